"""Inverse dynamics of every shipped press, and of linkages in space: time of a state and error of each engine.

From crank angles and the loaded press to the driving torque and the force of every bearing, new angles in every call, so that memory is not
laid out for one number alone. Errors are relative to the peak, against engine `pinocchio`. Cassie's twelve drivers are followed by engine
`space` in all columns.
"""

import itertools
import warnings
from collections.abc import Callable
from importlib.metadata import files
from pathlib import Path

import numpy as np
from benchmarks.stopwatch import least, table
from support import texts
from support.generators import spatial_linkages
from support.oracles import cassie

import pinpress as pp

STATES = 360
Solve = Callable[[str, float], pp.Reactions]  # by an engine, with angles shifted a little


def main(quick: bool = False) -> None:
    """Print the table."""
    linkages = {name: turning(pp.load(name)) for name in (pp.presses()[:1] if quick else pp.presses())}
    template = Path(pp.__file__).parent / "pin_table" / "templates" / "rssp.yaml"
    linkages["crank, ball-ended rod, slide"] = swinging(pp.build(template))
    if not quick:
        linkages["Bennett, 4 pins"] = swinging(texts.load(spatial_linkages.bennett()))
        linkages["Bricard, 6 pins"] = swinging(texts.load(spatial_linkages.bricard()))
        linkages["four-bar with a weld"] = swinging(texts.load(spatial_linkages.four_bar("fixed")))
    linkages["Cassie, 12 drivers"] = swaying_cassie()
    rows = []
    for name, solve in linkages.items():
        judge, shifts = solve("pinocchio", 0.0), itertools.count(0.0, 1e-5)
        engines = ("plane", "space", "pinocchio")[name not in pp.presses() :]  # shipped presses are planar
        works = [lambda engine=engine, solve=solve, shifts=shifts: solve(engine, next(shifts)) for engine in engines]
        times = dict(zip(engines, least(works, 1 if quick else 10), strict=True))
        ours = solve(engines[0], 0.0)
        torque = np.abs(ours.driving_torque - judge.driving_torque).max() / np.abs(judge.driving_torque).max()
        peak = max(np.abs(force).max() for force in judge.bearing_force.values())
        force = max(np.abs(ours.bearing_force[b] - judge.bearing_force[b]).max() for b in judge.bearing_force) / peak
        cells = [f"{1e6 * times[engine] / STATES:.3g}" if engine in times else "" for engine in ("plane", "space", "pinocchio")]
        rows.append((name, len(judge.bearing_force), *cells, f"{torque:.0e}", f"{force:.0e}"))
    head = ("", "bearings", "plane [us/state]", "space [us/state]", "pinocchio [us/state]", "error of torque", "of forces")
    print(table(head, rows))


def turning(press: pp.Linkage) -> Solve:
    """A turn at constant speed."""

    def solve(engine: str, shift: float) -> pp.Reactions:
        angle = 2 * np.pi * np.arange(STATES) / STATES + shift
        return pp.inverse_dynamics(press, pp.servo_cycle(press, angle=angle, speed=7.0, engine=engine), engine=engine)

    return solve


def swinging(press: pp.Linkage) -> Solve:
    """A swing over most of what the crank can turn."""
    low, high = (0.0, 2 * np.pi) if press.branch.period else press.branch.angles[[0, -1]]

    def solve(engine: str, shift: float) -> pp.Reactions:
        angle = 0.5 * (low + high) + 0.4 * (high - low) * np.sin(np.linspace(shift, 6.0, STATES))
        motion = pp.servo_cycle(press, angle=angle, speed=np.cos(angle), acceleration=np.sin(angle), engine=engine)
        return pp.inverse_dynamics(press, motion, engine=engine)

    return solve


def swaying_cassie() -> Solve:
    """The robot of example-robot-data, its motors and its knees' springs as drivers, which sway a little: its knees lock soon."""
    file = next(path.locate() for path in files("example-robot-data") or () if path.name == "cassie_v2.sdf")
    drivers = [f"{side}-{joint}" for side in ("left", "right") for joint in (*cassie.MOTORS, "knee-shin-joint")]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pp.PinpressWarning)  # its springs are not read
        robot = pp.load(str(file), driver=drivers)
    far = [0.3 if any(word in name for word in ("roll", "yaw", "pitch")) else 0.005 for name in robot.drivers]

    def solve(engine: str, shift: float) -> pp.Reactions:
        sway = far * np.sin(np.linspace(shift, 6.0, STATES)[:, None] + np.arange(len(robot.drivers)))
        motion = pp.servo_cycle(robot, angle=sway, speed=sway, acceleration=-sway, engine=engine)
        return pp.inverse_dynamics(robot, motion, engine=engine)

    return solve
