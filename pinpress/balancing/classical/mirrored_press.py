"""The mirrored arrangement: two halves of a press on two shafts that turn against each other. Zhang 2007, 3.6."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...common.arguments import typed
from ...common.arrays import Array
from ...common.checks import positive
from ...common.errors import PinpressError
from ...linkage.linkage import Linkage
from ..counterweights import rigid_body
from .crank_slider import CENTRED
from .press_plan import PlanBody, PlanPin, PressPlan, plan_of, press_of

SIDES = ("left", "right")


@typed
def mirrored(press: Linkage, shaft_distance: float) -> Linkage:
    """Make two halves of a press, one the mirror image of the other, on two shafts that a gear pair lets turn against each other.

    Zhang 2007, 3.6. The slide (and the counterweight) is common to both halves. The press, a centred crank-slider or what
    `with_opposed_balancer` makes of it, is shifted by half the distance of the shafts against the direction to which the crank turns from
    bottom dead centre, as the left half, and mirrored about the line on which its shaft was, as the right half. Whatever does not slide on
    the frame is then there twice, with "_left" and "_right" behind its name and half of its mass; the left shaft is driven, the right one
    mimics it by -1. Forces across the slide's line and moments about the middle vanish at any speed, also under a central load on the
    slide; forces along the line stay as they are. A slide whose centre of mass is beside the line of its pin keeps its own moment.

    Args:
        press: The press.
        shaft_distance: Distance of the shafts [m]. Whether the halves collide is not checked.

    Returns:
        A press that is in memory alone, with the crank angle, gravity, names, masses and strokes of ``press``, without visuals.

    Raises:
        PinpressError: The press is not planar with one driver on the frame, has gear pairs, no slide, guides in several directions, or a
            slide whose pin does not move on a line through the shaft; or the distance is not positive.
    """
    distance, drawn = positive("shaft_distance", shaft_distance, "m"), plan_of(press)
    guided = [each.link for each in drawn.bodies if each.limits and each.parent == drawn.frame]
    shaft = _shaft(press, drawn)
    across = _across(press, drawn, guided, shaft)
    return press_of(
        replace(_doubled(drawn, guided, shaft, across, distance), name=f"{press.name}_symmetric"),
        "Two mirrored halves on two shafts that a gear pair lets turn against each other (Zhang 2007, 3.6). SI units.",
    )


def _shaft(press: Linkage, drawn: PressPlan) -> Array:
    """A point (3,) on the shaft of the crank, in world axes [m]."""
    crank = next(each for each in drawn.bodies if each.joint == drawn.driver)
    if crank.parent != drawn.frame or drawn.slide is None:
        raise PinpressError(
            f"{press.name} has no crank on the frame, or no slide: give a crank-slider or what with_opposed_balancer() makes of it"
        )
    return np.asarray(crank.place.translation)


def _across(press: Linkage, drawn: PressPlan, guided: Sequence[str], shaft: Array) -> Array:
    """The unit vector (3,) across the slide's line, to which the crank turns from bottom dead centre.

    Raises:
        PinpressError: The links that are guided on the frame do not all move on the slide's line through the shaft.
    """
    assert drawn.slide is not None
    slide = drawn.body(drawn.slide)
    ends = [(k.name, link, k.point) for k in drawn.pins for link in (k.link1, k.link2) if link in guided]
    ends += [(each.joint, each.parent, each.place.translation) for each in drawn.bodies if each.parent in guided]
    along = slide.place.rotation @ slide.axis
    to_slide = next((point - shaft for _, link, point in ends if link == slide.link), along)
    across = np.cross(drawn.normal, along) * (1.0 if to_slide @ along > 0 else -1.0)
    for each in map(drawn.body, guided):
        if abs(each.place.rotation @ each.axis @ across) > CENTRED:
            raise PinpressError(
                f"{press.name}: joint {each.joint!r} guides in another direction than the slide's; only one can be mirrored"
            )
    for name, _, point in ends:
        if abs((point - shaft) @ across) > CENTRED * press.size:
            raise PinpressError(
                f"{press.name}: bearing {name!r} moves {abs((point - shaft) @ across):.6g} m beside the shaft; give a centred crank-slider"
            )
    return np.asarray(across)


def _doubled(drawn: PressPlan, shared: Sequence[str], shaft: Array, across: Array, distance: float) -> PressPlan:
    """The plan with all bodies but the shared ones halved in mass, shifted by half a distance [m] against ``across``, and mirrored about
    the plane through the shaft that this direction (3,) is normal to. The right driver mimics the left one by -1."""
    shift = -0.5 * distance * across

    def named(name: str, side: str) -> str:
        return name if name in (drawn.frame, *shared) else f"{name}_{side}"

    def moved(point: Array, side: str) -> Array:
        point = point + shift
        return point if side == "left" else point - 2 * ((point - shaft) @ across) * across

    def half(each: PlanBody, side: str) -> PlanBody:
        # A mirrored frame keeps its axes, and what is fixed to it changes sides in it.
        to = each.place.rotation.T @ across
        mirror = np.eye(3) if side == "left" else np.eye(3) - 2 * np.outer(to, to)
        whole = each.inertia
        return PlanBody(
            named(each.link, side),
            pin.SE3(each.place.rotation, moved(each.place.translation, side)),
            rigid_body(0.5 * whole.mass, mirror @ whole.lever, 0.5 * mirror @ whole.inertia @ mirror),
            f"{each.joint}_{side}",
            named(each.parent, side),
            mirror @ each.axis,
            each.limits,
            f"{drawn.driver}_left" if each.joint == drawn.driver and side == "right" else None,
        )

    kept = [each for each in drawn.bodies if each.link in shared]
    halves = [half(each, side) for side in SIDES for each in drawn.bodies if each.link not in shared]
    pins = [(each, side) for side in SIDES for each in drawn.pins]
    return replace(
        drawn,
        bodies=(*halves, *kept),
        pins=tuple(PlanPin(f"{k.name}_{s}", k.type, named(k.link1, s), named(k.link2, s), moved(k.point, s)) for k, s in pins),
        driver=f"{drawn.driver}_left",
    )
