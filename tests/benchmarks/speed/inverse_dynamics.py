"""Inverse dynamics of the ZXN2-3000(B) press at 70 r/min: pinpress beside a hand-written script and a plain Pinocchio loop; then of every
shipped press, of scenes with springs and friction, and of linkages in space.

Run `python tests/benchmarks/speed/inverse_dynamics.py`; `--quick` for a fifth of the repeats. pytest does not collect this file.
Every contestant starts from crank angles and the loaded press and ends with the driving torque and the force of every pin and
guide as arrays. pinpress takes another number of angles in each call, so that memory is not laid out for one number alone. Contestants take
turns within each repeat, so that whatever else the machine does meets all of them.
"""

from __future__ import annotations

import ctypes
import itertools
import os
import platform
import statistics
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from functools import partial
from importlib.metadata import files
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))
sys.path.insert(0, str(ROOT / "tests"))
from benchmarks import stopwatch  # noqa: E402
from support import texts  # noqa: E402
from support.generators import spatial_linkages  # noqa: E402
from support.oracles import cassie  # noqa: E402
from support.oracles.pinocchio_loop import PinocchioLoop, inverse_dynamics  # noqa: E402
from support.oracles.six_bar_script import Array, six_bar, world_forces  # noqa: E402

from pinpress.kinematics.cycle import _constants  # noqa: E402

SPEED = 70 * 2 * np.pi / 60  # [rad/s]
SUBSET = 720  # angles that the per-angle loop is timed on where the whole turn has more
REPEATS = {360: 60, 36000: 15}
GRIDS = 8  # numbers of angles that take turns
FEWEST = range(2, 24)  # numbers of angles for the fixed cost of a call
OPERATIONS = 95  # calls of NumPy's operations in one of the engine's first calls

Forces = dict[str, Array]
# Name, number of angles timed, the work, and what takes torque and forces out of the work's result.
Contestant = tuple[str, int, Callable[[], Any], Callable[[Any], tuple[Array, Forces]]]


def contestants(n: int) -> list[Contestant]:
    """Everything that is timed at n crank angles of one turn at constant speed."""
    theta1 = 2 * np.pi * np.arange(n) / n
    some = theta1[:SUBSET]
    loop = PinocchioLoop()
    found: list[Contestant] = [
        ("(a) hand script, NumPy", n, lambda: six_bar(theta1, SPEED, 0.0), lambda r: (r["tau"], world_forces(r))),
        (
            "(b) Pinocchio loop" + (f", first {SUBSET} angles" if n > SUBSET else ""),
            some.size,
            lambda: inverse_dynamics(some, SPEED, 0.0, loop),
            lambda r: (r["tau"], {name: force for name, force in r.items() if name != "tau"}),
        ),
    ]
    try:
        import pinpress as pp

        load, cycle, solve, rpm = pp.load, pp.cycle, pp.inverse_dynamics, pp.RPM
    except (ImportError, AttributeError) as error:
        print(f"pinpress is left out: {error}")
        return found
    press = load(ROOT / "urdf" / "zxn2_3000b.urdf")
    sizes = itertools.cycle(range(n - GRIDS // 2, n + GRIDS // 2))

    def pinpress(engine: str, where: dict[str, str], points: int = n) -> tuple[Array, Forces, Forces]:
        motion = cycle(press, speed=70.0 * rpm, points=points, **where)
        result = solve(press, motion, engine=engine)
        forces = {name: result.bearing_force[name] for name in press.bearings}
        moments = {name: result.bearing_moment[name] for name in press.bearings}
        return result.driving_torque, forces, moments

    found.append(("(c) pinpress, plane", n, lambda: pinpress("plane", {}, next(sizes)), lambda _: pinpress("plane", {})[:2]))
    if n <= SUBSET:
        anew: dict[str, Any] = {"engine": "space"}
        found.append(("(d) pinpress, space", n, lambda: pinpress("space", anew, next(sizes)), lambda _: pinpress("space", anew)[:2]))
        found.append(("(e) pinpress, pinocchio", n, lambda: pinpress("pinocchio", {"engine": "pinocchio"}), lambda r: r[:2]))
    return found


def timed(entries: list[Contestant], repeats: int) -> list[list[float]]:
    """Least seconds per call of every contestant, in turn, again and again."""
    return [[seconds] for seconds in stopwatch.least([work for _, _, work, _ in entries], repeats, time.perf_counter)]


def errors(entries: list[Contestant]) -> list[tuple[float, float]]:
    """Largest error of the torque and of any bearing force against the first contestant, each relative to its own peak.

    A bearing's error is the length of the difference of the force vectors at the same angle, its peak its largest force.
    """
    answers = [answer(work()) for _, _, work, answer in entries]
    torque0, forces0 = answers[0]
    found = []
    for torque, forces in answers:
        if set(forces) != set(forces0):
            raise SystemExit(f"bearings differ: {sorted(forces)} and {sorted(forces0)}")
        torque_error = np.abs(torque - torque0[: torque.size]).max() / np.abs(torque0).max()
        force_errors = [
            np.linalg.norm(force - forces0[name][: len(force)], axis=1).max() / np.linalg.norm(forces0[name], axis=1).max()
            for name, force in forces.items()
        ]
        found.append((float(torque_error), float(max(force_errors))))
    return found


def print_speed(n: int, repeats: int) -> None:
    """Time all contestants at n crank angles and print the table."""
    entries = contestants(n)
    seconds = timed(entries, repeats)
    found = errors(entries)
    per_point = [min(row) / size * 1e6 for row, (_, size, _, _) in zip(seconds, entries, strict=True)]
    medians = [statistics.median(row) / size * 1e6 for row, (_, size, _, _) in zip(seconds, entries, strict=True)]
    print(
        f"\n{n} crank angles, {repeats} repeats; ratios are of the best times, above 1 is slower; errors against (a), relative to the peak"
    )
    print(
        f"{'':34}{'us/point':>10}{'us/point':>10}{'ms':>10}{'ms':>10}{'ratio':>9}{'ratio':>9}{'torque':>10}{'force':>10}\n"
        f"{'':34}{'best':>10}{'median':>10}{'best':>10}{'median':>10}{'to (a)':>9}{'to (b)':>9}{'error':>10}{'error':>10}"
    )
    for (name, size, _, _), best, median, (torque, force) in zip(entries, per_point, medians, found, strict=True):
        scaled = "*" if size < n else " "
        print(
            f"{name:34}{best:10.3f}{median:10.3f}{best * n / 1e3:9.2f}{scaled}{median * n / 1e3:9.2f}{scaled}"
            f"{best / per_point[0]:9.3f}{best / per_point[1]:9.4f}{torque:10.1e}{force:10.1e}"
        )
    if any(size < n for _, size, _, _ in entries):
        print(f"* timed and checked on {SUBSET} consecutive angles at the same spacing, and scaled to {n} points")


def print_fixed_cost(repeats: int) -> None:
    """Time calls with so few angles that hardly anything but the calls' own cost is left, with another number of angles each time: the
    script is 225 operations on arrays (calls of NumPy's `ufunc_generic_fastcall`), the engine 95, most on complex ones, of which as many
    products alone are timed, too."""
    import pinpress as pp

    press, sizes = pp.load("zxn2_3000b"), itertools.cycle(FEWEST)

    def few() -> pp.Reactions:
        return pp.inverse_dynamics(press, pp.cycle(press, speed=70 * pp.RPM, points=next(sizes)))

    turns = itertools.cycle([2 * np.pi * np.arange(n) / n for n in FEWEST])
    rotor = np.exp(2j * np.pi * np.arange(12) / 12)

    def script() -> Forces:
        return world_forces(six_bar(next(turns), SPEED, 0.0))

    def bare() -> None:
        for _ in range(OPERATIONS):
            _ = rotor * rotor

    entries: list[Contestant] = [
        ("(a) hand script, NumPy", 12, script, lambda r: r),
        ("(c) pinpress, plane", 12, few, lambda r: r),
        (f"bare operations, {OPERATIONS} of them", 12, bare, lambda r: r),
    ]
    best = {name: min(row) for (name, *_), row in zip(entries, timed(entries, repeats), strict=True)}
    print(f"\n{FEWEST[0]} to {FEWEST[-1]} crank angles, (a) and (c) on average, the others 12; best times of a call, and ratios to (a)")
    for name, took in best.items():
        print(f"{name:34}{took * 1e6:10.0f} us{took / best[entries[0][0]]:8.2f}")


def print_presses(n: int, repeats: int) -> None:
    """Time every shipped press at n crank angles, each beside the six-bar, and what springs, friction and stiffnesses add."""
    import pinpress as pp

    def scene(press: pp.Linkage, engine: str = "auto", **more: Any) -> pp.Reactions:
        return pp.inverse_dynamics(press, pp.cycle(press, speed=70 * pp.RPM, points=n, engine=engine), engine=engine, **more)

    sizes = itertools.cycle(range(n - GRIDS // 2, n + GRIDS // 2 + 1))

    def new_angles(press: pp.Linkage, **more: Any) -> pp.Reactions:
        return pp.inverse_dynamics(press, pp.cycle(press, speed=70 * pp.RPM, points=next(sizes)), **more)

    presses = {name: pp.load(name) for name in pp.presses()}
    entries: list[Contestant] = [(name, n, lambda press=press: new_angles(press), lambda r: r) for name, press in presses.items()]
    six, pair = presses["zxn2_3000b"], presses["jf75g_125_symmetric"]
    spring = [pp.loads.SpringDamper("frame", "slide", stiffness=1e5, damping=1e3, free_length=0.2, point1=(0.0, 0.0, 1.0))]
    rubbing = {name: pp.loads.Friction(0.06, None if "guide" in name else 0.06) for name in six.bearings}
    shares = dict.fromkeys(pair.bearings, 1e9)
    entries += [
        ("zxn2_3000b, a spring to the slide", n, lambda: new_angles(six, loads=spring), lambda r: r),
        ("zxn2_3000b, friction everywhere", n, lambda: new_angles(six, friction=rubbing), lambda r: r),
        ("jf75g_125_symmetric, stiffnesses", n, lambda: new_angles(pair, stiffness=shares), lambda r: r),
    ]
    best = {name: min(row) / n * 1e6 for (name, _, _, _), row in zip(entries, timed(entries, repeats), strict=True)}
    base = best["zxn2_3000b"] / len(six.bearings)
    print(
        f"\nEvery shipped press, {n} crank angles, {repeats} repeats, best times; errors against engine 'pinocchio', relative to the peak"
    )
    print(f"{'':36}{'bearings':>10}{'us/point':>10}{'us/point':>12}{'ratio to':>12}{'torque':>10}{'force':>10}")
    print(f"{'':36}{'':>10}{'':>10}{'and bearing':>12}{'zxn2_3000b':>12}{'error':>10}{'error':>10}  closed by")
    for name, took in best.items():
        press = presses[name.split(",")[0]]
        each = took / len(press.bearings)
        line = f"{name:36}{len(press.bearings):10}{took:10.3f}{each:12.3f}{each / base:12.2f}"
        if name in presses:
            plane, judge = scene(press), scene(press, "pinocchio")
            torque = np.abs(plane.driving_torque - judge.driving_torque).max() / np.abs(judge.driving_torque).max()
            peak = max(np.abs(force).max() for force in judge.bearing_force.values())
            force = max(np.abs(plane.bearing_force[b] - judge.bearing_force[b]).max() for b in press.bearings) / peak
            line += f"{torque:10.1e}{force:10.1e}  {'iteration' if _constants(press).chain is None else 'roots'}"
        print(line)


def print_space(n: int, repeats: int) -> None:
    """Time linkages in space, new angles in every call: engine `space` beside `pinocchio`, from crank angles to forces. Cassie's twelve
    drivers are followed by engine `space` in both columns; there is a line of its forces alone."""
    import pinpress as pp

    def swung(press: pp.Linkage, engine: str, shift: float, **more: Any) -> pp.Reactions:
        low, high = (0.0, 2 * np.pi) if press.branch.period else press.branch.angles[[0, -1]]
        angle = 0.5 * (low + high) + 0.4 * (high - low) * np.sin(np.linspace(shift, 6.0, n))
        motion = pp.servo_cycle(press, angle=angle, speed=np.cos(angle), acceleration=np.sin(angle), engine=engine)
        return pp.inverse_dynamics(press, motion, engine=engine, **more)

    shifts = itertools.count(0.0, 1e-5)
    rssp = Path(pp.__file__).parent / "pin_table" / "templates" / "rssp.yaml"
    presses = {
        "crank, ball-ended rod, slide": pp.build(rssp),
        "Bennett, 4 pins": texts.load(spatial_linkages.bennett()),
        "Bricard, 6 pins": texts.load(spatial_linkages.bricard()),
        "four-bar with a weld": texts.load(spatial_linkages.four_bar("fixed")),
    }
    works: dict[str, Callable[[str, float], pp.Reactions]] = {name: partial(swung, press) for name, press in presses.items()}
    slide = presses["crank, ball-ended rod, slide"]
    guides = [name for name, axis in zip(slide.bearings, slide.axes, strict=False) if not axis.turns]  # joints come before loops
    rubbing = {name: pp.loads.Friction(0.06, None if name in guides else 0.02) for name in slide.bearings}
    works["ball-ended rod, friction"] = partial(swung, slide, friction=rubbing)
    robot = _cassie()
    far = [0.3 if any(word in name for word in ("roll", "yaw", "pitch")) else 0.005 for name in robot.drivers]  # its knees lock soon
    sway = far * np.sin(np.linspace(0.0, 6.0, n)[:, None] + np.arange(len(robot.drivers)))

    def swayed(engine: str) -> pp.Motion:
        return pp.servo_cycle(robot, angle=sway, speed=sway, acceleration=-sway, engine=engine)

    moved = {engine: swayed(engine) for engine in ("space", "pinocchio")}
    works["Cassie, 12 drivers"] = lambda engine, _: pp.inverse_dynamics(robot, swayed(engine), engine=engine)
    works["Cassie, forces alone"] = lambda engine, _: pp.inverse_dynamics(robot, moved[engine], engine=engine)
    entries: list[Contestant] = [
        (f"{name}|{engine}", n, lambda work=work, engine=engine: work(engine, next(shifts)), lambda r: r)
        for name, work in works.items()
        for engine in ("space", "pinocchio")
    ]
    best = {name: min(row) / n * 1e6 for (name, _, _, _), row in zip(entries, timed(entries, repeats), strict=True)}
    print(f"\nLinkages in space, {n} states, {repeats} repeats, best times; errors against engine 'pinocchio', relative to the peak")
    print(f"{'':36}{'us/state':>10}{'us/state':>10}{'ratio':>8}{'torque':>10}{'force':>10}")
    print(f"{'':36}{'space':>10}{'pinocchio':>10}{'':>8}{'error':>10}{'error':>10}")
    for name, work in works.items():
        ours, judge = work("space", 0.0), work("pinocchio", 0.0)
        torque = np.abs(ours.driving_torque - judge.driving_torque).max() / np.abs(judge.driving_torque).max()
        peak = max(np.abs(force).max() for force in judge.bearing_force.values())
        force = max(np.abs(ours.bearing_force[b] - judge.bearing_force[b]).max() for b in judge.bearing_force) / peak
        fast, slow = best[f"{name}|space"], best[f"{name}|pinocchio"]
        print(f"{name:36}{fast:10.2f}{slow:10.1f}{slow / fast:8.1f}{torque:10.1e}{force:10.1e}")


def _cassie() -> Any:
    """The robot of example-robot-data, its motors and its knees' springs as drivers."""
    import pinpress as pp

    file = next(path.locate() for path in files("example-robot-data") or () if path.name == "cassie_v2.sdf")
    drivers = [f"{side}-{joint}" for side in ("left", "right") for joint in (*cassie.MOTORS, "knee-shin-joint")]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pp.PinpressWarning)  # its springs are not read
        return pp.load(file, driver=drivers)


def print_cold_start(repeats: int) -> None:
    """Wall time of fresh interpreters, taking turns."""
    statements = [
        "pass",
        "import numpy",
        "import pinocchio",
        "import pinpress",
        'import pinpress; pinpress.load("zxn2_3000b")',
    ]
    # An interpreter that cannot run a statement would be timed for failing: leave it out, and say so.
    kept = []
    for statement in statements:
        trial = subprocess.run([sys.executable, "-c", statement], cwd=ROOT, capture_output=True, text=True, check=False)
        if trial.returncode == 0:
            kept.append(statement)
        else:
            print(f"left out: {statement}: {trial.stderr.strip().splitlines()[-1]}")
    seconds: dict[str, list[float]] = {statement: [] for statement in kept}
    for _ in range(repeats):
        for statement, row in seconds.items():
            start = partial(subprocess.run, [sys.executable, "-c", statement], cwd=ROOT, check=True)
            row.append(stopwatch.once(start, time.perf_counter)[1])
    base = statistics.median(seconds["import pinocchio"])
    print(f"\nCold start: wall time of a fresh process, median of {repeats}, files in the disk cache")
    print(f"{'':50}{'ms':>9}{'ratio to import pinocchio':>28}")
    for statement, row in seconds.items():
        median = statistics.median(row)
        print(f"{statement:50}{median * 1e3:9.0f}{median / base:28.3f}")


def blas_threads() -> str:
    """How many threads each OpenBLAS of this process would use, as the library itself says."""
    try:
        maps = Path("/proc/self/maps").read_text(encoding="utf-8")
    except OSError:
        return "unknown on this platform"
    libraries = sorted({line.split(maxsplit=5)[5] for line in maps.splitlines() if "blas" in line.rsplit("/", 1)[-1].lower()})
    said = []
    for library in libraries:
        handle = ctypes.CDLL(library)
        for symbol in ("scipy_openblas_get_num_threads64_", "scipy_openblas_get_num_threads", "openblas_get_num_threads"):
            if hasattr(handle, symbol):
                said.append(f"{Path(library).name}: {getattr(handle, symbol)()}")
                break
    return ", ".join(said) or "no OpenBLAS found"


QUICK = {"REPEATS": {360: 1}, "FEWEST": range(2, 4), "SUBSET": 36}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    print(f"Python {platform.python_version()}, NumPy {np.__version__}, Pinocchio {pin.__version__}, {os.cpu_count()} cores")
    print(f"OPENBLAS_NUM_THREADS={os.environ.get('OPENBLAS_NUM_THREADS', '(not set)')}; BLAS threads in use: {blas_threads()}")
    for n, repeats in REPEATS.items():
        print_speed(n, max(3, repeats // 5) if quick else repeats)
    print_fixed_cost(6 if quick else 30)
    print_presses(360, 5 if quick else 30)
    print_space(360, 3 if quick else 10)
    print_cold_start(3 if quick else 7)


if __name__ == "__main__":
    main()
