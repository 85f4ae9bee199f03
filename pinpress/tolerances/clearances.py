"""Position of the slide within the clearances of its bearings over the turn.

    play = tolerances.play(press, pp.cycle(press, 70 * pp.RPM), {"E": 50e-6, "F": 50e-6}, loads=[...])
    play.offset, play.reversals, play.bottom_shift

The force F in a bearing (parent on child) closes its radial clearance c: the child is displaced by -c F/|F| from the parent. f is the force
in the bearing for 1 N on the slide (see `virtual_work`). By virtual work the slide stands

z = sum of c f . F / |F|

above its position without clearances. If the slide presses on the bearing through the linkage (f . F > 0), the clearance lifts the slide by
up to c |f|. If the slide hangs from the bearing, the clearance lowers it by up to c |f|. When a force reverses, the slide moves by twice
that. The formula is of first order in the clearances. It assumes contact without separation and the forces of the rigid press. For impacts
and rattling there is another model, `elasticity.Elastic(clearances=...)`.

A force that reverses passes through small values. There the side of contact depends on the uncertainty of masses and loads. The parts of a
bearing's force come from weight, inertia and each load. A bearing counts as undetermined while its force is smaller than the share
`known_to` of the sum of the absolute parts: with parts known to 5 % their sum may then have any direction. There the slide may stand
anywhere in a band of c |f| to both sides.

With friction the forces are those of `inverse_dynamics` with friction, which is one more uncertain part. In a dry pin the point of contact
is turned from the force by the angle of friction, whose sine is mu. Its sense depends on which of the two links carries the pin. The model
does not know this link, so the band includes both senses.

The slide's guide is one more bearing, in which the forces across it count. A guide with a length L has two ends. Under the force N across
it and the moment M the ends carry N/2 + M/L and N/2 - M/L. If both have the same sign, the slide lies flat on a gib. Otherwise the slide is
tilted by 2 c / L.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..common import tables
from ..common.arguments import number, typed
from ..common.errors import PinpressError, UnknownNameError, caution, shown
from ..common.frozen import FrozenMapping
from ..common.parameters import Checked, parameter
from ..common.quantities import Array
from ..common.results import Record, Records, Tabular
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion, is_cycle, of_states
from ..kinematics.poses import rotation_of
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Friction, Load
from .virtual_work import UnitForces, in_plane, unit_forces

KNOWN_TO = 0.05  # default relative uncertainty of masses and loads
ROUNDING = 1e-9  # a smaller force, as a share of the largest bearing force of a state, counts as rounding error
UNMOVED = 1e-6  # with a smaller force per newton on the slide a bearing is not between drive and slide


@dataclass(frozen=True)
class GuideClearance(Checked):
    """The clearance of a guide with a length, in which the slide may tilt.

    Attributes:
        across: clearance on each side, half of the clearance between both gibs [m].
        length: length of the gibs along the guide; it moves with the sliding link [m].
        middle: distance from the sliding link's origin to the middle of this length, along `Linkage.slide_direction` for the slide, along
            the guide's axis for other links [m].
    """

    across: float = field(metadata=parameter("m", "positive"))
    length: float = field(metadata=parameter("m", "positive"))
    middle: float = field(default=0.0, metadata=parameter("m"))

    def __post_init__(self) -> None:
        super().__post_init__()
        _width("GuideClearance: across", self.across)
        if not self.length > 10 * self.across:
            raise PinpressError(
                f"GuideClearance: length is {self.length:g} m, too short for a clearance across of {self.across:g} m: give the length of"
                " the gibs and the clearance on each side, both in m"
            )


@dataclass(frozen=True, repr=False)
class ForceReversal(Record, units={"crank_angle": "rad", "change": "m", "force": "N"}):
    """A reversal of the force in a bearing, at which the slide moves through the clearance.

    Attributes:
        crank_angle: crank angle at which the force does not act along the slide's motion, linear between two states [rad]; of a driver
            that slides the position [m].
        bearing: name of the bearing, with the end of a guide that has two ends.
        side: "pressed" if the slide presses on the bearing after the reversal, "hanging" if it hangs from the bearing.
        change: by how much the slide moves, in a jump or over some degrees, 2 c |f|, positive upwards [m].
        force: remaining transverse force at this angle [N]: small if the journal knocks, large if it rolls around.
    """

    crank_angle: float
    bearing: str
    side: str
    change: float
    force: float


@dataclass(frozen=True, eq=False, repr=False)
class SlidePlay(OfPress, Tabular):
    """Position of the slide within the clearances of the bearings, in the n states of a motion. All arrays are read-only.

    Offsets are measured from the slide's position without clearances, positive along `Linkage.slide_direction` (upwards).

    Attributes:
        press_name: name of the press.
        motion: the motion.
        clearance: the given clearances.
        friction: the given friction of bearings and guides.
        known_to: relative uncertainty of masses, loads and friction [-].
        offset: (n,) offset of the slide along its guide [m].
        by_bearing: name of a bearing -> (n,) its part of the offset [m].
        lowest: (n,) lowest possible offset, with undetermined bearings and friction on the side that lowers the slide [m].
        highest: (n,) highest possible offset, with undetermined bearings and friction on the side that lifts the slide [m].
        undetermined: name of a bearing -> (n,) bool, whether its force is too small to determine the side of contact.
        shift: (n, 3) displacement of the slide across its guide at the middle of the gibs, in world axes [m]; zero without clearance there.
        rotation: (n, 3) rotation vector of the slide between the ends of its gibs, in world axes [rad].
        reversals: the forces that reverse, in the order of the states.
    """

    _press: Linkage
    motion: Motion
    clearance: Mapping[str, float | GuideClearance]
    friction: Mapping[str, Friction]
    known_to: float
    offset: Array
    by_bearing: Mapping[str, Array]
    lowest: Array
    highest: Array
    undetermined: Mapping[str, Array]
    shift: Array
    rotation: Array
    reversals: Records[ForceReversal]

    @cached_property
    def bottom_shift(self) -> float:
        """Lowest position of the slide with clearances - lowest position without [m]."""
        return float((self.motion.slide_position + self.offset).min() - self.motion.slide_position.min())

    @cached_property
    def bottom_band(self) -> tuple[float, float]:
        """Lowest and highest possible value of `bottom_shift` [m]."""
        rigid = self.motion.slide_position
        return tuple(float((rigid + edge).min() - rigid.min()) for edge in (self.lowest, self.highest))  # type: ignore[return-value]

    @cached_property
    def top_shift(self) -> float:
        """Highest position of the slide with clearances - highest position without [m]."""
        return float((self.motion.slide_position + self.offset).max() - self.motion.slide_position.max())

    @property
    def title(self) -> str:
        low, high = self.offset.min(), self.offset.max()
        return f"SlidePlay of {self.press_name}: {len(self.offset)} states, slide {low:+.4g} to {high:+.4g} m off in its clearances"

    def columns(self) -> dict[str, Array]:
        """A row for each state: driver, offset with its band, shares of the bearings, and the slide in its guide."""
        columns = self.motion._of_drivers(0) | {"offset [m]": self.offset, "lowest [m]": self.lowest, "highest [m]": self.highest}
        columns |= {f"offset_{name} [m]": share for name, share in self.by_bearing.items()}
        if self.shift.any() or self.rotation.any():
            columns |= tables.by_axis("shift", "m", self.shift) | tables.by_axis("rotation", "rad", self.rotation)
        return columns


@typed
def play(
    press: Linkage,
    motion: Motion,
    clearance: Mapping[str, float | GuideClearance],
    loads: Sequence[Load] = (),
    *,
    friction: Mapping[str, Friction] = NONE_GIVEN,
    known_to: float = KNOWN_TO,
) -> SlidePlay:
    """Compute the slide's position within the clearances of its bearings over a motion, and where forces reverse.

    Args:
        press: a press with a slide, in a plane or in space; its drivers keep their positions.
        motion: a motion of this press, from `cycle`, `servo_cycle` or a run.
        clearance: name of a bearing -> radial clearance, half of the difference of the diameters [m]; of a guide the clearance on each
            side, or a `GuideClearance` if the slide may tilt.
        loads: loads on the press, as in `inverse_dynamics`, including a balance cylinder.
        friction: friction of bearings and guides, as in `inverse_dynamics`; no friction acts at standstill, where it has no direction.
        known_to: relative uncertainty of masses, loads and friction [-]. A bearing counts as undetermined if its force is smaller than this
            share of the sum of its absolute parts.

    Raises:
        UnknownNameError: the press does not have a bearing with this name.
        PinpressError: there is no clearance, a clearance is not positive or does not suit its bearing, the moment of a guide is
            undetermined in a rigid press, the press has no slide, or known_to is out of range; also as `inverse_dynamics`.
    """
    doubt = number("known_to", known_to, "-")
    if not 0.0 <= doubt < 1.0:
        raise PinpressError(f"known_to is {doubt:g}: give a share from 0 to below 1, e.g. 0.05 for masses and loads known to 5 %")
    widths = _clearances(press, clearance)
    without = inverse_dynamics(press, motion, loads)
    reactions = inverse_dynamics(press, motion, loads, friction) if friction else without
    _refuse_open_moments(press, widths, reactions)
    unit = unit_forces(press, motion, without)
    still = np.zeros_like(motion.v.T)
    at_rest = of_states(press, motion.joint_position.T, still, still.copy(), motion.closure_error, None)
    rest, *moving = (
        inverse_dynamics(press, moved, alone) for moved, alone in ((at_rest, ()), (motion, ()), *((motion, [load]) for load in loads))
    )
    contacts, *causes = (contacts_of(press, unit, widths, by_cause) for by_cause in (reactions, rest, without, *moving))
    size = ROUNDING * np.max([np.linalg.norm(force, axis=1) for force in reactions.bearing_force.values()], axis=0)
    shares = {name: np.zeros(len(motion.v)) for name in widths}
    undetermined = {name: np.zeros(len(motion.v), bool) for name in widths}
    sure, spread = np.zeros(len(motion.v)), np.zeros(len(motion.v))
    for contact, *alone in zip(contacts, *causes, strict=True):
        weight, together, unloaded, *loaded = (cause.force for cause in alone)
        parts = [weight, unloaded - weight, *(force - unloaded for force in loaded), contact.force - together]
        weak = np.linalg.norm(contact.force, axis=1) <= doubt * sum(np.linalg.norm(part, axis=1) for part in parts) + size
        offset = contact.offset
        shares[contact.bearing] += offset
        undetermined[contact.bearing] |= weak
        sure += np.where(weak, 0.0, offset)
        spread += np.where(weak, contact.width * np.linalg.norm(contact.unit, axis=1), _friction_offset(contact, friction))
    shift, rotation = _in_guide(press, motion, contacts)
    reversals = [reversal for contact in contacts for reversal in _reversals(motion, contact)]
    return SlidePlay(
        _press=press,
        motion=motion,
        clearance=FrozenMapping(widths),
        friction=FrozenMapping(dict(friction)),
        known_to=doubt,
        offset=np.sum(list(shares.values()), axis=0),
        by_bearing=FrozenMapping(shares),
        lowest=sure - spread,
        highest=sure + spread,
        undetermined=FrozenMapping(undetermined),
        shift=shift,
        rotation=rotation,
        reversals=Records(ForceReversal, [reversal for _, reversal in sorted(reversals, key=lambda pair: pair[0])]),
    )


# -------------------------------------------------------------------------------------------------------------------------- contacts


class Contact(NamedTuple):
    """A place where two links touch: a pin, a guide, or an end of a guide at ``height`` above the middle of the gibs.

    ``unit``: (n, 3) force per newton on the slide.
    """

    name: str
    bearing: str
    width: float
    unit: Array
    force: Array
    height: float = 0.0

    @property
    def direction(self) -> Array:
        """(n, 3) direction of the force; zero where the force is zero."""
        size = np.linalg.norm(self.force, axis=1)[:, None]
        return np.asarray(np.divide(self.force, size, out=np.zeros_like(self.force), where=size > 0))

    @property
    def offset(self) -> Array:
        """(n,) offset of the slide by this contact [m]."""
        return np.asarray(self.width * np.einsum("nk,nk->n", self.unit, self.direction))


def _friction_offset(contact: Contact, friction: Mapping[str, Friction]) -> Array:
    """(n,) largest further offset of the slide, because friction turns a pin's contact from the force by the angle of friction [m]."""
    law = friction.get(contact.bearing)
    sine = 0.0 if law is None or law.radius is None else min(law.coefficient, 1.0)
    across = np.linalg.norm(np.cross(contact.unit, contact.direction), axis=1)
    return np.asarray(contact.width * sine * across + (1.0 - math.sqrt(1.0 - sine * sine)) * np.abs(contact.offset))


def contacts_of(press: Linkage, unit: UnitForces, widths: Mapping[str, float | GuideClearance], reactions: Reactions) -> list[Contact]:
    """The contacts of all bearings with clearance under the forces of ``reactions``."""
    return [contact for name, width in widths.items() for contact in _contacts(press, unit, name, width, reactions)]


def _contacts(press: Linkage, unit: UnitForces, name: str, width: float | GuideClearance, reactions: Reactions) -> Iterator[Contact]:
    motion, force = unit.motion, in_plane(press, reactions.bearing_force[name])
    if not isinstance(width, GuideClearance):
        yield Contact(name, name, width, _radial(press, motion, name, unit.force[name]), _radial(press, motion, name, force))
        return
    _, across, normal, origin = _guide_axes(press, motion, name)
    both = (unit.force[name], unit.moment[name]), (force, reactions.bearing_moment[name])
    for end, height in (("upper end", 0.5 * width.length), ("lower end", -0.5 * width.length)):
        # The moment about the other end gives the force at this end.
        other = origin + width.middle - height
        pushed, pushing = (
            ((moment @ normal - other * np.einsum("nk,nk->n", force, across)) / (2 * height))[:, None] * across for force, moment in both
        )
        yield Contact(f"{name} {end}", name, width.across, pushed, pushing, height)


def _radial(press: Linkage, motion: Motion, name: str, force: Array) -> Array:
    """The part (n, 3) of a bearing's force that closes its clearance.

    The part along the axis of a pin in space is left out, because shoulders take it; so is the part along a guide, which does not resist.
    """
    k = press.bearings.index(name)
    in_space = len(press.engine().directions) == 3
    if k >= len(press.joints):
        loop = press.loops[k - len(press.joints)]
        if not in_space or loop.type != "revolute":
            return force
        along = rotation_of(press, motion.joint_position, loop.joint2) @ loop.rotation2[:, 0]
    elif press.axes[k].turns and not in_space:
        return force
    else:
        along = rotation_of(press, motion.joint_position, k + 1) @ press.axes[k].direction
    return np.asarray(force - np.einsum("nk,nk->n", force, along)[:, None] * along)


def _guide_axes(press: Linkage, motion: Motion, name: str) -> tuple[Array, Array, Array, float]:
    """The direction of a guide in a planar press (n, 3), the direction across it (n, 3), the normal (3,), and the offset along the guide
    from the joint frame's origin to the link's origin [m]. A positive turn about the normal moves the link's upper end across.
    """
    k = press.joints.index(name)
    normal = press.engine().turning_axes()[0]
    rotation = rotation_of(press, motion.joint_position, k + 1)
    if press.slide is not None and k == press.slide_guide.joint:
        along = np.broadcast_to(press.slide_direction, (len(motion.v), 3))
        origin = float(along[0] @ rotation[0] @ press.frame_of(press.slide).placement.translation)
    else:
        along, origin = np.asarray(rotation @ press.axes[k].direction), 0.0
    return along, np.cross(normal, along), normal, origin


def _in_guide(press: Linkage, motion: Motion, contacts: Sequence[Contact]) -> tuple[Array, Array]:
    """Displacement of the slide across its guide, and its rotation, (n, 3) each, world axes [m, rad]."""
    shift, rotation = np.zeros((len(motion.v), 3)), np.zeros((len(motion.v), 3))
    name = press.joints[press.slide_guide.joint]
    ends = [contact for contact in contacts if contact.bearing == name]
    for contact in ends:
        moved = -contact.width * contact.direction
        shift += moved / len(ends)
        if contact.height:
            along, *_ = _guide_axes(press, motion, name)
            rotation += np.cross(along, moved) * (0.5 / contact.height)
    return shift, rotation


def _reversals(motion: Motion, contact: Contact) -> Iterator[tuple[float, ForceReversal]]:
    """The reversals of a contact's force, with their positions as (fractional) state numbers."""
    first = motion.crank_angle.reshape(len(motion.v), -1)[:, 0]
    size = np.linalg.norm(contact.unit, axis=1)
    for k, share in crossings(motion, contact.unit, contact.force):
        after = (k + 1) % len(first)
        step = float(first[after] - first[k]) if after else float(first[1] - first[0])
        pressed = bool(np.dot(contact.force[after], contact.unit[after]) > 0)
        change = 2 * contact.width * float((1 - share) * size[k] + share * size[after])
        yield (
            k + share,
            ForceReversal(
                crank_angle=float(first[k] + share * step),
                bearing=contact.name,
                side="pressed" if pressed else "hanging",
                change=change if pressed else -change,
                force=float(np.linalg.norm((1 - share) * contact.force[k] + share * contact.force[after])),
            ),
        )


def crossings(motion: Motion, unit: Array, force: Array) -> list[tuple[int, float]]:
    """Where forces (n, 3) change their sign along the unit forces (n, 3): numbers of the states before, and shares of the steps.

    The force must change its sign along the unit forces of both states. If only the unit force reverses, the contact stays.
    """
    after = np.roll(np.arange(len(force)), -1)
    here, after_step = np.einsum("nk,nk->n", force, unit), np.einsum("nk,nk->n", force[after], unit)
    along_next = np.einsum("nk,nk->n", force, unit[after]) * np.einsum("nk,nk->n", force[after], unit[after])
    size = np.linalg.norm(unit, axis=1)
    crossing = (here * after_step < 0) & (along_next < 0) & (np.minimum(size, size[after]) > UNMOVED)
    if not is_cycle(motion):  # else the first state follows the last one
        crossing[-1] = False
    return [(k, float(here[k] / (here[k] - after_step[k]))) for k in map(int, np.flatnonzero(crossing))]


# --------------------------------------------------------------------------------------------------------------------------- checks


def _clearances(press: Linkage, given: Mapping[str, float | GuideClearance]) -> dict[str, float | GuideClearance]:
    """Name of a bearing -> its checked clearance."""
    if not given:
        raise PinpressError("clearance is empty: give a mapping, name of a bearing: radial clearance [m], e.g. {'W': 5e-5}")
    checked: dict[str, float | GuideClearance] = {}
    planar = len(press.engine().directions) == 2
    for name, width in given.items():
        if name not in press.bearings:
            raise UnknownNameError("bearing", name, press.bearings)
        k = press.bearings.index(name)
        joint = k < len(press.joints)
        if not joint and press.loops[k - len(press.joints)].type == "fixed":
            raise PinpressError(f"clearance of {shown(name)}: this joint is welded, so it has no clearance; leave it out")
        if not isinstance(width, GuideClearance):
            checked[name] = _width(f"clearance of {shown(name)}", width)
            continue
        if not joint or press.axes[k].turns:
            raise PinpressError(
                f"clearance of {shown(name)}: this bearing is a pin, not a guide; give its radial clearance as a number [m]"
            )
        if not planar:
            raise PinpressError(f"{press.name} is not planar: give the clearance of guide {shown(name)} as a number [m]")
        checked[name] = width
    return checked


def _refuse_open_moments(press: Linkage, widths: Mapping[str, float | GuideClearance], reactions: Reactions) -> None:
    """Raise PinpressError if a slide may tilt in a guide whose moment other points of the slide may take."""
    for name in (name for name, width in widths.items() if isinstance(width, GuideClearance)):
        normal = press.engine().turning_axes()[0]
        if np.any(reactions.indeterminate[name][3:] & (np.abs(reactions.indeterminate_axes @ normal) > 0.5)):
            raise PinpressError(
                f"clearance of {shown(name)}: rigid mechanics does not determine the moment of this guide, because several rods may hold"
                " the link against turning; give the clearance as a number [m]"
            )


def _width(what: str, value: object) -> float:
    """A radial clearance, or one on each side of a guide [m]."""
    width = number(what, value, "m", positive=True)
    if not width < 0.1:
        raise PinpressError(f"{what} is {width:g} m: give the radial clearance in m, e.g. 5e-5")
    if width > 2e-3:
        caution(f"{what} is {width:g} m ({1e3 * width:g} mm), larger than usual clearances. Is it {width:g} mm? Write {1e-3 * width:g}")
    return width
