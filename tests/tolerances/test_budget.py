"""The parts of the accuracy budget by hand, and beside the elastic press that is simulated."""

import re
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from support import texts

import pinpress as pp
from pinpress import tolerances as tol

RPM = pp.RPM


@pytest.fixture(scope="module")
def crank_slide():
    """Rod and crank weigh nothing: at bottom dead centre all pins carry the slide's 100 kg, with its acceleration."""
    return texts.load(texts.without_mass(texts.shipped("crank_slide").text.decode(), "rod", "crank"))


def test_every_part_of_a_crank_slide_by_hand(crank_slide):
    speeds, pins = np.array([1.0, 20.0]), {"O": 1e-5, "P": 2e-5, "W": 3e-5}
    found = tol.budget(
        crank_slide,
        speeds=speeds,
        clearance=pins,
        stiffness=pp.elasticity.Stiffness({"O": 1e8, "W": 2e8}),
        temperatures=tol.Temperatures({"rod": 20.0, "crank": 10.0}, 1e-5),
        process=1e4,
        stiffness_known_to=0.2,
    )
    assert [each.condition for each in found.conditions] == ["idle", "process", "process, warm"] * 2
    compliance, heat = 1 / 1e8 + 1 / 2e8, -1e-5 * (20.0 * 0.4 + 10.0 * 0.1)
    weights = -100 * (9.81 + speeds**2 * 0.1 * 1.25)
    idle, process, warm = (found.conditions[k::3] for k in range(3))
    for k, weight in enumerate(weights):
        assert idle[k].clearances == pytest.approx(-6e-5)
        assert idle[k].springs == pytest.approx(weight * compliance)
        assert process[k].springs == pytest.approx((1e4 + weight) * compliance)
        assert process[k].clearances == pytest.approx(6e-5)
        assert warm[k].heat == pytest.approx(heat)
        assert warm[k].shift == pytest.approx(6e-5 + (1e4 + weight) * compliance + heat)
        assert warm[k].highest - warm[k].shift == pytest.approx(0.2 * (1e4 + weight) * compliance)
        assert warm[k].shift - warm[k].lowest == pytest.approx(0.2 * (1e4 + weight) * compliance)
        assert warm[k].rise == pytest.approx(warm[k].shift - idle[0].shift)
    assert found.worst == process[0]
    assert found.decides == "springs"
    assert re.search(r"most of it +0\.1\d+ mm +by springs", str(found))


def test_springs_over_speed_are_those_of_the_elastic_dead_centre():
    press, speeds = texts.shipped("zxn2_3000b"), np.array([10.0, 70.0]) * RPM
    springs = pp.elasticity.Stiffness(dict.fromkeys("ABCDEF", 2e9), shaft=3e7, frame=4e9)
    found = tol.budget(press, speeds=speeds, stiffness=springs)
    exact = pp.elasticity.dead_centre_shift(press, springs, speed=speeds)
    assert [each.shift for each in found.conditions] == pytest.approx(exact.position - exact.rigid_position, abs=2e-9)
    assert found.largest_rise == pytest.approx(exact.shift[1] - exact.shift[0], abs=2e-9)


def test_a_budget_without_rise_shows_machining_and_what_is_lowest(crank_slide):
    machining = tol.bottom_dead_centre(crank_slide, [tol.link_length(crank_slide, "P", "W", 1e-5)], samples=5000)
    backwards = tol.budget(crank_slide, speeds=[-2.0], clearance={"W": 1e-5}, machining=machining)
    assert backwards.conditions[0].shift == pytest.approx(-1e-5)
    assert re.search(r"machining +-\d.* µm  in 99.73 % of presses; the setting takes it away", str(backwards))
    assert "largest rise" not in str(backwards)
    model = crank_slide.model.copy()
    model.jointPlacements[2] = pin.SE3(model.jointPlacements[2].rotation, 1.01 * model.jointPlacements[2].translation)
    with pytest.raises(pp.PinpressError, match="machining is the scatter of a crank_slide with other lengths, masses or zero"):
        tol.budget(replace(crank_slide, model=model), speeds=[-2.0], clearance={"W": 1e-5}, machining=machining)
    assert backwards.columns()["rise [m]"] == [0.0]


def test_clearances_that_are_undetermined_leave_a_band(crank_slide):
    """A cylinder carries the slide: at a crawl its pins may stand on either side. Set there, the press rises by what inertia decides."""
    cylinder = [pp.loads.PointForce("slide", (0.0, 0.0, 981.0))]
    found = tol.budget(crank_slide, speeds=[1e-3, 20.0], clearance={"P": 2e-5, "W": 3e-5}, loads=cylinder)
    crawling, fast = found.conditions
    assert (crawling.lowest, crawling.highest) == pytest.approx((-5e-5, 5e-5))
    assert (fast.lowest, fast.shift, fast.highest) == pytest.approx((-5e-5, -5e-5, -5e-5))


def test_the_lowest_place_may_be_aside_of_the_rigid_dead_centre(crank_slide):
    """A force that lifts the slide within a degree of bottom dead centre alone: beside that it hangs, lower than it is pressed there."""

    def lifting(motion):
        turned = np.abs((motion.crank_angle + np.pi) % (2 * np.pi) - np.pi)
        return np.where(turned < np.radians(1.0), 2000.0, 0.0)[:, None] * [0.0, 0.0, 1.0]

    found = tol.budget(crank_slide, speeds=[1.0], clearance={"W": 5e-5}, loads=[pp.loads.PointForce("slide", lifting)]).conditions[0]
    aside = 0.5 * 0.1 * 1.25 * np.radians(1.0) ** 2
    assert (found.clearances, found.crank) == (pytest.approx(-5e-5, rel=1e-3), pytest.approx(aside, rel=0.25))  # in steps of 0.1 deg
    assert found.shift == pytest.approx(found.clearances + found.crank)


@pytest.mark.parametrize(("samples", "said"), [(4000, "in 99.73 % of presses"), (300, "in 95 % of presses"), (5, "in 5 presses")])
def test_machining_is_shown_of_small_samples_too(crank_slide, samples, said):
    machining = tol.bottom_dead_centre(crank_slide, [tol.link_length(crank_slide, "O", "P", 1e-4)], samples=samples)
    text = str(tol.budget(crank_slide, speeds=1.0, clearance={"W": 1e-5}, machining=machining))
    assert said in next(line for line in text.splitlines() if "machining" in line)
    if samples == 5:
        assert f"{1e6 * machining.height.deviation.min():.2f} to {1e6 * machining.height.deviation.max():.2f} µm" in text
