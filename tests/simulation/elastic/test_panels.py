"""Collocation on panels: inertia that depends on the state, against the same motion in other coordinates."""

import numpy as np
import pytest

from pinpress.common.numerics import radau_rule
from pinpress.simulation.elastic import panels

MASS, SPRING, LENGTH, GRAVITY = 2.0, 300.0, 0.5, 9.81


class CartesianPendulum:
    """A mass on a spring from the origin, by its place (x, z)."""

    def linearised(self, time, y, v, a, segments):
        r = np.linalg.norm(y, axis=1)[:, None]
        along = y / r
        outer = along[:, :, None] * along[:, None, :]
        stretch = (r - LENGTH) / r
        stiffness = SPRING * (outer + stretch[..., None] * (np.eye(2) - outer))
        force = -SPRING * stretch * y - (0, MASS * GRAVITY)
        return panels.Linearised(force - MASS * a, stiffness, np.zeros_like(stiffness), MASS * np.eye(2), np.zeros_like(y))


class PolarPendulum:
    """The same by its distance r and its angle p from the vertical: m r'' - m r p'^2 = .., m r^2 p'' + 2 m r r' p' = .."""

    def linearised(self, time, y, v, a, segments):
        (r, p), (dr, dp), (ddr, ddp) = y.T, v.T, a.T
        weight, zero = MASS * GRAVITY, np.zeros_like(r)
        inertia = MASS * np.stack([ddr - r * dp**2, r**2 * ddp + 2 * r * dr * dp], axis=1)
        force = np.stack([-SPRING * (r - LENGTH) + weight * np.cos(p), -weight * r * np.sin(p)], axis=1)
        of_force = np.array([[SPRING + zero, weight * np.sin(p)], [weight * np.sin(p), weight * r * np.cos(p)]])
        place = of_force + MASS * np.array([[-(dp**2), zero], [2 * r * ddp + 2 * dr * dp, zero]])
        rate = MASS * np.array([[zero, -2 * r * dp], [2 * r * dp, 2 * r * dr]])
        mass = MASS * np.array([[1 + zero, zero], [zero, r**2]])
        place, rate, mass = (np.moveaxis(each, 2, 0) for each in (place, rate, mass))
        return panels.Linearised(force - inertia, place, rate, mass, np.zeros_like(y))


def followed(equations, state, until, count):
    shares = np.arange(count + 1) / count
    mesh, rule = panels.Mesh(np.array([0.0, until]), np.zeros(count, dtype=int), shares[:-1], shares[1:]), radau_rule(5)
    guess = panels.PanelSolution(mesh, rule, np.tile(state, (count + 1, 1)), np.zeros((count, 5, 2)), np.inf, 0, np.eye(4))
    return panels.solve(equations, guess, panels.Ends(False, np.zeros(4), []), 1e-13, 30)


def test_inertia_that_depends_on_the_state():
    r, p, dr, dp = 0.55, 0.9, 0.2, 1.5
    start = np.array([r * np.sin(p), -r * np.cos(p), dr * np.sin(p) + r * dp * np.cos(p), -dr * np.cos(p) + r * dp * np.sin(p)])
    cartesian, polar = followed(CartesianPendulum(), start, 0.6, 12), followed(PolarPendulum(), np.array([r, p, dr, dp]), 0.6, 12)
    r, p = polar.states[:, :2].T
    np.testing.assert_allclose(np.stack([r * np.sin(p), -r * np.cos(p)], axis=1), cartesian.states[:, :2], rtol=0, atol=1e-9)
    assert polar.steps < 12  # Newton's method with all derivatives converges at once


def test_derivatives_of_a_window_by_its_start():
    """With inertia that depends on the state, too."""
    start, step = np.array([0.55, 0.9, 0.2, 1.5]), 1e-6
    found = followed(PolarPendulum(), start, 0.3, 6)
    ends = [[followed(PolarPendulum(), start + s * step * np.eye(4)[k], 0.3, 6).states[-1] for s in (1, -1)] for k in range(4)]
    by_start = np.array([(one - two) / (2 * step) for one, two in ends]).T
    assert found.passage == pytest.approx(by_start, rel=1e-6, abs=1e-6)
