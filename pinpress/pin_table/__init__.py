"""Pin tables: presses as engineers draw them, with pins, links and masses, in a YAML file or a call.

    pins = {"O": [0, 0], "P": {"from": "O", "length": 100, "angle": -90}, "W": {"P": 400, "x": 0, "side": "down"}}
    links = {"crank": {"pins": "O P", "mass": 20}, "rod": {"pins": "P W", "mass": 15}, "slide": {"pins": "W", "guide": "up", "mass": 90}}
    drawn = pp.pin_table.draft(units="mm", frame="O", pins=pins, links=links, drive="O")
    print(drawn)  # the bearings; drawn.sketch is a picture (SVG), drawn.urdf a file for other programs
    press = drawn.press()  # at once: pp.build(units="mm", ...), or pp.build("press.yaml")

The manual has all keys of a table.
"""

from ..common.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
