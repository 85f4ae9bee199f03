"""Error against run time of the six-bar press, pinpress and its peers: the tables and the picture of docs/accuracy.md.

Run `python viz/accuracy.py` (with `pip install -e '.[plots,peers]'`): in a few minutes it writes accuracy.csv and accuracy.png beside
itself and prints the table. The page's tables are made from that file, so that both are of one run.
"""

import csv
from pathlib import Path

import pinpress as pp

HERE = Path(__file__).resolve().parent
WANTED = (1e-6, 1e-9)  # errors of a run that are asked for: of the crank angle [rad], or of a peak force
AT_WORK = {"clutch and blanking": "error", "elastic die": "error", "stiff speed law": "force_error"}  # scene -> error that is asked for
NAMES = {  # method -> what the table calls it
    "plane": "`pinpress`, engine `plane`",
    "pinocchio": "`pinpress`, engine `pinocchio`",
    "reduced": "`pinpress`, `reduced`",
    "reduced, its table anew": "`pinpress`, `reduced`, its table made anew",
    "implicit": "`pinpress`, `implicit`",
    "constraint": "`pinpress`, `constraint`",
    "reduced, Runge-Kutta 4": "`pinpress`, `reduced`, Runge-Kutta 4",
    "constraint, Runge-Kutta 4": "`pinpress`, `constraint`, Runge-Kutta 4",
    "hand script": "hand script, batched NumPy",
}


def table(path: Path = HERE / "accuracy.csv") -> str:
    """The page's tables from a file that `WorkPrecision.to_csv` has written: inverse dynamics, then the least times of runs."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    turn = [row for row in rows if row["group"] == "inverse dynamics"]
    least = min(float(row["seconds [s]"]) for row in turn)
    lines = ["| inverse dynamics, 360 crank angles | time | | torque error | force error |", "|---|---|---|---|---|"]
    for row in sorted(turn, key=lambda row: float(row["seconds [s]"])):
        seconds = float(row["seconds [s]"])
        errors = f"{float(row['error']):.0e} | {float(row['force_error']):.0e}"
        lines.append(f"| {_name(row)} | {_milliseconds(seconds)} | {_times(seconds / least)} | {errors} |")
    runs = [row for row in rows if row["group"] == "free run" and row["error"]]
    best = {wanted: _fastest(runs, wanted) for wanted in WANTED}
    heads = " | ".join(f"to {wanted:.0e} rad | force error | loop gap" for wanted in WANTED)
    lines += ["", f"| free run of two turns, least time | {heads} |", "|---" * (1 + 3 * len(WANTED)) + "|"]
    order = sorted(best[WANTED[0]], key=lambda method: float(best[WANTED[0]][method]["seconds [s]"]))
    for method in order:
        cells = []
        for wanted in WANTED:
            reached = best[wanted].get(method)
            if reached is None:
                cells += ["not reached", "", ""]
            else:
                cells += [
                    _milliseconds(float(reached["seconds [s]"])),
                    f"{float(reached['force_error']):.0e}",
                    f"{float(reached['loop_gap [m]']):.0e} m" if reached["loop_gap [m]"] else "",
                ]
        lines.append(f"| {_name({'method': method})} | " + " | ".join(cells) + " |")
    return "\n".join([*lines, "", *_at_work(rows)])


def _at_work(rows: list[dict[str, str]]) -> list[str]:
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
        cells = [
            _milliseconds(float(best[method]["seconds [s]"])) if method in best else _missing(rows, scene, method)
            for (scene, _), best in found.items()
        ]
        lines.append(f"| {_name({'method': method})} | {' | '.join(cells)} |")
    return lines


def _missing(rows: list[dict[str, str]], scene: str, method: str) -> str:
    return "not reached" if any(row["group"] == scene and row["method"] == method for row in rows) else "left out"


def _fastest(rows: list[dict[str, str]], wanted: float, by: str = "error") -> dict[str, dict[str, str]]:
    """Of every method the fastest row with an error not above the wanted one."""
    best: dict[str, dict[str, str]] = {}
    for row in sorted(rows, key=lambda row: float(row["seconds [s]"])):
        if float(row[by]) <= wanted:
            best.setdefault(row["method"], row)
    return best


def _name(row: dict[str, str]) -> str:
    return NAMES.get(row["method"], row["method"])


def _milliseconds(seconds: float) -> str:
    return f"{1e3 * seconds:.3g} ms"


def _times(ratio: float) -> str:
    return "" if ratio == 1 else f"{ratio:.3g} times" if ratio < 100 else f"{ratio:.0f} times"


if __name__ == "__main__":
    from light import light  # type: ignore[import-not-found]  # beside this script

    measured = pp.accuracy.compare(pp.load("zxn2_3000b"), speed=70 * pp.RPM, repeats=4)
    measured.to_csv(HERE / "accuracy.csv")
    light(pp.plots.save(pp.accuracy.plot(measured), HERE / "accuracy.png"))
    print(f"{measured}\n\n{table()}")
