"""Regions for counterweights: links, places and masses of counterweights, and the linear variables that describe them.

In a planar press four numbers describe a body on a link: its mass m, its mass moment h = (h1, h2) and its moment of inertia J about the
region's centre. Material spread over a region can have all values with h in m times the region, and with J between h^2 / m (a point mass)
and the value for material at the far end of the region. These values form a convex cone, so the program finds the best of all shapes and
places.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common import plausibility
from ..common.arguments import any_numbers, in_unit, numbers, suitable_numbers, truth_value
from ..common.conic_program import AT_MOST, CONE, Rows
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.parameters import set_field
from ..common.quantities import Array
from ..linkage.linkage import Linkage
from .counterweights import PointMasses, carrying_joint, rigid_body, unit_tensor

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class CounterweightRegion:
    """The region of a link in which a counterweight may be, and its mass. All positions are in the link's own frame [m].

    The place is a point ``at``, a circle of ``radius`` about ``centre`` in the plane of motion, or the hull of ``corners`` (a segment or
    polygon) in a plane of motion. With ``replaces`` and without a place the counterweight is the link's own mass, which keeps its shape and
    centre but gets another size.

    Attributes:
        link: name of the link.
        mass: least and largest mass [kg]. A hole has a negative mass, and is possible only ``at`` a point.
        at: (3,) point [m].
        radius: radius of the circle [m].
        centre: (3,) centre of the circle [m].
        corners: (k, 3) corners of the polygon [m].
        gyration: radius of gyration of the counterweight's material about the normal of the plane (in a press that is not planar: about
            every axis), in addition to the spread over circle or polygon [m].
        replaces: whether the counterweight replaces the link's own mass.
        reset: what is adjusted in every operating condition, e.g. with each change of the die: "mass": the mass at a fixed place (``at``,
            or the link's own shape); "position": the position of a fixed mass within ``radius`` or ``corners``; "": nothing.

    Raises:
        PinpressError: the place is missing or given twice, a number is not finite or negative, or reset does not suit the place.
    """

    link: str
    mass: tuple[float, float] = (0.0, math.inf)
    at: Vector | None = None
    radius: float | None = None
    centre: Vector = (0.0, 0.0, 0.0)
    corners: tuple[Vector, ...] = ()
    gyration: float = 0.0
    replaces: bool = False
    reset: str = ""

    def __post_init__(self) -> None:
        for name, unit in {"mass": "kg", **dict.fromkeys(("at", "radius", "centre", "corners", "gyration"), "m")}.items():
            set_field(self, name, in_unit(f"{self.words}: {name}", getattr(self, name), unit))
        if self.at is not None:
            set_field(self, "at", tuple(numbers(f"{self.words}: at", self.at, (3,)).tolist()))
        if isinstance(self.corners, list | tuple) and not self.corners:
            set_field(self, "corners", ())
        else:
            corners = suitable_numbers(f"{self.words}: corners", self.corners, "points in the link's frame, (k, 3) [m]", (None, 3))
            set_field(self, "corners", tuple(map(tuple, corners.tolist())))
        places = (self.at is not None) + (self.radius is not None) + bool(self.corners)
        if places > 1:
            raise PinpressError(f"{self.words}: its place is given twice: give one of at, radius and corners")
        truth_value(f"{self.words}: replaces", self.replaces)
        if not places and not self.replaces:
            raise PinpressError(
                f"{self.words}: its place is missing: give at, radius or corners (or replaces=True, for another mass of the link itself)"
            )
        self._refuse_wrong_mass()
        for name, length in (("radius", self.radius), ("gyration", self.gyration)):
            if length is not None:
                suitable_numbers(f"{self.words}: {name}", length, "a length that is not negative [m]", suits=lambda size: size >= 0)
        self._refuse_wrong_reset()
        if self.gyration and not places:
            raise PinpressError(f"{self.words}: the link keeps its own shape and radius of gyration: leave out gyration")

    def _refuse_wrong_reset(self) -> None:
        if not isinstance(self.reset, str) or self.reset not in ("", "mass", "position"):
            raise PinpressError(f"{self.words}: reset is {shown(self.reset)}: give one of '', 'mass', 'position'")
        has_shape = self.radius is not None or bool(self.corners)
        if self.reset == "mass" and has_shape:
            raise PinpressError(
                f"{self.words}: reset='mass' needs a fixed place: give at=..., or reset='position' for a mass that moves within a shape"
            )
        if self.reset == "position" and not has_shape:
            raise PinpressError(f"{self.words}: reset='position' needs room: give radius=... or corners=..., or reset='mass' at a point")

    def _refuse_wrong_mass(self) -> None:
        mass = any_numbers(f"{self.words}: mass", self.mass)
        low, high = map(float, mass) if mass.shape == (2,) else (math.nan, math.nan)
        if not -math.inf < low <= high:
            raise PinpressError(
                f"{self.words}: mass is {shown(self.mass)}: give least and largest mass, e.g. (0, 500) [kg]; the largest may be math.inf"
            )
        if low < 0 and (self.at is None or self.replaces):
            raise PinpressError(
                f"{self.words}: its least mass is {low:g} kg, but only a hole at a point may have a negative mass: give at=..."
            )

    @property
    def words(self) -> str:
        """Name in messages."""
        return f"region on {shown(self.link)}"


@dataclass(frozen=True, eq=False, repr=False)
class RegionVariables:
    """A region as variables of the convex program, all about one in size.

    Attributes:
        region: the given region.
        joint: Pinocchio joint that carries the link.
        parts: point masses that a unit of each variable represents.
        mass: (variables,) mass per unit of each variable [kg].
        replaced: inertia that the link loses, in the joint's frame; None if the link keeps its mass.
        rows: constraints on only these variables; constraints on the mass have a name.
        filling: computes the inertia of the counterweight, in the joint's frame, from values (variables,).
    """

    region: CounterweightRegion
    joint: int
    parts: tuple[PointMasses, ...]
    mass: Array
    replaced: pin.Inertia | None
    rows: tuple[Rows, ...]
    filling: Callable[[Array], pin.Inertia]


def region_variables(press: Linkage, region: CounterweightRegion, inertia_counts: bool, unit: float) -> RegionVariables:
    """A region of a press as variables.

    Args:
        press: the press.
        region: the region.
        inertia_counts: whether the measured forces depend on moments of inertia.
        unit: mass per unit of a variable [kg].

    Raises:
        UnknownNameError: the press does not have a link with this name.
        PinpressError: the link does not move, the region has a shape in a press that is not planar, or its corners are in different planes.
    """
    if region.link not in press.links:
        raise UnknownNameError("link", region.link, press.links)
    joint, _ = carrying_joint(press, region.link, region.centre, region.words)
    for name, length in (("radius", region.radius), ("gyration", region.gyration)):
        plausibility.length(f"{region.words}: {name}", length or 0.0, press.size)
    replaced = press.model.inertias[joint] if region.replaces else None
    if region.radius is None and not region.corners:
        return _point_variables(press, region, joint, replaced, unit)
    return _shape_variables(press, region, joint, replaced, inertia_counts, unit)


def _point_variables(press: Linkage, region: CounterweightRegion, joint: int, replaced: pin.Inertia | None, unit: float) -> RegionVariables:
    """A region with one variable, the mass."""
    if region.at is None:
        assert replaced is not None  # a region without a place replaces the link's mass
        unit_body = _scale_density(replaced, unit / replaced.mass)
    else:
        _, point = carrying_joint(press, region.link, region.at, region.words)
        unit_body = rigid_body(unit, point, region.gyration**2 * unit * unit_tensor(press, joint))
    parts = (points_of(press, region.link, unit_body),)
    rows = _mass_rows(region, np.array([unit]), positive=False)
    return RegionVariables(region, joint, parts, np.array([unit]), replaced, rows, lambda u: _scale_density(unit_body, float(u[0])))


def _shape_variables(
    press: Linkage, region: CounterweightRegion, joint: int, replaced: pin.Inertia | None, inertia_counts: bool, unit: float
) -> RegionVariables:
    """A region with a shape. The variables are mass and mass moment in a circle, or masses at the corners of a polygon.

    If moments of inertia count, the moment of inertia about the centre is one more variable.
    """
    shape = _shape(press, region, joint)
    moments = _moments(shape.corners, inertia_counts)
    own_spread = (region.gyration / shape.size) ** 2 * moments[0]

    def filling(u: Array) -> pin.Inertia:
        m, h1, h2, about = moments @ u
        if not m > 0:
            return pin.Inertia.Zero()
        arm = np.array([h1, h2]) / m
        about_mass = max(about - m * float(arm @ arm), 0.0) if inertia_counts else own_spread @ u
        lever, tensor = shape.centre + shape.size * arm @ shape.in_plane, about_mass * unit * shape.size**2 * unit_tensor(press, joint)
        return rigid_body(unit * m, lever, tensor)

    return RegionVariables(
        region,
        joint,
        parts=tuple(_cross(press, region.link, shape.centre, shape.size * shape.in_plane, unit * column) for column in moments.T),
        mass=unit * moments[0],
        replaced=replaced,
        rows=(*_shape_rows(region, shape, moments, own_spread, inertia_counts), *_mass_rows(region, unit * moments[0], positive=True)),
        filling=filling,
    )


class _RegionShape(NamedTuple):
    """A circle (``corners`` is None) or polygon (``corners`` (q, 2) from the centre, divided by the size) in the plane of motion."""

    centre: Array
    in_plane: Array
    size: float
    corners: Array | None


def _shape(press: Linkage, region: CounterweightRegion, joint: int) -> _RegionShape:
    plane = press.plane_of_motion(f"{region.words}: {press.name} is not planar: give a point, at=...")
    frame = plane.frames[joint - 1]
    ends = np.array([carrying_joint(press, region.link, end, region.words)[1] for end in region.corners or [region.centre]])
    centre = ends.mean(axis=0)
    arms = (ends - centre) @ frame.T
    if np.abs(arms[:, 2]).max() > 1e-9 * plane.size:
        raise PinpressError(f"{region.words}: its corners are in different planes of motion: give all the same coordinate along the normal")
    size = float(region.radius) if region.radius is not None else float(np.linalg.norm(arms, axis=1).max())
    if not size > 0:
        raise PinpressError(f"{region.words}: its size is zero: give a point, at=..., instead")
    return _RegionShape(centre, frame[:2], size, arms[:, :2] / size if region.corners else None)


def _moments(corners: Array | None, inertia_counts: bool) -> Array:
    """Mass, mass moment (two rows) and moment of inertia (4, variables) per unit of each variable, in units of mass and size."""
    if corners is None:
        return np.eye(4)[:, : 3 + inertia_counts]
    moments = np.zeros((4, len(corners) + inertia_counts))
    moments[0, : len(corners)], moments[1:3, : len(corners)] = 1.0, corners.T
    moments[3, len(corners) :] = 1.0
    return moments


def _shape_rows(region: CounterweightRegion, shape: _RegionShape, moments: Array, own_spread: Array, inertia_counts: bool) -> list[Rows]:
    """The constraints that keep material within the shape. ``own_spread``: moment of inertia (variables,) by the radius of gyration."""
    mass, first, second, inertia = moments
    corners, rows = shape.corners, list[Rows]()
    if corners is not None:
        rows.append(Rows(AT_MOST, -np.eye(len(mass))[: len(corners)], np.zeros(len(corners))))
    elif not inertia_counts:
        rows.append(Rows(CONE, -np.array([mass, first, second]), np.zeros(3), f"radius of the {region.words}", 0.0))
    if inertia_counts:
        over_region = inertia - own_spread
        furthest = mass if corners is None else np.append((corners**2).sum(axis=1), 0.0)
        rows += [
            Rows(AT_MOST, np.array([over_region - furthest]), np.zeros(1), f"extent of the {region.words}", 0.0),
            Rows(CONE, -np.array([over_region + mass, 2 * first, 2 * second, over_region - mass]), np.zeros(4)),
        ]
    return rows


def _mass_rows(region: CounterweightRegion, mass: Array, positive: bool) -> tuple[Rows, ...]:
    """Constraints by the least and the largest mass; ``positive``: other constraints already exclude negative masses."""
    low, high = region.mass
    rows = []
    if low > 0 or not positive:
        size = max(float(np.abs(mass).max()), abs(low))
        rows.append(Rows(AT_MOST, -mass[None] / size, np.array([-low / size]), f"least mass of the {region.words}, {low:g} kg", size))
    if high < math.inf:
        size = max(float(np.abs(mass).max()), abs(high))
        rows.append(Rows(AT_MOST, mass[None] / size, np.array([high / size]), f"most mass of the {region.words}, {high:g} kg", size))
    return tuple(rows)


def _cross(press: Linkage, link: str, centre: Array, arms: Array, amounts: Array) -> PointMasses:
    """Five point masses with given moments, at a centre (3,) and at both ends of two arms (2, 3) through the centre.

    ``amounts``: mass, mass moment along both arms, and moment of inertia (4,), in units of mass and of the arms' length.
    """
    mass, first, second, inertia = amounts
    around = 0.25 * inertia
    masses = np.array([mass - inertia, 0.5 * first + around, around - 0.5 * first, 0.5 * second + around, around - 0.5 * second])
    return _in_link(press, link, masses, centre + np.array([np.zeros(3), arms[0], -arms[0], arms[1], -arms[1]]))


def points_of(press: Linkage, link: str, inertia: pin.Inertia) -> PointMasses:
    """Point masses with the mass, centre of mass and inertia tensor of a body, whose inertia is in the frame of the link's joint."""
    second = 0.5 * np.trace(inertia.inertia) * np.eye(3) - inertia.inertia  # second moments of mass about the centre, the integral of r r'
    spreads, directions = np.linalg.eigh(second)
    if not spreads.max() > 0:
        return _in_link(press, link, np.array([inertia.mass]), inertia.lever[None])
    arms = (np.sqrt(3.0 * np.maximum(spreads, 0.0) / inertia.mass) * directions).T
    return _in_link(press, link, np.full(6, inertia.mass / 6), inertia.lever + np.concatenate([arms, -arms]))


def _in_link(press: Linkage, link: str, masses: Array, points: Array) -> PointMasses:
    """Point masses whose points (p, 3) are given in the joint's frame; masses of zero are left out."""
    placement, used = press.frame_of(link).placement, masses != 0.0
    used[0] |= not used.any()
    return PointMasses(link, masses[used], np.array([placement.actInv(point) for point in points[used]]))


def _scale_density(inertia: pin.Inertia, factor: float) -> pin.Inertia:
    """The inertia of a body of this shape with its density multiplied by a factor."""
    return rigid_body(factor * inertia.mass, inertia.lever, factor * inertia.inertia)
