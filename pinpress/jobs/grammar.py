"""The sections of a job: what stands in each, as values that read it. The geometry of a press in a table is that of `pin_table`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..balancing.problem import Target
from ..common.arguments import read_quantity
from ..common.errors import FileEntryError, PinpressError, suggestion
from ..common.reading.entries import Entry, FileKind
from ..common.reading.filling import (
    Around,
    DataFile,
    Either,
    Listed,
    Named,
    Names,
    Number,
    Numbers,
    Part,
    Rows,
    Text,
    Truth,
    Value,
    Whole,
)
from ..foundation.frame_file import MOUNTED, ON_MOUNTS, USUAL_WORDS
from ..ratings.safety_distance import EDITIONS
from ..servo.cam_tables import LAYOUTS
from ..simulation.simulate import METHODS
from ..visual.languages import LANGUAGES
from .kinds import (
    BEARING,
    BRAKE,
    CASES,
    CLUTCH,
    CRITERIA,
    FLYWHEEL,
    JOINT,
    LIMITS,
    LOADS,
    MOTORS,
    PATHS,
    REGION,
    SERVO_DRIVE,
    Regions,
)

ALL = "all"  # in place of a bearing's name: every bearing that does not say otherwise
JOB = FileKind("job", FileEntryError, "the press, or file: press.urdf, and what acts on it", USUAL_WORDS)
Given = dict[str, Any]


def _given(made: Callable[..., Any], given: Given) -> Given:
    return given


def keys(example: str, values: Mapping[str, Value], needed: tuple[str, ...] = (), said: str = "") -> Part[Given]:
    """A section whose keys are arguments of a function, as far as they are given."""
    return Part(dict, example, values, needed=needed, finish=_given, said=said)


@dataclass(frozen=True)
class OfDriver:
    """A value of the press's only driver, with forces in place of torques where it slides.

    Attributes:
        each: the value.
    """

    each: Value

    def read(self, entry: Entry, around: Around) -> Any:
        """The value."""
        if len(around.drivers) > 1:
            names = ", ".join(around.drivers)
            entry.refuse(f"the press has {len(around.drivers)} drivers, {names}, and one value does not say how they move together", MOTION)
        return self.each.read(entry, replace(around, coordinate=next(iter(around.drivers.values()))))


@dataclass(frozen=True)
class OfDrivers:
    """A value of the only driver, or of several drivers by their names, each with the units of its coordinate.

    Attributes:
        each: the value of one.
        example: what names a driver, for messages.
    """

    each: Value
    example: str

    def read(self, entry: Entry, around: Around) -> dict[str, Any]:
        """The values by the names of drivers."""
        items = entry.value if isinstance(entry.value, Mapping) else {}
        if not items or not any(name in around.drivers for name in items):
            if len(around.drivers) > 1:
                first = next(iter(around.drivers))
                entry.refuse(f"it names none of the {len(around.drivers)} drivers", f"write {{{first}: {self.example}}}")
            name, coordinate = next(iter(around.drivers.items()))
            return {name: self.each.read(entry, replace(around, coordinate=coordinate))}
        for name, each in items.items():
            if name not in around.drivers:
                each.refuse(f"no driver {name}{suggestion(name, around.drivers)}", f"name one of {', '.join(around.drivers)}")
        return {name: self.each.read(each, replace(around, coordinate=around.drivers[name])) for name, each in items.items()}


class BySide(Text):
    """A force or speed at each of some heights."""

    def __init__(self, name: str, unit: str) -> None:
        self.part = keys(f"[{{height: 6 mm, {name}: ...}}]", {"height": Number("m"), name: Number(unit)}, ("height", name))
        self.name = name

    def read(self, entry: Entry, around: Around) -> Any:
        """Height [m] -> force [N] or speed [rad/s]."""
        return {each["height"]: each[self.name] for each in Listed(self.part).read(entry, around)}


class Stretch(Text):
    """Stiffness of a link between its bearings, or ``rigid``."""

    def read(self, entry: Entry, around: Around) -> Any:
        """The stiffness [N/m]; None: rigid."""
        return None if entry.value == "rigid" else Number("N/m").read(entry, around)


class FramePoint(Text):
    """A point of the frame: x, y, z; with ``on`` of a part; or the name of an interface of a frame that bends."""

    part = keys("{on: crown, at: 0 0 900 mm}", {"on": Text(), "at": Numbers("m")}, ("on", "at"))

    def read(self, entry: Entry, around: Around) -> Any:
        """The point [m], with its part; or the name."""
        if isinstance(entry.value, Mapping):
            given = self.part.read(entry, around)
            return given["on"], given["at"]
        text = entry.value if isinstance(entry.value, str) else ""
        return text if text[:1].isalpha() else Numbers("m").read(entry, around)


class Span(Numbers):
    """Two numbers, the lower one first."""

    def read(self, entry: Entry, around: Around) -> tuple[float, float]:
        """Both numbers."""
        numbers = super().read(entry, around)
        if len(numbers) != 2 or not numbers[0] < numbers[1]:
            entry.refuse(
                f"{entry.value if isinstance(entry.value, str) else numbers}", "write two speeds, the lower one first: 30 90 r/min"
            )
        return numbers[0], numbers[1]


class Dimension(Text):
    """A tolerance of a dimension, with what else is known of it, as a row of a table of dimensions."""

    part = keys(
        "{tolerance: 0.05 mm, shape: uniform}",
        {name: Text() for name in ("tolerance", "shape", "sd", "name", "cost", "smallest", "largest")},
        ("tolerance",),
    )

    def read(self, entry: Entry, around: Around) -> Any:
        """The row as texts, in the unit of the tolerance."""
        si = "rad" if entry.path[-1].startswith("angle") or entry.path[-1].endswith(".angle") else "m"  # of numbers of a call

        def with_unit(each: Entry) -> Entry:
            return replace(each, value=f"{each.value!r} {si}") if isinstance(each.value, float) else each

        if isinstance(entry.value, Mapping):
            known = {key: each if key == "cost" else with_unit(each) for key, each in entry.value.items()}
            row = self.part.read(replace(entry, value=known), around)
        else:
            row = {"tolerance": with_unit(entry).text("a tolerance")}
        number, _, unit = row["tolerance"].strip().partition(" ")
        if not unit:
            entry.refuse(f"{row['tolerance']} has no unit", f"write {number} mm, or {number} deg of an angle, with a blank before the unit")
        for name in ("sd", "smallest", "largest"):
            if name in row:
                try:
                    row[name] = repr(read_quantity(row[name], unit))
                except ValueError as error:
                    entry.refuse(f"{name} is {row[name]!r}, {error}", f"write it in {unit} too")
        return {**row, "tolerance": number, "unit": unit}


def _criteria(made: Callable[..., Any], given: Given) -> Given:
    """Criteria and their numbers in the form that `balance` takes."""
    minimise, limits = given.pop("minimise"), given.pop("limits", [])
    for _, _, most in minimise:
        if most is not None:
            most.refuse("a criterion to minimise has no limit", "write it among limits too")
    objective: Target | Mapping[Target, float] = {target: weight for target, weight, _ in minimise}
    if len(minimise) == 1 and minimise[0][1] == 1.0:
        objective = minimise[0][0]
    bounds = {}
    for target, _, most in limits:
        if most is None:
            raise PinpressError(f"the {target.words} is limited to nothing: write most, {{kind: added-mass, most: 661 kg}}")
        bounds[target] = Number(target.unit).read(most, Around())
    return {**given, "minimise": objective, "limits": bounds}


def _budget(made: Callable[..., Any], given: Given) -> Given:
    if len(given["speeds"]) < 1:
        raise PinpressError("speeds is empty: write them, speeds: 10 50 70 r/min; the press is set at the first")
    return given


def _rate(made: Callable[..., Any], given: Given) -> Given:
    """The time of a stroke in place of strokes in a minute."""
    if "time" in given and "strokes_per_minute" in given:
        raise PinpressError("time and strokes_per_minute both say how fast the press is: leave out one of them")
    strokes = given.pop("strokes_per_minute", None)
    return given if strokes is None else {**given, "time": 60.0 / strokes}


@dataclass(frozen=True)
class Place:
    """Where a joint is: an angle, or the position of one that slides."""

    def read(self, entry: Entry, around: Around) -> float:
        """The coordinate [rad or m]."""
        try:
            return Number("m").read(entry, around)
        except PinpressError:
            return Number("rad").read(entry, around)


EFFORT = OfDrivers(Number("N m"), "5 kN m")
SPEEDS = OfDrivers(Number("rad/s"), "30 r/min")
PLACES = OfDrivers(Number("rad"), "30 deg")
MOTION = "write motion: {file: motion.csv}, a table with a column for each"


@dataclass(frozen=True)
class Section:
    """A section of a job.

    Attributes:
        value: what stands in it.
        said: what it says, in a sentence.
        example: as it stands in a file.
        by_keys: whether ``--set section.key=value`` may begin it.
    """

    value: Value
    said: str
    example: str
    by_keys: bool = False


SECTIONS: Mapping[str, Section] = {
    "file": Section(Text(), "A URDF, SDF or MJCF file or a shipped press, in place of the table of pins.", "file: robot.urdf"),
    "drivers": Section(
        Names(), "Driven joints, if the file names no driver or if other joints are driven.", "drivers: motor_left motor_right"
    ),
    "slide": Section(
        Text(), "Name of the slide, if it is not `slide`: the link whose motion and process force are computed.", "slide: ram"
    ),
    "floating": Section(Truth(), "Whether free joints of the file leave their bodies free, such as the base of a robot.", "floating: yes"),
    "pose": Section(
        Named(Place(), "{knee: 30 deg}"),
        "Positions of some joints when the linkage is assembled, if its file draws it open or two assemblies are possible.",
        "pose: {knee: 30 deg, rod: -5 mm}",
        by_keys=True,
    ),
    "gravity": Section(Number("m/s2"), "Gravity downwards.", "gravity: 9.81 m/s2"),
    "zero": Section(
        Text(("drawn", "tdc", "bdc")), "Where the crank angle is 0: in the drawn pose, or at top or bottom dead centre.", "zero: tdc"
    ),
    "speed": Section(
        OfDriver(Number("rad/s")), "Speed of the driver; negative: backwards. If the driver slides: its highest speed.", "speed: 70 r/min"
    ),
    "motion": Section(
        keys("{file: motion.csv, period: 1 s}", {"file": DataFile(), "period": Number("s")}, ("file",)),
        "A table of the drivers' positions over time, in place of the speed.",
        "motion: {file: motion.csv, period: 1 s}",
    ),
    "loads": Section(
        Named(LOADS, "{draw: {kind: drawing, force: 1500 kN, start: 40 mm}}"),
        "Loads on the links. You choose their names.",
        "loads: {draw: {kind: drawing, force: 1500 kN, start: 40 mm}}",
    ),
    "bearings": Section(
        Named(BEARING, "{all: {friction: 0.05, diameter: 200 mm}}"),
        "Friction, stiffness, clearance, sizes and permissible force of bearings and guides, by their names; `all` holds for the others.",
        "bearings: {all: {friction: 0.05, diameter: 200 mm}, A: {permissible: 2 MN}}",
    ),
    "motor": Section(
        OfDrivers(MOTORS, "{kind: constant, value: 567 N m}"),
        "The motor; if there are several drivers, one for each, by their names.",
        "motor: {kind: induction, rated_power: 75 kW, rated_speed: 1485 r/min, inertia: 1.2 kg m2, ratio: 20.7}",
    ),
    "flywheel": Section(
        OfDrivers(FLYWHEEL, "2000 kg m2"),
        "Flywheel at the driver joint; if there are several drivers, one for each, by their names.",
        "flywheel: 6000 kg m2",
    ),
    "clutch": Section(OfDriver(CLUTCH), "Clutch between flywheel and crank.", "clutch: {torque: 60 kN m, closes: 0.2 s, rise: 50 ms}"),
    "brake": Section(OfDriver(BRAKE), "Brake on the crank.", "brake: {torque: 60 kN m, closes: 350 deg, rise: 50 ms}"),
    "capacities": Section(
        keys(
            "{nominal_force: 3000 kN, nominal_height: 13 mm, speed_drop: 15 %}",
            {
                "nominal_force": Number("N"),
                "nominal_height": Number("m"),
                "torque": EFFORT,
                "speed_drop": Number("-"),
                "motor_power": Number("W"),
                "slide_acceleration": Number("m/s2"),
                "shaking_force": Number("N"),
                "contact_height": Number("m"),
                "dwell_tolerance": Number("m"),
                "at_speed": Truth(),
            },
            ("nominal_force",),
        ),
        "What the press may bear; with `at_speed`, weights and inertia forces count too. Capacities of bearings are in `bearings`.",
        "capacities: {nominal_force: 3000 kN, nominal_height: 13 mm, speed_drop: 15 %}",
        by_keys=True,
    ),
    "stopping": Section(
        keys(
            "{delay: 30 ms, control: 10 ms, device: 20 ms, edition: ISO 13855:2010, resolution: 14 mm}",
            {
                "delay": Number("s"),
                "control": Number("s"),
                "device": Number("s"),
                "monitor": Number("s"),
                "inertia": Number("kg m2"),
                "edition": Text(tuple(EDITIONS)),
                **{name: Number("m") for name in ("resolution", "reach", "supplement")},
                "two_hand": Truth(),
            },
            ("delay",),
        ),
        "How far the press runs on after a signal, under its brake, and the safety distance by the formula of an edition.",
        "stopping: {delay: 30 ms, control: 10 ms, device: 20 ms, edition: ISO 13855:2010, resolution: 14 mm}",
        by_keys=True,
    ),
    "fe": Section(
        keys(
            "{link: rod, at: extremes, mesh: rod.inp, nodes: {P: 1, W: 2}}",
            {"link": Text(), "at": CASES, "mesh": DataFile(), "nodes": Named(Whole(), "{P: 1, W: 2}")},
            ("link",),
        ),
        "Load cases of a link for a finite element program.",
        "fe: {link: rod, at: extremes}",
        by_keys=True,
    ),
    "elastic": Section(
        keys(
            "{damping_ratio: 0.03, frame: 3 GN/m, crown_mass: 4 t}",
            {
                "damping_ratio": Number("-"),
                "shaft": Number("N m/rad"),
                "frame": Either(Number("N/m"), JOINT),
                "crown_mass": Number("kg"),
                "modulus": Number("Pa"),
                "rods": Named(Stretch(), "{rod: 7 GN/m}"),
            },
        ),
        "Damping, shaft, columns and rods of a press on springs; the stiffnesses of bearings stand with the bearings.",
        "elastic: {damping_ratio: 0.03, frame: 3 GN/m, crown_mass: 4 t}",
        by_keys=True,
    ),
    "foundation": Section(
        keys(
            ON_MOUNTS.example,
            {
                **MOUNTED,
                "points": Named(FramePoint(), "{crown: 0 0 900 mm}"),
                "speed_range": Span("rad/s"),
                "lift_off": Whole(),
            },
            ON_MOUNTS.needed,
        ),
        "The frame on its mounts; points whose vibration is shown; speeds over which; strokes with feet that lift off.",
        "foundation: frame.yaml",
    ),
    "balance": Section(
        Part(
            dict,
            "{regions: {crank: {radius: 300 mm}}, minimise: {kind: range, quantity: shaking_force, axis: z}}",
            {
                "regions": Regions(REGION, "{crank: {radius: 300 mm, mass: 0 200 kg}}"),
                "minimise": Listed(CRITERIA),
                "limits": Listed(CRITERIA),
                "dies": Numbers("kg"),
                "settings": Listed(Named(Text(), "{r: 150}")),
                "speeds": Numbers("rad/s"),
            },
            needed=("regions", "minimise"),
            finish=_criteria,
        ),
        "Where counterweights may be, and what they are to improve: over dies, settings of the table's parameters, and speeds.",
        "balance: {regions: {crank: {radius: 300 mm}}, minimise: {kind: range, quantity: shaking_force, axis: z}}",
    ),
    "tolerances": Section(
        keys(
            "{dimensions: dimensions.csv, within: 50 um}",
            {
                "dimensions": Either(DataFile(), Named(Dimension(), "{length E F: 0.05 mm}")),
                "within": Number("m"),
                "targets": keys("{height: 50 um}", {name: Number("m") for name in ("height", "top", "stroke")}),
                "forces": BySide("force", "N"),
                "speeds": BySide("speed", "rad/s"),
                "samples": Whole(),
                "seed": Whole(),
                "budget": Part(
                    dict,
                    "{speeds: 10 50 70 r/min, warm: {rod: 10 K}}",
                    {
                        "speeds": Numbers("rad/s"),
                        "warm": Named(Number("K"), "{rod: 10 K}"),
                        "expansion": Number("1/K"),
                        "table": Number("m"),
                        "face": Number("m"),
                        "process": Number("N"),
                    },
                    needed=("speeds",),
                    finish=_budget,
                ),
            },
            ("dimensions",),
        ),
        "Tolerances of dimensions, and what bottom dead centre may deviate; the budget takes clearances and stiffnesses of the bearings.",
        "tolerances: {dimensions: dimensions.csv, within: 50 um}",
    ),
    "servo": Section(
        Part(
            dict,
            "{strokes_per_minute: 25, drive: {...}}",
            {
                "strokes_per_minute": Number("-"),
                "time": Number("s"),
                "minimise": Text(("heat", "time", "energy", "peak")),
                "drive": SERVO_DRIVE,
                "motors": DataFile(),
                "ratios": Numbers("-"),
                "gear_inertia": Number("kg m2"),
                "pause": Number("s"),
                "path": PATHS,
                "limits": Listed(LIMITS),
                "points": Whole(),
                "step": Number("s"),
            },
            finish=_rate,
        ),
        "The servo drive, or a catalogue of motors, and what its best motion has to keep.",
        "servo: {strokes_per_minute: 25, drive: {inertia: 1.5 kg m2, ratio: 60, peak_torque: 2100 N m}, path: {kind: turn}}",
    ),
    "feed": Section(
        keys(
            "{above: 100 mm, time: 180 ms}",
            {"above": Number("m"), "time": Number("s"), "bars": Named(Numbers("rad"), "{ejector: 200 260 deg}")},
            ("above",),
        ),
        "The timing diagram: the window above a height in which the strip is fed, the feeder's time, and other windows of the crank angle.",
        "feed: {above: 100 mm, time: 180 ms, bars: {ejector: 200 260 deg}}",
        by_keys=True,
    ),
    "cam_table": Section(
        keys("{height: 1 um, layout: xyva}", {"height": Number("m"), "angle": Place(), "layout": Text(tuple(LAYOUTS))}),
        "Cam tables of the motion for a controller: of the slide's height, the crank's angle, or both, each with its tolerance.",
        "cam_table: {height: 1 um, layout: xyva}",
        by_keys=True,
    ),
    "mains": Section(
        keys(
            "{motors: motors.csv, ratios: 12 15, flywheels: 0.2 3 kg m2, speeds: 90 105 r/min, speed_drop: 6 %}",
            {
                "motors": DataFile(),
                "ratios": Numbers("-"),
                "flywheels": Numbers("kg m2"),
                "speeds": Numbers("rad/s"),
                "speed_drop": Number("-"),
                "reserve": Number("-"),
                "start_time": Number("s"),
                "efficiency": Number("-"),
            },
            ("motors", "ratios", "flywheels", "speeds", "speed_drop"),
        ),
        "A catalogue of motors on the mains, from which motor, gear and flywheel are chosen.",
        "mains: {motors: motors.csv, ratios: 12 15, flywheels: 0.2 3 kg m2, speeds: 90 105 r/min, speed_drop: 6 %}",
        by_keys=True,
    ),
    "run": Section(
        keys(
            "{duration: 3 s}",
            {
                "duration": Number("s"),
                "steady": Truth(),
                "speed": SPEEDS,
                "angle": PLACES,
                "method": Text(tuple(METHODS)),
                "step": Number("s"),
                "tolerance": Number("-"),
                "points": Whole(),
            },
        ),
        "How long the press runs, from which speed and angle; or its steady state.",
        "run: {duration: 3 s}",
        by_keys=True,
    ),
    "points": Section(Whole(), "States of a period at constant speed.", "points: 720"),
    "traces": Section(
        Named(
            Either(Rows("m"), keys("{link: rod, at: 0 0 400 mm}", {"link": Text(), "at": Numbers("m")}, needed=("link", "at"))),
            "{rod: 0 0 400 mm}",
        ),
        "Points of links whose paths are drawn, in the frames of the links: by the link's name, or by a name that you choose.",
        "traces: {T: {link: rod, at: 0 0 400 mm}}",
    ),
    "report": Section(
        keys(
            "{title: Press 3, company: Muster AG, language: en}",
            {
                **{name: Text() for name in ("title", "company", "drawing", "author", "revision", "date", "notes", "before")},
                "logo": DataFile(),
                "language": Text(tuple(LANGUAGES)),
            },
        ),
        "The head of the page, its language, and the variant or press with which it compares.",
        "report: {title: Press 3 for plant 7, company: Muster AG, language: en}",
        by_keys=True,
    ),
    "variants": Section(
        Named(Named(Text(), "{r: 150}"), "{long_stroke: {r: 150}}"),
        "Sets of other values, by the names of the variants; each value is written as for --set.",
        "variants: {long_stroke: {r: 150}, hard_steel: {loads.draw.force: 1900 kN}}",
    ),
}
