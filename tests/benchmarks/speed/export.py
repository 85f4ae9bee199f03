"""One state of a press: by the engine, from its table in Python, and in compiled C; largest errors beside the times.

Times are of one state with all bearing forces, and of the equation of motion alone. C is compiled by gcc at -O3.
"""

import subprocess
import tempfile
from pathlib import Path

import numpy as np
from benchmarks.stopwatch import least, table

import pinpress as pp

PRESSES = ("zxn2_3000b", "jf75g_125_symmetric", "pirica_double_knuckle")
PROGRAM = """
#include <stdio.h>
#include <time.h>
#include "press.h"
static double now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return 1e9 * t.tv_sec + t.tv_nsec; }
int main(void)
{
    double inputs[1] = {1e5}, outputs[PRESS_OUTPUTS], acceleration, sum = 0.0, begin = now(), middle;
    int k;
    for (k = 0; k < COUNT; k++) { press_all(1e-3 * k, 7.0, 1.0, inputs, outputs); sum += outputs[0]; }
    middle = now();
    for (k = 0; k < COUNT; k++) { press_acceleration(1e-3 * k, 7.0, 1.0, inputs, 5.0, &acceleration); sum += acceleration; }
    printf("%g %g %g", (middle - begin) / COUNT, (now() - middle) / COUNT, sum);
    return 0;
}
"""


def compiled(made: pp.export.PressTable, count: int) -> tuple[float, float]:
    """Seconds of a state and of an equation of motion in C."""
    with tempfile.TemporaryDirectory() as folder:
        pp.export.c_code(made, Path(folder, "press.c"))
        Path(folder, "main.c").write_text(PROGRAM, encoding="utf-8")
        command = ["gcc", "-std=gnu99", "-O3", f"-DCOUNT={count}", "press.c", "main.c", "-o", "program"]
        subprocess.run(command, cwd=folder, check=True)
        state, equation, _ = map(float, subprocess.run([Path(folder, "program")], capture_output=True, check=True).stdout.split())
    return 1e-9 * state, 1e-9 * equation


def main(quick: bool) -> None:
    repeats, count, rows = (2, 10_000, []) if quick else (300, 2_000_000, [])
    for name in PRESSES:
        press = pp.load(name)
        made = pp.export.tabulate(press)
        engine, state, equation = least(
            [
                lambda press=press: pp.inverse_dynamics(press, pp.servo_cycle(press, np.array([1.2]), speed=7.3, acceleration=0.0)),
                lambda made=made: made.at(1.2, 7.3, 0.0, force=1e5),
                lambda made=made: made.acceleration(1.2, 7.3, 100.0, 1e5),
            ],
            repeats,
        )
        in_c, equation_in_c = compiled(made, count)
        times = [f"{1e6 * seconds:.3g}" for seconds in (engine, state, equation, in_c, equation_in_c)]
        rows.append((f"`{name}`", *times, f"{max(made.error.values()):.0e}"))
    heads = [
        "us",
        "engine",
        "table, all forces",
        "table, equation of motion",
        "C, all forces",
        "C, equation of motion",
        "largest error found",
    ]
    print(table(heads, rows))
