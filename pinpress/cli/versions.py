"""Versions and licences of pinpress, of the packages that it uses, and of software in its pages, as `pinpress --version` prints them."""

import platform
import re
import textwrap
from collections import defaultdict
from collections.abc import Iterator
from importlib import metadata

from ..common import tables
from ..common.errors import PinpressError
from ..visual import licences
from ..visual.pages import meshcat_script, plotly_head

ITSELF = "pinpress"
UNSTATED = "not stated"
MISSING = "not installed"
REQUIREMENT = re.compile(r"([\w.-]+)[^;]*(?:;.*extra\s*==\s*['\"](\w+)['\"])?")
WIDTH = 100  # of lists of names
OF_USERS = (
    "recording",
    "report",
    "plots",
    "view",
    "video",
    "tables",
    "sweeps",
    "cluster",
    "records",
)  # extras; the others are those of developers


def lines() -> Iterator[str]:
    """Versions and licences, a line each."""
    version, licence = stated(ITSELF)
    yield f"{ITSELF} {version}, {licence}"
    yield f"{platform.python_implementation()} {platform.python_version()} on {platform.platform()}"
    needed, optional = _requirements()
    yield from ("", "Needed", *tables.fitted_words([(name, *stated(name)) for name in needed] or [("(the package is not installed)",)]))
    if optional:
        rows = [(name, *stated(name), f"for {', '.join(extras)}") for name, extras in optional.items()]
        yield from ("", "Optional", *tables.fitted_words(rows))
    yield from ("", "In recordings, reports and the live window", *tables.fitted_words([*_in_meshcat(), _plotly()]))
    yield from _in_plotly()


def stated(package: str) -> tuple[str, str]:
    """Version and licence of a package from its metadata: an SPDX expression, or else the text of its classifier or field."""
    try:
        about = metadata.metadata(package)
    except metadata.PackageNotFoundError:
        return MISSING, ""
    classified = [line.rpartition(" :: ")[2] for line in about.get_all("Classifier", []) if line.startswith("License :: OSI Approved ::")]
    expression, field = (about.get_all(name, [""])[0] for name in ("License-Expression", "License"))
    return about["Version"], expression or ", ".join(classified) or field.strip().partition("\n")[0] or UNSTATED  # some hold the whole text


def _requirements() -> tuple[list[str], dict[str, list[str]]]:
    """Packages that are always needed, and optional packages with the extras that name them."""
    try:
        lines = metadata.requires(ITSELF) or []
    except metadata.PackageNotFoundError:
        return [], {}
    needed, optional = [], dict[str, list[str]]()
    for line in lines:
        match = REQUIREMENT.match(line)
        if match is None or match[1] == ITSELF:
            continue
        if match[2] is None:
            needed.append(match[1])
        elif match[2] in OF_USERS and match[2] not in optional.setdefault(match[1], []):
            optional[match[1]].append(match[2])
    return needed, optional


def _in_meshcat() -> Iterator[tuple[str, str, str]]:
    """Meshcat's viewer and the software in it."""
    try:
        script = meshcat_script()
    except PinpressError:
        yield "Meshcat", MISSING, ""
        return
    yield "Meshcat's viewer", *stated("meshcat")
    for part in licences.of_meshcat(script):
        yield part.name, part.version, part.licence


def _plotly() -> tuple[str, str, str]:
    """Plotly's charts, from the comment at the top of the script."""
    try:
        head = plotly_head()
    except PinpressError:
        return "plotly.js", MISSING, ""
    licence = re.search(r"under the ([\w.-]+) license", head)
    return "plotly.js", licences.plotly_version(head) or UNSTATED, licence[1] if licence else UNSTATED


def _in_plotly() -> Iterator[str]:
    """Licences of the software in Plotly's charts; it has hundreds of parts."""
    _, version, _ = _plotly()
    if version == MISSING:
        return
    known = version if version in licences.examined() else " or ".join(licences.examined())
    yield from ("", f"In plotly.js {known}")
    names = defaultdict[str, list[str]](list)
    for part in licences.of_plotly(version):
        names[part.licence].append(f"{part.name} {part.version}".strip().replace(" ", "\N{NO-BREAK SPACE}"))
    for licence, parts in sorted(names.items(), key=lambda each: -len(each[1])):
        words = textwrap.wrap(", ".join(parts), WIDTH, break_long_words=False, break_on_hyphens=False)
        yield from (f"  {licence}", *(f"    {line}".replace("\N{NO-BREAK SPACE}", " ") for line in words))
