"""Place the pins of a table: by coordinates, by a length and an angle, by two lengths, or by a length and a line.

In the picture's plane x points right and z up; angles count counter-clockwise from +x towards z. Two lengths, or a length and a line, fit
at two places. ``side`` chooses one of them. The other place is kept: a wrong side gives that assembly.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, NoReturn

import numpy as np

from ..common.errors import PinTableError, odd_character, suggestion
from ..common.quantities import Array, quantity
from .formulas import Numbers
from .reading import Entry

UNITS = {name: quantity("m").sizes()[name] for name in ("mm", "cm", "m", "in")}  # [m]
RESERVED = ("from", "at", "length", "angle", "side", "near", "on", "x", "y", "z", "axis", "joint")  # keys of a pin, so not names
SIDES = {"up": (0.0, 1.0), "down": (0.0, -1.0), "left": (-1.0, 0.0), "right": (1.0, 0.0)}
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
PIN_AXIS = (0.0, -1.0, 0.0)  # axis of a pin normal to the picture: a positive angle turns x towards z
LONGEST = 1e5  # longest length of a table [m]
ALIKE = 1e-9  # of the size: places closer than this are one place, and a side does not choose between them


@dataclass(frozen=True, eq=False)
class Pin:
    """A pin in its place.

    Attributes:
        name: of the pin.
        point: (3,) world coordinates in the drawn pose [m].
        axis: (3,) direction that a link turns about; None for a ball joint.
        in_space: whether the table gives its axis or joint.
        other: (3,) the place that the other side gives [m]; None if only one place fits.
        lengths: names of the pins or points that it was measured from, with the distances [m]; for the sketch.
        entry: its entry in the table.
    """

    name: str
    point: Array
    axis: Array | None
    in_space: bool
    other: Array | None
    lengths: tuple[tuple[str, float], ...]
    entry: Entry


class UnreachableError(PinTableError):
    """The circles or the line of a pin do not meet; the attributes are for a sketch.

    Attributes:
        pins: the pins that are placed already.
        circles: (2,) centres in the picture's plane and radii [m].
        along: (2,) point and (2,) direction of the line; None without a line.
    """

    pins: tuple[Pin, ...]
    circles: tuple[tuple[Array, float], ...]
    along: tuple[Array, Array] | None


def place_pins(entries: Entry, numbers: Numbers) -> dict[str, Pin]:
    """Place all pins; the result has the order in which they could be placed.

    Args:
        entries: the table's ``pins``.
        numbers: reads the table's numbers.

    Raises:
        PinTableError: an entry has a wrong key or value, or pins are placed by one another.
        UnreachableError: the lengths do not meet.
    """
    placing = _Placing(entries, numbers)
    for name in placing.items:
        placing.pin(name)
    return placing.pins


def size_of(pins: Mapping[str, Pin]) -> float:
    """Diagonal of the box about all pins [m]."""
    return float(np.linalg.norm(np.ptp([pin.point for pin in pins.values()], axis=0)))


def refuse_unless_a_word(name: str, entry: Entry, what: str) -> None:
    """Refuse a name that is not one word: ``pins: A B`` and URDFs separate names by blanks."""
    word = re.sub(r"[\s,;:\[\]{}<>\"'&]+", "_", name)
    if odd := odd_character(name):
        parent = replace(entry, path=entry.path[:-1])
        parent.refuse(f"{name!a} has the character {odd}, which no line shows as it is", "give it another name")
    if word != name or not name:
        entry.refuse(f"{name!r} cannot name {what}", f"write one word: {word}" if word.strip("_") else "write a word")


# A place in the picture's plane (2,), the other place that fits, and the names of the pins that it was measured from with the distances.
_Place = tuple[Array, Array | None, tuple[tuple[str, float], ...]]


class _Placing:
    def __init__(self, entries: Entry, numbers: Numbers) -> None:
        self.items, self.numbers = entries.items("pins by their names: {A: [0, 0]}"), numbers
        self.pins: dict[str, Pin] = {}
        self.waiting: list[str] = []  # pins being placed, each measured from the next
        for name, entry in self.items.items():
            if name in RESERVED:
                entry.refuse(f"{name!r} cannot name a pin", f"choose a word that is not one of the keys {', '.join(RESERVED)}")
            refuse_unless_a_word(name, entry, "a pin")

    def pin(self, name: str) -> Pin:
        """The pin of this name. The pins that it is measured from are placed first."""
        if name not in self.pins:
            entry = self.items[name]
            if name in self.waiting:
                circle = (*self.waiting[self.waiting.index(name) :], name)
                entry.refuse(f"pins are placed by one another: {' - '.join(circle)}", "give one of them by coordinates, or by other pins")
            self.waiting.append(name)
            self.pins[name] = self._placed(name, entry)
            self.waiting.pop()
        return self.pins[name]

    def _placed(self, name: str, entry: Entry) -> Pin:
        if isinstance(entry.value, tuple):
            return Pin(name, _raised(self._pair(entry)), np.array(PIN_AXIS), False, None, (), entry)
        if isinstance(entry.value, str) and " " not in entry.value.strip():
            same = self._named(entry, entry.value.strip())
            return Pin(name, same.point, same.axis, same.in_space, None, (), entry)
        items = entry.items("a place: [x, z], the name of a pin at the same point, or {from: ..., length: ..., angle: ...}")
        in_space = "joint" in items or "axis" in items
        axis = self._axis(items)
        point, other, lengths = self._point(entry, items)
        across = self._length(items["y"]) if "y" in items else 0.0
        return Pin(name, _raised(point, across), axis, in_space, None if other is None else _raised(other, across), lengths, entry)

    def _axis(self, items: Mapping[str, Entry]) -> Array | None:
        """The axis (3,) of a pin; None for a ball joint."""
        if "joint" in items:
            if items["joint"].value != "ball":
                items["joint"].refuse(f"{items['joint'].value!r} is not a joint of a pin", "write joint: ball, or leave it out")
            if "axis" in items:
                items["axis"].refuse("a ball joint has no axis", "leave out axis or joint")
            return None
        if "axis" not in items:
            return np.array(PIN_AXIS)
        entry = items["axis"]
        if isinstance(entry.value, tuple):
            if len(entry.value) != 3:
                entry.refuse(f"an axis of {len(entry.value)} numbers", "write axis: x, y, z, -x, -y, -z, or three numbers")
            axis = np.array([self.numbers.number(each) for each in entry.value])
            if not np.linalg.norm(axis) > 0:
                entry.refuse("an axis of length zero", "write a direction, such as [1, 0, 0]")
            return np.asarray(axis / np.linalg.norm(axis))
        direction = signed_axis(entry.text("an axis"))
        return (
            entry.refuse(f"{entry.value!r} is not an axis", "write x, y, z, -x, -y, -z, or three numbers")
            if direction is None
            else direction
        )

    def _point(self, entry: Entry, items: Mapping[str, Entry]) -> _Place:
        for key, value in items.items():
            if key not in RESERVED and key not in self.items:
                entry.refuse_key(key, value, [*RESERVED, *self.items])
        lengths = {key: value for key, value in items.items() if key not in RESERVED}
        if "from" in items:
            self._only(items, ("from", "at", "length", "angle"))
            return self._polar(entry, items)
        if len(lengths) == 2:
            self._only(items, (*lengths, "side", "near"))
            return self._chosen(entry, items, self._two_circles(entry, lengths))
        if len(lengths) == 1:
            self._only(items, (*lengths, "x", "z", "on", "side", "near"))
            return self._chosen(entry, items, self._circle_and_line(entry, items, lengths))
        if lengths:
            entry.refuse(f"{len(lengths)} lengths", "give two lengths, or one length and a line (x:, z: or on:)")
        self._only(items, ("x", "z"))
        if "x" not in items or "z" not in items:
            ways = "[x, z]; {from: A, length: ..., angle: ...}; two lengths {A: ..., B: ..., side: ...}; or a length and a line"
            entry.refuse("no place", f"give {ways}")
        return np.array([self._length(items["x"]), self._length(items["z"])]), None, ()

    def _only(self, items: Mapping[str, Entry], keys: Sequence[str]) -> None:
        for key, value in items.items():
            if key not in (*keys, "axis", "joint", "y"):
                others = ", ".join(each for each in items if each in keys) or "the rest"
                value.refuse(f"{key} does not go with {others}", "give one way to place the pin")

    def _polar(self, entry: Entry, items: Mapping[str, Entry]) -> _Place:
        origin = items["from"]
        names = origin.names("a pin, or two")
        if len(names) > 2:
            origin.refuse(f"{len(names)} pins", "name the pin to start from, and the pin that the angle counts from")
        start, *others = (_flat(self._named(origin, name).point) for name in names)
        if "at" in items:
            if others or "length" in items or "angle" in items:
                items["at"].refuse("`at` needs one pin in `from` and no other key", "write {from: A, at: [dx, dz]}, or length and angle")
            return start + self._pair(items["at"]), None, ()
        if "length" not in items:
            entry.refuse("no length", "write {from: A, length: ..., angle: ...} or {from: A, at: [dx, dz]}")
        if "angle" not in items and not others:
            entry.refuse("no angle", "say angle: in degrees from +x, counter-clockwise")
        length = self._length(items["length"])
        if length < 0:
            remedy = f"write {self._shown(-length)}, and turn the angle by 180"
            items["length"].refuse(f"a length of {self._shown(length)}", remedy)
        angle = math.radians(self.numbers.number(items["angle"])) if "angle" in items else 0.0
        if others:
            x, z = others[0] - start
            if not math.hypot(x, z) > 0:
                origin.refuse(f"{names[0]} and {names[1]} are one point", "name two points, whose line the angle counts from")
            angle += math.atan2(z, x)
        return start + length * np.array([math.cos(angle), math.sin(angle)]), None, ((names[0], length),)

    def _two_circles(self, entry: Entry, lengths: Mapping[str, Entry]) -> _Fits:
        (a, first), (b, second) = measured = tuple((name, self._positive(each)) for name, each in lengths.items())
        start, end = (_flat(self._named(entry, name).point) for name in (a, b))
        distance = float(np.linalg.norm(end - start))
        if distance <= ALIKE * (first + second):
            entry.refuse(f"{a} and {b} are one point", "measure from two points that are apart")
        if not abs(first - second) <= distance * (1 + ALIKE) or not distance <= (first + second) * (1 + ALIKE):
            far = f"{a} and {b} are {self._shown(distance)} apart"
            problem = f"{self._shown(first)} and {self._shown(second)} do not meet: {far}"
            self._unreachable(entry, problem, "make one of them longer or shorter", ((start, first), (end, second)), None)
        forward = (first**2 - second**2 + distance**2) / (2 * distance)
        across = math.sqrt(max(first**2 - forward**2, 0.0))
        along = (end - start) / distance
        left = np.array([-along[1], along[0]])
        return _Fits(start + forward * along + across * left, start + forward * along - across * left, True, measured)

    def _circle_and_line(self, entry: Entry, items: Mapping[str, Entry], lengths: Mapping[str, Entry]) -> _Fits:
        ((name, each),) = lengths.items()
        radius, centre = self._positive(each), _flat(self._named(entry, name).point)
        point, along, words = self._line(entry, items)
        foot = point + ((centre - point) @ along) * along
        away = float(np.linalg.norm(centre - foot))
        if away > radius * (1 + ALIKE):
            problem = f"{self._shown(radius)} from {name} does not reach {words}: {self._shown(away)} away"
            self._unreachable(entry, problem, "make it longer, or move the line", ((centre, radius),), (point, along))
        half = math.sqrt(max(radius**2 - away**2, 0.0))
        return _Fits(foot + half * along, foot - half * along, False, ((name, radius),))

    def _line(self, entry: Entry, items: Mapping[str, Entry]) -> tuple[Array, Array, str]:
        """A point and the direction of the line that a pin is on, and the name of the line."""
        lines = [key for key in ("x", "z", "on") if key in items]
        if len(lines) != 1:
            problem = f"one length and {len(lines)} lines" if lines else "one length and no line"
            entry.refuse(problem, "give one of x:, z: and on:, or a second length")
        line = items[lines[0]]
        if lines == ["on"]:
            names = line.names("two pins")
            if len(names) != 2:
                line.refuse(f"a line through {len(names)} points", "name two pins: on: Q R")
            start, end = (_flat(self._named(line, name).point) for name in names)
            if not np.linalg.norm(end - start) > 0:
                line.refuse(f"{names[0]} and {names[1]} are one point", "name two points that are apart")
            return start, (end - start) / np.linalg.norm(end - start), f"the line {' '.join(names)}"
        value, upright = self._length(line), np.array([0.0, 1.0])
        point, along = (np.array([value, 0.0]), upright) if lines == ["x"] else (np.array([0.0, value]), upright[::-1])
        return point, along, f"{lines[0]} = {self._shown(value)}"

    def _chosen(self, entry: Entry, items: Mapping[str, Entry], fits: _Fits) -> _Place:
        """Choose one of two places by the side."""
        size = max(float(np.abs(np.stack([fits.first, fits.second])).max()), *(length for _, length in fits.measured))
        if np.linalg.norm(fits.first - fits.second) <= math.sqrt(ALIKE) * 1e-2 * size:
            return (fits.first + fits.second) / 2, None, fits.measured
        places = " and ".join(
            "({})".format(", ".join(f"{x / self.numbers.unit:.4g}" for x in place)) for place in (fits.first, fits.second)
        )
        turned = ", ccw or cw" if fits.by_two_pins else ""
        choice = items.get("near", items.get("side"))
        if choice is None:
            entry.refuse(f"two places fit, {places}", f"say side: up, down, left or right{turned}")
        if "side" in items and "near" in items:
            choice.refuse("both side and near", "give one of them")
        if "near" in items:
            near = self._pair(choice)
            better = float(np.linalg.norm(fits.second - near) - np.linalg.norm(fits.first - near))
        else:
            better = self._better(choice, fits, places)
        if abs(better) <= ALIKE * size:
            others = "left or right" if choice.value in ("up", "down") else "up or down"
            choice.refuse(f"it does not choose a place: {places} are equal in this direction", f"say {others}{turned}")
        return (fits.first, fits.second, fits.measured) if better > 0 else (fits.second, fits.first, fits.measured)

    def _better(self, entry: Entry, fits: _Fits, places: str) -> float:
        """How much more the first place is on the side than the second."""
        side = entry.text("a side")
        if side in SIDES:
            return float((fits.first - fits.second) @ np.array(SIDES[side]))
        if side in ("ccw", "cw") and fits.by_two_pins:
            return 1.0 if side == "ccw" else -1.0  # the first is on the left of the way from the first pin to the second
        allowed = [*SIDES, *(("ccw", "cw") if fits.by_two_pins else ())]
        remedy = f"two places fit, {places}: write one of {', '.join(allowed)}"
        return entry.refuse(f"{side!r} is not a side here{suggestion(side, allowed)}", remedy)

    def _unreachable(
        self, entry: Entry, problem: str, remedy: str, circles: tuple[tuple[Array, float], ...], along: tuple[Array, Array] | None
    ) -> NoReturn:
        error = UnreachableError(entry.file, entry.line, ": ".join(entry.path), problem, remedy)
        error.pins, error.circles, error.along = tuple(self.pins.values()), circles, along
        raise error

    def _named(self, entry: Entry, name: str) -> Pin:
        if name not in self.items:
            entry.refuse(f"no pin {name}{suggestion(name, self.items)}", f"name one of {', '.join(self.items)}")
        return self.pin(name)

    def _pair(self, entry: Entry) -> Array:
        values = entry.list("a point: [x, z]")
        if len(values) != 2:
            problem = f"{len(values)} numbers found, but a point is [x, z]"
            entry.refuse(problem, "write decimals after a point, not a comma; a point in space is {x: , y: , z: }")
        return np.array([self._length(each) for each in values])

    def _length(self, entry: Entry) -> float:
        length = self.numbers.length(entry)
        if abs(length) > LONGEST:
            entry.refuse(f"{self._shown(length)} is more than {LONGEST / 1e3:g} km", "check lengths and units against the drawing")
        return length

    def _positive(self, entry: Entry) -> float:
        length = self._length(entry)
        if length <= 0:
            entry.refuse(f"a length of {self._shown(length)}", "write a length above zero")
        return length

    def _shown(self, length: float) -> str:
        return f"{length / self.numbers.unit:.6g}"


class _Fits(NamedTuple):
    """The two places that lengths allow. If they are ``by_two_pins``, the first is on the left of the line from one pin to the other."""

    first: Array
    second: Array
    by_two_pins: bool
    measured: tuple[tuple[str, float], ...]


def signed_axis(name: str) -> Array | None:
    """The direction (3,) of x, -x, y, ...; None for any other word."""
    axis = AXES.get(name.removeprefix("-"))
    return None if axis is None else np.array(axis) * (-1.0 if name.startswith("-") else 1.0)


def _flat(point: Array) -> Array:
    return point[[0, 2]]


def _raised(point: Array, across: float = 0.0) -> Array:
    return np.array([point[0], across, point[1]])
