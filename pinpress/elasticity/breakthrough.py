"""Snap-through after break-through in blanking: the press, loaded and sprung, is let go and swings through into reverse load.

The slide, of effective mass m, hangs on the spring k of the press with the damping ratio zeta. Its displacement x counts along the guide's
axis (upwards) from where it would be without force. A force F on the slide holds it at F / k; as the blank breaks it falls linearly to
zero within a break-through time tau, or at once. Then m x'' + c x' + k x = F(t), x(0) = F / k, x'(0) = 0, c = 2 zeta sqrt(k m). While x < 0
the linkage is pulled: k |x| is its reverse load, and |x| the overshoot of the slide, by which the punch goes too deep. The slide's weight
is taken for balanced, the crank for held, its travel within the snap for small.

With a clearance g in the bearings the spring is in touch for x > 0 and for x < -g; between them the slide flies freely, and is damped no
more. Every segment is solved in closed form; where it ends is found to rounding.

Closed forms, without clearance: at once, reverse load F exp(-zeta pi / sqrt(1 - zeta^2)); within tau, undamped,
F |sin(w tau / 2) / (w tau / 2)|, w = sqrt(k / m) (a linear drop of force on a linear oscillator; any textbook of vibrations).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import number, numbers, positive
from ..common.errors import PinpressError
from ..common.frozen import read_only
from ..common.quantities import Array
from ..common.results import Tabular

WEAKEST = 1e-6  # ratio of reverse load and force, below which no force counts as permitted
GROWTH = 1.05  # of the force, in the search for one with clearance
AT_ONCE = 1e-9  # w tau: the reverse load differs by (w tau)^2 / 24
NO_CLEARANCE = 1e-13  # of the deflection F / k
LONGEST = 1e3  # periods that a break-through may take
STEPS = 32  # into which half a period is divided to look for what happens in it
PERIODS = 6  # that are shown after the force is gone
CALM = 1e-24  # of the elastic energy: what is left is rounding
TOUCHING = 1e-13  # of the deflection F / k: what is beyond an edge by less is on it
MOST = 20_000  # segments of half a period


@dataclass(frozen=True, eq=False, repr=False)
class SnapThroughResponse(Tabular):
    """Response of the slide and the sprung press to break-through. All arrays are read-only.

    Attributes:
        force: F, at break-through [N].
        stiffness: k, of the press [N/m].
        mass: m, of the slide and what yields with it [kg].
        damping_ratio: zeta [-].
        break_time: tau, in which the force falls to zero [s].
        clearance: g, of the bearings together [m].
        energy: F^2 / (2 k), elastic energy stored at break-through [J].
        reverse_force: largest pull of the spring k |x| [N].
        overshoot: of the slide beyond its unloaded position, clearance included [m].
        peak_acceleration: largest magnitude [m/s2].
        frequency: of the vibration after it, w sqrt(1 - zeta^2) [rad/s]; without the flights through a clearance, which slow it.
        time: (n,) in unequal steps, closest where segments meet [s].
        displacement: (n,) x [m].
        velocity: (n,) x' [m/s].
        spring_force: (n,) of the spring on the linkage, positive where it is pressed [N].
    """

    force: float
    stiffness: float
    mass: float
    damping_ratio: float
    break_time: float
    clearance: float
    energy: float
    reverse_force: float
    overshoot: float
    peak_acceleration: float
    frequency: float
    time: Array
    displacement: Array
    velocity: Array
    spring_force: Array

    @property
    def reverse_ratio(self) -> float:
        """Reverse load beside the force at break-through [-]."""
        return self.reverse_force / self.force

    @property
    def title(self) -> str:
        return f"SnapThroughResponse: reverse load {self.reverse_force:.4g} N after {self.force:.4g} N"

    def __str__(self) -> str:
        return (
            f"break-through at {1e-3 * self.force:.5g} kN: reverse load {1e-3 * self.reverse_force:.5g} kN"
            f" ({100 * self.reverse_ratio:.4g} %), overshoot {1e3 * self.overshoot:.4g} mm, peak acceleration"
            f" {self.peak_acceleration:.4g} m/s2, {self.frequency / (2 * np.pi):.4g} Hz after it, stored energy {self.energy:.4g} J"
        )

    def columns(self) -> dict[str, Array]:
        """The response as (n,) columns under their names with units."""
        return {
            "time [s]": self.time,
            "displacement [m]": self.displacement,
            "velocity [m/s]": self.velocity,
            "spring_force [N]": self.spring_force,
        }


def snap_through(
    force: float, stiffness: float, mass: float, *, damping_ratio: float = 0.0, break_time: float = 0.0, clearance: float = 0.0
) -> SnapThroughResponse:
    """Reverse load, overshoot and vibration of a press after break-through.

    Args:
        force: of blanking as the blank breaks through [N].
        stiffness: of the press at that height, 1 / `SlideCompliance.compliance` [N/m].
        mass: of the slide and what yields with it, with the upper die: `SlideCompliance.effective_mass` and the die's [kg].
        damping_ratio: zeta, from 0 to below 1 [-].
        break_time: in which the force falls to zero [s].
        clearance: of the bearings in the line of force, together [m].

    Raises:
        PinpressError: an argument out of range, a break-through longer than 1000 periods.
    """
    case = _case(force, stiffness, mass, damping_ratio, break_time, clearance)
    parts = list(segments(_resolved(case)))
    lowest, overload = _lowest(parts), 0.0
    time, displacement, velocity = [], [], []
    for segment, span in parts:
        inside = np.linspace(0.0, span, STEPS + 1)
        if span > 0.0:
            time.append(segment.start + inside[:-1])
            states = segment.at(inside[:-1])
            displacement.append(states[0])
            velocity.append(states[1])
        overload = max([overload, *(abs(segment.acceleration(s)) for s in (0.0, *segment.jerk_zeros(span), span))])
    last, span = parts[-1]
    end = last.at(span)
    x = np.append(np.concatenate(displacement), end[0])
    arrays = [np.append(np.concatenate(time), last.start + span), x, np.append(np.concatenate(velocity), end[1]), _spring(case, x)]
    return SnapThroughResponse(
        *case,
        energy=0.5 * case.force**2 / case.stiffness,
        reverse_force=max(0.0, -case.stiffness * (lowest + case.clearance)),
        overshoot=-lowest,
        peak_acceleration=overload,
        frequency=case.frequency * math.sqrt(1 - case.damping_ratio**2),
        time=arrays[0],
        displacement=arrays[1],
        velocity=arrays[2],
        spring_force=arrays[3],
    )


def permissible_breakthrough(
    reverse_force: ArrayLike,
    stiffness: ArrayLike,
    mass: ArrayLike,
    *,
    damping_ratio: float = 0.0,
    break_time: float = 0.0,
    clearance: float = 0.0,
) -> Array:
    """Force (n,) at break-through after which the reverse load is just what is permitted [N]; the least, where a clearance gives several
    that are more than a twentieth apart.

    Args:
        reverse_force: permitted; builders often name 10 to 20 % of the nominal force [N].
        stiffness: of the press, over height: 1 / `SlideCompliance.compliance` [N/m].
        mass: over height: `SlideCompliance.effective_mass` and that of the upper die [kg].
        damping_ratio: as of `snap_through` [-].
        break_time: as of `snap_through` [s].
        clearance: as of `snap_through` [m].

    Returns:
        (n,) of the first three, (n,) each or one number.

    Raises:
        PinpressError: arrays of different lengths, an argument out of range, a break-through so slow that no force brings the reverse load
            about.
    """
    asked = {"reverse_force": reverse_force, "stiffness": stiffness, "mass": mass}
    try:
        given = np.broadcast_arrays(*(np.atleast_1d(numbers(name, values)) for name, values in asked.items()))
    except ValueError:
        raise PinpressError("reverse_force, stiffness and mass are not numbers of one length: give (n,) or one number each") from None
    if given[0].ndim != 1:
        raise PinpressError(f"reverse_force, stiffness and mass have shape {given[0].shape} together: give (n,) or one number each")
    shared = {"damping_ratio": damping_ratio, "break_time": break_time, "clearance": clearance}
    more = [number(name, value) for name, value in shared.items()]
    found = np.array([_permissible(float(r), float(k), float(m), *more) for r, k, m in zip(*given, strict=True)])
    return read_only(found)


def _permissible(reverse: float, stiffness: float, mass: float, damping_ratio: float, break_time: float, clearance: float) -> float:
    positive("reverse_force", reverse, "N")
    linear = snap_through(reverse, stiffness, mass=mass, damping_ratio=damping_ratio, break_time=break_time).reverse_ratio
    if linear < WEAKEST:
        raise PinpressError(
            f"after a break-through of {break_time:g} s the reverse load is below 1e-6 of the force: it permits any force; shorten the time"
        )
    if clearance == 0.0:
        return reverse / linear
    from scipy.optimize import brentq  # slow to import

    def excess(force: float) -> float:
        case = _case(force, stiffness, mass, damping_ratio, break_time, clearance)
        return max(0.0, -case.stiffness * (_lowest(segments(_resolved(case), pressed=False)) + case.clearance)) - reverse

    low = reverse / GROWTH  # without damping, and at once, the reverse load is the force; else it is less
    while excess(high := GROWTH * low) < 0.0:
        low = high
        if low > reverse / WEAKEST:
            raise PinpressError(f"no force brings about a reverse load of {reverse:g} N within a break-through of {break_time:g} s")
    return float(brentq(excess, low, high, xtol=1e-12 * high, rtol=1e-14))


def _lowest(parts: Iterable[tuple[ResponseSegment, float]]) -> float:
    """The lowest place of the slide in these segments [m], 0 where it stays above."""
    return min(0.0, *(float(segment.at(s)[0]) for segment, span in parts for s in (0.0, *turning(segment, span), span)))


def _case(force: float, stiffness: float, mass: float, damping_ratio: float, break_time: float, clearance: float) -> Release:
    sizes = positive("force", force, "N"), positive("stiffness", stiffness, "N/m"), positive("mass", mass, "kg")
    zeta, tau, gap = number("damping_ratio", damping_ratio), number("break_time", break_time), number("clearance", clearance)
    if not 0.0 <= zeta < 1.0:
        raise PinpressError(f"damping_ratio is {zeta:g}: give one from 0 to below 1, of structures 0.01 to 0.1")
    for name, value in (("break_time", tau), ("clearance", gap)):
        if value < 0.0:
            raise PinpressError(f"{name} is {value:g}: it cannot be negative")
    case = Release(*sizes, zeta, tau, gap)
    if tau * case.frequency > 2 * np.pi * LONGEST:
        raise PinpressError(f"break_time is {tau:g} s, more than 1000 periods of the press: nothing snaps through; give a shorter one")
    return case


def _resolved(case: Release) -> Release:
    """The same, at once where the break-through is so short, or without clearance where it is so small, that only rounding could tell."""
    at_once = case.break_time * case.frequency < AT_ONCE
    none = case.clearance * case.stiffness < NO_CLEARANCE * case.force
    return case._replace(break_time=0.0 if at_once else case.break_time, clearance=0.0 if none else case.clearance)


def _spring(case: Release, x: Array) -> Array:
    return case.stiffness * (np.maximum(x, 0.0) + np.minimum(x + case.clearance, 0.0))


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
class ResponseSegment:
    """The motion over a time s from its start, in closed form: in touch with the spring, or in free flight.

    Attributes:
        case: press and force.
        start: time at s = 0 [s].
        x: place at s = 0 [m].
        v: velocity at s = 0 [m/s].
        a: force at s = 0 [N].
        b: rate of the force, a + b s [N/s].
        slack: place at which the spring is slack [m]; None in free flight.
    """

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
        at, rate = self._particular(0.0)
        y, w = self.x - at, self.v - rate
        return decay, damped, y, (w + decay * y) / damped

    def _particular(self, s: Any) -> tuple[Any, float]:
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
        particular, rate = self._particular(s)
        return np.array(
            [particular + fade * (c * cos + d * sin), rate + fade * ((damped * d - decay * c) * cos - (damped * c + decay * d) * sin)]
        )

    def pressed(self, span: float) -> float:
        """For how long within the span x is positive whatever the phase of the vibration, in touch with a spring that is slack at 0."""
        from scipy.optimize import brentq  # slow to import

        decay, _, c, d = self._wave

        def least(s: float) -> float:  # concave, so that it is positive up to a time, or to the end
            return float(self._particular(s)[0] - math.hypot(c, d) * math.exp(-decay * s))

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
        rate = complex(-decay, damped)  # x - particular is the real part of (c - i d) exp(rate s)
        phase = np.angle(rate**3 * complex(c, -d))
        first = (0.5 * np.pi - phase) % np.pi / damped
        return [float(s) for s in np.arange(first, span, np.pi / damped)]


class Leaving(NamedTuple):
    """The slide leaves its side of the clearance: after which time [s], at which x [m], to which side."""

    after: float
    x: float
    side: int


def segments(case: Release, pressed: bool = True) -> Iterator[tuple[ResponseSegment, float]]:
    """Segments of at most half a period and how long they last.

    They end when the force is gone, the slide has turned round below, and `PERIODS` are over.

    Args:
        case: press and force.
        pressed: begin at the start; else not before the slide might leave the spring, which most of a slow drop is before.
    """
    half = np.pi / case.frequency
    end = case.break_time + PERIODS * 2 * half
    t, x, v = _start(case, half, pressed)
    side, turned = 1, False  # 1: pressed, 0: in flight, -1: pulled
    for _ in range(MOST):
        segment, dropping = _segment(case, t, x, v, side), t < case.break_time
        if side == 0 and not dropping and case.mass * v * v <= CALM * case.force**2 / case.stiffness:
            yield segment, max(end - t, 0.0)
            return
        span = min(half, case.break_time - t) if dropping else half
        left = _coasting(case, x, v) if side == 0 and not dropping else _leaving(segment, span, side)
        dropped = dropping and left is None and span == case.break_time - t
        span = span if left is None else left.after
        yield segment, span
        if not dropping and (side < 0 or case.clearance == 0.0):
            turned = turned or any(segment.at(s)[0] < -case.clearance for s in turning(segment, span))
        t = case.break_time if dropped else t + span
        x, v = (float(number) for number in segment.at(span))
        if left is not None:
            x, side = left.x, left.side
        quiet = not dropping and 0.5 * case.mass * v * v + 0.5 * case.stiffness * x * x <= CALM * case.force**2 / case.stiffness
        if t >= end and (turned or quiet):
            return
    raise PinpressError(f"the slide does not come to rest or to reverse load within {MOST} half periods: check clearance and damping")


def _start(case: Release, half: float, pressed: bool) -> tuple[float, float, float]:
    """Time, place and velocity at which the segments begin; see `segments`."""
    x, v = case.force / case.stiffness, 0.0
    if pressed or not case.break_time:
        return 0.0, x, v
    first = _segment(case, 0.0, x, v, 1)
    t = half * max(0, int(first.pressed(case.break_time) / half) - 1)  # one fewer, far from rounding
    x, v = (float(number) for number in first.at(t))
    return t, x, v


def _segment(case: Release, t: float, x: float, v: float, side: int) -> ResponseSegment:
    """The segment that begins at a time, in a place, with a velocity, on a side of the clearance."""
    force, rate = (case.force * (1 - t / case.break_time), -case.force / case.break_time) if t < case.break_time else (0.0, 0.0)
    slack = None if side == 0 else (0.0 if side > 0 else -case.clearance)
    return ResponseSegment(case, t, x, v, force, rate, slack)


def _coasting(case: Release, x: float, v: float) -> Leaving:
    """When free flight without a force ends."""
    edge = -case.clearance if v < 0.0 else 0.0
    return Leaving((edge - x) / v, edge, -1 if v < 0.0 else 1)


def _leaving(segment: ResponseSegment, span: float, side: int) -> Leaving | None:
    """When within the span the slide leaves its side of the clearance; None: it does not."""
    from scipy.optimize import brentq  # slow to import

    gap = segment.case.clearance
    if gap == 0.0:
        return None
    edges = {1: [(0.0, -1, 0)], 0: [(0.0, 1, 1), (-gap, -1, -1)], -1: [(-gap, 1, 0)]}[side]  # x, direction of leaving, next side
    times = np.union1d(np.linspace(0.0, span, STEPS + 1), turning(segment, span))
    places = segment.at(times)[0]
    places[0] = segment.x
    for i in range(1, len(times)):
        for edge, way, after in edges:
            if way * (places[i] - edge) > TOUCHING * segment.case.force / segment.case.stiffness:
                begin = times[i - 1]
                if way * (places[i - 1] - edge) >= 0.0:  # on the edge already
                    return Leaving(float(begin), edge, after)
                found = brentq(lambda s, edge=edge: float(segment.at(s)[0]) - edge, begin, times[i], xtol=1e-300, rtol=1e-15)
                return Leaving(float(found), edge, after)
    return None


def turning(segment: ResponseSegment, span: float) -> list[float]:
    """Times within the span at which the slide turns round."""
    from scipy.optimize import brentq  # slow to import

    times = np.linspace(0.0, span, STEPS + 1)
    speeds = segment.at(times)[1]
    signs = np.flatnonzero(speeds[:-1] * speeds[1:] < 0.0)
    return [float(brentq(lambda s: float(segment.at(s)[1]), times[i], times[i + 1], xtol=1e-300, rtol=1e-15)) for i in signs]
