"""Build a press from a pin table."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..common.arguments import in_unit, is_quantity
from ..common.errors import (
    AssemblyError,
    PinpressError,
    PinTableError,
    SingularityError,
    UnknownNameError,
    UrdfError,
    odd_character,
    shown,
    suggestion,
)
from ..common.quantities import Array
from ..common.reading.entries import DEEPEST
from ..common.results import Records, Tabular
from ..common.tables import Columns
from ..kinematics.check import CheckResult, check_document
from ..kinematics.cycle import cycle
from ..kinematics.servo_motion import servo_cycle
from ..linkage.document import Document, Finding, check_command
from ..linkage.linkage import Linkage
from ..linkage.loading import load_document
from ..linkage.skeleton import PitchCircle, pitch_circles
from ..visual.shapes.appearance import ShownLink, bodies
from .copies import Parts, copied
from .formulas import CONSTANTS, FUNCTIONS, Numbers, formula, parameters_of
from .links import FRAME, Link, read_links
from .machine_elements import SECTIONS, read_machine_elements
from .placement import UNITS, Pin, UnreachableError, place_pins, size_of
from .reading import BESIDE, CALL, Entry, given_table, overlaid, read_table
from .sketch import sketch_of_failure, sketch_of_parts
from .tool import Tool, read_tool
from .tree import Tree, build_tree
from .urdf_text import REACH, urdf_text

NEEDED = {  # keys without which there is no press, and what to write if one is missing
    "units": "give the unit of all lengths: units: mm",
    "frame": "name the pins that are fixed in the frame: frame: A D",
    "pins": "give pins their places: pins: {A: [0, 0]}",
    "links": "name links with their pins: links: {crank: {pins: A B, mass: 20}}",
    "drive": "name the pin that is driven: drive: A",
}
KEYS = ("press", *NEEDED, "parameters", "base", "density", "masses", "copies", "gears", *SECTIONS, "turns", "tool", "note")
SENSES = ("clockwise", "counter-clockwise")  # in the picture: what `turns` may be
MARK = b"written by pinpress from the pin table"  # a URDF with this mark may be overwritten


@dataclass(frozen=True, eq=False, repr=False)
class DrawnPress(Tabular):
    """A press as its pin table draws it, before it is assembled; `draft` makes it.

    Attributes:
        name: of the press.
        file: name of the table's file, or "build(...)" if a call gives the table.
        unit: name of the table's unit of length.
        pins: all pins and points in their places, without copies.
        links: without copies.
        parts: with copies.
        tree: bearings of the parts.
        tool: point of the slide where process forces act; None: the slide's pins determine it.
    """

    name: str
    file: str
    unit: str
    pins: Mapping[str, Pin]
    links: tuple[Link, ...]
    parts: Parts
    tree: Tree
    tool: Tool | None
    _table: Entry  # the table of this press
    _given: tuple[str, ...] = ()  # values that replace the table's parameters, "r=150"

    @cached_property
    def urdf(self) -> bytes:
        """Write the press as URDF, with shapes for viewers.

        Raises:
            PinpressError: what `load` raises.
        """
        press = self.press()
        return self._text(bodies(press, _positions(press)))

    @cached_property
    def sketch(self) -> str:
        """Draw the drawn pose with its dimensions, as SVG."""
        circles: list[PitchCircle] = []
        with suppress(PinpressError):  # a table that makes no press can be drawn
            if self.parts.elements:
                press = self.press()
                circles = pitch_circles(press.model, press.meshes.values())
        return sketch_of_parts(self.name, self.parts, UNITS[self.unit], self.unit, circles)

    def _repr_html_(self) -> str:
        return f"<div>{self.sketch}{super()._repr_html_()}</div>"

    def press(self, gravity: Sequence[float] = (0.0, 0.0, -9.81), *, slide: str | None = None) -> Linkage:
        """Load the press from its URDF.

        Args:
            gravity: (3,) in world axes [m/s2].
            slide: name of the slide, as for `load`.

        Raises:
            PinTableError: a machine element of the table makes no sense in the linkage.
            PinpressError: `load` refuses the press.
        """
        command = "check() of its draft" if self.file == CALL else check_command(self.file, parameters=self._given)
        try:
            return load_document(self._document(), None, slide, gravity, in_file=False, command=command)
        except UrdfError as error:
            entry = self._elements.get(error.element)
            if entry is None:
                raise
            raise PinTableError(entry.file, entry.line, ": ".join(entry.path), error.problem, error.remedy) from error

    def check(self, slide: str | None = None) -> CheckResult:
        """Check how the press moves, and list all errors, doubts and notes, as `pinpress.check` does.

        Args:
            slide: as for `load`.
        """
        result = check_document(self.file, self._document(), slide=slide, in_file=False)
        findings: list[Finding] = []
        for each in result.findings:  # their lines belong to a URDF that the user has not seen
            entry = self._elements.get(each.element)
            element, line = (each.element, None) if entry is None else (": ".join(entry.path), entry.line)
            findings.append(replace(each, element=element, line=line))
        return replace(result, findings=Records(Finding, findings))

    @property
    def _elements(self) -> dict[str | None, Entry]:
        """Entries of machine elements, by what messages about their URDF call them (`Document.called`)."""
        return {f'<{each.tag} name="{each.name}">': each.entry for each in self.parts.elements}

    def _document(self, file: str | None = None, urdf: bytes | None = None) -> Document:
        """A URDF of this press, or the one that was written to a file; links with estimated moments of inertia are marked."""
        estimated = frozenset(link.name for link in self.parts.links if not link.inertia_given)
        return Document(file or f"{self.file}{self._with_given} as URDF", urdf or self._text(), estimated=estimated)

    @property
    def _with_given(self) -> str:
        return f" with {', '.join(self._given)}" if self._given else ""

    @property
    def title(self) -> str:
        """The press, how many links it has, and its size."""
        return f"DrawnPress {self.name}: {len(self.parts.links)} links and the frame, {size_of(self.parts.pins):.3f} m across"

    def columns(self) -> Columns:
        """Bearings with the links that they connect and their places in the drawn pose."""
        names, exerting, loaded = zip(*self.bearings(), strict=True)
        pins = {bearing.name: bearing.pin for bearing in (*self.tree.joints, *self.tree.loops)}
        origins = {link.guide.name: link.origin for link in self.parts.links if link.guide is not None}
        points = np.array([origins[name] if (pin := pins[name]) is None else self.parts.pins[pin].point for name in names])
        named = {"bearing": list(names), "force of": list(exerting), "on": list(loaded)}
        return named | {f"{axis} [m]": points[:, k] for k, axis in enumerate("xyz")}

    def bearings(self) -> Iterator[tuple[str, str, str]]:
        """For every bearing: its name, the link that exerts its force, and the link on which the force acts."""
        for bearing in (*self.tree.joints, *self.tree.loops):
            yield bearing.name, bearing.link1, bearing.link2

    def estimates(self) -> Iterator[tuple[str, str]]:
        """Names of links with their estimated values."""
        for link in self.links:
            for estimate in link.estimates:
                yield link.name, estimate
            if link.guide is not None and link.guide.name in self.tree.drivers and link.guide.travel is None:
                reach = f"{REACH:g} times the size of the press either way"
                yield link.name, f"travel of its guide, {reach}: give travel, which determines the stroke"

    def other_places(self) -> Iterator[tuple[str, tuple[float, float], tuple[float, float]]]:
        """Pins whose lengths allow another place: name, (x, z) of the place and (x, z) of the other place, in the table's unit."""
        unit = UNITS[self.unit]
        for name, pin in self.pins.items():
            if pin.other is not None:
                yield name, (pin.point[0] / unit, pin.point[2] / unit), (pin.other[0] / unit, pin.other[2] / unit)

    def with_other_place(self, pin: str) -> DrawnPress:
        """Build the press with a pin in its other place, as the other ``side`` gives it. Pins that are placed from this pin move too.

        Args:
            pin: name of a pin that `other_places` lists.

        Raises:
            UnknownNameError: there is no such pin, or its lengths allow no other place.
            PinTableError: the pin in its other place makes no press.
        """
        places = {name: other for name, _, other in self.other_places()}
        if pin not in places:
            raise UnknownNameError("pin with another place", pin, places)
        items = self._table.items("a table")
        pins = dict(items["pins"].items("pins"))
        entry = pins[pin]
        near = replace(entry, value=tuple(replace(entry, value=each) for each in places[pin]))
        kept = {key: each for key, each in entry.items("a pin").items() if key not in ("side", "near")}
        pins[pin] = replace(entry, value=kept | {"near": near})
        drawn = drawn_from(replace(self._table, value={**items, "pins": replace(items["pins"], value=pins)}))
        return replace(drawn, _given=self._given)

    def _text(self, shown: Sequence[ShownLink] = ()) -> bytes:
        """The URDF, with the shapes of these links."""
        items = self._table.items("a table")
        clockwise = "turns" in items and _is_clockwise(items["turns"])
        turning = "(0, 1, 0), so a positive angle turns z towards x" if clockwise else "(0, -1, 0), so a positive angle turns x towards z"
        lines = [
            f"{self.name}: {MARK.decode()} {Path(self.file).name}{self._with_given}.",
            f"Drawn at crank angle 0. x to the right, z up; pins turn about {turning}. SI units.",
            "",
            "Bearings, and the links between which their forces act:",
            *(f"  {name}: {link1} on {link2}" for name, link1, link2 in self.bearings()),
            *(f"  {element.name}: {' on '.join(element.bodies)}" for element in self.parts.elements),
        ]
        if estimates := [f"  {link}: {words}" for link, words in self.estimates()]:
            lines += ["", "Estimated, because the table does not give it:", *estimates]
        return urdf_text(self.name, "\n".join(lines), self.parts, self.tree, self.tool, shown)


def build(
    table: str | os.PathLike[str] | None = None, /, *, gravity: Sequence[float] = (0.0, 0.0, -9.81), slide: str | None = None, **values: Any
) -> Linkage:
    """Build a press from a pin table: pins by coordinates or lengths, links by their pins with masses, sections or estimates.

    In the picture x points right and z up; the drawn pose is crank angle 0. The page "A press from a table of
    pins" of the manual lists the keys of a table.

    Args:
        table: a YAML file, or the name of a shipped press, as in ``build("eccentric_blocks", r=10)``; None if ``values`` are the table.
        gravity: (3,) in world axes [m/s2].
        slide: name of the slide, the link whose motion and process force are computed, as for `load`.
        values: with a file, values of its ``parameters``, as in ``build("press.yaml", r=150)``. Without a file, the table itself, as in
            ``build(units="mm", frame="A D", pins={...}, links={...}, drive="A")``.

    Returns:
        The press in SI units, like a press that is loaded from a URDF; `write_urdf` writes it.

    Raises:
        PinTableError: the table makes no press; the message has file, line, the error and what to write.
        PinpressError: `load` refuses the linkage, for example because it cannot move.

    Warns:
        PinpressWarning: `load` warns, or a number is probably a mistake: another unit, or a centre of mass far outside its link.
    """
    return draft(table, **values).press(gravity, slide=slide)


def draft(table: str | os.PathLike[str] | None = None, /, **values: Any) -> DrawnPress:
    """Draw a press from its pin table: for the sketch, the URDF with shapes, and the list of estimates.

    Args:
        table: as for `build`.
        values: as for `build`.

    Raises:
        PinTableError: the table makes no press.

    Warns:
        PinpressWarning: a number is probably a mistake.
    """
    if isinstance(table, Mapping):
        raise PinpressError("build takes the path of a table, or the keys of one as arguments: write build(**table)")
    if table is None:
        return drawn_from(given_table(_without_units(values, values.get("units"))))
    return _with_parameters(read_table(table), values) if values else drawn_from(read_table(table))


def drawn_from(entries: Entry) -> DrawnPress:
    """Draw the press of a table; raises PinTableError if the table makes no press."""
    items = entries.items("keys: units, frame, pins, links and drive")
    for key, entry in items.items():
        if key not in KEYS and key not in BESIDE:
            entries.refuse_key(key, entry, (*KEYS, *BESIDE))
    for key, remedy in NEEDED.items():
        if (key not in items or not items[key].value) and not (key == "frame" and _act_on_frame(items)):
            entries.refuse(f"no {key}", remedy)
    unit = items["units"].text("a unit of length")
    if unit not in UNITS:
        items["units"].refuse(f"{unit!r} is not a unit of length here{suggestion(unit, UNITS)}", f"write one of {', '.join(UNITS)}")
    numbers = Numbers(parameters_of(items), UNITS[unit])
    try:
        pins = place_pins(items["pins"], numbers)
    except UnreachableError as error:
        drawn = sketch_of_failure(error, UNITS[unit], unit)
        raise PinTableError(error.file, error.line, error.element, error.problem, error.remedy, drawn) from error
    clockwise = "turns" in items and _is_clockwise(items["turns"])
    if clockwise:  # turn all axes that are normal to the picture together
        pins = {name: pin if pin.in_space or pin.axis is None else replace(pin, axis=-pin.axis) for name, pin in pins.items()}
    _check_size(items["pins"], pins, unit)
    links = read_links(items, pins, numbers)
    _check_links(links, pins, unit)
    parts = _parts(items, pins, links, numbers)
    for each in items["copies"].list("copies: [{links: rod, y: [-300, 300], names: _front _back}]") if "copies" in items else ():
        parts = copied(parts, each, numbers)
    tree = build_tree(parts, entries)
    _check_names(parts, tree)
    if clockwise:  # a ratio between a reversed axis and a guide or an axis in space changes its sign: teeth mesh as before
        sense = {joint.name: -1.0 if joint.pin is not None and not parts.pins[joint.pin].in_space else 1.0 for joint in tree.joints}
        meshing = {name: (leader, ratio * sense[name] * sense[leader]) for name, (leader, ratio) in tree.gears.items()}
        tree = replace(tree, gears=meshing)
    _check_racks(items, tree, size_of(pins), unit)
    name = items["press"].text("a name") if "press" in items else "press"
    if odd := odd_character(name):
        items["press"].refuse(f"{name!a} has the character {odd}, which no line shows as it is", "choose another name")
    tool = read_tool(items, pins, parts, tree, numbers)
    return DrawnPress(name, entries.file, unit, pins, links, parts, tree, tool, entries)


def _act_on_frame(items: Mapping[str, Entry]) -> bool:
    """Whether a machine element acts on the frame, as a nut that is fixed there: then no pin need be in it."""
    sections = [items[name].value for name in SECTIONS if name in items]
    elements = [each.value for section in sections if isinstance(section, Mapping) for each in section.values()]
    words = [each.value for element in elements if isinstance(element, Mapping) for each in element.values()]
    return any(FRAME in word.split() for word in words if isinstance(word, str))


def _is_clockwise(entry: Entry) -> bool:
    """Whether positive angles, speeds and torques are clockwise in the picture."""
    sense = entry.text("clockwise or counter-clockwise")
    if sense not in SENSES:
        entry.refuse(f"{sense!r} is not a sense of rotation{suggestion(sense, SENSES)}", f"write {' or '.join(SENSES)}")
    return sense == SENSES[0]


def _positions(press: Linkage) -> Array:
    """Joint positions (n, nv) over a turn; only the drawn pose if the press cannot turn round or has several drivers."""
    if len(press.drivers) > 1:
        return press.closed[None]
    try:
        if press.branch.period is not None and press.turns_until_back is None:
            return servo_cycle(press, np.arange(24) * (2 * np.pi / 24), speed=1.0, acceleration=0.0).joint_position
        return cycle(press, speed=1.0, points=24).joint_position
    except (AssemblyError, SingularityError):
        return press.closed[None]


def _with_parameters(table: Entry, values: Mapping[str, Any]) -> DrawnPress:
    """The press of a table with other values of its parameters."""
    items = table.items("a table")
    known = items["parameters"].items("names with numbers") if "parameters" in items else {}
    for name in values:
        if name not in known:
            where = f"its parameters are {', '.join(known)}" if known else "it has no parameters"
            table.refuse(f"no parameter {name}{suggestion(name, known)}", where)
    numbers = _without_units(values, items["units"].value if "units" in items else None)
    above = given_table({"parameters": numbers}).items("parameters")["parameters"]
    drawn = drawn_from(overlaid(table, replace(table, value={"parameters": above}, path=())))
    words = (f"{name}={value:.9g}" if isinstance(value, float) else f"{name}={value}" for name, value in numbers.items())
    return replace(drawn, _given=tuple(words))


def _without_units(value: Any, unit: object, depth: int = 0) -> Any:
    """Replace quantities of pint by numbers of a table: lengths in its unit, angles in degrees, the rest in SI units.

    Below the deepest level of a table all stays as it is: a list may contain itself.
    """
    if isinstance(value, Mapping | list | tuple) and depth > DEEPEST:
        return value
    if isinstance(value, Mapping):
        return {key: _without_units(each, unit, depth + 1) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_without_units(each, unit, depth + 1) for each in value]
    if not is_quantity(value):
        return value
    length = UNITS.get(unit, 1.0) if isinstance(unit, str) else 1.0  # any other unit is refused later
    for name, one in (("m", length), ("kg", 1.0), ("kg m2", 1.0), ("kg/m3", 1.0), ("rad", np.pi / 180)):
        with suppress(PinpressError):
            return np.asarray(in_unit("a value", value, name) / one).tolist()
    raise PinpressError(f"build: a table cannot hold {shown(value)}: give lengths, angles, masses or moments of inertia")


def _parts(items: Mapping[str, Entry], pins: Mapping[str, Pin], links: tuple[Link, ...], numbers: Numbers) -> Parts:
    fixed = items.get("frame")
    if fixed is not None and isinstance(fixed.value, Mapping):
        fixed.refuse("keys with values", "the pins fixed in the frame stand here, frame: A D; mass and mounts go into foundation")
    frame = () if fixed is None else tuple(fixed.names("names of pins, separated by blanks"))
    for name in frame:
        if name not in pins and fixed is not None:
            fixed.refuse(f"no pin {name}{suggestion(name, pins)}", f"name some of {', '.join(pins)}")
    drivers = tuple(items["drive"].names("the pin that is driven"))
    gears = items["gears"].items("gears: {V: -2 * O}") if "gears" in items else {}
    elements = read_machine_elements(items, pins, links, numbers)
    return Parts(pins, links, frame, drivers, {name: _gear(entry, numbers.parameters) for name, entry in gears.items()}, elements)


def _gear(entry: Entry, parameters: Mapping[str, float]) -> tuple[str, float]:
    """The bearing that a geared bearing follows, and the ratio; the formula is proportional to one bearing."""
    text, known = entry.text("a formula of one bearing, such as -2 * O"), (*parameters, *CONSTANTS, *FUNCTIONS)
    words = {word for word in re.findall(r"[A-Za-z_]\w*", text) if word not in known}
    if len(words) != 1:
        entry.refuse(f"{text!r} has {len(words)} bearings", "write a formula of one bearing, such as -2 * O")
    (leader,) = words
    once, twice, none = (formula(entry, {**parameters, leader: turns}) for turns in (1.0, 2.0, 0.0))
    if none or not np.isclose(twice, 2 * once, rtol=1e-12) or not once:
        entry.refuse(f"{text!r} is not proportional to {leader}", "write a ratio times a bearing, such as -2 * O")
    return leader, once


def _check_racks(items: Mapping[str, Entry], tree: Tree, size: float, unit: str) -> None:
    """Warn if a shaft moves a guide by far more than the size of the press in a radian: the number is probably in the table's unit."""
    guides = {joint.name for joint in tree.joints if joint.pin is None}
    for follower, (leader, ratio) in tree.gears.items():
        if (follower in guides) != (leader in guides):
            radius = abs(ratio) if follower in guides else 1 / abs(ratio)
            if radius > 10 * size > 0.0:
                written = items["gears"].items("gears").get(follower, items["gears"]) if "gears" in items else items["copies"]
                guide, shaft = (follower, leader) if follower in guides else (leader, follower)
                right = f"{radius * UNITS[unit]:.6g} m/rad for {radius:.6g} {unit}" if UNITS[unit] < 1 else "the pitch radius of a pinion"
                doubt = f"{shaft} moves {guide} by {radius:.6g} m/rad: gears of guides are in m/rad, not in units: {right}"
                written.doubt(f"{doubt}. A table in {unit} has racks: {{rack: {{pinion: , rack: , radius: }}}} and screws: with their lead")


def _check_names(parts: Parts, tree: Tree) -> None:
    """Refuse a machine element with the name of a bearing: both name forces."""
    bearings = [bearing.name for bearing in (*tree.joints, *tree.loops)]
    for element in parts.elements:
        if element.name in bearings:
            element.entry.refuse(f"{element.name} is a bearing, whose force has this name", "give the machine element another name")


def _check_size(entry: Entry, pins: Mapping[str, Pin], unit: str) -> None:
    """Refuse a press that is larger than any press; warn of a press that is too small to be one."""
    size = size_of(pins)
    largest = f"the largest distance is {size / UNITS[unit]:.4g} {unit}"
    if size > 200.0:  # [m]
        entry.refuse(largest, f"is it units: {'mm' if unit == 'm' else 'another'}?")
    if 0 < size < 0.02:
        entry.doubt(f"{largest}; is it units: {'m' if unit == 'mm' else 'another'}?")


def _check_links(links: tuple[Link, ...], pins: Mapping[str, Pin], unit: str) -> None:
    """Warn of centres of mass far outside of their links."""
    size = size_of(pins)
    for link in links:
        if link.guide is None:
            reach = max(float(np.linalg.norm(pins[name].point - link.origin)) for name in link.pins)
            away = float(np.linalg.norm(link.centre - link.origin))
            if away > 3 * max(reach, 0.2 * size):
                far = f"com is {away / UNITS[unit]:.4g} {unit} from {link.pins[0]}, the link reaches {reach / UNITS[unit]:.4g}"
                link.entry.doubt(f"{far}; to give a place in the drawing, name a point of pins")
