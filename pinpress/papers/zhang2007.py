"""Zhang X. 2007, master thesis, Southeast University: the high-speed press JF75G-125, 1250 kN, and how to balance it, by ADAMS.

The thesis prints masses and moments of inertia but no lengths: those of the shipped presses are inferred, each with its reason in the file.
Chapters 2 and 3 are here, 4 in `zhang2007_motion`, the balancing of chapter 5 in `zhang2007_balancing`, its loads in `zhang2007_loads`.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..balancing import classical
from ..balancing.counterweights import Counterweight, with_counterweights
from ..dynamics.inverse_dynamics import Reactions
from ..linkage.linkage import Linkage
from . import zhang2007_balancing, zhang2007_loads, zhang2007_motion, zhang2007_vibration
from .drawings import Panel, draw
from .pages import FINDINGS, FORMULAS, NO_RESULT, NOT, Entry, Page, Row
from .zhang2007_errata import ERRATA
from .zhang2007_presses import GRAVITY, POINTS, SPEED, clean, figures, presses, turning

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AUXILIARY = 0.0297  # auxiliary crank of the shipped press [m]
RADIUS, ROD_RADIUS = 0.15, 0.30  # of counterweights on crank and rod: ours, as the thesis prints none [m]
FORMULA = "formula"


def page() -> Page:
    """All tables and figures of the thesis."""
    given = presses()
    return Page(
        "zhang2007",
        "Zhang 2007: the high-speed press JF75G-125",
        "Zhang X. 2007, master thesis, Southeast University, Nanjing (in Chinese): vibration measurements, balancing arrangements,"
        " equations of motion and ADAMS models of a 1250 kN press at 300 strokes/min. `jf75g_125_plain`, `jf75g_125` and"
        " `jf75g_125_symmetric`. The thesis prints no lengths; ours are inferred, with reasons in these files, so that what depends on"
        " them can agree only as far as they do. We read the thesis in a transcription: what may be its mistake is marked `as our text"
        " reads`. Gravity is not printed, ours 9.80665 m/s2. Written by `python -m pinpress.papers zhang2007`.",
        (
            Entry(figures(1, 1, 4), "presses of others", NO_RESULT),
            Entry(figures(2, 1, 6), "photograph, scheme, CAD model, instruments, measuring points", NO_RESULT),
            _vibration(),
            Entry(("Fig. 2-16",), "photograph of the tool for piling", NO_RESULT),
            *_balancing(given),
            *zhang2007_motion.entries(given),
            Entry(figures(5, 1, 7), "flow chart, ADAMS models, schemes and screenshot", NO_RESULT),
            *zhang2007_balancing.entries(given),
            *zhang2007_loads.entries(given["jf75g_125_symmetric"]),
        ),
        ERRATA,
    )


def _vibration() -> Entry:
    """Chapter 2: what it finds by accelerometers on the frame, on 10 mm of rubber, at 200 to 400 r/min."""
    model = zhang2007_vibration.Vibration()
    rows = tuple(Row(f"{one.place}: {one.says}", "in words", f"{one.gives}. Agrees: {one.agrees}") for one in model.findings())
    reason = (
        "The curves are voltages behind amplifiers without a scale in m/s2, and the frame's mass and the stiffness of its mounts are not"
        " printed: only what the thesis says of them in words can be compared. Ours is a frame of bed and crown on columns, on four rubber"
        " pads, all of it assumed; `viz/foundation.md` names the assumptions, and what hangs on them."
    )
    numbers = (*figures(2, 7, 15), "Fig. 2-17", "Fig. 2-18")
    caption = "Ours: acceleration of the top beam, idle."
    return Entry(numbers, "vibration of the frame", FINDINGS, rows, reason, "zhang2007_vibration", model.draw, caption)


def _balancing(given: Mapping[str, Linkage]) -> tuple[Entry, ...]:
    plain, opposed, symmetric = given.values()
    before, after = turning(plain), turning(opposed)
    return (
        _rotors(),
        _slide(before),
        _complete(plain, before),
        _approximate(plain, before),
        _opposed(plain, before, after),
        _guides(plain, before),
        _symmetric(after, turning(symmetric)),
    )


def _rotors() -> Entry:
    masses, places, planes = [2.0, -1.2], [[0.10, 0.05, 0.0], [0.0, 0.20, 0.15]], (0.0, 0.30)
    products = [np.array([0.2, 0.0]), np.array([0.0, -0.18])]  # m r, across the shaft [kg m]
    alone = classical.static_balance(masses, places)
    first, second = classical.two_plane_balance(masses, places, planes=planes)
    far = [(0.30 - y) / 0.30 for y in (0.05, 0.20)]  # share of each in the first plane
    by_hand = [
        np.linalg.norm(products[0] + products[1]),
        np.linalg.norm(sum(share * product for share, product in zip(far, products, strict=True))),
        np.linalg.norm(sum((1 - share) * product for share, product in zip(far, products, strict=True))),
    ]
    names = ("in one plane (3.1.5)", "in two planes, first", "in two planes, second")
    rows = tuple(
        Row(f"mass times radius {name} [kg m]", f"{hand:.6f}", float(np.linalg.norm(found.product)), 1e-3, None, FORMULA)
        for name, hand, found in zip(names, by_hand, (alone, first, second), strict=True)
    )
    reason = (
        "The thesis has formulas without an example. Ours: 2 kg at 100 mm and a hole of 1.2 kg at 150 mm across, 50 and 200 mm along the"
        " shaft; planes at 0 and 300 mm."
    )
    return Entry(("Fig. 3-1", "Fig. 3-2"), "balancing of rotors in one and two planes", FORMULAS, rows, reason)


def _slide(before: Reactions) -> Entry:
    motion, radius, ratio, speed = before.motion, 0.015, 0.05, SPEED
    angle = motion.crank_angle
    formula = speed**2 * radius * (np.cos(angle) + ratio * np.cos(2 * angle))
    rows = tuple(
        Row(
            f"acceleration at {degrees} deg from bottom dead centre [m/s2]",
            f"{formula[k]:.4f}",
            float(motion.slide_acceleration[k]),
            0.05,
            None,
            FORMULA,
        )
        for degrees in (0, 60, 120, 180)
        for k in [degrees * POINTS // 360]
    )
    error = float(np.abs(formula - motion.slide_acceleration).max())
    rows += (
        Row("largest error of (3.2.2) over the turn [m/s2]", "", error, places=4),
        Row("stroke [mm]", "", float(1e3 * np.ptp(motion.slide_position)), places=2),
    )

    def shown() -> "Figure":
        time = 1e3 * motion.time
        panels = (
            Panel("position [mm]", {"": (time, 1e3 * (motion.slide_position - motion.slide_position[0]))}),
            Panel("velocity [m/s]", {"": (time, motion.slide_velocity)}),
            Panel("acceleration [m/s2]", {"": (time, motion.slide_acceleration)}, (), list(zip(time[::60], formula[::60], strict=True))),
        )
        return draw("time [ms]", panels, 3.4)

    reason = "(3.2.2) is the first two terms of a series; with the inferred crank of 15 mm and rod of 300 mm. Upwards is positive."
    caption = "Crosses: (3.2.2)."
    return Entry(("Fig. 3-3",), "motion of the slide", FORMULAS, rows, reason, "zhang2007_slide", shown, caption)


def _complete(plain: Linkage, before: Reactions) -> Entry:
    main = classical.as_crank_slider(plain)
    h1, h2 = main.crank_centre.real, main.rod_centre.real
    on_rod = (main.rod_mass * h2 + main.slide_mass * main.rod_length) / ROD_RADIUS
    at_pin = on_rod + main.rod_mass + main.slide_mass
    right = (at_pin * main.crank_radius + main.crank_mass * h1) / RADIUS
    wrong = (main.rod_mass * main.crank_radius + main.crank_mass * h1) / RADIUS  # as our text reads
    rod, crank = classical.complete_balance(plain, rod_radius=ROD_RADIUS, crank_radius=RADIUS)
    peak = float(np.ptp(before.shaking_force[:, 2]))

    def left(weights: Sequence[Counterweight]) -> float:
        return clean(float(np.ptp(turning(with_counterweights(plain, weights)).shaking_force[:, 2])), peak)

    rows = (
        Row("m'' on the rod [kg]", f"{on_rod:.3f}", rod.mass, 1e-3, None, FORMULA),
        Row("m' on the crank, corrected [kg]", f"{right:.3f}", crank.mass, 1e-3, None, FORMULA),
        Row("m' on the crank, as our text reads [kg]", "", wrong, places=3),
        Row("range of the vertical shaking force without balancing [N]", "", peak, places=0),
        Row("with both, m' corrected [N]", "0", left((rod, crank)), 0, None, FORMULA),
        Row("with both, m' as our text reads [N]", "", left((rod, Counterweight("crank", wrong, crank.position))), places=0),
    )
    reason = (
        "The thesis has formulas without an example. Ours: counterweights at 0.30 m on the rod and 0.15 m on the crank. As our text"
        " reads, m' has the rod's mass m2 where m_B belongs, all that hangs on the crank pin, and nearly doubles the force."
    )
    return Entry(("Fig. 3-4",), "complete balancing", FORMULAS, rows, reason)


def _approximate(plain: Linkage, before: Reactions) -> Entry:
    main = classical.as_crank_slider(plain)
    k, share = main.crank_radius, main.rod_share.real
    reciprocating = main.slide_mass + main.rod_mass * share
    turns = k / RADIUS * (main.crank_centre.real / k * main.crank_mass + (1 - share) * main.rod_mass)
    force = reciprocating * k * SPEED**2
    whole, half = (classical.approximate_balance(plain, RADIUS, share=part) for part in (1.0, 0.5))

    def first_order(weight: Counterweight) -> tuple[float, float]:
        after = turning(with_counterweights(plain, [weight]))
        changes = {(c.quantity, c.order): c.after for c in classical.compare_harmonics(before, after)}
        return tuple(clean(changes[f"force {way} the slide", 1], force) for way in ("along", "across"))  # type: ignore[return-value]

    along, across = first_order(whole)
    rows = (
        Row("m' + m'' on the crank [kg]", f"{turns + k / RADIUS * reciprocating:.3f}", whole.mass, 1e-3, None, FORMULA),
        Row("first order along the slide after it [N]", "0", along, 0, None, FORMULA),
        Row("first order across the slide after it [N]", f"{force:.1f}", across, 0.1, None, FORMULA),
        Row("half of m'': first order along the slide [N]", f"{force / 2:.1f}", first_order(half)[0], 0.1, None, FORMULA),
        Row("half of m'': first order across the slide [N]", f"{force / 2:.1f}", first_order(half)[1], 0.1, None, FORMULA),
    )
    reason = "Formulas without an example; counterweight at 0.15 m. What is taken away along the slide appears across it."
    return Entry(("Fig. 3-5",), "approximate balancing", FORMULAS, rows, reason)


def _opposed(plain: Linkage, before: Reactions, as_printed: Reactions) -> Entry:
    main = classical.as_crank_slider(plain)
    rod = 113.31
    wanted = (main.slide_mass + main.rod_mass / 2) * main.crank_radius / AUXILIARY - rod / 2
    press = classical.with_opposed_balancer(plain, AUXILIARY, rod_length=0.6, rod_mass=rod)
    after = turning(press)
    built = press.model.inertias[press.model.getJointId("counterweight_guide")].mass
    peak = float(np.ptp(before.shaking_force[:, 2]))
    rows = (
        Row("m6 with an auxiliary rod of 113.31 kg [kg]", f"{wanted:.2f}", float(built), 1e-2, None, FORMULA),
        Row("range of the vertical shaking force without [N]", "", peak, places=0),
        Row("with it [N]", "", float(np.ptp(after.shaking_force[:, 2])), places=2),
        Row("range of the lateral shaking force with it [N]", "", clean(float(np.ptp(after.shaking_force[:, 0])), peak), places=2),
        Row("masses of table 5-1 instead, vertical [N]", "", float(np.ptp(as_printed.shaking_force[:, 2])), places=2),
        Row("masses of table 5-1 instead, lateral [N]", "", float(np.ptp(as_printed.shaking_force[:, 0])), places=2),
    )
    reason = (
        "By the thesis' formulas for m6, with the inferred auxiliary crank of 29.7 mm and rod of 600 mm. What is left along the slide is"
        " the second order, as the ratios of crank and rod are 0.05 and 0.0495. Its masses of table 5-1 balance the sum of all masses"
        " instead."
    )
    return Entry(("Fig. 3-6",), "opposed arrangement", FORMULAS, rows, reason)


def _guides(plain: Linkage, before: Reactions) -> Entry:
    main = classical.as_crank_slider(plain)
    weight = (main.rod_mass + main.slide_mass) * GRAVITY
    centre = (main.rod_mass * main.rod_length / 2 + main.slide_mass * main.rod_length) / (main.rod_mass + main.slide_mass)
    simple = weight * centre / main.rod_length * np.tan(np.arcsin(main.crank_radius / main.rod_length))
    guide = float(np.abs(before.bearing_force["slide_guide"][:, 0]).max())
    wrong = (Row("peak of X4, the force in the slide's guide, by (3.5.24) [N]", f"{simple:.0f}", guide, None, None, FORMULA),)
    why = (
        "At constant crank speed, (3.5.20)-(3.5.25) take the angular accelerations of the rods and the accelerations of their mass centres"
        " for zero, which they are not, and turn the sign that gravity has in (3.5.3) and (3.5.6). What is left of X4 is gravity's alone."
    )
    return Entry(("Fig. 3-7 (captioned 4-6)",), "forces of the opposed arrangement", NOT, wrong, why)


def _symmetric(opposed: Reactions, symmetric: Reactions) -> Entry:
    force, moment = np.ptp(opposed.shaking_force[:, 0]), np.ptp(opposed.shaking_moment[:, 1])
    rows = (
        Row("range of the lateral shaking force, opposed [N]", "", float(force), places=1),
        Row("the same, symmetric [N]", "0", clean(float(np.ptp(symmetric.shaking_force[:, 0])), float(force)), 0, None, FORMULA),
        Row("range of the tilting moment, opposed [N m]", "", float(moment), places=1),
        Row("the same, symmetric [N m]", "0", clean(float(np.ptp(symmetric.shaking_moment[:, 1])), float(moment)), 0, None, FORMULA),
        Row("range of the vertical shaking force, opposed [N]", "", float(np.ptp(opposed.shaking_force[:, 2])), places=2),
        Row("the same, symmetric [N]", "", float(np.ptp(symmetric.shaking_force[:, 2])), places=2),
    )
    reason = "The thesis says it in words: no lateral force and no tilting moment. The vertical force stays as it is."
    return Entry(("Fig. 3-8",), "symmetric arrangement", FORMULAS, rows, reason)
