"""The table of extremes: what pinpress does where numbers, lengths, speeds, forces and positions are extreme, beside what is right.

python tests/extremes/extreme_cases.py            # all cases; writes viz/extremes.md and prints it
python tests/extremes/extreme_cases.py GROUP      # those whose group has this word in its name, printed only
"""

import math
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import groupby
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
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
SECONDS = 0.2  # of repeats, for a time that other work on the machine has not disturbed
INTRODUCTION = """# Extremes

`python tests/extremes/extreme_cases.py` runs every case, judges it and writes this page. `tests/extremes/test_extreme_cases.py` holds every
case to its bound.

- *expected*: each case has an expectation of its own: a closed form, a law of scaling or conservation, or the other engine or method.
- Errors are relative to the largest value of their kind (of runs: in rad, and of speeds relative to the speed). The number behind the
  stroke is the bound.
- *cost*: the run time divided by that of the same scene at ordinary numbers, in the same run. The linkages are loaded and followed round
  before.
- Cases marked + are long, and only the command runs them. **not met** stands where an expectation is not met.
"""


def seconds(work: Callable[[str], Any], way: str) -> float:
    """The least time of a call, of as many as fill `SECONDS`, at least one."""
    least, began = math.inf, time.perf_counter()
    while (start := time.perf_counter()) - began < SECONDS or math.isinf(least):
        with suppress(Exception):  # as expected, or the row says so
            work(way)
        least = min(least, time.perf_counter() - start)
    return least


def worked(case: Case, way: str) -> Outcome:
    """The outcome, a foreign exception too: one broken case must not hide the others."""
    try:
        return case.work(way)
    except Exception as error:
        return Outcome(math.inf, 0.0, "foreign exception: " + short(error))


def cells(case: Case, way: str) -> tuple[str, str]:
    """What happens, and the cost."""
    outcome = worked(case, way)
    numbers = "" if math.isinf(outcome.error) else f"{outcome.error:.1e} / {outcome.bound:.0e}"
    said = ", ".join(filter(None, (numbers, outcome.what)))
    timed = case.ordinary is not None and not case.long
    cost = f"{seconds(case.scene, way) / seconds(case.ordinary, way):.2g}" if timed else ""
    return said if outcome.met else f"**not met**: {said}", cost


def table(ways: Sequence[str], cases: Sequence[Case]) -> Iterator[str]:
    """Markdown, a row a case."""
    heads = [head for way in ways for head in (way, "cost")]
    yield f"| case | expected | {' | '.join(heads)} |"
    yield "|" + "---|" * (2 + len(heads))
    for case in cases:
        found = [cell for way in ways for cell in cells(case, way)]
        yield "| " + " | ".join(text.replace("|", "\\|") for text in (case.name + " +" * case.long, case.expected, *found)) + " |"


def page(cases: Sequence[Case]) -> Iterator[str]:
    """The lines of the page, as they are worked out."""
    yield INTRODUCTION
    for group, members in groupby(cases, key=lambda case: case.group):
        yield f"## {group}\n"
        for ways, some in groupby(members, key=lambda case: case.ways):
            yield from table(ways, list(some))
            yield ""


def main() -> None:
    wanted = " ".join(sys.argv[1:]).lower()
    lines = []
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a warning is an outcome that the table must show
        warnings.simplefilter("ignore", PinpressWarning)  # but not that no press is like that
        for line in page([case for case in CASES if wanted in case.group.lower()]):
            sys.stdout.write(line + "\n")
            sys.stdout.flush()
            lines.append(line)
    if not wanted:
        PAGE.write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
