"""What may be handed to the public functions and classes by mistake: valid arguments of each, and odd values to put in their places.

python tests/support/generators/hostile_arguments.py                     # every value in every place, with what came of it where that is
wrong
python tests/support/generators/hostile_arguments.py simulate loads.     # of these only
"""

# ruff: noqa: T201
import inspect
import itertools
import math
import sys
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import numpy as np
from support import texts
from support.every_result import hit_modes, one_turn, vibrations
from support.hammer_hits import standing
from support.time_limit import within

import pinpress as pp
from pinpress import foundation
from pinpress.balancing import classical
from pinpress.common.results import Records
from pinpress.kinematics import measures

SECONDS = 60.0  # that a call may take, on a machine with much else to do; most take milliseconds
FOLDER = Path("/nowhere")  # nothing is written
MOTION = Path(__file__).resolve().parents[2] / "kinematics" / "turn.csv"
RECORD = Path(__file__).resolve().parents[2] / "measured" / "short.csv"


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


@cache
def press() -> pp.Linkage:
    return texts.shipped("crank_slide")


def table() -> dict[str, object]:
    return {
        "units": "mm",
        "parameters": {"r": 100},
        "frame": "O",
        "pins": {"O": [0, 0], "P": {"from": "O", "length": "r", "angle": -90}, "W": {"P": 400, "x": 0, "side": "down"}},
        "links": {
            "crank": {"pins": "O P", "mass": 20},
            "rod": {"pins": "P W", "mass": 15},
            "slide": {"pins": "W", "guide": "up", "mass": 100},
        },
        "drive": "O",
        "gears": {},
        "copies": [],
        "density": 7850,
        "press": "crank_slide",
        "note": "a table",
        "gravity": (0.0, 0.0, -9.81),
    }


@cache
def scattered() -> pp.tolerances.Scatter:
    return pp.tolerances.bottom_dead_centre(press(), [pp.tolerances.link_length(press(), "P", "W", 5e-5)], samples=50).height


def servo_numbers() -> dict[str, Any]:
    return {
        "inertia": 0.1,
        "ratio": 10.0,
        "peak_torque": 500.0,
        "rated_torque": 100.0,
        "top_speed": 300.0,
        "power": 1e5,
        "copper": 0.1,
        "iron": 0.1,
        "viscous": 0.1,
        "regeneration": 0.5,
        "gear_inertia": 10.0,
    }


def servo_cycle() -> dict[str, Any]:
    drive = pp.servo.ServoDrive(**servo_numbers())
    return {"press": press(), "drive": drive, "loads": [], "time": 0.5, "path": pp.servo.Turn(), "points": 48}


def catalogue_numbers() -> dict[str, Any]:
    curves = {"speed": [0.0, 100.0, 200.0], "rated_torque": [30.0, 28.0, 14.0], "peak_torque": [80.0, 80.0, 40.0]}
    return {"name": "short", "inertia": 0.1, **curves, "copper": 0.01}


def swinging() -> dict[str, Any]:
    return {"press": press(), "speeds": [7.0], "swing": 0.2, "strokes": [2.6], "count": 3}


def planned() -> dict[str, Any]:
    asked = {"noise": 10.0, "time": 20.0, "rate": 100.0, "prior": 0.1, "known": {}, "friction": ["crank"], "cylinder": True}
    motions = {"even": pp.cycle(press(), 7.0, points=24)}
    return {"press": press(), "motions": motions, **asked, "expected": {"crank friction": 5.0}, "wanted": ["slide mass"]}


def sensing() -> dict[str, Any]:
    laws = {"W": pp.loads.Friction(0.02, radius=0.03)}
    return {
        "press": press(),
        "heights": [0.0, 0.02, 0.04],
        "heights_up": [0.0, 0.03],
        "friction": laws,
        "drive_inertia": 20.0,
        "stiffness": 1e9,
    }


def accelerations() -> dict[str, Any]:
    """One channel, a crank angle and a tacho."""
    time = np.arange(400) / 100
    columns = {"time [s]": time, "A [g]": np.sin(9 * time), "crank [rad]": 9 * time, "tacho [V]": np.sign(np.sin(9 * time))}
    asked = {"time": "time [s]", "angle": "crank [rad]", "tacho": None, "pulses": 1, "speed": None}
    return {"source": columns, "points": {"A [g]": pp.measured.Accelerometer((0.0, 0.0, 1.0))}, **asked}


def measured_numbers() -> dict[str, Any]:
    """A record of every kind of column."""
    time = np.linspace(0.0, 1.0, 101)
    torque = 100 + np.sin(20 * time)
    return {
        "time": time,
        "angle": 6.0 * time,
        "torque": torque,
        "current": None,
        "shaking_force": {"z": torque},
        "shaking_moment": {"y": torque},
        "height": 0.1 * time,
        "added_mass": {"slide": 20.0},
        "name": "run",
    }


@cache
def measured_run() -> pp.measured.MeasuredRun:
    time = np.linspace(0.0, 3.0, 601)
    motion = pp.servo_cycle(press(), 8.0 * time + np.sin(2.5 * time), time=time)
    torque = pp.inverse_dynamics(press(), motion).driving_torque + 20.0 + 2.0 * np.sin(1e3 * time)
    return pp.measured.MeasuredRun(time, 8.0 * time + np.sin(2.5 * time), torque)


def identified() -> dict[str, Any]:
    return {
        "press": press(),
        "runs": [measured_run()],
        "prior": 0.2,
        "known": {"slide mass": (100.0, 1.0)},
        "friction": ("crank", "pins", "slide_guide", "gibs"),
        "cylinder": True,
        "radii": {"O": 0.05},
        "drive_inertia": 1.0,
        "loads": [],
    }


def revealed() -> dict[str, Any]:
    return {name: value for name, value in identified().items() if name not in ("drive_inertia", "loads")} | {"noise": 0.01}


def record_names() -> dict[str, Any]:
    """Arguments of a record: a file that has such columns."""
    return {
        "file": RECORD,
        "angle": "crank [deg]",
        "torque": "motor [N m]",
        "time": "time [ms]",
        "ratio": 20.0,
        "angle_ratio": 1.0,
        "zero": 1.0,
        "counts": 8192,
        "motor_constant": 3.0,
        "height": "height [mm]",
        "shaking_force": {"z": "force [kN]"},
        "shaking_moment": {"y": "moment [kN m]"},
        "added_mass": {"slide": 20.0},
        "between": (0.0, 0.5),
    }


@cache
def served() -> pp.servo.ServoMotion:
    return pp.servo.constant_crank_speed(**servo_cycle())


def servo_window() -> dict[str, Any]:
    return {"limit": pp.servo.SlideSpeed(0.1, (0.01, 0.0))}


@cache
def motion() -> pp.Motion:
    return pp.cycle(press(), 7.0, points=24)


@cache
def reactions() -> pp.Reactions:
    return pp.inverse_dynamics(press(), motion())


@cache
def run() -> pp.Run:
    return pp.simulate(press(), 1.0, speed=7.0, drive=pp.drives.ConstantTorque(1.0))


LINK = pp.drives.DirectCurrentLink(0.05, 450.0, 560.0, 750.0, mains_power=1e6)


@cache
def servo_run() -> pp.Run:
    losses = {"copper": 0.01, "rated_rise": 80.0, "thermal_time": 1800.0}
    motor = pp.drives.ServoMotor([0.0, 0.3], [0.0, 6.0], 1e3, 1e2, 500.0, inertia=1.0, rated_torque=100.0, **losses)
    return pp.simulate(press(), 0.3, speed=0.0, drive=pp.drives.Geared(motor, 2.0))


@cache
def elastic_run() -> pp.ElasticRun:
    drive, elastic = pp.drives.PrescribedSpeed(30.0), pp.elasticity.Elastic(springs(), clearances={"P": pp.elasticity.Clearance(1e-4)})
    run = pp.simulate(press(), 0.22, drive=drive, elastic=elastic, points=21)
    assert isinstance(run, pp.ElasticRun)
    return run


@cache
def flexible_link() -> dict[str, Any]:
    """Two points on a spring that does not bend."""
    stiffness, degrees = np.zeros((4, 4)), [[0, 0], [0, 1], [1, 0], [1, 1]]
    stiffness[np.ix_([0, 2], [0, 2])] = 1e9 * np.array([[1, -1], [-1, 1]])
    named = {"link": "rod", "bearings": {"P": 0, "W": 1}, "modes": 2, "damping_ratio": 0.01}
    return named | {"mass": np.eye(4), "stiffness": stiffness, "nodes": [[0.0, 0.0], [0.5, 0.0]], "degrees": degrees}


EIGHT_WAY: dict[str, Any] = {
    "facing_x": (0.3, 0.2),
    "facing_y": (0.25, 0.28),
    "length": 0.5,
    "width": 0.1,
    "stiffness": 1e9,
    "preload": 2e4,
}


def springs() -> pp.elasticity.Stiffness:
    bearings = dict.fromkeys(press().bearings, 2e7)
    return pp.elasticity.Stiffness(bearings, moments={"slide_guide": 2e6})


@cache
def on_springs() -> pp.elasticity.Elastic:
    return pp.elasticity.Elastic(springs())


@cache
def elastic_stroke() -> pp.Run:
    return pp.steady_state(press(), 7.0, drive=pp.drives.PrescribedSpeed(7.0), elastic=on_springs(), points=11)


@cache
def diagram() -> pp.elasticity.CampbellDiagram:
    return pp.elasticity.campbell(press(), on_springs(), speeds=[5.0, 6.0], orders=3)


@cache
def stiffness() -> pp.elasticity.Stiffness:
    return pp.elasticity.Stiffness(bearings={"O": 1e9, "P": 1e9, "W": 1e9})


@cache
def system() -> foundation.MountedPress:
    frame = foundation.Frame(1000.0, (0.0, 0.0, 0.3), (500.0, 500.0, 500.0))
    return foundation.mounted(press(), frame, [mount(x, y) for x in (-0.5, 0.5) for y in (-0.4, 0.4)])


def beam_model() -> dict[str, object]:
    return {
        "places": {"a": (0.0, 0.0, 0.0), "b": (0.0, 1.0, 0.0)},
        "beams": [foundation.FrameBeam("a", "b", 0.3, 0.2, (0.0, 0.0, 1.0))],
        "bed": "a",
        "carrier": "b",
        "bearings": {"O": "a"},
        "elements": 2,
        "modes": 2,
        "loss_factor": 0.01,
    }


def matrices_of_a_frame() -> dict[str, object]:
    joined = np.kron([[1.0, -1.0], [-1.0, 1.0]], 1e6 * np.eye(6))
    return {
        "mass": np.eye(12),
        "stiffness": joined,
        "nodes": [(0.0, 0.0, 0.0), (0.0, 0.0, 0.0)],
        "degrees": [(k, i) for k in (0, 1) for i in range(6)],
        "interfaces": {"a": 0, "b": 1},
        "bed": "a",
        "carrier": "b",
        "bearings": {"O": "a"},
        "modes": 2,
        "loss_factor": 0.01,
        "lines": [(0, 1)],
    }


def spinning() -> foundation.MountedPress:
    return foundation.mounted(press(), system().frame, system().mounts, rotors=[foundation.Rotor(10.0, (0.0, 1.0, 0.0))])


def mount(x: float, y: float) -> foundation.Mount:
    return foundation.Mount((x, y, -0.2), (1e6, 1e6, 1e5), (1e3, 1e3, 1e3))


@cache
def elastic() -> pp.elasticity.SlideCompliance:
    return pp.elasticity.compliance(press(), stiffness())


@cache
def curve() -> pp.balancing.TradeOffCurve:
    return pp.balancing.trade_off(press(), motion(), regions=REGIONS, first=X, second=pp.balancing.AddedMass(), points=3)


@cache
def response() -> foundation.SpeedResponse:
    return foundation.over_speeds(system(), [5.0, 6.0], points={"top": (0.0, 0.0, 1.0)})


@cache
def vibration() -> foundation.FrameMotion:
    return foundation.steady_response(system(), reactions(), points={"top": (0.0, 0.0, 1.0)})


@cache
def rated() -> pp.ratings.PressRatings:
    return pp.ratings.rate(press(), 7.0, pp.ratings.Capacities(1e5), points=9)


@cache
def shift() -> pp.elasticity.ElasticDeadCentre:
    return pp.elasticity.dead_centre_shift(press(), stiffness(), speed=[5.0, 6.0])


def swept(x: float) -> dict[str, float]:
    return {"y": x}


X = pp.balancing.Range("shaking_force", "z")
REGIONS = [pp.balancing.CounterweightRegion("crank", radius=0.3, mass=(0.0, 50.0))]
PATH = FOLDER / "written"
SWEPT = FOLDER / "swept.sqlite"
LENGTHS = {("W", "rod"): (0.41, 0.0, 0.0)}
POINTS = {"top": (0.0, 0.0, 1.0)}


def _losses() -> dict[str, Any]:
    return {"load_loss": 1e3, "constant_loss": 200.0, "rated_rise": 80.0, "thermal_time": 1800.0}


def pins() -> dict[str, Any]:
    places = measures.bearing_positions(press(), motion())
    return {"pin": places["P"], "one": places["O"], "another": places["W"]}


Call = tuple[Callable[..., Any], Callable[[], dict[str, Any]]]


def calls() -> dict[str, Call]:
    """Name of a public function or class -> it, and what makes valid arguments of all its parameters that anything hangs on."""
    bare: dict[str, Any] = {"bearings": {"O": 1e9}, "moments": {}, "rods": [], "shaft": 1e6, "frame": 1e9}
    measured = {"quantity": "bearing_force", "axis": "x", "bearing": "O", "about": (0.0, 0.0, 0.0)}
    kinds: list[tuple[str, Callable[..., Any], Callable[[], dict[str, Any]]]] = [
        # descriptions
        ("Corner", pp.drives.Corner, lambda: {"speed": 10.0, "jump": True}),
        ("SwitchPoint", pp.drives.SwitchPoint, lambda: {"time": 1.0}),
        ("SwitchPoint", pp.drives.SwitchPoint, lambda: {"angle": 1.0}),
        (
            "Brake",
            pp.drives.Brake,
            lambda: {"torque": 100.0, "closes": pp.drives.SwitchPoint(time=1.0), "opens": pp.drives.SwitchPoint(time=2.0), "rise": 0.1},
        ),
        (
            "Clutch",
            pp.drives.Clutch,
            lambda: {"torque": 100.0, "closes": pp.drives.SwitchPoint(time=1.0), "opens": pp.drives.SwitchPoint(time=2.0), "rise": 0.1},
        ),
        (
            "DirectCurrentLink",
            pp.drives.DirectCurrentLink,
            lambda: {"capacitance": 0.05, "lower_voltage": 450.0, "charged_voltage": 560.0, "upper_voltage": 750.0, "mains_power": 3e4},
        ),
        (
            "Capacities",
            pp.ratings.Capacities,
            lambda: {
                "nominal_force": 1e5,
                "torque": 1e3,
                "bearings": {"O": 1e5},
                "flywheel_inertia": 10.0,
                "speed_drop": 0.1,
                "motor_power": 1e4,
                "slide_acceleration": 10.0,
                "shaking_force": 1e4,
            },
        ),
        ("OperatingCondition", pp.balancing.OperatingCondition, lambda: {"motion": motion(), "loads": [], "press": press(), "name": "one"}),
        ("ConstantTorque", pp.drives.ConstantTorque, lambda: {"value": 1.0}),
        ("Counterweight", pp.balancing.Counterweight, lambda: {"link": "crank", "mass": 1.0, "position": (0.1, 0.0, 0.0), "inertia": 0.1}),
        ("Flywheel", pp.drives.Flywheel, lambda: {"inertia": 1.0, "speed": 7.0}),
        ("Friction", pp.loads.Friction, lambda: {"coefficient": 0.1, "radius": 0.02, "viscous": 0.1, "preload": 0.0}),
        ("Gibs", pp.ratings.Gibs, lambda: {"length": 0.5, "width": 0.1, "normal": (1.0, 0.0, 0.0), "middle": 0.1, "one_sided": False}),
        (
            "GuideSurface",
            pp.elasticity.GuideSurface,
            lambda: {
                "name": "right",
                "point": (0.2, 0.0, 0.0),
                "normal": (1.0, 0.0, 0.0),
                "length": 0.5,
                "width": 0.1,
                "stiffness": 1e9,
                "preload": 2e4,
                "clearance": 0.0,
            },
        ),
        ("eight_way_guide", pp.elasticity.eight_way_guide, lambda: EIGHT_WAY | {"clearance": 0.0, "middle": 0.1}),
        (
            "guide_contact",
            pp.elasticity.guide_contact,
            lambda: {
                "press": press(),
                "reactions": reactions(),
                "surfaces": pp.elasticity.eight_way_guide(**EIGHT_WAY),
                "offset": (0.01, 0.01, 0.0),
            },
        ),
        ("Peak", pp.balancing.Peak, lambda: measured),
        ("Range", pp.balancing.Range, lambda: measured),
        ("Rms", pp.balancing.Rms, lambda: measured),
        ("build", pp.build, table),
        ("pin_table.draft", pp.pin_table.draft, lambda: {key: value for key, value in table().items() if key != "gravity"}),
        ("PointForce", pp.loads.PointForce, lambda: {"link": "slide", "force": (0.0, 0.0, 1.0), "point": (0.0, 0.0, 0.0)}),
        ("PreloadedJoint", pp.elasticity.PreloadedJoint, lambda: {"loaded": 1e9, "relieved": 3e9, "preload": 1e5}),
        ("Rod", pp.elasticity.Rod, lambda: {"link": "rod", "between": ("P", "W"), "stiffness": 1e9}),
        (
            "CounterweightRegion",
            pp.balancing.CounterweightRegion,
            lambda: {"link": "crank", "mass": (0.0, 10.0), "radius": 0.3, "centre": (0.0, 0.0, 0.0), "gyration": 0.1, "replaces": False},
        ),
        ("CounterweightRegion", pp.balancing.CounterweightRegion, lambda: {"link": "crank", "at": (0.1, 0.0, 0.0), "reset": "mass"}),
        (
            "CounterweightRegion",
            pp.balancing.CounterweightRegion,
            lambda: {"link": "crank", "corners": ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.0, 0.1))},
        ),
        (
            "SpringDamper",
            pp.loads.SpringDamper,
            lambda: {
                "link1": "frame",
                "link2": "slide",
                "stiffness": 1e4,
                "damping": 10.0,
                "free_length": 0.3,
                "point1": (0.0, 0.0, 1.0),
                "point2": (0.0, 0.0, 0.0),
            },
        ),
        ("Stiffness", pp.elasticity.Stiffness, lambda: bare),
        (
            "Elastic",
            pp.elasticity.Elastic,
            lambda: {"stiffness": stiffness(), "damping_ratio": 0.02, "dampers": {"O": 1e4}, "crown_mass": None},
        ),
        ("Clearance", pp.elasticity.Clearance, lambda: {"radial": 1e-4, "law": "hertz", "restitution": 0.7, "hertz_stiffness": 1e10}),
        (
            "flexible_beam",
            pp.elasticity.flexible_beam,
            lambda: {
                "press": press(),
                "link": "rod",
                "between": ("P", "W"),
                "area": 0.01,
                "second_moment": 1e-5,
                "modulus": 2e11,
                "elements": 4,
                "modes": 2,
                "damping_ratio": 0.01,
            },
        ),
        ("FlexibleLink", pp.elasticity.FlexibleLink, flexible_link),
        (
            "read_flexible_link",
            pp.elasticity.read_flexible_link,
            lambda: {"link": "rod", "file": FOLDER / "rod.npz", "bearings": {"P": 0, "W": 1}, "modes": 2, "damping_ratio": 0.01},
        ),
        ("journal_impacts", pp.elasticity.journal_impacts, lambda: {"run": elastic_run(), "bearing": "P"}),
        (
            "wear_depth",
            pp.elasticity.wear_depth,
            lambda: {"run": elastic_run(), "bearing": "P", "radius": 0.05, "width": 0.1, "hardness": 1e9, "coefficient": 1e-7},
        ),
        (
            "impact_statistics",
            pp.elasticity.impact_statistics,
            lambda: {
                "press": press(),
                "elastic": pp.elasticity.Elastic(springs(), clearances={"P": pp.elasticity.Clearance(1e-4)}),
                "bearing": "P",
                "speed": 30.0,
                "turns": 1,
                "settling": 0,
                "starts": 1,
                "loads": [],
            },
        ),
        ("hertz_stiffness", pp.elasticity.hertz_stiffness, lambda: {"bearing_radius": 0.05, "journal_radius": 0.0499}),
        (
            "steady_state elastic",
            pp.steady_state,
            lambda: {
                "press": press(),
                "speed": 7.0,
                "drive": pp.drives.PrescribedSpeed(7.0),
                "loads": [],
                "elastic": on_springs(),
                "points": 11,
                "tolerance": 1e-4,
            },
        ),
        ("loads.Blanking", pp.loads.Blanking, lambda: {"force": 1e3, "start": 0.01, "end": 0.005, "stripping": 10.0, "datum": 0.0}),
        ("loads.DeepDrawing", pp.loads.DeepDrawing, lambda: {"force": 1e3, "start": 0.01, "end": 0.0, "datum": 0.0}),
        ("loads.ElasticDie", pp.loads.ElasticDie, lambda: {"height": 0.01, "stiffness": 1e5, "damping": 10.0, "datum": 0.0}),
        (
            "loads.RateSensitiveBlanking",
            pp.loads.RateSensitiveBlanking,
            lambda: {
                "force": 1e3,
                "start": 0.01,
                "end": 0.005,
                "sensitivity": 0.05,
                "reference_speed": 1e-3,
                "peak": 0.007,
                "remaining": 0.5,
                "stripping": 10.0,
                "datum": 0.0,
            },
        ),
        (
            "loads.ImpactDamper",
            pp.loads.ImpactDamper,
            lambda: {"heights": [0.0, 0.01], "coefficients": [1e5, 2e5], "exponent": 2.0, "datum": 0.0},
        ),
        (
            "loads.HydraulicCushion",
            pp.loads.HydraulicCushion,
            lambda: {"force": 1e4, "height": 0.01, "rise": 1e-3, "return_force": 1e3, "datum": 0.0},
        ),
        (
            "loads.orifice_coefficient",
            pp.loads.orifice_coefficient,
            lambda: {"piston": 0.1, "orifice": 0.01, "density": 870.0, "discharge": 0.6},
        ),
        (
            "loads.pick_up_force",
            pp.loads.pick_up_force,
            lambda: {"mass": 500.0, "speed": 0.3, "stiffness": 1e8, "preload": 1e5},
        ),
        (
            "loads.Impact",
            pp.loads.Impact,
            lambda: {"height": 0.01, "stiffness": 1e7, "exponent": 1.5, "damping": 10.0, "depth": 1e-3, "datum": 0.0},
        ),
        (
            "loads.TwoSidedStop",
            pp.loads.TwoSidedStop,
            lambda: {"lower": 0.01, "upper": 0.02, "stiffness": 1e7, "exponent": 1.5, "damping": 10.0, "depth": 1e-3, "datum": 0.0},
        ),
        (
            "loads.BalanceCylinder",
            pp.loads.BalanceCylinder,
            lambda: {"bore": 0.1, "pressure": 6e5, "volume": 0.02, "rod": 0.03, "count": 2, "exponent": 1.4, "height": 0.0, "datum": 0.0},
        ),
        (
            "loads.PneumaticCushion",
            pp.loads.PneumaticCushion,
            lambda: {"bore": 0.1, "pressure": 6e5, "volume": 0.02, "height": 0.01, "rod": 0.03, "count": 2, "exponent": 1.4, "datum": 0.0},
        ),
        ("loads.ForceStroke", pp.loads.ForceStroke, lambda: {"heights": [0.0, 0.01, 0.02], "forces": [100.0, 50.0, 0.0]}),
        ("loads.Idle", pp.loads.Idle, lambda: {"datum": 0.0}),
        ("loads.ConstantForce", pp.loads.ConstantForce, lambda: {"force": 1e3, "height": 0.01, "datum": 0.0}),
        ("loads.TimeForce", pp.loads.TimeForce, lambda: {"force": lambda t: 10.0 + 0.0 * t}),
        ("loads.datum", pp.loads.datum, lambda: {"load": pp.loads.ConstantForce(1e3, 0.01), "press": press()}),
        ("loads.step", pp.loads.step, lambda: {"x": [0.0, 0.5, 1.0], "x0": 0.0, "h0": 0.0, "x1": 1.0, "h1": 2.0}),
        (
            "drives.Geared",
            pp.drives.Geared,
            lambda: {"drive": pp.drives.ConstantTorque(1.0), "ratio": 3.0, "gear_inertia": 0.1, "efficiency": 0.9},
        ),
        (
            "drives.InductionMotor",
            pp.drives.InductionMotor,
            lambda: {
                "rated_power": 1e4,
                "rated_speed": 150.0,
                "frequency": 50.0,
                "poles": 4,
                "breakdown_ratio": 2.5,
                "inertia": 0.1,
                **_losses(),
            },
        ),
        (
            "drives.InverterMotor",
            pp.drives.InverterMotor,
            lambda: {
                "rated_torque": 60.0,
                "rated_speed": 150.0,
                "frequency": 40.0,
                "rated_frequency": 50.0,
                "poles": 4,
                "overload": 1.5,
                "breakdown_ratio": 2.5,
                "inertia": 0.1,
                "inverter_efficiency": 0.97,
                "feeds_back": True,
                **_losses(),
            },
        ),
        (
            "tolerances.Dimension",
            pp.tolerances.Dimension,
            lambda: {"name": "OP", "tolerance": 1e-5, "direction": {("P", "crank"): (1, 0, 0)}},
        ),
        (
            "tolerances.link_length",
            pp.tolerances.link_length,
            lambda: {"press": press(), "first": "O", "second": "P", "tolerance": 1e-5, "shape": "truncated", "sd": 1e-5, "name": "r"},
        ),
        (
            "tolerances.pin_angle",
            pp.tolerances.pin_angle,
            lambda: {"press": texts.shipped("zxn2_3000b"), "first": "C", "vertex": "D", "second": "E", "tolerance": 1e-4},
        ),
        (
            "tolerances.pin_position",
            pp.tolerances.pin_position,
            lambda: {"press": press(), "bearing": "P", "axis": (1, 0, 0), "tolerance": 1e-5, "link": "crank"},
        ),
        (
            "tolerances.Temperatures",
            pp.tolerances.Temperatures,
            lambda: {"rise": {"rod": 10.0}, "expansion": 1.1e-5, "table": -0.8, "face": -0.1},
        ),
        (
            "tolerances.heat",
            pp.tolerances.heat,
            lambda: {"press": press(), "temperatures": pp.tolerances.Temperatures({"rod": 9.0}), "motion": motion()},
        ),
        (
            "tolerances.budget",
            pp.tolerances.budget,
            lambda: {
                "press": press(),
                "speeds": [7.0],
                "clearance": {"W": 1e-5},
                "process": 1e4,
                "loads": [],
                "known_to": 0.1,
                "stiffness_known_to": 0.1,
            },
        ),
        (
            "tolerances.parallelism",
            pp.tolerances.parallelism,
            lambda: {
                "press": texts.shipped("jf75g_125_two_point"),
                "parts": {"P4_front": [pp.tolerances.pin_position(texts.shipped("jf75g_125_two_point"), "O", "z", 1e-5)], "P4_back": []},
                "point_stiffness": 1e9,
                "guide_stiffness": 1e8,
                "samples": 20,
                "seed": 1,
            },
        ),
        (
            "tolerances.PermissibleSlope",
            pp.tolerances.PermissibleSlope,
            lambda: {"constant": 2e-5, "by_length": 6e-5, "force": 1e5, "place": (0.1, 0.0)},
        ),
        (
            "tolerances.GuideClearance",
            pp.tolerances.GuideClearance,
            lambda: {"across": 2e-5, "length": 0.2, "middle": 0.0},
        ),
        (
            "tolerances.play",
            pp.tolerances.play,
            lambda: {
                "press": press(),
                "motion": motion(),
                "clearance": {"W": 1e-5},
                "loads": [],
                "friction": {"W": pp.loads.Friction(0.1, 0.02)},
                "known_to": 0.1,
            },
        ),
        (
            "tolerances.play_over_speeds",
            pp.tolerances.play_over_speeds,
            lambda: {
                "press": press(),
                "clearance": {"W": 1e-5},
                "speed": [7.0],
                "loads": [],
                "friction": {"W": pp.loads.Friction(0.1, 0.02)},
                "known_to": 0.1,
            },
        ),
        (
            "tolerances.bottom_dead_centre",
            pp.tolerances.bottom_dead_centre,
            lambda: {
                "press": press(),
                "parts": [pp.tolerances.link_length(press(), *pins, 1e-5) for pins in ("OP", "PW")],
                "forces": {0.01: 1e5},
                "speeds": {0.05: -7.0},
                "correlation": {("OP", "PW"): 0.5},
                "samples": 50,
                "seed": 3,
            },
        ),
        (
            "tolerances.read_dimensions",
            pp.tolerances.read_dimensions,
            lambda: {"press": press(), "path": FOLDER / "dimensions.csv"},
        ),
        (
            "tolerances.allocate",
            pp.tolerances.allocate,
            lambda: {
                "press": press(),
                "parts": [pp.tolerances.link_length(press(), *pins, 1e-5) for pins in ("OP", "PW")],
                "cost": {"OP": 2.0},
                "targets": {"height": 1e-5, "stroke": 2e-5},
                "bounds": {"PW": (1e-6, 1e-4)},
                "deviations": 3.0,
                "motion": motion(),
                "correlation": {("OP", "PW"): 0.5},
            },
        ),
        ("servo.Turn", pp.servo.Turn, lambda: {"backwards": True}),
        ("servo.Stop", pp.servo.Stop, lambda: {"bottom": 0.1, "backwards": True}),
        ("servo.Pendulum", pp.servo.Pendulum, lambda: {"opening": 0.05, "dwell": 0.1}),
        ("servo.Pulse", pp.servo.Pulse, lambda: {"heights": (0.02, 0.01, 0.0), "back": 0.005, "dwell": 0.1}),
        ("servo.ServoDrive", pp.servo.ServoDrive, servo_numbers),
        ("servo.vdi_law", pp.servo.vdi_law, lambda: {"name": "3-4-5"}),
        ("servo.constant_crank_speed", pp.servo.constant_crank_speed, servo_cycle),
        ("servo.two_speed", pp.servo.two_speed, lambda: servo_cycle() | servo_window()),
        ("servo.constant_slide_speed", pp.servo.constant_slide_speed, lambda: servo_cycle() | servo_window()),
        ("servo.motion_by_law", pp.servo.motion_by_law, lambda: servo_cycle() | {"law": "cubic", "path": pp.servo.Stop(0.1)}),
        ("servo.ready_motions", pp.servo.ready_motions, lambda: servo_cycle() | {"limits": [*servo_window().values()]}),
        ("servo.CatalogueMotor", pp.servo.CatalogueMotor, catalogue_numbers),
        (
            "servo.motor_use",
            pp.servo.motor_use,
            lambda: {"motor": pp.servo.CatalogueMotor(**catalogue_numbers()), "motion": served(), "pause": 0.1},
        ),
        ("servo.read_motors", pp.servo.read_motors, lambda: {"path": FOLDER / "motors.csv"}),
        ("measured.MeasuredRun", pp.measured.MeasuredRun, measured_numbers),
        ("measured.record", pp.measured.record, record_names),
        ("measured.measuring_motions", pp.measured.measuring_motions, swinging),
        ("measured.plan", pp.measured.plan, planned),
        ("measured.force_sensor", pp.measured.force_sensor, sensing),
        ("measured.process_force", pp.measured.process_force, lambda: sensing() | {"run": one_turn()}),
        ("measured.Accelerometer", pp.measured.Accelerometer, lambda: {"point": (0.0, 0.0, 1.0), "direction": "z", "gain": 9.81}),
        ("measured.vibration", pp.measured.vibration, accelerations),
        ("measured.fit_mounts", pp.measured.fit_mounts, lambda: {"system": standing(), "measured": hit_modes(), "damping": "loss_factor"}),
        (
            "measured.OrderSpectra.with_modes",
            lambda modes: vibrations().order_spectra(3).with_modes(modes),
            lambda: {"modes": foundation.modes(standing())},
        ),
        ("measured.identify", pp.measured.identify, identified),
        ("measured.identifiability", pp.measured.identifiability, revealed),
        ("servo.compare_motions", pp.servo.compare_motions, lambda: {"motions": {"even": served()}, "limits": [*servo_window().values()]}),
        ("servo.controller_table", pp.servo.controller_table, lambda: {"motion": served(), "of": "height", "step": 0.01}),
        (
            "servo.choose_motor",
            pp.servo.choose_motor,
            lambda: {
                "press": press(),
                "motors": [pp.servo.CatalogueMotor(**catalogue_numbers())],
                "loads": [],
                "ratios": [10.0],
                "time": 1.0,
                "path": pp.servo.Turn(),
                "limits": [],
                "pause": 0.1,
                "gear_inertia": 1.0,
                "points": 24,
            },
        ),
        ("servo.capacitor", pp.servo.capacitor, lambda: {"motion": served(), "upper_voltage": 700.0, "lower_voltage": 400.0}),
        ("servo.SlideSpeed", pp.servo.SlideSpeed, lambda: {"speed": 0.5, "heights": (0.05, 0.0), "flank": "down", "constant": False}),
        ("servo.CrankSpeed", pp.servo.CrankSpeed, lambda: {"speed": 9.0, "heights": (0.05, 0.0), "flank": "both"}),
        ("servo.SlideAcceleration", pp.servo.SlideAcceleration, lambda: {"acceleration": 9.0, "heights": (0.05, 0.0), "flank": "both"}),
        ("servo.CrankAcceleration", pp.servo.CrankAcceleration, lambda: {"acceleration": 90.0}),
        ("servo.BearingForce", pp.servo.BearingForce, lambda: {"bearing": "O", "force": 1e5}),
        ("servo.TorqueRate", pp.servo.TorqueRate, lambda: {"rate": 1e4}),
        (
            "servo.trade_off",
            pp.servo.trade_off,
            lambda: {
                "press": press(),
                "drive": pp.servo.ServoDrive(inertia=1.0),
                "loads": [],
                "times": [1.0, 2.0],
                "minimise": "heat",
                "path": pp.servo.Stop(),
                "limits": [pp.servo.CrankSpeed(50.0)],
                "friction": {},
                "points": 24,
            },
        ),
        ("servo.RmsTorque", pp.servo.RmsTorque, lambda: {"torque": 100.0}),
        ("servo.FeedWindow", pp.servo.FeedWindow, lambda: {"height": 0.1, "time": 0.2}),
        (
            "servo.best_motion",
            pp.servo.best_motion,
            lambda: {
                "press": press(),
                "drive": pp.servo.ServoDrive(inertia=1.0),
                "loads": [],
                "minimise": "heat",
                "time": 1.0,
                "path": pp.servo.Stop(),
                "limits": [pp.servo.CrankSpeed(50.0)],
                "friction": {},
                "ratios": [1.0],
                "points": 24,
            },
        ),
        (
            "servo.evaluate",
            pp.servo.evaluate,
            lambda: {
                "press": press(),
                "drive": pp.servo.ServoDrive(**servo_numbers()),
                "loads": [],
                "time": [0.0, 0.5, 1.0],
                "angle": [0.0, 3.0, 6.0],
                "speed": 6.0,
                "acceleration": 0.0,
                "friction": {},
            },
        ),
        ("drives.PrescribedSpeed", pp.drives.PrescribedSpeed, lambda: {"speed": 7.0}),
        (
            "drives.ServoMotor",
            pp.drives.ServoMotor,
            lambda: {
                "times": [0.0, 0.5, 1.0],
                "angles": [0.0, 3.0, 7.0],
                "stiffness": 1e3,
                "damping": 100.0,
                "peak_torque": 500.0,
                "inertia": 0.1,
                "copper": 0.01,
                "regeneration": 0.5,
            },
        ),
        (
            "drives.SlipClutchMotor",
            pp.drives.SlipClutchMotor,
            lambda: {
                "rated_torque": 100.0,
                "primary_speed": 150.0,
                "top_speed": 120.0,
                "set_speed": 100.0,
                "regulation": 0.025,
                "lag": 0.01,
                "inertia": 0.1,
                "amplification": 0.3,
                "integral_time": 0.2,
                "feedback": 0.9,
                "residual_current": 0.1,
                "excitation_power": 100.0,
                **_losses(),
            },
        ),
        ("foundation.Frame", foundation.Frame, lambda: {"mass": 1e3, "centre": (0.0, 0.0, 0.3), "inertia": (500.0, 500.0, 500.0)}),
        (
            "foundation.Mount",
            foundation.Mount,
            lambda: {
                "point": (0.0, 0.0, 0.0),
                "stiffness": (1e6, 1e6, 1e6),
                "damping": (1.0, 1.0, 1.0),
                "loss_factor": 0.1,
                "static_stiffness": (1e6, 1e6, 1e6),
                "area": 0.1,
            },
        ),
        (
            "foundation.Attachment",
            foundation.Attachment,
            lambda: {"body": system().frame, "springs": system().mounts, "on": "frame"},
        ),
        (
            "foundation.FrameBeam",
            foundation.FrameBeam,
            lambda: {
                "start": "a",
                "end": "b",
                "width": 0.3,
                "height": 0.2,
                "across": (0.0, 0.0, 1.0),
                "wall": 0.02,
                "modulus": 2e11,
                "shear_modulus": 8e10,
                "density": 7850.0,
            },
        ),
        (
            "foundation.Rotor",
            foundation.Rotor,
            lambda: {"inertia": 10.0, "axis": (0.0, 1.0, 0.0), "ratio": 2.0, "on": "frame"},
        ),
        (
            "foundation.RubberPad",
            foundation.RubberPad,
            lambda: {
                "length": 0.1,
                "width": 0.1,
                "thickness": 0.03,
                "hardness": 60.0,
                "loss_factor": 0.1,
                "stiffening": 1.2,
                "bulk_modulus": 2e9,
            },
        ),
        # functions
        ("load", pp.load, lambda: {"path": "crank_slide", "driver": "O", "slide": "slide", "gravity": (0.0, 0.0, -9.81)}),
        ("check", pp.check, lambda: {"path": "crank_slide", "driver": "O", "slide": "slide"}),
        ("cycle", pp.cycle, lambda: {"press": press(), "speed": 7.0, "points": 12, "engine": "auto"}),
        (
            "servo_cycle",
            pp.servo_cycle,
            lambda: {
                "press": press(),
                "speed": [7.0, 7.0, 7.0],
                "angle": [0.0, 0.7, 1.4],
                "acceleration": 0.0,
                "time": [0.0, 0.1, 0.2],
                "engine": "plane",
            },
        ),
        (
            "read_motion",
            pp.read_motion,
            lambda: {"press": press(), "path": MOTION, "period": 1.0, "engine": "plane"},
        ),
        (
            "servo_cycle of heights",
            pp.servo_cycle,
            lambda: {
                "press": press(),
                "time": np.arange(8) / 8,
                "height": 0.1 + 0.05 * np.cos(np.arange(8) * np.pi / 4),
                "flank": "down",
                "period": 1.0,
            },
        ),
        ("dead_centres", pp.dead_centres, lambda: {"press": press()}),
        ("measures.least_transmission_angles", pp.measures.least_transmission_angles, lambda: {"press": press()}),
        (
            "measures.transmission_angle_curves",
            pp.measures.transmission_angle_curves,
            lambda: {"press": press(), "motion": motion()},
        ),
        (
            "inverse_dynamics",
            pp.inverse_dynamics,
            lambda: {
                "press": press(),
                "motion": motion(),
                "loads": [],
                "friction": {"O": pp.loads.Friction(0.1, 0.02)},
                "stiffness": {},
                "engine": "auto",
                "bearings": ("O",),
            },
        ),
        (
            "simulate",
            pp.simulate,
            lambda: {
                "press": press(),
                "duration": 0.2,
                "speed": 7.0,
                "angle": 0.0,
                "drive": pp.drives.ConstantTorque(1.0),
                "flywheel": pp.drives.Flywheel(1.0),
                "loads": [],
                "method": "reduced",
                "points": 11,
                "tolerance": 1e-9,
                "step": None,
                "clutch": None,
                "brake": None,
                "progress": None,
            },
        ),
        (
            "simulate_batch",
            pp.simulate_batch,
            lambda: {
                "press": press(),
                "duration": 0.2,
                "speed": [7.0, 8.0],
                "angle": 0.0,
                "drive": pp.drives.ConstantTorque(1.0),
                "flywheel": pp.drives.Flywheel(1.0),
                "loads": [],
                "points": 11,
                "tolerance": 1e-9,
            },
        ),
        (
            "drives.parameter",
            pp.drives.parameter,
            lambda: {"unit": "N m", "sign": "positive", "scenarios": True, "axes": 0, "remark": ""},
        ),
        (
            "steady_state",
            pp.steady_state,
            lambda: {
                "press": press(),
                "speed": 7.0,
                "drive": pp.drives.Geared(pp.drives.InductionMotor(1e4, 150.0), 20.0),
                "flywheel": pp.drives.Flywheel(100.0),
                "loads": [pp.loads.ConstantForce(1e3, 0.01)],
                "angle": 0.0,
                "points": 11,
                "tolerance": 1e-6,
            },
        ),
        ("duty_cycle", pp.measures.duty_cycle, lambda: {"run": run(), "start": 0.0, "end": 0.5}),
        ("duty_cycle", pp.measures.duty_cycle, lambda: {"run": run(), "end": 0.5}),
        ("stroke_duties", pp.measures.stroke_duties, lambda: {"run": run()}),
        (
            "motor_energy",
            pp.measures.motor_energy,
            lambda: {"run": servo_run(), "initial_rise": 20.0, "link": LINK, "initial_voltage": 600.0},
        ),
        ("extremes", pp.measures.extremes, lambda: {"reactions": reactions()}),
        ("driving_energy", pp.measures.driving_energy, lambda: {"reactions": reactions()}),
        ("harmonics", pp.measures.harmonics, lambda: {"motion": motion(), "force": reactions().shaking_force, "orders": 3}),
        (
            "operating_points",
            pp.sweeps.operating_points,
            lambda: {
                "press": press(),
                "speeds": [5.0, 6.0],
                "forces": [1.0, 2.0],
                "unit_load": pp.loads.ConstantForce(1.0, 0.01),
                "loads": [],
                "bearings": ["O"],
                "points": 12,
                "angles": False,
            },
        ),
        (
            "rate",
            pp.ratings.rate,
            lambda: {
                "press": press(),
                "speed": 7.0,
                "capacities": pp.ratings.Capacities(1e5, torque=1e3),
                "at_speed": False,
                "points": 9,
                "contact_height": 0.01,
                "dwell_tolerance": 1e-3,
                "engine": "auto",
            },
        ),
        (
            "rate_motion",
            pp.ratings.rate_motion,
            lambda: {
                "press": press(),
                "motion": motion(),
                "capacities": pp.ratings.Capacities(1e5, drivers={"O": 1e6}),
                "loads": [],
                "friction": {},
                "engine": "auto",
            },
        ),
        (
            "speed_limit",
            pp.ratings.speed_limit,
            lambda: {
                "press": press(),
                "capacities": pp.ratings.Capacities(1e5, bearings={"O": 1e5}),
                "torque": 1e3,
                "loads": [],
                "engine": "auto",
            },
        ),
        (
            "eccentric_load",
            pp.ratings.eccentric_load,
            lambda: {"press": press(), "motion": motion(), "force": 1e3, "offset": (0.01, 0.0, 0.0), "gibs": pp.ratings.Gibs(0.5, 0.1)},
        ),
        (
            "permissible_eccentricity",
            pp.ratings.permissible_eccentricity,
            lambda: {"press": press(), "motion": motion(), "force": 1e3, "gibs": pp.ratings.Gibs(0.5, 0.1), "pressure": 1e6},
        ),
        (
            "natural_frequencies",
            pp.elasticity.natural_frequencies,
            lambda: {"press": press(), "elastic": on_springs(), "angle": [0.1, 0.2], "flywheel": pp.drives.Flywheel(2.0)},
        ),
        ("campbell", pp.elasticity.campbell, lambda: {"press": press(), "elastic": on_springs(), "speeds": [5.0, 6.0], "orders": 3}),
        (
            "elasticity.over_speeds",
            pp.elasticity.over_speeds,
            lambda: {"press": press(), "elastic": on_springs(), "speeds": [5.0], "loads": []},
        ),
        ("compliance", pp.elasticity.compliance, lambda: {"press": press(), "stiffness": stiffness(), "angle": [0.1, 0.2]}),
        (
            "slide_deflection",
            pp.elasticity.slide_deflection,
            lambda: {"press": press(), "motion": motion(), "stiffness": stiffness(), "loads": []},
        ),
        ("dead_centre_shift", pp.elasticity.dead_centre_shift, lambda: {"press": press(), "stiffness": stiffness(), "speed": [5.0, 6.0]}),
        (
            "snap_through",
            pp.elasticity.snap_through,
            lambda: {"force": 1e5, "stiffness": 1e9, "mass": 500.0, "damping_ratio": 0.05, "break_time": 1e-3, "clearance": 1e-4},
        ),
        (
            "permissible_breakthrough",
            pp.elasticity.permissible_breakthrough,
            lambda: {
                "reverse_force": 1e4,
                "stiffness": 1e9,
                "mass": 500.0,
                "damping_ratio": 0.05,
                "break_time": 1e-3,
                "clearance": 1e-4,
            },
        ),
        ("motion_derivatives", pp.derivatives.motion_derivatives, lambda: {"press": press(), "motion": motion(), "directions": [LENGTHS]}),
        (
            "acceleration_derivatives",
            pp.derivatives.acceleration_derivatives,
            lambda: {"press": press(), "motion": motion(), "efforts": None, "armature": None},
        ),
        ("pivot_positions", pp.derivatives.pivot_positions, lambda: {"press": press()}),
        ("reshaped", pp.derivatives.reshaped, lambda: {"press": press(), "pivots": LENGTHS}),
        (
            "with_counterweights",
            pp.balancing.with_counterweights,
            lambda: {"press": press(), "counterweights": [pp.balancing.Counterweight("crank", 1.0)]},
        ),
        ("write_urdf", pp.write_urdf, lambda: {"press": press(), "path": PATH}),
        (
            "balance",
            pp.balancing.balance,
            lambda: {
                "press": press(),
                "motion": motion(),
                "regions": REGIONS,
                "minimise": X,
                "limits": {pp.balancing.AddedMass(): 20.0},
                "shares": [1.0],
            },
        ),
        (
            "compare_conditions",
            pp.balancing.compare_conditions,
            lambda: {
                "press": press(),
                "conditions": [
                    pp.balancing.OperatingCondition(motion(), name="one"),
                    pp.balancing.OperatingCondition(motion(), name="two"),
                ],
                "regions": REGIONS,
                "minimise": X,
                "limits": {},
            },
        ),
        (
            "trade_off",
            pp.balancing.trade_off,
            lambda: {
                "press": press(),
                "motion": motion(),
                "regions": REGIONS,
                "first": X,
                "second": pp.balancing.AddedMass(),
                "limits": {},
                "points": 3,
            },
        ),
        (
            "accuracy.compare",
            pp.accuracy.compare,
            lambda: {
                "press": press(),
                "speed": 7.0,
                "flywheel": None,
                "duration": 0.01,
                "points": 3,
                "repeats": 1,
                "scenes": ["free run"],
                "progress": None,
            },
        ),
        (
            "synthesise",
            pp.synthesis.synthesise,
            lambda: {
                "press": press(),
                "variables": {"P.crank.x": (0.05, 0.06, 0.2)},
                "minimise": lambda trial: trial.variables["P.crank.x"],
                "subject_to": {},
                "geometry": None,
                "method": "local",
                "loads": [],
                "seed": 0,
                "speed": 7.0,
                "points": 12,
            },
        ),
        (
            "synthesis.trade_off",
            pp.synthesis.trade_off,
            lambda: {
                "press": press(),
                "variables": {"P.crank.x": (0.05, 0.06, 0.2)},
                "first": lambda trial: trial.variables["P.crank.x"],
                "second": lambda trial: -trial.variables["P.crank.x"],
                "subject_to": {},
                "geometry": None,
                "loads": [],
                "speed": 7.0,
                "points": 12,
                "designs": 2,
            },
        ),
        (
            "sweep",
            pp.sweeps.sweep,
            lambda: {"function": swept, "grid": {"x": [1.0, 2.0]}, "executor": Inline(), "at_once": False, "paired": False, "in_flight": 2},
        ),
        ("sweeps.read", pp.sweeps.read, lambda: {"path": SWEPT}),
        ("sweeps.full_factorial", pp.sweeps.full_factorial, lambda: {"ranges": {"x": (0.0, 1.0), "y": (2.0, 3.0)}, "levels": 3}),
        ("sweeps.latin_hypercube", pp.sweeps.latin_hypercube, lambda: {"ranges": {"x": (0.0, 1.0)}, "count": 5, "seed": 1}),
        (
            "record",
            pp.record,
            lambda: {"press": press(), "motion": motion(), "path": PATH, "reactions": reactions(), "traces": [("slide", (0.0, 0.0, 0.0))]},
        ),
        (
            "record_modes",
            pp.record_modes,
            lambda: {
                "press": press(),
                "modes": pp.elasticity.natural_frequencies(press(), pp.elasticity.Elastic(springs()), angle=[0.1]),
                "path": PATH,
                "lowest": 1,
            },
        ),
        ("report", pp.report, lambda: {"press": press(), "motion": motion(), "path": PATH, "reactions": reactions(), "traces": []}),
        ("visual_model", pp.visual_model, lambda: {"press": press(), "motion": motion()}),
        ("Linkage.configuration", lambda angle: press().configuration(angle), lambda: {"angle": [0.1, 0.2]}),
        (
            "video.film",
            pp.video.film,
            lambda: {"page": "none.html", "path": FOLDER / "film.gif", "size": (320, 200), "frames_per_second": 2, "slowdown": 1.0},
        ),
        (
            "view",
            pp.view,
            lambda: {"press": "none.urdf", "speed": 7.0, "loads": [], "friction": {}, "stiffness": {}, "watch": False, "browser": False},
        ),
        ("video.image", pp.video.image, lambda: {"page": "none.html", "path": FOLDER / "image.png", "time": 0.0, "size": (320, 200)}),
        ("video.pdf", pp.video.pdf, lambda: {"page": "none.html", "path": FOLDER / "page.pdf", "time": 0.0}),
        ("plots.save", pp.plots.save, lambda: {"figure": pp.plots.draw(motion(), "position"), "path": FOLDER / "plot.svg"}),
        (
            "accuracy.plot",
            pp.accuracy.plot,
            lambda: {"measured": pp.accuracy.WorkPrecision("press", "scene", "machine", {}, Records(pp.accuracy.Measurement, ()), ())},
        ),
        ("plots.draw", lambda result, name: pp.plots.draw(result, name), lambda: {"result": reactions(), "name": "torque"}),
        (
            "tolerances.Scatter.with_limit",
            lambda limit: scattered().with_limit(limit),
            lambda: {"limit": 5e-5},
        ),
        ("measures.bearing_positions", measures.bearing_positions, lambda: {"press": press(), "motion": motion()}),
        ("measures.dwell_angle", measures.dwell_angle, lambda: {"motion": motion(), "tolerance": 1e-3}),
        ("measures.dwell_time", measures.dwell_time, lambda: {"motion": motion(), "tolerance": 1e-3}),
        ("measures.even_length", measures.even_length, lambda: {"motion": motion(), "variation": 0.1, "downwards": True}),
        ("measures.phases", pp.measures.phases, lambda: {"motion": motion(), "length": 0.05, "downwards": True}),
        ("measures.speed_variation", measures.speed_variation, lambda: {"motion": motion(), "length": 0.05, "downwards": True}),
        ("measures.mechanical_advantage", measures.mechanical_advantage, lambda: {"motion": motion(), "height": 0.05, "downwards": True}),
        ("measures.quick_return_ratio", measures.quick_return_ratio, lambda: {"motion": motion(), "downwards": True}),
        ("measures.speed_at", measures.speed_at, lambda: {"motion": motion(), "height": 0.05, "downwards": True}),
        ("measures.speed_ratio", measures.speed_ratio, lambda: {"motion": motion(), "downwards": True}),
        ("measures.stroke", measures.stroke, lambda: {"motion": motion()}),
        ("measures.transmission_angle", measures.transmission_angle, lambda: {"motion": motion(), **pins()}),
        (
            "measures.pressure_angle",
            measures.pressure_angle,
            lambda: {"motion": motion(), "driven": pins()["another"], "other": pins()["pin"], "axis": (0.0, 0.0, 1.0)},
        ),
        (
            "foundation.mounted",
            foundation.mounted,
            lambda: {
                "press": press(),
                "frame": system().frame,
                "mounts": system().mounts,
                "crown": None,
                "uprights": (),
                "attached": {"motor": foundation.Attachment(system().frame)},
                "rotors": [foundation.Rotor(1.0, (0.0, 1.0, 0.0))],
            },
        ),
        ("foundation.beam_frame", foundation.beam_frame, beam_model),
        ("foundation.reduced_frame", foundation.reduced_frame, matrices_of_a_frame),
        ("foundation.read_mounted", foundation.read_mounted, lambda: {"press": press(), "file": "frame.yaml"}),
        (
            "foundation.read_frame",
            foundation.read_frame,
            lambda: {
                "file": "frame.npz",
                "interfaces": {"a": 0},
                "bed": "a",
                "carrier": "a",
                "stiffness": None,
                "nodes": None,
                "degrees": None,
                "bearings": None,
                "modes": 2,
                "loss_factor": 0.01,
                "lines": None,
            },
        ),
        (
            "foundation.lifting_response",
            foundation.lifting_response,
            lambda: {"system": system(), "reactions": reactions(), "points": POINTS, "flywheel": pp.drives.Flywheel(1.0), "strokes": 2},
        ),
        ("foundation.whirl", foundation.whirl, lambda: {"system": spinning(), "speeds": [5.0, 6.0]}),
        ("foundation.modes", foundation.modes, lambda: {"system": system()}),
        ("foundation.press_inertia", foundation.press_inertia, lambda: {"press": press()}),
        (
            "foundation.pad_mount",
            foundation.pad_mount,
            lambda: {"point": (0.0, 0.0, 0.0), "pad": foundation.RubberPad(0.1, 0.1, 0.03, 60.0)},
        ),
        (
            "foundation.flywheel_moment",
            foundation.flywheel_moment,
            lambda: {"press": press(), "motion": motion(), "flywheel": pp.drives.Flywheel(1.0)},
        ),
        (
            "foundation.logarithmic_decrement",
            foundation.logarithmic_decrement,
            lambda: {"signal": np.exp(-0.1 * TIMES) * np.cos(3 * TIMES), "rate": 10.0, "band": (0.1, 2.0)},
        ),
        ("foundation.over_speeds", foundation.over_speeds, lambda: {"system": system(), "speeds": [5.0, 6.0], "points": POINTS}),
        (
            "foundation.steady_response",
            foundation.steady_response,
            lambda: {"system": system(), "reactions": reactions(), "points": POINTS, "flywheel": pp.drives.Flywheel(1.0)},
        ),
        (
            "foundation.time_response",
            foundation.time_response,
            lambda: {"system": system(), "reactions": reactions(), "points": POINTS, "flywheel": pp.drives.Flywheel(1.0)},
        ),
        ("foundation.transmissibility", foundation.transmissibility, lambda: {"system": system(), "frequency": [5.0, 6.0]}),
        (
            "foundation.isolate",
            foundation.isolate,
            lambda: {
                "press": press(),
                "frame": system().frame,
                "mounts": system().mounts,
                "speeds": [50.0, 60.0],
                "transmitted": 0.5,
                "sag": None,
            },
        ),
        ("classical.approximate_balance", classical.approximate_balance, lambda: {"press": press(), "radius": 0.2, "share": 0.5}),
        ("classical.compare_harmonics", classical.compare_harmonics, lambda: {"before": reactions(), "after": reactions(), "orders": 3}),
        (
            "classical.complete_balance",
            classical.complete_balance,
            lambda: {"press": press(), "rod_radius": 0.2, "crank_radius": 0.2},
        ),
        ("classical.as_crank_slider", classical.as_crank_slider, lambda: {"press": press()}),
        ("classical.harmonic_coefficients", classical.harmonic_coefficients, lambda: {"ratio": 0.2, "orders": 6}),
        (
            "classical.with_opposed_balancer",
            classical.with_opposed_balancer,
            lambda: {"press": press(), "crank_radius": 0.1, "rod_length": 0.4, "rod_mass": 1.0, "rod_inertia": 0.1, "die_mass": 5.0},
        ),
        (
            "classical.with_balance_shafts",
            classical.with_balance_shafts,
            lambda: {"press": press(), "radius": 0.1, "shaft_distance": 0.5, "orders": [1, 2], "crank_radius": 0.2},
        ),
        ("classical.mirrored", classical.mirrored, lambda: {"press": press(), "shaft_distance": 1.0}),
        ("classical.static_balance", classical.static_balance, lambda: {"masses": [1.0], "positions": [[0.1, 0.0, 0.0]]}),
        (
            "classical.two_plane_balance",
            classical.two_plane_balance,
            lambda: {"masses": [1.0], "positions": [[0.1, 0.2, 0.0]], "planes": [0.0, 1.0]},
        ),
        ("classical.unbalance", classical.unbalance, lambda: {"press": press(), "link": "crank"}),
    ]
    found: dict[str, Call] = {}
    for name, made, arguments in kinds:
        while name in found:
            name += "'"
        found[name] = made, arguments
    return found


TIMES = np.linspace(0.0, 10.0, 500)


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


def cases(*words: str) -> Iterator[tuple[str, str, str]]:
    """Name of a call, argument, and odd value in its place."""
    for name, (_, arguments) in calls().items():
        if not words or any(word in name for word in words):
            yield from ((name, argument, value) for argument, value in itertools.product(arguments(), ODD))


def judge(name: str, argument: str, value: str) -> str | None:
    """What is wrong with how a call takes an odd value; None if nothing is."""
    called, arguments = calls()[name]
    given = arguments() | {argument: ODD[value]}
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
    return None


def main(words: list[str]) -> int:
    wrong = count = 0
    for name, argument, value in cases(*words):
        count += 1
        if problem := judge(name, argument, value):
            wrong += 1
            print(f"{name}({argument}={value}): {problem}", flush=True)
    print(f"{count} calls, {wrong} of them wrong")
    return min(wrong, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
