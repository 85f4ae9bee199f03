"""Roots within brackets."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from pinpress.common.numerics import brent_root

FUNCTIONS = {
    "polynomial": lambda x: float(np.polyval([1.0, -0.3, -2.0, 0.7], x)),
    "steep at its root": lambda x: math.copysign(abs(x - 0.4) ** (1 / 3), x - 0.4),
    "step": lambda x: 1.0 if x > 0.4 else -1.0,
    "exponential": lambda x: math.exp(8 * x) - 30.0,
}


@pytest.mark.parametrize("tolerances", [{}, {"xtol": 1e-300, "rtol": 1e-15}, {"xtol": 1e-3}], ids=str)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_brent_takes_the_steps_of_scipy(name, tolerances):
    for low, high in ((-0.5, 1.0), (1.0, -0.5), (0.0, 0.9)):
        ours, theirs = [], []

        def called(places):
            return lambda x: places.append(x) or FUNCTIONS[name](x)

        assert brent_root(called(ours), low, high, **tolerances) == brentq(called(theirs), low, high, **tolerances)
        assert ours == theirs


def test_brent_returns_an_end_that_is_a_root():
    assert brent_root(lambda x: x, 0.0, 1.0) == 0.0
    assert brent_root(lambda x: x - 1.0, 0.0, 1.0) == 1.0


def test_brent_refuses_what_has_no_root():
    with pytest.raises(ValueError, match="one sign at both ends"):
        brent_root(lambda x: x * x + 1.0, -1.0, 1.0)
    with pytest.raises(ValueError, match="no value at"):
        brent_root(lambda x: math.nan, -1.0, 1.0)
    with pytest.raises(ValueError, match="no root was found in 100 steps"):
        brent_root(lambda x: 1.0 if x > 0.0 else -1.0, -1.0, 1e9, xtol=1e-300, rtol=1e-15)
