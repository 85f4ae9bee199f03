"""Forces on the links from outside, springs and dampers between them, and the kinds of load there are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from .process import TimeForce
from .protocol import ProcessLoad

if TYPE_CHECKING:
    from ..kinematics.motion import Motion


@dataclass(frozen=True)
class PointForce:
    """A force at a point of a link.

    A force between the slide and the bolster, such as a forming load, does not reach the foundation: a process load (`loads`) has its
    reaction on the frame with it; here give it as a second PointForce.

    Attributes:
        link: name of the link; the frame (root link) may be named too.
        force: in world axes [N]: (3,) constant, (n, 3) over the motion, or a function of the motion that returns one of these.
        point: of application, in the link's own frame [m].
    """

    link: str
    force: ArrayLike | Callable[[Motion], ArrayLike]
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class SpringDamper:
    """A spring and a damper side by side between a point of one link and one of another, which may be the frame.

    Its force along the line between the points is stiffness x (length - free_length) + damping x (rate of length), drawing them together
    where positive.

    Attributes:
        link1: name of the one link.
        link2: name of the other.
        stiffness: [N/m].
        damping: [N s/m].
        free_length: length at which the spring is slack [m].
        point1: in the frame of link1 [m].
        point2: in the frame of link2 [m].
    """

    link1: str
    link2: str
    stiffness: float = 0.0
    damping: float = 0.0
    free_length: float = 0.0
    point1: tuple[float, float, float] = (0.0, 0.0, 0.0)
    point2: tuple[float, float, float] = (0.0, 0.0, 0.0)


Load = PointForce | SpringDamper | ProcessLoad | TimeForce
