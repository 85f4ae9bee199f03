"""Elastic runs and steady states: what `simulate` and `steady_state` do where ``elastic`` is given."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...common.errors import PinpressError
from ...common.quantities import Array
from ...linkage.linkage import Linkage
from ..driven_press import DrivenPress, GeneralizedForce, JointPosition
from ..failures import failure
from ..run import state_count
from ..solvers import SimulationProblem
from ..trajectory import Trajectory
from .description import Elastic
from .equations import ElasticEquations, HeldCrank
from .march import march
from .period import periodic, periodic_near
from .press.drive import drive_train
from .press.friction import bearing_friction
from .press.paths import LengthPath, LinePath, from_frame, load_path, refuse_on_flexible_links
from .press.plane import PlaneGeometry
from .press.sprung_press import SprungPress
from .resting import resting
from .run import ElasticRun, ElasticSegment, elastic_run, segment_of
from .strokes import Strokes
from .task import ElasticSolution, Task, largest_deflection

STABLE = 1.001  # largest factor by which a disturbance may grow in a period: without dampers it is 1 within rounding


RigidPeriod = Callable[[float], Trajectory]
"""Of a crank angle: the period of the rigid press under its drive from there on."""


def elastic_steady_state(
    driven: DrivenPress,
    sprung: SprungPress,
    speed: float,
    angle: float,
    points: int | None,
    tolerance: float,
    began: float,
    rigid_period: RigidPeriod,
    near: ElasticRun | None = None,
) -> ElasticRun:
    """One period of a press on its springs; see `steady_state`.

    Args:
        driven: the press with drive and loads.
        sprung: the press on its springs; that of ``near`` where there is one.
        speed: of the crank, or near which it is sought under a drive [rad/s].
        angle: of the crank at the start [rad].
        points: number of states returned.
        tolerance: error of a coordinate, as a share of the largest displacement.
        began: time of the clock at which the call began [s].
        rigid_period: where there is a drive, what is near the motion sought.
        near: the steady state of the same press, springs and loads at another constant speed, from which this one is found if it can be.
    """
    if driven.prescribed is not None and driven.prescribed.speed != speed:
        raise PinpressError(f"speed is {speed:g}, but the drive prescribes {driven.prescribed.speed:g} rad/s: give the same")
    before = None if near is None else segment_of(near).solution
    if before is not None:
        driven = replace(driven, forces=before.equations.driven.forces)  # segments are compared by the intervals of these
    task, start = _task(driven, sprung, speed, angle, tolerance, steady=True)
    if driven.prescribed is None:
        task = _free(task, rigid_period(start), task.tolerance / tolerance)
    solution = None if before is None else periodic_near(task, start, before)
    if solution is None or solution.decay > STABLE:
        solution = periodic(task, start)
    if solution.decay > STABLE:
        raise failure("unstable stroke", decay=solution.decay)
    segment = _from_angle(solution, task, start, angle)
    first = segment.states(np.zeros(1))
    problem = SimulationProblem(driven, "elastic", np.array([angle]), first.crank[1], segment.end, tolerance)
    return elastic_run(problem, segment, state_count(points, abs(task.speed) * task.period / (2 * np.pi)), began)


def _from_angle(solution: ElasticSolution, task: Task, start: float, angle: float) -> ElasticSegment:
    """A period from a crank angle on; ``start``: that at which the solution begins."""
    knots = solution.panels.mesh.knots
    period = float(knots[-1] - knots[0])
    ahead = (np.sign(task.speed) * (angle - start)) % (abs(task.speed) * task.period)
    first = float(ahead) / abs(task.speed)
    if solution.equations.crank is None:
        borders, angles = solution.panels.mesh.borders, np.abs(solution.panels.states[:, task.equations.size - 1] - start)
        first = float(np.interp(ahead, angles, borders))
        for _ in range(6):  # Newton's method, from a place on the right panel
            y, v, _ = solution.panels.at(np.array([first]))
            first = min(max(first - float((abs(y[0, -1] - start) - ahead) / abs(v[0, -1])), 0.0), period)
    return ElasticSegment(solution, first, period, angle)


def elastic_simulation(
    problem: SimulationProblem, sprung: SprungPress, points: int | None, began: float, progress: Callable[[float], None] | None
) -> ElasticRun:
    """A run of a press on its springs; see `simulate`.

    Args:
        problem: what is simulated.
        sprung: the press on its springs.
        points: number of states returned.
        began: time of the clock at which the call began [s].
        progress: called with the time reached [s].
    """
    driven, angle, begins, until = problem.driven, float(problem.angle[0]), float(problem.speed[0]), problem.until
    speed = begins or _speed_ahead(driven)
    task, start = _task(driven, sprung, speed, angle, problem.tolerance, steady=False)
    if driven.prescribed is None:
        task = _free(task, None, task.tolerance / problem.tolerance)._replace(begins=begins / speed)
    solution = march(task, start, resting(task, start), until, progress=progress)
    segment = ElasticSegment(solution, 0.0, until, angle)
    return elastic_run(replace(problem, method="elastic"), segment, state_count(points, segment.travelled / (2 * np.pi)), began)


def _speed_ahead(driven: DrivenPress) -> float:
    """Speed with which a crank that stands will turn: that of the flywheel, which its clutch lets turn before it [rad/s]."""
    flywheel = driven.flywheel
    if driven.clutch is None or flywheel is None or not flywheel.speed:
        raise PinpressError(
            "speed is 0: an elastic motion is that of a crank that turns; give its speed at the start [rad/s], or a clutch that takes it"
            " along, and a Flywheel with its own speed"
        )
    return flywheel.speed


def _task(driven: DrivenPress, sprung: SprungPress, speed: float, angle: float, tolerance: float, steady: bool) -> tuple[Task, float]:
    """What is to be found for a crank at a constant speed, and the crank angle at which the solution begins: for a steady state one at
    which the rigid press turns."""
    _refuse_unsuitable(driven, sprung.elastic)
    if steady and sprung.open_pins:
        raise PinpressError(
            "a press with clearance has no steady state: its journals strike differently in each turn; let it run with simulate, and look"
            " at the peaks of its turns"
        )
    if (driven.clutch is not None or driven.brake is not None) and not sprung.geometry.constant_mass:
        raise PinpressError(
            "clutch and brake are for presses in a plane whose links do not bend: what holds them takes no inertia that depends on the pose"
            " yet; leave them out, or the flexible links"
        )
    strokes = Strokes(driven, 1 if speed > 0 else -1, _contacts(driven, sprung))
    turning = float(strokes.turnings[0]) if len(strokes.turnings) else angle
    deflection = largest_deflection(_task_from(turning, sprung.fixed or sprung, strokes, speed), turning)
    _refuse_soft(driven.press, deflection)
    # Floating point does not resolve smaller errors; in space they come through the products of rotation matrices.
    rounding = 1e-15 if isinstance(sprung.geometry, PlaneGeometry) else 1e-11
    error = max(tolerance * deflection, rounding * driven.press.size)
    start = turning if steady else angle
    return _task_from(start, sprung, strokes, speed)._replace(tolerance=error), start


def _task_from(start: float, sprung: SprungPress, strokes: Strokes, speed: float) -> Task:
    """The task from a crank angle on, without a tolerance."""
    press, driven = sprung.press, strokes.driven
    if press.period_turns is None:
        raise PinpressError(f"the crank of {press.name} does not turn fully: an elastic motion is that of a crank that does")
    paths = tuple(load_path(sprung, coordinate) for coordinate in driven.coordinates)
    refuse_on_flexible_links(sprung, paths)
    if sprung.geometry.base is not None:
        paths = from_frame(sprung, paths, isinstance(driven.coordinates[0], JointPosition))
    paths += tuple(LengthPath(pin.bodies, pin.arms, sign=-1.0) for pin in sprung.open_pins)
    paths += tuple(LinePath(sprung.geometry.with_lines([joint.spring])) for joint in sprung.open_joints)

    def rigid(times: Array) -> tuple[Array, Array, Array]:
        y, v, a = sprung.rigid(start + speed * times, speed)
        return y[:, :-1], v[:, :-1], a[:, :-1]

    period = 2 * np.pi * press.period_turns / abs(speed)
    gain = _gain(*rigid(np.array([0.0, period]))[0])
    friction = None if driven.friction is None else bearing_friction(sprung, driven.friction, speed)
    equations = ElasticEquations(sprung, driven, paths, HeldCrank(start, speed), contacts=strokes.contacts, friction=friction)
    return Task(equations, strokes, rigid, period, speed, gain, 0.0)


def _contacts(driven: DrivenPress, sprung: SprungPress) -> tuple[GeneralizedForce, ...]:
    """The contacts of pins with clearance and of members of preloaded joints, on paths after those of the loads."""
    contacts, first = [], len(driven.coordinates)
    for row, pin in enumerate(sprung.open_pins, first):
        both = (pin.contact(),)
        contacts.append(GeneralizedForce(row, -pin.clearance.radial, both, both))
    for row, joint in enumerate(sprung.open_joints, first + len(sprung.open_pins)):
        for member in joint.contacts():
            both = (member,)
            contacts.append(GeneralizedForce(row, 0.0, both, both))
    return tuple(contacts)


def _free(task: Task, period: Trajectory | None, displacement: float) -> Task:
    """The task of a crank that its drive turns.

    Args:
        task: of the same crank at a constant speed.
        period: of the rigid press under its drive; None: it is not known.
        displacement: to which errors of coordinates are compared [m or rad].
    """
    equations, crank, driven = task.equations, task.equations.crank, task.equations.driven
    assert crank is not None
    until = task.period if period is None else period.segments[-1].end
    train = drive_train(driven, crank.speed, until, displacement)

    def rigid(times: Array) -> tuple[Array, Array, Array]:
        if period is None:
            angle, speed, acceleration = crank.angle + crank.speed * times, np.full(len(times), crank.speed), np.zeros(len(times))
        else:
            sample = period.at(times)
            angle, speed, acceleration = sample.position[0], sample.speed[0], sample.acceleration[0]
        y, v, a = (np.pad(values, ((0, 0), (train.count, 0))) for values in equations.sprung.rigid(angle, speed, acceleration))
        if period is not None and train.scale:
            states = sample.drive_states
            assert driven.drive is not None
            v[:, : len(states)] = np.transpose(states) * train.scale
            a[:, : len(states)] = np.transpose(np.array(driven.drive.rates(speed, angle, times, tuple(states)))) * train.scale
        return y, v, a

    speed = crank.speed * task.period / until
    gain = _gain(*rigid(np.array([0.0, until]))[0])
    equations = replace(equations, crank=None, train=train, direction=1 if speed > 0 else -1)
    return task._replace(equations=equations, rigid=rigid, period=until, speed=speed, gain=gain)


def _gain(first: Array, last: Array) -> Array:
    """(2 f,) what coordinates and rates gain in a period: links whole turns, and others nothing."""
    gained = np.round((last - first) / np.pi) * np.pi
    return np.concatenate([gained, np.zeros(len(gained))])


def _refuse_soft(press: Linkage, deflection: float) -> None:
    """Raise PinpressError where the springs would let the linkage fall apart; ``deflection``: the largest of a coordinate [m or rad]."""
    if not deflection <= 0.1 * min(1.0, press.size):  # shares of the linkage's size, and turns in rad
        raise PinpressError(
            f"the springs of {press.name} are too soft for what acts on them: links would be displaced by about {1e3 * deflection:.3g} mm"
            f" (or turned by as many thousandths of a radian), in a linkage of {1e3 * press.size:.3g} mm; give stiffnesses in N/m, which"
            " are 1000 times those in N/mm, and 1e8 to 1e10 for bearings of presses"
        )


def _refuse_unsuitable(driven: DrivenPress, elastic: Elastic) -> None:
    if elastic.stiffness.shaft is not None and driven.clutch is not None:
        raise PinpressError("a shaft that twists has no clutch at its end, whose driven side would have no inertia: leave out one of them")
    for name, part in (("clutch", driven.clutch), ("brake", driven.brake), ("friction", driven.friction)):
        if part is not None and "plane" not in driven.press.engines:
            raise PinpressError(f"{driven.press.name} moves in space, where an elastic motion has no {name}: leave it out")
    if elastic.stiffness.shaft is not None and driven.prescribed is None and not driven.inertia > 0:
        raise PinpressError("a shaft that twists needs an inertia on its drive's side: give a flywheel, or a drive with inertia")
