"""The table of reduced inertia and potential energy: where one of its rows passes a level, against a fine grid of what it tabulates."""

from dataclasses import replace

import numpy as np
import pytest
from support.generators import large_linkages, spatial_linkages
from support.texts import load, shipped

from pinpress.simulation import reduced_model
from pinpress.simulation.reduced_model import (
    POTENTIAL,
    build_reduced_model,
    joined,
    reduced_model_of,
    reduced_model_to,
    resolution_for,
    roots,
    sample_rows,
)

GRID = np.linspace(0.0, 2 * np.pi, 40_001)


def passages(values, level):
    """Angles between two of the grid at which ``values`` pass a level, to first order."""
    above = values - level
    at = np.flatnonzero(np.signbit(above[1:]) != np.signbit(above[:-1]))
    return GRID[at] + (GRID[1] - GRID[0]) * above[at] / (above[at] - above[at + 1])


@pytest.mark.parametrize("name", ["zxn2_3000b", "jf75g_125", "thin_wall"])
@pytest.mark.parametrize("share", [0.02, 0.5, 0.71, 0.98])
def test_passages_of_a_level(name, share):
    """None is missed, and none is found where there is none."""
    table = reduced_model_of(shipped(name))
    energy = table.at(GRID)[0][POTENTIAL]
    level = energy.min() + share * np.ptp(energy)
    np.testing.assert_allclose(np.sort(roots(table, POTENTIAL, level)), passages(energy, level), rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", ["zxn2_3000b", "jf75g_125", "thin_wall"])
def test_turning_points(name):
    """The energy turns where its slope passes zero: where the grid has its peaks and troughs."""
    table = reduced_model_of(shipped(name))
    energy = table.at(GRID[:-1])[0][POTENTIAL]
    step = np.diff(np.append(energy, energy[0]))
    turns = GRID[:-1][np.signbit(step) != np.signbit(np.roll(step, 1))]
    found = np.sort(roots(table, POTENTIAL, 0.0, slope=True))
    assert len(found) == len(turns) >= 2
    assert np.abs(np.exp(1j * found) - np.exp(1j * turns)).max() < 2 * GRID[1]


def test_weights_that_balance_but_for_rounding_are_not_resolved():
    """Of 26 equal shafts on one height half turn against the others: where they are is no energy, and its rounding no function."""
    table = reduced_model_of(large_linkages.load(large_linkages.gear_train(25)))
    assert table.evaluations < 1000
    assert np.abs(table.at(GRID)[0][POTENTIAL]).max() < 1e-12


@pytest.mark.parametrize(("name", "calls"), [("thin_wall", 1), ("four-bar", 1), ("bricard", 2)])
def test_the_branch_tells_which_panels_resolve_the_inertia(name, calls, monkeypatch):
    """So that all are sampled at once, but beside a lock, where panels are halved more than twenty times."""
    of_space = {"four-bar": lambda: spatial_linkages.four_bar("fixed"), "bricard": spatial_linkages.bricard}
    press = load(of_space[name]()) if name in of_space else replace(shipped(name))
    asked = []
    monkeypatch.setattr(reduced_model, "sample_rows", lambda *given: asked.append(len(given[1])) or sample_rows(*given))
    found = build_reduced_model(press, ())
    assert len(asked) <= calls
    angles = np.random.default_rng(0).uniform(0.99 * found.borders[0], 0.99 * found.borders[-1], 200)
    rows, sampled = found.at(angles)[0], sample_rows(press, angles, ())
    for each in (rows, sampled):
        each[POTENTIAL] -= each[POTENTIAL, 0]  # its zero is arbitrary
    np.testing.assert_allclose(rows, sampled, rtol=1e-10, atol=1e-11 * np.abs(found.middles).max())


@pytest.mark.parametrize("resolution", [1e-10, 1e-7, 1e-5])
@pytest.mark.parametrize("name", ["zxn2_3000b", "jf75g_125", "thin_wall"])
def test_joined_panels_miss_no_more_than_they_may(name, resolution):
    """Between the nodes at which they are compared too, and they are fewer."""
    fine = reduced_model_of(shipped(name))
    coarse = joined(fine, resolution)
    values, others = fine.at(GRID)[0], coarse.at(GRID)[0]
    assert (np.abs(values - others).max(axis=1) <= 5 * resolution * np.abs(values).max(axis=1)).all()
    assert len(coarse.borders) <= len(fine.borders)
    assert len(coarse.borders) < 0.6 * len(fine.borders) or resolution < 1e-7
    assert (coarse.period, coarse.potential_range, coarse.lightest) == (fine.period, fine.potential_range, fine.lightest)


def test_a_press_keeps_one_model_for_each_power_of_ten():
    press = shipped("crank_slide")
    assert reduced_model_to(press, 1e-11) is reduced_model_to(press, 1e-9) is reduced_model_of(press)
    assert reduced_model_to(press, 1e-5) is reduced_model_to(press, 4e-5) is not reduced_model_to(press, 1e-6)
    assert [resolution_for(tolerance) for tolerance in (1e-13, 1e-6, 2e-6, 1e-2)] == pytest.approx([1e-11, 1e-8, 1e-8, 1e-5])
