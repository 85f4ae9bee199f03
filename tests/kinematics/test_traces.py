"""Paths of points of links: printed values of an independent solution in maximal coordinates, a circle, a guide, and the frame."""

import numpy as np
import pytest
from support.generators.random_linkages import four_bar
from support.texts import load, shipped

import pinpress as pp

# coupler point (2.5, 1.5) of a four-bar with frame 5, crank 2, coupler 4 and rocker 3.5, at 1 rad/s: crank angle [deg] -> place, velocity,
# acceleration, radius of curvature, its centre
PRINTED = {
    60: (
        (2.59522949912, 4.17238743294),
        (-0.96176308371, 0.4964687711),
        (-2.02111847703, -1.41159032989),
        0.53702381437,
        (2.3488979754, 3.69519212951),
    ),
    150: (
        (0.30616439025, 3.08462917743),
        (-1.12189024302, -1.61287443391),
        (1.03275751914, -0.33021662368),
        3.72448418236,
        (3.36371001635, 0.95784823691),
    ),
    300: (
        (0.31177301615, 1.10102942756),
        (1.13601326477, 0.85520737632),
        (0.88403484137, 2.05693322658),
        1.81886337719,
        (-0.78216082658, 2.55415458824),
    ),
}


@pytest.fixture(scope="module")
def coupler():
    """The four-bar, drawn at a crank angle of 1 rad, and its coupler point in the coupler's frame, which has the world's axes as drawn."""
    b = 2 * np.exp(1j)
    span = 5 - b
    along = (abs(span) ** 2 + 16 - 3.5**2) / (2 * abs(span))
    c = b + span / abs(span) * (along + 1j * np.sqrt(16 - along**2))
    arm = (2.5 + 1.5j) * (c - b) / 4
    return load(four_bar(5, 2, 4, 3.5, 1.0).urdf("O")), (arm.real, 0.0, arm.imag)


@pytest.mark.parametrize("angle", PRINTED)
def test_printed_values(coupler, angle):
    press, point = coupler
    motion = pp.servo_cycle(press, angle=[np.radians(angle) - 1.0], speed=[1.0], acceleration=[0.0])
    found = pp.measures.trace(press, motion, "coupler", point)
    place, velocity, acceleration, radius, centre = PRINTED[angle]
    plane = [0, 2]
    for values, printed in (
        (found.position, place),
        (found.velocity, velocity),
        (found.acceleration, acceleration),
        (found.centre, centre),
    ):
        np.testing.assert_allclose(values[0, plane], printed, atol=1e-10)
        assert abs(values[0, 1]) < 1e-12
    assert found.radius[0] == pytest.approx(radius, abs=1e-10)
    assert found.curvature[0] == pytest.approx(1 / radius, rel=1e-10)


def test_length_and_area(coupler):
    press, point = coupler
    found = pp.measures.trace(press, pp.cycle(press, speed=-1.0, points=2000), "coupler", point)
    assert found.length == pytest.approx(9.8311363612, abs=1e-10)
    assert found.area == pytest.approx(4.9449851988, abs=1e-10)
    x, z = found.position[:, 0], found.position[:, 2]
    np.testing.assert_allclose(
        [x.min(), x.max(), z.min(), z.max()], [-0.428385, 2.786423, 0.908790, 4.255099], atol=5e-6
    )  # (pi / 2000)^2 / 2 x radius
    turn = np.linspace(0.0, 2 * np.pi, 721)
    part = pp.servo_cycle(press, angle=turn, time=turn)
    assert pp.measures.trace(press, part, "coupler", point).length == pytest.approx(9.8311363612, abs=1e-8)


def test_circle_guide_and_frame():
    press = shipped("crank_slide")
    motion = pp.cycle(press, speed=3.0, points=90)
    pin = pp.measures.trace(press, motion, "crank", (0.3, 0.0, 0.4), "T")
    np.testing.assert_allclose(pin.radius, 0.5, rtol=1e-12)
    assert pin.length == pytest.approx(np.pi, rel=1e-12)
    assert pin.area == pytest.approx(np.pi / 4, rel=1e-12)
    slide = pp.measures.trace(press, motion, "slide")
    np.testing.assert_allclose(slide.velocity[:, 2], motion.slide_velocity, atol=1e-12)
    assert np.nanmax(slide.curvature) == 0.0
    assert slide.area < 1e-12
    assert slide.length == pytest.approx(2 * pp.measures.stroke(motion), rel=1e-3)
    frame = pp.measures.trace(press, motion, "frame", (1.0, 2.0, 3.0))
    assert np.array_equal(frame.position[5], [1.0, 2.0, 3.0])
    assert frame.length == 0.0


def test_in_a_job(tmp_path):
    """Points by link, and by names of their own; results of the job."""
    head = "file: crank_slide\nspeed: 10 rad/s\npoints: 12\n"
    (tmp_path / "job.yaml").write_text(head + "traces:\n  T: {link: rod, at: 100 0 50 mm}\n  rod: [0 0 400 mm, 0 0 1 m]\n")
    job = pp.job(tmp_path / "job.yaml")
    assert [(each.name, each.link) for each in job.traces()] == [("T", "rod"), ("rod (0, 0, 0.4)", "rod"), ("rod (0, 0, 1)", "rod")]
    press = shipped("crank_slide")
    wanted = pp.measures.trace(press, pp.cycle(press, speed=10.0, points=12), "rod", (0.1, 0.0, 0.05), "T")
    np.testing.assert_array_equal(job.traces()[0].position, wanted.position)
    (section,) = wanted.described()
    assert [chart.name for chart in section.blocks] == ["path", "velocity", "acceleration", "curvature"]


def test_refused():
    press = shipped("crank_slide")
    motion = pp.cycle(press, speed=1.0, points=12)
    with pytest.raises(pp.UnknownNameError, match="did you mean 'rod'"):
        pp.measures.trace(press, motion, "rodd")
    with pytest.raises(pp.PinpressError, match="x, y, z in the link's frame"):
        pp.measures.trace(press, motion, "rod", (1.0, 2.0))
    part = pp.servo_cycle(press, angle=[0.0, 0.1, 0.2], speed=[1.0] * 3, acceleration=[0.0] * 3)
    with pytest.raises(pp.PinpressError, match="is no cycle"):
        _ = pp.measures.trace(press, part, "rod").area
