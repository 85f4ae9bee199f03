"""Accelerometers on the frame of a press, and the runs that they recorded: accelerations in SI units in equal steps of time.

    pp.measured.Accelerometer((0.9, 0, 1.2), "z", gain=98.1)  # of a channel in V: 98.1 m/s2 per V

As in chapter 2 of Zhang 2007, each accelerometer sits at a point of the frame and measures along one direction.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ..common import files
from ..common.arguments import LARGEST, finite_numbers, known_factor, numbers, suitable_numbers
from ..common.errors import PinpressError, caution, shown
from ..common.frozen import Frozen
from ..common.quantities import GRAVITY, Array, readable
from ..common.reading.columns import Channels, Wanted, name_columns, read_channels, read_columns
from .records import UNEVEN, equal_samples, times_of

DIRECTIONS = ("x", "y", "z", "+x", "+y", "+z", "-x", "-y", "-z")
POINTS = {  # columns of a file of points
    "channel": Wanted(),
    **dict.fromkeys("xyz", Wanted("m", bare="m")),
    "direction": Wanted(),
    "part": Wanted(needed=False),
    "gain": Wanted("m/s2 per V", bare="m/s2 per V", needed=False),
}

Source: TypeAlias = str | os.PathLike[str] | Mapping[str, ArrayLike]


@dataclass(frozen=True)
class Accelerometer(Frozen):
    """Place, direction and gain of an accelerometer.

    Attributes:
        point: (3,) place in world axes [m]; ("crown", (x, y, z)) on the crown of a frame in two parts, as for `foundation`.
        direction: positive direction of measurement: "x", "y", "z", "-x", "-y", "-z", or a vector (3,) of any length.
        gain: acceleration for one V, for a column in V [m/s2 per V]; None for a column in m/s2 or g.

    Raises:
        PinpressError: the point is not three finite numbers, the direction is not valid, or the gain is zero.
    """

    point: ArrayLike | tuple[str, ArrayLike]
    direction: str | ArrayLike = "z"
    gain: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.place.shape != (3,) or self.along.shape != (3,):
            raise PinpressError(f"Accelerometer: point is {shown(self.point)}: give x, y, z [m], or ('crown', (x, y, z))")
        if self.gain is not None:
            suitable_numbers("Accelerometer: gain", self.gain, "m/s2 per V, not zero", suits=lambda gain: gain != 0)

    @property
    def on_crown(self) -> bool:
        """Whether the accelerometer is on the crown of a frame in two parts."""
        return isinstance(self.point, tuple) and len(self.point) == 2 and self.point[0] == "crown"

    @property
    def place(self) -> Array:
        """(3,) place in world axes [m]."""
        place = finite_numbers(self.point[1] if self.on_crown else self.point)  # type: ignore[index]  # a pair
        return np.empty(0) if place is None else place

    @property
    def along(self) -> Array:
        """(3,) unit vector of the direction of measurement."""
        if isinstance(self.direction, str):
            if self.direction not in DIRECTIONS:
                raise PinpressError(
                    f"Accelerometer: direction is {shown(self.direction)}: give one of {', '.join(DIRECTIONS)}, or a vector"
                )
            return np.where(np.array(list("xyz")) == self.direction[-1], -1.0 if self.direction[0] == "-" else 1.0, 0.0)
        wanted = "a vector (3,), not zero"
        vector = suitable_numbers("Accelerometer: direction", self.direction, wanted, (3,), lambda v: 0 < np.abs(v).max() < LARGEST)
        return np.asarray(vector / np.linalg.norm(vector))

    def row(self, parts: int) -> Array:
        """(6 parts,) readings for a unit acceleration of each coordinate of a frame in 1 or 2 parts, see `MountedPress`."""
        part, turning = int(self.on_crown and parts == 2), np.cross(self.place, self.along)
        row = np.zeros(6 * parts)
        row[6 * part : 6 * part + 6] = [*self.along, *turning]
        return row


@dataclass(frozen=True, eq=False, repr=False)
class VibrationRun(Frozen):
    """One record in equal steps of time, n samples. All arrays are read-only.

    Attributes:
        name: name of the file.
        time: (n,) times [s].
        acceleration: (n, channels) accelerations along the accelerometers' directions, minus their medians [m/s2].
        angle: (n,) crank angle, continuous over all turns; None if it is not known [rad].
    """

    name: str
    time: Array
    acceleration: Array
    angle: Array | None

    @property
    def rate(self) -> float:
        """Samples a second [Hz]."""
        return float((len(self.time) - 1) / (self.time[-1] - self.time[0]))


def points_of(file: str | os.PathLike[str]) -> dict[str, Accelerometer]:
    """Read accelerometers from a CSV file with the columns channel, x, y, z, direction and, if needed, part and gain.

    Raises:
        PinpressError: the file cannot be read or lacks a column, or a row does not describe an accelerometer.
    """
    sensors: dict[str, Accelerometer] = {}
    table = read_columns(files.path_of("points", file), POINTS)
    for line, row in table.rows():
        place, part, gain = (row["x"], row["y"], row["z"]), row.get("part") or "bed", row.get("gain", math.nan)
        if part not in ("bed", "crown"):
            raise PinpressError(f"{table.file}, line {line}: part is {shown(part)}: give bed or crown")
        if row["channel"] in sensors:
            raise PinpressError(
                f"{table.file}, line {line}: channel {row['channel']!r} is there twice: give each accelerometer a separate channel"
            )
        point = ("crown", place) if part == "crown" else place
        sensors[row["channel"]] = Accelerometer(point, row["direction"], None if math.isnan(gain) else gain)
    return sensors


def run_of(
    source: Source,
    name: str,
    sensors: Mapping[str, Accelerometer],
    time: str | None,
    crank: tuple[str | None, str | None, int],
    speed: float | None,
) -> VibrationRun:
    """One run of `vibration`; raises as `vibration`.

    Args:
        source: a file, or columns by name.
        name: name of the run if it is not a file.
        sensors: column -> accelerometer.
        time: column of the time.
        crank: columns of the crank's angle and of its tacho, and pulses in a turn.
        speed: constant speed of the crank [rad/s].
    """
    angle, tacho, pulses = crank
    wanted = [*sensors, *(each for each in (time, angle, tacho) if each is not None)]
    if isinstance(source, Mapping):
        if not all(isinstance(column, str) for column in source):
            raise PinpressError(f"{name}: names of columns are {shown(list(source))}: give texts, such as 'A [m/s2]'")
        table = name_columns(name, {column: numbers(f"{name}: {column}", values, (None,)) for column, values in source.items()})
    else:
        table, name = read_channels(source, wanted), os.path.basename(os.fspath(source))

    times = times_of(table, time)
    if len(times) < 256:
        raise PinpressError(f"{name}: {len(times)} samples: give 256 or more")
    steps = np.diff(times)
    if steps.min() <= 0 or steps.max() > 1.5 * np.median(steps) or steps.std() > UNEVEN * np.median(steps):
        k = int(np.abs(steps - np.median(steps)).argmax())
        raise PinpressError(
            f"{name}: samples are not in equal time steps: {steps[k]:.4g} s after {times[k]:.6g} s, but {np.median(steps):.4g} s elsewhere:"
            " cut the record there, or resample it"
        )

    accelerations = np.array([_acceleration(table, name, column, sensor) for column, sensor in sensors.items()]).T
    crank_angle = None
    if angle is not None:
        values, unit = table.column(angle)
        size = known_factor(unit, "rad")
        if size is None:
            known = ", ".join(readable("rad"))
            raise PinpressError(f"{name}: column {angle!r} is in {unit or 'no unit'}: give an angle in {known}, or tacho=")
        crank_angle = np.unwrap(_finite(values, name, angle) * size)
    elif tacho is not None:
        times, accelerations, crank_angle = _by_pulses(name, times, accelerations, _finite(table.column(tacho).values, name, tacho), pulses)
    elif speed is not None:
        crank_angle = speed * (times - times[0])
    return VibrationRun(name, times, accelerations - np.median(accelerations, axis=0), crank_angle)


def _acceleration(table: Channels, name: str, column: str, sensor: Accelerometer) -> Array:
    """(n,) values of a column in m/s2."""
    values, unit = table.column(column)
    factor = known_factor(unit, "m/s2")
    if factor is None and sensor.gain is not None:
        factor = sensor.gain * (1e-3 if unit == "mV" else 1.0)
    elif factor is None:
        what = f"is in {unit}" if unit else "has no unit"
        raise PinpressError(
            f"{name}: column {column!r} {what}: name it in one of {', '.join(readable('m/s2'))}, or give its Accelerometer a gain"
        )
    elif sensor.gain is not None:
        raise PinpressError(
            f"{name}: column {column!r} is in {unit}, but its accelerometer has a gain: leave the gain out, or name the column in V"
        )
    values = _finite(values, name, column)
    starts, lengths = equal_samples(values)

    def longest(value: float) -> int:
        return int(lengths[values[starts] == value].max(initial=1))

    rest = max(longest(values.max()), longest(values.min()))
    if not np.ptp(values):
        caution(f"{name}: channel {column!r} is constant, {values[0]:.4g} in all samples: check its cable, or leave it out")
    elif rest >= 8 and rest > 3 * longest(float(np.median(values))):
        caution(f"{name}: channel {column!r} stays at its extreme for {rest} samples, as if its amplifier is overdriven: lower that gain")
    size = float(np.abs(factor * (values - np.median(values))).max())
    if size > 1000 * GRAVITY:
        caution(f"{name}: channel {column!r} reaches {size / GRAVITY:.4g} g: check its unit, or its gain [m/s2 per V]")
    return np.asarray(factor * values)


def _finite(values: Array, name: str, column: str) -> Array:
    if not np.isfinite(values).all():
        raise PinpressError(f"{name}: {column} has no number in sample {int(np.argmin(np.isfinite(values)))}: cut the record there")
    return values


def _by_pulses(name: str, times: Array, accelerations: Array, signal: Array, pulses: int) -> tuple[Array, Array, Array]:
    """Times, accelerations and crank angles between the first and the last pulse of a tacho."""
    from scipy.interpolate import PchipInterpolator  # slow to import

    low, high = np.quantile(signal, (0.001, 0.999))
    levels = (signal - low) / (high - low)
    state = np.where(levels <= 0.35, 0.0, np.where(levels >= 0.65, 1.0, np.nan))  # noise between the levels makes no pulses
    known = np.flatnonzero(~np.isnan(state))
    risen = np.flatnonzero(np.diff(state[known]) > 0)
    if len(risen) < 4:
        raise PinpressError(f"{name}: the tacho gives {len(risen)} pulses: record four or more, or give angle= or speed=")
    first, last = known[risen], known[risen + 1]
    moments = times[first] + (0.5 - levels[first]) / (levels[last] - levels[first]) * (times[last] - times[first])
    within = (times >= moments[0]) & (times <= moments[-1])
    turned = PchipInterpolator(moments, 2 * np.pi / pulses * np.arange(len(moments)))(times[within])
    return times[within], accelerations[within], np.asarray(turned)
