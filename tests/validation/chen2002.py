"""Chen Y., Su S. 2002, Modern Manufacturing Engineering 2002(7), 42-44: a press for thin-walled parts, with an oscillating guide bar.

Angles of the crank are those of the paper, counter-clockwise from the direction of the ram's way back; the ram works towards -x.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pinpress.common.quantities import Array
from pinpress.derivatives.reshape import reshaped
from pinpress.kinematics.cycle import cycle
from pinpress.kinematics.dyads import transmission_angle_curves
from pinpress.kinematics.measures import (
    bearing_positions,
    even_length,
    pressure_angle,
    quick_return_ratio,
    speed_ratio,
    speed_variation,
    stroke,
)
from pinpress.kinematics.motion import Motion
from pinpress.kinematics.phases import phases
from pinpress.kinematics.servo_motion import servo_cycle
from pinpress.kinematics.slide_path import dead_centres
from pinpress.linkage.linkage import Linkage
from pinpress.linkage.loading import load
from pinpress.synthesis.design import Trial
from pinpress.synthesis.synthesis import SynthesisResult, synthesise
from validation.chen2002_design import AXIS, DRAWN, HALF, SPEED, STROKE, charts_entry, weighing_entry
from validation.pages import BEYOND, CURVES, FORMULAS, NO_RESULT, NOT, PARTLY, Erratum, Grid, Page, PageEntry, Panel, Row, draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINTS = 720
FORMULA, SOLVER = "formula", "independent solver"

ERRATA = (
    Erratum("(22), (23)", "l1 and l4 as variables of an objective", "l1 has no influence, and l4 no optimum: see (22), (23) above"),
    Erratum("constraints (3)", "bounds of the variables left out", "the upper bound of l4 decides the result, as it is the optimum"),
    Erratum("example", "h = 630 mm, l3 = 648 mm", "(19) and (21) give 631.4 mm and 647.2 mm"),
)


def page() -> Page:
    """All figures of the paper (it has no tables), and what its text claims."""
    press = load("thin_wall")
    motion = cycle(press, SPEED, points=POINTS)
    even = [even_speed(press, degrees) for degrees in (40, 10)]
    return Page(
        "chen2002",
        "Chen 2002: a press for thin-walled parts",
        "Chen Y., Su S. 2002, Modern Manufacturing Engineering 2002(7), 42-44 (in Chinese): lengths of an oscillating guide bar with a"
        " rocker-slide behind it, so that the ram works at an even speed and returns quickly. `thin_wall`, at 7.54 rad/s. The paper has"
        " no tables. We read it in a transcription. Written by `python tests/validation/validate.py chen2002`.",
        (
            PageEntry(("Fig. 1",), "scheme of the press", NO_RESULT),
            _ends(press),
            _speeds(press, motion, even[0].press),
            _phases(motion),
            _example(press, motion),
            _pressure_angles(press, motion),
            _uniform(press, motion),
            _objective(press, motion),
            _even(motion, even),
            charts_entry(press),
            weighing_entry(press),
        ),
        ERRATA,
    )


def design_rules(l1: Any, l4: Any) -> Mapping[tuple[str, str], Any]:
    """All lengths from crank and coupler [m], by (19) to (21)."""
    bar = STROKE / (2 * np.sin(HALF))
    return {
        ("A", "frame"): (0, 0, l1 / np.sin(HALF)),
        ("B", "crank"): (l1, 0, 0),
        ("D", "bar"): (bar, 0, 0),
        ("E", "coupler"): (l4, 0, 0),
        ("slide_guide", "frame"): (0, 0, 0.5 * bar * (1 + np.cos(HALF))),
    }


def as_the_paper_asks(press: Linkage, longest: float) -> SynthesisResult:
    """Least v_max / v_mean of the working stroke, with a bound of the coupler's length [m], which the paper leaves out."""
    return synthesise(
        press,
        {"l1": (0.080, 0.108, 0.140), "l4": (0.150, 0.200, longest)},
        minimise=lambda trial: speed_ratio(trial.motion),
        subject_to={"pressure angle": (_pressure, None, math.radians(40))},
        geometry=design_rules,
        speed=SPEED,
    )


def even_speed(press: Linkage, degrees: float) -> SynthesisResult:
    """Least drop of speed over 120 mm, with a largest pressure angle [deg]; coupler and height of the ram are free."""
    return synthesise(
        press,
        {"l4": (0.050, 0.220, 0.600), "h": (0.600, 0.630, 0.700)},
        minimise=lambda trial: speed_variation(trial.motion, DRAWN),
        subject_to={"pressure angle": (_pressure, None, math.radians(degrees))},
        geometry=lambda l4, h: {("E", "coupler"): (l4, 0, 0), ("slide_guide", "frame"): (0, 0, h)},
        speed=SPEED,
    )


def _pressure(trial: Trial) -> float:
    return pressure_angle(trial.motion, trial.positions["E"], trial.positions["D"], AXIS)


def largest_pressure(press: Linkage, motion: Motion) -> float:
    """The largest pressure angle between coupler and guide in the states of a turn [deg]."""
    return math.degrees(transmission_angle_curves(press, motion).pressure_angle["E"].max())


def _ends(press: Linkage) -> PageEntry:
    ends = dead_centres(press)
    start, end = math.degrees(ends.top_angle) - 360.0, math.degrees(ends.bottom_angle)
    half = math.degrees(HALF)
    rows = (
        Row("crank angle at the start of the working stroke [deg]", f"{-half:.3f}", start, 0.5, None, FORMULA),
        Row("crank angle at its end [deg]", f"{180 + half:.3f}", end, 0.5, None, FORMULA),
        Row("start of the working stroke, printed lengths [deg]", "-17.973159", start, 1e-5, None, SOLVER),
        Row("its end, printed lengths [deg]", "197.973159", end, 1e-5, None, SOLVER),
    )
    reason = (
        "The document's angles are (11) for K = 1.5. Ours are those of the printed lengths, which are rounded to millimetres, the crank's"
        " by up to 0.5 %."
    )
    return PageEntry(("Fig. 2",), "crank angles at the ends of the stroke", FORMULAS, rows, reason)


def _working(motion: Motion) -> tuple[Array, Array]:
    """Crank angle [deg] and speed towards the work [mm/s], (n,)."""
    return np.degrees(motion.crank_angle), -1e3 * motion.slide_velocity


def _speeds(press: Linkage, motion: Motion, even: Linkage) -> PageEntry:
    def down(degrees: float) -> float:
        return -1e3 * float(servo_cycle(press, speed=SPEED, angle=[math.radians(degrees)]).slide_velocity[0])

    fine = cycle(press, SPEED, points=72000)  # extremes to 1e-9
    fastest = int(fine.slide_velocity.argmin())
    ends = dead_centres(press)
    mean = 1e3 * ends.stroke / ((ends.bottom_angle - ends.top_angle + 2 * np.pi) / SPEED)
    rows = (
        Row("speed of the ram at 0 deg [mm/s]", "399.728925", down(0.0), 1e-6, None, SOLVER),
        Row("speed of the ram at 60 deg [mm/s]", "1086.607425", down(60.0), 1e-6, None, SOLVER),
        Row("mean speed of the working stroke [mm/s]", "800.034815", mean, 1e-6, None, SOLVER),
        Row("largest speed of the working stroke [mm/s]", "1152.606", -1e3 * float(fine.slide_velocity.min()), 1e-4, None, SOLVER),
        Row("crank angle there [deg]", "87.60", math.degrees(fine.crank_angle[fastest]), 0.02, None, SOLVER),
        Row("largest speed of the return stroke [mm/s]", "2181", 1e3 * float(fine.slide_velocity.max()), 0.05, None, SOLVER),
    )

    def shown() -> "Figure":
        curves = {"printed lengths": _working(motion), "even speed, ours, up to 40 deg": _working(cycle(even, SPEED, points=POINTS))}
        return draw("crank angle [deg]", [Panel("speed of the ram [mm/s]", curves)], 6.5)

    reason = "No number is printed in the figure; what the text says of it follows below."
    caption = "Speed towards the work is positive."
    return PageEntry(("Fig. 3",), "speed of the ram over the crank angle", CURVES, rows, reason, "chen2002_speed", shown, caption)


def _phases(motion: Motion) -> PageEntry:
    """The turn in the parts that the paper marks in Fig. 3."""
    rows = []
    for each in phases(motion, DRAWN):
        begin, ends = math.degrees(each.crank_angle), math.degrees(each.crank_angle + each.turned)
        begin, ends = (angle - 360 * (each.phase == "approach") for angle in (begin, ends))
        speeds = (f"{1e3 * speed:.0f}" for speed in (each.lowest_speed, each.mean_speed, each.highest_speed))
        rows.append((each.phase, f"{begin:.2f} to {ends:.2f}", f"{1e3 * each.duration:.1f}", f"{1e3 * each.travel:.1f}", *speeds))
    grid = Grid(("phase", "crank angle [deg]", "time [ms]", "travel [mm]", "lowest", "mean", "highest speed [mm/s]"), tuple(rows))
    reason = (
        "The paper marks approach, working stroke and quick return in the figure, without numbers at their ends. Here the working part is"
        " the 120 mm of evenest speed; a run-out leads from it to the dead centre. The approach is on average two fifths slower than the"
        " working part, as the paper wants it, but the ram meets the blank at full speed."
    )
    return PageEntry(("Phases",), "approach, working part, run-out and return of Fig. 3", BEYOND, (), reason, grids=(grid,))


def _pressure_angles(press: Linkage, motion: Motion) -> PageEntry:
    """The pressure angle between coupler and guide along the stroke, and where the ram works."""
    angles = np.degrees(transmission_angle_curves(press, motion).pressure_angle["E"])
    crank, working = np.degrees(motion.crank_angle), phases(motion, DRAWN)[1]
    begin, ends = math.degrees(working.crank_angle), math.degrees(working.crank_angle + working.turned)
    inside = (crank >= begin) & (crank <= ends)
    top = int(angles.argmax())
    rows = (
        Row("largest pressure angle [deg]", f"{math.degrees(math.asin((648 - 630) / 220)):.4f}", float(angles[top]), 1e-3, None, FORMULA),
        Row("crank angle there [deg]", "90", float(crank[top]), 1e-6, 2, FORMULA),
        Row(
            "pressure angle at both ends of the stroke [deg]",
            "",
            math.degrees(math.asin((630 - 648 * math.cos(math.asin(108 / 350))) / 220)),
            places=3,
        ),
        Row("largest within the working part [deg]", "", float(angles[inside].max()), places=3),
        Row("smallest within the working part [deg]", "", float(angles[inside].min()), places=3),
    )

    def shown() -> "Figure":
        way = 1e3 * (motion.slide_position.max() - motion.slide_position)
        return draw("travel of the ram [mm]", [Panel("pressure angle [deg]", {"": (way, angles)}, (), ())], 5.5)

    reason = (
        "At 90 and 270 deg the bar's end is highest above the guide's line, (18), at the ends of the stroke lowest below it. The block"
        " pushes the bar squarely, so that this is the only pressure angle."
    )
    return PageEntry(
        ("Pressure angle",),
        "between coupler and guide along the stroke",
        FORMULAS,
        rows,
        reason,
        "chen2002_pressure",
        shown,
        "Over the travel from the start of the working stroke; the way back has the same curve.",
    )


def _example(press: Linkage, motion: Motion) -> PageEntry:
    bar = STROKE / (2 * math.sin(HALF))
    rows = (
        Row("time ratio K", "1.5", quick_return_ratio(motion), 0.5, 5),
        Row("stroke [mm]", "400", 1e3 * stroke(motion), 0.5, 3),
        Row("crank l1 by (20) from l6 = 350 mm [mm]", "108", 350 * math.sin(HALF), 0.5, 2),
        Row("bar l3 by (21) [mm]", "648", 1e3 * bar, None, 2),
        Row("height h by (19) [mm]", "630", 500 * bar * (1 + math.cos(HALF)), None, 2),
        *_existence(press, motion),
        Row(
            "largest pressure angle, (18) [deg]",
            f"{math.degrees(math.asin((648 - 630) / 220)):.4f}",
            largest_pressure(press, motion),
            1e-3,
            None,
            FORMULA,
        ),
    )
    reason = (
        "l1 = 108, l3 = 648, l4 = 220, l6 = 350, h = 630 mm. Time ratio and stroke are those of these lengths, as far as their"
        " rounding to millimetres allows (0.5 % of the crank). Bar and height are not what the paper's own rules give when rounded."
        " Its constraints (2) of crank and guide hold; the third, as our text reads, is the triangle inequality and holds in any such"
        " press. That the block stays on the bar, s3 < l3, is not among them."
    )
    return PageEntry(("Example",), "lengths, time ratio, stroke, pressure angle", PARTLY, rows, reason)


def _existence(press: Linkage, motion: Motion) -> tuple[Row, ...]:
    """Constraints (2): the crank turns fully, the coupler reaches the guide, and the block stays beyond l6 - l1."""
    places = {name: 1e3 * place for name, place in bearing_positions(press, motion).items()}
    l1, l3, l4, l6 = (float(np.linalg.norm(places[end] - places[start], axis=1).max()) for start, end in ("AB", "CD", "DE", "CA"))
    block, height = np.linalg.norm(places["B"] - places["C"], axis=1), float((places["E"] - places["C"])[0, 2])
    values = {
        "l1 - l6, below 0 [mm]": l1 - l6,
        "h - l3 - l4, below 0 [mm]": height - l3 - l4,
        "l6 - l1 - s3, at most 0, largest over the turn [mm]": float((l6 - l1 - block).max()),
        "largest s3, below l3 = 648 [mm]": float(block.max()),
    }
    return tuple(Row(words, "", value, places=2) for words, value in values.items())


def _uniform(press: Linkage, motion: Motion) -> PageEntry:
    part = servo_cycle(press, speed=SPEED, angle=np.radians(np.linspace(60.0, 120.0, 601)))
    travel = 1e3 * float(part.slide_position[0] - part.slide_position[-1])
    speed = -part.slide_velocity
    rows = (
        Row("travel from 60 to 120 deg [mm]", "more than 120", travel, places=2),
        Row("the same [mm]", "156.63", travel, 0.01, None, SOLVER),
        Row("drop of speed within it [%]", "", 100 * float(1 - speed.min() / speed.max()), places=2),
        Row("least drop of speed over any 120 mm [%]", "3.69", 100 * speed_variation(motion, DRAWN), 0.2, None, SOLVER),
        *(Row(f"longest part with a drop of {drop:g} % [mm]", "", 1e3 * even_length(motion, drop / 100), places=1) for drop in (2, 5, 10)),
    )
    reason = (
        "The paper claims at least 120 mm at a nearly uniform speed, from 60 to 120 deg. The travel agrees. The paper does not say how"
        " uniform the speed is."
    )
    return PageEntry(("Uniform section",), "travel at even speed", CURVES, rows, reason)


def _objective(press: Linkage, motion: Motion) -> PageEntry:
    def value(l1: float, l4: float) -> float:
        return speed_ratio(cycle(reshaped(press, design_rules(l1, l4)), SPEED, points=360))

    limit = (math.pi + 2 * HALF) / (2 * (1 + math.sin(HALF)))
    found = as_the_paper_asks(press, 0.220)
    lengths = (0.150, 0.220, 0.400, 1.0, 3.0)
    rows = (
        Row("f = v_max / v_mean, printed lengths", "1.440695", speed_ratio(motion), 1e-4, None, SOLVER),
        Row("f by (19) to (21), l4 = 220 mm", "1.44043159", value(0.108, 0.220), 1e-6, None, SOLVER),
        *(Row(f"f, l4 = {1e3 * l4:g} mm", "", value(0.108, l4), places=6) for l4 in lengths),
        *(Row(f"f, l4 = 220 mm, l1 = {1e3 * l1:g} mm", "", value(l1, 0.220), places=6) for l1 in (0.080, 0.140)),
        Row(
            "f, l4 = 100 m; without end (pi + 2 d) / (2 (1 + sin d)), d = 18 deg", f"{limit:.6f}", value(0.108, 100.0), 1e-3, None, FORMULA
        ),
        Row("l4 that the search within 150 to 220 mm ends at [mm]", "", 1e3 * found.variables["l4"], places=2),
    )

    def shown() -> "Figure":
        coupler = np.geomspace(0.15, 3.0, 13)
        ours = np.array([value(0.108, l4) for l4 in coupler.tolist()])
        return draw("l4 [mm]", [Panel("v_max / v_mean", {"": (1e3 * coupler, ours)}, (limit,), ((220.0, value(0.108, 0.220)),))], 5.5)

    reason = (
        "The objective is degenerate. Stroke and K fix the mean speed, l1 only scales crank and centre distance together, and f falls"
        " without end as l4 grows. So every solver stops at the upper bound of l4, which the paper leaves out: 220 mm is an optimum only"
        " if it was that bound. From there to infinity f falls by 0.03 %."
    )
    caption = "Cross: l4 as printed; dashes: the limit."
    return PageEntry(("(22), (23)",), "objective and its optimum", NOT, rows, reason, "chen2002_objective", shown, caption)


def _even(motion: Motion, found: list[SynthesisResult]) -> PageEntry:
    rows = [Row("drop of speed over 120 mm, printed lengths [%]", "3.69", 100 * speed_variation(motion, DRAWN), 0.2, None, SOLVER)]
    for degrees, theirs, best in zip((40, 10), ("3.39", "3.64"), found, strict=True):
        rows += [
            Row(f"least drop, pressure angle up to {degrees} deg [%]", theirs, 100 * best.value, 0.3, None, SOLVER),
            Row(f"its l4, up to {degrees} deg [mm]", "", 1e3 * best.variables["l4"], places=0),
            Row(f"its h, up to {degrees} deg [mm]", "", 1e3 * best.variables["h"], places=0),
        ]
    reason = (
        "The press is meant to have a speed as even as possible over the 120 mm that are drawn. Here this is the objective, l4 and h are"
        " free, and the pressure angle is limited. It has an optimum, which is little better than the paper's lengths, as the guide bar"
        " decides."
    )
    return PageEntry(("Even speed",), "objective with an optimum", BEYOND, tuple(rows), reason)
