"""Forces that act on the links from outside, and springs, dampers and process loads between them."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import numbers, suitable_numbers
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.quantities import Array
from ..engines.forces import REST, AppliedForce
from ..kinematics.motion import point_motion
from ..kinematics.slide_path import dead_centres
from ..loads import caller_laws
from ..loads.link import Load, PointForce, SpringDamper
from ..loads.process import ForceInterval, ProcessLoad, TimeForce, datum

if TYPE_CHECKING:
    from ..kinematics.motion import Motion
    from ..linkage.linkage import Linkage


def asked(loads: Sequence[Load]) -> list[Load]:
    """The loads with callers' own functions wrapped, so that their errors and numbers are checked; other loads are returned unchanged."""
    return [
        replace(load, force=caller_laws.ForceOfMotion(f"load on {shown(load.link)}: force", load.force, np.geterr()))
        if isinstance(load, PointForce) and callable(load.force)
        else load
        if isinstance(load, PointForce | SpringDamper)  # looking whether something follows a protocol takes long
        else caller_laws.asked_load(load)
        for load in loads
    ]


def apply(loads: Sequence[Load], press: "Linkage", motion: "Motion") -> list[AppliedForce]:
    """Loads as arrays over the motion.

    A process load acts by its intervals for downward travel where the slide moves against its guide's axis, else by those for upward
    travel. Where the slide rests, its travel counts as upward, so that a load of the working stroke has ended at bottom dead centre.

    Raises:
        UnknownNameError: a load on a link that the linkage does not have.
        PinpressError: a force of the wrong shape; a value that is not finite; a spring whose ends meet; a process load on a linkage without
            a slide, without a datum, or for several scenarios; a force in time for states that have no time.
    """
    applied: list[AppliedForce] = []
    for load in loads:
        if isinstance(load, SpringDamper):
            applied += _spring_forces(load, press, motion)
        elif isinstance(load, PointForce):
            applied.append(_point_force(load, press, motion))
        elif isinstance(load, TimeForce):
            applied += _on_slide(load, press, _in_time(load, motion))
        elif isinstance(load, ProcessLoad) and not isinstance(load, type):
            applied += _on_slide(load, press, _in_height(load, press, motion))
        else:
            raise PinpressError(
                f"load {shown(load)} is none: give a PointForce, a SpringDamper, a process load (pinpress.loads) or a TimeForce"
            )
    return applied


def _on_slide(load: "ProcessLoad | TimeForce", press: "Linkage", along: Array) -> list[AppliedForce]:
    """A force (n,) [N] along the guide's axis at the slide's origin, and the opposite force on the frame in the same line of action."""
    guide, _ = press.slide_guide
    placement = press.model.jointPlacements[guide + 1]  # in the world, as the frame carries the guide
    origin = press.model.frames[press.model.getFrameId(press.slide, pin.BODY)].placement.translation
    force = along[:, None] * (placement.rotation @ press.axes[guide].direction)
    # The slide's origin moves along the axis: where it was drawn is a point of the frame in its line of action.
    return [AppliedForce(guide + 1, origin, force), AppliedForce(0, placement.act(origin), -force)]


def _in_height(load: ProcessLoad, press: "Linkage", motion: "Motion") -> Array:
    """The force (n,) of a process load on the slide, along the guide's axis [N]."""
    name, (guide, offset), force = caller_laws.name(load), press.slide_guide, np.zeros(len(motion.crank_angle))
    intervals = [(downwards, interval) for downwards in (True, False) for interval in load.intervals(downwards)]
    if not intervals:  # an idle press needs no datum
        return force
    zero = datum(caller_laws.as_given(load), press)
    height, velocity = motion.joint_position[:, guide] + (offset - zero), motion.v[:, guide]
    # At a dead centre the speed is rounding, which must not decide on the direction of travel.
    down = velocity < -REST * press.size * np.abs(motion.crank_speed).max()
    acts = False
    for downwards, interval in intervals:
        _refuse_scenarios(name, interval)
        inside = np.flatnonzero((down == downwards) & (interval.lower < height) & (height <= interval.upper))
        acts |= len(inside) > 0
        law = numbers(f"{name}: force", interval.force(height[inside], velocity[inside]))
        if law.shape not in ((), inside.shape):
            raise PinpressError(f"{name}: force of {inside.shape} heights has shape {law.shape}; give the same")
        force[inside] = np.maximum(law, 0.0) if interval.one_sided else law
    low, high = (-math.inf, math.inf) if acts else turning_points(press)
    plausibility.heights(name, [(interval.lower, interval.upper) for _, interval in intervals], low - zero, high - zero, press.size)
    return force


def turning_points(press: "Linkage") -> tuple[float, float]:
    """Slide positions at bottom and top dead centre [m]; infinite where there are none."""
    try:
        ends = dead_centres(press)
        return ends.bottom_position, ends.top_position
    except PinpressError:
        return -math.inf, math.inf


def _refuse_scenarios(name: str, interval: ForceInterval) -> None:
    """Raise PinpressError where a load's magnitude is an array of scenarios: over as many states it would be taken for one number a
    state."""
    somewhere = next((height for height in (interval.upper, interval.lower) if math.isfinite(height)), 0.0)
    shape = np.shape(interval.force(somewhere, 0.0))
    if shape:
        raise PinpressError(f"{name}: its force has shape {shape}, for scenarios; give one number, as a motion is one scenario")


def _in_time(load: TimeForce, motion: "Motion") -> Array:
    """The force (n,) of a load in time on the slide, along the guide's axis [N]."""
    for times in (motion.time[:1], motion.time):  # one time first: an array that does not depend on time may have as many values as states
        force = numbers("TimeForce: force", load.force(times))
        if force.shape not in ((), times.shape):
            raise PinpressError(f"TimeForce: force of {len(times)} times has shape {force.shape}; give {times.shape}, as the time has")
    return np.broadcast_to(force, motion.time.shape)


def _point_force(load: PointForce, press: "Linkage", motion: "Motion") -> AppliedForce:
    points, what = len(motion.crank_angle), f"load on {shown(load.link)}"
    joint, point = point_on_body(press, load.link, load.point, what, "point")
    force = numbers(f"{what}: force", load.force(motion) if callable(load.force) else load.force)
    if force.shape not in ((3,), (points, 3)):
        raise PinpressError(f"{what}: force has shape {force.shape}; give (3,) or ({points}, 3), in world axes [N]")
    return AppliedForce(joint, point, np.broadcast_to(force, (points, 3)))


def _spring_forces(load: SpringDamper, press: "Linkage", motion: "Motion") -> list[AppliedForce]:
    """The forces of a spring and damper on its two links."""
    ends, what = spring_ends(load, press), _spring_in_words(load)
    (position1, velocity1), (position2, velocity2) = (point_motion(press, motion, *end) for end in ends)
    span, rate = position2 - position1, velocity2 - velocity1
    length = np.linalg.norm(span, axis=1)
    if (load.free_length or load.damping) and not length.min() > 1e-12 * press.size:
        angle = np.degrees(np.ravel(motion.crank_angle[int(length.argmin())])[0])
        raise PinpressError(f"{what}: its ends meet at crank angle {angle:.6g} deg, where it has no direction; move a point")
    direction = span / np.where(length == 0.0, 1.0, length)[:, None]
    tension = load.stiffness * (length - load.free_length) + load.damping * np.einsum("nk,nk->n", rate, direction)
    force = tension[:, None] * direction
    return [AppliedForce(*ends[0], force), AppliedForce(*ends[1], -force)]


def spring_ends(load: SpringDamper, press: "Linkage") -> tuple[tuple[int, Array], tuple[int, Array]]:
    """The ends of a spring: for each the Pinocchio joint on whose body it is, and the point (3,) in that joint's frame [m].

    Raises:
        UnknownNameError: a link that the linkage does not have.
        PinpressError: a stiffness, damping or free length that is negative or no number, or a point of another shape.
    """
    what = _spring_in_words(load)
    for quantity in ("stiffness", "damping", "free_length"):
        wanted = "one number that is not negative"
        suitable_numbers(f"{what}: {quantity}", getattr(load, quantity), wanted, suits=lambda value: value >= 0)
    return point_on_body(press, load.link1, load.point1, what, "point1"), point_on_body(press, load.link2, load.point2, what, "point2")


def _spring_in_words(load: SpringDamper) -> str:
    return f"spring between {shown(load.link1)} and {shown(load.link2)}"


def point_on_body(press: "Linkage", link: str, point: ArrayLike, what: str, name: str) -> tuple[int, Array]:
    """The Pinocchio joint to whose body a link belongs, and a point of the link in that joint's frame (3,) [m].

    Args:
        press: the linkage.
        link: name of the link.
        point: (3,) in the link's frame [m].
        what: what has the point, for messages.
        name: the argument's name, for messages.

    Raises:
        UnknownNameError: a link that the linkage does not have.
        PinpressError: a point of another shape or not finite.
    """
    if link not in press.links:
        raise UnknownNameError("link", link, press.links)
    position = numbers(f"{what}: {name}", point)
    if position.shape != (3,):
        raise PinpressError(f"{what}: {name} has shape {position.shape}; give x, y, z in the link's frame [m]")
    plausibility.point(f"{what}: {name}", position, press.size)
    frame = press.model.frames[press.model.getFrameId(link, pin.BODY)]
    return frame.parentJoint, frame.placement.act(position)
