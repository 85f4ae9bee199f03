"""ADAMS' IMPACT and BISTOP: their published formulas, runs against SciPy, energy, and contact on springs."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from support import texts
from support.oracles import crank_slide_by_scipy, crank_slide_equation
from support.texts import shipped

import pinpress as pp
from pinpress.loads import Impact, TwoSidedStop, step

K, E, C, D = 4e7, 1.5, 3e4, 2e-3
SIX = "zxn2_3000b"


def impact(x, rate, x1, k, e, cmax, d):
    """IMPACT as ADAMS prints it."""
    return max(0.0, k * (x1 - x) ** e - float(step(x, x1 - d, cmax, x1, 0.0)) * rate) if x < x1 else 0.0


def bistop(x, rate, x1, x2, k, e, cmax, d):
    """BISTOP as ADAMS prints it."""
    if x <= x2:
        return impact(x, rate, x1, k, e, cmax, d)
    return min(0.0, -k * (x - x2) ** e - float(step(x, x2, 0.0, x2 + d, cmax)) * rate)


def force_of(load, height, velocity):
    """Force of a load by its intervals, with the height and velocity of one state."""
    found = [each for each in load.intervals(velocity < 0) if each.lower < height <= each.upper]
    assert len(found) <= 1
    return float(found[0].acting(found[0].force(height, velocity))) if found else 0.0


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.2])
@pytest.mark.parametrize("damping", [0.0, C])
def test_forces_are_those_of_adams(exponent, damping):
    stop = Impact(0.010, K, exponent, damping, D)
    pair = TwoSidedStop(0.010, 0.020, K, exponent, damping, D)
    heights = [0.0, 0.006, 0.008, 0.0085, 0.0099, 0.010, 0.0101, 0.015, 0.0199, 0.0201, 0.021, 0.022, 0.025]
    for rate in (-0.7, -1e-3, 1e-3, 0.7):
        mine = [force_of(stop, h, rate) for h in heights]
        assert mine == pytest.approx([impact(h, rate, 0.010, K, exponent, damping, D) for h in heights], rel=1e-12, abs=1e-9)
        mine = [force_of(pair, h, rate) for h in heights]
        assert mine == pytest.approx([bistop(h, rate, 0.010, 0.020, K, exponent, damping, D) for h in heights], rel=1e-12, abs=1e-9)
        for load in (stop, pair):  # arrays give what numbers give
            for each in load.intervals(True):
                inside = np.clip(np.linspace(0.0, 0.03, 31), max(each.lower, -1.0), min(each.upper, 1.0))
                assert each.force(inside, rate + 0 * inside) == pytest.approx([each.force(float(h), rate) for h in inside], rel=1e-13)


@pytest.mark.parametrize(
    ("load", "law"),
    [
        (Impact(0.05, 2e6, 1.5, 2e4, 0.005), lambda x, v: impact(x, v, 0.05, 2e6, 1.5, 2e4, 0.005)),
        (TwoSidedStop(0.05, 0.08, 2e7, 1.5, 2e4, 0.005), lambda x, v: bistop(x, v, 0.05, 0.08, 2e7, 1.5, 2e4, 0.005)),
    ],
)
def test_runs_are_those_of_the_printed_functions(load, law, method):
    """It bounces on the lower stop, and on the upper one; where damper and spring cancel on the way out the contact is lost."""
    press = shipped("crank_slide")
    given = {"speed": -6.0, "angle": 1.2, "flywheel": pp.drives.Flywheel(20.0), "loads": [load], "method": method, "points": 41}
    run = pp.simulate(press, 0.4, **given)
    expected = crank_slide_by_scipy.run(law, 1.2, -6.0, 20.0, run.time)
    heights = run.slide_position - pp.dead_centres(press).bottom_position
    assert heights.min() < 0.045  # met, below the depth of the damper
    assert run.crank_angle == pytest.approx(expected[0], abs=2e-7)  # SciPy does not stop at the kinks
    assert run.crank_speed == pytest.approx(expected[1], abs=2e-5)
    assert run.stats.energy_error < 1e-8
    if isinstance(load, TwoSidedStop):
        assert heights.max() > 0.082


@pytest.mark.exhaustive
@pytest.mark.parametrize("method", ["reduced", "implicit", "constraint"])
def test_a_stop_pushes_again_over_the_last_depth(method):
    """On the way out damper and spring cancel. The damper grows with the square of the depth, the spring with its power of 1.5: below 30 um
    it pushes again, which steps over time passed over."""
    press = texts.shipped("jf75g_125", gravity=(0, 0, -9.80665))
    k, c, depth, touching = 3e8, 4e4, 1e-3, 0.006
    given = {"speed": 20.0, "angle": 0.6, "flywheel": pp.drives.Flywheel(30.0), "method": method, "points": 7}
    run = pp.simulate(press, 0.03, loads=[Impact(touching, k, 1.5, c, depth)], **given)

    def rates(t, y):
        at = crank_slide_equation.coefficients(y[0])
        force = impact(at.height, at.lever * y[1], touching, k, 1.5, c, depth)
        return [y[1], (force * at.lever - 0.5 * at.slope * y[1] ** 2 - at.weight) / (at.inertia + 30.0)]

    # steps so short that the kinks at which SciPy does not stop cost nothing
    expected = solve_ivp(rates, (0.0, 0.03), [0.6, 20.0], "DOP853", t_eval=run.time, rtol=1e-12, atol=1e-13, max_step=2e-5).y
    assert impact(touching - 1e-4, 0.6, touching, k, 1.5, c, depth) == 0.0 < impact(touching - 1e-5, 0.6, touching, k, 1.5, c, depth)
    np.testing.assert_allclose(run.crank_angle, expected[0], rtol=0, atol=1e-9)


def test_work_lost_is_that_of_the_damper():
    """At the motion that the run has: quadrature of the damper's power alone; the spring gives its work back."""
    press = shipped(SIX)
    stop = Impact(0.02, 5e7, 1.5, 2e5, 0.003)
    given = {"flywheel": pp.drives.Flywheel(2e4), "speed": 7.0, "angle": 4.0}
    run = pp.simulate(press, 0.8, loads=[stop], points=8001, **given)
    height = run.slide_position - pp.dead_centres(press).bottom_position
    assert height[0] > 0.02 < height[-1]
    assert height.min() < 0.0005
    growing = np.asarray(step(height, 0.017, 2e5, 0.02, 0.0)) * (height < 0.02)
    pushed = np.maximum(5e7 * np.maximum(0.02 - height, 0.0) ** 1.5 - growing * run.slide_velocity, 0.0) > 0
    assert pushed.any()
    spring = np.trapezoid(np.where(pushed, 0.0, 5e7 * np.maximum(0.02 - height, 0.0) ** 1.5) * run.slide_velocity, run.time)
    damper = np.trapezoid(np.where(pushed, growing * run.slide_velocity**2, 0.0), run.time)
    assert run.load_work[-1] == pytest.approx(damper + spring, rel=1e-5)  # trapezium rule, with kinks


def test_spring_gives_its_energy_back():
    """k d^(e + 1)/(e + 1) goes in down to bottom dead centre, at constant speed, and comes back."""
    press, stop = shipped("jf75g_125"), Impact(0.004, 1e9, 1.5)
    motion = pp.cycle(press, 300 * pp.RPM, points=4096)
    work = np.cumsum(pp.inverse_dynamics(press, motion, loads=[stop]).driving_torque - pp.inverse_dynamics(press, motion).driving_torque)
    work *= 2 * np.pi / 4096
    stored = quad(lambda d: 1e9 * d**1.5, 0.0, 0.004)[0]
    assert np.ptp(work) == pytest.approx(stored, rel=1e-4)
    assert work[-1] == pytest.approx(0.0, abs=1e-6 * stored)  # the mean over a turn
    assert stored == pytest.approx(1e9 * 0.004**2.5 / 2.5, rel=1e-8)


@pytest.mark.exhaustive
def test_order_is_kept_in_a_tolerance():
    """Tighter tolerances come nearer, although the stop's force has a kink of power 1.5 and the contact is lost on the way out."""
    press = shipped("crank_slide")
    given = {"speed": -6.0, "angle": 1.4, "flywheel": pp.drives.Flywheel(20.0), "loads": [Impact(0.05, 2e6, 1.5, 2e4, 0.005)], "points": 2}
    ends = [pp.simulate(press, 0.6, tolerance=tolerance, **given).crank_angle[-1] for tolerance in (1e-4, 1e-6, 1e-8, 1e-11)]
    errors = np.abs(np.array(ends[:-1]) - ends[-1])
    assert np.all(errors < [1e-3, 1e-5, 1e-7])


def on_springs(press, stiffness, turning):
    return pp.elasticity.Stiffness(dict.fromkeys(press.bearings, stiffness), {"slide_guide": turning})


@pytest.mark.exhaustive
def test_contact_on_stiffer_springs_tends_to_that_of_the_rigid_press():
    """The work that its damper takes: the error falls in proportion to the compliance of the springs."""
    press, speed = shipped("crank_slide"), 2.0
    stop, held = Impact(0.02, 3e6, 1.5, 6e3, 0.004), pp.drives.PrescribedSpeed(speed)
    rigid = pp.simulate(press, np.pi, speed=speed, drive=held, loads=[stop], points=5).load_work[-1]
    errors = []
    for k in (2e8, 8e8):
        springs = pp.elasticity.Elastic(pp.elasticity.Stiffness(dict.fromkeys(press.bearings, k), {"slide_guide": k}), damping_ratio=0.2)
        run = pp.steady_state(press, speed, drive=held, loads=[stop], elastic=springs, points=5, tolerance=1e-6)
        errors.append(abs(run.load_work[-1] - rigid))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.exhaustive
def test_contact_lost_on_springs_stays_lost_through_the_depth_of_the_damper():
    """A strong damper lets go while the slide is below its full depth; the slide then rises through it. Work by the printed function."""
    press, speed, stop = shipped("crank_slide"), 4.0, Impact(0.02, 1e6, 1.5, 2e5, 0.004)
    springs = pp.elasticity.Elastic(on_springs(press, 3e7, 1e7), damping_ratio=0.1)
    held = pp.drives.PrescribedSpeed(speed)
    run = pp.simulate(press, 1.6, speed=speed, angle=np.pi, drive=held, loads=[stop], elastic=springs, points=4001)
    heights = run.slide_position - pp.dead_centres(press).bottom_position
    forces = np.array([impact(h, v, 0.02, 1e6, 1.5, 2e5, 0.004) for h, v in zip(heights, run.slide_velocity, strict=True)])
    lost = (heights < 0.02) & (forces == 0)
    assert (heights[lost] < 0.016).any()
    assert (heights[lost] > 0.018).any()
    assert run.load_work[-1] == pytest.approx(-np.trapezoid(forces * run.slide_velocity, run.time), rel=1e-5)  # trapezium rule, with kinks


def test_two_sided_stop_stops_an_elastic_press_on_both_sides():
    """Its forces at the true heights of the slide are those of BISTOP."""
    press, speed = shipped("crank_slide"), 2.0
    load = TwoSidedStop(0.01, 0.19, 1e6, 1.5, 2e3, 0.004)
    springs = pp.elasticity.Elastic(
        pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 30000000.0), {"slide_guide": 1e7}), damping_ratio=0.1
    )
    run = pp.steady_state(press, speed, drive=pp.drives.PrescribedSpeed(speed), loads=[load], elastic=springs, points=721)
    zero = pp.dead_centres(press).bottom_position
    heights = run.slide_position - zero
    assert heights.min() < 0.01 < 0.19 < heights.max()
    forces = [bistop(h, v, 0.01, 0.19, 1e6, 1.5, 2e3, 0.004) for h, v in zip(heights, run.slide_velocity, strict=True)]
    taken = -np.trapezoid(np.array(forces) * run.slide_velocity, run.time)
    assert run.load_work[-1] == pytest.approx(taken, abs=0.01 * np.abs(np.cumsum(forces * run.slide_velocity)).max() * run.time[1])


@pytest.mark.exhaustive
def test_scenarios_are_runs_one_by_one():
    press = shipped("jf75g_125")
    stiffness, damping = np.array([1e9, 3e9]), np.array([1e5, 4e5])
    given = {"speed": 30.0, "flywheel": pp.drives.Flywheel(136.0), "points": 5}
    for make in (lambda k, c: Impact(0.01, k, 1.5, c, 0.002), lambda k, c: TwoSidedStop(0.01, 0.025, k, 1.5, c, 0.002)):
        many = pp.simulate_batch(press, 0.3, loads=[make(stiffness, damping)], **given)
        for k in range(2):
            one = pp.simulate(press, 0.3, loads=[make(float(stiffness[k]), float(damping[k]))], **given)
            assert many[k].crank_angle == pytest.approx(one.crank_angle, abs=1e-9)


@pytest.mark.parametrize(
    "load", [Impact(0.01, K, 1.5, C, D), TwoSidedStop(-0.1, 0.01, K, 2.2, C, D), pp.loads.BalanceCylinder(0.1, 6e5, 0.001)]
)
def test_slopes_by_complex_numbers_are_central_differences(load):
    """As `derivatives` asks the laws."""
    for each in load.intervals(True):
        middle = 0.5 * (max(each.lower, -0.105) + min(each.upper, 0.03))
        for a, b in ((1.0, 0.0), (0.0, 1.0)):
            h, v, e = np.array([middle]), np.array([-0.2]), 1e-6
            exact = np.imag(each.force(h + 1e-20j * a, v + 1e-20j * b)) / 1e-20
            central = (each.force(h + e * a, v + e * b) - each.force(h - e * a, v - e * b)) / (2 * e)
            assert exact == pytest.approx(central, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("preload", [0.0, 2e5])
def test_a_mass_is_picked_up_as_scipy_says(preload):
    """The mass stands until the spring beats its preload; the largest force of the spring while it is pressed."""
    mass, speed, stiffness = 800.0, 0.4, 3e8

    def rates(time, y):
        force = stiffness * (speed * time - y[0])
        return [y[1], max(force - preload, 0.0) / mass if y[1] <= 0 else (force - preload) / mass]

    start, swing = preload / (stiffness * speed), np.pi * np.sqrt(mass / stiffness)
    times = np.linspace(0.0, start + swing, 4001)
    place = solve_ivp(rates, (0.0, times[-1]), [0.0, 0.0], t_eval=times, rtol=1e-9, atol=1e-13, max_step=swing / 400).y[0]
    largest = float((stiffness * (speed * times - place)).max())
    assert pp.loads.pick_up_force(mass, -speed, stiffness, preload=preload) == pytest.approx(largest, rel=1e-4)


def test_a_contact_that_would_pull_is_lost_on_either_side():
    stop = TwoSidedStop(lower=-0.1, upper=0.1, stiffness=1e6)
    for interval in stop.intervals(True):
        for law in (-2.0, 2.0):
            assert interval.pushes(law) == (interval.acting(law) != 0.0) == (law * interval.sense > 0)
    assert {interval.sense for interval in stop.intervals(True)} == {1, -1}


@pytest.mark.exhaustive
@pytest.mark.parametrize("stiffness", [1e6, pytest.param(1e8, marks=pytest.mark.exhaustive), 1e9])
def test_hard_stops_are_met_where_they_are_touched(stiffness):
    """There the force is zero, and rounding told whether the stop pushes: runs over time went on through it, up to 0.02 rad astray."""
    press = shipped("crank_slide")
    stop = TwoSidedStop(0.0005, 0.05, stiffness, 1.5, 1e-3 * stiffness, 1e-4)
    given = {"speed": 7.0, "flywheel": pp.drives.Flywheel(5.0), "loads": [stop]}
    ends = [pp.simulate(press, 1.5, **given, method=method).crank_angle[-1] for method in ("reduced", "implicit", "constraint")]
    assert ends == pytest.approx([ends[0]] * 3, abs=2e-7)


@pytest.mark.exhaustive
def test_a_law_may_fail_where_an_integrator_looks_ahead(method):
    """At a hard stop first trials of a step go metres beyond it, where a cylinder has no air; the motion stays clear of that."""
    press = shipped("jf75g_125_plain")
    stop = TwoSidedStop(2.14066e-3, 0.0285, 2.513605e11, 1.5, 1.162976e7, 2.14066e-4)
    cylinder = pp.loads.BalanceCylinder(0.0173205, 5e5, 2.266296e-5, height=0.06)
    given = {"speed": 14.90704, "flywheel": pp.drives.Flywheel(10.48383), "drive": pp.drives.ConstantTorque(61.033)}
    run, judge = (pp.simulate(press, 1.2, **given, loads=[cylinder, stop], method=how) for how in (method, "implicit"))
    assert run.crank_angle[-1] == pytest.approx(judge.crank_angle[-1], abs=1e-6)
