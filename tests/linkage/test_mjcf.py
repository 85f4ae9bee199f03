"""What is read of an MJCF: keyframes, free joints, equalities, springs and actuators, against MuJoCo's own kinematics and forces."""

import numpy as np
import pinocchio as pin
import pytest

from pinpress.common.errors import UrdfError
from pinpress.linkage.loading import parse

mujoco = pytest.importorskip("mujoco")

MASS = '<inertial pos="0.1 0 0.02" mass="2" diaginertia="0.01 0.02 0.025"/>'


def read(tmp_path, content):
    """MuJoCo's model of an MJCF with this content, and the document that our reader makes of it."""
    file = tmp_path / "robot.xml"
    file.write_text(f'<mujoco model="robot"><compiler angle="radian"/>{content}</mujoco>', encoding="utf-8")
    return mujoco.MjModel.from_xml_path(str(file)), parse(str(file))


def placements(document, coordinates):
    """Poses of all links by Pinocchio at coordinates by the names of joints, all others at zero."""
    model = pin.buildModelFromXML(document.text.decode())
    q = pin.neutral(model)
    for joint, position in coordinates.items():
        slot = model.joints[model.getJointId(joint)]
        q[slot.idx_q : slot.idx_q + slot.nq] = [position] if slot.nq == 1 else [np.cos(position), np.sin(position)]
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return {frame.name: data.oMf[k] for k, frame in enumerate(model.frames) if frame.type == pin.BODY}


def home(document):
    """The coordinates in ``<home>``."""
    return {joint.get("name"): joint.number("position", np.nan) for each in document.robot.all("home") for joint in each.all("joint")}


def forward(model, qpos=None, qvel=None):
    data = mujoco.MjData(model)
    data.qpos[:] = model.qpos0 if qpos is None else qpos
    data.qvel[:] = 0 if qvel is None else qvel
    mujoco.mj_forward(model, data)
    return data


TREE = f"""<worldbody><body name="base" pos="0.1 0.2 0.3" euler="0.1 0.2 0.3">{{free}}{MASS}
  <body name="arm" pos="0.2 0 0.1" euler="0.5 0 0.2">
    <joint name="A" axis="0 1 0" pos="0.02 0 0.01" ref="0.4"/><joint name="B" axis="1 0 1" pos="0 0.05 0" ref="-0.2"/>{MASS}
    <body name="fork" pos="0.3 0 0"><joint name="C" type="ball" pos="0.01 0.02 0"/>{MASS}
      <body name="tip" pos="0.1 0 0"><joint name="D" type="slide" axis="0 0.6 0.8" ref="0.05"/><joint name="E" axis="0 0 1"/>{MASS}</body>
    </body></body></body></worldbody>"""
KEYS = """<keyframe><key name="first" qpos="{} 0.1 0.2 1 0 0 0 0.3 0.4"/>
  <key name="{}" qpos="{} -0.3 0.6 0.5 0.1 -0.7 0.5 -0.2 1.1"/></keyframe>"""
PLACES = "1 2 3 1 0 0 0", "0.5 -1 2 0.6 0 0.8 0"


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize(("name", "key"), [("home", 1), ("second", 0), (None, None)])
def test_the_linkage_starts_in_the_keyframe_home_else_in_the_first_else_as_drawn(tmp_path, free, name, key):
    keys = "" if name is None else KEYS.format(PLACES[0] if free else "", name, PLACES[1] if free else "")
    model, document = read(tmp_path, TREE.format(free='<freejoint name="float"/>' if free else "") + keys)
    data = forward(model, None if key is None else model.key_qpos[key])
    places = placements(document, home(document))
    for body in ("base", "arm", "fork", "tip"):
        there = data.body(body)
        if body in ("base", "fork", "arm"):  # the frame of a link is that of its joint, which may stand beside MuJoCo's frame of the body
            assert places[body].rotation == pytest.approx(there.xmat.reshape(3, 3), abs=1e-12)
        centre = pin.buildModelFromXML(document.text.decode())
        joint = centre.frames[centre.getFrameId(body, pin.BODY)]
        lever = centre.inertias[joint.parentJoint].lever
        if joint.parentJoint:  # a fixed base is part of the universe
            assert places[body].act(joint.placement.actInv(lever)) == pytest.approx(there.xipos, abs=1e-12)
    assert [each.name for each in document.description.joints if each.type == "floating"] == (["float"] if free else [])


def test_joints_at_zero_need_no_home(tmp_path):
    _, document = read(tmp_path, TREE.replace('ref="0.4"', "").replace('ref="-0.2"', "").replace('ref="0.05"', "").format(free=""))
    assert home(document) == {}


BOX = f'<body name="box" pos="0.3 0.1 0.2" euler="0.3 0.2 0.1"><freejoint/>{MASS}<site name="on" pos="0.1 0 0" euler="0 1 0"/></body>'
WELDS = [
    '<weld body1="box"/>',
    '<weld body1="world" body2="box" relpose="1 2 3 0.6 0 0 0.8"/>',
    '<weld body1="box" body2="world" relpose="1 2 3 0.6 0 0 0.8" anchor="0.1 0.2 0.3"/>',
    '<weld body1="world" body2="box" relpose="1 2 3 2 0 1 0"/>',
    '<weld body1="world" body2="box" relpose="0 0 0 0 0 0 0" anchor="0.1 0.2 0.3"/>',
    '<weld site1="at" site2="on"/>',
    '<weld site1="on" site2="at"/>',
]


@pytest.mark.parametrize("weld", WELDS)
def test_a_free_body_that_is_welded_to_the_world_is_fixed_there(tmp_path, weld):
    arm = f'<body name="arm"><joint name="A" axis="0 1 0"/>{MASS}</body>'
    world = f'<worldbody><site name="at" pos="1 0.5 2" euler="0.4 0.5 0.6"/>{arm}{BOX}</worldbody>'
    model, document = read(tmp_path, f"{world}<equality>{weld}</equality>")
    (joint,) = [joint for joint in document.description.joints if joint.child == "box"]
    assert (joint.type, document.description.loops) == ("fixed", ())
    place = placements(document, {})["box"]
    turned = pin.Quaternion(place.rotation)
    data = forward(model, [0.0, *place.translation, turned.w, turned.x, turned.y, turned.z])
    assert np.abs(data.efc_pos[data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)]).max() < 1e-9
    with pytest.raises(UrdfError, match='<body name="box">: a free body that nothing joins to the others'):
        read(tmp_path, world)


CHAIN = "".join(
    f'<body name="b{k}" pos="{k} 0 0"><joint name="{name}" axis="0 1 0" ref="{ref}"/>{MASS}</body>'
    for k, (name, ref) in enumerate({"p": 0.1, "q": -0.2, "r": 0.3, "s": 0.0}.items())
)
TENDONS = """<tendon><fixed name="one"><joint joint="p" coef="1"/><joint joint="q" coef="-0.5"/></fixed>
  <fixed name="two"><joint joint="r" coef="2"/><joint joint="s" coef="3"/></fixed></tendon>"""
EQUALITIES = [
    ('<joint joint1="p" joint2="q" polycoef="0.1 -2 0 0 0"/>', "q"),
    ('<joint joint1="p" joint2="q"/><joint joint1="p" joint2="r" polycoef="0.2 4 0 0 0"/>', "q"),
    ('<joint joint1="p" polycoef="0.7 0 0 0 0"/>', ""),
    ('<joint joint1="p" joint2="q" polycoef="0.7 0 0 0 0"/>', "q"),
    ('<tendon tendon1="one" polycoef="0.3 0 0 0 0"/>', "q"),
    ('<tendon tendon1="one" tendon2="two" polycoef="0.3 0.5 0 0 0"/>', "q r s"),
    ('<joint joint1="s" joint2="r"/><tendon tendon1="one" tendon2="two" polycoef="0.3 0.5 0 0 0"/>', "q r"),
]


@pytest.mark.parametrize(("equalities", "leaders"), EQUALITIES)
def test_equalities_of_joints_and_tendons_are_zero_in_mujoco_where_they_hold_here(tmp_path, equalities, leaders):
    model, document = read(tmp_path, f"<worldbody>{CHAIN}</worldbody>{TENDONS}<equality>{equalities}</equality>")
    moved = dict(zip(leaders.split(), (0.4, -0.7, 1.1), strict=False))
    relations = {}  # by the joint that each determines
    for joint in document.description.joints:
        if joint.mimic:
            relations[joint.name] = {joint.name: 1.0, joint.mimic.leader: -joint.mimic.multiplier}, joint.mimic.offset
    for relation in document.robot.all("relation"):
        coefficients = {each.get("name"): each.number("coefficient", np.nan) for each in relation.all("joint")}
        assert next(iter(coefficients.values())) == 1.0
        relations[next(iter(coefficients))] = coefficients, relation.number("offset", np.nan)
    left = dict(relations)
    while left:
        name = next(name for name, (coefficients, _) in left.items() if {*coefficients} - {name} <= moved.keys())
        coefficients, offset = left.pop(name)
        moved[name] = offset - sum(value * moved[other] for other, value in coefficients.items() if other != name)
    data = forward(model, [moved.get(name, 0.0) for name in "pqrs"])
    if "0.7" in equalities:  # p is held, beside its ref, 0.1
        assert next(joint for joint in document.description.joints if joint.name == "p").type == "fixed"
        data = forward(model, [0.1 + pin.log3(placements(document, {})["b0"].rotation)[1], *(moved.get(name, 0.0) for name in "qrs")])
    assert len(data.efc_pos) == equalities.count("/>")
    assert np.abs(data.efc_pos).max() < 1e-12


def test_springs_dampers_and_armatures_are_those_with_which_mujoco_computes(tmp_path):
    attributes = 'stiffness="20" springref="0.5" damping="0.3" armature="0.04"'
    arm = f'<body name="arm"><joint name="A" axis="0 1 0" ref="0.2" {attributes}/>{MASS}</body>'
    actuator = '<actuator><motor joint="A" gear="3" armature="0.01" damping="0.02"/></actuator>'
    model, document = read(tmp_path, f"<worldbody>{arm}</worldbody>{actuator}")
    (spring,), (armature,) = document.robot.all("joint_spring"), document.robot.all("armature")
    stiffness, reference, damping = (spring.number(name, np.nan) for name in ("stiffness", "reference", "damping"))
    data = forward(model, [0.9], [1.5])
    assert -stiffness * (0.9 - reference) - damping * 1.5 == pytest.approx(float(data.qfrc_passive[0]), rel=1e-12)
    mass = np.zeros((1, 1))
    mujoco.mj_fullM(model, data, mass)
    assert 0.02 + 2 * (0.1**2 + 0.02**2) + armature.number("inertia", np.nan) == pytest.approx(mass.item(), rel=1e-12)


LIMITS = [  # attributes of the joint, actuators, largest effort
    ("", '<motor joint="A"/>', None),
    ("", '<motor joint="A" gear="-4" ctrlrange="-2 3"/>', 12.0),
    ("", '<motor joint="A" gear="4" ctrlrange="-2 3" forcerange="-1 1"/>', 4.0),
    ("", '<position joint="A" kp="50" ctrlrange="-2 3"/>', None),
    ("", '<position joint="A" kp="50" ctrlrange="-2 3" forcerange="-7 7"/>', 7.0),
    ("", '<general joint="A" gainprm="5" ctrlrange="-2 2"/><motor joint="A" ctrlrange="-1 1"/>', 11.0),
    ('actuatorfrcrange="-3 3"', '<motor joint="A" ctrlrange="-8 8"/>', 3.0),
]


@pytest.mark.parametrize(("joint", "actuators", "effort"), LIMITS)
def test_the_limits_of_actuators_limit_the_effort_of_their_joint(tmp_path, joint, actuators, effort):
    arm = f'<body name="arm"><joint name="A" axis="0 1 0" {joint}/>{MASS}</body>'
    model, document = read(tmp_path, f"<worldbody>{arm}</worldbody><actuator>{actuators}</actuator>")
    limits = [limit.number("effort", np.nan) for limit in document.robot.all("joint")[0].all("limit")]
    assert limits == ([] if effort is None else [effort])
    if effort is not None:
        data = mujoco.MjData(model)
        for sign in (-100, 100):
            data.ctrl[:] = sign
            mujoco.mj_forward(model, data)
            assert abs(data.qfrc_actuator[0]) <= effort * (1 + 1e-12)


def test_actuators_on_joints_and_tendons_of_joints_drive_and_others_are_named_once(tmp_path):
    sites = f'<site name="here"/><body name="free_ball" pos="0 0 1"><joint name="ball" type="ball"/>{MASS}</body>'
    actuators = (
        '<motor joint="s"/><position tendon="one"/><motor joint="s"/><motor name="thrust" site="here"/><general name="glue" body="b1"/>'
        '<motor name="spin" joint="ball"/>'
    )
    _, document = read(tmp_path, f"<worldbody>{CHAIN}{sites}</worldbody>{TENDONS}<actuator>{actuators}</actuator>")
    assert document.description.drivers == ("s", "p")
    assert [(each.severity, each.problem) for each in document.remarks if "ball joint is made" not in each.problem] == [
        ("note", "it pulls at 1 p + -0.5 q: joint p drives, with its own torque or force in results"),
        ("warning", "actuators that act on no hinge or slide are not read: thrust, glue, spin"),
    ]


def test_the_joint_that_drives_follows_no_other(tmp_path):
    equality = '<equality><joint joint1="p" joint2="q" polycoef="0 -2 0 0 0"/></equality>'
    _, document = read(tmp_path, f'<worldbody>{CHAIN}</worldbody>{equality}<actuator><motor joint="p"/></actuator>')
    mimics = {joint.name: joint.mimic.leader for joint in document.description.joints if joint.mimic}
    assert mimics == {"q": "p"}


def test_a_joint_that_an_equality_holds_does_not_drive(tmp_path):
    actuators = '<actuator><motor name="pull" joint="p"/><motor joint="q"/></actuator>'
    _, document = read(tmp_path, f'<worldbody>{CHAIN}</worldbody><equality><joint joint1="p"/></equality>{actuators}')
    assert document.description.drivers == ("q",)
    assert [each.problem for each in document.remarks] == ["an equality holds joint 'p': it does not drive"]


@pytest.mark.parametrize("inertial", [True, False])
def test_missing_meshes_are_left_out_where_bodies_have_inertias(tmp_path, inertial):
    texture = '<texture name="t" type="2d" file="t.png"/><material name="m" texture="t"/>'
    mesh = f'<asset>{texture}<mesh name="shape" file="shape.stl"/></asset>'
    shapes = '<geom type="mesh" mesh="shape"/><geom size="0.1" material="m"/>'
    arm = f'<body name="arm"><joint name="A" axis="0 1 0"/>{MASS * inertial}{shapes}</body>'
    file = tmp_path / "meshes.xml"
    table = f'<body name="table"><geom type="mesh" mesh="shape"/>{arm}</body>'  # its inertia counts nowhere: it does not move
    file.write_text(f'<mujoco>{mesh}<worldbody><geom type="mesh" mesh="shape"/>{table}</worldbody></mujoco>', encoding="utf-8")
    if inertial:
        remarks = parse(str(file)).remarks
        assert [each.problem for each in remarks] == ["it is read without meshes and textures, because files are missing"]
    else:
        with pytest.raises(
            UrdfError, match=r"'arm' comes from a mesh, .* cannot read it: .*(shape\.stl|t\.png)'; put the file there, or give "
        ):
            parse(str(file))


def test_links_and_hinges_of_balls_get_names_of_their_own(tmp_path):
    fork = f'<body name="b">{MASS}<joint name="C" type="ball"/></body><body name="b_1"><joint name="C_y" axis="0 1 0"/>{MASS}</body>'
    _, document = read(tmp_path, f"<worldbody>{fork}</worldbody>")
    joints = [(joint.name, joint.child) for joint in document.description.joints]
    assert joints == [("C_x", "b_1_2"), ("C_y_2", "b_2"), ("C_z", "b"), ("C_y", "b_1")]


@pytest.mark.parametrize("joint", ['stiffness="1 2"', 'damping="1 0 3"'])
def test_springs_and_dampers_that_are_not_linear_are_refused(tmp_path, joint):
    with pytest.raises(UrdfError, match='<joint name="A">: stiffness or damping grows with position or speed'):
        read(tmp_path, f'<worldbody><body name="arm"><joint name="A" axis="0 1 0" {joint}/>{MASS}</body></worldbody>')
