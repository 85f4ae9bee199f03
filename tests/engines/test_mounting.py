"""Poses with far open loops are closed, and near ones in the assembly that they are of."""

import numpy as np
import pinocchio as pin
import pytest
from support.generators.robot_legs import five_bar, mechanisms
from support.sampling import rest_exhaustive

from pinpress.common.errors import PinpressError
from pinpress.engines.constraints import LoopJoint
from pinpress.engines.mounting import CLOSED, Mounting
from pinpress.engines.spatial.engine import SpatialEngine
from pinpress.engines.structure import build_structure
from pinpress.linkage.assembly import follow_drivers

MECHANISMS = mechanisms()
STARTS = 10
BEGINS = rest_exhaustive([0, 10, 20], 0)  # of the starts


def drawn_open(structure, by, start):
    """A closed pose with every joint moved by up to ``by`` rad, slides by up to 0.3 times as much in lengths."""
    share = np.array([1.0 if axis.turns else 0.3 * structure.size for axis in structure.axes])
    return by * share * np.random.default_rng(start).uniform(-1.0, 1.0, structure.model.nv)


def mounted(structure, pose):
    """The closed pose with the drivers held, else with all joints free."""
    mounting = Mounting(structure)
    held = mounting.close(pose, structure.drivers)
    return held if held.misfit <= CLOSED else mounting.close(pose)


@pytest.mark.one_in(7)
@pytest.mark.parametrize("by", [0.1, 0.4, 1.5, *(pytest.param(by, marks=pytest.mark.exhaustive) for by in (0.2, 0.8, 1.2))])
@pytest.mark.parametrize("begin", BEGINS)
@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda each: each.name)
def test_every_open_pose_is_closed(mechanism, begin, by):
    structure = mechanism.structure
    engine = SpatialEngine(structure)
    poses = [mounted(structure, drawn_open(structure, by, start)) for start in range(begin, begin + STARTS)]
    assert max(pose.misfit for pose in poses) <= CLOSED
    assert engine.gaps(np.array([pose.position for pose in poses]).T).max() <= 1e-9 * structure.size


@pytest.mark.parametrize("by", [0.2, pytest.param(0.1, marks=pytest.mark.exhaustive)])
@pytest.mark.parametrize("begin", BEGINS)
@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda each: each.name)
def test_near_poses_are_closed_in_their_assembly(mechanism, begin, by):
    """It is the one that the closed pose reaches if its drivers are moved straight to where they are in the open pose."""
    structure, engine = mechanism.structure, SpatialEngine(mechanism.structure)
    reached, missed = 0, 0
    for start in range(begin, begin + STARTS):
        pose = drawn_open(structure, by, start)
        try:
            right = follow_drivers(engine, structure, np.zeros_like(pose), pose[None, list(structure.drivers)], mechanism.name)[:, 0]
        except PinpressError:
            continue  # the drivers lock on the way
        reached += 1
        missed += Mounting(structure).apart(Mounting(structure).close(pose, structure.drivers).position, right).max() > 1e-6
    assert reached >= 0.8 * STARTS
    assert missed == 0


@pytest.mark.parametrize("kind", ["revolute", "fixed"])
def test_slopes_of_wide_rotations_are_those_of_differences(kind):
    """Of loops that are open by up to half a turn."""
    model = pin.Model()
    for k, axis in enumerate((pin.JointModelRX(), pin.JointModelRY(), pin.JointModelRZ())):
        model.addJoint(k, axis, pin.SE3.Random(), f"j{k}")
    turned = pin.SE3.Random().rotation
    structure = build_structure(model, (LoopJoint("l", kind, 0, np.ones(3), np.eye(3), 3, np.ones(3), turned, 0),), (), (0,))
    mounting, random = Mounting(structure), np.random.default_rng(0)
    for _ in range(20):
        x, way = random.uniform(-1.4, 1.4, (2, 3))
        change = (mounting.equations(x + 1e-6 * way)[0] - mounting.equations(x - 1e-6 * way)[0]) / 2e-6
        np.testing.assert_allclose(mounting.equations(x)[1] @ way, change, atol=1e-7 * np.linalg.norm(way))


def test_assemblies_of_a_five_bar():
    """With the cranks held the rods meet on either side."""
    structure = five_bar()
    mounting = Mounting(structure)
    poses = mounting.assemblies(np.zeros(4), structure.drivers, 3.0)
    assert len(poses) == 2
    (told,) = mounting.told_apart([poses[1], poses[0]], 1, structure.passive_joints)
    ((name, value),) = told.items()
    assert value == poses[1][int(name[1:]) - 1]


def test_loops_that_cannot_close_end_near_the_least_gap():
    """One rod of a five-bar is longer than all other links together."""
    structure = five_bar()
    (loop,), others = structure.loops, 0.3 + 2 * 0.25 + np.hypot(0.3, 0.25)
    long = LoopJoint(loop.name, loop.type, 2, np.array([-1.2, 0.0, 0.25]), np.eye(3), 4, loop.point2, np.eye(3), 0)
    apart = Mounting(build_structure(structure.model, (long,), (), (0, 2)))
    gaps = [apart.close(start).misfit * apart.structure.size for start in np.random.default_rng(0).uniform(-1, 1, (5, 4))]
    least = np.hypot(1.2, 0.25) - others
    assert min(gaps) == pytest.approx(least, rel=1e-6)
    assert max(gaps) < 1.3 * least
