"""The motion of a press on springs: one period found directly, or step by step from a known state.

The period is one system of equations: all panels, the first state and the times at which loads begin and end (`panels`). It starts from the
rigid motion with its own events. Where the crank turns freely, the time of the period's end is unknown too: it ends where the crank has
turned through a period. Where Newton's method fails from there, or the links swing through more events than the rigid press, some
strokes are followed step by step first. Panels are divided until the error of each is below the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...common.quantities import Array
from ...loads.process import ForceInterval
from ..failures import failure
from .contact import HertzContact
from .equations import CRANK_ANGLE, INSTANT, ElasticEquations, Event, Release, Segment
from .panels import Border, Indices, Mesh, PanelSolution, radau, solve
from .phases import Border as LoadBorder
from .phases import LoadPhases, Phase, Plan
from .sprung_press import LineSprings, SprungPress

STAGES = 7  # collocation points of a panel: five to seven cost the same for the same error, seven less where it is small
FIRST, LEAST = 24, 6  # panels of a period at first, and of each segment
MOST_STEPS = 16  # of Newton's method
ROUNDS = 8  # in which panels are divided
SETTLED = 1e-3  # Newton's method ends where it changes coordinates by less than this share of the tolerance
WINDOW = 6  # panels that are solved at a time on the way from a known state
STROKES = 6  # that are followed before a press counts as one that does not repeat its stroke
SAMPLES = 16  # places of a segment at which the largest deflection is looked for
LOOKS = 12  # places on a panel at which events are looked for
BESIDE = 1e-9  # lengths of the linkage beside a border at which it is seen what acts there
LOOSE = 300.0  # multiple of the tolerance with which a period is found at first, to see whether its events are as planned
PLANS = 6  # times that the events of a period are planned by the motion that was found with those before
ASIDE = 1e-6  # angle beside a turning at which it is seen which way the rigid press goes [rad]
SHORTEST = 1e-9  # share of a period below which a window counts as stuck
PATIENCE = 4.0  # periods after which a free crank counts as one that does not get through a stroke
COURSE = 240  # times of a period between which those of crank angles are interpolated

RigidMotion = Callable[[Array], tuple[Array, Array, Array]]
"""Times (n,) to coordinates, rates and accelerations (n, f) of the rigid press."""


@dataclass(frozen=True, eq=False)
class ElasticSolution:
    """A motion on its segments.

    Attributes:
        equations: with the forces and events of the segments.
        panels: the motion.
        periodic: whether it is a period.
        evaluations: of the forces at one state, that the last panels took.
    """

    equations: ElasticEquations
    panels: PanelSolution
    periodic: bool
    evaluations: int

    @property
    def decay(self) -> float:
        """Factor by which a disturbance shrinks in a period: the largest size of an eigenvalue of its passage [-]."""
        return float(np.abs(np.linalg.eigvals(self.panels.passage)).max())


class Task(NamedTuple):
    """What is to be found.

    Attributes:
        equations: of the press; their segments are not yet known.
        phases: of its loads.
        rigid: the motion of the rigid press at the same speed, or under the same drive.
        period: of the rigid press [s].
        speed: of the crank, its mean over a period [rad/s].
        gain: (2 f,) what coordinates and rates have gained after a period.
        tolerance: error of a coordinate [m or rad].
    """

    equations: ElasticEquations
    phases: LoadPhases
    rigid: RigidMotion
    period: float
    speed: float
    gain: Array
    tolerance: float

    def times(self, travelled: Array) -> Array:
        """Times (n,) at which the rigid press has turned its crank so far (n,) [s]."""
        if self.equations.crank is not None:
            return travelled / abs(self.speed)
        times = np.linspace(0.0, self.period, COURSE + 1)
        angle = self.rigid(times)[0][:, -1]
        return np.interp(travelled, np.abs(angle - angle[0]), times)


# ------------------------------------------------------------------------------------------------------------------------------ one period


def periodic(task: Task, start: float) -> ElasticSolution:
    """The motion that repeats itself after a period, from a crank angle at which the rigid press turns.

    Raises:
        SimulationError: it is not found: the press may not repeat its stroke.
    """
    plan = task.phases.planned(start)
    guess, tolerance = _rigid_guess(task, plan), LOOSE * task.tolerance
    for _ in range(PLANS):
        found = _refined(task._replace(tolerance=tolerance), start, plan, guess)
        observed = None if found is None else _observed(task, found, start)
        if found is None or observed is None:
            break
        if not _alike(observed, plan):
            plan, guess = observed, _replanned(observed, found.panels)
        elif tolerance == task.tolerance:
            return found
        else:
            tolerance = task.tolerance
            guess = found.panels.onto(_divided(found.panels.mesh, found.panels.errors(), tolerance))
    y, v, _ = task.rigid(np.zeros(1))
    state, depths = np.concatenate([y[0], v[0]]), []
    for stroke in range(STROKES):
        followed = march(task, start, state, *_period_ends(task, start))
        state = followed.panels.states[-1] - task.gain
        depths.append(_deepest(followed))
        if stroke < 1:
            continue
        plan = Plan(followed.equations.segments, followed.equations.events or {}, followed.panels.mesh.knots * abs(task.speed))
        found = _refined(task, start, plan, followed.panels)
        observed = None if found is None else _observed(task, found, start)
        if found is not None and observed is not None and _alike(observed, plan):
            return found
    shown = ", ".join(f"{1e3 * depth:.4f}" for depth in depths)
    raise failure("does not repeat", strokes=STROKES, depths=shown)


def _rigid_guess(task: Task, plan: Plan) -> PanelSolution:
    """The rigid motion on the panels of a plan."""
    rule, share = radau(STAGES), np.diff(plan.knots) / plan.knots[-1]
    counts = np.maximum(LEAST, np.ceil(FIRST * share).astype(int))
    mesh = _even_mesh(task.times(plan.knots), counts)
    y, v, _ = task.rigid(mesh.borders)
    _, _, a = task.rigid((mesh.start[:, None] + mesh.length[:, None] * rule.points).ravel())
    accelerations = a.reshape(len(mesh.start), len(rule.points), -1)
    return PanelSolution(mesh, rule, np.concatenate([y, v], axis=1), accelerations, np.inf, 0, np.eye(2 * y.shape[1]))


def _even_mesh(knots: Array, counts: Indices) -> Mesh:
    """Panels of equal length in each segment."""
    low = np.concatenate([np.arange(count) / count for count in counts])
    high = np.concatenate([np.arange(1, count + 1) / count for count in counts])
    return Mesh(knots, np.repeat(np.arange(len(counts)), counts), low, high)


def _period_ends(task: Task, start: float) -> tuple[float, float]:
    """Time after which a period ends at the latest, and crank angle at which it does."""
    if task.equations.crank is not None:
        return task.period, np.inf
    return PATIENCE * task.period, start + task.speed * task.period


def _refined(task: Task, start: float, plan: Plan, guess: PanelSolution) -> ElasticSolution | None:
    """The period with the events of a plan, on as many panels as it takes; None where Newton's method fails."""
    events: dict[int, Event | Release] = dict(plan.events)
    if task.equations.crank is None:
        events[len(plan.segments)] = Event(CRANK_ANGLE, _period_ends(task, start)[1])
    equations = replace(task.equations, segments=plan.segments, events=events)
    free = [knot for knot, event in events.items() if not _known(event) or equations.crank is None]
    border = Border(True, task.gain, free)
    for _ in range(ROUNDS):
        found = solve(equations, guess, border, SETTLED * task.tolerance, MOST_STEPS)
        if found is None:
            return None
        errors = found.errors()
        if errors.max() <= task.tolerance:
            return ElasticSolution(equations, found, True, found.steps * errors.size * STAGES)
        guess = found.onto(_divided(found.mesh, errors, task.tolerance))
    return None


def _known(event: Event | Release) -> bool:
    """Whether the time of an event is known where the crank's speed is given."""
    return isinstance(event, Event) and event.path == CRANK_ANGLE


def _divided(mesh: Mesh, errors: Array, tolerance: float) -> Mesh:
    """Panels so short that the errors (p,) of these panels become smaller than the tolerance."""
    parts = np.maximum(1, np.ceil((errors / tolerance) ** (1 / (STAGES + 1)))).astype(int)
    ends = [np.linspace(low, high, part + 1) for low, high, part in zip(mesh.low, mesh.high, parts, strict=True)]
    low, high = (np.concatenate([each[piece] for each in ends]) for piece in (slice(None, -1), slice(1, None)))
    return Mesh(mesh.knots, np.repeat(mesh.segment, parts), low, high)


def _observed(task: Task, found: ElasticSolution, start: float) -> Plan | None:
    """The segments, with the times of their knots, in which forces act by the places that the paths of a motion really reach; None where
    no border tells why."""
    equations, mesh, phases = found.equations, found.panels.mesh, task.phases
    panel, share = np.repeat(np.arange(len(mesh.start)), LOOKS), np.tile((np.arange(LOOKS) + 0.5) / LOOKS, len(mesh.start))
    places, _, angles = _places(equations, found.panels, panel, share)
    times, ahead = mesh.start[panel] + share * mesh.length[panel], phases.turnings_ahead(start)
    turned, direction = np.searchsorted(ahead, np.abs(angles - start)), float(np.sign(task.speed))
    phase = phases.advanced(phases.begun(start + ASIDE * direction), places[0])
    segments, knots, events = [phases.active(phase, places[0])], [float(mesh.knots[0])], {}
    telling = _passes(phases, places) | np.append(False, turned[1:] != turned[:-1])
    for k in np.flatnonzero(telling):
        turning = start + direction * ahead[turned[k] - 1] if turned[k] != turned[k - 1] else None
        if turning is not None:
            phase = phases.begun(turning + direction * ASIDE)
        phase = phases.advanced(phase, places[k])
        segment = phases.active(phase, places[k])
        if segment == segments[-1]:
            continue
        if turning is not None:
            share_before, event = (turning - angles[k - 1]) / (angles[k] - angles[k - 1]), Event(CRANK_ANGLE, turning)
        else:
            passed = [border for border in phases.borders if _between(places[k - 1, border.path], border.value, places[k, border.path])]
            if not passed:
                return None
            before, after = places[k - 1, passed[0].path], places[k, passed[0].path]
            share_before, event = (passed[0].value - before) / (after - before), Event(*passed[0])
        events[len(knots)] = event
        knots.append(float(times[k - 1] + share_before * (times[k] - times[k - 1])))
        segments.append(segment)
    return Plan(tuple(segments), events, np.array([*knots, mesh.knots[-1]]))


def _passes(phases: LoadPhases, places: Array) -> Array:
    """(n,) whether a path passes a border on its way from one row of places (n, paths) to the next; it is told of the second one."""
    beyond = np.stack([places[:, border.path] > border.value for border in phases.borders], axis=1) if phases.borders else places[:, :0]
    return np.append(False, (beyond[1:] != beyond[:-1]).any(axis=1))


def _between(before: float, value: float, after: float) -> bool:
    return (before - value) * (after - value) <= 0 and before != after


def _alike(one: Plan, other: Plan) -> bool:
    """Whether the same forces act, from the same events on."""
    kinds = [[event.path for _, event in sorted(plan.events.items()) if isinstance(event, Event)] for plan in (one, other)]
    return one.segments == other.segments and kinds[0] == kinds[1]


def _replanned(plan: Plan, near: PanelSolution) -> PanelSolution:
    """A motion on the panels of a plan whose knots are times, as a guess."""
    counts = np.maximum(LEAST, np.diff(np.searchsorted(near.mesh.borders, plan.knots)))
    return _cut(near, _even_mesh(plan.knots, counts))


def _places(equations: ElasticEquations, panels: PanelSolution, panel: Indices, share: Array) -> tuple[Array, Array, Array]:
    """Values and rates (n, paths) of all paths, and crank angles (n,), at shares (n,) of panels (n,)."""
    y, v, _ = panels.within(panel, share)
    times = panels.mesh.start[panel] + share * panels.mesh.length[panel]
    free, rates = equations.whole(times, y, v)
    coordinates, all_rates = equations.sprung.all_coordinates(free), rates @ equations.sprung.carry.T
    found = [path.over(equations.sprung, coordinates, all_rates) for path in equations.paths]
    return np.stack([each.value for each in found], axis=1), np.stack([each.rate for each in found], axis=1), free[:, -1]


def _deepest(found: ElasticSolution) -> float:
    """Lowest place of the first path, the slide's [m]."""
    count = len(found.panels.mesh.start)
    places, _, _ = _places(found.equations, found.panels, np.repeat(np.arange(count), LOOKS), np.tile(np.arange(LOOKS) / LOOKS, count))
    return float(places[:, 0].min())


# ---------------------------------------------------------------------------------------------------------------------------- step by step


def march(
    task: Task, start: float, state: Array, until: float, goal: float = np.inf, progress: Callable[[float], None] | None = None
) -> ElasticSolution:
    """The motion from a state (2 f,) at time 0, at a crank angle.

    Args:
        task: what is to be found.
        start: crank angle at time 0 [rad].
        state: there.
        until: time of the end [s].
        goal: crank angle [rad] at which a free crank has arrived before that time; infinite: it goes on until then.
        progress: called with the time reached [s].

    Raises:
        SimulationError: the steps become too short, the crank comes to rest, or does not arrive.
    """
    marching = _March(task, start, state, goal)
    while marching.time < until * (1 - 1e-12) and not marching.arrived:
        marching.step(until)
        if progress is not None:
            progress(marching.time)
    if np.isfinite(goal) and not marching.arrived:
        raise failure("too weak", marching.time, marching.angle)
    return marching.joined()


class _Passing(NamedTuple):
    """A path passes a border, the crank an angle, or the force of a contact vanishes.

    Attributes:
        time: about which it does [s].
        border: the border; None: it is a contact's force.
        rise: change of the path there: positive where it rises.
        force: number of the contact.
    """

    time: float
    border: LoadBorder | None
    rise: float = 0.0
    force: int = -1

    @property
    def event(self) -> Event | Release:
        return Release(self.force) if self.border is None else Event(*self.border)


class _March:
    """A motion on its way."""

    def __init__(self, task: Task, start: float, state: Array, goal: float) -> None:
        self.task, self.start, self.state, self.time, self.goal = task, start, state, 0.0, goal
        self.direction = 1 if task.speed > 0 else -1
        self.phase = task.phases.begun(start + ASIDE * self.direction)
        self.ahead = task.phases.turnings_ahead(start)
        self.edges = np.sort([edge for force in task.phases.driven.forces for edge in force.edges])
        self.length = task.period / FIRST / WINDOW
        self.lengths: dict[tuple[bool, ...], float] = {}  # of the last panels while the same forces acted
        self.arrived = False
        self.windows: list[tuple[PanelSolution, int]] = []  # with the segment of each
        size = len(state) // 2
        self.acceleration = np.zeros(size)
        self.segments: list[Segment] = [task.phases.active(self.phase, self._places_now())]
        self.laws = [self.segments[0]]  # the same, with contacts as they were struck
        self.lost: dict[int, ForceInterval] = {}  # laws of contacts that push no more, by the numbers of their forces
        self.events: dict[int, Event | Release] = {}
        self.knots = [0.0]

    @property
    def angle(self) -> float:
        """Of the crank [rad]."""
        crank = self.task.equations.crank
        return float(self.state[len(self.state) // 2 - 1]) if crank is None else crank.angle + crank.speed * self.time

    def _next_turning(self) -> float:
        """Crank angle at which the rigid slide turns next; infinite where it does not matter."""
        if not len(self.ahead):
            return self.direction * np.inf
        period = abs(float(self.task.phases.driven.model.period or 2 * np.pi))
        travelled = self.direction * (self.angle - self.start)
        whole = np.floor(travelled / period) * period
        options = np.concatenate([self.ahead + whole, self.ahead + whole + period])
        return self.start + self.direction * float(options[options > travelled + ASIDE][0])

    def _equations(self) -> ElasticEquations:
        return replace(self.task.equations, segments=(self.laws[-1],), events={}, lost=self.lost)

    def _places_now(self) -> Array:
        return self._paths_now()[0]

    def _rates_now(self) -> Array:
        return self._paths_now()[1]

    def _paths_now(self) -> tuple[Array, Array]:
        """Values and rates (paths,) of all paths."""
        equations, size = self.task.equations, len(self.state) // 2
        free, rates = equations.whole(np.array([self.time]), self.state[None, :size], self.state[None, size:])
        coordinates, all_rates = equations.sprung.all_coordinates(free), rates @ equations.sprung.carry.T
        found = [path.over(equations.sprung, coordinates, all_rates) for path in equations.paths]
        return np.array([each.value[0] for each in found]), np.array([each.rate[0] for each in found])

    def step(self, until: float) -> None:
        """Go on by a window, or to the next event in it."""
        crank, turning, angle = self.task.equations.crank, np.inf, self._next_turning()
        if crank is not None:
            turning = self.time + (angle - self.angle) / crank.speed
        edges = self.edges[self.edges > self.time + INSTANT]
        end = min(until, turning, *edges[:1])
        span = min(WINDOW * self.length, end - self.time)
        found = self._solved(span, {}, None)
        error = np.inf if found is None else float(found.errors().max())
        factor = 0.9 * (self.task.tolerance / max(error, 1e-300)) ** (1 / (STAGES + 1)) if np.isfinite(error) else 0.25
        if not error <= self.task.tolerance:
            self.length = min(max(factor, 0.2), 0.9) * span / WINDOW
            if self.length < SHORTEST * self.task.period:
                raise failure("cannot go on", self.time, message="the steps become too short")
            return
        assert found is not None
        self.length = min(min(factor, 3.0) * span / WINDOW, self.task.period / FIRST)
        event = self._first_event(found, angle)
        if event is not None:
            ended = self._solved(event.time - self.time, {1: event.event}, found)
            if ended is None:
                self.length *= 0.25
                return
            self._take(ended)
            self._cross(event)
        else:
            self._take(found)
            if self.time >= turning - 1e-12 * self.task.period:
                self._turn(angle)
            elif len(edges) and self.time >= edges[0] - INSTANT:
                self._begin(Event(CRANK_ANGLE, self.angle), self._places_now())

    def _turn(self, angle: float) -> None:
        """Pass a crank angle at which the rigid slide turns."""
        self.phase = self.task.phases.begun(angle + ASIDE * self.direction)
        self._begin(Event(CRANK_ANGLE, angle), self._places_now())

    def _solved(self, span: float, events: dict[int, Event | Release], near: PanelSolution | None) -> PanelSolution | None:
        """A window from the present state; its end is free where an event ends it."""
        size, rule = len(self.state) // 2, radau(STAGES)
        mesh = _even_mesh(np.array([self.time, self.time + span]), np.array([WINDOW]))
        if near is None:
            h, y, v = mesh.length[0], self.state[:size], self.state[size:]
            ahead = np.arange(WINDOW + 1)[:, None] * h
            states = np.concatenate([y + ahead * v, np.tile(v, (WINDOW + 1, 1))], axis=1)
            accelerations = np.tile(self.acceleration, (WINDOW, STAGES, 1))
            guess = PanelSolution(mesh, rule, states, accelerations, np.inf, 0, np.eye(2 * size))
        else:
            guess = _cut(near, mesh)
        equations = replace(self._equations(), events=events)
        border = Border(False, np.zeros(2 * size), list(events))
        return solve(equations, guess, border, SETTLED * self.task.tolerance, MOST_STEPS)

    def _first_event(self, found: PanelSolution, turning: float) -> _Passing | None:
        """What first changes the forces that act within a window, or angle of its own that a free crank passes; without such an event the
        phase goes on to its end."""
        count, phases, phase = len(found.mesh.start), self.task.phases, self.phase
        angles = [angle for angle in (turning, self.goal) if np.isfinite(angle)] if self.task.equations.crank is None else []
        if not phases.borders and not angles:
            return None
        panel, share = np.repeat(np.arange(count), LOOKS), np.tile(np.arange(1, LOOKS + 1) / LOOKS, count)
        places, rates, crank = _places(self._equations(), found, panel, share)
        places, crank = np.concatenate([self._places_now()[None], places]), np.append(self.angle, crank)
        times = np.append(self.time, found.mesh.start[panel] + share * found.mesh.length[panel])
        acting = [(k, law) for k, law in enumerate(self.laws[-1]) if isinstance(law, ForceInterval)]
        pushing = [(k, law) for k, law in acting if law.one_sided and law.heeds_velocity]
        contacts = [*pushing, *self.lost.items()]
        telling = _passes(phases, places)
        telling[1] = True  # it starts on a border
        for k in range(1, len(times)):
            if not (telling[k] or contacts or angles):
                continue
            passed = [self._passing(times, crank, k, LoadBorder(CRANK_ANGLE, angle)) for angle in angles]
            released = None if any(passed) else self._released(contacts, phase, places[k], rates[k - 1])
            if released is not None:
                self.phase = phase
                return _Passing(float(times[k]), None, force=released)
            before_step, phase = phase, phases.advanced(phase, places[k])
            if phases.active(phase, places[k], self.time) != self.segments[-1]:
                passed += [self._passing(times, places[:, border.path], k, border) for border in phases.borders]
            found_here = [one for one in passed if one is not None]
            if found_here:
                self.phase = before_step
                return min(found_here, key=lambda passing: passing.time)
        self.phase = phase
        self.lost = {number: law for number, law in self.lost.items() if phase.through[number]}
        return None

    def _released(self, contacts: Sequence[tuple[int, ForceInterval]], phase: Phase, places: Array, rates: Array) -> int | None:
        """The first of the contacts that ceases to push, or pushes again before its bodies are apart; None: none does."""
        for number, law in contacts:
            if number in self.lost and not phase.through[number]:  # apart by now
                continue
            force = self.task.phases.forces[number]
            pushes = float(law.force(places[force.row] - force.datum, rates[force.row])) >= 0
            if pushes == phase.through[number]:
                return number
        return None

    def _passing(self, times: Array, values: Array, k: int, border: LoadBorder) -> _Passing | None:
        """The passage of a border by values (n,) at times (n,) between the last one and number k; None where there is none."""
        before, after = values[k - 1] - border.value, values[k] - border.value
        if before * after > 0 or before == after:
            return None
        return _Passing(float(times[k - 1] + (times[k] - times[k - 1]) * before / (before - after)), border, after - before)

    def _cross(self, passing: _Passing) -> None:
        """Go on after an event."""
        if passing.border is not None and passing.border.path == CRANK_ANGLE:
            self.arrived = passing.border.value == self.goal
            if not self.arrived:
                self._turn(passing.border.value)
            return
        places = self._places_now()
        if passing.border is None:
            law = self.laws[-1][passing.force]
            if isinstance(law, ForceInterval):
                self.lost[passing.force] = law
            self.phase = self.task.phases.released(self.phase, passing.force)
        else:
            beside = np.copysign(BESIDE * self.task.equations.sprung.press.size, passing.rise)
            places[passing.border.path] = passing.border.value + beside
            self.phase = self.task.phases.advanced(self.phase, places)
        self._begin(passing.event, places)

    def _begin(self, event: Event | Release, places: Array) -> None:
        """Begin a new segment where other forces act."""
        segment = self.task.phases.active(self.phase, places, self.time)
        if segment != self.segments[-1]:
            self.events[len(self.knots)] = event
            self.knots.append(self.time)
            self.lengths[_acting(self.segments[-1])] = self.length
            self.length = self.lengths.get(_acting(segment), self.length)
            self.laws.append(self._struck(segment))
            self.lost = {number: law for number, law in self.lost.items() if self.phase.through[number]}
            self.segments.append(segment)

    def _struck(self, segment: Segment) -> Segment:
        """The intervals of a new segment; contacts by Hertz with the speed at which they are struck now."""
        found, speeds = list(segment), None
        for number, interval in enumerate(segment):
            if not isinstance(interval, HertzContact):
                continue
            if self.segments[-1][number] is interval or number in self.lost:  # it goes on
                found[number] = self.lost.get(number, self.laws[-1][number])
                continue
            speeds = self._rates_now() if speeds is None else speeds
            found[number] = interval.struck(abs(float(speeds[self.task.phases.forces[number].row])))
        return tuple(found)

    def _take(self, window: PanelSolution) -> None:
        self.windows.append((window, len(self.segments) - 1))
        self.time, self.state = float(window.mesh.knots[-1]), window.states[-1]
        self.acceleration = window.accelerations[-1, -1]
        if self.task.equations.crank is None and not (self.direction * window.states[:, -1] > 0).all():
            raise failure("crank rests", self.time, self.angle)

    def joined(self) -> ElasticSolution:
        """All windows as one motion."""
        knots = np.array([*self.knots, self.time])
        borders = np.concatenate([*(window.mesh.start for window, _ in self.windows), [self.time]])
        segment = np.concatenate([np.full(len(window.mesh.start), number) for window, number in self.windows])
        spans = np.diff(knots)[segment]
        low, high = (borders[:-1] - knots[segment]) / spans, (borders[1:] - knots[segment]) / spans
        states = np.concatenate([*(window.states[:-1] for window, _ in self.windows), self.state[None]])
        passage = np.eye(len(self.state))
        for window, _ in self.windows:
            passage = window.passage @ passage
        panels = PanelSolution(
            Mesh(knots, segment, low, high),
            self.windows[0][0].rule,
            states,
            np.concatenate([window.accelerations for window, _ in self.windows]),
            0.0,
            sum(window.steps for window, _ in self.windows),
            passage,
        )
        evaluations = sum(window.steps * WINDOW * STAGES for window, _ in self.windows)
        return ElasticSolution(replace(self.task.equations, segments=tuple(self.laws), events=self.events), panels, False, evaluations)


def _acting(segment: Segment) -> tuple[bool, ...]:
    return tuple(interval is not None for interval in segment)


def _cut(near: PanelSolution, mesh: Mesh) -> PanelSolution:
    """The first part of a motion, as a guess on other panels."""
    y, v, _ = near.at(mesh.borders)
    _, _, a = near.at((mesh.start[:, None] + mesh.length[:, None] * near.rule.points).ravel() - 1e-12 * mesh.length[0])
    accelerations = a.reshape(len(mesh.start), len(near.rule.points), -1)
    return PanelSolution(mesh, near.rule, np.concatenate([y, v], axis=1), accelerations, np.inf, 0, near.passage)


def largest_deflection(task: Task, start: float) -> float:
    """Largest displacement of a coordinate by what acts in a period of the rigid press, on springs that follow at once [m or rad].

    It is that to which errors are compared.
    """
    plan, sprung = task.phases.planned(start), task.equations.sprung
    share = (np.arange(SAMPLES) + 1) / SAMPLES
    times = (plan.knots[:-1, None] + np.diff(plan.knots)[:, None] * share).ravel() * (task.period / plan.knots[-1])
    y, v, a = task.rigid(times)
    equations = replace(task.equations, segments=plan.segments, sprung=sprung.closed or sprung)
    segments = np.repeat(np.arange(len(plan.segments)), SAMPLES)
    force, _, _, _ = equations.forces(times, y, v, segments)
    bare = replace(equations, segments=tuple((None,) * len(segment) for segment in plan.segments))
    _, stiffness, _, _ = bare.forces(times, y, v, segments)
    return float(np.abs(np.linalg.solve(stiffness, (force - a @ equations.mass)[..., None])).max())


def resting(task: Task, start: float) -> Array:
    """The state (2 f,) at time 0 whose springs carry weight, loads and the inertia forces of the rigid motion, so that no vibration begins.
    Journals with clearance rest on their bearings on the side to which these forces press them.

    A free crank is accelerated by what its drive then leaves.

    Raises:
        SimulationError: the springs do not carry them.
    """
    y, v, a = task.rigid(np.zeros(1))
    phase = task.phases.begun(start + ASIDE * np.sign(task.speed))
    segment = task.phases.active(phase, task.phases.places(start))
    equations, sprung = replace(task.equations, segments=(segment,)), task.equations.sprung
    if sprung.closed is None:
        return np.concatenate([_balanced(equations, y, v, a, task.tolerance)[0], v[0]])
    y = _balanced(replace(equations, sprung=sprung.closed), y, v, a, task.tolerance)
    aside = replace(sprung.closed, lines=_pressed_aside(sprung, replace(equations, sprung=sprung.closed), y, v))
    y = _balanced(replace(equations, sprung=aside), y, v, a, task.tolerance)
    touching = segment[: len(task.phases.driven.forces)] + tuple(contact.rising[0] for contact in task.phases.contacts)
    return np.concatenate([_balanced(replace(equations, segments=(touching,)), y, v, a, task.tolerance)[0], v[0]])


def _balanced(equations: ElasticEquations, y: Array, v: Array, a: Array, tolerance: float) -> Array:
    """Coordinates (1, f) near ``y`` at which all forces balance the inertia forces of given accelerations (1, f)."""
    by_crank = v[0] / v[0, -1]  # rates of a free crank's coordinates by its own
    for _ in range(MOST_STEPS):
        force, stiffness, _, _ = equations.forces(np.zeros(1), y, v, np.zeros(1, dtype=int))
        matrix = stiffness[0]
        if equations.crank is None:
            matrix[:, -1] = equations.mass @ by_crank
        step = np.linalg.solve(matrix, force[0] - a[0] @ equations.mass)
        if equations.crank is None:
            a, step[-1] = a + step[-1] * by_crank, 0.0
        y = y + step
        if np.abs(step).max() <= tolerance:
            return y
    raise failure("cannot go on", 0.0, message="the springs do not carry the links at the start")


def _pressed_aside(sprung: SprungPress, closed: ElasticEquations, y: Array, v: Array) -> LineSprings:
    """The springs of the closed press, slack where journals with clearance lie beside their bearings' centres, as the forces press them."""
    lines = closed.sprung.lines
    free, _ = closed.whole(np.zeros(1), y, v)
    coordinates = closed.sprung.all_coordinates(free)
    extension, rest = closed.sprung.geometry(coordinates, np.zeros_like(coordinates)).extension[0], lines.rest.copy()
    for pin in sprung.open_pins:
        own = lines.bearing == pin.bearing
        rest[own] = extension[own] * (pin.clearance.radial / max(float(np.linalg.norm(extension[own])), 1e-300))
    return lines._replace(rest=rest)
