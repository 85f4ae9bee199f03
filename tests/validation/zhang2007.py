"""Zhang X. 2007, master thesis, Southeast University: the high-speed press JF75G-125, 1250 kN, and how to balance it, by ADAMS.

The thesis prints masses and moments of inertia but no lengths: those of the shipped presses are inferred, each with its reason in the file.
Chapter 3 is here, chapter 1 in `zhang2007_arrangements`, chapter 2 in `zhang2007_vibration`, the balancing of chapter 5 in
`zhang2007_balancing` and `zhang2007_search`, the runs of chapter 4 and of 5.7 in `zhang2007_runs`, and the parts
that it only names in `zhang2007_parts`.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pinpress.balancing import classical
from pinpress.balancing.counterweights import Counterweight, with_counterweights
from pinpress.dynamics.reactions import Reactions
from pinpress.linkage.linkage import Linkage
from validation import zhang2007_arrangements, zhang2007_balancing, zhang2007_parts, zhang2007_runs, zhang2007_search, zhang2007_vibration
from validation.pages import BEYOND, FINDINGS, FORMULAS, NO_RESULT, NOT, Erratum, Grid, Page, PageEntry, Panel, Row, draw, figures
from validation.zhang2007_balancing import GRAVITY, POINTS, SPEED, clean, presses, turning

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AUXILIARY = 0.0297  # auxiliary crank of the shipped press [m]
RADIUS, ROD_RADIUS = 0.15, 0.30  # radii of counterweights on crank and rod; ours, as the thesis prints none [m]
FORMULA = "formula"


def page() -> Page:
    """All tables and figures of the thesis."""
    given = presses()
    return Page(
        "zhang2007",
        "Zhang 2007: the high-speed press JF75G-125",
        "Zhang X. 2007, master thesis, Southeast University, Nanjing (in Chinese): vibration measurements, balancing arrangements,"
        " equations of motion and ADAMS models of a 1250 kN press at 300 strokes/min. `jf75g_125_plain`, `jf75g_125` and"
        " `jf75g_125_symmetric`. The thesis prints no lengths; ours are inferred, with reasons in these files, so numbers that depend on"
        " lengths can agree only as far as these do. We read the thesis in a transcription: what may be a mistake of the transcription is"
        " marked `as our text reads`. Gravity is not printed; ours is 9.80665 m/s2."
        " Written by `python tests/validation/validate.py zhang2007`.",
        (
            zhang2007_arrangements.machines(given),
            PageEntry(figures(2, 1, 6), "photograph, scheme, CAD model, instruments, measuring points", NO_RESULT),
            _vibration(),
            PageEntry(("Fig. 2-16",), "photograph of the tool for piling", NO_RESULT),
            *_balancing(given),
            *zhang2007_runs.motion_entries(given),
            PageEntry(figures(5, 1, 7), "flow chart, ADAMS models, schemes and screenshot", NO_RESULT),
            *zhang2007_search.entries(given["jf75g_125"]),
            *zhang2007_balancing.entries(given),
            *zhang2007_runs.load_entries(given["jf75g_125_symmetric"]),
            *zhang2007_arrangements.dies(given),
            *zhang2007_parts.entries(given["jf75g_125_plain"]),
            TOOLS,
        ),
        ERRATA,
        ("Fig. 5-11", "Zhang 2007, 5 and 6: the balanced press at work"),
    )


def _vibration() -> PageEntry:
    """Chapter 2: what accelerometers on the frame showed, on 10 mm of rubber, at 200 to 400 r/min."""
    model = zhang2007_vibration.Vibration()
    rows = tuple(Row(f"{one.place}: {one.says}", "in words", f"{one.gives}. Agrees: {one.agrees}") for one in model.findings())
    reason = (
        "The curves are voltages without a scale, and the frame's mass and mounts are not printed. So only words can be compared. Ours"
        " is a frame of bed and crown on columns, on four rubber pads, all of it assumed (`viz/foundation.md`)."
    )
    numbers = (*figures(2, 7, 15), "Fig. 2-17", "Fig. 2-18")
    caption = "Ours: acceleration of the top beam, idle."
    return PageEntry(numbers, "vibration of the frame", FINDINGS, rows, reason, "zhang2007_vibration", model.draw, caption)


def _balancing(given: Mapping[str, Linkage]) -> tuple[PageEntry, ...]:
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


def _rotors() -> PageEntry:
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
    return PageEntry(("Fig. 3-1", "Fig. 3-2"), "balancing of rotors in one and two planes", FORMULAS, rows, reason)


def _slide(before: Reactions) -> PageEntry:
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

    reason = "(3.2.2) has the first two terms of a series. Crank (15 mm) and rod (300 mm) are inferred. Upwards is positive."
    caption = "Crosses: (3.2.2)."
    return PageEntry(("Fig. 3-3",), "motion of the slide", FORMULAS, rows, reason, "zhang2007_slide", shown, caption)


def _complete(plain: Linkage, before: Reactions) -> PageEntry:
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
        " reads, m' has the rod's mass m2 in place of m_B, the mass of all that hangs on the crank pin, and nearly doubles the force."
    )
    return PageEntry(("Fig. 3-4",), "complete balancing", FORMULAS, rows, reason)


def _approximate(plain: Linkage, before: Reactions) -> PageEntry:
    main = classical.as_crank_slider(plain)
    k, share = main.crank_radius, main.rod_share.real
    reciprocating = main.slide_mass + main.rod_mass * share
    turns = k / RADIUS * (main.crank_centre.real / k * main.crank_mass + (1 - share) * main.rod_mass)
    force = reciprocating * k * SPEED**2
    whole, half = (classical.approximate_balance(plain, RADIUS, share=part) for part in (1.0, 0.5))

    def first_order(weight: Counterweight) -> tuple[float, float]:
        after = turning(with_counterweights(plain, [weight]))
        changes = {(c.quantity, c.order): c.after for c in classical.compare_harmonics(before, after)}
        return clean(changes["force along the slide", 1], force), clean(changes["force across the slide", 1], force)

    along, across = first_order(whole)
    rows = (
        Row("m' + m'' on the crank [kg]", f"{turns + k / RADIUS * reciprocating:.3f}", whole.mass, 1e-3, None, FORMULA),
        Row("first order along the slide after it [N]", "0", along, 0, None, FORMULA),
        Row("first order across the slide after it [N]", f"{force:.1f}", across, 0.1, None, FORMULA),
        Row("half of m'': first order along the slide [N]", f"{force / 2:.1f}", first_order(half)[0], 0.1, None, FORMULA),
        Row("half of m'': first order across the slide [N]", f"{force / 2:.1f}", first_order(half)[1], 0.1, None, FORMULA),
    )
    reason = "Formulas without an example; counterweight at 0.15 m. The force that is taken away along the slide appears across it."
    return PageEntry(("Fig. 3-5",), "approximate balancing", FORMULAS, rows, reason)


def _opposed(plain: Linkage, before: Reactions, as_printed: Reactions) -> PageEntry:
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
        "m6 is that of the thesis' formulas, with the inferred auxiliary crank of 29.7 mm and rod of 600 mm. The second order is left"
        " along the slide, as the ratios of crank to rod are 0.05 and 0.0495. The masses of table 5-1 balance the sum of all masses"
        " instead."
    )
    return PageEntry(("Fig. 3-6",), "opposed arrangement", FORMULAS, rows, reason)


def _guides(plain: Linkage, before: Reactions) -> PageEntry:
    main = classical.as_crank_slider(plain)
    weight = (main.rod_mass + main.slide_mass) * GRAVITY
    centre = (main.rod_mass * main.rod_length / 2 + main.slide_mass * main.rod_length) / (main.rod_mass + main.slide_mass)
    simple = weight * centre / main.rod_length * np.tan(np.arcsin(main.crank_radius / main.rod_length))
    guide = float(np.abs(before.bearing_force["slide_guide"][:, 0]).max())
    wrong = (Row("peak of X4, the force in the slide's guide, by (3.5.24) [N]", f"{simple:.0f}", guide, None, None, FORMULA),)
    why = (
        "At constant crank speed, (3.5.20)-(3.5.25) take the angular accelerations of the rods and the accelerations of their mass centres"
        " as zero, which they are not, and reverse the sign that gravity has in (3.5.3) and (3.5.6). Only gravity is left in X4."
    )
    return PageEntry(("Fig. 3-7 (captioned 4-6)",), "forces of the opposed arrangement", NOT, wrong, why)


def _symmetric(opposed: Reactions, symmetric: Reactions) -> PageEntry:
    force, moment = np.ptp(opposed.shaking_force[:, 0]), np.ptp(opposed.shaking_moment[:, 1])
    rows = (
        Row("range of the lateral shaking force, opposed [N]", "", float(force), places=1),
        Row("the same, symmetric [N]", "0", clean(float(np.ptp(symmetric.shaking_force[:, 0])), float(force)), 0, None, FORMULA),
        Row("range of the tilting moment, opposed [N m]", "", float(moment), places=1),
        Row("the same, symmetric [N m]", "0", clean(float(np.ptp(symmetric.shaking_moment[:, 1])), float(moment)), 0, None, FORMULA),
        Row("range of the vertical shaking force, opposed [N]", "", float(np.ptp(opposed.shaking_force[:, 2])), places=2),
        Row("the same, symmetric [N]", "", float(np.ptp(symmetric.shaking_force[:, 2])), places=2),
    )
    reason = "The thesis says in words that there is no lateral force and no tilting moment. The vertical force stays as it is."
    return PageEntry(("Fig. 3-8",), "symmetric arrangement", FORMULAS, rows, reason)


TOOLS = PageEntry(
    ("5.1.4, 5.2, 5.6, 6.1, 6.2",),
    "what of the tools, the results and the outlook is here",
    BEYOND,
    reason="These sections print no numbers.",
    grids=(
        Grid(
            ("", "the thesis", "here"),
            (
                ("5.1.4", "design studies, experiments, optimisation", "`pp.sweeps`, `balance`, `synthesise`"),
                (
                    "5.2",
                    "build, test, validate by measurements, refine, parameters, optimise",
                    "pin tables, `check`, `pp.measured`, springs and friction",
                ),
                ("5.6", "no degree of freedom left: kinematics, else dynamics", "`inverse_dynamics` of a motion, `simulate`"),
                ("6.1", "vibration, balancing, equations of motion, ADAMS, load cases", "Figs 2-7 to 2-18, 3-1 to 3-8, 4-10, 5-11 to 5-15"),
                ("6.2 (1)", "models of contact surfaces", "`PreloadedJoint`, `Clearance`, measured modes"),
                ("6.2 (2)", "smaller models of large machines", "`reduced_frame`"),
                ("6.2 (3)", "flexible bodies from modal files", "`read_flexible_link`; of links of planar presses"),
                ("6.2 (4)", "masses for more general use", "1.2.1, 6.2 (4) above"),
            ),
        ),
    ),
)
# Where a mistake may be the transcription's, the erratum says "as our text reads". Letters of a symbol font (l for lambda, f for phi) and
# dots lost above letters are no mistakes of the thesis and are not listed.
ERRATA = (
    Erratum("3.3", "m' = (m2 l1 + m1 h1) / r1, as our text reads", "m' = (m_B l1 + m1 h1) / r1, with all that hangs on the crank pin"),
    Erratum("3.4", "the second-order force is the first-order one again, as our text reads", "m_P4 omega^2 R lambda cos(2 phi), as in 3.2"),
    Erratum(
        "(3.5.1)",
        "signs of the pin forces",
        "by (3.5.2)-(3.5.6), with P3 opposite to P2: M - L1 (X2 sin(theta) + Y2 cos(theta)) + L2 (X3 sin(theta) + Y3 cos(theta))",
    ),
    Erratum(
        "(3.5.4), (3.5.7)",
        "sign of X4 against X2, of X5 against X3",
        "X4 and -X2, at opposite ends, turn the rod one way: J alpha'' = -X4 (L3 - e3) cos(alpha) - X2 e3 cos(alpha) + Y2 e3 sin(alpha)",
    ),
    Erratum("(3.5.6)", "m_s1, as our text reads", "m_s2"),
    Erratum("(3.5.12), (3.5.13)", "P3 on the side of P2", "it is opposite"),
    Erratum("(3.5.16)", "follows from (8)", "from (9)"),
    Erratum("(3.5.18)", "absent in our text", "by its place y1 = L1 sin(theta) + e3 cos(alpha), from (11), of the kind of (3.5.19)"),
    Erratum("(3.5.20)-(3.5.25)", "theta'' = 0 makes alpha'' = beta'' = 0", "they are not zero at constant speed, see Fig. 3-7"),
    Erratum("(3.5.20)-(3.5.23)", "the accelerations of the mass centres are dropped", "they are not zero either: X4 is not X2"),
    Erratum("(3.5.20), (3.5.21)", "gravity with the other sign than in (3.5.3), (3.5.6)", "Y2 = m_s1 (g + y1''), Y3 = m_s2 (g + y2'')"),
    Erratum("(3.5.23)", "follows from (16)", "from (17)"),
    Erratum("(4.2.1) on", "lambda^2 terms of x' with a plus", "with a minus"),
    Erratum("(4.2.14)", "twice, as our text reads: the slide's y after (4.2.3), and the first-order system", "the first is (4.2.4)"),
    Erratum("(4.2.6), (4.2.7)", "cos q, a stray l^2, rho2", "cos^2 q, no l^2, rho2^2"),
    Erratum("dV/dq after (4.2.8)", "m1 r", "m1 rho1"),
    Erratum(
        "(4.2.9), (4.2.10)",
        "F (r sin q + lambda^2 sin q cos q / A): no length in the second term",
        "F r (sin q + lambda sin q cos q / A)",
    ),
    Erratum("after (4.2.11)", "g lost beside M2", "M2 g lambda^2 sin q cos q / A"),
    Erratum("(4.2.12)", "no J0 in H1 after it, as our text reads", "J0 + J1"),
    Erratum("after (4.2.13)", "H1 q'' = -H2 q'^2 / H1 + (Q - H3) / H1", "q'' alone on the left"),
    Erratum("(4.2.16)", "r2 in the slide's position, as our text reads", "r1"),
    Erratum("(4.2.25), (4.2.26)", "q2 and omega2 of the auxiliary rod, as our text reads", "q5 and omega5"),
    Erratum("(4.2.31)", "r1 in the counterweight's position, as our text reads", "r2"),
    Erratum("(4.2.23)", "called an acceleration", "it is a velocity"),
    Erratum("(4.2.33)", "-r2 sin(q) q'' alone", "-r2 (sin(q) q'' + cos(q) q'^2)"),
    Erratum("after (4.2.39), (4.2.41)", "q' by the slope of the inertia", "q'^2"),
    Erratum("(4.2.40), (4.2.41)", "a factor cos q too many", "without it"),
    Erratum("(4.2.43), (4.2.45)", "y''", "y'^2"),
    Erratum("4.3, Runge-Kutta", "position by h/6 (l1 + l2 + l3)", "by h^2/6"),
    Erratum("4.3", "curves of 3 periods called steady", "567 N m without losses have no steady state"),
    Erratum("(5-8), (5-9)", "means of differences with their signs", "they vanish, whatever the masses: rms, as in (5-10) to (5-13)"),
    Erratum("Table 5-2", "11621.795, -65789.563 and their range 66952.358", "77411.358, or 1162.795: see Table 5-2"),
    Erratum("Tables 5-1, 5-2", "ranges of 139.07 N and 2724.88 N for the same masses", "not both at one speed; 5.5.5 prints none"),
    Erratum("5.7.3-5.7.5", "load functions of 1250", "1250 kN is 1250000 in newtons"),
    Erratum(
        "5.7.4",
        "window to 0.1738 s in the text, to 0.1838 s with pi / 0.0488 in the load function",
        "one of them; we read 0.1738 s, where a quarter sine over 0.0122 s has pi / 0.0244: see Fig. 5-14",
    ),
    Erratum("5.7.5", "pi / 0.0244", "pi / 0.0384, a half sine"),
    Erratum("5.7.3, 5.7.4", "bottom dead centre at 0.1 s, and at 0.2 s", "once a stroke"),
)
