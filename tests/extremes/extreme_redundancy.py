"""Cases of redundant linkages, and of presses that stand askew."""

from functools import cache
from typing import Any

import numpy as np
import pinocchio as pin
from extremes.extreme_case import METHODS, ROUNDING, Case, Outcome, compare, largest, loaded, shipped, worst
from extremes.extreme_crank_slide import spinning
from support.generators.random_linkages import momentum_balance, newton_euler
from support.generators.redundant_linkages import three_cranks
from support.generators.small_linkages import bolted

import pinpress as pp

ROUND = np.linspace(-0.3, 6.2, 13)
PART = np.linspace(-1.0, 1.5, 13)  # of a turn, within the limits of the three cranks

# ------------------------------------------------------------------------------------------------------------------------ redundancy

SHARED = "Shared forces of redundant loops"


def balanced(result: pp.Reactions) -> float:
    """What Newton's and Euler's equations of every body leave over, relative to the largest force and moment."""
    press = result._press
    forces, moments, idle = newton_euler(press, result.motion, result)
    for gear in press.couplings:  # their torques are moments along axes that otherwise are free
        torque = result.coupling_torque[press.joints[gear.follower]]
        idle[:, [gear.follower, gear.leader]] -= torque
    size = max(float(np.abs(force).max()) for force in result.bearing_force.values())
    length = max(1.0, max(float(np.abs(moment).max()) for moment in result.bearing_moment.values()) / size)
    return largest(float(np.abs(forces).max()), float(np.abs(idle).max()) / length, float(np.abs(moments).max()) / length) / size


def redundant(name: str, press: Any, angles: Any, marked: dict[str, str]) -> Case:
    """``marked``: of bearings, the components of their forces that are open, in words of x, y and z."""

    def scene(engine: str) -> pp.Reactions:
        return spinning(press(), engine, angles)

    def judge(result: pp.Reactions) -> Outcome:
        open_ones = {b: "".join(np.array(list("xyz"))[result.indeterminate[b][:3]]) for b in marked}
        if open_ones != marked:
            return Outcome(np.inf, 0.0, f"marked as open: {open_ones}")
        other = scene("plane" if result.engine == "pinocchio" else "pinocchio")
        return Outcome(largest(balanced(result), compare(result, other)), ROUNDING)

    return Case(
        SHARED,
        name,
        f"every body in balance, engines alike, open: {', '.join(f'{b} {axes}' for b, axes in marked.items())}",
        scene,
        judge,
    )


def summed(name: str, pairs: dict[str, tuple[str, ...]]) -> Case:
    """Forces of bearings side by side add up to those of the determinate press with the same masses."""

    def judge(result: pp.Reactions) -> Outcome:
        one = spinning(shipped("jf75g_125"), result.engine, ROUND)
        sums = [
            (sum(result.bearing_force[b][:, ::2] for b in shared), one.bearing_force[single][:, ::2]) for single, shared in pairs.items()
        ]
        return Outcome(worst([(result.driving_torque, one.driving_torque), *sums]), ROUNDING)

    return Case(
        SHARED,
        name,
        "torque and sums of forces in the plane are those of jf75g_125",
        lambda engine: spinning(shipped(name), engine, ROUND),
        judge,
    )


def parallelogram() -> pp.Linkage:
    return loaded(three_cranks(0.2).urdf("O"))


# ----------------------------------------------------------------------------------------------------------------------------- tilted

TILTED = "Presses that stand askew"
ANGLES = ("0.3 0 0", "0 0.7 0", "0 0 2.1", "1 -2 0.5", "3.14159 0.01 -1.5")  # roll, pitch, yaw [rad]


@cache
def askew(name: str, rpy: str, gravity: tuple[float, float, float]) -> pp.Linkage:
    return bolted(shipped(name), rpy, gravity=gravity)


def rotation(rpy: str) -> Any:
    return pin.rpy.rpyToMatrix(np.array(list(map(float, rpy.split()))))


def turned_gravity(rpy: str) -> tuple[float, float, float]:
    x, y, z = (rotation(rpy) @ np.array([0.0, 0.0, -9.81])).tolist()
    return x, y, z


def rotated(name: str, rpy: str) -> Case:
    def judge(result: pp.Reactions) -> Outcome:
        upright = spinning(shipped(name), result.engine, ROUND)
        return Outcome(compare(result, upright, rotation(rpy)), ROUNDING)

    return Case(
        TILTED,
        f"{name} and its gravity, rotated by {rpy}",
        "all forces rotated, torque the same",
        lambda engine: spinning(askew(name, rpy, turned_gravity(rpy)), engine, ROUND),
        judge,
    )


def leaning(name: str, rpy: str) -> Case:
    down = (0.0, 0.0, -9.81)

    def judge(result: pp.Reactions) -> Outcome:
        press, motion = askew(name, rpy, down), result.motion
        other = spinning(press, "plane" if result.engine == "pinocchio" else "pinocchio", ROUND)
        force, moment = momentum_balance(press, motion, [])
        return Outcome(largest(compare(result, other), worst([(result.shaking_force, force), (result.shaking_moment, moment)])), ROUNDING)

    return Case(
        TILTED,
        f"{name} rotated by {rpy}, gravity along -z",
        "engines alike, forces on the foundation by the rate of momentum",
        lambda engine: spinning(askew(name, rpy, down), engine, ROUND),
        judge,
    )


def rotated_run(name: str, rpy: str) -> Case:
    def scene(method: str, upright: bool = False) -> pp.Run:
        press = shipped(name) if upright else askew(name, rpy, turned_gravity(rpy))
        return pp.simulate(press, 0.5, speed=8.0, flywheel=pp.drives.Flywheel(500.0), method=method, points=60)

    def judge(run: pp.Run) -> Outcome:
        expected = scene("reduced", upright=True)
        apart = float(np.abs(run.crank_angle - expected.crank_angle).max())
        return Outcome(largest(apart, float(np.abs(run.crank_speed - expected.crank_speed).max()) / 8.0), 1e-9)

    return Case(
        TILTED + ": runs",
        f"{name} and its gravity, rotated by {rpy}",
        "the same angles at the same times as `reduced` upright (1e-9)",
        scene,
        judge,
        METHODS,
    )


SIX, TWO = "zxn2_3000b", "jf75g_125_two_point"
CASES = [
    redundant("two rods in parallel planes: " + TWO, lambda: shipped(TWO), ROUND, {"P4_front": "xyz", "O": "y", "P5": "y"}),
    redundant("two halves on geared shafts", lambda: shipped("jf75g_125_symmetric"), ROUND, {"P4_left": "xyz", "slide_guide": "xy"}),
    redundant("parallelogram with a third crank", parallelogram, PART, {"C": "xyz", "H": "xyz"}),
    summed(TWO, {"P4": ("P4_front", "P4_back"), "P2": ("P2_front", "P2_back"), "P5": ("P5",), "O": ("O",)}),
    *(rotated(name, rpy) for name in (SIX, TWO) for rpy in ANGLES[:: 1 if name == SIX else 2]),
    *(leaning(name, rpy) for name in (SIX, TWO) for rpy in ANGLES[:: 1 if name == SIX else 2]),
    *(rotated_run(SIX, rpy) for rpy in ANGLES[3:]),
]
