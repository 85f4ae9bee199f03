"""By how much a best motion exceeds its limits between the nodes of its program, by full inverse dynamics.

The program limits the mean torque of a segment, which the kinetic energies at the segment's ends give exactly. The acceleration is constant
within a segment. Inertia and loads are not constant there, so the torque at an instant may be larger than the mean torque.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.quantities import Array
from ..dynamics.reactions import Reactions
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load
from . import limits as limits_
from .conic.bounds import peak_torque_bounds
from .conic.local_limits import power_tangents, torque_rates
from .conic.motion_problem import Affine, Bounded, MotionProblem, cycle_time, figures, segment_times
from .conic.torque_curve import curve_tangents
from .motion import ServoMotion, evaluated, largest_size

INSIDE = 1e-7  # share of a segment by which its first and last states are moved inwards, because loads may jump at nodes
LOBATTO = np.array([0.0, 0.5 - 0.1 * 5**0.5, 0.5 + 0.1 * 5**0.5, 1.0]), np.array([1.0, 5.0, 5.0, 1.0]) / 12.0
NEAR = 0.95  # share of a limit above which the limit is checked between nodes too
SLOW = 1e-3  # share of the top speed below which the power does not limit the motion


class FullMotion(NamedTuple):
    """A motion by full inverse dynamics."""

    motion: ServoMotion  # the motion, with states within all segments and at rests
    reactions: Reactions  # the reactions of the motion
    time: Array  # (N + 1,) times at which the crank passes the nodes, or leaves them after a rest [s]
    segment: NDArray[np.intp]  # index of the segment of each state; -1 at rests


def excess_of(problem: MotionProblem, full: FullMotion) -> tuple[float, NDArray[np.bool_]]:
    """Largest share by which a motion exceeds its drive's torque or power; (2, N) whether torque and power come near it in each segment."""
    drive, moving = problem.drive, full.segment >= 0
    torque = np.abs(full.motion.motor_torque) / drive.peak_torque_at(full.motion.motor_speed)
    power = np.abs(full.motion.power) / (np.inf if drive.power is None else drive.power)
    used = np.stack([torque, power])[:, moving].reshape(2, -1, len(LOBATTO[0])).max(axis=2)
    return max(0.0, float(used.max()) - 1.0), used > NEAR


def limits_at_states(problem: MotionProblem, full: FullMotion, b: Array, chosen: NDArray[np.bool_]) -> list[Bounded]:
    """Limits of the torque and the power at the states within segments, as tangents at a motion.

    The torque within a segment is linear in b at the segment's ends. The limit power / speed is convex in b, so its tangent is below it.

    Args:
        problem: the problem.
        full: the motion at which the tangents touch.
        b: (N + 1,) squares of the crank's speed at the nodes [rad2/s2].
        chosen: (2, N) whether to limit the torque, and the power, in each segment.
    """
    grid, drive, motion = problem.coefficients.grid, problem.drive, full.motion
    least_speed, bounds = SLOW * np.abs(motion.speed).max(), []
    for power, segments in zip((None, drive.power), chosen, strict=True):
        states = np.flatnonzero((full.segment >= 0) & segments[full.segment])
        if power is not None:
            states = states[np.abs(motion.speed[states]) > least_speed]
        if not len(states):
            continue
        places = full.segment[states]
        share = (motion.angle[states] - grid.angle[places]) / grid.step[places]
        before, after, fixed = problem.torque_at(share, places)[:3]
        # the error of coefficients between the inner places also grows with b, except near rests
        left = motion.torque[states] - before * b[places] - after * b[places + 1] - fixed
        square = motion.speed[states] ** 2
        fast = square > SLOW * square.max()
        by_square = np.where(fast, left, 0.0) / np.where(fast, square, 1.0)
        torque = Affine(before + (1.0 - share) * by_square, after + share * by_square, fixed + np.where(fast, 0.0, left), places)
        speed = np.maximum(np.abs(motion.speed[states]), least_speed)
        slopes = 0.5 * (1.0 - share) / speed, 0.5 * share / speed
        if power is not None:
            bounds += power_tangents(power, torque, speed, slopes)
        else:
            bounds += peak_torque_bounds(drive, torque)
            bounds += [] if drive.curve_torque is None else curve_tangents(drive, torque, speed, slopes)
    return bounds


def full_motion(press: Linkage, loads: Sequence[Load], friction: Mapping[str, Friction], problem: MotionProblem, b: Array) -> FullMotion:
    """The motion in states within all segments and at rests.

    Args:
        press: the press.
        loads: the loads.
        friction: friction of bearings.
        problem: the problem.
        b: (N + 1,) squares of the crank's speed at the nodes [rad2/s2].
    """
    c, grid = problem.coefficients, problem.coefficients.grid
    durations = segment_times(c, b)
    nodes, rule = LOBATTO
    share = np.clip(nodes, INSIDE, 1.0 - INSIDE)
    speed, acceleration = grid.way * np.sqrt(b[:-1]), 0.5 * np.diff(b) / grid.step
    rests = np.zeros(len(durations))
    last = np.flatnonzero(np.append(np.diff(grid.leg) > 0, True))
    rests[last] = grid.legs.dwells
    cost = figures(problem, b)
    rests[-1] += cycle_time(problem, cost) - cost.time
    start = np.concatenate([[0.0], np.cumsum(durations + rests)])
    since = durations[:, None] * share
    time = start[:-1, None] + since
    angle = grid.angle[:-1, None] + speed[:, None] * since + 0.5 * acceleration[:, None] * since**2
    rate = speed[:, None] + acceleration[:, None] * since
    weight = durations[:, None] * rule
    parts = [time.ravel(), weight.ravel(), angle.ravel(), rate.ravel(), np.repeat(acceleration, len(nodes))]
    segment = np.repeat(np.arange(len(durations)), len(nodes))
    for k in np.flatnonzero(rests)[::-1]:
        at, ends = (k + 1) * len(nodes), np.array([start[k] + durations[k], start[k + 1]])
        # the path does not require this pause, so a brake holds the press in it
        half_dwell = 0.5 * grid.legs.dwells[grid.leg[k]]
        rest = (ends, np.full(2, half_dwell), np.full(2, grid.angle[k + 1]), np.zeros(2), np.zeros(2))
        parts = [np.concatenate([part[:at], more, part[at:]]) for part, more in zip(parts, rest, strict=True)]
        segment = np.insert(segment, at, (-1, -1))
    time_, weight_, angle_, rate_, acceleration_ = parts
    time_ = np.maximum.accumulate(time_)
    time_[-1] = start[-1]
    time_[0] = 0.0
    evaluated_ = evaluated(press, problem.drive, loads, time_, weight_, angle_, rate_, acceleration_, friction, bearings=None)
    return FullMotion(*evaluated_, start, segment)


def largest_excess(problem: MotionProblem, time: float | None, full: FullMotion, b: Array) -> float:
    """Largest share by which the full motion exceeds a limit.

    Args:
        problem: the problem.
        time: the user's time of a cycle, or None [s].
        full: the motion.
        b: (N + 1,) squares of the crank's speed at the nodes [rad2/s2].
    """
    motion, reactions, cost = full.motion, full.reactions, figures(problem, b)
    drive, excesses = problem.drive, [0.0]
    if time is not None:
        excesses.append(abs(cost.time / time - 1.0) if problem.time is None else cost.time / time - 1.0)
    if drive.peak_torque is not None:
        excesses.append(float((np.abs(motion.motor_torque) / drive.peak_torque_at(motion.motor_speed)).max()) - 1.0)
    if drive.top_speed is not None:
        excesses.append(float(np.abs(motion.motor_speed).max()) / drive.top_speed - 1.0)
    if drive.power is not None:
        excesses.append(motion.peak_power / drive.power - 1.0)
    if problem.rms is not None:
        excesses.append(motion.rms_torque / problem.rms - 1.0)
    if problem.below is not None:
        excesses.append((cost.below + problem.feed_time) / motion.duration - 1.0)
    for limit in problem.limits:
        if isinstance(limit, limits_.BearingForce):
            excesses.append(float(np.linalg.norm(reactions.bearing_force[limit.bearing], axis=1).max()) / limit.force - 1.0)
        elif isinstance(limit, limits_.TorqueRate):
            excesses.append(float(torque_rates(problem, b).max()) / drive.ratio / limit.rate - 1.0)
        elif isinstance(limit, limits_.StateLimit):
            value, most = largest_size(motion, limit)
            excesses.append(value / most - 1.0)
    return max(excesses)
