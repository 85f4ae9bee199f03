"""The single surfaces of a slide's guide: the force on each surface, with preload or clearance, and the tilt of the slide.

A surface of length L along the guide is a Winkler foundation on its middle line, with the stiffness k / L per metre. It pushes where it is
compressed and never pulls. The slide is rigid; it moves by u across its guide and by the small rotation w. Let p be the middle of a surface
from the slide's origin, and n the direction in which the slide presses on it. At the place s along the guide's axis a, the line is
compressed by

    d(s) = preload / k - clearance + n . (u + w x (p + s a))

and carries N = integral of k / L max(d, 0) ds. The slide takes the position of least energy: the sum of k / (2 L) integrals of max(d, 0)^2,
less the work of the force and moment of the slide on its guide. This energy is convex, so the forces are unique. Newton's method minimises
it, and so decides which part of which surface is in contact. A single surface under an eccentricity of more than L / 6 lifts off at one
end, as in `ratings.eccentric_load`. Two opposite surfaces under a force through their middle act as a `PreloadedJoint`.

Zhang (thesis, 2007, section 2.1) describes an eight-way slide guide, but gives no numbers for it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common import plausibility, tables
from ..common.arguments import LARGEST, number, positive, suitable_numbers, typed
from ..common.errors import PinpressError, caution, cautions_collected, shown
from ..common.frozen import Frozen, FrozenMapping, read_only
from ..common.quantities import Array
from ..common.results import Record, Records, Tabular
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion, refuse_motion_of_another
from ..kinematics.poses import point_on_body
from ..linkage.linkage import Linkage, OfPress
from ..simulation.elastic.preloaded_joint import FAINT, STIFFEST

WIDEST = 2e-3  # clearance of a surface above which it is probably in mm [m]
ACROSS = 1e-9  # component along the guide that the normal of a surface may have
HELD = 1e-9  # centring springs, as a share of the surfaces' stiffness, for a slide that floats in its clearances
LEFT = 1e-6  # if the centring springs take a larger share of the load, the surfaces do not hold the slide
STEPS, HALVES = 200, 40  # most steps of Newton's method, and most halvings of a step
SETTLED = 1e-11  # largest residual, as a share of the forces
ROUNDED = 1e-13  # the energy may rise by this share because of rounding errors


@dataclass(frozen=True)
class GuideSurface(Frozen):
    """One surface of a guide, on which the slide presses. It moves with the slide.

    Attributes:
        name: of the surface.
        point: (3,) middle of the surface, from the slide link's origin, in world axes [m].
        normal: (3,) direction in which the slide presses on it, across the guide's axis, in world axes.
        length: length along the guide [m].
        width: width across the guide [m].
        stiffness: stiffness of the whole surface, with its gib and the gib's screws [N/m].
        preload: force of the surface on the slide in its nominal position [N].
        clearance: gap between the surface and the slide in its nominal position [m]; 0 with preload.

    Raises:
        PinpressError: a number is not as described, or there are both preload and clearance.

    Warns:
        PinpressWarning: a preload is below 1 kN, or a clearance is above 2 mm: the unit may be wrong.
    """

    name: str
    point: tuple[float, float, float]
    normal: tuple[float, float, float]
    length: float
    width: float
    stiffness: float
    preload: float = 0.0
    clearance: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.name, str) or not self.name:
            raise PinpressError(f"GuideSurface: name is {shown(self.name)}: give each surface a name of its own")
        what = f"GuideSurface {self.name!r}"
        suitable_numbers(f"{what}: point", self.point, "three finite numbers, x, y, z [m]", (3,))
        suitable_numbers(f"{what}: normal", self.normal, "a direction of three finite numbers, e.g. (1, 0, 0)", (3,), np.any)
        for name, unit in (("length", "m"), ("width", "m"), ("stiffness", "N/m")):
            value = positive(f"{what}: {name}", getattr(self, name), unit, STIFFEST if name == "stiffness" else 1e3)
            object.__setattr__(self, name, value)
        for name, unit in (("preload", "N"), ("clearance", "m")):
            object.__setattr__(self, name, number(f"{what}: {name}", getattr(self, name), unit))
            if getattr(self, name) < 0:
                raise PinpressError(f"{what}: {name} is {getattr(self, name):g}; give a number that is not negative [{unit}]")
        if self.preload and self.clearance:
            raise PinpressError(f"{what}: it has a preload and a clearance; a surface that presses has no clearance: give one of them")
        _caution_units(what, self.preload, self.clearance)


@typed
def eight_way_guide(
    *,
    facing_x: Sequence[float],
    facing_y: Sequence[float],
    length: float,
    width: float,
    stiffness: float,
    preload: float = 0.0,
    clearance: float = 0.0,
    middle: float = 0.0,
) -> tuple[GuideSurface, ...]:
    """The eight equal surfaces of an upright slide that is guided in two directions at each of its four corners.

    Their names are corner and direction, such as "left front x": left is -x, front is -y. For other guides give a list of `GuideSurface`;
    ``dataclasses.replace`` changes a single surface.

    Args:
        facing_x: half distances along x and y between the middles of the surfaces on which the slide presses along x [m].
        facing_y: half distances along x and y between the middles of the surfaces on which the slide presses along y [m].
        length: length of each surface along the guide [m].
        width: width of each surface across the guide [m].
        stiffness: stiffness of each surface [N/m].
        preload: preload of each surface [N].
        clearance: clearance of each surface [m].
        middle: middle of the surfaces' length, above the slide link's origin [m].

    Raises:
        PinpressError: as `GuideSurface`.

    Warns:
        PinpressWarning: as `GuideSurface`, once for all eight surfaces.
    """
    surfaces, height = [], number("middle", middle, "m")
    for axis, (name, given) in enumerate((("facing_x", facing_x), ("facing_y", facing_y))):
        x, y = suitable_numbers(name, given, "two positive numbers, half distances along x and y [m]", (2,), lambda both: np.all(both > 0))
        for side, right in (("left", -1.0), ("right", 1.0)):
            for end, back in (("front", -1.0), ("back", 1.0)):
                normal = (right, 0.0, 0.0) if axis == 0 else (0.0, back, 0.0)
                point = (right * float(x), back * float(y), height)
                label = f"{side} {end} {'xy'[axis]}"
                with cautions_collected():  # one warning for all eight surfaces is given below
                    surfaces.append(GuideSurface(label, point, normal, length, width, stiffness, preload, clearance))
    _caution_units("eight_way_guide", surfaces[0].preload, surfaces[0].clearance)
    return tuple(surfaces)


def _caution_units(what: str, preload: float, clearance: float) -> None:
    """Warn if the unit of a surface's preload [N] or clearance [m] is probably wrong."""
    if 0 < preload < FAINT:
        caution(f"{what}: preload is {preload:g} N: if kN are meant, write {preload:g}e3")
    if clearance > WIDEST:
        caution(f"{what}: clearance is {clearance:g} m: if mm are meant, write {clearance:g}e-3")


@dataclass(frozen=True, repr=False)
class OpenSurface(Record, units={"begins": "rad", "ends": "rad", "least_contact": "-"}):
    """A part of a motion in which a surface is not in contact along its whole length.

    Attributes:
        surface: name of the surface.
        begins: crank angle of the first such state [rad]; position of a sliding driver [m].
        ends: crank angle of the last such state [rad]; position of a sliding driver [m].
        least_contact: smallest share of the surface's length in contact; 0: no contact.
    """

    surface: str
    begins: float
    ends: float
    least_contact: float


@dataclass(frozen=True, eq=False, repr=False)
class LoadedGuide(OfPress, Tabular):
    """The surfaces of a slide's guide in the n states of a motion. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        motion: the motion.
        surfaces: the surfaces.
        force: name of a surface -> (n,) force with which it presses on the slide, against its normal [N].
        pressure: name of a surface -> (n,) largest pressure on it [Pa].
        contact: name of a surface -> (n,) share of its length in contact [-].
        shift: (n, 3) displacement of the slide link's origin across the guide, in world axes [m].
        rotation: (n, 3) rotation vector of the slide in world axes [rad]; its components across the guide's axis are the tilt.
        guide_force: (n, 3) force of the guide on the slide across its axis, in world axes [N].
        guide_moment: (n, 3) moment of the guide on the slide about the slide link's origin, in world axes [N m].
        opened: parts of the motion in which a surface is not in contact along its whole length, in the order of the surfaces.
    """

    _press: Linkage
    motion: Motion
    surfaces: tuple[GuideSurface, ...]
    force: Mapping[str, Array]
    pressure: Mapping[str, Array]
    contact: Mapping[str, Array]
    shift: Array
    rotation: Array
    guide_force: Array
    guide_moment: Array
    opened: Records[OpenSurface] = field(repr=False)

    @property
    def title(self) -> str:
        hardest = max(self.force, key=lambda name: float(self.force[name].max()))
        tilt, most = 1e6 * np.linalg.norm(self.rotation, axis=1).max(), float(self.force[hardest].max())
        pressure = max(float(values.max()) for values in self.pressure.values())
        return (
            f"LoadedGuide of {self.press_name}: up to {most:.6g} N on {hardest}, {1e-6 * pressure:.4g} MPa, slide turned by up to"
            f" {tilt:.4g} microradians, {len(self.opened)} times not in full touch"
        )

    def columns(self) -> dict[str, Array]:
        """A row for each state: crank angle; force, pressure and contact share of each surface; position of the slide; force and moment of
        the guide."""
        columns = {"{} [{}]".format(*self.motion.driver_coordinates[0].heads[0]): self.motion.crank_angle}
        columns |= {f"force_{name} [N]": values for name, values in self.force.items()}
        columns |= {f"pressure_{name} [Pa]": values for name, values in self.pressure.items()}
        columns |= {f"contact_{name} [-]": values for name, values in self.contact.items()}
        columns |= tables.by_axis("shift", "m", self.shift) | tables.by_axis("rotation", "rad", self.rotation)
        return columns | tables.by_axis("guide_force", "N", self.guide_force) | tables.by_axis("guide_moment", "N m", self.guide_moment)


@typed
def guide_contact(
    press: Linkage, reactions: Reactions, surfaces: Sequence[GuideSurface], *, offset: Sequence[float] = (0.0, 0.0, 0.0)
) -> LoadedGuide:
    """Find how the surfaces of the slide's guide share its force and moments.

    The forces of the guide are those of the rigid press. In a planar press the links carry no moments out of the plane, so the guide
    carries them all.

    Args:
        press: a press with a slide whose guide the frame carries.
        reactions: reactions from `inverse_dynamics` of this press, with all loads; give forces off the slide's axis as `PointForce`.
        surfaces: surfaces of the slide's guide, e.g. from `eight_way_guide`.
        offset: (3,) offset of the process loads from `Linkage.tool`, in world axes [m].

    Raises:
        PinpressError: the press has no slide, a surface does not face across its guide, the reactions are of a press with other joints or
            lengths, the surfaces do not hold the slide, or parallel rods share moments with the guide (statically indeterminate).

    Warns:
        PinpressWarning: a surface or the offset is so far away that its unit may be mm.
    """
    surfaces = tuple(surfaces)
    across, shift = _checked(press, surfaces), suitable_numbers("offset", offset, "three finite numbers, x, y, z [m]", (3,))
    refuse_motion_of_another(press, reactions.motion)
    plausibility.point("guide_contact: offset", shift, press.size)
    if np.abs(shift).max() > LARGEST:
        raise PinpressError(f"guide_contact: offset is {shown(offset)} m; give numbers of at most {LARGEST:g} m")
    force, moment = _on_guide(press, reactions, shift)
    bed = _Bed.of(surfaces, across, press.slide_direction)
    load = np.column_stack([-force @ across.T, -moment])  # action of the slide on its guide
    places = _settled(bed, load, reactions.motion, press.name)
    touching = bed.touching(places)
    names = [surface.name for surface in surfaces]
    ends = np.maximum(
        np.stack([touching.middle - 0.5 * bed.length * touching.slope, touching.middle + 0.5 * bed.length * touching.slope]), 0
    )
    pressure = ends.max(axis=0) * bed.stiffness / (bed.length * np.array([surface.width for surface in surfaces]))
    contact = (touching.high - touching.low) / bed.length
    carried = bed.forces(places)
    return LoadedGuide(
        _press=press,
        motion=reactions.motion,
        surfaces=surfaces,
        force=_by_name(names, carried),
        pressure=_by_name(names, pressure),
        contact=_by_name(names, contact),
        shift=read_only(places[:, :2] @ across),
        rotation=read_only(places[:, 2:].copy()),
        guide_force=read_only(force @ across.T @ across),
        guide_moment=read_only(moment),
        opened=Records(OpenSurface, _open_stretches(names, contact, reactions.motion.crank_angle)),
    )


def _checked(press: Linkage, surfaces: Sequence[GuideSurface]) -> Array:
    """Two directions (2, 3) across the slide's guide."""
    axis = press.slide_direction
    if not surfaces or not all(isinstance(surface, GuideSurface) for surface in surfaces):
        raise PinpressError(f"surfaces is {shown(surfaces)}: give a list of GuideSurface, such as eight_way_guide(...)")
    names = [surface.name for surface in surfaces]
    if len(set(names)) < len(names):
        raise PinpressError(
            f"several surfaces are named {', '.join(sorted({n for n in names if names.count(n) > 1}))}: give each surface a different name"
        )
    for surface in surfaces:
        normal = np.array(surface.normal) / np.linalg.norm(surface.normal)
        if abs(normal @ axis) > ACROSS:
            raise PinpressError(
                f"GuideSurface {surface.name!r}: its normal {list(surface.normal)} is not across the guide's axis {axis.tolist()}; give"
                " each surface, GuideSurface(..., normal=), the direction in which this slide presses on it (eight_way_guide: of a slide"
                " along z)"
            )
    furthest = max(surfaces, key=lambda surface: float(np.abs(surface.point).max()))
    plausibility.point(f"GuideSurface {furthest.name!r}: point", np.array(furthest.point), press.size)
    longest = max(surfaces, key=lambda surface: surface.length)
    plausibility.length(f"GuideSurface {longest.name!r}: length", longest.length, press.size)
    first = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = first - (first @ axis) * axis
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)])


def _on_guide(press: Linkage, reactions: Reactions, offset: Array) -> tuple[Array, Array]:
    """Force (n, 3) of the guide on the slide and its moment about the slide link's origin, in world axes; process loads have an offset."""
    guide, slide = press.joints[press.slide_guide.joint], str(press.slide)
    if guide in reactions.left_out:
        raise PinpressError(f"the reactions leave out {shown(guide)}: name it in inverse_dynamics(..., bearings=), or give no bearings=")
    force = np.array(reactions.bearing_force[guide])
    joint, origin = point_on_body(press, slide, np.zeros(3), "the slide", "origin")
    if press.model.parents[joint] != 0:
        raise PinpressError(
            f"the guide {shown(guide)} of {press.name} is not on the frame, so its surfaces move: give a guide on the frame"
        )
    middle = press.model.jointPlacements[joint].rotation @ origin
    moment = reactions.bearing_moment[guide] - np.cross(middle, force)
    added = -np.cross(offset, reactions.process_force[:, None] * press.slide_direction)
    open_parts, axes = np.asarray(reactions.indeterminate[guide]), reactions.indeterminate_axes
    size = max(float(np.abs(force).max()), float(np.abs(moment).max()), float(np.abs(added).max()), 1.0)

    def is_open(vectors: Array, parts: NDArray[np.bool_]) -> bool:
        return float(np.abs(vectors @ axes.T)[:, parts].max(initial=0.0)) > ACROSS * size

    if is_open(added, open_parts[3:]) or (is_open(moment, open_parts[3:]) and not reactions.stiffness):
        raise PinpressError(
            f"parallel rods of {press.name} share moments with {shown(guide)}, and rigid mechanics does not say how: give inverse_dynamics"
            " stiffness=, and forces beside the axis as PointForce"
        )
    if is_open(force, open_parts[:3]) and not reactions.stiffness:
        raise PinpressError(
            f"a load presses {shown(slide)} across the plane of {press.name}, and rigid mechanics does not say what of it {shown(guide)}"
            " carries: give inverse_dynamics(..., stiffness=)"
        )
    return force, moment + added


class _Touching(NamedTuple):
    """Compression (n, S) at the middle of S surfaces [m], its slope along the guide, and the two ends of the contact [m]."""

    middle: Array
    slope: Array
    low: Array
    high: Array


class _Bed(NamedTuple):
    """The surfaces as Winkler foundations. A position of the slide is two displacements across the guide and three rotations.

    Attributes:
        stiffness: (S,) stiffness of the surfaces [N/m].
        length: (S,) length of the surfaces [m].
        begin: (S,) compression with the slide in its nominal position [m].
        shift: (S, 5) derivative of the compression at the middle by the position of the slide.
        tilt: (S, 5) derivative of the compression's slope by the position of the slide.
    """

    stiffness: Array
    length: Array
    begin: Array
    shift: Array
    tilt: Array

    @classmethod
    def of(cls, surfaces: Sequence[GuideSurface], across: Array, axis: Array) -> _Bed:
        normal = np.array([surface.normal for surface in surfaces], dtype=float)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        point = np.array([surface.point for surface in surfaces], dtype=float)
        stiffness, length = np.array([[surface.stiffness, surface.length] for surface in surfaces]).T
        begin = np.array([surface.preload / surface.stiffness - surface.clearance for surface in surfaces])
        shift = np.hstack([normal @ across.T, np.cross(point, normal)])
        tilt = np.hstack([np.zeros((len(surfaces), 2)), np.cross(axis, normal)])
        return cls(stiffness, length, begin, shift, tilt)

    def touching(self, places: Array) -> _Touching:
        """The contact at positions (n, 5) of the slide."""
        middle, slope = self.begin + places @ self.shift.T, places @ self.tilt.T
        half = np.broadcast_to(0.5 * self.length, middle.shape)
        with np.errstate(all="ignore"):
            zero = np.where(slope != 0, -middle / slope, np.where(middle > 0, -np.inf, np.inf))
        low = np.where(slope >= 0, np.clip(zero, -half, half), -half)
        return _Touching(middle, slope, low, np.where(slope < 0, np.clip(zero, -half, half), half))

    def _moments(self, places: Array) -> tuple[_Touching, tuple[Array, Array, Array]]:
        """The contact, and the integrals (n, S) of 1, s and s^2 over the length in contact."""
        at = self.touching(places)
        return at, ((at.high - at.low), (at.high**2 - at.low**2) / 2, (at.high**3 - at.low**3) / 3)

    def forces(self, places: Array) -> Array:
        """Forces (n, S) of the surfaces at positions (n, 5) of the slide [N]."""
        at, (one, s, _) = self._moments(places)
        return np.asarray(self.stiffness / self.length * (at.middle * one + at.slope * s))

    def energy(self, places: Array) -> Array:
        """Elastic energy (n,) at positions (n, 5) of the slide [J]."""
        at, (one, s, ss) = self._moments(places)
        squares = at.middle**2 * one + 2 * at.middle * at.slope * s + at.slope**2 * ss
        return np.asarray(0.5 * squares @ (self.stiffness / self.length))

    def slopes(self, places: Array) -> tuple[Array, Array]:
        """Gradient (n, 5) and Hessian (n, 5, 5) of the energy."""
        at, (one, s, ss) = self._moments(places)
        each = self.stiffness / self.length
        gradient = (each * (at.middle * one + at.slope * s)) @ self.shift + (each * (at.middle * s + at.slope * ss)) @ self.tilt
        mixed = np.einsum("ns,si,sj->nij", each * s, self.shift, self.tilt)
        hessian = np.einsum("ns,si,sj->nij", each * one, self.shift, self.shift) + mixed + mixed.transpose(0, 2, 1)
        return gradient, hessian + np.einsum("ns,si,sj->nij", each * ss, self.tilt, self.tilt)

    def scales(self) -> Array:
        """(5,) stiffness of all surfaces together against each component of a position."""
        whole = self.stiffness @ (self.shift**2 + (self.length**2)[:, None] / 12 * self.tilt**2)
        lever = max(float(np.abs(self.shift[:, 2:]).max()), float(self.length.max()))
        return np.asarray(np.maximum(whole, self.stiffness.sum() * np.array([1.0, 1.0, *(3 * [lever**2])]) * ACROSS))


def _settled(bed: _Bed, load: Array, motion: Motion, press_name: str) -> Array:
    """Positions (n, 5) of the slide at which the surfaces carry loads (n, 5).

    Centring springs, a billionth as stiff as the surfaces, keep a slide that floats in its clearances in the middle.
    """
    scale = np.sqrt(bed.scales())
    centring = HELD * np.ones(5)
    scaled_load = load / scale  # positions are scaled so that all components are equally stiff
    scaled = bed._replace(shift=bed.shift / scale, tilt=bed.tilt / scale)
    x = np.zeros_like(scaled_load)
    size = np.abs(scaled_load).max(axis=1) + np.abs(scaled.stiffness * bed.begin).max() * np.abs(scaled.shift).max() + 1e-300

    def energy(places: Array, loads: Array) -> Array:
        return np.asarray(scaled.energy(places) + 0.5 * (places**2 @ centring) - (places * loads).sum(axis=1))

    left = np.arange(len(x))
    for _ in range(STEPS):
        gradient, hessian = scaled.slopes(x[left])
        missing = gradient + centring * x[left] - scaled_load[left]
        still = np.abs(missing).max(axis=1) > SETTLED * size[left]
        left, missing, hessian = left[still], missing[still], hessian[still]
        if not len(left):
            break
        step = -np.linalg.solve(hessian + np.diag(centring), missing[..., None])[..., 0]
        before, falls = energy(x[left], scaled_load[left]), (missing * step).sum(axis=1)
        share = np.ones(len(left))
        for _ in range(HALVES):
            after = energy(x[left] + share[:, None] * step, scaled_load[left])
            steep = after > before + 1e-4 * share * falls + ROUNDED * np.abs(before)
            if not steep.any():
                break
            share[steep] *= 0.5
        x[left] += share[:, None] * step
    pulled = np.abs(centring * x).max(axis=1) > LEFT * size
    pulled[left] = True  # so far away that only rounding errors remain
    if pulled.any():
        raise PinpressError(
            f"at {motion.place(int(np.argmax(pulled)))} the surfaces do not hold the slide of {press_name} against force and moment on it:"
            " give surfaces that face it, on both sides and apart from each other, as eight_way_guide does"
        )
    return np.asarray(x / scale)


def _by_name(names: Sequence[str], values: Array) -> FrozenMapping[str, Array]:
    return FrozenMapping({name: column.copy() for name, column in zip(names, values.T, strict=True)})


def _open_stretches(names: Sequence[str], contact: Array, angle: Array) -> Iterator[OpenSurface]:
    for name, share in zip(names, contact.T, strict=True):
        apart = np.concatenate([[False], share < 1 - ACROSS, [False]])
        change = np.flatnonzero(apart[1:] != apart[:-1])
        for first, after in zip(change[::2], change[1::2], strict=True):
            yield OpenSurface(name, float(angle[first]), float(angle[after - 1]), float(share[first:after].min()))
