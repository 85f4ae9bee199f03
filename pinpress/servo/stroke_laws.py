"""Established motions: constant crank speed, two speeds, constant slide speed, and the laws of VDI 2143 from rest to rest.

Free parameters have the values with the least heat: the duration of the ramps, and the share of the cycle's time for each of two legs.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..common.arguments import expect, positive, typed, whole_number
from ..common.errors import PinpressError
from ..common.motion_laws import VDI_LAWS
from ..common.motion_laws import MotionLaw as MotionLaw  # public names of this room
from ..common.motion_laws import vdi_law as vdi_law
from ..common.numerics import bracketed_roots
from ..common.quantities import Array
from ..kinematics.cycle import motion_through_change_points
from ..kinematics.servo_motion import angle_on_flank
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage
from ..loads.link import Load
from .conic.coefficients import load_heights
from .drive import ServoDrive
from .limits import Limit, SlideSpeed, checked, span
from .motion import MOST_STATES, ServoMotion, evaluated
from .paths import Path, PathLegs, Stop, Turn, legs_of

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

TURN, STOP = Turn(), Stop()
POINTS = 720  # states of a cycle
FEWEST = 8  # least number of steps for a smooth piece of a cycle: a ramp, or a leg between jumps and edges of loads
SHARES = 1e-4  # error of the free parameters, as a share of their range
LEAST_RAMP = 1e-3  # shortest ramp, as a share of the cycle
SAME = 1e-9  # speeds that differ by a smaller share count as equal
BESIDE = 1e-9  # share of a piece by which states are moved away from the angle at which a load begins
WINDOW = 721  # number of crank angles at which a window of heights is evaluated


class _Part(NamedTuple):
    """A part of a cycle; ``at`` returns angle, speed and acceleration at times since its start, smooth between the times ``corners``."""

    duration: float
    at: Callable[[Array], tuple[Array, Array, Array]]
    corners: tuple[float, ...] = ()

    @property
    def way(self) -> float:
        """Angle by which the crank turns in this part [rad]."""
        return float(self.at(np.array([self.duration]))[0][0])

    def times_at(self, angles: Array) -> Array:
        """Times (m,) at which the crank has turned by angles (m,)."""

        def off(time: Array) -> tuple[Array, Array]:
            turned, speed, _ = self.at(time)
            return turned - angles, speed

        return bracketed_roots(off, np.zeros_like(angles), np.full_like(angles, self.duration), relative=1e-15)


@dataclass(frozen=True)
class _Cycle:
    """The arguments of a cycle's motion laws; ``edges``: (k,) crank angles at which a load begins or ends [rad]."""

    press: Linkage
    drive: ServoDrive
    loads: Sequence[Load]
    legs: PathLegs
    edges: Array
    time: float
    points: int

    @property
    def stroke_time(self) -> float:
        """Time of one of the strokes of the cycle [s]."""
        return self.time / self.legs.strokes

    @property
    def way(self) -> float:
        """Absolute angle by which the crank turns in a stroke, on a path of full turns [rad]."""
        return abs(float(self.legs.angles[-1] - self.legs.angles[0])) / self.legs.strokes

    @property
    def forward(self) -> bool:
        """Whether the crank turns in the positive direction, on a path of full turns."""
        return bool(self.legs.angles[-1] > self.legs.angles[0])

    def turning(self, parts: Sequence[_Part], start: float) -> ServoMotion:
        """The motion of a full turn, or of several equal strokes, from the parts of a stroke that starts at a crank angle."""
        ahead = float(self.legs.angles[0]) - start
        return self.motion([_start_later([*parts] * self.legs.strokes, (ahead if self.forward else -ahead) % self.way)])

    def motion(self, legs: Sequence[Sequence[_Part]]) -> ServoMotion:
        """The motion made of the parts of each leg, with the weights of Simpson's rule over every smooth piece."""
        times, weights, states = [], [], []
        angle, time = float(self.legs.angles[0]), 0.0
        ways = np.sign(np.diff(self.legs.angles))
        for way, parts in zip(ways, legs, strict=True):
            for part in parts:
                inner, least = np.unique([*part.corners, *self._edge_times(part, angle, way)]), 1e-12 * self.time
                inner = inner[(np.diff(inner, prepend=0.0) > least) & (inner < part.duration - least)]
                for first, last in itertools.pairwise([0.0, *inner.tolist(), part.duration]):
                    steps = max(FEWEST, 2 * math.ceil(0.5 * self.points * (last - first) / self.time))
                    since = np.linspace(first, last, steps + 1)
                    # forces may jump at edges and corners, so all states of a piece stay on its own side of the jump
                    since[0] += BESIDE * (last - first) * (first > 0)
                    since[-1] -= BESIDE * (last - first) * (last < part.duration)
                    gained, speed, acceleration = part.at(since)
                    rule = np.tile([2.0, 4.0], steps // 2 + 1)[:-1]
                    rule[[0, -1]] = 1.0
                    weights.append((last - first) / (3 * steps) * rule)
                    times.append(time + since)
                    states.append([angle + way * gained, way * speed, way * acceleration])
                time, angle = time + part.duration, angle + way * part.way
        return evaluated(
            self.press, self.drive, self.loads, np.concatenate(times), np.concatenate(weights), *np.concatenate(states, axis=1)
        )[0]

    def _edge_times(self, part: _Part, start: float, way: float) -> list[float]:
        """The times within a part at which the crank passes an angle where a load begins or ends."""
        ends = np.sort(start + way * np.array([0.0, part.way]))
        whole = 2 * np.pi * dead_centres(self.press).turns
        turns = np.arange(math.floor(ends[0] / whole) - 1, math.ceil(ends[1] / whole) + 1)
        edges = (self.edges[:, None] + whole * turns).ravel()
        times: list[float] = part.times_at(way * (edges[(edges > ends[0]) & (edges < ends[1])] - start)).tolist()
        return times


def _constant(speed: float, duration: float) -> _Part:
    return _Part(duration, lambda time: (speed * time, np.full_like(time, speed), np.zeros_like(time)))


def _ramp(first: float, last: float, duration: float) -> _Part:
    """From one speed to another at constant acceleration."""
    rate = (last - first) / duration
    return _Part(duration, lambda time: (first * time + 0.5 * rate * time**2, first + rate * time, np.full_like(time, rate)))


def _by_law(law: MotionLaw, way: float, duration: float) -> _Part:
    def at(time: Array) -> tuple[Array, Array, Array]:
        share = np.clip(time / duration, 0.0, 1.0)
        return way * law.position(share), way / duration * law.speed(share), way / duration**2 * law.acceleration(share)

    return _Part(duration, at, tuple(duration * share for share in law.corners))


def _start_later(parts: list[_Part], angle: float) -> list[_Part]:
    """The parts of a closed path, starting after the crank has turned by an angle; the parts before that come last."""
    for k, part in enumerate(parts):
        if angle < part.way:
            *early, late = _cut(part, angle)
            return [late, *parts[k + 1 :], *parts[:k], *early]
        angle -= part.way
    return parts


def _cut(part: _Part, angle: float) -> list[_Part]:
    """The two parts of a part that is cut after the crank has turned by an angle; the uncut part if the angle is 0."""
    if angle <= 0:
        return [part]
    time = float(part.times_at(np.array([angle]))[0])

    def late(since: Array) -> tuple[Array, Array, Array]:
        turned, speed, acceleration = part.at(time + since)
        return turned - part.at(np.array([time]))[0], speed, acceleration

    before = tuple(corner for corner in part.corners if corner < time)
    return [_Part(time, part.at, before), _Part(part.duration - time, late, tuple(c - time for c in part.corners if c > time))]


@typed
def constant_crank_speed(
    press: Linkage, drive: ServoDrive, loads: Sequence[Load] = (), *, time: float, path: Path = TURN, points: int = POINTS
) -> ServoMotion:
    """The motion of a servo press whose crank turns at constant speed, as in a press with a heavy flywheel.

    Args:
        press: the press.
        drive: the drive.
        loads: as in `inverse_dynamics`.
        time: time of a cycle [s].
        path: `Turn`; by default forwards.
        points: number of states.

    Raises:
        PinpressError: the path has rests, or as `evaluate`.
    """
    cycle = _cycle(press, drive, loads, time, path, points)
    _refuse_rests(cycle)
    return cycle.motion([[_constant(cycle.way / cycle.stroke_time, cycle.stroke_time)] * cycle.legs.strokes])


@typed
def two_speed(
    press: Linkage,
    drive: ServoDrive,
    loads: Sequence[Load] = (),
    *,
    time: float,
    limit: SlideSpeed,
    path: Path = TURN,
    points: int = POINTS,
) -> ServoMotion:
    """The motion of a servo press with two crank speeds: slow while the slide works, fast for the rest of the cycle.

    The slow speed is the highest at which the slide keeps the limit everywhere in the window of heights. The crank accelerates and
    decelerates at constant rates, in the time that gives the least heat.

    Args:
        press: the press.
        drive: the drive.
        loads: as in `inverse_dynamics`.
        time: time of a cycle [s].
        limit: largest speed of the slide in a window of heights, on the way down.
        path: `Turn`; by default forwards.
        points: number of states.

    Raises:
        PinpressError: the path has rests, heights are not within the stroke, the time is too short, or a constant crank speed already keeps
            the limit; also as `evaluate`.
    """
    cycle, window = _slow_turn(_cycle(press, drive, loads, time, path, points), limit)
    slow, whole = window.slowest, cycle.stroke_time
    working = window.angle / slow
    _refuse_short(cycle, working)

    def motion(ramp: float) -> ServoMotion:
        fast = (cycle.way - slow * (working + ramp)) / (whole - working - ramp)
        rest = whole - working - 2 * ramp
        parts = [_constant(slow, working), _ramp(slow, fast, ramp), *([_constant(fast, rest)] if rest > 0 else []), _ramp(fast, slow, ramp)]
        return cycle.turning(parts, window.start)

    return _best(motion, LEAST_RAMP * whole, 0.5 * (whole - working))


@typed
def constant_slide_speed(
    press: Linkage,
    drive: ServoDrive,
    loads: Sequence[Load] = (),
    *,
    time: float,
    limit: SlideSpeed,
    path: Path = TURN,
    points: int = POINTS,
) -> ServoMotion:
    """The motion of a servo press whose slide goes down at constant speed within a window of heights.

    Outside the window the crank turns at constant speed. Near bottom dead centre the crank would have to turn faster and faster to keep the
    slide's speed. There the crank stays at the outer speed once it has reached it. Before the window the crank slows down at a constant
    rate, in the time that gives the least heat.

    Args:
        press: the press.
        drive: the drive.
        loads: as in `inverse_dynamics`.
        time: time of a cycle [s].
        limit: speed of the slide in a window of heights, on the way down.
        path: `Turn`; by default forwards.
        points: number of states.

    Raises:
        PinpressError: as `two_speed`.
    """
    cycle, window = _slow_turn(_cycle(press, drive, loads, time, path, points), limit)
    whole = cycle.stroke_time
    working = float(window.height(0.0) - window.height(window.angle)) / limit.speed
    _refuse_short(cycle, working)

    def motion(ramp: float) -> ServoMotion:
        first, parts = _beside_window(cycle, window, ramp)
        return cycle.turning(parts, window.start + (first if cycle.forward else -first))

    return _best(motion, LEAST_RAMP * whole, 0.5 * (whole - working))


@typed
def motion_by_law(
    press: Linkage,
    drive: ServoDrive,
    law: str,
    loads: Sequence[Load] = (),
    *,
    time: float,
    path: Path = STOP,
    points: int = POINTS,
) -> ServoMotion:
    """The motion of a servo press whose crank goes from rest to rest by a law of VDI 2143 on each leg of its path.

    Two legs share the time so that the heat is least. With more legs, the time of a leg is proportional to the root of its angle, which is
    best for a constant inertia.

    Args:
        press: the press.
        drive: the drive.
        law: name of the law, see `vdi_law`.
        loads: as in `inverse_dynamics`.
        time: time of a cycle, the sum of legs and rests [s].
        path: `Stop`, `Pendulum` or `Pulse`; by default `Stop()`: one leg from top dead centre to top dead centre.
        points: number of states.

    Raises:
        PinpressError: the path has no rests, the rests take all the time, or as `evaluate`.
        UnknownNameError: no law has this name.
    """
    motion_law = vdi_law(law)
    cycle = _cycle(press, drive, loads, time, path, points)
    if cycle.legs.closed:
        raise PinpressError("path is a turn without a rest, but the laws go from rest to rest: give servo.Stop(), Pendulum or Pulse")
    ways, moving = np.abs(np.diff(cycle.legs.angles)), cycle.time - cycle.legs.dwell
    if not moving > 0:
        raise PinpressError(f"time is {cycle.time:g} s, but the path rests for {cycle.legs.dwell:g} s: give more time")

    def motion(shares: Array) -> ServoMotion:
        legs = [[_by_law(motion_law, float(way), moving * float(share))] for way, share in zip(ways, shares, strict=True)]
        for leg, dwell in zip(legs, cycle.legs.dwells.tolist(), strict=True):
            leg += [_constant(0.0, dwell)] if dwell > 0 else []
        return cycle.motion(legs)

    if len(ways) == 2:
        return _best(lambda share: motion(np.array([share, 1 - share])), 0.02, 0.98)
    return motion(np.sqrt(ways) / np.sqrt(ways).sum())


@typed
def ready_motions(
    press: Linkage,
    drive: ServoDrive,
    loads: Sequence[Load] = (),
    *,
    time: float,
    path: Path = TURN,
    limits: Sequence[Limit] = (),
    points: int = POINTS,
) -> dict[str, ServoMotion]:
    """All established motions for a cycle, with their names, to compare a better motion with.

    For a full turn the motions are "constant crank speed" and, if this breaks a limit of the slide's speed, "two speeds" and "constant
    slide speed". For a path with rests they are the laws of `vdi_law`, which do not consider limits.

    Args:
        press: the press.
        drive: the drive.
        loads: as in `inverse_dynamics`.
        time: time of a cycle [s].
        path: where the crank goes; by default `Turn()`.
        limits: as in `best_motion`; only the first `SlideSpeed` of the way down is considered.
        points: number of states.

    Raises:
        PinpressError: as the functions for single motions.
    """
    cycle = _cycle(press, drive, loads, time, path, points)
    common: dict[str, Any] = {"time": cycle.time, "path": path, "points": cycle.points}
    if not cycle.legs.closed:
        return {law: motion_by_law(press, drive, law, cycle.loads, **common) for law in VDI_LAWS}
    motions = {"constant crank speed": constant_crank_speed(press, drive, cycle.loads, **common)}
    slide = next((limit for limit in checked(limits) if isinstance(limit, SlideSpeed) and limit.flank != "up"), None)
    if slide is not None and not _is_slack(cycle, _window(cycle, slide)):
        motions["two speeds"] = two_speed(press, drive, cycle.loads, limit=slide, **common)
        motions["constant slide speed"] = constant_slide_speed(press, drive, cycle.loads, limit=slide, **common)
    return motions


# ------------------------------------------------------------------------------------------------------------------- windows of heights


@dataclass(frozen=True)
class _Window:
    """A window of heights on the slide's way down, which starts at crank angle ``start`` and takes the crank angle ``angle``.

    ``height`` and ``ratio`` are splines over the crank angle since the start: the slide's height [m], and its slope, positive downwards
    [m/rad]. ``speed`` is the speed of the slide in the window.
    """

    speed: float
    start: float
    angle: float
    height: CubicHermiteSpline
    ratio: CubicHermiteSpline

    @property
    def slowest(self) -> float:
        """Largest constant speed of the crank at which the slide keeps its speed limit everywhere in the window [rad/s]."""
        return self.speed / float(self.ratio(np.linspace(0.0, self.angle, 4 * WINDOW)).max())


def _window(cycle: _Cycle, limit: SlideSpeed) -> _Window:
    from scipy.interpolate import CubicHermiteSpline  # to save start-up time

    expect("limit", limit, SlideSpeed, "servo.SlideSpeed")
    if limit.flank == "up":
        raise PinpressError('limit holds on the way up: give SlideSpeed(speed, heights, flank="down")')
    ends, speed = dead_centres(cycle.press), limit.speed
    lower, upper = span(limit)
    if not lower < ends.stroke:
        raise PinpressError(f"limit holds from {lower:g} m up, above the stroke of {ends.stroke:.6g} m: give heights within it")
    lower, upper = max(lower, 0.0), min(upper, ends.stroke)
    before, after = (angle_on_flank(cycle.press, ends, height, cycle.forward) for height in (upper, lower))
    angle = (after - before if cycle.forward else before - after) % cycle.way
    along = np.linspace(0.0, angle, WINDOW)
    way = 1.0 if cycle.forward else -1.0
    motion = motion_through_change_points(cycle.press, before + way * along, way)
    ratio = -motion.slide_velocity
    height = CubicHermiteSpline(along, motion.slide_position - ends.bottom_position, -ratio)
    return _Window(speed, before, angle, height, CubicHermiteSpline(along, ratio, -motion.slide_acceleration))


def _beside_window(cycle: _Cycle, window: _Window, ramp: float) -> tuple[float, list[_Part]]:
    """The parts of a stroke at constant slide speed in the window, and at constant crank speed outside, with ramps of a duration between.

    Returns:
        The angle since the start of the window at which the constant slide speed starts [rad], and the parts.
    """
    from scipy.optimize import brentq  # to save start-up time

    whole = cycle.stroke_time

    def parts(fast: float) -> tuple[float, list[_Part]]:
        first, last = _constant_within(window, fast)
        inside = _at_constant_slide_speed(window, first, last)
        entry, exit_ = (float(window.speed / window.ratio(x)) for x in (first, last))
        down, up = fast - entry > SAME * fast, fast - exit_ > SAME * fast
        rest = whole - inside.duration - ramp * (down + up)
        return first, [
            inside,
            *([_ramp(exit_, fast, ramp)] if up else []),
            _constant(fast, rest),
            *([_ramp(fast, entry, ramp)] if down else []),
        ]

    def missed(fast: float) -> float:
        return sum(part.way for part in parts(fast)[1]) - cycle.way

    low = cycle.way / whole
    high = 2 * low
    while missed(high) < 0:
        high *= 2
    fast = brentq(missed, low, high, xtol=1e-13 * low, rtol=1e-14)
    return parts(fast)


def _constant_within(window: _Window, fast: float) -> tuple[float, float]:
    """Angles in the window between which the slide has its constant speed: there the crank is slower than outside the window."""
    ends = [0.0, window.angle]
    roots = np.sort(window.ratio.solve(window.speed / fast, extrapolate=False))
    slower = [bool(window.ratio(x) * fast > window.speed) for x in ends]
    return ends[0] if slower[0] else float(roots[0]), ends[1] if slower[1] else float(roots[-1])


def _at_constant_slide_speed(window: _Window, first: float, last: float) -> _Part:
    from scipy.interpolate import CubicHermiteSpline  # to save start-up time

    along = np.linspace(first, last, WINDOW)
    times = (window.height(first) - window.height(along)) / window.speed
    angles = CubicHermiteSpline(times, along, window.speed / window.ratio(along))
    slope = window.ratio.derivative()

    def at(time: Array) -> tuple[Array, Array, Array]:
        angle = angles(np.clip(time, 0.0, times[-1]))
        ratio = window.ratio(angle)
        speed = window.speed / ratio
        return angle - first, speed, -(speed**2) * slope(angle) / ratio

    return _Part(float(times[-1]), at)


# -------------------------------------------------------------------------------------------------------------------------- shared parts


def _cycle(press: Linkage, drive: ServoDrive, loads: Sequence[Load], time: float, path: Path, points: int) -> _Cycle:
    expect("drive", drive, ServoDrive, "servo.ServoDrive")
    duration = positive("time", time, "s")
    count = whole_number("points", points, FEWEST, MOST_STATES // 4)
    load_list = list(loads)
    return _Cycle(press, drive, load_list, legs_of(path, press), _load_edges(press, load_list), duration, count)


def _load_edges(press: Linkage, loads: Sequence[Load]) -> Array:
    """(k,) crank angles within the slide's period at which a load begins, ends or (at dead centres) changes its law [rad]."""
    if not loads:
        return np.empty(0)
    ends = dead_centres(press)
    heights = [height for height in load_heights(press, loads) if 0 < height < ends.stroke]
    # a crank that swings back goes down on the other flank
    return np.unique(
        [ends.bottom_angle, ends.top_angle, *(angle_on_flank(press, ends, h, down) for h in heights for down in (True, False))]
    )


def _best(motion: Callable[[float], ServoMotion], low: float, high: float) -> ServoMotion:
    """The motion with the least heat, over a parameter between two ends."""
    from scipy.optimize import minimize_scalar  # to save start-up time

    options = {"xatol": SHARES * (high - low)}
    optimum = minimize_scalar(lambda number: motion(number).heat, bounds=(low, high), method="bounded", options=options)
    return motion(float(optimum.x))


def _refuse_rests(cycle: _Cycle) -> None:
    if not cycle.legs.closed:
        raise PinpressError("path has rests, but this motion does not rest: give servo.Turn(), or take motion_by_law")


def _is_slack(cycle: _Cycle, window: _Window) -> bool:
    return cycle.way / cycle.stroke_time <= window.slowest


def _slow_turn(cycle: _Cycle, limit: SlideSpeed) -> tuple[_Cycle, _Window]:
    """A cycle of full turns, and the window of heights in which it must be slower than at a constant crank speed."""
    _refuse_rests(cycle)
    window = _window(cycle, limit)
    if _is_slack(cycle, window):
        even = cycle.way / cycle.stroke_time * window.speed / window.slowest
        raise PinpressError(
            f"limit is {window.speed:g} m/s, but at constant crank speed the slide reaches at most {even:.4g} m/s in the window:"
            " take constant_crank_speed, or give a lower speed or less time"
        )
    return cycle, window


def _refuse_short(cycle: _Cycle, working: float) -> None:
    if not working < (1 - 4 * LEAST_RAMP) * cycle.stroke_time:
        raise PinpressError(
            f"time is too short: a stroke has {cycle.stroke_time:g} s, but the window of heights alone takes {working:.6g} s at this slide"
            " speed; give more time, a higher speed or a smaller window"
        )
