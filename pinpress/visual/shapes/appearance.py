"""The appearance of a press: the `<visual>` shapes of its links, and plain shapes for links without visuals."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from ...common.arguments import typed
from ...common.errors import PinpressError
from ...common.quantities import Array
from ...engines.branch import predict
from ...kinematics.motion import Motion, refuse_motion_of_another
from ...linkage.element import Element
from ...linkage.linkage import Linkage
from ...linkage.writing import is_ballast
from .solids import Box, Cylinder, Part, Plate, Shape, Sphere, TriangleMesh, part, read_mesh
from .stand_ins import ShaftFlywheel, made_up_parts

MOST_SHAPES, MOST_TRIANGLES = 5000, 1_000_000  # limits for all links together; a browser can barely open a page with more
STAND_IN = "stand_in"  # visuals that pinpress wrote for other programs; made up again here, because lengths may have changed


@dataclass(frozen=True, eq=False)
class ShownLink:
    """A link that is shown.

    Attributes:
        name: name of the link.
        frame: index of the link in the frames of the model.
        parts: one or more solids in the link's frame.
        drawn: whether the parts are the URDF's visuals; otherwise they are made up from the link's bearings.
    """

    name: str
    frame: int
    parts: tuple[Part, ...]
    drawn: bool


def bodies(
    press: Linkage, joint_position: Array, *, made_up: Collection[str] = (), flywheels: Sequence[ShaftFlywheel] = ()
) -> tuple[ShownLink, ...]:
    """The links of a press as solids, in document order, followed by flywheels.

    A link without `<visual>` is shown as a bar, plate, web or disc between its bearings. A slide is a block of its mass, and the frame of a
    press has columns, beams, gibs and a bed. Counterweights are steel solids of their mass; those of `balance` are also shown on links with
    visuals. Links that are fixed to other links and have no bearing are left out.

    Args:
        press: the linkage.
        joint_position: (n, nv) joint positions of a motion; their ranges are the lengths of gibs [rad or m].
        made_up: names of links that are made up from their bearings although they have a `<visual>`, because it no longer fits.
        flywheels: flywheels on the shafts of drivers.

    Raises:
        PinpressError: joint positions have a wrong shape or are not finite; a visual is not finite or has no size, or its mesh cannot be
            read; or there are more visuals or triangles than a page can show.
    """
    travel = _travel(press, joint_position)
    robot = press.document.robot
    colours = _materials(robot)
    drawn = {name: parts for name, parts in _drawn(press.file, robot, colours).items() if name not in made_up}
    model = press.model
    made, wheels = made_up_parts(press, travel, drawn, flywheels)
    shown = [
        ShownLink(name, model.getFrameId(name, pin.BODY), (*drawn.get(name, ()), *made.get(name, ())), name in drawn)
        for name in press.links
        if name in drawn or made.get(name)
    ]
    for flywheel, wheel in zip(flywheels, wheels, strict=True):
        frame = next(f for f in model.frames if f.type == pin.BODY and f.parentJoint == model.getJointId(flywheel.driver))
        name = "flywheel" if "flywheel" not in press.links and len(flywheels) == 1 else f"flywheel of {flywheel.driver}"
        shown.append(ShownLink(name, model.getFrameId(frame.name, pin.BODY), wheel, False))
    return tuple(shown)


@typed
def visual_model(press: Linkage, motion: Motion | None = None) -> pin.GeometryModel:
    """The shapes that `record` shows, as a `pinocchio.GeometryModel` for ``press.model``.

    They are the boxes, cylinders, spheres and meshes of the URDF's ``<visual>``, and plain shapes for links without visuals. Objects have
    Pinocchio's names, "link_0", "link_1", ... for each link. They contain their meshes, but not the names of the mesh files. Every call
    makes new objects.

    Args:
        press: the linkage.
        motion: motion whose ranges of joint positions are the lengths of plain rails. By default the ranges over all possible crank angles;
            zero for a press with several drivers.

    Raises:
        PinpressError: a visual is not finite or has no size, or its mesh cannot be read; there are more visuals or triangles than a page
            can show; or the motion is of a linkage with other joints or lengths.
        SingularityError: no motion is given, and the linkage locks at its drawn pose.
    """
    if motion is not None:
        refuse_motion_of_another(press, motion)
    shapes, model = pin.GeometryModel(), press.model
    if motion is not None:
        position = motion.joint_position
    elif len(press.drivers) > 1:
        position = press.closed[None]
    else:  # over all crank angles, accurate enough for rails
        branch = press.branch_through_change_points
        position = predict(branch, np.linspace(branch.angles[0], branch.angles[-1], 361)).T
    for body in bodies(press, position):
        frame = model.frames[body.frame]
        for k, solid in enumerate(body.parts):
            place = frame.placement * pin.SE3(solid.placement)
            shape = _coal_shape(solid.shape)
            each = pin.GeometryObject(f"{body.name}_{k}", frame.parentJoint, body.frame, place, shape)
            each.meshColor, each.overrideMaterial = np.array(solid.rgba), True
            shapes.addGeometryObject(each)
    return shapes


def _drawn(file: str, robot: Element, colours: Mapping[str, Array]) -> dict[str, tuple[Part, ...]]:
    """Name of a link -> its visuals, for links with visuals. They are counted while they are read, so that memory suffices."""
    drawn, shapes, triangles = {}, 0, 0
    for link in robot.all("link"):
        parts = []
        for each in _visuals(file, link, colours):
            parts.append(each)
            shapes += 1
            triangles += len(each.shape.faces) if isinstance(each.shape, TriangleMesh) else 0
            for count, most, what in ((shapes, MOST_SHAPES, "visuals"), (triangles, MOST_TRIANGLES, "triangles")):
                if count > most:
                    name = link.get("name")
                    raise PinpressError(
                        f"link {name!r}: with it there are more than {most} {what} to be drawn; leave some out, or give coarser meshes"
                    )
        if parts:
            drawn[link.get("name")] = tuple(parts)
    return drawn


def _travel(press: Linkage, joint_position: Array) -> Array:
    """(2, nv) lowest and highest positions of the joints [rad or m]."""
    position = np.asarray(joint_position, dtype=float)
    count = len(press.joints)
    if position.ndim != 2 or position.shape[1] != count or len(position) == 0:
        raise PinpressError(f"joint_position has shape {position.shape}: give (n, {count}), those of a motion of {press.name}")
    if not np.isfinite(position).all():
        raise PinpressError(f"joint_position is not finite in state {int(np.argmin(np.isfinite(position).all(axis=1)))}")
    return np.array([position.min(axis=0), position.max(axis=0)])


def _materials(robot: Element) -> dict[str, Array]:
    """Colours by the names of materials: global ones first, then those within visuals, as in Pinocchio."""
    inside = (visual.all("material") for link in robot.all("link") for visual in link.all("visual"))
    colours: dict[str, Array] = {}
    for material in itertools.chain(robot.all("material"), *inside):
        colour = _colour(material)
        if material.get("name") and colour is not None:
            colours.setdefault(material.get("name"), colour)
    return colours


def _colour(material: Element) -> Array | None:
    for colour in material.all("color"):
        if rgba := colour.numbers("rgba"):
            return np.clip(rgba, 0.0, 1.0)
    return None


def _visuals(file: str, link: Element, colours: Mapping[str, Array]) -> Iterator[Part]:
    for visual in link.all("visual"):
        if visual.get("name") == STAND_IN or is_ballast(visual):
            continue
        rgba = next((colours.get(m.get("name"), _colour(m)) for m in visual.all("material")), None)
        xyz, rpy = np.zeros(3), np.zeros(3)
        for origin in visual.all("origin"):
            xyz, rpy = (np.array(_numbers(link.get("name"), origin, name, "0 0 0")) for name in ("xyz", "rpy"))
        placement = pin.SE3(pin.rpy.rpyToMatrix(rpy), xyz).homogeneous
        for geometry in visual.all("geometry"):
            for element in geometry.children:
                yield part(_shape(file, link.get("name"), element), placement, (0.62, 0.65, 0.69, 1.0) if rgba is None else rgba)


def _shape(file: str, link: str, element: Element) -> Shape:

    def sizes(name: str) -> tuple[float, ...]:
        numbers = _numbers(link, element, name)
        if min(numbers) <= 0:
            raise PinpressError(f"link {link!r}: <{element.tag}> has {name}={element.get(name)!r}; give sizes greater than 0, in metres")
        return numbers

    if element.tag == "box":
        x, y, z = sizes("size")
        return Box((x, y, z))
    if element.tag == "cylinder":
        return Cylinder(*sizes("radius"), *sizes("length"))
    if element.tag == "sphere":
        return Sphere(*sizes("radius"))
    if element.tag == "mesh":
        return read_mesh(file, link, element.get("filename"), _numbers(link, element, "scale", "1 1 1"))
    raise PinpressError(f"link {link!r}: <{element.tag}> cannot be drawn; use <mesh>, <box>, <cylinder> and <sphere>")


def _numbers(link: str, element: Element, name: str, default: str | None = None) -> tuple[float, ...]:
    if default is not None and name not in element.attributes:
        return tuple(map(float, default.split()))
    numbers = element.numbers(name)
    if not numbers:
        raise PinpressError(f"link {link!r}: <{element.tag}> has {name}={element.get(name)!r}; give finite numbers")
    return numbers


def _coal_shape(shape: Shape) -> Any:
    import coal  # part of Pinocchio, but seldom needed

    if isinstance(shape, Box):
        return coal.Box(*shape.size)
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.length)
    if isinstance(shape, Sphere):
        return coal.Sphere(shape.radius)
    if isinstance(shape, Plate):
        shape = shape.mesh()
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(shape.faces), len(shape.vertices))
    mesh.addVertices(shape.vertices)
    mesh.addTriangles(shape.faces)
    mesh.endModel()
    return mesh
