"""Capacities of a press, as its builder or buyer states them, and the process force that they permit over the working stroke.

At a given angle and speed the driving torque and every bearing force are affine in the process force F: R = R0 + F R1. R0 are the reactions
of the idle press, and R1 those of its links without mass under a force of 1 N, so that neither is a difference of large numbers. A capacity
C lets F grow until |R0 + F R1| = C, a quadratic equation.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.arguments import positive, suitable_numbers
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.frozen import Frozen, FrozenMapping
from ..common.quantities import RPM, Array, DriverCoordinate
from ..dynamics.inputs import Inputs, written
from ..dynamics.inverse_dynamics import Reactions, inverse_dynamics
from ..kinematics.motion import Motion, moved
from ..kinematics.servo_motion import servo_cycle
from ..kinematics.slide_path import DeadCentres, dead_centres
from ..linkage.linkage import Linkage
from ..loads.process import ConstantForce

NOMINAL, TORQUE, DRIVING_FORCE, BEARING = "nominal force", "torque", "driving force", "bearing "
TURN = 360  # states of a turn in which the idle press is checked
ROUNDING = 4 * float(np.finfo(float).eps)  # accuracy of roots, absolute and relative
TIE = 1e-9  # relative difference up to which two limits count as equal
SAME = 1e-12  # relative difference by rounding between limits that are equal at every height
GAUSS = np.polynomial.legendre.leggauss(3)  # nodes and weights, with which the work between two states is found
UNITS = {
    "nominal_force": "N",
    "nominal_height": "m",
    "torque": "N m",
    "flywheel_inertia": "kg m2",
    "speed_drop": "-",
    "motor_power": "W",
    "slide_acceleration": "m/s2",
    "shaking_force": "N",
}


@dataclass(frozen=True)
class Capacities(Frozen):
    """Capacities of a press. A capacity that is None, and a bearing without one, limit nothing.

    Attributes:
        nominal_force: largest process force at any height [N].
        nominal_height: height above bottom dead centre from which downwards the crank's torque permits the nominal force [m].
        torque: torque capacity at the driver joint, in place of the nominal height [N m]; of a driver that slides its force, a plain
            number [N].
        bearings: name of a bearing or guide -> largest magnitude of the force in it, in a planar press the radial force [N].
        flywheel_inertia: moment of inertia of the flywheel reduced to the driver joint, without the linkage [kg m2].
        speed_drop: largest drop of the flywheel's speed in a stroke, divided by the speed [-]. It goes with the flywheel. Usual values are
            0.2 to 0.3 in single strokes and 0.1 to 0.15 in continuous ones.
        motor_power: power of the motor that restores the energy from stroke to stroke in continuous use [W]. Leave it out for single
            strokes, between which there is time enough.
        slide_acceleration: largest slide acceleration that tool and feed allow [m/s2].
        shaking_force: largest force on the foundation beside the weight [N].

    Raises:
        PinpressError: a number is not positive and finite, both torque and nominal height are given, one of flywheel and drop of speed is
            given without the other, or the drop is larger than the speed.
    """

    nominal_force: float
    nominal_height: float | None = None
    torque: float | None = None
    bearings: Mapping[str, float] = field(default_factory=lambda: FrozenMapping({}))
    flywheel_inertia: float | None = None
    speed_drop: float | None = None
    motor_power: float | None = None
    slide_acceleration: float | None = None
    shaking_force: float | None = None

    def __post_init__(self) -> None:
        for name, unit in UNITS.items():
            value = getattr(self, name)
            if value is not None or name == "nominal_force":
                object.__setattr__(self, name, positive(name, value, unit))
        if not isinstance(self.bearings, Mapping):
            raise PinpressError(f"bearings is {shown(self.bearings)}: give a mapping of names to forces [N], e.g. {{'A': 2e6}}")
        known = {name: positive(f"the capacity of bearing {shown(name)}", value, "N") for name, value in self.bearings.items()}
        object.__setattr__(self, "bearings", FrozenMapping(known))
        if self.torque is not None and self.nominal_height is not None:
            raise PinpressError("torque and nominal_height both state the torque capacity: leave one out")
        if (self.flywheel_inertia is None) != (self.speed_drop is None):
            raise PinpressError("flywheel_inertia and speed_drop go together: give both, or neither")
        if self.speed_drop is not None and self.speed_drop > 1.0:
            raise PinpressError(f"speed_drop is {self.speed_drop:g}: give a fraction of the speed, 1 or less")

    def energies(self, speed: float, turns: int = 1) -> dict[str, float]:
        """Work that a stroke may take from each source of energy, by the source's name [J].

        A flywheel that slows from w to (1 - d) w gives J w^2 (1 - (1 - d)^2) / 2; a motor of power P restores 2 pi P / w in a turn.

        Args:
            speed: speed of the driver joint [rad/s].
            turns: turns of the driver joint from stroke to stroke.
        """
        found = {}
        if self.flywheel_inertia is not None and self.speed_drop is not None:
            # d (2 - d), because 1 - (1 - d)^2 loses digits for a small drop
            found["flywheel energy"] = 0.5 * self.flywheel_inertia * speed**2 * self.speed_drop * (2.0 - self.speed_drop)
        if self.motor_power is not None:
            found["motor energy"] = self.motor_power * 2 * math.pi * turns / abs(speed)
        return found


def capacities_in_words(given: Capacities, coordinate: DriverCoordinate) -> Inputs:
    """The capacities of a press that are given, by their names; ``coordinate``: that of its driver."""
    named = {name: (name.replace("_", " "), unit) for name, unit in UNITS.items()}
    if not coordinate.turns:
        named["torque"] = DRIVING_FORCE, coordinate.effort_unit
    rows = [(words, written(value, unit)) for name, (words, unit) in named.items() if (value := getattr(given, name)) is not None]
    return [*rows, *((f"bearing {name}", written(force, "N")) for name, force in given.bearings.items())]


def known_bearings(capacities: Capacities, press: Linkage) -> tuple[str, ...]:
    """Names of the bearings with a capacity, in the press's order.

    Raises:
        PinpressError: ``capacities`` is not a `Capacities`.
        UnknownNameError: the press has no such bearing.
    """
    if not isinstance(capacities, Capacities):
        raise PinpressError(f"capacities is a {type(capacities).__name__}: give Capacities(nominal_force=...)")
    for name in capacities.bearings:
        if name not in press.bearings:
            raise UnknownNameError("bearing", name, press.bearings)
    return tuple(name for name in press.bearings if name in capacities.bearings)


@dataclass(frozen=True, eq=False, repr=False)
class RatedStroke:
    """The working stroke of a press that is rated.

    Attributes:
        press: the press, with one driver and a slide with one top and one bottom dead centre.
        capacities: its capacities.
        speed: speed of the driver joint, negative backwards [rad/s]; of a driver that slides its highest one, on the way to bottom dead
            centre [m/s].
        torque: torque capacity at the driver joint [N m], or force capacity of a driver that slides [N]; None: it limits nothing.
        at_speed: whether weights and inertia forces count.
        engine: as in `cycle`.
        top: crank angle of the dead centre at which the working stroke begins [rad]; position of a driver that slides [m].
        bottom: crank angle at which it ends, unwrapped: less than ``top`` where the crank turns backwards [rad]; position of a driver that
            slides [m].
        bottom_position: slide position at its end [m].
        turns: turns of the driver joint from stroke to stroke. The whole press may repeat itself only after several strokes, with different
            forces in each.
    """

    press: Linkage
    capacities: Capacities
    speed: float
    torque: float | None
    at_speed: bool
    engine: str
    top: float
    bottom: float
    bottom_position: float
    turns: int

    @cached_property
    def bearings(self) -> tuple[str, ...]:
        return known_bearings(self.capacities, self.press)

    @cached_property
    def energies(self) -> Mapping[str, float]:
        return self.capacities.energies(self.speed, self.turns)

    @cached_property
    def massless(self) -> Linkage:
        return without_masses(self.press)

    @property
    def coordinate(self) -> DriverCoordinate:
        return self.press.driver_coordinates[0]

    def motion(self, angle: Array) -> Motion:
        """The motion at crank angles (n,), at constant speed of the driver."""
        return servo_cycle(self.press, speed=self.speed, angle=angle, engine=self.engine)

    def in_operation(self, motion: Motion) -> Motion:
        """A motion at constant speed as the press makes it in operation: a driver that slides moves harmonically, as in `cycle`."""
        if self.coordinate.turns:
            return motion
        middle, half = 0.5 * (self.top + self.bottom), 0.5 * abs(self.bottom - self.top)
        beside = motion.crank_angle - middle
        speed = self.speed * np.sqrt(np.maximum(1.0 - (beside / half) ** 2, 0.0))
        acceleration = -((self.speed / half) ** 2) * beside
        return moved(self.press, self.press.branch, motion.crank_angle, speed, acceleration, None, self.engine)

    def height(self, motion: Motion) -> Array:
        """Heights (n,) above bottom dead centre, not below it by rounding [m]."""
        return np.maximum(motion.slide_position - self.bottom_position, 0.0)


def rated_stroke(press: Linkage, capacities: Capacities, speed: float, at_speed: bool, engine: str) -> RatedStroke:
    """The working stroke to be rated, with the torque capacity that a nominal height stands for.

    Raises:
        PinpressError: the nominal height is not between 0 and the stroke, or the slide turns back within the travel of a driver that
            slides.
    """
    ends = dead_centres(press)
    if press.driver_coordinates[0].turns:
        way = 1.0 if speed > 0 else -1.0
        bottom = ends.top_angle + way * ((way * (ends.bottom_angle - ends.top_angle)) % (2 * np.pi * ends.turns))
    else:
        speed, bottom = math.copysign(speed, ends.bottom_angle - ends.top_angle), ends.bottom_angle
        _refuse_turning_back(press, ends)
    given = RatedStroke(
        press=press,
        capacities=capacities,
        speed=speed,
        torque=capacities.torque,
        at_speed=at_speed,
        engine=engine,
        top=ends.top_angle,
        bottom=bottom,
        bottom_position=ends.bottom_position,
        turns=ends.turns,
    )
    if capacities.nominal_height is None:
        return given
    at = given.motion(np.array([angle_at(given, "nominal_height", capacities.nominal_height)]))
    needed = unit_force_reactions(without_masses(press), at, ends.bottom_position, (), engine).driving_torque[0]
    return replace(given, torque=capacities.nominal_force * abs(float(needed)))


def _refuse_turning_back(press: Linkage, ends: DeadCentres) -> None:
    """Raise PinpressError where the slide turns back within the travel of a driver that slides, so that it comes down on two ways."""
    low, high = (float(end) for end in press.branch_through_change_points.angles[[0, -1]])
    places = np.linspace(ends.top_angle, ends.bottom_angle, TURN + 1)
    speeds = servo_cycle(press, places, speed=ends.bottom_angle - ends.top_angle).slide_velocity
    travelled = abs(ends.bottom_angle - ends.top_angle)
    if travelled < (1 - TIE) * (high - low) or np.any(speeds[1:-1] >= 0):
        first, last, bottom = (press.driver_coordinates[0].shown(place) for place in (low, high, ends.bottom_angle))
        raise PinpressError(
            f"the slide of {press.name} turns back while its driver goes from {first} to {last}, and so has no one working stroke: let the"
            f" <limit> of joint {press.driver!r}, or the travel in its table, end where the slide turns back (bottom dead centre:"
            f" {bottom})"
        )


def angle_at(rated: RatedStroke, name: str, height: float) -> float:
    """Crank angle in the working stroke at a height above bottom dead centre, unwrapped [rad]; position of a driver that slides [m].

    Args:
        rated: the working stroke.
        name: name of the height, for messages.
        height: the height [m].

    Raises:
        PinpressError: the height is not between 0 and the stroke.
    """
    from scipy.optimize import brentq  # slow to import

    stroke = dead_centres(rated.press).stroke
    wanted = f"a height between 0 and the stroke of {stroke:.6g} m ({1e3 * stroke:.6g} mm)"
    suitable_numbers(name, height, wanted, suits=lambda value: 0.0 < value < stroke)

    def above(angle: float) -> float:
        return float(rated.motion(np.array([angle])).slide_position[0]) - rated.bottom_position - height

    return float(brentq(above, rated.top, rated.bottom, xtol=ROUNDING, rtol=ROUNDING))


def refuse_overloaded_idle(rated: RatedStroke) -> None:
    """Raise PinpressError where the idle press at its speed exceeds a capacity of torque or bearings anywhere in a period."""
    turning, stroke = rated.coordinate.turns, np.linspace(rated.top, rated.bottom, TURN)
    if turning:
        whole = rated.top + np.arange(TURN * rated.press.period_turns) * (2 * np.pi / TURN)
        motion, speed = rated.motion(np.concatenate([whole, stroke])), f"{abs(rated.speed) / RPM:.6g} r/min"
    else:  # on the way back a driver that slides takes the same forces
        motion, speed = rated.in_operation(rated.motion(stroke)), f"a highest speed of {1e3 * abs(rated.speed):.6g} mm/s"
    idle = inverse_dynamics(rated.press, motion, engine=rated.engine, bearings=rated.bearings)
    loads = (
        {}
        if rated.torque is None
        else {f"the driving {rated.coordinate.effort}": (np.abs(idle.driving_torque), rated.torque, rated.coordinate.effort_unit)}
    )
    for name in rated.bearings:
        force = np.linalg.norm(idle.bearing_force[name], axis=1)
        loads[f"the force in bearing {shown(name)}"] = force, rated.capacities.bearings[name], "N"
    for what, (size, capacity, unit) in loads.items():
        worst = int(size.argmax())
        if size[worst] > capacity:
            raise PinpressError(
                f"{what} of the idle press is {size[worst]:.6g} {unit} at {motion.place(worst)} and {speed}, but the capacity is"
                f" {capacity:.6g} {unit}: lower the speed, or raise the capacity"
            )


def permitted_forces(rated: RatedStroke, motion: Motion, energy: bool = True) -> dict[str, Array]:
    """Process force (n,) that each limit permits, by the limit's name, infinite where it permits any; the nominal force is first [N].

    Args:
        rated: the working stroke.
        motion: motion of the press, n states.
        energy: whether to add the forces that take all usable energy when they act from here to bottom dead centre.
    """
    strokes = (_in_one_stroke(rated, again) for again in _in_every_stroke(rated, motion))
    found = functools.reduce(lambda some, others: {name: np.minimum(force, others[name]) for name, force in some.items()}, strokes)
    if energy:
        height = rated.height(motion)
        with np.errstate(divide="ignore", over="ignore"):  # at height zero any force is permitted
            found |= {name: usable / height for name, usable in rated.energies.items()}
    return found


class GoverningLimits(NamedTuple):
    """Limits over the working stroke.

    Attributes:
        angle: (n,) crank angles from top to bottom dead centre [rad].
        forces: name of a limit -> (n,) process force that it permits, at most the nominal force [N].
        names: (n,) names of the limit that governs; where it changes, the limit that begins to govern.
        changes: indices of the states at which it changes.
    """

    angle: Array
    forces: dict[str, Array]
    names: tuple[str, ...]
    changes: tuple[int, ...]


def governing_limits(rated: RatedStroke, points: int) -> GoverningLimits:
    """Limits at ``points`` crank angles in equal steps, at the nominal height, and at the angles where another limit begins to govern."""
    height = rated.capacities.nominal_height
    marks = [] if height is None else [angle_at(rated, "nominal_height", height)]
    angle = _in_order(rated, np.concatenate([np.linspace(rated.top, rated.bottom, points), marks]))
    names = _governing(_capped(rated, angle))
    next_names: dict[float, str] = {}
    for k in range(len(angle) - 1):
        if names[k] != names[k + 1]:
            next_names |= dict(_changes(rated, names[k], names[k + 1], float(angle[k]), float(angle[k + 1])))
    every = _in_order(rated, np.concatenate([angle, list(next_names)]))
    forces = _capped(rated, every)
    # At a change two limits permit equal forces up to rounding, which must not decide which of them governs.
    governing = tuple(next_names.get(float(at), name) for at, name in zip(every, _governing(forces), strict=True))
    return GoverningLimits(every, forces, governing, tuple(k for k, at in enumerate(every) if float(at) in next_names))


def permitted_work(rated: RatedStroke, angle: Array) -> Array:
    """Work (n,) of the force that all limits but energy permit, from each of the crank angles (n,) to the last of them [J].

    It is integrated by Gauss's rule between the angles.
    """
    nodes, weights = GAUSS
    middle, half = 0.5 * (angle[1:] + angle[:-1]), 0.5 * np.abs(np.diff(angle))
    motion = rated.motion((middle[:, None] + 0.5 * np.diff(angle)[:, None] * nodes).ravel())
    forces = permitted_forces(rated, motion, energy=False)
    power = np.min(list(forces.values()), axis=0) * np.abs(motion.slide_velocity / rated.speed)
    steps = half * (power.reshape(-1, len(nodes)) @ weights)
    return np.append(np.cumsum(steps[::-1])[::-1], 0.0)


def unit_force_reactions(massless: Linkage, motion: Motion, bottom: float, bearings: tuple[str, ...] | None, engine: str) -> Reactions:
    """Reactions to a process force of 1 N at every height of a motion, without weights and inertia forces.

    Args:
        massless: the press with massless links, see `without_masses`.
        motion: motion of the press.
        bottom: slide position at bottom dead centre [m].
        bearings: as in `inverse_dynamics`.
        engine: as in `cycle`.
    """
    above = 2 * max(float(np.ptp(motion.slide_position)), float(np.abs(motion.slide_position - bottom).max()), massless.size)
    return inverse_dynamics(massless, motion, [ConstantForce(1.0, above, bottom)], engine=engine, bearings=bearings)


def without_masses(press: Linkage) -> Linkage:
    """The press with massless links, whose reactions are those to the loads alone."""
    return press.with_inertias([pin.Inertia.Zero()] * press.model.njoints)


def largest_factor(constant: Array, slope: Array, capacity: Array | float) -> Array:
    """Largest factors f (n,) with |constant + f slope| <= capacity, infinite where no factor is too large.

    With the vectors k and s divided by the capacity, f is the root >= 0 of f^2 s.s + 2 f k.s + k.k - 1 = 0, in the form that loses no
    digits.

    Args:
        constant: (n, k) vectors, whose magnitude is within the capacity.
        slope: (n, k) vectors.
        capacity: capacity, a number or (n,).
    """
    scale = np.reshape(capacity, (-1, 1))
    unit = np.abs(slope).max(axis=1, keepdims=True)
    unit = np.where(unit > 0, unit, 1.0)  # squares of small numbers underflow
    k, s = constant / scale, slope / unit
    square, half, free = np.sum(s * s, axis=1), np.sum(k * s, axis=1), np.maximum(1.0 - np.sum(k * k, axis=1), 0.0)
    root = np.sqrt(half**2 + square * free)
    with np.errstate(all="ignore"):  # the form that divides by zero is not taken; free / 0 means that nothing limits
        outwards = np.where((half + root > 0) | (free > 0), free / (half + root), np.inf)
        return np.where(half >= 0, outwards, (root - half) / square) * (scale / unit)[:, 0]


def _in_every_stroke(rated: RatedStroke, motion: Motion) -> Iterator[Motion]:
    """The motion, and that part of the stroke in the other strokes of the period."""
    yield motion
    strokes = rated.press.period_turns // rated.turns if rated.coordinate.turns else 1
    for stroke in range(1, strokes):
        yield rated.motion(motion.crank_angle + 2 * np.pi * rated.turns * stroke)


def _in_one_stroke(rated: RatedStroke, motion: Motion) -> dict[str, Array]:
    """The forces that torque, bearings and the nominal force permit in one stroke; see `permitted_forces`."""
    capacities, count = rated.capacities, len(motion.crank_angle)
    found = {NOMINAL: np.full(count, capacities.nominal_force)}
    unit = unit_force_reactions(rated.massless, motion, rated.bottom_position, rated.bearings, rated.engine)
    operating = rated.in_operation(motion) if rated.at_speed else None
    idle = None if operating is None else inverse_dynamics(rated.press, operating, engine=rated.engine, bearings=rated.bearings)
    if rated.torque is not None:
        before = np.zeros((count, 1)) if idle is None else idle.driving_torque[:, None]
        name = TORQUE if rated.coordinate.turns else DRIVING_FORCE
        found[name] = largest_factor(before, unit.driving_torque[:, None], rated.torque)
    for name in rated.bearings:
        before = np.zeros((count, 3)) if idle is None else idle.bearing_force[name]
        found[BEARING + name] = largest_factor(before, unit.bearing_force[name], capacities.bearings[name])
    return found if rated.coordinate.turns else _without_rounding(found)


def _without_rounding(forces: Mapping[str, Array]) -> dict[str, Array]:
    """Forces (n,) that limits permit, those that differ by rounding made equal.

    A cylinder in line with the slide bears the process force at every height, and rounding must not decide which of equal limits governs.
    """
    found: dict[str, Array] = {}
    for name, force in forces.items():
        for before in found.values():
            force = np.where(np.isclose(force, before, rtol=SAME, atol=0.0), before, force)
        found[name] = force
    return found


def _in_order(rated: RatedStroke, angles: Array) -> Array:
    """Crank angles in the order of the working stroke, each once."""
    rising = np.unique(angles)
    return (rising if rated.bottom > rated.top else rising[::-1]).copy()


def _changes(rated: RatedStroke, first: str, second: str, low: float, high: float) -> Iterator[tuple[float, str]]:
    """Crank angles between two at which another limit begins to govern, and that limit: the second one at last, others may come between."""
    at = _crossing(rated, first, second, low, high)
    forces = _capped(rated, np.array([at]))
    (least,) = _governing(forces)
    if at not in (low, high) and forces[least][0] < (1 - TIE) * min(forces[first][0], forces[second][0]):
        yield from _changes(rated, first, least, low, at)
        yield from _changes(rated, least, second, at, high)
    else:
        yield at, second


def _crossing(rated: RatedStroke, first: str, second: str, low: float, high: float) -> float:
    """Crank angle between two at which the second limit begins to permit less than the first."""
    from scipy.optimize import brentq  # slow to import

    def ahead(angle: float) -> float:
        """Force that the first limit permits beyond that of the second; forces count up to twice the nominal one."""
        found = permitted_forces(rated, rated.motion(np.array([angle])))
        one, other = (min(float(found[name][0]), 2 * rated.capacities.nominal_force) for name in (first, second))
        return one - other

    before, after = ahead(low), ahead(high)
    if before * after >= 0:  # the limits change exactly at a state
        return low if before == 0.0 else high
    return float(brentq(ahead, low, high, xtol=ROUNDING, rtol=ROUNDING))


def _capped(rated: RatedStroke, angle: Array) -> dict[str, Array]:
    return {name: np.minimum(force, rated.capacities.nominal_force) for name, force in permitted_forces(rated, rated.motion(angle)).items()}


def _governing(forces: Mapping[str, Array]) -> tuple[str, ...]:
    """Name of the limit with the smallest force at every height, and of equal ones the first."""
    names = list(forces)
    return tuple(names[k] for k in np.argmin(list(forces.values()), axis=0))
