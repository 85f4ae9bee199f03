"""Room for counterweights: on which links, where and how heavy they may be, and what of that is linear.

In a planar press what is fixed to a link counts by four numbers: its mass m, its mass moment h = (h1, h2) and its moment of inertia J about
the room's centre. Material spread over a region can have just those with h in m times the region and J between that of a point mass,
h^2 / m, and that of all of it at the region's far end. This is a convex cone, so that the best of all shapes and places is found.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.arrays import Array
from ..common.checks import any_numbers, numbers
from ..common.conic_program import AT_MOST, CONE, Rows
from ..common.errors import PinpressError, UnknownNameError, shown
from ..linkage.linkage import Linkage
from .counterweights import body, carrier, spread
from .mass_response import PointMasses

Vector = tuple[float, float, float]
FLAT = 1e-9  # of the press's size: corners are in one plane of motion


@dataclass(frozen=True)
class Room:
    """Room for a counterweight on a link. All positions are in the link's own frame [m].

    Its place is one of: a point ``at``; within ``radius`` of ``centre`` in the plane of motion; within the polygon, segment or hull of
    ``corners``, which are in one plane of motion; or, where it ``replaces`` the link's own mass and none of these is given, that of the
    link's own, whose shape it has then.

    Attributes:
        link: its name. mass: least and most [kg]; holes are negative, and can be drilled ``at`` a point alone.
        gyration: radius of gyration of its material about the normal of the plane where it is a point, or in addition to its spread over
            radius or corners [m]. In a press that is not planar it is that about every axis.
        replaces: it takes the place of the link's own mass.
    """

    link: str
    mass: tuple[float, float] = (0.0, math.inf)
    at: Vector | None = None
    radius: float | None = None
    centre: Vector = (0.0, 0.0, 0.0)
    corners: tuple[Vector, ...] = ()
    gyration: float = 0.0
    replaces: bool = False

    def __post_init__(self) -> None:
        what = self.words
        if self.at is not None:
            object.__setattr__(self, "at", tuple(numbers(f"{what}: at", self.at, (3,)).tolist()))
        corners = (
            np.empty((0, 3)) if isinstance(self.corners, list | tuple) and not self.corners else numbers(f"{what}: corners", self.corners)
        )
        if corners.ndim != 2 or corners.shape[1] != 3:
            raise PinpressError(f"{what}: corners has shape {corners.shape}: give points in the link's frame, (k, 3) [m]")
        object.__setattr__(self, "corners", tuple(map(tuple, corners.tolist())))
        given = (self.at is not None) + (self.radius is not None) + bool(self.corners)
        if given > 1:
            raise PinpressError(f"{what}: give one of at, radius and corners")
        if not isinstance(self.replaces, bool):
            raise PinpressError(f"{what}: replaces is {shown(self.replaces)}: give True or False")
        if not given and not self.replaces:
            raise PinpressError(f"{what}: give its place: at, radius or corners (or replaces=True, for another mass of the link itself)")
        mass = any_numbers(f"{what}: mass", self.mass)
        low, high = map(float, mass) if mass.shape == (2,) else (math.nan, math.nan)
        if not -math.inf < low <= high:
            raise PinpressError(
                f"{what}: mass is {shown(self.mass)}: give the least and the most, as (0, 500) [kg]; the most may be math.inf"
            )
        if low < 0 and (self.at is None or self.replaces):
            raise PinpressError(f"{what}: its least mass is {low:g} kg, but only a hole at a point, at=..., has a negative one")
        for name, length in (("radius", self.radius), ("gyration", self.gyration)):
            if length is not None and not ((found := numbers(f"{what}: {name}", length)).ndim == 0 and found >= 0):
                raise PinpressError(f"{what}: {name} is {shown(length)}: give a length that is not negative [m]")
        if self.gyration and self.replaces and not given:
            raise PinpressError(f"{what}: the link keeps its own shape, and radius of gyration with it: leave gyration out")

    @property
    def words(self) -> str:
        """For messages."""
        return f"room on {shown(self.link)}"


@dataclass(frozen=True, eq=False, repr=False)
class Layout:
    """A room as variables, all about one in size.

    Attributes:
        room: as it was given. joint: that carries the link.
        parts: point masses that one of each variable is.
        mass: (variables,) [kg] of one of each. own: inertia that the link loses, in the joint's frame; None where it keeps it.
        rows: constraints on these variables alone; those on the mass are named.
        body: values of the variables to the inertia that the room is filled with, in the joint's frame.
    """

    room: Room
    joint: int
    parts: tuple[PointMasses, ...]
    mass: Array
    own: pin.Inertia | None
    rows: tuple[Rows, ...]
    body: Callable[[Array], pin.Inertia]


def layout(press: Linkage, room: Room, turning: bool, unit: float) -> Layout:
    """A room of a press as variables.

    Args:
        turning: whether moments of inertia count, or the forces asked for do not depend on them.
        unit: mass that one of a variable means [kg].

    Raises:
        UnknownNameError: no such link.
        PinpressError: a link that does not move, a room with a shape in a press that is not planar, corners in different planes.
    """
    if room.link not in press.links:
        raise UnknownNameError("link", room.link, press.links)
    joint, _ = carrier(press, room.link, room.centre, room.words)
    own = press.model.inertias[joint] if room.replaces else None
    if room.radius is None and not room.corners:
        return _single(press, room, joint, own, unit)
    return _spread_out(press, room, joint, own, _region(press, room, joint), turning, unit)


class _Region(NamedTuple):
    """Where a room with a shape is: its centre (3,) and the plane's directions (2, 3) in the joint's frame, its size [m], and its corners
    (q, 2) from the centre in that size, None for a circle."""

    centre: Array
    in_plane: Array
    size: float
    corners: Array | None


def _region(press: Linkage, room: Room, joint: int) -> _Region:
    if press.plane is None:
        raise PinpressError(f"{room.words}: {press.name} is not planar: give a point, at=..., there")
    frame = press.plane.frames[joint - 1]
    ends = np.array([carrier(press, room.link, end, room.words)[1] for end in room.corners or [room.centre]])
    centre = ends.mean(axis=0)
    arms = (ends - centre) @ frame.T
    if np.abs(arms[:, 2]).max() > FLAT * press.plane.size:
        raise PinpressError(f"{room.words}: its corners are in different planes of motion: give them one coordinate along the normal")
    size = float(room.radius) if room.radius is not None else float(np.linalg.norm(arms, axis=1).max())
    if not size > 0:
        raise PinpressError(f"{room.words} has no extent: give a point, at=..., instead")
    return _Region(centre, frame[:2], size, arms[:, :2] / size if room.corners else None)


def _single(press: Linkage, room: Room, joint: int, own: pin.Inertia | None, unit: float) -> Layout:
    """A room of one variable, the mass."""
    if room.at is None:
        assert own is not None  # a room without a place replaces the link's mass
        one = _scaled(own, unit / own.mass)
    else:
        _, point = carrier(press, room.link, room.at, room.words)
        one = body(unit, point, room.gyration**2 * unit * spread(press, joint))
    parts = (points_of(press, room.link, one),)
    rows = _mass_rows(room, np.array([unit]), positive=False)
    return Layout(room, joint, parts, np.array([unit]), own, rows, lambda u: _scaled(one, float(u[0])))


def _spread_out(press: Linkage, room: Room, joint: int, own: pin.Inertia | None, region: _Region, turning: bool, unit: float) -> Layout:
    """A room with a shape. Variables are mass and mass moment, of corners the masses in them; and, where it counts, the moment of inertia
    about the centre."""
    size, corners = region.size, region.corners
    # (4, variables): mass, mass moment and moment of inertia, in units of the room's mass and size
    if corners is None:
        numbers_of = np.eye(4)[:, : 3 + turning]
    else:
        numbers_of = np.zeros((4, len(corners) + turning))
        numbers_of[0, : len(corners)], numbers_of[1:3, : len(corners)] = 1.0, corners.T
        numbers_of[3, len(corners) :] = 1.0
    mass, first, second, inertia = numbers_of
    own_spread = (room.gyration / size) ** 2 * mass
    rows: list[Rows] = []
    if corners is not None:
        rows.append(Rows(AT_MOST, -np.eye(len(mass))[: len(corners)], np.zeros(len(corners))))
    elif not turning:
        rows.append(Rows(CONE, -np.array([mass, first, second]), np.zeros(3), f"radius of the {room.words}", 0.0))
    if turning:
        over_region = inertia - own_spread
        furthest = mass if corners is None else np.append((corners**2).sum(axis=1), 0.0)
        rows += [
            Rows(AT_MOST, np.array([over_region - furthest]), np.zeros(1), f"extent of the {room.words}", 0.0),
            Rows(CONE, -np.array([over_region + mass, 2 * first, 2 * second, over_region - mass]), np.zeros(4)),
        ]

    def filled(u: Array) -> pin.Inertia:
        m, h1, h2, about = numbers_of @ u
        if not m > 0:
            return pin.Inertia.Zero()
        arm = np.array([h1, h2]) / m
        about_mass = max(about - m * float(arm @ arm), 0.0) if turning else own_spread @ u
        return body(unit * m, region.centre + size * arm @ region.in_plane, about_mass * unit * size**2 * spread(press, joint))

    parts = tuple(_cross(press, room.link, region.centre, size * region.in_plane, unit * column) for column in numbers_of.T)
    rows += _mass_rows(room, unit * mass, positive=True)
    return Layout(room, joint, parts, unit * mass, own, tuple(rows), filled)


def _cross(press: Linkage, link: str, centre: Array, arms: Array, amounts: Array) -> PointMasses:
    """Five point masses about a centre, at the ends of arms (2, 3) both ways and in the middle, with this mass, mass moment and moment of
    inertia (4,), in units of mass and arms."""
    mass, first, second, inertia = amounts
    around = 0.25 * inertia
    masses = np.array([mass - inertia, 0.5 * first + around, around - 0.5 * first, 0.5 * second + around, around - 0.5 * second])
    return _in_link(press, link, masses, centre + np.array([np.zeros(3), arms[0], -arms[0], arms[1], -arms[1]]))


def points_of(press: Linkage, link: str, inertia: pin.Inertia) -> PointMasses:
    """Point masses with the same mass, centre of mass and inertia tensor as a body, given in the joint's frame."""
    second = 0.5 * np.trace(inertia.inertia) * np.eye(3) - inertia.inertia  # of mass about its centre: the integral of r r'
    spreads, directions = np.linalg.eigh(second)
    if not spreads.max() > 0:
        return _in_link(press, link, np.array([inertia.mass]), inertia.lever[None])
    arms = (np.sqrt(3.0 * np.maximum(spreads, 0.0) / inertia.mass) * directions).T
    return _in_link(press, link, np.full(6, inertia.mass / 6), inertia.lever + np.concatenate([arms, -arms]))


def _in_link(press: Linkage, link: str, masses: Array, points: Array) -> PointMasses:
    """Point masses whose points (p, 3) are in the joint's frame; those that are none are left out."""
    there = press.model.frames[press.model.getFrameId(link, pin.BODY)].placement
    some = masses != 0.0
    some[0] |= not some.any()
    return PointMasses(link, masses[some], np.array([there.actInv(point) for point in points[some]]))


def _mass_rows(room: Room, mass: Array, positive: bool) -> tuple[Rows, ...]:
    """The least and the most mass (variables,) of one of each; ``positive``: it is in any case."""
    low, high = room.mass
    rows = []
    if low > 0 or not positive:
        size = max(float(np.abs(mass).max()), abs(low))
        rows.append(Rows(AT_MOST, -mass[None] / size, np.array([-low / size]), f"least mass of the {room.words}, {low:g} kg", size))
    if high < math.inf:
        size = max(float(np.abs(mass).max()), abs(high))
        rows.append(Rows(AT_MOST, mass[None] / size, np.array([high / size]), f"most mass of the {room.words}, {high:g} kg", size))
    return tuple(rows)


def _scaled(inertia: pin.Inertia, factor: float) -> pin.Inertia:
    """Of a body of the same shape and other density."""
    return body(factor * inertia.mass, inertia.lever, factor * inertia.inertia)
