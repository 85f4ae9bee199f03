"""Many sets of lengths of a press, each closed and followed to a dead centre or a height.

Newton's method closes all sets together, and moves the crank of each set to where its slide turns back or reaches a height. It starts from
the first-order estimate. Then every set is checked: its loops must be closed, and it must be the nominal assembly, near the first-order
estimate.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.errors import PinpressError
from ...common.products import product
from ...common.quantities import Array
from ...derivatives.motion import Displacements
from ...engines.engine import MOST_NEWTON_STEPS
from ...engines.planar.engine import PlanarEngine
from ...linkage.linkage import Linkage
from .planar_shapes import PlanarShapes
from .shapes import Evaluated, Shapes
from .spatial_shapes import SpatialShapes

PIECE = 2048  # sets of one piece of work: their arrays stay in the cache


def shapes_of(press: Linkage, moved: Sequence[Displacements]) -> Shapes:
    """A press with dimensions that displace its pivots by ``moved`` per unit.

    Raises:
        PinpressError: the press has no slide, or a dimension leads out of the plane of a planar press.
    """
    return PlanarShapes.of(press, moved) if isinstance(press.engine(), PlanarEngine) else SpatialShapes.of(press, moved)


class Ending(NamedTuple):
    """Where the crank of every set ends.

    Attributes:
        start: (nv,) joint coordinates of the nominal press at its end.
        angle_slopes: (k,) derivatives of the crank angle by the dimensions, to first order.
        kind: "dead centre": the slide turns back; "height": the slide reaches a position; "held": the drivers keep their positions.
        target: (n,) positions of the slide, only for "height" [m].
    """

    start: Array
    angle_slopes: Array
    kind: str
    target: Array | None = None

    def part(self, sets: slice) -> Ending:
        """The end of some of the sets."""
        return self if self.target is None else self._replace(target=self.target[sets])


class Ended(NamedTuple):
    """All sets at their ends: slide position (n,) [m], its first and second derivative by the crank angle, and ``sound``: (n,) whether the
    set is closed, has reached its end, and is the nominal assembly.
    """

    position: Array
    rate: Array
    second: Array
    sound: NDArray[np.bool_]


def sound(shapes: Shapes, deviations: Array, ending: Ending, where: str) -> Ended:
    """Every set of deviations (k, n) at its end; ``where``: for messages.

    Raises:
        PinpressError: some of these presses cannot be closed there.
    """
    ended = follow_to_end(shapes, deviations, ending)
    refuse_lost(shapes, deviations, ended.sound, where)
    return ended


def refuse_lost(shapes: Shapes, deviations: Array, sound: NDArray[np.bool_], where: str) -> None:
    """Raise PinpressError if some sets of deviations (k, n) are not ``sound`` (n,)."""
    lost = np.flatnonzero(~sound)
    if len(lost):
        first = ", ".join(f"{value:.3g}" for value in deviations[:, lost[0]])
        raise PinpressError(
            f"{len(lost)} of {deviations.shape[1]} presses, worst corners included, cannot be closed {where} in the assembly of"
            f" {shapes.press.name}; the first of them deviates by {first} [m or rad]: make the tolerances smaller"
        )


def follow_to_end(shapes: Shapes, deviations: Array, ending: Ending) -> Ended:
    """Every set of deviations (k, n) at its end. This function never raises an error, see `sound`."""
    still, first = shapes.joint_slopes(ending.start)
    slopes = still + first * ending.angle_slopes
    pieces = [slice(begin, begin + PIECE) for begin in range(0, deviations.shape[1], PIECE)]
    ended = [_piece(shapes, deviations[:, sets], ending.part(sets), slopes) for sets in pieces]
    return Ended(*map(np.concatenate, zip(*ended, strict=True)))


def _piece(shapes: Shapes, deviations: Array, ending: Ending, slopes: Array) -> Ended:
    """`follow_to_end` of a piece; ``slopes``: (nv, k) of the joint coordinates."""
    guide, _, sign = shapes.press.slide_guide
    moved, added = product(slopes, deviations), shapes.added(deviations)
    x = ending.start[:, None] + moved
    # At a dead centre the square of the last step moves the slide, elsewhere the step itself [rad, or lengths of the linkage].
    largest_step = 1e-5 if ending.kind == "dead centre" else 1e-9
    with np.errstate(all="ignore"):  # a set that fails shows in its gap
        for _ in range(MOST_NEWTON_STEPS + 1):
            solution = shapes.evaluated(x, added)
            turn = _step_to_end(shapes, x, deviations, solution, ending)
            close = solution.gap <= shapes.tolerance
            at_rest = np.abs(turn) <= largest_step
            if (close & at_rest).all() or not np.isfinite(solution.gap).any():
                break
            x = x + solution.step + turn * (solution.first + 0.5 * turn * solution.second)
        x = x + solution.step + turn * (solution.first + 0.5 * turn * solution.second)
        sound = close & at_rest & same_assembly(shapes, x - ending.start[:, None], moved)
    rate, second = solution.first[guide] + turn * solution.second[guide], solution.second[guide]
    return Ended(shapes.position(x, deviations), sign * rate, sign * second, sound)


def same_assembly(shapes: Shapes, way: Array, moved: Array) -> NDArray[np.bool_]:
    """Whether sets (n,) are still the nominal assembly; ``way``: their motion (nv, n), ``moved``: their motion to first order.

    Both may differ by a quarter, as first order holds up to 0.2 rad or lengths of the linkage, and always by 0.001.
    """
    size = 1 + shapes.press.size
    expected = np.minimum(np.abs(moved).max(axis=0), 0.2 * size)
    return np.asarray(np.abs(way - moved).max(axis=0) <= 0.25 * expected + 1e-3 * size)


def _step_to_end(shapes: Shapes, x: Array, deviations: Array, solution: Evaluated, ending: Ending) -> Array:
    """Step (n,) of the crank towards the end of every set."""
    guide, _, sign = shapes.press.slide_guide
    if ending.kind == "dead centre":
        return np.asarray(-solution.first[guide] / solution.second[guide])
    if ending.target is None:
        return np.zeros(x.shape[1])
    return np.asarray((ending.target - shapes.position(x + solution.step, deviations)) / (sign * solution.first[guide]))
