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
from .conic.local_limits import torque_rates
from .conic.motion_problem import Affine, Bounded, MotionProblem, cycle_time, figures, segment_times
from .conic.torque_curve import tangents_at_states
from .limits import Limit
from .motion import ServoMotion, evaluated, largest_size

INSIDE = 1e-7  # share of a segment by which its first and last states are moved inwards, because loads may jump at nodes
LOBATTO = np.array([0.0, 0.5 - 0.1 * 5**0.5, 0.5 + 0.1 * 5**0.5, 1.0]), np.array([1.0, 5.0, 5.0, 1.0]) / 12.0
NEAR = 0.95  # share of a limit above which the limit is checked between nodes too
SLOW = 1e-3  # share of the top speed below which the power does not limit the motion


class FullMotion(NamedTuple):
    """A motion by full inverse dynamics.

    Attributes:
        motion: the motion, with states within all segments and at rests.
        reactions: the reactions of the motion.
        time: (N + 1,) times at which the crank passes the nodes, or leaves them after a rest [s].
        segment: index of the segment of each state; -1 at rests.
    """

    motion: ServoMotion
    reactions: Reactions
    time: Array
    segment: NDArray[np.intp]


class Excess(NamedTuple):
    """By how much the torque and the power of a motion exceed the drive's limits.

    Attributes:
        share: the largest excess at an instant, as a share of the limit.
        torque: (N,) whether the torque comes near its limit in the segment.
        power: (N,) whether the power comes near its limit in the segment.
    """

    share: float
    torque: NDArray[np.bool_]
    power: NDArray[np.bool_]

    def join_segments(self, earlier: Excess) -> Excess:
        """This excess, with the segments of an earlier one added."""
        return Excess(self.share, self.torque | earlier.torque, self.power | earlier.power)


def excess_of(problem: MotionProblem, full: FullMotion) -> Excess:
    """By how much a motion exceeds the limits of torque and power of its drive."""
    drive, moving = problem.drive, full.segment >= 0
    shares, near = [0.0], []
    torque = np.abs(full.motion.motor_torque) / drive.peak_torque_at(full.motion.motor_speed)
    power = np.abs(full.motion.power) / (np.inf if drive.power is None else drive.power)
    for values in (torque, power):
        used = values[moving].reshape(-1, len(LOBATTO[0])).max(axis=1)
        shares.append(float(used.max()) - 1.0)
        near.append(used > NEAR)
    return Excess(max(shares), *near)


def limits_at_states(problem: MotionProblem, full: FullMotion, b: Array, chosen: Excess) -> list[Bounded]:
    """Limits of the torque and the power at the states within segments, as tangents at a motion.

    The torque within a segment is linear in b at the segment's ends. The limit power / speed is convex in b, so its tangent is below it.

    Args:
        problem: the problem.
        full: the motion at which the tangents touch.
        b: (N + 1,) squares of the crank's speed at the nodes [rad2/s2].
        chosen: the segments to limit.
    """
    grid, drive, motion = problem.coefficients.grid, problem.drive, full.motion
    bounds = []
    for name, segments in (("torque of the motor", chosen.torque), ("power", chosen.power)):
        states = np.flatnonzero((full.segment >= 0) & segments[full.segment])
        if name == "power":
            states = states[np.abs(motion.speed[states]) > SLOW * np.abs(motion.speed).max()]
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
        before, after = before + (1.0 - share) * by_square, after + share * by_square
        fixed = fixed + np.where(fast, 0.0, left)
        if name == "power":
            assert drive.power is not None
            speed = np.abs(motion.speed[states])
            fall, level = 0.5 * drive.power / speed**3, 1.5 * drive.power / speed
            for sign in (1.0, -1.0):
                torque = Affine(sign * before + fall * (1.0 - share), sign * after + fall * share, sign * fixed, places)
                bounds.append(Bounded(f"power of the motor of {drive.power:.6g} W", level, drive.power, "W", torque))
        else:
            assert drive.peak_torque is not None
            most = np.full(len(places), drive.peak_torque * drive.ratio)
            words = f"torque of the motor of {drive.peak_torque:.6g} N m"
            torque = Affine(before, after, fixed, places)
            if not (drive.curve_torque and drive.curve_torque[0] <= drive.peak_torque):
                bounds.append(Bounded(words, most, drive.peak_torque, "N m", torque, both=True))
            if drive.curve_torque is not None:
                slow = np.maximum(np.abs(motion.speed[states]), SLOW * np.abs(motion.speed).max())
                bounds += tangents_at_states(drive, torque, share, slow)
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
        # a brake holds the press in a pause that the path does not ask for
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


def largest_excess(problem: MotionProblem, limits: Sequence[Limit], time: float | None, full: FullMotion, b: Array) -> float:
    """Largest share by which the full motion exceeds a limit.

    Args:
        problem: the problem.
        limits: the limits in addition to those of the drive.
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
    for limit in limits:
        if isinstance(limit, limits_.BearingForce):
            excesses.append(float(np.linalg.norm(reactions.bearing_force[limit.bearing], axis=1).max()) / limit.force - 1.0)
        elif isinstance(limit, limits_.TorqueRate):
            excesses.append(float(torque_rates(problem, b).max()) / drive.ratio / limit.rate - 1.0)
        elif isinstance(limit, limits_.StateLimit):
            value, most = largest_size(motion, limit)
            excesses.append(value / most - 1.0)
    return max(excesses)
