"""Two benchmarks with published answers: the N-four-bar to 10 s through its singular poses, and Andrews' squeezing mechanism to 0.05 s.

Times are from the loaded linkage, whose branch has been followed, to a `Run` with its states, accelerations and checks; Exudyn's from the
assembled system to its last state. Positions of Andrews' mechanism are also compared with a solution in 80 bits.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from benchmarks.stopwatch import least, ms, once, table
from support import texts
from support.oracles import andrews, n_four_bar
from support.oracles.exudyn_solver import solve

import pinpress as pp
from pinpress.accuracy.work_precision import without_table
from pinpress.common.quantities import Array

DURATION, WANTED = 0.05, 1e-7  # of Andrews' run [s], relative error of its positions that is asked for
TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
STEPS = (1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2.5e-6, 1.25e-6, 1e-6)  # of Exudyn [s]
(X, Z), (X3, Z3) = andrews.ANCHOR, andrews.ON_K3
SPRING = pp.loads.SpringDamper("frame", "K3", point1=(X, 0.0, Z), point2=(X3, 0.0, Z3), **andrews.SPRING)


def main(quick: bool = False) -> None:
    """Print the tables."""
    rows = []
    for count, methods in ((1, ("reduced", "constraint")), (2, ("reduced", "constraint")), (40, ("reduced",))):
        press = texts.load(n_four_bar.urdf(count))
        _, followed = once(lambda press=press: press.branch_through_change_points)
        for method in methods:

            def work(press: pp.Linkage = press, method: str = method) -> pp.Run:
                return pp.simulate(press, 10.0, speed=n_four_bar.SPEED, points=11, method=method)

            run, (seconds,) = work(), least([work], 1 if quick else 5)
            errors = [abs(run.crank_angle[second] - angle) for second, (angle, _) in n_four_bar.EXACT.get(count, {}).items()]
            worst = f"{max(errors):.1e}" if errors else ""
            rows.append((f"{count} four-bars", method, ms(followed), ms(seconds), f"{run.stats.energy_error:.1e}", worst))
    print(table(("linkage", "method", "branch [ms]", "run [ms]", "energy error", "error of the angle [rad]"), rows))

    press = texts.load(andrews.urdf(), gravity=(0.0, 0.0, 0.0))
    start, order = np.array([andrews.START[name] for name in andrews.NAMES]), [press.joints.index(name) for name in andrews.NAMES]
    rows = []
    for method in ("reduced", "constraint"):
        for time in list(andrews.REFERENCE)[: 1 if quick else None]:
            run, (expected, *_) = run_andrews(press, method, 1e-13, time), andrews.REFERENCE[time]
            error = np.abs(run.joint_position[-1, order] + start - expected).max() / np.abs(expected).max()
            rows.append((method, f"{time} s", f"{error:.1e}", f"{run.stats.energy_error:.1e}"))
    print("\n" + table(("Andrews' mechanism", "positions at", "error", "energy error"), rows))

    truth = run_andrews(press, "constraint", 1e-13).joint_position[-1]
    works: dict[str, Callable[[], Array]] = {
        f"{method}, tolerance {t:.0e}": lambda m=method, t=t: run_andrews(press, m, t).joint_position[-1]
        for method in ("reduced", "constraint")
        for t in TOLERANCES[-1:] * quick or TOLERANCES
    }
    works |= exudyn_runs(press, STEPS[3:4] if quick else STEPS)
    errors = [float(np.abs(work() - truth).max() / np.abs(truth).max()) for work in works.values()]
    results = list(zip(works, errors, least(list(works.values()), 1 if quick else 10), strict=True))
    print("\n" + table((f"Andrews' mechanism, {DURATION} s", "error", "ms"), [(name, f"{error:.1e}", ms(s)) for name, error, s in results]))
    best: dict[str, tuple[str, str]] = {}
    for name, error, seconds in sorted(results, key=lambda row: row[2]):
        if error < WANTED:
            best.setdefault(name.partition(",")[0], (name, ms(seconds)))
    print("\n" + table((f"least time for an error below {WANTED:g}", "ms"), best.values()))


def run_andrews(press: pp.Linkage, method: str, tolerance: float, duration: float = DURATION) -> pp.Run:
    """A run of Andrews' mechanism; the table of its reduced model is made anew."""
    drive = pp.drives.ConstantTorque(andrews.TORQUE)
    run = pp.simulate(without_table(press), duration, drive=drive, loads=[SPRING], method=method, tolerance=tolerance)
    assert isinstance(run, pp.Run)
    return run


def exudyn_runs(press: pp.Linkage, steps: tuple[float, ...]) -> Iterator[tuple[str, Callable[[], Array]]]:
    """Exudyn at each step; nothing where it is not installed."""
    try:
        from exudyn import itemInterface as items  # noqa: N813
    except ModuleNotFoundError:
        print("Exudyn is left out: not installed; pip install 'pinpress[peers]'")
        return
    from benchmarks.peers import exudyn_press

    system = exudyn_press.build(press)
    mbs, driver, k3 = system.mbs, press.driver_indices[0] + 1, press.joints.index("gamma") + 1
    crank = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=system.nodes[driver], coordinate=2))
    mbs.AddLoad(items.LoadCoordinate(markerNumber=crank, load=float(system.signs[driver] * andrews.TORQUE)))
    ends = [system.marker(0, np.array([X, 0.0, Z])), system.marker(k3, np.array([X3, 0.0, Z3]))]
    spring = {"stiffness": SPRING.stiffness, "referenceLength": SPRING.free_length}
    mbs.AddObject(items.ObjectConnectorSpringDamper(markerNumbers=ends, **spring))
    mbs.Assemble()

    def run(step: float) -> Any:
        exudyn_press.begin(press, system, 0.0, 0.0)
        solve(system.mbs, exudyn_press.settings(DURATION, round(DURATION / step)))
        turned = np.concatenate([[0.0], mbs.systemData.GetODE2Coordinates().reshape(-1, 3)[:, 2]])
        return system.signs[1:] * (turned[1:] - turned[list(press.model.parents)[1:]])

    for step in steps:
        yield f"Exudyn, step {1e6 * step:g} us", lambda step=step: run(step)
