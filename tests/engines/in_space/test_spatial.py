"""Linkages that only Pinocchio's engine can do: a loop through space, and planar ones that close more than they must."""

import re

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators import small_linkages
from support.generators.random_linkages import momentum_balance, newton_euler
from support.generators.redundant_linkages import three_cranks
from support.generators.spatial_crank_slide import CRANK_AXIS, GUIDE_AXIS, LENGTH, PIN_P, PIN_W, SPATIAL, inertial, text

import pinpress as pp

SPEED = 9.0


@pytest.fixture(scope="module")
def spatial():
    return texts.load(SPATIAL)


def travel(angle):
    """Travel of the slide along its guide, from the rod's length: analytic, so that it may be taken at complex angles."""
    c, s = np.cos(angle), np.sin(angle)
    crank_pin = (
        np.multiply.outer(PIN_P, c)
        + np.multiply.outer(np.cross(CRANK_AXIS, PIN_P), s)
        + np.multiply.outer(CRANK_AXIS * (CRANK_AXIS @ PIN_P), 1 - c)
    )
    along = GUIDE_AXIS @ crank_pin - GUIDE_AXIS @ PIN_W
    apart = crank_pin - PIN_W[:, None]
    return along - np.sqrt(along**2 - (apart * apart).sum(axis=0) + LENGTH**2)


def slope(function, angle):
    """Derivative by the eighth-order central difference; at h = 0.02 truncation and rounding are both about 1e-13 here."""
    h = 0.02
    weights = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
    return sum(w * function(angle, k * h) for k, w in enumerate(weights, 1)) / h


def test_it_is_spatial_and_has_one_degree_of_freedom(spatial):
    """The crank drives it: a rank from Pinocchio's frame Jacobians. One joint less locks it, one more lets the rod spin."""
    assert "plane" not in spatial.engines
    assert spatial.mobility == 1
    assert np.abs(spatial.closed).max() < 1e-13
    data = spatial.model.createData()
    rod, slide = (
        pin.computeFrameJacobian(spatial.model, data, pin.neutral(spatial.model), spatial.model.getFrameId(link), pin.LOCAL_WORLD_ALIGNED)
        for link in ("rod", "slide")
    )
    at_w = rod[:3] - pin.skew(PIN_W - PIN_P) @ rod[3:]
    assert np.linalg.matrix_rank(slide[:3] - at_w) == spatial.model.nv - 1
    for joint, free in (("fixed", 0), ("continuous", 2)):
        if joint == "fixed":
            urdf = re.sub(
                r'<joint name="Q" type="revolute">(.*?)<axis.*?</joint>', r'<joint name="Q" type="fixed">\1</joint>', SPATIAL, flags=re.S
            )
        else:
            extra = f'<link name="sleeve">{inertial(1.0, [0, 0, 0], [1, 0, 0, 1, 0, 1])}</link>'
            axis = text((PIN_W - PIN_P) / LENGTH)
            spin = f'<joint name="S" type="continuous"><parent link="cross"/><child link="sleeve"/><axis xyz="{axis}"/></joint>'
            urdf = SPATIAL.replace('<parent link="cross"/>', '<parent link="sleeve"/>').replace("</robot>", extra + spin + "</robot>")
        with pytest.raises(pp.UrdfError, match=f"mobility is {free}"):
            texts.load(urdf)


def test_slide_in_closed_form(spatial):
    """Position to 1e-13 m, velocity by complex step (exact), acceleration by an eighth-order difference of that, 1e-11."""
    speed, acceleration = np.linspace(-4, 9, 40), np.linspace(30, -10, 40)
    angle = np.linspace(-9, 12, 40)
    motion = pp.servo_cycle(spatial, angle=angle, speed=speed, acceleration=acceleration)
    offset = GUIDE_AXIS @ PIN_W
    np.testing.assert_allclose(motion.slide_position, offset + travel(angle), rtol=0, atol=1e-13)

    def rate(x):
        return travel(x + 1e-30j).imag / 1e-30

    first, second = rate(angle), slope(lambda x, d: rate(x + d) - rate(x - d), angle)
    assert np.abs(motion.slide_velocity - first * speed).max() <= 1e-12 * np.abs(first * speed).max()
    expected = first * acceleration + second * speed**2
    assert np.abs(motion.slide_acceleration - expected).max() <= 1e-11 * np.abs(expected).max()


def test_rates_are_derivatives_of_configurations(spatial):
    """Every joint: 1e-11 of the peak for the first, 1e-10 for the second, which amplifies rounding by 1 / h again."""
    angle = np.linspace(0.0, 6.0, 11)

    def turned(x, d):
        ends = [pp.servo_cycle(spatial, angle=x + e, speed=1.0).q for e in (-d, d)]
        return np.array([pin.difference(spatial.model, one, two) for one, two in zip(*ends, strict=True)])

    def sped_up(x, d):
        return pp.servo_cycle(spatial, angle=x + d, speed=1.0).v - pp.servo_cycle(spatial, angle=x - d, speed=1.0).v

    motion = pp.servo_cycle(spatial, angle=angle, speed=1.0)
    for values, expected, bound in ((motion.v, slope(turned, angle), 1e-11), (motion.a, slope(sped_up, angle), 1e-10)):
        assert np.abs(values - expected).max() <= bound * np.abs(expected).max()
        assert np.abs(expected).max(axis=0).min() > 0 or bound == 1e-10  # every joint moves; the crank has no acceleration


@pytest.mark.parametrize("direction", [1, -1])
def test_a_full_turn(spatial, direction):
    """Loops closed to 1e-12 m all round, and back at the start to rounding; the crank pin's first joint turns back as the crank turns."""
    assert spatial.branch.period == pytest.approx(2 * np.pi)
    gained = dict(zip(spatial.joints, spatial.branch.gain_per_period, strict=True))
    assert gained == {"O": 2 * np.pi, "P": -2 * np.pi, "Q": 0.0, "guide": 0.0}
    motion = pp.cycle(spatial, direction * SPEED, points=60)
    assert motion.closure_error.max() < 1e-12
    data = spatial.model.createData()
    for q in motion.q:
        pin.framesForwardKinematics(spatial.model, data, q)
        ends = data.oMf[spatial.model.getFrameId("rod")].act(PIN_W - PIN_P), data.oMf[spatial.model.getFrameId("slide")].translation
        assert np.linalg.norm(ends[0] - ends[1]) < 1e-12
    turns = pp.servo_cycle(spatial, angle=0.3 + 2 * np.pi * np.arange(-3, 4), speed=1.0)
    for name in ("q", "v", "a"):
        values = getattr(turns, name)
        np.testing.assert_allclose(values, np.tile(values[3], (7, 1)), rtol=0, atol=1e-12)


def test_forces(spatial):
    """Power and momentum to 1e-10 of the peak; Newton's and Euler's equations of every body, and passive joints idle, to 1e-12: rounding.

    The torque once more by virtual work of the open tree, which needs no loop force at all; and nothing is indeterminate.
    """
    states = np.linspace(0, 6, 15)
    motion = pp.servo_cycle(spatial, angle=states, speed=SPEED * np.cos(states), acceleration=30 * np.sin(3 * states))
    loads = [
        pp.loads.PointForce("slide", (50.0, -80.0, 3000.0), (0.1, 0.0, -0.1)),
        pp.loads.PointForce("rod", (7.0, 90.0, -60.0), (0.0, 0.1, -0.2)),
    ]
    loads.append(pp.loads.PointForce("frame", (1.0, 2.0, -3000.0), (0.0, 0.0, -0.9)))
    result = pp.inverse_dynamics(spatial, motion, loads)
    force_peak = max(np.abs(f).max() for f in result.bearing_force.values())
    moment_peak = force_peak * spatial.size
    assert np.abs(result.power_residual).max() <= 1e-10
    force, moment = momentum_balance(spatial, motion, loads)
    assert np.abs(result.shaking_force - force).max() <= 1e-10 * force_peak
    assert np.abs(result.shaking_moment - moment).max() <= 1e-10 * moment_peak
    forces, moments, idle = newton_euler(spatial, motion, result, loads)
    assert np.abs(forces).max() <= 1e-12 * force_peak
    assert np.abs(moments).max() <= 1e-12 * moment_peak
    assert np.abs(idle).max() <= 1e-12 * moment_peak
    assert not any(flags.any() for flags in result.indeterminate.values())

    unit = pp.servo_cycle(spatial, angle=states, speed=1.0).v
    data = spatial.model.createData()
    bare = pp.inverse_dynamics(spatial, motion).driving_torque
    efforts = [pin.rnea(spatial.model, data, q, v, a) @ u for q, v, a, u in zip(motion.q, motion.v, motion.a, unit, strict=True)]
    assert np.abs(bare - efforts).max() <= 1e-12 * moment_peak


# ------------------------------------------------------------------------------------------------------------------------ redundant


@pytest.mark.parametrize("turn", [False, True])
def test_a_redundant_linkage_moves(turn, engine):
    """It closes all the way round, and its coupler only translates (1e-12)."""
    press = texts.load(three_cranks().urdf("O"))
    assert press.engine("plane").plane.redundant
    assert press.mobility == 1
    assert press.rank == 3
    if turn:
        motion = pp.cycle(press, 5.0, points=24, engine=engine)
    else:
        motion = pp.servo_cycle(press, np.linspace(-1.0, 1.5, 9), speed=5.0, engine=engine)
    assert motion.closure_error.max() < 1e-12
    expected = {"O": 5.0, "B": -5.0, "D": 5.0, "G": 5.0}
    for name, rate in expected.items():
        np.testing.assert_allclose(motion.v[:, press.joints.index(name)], rate, rtol=1e-12)
    assert np.abs(motion.a).max() < 1e-10


@pytest.mark.parametrize("offset", [0.0, 0.2])
def test_a_redundant_linkage_in_closed_form(offset, engine):
    """Torque = I alpha + g sum(m r cos), as all parts turn alike or move like the crank pin; every body in balance; 1e-12 of the peak."""
    press = texts.load(three_cranks(offset).urdf("O"))
    angle = np.linspace(-1, 1.5, 19)
    acceleration = 20 * np.cos(angle)
    motion = pp.servo_cycle(press, angle=angle, speed=np.linspace(-6, 6, 19), acceleration=acceleration)
    result = pp.inverse_dynamics(press, motion, engine=engine)
    assert result.engine == engine
    turned = np.exp(1j * (0.5 + angle))
    inertia = sum(m * (abs(r) ** 2 + 0.01) for m, r in ((4, 0.12), (3, 0.15), (2, 0.18))) + 9 * 0.3**2
    lever = 4 * 0.12 + 3 * 0.15 + 2 * 0.18 * np.exp(0.3j) + 9 * 0.3
    expected = inertia * acceleration + 9.81 * (lever * turned).real
    assert np.abs(result.driving_torque - expected).max() <= 1e-12 * np.abs(expected).max()
    peak = max(np.abs(f).max() for f in result.bearing_force.values())
    forces, moments, idle = newton_euler(press, motion, result)
    assert np.abs(forces).max() <= 1e-12 * peak
    assert np.abs(moments).max() <= 1e-12 * peak
    assert np.abs(idle).max() <= 1e-12 * peak
    # the three pins carry the coupler: 9 kg on a circle of 0.3 m, with its weight
    moving = 0.3 * turned * (1j * acceleration - motion.crank_speed**2)
    total = 9 * np.stack([moving.real, np.zeros(19), moving.imag + 9.81], axis=1)
    held = result.bearing_force["B"] - result.bearing_force["C"] + result.bearing_force["H"]
    assert np.abs(held - total).max() <= 1e-12 * peak
    force, moment = momentum_balance(press, motion, [])
    assert np.abs(result.shaking_force - force).max() <= 1e-10 * peak
    assert np.abs(result.shaking_moment - moment).max() <= 1e-10 * peak
    assert np.abs(result.power_residual).max() <= 1e-10


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["zxn2_3000b", "crank_slide", "jf75g_125_symmetric"])
def test_the_same_is_open_in_a_press_that_stands_askew(name, engine):
    """Flags are along the horizontal in the plane, the normal, and the way up in the plane: what is certain upright is certain askew."""
    upright, askew = texts.shipped(name), small_linkages.bolted(texts.shipped(name), "0.3 0.2 0.1")
    straight, leaning = (pp.inverse_dynamics(press, pp.cycle(press, 5.0, points=7), engine=engine) for press in (upright, askew))
    np.testing.assert_array_equal(straight.indeterminate_axes, np.eye(3))
    axes, normal = leaning.indeterminate_axes, pin.rpy.rpyToMatrix(0.3, 0.2, 0.1)[:, 1]
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(axes) > 0.5
    assert abs(axes[0, 2]) < 1e-15  # horizontal
    assert axes[2, 2] > 0.5  # upwards
    assert abs(abs(axes[1] @ normal) - 1) < 1e-12
    certain = 0
    for bearing in upright.bearings:
        before, after = straight.indeterminate[bearing], leaning.indeterminate[bearing]
        # forces in the plane, then moments in it, are open together: their two directions are others than upright
        assert (after[1], after[4]) == (before[1], before[4])
        for pair in ([0, 2], [3, 5]):
            assert after[pair].any() == before[pair].any()
        certain += int(np.count_nonzero(~after))
    assert certain >= len(upright.bearings)


@pytest.mark.parametrize("press_name", ["zxn2_3000b", "crank_slide"])
def test_only_forces_across_an_ordinary_press_are_open(press_name, engine):
    """In-plane forces and moments are certain; along the normal, world y, the loops may share a force as they like."""
    press = texts.shipped(press_name)
    flags = pp.inverse_dynamics(press, pp.cycle(press, 5.0, points=7), engine=engine).indeterminate
    for name in press.bearings:
        assert flags[name][:3].tolist() == [False, True, False], name
        assert not flags[name][4], name
