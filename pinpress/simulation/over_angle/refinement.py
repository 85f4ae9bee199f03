"""A period solved on as many panels as it takes: which panels of a solution are too coarse, and where they are cut.

The last terms of its polynomials tell whether the panels resolve the solution, and so does a load at a panel's borders, where it has to be
what its polynomial promises. Where the crank passes a corner of the drive's torque, or a contact is lost, a panel is cut at that place; any
other panel that is too coarse is cut in its middle.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.numerics import gauss_rule, horner, polynomial_root
from ...common.products import product
from ...common.quantities import Array
from ...drives.protocol import Drive, corners_of
from ...dynamics.panels import last_terms
from ..driven_press import DrivenPress
from . import collocation
from .collocation import FLOOR, LEAST, CollocationSolution
from .forces import along_travel, along_travel_at_ends
from .mesh import FROM_REST, SAME, STEADY, TO_REST, AngleMesh, Indices, PanelForce, build_mesh

LAYER = 10.0  # e-folds of half a panel that holds what dies away at its start under a stiff drive


class SolvedPeriod(NamedTuple):
    """A period, or a part of it, on panels that were cut."""

    solution: CollocationSolution  # on the last panels
    coarse: Array  # (k,) angles travelled at which these would have to be cut again; none where they resolve it


def solve_period(
    driven: DrivenPress,
    mesh: AngleMesh,
    energy: Array,
    places: Callable[[CollocationSolution], Array | None],
    guess: Array | None = None,
    *,
    nearby: CollocationSolution | None = None,
    periodic: bool = False,
    most: int = 40,
) -> SolvedPeriod | None:
    """Solve a period over a mesh, and cut the mesh where it is too coarse, until it is nowhere.

    Args:
        driven: what is simulated.
        mesh: to begin with.
        energy: (S,) kinetic energy at the start [J].
        places: tells where to cut the panels of a solution, see `cuts`; None: the solution leads nowhere.
        guess: see `collocation.solve`.
        nearby: see `collocation.solve`.
        periodic: see `collocation.solve`.
        most: rounds after which panels that are still too coarse stay so.

    Returns:
        The solution; None if it leads nowhere.
    """
    for _ in range(most):
        solution = collocation.solve(driven, mesh, energy, guess, nearby=nearby, periodic=periodic)
        coarse = places(solution)
        if coarse is None:
            return None
        if not len(coarse):
            break
        rests = mesh.kinds[0] == FROM_REST, mesh.kinds[-1] == TO_REST
        mesh = build_mesh(driven, mesh.start, mesh.direction, np.sort(np.concatenate([mesh.borders, coarse])), rests, mesh.periods)
        guess, nearby, energy = interpolate_onto(solution, mesh), None, solution.ends[0]
    assert coarse is not None
    return SolvedPeriod(solution, coarse)


def stopping_panels(solution: CollocationSolution) -> NDArray[np.bool_]:
    """On which panels (p, S) the crank stops, or comes so near to a stop that time may not be resolved. All that follows them has no
    meaning."""
    lowest = np.minimum(solution.energy.min(axis=0), solution.ends[1:])
    known = np.arange(len(solution.ends))[:, None] <= solution.settled
    least = 0.0 if solution.speed_free else LEAST * np.where(known, solution.ends, 0.0).max(axis=0)
    stopping = (lowest <= least) | (np.arange(len(lowest))[:, None] >= solution.settled)
    if solution.mesh.kinds[-1] == TO_REST:
        stopping[-1] = (solution.energy[:, -1] <= 0).any(axis=0)
    return np.asarray(stopping)


def unsettled_panels(solution: CollocationSolution, stopping: NDArray[np.bool_], which: NDArray[np.bool_]) -> Indices:
    """The first panels on which Newton's method has not settled for one of the scenarios ``which`` (S,), of those that stop on none before;
    ``stopping``: (p, S), of `stopping_panels`."""
    first = np.where(stopping.any(axis=0), stopping.argmax(axis=0), len(stopping))
    return np.unique(solution.settled[which & (solution.settled < len(stopping)) & (first == solution.settled)])


def passed_corners(solution: CollocationSolution, drive: Drive) -> NDArray[np.bool_]:
    """On which panels (p, S) the crank passes a corner of the drive's torque."""
    speeds = _speeds_with_borders(solution)
    lowest, highest = speeds.min(axis=0), speeds.max(axis=0)
    passed = np.zeros(lowest.shape, dtype=bool)
    for corner, _ in corners_of(drive):
        passed |= (lowest < corner) & (corner < highest)
    return passed


def cuts(
    solution: CollocationSolution, upto: int, tolerance: float, drive: Drive | None = None, which: Indices | slice = slice(None)
) -> Array:
    """Angles travelled at which to cut panels that do not resolve energy or time.

    A polynomial's last terms tell what it misses; the errors of Gauss's rule are far smaller. A corner of a law that lies between a panel's
    last node and its border shows at the border alone. Of a single scenario, panels are cut where the crank passes a corner of the drive's
    torque or a contact is lost; all others are cut in their middle.

    Args:
        solution: the solution.
        upto: panels from this index on are left as they are.
        tolerance: last terms accepted, as a share of the whole.
        drive: whose torque may have corners; None: it has none.
        which: scenarios that count.
    """
    mesh = solution.mesh
    corners = () if drive is None else corners_of(drive)
    # Smaller last terms may be rounding, which no cut reduces.
    least = max(tolerance, 5e-14)
    coarse = _coarse(solution, upto, least, which) | _bent_at_borders(solution, upto, least, drive if corners else None, which)
    bad = coarse & (np.diff(mesh.borders[: upto + 1]) > 1e-9)  # [rad]
    if solution.stiffness.any():  # under a stiff drive an unresolved panel disturbs those that follow it
        bad[1:] &= (solution.stiffness[1:upto] <= LAYER) | ~bad[:-1]
    places = {panel: _cut_within(solution, panel) for panel in np.flatnonzero(bad).tolist()}
    if solution.ends.shape[1] == 1:
        places |= _cuts_at_corners(solution, upto, [float(np.ravel(speed)[0]) for speed, _ in corners])
        for force in mesh.forces:
            places |= {panel: place for panel, place in _cuts_at_contacts(solution, force).items() if panel < upto}
    return np.array(list(places.values()))


def _coarse(solution: CollocationSolution, upto: int, tolerance: float, which: Indices | slice) -> NDArray[np.bool_]:
    """Whether the first panels (upto,) are too coarse for energy or time of any scenario."""
    highest, taken = solution.ends[: upto + 1, which].max(axis=0), solution.durations[:upto, which].sum(axis=0) / solution.mesh.periods

    def missed(integrand: Array, whole: Array) -> NDArray[np.bool_]:
        return np.asarray((last_terms(integrand[:, :upto, which]) > tolerance * whole).any(axis=1), dtype=np.bool_)

    return np.asarray(missed(solution.force * solution.mesh.measure[:, :, None], highest) | missed(solution.slowness, taken))


def _bent_at_borders(
    solution: CollocationSolution, upto: int, tolerance: float, drive: Drive | None, which: Indices | slice
) -> NDArray[np.bool_]:
    """On which of the first panels (upto,) a load that depends on the velocity, or the torque of a drive with corners, is not at a border
    what its values at the nodes promise.

    Where the law has a corner at a distance d from the border, and no node lies between, the force is wrong by a slope x d at the border,
    and its work by half of that x d.
    """
    mesh, rule, bent = solution.mesh, gauss_rule(), np.zeros(len(solution.mesh.kinds), dtype=bool)
    loads = [force for force in mesh.forces if force.interval.heeds_velocity]
    if mesh.kinds.any() or not (loads or drive is not None):
        return bent[:upto]
    to_ends = np.array([(-1.0) ** np.arange(len(rule.nodes)), np.ones(len(rule.nodes))]) @ rule.legendre
    last_gap = 0.5 * (1.0 - float(rule.nodes[-1])) * mesh.measure[0]  # half the angle between a last node and the border
    accepted = tolerance * solution.ends[: upto + 1, which].max(axis=0)
    speeds = _border_speeds(solution)

    def look(panels: Indices, at_nodes: Array, at_ends: Array) -> None:
        promised = product(to_ends, at_nodes.reshape(len(at_nodes), -1)).reshape(2, *at_nodes.shape[1:])
        missed = np.abs(promised - at_ends).max(axis=0) * last_gap[panels, None]
        bent[panels] |= (missed[:, which] > accepted).any(axis=1)

    for force in loads:
        along = along_travel(mesh, force, mesh.direction * solution.speed)
        look(force.panels, along, along_travel_at_ends(mesh, force, speeds))
    if drive is not None:
        torque = mesh.direction * drive.torque(speeds) + np.zeros_like(speeds)
        look(np.arange(len(mesh.kinds)), solution.driving, np.stack([torque[:-1], torque[1:]]))
    return bent[:upto]


def _cut_within(solution: CollocationSolution, panel: int) -> float:
    """Where a panel is cut: in the middle of its x; under a stiff drive behind the layer at its start, where that is not cut off yet."""
    mesh, stiffness = solution.mesh, solution.stiffness
    low, high = mesh.borders[panel : panel + 2]
    share = {STEADY: 0.5, FROM_REST: 0.25, TO_REST: 0.75}[int(mesh.kinds[panel])]
    if stiffness[panel] > 2 * LAYER and (panel == 0 or stiffness[panel - 1] > 2 * LAYER):
        share = LAYER / float(stiffness[panel])
    return float(low + share * (high - low))


def _border_speeds(solution: CollocationSolution) -> Array:
    """Speed of the crank (p + 1, S) at the borders."""
    mesh = solution.mesh
    inertia = np.maximum(mesh.inertia_ends[:, None] + solution.added, np.finfo(float).tiny)
    return np.asarray(mesh.direction * np.sqrt(2 * np.maximum(solution.ends, 0.0) / inertia))


def _speeds_with_borders(solution: CollocationSolution) -> Array:
    """Speeds of the crank (q + 2, p, S) at the start of every panel, at its nodes and at its end."""
    ends = _border_speeds(solution)
    return np.concatenate([ends[None, :-1], solution.mesh.direction * solution.speed, ends[None, 1:]])


def _cuts_at_corners(solution: CollocationSolution, upto: int, corners: Sequence[float]) -> dict[int, float]:
    """Angles travelled, by panels, at which the crank passes one of the corners, even where that shows at no node."""
    mesh, places = solution.mesh, {}
    if corners:
        speeds = _speeds_with_borders(solution)[:, :upto, 0]
        for corner in corners:
            for panel in np.flatnonzero((speeds.min(axis=0) < corner) & (speeds.max(axis=0) > corner)).tolist():
                place = _place_of(mesh, panel, gauss_rule().polynomial(speeds[1:-1, panel]).tolist(), corner)
                if place is not None:
                    places[panel] = place
    return places


def _cuts_at_contacts(solution: CollocationSolution, force: PanelForce) -> dict[int, float]:
    """Angles travelled, by panels, at which the law of a contact changes its sign, of one scenario."""
    mesh, places, border_speeds = solution.mesh, {}, _border_speeds(solution)[:, 0]
    for panel in force.panels.tolist() if force.interval.one_sided else []:
        ends = slice(panel, panel + 2)
        rates = [
            mesh.lever[force.row][:, panel] * mesh.direction * solution.speed[:, panel, 0],
            mesh.lever_ends[force.row, ends] * border_speeds[ends],
        ]
        position = np.concatenate([mesh.position[force.row][:, panel], mesh.position_ends[force.row, ends]])
        law = np.asarray(force.interval.force(position - force.datum, np.concatenate(rates)))
        if law.min() < 0 < law.max():
            place = _place_of(mesh, panel, gauss_rule().polynomial(law[:-2]).tolist(), 0.0)
            if place is not None:
                places[panel] = place
    return places


def _place_of(mesh: AngleMesh, panel: int, polynomial: list[float], level: float) -> float | None:
    """Angle travelled at which a polynomial in the x of a panel passes a level; None if it does not, or only at the panel's borders."""
    polynomial = [polynomial[0] - level, *polynomial[1:]]
    samples = np.linspace(-1.0, 1.0, 2 * len(polynomial)).tolist()
    values = [horner(polynomial[::-1], x) for x in samples]
    for k in range(len(samples) - 1):
        if (values[k] > 0) != (values[k + 1] > 0):
            x = polynomial_root(polynomial, samples[k], samples[k + 1])
            place = float(mesh.travelled(np.array([panel]), np.array([x]))[0][0])
            if mesh.borders[panel] + SAME < place < mesh.borders[panel + 1] - SAME:
                return place
    return None


def interpolate_onto(solution: CollocationSolution, mesh: AngleMesh) -> Array | None:
    """The kinetic energy (q, p, S) of a solution at the nodes of another mesh over the same angles, where it is not solved that at the
    start; None if one of the meshes starts or ends at rest."""
    old = solution.mesh
    if old.kinds.any() or mesh.kinds.any():
        return None
    along = (mesh.angle - mesh.start) * mesh.direction
    panel = np.clip(old.borders.searchsorted(along, side="right") - 1, 0, len(old.kinds) - 1)
    low, high = old.borders[panel], old.borders[panel + 1]
    x = (2 * (along - low) / (high - low) - 1)[:, :, None]
    q, p, count = solution.energy.shape
    coefficients = gauss_rule().polynomial(solution.energy.reshape(q, -1)).reshape(q, p, count)
    value = coefficients[-1][panel]
    for k in range(q - 2, -1, -1):
        value = value * x + coefficients[k][panel]
    value = np.where(panel[:, :, None] < solution.settled, value, solution.ends[0])
    return np.asarray(np.maximum(value, FLOOR * solution.ends[0]))
