"""The speed at which a press reaches a capacity.

At a given crank angle every force of a press that turns at constant speed w is R = A w^2 + c, A by inertia, c by weights and by process
loads that depend on the slide's height alone. So the speed at which one reaches its capacity is a root of a quadratic equation in w^2.
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
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..kinematics.motion import Motion, servo_cycle
from ..kinematics.slide_path import stroke_turns
from ..linkage.linkage import Linkage
from ..loads.link import Load
from ..loads.process import ProcessLoad
from .permissible_force import BEARING, TORQUE, Capacities, known_bearings, largest_factor, without_masses

SHAKING, ACCELERATION = "shaking force", "slide acceleration"
STATES = 360  # of a turn
AROUND = 9  # states in which the neighbourhood of the worst is looked at
ROUNDS = 8  # each divides the neighbourhood by four: a degree to 3e-7 rad, whose square counts
NEARLY = 1.05  # times the least squared speed: what is further between the states is not the least
NOTHING = 1e-12  # of the largest force by inertia: less is rounding
FAST = 100.0  # times the speed at which inertia forces are as large as weights, about


@dataclass(frozen=True, repr=False)
class PermissibleSpeed(Record, units={"speed": "rad/s", "crank_angle": "rad"}):
    """The highest speed at which a press keeps every capacity.

    Attributes:
        speed: of the driver joint [rad/s].
        limited_by: "torque", "bearing NAME", "slide acceleration" or "shaking force".
        crank_angle: at which that is reached, from 0 to the end of the period, which mostly is 2 pi [rad].
        turns: of the driver joint from stroke to stroke; where there is no slide, those of the period.
    """

    speed: float
    limited_by: str
    crank_angle: float
    turns: int = 1

    @property
    def strokes_per_minute(self) -> float:
        """Mostly one a turn of the driver joint."""
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
    """The highest constant speed at which torque, bearings, slide acceleration and shaking force keep to their capacities over a period.

    Args:
        press: with one driver.
        capacities: what its parts can bear; nominal force and height and the energies limit no speed.
        torque: capacity at the driver joint [N m], where it is not among the capacities: `Ratings.torque_capacity`.
        loads: process loads whose forces depend on height and direction of travel alone; by default the press runs idle.
        engine: as in `cycle`.

    Returns:
        None where no speed reaches a capacity. The worst crank angle is found to rounding between the states, loads whose edges are
        closer than a degree to one another apart.

    Raises:
        PinpressError: the press is beyond a capacity at any speed, by weights and loads; a load that depends on the speed.
        UnknownNameError: a bearing that the press does not have.
        SingularityError: the linkage locks within the period.
    """
    known_bearings(capacities, press)
    if len(press.drivers) > 1:
        raise PinpressError(f"{press.name} has {len(press.drivers)} drivers: ratings are those of a press with one")
    if torque is not None:
        positive("torque", torque, "N m")
        if capacities.torque is not None:
            raise PinpressError("torque is among the capacities already: leave one out")
    return limiting_speed(press, capacities, capacities.torque if torque is None else torque, 1.0, loads, engine)


def limiting_speed(
    press: Linkage, capacities: Capacities, torque: float | None, way: float, loads: Sequence[ProcessLoad] = (), engine: str = "auto"
) -> PermissibleSpeed | None:
    """The highest speed as `speed_limit` finds it, with the crank turning either way.

    Args:
        press: with one driver.
        capacities: as of `speed_limit`.
        torque: capacity at the driver joint [N m]; None: it limits nothing.
        way: 1 or -1, forwards or backwards, which decides where loads act.
        loads: as of `speed_limit`.
        engine: as in `cycle`.
    """
    turning = _TurningPress(press, capacities, torque, way, tuple(loads), engine)
    if not turning.limits_something:
        return None
    step, turns = 2 * np.pi / STATES, press.period_turns
    angle: Array = np.arange(STATES * turns, dtype=float) * step
    first = {item.name: item for item in _limits(turning, angle)}
    least = min(float(item.square.min()) for item in first.values())
    if not math.isfinite(least):
        return None
    names = [name for name, item in first.items() if item.square.min() <= NEARLY * least]
    best = np.array([float(first[name].square.min()) for name in names])
    centre = np.array([angle[int(first[name].square.argmin())] for name in names])
    offsets = np.linspace(-1.0, 1.0, AROUND)
    for _ in range(ROUNDS):  # all at once, each about its own worst state
        places = centre[:, None] + step * offsets
        again = {item.name: item.square.reshape(places.shape) for item in _limits(turning, places.ravel())}
        for k, name in enumerate(names):
            square = again[name][k]
            if square.min() <= best[k]:
                best[k], centre[k] = float(square.min()), float(places[k, int(square.argmin())])
        step *= 2 / (AROUND - 1)
    worst = int(np.argmin(best))
    return PermissibleSpeed(
        math.sqrt(best[worst]), names[worst], float(centre[worst]) % (2 * math.pi * turns), stroke_turns(press) or turns
    )


class _SpeedLimit(NamedTuple):
    """Something with a capacity, and the squares of the speeds (n,) at which it is reached [rad2/s2], infinite where it is not."""

    name: str
    square: Array


@dataclass(frozen=True, eq=False)
class _TurningPress:
    """A press that turns at constant speed under loads; see `limiting_speed`."""

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
        faster = servo_cycle(self.press, speed=2 * self.fast, angle=motion.crank_angle, engine=self.engine)
        again = self.reactions(self.massless, faster, self.loads)
        if np.abs(again.driving_torque - found.driving_torque).max() > NOTHING * np.abs(found.driving_torque).max():
            raise PinpressError("a load depends on the slide's speed: a limit of speed takes loads that depend on height alone")
        return found


def _limits(turning: _TurningPress, angle: Array) -> Iterator[_SpeedLimit]:
    """Everything that has a capacity, at crank angles (n,)."""
    press, capacities, square = turning.press, turning.capacities, turning.fast**2
    fast = servo_cycle(press, speed=turning.fast, angle=angle, engine=turning.engine)
    still = replace(fast, crank_speed=0 * fast.crank_speed, v=0 * fast.v, a=0 * fast.a)  # in the same poses
    at_rest, running, loaded = turning.reactions(press, still), turning.reactions(press, fast), turning.under_loads(fast)
    largest = max(float(np.abs(force - at_rest.bearing_force[name]).max()) for name, force in running.bearing_force.items())
    size = press.size

    def reached(name: str, running: Array, resting: Array, load: Array | float, capacity: float, unit: str, least: float) -> _SpeedLimit:
        slope = np.where(np.abs(running - resting) > least, running - resting, 0.0) / square
        constant = resting + load
        amount = np.linalg.norm(constant, axis=1)
        worst = int(amount.argmax())
        if amount[worst] > capacity:
            raise PinpressError(
                f"{name} is {amount[worst]:.6g} {unit} at crank angle {fast.crank_degrees[worst]:.6g} deg at any speed, by weights"
                f"{' and loads' if turning.loads else ''}, its capacity {capacity:.6g} {unit}: more capacity, or less load"
            )
        return _SpeedLimit(name, largest_factor(constant, slope, capacity))

    if turning.torque is not None:
        load = 0.0 if loaded is None else loaded.driving_torque[:, None]
        yield reached(
            TORQUE, running.driving_torque[:, None], at_rest.driving_torque[:, None], load, turning.torque, "N m", NOTHING * largest * size
        )
    for name in known_bearings(capacities, press):
        load = 0.0 if loaded is None else loaded.bearing_force[name]
        yield reached(
            BEARING + name,
            running.bearing_force[name],
            at_rest.bearing_force[name],
            load,
            capacities.bearings[name],
            "N",
            NOTHING * largest,
        )
    nothing = np.zeros((len(angle), 1))
    if capacities.slide_acceleration is not None:
        yield reached(ACCELERATION, fast.slide_acceleration[:, None], nothing, 0.0, capacities.slide_acceleration, "m/s2", 0.0)
    if capacities.shaking_force is not None:  # of inertia alone; process loads do not reach the foundation
        shaking = running.shaking_force - at_rest.shaking_force
        yield reached(SHAKING, shaking, np.zeros_like(shaking), 0.0, capacities.shaking_force, "N", NOTHING * largest)
