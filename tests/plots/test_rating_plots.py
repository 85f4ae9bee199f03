"""What the force-stroke-energy diagram shows."""

import numpy as np
import pytest
from support.texts import shipped

import pinpress as pp
from pinpress.ratings.permissible_force import Capacities
from pinpress.ratings.rating import rate

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def rated():
    capacities = Capacities(3e6, nominal_height=0.013, bearings={"A": 2e6}, flywheel_inertia=4000.0, speed_drop=0.3)
    return rate(shipped("zxn2_3000b"), 70 * pp.RPM, capacities, points=61)


@pytest.fixture(scope="module")
def figure(rated):
    return pp.plots.draw(rated, "force", "near_bottom", "work")


def named(axes):
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    return dict(zip(names, [line for line in axes.get_lines() if line.get_linewidth() > 0.7], strict=True))


def test_the_curves_are_the_limits_and_the_thick_one_is_what_they_permit(rated, figure):
    for axes in figure.axes[:2]:
        drawn = named(axes)
        assert set(drawn) == {"permissible force", *rated.limits}
        for name, force in {"permissible force": rated.force, **rated.limits}.items():
            np.testing.assert_allclose(drawn[name].get_ydata(), force / 1e3, rtol=1e-12)
            np.testing.assert_allclose(drawn[name].get_xdata(), 1e3 * rated.height, rtol=1e-12)
        assert drawn["permissible force"].get_linewidth() > 2 * max(drawn[name].get_linewidth() for name in rated.limits)
    assert figure.axes[0].get_xlim() == (0.0, pytest.approx(1e3 * rated.stroke))


def test_hyperbolas_are_of_one_energy(figure):
    for axes in figure.axes[:2]:
        guides = [line for line in axes.get_lines() if line.get_linewidth() < 0.7]
        assert len(guides) == 4
        for line in guides:
            energy = line.get_xdata() * line.get_ydata()
            np.testing.assert_allclose(energy, energy[0], rtol=1e-12)


def test_work(rated, figure):
    axes = figure.axes[2]
    assert axes.get_xlabel() == "height above bottom dead centre [mm]"
    work, *energies = axes.get_lines()
    factor = {"energy [J]": 1.0, "energy [kJ]": 1e-3}[axes.get_ylabel()]
    np.testing.assert_allclose(work.get_ydata(), factor * rated.work)
    for line, energy in zip(energies, rated.energies.values(), strict=True):
        np.testing.assert_allclose(line.get_ydata(), factor * energy)


@pytest.mark.exhaustive
def test_the_process_is_drawn_beside_what_is_permitted(rated):
    press = shipped("zxn2_3000b")
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 70 * pp.RPM, points=90), [pp.loads.DeepDrawing(1e6, 0.04)])
    figure = pp.plots.draw(rated, "force", page=reactions)
    line = named(figure.axes[0])["process force"]
    np.testing.assert_allclose(line.get_ydata()[:-1], reactions.process_force / 1e3)
    np.testing.assert_allclose(line.get_xdata()[:-1], 1e3 * (reactions.motion.slide_position - pp.dead_centres(press).bottom_position))
    other = pp.inverse_dynamics(shipped("crank_slide"), pp.cycle(shipped("crank_slide"), 7.0, points=12))
    with pytest.raises(pp.PinpressError, match="the reactions belong to crank_slide, but the ratings to zxn2_3000b"):
        pp.plots.draw(rated, page=other)


@pytest.mark.exhaustive
def test_a_press_that_only_its_nominal_force_limits():
    rated = rate(shipped("crank_slide"), 9.0, Capacities(1e5), points=11)
    assert pp.plots.draw(rated, "force").axes[0].get_xlim() == (0.0, pytest.approx(200.0))
