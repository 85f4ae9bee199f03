"""Every feature that takes a press takes one with teeth and threads, or refuses it by name: no force of teeth is left out in silence."""

import numpy as np
import pytest
from support.presses import machine_presses

import pinpress as pp
from pinpress.ratings.limits import without_masses
from pinpress.tolerances.virtual_work import unit_forces

SPEED = 20.0
FORCE = 1e5
REFUSED = "has teeth, threads or rollers in 'teeth': "


@pytest.fixture(scope="module")
def press():
    return machine_presses.geared()


@pytest.fixture(scope="module")
def lossy():
    return machine_presses.geared(0.96)


def moved(press, points=90):
    """The working stroke of the crank: the pinion turns backwards while it turns forwards."""
    ends = pp.dead_centres(press)
    turns = np.linspace(ends.top_angle, ends.bottom_angle, points + 2)[1:-1]
    return pp.servo_cycle(press, turns, speed=np.sign(turns[-1] - turns[0]) * SPEED, acceleration=0.0)


def pushed(press, force):
    """Process forces (n,) up on the slide at its tool."""
    up = np.outer(force, press.slide_direction)
    return pp.loads.PointForce(press.slide, lambda motion: up, tuple(press.tool.point))


@pytest.mark.parametrize("efficiency", [1.0, 0.96])
@pytest.mark.parametrize("limited", ["Q", "teeth", "O"])
def test_a_rating_along_a_motion_is_reached(efficiency, limited):
    """Under the permitted force the bearing, or the teeth, carry what they may: with weights and inertia, for which nothing adds up."""
    press = machine_presses.geared(efficiency)
    motion = moved(press)
    rated = pp.ratings.rate_motion(press, motion, pp.ratings.Capacities(FORCE, bearings={limited: 2e4}))
    carried = pp.inverse_dynamics(press, motion, [pushed(press, rated.force)]).bearing_force[limited]
    governed = np.array(rated.limited_by) == f"bearing {limited}"
    assert governed.any()
    np.testing.assert_allclose(np.linalg.norm(carried, axis=1)[governed], 2e4, rtol=1e-9)


@pytest.mark.parametrize(("efficiency", "at_speed"), [(1.0, True), (0.96, False), pytest.param(0.96, True, marks=pytest.mark.exhaustive)])
def test_a_rating_over_the_stroke_is_reached(efficiency, at_speed):
    press = machine_presses.geared(efficiency)
    capacities = pp.ratings.Capacities(FORCE, bearings={"Q": 1e4}, torque=1200.0)
    rated = pp.ratings.rate(press, -SPEED, capacities, at_speed=at_speed, points=45)
    assert rated.speed_limit is None
    motion = pp.servo_cycle(press, rated.crank_angle, speed=-SPEED, acceleration=0.0)
    acting = press if at_speed else without_masses(press)  # there the process force counts alone
    for name, force in rated.limits.items():
        if name != "nominal force":
            found = pp.inverse_dynamics(acting, motion, [pushed(press, force)])
            size = np.abs(found.driving_torque) / 1200.0 if name == "torque" else np.linalg.norm(found.bearing_force["Q"], axis=1) / 1e4
            limited = force < FORCE
            assert limited.any()
            np.testing.assert_allclose(size[limited], 1.0, rtol=1e-8)


def test_a_clearance_at_the_pinion_turns_the_wheel_along_the_flank(press):
    """A unit force on the slide is Ft = ds/dphi / r at the pitch circle of the wheel, and the flank's force is larger by 1/cos(angle)."""
    motion, mesh = moved(press), press.meshes["teeth"]
    unit = unit_forces(press, motion)
    crank = press.joints.index("O")
    lever = motion.slide_velocity / motion.v[:, crank] / mesh.radii[1]
    np.testing.assert_allclose(np.linalg.norm(unit.force["Q"], axis=1), np.abs(lever) / np.cos(mesh.pressure_angle), rtol=1e-7)
    assert pp.tolerances.play(press, motion, {"Q": 1e-4}).offset.any()


def test_what_needs_no_forces_of_teeth_is_that_of_the_ratio_alone(press):
    """Shaking force, foundation, balancing of shaking, torque over speeds, and motors: as of a press whose ratio is a relation."""
    bare = machine_presses.of_ratio()
    motions = [pp.cycle(each, SPEED, points=60) for each in (press, bare)]
    reactions = [pp.inverse_dynamics(each, motion) for each, motion in zip((press, bare), motions, strict=True)]
    for name in ("driving_torque", "shaking_force", "shaking_moment"):
        one, other = (getattr(each, name) for each in reactions)
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-10 * np.abs(other).max())
    maps = [pp.sweeps.operating_points(each, [10.0, 30.0], bearings=(), points=60) for each in (press, bare)]
    np.testing.assert_allclose(*(each.results["largest_driving_torque"] for each in maps), rtol=1e-10)
    shaken = pp.balancing.Range("shaking_force", "z")
    best = [
        pp.balancing.balance(each, motion, regions=REGIONS, minimise=shaken) for each, motion in zip((press, bare), motions, strict=True)
    ]
    peaks = [np.ptp(each.reactions_after[0].shaking_force[:, 2]) for each in best]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-6)


def test_other_masses_keep_their_teeth(press):
    inertias = list(press.model.inertias)
    pinion = press.joints.index("Q") + 1
    inertias[pinion] = inertias[pinion] + inertias[pinion]
    other = press.with_inertias(inertias)
    assert other.meshes["teeth"].pitch_point == pytest.approx(press.meshes["teeth"].pitch_point)
    assert [contact.name for contact in other.contacts] == ["teeth"]


# ------------------------------------------------------------------------------------------------------------------------------- refused

ELASTIC = pp.elasticity.Elastic(pp.elasticity.Stiffness({"A": 1e9, "B": 1e9}))
SERVO = pp.servo.ServoDrive(inertia=0.1, ratio=10.0, peak_torque=500.0)
REGIONS = [pp.balancing.CounterweightRegion("crank", radius=0.2, mass=(0.0, 50.0))]


def balanced(press, minimise):
    return pp.balancing.balance(press, pp.cycle(press, SPEED, points=24), regions=REGIONS, minimise=minimise)


def synthesised(press):
    return pp.synthesis.synthesise(
        press,
        {"x": (0.05, 0.06, 0.07)},
        geometry=lambda x: {("A", "crank"): (x, 0.0, 0.08)},
        minimise=lambda trial: trial.reactions.driving_torque.max(),
        speed=7.0,
        points=24,
    )


FORCES = {
    "elastic run": lambda press: pp.simulate(press, 0.1, drive=pp.drives.PrescribedSpeed(30.0), elastic=ELASTIC),
    "natural frequencies": lambda press: pp.elasticity.natural_frequencies(press, ELASTIC),
    "compliance": lambda press: pp.elasticity.compliance(press, ELASTIC.stiffness),
    "deflection": lambda press: pp.elasticity.slide_deflection(press, pp.cycle(press, 5.0), ELASTIC.stiffness),
    "speed limit": lambda press: pp.ratings.speed_limit(press, pp.ratings.Capacities(FORCE, bearings={"Q": 1e4})),
    "operating points": lambda press: pp.sweeps.operating_points(press, [5.0]),
    "balancing of a bearing": lambda press: balanced(press, pp.balancing.Peak("bearing_force", bearing="O")),
    "limits of a servo motion": lambda press: pp.servo.best_motion(
        press, SERVO, time=1.0, path=pp.servo.Turn(), limits=[pp.servo.BearingForce("Q", 1e5)]
    ),
    "synthesis": synthesised,
}
LOSSES = {
    "run of all joints": lambda press: pp.simulate(press, 0.1, speed=1.0, method="constraint"),
    "servo motion": lambda press: pp.servo.best_motion(press, SERVO, time=1.0, path=pp.servo.Turn()),
    "balancing of the torque": lambda press: balanced(press, pp.balancing.Range("driving_torque")),
    "derivatives of accelerations": lambda press: pp.derivatives.acceleration_derivatives(press, pp.cycle(press, 5.0, points=3)),
    "records": lambda press: pp.measured.force_sensor(press, [0.0, 0.02]),
    "plan of records": lambda press: pp.measured.plan(press, {"even": pp.cycle(press, 5.0, points=24)}, noise=1.0),
}


@pytest.mark.parametrize("name", FORCES)
def test_what_lets_forces_of_bearings_add_up_refuses_teeth(press, name):
    with pytest.raises(pp.PinpressError, match=REFUSED):
        FORCES[name](press)


@pytest.mark.parametrize("name", LOSSES)
def test_what_lets_torques_add_up_refuses_losses(press, lossy, name):
    with pytest.raises(pp.PinpressError, match=REFUSED):
        LOSSES[name](lossy)
