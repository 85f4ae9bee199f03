"""The steady state of a loaded press: the periodic motion, found directly.

Where all depends on crank angle and speed, the kinetic energy over a period is solved for with the condition that it ends as it began (see
`collocation.solve`). A drive with states of its own is followed over periods, and Newton's method finds the speed and states that come
back.
"""

from __future__ import annotations

import time as clock
from collections.abc import Sequence

import numpy as np

from ..common import plausibility
from ..common.arguments import LARGEST, number, typed
from ..common.errors import PinpressError, SimulationError, shown
from ..common.parameters import refuse_scenarios
from ..common.quantities import Array
from ..drives.protocol import Drive
from ..drives.transmission import Flywheel
from ..kinematics.configurations import refuse_far
from ..linkage.linkage import Linkage
from ..loads import caller_laws
from ..loads.caller_laws import LawError
from ..loads.link import Load
from . import collocation
from . import reduced_model as reduced
from .angle_solver import angle_segment
from .collocation import build_mesh, cuts, interpolate_onto, mesh_borders, stopping_panels
from .driven_press import DrivenPress, driven_press, listed
from .failures import failure
from .law_trials import asked_drive
from .run import Run, as_run, count_of
from .simulate import tolerated
from .solvers import SimulationProblem
from .trajectory import INTEGRALS, State, Trajectory

MOST_CUTS = 30
PERIODS, MOST_PERIODS = 3, 60  # that a drive with states of its own is given to come near, and in all
BESIDE = 1e-6  # share of speed and states by which they are changed, to see what a period makes of it
SHARES = np.geomspace(0.25, 4.0, 33)  # of the speed given, that are tried first
CLOSER = 3  # times that the range of speeds is narrowed, 32 times each
COMES_BACK = 1e-10  # difference of the crank's speed, beside itself, after a period of a steady state


@typed
def steady_state(
    press: Linkage,
    speed: float,
    *,
    angle: float = 0.0,
    drive: Drive,
    flywheel: Flywheel | None = None,
    loads: Sequence[Load] = (),
    points: int | None = None,
    tolerance: float = 1e-11,
) -> Run:
    """One period of the steady state of a press: from crank angle ``angle`` on, until angle and speed are the same again.

    Args:
        press: a linkage with one driver.
        speed: about which the steady state is looked for [rad/s]; its sign is the direction.
        angle: of the crank at the start [rad].
        drive: what turns the crank; nothing in it may depend on time.
        flywheel: its inertia at the driver joint; None: none.
        loads: as of `simulate`; nothing in them may depend on time.
        points: number of states returned; by default 120 a turn.
        tolerance: as of `simulate`.

    Raises:
        PinpressError: an argument that makes no sense.
        SimulationError: there is no steady state near this speed: the drive is too weak for the load, or gives more than it takes at any
            speed, as a constant torque does.
    """
    began = clock.perf_counter()
    count_of(points, 0.0)
    if not isinstance(press, Linkage) or len(press.drivers) > 1:
        raise PinpressError("a steady state is that of a press with one driver: give the Linkage that load returns")
    start, guess, tolerance = number("angle", angle), number("speed", speed), tolerated(tolerance)
    refuse_far("angle", np.array(start))
    plausibility.speeds("speed", guess)
    if not abs(guess) <= LARGEST:
        raise PinpressError(f"speed is {guess:g}: give rad/s, {LARGEST:g} at most")
    if guess == 0.0:
        raise PinpressError("speed is 0: give the speed about which the press runs [rad/s]")
    listed(loads)
    refuse_scenarios("steady_state", speed, (drive, flywheel, *loads))
    drive, loads = asked_drive(drive, guess), caller_laws.asked_loads(loads)
    driven = driven_press(press, drive, flywheel, loads, None, None)
    if drive is None or not isinstance(drive, Drive):
        raise PinpressError(f"drive is {shown(drive)}: a steady state needs a motor, see pinpress.drives")
    if (drive.timed and not drive.state) or any(force.time is not None for force in driven.forces):
        raise PinpressError("a drive or force that goes with time has no steady state: give motors and process loads that do not")
    if driven.model.period is None:
        raise PinpressError(f"the crank of {press.name} does not turn fully: it has no steady state")
    with np.errstate(all="ignore"):
        path = None if driven.timed else _over_angle(driven, start, guess, tolerance)
        if path is None:
            path = _over_time(driven, start, guess, tolerance)
        until = path.segments[-1].end
        problem = SimulationProblem(
            driven, "reduced", np.array([start]), path.at(np.zeros(1), complete=False).speed[:, 0], until, tolerance
        )
        return as_run(problem, path, points, began)


def _over_angle(driven: DrivenPress, angle: float, speed: float, tolerance: float) -> Trajectory | None:
    """The periodic solution over the crank angle, None where it is not found so: the drive may be too stiff, or there may be none."""
    table = driven.model
    assert table.period is not None
    direction = 1 if speed > 0 else -1
    inertia = float(table.at(np.array([angle]))[0][reduced.INERTIA, 0]) + driven.inertia
    ends = mesh_borders(driven, angle, direction, table.period)
    near = _near(driven, ends, angle, speed)
    if near is None:
        return None
    energy = np.array([0.5 * inertia * near**2])
    solution, guess = None, None
    for _ in range(MOST_CUTS):
        mesh = build_mesh(driven, angle, direction, ends)
        guess = None if solution is None else interpolate_onto(solution, mesh)
        if guess is None:  # the course of the speed matters: a drive may have no slope at the mean
            guess = collocation.solve(driven, mesh, energy).energy
        solution = collocation.solve(driven, mesh, energy, guess, periodic=True)
        if stopping_panels(solution).any() or not solution.ends[0, 0] > 0:
            return None
        energy = solution.ends[0]
        coarse = cuts(solution, len(mesh.kinds), 0.1 * tolerance, driven.corners)
        if not len(coarse):
            change = abs(float(solution.ends[-1, 0] - solution.ends[0, 0])) / float(solution.ends.max())
            if not change < COMES_BACK:
                return None
            state = State(0.0, angle, float(direction * np.sqrt(2 * energy[0] / inertia)), np.zeros(len(INTEGRALS)))
            return Trajectory([angle_segment(driven, solution, len(mesh.kinds), state)])
        ends = np.sort(np.concatenate([ends, coarse]))
    return None


def _near(driven: DrivenPress, ends: Array, angle: float, speed: float) -> float | None:
    """A speed close to the steady state's next to the one given: between one from which a period speeds the press up, and a higher one from
    which it slows down; None where there is none.

    Raises:
        SimulationError: nothing depends on the speed.
    """
    speeds = speed * SHARES
    for _ in range(CLOSER):
        mesh = build_mesh(driven, angle, 1 if speed > 0 else -1, ends)
        energies = 0.5 * (mesh.inertia_ends[0] + driven.inertia) * speeds**2
        solution = collocation.solve(driven, mesh, energies)
        if solution.speed_free:  # nothing depends on the speed: no speed is better than another
            raise failure("no steady state", speed=speed)
        good = np.flatnonzero(~stopping_panels(solution).any(axis=0))
        gained = (solution.ends[-1] - energies)[good]
        found = np.flatnonzero((gained[:-1] > 0) & (gained[1:] <= 0))
        if not len(found):
            return None
        low = int(found[np.abs(np.log(speeds[good[found]] / speed)).argmin()])
        speeds = np.linspace(speeds[good[low]], speeds[good[low + 1]], len(SHARES))
    return float(speeds[len(speeds) // 2])


def _over_time(driven: DrivenPress, angle: float, speed: float, tolerance: float) -> Trajectory:
    """The periodic solution of speed and the drive's states over time: a few periods to come near, then Newton's method on what a period
    makes of them."""
    from .solvers import one_period  # imports SciPy's integrators

    assert driven.drive is not None
    at = np.array([speed, *driven.drive.state])
    try:
        before = np.inf
        for period in range(MOST_PERIODS):
            path, after = one_period(driven, angle, at, tolerance)
            change = float(np.max(np.abs(after - at) / np.maximum(np.abs(at), COMES_BACK)))
            if change <= COMES_BACK:
                return path
            # a plain period wherever Newton's method has led away: corners of the drive are not for it
            if period < PERIODS or change > 0.5 * before:
                at, before = after, np.inf if period < PERIODS else 2.1 * change
                continue
            before, steps = change, BESIDE * np.maximum(np.abs(at), BESIDE)
            columns = [(one_period(driven, angle, at + step, tolerance)[1] - after) / step[k] for k, step in enumerate(np.diag(steps))]
            found = at + np.linalg.solve(np.eye(len(at)) - np.array(columns).T, after - at)
            at = found if np.isfinite(found).all() and 0.8 < found[0] / at[0] < 1.25 else after
    except LawError:  # of the caller, whatever steady state there is
        raise
    except (SimulationError, np.linalg.LinAlgError) as error:
        raise failure("no steady state", speed=speed) from error
    raise failure("no steady state", speed=speed)
