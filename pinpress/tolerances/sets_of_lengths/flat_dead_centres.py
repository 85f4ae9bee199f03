"""The outermost slide position in sets of lengths that turn back at more places than the nominal press, or at another place.

A knuckle press turns back with a stretched or an almost stretched knuckle. With other lengths the crank may move the knuckle through the
stretched pose. Then one turning point becomes three: two outer points and an inner one between them. Similarly, a driver that slides may
reach a turning point before its limit. There the slide's path is flat, and Newton's method from the nominal position finds the inner point,
or no point. So the drivers of such sets move on step by step, in both directions, as long as the slide moves inwards only slowly. Each
turning point on the way is then located between two steps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.numerics import bracketed_roots
from ...common.products import product
from ...common.quantities import Array
from ...engines.engine import MOST_NEWTON_STEPS
from .endings import PIECE, Ending, follow_to_end, refuse_lost, same_assembly
from .shapes import Shapes

SLOW = 0.03  # largest share of the slide's mean speed that counts as slow


class TurningPoint(NamedTuple):
    """A place where the slide of the nominal press turns back, or where a driver that slides is at a limit.

    Attributes:
        ending: the end there, a "dead centre" or "held".
        upwards: whether the place is an upper one.
        ways: directions in which the driver can move on: 1 and -1, one of them at a limit, or empty if the driver is held.
        second: second derivative of the slide position by the driver.
        speed: mean speed of the slide over its motion, per speed of the driver [m/rad or -].
        step: step of the driver [rad or m].
        steps: number of steps to the end of the motion, a period or a travel.
    """

    ending: Ending
    upwards: bool
    ways: tuple[int, ...] = ()
    second: float = 0.0
    speed: float = 0.0
    step: float = 0.0
    steps: int = 0


def outermost_positions(shapes: Shapes, deviations: Array, point: TurningPoint) -> Array:
    """Outermost slide positions (n,) near a turning point, of sets of deviations (k, n) [m].

    Raises:
        PinpressError: some of these presses cannot be closed there.
    """
    ended, outwards = follow_to_end(shapes, deviations, point.ending), 1.0 if point.upwards else -1.0
    position, sound = ended.position, ended.sound
    if point.ending.kind == "dead centre":
        # With half of the nominal curvature a set turns back at one place, like the nominal press.
        flat = ~sound | (outwards * ended.second > -0.5 * abs(point.second))
    else:
        flat = np.any([outwards * way * ended.rate > -SLOW * point.speed for way in point.ways], axis=0) & sound
    doubtful = np.flatnonzero(flat)
    for begin in range(0, len(doubtful), PIECE):
        sets = doubtful[begin : begin + PIECE]
        position[sets], sound[sets] = _follow(shapes, deviations[:, sets], point, outwards)
    refuse_lost(shapes, deviations, sound, f"at {'top' if point.upwards else 'bottom'} dead centre")
    return position


class _States(NamedTuple):
    """Some sets, closed at positions of their drivers; ``closed``: (n,) whether a set is closed."""

    x: Array
    first: Array
    second: Array
    deviations: Array
    closed: NDArray[np.bool_]

    @staticmethod
    def at(shapes: Shapes, x: Array, deviations: Array) -> _States:
        """Close sets that are nearly closed, without moving their drivers."""
        added = shapes.added(deviations)
        with np.errstate(all="ignore"):  # a set that fails shows in its gap
            for _ in range(MOST_NEWTON_STEPS + 1):
                solution = shapes.evaluated(x, added)
                closed, x = solution.gap <= shapes.tolerance, x + solution.step
                if closed.all() or not np.isfinite(solution.gap).any():
                    break
        return _States(x, solution.first, solution.second, deviations, closed)

    def of(self, sets: NDArray[np.intp]) -> _States:
        """Some of these sets."""
        coordinates = self.x[:, sets], self.first[:, sets], self.second[:, sets]
        return _States(*coordinates, self.deviations[:, sets], self.closed[sets])

    def driven(self, shapes: Shapes, by: Array | float) -> _States:
        """These sets, with their drivers moved by ``by``."""
        return _States.at(shapes, self.x + by * (self.first + 0.5 * by * self.second), self.deviations)


def _follow(shapes: Shapes, deviations: Array, point: TurningPoint, outwards: float) -> tuple[Array, NDArray[np.bool_]]:
    """Outermost positions (n,) of sets, searched from the driver's nominal position, and whether a set is closed on the whole way."""
    guide, _, sign = shapes.press.slide_guide
    start, (still, _) = point.ending.start[:, None], shapes.joint_slopes(point.ending.start)
    moved = product(still, deviations)
    begun = _States.at(shapes, start + moved, deviations)
    sound = begun.closed & same_assembly(shapes, begun.x - start, moved)
    farthest, outermost = shapes.position(begun.x, deviations), np.maximum if point.upwards else np.minimum
    turned = np.zeros(len(sound), dtype=bool)
    for way in point.ways:
        sets, here = np.flatnonzero(sound), begun.of(np.flatnonzero(sound))
        for _ in range(point.steps):
            if not len(sets):
                break
            ahead = here.driven(shapes, way * point.step)
            before, after = (outwards * way * sign * states.first[guide] for states in (here, ahead))
            sound[sets] &= ahead.closed
            between = np.flatnonzero(ahead.closed & (before >= 0.0) & (after < 0.0))
            if len(between):
                turning = _turning_positions(shapes, ahead.of(between), -way * point.step, outwards)
                farthest[sets[between]] = outermost(farthest[sets[between]], turning)
                turned[sets[between]] = True
            on = np.flatnonzero(ahead.closed & (after >= -SLOW * point.speed))
            sets, here = sets[on], ahead.of(on)
        sound[sets] = False  # the slide never goes back
    return farthest, sound & (turned | (point.ending.kind == "held"))


def _turning_positions(shapes: Shapes, after: _States, back: float, outwards: float) -> Array:
    """Positions (n,) where the slide turns back within a step of the driver, from the states after it."""
    guide, _, sign = shapes.press.slide_guide

    def speed(share: Array) -> tuple[Array, Array]:
        states = after.driven(shapes, back * share)
        return outwards * sign * back * states.first[guide], outwards * sign * back * back * states.second[guide]

    count = after.x.shape[1]
    share = bracketed_roots(speed, np.zeros(count), np.ones(count), absolute=1e-8)
    return shapes.position(after.driven(shapes, back * share).x, after.deviations)
