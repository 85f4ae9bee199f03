"""What a scene does not need, and what leaving it out saves: time of the six-bar ZXN2-3000(B) with and without each thing, memory of fresh
interpreters. It writes viz/savings.md.
"""

import itertools
import os
import platform
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import trimesh
from benchmarks.stopwatch import compared, in_new_process, least, ms, once, table

import pinpress as pp
from pinpress.accuracy.work_precision import without_table
from pinpress.simulation.reduced_model import reduced_model_of

ROOT = Path(__file__).resolve().parents[3]
SPEED = 70 * pp.RPM
SIDES = 100  # of the mesh's sphere: it has 2 x 100 x 100 triangles

Work = Callable[[], Any]
Works = dict[str, Work]


def both_sizes(make: Callable[[int], Works], repeats: dict[int, int]) -> str:
    """The works at each number of crank angles; those that there are at the first alone are left empty."""
    columns = {n: dict(zip(works := make(n), least(list(works.values()), count), strict=True)) for n, count in repeats.items()}
    rows = []
    for name in next(iter(columns.values())):
        cells = [(ms(s[name]), f"{s[name] / next(iter(s.values())):.2f}") if name in s else ("", "") for s in columns.values()]
        rows.append((name, *itertools.chain(*cells)))
    return table(["", *itertools.chain(*((f"{n} angles, ms", "ratio") for n in columns))], rows)


def whole_motion(press: pp.Linkage, points: int, engine: str = "auto") -> None:
    """A turn with all that a motion holds; some of its quantities are computed when they are read."""
    motion = pp.cycle(press, speed=SPEED, points=points, engine=engine)
    _ = motion.q, motion.v, motion.a, motion.slide_position, motion.slide_velocity, motion.slide_acceleration


def bearings(n: int) -> Works:
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


def scenes(n: int) -> Works:
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


def shared(n: int) -> Works:
    """Inverse dynamics of presses of one size that share forces, or not, in one plane, or not."""
    presses = {name: pp.load(name) for name in ("jf75g_125", "jf75g_125_two_point", "jf75g_125_symmetric")}
    motions = {name: pp.cycle(press, speed=300 * pp.RPM, points=n) for name, press in presses.items()}
    words = {
        "jf75g_125": "flat, nothing shared",
        "jf75g_125_two_point": "rods in parallel planes share",
        "jf75g_125_symmetric": "gears and rods share",
    }
    found: Works = {}
    for name, press in presses.items():
        what = f"`{name}`, {len(press.bearings)} bearings: {words[name]}"
        found[what] = lambda press=press, name=name: pp.inverse_dynamics(press, motions[name])
        found[what + "; torque alone"] = lambda press=press, name=name: pp.inverse_dynamics(press, motions[name], bearings=())
    pair = presses["jf75g_125_symmetric"]
    stiff = dict.fromkeys(pair.bearings, 1e9)
    found["`jf75g_125_symmetric` by stiffnesses"] = lambda: pp.inverse_dynamics(pair, motions[pair.name], stiffness=stiff)
    return found


def kept() -> Works:
    """What is worked out once for a press, beside what is done again."""
    press, sizes = pp.load("zxn2_3000b"), itertools.cycle(range(356, 365))

    def fresh() -> pp.Linkage:
        return replace(press)

    def walked() -> None:
        _ = fresh().branch

    def run(press: pp.Linkage) -> pp.Run:
        return pp.simulate(press, 2.0, speed=SPEED, flywheel=pp.drives.Flywheel(500.0))

    return {
        "a further `cycle` of 356 to 364 angles": lambda: whole_motion(press, next(sizes)),
        "the first of a press": lambda: whole_motion(fresh(), 360),
        "of that the branch, walked once": walked,
        "a further `simulate` of 2 s": lambda: run(press),
        "the first of a press whose branch is known": lambda: run(without_table(press)),
        "of that the table of the reduced model": lambda: reduced_model_of(without_table(press)),
    }


def loading(folder: Path) -> Works:
    """Reading a URDF with shapes, with and without their geometry; nothing but a picture needs that."""
    plain = ROOT / "urdf" / "zxn2_3000b.urdf"
    meshed = folder / "meshed.urdf"
    trimesh.creation.uv_sphere(radius=0.1, count=[SIDES, SIDES]).export(folder / "sphere.stl")
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
        f"and geometry, with one mesh of about {2 * SIDES**2} triangles": geometry(relative),
        "`pp.load`: model, loops, all checks, drawn pose closed; no geometry": lambda: pp.load(plain),
        "`pp.load` of the one with a mesh": lambda: pp.load(meshed),
    }


def scenarios() -> Works:
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
    """Wall time and memory of fresh interpreters, taking turns; each row has the least of both."""
    runs: dict[str, list[tuple[float, list[int], str, str]]] = {name: [] for name in INTERPRETERS}
    for name in list(INTERPRETERS) * repeats:
        code = f"folder = {str(folder)!r}\n{INTERPRETERS[name]}\n{SEEN}"
        printed, seconds = once(partial(in_new_process, code), time.perf_counter)
        memory, large, modules = printed.splitlines()[-3:]
        runs[name].append((seconds, [int(kb) for kb in memory.split()], modules, large))
    base, rows = min(runs["`import pinocchio`"])[0], []
    for name, several in runs.items():
        seconds = min(several)[0]
        _, resident, modules, large = min(several, key=lambda run: run[1][1])
        rows.append((name, ms(seconds), f"{seconds / base:.2f}", *(f"{kb / 1024:.0f}" for kb in resident), modules, large))
    head = ("fresh interpreter", "ms", "to `import pinocchio`", "resident, MiB", "peak, MiB", "modules of pinpress", "imported")
    return table(head, rows)


def main(quick: bool = False) -> None:
    """Print the tables and write them to viz/savings.md; ``quick``: print alone."""
    sizes, few = ({360: 3}, 3) if quick else ({360: 60, 36000: 15}, 15)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
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
            ("Imports and memory", "Only what is used is imported.", fresh_processes(folder, 1 if quick else 10)),
        ]
    machine = f"Python {platform.python_version()}, NumPy {np.__version__}, Pinocchio {pin.__version__}, {os.cpu_count()} cores"
    text = f"""# What is left out, and what that saves

Times are of the six-bar ZXN2-3000(B) at 70 r/min, unless a table says otherwise. They are the least of many; the rows of a table take turns
in one run, and ratios are to its first row. {machine}; written by `python tests/benchmarks/run.py savings`.
"""
    text += "".join(f"\n## {title}\n\n{words}\n\n{rows}\n" for title, words, rows in parts)
    print(text)
    if not quick:
        (ROOT / "viz" / "savings.md").write_text(text, encoding="utf-8")
