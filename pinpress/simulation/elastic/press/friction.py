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
from ....common.quantities import Array
from ....engines.friction import FrictionLaw
from .geometry import BodyState
from .plane import LineStrains, PlaneGeometry
from .sprung_press import SpringForces, SprungPress


class FrictionStates(NamedTuple):
    """Friction of K bearings at n states.

    Attributes:
        strains: of the springs' lines.
        sliding: of lines along the axes of the guides.
        pulls: (n, S) of the springs [N].
        pressing: (n, K) forces with which the bearings press [N].
        speed: (n, K) at which their sides turn or slide against each other.
        efforts: (n, K) of friction, against it [N m, of a guide N].
    """

    strains: LineStrains
    sliding: LineStrains
    pulls: Array
    pressing: Array
    speed: Array
    efforts: Array


@dataclass(frozen=True, eq=False)
class BearingFriction:
    """Friction of some bearings of a press; see `bearing_friction`.

    Attributes:
        sprung: the press.
        slides: its bodies with lines along the axes of its guides with friction.
        guides: numbers of these guides.
        arm: (K,) friction by the force of the bearing, pins first [m, of a guide -].
        viscous: (K,) friction by speed.
        slow: (K,) speeds below which a bearing creeps.
        angles: (pins, 3 (bodies + 1)) all rates to the turning speeds of the pins.
        owners: (S, K) 1 where a spring is of this bearing.
        preload: (K,) least forces with which bearings press [N].
    """

    sprung: SprungPress
    slides: PlaneGeometry
    guides: tuple[int, ...]
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

    def at(self, state: BodyState) -> FrictionStates:
        """At n states."""
        sprung = self.sprung
        strains, sliding = sprung.geometry.strains(state), self.slides.strains(state)  # type: ignore[arg-type]
        pulls = sprung.pulls(strains)
        for joint in sprung.open_joints:
            pulls[:, joint.spring] += joint.spring_force(strains.extension[:, joint.spring])
        pressing = np.maximum(np.sqrt((pulls * pulls) @ self.owners), self.preload)
        speed = np.concatenate([state.rates @ self.angles.T, sliding.opening], axis=1)
        efforts = -(self.arm * pressing * np.tanh(speed / self.slow) + self.viscous * speed)
        return FrictionStates(strains, sliding, pulls, pressing, speed, efforts)

    def lost_power(self, state: BodyState) -> Array:
        """(n,) [W]."""
        rubbing = self.at(state)
        return -np.asarray((rubbing.efforts * rubbing.speed).sum(axis=1))

    def along_guides(self, state: BodyState) -> dict[int, Array]:
        """Friction (n, 3) of the guides on the links that slide in them, in world axes, by the numbers of the guides [N]."""
        rubbing, pins = self.at(state), len(self.angles)
        along = self.slides.along(rubbing.sliding)
        return {number: rubbing.efforts[:, pins + k, None] * along[:, k] for k, number in enumerate(self.guides)}

    def forces(self, state: BodyState, derivatives: bool = True) -> SpringForces:
        """Forces on the free coordinates."""
        rubbing, springs, sprung, slides = self.at(state), self.sprung.springs, self.sprung, self.slides
        pins, count = len(self.angles), len(state.rates)
        turning = np.broadcast_to(self._turning, (count, *self._turning.shape))
        gradient = np.concatenate([turning, sprung.to_free(slides.gradient(rubbing.sliding))], axis=1)
        force = np.matmul(rubbing.efforts[:, None, :], gradient)[:, 0]
        if not derivatives:
            return SpringForces(force, None, None)
        turned = np.zeros_like(gradient)  # derivatives of the speeds by the coordinates
        turned[:, pins:] = sprung.to_free(slides.gradient_rate(rubbing.sliding))
        geometry = sprung.geometry
        opening = sprung.to_free(geometry.gradient(rubbing.strains))
        stiffness = np.tile(springs.stiffness, (count, 1))
        for joint in sprung.open_joints:
            stiffness[:, joint.spring] += joint.spring_slope(rubbing.strains.extension[:, joint.spring])
        by_place = stiffness[:, :, None] * opening + springs.damping[:, None] * sprung.to_free(geometry.gradient_rate(rubbing.strains))
        share = np.tanh(rubbing.speed / self.slow)
        steep = self.arm * rubbing.pressing * (1 - share * share) / self.slow + self.viscous
        moving = (rubbing.pressing > self.preload)[:, None, :]  # not held by the preload
        along = -(rubbing.pulls[:, :, None] * self.owners) / np.maximum(rubbing.pressing, 1e-300)[:, None, :] * moving  # (n, S, K)
        pressed = (self.arm * share)[:, None, :] * along
        effort_by_place = np.matmul(pressed.transpose(0, 2, 1), by_place) + steep[:, :, None] * turned
        effort_by_rate = np.matmul(pressed.transpose(0, 2, 1), springs.damping[:, None] * opening) + steep[:, :, None] * gradient
        across, bend = gradient.transpose(0, 2, 1), sprung.to_free_twice(slides.bend(rubbing.sliding, rubbing.efforts[:, pins:]))
        return SpringForces(force, np.matmul(across, effort_by_place) - bend, np.matmul(across, effort_by_rate))


def bearing_friction(sprung: SprungPress, law: FrictionLaw, speed: float) -> BearingFriction:
    """Friction of the bearings of a press that runs at about a speed of its crank [rad/s].

    Raises:
        PinpressError: the press moves in space, a pin with friction has clearance, or a guide has a preload and a `PreloadedJoint`.
    """
    press, rubbing = sprung.press, np.flatnonzero((law.arm > 0) | (law.viscous > 0))
    if not isinstance(sprung.geometry, PlaneGeometry):
        raise PinpressError(f"{press.name} moves in space: on its springs it has no friction; leave it out")
    for pin in sprung.open_pins:
        if pin.bearing in rubbing:
            raise PinpressError(f"{shown(press.bearings[pin.bearing])} has clearance: give it no friction, or no clearance")
    geometry, directions = sprung.geometry, _guides(sprung)
    gibs = {joint.bearing: 2 * joint.joint.preload for joint in sprung.joints if joint.bearing in rubbing and joint.bearing in directions}
    for number in gibs:
        if law.preload[number]:
            raise PinpressError(
                f"friction of {shown(press.bearings[number])}: its gibs are a PreloadedJoint, whose forces rub: leave preload out"
            )
    pins = [int(number) for number in rubbing if number not in directions]
    guides = [int(number) for number in rubbing if number in directions]
    angles = np.zeros((len(pins), len(sprung.drawn)))
    for row, number in enumerate(pins):
        first, second = bodies_of(sprung, number)
        angles[row, 3 * first + 2], angles[row, 3 * second + 2] = -1.0, 1.0
    slides = geometry.with_lines([_first_line(sprung, number) for number in guides])
    directed = slides.lines._replace(direction=np.array([directions[number] for number in guides], dtype=complex))
    order = pins + guides
    # At a thousandth of the crank's speed friction does not yet have its whole size: a joint that it holds creeps with less.
    slow = 1e-3 * abs(speed) * np.where(np.arange(len(order)) < len(pins), 1.0, press.size)
    owners = (sprung.springs.bearing[:, None] == np.array(order)).astype(float)
    preload = np.array([gibs.get(number, law.preload[number]) for number in order])
    slides = replace(slides, lines=directed)
    return BearingFriction(sprung, slides, tuple(guides), law.arm[order], law.viscous[order], slow, angles, owners, preload)


def bodies_of(sprung: SprungPress, bearing: int) -> tuple[int, int]:
    """The bodies that a bearing of a planar press joins, the acting one first."""
    whole = sprung.closed or sprung
    line = _first_line(whole, bearing)
    bodies = int(whole.geometry.lines.first[line]), int(whole.geometry.lines.second[line])
    return bodies if whole.springs.sign[line] > 0 else bodies[::-1]


def _guides(sprung: SprungPress) -> dict[int, complex]:
    """Directions of the guides' axes in the drawn pose, by the numbers of their bearings."""
    guides = [j for j in range(sprung.press.model.nv) if not sprung.press.axes[j].turns]
    return {j: complex(-1j * sprung.geometry.lines.direction[_first_line(sprung, j)]) for j in guides}


def _first_line(sprung: SprungPress, bearing: int) -> int:
    return int(np.flatnonzero(sprung.springs.bearing == bearing)[0])
