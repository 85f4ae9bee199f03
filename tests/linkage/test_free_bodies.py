"""Free bodies of files: held, or split into six joints; and springs and rotors in joints of files."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import pinpress as pp

ROBOTS = Path(__file__).parents[1] / "reference" / "robots"
HOPPER = (ROBOTS / "18_floating_base.urdf").read_text()
BASE = ("root_x", "root_y", "root_z", "root_rz", "root_ry", "root_rx")
MOTORS = ["turn_a", "turn_b"]
STANCE = '<loop_joint name="foot" type="fixed"><link1 link="rod_a" xyz="0.31 0 0"/><link2 link="ground" xyz="{}" rpy="{}"/></loop_joint>'


def changed(tmp_path: Path, *pairs: tuple[str, str], text: str = HOPPER) -> Path:
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "changed.urdf"
    path.write_text(text)
    return path


def free_base_pose(press: pp.Linkage, link: str, coordinates: np.ndarray) -> pin.SE3:
    """Place of a link whose six coordinates are these, the others 0."""
    x = np.zeros(press.model.nv)
    x[[press.joints.index(joint) for joint in press.joints if joint.startswith("root_")]] = coordinates
    data = press.model.createData()
    pin.framesForwardKinematics(press.model, data, pin.integrate(press.model, pin.neutral(press.model), x))
    return data.oMf[press.model.getFrameId(link, pin.BODY)]


def test_a_free_joint_is_held_with_a_warning():
    with pytest.warns(pp.PinpressWarning, match=r"""<joint name="root">: it leaves link 'frame' free.*base='floating'"""):
        press = pp.load(ROBOTS / "18_floating_base.urdf")
    assert press.joints == ("turn_a", "knee_a", "turn_b", "knee_b")


def test_six_joints_are_three_travels_then_yaw_pitch_and_roll():
    press = pp.load(ROBOTS / "18_floating_base.urdf", base="floating", drivers=[*MOTORS, *BASE])
    assert set(BASE) < set(press.joints)
    assert press.slide is None
    at = np.array([0.1, -0.2, 0.3, 0.5, -0.6, 0.7])
    place = free_base_pose(press, "frame", at)
    np.testing.assert_allclose(place.translation, at[:3] + np.array([0.0, 0.0, 0.5]))
    np.testing.assert_allclose(pin.rpy.matrixToRpy(place.rotation), at[:2:-1], atol=1e-12)


def test_a_root_with_mass_floats(tmp_path):
    free = HOPPER[HOPPER.index('<joint name="root"') : HOPPER.index("</joint>") + len("</joint>")]
    path = changed(tmp_path, (free, ""), ('<link name="ground"/>', ""))
    six = [f"base{name.removeprefix('root')}" for name in BASE]
    press = pp.load(path, base="floating", drivers=[*MOTORS, *six])
    assert press.root == "world"
    assert press.joints[:6] == tuple(six)
    with pytest.raises(pp.UrdfError, match="has no mass"):
        pp.load(changed(tmp_path, ('<mass value="3.0"/>', '<mass value="0"/>'), text=path.read_text()), base="floating")
    with pytest.raises(pp.PinpressError, match="write 'fixed' or 'floating'"):
        pp.load(path, base="free")


def test_a_foot_on_the_ground_determines_the_base(tmp_path):
    drawn = pp.load(ROBOTS / "18_floating_base.urdf", base="floating", drivers=[*MOTORS, *BASE])
    data = drawn.model.createData()
    pin.framesForwardKinematics(drawn.model, data, pin.neutral(drawn.model))
    tip = data.oMf[drawn.model.getFrameId("rod_a", pin.BODY)] * pin.SE3(np.eye(3), np.array([0.31, 0.0, 0.0]))
    at, turned = (" ".join(map(repr, map(float, each))) for each in (tip.translation, pin.rpy.matrixToRpy(tip.rotation)))
    path = changed(tmp_path, ("</robot>", STANCE.format(at, turned) + "</robot>"))
    press = pp.load(path)  # the base is a body of the loops, however it is loaded
    assert (press.mobility, press.drivers, press.passive) == (2, ("turn_a", "turn_b"), ())
    forces = pp.inverse_dynamics(press, pp.servo_cycle(press, [[0.1, -0.1]], speed=[[1.0, 1.0]], acceleration=[[0.0, 0.0]]))
    weight = 9.81 * sum(inertia.mass for inertia in press.model.inertias)
    still = pp.inverse_dynamics(press, pp.servo_cycle(press, [[0.1, -0.1]], speed=[[0.0, 0.0]], acceleration=[[0.0, 0.0]]))
    np.testing.assert_allclose(still.bearing_force["foot"][0], [0.0, 0.0, -weight], atol=1e-9)
    assert np.abs(forces.power_residual).max() < 1e-12


@pytest.mark.parametrize(
    ("element", "problem"),
    [
        ('<joint_spring joint="knee_x" stiffness="1"/>', "no joint 'knee_x', did you mean 'knee_b'"),
        ('<joint_spring joint="knee_a" stiffness="-1"/>', "stiffness is negative"),
        ('<armature joint="knee_a" inertia="-1"/>', "inertia is negative"),
        ('<armature joint="knee_a" inertia="1"/><armature joint="knee_a" inertia="1"/>', "a second <armature> of joint 'knee_a'"),
        ('<armature joint="knee_a"/>', "has no inertia"),
        ('<joint_spring joint="knee_a" stiffness="1N"/>', "is not a finite number"),
    ],
)
def test_wrong_springs_and_rotors_are_refused(tmp_path, element, problem):
    path = changed(tmp_path, ("</robot>", element + "</robot>"), text=(ROBOTS / "19_no_driver.urdf").read_text())
    with pytest.raises(pp.UrdfError, match=problem):
        pp.load(path, drivers=MOTORS)


def test_springs_and_rotors_are_written(tmp_path):
    press = pp.load(ROBOTS / "19_no_driver.urdf", drivers=MOTORS)
    two, one = (pp.JointSpring("knee_a", 12.0, 0.1, 0.02), pp.JointSpring("turn_b", 3.0)), (pp.JointSpring("knee_b", damping=1.0),)
    for springs in (two, one, ()):
        model = press.model.copy()
        model.armature[1:3] += [0.01, 0.02]
        changed_press = replace(press, model=model, joint_springs=springs)
        again = pp.load(pp.write_urdf(changed_press, tmp_path / "again.urdf"))
        assert again.joint_springs == springs
        np.testing.assert_array_equal(again.model.armature, model.armature)
        press = again
