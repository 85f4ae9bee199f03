"""The path of the slide over a period: its dead centres and its working stroke."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from ..common.arguments import typed
from ..common.errors import PinpressError
from ..common.numerics import Numbers, bracketed_roots
from ..common.quantities import Array, ComplexArray
from ..common.results import Record
from ..engines.branch import out_of_branch
from ..linkage.linkage import Linkage
from ..linkage.memo import per_linkage
from .cycle import motion_through_change_points
from .periodic_curve import CrankMotion, Curve, curve, step_time, zeros

SAME = 1e-9  # share of a range below which values differ by rounding
ROUNDING = 4 * float(np.finfo(float).eps)  # rounding of a crank angle [rad]
SAMPLES = 720  # crank angles of a turn; two dead centres closer than half a degree would be missed
EQUAL = 1e-9  # share of the stroke below which slide positions differ by rounding


@dataclass(frozen=True, repr=False)
class DeadCentres(Record, units={"top_angle": "rad", "top_position": "m", "bottom_angle": "rad", "bottom_position": "m"}):
    """Outermost turning points of the slide over one period; of equally far ones the first. Of a press whose driver
    slides they are the outermost places of the slide within the driver's limits.

    Attributes:
        top_angle: angle of the driver joint at top dead centre, the upper end in an upright press, within the period
            [rad]; position of a driver that slides [m].
        top_position: position of the slide at top dead centre [m].
        bottom_angle: angle of the driver joint at bottom dead centre within the period [rad]; position of a driver that slides [m].
        bottom_position: position of the slide at bottom dead centre [m].
        turns: turns of the driver after which the slide repeats its motion; other links may be back only later (`Linkage.period_turns`).
            A fraction where a gear makes several equal strokes in a turn. 1 of a driver that slides, for there and back.
        strokes: strokes in these turns, down and up again. Several ones differ from each other, as under a knuckle that passes its straight
            position; a rise between them of less than a tenth of the longest one is a dwell, and begins no new stroke.
    """

    top_angle: float
    top_position: float
    bottom_angle: float
    bottom_position: float
    turns: float
    strokes: int = 1

    @property
    def strokes_per_turn(self) -> float:
        """Strokes in a turn of the driver [-]."""
        return self.strokes / self.turns

    @property
    def stroke(self) -> float:
        """Distance between the dead centres [m]."""
        return self.top_position - self.bottom_position


@dataclass(frozen=True, repr=False)
class DeadCentresOverTravel(DeadCentres, units=dict.fromkeys(DeadCentres.units, "m")):
    """Dead centres of a press whose driver slides. Attributes of `DeadCentres`; in place of angles the positions of the driver [m]."""


@typed
@per_linkage(of_geometry=True)
def dead_centres(press: Linkage) -> DeadCentres:
    """Dead centres of a press whose crank turns fully: zeros of the slide's speed, exact to rounding. They are kept with the press.

    Where the driver slides, the ends of its travel count too.

    Raises:
        PinpressError: the linkage has no slide or several drivers, its slide never turns back, or it is not back after many turns.
        SingularityError: the linkage locks within the period.
    """
    points = turning_points(press)
    top, bottom = (points.first_of_the_farthest(upwards) for upwards in (True, False))
    places, positions = points.places, points.positions
    kind = DeadCentres if press.driver_coordinates[0].turns else DeadCentresOverTravel
    ends = float(places[top]), float(positions[top]), float(places[bottom]), float(positions[bottom])
    return kind(*ends, points.turns, len(points.strokes))


class TurningPoints(NamedTuple):
    """Where the slide turns back in one period; of a press whose driver slides within its limits, the limits first.

    Attributes:
        places: (m,) angles of the driver joint within the period [rad]; positions of a driver that slides [m].
        positions: (m,) of the slide there [m].
        limits: how many of them, the first ones, are the driver's limits, where the slide need not turn back by itself.
        near: difference of position below which two are equally far [m].
        turns: of the driver after which the slide repeats its motion, see `DeadCentres`.
        strokes: of these turns, each with its upper and its lower dead centre, counted among the turning points.
    """

    places: Array
    positions: Array
    limits: int
    near: float
    turns: float
    strokes: tuple[tuple[int, int], ...]

    def first_of_the_farthest(self, upwards: bool) -> int:
        """The first of the uppermost or lowermost ones."""
        along = self.positions if upwards else -self.positions
        return int(np.argmax(along >= along.max() - self.near))


@per_linkage(of_geometry=True)
def turning_points(press: Linkage) -> TurningPoints:
    """The turning points of a slide. Raises as `dead_centres`."""
    _ = press.slide_guide  # it has a slide
    press.refuse_several_drivers(
        "alone they have no dead centre; see the lowest state of their motion, servo_cycle(press, angle, time=time)"
    )
    if not press.driver_coordinates[0].turns:
        return _within_travel(press)
    period = press.branch_through_change_points.period
    if period is None:
        raise out_of_branch(press.branch_through_change_points, upwards=press.branch_through_change_points.locks[True] is not None)

    # A press is often drawn at a dead centre: a grid that starts off the drawn pose has no sample on it.
    samples = np.linspace(0.0, period, round(SAMPLES * period / (2 * np.pi)) + 1) - 0.38 * np.pi / SAMPLES
    way, speeds, _ = _slide(press, samples)
    turning = np.flatnonzero(np.signbit(speeds[:-1]) != np.signbit(speeds[1:]))
    if len(turning) < 2 or np.ptp(way) <= SAME * press.size:  # a slide that stands still turns back by rounding alone
        raise PinpressError(f"the slide of {press.name} does not turn back within its period: it has no dead centres")
    angles = bracketed_roots(lambda angle: _slide(press, angle)[1:], samples[turning], samples[turning + 1], absolute=ROUNDING)
    positions = _slide(press, angles)[0]
    angles = np.where(np.abs(angles) < 1e-12, 0.0, angles % period)  # 0 and not 360 degrees for a press that is drawn there
    near, repeats = EQUAL * float(np.ptp(positions)), 1
    for parts in range(len(angles) // 2, 1, -1):
        if len(angles) % (2 * parts) == 0 and np.abs(_slide(press, samples + period / parts)[0] - way).max() <= near:
            repeats = parts
            break
    turns = Fraction(round(period / (2 * np.pi)), repeats)
    points = TurningPoints(angles, positions, 0, near, turns.numerator if turns.denominator == 1 else float(turns), ())
    order = np.argsort(angles)[: len(angles) // repeats]
    return _with_strokes(points, order.tolist())


def _within_travel(press: Linkage) -> TurningPoints:
    """Turning points of a press whose driver slides."""
    low, high = press.branch_through_change_points.angles[[0, -1]]
    samples = np.linspace(low, high, SAMPLES + 1)
    speeds = _slide(press, samples)[1]
    turning = np.flatnonzero(np.signbit(speeds[:-1]) != np.signbit(speeds[1:]))
    places = np.array([low, high])
    if len(turning):
        ends, rounding = (samples[turning], samples[turning + 1]), ROUNDING * press.size
        places = np.append(places, bracketed_roots(lambda position: _slide(press, position)[1:], *ends, absolute=rounding))
    positions = _slide(press, places)[0]
    if not np.ptp(positions) > EQUAL * press.size:
        raise PinpressError(f"the slide of {press.name} does not move with its driver: it has no dead centres")
    there = np.argsort(places).tolist()
    return _with_strokes(TurningPoints(places, positions, 2, 0.0, 1, ()), [*there, *there[-2:0:-1]])


def _with_strokes(points: TurningPoints, way: list[int]) -> TurningPoints:
    """The turning points with the strokes of a way through them that is repeated, counted among them."""
    # A slide that rises by less than a tenth of the stroke dwells: the die does not open for another part.
    heights, least = points.positions, 0.1 * float(np.ptp(points.positions))
    way = list(way)
    while len(way) > 2:
        swings = [abs(heights[one] - heights[before]) for before, one in zip([way[-1], *way], way, strict=False)]
        least_swing = int(np.argmin(swings))
        if swings[least_swing] >= least:
            break
        del way[least_swing], way[least_swing - 1 if least_swing else -1]
    if len(way) == 2:
        return points._replace(strokes=((points.first_of_the_farthest(True), points.first_of_the_farthest(False)),))
    first_top = 0 if heights[way[0]] > heights[way[1]] else 1
    way = [*way[first_top:], *way[:first_top]]
    return points._replace(strokes=tuple(zip(way[::2], way[1::2], strict=True)))


def _slide(press: Linkage, angle: Array) -> tuple[Array, Array, Array]:
    """Position of the slide and its first two derivatives by the crank angle, at crank angles (n,)."""
    motion = motion_through_change_points(press, angle, 1.0)
    return motion.slide_position, motion.slide_velocity, motion.slide_acceleration


def slide_turns(press: Linkage) -> float | None:
    """Turns of the driver after which the slide repeats its motion; for a linkage without dead centres the turns of its period, None where
    it has no period."""
    try:
        return dead_centres(press).turns
    except PinpressError:
        return press.turns_until_back


def stroke_turns(press: Linkage) -> float | None:
    """Turns of the driver for a stroke, of strokes that differ the mean; for a linkage without dead centres as `slide_turns`."""
    try:
        return 1.0 / dead_centres(press).strokes_per_turn
    except PinpressError:
        return press.turns_until_back


# ---------------------------------------------------------------------------------------------------------------------- strokes of a motion


class SlideMotion(CrankMotion, Protocol):
    """The part of a motion that measures of the slide need: a `CrankMotion` with the slide's motion along its guide's axis. A `Motion` is
    one. The arrays (n,) may be complex.

    Attributes:
        slide_position: (n,) [m].
        slide_velocity: (n,) [m/s].
        slide_acceleration: (n,) [m/s2].
    """

    @property
    def slide_position(self) -> Numbers: ...
    @property
    def slide_velocity(self) -> Numbers: ...
    @property
    def slide_acceleration(self) -> Numbers: ...


@dataclass(frozen=True, eq=False, repr=False)
class Stroke:
    """The way of a slide from one dead centre to the other. Travel counts from the start; speeds are in metres for each step from state to
    state.

    Attributes:
        path: slide position, rising along the stroke [m].
        start: place of the dead centre at which the stroke begins, counted in states.
        end: place of the dead centre at which it ends, larger than ``start``.
    """

    path: Curve
    start: complex
    end: complex

    @cached_property
    def nodes(self) -> Array:
        """Rising places (m,): start and end, and the states and extremes of speed between them. The speed is monotonic between
        neighbours."""
        return np.unique(np.concatenate([self._states, self.speed_extremes.real]))

    @cached_property
    def speed_extremes(self) -> ComplexArray:
        """Places (k,) of the local extremes of speed, without the dead centres."""
        backwards = np.signbit(self.path.at(self._states, 2)[2].real)
        before = np.flatnonzero(backwards[1:] != backwards[:-1])

        def turning(place: Numbers) -> tuple[ComplexArray, ComplexArray]:
            _, _, second, third = self.path.at(place)
            return second, third

        return zeros(turning, self._states[before], self._states[before + 1])

    @property
    def _states(self) -> Array:
        start, end = self.start.real, self.end.real
        return np.concatenate([[start], np.arange(np.floor(start) + 1, np.ceil(end)), [end]])

    @cached_property
    def length(self) -> complex:
        """Distance between the dead centres [m]."""
        return complex(self.travel(np.array([self.end]))[0])

    def travel(self, place: Numbers) -> ComplexArray:
        """Distance (m,) of places (m,) from the start [m]."""
        return np.asarray(self.path.at(place, 1)[0] - self._begin)

    def speed(self, place: Numbers) -> ComplexArray:
        """Speed (m,) at places (m,) [m for each step]."""
        return self.path.at(place, 1)[1]

    def place_at(self, travel: Numbers) -> ComplexArray:
        """Places (m,) at which the slide has moved by ``travel`` (m,) from the start, 0 to the length of the stroke [m]."""
        after = np.clip(np.searchsorted(self._travelled, travel.real), 1, len(self.nodes) - 1)

        def ahead(place: Numbers) -> tuple[ComplexArray, ComplexArray]:
            position, speed = self.path.at(place, 1)
            return position - (self._begin + travel), speed

        return zeros(ahead, self.nodes[after - 1], self.nodes[after])

    @cached_property
    def _begin(self) -> complex:
        return complex(self.path.at(np.array([self.start]), 1)[0][0])

    @cached_property
    def _travelled(self) -> Array:
        return self.travel(self.nodes).real


def slide_path(motion: SlideMotion) -> Curve:
    """Slide position over the period [m], or over that part of it after which the slide is back and other links are not.

    Raises:
        PinpressError: not one period at constant crank speed, no slide, a slide that does not turn back, or too few states.
    """
    time = step_time(motion)
    if not all(hasattr(motion, name) for name in ("slide_position", "slide_velocity", "slide_acceleration")):
        raise PinpressError(f"motion is a {type(motion).__name__} without the slide's position, velocity and acceleration: give a Motion")
    position, velocity, acceleration = motion.slide_position, motion.slide_velocity, motion.slide_acceleration
    real = not any(map(np.iscomplexobj, (position, velocity, acceleration, motion.crank_speed)))
    scaled = [np.asarray(values * scale) for values, scale in ((position, 1.0), (velocity, time), (acceleration, time**2))]
    states = _until_back(scaled)
    path = curve("the slide's position", scaled[0][:states], scaled[1][:states], scaled[2][:states], real)
    if len(path.turning_places) < 2:
        raise PinpressError("the slide does not turn back within the period: it has no dead centres, and no stroke to measure")
    return path


def working_stroke(motion: SlideMotion, downwards: bool = True) -> Stroke:
    """The stroke against the slide's direction, or along it where it is not ``downwards``.

    Raises:
        PinpressError: as `slide_path`; also where the slide turns back more than twice in the period.
    """
    path = slide_path(motion)
    places = path.turning_places
    if len(places) > 2:
        strokes = len(places) // 2
        hint = f"; of {strokes} equal strokes give a number of states that is a multiple of {strokes}" if path.states % strokes else ""
        raise PinpressError(
            f"the slide turns back {2 * strokes} times a period and has no one working stroke: stroke and dwell can be measured, not this"
            + hint
        )
    along = Curve(-path.coefficients if downwards else path.coefficients, path.real)
    start, end = (complex(place) for place in places[np.argsort(along.at(places, 1)[0].real)])
    return Stroke(along, start, end if end.real > start.real else end + path.states)


def _until_back(scaled: Sequence[Numbers]) -> int:
    """Number of states after which position, velocity and acceleration (n,) repeat themselves: a part of them, in which the slide goes down
    and up again."""
    count, rising = len(scaled[0]), scaled[1].real > 0
    for parts in range(int((rising != np.roll(rising, 1)).sum()) // 2, 1, -1):
        states, left = divmod(count, parts)
        if not left and all(np.abs(np.roll(x, states) - x).max() <= SAME * np.ptp(x.real) for x in scaled):
            return states
    return count
