"""Friction in bearings and guides: against presses written out by hand (`friction_script`), closed forms, the balance of bodies and power,
and against itself: the torque mu r F of the bearing forces that are returned.
"""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import assume, given
from support.exploring import examples
from support.generators.random_linkages import Drawing, drawn, linkages, momentum_balance, random_friction, slides
from support.generators.redundant_linkages import double, rods, three_cranks, wheels
from support.generators.spatial_crank_slide import SPATIAL
from support.generators.spatial_linkages import Loops, bennett, four_bar
from support.oracles import friction_script
from support.texts import load, shipped

import pinpress as pp

ENGINES = ("plane", "space", "pinocchio")
ANGLE = np.linspace(-7.0, 4.0, 31)
SERVO = {"angle": ANGLE, "speed": 6 * np.cos(np.linspace(0, 5, 31)), "acceleration": 40 * np.sin(np.linspace(1, 8, 31))}
LIFT = np.linspace(-2e5, 9e5, 31)
UP = np.array([0.0, 0.0, 1.0])


# ---------------------------------------------------------------------------------------------------- laws that hold for every linkage


class Turning:
    """Of every bearing in every state: axis (n, 3) of its turning or sliding, speed (n,) along it, both from Pinocchio's open tree."""

    def __init__(self, press, motion):
        model, loops = press.model, Loops(press.text.decode(), press.model)
        data, n, count = loops.data, len(motion.q), len(press.bearings)
        self.axis, self.speed = np.zeros((count, n, 3)), np.zeros((count, n))
        self.place = np.zeros((count, n, 3))
        self.left = np.zeros((n, model.nv, 6))  # inertia forces less weights, about joint origins
        for i, (q, v, a) in enumerate(zip(motion.q, motion.v, motion.a, strict=True)):
            pin.forwardKinematics(model, data, q, v, a)
            pin.computeJointJacobians(model, data, q)
            pin.updateFramePlacements(model, data)
            for j in range(model.nv):
                column = pin.getJointJacobian(model, data, j + 1, pin.LOCAL_WORLD_ALIGNED).reshape(6, model.nv)[:, j]
                turns = np.linalg.norm(column[3:]) > 0.5
                self.axis[j, i], self.speed[j, i] = column[3:] if turns else column[:3], v[j]
                self.place[j, i] = data.oMi[j + 1].translation
                inertia, rotation = model.inertias[j + 1], data.oMi[j + 1].rotation
                rate = inertia * data.a[j + 1] + data.v[j + 1].cross(inertia * data.v[j + 1])
                weight = inertia.mass * model.gravity.linear
                self.left[i, j, :3] = rotation @ rate.linear - weight
                self.left[i, j, 3:] = rotation @ rate.angular - np.cross(rotation @ inertia.lever, weight)
            for k, loop in enumerate(loops.loops, model.nv):
                spins = [data.oMi[joint].rotation @ data.v[joint].angular for joint in loop.joints]
                spin = spins[1] - spins[0]
                size = np.linalg.norm(spin)
                self.axis[k, i], self.speed[k, i] = spin / (size or 1.0), size
                self.place[k, i] = loops.places(loop)[0].translation
        self.ends = [(model.parents[j + 1], j + 1) for j in range(model.nv)] + [tuple(loop.joints) for loop in loops.loops]


def left_over(press, result, loads=()):
    """What Newton's and Euler's equations of all bodies leave over, from forces and moments as they are documented: (n, bodies, 6)."""
    turning = Turning(press, result.motion)
    left = -turning.left
    origins = turning.place[: press.model.nv]
    for k, (name, (parent, child)) in enumerate(zip(press.bearings, turning.ends, strict=True)):
        force, moment = result.bearing_force[name], result.bearing_moment[name]
        for body, sign in ((child, 1.0), (parent, -1.0)):
            if body:
                left[:, body - 1, :3] += sign * force
                left[:, body - 1, 3:] += sign * (moment + np.cross(turning.place[k] - origins[body - 1], force))
    for coupling in press.couplings:
        if meshes_with_slide(press, coupling):  # a force at the pitch point, from shaft to slide
            slide, shaft = sorted((press.joints.index(coupling.name), coupling.leader), key=lambda joint: press.axes[joint].turns)
            follows = press.joints[slide] == coupling.name
            push = result.coupling_torque[coupling.name][:, int(not follows), None] * turning.axis[slide]
            by_turn = coupling.multiplier if follows else 1 / coupling.multiplier  # [m/rad]
            pitch = origins[shaft] + by_turn * np.cross(turning.axis[slide], turning.axis[shaft])
            for body, sign in ((slide, 1.0), (shaft, -1.0)):
                left[:, body, :3] += sign * push
                left[:, body, 3:] += sign * np.cross(pitch - origins[body], push)
    data = press.model.createData()
    for each in loads:
        frame = press.model.getFrameId(each.link, pin.BODY)
        body = press.model.frames[frame].parentJoint
        for i, q in enumerate(result.motion.q if body else ()):
            pin.framesForwardKinematics(press.model, data, q)
            force = np.broadcast_to(each.force, (len(result.motion.q), 3))[i]
            left[i, body - 1, :3] += force
            left[i, body - 1, 3:] += np.cross(data.oMf[frame].act(np.array(each.point)) - origins[body - 1, i], force)
    return left


def meshes_with_slide(press, coupling):
    """Whether a coupling is a rack: its teeth push on both bodies, where a gear pair turns both shafts by torques."""
    return press.axes[press.joints.index(coupling.name)].turns != press.axes[coupling.leader].turns


def efforts(press, result):
    """Of every bearing (n,): what it transmits along the motion that it leaves free, less drives and gear pairs. Friction alone is left."""
    turning, sliding = Turning(press, result.motion), slides(press)
    torque = dict.fromkeys(press.bearings, 0.0)
    driving = result.driving_torque.reshape(len(result.motion.q), -1)
    for k, name in enumerate(press.drivers):
        torque[name] = torque[name] + driving[:, k]
    for coupling in press.couplings:
        if meshes_with_slide(press, coupling):
            continue
        for k, name in enumerate((coupling.name, press.joints[coupling.leader])):
            torque[name] = torque[name] + result.coupling_torque[coupling.name][:, k]
    parts = [result.bearing_force[name] if name in sliding else result.bearing_moment[name] for name in press.bearings]
    along = [np.einsum("nk,nk->n", part, axis) for part, axis in zip(parts, turning.axis, strict=True)]
    return {name: effort - torque[name] for name, effort in zip(press.bearings, along, strict=True)}


def lawful(press, result, friction, rest=1e-9):
    """Efforts (n,) that the law of friction names for the bearing forces that are returned: -(c w + mu r F sign w)."""
    turning, expected = Turning(press, result.motion), {}
    for k, name in enumerate(press.bearings):
        rubbing, speed = friction.get(name, pp.loads.Friction()), turning.speed[k]
        across = np.linalg.norm(np.cross(result.bearing_force[name], turning.axis[k]), axis=1)
        sign = np.where(np.abs(speed) <= rest * np.abs(speed).max(), 0.0, np.sign(speed))
        arm = rubbing.coefficient * (1.0 if rubbing.radius is None else rubbing.radius)
        expected[name] = -(rubbing.viscous * speed + arm * np.maximum(across, rubbing.preload) * sign)
    return expected


def check(press, result, friction, loads=(), bound=1e-12):
    """Every law, within a share of the peaks: bodies in balance, efforts of friction as the law says, its power, and all power together."""
    force = max(np.abs(values).max() for values in result.bearing_force.values())
    moment = max(np.abs(values).max() for values in result.bearing_moment.values())
    moment = max(moment, force * press.size)
    left = left_over(press, result, loads)
    assert np.abs(left[:, :, :3]).max() <= bound * force
    assert np.abs(left[:, :, 3:]).max() <= bound * moment
    turning, expected, found = Turning(press, result.motion), lawful(press, result, friction), efforts(press, result)
    for k, name in enumerate(press.bearings):
        peak = force if name in slides(press) else moment
        assert np.abs(found[name] - expected[name]).max() <= bound * peak, name
        power = -expected[name] * turning.speed[k]
        assert np.abs(result.friction_power[name] - power).max() <= bound * peak * np.abs(turning.speed).max(), name
        assert result.friction_power[name].min() >= 0.0
    assert np.abs(result.power_residual).max() <= bound
    shaking_force, shaking_moment = momentum_balance(press, result.motion, loads)
    assert np.abs(result.shaking_force - shaking_force).max() <= bound * force
    assert np.abs(result.shaking_moment - shaking_moment).max() <= bound * max(moment, np.abs(shaking_moment).max())


# ----------------------------------------------------------------------------------------------------------------- against the hand script


@cache
def by_hand(name):
    """Press, friction, and what the hand script says with and without it."""
    press = shipped(name)
    friction = random_friction(press, seed=len(name))
    moved = getattr(friction_script, name)(ANGLE, SERVO["speed"], SERVO["acceleration"])
    none = dict.fromkeys(friction, 0.0)
    return press, friction, friction_script.solve(moved, LIFT, *arms(friction)), friction_script.solve(moved, LIFT, none, none)


def arms(friction):
    """Of every bearing mu r or, of a guide, mu; and its viscous friction."""
    coulomb = {bearing: each.coefficient * (each.radius or 1.0) for bearing, each in friction.items()}
    return coulomb, {bearing: each.viscous for bearing, each in friction.items()}


@pytest.mark.parametrize("name", ["crank_slide", "zxn2_3000b"])
@pytest.mark.parametrize("rubs", [False, True])
def test_hand_script(name, rubs, engine):
    """Torque and all forces of a servo motion with a forming force, 1e-12 of the peaks. Friction changes all of them."""
    press, friction, rubbing, smooth = by_hand(name)
    motion = pp.servo_cycle(press, **SERVO, engine=engine)
    loads = [pp.loads.PointForce("slide", np.outer(LIFT, UP))]
    result = pp.inverse_dynamics(press, motion, loads, friction=friction if rubs else {}, engine=engine)
    expected = rubbing if rubs else smooth
    assert np.abs(result.driving_torque - expected["torque"]).max() <= 1e-12 * np.abs(expected["torque"]).max()
    peak = max(np.abs(expected[bearing]).max() for bearing in press.bearings)
    for bearing in press.bearings:
        force = result.bearing_force[bearing]
        if bearing == "slide_guide":
            assert np.abs(force[:, 0] - expected[bearing]).max() <= 1e-12 * peak
        else:
            assert np.abs(force[:, 0] + 1j * force[:, 2] - expected[bearing]).max() <= 1e-12 * peak, bearing
    for bearing in ("torque", *press.bearings):
        assert np.abs(rubbing[bearing] - smooth[bearing]).max() > 1e-3 * np.abs(smooth[bearing]).max(), bearing


@pytest.mark.parametrize(("name", "preload"), [("crank_slide", 4e4), ("zxn2_3000b", 1.2e5)])
def test_preloaded_gibs_by_hand(name, preload, engine):
    """In some states the preload rubs, in others the force across the guide: 1e-12 of the peaks, and every law."""
    press, friction, without, _ = by_hand(name)
    moved = getattr(friction_script, name)(ANGLE, SERVO["speed"], SERVO["acceleration"])
    friction = friction | {"slide_guide": replace(friction["slide_guide"], preload=preload)}
    expected = friction_script.solve(moved, LIFT, *arms(friction), preload=preload)
    loads = [pp.loads.PointForce("slide", np.outer(LIFT, UP))]
    result = pp.inverse_dynamics(press, pp.servo_cycle(press, **SERVO, engine=engine), loads, friction=friction, engine=engine)
    peak = np.abs(expected["torque"]).max()
    assert np.abs(result.driving_torque - expected["torque"]).max() <= 1e-12 * peak
    assert np.abs(expected["torque"] - without["torque"]).max() > 1e-3 * peak
    assert 3 < (np.abs(expected["slide_guide"]) > preload).sum() < len(ANGLE) - 3
    check(press, result, friction, loads)


# ------------------------------------------------------------------------------------------------------------------------- closed forms


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["crank_slide", "zxn2_3000b", "jf75g_125_symmetric"])
def test_viscous_friction_adds_its_power(name, engine):
    """The torque gains the sum of c_i w_i^2 / w, 1e-12 of the peak: no bearing force has a say in it."""
    press = shipped(name)
    motion = pp.cycle(press, speed=7.0, points=24, engine=engine)
    rng = np.random.default_rng(1)
    friction = {bearing: pp.loads.Friction(viscous=rng.uniform(50, 300)) for bearing in press.bearings}
    bare, result = (pp.inverse_dynamics(press, motion, friction=each, engine=engine) for each in ({}, friction))
    speeds = dict(zip(press.bearings, Turning(press, motion).speed, strict=True))
    added = sum(each.viscous * speeds[bearing] ** 2 for bearing, each in friction.items()) / 7.0
    peak = np.abs(result.driving_torque).max()
    assert np.abs(result.driving_torque - bare.driving_torque - added).max() <= 1e-12 * peak
    assert added.max() > 1e-3 * peak
    for bearing, each in friction.items():
        lost = each.viscous * speeds[bearing] ** 2
        assert np.abs(result.friction_power[bearing] - lost).max() <= 1e-13 * max(lost.max(), 1e-9)


@pytest.mark.parametrize("direction", [1, -1])
def test_the_drivers_bearing(direction, engine):
    """Friction there alone leaves all forces as they are, and adds mu r F to the torque, against the turning."""
    press = shipped("zxn2_3000b")
    motion = pp.cycle(press, speed=direction * 7.0, points=24, engine=engine)
    friction = {"A": pp.loads.Friction(coefficient=0.1, radius=0.07)}
    bare, result = (pp.inverse_dynamics(press, motion, friction=each, engine=engine) for each in ({}, friction))
    peak = max(np.abs(force).max() for force in bare.bearing_force.values())
    for bearing in press.bearings:
        np.testing.assert_allclose(result.bearing_force[bearing], bare.bearing_force[bearing], rtol=0, atol=1e-14 * peak)
    added = direction * 0.1 * 0.07 * np.linalg.norm(bare.bearing_force["A"], axis=1)
    assert np.abs(result.driving_torque - bare.driving_torque - added).max() <= 1e-13 * np.abs(bare.driving_torque).max()
    np.testing.assert_allclose(result.friction_power["A"], 7.0 * np.abs(added), rtol=1e-12)


def light_crank_slide(along, radius=0.1, length=0.4):
    """A slide of 50 kg on a line through the shaft, driven by a crank and a rod that weigh next to nothing."""
    drawing = Drawing("light")
    crank = radius * np.exp(0.7j)
    ahead = (np.conj(along) * crank).real
    end = (ahead + np.sqrt(ahead**2 - radius**2 + length**2)) * along
    drawing.joint("O", "frame", "crank", 0j)
    drawing.joint("P", "crank", "rod", crank)
    drawing.joint("guide", "frame", "slide", end, along=along)
    drawing.loop("W", "rod", "slide", end)
    for link, centre, mass in (("crank", 0j, 1e-9), ("rod", crank, 1e-9), ("slide", end, 50.0)):
        drawing.body(link, mass, centre, tensor=1e-12 * np.eye(3))
    return drawing.urdf("O"), crank, end


@pytest.mark.filterwarnings("ignore:.*points down:pinpress.PinpressWarning")
@pytest.mark.parametrize("along", [1j, -1j, 1 + 0j, np.exp(0.5j)], ids=["up", "down", "across", "slope"])
@pytest.mark.parametrize("direction", [1, -1])
def test_a_slide_that_rubs_in_its_guide(along, direction, engine):
    """A massless rod at the slope s against the guide pushes with P along it, P tan s across, and the slide's weight lies on it too:

    P = Q + mu sign(v) |N|, N = weight across less P tan s, with Q the slide's inertia and weight along. One of the signs of N fits.
    """
    text, crank, end = light_crank_slide(along)
    press = load(text)
    motion = pp.cycle(press, speed=direction * 5.0, points=25, engine=engine)
    mu = 0.3
    result = pp.inverse_dynamics(press, motion, friction={"guide": pp.loads.Friction(mu)}, engine=engine)
    turned = crank * np.exp(1j * motion.crank_angle)
    rod = end + along * motion.joint_position[:, press.joints.index("guide")] - turned
    slope = (np.conj(along) * rod).imag / (np.conj(along) * rod).real
    v, a = (part[:, press.joints.index("guide")] for part in (motion.v, motion.a))
    weight = 50.0 * 9.81 * np.conj(along) * 1j  # of what the guide and rod must carry: along and across
    q = 50.0 * a + weight.real
    # N = W - P s and P = Q + mu sign(v) side N, where side is the sign of N
    for side in (1.0, -1.0):
        k = mu * np.sign(v) * side
        normal = (weight.imag - q * slope) / (1 + k * slope)
        right = np.sign(normal) == side
        push = q + k * normal
        force = result.bearing_force["guide"][:, 0] + 1j * result.bearing_force["guide"][:, 2]
        expected = (1j * normal - k * normal) * along
        assert np.abs(force - expected)[right].max(initial=0.0) <= 1e-7 * np.abs(expected).max()  # the rod's 1e-9 kg
        torque = (np.conj(turned) * (push * (1 + 1j * slope) * along)).imag  # along the axis: the drawing turns counter-clockwise
        assert np.abs(result.driving_torque - torque)[right].max(initial=0.0) <= 1e-7 * np.abs(torque).max()


# ---------------------------------------------------------------------------------------------------------------------------- signs


def test_backwards_is_the_mirror_in_time(engine):
    """Coulomb friction: at the same angles, the mean torque changes its sign with the direction of the turn; forces differ by friction."""
    press = shipped("zxn2_3000b")
    friction = {bearing: pp.loads.Friction(0.1, None if bearing == "slide_guide" else 0.06) for bearing in press.bearings}
    angle = np.linspace(0.05, 6.2, 20)
    forward, backward = (
        pp.inverse_dynamics(press, pp.servo_cycle(press, angle=angle, speed=sign * 7.0, engine=engine), friction=friction, engine=engine)
        for sign in (1, -1)
    )
    bare = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=angle, speed=7.0, engine=engine), engine=engine)
    for result, sign in ((forward, 1), (backward, -1)):
        lost = sum(result.friction_power.values())
        assert np.all(sign * (result.driving_torque - bare.driving_torque) > 0)
        assert (
            np.abs(7.0 * sign * (result.driving_torque - bare.driving_torque) - lost).max()
            <= 1e-12 * 7.0 * np.abs(bare.driving_torque).max()
        )


@pytest.mark.parametrize("name", ["crank_slide", "zxn2_3000b", "jf75g_125", "jf75g_125_symmetric", "jf75g_125_two_point"])
def test_all_laws_over_a_turn(name, engine):
    """With friction everywhere; and all that is lost is what the drive puts in more; 1e-12 of the peaks."""
    press = shipped(name)
    motion = pp.cycle(press, speed=7.0, points=18, engine=engine)
    friction = random_friction(press, seed=3)
    bare, result = (pp.inverse_dynamics(press, motion, friction=each, engine=engine) for each in ({}, friction))
    check(press, result, friction)
    more = 7.0 * (result.driving_torque - bare.driving_torque)
    assert np.abs(more - sum(result.friction_power.values())).max() <= 1e-12 * 7.0 * np.abs(result.driving_torque).max()


# --------------------------------------------------------------------------------------------------------------------- dead centres, rest


@pytest.mark.parametrize(
    "angle",
    [[0.0], [np.pi], [-np.pi], [0.0, np.pi], [0.0, 1.0, np.pi], [-np.pi, 0.3, 3 * np.pi], [2 * np.pi]],
    ids=lambda angle: " ".join(f"{np.degrees(a):.0f}" for a in angle),
)
def test_a_slide_in_its_dead_centre_does_not_rub(angle, engine):
    """Its speed there is rounding: no Coulomb friction, whether or not the motion has other states; and nothing is NaN."""
    press = shipped("crank_slide")
    motion = pp.servo_cycle(press, angle=angle, speed=5.0, engine=engine)
    friction = {bearing: pp.loads.Friction(0.1, None if bearing == "slide_guide" else 0.05) for bearing in press.bearings}
    result = pp.inverse_dynamics(press, motion, friction=friction, engine=engine)
    still = np.isin(np.mod(np.round(np.degrees(motion.crank_angle)), 180), 0)
    weight_and_inertia = 100.0 * (motion.slide_acceleration + 9.81)
    along = result.bearing_force["W"][:, 2] - weight_and_inertia  # what the guide does upwards, negative
    peak = np.abs(result.bearing_force["W"]).max()
    assert np.abs(along[still]).max() <= 1e-12 * peak
    assert np.abs(along[~still]).min(initial=peak) > 1e-6 * peak
    assert not result.friction_power["slide_guide"][still].any()
    for part in (result.bearing_force, result.bearing_moment):
        assert all(np.isfinite(values).all() for values in part.values())


@pytest.mark.parametrize("name", ["crank_slide", "zxn2_3000b"])
def test_dead_centres_as_they_are_found(name, engine):
    """`dead_centres` gives them exactly enough for the slide to rest there."""
    press = shipped(name)
    ends = pp.dead_centres(press)
    motion = pp.servo_cycle(press, angle=[ends.bottom_angle, ends.top_angle], speed=7.0, engine=engine)
    result = pp.inverse_dynamics(press, motion, friction={"slide_guide": pp.loads.Friction(0.2)}, engine=engine)
    peak = np.abs(result.bearing_force["slide_guide"]).max()
    assert np.abs(result.bearing_force["slide_guide"][:, 2]).max() <= 1e-12 * peak


def carried_table():
    """A coupler on three parallel cranks, which only translates, pinned to a table on a cross slide: that pin never turns."""
    drawing, at = three_cranks(), 0.6 + 0.3j + 0.3 * np.exp(0.5j)
    drawing.joint("along", "frame", "carriage", at, along=1 + 0j)
    drawing.joint("upright", "carriage", "table", at, along=1j)
    drawing.loop("N", "table", "coupler", at)
    drawing.body("carriage", 5.0, at)
    drawing.body("table", 5.0, at)
    return drawing.urdf("O")


def test_a_pin_that_never_turns_does_not_rub(engine):
    """Its speed is rounding throughout, and none of it may count."""
    press = load(carried_table())
    motion = pp.cycle(press, speed=5.0, points=12, engine=engine)
    friction = {"N": pp.loads.Friction(0.1, 0.05)}
    bare, result = (pp.inverse_dynamics(press, motion, friction=each, engine=engine) for each in ({}, friction))
    assert not result.bearing_moment["N"][:, 1].any()
    np.testing.assert_array_equal(result.driving_torque, bare.driving_torque)


# ---------------------------------------------------------------------------------------------------- forces that vanish, or are large


@pytest.mark.parametrize("coefficient", [0.05, 0.3])
@pytest.mark.parametrize("guide", ["slide_guide", "counterweight_guide"])
def test_a_guide_without_a_force(guide, coefficient, engine):
    """The symmetric press does not press on its guides: rounding there is neither friction nor does it lock the press."""
    press = shipped("jf75g_125_symmetric")
    motion = pp.cycle(press, speed=30.0, points=72, engine=engine)
    bare, result = (pp.inverse_dynamics(press, motion, friction=f, engine=engine) for f in ({}, {guide: pp.loads.Friction(coefficient)}))
    assert np.abs(result.driving_torque - bare.driving_torque).max() <= 1e-12 * np.abs(bare.driving_torque).max()


@pytest.mark.parametrize("coefficient", [0.1, 1.0])
def test_where_the_thrust_changes_sides(coefficient, engine):
    """The slide's guide is without a force at a crank angle: around it, to the last digit, friction is found as everywhere else."""
    press = shipped("crank_slide")
    low, high = 3.0, 3.2  # [rad]
    for _ in range(60):
        middle = (low + high) / 2
        thrust = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=[middle], speed=5.0)).bearing_force["slide_guide"][0, 0]
        low, high = (middle, high) if thrust < 0 else (low, middle)
    angle = (low + high) / 2 + 1e-15 * np.arange(-30, 31, 3)
    friction = {"slide_guide": pp.loads.Friction(coefficient)}
    result = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=angle, speed=5.0, engine=engine), friction=friction, engine=engine)
    assert np.abs(result.bearing_force["slide_guide"]).max() <= 1e-9 * np.abs(result.bearing_force["W"]).max()


def refused(press, friction, speed, engine):
    """The message with which friction is refused over a turn; None where the forces that come back are lawful (1e-10 of the peaks)."""
    motion = pp.cycle(press, speed=speed, points=24, engine=engine)
    try:
        result = pp.inverse_dynamics(press, motion, friction=friction, engine=engine)
    except pp.PinpressError as error:
        return str(error)
    check(press, result, friction, bound=1e-10)
    return None


@pytest.mark.filterwarnings("ignore:friction of.*its (coefficient|radius) is")  # so large on purpose
@pytest.mark.parametrize("share", [0.1, 0.3, 0.5, 0.75, 0.9, 0.98, 1.01, 1.3, 5.0])
@pytest.mark.exhaustive
def test_near_self_locking(share, engine):
    """The crank-slider's guide locks when mu is the cotangent of the rod's largest slope. Well below, forces are found; near and beyond,
    they are lawful, or an error names the crank angle: nothing else comes back."""
    coefficient = share * np.sqrt(0.4**2 - 0.1**2) / 0.1
    message = refused(shipped("crank_slide"), {"slide_guide": pp.loads.Friction(coefficient)}, 5.0, engine)
    if share <= 0.75:
        assert message is None
    else:
        assert message is None or re.search(r"at crank angle \d+(\.\d+)? deg", message)


@pytest.mark.filterwarnings("ignore:friction of.*its (coefficient|radius) is")  # so large on purpose
@pytest.mark.parametrize("radius", [0.1, 0.3, 1.0, 3.0, 10.0, 100.0])
@pytest.mark.exhaustive
def test_bearings_out_of_all_proportion(radius, engine):
    """Friction circles as large as the links: lawful, or refused."""
    press = shipped("zxn2_3000b")
    friction = {bearing: pp.loads.Friction(0.3, radius) for bearing in press.bearings if bearing != "slide_guide"}
    message = refused(press, friction, 7.0, engine)
    assert message is None if radius <= 0.3 else message is None or "crank angle" in message


@pytest.mark.parametrize("name", ["crank_slide", "zxn2_3000b", "jf75g_125_two_point"])
def test_many_states(name):
    """More than are worked through at a time: the same numbers as in parts, and none of them locks by rounding."""
    press = shipped(name)
    friction = random_friction(press, seed=5)
    angle = 2 * np.pi * np.arange(6000) / 6000
    whole = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=angle, speed=7.0), friction=friction)
    peak = np.abs(whole.driving_torque).max()
    for part in (slice(0, 500), slice(1900, 2200), slice(5500, 6000)):
        some = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=angle[part], speed=7.0), friction=friction)
        assert np.abs(some.driving_torque - whole.driving_torque[part]).max() <= 1e-12 * peak
    assert np.abs(whole.power_residual).max() <= 1e-12


# --------------------------------------------------------------------------------------------------------------------- other linkages


def text_of(name):
    texts = {"bennett": bennett, "spatial": lambda: SPATIAL, "turntable": lambda: four_bar("revolute", table="table")}
    texts |= {"rods": lambda: rods(3), "held_rods": lambda: rods(2, "revolute"), "three_cranks": lambda: three_cranks(0.2).urdf("O")}
    return (texts | {"rack": lambda: wheels(("s1", "guide", 5.0, 0.01), ("rack", "s1", 0.1, 0.002))})[name]()


@pytest.mark.parametrize(
    ("name", "engine"),
    [
        ("spatial", "pinocchio"),
        ("bennett", "pinocchio"),
        ("turntable", "pinocchio"),
        *((name, engine) for name in ("rods", "held_rods", "three_cranks", "rack") for engine in ENGINES),
    ],
)
def test_all_laws_of_other_linkages(name, engine):
    """Through space, redundant (shared by stiffness), geared, with two drivers; with loads across the plane: 1e-12 of the peaks."""
    press = load(text_of(name))
    states = np.linspace(0.1, 0.6, 6)
    if len(press.drivers) == 2:
        states = np.stack([states, -0.5 * states], axis=1)
    motion = pp.servo_cycle(press, angle=states, speed=7 * np.cos(9 * states), acceleration=30 * np.sin(8 * states), engine=engine)
    friction = random_friction(press, seed=11, viscous=5.0)
    loads = [pp.loads.PointForce(link, (50.0, -80.0, 300.0), (0.1, 0.0, -0.1)) for link in press.links[1:3]]
    stiffness = {"W0": 2e9, "W1": 1e9} if name == "rods" else {}
    result = pp.inverse_dynamics(press, motion, loads, friction=friction, stiffness=stiffness, engine=engine)
    check(press, result, friction, loads)
    assert min(power.max() for power in result.friction_power.values()) > 0.0


def test_friction_of_a_spherical_loop_is_in_its_moment():
    """mu r times the force across its turning, against it, in both loops of a planar and of a spatial linkage."""
    for text, loop in ((SPATIAL, "W"), (rods(1), "W0")):
        press = load(text)
        motion = pp.servo_cycle(press, angle=[0.1, 0.4], speed=5.0)
        friction = {loop: pp.loads.Friction(0.1, 0.05)}
        result = pp.inverse_dynamics(press, motion, friction=friction)
        axis = Turning(press, motion).axis[press.bearings.index(loop)]
        across = np.linalg.norm(np.cross(result.bearing_force[loop], axis), axis=1)
        expected = -0.1 * 0.05 * across[:, None] * axis
        assert np.abs(result.bearing_moment[loop] - expected).max() <= 1e-13 * np.abs(expected).max()
        check(press, result, friction)


@examples(10)
@given(spec=linkages(most=3, extra=False))
def test_random_linkages(spec):
    """Friction everywhere, loads across the plane: all engines the same to 1e-10 of the peaks, and lawful."""
    drawing = drawn(spec)
    assume(drawing is not None)
    rng = np.random.default_rng(spec.seed + 3)
    if spec.seed % 2 and not spec.tilted:
        double(drawing, rng, 1)
    press = load(drawing.urdf("crank"), gravity=tuple(rng.normal(size=3) * 10))
    low, high = (-np.inf, np.inf) if press.branch.period else press.branch.angles[[0, -1]]
    angle = rng.uniform(max(-0.05, 0.5 * low), min(0.05, 0.5 * high), 3)
    motion = pp.servo_cycle(press, angle=angle, speed=rng.uniform(3, 10, 3), acceleration=rng.uniform(-50, 50, 3))
    loads = [pp.loads.PointForce(str(rng.choice(press.links)), 100 * rng.normal(size=3), tuple(rng.normal(size=3)))]
    size = press.size
    friction = {
        name: pp.loads.Friction(rng.uniform(0, 0.2), None if name in slides(press) else 0.05 * size * rng.uniform(), rng.uniform(0, 0.1))
        for name in press.bearings
        if rng.integers(4)
    }
    results = [pp.inverse_dynamics(press, motion, loads, friction=friction, engine=engine) for engine in ENGINES]
    for result in results:
        check(press, result, friction, loads, bound=1e-10)
    *batched, other = results
    force = max(np.abs(values).max() for values in other.bearing_force.values())
    moment = max(force * size, max(np.abs(values).max() for values in other.bearing_moment.values()))
    for one in batched:
        for name in press.bearings:
            assert np.abs(one.bearing_force[name] - other.bearing_force[name]).max() <= 1e-10 * force
            assert np.abs(one.bearing_moment[name] - other.bearing_moment[name]).max() <= 1e-10 * moment
        assert np.abs(one.driving_torque - other.driving_torque).max() <= 1e-10 * moment


# -------------------------------------------------------------------------------------------------------------- none, and bad input


@pytest.mark.parametrize(
    "friction", [{}, {"A": pp.loads.Friction()}, {"A": pp.loads.Friction(0.0, 0.06, 0.0), "slide_guide": pp.loads.Friction(0)}, None]
)
def test_no_friction_and_standstill_are_without_friction(friction, engine):
    """The same bytes as without the argument; at standstill (None) with friction everywhere."""
    press = shipped("zxn2_3000b")
    motion = pp.cycle(press, speed=7.0, points=24, engine=engine)
    if friction is None:
        motion = pp.servo_cycle(press, angle=np.linspace(0, 6, 7), speed=0.0, acceleration=5.0, engine=engine)
    bare = pp.inverse_dynamics(press, motion, engine=engine)
    result = pp.inverse_dynamics(press, motion, friction=random_friction(press) if friction is None else friction, engine=engine)
    tolerance = {"rtol": 0, "atol": 1e-14 * np.abs(bare.driving_torque).max() if friction is None else 0}
    np.testing.assert_allclose(result.driving_torque, bare.driving_torque, **tolerance)
    for bearing in press.bearings:
        np.testing.assert_allclose(result.bearing_force[bearing], bare.bearing_force[bearing], **tolerance)
        np.testing.assert_allclose(result.bearing_moment[bearing], bare.bearing_moment[bearing], **tolerance)
        assert not result.friction_power[bearing].any()
    assert list(result.columns()) == list(bare.columns())
