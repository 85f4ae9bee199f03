"""How long the first call of every public function takes on a shipped press, each in a new process.

The press is loaded, and what the call takes is there (see `GIVEN`). The times are the least of three processes: how long the first call
keeps its user waiting, with the imports that it needs; the processor's time of it; that of the same call once more. Calls that search, and
those that need Matplotlib, whose import alone takes half a second, stand in tables of their own. Imports of whole processes are in
`savings`.
"""

import re

from benchmarks.stopwatch import in_new_process, ms, table

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

CALLS = {
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
    "calls": CALLS,
    "calls that search": SEARCHES,
    "plots; `import matplotlib.pyplot` alone:": {"import": "import matplotlib.pyplot"} | PLOTS,
}


def main(quick: bool = False) -> None:
    """Print a table for each kind of calls; ``quick``: of each kind the first call, once."""
    for title, calls in KINDS.items():
        times = {name: seconds(call, 1 if quick else REPEATS) for name, call in list(calls.items())[: 1 if quick else None]}
        rows = [(name, *map(ms, row)) for name, row in sorted(times.items(), key=lambda item: -item[1][0])]
        print(table((title, "waited [ms]", "first [ms]", "again [ms]"), rows), flush=True)
        print()


def seconds(call: str, repeats: int) -> tuple[float, ...]:
    """Of the first call in a new process the time that passes and that of the processor, and that of the next call: the least of
    several."""
    words, lines = set(re.findall(r"\w+", call)), []
    for name, made in reversed(GIVEN.items()):
        if name in words:
            words |= set(re.findall(r"\w+", made))
            lines.append(f"{name} = {made}\n")
    program = START + "".join(reversed(lines)) + TIMED.format(call=call)
    runs = [tuple(map(float, in_new_process(program).split()[-3:])) for _ in range(repeats + 1)]
    return tuple(map(min, zip(*runs[1:], strict=True)))  # in the first one modules may have been compiled
