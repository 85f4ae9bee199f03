"""Capacities of a press, as its builder or buyer states them, and the process force that they permit over the working stroke.

At a given angle and speed the driving torque and every bearing force are affine in the process force F: R = R0 + F R1. R0 are the reactions
of the idle press, and R1 those of its links without mass under a force of 1 N, so that neither is a difference of large numbers. A capacity
C lets F grow until |R0 + F R1| = C, a quadratic equation.

With friction this still holds of the process force alone, because friction grows in proportion to it. Beside weights, inertia forces and
springs the friction of bearings is no longer affine in F, but |R| still crosses C once: where is found by Newton's method within a bracket.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ..common.arguments import is_multiple, is_quantity, positive, suitable_numbers
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.frozen import Frozen, FrozenMapping
from ..common.numerics import bracketed_roots, sign_change
from ..common.quantities import RPM, Array, DriverCoordinate
from ..dynamics.applied_loads import force_on_slide
from ..dynamics.inputs import Inputs, written
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions
from ..kinematics.cycle import motion_through_change_points, moved
from ..kinematics.motion import Motion
from ..kinematics.slide_path import DeadCentres, dead_centres
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load, PointForce, StandingLoad, law
from ..loads.process import ConstantForce, ProcessLoad, TimeForce

NOMINAL, TORQUE, DRIVING_FORCE, BEARING = "nominal force", "torque", "driving force", "bearing "
TURN = 360  # states of a turn in which the idle press is checked
ROUNDING = 4 * float(np.finfo(float).eps)  # accuracy of roots, absolute and relative
TIE = 1e-9  # relative difference up to which two limits count as equal
SAME = 1e-12  # relative difference by rounding between limits that are equal at every height
FURTHEST = 2.0  # multiple of the nominal force up to which forces are looked for with friction; larger ones never govern
BESIDE = 1e-6  # share of the nominal force by which the slope of a utilisation is found
SLOWED = 1e-6  # least share of its highest speed that a driver that slides counts as moving with: at rest friction has no direction
GAUSS = np.polynomial.legendre.leggauss(3)  # nodes and weights, with which the work of 1 N between two states is found
# Nodes and weights of a rule with the ends of a step: it sees a change of the governing limit even beside an end.
LOBATTO = np.array([-1.0, -math.sqrt(3 / 7), 0.0, math.sqrt(3 / 7), 1.0]), np.array([9.0, 49.0, 64.0, 49.0, 9.0]) / 90
SETTLED = 1e-13  # share of the whole work: a step is not halved further where that changes its work by less
MOST_HALVINGS = 40
NO_RATINGS = "ratings are those of a press with one, whose position gives the height; rate_motion finds the force along their motion"
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
    """Capacities of a press. A capacity of None and a bearing without capacity do not limit the press.

    Attributes:
        nominal_force: largest process force at any height [N].
        nominal_height: height above bottom dead centre from which downwards the crank's torque permits the nominal force [m].
        torque: torque capacity at the driver joint, in place of the nominal height [N m]; force capacity of a sliding driver [N].
        bearings: name of a bearing or guide -> largest magnitude of the force in it, in a planar press the radial force [N].
        drivers: name of a driver -> its torque capacity [N m], or force capacity of a sliding driver [N], in place of ``torque``; for
            `rate_motion` of presses with several drivers.
        flywheel_inertia: moment of inertia of the flywheel reduced to the driver joint, without the linkage [kg m2].
        speed_drop: largest drop of the flywheel's speed in a stroke, divided by the speed [-]. It goes with the flywheel. Usual values are
            0.2 to 0.3 in single strokes and 0.1 to 0.15 in continuous ones.
        motor_power: power of the motor that restores the energy from stroke to stroke in continuous use [W]. Leave it out for single
            strokes, between which there is time enough.
        slide_acceleration: largest slide acceleration that tool and feed allow [m/s2].
        shaking_force: largest force on the foundation, weight excluded [N].

    Raises:
        PinpressError: a number is not positive and finite, or has the unit of another quantity, both torque and nominal height are given,
            flywheel or drop of speed is missing, or the drop is larger than the speed.
    """

    nominal_force: float
    nominal_height: float | None = None
    torque: float | None = None
    bearings: Mapping[str, float] = field(default_factory=lambda: FrozenMapping({}))
    drivers: Mapping[str, float] = field(default_factory=lambda: FrozenMapping({}))
    flywheel_inertia: float | None = None
    speed_drop: float | None = None
    motor_power: float | None = None
    slide_acceleration: float | None = None
    shaking_force: float | None = None
    # Units of the torque (None) and of capacities of drivers by their names, where they were given with one.
    _effort_units: Mapping[str | None, str] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.drivers, Mapping):
            raise PinpressError(f"drivers is {shown(self.drivers)}: give a mapping of names to torques [N m], e.g. {{'A': 5e3}}")
        efforts: list[tuple[str | None, object]] = [(None, self.torque), *self.drivers.items()]
        units = {name: "N" if is_multiple(given, "N") else "N m" for name, given in efforts if is_quantity(given)}
        object.__setattr__(self, "_effort_units", FrozenMapping(units))
        if None in units:
            object.__setattr__(self, "torque", positive("torque", self.torque, units[None]))
        capable = {
            name: positive(f"the capacity of driver {shown(name)}", value, units.get(name, "N m")) for name, value in self.drivers.items()
        }
        object.__setattr__(self, "drivers", FrozenMapping(capable))
        if self.drivers and self.torque is not None:
            raise PinpressError("torque and drivers both give capacities of the drivers: leave torque out")
        for name, unit in UNITS.items():
            value = getattr(self, name)
            if value is not None or name == "nominal_force":
                object.__setattr__(self, name, positive(name, value, unit))
        if not isinstance(self.bearings, Mapping):
            raise PinpressError(f"bearings is {shown(self.bearings)}: give a mapping of names to forces [N], e.g. {{'A': 2e6}}")
        known = {name: positive(f"the capacity of bearing {shown(name)}", value, "N") for name, value in self.bearings.items()}
        object.__setattr__(self, "bearings", FrozenMapping(known))
        if self.torque is not None and self.nominal_height is not None:
            raise PinpressError("torque and nominal_height both give the torque capacity: leave one out")
        if (self.flywheel_inertia is None) != (self.speed_drop is None):
            raise PinpressError("the energy of a flywheel needs flywheel_inertia and speed_drop: give both, or leave both out")
        if self.speed_drop is not None and self.speed_drop > 1.0:
            raise PinpressError(f"speed_drop is {self.speed_drop:g}: give a fraction of the speed, 1 or less")

    def energies(self, speed: float, turns: float = 1) -> dict[str, float]:
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


def refuse_other_effort(given: Capacities, coordinate: DriverCoordinate, driver: str | None = None) -> None:
    """Raise PinpressError where the torque, or the capacity of a named driver, was given in a unit that a driver with this coordinate does
    not have."""
    unit = given._effort_units.get(driver)
    if unit not in (None, coordinate.effort_unit):
        what = "torque" if driver is None else f"the capacity of driver {shown(driver)}"
        moves = "turns" if coordinate.turns else "slides"
        raise PinpressError(f"{what} is given in {unit}, but the driver {moves}: give it in {coordinate.effort_unit}")


def refuse_by_driver(given: Capacities) -> None:
    """Raise PinpressError where capacities are given by drivers, which only `rate_motion` takes."""
    if given.drivers:
        raise PinpressError("drivers gives capacities along a motion, see rate_motion: give the capacity of a single driver as torque")


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
        loads: springs, balance cylinders and constant forces that act beside the process.
        friction: of the bearings, by their names.
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
    loads: tuple[Load, ...]
    friction: Mapping[str, Friction]
    engine: str
    top: float
    bottom: float
    bottom_position: float
    turns: float

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
        return motion_through_change_points(self.press, angle, self.speed, engine=self.engine)

    def in_operation(self, motion: Motion) -> Motion:
        """A motion at constant speed as the press makes it in operation: a driver that slides moves harmonically, as in `cycle`."""
        if self.coordinate.turns:
            return motion
        middle, half = 0.5 * (self.top + self.bottom), 0.5 * abs(self.bottom - self.top)
        beside = motion.crank_angle - middle
        slowest = SLOWED**2 if self.friction else 0.0
        speed = self.speed * np.sqrt(np.maximum(1.0 - (beside / half) ** 2, slowest))
        acceleration = -((self.speed / half) ** 2) * beside
        return moved(self.press, self.press.branch, motion.crank_angle, speed, acceleration, None, self.engine)

    def height(self, motion: Motion) -> Array:
        """Heights (n,) above bottom dead centre, not below it by rounding [m]."""
        return np.maximum(motion.slide_position - self.bottom_position, 0.0)

    @cached_property
    def work_by_force(self) -> Callable[[Array], Array]:
        """Work of the driver (n,) for a process force of 1 N and its friction, from crank angles (n,) to the end of the stroke [J/N]."""
        nodes, weights = GAUSS
        angle = np.linspace(self.top, self.bottom, 2 * TURN + 1)
        middle, half = 0.5 * (angle[1:] + angle[:-1]), 0.5 * (angle[1] - angle[0])
        places = np.concatenate([angle, (middle[:, None] + half * nodes).ravel()])
        torque = unit_force_reactions(self, self.motion(places), ()).driving_torque
        steps = half * (torque[len(angle) :].reshape(-1, len(nodes)) @ weights)
        work = np.append(np.cumsum(steps[::-1])[::-1], 0.0)
        order = slice(None) if half > 0 else slice(None, None, -1)
        angle, work, slope = angle[order], work[order], -torque[: len(angle)][order]
        step, chord = np.diff(angle), np.diff(work) / np.diff(angle)
        bend = (slope[:-1] + slope[1:] - 2 * chord) / step
        cubics = np.array([work[:-1], slope[:-1], (chord - slope[:-1]) / step - bend, bend / step])  # through values and slopes

        def left_at(at: Array) -> Array:
            piece = np.clip(np.searchsorted(angle, at, side="right") - 1, 0, len(step) - 1)
            beyond, (start, rate, half_bend, third) = at - angle[piece], cubics[:, piece]
            value = start + rate * beyond + half_bend * (beyond * beyond) + third * (beyond * beyond * beyond)
            return np.asarray(np.maximum(value, 0.0))

        return left_at


def rated_stroke(
    press: Linkage,
    capacities: Capacities,
    speed: float,
    *,
    at_speed: bool,
    beside: tuple[tuple[Load, ...], Mapping[str, Friction]],
    engine: str,
) -> RatedStroke:
    """The working stroke to be rated, with the torque capacity that a nominal height stands for; ``beside``: loads and friction.

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
        loads=beside[0],
        friction=beside[1],
        engine=engine,
        top=ends.top_angle,
        bottom=bottom,
        bottom_position=ends.bottom_position,
        turns=ends.turns,
    )
    if capacities.nominal_height is None:
        return given
    at = given.motion(np.array([angle_at(given, "nominal_height", capacities.nominal_height)]))
    needed = unit_force_reactions(given, at, ()).driving_torque[0]
    return replace(given, torque=capacities.nominal_force * abs(float(needed)))


def _refuse_turning_back(press: Linkage, ends: DeadCentres) -> None:
    """Raise PinpressError where the slide turns back within the travel of a driver that slides, so that it comes down on two ways."""
    low, high = (float(end) for end in press.branch_through_change_points.angles[[0, -1]])
    places = np.linspace(ends.top_angle, ends.bottom_angle, TURN + 1)
    speeds = motion_through_change_points(press, places, ends.bottom_angle - ends.top_angle).slide_velocity
    travelled = abs(ends.bottom_angle - ends.top_angle)
    if travelled < (1 - TIE) * (high - low) or np.any(speeds[1:-1] >= 0):
        first, last, bottom = (press.driver_coordinates[0].shown(place) for place in (low, high, ends.bottom_angle))
        raise PinpressError(
            f"the slide of {press.name} turns back while its driver goes from {first} to {last}, so it has no single working stroke: let"
            f" the <limit> of joint {press.driver!r}, or the travel in its table, end where the slide turns back (bottom dead centre:"
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
    stroke = dead_centres(rated.press).stroke
    wanted = f"a height between 0 and the stroke of {stroke:.6g} m ({1e3 * stroke:.6g} mm)"
    suitable_numbers(name, height, wanted, suits=lambda value: 0.0 < value < stroke)

    def above(angle: float) -> float:
        return float(rated.motion(np.array([angle])).slide_position[0]) - rated.bottom_position - height

    return sign_change(above, rated.top, rated.bottom, ROUNDING * max(abs(rated.top), abs(rated.bottom)))


def refuse_unrated(press: Linkage, loads: object, friction: Mapping[str, Friction], *, at_speed: bool) -> None:
    """Raise PinpressError where loads are none that stand beside the process, or where such loads or viscous friction stand beside the
    process force alone; and as `loads.link.law`."""
    if not isinstance(loads, list | tuple):
        raise PinpressError(f"loads is {shown(loads)}: give a list, loads=[...]")
    for load in loads:
        if isinstance(load, PointForce) and (callable(load.force) or np.ndim(load.force) != 1):
            raise PinpressError(f"load on {shown(load.link)}: ratings take a constant force, (3,) in world axes [N]")
        if not isinstance(load, StandingLoad):
            kind = type(load).__name__ if isinstance(load, ProcessLoad | TimeForce) and not isinstance(load, type) else shown(load)
            raise PinpressError(
                f"{kind} is not a load of ratings, which find the process force: give springs (SpringDamper), balance cylinders"
                " and constant forces (PointForce); ratings.utilisation(reactions) compares a process with the permissible force"
            )
    _ = law(friction, press)
    if at_speed:
        return
    if loads:
        raise PinpressError("springs and other forces count only with weights and inertia forces: also give at_speed=True (--at-speed)")
    for name, given in friction.items():
        if given.viscous:
            raise PinpressError(
                f"friction of {shown(name)}: viscous friction depends on the speed, not on the process force: also give at_speed=True"
                " (--at-speed), or leave it out"
            )
        if given.preload:
            raise PinpressError(
                f"friction of {shown(name)}: preloaded gibs have friction without a process force: also give at_speed=True (--at-speed), or"
                " leave it out"
            )


def refuse_overloaded_idle(rated: RatedStroke) -> None:
    """Raise PinpressError where the idle press at its speed exceeds a capacity of torque or bearings anywhere in a period."""
    turning, stroke = rated.coordinate.turns, np.linspace(rated.top, rated.bottom, TURN)
    if turning:
        whole = rated.top + np.arange(TURN * rated.press.period_turns) * (2 * np.pi / TURN)
        motion, speed = rated.motion(np.concatenate([whole, stroke])), f"{abs(rated.speed) / RPM:.6g} r/min"
    else:  # on the way back a driver that slides takes the same forces
        motion, speed = rated.in_operation(rated.motion(stroke)), f"a highest speed of {1e3 * abs(rated.speed):.6g} mm/s"
    idle = inverse_dynamics(rated.press, motion, rated.loads, rated.friction, engine=rated.engine, bearings=rated.bearings)
    sizes = (
        {}
        if rated.torque is None
        else {f"the driving {rated.coordinate.effort}": (np.abs(idle.driving_torque), rated.torque, rated.coordinate.effort_unit)}
    )
    for name in rated.bearings:
        force = np.linalg.norm(idle.bearing_force[name], axis=1)
        sizes[f"the force in bearing {shown(name)}"] = force, rated.capacities.bearings[name], "N"
    for what, (size, capacity, unit) in sizes.items():
        worst = int(size.argmax())
        if size[worst] > capacity:
            raise PinpressError(
                f"{what} of the idle press is {size[worst]:.6g} {unit} at {motion.place(worst)} and {speed}, but the capacity is"
                f" {capacity:.6g} {unit}: lower the speed, or raise the capacity"
            )


def permitted_forces(rated: RatedStroke, motion: Motion, energy: bool = True, wanted: Collection[str] | None = None) -> dict[str, Array]:
    """Process force (n,) that each limit permits, by the limit's name, infinite where it permits any; the nominal force is first [N].

    Args:
        rated: the working stroke.
        motion: motion of the press, n states.
        energy: whether to add the forces that take all usable energy when they act from here to bottom dead centre.
        wanted: names of limits; others are left out where that saves time. None: all.
    """
    strokes = (_in_one_stroke(rated, again, wanted) for again in _in_every_stroke(rated, motion))
    found = functools.reduce(lambda some, others: {name: np.minimum(force, others[name]) for name, force in some.items()}, strokes)
    if energy:
        work = rated.work_by_force(motion.crank_angle) if rated.friction and rated.energies else rated.height(motion)
        with np.errstate(divide="ignore", over="ignore"):  # at height zero any force is permitted
            found |= {name: usable / work for name, usable in rated.energies.items()}
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
    names = governing_names(_capped(rated, angle))
    next_names: dict[float, str] = {}
    for k in range(len(angle) - 1):
        if names[k] != names[k + 1]:
            next_names |= dict(_changes(rated, names[k], names[k + 1], float(angle[k]), float(angle[k + 1])))
    every = _in_order(rated, np.concatenate([angle, list(next_names)]))
    forces = _capped(rated, every)
    # At a change two limits permit equal forces up to rounding, which must not decide which of them governs.
    governing = tuple(next_names.get(float(at), name) for at, name in zip(every, governing_names(forces), strict=True))
    return GoverningLimits(every, forces, governing, tuple(k for k, at in enumerate(every) if float(at) in next_names))


def permitted_work(rated: RatedStroke, angle: Array) -> Array:
    """Work (n,) of the force that all limits but energy permit, from each of the crank angles (n,) to the last of them [J].

    Lobatto's rule integrates it between the angles, over steps that are halved until that changes nothing: where an energy governs, the
    other limits take over from each other at angles that are not among these.
    """
    nodes, weights = LOBATTO

    def over(low: Array, high: Array) -> Array:
        half = 0.5 * (high - low)
        places = (0.5 * (low + high)[:, None] + half[:, None] * nodes).ravel()
        motion = rated.motion(np.clip(places, angle.min(), angle.max()))  # not beyond an end by rounding
        forces = permitted_forces(rated, motion, energy=False)
        power = np.min(list(forces.values()), axis=0) * np.abs(motion.slide_velocity / rated.speed)
        return np.asarray(np.abs(half) * (power.reshape(-1, len(nodes)) @ weights))

    low, high, owner, steps = angle[:-1], angle[1:], np.arange(len(angle) - 1), np.zeros(len(angle) - 1)
    whole = over(low, high)
    accepted = SETTLED * float(whole.sum())
    for _ in range(MOST_HALVINGS):
        middle = 0.5 * (low + high)
        halves = over(np.concatenate([low, middle]), np.concatenate([middle, high])).reshape(2, -1)
        rough = np.abs(halves.sum(axis=0) - whole) > accepted
        np.add.at(steps, owner[~rough], halves[:, ~rough].sum(axis=0))
        low, high = np.concatenate([low[rough], middle[rough]]), np.concatenate([middle[rough], high[rough]])
        owner, whole = np.tile(owner[rough], 2), halves[:, rough].ravel()
        if not len(owner):
            break
    np.add.at(steps, owner, whole)
    return np.append(np.cumsum(steps[::-1])[::-1], 0.0)


def unit_force_reactions(rated: RatedStroke, motion: Motion, bearings: tuple[str, ...] | None) -> Reactions:
    """Reactions to a process force of 1 N at every height of a motion, with the Coulomb friction that it causes, without weights and
    inertia forces; ``bearings``: as in `inverse_dynamics`."""
    massless, bottom = rated.massless, rated.bottom_position
    above = 2 * max(float(np.ptp(motion.slide_position)), float(np.abs(motion.slide_position - bottom).max()), massless.size)
    dry = {name: replace(given, viscous=0.0, preload=0.0) for name, given in rated.friction.items()}
    return inverse_dynamics(massless, motion, [ConstantForce(1.0, above, bottom)], dry, engine=rated.engine, bearings=bearings)


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
    strokes = round(rated.press.period_turns / rated.turns) if rated.coordinate.turns else 1
    for stroke in range(1, strokes):
        yield rated.motion(motion.crank_angle + 2 * np.pi * rated.turns * stroke)


def _in_one_stroke(rated: RatedStroke, motion: Motion, wanted: Collection[str] | None) -> dict[str, Array]:
    """The forces that torque, bearings and the nominal force permit in one stroke; see `permitted_forces`."""
    found = {NOMINAL: np.full(len(motion.crank_angle), rated.capacities.nominal_force)}
    found |= _beside_friction(rated, motion, wanted) if rated.at_speed and rated.friction else _affine(rated, motion)
    return found if rated.coordinate.turns else _without_rounding(found)


def _affine(rated: RatedStroke, motion: Motion) -> dict[str, Array]:
    """The forces that torque and bearings permit where all reactions are affine in the process force."""
    capacities, count, found = rated.capacities, len(motion.crank_angle), {}
    unit = unit_force_reactions(rated, motion, rated.bearings)
    operating = rated.in_operation(motion) if rated.at_speed else None
    idle = (
        None if operating is None else inverse_dynamics(rated.press, operating, rated.loads, engine=rated.engine, bearings=rated.bearings)
    )
    if rated.torque is not None:
        before = np.zeros((count, 1)) if idle is None else idle.driving_torque[:, None]
        found[_driving_limit(rated)] = largest_factor(before, unit.driving_torque[:, None], rated.torque)
    for name in rated.bearings:
        before = np.zeros((count, 3)) if idle is None else idle.bearing_force[name]
        found[BEARING + name] = largest_factor(before, unit.bearing_force[name], capacities.bearings[name])
    return found


def _driving_limit(rated: RatedStroke) -> str:
    return TORQUE if rated.coordinate.turns else DRIVING_FORCE


def _beside_friction(rated: RatedStroke, motion: Motion, wanted: Collection[str] | None) -> dict[str, Array]:
    """The forces that torque and bearings permit where friction goes with weights, inertia forces and springs too; infinite where they are
    beyond `FURTHEST`. ``wanted``: names of the limits, None for all.

    Raises:
        PinpressError: friction locks the linkage, or a smaller force than one that is permitted is not.
    """
    capacities = {} if rated.torque is None else {_driving_limit(rated): rated.torque}
    capacities |= {BEARING + name: rated.capacities.bearings[name] for name in rated.bearings}
    names = [name for name in capacities if wanted is None or name in wanted]
    count, largest = len(motion.crank_angle), FURTHEST * rated.capacities.nominal_force
    found = np.full(len(names) * count, np.inf)
    if not names:
        return {}
    limit, angle = np.arange(len(found)) // count, np.tile(motion.crank_angle, len(names))
    idle, loaded = _Utilisation(rated, names, limit, angle).at(np.array([[0.0], [largest]]) + np.zeros(len(found)))
    found[idle >= 1.0] = 0.0
    limited = np.flatnonzero((idle < 1.0) & (loaded > 1.0))
    if len(limited):
        some = _Utilisation(rated, names, limit[limited], angle[limited])
        found[limited] = bracketed_roots(some.missing, np.zeros(len(limited)), np.full(len(limited), largest), relative=SAME)
        if wanted is None:
            some.refuse_several(found[limited])
    return dict(zip(names, found.reshape(len(names), count), strict=True))


class _Utilisation:
    """Shares of capacities that are used at m pairs of a limit and a state, under a process force each."""

    def __init__(self, rated: RatedStroke, names: Sequence[str], limit: NDArray[np.intp], angle: Array) -> None:
        """Begin with the states.

        Args:
            rated: the working stroke.
            names: of limits, the driving torque or bearings.
            limit: (m,) index of the limit among them.
            angle: (m,) crank angle of the state [rad].
        """
        self.rated, self.names, self.limit, self.angle = rated, names, limit, angle
        self.motions: dict[int, Motion] = {}

    def at(self, force: Array) -> Array:
        """Shares (k, m) under process forces (k, m) [N]."""
        rated, k = self.rated, len(force)
        if k not in self.motions:
            self.motions[k] = rated.in_operation(rated.motion(np.tile(self.angle, k)))
        loads = [*rated.loads, force_on_slide(rated.press, force.ravel())]
        found = inverse_dynamics(rated.press, self.motions[k], loads, rated.friction, engine=rated.engine, bearings=rated.bearings)
        shares = [
            np.linalg.norm(found.bearing_force[name.removeprefix(BEARING)], axis=1) / rated.capacities.bearings[name.removeprefix(BEARING)]
            if name.startswith(BEARING)
            else np.abs(found.driving_torque) / rated.torque
            for name in self.names
        ]
        return np.asarray(np.array(shares).reshape(len(shares), k, -1)[self.limit, :, np.arange(len(self.limit))].T)

    def missing(self, force: Array) -> tuple[Array, Array]:
        """Shares less 1 (m,) under process forces (m,) [N], and their derivatives by the force."""
        step = BESIDE * self.rated.capacities.nominal_force
        share, beside = self.at(np.stack([force, force + step]))
        return share - 1.0, (beside - share) / step

    def refuse_several(self, force: Array) -> None:
        """Raise PinpressError where a smaller force than (m,), at which a capacity is reached, exceeds it."""
        beyond = (self.at(np.array([[0.25], [0.5], [0.75]]) * force) > 1.0 + TIE).any(axis=0)
        if beyond.any():
            worst = int(np.argmax(beyond))
            raise PinpressError(
                f"at {self.rated.coordinate.at(float(self.angle[worst]))} there is no single permissible force with friction: '"
                f"{self.names[int(self.limit[worst])]}' permits {force[worst]:.6g} N, but not every smaller force; rate the press without"
                " friction"
            )


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
    (least,) = governing_names(forces)
    if at not in (low, high) and forces[least][0] < (1 - TIE) * min(forces[first][0], forces[second][0]):
        yield from _changes(rated, first, least, low, at)
        yield from _changes(rated, least, second, at, high)
    else:
        yield at, second


def _crossing(rated: RatedStroke, first: str, second: str, low: float, high: float) -> float:
    """Crank angle between two at which the second limit begins to permit less than the first."""

    def ahead(angle: float) -> float:
        """Force that the first limit permits beyond that of the second; forces count up to twice the nominal one."""
        found = permitted_forces(rated, rated.motion(np.array([angle])), wanted=(first, second))
        one, other = (min(float(found[name][0]), 2 * rated.capacities.nominal_force) for name in (first, second))
        return one - other

    before, after = ahead(low), ahead(high)
    if before * after >= 0:  # the limits change exactly at a state
        return low if before == 0.0 else high
    rounding = ROUNDING * max(abs(low), abs(high))
    found = sign_change(ahead, low, high, rounding)
    return next((state for state in (low, high) if abs(found - state) <= 2 * rounding), found)  # as at the nominal height


def _capped(rated: RatedStroke, angle: Array) -> dict[str, Array]:
    return {name: np.minimum(force, rated.capacities.nominal_force) for name, force in permitted_forces(rated, rated.motion(angle)).items()}


def governing_names(forces: Mapping[str, Array]) -> tuple[str, ...]:
    """Name of the limit with the smallest force in every state, and of those that are equal but for rounding the first."""
    names, limits = list(forces), np.array(list(forces.values()))
    return tuple(names[k] for k in np.argmax(limits <= (1 + TIE) * limits.min(axis=0), axis=0))
