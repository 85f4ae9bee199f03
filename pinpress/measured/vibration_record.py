"""Vibrations of a press measured by accelerometers on its frame.

record = pp.measured.vibration("hits.csv", {"ch1 [V]": pp.measured.Accelerometer((0.9, 0, 1.2), "z", gain=98.1)})
record.modes(beside=pp.foundation.modes(system))
record.spectra()
record.order_spectra()
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import expect, number, numbers, typed, whole_number
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.quantities import RPM
from ..common.reading.columns import split_head
from ..common.results import Tabular
from ..common.tables import Column
from ..foundation.free_decay import logarithmic_decrement
from ..foundation.mounted_press import VibrationModes
from .accelerometers import Accelerometer, Source, VibrationRun, points_of, run_of
from .hit_modes import MeasuredModes, hit_modes
from .vibration_spectra import OrderSpectra, Spectra, order_spectra, spectra


@dataclass(frozen=True, eq=False, repr=False)
class VibrationRecord(Tabular):
    """Accelerations of one or several runs, made by `vibration`.

    Attributes:
        accelerometers: name of a channel -> its accelerometer.
        runs: the runs, all with the same channels.
    """

    accelerometers: Mapping[str, Accelerometer]
    runs: tuple[VibrationRun, ...]

    @property
    def title(self) -> str:
        seconds = sum(float(run.time[-1] - run.time[0]) for run in self.runs)
        rates = sorted({f"{run.rate:.6g}" for run in self.runs})
        return f"VibrationRecord: {len(self.accelerometers)} channels, {len(self.runs)} runs, {seconds:.4g} s at {', '.join(rates)} Hz"

    def columns(self) -> dict[str, Column]:
        """A row for each channel of each run: its place, direction, root mean square and largest size."""
        rows = [(run, k, name) for run in self.runs for k, name in enumerate(self.accelerometers)]
        sensors = [self.accelerometers[name] for _, _, name in rows]
        columns: dict[str, Column] = {"run": [run.name for run, _, _ in rows], "channel": [name for _, _, name in rows]}
        columns |= {f"{axis} [m]": [float(sensor.place[i]) for sensor in sensors] for i, axis in enumerate("xyz")}
        columns |= {f"along_{axis} [-]": [float(sensor.along[i]) for sensor in sensors] for i, axis in enumerate("xyz")}
        return columns | {
            "rms [m/s2]": [float(run.acceleration[:, k].std()) for run, k, _ in rows],
            "peak [m/s2]": [float(np.abs(run.acceleration[:, k]).max()) for run, k, _ in rows],
        }

    def channel(self, name: str) -> int:
        """Number of the channel of this name.

        Raises:
            UnknownNameError: there is no such channel.
        """
        if name not in self.accelerometers:
            raise UnknownNameError("channel", name, self.accelerometers)
        return list(self.accelerometers).index(name)

    def spectra(self, resolution: float | None = None) -> Spectra:
        """Compute spectral densities of all channels over all runs by Welch's method (half-overlapping Hann windows).

        Args:
            resolution: distance of the lines [Hz]; by default such that about 16 windows are averaged.

        Raises:
            PinpressError: a run is shorter than one window, or the runs differ in their sampling rate.
        """
        return spectra(self.runs, tuple(self.accelerometers), resolution)

    def order_spectra(self, orders: float = 12.0, *, turns: int = 8) -> OrderSpectra:
        """Compute amplitudes by order (multiples of the crank's speed) over the speed; an order grows near a natural frequency.

        The accelerations are resampled in equal steps of the crank angle, so lines stay sharp while the speed changes.

        Args:
            orders: highest order.
            turns: turns of the crank in a window; the resolution is 1 / turns orders.

        Raises:
            PinpressError: the crank angle is not known, or a run has fewer turns or is sampled too slowly for the highest order.
        """
        return order_spectra(self.runs, tuple(self.accelerometers), orders, turns)

    def modes(
        self,
        beside: VibrationModes | None = None,
        *,
        band: tuple[float, float] | None = None,
        count: int | None = None,
        hits: ArrayLike | None = None,
    ) -> MeasuredModes:
        """Identify natural frequencies, damping and shapes from the free vibration after hits with a hammer on the frame at rest.

        Args:
            beside: calculated modes to compare with the measured modes.
            band: (2,) lowest and highest frequency of the modes [Hz]; by default from half the lowest to 1.3 times the highest of
                ``beside``.
            count: number of modes; by default all modes above the noise.
            hits: times of the hits in a single run [s]; by default they are searched.

        Raises:
            PinpressError: no hit is found, the sampling is too slow for the band, or no mode is above the noise.

        Warns:
            PinpressWarning: two modes are too close to be separated with fewer hits than modes.
        """
        if beside is not None:
            expect("beside", beside, VibrationModes, "foundation.modes")
        return hit_modes(self.runs, self.accelerometers, beside, band, count, hits)

    def decrement(self, channel: str, band: tuple[float, float], *, start: float | None = None, end: float | None = None) -> float:
        """Compute the logarithmic decrement of a channel's strongest vibration in a band, in a free decay of the first run [-].

        Args:
            channel: name of the channel.
            band: (2,) lowest and highest frequency [Hz].
            start: start of the decay, after its cause has ended; by default the record's first time [s].
            end: end of the decay; by default the record's last time [s].

        Raises:
            PinpressError: as for `foundation.logarithmic_decrement`.
            UnknownNameError: there is no such channel.
        """
        run = self.runs[0]
        first = run.time[0] if start is None else number("start", start, "s")
        last = run.time[-1] if end is None else number("end", end, "s")
        within = (run.time >= first) & (run.time <= last)
        return logarithmic_decrement(run.acceleration[within, self.channel(channel)], rate=run.rate, band=band)


@typed
def vibration(
    source: Source | Sequence[Source],
    points: Mapping[str, Accelerometer] | str | os.PathLike[str],
    *,
    time: str | None = None,
    angle: str | None = None,
    tacho: str | None = None,
    pulses: int = 1,
    speed: ArrayLike | None = None,
) -> VibrationRecord:
    """Read records of accelerometers.

    Args:
        source: a file (.csv, .parquet, .mat, .mf4) or columns {"time [s]": ..., "A [g]": ...}; or a list of these, one for each run, with
            the same channels.
        points: column with its unit (m/s2, g, or V with a gain) -> accelerometer; or a CSV file with the columns channel, x, y, z [m],
            direction and, if needed, part (bed or crown) and gain [m/s2 per V].
        time: column of the time [s, ms]; by default the column time or t.
        angle: column of the crank angle [rad, deg, turns], if it was measured.
        tacho: column of a tacho with pulses, in any unit.
        pulses: pulses of the tacho for each turn of the crank.
        speed: constant speed of the crank, one for all runs or one for each run [rad/s].

    Raises:
        PinpressError: a file or a column cannot be read; a channel has no point, or no unit; samples are missing, or not in equal steps.
        UnknownNameError: there is no such column.

    Warns:
        PinpressWarning: a channel stays at its extreme, as if an amplifier is overdriven; accelerations are above 1000 g; a channel is
            constant.
    """
    sources: list[Source] = list(source) if isinstance(source, list | tuple) else [source]  # type: ignore[list-item]  # one of both
    if not sources or not all(isinstance(each, str | os.PathLike | Mapping) for each in sources):
        raise PinpressError(f"source is {shown(source)}: give a file, columns {{'time [s]': ..., 'A [g]': ...}}, or a list of them")
    for what, name in (("time", time), ("angle", angle), ("tacho", tacho)):
        if name is not None and not isinstance(name, str):
            raise PinpressError(f"{what} is {shown(name)}: give the name of a column")
    if sum(each is not None for each in (angle, tacho, speed)) > 1:
        raise PinpressError("several of angle, tacho and speed are given: give only one of them")
    sensors = points_of(points) if isinstance(points, str | os.PathLike) else points
    named = isinstance(sensors, Mapping) and all(
        isinstance(name, str) and isinstance(each, Accelerometer) for name, each in sensors.items()
    )
    if not named or not sensors:
        raise PinpressError(f"points is {shown(points)}: give {{'A [m/s2]': Accelerometer((x, y, z), 'z'), ...}}, or a CSV file")
    speeds: list[float | None] = [None] * len(sources)
    if speed is not None:
        given = numbers("speed", speed, unit="rad/s")
        if given.shape not in ((), (len(sources),)) or not (given > 0).all():
            one = f"give one positive speed, or {len(sources)}, one for each run [rad/s]; {RPM:.5g} is 1 r/min"
            raise PinpressError(f"speed is {shown(speed)}: {one}")
        speeds = list(np.broadcast_to(given, (len(sources),)))
    crank = angle, tacho, whole_number("pulses", pulses, 1, 100_000)
    runs = [run_of(each, f"run {k + 1}", sensors, time, crank, speeds[k]) for k, each in enumerate(sources)]
    return VibrationRecord({split_head(name)[0]: each for name, each in sensors.items()}, tuple(runs))
