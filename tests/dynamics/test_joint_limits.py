"""Limits of the file's joints against a motion: the largest values, where they are, and by how much they are exceeded."""

from pathlib import Path

import numpy as np
import pytest

import pinpress as pp

LEG = Path(__file__).resolve().parents[2] / "docs" / "robots" / "leg.urdf"
LIMITS = {("hip", "torque"): 120.0, ("crank", "torque"): 60.0, ("hip", "speed"): 12.0, ("crank", "speed"): 15.0, ("knee", "speed"): 20.0}
ENDS = {"hip": (-1.2, 1.2), "crank": (-1.2, 1.2), "knee": (-0.9, 1.0)}


@pytest.fixture(scope="module")
def swing():
    """Faster and farther than the crank may, with a gap at the dead point behind the knee's other end."""
    leg, time = pp.load(LEG), np.linspace(0.0, 1.0, 300)
    drivers = np.column_stack([0.4 * np.sin(2 * np.pi * time), 1.3 * np.sin(4 * np.pi * time)])
    return leg, pp.inverse_dynamics(leg, pp.servo_cycle(leg, drivers, time=time, on_singular="nan"))


def test_each_limit_has_its_largest_use(swing):
    leg, reactions = swing
    uses = {(use.joint, use.quantity): use for use in pp.measures.joint_limits(reactions)}
    assert set(uses) == {*LIMITS, *((joint, "position") for joint in ENDS)}
    motion, efforts = reactions.motion, dict(zip(leg.drivers, reactions.driving_torque.T, strict=True))
    for (joint, quantity), limit in LIMITS.items():
        values = motion.v[:, leg.joints.index(joint)] if quantity == "speed" else efforts[joint]
        use, worst = uses[joint, quantity], int(np.nanargmax(np.abs(values)))
        assert (use.limit, use.state, use.time) == (limit, worst, motion.time[worst])
        assert use.value == values[worst]
        assert use.excess == pytest.approx(np.nanmax(np.abs(values)) - limit, rel=1e-12)
    for joint, (low, high) in ENDS.items():
        values, use = motion.joint_position[:, leg.joints.index(joint)], uses[joint, "position"]
        assert use.excess == pytest.approx(max(low - np.nanmin(values), np.nanmax(values) - high), rel=1e-9)
        assert use.value == values[use.state]
        assert use.limit == (low if low - use.value > use.value - high else high)


def test_what_is_exceeded_stands_first(swing):
    _, reactions = swing
    uses = pp.measures.joint_limits(reactions)
    beyond = [(use.joint, use.quantity) for use in uses if use.excess > 0]
    assert {("crank", "position"), ("crank", "speed")} <= set(beyond)
    assert [(use.joint, use.quantity) for use in uses[: len(beyond)]] == beyond
    leg = reactions._press
    apart = pp.servo_cycle(leg, [[0.0, 0.0], [0.1, -0.1]], speed=0.0, acceleration=0.0)
    assert pp.measures.joint_limits(pp.inverse_dynamics(leg, apart))[0].time is None
