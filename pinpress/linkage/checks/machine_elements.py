"""Problems of gears, racks, screws and worms that their elements show without the drawing."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator

from ...common.errors import suggestion
from ..description import MACHINE_ELEMENTS, Description, GearMesh, Rack, Screw, Worm
from ..element import Element
from .grammar import Problem

MM = {"module": 0.2, "radius": 2.0, "diameter": 5.0, "collar_diameter": 5.0, "lead": 1.0}
"""Lengths that no press has [m]: they are in millimetres."""
LEAST = 1e-6  # lengths below are as good as 0 [m]
MOST = 10_000  # teeth, starts and planets
STEEPEST = {"pressure_angle": 45.0, "helix": 60.0, "flank": 60.0}  # [deg]


def problems(robot: Element, description: Description) -> Iterator[Problem]:
    """Problems of all such elements, of each by itself and of two for the same links."""
    meshing: dict[frozenset[str], str] = {}
    for element, contents in zip(robot.all(*MACHINE_ELEMENTS), description.machine_elements, strict=True):
        links = tuple(element.get(name) for name in _LINKS[element.tag])
        yield from link_problems(element, links, description)
        yield from ((element, *problem) for problem in _number_problems(element))
        yield from ((element, *problem) for problem in itertools.chain(_word_problems(element), _PROBLEMS[type(contents)](contents)))
        bodies = frozenset(description.bodies.get(link, link) for link in links)
        if bodies in meshing:
            yield element, f"{links[0]!r} and {links[1]!r} mesh already, in {meshing[bodies]!r}", "remove one of the two"
        meshing.setdefault(bodies, element.get("name"))


_LINKS = {"gear_mesh": ("gear1", "gear2"), "rack": ("pinion", "rack"), "screw": ("screw", "nut"), "worm": ("worm", "wheel")}


def link_problems(element: Element, links: tuple[str, ...], description: Description) -> Iterator[Problem]:
    """Problems of the links that an element names: the two that touch, and their carrier."""
    carrier = element.get("carrier")
    for link in (*links, *([carrier] if carrier else [])):
        if link and link not in description.links:
            yield element, f"no link {link!r}{suggestion(link, description.links)}", "name a link of this press"
    bodies = [description.bodies.get(link) for link in links]
    if links[0] and links[0] == links[1]:
        yield element, f"both are link {links[0]!r}", "name two links"
    elif bodies[0] is not None and bodies[0] == bodies[1]:
        yield element, f"{links[0]!r} and {links[1]!r} are one body, welded together", "name two links that move against each other"
    if carrier and description.bodies.get(carrier, "") in bodies:
        problem = f"its carrier {carrier!r} is one of the two itself, or welded to it"
        yield element, problem, "name the link that holds both centres, or leave carrier out"


def _number_problems(element: Element) -> Iterator[tuple[str, str]]:
    for name, most in MM.items():
        value = element.number(name, 0.0)
        if value < 0.0 or 0.0 < value < LEAST:
            yield f"{name} is {value:g} m", "write a length above 0"
        elif value >= most:
            turn = " a turn" if name == "lead" else ""
            yield f"{name} is {value:g} m{turn}", f"a URDF has metres: {value / 1e3:g} for {value:g} mm"
    for name, most in STEEPEST.items():
        angle = element.number(name, 0.0)
        if 0.0 < angle < 1.0:
            yield f"{name} is {angle:g} deg, as if in radians", f"write degrees: {math.degrees(angle):.6g}"
        elif not 0.0 <= angle < most:
            yield f"{name} is {angle:g} deg", f"write degrees, from 0 to {most:g}; hand says the sense of a helix or thread"
    if not 0.0 < element.number("efficiency", 1.0) <= 1.0:
        yield f"efficiency is {element.number('efficiency', 1.0):g}", "write a share above 0, up to 1, such as 0.985"
    for name in ("friction", "collar_friction"):
        if not 0.0 <= element.number(name, 0.0) < 1.0:
            yield f"{name} is {element.number(name, 0.0):g}", "write a coefficient of friction from 0, such as 0.06"
    for name in ("teeth1", "teeth2", "teeth", "starts", "planets"):
        count = element.number(name, 1.0)
        if count != round(count) or count == 0.0:
            yield f"{_COUNTED.get(name, name)} is {count:g}", "write a whole number, and not 0"
        elif abs(count) > MOST:
            yield f"{_COUNTED.get(name, name)} is {count:g}", f"write how many there are, {MOST} at most"
        elif count < 0.0 and name not in _COUNTED:
            yield f"{name} is {count:g}", "write a number above 0"


_COUNTED = {"teeth1": "teeth of the first gear", "teeth2": "teeth of the second gear"}


def _word_problems(element: Element) -> Iterator[tuple[str, str]]:
    for name, words in (("hand", ("right", "left")), ("side", ("left", "right")), ("double_helical", ("true", "false"))):
        word = element.get(name)
        if word and word not in words:
            yield f"{name} is {word!r}{suggestion(word, words)}", f"write {name}: {' or '.join(words)}"


def _gears(gears: GearMesh) -> Iterator[tuple[str, str]]:
    if gears.teeth1 < 0 and gears.teeth2 < 0:
        yield "both gears are internal, with teeth below zero", "write one of the two numbers of teeth above zero"
    elif gears.teeth1 * gears.teeth2 < 0 and (ring := -min(gears.teeth1, gears.teeth2)) <= max(gears.teeth1, gears.teeth2):
        pinion = max(gears.teeth1, gears.teeth2)
        yield f"the internal gear has {ring:g} teeth, and the pinion in it {pinion:g}", "give the internal gear more teeth than its pinion"


def _rack(rack: Rack) -> Iterator[tuple[str, str]]:
    by_module = bool(rack.module and rack.teeth)
    if bool(rack.radius) == by_module or (rack.radius and (rack.module or rack.teeth)):
        yield "its pinion has no radius" if not rack.radius else "its radius is given twice", "give a radius, or else module and teeth"


def _screw(screw: Screw) -> Iterator[tuple[str, str]]:
    if not screw.lead:
        yield "its lead is 0", "write the travel in one turn"
    if screw.friction and not screw.diameter:
        yield "it has friction and no diameter", "give the mean diameter of the thread"
    if screw.collar_friction and not screw.collar_diameter:
        yield "its collar has friction and no diameter", "give collar_diameter, the mean diameter of the collar"


def _worm(worm: Worm) -> Iterator[tuple[str, str]]:
    if not worm.module and not worm.quotient:
        yield "neither its module nor its quotient is given", "give quotient, the pitch diameter of the worm by the module, or module"
    if worm.quotient and not 1.0 <= worm.quotient <= 1000.0:
        yield f"quotient is {worm.quotient:g}", "write the pitch diameter of the worm by the module, such as 10"


_PROBLEMS: dict[type, Callable[..., Iterator[tuple[str, str]]]] = {GearMesh: _gears, Rack: _rack, Screw: _screw, Worm: _worm}
