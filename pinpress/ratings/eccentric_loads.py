"""Eccentric process forces: tilting moment of the slide, reaction of its guide, and the pressure on the gibs.

A gib of length L along the guide's axis and width b that carries a normal force N and a tilting moment M has the pressure
p = N / (L b) + 6 M / (L^2 b) at its end, with a linear distribution (Navier). Between two gibs without clearance this holds for an
eccentricity M / N of more than L / 6 too, because the opposite gib pushes where a single gib would have to pull. A single gib can only
push: beyond L / 6 it lifts off, contact remains over 3 (L / 2 - M / N), and the pressure rises to 2 N / (3 b (L / 2 - M / N)). Beyond L / 2
the slide tips.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common import tables
from ..common.arguments import number, positive, suitable_numbers, typed
from ..common.errors import PinpressError
from ..common.quantities import Array
from ..common.results import Tabular
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion
from ..kinematics.poses import point_on_body
from ..linkage.linkage import Linkage
from ..loads.link import PointForce
from .limits import largest_factor, without_masses

DIRECTION = 1e-9  # component along the guide that a gib's normal may have
ROUNDING = 1e-12  # forces below this share of the process force are rounding


@dataclass(frozen=True)
class Gibs:
    """A pair of gibs that guide a slide from opposite sides. The loaded length of the gibs moves with the slide.

    Attributes:
        length: length of a gib along the guide's axis [m].
        width: width of a gib across the axis [m].
        normal: (3,) direction in which the gibs face, in world axes; None: across the guide in the plane of a planar press.
        middle: middle of the gibs' length, above the slide link's origin along the guide's axis [m].
        one_sided: True: with clearance, so that only one gib is in contact and may lift off. False: two gibs without clearance.
        pressure: permissible pressure, for `pins` [Pa]; None: no limit.
        wear_rate: worn volume / (force x rubbing way), for `pins`, as in `PlainBearing` [1/Pa]; None: no wear is computed.

    Raises:
        PinpressError: a length, width or pressure is not positive, the normal is not a direction, or the middle is not a finite number.
    """

    length: float
    width: float
    normal: tuple[float, float, float] | None = None
    middle: float = 0.0
    one_sided: bool = False
    pressure: float | None = None
    wear_rate: float | None = None

    def __post_init__(self) -> None:
        for name, unit in (("length", "m"), ("width", "m"), ("pressure", "Pa")):
            if getattr(self, name) is not None or unit == "m":
                object.__setattr__(self, name, positive(f"the gibs' {name}", getattr(self, name), unit))
        if self.wear_rate is not None:
            object.__setattr__(self, "wear_rate", number("the gibs' wear_rate", self.wear_rate, "1/Pa", positive=True))
        suitable_numbers("the gibs' middle", self.middle, "a finite number [m]")
        if self.normal is not None:
            suitable_numbers("the gibs' normal", self.normal, "a direction of three finite numbers, e.g. (1, 0, 0)", (3,), np.any)


@dataclass(frozen=True, eq=False, repr=False)
class GuideReaction(Tabular):
    """Reaction of the slide's guide to an eccentric process force, in n states. All arrays are read-only.

    Attributes:
        guide: name of the slide's bearing in its guide.
        tilting_moment: (3,) moment of the process force on the slide about `Linkage.tool`, in world axes [N m].
        force: (n, 3) force of the guide on the slide, in world axes [N].
        moment: (n, 3) moment of the guide on the slide about the middle of the gibs, in world axes [N m].
        normal_force: (n,) component of the force along the gibs' normal [N].
        tilting: (n,) component of the moment about the axis across guide and normal, which tilts the slide between the gibs [N m].
        pressure: (n,) largest pressure on a gib [Pa].
        contact: (n,) share of the gibs' length that is in contact [-].
        indeterminate: whether rigid-body mechanics leaves the tilting moment undetermined, because parallel rods may share it with the
            guide.
    """

    guide: str
    tilting_moment: Array
    force: Array
    moment: Array
    normal_force: Array
    tilting: Array
    pressure: Array
    contact: Array
    indeterminate: bool

    @property
    def title(self) -> str:
        size = np.linalg.norm(self.tilting_moment)
        return f"GuideReaction in {self.guide}: tilting moment {size:.6g} N m, pressure on the gibs up to {self.pressure.max():.6g} Pa"

    def columns(self) -> dict[str, Array]:
        """A row for each state: force and moment of the guide, and the load on the gibs."""
        return {
            **tables.by_axis("force", "N", self.force),
            **tables.by_axis("moment", "N m", self.moment),
            "normal_force [N]": self.normal_force,
            "tilting [N m]": self.tilting,
            "pressure [Pa]": self.pressure,
            "contact [-]": self.contact,
        }


@typed
def eccentric_load(
    press: Linkage, motion: Motion, *, force: float, offset: Sequence[float], gibs: Gibs, engine: str = "auto"
) -> GuideReaction:
    """Compute guide reaction and gib pressure under an eccentric process force, without weights and inertia forces.

    Args:
        press: a press with a slide.
        motion: motion of n states at which the force acts, e.g. ``servo_cycle(press, speed=0.0, angle=[...])``.
        force: force on the slide along the guide's axis, against the working stroke [N].
        offset: (3,) offset of the force from `Linkage.tool`, in the slide link's axes [m]; a shift along the guide's axis has no effect.
        gibs: the gibs of the slide's guide.
        engine: as in `cycle`.

    Raises:
        PinpressError: the press has no slide, the gibs do not face across the guide, the slide tips because a single gib would have to
            pull, or an argument is not as described.
    """
    newtons = positive("force", force, "N")
    point = suitable_numbers("offset", offset, "three finite numbers, x, y, z", (3,))
    across = _across(press, gibs)
    name, axis = _slide_guide(press)
    found = _guide_reaction(press, motion, newtons * axis, point, gibs, engine)
    normal, tilting = found.force @ across[0], found.moment @ across[1]
    pressure, contact = gib_pressure(gibs, normal, tilting, motion)
    open_moments = found.reactions.indeterminate[name][3:]
    return GuideReaction(
        guide=name,
        tilting_moment=np.cross(_rotation(press) @ point, newtons * axis),
        force=found.force,
        moment=found.moment,
        normal_force=normal,
        tilting=tilting,
        pressure=pressure,
        contact=contact,
        indeterminate=bool(np.any(open_moments & (np.abs(found.reactions.indeterminate_axes @ across[1]) > DIRECTION))),
    )


@typed
def permissible_eccentricity(
    press: Linkage, motion: Motion, *, force: float, gibs: Gibs, pressure: float, engine: str = "auto"
) -> tuple[float, float]:
    """Find the largest offset of a process force from `Linkage.tool` at which the gibs keep a pressure in all states of a motion.

    Args:
        press: a press with a slide.
        motion: motion of n states at which the force acts.
        force: force on the slide along the guide's axis, against the working stroke [N].
        gibs: the gibs of the slide's guide.
        pressure: permissible pressure on the gibs [Pa].
        engine: as in `cycle`.

    Returns:
        Least and largest coordinate of the force along the gibs' normal, from `Linkage.tool`; the first is not positive [m]. Their
        magnitudes may differ, because the guide also carries the lateral force of the rod.

    Raises:
        PinpressError: as for `eccentric_load`, or the central force alone is too large (the message names the crank angle), or the guide
            carries no part of the tilting moment.
    """
    newtons, allowed = positive("force", force, "N"), positive("pressure", pressure, "Pa")
    normal, about = _across(press, gibs)
    _, axis = _slide_guide(press)
    local = _rotation(press).T @ normal  # an offset of 1 m
    central = _guide_reaction(press, motion, newtons * axis, np.zeros(3), gibs, engine)
    beside = _guide_reaction(press, motion, newtons * axis, local, gibs, engine)
    across = central.force @ normal
    most = _largest_moment(gibs, np.where(np.abs(across) > ROUNDING * newtons, across, 0.0), allowed)
    constant, slope = central.moment @ about, (beside.moment - central.moment) @ about
    worst = int(np.argmax(np.abs(constant) - most))
    if most[worst] <= 0 or abs(constant[worst]) > most[worst]:
        raise PinpressError(
            f"at {motion.place(worst)} the gibs permit no eccentricity of a force of {newtons:.6g} N: a central"
            " force alone reaches the pressure, or does not press on a single gib. Give larger gibs, less force, or two gibs without"
            " clearance"
        )
    right, left = (float(largest_factor(constant[:, None], way * slope[:, None], most).min()) for way in (1.0, -1.0))
    if not (math.isfinite(right) and math.isfinite(left)):
        raise PinpressError("the guide carries no part of the tilting moment, so its gibs do not limit the eccentricity")
    return -left, right


def _slide_guide(press: Linkage) -> tuple[str, Array]:
    """Name of the slide's bearing in its guide, and `Linkage.slide_direction`."""
    return press.joints[press.slide_guide.joint], press.slide_direction


def _rotation(press: Linkage) -> Array:
    """Rotation (3, 3) of the slide link's own frame in the world; it is constant, because the frame carries the guide."""
    frame = press.model.frames[press.model.getFrameId(press.slide, pin.BODY)]
    return np.asarray(press.model.jointPlacements[frame.parentJoint].rotation @ frame.placement.rotation)


def _across(press: Linkage, gibs: Gibs) -> tuple[Array, Array]:
    """The gibs' normal, and the axis about which the slide tilts between them, as unit vectors (3,) in world axes."""
    _, axis = _slide_guide(press)
    if gibs.normal is not None:
        normal = np.array(gibs.normal, dtype=float)
    else:
        refusal = f"{press.name} is not planar: give the direction in which the gibs face, Gibs(..., normal=(x, y, z))"
        normal = np.cross(press.plane_or_refuse(refusal).normal, axis)
        normal *= np.sign(normal[np.abs(normal).argmax()])
    normal = normal / np.abs(normal).max()  # so that nothing overflows
    normal = normal / np.linalg.norm(normal)
    if abs(normal @ axis) > DIRECTION:
        raise PinpressError(f"the gibs' normal {normal.tolist()} is not across the guide's axis {axis.tolist()}: gibs face across it")
    return normal, np.cross(axis, normal)


class _Reaction(NamedTuple):
    """Action of the guide on the slide, in world axes.

    Attributes:
        force: (n, 3) force on the slide [N].
        moment: (n, 3) moment on the slide about the middle of the gibs [N m].
        reactions: the reactions of the press.
    """

    force: Array
    moment: Array
    reactions: Reactions


def _guide_reaction(press: Linkage, motion: Motion, force: Array, offset: Array, gibs: Gibs, engine: str) -> _Reaction:
    """Action of the guide under a force (3,) in world axes, with an offset (3,) from `Linkage.tool` in the slide's axes."""
    slide = str(press.slide)
    x, y, z = (press.tool.point + offset).tolist()
    joint, _ = point_on_body(press, slide, (x, y, z), "the process force", "offset")
    name, axis = _slide_guide(press)
    load = PointForce(slide, force, (x, y, z))
    found = inverse_dynamics(without_masses(press), motion, [load], engine=engine, bearings=(name,))
    # The moment is about the joint frame's origin, which moves with the slide.
    frame = press.model.frames[press.model.getFrameId(slide, pin.BODY)]
    middle = press.model.jointPlacements[joint].rotation @ frame.placement.translation + gibs.middle * axis
    reaction = np.array(found.bearing_force[name])
    moment = found.bearing_moment[name] - np.cross(middle, reaction)
    return _Reaction(reaction, moment, found)


def gib_pressure(gibs: Gibs, normal: Array, tilting: Array, motion: Motion) -> tuple[Array, Array]:
    """Largest pressure on a gib (n,) [Pa], and share of the length in contact (n,)."""
    n, m, area = np.abs(normal), np.abs(tilting), gibs.length * gibs.width
    linear = n / area + 6 * m / (area * gibs.length)
    if not gibs.one_sided:
        return linear, np.ones_like(n)
    tips = m >= 0.5 * gibs.length * n
    if np.any(tips & (m > 0)):
        raise PinpressError(
            f"the slide tips at {motion.place(int(np.argmax(tips & (m > 0))))}: the force on the gib acts beyond its end. Give longer gibs,"
            " less eccentricity, or two gibs without clearance (one_sided=False)"
        )
    lifted = m > n * gibs.length / 6
    held = np.where(lifted, 3 * (0.5 * gibs.length * n - m), gibs.length * n)  # contact length times force
    with np.errstate(all="ignore"):  # no force, no pressure
        return np.where(lifted, 2 * n**2 / (gibs.width * held), linear), np.where(n > 0, held / (n * gibs.length), 1.0)


def _largest_moment(gibs: Gibs, normal: Array, pressure: float) -> Array:
    """Tilting moment (n,) at which a gib reaches a pressure under normal forces (n,); negative if these alone exceed it [N m]."""
    n, area = np.abs(normal), gibs.length * gibs.width
    linear = (pressure - n / area) * area * gibs.length / 6
    if not gibs.one_sided:
        return linear
    return np.where(linear > n * gibs.length / 6, n * (0.5 * gibs.length - 2 * n / (3 * gibs.width * pressure)), linear)
