"""The machines of chapter 1 of Zhang 2007 that are shipped: against closed forms of their motion and forces, and by two engines."""

from pathlib import Path

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.balancing import classical

W = 300 * pp.RPM
MACHINES = ("underdrive", "eccentric_blocks", "aida_balance_slide", "pirica_double_knuckle")
URDF = Path(__file__).resolve().parents[2] / "urdf"


def vertical_orders(press, orders, points=96):
    """Complex amplitudes of the vertical shaking force [N]."""
    force = pp.inverse_dynamics(press, pp.cycle(press, W, points=points), bearings=()).shaking_force[:, 2]
    return (2 * np.fft.rfft(force) / points)[list(orders)]


def meeting(first, second, one, other, side):
    """The point at two distances from two points, to the left (1) or right (-1) of the way from the first to the second; complex [m]."""
    way = second - first
    along = (one**2 - other**2 + abs(way) ** 2) / (2 * abs(way))
    return first + (along + side * 1j * np.sqrt(one**2 - along**2)) * way / abs(way)


@pytest.mark.parametrize("name", MACHINES)
def test_stroke_and_engines(name):
    press = texts.shipped(name)
    motion = pp.cycle(press, W, points=24)
    assert pp.measures.stroke(motion) == pytest.approx(0.03, abs=1e-6)
    plane, pinocchio = (pp.inverse_dynamics(press, motion, engine=engine) for engine in ("plane", "pinocchio"))
    largest = max(np.abs(force).max() for force in plane.bearing_force.values())
    for field in ("shaking_force", "shaking_moment", "driving_torque"):
        np.testing.assert_allclose(getattr(plane, field), getattr(pinocchio, field), rtol=0, atol=1e-11 * largest)
    assert np.abs(plane.power_residual).max() < 1e-12


def test_underdrive_shakes_with_its_columns():
    """The crank-slider of the JF75G-125 with 3170 kg: m_C r w^2 A_k, and the crank's and the rod's rotating masses in the first order."""
    orders = vertical_orders(texts.shipped("underdrive"), (1, 2, 4))
    coefficients = classical.harmonic_coefficients(0.05, 4)
    reciprocating, rotating = 3170 + 77.49 / 2, 52.25 + 77.49 / 2
    expected = -0.015 * W**2 * (reciprocating * coefficients[[1, 2, 4]] + rotating * np.array([1, 0, 0]))
    np.testing.assert_allclose(orders, expected, rtol=0, atol=1e-9 * abs(expected[0]))


def test_the_lever_of_the_balance_slide_by_hand():
    """Slide and balance slide from circles that meet, and what the fulcrum does to the stroke."""
    q = np.linspace(0.0, 2 * np.pi, 36, endpoint=False)
    for f in (0.2, 0.24):
        press = pp.build(URDF / "aida_balance_slide.yaml", f=1e3 * f)
        motion = pp.servo_cycle(press, angle=q, speed=W)
        pin = -0.4 + 0.015 * 1j * np.exp(1j * q)
        guide = -0.4 + 1j * (pin.imag - np.sqrt(0.3**2 - (pin.real + 0.4) ** 2))
        fulcrum = -0.4 + f - 0.6j
        lever_in = meeting(guide, fulcrum, 0.3, f, -1)
        lever_out = fulcrum + (fulcrum - lever_in) * (0.4 - f) / f
        slide = lever_out.imag - np.sqrt(0.3**2 - lever_out.real**2)
        np.testing.assert_allclose(motion.slide_position, slide, rtol=0, atol=1e-13)
        assert np.ptp(slide) == pytest.approx(0.03 * (0.4 - f) / f, rel=1e-6)
        rocker = meeting(guide, -0.6 + 0.4j, 0.7, 0.2, -1)
        high = -0.6 + 0.4j + 3 * (rocker + 0.6 - 0.4j)
        balance = high.imag + np.sqrt(0.3**2 - high.real**2)
        joint = press.joints.index("balance_slide_guide")
        np.testing.assert_allclose(motion.joint_position[:, joint], balance - balance[0], rtol=0, atol=1e-13)


def test_the_knees_by_hand():
    q = np.linspace(0.0, 2 * np.pi, 36, endpoint=False)
    press = texts.shipped("pirica_double_knuckle")
    motion = pp.servo_cycle(press, angle=q, speed=W)
    pin = 0.014679 * 1j * np.exp(1j * q)
    guide = 1j * (pin.imag + np.sqrt(0.3**2 - pin.real**2))
    pivot = -0.35 + 0.1j
    inner = meeting(guide, pivot, 0.25, 0.2, 1)
    knee = pivot + 1.5 * (inner - pivot) * np.exp(-1j * np.radians(110))
    slide = knee.imag - np.sqrt(0.3**2 - (knee.real + 0.35) ** 2)
    np.testing.assert_allclose(motion.slide_position, slide, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("name", "set_to", "stays"),
    [
        ("aida_balance_slide", {"f": 240}, False),
        ("pirica_double_knuckle", {"r": 14.679 * 2 / 3}, True),
        ("eccentric_blocks", {"r": 10}, False),
    ],
)
def test_balance_at_another_stroke(name, set_to, stays):
    """The first order is balanced at 30 mm; at 20 mm it stays so where one crank moves slide and weights."""
    plain, least = abs(vertical_orders(texts.shipped("jf75g_125_plain"), (1,))[0]), 1e-6
    assert abs(vertical_orders(texts.shipped(name), (1,))[0]) < least * plain
    other = pp.build(URDF / f"{name}.yaml", **set_to)
    assert pp.measures.stroke(pp.cycle(other, W, points=96)) == pytest.approx(0.02, rel=5e-3)
    left = abs(vertical_orders(other, (1,))[0]) / (plain * 2 / 3)
    assert left < 2e-3 if stays else left > 0.4


def test_the_blocks_leave_the_even_orders():
    """Zhang 2007, Fig. 1-2, as inferred: what is left is m_C r w^2 A_k; nothing across, no moment."""
    press = texts.shipped("eccentric_blocks")
    orders = vertical_orders(press, (2, 4))
    coefficients = classical.harmonic_coefficients(0.05, 4)
    np.testing.assert_allclose(orders, -0.015 * W**2 * (2200 + 77.49 / 2) * coefficients[[2, 4]], rtol=0, atol=1e-6)
    result = pp.inverse_dynamics(press, pp.cycle(press, W, points=36))
    largest = max(np.abs(force).max() for force in result.bearing_force.values())
    assert np.abs(result.shaking_force[:, 0]).max() < 1e-12 * largest
    assert np.abs(result.shaking_moment[:, 1]).max() < 1e-12 * largest
