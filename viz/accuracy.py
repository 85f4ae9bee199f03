"""Error against run time of three linkages, pinpress and its peers: tables of docs/accuracy.md, docs/comparison.md and the README.

Run `python viz/accuracy.py` (with `pip install -e '.[plots,peers,drake]'` and a C++ compiler): in a few minutes it writes accuracy.csv, of
the six-bar press, accuracy_rssp.csv, accuracy_bricard.csv and accuracy.png beside itself, and puts the tables into the pages.
`python viz/accuracy.py pages` makes the tables anew from the files.
"""

import csv
import itertools
import re
import sys
from functools import cache
from pathlib import Path

import pinpress as pp
from pinpress.pin_table import templates

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
SIX_BAR, RSSP, BRICARD = LINKAGES = {  # file -> words of the tables' heads
    "accuracy.csv": "six-bar press",
    "accuracy_rssp.csv": "ball-ended rod, in space",
    "accuracy_bricard.csv": "Bricard's six pins",
}
POINTS = 360
TURN = f"{POINTS} crank angles"
SPACE, HYPHEN = "\u00a0", "\u2011"  # at which no line is broken
WANTED = (1e-6, 1e-9)  # errors of a run that are asked for: of the crank angle [rad], or of a peak force
AT_WORK = {"clutch and blanking": "error", "elastic die": "error", "stiff speed law": "force_error"}  # scene -> error that is asked for
NAMES = {  # method -> what the table calls it
    "plane": "`pinpress`, engine `plane`",
    "space": "`pinpress`, engine `space`",
    "pinocchio": "`pinpress`, engine `pinocchio`",
    "reduced": "`pinpress`, `reduced`",
    "reduced, its table anew": "`pinpress`, `reduced`, its table made anew",
    "implicit": "`pinpress`, `implicit`",
    "constraint": "`pinpress`, `constraint`",
    "reduced, Runge-Kutta 4": "`pinpress`, `reduced`, Runge-Kutta 4",
    "constraint, Runge-Kutta 4": "`pinpress`, `constraint`, Runge-Kutta 4",
    "elastic": "`pinpress`, `simulate(elastic=)`",
    "elastic, steady stroke": "`pinpress`, the stroke it repeats, directly",
    "hand script": "hand script, batched NumPy",
}
ON_SPRINGS = 1e-3, 1e-6, 1e-8  # errors that are asked for, of a peak force
PAGES = {
    "docs/accuracy.md": lambda: table(),
    "docs/comparison.md": lambda: comparison(),
    "README.md": lambda: in_short(),
    "paper/paper.md": lambda: in_paper(),
}
Row = dict[str, str]


def table() -> str:
    """The tables of docs/accuracy.md: inverse dynamics, what programs cannot do, and the least times of runs."""
    lines = _inverse_dynamics()
    refused = {row["method"]: row["cannot"] for file in LINKAGES for row in rows_of(file) if row["cannot"]}
    lines += ["", "| program | what it cannot do |", "|---|---|", *(f"| {_name(method)} | {words} |" for method, words in refused.items())]
    rows = rows_of(SIX_BAR)
    runs = [row for row in rows if row["group"] == "free run" and row["error"]]
    best = {wanted: _fastest(runs, wanted) for wanted in WANTED}
    heads = " | ".join(f"to {wanted:.0e} rad | force error | loop gap" for wanted in WANTED)
    lines += ["", f"| free run of two turns, least time | {heads} |", "|---" * (1 + 3 * len(WANTED)) + "|"]
    unreached = [method for method in dict.fromkeys(row["method"] for row in runs) if method not in best[WANTED[0]]]
    for method in [*best[WANTED[0]], *unreached]:
        cells = []
        for wanted in WANTED:
            reached = best[wanted].get(method)
            cells += ["not reached", "", ""] if reached is None else [_time(reached), _error(reached, "force_error"), _gap(reached)]
        lines.append(f"| {_name(method)} | " + " | ".join(cells) + " |")
    return "\n".join([*lines, "", *_at_work(rows), "", *_on_springs(rows)])


def comparison() -> str:
    """The table of docs/comparison.md: a turn of each linkage, and the least time of the six-bar's free run to 1e-6 rad."""
    runs = [row for row in rows_of(SIX_BAR) if row["group"] == "free run" and row["error"]]
    lines = [f"| program | {' | '.join(LINKAGES.values())} | run to 1e{HYPHEN}6{SPACE}rad | loop gap |", "|---" * (3 + len(LINKAGES)) + "|"]
    for words, turning, running in PROGRAMS:
        ran = [row for row in runs if running and _is(row, running)]
        fastest = min((row for row in ran if float(row["error"]) <= WANTED[0]), key=_seconds, default=None)
        run = ["not reached" if ran else "", ""] if fastest is None else [_time(fastest), _gap(fastest)]
        lines.append(f"| {words} | {' | '.join([*_turns(turning), *run])} |")
    return "\n".join(lines)


PROGRAMS = (  # words, methods of inverse dynamics of which the first one counts, and those of runs, all without versions
    ("pinpress", ("plane", "space"), "reduced"),
    ("hand script, NumPy", ("hand script",), ""),
    ("Pinocchio, a loop in C++", ("Pinocchio in C++",), ""),
    ("MuJoCo, loops in NumPy", ("MuJoCo + NumPy",), "MuJoCo + NumPy"),
    ("MuJoCo, `mj_step`", (), "MuJoCo, mj_step"),
    ("Drake, loops in NumPy", ("Drake + NumPy",), ""),
    ("Drake, its own steps", (), "Drake, SAP"),
    ("Exudyn", ("Exudyn",), "Exudyn"),
)


def in_short() -> str:
    """The table of the README: time and error of a turn of each linkage, a program a row."""
    lines = [f"| a turn, all forces | {' | error | '.join(LINKAGES.values())} | error |", "|---" * (1 + 2 * len(LINKAGES)) + "|"]
    programs = [(words, turning) for words, turning, _ in PROGRAMS if turning]
    for words, turning in [*programs, (NAMES["pinocchio"], ("pinocchio",))]:
        cells = itertools.chain(*(("", "") if row is None else (_time(row), _largest_error(row)) for row in _rows_of_turns(turning)))
        lines.append(f"| {words} | {' | '.join(cells)} |")
    return "\n".join(lines)


def in_paper() -> str:
    """The table of the article: a turn of each linkage, a program a row."""
    lines = [f"| program | {' | '.join(LINKAGES.values())} |", "|---" * (1 + len(LINKAGES)) + "|"]
    return "\n".join([*lines, *(f"| {words} | {' | '.join(_turns(turning))} |" for words, turning, _ in PROGRAMS if turning)])


def put_into_pages() -> None:
    """Replace the tables of the pages, each of which begins with the same cell as ours."""
    for page, made in PAGES.items():
        path = ROOT / page
        blocks = path.read_text(encoding="utf-8").split("\n\n")
        for new in made().split("\n\n"):
            (k,) = [k for k, block in enumerate(blocks) if block.split(" | ")[0] == new.split(" | ")[0]]
            blocks[k] = new + "\n" * (len(blocks[k]) - len(blocks[k].rstrip("\n")))
        path.write_text("\n\n".join(blocks), encoding="utf-8")


@cache
def rows_of(file: str) -> list[Row]:
    """Rows of a file that `WorkPrecision.to_csv` has written."""
    with (HERE / file).open(newline="", encoding="utf-8") as opened:
        return list(csv.DictReader(opened))


def _inverse_dynamics() -> list[str]:
    turns = {file: {row["method"]: row for row in rows_of(file) if row["group"] == "inverse dynamics"} for file in LINKAGES}
    heads = " | error | ".join(LINKAGES.values())
    lines = [f"| {TURN} | {heads} | error |", "|---" * (1 + 2 * len(LINKAGES)) + "|"]
    least = {method: _seconds(row) for turn in reversed(turns.values()) for method, row in turn.items()}  # of the six-bar where it is there
    for method in sorted(least, key=lambda method: least[method]):
        cells: list[str] = []
        for turn in turns.values():
            row = turn.get(method)
            cells += ["", ""] if row is None else [_time(row), _largest_error(row)]
        lines.append(f"| {_name(method)} | {' | '.join(cells)} |")
    return lines


def _turns(methods: tuple[str, ...]) -> list[str]:
    """Of each linkage the time of a turn by the first of these methods that treats it."""
    return ["" if row is None else _time(row) for row in _rows_of_turns(methods)]


def _rows_of_turns(methods: tuple[str, ...]) -> list[Row | None]:
    """Of each linkage the row of the first of these methods that treats it."""
    turns = [[row for row in rows_of(file) if row["group"] == "inverse dynamics"] for file in LINKAGES]
    return [next((row for method in methods for row in turn if _is(row, method)), None) for turn in turns]


def _largest_error(row: Row) -> str:
    """Of the driving torque and of the bearing forces, as a share of the largest."""
    return _share(max(float(row[name] or 0) for name in ("error", "force_error")))


def _at_work(rows: list[Row]) -> list[str]:
    """The least times of the press at work, a method a line, in the order of their times in the first scene."""
    found = {
        (scene, wanted): _fastest([row for row in rows if row["group"] == scene and row["error"]], wanted, by)
        for scene, by in AT_WORK.items()
        for wanted in WANTED
    }
    heads = [f"{scene}, to {wanted:.0e} {'rad' if AT_WORK[scene] == 'error' else 'of the force'}" for scene, wanted in found]
    lines = [f"| two turns at work, least time | {' | '.join(heads)} |", "|---" * (1 + len(heads)) + "|"]
    methods = list(dict.fromkeys(method for best in found.values() for method in best))
    for method in methods:
        cells = [_time(best[method]) if method in best else _missing(rows, scene, method) for (scene, _), best in found.items()]
        lines.append(f"| {_name(method)} | {' | '.join(cells)} |")
    return lines


def _on_springs(rows: list[Row]) -> list[str]:
    """The least times of the press on springs, a method a line, in the order of their times to the error in the middle."""
    own = [row for row in rows if row["group"] == "blanking on springs" and row["error"]]
    best = {wanted: _fastest(own, wanted, "force_error") for wanted in ON_SPRINGS}
    heads = " | ".join(f"to {wanted:.0e} of the force" for wanted in ON_SPRINGS)
    lines = [f"| half a stroke on springs, least time | {heads} |", "|---" * (1 + len(ON_SPRINGS)) + "|"]
    for method in dict.fromkeys([*best[ON_SPRINGS[1]], *best[ON_SPRINGS[0]]]):
        cells = [_time(best[wanted][method]) if method in best[wanted] else "not reached" for wanted in ON_SPRINGS]
        lines.append(f"| {_name(method)} | {' | '.join(cells)} |")
    return lines


def _missing(rows: list[Row], scene: str, method: str) -> str:
    return "not reached" if any(row["group"] == scene and row["method"] == method for row in rows) else "left out"


def _fastest(rows: list[Row], wanted: float, by: str = "error") -> dict[str, Row]:
    """Of every method the fastest row with an error not above the wanted one, the fastest first."""
    best: dict[str, Row] = {}
    for row in sorted(rows, key=_seconds):
        if float(row[by]) <= wanted:
            best.setdefault(row["method"], row)
    return best


def _is(row: Row, method: str) -> bool:
    """Whether a row is of a method that is named without the version of its program."""
    return re.sub(r" [0-9.]+\b", "", row["method"]) == method


def _name(method: str) -> str:
    return NAMES.get(method, method)


def _seconds(row: Row) -> float:
    return float(row["seconds [s]"])


def _time(row: Row) -> str:
    return f"{1e3 * _seconds(row):.3g}{SPACE}ms"


def _error(row: Row, name: str) -> str:
    return _share(float(row[name])) if row[name] else ""


def _share(value: float) -> str:
    return f"{value:.0e}".replace("-", HYPHEN)


def _gap(row: Row) -> str:
    return f"{_share(float(row['loop_gap [m]']))}{SPACE}m" if row["loop_gap [m]"] else ""


def _measured() -> None:
    from light import light  # type: ignore[import-not-found]  # beside this script

    def measure(press: pp.Linkage, file: str, speed: float, **how: object) -> pp.accuracy.WorkPrecision:
        measured = pp.accuracy.compare(press, speed=speed * pp.RPM, points=POINTS, repeats=4, **how)
        measured.to_csv(HERE / file)
        print(f"{measured}\n")
        return measured

    light(pp.plots.save(pp.accuracy.plot(measure(pp.load("zxn2_3000b"), SIX_BAR, 70)), HERE / "accuracy.png"))
    measure(pp.build(Path(templates.__file__).with_name("rssp.yaml")), RSSP, 60, scenes=[])
    measure(pp.load(ROOT / "pinpress" / "accuracy" / "peers" / "bricard.urdf"), BRICARD, 300, scenes=[])


if __name__ == "__main__":
    if sys.argv[1:] != ["pages"]:
        _measured()
    put_into_pages()
