"""What stands in the sections of a job, and its press."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..common.errors import PinpressError, suggestion
from ..common.reading.entries import Entry
from ..common.reading.filling import Around, Named, Number
from ..kinematics.slide_path import dead_centres
from ..linkage.formats.free_bodies import Base
from ..linkage.linkage import Linkage
from ..linkage.loading import load
from ..pin_table.building import DrawnPress
from .bearings import turns
from .grammar import ALL
from .sources import Source

ZEROS = {"tdc": "top dead centre", "bdc": "bottom dead centre"}


def read_value(value: Any, entry: Entry, around: Around, refuse: Callable[[PinpressError], Any]) -> Any:
    """What stands in a section; of a section with names every wrong entry is refused."""
    if not isinstance(value, Named):
        return value.read(entry, around)
    read = {}
    for name, each in entry.items(value.example).items():
        try:
            read[name] = value.each.read(each, around)
        except PinpressError as error:
            refuse(error)
    return read


def base_of(made: Mapping[str, Any]) -> Base:
    """What free joints of the file do, as an argument of `load`."""
    return "floating" if made.get("floating") else "fixed"


def press_of(found: Source, made: Mapping[str, Any], drawn: DrawnPress | None) -> Linkage:
    if made.get("gravity", 0.0) < 0:  # a press under upward gravity is not meant
        found.items["gravity"].refuse("it counts downwards, and is negative", "write gravity: 9.81 m/s2")
    gravity, slide = (0.0, 0.0, -made.get("gravity", 9.81)), made.get("slide")
    if drawn is not None:
        for name in ("drivers", "floating", "pose"):
            if name in found.items:
                found.items[name].refuse("it is for a press of a file", "leave it out: a table of pins has its drive")
        return drawn.press(gravity, slide=slide)
    for name in ("pins", "links"):
        if name in found.items:
            found.items[name].refuse("the press is that of file", "leave out one of them")
    press = load(found.model, made.get("drivers"), slide, gravity, base=base_of(made), pose=made.get("pose"))
    for name, each in found.items["pose"].items("poses").items() if "pose" in made else ():
        Number("rad" if turns(press, name) else "m").read(each, Around())  # one or the other was read before the press was known
    return press


def counted_from(press: Linkage, zero: str) -> Linkage:
    """The press with crank angles counted from one of its dead centres."""
    if zero == "drawn":
        return press
    press.refuse_several_drivers("their angles are 0 in the drawn pose; leave out zero")
    press.refuse_sliding_driver("its positions are 0 in the drawn pose; leave out zero")
    ends = dead_centres(press)
    return press.drawn_at(ends.top_angle if zero == "tdc" else ends.bottom_angle, ZEROS[zero])


def check_names(section: str, entry: Entry, read: Any, press: Linkage) -> None:
    """Refuse names of links and bearings that the press does not have, and units of the other kind of bearing, where they stand."""
    if section == "bearings":
        for name, each in entry.items("bearings").items():
            if name != ALL and name not in press.bearings:
                known = (*press.bearings, ALL)
                each.refuse(f"no bearing {name}{suggestion(name, known)}", f"name one of {', '.join(press.bearings)}, or {ALL}")
            if name in press.bearings and isinstance(each.value, Mapping) and "viscous" in each.value:
                Number("N m s/rad" if turns(press, name) else "N s/m").read(each.value["viscous"], Around())
    elif section == "loads":
        links = press.links
        for each in entry.items("loads").values():
            if isinstance(each.value, Mapping):
                for key in ("link", "link1", "link2"):
                    if key in each.value and (name := each.value[key].text("a link")) not in links:
                        each.value[key].refuse(f"no link {name!r}{suggestion(name, links)}", f"name one of {', '.join(links)}")
