"""The forces of springs, contacts, friction and loads at states of a motion; a run reports them, and its energy is checked by them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...common.quantities import Array, ComplexArray
from ...engines.planar.model import to_world
from .contact import OpenPin
from .equations import ElasticEquations
from .panels import Indices
from .press.geometry import BodyState
from .press.paths import NEAREST
from .press.sprung_press import JointMotion, SprungPress


@dataclass(frozen=True, eq=False)
class ActingForces:
    """Forces on the bodies at n states.

    Attributes:
        equations: of motion, with their segments.
        times: (n,) [s].
        segments: (n,) in which the states are.
        bodies: the states.
    """

    equations: ElasticEquations
    times: Array
    segments: Indices
    bodies: BodyState

    @cached_property
    def along_paths(self) -> list[tuple[Array, Array]]:
        """Of each load, then of each contact, the force along its path (n,) [N], and the rate of the path (n,) [m/s]."""
        return self.equations.path_forces(self.times, self.segments, self.bodies)

    @property
    def _contacts(self) -> list[Array]:
        """Forces (n,) of all contacts along their paths [N]."""
        return [force for force, _ in self.along_paths[len(self.equations.driven.forces) :]]

    @cached_property
    def joints(self) -> list[tuple[JointMotion, Array]]:
        """The preloaded joints that may open, and the force (n,) of both members of each along its extension [N]."""
        sprung = self.equations.sprung
        members = self._contacts[len(sprung.open_pins) :]
        forces = (loaded + relieved for loaded, relieved in zip(members[::2], members[1::2], strict=True))
        return list(zip(sprung.joint_motions(self.bodies), forces, strict=True))

    @cached_property
    def in_bearings(self) -> Array:
        """Forces (bearings, n, 3) in world axes, parent on child, or link1 on link2 [N]."""
        sprung, friction = self.equations.sprung, self.equations.friction
        forces = sprung.bearing_forces(self.bodies)
        if friction is not None:
            for number, along in friction.along_guides(self.bodies).items():
                forces[number] += along
        for pin, force in zip(sprung.open_pins, self._contacts, strict=False):
            gap = journal_places(sprung, pin, self.bodies)
            forces[pin.bearing] = to_world(sprung.geometry.plane, -force * gap / np.maximum(np.abs(gap), NEAREST))
        for motion, force in self.joints:
            if motion.joint.bearing >= 0:
                forces[motion.joint.bearing] += force[:, None] * motion.along
        return forces

    def joint_loads(self) -> dict[str, Array]:
        """Load (n,) of each part with a preloaded joint, the mean where it yields at two bearings [N]."""
        pulls: dict[str, list[Array]] = {}
        for motion, force in self.joints:
            pulls.setdefault(motion.joint.name, []).append(motion.pull - force)
        return {name: np.mean(loads, axis=0) for name, loads in pulls.items()}

    def on_slide(self) -> Array:
        """Force (n,) of the pins on the slide along its direction [N]."""
        press = self.equations.driven.press
        slide, joints, pull = press.slide_guide.joint + 1, press.model.nv, np.zeros(len(self.times))
        for number, force in enumerate(self.in_bearings):
            if number < joints and not press.axes[number].turns:
                continue
            loop = None if number < joints else press.loops[number - joints]
            first, second = (press.model.parents[number + 1], number + 1) if loop is None else (loop.joint1, loop.joint2)
            if slide in (first, second):
                pull += force @ press.slide_direction * (1.0 if second == slide else -1.0)
        return pull

    def work_on_loads(self) -> Array:
        """Power (n,) that the loads take [W]."""
        return -sum((force * rate for force, rate in self.along_paths[: len(self.equations.driven.forces)]), np.zeros(len(self.times)))

    def lost_power(self) -> Array:
        """Power (n,) lost in dampers, friction and contacts; what the springs of a preloaded joint's members take is not lost [W]."""
        equations = self.equations
        lost = equations.sprung.lost_power(self.bodies)
        if equations.friction is not None:
            lost = lost + equations.friction.lost_power(self.bodies)
        for force, rate in self.along_paths[len(equations.driven.forces) :]:
            lost = lost - force * rate
        for motion, _ in self.joints:
            lost = lost + motion.joint.spring_force(motion.extension) * motion.rate
        return np.asarray(lost)


def journal_places(sprung: SprungPress, pin: OpenPin, state: BodyState) -> ComplexArray:
    """Centre (n,) of the second side of a pin from that of its first side, in the axes of the plane [m]."""
    first, second = (sprung.geometry.point(state, body, arm).place @ (1.0, 1j) for body, arm in zip(pin.bodies, pin.arms, strict=True))
    return np.asarray(second - first)
