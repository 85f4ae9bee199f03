"""Coordinates of a linkage along which forces act: the slide's position, a joint's angle, the length of a spring, the path of a point.

The reduced method has them as functions of the crank angle, the other one works them out state by state.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ..common.arrays import Array
from ..kinematics.motion import Motion
from ..kinematics.point_motion import point_motion
from ..linkage.linkage import Linkage

if TYPE_CHECKING:
    from ..engines.spatial.forward_dynamics import ForwardDynamics

End = tuple[int, Array]
"""Pinocchio joint (0: the frame) and a point in its frame [m]."""


class Coordinate(Protocol):
    """A length of the linkage along which a force acts."""

    def over(self, press: Linkage, motion: Motion) -> Array:
        """Its values (n,) over a motion [m]."""

    def at(self, dynamics: "ForwardDynamics", x: Array, v: Array) -> tuple[float, float]:
        """Its value and rate in one state [m, m/s]."""

    def efforts(self, dynamics: "ForwardDynamics", x: Array, force: float) -> Array:
        """Joint efforts (nv,) of a force along it."""


@dataclass(frozen=True)
class SlidePosition:
    """Position of the slide along its guide's axis; ``guide`` its place in v, ``offset`` its position in the drawn pose."""

    guide: int
    offset: float

    def over(self, press: Linkage, motion: Motion) -> Array:
        return motion.joint_position[:, self.guide] + self.offset

    def at(self, dynamics: "ForwardDynamics", x: Array, v: Array) -> tuple[float, float]:
        return float(x[self.guide]) + self.offset, float(v[self.guide])

    def efforts(self, dynamics: "ForwardDynamics", x: Array, force: float) -> Array:
        result = np.zeros(len(x))
        result[self.guide] = force
        return result


@dataclass(frozen=True)
class JointAngle:
    """Angle of a joint, by its place in v; a force along it is a torque."""

    joint: int

    def over(self, press: Linkage, motion: Motion) -> Array:
        return motion.joint_position[:, self.joint]

    def at(self, dynamics: "ForwardDynamics", x: Array, v: Array) -> tuple[float, float]:
        return float(x[self.joint]), float(v[self.joint])

    def efforts(self, dynamics: "ForwardDynamics", x: Array, force: float) -> Array:
        result = np.zeros(len(x))
        result[self.joint] = force
        return result


@dataclass(frozen=True, eq=False)
class Length:
    """Distance between two points of links."""

    first: End
    second: End

    def over(self, press: Linkage, motion: Motion) -> Array:
        ends = [point_motion(press, motion, *end)[0] for end in (self.first, self.second)]
        return np.asarray(np.linalg.norm(ends[1] - ends[0], axis=1))

    def at(self, dynamics: "ForwardDynamics", x: Array, v: Array) -> tuple[float, float]:
        between, rate, length = self._between(dynamics, x, v)
        return length, float(between @ rate) / length

    def efforts(self, dynamics: "ForwardDynamics", x: Array, force: float) -> Array:
        between, _, length = self._between(dynamics, x, np.zeros(len(x)))
        along = force / length * between
        return dynamics.point_efforts(x, *self.second, along) - dynamics.point_efforts(x, *self.first, along)

    def _between(self, dynamics: "ForwardDynamics", x: Array, v: Array) -> tuple[Array, Array, float]:
        (first, speed1), (second, speed2) = (dynamics.point(x, v, *end) for end in (self.first, self.second))
        length = float(np.linalg.norm(second - first))
        return second - first, speed2 - speed1, length


@dataclass(frozen=True, eq=False)
class Path:
    """Work of a constant force (3,) at a point, in world axes [J]; a force of one along it is that force."""

    end: End
    force: Array

    def over(self, press: Linkage, motion: Motion) -> Array:
        return np.asarray(point_motion(press, motion, *self.end)[0] @ self.force)

    def at(self, dynamics: "ForwardDynamics", x: Array, v: Array) -> tuple[float, float]:
        position, velocity = dynamics.point(x, v, *self.end)
        return float(position @ self.force), float(velocity @ self.force)

    def efforts(self, dynamics: "ForwardDynamics", x: Array, force: float) -> Array:
        return dynamics.point_efforts(x, *self.end, force * self.force)
