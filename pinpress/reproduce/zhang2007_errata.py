"""Mistakes in the equations and tables of Zhang 2007."""

from .pages import Erratum

ERRATA = (
    Erratum("(3.2.2), (3.2.3)", "the factor of cos 2 phi is printed as l", "it is lambda, crank by rod"),
    Erratum("3.3", "m' = (m2 l1 + m1 h1) / r1", "m' = (m_B l1 + m1 h1) / r1, with all that hangs on the crank pin"),
    Erratum("(3.5.1), (3.5.12), (3.5.13)", "P3 on the side of P2", "it is opposite: its terms change sign"),
    Erratum(
        "(3.5.4), (3.5.7)",
        "relative sign of X4 and X2; alpha'' missing",
        "J alpha'' = moments about the mass centre",
    ),
    Erratum("(3.5.20)-(3.5.25)", "theta'' = 0 makes alpha'' = beta'' = 0", "alpha'' is not zero at constant speed, see Fig. 3-7"),
    Erratum("(4.2.1) on", "lambda^2 terms of x' with a plus", "with a minus"),
    Erratum("(4.2.6), (4.2.7)", "cos q, a stray l^2, rho2", "cos^2 q, no l^2, rho2^2"),
    Erratum("dV/dq after (4.2.8)", "m1 r", "m1 rho1"),
    Erratum(
        "(4.2.9), (4.2.10)",
        "F (r sin q + lambda^2 sin q cos q / A): no length in the second term",
        "F r (sin q + lambda sin q cos q / A)",
    ),
    Erratum("(4.2.12)", "terms of the order lambda left out; J0 missing from H1", "the reduced inertia holds J0, and odd orders of lambda"),
    Erratum("(4.2.16)", "r2 in the slide's position", "r1"),
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
    Erratum("5.7.4", "window to 0.1838 s; pi / 0.0488", "to 0.1738 s; a quarter sine over 0.0122 s has pi / 0.0244"),
    Erratum("5.7.5", "pi / 0.0244", "pi / 0.0384, a half sine"),
    Erratum("5.7.3, 5.7.4", "bottom dead centre at 0.1 s, and at 0.2 s", "once a stroke"),
)
