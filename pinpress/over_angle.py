"""The reduced equation over the crank angle: for a crank that turns, under forces that know time only through its speed.

With the kinetic energy W = (I + J) w^2 / 2 the equation reads dW/du = G(u, w) and dt/du = 1 / |w|, u the angle travelled. A period is
solved
at once, for all scenarios: W is the integral of G over panels of Gauss nodes (collocation), G depends on W through the speed, and Newton's
method needs three or four rounds, each an integral with an integrating factor. Where no force depends on the speed one round is exact, and
the crank may stop and swing back: towards a stop the panel runs over the square root of the angle left, in which time is smooth.

Panels end where a force is not smooth: at the heights where a load begins and ends, at dead centres, and, found as one goes, where the
drive's torque has a corner. A panel that does not resolve energy or time is halved.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .coordinates import Array
from .drives import Drive, PrescribedSpeed
from .loads import Stretch
from .reduced import COORDINATES, INERTIA, POTENTIAL, WEIGHT, Table, horner, root, rule
from .scene import Scene, not_positive

Indices = NDArray[np.intp]

ROUNDS = 30
SETTLED = 1e-10  # change of the kinetic energy in a round, beside the energy; Newton's method squares it, and its error is 1e-17
SAME = 1e-8  # borders closer than this are one [rad]
NARROWEST = 1e-9  # panel [rad]
LEAST = 1e-3  # kinetic energy, beside the period's largest, below which a drive that depends on speed may be about to stop the crank
FLOOR = 1e-6  # kinetic energy, beside the first, below which no speed is taken from it
STEADY, FROM_REST, TO_REST = 0, 1, -1  # how a panel runs
STIFF = 2.0  # change of the force by the kinetic energy over half a panel, above which the panel's equations are solved as they are
CLOSE = 1e-3  # change of the kinetic energy in a round, beside the energy, from which the slopes of the forces are kept
FURTHEST = 100.0  # times the kinetic energy before, that a round may go


class Push(NamedTuple):
    """A stretch of a force, on some of the panels."""

    row: int
    datum: float
    stretch: Stretch
    panels: Indices


@dataclass(frozen=True, eq=False, repr=False)
class Grid:
    """Panels over the angle travelled from a start, with what does not depend on speed at their nodes (q, p).

    Attributes:
        start: crank angle [rad]. direction: +1 or -1.
        borders: (p + 1,) angle travelled [rad]. kinds: (p,) `STEADY`, or `FROM_REST` or `TO_REST`: over the square root of the angle.
        measure: (q, p) derivative of the angle travelled by the panel's own x, from -1 to 1.
        angle: (q, p) crank angles. inertia, slope: I and I' [kg m2]. weight: -V' along the travel [N m].
        lifted: (q, p), lifted_ends: (p + 1,) potential energy since the start, at the nodes and borders [J].
        inertia_ends: (p + 1,) I at the borders. position_ends, lever_ends: (coordinates, p + 1) there.
        position, lever: (coordinates, q, p) coordinates c [m] and c' [m].
        pushes: the forces that act.
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
    pushes: tuple[Push, ...]


def on_the_way(table: Table, edges: Sequence[Array], start: float, direction: int) -> Array:
    """Angle to be travelled from crank angle ``start`` to each of the ``edges``, crank angles in the table's range."""
    travelled = (np.concatenate([np.zeros(0), *edges]) - start) * direction
    return travelled if table.period is None else travelled - np.floor(travelled / table.period) * table.period


def extent(table: Table, start: float, direction: int) -> float:
    """Angle over which a table goes on from a crank angle: a period, or what is left to its end [rad]."""
    if table.period is not None:
        return table.period
    return float(table.borders[-1] - start if direction > 0 else start - table.borders[0])


def borders(table: Table, edges: Sequence[Array], start: float, direction: int, extent: float) -> Array:
    """Borders of panels, angle travelled from crank angle ``start`` over ``extent`` [rad].

    Args:
        edges: crank angles in the table's range at which something is not smooth.
    """
    turns = np.arange(2 * np.pi, extent, 2 * np.pi)
    ends = np.sort(np.concatenate([turns, on_the_way(table, (table.borders, *edges), start, direction)]))
    ends = ends[(ends > SAME) & (ends < extent - SAME)]
    return np.concatenate([[0.0], ends[np.diff(ends, prepend=0.0) > SAME], [extent]])


def grid(scene: Scene, table: Table, start: float, direction: int, ends: Array, rests: tuple[bool, bool] = (False, False)) -> Grid:
    """The grid with these borders; ``rests``: whether the crank starts from rest in the first panel, and comes to rest in the last."""
    r = rule()
    kinds = np.zeros(len(ends) - 1, dtype=int)
    kinds[0] = FROM_REST if rests[0] else STEADY
    kinds[-1] = TO_REST if rests[1] else kinds[-1]
    along, measure = _run(ends, kinds, np.arange(len(kinds)), r.nodes[:, None])
    middle = 0.5 * (ends[:-1] + ends[1:])
    angle = start + direction * along
    values, slopes = table.at(start + direction * np.concatenate([along.ravel(), middle, ends]))  # all at once: half as many calls
    rows, count = len(values), along.size
    at_middle, at_ends = values[:, count : count + len(middle)], values[:, count + len(middle) :]
    values, by = values[:, :count].reshape(rows, *along.shape), slopes[:, count : count + len(middle)]
    slopes_ends = slopes[:, count + len(middle) :]
    slopes = slopes[:, :count].reshape(rows, *along.shape)
    pushes = []
    for force in scene.forces:
        height, rising = at_middle[COORDINATES + force.row] - force.datum, by[COORDINATES + force.row] * direction > 0
        for up in (True, False):
            for stretch in force.stretches(up):
                panels = np.flatnonzero((rising == up) & (height > stretch.lower) & (height <= stretch.upper))
                if len(panels):
                    pushes.append(Push(force.row, force.datum, stretch, panels))
    return Grid(
        start=start,
        direction=direction,
        borders=ends,
        kinds=kinds,
        measure=measure,
        angle=angle,
        inertia=values[INERTIA],
        slope=slopes[INERTIA],
        weight=-direction * values[WEIGHT],
        lifted=values[POTENTIAL] - at_ends[POTENTIAL, 0],
        inertia_ends=at_ends[INERTIA],
        lifted_ends=at_ends[POTENTIAL] - at_ends[POTENTIAL, 0],
        position=values[COORDINATES:],
        lever=slopes[COORDINATES:],
        position_ends=at_ends[COORDINATES:],
        lever_ends=slopes_ends[COORDINATES:],
        pushes=tuple(pushes),
    )


def travelled(grid: Grid, panel: Indices, x: Array) -> tuple[Array, Array]:
    """Angle travelled at places x (n,), from -1 to 1, of panels (n,), and its derivative by x."""
    return _run(grid.borders, grid.kinds, panel, x)


def _run(ends: Array, kinds: Indices, panel: Indices, x: Array) -> tuple[Array, Array]:
    low, high = ends[panel], ends[panel + 1]
    half, share, kind = 0.5 * (high - low), 0.5 * (1 + x), kinds[panel]
    along, measure = low + 2 * half * share, half + 0.0 * x
    if kind.any():
        along = np.where(kind == FROM_REST, low + 2 * half * share**2, np.where(kind == TO_REST, high - 2 * half * (1 - share) ** 2, along))
        measure = np.where(kind == FROM_REST, 2 * half * share, np.where(kind == TO_REST, 2 * half * (1 - share), measure))
    return along, measure


def _pushed(grid: Grid, push: Push, speed: Array) -> Array:
    """Force of a push along the travel (q, its panels, S) [N m], at the crank's speeds (q, p, S)."""
    position = grid.position[push.row][:, push.panels, None] - push.datum
    lever = grid.lever[push.row][:, push.panels, None]
    force = push.stretch.force(position, lever * speed[:, push.panels])
    if push.stretch.one_sided:
        force = np.maximum(force, 0.0)
    return np.asarray(grid.direction * lever * force)


@dataclass(frozen=True, eq=False, repr=False)
class Flow:
    """A period, or a part of it, solved for S scenarios.

    Attributes:
        grid: its panels.
        energy: (q, p, S) kinetic energy W at the nodes, ends: (p + 1, S) at the borders [J].
        speed: (q, p, S) size of the crank's speed [rad/s], of no meaning where W is below the floor.
        force: (q, p, S) dW/du; driving, resisting: parts of it, of the drive and of the loads [N m].
        held: whether no force depends on the speed, so that W is right beyond a stop too.
        settled: (S,) panels on which Newton's method has found W: all, or those before the crank all but stops.
        added: inertia of flywheel and drive, of the first scenario [kg m2]. evaluations: of the forces, nodes counted.
    """

    grid: Grid
    energy: Array
    ends: Array
    speed: Array
    force: Array
    driving: Array
    resisting: Array
    held: bool
    settled: Indices
    added: float
    evaluations: int


def flow(scene: Scene, grid: Grid, energy: Array, guess: Array | None = None, periodic: bool = False) -> Flow:
    """Kinetic energy over a grid, from ``energy`` (S,) at its start; or that of a ``periodic`` motion, near this energy, which ends with
    the energy with which it began.

    Raises:
        SimulationError: the inertia is not positive somewhere.
    """
    q, p = grid.angle.shape
    shape = (q, p, len(energy))
    inertia = grid.inertia[:, :, None] + scene.inertia
    if not inertia.min() > 0:
        worst = np.unravel_index(int(inertia.min(axis=2).argmin()), (q, p))
        raise not_positive(float(inertia.min()), None, float(grid.angle[worst]))
    drive, added = scene.drive, float(np.ravel(scene.inertia)[0])
    if isinstance(drive, PrescribedSpeed):
        return _prescribed(scene, grid, inertia, drive)
    forces = Forces(drive, grid, shape)

    def result(work: Array, held: bool, settled: Indices) -> Flow:
        force = forces.driving + forces.resisting + grid.weight[:, :, None]
        work, ends = _integral(grid, forces.driving + forces.resisting, grid.weight[:, :, None], energy)
        least = np.finfo(float).tiny if held else floor  # before a stop W is small, and right
        speed = np.sqrt(2 * np.maximum(work, least) / inertia)
        count = forces.asked * work.size
        return Flow(grid, work, ends, speed, force, forces.driving, forces.resisting, held, settled, added, count)

    every = np.full(len(energy), p)
    work = np.broadcast_to(energy, shape) if guess is None else guess
    # fixed, as far from the solution W may rise without bounds
    floor = FLOOR * work.max(axis=(0, 1)) + np.finfo(float).tiny
    rate, moved = None, np.full((p, len(energy)), np.inf)
    for _ in range(ROUNDS):
        above = np.maximum(work, floor)
        speed = np.sqrt(2 * above / inertia)
        total = forces.at(speed)
        if drive is None and not grid.pushes:
            return result(work, True, every)
        # Newton: dW/du = G + K (W_new - W); K by a difference, as it only has to lead there, and not anew close to the end
        if rate is None or moved.max() > CLOSE:
            change = forces.faster(speed, 1e-7)
            if not change.any():  # here; but also at the speeds that come of these forces?
                found = result(work, True, every)
                if np.array_equal(forces.at(found.speed), total):
                    return found  # of a periodic motion too: it does not come back, whatever its speed
                work, rate = np.maximum(found.energy, above / FURTHEST), None
                continue
            rate = change / (2e-7 * above)
        before = work
        total += grid.weight[:, :, None]
        total -= rate * before
        with np.errstate(all="ignore"):  # far from the solution it may overshoot without bounds
            work, energy = _factored(grid, total, rate, energy, periodic)
        if not np.isfinite(work.sum()):
            work = np.where(np.isfinite(work), work, above)
        work = np.minimum(np.maximum(work, above / FURTHEST), above * FURTHEST)
        moved = np.abs(work - before).max(axis=0) / np.maximum(work.max(axis=0), energy)
        if moved.max() <= SETTLED:
            break
    # what comes later does not matter to what comes before: the first panels may be right where the last ones are not
    unsettled = moved > SETTLED
    forces.at(np.sqrt(2 * np.maximum(work, floor) / inertia))
    return result(work, False, np.where(unsettled.any(axis=0), unsettled.argmax(axis=0), p))


class Forces:
    """Forces of drive and loads on a grid, along the travel, at changing speeds. Those of loads that know no speed are worked out once.

    Attributes:
        driving, resisting: (q, p, S) as last worked out [N m]. asked: how often.
    """

    def __init__(self, drive: Drive | None, grid: Grid, shape: tuple[int, ...]) -> None:
        self.drive, self.grid, self.asked = drive, grid, 0
        self.driving, self.resisting = np.zeros(shape), np.zeros(shape)
        self.steady = not grid.pushes

    def at(self, speed: Array) -> Array:
        """Sum of the forces at sizes of the crank's speed (q, p, S)."""
        self.driving = self._driving(speed)
        if not self.steady:
            self.resisting = self._resisting(speed)
        self.asked += 1
        return np.asarray(self.driving + self.resisting)

    def faster(self, speed: Array, share: float) -> Array:
        """Change of the sum where the crank is faster by a share than when it was last worked out."""
        higher = speed * (1 + share)
        change = self._driving(higher) - self.driving
        if not self.steady:
            resisting = self._resisting(higher)
            self.steady = bool(np.array_equal(resisting, self.resisting))
            if not self.steady:
                change += resisting - self.resisting
        self.asked += 1
        return np.asarray(change)

    def _driving(self, speed: Array) -> Array:
        if self.drive is None:
            return np.zeros_like(self.driving)
        torque = np.asarray(self.drive.torque(self.grid.direction * speed))
        signed = torque if self.grid.direction > 0 else -torque
        return signed if signed.shape == speed.shape else signed + np.zeros_like(self.driving)

    def _resisting(self, speed: Array) -> Array:
        result = np.zeros_like(self.driving)
        for push in self.grid.pushes:
            result[:, push.panels] += _pushed(self.grid, push, self.grid.direction * speed)
        return result


def _prescribed(scene: Scene, grid: Grid, inertia: Array, drive: PrescribedSpeed) -> Flow:
    """The flow at a constant speed, with the torque that this takes."""
    speed = np.full(inertia.shape, abs(drive.speed))
    work = 0.5 * inertia * speed**2
    resisting = np.zeros(inertia.shape)
    for push in grid.pushes:
        resisting[:, push.panels] += _pushed(grid, push, grid.direction * speed)
    force = 0.5 * grid.direction * grid.slope[:, :, None] * speed**2
    driving = force - resisting - grid.weight[:, :, None]
    ends = np.full((len(grid.borders), 1), work.max())
    return Flow(grid, work, ends, speed, force, driving, resisting, True, np.full(1, len(grid.kinds)), float(scene.inertia), work.size)


def _integral(grid: Grid, force: Array, weight: Array, energy: Array) -> tuple[Array, Array]:
    """W at the nodes (q, p, S) and borders (p + 1, S) from the force (q, p, S) of drive and loads and that of weights (q, p, 1).

    Of a crank that turns, weights put in the difference of their potential energy, not the integral of their force: it is the same in every
    turn. From rest and to rest W must be right beside itself where it is small: there all is integrated, away from the rest.
    """
    r = rule()
    q, p, count = force.shape
    rests = bool(grid.kinds.any())
    inner = (force + weight if rests else force) * grid.measure[:, :, None]
    flat = inner.reshape(q, p * count)
    totals = (r.weights @ flat).reshape(p, count)
    ends = np.concatenate([energy[None], totals]).cumsum(axis=0)
    within = (r.cumulative @ flat).reshape(q, p, count)
    work = ends[:-1] + within
    if not rests:
        work -= grid.lifted[:, :, None]
        ends -= grid.lifted_ends[:, None]
    elif grid.kinds[-1] == TO_REST:
        back = np.concatenate([-totals[::-1].cumsum(axis=0)[::-1], np.zeros((1, count))])
        half = int(ends[:, 0].argmax())
        left = ((r.weights - r.cumulative) @ flat).reshape(q, p, count)
        work[:, half:], ends[half + 1 :] = (back[1:] - left)[:, half:], back[half + 1 :]
    return work, ends


def _factored(grid: Grid, constant: Array, rate: Array, energy: Array, periodic: bool) -> tuple[Array, Array]:
    """W (q, p, S) from dW/du = constant + rate W, and its value (S,) at the start: ``energy``, or where it is ``periodic`` that at the end.

    On every panel W is a part of its own, plus a growth times its value at the start.
    """
    _, p, count = constant.shape
    exponents = rate * grid.measure[:, :, None]
    own, growth, gained, final = (_by_solving if np.abs(exponents).max() > STIFF else _by_factor)(
        constant * grid.measure[:, :, None], exponents
    )
    starts = np.empty((p, count))
    if periodic:
        energy = np.zeros(count)
        for k in range(p):
            energy = final[k] * energy + gained[k]
        energy = energy / (1 - final.prod(axis=0))
    start = energy
    for k in range(p):
        starts[k] = start
        start = final[k] * start + gained[k]
    return np.asarray(growth * starts + own), energy


def _by_factor(constant: Array, exponents: Array) -> tuple[Array, Array, Array, Array]:
    """Own part and growth (q, p, S), the same at the panels' ends (p, S), by an integrating factor: for all scenarios in few operations."""
    r = rule()
    q, p, count = constant.shape
    flat = exponents.reshape(q, p * count)
    growth, final = np.exp(r.cumulative @ flat).reshape(q, p, count), np.exp(r.weights @ flat).reshape(p, count)
    scaled = (constant / growth).reshape(q, p * count)
    return growth * (r.cumulative @ scaled).reshape(q, p, count), growth, final * (r.weights @ scaled).reshape(p, count), final


def _by_solving(constant: Array, exponents: Array) -> tuple[Array, Array, Array, Array]:
    """The same by solving the collocation equations of every panel: for drives so stiff that an integrating factor is no polynomial."""
    r = rule()
    rates, constants = np.moveaxis(exponents, 0, -1), np.moveaxis(constant, 0, -1)  # (p, S, q)
    matrix = np.eye(len(r.nodes)) - r.cumulative * rates[:, :, None, :]
    right = np.stack([constants @ r.cumulative.T, np.ones_like(constants)], axis=-1)
    try:
        parts = np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
    except np.linalg.LinAlgError:
        parts = np.full(right.shape, np.nan)
    own, growth = parts[..., 0], parts[..., 1]
    gained, final = (constants + rates * own) @ r.weights, 1 + (rates * growth) @ r.weights
    return np.moveaxis(own, -1, 0), np.moveaxis(growth, -1, 0), np.asarray(gained), np.asarray(final)


def carried(flow: Flow, grid: Grid) -> Array | None:
    """The kinetic energy (q, p, S) of a flow at the nodes of another grid over the same angles; None where one of them starts from rest."""
    old = flow.grid
    if old.kinds.any() or grid.kinds.any():
        return None
    along = (grid.angle - grid.start) * grid.direction
    panel = np.clip(old.borders.searchsorted(along, side="right") - 1, 0, len(old.kinds) - 1)
    low, high = old.borders[panel], old.borders[panel + 1]
    x = (2 * (along - low) / (high - low) - 1)[:, :, None]
    q, p, count = flow.energy.shape
    coefficients = (rule().monomials @ flow.energy.reshape(q, -1)).reshape(q, p, count)
    value = coefficients[-1][panel]
    for k in range(q - 2, -1, -1):
        value = value * x + coefficients[k][panel]
    return np.asarray(np.maximum(value, FLOOR * flow.ends[0]))


def stopping(flow: Flow) -> NDArray[np.bool_]:
    """Panels (p, S) on which the crank stops, or comes so near to it that time may not be resolved; what follows them is of no meaning."""
    lowest = np.minimum(flow.energy.min(axis=0), flow.ends[1:])
    known = np.arange(len(flow.ends))[:, None] <= flow.settled
    least = 0.0 if flow.held else LEAST * np.where(known, flow.ends, 0.0).max(axis=0)
    found = (lowest <= least) | (np.arange(len(lowest))[:, None] >= flow.settled)
    if flow.grid.kinds[-1] == TO_REST:
        found[-1] = (flow.energy[:, -1] <= 0).any(axis=0)
    return np.asarray(found)


def unresolved(flow: Flow, upto: int, tolerance: float, corners: Sequence[float] = (), which: Indices | slice = slice(None)) -> Array:
    """Where to cut those of the panels before ``upto`` that do not resolve energy or time, as angles travelled.

    A polynomial's last terms tell what it misses; Gauss's rule makes far smaller errors than that. A panel on which the crank passes one of
    the ``corners``, speeds at which a drive's torque is not smooth, is cut there (of one scenario); any other in its middle. ``which`` of
    the scenarios count.
    """
    r, g = rule(), flow.grid
    force, speed, ends = flow.force[:, :upto, which], flow.speed[:, :upto, which], flow.ends[: upto + 1, which]
    q, _, count = force.shape
    last, measure = r.legendre[-2:], g.measure[:, :upto, None]

    def coarse(integrand: Array, whole: Array) -> NDArray[np.bool_]:
        tail = np.abs(last @ (integrand * measure).reshape(q, -1)).max(axis=0).reshape(upto, count)
        return np.asarray((tail > tolerance * whole).any(axis=1), dtype=np.bool_)

    slowness = 1 / speed
    taken = (r.weights @ (slowness * measure).reshape(q, -1)).reshape(upto, count).sum(axis=0)
    bad = coarse(force, ends.max(axis=0)) | coarse(slowness, taken)
    bad &= np.diff(g.borders[: upto + 1]) > NARROWEST
    cuts = {panel: _middle(g, panel) for panel in np.flatnonzero(bad).tolist()}
    if count == 1:
        cuts |= _corners_passed(flow, upto, corners)
        for push in g.pushes:
            cuts |= {panel: at for panel, at in _contact_lost(flow, push) if panel < upto}
    return np.array(list(cuts.values()))


def _middle(grid: Grid, panel: int) -> float:
    """The middle of a panel, as it runs."""
    low, high = grid.borders[panel : panel + 2]
    share = {STEADY: 0.5, FROM_REST: 0.25, TO_REST: 0.75}[int(grid.kinds[panel])]
    return float(low + share * (high - low))


def _turning(flow: Flow) -> Array:
    """Speed of the crank (p + 1,) at the borders, of one scenario."""
    g = flow.grid
    inertia = np.maximum(g.inertia_ends + flow.added, np.finfo(float).tiny)
    return np.asarray(g.direction * np.sqrt(2 * np.maximum(flow.ends[:, 0], 0.0) / inertia))


def _corners_passed(flow: Flow, upto: int, corners: Sequence[float]) -> dict[int, float]:
    """Panels on which the crank passes one of these speeds, and where: also where no node sees it."""
    g, found = flow.grid, {}
    if corners:
        ends = _turning(flow)
        speeds = np.concatenate([ends[None, :-1], g.direction * flow.speed[:, :, 0], ends[None, 1:]])[:, :upto]
        for corner in corners:
            for panel in np.flatnonzero((speeds.min(axis=0) < corner) & (speeds.max(axis=0) > corner)).tolist():
                at = _place_of(flow, panel, (rule().monomials @ speeds[1:-1, panel]).tolist(), corner)
                if at is not None:
                    found[panel] = at
    return found


def _place_of(flow: Flow, panel: int, polynomial: list[float], level: float) -> float | None:
    """Where on a panel a polynomial in its x passes a level, as angle travelled; None where that is no place away from its borders."""
    g = flow.grid
    polynomial = [polynomial[0] - level, *polynomial[1:]]
    samples = np.linspace(-1.0, 1.0, 2 * len(polynomial)).tolist()
    values = [horner(polynomial[::-1], x) for x in samples]
    for k in range(len(samples) - 1):
        if (values[k] > 0) != (values[k + 1] > 0):
            x = root(polynomial, samples[k], samples[k + 1])
            at = float(travelled(g, np.array([panel]), np.array([x]))[0][0])
            if g.borders[panel] + SAME < at < g.borders[panel + 1] - SAME:
                return at
    return None


def _contact_lost(flow: Flow, push: Push) -> list[tuple[int, float]]:
    """Panels on which a contact's law changes its sign, and where, as angles travelled; of one scenario."""
    g, found, turned = flow.grid, [], _turning(flow)
    for panel in push.panels.tolist() if push.stretch.one_sided else []:
        ends = slice(panel, panel + 2)
        rates = [g.lever[push.row][:, panel] * g.direction * flow.speed[:, panel, 0], g.lever_ends[push.row, ends] * turned[ends]]
        position = np.concatenate([g.position[push.row][:, panel], g.position_ends[push.row, ends]])
        law = np.asarray(push.stretch.force(position - push.datum, np.concatenate(rates)))
        if law.min() < 0 < law.max():
            at = _place_of(flow, panel, (rule().monomials @ law[:-2]).tolist(), 0.0)
            if at is not None:
                found.append((panel, at))
    return found
