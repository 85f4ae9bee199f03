"""The point of the slide at which process forces act. ``press`` is a `Linkage`, whose module imports this one."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from ..common.quantities import Array

ALIKE = 1e-9  # distance, as a share of the linkage's size, below which two points are one


class ToolPoint(NamedTuple):
    """The point of the slide at which process forces act.

    Attributes:
        point: (3,) in the slide link's own frame [m]. A shift along the guide makes no difference.
        in_body: (3,) the same point in the frame of the joint that carries the slide [m].
        name: what the point is: "the middle of SL and SR", "pin S", "the origin of link slide", or its name in the file.
    """

    point: Array
    in_body: Array
    name: str


def tool_point(press: Any) -> ToolPoint:
    """The point of a linkage with a slide: the ``<tool>`` of its file, else the middle of the pins farthest apart by which links hold the
    slide. Where all of them are in one line along the guide, it is the origin of the slide's link."""
    link = press.model.frames[press.model.getFrameId(press.slide, pin.BODY)].placement
    for tool in press.document.robot.all("link")[press.links.index(str(press.slide))].all("tool"):
        point = np.array(tool.numbers("xyz"))
        return ToolPoint(point, link.act(point), tool.get("name") or "the <tool> of its file")
    pins = {name: link.actInv(point) for name, point in _holding_pins(press).items()}
    along = link.rotation.T @ press.axes[press.slide_guide.joint].direction
    if middle := middle_of_outermost(pins, along, press.size):
        return ToolPoint(middle[0], link.act(middle[0]), middle[1])
    at_origin = (name for name, point in pins.items() if np.linalg.norm(_across(point, along)) <= ALIKE * press.size)
    name = next((f"pin {name}" for name in at_origin), f"the origin of link {press.slide}")
    return ToolPoint(np.zeros(3), np.array(link.translation), name)


def middle_of_outermost(pins: Mapping[str, Array], along: Array, size: float) -> tuple[Array, str] | None:
    """The middle (3,) of the two pins that are farthest apart across a guide, and what it is; None if all are in one line along it.

    Args:
        pins: (3,) each, in one frame [m], by their names.
        along: (3,) unit vector along the guide in that frame.
        size: the linkage's size [m].
    """
    farthest, centre = ALIKE * size, None
    for first, second in itertools.combinations(pins, 2):
        apart = float(np.linalg.norm(_across(pins[first] - pins[second], along)))
        if apart > farthest * (1 + ALIKE):  # of diagonals that differ by rounding the first
            farthest, centre = apart, (0.5 * (pins[first] + pins[second]), f"the middle of {first} and {second}")
    return centre


def _across(vector: Array, along: Array) -> Array:
    return np.asarray(vector - (vector @ along) * along)


def _holding_pins(press: Any) -> dict[str, Array]:
    """Places (3,) in the frame of the slide's body of the bearings by which the drive holds it [m].

    A chain that hangs on the slide and leads to no driver, such as a lever that it moves, carries nothing of a process force.
    """
    slide, parents = press.slide_guide.joint + 1, list(press.model.parents)
    joints = [(name, parents[joint], joint) for joint, name in enumerate(press.joints, 1)]
    loops = [(loop.name, loop.joint1, loop.joint2) for loop in press.loops]
    geared = [("", pair.leader + 1, pair.follower + 1) for pair in press.couplings]
    geared += [("", contact.first, contact.second) for contact in press.contacts]
    driving, grows = {joint + 1 for joint in press.driver_indices}, True
    while grows:  # bodies that are connected with a driver's other than by the frame or the slide
        reached = {body for _, *ends in (*joints, *loops, *geared) if driving & set(ends) - {0, slide} for body in ends}
        grows = bool(reached - driving)
        driving |= reached
    driving -= {0, slide}
    places = {name: press.model.jointPlacements[child].translation for name, parent, child in joints if parent == slide}
    for loop in press.loops:
        if slide in (loop.joint1, loop.joint2):
            places[loop.name] = loop.point1 if loop.joint1 == slide else loop.point2
    others = {name: one if other == slide else other for name, one, other in (*joints, *loops)}
    return {name: np.asarray(place) for name, place in places.items() if others[name] in driving}
