"""Links that a press has several times: side by side or as mirror images. Other links carry all copies of their pins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..common.errors import suggestion
from ..common.quantities import Array
from .formulas import Numbers
from .links import Link, axes_along
from .machine_elements import MachineElement, copies_of
from .placement import ALIKE, AXES, Pin
from .reading import Entry

KEYS = ("links", "x", "y", "z", "mirror", "names", "gear", "note")


@dataclass(frozen=True, eq=False)
class Parts:
    """Pins, links, drives, gears and other machine elements of a press in its drawn pose (the pose that the table draws).

    Attributes:
        pins: by their names.
        links: in the table's order.
        frame: names of the pins in the frame.
        drivers: names of the driven pins and guides.
        gears: name of a geared pin or guide -> (name of the pin or guide that it follows, ratio of its motion to that one's).
        elements: gears, racks, screws and worms, by which links push on each other.
    """

    pins: Mapping[str, Pin]
    links: tuple[Link, ...]
    frame: tuple[str, ...]
    drivers: tuple[str, ...]
    gears: Mapping[str, tuple[str, float]]
    elements: tuple[MachineElement, ...] = ()


def copied(parts: Parts, entry: Entry, numbers: Numbers) -> Parts:
    """Copy links according to one entry of ``copies``.

    Raises:
        PinTableError: the entry has a wrong key or value, or names a link that cannot be copied.
    """
    items = entry.known(KEYS, "copies")
    named = _named(parts, entry, items)
    moves, mirrored = _moves(entry, items, numbers)
    suffixes = _suffixes(entry, items, len(moves))
    copies = list(zip(moves, suffixes, strict=True))
    for link in parts.links:
        if link.name not in named and link.guide is not None and link.guide.carrier in named:
            entry.refuse(f"{link.name} slides in {link.guide.carrier}, which is copied", f"copy {link.name} too")
    chosen = [link for link in parts.links if link.name in named]
    pins_copied = {name for link in chosen for name in link.pins}
    copied_bearings = pins_copied | {link.guide.name for link in chosen if link.guide is not None}

    def all_of(names: Sequence[str]) -> tuple[str, ...]:
        """Names of pins, with all copies of those that are copied."""
        return tuple(each for name in names for each in ([name + suffix for suffix in suffixes] if name in pins_copied else [name]))

    pins: dict[str, Pin] = {}
    for name, pin in parts.pins.items():
        if name not in pins_copied:
            pins[name] = pin
        for move, suffix in copies if name in pins_copied else ():
            # A mirror image turns about the mirrored axis the other way, as gears between mirrored shafts require.
            axis = None if pin.axis is None else move.turn @ pin.axis
            pins[name + suffix] = replace(pin, name=name + suffix, point=move(pin.point), axis=axis, other=None)
    links: list[Link] = []
    for link in parts.links:
        if link.name in named:
            links += [_copy(link, named, move, suffix) for move, suffix in copies]
        else:
            links.append(replace(link, pins=all_of(link.pins)))
    gears: dict[str, tuple[str, float]] = {}
    for name, (leader, ratio) in parts.gears.items():
        own = suffixes if leader in copied_bearings else [""] * len(suffixes)
        if name in copied_bearings:
            gears |= {name + suffix: (leader + end, ratio) for suffix, end in zip(suffixes, own, strict=True)}
        else:
            gears[name] = leader + own[0], ratio
    if "gear" in items:
        gears |= _geared(items["gear"], copied_bearings, suffixes, -1.0 if mirrored else 1.0)
    drivers = tuple(f"{name}{suffixes[0]}" if name in copied_bearings else name for name in parts.drivers)
    elements: list[MachineElement] = []
    for each in parts.elements:
        images = [(suffix, bool(np.linalg.det(move.turn) < 0), _swaps_sides(each, parts, move.turn)) for move, suffix in copies]
        elements += copies_of(each, named, pins_copied, images)
    return Parts(pins, tuple(links), all_of(parts.frame), drivers, gears, tuple(elements))


class _Move(NamedTuple):
    """From a link to its copy: first ``turn`` (3, 3), a reflection or the unit matrix, then a shift (3,) [m]."""

    turn: Array
    shift: Array

    def __call__(self, point: Array) -> Array:
        return self.turn @ point + self.shift


def _swaps_sides(element: MachineElement, parts: Parts, turn: Array) -> bool:
    """Whether the pinion of a mirror image is on the other side of its rack, seen along the pinion's axis with the guide upwards."""
    links = {link.name: link for link in parts.links}
    guides = [link.guide for link in map(links.get, element.bodies) if link is not None and link.guide is not None]
    if element.section != "racks" or not guides or np.array_equal(turn, np.eye(3)):
        return False
    mirrored, axes = int(np.argmin(np.diag(turn))), [parts.pins[name].axis for name in links[element.bodies[0]].pins]
    depth = next((int(np.argmax(np.abs(axis))) for axis in axes if axis is not None), 1)
    up = 1 if depth == 2 else 2
    return mirrored != depth and not (mirrored == up and abs(guides[0].direction[up]) > ALIKE)


def _copy(link: Link, named: Sequence[str], move: _Move, suffix: str) -> Link:
    guide = link.guide
    if guide is not None:
        carrier = guide.carrier + suffix if guide.carrier in named else guide.carrier
        ends = {name + suffix: move(point) for name, point in guide.ends.items()}
        guide = replace(guide, name=guide.name + suffix, carrier=carrier, direction=move.turn @ guide.direction, ends=ends)
    still = np.array_equal(move.turn, np.eye(3)) or np.array_equal(link.rotation, np.eye(3))
    return replace(
        link,
        name=link.name + suffix,
        pins=tuple(name + suffix for name in link.pins),
        guide=guide,
        centre=move(link.centre),
        inertia=move.turn @ link.inertia @ move.turn.T,
        origin=move(link.origin),
        rotation=link.rotation if still else axes_along(move.turn @ link.rotation[:, 0]),
    )


def _named(parts: Parts, entry: Entry, items: Mapping[str, Entry]) -> list[str]:
    if "links" not in items:
        entry.refuse("no links", "name the links that are copied: links: rod")
    names, known = items["links"].names("names of links"), [link.name for link in parts.links]
    for name in names:
        if name not in known:
            items["links"].refuse(f"no link {name}{suggestion(name, known)}", f"name some of {', '.join(known)}")
    return names


def _moves(entry: Entry, items: Mapping[str, Entry], numbers: Numbers) -> tuple[list[_Move], bool]:
    """Where the copies are, and whether they are mirror images."""
    ways = [key for key in ("x", "y", "z", "mirror") if key in items]
    if len(ways) != 1:
        entry.refuse(f"{', '.join(ways) or 'no way'} to copy", "give one of y: [-300, 300], x: [...] and mirror: x")
    ((way),) = ways
    if way == "mirror":
        if items[way].value not in AXES:
            items[way].refuse(f"{items[way].value!r} is not an axis", "write mirror: x, the axis that changes its sign")
        turn = np.eye(3) - 2 * np.diag(AXES[str(items[way].value)])
        return [_Move(np.eye(3), np.zeros(3)), _Move(turn, np.zeros(3))], True
    places = [numbers.length(each) for each in items[way].list(f"places: {way}: [-300, 300]")]
    if len(places) < 2 or len(set(places)) < len(places):
        items[way].refuse("several copies are in one place", f"give every copy its place: {way}: [-300, 300]")
    return [_Move(np.eye(3), np.array(AXES[way]) * place) for place in places], False


def _suffixes(entry: Entry, items: Mapping[str, Entry], count: int) -> list[str]:
    if "names" not in items:
        entry.refuse("no names", "say what is added to the names: names: _front _back")
    suffixes = items["names"].names("what is added to the names")
    if len(suffixes) != count or len(set(suffixes)) < count:
        items["names"].refuse(f"{len(suffixes)} names of {count} copies", f"write {count} different names")
    return suffixes


def _geared(entry: Entry, known: set[str], suffixes: Sequence[str], ratio: float) -> dict[str, tuple[str, float]]:
    gears: dict[str, tuple[str, float]] = {}
    for name in entry.names("the pins whose shafts are geared together"):
        if name not in known:
            entry.refuse(f"{name} is not copied{suggestion(name, known)}", f"name some of {', '.join(sorted(known))}")
        gears |= {f"{name}{suffix}": (f"{name}{suffixes[0]}", ratio) for suffix in suffixes[1:]}
    return gears
