"""Forces and moments on links, springs and dampers between links, friction in bearings and guides, and the union of all loads.

A bearing resists its rotation with the torque c w + mu r F, where F is its radial force (across the axis of rotation). A guide resists its
sliding with the force c v + mu F, where F is its force across the direction of sliding. F depends on the friction of all bearings, so that
both are found together. At rest, in a dead centre, Coulomb friction can have any value up to its limit; it is taken as zero.

Gibs that are preloaded against each other rub without a load. Two of one stiffness that face each other, each preloaded by P, press with
P + N/2 and P - N/2 under a net force N, together with 2 P, until at N = 2 P one of them lifts off; from there on the other presses with N
alone. So F is the larger of 2 P and |N|.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import numbers, suitable_numbers
from ..common.errors import PinpressError, UnknownNameError, caution, shown
from ..common.parameters import Checked, in_declared_units, parameter
from ..common.quantities import Array
from ..engines.friction import FrictionLaw
from ..engines.machine_elements.forces import friction_law
from .pneumatics import BalanceCylinder
from .process import ProcessLoad, TimeForce

if TYPE_CHECKING:
    from ..kinematics.motion import Motion
    from ..linkage.linkage import Linkage


COUNTER_CLOCKWISE = (0.0, -1.0, 0.0)  # axis of a turn from x to z


@dataclass(frozen=True)
class PointForce:
    """A force at a point of a link.

    A force between slide and bolster, such as a forming load, does not reach the foundation. A process load (`loads`) acts on the frame
    too; here give the reaction on the frame as a second PointForce.

    Attributes:
        link: name of the link; the frame (root link) may be named too.
        force: in world axes [N]: (3,) constant, (n, 3) over the motion, or a function of the motion that returns one of these.
        point: of application, in the link's own frame [m].

    Raises:
        PinpressError: the force or the point has another shape, or is not finite. What a function of the motion returns is checked where it
            acts.
    """

    link: str
    force: ArrayLike | Callable[[Motion], ArrayLike] = field(metadata=parameter("N", axes=1))
    point: tuple[float, float, float] = field(default=(0.0, 0.0, 0.0), metadata=parameter("m", axes=1))

    def __post_init__(self) -> None:
        in_declared_units(self)
        check_point(f"{self.label}: point", self.point)
        if not callable(self.force):
            shape = numbers(f"{self.label}: force", self.force).shape
            if shape != (3,) and (len(shape) != 2 or shape[1] != 3):
                raise PinpressError(f"{self.label}: force has shape {shape}; give (3,) or (n, 3), in world axes [N]")

    @property
    def label(self) -> str:
        """What messages call it."""
        return f"load on {shown(self.link)}"


@dataclass(frozen=True)
class SpringDamper:
    """A spring and a damper in parallel between two points of different links, one of which may be the frame.

    The force along the line between the points is stiffness x (length - free_length) + damping x (rate of length); a positive force draws
    the points together.

    Attributes:
        link1: name of one link.
        link2: name of the other link.
        stiffness: [N/m].
        damping: [N s/m].
        free_length: length at which the spring is slack [m].
        point1: in the frame of link1 [m].
        point2: in the frame of link2 [m].

    Raises:
        PinpressError: a stiffness, damping or free length is negative or no number, or a point has another shape or is not finite.

    Warns:
        PinpressWarning: both ends are on the same link, so that it does nothing.
    """

    link1: str
    link2: str
    stiffness: float = field(default=0.0, metadata=parameter("N/m", "not negative"))
    damping: float = field(default=0.0, metadata=parameter("N s/m", "not negative"))
    free_length: float = field(default=0.0, metadata=parameter("m", "not negative"))
    point1: tuple[float, float, float] = field(default=(0.0, 0.0, 0.0), metadata=parameter("m", axes=1))
    point2: tuple[float, float, float] = field(default=(0.0, 0.0, 0.0), metadata=parameter("m", axes=1))

    def __post_init__(self) -> None:
        in_declared_units(self)
        for quantity in ("stiffness", "damping", "free_length"):
            wanted = "one number that is not negative"
            suitable_numbers(f"{self.label}: {quantity}", getattr(self, quantity), wanted, suits=lambda value: value >= 0)
        check_point(f"{self.label}: point1", self.point1)
        check_point(f"{self.label}: point2", self.point2)
        if isinstance(self.link1, str) and isinstance(self.link2, str) and self.link1 == self.link2:
            caution(f"SpringDamper: link1 and link2 are both {shown(self.link1)}, which does not stretch it: name two links")

    @property
    def label(self) -> str:
        """What messages call it."""
        return f"spring between {shown(self.link1)} and {shown(self.link2)}"


@dataclass(frozen=True)
class PointMoment:
    """A moment on a link, which needs no point.

    Attributes:
        link: name of the link; the frame (root link) may be named too.
        moment: one number, positive counter-clockwise in the plane with x to the right and z up, which is about the world's -y (refused
            for a linkage that moves in another plane); or in world axes (3,), constant, (n, 3) over the motion, or a function of the motion
            that returns one of these [N m].
        on: name of the link that takes the opposite moment; None: it comes from outside the machine, and reaches the foundation.

    Raises:
        PinpressError: the moment has another shape, or is not finite. What a function of the motion returns is checked where it acts.

    Warns:
        PinpressWarning: both are the same link, so that it does nothing.
    """

    link: str
    moment: ArrayLike | Callable[[Motion], ArrayLike] = field(metadata=parameter("N m", axes=1))
    on: str | None = None

    def __post_init__(self) -> None:
        in_declared_units(self)
        if not callable(self.moment):
            self.vectors(self.moment)
        if isinstance(self.link, str) and isinstance(self.on, str) and self.link == self.on:
            caution(f"{self.label}: on is the same link, so that it does nothing: name another one")

    @property
    def label(self) -> str:
        """What messages call it."""
        return f"moment on {shown(self.link)}"

    def vectors(self, moment: object) -> Array:
        """The moment in world axes, (3,) or (n, 3) [N m]; raises PinpressError where it has another shape or is not finite."""
        values = numbers(f"{self.label}: moment", moment, unit="N m")
        if values.size == 1 and values.ndim <= 1:  # a job reads every row of numbers as a row
            return np.multiply(values.reshape(()), COUNTER_CLOCKWISE)
        if values.shape != (3,) and (values.ndim != 2 or values.shape[1] != 3):
            raise PinpressError(f"{self.label}: moment has shape {values.shape}; give one number, (3,) or (n, 3), in world axes [N m]")
        return values


@dataclass(frozen=True)
class TorsionSpring:
    """A torsion spring and a damper in parallel between two links that turn about parallel axes, one of which may be the frame.

    The moment on link2 is -(stiffness x (angle - free_angle) + damping x (rate of angle)), that on link1 the opposite. The angle is that of
    link2 against link1 along the motion, over any number of turns: zero where all joints between them stand at zero, as drawn, positive
    about the axis of the first pin on the way from link1 to link2. A spring between the two links of one pin is what
    ``<joint_spring>`` is in a file.

    Attributes:
        link1: name of one link.
        link2: name of the other link.
        stiffness: [N m/rad].
        damping: [N m s/rad].
        free_angle: angle at which the spring is slack [rad].

    Raises:
        PinpressError: a stiffness or damping is negative or no number, or the angle is no number. Where it acts: the links do not turn
            against each other, or not about parallel axes.

    Warns:
        PinpressWarning: both are the same link, so that it does nothing.
    """

    link1: str
    link2: str
    stiffness: float = field(default=0.0, metadata=parameter("N m/rad", "not negative"))
    damping: float = field(default=0.0, metadata=parameter("N m s/rad", "not negative"))
    free_angle: float = field(default=0.0, metadata=parameter("rad"))

    def __post_init__(self) -> None:
        in_declared_units(self)
        for quantity in ("stiffness", "damping"):
            wanted = "one number that is not negative"
            suitable_numbers(f"{self.label}: {quantity}", getattr(self, quantity), wanted, suits=lambda value: value >= 0)
        suitable_numbers(f"{self.label}: free_angle", self.free_angle, "one finite number [rad]")

    @property
    def label(self) -> str:
        """What messages call it."""
        return f"torsion spring between {shown(self.link1)} and {shown(self.link2)}"


Spring = SpringDamper | TorsionSpring

LinkLoad = PointForce | PointMoment | Spring
"""What acts on links by their names, whatever the slide does."""

StandingLoad = LinkLoad | BalanceCylinder
"""What acts over the whole stroke, in addition to the process."""

Load = LinkLoad | ProcessLoad | TimeForce


def is_constant(load: object) -> bool:
    """Whether a load is a force or moment that is the same in all states."""
    if isinstance(load, PointMoment):
        return not callable(load.moment) and np.ndim(load.moment) <= 1
    return isinstance(load, PointForce) and not callable(load.force) and np.ndim(load.force) == 1


def check_point(name: str, point: object) -> Array:
    """A point (3,) in a link's frame [m]; raises PinpressError where it has another shape or is not finite."""
    position = numbers(name, point, unit="m")
    if position.shape != (3,):
        raise PinpressError(f"{name} has shape {position.shape}; give x, y, z in the link's frame [m]")
    return position


@dataclass(frozen=True)
class Friction(Checked):
    """Friction of a bearing or guide.

    Attributes:
        coefficient: coefficient mu of Coulomb friction [-].
        radius: of the bearing [m]; a guide has none.
        viscous: viscous torque by angular speed [N m s/rad], in a guide viscous force by speed [N s/m].
        preload: of a guide: force with which all its gibs together press on the slide without a load [N]. Coulomb friction is that of the
            preload, or of the force across the guide where this is larger.

    Raises:
        PinpressError: a value is negative or no finite number.
    """

    coefficient: float = field(default=0.0, metadata=parameter("-", "not negative"))
    radius: float | None = field(default=None, metadata=parameter("m", "not negative"))
    viscous: float = 0.0
    preload: float = field(default=0.0, metadata=parameter("N", "not negative"))

    def __post_init__(self) -> None:
        super().__post_init__()
        wanted = "a finite number that is not negative"  # its unit differs between bearings and guides
        suitable_numbers("Friction: viscous", self.viscous, wanted, suits=lambda value: value >= 0)


def law(friction: Mapping[str, Friction], press: Linkage) -> FrictionLaw | None:
    """The friction of a linkage's bearings, with the losses of its contacts; None if there is neither.

    Raises:
        UnknownNameError: the linkage does not have a bearing of that name.
        PinpressError: a fixed loop has friction, a radius is missing or superfluous, or a pin has a preload.

    Warns:
        PinpressWarning: a coefficient is above 1, a radius above the size of the linkage, or a preload so small that it may be in kN.
    """
    if not isinstance(friction, Mapping):
        raise PinpressError("friction is no mapping: give {name of a bearing: Friction(...)}")
    if not (friction or any(contact.rubbing for contact in press.contacts)):
        return None
    size = press.size  # each look at it compares the whole model
    turns = [axis.turns for axis in press.axes] + [True] * len(press.loops)
    arm, viscous, preload = np.zeros((3, len(press.bearings)))
    for name, given in friction.items():
        if name not in press.bearings:
            raise UnknownNameError("bearing", name, press.bearings)
        if not isinstance(given, Friction):
            raise PinpressError(f"friction of {shown(name)} is {shown(given)}: give a Friction")
        index = press.bearings.index(name)
        if any(loop.name == name and loop.type == "fixed" for loop in press.loops):
            raise PinpressError(f"friction of {shown(name)}: a fixed loop does not turn; leave it out")
        if turns[index] and given.coefficient and given.radius is None:
            raise PinpressError(f"friction of {shown(name)}: its radius is missing; give that of the bearing [m]")
        if not turns[index] and given.radius is not None:
            raise PinpressError(f"friction of {shown(name)}: a guide has no radius; leave it out")
        if turns[index] and given.preload:
            raise PinpressError(f"friction of {shown(name)}: preload is that of the gibs of a guide; leave it out")
        plausibility.friction(shown(name), given.coefficient, given.radius or 0.0, size, given.preload)
        arm[index] = given.coefficient * (1.0 if given.radius is None else given.radius)
        viscous[index], preload[index] = given.viscous, given.preload
    return friction_law(arm, viscous, preload, press.structure)
