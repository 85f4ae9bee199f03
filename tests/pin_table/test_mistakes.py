"""Mistakes in pin tables that are not files of tests/mistakes: odd YAML, bad parameters, and what is drawn of a mistake."""

import os
import re
from typing import Any

import numpy as np
import pytest
from support.mistakes import FOLDER, TABLE

import pinpress as pp
from pinpress.cli.main import main
from pinpress.pin_table.building import draft
from pinpress.pin_table.templates import template


def test_a_centre_of_mass_that_is_not_given_is_listed(tmp_path):
    path = tmp_path / "press.yaml"
    text = TABLE.read_text(encoding="utf-8")
    path.write_text(text.replace(", com: [56.7, 0]", "").replace(", com: [-8.6, -3.8]", ""), encoding="utf-8")
    found = dict(draft(path).estimates())
    assert found["crank"] == "centre of mass half-way from A to B"
    assert found["rocker"] == "centre of mass of a flat plate with its corners at the pins"


def test_a_mapping_is_no_path():
    with pytest.raises(pp.PinpressError, match=r"write build\(\*\*table\)"):
        pp.build({"units": "mm"})


def test_a_urdf_is_no_table(tmp_path, capsys):
    """In a shell too, where it is not taken for a file that would be written over."""
    file = tmp_path / "press.urdf"
    file.write_text("<robot/>", encoding="utf-8")
    with pytest.raises(pp.PinTableError, match=r"this is not a pin table; pp.load\(path\)"):
        pp.build(file)
    assert main(["build", str(file)]) == 2
    assert "this is not a pin table; pp.load(path)" in capsys.readouterr().err


@pytest.mark.filterwarnings("ignore:.*radius of gyration")
def test_metres_taken_for_mm(tmp_path):
    path = tmp_path / "press.yaml"
    path.write_text(
        "units: mm\nframe: O\npins: {O: [0, 0], P: [0, -0.1], W: [0, -0.5]}\nmasses: none\n"
        "links: {crank: {pins: O P}, rod: {pins: P W}, slide: {pins: W, guide: up}}\ndrive: O\n"
    )
    with pytest.warns(pp.PinpressWarning, match="largest distance is 0.5 mm; is it units: m"):
        pp.build(path)


@pytest.mark.parametrize("density", ["7.85", "7.85e-6", "7850000"])
def test_densities_in_other_units(tmp_path, density):
    """g/cm3, kg/mm3 and g/m3 taken for kg/m3, of a link and of the whole table."""
    text, path = TABLE.read_text(encoding="utf-8"), tmp_path / "press.yaml"
    for changed in (text.replace("overhang: 90", f"overhang: 90, density: {density}"), f"{text}density: {density}\n"):
        path.write_text(changed, encoding="utf-8")
        with pytest.warns(pp.PinpressWarning, match=re.escape(f"density: {float(density):g} kg/m3 is not the density of a solid part")):
            draft(path)


@pytest.mark.parametrize("mistake", ["lengths-too-short-to-meet", "length-that-does-not-reach-the-line"])
def test_lengths_that_do_not_meet_are_drawn(mistake):
    with pytest.raises(pp.PinTableError) as caught:
        pp.build(FOLDER / f"{mistake}.yaml")
    assert caught.value.sketch is not None
    assert caught.value.sketch.count("<circle") > len(caught.value.element.split())
    assert ("<line" in caught.value.sketch) == mistake.endswith("line")


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


def test_a_slide_that_is_pinned_to_the_frame_is_named(tmp_path):
    path = tmp_path / "press.yaml"
    path.write_bytes(template("crank-slide").replace(b"frame: O", b"frame: O W"))
    with pytest.raises(pp.PinTableError, match=r"links: slide: it slides in the frame, but its pin W is fixed in the frame; take W out of"):
        pp.build(path)


def test_a_file_of_nearly_the_same_name_is_told(tmp_path):
    (tmp_path / "press.yaml").write_bytes(template("crank-slide"))
    with pytest.raises(pp.PinTableError, match=r"No such file or directory, did you mean 'press\.yaml'\?; give the path of a pin table"):
        pp.build(tmp_path / "press.yml")
    (tmp_path / "press.urdf").write_text(pp.build(tmp_path / "press.yaml").text.decode(), encoding="utf-8")
    with pytest.raises(pp.UrdfError, match=r"pres\.urdf: cannot be read: No such file or directory, did you mean 'press\.urdf'\?"):
        pp.load(tmp_path / "pres.urdf")
    with pytest.raises(pp.UrdfError, match=r"no such file, did you mean 'press\.urdf'\?; name a URDF file"):
        pp.load(tmp_path / "pressurdf")


@pytest.mark.parametrize(
    ("guide", "words"),
    [
        ("vertical", "no direction 'vertical'; write up, down, left, right, an angle, or two points"),
        ("upp", "no direction 'upp', did you mean 'up'?"),
        ("W", "the guide has one point, W; write up"),
        ([0, 1], "no pin 0; name some of O, P, W, or write up, down"),
    ],
)
def test_a_guide_says_how_it_may_be_written(guide, words):
    links = {"crank": {"pins": "O P", "mass": 20}, "rod": {"pins": "P W", "mass": 15}, "slide": {"pins": "W", "guide": guide, "mass": 9}}
    pins = {"O": [0, 0], "P": [0, 100], "W": [0, -300]}
    with pytest.raises(pp.PinTableError, match=re.escape(words)):
        pp.build(units="mm", frame="O", pins=pins, links=links, drive="O")


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"r": 5, "x": 2}, "no parameter x"),
        ({"r": "__import__('os')"}, "is not a parameter"),
        ({"r": "9**9**9**9"}, "no finite value"),
        ({"r": "(" * 150 + "1" + ")" * 150}, "characters"),
        ({"r": [1, 2]}, "a list where a number belongs"),
        ({"r": True}, "where a number belongs"),
        ({"r": object()}, "give numbers, texts, lists and mappings"),
        ({"r": -5}, "a length of -5"),
        ({"r": 1e9}, "more than 100 km"),
        ({"r": 1e300}, "r: 1e+300 is out of range: 1e+12 is the largest number"),
    ],
)
def test_bad_parameters(values, words, tmp_path):
    path = tmp_path / "press.yaml"
    path.write_bytes(template("guide-bar").replace(b"{from: A, length: r, angle: 0}", b"{A: r, x: 100, side: up}"))
    with pytest.raises(pp.PinpressError, match=re.escape(words)):
        pp.build(path, **values)


def crank_press(**slide):
    return {
        "units": "mm",
        "frame": "O",
        "pins": {"O": [0, 0], "P": {"from": "O", "length": 100, "angle": -90}, "W": {"P": 400, "x": 0, "side": "down"}},
        "links": {"crank": {"pins": "O P", "mass": 20}, "rod": {"pins": "P W", "mass": 15}, "slide": {"pins": "W", "guide": "up"} | slide},
        "drive": "O",
    }


@pytest.mark.parametrize(
    "slide",
    [{"mass": 1e300}, {"mass": 90, "inertia": [1e300, 1e300, 1e300]}, {"mass": 90, "com": [1e300, 0]}, {"box": "1e300 x 80 x 60"}],
)
def test_a_huge_number_is_refused_before_it_overflows(slide):
    with pytest.raises(pp.PinTableError, match=r"links: slide: .*1e\+300 is out of range: 1e\+12 is the largest number"):
        pp.build(**crank_press(**slide))


def test_a_length_with_an_angle_is_not_negative():
    table = crank_press(mass=90)
    table["pins"]["P"]["length"] = -100
    with pytest.raises(pp.PinTableError, match="pins: P: length: a length of -100; write 100, and turn the angle by 180"):
        pp.build(**table)


FOUR_BAR: dict[str, Any] = {
    "frame": "A D",
    "pins": {"A": [4.3, 3.9], "B": [1.4, 0.3], "C": [-2.1, -2.1], "D": [0.3, 1.4], "E": [-2.4, 1.8]},
    "links": {"ab": {"pins": "A B", "mass": 1}, "cbe": {"pins": "B C E", "mass": 1}, "dc": {"pins": "D C", "mass": 1}},
    "drive": "A",
}


def test_moments_of_inertia_that_are_estimated_are_not_doubted():
    """Coordinates in metres taken for mm: only the size is odd, and the moments of inertia follow from it."""
    with pytest.warns(pp.PinpressWarning) as said:
        pp.build(units="mm", **FOUR_BAR)
    assert not any("moments of inertia" in str(each.message) for each in said)
    with pytest.warns(pp.PinpressWarning):
        drawn = draft(units="mm", **FOUR_BAR)
    assert not [each for each in drawn.check().findings if "moments of inertia" in each.remedy]


def test_moments_of_inertia_that_are_given_are_doubted():
    links = FOUR_BAR["links"] | {"ab": {"pins": "A B", "mass": 1000, "inertia": 1e-4}}
    with pytest.warns(pp.PinpressWarning, match='<link name="ab">: with 1000 kg .* write moments of inertia in kg m2'):
        pp.build(units="m", **FOUR_BAR | {"links": links})


@pytest.mark.parametrize("given", [{"mass": 12e6}, {"mass": 12e6, "section": "40 x 40"}])
def test_a_mass_in_grams_is_doubted(given):
    links = FOUR_BAR["links"] | {"ab": {"pins": "A B"} | given}
    pins = {name: [10 * x, 10 * z] for name, (x, z) in FOUR_BAR["pins"].items()}
    with pytest.warns(pp.PinpressWarning, match="links: ab: mass: 1.2e\\+07 kg in .*: no material is that dense. Write kg"):
        draft(units="mm", **FOUR_BAR | {"links": links, "pins": pins})


def test_pins_at_one_point_count_once():
    """A crank with the shaft of a gear at its own: m l2 / 12 of a rod."""
    pins = FOUR_BAR["pins"] | {"A1": "A"}
    links = FOUR_BAR["links"] | {"ab": {"pins": "A A1 B", "mass": 3}, "wheel": {"pins": "A1", "disc": "0.1 x 0.1"}}
    drawn = draft(units="m", **FOUR_BAR | {"pins": pins, "links": links, "frame": "A D A1", "gears": {"A1": "2 * A"}})
    crank = next(link for link in drawn.links if link.name == "ab")
    assert crank.inertia[1, 1] == pytest.approx(3 * (2.9**2 + 3.6**2) / 12, rel=1e-12)
    assert crank.centre == pytest.approx([2.85, 0, 2.1])


def test_a_link_of_one_point_names_its_pins():
    pins = FOUR_BAR["pins"] | {"B1": "B", "B2": "B"}
    links = FOUR_BAR["links"] | {"piece": {"pins": "B B1 B2", "mass": 3}}
    with pytest.raises(pp.PinTableError, match="links: piece: pins: B and B1 and B2 are one point"):
        draft(units="m", **FOUR_BAR | {"pins": pins, "links": links})


@pytest.mark.parametrize("text", ["0x10", "0144", "1_000", "3j", "7in", "1e", "0b11", "2 * 0x10", "1.2.3", "٣"])
def test_only_plain_decimal_numbers_are_numbers(text):
    """Python reads some of these as numbers, and warns of others."""
    with pytest.raises(pp.PinTableError, match="is not a number"):
        pp.build(units="mm", **FOUR_BAR | {"parameters": {"r": text}})


@pytest.mark.parametrize(("text", "value"), [("1e5", 1e5), ("1.5E-3", 1.5e-3), (".5 + 00.5", 1.0), ("2*(1.)-0", 2.0)])
def test_plain_numbers_are_read(text, value):
    links = FOUR_BAR["links"] | {"ab": {"pins": "A B", "mass": text}}
    drawn = draft(units="m", **FOUR_BAR | {"links": links})
    assert next(link.mass for link in drawn.links if link.name == "ab") == value


def rack(ratio, units="mm"):
    size = 40 if units == "mm" else 0.04
    return {
        "units": units,
        "frame": "O",
        "pins": {"O": [0, 0], "Q": [size, 0]},
        "links": {"pinion": {"pins": "O", "mass": 5}, "slide": {"pins": "Q", "guide": "up", "mass": 10}},
        "gears": ratio,
        "drive": "O",
    }


@pytest.mark.parametrize("gears", [{"slide_guide": "40 * O"}, {"slide_guide": "-40 * O"}, {"O": "0.025 * slide_guide"}])
def test_a_rack_in_the_tables_unit_is_doubted(gears):
    with pytest.warns(pp.PinpressWarning, match=r"gears: \w+: O moves slide_guide by 40 m/rad: .* 0.04 m/rad for 40 mm"):
        pp.build(**rack(gears))


@pytest.mark.parametrize("units", ["mm", "m"])
def test_a_geared_guide_ends_nowhere(units):
    """0.04 m per radian: ten turns are 2.5 m, and no limit stands in the way that nobody wrote."""
    drawn = draft(**rack({"slide_guide": "0.04 * O"}, units))
    assert not [finding for finding in drawn.check().findings if "limit" in finding.problem]
    motion = pp.servo_cycle(drawn.press(), angle=[0.0, 20 * np.pi], speed=1.0, acceleration=0.0)
    assert np.ptp(motion.slide_position) == pytest.approx(0.04 * 20 * np.pi, rel=1e-12)


def trammels(degrees, second=180.0):
    """A platform on two elliptic trammels, 0.36 m and twice ``second`` long."""
    angle = np.radians(degrees)
    (c, s), other = (180 * np.cos(angle), 180 * np.sin(angle)), np.arcsin(180 * np.sin(angle) / second)
    d, e = second * np.cos(other), second * np.sin(other)
    pins = {"F1": [0, 0], "F2": [560, 0], "M1": [c, s], "S1": [2 * c, 0], "T1": [0, 2 * s]}
    pins |= {"M2": [560 - d, e], "S2": [560 - 2 * d, 0], "T2": [560, 2 * e]}
    links = {
        "c1": {"pins": "F1 M1", "mass": 1},
        "bar1": {"pins": "S1 M1 T1", "mass": 3, "com": "M1", "inertia": 0.04},
        "foot1": {"pins": "S1", "guide": "right", "mass": 1, "travel": [-60, 50]},
        "c2": {"pins": "F2 M2", "mass": 1},
        "bar2": {"pins": "S2 M2 T2", "mass": 3, "com": "M2", "inertia": 0.04},
        "foot2": {"pins": "S2", "guide": "right", "mass": 1},
        "platform": {"pins": "T1 T2", "mass": 10},
    }
    return {"units": "mm", "frame": "F1 F2", "pins": pins, "links": links, "drive": "foot1_guide"}


@pytest.mark.parametrize("degrees", [20.0, 42.0, 65.0])
@pytest.mark.parametrize("second", [180.0, 200.0])
def test_no_other_pose_is_asked_for_where_none_helps(degrees, second):
    """Both ends of the platform go straight up: their lines are across it, so that its length holds the second at second order only,
    wherever it is drawn."""
    with pytest.raises(pp.SingularityError, match=r"only at second order, .* it is shaky.* another pose does not help") as refused:
        pp.build(**trammels(degrees, second))
    assert "further on" not in str(refused.value)


def parallelogram(angle):
    pins = {"A": [0, 0], "D": [350, 0], "B": {"from": "A", "length": 90, "angle": angle}, "C": {"from": "B", "at": [350, 0]}}
    links = {"crank": {"pins": "A B", "mass": 1}, "coupler": {"pins": "B C", "mass": 3}, "follower": {"pins": "D C", "mass": 1}}
    return {"units": "mm", "frame": "A D", "pins": pins, "links": links, "drive": "A"}


def test_a_change_point_is_no_lock_and_its_lengths_are_right():
    with pytest.raises(pp.SingularityError, match="draw the linkage a little further on"):
        pp.build(**parallelogram(0))
    press = pp.build(**parallelogram(50))
    for prescribed in (lambda: pp.cycle(press, speed=1.0), lambda: pp.servo_cycle(press, angle=[0.0, 3.1], speed=1.0, acceleration=0.0)):
        with pytest.raises(pp.SingularityError, match=r"two assemblies meet at crank angles of -50, 130 deg|.* of 130, 310 deg") as refused:
            prescribed()
        assert "change the link lengths" not in str(refused.value)


def five_bar(degrees):
    pins = {
        "A": [-170, 0],
        "B": [170, 0],
        "C": {"from": "A", "length": 70, "angle": 100},
        "D": {"from": "B", "length": 70, "angle": degrees},
        "E": {"C": 320, "D": 320, "side": "down"},
    }
    links = {
        "c1": {"pins": "A C", "mass": 5},
        "c2": {"pins": "B D", "mass": 5},
        "r1": {"pins": "C E", "mass": 5},
        "r2": {"pins": "D E", "mass": 5},
        "slide": {"pins": "E", "guide": "up", "mass": 50},
    }
    return {"units": "mm", "frame": "A B", "pins": pins, "links": links, "gears": {"B": "-A"}, "drive": "A"}


def test_a_symmetry_that_is_rounded_is_named():
    assert pp.build(**five_bar(80)).mobility == 1
    for degrees in (80.0001, 79.999):
        with pytest.raises(pp.PinpressError, match=r"mobility is 0.* looks like rounding; write equal and symmetrical lengths"):
            pp.build(**five_bar(degrees))
    with pytest.raises(pp.PinpressError, match="mobility is 0") as refused:
        pp.build(**five_bar(60))
    assert "rounding" not in str(refused.value)


def test_a_driver_that_locks_is_warned_of():
    """No Grashof linkage: the crank is a rocker, by the law of cosines between the poses in which coupler and rocker are in one line."""
    pins = {"A": [0, 0], "D": [400, 0], "B": {"from": "A", "length": 300, "angle": 60}, "C": {"B": 250, "D": 260, "side": "up"}}
    links = {"crank": {"pins": "A B", "mass": 1}, "coupler": {"pins": "B C", "mass": 3}, "rocker": {"pins": "D C", "mass": 1}}
    farthest = np.degrees(np.arccos((300**2 + 400**2 - 510**2) / (2 * 300 * 400)))
    with pytest.warns(pp.PinpressWarning, match=rf"it turns only from -.* to {farthest - 60:.4g}\d* deg, where the linkage locks"):
        press = pp.build(units="mm", frame="A D", pins=pins, links=links, drive="A")
    assert press.mobility == 1


@pytest.mark.parametrize("odd", ["\u202e", "\u2066", "\u200f", "\u0007", "\x85", "\u2028"])
@pytest.mark.parametrize("place", ["press", "link", "pin"])
def test_a_name_that_no_line_shows_is_refused(odd, place):
    """Characters that turn the line round, ring a bell or end it; joiners, which some scripts need, pass."""

    def table(character):
        named = f"x{character}y"
        table = FOUR_BAR | {"press": named if place == "press" else "x"}
        if place == "link":
            table |= {"links": {named: {"pins": "A B", "mass": 1}} | {k: v for k, v in FOUR_BAR["links"].items() if k != "ab"}}
        if place == "pin":
            table |= {"pins": FOUR_BAR["pins"] | {named: [1, 1]}}
        return table

    with pytest.raises(pp.PinTableError, match=f"has the character U\\+{ord(odd):04X}, which no line shows") as refused:
        draft(units="m", **table(odd))
    assert odd not in str(refused.value)
    assert draft(units="m", **table("\u200c")).name


SLIDER = (
    "units: mm\nframe: O\npins: {O: [0, 0], P: [0, -100], W: {P: 400, x: 0, side: down}}\ndrive: O\n"
    "links: {crank: {pins: O P, mass: 1}, rod: {pins: P W, mass: 1}, slide: {pins: W, guide: up, mass: 1}}\n"
)


def test_an_emoji_may_be_escaped_as_json_does(tmp_path):
    path = tmp_path / "press.yaml"
    path.write_text('press: "\\ud83d\\ude00 x"\n' + SLIDER, encoding="utf-8")
    assert draft(path).urdf.decode().count('<robot name="\U0001f600 x">') == 1
    path.write_text('press: "\\ud83d x"\n' + SLIDER, encoding="utf-8")
    with pytest.raises(pp.PinTableError, match=r"press.yaml:1: press: .* has half a character"):
        draft(path)


@pytest.mark.skipif(os.name == "nt", reason="all names of files are text there")
def test_the_name_of_a_file_need_not_be_utf_8(tmp_path):
    path = os.path.join(os.fsencode(tmp_path), b"odd\xff.yaml")
    try:
        with open(path, "w", encoding="utf-8") as file:
            file.write(SLIDER)
    except OSError:
        pytest.skip("this file system takes no such name")
    assert b"odd?.yaml" in draft(os.fsdecode(path)).urdf
    assert pp.build(os.fsdecode(path)).mobility == 1


def test_a_long_name_of_a_file_is_refused(tmp_path, capsys):
    """100 Chinese characters are 300 bytes, and a name may have 255."""
    table = tmp_path / "press.yaml"
    table.write_text(SLIDER, encoding="utf-8")
    assert main(["build", str(table), "--out", str(tmp_path / f"{'中' * 100}.urdf")]) == 2
    assert "cannot write" in capsys.readouterr().err


def test_a_shipped_press_may_be_a_base(tmp_path):
    path = tmp_path / "press.yaml"
    path.write_text("base: eccentric_blocks\npress: changed\n", encoding="utf-8")
    changed, shipped = pp.build(path), pp.build("eccentric_blocks")
    assert changed.name == "changed"
    assert [each.mass for each in changed.model.inertias] == [each.mass for each in shipped.model.inertias]


def test_a_decimal_comma_in_braces_is_named(tmp_path):
    path = tmp_path / "press.yaml"
    path.write_text(SLIDER.replace("{P: 400, x", "{P: 400,5 mm, x"), encoding="utf-8")
    with pytest.raises(pp.PinTableError, match="'5 mm' is no key here; write decimals after a point, not after a comma"):
        draft(path)
