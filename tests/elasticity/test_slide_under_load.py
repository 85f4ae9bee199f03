"""Deflection of the slide in motion, and bottom dead centre over speed, by hand and by brute force."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from support import texts
from support.generators.period_presses import five_bar, of_two_motors

import pinpress as pp
from pinpress.balancing.classical import as_crank_slider
from pinpress.elasticity.slide_under_load import dead_centre_shift, slide_deflection
from pinpress.elasticity.springs import Rod, Stiffness
from pinpress.elasticity.unit_load import compliance


def stiffness_of(press):
    bearings = {name: 1.5e9 + 2e8 * i for i, name in enumerate(press.bearings) if "guide" not in name}
    return Stiffness(bearings, shaft=2e7, frame=3e9)


def test_crank_slide_at_bottom_dead_centre_by_hand():
    """All forces stand upright there: each pin carries the weight and inertia of what hangs on it, the rod the mean of its ends."""
    press = texts.shipped("crank_slide")
    parts = as_crank_slider(press)
    r, length, g = parts.crank_radius, parts.rod_length, 9.81
    found = dead_centre_shift(
        press, Stiffness({"W": 1e9, "P": 2e9, "O": 4e9}, {}, [Rod("rod", ("P", "W"), 5e8)], frame=8e9), speed=[0.0, 20.0]
    )

    def by_hand(weight, squared):
        slide = parts.slide_mass * (weight * g + squared * r * (1 + r / length))
        rod_acceleration = squared * r * (1 + r / length * parts.rod_centre.real / length)
        rod = slide + parts.rod_mass * (weight * g + rod_acceleration)
        crank = rod + parts.crank_mass * (weight * g + squared * parts.crank_centre.real)
        return -(slide / 1e9 + rod / 2e9 + crank / 4e9 + crank / 8e9 + 0.5 * (slide + rod) / 5e8)

    assert found.constant == pytest.approx(by_hand(1, 0), rel=1e-9)
    assert found.by_squared_speed == pytest.approx(by_hand(0, 1), rel=1e-9)
    np.testing.assert_allclose(found.at_rigid_angle, [by_hand(1, 0), by_hand(1, 400.0)], rtol=1e-9)


@pytest.mark.parametrize(("name", "speed"), [("zxn2_3000b", 7.3), ("jf75g_125", 42.0), ("jf75g_125_two_point", 60.0), ("thin_wall", 9.0)])
def test_bottom_dead_centre_by_brute_force(name, speed):
    press = texts.shipped(name)
    stiffness = stiffness_of(press)
    found = dead_centre_shift(press, stiffness, speed=[0.5 * speed, speed])

    def position(angle, w):
        return slide_deflection(press, pp.servo_cycle(press, speed=w, angle=np.atleast_1d(angle)), stiffness).slide_position

    for w, angle, lowest in zip(found.speed, found.crank_angle, found.position, strict=True):
        around = found.rigid_angle + np.linspace(-0.1, 0.1, 401)
        best = around[position(around, w).argmin()]
        result = minimize_scalar(
            lambda x, w=w: float(position(x, w)[0]), bounds=(best - 1e-3, best + 1e-3), method="bounded", options={"xatol": 1e-9}
        )
        assert lowest == pytest.approx(result.fun, abs=1e-14)
        assert angle == pytest.approx(result.x, abs=2e-6)
    assert found.rigid_position == pytest.approx(pp.servo_cycle(press, speed=1.0, angle=[found.rigid_angle]).slide_position[0], abs=1e-15)
    assert found.rigid_position <= pp.cycle(press, 1.0, points=3600).slide_position.min()
    still = dead_centre_shift(press, stiffness, speed=0.0)
    resting = position(found.rigid_angle + np.linspace(-1e-2, 1e-2, 2001), 0.0).min()
    assert found.standstill_position == pytest.approx(resting, abs=1e-11)
    assert still.position[0] == still.standstill_position == found.standstill_position
    assert found.standstill_position == pytest.approx(found.rigid_position + found.constant, abs=1e-3 * abs(found.constant))
    assert still.shift[0] == 0.0
    assert np.all(found.shift < 0.0)
    assert found.shift[1] == pytest.approx(found.by_squared_speed * speed**2, rel=5e-3)  # the crank angle moves little


def test_affine_in_the_squared_speed():
    press = texts.shipped("zxn2_3000b")
    stiffness, angles = stiffness_of(press), np.linspace(0.0, 6.0, 7)
    at = [slide_deflection(press, pp.servo_cycle(press, speed=w, angle=angles), stiffness).deflection for w in (0.0, 3.0, 8.0)]
    np.testing.assert_allclose((at[1] - at[0]) / 9, (at[2] - at[0]) / 64, rtol=1e-9, atol=1e-16)


def test_process_force_deflects_by_the_compliance():
    """Of a press without weight that turns slowly; without a load nothing of it yields."""
    press = texts.shipped("jf75g_125", gravity=(0.0, 0.0, 0.0))
    stiffness, motion = stiffness_of(press), pp.cycle(press, 1e-3, points=72)
    load = pp.loads.Blanking(1.25e6, 0.010, 0.005)
    found = slide_deflection(press, motion, stiffness, loads=[load])
    height = motion.slide_position - pp.dead_centres(press).bottom_position
    working = (motion.slide_velocity < 0) & (height > 0.005) & (height <= 0.010)
    force = np.where(working, 1.25e6 * np.sin(np.pi / 2 * (0.010 - height) / 0.005), 0.0)
    np.testing.assert_allclose(
        found.deflection, force * compliance(press, stiffness, angle=motion.crank_angle).compliance, rtol=1e-9, atol=1e-9
    )
    assert working.sum() > 3
    np.testing.assert_allclose(found.slide_position, motion.slide_position + found.deflection, rtol=0, atol=0)


def test_weight_balanced_by_a_constant_force():
    press = texts.shipped("crank_slide", gravity=(0.0, 0.0, -9.81))
    slide = press.model.inertias[press.model.getJointId("slide_guide")].mass
    stiffness = Stiffness({"W": 1e9})
    balanced = dead_centre_shift(press, stiffness, speed=15.0, loads=[pp.loads.PointForce("slide", (0.0, 0.0, slide * 9.81))])
    plain = dead_centre_shift(press, stiffness, speed=15.0)
    assert balanced.constant == pytest.approx(0.0, abs=1e-12 * abs(plain.by_squared_speed) + 1e-18)
    assert plain.constant == pytest.approx(-slide * 9.81 / 1e9, rel=1e-9)
    assert balanced.by_squared_speed == pytest.approx(plain.by_squared_speed, rel=1e-9)


def test_two_motors_hold_as_gears_do() -> None:
    """The geared five-bar is computed in the plane, with one driver held; without its gears two drivers are held, in space."""
    ratio, speed = 0.5, 4.0
    geared, press = five_bar(ratio), of_two_motors()
    turn = pp.cycle(geared, speed, points=48)
    motion = pp.servo_cycle(press, np.outer(turn.crank_angle, [1.0, ratio]), speed=[[speed, ratio * speed]] * 48, acceleration=0.0)
    stiffness = Stiffness(bearings={"O": 1e8, "A": 2e8, "C": 3e8, "S": 1e8}, moments={"guide": 1e7}, rods=[Rod("rod", ("C", "S"), 4e8)])
    loads = [pp.loads.PointForce("slide", (0.0, 0.0, 5e3))]
    want, found = (slide_deflection(*each, stiffness, loads=loads) for each in ((geared, turn), (press, motion)))
    np.testing.assert_allclose(found.deflection, want.deflection, rtol=0, atol=1e-9 * np.abs(want.deflection).max())
    assert list(found.columns())[:2] == ["crank_angle_O [rad]", "crank_angle_P [rad]"]
    with pytest.raises(pp.PinpressError, match="shaft names none of them"):
        slide_deflection(press, motion, Stiffness(shaft=1e6))
    with pytest.raises(pp.PinpressError, match="see slide_deflection of a motion"):
        compliance(press, stiffness)
