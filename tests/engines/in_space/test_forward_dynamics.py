"""Forward dynamics: against dense equations with multipliers, inverse dynamics, closed forms and power; states put on the loops."""

import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators import period_presses, random_linkages, redundant_linkages
from support.generators.random_linkages import Group, Spec
from support.generators.redundant_linkages import three_cranks
from support.generators.spatial_linkages import Loops, bennett, bricard, four_bar, null_space
from support.oracles import cassie
from support.oracles.cut_free import gears
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.engines.pinocchio.forward_dynamics import ForwardDynamics

TIMES = np.linspace(0.0, 2.0, 7)


def random_text(seed):
    rng = np.random.default_rng(seed)
    kinds = rng.choice(random_linkages.KINDS, size=rng.integers(1, 5))
    groups = tuple(Group(str(kind), int(rng.integers(3)), tuple(map(int, rng.integers(8, size=3)))) for kind in kinds)
    drawn = random_linkages.drawn(Spec(groups, seed, *map(bool, rng.integers(2, size=4))))
    return None if drawn is None else drawn.urdf("crank")


RANDOM = (0, 2, 6, 9, 11, 16, 25)  # seeds of linkages that can be drawn and turn by the swing of the cases

FAMILIES: dict[str, Any] = dict.fromkeys(pp.presses())
FAMILIES |= {"three_cranks": lambda: three_cranks().urdf("O"), "bennett": bennett, "bricard": bricard, "cassie": cassie.urdf}
FAMILIES |= {f"four_bar_{kind}": lambda kind=kind: four_bar(kind) for kind in ("spherical", "revolute", "fixed")}
FAMILIES["turntable"] = lambda: four_bar("revolute", table="table")
FAMILIES["geared_five_bar"] = lambda: redundant_linkages.five_bar(-0.7)
FAMILIES["train"] = lambda: redundant_linkages.wheels(("s1", "crank", -1.5), ("s2", "s1", 40.0, 0.2))
FAMILIES["rack"] = lambda: redundant_linkages.wheels(("s1", "crank", -1.5), ("rack", "s1", 0.3))
FAMILIES["long_train"] = lambda: redundant_linkages.wheels(("s1", "crank", -1.5), ("rack", "s1", 0.3), ("s2", "crank", 40.0, 0.2))
FAMILIES["geared_ring"] = lambda: redundant_linkages.wheels(("s1", "crank", -1.0), ("s2", "s1", -1.0), ("crank", "s2", 1.0))
FAMILIES |= {f"random_{seed}": lambda seed=seed: random_text(seed) for seed in RANDOM}

# A gear pair that depends on the loops, or many gear pairs; all others take Pinocchio's constraint dynamics.
GENERAL = {"eccentric_blocks", "jf75g_125_symmetric", "geared_ring", "long_train"}

# One of each kind; the others are exhaustive.
ALWAYS = ("zxn2_3000b", "jf75g_125_symmetric", "three_cranks", "bennett", "cassie", "four_bar_spherical", "random_6")


class Case(NamedTuple):
    name: str
    press: pp.Linkage
    motion: pp.Motion
    armature: np.ndarray
    dynamics: ForwardDynamics
    loops: Loops


@pytest.fixture(scope="module", params=rest_exhaustive(FAMILIES, *ALWAYS))
def case(request):
    made = FAMILIES[request.param]
    press = texts.shipped(request.param) if made is None else texts.load(made())
    count = len(press.drivers)
    swing, middle = {"cassie": (0.1, 0.0), "bricard": (1.0, -0.4)}.get(request.param, (0.4, 0.0))
    frequency, phase = np.linspace(2.0, 4.0, count), np.arange(count)
    argument = np.multiply.outer(TIMES, frequency) + phase
    parts = middle + swing * np.sin(argument), swing * frequency * np.cos(argument), -swing * frequency**2 * np.sin(argument)
    angle, speed, acceleration = (part[:, 0] if count == 1 else part for part in parts)
    motion = pp.servo_cycle(press, angle=angle, speed=speed, acceleration=acceleration)
    armature = np.zeros(press.model.nv)
    armature[list(press.driver_indices)] = 0.3
    return Case(request.param, press, motion, armature, press.forward_dynamics(armature), Loops(press.text.decode(), press.model))


def states(case):
    return [tuple(map(np.array, state)) for state in zip(case.motion.joint_position, case.motion.v, case.motion.q, strict=True)]


def rows(case, q, v):
    """Jacobian and drift of loops (the tests' own) and couplings."""
    jacobian, drift = case.loops.rows(q, v)
    for follower, leader, multiplier in gears(case.press):
        row = np.zeros(case.press.model.nv)
        row[case.press.joints.index(follower)], row[case.press.joints.index(leader)] = 1.0, -multiplier
        jacobian, drift = np.vstack([jacobian, row]), np.append(drift, 0.0)
    return jacobian, drift


def driving(press, result):
    """Driving torques of Reactions as efforts (n, nv)."""
    efforts = np.zeros((len(result.driving_torque), press.model.nv))
    efforts[:, list(press.driver_indices)] = result.driving_torque.reshape(len(efforts), -1)
    return efforts


def units(press):
    """What makes lengths of joint coordinates."""
    return np.array([press.size if axis.turns else 1.0 for axis in press.axes])


# --------------------------------------------------------------------------------------------------------------------------- acceleration


def test_dense_equations(case):
    """Under any efforts: [M J'; J 0] with least-squares multipliers, by NumPy, Pinocchio's mass matrix of the open tree, and rows of the
    tests' own. Both solutions lose digits with the condition of the dense matrix, most (to 3e-11) in Bennett's linkage: 1e-9."""
    rng, model, data = np.random.default_rng(1), case.press.model, case.press.model.createData()
    count = model.nv
    for x, v, q in states(case):
        efforts = 100 * rng.normal(size=count)
        mass = pin.crba(model, data, q) + np.diag(case.armature)
        jacobian, drift = rows(case, q, v)
        left = np.concatenate([efforts - pin.nonLinearEffects(model, data, q, v), -drift])
        dense = np.block([[mass, jacobian.T], [jacobian, np.zeros((len(jacobian),) * 2)]])
        expected = np.linalg.lstsq(dense, left, rcond=1e-13)[0][:count]
        found = case.dynamics.acceleration(x, v, efforts)
        assert np.abs(found - expected).max() <= 1e-9 * np.abs(expected).max()
        assert np.abs(jacobian @ found + drift).max() <= 1e-10 * np.abs(drift).max() + 1e-10 * np.abs(found).max()


def test_inverse_dynamics(case):
    """The motion's own accelerations under the torque that inverse dynamics says, with a load on a link; 1e-9 of the peak."""
    press, motion = case.press, case.motion
    link, point, force = press.links[-1], (0.02, -0.05, 0.01), (30.0, -40.0, 20.0)
    result = pp.inverse_dynamics(press, motion, [pp.loads.PointForce(link, force, point)])
    efforts = driving(press, result) + case.armature * motion.a
    frame = press.model.frames[press.model.getFrameId(link, pin.BODY)]
    at = frame.placement.act(np.array(point))
    for i, (x, v, _) in enumerate(states(case)):
        case.dynamics.place(x)
        load = case.dynamics.point_efforts(frame.parentJoint, at, np.array(force))
        found = case.dynamics.acceleration(x, v, efforts[i] + load)
        assert np.abs(found - motion.a[i]).max() <= 1e-9 * np.abs(motion.a).max()


def test_both_ways(case):
    """The quick way is taken where it suits and nowhere else, also with a heavy flywheel, and says what the general one says: 1e-12,
    or rounding of the open tree's accelerations, from which the quick way starts."""
    assert (case.dynamics.quick is None) == (case.name in GENERAL)
    rng, heavy = np.random.default_rng(2), case.press.forward_dynamics(1e4 * case.armature)
    for dynamics in (case.dynamics, heavy):
        for x, v, _ in states(case):
            efforts = 1000 * rng.normal(size=len(x))
            expected = dynamics.acceleration_in_null_space(x, v, efforts)
            free = np.abs(pin.aba(dynamics.model, dynamics.data, x, v, efforts)).max()
            assert np.abs(dynamics.acceleration(x, v, efforts) - expected).max() <= 1e-12 * np.abs(expected).max() + 1e-13 * free
            if dynamics.quick is not None:
                assert dynamics.quick.held_clearly(dynamics.lapack)


def test_a_light_shaft_costs_no_digits():
    """Without its gear pair the rotor of a motor would fly off under the motor's torque, and take the digits of all others with it."""
    press = period_presses.geared_down()
    motion = pp.servo_cycle(press, angle=[0.3, 1.0], speed=2.0)
    motor = np.array([joint == "M" for joint in press.joints], dtype=float)
    for inertia, torque, quickly in ((1.0, 10.0, True), (1e-7, 1e3, False)):
        dynamics = press.forward_dynamics(inertia * motor)
        assert dynamics.quick is not None
        for x, v in zip(motion.joint_position.copy(), motion.v.copy(), strict=True):
            found, expected = (way(x, v, torque * motor) for way in (dynamics.acceleration, dynamics.acceleration_in_null_space))
            assert np.array_equal(found, expected) != quickly
            assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()


def test_a_run_says_what_found_its_accelerations():
    """Algorithm, reason, states and settings; both algorithms where digits would be lost on the way."""
    for name, algorithm, reason in (
        ("zxn2_3000b", "constraintDynamics", "independent loops"),
        ("jf75g_125_two_point", "constraintDynamics", "loops that hold each other, with a larger mu"),
        ("jf75g_125_symmetric", "null space", "a gear pair whose ratio the loops keep too, as its torque is then undetermined"),
    ):
        press = texts.shipped(name)
        run = pp.simulate(press, 0.02, speed=7.0, method="constraint", tolerance=1e-6)
        found, quick = run.constraint_solution, press.forward_dynamics(np.zeros(press.model.nv)).quick
        assert (found.algorithm, found.reason) == (algorithm, reason)
        assert run.title.endswith(f"method 'constraint' by {algorithm}")
        states = found.by_constraint_dynamics, found.by_null_space
        assert min(states) == 0
        assert max(states) >= run.stats.evaluations
        settings = (None,) * 3 if quick is None else (quick.settings.mu, quick.settings.max_iter, 1e-13)
        assert (found.mu, found.iterations, found.tolerance) == settings
    assert pp.simulate(texts.shipped("zxn2_3000b"), 0.1, speed=7.0).constraint_solution is None


def test_a_gap_disturbs_no_more_than_itself(case):
    """A state off its loops by 1e-5 rad, as inside an integrator's step: accelerations change as little. Rows that become independent there
    would lock the linkage if they were held."""
    rng = np.random.default_rng(3)
    for x, v, _ in states(case)[:3]:
        efforts = 100 * rng.normal(size=len(x))
        closed = case.dynamics.acceleration(x, v, efforts)
        near = case.dynamics.acceleration(x + 1e-5 * rng.uniform(-1, 1, len(x)), v, efforts)
        assert np.abs(near - closed).max() <= 3e-3 * np.abs(closed).max()


def test_redundant_cranks_in_closed_form():
    """All parts turn alike, or move like the crank pin: inertia x alpha = torque - g sum(m r cos), 1e-12; and the armature adds to it."""
    press = texts.load(three_cranks().urdf("O"))
    inertia = sum(m * (abs(r) ** 2 + 0.01) for m, r in ((4, 0.12), (3, 0.15), (2, 0.18))) + 9 * 0.3**2
    lever = 4 * 0.12 + 3 * 0.15 + 2 * 0.18 * np.exp(0.3j) + 9 * 0.3
    motion = pp.servo_cycle(press, angle=np.linspace(-1, 1.5, 9), speed=np.linspace(-6, 6, 9), acceleration=0.0)
    for extra in (0.0, 5.0):
        dynamics = press.forward_dynamics(extra * np.array([joint == "O" for joint in press.joints]))
        for angle, x, v in zip(motion.crank_angle, motion.joint_position, motion.v, strict=True):
            expected = (40.0 - 9.81 * (lever * np.exp(1j * (0.5 + angle))).real) / (inertia + extra)
            found = dict(zip(press.joints, dynamics.acceleration(x, v, 40.0 * (np.array(press.joints) == "O")), strict=True))
            for name, sense in (("O", 1), ("B", -1), ("D", 1), ("G", 1)):
                assert abs(found[name] - sense * expected) <= 1e-12 * 50
    assert not np.any(press.model.armature)


def test_a_pendulum():
    """No loops at all: alpha = (torque - m g r cos) / inertia about the pivot."""
    drawing = random_linkages.Drawing("pendulum")
    drawing.joint("O", "frame", "bob", 0j)
    drawing.body("bob", 2.0, 0.5)
    dynamics = texts.load(drawing.urdf("O")).forward_dynamics(np.array([0.1]))
    x, v = np.array([0.7]), np.array([3.0])
    expected = (6.0 - 2 * 9.81 * 0.5 * math.cos(0.7)) / (2 * 0.5**2 + 2 * 0.01 + 0.1)
    assert abs(dynamics.acceleration(x, v, np.array([6.0]))[0] - expected) <= 1e-14 * 20
    assert dynamics.project(x, v) == (x, v, 0.0)
    assert dynamics.gap(x) == 0.0


def test_axes_the_other_way_round():
    """A revolute loop's axes may be drawn against each other: its two points are the same."""
    press = texts.load(four_bar("revolute"))
    (loop,) = press.loops
    other = dataclasses.replace(press, loops=(dataclasses.replace(loop, rotation2=loop.rotation2 @ np.diag([-1.0, -1.0, 1.0])),))
    x, v = press.closed, pp.servo_cycle(press, angle=[0.0], speed=2.0).v[0]
    first, second = (p.forward_dynamics(np.zeros(3)) for p in (press, other))
    assert second.gap(x) <= 1e-14
    np.testing.assert_allclose(second.acceleration(x, v, np.ones(3)), first.acceleration(x, v, np.ones(3)), rtol=1e-12)


def test_the_driver_at_a_dead_point():
    """Driven by its rocker, which stands still where crank and coupler are in line: `cycle` locks there, mechanics does not."""
    drawing = random_linkages.four_bar(1.0, 0.3, 0.9, 0.7, 0.5)
    by_crank, by_rocker = (texts.load(drawing.urdf(driver)) for driver in ("O", "D"))
    closest = (1 + (0.9 - 0.3) ** 2 - 0.7**2) / (2 * (0.9 - 0.3))  # cosine at the frame, coupler folded over the crank
    dead = math.acos(closest) - 0.5 - math.pi
    motion = pp.servo_cycle(by_crank, angle=[dead, dead + 1e-9], speed=3.0)
    rocker = by_rocker.joints.index("D")
    assert abs(motion.v[0, rocker]) < 1e-12
    with pytest.raises(pp.SingularityError):
        pp.servo_cycle(by_rocker, angle=[motion.joint_position[0, rocker]], speed=0.0)
    one, other = (press.forward_dynamics(np.zeros(3)) for press in (by_crank, by_rocker))
    for x, v in zip(np.array(motion.joint_position), np.array(motion.v), strict=True):
        moved = x + np.array([1e-4, -2e-4, 3e-4])
        for found, expected in zip(other.project(moved, v), one.project(moved, v), strict=True):
            np.testing.assert_array_equal(found, expected)
        efforts = np.array([20.0, 0.0, -30.0])
        np.testing.assert_allclose(other.acceleration(x, v, efforts), one.acceleration(x, v, efforts), rtol=1e-12)
        assert np.isfinite(other.acceleration(x, v, efforts)).all()


# ---------------------------------------------------------------------------------------------------------------------- locked, massless


def test_a_change_point():
    """A parallelogram in a line may go on as an antiparallelogram: said at that angle, and only there."""
    press = texts.load(three_cranks(third=False).urdf("O"))
    dynamics = press.forward_dynamics(np.zeros(3))
    line = -math.atan2(0.2, 1.0) - 0.5  # the crank along the line of pivots
    turned = np.array([{"O": 1.0, "B": -1.0, "D": 1.0}[joint] for joint in press.joints])
    for call in (dynamics.acceleration, lambda x, v, _: dynamics.project(x, v)):
        with pytest.raises(pp.SingularityError, match="lose equations") as caught:
            call(line * turned, 2.0 * turned, np.ones(3))
        assert caught.value.crank_angle == line
        assert caught.value.smallest_singular_value < 1e-12
    for offset in (1e-3, -1e-4, 1e-5):  # rounding over the distance: 1e-16 / 1e-5
        at = (line + offset) * turned
        alpha = dynamics.acceleration(at, 2.0 * turned, np.zeros(3))
        lever = 4 * 0.12 + 3 * 0.15 + 9 * 0.3
        inertia = 4 * (0.12**2 + 0.01) + 3 * (0.15**2 + 0.01) + 9 * 0.3**2
        expected = -9.81 * lever * math.cos(0.5 + at[press.joints.index("O")]) / inertia
        np.testing.assert_allclose(alpha, expected * turned, rtol=1e-8)


def massless(press, *links):
    model = press.model.copy()
    for link in links:
        model.inertias[model.frames[model.getFrameId(link, pin.BODY)].parentJoint] = pin.Inertia.Zero()
    return dataclasses.replace(press, model=model)


def test_links_without_mass():
    """A slide on a crank and rod without mass: m s'^2 alpha = torque - m s' (s'' speed^2 + g) from the slide's influence coefficients.
    At a dead centre nothing resists the crank."""
    press = texts.shipped("crank_slide")
    names = {name: press.model.frames[press.model.getFrameId(name, pin.BODY)].parentJoint for name in press.links}
    light = massless(press, *(link for link in press.links if link != press.slide and names[link]))
    mass = light.model.inertias[names[press.slide]].mass
    crank = press.joints.index(press.driver)
    dynamics, efforts = light.forward_dynamics(np.zeros(3)), 50.0 * (np.arange(3) == crank)
    angle = np.array([0.4, 1.0, 2.0, 4.0])
    motion, unit = (pp.servo_cycle(light, angle=angle, speed=s) for s in (7.0, 1.0))
    for i in range(len(angle)):
        first, second = unit.slide_velocity[i], unit.slide_acceleration[i]
        expected = (50.0 - mass * first * (second * 49.0 + 9.81)) / (mass * first**2)
        found = dynamics.acceleration(motion.joint_position[i], motion.v[i], efforts)
        assert abs(found[crank] - expected) <= 1e-10 * abs(expected)
    dead = pp.dead_centres(press)
    at = pp.servo_cycle(light, angle=[dead.top_angle], speed=1.0)
    with pytest.raises(pp.PinpressError, match="no mass resists"):
        dynamics.acceleration(at.joint_position[0], at.v[0], efforts)
    wheel = light.forward_dynamics(2.0 * (np.arange(3) == crank))
    assert abs(wheel.acceleration(at.joint_position[0], 0 * at.v[0], efforts)[crank] - 25.0) < 1e-9


@pytest.mark.parametrize("name", ["zxn2_3000b", "jf75g_125_symmetric"])
@pytest.mark.parametrize("wrong", [np.nan, np.inf, 1e200])
def test_what_is_not_finite(name, wrong):
    """Every argument is named; squares that overflow are too fast."""
    press = texts.shipped(name)
    dynamics = press.forward_dynamics(np.zeros(press.model.nv))
    x, zero = press.closed.copy(), np.zeros(press.model.nv)
    bad = zero.copy()
    bad[2] = wrong
    if np.isfinite(wrong):
        with pytest.raises(pp.PinpressError, match="too fast"):
            dynamics.acceleration(x, bad, zero)
        return
    for call, what in (
        (lambda: dynamics.acceleration(x + bad, zero, zero), "position"),
        (lambda: dynamics.acceleration(x, bad, zero), "speed"),
        (lambda: dynamics.acceleration(x, zero, bad), "effort"),
        (lambda: dynamics.project(x + bad, zero), "position"),
        (lambda: dynamics.project(x, bad), "speed"),
        (lambda: dynamics.gap(x + bad), "position"),
    ):
        with (
            np.errstate(all="ignore"),
            pytest.raises(pp.PinpressError, match=f"the {what} of joint {press.joints[2]} of {name} is not finite"),
        ):
            call()
    np.testing.assert_array_equal(dynamics.acceleration(x, zero, zero), press.forward_dynamics(zero).acceleration(x, zero, zero))


# ------------------------------------------------------------------------------------------------------------------------ energy, points


def test_energy(case):
    """Against the sum over the bodies: m v^2 / 2 of the centre, the turning about it, and m g z; 1e-12."""
    model, data = case.press.model, case.press.model.createData()
    for x, v, q in states(case):
        pin.forwardKinematics(model, data, q, v)
        kinetic, potential = 0.5 * case.armature @ v**2, 0.0
        for inertia, velocity, place in list(zip(model.inertias, data.v, data.oMi, strict=True))[1:]:
            centre = velocity.linear + np.cross(velocity.angular, inertia.lever)
            kinetic += 0.5 * inertia.mass * centre @ centre + 0.5 * velocity.angular @ inertia.inertia @ velocity.angular
            potential -= inertia.mass * model.gravity.linear @ place.act(inertia.lever)
        found = case.dynamics.energy(x, v)
        assert abs(found[0] - kinetic) <= 1e-12 * kinetic
        assert abs(found[1] - potential) <= 1e-12 * (abs(potential) + kinetic)


def test_power(case):
    """Efforts' power is the rate of energy along the accelerated motion, by a central difference; error h^2 and rounding / h: 1e-6."""
    rng, h = np.random.default_rng(4), 1e-5
    for x, v, _ in states(case)[:4]:
        efforts = 50 * rng.normal(size=len(x))
        a = case.dynamics.acceleration(x, v, efforts)
        after, before = (case.dynamics.project(x + s * h * v + 0.5 * h**2 * a, v + s * h * a) for s in (1, -1))
        rate = (sum(case.dynamics.energy(*after[:2])) - sum(case.dynamics.energy(*before[:2]))) / (2 * h)
        scale = np.abs(efforts * v).sum() + abs(sum(case.dynamics.energy(x, v)))
        assert abs(rate - efforts @ v) <= 1e-6 * scale


def test_energy_of_a_free_run():
    """Half a second without torque by Runge and Kutta's method of order 4 and projection: energy to h^4; of half the step 1/16."""
    press = texts.shipped("zxn2_3000b")
    crank = press.driver_indices[0]
    dynamics = press.forward_dynamics(2000.0 * (np.arange(5) == crank))
    drifts = []
    for steps in (200, 400):
        state = np.array(pp.servo_cycle(press, angle=[0.0], speed=7.0).v[0])
        x, v, h, none = press.closed.copy(), state, 0.5 / steps, np.zeros(5)
        start = sum(dynamics.energy(x, v))
        for _ in range(steps):
            slopes = [(v, dynamics.acceleration(x, v, none))]
            for share in (0.5, 0.5, 1.0):
                u = v + share * h * slopes[-1][1]
                slopes.append((u, dynamics.acceleration(x + share * h * slopes[-1][0], u, none)))
            x, v = (y + h / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3]) for y, k in zip((x, v), zip(*slopes, strict=True), strict=True))
            x, v, gap = dynamics.project(x, v)
            assert gap < 1e-13
        drifts.append(abs(sum(dynamics.energy(x, v)) - start) / start)
    assert drifts[1] < 1e-7
    assert 8 < drifts[0] / drifts[1] < 40


def test_points(case):
    """Where a point is, from Pinocchio's frames of the unchanged model; 1e-12. Its force has the same power as its efforts at any rates of
    the open tree."""
    rng, model, data = np.random.default_rng(5), case.press.model, case.press.model.createData()
    size = case.press.size
    for x, _, q in states(case)[:2]:
        v, force = rng.normal(size=model.nv), rng.normal(size=3)
        pin.forwardKinematics(model, data, q, v)
        case.dynamics.gap(0.9 * x)
        case.dynamics.place(x)  # nothing is left over from the other state
        for joint in range(model.njoints):
            point = size * rng.normal(size=3)
            place, efforts = case.dynamics.point(joint, point), case.dynamics.point_efforts(joint, point, force)
            turning = data.oMi[joint].rotation @ data.v[joint].angular
            velocity = data.oMi[joint].rotation @ data.v[joint].linear + np.cross(turning, data.oMi[joint].rotation @ point)
            assert np.abs(place - data.oMi[joint].act(point)).max() <= 1e-12 * (1 + size)
            assert efforts.shape == (model.nv,)
            assert abs(efforts @ v - force @ velocity) <= 1e-12 * (1 + np.abs(efforts * v).sum())


# ---------------------------------------------------------------------------------------------------------------------------- projection


def test_closed_states_are_left_alone(case):
    """To rounding of the loops: the same arrays' values, and a fresh array."""
    for x, v, _ in states(case):
        at, rates, gap = case.dynamics.project(x, v)
        assert at is not x
        assert np.abs(at - x).max() <= 1e-13 * (1 + np.abs(x).max())
        assert np.abs(rates - v).max() <= 1e-12 * np.abs(v).max()
        assert gap <= 1e-13 * (1 + case.press.size)
        assert gap == case.dynamics.gap(at)


def test_projection(case):
    """Perturbed states are closed to 1e-12 m by measure of the tests' own loops, rates belong to them, and once is enough."""
    rng, scale = np.random.default_rng(6), 1 / units(case.press)
    size = case.press.size
    for x, v, _ in states(case):
        moved = x + 1e-3 * size * scale * rng.uniform(-1, 1, len(x))
        at, rates, gap = case.dynamics.project(moved, v)
        q = pin.integrate(case.press.model, pin.neutral(case.press.model), at)
        apart, turned = case.loops.gaps(q)
        assert apart.max(initial=0.0) <= 1e-12 * (1 + size)
        assert turned.max(initial=0.0) <= 1e-7  # from a cross product or a logarithm of rounding: its root
        assert gap <= 1e-12 * (1 + size)
        jacobian, _ = rows(case, q, rates)
        assert np.abs(jacobian @ rates).max() <= 1e-12 * np.abs(rates).max() * (1 + size)
        again, same, _ = case.dynamics.project(at, rates)
        assert np.abs(again - at).max() <= 1e-13 * (1 + np.abs(at).max())
        assert np.abs(same - rates).max() <= 1e-12 * np.abs(rates).max()


def test_the_nearest_state(case):
    """From a state off along the normal the foot of the normal is found, but for the square of the distance: a tenth, a hundredth. Rates
    change along normals only. All in the metric in which every joint moves in lengths."""
    rng, unit = np.random.default_rng(7), units(case.press)
    for x, v, q in states(case)[:3]:
        jacobian = rows(case, q, v)[0] / unit
        tangents = null_space(jacobian)
        normal = rng.normal(size=len(x))
        normal -= tangents @ (tangents.T @ normal)
        normal *= case.press.size / np.linalg.norm(normal)
        far, near = (np.linalg.norm(unit * (case.dynamics.project(x + h * normal / unit, v)[0] - x)) for h in (1e-3, 1e-4))
        assert near <= 1e-5 * case.press.size
        assert near <= 0.02 * far + 1e-12
        other = v + normal / unit
        np.testing.assert_allclose(case.dynamics.project(x, other)[1], v, rtol=0, atol=1e-10 * np.abs(other).max())


def test_the_gap():
    """What a loop is drawn apart, and a coupling; many turns of the crank cost digits and no more."""
    press = texts.shipped("zxn2_3000b")
    dynamics = press.forward_dynamics(np.zeros(5))
    slide = press.slide_guide[0]
    assert dynamics.gap(press.closed + 1e-3 * (np.arange(5) == slide)) == pytest.approx(1e-3, rel=1e-9)
    x = pp.servo_cycle(press, angle=[0.7], speed=1.0).joint_position[0] + 1e5 * press.branch.gain_per_period
    x[slide] += 1e-6
    at, _, gap = dynamics.project(x, np.zeros(5))
    assert gap < 1e-9
    assert np.abs(at - x).max() < 1e-5
    geared = texts.shipped("jf75g_125_symmetric")
    turned = geared.closed + 1e-3 * np.array([joint in ("O_left",) for joint in geared.joints])
    assert geared.forward_dynamics(np.zeros(8)).gap(turned) == pytest.approx(1e-3 * geared.size, rel=1e-9)
