"""Runs of presses with cams: two methods agree, with friction and jumps of the acceleration too; one refuses by name."""

import copy

import numpy as np
import pytest
from support import cams

import pinpress as pp
from pinpress.loads import Friction

DRIVE = pp.drives.ConstantTorque(20.0)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("name", "friction"),
    [
        ("ejector", {}),
        ("feeder", {}),
        ("drawing_press", {}),
        pytest.param("drawing_press", {"holder_guide": Friction(0.1), "P": Friction(0.1, radius=0.03)}, marks=pytest.mark.exhaustive),
    ],
)
def test_methods_agree(name, friction):
    """Over a turn and more, with the energy that the drive gives."""
    press = cams.press(name)
    ends, loads = [], [cams.SPRING] if name == "ejector" else []
    for method in ("reduced", "implicit"):
        run = pp.simulate(
            press, 0.5, speed=12.0, drive=DRIVE, flywheel=pp.drives.Flywheel(2.0), loads=loads, friction=friction, method=method
        )
        ends.append([run.crank_angle[-1], run.crank_speed[-1]])
    np.testing.assert_allclose(*ends, rtol=1e-8)
    found = pp.inverse_dynamics(press, run, loads, friction=friction)
    assert found.power_residual.max() < 1e-12
    left = run.drive_torque - 2.0 * run.crank_acceleration  # accelerations between steps are accurate to the tolerance of the run
    assert found.driving_torque == pytest.approx(left, abs=1e-6 * np.abs(left).max())


@pytest.mark.exhaustive
def test_methods_agree_where_the_acceleration_jumps():
    table = copy.deepcopy(cams.EJECTOR)
    table["cams"]["eject"]["law"] = [[0, 0], {"trapezoid": [90, 40]}, [180, 40], {"cubic": [290, 0]}]
    press = pp.build(**table)
    ends = [pp.simulate(press, 0.5, speed=12.0, drive=DRIVE, method=method).crank_angle[-1] for method in ("reduced", "implicit")]
    assert ends[0] == pytest.approx(ends[1], rel=1e-9)


def test_refused_method():
    with pytest.raises(
        pp.PinpressError, match="ejector has the cam 'eject', which forward dynamics does not take: simulate it with method='auto'"
    ):
        pp.simulate(cams.press("ejector"), 0.1, speed=12.0, drive=DRIVE, method="constraint")
