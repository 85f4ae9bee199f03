"""Motion laws of VDI 2143 from rest to rest: a stroke of 1 in a time of 1, exact in position, speed and acceleration."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property

import numpy as np
from numpy.typing import ArrayLike

from .arguments import suitable_numbers
from .errors import UnknownNameError
from .quantities import Array
from .results import Record

GAUSS = 24  # points for the integral of a squared acceleration over a piece: exact for polynomials, and for sines within rounding error


@dataclass(frozen=True)
class _Piece:
    """Acceleration over a part of the time, as a share of the largest: a polynomial or a sine of the time since the start of the part."""

    duration: float
    polynomial: tuple[float, ...] = (0.0,)
    frequency: float = 0.0
    phase: float = 0.0

    @cached_property
    def _polynomials(self) -> tuple[np.polynomial.Polynomial, ...]:
        """Position, speed and acceleration."""
        acceleration = np.polynomial.Polynomial(self.polynomial)
        return acceleration.integ(2), acceleration.integ(), acceleration

    def gains(self, time: Array) -> tuple[Array, Array, Array]:
        """Changes of position (from rest) and of speed since the start of the piece, and the acceleration, at times since this start."""
        if not self.frequency:
            position, speed, acceleration = (polynomial(time) for polynomial in self._polynomials)
            return position, speed, acceleration
        angle, rate, first = self.frequency * time + self.phase, 1 / self.frequency, math.cos(self.phase)
        position = rate * (first * time - rate * (np.sin(angle) - math.sin(self.phase)))
        return position, rate * (first - np.cos(angle)), np.sin(angle)


@dataclass(frozen=True, repr=False)
class MotionLaw(Record):
    """A motion from rest to rest over a stroke of 1 in a time of 1, symmetric about its middle.

    Over a stroke L in a time T, speeds are larger by the factor L/T, and accelerations by the factor L/T^2.

    Attributes:
        name: name of the law in VDI 2143.
        peak_speed: largest speed, the coefficient Cv [-].
        peak_acceleration: largest acceleration, the coefficient Ca [-].
        heat: integral of the squared acceleration over the time [-]. A motor that turns an inertia J by an angle L in a time T has the
            integral of squared torque heat J^2 L^2/T^3 [N2 m2 s]. The least heat of all motions is 12, that of the cubic.
    """

    name: str
    peak_speed: float
    peak_acceleration: float
    heat: float
    _first_half: tuple[_Piece, ...] = field(repr=False)

    def position(self, time: ArrayLike) -> Array:
        """Position at times from 0 to 1, arrays of any shape [-]; raises `PinpressError` for times outside."""
        return self.values(time)[0]

    def speed(self, time: ArrayLike) -> Array:
        """Speed at times from 0 to 1, arrays of any shape [-]; raises `PinpressError` for times outside."""
        return self.values(time)[1]

    def acceleration(self, time: ArrayLike) -> Array:
        """Acceleration at times from 0 to 1, arrays of any shape [-]; raises `PinpressError` for times outside.

        At a jump in the first half this is the value before the jump. At time 0 and in the second half it is the value after the jump.
        """
        return self.values(time)[2]

    @property
    def corners(self) -> tuple[float, ...]:
        """Times between 0 and 1 at which the formula of the acceleration changes [-]."""
        first = np.cumsum([piece.duration for piece in self._first_half]).tolist()
        return (*first, *(1.0 - time for time in reversed(first[:-1])))

    def values(self, time: ArrayLike) -> tuple[Array, Array, Array]:
        """Position, speed and acceleration, as of the methods with these names."""
        times = suitable_numbers("time", time, "times from 0 to 1, as shares of the whole", None, lambda t: (t >= 0) & (t <= 1))
        late = times > 0.5
        position, speed, acceleration = _half(self._first_half, np.where(late, 1 - times, times))
        position, acceleration = self.peak_acceleration * position, self.peak_acceleration * acceleration
        return np.where(late, 1 - position, position), self.peak_acceleration * speed, np.where(late, -acceleration, acceleration)


def vdi_law(name: str) -> MotionLaw:
    """The motion law of VDI 2143 with a name.

    | name | Cv | Ca | heat | acceleration |
    |---|---|---|---|---|
    | cubic | 1.5 | 6 | 12 | falls evenly; it jumps at both ends |
    | trapezoid | 1.5 | 4.5 | 13.5 | constant, zero, constant: each for a third of the time |
    | modified sine | 1.760 | 5.528 | 15.28 | sines; between the first and the last eighth of the time the frequency is a third |
    | 3-4-5 | 1.875 | 5.774 | 17.14 | a polynomial, without a jump |
    | modified trapezoid | 2 | 4.888 | 17.92 | a trapezoid rounded by sines |
    | Bestehorn | 2 | 6.283 | 19.74 | a sine: the motion is a cycloid |

    Args:
        name: one of these names, or "sine" for Bestehorn's law.

    Raises:
        UnknownNameError: no law has this name.
    """
    if not isinstance(name, str) or name not in (*_ACCELERATIONS, SINE):
        raise UnknownNameError("motion law", name, _ACCELERATIONS)
    return _law("Bestehorn" if name == SINE else name)


@cache
def _law(name: str) -> MotionLaw:
    half = _ACCELERATIONS[name]
    position, speed, _ = _half(half, np.array(0.5))
    largest = 0.5 / float(position)
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS)
    squares = [0.5 * piece.duration * weights @ piece.gains(0.5 * piece.duration * (1 + nodes))[2] ** 2 for piece in half]
    return MotionLaw(name, largest * float(speed), largest, 2 * largest**2 * float(sum(squares)), half)


def _half(pieces: tuple[_Piece, ...], time: Array) -> tuple[Array, Array, Array]:
    """Position, speed and acceleration at times from 0 to 0.5, for a largest acceleration of 1."""
    position, speed, acceleration = (np.zeros_like(time) for _ in range(3))
    for piece, start in zip(pieces, np.cumsum([0.0, *(each.duration for each in pieces[:-1])]), strict=True):
        since = np.clip(time - start, 0.0, piece.duration)
        moved, gained, now = piece.gains(since)
        # after the end of a piece, its gain of speed remains
        position += moved + gained * np.maximum(time - start - since, 0.0)
        speed += gained
        acceleration = np.where((time > start) | (start == 0.0), now, acceleration)
    return position, speed, acceleration


_QUARTER = 0.5 * math.pi
_ACCELERATIONS: Mapping[str, tuple[_Piece, ...]] = {  # in the first half of the time
    "cubic": (_Piece(1 / 2, (1.0, -2.0)),),
    "trapezoid": (_Piece(1 / 3, (1.0,)), _Piece(1 / 6)),
    "modified sine": (_Piece(1 / 8, frequency=4 * math.pi), _Piece(3 / 8, frequency=4 * math.pi / 3, phase=_QUARTER)),
    "3-4-5": (_Piece(1 / 2, (0.0, 6 * math.sqrt(3), -18 * math.sqrt(3), 12 * math.sqrt(3))),),
    "modified trapezoid": (
        _Piece(1 / 8, frequency=4 * math.pi),
        _Piece(1 / 4, (1.0,)),
        _Piece(1 / 8, frequency=4 * math.pi, phase=_QUARTER),
    ),
    "Bestehorn": (_Piece(1 / 2, frequency=2 * math.pi),),
}
VDI_LAWS = tuple(_ACCELERATIONS)
SINE = "sine"  # another name of Bestehorn's law
