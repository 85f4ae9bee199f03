"""Curves between two criteria: their ends, their shape, and their picture."""

import dataclasses

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.balancing import (
    AddedMass,
    Counterweight,
    CounterweightRegion,
    OperatingCondition,
    Range,
    balance,
    trade_off,
    with_counterweights,
)

X, Z, MASS = Range("shaking_force", "x"), Range("shaking_force", "z"), AddedMass()
REGIONS = [CounterweightRegion("crank", radius=0.3), CounterweightRegion("rocker", radius=0.6), CounterweightRegion("rod", radius=0.3)]
PRESS = texts.shipped("zxn2_3000b")
MOTION = pp.cycle(PRESS, speed=70 * pp.RPM, points=90)


@pytest.fixture(scope="module")
def forces():
    return trade_off(PRESS, MOTION, regions=REGIONS, first=X, second=Z, limits={MASS: 661.0}, points=7)


@pytest.fixture(scope="module")
def weight():
    return trade_off(PRESS, MOTION, regions=REGIONS, first=X, second=MASS, points=5)


def test_ends_are_the_best_of_either_criterion(forces):
    before = np.array([criterion.value(pp.inverse_dynamics(PRESS, MOTION, bearings=())) for criterion in (X, Z)])
    for end, criterion, k in ((0, X, 0), (-1, Z, 1)):
        best = balance(PRESS, MOTION, regions=REGIONS, minimise=criterion, limits={MASS: 661.0})
        assert forces.values[end, k] == pytest.approx(best.value, abs=3e-7 * before[k])  # 1e-7 is given for the other, 1e-6 a moving mass


def test_no_design_is_better_in_both_and_the_curve_is_convex(forces, weight):
    """The criteria are convex, so that between two designs a mixture of both is at least as good."""
    for curve in (forces, weight):
        first, second = curve.values.T
        assert np.all(np.diff(first) > 0)
        assert np.all(np.diff(second) < 0)
        slopes = np.diff(first) / np.diff(second)
        assert np.all(np.diff(slopes) <= 1e-6 * np.abs(slopes).max())


def test_designs_are_presses_with_those_values(forces, weight):
    for curve, design, value in ((forces, forces.designs[3], forces.values[3]), (weight, weight.designs[1], weight.values[1])):
        shaking = pp.inverse_dynamics(design.press, MOTION, bearings=())
        assert X.value(shaking) == pytest.approx(value[0], rel=1e-9)
        assert (design.added_mass if curve is weight else Z.value(shaking)) == pytest.approx(value[1], rel=1e-9)


def test_the_lightest_end_is_the_press_as_it_is(weight):
    assert weight.values[-1, 1] == 0.0
    assert weight.designs[-1].counterweights == ()


def test_limits_hold_along_the_curve():
    torque = Range("driving_torque")
    limit = 1.0 * torque.value(pp.inverse_dynamics(PRESS, MOTION, bearings=()))
    curve = trade_off(PRESS, MOTION, regions=REGIONS[:2], first=Z, second=MASS, limits={torque: limit, MASS: 300.0}, points=3)
    for design in curve.designs:
        change = next(change for change in design.changes if change.criterion == torque)
        assert change.after <= limit * (1 + 1e-9)


def dies(points=36):
    """The press with two dies, and a motion with each at its own speed."""
    found = []
    for mass, speed in ((0.0, 300.0), (300.0, 250.0)):
        weight = [Counterweight("slide", mass, (0.0, 0.0, -0.4))] if mass else []
        each = with_counterweights(texts.shipped("jf75g_125_plain"), weight) if mass else texts.shipped("jf75g_125_plain")
        found.append(OperatingCondition(pp.cycle(each, speed * pp.RPM, points=points), press=each, name=f"{mass:g} kg"))
    return found


@pytest.mark.parametrize("reset", ["", "mass"])
def test_several_conditions_against_all_masses_on_a_grid(reset):
    """One mass opposite to the crank pin, the same for both dies or set anew: none on a grid beats the curve or its bound."""
    press, cases = texts.shipped("jf75g_125_plain"), dies()
    region = CounterweightRegion("crank", at=(-0.12, 0.0, 0.02), mass=(0, 400), reset=reset)
    curve = trade_off(press, cases, regions=[region], first=Z, second=X, points=4)
    at = np.linspace(0.0, 400.0, 2001)
    grid = np.zeros((2, 2, len(at)))
    for number, case in enumerate(cases):
        weights = [[Counterweight("crank", mass, (-0.12, 0.0, 0.02))] for mass in (100.0, 200.0)]
        presses = [with_counterweights(case.press, each) for each in weights]
        one, two = (pp.inverse_dynamics(each, case.motion, bearings=()).shaking_force for each in presses)
        for k, axis in enumerate((2, 0)):
            grid[number, k] = np.ptp(one[:, axis] + np.outer(at - 100.0, (two - one)[:, axis]) / 100.0, axis=1)
    assert [len(design.conditions) for design in curve.designs] == [2] * 4
    for (first, second), bound in zip(curve.values, curve.bounds, strict=True):
        allowed = grid[:, 1] <= second * (1 + 1e-12)
        if reset:  # each die has its own mass
            best = max(np.where(allowed[number], grid[number, 0], np.inf).min() for number in range(2))
        else:
            best = np.where(allowed.all(axis=0), grid[:, 0].max(axis=0), np.inf).min()
        assert bound <= first * (1 + 1e-9)
        assert first - bound <= 1e-5 * first
        assert bound <= best * (1 + 1e-9)
        step = np.abs(np.diff(grid[:, 0], axis=1)).max()
        assert first <= best + step


def test_one_condition_is_the_motion():
    region = CounterweightRegion("crank", radius=0.3)
    one = OperatingCondition(MOTION)
    found = [trade_off(PRESS, of, regions=[region], first=X, second=MASS, points=3) for of in (MOTION, [one])]
    np.testing.assert_array_equal(found[0].values, found[1].values)
    np.testing.assert_array_equal(found[0].bounds, found[1].bounds)
    assert found[0].bounds[-1] == found[0].values[-1, 0]
    with pytest.raises(pp.PinpressError, match="loads needs one motion"):
        trade_off(PRESS, [one], regions=[region], first=X, second=MASS, loads=[pp.loads.Idle()])


def test_bounds_lie_below_the_values_and_next_to_them(forces, weight):
    for curve in (forces, weight):
        before = curve.designs[1].changes[0].before
        gap = curve.values[:, 0] - curve.bounds
        assert gap.min() >= -1e-9 * before
        assert gap.max() <= 3e-6 * before


@pytest.mark.exhaustive
def test_curves_of_the_same_criteria_are_drawn_over_each_other(forces, weight):
    (shared,) = pp.plots.draw({"661 kg": forces, "half": dataclasses.replace(forces, values=0.5 * forces.values)}, "trade_off").axes
    assert len(shared.lines) == 3  # and the press before balancing
    assert [text.get_text() for text in shared.get_legend().get_texts()] == ["661 kg", "half", "before balancing"]
    assert shared.get_xlabel() == "range of the shaking force, z [kN]"
    (alone,) = pp.plots.draw(weight, "trade_off").axes
    assert alone.get_xlabel() == "added mass [kg]"
    curve, before = alone.lines
    factor = {"N": 1.0, "kN": 1e-3}[alone.get_ylabel().partition("[")[2].strip("]")]
    np.testing.assert_allclose(curve.get_xdata(), weight.values[:, 1])
    np.testing.assert_allclose(curve.get_ydata(), factor * weight.values[:, 0])
    assert before.get_ydata()[0] == pytest.approx(factor * weight.designs[0].changes[0].before)
    with pytest.raises(pp.PinpressError, match="light has its chart trade_off over another quantity: draw it alone"):
        pp.plots.draw({"661 kg": forces, "light": weight}, "trade_off")
