"""One press over the crank angle: period after period, and where it stops and no force depends on its speed, back again."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array
from ..common.errors import SimulationError
from ..loads.caller_laws import LawError
from . import collocation as over_angle
from . import mesh as panels
from . import mesh_refinement as resolution
from .angle_segments import Repeated, State, turned
from .collocation import Flow
from .driven_press import DrivenPress, not_positive
from .mesh import STEADY, TO_REST, Grid
from .reduced_model import INERTIA, POTENTIAL, WEIGHT, Table, beyond, horner, root, rule
from .trajectory import Path, Segment

SMALL = 1e-2  # swings shorter than this are followed over time: their forces are small differences [rad]
REST = 0.2  # angle before a stop that is run through over its square root [rad]
NOTHING = 3e-11  # force on a crank at rest, beside the range of the potential energy a radian, that is none
LITTLE = 1e-7  # kinetic energy, beside the range of the potential one, from which a start is followed over time
USED_UP = 1e-9  # kinetic energy left at a stop, beside the largest on the way there, that is none
MOST_PERIODS = 200_000  # in one run; each takes some memory
NOTICED = 1e-6  # share of a swing by which two stops are not in the same place
MOST_CUTS = 40  # rounds of cutting panels
MOST_KEPT = 150  # panels more than the table's, that are taken over into the next period
NO_CUTS = np.zeros(0)


def too_long(time: float, angle: float) -> SimulationError:
    """A run has more periods than are kept."""
    return SimulationError(f"more than {MOST_PERIODS} periods of the press: simulate in parts", time, angle)


class Stop(NamedTuple):
    """Why a run over the angle ended: ``at`` the state reached; ``held``: it is at rest there, and no force depends on speed."""

    at: State
    held: bool


class Swings:
    """Stops of a press under forces that do not depend on its speed: where it stops a second time, it swings on like that for ever."""

    def __init__(self, driven: DrivenPress) -> None:
        self.stops: list[tuple[int, float, float]] = []  # segments before, time, crank angle
        self.same_both_ways = all(force.rising is force.falling for force in driven.forces)

    def stopped(self, segments: Sequence[Segment], time: float, angle: float, until: float) -> Repeated | None:
        """The repetition of the swing that ends with this stop, where one does."""
        self.stops.append((len(segments), time, angle))
        if len(self.stops) < 3 or not self.same_both_ways:
            return None
        (count, first, at), (_, _, beyond) = self.stops[-3:-1]
        if abs(angle - at) > NOTICED * abs(beyond - at) or not first < time < until:
            return None
        return Repeated(Path(segments[count:]), first, time, until)


def run(
    driven: DrivenPress,
    table: Table,
    edges: Sequence[Array],
    begin: State,
    until: float,
    tolerance: float,
    progress: Callable[[float], None] | None = None,
) -> "tuple[list[Segment], Stop | None]":
    """Follow a press that turns, from a state on, up to a time or to where it may stop.

    Raises:
        SimulationError: it runs against a lock.
    """
    segments: list[Segment] = []
    state, before, swings = begin, None, Swings(driven)
    if not begin.speed:
        swings.stopped(segments, begin.time, begin.angle, until)
    # Angles that grow round off, and what a period begins with must be what the one before ended with: the equation is solved over angles
    # from the ``anchor`` on, again and again, and the crank's own angle is counted beside it.
    anchor, first, periods = begin.angle, begin.angle, 0
    while state.time < until:
        if len(segments) == MOST_PERIODS:
            raise too_long(state.time, state.angle)
        direction = _direction(driven, table, state)
        if direction == 0:
            return segments, Stop(state, held=True)
        try:
            found = _period(driven, table, edges, state, anchor, direction, until, tolerance, before)
        except LawError as error:
            raise error.within(state.time, state.angle) from error.__cause__
        if found is None:
            return segments, Stop(state, held=False)
        flow, count = found
        solved = turned(driven, table, replace(flow, grid=replace(flow.grid, start=state.angle)), count, state)
        segments.append(solved)
        state = solved.last()
        if table.period is not None and solved.travelled == table.period:
            periods += 1
            state = state._replace(angle=first + direction * periods * table.period)
        else:
            anchor, first, periods = anchor + direction * solved.travelled, state.angle, 0
        if progress is not None:
            progress(min(state.time, until))
        before = None
        if not flow.held:
            swings.stops.clear()
        if flow.grid.kinds[count - 1] == TO_REST:
            state = state._replace(speed=0.0)
            repeated = swings.stopped(segments, state.time, state.angle, until)
            if repeated is not None:
                return [*segments, repeated], None
        elif count < len(flow.grid.kinds) and state.time < until:
            return segments, Stop(state, held=False)
        elif table.period is None and state.time < until:
            raise beyond(table, state.angle, state.time)
        elif flow.grid.kinds[0] == STEADY and len(flow.grid.kinds) < len(table.borders) + MOST_KEPT:
            before = flow
    return segments, None


def _direction(driven: DrivenPress, table: Table, state: State) -> int:
    """Way in which the crank turns, or starts from rest; 0 where it stays."""
    if state.speed:
        return 1 if state.speed > 0 else -1
    scale = np.abs(table.coefficients[:, WEIGHT, 0]).max() + np.ptp(table.coefficients[:, POTENTIAL, 0])
    for direction in (1, -1):
        ends = np.array([0.0, 1e-6])
        if table.period is None and not table.borders[0] <= state.angle + direction * 1e-6 <= table.borders[-1]:
            continue
        beside = panels.grid(driven, table, state.angle, direction, ends, (True, False))
        force = over_angle.flow(driven, beside, np.zeros(1), _any_energy(driven, beside)).force
        if force[0, 0, 0] > NOTHING * scale:
            return direction
    return 0


def _any_energy(driven: DrivenPress, grid: Grid) -> Array:
    """Kinetic energy at 1 rad/s (q, p, 1): where to start from, when there is none yet."""
    return np.asarray(0.5 * (grid.inertia[:, :, None] + driven.inertia))


def _period(
    driven: DrivenPress,
    table: Table,
    edges: Sequence[Array],
    state: State,
    anchor: float,
    direction: int,
    until: float,
    tolerance: float,
    before: Flow | None,
) -> tuple[Flow, int] | None:
    """A period of the table from the crank angle ``anchor``, or less up to a stop or the time ``until``, and how many panels are right.

    ``before`` is the period before: its panels and its speeds are a good start. None where the crank would stop, or has to start, under a
    force that depends on its speed.
    """
    extent = panels.extent(table, anchor, direction)
    if extent <= 2 * panels.SAME:
        raise beyond(table, state.angle, state.time)
    from_rest, to_rest = state.speed == 0, False
    inertia = float(table.at(np.array([anchor]))[0][INERTIA, 0]) + driven.inertia
    if not inertia > 0:
        raise not_positive(inertia, state.time, state.angle)
    energy = np.array([0.5 * inertia * state.speed**2])
    if 0 < energy[0] < LITTLE * np.ptp(table.coefficients[:, POTENTIAL, 0]):
        return None
    if before is not None:
        grid, guess = before.grid, before.energy
    else:
        ends = panels.borders(table, edges, anchor, direction, extent)
        grid, guess = panels.grid(driven, table, anchor, direction, ends, (from_rest, to_rest)), None
    for _ in range(MOST_CUTS):
        if guess is None and from_rest:
            guess = _any_energy(driven, grid)
        flow = over_angle.flow(driven, grid, energy, guess)
        if from_rest and not flow.held:
            return None
        if to_rest and not _comes_to_rest(flow):
            return None
        count, stopping = _before_stop(flow, state.time, until)
        ends, stops = grid.borders, stopping and flow.held and not to_rest
        if count == 0 and not stops:
            return None
        cuts = resolution.unresolved(flow, count, tolerance, driven.corners) if count else NO_CUTS
        if len(cuts):
            ends = np.sort(np.concatenate([ends, cuts]))
        elif stops:  # where it stops is known from panels that are right, and not before
            ends = _with_rest(flow, count, ends, panels.on_the_way(table, edges, anchor, direction), from_rest)
            to_rest = True
            if ends[-1] < SMALL:
                return None
        else:
            return flow, count
        grid = panels.grid(driven, table, anchor, direction, ends, (from_rest, to_rest))
        guess = resolution.carried(flow, grid)
    # what still is not resolved: there the crank all but stops, or the drive switches again and again
    if to_rest or not len(cuts):
        return None
    right = int(grid.borders.searchsorted(cuts.min())) - 1
    return (flow, right) if right > 0 else None


def _comes_to_rest(flow: Flow) -> bool:
    """Whether a crank that is to rest at the end of its panels does so: no force depends on its speed, and all the energy is used up."""
    left = float(flow.ends[0, 0] + (rule().weights @ (flow.force[:, :, 0] * flow.grid.measure)).sum())
    return flow.held and abs(left) <= USED_UP * float(flow.ends.max())


def _before_stop(flow: Flow, time: float, until: float) -> tuple[int, bool]:
    """Panels up to a stop, or to the one in which the time ``until`` is reached; whether it was a stop that ended them."""
    stopping = resolution.stopping(flow)[:, 0]
    right = int(np.argmax(stopping)) if stopping.any() else len(stopping)
    if right:
        times = time + (rule().weights @ (flow.grid.measure[:, :right] / flow.speed[:, :right, 0])).cumsum()
        reached = times >= until
        if reached.any():
            return int(np.argmax(reached)) + 1, False
    return right, right < len(stopping)


def _with_rest(flow: Flow, panel: int, ends: Array, hard: Array, from_rest: bool) -> Array:
    """Borders up to the stop in a ``panel``, the last of them over the square root of the angle; it starts at ``hard`` borders at the
    latest."""
    grid, r = flow.grid, rule()
    polynomial = r.integral(flow.force[:, panel, 0] * grid.measure[:, panel]).tolist()
    polynomial[0] += float(flow.ends[panel, 0])
    samples = np.append(r.nodes, 1.0)
    first = int(np.argmax(np.append(flow.energy[:, panel, 0], flow.ends[panel + 1, 0]) <= 0))
    low = -1.0 if first == 0 else float(samples[first - 1])
    # a stop on the border itself may show as none: W is rounding there
    x = root(polynomial, low, float(samples[first])) if horner(polynomial[::-1], low) > 0 else low
    stop = float(panels.travelled(grid, np.array([panel]), np.array([x]))[0][0])
    hard = hard[hard < stop - panels.SAME]
    begin = max(stop - REST, float(hard.max(initial=0.0)))
    if from_rest:
        begin = max(begin, min(float(ends[1]), 0.5 * stop))
    return np.concatenate([ends[ends < begin - panels.SAME], [begin, stop]]) if begin > 0 else np.array([0.0, stop])
