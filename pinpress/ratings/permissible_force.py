"""Capacities of a press, as its builder or buyer states them, and the process force that they permit over the working stroke."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..common.arguments import is_multiple, is_quantity, positive, suitable_numbers
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.frozen import Frozen, FrozenMapping
from ..common.numerics import sign_change
from ..common.quantities import RPM, Array, DriverCoordinate
from ..dynamics.applied_loads import force_on_slide
from ..dynamics.inputs import Inputs, written
from ..dynamics.inverse_dynamics import inverse_dynamics
from ..dynamics.reactions import Reactions, carrying
from ..kinematics.cycle import motion_through_change_points, moved
from ..kinematics.motion import Motion
from ..kinematics.slide_path import DeadCentres, dead_centres
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load, PointForce, PointMoment, StandingLoad, is_constant, law
from ..loads.process import ConstantForce, ProcessLoad, TimeForce
from .limits import (
    DRIVING_FORCE,
    NOMINAL,
    SAME,
    TIE,
    Limit,
    affine_forces,
    bearing_limit,
    driver_limit,
    forces_with_friction,
    governing_names,
    without_masses,
)

TURN = 360  # states of a turn in which the idle press is checked
ROUNDING = 4 * float(np.finfo(float).eps)  # accuracy of roots, absolute and relative
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
    """Capacities of a press. A capacity of None does not limit the press, and neither does a bearing without a capacity.

    Attributes:
        nominal_force: largest process force at any height [N].
        nominal_height: height above bottom dead centre; at and below it the crank's torque permits the nominal force [m].
        torque: torque capacity at the driver joint, in place of the nominal height [N m]; force capacity of a sliding driver [N].
        bearings: name of a bearing or guide -> largest magnitude of its force; in a planar press, of the radial force [N].
        drivers: name of a driver -> its torque capacity [N m], or force capacity of a sliding driver [N], in place of ``torque``; for
            `rate_motion` of presses with several drivers.
        flywheel_inertia: moment of inertia of the flywheel reduced to the driver joint, without the linkage [kg m2].
        speed_drop: largest drop of the flywheel's speed in a stroke, divided by the speed [-]. Give it together with the flywheel. Usual
            values are 0.2 to 0.3 for single strokes and 0.1 to 0.15 for continuous strokes.
        motor_power: power of the motor that restores the energy from stroke to stroke in continuous use [W]. Leave it out for single
            strokes: between them the motor has enough time.
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
    # name of a driver, or None for ``torque`` -> unit with which the capacity was given, if it had one
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
        energies = {}
        if self.flywheel_inertia is not None and self.speed_drop is not None:
            # d (2 - d) keeps the digits that 1 - (1 - d)^2 loses for a small drop
            energies["flywheel energy"] = 0.5 * self.flywheel_inertia * speed**2 * self.speed_drop * (2.0 - self.speed_drop)
        if self.motor_power is not None:
            energies["motor energy"] = self.motor_power * 2 * math.pi * turns / abs(speed)
        return energies


def refuse_other_effort(given: Capacities, coordinate: DriverCoordinate, driver: str | None = None) -> None:
    """Raise PinpressError if the torque, or the capacity of a named driver, was given in a unit that does not suit this coordinate."""
    unit = given._effort_units.get(driver)
    if unit not in (None, coordinate.effort_unit):
        what = "torque" if driver is None else f"the capacity of driver {shown(driver)}"
        moves = "turns" if coordinate.turns else "slides"
        raise PinpressError(f"{what} is given in {unit}, but the driver {moves}: give it in {coordinate.effort_unit}")


def refuse_by_driver(given: Capacities) -> None:
    """Raise PinpressError if capacities are given by driver name, which only `rate_motion` accepts."""
    if given.drivers:
        raise PinpressError("drivers gives capacities along a motion, see rate_motion: give the capacity of a single driver as torque")


def capacities_in_words(given: Capacities, coordinate: DriverCoordinate) -> Inputs:
    """Names and values of the given capacities, as text; ``coordinate``: coordinate of the driver."""
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
        if name not in carrying(press):
            raise UnknownNameError("bearing", name, carrying(press))
    return tuple(name for name in carrying(press) if name in capacities.bearings)


@dataclass(frozen=True, eq=False, repr=False)
class RatedStroke:
    """The working stroke of a press that is rated.

    Attributes:
        press: the press, with one driver and a slide with one top and one bottom dead centre.
        capacities: its capacities.
        speed: speed of the driver joint, negative backwards [rad/s]; highest speed of a sliding driver, positive towards bottom dead centre
            of the slide [m/s].
        torque: torque capacity at the driver joint [N m], or force capacity of a sliding driver [N]; None: no limit.
        at_speed: whether weights and inertia forces count.
        loads: springs, balance cylinders and constant forces in addition to the process.
        friction: name of a bearing -> friction.
        engine: as in `cycle`.
        top: crank angle of the dead centre at which the working stroke begins [rad]; position of a sliding driver [m].
        bottom: crank angle at which it ends, unwrapped: less than ``top`` if the crank turns backwards [rad]; position of a sliding driver
            [m].
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
    def limits(self) -> tuple[Limit, ...]:
        """Limits of the driving torque and of bearings."""
        bearings = [bearing_limit(name, self.capacities.bearings[name]) for name in self.bearings]
        return tuple([] if self.torque is None else [driver_limit(self.press, self.press.driver, self.torque)]) + tuple(bearings)

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
        """From a motion at constant speed, the motion in operation: a sliding driver moves harmonically, as in `cycle`."""
        if self.coordinate.turns:
            return motion
        middle, half = 0.5 * (self.top + self.bottom), 0.5 * abs(self.bottom - self.top)
        beside = motion.crank_angle - middle
        slowest = 1e-12 if self.friction or self.press.loses_power else 0.0  # at rest friction would have no direction
        speed = self.speed * np.sqrt(np.maximum(1.0 - (beside / half) ** 2, slowest))
        acceleration = -((self.speed / half) ** 2) * beside
        return moved(self.press, self.press.branch, motion.crank_angle, speed, acceleration, None, self.engine)

    def height(self, motion: Motion) -> Array:
        """Heights (n,) above bottom dead centre, never negative by rounding errors [m]."""
        return np.maximum(motion.slide_position - self.bottom_position, 0.0)

    @cached_property
    def work_by_force(self) -> Callable[[Array], Array]:
        """Work of the driver (n,) for a process force of 1 N and its friction, from crank angles (n,) to the end of the stroke [J/N]."""
        from scipy.interpolate import CubicHermiteSpline  # slow to import

        nodes, weights = np.polynomial.legendre.leggauss(3)
        angle = np.linspace(self.top, self.bottom, 2 * TURN + 1)
        middle, half = 0.5 * (angle[1:] + angle[:-1]), 0.5 * (angle[1] - angle[0])
        places = np.concatenate([angle, (middle[:, None] + half * nodes).ravel()])
        torque = unit_force_reactions(self, self.motion(places), ()).driving_torque
        steps = half * (torque[len(angle) :].reshape(-1, len(nodes)) @ weights)
        work = np.append(np.cumsum(steps[::-1])[::-1], 0.0)
        rising = slice(None, None, 1 if half > 0 else -1)
        spline = CubicHermiteSpline(angle[rising], work[rising], -torque[: len(angle)][rising])
        return lambda at: np.maximum(spline(at), 0.0)


def rated_stroke(
    press: Linkage,
    capacities: Capacities,
    speed: float,
    *,
    at_speed: bool,
    beside: tuple[tuple[Load, ...], Mapping[str, Friction]],
    engine: str,
) -> RatedStroke:
    """The working stroke to be rated, with the torque capacity that a nominal height defines; ``beside``: loads and friction.

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
    """Raise PinpressError if the slide turns back within the travel of a sliding driver, because then it has two working strokes."""
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
    """Crank angle in the working stroke at a height above bottom dead centre, unwrapped [rad]; position of a sliding driver [m].

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
    """Raise PinpressError for a load that cannot be combined with the process force, and, unless ``at_speed``, for any load or viscous
    friction; also as `loads.link.law`."""
    if not isinstance(loads, list | tuple):
        raise PinpressError(f"loads is {shown(loads)}: give a list, loads=[...]")
    for load in loads:
        if isinstance(load, PointForce | PointMoment) and not is_constant(load):
            raise PinpressError(f"load on {shown(load.link)}: ratings take a constant force or moment, (3,) in world axes [N, N m]")
        if not isinstance(load, StandingLoad):
            kind = type(load).__name__ if isinstance(load, ProcessLoad | TimeForce) and not isinstance(load, type) else shown(load)
            raise PinpressError(
                f"{kind} is not a load of ratings, which find the process force: give SpringDamper, TorsionSpring, balance cylinders"
                " and constant PointForce and PointMoment; ratings.utilisation(reactions) compares a process with the permissible force"
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
    """Raise PinpressError if the idle press at its speed exceeds a capacity of torque or bearings anywhere in a period."""
    turning, stroke = rated.coordinate.turns, np.linspace(rated.top, rated.bottom, TURN)
    if turning:
        whole = rated.top + np.arange(TURN * rated.press.period_turns) * (2 * np.pi / TURN)
        motion, speed = rated.motion(np.concatenate([whole, stroke])), f"{abs(rated.speed) / RPM:.6g} r/min"
    else:  # a sliding driver needs the same forces on the way back
        motion, speed = rated.in_operation(rated.motion(stroke)), f"a highest speed of {1e3 * abs(rated.speed):.6g} mm/s"
    idle = inverse_dynamics(rated.press, motion, rated.loads, rated.friction, engine=rated.engine, bearings=rated.bearings)
    for limit in rated.limits:
        size = limit.size(idle)
        worst = int(size.argmax())
        if size[worst] > limit.capacity:
            raise PinpressError(
                f"{limit.what} of the idle press is {size[worst]:.6g} {limit.unit} at {motion.place(worst)} and {speed}, but the capacity"
                f" is {limit.capacity:.6g} {limit.unit}: lower the speed, or raise the capacity"
            )


def permitted_forces(rated: RatedStroke, motion: Motion, energy: bool = True, wanted: Collection[str] | None = None) -> dict[str, Array]:
    """Process force (n,) that each limit permits, by the limit's name, infinite if it permits any; the nominal force is first [N].

    Args:
        rated: the working stroke.
        motion: motion of the press, n states.
        energy: whether to add the forces that take all usable energy when they act from here to bottom dead centre.
        wanted: names of limits; other limits are left out if this saves time. None: all.
    """
    forces = _in_one_stroke(rated, motion, wanted)
    strokes = round(rated.press.period_turns / rated.turns) if rated.coordinate.turns else 1
    for stroke in range(1, strokes):  # the same part of the other strokes of the period
        others = _in_one_stroke(rated, rated.motion(motion.crank_angle + 2 * np.pi * rated.turns * stroke), wanted)
        forces = {name: np.minimum(force, others[name]) for name, force in forces.items()}
    if energy:
        rubs = bool(rated.friction) or rated.press.loses_power
        work = rated.work_by_force(motion.crank_angle) if rubs and rated.energies else rated.height(motion)
        with np.errstate(divide="ignore", over="ignore"):  # at height zero an energy permits any force
            forces |= {name: usable / work for name, usable in rated.energies.items()}
    return forces


class GoverningLimits(NamedTuple):
    """Limits over the working stroke.

    Attributes:
        angle: (n,) crank angles from top to bottom dead centre [rad].
        forces: name of a limit -> (n,) process force that it permits, at most the nominal force [N].
        names: (n,) names of the governing limit; at a change, of the limit that begins to govern.
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
    # at a change two limits permit equal forces, so rounding errors must not decide which of them governs
    governing = tuple(next_names.get(float(at), name) for at, name in zip(every, governing_names(forces), strict=True))
    return GoverningLimits(every, forces, governing, tuple(k for k, at in enumerate(every) if float(at) in next_names))


def permitted_work(rated: RatedStroke, angle: Array) -> Array:
    """Work (n,) of the force that all limits except energy permit, from each of the crank angles (n,) to the last one [J].

    The steps between the angles are halved until the work no longer changes: where an energy governs, the other limits may change between
    these angles.
    """
    # Lobatto's rule has the ends of a step among its nodes, so it detects a change of the governing limit even next to an end.
    nodes = np.array([-1.0, -math.sqrt(3 / 7), 0.0, math.sqrt(3 / 7), 1.0])
    weights = np.array([9.0, 49.0, 64.0, 49.0, 9.0]) / 90

    def over(low: Array, high: Array) -> Array:
        half = 0.5 * (high - low)
        places = (0.5 * (low + high)[:, None] + half[:, None] * nodes).ravel()
        motion = rated.motion(np.clip(places, angle.min(), angle.max()))  # not beyond an end by rounding errors
        forces = permitted_forces(rated, motion, energy=False)
        power = np.min(list(forces.values()), axis=0) * np.abs(motion.slide_velocity / rated.speed)
        return np.asarray(np.abs(half) * (power.reshape(-1, len(nodes)) @ weights))

    low, high, owner, steps = angle[:-1], angle[1:], np.arange(len(angle) - 1), np.zeros(len(angle) - 1)
    whole = over(low, high)
    accepted = 1e-13 * float(whole.sum())
    for _ in range(40):
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
    """Reactions to a process force of 1 N alone at every height of a motion, with its Coulomb friction; ``bearings``: as in
    `inverse_dynamics`."""
    massless, bottom = rated.massless, rated.bottom_position
    above = 2 * max(float(np.ptp(motion.slide_position)), float(np.abs(motion.slide_position - bottom).max()), massless.size)
    dry = {name: replace(given, viscous=0.0, preload=0.0) for name, given in rated.friction.items()}
    return inverse_dynamics(massless, motion, [ConstantForce(1.0, above, bottom)], dry, engine=rated.engine, bearings=bearings)


def _in_one_stroke(rated: RatedStroke, motion: Motion, wanted: Collection[str] | None) -> dict[str, Array]:
    """The forces that torque, bearings and the nominal force permit in one stroke; see `permitted_forces`."""
    nominal = np.full(len(motion.crank_angle), rated.capacities.nominal_force)
    forces = {NOMINAL: nominal}
    if rated.at_speed and (rated.friction or rated.press.uneven):
        limits = [limit for limit in rated.limits if wanted is None or limit.name in wanted]

        @functools.cache
        def repeated(times: int) -> Motion:
            return rated.in_operation(rated.motion(np.tile(motion.crank_angle, times)))

        def sizes(force: Array) -> Array:
            loads = [*rated.loads, force_on_slide(rated.press, force.ravel())]
            reactions = inverse_dynamics(
                rated.press, repeated(len(force)), loads, rated.friction, engine=rated.engine, bearings=rated.bearings
            )
            return np.array([limit.size(reactions).reshape(force.shape) for limit in limits])

        forces |= forces_with_friction(limits, sizes, nominal, motion.place, single=wanted is None)
    else:
        unit, idle = unit_force_reactions(rated, motion, rated.bearings), None
        if rated.at_speed:
            operating = rated.in_operation(motion)
            idle = inverse_dynamics(rated.press, operating, rated.loads, engine=rated.engine, bearings=rated.bearings)
        forces |= affine_forces(rated.limits, idle, unit)
    if rated.coordinate.turns:
        return forces
    # A cylinder in line with the slide bears the process force at every height, and rounding must not decide which of equal limits governs.
    equal: dict[str, Array] = {}
    for name, force in forces.items():
        for before in equal.values():
            force = np.where(np.isclose(force, before, rtol=SAME, atol=0.0), before, force)
        equal[name] = force
    return equal


def _in_order(rated: RatedStroke, angles: Array) -> Array:
    """Crank angles in the order of the working stroke, each once."""
    rising = np.unique(angles)
    return (rising if rated.bottom > rated.top else rising[::-1]).copy()


def _changes(rated: RatedStroke, first: str, second: str, low: float, high: float) -> Iterator[tuple[float, str]]:
    """Crank angles between two angles at which another limit begins to govern, with this limit; other limits may govern between the first
    and the second."""
    at = _crossing(rated, first, second, low, high)
    forces = _capped(rated, np.array([at]))
    (least,) = governing_names(forces)
    if at not in (low, high) and forces[least][0] < (1 - TIE) * min(forces[first][0], forces[second][0]):
        yield from _changes(rated, first, least, low, at)
        yield from _changes(rated, least, second, at, high)
    else:
        yield at, second


def _crossing(rated: RatedStroke, first: str, second: str, low: float, high: float) -> float:
    """Crank angle between two angles at which the second limit begins to permit less than the first."""

    def ahead(angle: float) -> float:
        """Force that the first limit permits less the force that the second permits; each counts up to twice the nominal force."""
        forces = permitted_forces(rated, rated.motion(np.array([angle])), wanted=(first, second))
        one, other = (min(float(forces[name][0]), 2 * rated.capacities.nominal_force) for name in (first, second))
        return one - other

    before, after = ahead(low), ahead(high)
    if before * after >= 0:  # the limits change exactly in a state
        return low if before == 0.0 else high
    rounding = ROUNDING * max(abs(low), abs(high))
    crossing = sign_change(ahead, low, high, rounding)
    return next((state for state in (low, high) if abs(crossing - state) <= 2 * rounding), crossing)  # e.g. the nominal height


def _capped(rated: RatedStroke, angle: Array) -> dict[str, Array]:
    return {name: np.minimum(force, rated.capacities.nominal_force) for name, force in permitted_forces(rated, rated.motion(angle)).items()}
