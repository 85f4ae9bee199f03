"""An idle press on its mounts over its range of speeds: its vibration, and the stiffest mounts that isolate the floor from it.

The shaking wrench of an idle press at constant speed has two parts. The part from the weights of the moving links is the same at all
speeds; the other part is proportional to the squared speed. Two cycles determine both parts, and so the wrench at all speeds.

Mounts isolate vibrations above sqrt(2) times the natural frequency. Softer mounts isolate better, but they sag more, and the press sways or
tips on them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import rising_speeds, suitable_numbers, typed
from ..common.errors import PinpressError, shown
from ..common.frozen import FrozenMapping, read_only
from ..common.quantities import RPM, Array, ComplexArray
from ..common.results import Tabular
from ..common.tables import by_axis
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..kinematics.cycle import doubt_speeds, period_at
from ..linkage.linkage import Linkage, OfPress
from .elastic_frame import ElasticFrame
from .frame_parts import axis_index, rows_at
from .mounted_press import MountedPress, mounted, natural_modes, with_mounts
from .mounts import Frame, Mount, listed_mounts
from .response import NOTHING, Points, checked_harmonics, displacement_amplitudes, frame_wrench, mount_forces, named_points

STATES = 360  # states of a turn, which resolve harmonics to order 179


@dataclass(frozen=True, eq=False, repr=False)
class SpeedResponse(OfPress, Tabular):
    """Steady-state vibration of an idle press at s speeds. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        speed: (s,) speeds of the crank [rad/s].
        rms: name of a point -> (s, 3) rms of its acceleration about its mean, in world axes [m/s2].
        peak: name of a point -> (s, 3) largest absolute acceleration, in world axes [m/s2].
        displacement: name of a point -> (s, 3) largest absolute displacement, in world axes [m].
        shaking_force: (s,) rms of the shaking force, weight excluded, all components together [N].
        floor_force: (s,) rms of the force on the floor, weight excluded, all components together [N].
    """

    _press: Linkage
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

    @property
    def transmitted(self) -> Array:
        """(s,) force on the floor divided by the shaking force [-].

        Raises:
            PinpressError: the shaking force is zero at one of the speeds.
        """
        if not self.shaking_force.all():
            raise PinpressError(f"no force of {self.press_name} shakes the frame: there is nothing to transmit")
        return self.floor_force / self.shaking_force

    def growth(self, point: str) -> Array:
        """(s,) exponent p of the local growth speed^p of a point's acceleration at each speed, all directions together [-].

        It is 2 on very stiff mounts, on which the frame hardly moves, and larger just below a resonance.

        Raises:
            PinpressError: the point vibrates at fewer than two speeds.
        """
        size = np.linalg.norm(self.rms[point], axis=1)
        if len(size) < 2 or not size.all():
            raise PinpressError(f"the growth of {shown(point)} needs two speeds at which it vibrates")
        return np.asarray(np.gradient(np.log(size), np.log(self.speed)))

    def columns(self) -> dict[str, Array]:
        """Speed, accelerations and displacements of the points, and the forces."""
        columns = {"speed [rad/s]": self.speed}
        for quantity, unit, by_point in (("rms", "m/s2", self.rms), ("peak", "m/s2", self.peak), ("displacement", "m", self.displacement)):
            for point, values in by_point.items():
                columns |= by_axis(f"{quantity}_{point}", unit, values)
        return columns | {"shaking_force [N]": self.shaking_force, "floor_force [N]": self.floor_force}


@typed
def over_speeds(system: MountedPress, speeds: ArrayLike, *, points: Points) -> SpeedResponse:
    """The steady-state vibration of the idle press at many speeds.

    Args:
        system: the press on its mounts.
        speeds: (s,) speeds of the crank, positive and rising [rad/s].
        points: points of the frame by name, as for `steady_response`.

    Raises:
        PinpressError: the speeds are not positive and rising, a point is not as described, or a harmonic meets a natural frequency without
            damping.
    """
    speed, rows = rising_speeds("speeds", speeds), named_points(system, points)
    frequency, harmonics = wrench_spectra(system, speed)
    amplitude = displacement_amplitudes(system, frequency, harmonics, speed[:, None])
    amplitude[:, 0] = 0.0  # the mean is a rounding error of the weight, not a vibration
    states = _states(system)
    by_point = {name: np.einsum("ij,skj->ski", at, amplitude) for name, at in rows.items()}
    acceleration = {name: -(frequency[..., None] ** 2) * values for name, values in by_point.items()}
    return SpeedResponse(
        _press=system.press,
        speed=read_only(speed),
        rms=FrozenMapping({name: read_only(_rms(values, states)) for name, values in acceleration.items()}),
        peak=FrozenMapping({name: read_only(_largest(values, states)) for name, values in acceleration.items()}),
        displacement=FrozenMapping({name: read_only(_largest(values, states)) for name, values in by_point.items()}),
        shaking_force=read_only(shaking_rms(system, harmonics)),
        floor_force=read_only(floor_rms(system, frequency, amplitude)),
    )


@typed
def transmissibility(system: MountedPress, frequency: ArrayLike, *, axis: str = "z") -> Array:
    """Force on the floor along an axis / harmonic force along this axis through the mean centre of mass of frame and press.

    The rotors do not spin.

    Args:
        system: the press on its mounts.
        frequency: (f,) angular frequencies, positive and rising [rad/s].
        axis: "x", "y" or "z".

    Returns:
        (f,) ratios of the amplitudes [-].

    Raises:
        PinpressError: the frequencies are not positive and rising, the axis is not "x", "y" or "z", or a frequency is a natural frequency
            without damping.
    """
    along = axis_index(axis)
    w = rising_speeds("frequency", frequency)
    force = rows_at(system.parts[system.carrier], system.centre)[along]
    amplitude = displacement_amplitudes(system, w, np.broadcast_to(force.astype(complex), (len(w), len(force))))
    return np.asarray(np.abs(mount_forces(system, w, amplitude).sum(axis=1)[:, along]))


@dataclass(frozen=True, eq=False, repr=False)
class Isolation(Tabular):
    """The stiffest mounts that isolate, found by `isolate`. All arrays are read-only.

    Attributes:
        system: the press on these mounts.
        mounts: the mounts.
        factor: stiffness of the mounts / stiffness of the given mounts [-].
        speed: (s,) speeds of the crank [rad/s].
        transmitted: (s,) force on the floor divided by the shaking force at each speed [-].
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

    def columns(self) -> dict[str, Array]:
        """Speed and transmitted share. The columns of ``system`` list the mounts."""
        return {"speed [rad/s]": self.speed, "transmitted [-]": self.transmitted}

    @property
    def stiffness(self) -> Array:
        """(3,) stiffness of all mounts together along x, y and z [N/m]."""
        return np.asarray(np.sum([mount.stiffness for mount in self.mounts], axis=0))

    @property
    def sag(self) -> float:
        """Largest vertical displacement of a mount at rest [m]."""
        return float(np.abs(self.system.downward_sag).max())


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
    """Find the stiffest mounts that transmit at most a given share of the idle press's shaking force at all given speeds.

    All stiffnesses of the given mounts are multiplied by one factor, and their damping by the root of the factor, which keeps the damping
    ratios.

    Args:
        press: a press with one driver, which turns fully.
        frame: the frame, in one part.
        mounts: the mounts, whose stiffnesses are multiplied by the factor.
        speeds: (s,) speeds of the crank, positive and rising, in steps so small that no resonance lies unseen between two speeds [rad/s].
        transmitted: largest ratio of the force on the floor to the shaking force, both as rms, between 0 and 1 [-].
        sag: largest permissible displacement of a mount at rest [m]; None: no limit.

    Raises:
        PinpressError: an argument is not as described, nothing shakes the frame, or no mounts meet the demands; the message names the
            demands that conflict.
    """
    speed, mounts = rising_speeds("speeds", speeds), listed_mounts(mounts, "mounts")
    wanted = "a share, more than 0 and less than 1"
    limit = float(suitable_numbers("transmitted", transmitted, wanted, suits=lambda share: 0 < share < 1))
    most_sag = None if sag is None else float(suitable_numbers("sag", sag, "a positive length [m]", suits=lambda length: length > 0))
    press.refuse_several_drivers(
        "mounts are sought over the speeds of one crank; compare steady_response of several mounts in their motion"
    )
    as_given = mounted(press, frame, mounts)
    frequency, harmonics = wrench_spectra(as_given, speed)
    shaking = shaking_rms(as_given, harmonics)
    if not shaking.all():
        raise PinpressError(f"no force of {press.name} shakes the frame: it needs no isolation")

    def transmit(factor: float) -> Array:
        try:
            system = with_mounts(as_given, _scale(mounts, factor))
        except PinpressError:  # the press tips over
            return np.full(len(speed), np.inf)
        return floor_rms(system, frequency, displacement_amplitudes(system, frequency, harmonics)) / shaking

    wish = f"pass on at most {limit:g} of the shaking force between {speed[0] / RPM:.4g} and {speed[-1] / RPM:.4g} per min"
    # the range is surely wide enough: from a lowest natural frequency of four times the highest speed (no isolation) to a hundredth of the
    # lowest speed (too soft to stand on)
    lowest = float(natural_modes(as_given)[0][0])
    factors = np.geomspace((4.0 * speed[-1]) ** 2 / lowest, (0.01 * speed[0]) ** 2 / lowest, 97)
    factor = _stiffest_factor(transmit, factors, limit, wish)
    stiffest = _scale(mounts, factor)
    result = Isolation(with_mounts(as_given, stiffest), stiffest, factor, speed, transmit(factor))
    if most_sag is not None and result.sag > most_sag:
        raise PinpressError(
            f"isolation and sag conflict: to {wish} the mounts may be at most {factor:.4g} times as stiff as those given, but sag"
            f" {1e3 * result.sag:.4g} mm then; {1e3 * most_sag:.4g} mm need {factor * result.sag / most_sag:.4g} times: allow more sag"
            " or more force, or raise the lowest speed"
        )
    return result


def _stiffest_factor(transmit: Callable[[float], Array], factors: Array, limit: float, wish: str) -> float:
    """The largest factor of the stiffness at which all shares (s,) of ``transmit`` are within the limit, refined between two of the falling
    trial factors.

    Raises:
        PinpressError: no trial factor keeps the limit; ``wish``: the demand as text, for the message.
    """
    worst: list[float] = []
    for factor in factors:
        worst.append(float(transmit(float(factor)).max()))
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
    while high > (1 + 1e-9) * low:  # the stiffness to nine digits
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if transmit(middle).max() <= limit else (low, middle)
    return low


def wrench_spectra(system: MountedPress, speed: Array) -> tuple[Array, ComplexArray]:
    """Angular frequencies (s, k) [rad/s] and harmonics (s, k, n) of the wrench on the frame at each speed, scaled as in `numpy.fft.rfft`.

    The highest harmonics are left out, because they are rounding errors.
    """
    press, fast = system.press, float(speed[-1])
    doubt_speeds(press, fast)
    # each bearing acts on an elastic frame at its own interface
    bearings = tuple(system.frame.bearings) if isinstance(system.frame, ElasticFrame) else ()

    def wrench(at_speed: float) -> Array:
        idle = inverse_dynamics(press, period_at(press, at_speed, _states(system)), bearings=bearings)
        return frame_wrench(system, idle, None)

    one, two = wrench(fast), wrench(2 * fast)
    growing = (two - one) / (3 * fast**2)
    size = max(np.abs(one).max(), np.abs(system.weight[:3]).max())
    states = _states(system)
    constant, squared = (
        checked_harmonics(np.fft.rfft(part, axis=0), states, size) for part in (one - fast**2 * growing, fast**2 * growing)
    )
    # other harmonics are rounding errors of the largest force
    significant = np.flatnonzero(np.maximum(np.abs(constant), np.abs(squared)).max(axis=1) > 1e-14 * states * size)
    orders = int(significant[-1]) + 1 if len(significant) else 1
    harmonics = constant[:orders] + (speed[:, None, None] / fast) ** 2 * squared[:orders]
    return speed[:, None] * (np.arange(harmonics.shape[1]) / press.period_turns), harmonics


def shaking_rms(system: MountedPress, harmonics: ComplexArray) -> Array:
    """Root mean square (s,) of the shaking force, all components together; zero if it is a rounding error [N]."""
    size = np.linalg.norm(_rms((harmonics @ system.rigid)[..., :3], _states(system)), axis=1)
    return np.asarray(np.where(size > NOTHING * np.abs(system.weight[:3]).max(), size, 0.0))


def floor_rms(system: MountedPress, frequency: Array, amplitude: ComplexArray) -> Array:
    """Root mean square (s,) of the force on the floor, all components together [N]."""
    return np.asarray(np.linalg.norm(_rms(mount_forces(system, frequency, amplitude).sum(axis=-2), _states(system)), axis=1))


def _states(system: MountedPress) -> int:
    """Number of states of a period."""
    return STATES * system.press.period_turns


def _rms(harmonics: ComplexArray, states: int) -> Array:
    """Root mean square (s, ...) about the mean of a quantity with these harmonics (s, k, ...)."""
    return np.asarray(np.sqrt(2 * (np.abs(harmonics[:, 1:]) ** 2).sum(axis=1)) / states)


def _largest(harmonics: ComplexArray, states: int) -> Array:
    """Largest absolute value (s, ...) of a quantity with these harmonics (s, k, ...)."""
    return np.asarray(np.abs(np.fft.irfft(harmonics, states, axis=1)).max(axis=1))


def _scale(mounts: Sequence[Mount], factor: float) -> tuple[Mount, ...]:
    """Mounts with their stiffness multiplied by a factor and their damping ratios unchanged."""
    return tuple(
        replace(
            mount,
            stiffness=tuple(factor * np.array(mount.stiffness)),
            damping=tuple(np.sqrt(factor) * np.array(mount.damping)),
            static_stiffness=tuple(factor * np.array(mount.static)),
        )
        for mount in mounts
    )
