"""The speed at which a press reaches a capacity.

At a given crank angle every force of a press that turns at constant speed w is R = A w^2 + c, where A comes from inertia and c from weights
and from process loads that depend on the slide's height alone. So w^2 at which a force reaches its capacity is the root of a quadratic
equation.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..common.arguments import positive, typed
from ..common.errors import PinpressError
from ..common.quantities import RPM, Array
from ..common.results import Record
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import motion_through_change_points
from ..kinematics.motion import Motion
from ..kinematics.slide_path import stroke_turns
from ..linkage.linkage import Linkage
from ..loads.link import Load
from ..loads.process import ProcessLoad
from .permissible_force import (
    BEARING,
    NO_RATINGS,
    TORQUE,
    Capacities,
    known_bearings,
    largest_factor,
    refuse_by_driver,
    refuse_other_effort,
    without_masses,
)

SHAKING, ACCELERATION = "shaking force", "slide acceleration"
STATES = 360  # states of a turn at which every limit is evaluated first
AROUND = 9  # states to each round of refining about the worst state
ROUNDS = 8  # rounds of refining; each divides the interval by four, in all from a degree to 3e-7 rad, whose square counts
NEARLY = 1.05  # times the least squared speed: between two states a limit above this cannot fall below the least
NOTHING = 1e-12  # forces below this share of the largest by inertia are rounding
FAST = 100.0  # times the speed at which inertia forces are about as large as weights


@dataclass(frozen=True, repr=False)
class PermissibleSpeed(Record, units={"speed": "rad/s", "crank_angle": "rad"}):
    """The highest speed at which a press keeps every capacity.

    Attributes:
        speed: speed of the driver joint [rad/s].
        limited_by: the capacity that is reached: "torque", "bearing NAME", "slide acceleration" or "shaking force".
        crank_angle: crank angle at which it is reached, from 0 to the end of the period, mostly 2 pi [rad].
        turns: turns of the driver joint from stroke to stroke, of strokes that differ the mean; for a press without a slide, those of its
            period.
    """

    speed: float
    limited_by: str
    crank_angle: float
    turns: float = 1

    @property
    def strokes_per_minute(self) -> float:
        """Strokes in a minute at this speed; mostly a stroke takes one turn of the driver joint."""
        return self.speed / RPM / self.turns


@typed
def speed_limit(
    press: Linkage,
    capacities: Capacities,
    *,
    torque: float | None = None,
    loads: Sequence[ProcessLoad] = (),
    engine: str = "auto",
) -> PermissibleSpeed | None:
    """Find the highest constant speed at which torque, bearings, slide acceleration and shaking force keep their capacities.

    The crank turns positively; for the other sense use `rate` at a negative speed.

    Args:
        press: a press with one driver.
        capacities: capacities of its parts. Nominal force and height, flywheel and motor limit no speed.
        torque: torque capacity at the driver joint where it is not among the capacities, as `PressRatings.torque_capacity` [N m].
        loads: process loads whose forces depend on height and direction of travel alone; by default the press runs idle.
        engine: as in `cycle`.

    Returns:
        The speed with the limit and the crank angle; None if no speed reaches a capacity. The crank angle is accurate within rounding
        error, except under loads with edges less than a degree apart.

    Raises:
        PinpressError: the press has several drivers, weights and loads alone exceed a capacity, a load depends on the speed, or an argument
            is not as described.
        UnknownNameError: the press has no such bearing.
        SingularityError: the linkage locks within the period.
    """
    known_bearings(capacities, press)
    press.refuse_several_drivers(NO_RATINGS)
    press.refuse_sliding_driver("a speed limit needs a crank; ratings.rate(press, speed, capacities, at_speed=True) checks one speed")
    refuse_by_driver(capacities)
    refuse_other_effort(capacities, press.driver_coordinates[0])
    if torque is not None:
        torque = positive("torque", torque, "N m")
        if capacities.torque is not None:
            raise PinpressError("torque is given twice, as argument and in capacities: leave one out")
    return limiting_speed(press, capacities, capacities.torque if torque is None else torque, 1.0, loads, engine)


def limiting_speed(
    press: Linkage, capacities: Capacities, torque: float | None, way: float, loads: Sequence[Load] = (), engine: str = "auto"
) -> PermissibleSpeed | None:
    """The highest speed as `speed_limit` finds it, with the crank turning forwards or backwards.

    Args:
        press: a press with one driver.
        capacities: as for `speed_limit`.
        torque: torque capacity at the driver joint [N m]; None: it limits nothing.
        way: 1 forwards, -1 backwards, which decides where loads act.
        loads: as for `speed_limit`, or springs without damping and constant forces.
        engine: as in `cycle`.
    """
    turning = _TurningPress(press, capacities, torque, way, tuple(loads), engine)
    if not turning.limits_something:
        return None
    step, turns = 2 * np.pi / STATES, press.period_turns
    angle: Array = np.arange(STATES * turns, dtype=float) * step
    first = _squared_speeds(turning, angle)
    least = min(float(square.min()) for square in first.values())
    if not math.isfinite(least):
        return None
    names = [name for name, square in first.items() if square.min() <= NEARLY * least]
    best = np.array([float(first[name].min()) for name in names])
    centre = np.array([angle[int(first[name].argmin())] for name in names])
    offsets = np.linspace(-1.0, 1.0, AROUND)
    for _ in range(ROUNDS):  # all at once, each about its own worst state
        places = centre[:, None] + step * offsets
        again = _squared_speeds(turning, places.ravel())
        for k, name in enumerate(names):
            square = again[name].reshape(places.shape)[k]
            if square.min() <= best[k]:
                best[k], centre[k] = float(square.min()), float(places[k, int(square.argmin())])
        step *= 2 / (AROUND - 1)
    worst = int(np.argmin(best))
    return PermissibleSpeed(
        math.sqrt(best[worst]), names[worst], float(centre[worst]) % (2 * math.pi * turns), stroke_turns(press) or turns
    )


@dataclass(frozen=True, eq=False)
class _TurningPress:
    """A press that turns at constant speed under loads.

    Attributes:
        press: the press.
        capacities: capacities of its parts.
        torque: torque capacity at the driver joint [N m]; None: it limits nothing.
        way: 1 forwards, -1 backwards.
        loads: loads that depend on the slide's height alone.
        engine: as in `cycle`.
    """

    press: Linkage
    capacities: Capacities
    torque: float | None
    way: float
    loads: tuple[Load, ...]
    engine: str

    @property
    def limits_something(self) -> bool:
        some = self.capacities
        return bool(some.bearings) or any(value is not None for value in (self.torque, some.slide_acceleration, some.shaking_force))

    @cached_property
    def massless(self) -> Linkage:
        return without_masses(self.press)

    @cached_property
    def fast(self) -> float:
        """A speed at which weights are small beside inertia forces [rad/s]."""
        gravity = float(np.linalg.norm(self.press.model.gravity.linear))
        return self.way * (FAST * math.sqrt(gravity / self.press.size) if gravity else 1.0)

    def reactions(self, press: Linkage, motion: Motion, loads: Sequence[Load] = ()) -> Reactions:
        return inverse_dynamics(press, motion, loads, engine=self.engine)

    def under_loads(self, motion: Motion) -> Reactions | None:
        """Reactions to the loads alone."""
        if not self.loads:
            return None
        found = self.reactions(self.massless, motion, self.loads)
        faster = motion_through_change_points(self.press, motion.crank_angle, 2 * self.fast, engine=self.engine)
        again = self.reactions(self.massless, faster, self.loads)
        if np.abs(again.driving_torque - found.driving_torque).max() > NOTHING * np.abs(found.driving_torque).max():
            raise PinpressError("a load depends on the slide's speed: a speed limit takes only loads that depend on height alone")
        return found


class _Loading(NamedTuple):
    """A quantity with a capacity, at crank angles (n,), as vectors of k components.

    Attributes:
        name: name of the limit.
        running: (n, k) values at the fast speed, without loads.
        resting: (n, k) values at rest, by weights alone.
        load: (n, k) values by loads alone, or 0.
        capacity: largest permitted magnitude.
        unit: unit of all these.
        rounding: size below which the share of inertia is rounding.
    """

    name: str
    running: Array
    resting: Array
    load: Array | float
    capacity: float
    unit: str
    rounding: float


def _squared_speeds(turning: _TurningPress, angle: Array) -> dict[str, Array]:
    """Squares of the speeds (n,) at which each limit is reached at crank angles (n,), infinite where it is not [rad2/s2]."""
    fast = motion_through_change_points(turning.press, angle, turning.fast, engine=turning.engine)
    return {loading.name: _squared_speed(turning, fast, loading) for loading in _loadings(turning, fast)}


def _loadings(turning: _TurningPress, fast: Motion) -> Iterator[_Loading]:
    """All quantities that have a capacity, in a motion at the fast speed."""
    press, capacities = turning.press, turning.capacities
    still = replace(fast, crank_speed=0 * fast.crank_speed, v=0 * fast.v, a=0 * fast.a)  # in the poses of the motion
    at_rest, running, loaded = turning.reactions(press, still), turning.reactions(press, fast), turning.under_loads(fast)
    largest = max(float(np.abs(force - at_rest.bearing_force[name]).max()) for name, force in running.bearing_force.items())
    if turning.torque is not None:
        load = 0.0 if loaded is None else loaded.driving_torque[:, None]
        torques = running.driving_torque[:, None], at_rest.driving_torque[:, None], load
        yield _Loading(TORQUE, *torques, turning.torque, "N m", NOTHING * largest * press.size)
    for name in known_bearings(capacities, press):
        load = 0.0 if loaded is None else loaded.bearing_force[name]
        forces = running.bearing_force[name], at_rest.bearing_force[name], load
        yield _Loading(BEARING + name, *forces, capacities.bearings[name], "N", NOTHING * largest)
    if capacities.slide_acceleration is not None:
        accelerations = fast.slide_acceleration[:, None], np.zeros((len(fast.crank_angle), 1)), 0.0
        yield _Loading(ACCELERATION, *accelerations, capacities.slide_acceleration, "m/s2", 0.0)
    if capacities.shaking_force is not None:  # of inertia alone; process loads do not reach the foundation
        shaking = running.shaking_force - at_rest.shaking_force
        yield _Loading(SHAKING, shaking, np.zeros_like(shaking), 0.0, capacities.shaking_force, "N", NOTHING * largest)


def _squared_speed(turning: _TurningPress, fast: Motion, loading: _Loading) -> Array:
    """Squares of the speeds (n,) at which one limit is reached.

    Raises:
        PinpressError: weights and loads alone exceed the capacity.
    """
    inertia = loading.running - loading.resting
    slope = np.where(np.abs(inertia) > loading.rounding, inertia, 0.0) / turning.fast**2
    constant = loading.resting + loading.load
    amount = np.linalg.norm(constant, axis=1)
    worst = int(amount.argmax())
    if amount[worst] > loading.capacity:
        raise PinpressError(
            f"{loading.name} is {amount[worst]:.6g} {loading.unit} at crank angle {fast.shown_position[worst]:.6g} deg at any speed, by"
            f" weights{' and loads' if turning.loads else ''}, but its capacity is {loading.capacity:.6g} {loading.unit}: raise the"
            " capacity, or lower the load"
        )
    return largest_factor(constant, slope, loading.capacity)
