"""Mounting: closed poses of a linkage from poses in which its loops are far open, by damped least squares.

Newton's method also closes far open loops, but often in another assembly. Damped steps reach the near one: from poses up to 0.2 rad a
joint away undamped steps miss it in one of four cases, damped ones in none (`tests/engines/test_mounting.py`). Gaps of points are divided
by the size of the linkage; rotations are the angles of the rotation vector [rad], because loops may start open by up to half a turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ..common.arguments import LARGEST
from ..common.quantities import Array
from .pinocchio.equations import OneConfiguration
from .structure import Structure

CLOSED = 1e-9  # misfit of a closed pose [lengths of the linkage, rad]
DONE = 1e-11  # misfit at which no further step is taken
STARTS = 20  # random ones
MOST_STEPS = 200
LONGEST_STEP = 0.5  # of a joint [rad, lengths of the linkage]


class Mounted(NamedTuple):
    """Where a mounting ended.

    Attributes:
        position: (nv,) joint coordinates [rad or m].
        misfit: root of the sum of all squared gaps there [lengths of the linkage, rad].
    """

    position: Array
    misfit: float


class Mounting:
    """Mounts one linkage, within the limits of its joints or without. It holds Pinocchio's data: use it within one call."""

    def __init__(self, structure: Structure) -> None:
        self.one, self.structure = OneConfiguration(structure), structure
        self.lengths = structure.lengths
        self.lower, self.upper = limits(structure)
        self.closed = max(CLOSED, structure.tolerance / structure.size)  # that of rounded linkages, and of those far from the origin

    def close(self, start: Array, held: Sequence[int] = (), limited: bool = True) -> Mounted:
        """The pose in which damped least squares end.

        Args:
            start: (nv,) joint coordinates to start from [rad or m].
            held: indices in v of the joints that keep their coordinates.
            limited: whether the other joints stay within their limits.
        """
        free = np.setdiff1d(np.arange(len(start)), held)
        lower, upper = (self.lower[free], self.upper[free]) if limited else (-np.inf, np.inf)
        x, damping = start.copy(), 1e-2
        x[free] = np.clip(x[free], lower, upper)
        gaps, columns = self.equations(x)
        cost = checked = float(gaps @ gaps)
        for step in range(1, MOST_STEPS + 1):
            if cost <= DONE**2 or not len(free):
                break
            slopes = columns[:, free] * self.lengths[free]
            gradient, curvature = slopes.T @ gaps, slopes.T @ slopes
            mean = float(np.trace(curvature)) / len(free)
            if not mean:
                break  # nothing that is free moves a gap
            for _ in range(12):  # by then steps are shorter by ten million
                moved = np.linalg.solve(curvature + damping * mean * np.eye(len(free)), -gradient)
                moved *= min(1.0, LONGEST_STEP / float(np.abs(moved).max(initial=1e-300)))
                ahead = x.copy()
                ahead[free] = np.clip(x[free] + moved * self.lengths[free], lower, upper)
                gaps_ahead, columns_ahead = self.equations(ahead)
                cost_ahead = float(gaps_ahead @ gaps_ahead)
                if cost_ahead < cost:
                    break
                damping *= 4.0
            else:
                break  # a minimum, or rounding
            x, gaps, columns, cost, damping = ahead, gaps_ahead, columns_ahead, cost_ahead, max(damping / 5.0, 1e-12)
            if step % 10 == 0:  # near a closed pose ten steps do more than this
                if cost > 0.999 * checked:
                    break
                checked = cost
        return Mounted(x, float(np.sqrt(cost)))

    def assemblies(self, around: Array, held: Sequence[int], spread: float) -> list[Array]:
        """Different closed poses (nv,) with some joints held, from a pose (nv,) and from random ones about it, each joint up to ``spread``
        away [rad, lengths of the linkage]. They are sought within the limits, the one from the pose itself comes first."""
        random, found = np.random.default_rng(0), list[Array]()
        for k in range(STARTS):
            start = around + min(k, 1) * spread * random.uniform(-1.0, 1.0, len(around)) * self.lengths
            start[list(held)] = around[list(held)]
            reached = self.close(start, held)
            if reached.misfit <= self.closed and all(self.apart(reached.position, other).max() > 1e-3 for other in found):
                found.append(self.without_turns(reached.position))
        return found

    def without_turns(self, position: Array) -> Array:
        """A pose (nv,) without the whole turns that joints without limits, but those of relations, have made from the zeros of the file."""
        turning = self.structure.turns & np.isinf(self.lower) & np.isinf(self.upper)
        turning[[joint for relation in self.structure.relations for joint in relation.joints]] = False
        turns = np.round(position / (2 * np.pi))
        return np.asarray(np.where(turning, position - 2 * np.pi * turns, position))

    def apart(self, one: Array, other: Array) -> Array:
        """Distances (nv,) of the joints in two poses (nv,), those of angles without whole turns [rad, lengths of the linkage]."""
        away = (one - other) / self.lengths
        return np.asarray(np.abs(np.where(self.structure.turns, np.remainder(away + np.pi, 2 * np.pi) - np.pi, away)))

    def told_apart(self, poses: Sequence[Array], count: int, able: Sequence[int]) -> list[dict[str, float]]:
        """The first ``count`` of several poses (nv,) by the one or two joints, of those that are ``able``, that tell each from all others:
        coordinates by the names of joints."""
        names, found = tuple(self.structure.model.names)[1:], list[dict[str, float]]()
        for pose in poses[:count]:
            apart = np.array([self.apart(pose, other)[list(able)] for other in poses if other is not pose]).reshape(-1, len(able))
            places: list[int] = []
            if len(apart):
                places.append(int(apart.min(axis=0).argmax()))
                if apart[:, places[0]].min() < 0.1:  # other assemblies have nearly the same
                    places.append(int(np.maximum(apart, apart[:, places]).min(axis=0).argmax()))
            found.append({names[able[place]]: float(pose[able[place]]) for place in places})
        return found

    def equations(self, x: Array) -> tuple[Array, Array]:
        """Gaps (rows,) and their Jacobian (rows, nv) at joint coordinates (nv,), the order of rows being that of `engines.structure`."""
        rows, row = self.one.at(x), 3 * len(self.structure.loops)
        gaps, columns = rows.gaps / self.structure.size, rows.columns / self.structure.size
        turning = self.one.data.J.reshape(6, -1)[3:]
        for k, loop in enumerate(self.structure.loops):
            if not loop.held_rotations:
                continue
            first = self.one.placements[loop.joint1].rotation @ loop.rotation1
            relative = first.T @ (self.one.placements[loop.joint2].rotation @ loop.rotation2)
            turned = first.T @ (turning * self.structure.incidence[:, k])  # of body 2 against body 1, in the axes of end 1
            of_loop = slice(row, row + loop.held_rotations)
            if loop.type == "fixed":
                gaps[of_loop], columns[of_loop] = pin.log3(relative), pin.Jlog3(relative).T @ turned
            else:
                gaps[of_loop], columns[of_loop] = _aligning(relative[:, 0], turned)
            row += loop.held_rotations
        return gaps, columns


def limits(structure: Structure) -> tuple[Array, Array]:
    """Lower and upper limits (nv,) of the joints [rad or m]; infinite where there are none, or no way between them, as programs write it
    that know no limits."""
    model, lower, upper = structure.model, np.full(structure.model.nv, -np.inf), np.full(structure.model.nv, np.inf)
    for j, slot in enumerate(structure.slots):
        low, high = float(model.lowerPositionLimit[slot.start]), float(model.upperPositionLimit[slot.start])
        if not slot.unbounded and low < high:
            lower[j], upper[j] = low if low > -LARGEST else -np.inf, high if high < LARGEST else np.inf
    return lower, upper


def within(structure: Structure, position: Array) -> NDArray[np.bool_]:
    """Whether each joint (nv,) is within its limits, but for what rounding and closing leave."""
    lower, upper = limits(structure)
    return np.asarray((position >= lower - 1e-6) & (position <= upper + 1e-6))


def _aligning(axis: Array, turned: Array) -> tuple[Array, Array]:
    """The shortest rotation (2,) that turns the first axis of end 1 to the ``axis`` (3,) of end 2, or to its opposite, and its slopes
    (2, nv); ``turned`` (3, nv): rates of body 2 against body 1. All in the axes of end 1."""
    axis = axis if axis[0] >= 0.0 else -axis
    across, cosine = np.array([-axis[2], axis[1]]), float(axis[0])
    sine = float(np.linalg.norm(across))
    ratio, bend = 1.0, -1.0 / 3.0  # angle by sine, and its slope by the cosine
    if sine > 1e-3:
        ratio = float(np.arctan2(sine, cosine)) / sine
        bend = (cosine * ratio - 1.0) / sine**2
    moved = np.cross(turned.T, axis).T
    return ratio * across, ratio * np.array([-moved[2], moved[1]]) + np.outer(across, bend * moved[0])
