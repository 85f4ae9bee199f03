"""Balancing of rigid rotors: cranks, crankshafts, flywheels, gears. Zhang 2007, 3.1.1.

A mass m at a radius r on a shaft with the speed w pulls the shaft outwards with the force m w^2 r. In static balance the sum of these
forces, and so the sum of m r, is zero (eq. 3.1.5). In dynamic balance their couples are zero too: the sum of a m r, where a is the place of
the mass along the shaft. Static balance needs one correction. Dynamic balance needs two corrections in different planes. A mass is added
opposite to the unbalance; a hole is drilled on the side of the unbalance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...common.arguments import numbers, positive, typed
from ...common.errors import PinpressError, UnknownNameError, shown
from ...common.quantities import Array
from ...common.results import Record, Records
from ...linkage.linkage import Linkage
from ..counterweights import Counterweight


@dataclass(frozen=True, eq=False, repr=False)
class Correction(Record, units={"product": "kg m", "centre": "m"}, parts={"product": "xyz", "centre": "xyz"}):
    """A mass times radius that balances a rotor, in one plane across its axis.

    Attributes:
        product: (3,) mass times radius vector of the added mass, in the rotor's frame [kg m].
        centre: (3,) point where the plane meets the axis, in the rotor's frame [m].
    """

    product: Array
    centre: Array

    def counterweight(self, link: str, radius: float) -> Counterweight:
        """The counterweight of this correction.

        Args:
            link: name of the link, which has the rotor's frame.
            radius: distance from the axis [m].

        Raises:
            PinpressError: the radius is not positive.
        """
        return self._at(link, radius, 1.0)

    def hole(self, link: str, radius: float) -> Counterweight:
        """The hole of this correction, on the side opposite to a counterweight.

        Args:
            link: name of the link, which has the rotor's frame.
            radius: distance from the axis [m].

        Raises:
            PinpressError: the radius is not positive.
        """
        return self._at(link, radius, -1.0)

    def _at(self, link: str, radius: float, sign: float) -> Counterweight:
        radius, size = positive(f"radius of the counterweight on {shown(link)}", radius, "m"), float(np.linalg.norm(self.product))
        x, y, z = self.centre + (sign * radius * (self.product / size) if size else 0.0)
        return Counterweight(link, sign * size / radius, (float(x), float(y), float(z)))


@dataclass(frozen=True, eq=False, repr=False)
class RotorUnbalance(Record, units={"static": "kg m", "couple": "kg m2"}, parts={"axis": "xyz", "static": "xyz", "couple": "xyz"}):
    """The unbalance of a rotor whose axis passes through the origin of its frame. Vectors are in this frame.

    At the speed w the rotor pulls its bearings with the force ``w**2 * static`` and the moment ``w**2 * cross(axis, couple)`` about the
    origin.

    Attributes:
        axis: (3,) unit vector along the shaft; places along the shaft are measured from the origin.
        static: (3,) sum of m r, across the axis [kg m].
        couple: (3,) sum of a m r, where a is the place along the axis [kg m2].
    """

    axis: Array
    static: Array
    couple: Array

    def static_balance(self, plane: float = 0.0) -> Correction:
        """The correction after which the rotor rests at any angle.

        Args:
            plane: place of the correction's plane along the axis [m].

        Raises:
            PinpressError: the place is not a finite number.
        """
        (centre,) = self._centres([plane])
        return _correction(-self.static, centre)

    def two_plane_balance(self, planes: Sequence[float]) -> Records[Correction]:
        """The corrections in two planes that cancel force and couple.

        u_a + u_b = -static and a u_a + b u_b = -couple give u_a = (b static - couple) / (a - b) and u_b = (couple - a static) / (a - b).

        Args:
            planes: places a and b of the two planes along the axis [m].

        Raises:
            PinpressError: the places are not two different finite numbers, or are too close together.
        """
        centres = self._centres(planes)
        if len(centres) != 2 or not np.ptp(planes) > 0:
            raise PinpressError(f"planes is {shown(planes)}: give the places of two different planes along the shaft [m]")
        a, b = (float(place) for place in planes)
        with np.errstate(all="ignore"):  # an overflow is refused below
            first, second = (b * self.static - self.couple) / (a - b), (self.couple - a * self.static) / (a - b)
        return Records(Correction, (_correction(first, centres[0]), _correction(second, centres[1])))

    def _centres(self, planes: Sequence[float]) -> Array:
        places = numbers("balancing of a rotor: planes", planes)
        if places.ndim != 1:
            raise PinpressError(f"planes is {shown(planes)}: give one number for each plane, its place along the shaft [m]")
        return np.multiply.outer(places, self.axis)


def static_balance(masses: ArrayLike, positions: ArrayLike) -> Correction:
    """The correction that moves a rotor's centre of mass to its axis: minus the sum of m r. Zhang 2007, eq. 3.1.5.

    Args:
        masses: (k,) masses on an otherwise balanced rotor, negative for holes [kg].
        positions: (k, 3) their places in the rotor's frame, whose y axis is the shaft's axis [m].

    Raises:
        PinpressError: an array has another shape, or values that are not finite.
    """
    return _of_masses(masses, positions).static_balance()


@typed
def two_plane_balance(masses: ArrayLike, positions: ArrayLike, *, planes: Sequence[float]) -> Records[Correction]:
    """The two corrections that cancel force and couple of a rotor. Zhang 2007, 3.1.1 (2).

    The planes a and b share a mass like a force on a beam, m (b - y) / (b - a) and m (y - a) / (b - a). The correction in a plane balances
    the shares in this plane.

    Args:
        masses: (k,) masses on an otherwise balanced rotor, negative for holes [kg].
        positions: (k, 3) their places in the rotor's frame, whose y axis is the shaft's axis [m].
        planes: places of the two planes along y [m].

    Raises:
        PinpressError: an array has another shape or values that are not finite, or the planes are not two different places.
    """
    return _of_masses(masses, positions).two_plane_balance(planes)


@typed
def unbalance(press: Linkage, link: str) -> RotorUnbalance:
    """The unbalance of a link that turns on the frame, with the parts welded to it, from its inertia in the model.

    ``static`` is mass times centre of mass across the axis. ``couple`` is minus the products of inertia with the axis, about the link's
    origin. The axis points in the positive direction of the link's frame (y in the shipped presses), independent of the joint's sense.

    Args:
        press: the press.
        link: name of the link.

    Raises:
        UnknownNameError: the press does not have a link with this name.
        PinpressError: no joint turns the link on the frame.
    """
    if not isinstance(link, str) or link not in press.links:
        raise UnknownNameError("link", link, press.links)
    # A link that is welded to another one has another frame, and is not a rotor of its own.
    turning = [j for j, axis in enumerate(press.axes, 1) if axis.turns and press.model.parents[j] == 0]
    rotors = {press.link_of(joint): joint for joint in turning}
    if link not in rotors:
        raise PinpressError(f"link {shown(link)} does not turn on the frame: give one of {', '.join(rotors) or 'no links in this press'}")
    joint = rotors[link]
    axis, body = press.axes[joint - 1].direction, press.model.inertias[joint]
    axis = axis * math.copysign(1.0, axis[np.abs(axis).argmax()])
    across = np.eye(3) - np.outer(axis, axis)
    about_origin = body.inertia @ axis - body.mass * (body.lever @ axis) * body.lever  # the part along the axis is removed below
    return RotorUnbalance(axis + 0.0, body.mass * across @ body.lever, -across @ about_origin)


def _of_masses(masses: ArrayLike, positions: ArrayLike) -> RotorUnbalance:
    """The unbalance of masses (k,) at positions (k, 3)."""
    mass, position = numbers("balancing of a rotor: masses", masses), numbers("balancing of a rotor: positions", positions)
    if mass.ndim != 1 or position.shape != (len(mass), 3):
        raise PinpressError(f"masses has shape {mass.shape}, positions {position.shape}: give (k,) masses and (k, 3) positions")
    axis = np.array([0.0, 1.0, 0.0])
    radii = position * (1.0 - axis)
    with np.errstate(all="ignore"):  # a correction that is not finite is refused
        return RotorUnbalance(axis, mass @ radii, (mass * position[:, 1]) @ radii)


def _correction(product: Array, centre: Array) -> Correction:
    """A correction; raises PinpressError if it is not finite."""
    if not np.isfinite(product).all():
        raise PinpressError("the correction of a rotor is not finite: give smaller masses, or planes that are further apart")
    return Correction(product + 0.0, centre + 0.0)  # + 0.0: no -0.0
