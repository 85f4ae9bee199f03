"""Whether a run is determined by its start: beside an unstable rest, such as a dead centre at the top, errors grow without bounds.

A crank that comes nearly to rest there, with next to no force on it, goes on or turns back by what is lost in rounding; its energy tells
nothing of that. A run that passes such a place is made again from starts moved by its tolerance, and the difference is what can be said.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ..common.arrays import Array
from ..common.errors import SimulationError, caution
from ..linkage.linkage import Linkage
from .angle_solver import NEAR, AngleSegment, nearly_at_rest
from .driven_press import DrivenPress
from .hybrid_system import HOLDING
from .reduced_model import INERTIA, POTENTIAL, WEIGHT, ReducedModel, tabulated
from .solvers import SimulationProblem, march
from .trajectory import RepetitionSegment, StandstillSegment, Trajectory

MOVED = 1e-6  # angle to both sides of a rest, at which it is seen whether it is stable [rad]
PUSHED, CREEPING = 1e-4, 1e-9  # angle [rad] and speed [rad/s] of a press at rest that is pushed
LOOKS = 240  # at the difference
ASTRAY = 1e3  # times the tolerance that a run may go astray
LOST = np.pi  # difference of a run that ends in an error, where the other does not [rad]


def start_sensitivity(problem: SimulationProblem, trajectory: Trajectory) -> float | None:
    """By how much more the crank angle goes astray in a run than its start is moved; None where it keeps clear of an unstable rest."""
    driven, until, tolerance = problem.driven, problem.until, problem.tolerance
    press = driven.press
    if len(press.drivers) > 1 or press.branch_through_change_points.period is None or driven.prescribed is not None:
        return None
    try:
        span = float(np.ptp(tabulated(press).coefficients[:, POTENTIAL, 0]))
    except SimulationError:  # its shafts do not come back together: no table
        return None
    rest = next((segment for segment in trajectory.segments if isinstance(segment, StandstillSegment)), None)
    if rest is not None and _falls(driven, rest.state.angle):
        caution(
            f"the press rests at an unstable equilibrium from {rest.start:.6g} s on, at crank angle {np.degrees(rest.state.angle):.6g} deg:"
            " it stays there as nothing pushes it, but the least push would send it down"
        )
        return None
    if not any(_beside_rest(press, segment, span) for segment in trajectory.segments):
        return None
    times = np.linspace(0.0, until, LOOKS + 1)
    start = trajectory.at(times[:1]).position[_row(press, trajectory)]
    angle, inertia = _angles(press, trajectory, times), float(tabulated(press).at(start)[0][INERTIA, 0])
    speed = max(float(np.abs(np.gradient(angle, times)).max()), float(np.sqrt(2 * span / (inertia + driven.inertia))))
    astray = 0.0
    for by in ((tolerance, 0.0), (0.0, tolerance * speed)):
        try:
            moved = replace(problem, angle=problem.angle + by[0], speed=problem.speed + by[1])
            astray = max(astray, float(np.abs(_angles(press, march(moved), times) - angle).max()))
        except SimulationError:
            astray = max(astray, LOST)
    found = astray / (tolerance * (1.0 + speed * until))
    if found > ASTRAY:
        caution(
            "the run is not determined to its tolerance: it passes an unstable rest so closely that a start moved by"
            f" {tolerance:.3g} of its sizes leads {astray:.3g} rad astray; start it farther from the rest, or with another speed"
        )
    return found


def _beside_rest(press: Linkage, segment: Any, span: float) -> bool:
    """Whether the crank comes close to an unstable rest."""
    if isinstance(segment, AngleSegment):
        return bool((_bend(tabulated(press), segment.slow) < 0).any())
    if isinstance(segment, StandstillSegment | RepetitionSegment):
        return False
    system, n = segment.system, segment.system.dynamics.size
    own = 0.0 if system.driven.clutch is not None else system.driven.inertia
    least = float(tabulated(press).coefficients[:, INERTIA, 0].min()) + own
    speeds = np.abs(segment.speeds)
    slowly = np.flatnonzero(0.5 * least * speeds**2 < NEAR * span)
    for stretch in np.split(slowly, np.flatnonzero(np.diff(slowly) > 1) + 1) if len(slowly) else []:
        k = int(stretch[speeds[stretch].argmin()])  # the slowest of states one after the other
        mode, time = segment.modes[max(k - 1, 0)], segment.start if k == 0 else segment.times[k - 1]
        if mode.brake.grip is HOLDING or mode.standing:
            continue
        y = segment.pieces[max(k - 1, 0)](time)
        rate = {}
        for by in (-MOVED, 0.0, MOVED):
            moved = y.copy()
            moved[:n] = system.dynamics.moved(y[:n], by)[0] if by else y[:n]
            rate[by] = system.dynamics.of_crank(system.rates(mode, time, moved)[n : 2 * n])
        inertia = float(tabulated(press).at(y[[system.dynamics.crank]])[0][INERTIA, 0]) + own
        if rate[MOVED] > rate[-MOVED] and nearly_at_rest(np.array(0.5 * inertia * speeds[k] ** 2), np.array(inertia * rate[0.0]), span):
            return True
    return False


def _falls(driven: DrivenPress, angle: float) -> bool:
    """Whether a press at rest goes on by itself when it is pushed a little, whichever way."""
    drive, weight = driven.drive, driven.model.at(angle + np.array([-PUSHED, PUSHED]))[0][WEIGHT]
    torques = [0.0 if drive is None else float(np.ravel(drive.torque(w))[0]) for w in (-CREEPING, CREEPING)]
    return bool(torques[0] < weight[0] and torques[1] > weight[1])


def _bend(table: ReducedModel, angle: Array) -> Array:
    """Second derivative (n,) of the potential energy by the crank angle (n,): negative where a rest is unstable [N m]."""
    return np.asarray(table.at(angle)[1][WEIGHT])


def _row(press: Linkage, trajectory: Trajectory) -> int:
    return press.driver_indices[0] if trajectory.at(np.zeros(1), False).position.shape[0] > 1 else 0


def _angles(press: Linkage, trajectory: Trajectory, times: Array) -> Array:
    angles: Array = trajectory.at(times, False).position[_row(press, trajectory)]
    return angles
