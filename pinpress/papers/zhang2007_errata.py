"""Mistakes in the equations and tables of Zhang 2007.

The thesis was read in a transcription. Where a mistake may be the transcription's, the erratum says "as our text reads". Letters of a
symbol font (l for lambda, f for phi) and dots lost above letters are no mistakes of the thesis and are not listed.
"""

from .pages import Erratum

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
    Erratum("(3.5.18)", "absent", "by its place y1 = L1 sin(theta) + e3 cos(alpha), from (11), of the kind of (3.5.19)"),
    Erratum("(3.5.20)-(3.5.25)", "theta'' = 0 makes alpha'' = beta'' = 0", "they are not zero at constant speed, see Fig. 3-7"),
    Erratum("(3.5.20)-(3.5.23)", "the accelerations of the mass centres are dropped", "they are not zero either: X4 is not X2"),
    Erratum("(3.5.20), (3.5.21)", "gravity with the other sign than in (3.5.3), (3.5.6)", "Y2 = m_s1 (g + y1''), Y3 = m_s2 (g + y2'')"),
    Erratum("(3.5.23)", "follows from (16)", "from (17)"),
    Erratum("(4.2.1) on", "lambda^2 terms of x' with a plus", "with a minus"),
    Erratum("(4.2.14)", "twice: the slide's y after (4.2.3), and the first-order system", "the first is (4.2.4)"),
    Erratum("(4.2.6), (4.2.7)", "cos q, a stray l^2, rho2", "cos^2 q, no l^2, rho2^2"),
    Erratum("dV/dq after (4.2.8)", "m1 r", "m1 rho1"),
    Erratum(
        "(4.2.9), (4.2.10)",
        "F (r sin q + lambda^2 sin q cos q / A): no length in the second term",
        "F r (sin q + lambda sin q cos q / A)",
    ),
    Erratum("after (4.2.11)", "g lost beside M2", "M2 g lambda^2 sin q cos q / A"),
    Erratum("(4.2.12)", "terms of the order lambda left out; J0 missing from H1", "the reduced inertia holds J0, and odd orders of lambda"),
    Erratum("after (4.2.13)", "H1 q'' = -H2 q'^2 / H1 + (Q - H3) / H1", "q'' alone on the left"),
    Erratum("(4.2.16)", "r2 in the slide's position, as our text reads", "r1"),
    Erratum("(4.2.25), (4.2.26)", "q2 and omega2 of the auxiliary rod, as our text reads", "q5 and omega5"),
    Erratum("(4.2.31)", "r1 in the counterweight's position", "r2"),
    Erratum("(4.2.23), (4.2.33)", "called accelerations", "they are velocities"),
    Erratum("after (4.2.39), (4.2.41)", "q' by the slope of the inertia", "q'^2"),
    Erratum("(4.2.40), (4.2.41)", "a factor cos q too many", "without it"),
    Erratum("(4.2.43), (4.2.45)", "y''", "y'^2"),
    Erratum("4.3, Runge-Kutta", "position by h/6 (l1 + l2 + l3)", "by h^2/6"),
    Erratum("4.3", "curves of 3 periods called steady", "567 N m without losses have no steady state"),
    Erratum("(5-8), (5-9)", "means of differences with their signs", "they vanish, whatever the masses: rms, as in (5-10) to (5-13)"),
    Erratum("Table 5-2", "11621.795 N", "1162.795 N, from the range printed below it"),
    Erratum("Tables 5-1, 5-2", "ranges of 139.07 N and 2724.88 N for the same masses and speed", "at most one of them is so"),
    Erratum("5.7.3-5.7.5", "load functions of 1250", "1250 kN is 1250000 in newtons"),
    Erratum(
        "5.7.4",
        "window to 0.1738 s in the text, to 0.1838 s with pi / 0.0488 in the load function",
        "one of them; we read 0.1738 s, where a quarter sine over 0.0122 s has pi / 0.0244: see Fig. 5-14",
    ),
    Erratum("5.7.5", "pi / 0.0244", "pi / 0.0384, a half sine"),
    Erratum("5.7.3, 5.7.4", "bottom dead centre at 0.1 s, and at 0.2 s", "once a stroke"),
)
