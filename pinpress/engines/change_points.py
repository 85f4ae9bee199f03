"""Change points: crank angles at which two assemblies meet and the drawn one runs smoothly through.

A parallelogram whose links lie in a line may go on as a crossed four-bar; the slide of a crank as long as its rod may go on or stay on the
crankshaft. The equations of the loops do not say which at the point itself, and beside it the rounding of their solution grows as the
distance falls. Yet either assembly is an analytic function of the crank angle. The drawn one is therefore closed on both sides, where the
equations are good, and polynomials through these configurations stand for the assembly between them. If they close the loops there too,
both sides belong to one assembly; at a lock there is no other side.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..common.quantities import Array
from .following import Follower, Node, extend_walk, hermite_at

INNER = 0.35  # share of this range in which polynomials replace the equations, whose rounding grows as 1 / distance^3
LEAP = 1 / 8  # share of this range on either side that is crossed in one step
RESOLVED = 1e-9  # error accepted of the polynomials' positions and influence coefficients [rad, lengths of the linkage]


def _chebyshev_nodes(count: int) -> Array:
    """The nodes from -1 to 1 at which a polynomial of ``count`` terms is best given."""
    return np.asarray(-np.cos((np.arange(count) + 0.5) * np.pi / count))


PLACES = np.delete(_chebyshev_nodes(18), [8, 9])  # of closed configurations over the range: none in its middle
BESIDE = _chebyshev_nodes(12)  # of closed configurations on one side, from which the other side is extrapolated


Gap = Callable[[Array], Array]
"""Joint coordinates (nv, n) -> largest gap (n,) of a loop or relation [m]."""


@dataclass(frozen=True, eq=False, repr=False)
class ChangePoint:
    """The drawn assembly in a range of crank angles round a change point.

    Attributes:
        angle: crank angle of the change point [rad].
        half: half width of the range [rad].
        coefficients: (terms, 3, nv) coefficients of Chebyshev polynomials over the range, for the joint coordinates and their first two
            derivatives by the crank angle.
    """

    angle: float
    half: float
    coefficients: Array

    @property
    def inner(self) -> float:
        """Distance from the change point within which the polynomials replace the equations [rad]."""
        return INNER * self.half

    def over_travel(self, unit: float) -> ChangePoint:
        """See `Branch.over_travel`."""
        return ChangePoint(self.angle * unit, self.half * unit, self.coefficients / unit ** np.arange(3.0)[:, None])

    def at(self, angle: Array) -> tuple[Array, Array, Array]:
        """Joint coordinates and their first two derivatives by the crank angle, (nv, n) each, at crank angles (n,) of the range."""
        position, first, second = np.polynomial.chebyshev.chebval((angle - self.angle) / self.half, self.coefficients)
        return position, first, second


def at_change_point(points: Sequence[ChangePoint], period: float | None, angle: Array) -> int | None:
    """Index of one of the crank angles (n,) that lies at a change point, to rounding; None if none does."""
    for point in points:
        distance = angle - point.angle
        if period is not None:
            distance -= period * np.round(distance / period)
        at = int(np.abs(distance).argmin())
        if abs(distance[at]) < 1e-6:  # [rad]; forces grow as 1 / distance, and are rounding from here on
            return at
    return None


def cross_change_point(
    follower: Follower, nodes: list[Node], angle: float, target: float, gap: Gap
) -> tuple[ChangePoint, list[Node]] | None:
    """The change point near a crank angle at which a walk to a ``target`` has ended, and nodes beyond it; None if the linkage locks."""
    direction = 1.0 if target > nodes[0].angle else -1.0
    half = min(0.3, 0.9 * abs(target - angle))  # width to each side that the polynomials cover [rad]; more would take more of their terms
    while half > 5e-3:
        found = _cross(follower, nodes, angle, direction * half, gap)
        if found is not None:
            return found
        half /= 2
    return None


def _cross(follower: Follower, nodes: list[Node], angle: float, reach: float, gap: Gap) -> tuple[ChangePoint, list[Node]] | None:
    """`cross_change_point` with one half width, ``reach`` [rad], which is positive to cross the point upwards."""
    share = [(angle - node.angle) / reach for node in nodes]
    start = next((k for k in reversed(range(len(nodes))) if share[k] >= LEAP), None)
    if start is None or share[start] > 0.5:
        return None
    finer = follower._replace(longest=min(follower.longest, abs(reach) / 4))
    near = [nodes[start]]
    if extend_walk(finer, near, angle - reach) is not None:
        return None
    places = 0.5 * (1 + LEAP) + 0.5 * (1 - LEAP) * BESIDE
    looked = finer.close(angle - reach * places, hermite_at(near, angle - reach * places))
    opposite = (-LEAP - 0.5 * (1 + LEAP)) / (0.5 * (1 - LEAP))
    guess: Array = np.asarray(np.polynomial.chebyshev.chebval(opposite, _fitted(BESIDE, looked.position.T)))
    closure = finer.close(np.array([angle + LEAP * reach]), guess[:, None])
    moved = float(np.abs(closure.position[:, 0] - guess).max()) / (1 + follower.size)
    # The other assembly is as far from the prediction as the distance, so that a hundredth of it tells them apart.
    if not (closure.gap[0] <= follower.tolerance and moved <= 1e-2 * abs(LEAP * reach) and np.isfinite(closure.second).all()):
        return None
    far = [Node.of(angle + LEAP * reach, closure)]
    if extend_walk(finer, far, angle + reach) is not None:
        return None
    return _joined(finer, near, far, angle, abs(reach), gap)


def _joined(
    follower: Follower, near: list[Node], far: list[Node], angle: float, half: float, gap: Gap
) -> tuple[ChangePoint, list[Node]] | None:
    """The polynomials through closed configurations on both sides, with the nodes of the far side; None if they do not close the loops in
    the middle too."""

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
    # Rounding leaves a fifth of this gap between the polynomials; where lengths are not quite equal there is more.
    closed = max(widest, widest_between) <= follower.tolerance and float(middle.max()) <= 5e-3 * follower.tolerance
    if not (closed and missed <= RESOLVED):
        return None
    return point, far


def _fitted(places: Array, values: Array) -> Array:
    """Coefficients (n, ...) of the Chebyshev polynomials through values (n, ...) at places (n,)."""
    solved = np.linalg.solve(np.polynomial.chebyshev.chebvander(places, len(places) - 1), values.reshape(len(places), -1))
    return np.asarray(solved.reshape(values.shape), dtype=np.float64)
