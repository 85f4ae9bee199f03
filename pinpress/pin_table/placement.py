"""Place the pins of a table: by coordinates, by a length and an angle, by two lengths, or by a length and a line.

In the picture's plane x points right and z up; angles count counter-clockwise from +x towards z. Two lengths, or a length and a line, fit
at two places. ``side`` chooses one of them. The other place is kept: a wrong side gives that assembly.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NoReturn

import numpy as np

from ..common.errors import PinTableError, odd_character, suggestion
from ..common.quantities import Array, quantity
from .formulas import number
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


def place_pins(entries: Entry, parameters: Mapping[str, float], unit: float) -> dict[str, Pin]:
    """Place all pins; the result has the order in which they could be placed.

    Args:
        entries: the table's ``pins``.
        parameters: parameter name -> value.
        unit: the table's unit of length [m].

    Raises:
        PinTableError: an entry has a wrong key or value, or pins are placed by one another.
        UnreachableError: the lengths do not meet.
    """
    placing = _Placing(entries, parameters, unit)
    for name in placing.items:
        placing.pin(name, ())
    return placing.pins


def refuse_unless_a_word(name: str, entry: Entry, what: str) -> None:
    """Refuse a name that is not one word: ``pins: A B`` and URDFs separate names by blanks."""
    word = re.sub(r"[\s,;:\[\]{}<>\"'&]+", "_", name)
    if odd := odd_character(name):
        replace(entry, path=entry.path[:-1]).refuse(
            f"{name!a} has the character {odd}, which no line shows as it is", "give it another name"
        )
    if word != name or not name:
        entry.refuse(f"{name!r} cannot name {what}", f"write one word: {word}" if word.strip("_") else "write a word")


class _Placing:
    def __init__(self, entries: Entry, parameters: Mapping[str, float], unit: float) -> None:
        self.items = entries.items("pins by their names: {A: [0, 0]}")
        self.parameters, self.unit = parameters, unit
        self.pins: dict[str, Pin] = {}
        for name, entry in self.items.items():
            if name in RESERVED:
                entry.refuse(f"{name!r} cannot name a pin", f"choose a word that is not one of the keys {', '.join(RESERVED)}")
            refuse_unless_a_word(name, entry, "a pin")

    def pin(self, name: str, above: tuple[str, ...]) -> Pin:
        """The pin of this name. The pins that it is measured from are placed first."""
        if name not in self.pins:
            entry = self.items[name]
            if name in above:
                circle = (*above[above.index(name) :], name)
                entry.refuse(f"pins are placed by one another: {' - '.join(circle)}", "give one of them by coordinates, or by other pins")
            placed = self._placed(name, entry, (*above, name))
            self.pins[name] = placed
        return self.pins[name]

    def _placed(self, name: str, entry: Entry, above: tuple[str, ...]) -> Pin:
        if isinstance(entry.value, tuple):
            return Pin(name, _raised(self._pair(entry)), np.array(PIN_AXIS), False, None, (), entry)
        if isinstance(entry.value, str) and " " not in entry.value.strip():
            same = self._named(entry, entry.value.strip(), above)
            return Pin(name, same.point, same.axis, same.in_space, None, (), entry)
        items = entry.items("a place: [x, z], the name of a pin at the same point, or {from: ..., length: ..., angle: ...}")
        joint, axis = self._joint(items)
        in_space = joint or "axis" in items
        point, other, lengths = self._point(entry, items, above)
        across = self._length(items["y"]) if "y" in items else 0.0
        lifted = _raised(point, across)
        return Pin(name, lifted, axis, in_space, None if other is None else _raised(other, across), lengths, entry)

    def _joint(self, items: Mapping[str, Entry]) -> tuple[bool, Array | None]:
        """Whether a pin is a ball joint, and the axis of a pin that is no ball joint."""
        if "joint" in items and items["joint"].value != "ball":
            items["joint"].refuse(f"{items['joint'].value!r} is not a joint of a pin", "write joint: ball, or leave it out")
        if "joint" in items and "axis" in items:
            items["axis"].refuse("a ball joint has no axis", "leave out axis or joint")
        if "joint" in items:
            return True, None
        return False, self._axis(items["axis"]) if "axis" in items else np.array(PIN_AXIS)

    def _axis(self, entry: Entry) -> Array:
        if isinstance(entry.value, tuple):
            if len(entry.value) != 3:
                entry.refuse(f"an axis of {len(entry.value)} numbers", "write axis: x, y, z, -x, -y, -z, or three numbers")
            axis = np.array([number(each, self.parameters) for each in entry.value])
            if not np.linalg.norm(axis) > 0:
                entry.refuse("an axis of length zero", "write a direction, such as [1, 0, 0]")
            return np.asarray(axis / np.linalg.norm(axis))
        name = entry.text("an axis")
        if name.lstrip("-") not in AXES or name.count("-") > 1:
            entry.refuse(f"{name!r} is not an axis", "write x, y, z, -x, -y, -z, or three numbers")
        return np.array(AXES[name.lstrip("-")]) * (-1.0 if name.startswith("-") else 1.0)

    def _point(
        self, entry: Entry, items: Mapping[str, Entry], above: tuple[str, ...]
    ) -> tuple[Array, Array | None, tuple[tuple[str, float], ...]]:
        """The place in the picture's plane, the other place that fits, and the pins or points that it was measured from."""
        for key, value in items.items():
            if key not in RESERVED and key not in self.items:
                entry.refuse_key(key, value, [*RESERVED, *self.items])
        lengths = {key: value for key, value in items.items() if key not in RESERVED}
        if "from" in items:
            self._only(entry, items, lengths, ("from", "at", "length", "angle"))
            return self._polar(entry, items, above)
        if len(lengths) == 2:
            self._only(entry, items, {}, (*lengths, "side", "near"))
            return self._chosen(entry, items, self._two_circles(entry, lengths, above), above)
        if len(lengths) == 1:
            self._only(entry, items, {}, (*lengths, "x", "z", "on", "side", "near"))
            return self._chosen(entry, items, self._circle_and_line(entry, items, lengths, above), above)
        if lengths:
            entry.refuse(f"{len(lengths)} lengths", "give two lengths, or one length and a line (x:, z: or on:)")
        self._only(entry, items, {}, ("x", "z"))
        if "x" not in items or "z" not in items:
            entry.refuse(
                "no place",
                "give [x, z]; {from: A, length: ..., angle: ...}; two lengths {A: ..., B: ..., side: ...}; or a length and a line",
            )
        return np.array([self._length(items["x"]), self._length(items["z"])]), None, ()

    def _only(self, entry: Entry, items: Mapping[str, Entry], forbidden: Mapping[str, Entry], keys: Sequence[str]) -> None:
        allowed = {*keys, "axis", "joint", "y"}
        for key, value in items.items():
            if key in forbidden or key not in allowed:
                value.refuse(
                    f"{key} does not go with {', '.join(k for k in items if k in keys) or 'the rest'}", "give one way to place the pin"
                )

    def _polar(self, entry: Entry, items: Mapping[str, Entry], above: tuple[str, ...]) -> tuple[Array, None, tuple[tuple[str, float], ...]]:
        names = items["from"].names("a pin, or two")
        if len(names) > 2:
            items["from"].refuse(f"{len(names)} pins", "name the pin to start from, and the pin that the angle counts from")
        pins = [self._named(items["from"], name, above) for name in names]
        start = _flat(pins[0].point)
        if "at" in items:
            if len(names) > 1 or "length" in items or "angle" in items:
                items["at"].refuse("`at` needs one pin in `from` and no other key", "write {from: A, at: [dx, dz]}, or length and angle")
            return start + self._pair(items["at"]), None, ()
        if "length" not in items:
            entry.refuse("no length", "write {from: A, length: ..., angle: ...} or {from: A, at: [dx, dz]}")
        if "angle" not in items and len(names) == 1:
            entry.refuse("no angle", "say angle: in degrees from +x, counter-clockwise")
        length = self._not_negative(items["length"])
        angle = math.radians(number(items["angle"], self.parameters)) if "angle" in items else 0.0
        if len(names) == 2:
            ray = _flat(pins[1].point) - start
            if not np.linalg.norm(ray) > 0:
                items["from"].refuse(f"{names[0]} and {names[1]} are one point", "name two points, whose line the angle counts from")
            angle += math.atan2(ray[1], ray[0])
        return start + length * np.array([math.cos(angle), math.sin(angle)]), None, ((names[0], length),)

    def _two_circles(self, entry: Entry, lengths: Mapping[str, Entry], above: tuple[str, ...]) -> _Fits:
        (a, first), (b, second) = ((name, self._positive(each)) for name, each in lengths.items())
        start, end = (_flat(self._named(entry, name, above).point) for name in (a, b))
        along, distance = end - start, float(np.linalg.norm(end - start))
        measured = ((a, first), (b, second))
        if distance <= ALIKE * (first + second):
            entry.refuse(f"{a} and {b} are one point", "measure from two points that are apart")
        if not abs(first - second) <= distance * (1 + ALIKE) or not distance <= (first + second) * (1 + ALIKE):
            far = f"{a} and {b} are {self._shown(distance)} apart"
            problem = f"{self._shown(first)} and {self._shown(second)} do not meet: {far}"
            self._unreachable(entry, problem, "make one of them longer or shorter", ((start, first), (end, second)), None)
        forward = (first**2 - second**2 + distance**2) / (2 * distance)
        across = math.sqrt(max(first**2 - forward**2, 0.0))
        along = along / distance
        left = np.array([-along[1], along[0]])
        return _Fits(start + forward * along + across * left, start + forward * along - across * left, (start, end), measured)

    def _circle_and_line(self, entry: Entry, items: Mapping[str, Entry], lengths: Mapping[str, Entry], above: tuple[str, ...]) -> _Fits:
        ((name, each),) = lengths.items()
        radius, centre = self._positive(each), _flat(self._named(entry, name, above).point)
        point, along, words = self._line(entry, items, above)
        foot = point + ((centre - point) @ along) * along
        away = float(np.linalg.norm(centre - foot))
        if away > radius * (1 + ALIKE):
            problem = f"{self._shown(radius)} from {name} does not reach {words}: {self._shown(away)} away"
            self._unreachable(entry, problem, "make it longer, or move the line", ((centre, radius),), (point, along))
        half = math.sqrt(max(radius**2 - away**2, 0.0))
        return _Fits(foot + half * along, foot - half * along, None, ((name, radius),))

    def _line(self, entry: Entry, items: Mapping[str, Entry], above: tuple[str, ...]) -> tuple[Array, Array, str]:
        """A point and the direction of the line that a pin is on, and the name of the line."""
        given = [key for key in ("x", "z", "on") if key in items]
        if len(given) != 1:
            remedy = "give one of x:, z: and on:, or a second length"
            entry.refuse("one length and no line" if not given else f"one length and {len(given)} lines", remedy)
        if given == ["on"]:
            names = items["on"].names("two pins")
            if len(names) != 2:
                items["on"].refuse(f"a line through {len(names)} points", "name two pins: on: Q R")
            start, end = (_flat(self._named(items["on"], name, above).point) for name in names)
            if not np.linalg.norm(end - start) > 0:
                items["on"].refuse(f"{names[0]} and {names[1]} are one point", "name two points that are apart")
            return start, (end - start) / np.linalg.norm(end - start), f"the line {' '.join(names)}"
        value = self._length(items[given[0]])
        words = f"{given[0]} = {self._shown(value)}"
        return (
            (np.array([value, 0.0]), np.array([0.0, 1.0]), words)
            if given == ["x"]
            else (np.array([0.0, value]), np.array([1.0, 0.0]), words)
        )

    def _chosen(
        self, entry: Entry, items: Mapping[str, Entry], fits: _Fits, above: tuple[str, ...]
    ) -> tuple[Array, Array | None, tuple[tuple[str, float], ...]]:
        """Choose one of two places by the side."""
        size = max(float(np.abs(np.stack([fits.first, fits.second])).max()), *(length for _, length in fits.measured))
        if np.linalg.norm(fits.first - fits.second) <= math.sqrt(ALIKE) * 1e-2 * size:
            return (fits.first + fits.second) / 2, None, fits.measured
        places = f"{self._place(fits.first)} and {self._place(fits.second)}"
        if "side" in items and "near" in items:
            items["near"].refuse("both side and near", "give one of them")
        if "near" in items:
            wanted = self._pair(items["near"])
            better = float(np.linalg.norm(fits.second - wanted) - np.linalg.norm(fits.first - wanted))
        elif "side" in items:
            better = self._better(items["side"], fits, places)
        else:
            entry.refuse(f"two places fit, {places}", "say side: up, down, left or right" + (", ccw or cw" if fits.ends else ""))
        if abs(better) <= ALIKE * size:
            said = items.get("near", items.get("side"))
            assert said is not None
            said.refuse(f"it does not choose a place: {places} are equal in this direction", self._instead(said, fits))
        return (fits.first, fits.second, fits.measured) if better > 0 else (fits.second, fits.first, fits.measured)

    def _better(self, entry: Entry, fits: _Fits, places: str) -> float:
        """How much more the first place is on the side than the second."""
        side = entry.text("a side")
        if side in SIDES:
            return float((fits.first - fits.second) @ np.array(SIDES[side]))
        if side in ("ccw", "cw") and fits.ends is not None:
            return 1.0 if side == "ccw" else -1.0  # the first is on the left of the way from the first pin to the second
        allowed = [*SIDES, *(("ccw", "cw") if fits.ends else ())]
        return entry.refuse(
            f"{side!r} is not a side here{suggestion(side, allowed)}", f"two places fit, {places}: write one of {', '.join(allowed)}"
        )

    def _instead(self, entry: Entry, fits: _Fits) -> str:
        vertical = entry.value in ("up", "down")
        return f"say {'left or right' if vertical else 'up or down'}" + (", ccw or cw" if fits.ends else "")

    def _unreachable(
        self, entry: Entry, problem: str, remedy: str, circles: tuple[tuple[Array, float], ...], along: tuple[Array, Array] | None
    ) -> NoReturn:
        error = UnreachableError(entry.file, entry.line, ": ".join(entry.path), problem, remedy)
        error.pins, error.circles, error.along = tuple(self.pins.values()), circles, along
        raise error

    def _named(self, entry: Entry, name: str, above: tuple[str, ...]) -> Pin:
        if name not in self.items:
            entry.refuse(f"no pin {name}{suggestion(name, self.items)}", f"name one of {', '.join(self.items)}")
        return self.pin(name, above)

    def _pair(self, entry: Entry) -> Array:
        values = entry.list("a point: [x, z]")
        if len(values) != 2:
            problem = f"{len(values)} numbers found, but a point is [x, z]"
            entry.refuse(problem, "write decimals after a point, not a comma; a point in space is {x: , y: , z: }")
        return np.array([self._length(each) for each in values])

    def _length(self, entry: Entry) -> float:
        length = number(entry, self.parameters) * self.unit
        if abs(length) > LONGEST:
            entry.refuse(f"{self._shown(length)} is more than {LONGEST / 1e3:g} km", "check lengths and units against the drawing")
        return length

    def _positive(self, entry: Entry) -> float:
        length = self._length(entry)
        if length <= 0:
            entry.refuse(f"a length of {self._shown(length)}", "write a length above zero")
        return length

    def _not_negative(self, entry: Entry) -> float:
        length = self._length(entry)
        if length < 0:
            entry.refuse(f"a length of {self._shown(length)}", f"write {self._shown(-length)}, and turn the angle by 180")
        return length

    def _shown(self, length: float) -> str:
        return f"{length / self.unit:.6g}"

    def _place(self, point: Array) -> str:
        return "({})".format(", ".join(f"{x / self.unit:.4g}" for x in point))


@dataclass(frozen=True, eq=False)
class _Fits:
    """The two places that lengths allow; with two ``ends`` the first place is on the left of the line between them."""

    first: Array
    second: Array
    ends: tuple[Array, Array] | None
    measured: tuple[tuple[str, float], ...]


def _flat(point: Array) -> Array:
    return point[[0, 2]]


def _raised(point: Array, across: float = 0.0) -> Array:
    return np.array([point[0], across, point[1]])
