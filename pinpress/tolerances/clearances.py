"""Where the slide stands in the clearances of its bearings over the turn.

    play = tolerances.play(press, pp.cycle(press, 70 * pp.RPM), {"E": 50e-6, "F": 50e-6}, loads=[...])
    play.offset, play.reversals, play.bottom_shift

A bearing with the radial clearance c is pressed together by its force F, parent on child: the child lies -c F/|F| off the parent. By
virtual work, with the force f in the bearing per newton on the slide (see `virtual_work`), the slide stands

    z = sum of c f . F / |F|

above its place without clearances. A bearing that the slide presses on through the linkage (f . F > 0) lifts it by up to c |f|, one that
it hangs from lowers it by as much; where a force reverses, the slide moves through twice that. The formula is of first order in the
clearances. It is that of contact without separation: the forces are those of the rigid press. Impacts and rattling are another model, see
`elasticity.Elastic(clearances=...)`.

A force that reverses passes through small values, where its direction, and so the side on which the bearing lies, hangs on how well
masses and loads are known. A bearing counts as undetermined where its force is smaller than a share `known_to` of the sum of the sizes of
its parts, by weight, inertia and each load: with parts known to 5 % their sum may then point any way. There the slide stands somewhere in
a band of c |f| to both sides.

With friction the forces are those of `inverse_dynamics` under friction, which is one more part that is known to such a share. In a dry pin
the contact itself leans from the force by the angle of friction, with the sine mu, ahead or behind depending on which of the two links
carries the pin. That is not known here: the band holds both.

The slide's guide is one more bearing, in which forces across it decide. A guide of some length has two ends. With the force N across it
and the moment M they carry N/2 + M/L and N/2 - M/L: where both have one sign the slide lies flat on a gib, else it stands askew, by
2 c / L.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common import tables
from ..common.arguments import number, typed
from ..common.errors import PinpressError, UnknownNameError, caution, shown
from ..common.frozen import FrozenMapping
from ..common.parameters import parameter
from ..common.quantities import Array
from ..common.results import Record, Records, Tabular
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion
from ..kinematics.poses import rotation_of
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Friction, Load
from .virtual_work import UnitForces, forces_by_cause, in_plane, unit_forces

KNOWN_TO = 0.05  # share to which masses and loads are known, by default
WIDEST = 2e-3  # radial clearance above which it is hardly meant [m]
ROUNDING = 1e-9  # share of the largest bearing force of a state below which a force is rounding
UNMOVED = 1e-6  # force in a bearing per newton on the slide below which the bearing is not between drive and slide


@dataclass(frozen=True)
class GuideClearance:
    """The clearance of a guide of some length, in which the slide may stand askew.

    Attributes:
        across: clearance on each side, half of that between both gibs [m].
        length: length of the gibs that guide the sliding link, along the guide; it moves with the link [m].
        middle: middle of this length above the origin of the sliding link, along `Linkage.slide_direction` for the slide, else along the
            guide's axis [m].
    """

    across: float = field(metadata=parameter("m", "positive"))
    length: float = field(metadata=parameter("m", "positive"))
    middle: float = field(default=0.0, metadata=parameter("m"))

    def __post_init__(self) -> None:
        _width("GuideClearance: across", self.across)
        number("GuideClearance: length", self.length, "m", positive=True)
        number("GuideClearance: middle", self.middle, "m")
        if not self.length > 10 * self.across:
            raise PinpressError(
                f"GuideClearance: length is {self.length:g} m with a clearance of {self.across:g} m across: give both in m, the length of"
                " the gibs and the clearance on each side"
            )


@dataclass(frozen=True, repr=False)
class ForceReversal(Record, units={"crank_angle": "rad", "change": "m", "force": "N"}):
    """A bearing in which the force reverses, so that the slide moves through its clearance.

    Attributes:
        crank_angle: where the force is across the direction in which it would move the slide, between two states by a straight line; of a
            driver that slides its position [m].
        bearing: name of the bearing, with the end of a guide that has two.
        side: "pressed" where the slide presses on the bearing from here on, "hanging" where it hangs from it.
        change: by how much the slide moves, at once or over some degrees, 2 c |f|; positive upwards [m].
        force: what is left of the force there, across [N]. It is small where the journal knocks, and large where it rolls around.
    """

    crank_angle: float
    bearing: str
    side: str
    change: float
    force: float


@dataclass(frozen=True, eq=False, repr=False)
class SlidePlay(OfPress, Tabular):
    """Where the slide stands in the clearances of the bearings, in the n states of a motion. All arrays are read-only.

    Offsets are those from the slide's place without clearances, positive along `Linkage.slide_direction` (upwards).

    Attributes:
        press_name: name of the press.
        motion: the motion.
        clearance: the clearances as they were given.
        friction: the friction of bearings and guides as it was given.
        known_to: share to which masses, loads and friction are known.
        offset: (n,) offset of the slide along its guide [m].
        by_bearing: name of a bearing -> (n,) its share of the offset [m].
        lowest: (n,) lowest offset, with every undetermined bearing on the side where the slide is low, and contacts of pins with friction
            leaning to the side where it is [m].
        highest: (n,) highest offset, likewise [m].
        undetermined: name of a bearing -> (n,) bool, whether its force is too small to tell on which side it lies.
        shift: (n, 3) displacement of the slide across its guide at the middle of the gibs, in world axes [m]; zero without clearance there.
        rotation: (n, 3) rotation of the slide between the ends of its gibs, as a vector in world axes [rad].
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
        """Lowest place of the slide in its clearances less that without them [m]."""
        return float((self.motion.slide_position + self.offset).min() - self.motion.slide_position.min())

    @cached_property
    def bottom_band(self) -> tuple[float, float]:
        """Lowest and highest value that `bottom_shift` may have [m]."""
        rigid = self.motion.slide_position
        return tuple(float((rigid + edge).min() - rigid.min()) for edge in (self.lowest, self.highest))  # type: ignore[return-value]

    @cached_property
    def top_shift(self) -> float:
        """Highest place of the slide in its clearances less that without them [m]."""
        return float((self.motion.slide_position + self.offset).max() - self.motion.slide_position.max())

    @property
    def title(self) -> str:
        low, high = self.offset.min(), self.offset.max()
        return f"SlidePlay of {self.press_name}: {len(self.offset)} states, slide {low:+.4g} to {high:+.4g} m off in its clearances"

    def __str__(self) -> str:
        low, high = self.bottom_band
        lines = [
            f"{self.press_name}: the slide in the clearances of {', '.join(self.clearance)}",
            tables.entry("bottom dead centre", f"{1e3 * self.bottom_shift:+.4f}", "mm", f"{1e3 * low:+.4f} to {1e3 * high:+.4f} mm"),
            tables.entry("top dead centre", f"{1e3 * self.top_shift:+.4f}", "mm"),
        ]
        if not self.reversals:
            return "\n".join([*lines, "  no force reverses: the slide stays on one side of its clearances"])
        first, forces = self.motion.driver_coordinates[0], tables.scale("N", [each.force for each in self.reversals])
        rows = [
            [
                f"{each.bearing} {each.side}",
                first.shown(each.crank_angle, ".1f"),
                f"{1e3 * each.change:+.4f} mm",
                f"{forces.shown(each.force)} {forces.unit} left",
            ]
            for each in self.reversals
        ]
        return "\n".join([*lines, "  forces reverse:", *tables.fitted(rows, "    ")])

    @property
    def _pictured(self) -> tuple[str, ...]:
        return self.motion._pictured[0], "offset [m]", "lowest [m]", "highest [m]"

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
    """Find where the slide stands in the clearances of its bearings over a motion, and where forces reverse.

    Args:
        press: a press with a slide, in a plane or in space; its drivers are held at their positions.
        motion: a motion of this press, from `cycle`, `servo_cycle` or a run.
        clearance: name of a bearing -> radial clearance, half of the difference of the diameters [m]; of a guide the clearance on each
            side, or a `GuideClearance` if the slide may stand askew.
        loads: loads on the press, as for `inverse_dynamics`; a balance cylinder too.
        friction: of bearings and guides, as for `inverse_dynamics`; at standstill it has no direction, and none acts.
        known_to: share to which masses, loads and friction are known. A bearing whose force is smaller than this share of the sum of its
            parts counts as undetermined.

    Raises:
        UnknownNameError: the press has no such bearing.
        PinpressError: no clearance, or one that is not positive; a bearing that cannot have one, or not of this kind; a guide whose moment
            rigid mechanics leaves open; the press has no slide; a share out of range; as `inverse_dynamics`.
    """
    doubt = number("known_to", known_to, "-")
    if not 0.0 <= doubt < 1.0:
        raise PinpressError(f"known_to is {doubt:g}: give a share from 0 to below 1, 0.05 where masses and loads are known to 5 %")
    widths = _clearances(press, clearance)
    without = inverse_dynamics(press, motion, loads)
    reactions = inverse_dynamics(press, motion, loads, friction) if friction else without
    _refuse_open_moments(press, widths, reactions)
    unit = unit_forces(press, motion, without)
    rest, moving = forces_by_cause(press, motion, loads)
    contacts = [each for name in widths for each in contacts_of(press, unit, name, widths[name], reactions)]
    causes = [
        [each.force for name in widths for each in contacts_of(press, unit, name, widths[name], found)]
        for found in (rest, without, *moving)
    ]
    size = ROUNDING * np.max([np.linalg.norm(force, axis=1) for force in reactions.bearing_force.values()], axis=0)
    shares = {name: np.zeros(len(motion.v)) for name in widths}
    open_, spread = {name: np.zeros(len(motion.v), bool) for name in widths}, np.zeros(len(motion.v))
    sure = np.zeros(len(motion.v))
    for k, contact in enumerate(contacts):
        weight, together, unloaded, *loaded = (cause[k] for cause in causes)
        parts = [weight, unloaded - weight, *(force - unloaded for force in loaded), contact.force - together]
        weak = np.linalg.norm(contact.force, axis=1) <= doubt * sum(np.linalg.norm(part, axis=1) for part in parts) + size
        offset = contact.offset
        shares[contact.bearing] += offset
        open_[contact.bearing] |= weak
        sure += np.where(weak, 0.0, offset)
        spread += np.where(weak, contact.width * np.linalg.norm(contact.unit, axis=1), _leaning(contact, friction))
    shift, rotation = _in_guide(press, motion, contacts, widths)
    reversals = [found for contact in contacts for found in _reversals(motion, contact)]
    return SlidePlay(
        _press=press,
        motion=motion,
        clearance=FrozenMapping(dict(clearance)),
        friction=FrozenMapping(dict(friction)),
        known_to=doubt,
        offset=np.sum(list(shares.values()), axis=0),
        by_bearing=FrozenMapping(shares),
        lowest=sure - spread,
        highest=sure + spread,
        undetermined=FrozenMapping(open_),
        shift=shift,
        rotation=rotation,
        reversals=Records(ForceReversal, [each for _, each in sorted(reversals, key=lambda pair: pair[0])]),
    )


# -------------------------------------------------------------------------------------------------------------------------- contacts


class Contact(NamedTuple):
    """A place where two links touch: a pin, a guide, or one end of a guide.

    Attributes:
        name: for messages and tables.
        bearing: name of its bearing.
        width: radial clearance [m].
        unit: (n, 3) force by newton on the slide [-].
        force: (n, 3) force, parent on child [N].
        height: place of an end above the middle of the gibs [m].
    """

    name: str
    bearing: str
    width: float
    unit: Array
    force: Array
    height: float = 0.0

    @property
    def direction(self) -> Array:
        """(n, 3) direction of the force, zero where there is none."""
        size = np.linalg.norm(self.force, axis=1)[:, None]
        return np.asarray(np.divide(self.force, size, out=np.zeros_like(self.force), where=size > 0))

    @property
    def offset(self) -> Array:
        """(n,) offset of the slide by this contact [m]."""
        return np.asarray(self.width * np.einsum("nk,nk->n", self.unit, self.direction))


def _leaning(contact: Contact, friction: Mapping[str, Friction]) -> Array:
    """(n,) by how much the contact of a pin moves the slide at most, where it leans from the force by the angle of friction [m]."""
    law = friction.get(contact.bearing)
    sine = 0.0 if law is None or law.radius is None else min(law.coefficient, 1.0)
    across = np.linalg.norm(np.cross(contact.unit, contact.direction), axis=1)
    return np.asarray(contact.width * sine * across + (1.0 - math.sqrt(1.0 - sine * sine)) * np.abs(contact.offset))


def contacts_of(press: Linkage, unit: UnitForces, name: str, width: float | GuideClearance, reactions: Reactions) -> Iterator[Contact]:
    """The contacts of a bearing with clearance under the forces of ``reactions``."""
    motion, force = unit.motion, in_plane(press, reactions.bearing_force[name])
    if not isinstance(width, GuideClearance):
        yield Contact(name, name, width, _radial(press, motion, name, unit.force[name]), _radial(press, motion, name, force))
        return
    _, across, normal, origin = _guide_axes(press, motion, name)
    middle = origin + width.middle
    for end, side in (("upper end", 1.0), ("lower end", -1.0)):
        other = middle - 0.5 * side * width.length
        ends = [
            side / width.length * (np.einsum("nk,k->n", moment, normal) - other * np.einsum("nk,nk->n", pushed, across))[:, None] * across
            for pushed, moment in ((unit.force[name], unit.moment[name]), (force, reactions.bearing_moment[name]))
        ]
        yield Contact(f"{name} {end}", name, width.across, ends[0], ends[1], 0.5 * side * width.length)


def _radial(press: Linkage, motion: Motion, name: str, force: Array) -> Array:
    """The part (n, 3) of a bearing's force that closes its clearance: without that along the axis of a pin in space, which shoulders
    take, and along a guide, where nothing holds."""
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
    """Of a guide in a planar press: its direction (n, 3), that across it (n, 3), the normal (3,) about which a link turns positively
    with its upper end moving across, and the place of the link's origin along the guide from that of its joint's frame [m]."""
    k = press.joints.index(name)
    normal = press.engine().turning_axes()[0]
    rotation = rotation_of(press, motion.joint_position, k + 1)
    if press.slide is not None and k == press.slide_guide.joint:
        along = np.broadcast_to(press.slide_direction, (len(motion.v), 3))
        place = press.model.frames[press.model.getFrameId(press.slide, pin.BODY)].placement.translation
        origin = float(along[0] @ rotation[0] @ place)
    else:
        along, origin = np.asarray(rotation @ press.axes[k].direction), 0.0
    return along, np.cross(normal, along), normal, origin


def _in_guide(
    press: Linkage, motion: Motion, contacts: Sequence[Contact], widths: Mapping[str, float | GuideClearance]
) -> tuple[Array, Array]:
    """Displacement of the slide across its guide and its rotation in it, (n, 3) each, world axes [m, rad]."""
    shift, rotation = np.zeros((len(motion.v), 3)), np.zeros((len(motion.v), 3))
    name = press.joints[press.slide_guide.joint]
    mine = [contact for contact in contacts if contact.bearing == name]
    for contact in mine:
        moved = -contact.width * contact.direction
        shift += moved / len(mine)
        if contact.height:
            along, _, _, _ = _guide_axes(press, motion, name)
            rotation += np.cross(along, moved) * (0.5 / contact.height)
    return shift, rotation


def _reversals(motion: Motion, contact: Contact) -> Iterator[tuple[float, ForceReversal]]:
    """The reversals of a contact's force, each with its place among the numbers of the states."""
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
    """Where forces (n, 3) pass to the other side along the unit forces (n, 3): numbers of the states before, and shares of the steps.

    The force must change its sign along the unit forces of both states. Where only the unit force turns back the contact stays.
    """
    after = np.roll(np.arange(len(force)), -1)
    here, there = np.einsum("nk,nk->n", force, unit), np.einsum("nk,nk->n", force[after], unit)
    along_next = np.einsum("nk,nk->n", force, unit[after]) * np.einsum("nk,nk->n", force[after], unit[after])
    size = np.linalg.norm(unit, axis=1)
    crossing = (here * there < 0) & (along_next < 0) & (np.minimum(size, size[after]) > UNMOVED)
    if not _whole(motion):
        crossing[-1] = False
    return [(k, float(here[k] / (here[k] - there[k]))) for k in map(int, np.flatnonzero(crossing))]


def _whole(motion: Motion) -> bool:
    """Whether the first state follows the last one: the states are even steps over a period whose end is left out, as of `cycle`."""
    if motion.period_turns is None or motion.crank_angle.ndim > 1 or len(motion.v) < 2:
        return False
    steps = np.diff(motion.crank_angle)
    return bool(np.allclose(steps, steps[0]) and np.isclose(abs(steps[0]) * len(motion.v), 2 * np.pi * motion.period_turns))


# --------------------------------------------------------------------------------------------------------------------------- checks


def _clearances(press: Linkage, given: Mapping[str, float | GuideClearance]) -> dict[str, float | GuideClearance]:
    """The clearances of a press by the names of its bearings, checked."""
    if not given:
        raise PinpressError("clearance is empty: give a mapping, name of a bearing: radial clearance [m], such as {'W': 5e-5}")
    found: dict[str, float | GuideClearance] = {}
    planar = len(press.engine().directions) == 2
    for name, width in given.items():
        if name not in press.bearings:
            raise UnknownNameError("bearing", name, press.bearings)
        k = press.bearings.index(name)
        joint = k < len(press.joints)
        if not joint and press.loops[k - len(press.joints)].type == "fixed":
            raise PinpressError(f"clearance of {shown(name)}: it is welded and has none; leave it out")
        if isinstance(width, GuideClearance):
            if not joint or press.axes[k].turns:
                raise PinpressError(f"clearance of {shown(name)}: it is a pin, no guide; give its radial clearance as a number [m]")
            if not planar:
                raise PinpressError(f"{press.name} is not planar: give the clearance of guide {shown(name)} as a number [m]")
            found[name] = width
        else:
            found[name] = _width(f"clearance of {shown(name)}", width)
    return found


def _refuse_open_moments(press: Linkage, widths: Mapping[str, float | GuideClearance], reactions: Reactions) -> None:
    """Raise PinpressError where a guide is to stand askew by a moment that points of the slide may take in its place."""
    for name in (name for name, width in widths.items() if isinstance(width, GuideClearance)):
        normal = press.engine().turning_axes()[0]
        if np.any(reactions.indeterminate[name][3:] & (np.abs(reactions.indeterminate_axes @ normal) > 0.5)):
            raise PinpressError(
                f"clearance of {shown(name)}: rigid mechanics leaves the moment of this guide open, because several rods may hold the link"
                " against turning; give the clearance as a number [m]"
            )


def _width(what: str, value: object) -> float:
    """A radial clearance, or one on each side of a guide [m]."""
    width = number(what, value, "m", positive=True)
    if not width < 0.1:
        raise PinpressError(f"{what} is {width:g} m: give the radial clearance in m, such as 5e-5")
    if width > WIDEST:
        caution(f"{what} is {width:g} m, {1e3 * width:g} mm: give it in m, {1e-3 * width:g} if mm are meant")
    return width
