"""Damping ratios of modes that swing or creep, against what each mode alone has, and the characteristic polynomial."""

import numpy as np
import pytest

from pinpress.common.numerics import damped_modes


@pytest.mark.one_in(5)
@pytest.mark.parametrize("seed", range(20))
def test_modes_that_are_damped_by_themselves_keep_their_ratios(seed):
    """Several creep; the slow rate of one and the fast one of another are no pair, though their order by size may say so."""
    rng = np.random.default_rng(seed)
    frequency, ratio = np.sort(10.0 ** rng.uniform(-1, 2, 6)), 10.0 ** rng.uniform(-2, 1.5, 6)
    found = damped_modes(frequency, np.diag(2 * ratio * frequency))
    np.testing.assert_allclose(found.ratio, ratio, rtol=1e-7)
    swings = np.where(ratio < 1, frequency * np.sqrt(np.abs(1 - ratio**2)), 0.0)
    np.testing.assert_allclose(found.frequency, swings, rtol=1e-7)


@pytest.mark.one_in(5)
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
