"""How a press vibrates on its mounts: what shakes the frame, and the motion of its points and the force on the floor that follow, in the
steady state, by the harmonics of the shaking force, and in time.

The frame is shaken by shaking force and moment of the machine, less its weight, and by the moment of a flywheel that changes its speed. Of
a periodic motion every harmonic is solved by itself, (K + i K'' + i w C - w^2 M) U = F: exact for forces that its states resolve. In time
the force is taken for a line between two states; with it a step of the linear system is exact (first-order hold: the matrix exponential of
(x, f, f') over a step), whatever the step beside the natural periods.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import finite_numbers, typed
from ..common.errors import PinpressError, UnknownNameError, expect, shown
from ..common.frozen import FrozenMapping
from ..common.quantities import Array, ComplexArray
from ..common.results import Tabular
from ..drives.transmission import Flywheel
from ..dynamics.harmonics import is_cycle
from ..dynamics.inverse_dynamics import Reactions
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..simulation.run import Run
from .mounted_press import MountedPress, quadrature, state_matrix
from .mounts import rows_at

UNRESOLVED = 1e-3  # share of the last third of the harmonics from which the states do not resolve the force
ROUNDING = 1e-9  # of weight and forces
RESONANCE = "a harmonic meets a natural frequency that has no damping: give the mounts damping or a loss factor, or another speed"

Points = Mapping[str, "ArrayLike | tuple[str, ArrayLike]"]


@typed
def steady_response(system: MountedPress, reactions: Reactions, *, points: Points, flywheel: Flywheel | None = None) -> FrameMotion:
    """The vibration of one period, when all that began it has died away.

    Args:
        system: the press on its mounts.
        reactions: of one period at constant speed (`cycle`), or of one period of `steady_state`.
        points: name -> (3,) point of the frame, world axes [m]; of a frame in two parts (3,) of the bed, or ("crown", (3,)).
        flywheel: on the crank's shaft; it matters where the speed changes. Its inertia is its angular momentum about the crank's axis by
            the crank's speed: of one on a shaft beside, its inertia times the ratio of its speed, negative where that turns the other way.

    Raises:
        PinpressError: an argument that makes no sense, a motion that is no period, or too few states for its shaking force.
    """
    wrench = forcing(system, reactions, flywheel)
    placed = named_points(system, points)
    length, states = period(reactions.motion)
    harmonics = resolved(np.fft.rfft(wrench[:states], axis=0), states, max(np.abs(wrench).max(), np.abs(system.weight[:3]).max()))
    frequency = np.linspace(0.0, 2 * np.pi / length * (len(harmonics) - 1), len(harmonics))
    amplitude = solved(system, frequency, harmonics)

    def in_time(spectrum: ComplexArray) -> Array:
        return np.fft.irfft(spectrum, states, axis=0)

    velocity = 1j * frequency[:, None] * amplitude
    return FrameMotion.of(
        system,
        time=np.linspace(0.0, length, states, endpoint=False),
        points=placed,
        motion=(in_time(amplitude), in_time(velocity), in_time(1j * frequency[:, None] * velocity)),
        mount_force=in_time(mount_forces(system, frequency, amplitude).reshape(len(frequency), -1)).reshape(states, -1, 3),
        forcing=in_time(harmonics),
        period=length,
    )


@typed
def time_response(system: MountedPress, reactions: Reactions, *, points: Points, flywheel: Flywheel | None = None) -> FrameMotion:
    """The vibration from rest, in the static position, as the press runs.

    What begins in full swing shakes a frame at rest; that dies away with the modes' damping.

    Args:
        system: the press on its mounts.
        reactions: of a run of `simulate`, or of any motion in equal steps of time.
        points: as of `steady_response`.
        flywheel: as of `steady_response`.

    Raises:
        PinpressError: an argument that makes no sense, or states that are not at equal intervals of time.
    """
    wrench = forcing(system, reactions, flywheel)
    placed, interval = named_points(system, points), step(reactions.motion)
    u, velocity, acceleration = stepped(system, wrench, interval)
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
        forcing=wrench,
        period=None,
    )


def stepped(system: MountedPress, wrench: Array, interval: float) -> tuple[Array, Array, Array]:
    """Displacements, velocities and accelerations (states, n) from rest under wrenches (states, n), linear in between."""
    from scipy.linalg import expm  # slow to import

    n = len(system.mass)
    a, b = state_matrix(system), np.vstack([np.zeros((n, n)), np.linalg.inv(system.mass)])
    whole = np.zeros((4 * n, 4 * n))
    whole[: 2 * n, : 2 * n], whole[: 2 * n, 2 * n : 3 * n], whole[2 * n : 3 * n, 3 * n :] = a * interval, b * interval, np.eye(n)
    exponential = expm(whole)
    free, late = exponential[: 2 * n, : 2 * n], exponential[: 2 * n, 3 * n :]
    early = exponential[: 2 * n, 2 * n : 3 * n] - late
    driven = wrench[:-1] @ early.T + wrench[1:] @ late.T
    states = np.zeros((len(wrench), 2 * n))
    state = states[0]
    for k in range(len(driven)):
        state = free @ state + driven[k]
        states[k + 1] = state
    if not np.isfinite(states[-1]).all():
        raise PinpressError("the vibration is not finite: the forces are too large for floating point")
    return states[:, :n], states[:, n:], (states @ a.T + wrench @ b.T)[:, n:]


def solved(system: MountedPress, frequency: Array, harmonics: ComplexArray) -> ComplexArray:
    """Amplitudes (..., n) of the displacement for those of the wrench (..., n) at angular frequencies (...).

    Raises:
        PinpressError: a resonance without damping.
    """
    w = frequency[..., None, None]
    matrix = system.stiffness + 1j * (np.sign(w) * system.loss + w * system.damping) - w**2 * system.mass
    try:
        amplitude = np.linalg.solve(matrix, harmonics[..., None])[..., 0]
    except np.linalg.LinAlgError:
        raise PinpressError(RESONANCE) from None
    if not np.isfinite(amplitude).all():
        raise PinpressError(RESONANCE)
    return np.asarray(amplitude)


def mount_forces(system: MountedPress, frequency: Array, amplitude: ComplexArray) -> ComplexArray:
    """Amplitudes (..., mounts, 3) of what the mounts exert on the frame."""
    stiffness, damping, loss = mount_constants(system)
    w = frequency[..., None, None]
    return np.asarray(-(stiffness + 1j * (np.sign(w) * loss + w * damping)) * np.einsum("mkj,...j->...mk", system.mount_rows, amplitude))


def mount_constants(system: MountedPress) -> tuple[Array, Array, Array]:
    """Stiffness, damping, and stiffness times loss factor of the mounts, (mounts, 3) each."""
    stiffness, damping = np.array([m.stiffness for m in system.mounts]), np.array([m.damping for m in system.mounts])
    return stiffness, damping, stiffness * np.array([m.loss_factor for m in system.mounts])[:, None]


def resolved(harmonics: ComplexArray, states: int, size_of_all: float) -> ComplexArray:
    """Harmonics (k, n) of a wrench over a period of so many states, the one of half their number, whose phase is not known, left out.

    ``size_of_all``: of what the wrench was worked out from, beside which some of it is rounding [N].

    Raises:
        PinpressError: the last third of them is no rounding: the force has jumps, or corners too sharp for the states.
    """
    size = np.abs(harmonics[1:]).reshape(len(harmonics) - 1, -1, 3).max(axis=(1, 2))
    tail = size[2 * len(size) // 3 :].max(initial=0.0)
    if tail > UNRESOLVED * size.max(initial=0.0) and tail > ROUNDING * states * size_of_all:
        raise PinpressError(
            f"{states} states do not resolve the shaking force, which changes too sharply: give more points, or a run to time_response"
        )
    if states % 2 == 0:
        harmonics[-1] = 0.0
    return harmonics


def named_points(system: MountedPress, points: Points) -> dict[str, Array]:
    """(3, n) rows of points by their names.

    Raises:
        PinpressError: no names, a point that is none, or one of a crown that there is not.
    """
    expect("points", points, Mapping, "{'top_beam': (x, y, z), ...}")
    rows = {}
    for name, given in points.items():
        part, place = (1, given[1]) if isinstance(given, tuple) and len(given) == 2 and given[0] == "crown" else (0, given)
        point = finite_numbers(place)
        if not isinstance(name, str) or point is None or point.shape != (3,):
            raise PinpressError(f"point {shown(name)} is {shown(given)}: give x, y, z [m] under a name, or ('crown', (x, y, z))")
        if part >= system.parts:
            raise PinpressError(f"point {shown(name)} is one of the crown, but the frame is in one part: give x, y, z alone")
        rows[name] = rows_at(system.parts, part, point)
    return rows


NOTHING = 1e-9  # of the weight: a shaking force that is rounding


@dataclass(frozen=True, eq=False, repr=False)
class FrameMotion(Tabular):
    """Vibration about the static position at n states. All arrays are read-only.

    Attributes:
        system: the press on its mounts.
        time: (n,) of the states [s].
        period: of a motion that is one period, its end left out [s]; else None.
        displacement: name of a point -> (n, 3) in world axes [m].
        velocity: name of a point -> (n, 3) in world axes [m/s].
        acceleration: name of a point -> (n, 3) in world axes [m/s2].
        coordinates: (n, coordinates) of the frame's parts, see `mounted_press` [m, rad].
        mount_force: (n, mounts, 3) what each mount exerts on the frame beside its static load [N].
        floor_force: (n, 3) what the mounts exert on the floor beside the weight [N].
        floor_moment: (n, 3) of these forces about the world origin [N m].
        shaking_force: (n, 3) of the machine beside its weight [N].
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

    def __str__(self) -> str:
        """Points, forces and mounts; units beside every number."""
        over = f"one period of {self.period:.6g} s" if self.period is not None else f"{self.time[-1]:.6g} s from rest"
        lines = [
            f"{self.system.press.name} on {len(self.system.mounts)} mounts: {over}",
            f"  {'acceleration [m/s2]':<24}{'rms x':>12}{'rms y':>12}{'rms z':>12}{'peak x':>12}{'peak y':>12}{'peak z':>12}",
        ]
        for point in self.acceleration:
            numbers = [*self.rms(point), *self.peak(point)]
            lines.append(f"  {point:<24}" + "".join(f"{number:12.4g}" for number in numbers))
        lines += [
            f"  {'shaking force, rms':<24}{spread(self.shaking_force):12.4g} N",
            f"  {'force on the floor, rms':<24}{spread(self.floor_force):12.4g} N",
        ]
        least = self.least_load
        number = int(least.argmin())
        lifts = ", which lifts off unless it is bolted down" if least[number] < 0 else ""
        lines.append(f"  {'least load on a mount':<24}{least[number]:12.4g} N on mount {number}{lifts}")
        pressures = [pressure for pressure in self.system.pressure if pressure is not None]
        if pressures:
            lines.append(f"  {'mean pressure at rest':<24}{max(pressures) / 1e6:12.4g} MPa at most")
        lines.append(f"  {'sag at rest':<24}{1e3 * np.abs(self.system.sag[:, 2]).max():12.4g} mm at most")
        return "\n".join(lines)

    @classmethod
    def of(
        cls,
        system: MountedPress,
        time: Array,
        points: Mapping[str, Array],
        motion: tuple[Array, Array, Array],
        mount_force: Array,
        forcing: Array,
        period: float | None,
    ) -> FrameMotion:
        """The motion of points from that of the coordinates.

        Args:
            system: the press on its mounts.
            time: (n,) of the states [s].
            points: name of a point -> (3, coordinates) its displacement for each coordinate.
            motion: displacements, velocities and accelerations of the coordinates, (n, coordinates) each.
            mount_force: (n, mounts, 3) what each mount exerts on the frame beside its static load [N].
            forcing: (n, coordinates) wrenches on the parts of the frame [N, N m].
            period: of a motion that is one period [s].
        """
        moved = [{name: np.array(values @ rows.T) for name, rows in points.items()} for values in motion]
        places = np.array([mount.point for mount in system.mounts])
        shaking = sum(forcing[:, 6 * part : 6 * part + 3] for part in range(system.parts))
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
            shaking_force=np.array(np.asarray(shaking)),
        )

    @property
    def transmitted(self) -> float:
        """Force on the floor by shaking force, both as roots of the mean of their squares about their means [-].

        Raises:
            PinpressError: nothing shakes.
        """
        shaking = spread(self.shaking_force)
        if shaking <= NOTHING * np.abs(self.system.weight[:3]).max():
            raise PinpressError(f"no force of {self.system.press.name} shakes the frame: there is nothing to transmit")
        return spread(self.floor_force) / shaking

    @property
    def least_load(self) -> Array:
        """(mounts,) smallest load on each mount, static one included [N].

        Where it is negative, a mount that is not bolted down lifts off, and the linear model does not hold.
        """
        least: Array = (self.system.mount_load[:, 2] + self.mount_force[:, :, 2]).min(axis=0)
        return least

    def rms(self, point: str) -> Array:
        """(3,) root mean square of a point's acceleration about its mean, in world axes [m/s2].

        Raises:
            UnknownNameError: no such point.
        """
        return np.asarray(self._of(point).std(axis=0))

    def peak(self, point: str) -> Array:
        """(3,) largest absolute acceleration of a point [m/s2].

        Raises:
            UnknownNameError: no such point.
        """
        return np.asarray(np.abs(self._of(point)).max(axis=0))

    def _of(self, point: str) -> Array:
        if point not in self.acceleration:
            raise UnknownNameError("point", point, self.acceleration)
        return self.acceleration[point]

    def columns(self) -> dict[str, Array]:
        """Time, the points' displacement, velocity and acceleration, and floor and shaking force, as columns with units."""
        columns = {"time [s]": self.time}
        quantities = (
            ("displacement", "m", self.displacement),
            ("velocity", "m/s", self.velocity),
            ("acceleration", "m/s2", self.acceleration),
        )
        for quantity, unit, by_point in quantities:
            for point, values in by_point.items():
                columns |= {f"{quantity}_{point}_{axis} [{unit}]": values[:, i] for i, axis in enumerate("xyz")}
        for name, unit, values in (
            ("floor_force", "N", self.floor_force),
            ("floor_moment", "N m", self.floor_moment),
            ("shaking_force", "N", self.shaking_force),
        ):
            columns |= {f"{name}_{axis} [{unit}]": values[:, i] for i, axis in enumerate("xyz")}
        return columns


def spread(force: Array) -> float:
    """Root of the mean square of a vector (n, 3) about its mean."""
    return float(np.sqrt((force.std(axis=0) ** 2).sum()))


EVEN = 1e-9  # difference of steps of time, or of the crank's speed, beside themselves that is none
SAME_SPEED = 1e-6  # of the crank at both ends of a period, and of flywheel and crank


def forcing(system: MountedPress, reactions: Reactions, flywheel: Flywheel | None) -> Array:
    """Wrenches (states, n) about the world origin on the parts of the frame, beside the weight at its mean place [N, N m].

    Of a frame in two parts the loads on the frame act on the bed, all else on the crown. The torque of a motor on the frame is no load: its
    casing turns back on the frame what its rotor gives the crank. The flywheel is not in the URDF: by J w' of its own the frame must turn
    the other way. ``flywheel.inertia`` is its angular momentum about the crank's axis by the crank's speed: that of one on a shaft beside
    is its inertia times the ratio of its speed, negative where that turns the other way.

    Raises:
        PinpressError: reactions of another press, a flywheel in scenarios, on a driver that is not on the frame, or behind a
            slipping clutch.
    """
    expect("system", system, MountedPress, "mounted")
    expect("reactions", reactions, Reactions, "inverse_dynamics")
    press = system.press
    if reactions._press is not press:
        raise PinpressError(
            f"the reactions are of {reactions._press.name}, loaded apart from the press on its mounts: use one Linkage for both"
        )
    shaking = np.hstack([reactions.shaking_force, reactions.shaking_moment])
    wrench = np.zeros((len(shaking), 6 * system.parts))
    wrench[:, -6:] = shaking - system.press_weight
    if flywheel is not None:
        wrench[:, -3:] += flywheel_moment(press, reactions.motion, flywheel)
    if system.parts == 2:
        for load in reactions._under.loads:
            if load.joint == 0:
                on_bed = np.hstack([load.force, np.cross(load.point, load.force)])
                wrench[:, :6] += on_bed
                wrench[:, 6:] -= on_bed
    return wrench


@typed
def flywheel_moment(press: Linkage, motion: Motion, flywheel: Flywheel) -> Array:
    """Moment of a flywheel on the frame, -J w' about the crank's axis.

    Args:
        press: the press, whose driver joint is on the frame.
        motion: of this press.
        flywheel: on the crank's shaft, see `steady_response`.

    Returns:
        (states, 3) in world axes [N m].

    Raises:
        PinpressError: a flywheel with the inertias of several scenarios, on a driver that is not on the frame, or behind a clutch that
            slips.
    """
    if np.ndim(flywheel.inertia):
        raise PinpressError("flywheel has the inertias of several scenarios: give one")
    driver = press.driver_indices[0]
    if press.model.parents[driver + 1] != 0:
        raise PinpressError(
            f"the driver joint {shown(press.driver)} is not on the frame: the moment of its flywheel has no fixed axis there"
        )
    if isinstance(motion, Run):
        difference = np.abs(motion.drive_speed - motion.crank_speed).max()
        if difference > SAME_SPEED * np.abs(motion.crank_speed).max():
            raise PinpressError(
                f"flywheel and crank differ in speed by up to {difference:.4g} rad/s, as a clutch slips: give a run, or the part of one,"
                " in which it holds"
            )
    axis = press.model.jointPlacements[driver + 1].rotation @ press.axes[driver].direction
    return np.asarray(-float(flywheel.inertia) * motion.crank_acceleration[:, None] * axis)


def period(motion: Motion) -> tuple[float, int]:
    """Period [s] of a periodic motion, and its states, equal intervals of time apart, the end left out.

    Raises:
        PinpressError: neither one period at constant speed nor one of a steady state.
    """
    states, speed = len(motion.crank_angle), motion.crank_speed
    angle = 2 * np.pi * (motion.period_turns or 1)
    if is_cycle(motion):
        if np.ptp(speed) <= EVEN * np.abs(speed).max() and not motion.crank_acceleration.any():
            return angle / abs(float(speed[0])), states
    elif isinstance(motion, Run):
        turned = abs(motion.crank_angle[-1] - motion.crank_angle[0])
        if (
            turned > 0.5 * angle
            and abs(turned - angle * round(turned / angle)) < SAME_SPEED
            and abs(speed[-1] - speed[0]) <= SAME_SPEED * abs(speed[0])
        ):
            return float(motion.time[-1] - motion.time[0]), states - 1
    raise PinpressError(
        "the motion is no period: give one at constant speed (cycle without angle=) or one period of steady_state, or use time_response"
    )


def step(motion: Motion) -> float:
    """Interval of time between the states of a motion [s].

    Raises:
        PinpressError: fewer than two states, or states that are not equal intervals apart.
    """
    steps = np.diff(motion.time)
    if not len(steps) or steps.min() <= 0 or np.ptp(steps) > 1e-6 * steps.mean():
        raise PinpressError("the states are not at equal intervals of time: give a run of simulate, or a motion with time= in equal steps")
    return float((motion.time[-1] - motion.time[0]) / len(steps))
