"""Change points: crank angles at which two assemblies of a linkage meet, and the drawn one runs smoothly through.

A parallelogram whose links lie in a line may go on as a crossed four-bar; the slide of a crank as long as its rod may go on or stay on the
crankshaft. At the point itself the equations of the loops do not say which; beside it they answer with rounding divided by the distance.
Yet either assembly is an analytic function of the crank angle. The drawn one is therefore closed where the equations are good, on both
sides, and polynomials through these configurations are the assembly between them. That they close the loops there too is the proof that
both sides are one assembly; at a lock there is no other side.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..common.arrays import Array
from .continuation import Follower, Node, advance, hermite_at

WIDEST, NARROWEST = 0.3, 5e-3  # half widths of the stretch with polynomials [rad]
INNER = 0.35  # share of it in which they stand for the equations, whose rounding grows as 1 / distance^3
LEAP = 1 / 8  # share of it that is leapt from either side at first
RESOLVED = 1e-9  # what the polynomials may miss, of positions and influence coefficients [rad, lengths of the linkage]
EQUAL = 5e-3  # share of the gap of a closed loop, by which the middle may miss: five times rounding; else links are not of equal length
MET = 1e-6  # distance from a change point at which forces, that grow as 1 / distance, are of rounding [rad]
AMBIGUOUS = 1e-2  # share of the distance across, by which Newton's method may move a joint: the other assembly is as far as that distance


def _spread(count: int) -> Array:
    """Where polynomials of so many terms are best given, -1 to 1."""
    return np.asarray(-np.cos((np.arange(count) + 0.5) * np.pi / count))


PLACES = np.delete(_spread(18), [8, 9])  # of closed configurations over the stretch: none in its middle
BESIDE = _spread(12)  # of those that look across from one side

Gap = Callable[[Array], Array]
"""Joint coordinates (nv, n) -> largest gaps of a loop (n,) [m]."""


@dataclass(frozen=True, eq=False, repr=False)
class ChangePoint:
    """The drawn assembly around a change point.

    Attributes:
        angle: crank angle [rad].
        half: half width of the stretch [rad].
        coefficients: (terms, 3, nv) of Chebyshev polynomials over the stretch: joint coordinates and their first two derivatives by the
            crank angle.
    """

    angle: float
    half: float
    coefficients: Array

    @property
    def inner(self) -> float:
        """Distance from the crank angle within which the equations are not to be solved [rad]."""
        return INNER * self.half

    def at(self, angle: Array) -> tuple[Array, Array, Array]:
        """Joint coordinates and their first two derivatives by the crank angle (nv, n) at crank angles (n,) of the stretch."""
        position, first, second = np.polynomial.chebyshev.chebval((angle - self.angle) / self.half, self.coefficients)
        return position, first, second


def met(points: Sequence[ChangePoint], period: float | None, angle: Array) -> int | None:
    """Index of one of crank angles (n,) that is as good as at a change point, if there is one."""
    for point in points:
        distance = angle - point.angle
        if period is not None:
            distance -= period * np.round(distance / period)
        at = int(np.abs(distance).argmin())
        if abs(distance[at]) < MET:
            return at
    return None


def across(follower: Follower, nodes: list[Node], angle: float, target: float, gap: Gap) -> tuple[ChangePoint, list[Node]] | None:
    """The change point about at a crank angle, at which a walk to a ``target`` has come to its end, and nodes beyond it; None where the
    linkage locks there."""
    direction = 1.0 if target > nodes[0].angle else -1.0
    half = min(WIDEST, 0.9 * abs(target - angle))
    while half > NARROWEST:
        found = _across(follower, nodes, angle, direction * half, gap)
        if found is not None:
            return found
        half /= 2
    return None


def _across(follower: Follower, nodes: list[Node], angle: float, reach: float, gap: Gap) -> tuple[ChangePoint, list[Node]] | None:
    """What `across` finds with one half width, ``reach``: positive to cross the point forwards."""
    share = [(angle - node.angle) / reach for node in nodes]
    start = next((k for k in reversed(range(len(nodes))) if share[k] >= LEAP), None)
    if start is None or share[start] > 0.5:
        return None
    finer = follower._replace(longest=min(follower.longest, abs(reach) / 4))
    near = [nodes[start]]
    if advance(finer, near, angle - reach) is not None:
        return None
    places = 0.5 * (1 + LEAP) + 0.5 * (1 - LEAP) * BESIDE
    looked = finer.close(angle - reach * places, hermite_at(near, angle - reach * places))
    opposite = (-LEAP - 0.5 * (1 + LEAP)) / (0.5 * (1 - LEAP))
    guess: Array = np.asarray(np.polynomial.chebyshev.chebval(opposite, _fitted(BESIDE, looked.position.T)))
    closure = finer.close(np.array([angle + LEAP * reach]), guess[:, None])
    moved = float(np.abs(closure.position[:, 0] - guess).max()) / (1 + follower.size)
    if not (closure.gap[0] <= follower.tolerance and moved <= AMBIGUOUS * abs(LEAP * reach) and np.isfinite(closure.second).all()):
        return None
    far = [Node.of(angle + LEAP * reach, closure)]
    if advance(finer, far, angle + reach) is not None:
        return None
    return _joined(finer, near, far, angle, abs(reach), gap)


def _joined(
    follower: Follower, near: list[Node], far: list[Node], angle: float, half: float, gap: Gap
) -> tuple[ChangePoint, list[Node]] | None:
    """The polynomials through closed configurations on both sides, if they are the assembly in the middle too."""

    def close(angles: Array) -> tuple[Array, float]:
        on_far = (angles - angle) * (far[0].angle - angle) > 0
        guess = np.where(on_far, hermite_at(far, angles), hermite_at(near, angles))
        closure = follower.close(angles, guess)
        return np.array([closure.position, closure.first, closure.second]), closure.widest

    values, widest = close(angle + half * PLACES)
    point = ChangePoint(angle, half, _fitted(PLACES, values.transpose(2, 0, 1)))
    between = angle + half * np.array([-0.9, -0.7, -0.5, -INNER, INNER, 0.5, 0.7, 0.9])
    checked, widest_between = close(between)
    missed = np.abs(checked - np.array(point.at(between))).max() / (1 + follower.size + np.abs(checked).max())
    middle = gap(point.at(angle + point.inner * np.linspace(-1, 1, 9))[0])
    closed = max(widest, widest_between) <= follower.tolerance and float(middle.max()) <= EQUAL * follower.tolerance
    if not (closed and missed <= RESOLVED):
        return None
    return point, far


def _fitted(places: Array, values: Array) -> Array:
    """Coefficients (n, ...) of the Chebyshev polynomials through values (n, ...) at places (n,)."""
    solved = np.linalg.solve(np.polynomial.chebyshev.chebvander(places, len(places) - 1), values.reshape(len(places), -1))
    return np.asarray(solved.reshape(values.shape), dtype=np.float64)
