"""The table of extremes: what pinpress does where numbers, lengths, speeds, forces and positions are extreme, beside what is right.

All go into viz/extremes.md; those whose group has a word in its name are only printed.
"""

import math
import warnings
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

from extremes import (
    extreme_change_points,
    extreme_elastic,
    extreme_loads,
    extreme_noise,
    extreme_redundancy,
    extreme_runs,
    extreme_sizes,
    extreme_stiff,
)
from extremes.extreme_case import Case, Outcome, short
from make import write

from pinpress import PinpressWarning

CASES: list[Case] = [
    case
    for module in (
        extreme_change_points,
        extreme_sizes,
        extreme_loads,
        extreme_stiff,
        extreme_redundancy,
        extreme_runs,
        extreme_noise,
        extreme_elastic,
    )
    for case in module.CASES
]
PAGE = Path(__file__).resolve().parents[2] / "viz" / "extremes.md"
INTRODUCTION = """# Extremes

`python docs/make.py extreme_cases` runs every case, judges it and writes this page. `tests/extremes/test_extreme_cases.py` holds every
case to its bound.

- *expected*: each case has an expectation of its own: a closed form, a law of scaling or conservation, or the other engine or method.
- Errors are relative to the largest value of their kind (of runs: in rad, and of speeds relative to the speed). The number behind the
  stroke is the bound.
- Cases marked + are long, and only the command runs them. **not met** stands where an expectation is not met.
"""


def worked(case: Case, way: str) -> Outcome:
    """The outcome, a foreign exception too: one broken case must not hide the others."""
    try:
        return case.work(way)
    except Exception as error:
        return Outcome(math.inf, 0.0, "foreign exception: " + short(error))


def cell(case: Case, way: str) -> str:
    """What happens."""
    outcome = worked(case, way)
    numbers = "" if math.isinf(outcome.error) else f"{outcome.error:.1e} / {outcome.bound:.0e}"
    said = ", ".join(filter(None, (numbers, outcome.what)))
    return said if outcome.met else f"**not met**: {said}"


def table(ways: Sequence[str], cases: Sequence[Case]) -> Iterator[str]:
    """Markdown, a row a case."""
    yield f"| case | expected | {' | '.join(ways)} |"
    yield "|" + "---|" * (2 + len(ways))
    for case in cases:
        found = [cell(case, way) for way in ways]
        yield "| " + " | ".join(text.replace("|", "\\|") for text in (case.name + " +" * case.long, case.expected, *found)) + " |"


def page(cases: Sequence[Case]) -> Iterator[str]:
    """The lines of the page, as they are worked out."""
    yield INTRODUCTION
    for group, members in groupby(cases, key=lambda case: case.group):
        yield f"## {group}\n"
        for ways, some in groupby(members, key=lambda case: case.ways):
            yield from table(ways, list(some))
            yield ""


def main(quick: bool = False, parts: Sequence[str] = ()) -> None:
    """Run the cases, or those of groups that have these words; ``quick``: those of noise."""
    wanted = "noise" if quick else " ".join(parts).lower()
    lines = []
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a warning is an outcome that the table must show
        warnings.simplefilter("ignore", PinpressWarning)  # but not that no press is like that
        for line in page([case for case in CASES if wanted in case.group.lower()]):
            print(line, flush=True)
            lines.append(line)
    if not wanted:
        write(PAGE, "\n".join(lines))
