"""How far the redundant equations of a linkage contradict each other, because the numbers of its file are rounded.

Two points on one hinge, or a hinge of five equations in a planar loop, hold more than they need. With rounded numbers such loops do not
close exactly, and singular values that should be zero are about as large as the gap that is left: 0.1 to 3 times, in lengths of the
linkage, where those of equations that count are 0.1 and more. So the gap shows where the line between them is. It is sought at the pose
where the sum of squared gaps is least, and at poses further along all freedoms, because files may have been made so that they close as
drawn.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..common.quantities import Array
from .pinocchio.equations import OneConfiguration
from .rank import ranks, singular_values, unit_columns
from .structure import ZERO, Structure

LARGEST = 1e-3  # misfit above which loops contradict each other [lengths of the linkage]
CLEAR = 100.0  # by which the last singular value that counts is larger than the first that does not
MOST_STEPS = 60  # of Gauss and Newton, which equations that nearly agree slow down
FURTHER = 0.3  # by which the fastest joint is moved from one pose to the next [rad, lengths of the linkage]
POSES = 4  # to either side


class _Pose(NamedTuple):
    """A pose where the sum of squared gaps is least.

    Attributes:
        x: (nv,) joint coordinates.
        gap: largest gap of a loop or relation [lengths of the linkage].
        columns: (rows, nv) Jacobian of the equations.
        free: (nv, k) joint rates by which all equations but those that may be false let it move.
    """

    x: Array
    gap: float
    columns: Array
    free: Array


def with_misfit(structure: Structure, start: Array) -> Structure:
    """The structure with its misfit, from joint coordinates (nv,) near a closed pose; the same one, if its equations agree within rounding
    error, or if they contradict each other so much that no misfit explains it."""
    poses = sorted(_poses(structure, start), key=lambda pose: pose.gap)
    # A gap ten times as wide elsewhere still counts as closed.
    while poses and 0.1 * structure.tolerance < poses[-1].gap * structure.size < LARGEST * structure.size:
        gap = poses[-1].gap
        tolerance = _rank_tolerance(gap)
        values = np.array([singular_values(pose.columns, tolerance) for pose in poses])
        counts = ranks(values, tolerance)
        r = int(counts.max())
        if counts[-1] == r:
            # The last that counts in any pose against the first that does not in all of them.
            false = float(values[:, r].max()) if r < values.shape[1] else 0.0
            # Such an equation opens by its singular value over a motion of 1 rad.
            misfit = max(gap, false)
            clear = r > 0 and values[:, r - 1].max() > CLEAR * false and misfit < LARGEST
            return replace(structure, misfit=misfit * structure.size) if clear else structure
        poses.pop()  # its gap is that of a lock, or of another assembly that two meet in
    return structure


def _rank_tolerance(gap: float) -> float:
    """`Structure.rank_tolerance` by a gap that may be a misfit [lengths of the linkage]."""
    return max(ZERO, 30 * min(gap, LARGEST))


def _poses(structure: Structure, start: Array) -> list[_Pose]:
    """Poses of least squares: near a start, and on the way from there by all freedoms at once, in two opposite directions."""
    one = OneConfiguration(structure)
    near = _least_squares(one, structure, start, 0.0)
    if near is None:
        return []
    poses = [near]
    for sign in (1.0, -1.0):
        pose, way = near, sign * np.random.default_rng(0).uniform(-1.0, 1.0, len(start)) * structure.lengths
        for _ in range(POSES):
            way = pose.free @ (np.linalg.pinv(pose.free) @ way)
            longest = float(np.abs(way / structure.lengths).max(initial=0.0))
            if not longest:
                break
            # A pose that happens to close has no misfit to tell its rank by: that of the others does.
            further = _least_squares(one, structure, pose.x + FURTHER / longest * way, max(each.gap for each in poses))
            if further is None or not further.gap < LARGEST:
                break  # a lock, or another assembly
            poses.append(further)
            pose = further
    return poses


def _least_squares(one: OneConfiguration, structure: Structure, x: Array, misfit: float) -> _Pose | None:
    """The pose of least squares near joint coordinates (nv,), by the steps of Gauss and Newton; None if they do not end.

    Args:
        one: the equations.
        structure: of the linkage.
        x: (nv,) joint coordinates.
        misfit: at other poses [lengths of the linkage].
    """
    size, before = structure.size, np.inf
    for _ in range(MOST_STEPS):
        rows = one.at(x)
        gap = _widest(rows.gaps, len(one.loops)) / size
        tolerance = _rank_tolerance(max(gap, misfit))
        scaled, lengths = unit_columns(rows.columns, tolerance)
        left, values, right = np.linalg.svd(scaled, full_matrices=True)
        r = int(ranks(values, tolerance))
        closing = left[:, :r].T @ rows.gaps / size  # what the step takes away of the gaps
        left_open = float(np.abs(closing).max(initial=0.0))
        if not np.isfinite(left_open):
            return None
        if left_open <= 1e-15 or 0.5 * before < left_open < 1e-12:
            return _Pose(x, gap, rows.columns, right[_surely(values) :].T / lengths[:, None])
        step = right[:r].T @ (size * closing / values[:r]) / lengths
        longest = float(np.abs(step / structure.lengths).max(initial=0.0))
        x, before = x - step * min(1.0, 0.5 / longest), left_open  # a longer step may lead to another assembly
    return None


def _surely(values: Array) -> int:
    """Number of the singular values (k,), largest first, before the first clear drop among those that may be false: small loops of a large
    robot have small ones that count."""
    most = int(ranks(values, 30 * LARGEST))
    drops = np.flatnonzero(values[max(most, 1) - 1 : -1] > CLEAR * values[max(most, 1) :])
    return max(most, 1) + int(drops[0]) if len(drops) else most


def _widest(gaps: Array, loops: int) -> float:
    """The largest gap of a loop or relation [m], from the gaps (rows,) of all equations."""
    points = np.linalg.norm(gaps[: 3 * loops].reshape(-1, 3), axis=1)
    return float(max(points.max(initial=0.0), np.abs(gaps[3 * loops :]).max(initial=0.0)))
