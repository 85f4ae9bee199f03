"""Chen 2002: rows of the page by the paper's equations written here."""

import numpy as np
import pytest
from scipy.optimize import brentq
from validation import chen2002
from validation.lookup import row


@pytest.mark.exhaustive
def test_chen_numbers_by_the_papers_equations():
    """(7) to (17) of the paper written out, over a fine grid of the working stroke."""
    l1, l3, l4, l6, h, speed = 108.0, 648.0, 220.0, 350.0, 630.0, 7.54

    def ram(q):
        s3 = np.sqrt(l6**2 + l1**2 + 2 * l1 * l6 * np.sin(q))
        theta3 = np.arccos(l1 * np.cos(q) / s3)
        theta4 = np.arcsin((h - l3 * np.sin(theta3)) / l4)
        omega3 = l1 * speed * np.cos(q - theta3) / s3
        omega4 = -l3 * omega3 * np.cos(theta3) / (l4 * np.cos(theta4))
        v = l3 * omega3 * np.sin(theta3) + l4 * omega4 * np.sin(theta4)
        return l3 * np.cos(theta3) + l4 * np.cos(theta4), v, theta4

    q = np.radians(np.linspace(-17.973159220540943, 197.97315922054094, 200001))
    x, v, theta4 = ram(q)
    page, within = chen2002, ram(np.radians(np.linspace(60, 120, 60001)))[1]
    mean = (x[0] - x[-1]) * speed / np.ptp(q)
    expected = {
        "stroke [mm]": x[0] - x[-1],
        "time ratio K": np.ptp(q) / (2 * np.pi - np.ptp(q)),
        "largest speed of the working stroke [mm/s]": v.max(),
        "mean speed of the working stroke [mm/s]": mean,
        "f = v_max / v_mean, printed lengths": v.max() / mean,
        "drop of speed within it [%]": 100 * (1 - within.min() / within.max()),
        "largest pressure angle, (18) [deg]": np.degrees(np.abs(theta4).max()),
    }
    for words, value in expected.items():
        assert row(page, words).value == pytest.approx(value, rel=1e-6), words
    # least drop over 120 mm: the speed having but one peak, that stretch which begins as fast as it ends
    assert np.count_nonzero(np.diff(np.sign(np.diff(v)))) == 1
    begin = brentq(lambda q0: ram(q0)[1] - np.interp(-(ram(q0)[0] - 120.0), -x, v), np.radians(30), np.radians(87), xtol=1e-12)
    assert row(page, "least drop of speed over any 120 mm [%]").value == pytest.approx(100 * (1 - ram(begin)[1] / v.max()), rel=1e-6)


def test_chen_constraints_of_crank_and_guide_by_hand():
    """l1 - l6, h - l3 - l4, and s3 between l6 - l1 and l6 + l1, which it reaches at 270 and 90 deg."""
    assert chen2002.constraints() == pytest.approx([108.0 - 350.0, 630.0 - 648.0 - 220.0, 0.0, 350.0 + 108.0], abs=1e-9)


@pytest.mark.exhaustive
def test_chen_objective_is_degenerate():
    """f falls with l4 towards its limit, and does not know l1."""
    page = chen2002
    falling = [row(page, f"f, l4 = {length} mm").value for length in (150, 220, 400, 1000, 3000)]
    assert falling == sorted(falling, reverse=True)
    assert falling[-1] > 1.43997794
    for length in (80, 140):
        assert row(page, f"f, l4 = 220 mm, l1 = {length} mm").value == pytest.approx(falling[1], rel=1e-9)
    assert row(page, "l4 that the search within 150 to 220 mm ends at [mm]").value == pytest.approx(220, rel=1e-6)
