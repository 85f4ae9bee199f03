"""Error against run time of three linkages, pinpress and other programs: tables of docs/accuracy.md, the README and the article.

python tests/benchmarks/accuracy/beside_programs.py          # measures in a few minutes and writes; needs plots, peers, drake, C++
python tests/benchmarks/accuracy/beside_programs.py pages    # picture and tables again from the files of the last measurement

It writes accuracy.csv, of the six-bar press, accuracy_rssp.csv, accuracy_bricard.csv and accuracy.png in viz, and the tables of the pages.
"""

import csv
import itertools
import math
import re
import sys
from functools import cache
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks.accuracy import contests, on_springs

import pinpress as pp
from pinpress.accuracy.scenes import SCENES, SPEED_LAW, build_scene
from pinpress.accuracy.work_precision import Contest, Group, Measurement, WorkPrecision, flywheel_inertia, hold
from pinpress.common.results import Records
from pinpress.pin_table import templates

ROOT = Path(__file__).resolve().parents[3]
VIZ = ROOT / "viz"
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


PROGRAMS = (  # words, and methods without versions, of which the first one that a linkage has counts
    ("pinpress", ("plane", "space")),
    ("hand script, NumPy", ("hand script",)),
    ("Pinocchio, a loop in C++", ("Pinocchio in C++",)),
    ("MuJoCo, loops in NumPy", ("MuJoCo + NumPy",)),
    ("Drake, loops in NumPy", ("Drake + NumPy",)),
    ("Exudyn", ("Exudyn",)),
)


def in_short() -> str:
    """The table of the README: time and error of a turn of each linkage, a program a row."""
    lines = [f"| a turn, all forces | {' | error | '.join(LINKAGES.values())} | error |", "|---" * (1 + 2 * len(LINKAGES)) + "|"]
    for words, turning in [*PROGRAMS, (NAMES["pinocchio"], ("pinocchio",))]:
        cells = itertools.chain(*(("", "") if row is None else (_time(row), _largest_error(row)) for row in _rows_of_turns(turning)))
        lines.append(f"| {words} | {' | '.join(cells)} |")
    return "\n".join(lines)


def in_paper() -> str:
    """The table of the article: a turn of each linkage, a program a row."""
    lines = [f"| program | {' | '.join(LINKAGES.values())} |", "|---" * (1 + len(LINKAGES)) + "|"]
    return "\n".join([*lines, *(f"| {words} | {' | '.join(_turns(turning))} |" for words, turning in PROGRAMS)])


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
    with (VIZ / file).open(newline="", encoding="utf-8") as opened:
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


def measure(press: pp.Linkage, speed: float, scenes: tuple[str, ...], repeats: int) -> tuple[WorkPrecision, dict[str, str]]:
    """All engines, methods and programs for a press, and what programs cannot do.

    Args:
        press: the press.
        speed: speed of the crank [rad/s].
        scenes: scenes to simulate, among `SCENES` and `on_springs.SPRINGS`.
        repeats: number of rounds of timing.
    """
    inertia, duration = flywheel_inertia(press), 4 * math.pi / abs(speed)
    peers, skipped = contests.find_peers(press)
    solvers, missing = contests.find_solvers(press)
    skipped += missing
    entered: list[Contest] = [contests.turn_beside_peers(press, speed, POINTS, peers)]
    for name in (scene for scene in SCENES if scene in scenes):
        contest, lines = contests.run_beside_peers(press, build_scene(press, name, speed, inertia, duration), peers, solvers)
        entered.append(contest)
        skipped += lines
    if on_springs.SPRINGS in scenes:
        contest, lines = on_springs.springs_contest(on_springs.build_springs_scene(press, speed, inertia))
        entered.append(contest)
        skipped += lines
    proximal = contests.proximal_contest(press, speed, inertia)
    if isinstance(proximal, str):
        skipped.append(proximal)
    else:
        entered.append(proximal)
    entered.append(contests.table_contest(press))
    cannot = {"plane": "linkages in space"} | {peer.name: peer.cannot for peer in peers}
    return hold(press, f"{speed / pp.RPM:g} r/min", entered, skipped, repeats), cannot


def write(measured: WorkPrecision, cannot: dict[str, str], path: Path) -> None:
    """The measurements as a CSV file, with what each program cannot do."""
    rows = [{**m.row(), "cannot": cannot.get(m.method, "")} for m in measured.measurements]
    with path.open("w", newline="", encoding="utf-8") as opened:
        file = csv.DictWriter(opened, list(rows[0]))
        file.writeheader()
        file.writerows(rows)


def picture() -> None:
    """viz/accuracy.png from viz/accuracy.csv: a panel for the turn and for each scene."""
    from light import light  # type: ignore[import-not-found]  # a script of viz

    rows = [row for row in rows_of(SIX_BAR) if row["group"] not in (contests.PROXIMAL, contests.TABLE)]
    groups, measurements = {}, []
    for name in dict.fromkeys(row["group"] for row in rows):
        drawn = "force_error" if name in (SPEED_LAW, on_springs.SPRINGS) else "error"
        least = min(float(row["error"]) for row in rows if row["group"] == name and row["error"])
        groups[name] = Group("", "", "", least, "", drawn)
    for row in rows:
        errors = (float(row[name]) if row[name] else None for name in ("error", "force_error"))
        measurements.append(Measurement(row["group"], row["method"], row["setting"], None, _seconds(row), *errors))
    measured = WorkPrecision("ZXN2-3000(B)", f"70 r/min, {TURN}", "", groups, Records(Measurement, measurements), ())
    light(pp.plots.save(pp.accuracy.plot(measured), VIZ / "accuracy.png"))


def main(quick: bool = False) -> None:
    """Measure and write; ``quick``: a turn of the six-bar beside its programs and the two contests of settings, once, printed alone."""
    if quick:
        print(measure(pp.load("zxn2_3000b"), 70 * pp.RPM, (), 1)[0])
        return
    bricard = pp.load(ROOT / "tests" / "benchmarks" / "peers" / "bricard.urdf")
    rssp = pp.build(Path(templates.__file__).with_name("rssp.yaml"))
    everything = (*SCENES, on_springs.SPRINGS)
    for file, press, speed, scenes in ((SIX_BAR, pp.load("zxn2_3000b"), 70, everything), (RSSP, rssp, 60, ()), (BRICARD, bricard, 300, ())):
        measured, cannot = measure(press, speed * pp.RPM, scenes, 4)
        write(measured, cannot, VIZ / file)
        print(f"{measured}\n")
    rows_of.cache_clear()
    picture()
    put_into_pages()


if __name__ == "__main__":
    sys.path.insert(0, str(VIZ))
    if sys.argv[1:] == ["pages"]:
        picture()
        put_into_pages()
    else:
        main()
