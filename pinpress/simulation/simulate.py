"""Forward dynamics: a press under motor, flywheel and process load.

    run = pp.simulate(press, duration=2.0, speed=70 * pp.RPM, flywheel=pp.drives.Flywheel(inertia=2000.0))

Two sets of equations give the same run. ``"reduced"`` integrates the one-degree-of-freedom equation (see `reduced_model`): over the crank
angle, all of a period at once, while the crank turns. It integrates over time where the crank may stop, or where a clutch, a drive's own
states or forces in time demand it. ``"implicit"`` integrates the same equation over time alone, by Radau IIA.
``"constraint"`` integrates all joints, with the loops closed again after every step: any linkage. Its accelerations are those of
Pinocchio's constraint dynamics, except with more than two gear pairs, gear pairs that depend on the loops, or links without mass: see
`forward_dynamics`, and `Run.constraint_solution`, which says what found them.
``"auto"`` is ``"reduced"`` for one driver, else ``"constraint"``, as it is where a slide does not come back after a turn, and a spring on
it does not grow evenly. Over time each method takes explicit steps, or implicit ones where forces
are so stiff that these are faster: `Stats.solvers` says which.

Where a crank comes nearly to rest near an unstable rest, such as a dead centre at the top, rounding decides whether it goes on or turns
back, and the energy balance does not show it. A run that passes such a place is repeated from starts moved by its tolerance, and the
difference is reported: `Stats.sensitivity`.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, overload

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import in_unit, number, numbers, suitable_numbers, typed
from ..common.errors import PinpressError, SimulationError, caution, shown
from ..common.parameters import refuse_scenarios
from ..common.quantities import Array
from ..drives.motors import ServoMotor
from ..drives.protocol import Drive
from ..drives.transmission import Brake, Clutch, Flywheel, Geared, PrescribedSpeed
from ..dynamics.inverse_dynamics import NONE_GIVEN
from ..kinematics.cycle import doubt_speeds
from ..linkage.assembly import refuse_far
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load
from ..loads.link import law as friction_law
from .driven_press import DriveByFunction, DrivenPress, MotorFunction, driven_press, is_motor_function, motor_against
from .elastic.description import Elastic
from .failures import name_driver_in_errors
from .law_trials import tried
from .over_angle.segment import AngleSegment
from .run import Run, as_run, state_count
from .sensitivity import start_sensitivity
from .solvers import SimulationProblem, checked_tolerance, march, refuse_many_turns
from .trajectory import Trajectory

if TYPE_CHECKING:
    from .elastic.run import ElasticRun

METHODS = ("auto", "reduced", "implicit", "constraint")


@overload
def simulate(
    press: Linkage,
    duration: float,
    *,
    speed: ArrayLike = ...,
    angle: ArrayLike | None = ...,
    drive: Drive | PrescribedSpeed | Mapping[str, Drive | PrescribedSpeed] | MotorFunction | None = ...,
    flywheel: Flywheel | Mapping[str, Flywheel] | None = ...,
    clutch: Clutch | None = ...,
    brake: Brake | None = ...,
    loads: Sequence[Load] = ...,
    friction: Mapping[str, Friction] = ...,
    method: str = ...,
    points: int | None = ...,
    elastic: Elastic,
    tolerance: float | None = ...,
    step: float | None = ...,
    progress: Callable[[float], None] | None = ...,
) -> ElasticRun: ...


@overload
def simulate(
    press: Linkage,
    duration: float,
    *,
    speed: ArrayLike = ...,
    angle: ArrayLike | None = ...,
    drive: Drive | PrescribedSpeed | Mapping[str, Drive | PrescribedSpeed] | MotorFunction | None = ...,
    flywheel: Flywheel | Mapping[str, Flywheel] | None = ...,
    clutch: Clutch | None = ...,
    brake: Brake | None = ...,
    loads: Sequence[Load] = ...,
    friction: Mapping[str, Friction] = ...,
    method: str = ...,
    points: int | None = ...,
    elastic: None = None,
    tolerance: float | None = ...,
    step: float | None = ...,
    progress: Callable[[float], None] | None = ...,
) -> Run: ...


@typed
def simulate(
    press: Linkage,
    duration: float,
    *,
    speed: ArrayLike = 0.0,
    angle: ArrayLike | None = None,
    drive: Drive | PrescribedSpeed | Mapping[str, Drive | PrescribedSpeed] | MotorFunction | None = None,
    flywheel: Flywheel | Mapping[str, Flywheel] | None = None,
    clutch: Clutch | None = None,
    brake: Brake | None = None,
    loads: Sequence[Load] = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    method: str = "auto",
    points: int | None = None,
    elastic: Elastic | None = None,
    tolerance: float | None = None,
    step: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Run:
    """Let a press run. `simulate_batch` runs several scenarios at once.

    A linkage with several drivers takes (drivers,) of ``speed`` and ``angle``, and drives (without states of their own) and flywheels by
    the names of the drivers' joints; its method is "auto" or "constraint". A `PrescribedSpeed` holds a motor at a constant speed, whatever
    the others do. Passive coordinates (`Linkage.passive`) have no drive, and springs of the file act in any run. With (motors,) of
    ``speed`` and ``angle`` the passive coordinates begin at rest, where the linkage was put together.

    Args:
        press: the linkage.
        duration: of the run [s].
        speed: of the crank at the start [rad/s], of a driver that slides [m/s].
        angle: of the crank at the start [rad], of a driver that slides its position [m]; by default where the linkage was put together,
            0 in the drawn pose.
        drive: what turns the crank, see `pinpress.drives`; None: nothing. On a driver that slides a `ConstantTorque` is a force [N], and a
            motor acts through a screw, ``Geared(motor, ratio=2 * pi / lead)`` with the lead in m a turn. Or a function
            of time [s], positions (motors,) [rad or m] and speeds (motors,) [rad/s or m/s] that returns the efforts of all motors,
            (motors,) [N m or N], such as a controller; the same arguments always give the same efforts.
        flywheel: its inertia stands at the driver joint, on the drive's side of a clutch.
        clutch: between flywheel and crank; None: they turn together.
        brake: on the crank.
        loads: process loads of `pinpress.loads`, constant forces on links, springs and dampers.
        friction: friction of bearings and guides, by their names, as in `inverse_dynamics`, of a press with one driver. A press that it
            stops stands until the drive overcomes it.
        method: "reduced": one equation over the crank angle, over time where the crank may stop; "implicit": the same equation over time,
            by Radau IIA; "constraint": all joints, of any linkage; "auto": "reduced" for one driver, else "constraint". Where a linkage
            locks, "constraint" runs on through the lock, and the others end with an error.
        points: number of states returned; by default 120 a turn, and at least 120.
        elastic: springs and dampers of bearings, guides, rods, shaft and frame; None: all parts are rigid. The result is then an
            `ElasticRun`. At its start the springs carry what acts on them, so that nothing rings yet. The crank turns one way, or stands
            where a brake holds it; the method is "auto".
        tolerance: error accepted of a step, relative to 1 rad and to the speeds of the crank, by default 1e-11. With ``elastic`` that of
            a coordinate on a panel, as a share of the largest displacement, by default 1e-5.
        step: fixed step of the classical Runge-Kutta method over time [s]; None: steps by error.
        progress: called with the time reached [s], from time to time.

    Raises:
        PinpressError: an argument makes no sense.
        SimulationError: the press stalls, runs against a lock, or has no inertia, or the energy does not balance. The error says when,
            where, and for which reason of `failures`.

    Warns:
        PinpressWarning: numbers of drives, loads and speeds that are probably a mistake; a press that stands at the end; a driver that
            moves at the start, where the program of its `ServoMotor` stands still; an asynchronous motor whose own direction is against the
            run; a slide that swings back and comes down again on what it has worked already.
    """
    began = clock.perf_counter()
    if elastic is not None and (_method(press, method) != "reduced" or step is not None) and len(press.drivers) == 1:
        raise PinpressError("an elastic motion has a method and steps of its own: leave out method and step")
    by_caller, method = method, _method(press, method)
    until = number("duration", duration, "s", positive=True)
    error = checked_tolerance(tolerance, elastic is not None)
    fixed = _fixed_step(step, until)
    state_count(points, 0.0)
    loads = list(loads)  # of what is gone through once, too
    if len(press.drivers) == 1:
        refuse_scenarios("simulate", speed, (drive, flywheel, *loads))
    home = press.closed[list(press.driver_indices)]
    angles, speeds = _start(press, "angle", angle, home), _start(press, "speed", speed, 0.0 * home, "/s")
    if is_motor_function(drive) and len(press.drivers) == 1:
        drive = DriveByFunction(drive)
    drive, loads = tried(drive, loads, float(np.abs(speeds).max()))
    refuse_far("angle", angles, press.driver_coordinates)
    refuse_many_turns(speeds, until, float(angles[0]))
    with name_driver_in_errors(press), np.errstate(all="ignore"):  # what is not finite is refused where it arises
        driven = _driven(press, method, drive, flywheel, loads, clutch, brake, friction)
        if by_caller == "auto" and not is_reducible(driven):
            method = "constraint"
        if (law := driven.law) is not None:  # what is wrong with it is said of the start
            law.efforts(0.0, angles[: len(law.rows)], speeds[: len(law.rows)])
        problem = _problem(driven, method, angles, speeds, until, error, fixed)
        doubt_speeds(press, problem.speed)
        _doubt_programs(press, drive, problem.speed)
        if driven.prescribed is None and len(press.drivers) == 1:
            of_flywheel = None if driven.clutch is None or driven.flywheel is None else driven.flywheel.speed
            doubt_motor(press, drive, problem.speed if of_flywheel is None else np.array([of_flywheel]))
        if elastic is not None:
            from .elastic.press.assembly import opening_press  # with the next one a third of what a rigid run imports of ours
            from .elastic.simulate_elastic import elastic_simulation

            return elastic_simulation(problem, opening_press(press, elastic), points, began, progress)
        trajectory = march(problem, progress)
        run = as_run(problem, trajectory, points, began, start_sensitivity(problem, trajectory))
    _doubt_second_strokes(trajectory)
    if (since := trajectory.standing) is not None:
        _tell_of_standstill(run, since)
    return run


def _doubt_programs(
    press: Linkage, drive: Drive | PrescribedSpeed | Mapping[str, Drive | PrescribedSpeed] | MotorFunction | None, speeds: Array
) -> None:
    """Warn of servo motors whose program stands still where the run begins, though their driver moves there."""
    drives = drive if isinstance(drive, Mapping) else {press.driver: drive}
    for driver, coordinate, speed in zip(press.drivers, press.driver_coordinates, speeds, strict=True):
        motor = part.drive if isinstance(part := drives.get(driver), Geared) else part
        if isinstance(motor, ServoMotor) and speed and motor.times[0] >= 0.0:
            unit, size = coordinate.shown_speed
            caution(
                f"the run begins with {speed / size:.4g} {unit} of {driver}, where its ServoMotor's program stands still: begin the program"
                " before 0 s, or the run at rest"
            )


def doubt_motor(press: Linkage, drive: object, speeds: Array) -> None:
    """Warn of a motor whose own direction is against that of a press that runs at the start, at ``speeds`` (n,) in n scenarios.

    A press that runs is near the motor's no-load speed. What turns back at less than half of that may well be meant so.
    """
    against = motor_against(press, drive, float(max(speeds, key=abs)))
    if against is not None and against.share > 0.5:
        caution(
            f"the motor turns the other way: without load the {against.motor} turns the driver at {against.idle}, but the run begins with"
            f" {against.speed}, so that it brakes the press and turns it back; if that is not meant, write {against.remedy}"
        )


def _doubt_second_strokes(trajectory: Trajectory) -> None:
    """Warn of a slide that works on its way down, swings back, and turns down again before it has left the heights of its load."""
    way, worked = 0, False  # direction of the crank so far, and whether a load that acts one way may have acted on the way down
    for segment in trajectory.segments:
        if isinstance(segment, AngleSegment):
            way, worked = int(np.sign(segment.begin.speed or segment.final_speed)), True
        system = getattr(segment, "system", None)  # of a `TimeSegment`, whose module imports SciPy's integrators
        if system is None:
            continue
        for start, mode in zip(segment.borders, segment.modes, strict=False):  # type: ignore[attr-defined]
            forces = zip(system.driven.forces, mode.forces, strict=True)
            works = any(place is not None and place.interval and not place.rising and force.works_once for force, place in forces)
            if works and worked and way and mode.way == -way:
                caution(
                    f"the slide turns down again at {start:.6g} s within the heights of a load that acts on the way down: a rigid run"
                    " meets there what it has worked already, as if it were new; end the run before, or leave the load out of the rest"
                )
                return
            way, worked = mode.way or way, worked or works


def _tell_of_standstill(run: Run, since: float) -> None:
    """Warn of a press that stands from a time [s] to the end, unless it has run down by friction, or struck, without a drive."""
    driven = run.problem.driven
    if driven.drive is None and (driven.friction is not None or driven.press.advancing.any()):
        return
    what = "load" if driven.friction is None else "friction" if not driven.forces else "friction and load"
    place = run.driver_coordinates[0].at(run.crank_angle[-1])
    holds = "hold" if " and " in what else "holds"
    caution(f"the press stands from {since:.6g} s to the end, at {place}: the {what} {holds} it there against the drive")


def _method(press: Linkage, given: str) -> str:
    """The method asked for; for "auto" the one that suits this press."""
    if not isinstance(given, str) or given not in METHODS:
        raise PinpressError(f"unknown method {shown(given)}: write {', '.join(map(repr, METHODS[:-1]))} or {METHODS[-1]!r}")
    if given == "auto":
        return "reduced" if len(press.drivers) == 1 else "constraint"
    return given


def is_reducible(driven: DrivenPress) -> bool:
    """Whether the reduced equation can have what acts on a press: not where a slide goes on from turn to turn along a spring, say."""
    if len(driven.press.drivers) > 1 or driven.friction is not None or not driven.press.advancing.any():
        return True
    try:
        return driven.model is not None
    except SimulationError as error:
        if error.reason == "does not come back":
            return False
        raise


def _fixed_step(given: float | None, until: float) -> float | None:
    """The step of the Runge-Kutta method [s]; raises PinpressError where the run would take too many steps."""
    if given is None:
        return None
    step, most = number("step", given, "s", positive=True), 1_000_000  # each step is kept in memory
    if step < until / most:
        raise PinpressError(f"step is {step:g} s: with it the run takes more than {most} steps; give a longer one, or a shorter duration")
    return step


def _driven(
    press: Linkage,
    method: str,
    drive: object,
    flywheel: object,
    loads: Sequence[Load],
    clutch: object,
    brake: object,
    friction: Mapping[str, Friction],
) -> DrivenPress:
    """The press with its parts. Raises as `driven_press`, and where the method does not suit several drivers or friction."""
    if method == "constraint" or len(press.drivers) > 1:
        if press.loses_power:
            press.refuse_contacts("their losses need one driver and method 'auto' or 'implicit'; leave efficiency and friction out of them")
        if friction_law(friction, press) is not None:
            press.refuse_several_drivers("their runs know no friction in bearings; leave it out, inverse_dynamics has it in a given motion")
            raise PinpressError(
                "method='constraint' has no friction in bearings, because that needs the bearing forces, which the reduced equation of one"
                " driver has; leave friction out, or let one driver turn with method='auto'"
            )
    if len(press.drivers) > 1 and method != "constraint":
        raise PinpressError(f"{press.name} has {len(press.drivers)} drivers: method='constraint' simulates it")
    return driven_press(press, drive, flywheel, loads, clutch, brake, friction)


def _problem(
    driven: DrivenPress, method: str, angles: Array, speeds: Array, until: float, tolerance: float, step: float | None
) -> SimulationProblem:
    """The problem of arguments that have been checked one by one.

    Raises:
        PinpressError: arguments contradict each other.
    """
    prescribed = driven.prescribed
    if prescribed is not None:
        if step is not None or any(force.time is not None for force in driven.forces):
            raise PinpressError(
                "a drive that prescribes the speed leaves nothing to integrate: leave step out; for forces in time use cycle and"
                " inverse_dynamics"
            )
        if speeds[0] not in (0.0, prescribed.speed):
            unit = driven.press.driver_coordinates[0].heads[1][1]
            raise PinpressError(f"speed is {speeds[0]:g}, but the drive prescribes {prescribed.speed:g} {unit}: leave speed out")
        method, speeds = "reduced", np.array([prescribed.speed])
    for name, part in driven.held.items():
        k = driven.press.drivers.index(name)
        if speeds[k] not in (0.0, part.speed):
            raise PinpressError(
                f"speed of {name} is {speeds[k]:g}, but its drive prescribes {part.speed:g}: leave it out, or write the same"
            )
        speeds[k] = part.speed
    if method == "implicit" and step is not None:
        raise PinpressError("step is of the classical Runge-Kutta method: leave it out with method='implicit'")
    return SimulationProblem(driven, method, angles, speeds, until, tolerance, step)


def _start(press: Linkage, name: str, value: ArrayLike | None, rest: Array, by: str = "") -> Array:
    """(drivers,) angles or speeds at the start, from one number or one of each driver; or from one of each motor, with ``rest`` (drivers,)
    for passive coordinates, and for all where nothing is given."""
    if value is None:
        return rest
    value = in_unit(name, value, press.driver_coordinates[0].unit + by)
    if len(press.drivers) == 1:
        return np.array([number(name, value)])
    if press.passive and (given := numbers(name, value)).shape == (len(press.motors),):
        value = np.concatenate([given, rest[len(press.motors) :]])
    wanted = f"finite numbers, one of each of the {len(press.drivers)} drivers"
    values = suitable_numbers(name, value, wanted, None, lambda values: values.shape in ((), (len(press.drivers),)))
    return np.broadcast_to(values, (len(press.drivers),)).copy()
