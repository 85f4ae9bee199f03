"""The linkage with all its joints, by Pinocchio's constraint dynamics, one state at a time: for integration over time."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .coordinates import Array
from .errors import PinpressError
from .forward_dynamics import ForwardDynamics
from .linkage import Linkage
from .scene import Coordinate


class Instant(NamedTuple):
    """A state: the first driver's angle and speed, coordinates with their rates, joint coordinates and rates (nv,)."""

    angle: float
    speed: float
    coordinates: list[tuple[float, float]]
    x: Array
    v: Array


class AllJoints:
    """`machine.Dynamics` of all joint coordinates; loops are kept closed by projection after every step."""

    def __init__(self, press: Linkage, coordinates: Sequence[Coordinate], inertia: Array) -> None:
        """``inertia`` (drivers,) of flywheels and drives at the drivers [kg m2]."""
        self.press, self.size = press, len(press.joints)
        self.drivers, self.driver = list(press.spatial.drivers), press.spatial.drivers[0]
        self.coordinates = tuple(coordinates)
        self.inertia = inertia
        self.dynamics: dict[float, ForwardDynamics] = {}
        self.loops = self._with(float(inertia[0]))
        self.trouble: PinpressError | None = None

    def _with(self, inertia: float) -> ForwardDynamics:
        if inertia not in self.dynamics:
            armature = np.zeros(self.size)
            armature[self.drivers] = self.inertia
            armature[self.driver] = inertia
            self.dynamics[inertia] = ForwardDynamics(self.press, armature)
        return self.dynamics[inertia]

    def at(self, position: Array, speed: Array) -> Instant:
        coordinates = [coordinate.at(self.loops, position, speed) for coordinate in self.coordinates]
        return Instant(float(position[self.driver]), float(speed[self.driver]), coordinates, position, speed)

    def accelerations(self, instant: Instant, torque: float, forces: Sequence[float], inertia: float) -> Array:
        efforts = np.zeros(self.size)
        efforts[self.driver] = torque
        for coordinate, force in zip(self.coordinates, forces, strict=True):
            if force:
                efforts += coordinate.efforts(self.loops, instant.x, force)
        try:
            return self._with(inertia).acceleration(instant.x, instant.v, efforts)
        except PinpressError as error:  # an integrator looks ahead: it shall try a shorter step
            self.trouble = error
            return np.full(self.size, np.nan)

    def of_crank(self, accelerations: Array) -> float:
        return float(accelerations[self.driver])

    def moved(self, position: Array, angle: float) -> tuple[Array, Array]:
        closure = self.press.close(np.array([position[self.driver] + angle]), position[:, None], "pinocchio")
        return closure.position[:, 0], closure.first[:, 0] * np.sign(angle)

    def project(self, position: Array, speed: Array) -> tuple[Array, Array] | None:
        return self.loops.project(position, speed)[:2]
