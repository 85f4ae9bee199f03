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
from .motion_problem import Affine, Bounded, MotionProblem, below_tangents


class TorqueLine(NamedTuple):
    """Largest torque at the crank: torque - fall x size of the crank's speed."""

    torque: float  # [N m]
    fall: float  # not negative [N m s/rad]


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
    drive, (torque, speed) = problem.drive, problem.with_drag(b)
    return np.asarray(np.abs(torque.at(b)) / (drive.ratio * drive.peak_torque_at(drive.ratio * speed)))


def curve_tangents(drive: ServoDrive, torque: Affine, speed: Array, slopes: tuple[Array, Array]) -> list[Bounded]:
    """Limits of the torque by tangents of the curve at these speeds; for ``speed`` and ``slopes`` see `below_tangents`."""
    runs: list[list[TorqueLine]] = []  # parts of the curve that bend upwards
    for line in _lines(_points(drive)):
        if runs and line.fall <= runs[-1][-1].fall:
            runs[-1].append(line)
        else:
            runs.append([line])
    bounds = []
    for run in runs:
        torques, falls = np.array(run).T
        active = (torques[:, None] - falls[:, None] * speed).argmax(axis=0)
        allowed, limit = torques[active] - falls[active] * speed, (curve_name(drive), max(drive.curve_torque or (0.0,)), "N m")
        bounds += below_tangents(torque, allowed, falls[active], speed, slopes, limit)
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
