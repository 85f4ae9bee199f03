"""The motion of a linkage, closed in every state and with exact rates, from the motion of its drivers; and the poses of its bodies."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, NamedTuple, cast

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..common import plausibility, tables
from ..common.arguments import numbers, typed, whole_number
from ..common.errors import PinpressError
from ..common.frozen import read_only
from ..common.quantities import Array, DriverCoordinate
from ..common.results import Tabular
from ..engines.branch import Branch, out_of_branch
from ..engines.engine import LOOSEST, ClosedStates, Closure, Engine
from ..engines.joints import Axis, Slot, configuration
from ..engines.pinocchio.engine import PinocchioEngine
from ..engines.pinocchio.model import SpatialModel
from ..engines.planar.chain import Chain, ChainClosure, ChainStates, chain_of
from ..engines.planar.engine import PlanarEngine
from ..engines.spatial.engine import SpatialEngine
from ..linkage.assembly import MANY_PERIODS, closed, followed_from, refuse_far
from ..linkage.linkage import NAME_A_SLIDE, Linkage, SlideGuide
from ..linkage.memo import per_linkage

ENGINES = (PlanarEngine, SpatialEngine, PinocchioEngine)
POINTS = 360  # states of a turn by default
MOST_IN_TITLE = 3  # drivers whose ranges are written out in a title
MOST_POINTS = 10**7  # most states of one period: half a gigabyte for every quantity of a six-bar press


class ClosedFor(NamedTuple):
    """The linkage whose loops were closed in the states of a motion, and these states with what its engine kept of closing them."""

    press: Linkage
    states: ClosedStates


@dataclass(frozen=True, eq=False, repr=False)
class Motion(Tabular):
    """Closed states of a linkage, n of them. All arrays are read-only.

    Attributes:
        linkage: name of the linkage.
        drivers: names of its driver joints.
        driver_coordinates: what their coordinates are: crank angles [rad], or positions of drivers that slide [m].
        joints: names of all joints, in the order of ``v``.
        crank_angle: (n,) angle of the driver joint, unwrapped [rad]; of a driver that slides its position [m]. Angle, speed and
            acceleration are (n, drivers) for several drivers.
        crank_speed: (n,) speed of the driver joint [rad/s or m/s].
        crank_acceleration: (n,) acceleration of the driver joint [rad/s2 or m/s2].
        joint_position: (n, nv) joint coordinates, zero in the drawn pose, angles unwrapped [rad or m].
        v: (n, nv) joint rates in Pinocchio's order [rad/s or m/s].
        a: (n, nv) joint accelerations in Pinocchio's order [rad/s2 or m/s2].
        q: (n, nq) Pinocchio's configurations.
        closure_error: (n,) largest distance between the two sides of a loop [m].
        time: (n,) time of the states [s]. Reading it raises PinpressError for states that have no time, see `servo_cycle`.
        slide_position: (n,) position of the slide link's origin along its guide in world coordinates, positive upwards (see
            `Linkage.slide_direction`) [m]. Reading it, or velocity or acceleration, raises PinpressError where the linkage has no slide.
        slide_velocity: (n,) velocity of the slide in this direction [m/s].
        slide_acceleration: (n,) acceleration of the slide in this direction [m/s2].
        period_turns: turns of the crank in a period, see `Linkage.period_turns`; None where the linkage has no period, or several drivers.
    """

    linkage: str
    drivers: tuple[str, ...]
    driver_coordinates: tuple[DriverCoordinate, ...]
    joints: tuple[str, ...]
    crank_angle: Array
    crank_speed: Array
    crank_acceleration: Array
    joint_position: Array
    v: Array
    a: Array
    closure_error: Array
    _time: Array | None
    _slots: tuple[Slot, ...]
    _guide: SlideGuide | None
    period_turns: int | None
    # Not taken over by dataclasses.replace: a motion with other positions must not keep the closure of this one.
    _closed_for: ClosedFor | None = field(default=None, init=False)

    @property
    def title(self) -> str:
        slide = "" if self._guide is None else f", slide at {self.slide_position.min():.6g} to {self.slide_position.max():.6g} m"
        return f"Motion of {self.linkage}: {len(self.crank_angle)} states, {self._drivers_in_words()}{slide}"

    def _drivers_in_words(self) -> str:
        """Between which places every driver moves; of many drivers how many there are."""
        coordinates, several = self.driver_coordinates, len(self.drivers) > 1
        if len(coordinates) > MOST_IN_TITLE:
            return f"{len(coordinates)} drivers"
        places = np.reshape(self.crank_angle, (-1, len(coordinates))).T
        ranges = (f"{at.min() * each.scale:.6g} to {at.max() * each.scale:.6g}" for at, each in zip(places, coordinates, strict=True))
        names = self.drivers if several else (coordinates[0].part,)
        parts = zip(names, ranges, coordinates, strict=True)
        return ", ".join(f"{name} at {ends} {each.shown_unit}" for name, ends, each in parts)

    def states(self, press: Linkage) -> ClosedStates:
        """The states as an engine takes them, with what it kept when it closed them for this very linkage."""
        if self._closed_for is not None and self._closed_for.press is press:
            return self._closed_for.states
        return ClosedStates(self.joint_position.T, self.v.T, self.a.T)

    def __getstate__(self) -> dict[str, Any]:
        """The state for copies and pickles, which do not know the linkage."""
        return vars(self) | {"_closed_for": None}

    @property
    def time(self) -> Array:
        if self._time is None:
            raise PinpressError("these states are no motion in time (angle and speed do not fit together): pass time= to servo_cycle")
        return self._time

    @cached_property
    def q(self) -> Array:
        return read_only(configuration(self._slots, self.joint_position.T).T)

    @cached_property
    def slide_position(self) -> Array:
        guide, offset, sign = self._slide()
        return read_only(sign * self.joint_position[:, guide] + offset)

    @property
    def shown_position(self) -> Array:
        """(n,) crank angle within one period, from 0 to 360 deg times its turns; unwrapped where there is no period [deg]. Of a driver that
        slides it is its position [mm], of several drivers that of the first."""
        shown = self.crank_angle.reshape(len(self.crank_angle), -1)[:, 0] * self.driver_coordinates[0].scale
        return shown if self.period_turns is None else np.asarray(shown % (360.0 * self.period_turns))

    def place(self, state: int) -> str:
        """Where the driver is in a state, in words: "crank angle 30 deg", "driver position 12 mm"; of several drivers the time of a state
        that has one."""
        if len(self.drivers) > 1 and self._time is not None:
            return f"time {self._time[state]:.6g} s"
        first = self.driver_coordinates[0]
        return f"{first.position} {self.shown_position[state]:.6g} {first.shown_unit}"

    @property
    def slide_velocity(self) -> Array:
        return self._along_slide(self.v)

    @property
    def slide_acceleration(self) -> Array:
        return self._along_slide(self.a)

    def columns(self) -> dict[str, Array]:
        """Time, drivers, slide and closure error as (n,) columns under their names with units. Of a driver that slides they are
        driver_position, driver_speed and driver_acceleration."""
        columns = {} if self._time is None else {"time [s]": self._time}
        for order in range(3):
            columns |= self._of_drivers(order)
        if self._guide is not None:
            columns |= {
                "slide_position [m]": self.slide_position,
                "slide_velocity [m/s]": self.slide_velocity,
                "slide_acceleration [m/s2]": self.slide_acceleration,
            }
        return columns | {"closure_error [m]": self.closure_error}

    def _of_drivers(self, order: int) -> dict[str, Array]:
        """Columns of all drivers: their positions (0), speeds (1) or accelerations (2)."""
        values = (self.crank_angle, self.crank_speed, self.crank_acceleration)[order]
        return tables.by_driver([each.heads[order] for each in self.driver_coordinates], values, self.drivers)

    def position_columns(self) -> dict[str, Array]:
        """The columns of where the drivers are, for tables beside those of the motion."""
        return self._of_drivers(0)

    @property
    def _pictured(self) -> tuple[str, ...]:
        return next(iter(self._of_drivers(0))), "slide_position [m]" if self._guide is not None else next(iter(self._of_drivers(1)))

    def to_mat(self, path: str | os.PathLike[str]) -> None:
        """Write a MATLAB file with one vector for each column, named without its unit, and the matrices q, v, a.

        Raises:
            PinpressError: a number is not finite, or the file cannot be written.
        """
        tables.write_mat(path, self.columns() | {"q": self.q, "v": self.v, "a": self.a})

    def _along_slide(self, rates: Array) -> Array:
        """(n,) rates of the slide, of those of all joints."""
        guide, _, sign = self._slide()
        return rates[:, guide] if sign > 0 else read_only(-rates[:, guide])

    def _slide(self) -> SlideGuide:
        if self._guide is None:
            raise PinpressError(f"{self.linkage} has no slide: {NAME_A_SLIDE}")
        return self._guide


@typed
def cycle(press: Linkage, speed: float | None = None, *, points: int | None = None, engine: str = "auto") -> Motion:
    """Move a press through one period at constant speed; one whose driver slides there and back.

    The period is one turn of the crank, or several turns where gear ratios bring the linkage back only after these
    (`Linkage.period_turns`). So extremes over it are those of all turns. It begins at crank angle 0 and goes on in equal steps; the end,
    which is the beginning of the next period, is left out.

    A driver that slides moves harmonically from the lower limit of its joint to the upper one and back, in equal steps of time; ``speed``
    is its highest speed, in the middle. For another motion over time, such as approach, pressing and return, use `servo_cycle`.

    Args:
        press: the press, with one driver.
        speed: speed of the driver joint [rad/s or m/s]; negative to turn backwards, or to begin at the upper limit. It must be given.
        points: number of states; by default 360 for each turn, and 360 in all for a driver that slides there and back.
        engine: as of `inverse_dynamics`: "plane", "space", "pinocchio", or "auto", the fastest.

    Raises:
        PinpressError: there is no speed, or it is 0; fewer than two points; several drivers; the linkage is not back after many turns; the
            motion is too fast for floating point; an unknown or unsuitable engine.
        SingularityError: the linkage locks within the period, or before the driver's limits.
        AssemblyError: the loops do not close.

    Warns:
        PinpressWarning: the speed is hardly meant: the slide is faster than 3 m/s and accelerated by more than 40 g, or the speed is above
            1000 rad/s, or 10 m/s.
    """
    motion, slide_rates = _over_period(press, speed, points, engine)
    _doubt(slide_rates, speed if isinstance(speed, float) else motion.crank_speed)
    return motion


def period_at(press: Linkage, speed: float | None, points: int | None = None, engine: str = "auto") -> Motion:
    """`cycle` at a speed that the caller of the library has not chosen, of which nobody is warned; arguments and errors as there."""
    return _over_period(press, speed, points, engine)[0]


def _over_period(press: Linkage, speed: float | None, points: int | None, engine: str) -> tuple[Motion, _SlideRates]:
    """`period_at`, and how fast the slide is."""
    # one that does not suit is refused before anything is computed
    chosen = None if isinstance(engine, str) and engine == "auto" else press.engine(engine)
    if speed is None:
        unit, such = ("rad/s", "7.0") if press.driver_coordinates[0].turns else ("m/s", "0.1")
        raise PinpressError(f"cycle needs the speed of the driver [{unit}]: give one number for a period, cycle(press, {such})")
    known = _known(press)
    angles, speeds, accelerations, times = _period(press, known, speed, points)
    turning = known.branch.period is not None
    motion = _along_branch(press, known, known.branch, angles, speeds, accelerations, times, chosen or known.engine, one_period=turning)
    return motion, known.slide_rates


def motion_through_change_points(
    press: Linkage,
    angle: Array,
    speed: Array | float,
    acceleration: Array | float = 0.0,
    time: Array | None = None,
    engine: str = "auto",
) -> Motion:
    """A motion of a linkage with one driver through states (n,), also through change points, where momentum carries the linkage on: see
    `Linkage.branch_through_change_points`. Without ``time`` the states have none. Nobody is warned of the speed."""
    refuse_far("angle", angle, press.driver_coordinates)
    speeds, accelerations = (np.broadcast_to(values, angle.shape) for values in (speed, acceleration))
    return moved(press, press.branch_through_change_points, angle, speeds, accelerations, time, engine)


def doubt_speeds(press: Linkage, speeds: Array | float, motion: Motion | None = None) -> None:
    """Warn of speeds of a press's drivers [rad/s or m/s] that are hardly meant.

    Args:
        press: the press.
        speeds: the speeds, of any shape.
        motion: the only states at which they are reached; by default a crank may have them at any angle.
    """
    _doubt(_slide_rates(press), speeds, motion)


def _doubt(rates: _SlideRates, speeds: Array | float, motion: Motion | None = None) -> None:
    """`doubt_speeds` of a press whose slide has these rates."""
    fastest = abs(speeds) if isinstance(speeds, float) else float(np.abs(speeds).max())
    slide = _at_speed(rates, fastest)
    if motion is not None and plausibility.too_hard(*slide):
        slide = float(np.abs(motion.slide_velocity).max()), float(np.abs(motion.slide_acceleration).max())
    plausibility.speeds("speed", fastest, rates.coordinate, slide)


def slide_at(press: Linkage, speed: float) -> tuple[float, float]:
    """Largest speed [m/s] and acceleration [m/s2] of the slide while the crank turns at a constant speed [rad/s]; 0 of a linkage without a
    slide, or without a crank that turns fully."""
    return _at_speed(_slide_rates(press), speed)


def _at_speed(rates: _SlideRates, speed: float) -> tuple[float, float]:
    return rates.speed * speed, rates.acceleration * speed * speed  # infinite where ** 2 would raise OverflowError


class _SlideRates(NamedTuple):
    """How fast the slide is where the crank turns at 1 rad/s; 0 of a linkage without a slide, or without a crank that turns fully.

    Attributes:
        speed: its largest speed [m/s].
        acceleration: its largest acceleration [m/s2].
        coordinate: of the first driver.
    """

    speed: float
    acceleration: float
    coordinate: DriverCoordinate


@per_linkage(of_geometry=True)
def _slide_rates(press: Linkage) -> _SlideRates:
    coordinate = press.driver_coordinates[0]
    if press.slide is None or len(press.drivers) > 1 or not coordinate.turns or press.branch.period is None:
        return _SlideRates(0.0, 0.0, coordinate)
    _, first, half_second, *_ = np.abs(press.branch.coefficients[:, press.slide_guide.joint]).max(axis=1)
    return _SlideRates(float(first), 2.0 * float(half_second), coordinate)


def of_states(
    press: Linkage, position: Array, v: Array, a: Array, gap: Array, times: Array | None, period_turns: int | None = None
) -> Motion:
    """The motion with these closed states.

    Args:
        press: the linkage.
        position: (nv, n) joint coordinates [rad or m].
        v: (nv, n) joint rates [rad/s or m/s].
        a: (nv, n) joint accelerations [rad/s2 or m/s2].
        gap: (n,) largest gaps of a loop [m].
        times: (n,) [s], None where the states have no time.
        period_turns: turns of the crank in a period, None for none.
    """
    return _of_states(_same_in_all_motions(press), position, v, a, gap, times, period_turns)


def _of_states(
    fixed: _SameInAllMotions, position: Array, v: Array, a: Array, gap: Array, times: Array | None, period_turns: int | None
) -> Motion:
    """`of_states` of a linkage of which this is known."""
    drivers = fixed.indices
    for each in (position, v, a):  # views of them would else be made writable again
        each.setflags(write=False)
    return Motion(
        linkage=fixed.linkage,
        drivers=fixed.drivers,
        driver_coordinates=fixed.driver_coordinates,
        joints=fixed.joints,
        crank_angle=position[drivers].T,
        crank_speed=v[drivers].T,
        crank_acceleration=a[drivers].T,
        joint_position=position.T,
        v=v.T,
        a=a.T,
        closure_error=gap,
        _time=times,
        _slots=fixed.slots,
        _guide=fixed.guide,
        period_turns=period_turns,
    )


class _SameInAllMotions(NamedTuple):
    """What all motions of a linkage have in common, by the names of `Motion`.

    Attributes:
        indices: of the drivers in v, one number where there is one driver.
    """

    linkage: str
    drivers: tuple[str, ...]
    driver_coordinates: tuple[DriverCoordinate, ...]
    indices: int | list[int]
    joints: tuple[str, ...]
    slots: tuple[Slot, ...]
    guide: SlideGuide | None


@per_linkage
def _same_in_all_motions(press: Linkage) -> _SameInAllMotions:
    guide = None if press.slide is None else press.slide_guide
    indices = press.driver_indices[0] if len(press.drivers) == 1 else list(press.driver_indices)
    return _SameInAllMotions(press.name, press.drivers, press.driver_coordinates, indices, press.joints, press.slots, guide)


def as_prescribed(motion: Motion, press: Linkage) -> Motion:
    """The states of a motion as those of another linkage that moves alike. From a simulated run, which belongs to its press, only the
    motion is taken."""
    kept = {each.name: getattr(motion, each.name) for each in fields(Motion) if each.init}
    return Motion(**(kept | {"linkage": press.name, "period_turns": press.turns_until_back}))


def moved(
    press: Linkage,
    branch: Branch | None,
    angles: Array,
    speeds: Array | float,
    accelerations: Array | float,
    times: Array | None,
    engine: str | Engine,
) -> Motion:
    """The motion with these driver angles, speeds and accelerations: (n,) along a ``branch``, where constant speeds may be one number and
    have the accelerations 0.0; (n, drivers) where there is no branch."""
    chosen = engine if isinstance(engine, ENGINES) else press.engine(cast(str, engine))  # which refuses what is none
    if branch is not None:
        return _along_branch(press, _known(press), branch, angles, speeds, accelerations, times, chosen)
    with np.errstate(all="ignore"):  # what overflows is refused
        position = followed_from(press.engine(), press.spatial_model, press.closed, angles, press.name)
        v, a, gap, solved = chosen.rates(position, np.transpose(speeds), np.transpose(accelerations))
        _refuse_too_fast(press, a)
    return _closed_motion(press, _same_in_all_motions(press), ClosedStates(position, v, a, solved=solved), gap, times, None)


class _Known(NamedTuple):
    """What motions along a branch take of a linkage with one driver, in one place, because each look at a linkage compares its model.

    Attributes:
        fixed: what all motions have in common.
        branch: its branch.
        spatial_model: constants for Pinocchio's engine.
        engine: the fastest engine.
        slide_rates: how fast the slide is.
        turns: `Linkage.turns_until_back` where the branch has a period, else None.
        chain: the chain of dyads that the linkage is; None where it is none.
    """

    fixed: _SameInAllMotions
    branch: Branch
    spatial_model: SpatialModel
    engine: Engine
    slide_rates: _SlideRates
    turns: int | None
    chain: Chain | None


@per_linkage
def _known(press: Linkage) -> _Known:
    branch = press.branch
    turns = None if branch.period is None else press.turns_until_back
    return _Known(
        fixed=_same_in_all_motions(press),
        branch=branch,
        spatial_model=press.spatial_model,
        engine=press.engine(),
        slide_rates=_slide_rates(press),
        turns=turns,
        chain=_chain(press),
    )


@per_linkage(of_geometry=True)
def _chain(press: Linkage) -> Chain | None:
    engine = press.engine()
    return chain_of(engine.plane, press.branch) if isinstance(engine, PlanarEngine) else None


def _along_branch(
    press: Linkage,
    known: _Known,
    branch: Branch,
    angles: Array,
    speeds: Array | float,
    accelerations: Array | float,
    times: Array | None,
    engine: Engine,
    one_period: bool = False,
) -> Motion:
    """`moved` along a branch of a linkage of which this is known; ``one_period``: whether the angles, which nobody else has, are those of
    one period."""
    if isinstance(speeds, np.ndarray) and not np.any(accelerations) and np.all(speeds == speeds[0]):
        speeds, accelerations = float(speeds[0]), 0.0
    turns = None if branch.period is None else press.turns_until_back if known.turns is None else known.turns
    chain = known.chain if branch is known.branch and engine is known.engine else None
    if chain is not None and (one_period or _reaches(chain, known.branch, angles)):
        with np.errstate(all="ignore"):  # what overflows is refused
            states, gap = _on_chain(chain, known.branch, angles, speeds, accelerations)
            _refuse_too_fast(press, states.a)
        return _closed_motion(press, known.fixed, states, gap, times, turns)
    closure = closed(engine, known.spatial_model, branch, angles, known.fixed.linkage)
    with np.errstate(all="ignore"):
        v, a = _rates(closure, speeds, accelerations)
        _refuse_too_fast(press, a)
    states = ClosedStates(closure.position, v, a, closure.basis, closure.jacobian, closure.solved)
    return _closed_motion(press, known.fixed, states, closure.gap, times, turns)


def _closed_motion(
    press: Linkage, fixed: _SameInAllMotions, states: ClosedStates, gap: Array, times: Array | None, period_turns: int | None
) -> Motion:
    """The motion with these states, in which the loops of a linkage were closed; arguments as of `of_states`."""
    motion = _of_states(fixed, states.position, states.v, states.a, gap, times, period_turns)
    vars(motion)["_closed_for"] = ClosedFor(press, states)
    return motion


def _on_chain(
    chain: Chain, branch: Branch, angles: Array, speeds: Array | float, accelerations: Array | float
) -> tuple[ChainStates, Array]:
    """States of a chain of dyads, and the largest gaps (n,), found in pieces that stay in the cache."""
    closure = ChainClosure(chain, branch, read_only(angles.copy()))
    n, states = len(angles), ChainStates(closure, _copied(speeds), _copied(accelerations))
    if n <= chain.piece:
        return states, states.gap
    states.position, states.v, states.a = np.empty((3, len(chain.plane.parents), n))
    gap = np.empty(n)
    for start in range(0, n, chain.piece):
        some = slice(start, start + chain.piece)
        speed, acceleration = (rates[some] if isinstance(rates, np.ndarray) else rates for rates in (speeds, accelerations))
        part = ChainStates(ChainClosure(chain, branch, angles[some]), speed, acceleration)
        states.position[:, some], states.v[:, some], states.a[:, some], gap[some] = part.position, part.v, part.a, part.gap
    return states, read_only(gap)


def _copied(rates: Array | float) -> Array | float:
    """Rates that stay what they are where the caller changes his array later."""
    return read_only(rates.copy()) if isinstance(rates, np.ndarray) else rates


def _reaches(chain: Chain, branch: Branch, angles: Array) -> bool:
    """Whether a chain of dyads closes at these angles."""
    far = MANY_PERIODS * (branch.period or 0.0)
    low, high = (chain.low, chain.high) if branch.period is None else (-far, far)
    return bool(low <= np.minimum.reduce(angles) and np.maximum.reduce(angles) <= high)


def _refuse_too_fast(press: Linkage, a: Array) -> None:
    """Raise PinpressError where joint accelerations, which have the squares of the speeds in them, are not finite."""
    if not math.isfinite(np.add.reduce(a, axis=None)):
        raise PinpressError(f"the motion of {press.name} is too fast for floating point: lower speed and acceleration")


def _rates(closure: Closure, speed: Array | float, acceleration: Array | float) -> tuple[Array, Array]:
    """Joint rates and accelerations (nv, n) from those of the driver, (n,) or one number."""
    a = closure.second * (speed * speed)
    if isinstance(acceleration, np.ndarray):
        a += closure.first * acceleration
    return closure.first * speed, a


def _period(
    press: Linkage, known: _Known, speed: float | ArrayLike, points: int | None
) -> tuple[Array, Array | float, Array | float, Array]:
    """Angles, speeds, accelerations and times (n,) of `cycle`; constant speeds and accelerations are one number."""
    branch, rate = known.branch, float(speed) if isinstance(speed, float) and math.isfinite(speed) else _one_speed(press, speed)
    if not branch.coordinate.turns:
        return _there_and_back(branch, rate, points)
    if branch.period is None:  # a prescribed turn does not go through change points
        raise out_of_branch(branch, rate > 0, press.branch_through_change_points)
    turns = press.period_turns if known.turns is None else known.turns
    period = 2 * np.pi * turns
    if not (rate and math.isfinite(period / rate)):
        raise PinpressError(f"speed is {abs(rate):g}: a turn never ends; give another, 70 r/min are 70 * pinpress.RPM [rad/s]")
    count = POINTS * turns if points is None else whole_number("points", points, 2, MOST_POINTS)
    angles: Array = np.arange(count, dtype=float) * (math.copysign(period, rate) / count)
    return angles, rate, 0.0, angles / rate


def _one_speed(press: Linkage, speed: ArrayLike) -> float:
    given = numbers("speed", speed, unit=f"{press.driver_coordinates[0].unit}/s")
    if given.ndim:
        raise PinpressError("speed is an array, but a turn at constant speed takes one number: write servo_cycle for a servo motion")
    return float(given)


def _there_and_back(branch: Branch, rate: float, points: int | None) -> tuple[Array, Array, Array, Array]:
    """`_period` of a driver that slides, harmonically with the highest speed ``rate`` [m/s]."""
    for upwards in (False, True):
        if branch.locks[upwards] is not None:
            raise out_of_branch(branch, upwards)
    low, high = float(branch.angles[0]), float(branch.angles[-1])
    half = 0.5 * (high - low)
    frequency = abs(rate) / half  # [rad/s]
    if not (rate and math.isfinite(2 * np.pi / frequency)):
        raise PinpressError(f"speed is {abs(rate):g}: the travel never ends; give the highest speed of the driver [m/s], e.g. 0.1")
    count = POINTS if points is None else whole_number("points", points, 2, MOST_POINTS)
    phase: Array = np.arange(count, dtype=float) * (2 * np.pi / count)
    way = math.copysign(half, rate)
    positions = np.clip(0.5 * (low + high) - way * np.cos(phase), low, high)
    return positions, rate * np.sin(phase), way * frequency**2 * np.cos(phase), phase / frequency


# ---------------------------------------------------------------------------------------------------------------------- poses of the bodies


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of the bodies of all Pinocchio joints (0: the frame) in n states, in world axes.

    Attributes:
        rotation: (joints + 1, n, 3, 3) rotation matrices of the joints' frames.
        position: (joints + 1, n, 3) positions of the joints' frames [m].
    """

    rotation: Array
    position: Array

    def points(self, joint: int, point: Array) -> Array:
        """(n, 3) world position of a point (3,) fixed to the body of a joint, in that joint's frame [m]."""
        return np.asarray(self.rotation[joint] @ point + self.position[joint])


def poses(press: Linkage, joint_position: Array) -> Poses:
    """Poses of all bodies at joint coordinates (n, nv), from the placements of the model's joints."""
    model, n = press.model, len(joint_position)
    rotation, position = np.empty((model.njoints, n, 3, 3)), np.empty((model.njoints, n, 3))
    rotation[0], position[0] = np.eye(3), 0.0
    for j, (axis, moved) in enumerate(zip(press.axes, joint_position.T, strict=True), 1):
        parent = model.parents[j]
        rotation[j], position[j] = carried(model.jointPlacements[j], axis, moved, rotation[parent], position[parent])
    return Poses(rotation, position)


def rotation_of(press: Linkage, joint_position: Array, joint: int) -> Array:
    """Rotations (n, 3, 3) of the body of a Pinocchio joint at joint coordinates (n, nv)."""
    model, axes, found = press.model, press.axes, np.broadcast_to(np.eye(3), (len(joint_position), 3, 3))
    while joint:
        turned = model.jointPlacements[joint].rotation
        axis = axes[joint - 1]
        if axis.turns:
            turned = turned @ _turned(axis.direction, joint_position[:, joint - 1])
        found, joint = turned @ found, model.parents[joint]
    return found


def carried(place: pin.SE3, axis: Axis, moved: Array, rotation: Array, position: Array) -> tuple[Array, Array]:
    """Rotations (n, 3, 3) and positions (n, 3) of the body of a joint with this placement and axis, at coordinates (n,), from those of the
    body that carries it."""
    turned = rotation @ place.rotation
    shifted = position + rotation @ place.translation
    if axis.turns:
        return turned @ _turned(axis.direction, moved), shifted
    return turned, shifted + moved[:, None] * (turned @ axis.direction)


def bearing_points(press: Linkage, at: Poses) -> Array:
    """(bearings, n, 3) points where the bearing forces act, in the order of `Linkage.bearings`, world axes [m]: origins of the joint
    frames, then points of the loops."""
    joints = [at.position[j] for j in range(1, press.model.njoints)]
    return np.array([*joints, *(at.points(loop.joint1, loop.point1) for loop in press.loops)])


def refuse_other_joints(press: Linkage, motion: Motion) -> None:
    """Raise PinpressError where a motion is of a linkage with other joints or drivers."""
    if motion.joints != press.joints or motion.drivers != press.drivers:
        raise PinpressError(f"the motion is of {motion.linkage} with other joints than {press.name}: make it with cycle(press, ...)")


def refuse_motion_of_another(press: Linkage, motion: Motion) -> None:
    """Raise PinpressError where a motion is not of this linkage: of one with other joints or drivers, or of other lengths."""
    refuse_other_joints(press, motion)
    if motion._closed_for is not None and motion._closed_for.press is press:
        return
    open_by = press.engine().gaps(motion.joint_position.T)
    if not open_by.max() <= LOOSEST * press.size:
        worst = int(open_by.argmax())
        raise PinpressError(
            f"the motion leaves the loops of {press.name} open by {open_by[worst]:.3g} m at {motion.place(worst)}, so that it is one of"
            " other lengths, or with another zero: make it with cycle(press, ...) or servo_cycle(press, ...)"
        )


def point_motion(press: Linkage, motion: Motion, joint: int, point: Array) -> tuple[Array, Array]:
    """World position [m] and velocity [m/s], (n, 3) each, of a point (3,) fixed to the body of a Pinocchio joint (0: the frame)."""
    n = len(motion.crank_angle)
    if joint == 0:
        return np.broadcast_to(point, (n, 3)), np.zeros((n, 3))
    return press.engine().point_motion(motion.states(press), joint, point)


def loaded_bodies(press: Linkage) -> tuple[int, ...]:
    """The Pinocchio joints on whose bodies the bearing forces act, in the order of `Linkage.bearings`: the child of a joint, link2 of a
    loop."""
    return (*range(1, press.model.njoints), *(loop.joint2 for loop in press.loops))


def _turned(axis: Array, angle: Array) -> Array:
    """(n, 3, 3) rotations by angles (n,) about an axis, by Rodrigues' formula."""
    skew = pin.skew(axis)
    return np.asarray(np.eye(3) + np.multiply.outer(np.sin(angle), skew) + np.multiply.outer(1.0 - np.cos(angle), skew @ skew))
