"""The highest speed against closed forms and against inverse dynamics at that speed and a little above."""

import numpy as np
import pytest
from support.texts import shipped

import pinpress as pp
from pinpress.loads.process import Blanking, ConstantForce
from pinpress.ratings.permissible_force import Capacities
from pinpress.ratings.speed_limits import speed_limit

FINE = 1800  # states of a turn
CLOSER = 4  # times the worst crank angle is looked for between the states beside it
SAME = 1e-10  # of the force: two places of a symmetric press


def worst(press, speed, item, loads=(), angles=None):
    """Largest value of an item over a turn, and the crank angle where it is."""
    if angles is not None:
        values = sizes(press, speed, item, loads, angles)
        return values.max(), angles[values.argmax()]
    step, angle = 2 * np.pi / FINE, worst(press, speed, item, loads, np.linspace(0, 2 * np.pi, FINE, endpoint=False))[1]
    for _ in range(CLOSER):
        amount, angle = worst(press, speed, item, loads, angle + step * np.linspace(-1, 1, 33))
        step /= 16
    return amount, angle


def sizes(press, speed, item, loads, angles):
    """Sizes (n,) of an item at crank angles (n,)."""
    motion = pp.servo_cycle(press, speed=speed, angle=angles)
    result = pp.inverse_dynamics(press, motion, list(loads))
    rest = pp.inverse_dynamics(press, pp.servo_cycle(press, speed=0.0, angle=angles))
    return {
        "torque": lambda: np.abs(result.driving_torque),
        "slide acceleration": lambda: np.abs(motion.slide_acceleration),
        "shaking force": lambda: np.linalg.norm(result.shaking_force - rest.shaking_force, axis=1),
    }.get(item, lambda: np.linalg.norm(result.bearing_force[item.removeprefix("bearing ")], axis=1))()


def capacities_for(item, amount):
    if item.startswith("bearing "):
        return Capacities(1e6, bearings={item.removeprefix("bearing "): amount})
    return Capacities(1e6, **{item.replace(" ", "_"): amount})


@pytest.mark.parametrize(
    ("name", "item"),
    [
        ("zxn2_3000b", "bearing A"),
        ("zxn2_3000b", "torque"),
        ("zxn2_3000b", "slide acceleration"),
        ("zxn2_3000b", "shaking force"),
        ("thin_wall", "bearing slot"),
        ("thin_wall", "shaking force"),
        ("jf75g_125_symmetric", "bearing P2_left"),
        ("jf75g_125", "torque"),
        ("crank_slide", "bearing slide_guide"),
    ],
)
def test_the_capacity_is_just_kept(name, item):
    """The capacity is what the item comes to at some speed: that speed is found. A little above it the capacity is exceeded."""
    press, speed = shipped(name), 13.7
    amount, angle = worst(press, speed, item)
    limit = speed_limit(press, capacities_for(item, amount))
    assert limit.limited_by == item
    np.testing.assert_allclose(limit.speed, speed, rtol=SAME)
    at = np.array([limit.crank_angle])
    reached, _ = worst(press, limit.speed, item, angles=at)
    np.testing.assert_allclose(reached, amount, rtol=SAME)
    assert worst(press, limit.speed, item)[0] <= amount * (1 + SAME)
    assert worst(press, 1.001 * limit.speed, item)[0] > amount
    away = np.abs((limit.crank_angle - angle + np.pi) % (2 * np.pi) - np.pi)
    assert away < 1e-3 or np.isclose(worst(press, speed, item, angles=at)[0], amount, rtol=SAME)  # a symmetric press has it twice


def test_slide_acceleration_of_the_crank_slide():
    """At bottom dead centre r w^2 (1 + r / l) = 0.125 w^2."""
    limit = speed_limit(shipped("crank_slide"), Capacities(1e5, slide_acceleration=50.0))
    np.testing.assert_allclose(limit.speed, np.sqrt(50.0 / 0.125), rtol=1e-12)
    np.testing.assert_allclose(limit.strokes_per_minute, 20 * 60 / (2 * np.pi), rtol=1e-12)
    assert min(limit.crank_angle, 2 * np.pi - limit.crank_angle) < 1e-6


def test_the_least_of_several_limits():
    press = shipped("zxn2_3000b")
    several = Capacities(3e6, bearings={"A": 2e5, "B": 2e5, "D": 2.5e5}, torque=4e4, slide_acceleration=40.0, shaking_force=2e5)
    alone = [Capacities(3e6, bearings={name: force}) for name, force in several.bearings.items()]
    alone += [Capacities(3e6, **{name: getattr(several, name)}) for name in ("torque", "slide_acceleration", "shaking_force")]
    limits = [speed_limit(press, capacities) for capacities in alone]
    least = min(limits, key=lambda limit: limit.speed)
    found = speed_limit(press, several)
    assert found.limited_by == least.limited_by
    np.testing.assert_allclose(found.speed, least.speed, rtol=1e-12)


def test_a_torque_beside_the_capacities():
    press = shipped("zxn2_3000b")
    assert speed_limit(press, Capacities(3e6), torque=3e4) == speed_limit(press, Capacities(3e6, torque=3e4))
    with pytest.raises(pp.PinpressError, match="leave one out"):
        speed_limit(press, Capacities(3e6, torque=3e4), torque=3e4)


@pytest.mark.parametrize("load", [ConstantForce(2e4, 0.01), Blanking(2e4, 0.02, 0.005)])
def test_with_a_process_load(load):
    press, capacities = shipped("crank_slide"), Capacities(1e5, bearings={"W": 2.5e4}, torque=3e3)
    limit = speed_limit(press, capacities, loads=[load])
    assert limit.limited_by == "bearing W"
    for factor, kept in ((0.9999, True), (1.001, False)):
        amount, _ = worst(press, factor * limit.speed, "bearing W", [load])
        assert (amount <= 2.5e4) == kept


def test_both_engines_agree():
    press, capacities = shipped("crank_slide"), Capacities(1e5, bearings={"O": 3e4, "W": 2.5e4}, shaking_force=2e4)
    one, other = (speed_limit(press, capacities, engine=engine) for engine in ("plane", "pinocchio"))
    assert one.limited_by == other.limited_by
    np.testing.assert_allclose(one.speed, other.speed, rtol=1e-10)


def test_what_no_speed_reaches():
    assert speed_limit(shipped("crank_slide"), Capacities(1e5)) is None
    # the symmetric press has no force in its guides at any speed, but for rounding
    assert speed_limit(shipped("jf75g_125_symmetric"), Capacities(1e6, bearings={"slide_guide": 1.0})) is None


def test_errors():
    press = shipped("crank_slide")
    # With the crank upright the rod, at sin(phi) = 1/4, holds the slide's 100 kg and, by moments about P, pushes on half its own 15 kg.
    at_rest = 9.81 * np.hypot(100.0, 107.5 * 0.25 / np.sqrt(1 - 0.25**2))
    with pytest.raises(
        pp.PinpressError, match=f"bearing W is {at_rest:.6g} N at crank angle (90|270) deg at any speed, by weights, but its"
    ):
        speed_limit(press, Capacities(1e5, bearings={"W": 500.0}))
    with pytest.raises(pp.PinpressError, match="by weights and loads"):
        speed_limit(press, Capacities(1e5, bearings={"W": 5e3}), loads=[ConstantForce(2e4, 0.01)])
    with pytest.raises(pp.PinpressError, match="no bearing 'X'"):
        speed_limit(press, Capacities(1e5, bearings={"X": 5e3}))
    with pytest.raises(pp.PinpressError, match="depends on the slide's speed"):
        speed_limit(press, Capacities(1e5, bearings={"W": 1e5}), loads=[pp.loads.ElasticDie(0.001, 1e7, damping=1e3)])
    with pytest.raises(pp.PinpressError, match="capacities is a dict"):
        speed_limit(press, {})
    with pytest.raises(pp.PinpressError, match="torque is -1"):
        speed_limit(press, Capacities(1e5), torque=-1)
