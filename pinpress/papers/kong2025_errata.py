"""Mistakes in the equations of Kong 2025."""

from .pages import Erratum

ERRATA = (
    Erratum("(3), (5), (8)", "the arm DE at the angle theta3", "it is at theta3 - alpha, alpha = 135 deg"),
    Erratum("(4)", "l_m and l_n with the wrong sign", "l_m + l1 cos(theta1) + l2 cos(theta2) = l31 cos(theta3); with sines and -l_n"),
    Erratum(
        "(10)",
        "the terms of l32 in rows 3 and 4 with the wrong sign; last vector with the first power of omega1",
        "the derivative of (7); its last vector is omega1^2 (-l1 cos(theta1), -l1 sin(theta1), 0, 0)",
    ),
    Erratum("(12)", "moments of F32y and F12x with the wrong sign", "moments about the coupler's centre of mass"),
    Erratum("(13)", "moments of F03y and F43x with the wrong sign", "moments about the rocker's centre of mass"),
    Erratum("(12)-(14)", "a2, a3, a4 called accelerations", "they are angular accelerations"),
    Erratum("(15)", "weight across the slide, inertia along the guide's force", "F45x = F05 across; F45y - G5 = m5 a5 upwards"),
    Erratum("(15), (18)", "inertia and weight of the slide along two axes in (15), along one in (18)", "along one"),
    Erratum(
        "(18)",
        "18 entries for 14 unknowns; no G1",
        "14, if each force and the weight behind it are one entry; G1 belongs to the second: see (18) above",
    ),
    Erratum("Table 2", "unit N; range 38476", "N m; 20325 + 18150 = 38475"),
    Erratum("Conclusion (4)", "all bearing forces fall by the balancing", "the ranges in B, C, D and E rise a little, see Fig. 6"),
    Erratum("1.1, motor", "724.9 to 1450 r/min for 50 to 70 strokes/min", "not by one gear ratio, see Fig. 1"),
)
