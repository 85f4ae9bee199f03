"""The guide-bar press for thin-walled parts against a solver and the paper's closed form; `validation.chen2002` has its figures.

Source: Chen Y. and Su S. 2002, Modern Manufacturing Engineering 2002(7), 42-44. `reference/thin_wall.json` was computed from its lengths
(and steel prisms) without pinpress. theta3, theta4: angles of bar and coupler in the picture plane; s3: distance CB.
"""

import json
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from support import texts

import pinpress as pp

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "thin_wall.json").read_text(encoding="utf-8"))
TABLE = REFERENCE["table"]
DRAWN = TABLE[0]  # crank angle 0
SPEED = REFERENCE["speed"]
L1, L3, L4, L6, H = (REFERENCE["geometry"][name] for name in ("l1", "l3", "l4", "l6", "h"))


@pytest.fixture(scope="module")
def press():
    return texts.shipped("thin_wall")


def column(name):
    return np.array([row[name] for row in TABLE])


def at(press, engine, angle):
    """Motion at one or more crank angles [rad], at the paper's speed."""
    return pp.servo_cycle(press, angle=np.atleast_1d(angle), speed=SPEED, engine=engine)


def links(press, motion):
    """Angle or distance, rate and acceleration of bar, coupler and block, named as in the reference."""
    bar, coupler, block = (press.joints.index(name) for name in ("C", "D", "slot"))
    position, v, a = motion.joint_position, motion.v, motion.a
    return {
        "th3": DRAWN["th3"] + position[:, bar],
        "w3": v[:, bar],
        "a3": a[:, bar],
        "th4": DRAWN["th4"] + position[:, bar] + position[:, coupler],
        "w4": v[:, bar] + v[:, coupler],
        "a4": a[:, bar] + a[:, coupler],
        "s3": DRAWN["s3"] + position[:, block],
        "ds3": v[:, block],
        "dds3": a[:, block],
        "x": motion.slide_position,
        "v": motion.slide_velocity,
        "a": motion.slide_acceleration,
    }


def closed_form(angle, speed):
    """Position and speed of the ram by the paper's equations."""
    s3 = np.sqrt(L6**2 + L1**2 + 2 * L1 * L6 * np.sin(angle))
    theta3 = np.arccos(L1 * np.cos(angle) / s3)
    theta4 = np.arcsin((H - L3 * np.sin(theta3)) / L4)
    omega3 = L1 * speed * np.cos(angle - theta3) / s3
    omega4 = -L3 * omega3 * np.cos(theta3) / (L4 * np.cos(theta4))
    return L3 * np.cos(theta3) + L4 * np.cos(theta4), -L3 * omega3 * np.sin(theta3) - L4 * omega4 * np.sin(theta4)


def working_stroke(press):
    """Crank angle at its start and end."""
    ends = pp.dead_centres(press)
    return ends.top_angle - 2 * np.pi, ends.bottom_angle


def in_plane(vectors):
    """(n, 3) world vectors as (x, y) of the picture plane."""
    return vectors[:, [0, 2]]


def test_drawn_pose_is_closed(press):
    """Every loop to 1e-15 m with all joints at zero: rounding of the angles and lengths in the file."""
    data, neutral = press.model.createData(), pin.neutral(press.model)
    pin.forwardKinematics(press.model, data, neutral)
    for loop in press.loops:
        gap = data.oMi[loop.joint2].act(loop.point2) - data.oMi[loop.joint1].act(loop.point1)
        assert np.abs(gap).max() <= 1e-15, loop.name
    np.testing.assert_allclose(press.closed, 0.0, atol=1e-14)


def test_bodies(press):
    """Steel prisms, 1e-15 relative: the digits of the reference. A ram that only slides has no say in its inertia."""
    for name, body in REFERENCE["bodies"].items():
        inertia = press.model.inertias[press.model.frames[press.model.getFrameId(name)].parentJoint]
        np.testing.assert_allclose(inertia.mass, body["mass"], rtol=1e-15)
        middle = {"crank": L1 / 2, "bar": L3 / 2, "coupler": L4 / 2}.get(name, 0.0)
        np.testing.assert_allclose(inertia.lever, [middle, 0, 0], rtol=1e-15)
        if name != "slide":
            np.testing.assert_allclose(inertia.inertia[1, 1], body["inertia"], rtol=1e-15)
    assert (press.driver, press.slide, press.mobility) == ("A", "slide", 1)
    assert set(press.bearings) == {"A", "C", "slot", "D", "slide_guide", "B", "E"}


@pytest.mark.parametrize("name", ["th3", "w3", "a3", "th4", "w4", "a4", "s3", "ds3", "dds3", "x", "v", "a"])
def test_kinematics_equal_the_reference(press, engine, name):
    """At every row, 1e-12 of the peak: both sides close to rounding."""
    values, expected = links(press, at(press, engine, np.radians(column("th1_deg"))))[name], column(name)
    assert np.abs(values - expected).max() <= 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("name", ["A", "B", "C", "D", "E"])
def test_pin_forces_equal_the_reference(press, engine, name):
    """At every row, 1e-13 of the peak; a pin turns freely, so only the drive's torque is a moment."""
    result = pp.inverse_dynamics(press, at(press, engine, np.radians(column("th1_deg"))), engine=engine)
    expected = np.stack([column(f"{name}x"), column(f"{name}y")], axis=1)
    peak = np.abs(expected).max()
    assert np.abs(in_plane(result.bearing_force[name]) - expected).max() <= 1e-13 * peak
    torque = column("T") if name == "A" else np.zeros(len(TABLE))
    moment = np.outer(torque, [0, -1, 0])
    assert np.abs(result.bearing_moment[name] - moment).max() <= 1e-13 * np.abs(column("T")).max()


def test_torque_block_and_guide_equal_the_reference(press, engine):
    """The bar pushes the block squarely, and with the couple that turns it: 1e-13 of the peak, of the force's for what must be zero. The
    guide carries the ram and has no moment about E."""
    result = pp.inverse_dynamics(press, at(press, engine, np.radians(column("th1_deg"))), engine=engine)
    assert np.abs(result.driving_torque - column("T")).max() <= 1e-13 * np.abs(column("T")).max()
    force, theta3, peak = in_plane(result.bearing_force["slot"]), column("th3"), np.abs(column("N")).max()
    across = -np.sin(theta3) * force[:, 0] + np.cos(theta3) * force[:, 1]
    along = np.cos(theta3) * force[:, 0] + np.sin(theta3) * force[:, 1]
    assert np.abs(across - column("N")).max() <= 1e-13 * peak
    assert np.abs(along).max() <= 1e-13 * peak
    couple = result.bearing_moment["slot"] @ [0, -1, 0]
    # 1e-10: a few hundredths of a newton metre are left of moments of hundreds
    assert np.abs(couple - column("M")).max() <= 1e-10 * np.abs(column("M")).max()

    peak = np.abs(column("Ny")).max()
    expected = np.stack([np.zeros(len(TABLE)), column("Ny")], axis=1)
    assert np.abs(in_plane(result.bearing_force["slide_guide"]) - expected).max() <= 1e-13 * peak
    moment = np.outer(column("Mg"), [0, -1, 0])
    assert np.abs(result.bearing_moment["slide_guide"] - moment).max() <= 1e-13 * peak * L4


def test_closed_form_of_the_ram(press, engine):
    """The paper's equations at random angles and speeds, 1e-12 of the peak: rounding."""
    random = np.random.default_rng(2002)
    angle, speed = random.uniform(-20, 20, 200), random.uniform(-10, 10, 200)
    motion = pp.servo_cycle(press, angle=angle, speed=speed, acceleration=0.0, engine=engine)
    position, velocity = closed_form(angle, speed)
    assert np.abs(motion.slide_position - position).max() <= 1e-12 * np.abs(position).max()
    assert np.abs(motion.slide_velocity - velocity).max() <= 1e-12 * np.abs(velocity).max()


def test_stroke_and_dead_centres(press, engine):
    """The paper asks for a stroke of 400 mm and K = 1.5, working time to return time; its rounded lengths give a little less."""
    start, end = working_stroke(press)
    motion = at(press, engine, [start, end])
    stroke = motion.slide_position[0] - motion.slide_position[1]
    assert round(1e3 * stroke, 3) == 399.909
    assert (round(np.degrees(start), 3), round(np.degrees(end), 3)) == (-17.973, 197.973)
    assert round(np.degrees(end - start)) == 216
    assert round((end - start) / (2 * np.pi - (end - start)), 5) == 1.49907
    # In closed form: the crank stands square to the bar at both ends
    swing = 2 * np.arcsin(L1 / L6)
    np.testing.assert_allclose([stroke, pp.dead_centres(press).stroke], 2 * L3 * np.sin(swing / 2), rtol=1e-14)
    np.testing.assert_allclose([start, end], [-swing / 2, np.pi + swing / 2], atol=1e-14)
    assert np.abs(motion.slide_velocity).max() <= 1e-14  # the last digit of the angle moves the ram by that


def test_turn_backwards(press, engine):
    """The same configurations and loads as forwards, rates reversed: 1e-12 of the peak, after a whole turn the other way."""
    forward, backward = (pp.cycle(press, speed, points=90, engine=engine) for speed in (SPEED, -SPEED))
    mirrored = -np.arange(90) % 90
    ahead, back = links(press, forward), links(press, backward)
    for name, values in back.items():
        sign = -1 if name in ("w3", "w4", "ds3", "v") else 1
        assert np.abs(values - sign * ahead[name][mirrored]).max() <= 1e-12 * np.abs(values).max(), name
    results = [pp.inverse_dynamics(press, motion, engine=engine) for motion in (forward, backward)]
    for name in press.bearings:
        there, here = (result.bearing_force[name] for result in results)
        assert np.abs(here - there[mirrored]).max() <= 1e-12 * np.abs(there).max(), name
    there, here = (result.driving_torque for result in results)
    assert np.abs(here - there[mirrored]).max() <= 1e-12 * np.abs(there).max()


@pytest.mark.parametrize("speed", [SPEED, -SPEED])
def test_power_balance(press, engine, speed):
    """With a drawing force on the ram: 1e-12 of the flow at every angle, and over the turn the drive gives what the force takes."""
    motion = pp.cycle(press, speed, engine=engine)
    drawing = 20e3 * np.sin(motion.crank_angle) ** 2  # smooth, so that the sum over a turn is exact
    load = pp.loads.PointForce("slide", np.outer(drawing, [1.0, 0.0, 0.0]))
    result = pp.inverse_dynamics(press, motion, loads=[load], engine=engine)
    assert np.abs(result.power_residual).max() <= 1e-12
    given, taken = result.driving_torque * motion.crank_speed, -drawing * motion.slide_velocity
    assert abs(given.sum() - taken.sum()) <= 1e-12 * np.abs(taken).sum()
    assert abs(taken.sum()) > 1e-2 * np.abs(taken).sum()  # not zero by symmetry
