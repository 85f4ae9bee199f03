"""Loops through space, and loops that close more than they must: Bennett's and Bricard's linkages, Cassie, a four-bar closed in each way.

Judged by closed forms, by Pinocchio's kinematics of the open tree with loops of the tests' own, by dense equations of the bodies cut free,
and by forward dynamics.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators.random_linkages import apart, momentum_balance
from support.generators.spatial_linkages import (
    BENNETT_DRAWN,
    BRICARD_DRAWN,
    Drawing,
    Loops,
    bennett,
    bennett_angle,
    bricard,
    bricard_angle,
    four_bar,
)
from support.oracles import cassie
from support.oracles.cut_free import cut_free
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.engines.spatial import equations

TIMES = np.linspace(0.0, 2.0, 7)


class Family(NamedTuple):
    """A linkage to be tested: what makes its text, rows and rank of its loops, swing of its drivers about a middle [rad]."""

    text: Any
    rows: int
    rank: int
    middle: Any = 0.0
    swing: Any = 1.0


_CASSIE_SWING = [{"knee-op": 0.1, "knee-shin-joint": 0.1}.get(name.partition("-")[2], 0.3) for name in cassie.DRIVERS]
FAMILIES = {
    "bennett": Family(bennett, 5, 2, swing=4.0),
    "bricard": Family(bricard, 5, 4, middle=-0.4, swing=1.3),
    "four_bar_spherical": Family(lambda: four_bar("spherical"), 3, 2, swing=4.0),
    "four_bar_revolute": Family(lambda: four_bar("revolute"), 5, 2, swing=4.0),
    "four_bar_fixed": Family(lambda: four_bar("fixed"), 6, 3, swing=4.0),
    "turntable": Family(lambda: four_bar("revolute", table="table"), 5, 2, swing=np.array([1.0, 1.2])),
    "cassie": Family(cassie.urdf, 12, 10, swing=np.array(_CASSIE_SWING)),
}

ALWAYS = ("bennett", "four_bar_spherical", "turntable")  # the others are exhaustive


class Case(NamedTuple):
    name: str
    text: str
    press: pp.Linkage
    motion: pp.Motion
    loads: list
    result: pp.Reactions
    loops: Loops
    balance: list  # what cut_free says of each state
    force: float  # peak of any component of any bearing force [N]
    moment: float


@pytest.fixture(scope="module", params=rest_exhaustive(FAMILIES, *ALWAYS))
def case(request):
    text = FAMILIES[request.param].text()
    press = texts.load(text)
    motion = swinging(press, request.param, TIMES)
    link = press.links[-1]
    loads = [pp.loads.PointForce(link, (30.0, -40.0, 20.0), (0.02, -0.05, 0.01))]
    result = pp.inverse_dynamics(press, motion, loads, engine="pinocchio")
    force, moment = (max(np.abs(f).max() for f in part.values()) for part in (result.bearing_force, result.bearing_moment))
    balance = [cut_free(press, motion, i, loads) for i in range(len(TIMES))]
    return Case(request.param, text, press, motion, loads, result, Loops(text, press.model), balance, force, moment)


def swing(name, time):
    """Angles, speeds and accelerations (n, drivers) of drivers that swing, each at its own frequency and phase."""
    family = FAMILIES[name]
    count = np.size(family.swing)
    rng = np.random.default_rng(7)
    frequency, phase = rng.uniform(1.0, 4.0, count), rng.uniform(0, 2 * np.pi, count)
    argument = np.multiply.outer(time, frequency) + phase
    far = family.swing * np.sin(argument)
    return family.middle + far, family.swing * frequency * np.cos(argument), -(frequency**2) * far


def swinging(press, name, time):
    """The motion with these drivers."""
    angle, speed, acceleration = (part[:, 0] if len(press.drivers) == 1 else part for part in swing(name, time))
    return pp.servo_cycle(press, angle=angle, speed=speed, acceleration=acceleration, engine="pinocchio")


def slope(function, h):
    """Derivative of a function of an offset at zero, by the eighth-order central difference."""
    return sum(w * (function(k * h) - function(-k * h)) for k, w in enumerate((4 / 5, -1 / 5, 4 / 105, -1 / 280), 1)) / h


# --------------------------------------------------------------------------------------------------------------------------- kinematics


def test_rank(case):
    """Of the Jacobian made here, in every state; what it leaves free is the mobility, and there is a driver for each."""
    family, press = FAMILIES[case.name], case.press
    assert "plane" not in press.engines or case.name.startswith("four_bar")
    for q in case.motion.q:
        jacobian, _ = case.loops.rows(q, np.zeros(press.model.nv))
        assert jacobian.shape == (family.rows, press.model.nv)
        assert np.linalg.matrix_rank(jacobian, 1e-9) == family.rank
    assert press.mobility == len(press.drivers) == press.model.nv - family.rank


def test_loops_stay_closed(case):
    """Points and directions, by Pinocchio's placements, to 1e-13 m and rad; and the motion says so."""
    apart, turned = np.array([case.loops.gaps(q) for q in case.motion.q]).transpose(1, 0, 2)
    assert apart.max() < 1e-13
    assert turned.max() < 1e-13
    assert case.motion.closure_error.max() < 1e-13


def test_drivers_do_what_is_asked(case):
    """Angle, speed and acceleration of each, in the order of the drivers, to rounding."""
    at = [case.press.joints.index(name) for name in case.press.drivers]
    for found, asked in zip((case.motion.joint_position, case.motion.v, case.motion.a), swing(case.name, TIMES), strict=True):
        np.testing.assert_allclose(found[:, at], asked, rtol=0, atol=1e-14)


@pytest.mark.exhaustive
def test_rates_are_derivatives_of_positions(case):
    """In time, of all joints: rates, and accelerations as derivatives of rates, to 1e-10 of the peak."""
    count = 3

    @cache
    def motion(offset):
        return swinging(case.press, case.name, TIMES[:count] + offset)

    for values, expected in (
        (case.motion.v, slope(lambda d: motion(d).joint_position, 0.002)),
        (case.motion.a, slope(lambda d: motion(d).v, 0.002)),
    ):
        assert np.abs(values[:count] - expected).max() <= 1e-10 * np.abs(expected).max()


# -------------------------------------------------------------------------------------------------------------------------------- forces


def test_bodies_cut_free(case):
    """All forces, moments and torques against the bodies cut free, also the choice among those that balance: least squares; 1e-12."""
    for i, expected in enumerate(state.wrenches for state in case.balance):
        for k, name in enumerate(case.press.bearings):
            assert np.abs(case.result.bearing_force[name][i] - expected[k, :3]).max() <= 1e-12 * case.force, name
            assert np.abs(case.result.bearing_moment[name][i] - expected[k, 3:]).max() <= 1e-12 * case.moment, name
        torques = axial_moments(case, expected, i)
        assert np.abs(case.result.driving_torque[i] - torques).max() <= 1e-12 * np.abs(case.result.driving_torque).max()


def axial_moments(case, wrenches, i):
    """(drivers,) moments of wrenches along the drivers' axes."""
    model, data = case.press.model, case.loops.data
    pin.computeJointJacobians(model, data, case.motion.q[i])
    places = [case.press.joints.index(name) for name in case.press.drivers]
    return [pin.getJointJacobian(model, data, j + 1, pin.LOCAL_WORLD_ALIGNED)[3:, j] @ wrenches[j, 3:] for j in places]


def test_open_components(case):
    """There are as many idle forces as rows too many, and just those components are marked that they reach in any state."""
    family, reached = FAMILIES[case.name], np.zeros((len(case.press.bearings), 6), dtype=bool)
    for idle in (state.idle for state in case.balance):
        assert len(idle) == family.rows - family.rank
        reached |= np.abs(idle).max(axis=0) > 1e-9
    for k, name in enumerate(case.press.bearings):
        assert case.result.indeterminate[name].tolist() == reached[k].tolist(), name


def test_power_and_momentum(case):
    """Power flows into energy, and what reaches the foundation is weight and loads less the rate of momentum; 1e-12 of the peak."""
    assert np.abs(case.result.power_residual).max() <= 1e-12
    force, moment = momentum_balance(case.press, case.motion, case.loads)
    assert np.abs(case.result.shaking_force - force).max() <= 1e-12 * case.force
    assert np.abs(case.result.shaking_moment - moment).max() <= 1e-12 * max(case.moment, case.force * case.press.size)


@pytest.mark.parametrize("name", [name for name in FAMILIES if np.size(FAMILIES[name].swing) == 1])
def test_equation_of_motion(name):
    """Torque = I x'' + I' x'^2 / 2 + V' of one degree of freedom, I and V from Pinocchio's energies at unit speed, 1e-11 of the peak."""
    press = texts.load(FAMILIES[name].text())
    motion = swinging(press, name, TIMES)
    x, speed, acceleration = motion.crank_angle, motion.crank_speed, motion.crank_acceleration
    model, data = press.model, press.model.createData()

    def energies(offset):
        unit = pp.servo_cycle(press, angle=x + offset, speed=1.0)
        inertia = [2 * pin.computeKineticEnergy(model, data, q, v) for q, v in zip(unit.q, unit.v, strict=True)]
        return np.array([inertia, [pin.computePotentialEnergy(model, data, q) for q in unit.q]])

    inertia, (change, lift) = energies(0.0)[0], slope(energies, 0.006)
    expected = inertia * acceleration + change * speed**2 / 2 + lift
    torque = pp.inverse_dynamics(press, motion).driving_torque
    assert np.abs(torque - expected).max() <= 1e-11 * np.abs(expected).max()


# ------------------------------------------------------------------------------------------------ all states at once, beside Pinocchio


def test_all_states_at_once(case):
    """The engine in space: motion; and forces with friction, stiffness and fewer bearings."""
    press, theirs = case.press, case.motion
    ours = pp.servo_cycle(press, angle=theirs.crank_angle, speed=theirs.crank_speed, acceleration=theirs.crank_acceleration, engine="space")
    for name in ("joint_position", "v", "a"):
        one, other = getattr(ours, name), getattr(theirs, name)
        assert np.abs(one - other).max() <= 1e-12 * (1 + np.abs(other).max()), name
    welds = {loop.name for loop in press.loops if loop.type == "fixed"}
    rubbing = {name: pp.loads.Friction(0.05, radius=0.02) for name in press.bearings if name not in welds}
    stiff = dict.fromkeys(press.bearings[:3], 1e8)
    for more in ({}, {"friction": rubbing}, {"stiffness": stiff}, {"bearings": press.bearings[1:3]}, {"bearings": ()}):
        one, other = (pp.inverse_dynamics(press, ours, case.loads, engine=engine, **more) for engine in ("space", "pinocchio"))
        assert max(apart(one, case.result if "bearings" in more else other)) <= 1e-11
        for name in press.bearings if not more else ():
            np.testing.assert_array_equal(one.indeterminate[name], other.indeterminate[name])


def test_logarithms_of_rotations():
    rng = np.random.default_rng(4)
    vectors = rng.normal(size=(40, 3))
    sizes = np.concatenate([np.linspace(0.0, np.pi - 1e-6, 30), np.pi - np.geomspace(1e-9, 1e-2, 10)])
    vectors *= (sizes / np.linalg.norm(vectors, axis=1))[:, None]
    rotations = np.array([pin.exp3(vector) for vector in vectors]).transpose(1, 2, 0)
    np.testing.assert_allclose(equations._logarithm(rotations).T, vectors, rtol=0, atol=1e-7)
    np.testing.assert_allclose(equations._logarithm(rotations).T[:20], vectors[:20], rtol=0, atol=1e-14)


# -------------------------------------------------------------------------------------------------------------- the linkages one by one


def test_bennett_goes_round():
    """tan(first / 2) tan(second / 2) is constant all round; the fourth pin goes against the second; 1e-13."""
    press = texts.load(bennett())
    gained = dict(zip(press.joints, press.branch.gain_per_period, strict=True))
    assert gained == pytest.approx({"J1": 2 * np.pi, "J2": -2 * np.pi, "J4": 2 * np.pi}, abs=1e-12)
    motion = pp.cycle(press, 3.0, points=60)
    position, rate = (dict(zip(press.joints, part.T, strict=True)) for part in (motion.joint_position, motion.v))
    second, slope_of_second = bennett_angle(BENNETT_DRAWN + motion.crank_angle)
    turned = np.unwrap(second) - bennett_angle(BENNETT_DRAWN)[0]
    assert np.abs(position["J2"] - turned).max() < 1e-13
    assert np.abs(position["J4"] + turned).max() < 1e-13
    assert np.abs(rate["J2"] - 3.0 * slope_of_second).max() < 1e-13


def test_bricard_in_closed_form():
    """cos 1 + cos 2 + cos 1 cos 2 = 0, and every other pin turns alike; 1e-13."""
    press = texts.load(bricard())
    motion = pp.servo_cycle(press, speed=2.0, angle=np.linspace(-1.9, 1.9, 40) - BRICARD_DRAWN)
    position, rate = (dict(zip(press.joints, part.T, strict=True)) for part in (motion.joint_position, motion.v))
    second, slope_of_second = bricard_angle(BRICARD_DRAWN + motion.crank_angle)
    turned = second - bricard_angle(BRICARD_DRAWN)[0]
    for name, expected in (("J2", turned), ("J3", motion.crank_angle), ("J5", motion.crank_angle), ("J6", turned)):
        assert np.abs(position[name] - expected).max() < 1e-13, name
    assert np.abs(rate["J2"] - 2.0 * slope_of_second).max() < 1e-13


@pytest.mark.exhaustive
def test_bricard_locks_at_120_degrees():
    """Where its second pin comes to zero, either way."""
    press = texts.load(bricard())
    low, high = press.branch.locks
    assert high.angle == pytest.approx(2 * np.pi / 3 - BRICARD_DRAWN, abs=1e-5)
    assert low.angle == pytest.approx(-2 * np.pi / 3 - BRICARD_DRAWN, abs=1e-5)
    with pytest.raises(pp.SingularityError, match="locks"):
        pp.servo_cycle(press, speed=1.0, angle=[2 * np.pi / 3 - BRICARD_DRAWN + 0.01])


@pytest.mark.exhaustive
@pytest.mark.parametrize(("make", "cuts", "swing"), [(bennett, (2, 3, 4), 4.0), (bricard, (2, 6), 1.0)])
def test_where_a_ring_is_cut_changes_nothing(make, cuts, swing):
    """Torque, and the shares of what is open, which are chosen among all bearings: a pin has its force and moment in any tree; 1e-12."""
    angle = swing * np.sin(np.arange(7.0))

    def solved(cut):
        press = texts.load(make(cut))
        motion = pp.servo_cycle(press, angle=angle, speed=np.linspace(-2, 2, 7), acceleration=np.linspace(3, 5, 7))
        result = pp.inverse_dynamics(press, motion)
        signs = {f"J{k}": 1.0 if k <= cut else -1.0 for k in range(1, cuts[-1] + 1)}  # a pin beyond the cut carries the link before it
        force, moment = (
            np.array([sign * part[name] for name, sign in signs.items()]) for part in (result.bearing_force, result.bearing_moment)
        )
        return result.driving_torque, force, moment

    first = solved(cuts[0])
    for cut in cuts[1:]:
        for values, expected in zip(solved(cut), first, strict=True):
            assert np.abs(values - expected).max() <= 1e-12 * np.abs(expected).max(), cut


@pytest.mark.exhaustive
@pytest.mark.parametrize(("closing", "engine"), [("revolute", "plane"), ("revolute", "pinocchio"), ("fixed", "pinocchio")])
def test_a_four_bar_is_the_same_however_it_is_closed(closing, engine):
    """By a pin with an axis, or by a weld in its coupler: torque, and forces and moments in the plane at all pins; 1e-13."""
    results = []
    for kind in ("spherical", closing):
        press = texts.load(four_bar(kind))
        motion = pp.cycle(press, 5.0, points=12, engine=engine)
        results.append(pp.inverse_dynamics(press, motion, engine=engine))
    reference, result = results
    torque = np.abs(reference.driving_torque).max()
    assert np.abs(result.driving_torque - reference.driving_torque).max() <= 1e-13 * torque
    for name in "OBCD":
        peak = np.abs(reference.bearing_force[name]).max()
        assert np.abs((result.bearing_force[name] - reference.bearing_force[name])[:, [0, 2]]).max() <= 1e-13 * peak, name
        assert np.abs((result.bearing_moment[name] - reference.bearing_moment[name])[:, 1]).max() <= 1e-13 * torque, name
        assert not result.indeterminate[name][[0, 2, 4]].any()
        assert result.indeterminate[name][1]


@pytest.mark.parametrize("seed", range(4))
def test_a_link_that_spins_freely_is_found(seed):
    """A sleeve on a four-bar's rocker that turns about a line through the loop's pin: its joint moves the loop by rounding alone."""
    pivot, crank_pin, rocker_pin = np.array([0.45, 0.0, -0.05]), np.array([0.1, 0.0, 0.11]), np.array([0.3, 0.0, 0.4])
    normal, along = np.array([0.0, -1.0, 0.0]), rocker_pin - pivot
    drawing = Drawing("sleeve", seed)
    drawing.joint("O", "frame", "crank", np.zeros(3), normal)
    drawing.joint("B", "crank", "rod", crank_pin, normal)
    drawing.joint("D", "frame", "rocker", pivot, normal)
    drawing.joint("S", "rocker", "sleeve", pivot + 0.3 * along, along / np.linalg.norm(along))
    drawing.loop("C", "spherical", "rod", "sleeve", rocker_pin)
    for link in ("crank", "rod", "rocker", "sleeve"):
        drawing.body(link, 1.0, crank_pin, 0.1)
    with pytest.warns(pp.PinpressWarning, match="weight would turn"):
        press = texts.load(drawing.urdf("O"))
    (swing,) = press.freedoms
    placed = press.model.createData()
    pin.forwardKinematics(press.model, placed, press.configuration(0.0))
    body = press.joints.index("S") + 1
    centre = np.cross(placed.oMi[body].act(press.model.inertias[body].lever) - rocker_pin, along / np.linalg.norm(along))
    assert (press.mobility, press.held, swing.kind, swing.joints, swing.bodies) == (2, ("S",), "swing", ("S",), ("sleeve",))
    assert swing.eccentricity == pytest.approx(np.linalg.norm(centre), rel=1e-9)


def test_cassie_is_read_as_it_is_written():
    """With every joint turned back to the pose of the SDF, all masses are where that has them: 3e-6 m, for its quarter turns are rounded.

    There the ball joints are closed by definition.
    """
    text = cassie.urdf()
    model = texts.load(text).model
    data = model.createData()
    back = pin.integrate(model, pin.neutral(model), np.array([-cassie.drawn(name) for name in list(model.names)[1:]]))
    apart, _ = Loops(text, model).gaps(back)
    assert apart.max() < 1e-14
    pin.forwardKinematics(model, data, back)
    links = {link.get("name"): link for link in cassie.sdf().findall("link")}
    pelvis = placement(links.pop("pelvis"))
    for name, link in links.items():
        joint = model.frames[model.getFrameId(name, pin.BODY)].parentJoint
        inertia, expected = model.inertias[joint], pelvis.actInv(placement(link) * placement(link.find("inertial")))
        assert inertia.mass == float(link.findtext("inertial/mass"))
        assert np.abs(data.oMi[joint].act(inertia.lever) - expected.translation).max() < 3e-6, name


def placement(element):
    numbers = np.array(element.findtext("pose").split(), dtype=float)
    return pin.SE3(pin.rpy.rpyToMatrix(numbers[3:]), numbers[:3])
