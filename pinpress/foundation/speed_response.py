"""An idle press on its mounts over its range of speeds: what its mounts pass on, and how stiff they may be to keep it from shaking the
floor.

Idle and at constant speed the shaking wrench is a part that the weights of the moving links give, the same at all speeds, and one that
grows with the speed squared; both are found from two cycles, and with them every speed at once.

Mounts isolate what is faster than sqrt(2) times their natural frequency, and the softer they are the more; but soft mounts sag, and the
press sways on them, or tips.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import finite_numbers, typed
from ..common.errors import PinpressError, shown
from ..common.frozen import FrozenMapping, read_only
from ..common.quantities import RPM, Array, ComplexArray
from ..common.results import Tabular
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..kinematics.motion import cycle
from ..linkage.linkage import Linkage
from .mounted_press import MountedPress, mounted, undamped, with_mounts
from .mounts import Frame, Mount, listed_mounts, rows_at
from .response import NOTHING, Points, forcing, mount_forces, named_points, resolved, solved

STATES = 360  # of a turn: harmonics to order 179
ROUNDED = 1e-14  # of the largest force: harmonics that are rounding, left out
AXES = {"x": 0, "y": 1, "z": 2}


@dataclass(frozen=True, eq=False, repr=False)
class SpeedResponse(Tabular):
    """Steady vibration of an idle press at each of (s,) speeds. All arrays are read-only.

    Attributes:
        press_name: of the press.
        speed: (s,) of the crank [rad/s].
        rms: name of a point -> (s, 3) root mean square of its acceleration about its mean [m/s2].
        peak: name of a point -> (s, 3) largest absolute acceleration [m/s2].
        displacement: name of a point -> (s, 3) largest absolute displacement [m].
        shaking_force: (s,) root of the mean of its squares, all components together, beside the weight [N].
        floor_force: (s,) force on the floor, likewise [N].
    """

    press_name: str
    speed: Array
    rms: Mapping[str, Array]
    peak: Mapping[str, Array]
    displacement: Mapping[str, Array]
    shaking_force: Array
    floor_force: Array

    @property
    def title(self) -> str:
        speeds, most = f"{self.speed[0]:.4g} to {self.speed[-1]:.4g} rad/s", self.floor_force.max()
        return f"SpeedResponse of {self.press_name}: {len(self.speed)} speeds, {speeds}, force on the floor up to {most:.4g} N"

    def __str__(self) -> str:
        head = "".join(f"{point + ' [m/s2]':>20}" for point in self.rms)
        lines = [
            f"{self.press_name} idle on its mounts: root mean square of the acceleration, all directions",
            f"  {'speed':>14}{head}{'shaking':>14}{'floor':>14}",
        ]
        for k, speed in enumerate(self.speed):
            size = "".join(f"{np.linalg.norm(values[k]):20.4g}" for values in self.rms.values())
            lines.append(f"  {speed / RPM:6.4g} per min{size}{self.shaking_force[k]:12.4g} N{self.floor_force[k]:12.4g} N")
        return "\n".join(lines)

    @property
    def transmitted(self) -> Array:
        """(s,) force on the floor by shaking force [-].

        Raises:
            PinpressError: nothing shakes at one of the speeds.
        """
        if not self.shaking_force.all():
            raise PinpressError(f"no force of {self.press_name} shakes the frame: there is nothing to transmit")
        return self.floor_force / self.shaking_force

    def growth(self, point: str) -> Array:
        """(s,) exponent p with which a point's acceleration, all directions, grows as speed^p, from speed to speed [-].

        It is 2 on mounts far stiffer than the speed, and more towards a resonance.

        Raises:
            PinpressError: fewer than two speeds at which the point vibrates.
        """
        size = np.linalg.norm(self.rms[point], axis=1)
        if len(size) < 2 or not size.all():
            raise PinpressError(f"the growth of {shown(point)} needs two speeds at which it vibrates")
        return np.asarray(np.gradient(np.log(size), np.log(self.speed)))

    def columns(self) -> dict[str, Array]:
        """Speed, accelerations and displacements of the points, and the forces, as columns with units."""
        columns = {"speed [rad/s]": self.speed}
        for quantity, unit, by_point in (("rms", "m/s2", self.rms), ("peak", "m/s2", self.peak), ("displacement", "m", self.displacement)):
            for point, values in by_point.items():
                columns |= {f"{quantity}_{point}_{axis} [{unit}]": values[:, i] for axis, i in AXES.items()}
        return columns | {"shaking_force [N]": self.shaking_force, "floor_force [N]": self.floor_force}


@typed
def over_speeds(system: MountedPress, speeds: ArrayLike, *, points: Points) -> SpeedResponse:
    """The steady vibration of the idle press at many speeds.

    Args:
        system: the press on its mounts.
        speeds: (s,) of the crank, rising, positive [rad/s].
        points: as of `steady_response`.

    Raises:
        PinpressError: speeds that are none, points that are none.
    """
    speed, rows = rising("speeds", speeds), named_points(system, points)
    frequency, harmonics = spectra(system, speed)
    amplitude = solved(system, frequency, harmonics)
    amplitude[:, 0] = 0.0  # what does not vibrate: rounding of the weight
    states = _states(system)
    by_point = {name: np.einsum("ij,skj->ski", at, amplitude) for name, at in rows.items()}
    acceleration = {name: -(frequency[..., None] ** 2) * values for name, values in by_point.items()}
    return SpeedResponse(
        press_name=system.press.name,
        speed=read_only(speed),
        rms=FrozenMapping({name: read_only(_rms(values, states)) for name, values in acceleration.items()}),
        peak=FrozenMapping({name: read_only(_largest(values, states)) for name, values in acceleration.items()}),
        displacement=FrozenMapping({name: read_only(_largest(values, states)) for name, values in by_point.items()}),
        shaking_force=read_only(shaking_rms(system, harmonics)),
        floor_force=read_only(floor_rms(system, frequency, amplitude)),
    )


@typed
def transmissibility(system: MountedPress, frequency: ArrayLike, *, axis: str = "z") -> Array:
    """Force on the floor along an axis by that of a harmonic force along it, through the mean centre of mass.

    Args:
        system: the press on its mounts.
        frequency: (f,) angular frequencies, rising, positive [rad/s].
        axis: "x", "y" or "z".

    Returns:
        (f,) ratios of the amplitudes [-].

    Raises:
        PinpressError: frequencies or an axis that are none.
    """
    if not isinstance(axis, str) or axis not in AXES:
        raise PinpressError(f"axis is {shown(axis)}: write 'x', 'y' or 'z'")
    w = rising("frequency", frequency)
    force = rows_at(system.parts, system.parts - 1, system.centre)[AXES[axis]]
    amplitude = solved(system, w, np.broadcast_to(force.astype(complex), (len(w), len(force))))
    return np.asarray(np.abs(mount_forces(system, w, amplitude).sum(axis=1)[:, AXES[axis]]))


def spectra(system: MountedPress, speed: Array) -> tuple[Array, ComplexArray]:
    """Angular frequencies (s, k) and one-sided harmonics (s, k, n) of the wrench on the frame, as `numpy.fft.rfft` has them over the
    states of a period. The last ones, that are rounding, are left out."""
    press, fast = system.press, float(speed[-1])
    one, two = (forcing(system, _idle(press, some), None) for some in (fast, 2 * fast))
    growing = (two - one) / (3 * fast**2)
    size = max(np.abs(one).max(), np.abs(system.weight[:3]).max())
    states = _states(system)
    constant, squared = (resolved(np.fft.rfft(part, axis=0), states, size) for part in (one - fast**2 * growing, fast**2 * growing))
    there = np.flatnonzero(np.maximum(np.abs(constant), np.abs(squared)).max(axis=1) > ROUNDED * states * size)
    orders = int(there[-1]) + 1 if len(there) else 1
    harmonics = constant[:orders] + (speed[:, None, None] / fast) ** 2 * squared[:orders]
    return speed[:, None] * (np.arange(harmonics.shape[1]) / press.period_turns), harmonics


def shaking_rms(system: MountedPress, harmonics: ComplexArray) -> Array:
    """(s,) of the shaking force [N], zero where it is rounding."""
    force = sum(harmonics[..., 6 * part : 6 * part + 3] for part in range(system.parts))
    size = np.sqrt((_rms(np.asarray(force), _states(system)) ** 2).sum(axis=1))
    return np.asarray(np.where(size > NOTHING * np.abs(system.weight[:3]).max(), size, 0.0))


def floor_rms(system: MountedPress, frequency: Array, amplitude: ComplexArray) -> Array:
    """(s,) of the force on the floor [N]."""
    return np.asarray(np.sqrt((_rms(mount_forces(system, frequency, amplitude).sum(axis=-2), _states(system)) ** 2).sum(axis=1)))


def rising(name: str, given: ArrayLike) -> Array:
    """An array (s,) of positive, rising numbers, at least one.

    Raises:
        PinpressError: it is none.
    """
    values = finite_numbers(given)
    if values is None or values.ndim != 1 or not len(values) or values[0] <= 0 or (np.diff(values) <= 0).any():
        raise PinpressError(f"{name} is {shown(given)}: give an array of positive numbers, rising [rad/s]")
    return values


def _idle(press: Linkage, speed: float) -> Reactions:
    return inverse_dynamics(press, cycle(press, speed, points=STATES * press.period_turns), bearings=())


def _states(system: MountedPress) -> int:
    """States of a period."""
    return STATES * system.press.period_turns


def _rms(harmonics: ComplexArray, states: int) -> Array:
    """Root mean square (s, ...) of what has these harmonics (s, k, ...), about its mean."""
    return np.asarray(np.sqrt(2 * (np.abs(harmonics[:, 1:]) ** 2).sum(axis=1)) / states)


def _largest(harmonics: ComplexArray, states: int) -> Array:
    return np.asarray(np.abs(np.fft.irfft(harmonics, states, axis=1)).max(axis=1))


TRIALS = 97  # stiffnesses tried, evenly in their logarithm, from the stiffest down
SOFTEST, STIFFEST = 0.01, 4.0  # lowest natural frequency beside the lowest and the highest speed, between which is looked
REFINED = 1e-9  # of the stiffness found, relative


@dataclass(frozen=True, eq=False, repr=False)
class Isolation(Tabular):
    """The stiffest mounts that isolate. All arrays are read-only.

    Attributes:
        system: the press on them.
        mounts: these mounts.
        factor: their stiffness by that of the mounts given [-].
        speed: (s,) of the crank [rad/s].
        transmitted: (s,) force on the floor by shaking force at each speed [-].
    """

    system: MountedPress
    mounts: tuple[Mount, ...]
    factor: float
    speed: Array
    transmitted: Array

    @property
    def title(self) -> str:
        most, speeds = self.transmitted.max(), f"{self.speed[0]:.4g} to {self.speed[-1]:.4g} rad/s"
        return f"Isolation of {self.system.press.name}: {self.factor:.4g} times the stiffness, {most:.3g} transmitted at {speeds}"

    def __str__(self) -> str:
        x, y, z = self.stiffness
        worst = self.speed[self.transmitted.argmax()]
        frequencies = ", ".join(f"{w / (2 * np.pi):.3g}" for w in np.sqrt(undamped(self.system)[0]))
        return "\n".join(
            [
                f"{self.system.press.name}: the stiffest mounts that isolate, {self.factor:.4g} times as stiff as those given",
                f"  all together        {x:12.4g} {y:12.4g} {z:12.4g} N/m along x, y, z",
                f"  natural frequencies {frequencies} Hz",
                f"  sag at rest         {1e3 * self.sag:12.4g} mm",
                f"  transmitted         {self.transmitted.max():12.4g} at most, at {worst / RPM:.4g} per min",
            ]
        )

    def columns(self) -> dict[str, Array]:
        """Speed and share transmitted as columns; the mounts' are those of `system`."""
        return {"speed [rad/s]": self.speed, "transmitted [-]": self.transmitted}

    @property
    def stiffness(self) -> Array:
        """(3,) of all mounts together along x, y and z [N/m]."""
        return np.asarray(np.sum([mount.stiffness for mount in self.mounts], axis=0))

    @property
    def sag(self) -> float:
        """Largest vertical displacement of a mount at rest [m]."""
        return _sag(self.system)


@typed
def isolate(
    press: Linkage,
    frame: Frame,
    mounts: Sequence[Mount],
    *,
    speeds: ArrayLike,
    transmitted: float,
    sag: float | None = None,
) -> Isolation:
    """The stiffest mounts with which the idle press passes on at most a share of its shaking force, at every one of its speeds.

    Args:
        press: with one driver that turns fully.
        frame: in one part.
        mounts: where they stand, and their ratios of stiffness. All their stiffnesses are multiplied by one factor, their damping by its
            root, which keeps damping ratios as they are.
        speeds: (s,) of the crank, rising, close enough that no resonance falls between two [rad/s].
        transmitted: force on the floor by shaking force, roots of mean squares, more than 0 and less than 1.
        sag: largest displacement of a mount at rest [m]; None: any.

    Raises:
        PinpressError: an argument that makes no sense; a press that shakes nothing; no such mounts: the error names what conflicts.
    """
    speed, mounts = rising("speeds", speeds), listed_mounts(mounts, "mounts")
    limit = _between("transmitted", transmitted, 1.0, "a share, more than 0 and less than 1")
    most_sag = None if sag is None else _between("sag", sag, np.inf, "a positive length [m]")
    given = mounted(press, frame, mounts)
    frequency, harmonics = spectra(given, speed)
    shaking = shaking_rms(given, harmonics)
    wish = f"pass on at most {limit:g} of the shaking force between {speed[0] / RPM:.4g} and {speed[-1] / RPM:.4g} per min"
    if not shaking.all():
        raise PinpressError(f"no force of {press.name} shakes the frame: it needs no isolation")

    def passed(factor: float) -> Array:
        try:
            system = with_mounts(given, _scaled(mounts, factor))
        except PinpressError:  # it tips
            return np.full(len(speed), np.inf)
        return floor_rms(system, frequency, solved(system, frequency, harmonics)) / shaking

    lowest = float(undamped(given)[0][0])
    factors = np.geomspace((STIFFEST * speed[-1]) ** 2 / lowest, (SOFTEST * speed[0]) ** 2 / lowest, TRIALS)
    worst: list[float] = []
    for factor in factors:
        worst.append(float(passed(float(factor)).max()))
        if worst[-1] <= limit:
            break
    else:
        best = int(np.argmin(worst))
        raise PinpressError(
            f"no stiffness lets these mounts {wish}: the least is {worst[best]:.3g}, at {factors[best]:.3g} times theirs; lower their"
            " damping, set them wider apart and nearer to the height of the centre of mass, against tipping and rocking, or give the"
            " frame more mass"
        )
    low, high = float(factors[len(worst) - 1]), float(factors[max(len(worst) - 2, 0)])
    while high > (1 + REFINED) * low:
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if passed(middle).max() <= limit else (low, middle)
    chosen = _scaled(mounts, low)
    system = with_mounts(given, chosen)
    if most_sag is not None and _sag(system) > most_sag:
        raise PinpressError(
            f"isolation and sag conflict: to {wish} the mounts may be at most {low:.4g} times as stiff as those given, but sag"
            f" {1e3 * _sag(system):.4g} mm then; {1e3 * most_sag:.4g} mm need {low * _sag(system) / most_sag:.4g} times: allow more sag or"
            " more force, or raise the lowest speed"
        )
    share = passed(low)
    return Isolation(system, chosen, low, speed, share)


def _scaled(mounts: Sequence[Mount], factor: float) -> tuple[Mount, ...]:
    return tuple(
        replace(
            mount,
            stiffness=tuple(factor * np.array(mount.stiffness)),
            damping=tuple(np.sqrt(factor) * np.array(mount.damping)),
            static_stiffness=tuple(factor * np.array(mount.static)),
        )
        for mount in mounts
    )


def _sag(system: MountedPress) -> float:
    return float(np.abs(system.sag[:, 2]).max())


def _between(name: str, given: object, upper: float, wanted: str) -> float:
    value = finite_numbers(given)
    if value is None or value.ndim or not 0 < value < upper:
        raise PinpressError(f"{name} is {shown(given)}: give {wanted}")
    return float(value)
