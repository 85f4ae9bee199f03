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

from ..common import tables
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
    """What accelerometers measured in one or several runs, made by `vibration`.

    Attributes:
        accelerometers: by the name of the channel.
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

    def __str__(self) -> str:
        rows = [["channel", "at", "along", *(f"{run.name}, rms" for run in self.runs), "peak"]]
        for k, (name, sensor) in enumerate(self.accelerometers.items()):
            place = ("crown " if sensor.on_crown else "") + ", ".join(f"{each:.4g}" for each in sensor.place) + " m"
            along = sensor.direction if isinstance(sensor.direction, str) else ", ".join(f"{each:.3g}" for each in sensor.along)
            peak = max(float(np.abs(run.acceleration[:, k]).max()) for run in self.runs)
            rows.append([name, place, str(along), *(f"{run.acceleration[:, k].std():.4g} m/s2" for run in self.runs), f"{peak:.4g} m/s2"])
        return "\n".join([self.title, *tables.fitted(rows)])

    def channel(self, name: str) -> int:
        """Number of the channel of this name.

        Raises:
            UnknownNameError: there is none.
        """
        if name not in self.accelerometers:
            raise UnknownNameError("channel", name, self.accelerometers)
        return list(self.accelerometers).index(name)

    def spectra(self, resolution: float | None = None) -> Spectra:
        """Spectral densities of all channels, by Welch's method (half-overlapping Hann windows), over all runs.

        Args:
            resolution: distance of the lines [Hz]; by default such that about 16 windows are averaged.

        Raises:
            PinpressError: a run is shorter than one window, or sampled at another rate than the others.
        """
        return spectra(self.runs, tuple(self.accelerometers), resolution)

    def order_spectra(self, orders: float = 12.0, *, turns: int = 8) -> OrderSpectra:
        """Amplitudes by order (multiples of the crank's speed) over the speed: what grows where an order meets a natural frequency.

        The accelerations are resampled in equal steps of the crank angle, so that lines stay sharp while the speed changes.

        Args:
            orders: highest order.
            turns: turns of the crank in a window, which parts orders 1 / turns apart.

        Raises:
            PinpressError: nothing says the crank angle, a run has fewer turns, or is sampled too slowly for the highest order.
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
        """Natural frequencies, damping and shapes from the free vibration after hits with a hammer on the frame at rest.

        Args:
            beside: calculated modes, which are laid beside the measured ones.
            band: (2,) lowest and highest frequency that is looked at [Hz]; by default from half the lowest to 1.3 times the highest of
                ``beside``.
            count: number of modes; by default as many as stand out of the noise.
            hits: times of the hits in a single run [s]; by default they are found.

        Raises:
            PinpressError: no hit is found, the sampling is too slow for the band, or no mode stands out.

        Warns:
            PinpressWarning: two modes lie so close to each other that fewer hits than modes mix their shapes.
        """
        if beside is not None:
            expect("beside", beside, VibrationModes, "foundation.modes")
        return hit_modes(self.runs, self.accelerometers, beside, band, count, hits)

    def decrement(self, channel: str, band: tuple[float, float], *, start: float | None = None, end: float | None = None) -> float:
        """Logarithmic decrement of the strongest vibration of a channel in a band, in a free decay of the first run [-].

        Args:
            channel: its name.
            band: (2,) lowest and highest frequency [Hz].
            start: of the decay, when its cause has ended; by default where the record begins [s].
            end: of the decay; by default where the record ends [s].

        Raises:
            PinpressError: as `foundation.logarithmic_decrement`.
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
    """Read what accelerometers measured.

    Args:
        source: a file (.csv, .parquet, .mat, .mf4), or columns {"time [s]": ..., "A [g]": ...}, or a list of these, one for each run, with
            the same channels.
        points: accelerometer by the name of its column, with its unit: m/s2, g, or V with a gain; or a CSV file with the columns channel,
            x, y, z [m], direction, and if need be part (bed or crown) and gain [m/s2 per V].
        time: column of the time [s, ms]; by default the one called time or t.
        angle: column of the crank angle [rad, deg, turns], if it was measured.
        tacho: column of a tacho that gives pulses, of any unit, if there is one.
        pulses: pulses of the tacho by turn of the crank.
        speed: speed of the crank, where it is known and constant, or one for each run [rad/s].

    Raises:
        PinpressError: a file or a column cannot be read; a channel has no point, or no unit; samples are missing, or not in equal steps.
        UnknownNameError: there is no such column.

    Warns:
        PinpressWarning: a channel stays at its extreme, as where an amplifier is overdriven; accelerations are above 1000 g; a channel is
            silent.
    """
    sources: list[Source] = list(source) if isinstance(source, list | tuple) else [source]  # type: ignore[list-item]  # one of both
    if not sources or not all(isinstance(each, str | os.PathLike | Mapping) for each in sources):
        raise PinpressError(f"source is {shown(source)}: give a file, columns {{'time [s]': ..., 'A [g]': ...}}, or a list of them")
    for what, name in (("time", time), ("angle", angle), ("tacho", tacho)):
        if name is not None and not isinstance(name, str):
            raise PinpressError(f"{what} is {shown(name)}: give the name of a column")
    if sum(each is not None for each in (angle, tacho, speed)) > 1:
        raise PinpressError("several of angle, tacho and speed are given: give the one that says where the crank is")
    sensors = points_of(points) if isinstance(points, str | os.PathLike) else points
    named = isinstance(sensors, Mapping) and all(
        isinstance(name, str) and isinstance(each, Accelerometer) for name, each in sensors.items()
    )
    if not named or not sensors:
        raise PinpressError(f"points is {shown(points)}: give {{'A [m/s2]': Accelerometer((x, y, z), 'z'), ...}}, or a CSV file")
    speeds = [None] * len(sources) if speed is None else _speeds(speed, len(sources))
    runs = [
        run_of(each, f"run {k + 1}", sensors, time, (angle, tacho, whole_number("pulses", pulses, 1, 100_000)), given)
        for k, (each, given) in enumerate(zip(sources, speeds, strict=True))
    ]
    return VibrationRecord({split_head(name)[0]: each for name, each in sensors.items()}, tuple(runs))


def _speeds(speed: ArrayLike, runs: int) -> list[float]:
    given = numbers("speed", speed, unit="rad/s")
    if given.shape not in ((), (runs,)) or not (given > 0).all():
        raise PinpressError(f"speed is {shown(speed)}: give one positive speed, or {runs}, one for each run [rad/s]; {RPM:.5g} is 1 r/min")
    return list(np.broadcast_to(given, (runs,)))
