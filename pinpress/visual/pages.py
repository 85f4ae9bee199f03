"""Self-contained web pages: templates, styles and scripts put together into one file.

A page is filled with our templates, packed data, or text whose ``<`` and ``&`` are escaped: a link called ``<script>`` stays text.
"""

import base64
import functools
import hashlib
import html
import importlib.resources
import importlib.util
import itertools
import json
import os
import re
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..common import files
from ..common.errors import PinpressError
from ..common.quantities import Array
from . import languages, licences

FIELD = re.compile(r"\{\{(\w+)\}\}")
FILE = re.compile(r"\{\{(\w+\.\w+)\}\}")
PAGES = (".html", ".htm")  # other names do not open in a browser by double click
DIGITS = np.frombuffer(b"0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz!#$%&()*+-;<=>?@^_`{|}~", np.uint8)  # of base 85
NO_MESHCAT = "recordings need Meshcat, which is not installed; pip install 'pinpress[recording]'"
NO_PLOTLY = "reports need Plotly, which is not installed; pip install 'pinpress[report]'"


@dataclass(frozen=True)
class Library:
    """A script of another package, as pages contain it.

    Attributes:
        packed: the script, see `pack`.
        digest: digest of the script, its name in a page's security policy.
        licence: texts of its licence and of the licences of all packages in it.
    """

    packed: str
    digest: str
    licence: str


def page(template: str, title: str, data: Mapping[str, Any], libraries: Mapping[str, Library], language: str = "en") -> bytes:
    """Make a page from the files of `templates/`; every ``{{name}}`` is replaced once.

    Libraries, data and the template's own scripts of the class ``packed`` are compressed; ``unpack.js`` opens them in the browser. The
    page's security policy names the scripts by their digests, so no other script can run.

    Args:
        template: name of an HTML file; ``{{file.css}}``, ``{{file.js}}`` and ``{{file.html}}`` in it are files next to it.
        title: any text.
        data: data for the page's own scripts, written as JSON.
        libraries: libraries by their names in the template.
        language: of its texts, one of `languages.LANGUAGES`.

    Raises:
        PinpressError: a number of the data is not finite.
    """
    whole = _with_files(template)
    data = data if language == "en" else languages.language(language).of_page(data, whole)
    digests = [library.digest for library in libraries.values()]

    def finished(script: re.Match[str]) -> str:
        """A script of the template, packed if its class says so; a script that is filled in later stays as it is."""
        opening, text = script[1], script[2]
        if FIELD.fullmatch(text):
            return script[0]
        digests.append(_digest(text.encode()))
        return f"{opening}{pack(text.encode()) if 'packed' in opening else text}</script>"

    whole = re.sub(r"(<script[^>]*>)(.*?)</script>", finished, whole, flags=re.DOTALL)
    fields = {
        "title": html.escape(title),
        "language": language,
        "data": pack(_as_json(data).encode()),
        "digests": " ".join(digests),
        "licences": html.escape("\n\n".join(library.licence for library in libraries.values()), quote=False),
        **{name: library.packed for name, library in libraries.items()},
    }
    return FIELD.sub(lambda match: fields[match[1]], whole).encode()  # in one pass, because filled-in text must not be searched for fields


def write(path: str | os.PathLike[str], content: bytes) -> Path:
    """Write a page, and return its path.

    Raises:
        PinpressError: the name does not end in .html, or the file cannot be written.
    """
    suffix = Path(path).suffix.lower() if isinstance(path, str | os.PathLike) else ".html"  # other objects are refused below
    if suffix not in PAGES:
        then = {".pdf": ", and print that page", ".png": ", and take a picture of that page"}.get(suffix, "")
        raise PinpressError(f"{path} would be a web page: end its name in .html{then}")
    return files.write(path, content)


def _with_files(name: str) -> str:
    """The text of a file of `templates/`; each file that it names is inserted at its place."""
    text = (importlib.resources.files(__package__) / "templates" / name).read_text("utf-8")
    return FILE.sub(lambda match: _with_files(match[1]), text)


def _as_json(data: Mapping[str, Any]) -> str:
    """Data as JSON. Raises PinpressError if a number is not finite."""
    parts = []
    for name, value in data.items():
        try:
            parts.append(f"{json.dumps(name)}:{json.dumps(value, separators=(',', ':'), allow_nan=False)}")
        except ValueError as error:
            raise PinpressError(f"the page cannot show the {name}: a value of it is not finite") from error
    return "{" + ",".join(parts) + "}"


def meshcat() -> Library:
    """Meshcat's viewer.

    Raises:
        PinpressError: it is not installed.
    """
    script = meshcat_script()
    of_meshcat = (script.parents[1] / "LICENSE", script.with_name("main.min.js.LICENSE.txt"))
    parts = licences.together("Meshcat's viewer holds parts of others:", licences.of_meshcat(script))
    return _library(script, "\n".join([*(path.read_text("utf-8") for path in of_meshcat), parts]))


def meshcat_script() -> Path:
    """The file of Meshcat's viewer; raises PinpressError if Meshcat is not installed."""
    return _package("meshcat", NO_MESHCAT) / "viewer/dist/main.min.js"


def plotly() -> Library:
    """Plotly's charts.

    Raises:
        PinpressError: it is not installed.
    """
    head = plotly_head()
    parts = licences.together("plotly.js holds parts of others:", licences.of_plotly(licences.plotly_version(head)))
    return _library(plotly_script(), f"{head}\n{parts}")


def plotly_script() -> Path:
    """The file of Plotly's charts; raises PinpressError if Plotly is not installed."""
    return _package("plotly", NO_PLOTLY) / "package_data/plotly.min.js"


def plotly_head() -> str:
    """The comment in front of Plotly's charts, with version and licence; raises PinpressError if Plotly is not installed."""
    with plotly_script().open(encoding="utf-8") as lines:
        return "".join(itertools.takewhile(lambda line: "*/" not in line, lines))


def _package(name: str, missing: str) -> Path:
    """The folder of a package. The package is not imported: Meshcat would start a web server, and Plotly would import many modules."""
    spec = importlib.util.find_spec(name)
    if spec is None or not spec.submodule_search_locations:
        raise PinpressError(missing)
    return Path(spec.submodule_search_locations[0])


@functools.cache
def _library(script: Path, licence: str) -> Library:
    text = script.read_bytes()
    return Library(pack(text), _digest(text), licence)


def _digest(script: bytes) -> str:
    """The name of a script in a page's security policy."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'"


def pack(content: bytes) -> str:
    """Compress bytes and write them in base 85 (RFC 1924), which takes 6 % less than base 64. `unpack.js` opens them."""
    compressed = zlib.compress(content, 5)  # the next level takes a third longer, for 0.7 % less
    missing = -len(compressed) % 4
    words = np.frombuffer(compressed + bytes(missing), ">u4").astype(np.uint32)
    digits = np.empty((len(words), 5), np.uint8)
    for place in range(4, -1, -1):  # base64.b85encode takes 0.3 s for Plotly, this 0.01 s
        words, digits[:, place] = np.divmod(words, np.uint32(85))
    return DIGITS[digits].tobytes()[: -missing or None].decode("ascii")


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
