"""What a press looks like as Pinocchio's geometry, for its viewers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from ..common.arguments import typed
from ..common.quantities import Array
from ..engines.branch import predict
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from .shapes.appearance import bodies
from .shapes.solids import Box, Cylinder, Shape, Sphere


@typed
def visual_model(press: Linkage, motion: Motion | None = None) -> pin.GeometryModel:
    """The shapes that `record` shows, as a `pinocchio.GeometryModel` that goes with ``press.model``.

    They are the boxes, cylinders, spheres and meshes of the URDF's ``<visual>``, and plain shapes of links that have none. Objects are
    named as Pinocchio names them, "link_0", "link_1", ... of each link; meshes are in them, without the names of their files. Every call
    makes new ones.

    Args:
        press: the linkage.
        motion: rails of plain shapes are as long as its travels. By default these are of all crank angles that the press can take; of a
            press with several drivers there are none.

    Raises:
        PinpressError: a visual that is not finite or of no size, or whose mesh cannot be read; more visuals or triangles than a page can
            show; a motion of other joints.
        SingularityError: no motion is given, and the linkage locks at its drawn pose.
    """
    found = pin.GeometryModel()
    for body in bodies(press, _positions(press) if motion is None else motion.joint_position):
        frame = press.model.frames[body.frame]
        for k, part in enumerate(body.parts):
            place = frame.placement * pin.SE3(part.placement)
            shape = _coal_shape(part.shape)
            each = pin.GeometryObject(f"{body.name}_{k}", frame.parentJoint, body.frame, place, shape)
            each.meshColor, each.overrideMaterial = np.array(part.rgba), True
            found.addGeometryObject(each)
    return found


def _positions(press: Linkage) -> Array:
    """(n, nv) joint coordinates over all crank angles, near enough for the lengths of rails; of several drivers the drawn pose."""
    if len(press.drivers) > 1:
        return press.closed[None]
    branch = press.branch_through_change_points
    return predict(branch, np.linspace(branch.angles[0], branch.angles[-1], 361)).T


def _coal_shape(shape: Shape) -> Any:
    import coal  # part of Pinocchio, but seldom needed

    if isinstance(shape, Box):
        return coal.Box(*shape.size)
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.length)
    if isinstance(shape, Sphere):
        return coal.Sphere(shape.radius)
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(shape.faces), len(shape.vertices))
    mesh.addVertices(shape.vertices)
    mesh.addTriangles(shape.faces)
    mesh.endModel()
    return mesh
