"""Linkages of Pinocchio models: the torque of the model's own equations of motion with multipliers, whatever joints it has."""

import warnings

import numpy as np
import pinocchio as pin
import pytest
from reference.robots.cases import FOLDER
from support import texts
from support.generators.spatial_linkages import bennett, four_bar, null_space

import pinpress as pp
from pinpress.engines.constraints import gear

SAME = 1e-11  # of the largest value: states of joints in chains are found by another way


def unit(rng):
    axis = rng.normal(size=3)
    return axis / np.linalg.norm(axis)


def composite(*joints):
    whole = pin.JointModelComposite()
    for joint in joints:
        whole.addJoint(joint, pin.SE3.Random())
    return whole


JOINTS = {
    "RX": lambda rng: pin.JointModelRX(),
    "RUBY": lambda rng: pin.JointModelRUBY(),
    "PZ": lambda rng: pin.JointModelPZ(),
    "R": lambda rng: pin.JointModelRevoluteUnaligned(unit(rng)),
    "RUBX": lambda rng: pin.JointModelRUBX(),
    "P": lambda rng: pin.JointModelPrismaticUnaligned(unit(rng)),
    "H": lambda rng: pin.JointModelHelicalUnaligned(unit(rng), 0.1),
    "HX": lambda rng: pin.JointModelHX(-0.2),
    "universal": lambda rng: pin.JointModelUniversal(*(axis.copy() for axis in np.linalg.qr(rng.normal(size=(3, 3)))[0].T[:2])),
    "ball": lambda rng: pin.JointModelSpherical(),
    "zyx": lambda rng: pin.JointModelSphericalZYX(),
    "planar": lambda rng: pin.JointModelPlanar(),
    "translation": lambda rng: pin.JointModelTranslation(),
    "composite": lambda rng: composite(pin.JointModelRX(), pin.JointModelPY(), pin.JointModelRUBZ()),
    "balls": lambda rng: composite(pin.JointModelSpherical(), pin.JointModelRY()),
    "free": lambda rng: pin.JointModelFreeFlyer(),
}


class Model:
    """Chains of joints from the frame, whose last bodies are held together by a loop each."""

    def __init__(self, chains, loops, seed, elsewhere=False):
        rng = np.random.default_rng(seed)
        pin.seed(seed)
        self.model = model = pin.Model()
        model.name = "made_up"
        ends = {"ground": 0}
        for chain, kinds in chains.items():
            joint = ends[kinds[0]]
            for k, kind in enumerate(kinds[1:]):
                joint = model.addJoint(joint, JOINTS[kind](rng), pin.SE3.Random(), f"{chain}{k}")
                model.appendBodyToJoint(joint, pin.Inertia.FromBox(*rng.uniform(0.1, 1, 4)), pin.SE3.Random())
            ends[chain] = joint
        model.addBodyFrame("tool", joint, pin.SE3.Random(), 0)
        model.armature = rng.uniform(0, 1, model.nv)
        self.q = pin.neutral(model)
        for joint in list(model.joints)[1:]:
            turned = {"JointModelSpherical": range(4), "JointModelFreeFlyer": range(3, 7)}.get(joint.shortname(), range(0))
            self.q[[joint.idx_q + k for k in turned]] = pin.Quaternion(pin.SE3.Random().rotation).coeffs()[: len(turned)]
            if turned or joint.shortname() == "JointModelPlanar" or "balls" in sum(chains.values(), ()):
                model.armature[joint.idx_v : joint.idx_v + joint.nv] = 0.0  # which is left out
        if elsewhere:
            self.q = pin.integrate(model, self.q, rng.uniform(-1, 1, model.nv))
        data = model.createData()
        pin.forwardKinematics(model, data, self.q)
        self.constraints, self.anchors = [], []
        for k, (end1, end2, kind) in enumerate(loops):
            place, joints = pin.SE3.Random(), (ends[end1], ends[end2])
            places = [data.oMi[joint].inverse() * place for joint in joints]
            contact = pin.ContactType.CONTACT_3D if kind == "point" else pin.ContactType.CONTACT_6D
            of_both = joints[0], places[0], joints[1], places[1]
            self.constraints.append(pin.RigidConstraintModel(contact, model, *of_both, pin.ReferenceFrame.LOCAL))
            self.constraints[-1].name = f"loop{k}"
            self.anchors.append((pin.PointAnchorConstraintModel if kind == "point" else pin.FrameAnchorConstraintModel)(model, *of_both))

    def driving(self, drivers, acceleration, rng):
        """Speeds of the drivers, and their torque by the equations of motion with multipliers, at a random speed that the loops allow."""
        model, data, q = self.model, self.model.createData(), self.q
        pin.computeJointJacobians(model, data, q)
        datas = [anchor.createData() for anchor in self.anchors]
        base = np.eye(model.nv)[: 6 * (model.joints[1].shortname() == "JointModelFreeFlyer")]  # a free base is held

        def drift(v):
            pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
            for anchor, of in zip(self.anchors, datas, strict=True):
                anchor.calc(model, data, of)
            return np.concatenate([*(of.constraint_acceleration_error for of in datas), np.zeros(len(base))])

        drift(np.zeros(model.nv))
        rows = np.vstack([*(anchor.jacobian(model, data, of) for anchor, of in zip(self.anchors, datas, strict=True)), base])
        free = null_space(rows)
        v = free @ rng.normal(size=free.shape[1])
        chosen = np.eye(model.nv)[drivers]
        a = np.linalg.lstsq(np.vstack([rows, chosen]), np.concatenate([-drift(v), acceleration]))[0]
        effort = pin.rnea(model, data, q, v, a)
        torque = np.linalg.lstsq(np.vstack([rows, chosen]).T, effort)[0][len(rows) :]
        return v[drivers], torque


def driven(press, at, speed, acceleration):
    """Driving torque at one state."""
    shape = (1, len(at)) if len(at) > 1 else (1,)
    motion = pp.servo_cycle(press, np.reshape(at, shape), speed=np.reshape(speed, shape), acceleration=np.reshape(acceleration, shape))
    return np.ravel(pp.inverse_dynamics(press, motion).driving_torque)


CASES = {  # chains: where they begin, and their joints; loops; drivers
    "points": ({"a": ("ground", "RX", "R", "PZ", "RUBX")}, [("a", "ground", "point")], ["a0"]),
    "hinges": ({"a": ("ground", "RUBY", "universal", "R", "P", "ball")}, [("a", "ground", "frame")], ["a0", "a3"]),
    "planar": ({"a": ("ground", "RUBX", "planar", "P", "universal")}, [("ground", "a", "frame")], ["a0"]),
    "composite": ({"a": ("ground", "RX", "composite", "balls")}, [("a", "ground", "frame")], ["a0", "a1_2"]),
    "screws": ({"a": ("ground", "H", "HX", "R", "P")}, [("a", "ground", "point")], ["a0"]),
    "platform": (
        {"a": ("ground", "RX", "R"), "b": ("ground", "PZ", "universal"), "c": ("ground", "RUBY", "P", "R"), "d": ("ground", "free")},
        [("a", "d", "frame"), ("b", "d", "point"), ("c", "d", "point")],
        ["b0", "c0"],
    ),
    "base": (
        {"r": ("ground", "free"), "a": ("r", "RX", "R"), "b": ("r", "RUBY", "R", "PZ")},
        [("a", "b", "point")],
        ["a0", "b0"],
    ),
    "between": (
        {"a": ("ground", "RX", "R"), "b": ("a", "universal", "R"), "c": ("a", "translation")},
        [("b", "c", "point"), ("b", "ground", "point")],
        ["a0", "a1"],
    ),
}


def loaded(model, drivers, **more):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pp.PinpressWarning)  # random bodies are odd ones
        return pp.from_pinocchio(model.model, model.constraints, drivers, model.q, **more)


@pytest.mark.one_in(11)
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("seed", "elsewhere"), [(0, False), (1, False), (2, True), (3, True)])
def test_the_torque_is_that_of_the_model_with_multipliers(case, seed, elsewhere):
    chains, loops, drivers = CASES[case]
    model, rng = Model(chains, loops, seed, elsewhere), np.random.default_rng(seed)
    press = loaded(model, drivers)
    assert press.mobility == len(drivers)
    acceleration = rng.normal(size=len(drivers))
    places = [place_in_v(model.model, name) for name in drivers]
    speed, expected = model.driving(places, acceleration, rng)
    got = driven(press, press.closed[list(press.driver_indices)], speed, acceleration)
    np.testing.assert_allclose(got, expected, rtol=0, atol=SAME * np.abs(expected).max())


def place_in_v(model, name):
    """Of a single joint, or of the part of a composite one with this number."""
    joint, _, part = name.partition("_")
    return model.joints[model.getJointId(joint)].idx_v + (int(part) - 1 if part else 0)


def reactions(press):
    """Torque and bearing forces over one turn, or of one state of several drivers."""
    count = len(press.drivers)
    motion = (
        pp.cycle(press, speed=3.0, points=12)
        if count == 1
        else pp.servo_cycle(press, np.full((1, count), 0.02), speed=np.full((1, count), 2.0), acceleration=np.ones((1, count)))
    )
    result = pp.inverse_dynamics(press, motion)
    return [np.ravel(result.driving_torque), *(np.ravel(result.bearing_force[name]) for name in press.bearings)]


PRESSES = {name: lambda name=name: pp.load(name) for name in pp.presses()} | {
    "bennett": lambda: texts.load(bennett()),
    "bennett_frame": lambda: texts.load(four_bar("fixed")),
}


@pytest.mark.one_in(7)
@pytest.mark.parametrize("name", PRESSES)
def test_model_and_constraints_of_a_linkage_give_it_back(name):
    press = PRESSES[name]()
    again = pp.from_pinocchio(press.model, press.constraint_models(), press.drivers, relations=press.relations)
    assert (again.name, again.bearings, again.slide, set(again.links)) == (press.name, press.bearings, press.slide, set(press.links))
    assert [loop.type for loop in again.loops] == [loop.type for loop in press.loops]
    for got, expected in zip(reactions(again), reactions(press), strict=True):
        assert np.abs(got - expected).max() <= 1e-12 * max(np.abs(expected).max(), np.abs(reactions(press)[1]).max())
    rigid = pin.StdVec_RigidConstraintModel([pin.convertToRigidConstraintModel(press.model, each) for each in press.constraint_models()])
    assert pp.from_pinocchio(press.model, rigid, press.drivers, relations=press.relations).text.count(b"<loop_joint") == len(press.loops)


def test_a_mimic_joint_is_a_gear_pair():
    """As Pinocchio has it in a tree; with the loop that a second wheel would close the gears would lock."""
    text = """<robot name="gears"><link name="frame"/>
      <link name="wheel"><inertial><origin xyz="0.1 0 0"/><mass value="2"/>
        <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <link name="arm"><inertial><origin xyz="0.3 0 0"/><mass value="1"/>
        <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="A" type="revolute"><parent link="frame"/><child link="wheel"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="2" effort="3" velocity="4"/></joint>
      <joint name="B" type="revolute"><parent link="wheel"/><child link="arm"/><origin xyz="0.2 0 0" rpy="0.3 0 0"/><axis xyz="0 0.6 0.8"/>
        <limit lower="-9" upper="9" effort="1" velocity="1"/><mimic joint="A" multiplier="-2" offset="0.3"/></joint></robot>"""
    model = pin.buildModelFromXML(text, mimic=True)
    press = pp.from_pinocchio(model, drivers="A", q=[0.0])
    (pair,) = press.couplings
    assert (pair.multiplier, pair.offset, press.links) == (-2.0, 0.3, ("frame", "wheel", "arm"))
    limits = press.model.lowerPositionLimit[0], press.model.upperPositionLimit[0], press.model.effortLimit[0], press.model.velocityLimit[0]
    assert limits == (-1, 2, 3, 4)
    state = 0.4, 1.5, -2.0
    expected = pin.rnea(model, model.createData(), *(np.array([each]) for each in state))
    assert driven(press, *([each] for each in state)) == pytest.approx(expected, rel=1e-12)


def test_frames_are_links_by_their_names():
    model = Model(*CASES["points"][:2], seed=1)
    press = loaded(model, ["a0"])
    frame, data = press.frame_of("tool"), model.model.createData()
    assert press.joints[frame.parentJoint - 1] == "a3"
    pin.framesForwardKinematics(model.model, data, model.q)
    ours = press.model.createData()
    pin.framesForwardKinematics(press.model, ours, press.configuration(0.0))
    place = data.oMf[model.model.getFrameId("tool")]
    assert ours.oMf[press.model.getFrameId("tool")].isApprox(place, 1e-12)


@pytest.mark.parametrize(
    ("constraint", "message"),
    [
        (lambda model: pin.RigidConstraintModel(pin.ContactType.CONTACT_6D, model, 1, pin.SE3.Random(), 0, pin.SE3.Random()), ""),
        (lambda model: "loop", "constraint_models has 'loop': give a RigidConstraintModel"),
    ],
)
def test_what_is_no_bearing_is_refused(constraint, message):
    model = Model(*CASES["points"][:2], seed=1)
    if not message:
        message, moved = "'made_up' has a desired offset", constraint(model.model)
        moved.desired_contact_placement, moved.name = pin.SE3.Random(), "made_up"
        constraint = lambda _: moved  # noqa: E731
    with pytest.raises(pp.PinpressError, match=message):
        pp.from_pinocchio(model.model, [constraint(model.model)], "a0")


def test_joints_that_cannot_be_read_are_named():
    model = pin.Model()
    model.addJoint(0, pin.JointModelEllipsoid(1.0, 2.0, 3.0), pin.SE3.Identity(), "egg")
    with pytest.raises(pp.PinpressError, match="joint 'egg' is a Ellipsoid joint, which cannot be read"):
        pp.from_pinocchio(model)
    with pytest.raises(pp.PinpressError, match="model is 3: give a pinocchio"):
        pp.from_pinocchio(3)
    with pytest.raises(pp.UnknownNameError, match="a0"):
        pp.from_pinocchio(Model(*CASES["points"][:2], seed=1).model, [], "a9")


def test_gears_of_several_joints_are_relations():
    press = texts.load((FOLDER / "13_urdfplus_coupling.urdf").read_text())
    again = pp.from_pinocchio(press.model, [], press.drivers, relations=press.relations)
    assert driven(again, [0.5], [1.0], [2.0]) == pytest.approx(1.756711562, rel=1e-9)
    with pytest.raises(pp.PinpressError, match="relations: 'spindle' names places in v that are not those of single joints"):
        pp.from_pinocchio(Model(*CASES["hinges"][:2], seed=0).model, [], "a0", relations=[gear("spindle", 5, 0, 2.0)])
