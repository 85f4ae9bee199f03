"""A press on its mounts as it runs: flywheel, piling, bed and crown; and mounts that isolate."""

import dataclasses

import numpy as np
import pinocchio as pin
import pytest
from support.generators.frames import on_four, turns, uneven
from support.texts import shipped

import pinpress as pp
from pinpress import foundation

FLYWHEEL = pp.drives.Flywheel(136.0)
PILING = pp.loads.ConstantForce(force=1e5, height=4.86e-5)
BED, CROWN = foundation.Frame(8000, (0, 0, -1.0), (3000, 2500, 3000)), foundation.Frame(7000, (0, 0.1, 0.4), (2500, 2000, 2500))
MOUNTS = on_four((1e7, 1e7, 1e9), height=-1.3, loss_factor=0.15)


def columns(stiffness=6e8, loss_factor=0.04):
    return on_four((1e8 * stiffness / 6e8, 1e8 * stiffness / 6e8, stiffness), height=-0.3, loss_factor=loss_factor)


def piling(press, duration, points, load=PILING):
    run = pp.simulate(press, duration, speed=350 * pp.RPM, flywheel=FLYWHEEL, loads=[load], points=points)
    return pp.inverse_dynamics(press, run, loads=[load])


# ----------------------------------------------------------------------------------------------------------------------------- flywheel


def test_flywheel_turns_the_frame_as_if_it_were_part_of_the_crank():
    """The same inertia put into the crank's body in the URDF gives the same shaking moment in any run."""
    press = shipped("jf75g_125_plain")
    crank = press.model.getJointId("O")
    inertias = [pin.Inertia(inertia) for inertia in press.model.inertias]
    body = inertias[crank]
    inertias[crank] = pin.Inertia(body.mass, body.lever, body.inertia + FLYWHEEL.inertia * np.diag([0.5, 1.0, 0.5]))  # a disc
    whole = press.with_inertias(inertias)
    angle = np.linspace(0.0, 3.0, 50)
    motion = pp.servo_cycle(press, speed=20 + angle, angle=angle, acceleration=20 + angle)
    apart, within = pp.inverse_dynamics(press, motion), pp.inverse_dynamics(whole, motion)
    moment = foundation.flywheel_moment(press, motion, FLYWHEEL)
    assert np.abs(moment[:, 1]).min() > 1000.0
    scale = np.abs(within.shaking_moment).max()
    np.testing.assert_allclose(apart.shaking_moment + moment, within.shaking_moment, atol=1e-12 * scale)


def test_flywheel_rocks_the_frame_only_where_the_speed_changes():
    press = shipped("jf75g_125")
    system = foundation.mounted(press, *uneven())
    even = pp.inverse_dynamics(press, pp.cycle(press, 30.0, points=90))
    without, with_it = (foundation.steady_response(system, even, points={}, flywheel=flywheel) for flywheel in (None, FLYWHEEL))
    np.testing.assert_array_equal(without.coordinates, with_it.coordinates)
    result = piling(press, 0.05, 501)
    without, with_it = (foundation.time_response(system, result, points={}, flywheel=flywheel) for flywheel in (None, FLYWHEEL))
    assert np.abs(with_it.coordinates - without.coordinates)[:, 4].max() > 0.01 * np.abs(without.coordinates[:, 4]).max()


# ----------------------------------------------------------------------------------------------------------------------- bed and crown


def test_stiff_columns_make_one_frame_of_two_parts():
    """The limit of a rigid frame, from which it differs by mounts / columns; the process force then shakes nothing."""
    press = shipped("jf75g_125_plain")
    bodies = [pin.Inertia(part.mass, np.array(part.centre), part.tensor) for part in (BED, CROWN)]
    both = bodies[0] + bodies[1]
    rigid = foundation.mounted(press, foundation.Frame(both.mass, both.lever, both.inertia), MOUNTS)
    split = foundation.mounted(press, BED, MOUNTS, crown=CROWN, uprights=columns(6e13))
    together = np.vstack([np.eye(6), np.eye(6)])  # bed and crown as one: columns and their static forces cancel
    for one, two in ((rigid.mass, split.mass), (rigid.stiffness, split.stiffness), (rigid.loss, split.loss)):
        np.testing.assert_allclose(together.T @ two @ together, one, atol=1e-7 * np.abs(one).max())
    result = pp.inverse_dynamics(press, pp.cycle(press, 30.0, points=720), loads=[pp.loads.DeepDrawing(1e5, start=0.03)])
    whole = foundation.steady_response(rigid, result, points={"top": (0, 0, 1)})
    parts = foundation.steady_response(split, result, points={"top": ("crown", (0, 0, 1)), "bed": (0, 0, 1)})
    rigidly = whole.displacement["top"]
    for point in ("top", "bed"):
        np.testing.assert_allclose(parts.displacement[point], rigidly, atol=1e-4 * np.abs(rigidly).max())
    np.testing.assert_allclose(foundation.modes(split).natural_frequency[:6], foundation.modes(rigid).natural_frequency, rtol=1e-4)
    np.testing.assert_allclose(split.mount_load, rigid.mount_load, rtol=1e-4, atol=1e-3 * np.abs(rigid.mount_load).max())


def test_process_force_stretches_the_columns():
    """A force that hardly changes, as slowly as the press crawls: crown and bed part by force / stiffness of the columns."""
    press = shipped("jf75g_125_plain")
    system = foundation.mounted(press, BED, MOUNTS, crown=CROWN, uprights=columns(loss_factor=0.0))
    drawing = pp.loads.DeepDrawing(1e5, start=0.03)
    points = {"crown": ("crown", (0, 0, 0)), "bed": (0, 0, 0)}
    motion = pp.cycle(press, 0.01, points=720)
    forced, idle = (
        foundation.steady_response(system, pp.inverse_dynamics(press, motion, loads=loads), points=points).displacement
        for loads in ([drawing], [])
    )
    parted = (forced["crown"] - forced["bed"] - idle["crown"] + idle["bed"])[:, 2]
    force = np.zeros(720)
    down = motion.slide_velocity < 0
    height = motion.slide_position - motion.slide_position.min()
    force[down] = 1e5 * np.sin(np.pi * (0.03 - height[down]) / 0.03)
    np.testing.assert_allclose(parted, force / 2.4e9, atol=2e-3 * 1e5 / 2.4e9)


def test_piling_rings_down_with_the_damping_of_the_stretching_mode():
    """After the stroke the columns' rate of stretching decays by the mode's decrement: 2 pi z / sqrt(1 - z^2)."""
    press = shipped("jf75g_125_symmetric")
    system = foundation.mounted(press, dataclasses.replace(BED, centre=(0, 0, -1)), MOUNTS, crown=CROWN, uprights=columns(loss_factor=0.06))
    result = piling(press, 0.15, 6001)
    response = foundation.time_response(system, result, points={"crown": ("crown", (0, 0, 0)), "bed": (0, 0, 0)}, flywheel=FLYWHEEL)
    found = foundation.modes(system)
    place = list(found.motion).index("stretching")
    stretch = response.displacement["crown"][:, 2] - response.displacement["bed"][:, 2]
    # The modal coordinate, by the mass matrix: of all that decays, this mode alone.
    modal = response.coordinates @ (system.mass @ found.shapes[:, place])
    held = np.abs(result.motion.slide_position - result.motion.slide_position.min()) <= PILING.height
    ends = np.flatnonzero(held[:-1] & ~held[1:])
    after = slice(ends[0] + 20, ends[0] + 20 + int(6 * 2 * np.pi / found.natural_frequency[place] / 2.5e-5))
    expected = 2 * np.pi * found.damping_ratio[place] / np.sqrt(1 - found.damping_ratio[place] ** 2)
    ringing = modal[after] - modal[after].mean()
    assert foundation.logarithmic_decrement(ringing) == pytest.approx(expected, rel=0.1)
    assert np.abs(stretch).max() > 1e5 / 2.4e9


def test_time_of_a_run_converges_with_its_states():
    """Jumps of the process force fall between states: first order, halving the step halves what is wrong."""
    press = shipped("jf75g_125_plain")
    system = foundation.mounted(press, BED, MOUNTS, crown=CROWN, uprights=columns())
    points = {"crown": ("crown", (0, 0, 0))}
    found = []
    for finer in (1, 8, 32):
        response = foundation.time_response(system, piling(press, 0.1, finer * 200 + 1), points=points, flywheel=FLYWHEEL)
        found.append(response.displacement["crown"][::finer])
    errors = [np.abs(some - found[-1]).max() for some in found[:-1]]
    assert errors[1] < 0.3 * errors[0]


# --------------------------------------------------------------------------------------------------------------------- steady runs


def test_a_period_of_a_steady_run_is_what_time_comes_to():
    """Under load with a motor the speed changes; one period by harmonics against many such periods in time, both with the flywheel."""
    press = shipped("jf75g_125")
    frame, mounts = uneven()
    damped = [foundation.Mount(m.point, m.stiffness, tuple(10 * np.array(m.damping))) for m in mounts]
    system = foundation.mounted(press, frame, damped)
    loads = [pp.loads.DeepDrawing(1e5, start=0.01)]
    motor = pp.drives.Geared(pp.drives.InductionMotor(rated_power=30e3, rated_speed=1485 * pp.RPM), ratio=4.95)
    steady = pp.steady_state(press, 300 * pp.RPM, drive=motor, flywheel=pp.drives.Flywheel(20.0), loads=loads, points=361)
    response = foundation.steady_response(
        system, pp.inverse_dynamics(press, steady, loads), points={"O": (0, 0, 0)}, flywheel=pp.drives.Flywheel(20.0)
    )
    one = np.s_[:-1]
    angle = np.concatenate([steady.crank_angle[one] + 2 * np.pi * k for k in range(16)])
    motion = pp.servo_cycle(
        press,
        speed=np.tile(steady.crank_speed[one], 16),
        angle=angle,
        acceleration=np.tile(steady.crank_acceleration[one], 16),
        time=np.arange(len(angle)) * (steady.time[1] - steady.time[0]),
    )
    time = foundation.time_response(
        system, pp.inverse_dynamics(press, motion, loads), points={"O": (0, 0, 0)}, flywheel=pp.drives.Flywheel(20.0)
    )
    size = np.abs(response.coordinates).max(axis=0)
    np.testing.assert_allclose(time.coordinates[-360:] / size, response.coordinates / size, atol=1e-3)


# ------------------------------------------------------------------------------------------------------------------------ isolation

SPEEDS = np.linspace(200, 400, 11) * pp.RPM
FRAME = foundation.Frame(15000, (0, 0, -0.6), (9000, 8000, 4000))
SPRINGS = on_four((2e6, 2e6, 2e6), (2e3, 2e3, 2e3), height=-0.6)


@pytest.mark.exhaustive
def test_isolating_mounts_are_the_stiffest_that_keep_the_limit():
    press = shipped("jf75g_125_plain")
    found = foundation.isolate(press, FRAME, SPRINGS, speeds=SPEEDS, transmitted=0.2)
    assert found.transmitted.max() <= 0.2
    stiffer = [
        dataclasses.replace(m, stiffness=tuple(1.002 * np.array(m.stiffness)), damping=tuple(np.sqrt(1.002) * np.array(m.damping)))
        for m in found.mounts
    ]
    for mounts, keeps in ((found.mounts, True), (stiffer, False)):
        response = foundation.over_speeds(foundation.mounted(press, FRAME, mounts), SPEEDS, points={})
        assert bool(response.transmitted.max() <= 0.2 * (1 + 1e-9)) is keeps
    # Mounts at the height of the centre of mass: the vertical mode alone, of closed form but for its damping and the small lateral force.
    assert found.stiffness[2] == pytest.approx(found.system.total_mass * SPEEDS[0] ** 2 * 0.2 / 1.2, rel=0.03)
    assert found.sag == pytest.approx(found.system.total_mass * 9.81 / found.stiffness[2], rel=1e-3)
    assert "sag at rest" in str(found)
    np.testing.assert_array_equal(found.to_frame()["transmitted [-]"], found.transmitted)


def test_backwards_shakes_as_forwards_mirrored_in_time():
    """Shaking force depends on the square of the speed: of a turn backwards the harmonics are the conjugates."""
    press = shipped("jf75g_125")
    system = foundation.mounted(press, *uneven())
    forwards, backwards = (
        foundation.steady_response(system, pp.inverse_dynamics(press, pp.cycle(press, speed, points=90)), points={"O": (0, 0, 0)})
        for speed in (20, -20)
    )
    wrench = [np.fft.rfft(response.shaking_force, axis=0) for response in (forwards, backwards)]
    np.testing.assert_allclose(wrench[1], wrench[0].conj(), atol=1e-9 * np.abs(wrench[0]).max())
    assert turns(press, -20.0, 1, 8).crank_angle[-1] == pytest.approx(-2 * np.pi)
