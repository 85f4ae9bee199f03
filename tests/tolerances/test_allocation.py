"""The cheapest tolerances: closed forms, several targets against another solver, bounds, and what cannot be kept."""

from dataclasses import replace

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.tolerances.dead_centre_scatter import dead_centre_gradients

tol = pp.tolerances
COSTS = {"DE": 3.0, "A x": 0.5}


@pytest.fixture(scope="module")
def press():
    return texts.shipped("zxn2_3000b")


@pytest.fixture(scope="module")
def parts(press):
    """The tolerances of a drawing, one of them uniform and one measured."""
    lengths = {"AB": 5e-5, "BC": 1e-4, "DC": 5e-5, "DE": 5e-5, "EF": 5e-5}
    return [
        *(tol.link_length(press, *pins, T) for pins, T in lengths.items()),
        tol.pin_position(press, "A", "x", 1e-4, shape="uniform"),
        tol.pin_position(press, "A", "z", 1e-4, shape=[-6e-5, -1e-5, 3e-5, 4e-5]),
        tol.pin_angle(press, "C", "D", "E", np.radians(0.01), sd=5e-5),
    ]


def test_one_target_is_the_closed_form(press, parts):
    """t in proportion to the cube root of cost over variance, as wide as the target lets them be."""
    wide = {part.name: (1e-4 * part.tolerance, 1e4 * part.tolerance) for part in parts}
    found = tol.allocate(press, parts, COSTS, {"height": 50e-6}, wide)
    present = np.array([part.tolerance for part in parts])
    sd = np.abs(dead_centre_gradients(press, parts)[0]) * [part.standard_deviation for part in parts]
    costs = np.array([COSTS.get(part.name, 1.0) for part in parts])
    factors = np.cbrt(costs / sd**2)
    factors *= 50e-6 / (3 * np.linalg.norm(sd * factors))
    assert found.tolerances / present == pytest.approx(factors, rel=1e-5)  # the optimum is flat: the cost is much closer
    assert found.value == pytest.approx((costs / factors).sum(), rel=1e-9)
    assert found.gap < 1e-8
    assert found.bound <= found.value
    assert found.prices["height"] == pytest.approx(found.value / 50e-6, rel=1e-6)  # the cost is in proportion to 1 / target
    assert found.cost_alike == pytest.approx(costs.sum() * 3 * np.linalg.norm(sd) / 50e-6)
    assert found.value < 0.7 * found.cost_alike


def test_the_new_tolerances_keep_the_target_in_a_sample(press, parts):
    found = tol.allocate(press, parts, COSTS, {"height": 50e-6, "stroke": 250e-6})
    sample = tol.bottom_dead_centre(press, found.parts, samples=20_000)
    for name, quantity in (("height", sample.height), ("stroke", sample.stroke)):
        assert 3 * quantity.first_order_sd == pytest.approx(found.reached[name], rel=1e-9)
        assert 3 * quantity.sd == pytest.approx(found.reached[name], rel=0.02)
    assert found.parts[6].mean == pytest.approx(0.0)


@pytest.mark.exhaustive
@pytest.mark.filterwarnings("ignore:Values in x were outside bounds:RuntimeWarning")  # of older releases of SciPy's solver
def test_several_targets_are_the_optimum_of_another_solver(press, parts):
    from scipy.optimize import minimize

    targets, bounds = {"height": 50e-6, "top": 250e-6, "stroke": 230e-6}, {"BC": (2e-5, 3e-5), "EF": (4.5e-5, 9e-5)}
    correlation = {("AB", "BC"): 0.6}
    found = tol.allocate(press, parts, COSTS, targets, bounds, correlation=correlation, deviations=2.5)
    present = np.array([part.tolerance for part in parts])
    tied = np.eye(len(parts))
    tied[0, 1] = tied[1, 0] = 0.6
    bottom, top = dead_centre_gradients(press, parts)
    costs = np.array([COSTS.get(part.name, 1.0) for part in parts])
    kept = []
    for slopes, limit in ((bottom, 50e-6), (top, 250e-6), (top - bottom, 230e-6)):
        part = slopes * [each.standard_deviation for each in parts]
        kept.append({"type": "ineq", "fun": lambda u, p=part, end=limit: 1.0 - 2.5**2 * (p * u) @ tied @ (p * u) / end**2})
    ends = np.array([bounds.get(each.name, (0.1 * each.tolerance, 10 * each.tolerance)) for each in parts]) / present[:, None]
    other = minimize(
        lambda u: (costs / u).sum(),
        np.clip(0.5, *ends.T),
        jac=lambda u: -costs / u**2,
        bounds=ends,
        constraints=kept,
        method="SLSQP",
        options={"ftol": 1e-13, "maxiter": 500},
    )
    assert other.success
    assert found.value == pytest.approx(other.fun, rel=1e-6)
    assert found.bound == pytest.approx(found.value, rel=1e-8)
    assert "BC" in str(found)
    assert "largest" in str(found)


def test_a_press_that_is_good_enough_takes_the_largest_tolerances(press, parts):
    found = tol.allocate(press, parts, None, {"height": 0.01})
    assert found.tolerances == pytest.approx(found.bounds[:, 1], rel=1e-6)
    assert found.prices["height"] == pytest.approx(0.0, abs=1e-3)
    assert "not used up" in str(found)


def test_targets_that_cannot_be_kept_say_by_how_much(press, parts):
    exact = [replace(part, shape="normal", sd=None) for part in parts]
    for correlation in (None, {("AB", "BC"): 0.5}):
        with pytest.raises(pp.PinpressError, match="smaller lower bounds"):
            tol.allocate(press, exact, None, {"height": 5e-6, "stroke": 20e-6}, correlation=correlation)
    sd = np.abs(dead_centre_gradients(press, exact)[0]) * [part.standard_deviation for part in exact]
    missed = 0.1 * 3 * np.linalg.norm(sd) - 5e-6
    with pytest.raises(pp.PinpressError, match=rf"height misses its target of 5 um by {1e6 * missed:.4g} um .*; EF adds most"):
        tol.allocate(press, exact, None, {"height": 5e-6})


def test_costs_that_no_solver_can_compare_are_named_as_costs():
    """Costs of 1e9 and 1e-9: solved, or refused in words of tolerances."""
    six_bar = texts.shipped("zxn2_3000b")
    several = [tol.link_length(six_bar, *pair, 50e-6) for pair in ("AB", "DC", "DE", "EF")]
    several.append(tol.link_length(six_bar, "B", "C", 1e-4))
    names = [part.name for part in several]
    said = ""
    for one, other in ((0, 1), (1, 0), (2, 3), (0, 4)):
        try:
            tol.allocate(six_bar, several, {names[one]: 1e9, names[other]: 1e-9}, {"height": 5e-6}, dict.fromkeys(names, (1e-9, 1e-2)))
        except pp.PinpressError as error:
            said += str(error)
    assert "costs differ by a factor of 1e+18" in said
    assert "counterweight" not in said
