"""Elastic runs and steady states: what `simulate` and `steady_state` do where ``elastic`` is given."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...common.errors import PinpressError, shown
from ...common.quantities import Array
from ...kinematics.motion import servo_cycle
from ...linkage.linkage import Linkage
from ..driven_press import DrivenPress
from ..run import state_count
from ..solvers import SimulationProblem
from .assembly import coordinates_of, sprung_press
from .description import Elastic
from .elastic_run import ElasticRun, ElasticSegment, elastic_run
from .equations import ElasticEquations, HeldCrank
from .load_paths import load_path
from .phases import LoadPhases
from .solution import RigidMotion, Task, march, periodic, resting

TOLERANCE = 1e-8  # error of a coordinate accepted by default [lengths of the linkage]


def elastic_steady_state(
    driven: DrivenPress, elastic: Elastic, speed: float, angle: float, points: int | None, tolerance: float | None
) -> ElasticRun:
    """One period of a press on its springs whose crank turns at a constant speed; see `steady_state`."""
    began, press = clock.perf_counter(), driven.press
    task, start = _task(driven, elastic, speed, angle, tolerance, steady=True)
    solution = periodic(task, start)
    first = float(((angle - start) / speed) % task.period)
    problem = SimulationProblem(driven, "elastic", np.array([angle]), np.array([speed]), task.period, task.tolerance)
    turns = abs(speed) * task.period / (2 * np.pi)
    return elastic_run(problem, ElasticSegment(solution, first, task.period, task.gain), elastic, state_count(points, turns), began)


def elastic_simulation(
    driven: DrivenPress, elastic: Elastic, speed: float, angle: float, duration: float, points: int | None, tolerance: float | None
) -> ElasticRun:
    """A run of a press on its springs; see `simulate`."""
    began = clock.perf_counter()
    task, start = _task(driven, elastic, speed, angle, tolerance, steady=False)
    solution = march(task, start, resting(task, start), duration)
    problem = SimulationProblem(driven, "elastic", np.array([angle]), np.array([speed]), duration, task.tolerance)
    turns = abs(speed) * duration / (2 * np.pi)
    return elastic_run(problem, ElasticSegment(solution, 0.0, duration, task.gain), elastic, state_count(points, turns), began)


def _task(driven: DrivenPress, elastic: Elastic, speed: float, angle: float, tolerance: float | None, steady: bool) -> tuple[Task, float]:
    """What is to be found, and the crank angle at which the solution begins."""
    press = driven.press
    _refuse_unsuitable(driven)
    sprung = sprung_press(press, elastic)
    paths = tuple(load_path(press, coordinate) for coordinate in driven.coordinates)
    phases = LoadPhases(driven, 1 if speed > 0 else -1)
    start = float(phases.turnings[0]) if steady and len(phases.turnings) else angle
    equations = ElasticEquations(sprung, driven, paths, HeldCrank(start, speed))

    def rigid(times: Array) -> tuple[Array, Array, Array]:
        motion = servo_cycle(press, angle=start + speed * times, speed=speed)
        found = coordinates_of(sprung, motion)
        return sprung.free_coordinates(found[0])[:, :-1], sprung.free_rates(found[1])[:, :-1], sprung.free_rates(found[2])[:, :-1]

    period = 2 * np.pi * press.period_turns / abs(speed)
    ends = rigid(np.array([0.0, period]))[0]
    gained = np.round((ends[1] - ends[0]) / np.pi) * np.pi  # whole turns of links, and of others nothing
    gain = np.concatenate([gained, np.zeros(len(gained))])
    return Task(equations, phases, rigid, period, speed, gain, TOLERANCE * press.size if tolerance is None else tolerance), start


def _refuse_unsuitable(driven: DrivenPress) -> None:
    if driven.prescribed is None:
        raise PinpressError("an elastic motion is that of a crank at constant speed: give drive=PrescribedSpeed(...)")
    if driven.friction is not None:
        raise PinpressError("an elastic motion has no friction: leave it out")
    if any(force.time is not None for force in driven.forces):
        raise PinpressError("an elastic motion takes loads by the slide's height, no TimeForce")
