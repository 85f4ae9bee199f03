"""Picture and tables of docs/accuracy.md, the README and the article, from the files that `programs` has measured."""

import csv
import re
from functools import cache
from pathlib import Path

from make import write
from support import markdown

import pinpress as pp
from pinpress.accuracy.scenes import SPEED_LAW
from pinpress.accuracy.work_precision import Group, Measurement, WorkPrecision
from pinpress.common.results import Records

ROOT = Path(__file__).resolve().parents[3]
VIZ = ROOT / "viz"
LINKAGES = {  # file -> words of the tables' heads
    "accuracy.csv": "six-bar press",
    "accuracy_rssp.csv": "ball-ended rod, in space",
    "accuracy_bricard.csv": "Bricard's six pins",
}
SPACE, HYPHEN = "\u00a0", "\u2011"  # at which no line is broken
RUN = (1e-6, 1e-9)  # errors of a run that are asked for: of the crank angle [rad], or of a peak force
AT_WORK = {"clutch and blanking": "error", "elastic die": "error", "stiff speed law": "force_error"}  # scene -> error that is asked for
SPRINGS = (1e-3, 1e-6, 1e-8)  # errors that are asked for, of a peak force
ENGINES = ("plane", "space", "pinocchio")
OURS = ("reduced", "implicit", "constraint")
NAMES = {  # method -> what the tables call it
    "reduced, its table anew": "`pinpress`, `reduced`, its table made anew",
    "elastic": "`pinpress`, `simulate(elastic=)`",
    "elastic, steady stroke": "`pinpress`, the stroke it repeats, directly",
    "hand script": "hand script, batched NumPy",
}
NAMES |= {engine: f"`pinpress`, engine `{engine}`" for engine in ENGINES} | {method: f"`pinpress`, `{method}`" for method in OURS}
NAMES |= {f"{method}, Runge-Kutta 4": f"`pinpress`, `{method}`, Runge-Kutta 4" for method in OURS}
PROGRAMS = {  # words of the short tables -> methods without versions, of which the first one that a linkage has counts
    "pinpress": ("plane", "space"),
    "hand script, NumPy": ("hand script",),
    "Pinocchio, a loop in C++": ("Pinocchio in C++",),
    "MuJoCo, loops in NumPy": ("MuJoCo + NumPy",),
    "Drake, loops in NumPy": ("Drake + NumPy",),
    "Exudyn": ("Exudyn",),
}
Row = dict[str, str]


def main(quick: bool = False) -> None:
    """Draw viz/accuracy.png and replace the tables of the pages, each of which begins with the same cell as ours; ``quick``: print them."""
    for page, text in {"docs/accuracy.md": table(), "README.md": in_short(), "paper/paper.md": in_paper()}.items():
        if quick:
            print(text, end="\n\n")
            continue
        blocks = (ROOT / page).read_text(encoding="utf-8").split("\n\n")
        for new in text.split("\n\n"):
            (k,) = [k for k, block in enumerate(blocks) if block.split(" | ")[0] == new.split(" | ")[0]]
            blocks[k] = new + "\n" * (len(blocks[k]) - len(blocks[k].rstrip("\n")))
        (ROOT / page).write_text("\n\n".join(blocks), encoding="utf-8")
    if not quick:
        picture()


@cache
def rows_of(file: str) -> list[Row]:
    """Rows of a file that `programs` has written."""
    with (VIZ / file).open(newline="", encoding="utf-8") as opened:
        return list(csv.DictReader(opened))


def table() -> str:
    """The tables of docs/accuracy.md: inverse dynamics, what programs cannot do, and the least times of runs."""
    turns = [{row["method"]: row for row in _group(file, "inverse dynamics")} for file in LINKAGES]
    least = {method: _seconds(row) for turn in reversed(turns) for method, row in turn.items()}  # of the six-bar where it is there
    lines = [
        (NAMES.get(method, method), *(cell for turn in turns for cell in _time_and_error(turn.get(method))))
        for method in sorted(least, key=lambda method: least[method])
    ]
    cannot = {row["method"]: row["cannot"] for file in LINKAGES for row in rows_of(file) if row["cannot"]}
    tables = [
        markdown.table(["360 crank angles", *(cell for words in LINKAGES.values() for cell in (words, "error"))], lines),
        markdown.table(["program", "what it cannot do"], ((NAMES.get(method, method), words) for method, words in cannot.items())),
        _free_run(),
        _least_times(
            "two turns at work, least time",
            {
                f"{scene}, to {error:.0e} {'rad' if of == 'error' else 'of the force'}": (scene, error, of)
                for scene, of in AT_WORK.items()
                for error in RUN
            },
        ),
        _least_times(
            "half a stroke on springs, least time",
            {f"to {error:.0e} of the force": ("blanking on springs", error, "force_error") for error in SPRINGS},
            first=1,
        ),
    ]
    return "\n\n".join(tables)


def in_short() -> str:
    """The table of the README: time and error of a turn of each linkage, a program a row."""
    head = ["a turn, all forces", *(cell for words in LINKAGES.values() for cell in (words, "error"))]
    programs = {**PROGRAMS, NAMES["pinocchio"]: ("pinocchio",)}
    return markdown.table(head, ((words, *(cell for row in _turns(of) for cell in _time_and_error(row))) for words, of in programs.items()))


def in_paper() -> str:
    """The table of the article: a turn of each linkage, a program a row."""
    rows = ((words, *(_time_and_error(row)[0] for row in _turns(methods))) for words, methods in PROGRAMS.items())
    return markdown.table(["program", *LINKAGES.values()], rows)


def _turns(methods: tuple[str, ...]) -> list[Row | None]:
    """Of each linkage the row of the first of these methods that treats it."""
    named = [{re.sub(r" [0-9.]+\b", "", row["method"]): row for row in _group(file, "inverse dynamics")} for file in LINKAGES]
    return [next((turn[method] for method in methods if method in turn), None) for turn in named]


def _free_run() -> str:
    runs = [row for row in _group("accuracy.csv", "free run") if row["error"]]
    best = {error: _fastest(runs, error, "error") for error in RUN}
    lines = []
    for method in dict.fromkeys([*best[RUN[0]], *(row["method"] for row in runs)]):
        cells = []
        for rows in best.values():
            row = rows.get(method)
            gap = f"{_share(row['loop_gap [m]'])}{SPACE}m" if row and row["loop_gap [m]"] else ""
            cells += ["not reached", "", ""] if row is None else [_time(row), _share(row["force_error"]) if row["force_error"] else "", gap]
        lines.append((NAMES.get(method, method), *cells))
    heads = [cell for error in RUN for cell in (f"to {error:.0e} rad", "force error", "loop gap")]
    return markdown.table(["free run of two turns, least time", *heads], lines)


def _least_times(title: str, columns: dict[str, tuple[str, float, str]], first: int = 0) -> str:
    """The least times to reach errors, by head: scene, error and which one; methods in the order of their times in the column `first`."""
    scenes = {head: _group("accuracy.csv", scene) for head, (scene, *_) in columns.items()}
    best = {head: _fastest([row for row in scenes[head] if row["error"]], *asked) for head, (_, *asked) in columns.items()}
    lines = []
    for method in dict.fromkeys(method for head in (list(columns)[first], *columns) for method in best[head]):
        tried = {head: any(row["method"] == method for row in rows) for head, rows in scenes.items()}
        cells = (_time(best[head][method]) if method in best[head] else "not reached" if tried[head] else "left out" for head in columns)
        lines.append((NAMES.get(method, method), *cells))
    return markdown.table([title, *columns], lines)


def _group(file: str, group: str) -> list[Row]:
    return [row for row in rows_of(file) if row["group"] == group]


def _fastest(rows: list[Row], error: float, of: str) -> dict[str, Row]:
    """Of every method the fastest row with an error not above this one, the fastest first."""
    best: dict[str, Row] = {}
    for row in sorted(rows, key=_seconds):
        if float(row[of]) <= error:
            best.setdefault(row["method"], row)
    return best


def _time_and_error(row: Row | None) -> tuple[str, str]:
    """Time, and the largest error of torque and bearing forces as a share of the largest."""
    return ("", "") if row is None else (_time(row), _share(max(float(row[of] or 0) for of in ("error", "force_error"))))


def _seconds(row: Row) -> float:
    return float(row["seconds [s]"])


def _time(row: Row) -> str:
    return f"{1e3 * _seconds(row):.3g}{SPACE}ms"


def _share(value: float | str) -> str:
    return f"{float(value):.0e}".replace("-", HYPHEN)


def picture() -> None:
    """viz/accuracy.png from viz/accuracy.csv: a panel for the turn and for each scene."""
    rows = [row for row in rows_of("accuracy.csv") if row["group"] not in ("proximal settings", "reduced table")]
    groups, measurements = {}, []
    for name in dict.fromkeys(row["group"] for row in rows):
        least = min(float(row["error"]) for row in rows if row["group"] == name and row["error"])
        groups[name] = Group("", "", "", least, "", "force_error" if name in (SPEED_LAW, "blanking on springs") else "error")
    for row in rows:
        errors = (float(row[name]) if row[name] else None for name in ("error", "force_error"))
        measurements.append(Measurement(row["group"], row["method"], row["setting"], None, _seconds(row), *errors))
    measured = WorkPrecision("ZXN2-3000(B)", "70 r/min, 360 crank angles", "", groups, Records(Measurement, measurements), ())
    write(VIZ / "accuracy.png", pp.accuracy.plot(measured))
