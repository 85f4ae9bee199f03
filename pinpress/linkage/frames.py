"""The frames of a linkage's links: their places, and their Jacobians by the drivers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..common.arguments import numbers
from ..common.errors import PinpressError, SingularityError, UnknownNameError
from ..common.quantities import Array
from ..engines.engine import LOOSEST
from ..engines.spatial.bodies import placements
from ..engines.spatial.engine import SpatialEngine
from ..engines.spatial.equations import Loops
from ..engines.spatial.frames import Frame, moving_frame

if TYPE_CHECKING:
    from .linkage import Linkage


def loops_of(press: Linkage) -> Loops:
    """The constants of the equations in space."""
    engine = press.engine("space")
    assert isinstance(engine, SpatialEngine)
    return engine.loops


def frame_named(press: Linkage, name: object) -> Frame:
    """The frame of a link.

    Raises:
        UnknownNameError: the linkage has no link of this name.
    """
    if not isinstance(name, str) or name not in press.links:
        raise UnknownNameError("link", name, press.links)
    frame = press.model.frames[press.model.getFrameId(name, pin.BODY)]
    return Frame(int(frame.parentJoint), frame.placement.rotation.copy(), frame.placement.translation.copy())


def closed_coordinates(press: Linkage, joints: object) -> Array:
    """Given joint coordinates (n, nv), see `Motion.joint_position`, as (nv, n).

    Raises:
        PinpressError: another shape, a number that is not finite, or coordinates that leave a loop open.
    """
    x = numbers("joints", joints, (None, len(press.joints))).T
    gaps = press.engine("space").gaps(x)
    if not gaps.max(initial=0.0) <= max(LOOSEST * press.size, press.structure.tolerance):
        state = int(gaps.argmax())
        raise PinpressError(
            f"joints leave a loop of {press.name} open by {gaps[state]:.3g} m in state {state}: give the joint_position of a motion of this"
            " linkage, or the positions of its drivers, drivers=..."
        )
    return x


def placed_frame(press: Linkage, frame: Frame, x: Array) -> Array:
    """Homogeneous matrices (n, 4, 4) from the frame to the world, at joint coordinates (nv, n)."""
    at = placements(loops_of(press).bodies, x)
    result = np.zeros((x.shape[1], 4, 4))
    result[:, :3, :3] = frame.rotations(at).transpose(2, 0, 1)
    result[:, :3, 3] = at.point(frame.joint, frame.point).T
    result[:, 3, 3] = 1.0
    return result


def frame_jacobian(press: Linkage, frame: Frame, x: Array) -> Array:
    """(n, 6, drivers) velocity of the frame's origin and angular velocity, world axes, at a unit rate of every driver.

    Raises:
        SingularityError: the drivers do not determine how the joints move at one of the joint coordinates (nv, n).
    """
    columns = moving_frame(loops_of(press), x, frame).columns
    wrong = ~np.isfinite(columns).all(axis=(0, 1))
    if wrong.any():
        state = int(np.argmax(wrong))
        place = press.structure.place(x[:, state])
        problem = f"{press.name} locks in state {state}, where its drivers do not determine how it moves: leave the state out"
        raise SingularityError(problem, float(x[press.driver_indices[0], state]), 0.0, place)
    return np.ascontiguousarray(columns.transpose(2, 0, 1))
