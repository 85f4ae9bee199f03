"""Machine elements of a pin table: gears, racks, screws, worms and cams, by which two links push on each other.

This module reads the table; the linkage checks whether the teeth can mesh.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from ..common.errors import suggestion
from . import cams
from .formulas import Numbers
from .links import FRAME, Link
from .placement import UNITS, Pin, refuse_unless_a_word
from .reading import Entry

HANDS = ("right", "left")  # of a helix or thread; a mirror image has the other one
SIDES = ("left", "right")  # on which a pinion lies of its rack; likewise
DOUBLE = "double"  # helix of herringbone teeth, which push nothing along their axis
_WITH_UNIT = re.compile(rf"\s*([-+.\d]+(?:[eE][-+]?\d+)?)\s*({'|'.join(UNITS)})\s*")


class Section(NamedTuple):
    """A section of a table whose entries are machine elements of one kind.

    Attributes:
        tag: of its elements in a URDF.
        bodies: attributes of the two links that push on each other; also the keys, except of gears.
        required: keys that an element must have, with what to write.
        lengths: keys whose values are lengths; here and below the attributes have the same names.
        numbers: keys whose values are numbers or angles in degrees.
        words: keys whose values are words.
        others: further keys.
    """

    tag: str
    bodies: tuple[str, str]
    required: Mapping[str, str]
    lengths: tuple[str, ...] = ()
    numbers: tuple[str, ...] = ()
    words: Mapping[str, tuple[str, ...]] = {}
    others: tuple[str, ...] = ("carrier",)

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys of an element."""
        return tuple(dict.fromkeys((*self.required, *self.lengths, *self.numbers, *self.words, *self.others, "note")))


SECTIONS: Mapping[str, Section] = {
    "meshes": Section(
        "gear_mesh",
        ("gear1", "gear2"),
        {"gears": "name the two gears: gears: pinion wheel", "teeth": "give the teeth of both: teeth: 20 100; internal ones below zero"},
        lengths=("module",),
        numbers=("pressure_angle", "efficiency", "planets"),
        others=("helix", "carrier", "at"),
    ),
    "racks": Section(
        "rack",
        ("pinion", "rack"),
        {"pinion": "name the link that turns: pinion: shaft", "rack": "name the link that slides: rack: slide"},
        lengths=("radius", "module"),
        numbers=("teeth", "pressure_angle", "efficiency"),
        words={"side": SIDES},
        others=("helix", "carrier"),
    ),
    "screws": Section(
        "screw",
        ("screw", "nut"),
        {
            "screw": "name the link that turns: screw: flywheel",
            "nut": "name the link that slides: nut: slide",
            "lead": "give the lead of a turn: lead: 20",
        },
        lengths=("lead", "diameter", "collar_diameter"),
        numbers=("flank", "friction", "collar_friction"),
        words={"hand": HANDS},
        others=(),
    ),
    "worms": Section(
        "worm",
        ("worm", "wheel"),
        {
            "worm": "name the link that has the worm: worm: motor_shaft",
            "wheel": "name the link that has the wheel: wheel: crank",
            "starts": "give the starts of the worm: starts: 2",
            "teeth": "give the teeth of the wheel: teeth: 40",
        },
        lengths=("module",),
        numbers=("starts", "teeth", "quotient", "pressure_angle", "friction"),
        words={"hand": HANDS},
    ),
    "cams": Section(
        "cam",
        ("cam", "follower"),
        {
            "cam": "name the link that turns: cam: crank",
            "follower": "name the link that the cam moves: follower: ejector",
            "radius": "give the distance from the axis of the cam to the centre of the roller at the lift 0: radius: 80",
            "roller": "give diameter x width of the roller: roller: 40 x 30",
        },
        lengths=("radius", "offset", "arm"),
        numbers=("drawn_at",),
        words={"kind": ("open", "groove")},
        others=("at", "law", "lifts"),
    ),
}


@dataclass(frozen=True, eq=False)
class MachineElement:
    """A machine element of a table.

    Attributes:
        name: of the element and of its force.
        section: its section of the table, a key of `SECTIONS`.
        links: attribute of its URDF element -> link or frame: the two links that push on each other, and their carrier, if the table names
            it.
        values: attribute -> number [m or deg, or without unit] or word.
        centres: attribute -> pin that is the centre of a gear without a bearing of its own, or of the roller of a cam's follower.
        entry: its place in the table.
        points: elements in its URDF element, as tags with attributes: the law of a cam.
    """

    name: str
    section: str
    links: Mapping[str, str]
    values: Mapping[str, float | str]
    centres: Mapping[str, str]
    entry: Entry
    points: tuple[cams.Point, ...] = ()

    @property
    def tag(self) -> str:
        """Of its element in a URDF."""
        return SECTIONS[self.section].tag

    @property
    def bodies(self) -> tuple[str, ...]:
        """The two links that push on each other: the force with the element's name acts from the first on the second."""
        return tuple(self.links[name] for name in SECTIONS[self.section].bodies)

    @property
    def carrier(self) -> str:
        """The link that carries both; the frame if the table names none."""
        return self.links.get("carrier", FRAME)


def read_machine_elements(
    items: Mapping[str, Entry], pins: Mapping[str, Pin], links: Sequence[Link], numbers: Numbers
) -> tuple[MachineElement, ...]:
    """Read the machine elements of a table.

    Args:
        items: key -> entry of the table.
        pins: pin name -> pin in its place.
        links: of the table.
        numbers: reads the table's numbers.

    Raises:
        PinTableError: an element has a wrong key or value, or two have one name.
    """
    reader = _Reader(pins, {link.name: link for link in links}, numbers)
    elements: dict[str, MachineElement] = {}
    for section in SECTIONS:
        named = items[section].items(f"elements by their names: {section}: {{name: {{...}}}}") if section in items else {}
        for name, entry in named.items():
            refuse_unless_a_word(name, entry, "a machine element")
            if name in elements:
                entry.refuse(f"{name} is a name in {elements[name].section} too", "give each machine element its own name")
            elements[name] = reader.element(section, name, entry)
    return tuple(elements.values())


class _Reader:
    def __init__(self, pins: Mapping[str, Pin], links: Mapping[str, Link], numbers: Numbers) -> None:
        self.pins, self.links, self.numbers = pins, links, numbers

    def element(self, key: str, name: str, entry: Entry) -> MachineElement:
        """Read one element of a section."""
        section = SECTIONS[key]
        items = entry.known(section.keys, f"one of {key}")
        for needed, remedy in section.required.items():
            if needed not in items:
                entry.refuse(f"no {needed}", remedy)
        written = {attribute: items[attribute] for attribute in (*section.bodies, "carrier") if attribute in items}
        if "gears" in items:
            written |= zip(section.bodies, _pair(items["gears"], "two gears"), strict=True)
        links = {attribute: self._link(each) for attribute, each in written.items()}
        values: dict[str, float | str] = {}
        if "gears" in items:
            values |= zip(("teeth1", "teeth2"), map(self.numbers.number, _pair(items["teeth"], "two numbers of teeth")), strict=True)
        values |= {each: self._length(items[each]) for each in section.lengths if each in items}
        values |= {each: self.numbers.number(items[each]) for each in section.numbers if each in items}
        values |= {each: _word(items[each], words) for each, words in section.words.items() if each in items}
        if "hand" in section.words:
            values.setdefault("hand", HANDS[0])  # which a mirror image changes
        if "helix" in items:
            values |= self._helix(items["helix"])
        if "follower" in items:
            return self._cam(MachineElement(name, key, links, values | cams.roller(items["roller"], self.numbers), {}, entry), items)
        centres = self._centres(entry, items, [links[attribute] for attribute in section.bodies]) if "gears" in items else {}
        return MachineElement(name, key, links, values, centres, entry)

    def _cam(self, cam: MachineElement, items: Mapping[str, Entry]) -> MachineElement:
        """A cam with the centre of its roller, if it is drawn, and with its law."""
        if ("law" in items) == ("lifts" in items):
            cam.entry.refuse("it needs a law or a table of lifts, one of the two", f"write {cams.LAW}")
        follower = self.links.get(cam.links["follower"])
        points = tuple(cams.points(items, follower is None or follower.guide is not None, self.numbers))
        if "at" not in items:
            return replace(cam, points=points)
        name = items["at"].text("the pin at the centre of the roller")
        if follower is None or name not in follower.pins:
            known = () if follower is None else follower.pins
            items["at"].refuse(f"no pin {name} of {cam.links['follower']}{suggestion(name, known)}", f"name one of {', '.join(known)}")
        return replace(cam, points=points, centres={"center": name})

    def _link(self, entry: Entry) -> str:
        name = entry.text("the name of a link, or frame").strip()
        name = next((link.name for link in self.links.values() if link.guide is not None and link.guide.name == name), name)
        if name not in (FRAME, *self.links):
            entry.refuse(f"no link {name}{suggestion(name, self.links)}", f"name one of {', '.join((*self.links, FRAME))}")
        return name

    def _length(self, entry: Entry) -> float:
        """A length in the table's unit or with a unit, such as 24mm [m]."""
        match = _WITH_UNIT.fullmatch(entry.value) if isinstance(entry.value, str) else None
        return self.numbers.length(entry) if match is None else self.numbers.number(replace(entry, value=match[1])) * UNITS[match[2]]

    def _helix(self, entry: Entry) -> dict[str, float | str]:
        """The angle of a helix and its hand: 15, 15 left, 25 double."""
        words = [entry.value] if isinstance(entry.value, float) else entry.names("an angle and a hand: helix: 15 left")
        angle, hand = replace(entry, value=words[0]), words[1] if len(words) > 1 else HANDS[0]
        if len(words) > 2 or hand not in (*HANDS, DOUBLE):
            entry.refuse(f"{entry.value!r} is not a helix", "write helix: 15 left, or of herringbone teeth helix: 25 double")
        whole: dict[str, float | str] = {"double_helical": "true"} if hand == DOUBLE else {"hand": hand}
        return {"helix": self.numbers.number(angle)} | whole

    def _centres(self, entry: Entry, items: Mapping[str, Entry], gears: Sequence[str]) -> dict[str, str]:
        """The pins at the centres of gears that ``at`` names: those of both, or of the one that is welded to the frame or to a link."""
        names = items["at"].names("the pin at the centre of a gear") if "at" in items else []
        for name in names:
            if name not in self.pins:
                items["at"].refuse(f"no pin {name}{suggestion(name, self.pins)}", f"name one of {', '.join(self.pins)}")
        if len(names) == 2:
            return dict(zip(("center1", "center2"), names, strict=True))
        if not names and FRAME in gears:
            entry.refuse("a gear is fixed to the frame, and nothing says where its centre is", "name the pin at its centre: at: A")
        if not names:
            return {}
        with_pin = [k for k, gear in enumerate(gears, 1) if gear != FRAME and names[0] in self.links[gear].pins]
        places = [k for k, gear in enumerate(gears, 1) if gear == FRAME] or with_pin
        if len(names) > 2 or len(places) != 1:
            items["at"].refuse(f"{' '.join(names)} does not say which gear has its centre there", "name the centres of both gears: at: B A")
        return {f"center{places[0]}": names[0]}


def copies_of(
    element: MachineElement, named: Sequence[str], pins: set[str], copies: Sequence[tuple[str, bool, bool]]
) -> Iterator[MachineElement]:
    """An element, or one for each copy of its links or pins.

    Args:
        element: of the table.
        named: names of the links that are copied.
        pins: names of the pins that are copied.
        copies: of every copy what is added to the names, whether it is a mirror image, and whether racks change sides in it.
    """
    if {*named}.isdisjoint(element.links.values()) and pins.isdisjoint(element.centres.values()):
        yield element
        return
    for suffix, mirrored, swapped in copies:
        if mirrored and element.section == "cams":
            element.entry.refuse(
                "a mirror image of it would turn the other way", "write the cam and the follower of the image in the table"
            )
        values = dict(element.values)
        for key, words, changes in (("hand", HANDS, mirrored), ("side", SIDES, swapped)):
            if changes and key in values:
                values[key] = words[1 - words.index(str(values[key]))]
        links = {key: link + suffix if link in named else link for key, link in element.links.items()}
        centres = {key: pin + suffix if pin in pins else pin for key, pin in element.centres.items()}
        yield replace(element, name=element.name + suffix, links=links, values=values, centres=centres)


def _pair(entry: Entry, what: str) -> list[Entry]:
    """Two values, separated by a blank or in a list."""
    values = list(entry.value) if isinstance(entry.value, tuple) else [replace(entry, value=word) for word in entry.names(what)]
    if len(values) != 2:
        entry.refuse(f"{len(values)} values", f"write {what} with a blank between them")
    return values


def _word(entry: Entry, words: Sequence[str]) -> str:
    word = entry.text(" or ".join(words)).strip()
    if word not in words:
        entry.refuse(f"{word!r} is not a word here{suggestion(word, words)}", f"write {' or '.join(words)}")
    return word
