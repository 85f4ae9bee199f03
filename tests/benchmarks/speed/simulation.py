"""Forward dynamics: error against run time of everything there is, a plain Pinocchio loop beside it, many scenarios against one, what a
tolerance buys, and tables of linkages in space.

Run `python tests/benchmarks/speed/simulation.py`; `--quick` for a fifth of the repeats, `--only tolerances` for one part. pytest does
not collect this file. The contestants take turns, so that whatever else the machine does meets all of them; the least time counts. Wall
times include everything from the loaded press, whose assembly has been followed, to a `Run` with its states, accelerations and checks (of
the plain loop: to the last state alone).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks.stopwatch import least as least_seconds
from benchmarks.stopwatch import once
from support import texts
from support.generators import spatial_linkages
from support.oracles.pinocchio_run import free_run
from support.oracles.six_bar_script import six_bar as hand_script
from support.oracles.six_bar_script import world_forces

import pinpress as pp
from pinpress.linkage.memo import keep_all_but
from pinpress.simulation.reduced_model import reduced_model_of

ANGLE, SPEED, DURATION = np.radians(154.0), 70 * pp.RPM, 2.0
FLYWHEEL = pp.drives.Flywheel(inertia=500.0)
WANTED = 1e-6  # [rad]
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 3e-7, 1e-7, 3e-8, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4)
ASKED = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)  # tolerances of the table of looser ones
SCENARIOS = 1000
LONG, FREE, BY_JOINTS, SIX_BAR = 60.0, 2000.0, 20.0, 8571.0  # runs under a motor, and free ones [s]

Contestant = tuple[str, Callable[[], float]]


def least(contestants: list[Contestant], repeats: int) -> list[tuple[str, float, float]]:
    """Name, result and least seconds of every contestant, in turn, again and again."""
    works = [work for _, work in contestants]
    results = [work() for work in works]
    return [(name, *each) for (name, _), *each in zip(contestants, results, least_seconds(works, repeats), strict=True)]


def without_table(press: pp.Linkage) -> pp.Linkage:
    """The same linkage, followed and all, without its reduced model."""
    same = replace(press)
    keep_all_but(reduced_model_of, same, press)
    return same


def six_bar(press: pp.Linkage, fresh: bool = False, **how: Any) -> float:
    """Crank angle at the end of the free run; ``fresh``: with its table made anew."""
    press = without_table(press) if fresh else press
    run = pp.simulate(press, DURATION, speed=SPEED, angle=ANGLE, flywheel=FLYWHEEL, **how)
    return float(run.crank_angle[-1])


def methods(repeats: int) -> None:
    """Both methods, the fixed steps and a plain loop."""
    press = pp.load("zxn2_3000b")
    _ = press.branch
    truths = [six_bar(press, method=method, tolerance=1e-13) for method in ("reduced", "constraint")]
    print(f"both methods at tolerance 1e-13 differ by {abs(truths[0] - truths[1]):.1e} rad")
    work_precision(press, truths[0], repeats)


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
    speed, inertia, force, power = (
        random.uniform(*ends, SCENARIOS) for ends in ((270 * pp.RPM, 330 * pp.RPM), (100, 200), (0, 1250e3), (30e3, 60e3))
    )

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
    print(f"\nJF75G-125, 2 s (10 strokes), 121 states: {SCENARIOS} scenarios together against one")
    for name, more in cases:

        def run(which: Any, more: Callable[[Any], dict[str, Any]] = more) -> Any:
            function = pp.simulate if isinstance(which, int) else pp.simulate_batch
            return function(
                press, 2.0, speed=speed[which], flywheel=pp.drives.Flywheel(inertia[which]), points=121, **more(which)
            ).crank_angle

        one: Contestant = ("one", lambda run=run: float(run(0)[-1]))
        many: Contestant = ("many", lambda run=run: float(run(slice(None))[-1, 0]))
        (_, first, alone), (_, same, together) = least([one, many], max(2, repeats // 3))
        print(f"  {name:56} {1e3 * alone:7.2f} ms {1e3 * together:8.1f} ms, ratio {together / alone:5.1f}, differ {abs(first - same):.0e}")


def long_runs(repeats: int) -> None:
    """A minute under the slip clutch, its steady state found directly, and energies of very long free runs."""
    press = pp.load("jf75g_125", gravity=(0, 0, -9.80665))
    flywheel, loads = pp.drives.Flywheel(136.0), [pp.loads.Blanking(1250e3, 0.010, 0.005)]
    drive = pp.drives.Geared(pp.drives.SlipClutchMotor(189.0, 1470 * pp.RPM, 1320 * pp.RPM, 900 * pp.RPM), 3.0)
    runs: dict[str, Any] = {}

    def minute() -> float:
        runs["minute"] = pp.simulate(press, LONG, speed=300 * pp.RPM, drive=drive, flywheel=flywheel, loads=loads)
        return 0.0

    def steady() -> float:
        runs["steady"] = pp.steady_state(press, 300 * pp.RPM, drive=drive, flywheel=flywheel, loads=loads)
        return 0.0

    (_, _, long), (_, _, direct) = least([("minute", minute), ("steady", steady)], max(2, repeats // 3))
    last, period = pp.measures.stroke_duties(runs["minute"])[-1], pp.measures.duty_cycle(runs["steady"])
    apart, slower = abs(last.duration - period.duration), abs(last.lowest_speed - period.lowest_speed)
    print("\nJF75G-125, slip-clutch motor, 1250 kN blanking, 300 strokes/min")
    print(f"  {LONG:g} s, {len(runs['minute'].time)} states: {long:.2f} s, energy error {runs['minute'].stats.energy_error:.1e}")
    print(f"  steady state directly: {1e3 * direct:.1f} ms; its period differs from the minute's last stroke by {apart:.0e} s,")
    print(f"  its lowest speed by {slower:.0e} rad/s; work of drive and load there {last.drive_work:.6f} and {last.load_work:.6f} J")
    how: dict[str, Any] = {"speed": 300 * pp.RPM, "flywheel": flywheel, "points": 1000}
    free, of_free = once(partial(pp.simulate, press, FREE, **how))
    closed, of_closed = once(partial(pp.simulate, press, BY_JOINTS, method="constraint", **how))
    print(f"  {_turns(free)} turns free, reduced: energy error {free.stats.energy_error:.1e}, {of_free:.1f} s")
    left = closed.stats
    print(f"  {_turns(closed)} turns free, constraint: energy error {left.energy_error:.1e}, gap {left.closure_error:.0e} m,")
    print(f"  {of_closed:.1f} s")
    six = pp.simulate(pp.load("zxn2_3000b"), SIX_BAR, speed=70 * pp.RPM, flywheel=pp.drives.Flywheel(2000.0), points=1000)
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

        (_, _, without), (_, _, taken) = least([("", lambda: run("bare", {})), ("", lambda: run("rubbing", rubbing))], max(2, repeats // 3))
        error = runs["rubbing"].stats.energy_error
        print(f"  {name:20} {1e3 * without:8.1f} ms {1e3 * taken:8.1f} ms, ratio {taken / without:5.1f}, energy error {error:.0e}")


def tolerances(repeats: int) -> None:
    """What looser tolerances save, and that each holds: time and error of the last crank angle, against a run of all joints over time,
    which has no table, and with friction against the tightest run."""
    six, jf, rssp = pp.load("zxn2_3000b"), pp.load("jf75g_125", gravity=(0, 0, -9.80665)), in_space()["crank, ball-ended rod, slide"]
    motor = pp.drives.Geared(pp.drives.InductionMotor(45e3, 1465 * pp.RPM), 4.9)
    blanking: dict[str, Any] = {"drive": motor, "flywheel": pp.drives.Flywheel(136.0), "loads": [pp.loads.Blanking(2e5, 0.010, 0.005)]}
    rubbing = {name: pp.loads.Friction(0.05, None if name == "slide_guide" else 0.06) for name in six.bearings}
    speeds = 300 * pp.RPM * np.random.default_rng(0).uniform(0.9, 1.1, SCENARIOS)
    speeds[0] = 300 * pp.RPM
    scenes: dict[str, tuple[Callable[..., Any], str]] = {
        "free": (partial(pp.simulate, six, DURATION, speed=SPEED, angle=ANGLE, flywheel=FLYWHEEL), "constraint"),
        "in space": (partial(pp.simulate, rssp, DURATION, speed=10.0, flywheel=pp.drives.Flywheel(1.0)), "constraint"),
        "motor": (partial(pp.simulate, jf, DURATION, speed=300 * pp.RPM, **blanking), "constraint"),
        "friction": (partial(pp.simulate, six, 1.0, speed=SPEED, flywheel=pp.drives.Flywheel(6000.0), friction=rubbing), "reduced"),
        "1000 motors": (partial(pp.simulate_batch, jf, DURATION, speed=speeds, **blanking), "of motor"),
    }
    print("\nfree runs of 2 s of the six-bar, and of a spatial crank, rod with balls and slide; JF75G-125 under a motor and blanking, 2 s;")
    print("six-bar with friction in all bearings, 1 s; 1000 runs as the third: ms, error of the last crank angle [rad]")
    print(f"  {'tolerance':10}" + "".join(f"{name:>20}" for name in scenes))
    truth: dict[str, float] = {}
    for name, (work, judge) in scenes.items():
        truth[name] = truth["motor"] if judge == "of motor" else last(work(tolerance=1e-13 if judge == "reduced" else 1e-12, method=judge))
    for tolerance in ASKED:
        works = [(name, lambda work=work, t=tolerance: last(work(tolerance=t, points=121))) for name, (work, _) in scenes.items()]
        found = [(seconds, abs(angle - truth[name])) for name, angle, seconds in least(works, max(2, repeats // 3))]
        print(f"  {tolerance:<10.0e}" + "".join(f"{1e3 * seconds:10.1f} {error:9.1e}" for seconds, error in found))


def last(run: Any) -> float:
    """The last crank angle of a run, or of the first scenario of a batch."""
    return float(np.ravel(run.crank_angle[-1])[0])


def in_space() -> dict[str, pp.Linkage]:
    return {
        "crank, ball-ended rod, slide": pp.build(Path(pp.__file__).parent / "pin_table" / "templates" / "rssp.yaml"),
        "Bennett, 4 pins": texts.load(spatial_linkages.bennett()),
        "Bricard, 6 pins": texts.load(spatial_linkages.bricard()),
        "welded four-bar": texts.load(spatial_linkages.four_bar("fixed")),
    }


def tables(repeats: int) -> None:
    """Tables of linkages in space and in the plane, and what the reduced equation then takes beside the equations of all joints."""
    print(
        "\nthe table of a press alone; a free run of 1 s with its table anew, with it known, and by all joints: ms; how far the last differ"
    )
    for name, press in {"ZXN2-3000(B), in the plane": pp.load("zxn2_3000b"), **in_space()}.items():
        inertia = 0.2 * float(reduced_model_of(press).middles[0].max())
        how: dict[str, Any] = {"speed": 6.0, "flywheel": pp.drives.Flywheel(inertia), "points": 121}
        if press.branch.period is None:
            how |= {"drive": None, "speed": 2.0}
        table = reduced_model_of(press)
        works: list[Contestant] = [
            ("table", lambda press=press: float(reduced_model_of(without_table(press)).evaluations)),
            ("anew", lambda press=press, how=how: last(pp.simulate(without_table(press), 0.4, **how))),
            ("known", lambda press=press, how=how: last(pp.simulate(press, 0.4, **how))),
            ("joints", lambda press=press, how=how: last(pp.simulate(press, 0.4, method="constraint", **how))),
        ]
        (_, _, made), (_, _, anew), (_, angle, known), (_, other, joints) = least(works, max(2, repeats // 3))
        times = " ".join(f"{1e3 * seconds:8.2f}" for seconds in (made, anew, known, joints))
        print(
            f"  {name:30} {table.evaluations:5} states {1e6 * made / table.evaluations:5.1f} us each {times}  {abs(angle - other):.0e} rad"
        )


def hand(repeats: int) -> None:
    """The script of the six-bar derived by hand, by which times of different machines and days can be compared."""
    angles = 2 * np.pi * np.arange(360) / 360

    def script() -> float:
        found = hand_script(angles, SPEED, 0.0)
        world_forces(found)
        return 0.0

    ((_, _, seconds),) = least([("", script)], 20 * repeats)
    print(f"inverse dynamics of the six-bar by a script derived by hand: {1e6 * seconds / 360:.3f} us an angle")


def _turns(run: pp.Run) -> int:
    return round(float(run.crank_angle[-1]) / (2 * np.pi))


QUICK = {  # what a quick run has instead
    "TOLERANCES": (1e-6, 1e-8),
    "STEPS": (1e-2,),
    "ASKED": (1e-6,),
    "SCENARIOS": 3,
    **dict.fromkeys(("LONG", "FREE", "BY_JOINTS", "SIX_BAR"), 2.0),
}


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    parts = {"hand": hand, "methods": methods, "tolerances": tolerances, "scenarios": scenarios, "tables": tables}
    parts |= {"friction": friction, "long": long_runs}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=parts, help="one part alone")
    only = parser.parse_args().only
    for name, part in parts.items():
        if only in (None, name):
            part(2 if quick else 10)


if __name__ == "__main__":
    main()
