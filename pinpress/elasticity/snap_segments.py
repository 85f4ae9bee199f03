"""A mass on a spring with a clearance, let go by a force that falls linearly: its motion in closed form, stretch by stretch.

Symbols and equation: see `breakthrough`.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..common.arrays import Array
from ..common.errors import PinpressError

STEPS = 32  # into which half a period is divided to look for what happens in it
PERIODS = 6  # that are shown after the force is gone
CALM = 1e-24  # of the elastic energy: what is left is rounding
TOUCHING = 1e-13  # of the deflection F / k: what is beyond an edge by less is on it
MOST = 20_000  # stretches of half a period


class Release(NamedTuple):
    """F [N], k [N/m], m [kg], zeta, tau [s], g [m]."""

    force: float
    stiffness: float
    mass: float
    damping_ratio: float
    break_time: float
    clearance: float

    @property
    def frequency(self) -> float:
        """Without damping and clearance [rad/s]."""
        return math.sqrt(self.stiffness / self.mass)


@dataclass(frozen=True)
class Stretch:
    """Closed form over a time s from its start: in touch with the spring, which is slack at ``slack``, or in free flight (None). The
    force is a + b s; x, v at s = 0."""

    case: Release
    start: float
    x: float
    v: float
    a: float
    b: float
    slack: float | None

    @property
    def _wave(self) -> tuple[float, float, float, float]:
        """Decay, damped frequency, and the amplitudes of cosine and sine."""
        case = self.case
        decay = case.damping_ratio * case.frequency
        damped = case.frequency * math.sqrt(1 - case.damping_ratio**2)
        at, rate = self._carried(0.0)
        y, w = self.x - at, self.v - rate
        return decay, damped, y, (w + decay * y) / damped

    def _carried(self, s: Any) -> tuple[Any, float]:
        """The particular solution, and its rate."""
        case = self.case
        assert self.slack is not None
        rate = self.b / case.stiffness
        return self.slack + (self.a + self.b * s) / case.stiffness - 2 * case.damping_ratio / case.frequency * rate, rate

    def at(self, s: Any) -> Array:
        """x and v, (2,) or (2, n)."""
        if self.slack is None:
            m = self.case.mass
            x = self.x + s * (self.v + s * (self.a / 2 + s * self.b / 6) / m)
            return np.array([x, self.v + s * (self.a + s * self.b / 2) / m])
        decay, damped, c, d = self._wave
        cos, sin, fade = np.cos(damped * s), np.sin(damped * s), np.exp(-decay * s)
        carried, rate = self._carried(s)
        return np.array(
            [carried + fade * (c * cos + d * sin), rate + fade * ((damped * d - decay * c) * cos - (damped * c + decay * d) * sin)]
        )

    def pressed(self, span: float) -> float:
        """For how long within the span x is positive whatever the phase of the vibration, in touch with a spring that is slack at 0."""
        from scipy.optimize import brentq

        decay, _, c, d = self._wave

        def least(s: float) -> float:  # concave, so that it is positive up to a time, or to the end
            return float(self._carried(s)[0] - math.hypot(c, d) * math.exp(-decay * s))

        return span if least(span) > 0.0 else float(brentq(least, 0.0, span)) if least(0.0) > 0.0 else 0.0

    def acceleration(self, s: float) -> float:
        """x'' [m/s2]."""
        if self.slack is None:
            return (self.a + self.b * s) / self.case.mass
        case = self.case
        x, v = self.at(s)
        return float((self.a + self.b * s - case.stiffness * (x - self.slack)) / case.mass - 2 * case.damping_ratio * case.frequency * v)

    def jerk_zeros(self, span: float) -> list[float]:
        """Times within the span at which the acceleration is extreme."""
        if self.slack is None:
            return []
        decay, damped, c, d = self._wave
        rate = complex(-decay, damped)  # x - carried is the real part of (c - i d) exp(rate s)
        phase = np.angle(rate**3 * complex(c, -d))
        first = (0.5 * np.pi - phase) % np.pi / damped
        return [float(s) for s in np.arange(first, span, np.pi / damped)]


def stretches(case: Release, pressed: bool = True) -> Iterator[tuple[Stretch, float]]:
    """Stretches of at most half a period and how long they last, until the force is gone, the slide has turned round below and `PERIODS`
    are over; ``pressed``: from the start, or not before the slide might leave the spring, which most of a slow drop is before."""
    period = 2 * np.pi / case.frequency
    end, t, turned = case.break_time + PERIODS * period, 0.0, False
    x, v = case.force / case.stiffness, 0.0
    side = 1  # 1: pressed, 0: in flight, -1: pulled
    slope = -case.force / case.break_time if case.break_time else 0.0
    if not pressed and case.break_time:
        first = Stretch(case, 0.0, x, v, case.force, slope, 0.0)
        t = 0.5 * period * max(0, int(first.pressed(case.break_time) / (0.5 * period)) - 1)  # one fewer, far from rounding
        x, v = (float(number) for number in first.at(t))
    for _ in range(MOST):
        dropping = t < case.break_time
        a = case.force * (1 - t / case.break_time) if dropping else 0.0
        stretch = Stretch(case, t, x, v, a, slope if dropping else 0.0, None if side == 0 else (0.0 if side > 0 else -case.clearance))
        span = min(period / 2, case.break_time - t) if dropping else period / 2
        if side == 0 and not dropping:
            if case.mass * v * v <= CALM * case.force**2 / case.stiffness:
                yield stretch, max(end - t, 0.0)
                return
            edge = -case.clearance if v < 0.0 else 0.0
            left: tuple[float, float, int] | None = ((edge - x) / v, edge, -1 if v < 0.0 else 1)
        else:
            left = _leaving(stretch, span, side)
        span = span if left is None else left[0]
        yield stretch, span
        if not dropping and (side < 0 or case.clearance == 0.0):
            turned = turned or any(stretch.at(s)[0] < -case.clearance for s in turning(stretch, span))
        dropped = dropping and left is None and span == case.break_time - t
        t = case.break_time if dropped else t + span
        x, v = (float(number) for number in stretch.at(span))
        if left is not None:
            x, side = left[1], left[2]
        quiet = not dropping and 0.5 * case.mass * v * v + 0.5 * case.stiffness * x * x <= CALM * case.force**2 / case.stiffness
        if t >= end and (turned or quiet):
            return
    raise PinpressError(f"the slide does not come to rest or to reverse load within {MOST} half periods: check clearance and damping")


def _leaving(stretch: Stretch, span: float, side: int) -> tuple[float, float, int] | None:
    """When within the span the slide leaves its side of the clearance, at which x, to which side; None: it does not."""
    from scipy.optimize import brentq

    gap = stretch.case.clearance
    if gap == 0.0:
        return None
    edges = {1: [(0.0, -1, 0)], 0: [(0.0, 1, 1), (-gap, -1, -1)], -1: [(-gap, 1, 0)]}[side]  # x, direction of leaving, next side
    times = np.union1d(np.linspace(0.0, span, STEPS + 1), turning(stretch, span))
    places = stretch.at(times)[0]
    places[0] = stretch.x
    for i in range(1, len(times)):
        for edge, way, after in edges:
            if way * (places[i] - edge) > TOUCHING * stretch.case.force / stretch.case.stiffness:
                begin = times[i - 1]
                if way * (places[i - 1] - edge) >= 0.0:  # on the edge already
                    return float(begin), edge, after
                found = brentq(lambda s, edge=edge: float(stretch.at(s)[0]) - edge, begin, times[i], xtol=1e-300, rtol=1e-15)
                return float(found), edge, after
    return None


def turning(stretch: Stretch, span: float) -> list[float]:
    """Times within the span at which the slide turns round."""
    from scipy.optimize import brentq

    times = np.linspace(0.0, span, STEPS + 1)
    speeds = stretch.at(times)[1]
    signs = np.flatnonzero(speeds[:-1] * speeds[1:] < 0.0)
    return [float(brentq(lambda s: float(stretch.at(s)[1]), times[i], times[i + 1], xtol=1e-300, rtol=1e-15)) for i in signs]
