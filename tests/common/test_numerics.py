"""Roots within brackets, running sums, and damping ratios of modes that swing or creep, against closed forms."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from pinpress.common.numerics import damped_modes, running_sums, sign_change

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


@pytest.mark.parametrize("seed", range(20))
def test_modes_that_are_damped_by_themselves_keep_their_ratios(seed):
    """Several creep; the slow rate of one and the fast one of another are no pair, though their order by size may say so."""
    rng = np.random.default_rng(seed)
    frequency, ratio = np.sort(10.0 ** rng.uniform(-1, 2, 6)), 10.0 ** rng.uniform(-2, 1.5, 6)
    found = damped_modes(frequency, np.diag(2 * ratio * frequency))
    np.testing.assert_allclose(found.ratio, ratio, rtol=1e-7)
    swings = np.where(ratio < 1, frequency * np.sqrt(np.abs(1 - ratio**2)), 0.0)
    np.testing.assert_allclose(found.frequency, swings, rtol=1e-7)


@pytest.mark.parametrize("seed", range(20))
def test_coupled_modes_keep_sum_and_product_of_their_eigenvalues(seed):
    """The trace and the determinant of the system are those of its modes, whatever dampers join them."""
    rng = np.random.default_rng(seed)
    frequency, factor = np.sort(rng.uniform(1, 50, 4)), rng.normal(size=(4, 4)) * rng.uniform(1, 10)
    found = damped_modes(frequency, factor @ factor.T)
    pairs = np.sort_complex(found.eigenvalues)
    assert pairs.sum().real == pytest.approx(-np.trace(factor @ factor.T), rel=1e-9)
    assert np.prod(pairs).real == pytest.approx(np.prod(frequency**2), rel=1e-6)
    assert (found.ratio > 0).all()


def test_a_rate_that_rounding_hides_leaves_the_ratio_finite():
    """Slow rates of 1e-13 of the fast ones and less, which rounding can turn round."""
    frequency, ratio = np.array([1e-3, 2e-3, 5.0]), np.array([1e9, 3e9, 0.1])
    mixed = np.linalg.qr(np.random.default_rng(1).normal(size=(2, 2)))[0]
    damping = np.diag(2 * ratio * frequency)
    damping[:2, :2] = mixed @ damping[:2, :2] @ mixed.T
    found = damped_modes(frequency, damping)
    assert np.isfinite(found.ratio).all()
    assert (found.ratio[:2] > 1e8).all()
    assert found.ratio[2] == pytest.approx(0.1, rel=1e-6)
