"""Peaks under loads that begin or end with a step: the limits at the edges, from closed forms, whatever states a motion has."""

import warnings

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from support import texts
from support.generators.pin_tables import MASSLESS, crank_slide

import pinpress as pp
from pinpress.dynamics.described import energy_of_stroke
from pinpress.dynamics.extremes import at_peaks, over_time
from pinpress.loads import Blanking, ConstantForce, ForceInterval, ForceStroke

R, L, FORCE, EDGE = 0.075, 0.330, 5e5, 0.007
SPEED = 30 * pp.RPM


def massless(angle=-37.0):
    """A slider crank without masses, drawn at an angle of the crank [deg]."""
    table = crank_slide(1e3 * R, 1e3 * L, masses="none", links=MASSLESS)
    table["pins"]["P"]["angle"] = angle
    return pp.build(**table)


def height(q):
    """Of the slide above its bottom, by the crank's angle from there."""
    return R + L - R * np.cos(q) - np.sqrt(L**2 - (R * np.sin(q)) ** 2)


def lever(q):
    """Derivative of the height by the angle: torque by force."""
    return R * np.sin(q) + R**2 * np.sin(q) * np.cos(q) / np.sqrt(L**2 - (R * np.sin(q)) ** 2)


def before_bottom(h):
    """Angle at which the slide is at a height."""
    return brentq(lambda q: height(q) - h, 1e-9, 1.5, xtol=1e-15)


def extremes(press, loads, points=None, speed=SPEED, **more):
    found = pp.measures.extremes(pp.inverse_dynamics(press, pp.cycle(press, speed, points=points), loads, **more))
    return {value.quantity: value for value in found}


def largest(value):
    return max(abs(value.smallest), abs(value.largest))


@pytest.mark.parametrize("speed", [SPEED, -SPEED])
@pytest.mark.parametrize("points", [90, 181, 720])
@pytest.mark.parametrize("angle", [-37.0, 12.3])
def test_a_step_is_met_at_its_edge(angle, points, speed):
    found = extremes(massless(angle), [ForceStroke([0.0, EDGE], [FORCE, FORCE])], points, speed)
    assert largest(found["driving torque"]) == pytest.approx(FORCE * lever(before_bottom(EDGE)), rel=2e-8)
    assert found["force in slide_guide, magnitude"].largest == pytest.approx(
        FORCE * np.tan(np.arcsin(R / L * np.sin(before_bottom(EDGE)))), rel=1e-7
    )
    # the force acts until the bottom, where it is let go: the rod is then upright
    assert found["force in W, magnitude"].largest == pytest.approx(
        FORCE / np.sqrt(1 - (R / L * np.sin(before_bottom(EDGE))) ** 2), rel=1e-7
    )


@pytest.mark.one_in(3)
@pytest.mark.parametrize("points", [60, 180, 721])
def test_a_load_shorter_than_a_step_has_its_peak(points):
    """A quarter sine over 0.4 mm, whose torque is largest a little above its end: less than one of 60 steps, in which no state is."""
    end = 0.0066
    q = np.linspace(before_bottom(end), before_bottom(EDGE), 400001)
    expected = np.max(FORCE * np.sin(np.pi / 2 * (EDGE - height(q)) / (EDGE - end)) * lever(q))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pp.PinpressWarning)  # of the states, in none of which the load acts
        found = extremes(massless(), [Blanking(FORCE, EDGE, end)], points)
    assert largest(found["driving torque"]) == pytest.approx(expected, rel=1e-7)


def test_the_reference_press_has_the_printed_peaks():
    """crank_slide under 1e5 N below 30 mm, with its masses: by an independent script, 7661.8265425857 N m at 318.9603436797 deg."""
    press = texts.shipped("crank_slide")
    found = [extremes(press, [ConstantForce(1e5, 0.03)], points, 10.0)["driving torque"] for points in (180, 360, 3600)]
    for value in found:
        assert value.largest == pytest.approx(max(each.largest for each in found), rel=2e-9)
        assert value.largest_at == pytest.approx(318.9603436797, abs=1e-6)


def test_smooth_peaks_do_not_depend_on_the_states():
    press = texts.shipped("zxn2_3000b")
    loads = [pp.loads.DeepDrawing(1.5e6, 0.04)]
    coarse, fine = (extremes(press, loads, points, 70 * pp.RPM) for points in (360, 2160))
    for name, value in fine.items():
        size = largest(value)
        assert abs(coarse[name].largest - value.largest) < 1e-9 * size, name
        if not name.endswith("magnitude"):  # which is not smooth near zero
            assert abs(coarse[name].smallest - value.smallest) < 1e-9 * size, name


class TwoSteps:
    """A load of a caller's own with two steps on the way down and one on the way up."""

    datum = None

    def intervals(self, downwards):
        def law(force):
            return lambda height, velocity: force + 0.0 * height

        if downwards:
            return ForceInterval(0.012, EDGE, law(1e5)), ForceInterval(EDGE, 0.001, law(FORCE))
        return (ForceInterval(0.020, 0.010, law(-2e5)),)


def test_every_step_of_a_callers_own_load_is_met():
    found = extremes(massless(), [TwoSteps()], 200)["driving torque"]
    low, high = sorted([FORCE * lever(before_bottom(EDGE)), 2e5 * lever(before_bottom(0.020))])
    assert largest(found) == pytest.approx(high, rel=2e-8)
    assert min(found.smallest, found.largest) >= -high
    assert low < high


def test_states_say_what_is_there():
    reactions = pp.inverse_dynamics(massless(), pp.cycle(massless(), SPEED, points=200), [ForceStroke([0.0, EDGE], [FORCE, FORCE])])
    found = at_peaks(reactions)
    remarks = [remark for remark in found.remarks if remark]
    assert remarks == ["where the load begins"] * 2 + ["where the load ends"] * 2
    begins = [k for k, remark in enumerate(found.remarks) if remark == "where the load begins"]
    assert np.diff(found.reactions.motion.crank_angle[begins])[0] < 1e-8
    assert found.reactions.process_force[begins].tolist() == [0.0, FORCE]
    assert over_time(reactions).weight.sum() == pytest.approx(2 * np.pi / SPEED, rel=1e-12)
    assert at_peaks(reactions) is found


@pytest.mark.parametrize("points", [60, 500])
def test_the_largest_deflection_is_at_the_edge(points):
    """A rod with the slope b, of the stiffness k, yields by F / (k cos2 b) along the guide: most at the edge, where b is largest."""
    press, stiff = massless(), 1e9
    springs = pp.elasticity.Stiffness(rods=[pp.elasticity.Rod("rod", ("P", "W"), stiff)])
    found = pp.elasticity.slide_deflection(
        press, pp.cycle(press, SPEED, points=points), springs, loads=[ForceStroke([0.0, EDGE], [FORCE, FORCE])]
    )
    expected = FORCE / (stiff * (1 - (R / L * np.sin(before_bottom(EDGE))) ** 2))
    (section,) = found.described()
    assert {figure.name: figure.value for figure in section.figures}["pushed up by at most"] == pytest.approx(expected, rel=1e-7)
    assert f"{expected:.4g} m" in found.title


@pytest.mark.parametrize("seed", range(6))
def test_no_number_depends_on_the_states(seed):
    """Presses under loads that begin and end with a step, two of three with friction that reverses: 1e-9 is a thousandth of six digits."""
    rng = np.random.default_rng(seed)
    press = texts.shipped(("crank_slide", "zxn2_3000b", "pirica_double_knuckle")[seed % 3])
    speed, (first, second) = float(rng.uniform(2.0, 8.0)) * (-1) ** seed, rng.uniform(2e-3, 1e-2, size=2)
    loads = [ConstantForce(rng.uniform(1e5, 1e6), first), Blanking(rng.uniform(1e5, 1e6), second, second / 2)]
    friction = {name: pp.loads.Friction(0.05, None if "guide" in name else 0.03) for name in press.bearings if seed % 3}
    found, energies, works, titles = [], [], [], set()
    for points in (90, 360, 1441):
        reactions = pp.inverse_dynamics(press, pp.cycle(press, speed, points=points), loads, friction)
        found.append({value.quantity: value for value in pp.measures.extremes(reactions)})
        energies.append(pp.measures.driving_energy(reactions))
        works.append((reactions.process_work, *np.ravel([bars.series["work"] for bars in energy_of_stroke(reactions)[1]])))
        titles.add(reactions.title.partition(" states, ")[2])
    assert len(titles) == 1
    for few, many in zip(works[0], works[-1], strict=True):
        assert few == pytest.approx(many, rel=1e-9, abs=1e-6)
    for name, value in found[-1].items():
        for other in found[:-1]:
            numbers = [(each.smallest, each.largest, each.rms) for each in (other[name], value)]
            np.testing.assert_allclose(*numbers, rtol=0, atol=1e-9 * largest(value) + 1e-9, err_msg=name)
    for name in ("work", "mean_torque", "rms_torque", "largest_torque", "stored", "lowest_at", "highest_at"):
        few, some, many = (getattr(energy, name) for energy in energies)
        assert (few, some) == pytest.approx((many, many), rel=1e-9), name


@pytest.mark.parametrize("points", [100, 400])
def test_rms_of_a_step_is_an_integral(points):
    found = extremes(massless(), [ForceStroke([0.0, EDGE], [FORCE, FORCE])], points)["driving torque"]
    square, _ = quad(lambda q: (FORCE * lever(q)) ** 2, 0, before_bottom(EDGE), epsrel=1e-13)
    assert found.rms == pytest.approx(np.sqrt(square / (2 * np.pi)), rel=1e-9)


def test_friction_and_redundant_bearings_keep_their_steps():
    """With friction in the guide, two steps: the largest torque is the same from coarse and fine states."""
    press = texts.shipped("crank_slide")
    friction = {"slide_guide": pp.loads.Friction(0.1)}
    found = [extremes(press, [ConstantForce(1e5, 0.03)], points, 10.0, friction=friction)["driving torque"] for points in (200, 1800)]
    assert found[0].largest == pytest.approx(found[1].largest, rel=1e-7)
    assert found[0].smallest == pytest.approx(found[1].smallest, rel=1e-7)


def test_a_motion_from_a_table_meets_its_steps():
    """A servo drive at even speed, given as angles over time, meets the edge that cycle meets."""
    press = massless()
    time = np.linspace(0, 2 * np.pi / SPEED, 301)
    motion = pp.servo_cycle(press, SPEED * time, time=time)
    found = pp.measures.extremes(pp.inverse_dynamics(press, motion, [ForceStroke([0.0, EDGE], [FORCE, FORCE])]))
    torque = next(value for value in found if value.quantity == "driving torque")
    assert largest(torque) == pytest.approx(FORCE * lever(before_bottom(EDGE)), rel=1e-7)


def test_a_run_meets_its_steps():
    """With a heavy flywheel and few states the forces are those of even speed: the peak of the bearing at the slide is that of a cycle."""
    press, loads = texts.shipped("crank_slide"), [ConstantForce(1e5, 0.03)]
    run = pp.simulate(press, 0.6, speed=10.0, flywheel=pp.drives.Flywheel(1e4), loads=loads, points=61)
    found = {each.quantity: each for each in pp.measures.extremes(pp.inverse_dynamics(press, run, loads))}
    even = extremes(press, loads, 720, 10.0)
    for name in ("force in slide_guide, magnitude", "force in W, magnitude", "force in P, magnitude"):
        assert found[name].largest == pytest.approx(even[name].largest, rel=1e-3), name


def test_a_force_that_is_noise_is_said():
    press, rng = texts.shipped("crank_slide"), np.random.default_rng(1)
    load = pp.loads.TimeForce(lambda time: 1e3 * rng.standard_normal(np.shape(time)))
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 10.0, points=50), [load])
    with pytest.warns(pp.PinpressWarning, match="largest values and means are those of the given states"):
        assert at_peaks(reactions).reactions is reactions


def test_loads_given_state_by_state_leave_the_states_alone():
    press = texts.shipped("crank_slide")
    motion = pp.cycle(press, 10.0, points=50)
    load = pp.loads.PointForce("slide", np.tile([0.0, 0.0, 1e3], (50, 1)))
    reactions = pp.inverse_dynamics(press, motion, [load])
    assert at_peaks(reactions).reactions is reactions


def test_a_force_at_a_pin_in_the_frame_is_warned_of():
    press = texts.shipped("zxn2_3000b")
    motion = pp.cycle(press, 1.0, points=12)
    load = pp.loads.PointForce("rocker", (-8e3, 0, 0))
    with pytest.warns(pp.PinpressWarning, match=r"load on 'rocker': its point is at pin D, which stands still in the frame"):
        pp.inverse_dynamics(press, motion, [load])
