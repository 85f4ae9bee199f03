"""`pinpress about`: versions of what pinpress runs on, and the licences of that and of what its pages hold of others."""

import argparse
import itertools
import json
import platform
import re
from collections.abc import Iterator
from importlib import metadata

from ..common import tables
from ..common.errors import PinpressError
from ..visual.pages import meshcat_script, plotly_script

ITSELF = "pinpress"
UNSTATED = "not stated"
MISSING = "not installed"
REQUIREMENT = re.compile(r"([\w.-]+)[^;]*(?:;.*extra\s*==\s*['\"](\w+)['\"])?")
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


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `about` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "about",
        help="versions of pinpress and of what it runs on, and the licences of all that is in its pages",
        description="Print the versions of pinpress, Python and all packages that it uses, for a bug report, with their licences as each\n"
        "package states them; then what a page (recording, report, live window) holds of others, read from the files that go into it.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print all of it. Returns 0."""
    print("\n".join(_lines()))
    return 0


def _lines() -> Iterator[str]:
    version, licence = stated(ITSELF)
    yield f"{ITSELF} {version}, {licence}"
    yield f"{platform.python_implementation()} {platform.python_version()} on {platform.platform()}"
    needed, optional = _requirements()
    yield from ("", "Needed", *tables.fitted_words([(name, *stated(name)) for name in needed] or [("(the package is not installed)",)]))
    if optional:
        rows = [(name, *stated(name), f"for {', '.join(extras)}") for name, extras in optional.items()]
        yield from ("", "Optional", *tables.fitted_words(rows))
    yield from ("", "In recordings, reports and the live window", *tables.fitted_words([*_in_meshcat(), *_in_plotly()]))


def stated(package: str) -> tuple[str, str]:
    """Version and licence of a package as its metadata state them: an SPDX expression, or else the words of its classifier or field."""
    try:
        about = metadata.metadata(package)
    except metadata.PackageNotFoundError:
        return MISSING, ""
    classified = [line.rpartition(" :: ")[2] for line in about.get_all("Classifier", []) if line.startswith("License :: OSI Approved ::")]
    expression, field = (about.get_all(name, [""])[0] for name in ("License-Expression", "License"))
    return about["Version"], expression or ", ".join(classified) or field.strip().partition("\n")[0] or UNSTATED  # some hold the whole text


def _requirements() -> tuple[list[str], dict[str, list[str]]]:
    """Packages that are always needed, and the others with the extras of users that name them."""
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
    """Meshcat's viewer and what is in it, by the list that it was built with."""
    try:
        script = meshcat_script()
    except PinpressError:
        yield "Meshcat", MISSING, ""
        return
    yield "Meshcat's viewer", *stated("meshcat")
    for part in json.loads(script.with_name(f"{script.name}.THIRD_PARTY_LICENSES.json").read_text("utf-8")):
        yield part["name"], part["version"], part["license"] or UNSTATED


def _in_plotly() -> Iterator[tuple[str, str, str]]:
    """Plotly's charts, by the comment in front of the script."""
    try:
        script = plotly_script()
    except PinpressError:
        yield "plotly.js", MISSING, ""
        return
    with script.open(encoding="utf-8") as lines:
        head = "".join(itertools.takewhile(lambda line: "*/" not in line, lines))
    version, licence = (re.search(words, head) for words in (r"plotly\.js v([\w.-]+)", r"under the ([\w.-]+) license"))
    yield "plotly.js", version[1] if version else UNSTATED, licence[1] if licence else UNSTATED
