"""Words of sketches lie on no line and on no other words, measured with the extents of a real font, and can be read."""

import itertools
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from support import texts
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.pin_table import sketch
from pinpress.pin_table.templates import TEMPLATES, template

SVG = "{http://www.w3.org/2000/svg}"


def strokes(drawing):
    """Points of each line, bar, plate and circle that is drawn."""
    for each in drawing.iter():
        kind = each.tag.removeprefix(SVG)
        if kind in ("polyline", "polygon"):
            corners = [np.array(pair.split(","), float) for pair in each.get("points").split()]
            corners += corners[:1] if kind == "polygon" else []
            yield from (np.linspace(a, b, 400) for a, b in itertools.pairwise(corners))
        elif kind == "line":
            x1, y1, x2, y2 = (float(each.get(key)) for key in ("x1", "y1", "x2", "y2"))
            angle, *about = map(float, re.findall(r"-?[\d.]+", each.get("transform", "0 0 0")))
            cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
            yield (np.linspace((x1, y1), (x2, y2), 400)[4:-4] - about) @ np.array([[cos, sin], [-sin, cos]]) + about
        elif kind == "circle":
            turns = np.linspace(0, 2 * np.pi, 400)[:, None]
            around = np.hstack([np.cos(turns), np.sin(turns)])
            yield np.array([float(each.get("cx")), float(each.get("cy"))]) + float(each.get("r")) * around


def written(drawing):
    """Box of each text but the title, as wide as in DejaVu Sans."""
    from matplotlib.textpath import TextPath

    for each in drawing.iter(f"{SVG}text"):
        if each.get("text-anchor") is None:
            size = 12 if each.get("class") else float(drawing.get("font-size", 14))
            box = TextPath((0, 0), each.text, size=size, usetex=False).get_extents()
            at = np.array([float(each.get("x")), float(each.get("y"))])
            yield each.text, np.array([at + np.array([box.x0, -box.y1]), at + np.array([box.x1, -box.y0])])


def check(drawing):
    boxes = list(written(drawing))
    for k, (words, (low, high)) in enumerate(boxes):
        for other, (a, b) in boxes[:k]:
            assert np.any((a >= high) | (low >= b)), f"{words} lies on {other}"
        for points in strokes(drawing):
            assert not np.any(np.all((low < points) & (points < high), axis=1)), f"{words} lies on a line"


@pytest.mark.parametrize("name", rest_exhaustive([*TEMPLATES], "hypocycloid", "drawing-8-bar"))
def test_templates(name, tmp_path):
    table = tmp_path / "press.yaml"
    table.write_bytes(template(name))
    check(ET.fromstring(pp.pin_table.draft(table).sketch))


@pytest.mark.parametrize("name", rest_exhaustive([*pp.presses()], "pirica_double_knuckle", "jf75g_125_symmetric"))
def test_shipped_presses(name):
    check(ET.fromstring(texts.shipped(name)._repr_html_()).find(f"{SVG}svg"))


@pytest.mark.parametrize("seed", rest_exhaustive(range(40), 0, 1))
def test_random_lines(seed):
    rng = np.random.default_rng(seed)
    names = rng.permutation(["crank", "a_long_name_of_a_rod", "slide"])
    scene = sketch._Sheet([np.array([0.0, 0.0]), np.array([600.0, 450.0])], "any table")
    points = rng.uniform((0, 0), (600, 450), (7, 2))
    for k, (a, b) in enumerate(itertools.pairwise(points)):
        scene._thin(np.array(scene.at(a)), np.array(scene.at(b)))
        scene.written.append((np.array(scene.at((a + b) / 2)), names[k % 3], None, ""))
        scene._dimension(np.array(scene.at(a)), np.array(scene.at(b)), f"{np.hypot(*(b - a)):.6g}")
    check(ET.fromstring(scene.text()))


def test_contrast():
    def luminance(colour):
        parts = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255
        return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]

    for colour in (*sketch.COLOURS, sketch.INK, sketch.WRONG, *re.findall("fill:(#[0-9a-f]{6})", sketch.STYLE)):
        assert 1.05 / (luminance(colour) + 0.05) >= 4.5
