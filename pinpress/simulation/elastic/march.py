"""The motion of a press on springs from a known state, step by step.

Some panels at a time are solved, as many as the tolerance allows. Where a load begins or ends, or a contact, the last panel ends there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...common.numerics import radau_rule
from ...common.quantities import Array
from ...loads.process import ForceInterval
from ..failures import failure
from .contact import HertzContact
from .equations import ElasticEquations
from .panels import Ends, Mesh, PanelSolution, PanelStates, solve
from .press.drive import TrainEvent, TrainMode
from .strokes import CRANK_ANGLE, INSTANT, Event, MotionEvent, Phase, Release, Segment, crossing
from .task import FIRST_PANELS, LOOKS, MOST_STEPS, PAST_TURNING, SETTLED, STAGES, ElasticSolution, Task, even_mesh

WINDOW = 6  # panels that are solved at a time on the way from a known state


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
    return marching.join()


class _Passing(NamedTuple):
    """An event, the time about which it happens [s], and the change of the path there: positive where it rises."""

    time: float
    event: MotionEvent
    rise: float = 0.0


class _Piece(NamedTuple):
    """A part of a motion in which the same intervals act; in ``laws`` contacts are as they were struck. A held crank has no mode."""

    mode: TrainMode | None
    segment: Segment
    laws: Segment


class _March:
    """A motion on its way."""

    def __init__(self, task: Task, start: float, state: Array, goal: float) -> None:
        self.task, self.start, self.state, self.time, self.goal = task, start, state, 0.0, goal
        self.direction = 1 if task.speed > 0 else -1
        self.phase = task.strokes.begin(start + PAST_TURNING * self.direction)
        self.ahead = task.strokes.turnings_ahead(start)
        self.train = task.equations.train
        self.mode: TrainMode | None = None
        edges = [edge for force in task.strokes.driven.forces for edge in force.edges]
        self.length = task.period / FIRST_PANELS / WINDOW
        self.lengths: dict[tuple[bool, ...], float] = {}  # of the last panels while the same forces acted
        self.arrived = False
        self.windows: list[tuple[PanelSolution, int]] = []  # with the segment of each
        size = len(state) // 2
        self.acceleration = np.zeros(size)
        if self.train is not None:
            self.mode = self.train.due(self.train.begun(start, float(state[-1]))[0], 0.0, state[size:])
            edges += [*self.train.switch_times, *self.train.risen(self.mode)]
        self.edges, self.farthest, self.at_once = np.unique(edges), start, 0
        segment = task.strokes.active(self.phase, self._places_now())
        self.pieces = [_Piece(self.mode, segment, segment)]
        self.lost: dict[int, ForceInterval] = {}  # laws of contacts that push no more, by the numbers of their forces
        self.events: dict[int, MotionEvent] = {}
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
        period = abs(float(self.task.strokes.driven.model.period or 2 * np.pi))
        travelled = self.direction * (self.angle - self.start)
        whole = np.floor(travelled / period) * period
        options = np.concatenate([self.ahead + whole, self.ahead + whole + period])
        return self.start + self.direction * float(options[options > travelled + PAST_TURNING][0])

    def _equations(self) -> ElasticEquations:
        modes = () if self.mode is None else (self.mode,)
        return replace(self.task.equations, segments=(self.pieces[-1].laws,), modes=modes, events={}, lost=self.lost)

    @property
    def _now(self) -> tuple[Array, Array, Array]:
        """Time (1,), coordinates and rates (1, size)."""
        y, v = np.split(self.state[None], 2, axis=1)
        return np.array([self.time]), y, v

    def _places_now(self) -> Array:
        """Values (paths,) of all paths."""
        return np.asarray(self.task.equations.places(*self._now)[0][0])

    def step(self, until: float) -> None:
        """Go on by a window, or to the next event in it."""
        if self._slip_at_once():
            return
        crank, turning, angle = self.task.equations.crank, np.inf, self._next_turning()
        if crank is not None:
            turning = self.time + (angle - self.angle) / crank.speed
        edges = self.edges[self.edges > self.time + INSTANT]
        end = min(until, turning, *edges[:1])
        span = min(WINDOW * self.length, end - self.time)
        window = self._solve_window(span, {}, None)
        error = np.inf if window is None else float(window.errors().max())
        factor = 0.9 * (self.task.tolerance / max(error, 1e-300)) ** (1 / (STAGES + 1)) if np.isfinite(error) else 0.25
        if not error <= self.task.tolerance:
            self.length = min(max(factor, 0.2), 0.9) * span / WINDOW
            if self.length < 1e-9 * self.task.period:  # it is stuck
                raise failure("cannot go on", self.time, message="the steps become too short")
            return
        assert window is not None
        self.length = min(min(factor, 3.0) * span / WINDOW, self.task.period / FIRST_PANELS)
        event = self._first_event(window, angle)
        if event is not None:
            ended = self._solve_window(event.time - self.time, {1: event.event}, window)
            if ended is None:
                self.length *= 0.25
                return
            self._take(ended)
            self._cross(event)
        else:
            self._take(window)
            if self.train is not None and self.mode is not None:
                self._go_on_in(self.train.due(self.mode, self.time, self.state[len(self.state) // 2 :]), Event(CRANK_ANGLE, self.angle))
            if self.time >= turning - 1e-12 * self.task.period:
                self._turn(angle)
            elif len(edges) and self.time >= edges[0] - INSTANT:
                self._begin(Event(CRANK_ANGLE, self.angle), self._places_now())

    def _turn(self, angle: float) -> None:
        """Pass a crank angle at which the rigid slide turns."""
        self.phase = self.task.strokes.begin(angle + PAST_TURNING * self.direction)
        self._begin(Event(CRANK_ANGLE, angle), self._places_now())

    def _solve_window(self, span: float, events: dict[int, MotionEvent], near: PanelSolution | None) -> PanelSolution | None:
        """A window from the present state; its end is free where an event ends it."""
        size, rule = len(self.state) // 2, radau_rule(STAGES)
        mesh = even_mesh(np.array([self.time, self.time + span]), np.array([WINDOW]))
        if near is None:
            h, y, v = mesh.length[0], self.state[:size], self.state[size:]
            ahead = np.arange(WINDOW + 1)[:, None] * h
            states = np.concatenate([y + ahead * v, np.tile(v, (WINDOW + 1, 1))], axis=1)
            accelerations = np.tile(self.acceleration, (WINDOW, STAGES, 1))
            guess = PanelSolution(mesh, rule, states, accelerations, np.inf, 0, np.eye(2 * size))
        else:
            guess = cut_to(near, mesh)
        equations = replace(self._equations(), events=events)
        border = Ends(False, np.zeros(2 * size), list(events))
        return solve(equations, guess, border, SETTLED * self.task.tolerance, MOST_STEPS)

    def _first_event(self, window: PanelSolution, turning: float) -> _Passing | None:
        """The first event within a window that changes the forces, or the first angle that a free crank passes; without one the phase goes
        on to the window's end."""
        strokes, phase, equations = self.task.strokes, self.phase, self._equations()
        angles = [angle for angle in (turning, self.goal) if np.isfinite(angle)] if self.task.equations.crank is None else []
        seen = window.sample(np.arange(1, LOOKS + 1) / LOOKS)
        margins = self._margins(seen)
        if not strokes.borders and not angles and not margins:
            return None
        places, rates = equations.places(seen.time, seen.y, seen.v)
        crank = np.append(self.angle, equations.whole(seen.time, seen.y, seen.v)[0][:, -1])
        places, times = np.concatenate([self._places_now()[None], places]), np.append(self.time, seen.time)
        acting = [(k, law) for k, law in enumerate(self.pieces[-1].laws) if isinstance(law, ForceInterval)]
        contacts = [*((k, law) for k, law in acting if law.one_sided and law.heeds_velocity), *self.lost.items()]
        joints = [number for number in self.lost if number >= len(strokes.driven.forces) + len(self.task.equations.sprung.open_pins)]
        changed = strokes.crossed(places)
        changed[1] = True  # it starts on a border
        for _, values in margins:
            changed |= values < 0
        for k in range(1, len(times)):
            if not (changed[k] or contacts or angles):
                continue
            passed = [self._passing(times, crank, k, Event(CRANK_ANGLE, angle)) for angle in angles]
            passed += [self._vanishing(times, values, k, event) for event, values in margins]
            released = None if any(passed) else self._released(contacts, phase, places[k], rates[k - 1])
            if released is not None:
                self.phase = phase
                return _Passing(float(times[k]), Release(released))
            before_step, phase = phase, strokes.advance(phase, places[k])
            apart = any(before_step.through[number] and not phase.through[number] for number in joints)  # its spring is relaxed
            if apart or strokes.active(phase, places[k], self.time) != self.pieces[-1].segment:
                passed += [self._passing(times, places[:, border.path], k, border) for border in strokes.borders]
            events = [passing for passing in passed if passing is not None]
            if events:
                self.phase = before_step
                return min(events, key=lambda passing: passing.time)
        self.phase = phase
        self.lost = {number: law for number, law in self.lost.items() if phase.through[number]}
        return None

    def _released(self, contacts: Sequence[tuple[int, ForceInterval]], phase: Phase, places: Array, rates: Array) -> int | None:
        """The first of the contacts that ceases to push, or pushes again before its bodies are apart; None: none does."""
        for number, law in contacts:
            if number in self.lost and not phase.through[number]:  # apart by now
                continue
            force = self.task.strokes.forces[number]
            if number in self.lost and not isinstance(law, HertzContact):  # it may have gone on into another interval since
                law = self.task.strokes.interval_at(number, phase, places) or law
            pushes = law.pushes(float(law.force(places[force.row] - force.datum, rates[force.row])))
            if pushes == phase.through[number]:
                if number in self.lost:
                    self.lost[number] = law
                return number
        return None

    def _passing(self, times: Array, values: Array, k: int, border: Event) -> _Passing | None:
        """The passage of a border by values (n,) at times (n,) between the last one and number k; None if they do not pass it."""
        before, after = values[k - 1] - border.value, values[k] - border.value
        share = crossing(before, after)
        return None if share is None else _Passing(float(times[k - 1] + (times[k] - times[k - 1]) * share), border, after - before)

    def _vanishing(self, times: Array, margin: Array, k: int, event: TrainEvent) -> _Passing | None:
        """The event of the drive train whose margin (n,) falls below zero before number k; None if it does not."""
        if margin[k] >= 0 or margin[k - 1] < 0:
            return None
        share = margin[k - 1] / (margin[k - 1] - margin[k])
        return _Passing(float(times[k - 1] + (times[k] - times[k - 1]) * share), event)

    def _margins(self, seen: PanelStates) -> list[tuple[TrainEvent, Array]]:
        """The events that may end the mode of the drive train, each with its margins at the start and at all places of a window."""
        if self.train is None or self.mode is None:
            return []
        events = self.train.events(self.mode, self.direction, self.angle)
        if not events:
            return []
        time, y, v = self._now
        states = np.append(time, seen.time), np.vstack([y, seen.y]), np.vstack([v, seen.v])
        return [(event, self._margin(event, *states)) for event in events]

    def _margin(self, event: TrainEvent, times: Array, y: Array, v: Array) -> Array:
        """Margin (n,) of an event in the present mode."""
        assert self.mode is not None
        return self._equations().train_margin(event, self.mode, times, y, v)[0]

    def _slip_at_once(self) -> bool:
        """Whether a coupling that holds begins to slip, because it can hold no more after an event."""
        if self.train is None or self.mode is None:
            return False
        for event in self.train.events(self.mode, self.direction, self.angle):
            if event.kind != "slips":
                continue
            coupling = self.train.coupling(event.side)
            # By less a coupling that just holds is beyond its torque in rounding.
            if coupling is not None and self._margin(event, *self._now)[0] < -1e-9 * coupling.torque:
                self._switch(event)
                return True
        return False

    def _switch(self, event: TrainEvent) -> None:
        """Go on after an event of the drive train."""
        assert self.train is not None
        assert self.mode is not None
        torque = float(self._equations().held_torque(event, *self._now)[0][0]) if event.kind == "slips" else 0.0
        y, v = np.split(self.state, 2)
        mode, rates = self.train.after(event, self.mode, self.time, v, torque)
        self.state = np.concatenate([y, rates])
        self._go_on_in(mode, event)

    def _go_on_in(self, mode: TrainMode, event: MotionEvent) -> None:
        """Go on in another mode of the drive train, after an event."""
        if mode == self.mode:
            return
        self.at_once = self.at_once + 1 if self.time <= self.knots[-1] else 0
        if self.at_once > 12:  # modes without time between them: they switch to and fro
            raise failure("chatters", self.time, self.angle)
        assert self.train is not None
        self.mode, self.edges = mode, np.unique([*self.edges, *self.train.risen(mode)])
        self._begin(event, self._places_now())

    def _cross(self, passing: _Passing) -> None:
        """Go on after an event."""
        event, places = passing.event, self._places_now()
        if isinstance(event, TrainEvent):
            self._switch(event)
            return
        if isinstance(event, Release):
            law = self.pieces[-1].laws[event.force]
            if isinstance(law, ForceInterval):
                self.lost[event.force] = law
            self.phase = self.task.strokes.release(self.phase, event.force)
        elif event.path == CRANK_ANGLE:
            self.arrived = event.value == self.goal
            if not self.arrived:
                self._turn(event.value)
            return
        else:
            # A billionth of the linkage's size past the border: rounding must not decide what acts there.
            places[event.path] = event.value + np.copysign(1e-9 * self.task.equations.sprung.press.size, passing.rise)
            self.phase = self.task.strokes.advance(self.phase, places)
        self._begin(event, places)

    def _begin(self, event: MotionEvent, places: Array) -> None:
        """Begin a new segment where other forces act."""
        segment = self.task.strokes.active(self.phase, places, self.time)
        last = self.pieces[-1]
        if segment == last.segment and self.mode == last.mode:
            return
        piece = _Piece(self.mode, segment, self._strike(segment))
        if not self.windows or self.windows[-1][1] < len(self.pieces) - 1:  # nothing has moved in the piece before
            self.pieces.pop()
        else:
            self.events[len(self.knots)] = event
            self.knots.append(self.time)
            self.lengths[_acting(last.segment)] = self.length
            self.length = self.lengths.get(_acting(segment), self.length)
        self.pieces.append(piece)
        self.lost = {number: law for number, law in self.lost.items() if self.phase.through[number]}

    def _strike(self, segment: Segment) -> Segment:
        """The intervals of a new segment; contacts by Hertz with the speed at which they are struck now."""
        laws, speeds = list(segment), None
        for number, interval in enumerate(segment):
            if not isinstance(interval, HertzContact):
                continue
            last = self.pieces[-1]
            if last.segment[number] is interval or number in self.lost:  # it goes on
                laws[number] = self.lost.get(number, last.laws[number])
                continue
            speeds = self.task.equations.places(*self._now)[1][0] if speeds is None else speeds
            laws[number] = interval.struck(abs(float(speeds[self.task.strokes.forces[number].row])))
        return tuple(laws)

    def _take(self, window: PanelSolution) -> None:
        self.windows.append((window, len(self.pieces) - 1))
        self.time, self.state = float(window.mesh.knots[-1]), window.states[-1]
        self.acceleration = window.accelerations[-1, -1]
        if self.task.equations.crank is not None:
            return
        if self.train is not None and (self.train.driven.clutch or self.train.driven.brake):
            self.farthest = self.direction * max(self.direction * self.farthest, self.direction * self.angle)
            # A crank that its brake holds swings a little with the links.
            backwards = self.direction * (self.farthest - self.angle) > 0.01
        else:
            backwards = not (self.direction * window.states[:, -1] > 0).all()
        if backwards:
            raise failure("crank rests", self.time, self.angle)

    def join(self) -> ElasticSolution:
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
        modes = tuple(piece.mode for piece in self.pieces if piece.mode is not None)
        laws = tuple(piece.laws for piece in self.pieces)
        equations = replace(self.task.equations, segments=laws, modes=modes, events=self.events)
        return ElasticSolution(equations, panels, None, evaluations)


def _acting(segment: Segment) -> tuple[bool, ...]:
    return tuple(interval is not None for interval in segment)


def cut_to(near: PanelSolution, mesh: Mesh) -> PanelSolution:
    """The first part of a motion, as a guess on other panels."""
    y, v, _ = near.at(mesh.borders)
    _, _, a = near.at((mesh.start[:, None] + mesh.length[:, None] * near.rule.points).ravel() - 1e-12 * mesh.length[0])
    accelerations = a.reshape(len(mesh.start), len(near.rule.points), -1)
    return PanelSolution(mesh, near.rule, np.concatenate([y, v], axis=1), accelerations, np.inf, 0, near.passage)
