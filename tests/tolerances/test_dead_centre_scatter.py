"""The scatter of dead centres: every press of a sample is the reshaped one, first order is exact, numbers of a six-bar press hold."""

import numpy as np
import pytest
from support import texts
from support.sliding_presses import TOGGLE
from support.two_servos import TWO_SERVOS

import pinpress as pp
from pinpress.derivatives import pivot_positions, reshaped
from pinpress.pin_table.templates import template
from pinpress.tolerances.dead_centre_scatter import dead_centre_gradients

tol = pp.tolerances
SLIDING = "a toggle that a screw moves"
LATE = 30_001  # a press of a sample that is worked through in many pieces


def six_bar(press, shape="normal"):
    """The tolerances of a drawing of zxn2_3000b."""
    lengths = {"AB": 5e-5, "BC": 1e-4, "DC": 5e-5, "DE": 5e-5, "EF": 5e-5}
    return [
        *(tol.link_length(press, *pins, T, shape=shape) for pins, T in lengths.items()),
        *(tol.pin_position(press, pin, axis, 1e-4, shape=shape) for pin, axis in (("A", "x"), ("A", "z"), ("slide_guide", "x"))),
        tol.pin_angle(press, "C", "D", "E", np.radians(0.01), shape=shape),
    ]


def all_pivots(press, tolerance):
    """A dimension for each pivot along each axis of the plane."""
    return [
        tol.pin_position(press, bearing, axis, tolerance, link=link, name=f"{bearing} {axis} {link}")
        for bearing, link in pivot_positions(press)
        for axis in "xz"
    ]


def built(press, found, k):
    """Press k of a sample, made anew."""
    at = pivot_positions(press)
    for part, deviation in zip(found.parts, found.deviations[:, k], strict=True):
        for key, vector in part.direction.items():
            at[key] = at[key] + deviation * np.asarray(vector)
    return reshaped(press, at)


@pytest.fixture(scope="module")
def press():
    return texts.shipped("zxn2_3000b")


@pytest.fixture(scope="module")
def found(press):
    return tol.bottom_dead_centre(press, six_bar(press), forces={0.006: 3e6}, speeds={0.05: 7.0, 0.1: -7.0}, samples=40_000)


def test_a_crank_slide_by_hand():
    press = texts.shipped("crank_slide")
    parts = [tol.link_length(press, "O", "P", 3e-5), tol.link_length(press, "P", "W", 4e-5), tol.pin_position(press, "O", "z", 1e-5)]
    found = tol.bottom_dead_centre(press, parts, samples=2000)
    assert found.gradient == pytest.approx([-1, -1, 1], abs=1e-12)
    assert found.top.gradient == pytest.approx([1, -1, 1], abs=1e-12)
    assert found.stroke.gradient == pytest.approx([2, 0, 0], abs=1e-12)
    assert found.share == pytest.approx(np.array([9, 16, 1]) / 26)
    assert found.worst_case == pytest.approx(8e-5)
    assert found.height.corners == pytest.approx([-8e-5, 8e-5], abs=1e-15)
    assert found.height.deviation == pytest.approx([-1, -1, 1] @ found.deviations, abs=1e-15)
    assert found.stroke.deviation == pytest.approx(2 * found.deviations[0], abs=1e-15)


def test_the_numbers_of_a_six_bar_press(found):
    """Our prototypes', each by its own calculation: sums over pivots, and one press after the other."""
    assert 3 * found.height.first_order_sd == pytest.approx(72.0e-6, abs=0.05e-6)
    assert 3 * found.top.first_order_sd == pytest.approx(361e-6, abs=0.5e-6)
    assert 3 * found.stroke.first_order_sd == pytest.approx(348e-6, abs=0.5e-6)
    assert (found.worst_case, found.stroke.worst_case) == (pytest.approx(132.6e-6, abs=0.1e-6), pytest.approx(916e-6, abs=0.5e-6))
    assert found.height.corners == pytest.approx([-132.0e-6, 133.2e-6], abs=0.05e-6)
    assert found.gradient[3:5] == pytest.approx([-0.9986, -1.0005], abs=1e-4)
    shares = dict(zip([part.name for part in found.parts], found.share, strict=True))
    assert (shares["EF"], shares["DE"]) == (pytest.approx(0.48, abs=0.005), pytest.approx(0.48, abs=0.005))
    by_stroke = dict(zip(shares, found.stroke.share, strict=True))
    assert [by_stroke[name] for name in ("BC", "A x", "angle CDE")] == pytest.approx([0.33, 0.27, 0.11], abs=0.005)
    assert found.within(50e-6) == pytest.approx(0.9628, abs=0.004)
    assert found.height.sd == pytest.approx(24.0e-6, rel=0.01)
    torque = found.torques[0.006]
    assert (torque.nominal, torque.first_order_sd) == (pytest.approx(75_990, abs=5), pytest.approx(20.24, abs=0.01))
    assert torque.sd == pytest.approx(20.24, rel=0.01)


def test_first_order_is_that_of_the_sample(found):
    """Regression of the sample on the deviations gives the gradients; the closed form of second order leaves little else."""
    for each in found.quantities:
        slopes = np.linalg.lstsq(found.deviations.T, each.deviation, rcond=None)[0]
        tolerances = np.array([part.tolerance for part in found.parts])
        assert np.abs((slopes - each.gradient) * tolerances).max() < 2e-3 * each.worst_case


@pytest.mark.filterwarnings("ignore:.*moves the slide at neither:pinpress.PinpressWarning")  # a guide along itself
@pytest.mark.parametrize("name", ["crank_slide", "jf75g_125_plain", "thin_wall", "zxn2_3000b", SLIDING])
def test_every_press_is_the_reshaped_one(name):
    press = texts.load(TOGGLE) if name == SLIDING else texts.shipped(name)
    found = tol.bottom_dead_centre(press, all_pivots(press, 1e-3), samples=40, seed=1)
    for k in (0, 27):
        ends = pp.dead_centres(built(press, found, k))
        assert found.height.nominal + found.height.deviation[k] == pytest.approx(ends.bottom_position, abs=1e-12)
        assert found.top.nominal + found.top.deviation[k] == pytest.approx(ends.top_position, abs=1e-12)


KNEE = """
press: knee
units: mm
frame: A D
pins:
  D: [0, 0]
  A: [500, -300]
  B: {from: A, length: 50, angle: 90}
  C: {B: 500, D: 300, side: left}
  F: {C: 300, x: 0, side: down}
links:
  crank: {pins: A B, mass: 10}
  coupler: {pins: B C, mass: 10}
  upper: {pins: D C, mass: 10}
  lower: {pins: C F, mass: 10}
  slide: {pins: F, guide: up, mass: 100}
drive: A
"""


@pytest.mark.filterwarnings("ignore:.*moves the slide at neither:pinpress.PinpressWarning")
def test_of_several_turning_points_the_outermost_of_each_press_counts(tmp_path):
    """The knee of a toggle swings through: two bottoms are equally low, and which of two tops 12 um apart is higher differs."""
    (tmp_path / "knee.yaml").write_text(KNEE)
    press = pp.build(tmp_path / "knee.yaml")
    found = tol.bottom_dead_centre(press, all_pivots(press, 2e-4), samples=8, seed=4)
    nominal, near_second = pp.dead_centres(press), 0
    for k in range(8):
        ends = pp.dead_centres(built(press, found, k))
        assert found.height.nominal + found.height.deviation[k] == pytest.approx(ends.bottom_position, abs=1e-12)
        assert found.top.nominal + found.top.deviation[k] == pytest.approx(ends.top_position, abs=1e-12)
        near_second += abs(ends.top_angle - nominal.top_angle) > 1.0
    assert 0 < near_second < 8


def test_torque_and_speed_are_those_of_the_reshaped_press(press, found):
    """At the height above its own bottom dead centre, found among the states of one turn."""
    other = built(press, found, LATE)
    low = pp.dead_centres(other)
    for height, sense, quantity, factor in [
        (0.006, 1.0, found.torques[0.006], -3e6),
        (0.05, 1.0, found.speeds[0.05], -7.0),
        (0.1, -1.0, found.speeds[0.1], -7.0),
    ]:
        near = low.bottom_angle - sense * np.linspace(0.01, 2.0, 400)
        above = pp.servo_cycle(other, speed=1.0, angle=near[::-1] if sense > 0 else near).slide_position - low.bottom_position
        angle = np.interp(height, np.sort(above), near)
        for _ in range(4):
            state = pp.servo_cycle(other, speed=1.0, angle=[angle])
            angle -= (state.slide_position[0] - low.bottom_position - height) / state.slide_velocity[0]
        state = pp.servo_cycle(other, speed=sense, angle=[angle])
        value = factor * state.slide_velocity[0]
        assert quantity.nominal > 0
        assert quantity.nominal + quantity.deviation[LATE] == pytest.approx(value, rel=1e-11)


def test_presses_that_close_in_another_assembly_are_refused(press):
    """A crank of 0.143 m that is 0.42 m shorter would point the other way, with a length of -0.277 m."""
    crank = tol.link_length(press, "A", "B", 0.01, shape=[-0.42, 0.001])
    with pytest.raises(pp.PinpressError, match=r"or not as zxn2_3000b is assembled; the first of them deviates by -0\.42 "):
        tol.bottom_dead_centre(press, [crank], samples=50)


def test_lengths_scale(press):
    """All pivots moved in proportion to their places move the slide in proportion: dz/dp . p is z itself."""
    swollen = tol.Dimension("all lengths", pivot_positions(press), 1e-6)
    ends = pp.dead_centres(press)
    assert np.array(dead_centre_gradients(press, [swollen])).ravel() == pytest.approx([ends.bottom_position, ends.top_position], rel=1e-12)


def test_bands_are_quantiles(press):
    """Of uniform dimensions, two of which count, the band is narrower than three standard deviations say."""
    found = tol.bottom_dead_centre(press, six_bar(press, "uniform"), samples=40_000)
    low, high = found.height.band(0.9973)
    assert (low, high) == (pytest.approx(-101e-6, abs=2e-6), pytest.approx(101e-6, abs=2e-6))
    assert 3 * found.height.sd == pytest.approx(125e-6, abs=1.5e-6)
    assert found.height.within(low, high) == pytest.approx(0.9973, abs=1e-4)
    with pytest.raises(pp.PinpressError, match=r"leaves 2 of 40000 presses at each end.*samples=100000 or more"):
        found.height.band(0.9999)


def test_correlated_lengths(press):
    """Rods from one batch, as long or as short as each other, double their deviations; opposite ones cancel."""
    parts = [tol.link_length(press, *pins, 5e-5) for pins in ("DE", "EF")]
    sd = {}
    for coefficient in (1.0, 0.0, -1.0):
        found = tol.bottom_dead_centre(press, parts, correlation={("DE", "EF"): coefficient}, samples=4000)
        sd[coefficient] = found.height.first_order_sd
        assert found.height.sd == pytest.approx(sd[coefficient], rel=0.04, abs=1e-9)
        assert found.share.sum() == pytest.approx(1.0)
    assert sd[1.0] == pytest.approx(5e-5 / 3 * np.abs(found.gradient).sum())
    assert sd[0.0] == pytest.approx(5e-5 / 3 * np.linalg.norm(found.gradient))
    assert sd[-1.0] == pytest.approx(5e-5 / 3 * abs(found.gradient[0] - found.gradient[1]))


def test_a_text_says_what_decides(found):
    text = str(found)
    assert "EF, DE make 96 % of the variance: half as wide, the standard deviation falls to 53 %" in text
    assert "worst corners         -132.0 and 133.2 um" in text
    assert "angle CDE       0.01 deg" in text


def test_what_cannot_be_answered_is_refused(press, tmp_path):
    rod = [tol.link_length(press, "E", "F", 5e-5)]
    two_points = texts.shipped("jf75g_125_two_point")
    (tmp_path / "rssp.yaml").write_bytes(template("rssp"))
    (tmp_path / "servos.yaml").write_text(TWO_SERVOS)
    spatial, servos = pp.build(tmp_path / "rssp.yaml"), pp.build(tmp_path / "servos.yaml")
    for wrong, said in [
        (lambda: tol.bottom_dead_centre(press, rod, forces={0.4: 1e6}), "a height of 400 mm is above the stroke.* from 301.261 mm above"),
        (lambda: tol.bottom_dead_centre(press, rod, speeds={0.0: 1.0}), "height of speeds is 0.0: give one finite number, positive"),
        (lambda: tol.bottom_dead_centre(press, rod, forces={0.1: 0.0}), "is 0 N"),
        (lambda: tol.bottom_dead_centre(press, rod, samples=1), "samples is 1"),
        (lambda: tol.bottom_dead_centre(two_points, [tol.link_length(two_points, "O", "P2_back", 1e-5)]), "bearings that hold each other"),
        (lambda: tol.bottom_dead_centre(spatial, all_pivots(spatial, 1e-5)), "exact derivatives are those of planar linkages"),
        (lambda: tol.bottom_dead_centre(servos, all_pivots(servos, 1e-5)), "several drivers|drivers"),
        (
            lambda: tol.bottom_dead_centre(press, [tol.link_length(press, "B", "C", 0.1, sd=0.5)], samples=50),
            "of 56 presses, worst corners among them, cannot be closed at",
        ),
    ]:
        with pytest.raises(pp.PinpressError, match=said):
            wrong()
