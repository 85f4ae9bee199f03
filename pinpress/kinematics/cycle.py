"""Motions from those of the drivers: a period at constant speed, and any states along the branch of a linkage."""

from __future__ import annotations

import math
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import numbers, typed, whole_number
from ..common.errors import PinpressError, SingularityError
from ..common.quantities import Array, DriverCoordinate
from ..engines.branch import Branch, out_of_branch
from ..engines.engine import ClosedStates, Closure, Engine
from ..engines.pinocchio.engine import PinocchioEngine
from ..engines.planar.chain import Chain, find_chain, states_along
from ..engines.planar.engine import PlanarEngine
from ..engines.spatial.engine import SpatialEngine
from ..engines.structure import Structure
from ..linkage.assembly import MANY_TURNS, close_on_branch, follow_drivers, refuse_far
from ..linkage.linkage import Linkage
from ..linkage.memo import per_linkage
from .motion import Motion, SharedByMotions, closed_motion, shared_by_motions

ENGINES = (PlanarEngine, SpatialEngine, PinocchioEngine)
POINTS = 360  # states of a turn by default
MOST_POINTS = 10**7  # most states of one period: half a gigabyte for every quantity of a six-bar press


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
    constants = _constants(press)
    angles, speeds, accelerations, times = _period(press, constants, speed, points)
    turning = constants.branch.period is not None
    motion = _along_branch(
        press, constants, constants.branch, angles, speeds, accelerations, times, chosen or constants.engine, one_period=turning
    )
    return motion, constants.slide_rates


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
    """Largest speed [m/s] and acceleration [m/s2] of the slide where the crank turns at 1 rad/s, 0 of a linkage without a slide or without
    a crank that turns fully; and the coordinate of the first driver."""

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


def moved(
    press: Linkage,
    branch: Branch | None,
    angles: Array,
    speeds: Array | float,
    accelerations: Array | float,
    times: Array | None,
    engine: str | Engine,
    locked: dict[int, SingularityError] | None = None,
) -> Motion:
    """The motion with these driver angles, speeds and accelerations: (n,) along a ``branch``, where constant speeds may be one number and
    have the accelerations 0.0; (n, drivers) where there is no branch. ``locked``: of several drivers as of `follow_drivers`."""
    chosen = engine if isinstance(engine, ENGINES) else press.engine(cast(str, engine))  # which refuses what is none
    if branch is not None:
        return _along_branch(press, _constants(press), branch, angles, speeds, accelerations, times, chosen)
    with np.errstate(all="ignore"):  # what overflows is refused
        position = follow_drivers(press.engine(), press.structure, press.closed, angles, press.name, locked)
        v, a, gap, solved = chosen.rates(position, np.transpose(speeds), np.transpose(accelerations))
        _refuse_too_fast(press, a)
    return closed_motion(press, shared_by_motions(press), ClosedStates(position, v, a, solved=solved), gap, times, None)


class _Constants(NamedTuple):
    """What motions along a branch need of a linkage with one driver, together because every access to a linkage compares its model.

    ``turns`` is `Linkage.turns_until_back` where the branch has a period; ``chain`` is None if the linkage is no chain of dyads.
    """

    fixed: SharedByMotions
    branch: Branch
    structure: Structure
    engine: Engine
    slide_rates: _SlideRates
    turns: int | None
    chain: Chain | None


@per_linkage
def _constants(press: Linkage) -> _Constants:
    branch = press.branch
    turns = None if branch.period is None else press.turns_until_back
    return _Constants(
        fixed=shared_by_motions(press),
        branch=branch,
        structure=press.structure,
        engine=press.engine(),
        slide_rates=_slide_rates(press),
        turns=turns,
        chain=_chain(press),
    )


@per_linkage(of_geometry=True)
def _chain(press: Linkage) -> Chain | None:
    engine = press.engine()
    return find_chain(engine.equations, press.branch) if isinstance(engine, PlanarEngine) else None


def _along_branch(
    press: Linkage,
    constants: _Constants,
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
    turns = None if branch.period is None else press.turns_until_back if constants.turns is None else constants.turns
    chain = constants.chain if branch is constants.branch and engine is constants.engine else None
    if chain is not None and (one_period or _reaches(chain, constants.branch, angles)):
        with np.errstate(all="ignore"):  # what overflows is refused
            states, gap = states_along(chain, branch, angles, speeds, accelerations)
            _refuse_too_fast(press, states.a)
        return closed_motion(press, constants.fixed, states, gap, times, turns)
    closure = close_on_branch(engine, constants.structure, branch, angles, constants.fixed.linkage)
    with np.errstate(all="ignore"):
        v, a = _rates(closure, speeds, accelerations)
        _refuse_too_fast(press, a)
    states = ClosedStates(closure.position, v, a, closure.basis, closure.solved)
    return closed_motion(press, constants.fixed, states, closure.gap, times, turns)


def _reaches(chain: Chain, branch: Branch, angles: Array) -> bool:
    """Whether a chain of dyads closes at these angles."""
    far = MANY_TURNS * 2 * np.pi
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
    press: Linkage, constants: _Constants, speed: float | ArrayLike, points: int | None
) -> tuple[Array, Array | float, Array | float, Array]:
    """Angles, speeds, accelerations and times (n,) of `cycle`; constant speeds and accelerations are one number."""
    branch, rate = constants.branch, float(speed) if isinstance(speed, float) and math.isfinite(speed) else _one_speed(press, speed)
    if not branch.coordinate.turns:
        return _there_and_back(branch, rate, points)
    if branch.period is None:  # a prescribed turn does not go through change points
        raise out_of_branch(branch, rate > 0, press.branch_through_change_points)
    turns = press.period_turns if constants.turns is None else constants.turns
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
