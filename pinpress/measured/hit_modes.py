"""Natural frequencies, damping and shapes of a press from hits with a hammer on its frame at rest.

After a hit the frame vibrates freely. What accelerometers measure then is a sum of decaying modes,

    y(t) = sum over modes of 2 Re(shape x strength of the hit in the mode x exp(s t)),    s = -z w + i w sqrt(1 - z^2),

with the same s and shape after all hits. The modes are found in two steps. The eigensystem realisation algorithm (Juang and Pappa 1985)
concatenates the Hankel matrices of all hits, truncates the rank to the part above the noise (Gavish and Donoho 2014), and computes s from
the shift of the rows. Starting from these s, the Gauss-Newton method fits s, shapes and strengths to all samples, and gives standard
deviations. Modes whose frequencies differ by less than their bandwidth can be separated only by hits that excite them differently: a single
hit mixes them.

First the samples are filtered and thinned. The filter has a finite length; after this length a free vibration is again a free vibration.

A hammer that bounces strikes again while the frame vibrates. Then the vibration is not the free vibration after the first blow, and the
residual of the modes is more than noise. A free vibration is free at any later time too, so later beginnings are tried until the residual
is only noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.arguments import numbers, suitable_numbers, whole_number
from ..common.errors import PinpressError, caution
from ..common.numerics import pair_modes
from ..common.quantities import Array, ComplexArray
from ..common.results import Tabular
from ..common.tables import Column
from ..foundation.mounted_press import VibrationModes
from .accelerometers import Accelerometer, VibrationRun

Samples = NDArray[np.intp]
FAINT = 1e-4  # a jump of energy below this share of the strongest hit is not a hit
MOST_DAMPED = 0.5  # a root with a higher damping ratio is not a mode
HUMMING = 5e-4  # a vibration with a lower damping ratio is mains hum or a nearby machine
MOST_MODES = 60
OUT_OF_NOISE = 4.0  # a mode is noise if the rms of its strengths / their standard deviations is smaller
SETTLED = 1e-9  # relative change of the roots below which the Gauss-Newton method ends


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredModes(Tabular):
    """m modes measured by hits, in order of frequency, compared with calculated modes. All arrays are read-only.

    Attributes:
        channels: names of the c channels.
        hits: (h,) times of the hits, run after run [s].
        natural_frequency: (m,) natural frequencies of the undamped modes [rad/s].
        natural_frequency_deviation: (m,) standard deviations of the natural frequencies due to noise [rad/s].
        damping_ratio: (m,) damping divided by critical damping [-].
        damping_ratio_deviation: (m,) standard deviations of the damping ratios due to noise [-].
        shapes: (c, m) complex shapes at the channels; the largest element is 1.
        energy_share: (m,) share of each mode in the energy of the measured vibration [-].
        noise: share of the energy that no mode explains [-].
        beside: calculated modes; None if none are given.
        partner: (m,) number of the calculated mode that belongs to the measured mode; -1 without a partner.
        mac: (m, n) modal assurance criterion of m measured and n calculated shapes at the accelerometers; 1 if they agree.
        misfit: factor on the deviations because the residual is more than noise; 1 if the residual is noise [-].
        late: time after the hits at which the vibration becomes free; above 0 if the hammer is soft or bounces [s].
    """

    channels: tuple[str, ...]
    hits: Array
    natural_frequency: Array
    natural_frequency_deviation: Array
    damping_ratio: Array
    damping_ratio_deviation: Array
    shapes: ComplexArray
    energy_share: Array
    noise: float
    beside: VibrationModes | None
    partner: tuple[int, ...]
    mac: Array
    misfit: float = 1.0
    late: float = 0.0

    @property
    def title(self) -> str:
        found = ", ".join(f"{w / (2 * np.pi):.4g}" for w in self.natural_frequency)
        return f"MeasuredModes: {found} Hz, of {len(self.hits)} hits and {len(self.channels)} channels"

    @property
    def logarithmic_decrement(self) -> Array:
        """(m,) logarithmic decrements [-]."""
        return np.asarray(2 * np.pi * self.damping_ratio / np.sqrt(1 - self.damping_ratio**2))

    def columns(self) -> dict[str, Column]:
        """A row for each mode: measured frequency and damping, calculated frequency and damping, and agreement of the shapes."""
        columns: dict[str, Column] = {
            "frequency [Hz]": self.natural_frequency / (2 * np.pi),
            "frequency_deviation [Hz]": self.natural_frequency_deviation / (2 * np.pi),
            "damping_ratio [-]": self.damping_ratio,
            "damping_ratio_deviation [-]": self.damping_ratio_deviation,
            "logarithmic_decrement [-]": self.logarithmic_decrement,
            "energy_share [-]": self.energy_share,
        }
        if self.beside is None:
            return columns
        theirs = [None if k < 0 else k for k in self.partner]
        frequency = [None if k is None else float(self.beside.natural_frequency[k]) / (2 * np.pi) for k in theirs]
        return columns | {
            "motion": [None if k is None else self.beside.motion[k] for k in theirs],
            "calculated_frequency [Hz]": frequency,
            "calculated_damping_ratio [-]": [None if k is None else float(self.beside.damping_ratio[k]) for k in theirs],
            "mac [-]": [None if k is None else float(self.mac[i, k]) for i, k in enumerate(theirs)],
        }

    @property
    def doubts(self) -> tuple[str, ...]:
        """Doubts about these modes, one sentence each."""
        found = []
        for one, other in self._close():
            frequencies = " and ".join(f"{self.natural_frequency[k] / (2 * np.pi):.4g}" for k in (one, other))
            found.append(
                f"{frequencies} Hz are closer than their damping is wide: {len(self.hits)} hit mixes their shapes; hit elsewhere too"
            )
        if self.beside is not None:
            for k, place in enumerate(self.partner):
                if place >= 0 and self.mac[k, place] < 0.8:
                    frequency = self.natural_frequency[k] / (2 * np.pi)
                    found.append(f"{frequency:.4g} Hz differs in shape from {self.beside.motion[place]!r}: MAC {self.mac[k, place]:.2f}")
        for w in self.natural_frequency[self.damping_ratio < HUMMING]:
            found.append(f"{w / (2 * np.pi):.4g} Hz does not die away: it is not a mode, but a hum or a machine that runs nearby")
        if self.noise > 0.3:
            found.append(
                f"{100 * self.noise:.2g} % of the energy after the hits is not free vibration of these modes: check the times of"
                " the hits, or give another band"
            )
        if self.late > 0:
            found.append(
                f"the first {self.late:.2g} s after the hits are left out, because the vibration is not yet free: the hammer is soft,"
                " or it bounced and struck again"
            )
        if self.misfit > 1.0:
            found.append(
                f"the residual is more than noise, so deviations are {self.misfit:.3g} times as wide: the hammer may have"
                " struck again, or a mode is missing. Hit once and hold the hammer back, or give a wider band"
            )
        return tuple(found)

    def _close(self) -> list[tuple[int, int]]:
        """Pairs of modes that these hits cannot separate, because there are fewer hits than modes."""
        w, width = self.natural_frequency, self.damping_ratio * self.natural_frequency
        pairs = [(k, k + 1) for k in range(len(w) - 1) if w[k + 1] - w[k] < width[k] + width[k + 1]]
        return pairs if len(self.hits) < 2 else []


class _Decays(NamedTuple):
    """Free vibrations after hits.

    Attributes:
        values: for each hit (n, channels) samples.
        step: time between samples [s].
        hits: (h,) times of the hits [s].
        colour: variance of the noise in the band / its mean over all frequencies.
    """

    values: tuple[Array, ...]
    step: float
    hits: Array
    colour: float

    def waves(self, hit: int, roots: ComplexArray) -> ComplexArray:
        """(n, m) exp(s t) after a hit."""
        return np.asarray(np.exp(np.outer(self.step * np.arange(len(self.values[hit])), roots)))


class _Model(NamedTuple):
    """Decaying modes: roots s (m,) [1/s], shapes (channels, m), strengths (m, hits)."""

    roots: ComplexArray
    shapes: ComplexArray
    strengths: ComplexArray

    def of(self, modes: Samples) -> _Model:
        """The model of only these modes, in this order."""
        return _Model(self.roots[modes], self.shapes[:, modes], self.strengths[modes])


class _Fit(NamedTuple):
    """Modes of free vibrations.

    Attributes:
        model: the modes.
        deviations: (m, 2) standard deviations of natural frequencies [rad/s] and damping ratios.
        noise: share of the energy that no mode explains.
        misfit: factor on the deviations because the residual is more than noise.
    """

    model: _Model
    deviations: Array
    noise: float
    misfit: float


def hit_modes(
    runs: Sequence[VibrationRun],
    accelerometers: Mapping[str, Accelerometer],
    beside: VibrationModes | None,
    band: tuple[float, float] | None,
    count: int | None,
    hits: ArrayLike | None,
) -> MeasuredModes:
    """Identify modes from hits, see `VibrationRecord.modes`."""
    low, high = _band(runs, beside, band)
    wanted = None if count is None else whole_number("count", count, 1, MOST_MODES)
    decays, fit, late = _begun_in_time(_free_vibrations(runs, low, high, hits), low, high, wanted)
    order = np.argsort(np.abs(fit.model.roots))
    model, deviations = fit.model.of(order), fit.deviations[order]
    partner, mac = _beside(model, accelerometers, beside)
    size = np.abs(model.roots)
    found = MeasuredModes(
        channels=tuple(accelerometers),
        hits=decays.hits,
        natural_frequency=size,
        natural_frequency_deviation=deviations[:, 0],
        damping_ratio=-model.roots.real / size,
        damping_ratio_deviation=deviations[:, 1],
        shapes=model.shapes,
        energy_share=_energy_share(decays, model),
        noise=fit.noise,
        misfit=fit.misfit,
        late=late,
        beside=beside,
        partner=partner,
        mac=mac,
    )
    for first, second in found._close()[:1]:
        caution(f"modes {first + 1} and {second + 1}: {found.doubts[0]}")
    if found.misfit > 1.0:
        caution(found.doubts[-1])
    return found


def _begun_in_time(decays: _Decays, low: float, high: float, wanted: int | None) -> tuple[_Decays, _Fit, float]:
    """Free vibrations whose residual is only noise, their modes, and the time after the hits at which they begin [s].

    If there is no such time, they begin at the hits.
    """
    step = max(1, round(0.5 / (low * decays.step)))
    first = _fitted(decays, _realised(decays, low, high, wanted), wanted)
    if first.misfit > 1.0:
        for skipped in range(step, min(map(len, decays.values)) - 6 * step, step):
            later = decays._replace(values=tuple(part[skipped:] for part in decays.values))
            try:
                fit = _fitted(later, _realised(later, low, high, wanted), wanted)
            except PinpressError:  # the vibration has died away
                break
            if fit.misfit <= 1.0:
                return later, fit, skipped * decays.step
    return decays, first, 0.0


def _band(runs: Sequence[VibrationRun], beside: VibrationModes | None, band: tuple[float, float] | None) -> tuple[float, float]:
    """Lowest and highest frequency [Hz]."""
    rate = min(run.rate for run in runs)
    if band is None:
        if beside is None:
            raise PinpressError("neither beside nor band is given: give the band of frequencies, band=(2, 40) [Hz]")
        ends = np.array([0.5 * beside.natural_frequency[0], 1.3 * beside.natural_frequency[-1]]) / (2 * np.pi)
    else:
        ends = suitable_numbers("band", band, "lowest and highest frequency, both positive [Hz]", (2,), lambda f: 0 < f[0] < f[1])
    needed = 2.56 * ends[1]  # the usual factor of recorders
    if rate < needed:
        raise PinpressError(
            f"{rate:.6g} samples a second are too few for {ends[1]:.4g} Hz: sample at {needed:.4g} Hz, or give a lower band"
        )
    return float(ends[0]), float(ends[1])


# ------------------------------------------------------------------------------------------------------------------------- free vibrations


def _free_vibrations(runs: Sequence[VibrationRun], low: float, high: float, hits: ArrayLike | None) -> _Decays:
    """The parts of all runs after hits, filtered and thinned; raises PinpressError if there is no such part."""
    from scipy.signal import fftconvolve, firwin  # slow to import

    rate = runs[0].rate
    if any(abs(run.rate - rate) > 1e-3 * rate for run in runs):
        raise PinpressError("the runs are sampled at different rates: call modes for each run separately")
    if hits is not None and len(runs) > 1:
        raise PinpressError(f"hits are given for {len(runs)} runs: give only one run, or leave hits out (then they are searched)")
    thinning = max(1, int(rate / (5 * high)))  # five samples per period of the highest frequency remain
    weights = np.ones(1)
    if thinning > 1:  # a filter of finite length prevents aliasing into the band
        stop = rate / thinning - high
        weights = firwin(int(np.ceil(3.3 * rate / (stop - high))) | 1, (high + stop) / rate, window="hamming")
    values, times = [], []
    for run in runs:
        starts = _hits(run, low) if hits is None else _given(run, hits)
        for start, end in zip(starts, np.append(starts[1:], len(run.time)), strict=True):
            part = run.acceleration[start + int(np.ceil(0.5 * rate / high)) : end - len(weights)]
            if len(part) - len(weights) >= 3 * rate / low:
                filtered = part if thinning == 1 else fftconvolve(part, weights[:, None], mode="valid", axes=0)
                values.append(np.asarray(filtered[::thinning]))
                times.append(run.time[start])
    if not values:
        raise PinpressError(f"after no hit there are three periods of {low:.4g} Hz without another hit: hit less often, and record longer")
    return _Decays(tuple(values), thinning / rate, np.array(times), float(1 / (thinning * (weights**2).sum())))


def _given(run: VibrationRun, hits: ArrayLike) -> Samples:
    moments = np.sort(numbers("hits", hits, (None,), unit="s"))
    outside = (moments < run.time[0]) | (moments > run.time[-1])
    if not len(moments) or outside.any():
        raise PinpressError(f"hits: give times from {run.time[0]:.6g} to {run.time[-1]:.6g} s, at least one")
    return np.searchsorted(run.time, moments).astype(np.intp)


def _hits(run: VibrationRun, low: float) -> Samples:
    """Samples at which hits begin: the energy jumps up."""
    from scipy.signal import find_peaks  # slow to import

    half = max(2, round(0.5 * run.rate / low))
    energy = np.concatenate([[0.0], np.cumsum((run.acceleration**2).sum(axis=1))])
    count = len(run.time)
    place = np.arange(count)
    after = energy[np.minimum(place + half, count)] - energy[place]
    before = energy[place] - energy[np.maximum(place - half, 0)]
    jump = np.log((after + FAINT * after.max()) / (before + FAINT * after.max()))
    jump[: min(half, count) // 8] = 0.0  # the time before the record is unknown
    peaks, _ = find_peaks(jump, height=np.log(9.0), distance=half)  # the amplitude becomes three times as large
    peaks = peaks[after[peaks] > 10 * FAINT * after.max()]
    if not len(peaks):
        raise PinpressError(
            f"{run.name}: no hit stands out: record the frame at rest and hit it with a soft hammer, or give the times, hits=[1.2, 9.5]"
        )
    return np.asarray(peaks, dtype=np.intp)


# ----------------------------------------------------------------------------------------------------------------------------------- modes


def _realised(decays: _Decays, low: float, high: float, wanted: int | None) -> ComplexArray:
    """Roots s of the modes in the band by the eigensystem realisation algorithm."""
    channels = decays.values[0].shape[1]
    shortest = min(map(len, decays.values))
    reach = 0.5 / (low * decays.step)  # half a period of the lowest frequency
    rows = int(np.clip(reach, 48 / channels, max(400 / channels, 2)))  # the largest size that is still decomposed quickly
    apart = max(1, min(round(reach / rows), shortest // (2 * rows)))
    rows = max(2, min(rows, shortest // (2 * apart)))
    starts = apart * np.arange(rows)

    def hankel(shift: int) -> Array:
        lengths = [min(len(part) - int(starts[-1]) - 1, 600) for part in decays.values]
        return np.block([[part[k + shift : k + shift + n].T for part, n in zip(decays.values, lengths, strict=True)] for k in starts])

    matrix = hankel(0)
    left, sizes, right = np.linalg.svd(matrix, full_matrices=False)
    ratio = min(matrix.shape) / max(matrix.shape)
    # singular values of noise are smaller (Gavish and Donoho 2014)
    threshold = (0.56 * ratio**3 - 0.95 * ratio**2 + 1.82 * ratio + 1.43) * np.median(sizes)
    order = int((sizes > threshold).sum())
    if wanted is not None:
        order = max(order, 2 * wanted + 2)
    order = min(order, 2 * MOST_MODES, int((sizes > 1e-12 * sizes[0]).sum()))
    root = np.sqrt(sizes[:order])
    advance = (left[:, :order] / root).T @ hankel(1) @ (right[:order].T / root)
    multipliers = np.linalg.eigvals(advance).astype(complex)
    roots = np.log(multipliers[np.abs(multipliers) > 0]) / decays.step
    size = np.abs(roots)
    within = (roots.imag > 0) & (size >= 2 * np.pi * low) & (size <= 2 * np.pi * high)
    within &= (roots.real < 0.01 * size) & (-roots.real < MOST_DAMPED * size)  # noise may give a hum a small negative damping
    if not within.any():
        raise PinpressError(f"no mode between {low:.4g} and {high:.4g} Hz stands out of the noise: hit harder, or give another band")
    return np.asarray(np.minimum(roots.real, 0.0)[within] + 1j * roots.imag[within])


def _fitted(decays: _Decays, roots: ComplexArray, wanted: int | None) -> _Fit:
    """The model that fits all samples best.

    Modes that do not stand out of the noise are left out, the faintest first.
    """
    model, scale = _separate(decays, roots), np.ones(decays.values[0].shape[1])
    while True:
        model, distinct, _ = _weighted(decays, model, scale, 4)  # few steps are enough to see which modes are noise
        dropped = _dropped(model, distinct, wanted)
        if not dropped:
            break
        model = model.of(np.delete(np.arange(len(distinct)), dropped))
    noise = np.sqrt(np.mean([(part**2).mean(axis=0) for part in _residual(decays, model)], axis=0))
    if noise.max() > 0:
        scale = np.maximum(noise, 0.1 * np.median(noise))
    model, distinct, covariance = _weighted(decays, model, scale, 30)
    if distinct.max() < OUT_OF_NOISE:
        raise PinpressError("no mode stands out of the noise: hit harder, or give another band")
    unit = model.shapes[np.abs(model.shapes).argmax(axis=0), np.arange(len(model.roots))]
    model = _Model(model.roots, model.shapes / unit, model.strengths * unit[:, None])
    residual, size = _residual(decays, model), np.abs(model.roots)
    share = sum(float((part**2).sum()) for part in residual) / sum(float((part**2).sum()) for part in decays.values)
    settled = (SETTLED * size.max() * decays.step * max(map(len, decays.values))) ** 2  # residual of the roots at which the method ends
    period = max(1, round(2 * np.pi / (size.min() * decays.step)))
    misfit = _misfit(decays, [part / scale for part in residual], period) if share > settled else 1.0
    return _Fit(model, misfit * _deviations(model.roots, covariance), share, misfit)


def _misfit(decays: _Decays, residual: Sequence[Array], period: int) -> float:
    """Factor on the deviations, more than 1 if the residuals (n, channels) after the hits are more than noise.

    The residual of a wrong model oscillates like the modes, in all channels together, and more before a second blow than after it. So the
    factor is raised if noise alone is too unlikely an explanation: if a frequency has too much energy compared with the frequencies around
    it (Fisher 1929), or if an interval of time has too much.

    Args:
        decays: the free vibrations.
        residual: residuals after each hit, in units of the noise of each channel.
        period: samples in a period of the slowest mode.
    """
    from scipy.ndimage import median_filter  # slow to import
    from scipy.stats import gamma  # slow to import

    channels = residual[0].shape[1]
    highest, odds = 0.0, 1.0
    for part in residual:
        swinging = part - part.mean(axis=0)
        powers = (np.abs(np.fft.rfft(swinging, axis=0)) ** 2).sum(axis=1)[1:] / max(float((swinging**2).mean()) * len(part), 1e-300)
        around = median_filter(powers, 51, mode="reflect") / gamma.median(channels)
        energies = (swinging[: len(part) // period * period] ** 2).reshape(-1, period * channels).sum(axis=1)
        independent = 0.5 * channels * period * around.mean() ** 2 / (around**2).mean()
        odds = min(odds, len(powers) * float(gamma.sf((powers / np.maximum(around, 1e-300)).max(), channels)))
        odds = min(odds, len(energies) * float(gamma.sf(independent * energies.max() / np.median(energies), independent)))
        highest = max(highest, float(powers.max()))
    return max(1.0, float(np.sqrt(highest / decays.colour))) if odds * len(residual) < 1e-4 else 1.0


def _weighted(decays: _Decays, model: _Model, scale: Array, steps: int) -> tuple[_Model, Array, Array]:
    """The best model, the strengths of its modes / their deviations, and the covariance of the unknowns.

    Channels are weighted by their noise ``scale`` (channels,).
    """
    whitened = decays._replace(values=tuple(part / scale for part in decays.values))
    best, covariance = _gauss_newton(whitened, model._replace(shapes=model.shapes / scale[:, None]), steps)
    return best._replace(shapes=best.shapes * scale[:, None]), _distinct(best, covariance), covariance


def _dropped(model: _Model, distinct: Array, wanted: int | None) -> list[int]:
    """Modes that are noise and left out next. Of two close modes only the fainter one, because each makes the other's strength
    uncertain."""
    least = OUT_OF_NOISE if wanted is None else np.inf
    most = len(distinct) - (1 if wanted is None else wanted)
    dropped: list[int] = np.flatnonzero(-model.roots.real > MOST_DAMPED * np.abs(model.roots)).tolist()[:most]
    if dropped:
        return dropped
    for mode in np.argsort(distinct).tolist():
        root, others = model.roots[mode], model.roots[dropped]
        apart = np.abs(root - others) > 3 * np.abs(root.real + others.real)
        if distinct[mode] < least and len(dropped) < most and apart.all():
            dropped.append(mode)
    return dropped


def _separate(decays: _Decays, roots: ComplexArray) -> _Model:
    """A first model: amplitudes by linear least squares, and the nearest product of shape and strength of each mode."""
    amplitudes = []
    for hit, part in enumerate(decays.values):
        waves = decays.waves(hit, roots)
        real, imaginary = np.split(np.linalg.lstsq(np.hstack([waves.real, -waves.imag]), part, rcond=None)[0], 2)
        amplitudes.append(real + 1j * imaginary)
    left, sizes, right = np.linalg.svd(np.moveaxis(np.array(amplitudes), 0, 2), full_matrices=False)  # (modes, channels, hits)
    return _Model(roots, np.asarray(left[:, :, 0].T), np.asarray(sizes[:, :1] * right[:, 0, :]))


def _residual(decays: _Decays, model: _Model) -> list[Array]:
    waves = [decays.waves(hit, model.roots) * model.strengths[:, hit] for hit in range(len(decays.values))]
    return [part - (wave @ model.shapes.T).real for part, wave in zip(decays.values, waves, strict=True)]


def _gauss_newton(decays: _Decays, model: _Model, steps: int) -> tuple[_Model, Array]:
    """The best model after up to ``steps`` steps, and the covariance matrix of its unknowns, in the order of `_equations`."""
    cost = np.inf
    shortened, step, trial = 1.0, np.zeros(0), model
    for _ in range(steps):
        matrix, missed, rest = _equations(decays, trial)
        tried = float(missed @ missed) + rest
        if tried > cost * (1 + 1e-12):
            if shortened < 1e-3:
                break
            shortened *= 0.25
            trial = _moved(model, shortened * step)
            continue
        settled = cost < np.inf and np.abs(trial.roots - model.roots).max() <= SETTLED * np.abs(trial.roots).max()
        model, cost, shortened = trial, min(cost, tried), 1.0
        sizes = np.linalg.norm(matrix, axis=0)
        normal = (matrix / sizes).T @ (matrix / sizes) + 1e-13 * np.eye(len(sizes))  # regularised against rounding errors
        step = np.linalg.solve(normal, (matrix / sizes).T @ missed) / sizes
        if settled:
            break
        trial = _moved(model, step)
    samples = sum(part.size for part in decays.values)
    spread = decays.colour * cost / max(samples - len(sizes), 1)
    return model, spread * np.linalg.inv(normal) / np.outer(sizes, sizes)


def _equations(decays: _Decays, model: _Model) -> tuple[Array, Array, float]:
    """Derivatives of the model by its unknowns, the residual, and the squares that no small change of the roots can reach.

    The first two are coordinates in an orthonormal basis of the waves and of their derivatives by the roots, so they have few rows. The
    unknowns are roots, then shapes without their largest elements, then strengths; mode by mode, each as real and imaginary part.
    """
    channels, modes = model.shapes.shape
    free = _free(model)
    blocks, missed, rest = [], [], 0.0
    for hit, part in enumerate(decays.values):
        waves = decays.waves(hit, model.roots)
        slopes = decays.step * np.arange(len(part))[:, None] * waves
        basis = np.linalg.qr(np.hstack([waves.real, waves.imag, slopes.real, slopes.imag]))[0]
        seen, wave, slope = basis.T @ part, basis.T @ waves, basis.T @ slopes
        rest += float((part**2).sum() - (seen**2).sum())
        strong = wave * model.strengths[:, hit]
        by_root = np.einsum("kj,cj->kcj", slope * model.strengths[:, hit], model.shapes)
        by_shape = np.einsum("kj,cd->kcjd", strong, np.eye(channels))[:, :, free]
        by_strength = np.zeros((len(seen), channels, modes, len(decays.values)), dtype=complex)
        by_strength[:, :, :, hit] = np.einsum("kj,cj->kcj", wave, model.shapes)
        columns = np.concatenate([by_root, by_shape, by_strength.reshape(len(seen), channels, -1)], axis=2).reshape(seen.size, -1)
        blocks.append(np.stack([columns.real, -columns.imag], axis=2).reshape(seen.size, -1))
        missed.append((seen - (strong @ model.shapes.T).real).ravel())
    return np.vstack(blocks), np.concatenate(missed), max(rest, 0.0)


def _free(model: _Model) -> NDArray[np.bool_]:
    """(m, channels) elements of shapes that are unknowns. The largest element of each mode is fixed, because only the product of shape and
    strength is determined."""
    largest = np.abs(model.shapes).argmax(axis=0)
    return np.asarray(np.arange(len(model.shapes)) != largest[:, None])


def _moved(model: _Model, step: Array) -> _Model:
    """The model after a step of its unknowns; its roots are limited so that the vibrations still oscillate and decay."""
    change = step[0::2] + 1j * step[1::2]
    modes, free, shapes = len(model.roots), _free(model), model.shapes.T.copy()
    end = modes + np.count_nonzero(free)
    shapes[free] += change[modes:end]
    roots, size = model.roots + change[:modes], np.abs(model.roots)
    roots = np.minimum(roots.real, -1e-9 * size) + 1j * np.maximum(roots.imag, 1e-3 * size)
    return _Model(roots, shapes.T, model.strengths + change[end:].reshape(modes, -1))


def _distinct(model: _Model, covariance: Array) -> Array:
    """(m,) strengths of each mode / their standard deviations, root mean square over the hits."""
    modes, hits = model.strengths.shape
    unknowns = np.arange(len(covariance) - 2 * hits * modes, len(covariance)).reshape(modes, -1)
    squares = []
    for strengths, own in zip(model.strengths, unknowns, strict=True):
        strength = np.stack([strengths.real, strengths.imag], axis=1).ravel()
        squares.append(strength @ np.linalg.pinv(covariance[np.ix_(own, own)], hermitian=True) @ strength)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0) / (2 * hits)))


def _deviations(roots: ComplexArray, covariance: Array) -> Array:
    """(m, 2) standard deviations of natural frequency [rad/s] and damping ratio."""
    found = []
    for k, root in enumerate(roots):
        size = abs(root)
        by_part = np.array([[root.real, root.imag], [-(root.imag**2) / size**2, root.real * root.imag / size**2]]) / size
        found.append(np.sqrt(np.maximum(np.diag(by_part @ covariance[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] @ by_part.T), 0.0)))
    return np.array(found)


def _energy_share(decays: _Decays, model: _Model) -> Array:
    """(m,) share of each mode in the energy of all modes."""
    decay = np.array([(np.abs(decays.waves(hit, model.roots)) ** 2).sum(axis=0) for hit in range(len(decays.values))])
    energy = (decay.T * np.abs(model.strengths) ** 2).sum(axis=1) * (np.abs(model.shapes) ** 2).sum(axis=0)
    return np.asarray(energy / energy.sum())


def _beside(model: _Model, accelerometers: Mapping[str, Accelerometer], beside: VibrationModes | None) -> tuple[tuple[int, ...], Array]:
    """Number of the calculated mode of each measured one, and the modal assurance criterion of all pairs."""
    if beside is None:
        return (-1,) * len(model.roots), np.zeros((len(model.roots), 0))
    seen = np.array([sensor.row(len(beside.shapes) // 6) for sensor in accelerometers.values()]) @ beside.shapes
    lengths = np.outer(np.linalg.norm(model.shapes, axis=0), np.linalg.norm(seen, axis=0))
    products = np.abs(model.shapes.conj().T @ seen)
    mac = np.divide(products, lengths, out=np.zeros_like(products), where=lengths > 0) ** 2
    apart = np.abs(np.log(np.abs(model.roots)[:, None] / beside.natural_frequency))
    mine, theirs = pair_modes(mac - apart)  # few accelerometers may not distinguish shapes, so frequencies count too
    partner = dict(zip(mine.tolist(), theirs.tolist(), strict=True))
    return tuple(partner.get(k, -1) for k in range(len(model.roots))), mac
