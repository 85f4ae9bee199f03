"""Friction in the bearings and guides of a planar press on springs.

Each bearing presses with the force F of its springs, and its friction opposes the speed w with which its sides turn, or slide, against each
other: mu r F sgn(w), of a guide mu F sgn(w), and a viscous part. Of a guide with a preload F is that, or the force of the springs where
this is larger; two gibs that are a `PreloadedJoint` press with twice its preload.

While the links ring about a reversal, w changes its sign in quick succession, or stays zero for an instant in which friction holds the
joint. Both are followed by tanh(w / w0) in place of the sign: a joint that friction holds creeps with less than w0, a thousandth of the
crank's speed, and beyond some multiples of w0 the law is exact. A press that stands as a whole creeps too: its standstill is that of the
rigid press.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....common.errors import PinpressError, shown
from ....common.quantities import Array, ComplexArray
from ....engines.forces import FrictionLaw
from ..press_on_springs import PressOnSprings
from ..sprung_press import LineGeometry, LineSprings, SprungPress

CREEPS = 1e-3  # share of the crank's speed at which friction has not yet its whole size
LEAST = 1e-300  # force that has a direction [N]


class FrictionStates(NamedTuple):
    """Friction of K bearings at n states.

    Attributes:
        geometry: of the springs.
        sliding: of the guides, along their axes.
        pulls: (n, S) of the springs [N].
        pressing: (n, K) forces with which the bearings press [N].
        speed: (n, K) at which their sides turn or slide against each other.
        efforts: (n, K) of friction, against it [N m, of a guide N].
    """

    geometry: LineGeometry
    sliding: LineGeometry
    pulls: Array
    pressing: Array
    speed: Array
    efforts: Array


@dataclass(frozen=True, eq=False)
class BearingFriction:
    """Friction of some bearings of a press; see `bearing_friction`.

    Attributes:
        sprung: the press.
        slides: the same press with springs along the axes of its guides with friction, in place of all others.
        arm: (K,) friction by the force of the bearing, pins first [m, of a guide -].
        viscous: (K,) friction by speed.
        slow: (K,) speeds below which a bearing creeps.
        angles: (pins, 3 (bodies + 1)) all rates to the turning speeds of the pins.
        owners: (S, K) 1 where a spring is of this bearing.
        preload: (K,) least forces with which bearings press [N].
    """

    sprung: SprungPress
    slides: SprungPress
    arm: Array
    viscous: Array
    slow: Array
    angles: Array
    owners: Array
    preload: Array

    @cached_property
    def _turning(self) -> Array:
        """(pins, f) free rates to the turning speeds of the pins."""
        return self.angles @ self.sprung.carry

    def at(self, coordinates: Array, rates: Array) -> FrictionStates:
        """At all coordinates and rates (n, 3 (bodies + 1))."""
        lines = self.sprung.lines
        geometry, sliding = self.sprung.geometry(coordinates, rates), self.slides.geometry(coordinates, rates)
        pulls = -(lines.stiffness * geometry.extension + lines.damping * geometry.opening)
        for joint, (extension, _) in self.sprung.joint_motion(geometry):
            pulls[:, joint.spring] += joint.spring_force(extension)
        pressing = np.maximum(np.sqrt((pulls * pulls) @ self.owners), self.preload)
        speed = np.concatenate([rates @ self.angles.T, sliding.opening], axis=1)
        efforts = -(self.arm * pressing * np.tanh(speed / self.slow) + self.viscous * speed)
        return FrictionStates(geometry, sliding, pulls, pressing, speed, efforts)

    def lost_power(self, coordinates: Array, rates: Array) -> Array:
        """(n,) [W]."""
        found = self.at(coordinates, rates)
        return -np.asarray((found.efforts * found.speed).sum(axis=1))

    def along_guides(self, coordinates: Array, rates: Array) -> dict[int, ComplexArray]:
        """Friction (n,) of the guides on the links that slide in them, in the axes of the plane, by the numbers of the guides [N]."""
        found, pins = self.at(coordinates, rates), len(self.angles)
        forces = found.efforts[:, pins:] * found.sliding.against.conj()
        return {int(number): forces[:, k] for k, number in enumerate(self.slides.lines.bearing)}

    def add(self, coordinates: Array, rates: Array, force: Array, stiffness: Array, damping: Array) -> None:
        """Add its forces to those on the free coordinates (n, f), and minus their derivatives (n, f, f)."""
        found, lines, sprung, slides = self.at(coordinates, rates), self.sprung.lines, self.sprung, self.slides
        pins, count = len(self.angles), len(coordinates)
        gradient = np.concatenate([np.broadcast_to(self._turning, (count, *self._turning.shape)), slides._gradient(found.sliding)], axis=1)
        turned = np.zeros_like(gradient)  # derivatives of the speeds by the coordinates
        turned[:, pins:] = slides._gradient_rate(found.sliding, rates)
        force += np.matmul(found.efforts[:, None, :], gradient)[:, 0]
        opening = sprung._gradient(found.geometry)
        held = np.tile(lines.stiffness, (count, 1))
        for joint, (extension, _) in sprung.joint_motion(found.geometry):
            held[:, joint.spring] += joint.spring_slope(extension)
        by_place = held[:, :, None] * opening + lines.damping[:, None] * sprung._gradient_rate(found.geometry, rates)
        share = np.tanh(found.speed / self.slow)
        steep = self.arm * found.pressing * (1 - share * share) / self.slow + self.viscous
        moving = (found.pressing > self.preload)[:, None, :]  # not held by the preload
        along = -(found.pulls[:, :, None] * self.owners) / np.maximum(found.pressing, LEAST)[:, None, :] * moving  # (n, S, K)
        pressed = (self.arm * share)[:, None, :] * along
        effort_by_place = np.matmul(pressed.transpose(0, 2, 1), by_place) + steep[:, :, None] * turned
        effort_by_rate = np.matmul(pressed.transpose(0, 2, 1), lines.damping[:, None] * opening) + steep[:, :, None] * gradient
        across = gradient.transpose(0, 2, 1)
        stiffness += np.matmul(across, effort_by_place) - slides._bend(found.sliding, found.efforts[:, pins:])
        damping += np.matmul(across, effort_by_rate)


def bearing_friction(sprung: PressOnSprings, law: FrictionLaw, speed: float) -> BearingFriction:
    """Friction of the bearings of a press that runs at about a speed of its crank [rad/s].

    Raises:
        PinpressError: the press moves in space, a pin with friction has clearance, or a guide has a preload beside a `PreloadedJoint`.
    """
    press, some = sprung.press, np.flatnonzero((law.arm > 0) | (law.viscous > 0))
    if not isinstance(sprung, SprungPress):
        raise PinpressError(f"{press.name} moves in space: on its springs it has no friction; leave it out")
    for pin in sprung.open_pins:
        if pin.bearing in some:
            raise PinpressError(f"{shown(press.bearings[pin.bearing])} has clearance: give it no friction, or no clearance")
    lines, directions = sprung.lines, _guides(sprung)
    gibs = {joint.bearing: 2 * joint.joint.preload for joint in sprung.joints if joint.bearing in some and joint.bearing in directions}
    for number in gibs:
        if law.preload[number]:
            raise PinpressError(
                f"friction of {shown(press.bearings[number])}: its gibs are a PreloadedJoint, whose forces rub: leave preload out"
            )
    pins = [int(number) for number in some if number not in directions]
    guides = [int(number) for number in some if number in directions]
    angles = np.zeros((len(pins), len(sprung.drawn)))
    for row, number in enumerate(pins):
        first, second = sprung.bodies_of(number)
        angles[row, 3 * first + 2], angles[row, 3 * second + 2] = -1.0, 1.0
    rows = [int(np.flatnonzero(lines.bearing == number)[0]) for number in guides]
    along = LineSprings._make(column[rows] for column in lines)
    nothing = np.zeros(len(rows))
    along = along._replace(direction=np.array([directions[number] for number in guides], dtype=complex), stiffness=nothing, damping=nothing)
    shapes, order = sprung.shapes[:, rows], pins + guides
    slow = CREEPS * abs(speed) * np.where(np.arange(len(order)) < len(pins), 1.0, press.size)
    owners = (lines.bearing[:, None] == np.array(order)).astype(float)
    preload = np.array([gibs.get(number, law.preload[number]) for number in order])
    slides = replace(sprung, lines=along, shapes=shapes)
    return BearingFriction(sprung, slides, law.arm[order], law.viscous[order], slow, angles, owners, preload)


def _guides(sprung: SprungPress) -> dict[int, complex]:
    """Directions of the guides' axes in the drawn pose, by the numbers of their bearings."""
    lines = sprung.lines
    number = sprung.press.model.nv
    guides = [j for j in range(number) if not sprung.press.axes[j].turns]
    across: ComplexArray = lines.direction
    return {j: complex(-1j * across[np.flatnonzero(lines.bearing == j)[0]]) for j in guides}
