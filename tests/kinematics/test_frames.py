"""Places and Jacobians of frames, compared with differences and with Pinocchio's Jacobian of the open tree and its loops."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators import spatial_linkages
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.engines.pinocchio.equations import OneConfiguration

ROBOTS = Path(__file__).resolve().parents[2] / "docs" / "robots"
STEP = 1e-7


def robot(name):
    return pp.load(ROBOTS / f"{name}.urdf")


MADE = {
    "leg": lambda: (robot("leg"), "foot", 0.5),
    "platform": lambda: (robot("platform"), "tool", 0.05),
    "bennett": lambda: (texts.load(spatial_linkages.bennett()), None, 0.3),
    "bricard": lambda: (texts.load(spatial_linkages.bricard()), None, 0.3),
    "press": lambda: (pp.load("zxn2_3000b"), None, 3.0),
}


@pytest.fixture(params=rest_exhaustive(MADE, *MADE.keys() - {"bricard"}))
def case(request):
    press, frame, reach = MADE[request.param]()
    positions = np.random.default_rng(7).uniform(-reach, reach, (9, len(press.drivers)))
    return press, frame or press.links[-1], positions if len(press.drivers) > 1 else positions[:, 0]


def test_jacobians_are_differences_of_placements(case):
    press, frame, positions = case
    jacobian, placed = press.jacobian(frame, positions), press.placements(frame, positions)
    assert jacobian.shape == (9, 6, len(press.drivers))
    for k in range(len(press.drivers)):
        step = STEP * (np.eye(len(press.drivers))[k] if len(press.drivers) > 1 else 1.0)
        slope = (press.placements(frame, positions + step) - press.placements(frame, positions - step)) / (2 * STEP)
        spin = slope[:, :3, :3] @ placed[:, :3, :3].swapaxes(1, 2)
        # closing to 1e-15 of the size leaves some 1e-8 in a difference over 2e-7
        np.testing.assert_allclose(jacobian[:, :3, k], slope[:, :3, 3], rtol=0, atol=1e-7)
        np.testing.assert_allclose(jacobian[:, 3:, k], np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1), rtol=0, atol=1e-7)


def test_jacobians_are_those_of_pinocchio(case):
    """J of the frame in the open tree, times the columns of the pseudo-inverse of the loops' Jacobian and the drivers."""
    press, frame, positions = case
    jacobian, q, nv = press.jacobian(frame, positions), press.configuration(positions), len(press.joints)
    motion = pp.servo_cycle(press, positions, speed=0.0)
    equations, data, index = OneConfiguration(press.structure), press.model.createData(), press.model.getFrameId(frame, pin.BODY)
    for state in range(len(positions)):
        loops = equations.at(motion.joint_position[state]).columns
        selected = np.eye(nv)[list(press.driver_indices)]
        influence = np.linalg.pinv(np.vstack([loops, selected]))[:, -len(press.drivers) :]
        tree = pin.computeFrameJacobian(press.model, data, q[state], index, pin.LOCAL_WORLD_ALIGNED)
        np.testing.assert_allclose(jacobian[state], tree @ influence, rtol=0, atol=1e-10 * max(1.0, float(np.abs(tree).max())))
    pin.framesForwardKinematics(press.model, data, q[-1])
    np.testing.assert_allclose(press.placements(frame, positions)[-1], data.oMf[index].homogeneous, rtol=0, atol=1e-13)
    np.testing.assert_allclose(press.jacobian(frame, joints=motion.joint_position), jacobian, rtol=1e-12, atol=1e-13)


def test_a_frame_moves_as_its_jacobian_says_and_its_force_is_held_by_the_drivers():
    platform = robot("platform")
    time = np.linspace(0.0, 1.0, 50)
    strokes = 0.03 * np.sin(2 * np.pi * np.outer(time, np.ones(6)) + np.arange(6))
    motion = pp.servo_cycle(platform, strokes, time=time)
    jacobian = platform.jacobian("tool", joints=motion.joint_position)
    velocity = np.einsum("nij,nj->ni", jacobian, motion.crank_speed)
    places = platform.placements("tool", joints=motion.joint_position)[:, :3, 3]
    np.testing.assert_allclose(velocity[5:-5, :3], np.gradient(places, time, axis=0)[5:-5], rtol=0, atol=2e-3)  # second differences
    force = np.array([30.0, -20.0, 50.0])
    loaded = pp.inverse_dynamics(platform, motion, [pp.loads.PointForce("tool", force)])
    unloaded = pp.inverse_dynamics(platform, motion)
    np.testing.assert_allclose(
        loaded.driving_torque - unloaded.driving_torque, -np.einsum("nij,i->nj", jacobian[:, :3], force), rtol=0, atol=1e-9
    )


def test_one_position_and_the_ground():
    leg = robot("leg")
    assert leg.jacobian("foot", [0.1, 0.2]).shape == (6, 2)
    assert leg.placements("foot", [0.1, 0.2]).shape == (4, 4)
    np.testing.assert_array_equal(leg.jacobian("trunk", [0.1, 0.2]), np.zeros((6, 2)))
    np.testing.assert_array_equal(leg.placements("trunk", [[0.1, 0.2]])[0], np.eye(4))


def test_what_is_no_frame_or_position_is_refused():
    leg = robot("leg")
    motion = pp.servo_cycle(leg, [[0.1, 0.2]], speed=0.0)
    with pytest.raises(pp.UnknownNameError, match="no link 'fot', did you mean 'foot'"):
        leg.jacobian("fot", [0.1, 0.2])
    with pytest.raises(pp.PinpressError, match=r"drivers has shape \(3,\): give \(2,\) or \(n, 2\)"):
        leg.jacobian("foot", [0.1, 0.2, 0.3])
    for given in ({}, {"drivers": [0.1, 0.2], "joints": motion.joint_position}):
        with pytest.raises(pp.PinpressError, match=r"give drivers=\.\.\., the positions of the drivers, or joints"):
            leg.jacobian("foot", **given)
    with pytest.raises(pp.PinpressError, match=r"joints leave a loop of leg open by .* m in state 0"):
        leg.placements("foot", joints=motion.joint_position + 0.1)


def test_where_drivers_do_not_determine_the_joints_there_is_no_jacobian():
    """Two couplers of a five-bar in one line: their pin can go up or down while the cranks stand."""
    inertial = '<inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>'
    pins = [("A", "frame", "left", 0), ("B", "frame", "right", 0.5), ("P", "left", "left_rod", 0.1), ("Q", "right", "right_rod", -0.1)]
    links = "".join(f'<link name="{link}">{inertial}</link>' for _, _, link, _ in pins)
    joints = "".join(
        f'<joint name="{name}" type="continuous"><parent link="{one}"/><child link="{other}"/><origin xyz="{x} 0 0"/>'
        '<axis xyz="0 -1 0"/></joint>'
        for name, one, other, x in pins
    )
    ends = '<link1 link="left_rod" xyz="0.15 0 0.2"/><link2 link="right_rod" xyz="-0.15 0 0.2"/>'
    loop = f'<loop_joint name="C" type="spherical">{ends}</loop_joint>'
    drives = "".join(f'<transmission name="{name}"><joint name="{name}"/></transmission>' for name in "AB")
    press = texts.load(f'<robot name="five_bar"><link name="frame"/>{links}{joints}{loop}{drives}</robot>')
    drawn = np.arctan2(0.2, 0.15)  # of the rods
    straight = {"A": np.pi / 2, "B": -np.pi / 2, "P": -np.pi / 2 - drawn, "Q": np.pi / 2 + drawn}
    with pytest.raises(pp.SingularityError, match="five_bar locks in state 0, where its drivers do not determine how it moves"):
        press.jacobian("left_rod", joints=[[straight[name] for name in press.joints]])
