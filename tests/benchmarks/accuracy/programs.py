"""Error against run time of three linkages, pinpress and other programs; in a few minutes, with plots, peers, drake and C++ installed.

It writes accuracy.csv, of the six-bar press, accuracy_rssp.csv and accuracy_bricard.csv in viz; `program_tables` makes picture and tables
of them.
"""

import csv
import math
from pathlib import Path

from benchmarks.accuracy import contests, on_springs, program_tables

import pinpress as pp
from pinpress.accuracy.scenes import SCENES, build_scene
from pinpress.accuracy.work_precision import Contest, WorkPrecision, flywheel_inertia, hold
from pinpress.pin_table import templates

POINTS = 360


def main(quick: bool = False) -> None:
    """Measure and write; ``quick``: a turn of the six-bar beside its programs and the two contests of settings, once, printed alone."""
    six_bar = pp.load("zxn2_3000b")
    if quick:
        print(measure(six_bar, 70 * pp.RPM, (), 1)[0])
        return
    rssp = pp.build(Path(templates.__file__).with_name("rssp.yaml"))
    bricard = pp.load(Path(__file__).parents[1] / "peers" / "bricard.urdf")
    presses = ((six_bar, 70, (*SCENES, on_springs.SPRINGS)), (rssp, 60, ()), (bricard, 300, ()))
    for file, (press, speed, scenes) in zip(program_tables.LINKAGES, presses, strict=True):
        measured, cannot = measure(press, speed * pp.RPM, scenes, 4)
        print(f"{measured}\n")
        rows = [{**m.row(), "cannot": cannot.get(m.method, "")} for m in measured.measurements]
        with (program_tables.VIZ / file).open("w", newline="", encoding="utf-8") as opened:
            writer = csv.DictWriter(opened, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)


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
    entered: list[Contest] = [contests.turn_beside_peers(press, speed, POINTS, peers)]
    held = [
        contests.run_beside_peers(press, build_scene(press, name, speed, inertia, duration), peers) for name in SCENES if name in scenes
    ]
    if on_springs.SPRINGS in scenes:
        held.append(on_springs.springs_contest(on_springs.build_springs_scene(press, speed, inertia)))
    for contest, lines in held:
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
