"""Work of the drive and the flywheel's energy, against the steady state under an even torque and the works of the loads."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.common.parameters import parameter
from pinpress.drives import SpeedTorqueDrive

SPEED = 70 * pp.RPM
LOAD = pp.loads.DeepDrawing(1e6, 0.04)


@dataclass(frozen=True)
class Even(SpeedTorqueDrive):
    """A drive whose torque is nearly the same at all speeds."""

    mean: float = field(metadata=parameter("N m"))
    inertia: float = 0.0
    rated_torque: float | None = None

    def torque(self, speed, angle=0.0, time=0.0, state=()):
        return self.mean * (1 - 0.05 * (speed - SPEED) / SPEED)


@pytest.mark.parametrize("speed", [SPEED, -SPEED])
def test_work_is_that_of_loads_and_friction(speed):
    press = texts.shipped("zxn2_3000b")
    friction = {name: pp.loads.Friction(0.05, None if name == "slide_guide" else 0.06) for name in press.bearings}
    damper = pp.loads.SpringDamper("frame", "slide", damping=2e4)
    reactions = pp.inverse_dynamics(press, pp.cycle(press, speed, points=720), [LOAD, damper], friction)
    energy, period = pp.measures.driving_energy(reactions), 2 * np.pi / SPEED
    lost = sum(power.mean() for power in reactions.friction_power.values()) * period
    damped = 2e4 * np.mean(reactions.motion.slide_velocity**2) * period  # the frame's end is beside the guide's axis, but for 3e-5
    assert energy.work == pytest.approx(1e6 * 0.04 * 2 / np.pi + lost + damped, rel=2e-3)
    assert energy.mean_power == pytest.approx(energy.work / period)
    assert energy.mean_torque == pytest.approx(energy.work / (2 * np.pi) * np.sign(speed))
    assert energy.rms_torque == pytest.approx(np.sqrt(np.mean(reactions.driving_torque**2)), rel=5e-4)
    assert energy.largest_torque == pytest.approx(np.abs(reactions.driving_torque).max(), rel=5e-4)
    assert energy.largest_torque >= np.abs(reactions.driving_torque).max()


def test_a_breakthrough_between_states_costs_no_accuracy():
    press, blank = texts.shipped("zxn2_3000b"), pp.loads.Blanking(1e6, 0.006, 0.002)
    few, many = (
        pp.measures.driving_energy(pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=points), [blank])) for points in (90, 2880)
    )
    assert few.work == pytest.approx(1e6 * 0.004 * 2 / np.pi, rel=1e-9)
    assert few.stored == pytest.approx(many.stored, rel=1e-9)


def test_flywheel_under_an_even_torque():
    """The steady state is exact; the drop of speed of first order differs from it by about a drop's share."""
    press, inertia = texts.shipped("zxn2_3000b"), 2e5
    energy = pp.measures.driving_energy(pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=1440), [LOAD]))
    drive, flywheel = Even(energy.mean_torque), pp.drives.Flywheel(inertia)
    run = pp.steady_state(press, SPEED, drive=drive, flywheel=flywheel, loads=[LOAD], points=1441)
    exact = pp.measures.duty_cycle(run)
    assert exact.mean_speed == pytest.approx(SPEED, rel=1e-2)
    assert energy.speed_drop(inertia) == pytest.approx(exact.speed_drop, rel=5e-3)
    assert energy.inertia(energy.speed_drop(inertia)) == pytest.approx(inertia)
    for angle, at in ((energy.lowest_at, run.crank_speed.argmin()), (energy.highest_at, run.crank_speed.argmax())):
        assert np.cos(angle - run.crank_angle[at]) > np.cos(np.radians(2.0))
