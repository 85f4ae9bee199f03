"""Loads, and the laws that any mechanism obeys: virtual work, linearity, scale, energy."""

import re

import numpy as np
import pinocchio as pin
import pytest
from support import texts

import pinpress as pp

SPEED = 70 * pp.RPM
SERVO = {"angle": np.linspace(-7, 4, 23), "speed": 6 * np.cos(np.linspace(0, 5, 23)), "acceleration": 40 * np.sin(np.linspace(1, 8, 23))}


@pytest.fixture(scope="module")
def zxn2():
    return texts.shipped("zxn2_3000b")


def numbers(result):
    """Every number of a result as (forces (bearings + 1, n, 3), moments (bearings + 2, n, 3))."""
    torque = np.zeros_like(result.shaking_force)
    torque[:, 0] = result.driving_torque
    return (
        np.array([*result.bearing_force.values(), result.shaking_force]),
        np.array([*result.bearing_moment.values(), result.shaking_moment, torque]),
    )


def same(one, other, bound):
    """Forces and moments within ``bound`` of their peaks."""
    for a, b in zip(numbers(one), numbers(other), strict=True):
        assert np.abs(a - b).max() <= bound * np.abs(a).max()


@pytest.fixture(scope="module")
def motion(zxn2):
    return pp.servo_cycle(zxn2, **SERVO)


# ---------------------------------------------------------------------------------------------------------------------------- loads


def test_a_load_may_be_constant_array_or_function(zxn2, motion, engine):
    """The three ways to write the same load give the same numbers, bit by bit."""
    force = np.array([2e4, 0.0, 1e6])
    tiled = np.tile(force, (len(motion.crank_angle), 1))
    written = (force, tiled, lambda m: np.tile(force, (len(m.crank_angle), 1)), lambda m: tuple(force))
    results = [pp.inverse_dynamics(zxn2, motion, [pp.loads.PointForce("slide", each, (0.1, 0.2, -0.7))], engine=engine) for each in written]
    for other in results[1:]:
        same(results[0], other, 0.0)
    bare = pp.inverse_dynamics(zxn2, motion, engine=engine)
    assert np.abs(results[0].driving_torque - bare.driving_torque).max() > 1e4
    # over the motion: a function that follows the slide
    press_fit = pp.loads.PointForce("slide", lambda m: np.outer(np.maximum(0, -0.9 - m.slide_position), [0, 0, 1e8]))
    pressed = pp.inverse_dynamics(zxn2, motion, [press_fit], engine=engine)
    changed = np.abs(pressed.driving_torque - bare.driving_torque) > 1.0
    assert 0 < changed.sum() < len(changed)
    assert not changed[motion.slide_position > -0.9].any()


def test_virtual_work(zxn2, motion, engine):
    """A force F up on the slide changes the torque by -F v / omega, and one on the rocker by its own power; 1e-10 of the peak change.

    The change is a difference of torques ten times as large, so it has a digit less. Rates are taken at crank speed 1.
    """
    unit = pp.servo_cycle(zxn2, angle=motion.crank_angle, speed=1.0)
    bare = pp.inverse_dynamics(zxn2, motion, engine=engine)
    force = np.linspace(-3e6, 2e6, len(motion.crank_angle))
    load = pp.loads.PointForce("slide", force[:, None] * np.array([0.0, 0.0, 1.0]), (0.3, -0.1, -0.7))
    change = pp.inverse_dynamics(zxn2, motion, [load], engine=engine).driving_torque - bare.driving_torque
    expected = -force * unit.slide_velocity
    assert np.abs(change - expected).max() <= 1e-10 * np.abs(expected).max()
    # on the rocker's pin E, 0.48 m from D: velocity = rate of D times the arm turned by 90 degrees
    angle = 0.850905189263493 - 0.75 * np.pi + motion.q[:, zxn2.model.joints[zxn2.joints.index("D") + 1].idx_q]
    velocity = 1j * unit.v[:, zxn2.joints.index("D")] * 0.48 * np.exp(1j * angle)
    on_e = pp.loads.PointForce("rocker", (7e4, 3e4, -5e4), (-0.33941125496954277, 0.0, -0.33941125496954283))
    change = pp.inverse_dynamics(zxn2, motion, [on_e], engine=engine).driving_torque - bare.driving_torque
    expected = -(7e4 * velocity.real - 5e4 * velocity.imag)
    assert np.abs(change - expected).max() <= 1e-10 * np.abs(expected).max()


def test_a_force_on_the_frame_goes_to_the_foundation(zxn2, motion, engine):
    """It changes the shaking force by itself, the shaking moment by its arm, and nothing else, bit by bit."""
    force, point = np.array([1e4, -2e4, 5e4]), np.array([0.3, 0.1, -1.9])
    bare = pp.inverse_dynamics(zxn2, motion, engine=engine)
    loaded = pp.inverse_dynamics(zxn2, motion, [pp.loads.PointForce("frame", force, tuple(point))], engine=engine)
    np.testing.assert_array_equal(loaded.driving_torque, bare.driving_torque)
    for name in zxn2.bearings:
        np.testing.assert_array_equal(loaded.bearing_force[name], bare.bearing_force[name])
        np.testing.assert_array_equal(loaded.bearing_moment[name], bare.bearing_moment[name])
    peak = np.abs(bare.shaking_force).max()
    np.testing.assert_allclose(loaded.shaking_force - bare.shaking_force, np.tile(force, (23, 1)), rtol=0, atol=1e-14 * peak)
    moment = np.tile(np.cross(point, force), (23, 1))
    np.testing.assert_allclose(loaded.shaking_moment - bare.shaking_moment, moment, rtol=0, atol=1e-14 * np.abs(bare.shaking_moment).max())


def test_a_forming_force_inside_the_machine_does_not_shake_it(zxn2, motion, engine):
    """Load on the slide and its reaction on the frame, on one line x = 0: nothing reaches the foundation. 1e-12 of the load: rounding."""
    up = np.array([0.0, 0.0, 3e6])
    pair = [pp.loads.PointForce("slide", up, (0, 0, -0.7)), pp.loads.PointForce("frame", -up, (0, 0, -1.88))]
    bare, loaded = (pp.inverse_dynamics(zxn2, motion, loads, engine=engine) for loads in ([], pair))
    assert np.abs(loaded.shaking_force - bare.shaking_force).max() <= 1e-12 * 3e6
    assert np.abs(loaded.shaking_moment - bare.shaking_moment).max() <= 1e-12 * 3e6
    alone = pp.inverse_dynamics(zxn2, motion, pair[:1], engine=engine)
    np.testing.assert_allclose(alone.shaking_force - bare.shaking_force, np.tile(up, (23, 1)), rtol=0, atol=1e-12 * 3e6)


# ------------------------------------------------------------------------------------------------------------------------ linearity


def test_torque_and_forces_are_affine(zxn2, engine):
    """At a crank angle: weight, plus parts proportional to omega^2, alpha and the load. 1e-12 of the peak: a sum of four."""
    angle = np.linspace(0.1, 6.0, 7)

    def at(speed, acceleration, load):
        loads = [pp.loads.PointForce("rod", load * np.array([1e5, 2e4, 7e5]), (0.2, 0.05, 0.1))]
        return numbers(
            pp.inverse_dynamics(zxn2, pp.servo_cycle(zxn2, angle=angle, speed=speed, acceleration=acceleration), loads, engine=engine)
        )

    weight, fast, sped_up, loaded = at(0, 0, 0), at(2.0, 0, 0), at(0, 3.0, 0), at(0, 0, 0.5)
    for k, whole in enumerate(at(-7.0, -20.0, 1.3)):
        parts = (fast[k] - weight[k]) * (49 / 4), (sped_up[k] - weight[k]) * (-20 / 3), (loaded[k] - weight[k]) * (1.3 / 0.5)
        assert np.abs(whole - weight[k] - sum(parts)).max() <= 1e-12 * max(np.abs(part).max() for part in (whole, weight[k], *parts))
        assert min(np.abs(part).max() for part in parts) > 1e-3 * np.abs(whole).max()


def test_weight_is_what_gravity_adds(engine):
    """Without gravity, speed and load nothing acts at all; with it, forces are proportional to it."""
    free, earth, double = (texts.shipped("zxn2_3000b", gravity=(0, 0, g)) for g in (0.0, -9.81, -19.62))
    poses = {"angle": np.linspace(0, 6, 9), "speed": 0.0}
    still = [pp.inverse_dynamics(p, pp.servo_cycle(p, **poses, engine=engine), engine=engine) for p in (free, earth, double)]
    for values in numbers(still[0]):
        assert not values.any()
    assert not still[0].power_residual.any()
    for one, two in zip(numbers(still[1]), numbers(still[2]), strict=True):
        assert np.abs(2 * one - two).max() <= 1e-14 * np.abs(two).max()
    total = np.array([0.0, 0.0, -9.81 * sum(inertia.mass for inertia in earth.model.inertias)])
    np.testing.assert_allclose(still[1].shaking_force, np.tile(total, (9, 1)), rtol=1e-13, atol=1e-13 * abs(total[2]))


# ---------------------------------------------------------------------------------------------------------------------------- scale


def scaled(press, length, mass):
    """The same press with all lengths and masses multiplied."""

    def times(factor):
        return lambda match: match[1] + " ".join(repr(float(x) * factor) for x in match[2].split()) + '"'

    text = press.text.decode()
    for pattern, factor in (
        (r'(<(?:origin|link[12] link="\w+") xyz=")([^"]*)"', length),
        (r'(<mass value=")([^"]*)"', mass),
        (r'(\bi[xyz]{2}=")([^"]*)"', mass * length**2),
    ):
        text = re.sub(pattern, times(factor), text)
    return texts.load(text, gravity=tuple(press.model.gravity.linear * length))


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")  # sizes and densities of no press
@pytest.mark.parametrize(("length", "mass"), [(1e-6, 1.0), (1e3, 1e-3), (1.0, 1e6), (1e-6, 1e-18)])
def test_scale(zxn2, length, mass, engine):
    """Lengths times s, masses times m, gravity times s: forces times m s, moments times m s^2, joint rates as they were. No length in the
    library may be an absolute one: 1e-12 of the peak is rounding."""
    other = scaled(zxn2, length, mass)
    weight = np.array([length if name == "slide_guide" else 1.0 for name in zxn2.joints])
    motions = [pp.servo_cycle(p, **SERVO, engine=engine) for p in (zxn2, other)]
    for name in ("v", "a"):
        one, two = (getattr(m, name) for m in motions)
        assert np.abs(one - two / weight).max() <= 1e-12 * np.abs(one).max()
    force, point = np.array([1e5, 2e5, -8e5]), np.array([0.1, 0.2, -0.7])
    results = [
        pp.inverse_dynamics(p, m, [pp.loads.PointForce("slide", force * f, tuple(point * s))], engine=engine)
        for p, m, f, s in zip((zxn2, other), motions, (1.0, mass * length), (1.0, length), strict=True)
    ]
    units = (mass * length, mass * length**2)
    for one, two, unit in zip(*map(numbers, results), units, strict=True):
        assert np.abs(one - two / unit).max() <= 1e-12 * np.abs(one).max()
    for name in zxn2.bearings:
        np.testing.assert_array_equal(results[0].indeterminate[name], results[1].indeterminate[name])
    assert np.abs(results[1].power_residual).max() < 1e-13


# --------------------------------------------------------------------------------------------------------------------------- energy


def test_power_balance(zxn2, motion, engine):
    """With loads, through standstill and at rest throughout: finite, and rounding (1e-13)."""
    loads = [pp.loads.PointForce("rod", (3e5, 1e4, -2e5), (0.2, 0.1, 0.0)), pp.loads.PointForce("crank", (0, 1e4, 1e5), (0.1, 0.0, 0.2))]
    result = pp.inverse_dynamics(zxn2, motion, loads, engine=engine)
    assert result.power_residual.shape == (23,)
    assert np.abs(result.power_residual).max() < 1e-13
    wrong = pp.inverse_dynamics(zxn2, motion, loads, engine=engine)  # the residual is worked out apart from the torque
    object.__setattr__(wrong, "driving_torque", result.driving_torque * 1.001)
    assert np.abs(wrong.power_residual).max() > 1e-4
    rest = pp.inverse_dynamics(zxn2, pp.servo_cycle(zxn2, angle=[0.0, 1.0, 2.0], speed=0.0, acceleration=5.0), loads, engine=engine)
    np.testing.assert_array_equal(rest.power_residual, np.zeros(3))
    through = pp.servo_cycle(zxn2, angle=[1.0, 1.1, 1.1, 1.0], speed=[2.0, 0.0, 0.0, -2.0], acceleration=-3.0)
    assert np.abs(pp.inverse_dynamics(zxn2, through, loads, engine=engine).power_residual).max() < 1e-13


@pytest.mark.parametrize("press_name", ["zxn2_3000b", "zxn2_3000b_balanced", "crank_slide"])
def test_a_turn_at_constant_speed_does_no_work(press_name):
    """Kinetic and potential energy come back, so the mean torque is zero: 1e-12 of the peak. (Equal steps over a period integrate a smooth
    function to rounding.)"""
    press = texts.shipped(press_name)
    for speed in (SPEED, -SPEED):
        torque = pp.inverse_dynamics(press, pp.cycle(press, speed, points=360)).driving_torque
        assert abs(torque.mean()) <= 1e-12 * np.abs(torque).max()


def test_work_is_energy(zxn2):
    """Torque over a part of a turn at constant speed is the kinetic and potential energy gained: Gauss-Legendre in 60 points, 1e-11."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    start, end = 0.4, 3.1
    angle = start + (end - start) * (nodes + 1) / 2
    work = (pp.inverse_dynamics(zxn2, pp.servo_cycle(zxn2, angle=angle, speed=SPEED)).driving_torque @ weights) * (end - start) / 2
    ends = pp.servo_cycle(zxn2, angle=[start, end], speed=SPEED)
    data = zxn2.model.createData()
    energy = [
        pin.computeKineticEnergy(zxn2.model, data, q, v) + pin.computePotentialEnergy(zxn2.model, data, q)
        for q, v in zip(ends.q, ends.v, strict=True)
    ]
    assert work == pytest.approx(energy[1] - energy[0], rel=1e-11)


# ---------------------------------------------------------------------------------------------------------------- drivers and motions


def test_another_driver_does_the_same_work(engine):
    """Driven at the rod's pin P instead of the crank, with the motion that the crank gave it: the same states and power; 1e-12."""
    by_crank, by_rod = texts.shipped("crank_slide"), pp.load("crank_slide", driver="P")
    assert by_rod.driver == "P"
    motion = pp.servo_cycle(by_crank, angle=np.linspace(-4, 5, 31), speed=np.linspace(3, 6, 31), acceleration=-20.0, engine=engine)
    p, o = (by_crank.joints.index(name) for name in "PO")
    # rod's angle against the crank: sin psi = lam sin q, turned back by q
    angle = -(motion.crank_angle + np.arcsin(0.25 * np.sin(motion.crank_angle)))
    driven = pp.servo_cycle(by_rod, angle=angle, speed=motion.v[:, p], acceleration=motion.a[:, p], engine=engine)
    for name in ("v", "a", "q"):
        expected = getattr(motion, name)
        assert np.abs(getattr(driven, name) - expected).max() <= 1e-12 * np.abs(expected).max()
    one, two = (pp.inverse_dynamics(press, m, engine=engine) for press, m in ((by_crank, motion), (by_rod, driven)))
    power = one.driving_torque * motion.v[:, o]
    assert np.abs(two.driving_torque * driven.v[:, p] - power).max() <= 1e-12 * np.abs(power).max()
    # what the foundation feels does not depend on where power comes in
    peak = np.abs(one.shaking_force).max()
    assert np.abs(one.shaking_force - two.shaking_force).max() <= 1e-12 * peak
    assert np.abs(one.shaking_moment - two.shaking_moment).max() <= 1e-12 * peak
    assert np.abs(one.bearing_force["W"] - two.bearing_force["W"]).max() > 1e-3 * peak
    assert np.abs(two.power_residual).max() < 1e-13


def test_a_motion_serves_another_press_of_the_same_lengths(zxn2, motion, engine):
    """The balanced press moves as the unbalanced one: its forces from either motion are the same to rounding (1e-12 of the peak)."""
    balanced = texts.shipped("zxn2_3000b_balanced")
    own = pp.inverse_dynamics(balanced, pp.servo_cycle(balanced, **SERVO), engine=engine)
    lent = pp.inverse_dynamics(balanced, motion, engine=engine)
    same(own, lent, 1e-12)
    assert np.abs(lent.power_residual).max() < 1e-13
    assert np.abs(own.driving_torque - pp.inverse_dynamics(zxn2, motion, engine=engine).driving_torque).max() > 100.0


@pytest.mark.parametrize(
    ("load", "named"),
    [
        (pp.loads.PointForce("slide", (0.0, 1.7e308, 0.0)), "bearing force"),  # across the plane, where no drive feels it
        (pp.loads.PointForce("slide", (0.0, 1e10, 0.0), (1e300, 0.0, 0.0)), "bearing moment"),
        (pp.loads.PointForce("slide", (0.0, 0.0, 1.7e308)), "driving torque"),
    ],
)
def test_what_is_not_finite_is_named_with_its_angle(load, named):
    """Of two loads that overflow together, in one of five states."""
    press = texts.shipped("zxn2_3000b")
    motion = pp.servo_cycle(press, angle=np.radians([10.0, 20.0, 30.0, 40.0, 50.0]), speed=7.0)
    force = np.zeros((5, 3))
    force[3] = load.force
    with pytest.raises(pp.PinpressError, match=f"^the {named} of zxn2_3000b is not finite at crank angle 40 deg"):
        pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce(load.link, force, load.point)] * 2)


def test_forces_whose_squares_are_too_large_for_floating_point():
    """They are returned, and proportional to the load: nothing else counts beside it."""
    press = pp.load("zxn2_3000b")
    motion = pp.cycle(press, speed=SPEED, points=9)
    small, large = (pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slide", (0.0, 0.0, size))]) for size in (1e20, 1e200))
    np.testing.assert_allclose(large.driving_torque, small.driving_torque * 1e180, rtol=1e-12)
    for name in press.bearings:
        scale = np.abs(large.bearing_force[name]).max()
        np.testing.assert_allclose(large.bearing_force[name], small.bearing_force[name] * 1e180, rtol=0, atol=1e-12 * scale)


HORIZONTAL = """<robot name="disc"><link name="frame"/><link name="disc"><inertial><origin xyz="0.2 0 0.1"/><mass value="40"/>
<inertia ixx="2" ixy="0" ixz="0" iyy="3" iyz="0" izz="2"/></inertial></link><joint name="O" type="continuous">
<origin xyz="0.3 0 0.7" rpy="1.5707963267948966 0 0"/><parent link="frame"/><child link="disc"/><axis xyz="0 -1 0"/></joint>
<transmission name="drive"><joint name="O"/></transmission></robot>"""


@pytest.fixture(scope="module")
def horizontal():
    return texts.load(HORIZONTAL)


def kept_in(press, angle, speed):
    """States that go through the same crank angle again and again."""
    none = np.zeros(5)
    return pp.servo_cycle(press, angle=none + angle, speed=none + speed, acceleration=none)


@pytest.mark.parametrize("case", ["a disc whose weight does no work", "dead centre", "dead centre without weights", "next to nothing"])
def test_where_all_powers_are_rounding_their_residual_is_small(horizontal, engine, case):
    """1e-14 of forces times velocities, of which a millionth is what it is beside."""
    if case == "a disc whose weight does no work":
        press, motion = horizontal, pp.cycle(horizontal, 7.0, points=40)
    else:
        press = texts.shipped("crank_slide", gravity=(0, 0, -9.81 if case == "dead centre" else 0.0))
        motion = pp.cycle(press, 1e-105, points=20) if case == "next to nothing" else kept_in(press, np.pi, 3.0)
    result = pp.inverse_dynamics(press, motion, engine=engine)
    assert np.abs(result.power_residual).max() < 1e-8


@pytest.mark.parametrize("share", [1e-3, 1.0])
def test_a_small_torque_that_is_wrong_shows_all_the_same(horizontal, engine, share):
    """Some 5e-3 N m accelerate the disc, whose centre is held to its circle by 430 N: the share by which a torque is wrong shows."""
    n = 9
    motion = pp.servo_cycle(horizontal, angle=np.linspace(0, 1, n), speed=np.full(n, 7.0), acceleration=np.full(n, 1e-3))
    result = pp.inverse_dynamics(horizontal, motion, engine=engine)
    torque = float(np.abs(result.driving_torque).max())
    assert np.abs(result.power_residual).max() < 1e-9
    wrong = pp.inverse_dynamics(horizontal, motion, engine=engine)
    object.__setattr__(wrong, "driving_torque", result.driving_torque * (1 + share))
    assert np.abs(wrong.power_residual).max() > 0.3 * share
    assert 1e-3 < torque < 1e-2
