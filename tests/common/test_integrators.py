"""Radau IIA by the conditions that define it, and on equations whose solutions are known; the fixed step by its order."""

import numpy as np
import pytest

from pinpress.common.integrators import STAGES, RadauIIA, RungeKutta4, method, rounding, slopes


def test_coefficients_are_radaus():
    """The conditions that define them: Radau's quadrature of order 2 s - 1, collocation of order s, and stiff accuracy."""
    r = method()
    assert r.nodes[-1] == 1.0
    for k in range(1, 2 * STAGES):
        assert r.matrix[-1] @ r.nodes ** (k - 1) == pytest.approx(1 / k, abs=1e-14)
    for k in range(1, STAGES + 1):
        assert r.matrix @ r.nodes ** (k - 1) == pytest.approx(r.nodes**k / k, abs=1e-14)


def test_the_embedded_formula_is_of_the_order_of_the_stages():
    r = method()
    weights = r.matrix[-1] + r.embedded
    assert r.start + weights.sum() == pytest.approx(1.0, abs=1e-13)
    for k in range(2, STAGES + 1):
        assert weights @ r.nodes ** (k - 1) == pytest.approx(1 / k, abs=1e-13)


def stepped(rates, y, until, tolerance, first=None):
    """Integrated to the end: the solver there, and the polynomials of its steps."""
    size = len(y)
    solver = RadauIIA(rates, 0.0, np.array(y), until, np.full(size, tolerance), 3e-14, 0, np.ones(size), first)
    pieces = []
    while solver.status == "running":
        assert solver.step() is None
        pieces.append(solver.dense_output())
    return solver, pieces


def test_it_converges_with_order_thirteen():
    """Of one step of a linear oscillation: halving it makes the error 2^14 times as small."""

    def rates(t, y):
        return np.array([y[1], -y[0]])

    errors = []
    for step in (2.0, 1.0):
        solver, _ = stepped(rates, [1.0, 0.0], step, 1e3, step)
        assert solver.nfev < 40  # one step
        errors.append(np.abs(solver.y - [np.cos(step), -np.sin(step)]).max())
    assert 12.5 < np.log2(errors[0] / errors[1]) - 1 < 14.5


@pytest.mark.parametrize("rate", [1e3, 1e6, 1e9])
def test_it_forgets_disturbances_and_is_right_between_its_nodes(rate):
    """Prothero and Robinson's equation, from beside its solution cos t: steps do not depend on the stiffness."""

    def rates(t, y):
        return np.array([-rate * (y[0] - np.cos(t)) - np.sin(t)])

    solver, pieces = stepped(rates, [0.0], 10.0, 1e-10)
    assert abs(solver.y[0] - np.cos(10.0)) < 1e-10
    assert len(pieces) < 60
    for piece in pieces:
        inside = np.linspace(piece.t_old, piece.t, 9)[1:-1]
        settled = np.exp(-rate * inside) < 1e-12
        assert np.abs(piece(inside)[0] - np.cos(inside))[settled].max(initial=0.0) < 1e-9


@pytest.mark.parametrize("speed", [0.0, 1e-15, 1e-9, 1e-3, 7.0])
def test_slopes_are_clear_of_rounding(speed):
    """Of a spring of 1e11 at unit length and a damper: at rest the rate is rounding alone, which a change by the speed's own size hides."""
    length, stiffness, damping = 1.0 / 3.0, 1e11, 1e6

    def rates(t, y):
        return np.array([y[1], -stiffness * ((y[0] - 1.0 + length) - length) - damping * y[1]])

    y = np.array([1.0, speed])
    f, sizes = rates(0.0, y), np.array([1.0, 7.0])
    found = slopes(rates, 0.0, y, f, sizes, rounding(rates, 0.0, y, f))
    np.testing.assert_allclose(found, [[0.0, 1.0], [-stiffness, -damping]], rtol=1e-3)


@pytest.mark.parametrize("speed", [0.0, 1e-13, 1e-10])
def test_slopes_of_a_law_that_is_sharp_about_zero(speed):
    sharp = 1e-9

    def rates(t, y):
        return np.array([-np.tanh(y[0] / sharp)])

    y = np.array([speed])
    f = rates(0.0, y)
    found = slopes(rates, 0.0, y, f, np.array([7.0]), rounding(rates, 0.0, y, f))
    assert found[0, 0] == pytest.approx(-1.0 / sharp / np.cosh(speed / sharp) ** 2, rel=1e-2)


def test_growth_is_grown():
    """L-stability must not damp what grows: an explosion of e^20 keeps its digits."""
    solver, _ = stepped(lambda t, y: 4.0 * y, [1.0], 5.0, 1e-10)
    assert solver.y[0] == pytest.approx(np.exp(20.0), rel=1e-8)


def test_the_fixed_step_is_of_order_four():
    """Also between its steps."""

    def off(step):
        solver, errors = RungeKutta4(lambda t, y: np.array([y[1], -y[0]]), 0.0, np.array([1.0, 0.0]), 2.0, step), []
        while solver.status == "running":
            assert solver.step() is None
            inside = np.linspace(solver.t_old, solver.t, 5)
            errors.append(np.abs(solver.dense_output()(inside)[0] - np.cos(inside)).max())
        return max(errors)

    assert 3.7 < np.log2(off(0.1) / off(0.05)) < 4.3
