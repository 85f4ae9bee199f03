"""Ratios of run times from commit to commit, as asv has stored them: the table and the picture of README.md in that folder.

Each line of the picture is pinpress against a peer that stays, as `ratios.py` describes.
"""

import ast
import json
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from make import write
from matplotlib.figure import Figure
from support import markdown

HISTORY = Path(__file__).resolve().parent
ENTRY = "track_"


def words() -> dict[str, str]:
    """What each ratio is of: name of its function, without what all of them begin with, to its docstring without the stop."""
    code = ast.parse((HISTORY / "ratios.py").read_text(encoding="utf-8"))
    functions = [node for node in code.body if isinstance(node, ast.FunctionDef) and node.name.startswith(ENTRY)]
    return {function.name.removeprefix(ENTRY): (ast.get_docstring(function) or "").rstrip(".") for function in functions}


def stored() -> list[dict[str, Any]]:
    """The results of all commits on all machines, oldest commit first."""
    files = [path for path in HISTORY.glob("results/*/*.json") if path.name != "machine.json"]
    return sorted(
        (json.loads(path.read_text(encoding="utf-8")) for path in files), key=lambda found: (found["date"], found["params"]["machine"])
    )


def ratio(found: dict[str, Any], name: str) -> float | None:
    """A ratio of a commit [-]; None where the commit cannot do it."""
    values = found["results"].get(f"ratios.{ENTRY}{name}", [None])[0]
    return None if not values or values[0] is None else float(values[0])


def table() -> str:
    """The ratios of all commits, a commit a row."""
    rows = []
    for found in stored():
        ratios = (ratio(found, name) for name in words())
        rows.append((f"{found['commit_hash'][:7]}, {_day(found)}", *("" if each is None else f"{each:.3g}" for each in ratios)))
    return markdown.table(("commit", *(name.replace("_", " ") for name in words())), rows)


def picture() -> Figure:
    """Each ratio over the commits, by that of the newest one."""
    commits = stored()
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    axes = figure.subplots()
    for name in words():
        known = [(k, each) for k, found in enumerate(commits) if (each := ratio(found, name)) is not None]
        places, values = zip(*known, strict=True)
        axes.plot(places, [value / values[-1] for value in values], "o-", label=f"{name.replace('_', ' ')}, last {values[-1]:.3g}")
    days = [f"{found['commit_hash'][:7]}, {_day(found)}" for found in commits]
    axes.set_xticks(range(len(commits)), days, rotation=40, ha="right", rotation_mode="anchor", fontsize="small")
    axes.set_yscale("log", base=2)
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set(ylabel="ratio of times / that of the last commit")
    axes.grid(alpha=0.3)
    figure.legend(loc="outside right upper", fontsize="small")
    return figure


def _day(found: dict[str, Any]) -> str:
    return datetime.fromtimestamp(found["date"] / 1000, timezone.utc).strftime("%Y-%m-%d")


def fill(page: str) -> str:
    """The page with the table of all commits between its marks."""
    before, _, rest = page.partition("<!-- table -->\n")
    _, end, after = rest.partition("<!-- end of table -->")
    return f"{before}<!-- table -->\n{table()}\n{end}{after}"


def main(quick: bool = False) -> None:
    """Write both."""
    write(HISTORY / "ratios.png", picture())
    page = HISTORY / "README.md"
    write(page, fill(page.read_text(encoding="utf-8")))
