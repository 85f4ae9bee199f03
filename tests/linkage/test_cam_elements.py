"""Cams of a URDF: what is read, refused and doubted, and presses that are written back."""

import re
from typing import Any

import numpy as np
import pytest
from support import cams
from support.texts import file, load

import pinpress as pp
from pinpress.engines.machine_elements.cams import CamContact

LAW = '<point angle="0" lift="0"/><point angle="90" lift="0.04" law="3-4-5"/><point angle="180" lift="0.04"/>'
BACK = '<point angle="270" lift="0" law="3-4-5"/>'
SAID = {"name": "eject", "cam": "camshaft", "follower": "ejector", "radius": 0.08, "roller_radius": 0.02, "roller_width": 0.03}


def cam(law=LAW + BACK, **attributes):
    said = " ".join(f'{key}="{value}"' for key, value in (SAID | attributes).items())
    return f"<cam {said}>{law}</cam>"


EMPTY = '<link name="{}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
PIN = """<joint name="{}" type="continuous"><parent link="frame"/><child link="{}"/><origin xyz="{} 0 0"/><axis xyz="0 -1 0"/></joint>"""
GUIDE = """<joint name="guide" type="prismatic"><parent link="{parent}"/><child link="ejector"/><axis xyz="{axis}"/>
  <limit lower="-1" upper="1" effort="1e6" velocity="10"/>{mimic}</joint>"""


def text(element=None, axis="0 0 1", parent="frame", mimic="", driver="O", more=""):
    links = "".join(map(EMPTY.format, ("camshaft", "ejector", "other")))
    pins = "".join(PIN.format(*pin) for pin in (("O", "camshaft", 0), ("A", "other", 0.15)))
    guide = GUIDE.format(parent=parent, axis=axis, mimic=mimic)
    element = element or cam(offset=0.01)
    still = "" if 'follower="other"' in element else '<relation name="still"><joint name="A"/></relation>'
    drive = f'<transmission name="drive"><joint name="{driver}"/></transmission>'
    return f'<robot name="cam"><link name="frame"/>{links}{pins}{guide}{still}{element}{drive}{more}</robot>'


def test_relation_and_contact():
    press = load(text())
    contact, relation = press.contacts[0], press.relations[-1]
    assert isinstance(contact, CamContact)
    assert (contact.name, relation.name, contact.relation) == ("eject", "eject", 1)
    assert (press.link_of(contact.first), press.link_of(contact.second), contact.carrier) == ("camshaft", "ejector", 0)
    assert press.mobility == 1
    motion = pp.servo_cycle(press, np.radians([0.0, 45.0, 90.0]), speed=0.0, acceleration=0.0)
    np.testing.assert_allclose(motion.joint_position[:, press.joints.index("guide")], [0.0, 0.02, 0.04], atol=1e-14)


def test_tables_of_lifts():
    """In metres, with slopes and second derivatives by rad, and without."""
    rows = "".join(
        f'<row angle="{angle}" lift="{0.02 - 0.02 * np.cos(np.radians(angle))}" slope="{0.02 * np.sin(np.radians(angle))}"'
        f' bend="{0.02 * np.cos(np.radians(angle))}"/>'
        for angle in range(0, 360, 15)
    )
    for table in (rows, re.sub(' slope="[^"]*" bend="[^"]*"', "", rows)):
        press = load(text(cam(table)))
        motion = pp.cycle(press, 2.0, points=50)
        np.testing.assert_allclose(motion.joint_position[:, -1], 0.02 - 0.02 * np.cos(motion.crank_angle), atol=2e-6)


def test_drawn_at_another_angle():
    """The coordinate counts from the drawn pose, the lift from the law."""
    press = load(text(cam(offset=0.01, drawn_at=90)))
    motion = pp.servo_cycle(press, np.radians([0.0, -90.0, 90.0]), speed=0.0, acceleration=0.0)
    np.testing.assert_allclose(motion.joint_position[:, press.joints.index("guide")], [0.0, -0.04, 0.0], atol=1e-14)
    assert press.contacts[0].wrench(np.zeros((3, 1))).point[0, 2] == pytest.approx(np.sqrt(0.0063) + 0.04, rel=1e-14)


@pytest.mark.parametrize(
    ("element", "options", "message"),
    [
        (cam(LAW), {}, 'cam name="eject">: its law is not closed: the lift is 0.04 m at 180 deg'),
        (cam(LAW + '<point angle="270" lift="0"/>'), {}, "speed jumps at 180 deg: 0 to -0.0254648 m/rad; .* modified sine"),
        (cam(offset=-0.09), {}, r"its radius is 0\.08 m, not more than the offset 0\.09 m"),
        (cam(center="0.09 0 0.01"), {}, r"the centre of the roller passes the cam at 0\.09 m"),
        (cam(center="0 0 0.1"), {}, r"its roller is drawn 0\.1 m from the axis .* the law has it at 0\.08 m"),
        (cam(center="0 0 0.1", offset=0), {}, "the centre of its roller is given twice"),
        (cam(arm=0.1), {}, "its follower is in a guide and has no arm"),
        (cam(drawn_at="90x"), {}, "drawn_at='90x': '90x' is not a finite number"),
        (cam(LAW.replace("0.04", "-0.09") + BACK), {}, "its lifts lead the roller beyond the line"),
        (cam(LAW.replace("0.04", "-0.07") + BACK), {}, r"its centre comes to 0\.01 m from the axis of the cam"),
        (cam(radius=0.05, roller_radius=0.045), {}, r"undercut: .* a radius of 0\.0\d+ m at .* the radius of the roller, 0\.045 m"),
        (cam(LAW.replace("3-4-5", "3-4-6") + BACK), {}, "no motion law '3-4-6', did you mean '3-4-5'"),
        (
            cam(LAW.replace('lift="0"', 'lift="0.01"') + BACK.replace('lift="0"', 'lift="0.01"')),
            {},
            r"the lift 0\.01 m at 0 deg, in the drawn",
        ),
        (cam(LAW + BACK + '<row angle="300" lift="0"/>'), {}, "has points of a law and rows of a table"),
        (cam(""), {}, "its law has 0 points"),
        (cam(kind="closed"), {}, "unknown kind 'closed'"),
        (cam(roller_width=0), {}, "roller_width is 0; write a length above 0"),
        (cam(cam="camshift"), {}, "no link 'camshift', did you mean 'camshaft'"),
        (cam(cam="frame"), {}, "link 'frame' does not move"),
        (cam(cam="ejector"), {}, "both are link 'ejector'"),
        (cam(), {"parent": "other"}, "'frame' carries the cam 'camshaft', and 'other' the follower 'ejector'"),
        (cam(), {"axis": "0 1 0"}, "its follower does not move in the plane across the axis of the cam"),
        (cam(), {"mimic": '<mimic joint="O"/>'}, "'guide' of the follower obeys the cam, and it is geared"),
        (cam(), {"driver": "guide"}, "'guide' of the follower obeys the cam, and it is driven"),
        (cam(), {"more": '<relation name="r"><joint name="guide"/></relation>'}, "obeys the cam, and relation 'r' moves it"),
        (cam() + cam(name="again"), {}, "and another cam moves it"),
        (cam(name="guide"), {}, "the name is already that of a <joint>"),
        (cam(cam="ejector", follower="other"), {}, "'guide' is prismatic"),
        (cam(follower="other"), {}, "its follower turns, and nothing says how long its arm is"),
        (cam(follower="other", arm=-1), {}, "arm is -1; write a length above 0"),
        (cam(follower="other", arm=1, offset=1), {}, "its follower is on an arm and has no offset"),
        (cam(follower="other", arm=0.05), {}, "its arm of 0.05 m, 0.15 m away from the cam, does not reach the radius 0.08 m"),
    ],
)
def test_refused(element, options, message):
    with pytest.raises(pp.PinpressError, match=message):
        pp.load(file(text(element, **options)))


def test_a_steep_cam_is_doubted():
    steep = LAW.replace('angle="90"', 'angle="50"') + BACK
    with pytest.warns(
        pp.PinpressWarning, match=r'<cam name="eject">: its pressure angle reaches 37\.83 deg at 22\.9 deg, above 30 deg for a'
    ):
        pp.load(file(text(cam(steep, offset=0.01))))


def test_the_hollow_flank_of_a_groove_can_be_undercut():
    """Where the path of the roller is hollow, with less than its radius: the inner flank exists, the outer one does not."""
    angles = np.arange(0.0, 360.0, 5.0)
    dip = -0.02 * np.exp(-((np.radians(angles - 180.0) / 0.25) ** 2))
    rows = "".join(f'<row angle="{angle}" lift="{lift}"/>' for angle, lift in zip(angles, dip - dip[0], strict=True))
    wavy = cam(rows, radius=0.16, roller_radius=0.045)
    press = pp.load(file(text(wavy)))
    contact: Any = press.contacts[0]
    convex, hollow = (contact.largest(lambda states, sign=sign: sign * states.curvature)[0] for sign in (1.0, -1.0))
    assert convex < 1 / 0.045 < hollow
    with pytest.raises(pp.UrdfError, match="the cam is undercut"):
        pp.load(file(text(wavy.replace("<cam ", '<cam kind="groove" '))))


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", cams.TABLES)
def test_written_and_read_again(name, tmp_path):
    """Also redrawn at another crank angle, where the law starts elsewhere."""
    press = cams.press(name).drawn_at(0.5)
    pp.write_urdf(press, tmp_path / "press.urdf")
    again = pp.load(tmp_path / "press.urdf")
    one, other = (pp.inverse_dynamics(each, pp.cycle(each, 5.0, points=12)) for each in (press, again))
    np.testing.assert_allclose(other.driving_torque, one.driving_torque, rtol=0, atol=1e-9)
    cam = press.contacts[0].name
    np.testing.assert_allclose(other.bearing_force[cam], one.bearing_force[cam], rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    ("write", "program"),
    [
        (pp.write_mjcf, "MuJoCo"),
        (pp.write_sdf, "Gazebo"),
        *((lambda press, path, dialect=each: pp.write_urdf(press, path, dialect=dialect), each) for each in ("urdf+", "gazebo", "drake")),
    ],
)
def test_programs_without_cams(write, program, tmp_path):
    with pytest.raises(pp.PinpressError, match=f"{re.escape(program)} has no cams, such as 'eject'"):
        write(cams.press("ejector"), tmp_path / "press.xml")


def test_check_names_the_cam():
    found = pp.check(file(text()))
    assert not found.errors
    assert "engine 'space' computes it, not 'plane': it has the cam 'eject'" in str(found).replace("\n    ", " ")
