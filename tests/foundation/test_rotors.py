"""What stands aside on the frame, and what spins in it: gyroscopic moments, whirl, critical speeds, against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.exploring import examples
from support.generators.frames import WIDE, harmonic_force, on_four, turns, uneven, weightless
from support.texts import shipped

import pinpress as pp
from pinpress import foundation
from pinpress.foundation.mounted_press import state_matrix
from pinpress.foundation.whirl_modes import SAME_MODE

FIXED = examples(5)
TILTING, POLAR, MASS = 450.0, 300.0, 1200.0
STIFFNESS = (2e6, 2e6, 7e6)


# -------------------------------------------------------------------------------------------------------------------------- the motor aside


@pytest.mark.parametrize("springs", [(), "stiff"])
def test_what_is_bolted_on_is_part_of_the_frame(springs):
    """The same as a frame with the sum of masses, first moments and inertias; on springs ten million times as stiff to 1e-6."""
    frame, mounts = uneven()
    motor = foundation.Frame(600.0, (0.2, 0.9, 0.8), (30.0, 40.0, 50.0))
    total = frame.mass + motor.mass
    centre = (frame.mass * np.array(frame.centre) + motor.mass * np.array(motor.centre)) / total
    tensor = np.zeros((3, 3))
    for body in (frame, motor):
        arm = np.array(body.centre) - centre
        tensor += body.tensor + body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    press = shipped("crank_slide")
    if springs:
        springs = [foundation.Mount((0.2 + x, 0.9 + y, 0.8 + z), (1e13,) * 3) for x, y, z in [(-0.2, 0, 0), (0.2, 0, 0), (0, 0.2, 0.2)]]
    one = foundation.mounted(press, foundation.Frame(total, centre, tensor), mounts)
    two = foundation.mounted(press, frame, mounts, attached={"motor": foundation.Attachment(motor, springs)})
    tolerance = 1e-6 if springs else 1e-12
    np.testing.assert_allclose(two.mount_load, one.mount_load, rtol=tolerance, atol=tolerance * 1e5)
    np.testing.assert_allclose(two.centre, one.centre, rtol=1e-12)
    assert two.total_mass == pytest.approx(one.total_mass, rel=1e-12)
    found, expected = foundation.modes(two), foundation.modes(one)
    np.testing.assert_allclose(found.natural_frequency[:6], expected.natural_frequency, rtol=tolerance)
    assert found.motion[:6] == expected.motion
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 20.0, points=60))
    there = {"top": (0.3, 0.2, 1.5)}
    whole, apart = (foundation.steady_response(each, reactions, points=there).displacement["top"] for each in (one, two))
    np.testing.assert_allclose(apart, whole, atol=tolerance * np.abs(whole).max())


def test_a_motor_on_its_bracket_is_a_mass_on_a_spring():
    """Two masses along z: the roots of (k1 + k2 - m1 w2)(k2 - m2 w2) - k2^2, and the amplitude of an absorber."""
    kz, k2, m2, height = 7e6, 8e5, 150.0, -1.0
    bracket = [foundation.Mount((x, y, height), (3e8, 3e8, k2 / 4)) for x in (-0.3, 0.3) for y in (-0.3, 0.3)]
    motor = foundation.Attachment(foundation.Frame(m2, (0, 0, height), (6.0, 6.0, 6.0)), bracket, on="frame")
    press = weightless()
    frame = foundation.Frame(MASS, (0.0, 0.0, height), (500.0, 450.0, 300.0))
    system = foundation.mounted(press, frame, on_four((2e6, 3e6, kz)), attached={"motor": motor})
    squares = np.roots([MASS * m2, -(m2 * (4 * kz + k2) + MASS * k2), 4 * kz * k2])
    found = foundation.modes(system)
    for square in squares:
        assert np.abs(found.natural_frequency / np.sqrt(square) - 1).min() < 1e-9
    assert "along z, motor" in found.motion
    w, force = 0.7 * np.sqrt(k2 / m2), 500.0
    reactions = pp.inverse_dynamics(press, pp.cycle(press, w, points=32), loads=[harmonic_force(press, force)])
    moved = foundation.steady_response(system, reactions, points={"frame": (0, 0, 0), "motor": ("motor", (0, 0, 0))}).displacement
    both = np.linalg.solve([[4 * kz + k2 - MASS * w**2, -k2], [-k2, k2 - m2 * w**2]], [force, 0.0])
    np.testing.assert_allclose([moved["frame"][0, 2], moved["motor"][0, 2]], both, rtol=1e-9)


# ---------------------------------------------------------------------------------------------------------------------------- whirl


@pytest.mark.parametrize("speed", [0.0, 10.0, 60.0])
def test_whirl_of_a_spinning_disc(speed):
    """I t'' = -k t and the gyroscopic moment J w: frequencies sqrt(k / I + g^2) +- g with g = J w / 2 I, forward the faster one."""
    system = tilting_disc()
    found = foundation.whirl(system, [speed] if speed else [0.0, 1.0])
    g, own = POLAR * 3.0 * speed / (2 * TILTING), 4 * STIFFNESS[2] * WIDE**2 / TILTING
    for sign in (1, -1):
        frequency = np.sqrt(own + g * g) + sign * g
        places = np.flatnonzero(np.abs(found.frequency[0] / frequency - 1) < 1e-9)
        assert len(places) == (1 if speed else 2)
        if speed:
            assert found.whirl[0, places[0]] == pytest.approx(sign, abs=1e-9)
    np.testing.assert_allclose(found.damping_ratio, 0.0, atol=1e-12)


def tilting_disc():
    """A rotor along z in a frame whose turns about x and y are alike, on mounts at the height of the centre of mass."""
    frame = foundation.Frame(MASS, (0.0, 0.0, -1.0), (TILTING, TILTING, 300.0))
    rotors = [foundation.Rotor(POLAR, (0, 0, 2.0), ratio=3.0)]
    return foundation.mounted(weightless(), frame, on_four(STIFFNESS), rotors=rotors)


def test_critical_speeds_of_a_spinning_disc():
    """Order k meets forward whirl where k^2 w^2 = k / (I - J ratio / order), if the disc is long; backward with a plus."""
    system = tilting_disc()
    spring = 4 * STIFFNESS[2] * WIDE**2
    diagram = foundation.whirl(system, [1.0, 2.0])
    for order in (1, 3):
        inertia = TILTING + np.array([1, -1]) * POLAR * 3.0 / order
        expected = np.sqrt(spring / inertia[inertia > 0]) / order
        found = diagram.critical_speeds(order)
        assert len(found) == 6 - (inertia < 0).sum()
        for speed in expected:
            assert np.abs(found / speed - 1).min() < 1e-9


@FIXED
@given(st.integers(0, 2**32 - 1))
def test_critical_speeds_lie_on_the_curves(seed):
    rng = np.random.default_rng(seed)
    frame, mounts = uneven()
    rotors = [foundation.Rotor(rng.uniform(100, 2000), rng.normal(size=3), ratio=rng.uniform(-4, 4)) for _ in range(2)]
    system = foundation.mounted(shipped("crank_slide"), frame, mounts, rotors=rotors)
    speeds = foundation.whirl(system, [1.0]).critical_speeds(2)
    for speed in speeds:
        assert np.abs(foundation.whirl(system, [speed]).frequency / (2 * speed) - 1).min() < 1e-8


def test_frequencies_are_eigenvalues_of_the_spinning_system():
    """Against the eigenvalues of the first-order system; damping to first order, so a hundredth of the dampers errs 1e-4 as much."""
    frame, mounts = uneven()
    light = [foundation.Mount(m.point, m.stiffness, tuple(1e-2 * np.array(m.damping)), loss_factor=1e-3) for m in mounts]
    rotors = [foundation.Rotor(900.0, (0.1, 1.0, 0.2), ratio=2.0), foundation.Rotor(50.0, (0, 1, 0), ratio=-9.0)]
    system = foundation.mounted(shipped("crank_slide"), frame, light, rotors=rotors)
    for k, speed in enumerate((5.0, 40.0)):
        exact = np.linalg.eigvals(state_matrix(system, speed) - loss_in_time(system))
        exact = exact[exact.imag > 0][np.argsort(exact[exact.imag > 0].imag)]
        found = foundation.whirl(system, [5.0, 40.0])
        order = np.argsort(found.frequency[k])
        np.testing.assert_allclose(found.frequency[k][order], exact.imag, rtol=1e-6)
        viscous = foundation.whirl(foundation.mounted(system.press, frame, [no_loss(m) for m in light], rotors=rotors), [5.0, 40.0])
        np.testing.assert_allclose(viscous.damping_ratio[k][order], -exact.real / np.abs(exact), rtol=1e-5)
        assert (found.damping_ratio - viscous.damping_ratio)[k].min() > 0


def loss_in_time(system):
    """What the loss factors add to the first-order system."""
    return state_matrix(system) - state_matrix(foundation.mounted(system.press, system.frame, [no_loss(m) for m in system.mounts]))


def no_loss(mount):
    return foundation.Mount(mount.point, mount.stiffness, mount.damping)


def test_modes_of_a_rotor_that_hardly_spins_are_named_as_those_at_standstill():
    frame, mounts = uneven()
    spinning = foundation.mounted(shipped("crank_slide"), frame, mounts, rotors=[foundation.Rotor(1e-3, (0.0, 1.0, 0.2))])
    diagram = foundation.whirl(spinning, [0.0, 30.0])
    assert tuple(diagram.motion(int(k)) for k in np.argsort(diagram.frequency[-1])) == foundation.modes(spinning).motion


def test_modes_are_followed_where_curves_cross():
    """In coarse and in fine steps the same curves; each mode keeps the product with itself."""
    frame, mounts = uneven()
    system = foundation.mounted(shipped("crank_slide"), frame, mounts, rotors=[foundation.Rotor(3000.0, (0, 1, 0), ratio=2.0)])
    fine, coarse = foundation.whirl(system, np.linspace(0.0, 60.0, 241)), foundation.whirl(system, [0.0, 30.0, 60.0])
    np.testing.assert_allclose(coarse.frequency, fine.frequency[::120], rtol=1e-9)
    products = np.abs(np.einsum("ski,ij,skj->sk", fine.shapes[1:].conj(), system.mass, fine.shapes[:-1]))
    assert products.min() > SAME_MODE
    assert "forward" in str(fine)
    assert "critical speeds" in str(fine)


def test_gyroscopic_moments_do_no_work():
    system = foundation.mounted(shipped("crank_slide"), *uneven(), rotors=[foundation.Rotor(300.0, (0, 1, 0), on="frame")])
    np.testing.assert_array_equal(system.gyroscopic, -system.gyroscopic.T)
    assert np.linalg.matrix_rank(system.gyroscopic) == 2


# ------------------------------------------------------------------------------------------------------------------------- responses


def with_a_rotor():
    frame, mounts = uneven()
    damped = [foundation.Mount(m.point, m.stiffness, tuple(8 * np.array(m.damping))) for m in mounts]
    press = shipped("jf75g_125")
    rotors = [foundation.Rotor(400.0, (0, 1, 0), ratio=4.0)]
    return foundation.mounted(press, frame, damped, rotors=rotors), press


def test_the_steady_state_is_where_time_leads():
    """Many turns in time from rest end in the steady state, gyroscopic moments included; without the rotor they end elsewhere."""
    system, press = with_a_rotor()
    there, states = {"top": (0.3, 0.2, 1.5)}, 180
    steady = foundation.steady_response(system, pp.inverse_dynamics(press, pp.cycle(press, 20.0, points=states)), points=there)
    motion = turns(press, 20.0, 25, states)
    reactions = pp.inverse_dynamics(press, motion)
    last = foundation.time_response(system, reactions, points=there).displacement["top"][-states - 1 : -1]
    size = np.abs(steady.displacement["top"]).max()
    np.testing.assert_allclose(last, steady.displacement["top"], atol=3e-4 * size)
    plain = foundation.mounted(press, system.frame, system.mounts)
    without = foundation.steady_response(plain, pp.inverse_dynamics(press, pp.cycle(press, 20.0, points=states)), points=there)
    assert np.abs(without.displacement["top"] - steady.displacement["top"]).max() > 3e-2 * size
    over = foundation.over_speeds(system, [15.0, 20.0], points=there)
    np.testing.assert_allclose(over.rms["top"][1], steady.rms("top"), rtol=1e-6)


@pytest.mark.exhaustive
def test_a_rotor_that_speeds_up():
    """Against M u'' + (C + w G) u' + (K + w' G) u = f - w' h, by SciPy with w from a table."""
    from scipy.integrate import solve_ivp
    from scipy.interpolate import make_interp_spline

    system, press = with_a_rotor()
    time = np.linspace(0.0, 1.0, 4001)
    motion = pp.servo_cycle(press, angle=5.0 * time**2, time=time)
    found = foundation.time_response(system, pp.inverse_dynamics(press, motion), points={})
    reactions = pp.inverse_dynamics(press, motion)
    wrench = np.hstack([reactions.shaking_force, reactions.shaking_moment]) - system.press_weight
    wrench[:, 3:] -= np.outer(motion.crank_acceleration, system.rotors[0].momentum)
    force = make_interp_spline(motion.time, wrench, k=1)

    def rate(t, x):
        u, v = x[:6], x[6:]
        resisting = (system.damping + 10.0 * t * system.gyroscopic) @ v + (system.stiffness + 10.0 * system.gyroscopic) @ u
        return np.concatenate([v, np.linalg.solve(system.mass, force(t) - resisting)])

    exact = solve_ivp(rate, (0.0, 1.0), np.zeros(12), rtol=1e-9, atol=1e-14, max_step=1e-3).y[:6, -1]
    np.testing.assert_allclose(found.coordinates[-1], exact, atol=2e-6 * np.abs(found.coordinates).max())
