"""What pin tables refuse and doubt, each with its message; the files of tests/mistakes have everyday mistakes."""

import os
import re
from typing import Any

import numpy as np
import pytest
from support.generators.pin_tables import FOUR_BAR, crank_slide, with_link
from support.mistakes import FOLDER, TABLE

import pinpress as pp
from pinpress.cli.main import main
from pinpress.pin_table.building import draft
from pinpress.pin_table.templates import template

RIGHT = TABLE.read_text(encoding="utf-8")
CRANK_SLIDE, TOGGLE, GUIDE_BAR = (template(name).decode() for name in ("crank-slide", "toggle", "guide-bar"))
SLIDER = (
    "units: mm\nframe: O\npins: {O: [0, 0], P: [0, -100], W: {P: 400, x: 0, side: down}}\ndrive: O\n"
    "links: {crank: {pins: O P, mass: 1}, rod: {pins: P W, mass: 1}, slide: {pins: W, guide: up, mass: 1}}\n"
)
LEVER_GEAR = {
    "units": "mm",
    "frame": "A A1",
    "pins": {"A": [0, 0], "A1": "A", "B": [70, 0], "C": {"B": 310, "z": 0, "side": "right"}},
    "links": {
        "crank": {"pins": "A B", "mass": 2},
        "ring": {"pins": "A1", "disc": "140 x 20", "mass": 8},
        "rod": {"pins": "B C", "mass": 3},
        "slide": {"pins": "C", "guide": "right", "mass": 5},
    },
    "drive": "A1",
}
LARGE = r"links: slide: .*1e\+300 is out of range: 1e\+12 is the largest number"
CARRIERS = "gears: {}: no link carries both axes (?=.*B is between crank and rod).* between frame and ring"


def changed(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new)


def four_bar(units: str = "m", scale: float = 1, more: Any = None, **changes: Any) -> dict[str, Any]:
    """The four-bar with other keys of its links, and pins or links more."""
    pins = {name: [scale * x, scale * z] for name, (x, z) in FOUR_BAR["pins"].items()} | changes.pop("pins", {})
    return FOUR_BAR | {"units": units, "pins": pins, "links": FOUR_BAR["links"] | (more or {})} | changes


def rack(gears: Any, units: str = "mm") -> dict[str, Any]:
    size = 40 if units == "mm" else 0.04
    links = {"pinion": {"pins": "O", "mass": 5}, "slide": {"pins": "Q", "guide": "up", "mass": 10}}
    return {"units": units, "frame": "O", "pins": {"O": [0, 0], "Q": [size, 0]}, "links": links, "gears": gears, "drive": "O"}


def trammels(degrees: float, second: float) -> dict[str, Any]:
    """A platform on two elliptic trammels, 0.36 m and twice ``second`` long. Both its ends go straight up: their lines are across it, so
    that its length holds the second trammel at second order only, wherever it is drawn."""
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


def five_bar(degrees: float) -> dict[str, Any]:
    pins = {
        "A": [-170, 0],
        "B": [170, 0],
        "C": {"from": "A", "length": 70, "angle": 100},
        "D": {"from": "B", "length": 70, "angle": degrees},
    }
    pins |= {"E": {"C": 320, "D": 320, "side": "down"}}
    links: dict[str, Any] = {name: {"pins": pins, "mass": 5} for name, pins in (("c1", "A C"), ("c2", "B D"), ("r1", "C E"), ("r2", "D E"))}
    links |= {"slide": {"pins": "E", "guide": "up", "mass": 50}}
    return {"units": "mm", "frame": "A B", "pins": pins, "links": links, "gears": {"B": "-A"}, "drive": "A"}


REFUSALS: list[tuple[Any, str]] = [  # the keys of a call or the text of a file, and the message
    ("a: &a [*a]", "the pin table is too large; write at most 20000 entries, 12 deep"),
    ("a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]", "'a' is no key here"),
    ("[1, 2]", "a list; write keys: units, frame, pins, links and drive"),
    ("- a\n- b", "a list; write keys"),
    ("? [a]\n: b", "a key is no single word; write a name before the colon"),
    ("%YAML 9", "it is no YAML"),
    ("a: !!python/name:os.system x", "'a' is no key here"),
    ('press: "\\ud83d x"\n' + SLIDER, "press.yaml:1: press: .* has half a character"),
    (changed(SLIDER, "{P: 400, x", "{P: 400,5 mm, x"), "'5 mm' is no key here; write decimals after a point, not after a comma"),
    (changed(CRANK_SLIDE, "frame: O", "frame: O W"), "slide: it slides in the frame, but its pin W is fixed in the frame; take W out of"),
    (changed(CRANK_SLIDE, "crank: {", "crank: {travel: [-1, 1], "), "crank has no guide; say where it slides"),
    *(
        (changed(TOGGLE, "[-80, 195]", travel), "links: piston: travel: .*" + re.escape(words))
        for travel, words in (
            ("20", "'20' is a text; write how far it slides"),
            ("[20]", "1 numbers; write the lowest and the highest"),
            ("[10, 20]", "it slides from 10 to 20; count from the drawn pose"),
            ("[0, 0]", "it slides from 0 to 0; count from the drawn pose"),
            ("[-20mm, 0]", "-20mm"),
        )
    ),
    *(
        (with_link("slide", guide=guide, mass=9), re.escape(words))
        for guide, words in (
            ("vertical", "no direction 'vertical'; write up, down, left, right, an angle, or two points"),
            ("upp", "no direction 'upp', did you mean 'up'?"),
            ("W", "the guide has one point, W; write up"),
            ([0, 1], "no pin 0; name some of O, P, W, or write up, down"),
        )
    ),
    *(
        (with_link("slide", **keys), LARGE)
        for keys in ({"mass": 1e300}, {"mass": 9, "inertia": 3 * [1e300]}, {"mass": 9, "com": [1e300, 0]}, {"box": "1e300 x 80 x 60"})
    ),
    (crank_slide(tool="Q"), "tool: no pin Q; name a pin or a point of `pins`"),
    (crank_slide(tool=[1, 2, 3]), r"tool: 3 numbers found; a point is \[x, z\]"),
    (crank_slide(tool="P", links={"crank": {"pins": "O P", "mass": 40}}), "tool: no link is the slide; guide one link by the frame"),
    (crank_slide(turns="cw"), "'cw' is not a sense of rotation.*; write clockwise or counter-clockwise"),
    (crank_slide(drive="-O"), "-O has a sign.*; write O; .* turns: clockwise, or .* a negative speed"),
    (crank_slide(crank=-100), "pins: P: length: a length of -100; write 100, and turn the angle by 180"),
    *(
        (with_link("crank", **{key: value}) | {"masses": "none"}, f"links: crank: {key}: {key} of a link without mass; give its mass")
        for key, value in (("com", [30, 0]), ("inertia", 0.1), ("gyration", 40), ("density", 2700))
    ),
    (
        four_bar(pins={"B1": "B", "B2": "B"}, more={"piece": {"pins": "B B1 B2", "mass": 3}}),
        "links: piece: pins: B and B1 and B2 are one point",
    ),
    *(
        (four_bar(parameters={"r": text}), "is not a number")  # Python reads some of these as numbers, and warns of others
        for text in ("0x10", "0144", "1_000", "3j", "7in", "1e", "0b11", "2 * 0x10", "1.2.3", "٣")
    ),
    # a gear on a rod and a ring in the frame: coordinates of joints are not what teeth couple
    (LEVER_GEAR | {"gears": {"A1": "0.4 * B"}}, CARRIERS.format("A1")),
    (LEVER_GEAR | {"gears": {"B": "2.5 * A1"}}, CARRIERS.format("B")),
    (LEVER_GEAR | {"gears": {"B": "-A1"}}, CARRIERS.format("B")),
    *(
        (trammels(degrees, second), r"^(?!.*further on).*only at second order, .* it is shaky.* another pose does not help")
        for degrees in (20.0, 42.0, 65.0)
        for second in (180.0, 200.0)
    ),
    *(
        (five_bar(degrees), "mobility is 0.*; it misses moving by little: 0.1 rad further, loop .* stays open by .* mm")
        for degrees in (85.0, 75.0)
    ),
    (five_bar(60), "^(?!.*rounding).*mobility is 0"),
]


def path_of(text: str, folder: Any) -> Any:
    path = folder / "press.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(("table", "message"), REFUSALS, ids=[message[:40] for _, message in REFUSALS])
def test_refusals(table, message, tmp_path):
    with pytest.raises(pp.PinpressError, match=message):
        pp.build(path_of(table, tmp_path)) if isinstance(table, str) else pp.build(**table)


PARAMETERS = [
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
]


@pytest.mark.parametrize(("values", "message"), PARAMETERS)
def test_refused_parameters(values, message, tmp_path):
    path = path_of(changed(GUIDE_BAR, "{from: A, length: r, angle: 0}", "{A: r, x: 100, side: up}"), tmp_path)
    with pytest.raises(pp.PinpressError, match=re.escape(message)):
        pp.build(path, **values)


DOUBTS: list[tuple[Any, str]] = [  # the keys of a call or the text of a file, and the warning
    (
        "units: mm\nframe: O\npins: {O: [0, 0], P: [0, -0.1], W: [0, -0.5]}\nmasses: none\n"
        "links: {crank: {pins: O P}, rod: {pins: P W}, slide: {pins: W, guide: up}}\ndrive: O\n",
        "largest distance is 0.5 mm; is it units: m",
    ),
    *(
        (text, f"density: {re.escape(f'{float(density):g}')} kg/m3 is not the density of a solid part")
        for density in ("7.85", "7.85e-6", "7850000")  # in g/cm3, kg/mm3 and g/m3, of a link and of the whole table
        for text in (RIGHT.replace("overhang: 90", f"overhang: 90, density: {density}"), f"{RIGHT}density: {density}\n")
    ),
    *(
        (four_bar("mm", 10, {"ab": {"pins": "A B"} | keys}), r"links: ab: mass: 1.2e\+07 kg in .*: no material is that dense. Write kg")
        for keys in ({"mass": 12e6}, {"mass": 12e6, "section": "40 x 40"})
    ),
    *(
        (rack(gears), r"gears: \w+: O moves slide_guide by 40 m/rad: .* 0.04 m/rad for 40 mm")
        for gears in ({"slide_guide": "40 * O"}, {"slide_guide": "-40 * O"}, {"O": "0.025 * slide_guide"})
    ),
    (crank_slide(masses="none"), "masses: masses: none has no effect, because every link has a mass"),
    *(
        (with_link("rod", density=2700, **keys), "links: rod: density: density has no effect, because the mass is given")
        for keys in ({"mass": 15}, {"mass": 15, "section": "40 x 40"})
    ),
]


@pytest.mark.parametrize(("table", "message"), DOUBTS)
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_doubts(table, message, tmp_path):
    with pytest.warns(pp.PinpressWarning, match=message):
        draft(path_of(table, tmp_path)) if isinstance(table, str) else draft(**table)


def test_an_exact_symmetry_moves():
    """The five-bar of the refusals with the angle that makes it symmetrical."""
    assert pp.build(**five_bar(80)).mobility == 1


@pytest.mark.exhaustive
def test_estimated_moments_of_inertia_are_not_doubted_but_given_ones():
    """Coordinates in metres taken for mm: only the size is odd, and the moments of inertia follow from it."""
    with pytest.warns(pp.PinpressWarning) as caught:
        press = draft(**four_bar("mm"))
    assert not any("moments of inertia" in str(each.message) for each in caught)
    assert not [each for each in press.check().findings if "moments of inertia" in each.remedy]
    with pytest.warns(pp.PinpressWarning, match='<link name="ab">: with 1000 kg .* write moments of inertia in kg m2'):
        pp.build(**four_bar(more={"ab": {"pins": "A B", "mass": 1000, "inertia": 1e-4}}))


@pytest.mark.parametrize("place", ["press", "link", "pin"])
def test_a_name_that_no_line_shows_is_refused(place):
    """Characters that turn the line round, ring a bell or end it. Joiners, which some scripts need, pass."""

    def named(name):
        bar = {"pins": "A B", "mass": 1}
        changes = {"press": {"press": name}, "link": {"more": {name: bar, "ab": bar}}, "pin": {"pins": {name: [1, 1]}}}
        return four_bar(**changes[place])

    for odd in ("\u202e", "\u2066", "\u200f", "\u0007", "\x85", "\u2028"):
        with pytest.raises(pp.PinTableError, match=f"has the character U\\+{ord(odd):04X}, which no line shows") as refused:
            draft(**named(f"x{odd}y"))
        assert odd not in str(refused.value)
    assert draft(**named("x\u200cy")).name


@pytest.mark.parametrize("mistake", ["lengths-too-short-to-meet", "length-that-does-not-reach-the-line"])
def test_lengths_that_do_not_meet_are_drawn(mistake):
    with pytest.raises(pp.PinTableError) as caught:
        pp.build(FOLDER / f"{mistake}.yaml")
    assert caught.value.sketch is not None
    assert caught.value.sketch.count("<circle") > len(caught.value.element.split())
    assert ("<line" in caught.value.sketch) == mistake.endswith("line")


def test_a_change_point_is_no_lock_and_its_lengths_are_right():
    def parallelogram(angle):
        pins = {"A": [0, 0], "D": [350, 0], "B": {"from": "A", "length": 90, "angle": angle}, "C": {"from": "B", "at": [350, 0]}}
        links = {"crank": {"pins": "A B", "mass": 1}, "coupler": {"pins": "B C", "mass": 3}, "follower": {"pins": "D C", "mass": 1}}
        return pp.build(units="mm", frame="A D", pins=pins, links=links, drive="A")

    with pytest.raises(pp.SingularityError, match="draw the linkage a little further on"):
        parallelogram(0)
    press = parallelogram(50)
    for prescribed in (lambda: pp.cycle(press, speed=1.0), lambda: pp.servo_cycle(press, angle=[0.0, 3.1], speed=1.0, acceleration=0.0)):
        with pytest.raises(pp.SingularityError, match=r"two assemblies meet at crank angles of -50, 130 deg|.* of 130, 310 deg") as refused:
            prescribed()
        assert "change the link lengths" not in str(refused.value)


# Files


def test_what_is_no_table_is_refused_with_its_remedy(tmp_path, capsys):
    """A URDF is refused in a shell too, where it is not taken for a file that would be written over. 100 Chinese characters are 300 bytes,
    and a file's name may have 255."""
    with pytest.raises(pp.PinpressError, match=r"write build\(\*\*table\)"):
        pp.build({"units": "mm"})
    table, urdf = path_of(CRANK_SLIDE, tmp_path), tmp_path / "press.urdf"
    with pytest.raises(pp.PinTableError, match=r"No such file or directory, did you mean 'press\.yaml'\?; give the path of a pin table"):
        pp.build(tmp_path / "press.yml")
    urdf.write_bytes(pp.build(table).text)
    with pytest.raises(pp.PinTableError, match=r"this is not a pin table; pp.load\(path\)"):
        pp.build(urdf)
    for arguments, message in (
        ([urdf], "is no table of pins"),
        ([table, "--out", f"{'中' * 100}.urdf"], "cannot write"),
    ):
        assert main(["build", *map(str, arguments)]) == 2
        assert message in capsys.readouterr().err
    with pytest.raises(pp.UrdfError, match=r"pres\.urdf: cannot be read: No such file or directory, did you mean 'press\.urdf'\?"):
        pp.load(tmp_path / "pres.urdf")
    with pytest.raises(pp.UrdfError, match=r"no such file, did you mean 'press\.urdf'\?; name a URDF file"):
        pp.load(tmp_path / "pressurdf")


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


def test_scalars_are_what_they_look_like(tmp_path):
    """Pins may be called NO or 1, 1e2 is a number, an emoji may be escaped as JSON does, and plain decimals are read."""
    text = re.sub(r"\bO\b", "NO", CRANK_SLIDE).replace(" P:", " 1:").replace("O P", "O 1").replace("P W", "1 W").replace("{P: l", "{1: l")
    press = pp.build(path_of(text.replace("mass: 100", "mass: 1e2"), tmp_path))
    assert {"NO", "1"} < {*press.joints}
    assert '<robot name="\U0001f600 x">' in draft(path_of('press: "\\ud83d\\ude00 x"\n' + SLIDER, tmp_path)).urdf.decode()
    for text, value in (("1e5", 1e5), ("1.5E-3", 1.5e-3), (".5 + 00.5", 1.0), ("2*(1.)-0", 2.0)):
        assert draft(**four_bar(more={"ab": {"pins": "A B", "mass": text}})).links[0].mass == value


def test_a_shipped_press_may_be_a_base(tmp_path):
    changed_press, shipped = pp.build(path_of("base: eccentric_blocks\npress: changed\n", tmp_path)), pp.build("eccentric_blocks")
    assert changed_press.name == "changed"
    assert [each.mass for each in changed_press.model.inertias] == [each.mass for each in shipped.model.inertias]
