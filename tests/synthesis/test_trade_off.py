"""Trade-offs between two objectives of a synthesis, against curves in closed form."""

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.kinematics.measures import stroke

SPEED, RADIUS = 10.0, 0.12
VARIABLES = {"P.crank.x": (0.05, 0.1, 0.2), "W.rod.x": (0.3, 0.7, 0.9)}


def length(trial):
    return trial.variables["W.rod.x"]


def largest_acceleration(trial):
    return trial.motion.slide_acceleration


def found(first, second, variables=VARIABLES, **others):
    return pp.synthesis.trade_off(texts.shipped("crank_slide"), variables, first=first, second=second, speed=SPEED, points=72, **others)


@pytest.fixture(scope="module")
def curve():
    """A short rod against a low acceleration, with a stroke of 240 mm."""
    limits = {"stroke": (lambda trial: stroke(trial.motion), 2 * RADIUS, 2 * RADIUS)}
    return found(largest_acceleration, length, subject_to=limits, designs=5)


@pytest.mark.exhaustive
def test_of_rod_and_acceleration_in_closed_form(curve):
    """r w^2 (1 + r / l) is the largest acceleration at bottom dead centre: all lengths of the rod are on the curve."""
    acceleration, rod = curve.values.T
    np.testing.assert_allclose(acceleration, RADIUS * SPEED**2 * (1 + RADIUS / rod), rtol=1e-7)
    assert rod[0] == pytest.approx(0.9, rel=2e-4)  # an end may be worse by 1e-4 of the curve
    assert rod[-1] == pytest.approx(0.3, rel=1e-3)
    np.testing.assert_allclose(np.diff(rod), np.diff(rod)[0], rtol=1e-4)
    for design in curve.designs:
        assert design.kkt <= 1e-6
        assert stroke(pp.cycle(design.press, SPEED)) == pytest.approx(2 * RADIUS, rel=1e-6)


def test_none_is_better_in_both(curve):
    first, second = curve.values.T
    assert np.all(np.diff(first) > 0)
    assert np.all(np.diff(second) < 0)


def test_as_a_table(curve):
    columns = curve.columns()
    assert list(columns) == ["first objective", "second objective", "P.crank.x", "W.rod.x"]
    np.testing.assert_array_equal(columns["W.rod.x"], [design.variables["W.rod.x"] for design in curve.designs])
    assert repr(curve).startswith("<DesignTradeOff of crank_slide_synthesised: 5 designs, first objective")


def test_objectives_without_conflict_have_one_design():
    """A long stroke lowers both: no curve."""
    only = found(lambda trial: -stroke(trial.motion), lambda trial: -2 * stroke(trial.motion), {"P.crank.x": (0.05, 0.1, 0.2)})
    assert len(only.designs) == 1
    assert only.values.tolist() == [[pytest.approx(-0.4), pytest.approx(-0.8)]]


@pytest.mark.exhaustive
def test_an_end_that_leaves_a_variable_free_is_the_best_in_the_other_objective():
    """The stroke knows no rod; the acceleration wants it long. So the end with the least stroke has the longest rod."""
    designs = found(lambda trial: -stroke(trial.motion), largest_acceleration, designs=3).designs
    for design in designs:
        assert design.variables["W.rod.x"] == pytest.approx(0.9, rel=1e-6)


def test_names_of_objectives_are_taken():
    with pytest.raises(pp.PinpressError, match="'second objective' is the name of an objective"):
        found(length, largest_acceleration, subject_to={"second objective": (length, None, None)})


@pytest.mark.parametrize("designs", [1, 1001, 2.5])
def test_refuses_numbers_of_designs(designs):
    with pytest.raises(pp.PinpressError, match="designs"):
        found(length, largest_acceleration, designs=designs)
