"""Masses added to the links of a press: the new press, and the changes of torques and forces.

A mass m at a point of a link acts on the link like the force m (g - a) at this point, where a is the point's acceleration (d'Alembert). So
all forces are linear in the masses, and in quantities that point masses represent: a counterweight, a mass moment, a moment of inertia.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..common.arguments import expect, number, numbers, typed
from ..common.errors import PinpressError, UnknownNameError, cautions_collected, shown
from ..common.frozen import Frozen
from ..common.quantities import Array
from ..common.results import Record
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion
from ..kinematics.poses import point_on_body
from ..linkage.linkage import Linkage, first_unphysical
from ..loads.link import Load, PointForce, check_point


@dataclass(frozen=True, repr=False)
class Counterweight(Record, units={"mass": "kg", "position": "m", "inertia": "kg m2"}, parts={"position": "xyz"}):
    """A mass fixed to a link; a negative mass is a hole.

    Attributes:
        link: name of the link.
        mass: mass [kg].
        position: (3,) centre of mass in the link's own frame [m].
        inertia: moment of inertia about the centre of mass: in a planar press about the plane's normal, as of a lamina, in other presses
            about every axis [kg m2]. 0 is a point mass, m_b r_b^2 / 2 a disc as in Zhang 2007, (5-6). It is negative only for a negative
            mass.

    Raises:
        PinpressError: a number is not finite, or no body can have this inertia with this mass.
    """

    link: str
    mass: float
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    inertia: float = 0.0

    def __post_init__(self) -> None:
        what = f"counterweight on {shown(self.link)}"
        vars(self)["mass"] = number(f"{what}: mass", self.mass, "kg")
        vars(self)["inertia"] = number(f"{what}: inertia", self.inertia, "kg m2")
        vars(self)["position"] = tuple(numbers(f"{what}: position", self.position, (3,), unit="m").tolist())
        if self.inertia * self.mass < 0 or (self.inertia and not self.mass):
            raise PinpressError(
                f"{what}: no body has an inertia of {self.inertia:g} kg m2 with a mass of {self.mass:g} kg: give both the same sign"
            )


@typed
def with_counterweights(press: Linkage, counterweights: Iterable[Counterweight]) -> Linkage:
    """Fix counterweights to the links of a press.

    Mass, centre of mass and inertia of a link with its counterweight follow Zhang 2007, (5-3) to (5-6), without their special cases: (5-4)
    finds the centre on one side only, and (5-5) is 0 / 0 for a counterweight on the line of a rod.

    Args:
        press: the press without the counterweights.
        counterweights: counterweights and holes.

    Returns:
        The new press, which `write_urdf` can write.

    Raises:
        UnknownNameError: the press does not have a link with this name.
        PinpressError: a counterweight is on the frame, has a number that is not finite or an inertia without mass, or a hole leaves a link
            without mass or with an inertia that no body can have.
    """
    inertias = list(press.model.inertias)
    changed = set()
    for weight in counterweights:
        joint, added = _added_inertia(press, weight)
        inertias[joint] = combine_inertias(inertias[joint], added)
        changed.add(joint)
    for joint in changed:
        refuse_unphysical(press, joint, inertias[joint])
    return press.with_inertias(inertias)


def with_die(press: Linkage, mass: float, slide: str) -> Linkage:
    """The press with an upper die [kg] in the centre of mass of its slide."""
    frame = press.frame_of(slide)
    x, y, z = frame.placement.actInv(press.model.inertias[frame.parentJoint].lever).tolist()
    return with_counterweights(press, [Counterweight(slide, mass, (x, y, z))])


@dataclass(frozen=True)
class OperatingCondition(Frozen):
    """An operating condition: a motion of the press, the loads on it as in `inverse_dynamics`, and the press with its die or stroke.

        die = pp.balancing.Counterweight("slide", 300.0, (0.0, 0.0, -0.4))  # an upper die of 300 kg
        with_die = pp.balancing.with_counterweights(press, [die])
        pp.balancing.OperatingCondition(pp.cycle(with_die, speed), press=with_die, name="die of 300 kg")

    Attributes:
        motion: motion of the press.
        loads: loads on the press in this motion.
        press: the press with the die or stroke of this condition, with the same links, joints and bearings; None: the press itself.
        name: name in tables; empty: the condition's number.

    Raises:
        PinpressError: motion is not a motion, press is not a press, or name is not a text.
    """

    motion: Motion
    loads: Sequence[Load] = ()
    press: Linkage | None = None
    name: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        expect("operating condition: motion", self.motion, Motion, "cycle or simulate")
        if self.press is not None:
            expect("operating condition: press", self.press, Linkage, "load or with_counterweights")
        if not isinstance(self.name, str):
            raise PinpressError(f"operating condition: name is {shown(self.name)}: give a text")

    def set_up(self, press: Linkage) -> Linkage:
        """The press in this condition; ``press``: the press itself."""
        return press if self.press is None else self.press


@dataclass(frozen=True, eq=False, repr=False)
class PointMasses:
    """Point masses on a link.

    Attributes:
        link: name of the link.
        masses: (p,) masses, possibly negative, because several can represent a mass moment or a moment of inertia [kg].
        points: (p, 3) places in the link's own frame [m].
    """

    link: str
    masses: Array
    points: Array


@dataclass(frozen=True, eq=False, repr=False)
class MassResponse:
    """The changes of the forces of `Reactions` by masses, in world axes. Changes that were not computed are empty.

    Attributes:
        shaking_force: (n, 3) change of the shaking force [N].
        shaking_moment: (n, 3) change of the shaking moment about the world origin [N m].
        driving_torque: (n,), or (n, drivers) with several drivers, change of the driving torque [N m].
        bearing_force: name of a bearing -> (n, 3) change of its force [N].
        bearing_moment: name of a bearing -> (n, 3) change of its moment [N m].
    """

    shaking_force: Array
    shaking_moment: Array
    driving_torque: Array
    bearing_force: Mapping[str, Array]
    bearing_moment: Mapping[str, Array]


def mass_response(
    press: Linkage, condition: OperatingCondition, reactions: Reactions, masses: PointMasses, inner_forces: bool
) -> MassResponse:
    """Compute the changes of the shaking force and moment, and optionally of the inner forces, by point masses.

    Args:
        press: the press without the masses.
        condition: motion and loads.
        reactions: reactions of the press in this condition without the masses.
        masses: the point masses.
        inner_forces: whether to compute the changes of the driving torque and of the bearings in ``reactions`` too.
    """
    position, force = _inertia_forces(press, condition.motion, masses)
    shaking = force.sum(axis=0), np.cross(position, force).sum(axis=0)
    if not inner_forces:
        return MassResponse(*shaking, np.zeros((len(condition.motion.crank_angle), 0)), {}, {})
    # Masses as heavy as the press keep the digits of the difference of two reactions.
    largest = np.abs(masses.masses).max()
    factor = moving_mass(press) / largest if largest > 0 else 1.0
    added = [PointForce(masses.link, factor * f, tuple(p)) for f, p in zip(force, masses.points, strict=True) if f.any()]
    with cautions_collected():  # the functions that take regions and loads already caution
        after = inverse_dynamics(press, condition.motion, [*condition.loads, *added], bearings=tuple(reactions.bearing_force))
    return MassResponse(
        *shaking,
        driving_torque=(after.driving_torque - reactions.driving_torque) / factor,
        bearing_force={name: (after.bearing_force[name] - before) / factor for name, before in reactions.bearing_force.items()},
        bearing_moment={name: (after.bearing_moment[name] - before) / factor for name, before in reactions.bearing_moment.items()},
    )


def moving_mass(press: Linkage) -> float:
    """Mass of all links except the frame [kg]."""
    return float(sum(inertia.mass for inertia in list(press.model.inertias)[1:]))


def carrying_joint(press: Linkage, link: str, position: tuple[float, float, float], what: str) -> tuple[int, Array]:
    """The Pinocchio joint that carries a moving link, and a point of the link in that joint's frame [m].

    Args:
        press: the press.
        link: name of the link.
        position: (3,) point in the link's own frame [m].
        what: name of the placed object, for messages.

    Raises:
        PinpressError: the link does not move, or the position is not three finite numbers.
    """
    joint, point = point_on_body(press, link, check_point(f"{what}: position", position), what, "position")
    if joint == 0:
        moving = [name for name in press.links if press.frame_of(name).parentJoint]
        raise PinpressError(f"{what}: link {shown(link)} does not move, so a mass on it balances nothing: give one of {', '.join(moving)}")
    return joint, point


def combine_inertias(first: pin.Inertia, second: pin.Inertia) -> pin.Inertia:
    """The inertia of two bodies fixed together, in one frame. A body may be a hole, which Pinocchio's sum does not accept."""
    mass = first.mass + second.mass
    lever = (first.mass * first.lever + second.mass * second.lever) / mass if mass else np.zeros(3)
    tensor = first.inertia + second.inertia
    for part in (first, second):
        arm = part.lever - lever
        tensor = tensor + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return rigid_body(mass, lever, tensor)


def rigid_body(mass: float, lever: Array, tensor: Array) -> pin.Inertia:
    """The inertia of a mass [kg] with its centre at ``lever`` (3,) [m] and a tensor (3, 3) about that centre [kg m2]."""
    result = pin.Inertia.Zero()  # Pinocchio's constructor refuses holes, and thin bodies with rounding errors
    result.mass, result.lever, result.inertia = mass, lever, tensor
    return result


def unit_tensor(press: Linkage, joint: int) -> Array:
    """Inertia tensor (3, 3) in the joint's frame of material whose moment of inertia is one [kg m2].

    In a planar press the material is a lamina in the plane, with its inertia about the plane's normal; in any other press it is a ball.
    """
    axes = press.engine_of_one_driver.turning_axes(joint)
    return np.asarray(0.5 * (np.eye(3) + axes.T @ axes))


def refuse_unphysical(press: Linkage, joint: int, inertia: pin.Inertia) -> None:
    """Raise PinpressError if counterweights leave a joint with an inertia that no body can have."""
    name = press.model.names[joint]
    if not inertia.mass > 0:
        raise PinpressError(f"counterweights leave the body on joint {shown(name)} a mass of {inertia.mass:g} kg: remove less mass")
    if wrong := first_unphysical([inertia]):
        remedy = "remove less mass, or mass nearer to its centre of mass"
        raise PinpressError(f"counterweights leave the body on joint {shown(name)} {wrong[1]}: {remedy}")


def _added_inertia(press: Linkage, weight: Counterweight) -> tuple[int, pin.Inertia]:
    """The Pinocchio joint that carries a counterweight, and its inertia in that joint's frame."""
    if not isinstance(weight, Counterweight):
        raise PinpressError(f"{shown(weight)} is not a counterweight: give Counterweight(link, mass, position)")
    what = f"counterweight on {shown(weight.link)}"
    if weight.link not in press.links:
        raise UnknownNameError("link", weight.link, press.links)
    joint, point = carrying_joint(press, weight.link, weight.position, what)
    return joint, rigid_body(weight.mass, point, weight.inertia * unit_tensor(press, joint))


def _inertia_forces(press: Linkage, motion: Motion, masses: PointMasses) -> tuple[Array, Array]:
    """World positions (p, n, 3) of the masses [m], and weight plus inertia force (p, n, 3) of each [N]."""
    frame = press.frame_of(masses.link)
    points = masses.points @ frame.placement.rotation.T + frame.placement.translation
    moved = press.engine().body_motion(motion.states(press), [frame.parentJoint]).points(points)
    position, acceleration = moved.place.swapaxes(1, 2), moved.acceleration.swapaxes(1, 2)
    return position, masses.masses[:, None, None] * (press.model.gravity.linear - acceleration)
