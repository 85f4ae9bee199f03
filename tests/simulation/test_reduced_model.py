"""The table of reduced inertia and potential energy: where one of its rows passes a level, against a fine grid of what it tabulates."""

from dataclasses import replace

import numpy as np
import pytest
from support.generators import large_linkages, spatial_linkages
from support.texts import load, shipped

from pinpress.simulation.reduced_model import (
    POTENTIAL,
    build_reduced_model,
    reduced_model_of,
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
    np.testing.assert_allclose(np.sort(table.roots(POTENTIAL, level)), passages(energy, level), rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", ["zxn2_3000b", "jf75g_125", "thin_wall"])
def test_turning_points(name):
    """The energy turns where its slope passes zero: where the grid has its peaks and troughs."""
    table = reduced_model_of(shipped(name))
    energy = table.at(GRID[:-1])[0][POTENTIAL]
    step = np.diff(np.append(energy, energy[0]))
    turns = GRID[:-1][np.signbit(step) != np.signbit(np.roll(step, 1))]
    found = np.sort(table.roots(POTENTIAL, slope=True))
    assert len(found) == len(turns) >= 2
    assert np.abs(np.exp(1j * found) - np.exp(1j * turns)).max() < 2 * GRID[1]


def test_weights_that_balance_but_for_rounding_are_not_resolved():
    """Of 26 equal shafts on one height half turn against the others: where they are is no energy, and its rounding no function."""
    table = reduced_model_of(large_linkages.load(large_linkages.gear_train(25)))
    assert table.evaluations < 1000
    assert np.abs(table.at(GRID)[0][POTENTIAL]).max() < 1e-12


@pytest.mark.parametrize("name", ["thin_wall", "four-bar", pytest.param("bricard", marks=pytest.mark.exhaustive)])
def test_the_table_is_what_it_tabulates(name):
    """Between the angles at which it was sampled too, and nearly up to a lock."""
    of_space = {"four-bar": lambda: spatial_linkages.four_bar("fixed"), "bricard": spatial_linkages.bricard}
    press = load(of_space[name]()) if name in of_space else replace(shipped(name))
    found = build_reduced_model(press, ())
    angles = np.random.default_rng(0).uniform(0.99 * found.borders[0], 0.99 * found.borders[-1], 200)
    rows, sampled = found.at(angles)[0], sample_rows(press, angles, ())
    for each in (rows, sampled):
        each[POTENTIAL] -= each[POTENTIAL, 0]  # its zero is arbitrary
    np.testing.assert_allclose(rows, sampled, rtol=1e-10, atol=1e-11 * np.abs(found.middles).max())
