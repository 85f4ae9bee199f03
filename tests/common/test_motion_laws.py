"""Motion laws of VDI 2143 against their closed forms, and as motions that are consistent with themselves."""

from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.exploring import examples

import pinpress as pp
from pinpress.common.motion_laws import VDI_LAWS

SINE, TRAPEZOID = 4 * pi**2 / (4 + pi), 8 * pi / (2 + pi)
COEFFICIENTS = {  # Cv, Ca, heat
    "cubic": (3 / 2, 6, 12),
    "trapezoid": (3 / 2, 9 / 2, 27 / 2),
    "modified sine": (4 * pi / (4 + pi), SINE, SINE**2 / 2),
    "3-4-5": (15 / 8, 10 / sqrt(3), 120 / 7),
    "modified trapezoid": (2, TRAPEZOID, 3 / 4 * TRAPEZOID**2),
    "Bestehorn": (2, 2 * pi, 2 * pi**2),
}
JOINTS = (0, 1 / 8, 1 / 3, 3 / 8, 1 / 2, 5 / 8, 2 / 3, 7 / 8, 1)  # where pieces of any law meet
NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)


@pytest.mark.parametrize("name", VDI_LAWS)
def test_coefficients_are_those_of_the_closed_forms(name):
    law = pp.servo.vdi_law(name)
    assert (law.peak_speed, law.peak_acceleration, law.heat) == pytest.approx(COEFFICIENTS[name], rel=1e-13)
    time = np.linspace(0, 1, 2001)
    assert np.abs(law.speed(time)).max() == pytest.approx(law.peak_speed, rel=1e-12)
    assert np.abs(law.acceleration(time)).max() == pytest.approx(law.peak_acceleration, rel=1e-6)


@given(name=st.sampled_from(VDI_LAWS), ends=st.tuples(st.floats(0, 1), st.floats(0, 1)))
@examples(40)
def test_speed_and_position_are_integrals(name, ends):
    law, (first, last) = pp.servo.vdi_law(name), sorted(ends)
    cuts = np.array([first, *(cut for cut in JOINTS if first < cut < last), last])
    middle, half = 0.5 * (cuts[1:] + cuts[:-1])[:, None], 0.5 * np.diff(cuts)[:, None]
    for rate, whole in ((law.speed, law.position), (law.acceleration, law.speed)):
        gained = float(np.sum(half * WEIGHTS * rate(np.clip(middle + half * NODES, 0, 1))))
        assert whole(last) - whole(first) == pytest.approx(gained, abs=1e-13)


@pytest.mark.parametrize("name", VDI_LAWS)
def test_a_law_goes_from_rest_to_rest_and_is_symmetric(name):
    law, time = pp.servo.vdi_law(name), np.linspace(0, 1, 97)
    assert law.position([0, 1]).tolist() == [0, 1]
    assert law.speed([0, 1]).tolist() == [0, 0]
    assert law.position(time) + law.position(1 - time) == pytest.approx(np.ones(97), abs=1e-15)
    assert np.all(np.diff(law.position(time)) > 0)
