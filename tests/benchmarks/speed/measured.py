"""Times of what is found from records: processor time of one process, the least of several calls.

python tests/benchmarks/speed/measured.py
"""

import sys
import warnings
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
import numpy as np
from benchmarks import stopwatch
from support import hammer_hits

import pinpress as pp
from pinpress import foundation, measured

TIMES = 5
NOISE = 1000.0  # of the torque in `blanking` [N m]


def least(function: Callable[[], object]) -> float:
    """Least processor time of some calls [s]."""
    return stopwatch.least([function], TIMES)[0]


def blanking(strokes: int, friction: dict[str, pp.loads.Friction]) -> measured.MeasuredRun:
    """Strokes of the ZXN2-3000B at 50 a minute, sampled at 1000 Hz."""
    press = pp.load("zxn2_3000b")
    moments = np.arange(round(strokes * 1200)) / 1000
    states = pp.servo_cycle(press, pp.dead_centres(press).top_angle + 50 * pp.RPM * moments, speed=50 * pp.RPM, acceleration=0.0)
    load = pp.loads.DeepDrawing(1e6, start=0.01)
    torque = pp.inverse_dynamics(press, states, loads=[load], friction=friction, bearings=()).driving_torque
    return measured.MeasuredRun(moments, states.crank_angle, torque + NOISE * np.random.default_rng(0).normal(size=len(torque)))


def behind(flywheel: float, counts: int | None) -> str:
    """Standard deviations of the force at heights, with 1 % noise of the torque and that of an encoder [kN]."""
    heights, rng = np.array([0.0, 1.0, 4.0, 10.0, 20.0]) * 1e-3, np.random.default_rng(1)
    plain = blanking(1, {})
    angle = plain.angle if counts is None else plain.angle + 2 * np.pi / counts / np.sqrt(12) * rng.normal(size=len(plain.angle))
    run = measured.MeasuredRun(plain.time, angle, plain.torque + np.sqrt(1380.0**2 - NOISE**2) * rng.normal(size=len(angle)))
    found = measured.process_force(pp.load("zxn2_3000b"), run, heights, drive_inertia=flywheel)
    sizes = found.deviation / max(1.0, found.misfit, found.idle_misfit)
    return ", ".join(f"{1e-3 * size:.1f} kN at {1e3 * height:g} mm" for size, height in zip(sizes[:4], heights, strict=False))


QUICK = {"TIMES": 1}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    for flywheel, counts in ((0.0, None), (2000.0, 8192), (2000.0, 131_072)):
        print(f"flywheel {flywheel:4.0f} kg m2, encoder {counts or 'exact':>6}: {behind(flywheel, counts)}")
    press, heights = pp.load("zxn2_3000b"), np.linspace(0.0, 0.012, 13)
    rubbing = {"slide_guide": pp.loads.Friction(0.05), "A": pp.loads.Friction(0.02, radius=0.2)}
    print(f"sensor of forces made                 {1e3 * least(lambda: measured.force_sensor(press, heights)):8.1f} ms")
    for words, friction, flywheel in (("", {}, 0.0), (", flywheel", {}, 2000.0), (", friction", rubbing, 0.0)):
        sensor = measured.force_sensor(press, heights, friction=friction, drive_inertia=flywheel)
        run = blanking(1, friction)
        took = least(lambda sensor=sensor, run=run: sensor.force(run))
        print(f"{f'a stroke of 1200 samples{words}':38s}{1e3 * took:8.1f} ms, {1 / took:.0f} strokes a second")
    record = measured.vibration(hammer_hits.columns(), hammer_hits.SENSORS)
    beside = foundation.modes(hammer_hits.standing())
    print(f"6 modes of 3 hits and 15 channels     {1e3 * least(lambda: record.modes(beside=beside)):8.1f} ms")
    found = record.modes(beside=beside)
    print(f"mounts fitted to them                 {1e3 * least(lambda: measured.fit_mounts(hammer_hits.standing(), found)):8.1f} ms")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
