"""Snap-through after break-through in blanking: the elastic press is suddenly unloaded and overshoots into reverse load.

The slide, of effective mass m, is connected to the spring k of the press, with the damping ratio zeta. Its displacement x is measured along
the guide's axis (upwards) from the unloaded position. A force F on the slide displaces it by F / k. When the blank breaks, the force falls
linearly to zero within a break-through time tau, or at once. Then m x'' + c x' + k x = F(t), x(0) = F / k, x'(0) = 0, c = 2 zeta sqrt(k m).
While x < 0 the slide pulls the linkage: k |x| is the reverse load, and |x| is the overshoot, by which the punch goes too deep. The model
assumes that the slide's weight is balanced, the crank is held, and the slide's travel during the snap-through is small.

With a clearance g in the bearings the spring is in contact for x > 0 and for x < -g; in between, the slide flies freely without damping.
Every segment of the motion has a closed form, and its end is computed within rounding error.

Closed forms without clearance: for a sudden break the reverse load is F exp(-zeta pi / sqrt(1 - zeta^2)). For a break within tau and
without damping it is F |sin(w tau / 2) / (w tau / 2)|, w = sqrt(k / m) (a linear drop of force on a linear oscillator; see any textbook on
vibrations).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import number, numbers, positive
from ..common.errors import PinpressError
from ..common.frozen import read_only
from ..common.numerics import sign_change
from ..common.quantities import Array
from ..common.results import Tabular

WEAKEST = 1e-6  # ratio of reverse load to force; below it the reverse load limits no force
GROWTH = 1.05  # ratio of the forces of two trials in the search with clearance
LONGEST = 1e3  # periods that a break-through may take
STEPS = 32  # steps of half a period in which turning points and edges of the clearance are searched
PERIODS = 6  # periods of vibration after the force is gone
CALM = 1e-24  # a kinetic energy below this share of the elastic energy is a rounding error
MOST = 20_000  # most segments, of half a period each
ROUNDING = 4 * float(np.finfo(float).eps)  # a root is computed to this share of its interval


@dataclass(frozen=True, eq=False, repr=False)
class SnapThroughResponse(Tabular):
    """Response of the slide and the elastic press to break-through. All arrays are read-only.

    Attributes:
        force: force F at break-through [N].
        stiffness: stiffness k of the press [N/m].
        mass: mass m of the slide and the parts that move with it [kg].
        damping_ratio: damping ratio zeta [-].
        break_time: time tau in which the force falls to zero [s].
        clearance: sum g of the clearances of the bearings [m].
        energy: elastic energy stored at break-through, F^2 / (2 k) [J].
        reverse_force: reverse load, the largest pull of the spring on the linkage [N].
        overshoot: largest displacement of the slide beyond its unloaded position, with the clearance [m].
        peak_acceleration: largest magnitude of the slide's acceleration [m/s2].
        frequency: frequency of the vibration after break-through, w sqrt(1 - zeta^2) [rad/s]; flights through a clearance lower it further.
        time: (n,) times from break-through, in unequal steps [s].
        displacement: (n,) displacement x [m].
        velocity: (n,) velocity x' [m/s].
        spring_force: (n,) force of the spring on the linkage, positive in compression [N].
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
        """Reverse load divided by the force at break-through [-]."""
        return self.reverse_force / self.force

    @property
    def title(self) -> str:
        return f"SnapThroughResponse: reverse load {self.reverse_force:.4g} N after {self.force:.4g} N"

    def columns(self) -> dict[str, Array]:
        """A row for each time: displacement, velocity and force."""
        return {
            "time [s]": self.time,
            "displacement [m]": self.displacement,
            "velocity [m/s]": self.velocity,
            "spring_force [N]": self.spring_force,
        }


def snap_through(
    force: float, stiffness: float, mass: float, *, damping_ratio: float = 0.0, break_time: float = 0.0, clearance: float = 0.0
) -> SnapThroughResponse:
    """Find reverse load, overshoot and vibration of a press after break-through.

    Args:
        force: force of blanking when the blank breaks through [N].
        stiffness: stiffness of the press at the height of break-through, 1 / `SlideCompliance.compliance` [N/m].
        mass: mass of the slide and the parts that move with it, with the upper die: `SlideCompliance.effective_mass` plus the die's mass
            [kg].
        damping_ratio: damping ratio zeta, from 0 to below 1 [-].
        break_time: time in which the force falls to zero; 0: at once [s].
        clearance: sum of the clearances of all bearings in the line of force [m].

    Raises:
        PinpressError: an argument is out of range, the break-through takes longer than 1000 periods, or the slide does not come to rest.
    """
    release = _release(force, stiffness, mass, damping_ratio, break_time, clearance)
    parts = list(segments(_without_traces(release)))
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
    arrays = [np.append(np.concatenate(time), last.start + span), x, np.append(np.concatenate(velocity), end[1]), _spring(release, x)]
    return SnapThroughResponse(
        *release,
        energy=0.5 * release.force**2 / release.stiffness,
        reverse_force=max(0.0, -release.stiffness * (lowest + release.clearance)),
        overshoot=-lowest,
        peak_acceleration=overload,
        frequency=release.frequency * math.sqrt(1 - release.damping_ratio**2),
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
    """Find the force at break-through for which the reverse load just reaches its permitted value.

    With a clearance there may be several such forces; then the result is the smallest, if they differ by more than 5 %. The first three
    arguments are (n,) arrays, for example over the height, or single numbers.

    Args:
        reverse_force: permitted reverse load, as stated by the maker of the press; often 10 % of the nominal force [N].
        stiffness: stiffness of the press, 1 / `SlideCompliance.compliance` [N/m].
        mass: `SlideCompliance.effective_mass` plus the mass of the upper die [kg].
        damping_ratio: as for `snap_through` [-].
        break_time: as for `snap_through` [s].
        clearance: as for `snap_through` [m].

    Returns:
        (n,) forces [N].

    Raises:
        PinpressError: arrays differ in length, an argument is out of range, or the break-through is so slow that no force causes this
            reverse load.
    """
    asked = {"reverse_force": reverse_force, "stiffness": stiffness, "mass": mass}
    try:
        arrays = np.broadcast_arrays(*(np.atleast_1d(numbers(name, values)) for name, values in asked.items()))
    except ValueError:
        raise PinpressError("reverse_force, stiffness and mass are not numbers of one length: give arrays (n,) or single numbers") from None
    if arrays[0].ndim != 1:
        raise PinpressError(f"reverse_force, stiffness and mass have shape {arrays[0].shape} together: give arrays (n,) or single numbers")
    shared = {"damping_ratio": damping_ratio, "break_time": break_time, "clearance": clearance}
    more = [number(name, value) for name, value in shared.items()]
    forces = np.array([_permissible(float(r), float(k), float(m), *more) for r, k, m in zip(*arrays, strict=True)])
    return read_only(forces)


class Release(NamedTuple):
    """A break-through: the arguments of `snap_through`, checked."""

    force: float
    stiffness: float
    mass: float
    damping_ratio: float
    break_time: float
    clearance: float

    @property
    def frequency(self) -> float:
        """Natural frequency w without damping and clearance [rad/s]."""
        return math.sqrt(self.stiffness / self.mass)


@dataclass(frozen=True)
class ResponseSegment:
    """The slide's motion over the time s since the segment's start, in closed form, in contact with the spring or in free flight.

    Attributes:
        release: the break-through.
        start: time at s = 0 [s].
        x: displacement at s = 0 [m].
        v: velocity at s = 0 [m/s].
        a: force at s = 0 [N].
        b: rate of the force, which is a + b s [N/s].
        slack: displacement at which the spring is slack [m]; None in free flight.
    """

    release: Release
    start: float
    x: float
    v: float
    a: float
    b: float
    slack: float | None

    @property
    def _wave(self) -> tuple[float, float, float, float]:
        """Decay rate [1/s], damped frequency [rad/s], and the amplitudes of cosine and sine [m]."""
        release = self.release
        decay = release.damping_ratio * release.frequency
        damped = release.frequency * math.sqrt(1 - release.damping_ratio**2)
        place, rate = self._particular(0.0)
        y, w = self.x - place, self.v - rate
        return decay, damped, y, (w + decay * y) / damped

    def _particular(self, s: Any) -> tuple[Any, float]:
        """The particular solution [m] and its time derivative [m/s]."""
        release = self.release
        assert self.slack is not None
        rate = self.b / release.stiffness
        return self.slack + (self.a + self.b * s) / release.stiffness - 2 * release.damping_ratio / release.frequency * rate, rate

    def at(self, s: Any) -> Array:
        """Displacement [m] and velocity [m/s] at a time s or (n,) times, (2,) or (2, n)."""
        if self.slack is None:
            m = self.release.mass
            x = self.x + s * (self.v + s * (self.a / 2 + s * self.b / 6) / m)
            return np.array([x, self.v + s * (self.a + s * self.b / 2) / m])
        decay, damped, c, d = self._wave
        cos, sin, fade = np.cos(damped * s), np.sin(damped * s), np.exp(-decay * s)
        particular, rate = self._particular(s)
        return np.array(
            [particular + fade * (c * cos + d * sin), rate + fade * ((damped * d - decay * c) * cos - (damped * c + decay * d) * sin)]
        )

    def pressed(self, span: float) -> float:
        """Time within the span in which x is positive for any phase of the vibration; in contact, with a spring that is slack at x = 0."""
        decay, _, c, d = self._wave

        def least(s: float) -> float:  # concave, so it is positive up to one time, or up to the end
            return float(self._particular(s)[0] - math.hypot(c, d) * math.exp(-decay * s))

        return span if least(span) > 0.0 else sign_change(least, 0.0, span, ROUNDING * span) if least(0.0) > 0.0 else 0.0

    def acceleration(self, s: Any) -> Any:
        """Acceleration x'' at a time s or (n,) times [m/s2]."""
        if self.slack is None:
            return (self.a + self.b * s) / self.release.mass
        release = self.release
        x, v = self.at(s)
        return (
            self.a + self.b * s - release.stiffness * (x - self.slack)
        ) / release.mass - 2 * release.damping_ratio * release.frequency * v

    def jerk_zeros(self, span: float) -> list[float]:
        """Times within the span at which the acceleration has an extreme value [s]."""
        if self.slack is None:
            return []
        decay, damped, c, d = self._wave
        rate = complex(-decay, damped)  # x - particular is the real part of (c - i d) exp(rate s)
        phase = np.angle(rate**3 * complex(c, -d))
        first = (0.5 * np.pi - phase) % np.pi / damped
        return [float(s) for s in np.arange(first, span, np.pi / damped)]


def segments(release: Release, pressed: bool = True) -> Iterator[tuple[ResponseSegment, float]]:
    """The segments of the motion, at most half a period each, with their lengths [s].

    They end when the force is zero, the slide has turned back in reverse load (or is at rest), and `PERIODS` periods are over.

    Args:
        release: the break-through.
        pressed: whether to begin at break-through. Otherwise the time in which the slide certainly stays in contact with the spring is left
            out, which is most of a slow break-through.

    Raises:
        PinpressError: the slide does not come to rest.
    """
    half = np.pi / release.frequency
    end = release.break_time + PERIODS * 2 * half
    t, x, v = _start(release, half, pressed)
    side, turned = 1, False  # 1: pressed, 0: in flight, -1: pulled
    for _ in range(MOST):
        segment, dropping = _segment(release, t, x, v, side), t < release.break_time
        if side == 0 and not dropping and release.mass * v * v <= CALM * release.force**2 / release.stiffness:
            yield segment, max(end - t, 0.0)
            return
        span = min(half, release.break_time - t) if dropping else half
        left = _coasting(release, x, v) if side == 0 and not dropping else _leaving(segment, span, side)
        dropped = dropping and left is None and span == release.break_time - t
        span = span if left is None else left.after
        yield segment, span
        if not dropping and (side < 0 or release.clearance == 0.0):
            turned = turned or any(segment.at(s)[0] < -release.clearance for s in turning(segment, span))
        t = release.break_time if dropped else t + span
        x, v = (float(number) for number in segment.at(span))
        if left is not None:
            x, side = left.x, left.side
        quiet = not dropping and 0.5 * release.mass * v * v + 0.5 * release.stiffness * x * x <= CALM * release.force**2 / release.stiffness
        if t >= end and (turned or quiet):
            return
    raise PinpressError(f"the slide does not come to rest or to reverse load within {MOST} half periods: check clearance and damping")


def turning(segment: ResponseSegment, span: float) -> list[float]:
    """Times within the span at which the slide turns back [s]."""
    times = np.linspace(0.0, span, STEPS + 1)
    speeds = segment.at(times)[1]
    signs = np.flatnonzero(speeds[:-1] * speeds[1:] < 0.0)
    return [sign_change(lambda s: float(segment.at(s)[1]), float(times[i]), float(times[i + 1]), ROUNDING * span) for i in signs]


class Leaving(NamedTuple):
    """The end of a segment where the slide leaves its side of the clearance.

    Attributes:
        after: time from the segment's start [s].
        x: displacement there [m].
        side: side that it reaches: 1 pressed, 0 in flight, -1 pulled.
    """

    after: float
    x: float
    side: int


def _permissible(reverse: float, stiffness: float, mass: float, damping_ratio: float, break_time: float, clearance: float) -> float:
    positive("reverse_force", reverse, "N")
    linear = snap_through(reverse, stiffness, mass=mass, damping_ratio=damping_ratio, break_time=break_time).reverse_ratio
    if linear < WEAKEST:
        raise PinpressError(
            f"after a break-through of {break_time:g} s the reverse load is below 1e-6 of the force, so that any force is permitted:"
            " shorten the time"
        )
    if clearance == 0.0:
        return reverse / linear

    def excess(force: float) -> float:
        release = _release(force, stiffness, mass, damping_ratio, break_time, clearance)
        return max(0.0, -release.stiffness * (_lowest(segments(_without_traces(release), pressed=False)) + release.clearance)) - reverse

    low = reverse / GROWTH  # the reverse load equals the force without damping and for a sudden break; otherwise it is smaller
    while excess(high := GROWTH * low) < 0.0:
        low = high
        if low > reverse / WEAKEST:
            raise PinpressError(f"no force causes a reverse load of {reverse:g} N after a break-through of {break_time:g} s")
    return sign_change(excess, low, high, 1e-12 * high)


def _lowest(parts: Iterable[tuple[ResponseSegment, float]]) -> float:
    """Lowest displacement of the slide in some segments, at most 0 [m]."""
    return min(0.0, *(float(segment.at(s)[0]) for segment, span in parts for s in (0.0, *turning(segment, span), span)))


def _release(force: float, stiffness: float, mass: float, damping_ratio: float, break_time: float, clearance: float) -> Release:
    sizes = positive("force", force, "N"), positive("stiffness", stiffness, "N/m"), positive("mass", mass, "kg")
    zeta, tau, gap = number("damping_ratio", damping_ratio), number("break_time", break_time), number("clearance", clearance)
    if not 0.0 <= zeta < 1.0:
        raise PinpressError(f"damping_ratio is {zeta:g}: give a ratio from 0 to below 1; structures have 0.01 to 0.1")
    for name, value in (("break_time", tau), ("clearance", gap)):
        if value < 0.0:
            raise PinpressError(f"{name} is {value:g}: it cannot be negative")
    release = Release(*sizes, zeta, tau, gap)
    if tau * release.frequency > 2 * np.pi * LONGEST:
        raise PinpressError(
            f"break_time is {tau:g} s, more than 1000 periods of the press: so slow that there is no snap-through; give a shorter time"
        )
    plausibility.release(*sizes, tau, gap)
    return release


def _without_traces(release: Release) -> Release:
    """The release, with break time or clearance set to zero if its effect is within rounding error."""
    at_once = release.break_time * release.frequency < 1e-9  # the reverse load differs by (w tau)^2 / 24
    none = release.clearance * release.stiffness < 1e-13 * release.force  # a smaller clearance is a rounding error of the deflection
    return release._replace(break_time=0.0 if at_once else release.break_time, clearance=0.0 if none else release.clearance)


def _spring(release: Release, x: Array) -> Array:
    """Force (n,) of the spring at displacements (n,) [N]."""
    return release.stiffness * (np.maximum(x, 0.0) + np.minimum(x + release.clearance, 0.0))


def _start(release: Release, half: float, pressed: bool) -> tuple[float, float, float]:
    """Time [s], displacement [m] and velocity [m/s] at which the segments begin; see `segments`."""
    x, v = release.force / release.stiffness, 0.0
    if pressed or not release.break_time:
        return 0.0, x, v
    first = _segment(release, 0.0, x, v, 1)
    t = half * max(0, int(first.pressed(release.break_time) / half) - 1)  # one half period fewer, to stay away from rounding errors
    x, v = (float(number) for number in first.at(t))
    return t, x, v


def _segment(release: Release, t: float, x: float, v: float, side: int) -> ResponseSegment:
    """The segment that begins at a time, displacement and velocity, on a side of the clearance."""
    force, rate = (
        (release.force * (1 - t / release.break_time), -release.force / release.break_time) if t < release.break_time else (0.0, 0.0)
    )
    slack = None if side == 0 else (0.0 if side > 0 else -release.clearance)
    return ResponseSegment(release, t, x, v, force, rate, slack)


def _coasting(release: Release, x: float, v: float) -> Leaving:
    """The end of a free flight without force."""
    edge = -release.clearance if v < 0.0 else 0.0
    return Leaving((edge - x) / v, edge, -1 if v < 0.0 else 1)


def _leaving(segment: ResponseSegment, span: float, side: int) -> Leaving | None:
    """The instant within the span at which the slide leaves its side of the clearance; None if it does not leave."""
    gap = segment.release.clearance
    if gap == 0.0:
        return None
    edges = {1: [(0.0, -1, 0)], 0: [(0.0, 1, 1), (-gap, -1, -1)], -1: [(-gap, 1, 0)]}[side]  # x, direction of leaving, next side
    times = np.union1d(np.linspace(0.0, span, STEPS + 1), turning(segment, span))
    places = segment.at(times)[0]
    places[0] = segment.x
    for i in range(1, len(times)):
        for edge, way, after in edges:
            # the slide is at the edge if its distance is within the rounding error of the deflection
            if way * (places[i] - edge) > 1e-13 * segment.release.force / segment.release.stiffness:
                begin = times[i - 1]
                if way * (places[i - 1] - edge) >= 0.0:  # already at the edge
                    return Leaving(float(begin), edge, after)

                def beyond(s: float, edge: float = edge) -> float:
                    return float(segment.at(s)[0]) - edge

                return Leaving(sign_change(beyond, float(begin), float(times[i]), ROUNDING * span), edge, after)
    return None
