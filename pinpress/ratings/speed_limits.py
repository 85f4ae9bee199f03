"""The speed at which a press reaches a capacity.

At a given crank angle every force of a press that turns at constant speed w is R = A w^2 + c. A comes from inertia, c from weights and from
process loads that depend on the slide's height alone. So the w^2 at which a force reaches its capacity is the root of a quadratic equation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
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
from .limits import Limit, bearing_limit, driver_limit, largest_factor, without_masses
from .permissible_force import NO_RATINGS, Capacities, known_bearings, refuse_by_driver, refuse_other_effort

NOTHING = 1e-12  # share of the largest force by inertia, below which forces are rounding errors


@dataclass(frozen=True, repr=False)
class PermissibleSpeed(Record, units={"speed": "rad/s", "crank_angle": "rad"}):
    """The highest speed at which a press keeps every capacity.

    Attributes:
        speed: speed of the driver joint [rad/s].
        limited_by: the capacity that is reached: "torque", "bearing NAME", "slide acceleration" or "shaking force".
        crank_angle: crank angle at which it is reached, from 0 to the end of the period, mostly 2 pi [rad].
        turns: turns of the driver joint from stroke to stroke, the mean if strokes differ; for a press without a slide, the turns of its
            period.
    """

    speed: float
    limited_by: str
    crank_angle: float
    turns: float = 1

    @property
    def strokes_per_minute(self) -> float:
        """Strokes in a minute at this speed; usually a stroke takes one turn of the driver joint."""
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
        torque: torque capacity at the driver joint, if ``capacities`` does not contain it, e.g. `PressRatings.torque_capacity` [N m].
        loads: process loads whose forces depend only on height and direction of travel; by default the press runs idle.
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
        torque: torque capacity at the driver joint [N m]; None: no limit.
        way: 1 forwards, -1 backwards, which decides where loads act.
        loads: as for `speed_limit`, or springs without damping and constant forces.
        engine: as in `cycle`.
    """
    limits = [] if torque is None else [driver_limit(press, press.driver, torque)]
    limits += [bearing_limit(name, capacities.bearings[name]) for name in known_bearings(capacities, press)]
    if not limits and capacities.slide_acceleration is None and capacities.shaking_force is None:
        return None
    if limits and press.uneven:
        press.refuse_contacts(
            "with them bearing forces are not linear in the squared speed; ratings.rate(..., at_speed=True) checks one speed"
        )
    gravity = float(np.linalg.norm(press.model.gravity.linear))
    fast = way * (100 * math.sqrt(gravity / press.size) if gravity else 1.0)  # inertia forces are much larger than weights
    turning = _TurningPress(press, without_masses(press), capacities, tuple(limits), fast, tuple(loads), engine)

    # All limits in 360 states of a turn. Limits above 1.05 times the least squared speed cannot fall below it between two states.
    step, turns = 2 * np.pi / 360, press.period_turns
    angle: Array = np.arange(360 * turns, dtype=float) * step
    first = turning.squared_speeds(angle)
    least = min(float(square.min()) for square in first.values())
    if not math.isfinite(least):
        return None
    names = [name for name, square in first.items() if square.min() <= 1.05 * least]
    best = np.array([float(first[name].min()) for name in names])
    centre = np.array([angle[int(first[name].argmin())] for name in names])
    for _ in range(8):  # each round divides the interval by four: from a degree to 3e-7 rad; the error is its square
        places = centre[:, None] + step * np.linspace(-1.0, 1.0, 9)
        squares = turning.squared_speeds(places.ravel())
        for k, name in enumerate(names):
            square = squares[name].reshape(places.shape)[k]
            if square.min() <= best[k]:
                best[k], centre[k] = float(square.min()), float(places[k, int(square.argmin())])
        step /= 4
    worst = int(np.argmin(best))
    return PermissibleSpeed(
        math.sqrt(best[worst]), names[worst], float(centre[worst]) % (2 * math.pi * turns), stroke_turns(press) or turns
    )


class _TurningPress(NamedTuple):
    """A press that turns at constant speed under loads.

    Attributes:
        press: the press.
        massless: the press with links without mass.
        capacities: capacities of its parts.
        limits: limits of torque and bearings.
        fast: a speed at which weights are small compared with inertia forces [rad/s].
        loads: loads that depend on the slide's height alone.
        engine: as in `cycle`.
    """

    press: Linkage
    massless: Linkage
    capacities: Capacities
    limits: tuple[Limit, ...]
    fast: float
    loads: tuple[Load, ...]
    engine: str

    def squared_speeds(self, angle: Array) -> dict[str, Array]:
        """Squares of the speeds (n,) at which each limit is reached at crank angles (n,), infinite if no speed reaches it [rad2/s2].

        Raises:
            PinpressError: weights and loads alone exceed a capacity, or a load depends on the speed.
        """
        press, capacities = self.press, self.capacities
        fast = motion_through_change_points(press, angle, self.fast, engine=self.engine)
        still = replace(fast, crank_speed=0 * fast.crank_speed, v=0 * fast.v, a=0 * fast.a)  # in the poses of the motion
        resting, running = (inverse_dynamics(press, motion, engine=self.engine) for motion in (still, fast))
        loaded = self._under_loads(fast) if self.loads else None
        largest = max(float(np.abs(force - resting.bearing_force[name]).max()) for name, force in running.bearing_force.items())
        squares = {}
        for limit in self.limits:
            constant = limit.reaction(resting)
            inertia = limit.reaction(running) - constant
            constant = constant if loaded is None else constant + limit.reaction(loaded)
            amount = np.linalg.norm(constant, axis=1)
            worst = int(amount.argmax())
            if amount[worst] > limit.capacity:
                raise PinpressError(
                    f"{limit.name} is {amount[worst]:.6g} {limit.unit} at crank angle {fast.shown_position[worst]:.6g} deg at any speed, by"
                    f" weights{' and loads' if self.loads else ''}, but its capacity is {limit.capacity:.6g} {limit.unit}: raise the"
                    " capacity, or lower the load"
                )
            rounding = NOTHING * largest * (press.size if limit.unit == "N m" else 1.0)
            slope = np.where(np.abs(inertia) > rounding, inertia, 0.0) / self.fast**2
            squares[limit.name] = largest_factor(constant, slope, limit.capacity)
        if capacities.slide_acceleration is not None:
            slope = fast.slide_acceleration[:, None] / self.fast**2
            squares["slide acceleration"] = largest_factor(0 * slope, slope, capacities.slide_acceleration)
        if capacities.shaking_force is not None:  # by inertia alone, because process loads do not reach the foundation
            shaking = running.shaking_force - resting.shaking_force
            slope = np.where(np.abs(shaking) > NOTHING * largest, shaking, 0.0) / self.fast**2
            squares["shaking force"] = largest_factor(0 * slope, slope, capacities.shaking_force)
        return squares

    def _under_loads(self, motion: Motion) -> Reactions:
        """Reactions to the loads alone."""
        faster = motion_through_change_points(self.press, motion.crank_angle, 2 * self.fast, engine=self.engine)
        once, twice = (inverse_dynamics(self.massless, each, self.loads, engine=self.engine) for each in (motion, faster))
        if np.abs(twice.driving_torque - once.driving_torque).max() > NOTHING * np.abs(once.driving_torque).max():
            raise PinpressError("a load depends on the slide's speed: a speed limit takes only loads that depend on height alone")
        return once
