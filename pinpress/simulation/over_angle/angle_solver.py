"""One press solved over the crank angle, period after period. Where it stops and no force depends on its speed, it is followed back."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...common.numerics import gauss_rule, horner, polynomial_root
from ...common.quantities import Array
from ...loads.caller_laws import LawError
from ..driven_press import DrivenPress
from ..failures import failure
from ..reduced_model import INERTIA, WEIGHT, lock_failure
from ..trajectory import RepetitionSegment, Segment, State, Trajectory
from . import collocation
from .collocation import CollocationSolution
from .mesh import FROM_REST, SAME, STEADY, TO_REST, AngleMesh, angle_to, build_mesh, mesh_borders, range_ahead, repeat_mesh
from .refinement import cuts, solve_period, stopping_panels
from .segment import angle_segment

MOST_PERIODS = 200_000  # most periods of one run: each takes some memory
AT_ONCE = 8  # most periods solved at once: more save almost nothing


# --------------------------------------------------------------------------------------------------------------------- from stop to stop


class Stop(NamedTuple):
    """Why a run over the angle ended."""

    state: State  # in which it ended
    at_rest: bool  # whether the press is at rest there, and no force depends on its speed


class AngleSolver:
    """Follows a press that turns, from a state to a time or to a place where it may stop.

    Attributes:
        segments: found so far, of one period or several each.
        state: of the press at their end.
    """

    def __init__(self, driven: DrivenPress, begin: State, until: float, tolerance: float) -> None:
        """Begin with a state.

        Args:
            driven: what is simulated.
            begin: the state.
            until: time at which the run ends [s].
            tolerance: last terms of a panel's polynomials that are accepted, as a share of the whole.
        """
        self.driven, self.model, self.until, self.tolerance = driven, driven.model, until, tolerance
        self.segments: list[Segment] = []
        self.state = begin
        self.before: CollocationSolution | None = None  # of the period before: its panels and speeds are a good guess
        self.swings = _Swings(driven)
        if not begin.speed:
            self.swings.repetition(self.segments, begin, until)
        # Growing angles would be rounded differently in each period, and a period must begin with exactly what the one before ended with.
        # The equation is therefore solved over the same angles from the ``anchor`` on, and the crank's own angle is counted separately.
        self.anchor, self.first, self.periods = begin.angle, begin.angle, 0
        self.solved = 0  # periods in all

    def run(self, progress: Callable[[float], None] | None = None) -> Stop | None:
        """Add segments up to the end, or to a place where the press may stop. Returns why it ended there, None at the end.

        Args:
            progress: called with the time reached [s] after every segment.

        Raises:
            SimulationError: the press runs against a lock.
        """
        while self.state.time < self.until:
            if self.solved >= MOST_PERIODS:
                raise failure("too many periods", self.state.time, self.state.angle, most=MOST_PERIODS)
            direction = _direction(self.driven, self.state)
            if direction == 0:
                return Stop(self.state, at_rest=True)
            try:
                solved = self._period(direction)
            except LawError as error:
                raise error.within(self.state.time, self.state.angle) from error.__cause__
            if solved is None:
                return Stop(self.state, at_rest=False)
            self._append(*solved)
            if progress is not None:
                progress(min(self.state.time, self.until))
            if not self._goes_on(*solved):
                return Stop(self.state, at_rest=False)
        return None

    def _append(self, solution: CollocationSolution, count: int) -> None:
        """Add the segment of the first ``count`` panels of a solution, and go to its end."""
        from_here = replace(solution, mesh=replace(solution.mesh, start=self.state.angle))
        segment = angle_segment(self.driven, from_here, count, self.state)
        self.segments.append(segment)
        self.state = segment.last()
        self.solved += solution.mesh.periods
        period = self.model.period
        if period is not None and self.model.repeats and segment.travelled == solution.mesh.periods * period:
            self.periods += solution.mesh.periods
            self.state = self.state._replace(angle=self.first + solution.mesh.direction * self.periods * period)
        else:
            self.anchor += solution.mesh.direction * segment.travelled
            self.first, self.periods = self.state.angle, 0

    def _goes_on(self, solution: CollocationSolution, count: int) -> bool:
        """Prepare the next period, and return whether there is one. Where the press swings for ever, add the repetition up to the end."""
        kinds, self.before = solution.mesh.kinds, None
        if not solution.speed_free:
            self.swings.stops.clear()
        if kinds[count - 1] == TO_REST:
            self.state = self.state._replace(speed=0.0)
            repetition = self.swings.repetition(self.segments, self.state, self.until)
            if repetition is not None:
                self.segments.append(repetition)
                self.state = self.state._replace(time=self.until)
        elif count < len(kinds) and self.state.time < self.until:
            return False
        elif self.model.period is None and self.state.time < self.until:
            raise lock_failure(self.model, self.state.angle, self.state.time)
        elif self.model.repeats and kinds[0] == STEADY and len(kinds) < solution.mesh.periods * len(self.model.borders) + 150:
            self.before = solution  # a mesh with more panels, cut for this period alone, would cost every later one
        return True

    def _period(self, direction: int) -> tuple[CollocationSolution, int] | None:
        """The solution of a period or several from the anchor on, or of a shorter range up to a stop, and how many of its panels are right.

        None if the crank would stop, or has to start, under a force that depends on its speed.
        """
        driven, model, anchor = self.driven, self.model, self.anchor
        extent = range_ahead(model, anchor, direction)
        if extent <= 2 * SAME:
            raise lock_failure(model, self.state.angle, self.state.time)
        energy = self._energy()
        # A start with almost no kinetic energy may come to rest at once: it is followed over time.
        if 0 < energy[0] < 1e-7 * model.potential_range:
            return None
        if self.before is not None:
            return self._resolve(self.before.mesh, energy, self.before)
        borders = mesh_borders(driven, anchor, direction, extent)
        mesh = build_mesh(driven, anchor, direction, borders, (self.state.speed == 0, False))
        periods = self._periods_ahead(mesh, float(energy[0]))
        return self._resolve(repeat_mesh(mesh, periods) if periods > 1 else mesh, energy, None)

    def _periods_ahead(self, mesh: AngleMesh, energy: float) -> int:
        """How many periods to solve at once: where no force depends on the speed, those that are left, or equal parts of them.

        Args:
            mesh: of one period.
            energy: kinetic energy at its start [J].
        """
        if not self.model.repeats or self.state.speed == 0 or not self.driven.speed_free:
            return 1
        left = energy - mesh.lifted  # what the loads take away is not in it: the periods grow longer
        if left.min() <= 0:
            return 1
        lasts = float((gauss_rule().weights @ (mesh.measure * np.sqrt((mesh.inertia + self.driven.inertia) / (2 * left)))).sum())
        ahead = (self.until - self.state.time) / lasts
        return math.ceil(ahead / math.ceil(ahead / AT_ONCE))

    def _resolve(self, mesh: AngleMesh, energy: Array, nearby: CollocationSolution | None) -> tuple[CollocationSolution, int] | None:
        """Solve a period, and where it stops in it, again over a mesh that ends there. Returns as `_period`.

        Args:
            mesh: to begin with.
            energy: (1,) kinetic energy at the start [J].
            nearby: a solution over the same mesh, near which this one is; None: unknown.
        """
        driven, direction = self.driven, mesh.direction
        period = solve_period(driven, mesh, energy, self._coarse, nearby=nearby)
        if period is None:
            return None
        count, stopping = _before_stop(period.solution, self.state.time, self.until)
        if stopping and period.solution.speed_free and not len(period.coarse):  # only from panels that are right it is known where it stops
            edges = angle_to(self.model, driven.switch_angles, self.anchor, direction)
            borders = _with_rest(period.solution, count, edges, self.state.speed == 0)
            # The forces of a shorter swing are small differences: it is followed over time.
            if borders[-1] < 1e-2:
                return None
            mesh = build_mesh(driven, self.anchor, direction, borders, (self.state.speed == 0, True), mesh.periods)
            period = solve_period(driven, mesh, energy, self._coarse)
            if period is None or len(period.coarse):
                return None
            count, _ = _before_stop(period.solution, self.state.time, self.until)
        elif len(period.coarse):  # there the crank nearly stops, or the drive switches again and again
            count = int(period.solution.mesh.borders.searchsorted(period.coarse.min())) - 1
        return (period.solution, count) if count > 0 else None

    def _coarse(self, solution: CollocationSolution) -> Array | None:
        """Where to cut the panels of a solution that are too coarse; None if the crank is not to be followed over its angle."""
        from_rest, to_rest = solution.mesh.kinds[0] == FROM_REST, solution.mesh.kinds[-1] == TO_REST
        if (from_rest and not solution.speed_free) or (to_rest and not _comes_to_rest(solution)):
            return None
        count, stopping = _before_stop(solution, self.state.time, self.until)
        if count == 0:
            return np.zeros(0) if stopping and solution.speed_free and not to_rest else None
        return cuts(solution, count, self.tolerance, self.driven.drive)

    def _energy(self) -> Array:
        """(1,) kinetic energy of the state [J]."""
        if self.before is not None:
            inertia = float(self.before.mesh.inertia_ends[0]) + self.driven.inertia
        else:
            inertia = float(self.model.at(np.array([self.anchor]))[0][INERTIA, 0]) + self.driven.inertia
        if not inertia > 0:
            raise failure("no inertia", self.state.time, self.state.angle, inertia=inertia)
        return np.array([0.5 * inertia * self.state.speed**2])


class _Swings:
    """Remembers the stops of a press. Where no force depends on its speed and it stops in the same place again, it repeats that swing for
    ever."""

    def __init__(self, driven: DrivenPress) -> None:
        self.stops: list[tuple[int, float, float]] = []  # segments before, time, crank angle
        self.same_both_ways = all(force.rising is force.falling for force in driven.forces)

    def repetition(self, segments: Sequence[Segment], stop: State, until: float) -> RepetitionSegment | None:
        """The repetition of the swing that ends with this stop; None if none does."""
        self.stops.append((len(segments), stop.time, stop.angle))
        if len(self.stops) < 3 or not self.same_both_ways:
            return None
        (count, first, angle), (_, _, beyond) = self.stops[-3:-1]
        # Two stops that are further apart are different places.
        if abs(stop.angle - angle) > 1e-6 * abs(beyond - angle) or not first < stop.time < until:
            return None
        return RepetitionSegment(Trajectory(segments[count:]), first, stop.time, until)


def _direction(driven: DrivenPress, state: State) -> int:
    """Direction in which the crank turns, or starts from rest; 0 where it stays at rest."""
    model = driven.model
    if state.speed:
        return 1 if state.speed > 0 else -1
    scale = np.abs(model.middles[WEIGHT]).max() + model.potential_range
    for direction in (1, -1):
        ends = np.array([0.0, 1e-6])
        if model.period is None and not model.borders[0] <= state.angle + direction * 1e-6 <= model.borders[-1]:
            continue
        ahead = build_mesh(driven, state.angle, direction, ends, (True, False))
        force = collocation.solve(driven, ahead, np.zeros(1)).force
        if force[0, 0, 0] > 3e-11 * scale:  # a smaller force does not move a crank at rest
            return direction
    return 0


def _comes_to_rest(solution: CollocationSolution) -> bool:
    """Whether the crank comes to rest at the end of the panels: no force depends on its speed, and all its energy is used up."""
    left = float(solution.ends[0, 0] + (gauss_rule().weights @ (solution.force[:, :, 0] * solution.mesh.measure)).sum())
    return solution.speed_free and abs(left) <= 1e-9 * float(solution.ends.max())  # less is rounding of the energies on the way


def _before_stop(solution: CollocationSolution, time: float, until: float) -> tuple[int, bool]:
    """Number of panels up to a stop, or up to and with that in which the time ``until`` is reached, and whether a stop ends them."""
    stopping = stopping_panels(solution)[:, 0]
    right = int(np.argmax(stopping)) if stopping.any() else len(stopping)
    if right:
        reached = time + solution.durations[:right, 0].cumsum() >= until
        if reached.any():
            return int(np.argmax(reached)) + 1, False
    return right, right < len(stopping)


def _with_rest(solution: CollocationSolution, panel: int, edges: Array, from_rest: bool) -> Array:
    """Borders up to the stop in a ``panel``. The last of the new panels runs over the square root of the angle; it begins at the last of
    the ``edges`` before the stop, which are angles travelled, or later."""
    rule, mesh = gauss_rule(), solution.mesh
    polynomial = rule.integral(solution.force[:, panel, 0] * mesh.measure[:, panel]).tolist()  # the energy, which is used up at the stop
    polynomial[0] += float(solution.ends[panel, 0])
    samples = np.append(rule.nodes, 1.0)
    first = int(np.argmax(np.append(solution.energy[:, panel, 0], solution.ends[panel + 1, 0]) <= 0))
    low = -1.0 if first == 0 else float(samples[first - 1])
    # a stop on the border itself may not show: W is rounding there
    x = polynomial_root(polynomial, low, float(samples[first])) if horner(polynomial[::-1], low) > 0 else low
    stop = float(mesh.travelled(np.array([panel]), np.array([x]))[0][0])
    edges = edges[edges < stop - SAME]
    # the last 0.2 rad before the stop, or less
    begin = max(stop - 0.2, float(edges.max(initial=0.0)))
    if from_rest:
        begin = max(begin, min(float(mesh.borders[1]), 0.5 * stop))
    return np.concatenate([mesh.borders[mesh.borders < begin - SAME], [begin, stop]]) if begin > 0 else np.array([0.0, stop])
