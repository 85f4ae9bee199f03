"""One state of a press: by the engine, from its table in Python, and in compiled C; largest errors beside the times.

Times are of one state with all bearing forces, and of the equation of motion alone. C is compiled by gcc at -O3. The second table has what
in pinpress asks for many states: how much of its time the press takes, so how much faster it would be if the press took none.
"""

import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

import numpy as np
from benchmarks.stopwatch import least, table

import pinpress as pp
from pinpress.common.quantities import Values
from pinpress.live.pictures import Operation, picture
from pinpress.simulation.over_time.equations_of_motion import ReducedDynamics
from pinpress.simulation.reduced_model import reduced_model_of

CALLS = 1000  # that the clock takes together
ONE = np.array([1.2])  # an angle
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


def many(call: Callable[[], object]) -> Callable[[], object]:
    return lambda: [call() for _ in range(CALLS)]


def compiled(made: pp.export.PressTable, count: int) -> tuple[float, float]:
    """Seconds of a state and of an equation of motion in C."""
    with tempfile.TemporaryDirectory() as folder:
        pp.export.c_code(made, Path(folder, "press.c"))
        Path(folder, "main.c").write_text(PROGRAM, encoding="utf-8")
        command = ["gcc", "-std=gnu99", "-O3", f"-DCOUNT={count}", "press.c", "main.c", "-o", "program"]
        subprocess.run(command, cwd=folder, check=True)
        runs = [subprocess.run([Path(folder, "program")], capture_output=True, check=True).stdout.split() for _ in range(5)]
    state, equation, _ = np.array(runs, float).min(axis=0)
    return 1e-9 * state, 1e-9 * equation


@dataclass(frozen=True)
class Controller(pp.drives.SpeedTorqueDrive):
    """A controller of the speed with an integral part, as a user writes one."""

    inertia: float = 500.0
    rated_torque: None = None
    timed: bool = True
    state: tuple[float, ...] = (0.0,)

    def torque(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> Values:
        return 1e4 * (7.0 - speed) + 2e4 * state[0]

    def rates(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> tuple[Values, ...]:
        return (7.0 - speed,)


def shares(quick: bool) -> list[tuple[str, ...]]:
    """Rows of what asks for many states: its name, seconds, states, and how much faster it were without the press."""
    press, duration, repeats = pp.load(PRESSES[0]), 0.05 if quick else 4.0, 1 if quick else 3
    times, loads = np.linspace(0.0, duration, 4 if quick else 41), [pp.loads.Blanking(1e6, 0.006, 0.002)]
    servo = pp.drives.ServoMotor(times, 7 * times + 0.5 * np.sin(7 * times), stiffness=2e6, damping=2e5, peak_torque=1e6, inertia=60.0)
    dynamics = ReducedDynamics(reduced_model_of(press))
    state = least([many(lambda: dynamics.at(np.array([1.2]), np.array([7.3])))], 10 * repeats)[0] / CALLS
    rows = []
    for name, drive, speed in (("servo motor", servo, {}), ("controller as a drive", Controller(), {"speed": 5.0})):

        def run(drive=drive, speed=speed):
            return pp.simulate(press, duration, drive=drive, loads=loads, **speed)

        with mock.patch.object(ReducedDynamics, "at", autospec=True, side_effect=ReducedDynamics.at) as at:
            run()
        [whole] = least([run], repeats)
        rows.append((f"{name}, {duration:g} s", whole, at.call_count, at.call_count * state))
    operation, motion = Operation(7.0, (), {}, {}), pp.cycle(press, 7.0, points=180)
    links = picture(press, operation, None, first=True).links
    whole, moved, loaded = least(
        [lambda: picture(press, operation, links), lambda: pp.cycle(press, 7.0, points=180), lambda: pp.inverse_dynamics(press, motion)],
        10 * repeats,
    )
    rows.append(("picture of the live window", whole, 180, moved + loaded))
    return [
        (name, f"{1e3 * whole:.3g}", f"{count}", f"{1e3 * part:.2g}", f"{whole / (whole - part):.2f}") for name, whole, count, part in rows
    ]


def main(quick: bool) -> None:
    repeats, count, rows = (2, 10_000, []) if quick else (300, 2_000_000, [])
    for name in PRESSES:
        press = pp.load(name)
        made = pp.export.tabulate(press)
        [engine] = least([lambda press=press: pp.inverse_dynamics(press, pp.servo_cycle(press, ONE, speed=7.3, acceleration=0.0))], repeats)
        calls = [lambda made=made: made.at(1.2, 7.3, 0.0, force=1e5), lambda made=made: made.acceleration(1.2, 7.3, 100.0, 1e5)]
        state, equation = (seconds / CALLS for seconds in least([*map(many, calls)], repeats // 10 + 1))
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
    print()
    print(table(["", "whole [ms]", "states", "press [ms]", "times faster without it"], shares(quick)))
