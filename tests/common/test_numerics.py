"""Roots within brackets, and running sums."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from pinpress.common.numerics import running_sums, sign_change

FUNCTIONS = {
    "polynomial": lambda x: float(np.polyval([1.0, -0.3, -2.0, 0.7], x)),
    "steep at its root": lambda x: math.copysign(abs(x - 0.4) ** (1 / 3), x - 0.4),
    "flat at its root": lambda x: (x - 0.4) ** 5,
    "step": lambda x: 1.0 if x > 0.4 else -1.0,
    "exponential": lambda x: math.exp(8 * x) - 30.0,
}


@pytest.mark.parametrize("width", [1e-3, 1e-9, 4e-16])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_sign_change_is_found_in_few_steps(name, width):
    for low, high in ((-0.5, 1.0), (1.0, -0.5), (0.0, 0.9)):
        places = []
        found = sign_change(lambda x, places=places: places.append(x) or FUNCTIONS[name](x), low, high, width)
        smooth = name in ("polynomial", "exponential")
        assert abs(found - (brentq(FUNCTIONS[name], low, high, xtol=1e-15) if smooth else 0.4)) <= width + 1e-15
        assert len(places) <= 7 + math.log2(abs(high - low) / width)
        if smooth:
            assert len(places) <= 20


def test_sign_change_at_an_end():
    assert sign_change(lambda x: x, 0.0, 1.0, 1e-15) == 0.0
    assert sign_change(lambda x: x - 1.0, 0.0, 1.0, 1e-15) == 1.0


@pytest.mark.parametrize("columns", [1, 63, 64, 300])
def test_running_sums_are_those_of_numpy_bit_by_bit(columns):
    rng = np.random.default_rng(columns)
    start, steps = rng.normal(size=columns), 10.0 ** rng.uniform(-8, 8, (20, columns)) * rng.choice([-1, 1], (20, columns))
    np.testing.assert_array_equal(running_sums(start, steps), np.concatenate([start[None], steps]).cumsum(axis=0))
    np.testing.assert_array_equal(running_sums(0.0, steps)[1:], steps.cumsum(axis=0))
