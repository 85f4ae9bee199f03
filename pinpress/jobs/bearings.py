"""What a job says of bearings and guides, by their names and of all: friction, springs, clearances."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any

from ..common.errors import PinpressError
from ..linkage.linkage import Linkage
from ..loads.link import Friction
from ..pin_table.building import DrawnPress
from ..pin_table.rod_sections import rods
from ..ratings.eccentric_loads import Gibs
from ..ratings.pin_use import PlainBearing, RollingBearing
from ..simulation.elastic.contact import Clearance
from ..simulation.elastic.description import Elastic, Rod, Stiffness
from ..simulation.elastic.yielding import bearings_of_link
from .grammar import ALL
from .kinds import Bearing

OF_PINS = ("radius", "diameter", "width", "clearance", "pressure", "wear_rate", "rolling")  # of which `all` says nothing to guides
OF_GUIDES = ("length", "middle")
OF_FRICTION = ("friction", "viscous", "preload")


def bearings_of(press: Linkage, given: Mapping[str, Bearing]) -> Mapping[str, Bearing]:
    """Each bearing and guide of which something is said, with what is said of all.

    Raises:
        PinpressError: what is said of all has another unit or no meaning at some of them.
    """
    every = given.get(ALL, Bearing()) if ALL not in press.bearings else Bearing()
    for name, what in (("viscous", "has another unit in a guide than in a pin"), ("preload", "is the force of a guide's gibs")):
        if getattr(every, name) is not None:
            raise PinpressError(f"{ALL}: {name} {what}: write it at each bearing by its name")
    for name, each in given.items():
        if name in press.bearings:
            _refuse_unfit_sizes(name, each, turns(press, name))
    found = {name: _over(every, given.get(name, Bearing()), _unfit(press, name)) for name in press.bearings}
    return {name: each for name, each in found.items() if each != Bearing()}


def _over(every: Bearing, own: Bearing, unfit: tuple[str, ...]) -> Bearing:
    """A bearing with what is said of all where it says nothing of its own."""
    said = {each.name: getattr(every, each.name) for each in fields(Bearing) if each.name not in unfit}
    if own.joint is not None or own.stiffness is not None:  # one stands in place of the other
        said["joint"] = said["stiffness"] = None
    return replace(own, **{name: value for name, value in said.items() if value is not None and getattr(own, name) is None})


def _unfit(press: Linkage, name: str) -> tuple[str, ...]:
    """What is said of all and does not hold of this bearing."""
    unfit: tuple[str, ...] = OF_GUIDES if turns(press, name) else OF_PINS
    unfit += () if name not in _welded(press) else OF_FRICTION
    return unfit if name in _held_against_turning(press) else (*unfit, "moment_stiffness")


def _refuse_unfit_sizes(name: str, given: Bearing, turning: bool) -> None:
    """Refuse sizes of a pin at a guide, those of a guide at a pin, and a guide of which only length or only width is given."""
    for key in OF_GUIDES if turning else ("diameter", "rolling"):
        if getattr(given, key) is not None:
            right = "is a pin: write diameter: 80 mm, width: 80 mm" if turning else "is a guide: write length: 400 mm, width: 120 mm"
            raise PinpressError(f"{name}: {key}, but {name} {right}")
    if not turning and (given.length is None) != (given.width is None):
        lacking = "length: 400 mm" if given.length is None else "width: 120 mm"
        raise PinpressError(f"{name}: the pressure on a guide needs its length and its width; add {lacking}")


def turns(press: Linkage, name: str) -> bool:
    """Whether a bearing turns, rather than slide as a guide."""
    return name not in press.joints or press.axes[press.joints.index(name)].turns


def _welded(press: Linkage) -> set[str]:
    return {loop.name for loop in press.loops if loop.type == "fixed"}


def _held_against_turning(press: Linkage) -> list[str]:
    """Bearings with a stiffness against turning: guides, and in space all that are no balls."""
    if "plane" in press.engines:
        return [name for name, axis in zip(press.joints, press.axes, strict=True) if not axis.turns]
    balls = {loop.name for loop in press.loops if loop.type == "spherical"}
    return [name for name in press.bearings if name not in balls]


def frictions_of(press: Linkage, bearings: Mapping[str, Bearing]) -> Mapping[str, Friction]:
    """Friction of the bearings that have some; its radius is half of the diameter where none is given.

    Raises:
        PinpressError: a bearing that turns has friction and no radius.
    """
    found, lacking = {}, []
    for name, each in bearings.items():
        if all(getattr(each, part) is None for part in OF_FRICTION):
            continue
        radius = each.radius if each.radius is not None or each.diameter is None else 0.5 * each.diameter
        if each.friction and radius is None and turns(press, name):
            lacking.append(name)
        found[name] = Friction(each.friction or 0.0, radius, each.viscous or 0.0, each.preload or 0.0)
    if lacking:
        turn = "turns" if len(lacking) == 1 else "turn"
        raise PinpressError(f"friction of {', '.join(lacking)}, which {turn}, without a radius; add diameter: 120 mm, or radius: 60 mm")
    return found


def pins_of(press: Linkage, bearings: Mapping[str, Bearing]) -> Mapping[str, PlainBearing | RollingBearing | Gibs]:
    """The bearings to rate: those that roll, all other pins with diameter and width, and guides with length and width."""
    unfit = _welded(press) | {loop.name for loop in press.loops if loop.type == "spherical" and "plane" not in press.engines}
    found: dict[str, PlainBearing | RollingBearing | Gibs] = {}
    for name, each in bearings.items():
        if each.rolling is not None:
            found[name] = each.rolling
        elif each.diameter is not None and each.width is not None and turns(press, name) and name not in unfit:
            found[name] = PlainBearing(each.diameter, each.width, each.pressure, each.wear_rate)
        elif each.length is not None and each.width is not None:
            found[name] = Gibs(each.length, each.width, middle=each.middle or 0.0, pressure=each.pressure, wear_rate=each.wear_rate)
    return found


def clearances_of(bearings: Mapping[str, Bearing]) -> Mapping[str, float]:
    """Radial clearances of the bearings that have some [m]."""
    return {name: each.clearance.radial for name, each in bearings.items() if isinstance(each.clearance, Clearance)}


def stiffness_of(press: Linkage, drawn: DrawnPress | None, bearings: Mapping[str, Bearing], elastic: Mapping[str, Any]) -> Stiffness:
    """Stiffnesses of the bearings and guides that have some, of rods, shaft and columns.

    Raises:
        PinpressError: a rod is none, or its section is not of steel and there is no modulus.
    """
    across = {name: each.joint if each.joint is not None else each.stiffness for name, each in bearings.items()}
    turning = {name: each.moment_stiffness for name, each in bearings.items() if each.moment_stiffness is not None}
    known = {name: value for name, value in across.items() if value is not None}
    stretching = _rods(press, drawn, elastic.get("modulus"), elastic.get("rods", {}))
    return Stiffness(known, turning, stretching, elastic.get("shaft"), elastic.get("frame"))


def _rods(press: Linkage, drawn: DrawnPress | None, modulus: float | None, given: Mapping[str, float | None]) -> list[Rod]:
    """The rods with a section in the table, and those whose stiffness is given in place of it."""
    if drawn is None and modulus is not None:
        raise PinpressError("modulus is of the sections of a table of pins: leave it out, and write rods: {rod: 7 GN/m}")
    found = {} if drawn is None else {rod.link: rod for rod in rods(drawn, modulus=modulus)}
    for link, value in given.items():
        _, ends = bearings_of_link(press, link)
        if value is None:
            found.pop(link, None)
        elif len(ends) == 2:
            one, other = (press.bearings[k] for k in ends)
            found[link] = Rod(link, (one, other), value)
        else:
            raise PinpressError(f"rods: {link} has {len(ends)} bearings, and a rod has two: leave it out")
    return list(found.values())


def elastic_of(
    press: Linkage,
    drawn: DrawnPress | None,
    bearings: Mapping[str, Bearing],
    elastic: Mapping[str, Any],
    frame: Callable[[], Mapping[str, Any]],
) -> Elastic:
    """The press on springs.

    Args:
        press: the press.
        drawn: the press as its table draws it; None if it comes from another file.
        bearings: what is said of its bearings.
        elastic: damping ratio, shaft, columns and crown of the section ``elastic``.
        frame: gives the frame on its mounts, as arguments of `Elastic`.

    Raises:
        PinpressError: a bearing has no stiffness, or a guide none against turning.
    """
    stiffness = stiffness_of(press, drawn, bearings, elastic)
    for names, known, key in (
        (press.bearings, stiffness.bearings, "stiffness: 2 GN/m"),
        (_held_against_turning(press), stiffness.moments, "moment_stiffness: 200 MN m/rad"),
    ):
        missing = [name for name in names if name not in known]
        if missing:
            what = key.partition(":")[0]
            raise PinpressError(
                f"{', '.join(missing)} {'has' if len(missing) == 1 else 'have'} no {what}, and in an elastic motion all are elastic;"
                f" write {key} at {ALL} or at each of them"
            )
    given = {name: elastic[name] for name in ("damping_ratio", "crown_mass") if name in elastic}
    clearances = {name: each.clearance for name, each in bearings.items() if each.clearance is not None}
    return Elastic(stiffness, clearances=clearances, **given, **frame())
