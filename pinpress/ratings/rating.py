"""Ratings: the force that a press may exert at each height, limited by torque, bearings and energy, as press builders print it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..common import plausibility
from ..common.arguments import expect, in_unit, positive, suitable_numbers, truth_value, typed, whole_number
from ..common.errors import PinpressError
from ..common.frozen import FrozenMapping, read_only
from ..common.quantities import GRAVITY, RPM, Array, DriverCoordinate
from ..common.results import Tabular
from ..dynamics.inverse_dynamics import NONE_GIVEN
from ..dynamics.reactions import Reactions
from ..kinematics import measures
from ..kinematics.cycle import cycle
from ..kinematics.motion import Motion, refuse_motion_of_another
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage, OfPress
from ..loads.link import Friction, Load, Spring
from .permissible_force import (
    NO_RATINGS,
    TURN,
    Capacities,
    GoverningLimits,
    RatedStroke,
    angle_at,
    governing_limits,
    known_bearings,
    permitted_work,
    rated_stroke,
    refuse_by_driver,
    refuse_other_effort,
    refuse_overloaded_idle,
    refuse_unrated,
)
from .speed_limits import PermissibleSpeed, limiting_speed

DWELL = 0.01  # distance from bottom dead centre that counts as dwell, as a share of the stroke
MOST_POINTS = 10**5  # crank angles; more would be a mistake
SLOWEST, FASTEST = 1e-12, 1e12  # speeds [rad/s] whose square and time of a turn neither overflow nor underflow


@dataclass(frozen=True, eq=False, repr=False)
class PressRatings(OfPress, Tabular):
    """The ratings of a press over its working stroke, at n heights from top to bottom dead centre. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        capacities: capacities as given.
        driver_coordinate: coordinate of its driver.
        speed: speed of the driver joint, negative backwards [rad/s]; highest speed of a sliding driver, with the sign of its motion towards
            bottom dead centre [m/s].
        at_speed: whether the forces take weights and inertia forces at this speed into account. False: the process force alone, as
            catalogues print it.
        loads: springs, balance cylinders and constant forces in addition to the process, as given.
        friction: friction of bearings and guides, as given.
        torque_capacity: torque capacity at the driver joint, given or from nominal force and height [N m]; force capacity of a sliding
            driver [N]. None: no limit. From a nominal height it includes the friction that the nominal force causes there.
        crank_angle: (n,) crank angle, unwrapped [rad]; position of a sliding driver [m].
        height: (n,) height of the slide above bottom dead centre, falling to 0 [m].
        travel_per_angle: (n,) ds/dtheta of the slide along its guide's axis [m/rad]. Its magnitude is the driving torque for a process
            force of 1 N without losses [N m/N]; its inverse is the mechanical advantage, which grows without bounds at the dead centres.
            For a sliding driver it is the travel of the slide / travel of the driver [-], which is the driving force for 1 N.
        slide_velocity: (n,) velocity of the slide along the guide's axis [m/s].
        force: (n,) permissible process force, the smallest force that a limit permits [N].
        limits: name of a limit -> (n,) process force that it permits alone, at most the nominal force [N]. The names are "nominal force",
            "torque" ("driving force" for a sliding driver), "bearing NAME", "flywheel energy" and "motor energy". An energy E permits
            E / height, a constant force from this height to bottom dead centre; with friction it permits E / (work of the crank for 1 N).
        limited_by: (n,) name of the limit that governs.
        changes: heights at which another limit begins to govern, falling, accurate within rounding error [m]; ``height`` contains them.
        work: (n,) work of the force that all limits except energy permit, down to bottom dead centre [J]. It may exceed an energy.
        energies: work that a stroke may take from each source, "flywheel energy" and "motor energy" [J].
        stroke: stroke of the slide [m].
        quick_return_ratio: time of the working stroke / time of the return stroke [-]; None if the driver slides.
        contact_height: height above bottom dead centre at which the tool meets the work [m]; None: not given.
        contact_speed: speed of the slide at this height [m/s]; None without a height.
        contact_advantage: mechanical advantage at this height, force on the slide for 1 N m at the crank [1/m], or for 1 N at a sliding
            driver [-]; None without a height.
        dwell_tolerance: distance from bottom dead centre that counts as dwell [m]; None if the driver slides.
        dwell_time: time in which the slide is within this distance [s]; None if the driver slides.
        speed_limit: speed at which the idle press reaches a capacity; None if no speed reaches a capacity, for a sliding driver, and with
            friction or dampers.
        turns: turns of the driver joint from stroke to stroke; 1 if the driver slides.
    """

    _press: Linkage
    capacities: Capacities
    driver_coordinate: DriverCoordinate
    speed: float
    at_speed: bool
    loads: tuple[Load, ...]
    friction: Mapping[str, Friction]
    torque_capacity: float | None
    crank_angle: Array
    height: Array
    travel_per_angle: Array
    slide_velocity: Array
    force: Array
    limits: Mapping[str, Array]
    limited_by: tuple[str, ...]
    changes: tuple[float, ...]
    work: Array
    energies: Mapping[str, float]
    stroke: float
    quick_return_ratio: float | None
    contact_height: float | None
    contact_speed: float | None
    contact_advantage: float | None
    dwell_tolerance: float | None
    dwell_time: float | None
    speed_limit: PermissibleSpeed | None
    turns: float

    @property
    def title(self) -> str:
        return f"PressRatings of {self.press_name}: {len(self.height)} heights, nominal force {self.capacities.nominal_force:.6g} N"

    def utilisation(self, reactions: Reactions) -> Array:
        """Process force / permissible force at the slide's height (n,) [-], read-only: above 1 the press is overloaded.

        Between the ratings' heights the permissible force is interpolated linearly.

        Args:
            reactions: reactions of the same press to a motion of n states under process loads.

        Raises:
            PinpressError: the reactions belong to another press.
        """
        expect("reactions", reactions, Reactions, "inverse_dynamics")
        press = reactions._press
        if press.name != self.press_name:
            raise PinpressError(
                f"the reactions belong to {press.name}, but the ratings to {self.press_name}: give reactions of the same press"
            )
        refuse_motion_of_another(self._press, reactions.motion)
        height = reactions.motion.slide_position - dead_centres(press).bottom_position
        return read_only(reactions.process_force / np.interp(height, self.height[::-1], self.force[::-1]))

    def columns(self) -> dict[str, Array | list[str]]:
        """A row for each height from top to bottom dead centre; with a sliding driver also driver_position and travel_per_driver_travel."""
        (position, unit), *_ = self.driver_coordinate.heads
        travel = "travel_per_angle [m/rad]" if self.driver_coordinate.turns else "travel_per_driver_travel [m/m]"
        return {
            "height [m]": self.height,
            f"{position} [{unit}]": self.crank_angle,
            travel: self.travel_per_angle,
            "slide_velocity [m/s]": self.slide_velocity,
            "force [N]": self.force,
            "limited_by": list(self.limited_by),
            **{f"{name} [N]": force for name, force in self.limits.items()},
            "work [J]": self.work,
        }


@typed
def rate(
    press: Linkage,
    speed: float,
    capacities: Capacities,
    *,
    at_speed: bool = False,
    loads: Sequence[Load] = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    points: int = 181,
    contact_height: float | None = None,
    dwell_tolerance: float | None = None,
    engine: str = "auto",
) -> PressRatings:
    """Find the permissible force of a press over its working stroke, and its permissible speed.

    The permissible force is the smallest of F_N, C / |ds/dtheta|, E / h and the forces that the bearings permit. A nominal height h_N
    defines the torque C = F_N |ds/dtheta| at h_N. The working stroke goes downwards, against the slide's direction.

    Friction raises the torque for a process force and changes the bearing forces. The friction loss of a process force reduces energies;
    the motor covers the losses of the idle press and of dampers.

    For a sliding driver C is its force capacity and theta its position. The driver moves harmonically, as in `cycle`. Capacities of energy
    and speed, and the dwell, need a crank; they are refused for a sliding driver.

    Args:
        press: a press with one driver, and a slide with one top and one bottom dead centre; if the driver slides, these are the ends of its
            travel.
        speed: speed of the driver joint in operation, negative backwards [rad/s]; highest speed of a sliding driver, in the middle of its
            travel, where the sign has no effect [m/s].
        capacities: capacities of its parts.
        at_speed: whether torque and bearings also carry weights and inertia forces at this speed, as in operation. By default they carry
            the process force alone, as catalogues print ratings. A nominal height defines the same torque capacity in both cases, so with
            ``at_speed`` the force at this height differs from the nominal force.
        loads: springs and dampers, e.g. a balance cylinder, and constant forces on links, in addition to the process; only with
            ``at_speed``, like weights and inertia forces.
        friction: friction of bearings and guides, by their names. By default only the process force causes friction. With ``at_speed``
            weights, inertia forces and springs cause friction too; it may be viscous, and gibs may be preloaded.
        points: number of crank angles, or of positions of a sliding driver, in equal steps from top to bottom dead centre, at least 3. The
            nominal height and the heights at which the governing limit changes are added.
        contact_height: height above bottom dead centre at which the tool meets the work [m]; by default the nominal height.
        dwell_tolerance: distance from bottom dead centre that counts as dwell [m]; by default a hundredth of the stroke.
        engine: as in `cycle`.

    Raises:
        PinpressError: the press has several drivers or a slide that turns back more than twice in a stroke, a height is not within the
            stroke, a sliding driver cannot have a capacity, a load is a process load, friction locks the press, another argument is not
            as described, or the idle press exceeds a capacity, by its weight alone or (with ``at_speed``) at its speed. The message names
            the capacity, the crank angle and the speed.
        UnknownNameError: the press has no such bearing or link.
        SingularityError: the linkage locks within the period.
    """
    known_bearings(capacities, press)
    press.refuse_several_drivers(NO_RATINGS)
    refuse_by_driver(capacities)
    refuse_other_effort(capacities, press.driver_coordinates[0])
    turning = press.driver_coordinates[0].turns
    speed, points = _speed(speed, turning), whole_number("points", points, 3, MOST_POINTS)
    truth_value("at_speed", at_speed)
    refuse_unrated(press, loads, friction, at_speed=bool(at_speed))
    if not turning:
        _refuse_what_turns(press, capacities, dwell_tolerance)
    _doubt_capacities(press, capacities, speed)
    period = _period(press, speed, engine)
    quick_return = measures.quick_return_ratio(period) if turning else None  # raises an error for a slide with several working strokes
    beside = tuple(loads), FrozenMapping(friction)
    rated = rated_stroke(press, capacities, speed, at_speed=bool(at_speed), beside=beside, engine=engine)
    if at_speed:
        refuse_overloaded_idle(rated)
    return _ratings(rated, governing_limits(rated, points), period, quick_return, contact_height, dwell_tolerance)


def _period(press: Linkage, speed: float, engine: str) -> Motion:
    """One period, with equally many states in each stroke."""
    if not press.driver_coordinates[0].turns:
        return cycle(press, speed, engine=engine)
    strokes = round(press.period_turns / dead_centres(press).turns)
    return cycle(press, speed, points=strokes * math.ceil(TURN * press.period_turns / strokes), engine=engine)


def _doubt_capacities(press: Linkage, capacities: Capacities, speed: float) -> None:
    """Warn of capacities that are tiny compared with the weight of the slide."""
    weight = GRAVITY * float(press.model.inertias[press.slide_guide.joint + 1].mass)
    plausibility.forces("nominal_force", capacities.nominal_force, weight, feeble=0.3)
    if press.driver_coordinates[0].turns and capacities.motor_power is not None:
        plausibility.torque("motor_power by speed", capacities.motor_power / abs(speed), 0.5 * weight * dead_centres(press).stroke)


def _ratings(
    rated: RatedStroke,
    found: GoverningLimits,
    period: Motion,
    quick_return: float | None,
    contact_height: float | None,
    dwell_tolerance: float | None,
) -> PressRatings:
    """The ratings of a working stroke whose limits are known.

    Args:
        rated: the working stroke.
        found: its limits.
        period: motion of the press over a period at its speed.
        quick_return: quick return ratio of this motion; None if the driver slides.
        contact_height: as for `rate`.
        dwell_tolerance: as for `rate`.
    """
    press, capacities, speed, turning = rated.press, rated.capacities, rated.speed, rated.coordinate.turns
    motion = rated.motion(found.angle)
    height = rated.height(motion)
    stroke = measures.stroke(period) if turning else dead_centres(press).stroke
    contact = capacities.nominal_height if contact_height is None else positive("contact_height", contact_height, "m")
    tolerance = None
    if turning:
        tolerance = DWELL * stroke if dwell_tolerance is None else positive("dwell_tolerance", dwell_tolerance, "m")
    contact_speed, advantage = (None, None) if contact is None else _at_contact(rated, period, contact)
    return PressRatings(
        _press=press,
        capacities=capacities,
        driver_coordinate=rated.coordinate,
        speed=speed,
        at_speed=rated.at_speed,
        loads=rated.loads,
        friction=rated.friction,
        torque_capacity=rated.torque,
        crank_angle=found.angle,
        height=height,
        travel_per_angle=motion.slide_velocity / speed,
        slide_velocity=rated.in_operation(motion).slide_velocity,
        force=np.min(list(found.forces.values()), axis=0),
        limits=found.forces,
        limited_by=found.names,
        changes=tuple(float(height[k]) for k in found.changes),
        work=permitted_work(rated, found.angle),
        energies=dict(rated.energies),
        stroke=stroke,
        quick_return_ratio=quick_return,
        contact_height=contact,
        contact_speed=contact_speed,
        contact_advantage=advantage,
        dwell_tolerance=tolerance,
        dwell_time=None if tolerance is None else measures.dwell_time(period, tolerance),
        speed_limit=_speed_limit(rated),
        turns=rated.turns,
    )


def _speed_limit(rated: RatedStroke) -> PermissibleSpeed | None:
    """The speed at which the idle press reaches a capacity; None if forces are not affine in the square of the speed."""
    damped = any(isinstance(load, Spring) and load.damping for load in rated.loads)
    if not rated.coordinate.turns or rated.friction or rated.press.uneven or damped:
        return None
    way = math.copysign(1.0, rated.speed)
    return limiting_speed(rated.press, rated.capacities, rated.torque, way, rated.loads, rated.engine)


def _at_contact(rated: RatedStroke, period: Motion, height: float) -> tuple[float, float]:
    """Speed of the slide [m/s] and mechanical advantage at a height; arguments as for `_ratings`."""
    if rated.coordinate.turns:
        return measures.speed_at(period, height), measures.mechanical_advantage(period, height)
    motion = rated.motion(np.array([angle_at(rated, "contact_height", height)]))
    return abs(float(rated.in_operation(motion).slide_velocity[0])), abs(rated.speed / float(motion.slide_velocity[0]))


def _refuse_what_turns(press: Linkage, capacities: Capacities, dwell_tolerance: float | None) -> None:
    """Raise PinpressError for arguments that need a crank, for a press with a sliding driver."""
    given: dict[str, tuple[object, str]] = {
        "flywheel_inertia and speed_drop": (capacities.flywheel_inertia, "give the force of the driver as torque [N]"),
        "motor_power": (capacities.motor_power, "compare the power with the driving force x driver speed of inverse_dynamics"),
        "slide_acceleration": (capacities.slide_acceleration, "compare it with slide_acceleration of cycle(press, speed)"),
        "shaking_force": (capacities.shaking_force, "compare it with shaking_force of inverse_dynamics(press, cycle(press, speed))"),
        "dwell_tolerance": (dwell_tolerance, "take the dwell from the motion that its control makes"),
    }
    for name, (value, instead) in given.items():
        if value is not None:
            press.refuse_sliding_driver(f"ratings take {name} of a crank alone; instead, {instead}")


def _speed(speed: float, turning: bool) -> float:
    unit, such = ("rad/s", "70 * pinpress.RPM") if turning else ("m/s", "0.1")
    wanted = f"one number that is not zero [{unit}], e.g. {such}"
    return float(suitable_numbers("speed", in_unit("speed", speed, unit), wanted, suits=lambda value: SLOWEST <= abs(value) <= FASTEST))


def conditions_in_words(ratings: PressRatings) -> str:
    """The speed, and the forces that count in addition to the process."""
    what = "with weights and inertia forces at this speed" if ratings.at_speed else "the process force alone, as catalogues print it"
    what += "".join(f", with {words}" for words, given in (("springs", ratings.loads), ("friction", ratings.friction)) if given)
    if ratings.driver_coordinate.turns:
        pace = f"{abs(ratings.speed) / RPM / ratings.turns:g} strokes/min{'' if ratings.speed > 0 else ', backwards'}"
    else:
        pace = f"up to {1e3 * abs(ratings.speed):g} mm/s of the driver"
    return f"{pace}; forces: {what}"
