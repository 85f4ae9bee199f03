"""Chen Y., Su S. 2002, Modern Manufacturing Engineering 2002(7), 42-44: a press for thin-walled parts, with an oscillating guide bar.

Angles of the crank are those of the paper, counter-clockwise from the direction of the ram's way back; the ram works towards -x.
"""

import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from validation.chen2002_design import AXIS, DRAWN, HALF, SPEED, STROKE, chart_rows, evenest, weighed_table
from validation.pictures import draw
from validation.rows import BEYOND, CONFIRMED, FORMULA, NOT, PARTLY, SOLVER, UNPRINTED, Part, Row, Table, rows_from, unclaimed

import pinpress as pp
from pinpress.common.quantities import Array
from pinpress.derivatives import reshaped
from pinpress.measures import (
    bearing_positions,
    even_length,
    phases,
    pressure_angle,
    quick_return_ratio,
    speed_ratio,
    speed_variation,
    stroke,
    transmission_angle_curves,
)
from pinpress.synthesis import SynthesisResult, Trial, synthesise

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINTS = 720
BAR = STROKE / (2 * math.sin(HALF))  # l3 by (21) [m]
LIMIT = (math.pi + 2 * HALF) / (2 * (1 + math.sin(HALF)))  # of v_max / v_mean as l4 grows without end
LARGEST_PRESSURE = math.degrees(math.asin((648 - 630) / 220))  # by (18) [deg]


@cache
def press() -> pp.Linkage:
    return pp.load("thin_wall")


@cache
def motion(points: int = POINTS) -> pp.Motion:
    """A turn with the printed lengths."""
    return pp.cycle(press(), SPEED, points=points)


@cache
def ends() -> Any:
    return pp.dead_centres(press())


def design_rules(l1: Any, l4: Any) -> Mapping[tuple[str, str], Any]:
    """All lengths from crank and coupler [m], by (19) to (21)."""
    return {
        ("A", "frame"): (0, 0, l1 / np.sin(HALF)),
        ("B", "crank"): (l1, 0, 0),
        ("D", "bar"): (BAR, 0, 0),
        ("E", "coupler"): (l4, 0, 0),
        ("slide_guide", "frame"): (0, 0, 0.5 * BAR * (1 + np.cos(HALF))),
    }


def _pressure(trial: Trial) -> float:
    return pressure_angle(trial.motion, trial.positions["E"], trial.positions["D"], AXIS)


def as_the_paper_asks(press: pp.Linkage, longest: float) -> SynthesisResult:
    """Least v_max / v_mean of the working stroke, with a bound of the coupler's length [m], which the paper leaves out."""
    return synthesise(
        press,
        {"l1": (0.080, 0.108, 0.140), "l4": (0.150, 0.200, longest)},
        minimise=lambda trial: speed_ratio(trial.motion),
        subject_to={"pressure angle": (_pressure, None, math.radians(40))},
        geometry=design_rules,
        speed=SPEED,
    )


@cache
def even_speed(press: pp.Linkage, degrees: float) -> SynthesisResult:
    """Least drop of speed over 120 mm, with a largest pressure angle [deg]; coupler and height of the ram are free."""
    return synthesise(
        press,
        {"l4": (0.050, 0.220, 0.600), "h": (0.600, 0.630, 0.700)},
        minimise=lambda trial: speed_variation(trial.motion, DRAWN),
        subject_to={"pressure angle": (_pressure, None, math.radians(degrees))},
        geometry=lambda l4, h: {("E", "coupler"): (l4, 0, 0), ("slide_guide", "frame"): (0, 0, h)},
        speed=SPEED,
    )


def pressure_curve(press: pp.Linkage, motion: pp.Motion) -> Array:
    """(n,) pressure angle between coupler and guide over a turn [deg]."""
    return np.degrees(transmission_angle_curves(press, motion).pressure_angle["E"])


def largest_pressure(press: pp.Linkage, motion: pp.Motion) -> float:
    """The largest pressure angle between coupler and guide in the states of a turn [deg]."""
    return float(pressure_curve(press, motion).max())


# ------------------------------------------------------------------------------------------------------------------------------- rows


def end_rows() -> Iterator[Row]:
    def ours() -> list[float]:
        return 2 * [math.degrees(ends().top_angle) - 360.0, math.degrees(ends().bottom_angle)]

    half = math.degrees(HALF)
    return rows_from(
        ours,
        ("crank angle at the start of the working stroke [deg]", f"{-half:.3f}", 0.5, FORMULA),
        ("crank angle at its end [deg]", f"{180 + half:.3f}", 0.5, FORMULA),
        ("start of the working stroke, printed lengths [deg]", "-17.973159", 1e-5, SOLVER),
        ("its end, printed lengths [deg]", "197.973159", 1e-5, SOLVER),
    )


def speed_rows() -> Iterator[Row]:
    def ours() -> list[float]:
        at_angles = pp.servo_cycle(press(), speed=SPEED, angle=np.radians([0.0, 60.0])).slide_velocity
        mean = ends().stroke * SPEED / (ends().bottom_angle - ends().top_angle + 2 * np.pi)
        velocity, angle = motion(72000).slide_velocity, motion(72000).crank_angle  # extremes to 1e-9
        return [
            *(-1e3 * at_angles),
            1e3 * mean,
            -1e3 * velocity.min(),
            np.degrees(angle[velocity.argmin()]),
            1e3 * velocity.max(),
        ]

    return rows_from(
        ours,
        ("speed of the ram at 0 deg [mm/s]", "399.728925", 1e-6, SOLVER),
        ("speed of the ram at 60 deg [mm/s]", "1086.607425", 1e-6, SOLVER),
        ("mean speed of the working stroke [mm/s]", "800.034815", 1e-6, SOLVER),
        ("largest speed of the working stroke [mm/s]", "1152.606", 1e-4, SOLVER),
        ("crank angle there [deg]", "87.60", 0.02, SOLVER),
        ("largest speed of the return stroke [mm/s]", "2181", 0.05, SOLVER),
    )


def phase_table() -> Table:
    """The turn in the parts that the paper marks in Fig. 3."""
    rows = []
    for part in phases(motion(), DRAWN):
        first, last = math.degrees(part.crank_angle), math.degrees(part.crank_angle + part.turned)
        first, last = (angle - 360 * (part.phase == "approach") for angle in (first, last))
        speeds = (f"{1e3 * speed:.0f}" for speed in (part.lowest_speed, part.mean_speed, part.highest_speed))
        rows.append((part.phase, f"{first:.2f} to {last:.2f}", f"{1e3 * part.duration:.1f}", f"{1e3 * part.travel:.1f}", *speeds))
    return Table(("phase", "crank angle [deg]", "time [ms]", "travel [mm]", "lowest", "mean", "highest speed [mm/s]"), tuple(rows))


def example_rows() -> Iterator[Row]:
    def ours() -> list[float]:
        by_rules = [350 * math.sin(HALF), 1e3 * BAR, 500 * BAR * (1 + math.cos(HALF))]
        pressure = pressure_curve(press(), motion()).max()
        return [quick_return_ratio(motion()), 1e3 * stroke(motion()), *by_rules, *constraints(), pressure]

    return rows_from(
        ours,
        ("time ratio K", "1.5", 0.5, "", 5),
        ("stroke [mm]", "400", 0.5, "", 3),
        ("crank l1 by (20) from l6 = 350 mm [mm]", "108", 0.5, "", 2),
        ("bar l3 by (21) [mm]", "648", None, "", 2),
        ("height h by (19) [mm]", "630", None, "", 2),
        ("l1 - l6, below 0 [mm]", "", None, "", 2),
        ("h - l3 - l4, below 0 [mm]", "", None, "", 2),
        ("l6 - l1 - s3, at most 0, largest over the turn [mm]", "", None, "", 2),
        ("largest s3, below l3 = 648 [mm]", "", None, "", 2),
        ("largest pressure angle, (18) [deg]", f"{LARGEST_PRESSURE:.4f}", 1e-3, FORMULA),
    )


@cache
def constraints() -> tuple[float, ...]:
    """Constraints (2) [mm]: the crank turns fully, the coupler reaches the guide, and the block stays beyond l6 - l1."""
    places = {name: 1e3 * place for name, place in bearing_positions(press(), motion()).items()}
    l1, l3, l4, l6 = (float(np.linalg.norm(places[end] - places[start], axis=1).max()) for start, end in ("AB", "CD", "DE", "CA"))
    block, height = np.linalg.norm(places["B"] - places["C"], axis=1), float((places["E"] - places["C"])[0, 2])
    return l1 - l6, height - l3 - l4, float((l6 - l1 - block).max()), float(block.max())


def pressure_rows() -> Iterator[Row]:
    def ours() -> list[float]:
        angles, crank, part = pressure_curve(press(), motion()), motion().crank_angle, phases(motion(), DRAWN)[1]
        working = angles[(crank >= part.crank_angle) & (crank <= part.crank_angle + part.turned)]
        at_ends = math.degrees(math.asin((630 - 648 * math.cos(math.asin(108 / 350))) / 220))
        return [angles.max(), np.degrees(crank[angles.argmax()]), at_ends, working.max(), working.min()]

    return rows_from(
        ours,
        ("largest pressure angle [deg]", f"{LARGEST_PRESSURE:.4f}", 1e-3, FORMULA),
        ("crank angle there [deg]", "90", 1e-6, FORMULA, 2),
        ("pressure angle at both ends of the stroke [deg]", "", None, "", 3),
        ("largest within the working part [deg]", "", None, "", 3),
        ("smallest within the working part [deg]", "", None, "", 3),
    )


def uniform_rows() -> Iterator[Row]:
    def ours() -> list[float]:
        part = pp.servo_cycle(press(), speed=SPEED, angle=np.radians(np.linspace(60.0, 120.0, 601)))
        travel = 1e3 * float(part.slide_position[0] - part.slide_position[-1])
        drop = 1 - part.slide_velocity.max() / part.slide_velocity.min()  # the ram moves towards -x
        lengths = [1e3 * even_length(motion(), most / 100) for most in (2, 5, 10)]
        return [travel, travel, 100 * drop, 100 * speed_variation(motion(), DRAWN), *lengths]

    return rows_from(
        ours,
        ("travel from 60 to 120 deg [mm]", "more than 120", None, "", 2),
        ("the same [mm]", "156.63", 0.01, SOLVER),
        ("drop of speed within it [%]", "", None, "", 2),
        ("least drop of speed over any 120 mm [%]", "3.69", 0.2, SOLVER),
        *unclaimed((f"longest part with a drop of {most} % [mm]" for most in (2, 5, 10)), 1),
    )


def objective(l1: float, l4: float) -> float:
    """v_max / v_mean by the rules of design, lengths in m."""
    return speed_ratio(pp.cycle(reshaped(press(), design_rules(l1, l4)), SPEED, points=360))


def objective_rows() -> Iterator[Row]:
    lengths, cranks = (0.150, 0.220, 0.400, 1.0, 3.0), (0.080, 0.140)

    def ours() -> list[float]:
        by_lengths = [objective(0.108, l4) for l4 in lengths] + [objective(l1, 0.220) for l1 in cranks] + [objective(0.108, 100.0)]
        return [speed_ratio(motion()), objective(0.108, 0.220), *by_lengths]

    without_end = "f, l4 = 100 m; without end (pi + 2 d) / (2 (1 + sin d)), d = 18 deg"
    yield from rows_from(
        ours,
        ("f = v_max / v_mean, printed lengths", "1.440695", 1e-4, SOLVER),
        ("f by (19) to (21), l4 = 220 mm", "1.44043159", 1e-6, SOLVER),
        *unclaimed((f"f, l4 = {1e3 * l4:g} mm" for l4 in lengths), 6),
        *unclaimed((f"f, l4 = 220 mm, l1 = {1e3 * l1:g} mm" for l1 in cranks), 6),
        (without_end, f"{LIMIT:.6f}", 1e-3, FORMULA),
    )
    words = "l4 that the search within 150 to 220 mm ends at [mm]"
    yield Row(words, "", lambda: 1e3 * as_the_paper_asks(press(), 0.220).variables["l4"], places=2)


def even_rows() -> Iterator[Row]:
    yield Row("drop of speed over 120 mm, printed lengths [%]", "3.69", lambda: 100 * speed_variation(motion(), DRAWN), 0.2, SOLVER)
    for degrees, solved in ((40, "3.39"), (10, "3.64")):

        def ours(degrees: float = degrees) -> list[float]:
            best = even_speed(press(), degrees)
            return [100 * best.value, *(1e3 * best.variables[name] for name in ("l4", "h"))]

        least = f"least drop, pressure angle up to {degrees} deg [%]", solved, 0.3, SOLVER
        yield from rows_from(ours, least, *unclaimed((f"its {name}, up to {degrees} deg [mm]" for name in ("l4", "h")), 0))


PARTS = (
    Part("Fig. 2: crank angles at the ends of the stroke", CONFIRMED, tuple(end_rows()), "The formula is (11) for K = 1.5."),
    Part("Fig. 3: speed of the ram over the crank angle", UNPRINTED, tuple(speed_rows())),
    Part("Phases: approach, working part, run-out and return of Fig. 3", BEYOND, (), "", [phase_table]),
    Part("Example: lengths, time ratio, stroke, pressure angle", PARTLY, tuple(example_rows())),
    Part("Pressure angle: between coupler and guide along the stroke", CONFIRMED, tuple(pressure_rows())),
    Part("Uniform section: travel at even speed", UNPRINTED, tuple(uniform_rows())),
    Part("(22), (23): objective and its optimum", NOT, tuple(objective_rows())),
    Part("Even speed: an objective with an optimum", BEYOND, tuple(even_rows()), "Free are l4 and h, under a limit of the pressure angle."),
    Part(
        "Design charts: time ratio, stroke, pressure angle and drop of speed over l1 / l3 and h / l3",
        BEYOND,
        tuple(chart_rows(press)),
        "Proportions l6 / l3 = 0.540 and l4 / l3 = 0.340 of the example.",
        [lambda: evenest(press())],
    ),
    Part(
        "Weighed: even speed, torque and bearing forces together",
        BEYOND,
        (),
        "Stroke and time ratio are the paper's. Free are l1 (80 to 160 mm, with l6), l4 (80 to 600 mm) and h, with a pressure angle up to"
        " 40 deg. The process, 10 kN over 120 mm, is ours; the bodies keep their masses.",
        [lambda: weighed_table(press())],
    ),
)
NO_RESULTS = "Fig. 1"  # a scheme
# Rows of the page for readers: quantities by the number of their part, all of a part if none is named.
MAIN: dict[str, tuple[str, ...]] = {
    "Fig. 2": ("crank angle at the start of the working stroke [deg]", "crank angle at its end [deg]"),
    "Fig. 3": ("largest speed of the working stroke [mm/s]", "largest speed of the return stroke [mm/s]"),
    "Example": (
        "time ratio K",
        "stroke [mm]",
        "crank l1 by (20) from l6 = 350 mm [mm]",
        "bar l3 by (21) [mm]",
        "height h by (19) [mm]",
        "largest pressure angle, (18) [deg]",
    ),
    "Uniform section": ("travel from 60 to 120 deg [mm]", "drop of speed within it [%]", "least drop of speed over any 120 mm [%]"),
    "(22), (23)": ("f = v_max / v_mean, printed lengths", "f, l4 = 400 mm", "l4 that the search within 150 to 220 mm ends at [mm]"),
    "Even speed": ("least drop, pressure angle up to 40 deg [%]", "least drop, pressure angle up to 10 deg [%]"),
}


def speed_picture() -> "Figure":
    """Speed of the ram with the printed lengths and with the evenest speed under 40 deg."""
    even = pp.cycle(even_speed(press(), 40).press, SPEED, points=POINTS)
    turns = {"printed lengths": motion(), "even speed, ours, up to 40 deg": even}
    curves = {name: (np.degrees(turn.crank_angle), -1e3 * turn.slide_velocity) for name, turn in turns.items()}
    return draw("crank angle [deg]", "speed of the ram [mm/s]", curves)


PICTURES = {"chen2002_speed": speed_picture}
