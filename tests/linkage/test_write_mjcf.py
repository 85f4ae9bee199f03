"""Linkages written for MuJoCo: MuJoCo's own terms give the same torques, and read again the linkage is the same."""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from reference.robots.cases import CASES
from support import texts
from support.exploring import examples
from support.generators import spatial_linkages
from support.generators.machine_elements import MESHING
from support.generators.random_linkages import drawn, linkages, servo
from support.generators.spatial_crank_slide import SPATIAL
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.engines.constraints import Curve, Relation
from pinpress.kinematics.check import check

mujoco = pytest.importorskip("mujoco")

from support.oracles.mujoco_terms import MujocoTerms  # noqa: E402  behind the check that MuJoCo is installed

SAME = 1e-12  # of lengths: placements are multiplied up and taken apart again


def written(press, folder):
    """The MJCF of a linkage."""
    return pp.write_mjcf(press, folder / "written.xml")


def compare_torques(press, path, motion, reactions):
    """The torques of the first state of a motion are those of MuJoCo's terms, whose equalities are as many as ours."""
    terms = MujocoTerms(path, press, motion.joint_position[0], motion.v[0])
    hinges = sum(loop.type == "revolute" for loop in press.loops)
    assert (terms.model.nv, terms.model.neq) == (press.model.nv, len(press.loops) + hinges + len(press.relations))
    assert terms.gap() < max(1e-9 * press.size, press.structure.tolerance)
    accelerations = {name: reactions.motion.a[0, press.joints.index(name)] for name in press.motors}
    rank = press.structure.rank_tolerance  # larger than 1e-9 where rounded numbers contradict each other
    torque = terms.torque(accelerations, press.held, len(press.passive), rank)
    ours = np.ravel(reactions.driving_torque[0] if len(press.drivers) > 1 else reactions.driving_torque[:1])[: len(press.motors)]
    scale = max(np.abs(torque).max(), 1e-9 * np.abs(terms.data.qfrc_bias).max())
    np.testing.assert_allclose(ours, torque, rtol=0, atol=(1e-9 if rank <= 1e-9 else 1e-6) * scale)


def compare_start(press, path):
    """MuJoCo starts in the closed pose, which is its keyframe, at our coordinates."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for start in (model.qpos0, model.key("home").qpos):
        data.qpos[:] = start
        mujoco.mj_forward(model, data)
        rows = data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        closed = max(1e-12 * max(press.size, 1.0), press.structure.tolerance)
        assert np.abs(data.efc_pos[rows]).max(initial=0.0) < closed + 1e-9 * (start is model.qpos0)
    at_home = dict(zip(press.joints, press.closed, strict=True))
    for k in range(model.njnt):
        if model.jnt_type[k] != int(mujoco.mjtJoint.mjJNT_FREE):
            assert model.key("home").qpos[model.jnt_qposadr[k]] == pytest.approx(at_home[model.joint(k).name], abs=1e-15)


def contents(press):
    """Numbers of a linkage by names, in world axes where the frame of a joint is not unique."""
    model, size = press.model, press.size
    for name in press.joints:
        joint = model.getJointId(name)
        place, inertia = model.jointPlacements[joint], model.inertias[joint]
        yield f"{name} placed", np.concatenate([place.translation / size, place.rotation.ravel()])
        yield f"{name} axis", press.axes[joint - 1].direction
        heaviest = max(1.0, *(each.mass for each in model.inertias))  # [kg]
        yield f"{name} mass", np.array([inertia.mass, *(inertia.mass * inertia.lever / size)]) / heaviest
        yield f"{name} inertia", inertia.inertia.ravel() / (heaviest * max(1.0, size) ** 2)
        yield f"{name} armature", np.array(model.armature[joint - 1])
        yield f"{name} at home", np.array(press.closed[joint - 1])
    for loop in press.loops:
        yield f"{loop.name} points", np.concatenate([loop.point1, loop.point2]) / size
        if loop.type == "revolute":
            yield f"{loop.name} axes", np.concatenate([loop.rotation1[:, 0], loop.rotation2[:, 0]])
        if loop.type == "fixed":
            yield f"{loop.name} turned", loop.rotation1 @ loop.rotation2.T
    for relation in press.relations:
        joints = {press.joints[joint]: value / next(iter(relation.coefficients.values())) for joint, value in relation.coefficients.items()}
        yield f"relation {sorted(joints)}", np.array([joints[name] for name in sorted(joints)]) / joints[min(joints)]
        yield f"relation {sorted(joints)} offset", np.array(relation.offset / joints[min(joints)])
    for spring in press.joint_springs:
        yield f"{spring.joint} spring", np.array([spring.stiffness, spring.reference if spring.stiffness else 0.0, spring.damping])


def compare_read_again(press, path, raised=(), **options):
    """The same linkage, apart from its ground, which MuJoCo calls world, and from inertias that had to be raised."""
    back = pp.load(path, gravity=tuple(press.model.gravity.linear), slide=press.slide, **options)
    assert sorted(back.joints) == sorted(press.joints)
    assert (back.drivers, back.held, back.passive, back.slide) == (press.drivers, press.held, press.passive, press.slide)
    assert set(press.links) <= set(back.links)
    assert [(loop.name, loop.type) for loop in back.loops] == [(loop.name, loop.type) for loop in press.loops]
    before, now = dict(contents(press)), dict(contents(back))
    assert before.keys() == now.keys()
    for what, numbers in before.items():
        if what in raised:
            continue
        assert np.abs(numbers - now[what]).max(initial=0.0) <= SAME, what


def compare(press, folder, motion=None, **options):
    """All comparisons; the torques in the first state of a motion, by default near the home pose."""
    path = written(press, folder)
    if motion is None:
        rng, count = np.random.default_rng(len(press.joints)), len(press.drivers)
        home = press.closed[list(press.driver_indices)]
        motion = moved(press, home + 0.1 * rng.uniform(0.5, 1, count), rng.uniform(1, 2, count), rng.uniform(1, 2, count))
    compare_start(press, path)
    compare_torques(press, path, motion, pp.inverse_dynamics(press, motion))
    compare_read_again(press, path, **options)


def moved(press, at, speed, acceleration):
    """The motion of one state of all drivers."""
    at, speed, acceleration = (np.reshape(values, (1, -1) if len(press.drivers) > 1 else -1) for values in (at, speed, acceleration))
    return pp.servo_cycle(press, at, speed=speed, acceleration=acceleration)


@pytest.mark.parametrize("name", pp.presses())
def test_shipped_presses(name, tmp_path):
    compare(texts.shipped(name), tmp_path)


@pytest.mark.parametrize("name", pp.presses())
def test_loops_stay_closed_in_a_simulation_by_mujoco(name, tmp_path):
    press = texts.shipped(name)
    model = mujoco.MjModel.from_xml_path(str(written(press, tmp_path)))
    data = mujoco.MjData(model)
    for _ in range(100):
        mujoco.mj_step(model, data)
    rows = data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    assert np.abs(data.efc_pos[rows]).max() < 1e-4 * press.size
    assert data.time == pytest.approx(0.2)


SPACE = {
    "bennett": spatial_linkages.bennett(),
    "bricard": spatial_linkages.bricard(),
    "crank_slide": SPATIAL,
    "ball": spatial_linkages.four_bar("spherical"),
    "hinge": spatial_linkages.four_bar("revolute"),
    "weld": spatial_linkages.four_bar("fixed"),
    "two_drivers": spatial_linkages.four_bar("revolute", table="table"),
}


@pytest.mark.parametrize("name", rest_exhaustive(SPACE, *SPACE.keys() - {"bricard"}))
def test_linkages_in_space(name, tmp_path):
    compare(texts.load(SPACE[name]), tmp_path)


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@examples(10)
@given(spec=linkages(most=3))
def test_random_linkages(spec):
    drawing = drawn(spec)
    assume(drawing)
    with tempfile.TemporaryDirectory() as folder:
        press = texts.load(drawing.urdf("crank"))
        compare(press, Path(folder), pp.servo_cycle(press, **servo(press, np.random.default_rng(spec.seed), states=1)))


@pytest.mark.one_in(13)
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize("case", [pytest.param(case, id=case.id) for case in CASES])
def test_small_robots(case, tmp_path):
    press = case.press
    raised = [f"{joint} inertia" for joint in press.joints] if "flat_inertia" in case.file else []
    options = {name: case.load[name] for name in {"base"} & case.load.keys()}
    compare(press, tmp_path, moved(press, case.at, case.speed, case.acceleration), raised=raised, **options)


INERTIAL = (
    '<inertial><origin xyz="0.1 0 0.02"/><mass value="2"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.025"/></inertial>'
)
LOOKS = """<visual><origin xyz="0.1 0 0" rpy="0.3 0 0"/><geometry><box size="0.1 0.2 0.3"/></geometry>
  <material name="red"><color rgba="1 0 0 1"/></material></visual>
  <visual><geometry><cylinder radius="0.05" length="0.4"/></geometry></visual>"""


def chain(more=""):
    """Three arms one after the other, of which the second one is two links, and whose turns are related."""
    lines = ['<robot name="chain"><link name="hall"/>']
    for k, (name, parent) in enumerate((("a", "hall"), ("b", "a"), ("world", "cover"))):
        axis, limit = ("0 -1 0", "0 0 1", "0.6 0 0.8")[k], '<limit lower="-2" upper="2" effort="30" velocity="1"/>'
        lines.append(
            f'<link name="{name}">{INERTIAL}{LOOKS if k == 0 else ""}</link>'
            f'<joint name="turn_{name}" type="revolute"><parent link="{parent}"/><child link="{name}"/>'
            f'<origin xyz="0.2 0 0.1" rpy="0.1 0.2 {k}"/><axis xyz="{axis}"/>{limit}</joint>'
        )
    lines.append(f'<link name="cover">{INERTIAL}</link><joint name="screws" type="fixed"><parent link="b"/><child link="cover"/>')
    lines.append('<origin xyz="0.1 0 0" rpy="0 0 0.5"/></joint>')
    joints = {"turn_world": 1.0, "turn_a": 2.0, "turn_b": -0.5}
    terms = "".join(f'<joint name="{name}" coefficient="{value}"/>' for name, value in joints.items())
    lines.append(f'<relation name="sum" offset="0.3">{terms}</relation>')
    lines.append('<joint_spring joint="turn_a" stiffness="20" reference="0.4" damping="0.3"/><armature joint="turn_b" inertia="0.05"/>')
    lines += [f'<transmission name="{name}"><joint name="turn_{name}"/></transmission>' for name in "ab"]
    return "\n".join([*lines, more, "</robot>"])


def test_relations_springs_rotors_limits_welded_links_and_shapes(tmp_path):
    press = texts.load(chain())
    path = written(press, tmp_path)
    compare_start(press, path)
    motion = moved(press, [0.2, -0.3], [1.0, 2.0], [3.0, -4.0])
    compare_torques(press, path, motion, pp.inverse_dynamics(press, motion))
    back = pp.load(path)
    assert back.links == ("world", "hall", "a", "b", "cover", "world_2")  # MuJoCo keeps the name of its world to itself
    before, now = dict(contents(press)), dict(contents(back))
    assert before.keys() == now.keys()
    for what, numbers in before.items():
        assert np.abs(numbers - now[what]).max(initial=0.0) <= SAME, what
    for limit in ("lowerPositionLimit", "upperPositionLimit", "upperEffortLimit"):
        assert getattr(back.model, limit)[:2] == pytest.approx(getattr(press.model, limit)[:2])
    model = mujoco.MjModel.from_xml_path(str(path))
    assert model.geom_size[:2] == pytest.approx(np.array([[0.05, 0.1, 0.15], [0.05, 0.2, 0.0]]))
    assert not model.geom_contype.any()
    assert model.geom_rgba[0] == pytest.approx([1, 0, 0, 1])


def test_a_press_that_is_drawn_elsewhere_and_balanced(tmp_path):
    press = texts.shipped("zxn2_3000b").drawn_at(1.0)
    inertias = list(press.model.inertias)
    inertias[1] = inertias[1] + inertias[1]
    compare(press.with_inertias(inertias), tmp_path)


def test_names_of_second_points_are_not_those_of_other_bearings(tmp_path):
    text = spatial_linkages.four_bar("revolute").replace('"D"', '"C_axis"')
    press = texts.load(text)
    model = mujoco.MjModel.from_xml_path(str(written(press, tmp_path)))
    assert [model.equality(k).name for k in range(model.neq)] == ["C", "C_axis_2"]
    compare(press, tmp_path)


def test_an_arm_without_loops_in_its_keyframe_on_a_base_without_moments_of_inertia(tmp_path):
    file = tmp_path / "arm.xml"
    base = '<inertial pos="0.1 0 0" mass="2" diaginertia="0 0 0"/>'
    arm = '<body name="arm"><joint name="A" axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0.1"/></body>'
    home = '<keyframe><key name="home" qpos="0.3"/></keyframe>'
    file.write_text(
        f'<mujoco><worldbody><body name="base">{base}{arm}</body></worldbody>{home}<actuator><motor joint="A"/></actuator></mujoco>'
    )
    compare(pp.load(file), tmp_path)
    assert "arm.xml" in str(check(file))
    assert not check(file).errors


@pytest.mark.parametrize("name", MESHING)
def test_teeth_and_threads_are_equalities_that_move_and_drive_alike(name, tmp_path):
    press = pp.build(**MESHING[name])
    assert press.meshes
    with pytest.warns(pp.PinpressWarning, match="MuJoCo has no teeth and threads: .* their losses and their forces on bearings"):
        compare(press, tmp_path)


def test_a_cam_is_refused(tmp_path):
    press = texts.shipped("crank_slide")
    cam = Relation("slide_guide", {press.joints.index("slide_guide"): 1.0}, curve=Curve(0, lambda x: (x, x, x)))
    with pytest.raises(pp.PinpressError, match="MuJoCo has no cams, such as 'slide_guide'"):
        written(replace(press, relations=(cam,)), tmp_path)
    assert not list(tmp_path.iterdir())
