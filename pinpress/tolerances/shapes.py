"""A press with many sets of lengths at once: each closed with its own, and followed to the dead centre or height that is asked of it.

The rows of a `Plane` follow the pivots in proportion, C(x) = C + sum x_k C'_k. With rows of their own for every set of deviations x_k,
Newton's method closes all of them together, and moves the crank of each to where its slide turns back, or stands at a height. It starts
from the nominal state, carried on to first order, and every set is checked: that its loops are closed, and that it is the nominal
assembly still, near where first order has it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.quantities import Array, ComplexArray
from ..derivatives.motion import States, directed, guide_shift, planar, shift
from ..engines.engine import ACCEPTED, MOST_NEWTON_STEPS
from ..engines.joints import product
from ..engines.planar.kinematics import NO_SLIPS, basis_acceleration, basis_at, drive, factored, solve
from ..engines.planar.model import Plane
from ..linkage.linkage import Linkage
from .dimensions import Dimension

PIECE = 2048  # sets that are worked through at a time: their arrays stay in the cache
TURNED = 1e-9  # last step of the crank [rad, or lengths of the linkage]
TURNED_BACK = 1e-5  # last step at a dead centre, where what is left after it, its square, moves the slide by no more than rounding
CORRECTED = 0.25  # share of what first order moves it by, by which Newton's method may correct a joint
NEARLY = 1e-3  # correction that is accepted in any case [rad, or lengths of the linkage]


class Shapes(NamedTuple):
    """A planar press whose pivots can be moved by k dimensions.

    Attributes:
        press: the press.
        plane: constants of the nominal linkage.
        by: what each dimension adds to the rows, per unit of it.
        places: (m, 2) the entries of `Plane.closure` that change.
        slopes: (m, k) their derivatives by the dimensions.
        guide_slopes: (k,) by how much each dimension moves the slide's guide along itself, which no joint coordinate shows.
    """

    press: Linkage
    plane: Plane
    by: tuple[ComplexArray, ...]
    places: NDArray[np.intp]
    slopes: ComplexArray
    guide_slopes: Array

    @staticmethod
    def of(press: Linkage, parts: Sequence[Dimension]) -> Shapes:
        """The press with its dimensions.

        Raises:
            PinpressError: the press is not planar, or has no slide; a dimension leads out of its plane.
        """
        plane, guide = planar(press), press.slide_guide.joint
        shifts = [shift(press, plane, directed(press, part.direction)) for part in parts]
        changes = np.array([each.closure for each in shifts])
        places = np.argwhere(changes.any(axis=0))
        slopes = changes[:, places[:, 0], places[:, 1]].T
        return Shapes(press, plane, tuple(changes), places, slopes, np.array([guide_shift(plane, each, guide) for each in shifts]))

    def position(self, joint_position: Array, deviations: Array) -> Array:
        """Slide position (n,) at joint coordinates (nv, n) of sets with deviations (k, n) [m]."""
        guide, offset, sign = self.press.slide_guide
        return np.asarray(sign * (joint_position[guide] + self.guide_slopes @ deviations) + offset)


class Ending(NamedTuple):
    """Where the crank of every set ends: one of these three.

    Attributes:
        start: (nv,) joint coordinates of the nominal press there.
        angle_slopes: (k,) derivatives of the crank angle by the dimensions, to first order.
        kind: "dead centre": the slide turns back; "height": it stands at a position; "held": the driver stands where it is, at an
            end of its travel.
        target: (n,) position of the slide [m]; of a "height" alone.
    """

    start: Array
    angle_slopes: Array
    kind: str
    target: Array | None = None

    def part(self, sets: slice) -> Ending:
        """The same of some of the sets."""
        return self if self.target is None else self._replace(target=self.target[sets])


class Ended(NamedTuple):
    """All sets where they end.

    Attributes:
        angle: (n,) crank angle [rad]; of a driver that slides its position [m].
        position: (n,) slide position [m].
        rate: (n,) derivative of the slide position by the crank angle [m/rad].
        sound: (n,) whether the set is closed, has come to its end, and is the nominal assembly.
    """

    angle: Array
    position: Array
    rate: Array
    sound: NDArray[np.bool_]


def followed_to(shapes: Shapes, deviations: Array, ending: Ending) -> Ended:
    """Every set of deviations (k, n) at its end. It never raises: the caller judges which sets are sound."""
    slopes = _first_order(shapes, ending)
    count = deviations.shape[1]
    whole = Ended(np.empty(count), np.empty(count), np.empty(count), np.empty(count, dtype=bool))
    for begin in range(0, count, PIECE):
        sets = slice(begin, begin + PIECE)
        for all_sets, part in zip(whole, _piece(shapes, deviations[:, sets], ending.part(sets), slopes), strict=True):
            all_sets[sets] = part
    return whole


def _first_order(shapes: Shapes, ending: Ending) -> Array:
    """Derivatives (nv, k) of the joint coordinates by the dimensions, along with the crank."""
    states = States.of(shapes.plane, ending.start[:, None])
    first = np.empty_like(states.basis[:, 0].real, shape=(len(ending.start), 1))
    drive(shapes.plane, states.rows, states.factors, first)
    loops = len(shapes.plane.loop_points)
    still = [states.solve(product(each[:loops], states.basis))[:, 0] for each in shapes.by]
    return np.stack(still, axis=1) + first * ending.angle_slopes


def _piece(shapes: Shapes, deviations: Array, ending: Ending, slopes: Array) -> Ended:
    """`followed_to` of a piece; ``slopes``: from `_first_order`."""
    plane, press = shapes.plane, shapes.press
    guide, _, sign = press.slide_guide
    added = shapes.slopes @ deviations
    moved = slopes @ deviations
    x = ending.start[:, None] + moved
    with np.errstate(all="ignore"):  # a set that fails shows in its gap
        for _ in range(MOST_NEWTON_STEPS + 1):
            found = _evaluated(shapes, x, added)
            turn = _turned(shapes, x, deviations, found, ending)
            close = found.gap <= ACCEPTED * plane.tolerance
            at_rest = np.abs(turn) <= (TURNED_BACK if ending.kind == "dead centre" else TURNED)
            if (close & at_rest).all() or not np.isfinite(found.gap).any():
                break
            x = x + found.step + turn * (found.first + 0.5 * turn * found.second)
        x = x + found.step + turn * (found.first + 0.5 * turn * found.second)
        corrected = np.abs(x - ending.start[:, None] - moved).max(axis=0)
        near = corrected <= CORRECTED * np.abs(moved).max(axis=0) + NEARLY * (1 + plane.size)
    return Ended(
        x[plane.driver], shapes.position(x, deviations), sign * (found.first[guide] + turn * found.second[guide]), close & at_rest & near
    )


class _Evaluated(NamedTuple):
    """What Newton's method needs of joint coordinates (nv, n).

    Attributes:
        gap: (n,) largest gap of a loop or coupling [m].
        step: (nv, n) that closes them.
        first: (nv, n) derivative of the joint coordinates by the crank angle.
        second: (nv, n) second derivative.
    """

    gap: Array
    step: Array
    first: Array
    second: Array


def _evaluated(shapes: Shapes, x: Array, added: ComplexArray) -> _Evaluated:
    """The loop equations of sets at joint coordinates (nv, n); ``added``: (m, n) to the entries of the closure."""
    plane = shapes.plane
    loops = len(plane.loop_points)
    basis = basis_at(plane, x)
    rows = _rows(shapes, basis, added, len(plane.closure))
    slips = plane.coupled @ x - plane.offsets[:, None] if len(plane.offsets) else NO_SLIPS
    gap = np.abs(rows[:loops]).max(axis=0, initial=0.0)
    if len(slips):
        gap = np.maximum(gap, np.abs(slips).max(axis=0))
    factors = factored(plane, rows)
    step, second = np.zeros_like(x), np.zeros_like(x)
    first = np.empty_like(x)
    solve(plane, rows, factors, [*rows[:loops], *slips], step)
    drive(plane, rows, factors, first)
    turning = _rows(shapes, basis_acceleration(plane, basis, first, None), added, loops)
    solve(plane, rows, factors, [*turning, *[None] * len(plane.offsets)], second)
    return _Evaluated(gap, step, first, second)


def _rows(shapes: Shapes, basis: ComplexArray, added: ComplexArray, count: int) -> ComplexArray:
    """The first ``count`` rows of every set's closure at a basis (nb, n)."""
    rows = np.array(product(shapes.plane.closure[:count], basis))
    for (row, column), values in zip(shapes.places, added, strict=True):
        if row < count:
            rows[row] += values * basis[column]
    return rows


def _turned(shapes: Shapes, x: Array, deviations: Array, found: _Evaluated, ending: Ending) -> Array:
    """Step (n,) of the crank towards the end of every set."""
    guide, _, sign = shapes.press.slide_guide
    if ending.kind == "dead centre":
        return np.asarray(-found.first[guide] / found.second[guide])
    if ending.target is None:
        return np.zeros(x.shape[1])
    ahead = ending.target - shapes.position(x + found.step, deviations)
    return np.asarray(ahead / (sign * found.first[guide]))
