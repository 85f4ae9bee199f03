"""Linkages in other formats: the same numbers as from our own, and what cannot be read refused by name."""

import pickle
import re
import sys
import warnings

import numpy as np
import pytest
from support import texts
from support.generators.other_formats import FORMATS, Press

import pinpress as pp
from pinpress.common.errors import UrdfError
from pinpress.linkage.loading import build, parse

SAME = 1e-12  # of the largest value: placements are multiplied up and taken apart again


def named(name, text):
    """A file of this name in a folder of its own."""
    return texts.file(text, name)


def loaded(file, **more):
    """With what it warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        press = pp.load(file, **more)
    return press, [str(warning.message) for warning in caught]


def forces(press):
    """Driving torque and the forces of all bearings, (n, 1 + 3 bearings), by sorted names."""
    reactions = pp.inverse_dynamics(press, pp.cycle(press, speed=5.0, points=24))
    names = sorted(press.bearings)
    torque = np.reshape(reactions.driving_torque, (24, -1))
    return names, np.hstack([torque, *(reactions.bearing_force[name] for name in names)])


@pytest.mark.one_in(29)
@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("name", pp.presses())
def test_a_press_in_another_format_has_the_torque_and_bearing_forces_of_ours(name, form, tmp_path):
    source = Press(pp.load(name).text.decode())
    write, ending = FORMATS[form]
    ours = pp.load(named("ours.urdf", source.urdf()))
    press, warned = loaded(named(f"theirs.{ending}", write(source)))
    assert (press.name, press.drivers, press.slide) == (ours.name, ours.drivers, ours.slide)
    assert bool(warned) == (form == "bushings")
    names, expected = forces(ours)
    got_names, got = forces(press)
    assert got_names == names
    assert np.abs(got - expected).max() <= SAME * np.abs(expected).max()

    again = pp.load(pp.write_urdf(press, tmp_path / "again.urdf"), slide=press.slide)
    assert np.abs(forces(again)[1] - got).max() <= SAME * np.abs(expected).max()
    assert again.text == press.text


def test_messages_name_the_element_and_line_of_the_file():
    source = Press(pp.load("crank_slide").text.decode())
    sdf, mjcf = source.sdf("1.6"), source.mjcf()
    locked = named("locked.sdf", sdf.replace('<joint name="P" type="continuous">', '<joint name="P" type="fixed">'))
    with pytest.raises(UrdfError, match=re.escape('<model name="crank_slide">: mobility is')) as caught:
        pp.load(locked)
    assert caught.value.file == str(locked)
    heavy = named("heavy.sdf", sdf.replace("<mass>20.0</mass>", "<mass>-20.0</mass>"))
    line = next(k for k, text in enumerate(heavy.read_text().splitlines(), 1) if "-20.0" in text)
    with pytest.raises(UrdfError, match=re.escape(f'{heavy}:{line}: <inertial> of <link name="crank">: the mass -20.0')):
        pp.load(heavy)
    apart = named("apart.xml", re.sub('<site name="W_1" pos="[^"]*"', '<site name="W_1" pos="2 2 2"', mjcf))
    line = next(k for k, text in enumerate(mjcf.splitlines(), 1) if "<connect" in text)
    with pytest.raises(pp.PinpressError, match=re.escape(f"{apart}:{line}: ")):
        pp.load(apart)
    (error,) = pp.check(apart).errors
    assert (error.element, error.line) == ('<connect name="W">', line)
    assert f"{apart}:{line}: error: <connect" in str(pp.check(apart))


def test_a_press_from_another_format_is_kept_whole(tmp_path):
    press = pp.load(named("press.sdf", Press(pp.load("crank_slide").text.decode()).sdf()))
    copy = pickle.loads(pickle.dumps(press))
    assert (copy.text, copy.document.origins) == (press.text, press.document.origins)
    assert np.array_equal(forces(copy)[1], forces(press)[1])
    assert press.file.endswith("press.sdf")
    heavier = [inertia.copy() for inertia in press.model.inertias]
    heavier[1].mass *= 2
    changed = press.with_inertias(heavier)
    assert pp.load(pp.write_urdf(changed, tmp_path / "heavier.urdf")).model.inertias[1].mass == heavier[1].mass


def test_mjcf_without_mujoco_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(pp.PinpressError, match=r"pip install 'pinpress\[peers\]', or mujoco alone"):
        pp.load(named("press.xml", Press(pp.load("crank_slide").text.decode()).mjcf()))


def test_another_root_element_is_refused(tmp_path):
    with pytest.raises(UrdfError, match=":1: <html>: the root element is not <robot>, <sdf> or <mujoco>"):
        pp.load(named("page.xml", "<html/>"))
    with pytest.raises(UrdfError, match="cannot be read: "):
        pp.load(tmp_path / "missing.sdf")


# ---------------------------------------------------------------------------------------------------------------------- dialects of URDF


def crank_slide(loop):
    """The shipped press with another element in the place of its loop."""
    return re.sub("<loop_joint.*</loop_joint>", lambda _: loop, pp.load("crank_slide").text.decode(), flags=re.DOTALL)


BUSHING = (
    '<drake:linear_bushing_rpy><drake:bushing_frameA name="rod"/><drake:bushing_frameC name="slide"/>'
    '<drake:bushing_torque_stiffness value="{}"/><drake:bushing_torque_damping value="0 0 0"/>'
    '<drake:bushing_force_stiffness value="{}"/><drake:bushing_force_damping value="0 0 0"/></drake:linear_bushing_rpy>'
)
BALL = (
    '<drake:ball_constraint><drake:ball_constraint_body_A name="rod"/><drake:ball_constraint_p_AP value="0.4 0 0"/>'
    '<drake:ball_constraint_body_B name="slide"/><drake:ball_constraint_p_BQ value="0 0 0"/></drake:ball_constraint>'
)
LOOP = '<{0} name="W" type="{1}"><predecessor link="rod"><origin xyz="0.4 0 0"/></predecessor><successor link="slide"/>{2}</{0}>'
GAZEBO = '<gazebo><joint name="W" type="{}"><parent>rod</parent><child>slide</child>{}</joint></gazebo>'


@pytest.mark.parametrize(
    ("loop", "name", "type", "axis"),
    [
        (BALL, "ball_rod_slide", "spherical", None),
        (BUSHING.format("0 0 0", "1 2 3"), "bushing_rod_slide", "spherical", None),
        (BUSHING.format("5 0 5", "1 2 3"), "bushing_rod_slide", "revolute", (0, 1, 0)),
        (LOOP.format("loop", "revolute", '<axis xyz="0 -2 0"/>'), "W", "revolute", (0, -1, 0)),
        (LOOP.format("constraint", "continuous", ""), "W", "revolute", (1, 0, 0)),
        (LOOP.format("loop", "fixed", ""), "W", "fixed", None),
        (GAZEBO.format("ball", ""), "W", "spherical", None),
        (GAZEBO.format("revolute", "<axis><xyz>0 -1 0</xyz></axis>"), "W", "revolute", (0, -1, 0)),
    ],
)
def test_loops_of_other_dialects_are_read(loop, name, type, axis):
    document = parse(named("press.urdf", crank_slide(loop)))
    (found,) = document.robot.all("loop_joint")
    assert (found.get("name"), found.get("type")) == (name, type)
    assert [each.numbers("xyz") for each in found.all("axis")] == [axis] * (axis is not None)
    before, after = crank_slide("").encode(), document.text.replace(b"<gazebo></gazebo>", b"")
    assert re.sub(rb"<loop_joint.*</loop_joint>", b"", after) == before  # to the byte


def test_a_joint_of_gazebo_may_have_its_axis_in_the_frame_of_the_model():
    axis = "<axis><xyz>0 -1 0</xyz><use_parent_model_frame>true</use_parent_model_frame></axis>"
    loop = GAZEBO.format("revolute", axis + "<pose>0 0 0 0.5 0 0</pose>")
    document = parse(named("press.urdf", crank_slide(loop)))
    press = build(document, None, None)
    assert press.loops[0].rotation1[:, 0] == pytest.approx([0, -1, 0], abs=1e-15)


@pytest.mark.parametrize(
    ("frame", "at"),
    [("rod", "0.4 0 0"), ("slide", "0 0 0"), ("P", "0.4 0 0"), ("O", "0.5 0 0"), ("slide_guide", "0 0 0"), ("__model__", "0 0 -0.5")],
)
def test_a_joint_of_gazebo_may_be_placed_in_another_frame(frame, at):
    """A link, a joint, whose frame is that of its child, or the model: the same place and axis make the same loop."""
    axis = f'<axis><xyz expressed_in="{frame}">0 -1 0</xyz></axis>'
    document = parse(named("press.urdf", crank_slide(GAZEBO.format("revolute", f'<pose relative_to="{frame}">{at} 0.5 0 0</pose>{axis}'))))
    loop = build(document, None, None).loops[0]
    np.testing.assert_allclose([loop.point1, loop.point2, loop.rotation1[:, 0]], [[0.4, 0, 0], [0, 0, 0], [0, -1, 0]], rtol=0, atol=1e-15)


COUPLING = '<coupling name="c"><predecessor link="{}"/><successor link="{}"/><ratio value="{}"/></coupling>'
DIALECT_REFUSED = [
    (GAZEBO.format("ball", '<pose relative_to="rot">0 0 0 0 0 0</pose>'), "<pose>.*: no frame 'rot'; name a link or joint of this file"),
    (BUSHING.format("5 0 0", "1 2 3"), "<drake:linear_bushing_rpy>: a bushing is elastic, and this one is neither a pin"),
    (BUSHING.format("0 0 0", "1 0 3"), "neither a pin .* nor a ball joint"),
    (BALL.replace('name="rod"', 'name="rot"'), "<drake:ball_constraint> ball_rot_slide: no link 'rot', did you mean 'rod'"),
    (BALL.replace("0.4 0 0", "0.4 0"), "<drake:ball_constraint_p_AP>.*: 2 numbers, not 3"),
    (BALL.replace('<drake:ball_constraint_p_BQ value="0 0 0"/>', ""), "has no <drake:ball_constraint_p_BQ>"),
    ('<drake:joint name="W" type="ball"/>', '<drake:joint name="W">: cannot be read'),
    ("<drake:tendon_constraint/>", "<drake:tendon_constraint>: cannot be read"),
    ('<coupling name="c"/>', '<coupling name="c">: has no <predecessor>'),
    (COUPLING.format("rot", "rod", 2), "<predecessor> of <coupling name=.c.>: no link 'rot'"),
    (COUPLING.format("crank", "rod", 0), "<coupling name=.c.>: its ratio is 0"),
    (COUPLING.format("frame", "rod", 2), "no moving joint is between its links on one of their sides"),
    (COUPLING.format("crank", "rod", 2), "no moving joint is between its links on one of their sides"),  # the crank carries the rod
    (COUPLING.format("crank", "slide", "1,5"), "<ratio> of <coupling name=.c.>: '1,5' is not a finite number"),
    ('<link name="closing_a_2"/>', "it is the one side of a loop, of which the other, link 'closing_a_1', is missing"),
    (LOOP.format("loop", "prismatic", ""), "<loop name=.W.>: type 'prismatic' closes no loop here"),
    (LOOP.format("loop", "", ""), "<loop name=.W.>: has no type"),
    (LOOP.format("loop", "revolute", '<axis xyz="0 0 0"/>'), "the axis is zero"),
    (GAZEBO.format("screw", ""), "<joint name=.W.>: a screw joint closes no loop here"),
    (GAZEBO.format("ball", "").replace("rod", "rot"), "no link 'rot'"),
    ('<lop_joint name="W"/>', "unknown element <lop_joint>"),
]


@pytest.mark.parametrize(("loop", "message"), DIALECT_REFUSED)
def test_loops_that_cannot_be_read_are_refused_by_name_and_line(loop, message):
    text = crank_slide("\n" + loop)
    line = text.splitlines().index(loop) + 1
    with pytest.raises(UrdfError, match=message) as caught:
        pp.load(named("press.urdf", text))
    assert caught.value.line == line


def test_more_loops_than_a_press_can_have_are_refused():
    with pytest.raises(UrdfError, match="there are 501 loops, more than 500"):
        parse(named("press.urdf", crank_slide(501 * BALL)))


def test_springs_and_rotors_of_drake_are_warned_of():
    text = crank_slide(BALL + "<drake:linear_spring_damper/>")
    text = text.replace("<mechanicalReduction>", '<drake:rotor_inertia value="0.1"/><mechanicalReduction>')
    press, warned = loaded(named("press.urdf", text))
    assert press.loops[0].name == "ball_rod_slide"
    assert [re.search("a spring|the rotor", message)[0] for message in warned] == ["a spring", "the rotor"]


# ---------------------------------------------------------------------------------------------------------------------------------- MJCF


FEATURES = """<mujoco model="features">
  <compiler angle="degree" eulerseq="xyz"/>
  <default>
    <joint axis="0 -2 0" damping="0.5"/>
    <geom density="7850" rgba="0.1 0.2 0.3 1"/>
    <default class="guide"><joint type="slide" axis="0 0 1" range="-0.5 0.5"/></default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body name="frame" pos="0.1 0.2 0.3" euler="0 0 30">
      <body name="crank">
        <joint name="A" pos="0.02 0 0.01" range="-200 220" ref="20"/>
        <geom type="box" size="0.1 0.02 0.03" pos="0.08 0 0.01"/>
        <body name="rod" pos="0.2 0 0" euler="0 10 0">
          <joint name="B"/>
          <geom type="capsule" size="0.02" fromto="0 0 0 0.5 0 0"/>
        </body>
      </body>
      <body name="slide" pos="0.6 0 -0.1">
        <joint name="across" class="guide" axis="1 0 0"/>
        <joint name="turn" pos="0 0 0.05" axis="0 1 0"/>
        <joint name="up" class="guide"/>
        <geom type="cylinder" size="0.05 0.1"/>
        <geom type="ellipsoid" size="0.05 0.1 0.02"/>
        <body name="ball" pos="0 0 0.1"><joint name="C" type="ball" pos="0 0 0.02"/><geom type="sphere" size="0.05"/></body>
      </body>
    </body>
  </worldbody>
  <actuator><position joint="A" kp="10"/><motor joint="A"/></actuator>
</mujoco>"""


def test_bodies_of_an_mjcf_are_where_mujoco_has_them():
    import mujoco
    import pinocchio as pin

    model = mujoco.MjModel.from_xml_string(FEATURES)
    document = parse(named("features.xml", FEATURES))
    ours = pin.buildModelFromXML(document.text.decode())
    data, there = ours.createData(), mujoco.MjData(model)
    random = np.random.default_rng(3)
    for _ in range(5):
        moved = {joint: random.uniform(-1, 1) for joint in ("A", "B", "across", "turn", "up")}  # A has ref="20"
        turns = random.uniform(-1, 1, 3)
        q = pin.neutral(ours)
        for joint, angle in (*moved.items(), *zip(("C_x", "C_y", "C_z"), turns, strict=True)):
            slot = ours.joints[ours.getJointId(joint)]
            q[slot.idx_q : slot.idx_q + slot.nq] = [angle] if slot.nq == 1 else [np.cos(angle), np.sin(angle)]
        there.qpos[:] = model.qpos0
        for joint, angle in moved.items():
            there.joint(joint).qpos[0] = angle
        ball = pin.Quaternion(pin.exp3(turns[0] * np.eye(3)[0]) @ pin.exp3(turns[1] * np.eye(3)[1]) @ pin.exp3(turns[2] * np.eye(3)[2]))
        there.joint("C").qpos[:] = [ball.w, ball.x, ball.y, ball.z]
        mujoco.mj_forward(model, there)
        pin.framesForwardKinematics(ours, data, q)
        for body in ("crank", "rod", "slide", "ball"):
            place = data.oMf[ours.getFrameId(body, pin.BODY)]
            own = model.body(body)
            turned = place.rotation @ pin.Quaternion(*np.array(there.body(body).xquat)).matrix().T
            assert np.abs(turned - np.eye(3)).max() < 1e-12, body
            joint = ours.frames[ours.getFrameId(body, pin.BODY)].parentJoint
            centre = data.oMi[joint].act(ours.inertias[joint].lever)
            assert centre == pytest.approx(there.body(body).xipos, abs=1e-12)
            assert ours.inertias[joint].mass == pytest.approx(own.mass[0], rel=1e-14)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, there, mass)
        hinges = [model.joint(joint).dofadr[0] for joint in moved]
        columns = [ours.joints[ours.getJointId(joint)].idx_v for joint in moved]
        own_mass = pin.crba(ours, data, q)
        own_mass = np.triu(own_mass) + np.triu(own_mass, 1).T
        assert own_mass[np.ix_(columns, columns)] == pytest.approx(mass[np.ix_(hinges, hinges)], rel=1e-10)


def test_an_mjcf_keeps_limits_shapes_and_drivers_and_says_what_is_left_out():
    file = named("features.xml", FEATURES)
    robot = parse(file).robot
    joints = {joint.get("name"): joint for joint in robot.all("joint")}
    (limit,) = joints["A"].all("limit")
    assert limit.numbers("lower") + limit.numbers("upper") == pytest.approx((np.radians(-200), np.radians(220)))
    springs = {spring.get("joint"): spring for spring in robot.all("joint_spring")}
    assert set(springs) == {"A", "B", "across", "turn", "up"}
    assert (springs["A"].numbers("damping"), springs["A"].numbers("stiffness")) == ((0.5,), (0.0,))
    assert [transmission.all("joint")[0].get("name") for transmission in robot.all("transmission")] == ["A"]
    shapes = [shape.tag for link in robot.all("link") for visual in link.all("visual") for shape in visual.all("geometry")[0].children]
    assert shapes == ["box", "cylinder", "sphere", "sphere", "cylinder", "sphere"]
    assert (str(joints["B"]), joints["B"].line) == ('<joint name="B">', 15)
    notes = [(note.severity, note.element, note.line) for note in parse(file).remarks]
    assert notes == [("note", '<body name="slide">', 19), ("note", '<joint name="C">', 25), ("warning", '<joint name="C">', 25)]


WELDED = """<mujoco model="welded"><compiler angle="radian"/><worldbody>
  <body name="crank" pos="0 0 0.4" euler="0 0.3 0"><joint name="A" axis="0 -1 0"/><geom type="box" size="0.1 0.02 0.03"/>
    <body name="pin" pos="0.1 0 0" euler="0 0 0.4"><joint name="B" axis="0 -1 0" pos="0.01 0 0"/>
      <geom type="box" size="0.1 0.02 0.03"/></body>
  </body>
  <body name="left" pos="-0.3 0 0"><joint name="D" axis="0 -1 0"/><geom type="box" size="0.1 0.02 0.03" pos="0.1 0 0"/></body>
</worldbody><equality>{}</equality><actuator><motor joint="A"/></actuator></mujoco>"""


def test_a_weld_of_an_mjcf_is_a_fixed_loop_in_the_drawn_pose():
    file = named("welded.xml", WELDED.format('<weld name="W" body1="pin" body2="left" anchor="0.1 0.2 0.3"/>'))
    press = build(parse(file), None, None)
    assert [(loop.name, loop.type) for loop in press.loops] == [("W", "fixed")]
    assert np.abs(press.assembly.gaps).max() < 1e-15


@pytest.mark.parametrize("by_sites", [False, True])
def test_a_weld_of_an_mjcf_that_holds_no_turning_is_a_ball(by_sites):
    """MuJoCo: with torquescale="0" a weld behaves like a connect constraint."""
    ends = 'site1="one" site2="two"' if by_sites else 'body1="pin" body2="left" anchor="0.1 0.2 0.3"'
    text = WELDED.format(f'<weld name="W" {ends} torquescale="0"/>')
    for body, site in (("pin", '<site name="one" pos="0.1 0 0" euler="1 2 3"/>'), ("left", '<site name="two" pos="0.5 0 0.4"/>')):
        text = re.sub(rf'(<body name="{body}"[^>]*>)', rf"\1{site}", text)
    described = parse(named("welded.xml", text)).description
    assert [loop.type for loop in described.loops] == ["spherical"]


def test_joint_equalities_of_an_mjcf_are_gear_pairs_about_the_drawn_pose():
    pairs = '<joint joint1="B" joint2="A" polycoef="0 -2 0 0 0"/><joint joint1="B" joint2="D" polycoef="0.1 4 0 0 0"/>'
    file = named("geared.xml", WELDED.format(pairs))
    mimics = {joint.name: joint.mimic for joint in parse(file).description.joints}
    assert (mimics["B"].leader, mimics["B"].multiplier, mimics["B"].offset) == ("A", -2, 0)
    assert (mimics["D"].leader, mimics["D"].multiplier, mimics["D"].offset) == ("B", 0.25, -0.025)  # turned round: B follows A already
    file = named("held.xml", WELDED.format('<joint joint1="B"/>'))
    assert parse(file).description.joints[1].type == "fixed"


MJCF_REFUSED = [
    ('<joint joint1="B" joint2="A" polycoef="0 1 2 0 0"/>', "joint_0.>: joints that follow .* by a polynomial"),
    ('<connect body1="nobody" anchor="0 0 0"/>', "MuJoCo cannot read it: .*nobody"),
    ('<conect body1="pin" anchor="0 0 0"/>', "MuJoCo cannot read it: .*conect"),
]


@pytest.mark.parametrize(("equality", "message"), MJCF_REFUSED)
def test_what_an_mjcf_says_otherwise_is_refused_by_name(equality, message):
    with pytest.raises(UrdfError, match=message):
        pp.load(named("bad.xml", WELDED.format(equality)))


def test_what_acts_in_mujoco_and_not_here_is_warned_of():
    text = WELDED.format('<weld body1="pin" body2="left" active="false"/>')
    tendon = '<tendon><fixed stiffness="3"><joint joint="A" coef="1"/></fixed></tendon>'
    text = text.replace("<equality>", f'{tendon}<option gravity="0 0 -1"/><equality>')
    found = [(remark.severity, remark.problem) for remark in parse(named("more.xml", text)).remarks]
    assert ("warning", "springs, dampers, friction, limits and inertia of 1 tendons are not read") in found
    assert ("warning", "the gravity of the file is not read") in found
    assert ("note", 'it is left out, as active="false" says') in found


def test_what_mujoco_warns_of_is_passed_on_and_leaves_no_file(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    text = WELDED.format("").replace('<body name="left"', '<site name="s" rgba="nan 0 0 1"/><body name="left"')
    (found,) = parse(named("nan.xml", text)).remarks
    assert (found.severity, found.problem) == ("warning", "MuJoCo warns: XML contains a 'NaN'. Please check it carefully.")
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")
