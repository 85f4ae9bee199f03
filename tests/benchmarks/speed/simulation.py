"""Forward dynamics: what a tolerance buys, and how long runs keep their energy.

Wall times are from the loaded press, whose assembly has been followed, to a `Run` with its states, accelerations and checks.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.stopwatch import least, ms, once, table

import pinpress as pp

SPEED, DURATION = 70 * pp.RPM, 2.0
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)


def main(quick: bool = False) -> None:
    """Print the tables."""
    tolerances(quick)
    long_runs(quick)


def tolerances(quick: bool) -> None:
    """Time and error of the last crank angle, against a run of all joints over time, which has no table, and with friction against the
    tightest run."""
    six, jf = pp.load("zxn2_3000b"), pp.load("jf75g_125", gravity=(0, 0, -9.80665))
    rssp = pp.build(Path(pp.__file__).parent / "pin_table" / "templates" / "rssp.yaml")
    motor = pp.drives.Geared(pp.drives.InductionMotor(45e3, 1465 * pp.RPM), 4.9)
    blanking: dict[str, Any] = {"drive": motor, "flywheel": pp.drives.Flywheel(136.0), "loads": [pp.loads.Blanking(2e5, 0.010, 0.005)]}
    rubbing = {name: pp.loads.Friction(0.05, None if name == "slide_guide" else 0.06) for name in six.bearings}
    speeds = 300 * pp.RPM * np.random.default_rng(0).uniform(0.9, 1.1, 3 if quick else 1000)
    speeds[0] = 300 * pp.RPM
    free = {"speed": SPEED, "angle": np.radians(154.0), "flywheel": pp.drives.Flywheel(500.0)}
    scenes: dict[str, tuple[Callable[..., Any], str]] = {
        "free": (partial(pp.simulate, six, DURATION, **free), "constraint"),
        "in space": (partial(pp.simulate, rssp, DURATION, speed=10.0, flywheel=pp.drives.Flywheel(1.0)), "constraint"),
        "motor": (partial(pp.simulate, jf, DURATION, speed=300 * pp.RPM, **blanking), "constraint"),
        "friction": (partial(pp.simulate, six, 1.0, speed=SPEED, flywheel=pp.drives.Flywheel(6000.0), friction=rubbing), "reduced"),
        f"{len(speeds)} motors": (partial(pp.simulate_batch, jf, DURATION, speed=speeds, **blanking), "of motor"),
    }
    print("Free runs of 2 s of the six-bar, and of a spatial crank, rod with balls and slide; JF75G-125 under a motor and blanking, 2 s;")
    print(f"six-bar with friction in all bearings, 1 s; {len(speeds)} runs as the third: time, error of the last crank angle [rad]\n")
    truth: dict[str, float] = {}
    for name, (work, judge) in scenes.items():
        truth[name] = truth["motor"] if judge == "of motor" else last(work(tolerance=1e-13 if judge == "reduced" else 1e-12, method=judge))
    rows = []
    for tolerance in TOLERANCES[4:5] if quick else TOLERANCES:
        works = [partial(work, tolerance=tolerance, points=121) for work, _ in scenes.values()]
        errors = [abs(last(work()) - truth[name]) for name, work in zip(scenes, works, strict=True)]
        seconds = least(works, 1 if quick else 3)
        rows.append((f"{tolerance:.0e}", *(f"{ms(s)} ms, {error:.1e}" for s, error in zip(seconds, errors, strict=True))))
    print(table(("tolerance", *scenes), rows))


def last(run: Any) -> float:
    """The last crank angle of a run, or of the first scenario of a batch."""
    return float(np.ravel(run.crank_angle[-1])[0])


def long_runs(quick: bool) -> None:
    """A minute under the slip clutch, its steady state found directly, and energies of very long free runs."""
    press = pp.load("jf75g_125", gravity=(0, 0, -9.80665))
    flywheel = pp.drives.Flywheel(136.0)
    drive = pp.drives.Geared(pp.drives.SlipClutchMotor(189.0, 1470 * pp.RPM, 1320 * pp.RPM, 900 * pp.RPM), 3.0)
    given: dict[str, Any] = {"drive": drive, "flywheel": flywheel, "loads": [pp.loads.Blanking(1250e3, 0.010, 0.005)]}
    minute, steady = (
        partial(pp.simulate, press, 2.0 if quick else 60.0, speed=300 * pp.RPM, **given),
        partial(pp.steady_state, press, 300 * pp.RPM, **given),
    )
    (long, direct), run, period = least([minute, steady], 1 if quick else 3), minute(), pp.measures.duty_cycle(steady())
    stroke = pp.measures.stroke_duties(run)[-1]
    print(f"\nJF75G-125, slip-clutch motor, 1250 kN blanking, 300 strokes/min: {run.time[-1]:g} s, {len(run.time)} states:")
    print(f"{ms(long)} ms, energy error {run.stats.energy_error:.1e}; its steady state directly: {ms(direct)} ms. The period differs from")
    print(f"the last stroke by {abs(stroke.duration - period.duration):.0e} s, its lowest speed by", end=" ")
    print(f"{abs(stroke.lowest_speed - period.lowest_speed):.0e} rad/s.\n")
    rows = []
    six = pp.load("zxn2_3000b")
    for linkage, method, duration, speed, inertia in (
        (press, "reduced", 2000.0, 300 * pp.RPM, 136.0),
        (press, "constraint", 20.0, 300 * pp.RPM, 136.0),
        (six, "reduced", 8571.0, SPEED, 2000.0),
    ):
        how: dict[str, Any] = {"speed": speed, "flywheel": pp.drives.Flywheel(inertia), "points": 1000, "method": method}
        free, seconds = once(partial(pp.simulate, linkage, 2.0 if quick else duration, **how))
        turns, stats = round(float(free.crank_angle[-1]) / (2 * np.pi)), free.stats
        rows.append((linkage.name, method, turns, f"{stats.energy_error:.1e}", f"{stats.closure_error:.0e}", f"{seconds:.1f}"))
    print(table(("free run", "method", "turns", "energy error", "gap [m]", "s"), rows))
