"""Linkages of which motors move a part: springs and rotors in joints, free accelerations, static equilibrium, floating bases."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline
from support.generators.sprung_trees import sprung_tree

import pinpress as pp
from pinpress.linkage.description import JointSpring

ROBOTS = Path(__file__).parents[1] / "reference" / "robots"
BASE = ("root_x", "root_y", "root_z", "root_rz", "root_ry", "root_rx")


def five_bar(*springs: JointSpring, gravity=(0.0, 0.0, -9.81)) -> pp.Linkage:
    """The five-bar of which turn_b is passive."""
    press = pp.load(ROBOTS / "19_no_driver.urdf", drivers=["turn_a", "turn_b"], gravity=gravity)
    return replace(press, passive=("turn_b",), joint_springs=springs)


def sprung_five_bar() -> pp.Linkage:
    return five_bar(JointSpring("knee_a", 12.0, 0.1, 0.02))


def hopper(gravity=(0.0, 0.0, -9.81)) -> pp.Linkage:
    press = pp.load(ROBOTS / "18_floating_base.urdf", base="floating", drivers=["turn_a", "turn_b", *BASE], gravity=gravity)
    return replace(press, passive=BASE)


def any_state(press: pp.Linkage, rng: np.random.Generator) -> pp.Motion:
    place, speed, acceleration = rng.uniform(-1, 1, (3, 1, len(press.drivers))) * [[[0.1]], [[2.0]], [[5.0]]]
    return pp.servo_cycle(press, place, speed=speed, acceleration=acceleration)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_free_accelerations_and_torques_of_random_trees_are_those_of_mujoco(seed, tmp_path):
    pytest.importorskip("mujoco")
    from support.oracles.mujoco_dynamics import free_motion

    press = sprung_tree(seed, tmp_path, joints=9 + seed % 3, loops=1 + seed % 2)
    motion = any_state(press, np.random.default_rng(seed))
    count = len(press.motors)
    expected = free_motion(press, motion.joint_position[0], motion.v[0], motion.crank_acceleration[0, :count])
    for engine in press.engines:
        forces = pp.inverse_dynamics(press, motion, engine=engine)
        scale = np.abs(expected.efforts).max()
        np.testing.assert_allclose(forces.motion.a[0], expected.acceleration, atol=1e-9 * np.abs(expected.acceleration).max())
        np.testing.assert_allclose(forces.driving_torque[0, :count], expected.efforts, atol=1e-9 * scale)
        np.testing.assert_allclose(forces.driving_torque[0, count:], 0.0, atol=1e-10 * scale)
        assert np.abs(forces.power_residual).max() < 1e-12


@pytest.mark.parametrize("name", ["zxn2_3000b", "crank_slide"])
def test_all_engines_agree_on_springs_and_rotors_in_joints(name):
    press = pp.load(name)
    model = press.model.copy()
    model.armature[:] = np.linspace(1.0, 2.0, model.nv)
    springs = tuple(JointSpring(joint, 1e4, 0.1 * k, 30.0) for k, joint in enumerate(press.joints))
    changed = replace(press, model=model, joint_springs=springs)
    motion = pp.cycle(changed, 7.0, points=24)
    friction = {"O" if name == "crank_slide" else "A": pp.loads.Friction(0.1, 0.05)}
    plane, space, pinocchio = (pp.inverse_dynamics(changed, motion, friction=friction, engine=engine) for engine in changed.engines)
    plain = pp.inverse_dynamics(press, motion, friction=friction)
    scale = np.abs(plane.driving_torque).max()
    assert np.abs(plane.driving_torque - plain.driving_torque).max() > 0.01 * scale
    assert np.abs(plane.power_residual).max() < 1e-12
    for other in (space, pinocchio):
        np.testing.assert_allclose(other.driving_torque, plane.driving_torque, atol=1e-11 * scale)
        for bearing in press.bearings:
            in_plane = (
                plane.bearing_force[bearing] - (plane.bearing_force[bearing] @ press.planarity.normal)[:, None] * press.planarity.normal
            )
            np.testing.assert_allclose(
                other.bearing_force[bearing] @ press.planarity.axes[::2].T, in_plane @ press.planarity.axes[::2].T, atol=1e-9 * scale
            )
            np.testing.assert_allclose(
                other.bearing_moment[bearing] @ press.planarity.normal,
                plane.bearing_moment[bearing] @ press.planarity.normal,
                atol=1e-9 * scale,
            )


def test_a_motor_and_a_spring():
    press = sprung_five_bar()
    motion = pp.servo_cycle(press, [[0.25, -0.15]], speed=[[1.2, -0.7]], acceleration=[[3.0, 0.0]])
    forces = pp.inverse_dynamics(press, motion)
    np.testing.assert_allclose(forces.driving_torque, [[3.76462034, 0.0]], atol=1e-9)
    np.testing.assert_allclose(forces.motion.crank_acceleration, [[3.0, 58.22628394]], rtol=1e-10)
    given = pp.inverse_dynamics(press, forces.motion, passive="given")
    np.testing.assert_allclose(given.driving_torque, forces.driving_torque, atol=1e-12)


def test_a_floating_base_at_rest_and_held():
    press = hopper()
    motion = pp.servo_cycle(press, [[0.25, -0.15]], speed=[[1.2, -0.7]], acceleration=[[3.0, 4.0]])
    free, held = pp.inverse_dynamics(press, motion), pp.inverse_dynamics(press, motion, passive="given")
    np.testing.assert_allclose(free.driving_torque[0, :2], [0.006510758648, 0.01081461152], rtol=1e-9)
    acceleration = free.motion.a[0, [press.joints.index(joint) for joint in BASE]]
    np.testing.assert_allclose(acceleration, [0.05465089152, 0, -9.787072993, 0, 2.012452185, 0], atol=1e-9)
    np.testing.assert_allclose(held.driving_torque[0, :2], [-1.534725584, 1.69914532], rtol=1e-9)
    np.testing.assert_allclose(held.bearing_force["root_rx"][0], [-0.8086415531, 0.0, 53.35177828], atol=1e-8)
    np.testing.assert_allclose(held.bearing_moment["root_rx"][0], [0.0, -0.3343495943, 0.0], atol=1e-9)


def test_equilibrium_follows_the_motor():
    press = sprung_five_bar()
    at_rest = pp.inverse_dynamics(press, pp.servo_cycle(press, [0.25], speed=[0.0], acceleration=[0.0]), passive="equilibrium")
    np.testing.assert_allclose(at_rest.motion.crank_angle[0], [0.25, 0.3672696236], rtol=1e-9)
    with pytest.raises(pp.PinpressError, match=r"ends near turn_a 22\.8959 deg"):
        pp.inverse_dynamics(press, pp.servo_cycle(press, [0.5], speed=[0.0], acceleration=[0.0]), passive="equilibrium")


@pytest.mark.exhaustive
def test_the_rates_of_an_equilibrium_are_those_of_its_path():
    press, time = sprung_five_bar(), np.linspace(0.0, 1.0, 33)
    forces = pp.inverse_dynamics(press, pp.servo_cycle(press, 0.3 * time, time=time), passive="equilibrium")
    of_time = make_interp_spline(time, forces.motion.crank_angle[:, 1], 11)
    inside = slice(8, -8)
    np.testing.assert_allclose(forces.motion.crank_speed[inside, 1], of_time(time, 1)[inside], rtol=1e-8)
    np.testing.assert_allclose(forces.motion.crank_acceleration[inside, 1], of_time(time, 2)[inside], rtol=1e-6)
    still = pp.servo_cycle(press, forces.motion.crank_angle, speed=np.zeros((33, 2)), acceleration=np.zeros((33, 2)))
    np.testing.assert_allclose(pp.inverse_dynamics(press, still, passive="given").driving_torque[:, 1], 0.0, atol=1e-11)


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"friction": {"knee_a": pp.loads.Friction(0.1, 0.01)}}, "depend on Coulomb friction"),
        ({"passive": "hold"}, "write 'free', 'given', 'equilibrium'"),
        ({"passive": "equilibrium", "loads": [pp.loads.PointForce("rod_a", lambda motion: [0.0, 0.0, 1.0])]}, "takes constant forces"),
    ],
)
def test_what_passive_coordinates_do_not_take_is_refused(given, reason):
    press = five_bar()
    motion = pp.servo_cycle(press, [0.25], speed=[0.5], acceleration=[0.0])
    with pytest.raises(pp.PinpressError, match=reason):
        pp.inverse_dynamics(press, motion, **given)


def test_a_passive_coordinate_without_inertia_is_refused():
    press = hopper()
    model = press.model.copy()
    for joint in range(1, model.njoints):
        model.inertias[joint].mass *= 0.0
        model.inertias[joint].inertia *= 0.0
    light = replace(press, model=model)
    with pytest.raises(pp.PinpressError, match=r"passive coordinate 'root_\w+' of hopper moves no mass"):
        pp.inverse_dynamics(light, pp.servo_cycle(light, [[0.2, 0.1]], speed=[[1.0, 1.0]], acceleration=[[0.0, 0.0]]))


@pytest.mark.parametrize(
    ("name", "at", "speed", "acceleration", "torque"),
    [
        pytest.param("16_rod_cut_in_middle.urdf", [0.3], [2.0], [5.0], [4.925070774], marks=pytest.mark.exhaustive),
        ("17_legs_between_two_balls.urdf", [0.02, -0.015], [0.1, 0.2], [1.0, -1.0], [3.407297337, 2.479555658]),
    ],
)
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_balanced_rods_take_the_same_torque_held_and_free_to_spin(name, at, speed, acceleration, torque):
    held = pp.load(ROBOTS / name)
    free = replace(held, held=(), drivers=(*held.motors, *held.held), passive=held.held)
    for press in (held, free):
        several = (np.array(each)[None] if len(press.drivers) > 1 else np.array(each) for each in (at, speed, acceleration))
        given, by, change = several
        forces = pp.inverse_dynamics(press, pp.servo_cycle(press, given, speed=by, acceleration=change))
        np.testing.assert_allclose(np.ravel(forces.driving_torque)[: len(at)], torque, rtol=1e-8)
        assert all(np.abs(moment).max() < 1e-8 for moment in forces.held_moment.values())
    assert len(held.held) == len(held.freedoms) > 0


def test_viscous_friction_acts_while_coordinates_are_free():
    press = five_bar()
    motion = pp.servo_cycle(press, [[0.25, -0.15]], speed=[[1.2, -0.7]], acceleration=[[3.0, 0.0]])
    friction = {"turn_b": pp.loads.Friction(viscous=0.3), "tip": pp.loads.Friction(viscous=0.1)}
    rubbed, plain = pp.inverse_dynamics(press, motion, friction=friction), pp.inverse_dynamics(press, motion)
    assert abs(rubbed.motion.a - plain.motion.a).max() > 1.0
    assert abs(rubbed.power_residual).max() < 1e-12
    damped = replace(press, joint_springs=(JointSpring("turn_b", damping=0.3),))
    of_joint = pp.inverse_dynamics(press, motion, friction={"turn_b": friction["turn_b"]})
    np.testing.assert_allclose(of_joint.motion.a, pp.inverse_dynamics(damped, motion).motion.a, rtol=1e-12)
