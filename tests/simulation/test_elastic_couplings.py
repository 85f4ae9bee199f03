"""Presses on springs behind clutch and brake: closed forms of two inertias, the rigid press, energy, and what happens when."""

from typing import Any

import numpy as np
import pytest
from simulation.test_elastic_drives import SPEED, induction, jf75g, pendulum, springs

import pinpress as pp

Clutch, Brake, At, Flywheel = pp.drives.Clutch, pp.drives.Brake, pp.drives.SwitchPoint, pp.drives.Flywheel


def test_a_clutch_joins_two_inertias():
    """Wheel of 50 kg m2 at 12 rad/s a crank of 100 kg m2 at 3 rad/s, 300 N m from 0.1 s on: they slip for 9 / (300 (1/50 + 1/100)) s."""
    clutch = Clutch(300.0, closes=At(time=0.1))
    run: Any = pp.simulate(
        pendulum(0.3), 1.4, speed=3.0, flywheel=Flywheel(50.0, speed=12.0), clutch=clutch, elastic=springs(pendulum(0.3), 1e6), points=141
    )
    assert [time for time, _, _ in run.events] == pytest.approx([0.1, 1.1], abs=3e-5)
    assert run.crank_speed[[5, 60, 140]] == pytest.approx([3.0, 3.0 + 300 / 100 * 0.5, 6.0], rel=1e-4)
    assert run.drive_speed[[5, 60, 140]] == pytest.approx([12.0, 12.0 - 300 / 50 * 0.5, 6.0], rel=1e-4)
    assert run.lost[-1] == pytest.approx(0.5 * 50 * 144 + 0.5 * 100 * 9 - 0.5 * 150 * 36, rel=1e-4)
    assert run.stats.energy_error < 1e-12


def test_a_brake_stops_a_crank_and_holds_it():
    """30 rad/s at 100 kg m2, a brake whose 1500 N m rise in 0.4 s: it is held after (3000 + 300) / 1500 s, and stands."""
    run: Any = pp.simulate(
        pendulum(0.3), 2.5, speed=30.0, brake=Brake(1500.0, closes=At(time=0.0), rise=0.4), elastic=springs(pendulum(0.3), 1e7), points=101
    )
    assert run.events[-1][0] == pytest.approx(2.2, abs=5e-4)
    assert run.lost[-1] == pytest.approx(0.5 * 100 * 900, rel=5e-4)
    assert np.abs(run.crank_speed[run.time > 2.21]).max() == 0.0
    assert run.stats.energy_error < 1e-12


STROKE = {
    "drive": induction(),
    "flywheel": Flywheel(40.0, speed=SPEED),
    "clutch": Clutch(5e3, closes=At(time=0.02), opens=At(angle=3.5), rise=0.02),
    "brake": Brake(4e3, closes=At(angle=3.6), rise=0.01),
}


def test_a_press_starts_and_stops():
    """The clutch takes a standing press along and opens, the brake holds it: as the rigid press does, nearly."""
    rigid = pp.simulate(jf75g(), 0.2, **STROKE, points=101)
    run: Any = pp.simulate(jf75g(), 0.2, **STROKE, elastic=springs(jf75g(), 4e9), points=101)
    assert run.stats.energy_error < 1e-12
    assert len(run.events) == 5  # the clutch closes, holds, opens, the brake closes, holds
    assert not run.crank_speed[-20:].any()
    assert [angle for _, angle, _ in run.events][2:4] == pytest.approx([3.5, 3.6], abs=1e-9)
    assert run.drive_work[-1] == pytest.approx(rigid.drive_work[-1], rel=3e-3)
    np.testing.assert_allclose(run.crank_angle, rigid.crank_angle, atol=5e-3)
    np.testing.assert_allclose(run.drive_speed, rigid.drive_speed, rtol=5e-4)


def test_an_overloaded_clutch_slips_and_holds_again():
    """Blanking asks for more than the clutch can hold: it slips, and holds after the break; when and how much as in the rigid press."""
    given: Any = {
        "speed": SPEED,
        "drive": induction(),
        "flywheel": Flywheel(40.0),
        "clutch": Clutch(4e3),
        "loads": [pp.loads.Blanking(0.6e6, 0.006, 0.003)],
        "angle": 1.0,
        "points": 401,
    }
    rigid = pp.simulate(jf75g(), 0.15, **given)
    run: Any = pp.simulate(jf75g(), 0.15, **given, elastic=springs(jf75g(), 2e10))
    grips = run.events[-1][0]  # begins to cut, slips, breaks through, holds
    slipping = np.abs(rigid.drive_speed - rigid.crank_speed) > 1e-6
    assert rigid.time[slipping][[0, -1]] == pytest.approx([run.events[1][0], grips], abs=1e-3)
    assert np.abs(run.drive_speed - run.crank_speed)[(run.time < run.events[1][0]) | (run.time > grips)].max() < 1e-9
    assert run.stats.energy_error < 1e-11


def test_refused_of_couplings():
    with pytest.raises(pp.PinpressError, match="a shaft that twists has no clutch"):
        pp.simulate(jf75g(), 0.1, **STROKE, elastic=springs(jf75g(), shaft=1e7))
    with pytest.raises(pp.PinpressError, match="Flywheel with its own speed"):
        pp.simulate(jf75g(), 0.1, flywheel=Flywheel(40.0), clutch=Clutch(1e3), elastic=springs(jf75g()))
