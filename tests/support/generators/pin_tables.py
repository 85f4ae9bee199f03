"""Pin tables of a crank-slide and of a four-bar, to be changed and built."""

from typing import Any

FOUR_BAR: dict[str, Any] = {  # in any unit
    "frame": "A D",
    "pins": {"A": [4.3, 3.9], "B": [1.4, 0.3], "C": [-2.1, -2.1], "D": [0.3, 1.4], "E": [-2.4, 1.8]},
    "links": {"ab": {"pins": "A B", "mass": 1}, "cbe": {"pins": "B C E", "mass": 1}, "dc": {"pins": "D C", "mass": 1}},
    "drive": "A",
}
MASSLESS: dict[str, Any] = {
    "crank": {"pins": "O P"},
    "rod": {"pins": "P W"},
    "slide": {"pins": "W", "guide": "up"},
}  # links of a crank-slide


def crank_slide(crank: float = 100, rod: float = 400, side: str = "down", **changes: Any) -> dict[str, Any]:
    """Keys of a table in mm whose crank points down as drawn; its masses are those of the shipped press of this name."""
    links = {
        "crank": {"pins": "O P", "mass": 20, "com": [30, 0], "inertia": 0.1},
        "rod": {"pins": "P W", "mass": 15},
        "slide": {"pins": "W", "guide": "up", "mass": 100},
    }
    pins = {"O": [0, 0], "P": {"from": "O", "length": crank, "angle": -90}, "W": {"P": rod, "x": 0, "side": side}}
    return {"units": "mm", "frame": "O", "pins": pins, "links": links, "drive": "O"} | changes


def with_link(name: str, **keys: Any) -> dict[str, Any]:
    """The crank-slide whose crank, rod or slide has its pins, its guide and these keys alone; any other name is a link more."""
    links = crank_slide()["links"]
    kept = {key: links[name][key] for key in ("pins", "guide") if key in links.get(name, {})}
    return crank_slide(links=links | {name: kept | keys})
