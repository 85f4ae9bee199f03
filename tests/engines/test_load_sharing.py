"""Gear pairs, and forces that rigid mechanics leaves open, against dense equations of all bodies cut free.

Every bearing has a force and a moment as unknowns there, every gear pair and drive an effort; what balances without any motion is the null
space, by singular values, and the share is chosen in it by least squares (`cut_free`). Nothing of that is the library's but the kinematics.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support import texts
from support.exploring import examples
from support.generators.random_linkages import Group, Spec, drawn, linkages, momentum_balance
from support.generators.redundant_linkages import LINKAGES, NOT_PLANAR, double, five_bar, wheels
from support.oracles.cut_free import cut_free, gears
from support.texts import load

import pinpress as pp
from pinpress.engines.sharing import Objective, lexicographic_least_squares

ENGINES = ("plane", "space", "pinocchio")


# ----------------------------------------------------------------------------------------------------------------------------- linkages


BOTH = [(name, engine) for name in LINKAGES for engine in ENGINES if engine == "pinocchio" or name not in NOT_PLANAR]
SERVO = {"angle": np.array([-0.3, 0.1, 0.45]), "speed": np.array([-6.0, 4.0, 9.0]), "acceleration": np.array([30.0, -50.0, 10.0])}


class Case(NamedTuple):
    press: pp.Linkage
    motion: pp.Motion
    loads: list


@cache
def case(name):
    made = LINKAGES[name]()
    press = made if isinstance(made, pp.Linkage) else load(made)
    loads = [pp.loads.PointForce(link, (100.0, -300.0, 900.0), (0.05, 0.1, -0.1)) for link in press.links[1:3]]
    return Case(press, pp.servo_cycle(press, **SERVO), loads)


@cache
def expected(name, stiffness):
    press, motion, loads = case(name)
    return [cut_free(press, motion, i, loads, dict(stiffness)) for i in range(len(motion.q))]


def errors(press, result, states):
    """Largest differences: forces by their peak; moments, torques of drives and of gear pairs by that of moments."""
    wrenches = np.array([state.wrenches for state in states])
    force = np.abs(wrenches[:, :, :3]).max()
    moment = max(np.abs(wrenches[:, :, 3:]).max(), force * press.size)
    for k, name in enumerate(press.bearings):
        yield np.abs(result.bearing_force[name] - wrenches[:, k, :3]).max() / force
        yield np.abs(result.bearing_moment[name] - wrenches[:, k, 3:]).max() / moment
    yield np.abs(result.driving_torque - [state.drives[0] for state in states]).max() / moment
    for k, (follower, _, multiplier) in enumerate(gears(press)):
        torque = np.array([state.couplings[k] for state in states])
        yield np.abs(result.coupling_torque[follower] - np.stack([torque, -multiplier * torque], axis=1)).max() / moment


# ------------------------------------------------------------------------------------------------------------------------------- tests


@pytest.mark.one_in(23)
@pytest.mark.parametrize("stiff", ["none", "some", "all"])
@pytest.mark.parametrize(("name", "engine"), BOTH)
def test_bodies_cut_free(name, engine, stiff):
    """All forces, moments and torques, 1e-12 of their peaks, with loads across the plane; shared with and without stiffnesses. Components
    are open that idle forces reach, by singular values, in any of the states; the foundation gets weight and loads less the rate of
    momentum."""
    press, motion, loads = case(name)
    names = press.bearings if stiff == "all" else press.bearings[1::2] if stiff == "some" else ()
    stiffness = {bearing: 1e8 * (1 + 7 * k % 5) for k, bearing in enumerate(names)}
    result = pp.inverse_dynamics(press, motion, loads, stiffness=stiffness, engine=engine)
    assert result.engine == engine
    states = expected(name, tuple(stiffness.items()))
    assert max(errors(press, result, states)) <= 1e-12
    assert np.abs(result.power_residual).max() <= 1e-12
    for k, bearing in enumerate(press.bearings):
        assert result.indeterminate[bearing].tolist() == np.any([state.open[k] for state in states], axis=0).tolist(), bearing
    for k, (follower, *_) in enumerate(gears(press)):
        assert result.indeterminate_coupling[follower] == any(state.open_couplings[k] for state in states), follower
    assert result.indeterminate_coupling.keys() == result.coupling_torque.keys()
    peak = max(np.abs(force).max() for force in result.bearing_force.values())
    force, moment = momentum_balance(press, motion, loads)
    assert np.abs(result.shaking_force - force).max() <= 1e-12 * peak
    assert np.abs(result.shaking_moment - moment).max() <= 1e-12 * max(peak * press.size, np.abs(moment).max())


def test_the_torque_of_a_gear_pair_is_open_where_rods_could_carry_it():
    """In the symmetric press and in a ring of gears; in a gear train each is certain."""
    for name, opened in (("symmetric", True), ("ring", True), ("chain", False), ("five_bar", False)):
        press, motion, loads = case(name)
        flags = pp.inverse_dynamics(press, motion, loads).indeterminate_coupling
        assert set(flags.values()) == {opened}, name


def test_gear_train_in_closed_form(engine):
    """Three eccentric shafts: each needs I alpha + weight x lever, the crank what all need, times their ratios; 1e-12."""
    press = load(wheels(("s1", "crank", -2.0, 0.03), ("s2", "s1", 1.5, -0.01), linked=False))
    result = pp.inverse_dynamics(press, pp.servo_cycle(press, **SERVO), engine=engine)
    shafts = {"crank": (4.0, 0.05 + 0.1j, 1.0, 0.0, 1), "s1": (3.0, 0.05 + 0.1j, -2.0, 0.03, 1), "s2": (4.0, 0.05 + 0.1j, -3.0, 0.035, -1)}
    needed = {}
    for name, (mass, lever, ratio, offset, sense) in shafts.items():
        inertia = mass * (abs(lever) ** 2 + 0.01)
        turned = lever * np.exp(1j * sense * (ratio * SERVO["angle"] + offset))
        needed[name] = inertia * ratio * SERVO["acceleration"] + sense * 9.81 * mass * turned.real
    second = needed["s2"]
    first = needed["s1"] + 1.5 * second
    whole = needed["crank"] - 2.0 * first
    for found, torque in (
        (result.driving_torque, whole),
        (result.coupling_torque["s1"], np.stack([first, 2.0 * first], axis=1)),
        (result.coupling_torque["s2"], np.stack([second, -1.5 * second], axis=1)),
    ):
        assert np.abs(found - torque).max() <= 1e-12 * np.abs(whole).max()


def test_rack_and_pinion_in_closed_form(engine):
    """A rack of 7 kg on a slope of 0.3 rad, 0.2 m by the radian: the pinion pushes it along with m (a + g sin), 1e-12."""
    press = load(wheels(("rack", "crank", 0.2, 0.05), linked=False))
    motion = pp.servo_cycle(press, **SERVO)
    at = press.joints.index("rack")
    assert np.abs(motion.joint_position[:, at] - 0.2 * SERVO["angle"] - 0.05).max() <= 1e-15
    result = pp.inverse_dynamics(press, motion, engine=engine)
    push = 7.0 * (0.2 * SERVO["acceleration"] + 9.81 * np.sin(0.3))
    assert np.abs(result.coupling_torque["rack"] - np.stack([push, -0.2 * push], axis=1)).max() <= 1e-12 * np.abs(push).max()
    along = np.array([np.cos(0.3), 0.0, np.sin(0.3)])
    assert np.abs(result.bearing_force["rack"] @ along).max() <= 1e-12 * np.abs(push).max()  # the teeth carry it, and press on the shaft
    without = load(wheels(linked=False))
    alone = pp.inverse_dynamics(without, pp.servo_cycle(without, **SERVO), engine=engine)
    pressed = result.bearing_force["crank"] - alone.bearing_force["crank"]
    assert np.abs(pressed - push[:, None] * along).max() <= 1e-12 * np.abs(push).max()


def test_a_five_bar_stays_closed(engine):
    """All the way round, its second crank at the multiple of the first that the gears give it."""
    press = load(five_bar(-1.0))
    assert press.mobility == 1
    motion = pp.cycle(press, 4.0, points=24, engine=engine)
    assert motion.closure_error.max() <= 1e-13
    second = press.joints.index("second")
    assert np.abs(motion.joint_position[:, second] + motion.crank_angle).max() <= 1e-14
    assert np.abs(motion.v[:, second] + 4.0).max() <= 1e-13
    assert np.abs(motion.a[:, press.joints.index("L")]).max() > 1.0


@pytest.mark.parametrize("ratio", [170 / 861, -861 / 170, float(np.sqrt(2))])
def test_any_gear_ratio_can_be_driven(ratio, engine):
    """A shaft that no loop holds need not come back to its start: with such teeth it never does, or after many turns. It is driven through
    angles; one period of it would be no cycle."""
    press = load(wheels(("s1", "crank", ratio)))
    with pytest.raises(pp.PinpressError, match="has no period"):
        pp.cycle(press, 5.0, points=12, engine=engine)
    motion = pp.servo_cycle(press, angle=np.linspace(0.0, 6.0, 12), speed=5.0, engine=engine)
    assert np.abs(motion.joint_position[:, press.joints.index("s1")] - ratio * motion.crank_angle).max() <= 1e-13
    far = pp.servo_cycle(press, angle=[1e3], speed=5.0, engine=engine)
    assert far.joint_position[0, press.joints.index("s1")] == pytest.approx(1e3 * ratio, rel=1e-13)


@pytest.mark.parametrize("ratio", [0.1, 0.0511])
def test_a_rack_need_not_come_back(ratio, engine):
    """It travels on, turn by turn, whatever the pinion's radius."""
    press = load(wheels(("rack", "crank", ratio)))
    motion = pp.servo_cycle(press, angle=np.linspace(0.0, 41.0, 9), speed=5.0, engine=engine)
    assert np.abs(motion.joint_position[:, press.joints.index("rack")] - ratio * motion.crank_angle).max() <= 1e-13


@pytest.mark.parametrize("name", ["two_point", "three_held_rods", "geared_cranks"])
def test_only_ratios_of_stiffnesses_count(name, engine):
    """All of them a millionfold share the same; 1e-12 of the peak."""
    press, motion, loads = case(name)
    soft = {bearing: 1e6 * (1 + k) for k, bearing in enumerate(press.bearings)}
    hard = {bearing: 1e6 * value for bearing, value in soft.items()}
    one, two = (pp.inverse_dynamics(press, motion, loads, stiffness=each, engine=engine) for each in (soft, hard))
    peak = max(np.abs(force).max() for force in one.bearing_force.values())
    for bearing in press.bearings:
        assert np.abs(one.bearing_force[bearing] - two.bearing_force[bearing]).max() <= 1e-12 * peak


@pytest.mark.parametrize("name", ["two_point", "symmetric", "three_held_rods", "geared_cranks", "chain"])
def test_a_stiffness_of_any_one_bearing(name):
    """Its force is the least that idle forces can make it, then the rest. Where they hardly reach it, as a shaft that is geared to the
    driver, large ones decide, and rounding grows with them."""
    press, motion, loads = case(name)
    for bearing in press.bearings:
        state = cut_free(press, motion, 1, loads, {bearing: 1e9})
        for engine in ENGINES:
            moved = pp.servo_cycle(press, **{key: values[1:2] for key, values in SERVO.items()}, engine=engine)
            result = pp.inverse_dynamics(press, moved, loads, stiffness={bearing: 1e9}, engine=engine)
            assert max(errors(press, result, [state])) <= 100 * np.finfo(float).eps / state.least, (bearing, engine)


@pytest.mark.parametrize(
    ("name", "bearing"),
    [
        ("two_point", "O"),
        ("two_point", "slide_guide"),
        ("two_point", "P5"),
        ("symmetric", "slide_guide"),
        ("symmetric", "counterweight_guide"),
    ],
)
def test_a_stiffness_that_idle_forces_do_not_reach(name, bearing, engine):
    """Changes nothing: its energy is rounding, and nothing may be shared by that. The symmetric press
    does not press on its guides anyway. 1e-9 of the peak: near dead centres, zero is ill determined."""
    press = case(name).press
    motion = pp.cycle(press, speed=30.0, points=36, engine=engine)
    bare, result = (pp.inverse_dynamics(press, motion, stiffness=each, engine=engine) for each in ({}, {bearing: 1e9}))
    peak = max(np.abs(force).max() for force in bare.bearing_force.values())
    for other in press.bearings:
        assert np.abs(result.bearing_force[other] - bare.bearing_force[other]).max() <= 1e-9 * peak, other


def test_a_soft_rod_carries_nothing_but_itself(engine):
    """A millionth of the others' stiffness: what is left along it is a millionth, and what its own mass needs."""
    press, motion, _ = case("three_rods")
    heavy = [pp.loads.PointForce("slide", (0.0, 0.0, 1e6))]
    stiffness = {"W0": 1e9, "W1": 1e3, "W2": 1e9}
    loaded, idle = (pp.inverse_dynamics(press, motion, loads, stiffness=stiffness, engine=engine) for loads in (heavy, []))
    share = {name: np.abs(loaded.bearing_force[name] - idle.bearing_force[name]).max() for name in stiffness}
    assert share["W0"] == pytest.approx(share["W2"], rel=1e-9)
    assert 0.9e-6 * share["W0"] <= share["W1"] <= 1.1e-6 * share["W0"]


def test_stiffness_does_not_matter_where_nothing_is_open(engine):
    """The six-bar in its plane: the same to rounding, 1e-13."""
    press = texts.shipped("zxn2_3000b")
    motion = pp.servo_cycle(press, **SERVO)
    one, two = (pp.inverse_dynamics(press, motion, stiffness=each, engine=engine) for each in ({}, {"B": 1e6, "slide_guide": 1e9}))
    for bearing in press.bearings:
        assert np.abs(one.bearing_force[bearing] - two.bearing_force[bearing]).max() <= 1e-13 * np.abs(one.bearing_force["A"]).max()


@pytest.mark.parametrize(
    ("stiffness", "message"),
    [({"W0": 1e9, "W1": 0.0}, "stiffness of 'W1'"), ({"W_1": 1e9}, "did you mean 'W1'"), (1e9, "mapping")],
)
def test_stiffnesses_that_are_none_are_refused(stiffness, message):
    press, motion, _ = case("two_rods")
    with pytest.raises(pp.PinpressError, match=message):
        pp.inverse_dynamics(press, motion, stiffness=stiffness)


# ------------------------------------------------------------------------------------------------------------------- random linkages


@pytest.mark.exhaustive
@examples(5)
@given(spec=linkages(most=2, extra=False, tilted=False), count=st.integers(1, 2), soft=st.booleans())
def test_links_side_by_side(spec, count, soft):
    """Random linkages in which some links stand there twice: both engines against the bodies cut free, 1e-10 of the peaks."""
    drawing = drawn(spec)
    assume(drawing is not None)
    rng = np.random.default_rng(spec.seed + 2)
    double(drawing, rng, count)
    press = load(drawing.urdf("crank"), gravity=tuple(rng.normal(size=3) * 10))
    low, high = (-np.inf, np.inf) if press.branch.period else press.branch.angles[[0, -1]]
    angle = rng.uniform(max(-0.05, 0.5 * low), min(0.05, 0.5 * high), 2)
    motion = pp.servo_cycle(press, angle=angle, speed=rng.uniform(-10, 10, 2), acceleration=rng.uniform(-50, 50, 2))
    loads = [pp.loads.PointForce(str(rng.choice(press.links)), 100 * rng.normal(size=3), tuple(rng.normal(size=3)))]
    stiffness = {name: 10 ** rng.uniform(8, 9) for name in press.bearings if soft and rng.integers(2)}
    states = [cut_free(press, motion, i, loads, stiffness) for i in range(2)]
    reached = np.any([state.open for state in states], axis=0)
    assert "plane" in press.engines
    for engine in ENGINES:
        result = pp.inverse_dynamics(press, motion, loads, stiffness=stiffness, engine=engine)
        assert max(errors(press, result, states)) <= 1e-10
        assert [result.indeterminate[name].tolist() for name in press.bearings] == reached.tolist()


@pytest.mark.exhaustive
def test_a_second_rod_nearly_in_line_with_another():
    """Block by block, such a pair would lock a hair's breadth from the drawn pose; all equations together do not."""
    drawing = drawn(Spec((Group("triad", 0, (0, 0, 0)),), seed=1186975, stacked=True))
    double(drawing, np.random.default_rng(1186977), 1)
    press = load(drawing.urdf("crank"))
    motion = pp.servo_cycle(press, angle=[-0.02, 0.02], speed=3.0)
    result = pp.inverse_dynamics(press, motion)
    assert max(errors(press, result, [cut_free(press, motion, i) for i in range(2)])) <= 1e-10


# ------------------------------------------------------------------------------------------------------- one objective after the other


def one_after_the_other(matrices, starts):
    """The shortest of the y that minimise |A y + b| one after the other, of one state, by singular values."""
    y, ways = np.zeros(matrices[0].shape[1]), np.eye(matrices[0].shape[1])
    for matrix, start in zip(matrices, starts, strict=True):
        left, values, right = np.linalg.svd(matrix @ ways)
        rank = np.count_nonzero(values > 1e-9)
        y = y - ways @ right[:rank].T @ (left[:, :rank].T @ (matrix @ y + start) / values[:rank])
        ways = ways @ right[rank:].T
        if not ways.shape[1]:
            break
    return y


@pytest.mark.parametrize("ranks", [[2, 2, 2], [2, 1, 0], [0, 0, 0]])
@pytest.mark.parametrize("spread", [1.0, 1e-4])  # of singular values: normal equations, and singular values
def test_objectives_one_after_the_other(ranks, spread):
    rng = np.random.default_rng(4)
    first = np.array([rng.normal(size=(7, r)) * spread ** np.arange(r) @ rng.normal(size=(r, 4)) for r in ranks])
    second = np.array([rng.normal(size=(5, 1)) @ rng.normal(size=(1, 4)) for _ in ranks])
    third = rng.normal(size=(3, 6, 4)) if ranks[0] else second
    starts = [rng.normal(size=matrix.shape[:2]) for matrix in (first, second, third)]
    found = lexicographic_least_squares([Objective(*each, 1.0) for each in zip((first, second, third), starts, strict=True)])
    expected = [one_after_the_other([a[i] for a in (first, second, third)], [b[i] for b in starts]) for i in range(3)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_normal_equations_lose_no_digits():
    """Their squared singular values spread over 3e-6, so that they alone would be right to 1e-11."""
    rng = np.random.default_rng(0)
    left, right = np.linalg.qr(rng.normal(size=(5, 9, 4)))[0], np.linalg.qr(rng.normal(size=(5, 4, 4)))[0]
    matrix, start = left * 0.12 ** np.arange(4) @ right, rng.normal(size=(5, 9))
    expected = [-np.linalg.lstsq(*each, rcond=None)[0] for each in zip(matrix, start, strict=True)]
    found = lexicographic_least_squares([Objective(matrix, start, 1.0)])
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
