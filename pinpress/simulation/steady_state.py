"""The steady state of a loaded press: its periodic motion, found directly.

Where all depends on crank angle and speed, the kinetic energy over a period is solved with the condition that it ends as it began (see
`collocation.solve`). A drive with states of its own is followed over periods, and Newton's method finds the speed and states to which the
press comes back.
"""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, overload

import numpy as np

from ..common.arguments import LARGEST, number, typed
from ..common.errors import PinpressError, SimulationError, shown
from ..common.parameters import refuse_scenarios
from ..common.quantities import RPM, Array
from ..drives.protocol import Drive
from ..drives.transmission import Flywheel, PrescribedSpeed
from ..dynamics.applied_loads import turn_of_spring
from ..dynamics.inverse_dynamics import NONE_GIVEN
from ..kinematics.cycle import doubt_speeds
from ..linkage.assembly import refuse_far
from ..linkage.linkage import Linkage
from ..loads.caller_laws import LawError
from ..loads.link import Friction, Load, TorsionSpring
from .driven_press import DrivenPress, driven_press, motor_against
from .elastic.description import Elastic
from .failures import failure, name_driver_in_errors
from .law_trials import tried
from .over_angle import collocation
from .over_angle.collocation import CollocationSolution
from .over_angle.mesh import AngleMesh, Indices, build_mesh, mesh_borders
from .over_angle.refinement import cuts, solve_period, stopping_panels
from .over_angle.segment import angle_segment
from .run import Run, as_run, state_count
from .solvers import TOLERANCE, SimulationProblem, checked_tolerance, crank_sizes, reduced_system
from .trajectory import INTEGRALS, State, Trajectory

if TYPE_CHECKING:
    from .elastic.run import ElasticRun

SHARES = np.geomspace(0.25, 4.0, 33)  # multiples of the given speed among which the steady state is searched
COMES_BACK = 1e-10  # relative difference accepted between the speeds at start and end of a period


@overload
def steady_state(
    press: Linkage,
    speed: float,
    *,
    angle: float = ...,
    drive: Drive | PrescribedSpeed,
    flywheel: Flywheel | None = ...,
    loads: Sequence[Load] = ...,
    friction: Mapping[str, Friction] = ...,
    points: int | None = ...,
    elastic: Elastic,
    tolerance: float | None = ...,
) -> ElasticRun: ...


@overload
def steady_state(
    press: Linkage,
    speed: float,
    *,
    angle: float = ...,
    drive: Drive | PrescribedSpeed,
    flywheel: Flywheel | None = ...,
    loads: Sequence[Load] = ...,
    friction: Mapping[str, Friction] = ...,
    points: int | None = ...,
    elastic: None = None,
    tolerance: float | None = ...,
) -> Run: ...


@typed
def steady_state(
    press: Linkage,
    speed: float,
    *,
    angle: float = 0.0,
    drive: Drive | PrescribedSpeed,
    flywheel: Flywheel | None = None,
    loads: Sequence[Load] = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    points: int | None = None,
    elastic: Elastic | None = None,
    tolerance: float | None = None,
) -> Run:
    """One period of the steady state of a press: from crank angle ``angle`` on, until angle and speed are the same again.

    Args:
        press: a linkage with one driver.
        speed: speed near which the steady state is sought [rad/s]; its sign is the direction.
        angle: of the crank at the start [rad].
        drive: what turns the crank; nothing in it may depend on time.
        flywheel: its inertia stands at the driver joint; None: none.
        loads: as in `simulate`; nothing in them may depend on time.
        friction: as in `simulate`.
        points: number of states returned; by default 120 a turn.
        elastic: as in `simulate`; the drive may then be a `PrescribedSpeed` too. The steady state is the stroke that the press repeats
            on its springs.
        tolerance: as in `simulate`.

    Raises:
        PinpressError: an argument makes no sense.
        SimulationError: there is no steady state near this speed, because the drive is too weak for the load, or gives more than the load
            takes at every speed, as a constant torque does, or is an asynchronous motor that turns the other way.
    """
    return steady_state_near(None, press, speed, angle, drive, flywheel, loads, friction, points, elastic, tolerance)


def steady_state_near(
    neighbour: ElasticRun | None,
    press: Linkage,
    speed: float,
    angle: float,
    drive: Drive | PrescribedSpeed,
    flywheel: Flywheel | None,
    loads: Sequence[Load],
    friction: Mapping[str, Friction],
    points: int | None,
    elastic: Elastic | None,
    tolerance: float | None,
) -> Run:
    """The `steady_state`, by that of the same press, springs and loads at another constant speed, where there is one that leads to it."""
    began = clock.perf_counter()
    state_count(points, 0.0)
    press.refuse_several_drivers("a steady state is that of a press with one; let it run with simulate")
    press.refuse_sliding_driver("it has no steady state; let it run with simulate, or prescribe its motion with cycle or servo_cycle")
    start, near, tolerance = number("angle", angle, "rad"), _speed(speed), checked_tolerance(tolerance, elastic is not None)
    refuse_far("angle", np.array(start), press.driver_coordinates)
    loads = list(loads)  # of what is gone through once, too
    refuse_scenarios("steady_state", speed, (drive, flywheel, *loads))
    tried_drive, loads = tried(drive, loads, near)
    driven = driven_press(press, tried_drive, flywheel, loads, None, None, friction)
    if elastic is None or driven.prescribed is None:
        _refuse_without_steady_state(driven, drive, near)
    _refuse_winding_springs(press, loads)
    doubt_speeds(press, near)
    if elastic is not None:
        from .elastic.press.assembly import opening_press  # rigid periods need nothing of these, and they are large
        from .elastic.run import segment_of
        from .elastic.simulate_elastic import elastic_steady_state

        rigid_period = partial(_rigid_period, driven, near, TOLERANCE)
        with name_driver_in_errors(press), np.errstate(all="ignore"):  # what is not finite is refused where it arises
            sprung = opening_press(press, elastic) if neighbour is None else segment_of(neighbour).solution.equations.sprung
            return elastic_steady_state(driven, sprung, near, start, points, tolerance, began, rigid_period, neighbour)
    with np.errstate(all="ignore"):  # what is not finite is refused where it arises
        period = _rigid_period(driven, near, tolerance, start)
        speeds = period.at(np.zeros(1), complete=False).speed[:, 0]
        problem = SimulationProblem(driven, "reduced", np.array([start]), speeds, period.segments[-1].end, tolerance)
        return as_run(problem, period, points, began)


def _refuse_winding_springs(press: Linkage, loads: Sequence[Load]) -> None:
    """Raise PinpressError for a torsion spring that is wound up by turns, and thus never back."""
    gain = press.branch_through_change_points.gain_per_period
    for load in loads:
        if isinstance(load, TorsionSpring) and load.stiffness and abs(turn_of_spring(load, press).angle(gain)) > 1e-9:  # rounding [rad]
            raise PinpressError(f"{load.label}: every period winds it up by a turn, so that there is no steady state: give only damping")


def _rigid_period(driven: DrivenPress, speed: float, tolerance: float, angle: float) -> Trajectory:
    """The period from a crank angle on, of the steady state near a speed."""
    period = None if driven.timed else _over_angle(driven, angle, speed, tolerance)
    return _over_time(driven, angle, speed, tolerance) if period is None else period


def _speed(given: object) -> float:
    """The speed near which the steady state is searched [rad/s]."""
    speed = number("speed", given, "rad/s")
    if not abs(speed) <= LARGEST:
        raise PinpressError(f"speed is {speed:g}: give rad/s, {LARGEST:g} at most")
    if speed == 0.0:
        raise PinpressError("speed is 0: give the speed about which the press runs [rad/s]")
    return speed


def _refuse_without_steady_state(driven: DrivenPress, given: object, near: float) -> None:
    """Raise PinpressError where a driven press can have no steady state near a speed; ``given``: the drive as it was given."""
    drive = driven.drive
    if drive is None:
        raise PinpressError(f"drive is {shown(given)}: a steady state needs a motor, see pinpress.drives")
    if (drive.timed and not drive.state) or any(force.time is not None for force in driven.forces):
        raise PinpressError("a drive or force that goes with time has no steady state: give motors and process loads that do not")
    if driven.model.period is None:
        raise PinpressError(f"the crank of {driven.press.name} does not turn fully: it has no steady state")
    if not driven.model.repeats:
        raise PinpressError(
            f"a slide of {driven.press.name} does not come back after a turn, as on a screw or a rack: it has no steady state; let it run"
            " with simulate"
        )
    if (against := motor_against(driven.press, given, near)) is not None:
        raise failure("other way", **against._asdict())


# --------------------------------------------------------------------------------------------------------------------------- over the angle


def _over_angle(driven: DrivenPress, angle: float, speed: float, tolerance: float) -> Trajectory | None:
    """The periodic solution over the crank angle; None if it is not found: the drive may be too stiff, or there may be none.

    Raises:
        SimulationError: nothing depends on the speed.
    """
    model, direction = driven.model, 1 if speed > 0 else -1
    assert model.period is not None
    mesh = build_mesh(driven, angle, direction, mesh_borders(driven, angle, direction, model.period))
    speeds = speed * SHARES[14:19]  # mostly it is this near
    tried = collocation.solve(driven, mesh, _energies(driven, mesh, speeds), roughly=True)
    bounds = None if tried.speed_free else _bounds(tried, speeds, speed)  # at speeds further off a force may depend on the speed
    for attempt in range(4):  # each narrows the range of speeds to a 32nd
        if bounds is not None:
            gained, starts = (tried.ends[-1] - tried.ends[0])[bounds], tried.ends[0, bounds]
            weights = np.array([-gained[1], gained[0]]) / (gained[0] - gained[1])  # between the bounds nothing is gained
            guess = (tried.energy[:, :, bounds] @ weights)[:, :, None]
            solution = _periodic(driven, mesh, (starts @ weights)[None], guess, tolerance)
            # Newton's method may also end at a motion that the press leaves when it is disturbed, or far off. In the narrowest range the
            # bounds of a coarse mesh are not exact enough to tell.
            near = solution is not None and (attempt == 3 or starts.min() <= solution.ends[0, 0] <= starts.max())
            if solution is not None and near and solution.exponent[0] < 0:
                begin = float(direction * np.sqrt(2 * solution.ends[0, 0] / (solution.mesh.inertia_ends[0] + driven.inertia)))
                state = State(0.0, angle, begin, np.zeros(len(INTEGRALS)))
                return Trajectory([angle_segment(driven, solution, len(solution.mesh.kinds), state)])
        speeds = speed * SHARES if bounds is None else np.linspace(float(speeds[bounds[0]]), float(speeds[bounds[1]]), len(SHARES))
        tried = collocation.solve(driven, mesh, _energies(driven, mesh, speeds))
        if tried.speed_free:  # no speed is better than another
            raise _no_steady_state(speed)
        bounds = _bounds(tried, speeds, speed)
        if bounds is None:
            return None
    return None


def _periodic(driven: DrivenPress, mesh: AngleMesh, energy: Array, guess: Array, tolerance: float) -> CollocationSolution | None:
    """The periodic solution on as many panels as it takes; None if it is not found.

    Args:
        driven: what is simulated.
        mesh: the first panels.
        energy: (1,) kinetic energy at the start, near that of the steady state [J].
        guess: (q, p, 1) kinetic energy over the mesh [J].
        tolerance: as in `simulate`.
    """

    def places(solution: CollocationSolution) -> Array | None:
        if stopping_panels(solution).any() or not solution.ends[0, 0] > 0:
            return None
        return cuts(solution, len(solution.mesh.kinds), 0.1 * tolerance, driven.drive)

    period = solve_period(driven, mesh, energy, places, guess, periodic=True)
    if period is None or len(period.coarse):
        return None
    ends = period.solution.ends[:, 0]
    return period.solution if abs(ends[-1] - ends[0]) / ends.max() < COMES_BACK else None


def _energies(driven: DrivenPress, mesh: AngleMesh, speeds: Array) -> Array:
    """Kinetic energies (n,) at the start of a mesh [J] at speeds (n,) [rad/s]."""
    return np.asarray(0.5 * (mesh.inertia_ends[0] + driven.inertia) * speeds**2)


def _bounds(tried: CollocationSolution, speeds: Array, speed: float) -> Indices | None:
    """Indices (2,) of the two speeds about the steady state nearest to ``speed``; None if there are none.

    From the lower one a period speeds the press up, from the higher one it slows the press down.

    Args:
        tried: a period from each of the speeds.
        speeds: (n,) in rising size [rad/s].
        speed: near which the steady state is searched [rad/s].
    """
    good = np.flatnonzero(~stopping_panels(tried).any(axis=0))
    gained = (tried.ends[-1] - tried.ends[0])[good]
    lower = np.flatnonzero((gained[:-1] > 0) & (gained[1:] <= 0))
    if not len(lower):
        return None
    low = int(lower[np.abs(np.log(speeds[good[lower]] / speed)).argmin()])
    return good[low : low + 2]


# -------------------------------------------------------------------------------------------------------------------------------- over time


def _over_time(driven: DrivenPress, angle: float, speed: float, tolerance: float) -> Trajectory:
    """The periodic solution of speed and the drive's states over time.

    Raises:
        SimulationError: there is none near this speed.
    """
    assert driven.drive is not None
    try:
        period = _shoot(driven, angle, np.array([speed, *driven.drive.state]), tolerance)
    except LawError:  # an error of the caller's law is raised as it is
        raise
    except (SimulationError, np.linalg.LinAlgError) as error:
        raise _no_steady_state(speed) from error
    if period is None:
        raise _no_steady_state(speed)
    return period


def _no_steady_state(speed: float) -> SimulationError:
    return failure("no steady state", speed=speed, turns=speed / RPM)


def _shoot(driven: DrivenPress, angle: float, start: Array, tolerance: float) -> Trajectory | None:
    """A few periods to come near the steady state, then Newton's method on what a period makes of speed and states; None if it fails.

    Args:
        driven: what is simulated.
        angle: of the crank at the start of a period [rad].
        start: (k,) speed of the crank and states of the drive to begin with.
        tolerance: as in `simulate`.
    """
    before = np.inf
    for count in range(60):
        period, after = _period(driven, angle, start, tolerance)
        change = float(np.max(np.abs(after - start) / np.maximum(np.abs(start), COMES_BACK)))
        if change <= COMES_BACK:
            return period
        # a plain period replaces a step of Newton's method that has led away, as it does at corners of the drive
        if count < 3 or change > 0.5 * before:
            start, before = after, np.inf if count < 3 else 2.1 * change
            continue
        before = change
        steps = 1e-6 * np.maximum(np.abs(start), 1e-6)  # as far above rounding as below what bends
        columns = [(_period(driven, angle, start + step, tolerance)[1] - after) / step[k] for k, step in enumerate(np.diag(steps))]
        solved = np.asarray(start + np.linalg.solve(np.eye(len(start)) - np.array(columns).T, after - start))
        start = solved if np.isfinite(solved).all() and 0.8 < solved[0] / start[0] < 1.25 else after
    return None


def _period(driven: DrivenPress, angle: float, start: Array, tolerance: float) -> tuple[Trajectory, Array]:
    """A period of the reduced model over time, from a crank angle with speed and states of the drive (k,), and these at its end.

    Raises:
        SimulationError: the crank does not get through a period.
    """
    from .over_time.time_solver import Settings, integrate  # imports SciPy's integrators

    assert driven.model.period is not None
    system = reduced_system(driven)
    direction = 1.0 if start[0] > 0 else -1.0
    target = angle + direction * driven.model.period
    patience = 20.0 * driven.model.period / abs(float(start[0]))  # at a twentieth of the first speed it does not get through
    mode, y = system.begin(0.0, np.array([angle]), start[:1], np.zeros(len(INTEGRALS)), tuple(start[1:].tolist()))

    def beyond(y: Array) -> bool:
        return bool((y[0] - target) * direction >= 0)

    most, y = integrate(system, mode, 0.0, y, patience, Settings(tolerance, crank_sizes(driven, y)), beyond)
    if not beyond(y):
        raise failure("too weak", float(patience), float(y[0]))
    # steps are made to end at the target, because the integrator's interpolation is less exact than its steps
    since, mode, before, end = most.before(lambda y: float((y[0] - target) * direction))
    segments, y = [most], before
    # Newton's method on the time of the period's end.
    for _ in range(4):
        if end <= since:  # an event has ended the step before at the target
            break
        last, y = integrate(system, mode, since, before, end, Settings(tolerance, crank_sizes(driven, before)))
        segments = [most, last]
        end += float((target - y[0]) / y[1])
    return Trajectory(segments), y[1 : -len(INTEGRALS)]
