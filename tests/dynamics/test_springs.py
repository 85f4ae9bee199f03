"""Springs and dampers between links: against pairs of forces worked out from Pinocchio's own placements and velocities, and energy."""

from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from support.generators.random_linkages import four_bar, momentum_balance
from support.generators.redundant_linkages import three_cranks
from support.generators.spatial_crank_slide import SPATIAL
from support.generators.spatial_linkages import four_bar as spatial_four_bar
from support.texts import load, shipped

import pinpress as pp

ENGINES = ("plane", "space", "pinocchio")
ANGLE = np.linspace(-0.6, 0.9, 7)
SERVO = {"angle": ANGLE, "speed": 6 * np.cos(3 * ANGLE), "acceleration": 40 * np.sin(5 * ANGLE)}


def welded():
    """A four-bar with a bracket welded to its coupler, turned and out of the plane, and another one on the frame."""
    drawing = four_bar(1.0, 0.3, 0.9, 0.8, 1.0)
    drawing.weld("arm", "coupler", "bracket", 0.5 + 0.6j, 0.2, (0.3, -0.8, 1.1))
    drawing.weld("stand", "frame", "post", 0.2 - 0.3j, -0.1, (1.0, 0.2, 0.0))
    drawing.body("bracket", 1.5, 0.5 + 0.7j, 0.2)
    drawing.body("post", 3.0, 0.2 - 0.4j)
    return drawing.urdf("O")


# press, two links and their points, engines
CASES = {
    "slide_to_frame": (lambda: "crank_slide", ("slide", (0.05, 0.1, -0.1)), ("frame", (0.3, -0.2, -0.9)), ENGINES),
    "frame_to_rocker": (lambda: "zxn2_3000b", ("frame", (0.2, 0.3, 0.7)), ("rocker", (0.1, 0.05, 0.2)), ENGINES),
    "rod_to_crank": (lambda: "zxn2_3000b", ("rod", (0.3, 0.0, 0.1)), ("crank", (-0.1, 0.2, 0.0)), ENGINES),
    "welded_links": (welded, ("bracket", (0.1, 0.05, -0.1)), ("post", (0.0, 0.1, 0.2)), ENGINES),
    "redundant": (lambda: three_cranks(0.2).urdf("O"), ("coupler", (0.1, 0.2, 0.0)), ("second", (0.1, -0.1, 0.1)), ENGINES),
    "through_space": (lambda: SPATIAL, ("rod", (0.02, 0.1, -0.2)), ("crank", (-0.1, 0.0, 0.05)), ("pinocchio",)),
}
BOTH = [(name, engine) for name, (*_, engines) in CASES.items() for engine in engines]
SPRINGS = {
    "spring": {"stiffness": 3e4, "free_length": 0.2},
    "damper": {"damping": 800.0},
    "both": {"stiffness": 2e4, "damping": 500.0, "free_length": 0.9},
    "no_free_length": {"stiffness": 2e4},
}


@cache
def made(name):
    text, (link1, point1), (link2, point2), _ = CASES[name]
    press = load(text()) if "<" in text() else shipped(text())
    return press, {"link1": link1, "link2": link2, "point1": point1, "point2": point2}


def ends(press, motion, link, point):
    """Position and velocity (n, 3) of a point of a link, world axes."""
    data, frame = press.model.createData(), press.model.getFrameId(link, pin.BODY)
    position, velocity = np.empty((2, len(motion.q), 3))
    for i, (q, v) in enumerate(zip(motion.q, motion.v, strict=True)):
        pin.forwardKinematics(press.model, data, q, v)
        place = pin.updateFramePlacement(press.model, data, frame)
        moving = pin.getFrameVelocity(press.model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        position[i] = place.act(np.array(point))
        velocity[i] = moving.linear + np.cross(moving.angular, position[i] - place.translation)
    return position, velocity


def stretch(press, motion, link1, link2, point1, point2):
    """Length (n,), its rate, and the direction (n, 3) from point 1 to point 2."""
    (first, slow), (second, fast) = ends(press, motion, link1, point1), ends(press, motion, link2, point2)
    length = np.linalg.norm(second - first, axis=1)
    direction = (second - first) / length[:, None]
    return length, np.einsum("nk,nk->n", fast - slow, direction), direction


def pulled(press, motion, between, stiffness=0.0, damping=0.0, free_length=0.0):
    """The pair of forces that a spring and damper make."""
    length, rate, direction = stretch(press, motion, **between)
    force = (stiffness * (length - free_length) + damping * rate)[:, None] * direction
    return [
        pp.loads.PointForce(between["link1"], force, between["point1"]),
        pp.loads.PointForce(between["link2"], -force, between["point2"]),
    ]


def same(one, other, bound):
    """Torque, all forces and moments of two results, within a share of their peaks."""
    force = max(np.abs(values).max() for values in other.bearing_force.values())
    moment = max(force, *(np.abs(values).max() for values in other.bearing_moment.values()))
    assert np.abs(one.driving_torque - other.driving_torque).max() <= bound * moment
    for name in one.bearing_force:
        assert np.abs(one.bearing_force[name] - other.bearing_force[name]).max() <= bound * force, name
        assert np.abs(one.bearing_moment[name] - other.bearing_moment[name]).max() <= bound * moment, name
    assert np.abs(one.shaking_force - other.shaking_force).max() <= bound * force
    assert np.abs(one.shaking_moment - other.shaking_moment).max() <= bound * moment


# ------------------------------------------------------------------------------------------------------------------------------- forces


@pytest.mark.one_in(11)
@pytest.mark.parametrize("spring", SPRINGS)
@pytest.mark.parametrize(("name", "engine"), BOTH)
def test_a_spring_is_the_pair_of_its_forces(name, spring, engine):
    """Everything as with the two forces on its links, 1e-12 of the peaks; and it changes something."""
    press, between = made(name)
    motion = pp.servo_cycle(press, **SERVO, engine=engine)
    sprung = pp.inverse_dynamics(press, motion, [pp.loads.SpringDamper(**between, **SPRINGS[spring])], engine=engine)
    same(sprung, pp.inverse_dynamics(press, motion, pulled(press, motion, between, **SPRINGS[spring]), engine=engine), 1e-12)
    bare = pp.inverse_dynamics(press, motion, engine=engine)
    assert np.abs(sprung.driving_torque - bare.driving_torque).max() > 1.0
    assert np.abs(sprung.power_residual).max() <= 1e-12


@pytest.mark.parametrize(("name", "engine"), BOTH)
def test_ends_may_be_swapped_and_the_foundation_feels_nothing(name, engine):
    """Both its ends are on the machine, also where one is on the frame: what shakes is the rate of momentum alone; 1e-12 of the peaks."""
    press, between = made(name)
    swapped = {key: between[key[:-1] + {"1": "2", "2": "1"}[key[-1]]] for key in between}
    motion = pp.servo_cycle(press, **SERVO, engine=engine)
    one, two = (
        pp.inverse_dynamics(press, motion, [pp.loads.SpringDamper(**ends, **SPRINGS["both"])], engine=engine) for ends in (between, swapped)
    )
    same(one, two, 1e-13)
    force, moment = momentum_balance(press, motion, [])
    peak = max(np.abs(values).max() for values in one.bearing_force.values())
    assert np.abs(one.shaking_force - force).max() <= 1e-12 * peak
    assert np.abs(one.shaking_moment - moment).max() <= 1e-12 * peak * press.size


def test_a_balance_spring_in_closed_form(engine):
    """From the slide's pin straight up to the crankshaft: it pulls with k (L - L0) + c dL/dt, L the height of the slide below the shaft."""
    press = shipped("crank_slide")
    motion = pp.cycle(press, speed=5.0, points=24, engine=engine)
    spring = pp.loads.SpringDamper("slide", "frame", stiffness=4e3, damping=300.0, free_length=0.25)
    bare, result = (pp.inverse_dynamics(press, motion, loads, engine=engine) for loads in ([], [spring]))
    lift = 4e3 * (-motion.slide_position - 0.25) - 300.0 * motion.slide_velocity
    change = result.bearing_force["W"] - bare.bearing_force["W"]
    peak = np.abs(result.bearing_force["W"]).max()
    assert np.abs(change[:, 2] + lift).max() <= 1e-13 * peak
    torque = result.driving_torque - bare.driving_torque
    assert np.abs(torque + lift * motion.slide_velocity / 5.0).max() <= 1e-13 * peak


def test_a_spring_within_a_link_does_nothing(engine):
    """Its two forces are on one line of one body: 1e-13 of what they are themselves."""
    press = shipped("zxn2_3000b")
    motion = pp.servo_cycle(press, **SERVO, engine=engine)
    with pytest.warns(pp.PinpressWarning, match="link1 and link2 are both 'rod', which does not stretch it: name two links"):
        spring = pp.loads.SpringDamper("rod", "rod", 1e6, 1e4, 0.1, (0.1, 0.2, 0.0), (0.3, -0.1, 0.1))
    held, free = (pp.inverse_dynamics(press, motion, loads, engine=engine) for loads in ([spring], []))
    same(held, free, 1e-13)


def test_springs_of_linkages_with_several_drivers():
    """A four-bar on a turntable, driven at both."""
    press = load(spatial_four_bar("revolute", table="table"))
    angle = np.stack([ANGLE, -0.5 * ANGLE], axis=1)
    motion = pp.servo_cycle(press, angle=angle, speed=3.0, acceleration=-5.0)
    between = {"link1": "rocker", "link2": "frame", "point1": (0.1, 0.2, 0.0), "point2": (0.3, 0.1, 0.9)}
    sprung = pp.inverse_dynamics(press, motion, [pp.loads.SpringDamper(**between, **SPRINGS["both"])])
    same(sprung, pp.inverse_dynamics(press, motion, pulled(press, motion, between, **SPRINGS["both"])), 1e-12)
    assert sprung.driving_torque.shape == (7, 2)
    assert np.abs(sprung.power_residual).max() <= 1e-12


def test_springs_and_friction_together(engine):
    """A spring's force is in the radial forces that rub."""
    press = shipped("zxn2_3000b")
    motion = pp.servo_cycle(press, **SERVO, engine=engine)
    between = {"link1": "rocker", "link2": "frame", "point1": (0.1, 0.0, 0.2), "point2": (1.0, 0.0, 0.9)}
    friction = {name: pp.loads.Friction(0.1, None if name == "slide_guide" else 0.05, 20.0) for name in press.bearings}
    results = [
        pp.inverse_dynamics(press, motion, loads, friction=friction, engine=engine)
        for loads in ([pp.loads.SpringDamper(**between, **SPRINGS["both"])], pulled(press, motion, between, **SPRINGS["both"]))
    ]
    same(results[0], results[1], 1e-12)
    assert np.abs(results[0].power_residual).max() <= 1e-12


# ------------------------------------------------------------------------------------------------------------------------------- energy


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", ["slide_to_frame", "frame_to_rocker", "rod_to_crank"])
def test_energy_over_a_turn(name, engine):
    """At constant speed a spring gives back what it takes: the mean torque stays, 1e-12 of the peak change. A damper takes the integral of
    c (dL/dt)^2; and at every angle the drive pays what they take. Equal steps over a period integrate smooth functions to rounding."""
    press, between = made(name)
    motion = pp.cycle(press, speed=7.0, points=120, engine=engine)
    length, rate, _ = stretch(press, motion, **between)
    bare = pp.inverse_dynamics(press, motion, engine=engine).driving_torque
    taken = {"spring": 3e4 * (length - 0.2) * rate, "damper": 800.0 * rate**2}
    for spring, power in taken.items():
        sprung = pp.inverse_dynamics(press, motion, [pp.loads.SpringDamper(**between, **SPRINGS[spring])], engine=engine).driving_torque
        peak = max(np.abs(bare).max(), np.abs(sprung).max())
        assert np.abs(7.0 * (sprung - bare) - power).max() <= 1e-12 * 7.0 * peak
        mean = (sprung - bare).mean()
        if spring == "spring":
            assert abs(mean) <= 1e-12 * peak
        else:
            assert mean > 1e-3 * np.abs(sprung - bare).max()


def test_work_on_a_spring_is_its_energy(engine):
    """Over a part of a turn: k (L - L0)^2 / 2 at its ends; Gauss-Legendre in 60 points, 1e-11."""
    press = shipped("zxn2_3000b")
    nodes, weights = np.polynomial.legendre.leggauss(60)
    between = {"link1": "rocker", "link2": "frame", "point1": (0.1, 0.0, 0.2), "point2": (1.0, 0.3, 0.9)}
    spring = pp.loads.SpringDamper(**between, stiffness=5e5, free_length=0.4)
    motion = pp.servo_cycle(press, angle=0.4 + 2.7 * (nodes + 1) / 2, speed=7.0, engine=engine)
    sprung, bare = (pp.inverse_dynamics(press, motion, loads, engine=engine).driving_torque for loads in ([spring], []))
    work = ((sprung - bare) @ weights) * 2.7 / 2
    length, _, _ = stretch(press, pp.servo_cycle(press, angle=[0.4, 3.1], speed=7.0), **between)
    energy = 5e5 * (length - 0.4) ** 2 / 2
    assert work == pytest.approx(energy[1] - energy[0], rel=1e-11)


# --------------------------------------------------------------------------------------------------------- ends that meet, bad input

MEETING = {"link1": "slide", "link2": "frame", "point2": (0.0, 0.0, -0.5)}  # at bottom dead centre, crank angle 0


def test_ends_may_meet_where_a_spring_has_no_free_length(engine):
    """Its force is k times the distance, also in direction: zero there, and finite."""
    press = shipped("crank_slide")
    motion = pp.cycle(press, speed=5.0, points=8, engine=engine)
    spring = pp.loads.SpringDamper(**MEETING, stiffness=1e5)
    bare, result = (pp.inverse_dynamics(press, motion, loads, engine=engine) for loads in ([], [spring]))
    change = result.bearing_force["W"][:, 2] - bare.bearing_force["W"][:, 2]
    peak = np.abs(result.bearing_force["W"]).max()
    assert np.abs(change - 1e5 * (motion.slide_position + 0.5)).max() <= 1e-13 * peak
    assert abs(change[0]) <= 1e-13 * peak
