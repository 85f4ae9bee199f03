"""Impact dampers and hydraulic cushions: Bernoulli's equation, dissipated work by quadrature, runs against SciPy."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from support.oracles import crank_slide_by_scipy, textbook_crank_slide
from support.texts import shipped

import pinpress as pp
from pinpress.loads import HydraulicCushion, ImpactDamper, orifice_coefficient

SPEED = 10.0
DAMPER = ImpactDamper([0.0, 0.03, 0.06], [6e4, 3e4, 1e4])
CUSHION = HydraulicCushion(2e4, 0.06, rise=0.002, return_force=3e3)


def throttled(height, velocity):
    """The force of DAMPER by hand."""
    inside = (height > 0.0) & (height <= 0.06) & (velocity < 0)
    return inside * np.interp(height, [0.0, 0.03, 0.06], [6e4, 3e4, 1e4]) * velocity**2


def cushioned(height, velocity):
    if velocity < 0:
        return 2e4 * min(1.0, (0.06 - height) / 0.002) if height <= 0.06 else 0.0
    return 3e3 if height <= 0.06 else 0.0


def test_an_orifice_is_bernoullis():
    """Oil of 870 kg/m3, piston of 100 mm, orifice of 10 mm at 0.1 m/s: 100 times as fast by area, 0.62 of which contracts."""
    speed_of_oil = 0.1 * 100 / 0.62
    force = 870 / 2 * speed_of_oil**2 * math.pi / 4 * 0.1**2
    assert orifice_coefficient(0.1, 0.01) * 0.1**2 == pytest.approx(force, rel=1e-12)
    assert orifice_coefficient(0.1, 0.01, density=435.0, discharge=0.31) == pytest.approx(2 * orifice_coefficient(0.1, 0.01))


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0])
def test_force_of_a_damper(exponent):
    damper = ImpactDamper([0.06, 0.03, 0.0], [1e4, 3e4, 6e4], exponent)
    assert np.asarray(damper.heights).tolist() == [0.0, 0.03, 0.06]
    assert damper.intervals(True) is damper.intervals(False)
    for each in damper.intervals(True):
        heights = np.linspace(each.lower, each.upper, 5)
        for velocity in (-0.7, -1e-3, 0.0, 0.4):
            expected = np.interp(heights, [0.0, 0.03, 0.06], [6e4, 3e4, 1e4]) * max(-velocity, 0.0) ** exponent
            assert each.acting(each.force(heights, velocity + 0 * heights)) == pytest.approx(expected, rel=1e-13)
            assert [float(each.acting(each.force(float(h), velocity))) for h in heights] == pytest.approx(expected, rel=1e-13)
        slope = np.imag(each.force(heights + 0j, -0.3 + 1e-20j * np.ones(5))) / 1e-20
        assert slope == pytest.approx(-exponent * np.interp(heights, [0.0, 0.03, 0.06], [6e4, 3e4, 1e4]) * 0.3 ** (exponent - 1))


def test_dissipated_work_is_the_quadrature_of_its_power():
    """At constant speed, over half a turn down to bottom dead centre; and over the whole turn, as it takes nothing upwards."""
    press = shipped("crank_slide")
    run = pp.simulate(press, 2 * np.pi / SPEED, speed=SPEED, angle=np.pi, drive=pp.drives.PrescribedSpeed(SPEED), loads=[DAMPER], points=9)

    def power(angle):
        height, slope = textbook_crank_slide.height(angle), textbook_crank_slide.lever(angle)
        return -throttled(height, SPEED * slope) * slope

    start, kink = (2 * np.pi - crank_slide_by_scipy.angle_of(height) for height in (0.06, 0.03))
    expected = quad(power, start, kink, epsabs=1e-9)[0] + quad(power, kink, 2 * np.pi, epsabs=1e-9)[0]
    assert run.load_work[-1] == pytest.approx(expected, rel=1e-10)
    assert run.load_work[4] == pytest.approx(expected, rel=1e-10)
    motion = pp.servo_cycle(press, angle=np.linspace(4.0, 7.0, 200), speed=SPEED)
    assert np.abs(pp.inverse_dynamics(press, motion, loads=[DAMPER, CUSHION]).power_residual).max() < 1e-12


@pytest.mark.parametrize(("load", "law"), [(DAMPER, throttled), (CUSHION, cushioned)])
def test_runs_are_those_of_scipy(load, law, method):
    press = shipped("crank_slide")
    given = {"speed": SPEED, "angle": 4.2, "flywheel": pp.drives.Flywheel(40.0), "loads": [load], "method": method, "points": 21}
    run = pp.simulate(press, 0.5, **given)
    expected = crank_slide_by_scipy.run(law, 4.2, SPEED, 40.0, run.time)
    assert run.crank_angle[-1] > 2 * np.pi + 1.3  # through bottom dead centre, and up beyond the cushion
    assert run.crank_angle == pytest.approx(expected[0], abs=3e-6)  # SciPy does not stop where a force jumps
    assert run.crank_speed == pytest.approx(expected[1], abs=1e-4)
    assert run.stats.energy_error < 1e-8


def test_scenarios_are_runs_one_by_one():
    press, sizes = shipped("crank_slide"), np.array([1.0, 2.0])
    given = {"speed": SPEED, "angle": 4.2, "flywheel": pp.drives.Flywheel(40.0), "points": 5}
    for make in (
        lambda k: ImpactDamper([0.0, 0.06], np.multiply.outer([3e4, 1e4], k)),
        lambda k: HydraulicCushion(1e4 * k, 0.06, 0.002, 1e3 * k),
    ):
        many = pp.simulate_batch(press, 0.3, loads=[make(sizes)], **given)
        for k, size in enumerate(sizes.tolist()):
            assert many[k].crank_angle == pytest.approx(pp.simulate(press, 0.3, loads=[make(size)], **given).crank_angle, abs=1e-9)
