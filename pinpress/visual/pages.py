"""Self-contained web pages: templates, styles and scripts put together into one file.

A page is filled with text of ours, JSON in which no tag can begin, or text whose ``<`` and ``&`` are escaped: a link called ``<script>``
stays text.
"""

import base64
import html
import importlib.resources
import importlib.util
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..common.errors import PinpressError
from ..common.quantities import Array

NO_MESHCAT = "recordings need Meshcat, which is not installed; pip install 'pinpress[recording]'"
NO_PLOTLY = "reports need Plotly, which is not installed; pip install 'pinpress[report]'"


def page(template: str, title: str, data: Mapping[str, Any], scripts: dict[str, str]) -> bytes:
    """Make a page from the files of `templates/`; every ``{{name}}`` is replaced once.

    Args:
        template: name of an HTML file; ``{{file.css}}`` and ``{{file.js}}`` in it are files beside it.
        title: any text.
        data: data for the page's own scripts, written as JSON.
        scripts: text of libraries by name, see `as_script` and `as_text`.

    Raises:
        PinpressError: a number of the data is not finite.
    """
    folder = importlib.resources.files(__package__) / "templates"
    fields = {"title": html.escape(title), "data": _as_json(data).replace("<", "\\u003c")}

    whole = re.sub(r"\{\{(\w+\.\w+)\}\}", lambda match: (folder / match[1]).read_text("utf-8"), (folder / template).read_text("utf-8"))
    # in one pass, as the filled-in text must not be searched
    return re.sub(r"\{\{(\w+)\}\}", lambda match: (scripts | fields)[match[1]], whole).encode()


def _as_json(data: Mapping[str, Any]) -> str:
    """Data as JSON. Raises PinpressError where a number is not finite."""
    parts = []
    for name, value in data.items():
        try:
            parts.append(f"{json.dumps(name)}:{json.dumps(value, separators=(',', ':'), allow_nan=False)}")
        except ValueError as error:
            raise PinpressError(f"the page cannot show the {name}: a value of it is not finite") from error
    return "{" + ",".join(parts) + "}"


def meshcat() -> dict[str, str]:
    """Meshcat's viewer and its licences.

    Raises:
        PinpressError: it is not installed.
    """
    root = _package("meshcat", NO_MESHCAT) / "viewer"
    licences = "\n".join((root / name).read_text("utf-8") for name in ("LICENSE", "dist/main.min.js.LICENSE.txt"))
    return {"viewer": as_script((root / "dist/main.min.js").read_text("utf-8")), "licences": as_text(licences)}


def plotly() -> dict[str, str]:
    """Plotly's charts; the licence stands at the head of the script.

    Raises:
        PinpressError: it is not installed.
    """
    root = _package("plotly", NO_PLOTLY)
    return {"plotly": as_script((root / "package_data/plotly.min.js").read_text("utf-8"))}


def _package(name: str, missing: str) -> Path:
    """The folder of a package, which is not imported: Meshcat would start a web server, Plotly import much else."""
    spec = importlib.util.find_spec(name)
    if spec is None or not spec.submodule_search_locations:
        raise PinpressError(missing)
    return Path(spec.submodule_search_locations[0])


def as_script(script: str) -> str:
    """A script with the tags escaped that would end its element."""
    return re.sub(r"<(?=/script|!--)", r"\\x3c", script, flags=re.IGNORECASE)


def as_text(text: str) -> str:
    """Text escaped for HTML."""
    return html.escape(text, quote=False)


def packed(values: Array, what: str) -> str:
    """Encode numbers in C order as little-endian 32-bit floats in base64.

    Args:
        values: numbers of any shape.
        what: their name in messages.

    Raises:
        PinpressError: a number is not finite, or too large.
    """
    with np.errstate(over="ignore"):
        short = np.ascontiguousarray(values, dtype="<f4")
    if not np.isfinite(short).all():
        raise PinpressError(f"{what} is not finite, or too large to be drawn; give a motion and reactions that this library returned")
    return base64.b64encode(short.tobytes()).decode("ascii")
