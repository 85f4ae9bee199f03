"""What yields in a press, checked: stiffnesses and dampers by the numbers of its bearings, and the ends of its rods.

Deflections under static forces (`elasticity`) and motions on springs refuse the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from ...common import plausibility
from ...common.arguments import number, positive
from ...common.errors import PinpressError, UnknownNameError, shown
from ...common.quantities import GRAVITY, Array
from ...kinematics.poses import loaded_bodies
from ...linkage.linkage import Linkage
from .description import Rod, Stiffness
from .preloaded_joint import STIFFEST, PreloadedJoint, closed_stiffness

FRAME, SHAFT = "frame", "shaft"  # names of these parts
LIGHTEST = 1e-9  # share of the heaviest link's mass below which a link counts as one without mass


def part_stiffness(part: str, given: object, unit: str = "N/m") -> float:
    """Stiffness of a part, that of a closed joint where it has one; raises PinpressError where it is no positive number, or too large."""
    return positive(f"stiffness of {part}", closed_stiffness(given), unit, STIFFEST)


def bearing_number(press: Linkage, name: object) -> int:
    """Number of a bearing; raises UnknownNameError where the linkage has no such bearing."""
    if not isinstance(name, str) or name not in press.bearings:
        raise UnknownNameError("bearing", name, press.bearings)
    return press.bearings.index(name)


def link_joint(press: Linkage, link: object) -> int:
    """Pinocchio's joint of a link that moves; raises UnknownNameError where the linkage has no such link."""
    if not isinstance(link, str) or link not in press.links or link == press.root:
        raise UnknownNameError("moving link", link, [name for name in press.links if name != press.root])
    return int(press.model.frames[press.model.getFrameId(link, pin.BODY)].parentJoint)


def named(what: str, given: object) -> Mapping[str, Any]:
    """Stiffnesses by the names of bearings; raises PinpressError where they are no mapping."""
    if not isinstance(given, Mapping):
        raise PinpressError(f"{what} is {shown(given)}: give a mapping, name of a bearing: stiffness")
    return given


def rods_of(stiffness: Stiffness) -> Sequence[Rod]:
    """The rods; raises PinpressError where there is something else among them."""
    rods = stiffness.rods
    if not isinstance(rods, Sequence) or not all(isinstance(rod, Rod) for rod in rods):
        raise PinpressError(f"rods is {shown(rods)}: give a list of Rod(link, (bearing, bearing), stiffness)")
    return rods


class RodEnds(NamedTuple):
    """What a rod's link has to do with the bearings.

    Attributes:
        joint: Pinocchio's joint of the link.
        ends: numbers of the two bearings that the rod lies between.
        signs: for each bearing of the link, by its number, 1 where its force acts on the link, -1 where on its other side.
    """

    joint: int
    ends: tuple[int, int]
    signs: dict[int, float]


def rod_ends(press: Linkage, rod: Rod) -> RodEnds:
    """The ends of a rod.

    Raises:
        UnknownNameError: the linkage has no such link or bearing.
        PinpressError: the names are not those of two bearings of the link.
    """
    if not isinstance(rod.between, tuple | list) or len(rod.between) != 2 or rod.between[0] == rod.between[1]:
        raise PinpressError(f"rod of {shown(rod.link)}: between is {shown(rod.between)}; give the names of two of its bearings")
    ends = bearing_number(press, rod.between[0]), bearing_number(press, rod.between[1])
    joint, signs = bearings_of_link(press, rod.link)
    for end in ends:
        if end not in signs:
            names = ", ".join(press.bearings[k] for k in signs)
            raise PinpressError(f"rod of {shown(rod.link)}: bearing {shown(press.bearings[end])} is not on that link; there are: {names}")
    return RodEnds(joint, ends, signs)


def bearings_of_link(press: Linkage, link: str) -> tuple[int, dict[int, float]]:
    """Joint of a link, and `RodEnds.signs` of its bearings; raises UnknownNameError where the linkage has no such link."""
    joint = link_joint(press, link)
    acting = (*map(int, list(press.model.parents)[1:]), *(loop.joint1 for loop in press.loops))
    both = enumerate(zip(loaded_bodies(press), acting, strict=True))
    return joint, {k: 1.0 if joint == loaded else -1.0 for k, (loaded, other) in both if joint in (loaded, other)}


def refuse_meeting(press: Linkage, rod: str, length: float | Array) -> None:
    """Raise PinpressError where a rod between two bearings has no length, at some state or at all [m]."""
    if not np.min(length) > 1e-9 * press.size:  # less is rounding
        raise PinpressError(f"rod {shown(rod)}: its bearings meet, so that it has no direction; name two that stay apart")


def by_bearing(
    press: Linkage, what: str, given: object, unit: str, needed: Sequence[int], *, holds_none: str, yields: str
) -> dict[int, float]:
    """Stiffnesses of a press by the numbers of its bearings.

    Args:
        press: the press.
        what: the field of `Stiffness`, for messages.
        given: name of a bearing -> stiffness, of any type.
        unit: of the stiffnesses.
        needed: numbers of the bearings that need one, and may have one.
        holds_none: what a bearing is that may not, for messages.
        yields: in which motion what yields, for messages.

    Raises:
        UnknownNameError: a name is not that of a bearing.
        PinpressError: a bearing lacks its stiffness or has one that it cannot have, or a number is not positive.
    """
    values = {}
    for name, value in named(what, given).items():
        place = bearing_number(press, name)
        if place not in needed:
            raise PinpressError(f"{what} names {shown(name)}, which is {holds_none}: leave it out")
        refuse_joint_but_of_guide(press, place, value, unit)
        values[place] = part_stiffness(shown(name), value, unit)
    missing = [press.bearings[place] for place in needed if place not in values]
    if missing:
        raise PinpressError(
            f"Stiffness.{what} lacks {', '.join(map(shown, missing))} of {press.name}{yields}; give each a stiffness [{unit}]"
        )
    return values


def refuse_joint_but_of_guide(press: Linkage, place: int, value: object, unit: str = "N/m") -> None:
    """Raise PinpressError where a part other than a guide across its axis has a preloaded joint, or its two gibs are unlike.

    Args:
        press: the press.
        place: number of the bearing.
        value: the stiffness given.
        unit: of the stiffness.
    """
    if not isinstance(value, PreloadedJoint):
        return
    name = shown(press.bearings[place])
    if unit != "N/m" or place >= len(press.joints) or press.axes[place].turns:
        raise PinpressError(f"stiffness of {name} is a PreloadedJoint, which a guide has across its axis alone: give a number [{unit}]")
    if value.loaded != value.relieved:
        raise PinpressError(f"stiffness of {name}: both gibs of a guide are alike; give loaded and relieved the same stiffness")


def dampers_by_bearing(press: Linkage, dampers: Mapping[str, float]) -> dict[int, float]:
    """Dampers by the numbers of their bearings [N s/m]; raises PinpressError where a name or a number is not suitable."""
    dampings = {}
    for name, value in dampers.items():
        place = bearing_number(press, name)
        dampings[place] = number(f"damper of {shown(name)}", value, "N s/m")
        if dampings[place] < 0:
            raise PinpressError(f"damper of {shown(name)} is {dampings[place]:g}: give a number that is not negative [N s/m]")
    return dampings


def doubt_stiffness(press: Linkage, stiffness: Stiffness) -> None:
    """Warn of springs of a press that are so soft, all of a kind, that they may be in N/mm."""
    weight = GRAVITY * float(press.model.inertias[press.slide_guide.joint + 1].mass)
    bearings = [float(closed_stiffness(value)) for value in stiffness.bearings.values()]  # type: ignore[arg-type]
    if bearings:
        plausibility.springs("Stiffness: the largest of bearings", max(bearings), weight, press.size)
    for rod in stiffness.rods:
        plausibility.springs(f"Stiffness: that of rod {shown(rod.link)}", float(closed_stiffness(rod.stiffness)), weight, press.size)  # type: ignore[arg-type]
    if stiffness.frame is not None:
        plausibility.springs("Stiffness: frame", float(closed_stiffness(stiffness.frame)), weight, press.size)  # type: ignore[arg-type]
    for name, value in (("the largest of moments", max(stiffness.moments.values(), default=None)), ("shaft", stiffness.shaft)):
        if value is not None:
            plausibility.turning_springs(f"Stiffness: {name}", float(value), weight * press.size)
