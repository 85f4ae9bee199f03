"""Everyday mistakes in pin tables: what is said to each, with the line, and what to write instead."""

import re

import pytest

import pinpress as pp
from pinpress.pin_table.templates import template

GOOD = """\
units: mm
frame: A D
pins:
  D: [0, 0]
  A: [1250, -200]
  B: {from: A, length: 143, angle: 0}
  C: {B: 1243, D: 375, side: up}
  E: {from: D C, length: 480, angle: -135}
  F: {E: 480, x: 0, side: down}
links:
  crank:   {pins: A B,   mass: 1009.16, com: [56.7, 0],    inertia: 31.5}
  coupler: {pins: B C,   mass: 290.57}
  rocker:  {pins: D C E, mass: 2871.07, com: [-8.6, -3.8], inertia: 183}
  rod:     {pins: E F,   section: 200 x 120, overhang: 90}
  slide:   {pins: F, guide: up, mass: 7073.87}
drive: A
"""
COUPLER = "coupler: {pins: B C,   mass: 290.57}"

# What stands in the table, what is written instead, the line, and words of the message.
MISTAKES = {
    "no units": ("units: mm\n", "", None, "say the unit of all lengths: units: mm"),
    "unknown unit": ("units: mm", "units: mmm", 1, "did you mean 'mm'?"),
    "decimal comma in a point": ("A: [1250, -200]", "A: [1250,5, -200]", 5, "a point is [x, z], 3 numbers found"),
    "decimal comma in a mass": ("mass: 290.57", "mass: 290,57", 12, "write decimals after a point, not after a comma"),
    "misspelt key": ("inertia: 31.5", "inertai: 31.5", 11, "did you mean 'inertia'?"),
    "misspelt section of the table": ("links:", "link:", 10, "did you mean 'links'?"),
    "no space after a colon": ("length: 143", "length:143", 6, "write a space after the colon"),
    "tab": ("  C: {B", "\tC: {B", 7, "indent with blanks"),
    "key twice": ("  E: {from", "  D: {from", 8, "D stands there twice"),
    "pin in lower case": ("pins: B C", "pins: B c", 12, "did you mean 'C'?"),
    "commas between names": ("pins: D C E", "pins: 'D, C, E'", 13, "separate names by blanks"),
    "reserved name": ("  E: {from", "  side: {from", 8, "'side' cannot name a pin"),
    "no side": (", side: up}", "}", 7, "two places fit, (157.9, -340.1) and (247.2, 282); say side"),
    "side does not decide": ("F: {E: 480, x: 0, side: down}", "F: {E: 480, x: 0, side: left}", 9, "say up or down"),
    "unknown side": ("side: up", "side: upp", 7, "did you mean 'up'?"),
    "lengths too short": ("B: 1243, D: 375", "B: 700, D: 375", 7, "700 and 375 do not meet: B and D are 1407.28 apart"),
    "line not reached": ("F: {E: 480, x: 0", "F: {E: 20, x: 0", 9, "20 from E does not reach x = 0: 31.4"),
    "placed in a circle": ("B: {from: A, length: 143, angle: 0}", "B: {C: 1243, A: 143, side: up}", 6, "placed by one another: B - C - B"),
    "rod of length zero": ("F: {E: 480, x: 0, side: down}", "F: E", 14, "E and F are one point"),
    "three pins on a line": ("length: 480, angle: -135}", "length: 480, angle: 180}", 13, "on a line"),
    "no mass": (COUPLER, "coupler: {pins: B C}", 12, "give mass, section, box or disc; or say masses: none"),
    "negative mass": ("mass: 290.57", "mass: -290.57", 12, "a mass of -290.57"),
    "inertia about a wrong point": ("inertia: 31.5}", "inertia: {D: 31.5}}", 11, "less than its mass there would have"),
    "frame pin forgotten": ("frame: A D", "frame: A", None, "mobility is"),
    "guide forgotten": ("guide: up, ", "", None, "mobility is"),
    "a link drives": ("drive: A", "drive: crank", 16, "crank is a link; name its bearing: A"),
    "unknown driver": ("drive: A", "drive: Z", 16, "no pin or guide Z"),
    "link in the air": ("pins: E F", "pins: F", 14, "a section of a link with one pin"),
    "an empty list of pins": ("pins: E F", "pins: []", 14, "names of pins"),
    "no pins": ("pins: F, guide", "guide", 15, "no pins"),
    "empty": (GOOD, "", None, "it is empty"),
    "not a table": (GOOD, "hello", 1, "where keys"),
    "bracket left open": ("A: [1250, -200]", "A: [1250, -200", None, "it is no YAML"),
    "formula of an unknown name": ("length: 143", "length: r", 6, "'r' in 'r' is no parameter"),
    "formula without value": ("length: 143", "length: 1 / 0", 6, "has no finite value"),
    "mm taken for m": ("units: mm", "units: m", 3, "is it units: mm?"),
    "two sorts of mass": ("section: 200 x 120", "section: 200 x 120, disc: 20 x 30", 14, "give one of them"),
    "section of one number": ("section: 200 x 120", "section: 200", 14, "height x width"),
    "guide of one pin": ("guide: up", "guide: A", 15, "name two points, up, down, left, right or an angle"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_what_is_said(mistake, tmp_path):
    old, new, line, words = MISTAKES[mistake]
    assert GOOD.count(old) == 1
    path = tmp_path / "press.yaml"
    path.write_text(GOOD.replace(old, new), encoding="utf-8")
    if mistake == "three pins on a line":
        path.write_text(path.read_text().replace(", com: [-8.6, -3.8], inertia: 183", ""), encoding="utf-8")
    with pytest.raises(pp.PinpressError, match=re.escape(words)) as caught:
        pp.build(path)
    assert str(caught.value).startswith(str(path) + (f":{line}: " if line else ""))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("com: [56.7, 0]", "com: [13000, 0]", "a place in the drawing is the name of a point in pins"),
        ("inertia: 31.5", "inertia: 31500000", "write moments of inertia in kg m2"),
    ],
)
def test_what_is_legal_but_hardly_meant(old, new, words, tmp_path):
    path = tmp_path / "press.yaml"
    path.write_text(GOOD.replace(old, new), encoding="utf-8")
    with pytest.warns(pp.PinpressWarning, match=re.escape(words)):
        pp.build(path)


@pytest.mark.filterwarnings("ignore:.*radius of gyration")
def test_metres_taken_for_mm(tmp_path):
    path = tmp_path / "press.yaml"
    path.write_text(
        "units: mm\nframe: O\npins: {O: [0, 0], P: [0, -0.1], W: [0, -0.5]}\nmasses: none\n"
        "links: {crank: {pins: O P}, rod: {pins: P W}, slide: {pins: W, guide: up}}\ndrive: O\n"
    )
    with pytest.warns(pp.PinpressWarning, match="largest distance is 0.5 mm; is it units: m"):
        pp.build(path)


@pytest.mark.parametrize("mistake", ["lengths too short", "line not reached"])
def test_lengths_that_do_not_meet_are_drawn(mistake, tmp_path):
    old, new, _, _ = MISTAKES[mistake]
    path = tmp_path / "press.yaml"
    path.write_text(GOOD.replace(old, new), encoding="utf-8")
    with pytest.raises(pp.PinTableError) as caught:
        pp.build(path)
    assert caught.value.sketch is not None
    assert caught.value.sketch.count("<circle") > len(caught.value.element.split())
    assert ("<line" in caught.value.sketch) == (mistake == "line not reached")


def test_scalars_are_what_they_look_like(tmp_path):
    """Pins may be called NO or 1, and 1e3 is a number."""
    text = template("crank-slide").decode()
    text = re.sub(r"\bO\b", "NO", text).replace(" P:", " 1:").replace("O P", "O 1").replace("P W", "1 W").replace("{P: l", "{1: l")
    path = tmp_path / "press.yaml"
    path.write_text(text.replace("mass: 100", "mass: 1e2"), encoding="utf-8")
    press = pp.build(path)
    assert "NO" in press.joints
    assert "1" in press.joints


@pytest.mark.parametrize(
    "text",
    [
        "a: &a [*a]",
        "a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]",
        "[1, 2]",
        "- a\n- b",
        "? [a]\n: b",
        "%YAML 9",
        "a: !!python/name:os.system x",
    ],
)
def test_odd_yaml_is_refused(text, tmp_path):
    path = tmp_path / "press.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(pp.PinTableError):
        pp.build(path)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"r": 5, "x": 2}, "no parameter x"),
        ({"r": "__import__('os')"}, "is no parameter"),
        ({"r": "9**9**9**9"}, "no finite value"),
        ({"r": "(" * 150 + "1" + ")" * 150}, "characters"),
        ({"r": [1, 2]}, "a list where a number belongs"),
        ({"r": True}, "where a number belongs"),
        ({"r": object()}, "give numbers, texts, lists and mappings"),
        ({"r": -5}, "a length of -5"),
        ({"r": 1e300}, "more than 100 km"),
    ],
)
def test_bad_parameters(values, words, tmp_path):
    path = tmp_path / "press.yaml"
    path.write_bytes(template("guide-bar").replace(b"{from: A, length: r, angle: 0}", b"{A: r, x: 100, side: up}"))
    with pytest.raises(pp.PinpressError, match=re.escape(words)):
        pp.build(path, **values)
