"""The tables and the picture of docs/servo.md: best motions of servo presses beside those that engineers know, and gear ratios."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from make import DOCS, VIZ, write
from support import markdown

import pinpress as pp
from pinpress import servo
from pinpress.loads import DeepDrawing, ForceStroke


class Case(NamedTuple):
    """A press with its work.

    Attributes:
        words: what it does.
        press: name or path of the press.
        inertia: of the drive at the crank [kg m2].
        load: the process.
        time: of a cycle [s].
        path: where the crank goes.
        limits: what the motion keeps.
    """

    words: str
    press: str | Path
    inertia: float
    load: DeepDrawing | ForceStroke
    time: float
    path: servo.Turn | servo.Stop
    limits: Sequence[servo.SlideSpeed]


CASES = {
    "A": Case(
        "zxn2_3000b draws 1.5 MN over 60 mm, 25/min, at most 0.2 m/s",
        "zxn2_3000b",
        800.0,
        DeepDrawing(1.5e6, 0.06),
        60 / 25,
        servo.Turn(),
        [servo.SlideSpeed(0.2, (0.06, 0.0))],
    ),
    "B": Case(
        "the tour's knuckle press coins, 1 s, rests 0.15 s at bottom",
        DOCS / "tour" / "knuckle.urdf",
        10.0,
        ForceStroke([0.002, 0.001, 0.0005, 0.0], forces=[0.0, 0.30e6, 0.70e6, 1.60e6]),
        1.0,
        servo.Stop(bottom=0.15),
        [],
    ),
}


def motions(case: Case) -> tuple[servo.MotionOptimum, dict[str, servo.ServoMotion]]:
    """The best motion of a case, and those that engineers know."""
    press, drive = pp.load(case.press), servo.ServoDrive(inertia=case.inertia, copper=1e-5, regeneration=0.0)
    best = servo.best_motion(press, drive, [case.load], time=case.time, path=case.path, limits=case.limits)
    return best, servo.ready_motions(press, drive, [case.load], time=case.time, path=case.path, limits=case.limits)


def table() -> str:
    """The tables of all cases; torques at the crank."""
    tables = []
    for case in CASES.values():
        best, ready = motions(case)
        rows = []
        for row in servo.compare_motions({"least heat": best.motion, **ready}, case.limits).rows:
            more = "" if row.more_than_least is None or row.breaks else f"{100 * row.more_than_least:+.1f} %"
            speed = f"{float(row.breaks.rpartition(' ')[2]):.2g} m/s" if row.breaks else ""
            rows.append(
                (row.name, f"{1e-3 * row.rms_torque:.4g}", more, f"{1e-3 * row.peak_torque:.3g}", f"{1e-3 * row.peak_power:.3g}", speed)
            )
        heads = ("motion", "rms [kN m]", "beside the best", "peak [kN m]", "power [kW]", "slide")
        tables += [f"{case.words}:", markdown.table(heads, rows)]
    return "\n\n".join(tables)


def ratios() -> str:
    """What gear ratios make of two rotors."""
    case, rows = CASES["A"], []
    for inertia in (6.0, 2.0):
        drives = [servo.ServoDrive(inertia=inertia, ratio=ratio, gear_inertia=50.0) for ratio in (40.0, 60.0, 100.0)]
        given = {"time": case.time, "path": case.path, "limits": case.limits}
        found = [servo.best_motion(pp.load(case.press), drive, [case.load], **given).motion for drive in drives]
        rows.append((f"{inertia:g} kg m2", *(f"{motion.rms_motor_torque:.0f} N m" for motion in found)))
    return markdown.table(("rotor", "40", "60", "100"), rows)


def main(quick: bool = False) -> None:
    """Print the tables and draw the picture; ``quick``: the picture alone."""
    if not quick:
        print(table(), ratios(), sep="\n\n")
    best, ready = motions(CASES["A"])
    print(servo.capacitor(best.motion))
    charts = "height", "crank_speed", "torque", "power"
    write(VIZ / "servo.png", pp.plots.draw({"least heat": best.motion, **ready}, *charts))
