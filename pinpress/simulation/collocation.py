"""The reduced equation over the crank angle, for a crank that turns under forces that depend on crank angle and speed alone.

Panels of a mesh end where a force is not smooth: at the heights where a load begins and ends, and at dead centres. Each has Gauss's nodes.
A panel that starts or ends at rest runs over the square root of the angle, in which time is smooth.

With the kinetic energy W = (I + J) w^2 / 2 the equation reads dW/du = G(u, w) and dt/du = 1 / |w|, where u is the angle travelled. A period
is solved at once for all scenarios: W is the integral of G over the panels (collocation), and G depends on W through the speed. Newton's
method needs few rounds. Each is an integral with an integrating factor, or under a stiff drive the solution of each panel's linear
equations. Where no force depends on the speed, one round is exact.

The last terms of its polynomials tell whether the panels resolve the solution. Where the crank passes a corner of the drive's torque, or a
contact is lost, a panel is cut at that place; any other panel that is too coarse is cut in its middle.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.numerics import gauss_rule, horner, polynomial_root
from ..common.quantities import Array
from ..drives.protocol import Drive
from ..drives.transmission import PrescribedSpeed
from ..loads.process import ForceInterval
from .driven_press import DrivenPress
from .failures import failure
from .reduced_model import COORDINATES, INERTIA, POTENTIAL, WEIGHT, BearingStates, ReducedModel

Indices = NDArray[np.intp]

SAME = 1e-8  # borders closer than this are one [rad]
STEADY, FROM_REST, TO_REST = 0, 1, -1  # kinds of panels: over the angle, or over its square root from a rest or to one

ROUNDS = 30  # most rounds of Newton's method
SETTLED = 1e-10  # relative change of the kinetic energy in a round that ends Newton's method, whose next change would be its square
FLOOR = 1e-6  # share of the first kinetic energy: no speed is computed from less
STIFF = 2.0  # where the energy changes the force by more over half a panel, the panel's own linear equations are solved
CLOSE = 1e-3  # relative change of the kinetic energy in a round from which on the slopes of the forces are kept
FURTHEST = 100.0  # largest factor by which a round may change the kinetic energy
BESIDE = 1e-7  # relative change of a speed by which the slopes of the forces are found
BEYOND = 10.0  # guesses of the energy are limited to this multiple of the largest energy that is known
NARROWEST = 1e-9  # narrowest panel that is cut [rad]
ROUNDED = 5e-14  # last terms of a polynomial up to this share of the whole may be rounding, which no cut reduces
LAYER = 10.0  # e-folds of half a panel that holds what dies away at its start under a stiff drive
LEAST = 1e-3  # share of the period's largest kinetic energy: with less, a drive that depends on speed may be about to stop the crank


# ------------------------------------------------------------------------------------------------------------------------------------- mesh


class PanelForce(NamedTuple):
    """An interval of a force, with the panels on which it acts.

    Attributes:
        row: of the coordinate along which it acts.
        datum: value of the coordinate from which heights count [m].
        interval: with its law.
        panels: indices of the panels on which it acts.
    """

    row: int
    datum: float
    interval: ForceInterval
    panels: Indices


@dataclass(frozen=True, eq=False, repr=False)
class Mesh:
    """p panels over the angle travelled from a start, with all that does not depend on speed, at q nodes of each and at p + 1 borders.

    Attributes:
        start: crank angle [rad].
        direction: +1 or -1.
        borders: (p + 1,) angle travelled [rad].
        kinds: (p,) `STEADY`, or over the square root of the angle `FROM_REST` or `TO_REST`.
        measure: (q, p) derivative of the angle travelled by x, which goes from -1 to 1 over a panel.
        angle: (q, p) crank angles [rad].
        inertia: (q, p) I [kg m2].
        slope: (q, p) I' [kg m2].
        weight: (q, p) -V' along the travel [N m].
        lifted: (q, p) potential energy gained since the start [J].
        lifted_ends: (p + 1,) potential energy gained up to the borders [J].
        inertia_ends: (p + 1,) I at the borders [kg m2].
        position: (coordinates, q, p) coordinates c [m].
        lever: (coordinates, q, p) c' [m].
        position_ends: (coordinates, p + 1) c at the borders [m].
        lever_ends: (coordinates, p + 1) c' at the borders [m].
        forces: intervals of forces, each with the panels on which it acts.
        bearings: the bearings with friction at the q p nodes, node by node; None for none.
    """

    start: float
    direction: int
    borders: Array
    kinds: Indices
    measure: Array
    angle: Array
    inertia: Array
    slope: Array
    weight: Array
    lifted: Array
    lifted_ends: Array
    inertia_ends: Array
    position: Array
    lever: Array
    position_ends: Array
    lever_ends: Array
    forces: tuple[PanelForce, ...]
    bearings: BearingStates | None

    def travelled(self, panel: Indices, x: Array) -> tuple[Array, Array]:
        """Angle travelled at places x (n,), from -1 to 1 on panels (n,), and its derivative by x."""
        return _run(self.borders, self.kinds, panel, x)


def mesh_borders(driven: DrivenPress, start: float, direction: int, extent: float) -> Array:
    """Borders of panels as angles travelled from crank angle ``start`` over an ``extent`` [rad]: those of the reduced model, and places at
    which a force is not smooth."""
    turns = np.arange(2 * np.pi, extent, 2 * np.pi)
    ends = np.sort(np.concatenate([turns, angle_to(driven.model, (driven.model.borders, *driven.switch_angles), start, direction)]))
    ends = ends[(ends > SAME) & (ends < extent - SAME)]
    return np.concatenate([[0.0], ends[np.diff(ends, prepend=0.0) > SAME], [extent]])


def angle_to(model: ReducedModel, places: Sequence[Array], start: float, direction: int) -> Array:
    """Angles to be travelled from crank angle ``start`` to each of the ``places``, which are crank angles in the model's range [rad]."""
    travelled = (np.concatenate([np.zeros(0), *places]) - start) * direction
    return travelled if model.period is None else travelled - np.floor(travelled / model.period) * model.period


def range_ahead(model: ReducedModel, start: float, direction: int) -> float:
    """Angle over which a model goes on from a crank angle: a period, or the rest of its range [rad]."""
    if model.period is not None:
        return model.period
    return float(model.borders[-1] - start if direction > 0 else start - model.borders[0])


def build_mesh(driven: DrivenPress, start: float, direction: int, borders: Array, rests: tuple[bool, bool] = (False, False)) -> Mesh:
    """The mesh with these borders.

    Args:
        driven: what is simulated.
        start: crank angle [rad].
        direction: +1 or -1.
        borders: (p + 1,) angle travelled [rad].
        rests: whether the crank starts from rest in the first panel, and comes to rest in the last.
    """
    kinds = _kinds(len(borders) - 1, *rests)
    along, measure = _run(borders, kinds, np.arange(len(kinds)), gauss_rule().nodes[:, None])
    middle = 0.5 * (borders[:-1] + borders[1:])
    angle, nodes = start + direction * along, along.size
    values, slopes = driven.model.at(
        start + direction * np.concatenate([along.ravel(), middle, borders])
    )  # all at once: half as many calls
    at_middle, slopes_middle = (rows[:, nodes : nodes + len(middle)] for rows in (values, slopes))
    at_ends, slopes_ends = (rows[:, nodes + len(middle) :] for rows in (values, slopes))
    at_nodes, slopes_nodes = (rows[:, :nodes].reshape(len(rows), *along.shape) for rows in (values, slopes))
    return Mesh(
        start=start,
        direction=direction,
        borders=borders,
        kinds=kinds,
        measure=measure,
        angle=angle,
        inertia=at_nodes[INERTIA],
        slope=slopes_nodes[INERTIA],
        weight=-direction * at_nodes[WEIGHT],
        lifted=at_nodes[POTENTIAL] - at_ends[POTENTIAL, 0],
        inertia_ends=at_ends[INERTIA],
        lifted_ends=at_ends[POTENTIAL] - at_ends[POTENTIAL, 0],
        position=at_nodes[COORDINATES:],
        lever=slopes_nodes[COORDINATES:],
        position_ends=at_ends[COORDINATES:],
        lever_ends=slopes_ends[COORDINATES:],
        forces=_panel_forces(driven, at_middle[COORDINATES:], slopes_middle[COORDINATES:] * direction > 0),
        bearings=None if driven.bearing_model is None else driven.bearing_model.at(angle.ravel()),
    )


def _kinds(count: int, from_rest: bool, to_rest: bool) -> Indices:
    kinds = np.full(count, STEADY)
    kinds[0] = FROM_REST if from_rest else STEADY
    kinds[-1] = TO_REST if to_rest else kinds[-1]
    return kinds


def _panel_forces(driven: DrivenPress, position: Array, rising: NDArray[np.bool_]) -> tuple[PanelForce, ...]:
    """The forces that act on each panel.

    Args:
        driven: what is simulated.
        position: (coordinates, p) coordinates in the middles of the panels.
        rising: (coordinates, p) whether they rise there.
    """
    found = []
    for force in driven.forces:
        height = position[force.row] - force.datum
        for up in (True, False):
            for interval in force.intervals(up):
                panels = np.flatnonzero((rising[force.row] == up) & (height > interval.lower) & (height <= interval.upper))
                if len(panels):
                    found.append(PanelForce(force.row, force.datum, interval, panels))
    return tuple(found)


def _run(borders: Array, kinds: Indices, panel: Indices, x: Array) -> tuple[Array, Array]:
    """See `Mesh.travelled`."""
    low, high = borders[panel], borders[panel + 1]
    half, share, kind = 0.5 * (high - low), 0.5 * (1 + x), kinds[panel]
    along, measure = low + 2 * half * share, half + 0.0 * x
    if kind.any():
        along = np.where(kind == FROM_REST, low + 2 * half * share**2, np.where(kind == TO_REST, high - 2 * half * (1 - share) ** 2, along))
        measure = np.where(kind == FROM_REST, 2 * half * share, np.where(kind == TO_REST, 2 * half * (1 - share), measure))
    return along, measure


# ----------------------------------------------------------------------------------------------------------------------------- solution


@dataclass(frozen=True, eq=False, repr=False)
class CollocationSolution:
    """A period, or a part of it, solved for S scenarios, at q nodes of p panels.

    Attributes:
        mesh: its panels.
        energy: (q, p, S) kinetic energy W at the nodes [J].
        ends: (p + 1, S) W at the borders [J].
        speed: (q, p, S) size of the crank's speed [rad/s]; it has no meaning where W is below the floor.
        force: (q, p, S) dW/du [N m].
        driving: (q, p, S) part of the force that comes from the drive [N m].
        resisting: (q, p, S) part of the force that comes from the loads [N m].
        friction_torque: (q, p, S) part of the force that comes from friction in the bearings [N m]; None for none.
        speed_free: whether no force depends on the speed, so that W is right beyond a stop too.
        stiffness: (p,) e-folds by which a disturbance of W dies away on half a panel; 0 where the drive is not stiff.
        exponent: (S,) e-folds by which a disturbance of a periodic W grows in a period; 0 of any other W.
        settled: (S,) number of panels on which Newton's method has found W: all, or those before the crank nearly stops.
        added: inertia of flywheel and drive, of the first scenario [kg m2].
        evaluations: number of nodes at which the forces were computed, each time counted.
    """

    mesh: Mesh
    energy: Array
    ends: Array
    speed: Array
    force: Array
    driving: Array
    resisting: Array
    friction_torque: Array | None
    speed_free: bool
    stiffness: Array
    exponent: Array
    settled: Indices
    added: float
    evaluations: int


def solve(driven: DrivenPress, mesh: Mesh, energy: Array, guess: Array | None = None, periodic: bool = False) -> CollocationSolution:
    """Find the kinetic energy over a mesh.

    Args:
        driven: what is simulated.
        mesh: its panels.
        energy: (S,) kinetic energy at the start of the mesh [J].
        guess: (q, p, S) kinetic energy from which Newton's method starts; None: ``energy`` everywhere.
        periodic: whether the motion has to end with the energy with which it begins; ``energy`` is then near it.

    Raises:
        SimulationError: the inertia is not positive everywhere.
    """
    inertia = _inertia(driven, mesh)
    if driven.prescribed is not None:
        return _prescribed(driven, mesh, inertia, driven.prescribed)
    work = np.broadcast_to(energy, (*mesh.angle.shape, len(energy))) if guess is None else guess
    return _Newton(driven, mesh, inertia, energy, work, periodic).solve(work)


def _inertia(driven: DrivenPress, mesh: Mesh) -> Array:
    """(q, p, S) inertia at the crank [kg m2]."""
    inertia: Array = mesh.inertia[:, :, None] + driven.inertia
    if not inertia.min() > 0:
        worst = np.unravel_index(int(inertia.min(axis=2).argmin()), mesh.angle.shape)
        raise failure("no inertia", None, float(mesh.angle[worst]), inertia=float(inertia.min()))
    return inertia


class _Newton:
    """Newton's method for the kinetic energy on all panels at once: dW/du = G + K (W_new - W)."""

    def __init__(self, driven: DrivenPress, mesh: Mesh, inertia: Array, energy: Array, work: Array, periodic: bool) -> None:
        """Begin with a guess of the kinetic energy.

        Args:
            driven: what is simulated.
            mesh: its panels.
            inertia: (q, p, S) at the crank [kg m2].
            energy: (S,) kinetic energy at the start [J].
            work: (q, p, S) the guess at the nodes [J].
            periodic: whether the motion has to end with the energy with which it begins.
        """
        self.mesh, self.inertia, self.energy, self.periodic = mesh, inertia, energy, periodic
        self.forces = Forces(driven.drive, mesh, inertia, work.shape)
        self.constant = driven.drive is None and not mesh.forces and mesh.bearings is None
        self.added = float(np.ravel(driven.inertia)[0])
        # from the guess alone, because W may rise without bounds far from the solution
        self.floor = FLOOR * work.max(axis=(0, 1)) + np.finfo(float).tiny
        self.stiffness, self.exponent = np.zeros(len(mesh.kinds)), np.zeros(len(energy))
        self.everywhere = np.full(len(energy), len(mesh.kinds))

    def solve(self, work: Array) -> CollocationSolution:
        rate, moved, ends, force = None, np.full((len(self.mesh.kinds), len(self.energy)), np.inf), None, None
        for _ in range(ROUNDS):
            above = np.maximum(work, self.floor)
            speed = np.sqrt(2 * above / self.inertia)
            total = self.forces.at(speed)
            if self.constant:
                return self._solution(work, True, self.everywhere)
            # K is found by a difference, because it only has to lead to the solution, and is kept close to it
            if rate is None or moved.max() > CLOSE:
                change = self.forces.faster(speed, BESIDE)
                # no force depends on the speed here; is it so at the speeds that follow from these forces too?
                if self.mesh.bearings is None and not change.any():
                    found = self._solution(work, True, self.everywhere)
                    if np.array_equal(self.forces.at(found.speed), total):
                        return self._seen_at_rest(found, total)
                    work, rate = np.maximum(found.energy, above / FURTHEST), None
                    continue
                rate = change / (2 * BESIDE * above)
                self.stiffness = self._stiffness(rate)
                self.exponent = _over_panels(self.mesh, rate).sum(axis=0) if self.periodic else self.exponent
            before = work
            work, ends, force = self._round(total, rate, before)
            if not np.isfinite(work.sum()):
                work = np.where(np.isfinite(work), work, above)
            work = np.minimum(np.maximum(work, above / FURTHEST), above * FURTHEST)
            last, moved = moved, np.abs(work - before).max(axis=0) / np.maximum(work.max(axis=0), self.energy)
            # a stiff drive's torque changes with the last digit of the speed
            if moved.max() <= SETTLED and not (self.stiffness.any() and moved.max() < 0.5 * last.max()):
                break
        # later panels do not act on earlier ones: the first panels may be right where the last ones are not
        unsettled = moved > SETTLED
        self.forces.at(np.sqrt(2 * np.maximum(work, self.floor) / self.inertia))
        settled = np.where(unsettled.any(axis=0), unsettled.argmax(axis=0), len(self.mesh.kinds))
        return self._solution(work, False, settled, ends, force) if self.stiffness.any() else self._solution(work, False, settled)

    def _stiffness(self, rate: Array) -> Array:
        stiffness = np.abs(rate * self.mesh.measure[:, :, None]).max(axis=(0, 2))
        return np.asarray(stiffness * (stiffness.max() > STIFF))

    def _round(self, total: Array, rate: Array, before: Array) -> tuple[Array, Array, Array | None]:
        """W at the nodes and borders after a round, and under a stiff drive the force that solves the equations."""
        total += self.mesh.weight[:, :, None]
        total -= rate * before
        with np.errstate(all="ignore"):  # far from the solution it may overshoot without bounds
            found = (_solved if self.stiffness.any() else _factored)(self.mesh, total, rate, self.energy, self.periodic)
        self.energy = found[1][0]
        return found

    def _seen_at_rest(self, found: CollocationSolution, total: Array) -> CollocationSolution:
        """A solution whose forces do not depend on its speeds. Where it has a stop, the forces at rest decide `speed_free`."""
        stopping = self.mesh.kinds.any() or not found.ends.min() > 0
        # a periodic motion is speed-free too: it does not come back, whatever its speed
        return replace(found, speed_free=bool(np.array_equal(self.forces.at(0.0 * found.speed), total))) if stopping else found

    def _solution(
        self, work: Array, speed_free: bool, settled: Indices, ends: Array | None = None, force: Array | None = None
    ) -> CollocationSolution:
        forces, weight = self.forces, self.mesh.weight[:, :, None]
        if ends is None or force is None:
            force = forces.total + weight
            work, ends = _integral(self.mesh, forces.total, weight, self.energy)
        else:  # the torque of a stiff drive follows from the solution: computed from the speed it would have the rounding of that
            others = forces.resisting if forces.friction_torque is None else forces.resisting + forces.friction_torque
            forces.driving = force - others - weight
        least = np.finfo(float).tiny if speed_free else self.floor  # before a stop W is small, and right
        return CollocationSolution(
            mesh=self.mesh,
            energy=work,
            ends=ends,
            speed=np.sqrt(2 * np.maximum(work, least) / self.inertia),
            force=force,
            driving=forces.driving,
            resisting=forces.resisting,
            friction_torque=forces.friction_torque,
            speed_free=speed_free,
            stiffness=self.stiffness,
            exponent=self.exponent,
            settled=settled,
            added=self.added,
            evaluations=forces.asked * work.size,
        )


def _prescribed(driven: DrivenPress, mesh: Mesh, inertia: Array, drive: PrescribedSpeed) -> CollocationSolution:
    """The solution at a constant speed, with the torque that this takes."""
    speed = np.full(inertia.shape, abs(drive.speed))
    work = 0.5 * inertia * speed**2
    resisting = np.zeros(inertia.shape)
    for force in mesh.forces:
        resisting[:, force.panels] += _along_travel(mesh, force, mesh.direction * speed)
    total = 0.5 * mesh.direction * mesh.slope[:, :, None] * speed**2
    friction_torque, driving = None, total - resisting - mesh.weight[:, :, None]
    if mesh.bearings is not None:
        friction_torque = _friction_torque(mesh, mesh.bearings, speed, np.zeros(speed.shape), np.full(speed.shape, np.inf))[0]
        driving -= friction_torque
    return CollocationSolution(
        mesh=mesh,
        energy=work,
        ends=np.full((len(mesh.borders), 1), work.max()),
        speed=speed,
        force=total,
        driving=driving,
        resisting=resisting,
        friction_torque=friction_torque,
        speed_free=True,
        stiffness=np.zeros(len(mesh.kinds)),
        exponent=np.zeros(1),
        settled=np.full(1, len(mesh.kinds)),
        added=float(driven.inertia),
        evaluations=work.size,
    )


# ------------------------------------------------------------------------------------------------------------------------------- forces


class Forces:
    """Forces of drive, loads and friction on a mesh, along the travel, at changing speeds. Loads that do not depend on speed are computed
    once.

    Attributes:
        driving: (q, p, S) of the drive, as last computed [N m].
        resisting: (q, p, S) of the loads, as last computed [N m].
        friction_torque: (q, p, S) of friction in the bearings, as last computed [N m]; None for none.
        asked: number of times that they were computed.
    """

    def __init__(self, drive: Drive | None, mesh: Mesh, inertia: Array, shape: tuple[int, ...]) -> None:
        self.drive, self.mesh, self.inertia, self.asked = drive, mesh, inertia, 0
        self.driving, self.resisting = np.zeros(shape), np.zeros(shape)
        self.friction_torque: Array | None = None
        self.efforts: Array | None = None  # of friction, from which the next ones are found
        self.steady = not mesh.forces

    @property
    def total(self) -> Array:
        """(q, p, S) sum of the forces, as last computed."""
        acting = self.driving + self.resisting
        return np.asarray(acting if self.friction_torque is None else acting + self.friction_torque)

    def at(self, speed: Array) -> Array:
        """Sum of the forces at sizes of the crank's speed (q, p, S)."""
        self.driving = self._driving(speed)
        if not self.steady:
            self.resisting = self._resisting(speed)
        if self.mesh.bearings is not None:
            self.friction_torque = self._friction(self.mesh.bearings, speed, self.driving + self.resisting)
        self.asked += 1
        return self.total

    def faster(self, speed: Array, share: float) -> Array:
        """Change of the sum where the crank is faster by a share than at the last `at`."""
        higher = speed * (1 + share)
        driving, resisting = self._driving(higher), self.resisting
        change = driving - self.driving
        if not self.steady:
            resisting = self._resisting(higher)
            self.steady = bool(np.array_equal(resisting, self.resisting))
            if not self.steady:
                change += resisting - self.resisting
        if self.mesh.bearings is not None and self.friction_torque is not None:
            change += self._friction(self.mesh.bearings, higher, driving + resisting) - self.friction_torque
        self.asked += 1
        return np.asarray(change)

    def _driving(self, speed: Array) -> Array:
        if self.drive is None:
            return np.zeros_like(self.driving)
        torque = np.asarray(self.drive.torque(self.mesh.direction * speed))
        signed = torque if self.mesh.direction > 0 else -torque
        return signed if signed.shape == speed.shape else signed + np.zeros_like(self.driving)

    def _resisting(self, speed: Array) -> Array:
        result = np.zeros_like(self.driving)
        for force in self.mesh.forces:
            result[:, force.panels] += _along_travel(self.mesh, force, self.mesh.direction * speed)
        return result

    def _friction(self, bearings: BearingStates, speed: Array, acting: Array) -> Array:
        """Torque of friction (q, p, S) under torques of drive and loads."""
        mesh = self.mesh
        net = acting + mesh.weight[:, :, None] - 0.5 * mesh.direction * mesh.slope[:, :, None] * speed**2
        friction_torque, self.efforts = _friction_torque(mesh, bearings, speed, net, self.inertia, self.efforts)
        return friction_torque


def _friction_torque(
    mesh: Mesh, bearings: BearingStates, speed: Array, net: Array, inertia: Array, start: Array | None = None
) -> tuple[Array, Array]:
    """Torque of friction (q, p, S) along the travel, and its efforts; arrays are those of `BearingStates.torque`, as (q, p, S)."""
    q, p, count = speed.shape
    along: dict[int, Array] = {}
    for force in mesh.forces:
        on_coordinate = along.setdefault(force.row, np.zeros(speed.shape))
        on_coordinate[:, force.panels] += _size(mesh, force, mesh.direction * speed)
    rate, acting, resisting = (values.reshape(q * p, -1) for values in (speed, net, inertia))
    forces = {row: force.reshape(q * p, count) for row, force in along.items()}
    torque, efforts = bearings.torque(mesh.direction, rate, acting, resisting, forces, start)
    return torque.reshape(speed.shape), efforts


def _along_travel(mesh: Mesh, force: PanelForce, speed: Array) -> Array:
    """A force along the travel (q, its panels, S) [N m], at the crank's speeds (q, p, S)."""
    return np.asarray(mesh.direction * mesh.lever[force.row][:, force.panels, None] * _size(mesh, force, speed))


def _size(mesh: Mesh, force: PanelForce, speed: Array) -> Array:
    """A force along its coordinate (q, its panels, S) [N], at the crank's speeds (q, p, S)."""
    position = mesh.position[force.row][:, force.panels, None] - force.datum
    lever = mesh.lever[force.row][:, force.panels, None]
    size = force.interval.force(position, lever * speed[:, force.panels])
    return np.asarray(np.maximum(size, 0.0) if force.interval.one_sided else size)


# ---------------------------------------------------------------------------------------------------------------- integrals over panels


def _integral(mesh: Mesh, force: Array, weight: Array, energy: Array) -> tuple[Array, Array]:
    """W at the nodes (q, p, S) and borders (p + 1, S) from the force (q, p, S) of drive and loads and that of weights (q, p, 1).

    While the crank turns, the work of weights is the difference of their potential energy and not the integral of their force, because it
    is then the same in every turn. Near a rest W is small and must be right relative to itself: there all is integrated, away from the
    rest.
    """
    rule = gauss_rule()
    q, p, count = force.shape
    rests = bool(mesh.kinds.any())
    inner = (force + weight if rests else force) * mesh.measure[:, :, None]
    flat = inner.reshape(q, p * count)
    totals = (rule.weights @ flat).reshape(p, count)
    ends = np.concatenate([energy[None], totals]).cumsum(axis=0)
    within = (rule.cumulative @ flat).reshape(q, p, count)
    work = ends[:-1] + within
    if not rests:
        work -= mesh.lifted[:, :, None]
        ends -= mesh.lifted_ends[:, None]
    elif mesh.kinds[-1] == TO_REST:
        back = np.concatenate([-totals[::-1].cumsum(axis=0)[::-1], np.zeros((1, count))])
        half = int(ends[:, 0].argmax())
        left = ((rule.weights - rule.cumulative) @ flat).reshape(q, p, count)
        work[:, half:], ends[half + 1 :] = (back[1:] - left)[:, half:], back[half + 1 :]
    return work, ends


def _factored(mesh: Mesh, constant: Array, rate: Array, energy: Array, periodic: bool) -> tuple[Array, Array, None]:
    """W (q, p, S) from dW/du = constant + rate W by an integrating factor, for all scenarios in few operations; its values (p + 1, S) at
    the borders; and no force. At the start W is ``energy``, or if ``periodic`` the same as at the end.

    On every panel W is a part of its own, plus a growth times its value at the panel's start.
    """
    rule = gauss_rule()
    q, p, count = constant.shape
    flat = (rate * mesh.measure[:, :, None]).reshape(q, p * count)
    growth, final = np.exp(rule.cumulative @ flat).reshape(q, p, count), np.exp(rule.weights @ flat).reshape(p, count)
    scaled = (constant * mesh.measure[:, :, None] / growth).reshape(q, p * count)
    ends = _panel_by_panel(final * (rule.weights @ scaled).reshape(p, count), final, energy, periodic)
    return np.asarray(growth * (ends[:-1] + (rule.cumulative @ scaled).reshape(q, p, count))), ends, None


def _solved(mesh: Mesh, constant: Array, rate: Array, energy: Array, periodic: bool) -> tuple[Array, Array, Array]:
    """W as `_factored` returns it, by the collocation equations of every panel, for drives so stiff that polynomials do not resolve an
    integrating factor; and the force dW/du (q, p, S) that solves them, because computed from W it would have the rounding of W.
    """
    rule, measure = gauss_rule(), mesh.measure.T[:, None]
    exponents = np.moveaxis(rate, 0, -1) * measure  # (p, S, q)
    right = np.stack([np.moveaxis(constant, 0, -1) * measure, exponents], axis=-1)
    try:
        parts = np.linalg.solve(np.eye(len(rule.nodes)) - exponents[..., None] * rule.cumulative, right)
    except np.linalg.LinAlgError:
        parts = np.full(right.shape, np.nan)
    own, growth = parts[..., 0], parts[..., 1]
    ends = _panel_by_panel(own @ rule.weights, 1 + growth @ rule.weights, energy, periodic)
    gained = own + growth * ends[:-1, :, None]
    work = ends[:-1, :, None] + gained @ rule.cumulative.T
    return np.moveaxis(work, -1, 0), ends, np.moveaxis(gained / measure, -1, 0)


def _panel_by_panel(gained: Array, final: Array, energy: Array, periodic: bool) -> Array:
    """W (p + 1, S) at the borders, from what panels (p, S) add to it, and the factor (p, S) by which they multiply its value at their
    start."""
    if periodic:
        energy = np.zeros(len(energy))
        for k in range(len(gained)):
            energy = final[k] * energy + gained[k]
        energy = energy / (1 - final.prod(axis=0))
    ends = np.empty((len(gained) + 1, len(energy)))
    ends[0] = energy
    for k in range(len(gained)):
        ends[k + 1] = final[k] * ends[k] + gained[k]
    return ends


def panel_integrals(solution: CollocationSolution, rate: Array) -> Array:
    """Integrals (p, S) of a rate (q, p, S) by the angle travelled, over each panel."""
    return _over_panels(solution.mesh, rate)


def _over_panels(mesh: Mesh, rate: Array) -> Array:
    q, p, count = rate.shape
    return np.asarray((gauss_rule().weights @ (rate * mesh.measure[:, :, None]).reshape(q, -1)).reshape(p, count))


# --------------------------------------------------------------------------------------------------------------------------- refinement


def stopping_panels(solution: CollocationSolution) -> NDArray[np.bool_]:
    """On which panels (p, S) the crank stops, or comes so near to a stop that time may not be resolved. All that follows them has no
    meaning."""
    lowest = np.minimum(solution.energy.min(axis=0), solution.ends[1:])
    known = np.arange(len(solution.ends))[:, None] <= solution.settled
    least = 0.0 if solution.speed_free else LEAST * np.where(known, solution.ends, 0.0).max(axis=0)
    found = (lowest <= least) | (np.arange(len(lowest))[:, None] >= solution.settled)
    if solution.mesh.kinds[-1] == TO_REST:
        found[-1] = (solution.energy[:, -1] <= 0).any(axis=0)
    return np.asarray(found)


def cuts(
    solution: CollocationSolution, upto: int, tolerance: float, corners: Sequence[float] = (), which: Indices | slice = slice(None)
) -> Array:
    """Angles travelled at which to cut panels that do not resolve energy or time.

    A polynomial's last terms tell what it misses; the errors of Gauss's rule are far smaller. Of a single scenario, panels are cut where
    the crank passes a corner or a contact is lost; all others are cut in their middle.

    Args:
        solution: the solution.
        upto: panels from this index on are left as they are.
        tolerance: last terms accepted, as a share of the whole.
        corners: speeds at which the drive's torque is not smooth [rad/s].
        which: scenarios that count.
    """
    mesh = solution.mesh
    bad = _coarse(solution, upto, max(tolerance, ROUNDED), which) & (np.diff(mesh.borders[: upto + 1]) > NARROWEST)
    if solution.stiffness.any():  # under a stiff drive an unresolved panel disturbs those that follow it
        bad[1:] &= (solution.stiffness[1:upto] <= LAYER) | ~bad[:-1]
    found = {panel: _cut_within(solution, panel) for panel in np.flatnonzero(bad).tolist()}
    if solution.ends[:, which].shape[1] == 1:
        found |= _corners_passed(solution, upto, corners)
        for force in mesh.forces:
            found |= {panel: at for panel, at in _contact_lost(solution, force) if panel < upto}
    return np.array(list(found.values()))


def _coarse(solution: CollocationSolution, upto: int, tolerance: float, which: Indices | slice) -> NDArray[np.bool_]:
    """Whether the first panels (upto,) are too coarse for energy or time of any scenario."""
    rule, measure = gauss_rule(), solution.mesh.measure[:, :upto, None]
    force, speed, ends = solution.force[:, :upto, which], solution.speed[:, :upto, which], solution.ends[: upto + 1, which]
    q, _, count = force.shape

    def missed(integrand: Array, whole: Array) -> NDArray[np.bool_]:
        tail = np.abs(rule.legendre[-2:] @ (integrand * measure).reshape(q, -1)).max(axis=0).reshape(upto, count)
        return np.asarray((tail > tolerance * whole).any(axis=1), dtype=np.bool_)

    slowness = 1 / speed
    taken = (rule.weights @ (slowness * measure).reshape(q, -1)).reshape(upto, count).sum(axis=0)
    return np.asarray(missed(force, ends.max(axis=0)) | missed(slowness, taken))


def _cut_within(solution: CollocationSolution, panel: int) -> float:
    """Where a panel is cut: in the middle of its x; under a stiff drive behind the layer at its start, where that is not cut off yet."""
    mesh, stiffness = solution.mesh, solution.stiffness
    low, high = mesh.borders[panel : panel + 2]
    share = {STEADY: 0.5, FROM_REST: 0.25, TO_REST: 0.75}[int(mesh.kinds[panel])]
    if stiffness[panel] > 2 * LAYER and (panel == 0 or stiffness[panel - 1] > 2 * LAYER):
        share = LAYER / float(stiffness[panel])
    return float(low + share * (high - low))


def _border_speeds(solution: CollocationSolution) -> Array:
    """Speed of the crank (p + 1,) at the borders, of one scenario."""
    mesh = solution.mesh
    inertia = np.maximum(mesh.inertia_ends + solution.added, np.finfo(float).tiny)
    return np.asarray(mesh.direction * np.sqrt(2 * np.maximum(solution.ends[:, 0], 0.0) / inertia))


def _corners_passed(solution: CollocationSolution, upto: int, corners: Sequence[float]) -> dict[int, float]:
    """Panels on which the crank passes one of the corners, and the place, even where that shows at no node."""
    mesh, found = solution.mesh, {}
    if corners:
        ends = _border_speeds(solution)
        speeds = np.concatenate([ends[None, :-1], mesh.direction * solution.speed[:, :, 0], ends[None, 1:]])[:, :upto]
        for corner in corners:
            for panel in np.flatnonzero((speeds.min(axis=0) < corner) & (speeds.max(axis=0) > corner)).tolist():
                at = _place_of(mesh, panel, gauss_rule().polynomial(speeds[1:-1, panel]).tolist(), corner)
                if at is not None:
                    found[panel] = at
    return found


def _contact_lost(solution: CollocationSolution, force: PanelForce) -> list[tuple[int, float]]:
    """Panels on which the law of a contact changes its sign, and the place as angle travelled, of one scenario."""
    mesh, found, border_speeds = solution.mesh, [], _border_speeds(solution)
    for panel in force.panels.tolist() if force.interval.one_sided else []:
        ends = slice(panel, panel + 2)
        rates = [
            mesh.lever[force.row][:, panel] * mesh.direction * solution.speed[:, panel, 0],
            mesh.lever_ends[force.row, ends] * border_speeds[ends],
        ]
        position = np.concatenate([mesh.position[force.row][:, panel], mesh.position_ends[force.row, ends]])
        law = np.asarray(force.interval.force(position - force.datum, np.concatenate(rates)))
        if law.min() < 0 < law.max():
            at = _place_of(mesh, panel, gauss_rule().polynomial(law[:-2]).tolist(), 0.0)
            if at is not None:
                found.append((panel, at))
    return found


def _place_of(mesh: Mesh, panel: int, polynomial: list[float], level: float) -> float | None:
    """Angle travelled at which a polynomial in the x of a panel passes a level; None where it does not, or only at the panel's borders."""
    polynomial = [polynomial[0] - level, *polynomial[1:]]
    samples = np.linspace(-1.0, 1.0, 2 * len(polynomial)).tolist()
    values = [horner(polynomial[::-1], x) for x in samples]
    for k in range(len(samples) - 1):
        if (values[k] > 0) != (values[k + 1] > 0):
            x = polynomial_root(polynomial, samples[k], samples[k + 1])
            at = float(mesh.travelled(np.array([panel]), np.array([x]))[0][0])
            if mesh.borders[panel] + SAME < at < mesh.borders[panel + 1] - SAME:
                return at
    return None


def interpolate_onto(solution: CollocationSolution, mesh: Mesh) -> Array | None:
    """The kinetic energy (q, p, S) of a solution at the nodes of another mesh over the same angles; None where one of the meshes starts or
    ends at rest."""
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
    # the energy has no meaning on panels on which Newton's method has not settled, and must not enter the largest energy
    known = np.arange(len(old.kinds))[:, None] < solution.settled
    highest = np.maximum(np.where(known, solution.energy.max(axis=0), 0.0).max(axis=0), solution.ends[0])
    return np.asarray(np.clip(value, FLOOR * solution.ends[0], BEYOND * highest))
