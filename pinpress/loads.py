"""Forces that act on the links from outside."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from .coordinates import Array
from .errors import PinpressError, UnknownNameError

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
class AppliedForce:
    """A PointForce worked out for one motion: on the body of Pinocchio joint ``joint`` (0: the frame), ``point`` (3,) in that joint's
    frame [m], ``force`` (n, 3) in world axes [N]."""

    joint: int
    point: Array
    force: Array

    def part(self, points: slice) -> "AppliedForce":
        """The same over a part of the motion."""
        return AppliedForce(self.joint, self.point, self.force[points])


def apply(loads: Sequence[PointForce], press: "Linkage", motion: "Motion") -> list[AppliedForce]:
    """Loads as arrays over the motion.

    Raises:
        UnknownNameError: a load on a link that the linkage does not have.
        PinpressError: a force of the wrong shape, or a value that is not finite.
    """
    return [_applied(load, press, motion) for load in loads]


def _applied(load: PointForce, press: "Linkage", motion: "Motion") -> AppliedForce:
    if load.link not in press.links:
        raise UnknownNameError("link", load.link, press.links)
    points = len(motion.crank_angle)
    force = _numbers(load.force(motion) if callable(load.force) else load.force, load, "force")
    if force.shape not in ((3,), (points, 3)):
        raise PinpressError(f"load on {load.link!r}: force has shape {force.shape}; give (3,) or ({points}, 3), in world axes [N]")
    point = _numbers(load.point, load, "point")
    if point.shape != (3,):
        raise PinpressError(f"load on {load.link!r}: point has shape {point.shape}; give x, y, z in the link's frame [m]")
    frame = press.model.frames[press.model.getFrameId(load.link, pin.BODY)]
    return AppliedForce(frame.parentJoint, frame.placement.act(point), np.broadcast_to(force, (points, 3)))


def _numbers(values: ArrayLike, load: PointForce, name: str) -> Array:
    try:
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise PinpressError(f"load on {load.link!r}: {name} is not an array of numbers") from None
    if not np.all(np.isfinite(numbers)):
        raise PinpressError(f"load on {load.link!r}: {name} is not finite")
    return numbers
