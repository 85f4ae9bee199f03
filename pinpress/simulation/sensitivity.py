"""How far a run depends on its start, where it passes close to an unstable rest.

There rounding decides whether the crank goes on or turns back, and the energy balance does not show it. The run is therefore repeated from
starts that are moved by its tolerance.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ..common.errors import SimulationError, caution
from ..common.quantities import Array
from ..linkage.linkage import Linkage
from .driven_press import DrivenPress
from .over_angle.segment import NEAR, AngleSegment, nearly_at_rest
from .reduced_model import INERTIA, WEIGHT, ReducedModel
from .solvers import SimulationProblem, march
from .trajectory import RepetitionSegment, StandstillSegment, Trajectory


def start_sensitivity(problem: SimulationProblem, trajectory: Trajectory) -> float | None:
    """By what factor the crank angle of a run moves more than its start; None if the run keeps clear of an unstable rest."""
    driven, press = problem.driven, problem.driven.press
    if len(press.drivers) > 1 or press.branch_through_change_points.period is None or driven.prescribed is not None:
        return None
    try:
        model = driven.model
    except SimulationError:  # its shafts do not come back together: there is no reduced model
        return None
    rest = next((segment for segment in trajectory.segments if isinstance(segment, StandstillSegment)), None)
    if rest is not None and _falls(driven, rest.state.angle):
        caution(
            f"the press rests at an unstable equilibrium from {rest.start:.6g} s on, at"
            f" {press.driver_coordinates[0].at(rest.state.angle)}:"
            " it stays there as nothing pushes it, but the least push would send it down"
        )
        return None
    span = model.potential_range
    if not any(_beside_rest(model, segment, span) for segment in trajectory.segments):
        return None
    return _compare_moved_starts(problem, trajectory, model, span)


def _compare_moved_starts(problem: SimulationProblem, trajectory: Trajectory, model: ReducedModel, span: float) -> float:
    """`start_sensitivity` of a run that passes an unstable rest, from runs whose starts are moved.

    Args:
        problem: of the run.
        trajectory: of the run.
        model: of the press.
        span: range of the potential energy [J].
    """
    press, until, tolerance = problem.driven.press, problem.until, problem.tolerance
    times = np.linspace(0.0, until, 241)
    angles = _crank_angles(press, trajectory, times)
    inertia = float(model.at(angles[:1])[0][INERTIA, 0]) + problem.driven.inertia
    speed = max(float(np.abs(np.gradient(angles, times)).max()), float(np.sqrt(2 * span / inertia)))
    astray = 0.0
    for angle_by, speed_by in ((tolerance, 0.0), (0.0, tolerance * speed)):
        try:
            moved = march(replace(problem, angle=problem.angle + angle_by, speed=problem.speed + speed_by))
            astray = max(astray, float(np.abs(_crank_angles(press, moved, times) - angles).max()))
        except SimulationError:
            # A run that ends in an error differs by as much as two crank angles can.
            astray = max(astray, np.pi)
    factor = astray / (tolerance * (1.0 + speed * until))
    # A run that multiplies an error of its start by more than this is not determined.
    if factor > 1e3:
        caution(
            "the run is not determined to its tolerance: it passes an unstable rest so closely that a start moved by"
            f" {tolerance:.3g} of its sizes leads {astray:.3g} rad astray; start it farther from the rest, or with another speed"
        )
    return factor


def _beside_rest(model: ReducedModel, segment: Any, span: float) -> bool:
    """Whether the crank comes close to an unstable rest."""
    if isinstance(segment, AngleSegment):
        return bool(len(segment.slow)) and bool((model.at(segment.slow)[1][WEIGHT] < 0).any())
    if isinstance(segment, StandstillSegment | RepetitionSegment):
        return False
    system, n = segment.system, segment.system.dynamics.size
    added = 0.0 if system.driven.clutch is not None else system.driven.inertia
    least = float(model.middles[INERTIA].min()) + added
    speeds = np.abs(segment.speeds)
    slowly = np.flatnonzero(0.5 * least * speeds**2 < NEAR * span)
    for stretch in np.split(slowly, np.flatnonzero(np.diff(slowly) > 1) + 1) if len(slowly) else []:
        k = int(stretch[speeds[stretch].argmin()])  # the slowest of states one after the other
        mode, time = segment.modes[max(k - 1, 0)], segment.start if k == 0 else segment.times[k - 1]
        if mode.rests:
            continue
        y = segment.pieces[max(k - 1, 0)](time)
        accelerations = []
        for by in (-1e-6, 0.0, 1e-6):  # so near that a rest is stable or unstable by them [rad]
            moved = y.copy()
            moved[:n] = system.dynamics.move_crank(y[:n], by)[0] if by else y[:n]
            accelerations.append(system.dynamics.of_crank(system.rates(mode, time, moved)[n : 2 * n]))
        below, here, above = accelerations
        inertia = float(model.at(y[[system.dynamics.crank]])[0][INERTIA, 0]) + added
        if above > below and nearly_at_rest(np.array(0.5 * inertia * speeds[k] ** 2), np.array(inertia * here), span):
            return True
    return False


def _falls(driven: DrivenPress, angle: float) -> bool:
    """Whether a press at rest moves on by itself when it is pushed a little in either direction."""
    drive, weight = driven.drive, driven.model.at(angle + np.array([-1e-4, 1e-4]))[0][WEIGHT]  # beyond the rounding of a rest [rad]
    torques = [0.0 if drive is None else float(np.ravel(drive.torque(speed))[0]) for speed in (-1e-9, 1e-9)]  # either way, but at rest
    return bool(torques[0] < weight[0] and torques[1] > weight[1])


def _crank_angles(press: Linkage, trajectory: Trajectory, times: Array) -> Array:
    """Crank angles (n,) at times (n,) [rad]."""
    position = trajectory.at(times, complete=False).position
    return np.asarray(position[press.driver_indices[0] if len(position) > 1 else 0])
