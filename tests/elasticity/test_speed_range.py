"""Campbell diagrams, and strokes over the speed, of presses on springs."""

from functools import cache

import numpy as np
import pytest
from support.texts import shipped

import pinpress as pp
from pinpress.elasticity import Elastic, Stiffness, campbell, over_speeds

SPEEDS = np.array([288.0, 300.0]) * pp.RPM
BLANKING = [pp.loads.Blanking(1.25e6, 0.010, 0.005)]


def elastic(press):
    return Elastic(Stiffness(dict.fromkeys(press.bearings, 2e9), moments={"slide_guide": 2e8}))


@cache
def diagram():
    press = shipped("jf75g_125_plain")
    return campbell(press, elastic(press), speeds=np.linspace(100, 350, 26) * pp.RPM)


def test_resonances_are_where_orders_meet_frequencies():
    found, frequency = diagram(), diagram().modes.natural_frequency
    assert (len(found.resonances), found.turns) == (8, 1)
    for each in found.resonances:
        band = frequency[:, each.mode - 1]
        assert each.order * each.speed == pytest.approx(band.mean(), rel=1e-12)
        assert (each.order * each.slowest, each.order * each.fastest) == pytest.approx((band.min(), band.max()), rel=1e-12)
        np.testing.assert_allclose(np.interp(each.speed, found.speed, found.order_frequency(each.order)), band.mean(), rtol=1e-12)
    orders = {(mode, order) for mode in range(1, 9) for order in range(1, 21)}
    listed = {(each.mode, each.order) for each in found.resonances}
    for mode, order in orders - listed:
        band = frequency[:, mode - 1] / order
        assert band.max() < found.speed[0] or band.min() > found.speed[-1]
    assert "..." not in str(found)
    assert "  8 resonances." in str(found)


@pytest.mark.exhaustive
def test_strokes_over_the_speed_are_steady_states():
    press = shipped("jf75g_125_plain")
    found = over_speeds(press, elastic(press), speeds=SPEEDS, loads=BLANKING)
    for k, speed in enumerate(SPEEDS):
        drive = pp.drives.PrescribedSpeed(speed)
        run = pp.steady_state(press, speed, drive=drive, loads=BLANKING, elastic=elastic(press), points=721)
        assert isinstance(run, pp.ElasticRun)
        for bearing, peak in run.peaks.items():
            assert found.peaks[bearing][k] == pytest.approx(peak, rel=1e-5)
        assert found.deepest[k] == pytest.approx(run.deepest, abs=1e-8)
        assert found.reverse_force[k] == pytest.approx(run.reverse_force, rel=1e-5)
        assert found.lost[k] == pytest.approx(run.lost[-1], rel=1e-4)
        beside = run.shaking_force[:-1] - run.shaking_force[:-1].mean(axis=0)
        assert found.frame_force[k] == pytest.approx(np.linalg.norm(beside, axis=1).max(), rel=1e-3)
    assert found.depth[1] == pytest.approx(1643.19e-6, abs=1e-8)
    assert str(found).splitlines()[-1].split()[:2] == ["300.00", "1.6432"]  # r/min, mm


def test_a_press_that_does_not_repeat_is_named_by_its_speed(monkeypatch):
    from pinpress.elasticity import speed_range

    def fails(*arguments, **named):
        raise pp.SimulationError("it does not repeat")

    monkeypatch.setattr(speed_range, "steady_state_near", fails)
    press = shipped("jf75g_125_plain")
    with pytest.raises(pp.SimulationError, match="at 300 r/min: it does not repeat"):
        over_speeds(press, elastic(press), speeds=[300 * pp.RPM])
