"""Cams under load: printed values of an independent script, balances of single bodies, engines, peaks at corners, and lift-off."""

import copy
import dataclasses
import pickle

import numpy as np
import pinocchio as pin
import pytest
from support import cams, texts

import pinpress as pp
from pinpress.loads import PointForce, PointMoment

SPEED = 12.0
LEAVES = "ejector: its roller leaves the cam 'eject' at crank angle .* deg, where the cam would have to pull it: press the roller on"
LOAD = PointForce("ejector", (0.0, 0.0, -3000.0))


def ejector(law):
    """The ejector of the printed values, which returns as it rises."""
    table = copy.deepcopy(cams.EJECTOR)
    table["cams"]["eject"]["law"] = [[0, 0], {law: [90, 40]}, [180, 40], {law: [290, 0]}]
    return pp.build(**table)


@pytest.mark.parametrize(
    ("law", "printed"),
    [
        (
            "3-4-5",
            {
                20: (3.0564446477, 8.8413955664, 4496.0388812, 101.3878918, -1298.006981),
                45: (20, 20.799191955, 4755.139165, 212.24505323, 91.67776254),
                70: (36.943555352, 6.290389654, 4474.8262569, 101.50815665, 64.4847066),
            },
        ),
        pytest.param("sine", {45: (20, 22.385793035, 4807.5441485, 226.39472345, 91.04082045)}, marks=pytest.mark.exhaustive),
        pytest.param(
            "modified sine", {70: (36.459358628, 7.1413959172, 4513.2167759, 109.77253414, 67.65340104)}, marks=pytest.mark.exhaustive
        ),
    ],
)
def test_ejector(law, printed):
    """Lift [mm], pressure angle [deg], force, torque and radius of the pitch curve [mm] at cam angles; what goes into cam and guide."""
    press = ejector(law)
    motion = pp.cycle(press, SPEED, points=72)
    found = pp.measures.cam(press, pp.inverse_dynamics(press, motion, [cams.SPRING, LOAD]), "eject")
    both = [pp.inverse_dynamics(press, motion, [cams.SPRING, LOAD], engine=engine) for engine in ("space", "pinocchio")]
    for angle, values in printed.items():
        k = angle // 5
        shown = 1e3 * found.lift[k], np.degrees(found.pressure_angle[k]), found.force[k], found.cam_torque[k], 1e3 * found.pitch_radius[k]
        assert shown == pytest.approx(values, rel=2e-10)
        for reactions in both:
            assert np.linalg.norm(reactions.bearing_force["eject"][k]) == pytest.approx(values[2], rel=1e-10)
            assert reactions.driving_torque[k] == pytest.approx(values[3], rel=1e-9)
    side = found.effort * np.tan(found.pressure_angle)
    for reactions in both:
        np.testing.assert_allclose(reactions.bearing_force["ejector_guide"], np.stack([side, 0 * side, 0 * side], axis=1), atol=1e-9)
        assert reactions.power_residual.max() < 1e-14


@pytest.mark.parametrize(
    ("law", "speed"),
    [
        ("3-4-5", 27.64205203),
        pytest.param("sine", 26.34666271, marks=pytest.mark.exhaustive),
        pytest.param("modified sine", 28.55680494, marks=pytest.mark.exhaustive),
    ],
)
def test_speed_of_lift_off(law, speed):
    """The printed speeds are those of the rise alone: this return is too slow to lift off. The asked speed does not matter."""
    table = copy.deepcopy(cams.EJECTOR)
    table["cams"]["eject"]["law"] = [[0, 0], {law: [90, 40]}, [180, 40], {"3-4-5": [359, 0]}]
    press = pp.build(**table)
    reactions = pp.inverse_dynamics(press, pp.cycle(press, SPEED if law == "sine" else 20.0, points=72), [cams.SPRING])
    assert pp.measures.cam(press, reactions, "eject").lift_off_speed == pytest.approx(speed, abs=6e-9)


@pytest.mark.exhaustive
def test_lift_off_with_a_load_that_grows_with_the_speed():
    """A damper that only opposes the return; the speed is confirmed by the least force at this speed."""
    press = ejector("3-4-5")
    damped = [dataclasses.replace(cams.SPRING, damping=400.0)]
    speed = pp.measures.cam(press, pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=90), damped), "eject").lift_off_speed
    again = pp.measures.cam(press, pp.inverse_dynamics(press, pp.cycle(press, speed, points=90), damped), "eject")
    assert abs(again.least_force[0]) < 1e-6 * again.largest_force[0]


def test_slow_motions_find_the_same_speed():
    press = cams.press("ejector")
    found = [pp.measures.cam(press, pp.inverse_dynamics(press, pp.cycle(press, w, points=36)), "eject").lift_off_speed for w in (1e-3, 5.0)]
    assert found[0] == pytest.approx(found[1], rel=1e-9)


def test_what_no_speed_lifts_off():
    press, holder = ejector("3-4-5"), cams.press("drawing_press")
    with pytest.warns(pp.PinpressWarning, match=LEAVES):
        reactions = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=24), [PointForce("ejector", (0.0, 0.0, 1000.0))])
    assert pp.measures.cam(press, reactions, "eject").lift_off_speed == 0.0  # it is lifted at rest
    uneven = pp.servo_cycle(press, np.linspace(0.0, 6.0, 24), speed=np.linspace(1.0, 2.0, 24), acceleration=np.zeros(24))
    assert pp.measures.cam(press, pp.inverse_dynamics(press, uneven), "eject").lift_off_speed is None
    groove = pp.measures.cam(holder, pp.inverse_dynamics(holder, pp.cycle(holder, SPEED, points=24)), "hold")
    assert groove.grooved
    assert groove.lift_off_speed is None


@pytest.mark.parametrize(
    ("angle", "slope", "pressure_angle", "force", "torque"),
    [
        (30, 0.19845, 10.31796551, 2354.47520182, 55.1627688),
        pytest.param(50, 0.28125, 19.64137159, 1769.63277153, 56.25, marks=pytest.mark.exhaustive),
        pytest.param(80, 0.1152, 12.12086348, 945.18451165, 12.77494315, marks=pytest.mark.exhaustive),
    ],
)
def test_feeder(angle, slope, pressure_angle, force, torque):
    """0.8 kg m2 at 15 rad/s against 200 N m; the arm turns clockwise as it rises, against its own axis."""
    press = cams.press("feeder")
    motion = pp.cycle(press, 15.0, points=36)
    k, arm = angle // 10, press.joints.index("B")
    against = PointMoment("arm", 200.0)
    assert motion.v[k, arm] == pytest.approx(-slope * 15.0, rel=1e-12)
    found = pp.measures.cam(press, pp.inverse_dynamics(press, motion, [against]), "feed")
    assert (np.degrees(found.pressure_angle[k]), found.cam_torque[k]) == pytest.approx((pressure_angle, torque), rel=2e-9)
    for engine in ("space", "pinocchio"):
        reactions = pp.inverse_dynamics(press, motion, [against], engine=engine)
        assert np.linalg.norm(reactions.bearing_force["feed"][k]) == pytest.approx(force, rel=2e-9)
        assert reactions.driving_torque[k] == pytest.approx(torque, rel=2e-9)


def test_forces_balance_on_every_body():
    """Blank holder beside a crank-slide, in maximal coordinates: the cam's force, moved to the centres of mass, balances both bodies."""
    press = cams.press("drawing_press")
    motion = pp.cycle(press, SPEED, points=90)
    reactions = pp.inverse_dynamics(press, motion, [PointForce("holder", (30.0, 0.0, -2000.0))])
    holder, push = press.joints.index("holder_guide"), reactions.bearing_force["hold"]
    up = -motion.a[:, holder]
    total = push + reactions.bearing_force["holder_guide"] + [30.0, 0.0, -2000.0 - 60.0 * 9.81]
    np.testing.assert_allclose(total, 60.0 * np.stack([0 * up, 0 * up, up], axis=1), atol=1e-9)
    crank = reactions.bearing_force["O"] - push - reactions.bearing_force["P"]
    contact = press.contacts[0].wrench(motion.joint_position.T)
    lever = np.cross(contact.point, -push) + np.cross(pp.measures.bearing_positions(press, motion)["P"], -reactions.bearing_force["P"])
    angle = motion.crank_angle  # the centre of mass of the crank is in the middle of O and P
    centre = 0.05 * np.stack([np.sin(angle), 0 * angle, -np.cos(angle)], axis=1)
    weight = np.array([0.0, 0.0, -30.0 * 9.81])
    np.testing.assert_allclose(crank + weight, -(SPEED**2) * 30.0 * centre, atol=1e-8)
    moment = reactions.bearing_moment["O"] + lever + np.cross(centre, weight)
    np.testing.assert_allclose(moment, 0.0, atol=1e-8)
    assert (pp.measures.cam(press, reactions, "hold").force < 0.0).any()  # which the groove takes


def test_hertz():
    """5 kN, radius 20 on 60 mm, 30 mm wide, steel."""
    press = cams.press("ejector")
    table = copy.deepcopy(cams.EJECTOR)
    table["cams"]["eject"] |= {"offset": 0, "law": [[0, 0], [180, 0]]}
    table["pins"]["E"] = [0, 80]
    press = pp.build(**table)
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 1.0, points=8), [PointForce("ejector", (0.0, 0.0, -5000.0 + 25 * 9.81))])
    found = pp.measures.cam(press, reactions, "eject")
    np.testing.assert_allclose(found.pressure, 638.81890835e6, rtol=1e-11)
    np.testing.assert_allclose(found.surface_radius, 0.06, rtol=1e-12)
    assert found.least_radius[0] == pytest.approx(0.06, rel=1e-12)
    assert found.lift_off_speed is None  # without a lift no speed does it


def test_hertz_in_a_groove():
    """A roller that is pulled touches the outer flank, which is hollow there: 1/20 - 1/100 mm."""
    table = copy.deepcopy(cams.EJECTOR)
    table["cams"]["eject"] |= {"offset": 0, "kind": "groove", "law": [[0, 0], [180, 0]]}
    table["pins"]["E"] = [0, 80]
    press = pp.build(**table)
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 1.0, points=8), [PointForce("ejector", (0.0, 0.0, 5000.0 + 25 * 9.81))])
    pressure = pp.measures.cam(press, reactions, "eject").pressure
    np.testing.assert_allclose(pressure, np.sqrt(5000.0 * 2.1e11 * 40.0 / (2 * np.pi * 0.91 * 0.03)), rtol=1e-12)


@pytest.mark.filterwarnings("ignore:ejector. its roller leaves the cam")
def test_peaks_do_not_depend_on_the_states():
    """The acceleration of the trapezoid jumps at corners between the states: both limits are found, and smooth peaks as well."""
    press = ejector("trapezoid")
    found = []
    for points in (36, 97):
        reactions = pp.inverse_dynamics(press, pp.cycle(press, 40.0, points=points), [cams.SPRING])
        cam = pp.measures.cam(press, reactions, "eject")
        guide = next(each for each in pp.measures.extremes(reactions) if each.quantity == "force in ejector_guide, x")
        found.append([*cam.largest_force, cam.least_force[0], cam.largest_pressure[0], guide.largest, guide.smallest])
    np.testing.assert_allclose(found[0], found[1], rtol=1e-8)  # of the smooth peaks of the guide; those at corners have all digits
    rise = 25.0 * (4.5 * 0.04 / (np.pi / 2) ** 2 * 40.0**2 + 9.81) + 800.0
    at_corner = rise + 20e3 * 0.04 / 4  # a quarter of the lift after a third of the way
    cosine = (np.sqrt(0.0063) + 0.01) / np.hypot(np.sqrt(0.0063) + 0.01, 1.5 * 0.04 / (np.pi / 2) - 0.01)
    assert found[0][0] == pytest.approx(at_corner / cosine, rel=1e-9)


@pytest.mark.parametrize(("ratio", "turns"), [(-0.5, 2), (2 / 3, 3), (-2.0, 1)])
def test_the_period_is_that_of_the_cam(ratio, turns):
    """Of a camshaft that is geared to the driver, whose speed of lift-off then counts."""
    table = copy.deepcopy(cams.EJECTOR)
    table |= {"frame": "O Q", "pins": table["pins"] | {"Q": [-200, 0]}, "drive": "Q", "gears": {"O": f"{ratio} * Q"}}
    table["links"]["motor"] = {"pins": "Q", "mass": 5, "inertia": 0.01}
    press = pp.build(**table)
    motion = pp.cycle(press, 3.0, points=60)
    assert motion.period_turns == turns
    assert motion.joint_position[:, press.joints.index("ejector_guide")].max() == pytest.approx(0.04, abs=1e-12)
    lift_off = pp.measures.cam(press, pp.inverse_dynamics(press, motion), "eject").lift_off_speed
    plain = cams.press("ejector")
    alone = pp.measures.cam(plain, pp.inverse_dynamics(plain, pp.cycle(plain, 3.0, points=60)), "eject").lift_off_speed
    assert lift_off * abs(ratio) == pytest.approx(alone, rel=1e-9)


def test_drawn_elsewhere():
    """A press drawn at another crank angle has the same forces in the world."""
    press = cams.press("drawing_press")
    again = press.drawn_at(0.7)
    one, other = (
        pp.inverse_dynamics(each, pp.servo_cycle(each, angle, speed=3.0, acceleration=0.0))
        for each, angle in ((press, [1.2]), (again, [0.5]))
    )
    for name, force in one.bearing_force.items():
        np.testing.assert_allclose(other.bearing_force[name], force, atol=1e-8)
    found = [pp.measures.cam(*each, "hold") for each in ((press, one), (again, other))]
    assert found[0].lift[0] == pytest.approx(found[1].lift[0], abs=1e-15)
    assert found[0].angle[0] == pytest.approx(found[1].angle[0], abs=1e-12)


def test_clockwise():
    """With all turns reversed, a negative speed gives the forces of the positive one; the offset is on the same side of the picture."""
    clockwise = pp.build(**copy.deepcopy(cams.EJECTOR) | {"turns": "clockwise", "pins": {"O": [0, 0], "E": [-10, "sqrt(80**2 - 10**2)"]}})
    press = cams.press("ejector")
    one, other = (pp.inverse_dynamics(each, pp.cycle(each, 5.0, points=36)) for each in (press, clockwise))
    mirrored = one.bearing_force["eject"] * [-1.0, 1.0, 1.0]
    np.testing.assert_allclose(other.bearing_force["eject"], mirrored, atol=1e-9)
    np.testing.assert_allclose(other.driving_torque, one.driving_torque, atol=1e-9)


def test_result_is_read_only_and_can_be_sent():
    press = cams.press("ejector")
    found = pp.measures.cam(press, pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=36), [cams.SPRING]), "eject")
    again = pickle.loads(pickle.dumps(found))
    assert again.least_force == found.least_force
    assert not again.force.flags.writeable
    assert {"lift [m]", "force [N]", "pressure [Pa]"} <= set(found.columns())
    assert "the roller leaves the cam" in str(found)


def test_refused_cams():
    press, other = cams.press("ejector"), cams.press("feeder")
    reactions = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=36), [cams.SPRING])
    with pytest.raises(pp.PinpressError, match="no cam 'ejekt', did you mean 'eject'"):
        pp.measures.cam(press, reactions, "ejekt")
    with pytest.raises(pp.PinpressError, match="the reactions are of ejector: give reactions of feeder"):
        pp.measures.cam(other, reactions, "feed")


MOMENTS = '<inertia ixx="0.01" iyy="0.02" izz="0.015" ixy="0" ixz="0" iyz="0"/>'
BODY = f'<inertial><origin xyz="0.02 0.01 0.03"/><mass value="3"/>{MOMENTS}</inertial>'
TURNTABLE = f"""<robot name="turntable"><link name="frame"/><link name="table">{BODY}</link><link name="camshaft">{BODY}</link>
  <link name="lifter">{BODY}</link><link name="arm">{BODY}</link>
  <joint name="T" type="continuous"><parent link="frame"/><child link="table"/><origin rpy="0.3 -0.2 0.5"/><axis xyz="0 0.6 0.8"/></joint>
  <joint name="C" type="continuous"><parent link="table"/><child link="camshaft"/><origin xyz="0.1 0.2 -0.1" rpy="1 0.4 -0.7"/>
    <axis xyz="0 0 1"/><mimic joint="T" multiplier="-1.5"/></joint>
  <joint name="L" type="prismatic"><parent link="table"/><child link="lifter"/><origin xyz="0.2 0.2 -0.1" rpy="1 0.4 -0.7"/>
    <axis xyz="0.8 0.6 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="A" type="continuous"><parent link="table"/><child link="arm"/><origin xyz="0.3 0.2 -0.1" rpy="1 0.4 -0.7"/>
    <axis xyz="0 0 -1"/></joint>
  <cam name="lift" cam="camshaft" follower="lifter" radius="0.1" offset="-0.02" roller_radius="0.01" roller_width="0.02" kind="groove">
    <point angle="0" lift="0"/><point angle="150" lift="0.05" law="sine"/><point angle="360" lift="0" law="modified trapezoid"/></cam>
  <cam name="swing" cam="camshaft" follower="arm" radius="0.15" arm="0.13" roller_radius="0.01" roller_width="0.02" kind="groove">
    <point angle="0" lift="0"/><point angle="200" lift="12" law="3-4-5"/><point angle="360" lift="0" law="modified sine"/></cam>
  <transmission name="drive"><joint name="T"/></transmission></robot>"""


@pytest.mark.parametrize("engine", ["space", "pinocchio"])
def test_cams_on_a_turntable_in_space(engine):
    """Two followers of one cam whose axis turns. Each body is cut free, with its motion by Pinocchio's own kinematics."""
    press = texts.load(TURNTABLE)
    motion = pp.servo_cycle(press, np.linspace(0.1, 6.0, 5), speed=4.0, acceleration=2.0)
    reactions = pp.inverse_dynamics(press, motion, engine=engine)
    assert reactions.power_residual.max() < 1e-14
    model, data = press.model, press.model.createData()
    contacts = {contact.name: contact for contact in press.contacts}
    for k in range(5):
        q, x = press.configuration(motion.crank_angle[k]), motion.joint_position[k][:, None]
        pin.forwardKinematics(model, data, q, motion.v[k], motion.a[k])
        for joint, name in (("L", "lift"), ("A", "swing")):
            body = press.joints.index(joint) + 1
            place, contact = data.oMi[body], contacts[name]
            inertia = model.inertias[body]
            centre = place.act(inertia.lever)
            spin = pin.getVelocity(model, data, body, pin.WORLD).angular
            at_centre = pin.SE3(np.eye(3), inertia.lever)
            acceleration = at_centre.actInv(data.a[body]).linear + np.cross(data.v[body].angular, at_centre.actInv(data.v[body]).linear)
            turning = pin.getAcceleration(model, data, body, pin.WORLD).angular
            tensor = place.rotation @ inertia.inertia @ place.rotation.T
            cam, held = reactions.bearing_force[name][k], reactions.bearing_force[joint][k]
            weight = inertia.mass * np.array([0.0, 0.0, -9.81])
            np.testing.assert_allclose(cam + held + weight, inertia.mass * place.rotation @ acceleration, atol=1e-10)
            point = data.oMi[contact.carrier].act(contact.wrench(x).point[0])
            moment = np.cross(point - centre, cam) + np.cross(place.translation - centre, held) + reactions.bearing_moment[joint][k]
            np.testing.assert_allclose(moment, tensor @ turning + np.cross(spin, tensor @ spin), atol=1e-10)
