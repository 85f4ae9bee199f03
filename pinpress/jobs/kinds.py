"""Kinds of parts that a job names by ``kind``: motors, loads, paths and limits of a servo press, criteria of balancing.

The keys of a part are the fields of its class. What is not declared there, or stands in a file of its own, is said here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ..balancing.problem import AXES, QUANTITIES, AddedMass, Peak, Range, Rms
from ..balancing.regions import CounterweightRegion
from ..common.errors import PinpressError
from ..common.parameters import Checked, parameter
from ..common.quantities import CRANK, RAM
from ..common.reading.entries import Entry
from ..common.reading.filling import Around, DataColumns, Either, Named, Number, Numbers, OneOf, Part, Rows, Text, Truth, Value
from ..drives.motors import ConstantTorque, InductionMotor, InverterMotor, ServoMotor
from ..drives.slip_clutch import SlipClutchMotor
from ..drives.transmission import Brake, Clutch, Flywheel, Geared, PrescribedSpeed, SwitchPoint
from ..loads.contacts import Impact, TwoSidedStop
from ..loads.hydraulics import HydraulicCushion, ImpactDamper
from ..loads.link import PointForce, PointMoment, SpringDamper, TorsionSpring
from ..loads.pneumatics import BalanceCylinder, PneumaticCushion
from ..loads.process import Blanking, ConstantForce, DeepDrawing, ElasticDie, ForceStroke, Idle
from ..loads.shearing import RateSensitiveBlanking
from ..ratings.pin_use import EXPONENTS, RollingBearing
from ..servo.drive import ServoDrive
from ..servo.limits import (
    BearingForce,
    CrankAcceleration,
    CrankSpeed,
    FeedWindow,
    RmsTorque,
    SlideAcceleration,
    SlideSpeed,
    TorqueRate,
)
from ..servo.paths import Pendulum, Pulse, Stop, Turn
from ..simulation.elastic.contact import LAWS, Clearance
from ..simulation.elastic.preloaded_joint import PreloadedJoint

# ------------------------------------------------------------------------------------------------------------------------------- loads

LOADS = OneOf(
    {
        "idle": Part(Idle, "{kind: idle}"),
        "constant-force": Part(ConstantForce, "{kind: constant-force, force: 1000 kN, height: 0.5 mm}"),
        "blanking": Part(Blanking, "{kind: blanking, force: 1000 kN, start: 6 mm, end: 2 mm}"),
        "drawing": Part(DeepDrawing, "{kind: drawing, force: 500 kN, start: 50 mm}"),
        "table": Part(
            ForceStroke,
            "{kind: table, file: stroke.csv}",
            {"file": DataColumns(("height", "force"), ("m", "N"), ("m", "N"), ("heights", "forces"))},
            without=("heights", "forces"),
            needed=("file",),
        ),
        "die": Part(ElasticDie, "{kind: die, height: 1 mm, stiffness: 1 GN/m}"),
        "impact": Part(Impact, "{kind: impact, height: 1 mm, stiffness: 1e10 N/m^1.5, damping: 100 kN s/m, depth: 0.1 mm}"),
        "shearing": Part(
            RateSensitiveBlanking,
            "{kind: shearing, force: 600 kN, start: 4 mm, end: 2 mm, sensitivity: 0.05, reference_speed: 1 mm/s}",
        ),
        "stops": Part(TwoSidedStop, "{kind: stops, lower: -1 mm, upper: 32 mm, stiffness: 1e10 N/m^1.5}"),
        "balance-cylinder": Part(BalanceCylinder, "{kind: balance-cylinder, bore: 160 mm, pressure: 6 bar, volume: 80 l, count: 2}"),
        "impact-damper": Part(ImpactDamper, "{kind: impact-damper, heights: 0 8 mm, coefficients: 2e6 2e6 N s^2/m^2}"),
        "hydraulic-cushion": Part(HydraulicCushion, "{kind: hydraulic-cushion, force: 300 kN, height: 60 mm, rise: 1 mm}"),
        "air-cushion": Part(PneumaticCushion, "{kind: air-cushion, bore: 200 mm, pressure: 5 bar, volume: 40 l, height: 12 mm}"),
        "point-force": Part(PointForce, "{kind: point-force, link: slide, force: 0 0 5 kN}"),
        "moment": Part(PointMoment, "{kind: moment, link: rod, moment: 20 N m}"),
        "torsion-spring": Part(
            TorsionSpring, "{kind: torsion-spring, link1: crank, link2: rod, stiffness: 500 N m/rad, free_angle: 30 deg}"
        ),
        "spring": Part(
            SpringDamper, "{kind: spring, link1: frame, link2: slide, stiffness: 200 kN/m, free_length: 400 mm, point1: 0 0 500 mm}"
        ),
    }
)

# ------------------------------------------------------------------------------------------------------------------------------ drives


def _geared(made: Callable[..., Any], given: dict[str, Any]) -> Any:
    """A motor behind its gear, if it has one."""
    gear = {name: given.pop(name) for name in GEAR if name in given}
    if gear and "ratio" not in gear:
        raise PinpressError(f"{' and '.join(gear)} without a ratio: write ratio, turns of the motor in a turn of the crank")
    return Geared(made(**given), **gear) if gear else made(**given)


GEAR: Mapping[str, Value] = {"ratio": Number("-"), "gear_inertia": Number("kg m2"), "efficiency": Number("-")}


def _motor(made: type, example: str, keys: Mapping[str, Value] | None = None, without: tuple[str, ...] = ()) -> Part[Any]:
    keys = keys or {}
    return Part(made, example, {**keys, **GEAR}, without, tuple(name for name in keys if name == "program"), _geared)


class Motors(OneOf):
    """A motor or other drive. One behind gears has torques and speeds of rotation also on a driver that slides."""

    def read(self, entry: Entry, around: Around) -> Any:
        """The drive."""
        geared = isinstance(entry.value, Mapping) and "ratio" in entry.value
        return super().read(entry, replace(around, coordinate=CRANK) if geared else around)


MOTORS = Motors(
    {
        "constant": _motor(ConstantTorque, "{kind: constant, value: 567 N m}"),
        "induction": _motor(
            InductionMotor,
            "{kind: induction, rated_power: 75 kW, rated_speed: 1485 r/min, inertia: 1.2 kg m2, ratio: 20.7, efficiency: 0.95}",
        ),
        "inverter": _motor(
            InverterMotor,
            "{kind: inverter, rated_torque: 482 N m, rated_speed: 1485 r/min, frequency: 40 Hz, ratio: 20.7}",
            {"curve": DataColumns(("frequency", "torque"), ("Hz", "N m"), ("Hz", "N m"), ("curve",))},
        ),
        "slip-clutch": _motor(
            SlipClutchMotor,
            "{kind: slip-clutch, rated_torque: 189 N m, primary_speed: 1470 r/min, top_speed: 1320 r/min, set_speed: 900 r/min, ratio: 3}",
        ),
        "servo": _motor(
            ServoMotor,
            "{kind: servo, program: motion.csv, stiffness: 20 kN m/rad, damping: 900 N m s/rad, peak_torque: 5 kN m, ratio: 10}",
            {"program": DataColumns(("time", "angle"), ("s", "rad"), ("s", "deg"), ("times", "angles"), sliding=("position", "m", "mm"))},
            ("times", "angles"),
        ),
        "prescribed": Part(PrescribedSpeed, "{kind: prescribed, speed: 70 r/min}"),
    }
)


class Instant(Text):
    """A time, or a crank angle."""

    def read(self, entry: Entry, around: Around) -> SwitchPoint:  # type: ignore[override]
        """The instant."""
        text = entry.text("a time as 0.1 s, or a crank angle as 350 deg").strip()
        if re.fullmatch(r"[-+.\deE]+", text) and float(text):
            entry.refuse(f"{text} has no unit", f"write {text} deg of the crank, or {text} s")
        angle = text.rstrip("0123456789").endswith(("deg", "°", "rad", "turn", "turns", "rev"))
        number = Number("rad" if angle else "s").read(entry, around)
        return SwitchPoint(angle=number) if angle else SwitchPoint(time=number)


_SWITCHED: Mapping[str, Value] = {"closes": Instant(), "opens": Instant()}
FLYWHEEL = Either(Number("kg m2"), Part(Flywheel, "{inertia: 6000 kg m2, speed: 70 r/min}"), Flywheel)
CLUTCH = Part(Clutch, "{torque: 60 kN m, rise: 0.1 s, closes: 0.2 s}", _SWITCHED)
BRAKE = Part(Brake, "{torque: 40 kN m, closes: 350 deg}", _SWITCHED)

# ---------------------------------------------------------------------------------------------------------------------------- bearings

CLEARANCE = Either(Number("m"), Part(Clearance, "{radial: 0.1 mm}", {"law": Text(tuple(LAWS))}), Clearance)
JOINT = Part(PreloadedJoint, "{loaded: 2 GN/m, relieved: 6 GN/m, preload: 2500 kN}")


@dataclass(frozen=True)
class Bearing(Checked):
    """What a job says of a bearing or guide beside its place. What is None is not said.

    Attributes:
        friction: coefficient of Coulomb friction [-].
        viscous: viscous torque by angular speed [N m s/rad], in a guide viscous force by speed [N s/m].
        preload: force with which all gibs of a guide press on the slide without a load [N].
        radius: of friction [m]; None: half of the diameter.
        diameter: of the pin [m].
        width: of the bearing, of a guide across its axis [m].
        length: of the gibs of a guide along its axis [m].
        middle: middle of the gibs above the link's origin, along the guide's axis [m]; None: 0.
        stiffness: across the axis [N/m].
        moment_stiffness: against turning [N m/rad].
        clearance: of a pin, or None.
        joint: preloaded gibs of a guide, in place of its stiffness, or None.
        permissible: largest force [N].
        pressure: permissible, of the projected surface of a pin or of the gibs of a guide [Pa].
        wear_rate: worn volume / (force x rubbing way) [1/Pa].
        rolling: rolling bearings on the pin, or None. Other pins with diameter and width, and guides with length and width, are rated too.
    """

    friction: float | None = field(default=None, metadata=parameter("-", "not negative"))
    viscous: float | None = field(default=None, metadata=parameter("N m s/rad", "not negative"))
    preload: float | None = field(default=None, metadata=parameter("N", "not negative"))
    radius: float | None = field(default=None, metadata=parameter("m", "not negative"))
    diameter: float | None = field(default=None, metadata=parameter("m", "positive"))
    width: float | None = field(default=None, metadata=parameter("m", "positive"))
    length: float | None = field(default=None, metadata=parameter("m", "positive"))
    middle: float | None = field(default=None, metadata=parameter("m"))
    stiffness: float | None = field(default=None, metadata=parameter("N/m", "positive"))
    moment_stiffness: float | None = field(default=None, metadata=parameter("N m/rad", "positive"))
    clearance: Clearance | None = None
    joint: PreloadedJoint | None = None
    permissible: float | None = field(default=None, metadata=parameter("N", "positive"))
    pressure: float | None = field(default=None, metadata=parameter("Pa", "positive"))
    wear_rate: float | None = field(default=None, metadata=parameter("1/Pa", "not negative"))
    rolling: RollingBearing | None = None


class Viscous(Number):
    """Viscous friction of a pin, or of a guide in the unit of one; which of them it is the press knows."""

    def read(self, entry: Entry, around: Around) -> Any:
        """The torque by angular speed [N m s/rad], or the force by speed [N s/m]."""
        in_guide = isinstance(entry.value, str) and entry.value.endswith(("s/m", "s/mm"))
        return super().read(entry, replace(around, coordinate=RAM if in_guide else CRANK))


ROLLING = Part(RollingBearing, "{rating: 800 kN, kind: roller, count: 2}", {"kind": Text(tuple(EXPONENTS))})
BEARING = Part(
    Bearing,
    "{friction: 0.05, diameter: 200 mm, width: 160 mm}",
    {"viscous": Viscous("N m s/rad"), "clearance": CLEARANCE, "joint": JOINT, "rolling": ROLLING},
)

# ---------------------------------------------------------------------------------------------------------------------- load cases


class Cases(Text):
    """Which load cases: angles, or a text such as "extremes" or "peak W"."""

    def read(self, entry: Entry, around: Around) -> Any:
        """The text, or angles of the first driver."""
        text = entry.value if isinstance(entry.value, str) else ""
        return text if text[:1].isalpha() else Numbers("rad").read(entry, around)


CASES = Cases()

# ------------------------------------------------------------------------------------------------------------------------------- servo

_FLANK = Text(("down", "up", "both"))
_BETWEEN: Mapping[str, Value] = {"heights": Numbers("m"), "flank": _FLANK}
LIMITS = OneOf(
    {
        "slide-speed": Part(SlideSpeed, "{kind: slide-speed, speed: 200 mm/s, heights: 60 0 mm}", _BETWEEN),
        "crank-speed": Part(CrankSpeed, "{kind: crank-speed, speed: 40 r/min}", _BETWEEN),
        "slide-acceleration": Part(SlideAcceleration, "{kind: slide-acceleration, acceleration: 20 m/s2}", _BETWEEN),
        "crank-acceleration": Part(CrankAcceleration, "{kind: crank-acceleration, acceleration: 30 rad/s2}"),
        "bearing-force": Part(BearingForce, "{kind: bearing-force, bearing: A, force: 2 MN}"),
        "torque-rate": Part(TorqueRate, "{kind: torque-rate, rate: 20000 N m/s}"),
        "rms": Part(RmsTorque, "{kind: rms, torque: 600 N m}"),
        "feed-window": Part(FeedWindow, "{kind: feed-window, height: 150 mm, time: 0.8 s}"),
    }
)
PATHS = OneOf(
    {
        "turn": Part(Turn, "{kind: turn, backwards: yes}"),
        "stop": Part(Stop, "{kind: stop, bottom: 0.15 s}"),
        "pendulum": Part(Pendulum, "{kind: pendulum, opening: 60 mm, dwell: 0.2 s}"),
        "pulse": Part(Pulse, "{kind: pulse, heights: 20 10 0 mm, back: 2 mm}", {"heights": Numbers("m")}),
    }
)
SERVO_DRIVE = Part(ServoDrive, "{inertia: 1.5 kg m2, ratio: 60, gear_inertia: 50 kg m2, peak_torque: 2100 N m, rated_torque: 800 N m}")

# ----------------------------------------------------------------------------------------------------------------------------- balance


class Axis(Text):
    """An axis by its name, or a direction."""

    def read(self, entry: Entry, around: Around) -> Any:
        """The name, or three numbers."""
        return entry.value if isinstance(entry.value, str) and entry.value in AXES else Numbers("-").read(entry, around)


class Bound(Number):
    """A number in the unit of its criterion, which is known when that is read."""

    def read(self, entry: Entry, around: Around) -> Any:
        """The entry itself."""
        return entry


def _criterion(made: Callable[..., Any], given: dict[str, Any]) -> tuple[Any, float, Entry | None]:
    """A criterion, its weight, and what it may be at most."""
    weight, most = given.pop("weight", 1.0), given.pop("most", None)
    return made(**given), weight, most


def _of_criteria(made: type, example: str, keys: Mapping[str, Value]) -> Part[Any]:
    return Part(made, example, {**keys, "weight": Number("-"), "most": Bound("-")}, finish=_criterion)


_OF_FORCES: Mapping[str, Value] = {"quantity": Text(tuple(QUANTITIES)), "axis": Axis(), "about": Numbers("m")}
CRITERIA = OneOf(
    {
        "range": _of_criteria(Range, "{kind: range, quantity: shaking_force, axis: z}", _OF_FORCES),
        "rms": _of_criteria(Rms, "{kind: rms, quantity: driving_torque}", _OF_FORCES),
        "peak": _of_criteria(Peak, "{kind: peak, quantity: bearing_force, bearing: A, most: 100 kN}", _OF_FORCES),
        "added-mass": _of_criteria(AddedMass, "{kind: added-mass, most: 661 kg}", {}),
    }
)


class _Masses(Numbers):
    """The least and the largest mass."""

    def read(self, entry: Entry, around: Around) -> Any:
        masses = super().read(entry, around)
        return masses if len(masses) == 2 else entry.refuse(f"{len(masses)} numbers", "write the least and the largest mass: 0 200 kg")


class Regions(Named):
    """Regions for counterweights by names, which are those of links where a region names none."""

    def read(self, entry: Entry, around: Around) -> Any:
        """The regions by their names."""
        found = {}
        for name, each in entry.items(self.example).items():
            items = dict(each.known(tuple(REGION.values), REGION.example))
            found[name] = REGION.of(each, {"link": replace(each, value=name), **items}, around)
        return found


REGION = Part(
    CounterweightRegion,
    "{radius: 300 mm, mass: 0 200 kg}",
    {
        "link": Text(),
        "mass": _Masses("kg"),
        "at": Numbers("m"),
        "radius": Number("m"),
        "centre": Numbers("m"),
        "corners": Rows("m"),
        "gyration": Number("m"),
        "replaces": Truth(),
        "reset": Text(("mass", "position")),
    },
    without=("link",),
)
