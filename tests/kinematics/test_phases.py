"""Phases of the stroke, the longest even part, and transmission angles over a motion, against closed forms."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from support import texts
from support.oracles.closed_form_slides import crank_slide, scotch_yoke, turn

import pinpress as pp
from pinpress.kinematics import measures

L1, L3, L4, L6, H, SPEED = 0.108, 0.648, 0.220, 0.350, 0.630, 7.54  # lengths of Chen 2002 [m], speed of the crank [rad/s]


def ram(angle):
    """Position and speed [m, m/s] of the guide-bar press's ram towards the work, by (7) to (17) of Chen 2002."""
    s3 = np.sqrt(L6**2 + L1**2 + 2 * L1 * L6 * np.sin(angle))
    theta3 = np.arccos(L1 * np.cos(angle) / s3)
    theta4 = np.arcsin((H - L3 * np.sin(theta3)) / L4)
    omega3 = L1 * SPEED * np.cos(angle - theta3) / s3
    omega4 = -L3 * omega3 * np.cos(theta3) / (L4 * np.cos(theta4))
    return -L3 * np.cos(theta3) - L4 * np.cos(theta4), L3 * omega3 * np.sin(theta3) + L4 * omega4 * np.sin(theta4)


@pytest.fixture(scope="module")
def thin_wall():
    return texts.shipped("thin_wall")


@pytest.fixture(scope="module")
def motion(thin_wall):
    return pp.cycle(thin_wall, SPEED, points=720)


def test_phases_of_a_sine_in_closed_form():
    """s = -r cos: the evenest part is the middle one; it begins and ends where the sine of the angle from the middle is half its length."""
    radius, length, speed = 0.1, 0.06, 3.0
    approach, working, run_out, back = pp.measures.phases(turn(scotch_yoke(radius), 360, speed, 0.0), length)
    half = math.asin(length / 2 / radius)
    assert working.turned == pytest.approx(2 * half, rel=1e-9)
    assert working.height == pytest.approx(radius + length / 2, rel=1e-9)
    assert working.highest_speed == pytest.approx(radius * speed, rel=1e-9)
    assert working.lowest_speed == pytest.approx(radius * speed * math.cos(half), rel=1e-9)
    assert working.mean_speed == pytest.approx(length * speed / (2 * half), rel=1e-9)
    assert approach.travel == pytest.approx(radius - length / 2, rel=1e-9)
    assert approach.height == pytest.approx(2 * radius, rel=1e-9)
    assert run_out.turned == pytest.approx(math.pi / 2 - half, rel=1e-9)
    assert back.turned == pytest.approx(math.pi, rel=1e-9)
    assert (approach.lowest_speed, run_out.lowest_speed, back.lowest_speed, back.height) == (0.0, 0.0, 0.0, pytest.approx(0.0, abs=1e-12))


def test_phases_of_chen_2002(motion):
    """Dead centres at -17.973 and 197.973 deg; the 120 mm begin as fast as they end, on both sides of the peak of speed at 87.60 deg."""
    approach, working, run_out, back = pp.measures.phases(motion, 0.120)
    ends = np.radians([-17.973159220540943, 197.97315922054094])

    def behind(angle):
        """Where the ram is 120 mm further."""
        return brentq(lambda q: ram(q)[0] - ram(angle)[0] - 0.120, angle, ends[1], xtol=1e-14)

    begin = brentq(lambda q: ram(q)[1] - ram(behind(q))[1], 0.6, 1.5, xtol=1e-14)
    assert approach.crank_angle == pytest.approx(ends[0] + 2 * np.pi, abs=1e-8)
    assert working.crank_angle == pytest.approx(begin, abs=1e-8)
    assert run_out.crank_angle == pytest.approx(behind(begin), abs=1e-8)
    assert back.crank_angle == pytest.approx(ends[1], abs=1e-8)
    assert working.highest_speed == pytest.approx(1.152606, abs=1e-6)
    assert working.lowest_speed == pytest.approx(ram(begin)[1], rel=1e-8)
    assert 1 - working.lowest_speed / working.highest_speed == pytest.approx(measures.speed_variation(motion, 0.120), rel=1e-12)
    assert back.highest_speed == pytest.approx(2.181, abs=5e-4)
    assert (approach.turned + working.turned + run_out.turned) / back.turned == pytest.approx(1.49907, abs=5e-6)


@pytest.mark.parametrize("downwards", [True, False])
@pytest.mark.parametrize("start", [0.0, 2.0, -4.0])
def test_phases_fill_the_turn(downwards, start):
    motion = turn(crank_slide(offset=0.03), 360, -5.0, start)
    parts = pp.measures.phases(motion, 0.07, downwards=downwards)
    assert [part.phase for part in parts] == ["approach", "working", "run-out", "return"]
    assert sum(part.turned for part in parts) == pytest.approx(2 * np.pi, rel=1e-12)
    assert sum(part.duration for part in parts) == pytest.approx(2 * np.pi / 5.0, rel=1e-12)
    assert sum(part.travel for part in parts[:3]) == pytest.approx(measures.stroke(motion), rel=1e-12)
    assert parts[3].travel == pytest.approx(measures.stroke(motion), rel=1e-12)
    for part, after in zip(parts, parts[1:] + parts[:1], strict=True):
        assert (part.crank_angle - part.turned - after.crank_angle + 1) % (2 * np.pi) == pytest.approx(1.0, abs=1e-9)
        down = downwards is (part.phase != "return")
        assert after.height == pytest.approx(part.height - part.travel * (1 if down else -1), abs=1e-12)


@pytest.mark.exhaustive
def test_the_longest_even_part(thin_wall):
    """It has its variation; of a sine its half angle has cos = 0.8, sin = 0.6; and the complex step differentiates it."""
    motion = pp.cycle(thin_wall, SPEED, points=120)
    for variation in (1e-4, 0.05, 0.99):
        assert measures.speed_variation(motion, measures.even_length(motion, variation)) == pytest.approx(variation, rel=1e-9)
    assert measures.even_length(turn(scotch_yoke(0.1), 360, 3.0, 0.0), 0.2) == pytest.approx(0.2 * 0.6, rel=1e-9)

    def length(offset):
        return measures.even_length(turn(crank_slide(offset=offset), 90, SPEED, 0.0), 0.1)

    quotient = (length(0.02 + 1e-5) - length(0.02 - 1e-5)) / 2e-5
    assert length(0.02 + 1e-30j).imag / 1e-30 == pytest.approx(quotient, rel=1e-6)
    assert length(0.02 + 1e-30j).real == pytest.approx(length(0.02), rel=1e-12)


def test_pressure_angles_of_chen_2002(thin_wall, motion):
    """(18): |h - l3 sin theta3| / l4 is the sine of the angle between coupler and guide; the block pushes the bar squarely."""
    curves = pp.measures.transmission_angle_curves(thin_wall, motion)
    angle = motion.crank_angle
    s3 = np.sqrt(L6**2 + L1**2 + 2 * L1 * L6 * np.sin(angle))
    sine = np.abs(H - L3 * np.sqrt(1 - (L1 * np.cos(angle) / s3) ** 2)) / L4
    np.testing.assert_allclose(curves.pressure_angle["E"], np.arcsin(sine), atol=1e-9)
    np.testing.assert_allclose(curves.pressure_angle["slot"], 0.0, atol=1e-7)
    assert math.degrees(curves.pressure_angle["E"].max()) == pytest.approx(math.degrees(math.asin(18 / 220)), abs=1e-6)
    assert list(curves.columns()) == ["crank_angle [rad]", "transmission_angle_slot [rad]", "transmission_angle_E [rad]"]


@pytest.mark.parametrize("name", ["zxn2_3000b", "crank_slide"])
def test_least_angles_are_those_of_the_curves(name):
    press = texts.shipped(name)
    curves = pp.measures.transmission_angle_curves(press, pp.cycle(press, 1.0, points=3600))
    for dyad in pp.measures.least_transmission_angles(press):
        assert curves.transmission_angle[dyad.bearing].min() == pytest.approx(dyad.least_transmission_angle, abs=1e-5)
