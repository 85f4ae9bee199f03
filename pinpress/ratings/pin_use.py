"""Pins, guides, rolling bearings: pressure, rubbing way, wear, equivalent load and life, from forces and the turn between two links.

Every sum over the motion is an integral between the edges of loads and the reversals of each bearing, where force or speed jump. A sum over
equal states would be wrong for a blow of a few degrees.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..common.arguments import expect, typed, whole_number
from ..common.errors import PinpressError, UnknownNameError, caution, shown
from ..common.frozen import FrozenMapping
from ..common.parameters import Checked, parameter
from ..common.quantities import Array
from ..common.results import Record, Records, Tabular
from ..common.tables import Columns
from ..dynamics.applied_loads import RelativeTurn, turn_between
from ..dynamics.extremes import between_states
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion, is_cycle
from ..kinematics.poses import rotation_of
from ..kinematics.slide_path import stroke_turns
from ..linkage.linkage import Linkage, OfPress
from .eccentric_loads import DIRECTION, Gibs, gib_pressure

EXPONENTS = {"ball": 3.0, "roller": 10.0 / 3.0}  # of life by load, ISO 281
FRETTING = math.radians(5.0)  # below a swing of about this size rolling bearings fret, and the life of ISO 281 says nothing


@dataclass(frozen=True)
class PlainBearing(Checked):
    """A plain bearing of a pin.

    Attributes:
        diameter: of the pin [m].
        width: of the bearing, of all its parts together [m].
        pressure: permissible projected pressure [Pa]; None: no limit.
        wear_rate: worn volume / (force x rubbing way), k of Archard's law [1/Pa]: 1e-15 is 1e-6 mm3/(N m). None: no wear is computed.
    """

    diameter: float = field(metadata=parameter("m", "positive"))
    width: float = field(metadata=parameter("m", "positive"))
    pressure: float | None = field(default=None, metadata=parameter("Pa", "positive"))
    wear_rate: float | None = field(default=None, metadata=parameter("1/Pa", "not negative"))


@dataclass(frozen=True)
class RollingBearing(Checked):
    """Rolling bearings on a pin, for radial load.

    Attributes:
        rating: dynamic load rating C of one bearing [N].
        kind: "ball" or "roller".
        count: bearings next to each other that share the force equally.
        static_rating: static load rating C0 of one bearing [N]; None: no static safety.
    """

    rating: float = field(metadata=parameter("N", "positive"))
    kind: str = "roller"
    count: int = 1
    static_rating: float | None = field(default=None, metadata=parameter("N", "positive"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.kind, str) or self.kind not in EXPONENTS:
            raise PinpressError(f"RollingBearing: kind is {shown(self.kind)}: give 'ball' or 'roller'")
        whole_number("RollingBearing: count", self.count, 1, 100)


UNITS = {"largest_force": "N", "at": "rad", "way": "rad", "swing": "rad", "rubbing_way": "m", "largest_pressure": "Pa", "pressure": "Pa"}
UNITS |= {
    "pressure_over_way": "Pa",
    "pv": "W/m2",
    "largest_pv": "W/m2",
    "wear": "m",
    "largest_tilting": "N m",
    "equivalent_load": "N",
    "hours": "h",
}


@dataclass(frozen=True, repr=False)
class PinUse(Record, units=UNITS):
    """How a motion uses a bearing. A stroke is a stroke of the slide; without a slide, and in motions that are not a period, it is the
    whole motion. In each state the pressure of a guide is that at the end of the gibs where it is largest, by force and tilting moment.

    Attributes:
        bearing: its name.
        largest_force: largest force across the pin's axis, of a guide along the normal of its gibs [N].
        at: angle or position of the first driver there [rad or m].
        way: angle by which the links turn relative to each other in a stroke, forwards and backwards added up [rad]; None for a guide.
        swing: from one end of the swing to the other [rad]; None for a guide, and if the bearing turns fully.
        rubbing_way: way x half the diameter, of a guide its travel [m]; this and the next ones are None for a rolling bearing.
        largest_pressure: largest force / (diameter x width), of a guide at the end of a gib [Pa].
        pressure: mean over time [Pa].
        pressure_over_way: mean over the way [Pa].
        pv: mean over time of pressure x rubbing speed [W/m2]; 1e6 W/m2 are 1 MPa m/s.
        largest_pv: largest pressure x rubbing speed [W/m2].
        wear: mean depth worn off the projected surface in a stroke [m]; None without a wear rate.
        largest_tilting: largest tilting moment of a guide about the middle of its gibs [N m]; None for a pin.
        equivalent_load: P of one bearing, the mean of its force over the way with the exponent of life [N]; this and the next ones are None
            for a plain bearing.
        strokes: L10, strokes that 90 % of such bearings survive [-]; infinite without force or way.
        hours: the same in hours of this motion [h].
        static_safety: C0 / largest force on one bearing [-]; None without a static rating.
    """

    bearing: str
    largest_force: float
    at: float
    way: float | None = None
    swing: float | None = None
    rubbing_way: float | None = None
    largest_pressure: float | None = None
    pressure: float | None = None
    pressure_over_way: float | None = None
    pv: float | None = None
    largest_pv: float | None = None
    wear: float | None = None
    largest_tilting: float | None = None
    equivalent_load: float | None = None
    strokes: float | None = None
    hours: float | None = None
    static_safety: float | None = None


@dataclass(frozen=True, eq=False, repr=False)
class PinRatings(OfPress, Tabular):
    """How a motion uses pins, guides and rolling bearings.

    Attributes:
        press_name: name of the press.
        bearings: name -> the bearing, as given.
        uses: name -> how it is used.
        stroke_time: mean time of a stroke, see `PinUse` [s].
    """

    _press: Linkage
    bearings: Mapping[str, PlainBearing | RollingBearing | Gibs]
    uses: Mapping[str, PinUse]
    stroke_time: float

    def __getitem__(self, name: str) -> PinUse:
        if name not in self.uses:
            raise UnknownNameError("rated bearing", name, self.uses)
        return self.uses[name]

    @property
    def title(self) -> str:
        return f"PinRatings of {self.press_name}: {', '.join(f'{use.bearing} {use.largest_force:.6g} N' for use in self.uses.values())}"

    def columns(self) -> Columns:
        """A row for each bearing; columns that no bearing has are left out."""
        return Records(PinUse, self.uses.values()).columns()


@typed
def pins(reactions: Reactions, bearings: Mapping[str, PlainBearing | RollingBearing | Gibs]) -> PinRatings:
    """Rate pins, guides and rolling bearings: pressure, p v, rubbing way, wear, equivalent load, life and static safety.

    The life is that of ISO 281 without factors for lubricant and reliability, by Palmgren and Miner over the true turn between the two
    links of each bearing, so the formula is the same for turning and swinging bearings. It is not valid for swings in which no rolling
    element reaches the place of the next one, about 720 deg / number of elements.

    Args:
        reactions: reactions of all bearings to a motion with times.
        bearings: name of a bearing -> `PlainBearing` or `RollingBearing`; of a guide -> `Gibs`.

    Raises:
        UnknownNameError: the press has no such bearing.
        PinpressError: a bearing is a fixed loop, a loop in space without one axis, or has another kind of size than its own; the slide tips
            on a single gib; the gibs do not face across the guide; the reactions leave out a bearing, or the motion has no times.

    Warns:
        PinpressWarning: a load rating is below the largest force, or a rolling bearing swings by less than 5 deg.
    """
    expect("reactions", reactions, Reactions, "inverse_dynamics")
    press, motion = reactions._press, reactions.motion
    turns = {name: _turn(press, name, given) for name, given in bearings.items()}
    if motion._time is None or len(motion.time) < 2:
        raise PinpressError("the motion has no times, over which to integrate: give servo_cycle(press, angle, time=time)")

    def quantities(reactions: Reactions) -> Iterator[tuple[Array, float]]:
        for name, turn in turns.items():
            given, place, rate = bearings[name], turn.angle(reactions.motion.joint_position), np.abs(turn.angle(reactions.motion.v))
            pressing = _on_gibs(reactions, name, given) if isinstance(given, Gibs) else (_across(reactions, name, turn),)
            yield from ((values[:, None], 0.0) for values in (place, rate, *pressing, pressing[-1] * rate))

    def reversing(motion: Motion) -> tuple[Array, Array]:
        rates = ([turn.angle(values) for turn in turns.values()] for values in (motion.v, motion.a))
        return tuple(map(np.array, rates))  # type: ignore[return-value]

    between = between_states(reactions, quantities, reversing)
    peaks, (states, weight, _) = between.peak_states().reactions, between.mean_states()
    time, strokes = float(weight.sum()), _strokes(press, motion)

    uses = {}
    for name, turn in turns.items():
        given, rate = bearings[name], np.abs(turn.angle(states.motion.v))
        if isinstance(given, Gibs):
            uses[name] = _of_guide(peaks, name, given, turn, states, weight, strokes)
            continue
        force = _across(states, name, turn)
        at_peak = _across(peaks, name, turn)
        worst = int(at_peak.argmax())
        largest, angle = float(at_peak[worst]), turn.angle(peaks.motion.joint_position)
        way = float(weight @ rate)
        through = is_cycle(motion) and abs(float(weight @ turn.angle(states.motion.v))) > 1e-9 * way
        place = float(np.ravel(peaks.motion.crank_angle[worst])[0])
        use = PinUse(name, largest, place, way / strokes, None if through else float(np.ptp(angle)))
        if isinstance(given, PlainBearing):
            speed = 0.5 * given.diameter * rate
            most = 0.5 * given.diameter * float((at_peak * np.abs(turn.angle(peaks.motion.v))).max())
            area = given.diameter * given.width
            pressed = replace(use, largest_pressure=use.largest_force / area, largest_pv=most / area)
            uses[name] = _rubbed(pressed, given.wear_rate, force / area, speed, weight, strokes)
        else:
            uses[name] = _of_rolling(use, given, force / given.count, rate, weight, strokes)
    return PinRatings(press, FrozenMapping(bearings), FrozenMapping(uses), time / strokes)


def _rubbed(use: PinUse, wear_rate: float | None, pressure: Array, speed: Array, weight: Array, strokes: float) -> PinUse:
    """The use with means of pressures (n,) [Pa] and rubbing speeds (n,) [m/s], with weights in time (n,) [s]."""
    time, rubbed, way = float(weight.sum()), float(weight @ (pressure * speed)), float(weight @ speed)
    return replace(
        use,
        rubbing_way=way / strokes,
        pressure=float(weight @ pressure) / time,
        pressure_over_way=rubbed / way if way else None,
        pv=rubbed / time,
        wear=None if wear_rate is None else wear_rate * rubbed / strokes,
    )


class _GibLoad(NamedTuple):
    """Load on the gibs of a guide in n states.

    Attributes:
        normal: (n,) size of the force along the gibs' normal [N].
        tilting: (n,) size of the moment about the middle of the gibs [N m].
        pressure: (n,) largest pressure [Pa].
    """

    normal: Array
    tilting: Array
    pressure: Array


def _on_gibs(reactions: Reactions, name: str, gibs: Gibs) -> _GibLoad:
    """The load on the gibs of a guide.

    Raises:
        PinpressError: the gibs do not face across the guide, or no plane says how they face; the slide tips on a single gib.
    """
    press, motion = reactions._press, reactions.motion
    body = press.joints.index(name) + 1
    link = press.model.frames[press.model.getFrameId(press.link_of(body), pin.BODY)]
    rotation = rotation_of(press, motion.joint_position, body)
    axis = rotation @ press.axes[body - 1].direction
    if gibs.normal is None:
        refusal = f"{press.name} is not planar: give the direction in which the gibs of {name} face, Gibs(..., normal=(x, y, z))"
        normal = np.cross(press.plane_or_refuse(refusal).normal, axis)
    else:
        normal = np.broadcast_to(np.array(gibs.normal) / np.linalg.norm(gibs.normal), axis.shape)
        if np.abs(np.einsum("nk,nk->n", normal, axis)).max() > DIRECTION:
            raise PinpressError(f"the gibs' normal {list(gibs.normal)} is not across the axis of {name}: gibs face across it")
    middle = rotation @ link.placement.translation + gibs.middle * axis  # the moment is about the joint frame's origin
    force = reactions.bearing_force[name]
    moment = reactions.bearing_moment[name] - np.cross(middle, force)
    across, tilting = (np.abs(np.einsum("nk,nk->n", *pair)) for pair in ((force, normal), (moment, np.cross(axis, normal))))
    return _GibLoad(across, tilting, gib_pressure(gibs, across, tilting, motion)[0])


def _of_guide(peaks: Reactions, name: str, gibs: Gibs, turn: RelativeTurn, states: Reactions, weight: Array, strokes: float) -> PinUse:
    """The use of a guide, largest at its peaks, with means over states with weights in time (n,) [s]."""
    pressure, speed = _on_gibs(states, name, gibs).pressure, np.abs(turn.angle(states.motion.v))
    most, fastest = _on_gibs(peaks, name, gibs), np.abs(turn.angle(peaks.motion.v))
    worst = int(most.pressure.argmax())
    use = PinUse(
        name,
        float(most.normal.max()),
        float(np.ravel(peaks.motion.crank_angle[worst])[0]),
        largest_pressure=float(most.pressure[worst]),
        largest_pv=float((most.pressure * fastest).max()),
        largest_tilting=float(most.tilting.max()),
    )
    return _rubbed(use, gibs.wear_rate, pressure, speed, weight, strokes)


def _of_rolling(use: PinUse, bearing: RollingBearing, force: Array, rate: Array, weight: Array, strokes: float) -> PinUse:
    """The use of a rolling bearing under forces (n,) on each of its bearings, that turns at rates (n,), with weights in time (n,) [s]."""
    exponent, peak = EXPONENTS[bearing.kind], use.largest_force / bearing.count
    if bearing.rating < peak:
        caution(f"{use.bearing}: its load rating C is {bearing.rating:g} N, below its largest force of {peak:.4g} N: check that C is in N")
    if use.swing is not None and use.swing < FRETTING:
        swing = math.degrees(use.swing)
        caution(f"{use.bearing} swings by {swing:.3g} deg: below about 5 deg a rolling bearing frets, and its life by ISO 281 is not valid")
    turned = float(weight @ rate)
    # relative to the rating, so that no power overflows
    damage = float(weight @ ((force / bearing.rating) ** exponent * rate))
    life = 1e6 * 2 * np.pi * strokes / damage if damage else math.inf
    return replace(
        use,
        equivalent_load=bearing.rating * (damage / turned) ** (1 / exponent) if turned else None,
        strokes=life,
        hours=life * float(weight.sum()) / strokes / 3600,
        static_safety=None if bearing.static_rating is None or not peak else bearing.static_rating / peak,
    )


def _turn(press: Linkage, name: str, given: object) -> RelativeTurn:
    """How the two links of a bearing turn against each other, or how those of a guide slide."""
    if name not in press.bearings:
        raise UnknownNameError("bearing", name, press.bearings)
    if not isinstance(given, PlainBearing | RollingBearing | Gibs):
        raise PinpressError(f"bearings of {shown(name)} is {shown(given)}: give a PlainBearing or a RollingBearing, of a guide Gibs")
    slides = name in press.joints and not press.axes[press.joints.index(name)].turns
    if slides != isinstance(given, Gibs):
        what = "a guide: give Gibs(length, width)" if slides else "a pin, which has no gibs: give PlainBearing(diameter, width)"
        raise PinpressError(f"{name} is {what}")
    if name in press.joints:
        joint = press.joints.index(name)
        bodies = press.model.parents[joint + 1], joint + 1
        if slides:
            return RelativeTurn(bodies, press.axes[joint].direction, np.eye(len(press.axes))[joint])
    else:
        loop = next(loop for loop in press.loops if loop.name == name)
        bodies = loop.joint1, loop.joint2
    turn = turn_between(press, bodies, f"bearing {name}: between its links", "leave it out")
    if turn is None:
        raise PinpressError(f"{name} does not turn: leave it out")
    return turn


def _across(reactions: Reactions, name: str, turn: RelativeTurn) -> Array:
    """Forces (n,) across the axis of a pin [N]."""
    force = reactions.bearing_force[name]
    axis = rotation_of(reactions._press, reactions.motion.joint_position, turn.bodies[1]) @ turn.axis
    return np.asarray(np.linalg.norm(np.cross(force, axis), axis=1))


def _strokes(press: Linkage, motion: Motion) -> float:
    """Strokes of a motion; 1 for a motion that is not a period."""
    if not is_cycle(motion) or len(motion.drivers) > 1 or not motion.driver_coordinates[0].turns:
        return 1.0
    return float((motion.period_turns or 1) / (stroke_turns(press) or 1))
