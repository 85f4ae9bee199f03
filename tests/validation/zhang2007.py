"""Zhang X. 2007, master thesis, Southeast University: the high-speed press JF75G-125, 1250 kN, and how to balance it, by ADAMS.

The thesis prints masses and moments of inertia but no lengths: those of the shipped presses are inferred, each with its reason in the file.
Chapters 3 and 5 are in `zhang2007_balancing` and `zhang2007_search`, chapter 1 and upper dies in `zhang2007_arrangements`, chapter 2 in
`zhang2007_vibration`, the runs of chapter 4 and of 5.7 in `zhang2007_runs`, the parts that it only names in `zhang2007_parts`.
"""

from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from validation import zhang2007_arrangements as arrangements
from validation import zhang2007_balancing as balancing
from validation import zhang2007_parts, zhang2007_runs, zhang2007_vibration
from validation.pictures import draw
from validation.rows import BEYOND, CONFIRMED, DATA, FINDINGS, NOT, UNPRINTED, Part, Row, rows_from
from validation.zhang2007_search import searches_rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@cache
def frame() -> zhang2007_vibration.Vibration:
    return zhang2007_vibration.Vibration()


def vibration_rows() -> Iterator[Row]:
    """Chapter 2: what accelerometers on the frame showed, on 10 mm of rubber, at 200 to 400 r/min."""

    return rows_from(
        lambda: [f"{finding.gives}. Agrees: {finding.agrees}" for finding in frame().findings()],
        *((says, "in words") for says in zhang2007_vibration.SAID),
    )


PARTS = (
    Part(
        "Fig. 1-1 to 1-4: machines of others, and how they are balanced",
        FINDINGS,
        tuple(arrangements.machine_rows()),
        "The thesis shows schemes without any size. Ours have the stroke, slide, crank and rod of the JF75G-125, at 300 strokes/min;"
        " `viz/arrangements.md` compares them further.",
    ),
    Part(
        "Fig. 2-7 to 2-15, Fig. 2-17, Fig. 2-18: vibration of the frame",
        FINDINGS,
        tuple(vibration_rows()),
        "The curves are voltages without a scale. All data of our frame on four rubber pads are assumed (`viz/foundation.md`).",
    ),
    Part(
        "Fig. 3-1, Fig. 3-2: balancing of rotors in one and two planes",
        CONFIRMED,
        tuple(balancing.rotor_rows()),
        "Our example: 2 kg at 100 mm and a hole of 1.2 kg at 150 mm across, 50 and 200 mm along the shaft; planes at 0 and 300 mm.",
    ),
    Part("Fig. 3-3: motion of the slide", CONFIRMED, tuple(balancing.slide_rows()), "The formula is (3.2.2). Upwards is positive."),
    Part(
        "Fig. 3-4: complete balancing",
        CONFIRMED,
        tuple(balancing.complete_rows()),
        "Our example: counterweights at 0.30 m on the rod and 0.15 m on the crank.",
    ),
    Part("Fig. 3-5: approximate balancing", CONFIRMED, tuple(balancing.approximate_rows()), "Our example: counterweight at 0.15 m."),
    Part(
        "Fig. 3-6: opposed arrangement",
        CONFIRMED,
        tuple(balancing.opposed_rows()),
        "With the inferred auxiliary crank of 29.7 mm and rod of 600 mm.",
    ),
    Part("Fig. 3-7 (captioned 4-6): forces of the opposed arrangement", NOT, tuple(balancing.guide_rows())),
    Part("Fig. 3-8: symmetric arrangement", CONFIRMED, tuple(balancing.symmetric_rows())),
    Part("Table 4-1: motor with slip clutch", DATA, tuple(zhang2007_runs.motor_rows()), "The primary speed of 1470 r/min is ours."),
    Part(
        "4.3, control: where the speed control is lost",
        CONFIRMED,
        tuple(zhang2007_runs.control_rows()),
        "By (4.3.1), set to 900 r/min; the gain follows from the regulation.",
    ),
    Part(
        "Fig. 4-10, Fig. 4-11, Fig. 4-12 (captioned 4-11): motion of the slide by Runge-Kutta",
        UNPRINTED,
        tuple(zhang2007_runs.motion_rows()),
        "The solver integrates the correct equation with the thesis' torque, initial speed and step and the inferred lengths.",
    ),
    Part(
        "(5-3) to (5-6): a rod with its counterweight",
        CONFIRMED,
        tuple(balancing.rod_rows()),
        "Our example: on the auxiliary rod a disc of half its mass with a radius of 100 mm, 150 mm from the pin, 150 degrees from the rod's"
        " centre of mass.",
    ),
    Part(
        "5.4: searches at random, on a grid, step by step, and the proved optimum",
        BEYOND,
        tuple(searches_rows()),
        "Between m5 = 0 and 150 kg and m6 = 900 and 1200 kg; times by `python tests/benchmarks/run.py searches`.",
    ),
    Part(
        "(5-10) to (5-14): objective of balancing",
        UNPRINTED,
        tuple(balancing.objective_rows()),
        "Weights and scales are not printed; ours are a quarter for each.",
    ),
    Part(
        "Table 5-1: search for the masses of auxiliary rod and counterweight",
        NOT,
        tuple(balancing.search_rows()),
        "Range of the vertical force.",
        [balancing.other_lengths],
    ),
    Part("Fig. 5-11: empty strokes after the search", NOT, tuple(balancing.idle_rows()), "Without the weight."),
    Part(
        "Table 5-2: shaking force before and after",
        NOT,
        tuple(balancing.comparison_rows()),
        "The original's forces include the weights of what moves and of the flywheel, the improved press's none.",
        [balancing.readings],
    ),
    Part(
        "Fig. 5-8 to 5-10: load laws of piling, blanking, drawing",
        CONFIRMED,
        tuple(zhang2007_runs.law_rows()),
        "Over the slide's height: blanking from 10 to 5 mm, drawing from 10 to 0 mm.",
    ),
    Part("Fig. 5-12: ADAMS' function STEP", CONFIRMED, tuple(zhang2007_runs.step_rows())),
    Part(
        "5.1.2 (3), 5.1.3: ADAMS' functions of contact",
        CONFIRMED,
        tuple(zhang2007_runs.contact_rows()),
        "Our example: k = 2.2e9 N/m^1.5, a damper of 1e5 N s/m from 0.5 mm on.",
    ),
    Part("Fig. 5-13: forces under piling", NOT, tuple(zhang2007_runs.case_rows("piling")), "Sizes of peaks."),
    Part("Fig. 5-14: forces under blanking", NOT, tuple(zhang2007_runs.case_rows("blanking")), "Windows go with the slide's height."),
    Part("Fig. 5-15: forces under drawing", NOT, tuple(zhang2007_runs.case_rows("drawing"))),
    Part(
        "3.5, m7: counterweight for slide and upper die",
        CONFIRMED,
        tuple(arrangements.die_rows()),
        "m6 = L1 / L2 m_A - m4 e4 / L4, where m_A is the mass of slide, upper die and the main rod's share at the slide's pin.",
    ),
    Part(
        "1.2.1, 6.2 (4): balance and the change of die and stroke",
        BEYOND,
        (),
        "Ranges of the vertical force at 300 strokes/min, balanced for one die or stroke, by a proved compromise, and set again for each.",
        [arrangements.changed_dies, arrangements.changed_blocks, arrangements.changed_slide],
    ),
    Part(
        "2.1: tie rods, eight-way guide and balance cylinders",
        BEYOND,
        tuple(zhang2007_parts.frame_rows()),
        "All data are assumed: rods of 2e9 N/m, uprights of 6e9 N/m, four cylinders of 125 mm at 4.4 bar with a tank of 60 l, eight gibs of"
        " 600 x 80 mm and 2e9 N/m.",
    ),
    Part(
        "5.7.6: measures against the shock of blanking",
        BEYOND,
        tuple(zhang2007_parts.shock_rows()),
        "All data are assumed: `jf75g_125_plain` on springs, 60 strokes/min, a blank of 600 kN whose force falls to half before it breaks;"
        " a pace that falls to 2 % at 27 degrees before bottom dead centre; two dampers with orifices of 12 mm.",
    ),
)
# photographs, schemes, drawings of models, screenshots, a flow chart
NO_RESULTS = "Fig. 2-1 to 2-6, Fig. 2-16, Fig. 4-4 to 4-9, Fig. 5-1 to 5-7"
# Rows of the page for readers: quantities by the number of their part, all of a part if none is named.
MAIN: dict[str, tuple[str, ...]] = {
    "Fig. 3-6": (
        "m6 with an auxiliary rod of 113.31 kg [kg]",
        "range of the vertical shaking force without [N]",
        "range of the vertical shaking force with it [N]",
    ),
    "Fig. 3-8": ("range of the lateral shaking force, opposed [N]", "range of the lateral shaking force, symmetric [N]"),
    "Fig. 4-10, Fig. 4-11, Fig. 4-12 (captioned 4-11)": ("crank angle [rad] after 0.6 s", "rise of the crank speed in 1 s [%]"),
    "Table 5-1": (
        "step 1, m5 = 100 kg, m6 = 1000 kg [N]",
        "step 4, m5 = 114.095 kg, m6 = 1044.6 kg [N]",
        "step 17, m5 = 113.31 kg, m6 = 1045 kg [N]",
        "optimum, m5 [kg]",
        "optimum, m6 [kg]",
        "optimum, range [N]",
    ),
    "Table 5-2": (
        "original, 300 r/min, vertical maximum [N]",
        "original, 300 r/min, vertical minimum [N]",
        "original, 300 r/min, vertical range [N]",
        "original, 300 r/min, lateral range [N]",
        "improved, 300 r/min, vertical range [N]",
        "improved, 300 r/min, lateral range [N]",
        "300 r/min, vertical range before by after",
        "300 r/min, lateral range before by after",
    ),
    **{
        f"Fig. 5-{k}": ("peak of the vertical force [N], with 1250 kN", "peak of the vertical force [N], with 1250 N") for k in (13, 14, 15)
    },
}


def search_picture() -> "Figure":
    """Table 5-1: the printed ranges, ours with the same masses, and our optimum as dashes."""
    steps = np.arange(1.0, len(balancing.SEARCH) + 1)
    ours = balancing.ranges(balancing.opposed())(np.array([step[:2] for step in balancing.SEARCH]))
    curves = {"Zhang 2007": (steps, np.array([float(step[2]) for step in balancing.SEARCH])), "pinpress, same masses": (steps, ours)}
    return draw("step of the search", "range of the vertical force [N]", curves, (balancing.proved()[1],), logarithmic=True)


PICTURES = {"zhang2007_search": search_picture}
