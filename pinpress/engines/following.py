"""An assembly followed from one closed configuration to the next, in steps so small that another assembly cannot be reached.

One driver's assembly is walked step by step. A path of several drivers is closed all at once where the steps between its positions are as
short as those of a walk: a step of a path counts only where it would count in a walk.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.numerics import quintics
from ..common.products import product
from ..common.quantities import CRANK, Array, DriverCoordinate
from .engine import Close, CloseDrivers, Closure
from .structure import SMALLEST_MARGIN

COARSE_STEP = 2 * np.pi / 64  # longest step of the walk, unless the linkage moves too fast for it [rad]
FIRST_STEP = 1e-3  # first step of the walk, which shows how the margins change [rad]
AT_ONCE = 16  # most steps of a walk that are closed at once
ROUNDING = 1e-12  # of a joint's position [rad, lengths of the linkage]


class SingularPosition(NamedTuple):
    """Where a walk ended because the linkage locks or two assemblies meet.

    Attributes:
        angle: crank angle [rad].
        margin: smallest margin at the last node before it, see `Closure`.
    """

    angle: float
    margin: float


class Follower(NamedTuple):
    """How a branch is followed.

    Attributes:
        close: closes the loops.
        size: length of the linkage [m].
        tolerance: gap at which a loop is closed [m].
        longest: longest step of the walk [rad].
        smallest_margin: margin below which the walk ends.
        unit: travel of a driver that slides, counted as 1 rad [m].
        coordinate: of the driver.
        farthest: (nv,) how far a joint may move from its start [rad or m]; the walk ends beyond that.
    """

    close: Close
    size: float
    tolerance: float
    longest: float = COARSE_STEP
    smallest_margin: float = SMALLEST_MARGIN
    unit: float = 1.0
    coordinate: DriverCoordinate = CRANK
    farthest: Array | float = np.inf


@dataclass(frozen=True, eq=False, repr=False)
class Node:
    """A closed configuration of a walk. All attributes but the angle are columns of a `Closure`.

    Attributes:
        angle: crank angle [rad].
        position: (nv,) joint coordinates [rad or m].
        first: (nv,) first-order influence coefficients.
        second: (nv,) second-order influence coefficients.
        margins: (blocks,) margins, see `Closure`.
    """

    angle: float
    position: Array
    first: Array
    second: Array
    margins: Array

    @staticmethod
    def of(angle: float, closure: Closure, place: int = 0) -> Node:
        """The node at a crank angle, from the column ``place`` of a closure."""
        assert closure.margins is not None
        return Node(angle, *(each[:, place] for each in (closure.position, closure.first, closure.second, closure.margins)))


def follow(
    close: Close, start: Array, distance: float, size: float, tolerance: float, smallest_margin: float = SMALLEST_MARGIN
) -> Array | SingularPosition:
    """Follow an assembly along a path, and return its configuration (nv,) at the end, or the place where it locks on the way.

    Args:
        close: closing function that takes distances along the path in place of crank angles.
        start: (nv,) closed configuration at the beginning of the path.
        distance: length of the path, counted as an angle [rad].
        size: length of the linkage [m].
        tolerance: gap at which a loop counts as closed [m].
        smallest_margin: margin below which the linkage counts as locked.
    """
    nodes = [Node.of(0.0, close(np.zeros(1), start[:, None]))]
    locked = extend_walk(Follower(close, size, tolerance, smallest_margin=smallest_margin), nodes, distance)
    return nodes[-1].position if locked is None else locked


def extend_walk(follower: Follower, nodes: list[Node], target: float) -> SingularPosition | None:
    """Append nodes up to the crank angle ``target``. Returns where the linkage locks before it, None if it does not.

    Steps of full length are closed several at once, which takes a third of the time; only those that count one after the other are kept.
    """
    direction = 1.0 if target > nodes[-1].angle else -1.0
    step, tried = FIRST_STEP, 1
    share = 0.5 * min(1.0, follower.longest / COARSE_STEP)  # towards a singularity all steps are as much shorter as the longest one is
    while abs(target - nodes[-1].angle) > 0:
        last = nodes[-1]
        ahead = _singularity_ahead(nodes[-2], last) if len(nodes) > 1 else np.inf
        margin = float(np.abs(last.margins).min(initial=1.0))
        if np.any(np.abs(last.position - nodes[0].position) > follower.farthest):
            return SingularPosition(last.angle, margin)
        if margin < follower.smallest_margin:
            return SingularPosition(last.angle + direction * min(ahead, follower.longest), margin)
        step = min(step, share * ahead)
        count = tried if step == follower.longest else 1
        angles = last.angle + direction * step * np.arange(1 + count, dtype=np.float64)
        ends = np.flatnonzero(np.abs(target - angles[:-1]) <= 1.01 * step)
        if len(ends):  # the last step of a turn is stretched or cut to end on it exactly
            angles = np.append(angles[: ends[0] + 1], target)
        h = angles - last.angle
        guess = last.position[:, None] + h * (last.first[:, None] + 0.5 * h * last.second[:, None])
        closure = follower.close(angles, guess)
        good = _continues(closure, np.diff(angles), follower.size, follower.tolerance, share, follower.smallest_margin)
        inside = np.abs(closure.position[:, :-1] - nodes[0].position[:, None]) <= np.reshape(follower.farthest, (-1, 1))
        count = _leading(good & inside.all(axis=0))
        nodes += [Node.of(float(angles[k]), closure, k) for k in range(1, count + 1)]
        tried = min(AT_ONCE, max(1, 2 * count))  # one that is far away can keep Newton's method from closing those that are near
        if count:
            step = min(2 * step, follower.longest)
        elif len(angles) == 2:
            step = min(step, abs(h[1])) / 2
            if step < 1e-10:  # [rad] rounding of a crank angle, nearly: the linkage locks here
                return SingularPosition(last.angle, margin)
    return None


def _singularity_ahead(before: Node, last: Node) -> float:
    """Crank angle after which the first of the margins would reach zero if all went on falling as between these nodes [rad].

    Nothing but such a margin shows a change point that the linkage runs through smoothly.
    """
    margins, fallen = np.abs(last.margins), np.abs(before.margins) - np.abs(last.margins)
    share = np.max(fallen / margins, initial=0.0)
    return float(abs(last.angle - before.angle) / share) if share > 0 else np.inf


def _continues(
    closure: Closure, steps: Array, size: float, tolerance: float, share: float = 0.5, smallest_margin: float = SMALLEST_MARGIN
) -> NDArray[np.bool_]:
    """Whether each of s steps between s + 1 configurations continues an assembly, and does not go over to another one.

    Newton's method must have corrected the prediction from the configuration before by little, compared with the step. Every margin must
    have kept its sign and half its value, because it passes through zero where assemblies meet, and a step must be no longer than a part of
    the way on which it would reach zero, if it went on falling as in the step before.

    Args:
        closure: the configurations.
        steps: (s,) steps between them [rad].
        size: length of the linkage [m].
        tolerance: gap at which a loop counts as closed [m].
        share: the part of that way.
        smallest_margin: margin before a step below which the linkage counts as locked.
    """
    assert closure.margins is not None
    weight, lengths = 1.0 / (1.0 + size), np.abs(steps)
    closed = (closure.gap <= tolerance) & np.isfinite(closure.second).all(axis=0)
    last, first, second = closure.position[:, :-1], closure.first[:, :-1], closure.second[:, :-1]
    with np.errstate(all="ignore"):  # of configurations that are not closed
        corrections = weight * np.abs(closure.position[:, 1:] - last - steps * (first + 0.5 * steps * second)).max(axis=0)
        near = corrections <= 0.1 * lengths * (1.0 + weight * np.abs(first).max(axis=0)) + ROUNDING
        before, after = np.abs(closure.margins[:, :-1]), closure.margins[:, 1:] * np.sign(closure.margins[:, :-1])
        kept = (before >= smallest_margin) & (after >= 0.5 * before) & (after <= 2.0 * np.maximum(before, 0.25))
        near[1:] &= lengths[1:] * _falling(before, after, lengths)[:-1] <= share
    return np.asarray(closed[:-1] & closed[1:] & near & kept.all(axis=0))


def _falling(before: Array, after: Array, steps: Array) -> Array:
    """Inverse of the way (s,) after which the first of the margins (blocks, s) would reach zero behind each of s steps [1/rad]."""
    return np.asarray(np.max((before - after) / after, axis=0, initial=0.0) / steps)


def _leading(good: NDArray[np.bool_]) -> int:
    """How many there are before the first that is not good."""
    return len(good) if good.all() else int(np.argmin(good))


# ------------------------------------------------------------------------------------------------------------- a path of several drivers


class Path(NamedTuple):
    """Positions of several drivers, one after the other, and the stations between them at which the linkage is closed.

    Attributes:
        stations: (s + 1, drivers) driver positions [rad or m]; the first one is where the path begins.
        steps: (s,) distances between them [rad].
        along: (s + 1, drivers) rates of the drivers by this distance, from each station to the next.
        ends: (n,) indices of the stations that are the positions.
    """

    stations: Array
    steps: Array
    along: Array
    ends: NDArray[np.intp]


def path_between(positions: Array, lengths: Array, most: int) -> Path:
    """The path through positions, in steps no longer than those of a walk. Where it begins or turns off, a short step shows how the margins
    change.

    Args:
        positions: (n + 1, drivers) of the drivers [rad or m].
        lengths: (drivers,) what counts as 1 rad of each.
        most: number of steps after which the path ends, at the last position before.
    """
    ways = np.diff(positions, axis=0)
    distances = np.linalg.norm(ways / lengths, axis=1)
    directions = ways / lengths / np.where(distances, distances, 1.0)[:, None]
    # A path takes another direction where it turns off by more than 60 deg.
    turns_off = np.append(True, (directions[1:] * directions[:-1]).sum(axis=1) < 0.5) & (distances > 2 * FIRST_STEP)
    equal_steps = np.ceil(distances / COARSE_STEP).astype(int)
    counts = equal_steps + turns_off
    ends = np.cumsum(counts)
    ends = ends[ends <= most]
    way = np.repeat(np.arange(len(ends)), counts[: len(ends)])
    place = (
        np.arange(len(way)) - (ends - counts[: len(ends)])[way] + 1 - turns_off[way]
    )  # among the equal steps of its way; 0: the short one
    share = np.where(place == 0, FIRST_STEP / np.where(distances, distances, 1.0)[way], place / equal_steps[way])[:, None]
    stations = np.where(share == 1.0, positions[1:][way], positions[way] + share * ways[way])
    stations = np.concatenate([positions[:1], stations])
    steps = np.linalg.norm(np.diff(stations, axis=0) / lengths, axis=1)
    along = np.zeros_like(stations)
    along[:-1] = np.diff(stations, axis=0) / steps[:, None]
    return Path(stations, steps, along, ends)


def follow_at_once(
    close: CloseDrivers, start: Array, path: Path, size: float, tolerance: float, smallest_margin: float = SMALLEST_MARGIN
) -> Array:
    """Configurations (nv, k) at the first k positions of a path, as many as are found by closing all its stations at once.

    Newton's method starts from where the joints would be if all went on moving as they do at the start. What it finds counts as far as each
    station continues the assembly of the one before it, by the measures of a walk.

    Args:
        close: closing function for positions of all drivers.
        start: (nv,) closed configuration at the beginning of the path.
        path: the path.
        size: length of the linkage [m].
        tolerance: gap at which a loop counts as closed [m].
        smallest_margin: margin below which the linkage counts as locked.
    """
    begin, count = path.stations[0], path.stations.shape[1]
    alike = close(np.repeat(begin[:, None], count, axis=1), np.eye(count), np.repeat(start[:, None], count, axis=1)).first
    guess = start[:, None] + product(alike, (path.stations - begin).T)
    closure = close(path.stations.T, path.along.T, guess)
    steps, good = path.steps, _continues(closure, path.steps, size, tolerance, smallest_margin=smallest_margin)
    assert closure.margins is not None
    with np.errstate(all="ignore"):  # a path counts only where it could be followed back as well
        before, after = np.abs(closure.margins[:, :-1]), closure.margins[:, 1:] * np.sign(closure.margins[:, :-1])
        good[:-1] &= steps[:-1] * _falling(after, before, steps)[1:] <= 0.5
    return np.asarray(closure.position[:, path.ends[path.ends <= _leading(good)]])


# -------------------------------------------------------------------------------------------------- polynomials through the nodes of a walk


def hermite_at(nodes: Sequence[Node], angle: Array) -> Array:
    """Joint coordinates (nv, n) at crank angles (n,) from the quintics through nodes in the order of a walk."""
    rising = sorted(nodes, key=lambda node: node.angle)
    borders = np.array([node.angle for node in rising])
    return evaluated(borders, quintics(np.diff(borders), *columns(rising)), angle)


def columns(nodes: Sequence[Node]) -> tuple[Array, Array, Array]:
    """Positions and their first two derivatives at nodes, (nv, nodes) each."""
    position, first, second = (np.array([getattr(node, name) for node in nodes]).T for name in ("position", "first", "second"))
    return position, first, second


def evaluated(borders: Array, coefficients: Array, angle: Array) -> Array:
    """Values (nv, n) of the polynomials (6, nv, m) between borders (m + 1,) at crank angles (n,), by Estrin's scheme: in fewer steps than
    Horner's, each on more numbers."""
    interval = borders[1:-1].searchsorted(angle, side="right")
    h = angle - borders.take(interval)
    powers = coefficients.take(interval, axis=2)
    pairs = powers[1::2]
    pairs *= h
    pairs += powers[::2]
    x: Array = pairs[2]
    h *= h
    x *= h
    x += pairs[1]
    x *= h
    x += pairs[0]
    return x


def slopes(borders: Array, coefficients: Array, angle: Array) -> Array:
    """Derivatives (nv, n) of the polynomials of `evaluated`."""
    interval = borders[1:-1].searchsorted(angle, side="right")
    h = angle - borders.take(interval)
    x: Array = 5.0 * coefficients[5].take(interval, axis=1)
    for power in (4, 3, 2, 1):
        x *= h
        x += power * coefficients[power].take(interval, axis=1)
    return x
