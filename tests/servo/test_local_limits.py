"""Limits that are not convex, of motions of any shape: what they measure is plain mechanics, and tangents touch them from within."""

from dataclasses import replace

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress import servo
from pinpress.kinematics.cycle import motion_through_change_points
from pinpress.servo.conic import local_limits
from pinpress.servo.conic.bounds import motion_problem
from pinpress.servo.conic.coefficients import coefficients, path_grid, path_marks
from pinpress.servo.task import make_task
from pinpress.simulation.reduced_model import energies

PATHS = {
    "turn": servo.Turn(),
    "turn backwards": servo.Turn(backwards=True),
    "stop": servo.Stop(bottom=0.3),
    "pulses": servo.Pulse(heights=(0.03, 0.01), back=0.005, dwell=0.2),
}
DRIVE = servo.ServoDrive(inertia=0.4, ratio=20.0, peak_torque=900.0, viscous=0.6)
POWER, RATE, RATIO, DRAG = 25e3, 4e4, 20.0, 0.6 * 20.0**2


def problem_of(path, drive=DRIVE, limits=()):
    task = make_task(texts.shipped("crank_slide"), drive, [], "heat", 3.0, PATHS[path], limits, {}, 120)
    return motion_problem(task.coefficients, drive, task.limits, {"heat": 1.0}, task.time)


def any_motion(problem, seed):
    """(N + 1,) squares of speeds at the nodes, 0 at rests; those of a turn end as they begin."""
    grid = problem.coefficients.grid
    b = np.random.default_rng(seed).uniform(1.0, 30.0, len(grid.angle))
    b[-1] = b[0] if grid.legs.closed else b[-1]
    return np.where(grid.rest, 0.0, b)


def plain(problem, b):
    """Mean torques with the drag (N,), mean speeds and times of segments, from energies at the nodes."""
    grid, press = problem.coefficients.grid, texts.shipped("crank_slide")
    kinetic, potential = energies(press, motion_through_change_points(press, grid.angle, 1.0))
    whole = (kinetic + 0.5 * 0.4 * RATIO**2) * b + potential
    mean_speed = 0.5 * (np.sqrt(b[1:]) + np.sqrt(b[:-1]))
    step = np.diff(grid.angle)
    return np.diff(whole) / step + DRAG * np.sign(step) * mean_speed, mean_speed, np.abs(step) / mean_speed


def follow(grid):
    """Pairs of segments without a dwell between them: a turn goes on with its first one."""
    count = len(grid.step)
    pairs = [(k, k + 1) for k in range(count - 1) if grid.leg[k] == grid.leg[k + 1] or grid.legs.dwells[grid.leg[k]] == 0]
    return np.array([*pairs, *([(count - 1, 0)] if grid.legs.closed else [])]).T


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_coefficients_of_bearings_are_the_forces_of_any_motion(way):
    """The crank at any speed and acceleration, under weight and a load by height: those of inverse dynamics."""
    press, load = texts.shipped("zxn2_3000b"), pp.loads.DeepDrawing(1e6, start=0.05)
    legs = servo.Turn(backwards=way < 0).legs(press)
    grid = path_grid(legs, path_marks(press, legs, [0.05]), 40)
    found = coefficients(press, grid, [load], {}, 2.0, ["E", "slide_guide"])
    angle = (grid.angle[:-1] + found.inner * grid.step).ravel()
    speed, acceleration = way * np.random.default_rng(5).uniform(1.0, 8.0, len(angle)), np.linspace(-60.0, 90.0, len(angle))
    motion = pp.servo_cycle(press, angle, speed=speed, acceleration=acceleration)
    reactions = pp.inverse_dynamics(press, motion, loads=[load])
    for name, each in found.bearings.items():
        parts = (part.reshape(-1, 3) for part in (each.by_acceleration, each.by_square, each.fixed))
        force = sum(factor[:, None] * part for factor, part in zip((acceleration, speed**2, np.ones_like(speed)), parts, strict=True))
        np.testing.assert_allclose(force[:, [0, 2]], reactions.bearing_force[name][:, [0, 2]], atol=1e-9 * 1e6)


@pytest.mark.parametrize("path", PATHS)
def test_power_and_rate_of_torque_are_those_of_energies(path):
    """A rate goes from the middle of a segment to that of the next, through a stop without a dwell too, but not over a dwell."""
    problem = problem_of(path)
    b, grid = any_motion(problem, 1), problem.coefficients.grid
    torque, speed, times = plain(problem, b)
    np.testing.assert_allclose(local_limits.powers(problem, b), np.abs(torque) * speed, rtol=1e-6, atol=1e-6 * POWER)
    alone, (first, second) = torque - DRAG * grid.way * speed, follow(grid)
    rates = np.abs(alone[second] - alone[first]) / (0.5 * (times[first] + times[second]))
    np.testing.assert_allclose(local_limits.torque_rates(problem, b), [*rates, 0.0], rtol=1e-6, atol=1e-6 * rates.max())


CURVES = {"concave curve": ((0, 60, 100, 140), (900, 900, 700, 100)), "convex curve": ((0, 40, 90, 140), (900, 400, 150, 90))}


@pytest.mark.one_in(8)
@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("which", ["power", "rate", *CURVES])
def test_tangents_touch_limits_from_within(path, which):
    """At the motion at which they are drawn they leave what the limit leaves, with the drag of its speeds; of other motions they leave no
    more than that."""
    speeds, torques = CURVES.get(which, (None, None))
    drive = replace(DRIVE, curve_speed=speeds, curve_torque=torques, power=POWER if which == "power" else None)
    problem = problem_of(path, drive, [servo.TorqueRate(RATE / RATIO)] if which == "rate" else [])
    grid, base = problem.coefficients.grid, any_motion(problem, 2)
    rows = local_limits.tangents(problem, base)
    drag = DRAG * grid.way * plain(problem, base)[1]
    first, second = follow(grid)

    def left(b):
        """Of the torque driving and braking, or of its rise and fall."""
        torque, speed, times = plain(problem, b)
        torque = torque - DRAG * grid.way * speed
        if which == "rate":
            change, allowed = torque[second] - torque[first], RATE * 0.5 * (times[first] + times[second])
        else:
            change, allowed = torque + drag, POWER / speed if which == "power" else RATIO * np.interp(RATIO * speed, speeds, torques)
        return allowed - change, allowed + change

    def left_by_tangents(b):
        return [np.min([row.most - row.quantity.at(b) for row in rows[sign::2]], axis=0) for sign in range(2)]

    scale = np.abs(left(base)).max()
    np.testing.assert_allclose(left_by_tangents(base), left(base), rtol=0, atol=1e-6 * scale)
    for other in (np.where(grid.rest, 0.0, 1.02 * base), *(any_motion(problem, seed) for seed in range(3, 8))):
        assert (np.array(left_by_tangents(other)) <= np.array(left(other)) + 1e-6 * scale).all()


@pytest.mark.parametrize("path", PATHS)
def test_nodes_stand_where_forces_begin_and_where_the_slide_turns_back(path):
    """On every leg, in its direction, whichever that is; a turn back at a height is an end of a leg anyhow."""
    press, blank = texts.shipped("crank_slide"), pp.loads.Blanking(1e5, 0.05, 0.02)
    grid = make_task(press, DRIVE, [blank], "heat", 3.0, PATHS[path], [], {}, 120).coefficients.grid
    lowest = pp.dead_centres(press).bottom_position

    def height(angle):
        return np.abs(pp.servo_cycle(press, np.atleast_1d(angle), speed=1.0).slide_position - lowest)

    for leg in range(grid.leg.max() + 1):
        own = np.flatnonzero(grid.leg == leg)
        nodes = grid.angle[own[0] : own[-1] + 2]
        way = np.sign(nodes[-1] - nodes[0])
        assert (way * np.diff(nodes) > 0).all()
        heights, between = height(nodes), height(np.linspace(nodes[0], nodes[-1], 2001))
        for wanted in (0.05, 0.02):
            crossed = np.count_nonzero(np.diff(np.sign(between - wanted)))
            assert np.count_nonzero(np.abs(heights - wanted) < 1e-9) >= crossed
        turns = np.count_nonzero(np.diff(np.sign(np.diff(between))))
        assert np.count_nonzero(heights < 1e-9) >= turns
