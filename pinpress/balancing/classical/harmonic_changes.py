"""Which harmonics of the shaking force and of the tilting moment a change of a press cancels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...common.arguments import typed
from ...common.arrays import Array
from ...common.errors import PinpressError, expect
from ...dynamics.harmonics import harmonics
from ...dynamics.inverse_dynamics import Reactions
from ...kinematics.poses import poses

ROUNDING = 1e-12  # of the largest bearing force: harmonics this small are rounding
UNCHANGED = 1e-9  # of an amplitude: a change this small is none
SAME_SPEED = 1e-9  # of a speed: a difference this small is none


@dataclass(frozen=True)
class HarmonicChange:
    """What became of one harmonic.

    Attributes:
        quantity: "force along the slide" (vertical in an upright press), "force across the slide" (lateral) or "tilting moment".
        order: Order of the crank's speed; also fractions where a press repeats itself only after several turns.
        before: Amplitude before [N, or N m].
        after: Amplitude after [N, or N m].
        change: "cancelled" (it is rounding), "reduced", "unchanged", "raised", or "none" where there was and is nothing but rounding.
    """

    quantity: str
    order: float
    before: float
    after: float
    change: str


@typed
def compare_harmonics(before: Reactions, after: Reactions, *, orders: int = 6) -> tuple[HarmonicChange, ...]:
    """Compare the harmonics of the shaking force and of the tilting moment of two presses.

    The moment is about the shaft of the press before. What is below 1e-12 of the largest bearing force, or of its moment at an arm of the
    linkage's size, is rounding.

    Args:
        before: Reactions of a planar press over a period or more.
        after: Reactions of the changed press, at the same speed.
        orders: Highest order.

    Raises:
        PinpressError: A press is not planar or has no slide, or the motions are at different speeds, without a full period, or with too few
            states for the orders.
    """
    for reactions in (before, after):
        expect("reactions", reactions, Reactions, "inverse_dynamics")
    press, (speed, other) = before._press, (np.abs(reactions.motion.crank_speed).max() for reactions in (before, after))
    normal = press.plane_or_refuse(f"{press.name} is not planar: look at the harmonics of its shaking force one axis at a time").normal
    if not abs(other - speed) <= SAME_SPEED * speed:
        raise PinpressError("before and after are at different speeds, with whose squares forces grow: make both motions with one speed")
    guide, _ = press.slide_guide
    at = poses(press, press.closed[None])
    along = at.rotation[guide + 1, 0] @ press.axes[guide].direction
    axes = np.array([along, np.cross(normal, along)])
    shaft = at.position[press.driver_indices[0] + 1, 0]
    (first, least1), (second, least2) = (_amplitudes(each, axes, normal, shaft, orders) for each in (before, after))
    none = np.zeros(3)
    return tuple(
        HarmonicChange(quantity, order, was, now, _change(was, now, max(least1[k], least2[k])))
        for k, quantity in enumerate(("force along the slide", "force across the slide", "tilting moment"))
        for order in sorted({*first, *second})
        for was, now in [(float(first.get(order, none)[k]), float(second.get(order, none)[k]))]
    )


def _amplitudes(
    reactions: Reactions, axes: Array, normal: Array, shaft: Array, orders: int
) -> tuple[dict[float, Array], tuple[float, float, float]]:
    """By order, amplitudes (3,) of the forces along and across and of the moment about the shaft, and what is rounding of each."""
    force = reactions.shaking_force
    moment = (reactions.shaking_moment - np.cross(shaft, force)) @ normal
    found = harmonics(reactions.motion, np.column_stack([force @ axes.T, moment]), orders)
    turns = reactions.motion.period_turns or 1
    if found is None or len(found.orders) <= orders * turns:
        raise PinpressError(
            f"the motion of {reactions.motion.linkage} has no full period of {2 * orders * turns + 1} states: use cycle(..., points=...)"
        )
    least = ROUNDING * max(float(np.abs(each).max()) for each in (force, *reactions.bearing_force.values()))
    by_order = {int(o) if o.is_integer() else float(o): at for o, at in zip(found.orders[1:], found.amplitude[1:], strict=True)}
    return by_order, (least, least, least * reactions._press.size)


def _change(before: float, after: float, least: float) -> str:
    if after <= least:
        return "none" if before <= least else "cancelled"
    if abs(after - before) <= max(least, UNCHANGED * before):
        return "unchanged"
    return "reduced" if after < before else "raised"
