"""The forces of drive, loads and friction at the nodes of a mesh."""

import numpy as np

from ...common.quantities import Array
from ...drives.protocol import Drive
from ..bearing_model import BearingStates
from .mesh import AngleMesh, PanelForce


class Forces:
    """Forces of drive, loads and friction on a mesh, along the travel, at changing speeds. Loads that do not depend on speed are computed
    once.

    Attributes:
        driving: (q, p, S) of the drive, as last computed [N m].
        resisting: (q, p, S) of the loads, as last computed [N m].
        friction_torque: (q, p, S) of friction in the bearings, as last computed [N m]; None for none.
        total: (q, p, S) sum of them, as last computed [N m].
        asked: number of times that they were computed.
    """

    def __init__(self, drive: Drive | None, mesh: AngleMesh, inertia: Array, shape: tuple[int, ...]) -> None:
        self.drive, self.mesh, self.inertia, self.asked = drive, mesh, inertia, 0
        self.driving, self.resisting = np.zeros(shape), np.zeros(shape)
        self.friction_torque: Array | None = None
        self.efforts: Array | None = None  # of friction, from which the next ones are found
        self.total = self.driving
        # as declared: a load that is the same at some speeds, as one that only acts above one, may be another at those of a later round
        self.constant = not any(force.interval.heeds_velocity for force in mesh.forces)
        self.known = not mesh.forces  # whether the loads are, whatever the speed

    @property
    def vary(self) -> bool:
        """Whether loads or friction depend on the speed."""
        return not self.constant or self.mesh.bearings is not None

    def at(self, speed: Array) -> Array:
        """Sum of the forces at sizes of the crank's speed (q, p, S)."""
        self.driving = self.driving_at(speed)
        if not self.known:
            self.resisting, self.known = self.resisting_at(speed), self.constant
        if self.mesh.bearings is not None:
            self.friction_torque = self._friction(self.mesh.bearings, speed, self.driving + self.resisting)
        acting = self.driving + self.resisting if self.mesh.forces else self.driving
        self.total = acting if self.friction_torque is None else acting + self.friction_torque
        self.asked += 1
        return self.total

    def faster(self, speed: Array, share: float) -> Array:
        """Change of the sum where the crank is faster by a share than at the last `at`."""
        higher = speed * (1 + share)
        driving, resisting = self.driving_at(higher), self.resisting
        change = driving - self.driving
        if not self.constant:
            resisting = self.resisting_at(higher)
            change += resisting - self.resisting
        if self.mesh.bearings is not None and self.friction_torque is not None:
            change += self._friction(self.mesh.bearings, higher, driving + resisting) - self.friction_torque
        self.asked += 1
        return np.asarray(change)

    def driving_at(self, speed: Array) -> Array:
        """Torque (q, p, S) of the drive alone at speeds (q, p, S)."""
        if self.drive is None:
            return np.zeros_like(self.driving)
        torque = np.asarray(self.drive.torque(speed if self.mesh.direction > 0 else -speed))
        signed = torque if self.mesh.direction > 0 else -torque
        return signed if signed.shape == speed.shape else signed + np.zeros_like(self.driving)

    def resisting_at(self, speed: Array) -> Array:
        """Torque (q, p, S) of the loads alone at speeds (q, p, S)."""
        result = np.zeros_like(self.driving)
        for force in self.mesh.forces:
            result[:, force.panels] += along_travel(self.mesh, force, self.mesh.direction * speed)
        return result

    def _friction(self, bearings: BearingStates, speed: Array, acting: Array) -> Array:
        """Torque of friction (q, p, S) under torques of drive and loads."""
        mesh = self.mesh
        net = acting + mesh.weight[:, :, None] - 0.5 * mesh.direction * mesh.slope[:, :, None] * speed**2
        friction_torque, self.efforts = friction_torque_at(mesh, bearings, speed, net, self.inertia, self.efforts)
        return friction_torque


def friction_torque_at(
    mesh: AngleMesh, bearings: BearingStates, speed: Array, net: Array, inertia: Array, start: Array | None = None
) -> tuple[Array, Array]:
    """Torque of friction (q, p, S) along the travel, and its efforts; arrays are those of `BearingStates.torque`, as (q, p, S)."""
    q, p, count = speed.shape
    along: dict[int, Array] = {}
    for force in mesh.forces:
        on_coordinate = along.setdefault(force.row, np.zeros(speed.shape))
        on_coordinate[:, force.panels] += _size(mesh, force, mesh.direction * speed)
    rate, acting, resisting = (values.reshape(q * p, -1) for values in (speed, net, inertia))
    forces = {row: force.reshape(q * p, count) for row, force in along.items()}
    torque, efforts = bearings.torque(mesh.direction, rate, acting, resisting, forces, start)
    return torque.reshape(speed.shape), efforts


def along_travel(mesh: AngleMesh, force: PanelForce, speed: Array) -> Array:
    """A force along the travel (q, its panels, S) [N m], at the crank's speeds (q, p, S)."""
    return np.asarray(mesh.direction * mesh.lever[force.row][:, force.panels, None] * _size(mesh, force, speed))


def along_travel_at_ends(mesh: AngleMesh, force: PanelForce, speed: Array) -> Array:
    """A force along the travel (2, its panels, S) [N m] at the start and the end of each of its panels, at the crank's speeds (p + 1, S) at
    the borders."""
    ends = np.stack([force.panels, force.panels + 1])
    lever = mesh.lever_ends[force.row][ends, None]
    size = force.interval.force(mesh.position_ends[force.row][ends, None] - force.datum, lever * speed[ends])
    return np.asarray(mesh.direction * lever * force.interval.acting(size))


def _size(mesh: AngleMesh, force: PanelForce, speed: Array) -> Array:
    """A force along its coordinate (q, its panels, S) [N], at the crank's speeds (q, p, S)."""
    position = mesh.position[force.row][:, force.panels, None] - force.datum
    lever = mesh.lever[force.row][:, force.panels, None]
    size = force.interval.force(position, lever * speed[:, force.panels])
    return np.asarray(force.interval.acting(size))
