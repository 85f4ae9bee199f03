"""Spectra of measured vibrations: densities over the frequency, and amplitudes by order over the speed of the crank.

An order is a frequency divided by the crank's frequency: the first order occurs once a turn. Windows of whole turns, resampled in equal
steps of the crank angle, show orders as sharp lines while the speed changes. A natural frequency keeps its place in hertz, so it passes
through the orders when the speed rises.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..common.arguments import expect, number, whole_number
from ..common.errors import PinpressError, UnknownNameError
from ..common.quantities import RPM, Array
from ..common.results import Tabular
from ..foundation.mounted_press import VibrationModes
from .accelerometers import VibrationRun

NAMED = 6  # most lines and orders that are named


@dataclass(frozen=True, eq=False, repr=False)
class Spectra(Tabular):
    """Spectral densities of all channels, k lines. All arrays are read-only.

    Attributes:
        channels: names of the channels.
        frequency: (k,) frequencies [Hz].
        density: (k, channels) power spectral density of the acceleration; its integral over the frequency is the mean square
            [m2/s4/Hz].
        windows: number of averaged windows; a density has a relative standard deviation of about 1 / sqrt(windows).
    """

    channels: tuple[str, ...]
    frequency: Array
    density: Array
    windows: int

    @property
    def title(self) -> str:
        resolution = self.frequency[1] - self.frequency[0]
        size = f"lines {resolution:.4g} Hz apart to {self.frequency[-1]:.5g} Hz"
        return f"Spectra: {len(self.channels)} channels, {size}, {self.windows} windows"

    @property
    def rms(self) -> Array:
        """(channels,) root mean square of the acceleration [m/s2]."""
        return np.asarray(np.sqrt(self.density.sum(axis=0) * (self.frequency[1] - self.frequency[0])))

    @property
    def lines(self) -> Array:
        """(up to 6,) frequencies of peaks in the density summed over all channels, the strongest first [Hz].

        These peaks are higher than the scatter of noise, whose densities have a chi-squared distribution.
        """
        from scipy.signal import find_peaks  # slow to import
        from scipy.special import chdtri

        whole, freedoms = self.density.sum(axis=1), 0.9 * 2 * self.windows  # 90 % of half-overlapping windows count as independent
        rarely = 0.5 * 0.01 / len(whole)  # significance level: a peak is named in 1 % of spectra of pure noise
        scatter = float(chdtri(freedoms, rarely) / chdtri(freedoms, 1.0 - rarely))
        peaks, _ = find_peaks(np.log(np.maximum(whole, np.finfo(float).tiny)), prominence=np.log(max(4.0, scatter)))
        return np.asarray(self.frequency[peaks[np.argsort(-whole[peaks])][:NAMED]])

    def columns(self) -> dict[str, Array]:
        """Frequency, and the density of each channel."""
        return {"frequency [Hz]": self.frequency} | {f"{name} [m2/s4/Hz]": self.density[:, k] for k, name in enumerate(self.channels)}


@dataclass(frozen=True, eq=False, repr=False)
class OrderSpectra(Tabular):
    """Amplitudes by order in w windows, by rising speed. All arrays are read-only.

    Attributes:
        channels: names of the channels.
        speed: (w,) mean speed of the crank in each window [rad/s].
        order: (o,) orders, from 1 / turns [-].
        amplitude: (w, o, channels) amplitudes of the acceleration (peak values of a sine) [m/s2].
        turns: turns of the crank in a window.
        beside: calculated modes, see `with_modes`; None for none.
    """

    channels: tuple[str, ...]
    speed: Array
    order: Array
    amplitude: Array
    turns: int
    beside: VibrationModes | None = None

    @property
    def title(self) -> str:
        low, high = self.speed[0] / RPM, self.speed[-1] / RPM
        return (
            f"OrderSpectra: {len(self.speed)} windows of {self.turns} turns, {low:.4g} to {high:.4g} r/min, orders up to {self.order[-1]:g}"
        )

    def of(self, channel: str, order: float) -> Array:
        """Read the amplitudes (w,) of one order over the speed [m/s2].

        Args:
            channel: name of the channel.
            order: a multiple of 1 / turns.

        Raises:
            PinpressError: the windows do not resolve this order.
            UnknownNameError: there is no such channel.
        """
        if channel not in self.channels:
            raise UnknownNameError("channel", channel, self.channels)
        place = int(np.abs(self.order - number("order", order)).argmin())
        if abs(self.order[place] - order) > 1e-9:
            raise PinpressError(f"order {order:g} is not resolved: give a multiple of {1 / self.turns:g} up to {self.order[-1]:g}")
        return np.asarray(self.amplitude[:, place, self.channels.index(channel)])

    def peaks(self, channel: int) -> list[int]:
        """Places of the strongest orders of a channel, by rising order. The neighbours of a peak are not peaks, because the window spreads
        each line over them."""
        largest = self.amplitude[:, :, channel].max(axis=0)
        beside = np.pad(largest, 1)
        peaks = np.flatnonzero((largest > beside[:-2]) & (largest >= beside[2:]) & (largest > 0.02 * largest.max()))
        return sorted(map(int, peaks[np.argsort(-largest[peaks])][: NAMED // 2]))

    def with_modes(self, modes: VibrationModes) -> OrderSpectra:
        """The same spectra next to calculated modes, whose natural frequencies are lines in pictures.

        Raises:
            PinpressError: ``modes`` is not a `VibrationModes`.
        """
        expect("modes", modes, VibrationModes, "foundation.modes")
        return replace(self, beside=modes)

    def columns(self) -> dict[str, Array]:
        """A row for each window and order: speed, order, frequency, and the amplitude of each channel."""
        speed, order = (each.ravel() for each in np.meshgrid(self.speed, self.order, indexing="ij"))
        columns = {"speed [rad/s]": speed, "order [-]": order, "frequency [Hz]": order * speed / (2 * np.pi)}
        return columns | {f"{name} [m/s2]": self.amplitude[:, :, k].ravel() for k, name in enumerate(self.channels)}


def spectra(runs: Sequence[VibrationRun], channels: tuple[str, ...], resolution: float | None) -> Spectra:
    """Spectral densities, see `VibrationRecord.spectra`."""
    from scipy.signal import welch  # slow to import

    rate = runs[0].rate
    for run in runs:
        if abs(run.rate - rate) > 1e-3 * rate:
            raise PinpressError(
                f"{run.name} is sampled at {run.rate:.6g} Hz, {runs[0].name} at {rate:.6g} Hz: call spectra for each separately"
            )
    shortest = min(len(run.time) for run in runs)
    wanted = 8 * rate / shortest if resolution is None else number("resolution", resolution, "Hz", positive=True)
    length = round(rate / wanted)
    if not 8 <= length <= shortest:
        raise PinpressError(
            f"resolution {wanted:g} Hz needs windows of {length} samples, but the shortest run has {shortest}: give"
            f" {rate / shortest:.3g} to {rate / 8:.3g} Hz"
        )
    counts = [(len(run.time) - length // 2) // (length - length // 2) for run in runs]
    parts = [welch(run.acceleration, rate, nperseg=length, axis=0) for run in runs]
    density = sum(count * part for count, (_, part) in zip(counts, parts, strict=True)) / sum(counts)
    return Spectra(channels, parts[0][0], np.asarray(density), sum(counts))


def order_spectra(runs: Sequence[VibrationRun], channels: tuple[str, ...], orders: float, turns: int) -> OrderSpectra:
    """Amplitudes by order, see `VibrationRecord.order_spectra`."""
    highest, turns = number("orders", orders, positive=True), whole_number("turns", turns, 2, 10_000)
    windows = sorted((window for run in runs for window in _windows(run, highest, turns)), key=lambda window: window[0])
    speeds, amplitudes = zip(*windows, strict=True)
    kept = int(highest * turns + 1e-9)
    return OrderSpectra(channels, np.array(speeds), np.arange(1, kept + 1) / turns, np.array(amplitudes)[:, 1 : kept + 1], turns)


def _windows(run: VibrationRun, highest: float, turns: int) -> list[tuple[float, Array]]:
    """Mean speed and amplitudes (orders, channels) of each window of a run."""
    from scipy.interpolate import make_interp_spline  # slow to import
    from scipy.signal import firwin, resample_poly

    if run.angle is None:
        raise PinpressError(f"{run.name}: the crank angle is not known: give angle=, tacho= or speed= to vibration")
    angle = run.angle if run.angle[-1] > run.angle[0] else -run.angle
    if not (np.diff(angle) > 0).all():
        moment = run.time[int(np.argmin(np.diff(angle)))]
        raise PinpressError(f"{run.name}: the crank turns back or rests at {moment:.6g} s: give a run in which it keeps turning")
    count = int((angle[-1] - angle[0]) / (2 * np.pi * turns))
    if count < 1:
        turned = (angle[-1] - angle[0]) / (2 * np.pi)
        raise PinpressError(
            f"{run.name}: {turned:.4g} turns of the crank are less than a window of {turns}: give fewer turns=, or a longer run"
        )
    fastest = float((np.diff(angle) / np.diff(run.time)).max())
    needed = 2 / 0.8 * highest * fastest / (2 * np.pi)  # recorders have flat amplitudes up to 0.8 of the Nyquist frequency
    if run.rate < needed:
        raise PinpressError(
            f"{run.name}: order {highest:g} at {fastest / RPM:.4g} r/min is {highest * fastest / (2 * np.pi):.4g} Hz;"
            f" {run.rate:.6g} samples a second are too few: sample at {needed:.4g} Hz, or give fewer orders"
        )
    slowest = (angle[-1] - angle[0]) / (run.time[-1] - run.time[0])
    points = 1 << int(np.ceil(np.log2(max(run.rate * 2 * np.pi / min(slowest, fastest) * 2, 8 * highest))))
    # A spline through 2.5 samples a period flattens a sine by 16 %, through ten samples by 0.1 %. So the signal is first upsampled
    # fourfold, by a filter over 20 samples to both sides that keeps amplitudes within 1e-4.
    between = firwin(2 * 20 * 4 + 1, 1 / 4, window=("kaiser", 8.0))
    fine = resample_poly(run.acceleration, 4, 1, axis=0, window=between, padtype="line")
    resampled = make_interp_spline(np.arange(len(fine)) / 4, fine, k=3)
    sample, moment = (make_interp_spline(angle, each, k=3) for each in (np.arange(len(angle)), run.time))
    window = np.hanning(turns * points + 1)[:-1, None]
    windows = []
    for k in range(count):
        begin = angle[0] + 2 * np.pi * turns * k
        values = resampled(sample(begin + 2 * np.pi / points * np.arange(turns * points)))
        lines = np.fft.rfft(window * (values - values.mean(axis=0)), axis=0)
        first, last = moment([begin, begin + 2 * np.pi * turns])
        windows.append((float(2 * np.pi * turns / (last - first)), (2 * np.abs(lines) / window.sum())[: int(highest * turns + 1e-9) + 1]))
    return windows
