"""Time of finding masses and friction from two minutes of record at 1 kHz: processor time of one process, the least of several calls.
How often 95 % intervals hold the truth, of presses and encoders' zeros drawn from the prior, 15 s of record with 1 % noise.

python tests/benchmarks/speed/identification.py
"""

import sys
import warnings
from dataclasses import replace
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
import numpy as np
from benchmarks import stopwatch
from support.presses.measured_presses import columns, drawn, drive, press_of, run

from pinpress import measured
from pinpress.measured.regressor import inertial_equations

TIMES, PRESSES = 3, 40
DRAWN = ("zxn2_3000b", "jf75g_125")  # whose intervals are tried
STROKES = {"zxn2_3000b": (30, 50, 70), "jf75g_125": (100, 200, 300), "rssp": (40, 80, 120)}
KINDS = {"crank and gibs, cylinder": (("crank", "gibs"), True), "crank, pins and guide, cylinder": (("crank", "pins", "slide_guide"), True)}


def records(name: str) -> list[measured.MeasuredRun]:
    """Three runs of 40 s at 1 kHz."""
    rng = np.random.default_rng(0)
    masses = drawn(name, rng)
    torques = [columns(name, strokes, (), False, 40.0, 1000.0) @ masses for strokes in STROKES[name]]
    rubbing, noise = (share * max(np.abs(torque).max() for torque in torques) for share in (0.02, 0.01))
    return [
        run(drive(strokes, 40.0, 1000.0), torque + rubbing, rng, noise, 8192)
        for strokes, torque in zip(STROKES[name], torques, strict=True)
    ]


def coverage(name: str) -> str:
    """Shares of masses, inertias, losses and zeros that are within their intervals, and the median deviation of the zero."""
    press, inside, zeros = press_of(name), [], []
    names = [each.name for each in inertial_equations(press).parameters]
    for seed in range(PRESSES):
        rng = np.random.default_rng(seed)
        masses, zero, runs = drawn(name, rng), rng.normal(scale=0.1), []
        torques = [columns(name, strokes, (), False) @ masses for strokes in STROKES[name]]
        size = max(np.abs(torque).max() for torque in torques)
        for strokes, torque in zip(STROKES[name], torques, strict=True):
            made = run(drive(strokes), torque + 0.02 * size, rng, 0.01 * size, 8192)
            runs.append(replace(made, angle=made.angle + zero))
        found = measured.identify(press, runs, friction=("crank",))
        truth = dict(zip(names, masses, strict=True)) | {"encoder zero": zero}
        inside += [low <= truth[each] <= high for each, (low, high) in found.intervals.items() if each in truth]
        zeros.append(next(each.posterior for each in found.parameters if each.name == "encoder zero"))
    share, deviation = 100 * np.mean(inside), np.degrees(np.median(zeros))
    return f"{share:.1f} % of {len(inside)} values within 95 % intervals, encoder's zero ±{1.96 * deviation:.2g} deg"


QUICK = {"TIMES": 1, "PRESSES": 1, "STROKES": {"jf75g_125": STROKES["jf75g_125"]}, "DRAWN": ["jf75g_125"]}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    for name in STROKES:
        press, runs = press_of(name), records(name)
        for words, (friction, cylinder) in KINDS.items():
            (seconds,) = stopwatch.least([partial(measured.identify, press, runs, friction=friction, cylinder=cylinder)], TIMES)
            print(f"{name:12} {words:34} {seconds:6.2f} s")

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name in DRAWN:
            print(f"{name:12} {coverage(name)}")


if __name__ == "__main__":
    main()
