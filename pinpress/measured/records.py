"""Records of a running press: crank angle without jumps and torque at the crank, in SI units; faults of a record are reported.

run = pp.measured.record("50.csv", angle="crank [deg]", torque="motor [N m]", ratio=20.7)
run = pp.measured.MeasuredRun(time, angle, torque)  # the same from arrays
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import LARGEST, SMALLEST, known_factor, number, numbers, typed
from ..common.errors import PinpressError, caution, shown
from ..common.frozen import FrozenMapping
from ..common.quantities import Array, readable
from ..common.reading.columns import TIMES, Channels, read_channels, split_head
from ..common.results import Tabular

FEWEST = 32  # samples of a record
FEWEST_A_TURN = 12  # samples
UNEVEN = 0.02  # standard deviation / median of the steps of time: above it, sampling is uneven
_NONE_GIVEN: Mapping[str, Any] = FrozenMapping({})
_UNITS = {"time": "s", "angle": "rad", "torque": "N m", "current": "A", "height": "m"}  # of the columns
_SHAKING = {"shaking_force": "N", "shaking_moment": "N m"}  # of the columns by axis


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredRun(Tabular):
    """A record of a running press with n samples. All arrays are read-only.

    Attributes:
        time: (n,) times, rising [s].
        angle: (n,) crank angle, continuous over all turns; 0 in the drawn pose (the pose in the press's file) [rad].
        torque: (n,) torque of the drive at the crank, positive in the positive direction of the crank; None if not measured [N m].
        current: (n,) motor current in place of a torque, for a motor that turns with the crank; None if not measured [A].
        shaking_force: world axis "x", "y" or "z" -> (n,) measured force of the press on its foundation, weight included [N].
        shaking_moment: world axis -> (n,) measured moment on the foundation about the world's origin [N m].
        height: (n,) measured height of the slide; None if not measured [m].
        added_mass: name of a link -> mass that was fastened at the origin of its frame for this run [kg].
        name: name of the run, for messages.
        notes: changes made to the record when it was read, as text.

    Raises:
        PinpressError: a column is not finite or differs in length from the time; times do not rise or have a gap; the angle jumps or is
            constant; a torque or current is larger than in any press; there are too few samples.

    Warns:
        PinpressWarning: sampling is uneven; the torque stays at its extreme, as if the drive limits it; the crank rests in a part of a
            record with torque; the mean power is negative.
    """

    time: Array
    angle: Array
    torque: Array | None = None
    current: Array | None = None
    shaking_force: Mapping[str, Array] = field(default_factory=dict)
    shaking_moment: Mapping[str, Array] = field(default_factory=dict)
    height: Array | None = None
    added_mass: Mapping[str, float] = field(default_factory=dict)
    name: str = "run"
    notes: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        for column, unit in _UNITS.items():
            if column in ("time", "angle") or getattr(self, column) is not None:
                vars(self)[column] = numbers(f"{self.name}: {column}", getattr(self, column), (None,), unit=unit)
        for kind, unit in _SHAKING.items():
            given = getattr(self, kind)
            if not isinstance(given, Mapping) or not set(given) <= set("xyz"):
                raise PinpressError(f"{self.name}: {kind} is {shown(given)}: give a mapping by axis, {{'x': ..., 'z': ...}}")
            by_axis = {
                axis: numbers(f"{self.name}: {kind} along {axis}", given[axis], (None,), unit=unit) for axis in "xyz" if axis in given
            }
            vars(self)[kind] = by_axis
        if not isinstance(self.added_mass, Mapping):
            raise PinpressError(f"{self.name}: added_mass is {shown(self.added_mass)}: give masses by link, {{'slide': 200.0}}")
        masses = {str(link): number(f"{self.name}: mass on {link}", mass, "kg", positive=True) for link, mass in self.added_mass.items()}
        vars(self)["added_mass"] = masses
        if self.torque is not None and self.current is not None:
            raise PinpressError(f"{self.name}: both torque and current are given: give only one of them")
        lengths = {name: len(values) for name, values, _ in self._signals()}
        if len(set(lengths.values())) > 1:
            raise PinpressError(
                f"{self.name}: lengths differ ({', '.join(f'{k} {n}' for k, n in lengths.items())}): give one value for each time"
            )
        if len(self.time) < FEWEST:
            raise PinpressError(f"{self.name}: {len(self.time)} samples: measure at least {FEWEST}, better some strokes at 500 Hz")
        _check_times(self)
        _check_angle(self)
        _check_torque(self)
        super().__post_init__()

    @property
    def title(self) -> str:
        low, high = self.speeds
        return (
            f"MeasuredRun {self.name}: {len(self.time)} samples, {self.duration:.6g} s at {1 / self.sampling:.6g} Hz, {self.strokes:.6g}"
            f" turns of the crank at {30 / math.pi * low:.4g} to {30 / math.pi * high:.4g} r/min"
        )

    @property
    def sampling(self) -> float:
        """Median of the time between samples [s]."""
        return float(np.median(np.diff(self.time)))

    @property
    def duration(self) -> float:
        """Time from the first sample to the last [s]."""
        return float(self.time[-1] - self.time[0])

    @property
    def strokes(self) -> float:
        """Turns of the crank; turns forward and backward are both counted [-]."""
        return float(np.abs(np.diff(self.angle)).sum() / (2 * math.pi))

    @property
    def speeds(self) -> tuple[float, float]:
        """Lowest and highest speed of the crank, each a mean over a hundredth of the record, at least a twelfth of a turn [rad/s]."""
        step = max(len(self.time) // 100, round(len(self.time) / max(FEWEST_A_TURN * self.strokes, 1.0)), 1)
        means = np.diff(self.angle[::step]) / np.diff(self.time[::step])
        return float(means.min()), float(means.max())

    @property
    def resolution(self) -> float | None:
        """Step of the encoder at the crank: all changes of the angle are multiples of it. None if the angle has no steps [rad]."""
        steps = np.unique(np.round(np.abs(np.diff(self.angle)), 10))
        if len(steps) > len(self.angle) // 4 or len(steps) < 2:
            return None
        least = float(np.diff(steps[steps > 0], prepend=0.0).min())
        multiples = np.round(steps / least)
        even = np.abs(steps - multiples * least).max() <= 1e-3 * least * (1 + multiples.max())
        return float(steps.sum() / multiples.sum()) if even else None

    def between(self, start: float, end: float) -> MeasuredRun:
        """Cut out the part of the record between two times [s].

        Raises:
            PinpressError: there are fewer than 32 samples between the times.
        """
        inside = (self.time >= number("start", start, "s")) & (self.time <= number("end", end, "s"))
        cut: dict[str, Any] = {name: getattr(self, name)[inside] for name in _UNITS if getattr(self, name) is not None}
        cut |= {kind: {axis: values[inside] for axis, values in getattr(self, kind).items()} for kind in _SHAKING}
        return replace(self, **cut)

    def columns(self) -> dict[str, Array]:
        """All measured quantities as columns: name with unit -> (n,) values."""
        return {f"{name} [{unit}]": values for name, values, unit in self._signals()}

    def _signals(self) -> Iterator[tuple[str, Array, str]]:
        """Name, samples (n,) and unit of each measured quantity."""
        yield from ((name, getattr(self, name), unit) for name, unit in _UNITS.items() if getattr(self, name) is not None)
        for kind, unit in _SHAKING.items():
            yield from ((f"{kind}_{axis}", values, unit) for axis, values in getattr(self, kind).items())


def _check_times(run: MeasuredRun) -> None:
    steps = np.diff(run.time)
    if not (steps > 0).all():
        k = int(np.argmax(steps <= 0))
        raise PinpressError(
            f"{run.name}: the time does not rise after {run.time[k]:.6g} s (sample {k}): sort the samples and leave out duplicates"
        )
    common = float(np.median(steps))
    if steps.max() > 4.5 * common:  # shorter gaps are a few samples that a bus lost
        k = int(np.argmax(steps > 4.5 * common))
        raise PinpressError(
            f"{run.name}: no samples for {steps[k]:.4g} s after {run.time[k]:.6g} s; elsewhere they are {common:.4g} s apart. Make a run of"
            " each part: record(..., between=(start, end))"
        )
    if common > 0.5:  # [s]: too slow to resolve a stroke
        caution(f"{run.name}: samples are {common:.4g} s apart. If the time is in ms, give it in s, or name the file's column time [ms]")
    if np.std(steps) > UNEVEN * common:
        caution(
            f"{run.name}: samples are {steps.min():.4g} to {steps.max():.4g} s apart, but the estimates assume equal steps:"
            " record at a fixed rate, with the times of the drive's clock"
        )


def _check_angle(run: MeasuredRun) -> None:
    steps = np.diff(run.angle)
    k = int(np.abs(steps).argmax())
    largest = abs(float(steps[k]))
    if largest == 0:
        raise PinpressError(f"{run.name}: the crank rests all the time at {math.degrees(run.angle[0]):.6g} deg: measure a running press")
    pace = float(np.quantile(np.abs(steps / np.diff(run.time)), 0.99))
    if largest > math.radians(5) and largest > 4 * pace * (run.time[k + 1] - run.time[k]):
        raise PinpressError(
            f"{run.name}: the angle jumps by {math.degrees(steps[k]):.6g} deg after {run.time[k]:.6g} s; the crank turns only"
            f" {math.degrees(pace * run.sampling):.3g} deg between samples. Give a continuous angle, or cut the record there"
        )
    if largest > 2 * math.pi / FEWEST_A_TURN:
        raise PinpressError(
            f"{run.name}: the crank turns {math.degrees(largest):.4g} deg between samples: sample at"
            f" {math.ceil(50 * pace / (2 * math.pi)):g} Hz or more, or give the angle in rad"
        )


def _check_torque(run: MeasuredRun) -> None:
    effort, word, unit = (run.torque, "torque", "N m") if run.torque is not None else (run.current, "current", "A")
    if effort is None:
        return
    if not np.ptp(effort):
        raise PinpressError(f"{run.name}: the {word} is the same in all samples ({effort[0]:.6g}): give a measured column")
    largest = float(np.abs(effort).max())
    if not SMALLEST <= largest <= LARGEST:
        raise PinpressError(f"{run.name}: the largest {word} is {largest:.4g} {unit}, a size that no press has: check its unit")

    starts, lengths = equal_samples(run.angle)
    k = int(lengths.argmax())
    if lengths[k] > max(20 * np.median(lengths), FEWEST):  # a coarse encoder repeats an angle only for a shorter time
        rest, begin = lengths[k] * run.sampling, run.time[starts[k]]
        caution(
            f"{run.name}: the crank rests for {rest:.4g} s from {begin:.6g} s on. A brake may hold it, and friction has no direction:"
            " leave this part out: record(..., between=(start, end))"
        )

    starts, lengths = equal_samples(effort)
    for extreme in (effort.max(), effort.min()):
        there = effort[starts] == extreme
        longest = int(lengths[there].max())
        if longest >= 12 and longest > 3 * lengths[~there].max(initial=0):  # other values are constant only for a shorter time
            caution(
                f"{run.name}: the {word} stays at {extreme:.6g} for {longest} samples from {run.time[starts[there][0]]:.6g} s on, as if a"
                " drive or an amplifier limits it: raise the limit or range, or leave these parts out"
            )

    power = effort * np.gradient(run.angle, run.time)
    if power.mean() < -0.1 * np.abs(power).mean():  # the mean power of an idle press may be slightly negative because of noise
        caution(
            f"{run.name}: the mean power is {'' if run.torque is None else f'{power.mean():.4g} W, '}negative, as if the press drives its"
            " motor: change the sign of the ratio, record(..., ratio=-20.7), or of angle_ratio="
        )


def equal_samples(values: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Starts and lengths of the runs of equal samples."""
    starts = np.append(0, np.flatnonzero(np.diff(values)) + 1)
    return starts, np.diff(starts, append=len(values))


def white_noise(samples: Array) -> float:
    """Standard deviation of white noise in samples of a slow signal: third differences are sqrt(20) times as large. Edges of the signal are
    ignored."""
    return float(1.4826 * np.median(np.abs(np.diff(samples, 3))) / math.sqrt(20.0))


def sample_noise(samples: Array) -> float:
    """`white_noise`, but never 0: at least as large as the rounding error of sums over samples."""
    return max(white_noise(samples), 1e-5 * float(np.abs(samples).max()), np.finfo(float).tiny)


# ------------------------------------------------------------------------------------------------------------------------------ from files


@typed
def record(
    file: str | os.PathLike[str],
    angle: str,
    torque: str | None = None,
    *,
    time: str | None = None,
    ratio: float = 1.0,
    angle_ratio: float = 1.0,
    zero: float = 0.0,
    counts: float | None = None,
    motor_constant: float | None = None,
    height: str | None = None,
    shaking_force: Mapping[str, str] = _NONE_GIVEN,
    shaking_moment: Mapping[str, str] = _NONE_GIVEN,
    added_mass: Mapping[str, float] = _NONE_GIVEN,
    between: Sequence[float] | None = None,
) -> MeasuredRun:
    """Read a record: crank angle, torque or current of the motor, and other measured quantities.

    Columns are named with their units. "motor [N m]" is the column of this name, or the column "motor" in the unit that the file gives,
    or in N m if the file gives no unit. Angles that restart after each turn or when a counter overflows are made continuous.

    Args:
        file: .csv or .txt (names in the first line, separated by commas, semicolons or tabs), .parquet, .mat (one vector for each channel;
            not version 7.3) or .mf4 (needs asammdf).
        angle: column of the angle [rad, deg, turns, or counts with ``counts``].
        torque: column of the motor's torque [N m, kN m] or current [A, mA]; None if not measured.
        time: column of the time [s, ms, us]; by default the column time or t, or the times of an MDF4 file.
        ratio: motor turns / crank turns; torques are multiplied by it. Negative if a positive torque turns the crank backwards.
        angle_ratio: encoder turns / crank turns; angles are divided by it. Negative if the encoder counts backwards.
        zero: reading of the angle's column in the drawn pose, in the column's unit.
        counts: counts in one turn of the encoder, for an angle in counts.
        motor_constant: motor torque / current, for a column in A; None: `identify` finds it [N m/A].
        height: column of the slide's height [m, mm].
        shaking_force: world axis -> column of the force on the foundation, {"x": "Fx [kN]", "z": "Fz [kN]"} [N, kN].
        shaking_moment: world axis -> column of the moment about the world's origin [N m, kN m].
        added_mass: link -> mass that was fastened to it for this run, see `MeasuredRun` [kg].
        between: (first, last) time of the part that is read; by default the whole record [s].

    Raises:
        PinpressError: the file cannot be read; a column has no unit, or the unit of another quantity, such as a speed for the angle;
            `MeasuredRun` refuses the record.
        UnknownNameError: the file has no column of this name.

    Warns:
        PinpressWarning: as for `MeasuredRun`.
    """
    for name in (angle, torque, time, height, *shaking_force.values(), *shaking_moment.values()):
        if not isinstance(name, str) and (name is not None or angle is None):
            raise PinpressError(f"the name of a column is {shown(name)}: give text, 'motor [N m]'")
    asked = (torque, time, height, *shaking_force.values(), *shaking_moment.values())
    table = read_channels(file, [angle, *(name for name in asked if name is not None)])
    times = times_of(table, time)
    start, end = (-math.inf, math.inf) if between is None else numbers("between", between, (2,))
    inside = (times >= start) & (times <= end)

    def samples(name: str, unit: str, quantity: str, factor: float | None = None) -> Array:
        """(n,) a column in an SI unit; ``factor``: size of its unit, by default from the table of units."""
        values, given = table.column(name)
        size = _factor(table.file, name, given, unit, quantity) if factor is None else factor
        missing = ~np.isfinite(values[inside])
        if missing.any():
            first = times[inside][int(np.argmax(missing))]
            raise PinpressError(f"{table.file}: {name} has no number at {first:.6g} s: cut the record with between=, or fill the gap")
        return np.asarray(values[inside] * size)

    # The angle: continuous, that of the crank, and 0 in the drawn pose.
    unit = table.column(angle).unit
    counted = counts is not None and unit == "counts"
    size = 2 * math.pi / number("counts", counts, positive=True) if counted else _factor(table.file, angle, unit, "rad", "angle")
    readings, over = _continuous(samples(angle, "rad", "angle", 1.0), 2 * math.pi / size, counted)
    crank = size * (readings - number("zero", zero)) / _ratio("angle_ratio", angle_ratio)

    # Torque or current, at the crank.
    gear, effort, current = _ratio("ratio", ratio), None, None
    if torque is not None:
        drawn = known_factor(table.column(torque).unit, "A") is not None
        at_crank = gear * samples(torque, "A" if drawn else "N m", "torque")
        if drawn and motor_constant is None:
            current = at_crank
        else:
            effort = at_crank * (number("motor_constant", motor_constant, positive=True) if drawn else 1.0)

    return MeasuredRun(
        times[inside],
        crank,
        effort,
        current,
        {axis: samples(name, "N", "force") for axis, name in shaking_force.items()},
        {axis: samples(name, "N m", "moment") for axis, name in shaking_moment.items()},
        None if height is None else samples(height, "m", "height"),
        added_mass,
        os.path.basename(table.file),
        () if over is None else (f"{angle} restarts {over}; it was made continuous",),
    )


def times_of(table: Channels, asked: str | None) -> Array:
    """Read the times of a file [s]. ``asked``: column of the time; None: the column time or t, or the times of the format.

    Raises:
        PinpressError: there is no such column, its unit is not a time, or a time is not a number.
    """
    if asked is None:
        if table.time is not None:
            return table.time
        asked = next((name for name in table.columns if name.lower() in TIMES), None)
        if asked is None:
            raise PinpressError(f"{table.file} has no column time or t: name the time's column, record(..., time='clock [ms]')")
    values, unit = table.column(asked)
    size = _factor(table.file, asked, unit or "s", "s", "time")
    if not np.isfinite(values).all():
        raise PinpressError(
            f"{table.file}: {asked} has no number in row {int(np.argmin(np.isfinite(values)))}, counted from 0: leave this row out"
        )
    return np.asarray(values * size)


def _factor(file: str, name: str, given: str, unit: str, quantity: str) -> float:
    """Size of the unit of a column; raises PinpressError if it is not a unit of this quantity."""
    factor = known_factor(given, unit)
    if factor is not None:
        return factor
    (plain, _), known = split_head(name), readable(unit)
    such = f"write the column as {plain!r} with one of the units {', '.join(known)}: '{plain} [{next(iter(known))}]'"
    if not given:
        raise PinpressError(f"{file}: column {plain!r} has no unit: {such}")
    if quantity == "angle" and known_factor(given, "rad/s") is not None:
        raise PinpressError(f"{file}: {name!r} is a speed in {given}, not an angle: give the column of the encoder's angle")
    if given == "counts":
        raise PinpressError(f"{file}: {name!r} is in counts: give the counts in one turn, record(..., counts=8192)")
    if given == "%":
        raise PinpressError(f"{file}: {name!r} is in %: multiply it by the rated torque, and {such}")
    raise PinpressError(f"{file}: {name!r} is in {given}, which is not a unit of {quantity}: {such}")


def _ratio(name: str, value: float) -> float:
    ratio = number(name, value)
    if not 1e-6 < abs(ratio) < 1e6:
        raise PinpressError(f"{name} is {shown(value)}: give turns of motor or encoder / turns of the crank, such as 20.7")
    return ratio


def _continuous(readings: Array, turn: float, counted: bool) -> tuple[Array, str | None]:
    """Readings of an encoder without the jumps at which it restarts, and how often it restarts, as text; None if it does not.

    Args:
        readings: (n,) readings.
        turn: readings in a turn.
        counted: whether they are counts, which also restart where 16, 24 or 32 bits overflow.
    """
    steps = np.diff(readings)
    ranges = [turn, *(each for each in (2.0**16, 2.0**24, 2.0**32) if counted and each > turn)]
    over = next((each for each in ranges if 0.5 * each < np.abs(steps).max(initial=0.0) < 1.5 * each), None)
    if over is None:
        return readings, None
    jumps = np.round(steps / over)
    return np.asarray(readings - over * np.append(0.0, np.cumsum(jumps))), f"{np.count_nonzero(jumps)} times, each time after {over:.6g}"
