"""Feet that lift off: the linear response where none does, closed forms and SciPy where they do, motions that repeat or do not."""

import functools

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from support.generators.frames import on_four, turns, uneven, weightless
from support.oracles import feet_by_solver
from support.sampling import rest_exhaustive
from support.texts import shipped

import pinpress as pp
from pinpress import foundation
from pinpress.foundation.response import frame_wrench

MASS, KZ, GRAVITY = 1000.0, 1e5, 9.81
CENTRED = foundation.Frame(MASS, (0, 0, -1.0), (500, 500, 500))
CENTRE = {"centre": (0, 0, -1.0)}


def one_mass(damping=0.0):
    return foundation.mounted(weightless(), CENTRED, on_four((1e6, 1e6, KZ), (0.0, 0.0, damping)))


def shaken(amplitude, speed=20.0, states=90, count=1):
    """A force on the frame along z, amplitude times the weight, a sine of the crank angle."""
    press = weightless()

    def force(motion):
        return np.outer(amplitude * MASS * GRAVITY * np.sin(motion.crank_angle), [0.0, 0.0, 1.0])

    motion = turns(press, speed, count, states)
    return pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce(press.root, force)])


@functools.cache
def bouncing(damping):
    """SciPy's motion of the mass on the floor: pads with spring and damper that only press, the force linear between the same states."""
    reactions = shaken(2.5, count=2)
    time, force = reactions.motion.time, reactions.shaking_force[:, 2] - reactions.shaking_force[0, 2]
    free = MASS * GRAVITY / (4 * KZ)

    def pressing(x):
        return MASS * GRAVITY - 4 * KZ * x[0] - 4 * damping * x[1]

    def rate(t, x, stands):
        on = pressing(x) - MASS * GRAVITY if stands else -MASS * GRAVITY
        return [x[1], (np.interp(t, time, force) + on) / MASS]

    def lifts(t, x, stands):
        return pressing(x) if stands else max(x[0] - free, -pressing(x))

    vars(lifts).update(terminal=True, direction=-1)
    switches, found, x, t, stands = [], [], np.zeros(2), 0.0, True
    while t < time[-1]:
        part = solve_ivp(rate, (t, time[-1]), x, args=(stands,), events=lifts, rtol=1e-10, atol=1e-13, max_step=5e-4, dense_output=True)
        found.append((t, part.t[-1], part.sol))
        t, x = part.t[-1], part.y[:, -1]
        if part.status == 1:
            switches.append(t)
            stands = not stands
            t, x = (t + 1e-12, x + 1e-12 * np.array(rate(t, x, stands)))
    heights = np.array([next(sol for low, high, sol in found if low - 1e-11 <= t <= high + 1e-11)(t)[0] for t in time])
    return np.array(switches), heights


@pytest.mark.parametrize("damping", rest_exhaustive([0.0, 800.0], 800.0))
def test_a_bouncing_mass(damping):
    """Against SciPy with events: every lift-off and landing, and the height between; the four feet switch together."""
    switches, heights = bouncing(damping)
    found = foundation.lifting_response(one_mass(damping), shaken(2.5, count=2), points=CENTRE)
    assert len(switches) >= 3
    ours = np.ravel(np.stack([found.start, found.end], axis=1)[::4])
    np.testing.assert_allclose(ours[: len(switches)], switches, atol=1e-8)
    for k in range(1, 4):
        np.testing.assert_allclose(found.start[k::4], found.start[::4], atol=1e-9)
    np.testing.assert_allclose(found.motion.displacement["centre"][:, 2], heights, atol=5e-8)  # corners of the force cost SciPy 2e-8
    assert (found.motion.least_load >= -1e-6).all()
    assert found.gap.max() > 1e-3


def test_free_flight_and_landing():
    """A mass thrown up by half a sine: between lift-off and landing it flies as a stone does, and lands as fast as it left."""
    press, system = weightless(), one_mass()

    def force(motion):
        pushing = motion.crank_angle < np.pi
        return np.outer(3.0 * MASS * GRAVITY * np.sin(motion.crank_angle) * pushing, [0.0, 0.0, 1.0])

    motion = turns(press, 30.0, 4, 240)
    result = pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce(press.root, force)])
    found = foundation.lifting_response(system, result, points=CENTRE)
    start, end = found.start[0], found.end[0]
    time, height = found.motion.time, found.motion.displacement["centre"][:, 2]
    speed = found.motion.velocity["centre"][:, 2]
    flying = (time > max(start, np.pi / 30.0 + 1e-3)) & (time < end)
    assert flying.sum() > 10
    np.testing.assert_allclose(found.motion.acceleration["centre"][flying, 2], -GRAVITY, rtol=1e-9)
    after = time[flying][0]
    energy = 0.5 * speed[flying] ** 2 + GRAVITY * height[flying]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)
    free = MASS * GRAVITY / (4 * KZ)
    root = speed[flying][0] + np.sqrt(speed[flying][0] ** 2 + 2 * GRAVITY * (height[flying][0] - free))
    assert end == pytest.approx(after + root / GRAVITY, abs=1e-9)
    np.testing.assert_allclose(found.motion.floor_force[flying, 2], MASS * GRAVITY, rtol=1e-9)  # of 0 N, beside the weight
    total = 0.5 * MASS * speed**2 + np.where(height < free, 2 * KZ * height**2, 2 * KZ * free**2 + MASS * GRAVITY * (height - free))
    np.testing.assert_allclose(total[time > np.pi / 30.0 + 1e-3], total[-1], rtol=1e-8)


@pytest.mark.parametrize("lossy", [False, True])
def test_where_no_foot_lifts_it_is_the_linear_response(lossy):
    """Over a run that of `time_response` to rounding; over a period that in which it ends, every stroke the same, and without loss factors
    the steady state, as far as a force linear between states is one of harmonics."""
    frame, mounts = uneven()
    mounts = [foundation.Mount(m.point, m.stiffness, m.damping, loss_factor=0.1) for m in mounts] if lossy else mounts
    press = shipped("jf75g_125")
    rotors = [foundation.Rotor(100.0, (0, -1, 0))]
    system = foundation.mounted(press, frame, mounts, rotors=rotors)
    points = {"top": (0.3, 0.2, 1.5)}
    run = pp.inverse_dynamics(press, turns(press, 20.0, 2, 90))
    found = foundation.lifting_response(system, run, points=points)
    linear = foundation.time_response(system, run, points=points)
    for name in ("displacement", "acceleration"):
        one, two = getattr(found.motion, name)["top"], getattr(linear, name)["top"]
        np.testing.assert_allclose(one, two, atol=1e-9 * np.abs(two).max())
    np.testing.assert_allclose(found.motion.mount_force, linear.mount_force, atol=1e-8 * np.abs(linear.mount_force).max())
    assert len(found.mount) == 0
    assert "no mount lifts off" in str(found)
    period = pp.inverse_dynamics(press, pp.cycle(press, 20.0, points=180))
    found = foundation.lifting_response(system, period, points=points, strokes=3)
    assert found.repeats_after == 1
    assert found.change.max() < 1e-9
    assert "every stroke" in str(found)
    assert "from rest" not in str(found)
    long = foundation.time_response(system, pp.inverse_dynamics(press, turns(press, 20.0, 150, 180)), points=points)
    assert "from rest" in str(long)
    settled = long.displacement["top"][-541:]
    np.testing.assert_allclose(found.motion.displacement["top"], settled, atol=1e-6 * np.abs(settled).max())
    if lossy:  # in time a loss factor is that of each mode's own frequency
        return
    steady = foundation.steady_response(system, period, points=points)
    want = np.vstack([np.tile(steady.displacement["top"], (3, 1)), steady.displacement["top"][:1]])
    np.testing.assert_allclose(found.motion.displacement["top"], want, atol=2e-3 * np.abs(want).max())


@pytest.mark.exhaustive
def test_a_motion_that_settles_and_one_that_does_not():
    """A hammering mass: with enough damping it repeats every stroke, however it began; with less it has not after five."""
    press = weightless()

    def force(motion):
        return np.outer(1.6 * MASS * GRAVITY * np.sin(motion.crank_angle), [0.0, 0.0, 1.0])

    cycle = pp.cycle(press, 15.0, points=60)
    result = pp.inverse_dynamics(press, cycle, loads=[pp.loads.PointForce(press.root, force)])
    settled = foundation.lifting_response(one_mass(8000.0), result, points=CENTRE, strokes=10)
    assert settled.repeats_after == 1
    assert "every stroke" in str(settled)
    assert len(settled.mount) >= 4 * 10
    loose = foundation.lifting_response(one_mass(50.0), result, points=CENTRE, strokes=5)
    assert loose.repeats_after is None
    assert loose.change[-1] > 1e-3
    assert "does not" in str(loose)


def test_one_side_lifts_and_the_press_may_walk():
    """A force along x, above the mounts, lifts two feet at a time; the momentum balance holds; feet that land elsewhere stay there."""
    press = weightless()
    mounts = on_four((2e5, 2e5, KZ), (200.0, 200.0, 400.0))
    high = foundation.Frame(MASS, (0, 0, 0.2), (200, 200, 200))
    system = foundation.mounted(press, high, mounts)

    def force(motion):
        angle = motion.crank_angle
        return np.outer(MASS * GRAVITY * (0.6 * np.sin(angle) + 0.3 * np.cos(2 * angle)), [1.0, 0.0, 0.0])

    result = pp.inverse_dynamics(press, turns(press, 12.0, 3, 180), loads=[pp.loads.PointForce(press.root, force)])
    found = foundation.lifting_response(system, result, points={"centre": (0, 0, 0.2)})
    assert {1, 2} <= set(found.mount) or {3, 4} <= set(found.mount)
    assert np.abs(found.walked[:, 0]).max() > 1e-5
    assert "walked" in str(found)
    left = found.motion.shaking_force - MASS * found.motion.acceleration["centre"]
    np.testing.assert_allclose(found.motion.floor_force, left, atol=1e-8 * np.abs(left).max())
    assert found.motion.mount_force[:, :, 2].min() >= -system.mount_load[:, 2].max() - 1e-6


@pytest.mark.parametrize("method", ["explicit", pytest.param("implicit", marks=pytest.mark.exhaustive)])
def test_by_a_solver_with_events(method):
    """An uneven frame that rocks on its feet and walks, by the solvers of simulations: states, lifts, and where the pads grip."""
    press, (frame, mounts) = weightless(), uneven()
    system = foundation.mounted(press, frame, mounts)

    def force(motion):
        return np.outer(8e4 * np.sin(motion.crank_angle), [0.4, 0.2, 1.0])

    motion = turns(press, 30.0, 1, 360)
    reactions = pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce(press.root, force)])
    lifted = foundation.lifting_response(system, reactions, points={})
    wrench, time = frame_wrench(system, reactions, None), motion.time
    begin = np.concatenate([lifted.motion.coordinates[0], np.gradient(lifted.motion.coordinates, time, axis=0, edge_order=2)[0]])
    found, feet = feet_by_solver.motion(
        system, CubicSpline(time, wrench), begin, time, method=method, tolerance=1e-8, longest=2 * float(time[1])
    )
    assert len(lifted.mount) >= 3
    size = np.abs(found[:, :6]).max(axis=0)
    assert (np.abs(found[:, :6] - lifted.motion.coordinates).max(axis=0) / size).max() < 1e-3  # the force is linear between the states
    assert len(feet.switches) == 2 * len(lifted.mount) - int((lifted.end == time[-1]).sum())
    assert np.abs(feet.anchor[:, :2] - lifted.walked).max() < 1e-3 * np.abs(lifted.walked).max()


def test_a_press_that_is_thrown_about_is_doubted():
    frame, mounts = uneven()
    press = weightless()
    force = pp.loads.PointForce(press.root, lambda motion: np.outer(np.sin(motion.crank_angle), [0.0, 0.0, 3e5]))
    result = pp.inverse_dynamics(press, turns(press, 12.0, 2, 90), loads=[force])
    with pytest.warns(pp.PinpressWarning, match="turns by .* deg"):
        foundation.lifting_response(foundation.mounted(press, frame, mounts), result, points={})


def test_states_in_between_of_the_same_force_change_nothing():
    """The force is linear between states: given at the middles too, it is the same, and so are the instants of all switches."""
    press, system = weightless(), one_mass(300.0)
    coarse = turns(press, 20.0, 2, 30)
    at, push = coarse.crank_angle, 2.5 * MASS * GRAVITY * np.sin(coarse.crank_angle)
    found = []
    for motion in (coarse, turns(press, 20.0, 2, 60)):
        load = pp.loads.PointForce(press.root, lambda motion: np.outer(np.interp(motion.crank_angle, at, push), [0.0, 0.0, 1.0]))
        found.append(foundation.lifting_response(system, pp.inverse_dynamics(press, motion, loads=[load]), points=CENTRE))
    assert len(found[0].mount) >= 4
    np.testing.assert_allclose(found[1].start, found[0].start, atol=1e-10)
    np.testing.assert_allclose(found[1].end, found[0].end, atol=1e-10)
