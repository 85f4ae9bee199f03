"""Pin tables with gears, racks and screws, without losses but for friction in the thread of the screw."""

from typing import Any

from support.generators.pin_tables import crank_slide

# A crank-slide whose crank has a wheel, which a pinion drives.
GEARED: dict[str, Any] = crank_slide(frame="O Q") | {
    "pins": crank_slide()["pins"] | {"Q": [-600, 0]},
    "links": crank_slide()["links"] | {"pinion": {"pins": "Q", "mass": 2}},
    "drive": "Q",
}
TEETH = {"gears": "pinion crank", "teeth": "20 100"}
# A lever gear: the ring turns the planet, which is welded to the rod. Its carrier is the crank.
LEVER_GEAR: dict[str, Any] = {
    "units": "mm",
    "frame": "A A1",
    "pins": {"A": [0, 0], "A1": "A", "B": [60, 0], "C": {"B": 240, "z": 0, "side": "right"}},
    "links": {
        "crank": {"pins": "A B", "mass": 2, "com": [30, 0], "inertia": 0.0006},
        "ring": {"pins": "A1", "mass": 8, "inertia": 0.0576},
        "rod": {"pins": "B C", "mass": 3, "com": [120, 0], "inertia": 0.0144},
        "slide": {"pins": "C", "guide": "right", "mass": 5},
    },
    "drive": "A1",
    "meshes": {"teeth": {"gears": "ring rod", "teeth": "-40 20"}},
}
PLANETARY: dict[str, Any] = {
    "units": "mm",
    "frame": "S A",
    "pins": {"S": [0, 0], "A": "S", "P": [250, 0]},
    "links": {
        "sun": {"pins": "S", "mass": 10, "inertia": 0.05},
        "arm": {"pins": "A P", "mass": 40, "inertia": 0.8},
        "planet": {"pins": "P", "mass": 12, "inertia": 0.14},
    },
    "drive": "S",
    "meshes": {"sun_planet": {"gears": "sun planet", "teeth": [20, 30]}, "ring": {"gears": "planet frame", "teeth": "30 -80", "at": "A"}},
}
ARBOR: dict[str, Any] = {
    "units": "mm",
    "frame": "O",
    "pins": {"O": [-24, 0], "W": [0, 0]},
    "links": {"pinion": {"pins": "O", "mass": 1}, "slide": {"pins": "W", "guide": "up", "mass": 5}},
    "drive": "O",
    "racks": {"rack": {"pinion": "pinion", "rack": "slide", "radius": 24, "pressure_angle": 20, "side": "left"}},
}
SCREW: dict[str, Any] = {
    "units": "mm",
    "frame": "S",
    "pins": {"S": {"x": 0, "y": 0, "z": 0, "axis": "z"}, "Q": {"x": 0, "y": 0, "z": -200, "axis": "z"}},
    "links": {
        "flywheel": {"pins": "S", "mass": 300, "com": "S", "inertia": [15, 15, 25]},
        "slide": {"pins": "Q", "guide": "up", "mass": 450},
    },
    "drive": "S",
    "screws": {"spindle": {"screw": "flywheel", "nut": "slide", "lead": 200, "diameter": 300, "flank": 15, "friction": 0.06}},
}


def changed(table: dict[str, Any], section: str, name: str, **keys: Any) -> dict[str, Any]:
    """A table with other keys of a machine element; those that are None are left out."""
    element = table.get(section, {}).get(name, {}) | keys
    return table | {section: table.get(section, {}) | {name: {key: value for key, value in element.items() if value is not None}}}


def meshing(**keys: Any) -> dict[str, Any]:
    return changed(GEARED | {"meshes": {"teeth": TEETH}}, "meshes", "teeth", **keys)


MESHING = {
    "gears": meshing(),
    "lever gear": LEVER_GEAR,
    "planetary": PLANETARY,
    "rack": ARBOR,
    "screw": changed(SCREW, "screws", "spindle", friction=None),
}
WORM: dict[str, Any] = {
    "units": "mm",
    "frame": "O M",
    "pins": {"O": [0, 0], "M": {"x": 0, "y": 0, "z": -200, "axis": "x"}},
    "links": {"wheel": {"pins": "O", "mass": 10}, "shaft": {"pins": "M", "mass": 5, "inertia": [0.01, 0.01, 0.01]}},
    "drive": "M",
    "worms": {"worm": {"worm": "shaft", "wheel": "wheel", "starts": 2, "teeth": 40, "module": 8, "quotient": 10, "friction": 0.05}},
}
RUBBING = {  # with helices, losses and threads of both hands
    "gears": meshing(helix="15 left", efficiency=0.97, module=9.5),
    "lever gear": changed(LEVER_GEAR, "meshes", "teeth", helix=10, efficiency=0.985),
    "planets": {
        **PLANETARY,
        "meshes": {
            "sun_planet": {"gears": "planet sun", "teeth": [30, 20], "planets": 4, "efficiency": 0.99},
            "ring": {"gears": "planet frame", "teeth": "30 -80", "at": "A", "planets": 4, "efficiency": 0.985},
        },
    },
    "rack": changed(ARBOR, "racks", "rack", helix="20 left", efficiency=0.98, side=None),
    "screw": changed(SCREW, "screws", "spindle", collar_friction=0.1, collar_diameter=200, hand="left"),
    "worm": WORM,
}
