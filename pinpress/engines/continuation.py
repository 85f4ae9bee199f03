"""Following an assembly of a linkage from one closed configuration to the next, in steps so small that another cannot be reached."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array
from .closure import Close, Closure

COARSE_STEP = 2 * np.pi / 64  # longest step of the walk, unless the linkage moves too fast for it [rad]
FIRST_STEP = 1e-3  # of the walk, to learn how the margins change [rad]
SMALLEST_STEP = 1e-10  # the walk ends where it would need a shorter one: the linkage locks there [rad]
SMALLEST_MARGIN = 1e-6  # below it rounding of the loop equations decides where two assemblies meet: the walk ends there too


class SingularPosition(NamedTuple):
    """Where a walk ended: the crank angle [rad] at which the linkage locks or two assemblies meet, and the margin left before it."""

    angle: float
    margin: float


class Follower(NamedTuple):
    """How a branch is followed, see `branch.walk`: in steps up to the ``longest``."""

    close: Close
    size: float
    tolerance: float
    longest: float = COARSE_STEP
    smallest_margin: float = SMALLEST_MARGIN


@dataclass(frozen=True, eq=False, repr=False)
class Node:
    """A closed configuration of a walk; see `Closure`."""

    angle: float
    position: Array
    first: Array
    second: Array
    margins: Array

    @staticmethod
    def of(angle: float, closure: Closure) -> Node:
        assert closure.margins is not None
        return Node(angle, closure.position[:, 0], closure.first[:, 0], closure.second[:, 0], closure.margins[:, 0])


def advance(follower: Follower, nodes: list[Node], target: float) -> SingularPosition | None:
    """Append nodes up to the crank angle ``target``; where the linkage locks before it, say where."""
    direction = 1.0 if target > nodes[-1].angle else -1.0
    step = FIRST_STEP
    weight = 1.0 / (1.0 + follower.size)
    while abs(target - nodes[-1].angle) > 0:
        last = nodes[-1]
        ahead = _singularity_ahead(nodes[-2], last) if len(nodes) > 1 else np.inf
        margin = float(np.abs(last.margins).min(initial=1.0))
        if margin < follower.smallest_margin:
            return SingularPosition(last.angle + direction * min(ahead, follower.longest), margin)
        step = min(step, 0.5 * ahead)
        remaining = abs(target - last.angle)
        # the last step of a turn is stretched or cut to end on it exactly
        angle = target if remaining <= 1.01 * step else last.angle + direction * step
        h = angle - last.angle
        guess = last.position + h * (last.first + 0.5 * h * last.second)
        closure = follower.close(np.array([angle]), guess[:, None])
        if _belongs(closure, guess, last, h, weight, follower.tolerance):
            nodes.append(Node.of(angle, closure))
            step = min(2 * step, follower.longest)
        else:
            step = min(step, abs(h)) / 2
            if step < SMALLEST_STEP:
                return SingularPosition(last.angle, margin)
    return None


def _singularity_ahead(before: Node, last: Node) -> float:
    """Crank angle in which the first of the margins would reach zero, falling on as it has fallen [rad].

    A change point that the linkage runs through smoothly shows in nothing but a margin that falls to zero and rises again.
    """
    margins, fallen = np.abs(last.margins), np.abs(before.margins) - np.abs(last.margins)
    share = np.max(fallen / margins, initial=0.0)
    return float(abs(last.angle - before.angle) / share) if share > 0 else np.inf


def _belongs(closure: Closure, guess: Array, last: Node, h: float, weight: float, tolerance: float) -> bool:
    """Whether a closed configuration is the continuation of the last node and not another assembly.

    Newton's method must have moved it little from its prediction, compared with the step itself, and every margin, which passes through
    zero where assemblies meet, must have kept its sign and half its value.
    """
    assert closure.margins is not None
    if not closure.gap[0] <= tolerance or not np.all(np.isfinite(closure.second)):
        return False
    before, margins = np.abs(last.margins), closure.margins[:, 0] * np.sign(last.margins)
    if np.any(margins < 0.5 * before) or np.any(margins > 2.0 * np.maximum(before, 0.25)):
        return False
    correction = weight * np.abs(closure.position[:, 0] - guess).max()
    return bool(correction <= 0.1 * abs(h) * (1.0 + weight * np.abs(last.first).max()))


def follow(close: Close, start: Array, distance: float, size: float, tolerance: float) -> Array | SingularPosition:
    """The closed configuration (nv,) a ``distance`` [rad] along a path, followed from the closed one ``start`` (nv,) at its beginning; or
    where the linkage locks on the way. ``close`` takes distances along the path for crank angles."""
    nodes = [Node.of(0.0, close(np.zeros(1), start[:, None]))]
    locked = advance(Follower(close, size, tolerance), nodes, distance)
    return nodes[-1].position if locked is None else locked


def hermite(angles: Array, position: Array, first: Array, second: Array) -> Array:
    """Coefficients (m, 6, nv) of the quintics with these values and derivatives (m + 1, nv) at both ends.

    Written out, because SciPy's BPoly would cost its import (longer than everything else a first cycle does).
    """
    h = np.diff(angles)[:, None]
    value = position[1:] - position[:-1] - h * (first[:-1] + 0.5 * h * second[:-1])
    slope = h * (first[1:] - first[:-1] - h * second[:-1])
    bend = 0.5 * h**2 * (second[1:] - second[:-1])
    powers = [
        position[:-1],
        first[:-1],
        0.5 * second[:-1],
        (10 * value - 4 * slope + bend) / h**3,
        (-15 * value + 7 * slope - 2 * bend) / h**4,
        (6 * value - 3 * slope + bend) / h**5,
    ]
    return np.ascontiguousarray(np.stack(powers, axis=1))  # so that a prediction copies a few rows and not the table


def hermite_at(nodes: Sequence[Node], angle: Array) -> Array:
    """Joint coordinates (nv, n) at crank angles (n,) from the quintics through nodes in the order of a walk."""
    rising = sorted(nodes, key=lambda node: node.angle)
    borders = np.array([node.angle for node in rising])
    coefficients = hermite(borders, *(np.array([getattr(node, name) for node in rising]) for name in ("position", "first", "second")))
    interval = borders[1:-1].searchsorted(angle, side="right")
    powers = np.vander(angle - borders[interval], 6, increasing=True)
    return np.asarray(np.einsum("nkj,nk->jn", coefficients[interval], powers))
