"""Vibration of a press on its mounts: motion of points of the frame, and force on the floor, in the steady state or over time.

The excitation is the shaking force and moment of the machine, weight excluded, and the reaction of a flywheel whose speed changes.

In the steady state each harmonic of a periodic motion is solved separately, (K + i K'' + i w C - w^2 M) U = F. This is exact for forces
that the states resolve. Over time the force is assumed to be linear between two states. Then a step of the linear system is exact for any
step size (first-order hold: the matrix exponential of (x, f, f') over a step).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import expect, finite_numbers, number, typed
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.frozen import FrozenMapping
from ..common.quantities import Array, ComplexArray
from ..common.results import Tabular
from ..common.tables import by_axis
from ..drives.transmission import Flywheel
from ..dynamics.reactions import Reactions
from ..dynamics.shaking import on_frame_at
from ..kinematics.motion import Motion, is_cycle
from ..linkage.linkage import Linkage, is_same_press, told_apart
from ..simulation.run import Run
from .elastic_frame import ElasticFrame
from .frame_parts import rows_at
from .mounted_press import MountedPress, quadrature, state_matrix

SOLVED_AT_ONCE = 2**22  # entries of the matrices of harmonics that are solved together: 64 MB
NOTHING = 1e-9  # a shaking force below this share of the weight is a rounding error
EVEN = 1e-9  # the crank's speed is constant up to this relative difference
SAME_STEP = 1e-6  # relative difference up to which steps of time are equal
SAME_SPEED = 1e-6  # relative difference up to which speeds at both ends of a period, or of flywheel and crank, are equal
RESONANCE = "a harmonic meets a natural frequency that has no damping: give the mounts damping or a loss factor, or another speed"
Points = Mapping[str, "ArrayLike | str | tuple[str, ArrayLike]"]
Flywheels = Flywheel | Mapping[str, Flywheel] | None


@typed
def steady_response(
    system: MountedPress, reactions: Reactions, *, points: Points, flywheel: Flywheels = None, period: float | None = None
) -> FrameMotion:
    """The vibration over one period, after the initial vibration has died away.

    Gyroscopic moments of rotors are computed at the mean speed.

    Args:
        system: the press on its mounts.
        reactions: reactions of this press over one period at constant speed (`cycle`), or over one period of `steady_state`. With
            ``period``, over one period of any motion in equal steps of time, e.g. of `servo_cycle`, with one or several drivers.
        points: name -> (3,) point of the frame in world axes [m]. In a frame of two parts this is a point of the bed, ("crown", (x, y, z))
            is a point of the crown, and ("motor", (x, y, z)) a point of the attachment "motor". In an elastic frame (x, y, z) is a node of
            its model; or give the name of an interface, or (interface, (x, y, z)) for a point that moves with the interface.
        flywheel: flywheel on the crank's shaft; it has an effect only if the speed changes. Its inertia is angular momentum about the
            crank's axis / crank speed: for a flywheel on another shaft, inertia x (flywheel speed / crank speed), negative if it turns the
            other way. For several drivers, a mapping from driver name to flywheel.
        period: time after which the motion repeats itself, if it is neither at constant speed nor a steady state [s].

    Raises:
        PinpressError: the reactions are of another press, the motion is not one period, it has too few states for the shaking force, a
            point or the flywheel is not as described, a harmonic meets a natural frequency without damping, or the speed of rotors changes
            over the ``period``.
    """
    placed = named_points(system, points)
    length, states = period_of(reactions.motion, period)
    speed = reactions.motion.crank_speed
    # rotors count as spinning at the crank's mean speed if its speed changes by less than a twentieth
    if period is not None and system.gyroscopic.any() and np.ptp(speed) > 0.05 * np.abs(speed).max():
        raise PinpressError(
            "the rotors change their speed over the period, and with it their moments: use time_response, or leave the rotors out"
        )
    harmonics = checked_harmonics(*spectrum(system, reactions, flywheel, period))
    frequency = np.linspace(0.0, 2 * np.pi / length * (len(harmonics) - 1), len(harmonics))
    amplitude = displacement_amplitudes(system, frequency, harmonics, mean_speed(system, reactions.motion))

    def in_time(spectrum: ComplexArray) -> Array:
        return np.fft.irfft(spectrum, states, axis=0)

    velocity = 1j * frequency[:, None] * amplitude
    return FrameMotion.of(
        system,
        time=np.linspace(0.0, length, states, endpoint=False),
        points=placed,
        motion=(in_time(amplitude), in_time(velocity), in_time(1j * frequency[:, None] * velocity)),
        mount_force=in_time(mount_forces(system, frequency, amplitude).reshape(len(frequency), -1)).reshape(states, -1, 3),
        wrench=in_time(harmonics),
        period=length,
    )


@typed
def time_response(system: MountedPress, reactions: Reactions, *, points: Points, flywheel: Flywheels = None) -> FrameMotion:
    """The vibration over time of a frame that is initially at rest in its static position.

    A motion that begins at full speed is a sudden load on the frame at rest; the vibration from this start dies away with the modes'
    damping.

    Args:
        system: the press on its mounts.
        reactions: reactions of this press in a run of `simulate`, or in any motion in equal steps of time.
        points: as for `steady_response`.
        flywheel: as for `steady_response`.

    Raises:
        PinpressError: the reactions are of another press, the states are not at equal intervals of time, a point or the flywheel is not as
            described, or the vibration is not finite.
    """
    wrench = frame_wrench(system, reactions, flywheel)
    placed, interval = named_points(system, points), time_step(reactions.motion)
    u, velocity, acceleration = vibration_from_rest(system, wrench, interval, reactions.motion)
    rows = system.mount_rows
    stiffness, damping, loss = mount_constants(system)
    displaced, moving = np.einsum("mkj,nj->nmk", rows, u), np.einsum("mkj,nj->nmk", rows, velocity)
    later = np.einsum("mkj,nj->nmk", rows, velocity @ quadrature(system).T)
    return FrameMotion.of(
        system,
        time=reactions.motion.time - reactions.motion.time[0],
        points=placed,
        motion=(u, velocity, acceleration),
        mount_force=-(stiffness * displaced + damping * moving + loss * later),
        wrench=wrench,
        period=None,
    )


@dataclass(frozen=True, eq=False, repr=False)
class FrameMotion(Tabular):
    """Vibration about the static position in n states. All arrays are read-only.

    Attributes:
        system: the press on its mounts.
        time: (n,) times of the states, from zero [s].
        period: period of the motion; its end is not among the states [s]; None if the motion is not one period.
        displacement: name of a point -> (n, 3) in world axes [m].
        velocity: name of a point -> (n, 3) in world axes [m/s].
        acceleration: name of a point -> (n, 3) in world axes [m/s2].
        coordinates: (n, coordinates) coordinates of the frame's parts, see `MountedPress` [m, rad].
        mount_force: (n, mounts, 3) force of each mount on the frame in addition to its static load, in world axes [N].
        floor_force: (n, 3) force of all mounts on the floor without the weight, in world axes [N].
        floor_moment: (n, 3) moment of these forces about the world origin [N m].
        shaking_force: (n, 3) force of the machine on the frame without its weight, in world axes [N].
    """

    system: MountedPress
    time: Array
    period: float | None
    displacement: Mapping[str, Array]
    velocity: Mapping[str, Array]
    acceleration: Mapping[str, Array]
    coordinates: Array
    mount_force: Array
    floor_force: Array
    floor_moment: Array
    shaking_force: Array

    @property
    def title(self) -> str:
        points = ", ".join(self.displacement) or "none"
        return f"FrameMotion of {self.system.press.name}: {len(self.time)} states, {self.time[-1]:.6g} s, points {points}"

    @classmethod
    def of(
        cls,
        system: MountedPress,
        time: Array,
        points: Mapping[str, Array],
        motion: tuple[Array, Array, Array],
        mount_force: Array,
        wrench: Array,
        period: float | None,
    ) -> FrameMotion:
        """The motion of points from the motion of the coordinates.

        Args:
            system: the press on its mounts.
            time: (n,) times of the states [s].
            points: name of a point -> (3, coordinates) its displacement for a unit of each coordinate.
            motion: displacements, velocities and accelerations of the coordinates, (n, coordinates) each.
            mount_force: (n, mounts, 3) force of each mount on the frame in addition to its static load [N].
            wrench: (n, coordinates) wrenches on the parts of the frame, from `frame_wrench` [N, N m].
            period: length of the period [s]; None if the motion is not one period.
        """
        moved = [{name: np.array(values @ rows.T) for name, rows in points.items()} for values in motion]
        places = np.array([mount.point for mount in system.mounts])
        shaking = (wrench @ system.rigid)[:, :3]
        return cls(
            system=system,
            time=np.array(time),
            period=period,
            displacement=FrozenMapping(moved[0]),
            velocity=FrozenMapping(moved[1]),
            acceleration=FrozenMapping(moved[2]),
            coordinates=np.array(motion[0]),
            mount_force=np.array(mount_force),
            floor_force=np.array(-mount_force.sum(axis=1)),
            floor_moment=np.array(-np.cross(places, mount_force).sum(axis=1)),
            shaking_force=shaking,
        )

    @property
    def from_rest(self) -> bool:
        """Whether the frame is initially at rest in its static position."""
        return self.period is None and not self.coordinates[0].any()

    @property
    def transmitted(self) -> float:
        """Force on the floor divided by the shaking force, both as rms about their means [-].

        Raises:
            PinpressError: the shaking force is zero.
        """
        shaking = rms_about_mean(self.shaking_force)
        if shaking <= NOTHING * np.abs(self.system.weight[:3]).max():
            raise PinpressError(f"no force of {self.system.press.name} shakes the frame: there is nothing to transmit")
        return rms_about_mean(self.floor_force) / shaking

    @property
    def least_load(self) -> Array:
        """(mounts,) smallest vertical load on each mount, the static load included [N].

        If it is negative, a mount that is not bolted down lifts off and the linear model is not valid: see `lifting_response`.
        """
        least: Array = (self.system.upward_load + self.mount_force @ self.system.press.up).min(axis=0)
        return least

    def rms(self, point: str) -> Array:
        """(3,) rms of a point's acceleration about its mean, in world axes [m/s2].

        Raises:
            UnknownNameError: there is no such point.
        """
        return np.asarray(self._of(point).std(axis=0))

    def peak(self, point: str) -> Array:
        """(3,) largest absolute acceleration of a point, in world axes [m/s2].

        Raises:
            UnknownNameError: there is no such point.
        """
        return np.asarray(np.abs(self._of(point)).max(axis=0))

    def _of(self, point: str) -> Array:
        if point not in self.acceleration:
            raise UnknownNameError("point", point, self.acceleration)
        return self.acceleration[point]

    def columns(self) -> dict[str, Array]:
        """Time, the points' displacement, velocity and acceleration, force and moment on the floor, and shaking force."""
        columns = {"time [s]": self.time}
        for name, unit in (("displacement", "m"), ("velocity", "m/s"), ("acceleration", "m/s2")):
            for point, values in getattr(self, name).items():
                columns |= by_axis(f"{name}_{point}", unit, values)
        columns |= by_axis("floor_force", "N", self.floor_force) | by_axis("floor_moment", "N m", self.floor_moment)
        return columns | by_axis("shaking_force", "N", self.shaking_force)


@typed
def flywheel_moment(press: Linkage, motion: Motion, flywheel: Flywheel | Mapping[str, Flywheel]) -> Array:
    """Moment of flywheels on the frame: the sum of -J w' about the crank axis of each flywheel.

    Args:
        press: a press whose driver joints are on the frame.
        motion: a motion of this press.
        flywheel: flywheel on the crank's shaft; for another shaft see `steady_response`. For several drivers, a mapping from driver name to
            flywheel.

    Returns:
        (states, 3) moment in world axes [N m].

    Raises:
        PinpressError: a flywheel has the inertias of several scenarios, its driver joint slides or is not on the frame, there are several
            drivers and none is named, or a clutch between flywheel and crank slips.
        UnknownNameError: there is no driver with this name.
    """
    if isinstance(flywheel, Flywheel):
        press.refuse_several_drivers("flywheel names none of them; give flywheel={'" + press.drivers[0] + "': Flywheel(...)}")
        flywheel = {press.driver: flywheel}
    _refuse_slip(motion)
    accelerations = motion.crank_acceleration.reshape(len(motion.crank_acceleration), -1)
    moment = np.zeros((len(accelerations), 3))
    for name, wheel in flywheel.items():
        if name not in press.drivers:
            raise UnknownNameError("driver", name, press.drivers)
        place = press.drivers.index(name)
        joint = press.driver_indices[place]
        expect(f"flywheel of {shown(name)}", wheel, Flywheel, "Flywheel")
        if np.ndim(wheel.inertia):
            raise PinpressError("flywheel has the inertias of several scenarios: give one inertia")
        if not press.driver_coordinates[place].turns:
            raise PinpressError(f"the driver {shown(name)} slides, and a flywheel turns with a crank: leave it out")
        if press.model.parents[joint + 1] != 0:
            raise PinpressError(f"the driver joint {shown(name)} is not on the frame: the moment of its flywheel has no fixed axis there")
        axis = press.model.jointPlacements[joint + 1].rotation @ press.axes[joint].direction
        moment -= float(wheel.inertia) * accelerations[:, place, None] * axis
    return moment


def _refuse_slip(motion: Motion) -> None:
    if isinstance(motion, Run):
        difference = np.abs(motion.drive_speed - motion.crank_speed).max()
        if difference > SAME_SPEED * np.abs(motion.crank_speed).max():
            raise PinpressError(
                f"the speeds of flywheel and crank differ by up to {difference:.4g} rad/s because a clutch slips: give a run, or the part"
                " of one, in which it holds"
            )


def mean_speed(system: MountedPress, motion: Motion) -> float:
    """Mean speed of the crank with which the rotors spin [rad/s]; 0 without rotors."""
    return float(motion.crank_speed.mean()) if system.rotors else 0.0


def frame_wrench(system: MountedPress, reactions: Reactions, flywheel: Flywheels) -> Array:
    """Forces (states, n) of the machine on the coordinates of the frame, less the weight at its mean position [N, N m].

    In a frame of two parts the loads on the frame act on the bed, and all other forces on the crown. In an elastic frame they act at its
    interfaces for bed, crank and bearings. The torque of a motor on the frame is not a load: the casing exerts on the frame the reaction to
    the rotor's torque on the crank. The flywheel is not in the URDF; see `flywheel_moment`. Rotors react to changes of their own speed.

    Raises:
        PinpressError: the reactions are of another press, there are both rotors and a flywheel, or as `flywheel_moment`.
    """
    expect("system", system, MountedPress, "mounted")
    expect("reactions", reactions, Reactions, "inverse_dynamics")
    press = system.press
    if not is_same_press(reactions._press, press):
        other = told_apart(reactions._press, press)
        raise PinpressError(f"the reactions are of {other}, and {press.name} is on the mounts: give reactions of this press")
    if flywheel is not None and system.rotors:
        raise PinpressError("the rotors of the press on its mounts react to changes of speed already: leave out flywheel=, or the rotors")
    shaking = np.hstack([reactions.shaking_force, reactions.shaking_moment]) - system.press_weight
    if flywheel is not None:
        shaking[:, 3:] += flywheel_moment(press, reactions.motion, flywheel)
    bed, carrier = system.parts[system.bed], system.parts[system.carrier]
    wrench = np.asarray(shaking @ carrier)
    if system.bed != system.carrier:
        for load in reactions._conditions.loads:
            if load.joint == 0:
                moment = np.cross(load.point, load.force) + (0.0 if load.moment is None else load.moment)
                wrench += np.hstack([load.force, moment]) @ (bed - carrier)
    if isinstance(system.frame, ElasticFrame):
        for bearing, interface in system.frame.bearings.items():
            force, moment = reactions.bearing_force[bearing], reactions.bearing_moment[bearing]
            for sign, point in on_frame_at(press, reactions.motion, press.bearings.index(bearing)):
                wrench += sign * np.hstack([force, moment + np.cross(point, force)]) @ (system.parts[interface] - carrier)
    if system.rotors:
        _refuse_slip(reactions.motion)
        momentum = sum(rotor.momentum @ system.motion_of(rotor.on)[3:] for rotor in system.rotors)
        wrench -= np.outer(reactions.motion.crank_acceleration, momentum)
    return wrench


def named_points(system: MountedPress, points: Points) -> dict[str, Array]:
    """Rows (3, n) of the displacement of each named point, for the coordinates.

    Raises:
        PinpressError: ``points`` is not a mapping from names to points.
        UnknownNameError: a point is on a part that the frame does not have.
    """
    expect("points", points, Mapping, "{'top_beam': (x, y, z), ...}")
    rows = {}
    for name, given in points.items():
        named, part, place = False, system.bed, given
        if isinstance(given, tuple) and len(given) == 2 and isinstance(given[0], str):  # ("crown", (x, y, z))
            named, part, place = True, given[0], given[1]
        if isinstance(system.frame, ElasticFrame) and isinstance(given, str):
            part, place = given, system.frame.nodes.get(given, system.frame.nodes[system.bed])
        point = finite_numbers(place)
        if not isinstance(name, str) or point is None or point.shape != (3,):
            raise PinpressError(f"point {shown(name)} is {shown(given)}: give x, y, z [m] under a name, or ('crown', (x, y, z))")
        plausibility.point(f"point {shown(name)}", point, system.press.size)
        if isinstance(system.frame, ElasticFrame) and not named and not isinstance(given, str):
            near = system.frame.rows_near(point)
            rows[name] = np.pad(near, ((0, 0), (0, len(system.mass) - len(near.T))))
            continue
        rows[name] = rows_at(system.motion_of(part), point)
    return rows


def checked_harmonics(harmonics: ComplexArray, states: int, size_of_all: float) -> ComplexArray:
    """Harmonics of a wrench, checked. For an even number of states the highest harmonic is set to zero, because its phase is unknown.

    Args:
        harmonics: (k, n) from `numpy.fft.rfft`; changed in place.
        states: number of states of the period.
        size_of_all: size of the forces that the wrench was worked out from, to which rounding is relative [N].

    Raises:
        PinpressError: the last third of the harmonics is larger than rounding errors: the force has jumps, or too sharp corners for the
            states.
    """
    if (enough := states_enough(harmonics, states, size_of_all)) > states:
        raise PinpressError(
            f"{states} states do not resolve the shaking force, which changes too sharply, e.g. when a blank breaks: give about"
            f" {enough} points, or use time_response"
        )
    if states % 2 == 0:
        harmonics[-1] = 0.0
    return harmonics


def states_that_resolve(system: MountedPress, reactions: Reactions, flywheel: Flywheels = None) -> int:
    """Number of states of the period that `steady_response` needs: the number in these reactions, or more; see `states_enough`.

    Raises:
        PinpressError: the reactions are of another press, or the motion is not one period.
    """
    return states_enough(*spectrum(system, reactions, flywheel))


def spectrum(
    system: MountedPress, reactions: Reactions, flywheel: Flywheels, period: float | None = None
) -> tuple[ComplexArray, int, float]:
    """Harmonics of the wrench on the frame over a period, the number of its states, and the size of its forces [N], for `states_enough`."""
    wrench, (_, states) = frame_wrench(system, reactions, flywheel), period_of(reactions.motion, period)
    return np.fft.rfft(wrench[:states], axis=0), states, max(float(np.abs(wrench).max()), float(np.abs(system.weight[:3]).max()))


def states_enough(harmonics: ComplexArray, states: int, size_of_all: float) -> int:
    """Number of states of the period that resolve a wrench: the given number, or a larger one that is about enough for a force that jumps.

    Args:
        harmonics: (k, n) as `numpy.fft.rfft` gives them.
        states: number of states of the period.
        size_of_all: size of the forces that the wrench was worked out from, to which rounding is relative [N].
    """
    size = np.abs(harmonics[1:]).max(axis=1)
    tail, largest = size[2 * len(size) // 3 :].max(initial=0.0), size.max(initial=0.0)
    unresolved = 1e-3 * largest  # states resolve a force if the last third of its harmonics are smaller
    if tail <= unresolved or tail <= 1e-9 * states * size_of_all:  # a billionth of weight and forces is a rounding error
        return states
    # the harmonics of a jump fall as 1 / order; this is an estimate, so a tenth more states are required
    return 100 * int(np.ceil(1.1 * states * tail / unresolved / 100))


def displacement_amplitudes(system: MountedPress, frequency: Array, harmonics: ComplexArray, speed: ArrayLike = 0.0) -> ComplexArray:
    """Complex amplitudes (..., n) of the coordinates for amplitudes (..., n) of the wrench at angular frequencies (...) [rad/s].

    Args:
        system: the press on its mounts.
        frequency: (...) angular frequencies [rad/s].
        harmonics: (..., n) amplitudes of the wrench.
        speed: crank speed at which the rotors spin, a number or (...) [rad/s].

    Raises:
        PinpressError: a frequency is a natural frequency without damping.
    """
    shape, n = harmonics.shape[:-1], harmonics.shape[-1]
    forces = harmonics.reshape(-1, n, 1)
    frequencies, spins = (np.broadcast_to(each, shape).reshape(-1, 1, 1) for each in (frequency, np.asarray(speed)))
    amplitude = np.empty(forces.shape, dtype=complex)
    together = max(1, SOLVED_AT_ONCE // n**2)
    for first in range(0, len(forces), together):
        these = slice(first, first + together)
        w, spin = frequencies[these], spins[these]
        matrix = system.stiffness + 1j * (np.sign(w) * system.loss + w * (system.damping + spin * system.gyroscopic)) - w**2 * system.mass
        try:
            amplitude[these] = np.linalg.solve(matrix, forces[these])
        except np.linalg.LinAlgError:
            raise PinpressError(RESONANCE) from None
    if not np.isfinite(amplitude).all():
        raise PinpressError(RESONANCE)
    return amplitude.reshape(harmonics.shape)


def mount_forces(system: MountedPress, frequency: Array, amplitude: ComplexArray) -> ComplexArray:
    """Complex amplitudes (..., mounts, 3) of the forces of the mounts on the frame [N], from amplitudes (..., n) of the coordinates."""
    stiffness, damping, loss = mount_constants(system)
    w = frequency[..., None, None]
    return np.asarray(-(stiffness + 1j * (np.sign(w) * loss + w * damping)) * np.einsum("mkj,...j->...mk", system.mount_rows, amplitude))


def mount_constants(system: MountedPress) -> tuple[Array, Array, Array]:
    """Stiffness [N/m], damping [N s/m], and stiffness times loss factor [N/m] of the mounts, (mounts, 3) each."""
    stiffness, damping = np.array([m.stiffness for m in system.mounts]), np.array([m.damping for m in system.mounts])
    return stiffness, damping, stiffness * np.array([m.loss_factor for m in system.mounts])[:, None]


def vibration_from_rest(system: MountedPress, wrench: Array, interval: float, motion: Motion) -> tuple[Array, Array, Array]:
    """Displacements, velocities and accelerations (states, n) from rest, under wrenches (states, n) that are linear between states.

    If the speed w of the rotors changes about its mean, the additional moments -(w - mean) G u' - w' G u are also assumed to be linear
    between two states. The moments at the end of a step are solved together with the step.

    Raises:
        PinpressError: the vibration is not finite.
    """
    n, speed = len(system.mass), motion.crank_speed
    a, b = state_matrix(system, mean_speed(system, motion)), np.vstack([np.zeros((n, n)), np.linalg.inv(system.mass)])
    free, early, late = step_matrices(a, b, interval)
    driven = wrench[:-1] @ early.T + wrench[1:] @ late.T
    states, unsteady = np.zeros((len(wrench), 2 * n)), system.gyroscopic.any() and np.ptp(speed) > EVEN * np.abs(speed).max()
    spun = np.zeros((len(wrench), n))  # moments of the rotors from changes of speed
    state = states[0]
    for k in range(len(driven)):
        state = free @ state + driven[k]
        if unsteady:
            state = state + early @ spun[k]
            turning = np.hstack([motion.crank_acceleration[k + 1] * system.gyroscopic, (speed[k + 1] - speed.mean()) * system.gyroscopic])
            state = np.linalg.solve(np.eye(2 * n) + late @ turning, state)
            spun[k + 1] = -turning @ state
        states[k + 1] = state
    if not np.isfinite(states[-1]).all():
        raise PinpressError("the vibration is not finite: the forces are too large for floating point")
    return states[:, :n], states[:, n:], (states @ a.T + (wrench + spun) @ b.T)[:, n:]


def step_matrices(a: Array, b: Array, interval: float) -> tuple[Array, Array, Array]:
    """Matrices of an exact step of x' = a x + b f with f linear over the step: for x, for f at the start, and for f at the end."""
    from scipy.linalg import expm  # slow to import

    n, m = b.shape
    whole = np.zeros((n + 2 * m, n + 2 * m))
    whole[:n, :n], whole[:n, n : n + m], whole[n : n + m, n + m :] = a * interval, b * interval, np.eye(m)
    exponential = expm(whole)
    free, late = exponential[:n, :n], exponential[:n, n + m :]
    return free, exponential[:n, n : n + m] - late, late


def period_of(motion: Motion, period: float | None = None) -> tuple[float, int]:
    """Length of the period of a motion [s], and the number of its states at equal intervals of time, without the end.

    Args:
        motion: the motion.
        period: the length of the period, if given [s].

    Raises:
        PinpressError: no period is given and the motion is not one period at constant speed or of a steady state, or the states do not fill
            the period in equal steps.
    """
    states, speed = len(motion.crank_angle), motion.crank_speed
    if period is not None:
        period, step = number("period", period, "s", positive=True), time_step(motion)
        for count in (states, states - 1):  # the states may or may not include the end of the period
            if abs(count * step - period) <= SAME_STEP * step:
                return period, count
        raise PinpressError(
            f"period is {period:.10g} s, but the {states} states take {(states - 1) * step:.10g} s in steps of {step:.6g} s: give the"
            " motion over one period in equal steps"
        )
    angle = 2 * np.pi * (motion.period_turns or 1)
    if is_cycle(motion):
        if np.ptp(speed) <= EVEN * np.abs(speed).max() and not motion.crank_acceleration.any():
            return angle / abs(float(speed[0])), states
    elif isinstance(motion, Run) and speed.ndim == 1:  # a turn is not defined for several drivers
        turned = abs(motion.crank_angle[-1] - motion.crank_angle[0])
        if (
            turned > 0.5 * angle
            and abs(turned - angle * round(turned / angle)) < SAME_SPEED
            and abs(speed[-1] - speed[0]) <= SAME_SPEED * abs(speed[0])
        ):
            return float(motion.time[-1] - motion.time[0]), states - 1
    raise PinpressError(
        "the motion is no period: give one at constant speed (cycle without angle=) or one period of steady_state, say after which period="
        " in s a motion over time begins again, or use time_response"
    )


def time_step(motion: Motion) -> float:
    """Interval of time between the states of a motion [s].

    Raises:
        PinpressError: there are fewer than two states, or their intervals differ.
    """
    steps = np.diff(motion.time)
    if not len(steps) or steps.min() <= 0 or np.ptp(steps) > SAME_STEP * steps.mean():
        raise PinpressError("the states are not at equal intervals of time: give a run of simulate, or a motion with time= in equal steps")
    return float((motion.time[-1] - motion.time[0]) / len(steps))


def rms_about_mean(force: Array) -> float:
    """Rms of a vector (n, 3) about its mean, all components together."""
    return float(np.sqrt((force.std(axis=0) ** 2).sum()))
