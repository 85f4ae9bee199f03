"""The equations of motion that are integrated over time: of the crank alone, or of all joints.

Each gives the linkage's accelerations in one state, under a torque on the crank and forces along coordinates. The crank alone is the
reduced model of `reduced_model`; all joints are those of Pinocchio's constraint dynamics, for any linkage.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from ...common.errors import PinpressError, SingularityError
from ...common.quantities import Array
from ...common.results import Record
from ...kinematics.cycle import motion_through_change_points
from ...linkage.linkage import Linkage
from ..driven_press import Coordinate, Length, WorkOfForce
from ..reduced_model import COORDINATES, INERTIA, WEIGHT, ReducedModel

if TYPE_CHECKING:
    from ...engines.pinocchio.forward_dynamics import ForwardDynamics


class Dynamics(Protocol):
    """The linkage as it is integrated: its crank alone, or all its joints.

    Attributes:
        size: number of positions, and of speeds.
        crank: place of the crank among them.
        alone: whether the crank is the only driver, so that the linkage is at rest whenever the crank is.
    """

    size: int
    crank: int
    alone: bool

    def at(self, position: Array, speed: Array) -> Any:
        """The state as forces need it: an object with the crank's ``angle`` and ``speed``, and the ``coordinates``, (value, rate) each."""

    def accelerations(self, instant: Any, torque: float, forces: Sequence[float], inertia: float) -> Any:
        """Accelerations (size,) in a state, as returned by `at`, under a torque on the crank and forces along the coordinates; ``inertia``:
        added to the crank [kg m2]."""

    def of_crank(self, accelerations: Any) -> float:
        """The crank's acceleration among these accelerations."""

    def stands(self, instant: Any) -> bool:
        """Whether the links are at rest in a state in which the crank is."""

    def move_crank(self, position: Array, angle: float) -> tuple[Array, Array]:
        """Positions at a crank angle that is a small ``angle`` away, and speeds that lead there."""

    def project(self, position: Array, speed: Array) -> tuple[Array, Array] | None:
        """The nearest state with closed loops; None if no loop can be open."""

    def close_loops(self, position: Array, speed: Array) -> tuple[Array, Array]:
        """States (size, n) with their loops closed."""


# ------------------------------------------------------------------------------------------------------------------------------ crank alone


class CrankState(NamedTuple):
    """A state of the crank."""

    angle: float  # [rad]
    speed: float  # [rad/s]
    coordinates: list[tuple[float, float]]  # their values and rates
    inertia: float  # I [kg m2]
    inertia_slope: float  # I' [kg m2/rad]
    weight: float  # V' [N m]
    levers: list[float]  # derivatives c' of the coordinates by the crank angle


class ReducedDynamics:
    """The crank alone, by a reduced model, whose one position is the crank angle."""

    size, crank, alone = 1, 0, True

    def __init__(self, table: ReducedModel) -> None:
        self.table = table
        self.gains = table.gains.tolist() if table.gains.any() else None
        self.first, self.last = float(table.borders[0]), float(table.borders[-1])

    def at(self, position: Array, speed: Array) -> CrankState:
        angle, rate = float(position[0]), float(speed[0])
        period, local, loose, turns = self.table.period, angle, 0.0, 0.0
        if period is not None:
            turns = (angle - self.first) // period
            # The rounding of many turns may leave an angle just outside the range.
            local, loose = angle - turns * period, 1e-6
        if not self.first - loose <= local <= self.last + loose:
            count = self.table.coefficients.shape[1] - COORDINATES  # NaN makes an integrator that looks ahead try a shorter step
            return CrankState(angle, rate, [(math.nan, math.nan)] * count, math.nan, math.nan, math.nan, [math.nan] * count)
        values, slopes = self.table.one(local)
        if self.gains is not None:
            values = [value + turns * gain for value, gain in zip(values, self.gains, strict=True)]
        levers = slopes[COORDINATES:]
        coordinates = [(value, lever * rate) for value, lever in zip(values[COORDINATES:], levers, strict=True)]
        return CrankState(angle, rate, coordinates, values[INERTIA], slopes[INERTIA], values[WEIGHT], levers)

    def accelerations(self, instant: CrankState, torque: float, forces: Sequence[float], inertia: float) -> float:
        total = instant.inertia + inertia
        if not total > 0:  # no mass resists; NaN makes an integrator try a shorter step
            return math.nan
        for row, force in enumerate(forces):
            torque += force * instant.levers[row]
        return (torque - instant.weight - 0.5 * instant.inertia_slope * instant.speed * instant.speed) / total

    def of_crank(self, accelerations: float) -> float:
        return float(np.ravel(accelerations)[0])

    def stands(self, instant: CrankState) -> bool:
        return True

    def move_crank(self, position: Array, angle: float) -> tuple[Array, Array]:
        return position + angle, np.array([1.0 if angle > 0 else -1.0])

    def project(self, position: Array, speed: Array) -> None:
        return None

    def close_loops(self, position: Array, speed: Array) -> tuple[Array, Array]:
        return position, speed


# ------------------------------------------------------------------------------------------------------------------------------- all joints


class LinkageState(NamedTuple):
    """A state of all joints."""

    angle: float  # of the first driver [rad]
    speed: float  # of the first driver [rad/s]
    coordinates: list[tuple[float, float]]  # their values and rates
    levers: list[Array]  # (nv,) their derivatives by the joint coordinates
    x: Array  # (nv,) joint coordinates
    v: Array  # (nv,) joint rates


@dataclass(frozen=True, repr=False)
class ConstraintSolution(Record, units={"mu": "1/kg", "tolerance": "N"}):
    """What found the accelerations of a run by method "constraint".

    Attributes:
        algorithm: "constraintDynamics", which is Pinocchio's; "null space" of the constraints, which is ours, with Pinocchio's mass matrix
            and forces; or both, the more frequent one first.
        reason: why that algorithm can be used; a state in which `constraintDynamics` would lose digits takes the null space.
        by_constraint_dynamics: number of states whose accelerations `constraintDynamics` found, those of the result among them.
        by_null_space: number of states whose accelerations the null space found.
        mu: Pinocchio's proximal parameter; None without `constraintDynamics`, as are the next two.
        iterations: most proximal iterations.
        tolerance: change of the multipliers at which iterations end.
    """

    algorithm: str
    reason: str
    by_constraint_dynamics: int
    by_null_space: int
    mu: float | None = None
    iterations: int | None = None
    tolerance: float | None = None


class FullDynamics:
    """All joints, one state at a time by `ForwardDynamics`; loops are kept closed by projection after every step."""

    def __init__(self, press: Linkage, coordinates: Sequence[Coordinate], inertia: Array, held: Collection[str] = ()) -> None:
        """Prepare what does not change with the state.

        Args:
            press: the linkage.
            coordinates: along which forces act.
            inertia: (drivers,) of flywheels and drives at the drivers [kg m2].
            held: names of motors whose speeds are held.
        """
        self.held = [press.joints.index(name) for name in held]
        self.press, self.size = press, len(press.joints)
        self.drivers, self.crank = list(press.driver_indices), press.driver_indices[0]
        self.coordinates, self.inertia = tuple(coordinates), inertia
        self.of_points = any(isinstance(coordinate, Length | WorkOfForce) for coordinate in coordinates)
        self.dynamics: dict[float, ForwardDynamics] = {}
        self.loops = self._with(float(inertia[0]))
        self.alone = len(self.drivers) == 1
        # where the crank turns fully on the drawn assembly, all states are closed at once from its angles
        self.turns = self.alone and press.branch_through_change_points.period is not None
        self.change_points = press.branch_through_change_points.change_points if self.alone else ()
        # speeds of joints as those of points [m/s]
        self.units = np.array([press.size if axis.turns else 1.0 for axis in press.axes])

    def _with(self, inertia: float) -> "ForwardDynamics":
        """The dynamics with this inertia on the crank: with the flywheel, or without it while the clutch is open."""
        if inertia not in self.dynamics:
            armature = np.zeros(self.size)
            armature[self.drivers] = self.inertia
            armature[self.crank] = inertia
            self.dynamics[inertia] = self.press.forward_dynamics(armature)
        return self.dynamics[inertia]

    def at(self, position: Array, speed: Array) -> LinkageState:
        coordinates, levers = [], []
        if self.of_points:
            self.loops.place(position)
        for coordinate in self.coordinates:
            value, lever = coordinate.at(self.loops, position)
            coordinates.append((value, float(lever.dot(speed))))
            levers.append(lever)
        return LinkageState(float(position[self.crank]), float(speed[self.crank]), coordinates, levers, position, speed)

    def accelerations(self, instant: LinkageState, torque: float, forces: Sequence[float], inertia: float) -> Array:
        if self.held:
            return self.holding(instant, forces)[0]
        efforts = self._efforts(instant, torque, forces)
        try:
            if (along := self._beside(instant.x)) is not None:
                return self._with(inertia).acceleration_along(*along, instant.speed, efforts)
            return self._with(inertia).acceleration(instant.x, instant.v, efforts)
        except PinpressError:  # NaN makes an integrator that looks ahead try a shorter step
            return np.full(self.size, np.nan)

    def _efforts(self, instant: LinkageState, torque: float, forces: Sequence[float]) -> Array:
        """Efforts (size,) of the joints under a torque on the crank and forces along the coordinates."""
        efforts = np.zeros(self.size)
        efforts[self.crank] = torque
        for force, lever in zip(forces, instant.levers, strict=False):
            if force:
                efforts += force * lever
        return efforts

    def holding(self, instant: LinkageState, forces: Sequence[float]) -> tuple[Array, Array]:
        """Accelerations (size,) under forces along the coordinates, and the efforts (held,) that hold the speeds of motors.

        Accelerations are linear in efforts, so that one more acceleration for each motor shows what holds them.
        """
        efforts, dynamics = self._efforts(instant, 0.0, forces), self._with(float(self.inertia[0]))
        try:
            a = dynamics.acceleration(instant.x, instant.v, efforts)
            pushed = efforts + np.eye(self.size)[self.held]
            answers = np.array([dynamics.acceleration(instant.x, instant.v, each) for each in pushed]) - a
            for _ in range(2):  # the second step takes off what differences of accelerations have left
                efforts[self.held] += np.linalg.solve(answers[:, self.held].T, -a[self.held])
                a = dynamics.acceleration(instant.x, instant.v, efforts)
        except (PinpressError, np.linalg.LinAlgError):  # NaN makes an integrator that looks ahead try a shorter step
            return np.full(self.size, np.nan), np.full(len(self.held), np.nan)
        a[self.held] = 0.0
        return a, efforts[self.held]

    def of_crank(self, accelerations: Array) -> float:
        return float(accelerations[self.crank])

    def stands(self, instant: LinkageState) -> bool:
        crank = self.units[self.crank] * abs(instant.speed)
        # A joint that is a thousand times as fast as the crank moves though the crank stands; one below 1e-6 m/s stands in any case.
        return bool(np.abs(self.units * instant.v).max() <= max(1e3 * crank, 1e-6))

    def move_crank(self, position: Array, angle: float) -> tuple[Array, Array]:
        closure = self.press.engine("pinocchio").close(np.array([position[self.crank] + angle]), position[:, None])
        return closure.position[:, 0], closure.first[:, 0] * np.sign(angle)

    def project(self, position: Array, speed: Array) -> tuple[Array, Array] | None:
        if (along := self._beside(position)) is not None:
            return along[0], along[1] * speed[self.crank]
        return self.loops.project(position, speed)[:2]

    def _beside(self, position: Array) -> tuple[Array, Array, Array] | None:
        """Joint coordinates and their first two derivatives by the crank angle (nv,) near a change point, where the equations of the
        loops do not determine them; None elsewhere.

        Raises:
            SingularityError: beyond a lock the linkage has come to the change point in another assembly than the drawn one.
        """
        for point in self.change_points:
            period = self.press.branch_through_change_points.period
            turns = 0.0 if period is None else round((position[self.crank] - point.angle) / period)
            angle = position[self.crank] - turns * (period or 0.0)
            if abs(angle - point.angle) < point.half:
                x, first, second = (values[:, 0] for values in point.at(np.array([angle])))
                x = x + turns * self.press.branch_through_change_points.gain_per_period
                x[self.crank] = position[self.crank]
                # A joint this far from the drawn assembly [rad, lengths of the linkage] is in another assembly.
                if np.abs(self.units * (x - position)).max() > 0.1 * self.press.size:
                    raise SingularityError("the linkage comes to a change point in another assembly than the drawn one", angle, 0.0)
                return x, first, second
        return None

    def close_loops(self, position: Array, speed: Array) -> tuple[Array, Array]:
        if self.turns:
            motion = motion_through_change_points(self.press, position[self.crank], speed[self.crank])
            return motion.joint_position.T, motion.v.T
        pairs = [self.loops.project(x, v)[:2] for x, v in zip(position.T.copy(), speed.T.copy(), strict=True)]
        states = np.array(pairs).transpose(1, 2, 0)
        return states[0], states[1]

    def solution(self) -> ConstraintSolution:
        """What has found the accelerations so far."""
        quick, reason = self.loops.quick, self.loops.why
        by_algorithm = {
            "constraintDynamics": sum(dynamics.quickly for dynamics in self.dynamics.values()),
            "null space": sum(dynamics.generally for dynamics in self.dynamics.values()),
        }
        used = sorted((name for name in by_algorithm if by_algorithm[name]), key=lambda name: -by_algorithm[name])
        algorithm = ", ".join(used) or ("null space" if quick is None else "constraintDynamics")
        settings = None if quick is None else quick.settings
        proximal = () if settings is None else (float(settings.mu), int(settings.max_iter), float(settings.relative_accuracy))
        return ConstraintSolution(algorithm, reason, *by_algorithm.values(), *proximal)

    def energy(self, y: Array) -> float:
        """Kinetic energy [J]; ``y``: positions, followed by speeds."""
        return self.loops.energy(y[: self.size], y[self.size :])[0]
