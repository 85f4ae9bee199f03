"""A largest torque that falls with the speed, like the curve of a motor above its base speed.

At the crank the curve is a chain of lines, torque <= a - k x speed. A line is linear in c, the root of b. No motion is above the curve's
hull, so every program has the hull's rows, which give its bound. These rows allow c to be smaller than the speed. A motion may use this to
exceed the curve. Tangents then limit it: a - k x speed is convex in b, so its tangent is a lower bound. If a curve bends upwards, as at
constant power, the line at the last motion's speed is below the other lines.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from ...common.quantities import Array
from ..drive import ServoDrive
from .motion_problem import Affine, Bounded, MotionProblem


class TorqueLine(NamedTuple):
    """Largest torque at the crank: torque - fall x size of the crank's speed.

    Attributes:
        torque: [N m].
        fall: not negative [N m s/rad].
    """

    torque: float
    fall: float


def curve_name(drive: ServoDrive) -> str:
    """The curve as text, with its largest torque."""
    return f"curve of torque of the motor of {max(drive.curve_torque or (0.0,)):.6g} N m"


def hull_bounds(problem: MotionProblem) -> list[Bounded]:
    """The curve's hull as limits of the mean torque of segments and of c, exact where c is the speed."""
    drive, torque = problem.drive, problem.mean_torque()
    bounds = []
    for line in _lines(_hull(_points(drive))):
        most = np.full(len(torque.segments), line.torque)
        words = curve_name(drive)
        bounds.append(Bounded(words, most, line.torque / drive.ratio, "N m", torque, both=True, drag=drive.crank_drag, by_speed=line.fall))
    return bounds


def curve_use(problem: MotionProblem, b: Array) -> Array:
    """(N,) mean torque / torque of the curve at the mean speed, of each segment [-]."""
    drive = problem.drive
    speed = 0.5 * (np.sqrt(b[1:]) + np.sqrt(b[:-1]))
    torque = problem.mean_torque().at(b) + drive.crank_drag * problem.coefficients.grid.way * speed
    return np.asarray(np.abs(torque) / (drive.ratio * drive.peak_torque_at(drive.ratio * speed)))


def curve_tangents(problem: MotionProblem, b: Array) -> list[Bounded]:
    """Mean torques of segments below tangents of the curve at a motion; the drag of the drive counts at the speed of b."""
    drive, mean, speed = problem.drive, problem.mean_torque(), np.sqrt(b)
    total = speed[1:] + speed[:-1]
    drag = 0.5 * drive.crank_drag * problem.coefficients.grid.way * total
    bounds = []
    for torque, fall in _active_lines(drive, 0.5 * total):
        # at a rest b is no variable
        slopes = [np.divide(-0.25 * fall, each, out=np.zeros_like(each), where=each > 0) for each in (speed[:-1], speed[1:])]
        level = torque - 0.5 * fall * total - slopes[0] * b[:-1] - slopes[1] * b[1:]
        for sign in (1.0, -1.0):
            quantity = Affine(sign * mean.before - slopes[0], sign * mean.after - slopes[1], sign * (mean.fixed + drag), mean.segments)
            bounds.append(Bounded(curve_name(drive), level, max(drive.curve_torque or (0.0,)), "N m", quantity))
    return bounds


def tangents_at_states(drive: ServoDrive, torque: Affine, share: Array, speed: Array) -> list[Bounded]:
    """Torques at states within segments below tangents of the curve at their speeds.

    Args:
        drive: the drive.
        torque: of each state, its drag included.
        share: (m,) place of each state in its segment, as a share of the step [-].
        speed: (m,) absolute speed of the crank at these states, not 0 [rad/s].
    """
    bounds = []
    for most, fall in _active_lines(drive, speed):
        slope = 0.5 * fall / speed
        level = most - 0.5 * fall * speed
        for sign in (1.0, -1.0):
            before, after = sign * torque.before + slope * (1.0 - share), sign * torque.after + slope * share
            quantity = Affine(before, after, sign * torque.fixed, torque.segments)
            bounds.append(Bounded(curve_name(drive), level, max(drive.curve_torque or (0.0,)), "N m", quantity))
    return bounds


def _points(drive: ServoDrive) -> list[tuple[float, float]]:
    """Corners of the curve at the crank: speed [rad/s], torque [N m]."""
    speeds, torques = drive.curve_speed or (), drive.curve_torque or ()
    return [(speed / drive.ratio, torque * drive.ratio) for speed, torque in zip(speeds, torques, strict=True)]


def _hull(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The corners on the upper hull of a curve."""
    kept: list[tuple[float, float]] = []
    for x, y in points:
        while len(kept) > 1 and (kept[-1][1] - kept[-2][1]) * (x - kept[-2][0]) <= (y - kept[-2][1]) * (kept[-1][0] - kept[-2][0]):
            kept.pop()
        kept.append((x, y))
    return kept


def _lines(points: list[tuple[float, float]]) -> list[TorqueLine]:
    """The lines between corners."""
    lines = []
    for (x, y), (x2, y2) in itertools.pairwise(points):
        fall = max(0.0, (y - y2) / (x2 - x))
        lines.append(TorqueLine(y + fall * x, fall))
    return lines


def _active_lines(drive: ServoDrive, speed: Array) -> list[tuple[Array, Array]]:
    """Torques (m,) and falls (m,) of the lines that limit the torque at speeds (m,), one for each part of the curve that bends upwards."""
    runs: list[list[TorqueLine]] = []
    for line in _lines(_points(drive)):
        if runs and line.fall <= runs[-1][-1].fall:
            runs[-1].append(line)
        else:
            runs.append([line])
    found = []
    for run in runs:
        torques, falls = (np.array([line[k] for line in run])[:, None] for k in range(2))
        chosen = (torques - falls * speed).argmax(axis=0)
        found.append((torques[chosen, 0], falls[chosen, 0]))
    return found
