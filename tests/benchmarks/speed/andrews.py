"""Andrews' squeezing mechanism to 0.05 s: error of the positions against run time, of pinpress and, where it is installed, of Exudyn.

Run `python tests/benchmarks/speed/andrews.py`; `--quick` for fewer repeats. pytest does not collect this file. The contestants take
turns, so
that whatever else the machine does meets all of them; the least time counts. pinpress's times are from the loaded mechanism, whose
assembly has been followed, to a `Run` with its states, accelerations and checks; Exudyn's from the assembled system to its last state.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks.stopwatch import least as least_seconds
from support.oracles import andrews
from support.oracles.exudyn_solver import solve

import pinpress as pp

DURATION = 0.05  # [s]
WANTED = 1e-7  # relative
TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
TIMES = tuple(andrews.REFERENCE)  # of the published positions [s]
STEPS = (1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2.5e-6, 1.25e-6, 1e-6)  # [s]
(X, Z), (X3, Z3) = andrews.ANCHOR, andrews.ON_K3
SPRING = pp.loads.SpringDamper("frame", "K3", point1=(X, 0.0, Z), point2=(X3, 0.0, Z3), **andrews.SPRING)

Array = Any
Contestant = tuple[str, Callable[[], Array]]


def mechanism() -> pp.Linkage:
    """Andrews' mechanism, its assembly followed."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "andrews.urdf"
        file.write_text(andrews.urdf(), encoding="utf-8")
        press = pp.load(file, gravity=(0.0, 0.0, 0.0))
    _ = press.branch
    return press


def pinpress(press: pp.Linkage, method: str, tolerance: float) -> Array:
    """(7,) joint coordinates at the end; the table of the reduced inertia is made anew."""
    press.__dict__.pop("table", None)
    run = pp.simulate(press, DURATION, drive=pp.drives.ConstantTorque(andrews.TORQUE), loads=[SPRING], method=method, tolerance=tolerance)
    return run.joint_position[-1]


def exudyn_runs(press: pp.Linkage) -> list[Contestant]:
    """Exudyn at each step; nothing where it is not installed."""
    try:
        from exudyn import itemInterface as items  # noqa: N813
    except ModuleNotFoundError:
        print("Exudyn is left out: not installed; pip install 'pinpress[peers]'")
        return []
    from benchmarks.peers import exudyn_press

    system = exudyn_press.build(press)
    mbs, driver, k3 = system.mbs, press.driver_indices[0] + 1, press.joints.index("gamma") + 1
    crank = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=system.nodes[driver], coordinate=2))
    mbs.AddLoad(items.LoadCoordinate(markerNumber=crank, load=float(system.signs[driver] * andrews.TORQUE)))
    ends = [system.marker(0, np.array([X, 0.0, Z])), system.marker(k3, np.array([X3, 0.0, Z3]))]
    spring = {"stiffness": SPRING.stiffness, "referenceLength": SPRING.free_length}
    mbs.AddObject(items.ObjectConnectorSpringDamper(markerNumbers=ends, **spring))
    mbs.Assemble()

    def run(step: float) -> Array:
        exudyn_press.begin(press, system, 0.0, 0.0)
        solve(system.mbs, exudyn_press.settings(DURATION, round(DURATION / step)))
        turned = np.concatenate([[0.0], mbs.systemData.GetODE2Coordinates().reshape(-1, 3)[:, 2]])
        parents = list(press.model.parents)[1:]
        return system.signs[1:] * (turned[1:] - turned[parents])

    return [(f"Exudyn, step {1e6 * step:g} us", lambda step=step: run(step)) for step in STEPS]


def least(contestants: list[Contestant], repeats: int) -> list[tuple[str, Array, float]]:
    """Name, result and least seconds of every contestant, in turn, again and again."""
    works = [work for _, work in contestants]
    results = [work() for work in works]
    return [(name, *each) for (name, _), *each in zip(contestants, results, least_seconds(works, repeats), strict=True)]


def against_80_bit(press: pp.Linkage) -> None:
    """Print the errors of the positions at the instants of the 80-bit solution."""
    start = np.array([andrews.START[name] for name in andrews.NAMES])
    order = [press.joints.index(name) for name in andrews.NAMES]
    for method in ("reduced", "constraint"):
        for time in TIMES:
            expected, *_ = andrews.REFERENCE[time]
            drive = pp.drives.ConstantTorque(andrews.TORQUE)
            run = pp.simulate(press, time, drive=drive, loads=[SPRING], method=method, tolerance=1e-13)
            error = np.abs(run.joint_position[-1, order] + start - expected).max() / np.abs(expected).max()
            print(f"  {method:10} positions at {time} s: {error:.1e} of the largest, energy {run.stats.energy_error:.1e}")


QUICK = {"DURATION": 0.005, "TOLERANCES": (1e-8,), "STEPS": (1e-5,), "TIMES": (0.01,)}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    repeats = 1 if quick else 10
    press = mechanism()
    against_80_bit(press)
    truth = pinpress(press, "constraint", 1e-13)
    size = np.abs(truth).max()
    apart = np.abs(pinpress(press, "reduced", 1e-13) - truth).max() / size
    print(
        f"positions at {DURATION} s, errors relative to the largest, {size:.12f} rad; both methods at tolerance 1e-13 differ by {apart:.1e}"
    )
    entries: list[Contestant] = []
    for method in ("reduced", "constraint"):
        entries += [(f"{method}, tolerance {t:.0e}", lambda m=method, t=t: pinpress(press, m, t)) for t in TOLERANCES]
    found = [(name, np.abs(end - truth).max() / size, seconds) for name, end, seconds in least(entries + exudyn_runs(press), repeats)]
    for name, error, seconds in found:
        print(f"  {name:40} {error:9.1e} {1e3 * seconds:10.2f} ms")
    print(f"\nleast time for an error below {WANTED:g}")
    best = {}
    for kind in ("reduced", "constraint", "Exudyn"):
        good = [(seconds, error, name) for name, error, seconds in found if name.startswith(kind) and error < WANTED]
        if good:
            best[kind] = min(good)
            seconds, error, name = best[kind]
            print(f"  {name:40} {error:9.1e} {1e3 * seconds:10.2f} ms")
    for kind, (seconds, _, _) in best.items():
        if "Exudyn" in best and kind != "Exudyn":
            print(f"Exudyn takes {best['Exudyn'][0] / seconds:.1f} times as long as {kind}")


if __name__ == "__main__":
    main()
