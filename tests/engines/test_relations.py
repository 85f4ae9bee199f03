"""Relations between joint coordinates beyond gear pairs: of three joints, and with a curve."""

import dataclasses
import pickle

import numpy as np
import pytest
from support.texts import load

import pinpress as pp
from pinpress.engines.constraints import Curve, Relation

BODY = (
    '<inertial><origin xyz="0.02 0 0.01"/><mass value="3"/><inertia ixx="0.01" iyy="0.02" izz="0.015" ixy="0" ixz="0" iyz="0"/></inertial>'
)
TURNING = """<link name="{link}">{body}</link><joint name="{name}" type="continuous"><parent link="frame"/><child link="{link}"/>
  <axis xyz="0 -1 0"/>{mimic}</joint>"""
TEXT = f"""<robot name="cam"><link name="frame"/>
  {TURNING.format(link="cam", name="O", body=BODY, mimic="")}
  {TURNING.format(link="wheel", name="G", body=BODY, mimic='<mimic joint="O" multiplier="2"/>')}
  <link name="slide">{BODY}</link>
  <joint name="guide" type="prismatic"><parent link="frame"/><child link="slide"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1e6" velocity="10"/><mimic joint="O" multiplier="0.1"/></joint>
  <transmission name="drive"><joint name="O"/></transmission></robot>"""
LIFT, SHARE = 0.03, 0.01


def lift(angle):
    """Of the cam, with first and second derivative [m]."""
    return LIFT * (1 - np.cos(angle)), LIFT * np.sin(angle), LIFT * np.cos(angle)


@pytest.fixture(scope="module")
def cam():
    """The slide follows the cam on O, and the wheel G by a rack."""
    press = load(TEXT)
    gear, _ = press.relations
    crank, wheel, guide = (press.joints.index(name) for name in ("O", "G", "guide"))
    return dataclasses.replace(press, relations=(gear, Relation("guide", {guide: 1.0, wheel: -SHARE}, curve=Curve(crank, lift))))


@pytest.mark.parametrize("engine", ["space", "pinocchio"])
def test_a_cam_moves_the_slide(cam, engine):
    """Positions, rates and accelerations are those of the lift; the torque is that of virtual work."""
    assert cam.engines == ("space", "pinocchio")
    angle, speed, acceleration = np.linspace(-3, 3, 7), 5.0, -2.0
    motion = pp.servo_cycle(cam, angle, speed=speed, acceleration=acceleration)
    value, slope, bend = lift(angle)
    guide, wheel = cam.joints.index("guide"), cam.joints.index("G")
    np.testing.assert_allclose(motion.joint_position[:, guide], value + 2 * SHARE * angle, rtol=0, atol=1e-14)
    along = slope + 2 * SHARE
    np.testing.assert_allclose(motion.v[:, guide], along * speed, rtol=0, atol=1e-13)
    np.testing.assert_allclose(motion.a[:, guide], along * acceleration + bend * speed**2, rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion.v[:, wheel], 2 * speed, rtol=1e-14)
    found = pp.inverse_dynamics(cam, motion, engine=engine)
    assert found.power_residual.max() < 1e-13
    slide = 3.0 * (motion.a[:, guide] + 9.81)
    inertia = 0.02 + 3.0 * (0.02**2 + 0.01**2)
    weight = 3.0 * 9.81 * np.stack([0.02 * np.cos(each) - 0.01 * np.sin(each) for each in (angle, 2 * angle)])
    torque = inertia * acceleration * (1 + 4) + weight[0] + 2 * weight[1] + along * slide
    np.testing.assert_allclose(found.driving_torque, torque, rtol=0, atol=1e-11)
    pair = found.coupling_torque["G"][:, 0]
    np.testing.assert_allclose(pair, 2 * inertia * acceleration + weight[1] + SHARE * slide, rtol=0, atol=1e-11)


def test_what_takes_no_curve(cam):
    assert [pair.name for pair in cam.couplings] == ["G"]
    with pytest.raises(
        pp.PinpressError, match="cam has the cam 'guide', which forward dynamics does not take: simulate it with method='auto'"
    ):
        cam.forward_dynamics(np.zeros(3))
    again = pickle.loads(pickle.dumps(cam.relations))
    assert [relation.joints for relation in again] == [relation.joints for relation in cam.relations]
