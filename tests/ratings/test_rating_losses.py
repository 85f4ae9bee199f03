"""Ratings with friction and beside springs: against presses written out by hand, virtual work, and inverse dynamics at the forces found."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from support.oracles import friction_script
from support.texts import shipped

import pinpress as pp
from pinpress.loads.link import Friction, PointForce, SpringDamper
from pinpress.ratings.limits import BEARING, without_masses
from pinpress.ratings.permissible_force import Capacities
from pinpress.ratings.rating import rate

SPEED = 70 * pp.RPM
CYLINDER = SpringDamper("frame", "slide", 2e5, 500.0, 0.4, point1=(0.0, 0.0, 0.5))
NOMINAL = {"zxn2_3000b": 3e6, "crank_slide": 1e5}


def rubbing(press, coefficient=0.05, viscous=0.0):
    return {name: Friction(coefficient, None if name == "slide_guide" else 0.06, viscous) for name in press.bearings}


def utilisation(press, found, name, force):
    """Share of the capacity of a limit that is used at all heights, by inverse dynamics under process forces (n,)."""
    motion = pp.servo_cycle(press, found.crank_angle, speed=found.speed)
    loads = [*found.loads, PointForce("slide", force[:, None] * press.slide_direction)]
    reactions = pp.inverse_dynamics(press if found.at_speed else without_masses(press), motion, loads, found.friction)
    if name == "torque":
        return np.abs(reactions.driving_torque) / found.torque_capacity
    bearing = name.removeprefix(BEARING)
    return np.linalg.norm(reactions.bearing_force[bearing], axis=1) / found.capacities.bearings[bearing]


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["zxn2_3000b", "crank_slide"])
def test_permissible_forces_by_hand(name):
    """The torque of the press written out by hand is the capacity where it governs; pins bear just theirs (friction, weight, inertia)."""
    press, nominal = shipped(name), NOMINAL[name]
    friction, pin = rubbing(press), press.bearings[-1]
    bearings = {pin: 0.9 * nominal}
    found = rate(press, SPEED, Capacities(nominal, 0.013, bearings=bearings), at_speed=True, friction=friction, points=24)
    moved = getattr(friction_script, name)(found.crank_angle, np.full(len(found.height), SPEED), np.zeros(len(found.height)))
    coulomb = {bearing: each.coefficient * (each.radius or 1.0) for bearing, each in friction.items()}
    by_hand = friction_script.solve(moved, found.force, coulomb, dict.fromkeys(friction, 0.0))
    shares = {"torque": np.abs(by_hand["torque"]) / found.torque_capacity, BEARING + pin: np.abs(by_hand[pin]) / bearings[pin]}
    governs = np.array(found.limited_by)
    governs[[0, -1]] = "dead centre"  # at which rounding decides which way the slide rubs
    assert set(governs) >= set(shares)
    for limit, share in shares.items():
        assert np.abs(share[governs == limit] - 1).max() < 1e-9
        assert share[1:-1].max() < 1 + 1e-9


def test_a_nominal_height_stands_for_the_torque_with_friction():
    """By hand: torque of the nominal force on a crank-slide without masses, in static balance with its friction."""
    press = shipped("crank_slide")
    friction, capacities = rubbing(press), Capacities(1e5, 0.02)
    found, ideal = rate(press, SPEED, capacities, friction=friction, points=25), rate(press, SPEED, capacities, points=25)
    at = np.abs(found.height - 0.02).argmin()
    moved = friction_script.crank_slide(found.crank_angle[at : at + 1], np.array([SPEED]), np.zeros(1))
    for body in moved.bodies:
        body.mass = body.inertia = 0.0
    coulomb = {bearing: each.coefficient * (each.radius or 1.0) for bearing, each in friction.items()}
    by_hand = friction_script.solve(moved, np.array([1e5]), coulomb, dict.fromkeys(friction, 0.0))
    assert found.torque_capacity == pytest.approx(by_hand["torque"][0], rel=1e-9)
    assert found.torque_capacity > 1.1 * ideal.torque_capacity
    # what friction takes weighs more near the dead centre, where the lever is short: there the crank permits less than without it
    near = found.height < 0.02
    assert np.all(found.force[near] <= ideal.force[near])
    assert found.speed_limit is None


@pytest.mark.parametrize(
    "given", [{}, {"at_speed": True}, {"at_speed": True, "loads": [CYLINDER]}, {"at_speed": True, "loads": [CYLINDER], "viscous": 30.0}]
)
def test_every_limit_is_just_met(given):
    """Inverse dynamics at the force that a limit permits uses up that limit, and half of the force does not."""
    press = shipped("zxn2_3000b")
    friction = rubbing(press, viscous=given.get("viscous", 0.0))
    capacities = Capacities(3e6, 0.013, bearings={"A": 1.2e6, "slide_guide": 3e5})
    found = rate(press, SPEED, capacities, friction=friction, points=13, **{k: v for k, v in given.items() if k != "viscous"})
    for name, force in found.limits.items():
        if name == "nominal force":
            continue
        reached = force < capacities.nominal_force * (1 - 1e-9)
        used = utilisation(press, found, name, force)
        assert np.abs(used[reached] - 1).max() < 1e-9
        assert used[~reached].max() < 1 + 1e-9
        assert utilisation(press, found, name, 0.5 * force).max() < 1.0


def test_a_balance_cylinder_by_virtual_work():
    """Springs add their force times the slide's travel to the torque of the idle press, and a constant force on the slide its own."""
    press, lift = shipped("crank_slide"), PointForce("slide", (0.0, 0.0, 900.0))
    spring = replace(CYLINDER, damping=0.0)
    found = rate(press, SPEED, Capacities(1e5, torque=12e3), at_speed=True, loads=[spring, lift], points=19)
    motion = pp.servo_cycle(press, found.crank_angle, speed=SPEED)
    idle = pp.inverse_dynamics(press, motion).driving_torque
    pull = spring.stiffness * (0.5 - motion.slide_position - spring.free_length)  # the cylinder stands above the slide, on its axis
    beside = -(pull + 900.0) * found.travel_per_angle
    limit = np.array(found.limited_by) == "torque"
    assert limit.sum() > 5
    np.testing.assert_allclose((idle + beside - found.force * found.travel_per_angle)[limit], 12e3, rtol=1e-10)
    assert found.speed_limit is not None


def test_energy_pays_for_the_friction_of_the_process():
    """E / height without friction; with it E / (work of the crank for 1 N), here by adaptive quadrature."""
    press = shipped("zxn2_3000b")
    friction, capacities = rubbing(press), Capacities(3e6, flywheel_inertia=2000.0, speed_drop=0.2)
    found = rate(press, SPEED, capacities, friction=friction, points=7)
    massless = without_masses(press)

    def torque(angle):
        motion = pp.servo_cycle(press, np.array([angle]), speed=SPEED)
        return float(pp.inverse_dynamics(massless, motion, [PointForce("slide", (0.0, 0.0, 1.0))], friction).driving_torque[0])

    k = int(np.argmax(found.height < 0.05))
    work = quad(torque, found.crank_angle[k], found.crank_angle[-1], epsabs=1e-9, limit=30)[0]
    assert found.limits["flywheel energy"][k] == pytest.approx(found.energies["flywheel energy"] / work, rel=1e-6)
    assert work > 1.05 * found.height[k]


@pytest.mark.exhaustive
def test_no_friction_is_no_friction():
    """Coefficients of zero lead the other way to the same limits."""
    press, capacities = shipped("zxn2_3000b"), Capacities(3e6, 0.013, bearings={"A": 1.2e6})
    none, zero = (rate(press, SPEED, capacities, at_speed=True, friction=given, points=9) for given in ({}, rubbing(press, 0.0)))
    assert zero.limited_by == none.limited_by
    np.testing.assert_allclose(zero.force, none.force, rtol=1e-10)


@pytest.mark.filterwarnings("ignore:friction of.*its (coefficient|radius) is")  # so large on purpose
@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            {"loads": [pp.loads.Blanking(1e6, 0.006, 0.002)], "at_speed": True},
            "Blanking is not a load of ratings, which find the process force",
        ),
        ({"loads": [pp.loads.TimeForce(np.sin)], "at_speed": True}, "TimeForce is not a load of ratings"),
        ({"loads": [PointForce("slide", lambda motion: np.zeros(3))], "at_speed": True}, "load on 'slide': ratings take a constant force"),
        ({"loads": CYLINDER, "at_speed": True}, "give a list"),
        ({"loads": [CYLINDER]}, r"also give at_speed=True"),
        ({"friction": {"A": Friction(0.1, 0.06, 5.0)}}, "friction of 'A': viscous friction depends on the speed"),
        ({"friction": {"A": Friction(0.1)}}, "its radius is missing"),
        ({"friction": 0.1}, "friction is a float: give a mapping"),
        ({"friction": {"A": 0.1}}, "friction of 'A' is 0.1: give a Friction"),
        ({"friction": {"slide_guide": Friction(5.0)}}, "friction locks the linkage"),
    ],
)
def test_what_is_refused(given, words):
    with pytest.raises(pp.PinpressError, match=words):
        rate(shipped("zxn2_3000b"), SPEED, Capacities(3e6, 0.013), points=9, **given)
