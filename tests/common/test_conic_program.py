"""Convex programs whose optima are known; dense and sparse; what is infeasible, and what is not solved."""

import numpy as np
import pytest
from scipy import sparse

import pinpress as pp
from pinpress.common import conic_program
from pinpress.common.conic_program import AT_MOST, CONE, EQUAL, SEMIDEFINITE, InfeasibleError, Rows, UnsolvedError, minimise


@pytest.mark.parametrize("of", [np.asarray, sparse.coo_matrix, sparse.csr_array])
def test_two_circles_and_a_line(of):
    """The lowest point of two discs on a line: cones of one kind are given in groups."""
    discs = np.array([[0, 0], [-1, 0], [0, -1]] * 2, dtype=float)
    rows = [
        Rows(CONE, of(discs), np.array([2.0, 0.0, 0.0, 2.0, -1.0, 0.0]), size=3),
        Rows(EQUAL, of(np.array([[1.0, -1.0]])), np.array([0.5])),
    ]
    found = minimise(np.array([0.0, 1.0]), rows, remedy="")
    assert found.x[0] - found.x[1] == pytest.approx(0.5, abs=1e-9)
    lengths = np.hypot(found.x[0] - [0, 1], found.x[1])
    assert lengths.max() == pytest.approx(2.0, abs=1e-9)
    assert found.bound == pytest.approx(found.value, abs=1e-9)
    assert found.bound <= found.value + 1e-12


def test_the_nearest_positive_semidefinite_matrix():
    """That of the positive eigenvalues, in the measure of Frobenius."""
    matrix = np.random.default_rng(1).normal(size=(4, 4))
    matrix += matrix.T
    rows, columns = np.tril_indices(4)
    scale = np.where(rows == columns, 1.0, np.sqrt(2.0))
    at = matrix[rows, columns] * scale
    found = minimise(np.zeros(10), [Rows(SEMIDEFINITE, -np.eye(10), at)], squares=1.0, equilibrate=True, remedy="")
    values, vectors = np.linalg.eigh(matrix)
    expected = ((vectors * np.maximum(values, 0)) @ vectors.T)[rows, columns] * scale
    np.testing.assert_allclose(at + found.x, expected, atol=1e-9)
    part = Rows(SEMIDEFINITE, np.eye(10), at)
    np.testing.assert_allclose(part.into_cone(at), expected, atol=1e-12)
    assert part.outside(expected) < 1e-12 < part.outside(at)


@pytest.mark.parametrize("equilibrate", [None, True, False])
def test_what_no_numbers_fulfil_is_proved(equilibrate):
    rows = [Rows(AT_MOST, np.array([[1.0], [-1.0]]), np.array([1.0, -2.0]))]
    with pytest.raises(InfeasibleError):
        minimise(np.ones(1), rows, equilibrate=equilibrate, remedy="")


def test_a_proof_that_holds_for_small_numbers_alone_is_none(monkeypatch):
    rows = [Rows(AT_MOST, np.array([[1.0], [-1.0]]), np.array([1.0, -2.0]))]
    monkeypatch.setattr(conic_program, "REACH", 1e99)
    with pytest.raises(UnsolvedError, match=r"which its dual variables do not prove\); give more room"):
        minimise(np.ones(1), rows, remedy="give more room")


def test_what_is_not_proved_is_said_with_what_to_do():
    """Numbers of very different sizes; the end of the message is the caller's."""
    rows = [Rows(CONE, -np.diag([1.0, 1e9, 1e-9]), np.zeros(3)), Rows(AT_MOST, np.array([[0.0, -1.0, -1e12]]), np.array([-1e3]))]
    with pytest.raises(pp.PinpressError, match=r"^the optimum was not found \(.*\); bring numbers closer together$"):
        minimise(np.array([1.0, 0.0, 0.0]), rows, within=1e-15, remedy="bring numbers closer together")


def test_prices_are_slopes_of_the_cost():
    def optimum(limit):
        return minimise(np.array([-1.0, -2.0]), [Rows(CONE, np.array([[0, 0], [-1.0, 0], [0, -1.0]]), np.array([limit, 0, 0]))], remedy="")

    found = optimum(3.0)
    assert found.value == pytest.approx(-3 * np.sqrt(5), rel=1e-9)
    assert found.prices[0][0] == pytest.approx((optimum(2.99).value - optimum(3.01).value) / 0.02, rel=1e-6)
