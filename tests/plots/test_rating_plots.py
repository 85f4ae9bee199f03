"""What the force-stroke-energy diagram shows."""

import sys

import numpy as np
import pytest
from support.texts import shipped

import pinpress as pp
from pinpress.plots.force_stroke import GOVERNING
from pinpress.ratings.permissible_force import Capacities
from pinpress.ratings.rating import rate


@pytest.fixture(scope="module")
def rated():
    capacities = Capacities(3e6, nominal_height=0.013, bearings={"A": 2e6}, flywheel_inertia=4000.0, speed_drop=0.3)
    return rate(shipped("zxn2_3000b"), 70 * pp.RPM, capacities, points=61)


@pytest.fixture(scope="module")
def figure(rated):
    return pp.plots.ratings(rated)


def test_the_curves_are_the_limits_and_the_thick_ones_those_that_govern(rated, figure):
    axes = figure.axes[1]  # the whole stroke
    thick = [line for line in axes.get_lines() if line.get_linewidth() == GOVERNING]
    assert len(thick) == len(rated.limits)
    drawn = np.array([line.get_ydata() for line in thick])
    covered = np.nanmin(drawn, axis=0)  # at every height at least one is drawn
    np.testing.assert_allclose(covered, rated.force / 1e3, rtol=1e-9)
    np.testing.assert_allclose(np.nanmax(drawn, axis=0), rated.force / 1e3, rtol=1e-9)
    for line, name in zip(thick, rated.limits, strict=True):
        assert np.isfinite(line.get_ydata()).any() == (name in rated.limited_by)
        np.testing.assert_array_equal(line.get_xdata(), 1e3 * rated.height)


def test_hyperbolas_are_of_the_energy_they_name(figure):
    axes = figure.axes[0]
    curves = {f"{np.mean(line.get_xdata() * line.get_ydata()) / 1e3:.6g} kJ" for line in axes.get_lines() if line.get_linewidth() == 0.5}
    assert curves == {text.get_text() for text in axes.texts}
    assert len(curves) == 4


def test_names_and_units(rated, figure):
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list(rated.limits)
    assert figure.axes[0].get_ylabel() == "process force [kN]"
    assert figure.axes[3].get_xlabel() == "height above bottom dead centre [mm]"
    np.testing.assert_allclose(figure.axes[3].get_lines()[0].get_ydata(), rated.work / 1e3)


@pytest.mark.exhaustive
def test_the_process_is_drawn_beside_what_is_permitted(rated):
    press = shipped("zxn2_3000b")
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 70 * pp.RPM, points=90), [pp.loads.DeepDrawing(1e6, 0.04)])
    figure = pp.plots.ratings(rated, reactions)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [*rated.limits, "process force"]
    for axes in figure.axes[:2]:
        line = axes.get_lines()[-1]
        np.testing.assert_allclose(line.get_ydata(), reactions.process_force / 1e3)
        np.testing.assert_allclose(line.get_xdata(), 1e3 * (reactions.motion.slide_position - pp.dead_centres(press).bottom_position))
    other = pp.inverse_dynamics(shipped("crank_slide"), pp.cycle(shipped("crank_slide"), 7.0, points=12))
    with pytest.raises(pp.PinpressError, match="the reactions are of crank_slide"):
        pp.plots.ratings(rated, other)


@pytest.mark.exhaustive
def test_a_press_that_only_its_nominal_force_limits():
    rated = rate(shipped("crank_slide"), 9.0, Capacities(1e5), points=11)
    assert pp.plots.ratings(rated).axes[1].get_xlim() == (0.0, pytest.approx(200.0))


def test_errors(rated, monkeypatch):
    with pytest.raises(pp.PinpressError, match="ratings is a dict"):
        pp.plots.ratings({})
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(pp.PinpressError, match="pip install"):
        pp.plots.ratings(rated)
