"""Small files of robots, in the dialects that programs write: mobility, positions and torques against values of other programs."""

import numpy as np
import pytest
from reference.robots.cases import CASES, Case

import pinpress as pp

WAITING = {}


def _waiting(case: Case) -> list[pytest.MarkDecorator]:
    reason = WAITING.get(case.file[:2]) or WAITING.get(case.id)
    return [pytest.mark.xfail(strict=True, reason=reason)] if reason else []


@pytest.mark.one_in(7)
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize("case", [pytest.param(case, id=case.id, marks=_waiting(case)) for case in CASES])
def test_mobility_positions_and_torques_are_those_of_other_programs(case: Case) -> None:
    if case.path.suffix == ".xml":
        pytest.importorskip("mujoco")
    press = case.press
    assert press.mobility == case.mobility
    assert press.drivers == case.drivers
    at, speed, acceleration = ([values] if len(case.at) > 1 else values for values in (case.at, case.speed, case.acceleration))
    motion = pp.servo_cycle(press, at, speed=speed, acceleration=acceleration)
    positions = [motion.joint_position[0, press.joints.index(joint)] for joint in case.others]
    np.testing.assert_allclose(positions, list(case.others.values()), rtol=1e-9, atol=1e-7 if case.tolerance == 1e-6 else 0)
    torque = np.ravel(pp.inverse_dynamics(press, motion).driving_torque)
    np.testing.assert_allclose(torque, case.torque, rtol=case.tolerance, atol=1e-9 * np.abs(case.torque).max())
