"""Derivatives of accelerations and multipliers: against differences of the null-space equations along closed motions, and closed forms."""

import dataclasses

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators import random_linkages, redundant_linkages
from support.generators.random_linkages import Group, Spec
from support.generators.spatial_linkages import bennett, four_bar, null_space
from support.oracles import cassie

import pinpress as pp


def inclined():
    """A planar linkage in a plane that is not along the axes, whose loop begins on the frame."""
    return random_linkages.drawn(Spec((Group("RRR", 2, (3, 4, 4)),), 11, tilted=True, stacked=False, solid=False, extra=False)).urdf(
        "crank"
    )


# each has something that the others have not: loops that hold each other, rings in space, gear pairs that depend on loops or on each other,
# several drivers, a turning plane
FAMILIES = {
    "zxn2_3000b": None,
    "jf75g_125_two_point": None,
    "bennett": bennett,
    "welded": lambda: four_bar("fixed"),
    "turntable": lambda: four_bar("revolute", table="table"),
    "jf75g_125_symmetric": None,
    "ring of gears": lambda: redundant_linkages.wheels(("s1", "crank", -1.0), ("s2", "s1", -1.0), ("crank", "s2", 1.0)),
    "cassie": cassie.urdf,
    "inclined": inclined,
}


def loaded(name):
    made = FAMILIES[name]
    return texts.shipped(name) if made is None else texts.load(made())


def richardson(function, h):
    """Derivative at 0 by central differences of order 4."""
    wide, near = ((function(step) - function(-step)) / (2 * step) for step in (h, 0.5 * h))
    return (4 * near - wide) / 3


def gears(press):
    rows = np.zeros((len(press.couplings), press.model.nv))
    for row, gear in zip(rows, press.couplings, strict=True):
        row[gear.follower], row[gear.leader] = 1.0, -gear.multiplier
    return rows


def point_rows(press, x):
    """Jacobian of the loops' points, of link2 less link1 in world axes, from Pinocchio's frames; and of the gear pairs."""
    model = press.model.copy()
    first, frames = press.forward_dynamics(np.zeros(model.nv)).ends, []
    for k, (joint1, place1, joint2, place2) in enumerate(first):
        for side, joint, place in ((1, joint1, place1), (2, joint2, place2)):
            frames.append(model.addFrame(pin.Frame(f"point {k} {side}", joint, 0, place, pin.OP_FRAME)))
    data, q = model.createData(), pin.integrate(model, pin.neutral(model), x)
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    of = [pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)[:3] for frame in frames]
    return np.concatenate([np.concatenate([two - one for one, two in zip(of[::2], of[1::2], strict=True)]), gears(press)])


def answer(press, dynamics, x, v, efforts):
    """Acceleration, from the null space of the constraints, and multipliers of least size."""
    a = dynamics.acceleration_in_null_space(x, v, efforts)
    model, data = press.model, press.model.createData()
    q = pin.integrate(model, pin.neutral(model), x)
    left = pin.crba(model, data, q) @ a + dynamics.armature * a + pin.nonLinearEffects(model, data, q, v) - efforts
    rows, turn = point_rows(press, x), [press.axes[gear.follower].turns for gear in press.couplings]
    lengths = np.concatenate([np.ones(len(rows) - len(turn)), np.where(turn, press.size, 1.0)])  # a torque counts as a force at this length
    return np.concatenate([a, lengths * np.linalg.lstsq((lengths[:, None] * rows).T, left, rcond=1e-9)[0]])


@pytest.mark.one_in(9)
@pytest.mark.parametrize("name", FAMILIES)
def test_differences_along_closed_motions(name):
    """In random directions; rounding over the step and the step's fourth power leave 1e-10 to 1e-9."""
    press, rng = loaded(name), np.random.default_rng(3)
    drivers, count = len(press.drivers), press.model.nv
    at = np.full((2, drivers), [[0.0], [-0.2]]) if drivers > 1 else np.array([0.0, -0.2])  # where drawn, some are at a dead centre
    motion = pp.servo_cycle(press, angle=at, speed=2.0 + 0 * at, acceleration=0 * at)
    armature = 0.3 * np.isin(np.arange(count), press.driver_indices)
    efforts = 30 * rng.normal(size=count)
    found = pp.derivatives.acceleration_derivatives(press, motion, efforts=efforts, armature=armature)
    dynamics = press.forward_dynamics(armature)
    assert len(found.multiplier_names) == found.multipliers.shape[1]
    for i in range(2):
        state = np.array(motion.joint_position[i]), np.array(motion.v[i])
        derivatives = [
            np.concatenate([getattr(found, f"by_{what}")[i], getattr(found, f"multipliers_by_{what}")[i]])
            for what in ("position", "rate", "effort")
        ]
        expected = answer(press, dynamics, state[0], state[1], efforts)
        cases = [(np.concatenate([found.acceleration[i], found.multipliers[i]]), expected)]
        cases += differences(press, dynamics, state[0], state[1], efforts, derivatives, rng)
        for computed, true in cases:
            for part in (slice(count), slice(count, None)):
                scale = np.abs(true[part]).max() + 1e-3 * np.abs(expected[part]).max()
                assert np.abs(computed[part] - true[part]).max() <= 1e-8 * scale


def differences(press, dynamics, x, v, efforts, derivatives, rng):
    """Changes by the derivatives, and by differences: of position and rates together, of rates, and of efforts."""
    by_position, by_rate, by_effort = derivatives
    count, free = len(x), null_space(point_rows(press, x))
    dx, dv = (free @ rng.normal(size=free.shape[1]) for _ in range(2))
    dx, dv, pushed = dx / np.abs(dx).max(), 5 * dv / np.abs(dv).max(), rng.normal(size=count)

    def beside(h):
        at, rates, _ = dynamics.project(x + h * dx, v + h * dv)
        return at, rates

    moved = richardson(lambda h: np.concatenate(beside(h)), 5e-4)
    along = by_position @ moved[:count] + by_rate @ moved[count:]
    yield along, richardson(lambda h: answer(press, dynamics, beside(h)[0], beside(h)[1], efforts), 5e-4)
    yield by_rate @ dv, richardson(lambda h: answer(press, dynamics, x, v + h * dv, efforts), 0.1)
    yield by_effort @ pushed, richardson(lambda h: answer(press, dynamics, x, v, efforts + h * pushed), 1.0)


def test_differences_converge_in_their_order():
    """Central differences of the acceleration by the crank angle come to the derivative with the square of the step."""
    press, flywheel = texts.shipped("zxn2_3000b"), 500.0 * (np.arange(5) == 0)
    dynamics, efforts = press.forward_dynamics(flywheel), 2e3 * (np.arange(5) == 0)

    def at(angle):
        motion = pp.servo_cycle(press, angle=[angle], speed=7.0)
        return dynamics.acceleration(np.array(motion.joint_position[0]), np.array(motion.v[0]), efforts)

    motion = pp.servo_cycle(press, angle=[0.8], speed=7.0)
    found = pp.derivatives.acceleration_derivatives(press, motion, efforts=efforts, armature=flywheel)
    derivative = found.by_position[0] @ motion.v[0] / 7.0 + found.by_rate[0] @ motion.a[0] / 7.0
    errors = [np.abs((at(0.8 + h) - at(0.8 - h)) / (2 * h) - derivative).max() for h in (2e-2, 1e-2, 5e-3)]
    assert 3.8 < errors[0] / errors[1] < 4.2
    assert 3.9 < errors[1] / errors[2] < 4.1


def test_without_arguments():
    """Under its own driving torque the motion has its own accelerations, and the multipliers are the bearing forces of the loops."""
    press = texts.shipped("zxn2_3000b")
    motion = pp.cycle(press, 7.0, points=5)
    found, forces = pp.derivatives.acceleration_derivatives(press, motion), pp.inverse_dynamics(press, motion).bearing_force
    assert np.abs(found.acceleration - motion.a).max() <= 1e-12 * np.abs(motion.a).max()
    expected = np.concatenate([forces[loop.name] for loop in press.loops], axis=1)
    assert np.abs(found.multipliers - expected).max() <= 1e-12 * np.abs(expected).max()
    assert found.multiplier_names == ("C x", "C y", "C z", "F x", "F y", "F z")
    assert found.columns()["acceleration_B_by_rate_D [(rad/s2)/(rad/s)]"].tolist() == found.by_rate[:, 1, 2].tolist()
    assert not found.by_position.flags.writeable


def test_a_pendulum():
    """No loops: inertia x acceleration = effort - m g r cos."""
    drawing = random_linkages.Drawing("pendulum")
    drawing.joint("O", "frame", "bob", 0j)
    drawing.body("bob", 2.0, 0.5)
    press = texts.load(drawing.urdf("O"))
    motion = pp.servo_cycle(press, angle=[0.7], speed=3.0)
    found = pp.derivatives.acceleration_derivatives(press, motion, efforts=[6.0], armature=[0.1])
    inertia = 2 * 0.5**2 + 2 * 0.01 + 0.1
    assert found.acceleration[0, 0] == pytest.approx((6 - 9.81 * np.cos(0.7)) / inertia, rel=1e-13)
    assert found.by_position[0, 0, 0] == pytest.approx(9.81 * np.sin(0.7) / inertia, rel=1e-13)
    assert abs(found.by_rate[0, 0, 0]) < 1e-13
    assert found.by_effort[0, 0, 0] == pytest.approx(1 / inertia, rel=1e-13)
    assert found.multipliers.shape == (1, 0)


def test_efforts_and_presses_without_derivatives_are_refused():
    press = texts.shipped("zxn2_3000b")
    motion, derivatives = pp.cycle(press, 7.0, points=3), pp.derivatives.acceleration_derivatives
    with pytest.raises(pp.PinpressError, match="with other joints"):
        derivatives(texts.shipped("crank_slide"), motion)
    for wrong in (np.ones(4), np.ones((4, 5)), [np.nan] * 5):
        with pytest.raises(pp.PinpressError, match="efforts"):
            derivatives(press, motion, efforts=wrong)
    with pytest.raises(pp.PinpressError, match="too fast for floating point"):
        derivatives(press, dataclasses.replace(motion, v=1e200 * motion.v), efforts=np.zeros(5))
    with pytest.raises(pp.PinpressError, match="armature"):
        derivatives(press, motion, armature=np.ones(3))
    model = press.model.copy()
    model.inertias[5] = pin.Inertia.Zero()
    light = dataclasses.replace(press, model=model)
    with pytest.raises(pp.PinpressError, match="moves no mass"):
        derivatives(light, pp.cycle(light, 7.0, points=3))
