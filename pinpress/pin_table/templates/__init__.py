"""Templates of pin tables, one file for each kind of press."""

from importlib.resources import files

TEMPLATES = (
    "crank-slide",
    "knuckle",
    "link-drive",
    "drawing-8-bar",
    "eccentric-block",
    "guide-bar",
    "toggle",
    "hypocycloid",
    "screw",
    "rssp",
)


def template(name: str) -> bytes:
    """Read the text of a template, one of `TEMPLATES`."""
    return (files(__name__) / f"{name}.yaml").read_bytes()
