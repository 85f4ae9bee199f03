"""From a description to forces: lines and seconds for five presses as pin tables, the other formats that are read, and what is said to
everyday mistakes.

Run `python tests/benchmarks/speed/descriptions.py`; pytest does not collect this file. Lines are those of the table without
comments. Forces are the driving torque and every bearing force at 360 crank angles, at 60 r/min, with the walk through the turn that
the first motion of a press needs.
"""

import statistics
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks import stopwatch
from support import mistakes
from support.generators.other_formats import FORMATS, Press

import pinpress as pp
from pinpress.pin_table import templates

REPEATS = 5
TEMPLATES = Path(templates.__file__).parent
SHIPPED = Path(__file__).resolve().parents[3] / "urdf"
PRESSES = {
    "six-bar press": SHIPPED / "zxn2_3000b.yaml",
    "press with a knuckle": TEMPLATES / "knuckle.yaml",
    "press with a link drive": TEMPLATES / "link-drive.yaml",
    "drawing press, eight bars": TEMPLATES / "drawing-8-bar.yaml",
    "spatial press, balls at its rod": TEMPLATES / "rssp.yaml",
}
FIRST = """
import sys, time
start = time.perf_counter()
import pinpress as pp
press = pp.build(sys.argv[1])
pp.inverse_dynamics(press, pp.cycle(press, speed=60 * pp.RPM, points=360))
print(time.perf_counter() - start)
"""


QUICK = {
    "REPEATS": 1,
    "PRESSES": {"six-bar press": PRESSES["six-bar press"]},
    "FORMATS": {"drake": FORMATS["drake"]},
}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    print("| pin table | lines | bearings | table to press | all forces | both in a new process, imports included |")
    print("|---|---|---|---|---|---|")
    for name, table in PRESSES.items():
        press = pp.build(table)
        built = least(lambda table=table: pp.build(table))
        forces = least(lambda table=table: all_forces(pp.build(table))) - built
        first = statistics.median(
            float(subprocess.run([sys.executable, "-c", FIRST, str(table)], capture_output=True, text=True, check=True).stdout)
            for _ in range(REPEATS)
        )
        print(f"| {name} | {lines(table)} | {len(press.bearings)} | {1e3 * built:.0f} ms | {1e3 * forces:.1f} ms | {first:.2f} s |")

    print("\n| format | presses read | largest difference of a force from ours, relative | time to load, ours is 1 |")
    print("|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name, (write, ending) in FORMATS.items():
            differences, ratios = [], []
            for shipped in pp.presses():
                source = Press(pp.load(shipped).text.decode())
                ours, theirs = Path(folder) / "ours.urdf", Path(folder) / f"theirs.{ending}"
                ours.write_text(source.urdf(), encoding="utf-8")
                theirs.write_text(write(source), encoding="utf-8")
                expected = all_forces(pp.load(ours))
                differences.append(float(np.abs(all_forces(loaded(theirs)) - expected).max() / np.abs(expected).max()))
                ratios.append(least(lambda theirs=theirs: loaded(theirs)) / least(lambda ours=ours: pp.load(ours)))
            print(f"| {name} | {len(differences)} of {len(pp.presses())} | {max(differences):.0e} | {statistics.median(ratios):.1f} |")

    files = [file for right in (mistakes.TABLE, mistakes.URDF) for file in mistakes.files(right)]
    said = {file: " ".join(mistakes.said(file)).replace(str(file), f"press{file.suffix}") for file in files}
    print(f"\n| file of tests/mistakes | what is said: to {sum(map(bool, said.values()))} of {len(files)} |\n|---|---|")
    print("\n".join(f"| {file.name} | {words} |" for file, words in said.items()))


def lines(table: Path) -> int:
    """Number of lines that are neither empty nor comments."""
    text = table.read_text(encoding="utf-8")
    return sum(bool(line.strip()) and not line.lstrip().startswith("#") for line in text.splitlines())


def loaded(file: Path) -> Any:
    """The press of a file whose format may hold what a rigid pin leaves out, which a warning says."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pp.load(file)


def all_forces(press: Any) -> np.ndarray:
    """Driving torque and the forces of all bearings, (360, 1 + 3 bearings), bearings by their names."""
    reactions = pp.inverse_dynamics(press, pp.cycle(press, speed=60 * pp.RPM, points=360))
    forces = [reactions.bearing_force[name] for name in sorted(press.bearings)]
    return np.hstack([np.reshape(reactions.driving_torque, (360, -1)), *forces])


def least(work: Callable[[], object]) -> float:
    """Least time of a call [s]."""
    return stopwatch.least([work], REPEATS)[0]


if __name__ == "__main__":
    main()
