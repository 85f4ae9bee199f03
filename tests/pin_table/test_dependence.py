"""Numbers of a pin table as dimensions with tolerances: against presses that are built again with other numbers."""

from functools import partial

import numpy as np
import pytest

import pinpress as pp
from pinpress.pin_table.templates import template

tol, dimension = pp.tolerances, pp.pin_table.dimension
TABLE = """
units: in
parameters: {r: 3.5, l: 16, e: 1, spare: 3}
frame: O
pins:
  O: [0, 0]
  P: {from: O, length: r, angle: -70}
  W: {P: l, x: e, side: down}
links:
  crank: {pins: O P, mass: 20}
  rod: {pins: P W, mass: 30}
  slide: {pins: W, guide: up, mass: 90}
drive: O
"""
FOUR_BAR = """
units: in
parameters: {tilt: 20}
frame: O D
pins: {O: [0, 0], P: {from: O, length: 4, angle: 90}, D: {from: O, length: 20, angle: tilt}, B: {P: 15, D: 12, side: up}}
links: {crank: {pins: O P, mass: 20}, coupler: {pins: P B, mass: 30}, rocker: {pins: D B, mass: 30}}
drive: O
"""
INCH = 0.0254


@pytest.fixture
def table(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "press.yaml").write_text(TABLE)
    return "press.yaml"


@pytest.mark.parametrize(
    ("name", "number", "unit"),
    [
        *(("knuckle.yaml", number, 1e-3) for number in ("r", "l", "upper", "lower")),
        ("guide-bar.yaml", "bar", 1e-3),
        ("pirica_double_knuckle", "r", 1e-3),  # with copies, whose bearings are redundant
        ("press.yaml", "e", INCH),
    ],
)
def test_gradients_are_those_of_presses_that_are_built_again(table, tmp_path, name, number, unit):
    if name in ("knuckle.yaml", "guide-bar.yaml"):
        (tmp_path / name).write_bytes(template(name.removesuffix(".yaml")))
    drawn, step = pp.pin_table.draft(name), 1e-5 / unit
    found = tol.bottom_dead_centre(drawn.press(), [dimension(drawn, number, 1e-4)], samples=10)
    start = float(drawn._table.items("")["parameters"].items("")[number].value)
    ends = [pp.dead_centres(pp.build(name, **{number: start + way * step})) for way in (1, -1)]
    for result, place in ((found.height, "bottom_position"), (found.top, "top_position")):
        difference = (getattr(ends[0], place) - getattr(ends[1], place)) / (2 * step * unit)
        assert result.gradient[0] == pytest.approx(difference, rel=1e-8)  # as far as the differences are exact


def test_every_press_of_the_sample_is_one_of_the_table(table):
    drawn, start = pp.pin_table.draft(table), {"r": 3.5, "l": 16.0, "e": 1.0}
    parts = [dimension(drawn, name, 2e-4, shape="uniform") for name in start]
    found = tol.bottom_dead_centre(drawn.press(), parts, samples=20, seed=1)
    for k, deviations in enumerate(found.deviations.T):
        ends = pp.dead_centres(pp.build(table, **{n: v + by / INCH for (n, v), by in zip(start.items(), deviations, strict=True)}))
        for result, place in ((found.height, ends.bottom_position), (found.top, ends.top_position)):
            assert result.nominal + result.deviation[k] == pytest.approx(place, abs=1e-14)


def test_an_angle_moves_its_pin_on_its_circle(tmp_path):
    (tmp_path / "four.yaml").write_text(FOUR_BAR)
    part = dimension(pp.pin_table.draft(tmp_path / "four.yaml"), "tilt", np.radians(0.01), unit="rad")
    assert [*part.direction] == [("D", "frame")]
    across = 20 * INCH * np.array([-np.sin(np.radians(20)), 0.0, np.cos(np.radians(20))])
    assert part.direction["D", "frame"] == pytest.approx(across, rel=1e-9)
    assert part.unit == "rad"


def test_a_job_and_a_file_name_numbers_of_the_table(table, tmp_path):
    (tmp_path / "job.yaml").write_text(
        "base: press.yaml\nzero: tdc\ntolerances: {dimensions: {r: 0.1 mm, length P W: 0.1 mm}, samples: 50}\n"
    )
    (tmp_path / "rows.csv").write_text("dimension, tolerance, unit, cost\nr, 50, um, 3\nlength P W, 0.1, mm, 1\n")
    (tmp_path / "four.yaml").write_text(FOUR_BAR)
    job = pp.job("job.yaml", **{"tolerances.dimensions.r": "50 um"})
    drawn = pp.pin_table.draft(table)
    press = drawn.press()
    parts = [dimension(drawn, "r", 50e-6), tol.link_length(press, "P", "W", 1e-4)]
    direct = tol.bottom_dead_centre(press, parts, samples=50)
    assert job.scatter().height.deviation == pytest.approx(direct.height.deviation, abs=1e-15)
    rows = tol.read_dimensions(press, "rows.csv", partial(dimension, drawn))
    assert tol.bottom_dead_centre(press, rows.parts, samples=50).height.gradient == pytest.approx(direct.height.gradient, rel=1e-12)
    assert tol.allocate(press, rows.parts, rows.costs, {"height": 1e-4}).reached["height"] == pytest.approx(1e-4, rel=1e-6)
    with pytest.raises(pp.PinpressError, match=r"'r' is not a dimension: write 'length E F'.* not in the frame$"):
        tol.read_dimensions(press, "rows.csv")
    angle = pp.job("four.yaml", tolerances={"dimensions": {"pins.P.angle": 1e-4, "tilt": "0.01 deg"}})
    with pytest.raises(pp.PinpressError, match="the angle of crank in the drawn pose changes with"):
        _ = angle.dimensions


REFUSALS = [
    (("q", 1e-4), {}, "no number in press.yaml 'q'; there are: r, l, e, spare, pins.O.1"),
    (("pins.W.side", 1e-4), {}, "did you mean"),
    (("spare", 1e-4), {}, "no pin of press.yaml depends on spare: leave it out"),
    (("r", 1e-4), {"unit": "mm"}, "unit of r is 'mm': give 'm' or 'rad'"),
    (("r", 0.0), {}, "tolerance of dimension 'r' is 0"),
    (("pins.P.angle", 1e-4), {}, "pins.P.angle is an angle, but its tolerance is a length: give the tolerance in deg"),
    (("pins.P.length", 1e-4), {"unit": "rad"}, "pins.P.length is a length, but its tolerance is an angle: give the tolerance in mm"),
]


@pytest.mark.parametrize(("given", "options", "message"), REFUSALS)
def test_refusals(table, given, options, message):
    with pytest.raises(pp.PinpressError, match=message):
        dimension(pp.pin_table.draft(table), *given, **options)
