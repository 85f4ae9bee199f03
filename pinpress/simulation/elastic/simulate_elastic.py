"""Elastic runs and steady states: what `simulate` and `steady_state` do where ``elastic`` is given."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...common.errors import PinpressError
from ...common.quantities import Array
from ...kinematics.motion import motion_through_change_points
from ..driven_press import DrivenPress, GeneralizedForce
from ..run import state_count
from ..solvers import SimulationProblem
from .assembly import coordinates_of, sprung_press
from .description import Elastic
from .elastic_run import ElasticRun, ElasticSegment, elastic_run
from .equations import ElasticEquations, HeldCrank
from .load_paths import LengthPath, load_path
from .phases import LoadPhases
from .solution import Task, largest_deflection, march, periodic, resting
from .sprung_press import SprungPress

ROUNDING = 1e-15  # smallest error of a coordinate that floating point tells [lengths of the linkage]


def elastic_steady_state(
    driven: DrivenPress, elastic: Elastic, speed: float, angle: float, points: int | None, tolerance: float, began: float
) -> ElasticRun:
    """One period of a press on its springs; see `steady_state`.

    Args:
        driven: the press with drive and loads.
        elastic: what yields.
        speed: of the crank [rad/s].
        angle: of the crank at the start [rad].
        points: number of states returned.
        tolerance: error of a coordinate [lengths of the linkage].
        began: time of the clock at which the call began [s].
    """
    if driven.prescribed is not None and driven.prescribed.speed != speed:
        raise PinpressError(f"speed is {speed:g}, but the drive prescribes {driven.prescribed.speed:g} rad/s: give the same")
    task, start = _task(driven, elastic, speed, angle, tolerance, steady=True)
    solution = periodic(task, start)
    first = float(((angle - start) / speed) % task.period)
    problem = SimulationProblem(driven, "elastic", np.array([angle]), np.array([speed]), task.period, tolerance)
    turns = abs(speed) * task.period / (2 * np.pi)
    return elastic_run(problem, ElasticSegment(solution, first, task.period, task.gain, angle), elastic, state_count(points, turns), began)


def elastic_simulation(problem: SimulationProblem, elastic: Elastic, points: int | None, began: float) -> ElasticRun:
    """A run of a press on its springs; see `simulate`.

    Args:
        problem: what is simulated.
        elastic: what yields.
        points: number of states returned.
        began: time of the clock at which the call began [s].
    """
    angle, speed, until = float(problem.angle[0]), float(problem.speed[0]), problem.until
    task, start = _task(problem.driven, elastic, speed, angle, problem.tolerance, steady=False)
    solution = march(task, start, resting(task, start), until)
    turns = abs(speed) * until / (2 * np.pi)
    problem = replace(problem, method="elastic")
    return elastic_run(problem, ElasticSegment(solution, 0.0, until, task.gain, angle), elastic, state_count(points, turns), began)


def _task(driven: DrivenPress, elastic: Elastic, speed: float, angle: float, tolerance: float, steady: bool) -> tuple[Task, float]:
    """What is to be found, and the crank angle at which the solution begins: for a steady state one at which the rigid press turns."""
    _refuse_unsuitable(driven)
    sprung = sprung_press(driven.press, elastic)
    if steady and sprung.open_pins:
        raise PinpressError(
            "a press with clearance has no steady state: its journals strike differently in each turn; let it run with simulate, and look"
            " at the peaks of its turns"
        )
    phases = LoadPhases(driven, 1 if speed > 0 else -1, _contacts(driven, sprung))
    turning = float(phases.turnings[0]) if len(phases.turnings) else angle
    from_turning = _task_from(turning, sprung, phases, speed)
    error = max(tolerance * largest_deflection(from_turning, turning), ROUNDING * driven.press.size)
    task, start = (from_turning, turning) if steady else (_task_from(angle, sprung, phases, speed), angle)
    return task._replace(tolerance=error), start


def _task_from(start: float, sprung: SprungPress, phases: LoadPhases, speed: float) -> Task:
    """The task from a crank angle on, without a tolerance."""
    press, driven = sprung.press, phases.driven
    if press.period_turns is None:
        raise PinpressError(f"the crank of {press.name} does not turn fully: an elastic motion is that of a crank that does")
    paths = tuple(load_path(press, coordinate) for coordinate in driven.coordinates)
    paths += tuple(LengthPath(pin.bodies, pin.arms, 0.0, -1.0) for pin in sprung.open_pins)

    def rigid(times: Array) -> tuple[Array, Array, Array]:
        found = coordinates_of(sprung, motion_through_change_points(press, start + speed * times, speed))
        return sprung.free_coordinates(found[0])[:, :-1], sprung.free_rates(found[1])[:, :-1], sprung.free_rates(found[2])[:, :-1]

    period = 2 * np.pi * press.period_turns / abs(speed)
    ends = rigid(np.array([0.0, period]))[0]
    gained = np.round((ends[1] - ends[0]) / np.pi) * np.pi  # whole turns of links, and of others nothing
    gain = np.concatenate([gained, np.zeros(len(gained))])
    equations = ElasticEquations(sprung, driven, paths, HeldCrank(start, speed), contacts=phases.contacts)
    return Task(equations, phases, rigid, period, speed, gain, 0.0)


def _contacts(driven: DrivenPress, sprung: SprungPress) -> tuple[GeneralizedForce, ...]:
    """The contacts of pins with clearance, on paths after those of the loads."""
    found = []
    for number, pin in enumerate(sprung.open_pins):
        both = (pin.contact(),)
        found.append(GeneralizedForce(len(driven.coordinates) + number, -pin.clearance.radial, both, both))
    return tuple(found)


def _refuse_unsuitable(driven: DrivenPress) -> None:
    if driven.prescribed is None:
        raise PinpressError("an elastic motion is that of a crank at constant speed: give drive=PrescribedSpeed(...)")
    if driven.friction is not None:
        raise PinpressError("an elastic motion has no friction: leave it out")
    if any(force.time is not None for force in driven.forces):
        raise PinpressError("an elastic motion takes loads by the slide's height, no TimeForce")
