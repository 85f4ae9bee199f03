"""Forward dynamics: error against run time of everything there is, a plain Pinocchio loop beside it, and many scenarios against one.

Run `python tests/benchmarks/benchmark_simulation.py`; `--quick` for a fifth of the repeats. pytest does not collect this file. The
contestants
take turns, so that whatever else the machine does meets all of them; the least time counts. Wall times include everything from the loaded
press, whose assembly has been followed, to a `Run` with its states, accelerations and checks (of the plain loop: to the last state alone).
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.oracles.pinocchio_run import free_run

import pinpress as pp
from pinpress.accuracy.contests import least_seconds
from pinpress.simulation.reduced_model import reduced_model_of

ANGLE, SPEED, DURATION = np.radians(154.0), 70 * pp.RPM, 2.0
FLYWHEEL = pp.drives.Flywheel(inertia=500.0)
WANTED = 1e-6  # [rad]
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 3e-7, 1e-7, 3e-8, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4)

Contestant = tuple[str, Callable[[], float]]


def least(contestants: list[Contestant], repeats: int) -> list[tuple[str, float, float]]:
    """Name, result and least seconds of every contestant, in turn, again and again."""
    works = [work for _, work in contestants]
    results = [work() for work in works]
    return [(name, *each) for (name, _), *each in zip(contestants, results, least_seconds(works, repeats), strict=True)]


def six_bar(press: pp.Linkage, fresh: bool = False, **how: Any) -> float:
    """Crank angle at the end of the free run; ``fresh``: with its table made anew."""
    if fresh:
        press.__dict__.pop("table", None)
    run = pp.simulate(press, DURATION, speed=SPEED, angle=ANGLE, flywheel=FLYWHEEL, **how)
    return float(run.crank_angle[-1])


def work_precision(press: pp.Linkage, truth: float, repeats: int) -> None:
    """Error against run time of both methods and of the fixed-step method, and what it takes to reach the wanted error."""
    print(f"\nZXN2-3000(B), free run of 2 s, J0 = 500 kg m2, from 154 deg at 70 r/min: error of the last crank angle, {truth:.10f} rad")
    entries: list[Contestant] = []
    for method in ("reduced", "constraint"):
        entries += [
            (f"{method}, tolerance {t:.0e}", lambda t=t, m=method: six_bar(press, method=m, tolerance=t)) for t in TOLERANCES if t <= 1e-2
        ]
        entries += [(f"{method}, RK4 {1e3 * h:g} ms", lambda h=h, m=method: six_bar(press, method=m, step=h)) for h in STEPS]
    entries += [
        (f"plain Pinocchio loop, RK4 {1e3 * DURATION / n:.3g} ms", lambda n=n: free_run(ANGLE, SPEED, 500.0, DURATION, n)[0])
        for n in (100, 200, 400, 800)
    ]
    entries += [("reduced with its table, default", lambda: six_bar(press, fresh=True))]
    found = [(name, abs(angle - truth), seconds) for name, angle, seconds in least(entries, repeats)]
    for name, error, seconds in found:
        print(f"  {name:40} {error:9.1e} rad {1e3 * seconds:9.2f} ms")
    print(f"\nleast time for an error below {WANTED:g} rad")
    for kind in (
        "reduced with its table",
        "reduced, tolerance",
        "reduced, RK4",
        "constraint, tolerance",
        "constraint, RK4",
        "plain Pinocchio loop",
    ):
        good = [(seconds, error, name) for name, error, seconds in found if name.startswith(kind) and error < WANTED]
        if good:
            seconds, error, name = min(good)
            print(f"  {name:40} {error:9.1e} rad {1e3 * seconds:9.2f} ms")


def scenarios(repeats: int) -> None:
    """1000 scenarios against one."""
    press = pp.load("jf75g_125", gravity=(0, 0, -9.80665))
    _ = reduced_model_of(press)
    random = np.random.default_rng(0)
    speed, inertia, force = 300 * pp.RPM * random.uniform(0.9, 1.1, 1000), random.uniform(100, 200, 1000), random.uniform(0, 1250e3, 1000)
    power = random.uniform(30e3, 60e3, 1000)

    def blanking(size: Any) -> list[Any]:
        return [pp.loads.Blanking(size, 0.010, 0.005)]

    def motor(size: Any) -> Any:
        return pp.drives.Geared(pp.drives.InductionMotor(size, 1465 * pp.RPM), 4.9)

    cases: list[tuple[str, Callable[[Any], dict[str, Any]]]] = [
        ("free run: speeds, flywheels", lambda s: {}),
        (
            "567 N m and blanking: speeds, flywheels, forces",
            lambda s: {"drive": pp.drives.ConstantTorque(567.0), "loads": blanking(force[s])},
        ),
        ("motor and blanking: speeds, flywheels, powers, forces", lambda s: {"drive": motor(power[s]), "loads": blanking(0.2 * force[s])}),
    ]
    print("\nJF75G-125, 2 s (10 strokes), 121 states: 1000 scenarios together against one")
    for name, more in cases:

        def run(which: Any, more: Callable[[Any], dict[str, Any]] = more) -> Any:
            function = pp.simulate if isinstance(which, int) else pp.simulate_batch
            return function(
                press, 2.0, speed=speed[which], flywheel=pp.drives.Flywheel(inertia[which]), points=121, **more(which)
            ).crank_angle

        one: Contestant = ("one", lambda run=run: float(run(0)[-1]))
        many: Contestant = ("many", lambda run=run: float(run(slice(None))[-1, 0]))
        (_, first, alone), (_, same, together) = least([one, many], repeats)
        print(f"  {name:56} {1e3 * alone:7.2f} ms {1e3 * together:8.1f} ms, ratio {together / alone:5.1f}, differ {abs(first - same):.0e}")


def long_runs(repeats: int) -> None:
    """A minute under the slip clutch, its steady state found directly, and energies of very long free runs."""
    press = pp.load("jf75g_125", gravity=(0, 0, -9.80665))
    flywheel, loads = pp.drives.Flywheel(136.0), [pp.loads.Blanking(1250e3, 0.010, 0.005)]
    drive = pp.drives.Geared(pp.drives.SlipClutchMotor(189.0, 1470 * pp.RPM, 1320 * pp.RPM, 900 * pp.RPM), 3.0)
    runs: dict[str, Any] = {}

    def minute() -> float:
        runs["minute"] = pp.simulate(press, 60.0, speed=300 * pp.RPM, drive=drive, flywheel=flywheel, loads=loads)
        return 0.0

    def steady() -> float:
        runs["steady"] = pp.steady_state(press, 300 * pp.RPM, drive=drive, flywheel=flywheel, loads=loads)
        return 0.0

    (_, _, long), (_, _, direct) = least([("minute", minute), ("steady", steady)], repeats)
    last, period = pp.measures.stroke_duties(runs["minute"])[-1], pp.measures.duty_cycle(runs["steady"])
    apart, slower = abs(last.duration - period.duration), abs(last.lowest_speed - period.lowest_speed)
    print("\nJF75G-125, slip-clutch motor, 1250 kN blanking, 300 strokes/min")
    print(f"  60 s, {len(runs['minute'].time)} states: {long:.2f} s, energy error {runs['minute'].stats.energy_error:.1e}")
    print(f"  steady state directly: {1e3 * direct:.1f} ms; its period differs from the minute's last stroke by {apart:.0e} s,")
    print(f"  its lowest speed by {slower:.0e} rad/s; work of drive and load there {last.drive_work:.6f} and {last.load_work:.6f} J")
    start = time.perf_counter()
    free = pp.simulate(press, 2000.0, speed=300 * pp.RPM, flywheel=flywheel, points=1000)
    middle = time.perf_counter()
    closed = pp.simulate(press, 20.0, speed=300 * pp.RPM, flywheel=flywheel, method="constraint", points=1000)
    end = time.perf_counter()
    print(f"  {_turns(free)} turns free, reduced: energy error {free.stats.energy_error:.1e}, {middle - start:.1f} s")
    left = closed.stats
    print(f"  {_turns(closed)} turns free, constraint: energy error {left.energy_error:.1e}, gap {left.closure_error:.0e} m,")
    print(f"  {end - middle:.1f} s")
    six = pp.simulate(pp.load("zxn2_3000b"), 8571.0, speed=70 * pp.RPM, flywheel=pp.drives.Flywheel(2000.0), points=1000)
    print(f"  ZXN2-3000(B) from 70 strokes/min, {_turns(six)} turns free, reduced: energy error {six.stats.energy_error:.1e}")


def friction(repeats: int) -> None:
    """What friction in all bearings adds to the time of a run and of a steady state."""
    press = pp.load("zxn2_3000b")
    rubbing = {name: pp.loads.Friction(0.05, None if name == "slide_guide" else 0.06) for name in press.bearings}
    drive = pp.drives.Geared(pp.drives.InductionMotor(75e3, 1485 * pp.RPM, inertia=1.2), 20.7)
    given: dict[str, Any] = {"drive": drive, "flywheel": pp.drives.Flywheel(6000.0), "loads": [pp.loads.DeepDrawing(1e6, 0.010)]}
    print("\nZXN2-3000(B), motor and 1000 kN drawing, 70 strokes/min: without and with friction in all bearings")
    for name, work in (
        ("a run of 3 s", lambda acting: pp.simulate(press, 3.0, speed=70 * pp.RPM, friction=acting, **given)),
        ("over time, 0.5 s", lambda acting: pp.simulate(press, 0.5, speed=70 * pp.RPM, friction=acting, method="implicit", **given)),
        ("the steady state", lambda acting: pp.steady_state(press, 70 * pp.RPM, friction=acting, **given)),
    ):
        runs: dict[str, pp.Run] = {}

        def run(which: str, acting: Any, work: Any = work, runs: dict[str, pp.Run] = runs) -> float:
            runs[which] = work(acting)
            return 0.0

        (_, _, without), (_, _, taken) = least([("", lambda: run("bare", {})), ("", lambda: run("rubbing", rubbing))], repeats)
        error = runs["rubbing"].stats.energy_error
        print(f"  {name:20} {1e3 * without:8.1f} ms {1e3 * taken:8.1f} ms, ratio {taken / without:5.1f}, energy error {error:.0e}")


def _turns(run: pp.Run) -> int:
    return round(float(run.crank_angle[-1]) / (2 * np.pi))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a fifth of the repeats")
    repeats = 2 if parser.parse_args().quick else 10
    press = pp.load("zxn2_3000b")
    _ = press.branch
    truths = [six_bar(press, method=method, tolerance=1e-13) for method in ("reduced", "constraint")]
    print(f"both methods at tolerance 1e-13 differ by {abs(truths[0] - truths[1]):.1e} rad")
    work_precision(press, truths[0], repeats)
    scenarios(max(2, repeats // 3))
    friction(max(2, repeats // 3))
    long_runs(max(2, repeats // 3))


if __name__ == "__main__":
    main()
