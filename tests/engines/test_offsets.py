"""Gear pairs with an offset: the follower is drawn where the offset puts it, and every result is that of a shaft mounted so."""

import numpy as np
from support.generators import large_linkages
from support.generators.malformed_linkages import GEAR, changed

import pinpress as pp

OFFSET = 0.5


def train(mimic, mounted=0.0):
    """Two shafts in a row, with eccentric wheels; the second's mounted turned by an angle."""
    text = large_linkages.gear_train(2).replace('<mimic joint="shaft_0" multiplier="-1"/>', mimic)
    return large_linkages.load(text.replace('<origin xyz="1 0 0"/>', f'<origin xyz="1 0 0" rpy="0 {-mounted!r} 0"/>'))


def test_offset_is_a_shaft_mounted_turned(engine):
    angles = np.linspace(-4.0, 9.0, 11)
    presses = (
        train(f'<mimic joint="shaft_0" multiplier="-1" offset="{OFFSET!r}"/>'),
        train('<mimic joint="shaft_0" multiplier="-1"/>', mounted=OFFSET),
    )
    motions = [pp.servo_cycle(press, angle=angles, speed=5.0, engine=engine) for press in presses]
    # the third shaft mimics the second, offset and all: as a mounted one it would not
    np.testing.assert_allclose(motions[0].joint_position[:, 1], OFFSET - angles, atol=1e-12)
    np.testing.assert_allclose(motions[0].joint_position[:, 2], angles - OFFSET, atol=1e-12)
    offset, mounted = (pp.inverse_dynamics(press, motion, engine=engine) for press, motion in zip(presses, motions, strict=True))
    for name in ("shaft_0", "shaft_1"):
        np.testing.assert_allclose(offset.bearing_force[name], mounted.bearing_force[name], atol=1e-11)
    weight = 9.81 * 0.1
    needed = weight * (np.cos(angles) - (np.cos(angles - OFFSET) - np.cos(angles - OFFSET)))
    np.testing.assert_allclose(offset.driving_torque, needed, atol=1e-11)
    assert np.abs(mounted.driving_torque - needed).max() > 0.1


def test_a_driver_that_follows():
    """The driven shaft is itself the follower: its leader is drawn where that puts it."""
    text = large_linkages.gear_train(1).replace('multiplier="-1"/>', f'multiplier="-2" offset="{OFFSET!r}"/>')
    press = large_linkages.load(text, driver="shaft_1")
    motion = pp.servo_cycle(press, angle=[0.0, 1.0], speed=5.0)
    np.testing.assert_allclose(motion.joint_position[:, press.joints.index("shaft_0")], (np.array([0.0, 1.0]) - OFFSET) / -2, atol=1e-14)


def test_offset_is_no_finding():
    """Beside a loop, and beyond what closing may turn a joint by."""
    press = large_linkages.load(changed((GEAR, GEAR.replace("/>", ' offset="2.5"/>'))))
    assert press.closed[press.joints.index("G")] == 2.5
    assert np.abs(press.closed - press.assembly.start).max() < 1e-12
    run = pp.simulate(press, 0.3, speed=9.0, flywheel=pp.drives.Flywheel(10.0))
    np.testing.assert_allclose(run.joint_position[:, press.joints.index("G")], 2.5 - 2 * run.crank_angle, atol=1e-12)
