"""The logarithmic decrement of a vibration that dies away, from a signal with noise and other vibrations in it.

Peaks of a measured signal cannot be counted, because noise makes peaks too. The signal is not filtered first: the ringing of the filter
would count as damping. Instead one decaying vibration is fitted to the lines of the signal's spectrum around its strongest one.
The samples a r^k, r = exp(-s + i w), k = 0 ... n - 1, have at the frequency v of a line the spectrum

    a (1 - r^n) / (1 - r exp(-i v)) + its partner for the conjugates of a and r,

which is exact for a signal of any length, so that a signal without noise gives the decrement 2 pi s / w within rounding error. Vibrations
outside the band change slowly over it, and are taken as a straight line.
"""

from __future__ import annotations

import numpy as np

from ..common.arguments import finite_numbers, number, suitable_numbers
from ..common.errors import PinpressError, shown
from ..common.quantities import Array, ComplexArray

HALF_BAND = np.sqrt(2.0)  # the band reaches from the strongest line divided by this to the line times this: an octave
BESIDE = 2  # and this many lines further, for short signals


def logarithmic_decrement(signal: Array, *, rate: float = 1.0, band: tuple[float, float] | None = None) -> float:
    """Logarithmic decrement of a decaying vibration [-].

    The decrement is ln(peak / peak a period later), which is 2 pi z / sqrt(1 - z^2) at a damping ratio z. It is that of the strongest
    vibration of the signal, found in an octave around its frequency; noise and vibrations at other frequencies hardly matter.

    Args:
        signal: (n,) one component of a vibration after its cause has ended, in equal steps of time.
        rate: samples a second, which only gives ``band`` its unit [Hz].
        band: (2,) lowest and highest frequency of the vibration that is meant, without its neighbours; by default an octave around the
            strongest of all [Hz].

    Raises:
        PinpressError: the signal is not an array (n,) of finite numbers, has fewer than two periods of its strongest vibration, or nothing
            that decays stands out of its noise; the band holds no frequency of the signal.
    """
    values = finite_numbers(signal)
    if values is None or values.ndim != 1:
        raise PinpressError("signal is no array (n,) of finite numbers: give one component of a vibration")
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
    # At five standard deviations an amplitude is no noise.
    if certainty < 5.0:
        raise PinpressError(
            f"no vibration that dies away stands out of the noise of the signal around its line {strongest}: give the time after a hit"
            " alone, or the band of the vibration that is meant"
        )
    return float(2 * np.pi * decay / turn)


def _strongest(size: Array, count: int, rate: float, band: tuple[float, float] | None) -> int:
    """Number of the strongest line of a spectrum, which is its periods in the signal; raises PinpressError if it has none."""
    lines = np.arange(len(size))
    within = lines >= 1
    if band is not None:
        wanted = f"lowest and highest frequency, from 0 to half the rate, {rate / 2:g} Hz"
        low, high = suitable_numbers("band", band, wanted, (2,), lambda ends: 0 <= ends[0] < ends[1] <= rate / 2)
        within &= (lines * rate / count >= low) & (lines * rate / count <= high)
        if not within.any():
            raise PinpressError(f"band {shown(band)} holds no line of a signal of {count / rate:g} s: give a wider one, or a longer signal")
    strongest = int(np.where(within, size, 0.0).argmax())
    # A vibration of less than two periods cannot be distinguished from a drift.
    if strongest < 2:
        raise PinpressError("signal is shorter than two periods of its strongest vibration: give two or more")
    return strongest


def _fitted(spectrum: ComplexArray, lines: Array, count: int, strongest: int) -> tuple[float, float, float]:
    """Decay and turn of the vibration by sample, and its amplitude by its standard deviation."""
    from scipy.optimize import least_squares  # slow to import

    around = np.exp(-2j * np.pi * lines / count)
    known = np.concatenate([spectrum.real, spectrum.imag])
    place = (lines - lines.mean()) / len(lines)
    # With ten lines or more, vibrations outside the band count as a straight line instead of a constant.
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

    # The fit starts from several decays over the whole signal, as exponents.
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
