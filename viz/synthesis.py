"""Link lengths found for the thin-wall press of Chen 2002 and for the ZXN2-3000(B): the table of docs/synthesis.md."""

import numpy as np
from support import markdown
from validation.chen2002 import as_the_paper_asks, even_speed, largest_pressure
from validation.chen2002_design import DRAWN, SPEED

import pinpress as pp
from pinpress.kinematics.measures import quick_return_ratio, speed_ratio, speed_variation, stroke

CREST = 0.3012  # stroke of the ZXN2-3000(B) [m]


def less_torque() -> pp.synthesis.SynthesisResult:
    """The six-bar, running empty, with a lower peak of driving torque: the same stroke, no less time on the way down than up."""
    return pp.synthesis.synthesise(
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


def table() -> str:
    """The lengths of the thin-wall press by several objectives, and what they make of it."""
    press = pp.load("thin_wall")
    found: dict[str, pp.synthesis.SynthesisResult | None] = {"as printed (Chen 2002)": None}
    for longest in (0.22, 0.40, 3.0):
        found[f"the paper's objective, l4 up to {1e3 * longest:.0f} mm"] = as_the_paper_asks(press, longest)
    for degrees in (40, 10):
        found[f"even speed, pressure angle up to {degrees} deg"] = even_speed(press, degrees)
    return markdown.table(
        ("thin-wall press", "l4 [mm]", "h [mm]", "pressure angle [deg]", "v_max / v_mean", "speed drop over 120 mm", "held by"),
        [_row(what, press if result is None else result.press, result) for what, result in found.items()],
    )


def _row(what: str, press: pp.Linkage, result: pp.synthesis.SynthesisResult | None) -> tuple[str, ...]:
    motion = pp.cycle(press, SPEED)
    coupler, height = press.loops[1].point1[0], press.model.jointPlacements[press.model.getJointId("slide_guide")].translation[2]
    lengths = f"{1e3 * coupler:.1f}", f"{1e3 * height:.1f}", f"{largest_pressure(press, motion):.2f}"
    held = [] if result is None else [f"{active.name}, {active.side} bound" for active in result.active]
    held += [] if result is None else [f"{name} has no influence" for name in result.idle]
    return what, *lengths, f"{speed_ratio(motion):.5f}", f"{100 * speed_variation(motion, DRAWN):.2f} %", "; ".join(held)


def main(quick: bool = False) -> None:
    """Print the table and the six-bar; ``quick``: the six-bar alone."""
    if not quick:
        print(table())
    six_bar = less_torque()
    print(f"\nZXN2-3000(B), largest driving torque {six_bar.start_value:.0f} N m -> {six_bar.value:.0f} N m, {six_bar.evaluations} designs")
    for line in six_bar.table():
        print(f"  {line.name}: {line.start:.6g} -> {line.value:.6g}")
    print("  held by", *(f"{active.name} ({active.side} bound)" for active in six_bar.active))
