"""Link lengths found for the thin-wall press of Chen 2002 and for the ZXN2-3000(B): the table of docs/synthesis.md.

python viz/synthesis.py
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

import pinpress as pp
from pinpress.measures import flatness, pressure_angle, quick_return_ratio, speed_ratio, stroke

DRAWN = 0.120  # m that are to be drawn at even speed
HALF = math.radians(18)  # half the angle between the bar's dead centres, for a ratio of working to return time of 1.5
STROKE = 0.400
CREST = 0.3012  # stroke of the ZXN2-3000(B) [m]


def design_rules(l1: Any, l4: Any) -> Mapping[tuple[str, str], Any]:
    """Chen 2002: all lengths from crank and coupler."""
    bar = STROKE / (2 * np.sin(HALF))
    return {
        ("A", "frame"): (0, 0, l1 / np.sin(HALF)),
        ("B", "crank"): (l1, 0, 0),
        ("D", "bar"): (bar, 0, 0),
        ("E", "coupler"): (l4, 0, 0),
        ("slide_guide", "frame"): (0, 0, 0.5 * bar * (1 + np.cos(HALF))),
    }


def free_height(l4: Any, h: Any) -> Mapping[tuple[str, str], Any]:
    """The shipped press with another coupler and another height of the ram."""
    return {("E", "coupler"): (l4, 0, 0), ("slide_guide", "frame"): (0, 0, h)}


def pressure(trial: pp.Trial) -> float:
    """Largest angle between coupler and guide [rad]."""
    return pressure_angle(trial.motion, trial.positions["E"], trial.positions["D"], (1, 0, 0))


def as_the_paper_asks(longest: float) -> pp.Synthesis:
    """The paper's problem: v_max / v_mean of the working stroke, with a bound of the coupler's length [m], which it does not print."""
    return pp.synthesise(
        pp.load("thin_wall"),
        {"l1": (0.080, 0.108, 0.140), "l4": (0.150, 0.200, longest)},
        minimise=lambda trial: speed_ratio(trial.motion),
        subject_to={"pressure angle": (pressure, None, math.radians(40))},
        geometry=design_rules,
        speed=7.54,
    )


def even_speed(degrees: float) -> pp.Synthesis:
    """Even speed over 120 mm, with a largest pressure angle."""
    return pp.synthesise(
        pp.load("thin_wall"),
        {"l4": (0.050, 0.220, 0.600), "h": (0.600, 0.630, 0.700)},
        minimise=lambda trial: flatness(trial.motion, DRAWN),
        subject_to={"pressure angle": (pressure, None, math.radians(degrees))},
        geometry=free_height,
        speed=7.54,
    )


def less_torque() -> pp.Synthesis:
    """The six-bar, running empty, with a lower peak of driving torque: the same stroke, no less time on the way down than up."""
    return pp.synthesise(
        pp.load("zxn2_3000b"),
        {"x": (1.1, 1.25, 1.4), "z": (-0.35, -0.2, -0.05), "l1": (0.12, 0.143, 0.17), "l2": (1.1, 1.243, 1.4), "l31": (0.33, 0.375, 0.42)},
        minimise=lambda trial: np.concatenate([trial.reactions.driving_torque, -trial.reactions.driving_torque]),
        subject_to={
            "stroke": (lambda trial: stroke(trial.motion), CREST, CREST),
            "time ratio": (lambda trial: quick_return_ratio(trial.motion), 1.0, None),
        },
        geometry=lambda x, z, l1, l2, l31: {
            ("A", "frame"): (x, 0, z),
            ("B", "crank"): (l1, 0, 0),
            ("C", "coupler"): (l2, 0, 0),
            ("C", "rocker"): (l31, 0, 0),
        },
        speed=70 * pp.RPM,
    )


def thin_wall_row(what: str, press: pp.Linkage, held: str) -> str:
    motion = pp.cycle(press, speed=7.54)
    at = pp.measures.bearing_positions(press, motion)
    angle = math.degrees(pressure_angle(motion, at["E"], at["D"], (1, 0, 0)))
    coupler, height = press.loops[1].point1[0], press.model.jointPlacements[press.model.getJointId("slide_guide")].translation[2]
    lengths = f"{1e3 * coupler:.1f} | {1e3 * height:.1f} | {angle:.2f}"
    return f"| {what} | {lengths} | {speed_ratio(motion):.5f} | {100 * flatness(motion, DRAWN):.2f} % | {held} |"


def table() -> str:
    """Markdown."""
    lines = ["| thin-wall press | l4 [mm] | h [mm] | pressure angle [deg] | v_max / v_mean | speed drop over 120 mm | held by |"]
    lines += ["|---|---|---|---|---|---|---|", thin_wall_row("as printed (Chen 2002)", pp.load("thin_wall"), "")]
    for longest in (0.22, 0.40, 3.0):
        lines.append(row(f"the paper's objective, l4 up to {1e3 * longest:.0f} mm", as_the_paper_asks(longest)))
    for degrees in (40, 10):
        lines.append(row(f"even speed, pressure angle up to {degrees} deg", even_speed(degrees)))
    return "\n".join(lines)


def row(what: str, found: pp.Synthesis) -> str:
    held = [f"{active.name}, {active.side} bound" for active in found.active] + [f"{name} has no influence" for name in found.idle]
    return thin_wall_row(what, found.press, "; ".join(held))


if __name__ == "__main__":
    print(table())
    six_bar = less_torque()
    print(f"\nZXN2-3000(B), largest driving torque {six_bar.start_value:.0f} N m -> {six_bar.value:.0f} N m, {six_bar.evaluations} designs")
    for line in six_bar.table():
        print(f"  {line.name}: {line.start:.6g} -> {line.value:.6g}")
    print("  held by", *(f"{active.name} ({active.side} bound)" for active in six_bar.active))
