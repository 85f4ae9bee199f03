"""Presses with cams, as tables: an ejector in a guide, a feeder on an arm, and a blank holder beside a crank-slide."""

from functools import cache

import numpy as np

import pinpress as pp

EJECTOR = {
    "press": "ejector",
    "units": "mm",
    "frame": "O",
    "pins": {"O": [0, 0], "E": [10, "sqrt(80**2 - 10**2)"]},
    "links": {"camshaft": {"pins": "O", "mass": 20, "inertia": 0.5}, "ejector": {"pins": "E", "guide": "up", "mass": 25}},
    "drive": "O",
    "cams": {
        "eject": {
            "cam": "camshaft",
            "follower": "ejector",
            "radius": 80,
            "offset": 10,
            "roller": "40 x 30",
            "law": [[0, 0], {"3-4-5": [90, 40]}, [180, 40], {"3-4-5": [290, 0]}],
        }
    },
}
FEEDER = {
    "press": "feeder",
    "units": "mm",
    "frame": "O B",
    "pins": {"O": [0, 0], "B": [150, 0], "R": {"B": 120, "O": 70, "side": "up"}},
    "links": {"camshaft": {"pins": "O", "mass": 20, "inertia": 0.5}, "arm": {"pins": "B R", "mass": 10, "com": [0, 0], "inertia": 0.8}},
    "drive": "O",
    "cams": {
        "feed": {
            "cam": "camshaft",
            "follower": "arm",
            "radius": 70,
            "at": "R",
            "roller": "40 x 30",
            "kind": "groove",
            "law": [[0, 0], {"3-4-5": [100, 15]}, [180, 15], {"3-4-5": [300, 0]}],
        }
    },
}
BLANK_HOLDER = {
    "press": "drawing_press",
    "units": "mm",
    "frame": "O",
    "pins": {"O": [0, 0], "P": [0, -100], "W": [0, -500], "H": [0, -160]},
    "links": {
        "crank": {"pins": "O P", "mass": 30, "inertia": 0.4},
        "rod": {"pins": "P W", "mass": 20},
        "slide": {"pins": "W", "guide": "up", "mass": 100},
        "holder": {"pins": "H", "guide": "down", "mass": 60},
    },
    "drive": "O",
    "cams": {
        "hold": {
            "cam": "crank",
            "follower": "holder",
            "radius": 160,
            "at": "H",
            "drawn_at": 180,
            "roller": "50 x 40",
            "kind": "groove",
            "law": [[0, -60], [50, -60], {"modified sine": [145, 0]}, [205, 0], {"modified sine": [300, -60]}],
        }
    },
}
SPRING = pp.loads.SpringDamper("frame", "ejector", 20e3, 0.0, 0.26, (0.01, 0.0, 0.22 + np.sqrt(0.0063)))
"""On the ejector, preloaded by 800 N."""

TABLES = {"ejector": EJECTOR, "feeder": FEEDER, "drawing_press": BLANK_HOLDER}


@cache
def press(name):
    """The press of a table."""
    slide = {"slide": "slide"} if name == "drawing_press" else {}
    return pp.build(**TABLES[name], **slide)
