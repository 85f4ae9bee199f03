"""Records of a running press: the crank's angle without jumps and the torque at the crank, in SI units, with what is amiss in them.

run = pp.measured.record("50.csv", angle="crank [deg]", torque="motor [N m]", ratio=20.7)
run = pp.measured.MeasuredRun(time, angle, torque)  # the same from arrays
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..common.arguments import LARGEST, SMALLEST, known_factor, number, numbers, typed
from ..common.errors import PinpressError, caution, shown
from ..common.frozen import FrozenMapping
from ..common.quantities import Array, readable
from ..common.reading.columns import TIMES, Channels, read_channels, split_head
from ..common.results import Tabular

FEWEST = 32  # samples of a record
SLOWEST_SAMPLES = 0.5  # samples this far apart show nothing of a stroke [s]
GAP = 4.5  # times the common step between samples, from which on a step is a gap: fewer are samples that a bus lost
UNEVEN = 0.02  # standard deviation of the steps by their median, above which sampling is called uneven
JUMP = 0.5  # share of a turn of the counter by which an angle changes where it starts anew
ROLLOVERS = (2.0**16, 2.0**24, 2.0**32)  # counts after which counters start anew
RESTING = 20.0  # times the median between two changes of the angle, from which on the crank rests
FLAT = 12  # samples in a row at the very extreme that look like saturation
BRAKING = 0.1  # share of the sum of sizes of the power by which its mean is below 0 where a sign is wrong
FEWEST_A_TURN = 12  # samples
NOISELESS = 1e-5  # least noise by the largest sample: so exact are sums over samples
AXES = ("x", "y", "z")
_NONE_GIVEN: Mapping[str, Any] = FrozenMapping({})

_UNITS = {"torque": "N m", "current": "A"}
SPEEDS = ("rpm", "r/min", "1/min", "min-1", "rad/s", "deg/s", "Hz")


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredRun(Tabular):
    """A record of a running press, n samples of it. All arrays are read-only.

    Attributes:
        time: (n,) rising [s].
        angle: (n,) crank angle, continuous over all turns; 0 where the press is as drawn [rad].
        torque: (n,) torque of the drive at the crank, positive where it drives in the positive direction; None where it was not measured
            [N m].
        current: (n,) current of the motor in place of a torque, as it would be of a motor that turns with the crank; None where it was not
            measured [A].
        shaking_force: by the world's axis ("x", "y", "z") the measured forces of the press on its foundation, weight included, (n,) each
            [N].
        shaking_moment: by the world's axis the measured moments about the world's origin, (n,) each [N m].
        height: (n,) measured height of the slide; None where it was not measured [m].
        added_mass: masses that were fastened to links for this run, by the name of the link, in their frame's origin [kg].
        name: of the run, for messages.
        notes: what was done to the record when it was read, in words.

    Raises:
        PinpressError: a column is not finite, or has another length than the time; times do not rise, or have a gap; the angle jumps, or
            rests all the time; a torque or current of a size that no press has; too few samples.

    Warns:
        PinpressWarning: sampling is uneven; the torque stays at its extreme, as where a drive cuts it off; the crank rests in a part of a
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
        for column, unit in (("time", "s"), ("angle", "rad"), ("torque", "N m"), ("current", "A"), ("height", "m")):
            if column in ("time", "angle") or getattr(self, column) is not None:
                vars(self)[column] = numbers(f"{self.name}: {column}", getattr(self, column), (None,), unit=unit)
        for kind, unit in (("shaking_force", "N"), ("shaking_moment", "N m")):
            vars(self)[kind] = self._by_axis(kind, unit)
        vars(self)["added_mass"] = self._masses()
        if self.torque is not None and self.current is not None:
            raise PinpressError(f"{self.name}: both torque and current are given; give one of them")
        lengths = {name: len(values) for name, values in self._signals().items()}
        if len(set(lengths.values())) > 1:
            raise PinpressError(f"{self.name}: lengths differ ({', '.join(f'{k} {n}' for k, n in lengths.items())}); give one value a time")
        if len(self.time) < FEWEST:
            raise PinpressError(f"{self.name}: {len(self.time)} samples; measure at least {FEWEST}, better some strokes at 500 Hz")
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
        """Turns of the crank, those there and back each counted [-]."""
        return float(np.abs(np.diff(self.angle)).sum() / (2 * math.pi))

    @property
    def speeds(self) -> tuple[float, float]:
        """Lowest and highest speed of the crank, each over a hundredth of the record or a twelfth of a turn, the longer [rad/s]."""
        step = max(len(self.time) // 100, round(len(self.time) / max(FEWEST_A_TURN * self.strokes, 1.0)), 1)
        means = np.diff(self.angle[::step]) / np.diff(self.time[::step])
        return float(means.min()), float(means.max())

    @property
    def resolution(self) -> float | None:
        """Step of the encoder at the crank, of which all changes of the angle are multiples; None where the angle has no steps [rad]."""
        steps = np.unique(np.round(np.abs(np.diff(self.angle)), 10))
        if len(steps) > len(self.angle) // 4 or len(steps) < 2:
            return None
        least = float(np.diff(steps[steps > 0], prepend=0.0).min())
        multiples = np.round(steps / least)
        even = np.abs(steps - multiples * least).max() <= 1e-3 * least * (1 + multiples.max())
        return float(steps.sum() / multiples.sum()) if even else None

    def between(self, start: float, end: float) -> MeasuredRun:
        """The part of the record between two times [s].

        Raises:
            PinpressError: fewer than 32 samples are between them.
        """
        inside = (self.time >= number("start", start, "s")) & (self.time <= number("end", end, "s"))
        columns = {name: getattr(self, name) for name in ("time", "angle", "torque", "current", "height")}
        cut: dict[str, Any] = {name: None if values is None else values[inside] for name, values in columns.items()}
        for kind in ("shaking_force", "shaking_moment"):
            cut[kind] = {axis: values[inside] for axis, values in getattr(self, kind).items()}
        return replace(self, **cut)

    @property
    def _pictured(self) -> tuple[str, ...]:
        return "time [s]", *(name for name in ("torque [N m]", "current [A]") if name in self.columns())

    def columns(self) -> dict[str, Array]:
        """Everything measured as columns (n,) under their names with units."""
        units = {"time": "s", "angle": "rad", "torque": "N m", "current": "A", "height": "m"}
        return {f"{name} [{units.get(name, 'N m' if 'moment' in name else 'N')}]": values for name, values in self._signals().items()}

    def __str__(self) -> str:
        return "\n".join([super().__str__(), *(f"  {note}" for note in self.notes)])

    def _signals(self) -> dict[str, Array]:
        found = {name: getattr(self, name) for name in ("time", "angle", "torque", "current", "height")}
        for kind in ("shaking_force", "shaking_moment"):
            found |= {f"{kind}_{axis}": values for axis, values in getattr(self, kind).items()}
        return {name: values for name, values in found.items() if values is not None}

    def _by_axis(self, kind: str, unit: str) -> dict[str, Array]:
        given = getattr(self, kind)
        if not isinstance(given, Mapping) or not set(given) <= set(AXES):
            raise PinpressError(f"{self.name}: {kind} is {shown(given)}: give a mapping by axis, {{'x': ..., 'z': ...}}")
        return {axis: numbers(f"{self.name}: {kind} along {axis}", given[axis], (None,), unit=unit) for axis in AXES if axis in given}

    def _masses(self) -> dict[str, float]:
        if not isinstance(self.added_mass, Mapping):
            raise PinpressError(f"{self.name}: added_mass is {shown(self.added_mass)}: give masses by link, {{'slide': 200.0}}")
        return {str(link): number(f"{self.name}: mass on {link}", mass, "kg", positive=True) for link, mass in self.added_mass.items()}


def _check_times(run: MeasuredRun) -> None:
    steps = np.diff(run.time)
    if not (steps > 0).all():
        k = int(np.argmax(steps <= 0))
        raise PinpressError(
            f"{run.name}: the time does not rise after {run.time[k]:.6g} s (sample {k}); sort the samples, leave out doubles"
        )
    common = float(np.median(steps))
    if steps.max() > GAP * common:
        k = int(np.argmax(steps > GAP * common))
        raise PinpressError(
            f"{run.name}: no samples for {steps[k]:.4g} s after {run.time[k]:.6g} s, where they are {common:.4g} s apart; make a run of"
            " each part, with record(..., between=(start, end))"
        )
    if common > SLOWEST_SAMPLES:
        caution(f"{run.name}: samples are {common:.4g} s apart: if the time is in ms, write {common:.4g}e-3, in a file time [ms]")
    if np.std(steps) > UNEVEN * common:
        caution(
            f"{run.name}: samples are {steps.min():.4g} to {steps.max():.4g} s apart; noise is taken as even: record at a fixed rate, where"
            " the drive's own clock writes the times"
        )


def _check_angle(run: MeasuredRun) -> None:
    steps = np.diff(run.angle)
    largest = float(np.abs(steps).max())
    if largest == 0:
        raise PinpressError(f"{run.name}: the crank rests all the time at {math.degrees(run.angle[0]):.6g} deg; measure a running press")
    k = int(np.argmax(np.abs(steps)))
    pace = float(np.quantile(np.abs(steps / np.diff(run.time)), 0.99))
    if largest > math.radians(5) and largest > 4 * pace * (run.time[k + 1] - run.time[k]):
        raise PinpressError(
            f"{run.name}: the angle jumps by {math.degrees(steps[k]):.6g} deg after {run.time[k]:.6g} s, where the crank turns"
            f" {math.degrees(pace * run.sampling):.3g} deg between samples; give it unwrapped, or cut the record there"
        )
    if largest > 2 * math.pi / FEWEST_A_TURN:
        raise PinpressError(
            f"{run.name}: the crank turns {math.degrees(largest):.4g} deg between samples; sample at"
            f" {math.ceil(50 * pace / (2 * math.pi)):g} Hz or more, or give the angle in rad"
        )


def _check_torque(run: MeasuredRun) -> None:
    effort, word = (run.torque, "torque") if run.torque is not None else (run.current, "current")
    if effort is None:
        return
    if not np.ptp(effort):
        raise PinpressError(f"{run.name}: the {word} is the same in all samples ({effort[0]:.6g}); give the column that was measured")
    largest = float(np.abs(effort).max())
    if not SMALLEST <= largest <= LARGEST:
        raise PinpressError(f"{run.name}: the largest {word} is {largest:.4g} {_UNITS[word]}, as of no press; see to its unit")
    _doubt_rest(run)
    for extreme in (effort.max(), effort.min()):
        longest, others = longest_rest(effort, extreme)
        if longest >= FLAT and longest > 3 * others:
            k = int(np.argmax(effort == extreme))
            caution(
                f"{run.name}: the {word} stays at {extreme:.6g} for {longest} samples from {run.time[k]:.6g} s on, as where a drive or an"
                " amplifier cuts it off: raise its limit or range, or leave these parts out"
            )
    speed = np.gradient(run.angle, run.time)
    power, size = float(np.mean(effort * speed)), float(np.mean(np.abs(effort * speed)))
    if power < -BRAKING * size:
        caution(
            f"{run.name}: the mean power is {'' if run.torque is None else f'{power:.4g} W, '}below 0, as if the press drove its motor:"
            " give the ratio with the other sign, record(..., ratio=-20.7), or the angle's, angle_ratio="
        )


def _doubt_rest(run: MeasuredRun) -> None:
    """Warn of a crank that stands in a part of a record with torque."""
    changes = np.flatnonzero(np.diff(run.angle)) + 1
    ends = np.concatenate([[0], changes, [len(run.angle)]])
    lengths = np.diff(ends)
    k = int(lengths.argmax())
    if lengths[k] > max(RESTING * np.median(lengths), FEWEST):
        rest, begin = lengths[k] * run.sampling, run.time[ends[k]]
        caution(
            f"{run.name}: the crank rests for {rest:.4g} s from {begin:.6g} s on, where a brake may hold it and friction has no direction:"
            " leave this part out, record(..., between=(start, end))"
        )


def longest_rest(values: Array, at: float) -> tuple[int, int]:
    """Most samples in a row with one value, where it is this one, and elsewhere."""
    ends = np.flatnonzero(np.diff(values)) + 1
    lengths = np.diff(np.concatenate([[0], ends, [len(values)]]))
    there = values[np.concatenate([[0], ends])] == at
    return int(lengths[there].max(initial=0)), int(lengths[~there].max(initial=0))


def sample_noise(samples: Array) -> float:
    """Standard deviation of even noise in samples that change slowly between them, edges left aside; never 0."""
    found = float(1.4826 * np.median(np.abs(np.diff(samples, 3))) / math.sqrt(20.0))
    return max(found, NOISELESS * float(np.abs(samples).max()), np.finfo(float).tiny)


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
    """Read a record: crank angle, torque or current of the motor and what else was measured.

    Columns are named with their units, "motor [N m]": the column of this name, or the one called "motor", in the unit that the file has
    for it, else in this one. Angles that start anew after each turn, or where a counter overflows, are made continuous.

    Args:
        file: .csv or .txt (names in the first line, parted by commas, semicolons or tabs), .parquet, .mat (a vector a channel, not version
            7.3) or .mf4 (needs asammdf).
        angle: column of the angle [rad, deg, turns, or counts with ``counts``].
        torque: column of the motor's torque [N m, kN m] or current [A, mA]; None where none was measured.
        time: column of the time [s, ms, us]; by default the one called time or t, or the times of an MDF4 file.
        ratio: turns of the motor by turns of the crank, by which torques are multiplied; negative where a positive torque turns the crank
            backwards.
        angle_ratio: turns of the encoder by turns of the crank, by which angles are divided; negative where it counts backwards.
        zero: the column's angle where the press is as drawn, in its own unit.
        counts: counts of the encoder in one turn of it, for an angle in counts.
        motor_constant: torque of the motor by its current, for a column in A; None: to be identified [N m/A].
        height: column of the slide's height [m, mm].
        shaking_force: columns of forces on the foundation by the world's axis, {"x": "Fx [kN]", "z": "Fz [kN]"} [N, kN].
        shaking_moment: columns of moments about the world's origin by axis [N m, kN m].
        added_mass: masses fastened for this run, by link, see `MeasuredRun` [kg].
        between: first and last time that are read; by default all [s].

    Raises:
        PinpressError: the file cannot be read; a column has no unit, or one of another quantity, such as a speed for the angle; what
            `MeasuredRun` raises.
        UnknownNameError: it has no column of this name.

    Warns:
        PinpressWarning: as `MeasuredRun`.
    """
    given = (torque, time, height, *shaking_force.values(), *shaking_moment.values())
    asked = [angle, *(name for name in given if name is not None)]
    for name in asked:
        if not isinstance(name, str):
            raise PinpressError(f"the name of a column is {shown(name)}: give text, 'motor [N m]'")
    table = read_channels(file, asked)
    times = times_of(table, time)
    span = np.ones(len(times), dtype=bool)
    if between is not None:
        start, end = numbers("between", between, (2,))
        span = (times >= start) & (times <= end)

    def values(name: str, wanted: str, what: str, size: float | None = None) -> Array:
        found, unit = table.column(name)
        size = known_factor(unit, wanted) if size is None else size
        if size is None:
            raise PinpressError(_unit_refused(table.file, name, unit, what, wanted))
        wrong = ~np.isfinite(found[span])
        if wrong.any():
            first = times[span][int(np.argmax(wrong))]
            raise PinpressError(f"{table.file}: {name} has no number at {first:.6g} s; cut the record with between=, or fill the gap")
        return np.asarray(found[span] * size)

    notes: list[str] = []
    in_counts = counts is not None and table.column(angle).unit == "counts"
    per_unit = 2 * math.pi / number("counts", counts, positive=True) if in_counts else known_factor(table.column(angle).unit, "rad")
    readings = values(angle, "rad", "angle", per_unit)  # refuses a column in another unit
    per_unit = per_unit or 1.0
    readings = _continuous(readings / per_unit, per_unit, times[span], angle, notes, counted=in_counts)
    crank = per_unit * (readings - number("zero", zero)) / _ratio("angle_ratio", angle_ratio)
    gear, effort, current = _ratio("ratio", ratio), None, None
    if torque is not None:
        drawn = known_factor(table.column(torque).unit, "A") is not None
        read_in = gear * values(torque, "A" if drawn else "N m", "torque")
        if drawn and motor_constant is None:
            current = read_in
        else:
            effort = read_in * (number("motor_constant", motor_constant, positive=True) if drawn else 1.0)
    return MeasuredRun(
        times[span],
        crank,
        effort,
        current,
        {axis: values(name, "N", "force") for axis, name in shaking_force.items()},
        {axis: values(name, "N m", "moment") for axis, name in shaking_moment.items()},
        None if height is None else values(height, "m", "height"),
        added_mass,
        os.path.basename(table.file),
        tuple(notes),
    )


def times_of(table: Channels, asked: str | None) -> Array:
    """Times of a file [s]; ``asked``: the column of the time, None for the one called time or t, or those of the format itself.

    Raises:
        PinpressError: there is no such column, it is in another unit, or a time is no number.
    """
    if asked is None:
        if table.time is not None:
            return table.time
        asked = next((name for name in table.columns if name.lower() in TIMES), None)
        if asked is None:
            raise PinpressError(f"{table.file} has no column of the time; name it, record(..., time='clock [ms]')")
    found, unit = table.column(asked)
    size = known_factor(unit or "s", "s")
    if size is None:
        raise PinpressError(_unit_refused(table.file, asked, unit, "time", "s"))
    if not np.isfinite(found).all():
        raise PinpressError(
            f"{table.file}: {asked} has no number in row {int(np.argmin(np.isfinite(found)))}, counted from 0; leave it out"
        )
    return np.asarray(found * size)


def _unit_refused(file: str, name: str, unit: str, what: str, wanted: str) -> str:
    (plain, _), known = split_head(name), readable(wanted)
    such = f"write the column as {plain!r} with one of the units {', '.join(known)}: '{plain} [{next(iter(known))}]'"
    if not unit:
        return f"{file}: column {plain!r} has no unit; {such}"
    if what == "angle" and unit in SPEEDS:
        return f"{file}: {name!r} is a speed, in {unit}, no angle; give the column of the encoder's angle"
    if unit == "counts":
        return f"{file}: {name!r} is in counts; say how many are a turn, record(..., counts=8192)"
    if unit == "%":
        return f"{file}: {name!r} is in %; multiply it by the rated torque first, and {such}"
    return f"{file}: {name!r} is in {unit}, which is no unit of {what}; {such}"


def _ratio(name: str, value: float) -> float:
    found = number(name, value)
    if not 1e-6 < abs(found) < 1e6:
        raise PinpressError(f"{name} is {shown(value)}; give turns of motor or encoder by turns of the crank, such as 20.7")
    return found


def _continuous(readings: Array, per_unit: float, times: Array, name: str, notes: list[str], *, counted: bool) -> Array:
    """Readings of an encoder, in its unit, without the jumps where it starts anew; ``notes`` takes what was done."""
    if len(readings) < 2:
        return readings
    steps = np.diff(readings)
    turn = 2 * math.pi / per_unit
    rollovers = [turn, *(each for each in ROLLOVERS if counted and each > turn)]
    span = float(np.abs(steps).max())
    over = next((each for each in rollovers if JUMP * each < span < (2 - JUMP) * each), None)
    if over is None:
        return readings
    jumps = np.round(steps / over)
    notes.append(f"{name} starts anew {int(np.count_nonzero(jumps))} times, after {over:.6g} each; it was made continuous")
    return np.asarray(readings - over * np.concatenate([[0.0], np.cumsum(jumps)]))
