"""Forces that act on the links from outside, and springs and dampers between them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from .coordinates import Array
from .errors import PinpressError, UnknownNameError
from .points import point_motion

if TYPE_CHECKING:
    from .linkage import Linkage
    from .motion import Motion


@dataclass(frozen=True)
class PointForce:
    """A force at a point of a link.

    A force between the slide and the bolster, such as a forming load, does not reach the foundation: give its reaction as a second
    PointForce on the frame.

    Attributes:
        link: name of the link; the frame (root link) may be named too.
        force: in world axes [N]: (3,) constant, (n, 3) over the motion, or a function of the motion that returns one of these.
        point: of application, in the link's own frame [m].
    """

    link: str
    force: "ArrayLike | Callable[[Motion], ArrayLike]"
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SpringDamper:
    """A spring and a damper side by side between a point of one link and one of another, which may be the frame.

    Its force along the line between the points is stiffness x (length - free_length) + damping x (rate of length), drawing them together
    where positive.

    Attributes:
        link1, link2: names of the links. point1, point2: in the links' own frames [m].
        stiffness: [N/m]. damping: [N s/m]. free_length: length at which the spring is slack [m].
    """

    link1: str
    link2: str
    stiffness: float = 0.0
    damping: float = 0.0
    free_length: float = 0.0
    point1: tuple[float, float, float] = (0.0, 0.0, 0.0)
    point2: tuple[float, float, float] = (0.0, 0.0, 0.0)


Load = PointForce | SpringDamper


@dataclass(frozen=True)
class AppliedForce:
    """A load worked out for one motion: on the body of Pinocchio joint ``joint`` (0: the frame), ``point`` (3,) in that joint's
    frame [m], ``force`` (n, 3) in world axes [N]."""

    joint: int
    point: Array
    force: Array

    def part(self, points: slice) -> "AppliedForce":
        """The same over a part of the motion."""
        return AppliedForce(self.joint, self.point, self.force[points])


def apply(loads: Sequence[Load], press: "Linkage", motion: "Motion") -> list[AppliedForce]:
    """Loads as arrays over the motion.

    Raises:
        UnknownNameError: a load on a link that the linkage does not have.
        PinpressError: a force of the wrong shape, a value that is not finite, a spring whose ends meet.
    """
    applied: list[AppliedForce] = []
    for load in loads:
        if isinstance(load, SpringDamper):
            applied += _stretched(load, press, motion)
        elif isinstance(load, PointForce):
            applied.append(_applied(load, press, motion))
        else:
            raise PinpressError(f"load {load!r} is none: give a PointForce or a SpringDamper")
    return applied


def _applied(load: PointForce, press: "Linkage", motion: "Motion") -> AppliedForce:
    points, what = len(motion.crank_angle), f"load on {load.link!r}"
    joint, point = _place(press, load.link, load.point, what, "point")
    force = _numbers(load.force(motion) if callable(load.force) else load.force, what, "force")
    if force.shape not in ((3,), (points, 3)):
        raise PinpressError(f"{what}: force has shape {force.shape}; give (3,) or ({points}, 3), in world axes [N]")
    return AppliedForce(joint, point, np.broadcast_to(force, (points, 3)))


def _stretched(load: SpringDamper, press: "Linkage", motion: "Motion") -> list[AppliedForce]:
    """The forces of a spring and damper on its two links."""
    what = f"spring between {load.link1!r} and {load.link2!r}"
    for quantity in ("stiffness", "damping", "free_length"):
        value = _numbers(getattr(load, quantity), what, quantity)
        if value.ndim or value < 0:
            raise PinpressError(f"{what}: {quantity} is {getattr(load, quantity)!r}; give one number that is not negative")
    ends = [
        _place(press, load.link1, load.point1, what, "point1"),
        _place(press, load.link2, load.point2, what, "point2"),
    ]
    (position1, velocity1), (position2, velocity2) = (point_motion(press, motion, *end) for end in ends)
    between, rate = position2 - position1, velocity2 - velocity1
    length = np.linalg.norm(between, axis=1)
    if (load.free_length or load.damping) and not length.min() > 1e-12 * press.spatial.size:
        angle = np.degrees(np.ravel(motion.crank_angle[int(length.argmin())])[0])
        raise PinpressError(f"{what}: its ends meet at crank angle {angle:.6g} deg, where it has no direction; move a point")
    direction = between / np.where(length == 0.0, 1.0, length)[:, None]
    tension = load.stiffness * (length - load.free_length) + load.damping * np.einsum("nk,nk->n", rate, direction)
    force = tension[:, None] * direction
    return [AppliedForce(*ends[0], force), AppliedForce(*ends[1], -force)]


def _place(press: "Linkage", link: str, point: ArrayLike, what: str, name: str) -> tuple[int, Array]:
    """The joint whose body a link belongs to, and a point of the link in that joint's frame."""
    if link not in press.links:
        raise UnknownNameError("link", link, press.links)
    numbers = _numbers(point, what, name)
    if numbers.shape != (3,):
        raise PinpressError(f"{what}: {name} has shape {numbers.shape}; give x, y, z in the link's frame [m]")
    frame = press.model.frames[press.model.getFrameId(link, pin.BODY)]
    return frame.parentJoint, frame.placement.act(numbers)


def _numbers(values: ArrayLike, what: str, name: str) -> Array:
    try:
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise PinpressError(f"{what}: {name} is not an array of numbers") from None
    if not np.all(np.isfinite(numbers)):
        raise PinpressError(f"{what}: {name} is not finite")
    return numbers
