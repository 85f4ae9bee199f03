"""How long the first call of every public function takes on a shipped press, each in a new process.

Run `python tests/benchmarks/speed/first_calls.py`, with words behind it for the calls whose names have one of them. pytest does not
collect this file. The press is loaded, and what the call takes is there (see `GIVEN`). The times are the least of three processes: how long
the first call keeps its user waiting, with the imports that it needs; the processor's time of it, on all cores; that of the same call once
more. Calls that search or run other programs, and those that need Matplotlib, whose import alone takes half a second, stand in tables of
their own. The last table has whole processes: commands, and what Python, NumPy, Pinocchio and those parts of SciPy take of them that
integrate and interpolate.
"""

import argparse
import os
import re
import resource
import subprocess
import sys
import tempfile

REPEATS = 3

START = """
import sys, tempfile, time
from pathlib import Path
import numpy as np
import pinpress as pp
from pinpress import foundation
from pinpress.balancing import classical
from pinpress.kinematics import measures
folder = Path(tempfile.mkdtemp())
press = pp.load("zxn2_3000b")
"""
TIMED = """
waited, started = time.perf_counter(), time.process_time()
{call}
first, waited = time.process_time() - started, time.perf_counter() - waited
started = time.process_time()
{call}
print(waited, first, time.process_time() - started)
"""

# What calls take, by names; each line may use the names above it.
GIVEN = {
    "times": "np.arange(8) / 8",
    "heights": "0.1 + 0.05 * np.cos(2 * np.pi * times)",
    "unit_load": "pp.loads.ConstantForce(1.0, 0.01)",
    "ADDED": "pp.balancing.AddedMass()",
    "LENGTH": "{'C.coupler.x': (1.2, 1.243, 1.3)}",
    "largest_force": "lambda trial: np.ptp(trial.reactions.shaking_force[:, 2])",
    "crank_slide": "pp.load('crank_slide')",
    "rssp": "pp.build(Path(pp.__file__).parent / 'pin_table/templates/rssp.yaml')",
    "POINTS": "{'top': (0.0, 0.0, 1.0)}",
    "REGIONS": "[pp.balancing.CounterweightRegion('crank', radius=0.5, mass=(0.0, 500.0))]",
    "VERTICAL": "pp.balancing.Range('shaking_force', 'z')",
    "CAPACITIES": "pp.ratings.Capacities(3000e3, nominal_height=0.013, bearings={'A': 1.5e6}, flywheel_inertia=2000.0, speed_drop=0.2)",
    "GIBS": "pp.ratings.Gibs(1.2, 0.3)",
    "STIFFNESS": "pp.elasticity.Stiffness(bearings={name: 1e10 for name in press.bearings if name != 'slide_guide'})",
    "SPRINGS": "pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 5e9), moments={'slide_guide': 1e8})",
    "ELASTIC": "pp.elasticity.Elastic(SPRINGS, damping_ratio=0.05)",
    "STEADY": "pp.drives.PrescribedSpeed(7.0)",
    "FRICTION": "{name: pp.loads.Friction(0.05, 0.06) for name in press.bearings if name != 'slide_guide'}",
    "BLANKING": "pp.loads.Blanking(1000e3, 0.006, 0.003)",
    "MOTOR": "pp.drives.Geared(pp.drives.InductionMotor(75e3, 980 * pp.RPM, frequency=50.0, poles=6), 14.0)",
    "FLYWHEEL": "pp.drives.Flywheel(2000.0)",
    "motion": "pp.cycle(press, 70 * pp.RPM)",
    "places": "measures.bearing_positions(press, motion)",
    "reactions": "pp.inverse_dynamics(press, motion)",
    "run": "pp.simulate(press, 2.0, speed=7.0, drive=MOTOR, flywheel=FLYWHEEL, loads=[BLANKING])",
    "rated": "pp.ratings.rate(press, 70 * pp.RPM, CAPACITIES)",
    "elastic": "pp.elasticity.compliance(press, STIFFNESS)",
    "shift": "pp.elasticity.dead_centre_shift(press, STIFFNESS, speed=[5.0, 6.0])",
    "mounts": "[foundation.Mount((x, y, -0.2), (1e8, 1e8, 2e7), (1e5, 1e5, 1e5)) for x in (-1.5, 1.5) for y in (-1.0, 1.0)]",
    "frame": "foundation.Frame(40e3, (0.0, 0.0, 1.5), (4e4, 4e4, 2e4))",
    "system": "foundation.mounted(press, frame, mounts)",
    "response": "foundation.over_speeds(system, np.linspace(4.0, 8.0, 21), points=POINTS)",
    "vibration": "foundation.steady_response(system, reactions, points=POINTS)",
    "curve": "pp.balancing.trade_off(press, motion, regions=REGIONS, first=VERTICAL, second=pp.balancing.AddedMass(), points=3)",
}

QUICK = {
    "load": "pp.load('zxn2_3000b')",
    "check": "pp.check('zxn2_3000b')",
    "presses": "pp.presses()",
    "build": "pp.build(Path(pp.__file__).parent / 'pin_table/templates/crank-slide.yaml')",
    "build, in space": "pp.build(Path(pp.__file__).parent / 'pin_table/templates/rssp.yaml')",
    "pin_table.draft": "pp.pin_table.draft(Path(pp.__file__).parent / 'pin_table/templates/crank-slide.yaml')",
    "write_urdf": "pp.write_urdf(press, folder / 'press.urdf')",
    "visual_model": "pp.visual_model(press, motion)",
    "a press in a notebook": "press._repr_html_()",
    "a press in a notebook, in space": "rssp._repr_html_()",
    "reactions in a notebook": "reactions._repr_html_()",
    "cycle": "pp.cycle(press, 7.0)",
    "cycle, in space": "pp.cycle(rssp, 7.0)",
    "servo_cycle": "pp.servo_cycle(press, angle=np.linspace(0.0, 6.0, 360), speed=7.0)",
    "servo_cycle of heights": "pp.servo_cycle(crank_slide, time=times, height=heights, flank='down')",
    "dead_centres": "pp.dead_centres(press)",
    "inverse_dynamics": "pp.inverse_dynamics(press, motion)",
    "inverse_dynamics, loads and friction": "pp.inverse_dynamics(press, motion, loads=[BLANKING], friction=FRICTION)",
    "inverse_dynamics, stiffness": "pp.inverse_dynamics(press, motion, stiffness=STIFFNESS.bearings)",
    "inverse_dynamics, in space": "pp.inverse_dynamics(rssp, pp.cycle(rssp, 7.0))",
    "Reactions.indeterminate": "reactions.indeterminate",
    "simulate": "pp.simulate(press, 2.0, speed=7.0, drive=MOTOR, flywheel=FLYWHEEL, loads=[BLANKING])",
    "simulate, all joints": "pp.simulate(press, 0.5, speed=7.0, method='constraint')",
    "simulate, in space": "pp.simulate(rssp, 0.5, speed=7.0)",
    "simulate_batch": "pp.simulate_batch(press, 0.5, speed=np.linspace(6.0, 7.0, 10))",
    "steady_state": "pp.steady_state(press, speed=7.0, drive=MOTOR, flywheel=FLYWHEEL, loads=[BLANKING])",
    "report": "pp.report(press, motion, folder / 'report.html', reactions=reactions)",
    "record": "pp.record(press, motion, folder / 'press.html', reactions=reactions)",
    "measures.extremes": "pp.measures.extremes(reactions)",
    "measures.driving_energy": "pp.measures.driving_energy(reactions)",
    "measures.harmonics": "pp.measures.harmonics(motion, reactions.shaking_force)",
    "measures.least_transmission_angles": "pp.measures.least_transmission_angles(press)",
    "measures.bearing_positions": "pp.measures.bearing_positions(press, motion)",
    "measures.dwell_angle": "pp.measures.dwell_angle(motion, 1e-3)",
    "measures.dwell_time": "pp.measures.dwell_time(motion, 1e-3)",
    "measures.speed_variation": "pp.measures.speed_variation(motion, 0.05)",
    "measures.even_length": "pp.measures.even_length(motion, 0.1)",
    "measures.phases": "pp.measures.phases(motion, 0.05)",
    "measures.transmission_angle_curves": "pp.measures.transmission_angle_curves(press, motion)",
    "measures.mechanical_advantage": "pp.measures.mechanical_advantage(motion, 0.05)",
    "measures.quick_return_ratio": "pp.measures.quick_return_ratio(motion)",
    "measures.speed_at": "pp.measures.speed_at(motion, 0.05)",
    "measures.speed_ratio": "pp.measures.speed_ratio(motion)",
    "measures.stroke": "pp.measures.stroke(motion)",
    "measures.transmission_angle": "pp.measures.transmission_angle(motion, pin=places['C'], one=places['B'], another=places['D'])",
    "measures.pressure_angle": "pp.measures.pressure_angle(motion, driven=places['F'], other=places['E'], axis=(0.0, 0.0, 1.0))",
    "measures.duty_cycle": "pp.measures.duty_cycle(run)",
    "measures.stroke_duties": "pp.measures.stroke_duties(run)",
    "ratings.rate": "pp.ratings.rate(press, 70 * pp.RPM, CAPACITIES)",
    "ratings.speed_limit": "pp.ratings.speed_limit(press, CAPACITIES)",
    "ratings.eccentric_load": "pp.ratings.eccentric_load(press, motion, force=1000e3, offset=(0.1, 0.0, 0.0), gibs=GIBS)",
    "ratings.permissible_eccentricity": "pp.ratings.permissible_eccentricity(press, motion, force=1000e3, gibs=GIBS, pressure=3e6)",
    "elasticity.compliance": "pp.elasticity.compliance(press, STIFFNESS)",
    "elasticity.slide_deflection": "pp.elasticity.slide_deflection(press, motion, STIFFNESS)",
    "elasticity.dead_centre_shift": "pp.elasticity.dead_centre_shift(press, STIFFNESS, speed=[5.0, 6.0])",
    "elasticity.snap_through": "pp.elasticity.snap_through(1e5, 1e9, mass=500.0, break_time=1e-3, clearance=1e-4)",
    "elasticity.permissible_breakthrough": "pp.elasticity.permissible_breakthrough(1e4, 1e9, mass=500.0, break_time=1e-3, clearance=1e-4)",
    "elasticity.natural_frequencies": "pp.elasticity.natural_frequencies(press, ELASTIC)",
    "elasticity.campbell": "pp.elasticity.campbell(press, ELASTIC, speeds=np.linspace(5.0, 8.0, 16))",
    "simulate on springs": "pp.simulate(press, 0.5, drive=STEADY, elastic=ELASTIC)",
    "steady_state on springs": "pp.steady_state(press, 7.0, drive=STEADY, elastic=ELASTIC)",
    "steady_state on springs, blanking": "pp.steady_state(press, 7.0, drive=STEADY, loads=[BLANKING], elastic=ELASTIC)",
    "elasticity.over_speeds": "pp.elasticity.over_speeds(press, ELASTIC, speeds=np.linspace(6.0, 8.0, 5))",
    "derivatives.motion_derivatives": "pp.derivatives.motion_derivatives(press, motion, [{('F', 'rod'): (0.001, 0.0, 0.0)}])",
    "derivatives.acceleration_derivatives": "pp.derivatives.acceleration_derivatives(press, motion)",
    "derivatives.pivot_positions": "pp.derivatives.pivot_positions(press)",
    "derivatives.reshaped": "pp.derivatives.reshaped(press, {('F', 'rod'): (0.485, 0.0, 0.0)})",
    "sweeps.operating_points": "pp.sweeps.operating_points(press, speeds=[5.0, 6.0], forces=[1e5, 1e6], unit_load=unit_load)",
    "balancing.with_counterweights": "pp.balancing.with_counterweights(press, [pp.balancing.Counterweight('crank', 100.0)])",
    "balancing.balance": "pp.balancing.balance(press, motion, regions=REGIONS, minimise=VERTICAL)",
    "balancing.trade_off": "pp.balancing.trade_off(press, motion, regions=REGIONS, first=VERTICAL, second=ADDED, points=11)",
    "balancing.compare_conditions": (
        "pp.balancing.compare_conditions(press, [pp.balancing.OperatingCondition(motion, name=name) for name in 'ab'], regions=REGIONS,"
        " minimise=VERTICAL)"
    ),
    "classical.approximate_balance": "classical.approximate_balance(crank_slide, radius=0.2, share=0.5)",
    "classical.complete_balance": "classical.complete_balance(crank_slide, rod_radius=0.2, crank_radius=0.2)",
    "classical.compare_harmonics": "classical.compare_harmonics(reactions, reactions)",
    "classical.with_balance_shafts": "classical.with_balance_shafts(crank_slide, radius=0.1, shaft_distance=0.5)",
    "classical.as_crank_slider": "classical.as_crank_slider(crank_slide)",
    "classical.mirrored": "classical.mirrored(crank_slide, shaft_distance=1.0)",
    "classical.unbalance": "classical.unbalance(press, 'crank')",
    "foundation.mounted": "foundation.mounted(press, frame, mounts)",
    "foundation.modes": "foundation.modes(system)",
    "foundation.whirl": (
        "foundation.whirl(foundation.mounted(press, frame, mounts, rotors=[foundation.Rotor(136.0, (0, 1, 0))]), [0.0, 30.0, 60.0])"
    ),
    "foundation.beam_frame": (
        "foundation.beam_frame({'a': (0, 0, 0), 'b': (0, 0, 1)}, [foundation.FrameBeam('a', 'b', 0.3, 0.2, (1, 0, 0))], bed='a',"
        " carrier='b')"
    ),
    "foundation.lifting_response": "foundation.lifting_response(system, reactions, points=POINTS)",
    "foundation.press_inertia": "foundation.press_inertia(press)",
    "foundation.flywheel_moment": "foundation.flywheel_moment(press, motion, FLYWHEEL)",
    "foundation.over_speeds": "foundation.over_speeds(system, np.linspace(4.0, 8.0, 81), points=POINTS)",
    "foundation.steady_response": "foundation.steady_response(system, reactions, points=POINTS)",
    "foundation.time_response": "foundation.time_response(system, reactions, points=POINTS)",
    "foundation.transmissibility": "foundation.transmissibility(system, np.linspace(1.0, 30.0, 100))",
}
SEARCHES = {
    "foundation.isolate": "foundation.isolate(press, frame, mounts, speeds=[7.0, 8.0], transmitted=0.9)",
    "synthesis.trade_off": "pp.synthesis.trade_off(press, LENGTH, first=largest_force, second=lambda t: t.positions['E'][:, 2], speed=7.0)",
    "synthesis.synthesise": "pp.synthesis.synthesise(press, LENGTH, minimise=largest_force, speed=7.0)",
}
PLOTS = {
    "plots.draw": "pp.plots.draw(reactions, 'bearings')",
    "plots.save": "pp.plots.save(pp.plots.draw(motion, 'position'), folder / 'plot.svg')",
}
KINDS = {
    "calls": QUICK,
    "calls that search": SEARCHES,
    "plots; `import matplotlib.pyplot` alone:": {"import": "import matplotlib.pyplot"} | PLOTS,
}

WAITING_FOR = (
    "\nWhat takes longest, but for work, imports SciPy, for DOP853 or splines. Whatever is imported of that, its"
    " `from numpy import *` imports numpy.f2py and numpy.testing too, see the table of processes."
)

COMMANDS = {
    "python": ["-c", "pass"],
    "import numpy, pinocchio": ["-c", "import numpy, pinocchio"],
    "import numpy, pinocchio, numpy.f2py, numpy.testing": ["-c", "import numpy, pinocchio, numpy.f2py, numpy.testing"],
    "import numpy, pinocchio, scipy.integrate": ["-c", "import numpy, pinocchio, scipy.integrate"],
    "import numpy, pinocchio, scipy.interpolate": ["-c", "import numpy, pinocchio, scipy.interpolate"],
    "pinpress --help": ["-m", "pinpress", "--help"],
    "pinpress about": ["-m", "pinpress", "about"],
    "pinpress check": ["-m", "pinpress", "check", "zxn2_3000b"],
    "pinpress analyse": ["-m", "pinpress", "analyse", "zxn2_3000b", "--speed", "70"],
    "pinpress simulate": ["-m", "pinpress", "simulate", "zxn2_3000b", "--speed", "70", "--duration", "2"],
    "pinpress report": ["-m", "pinpress", "report", "zxn2_3000b", "--speed", "70", "--out", "page.html"],
}


def main(quick: bool = False) -> None:
    """Run the benchmark; ``quick``: the first call of each kind and no commands, without a meaning of the times."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", help="in the names of the calls that are timed; by default all are")
    words = parser.parse_args().words
    for title, calls in KINDS.items():
        wanted = {name: call for name, call in calls.items() if not words or any(word in name for word in words)}
        if wanted:
            print(f"\n| {title} | waited [ms] | first [ms] | again [ms] |\n|---|---:|---:|---:|")
        wanted = dict(list(wanted.items())[:1]) if quick else wanted
        found = {name: seconds(call) for name, call in wanted.items()}
        for name, (waited, first, again) in sorted(found.items(), key=lambda each: -each[1][0]):
            print(f"| {name} | {1e3 * waited:.0f} | {1e3 * first:.0f} | {1e3 * again:.1f} |", flush=True)
    print(WAITING_FOR)
    commands = {} if quick else {name: line for name, line in COMMANDS.items() if not words or any(word in name for word in words)}
    if commands:
        print("\n| processes | whole [ms] |\n|---|---:|")
    for name, line in commands.items():
        print(f"| {name} | {1e3 * of_process(line):.0f} |", flush=True)


def of_process(arguments: list[str]) -> float:
    """Of a whole process of Python, from its start to its end: the least of several."""
    compiled = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    times = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(REPEATS + 1):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            run = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=False, env=compiled, cwd=folder)
            if run.returncode:
                sys.exit(f"{arguments}\n{run.stderr}")
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(times[1:])


def seconds(call: str) -> tuple[float, ...]:
    """Of the first call in a new process the time that passes and that of the processor, and that of the next call: the least of
    several."""
    program = START + given(call) + TIMED.format(call=call)
    compiled = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}  # as where it is installed
    times = []
    for _ in range(REPEATS + 1):
        run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False, env=compiled)
        if run.returncode:
            sys.exit(f"{call}\n{run.stderr}")
        times.append(tuple(map(float, run.stdout.split()[-3:])))
    return tuple(map(min, zip(*times[1:], strict=True)))  # in the first one modules may have been compiled


def given(call: str) -> str:
    """The lines that make what a call takes."""
    words, lines = set(re.findall(r"\w+", call)), []
    for name, made in reversed(GIVEN.items()):
        if name in words:
            words |= set(re.findall(r"\w+", made))
            lines.append(f"{name} = {made}\n")
    return "".join(reversed(lines))


if __name__ == "__main__":
    main()
