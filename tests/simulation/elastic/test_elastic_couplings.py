"""Presses on springs behind clutch and brake, and under drives with states or with torques that jump: closed forms of two inertias, the
rigid press, energy, and what happens when."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from support.presses.presses_on_springs import BLANK, SPEED, induction, jf75g, pendulum, springs

import pinpress as pp

Clutch, Brake, At, Flywheel = pp.drives.Clutch, pp.drives.Brake, pp.drives.SwitchPoint, pp.drives.Flywheel


@pytest.mark.exhaustive
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


@pytest.mark.exhaustive
def test_a_brake_stops_a_crank_and_holds_it():
    """30 rad/s at 100 kg m2, a brake whose 1500 N m rise in 0.4 s: it is held after (3000 + 300) / 1500 s, and stands."""
    run: Any = pp.simulate(
        pendulum(0.3), 2.5, speed=30.0, brake=Brake(1500.0, closes=At(time=0.0), rise=0.4), elastic=springs(pendulum(0.3), 1e7), points=101
    )
    assert run.events[-1][0] == pytest.approx(2.2, abs=5e-4)
    assert run.lost[-1] == pytest.approx(0.5 * 100 * 900, rel=5e-4)
    assert np.abs(run.crank_speed[run.time > 2.21]).max() < 1e-12
    assert run.stats.energy_error < 1e-12


@pytest.mark.exhaustive
@pytest.mark.parametrize("way", [1, -1])
def test_couplings_that_are_closed_from_the_start(way):
    """A brake of 1500 N m stops 100 kg m2 at 30 rad/s after 2 s, both ways; a clutch of 300 N m joins a slower wheel or a faster one."""
    elastic = springs(pendulum(0.3), 1e7)
    run: Any = pp.simulate(pendulum(0.3), 2.2, speed=30.0 * way, brake=Brake(1500.0), elastic=elastic, points=23)
    assert run.crank_speed[10] == pytest.approx(way * (30.0 - 15.0 * run.time[10]), rel=1e-3)
    assert run.events[-1][0] == pytest.approx(2.0, abs=1e-3)
    assert run.lost[-1] == pytest.approx(0.5 * 100 * 900, rel=1e-3)
    assert np.abs(run.crank_speed[-2:]).max() < 1e-12
    wheel = Flywheel(50.0, speed=7.5 + 4.5 * way)
    run = pp.simulate(pendulum(0.3), 1.4, speed=7.5 - 4.5 * way, flywheel=wheel, clutch=Clutch(300.0), elastic=elastic, points=15)
    assert run.events[-1][0] == pytest.approx(9.0 / (300.0 * (1 / 50 + 1 / 100)), abs=1e-3)
    assert run.crank_speed[5] == pytest.approx(7.5 - 4.5 * way + way * 3.0 * run.time[5], rel=1e-3)
    together = (50 * (7.5 + 4.5 * way) + 100 * (7.5 - 4.5 * way)) / 150
    assert (run.crank_speed[-1], run.drive_speed[-1]) == pytest.approx((together, together), rel=1e-4)


STROKE = {
    "drive": induction(),
    "flywheel": Flywheel(40.0, speed=SPEED),
    "clutch": Clutch(5e3, closes=At(time=0.02), opens=At(angle=3.5), rise=0.02),
    "brake": Brake(4e3, closes=At(angle=3.6), rise=0.01),
}


@pytest.mark.exhaustive
def test_a_press_starts_and_stops():
    """The clutch takes a standing press along and opens, the brake holds it: as the rigid press does, nearly."""
    rigid = pp.simulate(jf75g(), 0.2, **STROKE, points=101)
    run: Any = pp.simulate(jf75g(), 0.2, **STROKE, elastic=springs(jf75g(), 4e9), points=101)
    assert run.stats.energy_error < 1e-12
    assert len(run.events) == 5  # the clutch closes, holds, opens, the brake closes, holds
    assert np.abs(run.crank_speed[-20:]).max() < 1e-12
    assert [angle for _, angle, _ in run.events][2:4] == pytest.approx([3.5, 3.6], abs=1e-9)
    assert run.drive_work[-1] == pytest.approx(rigid.drive_work[-1], rel=3e-3)
    np.testing.assert_allclose(run.crank_angle, rigid.crank_angle, atol=5e-3)
    np.testing.assert_allclose(run.drive_speed, rigid.drive_speed, rtol=5e-4)


@pytest.mark.exhaustive
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


def test_couplings_that_an_elastic_press_cannot_have_are_refused():
    with pytest.raises(pp.PinpressError, match="a shaft that twists has no clutch"):
        pp.simulate(jf75g(), 0.1, **STROKE, elastic=springs(jf75g(), shaft=1e7))
    with pytest.raises(pp.PinpressError, match="Flywheel with its own speed"):
        pp.simulate(jf75g(), 0.1, flywheel=Flywheel(40.0), clutch=Clutch(1e3), elastic=springs(jf75g()))


@dataclass(frozen=True)
class Controlled(pp.drives.SpeedTorqueDrive):
    """A motor behind a lag, with a speed control that has an integral part: the mean speed is the one that is set."""

    wanted: float
    inertia = 0.5
    state = (0.0, 0.0)
    timed = True
    rated_torque = None

    def torque(self, speed, angle=0.0, time=0.0, state=()):
        return state[0] + 0.0 * speed

    def rates(self, speed, angle=0.0, time=0.0, state=()):
        error = self.wanted - speed
        return (2000.0 * error + 20000.0 * state[1] - state[0]) / 0.01, error


@pytest.mark.exhaustive
def test_steady_state_of_a_drive_with_states():
    run: Any = pp.steady_state(
        jf75g(), SPEED, drive=Controlled(SPEED), flywheel=Flywheel(40.0), loads=[BLANK], elastic=springs(jf75g()), points=121
    )
    assert run.time[-1] == pytest.approx(2 * np.pi / SPEED, rel=1e-12)  # the integral of the error comes back
    assert run.drive_torque[-1] == pytest.approx(run.drive_torque[0], rel=1e-9)
    assert run.drive_work[-1] == pytest.approx(run.load_work[-1] + run.lost[-1], rel=1e-10)
    assert run.decay_per_stroke < 1


@dataclass(frozen=True)
class Jumping(pp.drives.SpeedTorqueDrive):
    """A torque that is larger above a speed."""

    at: float
    inertia = 0.5
    rated_torque = None

    @property
    def corners(self):
        return (pp.drives.Corner(self.at, jump=True),)

    def torque(self, speed, angle=0.0, time=0.0, state=()):
        return np.where(np.asarray(speed) < self.at, 300.0, 800.0) - 200 * (np.asarray(speed) - self.at)


def servo(speed):
    times = np.linspace(-0.02, 0.1, 7)
    return pp.drives.ServoMotor(times, 1.0 + speed * times, 2e5, 2e3, 1e5, inertia=1.0)


@pytest.mark.one_in(6)
@pytest.mark.parametrize(
    ("drive", "torque"), [(Controlled(SPEED), 50.0), (Jumping(0.995 * SPEED), 20.0), (servo(SPEED), 50.0)], ids=["states", "jump", "servo"]
)
def test_drives_of_all_kinds_as_with_the_rigid_press(drive, torque):
    given: Any = {"speed": 0.99 * SPEED, "angle": 1.0, "drive": drive, "flywheel": Flywheel(40.0), "points": 121}
    rigid = pp.simulate(jf75g(), 0.07, **given)
    run: Any = pp.simulate(jf75g(), 0.07, **given, elastic=springs(jf75g(), 2e10))
    assert run.stats.energy_error < 1e-12
    np.testing.assert_allclose(run.crank_speed, rigid.crank_speed, rtol=3e-3)
    if isinstance(drive, Jumping):
        passed = rigid.crank_angle[np.flatnonzero(np.diff(np.sign(rigid.crank_speed - drive.at)))]
        assert [angle for _, angle, _ in run.events] == pytest.approx(passed, abs=0.02)
    else:
        np.testing.assert_allclose(run.drive_torque, rigid.drive_torque, atol=torque)


@pytest.mark.exhaustive
def test_steady_state_whose_torque_jumps():
    """The speed passes the jump twice in a stroke, as the rigid press's does; what the springs change falls with their stiffness."""

    class Crossed(Jumping):
        def torque(self, speed, angle=0.0, time=0.0, state=()):
            return np.where(np.asarray(speed) < self.at, 150.0, 230.0) - 400 * (np.asarray(speed) - self.at)

    given: Any = {"drive": Crossed(34.0), "flywheel": Flywheel(40.0), "loads": [pp.loads.Blanking(0.6e6, 0.006, 0.003)], "points": 121}
    rigid, beside = pp.steady_state(jf75g(), SPEED, **given), []
    for stiffness in (5e9, 2e10):
        run: Any = pp.steady_state(jf75g(), SPEED, elastic=replace(springs(jf75g(), stiffness), damping_ratio=0.2), **given)
        assert len(run.events) == 4
        assert run.stats.energy_error < 1e-11
        beside.append(np.abs(run.crank_speed - rigid.crank_speed).max())
    assert beside[1] < 0.5 * beside[0]
