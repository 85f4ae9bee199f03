"""The drawing of a linkage in notebooks: links and bearings where they are, any press, names as they are."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from support import texts
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.linkage.skeleton import HEIGHT, WIDTH
from pinpress.pin_table.templates import TEMPLATES, template

SVG = "{http://www.w3.org/2000/svg}"


def drawn(press):
    shown = ET.fromstring(press._repr_html_())
    assert shown.findtext("div") == repr(press)[1:-1]
    return shown.find(f"{SVG}svg")


def test_the_crank_is_drawn_60_deg_on():
    press = texts.shipped("crank_slide")
    picture = drawn(press)
    crank, rod = (
        np.array([list(map(float, pair.split(","))) for pair in line.get("points").split()]) * [1, -1]
        for line in picture.iter(f"{SVG}polyline")
    )
    np.testing.assert_allclose(np.ptp(rod, axis=0).max() / np.hypot(*np.ptp(crank, axis=0)), 0.4 / 0.1, rtol=0.15)
    away = crank[np.argmin(crank[:, 1])] - crank[np.argmax(crank[:, 1])]
    assert np.degrees(np.arctan2(away[1], away[0])) == pytest.approx(-30, abs=1)
    assert {text.text for text in picture.iter(f"{SVG}text")} == {"O", "P", "W"}


@pytest.mark.parametrize("name", rest_exhaustive([*pp.presses(), *TEMPLATES], "jf75g_125_symmetric", "toggle"))
def test_every_press_has_a_drawing(name, tmp_path):
    table = tmp_path / "press.yaml"
    if name in TEMPLATES:
        table.write_bytes(template(name))
    picture = drawn(texts.shipped(name) if name in pp.presses() else pp.build(table))
    places = [(float(each.get("cx")), float(each.get("cy"))) for each in picture.iter(f"{SVG}circle")]
    assert all(0 < x < WIDTH and 0 < y < HEIGHT for x, y in places)
    apart = len({round(x) for x, _ in places}) + len({round(y) for _, y in places})
    assert apart > (2 if name == "screw" else 3)  # the screw and its nut are on one line


def test_a_locked_linkage_is_drawn_as_it_is(monkeypatch):
    def locks(*_):
        raise pp.SingularityError("locks", 0.0, 0.0)

    monkeypatch.setattr(type(texts.shipped("crank_slide")), "drawn_at", locks)
    lines = list(drawn(texts.shipped("crank_slide")).iter(f"{SVG}polyline"))
    assert {round(float(pair.split(",")[0])) for line in lines for pair in line.get("points").split()} == {WIDTH / 2}


def test_names_are_text():
    name = "&lt;b&gt;"
    shown = texts.load(texts.shipped("crank_slide").text.decode().replace('name="P"', f'name="{name}"'))._repr_html_()
    assert name in shown
    assert "<b>" not in shown
