"""A problem of simulation, and the solvers that take turns at it.

A press with one driver turns by the reduced equation: over the crank angle while it turns and nothing depends on time, else over time.
A linkage with all its joints is integrated over time. `march` chooses.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..common.arguments import number
from ..common.errors import PinpressError, SimulationError
from ..common.quantities import Array
from ..kinematics.cycle import motion_through_change_points
from ..kinematics.servo_motion import servo_cycle
from ..loads.caller_laws import LawError
from .driven_press import DrivenPress
from .failures import failure
from .over_angle.angle_solver import MOST_PERIODS, AngleSolver
from .over_angle.collocation import LEAST
from .over_angle.segment import AngleSegment
from .over_time.equations_of_motion import FullDynamics, ReducedDynamics
from .over_time.hybrid_system import HybridSystem, Mode
from .reduced_model import INERTIA, ReducedModel, lock_failure
from .trajectory import INTEGRALS, RepetitionSegment, Segment, StandstillSegment, State, Trajectory

if TYPE_CHECKING:
    from .over_time.time_solver import TimeSegment

AGAIN = 4.0  # the crank is followed over its angle again from this multiple of the kinetic energy at which it was no longer sure to turn
LEAST_TOLERANCE = 1e-13  # a smaller error of a step is rounding
TOLERANCE, ELASTIC_TOLERANCE = 1e-11, 1e-5  # by default, of a rigid and of an elastic motion

Progress = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class SimulationProblem:
    """What is to be simulated, from which state to which time, and how well.

    Attributes:
        driven: the press, its drives and loads.
        method: "reduced", "implicit" (the reduced equation by Radau IIA alone), "constraint" or "elastic".
        angle: (drivers,) at time 0 [rad].
        speed: (drivers,) at time 0 [rad/s].
        until: time of the end [s].
        tolerance: error accepted of a step, relative to 1 rad and to the speeds of the crank.
        step: fixed step of the classical Runge-Kutta method [s]; None: steps by error.
    """

    driven: DrivenPress
    method: str
    angle: Array
    speed: Array
    until: float
    tolerance: float
    step: float | None = None


def checked_tolerance(tolerance: float | None, elastic: bool = False) -> float:
    """The tolerance as a number, that by default where none is given; raises PinpressError outside the range that can be kept."""
    value = number("tolerance", (ELASTIC_TOLERANCE if elastic else TOLERANCE) if tolerance is None else tolerance, positive=True)
    if not LEAST_TOLERANCE <= value <= 1e-2:
        raise PinpressError(f"tolerance is {value:g}: give one from {LEAST_TOLERANCE:g} to 0.01")
    return value


def refuse_many_turns(speeds: Array, until: float, angle: float) -> None:
    """Raise SimulationError where the run would have too many turns to be kept."""
    if not float(np.abs(speeds).max()) * until <= 2 * np.pi * MOST_PERIODS:
        raise failure("too many turns", 0.0, angle, most=MOST_PERIODS)


def march(problem: SimulationProblem, progress: Progress | None = None) -> Trajectory:
    """Follow the press to the end.

    Over the crank angle where that is possible. From a state at which it may stop there, it is followed over time until it turns for sure.

    Raises:
        SimulationError: the press stalls, runs against a lock or has no inertia, or the run would take too long.
    """
    driven = problem.driven
    if driven.clutch is None and driven.inertia < 0:
        _least_inertia(driven, needed=True)
    if problem.method == "constraint":
        return Trajectory([_all_joints_over_time(problem, progress)])
    in_time = driven.timed or problem.step is not None or (problem.method == "implicit" and driven.prescribed is None)
    turns = not in_time and _least_inertia(driven)[0] > 0  # without inertia the crank may stay between dead centres
    over_time, segments = OverTime(problem, progress, turns), list[Segment]()
    stopped: State | None = None  # where the crank may stop, so that it is followed over time
    state: State | None = State(0.0, float(problem.angle[0]), float(problem.speed[0]), np.zeros(len(INTEGRALS)))
    while state is not None:
        if turns and state is not stopped:
            leg, stopped = _over_angle(problem, state, progress, first=not segments)
            state = stopped
        else:
            leg, state = over_time.advance(state, segments)
        segments += leg
    return Trajectory(segments)


def _least_inertia(driven: DrivenPress, needed: bool = False) -> tuple[float, float]:
    """The least inertia at the crank [kg m2], and its crank angle [rad]; raises SimulationError where it is not positive but ``needed``
    so."""
    inertia, angle = driven.model.lightest
    least = inertia + driven.inertia
    if needed and not least > 0:
        raise failure("no inertia", None, angle, inertia=least)
    return least, angle


def _over_angle(problem: SimulationProblem, state: State, progress: Progress | None, first: bool) -> tuple[list[Segment], State | None]:
    """The reduced equation over the crank angle, period by period (see `angle_solver`), while the crank turns.

    Returns:
        Segments, and the state at which the crank may stop; None at the end of the run.
    """
    driven = problem.driven
    solver = AngleSolver(driven, state, problem.until, 0.1 * problem.tolerance)
    stop = solver.run(progress)
    if stop is None:
        return solver.segments, None
    idle = driven.drive is None or not np.any(driven.drive.torque(0.0))  # else gears with losses may hold the crank against its torque
    if stop.at_rest and not driven.forces and first and driven.friction is None and idle:  # in equilibrium, if an unstable one
        return [*solver.segments, StandstillSegment(stop.state, problem.until)], None
    return solver.segments, stop.state


class OverTime:
    """The reduced equation over time, whatever happens. If ``turns``, it ends once the crank turns for sure."""

    def __init__(self, problem: SimulationProblem, progress: Progress | None, turns: bool) -> None:
        self.problem, self.progress, self.turns = problem, progress, turns
        self.swings = True  # whether it is still to be found out if the crank swings to and fro for ever
        self.threshold: float | None = None  # kinetic energy from which the crank turns for sure [J]
        self.handed: State | None = None

    def advance(self, state: State, before: Sequence[Segment]) -> tuple[list[Segment], State | None]:
        """Segments from a state on, and the state from which the crank turns for sure; None at the end of the run. ``before``: the segments
        so far."""
        problem, driven = self.problem, self.problem.driven
        if self.threshold is None:
            self.threshold = _turning_energy(driven, state, before)
        elif state is self.handed:  # too early
            self.threshold *= AGAIN
        system, segments = reduced_system(driven), list[Segment]()
        while True:
            followed = _Followed(driven, self.threshold, state.speed, self.swings) if self.turns else None
            segment, state = self._integrate(system, state, followed)
            segments.append(segment)
            if segment.end >= problem.until:
                return segments, None
            if followed is None or not followed.swung:
                self.handed = state
                return segments, state
            swinging = None if driven.heeds_speed else _repeat_swing(system, segment, problem.tolerance, problem.until)
            if swinging is not None:
                return [*segments, *swinging], None
            self.swings = False

    def _integrate(self, system: HybridSystem, state: State, followed: "_Followed | None") -> "tuple[TimeSegment, State]":
        """Integrate from a state to the end, or until the crank has been ``followed`` for long enough. Returns the segment and the state
        at its end."""
        from .over_time.time_solver import BY_STIFFNESS, IMPLICIT, Settings, integrate  # imports SciPy's integrators

        problem, driven = self.problem, self.problem.driven
        mode, y = _begin(system, state)
        method = IMPLICIT if problem.method == "implicit" else BY_STIFFNESS
        settings = Settings(problem.tolerance, crank_sizes(driven, y), problem.step, method)
        try:
            segment, y = integrate(system, mode, state.time, y, problem.until, settings, followed, self.progress)
        except SimulationError as error:
            least, where = _least_inertia(driven)
            reached = error.crank_angle
            end = None if reached is None else _end_at(driven.model, reached)
            if end is not None:
                raise lock_failure(driven.model, end, error.time) from error
            if least > 0 or isinstance(error, LawError):
                raise
            angle = where if error.crank_angle is None else error.crank_angle
            raise failure("no inertia", error.time, angle, inertia=least) from error
        return segment, State(segment.end, float(y[0]), float(y[1]), y[-len(INTEGRALS) :])


def _end_at(model: ReducedModel, angle: float) -> float | None:
    """The end of a model without a period at which a crank angle is, or beyond which; None if it is at none."""
    low, high = float(model.borders[0]), float(model.borders[-1])
    # Steps over time that find no way on this near to the end of the range have come to the lock.
    margin = 1e-5 * (high - low)
    if model.period is not None or low + margin < angle < high - margin:
        return None
    return low if angle <= low + margin else high


class _Followed:
    """Tells when a crank has been followed over time for long enough: when it turns, or has swung to and fro once."""

    def __init__(self, driven: DrivenPress, threshold: float, speed: float, swings: bool) -> None:
        """Begin to follow a crank.

        Args:
            driven: what is simulated.
            threshold: kinetic energy from which the crank turns for sure [J].
            speed: of the crank at the start [rad/s].
            swings: whether a whole swing ends it too.
        """
        self.driven, self.threshold, self.speed = driven, threshold, speed
        self.left = (2 if speed == 0 else 3) if swings else -1  # stops before a whole swing is over
        self.swung = False

    def __call__(self, y: Array) -> bool:
        if y[1] * self.speed < 0:
            self.left -= 1
        self.speed, self.swung = float(y[1]) or self.speed, self.left == 0
        return self.swung or _energy(self.driven, y[0], y[1]) > self.threshold


def _turning_energy(driven: DrivenPress, state: State, before: Sequence[Segment]) -> float:
    """Kinetic energy from which a crank that has stopped turns for sure again [J]."""
    states = (state, *(segment.last() for segment in before if isinstance(segment, AngleSegment)))
    fastest = max(_energy(driven, s.angle, s.speed) for s in states)
    # With less than 1e-4 of the range of the potential energy a crank is not sure to turn.
    return max(AGAIN * LEAST * fastest, 1e-4 * driven.model.potential_range)


def _repeat_swing(system: HybridSystem, segment: "TimeSegment", tolerance: float, until: float) -> "list[Segment] | None":
    """Follow a crank that swings to and fro, under forces that do not depend on its speed, for one swing, to a tolerance relative to the
    swing, and repeat that to the end. None if the crank does not come back."""
    from .over_time.time_solver import IMPLICIT, Settings, integrate  # imports SciPy's integrators

    begin, turn, again = segment.stops()[-3:]
    sample = segment.at(np.array([begin, turn]), complete=False)
    angle, beyond = sample.position[0]
    if angle == beyond:  # it stands, but for rounding
        return None
    mode, y = _begin(system, State(begin, float(angle), 0.0, sample.integrals[:, 0]))
    sizes = crank_sizes(system.driven, y)
    sizes[:2] = abs(beyond - angle), abs(beyond - angle) * 2 * np.pi / (again - begin)
    followed = _Followed(system.driven, np.inf, 0.0, swings=True)
    end = begin + 2 * (again - begin)
    swing, _ = integrate(system, mode, begin, y, end, Settings(tolerance, sizes, method=IMPLICIT), followed)
    stops = swing.stops()
    return [swing, RepetitionSegment(Trajectory([swing]), begin, stops[2], until)] if len(stops) > 2 else None


def _all_joints_over_time(problem: SimulationProblem, progress: Progress | None) -> Segment:
    """All joints at once, over time, to the end."""
    from .over_time.time_solver import Settings, integrate  # imports SciPy's integrators

    driven, press, angle, speed = problem.driven, problem.driven.press, problem.angle, problem.speed
    joints = FullDynamics(press, driven.coordinates, driven.inertias, driven.held)
    system, several = HybridSystem(joints, driven), len(press.drivers) > 1
    first = servo_cycle(press, angle=angle[None], speed=speed[None]) if several else motion_through_change_points(press, angle, speed)
    mode, y = system.begin(0.0, first.joint_position[0], first.v[0], np.zeros(len(INTEGRALS)))
    settings = Settings(problem.tolerance, _joint_sizes(driven, joints, speed, y), problem.step)
    return integrate(system, mode, 0.0, y, problem.until, settings, progress=progress)[0]


def _begin(system: HybridSystem, state: State) -> tuple[Mode, Array]:
    """Mode and vector of a state of the crank."""
    return system.begin(state.time, np.array([state.angle]), np.array([state.speed]), state.integrals)


def reduced_system(driven: DrivenPress) -> HybridSystem:
    """The press as its crank alone, to be integrated over time."""
    return HybridSystem(ReducedDynamics(driven.model), driven)


def _energy(driven: DrivenPress, angle: float, speed: float) -> float:
    """Kinetic energy of a crank angle and speed [J]."""
    inertia = float(driven.model.at(np.array([angle]))[0][INERTIA, 0]) + float(driven.inertia)
    return 0.5 * inertia * speed**2


def crank_sizes(driven: DrivenPress, y: Array) -> Array:
    """Sizes of the entries of the crank's vector, to which tolerances are relative."""
    speed, energy = driven.motion_sizes(float(y[1]))
    return np.array([1.0, speed, *_state_sizes(driven, len(y) - 2 - len(INTEGRALS), speed), energy, energy, np.inf, energy])


def _joint_sizes(driven: DrivenPress, joints: FullDynamics, speed: Array, y: Array) -> Array:
    """Sizes of the entries of the vector of all joints, to which tolerances are relative.

    The size of an angle is 1 rad, that of a rate the largest ``speed`` (drivers,) at the start or the one that gravity gives, whichever is
    larger. Travels count in lengths of the linkage.
    """
    press = driven.press
    rate = max(float(np.abs(speed).max()), math.sqrt(float(np.linalg.norm(press.model.gravity.linear)) / press.size)) or 1.0
    energy = joints.energy(np.concatenate([y[: joints.size], rate * np.ones(joints.size)]))
    states = _state_sizes(driven, len(y) - 2 * joints.size - len(INTEGRALS), rate)
    return np.concatenate([press.lengths, press.lengths * rate, states, [energy, energy, np.inf, energy]])


def _state_sizes(driven: DrivenPress, count: int, speed: float) -> list[float]:
    """Sizes of a drive's states, followed by that of the speed of a clutch's driving side."""
    of_shaft = [] if driven.clutch is None else [speed]
    return [1.0] * (count - len(of_shaft)) + of_shaft
