"""Forward dynamics: a press under motor, flywheel and process load.

    run = pp.simulate(press, duration=2.0, speed=70 * pp.RPM, flywheel=pp.drives.Flywheel(inertia=2000.0))

Two sets of equations give the same run. ``"reduced"`` integrates the one-degree-of-freedom equation (see `reduced`): over the crank angle,
all of a period at once, while the crank turns, and over time where it may stop, or where a clutch, a drive's own states or forces in time
demand it. ``"implicit"`` integrates the same equation over time alone, by Radau IIA.
``"constraint"`` integrates all joints, with the loops closed again after every step: any linkage. Its accelerations are those of
Pinocchio's constraint dynamics, but not with gear pairs, links without mass or loops that hold each other: see `forward_dynamics`.
``"auto"`` is the first where there is one driver, else the last. Over time each of them takes explicit steps, or implicit ones where forces
are so stiff that these get on faster: `Stats.solvers` says which.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import typed
from ..common.arrays import Array
from ..common.checks import finite_numbers, number
from ..common.errors import PinpressError, caution, shown
from ..common.parameters import refuse_scenarios
from ..drives.protocol import Drive
from ..drives.transmission import Brake, Clutch, Flywheel, PrescribedSpeed
from ..kinematics.configurations import refuse_far
from ..linkage.linkage import Linkage
from ..loads import caller_laws
from ..loads.link import Load
from .angle_solver import MOST_PERIODS
from .driven_press import driven_press, listed, press_with_drives
from .failures import failure
from .law_trials import asked_drive
from .run import Run, as_run, count_of
from .solvers import SimulationProblem, march
from .start_sensitivity import start_sensitivity

METHODS = ("auto", "reduced", "implicit", "constraint")
MOST_STEPS = 1_000_000  # of the Runge-Kutta method
LEAST_TOLERANCE = 1e-13


@typed
def simulate(
    press: Linkage,
    duration: float,
    speed: ArrayLike = 0.0,
    angle: ArrayLike = 0.0,
    drive: Drive | PrescribedSpeed | Mapping[str, Drive] | None = None,
    flywheel: Flywheel | Mapping[str, Flywheel] | None = None,
    loads: Sequence[Load] = (),
    method: str = "auto",
    clutch: Clutch | None = None,
    brake: Brake | None = None,
    points: int | None = None,
    step: float | None = None,
    tolerance: float = 1e-11,
    progress: Callable[[float], None] | None = None,
) -> Run:
    """Let a press run; several scenarios at once: `simulate_batch`.

    Args:
        press: the linkage.
        duration: of the run [s].
        speed: of the crank at the start [rad/s].
        angle: of the crank at the start [rad].
        drive: what turns the crank, see `pinpress.drives`; None: nothing.
        flywheel: its inertia stands at the driver joint, on the drive's side of a clutch.
        loads: process loads of `pinpress.loads`, constant forces on links, springs and dampers.
        method: "auto", "reduced", "implicit" or "constraint", see the module. Where a linkage locks the first three end, "constraint" runs
            on through the lock.
        clutch: between flywheel and crank; None: they turn together.
        brake: on the crank.
        points: number of states returned; by default 120 a turn, and at least 120.
        step: fixed step of the classical Runge-Kutta method over time [s]; None: steps by error.
        tolerance: of the error of a step, beside 1 rad and the speeds of the crank.
        progress: called with the time reached [s], now and then.

    A linkage with several drivers takes (drivers,) of ``speed`` and ``angle``, and drives (of torque by speed alone) and flywheels by the
    names of the drivers' joints; its method is "auto" or "constraint".

    Raises:
        PinpressError: an argument that makes no sense.
        SimulationError: the press stalls, runs against a lock, or has no inertia, or the energy does not balance: the error says when,
            where, and for which reason of `failures`.
    """
    began = clock.perf_counter()
    if not isinstance(press, Linkage):
        raise PinpressError(f"press is {shown(press)}: give a Linkage, as load returns it")
    if not isinstance(method, str) or method not in METHODS:
        raise PinpressError(f"unknown method {shown(method)}: write {', '.join(map(repr, METHODS[:-1]))} or {METHODS[-1]!r}")
    if method == "auto":
        method = "reduced" if len(press.drivers) == 1 else "constraint"
    until, tolerance = number("duration", duration, positive=True), tolerated(tolerance)
    fixed = None if step is None else number("step", step, positive=True)
    if fixed is not None and fixed < until / MOST_STEPS:
        raise PinpressError(
            f"step is {fixed:g} s: with it the run takes more than {MOST_STEPS} steps; give a longer one, or a shorter duration"
        )
    if progress is not None and (not callable(progress) or isinstance(progress, type)):
        raise PinpressError(f"progress is {shown(progress)}: give a function of the time reached [s]")
    count_of(points, 0.0)
    listed(loads)
    if len(press.drivers) == 1:
        refuse_scenarios("simulate", speed, (drive, flywheel, *loads))
    angles, speeds = _start(press, "angle", angle), _start(press, "speed", speed)
    drive, loads = asked_drive(drive, float(np.abs(speeds).max())), caller_laws.asked_loads(loads)
    refuse_far("angle", angles)
    refuse_long(speeds, until, float(angles[0]))
    plausibility.speeds("speed", speeds)
    with np.errstate(all="ignore"):  # what is not finite is refused where it arises
        problem = _problem(press, method, (drive, flywheel, loads, clutch, brake), angles, speeds, until, tolerance, fixed)
        trajectory = march(problem, progress)
        run = as_run(problem, trajectory, points, began, start_sensitivity(problem, trajectory))
    if (since := trajectory.standing) is not None:
        caution(
            f"the press stands from {since:.6g} s to the end, at crank angle {np.degrees(run.crank_angle[-1]):.6g} deg: the load holds it"
            " there against the drive"
        )
    return run


def _problem(
    press: Linkage,
    method: str,
    parts: tuple[object, object, Sequence[Load], object, object],
    angles: Array,
    speeds: Array,
    until: float,
    tolerance: float,
    step: float | None,
) -> SimulationProblem:
    """The problem of arguments that are checked one by one; ``parts``: drive, flywheel, loads, clutch, brake.

    Raises:
        PinpressError: parts that make no sense, or do not go together with each other or the method.
    """
    if len(press.drivers) > 1:
        if method != "constraint":
            raise PinpressError(f"{press.name} has {len(press.drivers)} drivers: method='constraint' simulates it")
        driven = press_with_drives(press, *parts)
    else:
        driven = driven_press(press, *parts)
    if driven.prescribed is not None:
        if step is not None or any(force.time is not None for force in driven.forces):
            raise PinpressError(
                "a drive that prescribes the speed leaves nothing to integrate: leave step out; for forces in time use cycle and"
                " inverse_dynamics"
            )
        if speeds[0] not in (0.0, driven.prescribed.speed):
            raise PinpressError(f"speed is {speeds[0]:g}, but the drive prescribes {driven.prescribed.speed:g} rad/s: leave speed out")
        method, speeds = "reduced", np.array([driven.prescribed.speed])
    if method == "implicit" and step is not None:
        raise PinpressError("step is of the classical Runge-Kutta method: leave it out with method='implicit'")
    return SimulationProblem(driven, method, angles, speeds, until, tolerance, step)


def refuse_long(speeds: Array, until: float, angle: float) -> None:
    """Raise SimulationError where the run would be too long to be kept."""
    if not float(np.abs(speeds).max()) * until <= 2 * np.pi * MOST_PERIODS:
        raise failure("too many turns", 0.0, angle, most=MOST_PERIODS)


def _start(press: Linkage, name: str, value: ArrayLike) -> Array:
    """(drivers,) numbers."""
    if len(press.drivers) == 1:
        return np.array([number(name, value)])
    given = finite_numbers(value)
    if given is None or given.shape not in ((), (len(press.drivers),)):
        raise PinpressError(f"{name} is {shown(value)}: give finite numbers, one of each of the {len(press.drivers)} drivers")
    return np.broadcast_to(given, (len(press.drivers),)).copy()


def tolerated(tolerance: float) -> float:
    """A tolerance, if it is one that can be kept."""
    value = number("tolerance", tolerance, positive=True)
    if not LEAST_TOLERANCE <= value <= 1e-2:
        raise PinpressError(f"tolerance is {value:g}: give one from {LEAST_TOLERANCE:g} to 0.01")
    return value
