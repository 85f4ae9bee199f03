"""A press with its drives and loads, as every solver of a simulation sees it.

Every force from outside acts along a coordinate of the linkage: a process load along the slide's position, a spring along its length, a
constant force along the path of its point, a further drive along its joint's angle. The reduced equation has the coordinates as functions
of the crank angle; the equations of all joints compute them state by state.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.frozen import read_only
from ..common.quantities import GRAVITY, Array, Values
from ..drives.electric import ElectricMotor
from ..drives.protocol import Drive, SpeedTorqueDrive, corners_of
from ..drives.transmission import Brake, Clutch, Flywheel, Geared, PrescribedSpeed, innermost
from ..dynamics import applied_loads
from ..dynamics.inverse_dynamics import NONE_GIVEN
from ..engines.friction import FrictionLaw
from ..engines.structure import drawn_placements
from ..engines.wrenches import AppliedForce
from ..kinematics.cycle import slide_at
from ..kinematics.motion import Motion
from ..kinematics.poses import body_of, point_motion
from ..linkage.linkage import Linkage
from ..loads import caller_laws
from ..loads.link import Friction, Load, PointForce, PointMoment, SpringDamper, TorsionSpring, is_constant, law
from ..loads.process import ForceInterval, ProcessLoad, TimeForce, datum
from .bearing_model import BearingModel, build_bearing_model
from .reduced_model import (
    COORDINATES,
    INERTIA,
    ReducedModel,
    build_reduced_model,
    places_of,
    reduced_model_of,
)

if TYPE_CHECKING:
    from ..engines.pinocchio.forward_dynamics import ForwardDynamics


MotorFunction = Callable[[float, Array, Array], ArrayLike]
"""Efforts (motors,) of all motors of a linkage [N m or N] by time [s], positions (motors,) [rad or m] and speeds (motors,) [rad/s or
m/s]."""

End = tuple[int, Array]
"""Pinocchio joint (0: the frame) and a point in its frame [m]."""


class Coordinate(Protocol):
    """A length of the linkage along which a force acts."""

    def over(self, press: Linkage, motion: Motion) -> Array:
        """Its values (n,) over a motion [m]."""

    def at(self, dynamics: "ForwardDynamics", x: Array) -> tuple[float, Array]:
        """Its value [m] at joint coordinates (nv,) at which the links are placed, and its derivatives (nv,) by them, which are the joint
        efforts of a force of 1 along it."""

    def unit_force(self, press: Linkage, motion: Motion) -> list[AppliedForce]:
        """The forces on links over a motion for which a force of 1 along it stands."""


@dataclass(frozen=True)
class JointPosition:
    """Position of a joint: the angle of a pin, along which a force is a torque, or where a slide stands along its guide.

    Attributes:
        joint: its place in v.
        offset: where the joint's own coordinate is zero.
        sign: 1, or -1 where it counts against the joint's own coordinate.
    """

    joint: int
    offset: float = 0.0
    sign: float = 1.0

    def over(self, press: Linkage, motion: Motion) -> Array:
        return self.sign * motion.joint_position[:, self.joint] + self.offset

    def at(self, dynamics: "ForwardDynamics", x: Array) -> tuple[float, Array]:
        lever = np.zeros(len(x))
        lever[self.joint] = self.sign
        return self.sign * float(x[self.joint]) + self.offset, lever

    def unit_force(self, press: Linkage, motion: Motion) -> list[AppliedForce]:
        assert press.slide is not None  # with one driver it is the slide's
        along = np.tile(press.slide_direction, (len(motion.crank_angle), 1))
        return [AppliedForce(press.slide_guide.joint + 1, press.tool.in_body, along)]


@dataclass(frozen=True, eq=False)
class Length:
    """Distance between two points of links.

    Attributes:
        first: one point.
        second: the other point.
    """

    first: End
    second: End

    def over(self, press: Linkage, motion: Motion) -> Array:
        ends = [point_motion(press, motion, *end)[0] for end in (self.first, self.second)]
        return np.asarray(np.linalg.norm(ends[1] - ends[0], axis=1))

    def at(self, dynamics: "ForwardDynamics", x: Array) -> tuple[float, Array]:
        along = dynamics.point(*self.second) - dynamics.point(*self.first)
        length = math.sqrt(along.dot(along))
        along /= length
        return length, dynamics.point_efforts(*self.second, along) - dynamics.point_efforts(*self.first, along)

    def unit_force(self, press: Linkage, motion: Motion) -> list[AppliedForce]:
        first, second = (point_motion(press, motion, *end)[0] for end in (self.first, self.second))
        along = (second - first) / np.linalg.norm(second - first, axis=1)[:, None]
        return [AppliedForce(*self.first, -along), AppliedForce(*self.second, along)]


@dataclass(frozen=True, eq=False)
class Turn:
    """Angle of a link against another [rad], along which a force is a moment.

    Attributes:
        turn: the two links, and the joints whose angles add up to it.
    """

    turn: applied_loads.RelativeTurn

    def over(self, press: Linkage, motion: Motion) -> Array:
        return self.turn.angle(motion.joint_position)

    def at(self, dynamics: "ForwardDynamics", x: Array) -> tuple[float, Array]:
        return float(x.dot(self.turn.by)), self.turn.by

    def unit_force(self, press: Linkage, motion: Motion) -> list[AppliedForce]:
        return applied_loads.turn_forces(press, motion, self.turn, np.ones(len(motion.crank_angle)))


@dataclass(frozen=True, eq=False)
class WorkOfForce:
    """Work of a constant force at a point of a link [J]. A generalized force of 1 along this coordinate is that force.

    Attributes:
        end: the point.
        force: (3,) in world axes [N].
    """

    end: End
    force: Array

    def over(self, press: Linkage, motion: Motion) -> Array:
        return np.asarray(point_motion(press, motion, *self.end)[0] @ self.force)

    def at(self, dynamics: "ForwardDynamics", x: Array) -> tuple[float, Array]:
        return float(dynamics.point(*self.end).dot(self.force)), dynamics.point_efforts(*self.end, self.force)

    def unit_force(self, press: Linkage, motion: Motion) -> list[AppliedForce]:
        return [AppliedForce(*self.end, np.tile(self.force, (len(motion.crank_angle), 1)))]


@dataclass(frozen=True, eq=False)
class WorkOfMoment:
    """Work of a constant moment on a link that turns about one axis in the frame [J]. A generalized force of 1 along it is that moment.

    Attributes:
        joint: Pinocchio joint of the link's body.
        moment: (3,) in world axes [N m].
        by: (nv,) derivatives of the work by the joint coordinates.
        braced: whether the frame takes the opposite moment.
    """

    joint: int
    moment: Array
    by: Array
    braced: bool

    def over(self, press: Linkage, motion: Motion) -> Array:
        return np.asarray(motion.joint_position @ self.by)

    def at(self, dynamics: "ForwardDynamics", x: Array) -> tuple[float, Array]:
        return float(x.dot(self.by)), self.by

    def unit_force(self, press: Linkage, motion: Motion) -> list[AppliedForce]:
        return [AppliedForce.couple(self.joint, np.tile(self.moment, (len(motion.crank_angle), 1)))]


@dataclass(frozen=True, eq=False)
class GeneralizedForce:
    """A force along a coordinate of the press.

    Attributes:
        row: of the coordinate.
        datum: value of the coordinate from which the intervals count [m].
        rising: intervals that act while the coordinate rises.
        falling: intervals that act while it falls; the same object where the direction does not matter.
        time: the force as a function of time [s], in place of the intervals.
        edges: instants at which that is not smooth [s].
        drive: the drive whose torque along this angle it is, in place of the intervals; None: a load.
    """

    row: int
    datum: float
    rising: tuple[ForceInterval, ...] = ()
    falling: tuple[ForceInterval, ...] = ()
    time: Callable[[Any], Any] | None = None
    edges: tuple[float, ...] = ()
    drive: Drive | None = None

    def intervals(self, rising: bool) -> tuple[ForceInterval, ...]:
        return self.rising if rising else self.falling

    @property
    def works_once(self) -> bool:
        """Whether it acts on the way down and pushes nothing on the way up, as on a part that it changes for good."""
        return self.rising is not self.falling and all(float(np.max(up.force(up.upper, 0.0))) < 0 for up in self.rising)

    def borders(self) -> tuple[float, ...]:
        """Values of the coordinate at which the force is not smooth."""
        ends = {end for interval in self.rising + self.falling for end in (interval.lower, interval.upper)}
        return tuple(sorted(self.datum + end for end in ends if math.isfinite(end)))


@dataclass(frozen=True, eq=False)
class DriveByFunction(SpeedTorqueDrive):
    """A caller's `MotorFunction` as the drive of a single driver."""

    function: MotorFunction
    inertia, rated_torque, timed = 0.0, None, True

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        states = np.broadcast(time, angle, speed)
        efforts = [np.reshape(self.function(at, np.array([place]), np.array([rate])), ()) for at, place, rate in states]
        return np.array(efforts, dtype=float).reshape(states.shape) if states.shape else float(efforts[0])


def is_motor_function(drive: object) -> TypeGuard[MotorFunction]:
    """Whether a drive is given as a function of the state of all motors."""
    return callable(drive) and not isinstance(drive, type | Drive)


@dataclass(frozen=True, eq=False)
class MotorLaw:
    """A caller's function of the state of all motors of a linkage with several drivers, such as a controller.

    Attributes:
        law: of time [s], positions (motors,) and speeds (motors,): the motors' efforts (motors,) [N m or N].
        rows: the coordinates of the motors, by their indices.
    """

    law: caller_laws.Law
    rows: tuple[int, ...]

    def among(self, time: float, coordinates: Sequence[tuple[float, float]]) -> Array:
        """The efforts at a time [s], by the values and rates of all coordinates of a `DrivenPress`; raises as `efforts`."""
        return self.efforts(time, *np.array([coordinates[row] for row in self.rows]).T)

    def efforts(self, time: float, positions: Array, speeds: Array) -> Array:
        """The efforts at a time [s], by positions and speeds (motors,).

        Raises:
            LawError: the function fails, or does not return a finite number for each motor.
        """
        efforts = np.asarray(self.law(time, positions, speeds), dtype=float)
        if efforts.shape != positions.shape:
            raise caller_laws.LawError(f"drive gives efforts of shape {efforts.shape}; give {positions.shape}, one for each motor")
        return efforts


@dataclass(frozen=True, eq=False)
class DrivenPress:
    """What is simulated: a press, its drives, and the forces on it.

    Attributes:
        press: the linkage.
        inertia: of flywheel and drive at the (first) driver, a number or (S,) for S scenarios [kg m2].
        inertias: of flywheel and drive at every driver, (drivers,) or (1, S) [kg m2].
        coordinates: along which forces act; that of the slide comes first, if there is a slide.
        forces: of the loads, and of the drives where there are several drivers.
        drive: gives the torque on the one driver; None: nothing drives it, its speed is prescribed, or the linkage has several drivers.
        prescribed: the speed at which the one driver is held, whatever torque that takes; None: it is not held.
        flywheel: on the drive's side of the clutch.
        flywheels: of a linkage with several drivers, by their names.
        held: drives that hold the speeds of motors of such a linkage, by their names.
        law: the efforts of all motors in place of drives, where there are several drivers; None: there is none.
        clutch: between drive and flywheel, and the crank; None: they turn together.
        brake: on the crank.
        friction: of the bearings; None for none.
    """

    press: Linkage
    inertia: Any
    inertias: Array
    coordinates: tuple[Coordinate, ...]
    forces: tuple[GeneralizedForce, ...]
    drive: Drive | None = None
    prescribed: PrescribedSpeed | None = None
    flywheel: Flywheel | None = None
    clutch: Clutch | None = None
    brake: Brake | None = None
    friction: FrictionLaw | None = None
    flywheels: Mapping[str, Flywheel] = field(default_factory=dict)
    held: Mapping[str, PrescribedSpeed] = field(default_factory=dict)
    law: "MotorLaw | None" = None

    @property
    def timed(self) -> bool:
        """Whether anything depends on more than crank angle and speed, or jumps at a speed. Periods cannot be solved at once then."""
        timed = any(force.time is not None or (force.drive is not None and force.drive.timed) for force in self.forces)
        return (
            timed
            or self.law is not None
            or self.clutch is not None
            or self.brake is not None
            or (self.drive is not None and (self.drive.timed or self._jumps))
        )

    @property
    def _jumps(self) -> bool:
        """Whether the drive's torque jumps at a speed, other than at rest."""
        return self.drive is not None and any(jump and np.any(speed) for speed, jump in corners_of(self.drive))

    @property
    def heeds_speed(self) -> bool:
        """Whether a force depends on more than the crank angle. Where none does, a swing of the crank repeats itself."""
        if self.friction is not None or self.timed or (self.drive is not None and getattr(self.drive, "heeds_speed", True)):
            return True
        return any(force.rising is not force.falling or any(interval.heeds_velocity for interval in force.rising) for force in self.forces)

    @cached_property
    def speed_free(self) -> bool:
        """Whether no force depends on time or on the size of the speed, while the crank turns one way."""
        if self.timed or self.friction is not None or (self.drive is not None and getattr(self.drive, "heeds_speed", True)):
            return False
        return not any(interval.heeds_velocity for force in self.forces for interval in (*force.rising, *force.falling))

    @cached_property
    def model(self) -> ReducedModel:
        """The press reduced to its crank, with the coordinates of the forces."""
        press, coordinates = self.press, self.coordinates
        if len(coordinates) == (press.slide is not None):
            return reduced_model_of(press)
        angles = any(isinstance(each, JointPosition | Turn | WorkOfMoment) for each in coordinates[press.slide is not None :])
        return build_reduced_model(press, [partial(coordinate.over, press) for coordinate in coordinates], angles=angles)

    @cached_property
    def bearing_model(self) -> BearingModel | None:
        """The bearings with their friction; None if there is none. Raises as `build_bearing_model`."""
        if self.friction is None:
            return None
        unit_forces = [partial(coordinate.unit_force, self.press) for coordinate in self.coordinates]
        return build_bearing_model(self.press, self.friction, self.model, unit_forces)

    @cached_property
    def switch_angles(self) -> tuple[Array, ...]:
        """Crank angles in the model's range at which a force is not smooth: (k,) of each border of its intervals, of the turns of its
        coordinate, and of those of each bearing with friction [rad]."""
        angles = [] if self.bearing_model is None else [*self.bearing_model.reversals]
        for force in self.forces:
            row, borders = COORDINATES + force.row, force.borders()
            angles += [places_of(self.model, row, border) for border in borders]
            if borders:
                angles.append(self.model.roots(row, slope=True))
        return read_only(tuple(angles))

    @cached_property
    def switch_times(self) -> tuple[float, ...]:
        """Instants at which a force or a coupling is not smooth [s]."""
        times = [edge for force in self.forces for edge in force.edges]
        for coupling in (self.clutch, self.brake):
            for switch in () if coupling is None else (coupling.closes, coupling.opens):
                if coupling is not None and switch is not None and switch.time is not None:
                    times += [switch.time, switch.time + coupling.rise]
        return tuple(times)

    def motion_sizes(self, speed: float) -> tuple[float, float]:
        """Speed [rad/s] and kinetic energy [J] of a crank that has this speed or falls by itself, to which tolerances are relative."""
        inertia = self.model.middles[INERTIA] + self.inertia
        least = max(float(inertia.min()), float(np.finfo(float).tiny))
        size = max(abs(speed), math.sqrt(2 * self.model.potential_range / least)) or 1.0
        return size, 0.5 * float(np.abs(inertia).max()) * size**2

    @cached_property
    def corners(self) -> tuple[float, ...]:
        """Speeds of the drive's shaft at which its torque is not smooth, those of the first scenario [rad/s]."""
        return () if self.drive is None else tuple(float(np.ravel(speed)[0]) for speed, _ in corners_of(self.drive))


def driven_press(
    press: Linkage,
    drive: object,
    flywheel: object,
    loads: Sequence[Load],
    clutch: object,
    brake: object,
    friction: Mapping[str, Friction] = NONE_GIVEN,
) -> DrivenPress:
    """A press, and all that acts on it. Drive and loads have been `tried`.

    A linkage with several drivers has drives and flywheels by the names of their joints, and no friction.

    Raises:
        PinpressError: an argument is of the wrong kind or contradicts another, a load cannot be simulated, or heights are to be measured
            from a bottom dead centre that does not exist.
        UnknownNameError: a load acts on a link that the linkage does not have, or a part on a driver that it does not have.
    """
    coordinates, forces = _coordinates_and_forces(press, loads)
    if friction and press.joint_springs:
        names = ", ".join(spring.joint for spring in press.joint_springs)
        raise PinpressError(f"{press.name} has springs in joints ({names}), with which runs know no friction in bearings: leave it out")
    if len(press.drivers) > 1:
        return _with_several_drivers(press, drive, flywheel, coordinates, forces, clutch, brake)
    _refuse_other_parts(drive, flywheel, clutch, brake)
    if not press.driver_coordinates[0].turns:
        _refuse_parts_that_turn(press.driver, {"drive": drive, "flywheel": flywheel, "clutch": clutch, "brake": brake})
    assert isinstance(drive, None | PrescribedSpeed | Drive)  # the protocol last, because it looks for each of its members
    assert isinstance(flywheel, Flywheel | None)
    assert isinstance(clutch, Clutch | None)
    assert isinstance(brake, Brake | None)
    prescribed, drive = (drive, None) if isinstance(drive, PrescribedSpeed) else (None, drive)
    inertia: Any = 0.0 if flywheel is None else flywheel.inertia
    if drive is not None:
        inertia = inertia + drive.inertia
    if clutch is not None and not float(inertia) > 0:
        raise PinpressError("a clutch needs an inertia on its driving side: give a flywheel, or a drive with inertia")
    _doubt_parts(press, drive, flywheel, clutch, brake)
    return DrivenPress(
        press=press,
        inertia=inertia,
        inertias=np.array([inertia]),
        coordinates=tuple(coordinates),
        forces=tuple(forces),
        drive=drive,
        prescribed=prescribed,
        flywheel=flywheel,
        clutch=clutch,
        brake=brake,
        friction=law(friction, press),
    )


def _doubt_parts(press: Linkage, drive: Drive | None, flywheel: Flywheel | None, clutch: Clutch | None, brake: Brake | None) -> None:
    """Warn of parts that probably belong to a press of another size."""
    mass = sum(float(inertia.mass) for inertia in press.model.inertias)
    if flywheel is not None:
        plausibility.flywheel(float(np.max(flywheel.inertia)), mass, press.size)
    torques: dict[str, Any] = {type(part).__name__: part.torque for part in (clutch, brake) if part is not None}
    if drive is not None:
        inner, ratio = innermost(drive)
        if drive.rated_torque is not None:
            torques[f"the rated torque of {type(inner).__name__}"] = abs(ratio) * np.max(drive.rated_torque)
        if press.driver_coordinates[0].turns:
            idle = float(np.abs(getattr(drive, "reversals", ())).max(initial=0.0))  # where a motor gives no torque
            plausibility.idle_speed(type(inner).__name__, idle, slide_at(press, idle), slide_at(press, 0.5 * idle))
    if press.slide is not None and torques and press.driver_coordinates[0].turns:
        low, high = applied_loads.turning_points(press)
        weight = GRAVITY * float(press.model.inertias[press.slide_guide.joint + 1].mass)
        for name, value in torques.items():
            plausibility.torque(name, float(value), 0.5 * weight * (high - low) if math.isfinite(high - low) else 0.0)


class MotorAgainst(NamedTuple):
    """An asynchronous motor whose rotating field turns against a speed: turned that way it brakes at every speed."""

    motor: str  # name of its class
    idle: str  # no-load speed of the driver under it, with its sign, in the unit in which speeds are shown
    share: float  # of the no-load speed that the speed is, positive
    speed: str  # the same of the speed
    remedy: str  # what turns the motor round


def motor_against(press: Linkage, given: object, speed: float) -> MotorAgainst | None:
    """The motor of a drive if its own direction is against a speed of the driver [rad/s or m/s]; else None."""
    drive = caller_laws.as_given(given)
    if not isinstance(drive, Drive):
        return None
    motor, ratio = innermost(drive)
    motor = caller_laws.as_given(motor)
    idle = (getattr(motor, "primary_speed", None) or max(getattr(motor, "reversals", ()), default=0.0)) / ratio
    if not idle * speed < 0:
        return None
    remedy = f"ratio={-drive.ratio:g}" if isinstance(drive, Geared) else "Geared(motor, ratio=-1)"
    unit, size = press.driver_coordinates[0].shown_speed
    return MotorAgainst(type(motor).__name__, f"{idle / size:.6g} {unit}", -speed / idle, f"{speed / size:.6g} {unit}", remedy)


def _refuse_other_parts(drive: object, flywheel: object, clutch: object, brake: object) -> None:
    """Raise PinpressError where a part is of the wrong kind, or clutch and brake have nothing to do."""
    if drive is not None and not (isinstance(drive, PrescribedSpeed | Drive) and not isinstance(drive, type)):
        raise PinpressError(f"drive is {shown(drive)}: give one of pinpress.drives, e.g. ConstantTorque(567.0) [N m]")
    for name, value, kind in (("flywheel", flywheel, Flywheel), ("clutch", clutch, Clutch), ("brake", brake, Brake)):
        if value is not None and not isinstance(value, kind):
            raise PinpressError(f"{name} is {shown(value)}: give a {kind.__name__}(...)")
    if isinstance(drive, PrescribedSpeed) and (clutch is not None or brake is not None):
        raise PinpressError("a drive that prescribes the crank's speed leaves nothing to clutch and brake: leave them out")


def _refuse_parts_that_turn(driver: str, parts: Mapping[str, object]) -> None:
    """Raise PinpressError for parts that need a shaft, on a driver that slides; ``parts``: by the names of their arguments."""
    remedies = {
        "flywheel": "give what turns behind a screw to its motor, Geared(motor, ratio=2 * pi / lead)",
        "clutch": "leave it out, or give a drive of your own whose force is that of the clutch",
        "brake": "leave it out, or give a drive of your own whose force is that of the brake",
        "drive": "let it act through a screw, Geared(motor, ratio=2 * pi / lead); a cylinder's force is ConstantTorque [N]",
    }
    for name, part in parts.items():
        if isinstance(part, Flywheel | Clutch | Brake | ElectricMotor):
            raise PinpressError(f"driver {driver!r} slides, but {type(part).__name__} needs a shaft: {remedies[name]}")


def _with_several_drivers(
    press: Linkage,
    drive: object,
    flywheel: object,
    coordinates: "list[Coordinate]",
    forces: "list[GeneralizedForce]",
    clutch: object,
    brake: object,
) -> DrivenPress:
    """See `driven_press`; coordinates and forces are those of the loads."""
    if clutch is not None or brake is not None:
        press.refuse_several_drivers("clutch and brake are for one; leave them out")
    law = None
    if is_motor_function(drive):
        rows = tuple(range(len(coordinates), len(coordinates) + len(press.motors)))
        coordinates += map(JointPosition, press.driver_indices[: len(rows)])
        law, drive = MotorLaw(_motor_law(drive), rows), None
    drives: Mapping[str, Any] = _by_driver(press, "drive", drive, Drive)
    held = {name: part for name, part in drives.items() if isinstance(part, PrescribedSpeed)}
    flywheels: Mapping[str, Flywheel] = _by_driver(press, "flywheel", flywheel, Flywheel)
    inertias = np.zeros(len(press.drivers))
    for k, (name, joint) in enumerate(zip(press.drivers, press.driver_indices, strict=True)):
        if not press.driver_coordinates[k].turns:
            _refuse_parts_that_turn(name, {"drive": drives.get(name), "flywheel": flywheels.get(name)})
        if name in flywheels:
            inertias[k] += flywheels[name].inertia
        if name in drives and name not in held:
            inertias[k] += drives[name].inertia
            forces.append(GeneralizedForce(len(coordinates), 0.0, drive=drives[name]))
            coordinates.append(JointPosition(joint))
    return DrivenPress(
        press, float(inertias[0]), inertias, tuple(coordinates), tuple(forces), flywheels=dict(flywheels), held=held, law=law
    )


def _motor_law(function: Any) -> caller_laws.Law:
    return caller_laws.Law("drive", (("time", "s"), ("position", ""), ("speed", "")), function, np.geterr())


def _by_driver(press: Linkage, name: str, given: object, kind: type) -> Mapping[str, Any]:
    """The mapping from driver joints to parts that was given as argument ``name``, each part of this kind; empty where none was given."""
    by_joint = {} if given is None else given
    if not isinstance(by_joint, Mapping):
        one_each = ", ".join(f"{joint!r}: ..." for joint in press.motors)
        every = ", or a function of time, positions and speeds of the motors that returns their efforts" if name == "drive" else ""
        raise PinpressError(f"{press.name} has {len(press.drivers)} drivers: give a {kind.__name__} for each, {name}={{{one_each}}}{every}")
    for joint, value in by_joint.items():
        if joint not in press.motors:
            raise UnknownNameError("driver", joint, press.motors)
        if isinstance(value, PrescribedSpeed) and kind is Drive:
            continue
        if not isinstance(value, kind) or isinstance(value, type):
            raise PinpressError(f"{name} of {shown(joint)} is {shown(value)}: give a {kind.__name__}")
        if isinstance(value, Drive) and value.state:
            follows = "give one whose torque follows from speed, angle and time"
            raise PinpressError(f"drive of {shown(joint)} has states of its own, which drives of several drivers cannot have: {follows}")
    return by_joint


def _coordinates_and_forces(press: Linkage, loads: Sequence[Load]) -> "tuple[list[Coordinate], list[GeneralizedForce]]":
    """The coordinates along which loads act, that of the slide first, and their forces."""
    coordinates: list[Coordinate] = [] if press.slide is None else [JointPosition(*press.slide_guide)]
    forces: list[GeneralizedForce] = []
    for spring in press.joint_springs:
        in_joint = (ForceInterval(math.inf, -math.inf, spring.effort, heeds_velocity=bool(spring.damping)),)
        forces.append(GeneralizedForce(len(coordinates), 0.0, in_joint, in_joint))
        coordinates.append(JointPosition(press.joints.index(spring.joint)))
    for load in loads:
        if isinstance(load, SpringDamper):
            law_of_spring = partial(_spring_force, load)
            always = (ForceInterval(math.inf, -math.inf, law_of_spring, heeds_velocity=bool(load.damping)),)
            forces.append(GeneralizedForce(len(coordinates), 0.0, always, always))
            coordinates.append(Length(*applied_loads.spring_ends(load, press)))
        elif isinstance(load, TorsionSpring):
            law_of_turn = partial(_torsion_spring_moment, load)
            always = (ForceInterval(math.inf, -math.inf, law_of_turn, heeds_velocity=bool(load.damping)),)
            forces.append(GeneralizedForce(len(coordinates), 0.0, always, always))
            coordinates.append(Turn(applied_loads.turn_of_spring(load, press)))
        elif isinstance(load, PointMoment):
            if not is_constant(load):
                raise PinpressError(f"{load.label}: a simulation takes a constant moment, one number or (3,) in world axes [N m]")
            vector = applied_loads.moment_vectors(load, press, load.moment)
            joints = [body_of(press, link) for link in (load.link, load.on) if link is not None]
            for link, joint, moment in zip((load.link, load.on), joints, (vector, -vector), strict=False):
                if link is not None and joint:  # the frame does not move
                    turn = applied_loads.relative_turn(press, press.root, link, load.label)
                    constant = (ForceInterval(math.inf, -math.inf, _constant_one, heeds_velocity=False),)
                    forces.append(GeneralizedForce(len(coordinates), 0.0, constant, constant))
                    coordinates.append(WorkOfMoment(joint, moment, _turned_by(press, turn, moment), 0 in joints))
        elif isinstance(load, PointForce):
            if callable(load.force) or np.ndim(load.force) != 1:
                raise PinpressError(
                    f"{load.label}: a simulation takes a constant force, (3,) in world axes [N]; for one that changes write one of"
                    " pinpress.loads, or a class with their members `datum` and `intervals`"
                )
            placed = applied_loads.point_force(load, press, load.force)
            if placed.joint:  # the frame does not move
                constant = (ForceInterval(math.inf, -math.inf, _constant_one, heeds_velocity=False),)
                forces.append(GeneralizedForce(len(coordinates), 0.0, constant, constant))
                coordinates.append(WorkOfForce((placed.joint, placed.point), placed.force[0]))
        else:
            _ = press.slide_guide  # raises PinpressError where the linkage has no slide, whose coordinate is the first
            if isinstance(load, TimeForce):
                forces.append(GeneralizedForce(0, 0.0, time=load.force, edges=tuple(load.edges)))
            elif (force := _process_force(press, load)) is not None:
                forces.append(force)
    return coordinates, forces


def _turned_by(press: Linkage, turn: applied_loads.RelativeTurn | None, moment: Array) -> Array:
    """(nv,) work of a moment in world axes by joint coordinates, on a link that turns against the frame about one axis [N m]."""
    if turn is None:
        return np.zeros(len(press.joints))
    axis = drawn_placements(press.model)[turn.bodies[1]].rotation @ turn.axis
    return np.asarray(float(axis @ moment) * turn.by)


def _process_force(press: Linkage, load: ProcessLoad) -> GeneralizedForce | None:
    """The force of a process load; None if it acts nowhere."""
    rising, falling = tuple(load.intervals(downwards=False)), tuple(load.intervals(downwards=True))
    if not rising and not falling:
        return None
    name, zero = caller_laws.name(load), datum(caller_laws.as_given(load), press)
    intervals = [*((True, interval) for interval in falling), *((False, interval) for interval in rising)]
    applied_loads.warn_of_load(name, press, intervals, zero, applied_loads.turning_points(press))
    # Crank angles cannot distinguish the ends of a thinner interval.
    least = 1e-8 * press.size
    for _, interval in intervals:
        if interval.upper - interval.lower < least:
            raise PinpressError(
                f"{name}: an interval of {interval.upper - interval.lower:g} m is thinner than a simulation resolves; give at least"
                f" {least:.2g} m"
            )
    return GeneralizedForce(0, zero, rising, rising if rising == falling else falling)


# Functions of the module, and not within others, so that what is simulated can be pickled.


def _constant_one(position: Any, velocity: Any) -> Any:
    return position * 0.0 + 1.0


def _torsion_spring_moment(spring: TorsionSpring, angle: Any, rate: Any) -> Any:
    return spring.stiffness * (spring.free_angle - angle) - spring.damping * rate


def _spring_force(spring: SpringDamper, length: Any, rate: Any) -> Any:
    return spring.stiffness * (spring.free_length - length) - spring.damping * rate
