"""The outermost place of the slide in sets of lengths that turn back at more places than the nominal press, or at another one.

A knuckle press turns back where its knuckle is stretched, or short of it. With other lengths the crank takes the knuckle through the
stretched pose: one turning point becomes three, two outer ones and an inner one between them. A driver that slides may likewise reach a
turning point short of its limit. There the slide's path is flat, and Newton's method from the nominal place finds the inner one, or none.
The drivers of such sets are therefore moved on step by step, both ways, as long as the slide hardly moves inwards, and each place where it
turns back on the way is narrowed down between two steps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.numerics import bracketed_roots
from ...common.products import product
from ...common.quantities import Array
from ...engines.engine import ACCEPTED, MOST_NEWTON_STEPS
from .endings import PIECE, Ending, followed_to, refuse_lost, same_assembly
from .shapes import Evaluated, Shapes

SHARP = 0.5  # share of the nominal curvature from which on a set turns back as the nominal press does, at one place
SLOW = 0.03  # share of the slide's mean speed up to which it hardly moves
NARROW = 1e-8  # bracket of a turning point, as a share of a step


class TurningPoint(NamedTuple):
    """A place where the slide of the nominal press turns back, or where its driver that slides is at a limit.

    Attributes:
        ending: there, a "dead centre" or "held".
        upwards: whether it is an upper one.
        ways: in which the driver can go on: both, 1 and -1, or one at a limit; none where it is held.
        second: second derivative of the slide position by the driver there.
        speed: mean speed of the slide over its motion, by the driver [m/rad or -].
        step: of the driver [rad or m].
        steps: to the end of its motion, a period or a travel.
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
    ended, outwards = followed_to(shapes, deviations, point.ending), 1.0 if point.upwards else -1.0
    position, sound = ended.position, ended.sound
    if point.ending.kind == "dead centre":
        flat = ~sound | (outwards * ended.second > -SHARP * abs(point.second))
    else:
        flat = np.any([outwards * way * ended.rate > -SLOW * point.speed for way in point.ways], axis=0) & sound
    doubtful = np.flatnonzero(flat)
    for begin in range(0, len(doubtful), PIECE):
        sets = doubtful[begin : begin + PIECE]
        position[sets], sound[sets] = _followed(shapes, deviations[:, sets], point, outwards)
    refuse_lost(shapes, deviations, sound, f"at {'top' if point.upwards else 'bottom'} dead centre")
    return position


class _States(NamedTuple):
    """Some sets, each closed with its driver somewhere.

    Attributes:
        x: (nv, n) joint coordinates.
        found: the equations there.
        deviations: (k, n) of them.
        closed: (n,) whether they are closed.
    """

    x: Array
    found: Evaluated
    deviations: Array
    closed: NDArray[np.bool_]

    @staticmethod
    def at(shapes: Shapes, x: Array, deviations: Array) -> _States:
        """Sets that are nearly closed, with their drivers where they are."""
        added = shapes.added(deviations)
        with np.errstate(all="ignore"):  # a set that fails shows in its gap
            for _ in range(MOST_NEWTON_STEPS + 1):
                found = shapes.evaluated(x, added)
                closed = found.gap <= ACCEPTED * shapes.tolerance
                if closed.all() or not np.isfinite(found.gap).any():
                    break
                x = x + found.step
        return _States(x + found.step, found, deviations, closed)

    def of(self, sets: NDArray[np.intp]) -> _States:
        """Some of them."""
        found = Evaluated(self.found.gap[sets], *(each[:, sets] for each in self.found[1:]))
        return _States(self.x[:, sets], found, self.deviations[:, sets], self.closed[sets])

    def driven(self, shapes: Shapes, by: Array | float) -> _States:
        """The same with their drivers moved on by ``by``."""
        x = self.x + by * (self.found.first + 0.5 * by * self.found.second)
        return _States.at(shapes, x, self.deviations)


def _followed(shapes: Shapes, deviations: Array, point: TurningPoint, outwards: float) -> tuple[Array, NDArray[np.bool_]]:
    """Outermost positions (n,) of sets from the nominal place of the driver on, and which of them are closed all the way."""
    guide, _, sign = shapes.press.slide_guide
    start, (still, _) = point.ending.start[:, None], shapes.joint_slopes(point.ending.start)
    moved = product(still, deviations)
    begun = _States.at(shapes, start + moved, deviations)
    sound = begun.closed & same_assembly(shapes, begun.x - start, moved)
    farthest = shapes.position(begun.x, deviations)
    turned = np.zeros(len(sound), dtype=bool)
    for way in point.ways:
        sets, here = np.flatnonzero(sound), begun.of(np.flatnonzero(sound))
        for _ in range(point.steps):
            if not len(sets):
                break
            there = here.driven(shapes, way * point.step)
            before, after = (outwards * way * sign * each.found.first[guide] for each in (here, there))
            sound[sets] &= there.closed
            between = np.flatnonzero(there.closed & (before >= 0.0) & (after < 0.0))
            if len(between):
                found = _turned_back(shapes, there.of(between), -way * point.step, outwards)
                np.maximum.at(farthest, sets[between], found) if point.upwards else np.minimum.at(farthest, sets[between], found)
                turned[sets[between]] = True
            on = np.flatnonzero(there.closed & (after >= -SLOW * point.speed))
            sets, here = sets[on], there.of(on)
        sound[sets] = False  # the slide never goes back
    return farthest, sound & (turned | (point.ending.kind == "held"))


def _turned_back(shapes: Shapes, after: _States, back: float, outwards: float) -> Array:
    """Positions (n,) where the slide turns back within a step of the driver, from the states after it."""
    guide, _, sign = shapes.press.slide_guide

    def speed(share: Array) -> tuple[Array, Array]:
        found = after.driven(shapes, back * share).found
        return outwards * sign * back * found.first[guide], outwards * sign * back * back * found.second[guide]

    count = after.x.shape[1]
    share = bracketed_roots(speed, np.zeros(count), np.ones(count), absolute=NARROW)
    return shapes.position(after.driven(shapes, back * share).x, after.deviations)
