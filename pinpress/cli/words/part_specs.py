"""Read parts of a press from the command line, such as ``--motor induction:rated_power=75kW,rated_speed=1485,ratio=20.7``.

All commands have the same grammar for loads, springs, friction, motors, flywheels, clutches, brakes, elastic parts, and the frame on its
mounts.

Keys are the fields of the classes of `drives`, `loads` and `foundation`. Values are in SI units or have a unit; speeds are in r/min, or in
mm/s for a sliding driver. A clutch or brake is switched at a time, ``0.1s``, or at a crank angle, ``180deg``. Points and forces are
``x/y/z``. Tables of numbers come from CSV files of two columns.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, fields, replace
from dataclasses import field as declare
from functools import partial
from typing import Any, Generic, TypeVar

from ...common import tables
from ...common.errors import PinpressError, UnknownNameError, suggestion
from ...common.parameters import declared, in_signature, parameter
from ...common.quantities import CRANK, RAM, DriverCoordinate
from ...drives.motors import ConstantTorque, InductionMotor, InverterMotor, ServoMotor
from ...drives.protocol import Drive
from ...drives.slip_clutch import SlipClutchMotor
from ...drives.transmission import Brake, Clutch, Flywheel, Geared, PrescribedSpeed, SwitchPoint
from ...foundation.mounts import Frame, Mount, RubberPad, pad_mount
from ...linkage.linkage import Linkage
from ...loads.contacts import Impact, TwoSidedStop
from ...loads.hydraulics import HydraulicCushion, ImpactDamper
from ...loads.link import Friction, Load, PointForce, SpringDamper
from ...loads.pneumatics import BalanceCylinder, PneumaticCushion
from ...loads.process import Blanking, ConstantForce, DeepDrawing, ElasticDie, ForceStroke, Idle
from ...loads.shearing import RateSensitiveBlanking
from ...simulation.elastic.contact import Clearance
from ...simulation.elastic.preloaded_joint import PreloadedJoint
from .part_values import instant, numbers, pairs_of_file, speed, truth, vector, whole_number
from .units import read_quantity

T = TypeVar("T")


@dataclass(frozen=True)
class Table:
    """A CSV file of two columns in place of fields.

    Attributes:
        key: Key whose value is the path of the file.
        columns: Names of both columns with units.
        into: Name of the field that takes the pairs, or of one field for each column.
        unit: Unit of the second column, in units of the field.
    """

    key: str
    columns: tuple[str, str]
    into: tuple[str, ...]
    unit: float = 1.0


@dataclass(frozen=True)
class Kind(Generic[T]):
    """A kind of drive, load or other part.

    Attributes:
        made: Class of the part.
        example: Words behind the kind's name that make one.
        table: Table that it takes from a file; None where it takes none.
        geared: Whether it also takes the keys of a `Geared`.
        driver: Coordinate of the driver on which it acts: where this slides, with forces in place of torques, and speeds along its axis.
    """

    made: type[T]
    example: str
    table: Table | None = None
    geared: bool = False
    driver: DriverCoordinate = CRANK


MOTORS: Mapping[str, Kind[Any]] = {
    "constant": Kind(ConstantTorque, "value=567", geared=True),
    "induction": Kind(InductionMotor, "rated_power=75e3,rated_speed=1485,inertia=1.2,ratio=20.7,efficiency=0.95", geared=True),
    "inverter": Kind(
        InverterMotor,
        "rated_torque=482,rated_speed=1485,frequency=40,ratio=20.7",
        Table("curve", ("frequency [Hz]", "torque [N m]"), ("curve",)),
        geared=True,
    ),
    "slip-clutch": Kind(SlipClutchMotor, "rated_torque=189,primary_speed=1470,top_speed=1320,set_speed=900,ratio=3", geared=True),
    "servo": Kind(
        ServoMotor,
        "program=motion.csv,stiffness=2e4,damping=900,peak_torque=5e3,ratio=10",
        Table("program", ("time [s]", "angle [deg]"), ("times", "angles"), math.radians(1.0)),
        geared=True,
    ),
    "prescribed": Kind(PrescribedSpeed, "speed=70"),
}

# without gears; what else there is needs a shaft, as the simulation says
ON_SLIDING_DRIVERS: Mapping[str, Kind[Any]] = {
    **MOTORS,
    "constant": replace(MOTORS["constant"], example="value=20kN", driver=RAM),
    "servo": Kind(
        ServoMotor,
        "program=motion.csv,stiffness=2e6,damping=9e4,peak_torque=50kN",
        Table("program", ("time [s]", "position [mm]"), ("times", "angles"), 1e-3),
        geared=True,
        driver=RAM,
    ),
    "prescribed": replace(MOTORS["prescribed"], example="speed=100", driver=RAM),
}

LOADS: Mapping[str, Kind[Any]] = {
    "idle": Kind(Idle, ""),
    "constant-force": Kind(ConstantForce, "force=1e6,height=0.0005"),
    "blanking": Kind(Blanking, "force=1e6,start=0.006,end=0.002"),
    "drawing": Kind(DeepDrawing, "force=5e5,start=0.05"),
    "table": Kind(ForceStroke, "file=stroke.csv", Table("file", ("height [m]", "force [N]"), ("heights", "forces"))),
    "die": Kind(ElasticDie, "height=0.001,stiffness=1e9"),
    "impact": Kind(Impact, "height=1mm,stiffness=1e10,damping=1e5,depth=0.1mm"),
    "shearing": Kind(RateSensitiveBlanking, "force=6e5,start=4mm,end=2mm,sensitivity=0.05,reference_speed=1mm/s,peak=3mm,remaining=0.5"),
    "stops": Kind(TwoSidedStop, "lower=-1mm,upper=32mm,stiffness=1e10"),
    "balance-cylinder": Kind(BalanceCylinder, "bore=160mm,pressure=6bar,volume=80l,count=2"),
    "impact-damper": Kind(ImpactDamper, "heights=0mm/8mm,coefficients=2e6/2e6"),
    "hydraulic-cushion": Kind(HydraulicCushion, "force=300kN,height=60mm,rise=1mm,return_force=20kN"),
    "air-cushion": Kind(PneumaticCushion, "bore=200mm,pressure=5bar,volume=40l,height=12mm"),
    "point-force": Kind(PointForce, "link=slide,force=0/0/5kN"),
}

SPRING = Kind(SpringDamper, "link1=frame,link2=slide,stiffness=200kN/m,free_length=0.4,point1=0/0/0.5")
FRICTION = Kind(Friction, "coefficient=0.08,radius=60mm")
LISTS = {"heights": ("=H/H", "m"), "coefficients": ("=C/C", "N s^e/m^e")}  # keys of numbers with a slash between them, and their units
ALL = "all"  # in place of a bearing's name: every bearing and guide that is not named otherwise

FLYWHEEL = Kind(Flywheel, "inertia=2000")
CLUTCH = Kind(Clutch, "torque=6e4,rise=0.1,closes=0.2s")
BRAKE = Kind(Brake, "torque=4e4,closes=350deg")

FRAME = Kind(Frame, "mass=15t,centre=0/0.1/-0.35,inertia=9000/8000/4000")
MOUNT = Kind(Mount, "point=0.55/0.6/-1.3,stiffness=50MN/m/50MN/m/200MN/m,damping=2e5/2e5/4e5")
PAD = Kind(RubberPad, "length=200mm,width=200mm,thickness=10mm,hardness=65,loss_factor=0.15,stiffening=1.3")


@dataclass(frozen=True)
class Place:
    """Where the middle of a pad is.

    Attributes:
        point: x, y, z in world axes [m].
    """

    point: tuple[float, float, float] = declare(metadata=parameter("m", axes=1))


PLACE = Kind(Place, "point=0.55/0.6/-1.3")


@dataclass(frozen=True)
class Yielding:
    """Elastic parts in addition to bearings and guides, and damping of an elastic motion; see `Elastic` and its `Stiffness`.

    Attributes:
        damping_ratio: damping ratio of the lowest vibration at bottom dead centre [-].
        shaft: torsional stiffness of the shaft [N m/rad].
        frame: stiffness of the columns [N/m].
        crown_mass: mass that the columns carry [kg].
    """

    damping_ratio: float = declare(default=0.02, metadata=parameter("-"))
    shaft: float | None = declare(default=None, metadata=parameter("N m/rad"))
    frame: float | None = declare(default=None, metadata=parameter("N/m"))
    crown_mass: float | None = declare(default=None, metadata=parameter("kg"))


ELASTIC = Kind(Yielding, "damping_ratio=0.03,frame=3GN/m,crown_mass=4t")
CLEARANCE = Kind(Clearance, "radial=0.1mm")
JOINT = Kind(PreloadedJoint, "loaded=2GN/m,relieved=6GN/m,preload=2500kN")
COLUMNS = "frame"  # name of the columns between crown and table, beside those of bearings and guides


def motor(words: str | None, coordinate: DriverCoordinate) -> Drive | PrescribedSpeed | None:
    """Read the motor or other drive from a text such as ``constant:value=567``.

    Args:
        words: Text of the option; None: no drive.
        coordinate: Coordinate of the driver. A drive without a ratio on a sliding driver has forces, not torques.

    Raises:
        PinpressError: A kind or key is unknown, a key is missing, or a value is wrong; the message lists kinds or keys with an example.
    """
    if words is None:
        return None
    geared = any(word.startswith("ratio=") for word in words.partition(":")[2].split(","))
    made: Drive | PrescribedSpeed = named("--motor", MOTORS if coordinate.turns or geared else ON_SLIDING_DRIVERS, words)
    return made


def load(words: str) -> Load:
    """Read the load from a text such as ``die:height=0.001,stiffness=1e9``. Raises as `motor`."""
    made: Load = named("--load", LOADS, words)
    return made


def frictions(specs: Sequence[str], press: Linkage) -> dict[str, Friction]:
    """Read friction of bearings and guides from texts such as ``A:coefficient=0.08,radius=60mm``.

    ``all:...`` is friction of all bearings and guides without a separate text; its radius is for bearings that turn.

    Raises:
        PinpressError: As for `motor`; also if a name is given twice.
        UnknownNameError: The press has no such bearing.
    """
    found: dict[str, Friction] = {}
    for words in specs:
        name, colon, rest = words.rpartition(":")  # a bearing's name may have a colon in it
        if not colon:
            raise PinpressError(f"--friction {words}: it names no bearing; write e.g. --friction {ALL}:{FRICTION.example}")
        if name in found:
            raise PinpressError(f"--friction {words}: the friction of {name} is given twice")
        if name not in (ALL, *press.bearings):
            raise UnknownNameError("bearing", name, (*press.bearings, ALL))
        found[name] = _made(f"--friction {name}:", FRICTION, rest)
    every = found.pop(ALL) if ALL in found and ALL not in press.bearings else None
    if every is None:
        return found
    if every.viscous:
        raise PinpressError(
            f"--friction {ALL}: viscous has the unit N m s/rad for a bearing and N s/m for a guide; give it for each by name"
        )
    if every.preload:
        raise PinpressError(f"--friction {ALL}: preload is the force of a guide's gibs; give it for each guide by name")
    turning = [axis.turns for axis in press.axes] + [True] * len(press.loops)
    fixed = {loop.name for loop in press.loops if loop.type == "fixed"}
    of_all = {
        name: every if turns else replace(every, radius=None)
        for name, turns in zip(press.bearings, turning, strict=True)
        if name not in fixed
    }
    return of_all | found


def by_bearing(option: str, specs: Sequence[str], unit: str, quantity: str, example: str) -> dict[str, float]:
    """Read positive numbers by the names of bearings and guides from texts such as ``A=2e6``.

    Args:
        option: The option, for messages.
        specs: Texts of the option.
        unit: Unit of numbers without a unit.
        quantity: Name of the quantity, for messages.
        example: A number, for messages.

    Raises:
        PinpressError: A text has no name or no positive number, or a bearing is given twice.
    """
    found: dict[str, float] = {}
    for spec in specs:
        name, equals, text = spec.rpartition("=")  # a bearing's name may have an equals sign in it
        try:
            number = read_quantity(text, unit)
        except ValueError:
            number = float("nan")
        if not equals or not name or not number > 0:
            raise PinpressError(f"{option} {spec}: it needs NAME={unit}, a positive {quantity} [{unit}]; write e.g. {option} A={example}")
        if name in found:
            raise PinpressError(f"{option} {spec}: {name} is given twice")
        found[name] = number
    return found


def clearances(specs: Sequence[str], press: Linkage) -> dict[str, Clearance]:
    """Read clearances by the names of pins from texts such as ``A:radial=0.1mm``. Raises as `frictions`."""
    return _by_part("--clearance", CLEARANCE, specs, press.bearings, "it names no pin")


def joints(specs: Sequence[str], press: Linkage) -> dict[str, PreloadedJoint]:
    """Read preloaded joints of guides or of `COLUMNS` from texts such as ``frame:loaded=2GN/m,relieved=6GN/m,preload=2500kN``.

    Raises as `frictions`.
    """
    return _by_part("--preloaded-joint", JOINT, specs, (*press.bearings, COLUMNS), "it names neither a guide nor the frame")


def _by_part(option: str, kind: Kind[T], specs: Sequence[str], names: Sequence[str], nameless: str) -> dict[str, T]:
    """Read ``NAME:KEYS`` for these names; ``nameless``: message for a text without a name."""
    found: dict[str, T] = {}
    for words in specs:
        name, colon, rest = words.rpartition(":")
        if not colon:
            raise PinpressError(f"{option} {words}: {nameless}; write e.g. {option} {names[-1]}:{kind.example}")
        if name in found:
            raise PinpressError(f"{option} {words}: {name} is given twice")
        if name not in names:
            raise UnknownNameError("bearing", name, names)
        found[name] = _made(f"{option} {name}:", kind, rest)
    return found


def flywheel(words: str | None) -> Flywheel | None:
    """Read the flywheel from a text such as ``2000`` (its inertia) or ``inertia=2000,speed=70``; None without a text.

    Raises as `part`.
    """
    if words is None:
        return None
    return part("--flywheel", FLYWHEEL, f"inertia={words}" if words and "=" not in words and "," not in words else words)


def mounts(specs: Sequence[str], pad: str | None) -> list[Mount]:
    """Read the mounts of a frame. Raises as `part`.

    Args:
        specs: A text for each mount, ``point=0.55/0.6/-1.3,stiffness=5e7/5e7/2e8``; with ``pad`` only the point.
        pad: Rubber pad of each mount, ``length=200mm,width=200mm,thickness=10mm,hardness=65``; None without pads.
    """
    if pad is None:
        return [part("--mount", MOUNT, words) for words in specs]
    rubber = part("--pad", PAD, pad)
    return [pad_mount(part("--mount", PLACE, words).point, rubber) for words in specs]


def part(option: str, kind: Kind[T], words: str) -> T:
    """Read a part from a text such as ``torque=6e4,closes=0.2s``.

    Args:
        option: Name of the option, for messages.
        kind: Kind of the part.
        words: Text of the option.

    Raises:
        PinpressError: A key is unknown or missing, or a value is wrong; the message lists the keys with an example.
    """
    made: T = _made(f"{option} ", kind, words)
    return made


def keys(kind: Kind[Any]) -> str:
    """The keys of a kind, with optional ones in brackets."""
    return " ".join(str(key) for key in _keys(kind).values()) or "(no keys)"


def explained(*parts: str) -> str:
    """Help of the options of these names: load, spring, friction, motor, clutch, elastic, joint (part of elastic), mount."""
    intro = "KIND:KEYS are e.g. blanking:force=1000kN,start=6mm,end=2mm; keys in brackets are optional. Numbers are in SI units, speeds in"
    lines = [intro, "r/min, or numbers have units. Files are CSV of two columns."]
    for part in parts:
        lines += ["", *_EXPLAINED[part]()]
    return "\n".join(lines) + "\n"


def _of_loads() -> list[str]:
    return [
        "--load; heights are slide positions above bottom dead centre, or above the slide position datum=:",
        *_kinds(LOADS),
        "  all loads act between slide and frame, except point-force: on one link from outside, in world axes, at a point of the link",
    ]


def _of_springs() -> list[str]:
    return [
        "--spring, with a parallel damper, between points of two links in their frames:",
        f"  {keys(SPRING)}",
        f"  e.g. --spring {SPRING.example}",
    ]


def _of_friction() -> list[str]:
    return [
        f"--friction of a bearing (moment coefficient x radius x force), of a guide (coefficient x force), or of {ALL} others:",
        f"  NAME:{keys(FRICTION)}",
        f"  e.g. --friction {ALL}:{FRICTION.example} --friction A:viscous=50; viscous is in N m s/rad, for a guide in N s/m;",
        "  preload is the sum of the forces of all gibs of a guide without a load",
    ]


def _of_motors() -> list[str]:
    return [
        "--motor; with ratio= it acts on the crank through gears:",
        *_kinds(MOTORS),
        f"  e.g. --motor induction:{MOTORS['induction'].example}",
        "  on a sliding driver, without ratio=: constant, servo and prescribed, with forces in N, speeds in mm/s, the program in mm,",
        "  e.g. --motor constant:value=20kN",
    ]


def _of_clutches() -> list[str]:
    return ["--clutch and --brake, switched at a time or a crank angle:", f"  {keys(CLUTCH)}"]


def _of_springs_of_bearings() -> list[str]:
    return [
        "--stiffness of a bearing, or of a guide across its axis [N/m], --moment-stiffness of a guide against turning [N m/rad]; or of",
        f"  {ALL} others: the press runs on these springs",
        f"  e.g. --stiffness {ALL}=2GN/m --stiffness A=3e9 --moment-stiffness {ALL}=2e8",
        "--elastic, other elastic parts (shaft, columns under a crown), and the damping ratio of the lowest vibration:",
        f"  {keys(ELASTIC)}",
        f"  e.g. --elastic {ELASTIC.example}",
        "--clearance of a pin, with law=hertz also restitution= and hertz_stiffness=:",
        f"  NAME:{keys(CLEARANCE)}",
        f"  e.g. --clearance A:{CLEARANCE.example}",
        *_of_joints(),
    ]


def _of_joints() -> list[str]:
    return [
        f"--preloaded-joint of two members in place of a stiffness; a positive load adds to the loaded member; {COLUMNS}: of the columns:",
        f"  NAME:{keys(JOINT)}",
        f"  e.g. --preloaded-joint {COLUMNS}:{JOINT.example}, tie rods and uprights",
    ]


def _of_mounts() -> list[str]:
    return [
        "--frame, all masses fixed to the frame that are not in the file, in world axes, and --mount, each spring below the frame:",
        f"  {keys(FRAME)}",
        f"  {keys(MOUNT)}",
        f"  e.g. --frame {FRAME.example} --mount {MOUNT.example}",
    ]


def _kinds(kinds: Mapping[str, Kind[Any]]) -> list[str]:
    files = [f"{name} {', '.join(kind.table.columns)}" for name, kind in kinds.items() if kind.table]
    return [*tables.table(([f"{name}:", keys(kind)] for name, kind in kinds.items()), [19, 0]), f"  columns of files: {'; '.join(files)}"]


_EXPLAINED: Mapping[str, Callable[[], list[str]]] = {
    "load": _of_loads,
    "spring": _of_springs,
    "friction": _of_friction,
    "motor": _of_motors,
    "clutch": _of_clutches,
    "elastic": _of_springs_of_bearings,
    "joint": _of_joints,
    "mount": _of_mounts,
}


@dataclass(frozen=True)
class _Key:
    """A key.

    Attributes:
        name: Name of the key.
        note: Note shown next to the name.
        optional: Whether the key may be left out.
        read: Function that makes a value of a text.
    """

    name: str
    note: str
    optional: bool
    read: Callable[[str], Any]

    def __str__(self) -> str:
        return f"[{self.name}{self.note}]" if self.optional else f"{self.name}{self.note}"


def named(option: str, kinds: Mapping[str, Kind[Any]], words: str) -> Any:
    """Read a part of the kind that the text names before a colon; arguments and errors as for `part`."""
    name, _, rest = words.partition(":")
    if name not in kinds:
        example = next(f"{option} {known}:{kind.example}" for known, kind in kinds.items() if kind.example)
        raise PinpressError(
            f"{option} {words}: no kind {name!r}{suggestion(name, kinds)}; there are: {', '.join(kinds)}; write e.g. {example}"
        )
    return _made(f"{option} {name}:", kinds[name], rest)


def _made(option: str, kind: Kind[Any], words: str) -> Any:
    """A part of a kind; ``option``: the words before on the command line, for messages."""

    def line(words: str) -> str:
        return f"{option}{words}".rstrip(": ")

    def wrong(problem: str) -> PinpressError:
        speeds = f", speeds in {kind.driver.shown_speed[0]}" if any(map(_is_speed, fields(kind.made))) else ""
        takes = f"it takes {keys(kind)}, SI units{speeds} or with units (12mm, 4000kN)"
        return PinpressError(f"{line(words)}: {problem}; {takes}; write e.g. {line(kind.example)}")

    known = _keys(kind)
    values: dict[str, Any] = {}
    for word in words.split(",") if words else ():
        name, equals, text = word.partition("=")
        if not equals:
            raise wrong(f"{word!r} is not key=value")
        if name not in known:
            raise wrong(f"no key {name!r}{suggestion(name, known)}")
        if name in values:
            raise wrong(f"{name} is given twice")
        try:
            values[name] = known[name].read(text)
        except ValueError as error:
            raise wrong(f"{name} is {text!r}, {error}") from None
    missing = [key.name for key in known.values() if not key.optional and key.name not in values]
    gear = {name: values.pop(name) for name in _GEAR if kind.geared and name in values}
    if gear and "ratio" not in gear:
        missing.append("ratio")
    if missing:
        raise wrong(f"{' and '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing")
    if kind.table is not None and kind.table.key in values:
        values |= _fields_of(kind.table, values.pop(kind.table.key))
    try:
        made = kind.made(**values)
        return Geared(made, **gear) if gear else made
    except PinpressError as error:
        raise wrong(str(error)) from None


def _keys(kind: Kind[Any]) -> dict[str, _Key]:
    """The keys of a kind, in the order of the fields of its class."""
    table = kind.table
    found = []
    for field in in_signature(kind.made):
        optional = field.default is not MISSING
        if table is None or field.name not in table.into:
            found.append(_Key(field.name, _note(field, kind.driver), optional, _reader(field, kind.driver)))
        elif field.name == table.into[0]:
            found.append(_Key(table.key, "=FILE", optional, partial(pairs_of_file, columns=table.columns)))
    return {key.name: key for key in found} | (_GEAR if kind.geared else {})


def _note(field: Field[Any], driver: DriverCoordinate = CRANK) -> str:
    if _is_speed(field):
        return "=RPM" if driver.turns else "=MM/S"
    if field.name in LISTS:
        return LISTS[field.name][0]
    if isinstance(field.default, bool):
        return "=yes|no"
    if _is_at(field):
        return "=0.1s|180deg"
    known = declared(field)
    if known is not None and known.axes:
        return "=X/Y/Z"
    if field.default is MISSING or field.default is None:
        return ""
    return f"={field.default}" if isinstance(field.default, str) else f"={field.default:g}"


def _reader(field: Field[Any], driver: DriverCoordinate = CRANK) -> Callable[[str], Any]:
    if _is_at(field):
        return instant
    if field.type in (int, "int"):
        return whole_number
    if field.type in (str, "str"):
        return str
    if _is_speed(field):
        return partial(speed, driver=driver)
    if isinstance(field.default, bool):
        return truth
    if field.name in LISTS:
        return partial(numbers, unit=LISTS[field.name][1])
    known = declared(field)
    unit = "-" if known is None else driver.in_place_of(known.unit)
    return partial(vector if known is not None and known.axes else read_quantity, unit=unit)


def _is_speed(field: Field[Any]) -> bool:
    known = declared(field)
    return (field.name == "speed" or field.name.endswith("_speed")) and (known is None or known.unit != "m/s")


def _is_at(field: Field[Any]) -> bool:
    return SwitchPoint.__name__ in re.findall(r"\w+", str(field.type))


def _fields_of(table: Table, pairs: list[tuple[float, float]]) -> dict[str, Any]:
    scaled = [(first, second * table.unit) for first, second in pairs]
    if len(table.into) == 1:
        return {table.into[0]: scaled}
    return {name: [pair[i] for pair in scaled] for i, name in enumerate(table.into)}


_GEAR = {field.name: _Key(field.name, _note(field), True, _reader(field)) for field in fields(Geared) if field.name != "drive"}
