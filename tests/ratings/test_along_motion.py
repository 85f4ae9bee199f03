"""Process forces along a motion, of one driver or several: put back on the press they use up what governs and nothing more."""

from typing import Any

import numpy as np
import pint
import pytest
from support.presses.two_servos import TWO_SERVOS
from support.texts import shipped

import pinpress as pp
from pinpress import PinpressError, UnknownNameError
from pinpress.ratings import Capacities, rate, rate_motion
from pinpress.ratings.limits import Limit, forces_with_friction

TIME = np.arange(90) / 90
TURNED = 2 * np.pi * TIME


@pytest.fixture(scope="module")
def press(tmp_path_factory):
    path = tmp_path_factory.mktemp("press") / "press.yaml"
    path.write_text(TWO_SERVOS, encoding="utf-8")
    return pp.build(path)


@pytest.fixture(scope="module")
def motion(press):
    return pp.servo_cycle(press, np.column_stack([TURNED, -TURNED + 0.4 * np.sin(TURNED)]), time=TIME, period=1.0)


RUBBING = {name: pp.loads.Friction(0.06, radius=0.05) for name in ("A", "B", "P", "Q", "S")} | {"slide_guide": pp.loads.Friction(0.05)}


def used(press, motion, capacities, force, loads=(), friction=None):
    """Name of a limit -> (n,) share of it that a process force takes."""
    pushed = pp.loads.PointForce(press.slide, force[:, None] * press.slide_direction)
    found = pp.inverse_dynamics(press, motion, [*loads, pushed], friction or {})
    torques = found.driving_torque.reshape(len(force), -1)
    shares = {f"torque {name}": np.abs(torques[:, press.drivers.index(name)]) / most for name, most in capacities.drivers.items()}
    shares |= {f"bearing {name}": np.linalg.norm(found.bearing_force[name], axis=1) / most for name, most in capacities.bearings.items()}
    return shares | {"nominal force": force / capacities.nominal_force}


@pytest.mark.parametrize("friction", [{}, RUBBING], ids=["smooth", "rubbing"])
@pytest.mark.parametrize("spring", [False, True])
def test_the_permissible_force_uses_up_the_limit_that_governs(press, motion, spring, friction):
    loads = [pp.loads.SpringDamper("slide", press.root, 5e3, 200.0, 0.5)] if spring else []
    capacities = Capacities(3e5, drivers={"A": 9e3, "B": 1e4}, bearings={"S": 2.9e5, "P": 2e5})
    found = rate_motion(press, motion, capacities, loads=loads, friction=friction)
    assert {"torque A", "torque B"} < set(found.limited_by)
    shares = used(press, motion, capacities, found.force, loads, friction)
    governing = np.array([shares[name][k] for k, name in enumerate(found.limited_by)])
    np.testing.assert_allclose(governing, 1.0, rtol=1e-9)
    assert np.max(list(shares.values())) < 1 + 1e-9
    for name, force in found.limits.items():
        np.testing.assert_array_less(found.force, force * (1 + 1e-12) + 1e-9)
        limited = force < capacities.nominal_force
        np.testing.assert_allclose(used(press, motion, capacities, force, loads, friction)[name][limited], 1.0, rtol=1e-9)


def test_the_torques_of_a_slow_press_follow_from_virtual_work(press):
    """Without speed and weight, at a symmetric pose: each motor bears half of F times the slide's travel by both angles."""
    light = press.with_inertias([type(each).Zero() for each in press.model.inertias])
    angles, step = np.array([[0.7, -0.7]]), 1e-6
    motion = pp.servo_cycle(light, angles, speed=np.zeros((1, 2)))
    beside = pp.servo_cycle(light, angles + step * np.array([[1.0, -1.0], [-1.0, 1.0]])[:, None].reshape(2, 2), speed=np.zeros((2, 2)))
    travel = abs(np.diff(beside.slide_position)[0]) / (2 * step)
    found = rate_motion(light, motion, Capacities(1e9, drivers={"A": 5e3, "B": 8e3}))
    assert found.force[0] == pytest.approx(2 * 5e3 / travel, rel=1e-7)
    assert found.limited_by == ("torque A",)


@pytest.mark.parametrize("friction", [{}, {"A": pp.loads.Friction(0.05, radius=0.1), "slide_guide": pp.loads.Friction(0.05)}])
def test_one_driver_at_constant_speed_is_rated_as_by_rate(friction):
    press = shipped("zxn2_3000b")
    capacities = Capacities(3e6, torque=1.3e5, bearings={"A": 1.5e6, "D": 3.3e6})
    expected = rate(press, 7.0, capacities, at_speed=True, friction=friction)
    motion = pp.servo_cycle(press, expected.crank_angle, speed=7.0, acceleration=0.0)
    found = rate_motion(press, motion, capacities, friction=friction)
    np.testing.assert_allclose(found.force, expected.force, rtol=1e-9)
    torque: Any = pint.Quantity(130.0, "kN m")
    named = rate_motion(press, motion, Capacities(3e6, drivers={press.driver: torque}, bearings=capacities.bearings), friction=friction)
    np.testing.assert_array_equal(named.force, found.force)


def test_utilisation_is_that_of_the_process_in_the_same_states(press, motion):
    found = rate_motion(press, motion, Capacities(4e5, drivers={"A": 9e3, "B": 1e4}))
    drawing = pp.loads.DeepDrawing(2e5, start=0.02, datum=motion.slide_position.min())
    reactions = pp.inverse_dynamics(press, motion, loads=[drawing])
    np.testing.assert_allclose(found.utilisation(reactions), reactions.process_force / found.force)
    assert found.utilisation(reactions).max() > 0.1
    again = pp.servo_cycle(press, np.column_stack([TURNED, -TURNED]), time=TIME, period=1.0)
    with pytest.raises(PinpressError, match="belong to another motion"):
        found.utilisation(pp.inverse_dynamics(press, again, loads=[drawing]))
    with pytest.raises(PinpressError, match="give reactions of the same press"):
        found.utilisation(pp.inverse_dynamics(shipped("crank_slide"), pp.cycle(shipped("crank_slide"), 1.0)))


def test_the_table_names_states_and_limits(press, motion):
    found = rate_motion(press, motion, Capacities(4e5, drivers={"A": 9e3}))
    text, least = str(found), int(found.force.argmin())
    assert f"{found.force[least] / 1e3:.5g} kN" in text
    assert f"time {TIME[least]:.6g} s" in text
    assert [*found.columns()][:3] == ["time [s]", "crank_angle_A [rad]", "crank_angle_B [rad]"]
    assert found.columns()["torque A [N]"] is found.limits["torque A"]


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"torque": 5e3}, "give drivers={'A': 5000}"),
        ({"nominal_height": 0.01}, "nominal_height is not a capacity along a given motion"),
        ({"motor_power": 1e4}, "motor_power is not a capacity along a given motion"),
        ({"drivers": {"A": 200.0}}, "the driving torque of 'A' is .* without a process, but the capacity is 200 N m"),
        ({"bearings": {"S": 10.0}}, "the force in bearing 'S' is"),
        ({"drivers": {"A": pint.Quantity(5.0, "kN")}}, "the capacity of driver 'A' is given in N, but the driver turns"),
    ],
)
def test_capacities_that_are_none_are_refused(press, motion, given, says):
    with pytest.raises(PinpressError, match=says):
        rate_motion(press, motion, Capacities(4e5, **given))


def test_what_does_not_go_together_is_refused(press, motion):
    with pytest.raises(UnknownNameError, match="driver"):
        rate_motion(press, motion, Capacities(4e5, drivers={"C": 5e3}))
    with pytest.raises(PinpressError, match="torque and drivers"):
        Capacities(4e5, torque=1e3, drivers={"A": 5e3})
    with pytest.raises(PinpressError, match="give a mapping"):
        Capacities(4e5, drivers=[5e3])
    with pytest.raises(PinpressError, match="is not a load of ratings"):
        rate_motion(press, motion, Capacities(4e5), loads=[pp.loads.Blanking(1e3, 0.01, 0.0)])
    for call in (
        lambda given: rate(shipped("crank_slide"), 1.0, given),
        lambda given: pp.ratings.speed_limit(shipped("crank_slide"), given),
    ):
        with pytest.raises(PinpressError, match="give the capacity of a single driver as torque"):
            call(Capacities(4e5, drivers={"O": 5e3}))
    with pytest.raises(PinpressError):
        rate_motion(shipped("crank_slide"), motion, Capacities(4e5))


def test_a_force_of_which_a_smaller_one_is_not_permitted_is_refused(motion):
    """Two made-up limits: one rises with the force up to its capacity at 8 N, the other one is exceeded at 2 N too."""
    limits = [Limit(name, name, 1.0, "N", lambda reactions: np.zeros((1, 1))) for name in ("rising", "bent")]

    def sizes(force):
        return np.array([force / 8.0, force / 8.0 + 2.0 * np.exp(-(((force - 2.0) / 0.3) ** 2))])

    nominal = np.full(2, 10.0)
    alone = forces_with_friction(limits[:1], lambda force: sizes(force)[:1], nominal, motion.place)
    np.testing.assert_allclose(alone["rising"], 8.0, rtol=1e-12)
    with pytest.raises(PinpressError, match=r"time 0 s .*'bent' permits .* but not every smaller force"):
        forces_with_friction(limits, sizes, nominal, motion.place)
