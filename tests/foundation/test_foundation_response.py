"""Vibration of a press on its mounts: closed forms of one mass, frequency against time, balances, and the full nonlinear equations."""

import numpy as np
import pinocchio as pin
import pytest
from support.generators.frames import harmonic_force, on_four, turns, uneven, weightless
from support.texts import shipped

import pinpress as pp
from pinpress import PinpressError, foundation
from pinpress.foundation.response import checked_harmonics, states_that_resolve

POINTS = {"top": (0.3, 0.2, 1.5), "bed": (-0.2, 0.1, -1.0)}
SPEED = 20.0


def shaken(name="jf75g_125", speed=SPEED, frame=None, mounts=None, states=180):
    """A press on uneven mounts, and its reactions over a turn."""
    press = shipped(name)
    usual = uneven()
    system = foundation.mounted(press, frame or usual[0], mounts or usual[1])
    return system, pp.inverse_dynamics(press, pp.cycle(press, speed, points=states))


# ------------------------------------------------------------------------------------------------------------------------ one mass

MASS, KZ, CZ, FORCE = 1000.0, 4e5 / 4, 2e3 / 4, 150.0
CENTRED = foundation.Frame(MASS, (0, 0, -1.0), (500, 500, 500))


def one_mass(speed, loss_factor=0.0, damping=CZ):
    mounts = on_four((1e6, 1e6, KZ), (0.0, 0.0, damping), loss_factor=loss_factor)
    press = weightless()
    system = foundation.mounted(press, CENTRED, mounts)
    result = pp.inverse_dynamics(press, pp.cycle(press, speed, points=32), loads=[harmonic_force(press, FORCE)])
    return system, foundation.steady_response(system, result, points={"centre": (0, 0, -1.0)})


@pytest.mark.parametrize("speed", [5.0, 20.0, 55.0, -20.0])
def test_one_mass_on_a_spring_and_a_damper(speed):
    """F cos(w t): z = Re F e^(i w t) / (k - m w^2 + i w c); the floor feels (k + i w c) z."""
    system, response = one_mass(speed)
    w = abs(speed)
    z = FORCE / (4 * KZ - MASS * w**2 + 1j * w * 4 * CZ)
    turning = np.exp(1j * w * response.time)
    np.testing.assert_allclose(response.displacement["centre"][:, 2], (z * turning).real, atol=1e-10 * abs(z))
    np.testing.assert_allclose(response.velocity["centre"][:, 2], (1j * w * z * turning).real, atol=1e-10 * w * abs(z))
    np.testing.assert_allclose(response.acceleration["centre"][:, 2], (-(w**2) * z * turning).real, atol=1e-10 * w**2 * abs(z))
    floor = (4 * KZ + 1j * w * 4 * CZ) * z
    np.testing.assert_allclose(response.floor_force[:, 2], (floor * turning).real, atol=1e-9 * FORCE)
    assert response.transmitted == pytest.approx(abs(floor) / FORCE, rel=1e-9)
    assert foundation.transmissibility(system, [w])[0] == pytest.approx(abs(floor) / FORCE, rel=1e-9)
    assert response.rms("centre")[2] == pytest.approx(w**2 * abs(z) / np.sqrt(2), rel=1e-9)


def test_one_mass_on_rubber():
    """Hysteretic: z = F / (k (1 + i eta) - m w^2); at resonance F / (eta k), however slow or fast that is."""
    w = np.sqrt(4 * KZ / MASS)
    _, response = one_mass(w, loss_factor=0.1, damping=0.0)
    assert np.abs(response.displacement["centre"][:, 2]).max() == pytest.approx(FORCE / (0.1 * 4 * KZ), rel=1e-9)


def test_transmissibility_is_one_where_mounts_are_stiff_and_at_root_two_without_damping():
    system, _ = one_mass(7.0, damping=0.0)
    w = np.sqrt(4 * KZ / MASS)
    np.testing.assert_allclose(foundation.transmissibility(system, [1e-3 * w, np.sqrt(2) * w]), 1.0, rtol=2e-6)


# ---------------------------------------------------------------------------------------------------------------------------- balances


def test_power_of_the_machine_goes_into_the_dampers():
    """Over a period the wrench's work on the frame is what c v^2 loses; all six coordinates move."""
    system, result = shaken(states=360)
    response = foundation.steady_response(
        system, result, points={f"m{k}": mount.point for k, mount in enumerate(system.mounts)} | {"O": (0, 0, 0)}
    )
    wrench = np.hstack([result.shaking_force, result.shaking_moment]) - system.press_weight
    rate = np.fft.irfft(
        1j * 2 * np.pi / response.period * np.arange(181)[:, None] * np.fft.rfft(response.coordinates, axis=0), 360, axis=0
    )  # written anew from the displacements
    given = (wrench * rate).sum(axis=1).mean()
    lost = sum((response.velocity[f"m{k}"] ** 2 * mount.damping).sum(axis=1).mean() for k, mount in enumerate(system.mounts))
    assert given == pytest.approx(lost, rel=1e-9)
    assert np.abs(response.coordinates).max(axis=0).min() > 0


@pytest.mark.parametrize("lossy", [False, True])
def test_force_on_the_floor_is_what_momentum_leaves(lossy):
    """Shaking force less mass times acceleration of the whole centre of mass, in the steady state and from rest."""
    frame, mounts = uneven()
    mounts = [foundation.Mount(m.point, m.stiffness, loss_factor=0.1) for m in mounts] if lossy else mounts
    press = shipped("jf75g_125")
    system = foundation.mounted(press, frame, mounts)
    centre = {"centre": tuple(system.centre)}
    steady = foundation.steady_response(system, pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=180)), points=centre)
    starting = foundation.time_response(system, pp.inverse_dynamics(press, turns(press, SPEED, 2, 180)), points=centre)
    for response in (steady, starting):
        left = response.shaking_force - system.total_mass * response.acceleration["centre"]
        np.testing.assert_allclose(response.floor_force, left, atol=1e-9 * np.abs(response.shaking_force).max())


# ------------------------------------------------------------------------------------------------------------ frequency against time


def settled(states):
    """The last of many turns in time, and the steady state of one, of the same press."""
    frame, mounts = uneven()
    damped = [foundation.Mount(m.point, m.stiffness, tuple(8 * np.array(m.damping))) for m in mounts]
    press = shipped("jf75g_125")
    system = foundation.mounted(press, frame, damped)
    steady = foundation.steady_response(system, pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=states)), points=POINTS)
    time = foundation.time_response(system, pp.inverse_dynamics(press, turns(press, SPEED, 12, states)), points=POINTS)
    return steady, time


def test_time_comes_to_the_steady_state_with_the_square_of_the_step():
    """The force is a line between states: error of second order, here of some 1e-4 at 60 states a turn."""
    errors = []
    for states in (60, 120):
        steady, time = settled(states)
        begin = 11 * states
        size = np.abs(steady.displacement["top"]).max()
        errors.append(np.abs(time.displacement["top"][begin:-1] - steady.displacement["top"]).max() / size)
        np.testing.assert_allclose(time.floor_force[begin:-1], steady.floor_force, atol=20 * errors[-1] * np.abs(steady.floor_force).max())
    assert errors[0] < 1e-3
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_speeds_at_once_are_those_one_by_one():
    frame, mounts = uneven()
    press = shipped("jf75g_125")
    system = foundation.mounted(press, frame, mounts)
    speeds = np.array([15.0, 22.0, 40.0])
    together = foundation.over_speeds(system, speeds, points=POINTS)
    for k, speed in enumerate(speeds):
        alone = foundation.steady_response(system, pp.inverse_dynamics(press, pp.cycle(press, speed, points=360)), points=POINTS)
        for point in POINTS:
            np.testing.assert_allclose(together.rms[point][k], alone.rms(point), rtol=1e-6)
            np.testing.assert_allclose(together.peak[point][k], alone.peak(point), rtol=1e-6)
        assert together.transmitted[k] == pytest.approx(alone.transmitted, rel=1e-7)


def test_acceleration_grows_with_the_square_far_below_resonance():
    """Displacements follow the force, which grows as w^2; accelerations as w^4 on stiff springs, w^2 on soft ones."""
    frame = foundation.Frame(1e4, (0, 0, -0.5), (6e3, 6e3, 6e3))
    for stiffness, power in ((1e13, 4.0), (1e3, 2.0)):
        light = shipped("jf75g_125_plain", gravity=(0, 0, 0))
        system = foundation.mounted(light, frame, on_four((stiffness,) * 3, height=-0.5))
        found = foundation.over_speeds(system, np.linspace(20, 40, 41), points={"centre": (0, 0, -0.5)})
        assert found.growth("centre")[20] == pytest.approx(power, abs=0.01)


# ------------------------------------------------------------------------------------------------------------- all of it, nonlinear


class Floating:
    """The press with its frame on a free-flyer joint, its joints moved as a motion says, on the same springs and dampers.

    Pinocchio's rows of the free flyer, M_ff a + b = wrench of the mounts (in the frame's axes), by the classical Runge-Kutta method, its
    rotation as a quaternion. Large turns, mounts that move with the frame, the inertia of every pose, Coriolis and gyroscopic forces: all
    are in.
    """

    def __init__(self, system, motion):
        press, frame = system.press, system.frame
        base = pin.Model()
        joint = base.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "floating")
        base.appendBodyToJoint(joint, pin.Inertia(frame.mass, np.array(frame.centre), frame.tensor), pin.SE3.Identity())
        place = base.addFrame(pin.Frame("carrier", joint, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
        self.model = pin.appendModel(base, press.model, place, pin.SE3.Identity())
        self.model.gravity = press.model.gravity
        assert list(self.model.names)[2:] == list(press.joints)
        self.data, self.motion, self.system = self.model.createData(), motion, system
        self.points = np.array([mount.point for mount in system.mounts])
        self.stiffness = np.array([mount.stiffness for mount in system.mounts])
        self.damping = np.array([mount.damping for mount in system.mounts])

    def rate(self, k, state):
        place, turn, v = state[:3], state[3:7] / np.linalg.norm(state[3:7]), state[7:]
        rotation = pin.Quaternion(turn).matrix()
        q = np.concatenate([place, turn, self.motion.q[k]])
        free = np.concatenate([v, self.motion.v[k]])
        given = np.concatenate([np.zeros(6), self.motion.a[k]])
        bias = pin.rnea(self.model, self.data, q, free, given)[:6]
        inertia = pin.crba(self.model, self.data, q)[:6, :6]
        inertia = np.triu(inertia) + np.triu(inertia, 1).T
        arms = self.points @ rotation.T
        moved = place + arms - self.points
        speed = rotation @ v[:3] + np.cross(rotation @ v[3:], arms)
        force = (self.system.mount_load - self.stiffness * moved - self.damping * speed) @ rotation  # in the frame's axes
        wrench = np.concatenate([force.sum(axis=0), np.cross(self.points, force).sum(axis=0)])
        x, y, z, w = turn
        wx, wy, wz = v[3:]
        spin = 0.5 * np.array([w * wx + y * wz - z * wy, w * wy + z * wx - x * wz, w * wz + x * wy - y * wx, -x * wx - y * wy - z * wz])
        return np.concatenate([rotation @ v[:3], spin, np.linalg.solve(inertia, wrench - bias)])

    def displacement(self, point):
        """(states, 3) of a point from rest, at every second state of the motion: the others are middles of steps."""
        step = 2 * (self.motion.time[1] - self.motion.time[0])
        state = np.array([0, 0, 0, 0, 0, 0, 1.0, *np.zeros(6)])
        found = [np.zeros(3)]
        for k in range(0, len(self.motion.time) - 2, 2):
            a = self.rate(k, state)
            b = self.rate(k + 1, state + 0.5 * step * a)
            c = self.rate(k + 1, state + 0.5 * step * b)
            d = self.rate(k + 2, state + step * c)
            state = state + step / 6 * (a + 2 * b + 2 * c + d)
            found.append(state[:3] + pin.Quaternion(state[3:7] / np.linalg.norm(state[3:7])).matrix() @ point - point)
        return np.array(found)


def nonlinear_and_linear(name, speed, scale, count=2, states=240):
    frame, mounts = uneven(scale)
    press = shipped(name)
    system = foundation.mounted(press, frame, mounts)
    motion = turns(press, speed, count, states)
    linear = foundation.time_response(system, pp.inverse_dynamics(press, motion), points=POINTS).displacement["top"][::2]
    return Floating(system, motion).displacement(np.array(POINTS["top"])), linear


@pytest.mark.parametrize(("name", "speed"), [("jf75g_125_plain", 35.0), ("zxn2_3000b", 8.0)])
def test_linear_model_differs_by_second_order_from_the_full_equations(name, speed):
    """A frame and mounts ten times as heavy and stiff vibrate a tenth; what the linear model leaves out (inertia that changes over the
    turn, gyroscopic moments, large turns) is a product of vibration and share of the moving mass: a hundredth. The motion is spatial."""
    sizes, differences = [], []
    for scale in (10.0, 100.0):
        full, linear = nonlinear_and_linear(name, speed, scale)
        sizes.append(np.abs(full).max())
        differences.append(np.abs(full - linear).max())
        assert (np.abs(full).max(axis=0) > 1e-3 * sizes[-1]).all()
    assert differences[0] < 0.1 * sizes[0]
    assert 8 < sizes[0] / sizes[1] < 12
    assert 70 < differences[0] / differences[1] < 140


def test_mounts_that_lift_off_are_named():
    press = weightless()
    system = foundation.mounted(press, CENTRED, on_four((1e6, 1e6, KZ)))
    heavy = harmonic_force(press, 1.5 * MASS * 9.81)
    result = pp.inverse_dynamics(press, pp.cycle(press, 0.5, points=32), loads=[heavy])
    response = foundation.steady_response(system, result, points={})
    assert response.least_load.max() < 0
    assert "lifts off" in str(response)


def test_a_press_that_is_loaded_again_is_the_same():
    system, ours = shaken(states=60)
    press = pp.load("jf75g_125")
    again = pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=60))
    floors = [foundation.steady_response(system, reactions, points={}).floor_force for reactions in (again, ours)]
    np.testing.assert_array_equal(*floors)


def test_the_states_that_a_jump_needs_are_told():
    """As many as `steady_response` takes, and hardly more: a jump's harmonics fall as one over their order. From few, about as many."""
    system, _ = shaken(states=60)
    jumping = pp.loads.PointForce("frame", lambda m: np.outer(m.crank_angle > 3.0, [0, 0, 1e5]))

    def of(states):
        return pp.inverse_dynamics(system.press, pp.cycle(system.press, 3.0, points=states), loads=[jumping])

    from_few, from_more = (states_that_resolve(system, of(states)) for states in (60, 500))
    with pytest.raises(PinpressError, match=f"500 states do not resolve .*: give about {from_more} points"):
        foundation.steady_response(system, of(500), points={})
    assert states_that_resolve(system, of(from_more)) == from_more == foundation.steady_response(system, of(from_more), points={}).time.size
    assert states_that_resolve(system, of(int(0.8 * from_more))) > 0.8 * from_more, "a fifth less are too few"
    assert 0.8 < from_few / from_more < 1.25


def test_harmonics_solved_some_at_a_time(monkeypatch):
    """Those of a long period would take too much memory together."""
    system, reactions = shaken(states=60)
    together = foundation.steady_response(system, reactions, points=POINTS)
    monkeypatch.setattr("pinpress.foundation.response.SOLVED_AT_ONCE", 7 * len(system.mass) ** 2)
    for name, values in foundation.steady_response(system, reactions, points=POINTS).columns().items():
        assert np.array_equal(values, together.columns()[name])


@pytest.mark.parametrize("states", [30, 31])
def test_the_highest_harmonic_counts_where_its_phase_is_known(states):
    """Of an even number of states the highest one is their alternation, which may be sine or cosine; of an odd number it is a true one."""
    harmonics = np.zeros((states // 2 + 1, 6), dtype=complex)
    harmonics[1], harmonics[-1] = 1.0, 1e-15
    kept = checked_harmonics(harmonics.copy(), states, 1e3)
    np.testing.assert_array_equal(kept[:-1], harmonics[:-1])
    np.testing.assert_array_equal(kept[-1], 0.0 if states == 30 else harmonics[-1])
