"""The linkage with all its joints, by `ForwardDynamics`, one state at a time: for integration over time."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array
from ..common.errors import PinpressError
from ..engines.spatial.forward_dynamics import ForwardDynamics
from ..kinematics.motion import motion_through_change_points
from ..linkage.linkage import Linkage
from .driven_press import Coordinate
from .failures import failure

STANDING = 1e-6  # speed of a joint that stands [m/s]
MOVING = 1e3  # times the crank's speed, beyond which a joint moves though the crank stands


class LinkageState(NamedTuple):
    """A state: the first driver's angle and speed, coordinates with their rates, joint coordinates and rates (nv,)."""

    angle: float
    speed: float
    coordinates: list[tuple[float, float]]
    x: Array
    v: Array


class FullDynamics:
    """`hybrid_system.Dynamics` of all joint coordinates; loops are kept closed by projection after every step."""

    def __init__(self, press: Linkage, coordinates: Sequence[Coordinate], inertia: Array) -> None:
        """``inertia`` (drivers,) of flywheels and drives at the drivers [kg m2]."""
        self.press, self.size = press, len(press.joints)
        self.drivers, self.crank = list(press.driver_indices), press.driver_indices[0]
        self.coordinates, self.inertia = tuple(coordinates), inertia
        self.dynamics: dict[float, ForwardDynamics] = {}
        self.loops = self._with(float(inertia[0]))
        self.alone = len(self.drivers) == 1
        # where the crank turns on the drawn assembly, all states at once are closed from its angles
        self.turns = self.alone and press.branch_through_change_points.period is not None
        self.change_points = press.branch_through_change_points.change_points if self.alone else ()
        # speeds of joints as those of points [m/s]
        self.units = np.array([press.size if axis.turns else 1.0 for axis in press.axes])

    def _with(self, inertia: float) -> ForwardDynamics:
        """The dynamics with this inertia on the crank: with the flywheel, or with an open clutch without it."""
        if inertia not in self.dynamics:
            armature = np.zeros(self.size)
            armature[self.drivers] = self.inertia
            armature[self.crank] = inertia
            self.dynamics[inertia] = self.press.forward_dynamics(armature)
        return self.dynamics[inertia]

    def at(self, position: Array, speed: Array) -> LinkageState:
        coordinates = [coordinate.at(self.loops, position, speed) for coordinate in self.coordinates]
        return LinkageState(float(position[self.crank]), float(speed[self.crank]), coordinates, position, speed)

    def accelerations(self, instant: LinkageState, torque: float, forces: Sequence[float], inertia: float) -> Array:
        efforts = np.zeros(self.size)
        efforts[self.crank] = torque
        for row, force in enumerate(forces):
            if force:
                efforts += self.coordinates[row].efforts(self.loops, instant.x, force)
        try:
            if (along := self._beside(instant.x)) is not None:
                return self._with(inertia).acceleration_along(*along, instant.speed, efforts)
            return self._with(inertia).acceleration(instant.x, instant.v, efforts)
        except PinpressError:  # an integrator looks ahead: it shall try a shorter step
            return np.full(self.size, np.nan)

    def of_crank(self, accelerations: Array) -> float:
        return float(accelerations[self.crank])

    def stands(self, instant: LinkageState, time: float) -> None:
        crank = self.units[self.crank] * abs(instant.speed)
        if float(np.abs(self.units * instant.v).max()) > max(MOVING * crank, STANDING):
            raise failure("stops at a lock", time, instant.angle)

    def moved(self, position: Array, angle: float) -> tuple[Array, Array]:
        closure = self.press.engine("pinocchio").close(np.array([position[self.crank] + angle]), position[:, None])
        return closure.position[:, 0], closure.first[:, 0] * np.sign(angle)

    def project(self, position: Array, speed: Array) -> tuple[Array, Array] | None:
        if (along := self._beside(position)) is not None:
            return along[0], along[1] * speed[self.crank]
        return self.loops.project(position, speed)[:2]

    def _beside(self, position: Array) -> tuple[Array, Array, Array] | None:
        """Joint coordinates and their first two derivatives by the crank angle (nv,) beside a change point, where the equations of the
        loops say too little; None elsewhere."""
        for point in self.change_points:
            period = self.press.branch_through_change_points.period
            turns = 0.0 if period is None else round((position[self.crank] - point.angle) / period)
            angle = position[self.crank] - turns * (period or 0.0)
            if abs(angle - point.angle) < point.half:
                at, first, second = (values[:, 0] for values in point.at(np.array([angle])))
                at = at + turns * self.press.branch_through_change_points.advance
                at[self.crank] = position[self.crank]
                return at, first, second
        return None

    def closed(self, position: Array, speed: Array) -> tuple[Array, Array]:
        if self.turns:
            motion = motion_through_change_points(self.press, position[self.crank], speed[self.crank])
            return motion.joint_position.T, motion.v.T
        pairs = [self.loops.project(x, v)[:2] for x, v in zip(position.T.copy(), speed.T.copy(), strict=True)]
        states = np.array(pairs).transpose(1, 2, 0)
        return states[0], states[1]

    def energy(self, y: Array) -> float:
        """Kinetic energy of positions and speeds, one after the other [J]."""
        return self.loops.energy(y[: self.size], y[self.size :])[0]
