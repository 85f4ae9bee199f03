"""The logarithmic decrement of a vibration that dies away, from a signal with noise and other vibrations.

Peaks of a measured signal cannot be counted, because noise makes peaks too. The signal is not filtered first: the ringing of the filter
would count as damping. Instead one decaying vibration is fitted to the spectral lines around the strongest line of the signal. At the
frequency v of a line, the samples a r^k, r = exp(-s + i w), k = 0 ... n - 1, have the spectrum

    a (1 - r^n) / (1 - r exp(-i v)) + the same term with the conjugates of a and r,

which is exact for a signal of any length. So a signal without noise gives the decrement 2 pi s / w within rounding error. Vibrations
outside the band change slowly within the band and are approximated by a straight line.
"""

from __future__ import annotations

import numpy as np

from ..common.arguments import finite_numbers, number, suitable_numbers
from ..common.errors import PinpressError, shown
from ..common.quantities import Array, ComplexArray

HALF_BAND = np.sqrt(2.0)  # the band is an octave: from the strongest line / HALF_BAND to the strongest line * HALF_BAND
BESIDE = 2  # additional lines at both ends of the band, for short signals


def logarithmic_decrement(signal: Array, *, rate: float = 1.0, band: tuple[float, float] | None = None) -> float:
    """Logarithmic decrement of a decaying vibration [-].

    The decrement is ln(peak / peak a period later), which is 2 pi z / sqrt(1 - z^2) at a damping ratio z. The result is the decrement of
    the signal's strongest vibration, fitted within an octave around its frequency. Noise and vibrations at other frequencies have little
    effect.

    Args:
        signal: (n,) one component of a vibration after its cause has ended, in equal steps of time.
        rate: samples per second; it only defines the unit of ``band`` [Hz].
        band: (2,) lowest and highest frequency of the wanted vibration, without its neighbours; by default an octave around the strongest
            vibration [Hz].

    Raises:
        PinpressError: the signal is not an array (n,) of finite numbers, has fewer than two periods of its strongest vibration, or has no
            decaying vibration above the noise; or the band has no frequency of the signal.
    """
    values = finite_numbers(signal)
    if values is None or values.ndim != 1:
        raise PinpressError("signal is not an array (n,) of finite numbers: give one component of a vibration")
    if len(values) < 8 or not np.ptp(values):
        raise PinpressError(f"signal of {len(values)} samples does not swing: give a vibration of two periods or more")
    swinging = values / np.abs(values).max()
    spectrum = np.fft.rfft(swinging - swinging.mean())
    rate = number("rate", rate, "Hz", positive=True)
    strongest = _strongest(np.abs(spectrum), len(values), rate, band)
    around = (strongest / HALF_BAND, strongest * HALF_BAND) if band is None else tuple(np.multiply(band, len(values) / rate))
    low = max(1, int(around[0]) - BESIDE)
    high = min(len(spectrum) - 1, int(np.ceil(around[1])) + BESIDE)
    lines = np.arange(low, high + 1.0)
    decay, turn, certainty = _fitted(spectrum[low : high + 1], lines, len(values), strongest)
    # an amplitude above five standard deviations is not noise
    if certainty < 5.0:
        raise PinpressError(
            f"no vibration that dies away stands out of the noise of the signal around its line {strongest}: give the time after a hit"
            " alone, or give the band of the wanted vibration"
        )
    return float(2 * np.pi * decay / turn)


def _strongest(size: Array, count: int, rate: float, band: tuple[float, float] | None) -> int:
    """Number of the strongest line of a spectrum (its periods within the signal); raises PinpressError if there is no such line."""
    lines = np.arange(len(size))
    within = lines >= 1
    if band is not None:
        wanted = f"lowest and highest frequency, from 0 to half the rate, {rate / 2:g} Hz"
        low, high = suitable_numbers("band", band, wanted, (2,), lambda ends: 0 <= ends[0] < ends[1] <= rate / 2)
        within &= (lines * rate / count >= low) & (lines * rate / count <= high)
        if not within.any():
            raise PinpressError(f"band {shown(band)} holds no line of a signal of {count / rate:g} s: give a wider one, or a longer signal")
    strongest = int(np.where(within, size, 0.0).argmax())
    # a vibration of less than two periods cannot be distinguished from a drift
    if strongest < 2:
        raise PinpressError("signal is shorter than two periods of its strongest vibration: give two or more")
    return strongest


def _fitted(spectrum: ComplexArray, lines: Array, count: int, strongest: int) -> tuple[float, float, float]:
    """Decay and phase advance of the vibration per sample, and its amplitude / standard deviation of the amplitude."""
    from scipy.optimize import least_squares  # slow to import

    around = np.exp(-2j * np.pi * lines / count)
    known = np.concatenate([spectrum.real, spectrum.imag])
    place = (lines - lines.mean()) / len(lines)
    # with ten lines or more, vibrations outside the band are approximated by a straight line instead of a constant
    outside = [1.0 + 0 * place, place] if len(lines) >= 10 else []

    def columns(unknown: Array) -> Array:
        root = np.exp((-unknown[0] + 1j * unknown[1]) / count)
        line = (1 - root**count) / (1 - root * around)
        partner = (1 - root.conj() ** count) / (1 - root.conj() * around)
        complex_columns = [line + partner, 1j * (line - partner), *(part * each for each in outside for part in (1.0 + 0j, 1j))]
        return np.array([np.concatenate([column.real, column.imag]) for column in complex_columns]).T

    def missed(unknown: Array) -> Array:
        matrix = columns(unknown)
        return np.asarray(matrix @ np.linalg.lstsq(matrix, known, rcond=None)[0] - known)

    # the fit starts from several decay exponents over the whole signal
    trials = [
        least_squares(
            missed, [start, 2 * np.pi * strongest], bounds=([-10.0, 0.0], [np.inf, np.pi * count]), xtol=1e-14, ftol=1e-14, gtol=1e-14
        )
        for start in (0.3, 1.0, 3.0, 10.0, 30.0)
    ]
    best = min(trials, key=lambda trial: trial.cost)
    matrix = columns(best.x)
    amplitude = np.linalg.lstsq(matrix, known, rcond=None)[0]
    free = max(1, len(known) - matrix.shape[1] - 2)
    deviation = np.sqrt(2 * best.cost / free * np.diag(np.linalg.pinv(matrix.T @ matrix))[:2].sum())
    certainty = np.linalg.norm(amplitude[:2]) / max(deviation, np.finfo(float).tiny)
    return best.x[0] / count, best.x[1] / count, float(certainty)
