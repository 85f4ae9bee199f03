"""Maps of operating points: colours are the values, at their places, in any order of the grid."""

from typing import Any

import numpy as np
import pytest
from support import every_result, texts

import pinpress as pp

pytest.importorskip("matplotlib")


def test_a_map_has_the_values_at_their_places():
    press = texts.shipped("crank_slide")
    speeds, forces = np.array([14.0, 7.0, 10.0]), np.array([0.0, 2e4])
    found = pp.sweeps.operating_points(press, speeds, forces=forces, unit_load=pp.loads.ConstantForce(1.0, 0.02))
    axes = pp.plots.draw(found, "map largest_driving_torque").axes[0]
    mesh: Any = axes.collections[0]
    assert len(axes.collections) == 1
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("force [kN]", "speed [r/min]")
    places = np.asarray(mesh.get_coordinates())
    assert places[:, 0, 1] == pytest.approx(np.sort(speeds) / pp.RPM)
    assert places[0, :, 0] == pytest.approx(1e-3 * forces)
    values = np.asarray(mesh.get_array()).reshape(3, 2)
    assert values == pytest.approx(found.grid("largest_driving_torque")[[1, 2, 0]], rel=1e-12)
    assert len(pp.plots.draw(found, "map").axes) == len(found.results)
    alone = pp.sweeps.operating_points(press, [7.0], forces=forces, unit_load=pp.loads.ConstantForce(1.0, 0.02))
    with pytest.raises(pp.PinpressError, match="has no charts"):
        pp.plots.draw(alone)


def test_orders_stand_next_to_calculated_frequencies():
    orders = next(value for value in every_result.made() if type(value).__name__ == "OrderSpectra")
    modes = next(value for value in every_result.made() if type(value).__name__ == "VibrationModes")
    axes = pp.plots.draw(orders.with_modes(modes), "orders Ax").axes[0]
    highest = orders.order[-1] * orders.speed[-1]
    expected = [w / (2 * np.pi) for w in modes.natural_frequency if w < highest]
    assert expected
    assert [line.get_ydata()[0] for line in axes.lines] == pytest.approx(expected)
    with pytest.raises(pp.PinpressError, match="modes is a int, no VibrationModes"):
        orders.with_modes(3)
