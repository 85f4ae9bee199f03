"""Forces between the teeth of a rack and its pinion, and between the threads of a screw and its nut: on the bearings, and their friction.

`cut_free` compares racks in whole linkages; here are closed forms: an arbor press, whose pinion pushes a ram, and a spindle that lifts a
nut.
"""

import numpy as np
import pytest
from support.generators import same_linkage
from support.texts import load

import pinpress as pp

ENGINES = ("plane", "space", "pinocchio")
G = 9.81


def arbor(ratio, ram=24):
    """A pinion of 2 kg at the origin and a ram of 8 kg whose pin is drawn at ``ram`` mm; ``ratio`` in m/rad."""
    return pp.build(
        units="mm",
        frame="O",
        pins={"O": [0, 0], "Q": [ram, 0]},
        links={"pinion": {"pins": "O", "mass": 2, "disc": "24 x 40"}, "slide": {"pins": "Q", "guide": "up", "mass": 8}},
        gears={"slide_guide": f"{ratio} * O"},
        drive="O",
    )


@pytest.mark.parametrize(("ratio", "ram"), [(0.024, 24), (0.024, 60), (-0.03, -30)])
def test_an_arbor_press(engine, ratio, ram):
    """The teeth hold push less weight of the ram, at the pitch line; the pinion's bearing holds the teeth and the pinion's weight, the
    guide nothing along the ram, and the moment of a ram whose pin is off the pitch line."""
    press, push = arbor(ratio, ram), 1e4
    motion = pp.servo_cycle(press, angle=np.radians([0.0, -5.0, 7.0]), speed=-1.0, acceleration=[0.0, 3.0, -20.0])
    found = pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slide", (0, 0, push))], engine=engine)
    teeth = 8 * (ratio * np.array([0.0, 3.0, -20.0]) + G) - push  # of the pinion on the ram, upwards
    up, turn = np.array([0, 0, 1.0]), np.array([0, -1.0, 0])
    np.testing.assert_allclose(found.coupling_torque["slide_guide"][:, 0], teeth, rtol=1e-12)
    np.testing.assert_allclose(found.bearing_force["O"], (teeth + 2 * G)[:, None] * up, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.bearing_force["slide_guide"], 0.0, rtol=0, atol=1e-9)
    arm = 1e-3 * ram - ratio  # of the pin beyond the pitch line; the push goes through the pin
    np.testing.assert_allclose(found.bearing_moment["slide_guide"], (teeth * arm)[:, None] * turn, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.bearing_moment["O"], found.driving_torque[:, None] * turn, rtol=0, atol=1e-9)
    assert "coupling_force_slide_guide [N]" in found.columns()
    some = pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slide", (0, 0, push))], engine=engine, bearings=["O"])
    np.testing.assert_allclose(some.bearing_force["O"], found.bearing_force["O"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(some.shaking_moment, found.shaking_moment, rtol=0, atol=1e-9)


def test_friction_of_the_pinions_bearing(engine):
    """mu r times what the bearing carries, the teeth's force among it; the guide, without a force across, rubs nothing."""
    press, friction = arbor(0.03, 30), {"O": pp.loads.Friction(0.08, radius=0.015), "slide_guide": pp.loads.Friction(0.1)}
    motion = pp.servo_cycle(press, angle=np.radians([0.0, -5.0]), speed=-1.0, acceleration=0.0)
    loads = [pp.loads.PointForce("slide", (0, 0, 12e3))]
    smooth, rough = (pp.inverse_dynamics(press, motion, loads, friction=each, engine=engine) for each in ({}, friction))
    carried = 12e3 - 8 * G - 2 * G
    np.testing.assert_allclose(rough.driving_torque - smooth.driving_torque, -0.08 * 0.015 * carried, rtol=1e-11)
    np.testing.assert_allclose(rough.friction_power["O"], 0.08 * 0.015 * carried, rtol=1e-11)
    assert np.abs(rough.power_residual).max() < 1e-13


def test_a_run_loses_the_same_power():
    """Simulated with its bearing's friction: the balance of energy closes, and inverse dynamics of its states has no torque left."""
    press, friction = arbor(0.03, 30), {"O": pp.loads.Friction(0.08, radius=0.015)}
    loads = [pp.loads.PointForce("slide", (0, 0, 500.0))]
    run = pp.simulate(press, 0.05, speed=1.0, loads=loads, friction=friction)
    found = pp.inverse_dynamics(press, run, loads, friction=friction)
    carried = np.linalg.norm(found.bearing_force["O"], axis=1)
    assert np.abs(carried - 2 * G).min() > 5
    np.testing.assert_allclose(found.friction_power["O"], 0.08 * 0.015 * carried * run.crank_speed, rtol=1e-9)
    assert np.abs(found.driving_torque).max() < 1e-7 * 500 * 0.03


SCREW = """<robot name="screw">
  <link name="frame"/>
  <link name="spindle"><inertial><origin xyz="0 0 0.2"/><mass value="5"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.02"/></inertial></link>
  <link name="slide"><inertial><origin xyz="0.1 0 0"/><mass value="40"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="spindle" type="continuous"><parent link="frame"/><child link="spindle"/><origin xyz="0 0 0.5"/><axis xyz="0 0 1"/></joint>
  <joint name="guide" type="prismatic"><parent link="frame"/><child link="slide"/><origin xyz="0.3 0 0.4"/><axis xyz="0 0 1"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/><mimic joint="spindle" multiplier="0.004"/></joint>
  <transmission name="t"><joint name="spindle"/></transmission>
</robot>"""


@pytest.mark.parametrize("engine", ENGINES[1:])
def test_a_screw(engine):
    """The spindle's bearing carries the nut's weight along its axis, the guide nothing along its own; it holds the nut against turning, and
    against tilting by its weight beside the spindle."""
    press = load(SCREW)
    motion = pp.servo_cycle(press, angle=[0.0, 30.3], speed=5.0, acceleration=[0.0, 250.0])
    found = pp.inverse_dynamics(press, motion, engine=engine)
    lifted = 40 * (G + 0.004 * np.array([0.0, 250.0]))
    np.testing.assert_allclose(found.bearing_force["spindle"], np.outer(lifted + 5 * G, [0, 0, 1]), rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.bearing_force["guide"], 0.0, rtol=0, atol=1e-10)
    tilting = -lifted * 0.4  # inertia and weight act 0.1 m beyond the guide, the thread 0.3 m before it
    expected = np.stack([0 * lifted, tilting, -0.004 * lifted], axis=1)
    np.testing.assert_allclose(found.bearing_moment["guide"], expected, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.bearing_moment["spindle"][:, 2], found.driving_torque, rtol=0, atol=1e-12)


def test_teeth_of_a_press_whose_frame_is_turned(engine):
    """The file of a frame that is fixed to a turned link has turned frames of all joints: forces and moments turn with it."""
    press = arbor(0.024, 60)
    same = same_linkage.turned(press, np.random.default_rng(3))
    given = {"angle": np.radians([0.0, -5.0, 7.0]), "speed": -1.0, "acceleration": [0.0, 3.0, -20.0]}
    upright, turned = (pp.inverse_dynamics(each, pp.servo_cycle(each, **given), engine=engine) for each in (press, same.press))
    for name in press.bearings:
        np.testing.assert_allclose(upright.bearing_force[name] @ same.vectors.T, turned.bearing_force[name], rtol=0, atol=1e-10)
        np.testing.assert_allclose(same.moments(upright.bearing_moment[name]), turned.bearing_moment[name], rtol=0, atol=1e-10)
