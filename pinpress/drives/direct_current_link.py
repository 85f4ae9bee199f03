"""The direct-current link between the mains and a servo drive: a capacitor of finite size, a rectifier and a brake resistor.

The rectifier gives power and takes none back. It charges the capacitor with all that the mains may give until the charged voltage is
reached, and holds that as long as the drive takes no more than the mains may give. What the drive takes beyond comes out of the capacitor,
and what braking gives back goes into it, up to the upper voltage; there the resistor burns it. With the energy E = C U² / 2, the power p of
the drive and the limit P of the mains

    dE/dt = P - p  below the charged voltage,  0 at it while 0 <= p <= P,  -p above it,  0 at the upper voltage while p < 0.

The power is a polynomial between instants and is cut where it passes 0 and P, so that the energy is monotone on every piece and the
instants at which the law changes are roots of polynomials: none is stepped over, and the balance of energy closes within
rounding error.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import number, numbers
from ..common.errors import PinpressError
from ..common.numerics import gauss_rule, horner, polynomial_root, sign_change
from ..common.parameters import Checked, parameter
from ..common.quantities import Array

SETTLED = 1e-14  # share of the energy that goes through the link up to which it may differ at both ends of a stroke that repeats


@dataclass(frozen=True, eq=False)
class DirectCurrentLink(Checked):
    """The direct-current link of a servo drive: a capacitor on a rectifier that feeds nothing back, and a brake resistor.

    Attributes:
        capacitance: of the capacitor [F].
        lower_voltage: below which the drive cannot work [V].
        charged_voltage: to which the mains charge the capacitor, and which they hold [V]; not below the lower one.
        upper_voltage: at which the brake resistor is switched on [V]; above the lower one, not below the charged one.
        mains_power: largest power from the mains [W]; None: no limit, and the voltage never falls below the charged one.

    Raises:
        PinpressError: a number is not positive, the voltages do not rise, or the energy is too large for floating point.
    """

    capacitance: float = field(metadata=parameter("F", "positive"))
    lower_voltage: float = field(metadata=parameter("V", "positive"))
    charged_voltage: float = field(metadata=parameter("V", "positive"))
    upper_voltage: float = field(metadata=parameter("V", "positive"))
    mains_power: float | None = field(default=None, metadata=parameter("W", "positive"))

    def __post_init__(self) -> None:
        super().__post_init__()
        lower, charged, upper = self.lower_voltage, self.charged_voltage, self.upper_voltage
        if not lower <= charged <= upper or not lower < upper:
            raise PinpressError(
                f"DirectCurrentLink: lower_voltage is {lower:g}, charged_voltage {charged:g} and upper_voltage {upper:g} V;"
                " give them rising [V]"
            )
        span = self.energy_at(upper) - self.energy_at(lower)
        if not 0 < span < math.inf:
            raise PinpressError(f"DirectCurrentLink: capacitance is {self.capacitance:g}; give that of the link in F, such as 0.05")

    def energy_at(self, voltage: float) -> float:
        """Energy at a voltage less that at the charged one [J]; raises PinpressError where the voltage is no finite number."""
        volts = number("voltage", voltage, "V")
        return 0.5 * self.capacitance * (volts - self.charged_voltage) * (volts + self.charged_voltage)

    def voltage_at(self, energy: ArrayLike) -> Array:
        """Voltages at energies of any shape less that at the charged voltage, not below the lower one [V].

        Raises:
            PinpressError: an energy is no finite number.
        """
        energies = numbers("energy", energy, unit="J")
        return np.sqrt(np.maximum(self.charged_voltage**2 + 2.0 * energies / self.capacitance, self.lower_voltage**2))


class Feeding(IntEnum):
    """How a link is fed."""

    AT_LIMIT = 0
    """The mains give all that they may."""
    NOT = 1
    """The mains give nothing."""
    HELD = 2
    """The mains give what the drive takes."""
    BURNT = 3
    """The resistor burns what braking gives back."""


AT_LIMIT, NOT, HELD, BURNT = Feeding


class Course(NamedTuple):
    """The energy of a link over time, at m + 1 instants between which it is fed in one way.

    Attributes:
        times: (m + 1,) [s].
        energy: (m + 1,) less that at the charged voltage [J].
        mains: (m + 1,) work from the mains since the start [J].
        burnt: (m + 1,) work burnt in the resistor since the start [J].
        feeding: (m,) how it is fed between the instants, each a `Feeding`.
    """

    times: Array
    energy: Array
    mains: Array
    burnt: Array
    feeding: Array

    def powers(self, link: DirectCurrentLink, times: Array, taken: Array) -> tuple[Array, Array]:
        """Powers (n,) from the mains and into the resistor at times (n,), at which a power (n,) is taken from the link [W]."""
        fed = self.feeding[np.minimum(np.searchsorted(self.times, times, side="right") - 1, len(self.feeding) - 1)]
        following = np.clip(taken, 0.0, link.mains_power)
        mains = np.select([fed == AT_LIMIT, fed == HELD], [0.0 if link.mains_power is None else link.mains_power, following], 0.0)
        return mains, np.where(fed == BURNT, np.maximum(-taken, 0.0), 0.0)

    def works(self, times: Array) -> tuple[Array, Array, Array]:
        """Works (n,) from the mains and into the resistor since the start, and energy (n,), at times (n,) of this course [J]."""
        place = np.searchsorted(self.times, times)
        return self.mains[place], self.burnt[place], self.energy[place]


class _Piece(NamedTuple):
    """Part of an interval over which the power stays on one side of 0 and of what the mains may give.

    Attributes:
        start: of the interval [s].
        finish: of the interval [s].
        half: of its duration [s].
        work: coefficients of rising powers of x, which goes from -1 to 1 over the interval, of the work that the drive takes [J].
        low: x at the start of the part.
        high: x at its end.
        side: -1 where the drive brakes, 1 where it takes more than the mains may give, else 0.
    """

    start: float
    finish: float
    half: float
    work: list[float]
    low: float
    high: float
    side: int

    def time(self, x: float) -> float:
        return self.finish if x == 1.0 else self.start + self.half * (x + 1.0)

    def taken(self, x: float) -> float:
        """Work that the drive has taken since the start of the interval [J]."""
        return horner(self.work[::-1], x)


@dataclass(frozen=True, eq=False)
class LinkedPower:
    """A power that is taken from a link.

    Attributes:
        link: the link.
        edges: (n + 1,) instants between which the power is smooth [s].
        power: (n, q) at the nodes of `gauss_rule` between them; negative where the drive brakes [W].
    """

    link: DirectCurrentLink
    edges: Array
    power: Array

    def course(self, energy: float) -> Course:
        """The course from an energy less that at the charged voltage [J]. It goes on below the lower voltage, without end."""
        state = (float(self.edges[0]), energy, 0.0, 0.0)
        states, feeding = [state], list[Feeding]()
        for piece in self._pieces:
            x = piece.low
            while x < piece.high:
                fed, x, state = self._stage(piece, x, *state)
                feeding.append(fed)
                states.append(state)
        times, energies, mains, burnt = np.array(states).T
        return Course(times, energies, mains, burnt, np.array(feeding))

    def settled(self) -> float | None:
        """Energy at which a stroke begins and ends that has been repeated for good, less that at the charged voltage [J].

        The energy at the end never falls with that at the start, and rises by no more than it. None: the mains give too little.
        """
        through = float(0.5 * np.diff(self.edges) @ (np.abs(self.power) @ gauss_rule().weights))

        def gained(energy: float) -> float:
            return float(self.course(energy).energy[-1]) - energy

        once = float(self.course(0.0).energy[-1])
        if abs(gained(once)) <= SETTLED * through:  # mostly one stroke forgets how it began
            return once
        full, rounding = self._full, SETTLED * max(through, self._full)
        if self.link.mains_power is None:
            return sign_change(gained, 0.0, full, rounding)
        empty = -through - self.link.mains_power * float(self.edges[-1] - self.edges[0])  # too low to come back to the charged voltage
        if gained(empty) < 0:
            return None
        return sign_change(gained, empty, full, rounding)

    def _stage(
        self, piece: _Piece, x: float, time: float, energy: float, mains: float, burnt: float
    ) -> tuple[Feeding, float, tuple[float, float, float, float]]:
        """How the link is fed from a place of a piece on, the place up to which it is, and time, energy and works there."""
        fed, target = self._feeding(energy, piece.side)
        # power from the mains that does not follow the power of the drive [W]
        from_mains = self.link.mains_power if fed is AT_LIMIT and self.link.mains_power is not None else 0.0
        end = piece.high
        before = piece.taken(x)
        if fed in (HELD, BURNT):
            work = piece.taken(end) - before
            mains, burnt = (mains + work, burnt) if fed is HELD else (mains, burnt - work)
            return fed, end, (piece.time(end), energy, mains, burnt)
        after = energy + from_mains * piece.half * (end - x) - (piece.taken(end) - before)
        after = min(after, max(energy, self._full))  # on a piece of rounding's length the sign of the power is rounding too
        if target is not None and (after >= target) == (energy < target):
            missing = [-coefficient for coefficient in piece.work]
            missing[0] += energy + before - target - from_mains * piece.half * x
            missing[1] += from_mains * piece.half
            reached = (horner(missing[::-1], x) > 0) != (energy > target)  # so near that it is rounding
            end, after = x if reached else polynomial_root(missing, x, end), target
        mains += from_mains * piece.half * (end - x)
        return fed, end, (piece.time(end), after, mains, burnt)

    def _feeding(self, energy: float, side: int) -> tuple[Feeding, float | None]:
        """How the link is fed at an energy, and the energy at which that ends."""
        if energy < 0:
            return AT_LIMIT, None if side > 0 else 0.0
        if side < 0:
            return (NOT, self._full) if energy < self._full else (BURNT, None)
        if energy > 0:
            return NOT, 0.0
        return (AT_LIMIT, None) if side > 0 else (HELD, None)

    @cached_property
    def _full(self) -> float:
        return self.link.energy_at(self.link.upper_voltage)

    @cached_property
    def _pieces(self) -> list[_Piece]:
        rule, limit = gauss_rule(), self.link.mains_power
        half = 0.5 * np.diff(self.edges)
        work = (rule.integral(self.power.T) * half).T
        pieces = []
        ends = zip(self.edges[:-1].tolist(), self.edges[1:].tolist(), half.tolist(), strict=True)
        for interval, values, integral in zip(ends, self.power, work.tolist(), strict=True):
            cuts, series = {-1.0, 1.0}, rule.legendre @ values
            for level in (0.0,) if limit is None else (0.0, limit):
                cuts |= set(_crossings(series, level))
            for low, high in itertools.pairwise(sorted(cuts)):
                inside = np.polynomial.legendre.legval(0.5 * (low + high), series)
                side = -1 if inside < 0 else int(limit is not None and inside > limit)
                pieces.append(_Piece(*interval, integral, low, high, side))
        return pieces


def _crossings(series: Array, level: float) -> list[float]:
    """Places between -1 and 1 at which a Legendre series passes or touches a level."""
    series = series.copy()
    series[0] -= level
    if abs(series[0]) > np.abs(series[1:]).sum():  # the level is out of reach
        return []
    roots = np.polynomial.legendre.legroots(series)
    # A double root, where the power touches a limit, has a small imaginary part by rounding.
    return [float(root.real) for root in roots if abs(root.imag) < 1e-9 and -1 < root.real < 1]
