"""Preloaded joints: both members by equilibrium, closed and open; in the slide's deflection; closed in elastic motion."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq
from support.exploring import examples
from support.texts import shipped

import pinpress as pp
from pinpress.elasticity import Elastic, PreloadedJoint, Rod, Stiffness, compliance, dead_centre_shift, slide_deflection

TIE_RODS = PreloadedJoint(loaded=2e9, relieved=6e9, preload=2.5e6)  # twice the nominal force of 1250 kN
SPEED = 300 * pp.RPM
BEARINGS: dict[str, float | PreloadedJoint] = {"O": 3e9, "P2": 4e9, "P4": 4e9, "slide_guide": 2e9}


def by_hand(joint, load):
    """Elongation at which both members hold the load, each of which only pushes on the other: the root of their equilibrium."""

    def missing(x):
        return max(joint.preload + joint.loaded * x, 0.0) - max(joint.preload - joint.relieved * x, 0.0) - load

    far = 2 * (abs(load) + joint.preload) / min(joint.loaded, joint.relieved)
    return brentq(missing, -far, far, xtol=1e-18, rtol=1e-15)


@examples(60)
@given(
    loaded=st.floats(1e8, 1e10),
    relieved=st.floats(1e8, 1e10),
    preload=st.floats(1e4, 1e7),
    share=st.floats(-4.0, 4.0),
)
def test_elongation_is_that_of_equilibrium(loaded, relieved, preload, share):
    joint = PreloadedJoint(loaded, relieved, preload)
    load = share * preload
    x = float(joint.elongation(load))
    assert x == pytest.approx(by_hand(joint, load), rel=1e-9, abs=1e-15)
    pulled, pressed = joint.forces(load)
    assert pulled - pressed == pytest.approx(load, rel=1e-9, abs=1e-6 * preload)
    assert min(pulled, pressed) >= 0
    assert (pressed == 0) == (load >= joint.opening_load) or abs(load - joint.opening_load) < 1e-9 * preload


def test_marked_loads():
    """Rods a third as stiff as the uprights take a quarter of a load; uprights lift off at P (1 + 1/3)."""
    assert TIE_RODS.stiffness == 8e9
    assert TIE_RODS.opening_load == pytest.approx(2.5e6 * 4 / 3)
    assert TIE_RODS.slack_load == pytest.approx(2.5e6 * 4)
    pulled, pressed = TIE_RODS.forces([0.0, 1.25e6, TIE_RODS.opening_load, 4e6])
    assert pulled == pytest.approx([2.5e6, 2.5e6 + 1.25e6 / 4, TIE_RODS.opening_load, 4e6])
    assert pressed == pytest.approx([2.5e6, 2.5e6 - 0.75 * 1.25e6, 0.0, 0.0], abs=1e-6)
    assert TIE_RODS.elongation(4e6) - TIE_RODS.elongation(3.5e6) == pytest.approx(5e5 / 2e9)
    assert TIE_RODS.elongation([[1e6, -1e6]]).shape == (1, 2)
    assert np.all(np.diff(TIE_RODS.elongation(np.linspace(-2e7, 2e7, 999))) > 0)


@pytest.mark.parametrize("engine", ["jf75g_125_plain", "zxn2_3000b"])
def test_closed_it_is_a_spring(engine):
    press = shipped(engine)
    motion, load = pp.cycle(press, 5.0, points=60), [pp.loads.DeepDrawing(5e5, 0.01)]
    bearings = dict.fromkeys(press.bearings, 4e9)
    gibs = PreloadedJoint(2e9, 2e9, 5e6)
    given = [Stiffness(bearings | {"slide_guide": gibs}, frame=TIE_RODS), Stiffness(bearings, frame=8e9)]
    closed, linear = (slide_deflection(press, motion, each, loads=load).deflection for each in given)
    assert closed == pytest.approx(linear, rel=1e-13, abs=1e-16)
    assert compliance(press, given[0]).compliance == pytest.approx(compliance(press, given[1]).compliance, rel=1e-13)
    assert dead_centre_shift(press, given[0], speed=5.0).shift == pytest.approx(
        dead_centre_shift(press, given[1], speed=5.0).shift, rel=1e-9
    )


def test_uprights_that_lift_off_leave_the_rods_alone():
    """The frame's share of the deflection is the joint's elongation by the pull of the columns, found from the bearing of the crank."""
    press = shipped("jf75g_125_plain")
    motion, load = pp.servo_cycle(press, angle=np.linspace(5.6, 6.2, 61), speed=SPEED), [pp.loads.DeepDrawing(5e6, 0.005)]
    stiffness = Stiffness(BEARINGS, frame=TIE_RODS)
    found = slide_deflection(press, motion, stiffness, loads=load)
    pull = -pp.inverse_dynamics(press, motion, loads=load).bearing_force["O"][:, 2]
    assert pull.max() > TIE_RODS.opening_load > pull.min()
    assert found.parts["frame"] == pytest.approx([by_hand(TIE_RODS, float(each)) for each in pull], rel=1e-9)
    linear = slide_deflection(press, motion, Stiffness(BEARINGS, frame=8e9), loads=load)
    more = found.deflection - linear.deflection
    assert np.all((more > 1e-9) == (pull > TIE_RODS.opening_load))
    assert more.max() == pytest.approx((pull.max() - TIE_RODS.opening_load) * (1 / 2e9 - 1 / 8e9), rel=1e-9)


def test_a_gib_that_lifts_leaves_one():
    """Work of the guide's elongation over its unit force, by hand from the reactions."""
    press = shipped("jf75g_125_plain")
    motion, load = pp.servo_cycle(press, angle=np.linspace(5.6, 6.2, 31), speed=SPEED), [pp.loads.DeepDrawing(3e6, 0.005)]
    gibs = PreloadedJoint(1e9, 1e9, 2e4)
    found = slide_deflection(press, motion, Stiffness(BEARINGS | {"slide_guide": gibs}), loads=load)
    one = pp.loads.PointForce("slide", (0.0, 0.0, 1e6))
    across, more = (pp.inverse_dynamics(press, motion, loads=each).bearing_force["slide_guide"][:, 0] for each in (load, [*load, one]))
    assert np.abs(across).max() > gibs.opening_load > np.abs(across).min()
    expected = (more - across) / 1e6 * np.array([by_hand(gibs, float(each)) for each in across])
    assert found.parts["slide_guide"] == pytest.approx(expected, rel=1e-9, abs=1e-18)


def test_a_screw_in_a_rod_that_lifts_off():
    press = shipped("jf75g_125_plain")
    motion, load = pp.servo_cycle(press, angle=np.linspace(5.9, 6.2, 21), speed=SPEED), [pp.loads.DeepDrawing(1e6, 0.005)]
    link = next(name for name in press.links if "rod" in name)
    screw = PreloadedJoint(3e9, 5e9, 1e5)  # pressing on the rod takes from the screw, and adds to its lock
    found = slide_deflection(press, motion, Stiffness(BEARINGS, rods=[Rod(link, ("P2", "P4"), screw)]), loads=load)
    linear = slide_deflection(press, motion, Stiffness(BEARINGS, rods=[Rod(link, ("P2", "P4"), 8e9)]), loads=load)
    name = next(name for name in found.parts if name.startswith(link))
    assert np.all(found.parts[name] >= linear.parts[name] - 1e-15)
    assert found.parts[name].max() > 1.2 * linear.parts[name].max()  # the lock carries alone


@pytest.mark.exhaustive
def test_closed_in_elastic_motion_it_is_a_spring():
    press, held = shipped("crank_slide"), pp.drives.PrescribedSpeed(2.0)
    bearings, blank = dict.fromkeys(press.bearings, 1e8), [pp.loads.Blanking(3e4, 0.02, 0.01)]

    def run(frame, guide=1e8):
        stiffness = Stiffness(bearings | {"slide_guide": guide}, {"slide_guide": 1e7}, frame=frame)
        return pp.simulate(
            press, 2.5, speed=2.0, angle=3.5, drive=held, loads=blank, points=101, elastic=Elastic(stiffness, 0.1, crown_mass=500)
        )

    linear, joined = run(4e8), run(PreloadedJoint(1e8, 3e8, 1e5), PreloadedJoint(5e7, 5e7, 1e5))
    assert joined.slide_position == pytest.approx(linear.slide_position, abs=1e-12)
    assert joined.stats.energy_error < 1e-10
