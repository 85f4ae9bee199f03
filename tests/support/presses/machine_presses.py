"""Small presses with a machine element each, without losses, and the same with losses in teeth and threads."""

from functools import cache

import pinpress as pp

CRANK = {
    "crank": {"pins": "O A", "mass": 20.0, "com": [0, 40], "inertia": 0.2},
    "rod": {"pins": "A B", "mass": 30.0},
    "slide": {"pins": "B", "guide": "up", "mass": 100.0},
}
PINS = {"O": [0, 0], "A": [60, 80], "B": [0, -300]}


def turning(link, pin, mass, inertia):
    return {link: {"pins": pin, "mass": mass, "com": pin, "inertia": inertia}}


@cache
def geared(efficiency=1.0):
    """A crank-slider whose crank is a wheel that a pinion on the frame drives."""
    return _geared(meshes={"teeth": {"gears": "pinion crank", "teeth": "20 100", "efficiency": efficiency}})


@cache
def of_ratio():
    """The same with the ratio alone, whose forces are none of teeth."""
    return _geared(gears={"O": "-0.2 * Q"})


def _geared(**coupled):
    pins, links = {**PINS, "Q": [-600, 0]}, {**turning("pinion", "Q", 30.0, 0.15), **CRANK}
    return pp.build(units="mm", frame="O Q", pins=pins, links=links, **coupled, drive="Q", press="geared")


@cache
def planetary(efficiency=1.0):
    """A crank-slider whose crank is the carrier of a planetary stage; its sun drives."""
    links = {**turning("sun", "O", 10.0, 0.05), **turning("planet", "P", 12.0, 0.14), **CRANK}
    links["crank"] = {**CRANK["crank"], "pins": "O A P"}
    losses = {"planets": 4, "efficiency": efficiency}
    return pp.build(
        units="mm",
        frame="O",
        pins={**PINS, "P": [250, 0]},
        links=links,
        meshes={
            "inner": {"gears": "sun planet", "teeth": "20 30", "carrier": "crank", **losses},
            "outer": {"gears": "planet frame", "teeth": "30 -80", "carrier": "crank", "at": "O", **losses},
        },
        drive="O",
        press="planetary",
    )


@cache
def arbor(efficiency=1.0):
    """An arbor press: a shaft with a pinion moves a rack."""
    return pp.build(
        units="mm",
        frame="O",
        pins={"O": [0, 0], "Q": [24, 0]},
        links={**turning("shaft", "O", 2.0, 0.01), "slide": {"pins": "Q", "guide": "up", "mass": 8.0}},
        racks={"rack": {"pinion": "shaft", "rack": "slide", "radius": "24mm", "pressure_angle": 20, "efficiency": efficiency}},
        drive="O",
        press="arbor",
    )


LEAD = 0.2


@cache
def spindle(friction=0.0, lead=LEAD):
    """A screw press: a flywheel on a spindle whose nut is the slide, which falls where the flywheel turns positively."""
    return jack(450.0, lead, 0.3, friction)


@cache
def jack(mass, lead, diameter, friction):
    """A screw that lowers a slide of this mass where it turns positively."""
    return pp.build(
        units="mm",
        frame="S",
        pins={"S": {"x": 0, "y": 0, "z": 0, "axis": "z"}, "N": {"x": 0, "y": 0, "z": -500, "axis": "z"}},
        links={
            "flywheel": {"pins": "S", "mass": 300, "com": "S", "inertia": [15, 15, 25]},
            "slide": {"pins": "N", "guide": "up", "mass": mass},
        },
        screws={"thread": {"screw": "flywheel", "nut": "slide", "lead": 1e3 * lead, "diameter": 1e3 * diameter, "friction": friction}},
        drive="S",
        press="spindle",
    )


PRESSES = (geared, planetary, arbor, spindle)
