"""What may be handed to the public functions and classes by mistake: valid arguments of each, and odd values to put in their places.

python tests/support/generators/hostile_arguments.py                     # every value in every place, with what came of it where that is
wrong
python tests/support/generators/hostile_arguments.py simulate loads.     # of these only

What is called is found in the public rooms, and its parameters in its signature. Arguments of a class are those of its example in
`every_result`; those of a function come from `SHARED` by the name of the parameter, changed for a room or a function in `FUNCTIONS`.
"""

# ruff: noqa: T201
import dataclasses
import inspect
import itertools
import math
import sys
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from datetime import datetime
from functools import cache, partial
from pathlib import Path
from typing import Any

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import numpy as np
from support import cams, every_result, texts
from support.every_result import (
    BEAM,
    CAPACITIES,
    CRANK_LENGTH,
    FRAME,
    MOTOR,
    PIN_TABLE,
    ROTOR,
    hit_modes,
    motion,
    one_turn,
    press,
    reactions,
)
from support.hammer_hits import standing
from support.time_limit import within

import pinpress as pp
from pinpress import foundation
from pinpress.kinematics import measures

SECONDS = 60.0  # that a call may take, on a machine with much else to do; most take milliseconds
FOLDER = Path("/nowhere")  # nothing is written
TESTS = Path(__file__).resolve().parents[2]
NOT_TRIED = {"draw", "presses"}  # any number of names, see `OTHERS`; no arguments
TRIED = {"Accelerometer", "Attachment", "Counterweight", "GuideSurface", "MeasuredRun", "Rotor"}  # results which callers make as well
RESULTS = {"ElasticRun", "ForceInterval", "Job", "Linkage", "Trial"}  # which no function returns by name


def law(*_: object) -> str:
    return "a force"


RINGED: list[Any] = []
RINGED.append(RINGED)

ODD: dict[str, Any] = {
    "None": None,
    "empty text": "",
    "text": "x",
    "number as text": "1.0",
    "bytes": b"x",
    "object": object(),
    "nan": math.nan,
    "inf": math.inf,
    "-inf": -math.inf,
    "0": 0,
    "-1": -1,
    "tiny": 1e-300,
    "huge": 1e300,
    "-huge": -1e300,
    "whole": 10**30,
    "beyond": 10**400,
    "True": True,
    "complex": 1 + 2j,
    "[]": [],
    "()": (),
    "{}": {},
    "ragged": [[1.0], [1.0, 2.0]],
    "ringed": RINGED,
    "texts": ["x", "y"],
    "mapping": {"x": "y"},
    "mapping of numbers": {1: 2},
    "masked": np.ma.array([1.0, 2.0], mask=[False, True]),
    "dates": np.array(["2026-01-01", "2026-01-02"], dtype="datetime64[D]"),
    "date": datetime(2026, 1, 1),
    "span": np.timedelta64(3, "s"),
    "truths": np.array([True, False]),
    "nans": [math.nan, 1.0, 2.0],
    "infs": [math.inf, 1.0, 2.0],
    "huges": [1e300, 1e300, 1e300],
    "no length": [0.0, 0.0, 0.0],
    "cube": np.zeros((2, 2, 2)),
    "class": float,
    "library class": pp.Motion,
    "law": law,
    "wrong law": lambda *_: np.zeros(7),
    "module": math,
}


class Inline(Executor):
    """Works in this process: a sweep need not start others."""

    def submit(self, function: Any, /, *given: Any, **named: Any) -> Any:
        from concurrent.futures import Future

        future: Any = Future()
        try:
            future.set_result(function(*given, **named))
        except Exception as error:
            future.set_exception(error)
        return future


def swept(x: float) -> dict[str, float]:
    return {"y": x}


@cache
def run() -> pp.Run:
    return pp.simulate(press(), 1.0, speed=7.0, drive=pp.drives.ConstantTorque(1.0))


@cache
def servo_run() -> pp.Run:
    losses = {"copper": 0.01, "rated_rise": 80.0, "thermal_time": 1800.0}
    motor = pp.drives.ServoMotor([0.0, 0.3], [0.0, 6.0], 1e3, 1e2, 500.0, inertia=1.0, rated_torque=100.0, **losses)
    return pp.simulate(press(), 0.3, speed=0.0, drive=pp.drives.Geared(motor, 2.0))


def loose() -> pp.elasticity.Elastic:
    """Soft bearings, and clearance in one."""
    stiffness = pp.elasticity.Stiffness(dict.fromkeys(press().bearings, 2e7), moments={"slide_guide": 2e6})
    return pp.elasticity.Elastic(stiffness, clearances={"P": pp.elasticity.Clearance(1e-4)})


@cache
def elastic_run() -> pp.Run | pp.ElasticRun:
    return pp.simulate(press(), 0.22, drive=pp.drives.PrescribedSpeed(30.0), elastic=loose(), points=21)


@cache
def served() -> pp.servo.ServoMotion:
    return pp.servo.constant_crank_speed(**arguments("servo.constant_crank_speed"))


@cache
def bearings() -> dict[str, Any]:
    return dict(measures.bearing_positions(press(), motion()))


@cache
def two_lengths() -> list[pp.tolerances.Dimension]:
    return [pp.tolerances.link_length(press(), *pins, 1e-5) for pins in ("OP", "PW")]


def accelerations() -> dict[str, Any]:
    """One channel, a crank angle and a tacho."""
    time = np.arange(400) / 100
    return {"time [s]": time, "A [g]": np.sin(9 * time), "crank [rad]": 9 * time, "tacho [V]": np.sign(np.sin(9 * time))}


def radius(trial: pp.synthesis.Trial) -> float:
    return trial.variables["radius"]


def negative_radius(trial: pp.synthesis.Trial) -> float:
    return -radius(trial)


LENGTHS = {("W", "rod"): (0.41, 0.0, 0.0)}
SLOW_DOWN = pp.servo.SlideSpeed(0.1, (0.01, 0.0))
FRAME_MATRICES = {
    "mass": np.eye(12),
    "stiffness": np.kron([[1.0, -1.0], [-1.0, 1.0]], 1e6 * np.eye(6)),
    "nodes": [(0.0, 0.0, 0.0), (0.0, 0.0, 0.0)],
    "degrees": [(k, i) for k in (0, 1) for i in range(6)],
    "lines": [(0, 1)],
}
TIMES = np.linspace(0.0, 10.0, 500)
PIN_TABLE_KEYS = PIN_TABLE | {
    "gears": {},
    "copies": [],
    "density": 7850,
    "press": "crank_slide",
    "note": "a table",
}


class Late(partial):
    """A value that is calculated when it is asked for."""


# Valid values by the name of the parameter, where a parameter has no default or needs another.
SHARED: dict[str, Any] = {
    "press": Late(press),
    "motion": Late(motion),
    "reactions": Late(reactions),
    "run": Late(run),
    "flywheel": pp.drives.Flywheel(1.0),
    "speed": 7.0,
    "speeds": [5.0, 6.0],
    "points": 12,
    "force": 1e3,
    "link": "rod",
    "bearing": "P",
    "between": ("P", "W"),
    "page": "none.html",
}
FUNCTIONS: dict[str, dict[str, Any]] = {
    "build": PIN_TABLE_KEYS | {"gravity": (0.0, 0.0, -9.81)},
    "check": {"path": "crank_slide", "driver": "O", "slide": "slide"},
    "from_pinocchio": {
        "model": Late(lambda: press().model),
        "constraint_models": Late(lambda: press().constraint_models()),
        "drivers": "O",
        "q": Late(lambda: press().configuration(0.0)),
    },
    "inverse_kinematics": {"frame": "slide", "places": Late(lambda: press().placements("slide", [0.1, 0.2]))},
    "inverse_dynamics": {"friction": {"O": pp.loads.Friction(0.1, 0.02)}, "bearings": ("O",)},
    "load": {"path": "crank_slide", "driver": "O", "slide": "slide"},
    "read_motion": {"path": TESTS / "kinematics" / "turn.csv", "period": 1.0},
    "record": {"path": FOLDER / "page.html", "traces": [("slide", (0.0, 0.0, 0.0))]},
    "record_modes": {
        "path": FOLDER / "page.html",
        "modes": Late(lambda: pp.elasticity.natural_frequencies(press(), every_result.on_springs(), angle=[0.1])),
    },
    "report": {"path": FOLDER / "page.html"},
    "servo_cycle": {"speed": [7.0, 7.0, 7.0], "angle": [0.0, 0.7, 1.4], "acceleration": 0.0, "time": [0.0, 0.1, 0.2]},
    "simulate": {"duration": 0.2, "drive": pp.drives.ConstantTorque(1.0), "method": "reduced"},
    "simulate_batch": {"duration": 0.2, "drive": pp.drives.ConstantTorque(1.0), "speed": [7.0, 8.0]},
    "steady_state": {
        "drive": pp.drives.Geared(pp.drives.InductionMotor(1e4, 150.0), 20.0),
        "flywheel": pp.drives.Flywheel(100.0),
        "loads": [pp.loads.ConstantForce(1e3, 0.01)],
    },
    "view": {"press": "none.urdf", "browser": False},
    "write_sdf": {"path": FOLDER / "written"},
    "write_urdf": {"path": FOLDER / "written"},
    "write_mjcf": {"path": FOLDER / "written.xml"},
    "accuracy.compare": {"duration": 0.01, "points": 3, "repeats": 1, "scenes": ["free run"]},
    "accuracy.plot": {"measured": every_result.ACCURACY},
    "balancing": {
        "regions": [pp.balancing.CounterweightRegion("crank", radius=0.3, mass=(0.0, 50.0))],
        "minimise": every_result.Z,
        "first": every_result.Z,
        "second": pp.balancing.AddedMass(),
        "points": 3,
        "conditions": Late(lambda: [pp.balancing.OperatingCondition(motion(), name=name) for name in ("one", "two")]),
        "counterweights": [pp.balancing.Counterweight("crank", 1.0)],
    },
    "balancing.balance": {"limits": {pp.balancing.AddedMass(): 20.0}, "shares": [1.0]},
    "derivatives": {"directions": [LENGTHS], "pivots": LENGTHS},
    "drives.parameter": {"unit": "N m", "sign": "positive", "scenarios": True, "axes": 0, "remark": ""},
    "elasticity": {
        "elastic": Late(every_result.on_springs),
        "stiffness": every_result.STIFFNESS,
        "angle": [0.1, 0.2],
        "orders": 3,
        "modes": 2,
        "elements": 4,
        "area": 0.01,
        "second_moment": 1e-5,
        "damping_ratio": 0.05,
        "mass": 500.0,
        "run": Late(elastic_run),
    },
    "elasticity.dead_centre_shift": {"speed": [5.0, 6.0]},
    "elasticity.eight_way_guide": {
        "facing_x": (0.3, 0.2),
        "facing_y": (0.25, 0.28),
        "length": 0.5,
        "width": 0.1,
        "stiffness": 1e9,
        "preload": 2e4,
    },
    "elasticity.guide_contact": {
        "surfaces": Late(lambda: pp.elasticity.eight_way_guide(**arguments("elasticity.eight_way_guide"))),
        "offset": (0.01, 0.01, 0.0),
    },
    "elasticity.hertz_stiffness": {"bearing_radius": 0.05, "journal_radius": 0.0499},
    "elasticity.impact_statistics": {"elastic": Late(loose), "speed": 30.0, "turns": 1, "settling": 0, "starts": 1},
    "elasticity.permissible_breakthrough": {"reverse_force": 1e4, "stiffness": 1e9, "break_time": 1e-3, "clearance": 1e-4},
    "elasticity.read_flexible_link": {"file": FOLDER / "rod.npz", "bearings": {"P": 0, "W": 1}, "stiffness": None},
    "elasticity.snap_through": {"force": 1e5, "stiffness": 1e9, "break_time": 1e-3, "clearance": 1e-4},
    "elasticity.wear_depth": {"radius": 0.05, "width": 0.1, "hardness": 1e9, "coefficient": 1e-7},
    "export.c_code": {"table": Late(every_result.tabulated), "path": FOLDER / "press.c"},
    "export.fmu": {"table": Late(every_result.tabulated), "path": FOLDER / "press.fmu", "compiler": None, "platform": "linux64"},
    "export.matlab": {"table": Late(every_result.tabulated), "path": FOLDER / "press.m"},
    "fe.load_cases": {"at": "peak W"},
    "foundation": {
        "system": Late(every_result.mounted),
        "frame": FRAME,
        "mounts": every_result.MOUNTS,
        "points": {"top": (0.0, 0.0, 1.0)},
        "bed": "a",
        "carrier": "b",
        "bearings": {"O": "a"},
        "modes": 2,
    },
    "foundation.beam_frame": {"places": {"a": (0.0, 0.0, 0.0), "b": (0.0, 1.0, 0.0)}, "beams": [BEAM], "elements": 2},
    "foundation.isolate": {"speeds": [50.0, 60.0], "transmitted": 0.5},
    "foundation.logarithmic_decrement": {"signal": np.exp(-0.1 * TIMES) * np.cos(3 * TIMES), "rate": 10.0, "band": (0.1, 2.0)},
    "foundation.mounted": {"attached": {"motor": foundation.Attachment(FRAME)}, "rotors": [ROTOR], "motion": None},
    "foundation.pad_mount": {"point": (0.0, 0.0, 0.0), "pad": foundation.RubberPad(0.1, 0.1, 0.03, 60.0)},
    "foundation.press_inertia": {"motion": None},
    "foundation.read_frame": {"file": "frame.npz", "interfaces": {"a": 0}, "carrier": "a"},
    "foundation.read_mounted": {"file": "frame.yaml", "motion": None},
    "foundation.reduced_frame": FRAME_MATRICES | {"interfaces": {"a": 0, "b": 1}},
    "foundation.transmissibility": {"frequency": [5.0, 6.0]},
    "foundation.whirl": {"system": Late(lambda: foundation.mounted(press(), FRAME, every_result.MOUNTS, rotors=[ROTOR]))},
    "loads.datum": {"load": pp.loads.ConstantForce(1e3, 0.01)},
    "loads.orifice_coefficient": {"piston": 0.1, "orifice": 0.01},
    "loads.pick_up_force": {"mass": 500.0, "speed": 0.3, "stiffness": 1e8, "preload": 1e5},
    "loads.step": {"x": [0.0, 0.5, 1.0], "x0": 0.0, "h0": 0.0, "x1": 1.0, "h1": 2.0},
    "measured": {
        "heights": [0.0, 0.02, 0.04],
        "heights_up": [0.0, 0.03],
        "stiffness": 1e9,
        "drive_inertia": 20.0,
        "known": {"slide mass": (100.0, 1.0)},
        "friction": ("crank", "pins", "slide_guide", "gibs"),
        "cylinder": True,
        "radii": {"O": 0.05},
        "runs": Late(lambda: [every_result.measured_run()]),
    },
    "measured.fit_mounts": {"system": Late(standing), "measured": Late(hit_modes)},
    "measured.force_sensor": {"friction": {"W": pp.loads.Friction(0.02, radius=0.03)}},
    "measured.measuring_motions": {"swing": 0.2, "speeds": [7.0], "count": 3},
    "measured.plan": {
        "motions": Late(lambda: {"even": motion()}),
        "noise": 10.0,
        "known": {},
        "friction": ["crank"],
        "expected": {"crank friction": 5.0},
        "wanted": ["slide mass"],
    },
    "measured.process_force": {"friction": {"W": pp.loads.Friction(0.02, radius=0.03)}, "run": Late(one_turn)},
    "measured.record": {
        "file": TESTS / "measured" / "short.csv",
        "angle": "crank [deg]",
        "torque": "motor [N m]",
        "time": "time [ms]",
        "ratio": 20.0,
        "zero": 1.0,
        "counts": 8192,
        "motor_constant": 3.0,
        "height": "height [mm]",
        "shaking_force": {"z": "force [kN]"},
        "shaking_moment": {"y": "moment [kN m]"},
        "added_mass": {"slide": 20.0},
        "between": (0.0, 0.5),
    },
    "measured.vibration": {
        "source": Late(accelerations),
        "points": {"A [g]": pp.measured.Accelerometer((0.0, 0.0, 1.0))},
        "time": "time [s]",
        "angle": "crank [rad]",
        "speed": None,
    },
    "measures": {
        "tolerance": 1e-3,
        "height": 0.05,
        "length": 0.05,
        "variation": 0.1,
        "orders": 3,
        "above": 0.05,
        "force": Late(lambda: reactions().shaking_force),
    },
    "measures.cam": {
        "press": Late(lambda: cams.press("ejector")),
        "reactions": Late(lambda: every_result.cam_reactions()),
        "name": "eject",
    },
    "mains.choose_drive": {
        "motors": {"11 kW": every_result.MAINS},
        "friction": {},
        "ratios": [15.0],
        "flywheels": (0.5, 1.0),
        "speeds": (9.0, 11.0),
        "speed_drop": 0.06,
        "start_time": 10.0,
    },
    "mains.read_motors": {"path": FOLDER / "motors.csv"},
    "measures.duty_cycle": {"end": 0.5},
    "measures.timing": {"feed_time": 0.1, "loads": [], "bars": {"ejector": (1.0, 2.0)}},
    "measures.poles": {"to": "frame"},
    "measures.workspace": {
        "press": Late(every_result.leg),
        "frame": "foot",
        "ranges": {"hip": (-0.1, 0.1), "crank": (0.0, 0.1)},
        "points": 3,
    },
    "measures.motor_energy": {
        "run": Late(servo_run),
        "initial_rise": 20.0,
        "link": pp.drives.DirectCurrentLink(0.05, 450.0, 560.0, 750.0, mains_power=1e6),
        "initial_voltage": 600.0,
    },
    "measures.pressure_angle": {"driven": Late(lambda: bearings()["W"]), "other": Late(lambda: bearings()["P"]), "axis": (0.0, 0.0, 1.0)},
    "measures.transmission_angle": {
        name: Late(lambda place=place: bearings()[place]) for name, place in zip(("pin", "one", "another"), "POW", strict=True)
    },
    "job": {"file": "crank_slide", "speed": 7.0, "loads": {"draw": every_result.DEEP}, "set": ["zero=tdc"], "variant": None},
    "pin_table.draft": PIN_TABLE_KEYS,
    "pin_table.dimension": {"drawn": Late(lambda: pp.pin_table.draft(**PIN_TABLE)), "number_name": "r", "tolerance": 1e-5},
    "pin_table.rods": {"drawn": Late(lambda: pp.pin_table.draft(**PIN_TABLE)), "modulus": 2e11},
    "plots.save": {"figure": Late(lambda: pp.plots.draw(motion(), "position")), "path": FOLDER / "plot.svg"},
    "ratings": {"capacities": CAPACITIES, "points": 9, "offset": (0.01, 0.0, 0.0), "gibs": pp.ratings.Gibs(0.5, 0.1), "pressure": 1e6},
    "ratings.rate": {"contact_height": 0.01, "dwell_tolerance": 1e-3},
    "ratings.rate_motion": {"capacities": pp.ratings.Capacities(1e5, drivers={"O": 1e6})},
    "ratings.speed_limit": {"torque": 1e3},
    "ratings.pins": {"bearings": {"W": pp.ratings.PlainBearing(0.08, 0.08), "O": pp.ratings.RollingBearing(5e5)}},
    "ratings.stopping": {"brake": 500.0, "delay": 0.03, "rise": 0.05, "monitor": 0.02, "inertia": 1.0},
    "servo": {
        "drive": every_result.SERVO,
        "time": 0.5,
        "points": 24,
        "ratios": [10.0],
        "limit": SLOW_DOWN,
        "limits": [SLOW_DOWN],
        "motion": Late(served),
        "motor": MOTOR,
        "motors": [MOTOR],
        "pause": 0.1,
    },
    "servo.best_motion": {"limits": [pp.servo.CrankSpeed(50.0)], "path": pp.servo.Stop(), "time": 1.0},
    "servo.cam_table": {"of": "height", "layout": "xyva", "tolerance": 1e-4, "motion": Late(motion)},
    "servo.choose_motor": {"limits": [], "time": 1.0},
    "servo.compare_motions": {"motions": Late(lambda: {"even": served()})},
    "servo.controller_table": {"of": "height", "step": 0.01},
    "servo.evaluate": {"time": [0.0, 0.5, 1.0], "angle": [0.0, 3.0, 6.0], "speed": 6.0, "acceleration": 0.0},
    "servo.motion_by_law": {"law": "cubic", "path": pp.servo.Stop(0.1)},
    "servo.read_motors": {"path": FOLDER / "motors.csv"},
    "servo.trade_off": {"limits": [pp.servo.CrankSpeed(50.0)], "path": pp.servo.Stop(), "times": [1.0, 2.0]},
    "servo.vdi_law": {"name": "3-4-5"},
    "sweeps": {"ranges": {"x": (0.0, 1.0), "y": (2.0, 3.0)}, "levels": 3, "count": 5},
    "sweeps.operating_points": {"forces": [1e3, 2e3], "unit_load": pp.loads.ConstantForce(1.0, 0.01), "bearings": ["O"]},
    "sweeps.read": {"path": FOLDER / "swept.sqlite"},
    "sweeps.sweep": {"function": swept, "grid": {"x": [1.0, 2.0]}, "executor": Inline(), "in_flight": 2},
    "synthesis": CRANK_LENGTH | {"minimise": radius, "first": radius, "second": negative_radius, "designs": 2, "points": 12},
    "tolerances": {
        "tolerance": 1e-5,
        "first": "O",
        "second": "P",
        "clearance": {"W": 1e-5},
        "friction": {"W": pp.loads.Friction(0.1, 0.02)},
        "temperatures": every_result.WARM,
        "parts": Late(two_lengths),
        "samples": 50,
        "correlation": {("OP", "PW"): 0.5},
        "axis": (1, 0, 0),
    },
    "tolerances.allocate": {"cost": {"OP": 2.0}, "targets": {"height": 1e-5, "stroke": 2e-5}, "bounds": {"PW": (1e-6, 1e-4)}},
    "tolerances.bottom_dead_centre": {"forces": {0.01: 1e5}, "speeds": {0.05: -7.0}, "motion": None},
    "tolerances.budget": {"process": 1e4, "temperatures": None, "speeds": [7.0]},
    "tolerances.parallelism": {
        "press": Late(texts.shipped, "jf75g_125_two_point"),
        "parts": Late(every_result.two_points),
        "correlation": None,
        "point_stiffness": 1e9,
        "guide_stiffness": 1e8,
        "samples": 20,
    },
    "tolerances.pin_angle": {"press": Late(texts.shipped, "zxn2_3000b"), "first": "C", "vertex": "D", "second": "E"},
    "tolerances.pin_position": {"link": "crank"},
    "tolerances.play_over_speeds": {"speed": [7.0]},
    "tolerances.read_dimensions": {"path": FOLDER / "dimensions.csv", "of_table": None},
    "video.film": {"path": FOLDER / "film.gif", "size": (320, 200), "frames_per_second": 2, "slowdown": 1.0},
    "video.image": {"path": FOLDER / "image.png", "size": (320, 200)},
    "video.pdf": {"path": FOLDER / "page.pdf"},
    "classical": {
        "radius": 0.1,
        "rod_radius": 0.2,
        "crank_radius": 0.2,
        "shaft_distance": 0.5,
        "link": "crank",
        "ratio": 0.2,
        "before": Late(reactions),
        "after": Late(reactions),
        "orders": 3,
        "masses": [1.0],
        "positions": [[0.1, 0.2, 0.0]],
        "planes": [0.0, 1.0],
    },
    "classical.static_balance": {"positions": [[0.1, 0.0, 0.0]]},
    "classical.with_balance_shafts": {"orders": [1, 2]},
    "classical.with_opposed_balancer": {"crank_radius": 0.1, "rod_length": 0.4, "rod_mass": 1.0, "rod_inertia": 0.1, "die_mass": 5.0},
}
# Other arguments of what is called above, and methods of results.
TIME = np.arange(8) / 8
OTHERS: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    "SwitchPoint of an angle": (pp.drives.SwitchPoint, {"angle": 1.0}),
    "CounterweightRegion at a place": (pp.balancing.CounterweightRegion, {"link": "crank", "at": (0.1, 0.0, 0.0), "reset": "mass"}),
    "CounterweightRegion of corners": (
        pp.balancing.CounterweightRegion,
        {"link": "crank", "corners": ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.0, 0.1))},
    ),
    "steady_state elastic": (
        pp.steady_state,
        {"drive": pp.drives.PrescribedSpeed(7.0), "elastic": Late(every_result.on_springs), "tolerance": 1e-4, "flywheel": None},
    ),
    "servo_cycle of heights": (
        pp.servo_cycle,
        {"time": TIME, "height": 0.1 + 0.05 * np.cos(2 * np.pi * TIME), "flank": "down", "period": 1.0, "speed": None},
    ),
    "plots.draw": (lambda result, name: pp.plots.draw(result, name), {"result": Late(reactions), "name": "torque"}),
    "Linkage.configuration": (lambda angle: press().configuration(angle), {"angle": [0.1, 0.2]}),
    "OrderSpectra.with_modes": (
        lambda modes: every_result.vibrations().order_spectra(3).with_modes(modes),
        {"modes": Late(lambda: foundation.modes(standing()))},
    ),
    "Scatter.with_limit": (lambda limit: every_result.scattered().height.with_limit(limit), {"limit": 5e-5}),
}


@cache
def calls() -> dict[str, tuple[Callable[..., Any], dict[str, Any]]]:
    """Name of a public function or class with its room -> it, and valid arguments of all its parameters, some of which are late."""
    found: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {}
    results = {kind.__name__ for kind in every_result.returned()} - TRIED | RESULTS
    seen = set()
    for room in every_result.rooms():
        title = "" if room is pp else room.__name__.rpartition(".")[2]
        for name in dir(room):
            thing = getattr(room, name)
            if inspect.ismodule(thing) or thing in seen or name in results | NOT_TRIED:
                continue
            seen.add(thing)
            label = f"{title}.{name}".strip(".")
            if inspect.isfunction(thing):
                found[label] = thing, taken(thing, FUNCTIONS.get(title, {}) | FUNCTIONS.get(label, {}))
            elif inspect.isclass(thing) and dataclasses.is_dataclass(thing):
                found[label] = thing, {field.name: Late(of_example, thing, field.name) for field in dataclasses.fields(thing) if field.init}
    return found | {label: (called, taken(called, values)) for label, (called, values) in OTHERS.items()}


def taken(called: Callable[..., Any], values: dict[str, Any]) -> dict[str, Any]:
    """A value for every parameter: one of these, a shared one, or the default."""
    parameters = inspect.signature(called).parameters.values()
    shared = {} if inspect.isclass(called) else SHARED
    if any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters):
        return values
    return {parameter.name: (shared | values).get(parameter.name, parameter.default) for parameter in parameters}


@cache
def examples() -> dict[type, Any]:
    return {type(example): example for example in reversed(every_result.descriptions())}


def of_example(kind: type, name: str) -> Any:
    return getattr(examples()[kind], name)


def arguments(name: str) -> dict[str, Any]:
    """Valid ones of a call."""
    return {parameter: value() if isinstance(value, Late) else value for parameter, value in calls()[name][1].items()}


def cases(*words: str) -> Iterator[tuple[str, str, str]]:
    """Name of a call, argument, and odd value in its place."""
    for name, (_, valid) in calls().items():
        if not words or any(word in name for word in words):
            yield from ((name, argument, value) for argument, value in itertools.product(valid, ODD))


def judge(name: str, argument: str, value: str, no_number: bool = False) -> str | None:
    """What is wrong with how a call takes an odd value; None if nothing is. no_number: it has to be refused."""
    return problem(calls()[name][0], arguments(name) | {argument: ODD[value]}, no_number)


def problem(called: Callable[..., Any], given: dict[str, Any], no_number: bool = False) -> str | None:
    """What is wrong with how arguments are taken: any exception but a refusal with a message, or none where a number is wanted."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", pp.PinpressWarning)
        try:
            with within(SECONDS):
                called(**given)
        except pp.PinpressError as error:
            return "no message" if len(str(error)) < 10 else None
        except BaseException as error:
            place = inspect.trace()[-1]
            return f"{type(error).__name__}: {str(error)[:150]} ({Path(place.filename).name}:{place.lineno})"
    return "taken for a number" if no_number else None


def main(words: list[str]) -> int:
    wrong = count = 0
    for name, argument, value in cases(*words):
        count += 1
        if said := judge(name, argument, value):
            wrong += 1
            print(f"{name}({argument}={value}): {said}", flush=True)
    print(f"{count} calls, {wrong} of them wrong")
    return min(wrong, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
