"""Blanking that feels speed: its law at marked points, work by quadrature, runs against SciPy, and the pause before break-through."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from support.oracles import crank_slide_by_scipy, textbook_crank_slide
from support.texts import shipped

import pinpress as pp
from pinpress.loads import Blanking, RateSensitiveBlanking

BLANK = RateSensitiveBlanking(3e4, 0.04, 0.02, sensitivity=0.05, reference_speed=1e-3, peak=0.03, remaining=0.4, stripping=2e3)


def by_hand(height, velocity):
    """The force of BLANK."""
    if velocity >= 0:
        return -2e3 if 0.02 < height <= 0.04 else 0.0
    factor = 1 + 0.05 * math.asinh(-velocity / 1e-3)
    if 0.03 < height <= 0.04:
        return 3e4 * factor * math.sin(0.5 * math.pi * (0.04 - height) / 0.01)
    return 3e4 * factor * (0.4 + 0.6 * math.cos(0.5 * math.pi * (0.03 - height) / 0.01)) if 0.02 < height <= 0.03 else 0.0


def test_law_at_marked_points():
    rising, falling = BLANK.intervals(True)
    assert (rising.upper, rising.lower, falling.upper, falling.lower) == (0.04, 0.03, 0.03, 0.02)
    assert rising.force(0.04, -1.0) == pytest.approx(0.0, abs=1e-9)
    assert rising.force(0.03, 0.0) == falling.force(0.03, 0.0) == pytest.approx(3e4)
    assert falling.force(0.02, 0.0) == pytest.approx(0.4 * 3e4)
    johnson_cook = 1 + 0.05 * math.log(2 * 1.0 / 1e-3)  # at high rates
    assert rising.force(0.03, -1.0) == pytest.approx(3e4 * johnson_cook, rel=1e-7)
    assert rising.force(0.03, 0.001) < 3e4 < rising.force(0.03, -0.001)
    heights = np.linspace(0.021, 0.0399, 12)
    for each in (rising, falling):
        inside = heights[(heights > each.lower) & (heights <= each.upper)]
        assert each.force(inside, -0.3 + 0 * inside) == pytest.approx([by_hand(float(h), -0.3) for h in inside], rel=1e-13)
        slope = np.imag(each.force(inside + 0j, -0.3 + 1e-20j * np.ones(len(inside)))) / 1e-20
        factor = 1 + 0.05 * math.asinh(300)
        share = np.array([by_hand(float(h), -0.3) for h in inside]) / factor
        assert slope == pytest.approx(-share * 0.05 / math.sqrt(1 + 300**2) / 1e-3, rel=1e-10)


def test_without_rate_and_flank_it_is_blanking():
    press = shipped("jf75g_125")
    motion = pp.cycle(press, 30.0)
    plain, felt = Blanking(1e6, 0.01, 0.005, 1e4), RateSensitiveBlanking(1e6, 0.01, 0.005, 0.0, 1.0, stripping=1e4)
    one, other = (pp.inverse_dynamics(press, motion, loads=[load]).driving_torque for load in (plain, felt))
    assert np.array_equal(one, other)


def test_work_at_constant_speed_is_a_quadrature():
    press, speed = shipped("crank_slide"), 6.0
    run = pp.simulate(press, 2 * np.pi / speed, speed=speed, angle=np.pi, drive=pp.drives.PrescribedSpeed(speed), loads=[BLANK], points=3)

    def power(angle):
        height, slope = textbook_crank_slide.height(angle), textbook_crank_slide.lever(angle)
        return -by_hand(height, speed * slope) * slope

    edges = [crank_slide_by_scipy.angle_of(height) for height in (0.02, 0.03, 0.04)]
    expected = sum(quad(power, 2 * np.pi - high, 2 * np.pi - low, epsabs=1e-9)[0] for low, high in itertools.pairwise(edges))
    assert run.load_work[1] == pytest.approx(expected, rel=1e-10)
    assert run.load_work[2] == pytest.approx(expected + 2e3 * 0.02, rel=1e-10)


def test_runs_are_those_of_scipy(method):
    press = shipped("crank_slide")
    given = {"speed": 8.0, "angle": 4.6, "flywheel": pp.drives.Flywheel(60.0), "loads": [BLANK], "method": method, "points": 16}
    run = pp.simulate(press, 0.4, **given)
    expected = crank_slide_by_scipy.run(by_hand, 4.6, 8.0, 60.0, run.time)
    assert run.crank_angle[-1] > 2 * np.pi + 1.0
    assert run.crank_angle == pytest.approx(expected[0], abs=3e-6)  # SciPy does not stop where the force jumps
    assert run.crank_speed == pytest.approx(expected[1], abs=1e-4)
    assert run.stats.energy_error < 1e-8


def test_scenarios_are_runs_one_by_one():
    press = shipped("crank_slide")
    sensitivity, force = np.array([0.0, 0.05]), np.array([3e4, 2e4])
    given = {"speed": 8.0, "angle": 4.6, "flywheel": pp.drives.Flywheel(60.0), "points": 5}
    many = pp.simulate_batch(press, 0.3, loads=[replace(BLANK, force=force, sensitivity=sensitivity)], **given)
    for k in range(2):
        one = pp.simulate(press, 0.3, loads=[replace(BLANK, force=float(force[k]), sensitivity=float(sensitivity[k]))], **given)
        assert many[k].crank_angle == pytest.approx(one.crank_angle, abs=1e-10)


@pytest.mark.exhaustive
def test_a_pause_before_break_through_lowers_the_shock():
    """On springs the blank breaks slowly after a pause; the force at rest that is left bounds what can spring back from below."""
    press, w = shipped("jf75g_125_plain"), 60 * pp.RPM
    stiffness = pp.elasticity.Stiffness({"O": 3e9, "P2": 4e9, "P4": 4e9, "slide_guide": 2e9}, {"slide_guide": 2e8}, frame=3e9)
    springs = pp.elasticity.Elastic(stiffness, damping_ratio=0.03, crown_mass=4000)
    blank = RateSensitiveBlanking(6e5, 0.004, 0.002, 0.05, 1e-3, peak=0.003, remaining=0.5)
    angle = np.linspace(np.pi - 0.1, 3 * np.pi, 3049)
    reverse = {}
    for slowest in (1.0, 0.02):
        pace = 1 - (1 - slowest) * np.exp(-(((angle - 5.81) / 0.05) ** 2))
        times = np.concatenate([[0.0], np.cumsum(0.5 * (1 / pace[1:] + 1 / pace[:-1]) * np.diff(angle) / w)])
        times -= np.interp(np.pi, angle, times)
        motor = pp.drives.ServoMotor(times, angle, stiffness=2e7, damping=2e5, peak_torque=1e6, inertia=60)
        given = {"angle": np.pi, "speed": w, "drive": motor, "loads": [blank], "elastic": springs, "points": 4001, "tolerance": 1e-3}
        run = pp.simulate(press, 0.75 * times[-1], **given)
        broken = int(np.searchsorted(run.time, run.events[-1][0]))
        left = 0.5 * 6e5 * (1 + 0.05 * math.asinh(-float(run.slide_velocity[broken - 1]) / 1e-3))
        reverse[slowest] = run.reverse_force
        weight = 2200 * 9.81
        assert 0.4 * left < run.reverse_force < left + weight
    assert reverse[0.02] < 0.8 * reverse[1.0]
