"""Pinocchio's own constraint models of the loops: closed, moving with the loops, with multipliers that are the bearing forces, by sign."""

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators.spatial_linkages import bennett, bricard, four_bar
from support.oracles import cassie
from support.sampling import rest_exhaustive

import pinpress as pp

ANGLES = np.array([-0.3, 0.1, 0.35])
SPATIAL = {"bennett": bennett, "bricard": bricard, "cassie": cassie.urdf, "turntable": lambda: four_bar("revolute", table="table")}
SPATIAL |= {f"four_bar_{kind}": lambda kind=kind: four_bar(kind) for kind in ("spherical", "revolute", "fixed")}
FAMILIES = (*pp.presses(), *SPATIAL)
ALWAYS = ("crank_slide", "jf75g_125_two_point", "bennett", "cassie", "four_bar_revolute")  # the others are exhaustive


@pytest.fixture(scope="module", params=rest_exhaustive(FAMILIES, *ALWAYS))
def press(request):
    made = SPATIAL.get(request.param)
    return texts.load(made()) if made else texts.shipped(request.param)


@pytest.fixture(scope="module")
def reactions(press):
    several = len(press.drivers) > 1
    small = 0.2 if several else 1.0
    angle = small * (np.multiply.outer(ANGLES, np.linspace(1.0, 0.5, len(press.drivers))) if several else ANGLES)
    motion = pp.servo_cycle(press, angle=angle, speed=np.full(angle.shape, 3.0), acceleration=np.full(angle.shape, -7.0))
    return pp.inverse_dynamics(press, motion)


def worked_out(press, q, v):
    """Anchors with their data at a state, joint accelerations zero; and the joints' placements."""
    model, data = press.model, press.model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
    anchors = press.constraint_models()
    datas = [anchor.createData() for anchor in anchors]
    for anchor, datum in zip(anchors, datas, strict=True):
        anchor.calc(model, data, datum)
    return anchors, datas, data


def of_bearings(press, anchors, placements, force, moment):
    """Multipliers of the anchors from forces and moments of the loops, of link1 on link2, in world axes."""
    multipliers = []
    for loop in press.loops:
        ours = [anchor for anchor in anchors if anchor.name == loop.name]
        turned = [placements[anchor.joint1_id].rotation @ anchor.joint1_placement.rotation for anchor in ours]
        if loop.type == "revolute":
            axis = turned[0][:, 0]
            far = np.cross(moment[loop.name], axis) / press.size
            multipliers += [turned[0].T @ (force[loop.name] - far), turned[1].T @ far]
        else:
            multipliers.append(turned[0].T @ force[loop.name])
            if loop.type == "fixed":
                multipliers.append(turned[0].T @ moment[loop.name])
    return np.concatenate([np.empty(0), *multipliers])


def driving_efforts(press, reactions, i):
    """Joint efforts (nv,) of drives and gear pairs at state i."""
    efforts = np.zeros(press.model.nv)
    efforts[list(press.driver_indices)] = reactions.driving_torque[i]
    for coupling in press.couplings:
        efforts[[coupling.follower, coupling.leader]] += reactions.coupling_torque[coupling.name][i]
    return efforts


def test_loops_are_closed_and_stay_so(press, reactions):
    """Gaps, their rates and their second derivatives are zero in a closed motion, to rounding of the terms that they consist of."""
    motion = reactions.motion
    for q, v, a in zip(motion.q, motion.v, motion.a, strict=True):
        anchors, datas, data = worked_out(press, q, v)
        for anchor, datum in zip(anchors, datas, strict=True):
            jacobian = anchor.jacobian(press.model, data, datum).reshape(-1, press.model.nv)
            drift = datum.constraint_acceleration_error
            assert np.abs(datum.constraint_position_error).max() <= 1e-11
            assert np.abs(jacobian @ v).max() <= 1e-11 * (np.abs(jacobian) @ np.abs(v)).max()
            assert np.abs(jacobian @ a + drift).max() <= 1e-11 * ((np.abs(jacobian) @ np.abs(a)).max() + np.abs(drift).max())


def test_bearing_forces_are_multipliers(press, reactions):
    """M a + h = efforts + J' multipliers with forces and moments of link1 on link2, of redundant loops too: 1e-11 of the peak effort."""
    motion, model = reactions.motion, press.model
    for i, (q, v, a) in enumerate(zip(motion.q, motion.v, motion.a, strict=True)):
        anchors, datas, data = worked_out(press, q, v)
        rows = [anchor.jacobian(model, data, datum).reshape(-1, model.nv) for anchor, datum in zip(anchors, datas, strict=True)]
        jacobian = np.concatenate([np.empty((0, model.nv)), *rows])
        force, moment = ({name: values[i] for name, values in each.items()} for each in (reactions.bearing_force, reactions.bearing_moment))
        multipliers = of_bearings(press, anchors, data.oMi, force, moment)
        tree = pin.rnea(model, model.createData(), q, v, a)
        left = tree - driving_efforts(press, reactions, i) - jacobian.T @ multipliers
        peak = np.abs(tree).max() + (np.abs(jacobian.T) @ np.abs(multipliers)).max()
        assert np.abs(left).max() <= 1e-11 * peak


def test_constraint_dynamics(press, reactions):
    """Pinocchio's accelerations under the driving torques are the motion's, and its contact forces, of link2 on link1, are the opposite of
    the bearing forces, where rigid mechanics decides them: 1e-9 of the peaks, as redundant rows leave pivots to rounding."""
    motion, model = reactions.motion, press.model
    kinds = pin.StdVec_RigidConstraintModel([pin.convertToRigidConstraintModel(model, each) for each in press.constraint_models()])
    names = [each.name for each in press.constraint_models()]
    peak = np.abs(motion.a).max()
    for i, (q, v, a) in enumerate(zip(motion.q, motion.v, motion.a, strict=True)):
        data, datas = model.createData(), pin.StdVec_RigidConstraintData([kind.createData() for kind in kinds])
        pin.initConstraintDynamics(model, data, kinds, datas)
        settings = pin.ProximalSettings(0.0, 1e-13, 1e-9, 30)
        found = pin.constraintDynamics(model, data, q, v, driving_efforts(press, reactions, i), kinds, datas, settings)
        assert np.abs(found - a).max() <= 1e-9 * peak
        for loop in press.loops:
            force = np.zeros(3)
            for name, kind, datum in zip(names, kinds, datas, strict=True):
                if name == loop.name:
                    turned = data.oMi[kind.joint1_id].rotation @ kind.joint1_placement.rotation
                    force -= turned @ np.array(datum.contact_force.linear)
            open_to_idle = reactions.indeterminate[loop.name][:3]
            off = reactions.indeterminate_axes @ (force - reactions.bearing_force[loop.name][i])
            assert np.abs(off[~open_to_idle]).max(initial=0.0) <= 1e-9 * np.abs(reactions.bearing_force[loop.name]).max()


def test_kinds_and_names(press):
    anchors = press.constraint_models()
    wanted = {"spherical": ["Point"], "revolute": ["Point"] * 2, "fixed": ["Frame"]}
    assert [(each.name, each.shortname()) for each in anchors] == [
        (loop.name, f"{kind}AnchorConstraintModel") for loop in press.loops for kind in wanted[loop.type]
    ]


def test_what_a_caller_changes_is_his():
    press = texts.shipped("zxn2_3000b")
    first, second = press.constraint_models()[0], press.constraint_models()[0]
    first.name, first.joint1_placement = "mine", pin.SE3.Random()
    for anchor in (second, press.constraint_models()[0]):
        assert anchor.name == "C"
        np.testing.assert_array_equal(anchor.joint1_placement.translation, press.loops[0].point1)


def test_a_tree_has_none(tmp_path):
    (tmp_path / "disc.urdf").write_text(
        '<robot name="disc"><link name="frame"/><link name="disc"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
        'ixz="0" iyz="0"/></inertial></link><joint name="O" type="continuous"><parent link="frame"/><child link="disc"/></joint></robot>'
    )
    assert pp.load(tmp_path / "disc.urdf", driver="O").constraint_models() == ()
