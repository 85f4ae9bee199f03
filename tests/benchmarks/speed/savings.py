"""What a scene does not need, and what leaving it out saves: time of the six-bar ZXN2-3000(B) with and without each thing, memory of fresh
interpreters.

Run `python tests/benchmarks/speed/savings.py`; `--quick` for a fifth of the repeats. pytest does not collect this file. It prints
the tables and writes them to `viz/savings.md`. Contestants of a table take turns within each repeat, so that whatever else the machine does
meets all of them; the least time counts. Ratios are to the first row of the same table.
"""

from __future__ import annotations

import itertools
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

sys.path.insert(0, str(Path(__file__).parents[2]))
from benchmarks.stopwatch import least as least_seconds
from benchmarks.stopwatch import once

import pinpress as pp
from pinpress.linkage.memo import keep_all_but
from pinpress.simulation.reduced_model import reduced_model_of

ROOT = Path(__file__).resolve().parents[3]
SPEED = 70 * pp.RPM
REPEATS = {360: 60, 36000: 15}
SIDES = 100  # of the mesh's sphere: it has 2 x 100 x 100 triangles
WRITTEN = ROOT / "viz" / "savings.md"
COMMAND = "python tests/benchmarks/speed/savings.py"

Work = Callable[[], Any]
Contestants = dict[str, Work]


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """As Markdown, numbers to the right."""
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def compared(contestants: Contestants, repeats: int) -> str:
    best = least_seconds(list(contestants.values()), repeats)
    rows = [[name, _ms(seconds), f"{seconds / best[0]:.2f}"] for name, seconds in zip(contestants, best, strict=True)]
    return table(["", "ms", "ratio"], rows)


def both_sizes(make: Callable[[int], Contestants], repeats: dict[int, int]) -> str:
    """The contestants at either number of crank angles beside each other; those that there are at the first alone are left empty."""
    columns = {n: dict(zip(made := make(n), least_seconds(list(made.values()), count), strict=True)) for n, count in repeats.items()}
    rows = []
    for name in next(iter(columns.values())):
        row = [name]
        for found in columns.values():
            seconds = found.get(name)
            row += ["", ""] if seconds is None else [_ms(seconds), f"{seconds / next(iter(found.values())):.2f}"]
        rows.append(row)
    return table(["", *itertools.chain(*((f"{n} angles, ms", "ratio") for n in columns))], rows)


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:.3g}" if seconds < 0.0995 else f"{1e3 * seconds:.0f}"


# ------------------------------------------------------------------------------------------------------------------------------ tables


def whole_motion(press: pp.Linkage, points: int, engine: str = "auto") -> None:
    """A turn with all that a motion holds; some of its quantities are computed when they are read."""
    motion = pp.cycle(press, speed=SPEED, points=points, engine=engine)
    _ = motion.q, motion.v, motion.a, motion.slide_position, motion.slide_velocity, motion.slide_acceleration


def bearings(n: int) -> Contestants:
    """Inverse dynamics of one motion with fewer bearings, by either engine, beside the motion itself."""
    press = pp.load("zxn2_3000b")
    motion = pp.cycle(press, speed=SPEED, points=n)

    def solve(**more: Any) -> Work:
        return lambda: pp.inverse_dynamics(press, motion, **more)

    sizes = itertools.cycle(range(n - 4, n + 5))  # so that memory is not laid out for one number alone

    found = {
        "all 7 bearings": solve(),
        "torque alone, `bearings=()`": solve(bearings=()),
        "torque alone, then the shaking force": lambda: pp.inverse_dynamics(press, motion, bearings=()).shaking_force,
        "all, then the shaking force": lambda: pp.inverse_dynamics(press, motion).shaking_force,
        "all, then the power residual": lambda: pp.inverse_dynamics(press, motion).power_residual,
        "the motion itself, `cycle`": lambda: whole_motion(press, next(sizes)),
    }
    if n <= 360:
        found |= {
            "engine `space`, all": solve(engine="space"),
            "engine `space`, the motion itself": lambda: whole_motion(press, next(sizes), "space"),
            "engine `pinocchio`, all": solve(engine="pinocchio"),
            "engine `pinocchio`, torque alone": solve(engine="pinocchio", bearings=()),
            "engine `pinocchio`, the motion itself": lambda: whole_motion(press, next(sizes), "pinocchio"),
        }
    return found


def scenes(n: int) -> Contestants:
    """Inverse dynamics of the six-bar, all bearings, with one thing more at a time."""
    press = pp.load("zxn2_3000b")
    weightless = pp.load("zxn2_3000b", gravity=(0.0, 0.0, 0.0))
    motion, floating = (pp.cycle(each, speed=SPEED, points=n) for each in (press, weightless))
    spring = pp.loads.SpringDamper("frame", "slide", stiffness=1e5, damping=1e3, free_length=0.2, point1=(0.0, 0.0, 1.0))
    rubbing = {name: pp.loads.Friction(0.06, None if "guide" in name else 0.06) for name in press.bearings}

    def solve(**more: Any) -> Work:
        return lambda: pp.inverse_dynamics(press, motion, **more)

    return {
        "nothing but weights": solve(),
        "no weights either": lambda: pp.inverse_dynamics(weightless, floating),
        "a force in the plane": solve(loads=[pp.loads.PointForce("slide", (0.0, 0.0, 1e6))]),
        "a force across the plane": solve(loads=[pp.loads.PointForce("slide", (0.0, 1e3, 1e6))]),
        "a force across the plane, torque alone": solve(loads=[pp.loads.PointForce("slide", (0.0, 1e3, 1e6))], bearings=()),
        "a process load": solve(loads=[pp.loads.DeepDrawing(force=1e6, start=0.010)]),
        "a spring to the slide": solve(loads=[spring]),
        "a spring to the slide, torque alone": solve(loads=[spring], bearings=()),
        "stiffnesses, where nothing is shared": solve(stiffness=dict.fromkeys(press.bearings, 1e9)),
        "friction everywhere": solve(friction=rubbing),
        "friction everywhere, torque alone": solve(friction=rubbing, bearings=()),
    }


def shared(n: int) -> Contestants:
    """Inverse dynamics of presses of one size that share forces, or not, in one plane, or not."""
    presses = {name: pp.load(name) for name in ("jf75g_125", "jf75g_125_two_point", "jf75g_125_symmetric")}
    motions = {name: pp.cycle(press, speed=300 * pp.RPM, points=n) for name, press in presses.items()}
    words = {
        "jf75g_125": "flat, nothing shared",
        "jf75g_125_two_point": "rods in parallel planes share",
        "jf75g_125_symmetric": "gears and rods share",
    }
    found: Contestants = {}
    for name, press in presses.items():
        what = f"`{name}`, {len(press.bearings)} bearings: {words[name]}"
        found[what] = lambda press=press, name=name: pp.inverse_dynamics(press, motions[name])
        found[what + "; torque alone"] = lambda press=press, name=name: pp.inverse_dynamics(press, motions[name], bearings=())
    pair = presses["jf75g_125_symmetric"]
    stiff = dict.fromkeys(pair.bearings, 1e9)
    found["`jf75g_125_symmetric` by stiffnesses"] = lambda: pp.inverse_dynamics(pair, motions[pair.name], stiffness=stiff)
    return found


def kept() -> Contestants:
    """What is worked out once for a press, beside what is done again."""
    press, sizes = pp.load("zxn2_3000b"), itertools.cycle(range(356, 365))

    def fresh() -> pp.Linkage:
        return replace(press)

    def walked() -> None:
        _ = fresh().branch

    def without_table() -> pp.Linkage:
        equal = replace(press)
        keep_all_but(reduced_model_of, equal, press)
        return equal

    def run(press: pp.Linkage) -> pp.Run:
        return pp.simulate(press, 2.0, speed=SPEED, flywheel=pp.drives.Flywheel(500.0))

    return {
        "a further `cycle` of 356 to 364 angles": lambda: whole_motion(press, next(sizes)),
        "the first of a press": lambda: whole_motion(fresh(), 360),
        "of that the branch, walked once": walked,
        "a further `simulate` of 2 s": lambda: run(press),
        "the first of a press whose branch is known": lambda: run(without_table()),
        "of that the table of the reduced model": lambda: reduced_model_of(without_table()),
    }


def sphere(file: Path) -> None:
    """A mesh, as a binary STL."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, SIDES + 1), np.linspace(0, np.pi, SIDES + 1), indexing="ij")
    points = 0.1 * np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], axis=2).reshape(-1, 3, 3), np.stack([a, c, d], axis=2).reshape(-1, 3, 3)])
    record = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    record["corners"] = triangles
    file.write_bytes(b"\0" * 80 + len(record).to_bytes(4, "little") + record.tobytes())


def loading(folder: Path) -> Contestants:
    """Reading a URDF with shapes, with and without their geometry; nothing but a picture needs that."""
    plain = ROOT / "urdf" / "zxn2_3000b.urdf"
    meshed = folder / "meshed.urdf"
    sphere(folder / "sphere.stl")
    ball = '<visual><geometry><mesh filename="sphere.stl"/></geometry></visual>'
    meshed.write_text(plain.read_text(encoding="utf-8").replace('<link name="slide">', f'<link name="slide">{ball}', 1), encoding="utf-8")

    def geometry(file: Path) -> Work:
        def work() -> None:
            model = pin.buildModelFromUrdf(str(file))
            pin.buildGeomFromUrdf(model, str(file), pin.VISUAL, None, [str(folder)])
            pin.buildGeomFromUrdf(model, str(file), pin.COLLISION, None, [str(folder)])

        return work

    relative = folder / "relative.urdf"
    relative.write_text(meshed.read_text(encoding="utf-8").replace("sphere.stl", str(folder / "sphere.stl")), encoding="utf-8")
    return {
        "`pin.buildModelFromUrdf`": lambda: pin.buildModelFromUrdf(str(plain)),
        "and geometry, by coal: boxes and cylinders": geometry(plain),
        f"and geometry, with one mesh of {2 * SIDES * SIDES} triangles": geometry(relative),
        "`pp.load`: model, loops, all checks, drawn pose closed; no geometry": lambda: pp.load(plain),
        "`pp.load` of the one with a mesh": lambda: pp.load(meshed),
    }


def scenarios() -> Contestants:
    """Forward dynamics of 50 scenarios together, and each alone."""
    press = pp.load("zxn2_3000b")
    inertias = np.linspace(1000.0, 3000.0, 50)
    drive = pp.drives.ConstantTorque(500.0)

    def run(inertia: Any) -> Any:
        function = pp.simulate_batch if np.ndim(inertia) else pp.simulate
        return function(press, 2.0, speed=SPEED, flywheel=pp.drives.Flywheel(inertia), drive=drive, points=121)

    return {
        "one": lambda: run(inertias[0]),
        "50 together, as arrays": lambda: run(inertias),
        "50, one after the other": lambda: [run(inertia) for inertia in inertias],
    }


IMPORT = "import pinpress as pp"
LOAD = f'{IMPORT}; press = pp.load("zxn2_3000b")'
SOLVE = f"{LOAD}; motion = pp.cycle(press, speed=7.33); result = pp.inverse_dynamics(press, motion)"
INTERPRETERS = {
    "python": "",
    "`import numpy`": "import numpy",
    "`import pinocchio`": "import pinocchio",
    "`import pinpress`": IMPORT,
    "and `load`": LOAD,
    "`load`, `cycle`, `inverse_dynamics`": SOLVE,
    "`load`, `simulate`": f"{LOAD}; pp.simulate(press, 2.0, speed=7.33, flywheel=pp.drives.Flywheel(500.0))",
    "`load` to `inverse_dynamics`, `record`": f'{SOLVE}; pp.record(press, motion, folder + "/press.html", reactions=result)',
    "`load` to `inverse_dynamics`, `report`": f'{SOLVE}; pp.report(press, motion, folder + "/report.html", reactions=result)',
    "`load` to `inverse_dynamics`, `plots.draw`": f"{SOLVE}; pp.plots.draw(result, 'torque')",
}
SEEN = """
import sys
status = dict(line.split(":", 1) for line in open("/proc/self/status")) if sys.platform == "linux" else {}
large = "numpy pinocchio scipy matplotlib plotly meshcat pandas trimesh PIL".split()
print(status.get("VmRSS", "0 kB").split()[0], status.get("VmHWM", "0 kB").split()[0])
print(", ".join(name for name in large if name in sys.modules) or "none of them")
print(len([name for name in sys.modules if name.startswith("pinpress.")]))
"""


def fresh_processes(folder: Path, repeats: int) -> str:
    """Wall time and memory of fresh interpreters, taking turns."""
    best: dict[str, float] = dict.fromkeys(INTERPRETERS, np.inf)
    said: dict[str, list[str]] = {}
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    for name in list(INTERPRETERS) * repeats:
        command = [sys.executable, "-c", f"folder = {str(folder)!r}\n{INTERPRETERS[name]}\n{SEEN}"]
        start = partial(subprocess.run, command, capture_output=True, text=True, check=True, env=environment)
        done, seconds = once(start, time.perf_counter)
        best[name] = min(best[name], seconds)
        memory, large, modules = done.stdout.splitlines()[-3:]
        if name not in said or int(memory.split()[1]) < int(said[name][0].split()[1]):
            said[name] = [memory, large, modules]
    base = best["`import pinocchio`"]
    rows = []
    for name, seconds in best.items():
        memory, large, modules = said[name]
        rows.append([name, _ms(seconds), f"{seconds / base:.2f}", *(f"{int(kb) / 1024:.0f}" for kb in memory.split()), modules, large])
    return table(
        ["fresh interpreter", "ms", "to `import pinocchio`", "resident, MiB", "peak, MiB", "modules of pinpress", "imported"], rows
    )


QUICK = {
    "REPEATS": {360: 1},
    "SIDES": 8,
    "INTERPRETERS": {name: code for name, code in INTERPRETERS.items() if "import pinocchio" in name or "and `load`" in name},
}  # what a quick run has instead


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: in a few seconds, without a meaning of the times."""
    globals().update(QUICK if quick else {})
    share = 5 if quick else 1
    sizes = {n: max(3, count // share) for n, count in REPEATS.items()}
    few = max(3, 15 // share)
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        parts = [
            ("Bearings that are not asked for", "Inverse dynamics alone, of a motion at hand.", both_sizes(bearings, sizes)),
            (
                "Loads, friction, springs, weights",
                "Inverse dynamics alone, of all bearings unless a row says otherwise.",
                both_sizes(scenes, sizes),
            ),
            ("Sharing, and what leaves the plane", "Inverse dynamics alone.", both_sizes(shared, sizes)),
            ("What is kept with a press", "Each row includes all that it needs and that is not kept.", compared(kept(), few)),
            ("Geometry", "A URDF with boxes, cylinders and a mesh; shapes are read when they are drawn.", compared(loading(folder), few)),
            ("Scenarios", "Runs of 2 s under a constant torque.", compared(scenarios(), few)),
            ("Imports and memory", "Only what is used is imported.", fresh_processes(folder, max(3, 10 // share))),
        ]
    machine = f"Python {platform.python_version()}, NumPy {np.__version__}, Pinocchio {pin.__version__}, {os.cpu_count()} cores"
    text = f"""# What is left out, and what that saves

Times are of the six-bar ZXN2-3000(B) at 70 r/min, unless a table says otherwise. They are the least of many; the rows of a table take turns
in one run, and ratios are to its first row. {machine}; written by `{COMMAND}`.
"""
    for title, words, rows in parts:
        text += f"\n## {title}\n\n{words}\n\n{rows}\n"
    print(text)
    if not quick:
        WRITTEN.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
