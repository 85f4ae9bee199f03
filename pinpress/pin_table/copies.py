"""Links that a press has several times: side by side or as mirror images. Other links carry all copies of their pins."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..common.errors import suggestion
from ..common.quantities import Array
from .formulas import number
from .links import Link, axes_along
from .placement import AXES, Pin
from .reading import Entry

KEYS = ("links", "x", "y", "z", "mirror", "names", "gear", "note")


@dataclass(frozen=True, eq=False)
class Parts:
    """Pins, links, drives and gears of a press in its drawn pose (the pose that the table draws).

    Attributes:
        pins: by their names.
        links: in the table's order.
        frame: names of the pins in the frame.
        drivers: names of the driven pins and guides.
        gears: name of a geared pin or guide -> (name of the pin or guide that it follows, ratio of its motion to that one's).
    """

    pins: Mapping[str, Pin]
    links: tuple[Link, ...]
    frame: tuple[str, ...]
    drivers: tuple[str, ...]
    gears: Mapping[str, tuple[str, float]]


def copied(parts: Parts, entry: Entry, parameters: Mapping[str, float], unit: float) -> Parts:
    """Copy links according to one entry of ``copies``.

    Raises:
        PinTableError: the entry has a wrong key or value, or names a link that cannot be copied.
    """
    items = entry.known(KEYS, "copies")
    named = _named(parts, entry, items)
    moves, mirrored = _moves(entry, items, parameters, unit)
    suffixes = _suffixes(entry, items, len(moves))
    chosen = [link for link in parts.links if link.name in named]
    own = {name for link in chosen for name in link.pins}
    guides = {link.guide.name for link in chosen if link.guide is not None}
    for link in parts.links:
        if link.name not in named and link.guide is not None and link.guide.carrier in named:
            entry.refuse(f"{link.name} slides in {link.guide.carrier}, which is copied", f"copy {link.name} too")
    copying = _Copying(named, own, guides, suffixes)
    pins = dict(_copied_pins(parts.pins, own, moves, suffixes))
    links = [each for link in parts.links for each in copying.link(link, moves)]
    gears = {new: follows for name, follows in parts.gears.items() for new, follows in copying.gears(name, follows)}
    if "gear" in items:
        gears |= _geared(items["gear"], own | guides, suffixes, -1.0 if mirrored else 1.0)
    frame = tuple(each for name in parts.frame for each in copying.names(name, own))
    drivers = tuple(f"{name}{suffixes[0]}" if name in own | guides else name for name in parts.drivers)
    return Parts(pins, tuple(links), frame, drivers, gears)


@dataclass(frozen=True)
class _Copying:
    named: Sequence[str]
    own: set[str]
    guides: set[str]
    suffixes: Sequence[str]

    def names(self, name: str, among: set[str]) -> list[str]:
        """All copies of a name, or the name itself if it has no copies."""
        return [f"{name}{suffix}" for suffix in self.suffixes] if name in among else [name]

    def link(self, link: Link, moves: Sequence[_Move]) -> list[Link]:
        """All copies of a link. A link without copies returns alone, with all copies of its pins."""
        if link.name not in self.named:
            return [replace(link, pins=tuple(each for name in link.pins for each in self.names(name, self.own)))]
        return [self._copy(link, move, suffix) for move, suffix in zip(moves, self.suffixes, strict=True)]

    def _copy(self, link: Link, move: _Move, suffix: str) -> Link:
        guide = link.guide
        if guide is not None:
            carrier = guide.carrier + suffix if guide.carrier in self.named else guide.carrier
            ends = {name + suffix: move(point) for name, point in guide.ends.items()}
            guide = replace(guide, name=guide.name + suffix, carrier=carrier, direction=move.turn @ guide.direction, ends=ends)
        still = np.array_equal(move.turn, np.eye(3)) or np.array_equal(link.rotation, np.eye(3))
        rotation = link.rotation if still else axes_along(move.turn @ link.rotation[:, 0])
        return replace(
            link,
            name=link.name + suffix,
            pins=tuple(name + suffix for name in link.pins),
            guide=guide,
            centre=move(link.centre),
            inertia=move.turn @ link.inertia @ move.turn.T,
            origin=move(link.origin),
            rotation=rotation,
        )

    def gears(self, name: str, follows: tuple[str, float]) -> list[tuple[str, tuple[str, float]]]:
        """The gear pairs of all copies of a pin or guide."""
        among, (leader, ratio) = self.own | self.guides, follows
        if name not in among:
            return [(name, (self.names(leader, among)[0], ratio))]
        return [(f"{name}{suffix}", (f"{leader}{suffix}" if leader in among else leader, ratio)) for suffix in self.suffixes]


@dataclass(frozen=True, eq=False)
class _Move:
    """From a link to its copy: first ``turn`` (3, 3), a reflection or the unit matrix, then a shift (3,) [m]."""

    turn: Array
    shift: Array

    def __call__(self, point: Array) -> Array:
        return self.turn @ point + self.shift


def _named(parts: Parts, entry: Entry, items: Mapping[str, Entry]) -> list[str]:
    if "links" not in items:
        entry.refuse("no links", "name the links that are copied: links: rod")
    names, known = items["links"].names("names of links"), [link.name for link in parts.links]
    for name in names:
        if name not in known:
            items["links"].refuse(f"no link {name}{suggestion(name, known)}", f"name some of {', '.join(known)}")
    return names


def _moves(entry: Entry, items: Mapping[str, Entry], parameters: Mapping[str, float], unit: float) -> tuple[list[_Move], bool]:
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
    places = [number(each, parameters) * unit for each in items[way].list(f"places: {way}: [-300, 300]")]
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


def _copied_pins(pins: Mapping[str, Pin], own: set[str], moves: Sequence[_Move], suffixes: Sequence[str]) -> Iterator[tuple[str, Pin]]:
    for name, pin in pins.items():
        if name not in own:
            yield name, pin
        for move, suffix in zip(moves, suffixes, strict=True):
            if name in own:
                # A mirror image turns about the mirrored axis the other way, as gears between mirrored shafts require.
                axis = None if pin.axis is None else move.turn @ pin.axis
                yield f"{name}{suffix}", replace(pin, name=f"{name}{suffix}", point=move(pin.point), axis=axis, other=None)


def _geared(entry: Entry, known: set[str], suffixes: Sequence[str], ratio: float) -> dict[str, tuple[str, float]]:
    gears: dict[str, tuple[str, float]] = {}
    for name in entry.names("the pins whose shafts are geared together"):
        if name not in known:
            entry.refuse(f"{name} is not copied{suggestion(name, known)}", f"name some of {', '.join(sorted(known))}")
        gears |= {f"{name}{suffix}": (f"{name}{suffixes[0]}", ratio) for suffix in suffixes[1:]}
    return gears
