"""Presses from pin tables: against their URDFs, closed forms of plain bodies, and whatever the order in which a table is written."""

import math
import random
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from support.exploring import examples
from support.generators.pin_tables import FOUR_BAR, MASSLESS, crank_slide, with_link
from support.mistakes import TABLE

import pinpress as pp
from pinpress.pin_table import draft
from pinpress.pin_table.templates import TEMPLATES, template
from pinpress.visual.shapes.appearance import bodies

URDF = Path(__file__).resolve().parents[2] / "urdf"
TURN = 60 * pp.RPM
SIX_BAR = yaml.load((URDF / "zxn2_3000b.yaml").read_text(encoding="utf-8"), Loader=yaml.BaseLoader)


def reactions(press: pp.Linkage, points: int = 72) -> pp.Reactions:
    return pp.inverse_dynamics(press, pp.cycle(press, speed=TURN, points=points))


@pytest.mark.parametrize("name", pp.presses())
def test_shipped_tables_and_urdfs_are_one_press(name):
    """Motion, torque, every bearing force with its name and sign, and the moments on the foundation, which feel where masses stand."""
    built, loaded = reactions(pp.build(URDF / f"{name}.yaml")), reactions(pp.load(name))
    assert np.abs(built.motion.slide_position - loaded.motion.slide_position).max() < 1e-14
    assert np.abs(built.driving_torque - loaded.driving_torque).max() < 5e-14 * np.abs(loaded.driving_torque).max()
    largest = max(np.abs(force).max() for force in loaded.bearing_force.values())
    assert np.abs(built.shaking_moment - loaded.shaking_moment).max() < 5e-14 * largest * loaded._press.size
    assert list(built.bearing_force)
    assert set(built.bearing_force) == set(loaded.bearing_force)
    for bearing, force in loaded.bearing_force.items():
        assert np.abs(built.bearing_force[bearing] - force).max() < 1e-14 * largest


# Strokes of the table's presses, computed by other means (a prototype with its own dyads) to the digits given [mm].
STROKES = {
    "crank-slide": 200.0,
    "knuckle": 122.062,
    "link-drive": 239.004,
    "drawing-8-bar": 417.970,
    "eccentric-block": 50.000,
    "guide-bar": 400.0,
    "hypocycloid": 200.0,
    "rssp": 160.395,
}


def toggle_slide(travel):
    """Position of the slide of the toggle by the law of cosines in the triangle of its upper pin, the cylinder's trunnion and the knee."""
    trunnion, knee = np.array([-0.9, -0.12]), 0.3 * np.array([math.cos(math.radians(-130)), math.sin(math.radians(-130))])
    frame, cylinder = math.hypot(*trunnion), math.dist(trunnion, knee) + travel
    angle = math.atan2(*trunnion[::-1]) + np.arccos((frame**2 + 0.3**2 - cylinder**2) / (2 * frame * 0.3))
    return 0.3 * np.sin(angle) - np.sqrt(0.34**2 - (0.3 * np.cos(angle)) ** 2)


def test_the_blow_of_the_screw_press(tmp_path):
    """Thread and collar make an arm of the force, another one as the slide drives; the die takes what is left of the energy."""
    path = tmp_path / "screw.yaml"
    path.write_bytes(template("screw"))
    job = pp.job(path, **{"run.points": 2000, "run.duration": 0.75})
    (die,), run = job.loads.values(), job.simulate()
    inertia, mass, weight, per_radian, fall = 780.0, 2400.0, 2400 * 9.81, 0.22 / (2 * math.pi), 0.38
    lead = math.atan(0.22 / (math.pi * 0.3))
    rho, collar = math.atan(0.05 / math.cos(math.atan(math.tan(math.radians(15)) * math.cos(lead)))), 0.05 * 0.17
    driven, pressing = 0.15 * math.tan(lead - rho) - collar, 0.15 * math.tan(lead + rho) + collar
    hit = job.sections["run"]["speed"]["S"] ** 2 + 2 * fall / per_radian * weight * driven / (inertia + mass * per_radian * driven)
    hit += weight**2 / die.stiffness / per_radian * driven / (inertia + mass * per_radian * driven)  # until the die carries the weight
    energy = 0.5 * per_radian / pressing * (inertia + mass * per_radian * pressing) * hit
    largest = weight + math.sqrt(2 * die.stiffness * energy)
    assert die.stiffness * (-1.28 - run.slide_position.min()) == pytest.approx(largest, rel=1e-5)  # states are 0.4 ms apart


@pytest.mark.parametrize("name", [name for name in TEMPLATES if name != "screw"])
def test_templates_are_presses(name, tmp_path):
    path = tmp_path / f"{name}.yaml"
    path.write_bytes(template(name))
    press = pp.build(path)
    if name == "toggle":
        motion = pp.cycle(press, speed=0.05, points=40)
        np.testing.assert_allclose(motion.slide_position, toggle_slide(motion.crank_angle), rtol=0, atol=1e-13)
        assert (press.drivers, motion.crank_angle.min(), motion.crank_angle.max()) == (("cylinder",), -0.08, 0.195)
    else:
        motion = pp.cycle(press, speed=TURN, points=360)
        assert np.ptp(motion.slide_position) * 1e3 == pytest.approx(STROKES[name], abs=0.6 if name == "guide-bar" else 6e-3)
    found = pp.inverse_dynamics(press, motion)
    assert np.abs(found.power_residual).max() < 1e-13


def test_parameters_change_the_press(tmp_path):
    path = tmp_path / "press.yaml"
    path.write_bytes(template("crank-slide"))
    for r in (100, "80 + 40", 120.0):
        stroke = np.ptp(pp.cycle(pp.build(path, r=r), speed=TURN, points=4).slide_position)
        assert stroke == pytest.approx(2 * (100 if r == 100 else 120) / 1e3, rel=1e-12)


def test_in_a_call_as_in_a_file():
    """Numbers in place of texts, lists in place of words, and no file at all."""
    table = crank_slide()
    table["links"]["crank"]["pins"] = ["O", "P"]
    ours, theirs = reactions(pp.build(**table)), reactions(pp.load("crank_slide"))
    assert np.abs(ours.driving_torque - theirs.driving_torque).max() < 1e-14 * np.abs(theirs.driving_torque).max()


@pytest.mark.one_in(8)
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", ["knuckle", "drawing-8-bar", "eccentric-block", "guide-bar", "hypocycloid"])
def test_any_order_is_the_same_press(name, seed, tmp_path):
    """Torque and forces, these up to the sense in which they are given."""
    table = yaml.load(template(name), Loader=yaml.BaseLoader)
    shuffled = random.Random(seed)
    for key in ("pins", "links"):
        items = list(table[key].items())
        shuffled.shuffle(items)
        table[key] = dict(items)
    path = tmp_path / "press.yaml"
    path.write_bytes(template(name))
    ours, theirs = reactions(pp.build(**table), 24), reactions(pp.build(path), 24)
    assert np.abs(ours.driving_torque - theirs.driving_torque).max() < 2e-13 * np.abs(theirs.driving_torque).max()
    largest = max(np.abs(force).max() for force in theirs.bearing_force.values())
    for bearing, force in theirs.bearing_force.items():
        if bearing in ours.bearing_force:
            given_as = ours.bearing_force[bearing]
            assert min(np.abs(given_as - force).max(), np.abs(given_as + force).max()) < 2e-13 * largest


@examples(90)
@given(st.floats(-180, 180), st.floats(-180, 180), st.floats(0.2, 3.0), st.floats(0.2, 3.0))
def test_pins_are_where_their_lengths_say(one, two, first, second):
    """Two lengths, a length and a line, and angles from rays: measured again from the places."""
    pins = {"A": [10, 20], "B": {"from": "A", "length": 100, "angle": one}, "C": {"from": "A B", "length": 70, "angle": two}}
    placed = draft(**crank_slide(pins=crank_slide()["pins"] | pins)).pins
    a, b, c = (placed[name].point[[0, 2]] for name in "ABC")
    assert np.linalg.norm(b - a) == pytest.approx(0.1)
    assert np.linalg.norm(c - a) == pytest.approx(0.07)
    turned = np.degrees(np.angle(complex(*(c - a)) / complex(*(b - a))))
    assert (turned - two + 180) % 360 - 180 == pytest.approx(0, abs=1e-9)
    if abs(first - second) * 101 < 100 < (first + second) * 99:  # they meet, and not in one point
        for side in ("ccw", "cw"):
            more = pins | {"D": {"A": first * 100, "B": second * 100, "side": side}}
            d = draft(**crank_slide(pins=crank_slide()["pins"] | more)).pins["D"].point[[0, 2]]
            assert np.linalg.norm(d - a) == pytest.approx(first / 10)
            assert np.linalg.norm(d - b) == pytest.approx(second / 10)
            assert ((b - a)[0] * (d - a)[1] > (b - a)[1] * (d - a)[0]) == (side == "ccw")


def link_of(name: str, table):
    """A link as the table draws it."""
    return next(link for link in draft(**table).links if link.name == name)


@pytest.mark.parametrize(
    ("crank", "mass", "centre", "inertia"),
    [
        ({"mass": 12}, 12, (0, -0.05), 12 * 0.1**2 / 12),
        ({"mass": 12, "gyration": 40}, 12, (0, -0.05), 12 * 0.04**2),
        ({"mass": 12, "com": "P", "inertia": 0.3}, 12, (0, -0.1), 0.3),
        ({"mass": 12, "com": "P", "inertia": {"O": 0.3}}, 12, (0, -0.1), 0.3 - 12 * 0.1**2),
        ({"mass": 12, "com": [20, 5], "inertia": 0.3}, 12, (0.005, -0.02), 0.3),
        ({"section": "60 x 40"}, 7850 * 0.1 * 0.06 * 0.04, (0, -0.05), 7850 * 0.1 * 0.06 * 0.04 * (0.1**2 + 0.06**2) / 12),
        ({"section": [60, 40], "overhang": 20, "mass": 9}, 9, (0, -0.05), 9 * (0.14**2 + 0.06**2) / 12),
        ({"disc": "80 x 50"}, 7850 * np.pi * 0.08**2 * 0.05, (0, 0), 7850 * np.pi * 0.08**4 * 0.05 / 2),
        ({"disc": "80 x 50", "density": 1000, "com": "P"}, 1000 * np.pi * 0.08**2 * 0.05, (0, -0.1), 1000 * np.pi * 0.08**4 * 0.05 / 2),
        ({"mass": 3, "com": "P", "inertia": 0.1, "parts": [{"mass": 1, "at": "O"}]}, 4, (0, -0.075), 0.1 + 3 * 0.025**2 + 0.075**2),
    ],
)
def test_masses_are_those_of_plain_bodies(crank, mass, centre, inertia):
    link = link_of("crank", with_link("crank", **crank))
    assert link.mass == pytest.approx(mass, rel=1e-14)
    assert link.centre[[0, 2]] == pytest.approx(centre, abs=1e-15)
    assert link.inertia[1, 1] == pytest.approx(inertia, rel=1e-12)


def test_a_plate_is_a_triangle_of_its_pins():
    """About its centroid m (a2 + b2 + c2) / 36."""
    table = SIX_BAR | {"links": SIX_BAR["links"] | {"rocker": {"pins": "D C E", "mass": "100"}}}
    rocker, pins = link_of("rocker", table), draft(**table).pins
    corners = [pins[name].point for name in "DCE"]
    sides = sum(float((p - q) @ (p - q)) for p, q in zip(corners, [*corners[1:], corners[0]], strict=True))
    assert rocker.centre == pytest.approx(np.mean(corners, axis=0), abs=1e-15)
    assert rocker.inertia[1, 1] == pytest.approx(100 * sides / 36, rel=1e-12)


def test_a_plate_of_four_pins_is_two_triangles():
    """A rectangle 200 x 300 with a fifth pin inside: m (a2 + b2) / 12 about its middle."""
    pins = {"A": [0, 0], "B": [200, 0], "C": [200, 300], "D": [0, 300], "E": [90, 100]}
    plate = {"pins": "A B C D E", "mass": 12, "parts": [{"mass": 1e-12, "at": "A"}]}
    link = link_of("plate", with_link("plate", **plate) | {"pins": crank_slide()["pins"] | pins, "frame": "O A B"})
    assert link.centre == pytest.approx([0.1, 0, 0.15], abs=1e-12)
    assert link.inertia[1, 1] == pytest.approx(12 * (0.2**2 + 0.3**2) / 12, rel=1e-9)


def test_pins_at_one_point_count_once():
    """A crank with the shaft of a gear at its own: m l2 / 12 of a rod."""
    pins = FOUR_BAR["pins"] | {"A1": "A"}
    links = FOUR_BAR["links"] | {"ab": {"pins": "A A1 B", "mass": 3}, "wheel": {"pins": "A1", "disc": "0.1 x 0.1"}}
    link = link_of("ab", FOUR_BAR | {"units": "m", "pins": pins, "links": links, "frame": "A D A1", "gears": {"A1": "2 * A"}})
    assert link.inertia[1, 1] == pytest.approx(3 * (2.9**2 + 3.6**2) / 12, rel=1e-12)
    assert link.centre == pytest.approx([2.85, 0, 2.1])


def test_without_masses_the_forces_of_loads_remain():
    """A crank-slide at 30 deg that holds 1 kN by its torque: the closed form of a massless one."""
    press = pp.build(**crank_slide(masses="none", links=MASSLESS), gravity=(0, 0, 0))
    motion = pp.servo_cycle(press, angle=[np.pi / 6], speed=[0.0], acceleration=[0.0])
    loads = [pp.loads.PointForce("slide", (0, 0, 1000.0))]
    torque = pp.inverse_dynamics(press, motion, loads=loads).driving_torque[0]
    angle, ratio = np.pi / 6, 0.25
    lever = 0.1 * (np.sin(angle) + ratio * np.sin(angle) * np.cos(angle) / np.sqrt(1 - (ratio * np.sin(angle)) ** 2))
    assert abs(torque) == pytest.approx(1000 * lever, rel=1e-9)


def test_a_mass_that_is_given_counts_beside_masses_none():
    """The shaking force of a crank-slide whose slide alone has a mass, m (g + acceleration) in closed form; the others weigh 1 mg, which is
    below a thousandth of a newton."""
    r, rod, mass, speed = 0.055, 0.21, 3.5, 30.0
    table = crank_slide(55, 210, masses="none", links=MASSLESS | {"slide": MASSLESS["slide"] | {"mass": mass}})
    motion = pp.cycle(press := pp.build(**table), speed=speed, points=72)
    s, c = np.sin(motion.crank_angle), np.cos(motion.crank_angle)
    root = np.sqrt(rod**2 - (r * s) ** 2)
    upwards = speed**2 * (r * c + r**2 * (c**2 - s**2) / root + r**4 * (s * c) ** 2 / root**3)
    np.testing.assert_allclose(pp.inverse_dynamics(press, motion).shaking_force[:, 2], -mass * (9.81 + upwards), rtol=0, atol=1e-3)
    assert dict(draft(**table).estimates())["rod"] == "a mass of 1 mg, as masses: none says"
    assert not any("1 mg" in words for link, words in draft(**table).estimates() if link == "slide")


def test_parts_count_beside_masses_none():
    """A point mass welded on a crank without mass: its weight at its radius is the torque in the drawn pose."""
    crank = {"pins": "O P", "parts": [{"mass": 7, "at": [30, 40]}]}
    press = pp.build(**crank_slide(masses="none", links=MASSLESS | {"crank": crank}))
    still = pp.servo_cycle(press, angle=[0.0], speed=[0.0], acceleration=[0.0])
    assert pp.inverse_dynamics(press, still).driving_torque[0] == pytest.approx(7 * 9.81 * 0.04, abs=1e-4)  # x of the crank points down


def test_the_density_of_a_link_is_that_of_its_cube():
    """A slide of which only mass and density are given: m a2 / 6 of a cube of aluminium."""
    slide = link_of("slide", with_link("slide", mass=100, density=2700))
    assert slide.inertia[1, 1] == pytest.approx(100 * (100 / 2700) ** (2 / 3) / 6, rel=1e-12)


@pytest.mark.parametrize(
    ("rod", "said"),
    [
        ({"mass": 15, "section": "40 x 40"}, "moments of inertia of its section, with the mass that is given"),
        ({"inertia": 0.2, "section": "40 x 40"}, "mass of its section of 7850 kg/m3, 5.024 kg; its moment of inertia is given"),
        ({"com": [100, 0], "section": "40 x 40"}, "moments of inertia of its section about its middle, taken about com"),
    ],
)
def test_what_a_mixture_leaves_to_be_estimated_is_listed(rod, said):
    assert [words for link, words in draft(**with_link("rod", **rod)).estimates() if link == "rod"] == [said]


def test_copies_share_what_one_carried():
    """Two rods of half the mass side by side carry half the force each; four points are two steps."""
    whole = reactions(pp.build(**crank_slide()))
    half, copies = with_link("rod", mass=7.5), [{"links": "rod", "y": [-200, 200], "names": "_front _back"}]
    split = reactions(pp.build(**half, copies=copies))
    assert split.driving_torque == pytest.approx(whole.driving_torque, rel=1e-12)
    for side in ("_front", "_back"):
        assert split.bearing_force[f"P{side}"] == pytest.approx(whole.bearing_force["P"] / 2, abs=1e-9)
    twice = [*copies, {"links": "rod_front rod_back", "x": [-5, 5], "names": "_left _right"}]
    assert len(draft(**half, copies=twice).parts.links) == 6


def test_a_mirrored_half_turns_the_other_way():
    table = yaml.load((URDF / "jf75g_125_symmetric.yaml").read_text(encoding="utf-8"), Loader=yaml.BaseLoader)
    assert table["copies"][0]["mirror"] == "x"
    press = pp.build(URDF / "jf75g_125_symmetric.yaml")
    shaking = reactions(press).shaking_force
    assert np.abs(shaking[:, 0]).max() < 1e-9 * np.abs(shaking[:, 2]).max()


@pytest.mark.exhaustive
def test_a_mirrored_crank_in_space_is_the_image_of_the_other():
    """Two cranks about x, one the mirror image of the other, geared: their slides move alike."""
    pins = {
        "O": {"x": 30, "y": 0, "z": 0, "axis": "x"},
        "B": {"x": 90, "y": -80, "z": 0, "joint": "ball"},
        "S": {"x": 180, "y": 30, "z": -420, "joint": "ball"},
    }
    made = {
        "crank": {"pins": "O B", "mass": 12, "com": {"x": 30, "y": -30}, "inertia": [0.04, 0.03, 0.05]},
        "rod": {"pins": "B S", "mass": 6},
        "slide": {"pins": "S", "guide": "up", "mass": 60},
    }
    copies = [{"links": "crank rod slide", "mirror": "x", "names": "_left _right", "gear": "O"}]
    press = draft(units="mm", frame="O", pins=pins, links=made, drive="O", copies=copies).press()
    motion = pp.cycle(press, speed=TURN, points=12)
    left, right = (motion.joint_position[:, press.joints.index(f"slide_guide{side}")] for side in ("_left", "_right"))
    assert np.ptp(left) > 0.1
    assert right == pytest.approx(left, abs=1e-12)


@pytest.mark.exhaustive
@pytest.mark.filterwarnings("ignore:Conversion of an array:DeprecationWarning")  # of yourdfpy 0.0.56
def test_what_is_written_is_a_urdf_for_others(tmp_path):
    """Read by yourdfpy and Pinocchio: links, masses and shapes; loaded by us, the same forces."""
    import pinocchio as pin
    import yourdfpy

    drawn = draft(URDF / "zxn2_3000b.yaml")
    path = tmp_path / "press.urdf"
    path.write_bytes(drawn.urdf)
    robot = yourdfpy.URDF.load(str(path), load_meshes=False)
    assert [*robot.link_map] == ["frame", "crank", "coupler", "rocker", "rod", "slide"]
    assert all(robot.link_map[name].visuals for name in robot.link_map if name != "frame")
    assert sum(inertia.mass for inertia in pin.buildModelFromUrdf(str(path)).inertias) == pytest.approx(
        sum(float(link["mass"]) for link in SIX_BAR["links"].values()), rel=1e-12
    )
    loaded = pp.load(path)
    assert not any(body.drawn for body in bodies(loaded, loaded.closed[None]))  # its shapes are made up anew
    path.write_bytes(drawn.urdf.replace(b'<visual name="stand_in">', b"<visual>", 1))  # one that somebody has changed stays
    assert [body.name for body in bodies(pp.load(path), loaded.closed[None]) if body.drawn] == ["frame"]
    torque = reactions(loaded).driving_torque
    assert torque == pytest.approx(reactions(drawn.press()).driving_torque, rel=1e-14)
    assert b"A: frame on crank" in drawn.urdf


def test_bases_are_laid_under(tmp_path):
    """Pins and keys of links are replaced, ``none`` removes; a base that leads back is refused."""
    (tmp_path / "base.yaml").write_bytes(template("crank-slide"))
    (tmp_path / "press.yaml").write_text("base: base.yaml\nlinks: {rod: {section: none, overhang: none, mass: 15}}\nparameters: {r: 90}\n")
    drawn = draft(tmp_path / "press.yaml")
    assert drawn.parts.links[1].mass == 15
    assert np.linalg.norm(drawn.pins["P"].point) == pytest.approx(0.09)
    (tmp_path / "base.yaml").write_text("base: press.yaml\n")
    with pytest.raises(pp.PinTableError, match="the tables name each other as base"):
        pp.build(tmp_path / "press.yaml")


def test_sketches_are_drawings():
    """Every pin and length of the six-bar by its number; XML that a browser shows."""
    from xml.etree import ElementTree

    sketch = draft(URDF / "zxn2_3000b.yaml").sketch
    for rule in re.findall(r"([^{}>]+)\{", sketch):  # or it would style the other drawings of a notebook
        assert rule.startswith(".pinpress-sketch ")
    words = {each.text for each in ElementTree.fromstring(sketch).iter("{http://www.w3.org/2000/svg}text")}
    assert {"A", "B", "C", "D", "E", "F", "143", "1243", "375", "480", "crank", "slide"} <= words


def test_a_plate_shows_all_its_lengths_of_the_table():
    pins = {
        "O": [0, 0],
        "G": [-620, -250],
        "P": [0, 125],
        "Q": {"P": 520, "G": 430, "side": "left"},
        "R": {"P": 380, "Q": 330, "side": "down"},
    }
    links = {"crank": {"pins": "O P"}, "plate": {"pins": "P Q R"}, "rocker": {"pins": "G Q"}}
    sketch = draft(units="mm", frame="O G", pins=pins, links=links, drive="O", masses="none").sketch
    assert re.findall(r'class="dimension">([^<]*)', sketch) == ["125", "520", "380", "330", "430"]


@pytest.mark.exhaustive
@pytest.mark.filterwarnings("ignore:.*pin M is not in the frame")
def test_a_screw_on_geared_spindles_turns_metres_into_radians(tmp_path):
    """The same toggle, its knee pushed by a nut: the driver is the spindle in the barrel, geared to the guide by its lead."""
    text = template("toggle").replace(b"drive: cylinder", b"gears: {cylinder: 0.02/(2*pi) * M}\ndrive: M")
    text = text.replace(b"  U: [0, 0]", b"  U: [0, 0]\n  M: [-1000, 200]").replace(b"{pins: G,", b"{pins: G M,")
    path = tmp_path / "press.yaml"
    path.write_bytes(text.replace(b"links:", b"links:\n  spindle: {pins: M, mass: 3, inertia: 0.01}", 1))
    press = pp.build(path)
    motion = pp.servo_cycle(press, angle=np.linspace(-20, 51, 8), speed=0.0, acceleration=0.0)
    np.testing.assert_allclose(motion.slide_position, toggle_slide(np.linspace(-20, 51, 8) * 0.02 / (2 * np.pi)), rtol=0, atol=1e-12)


def test_a_planet_rolls_in_a_fixed_ring():
    """Cardan's gears, a ring of twice the planet's size: the crank carries both, so that -80 (0 - crank) + 40 (planet - crank) = 0, and a
    pin of the planet as far out as the crank is long goes along a straight line, 2 a cos(crank) from the centre."""
    press = pp.build(
        units="mm",
        frame="A",
        pins={"A": [0, 0], "B": [100, 0], "S": [200, 0], "W": {"S": 500, "x": 0, "side": "down"}},
        links={
            "crank": {"pins": "A B", "mass": 4},
            "planet": {"pins": "B S", "mass": 2},
            "rod": {"pins": "S W", "mass": 3},
            "slide": {"pins": "W", "guide": "up", "mass": 20},
        },
        gears={"B": "-2 * A"},
        drive="A",
    )
    motion = pp.cycle(press, speed=1.0, points=36)
    across = 0.2 * np.cos(motion.crank_angle)
    np.testing.assert_allclose(motion.slide_position, -np.sqrt(0.5**2 - across**2), rtol=0, atol=1e-14)


def test_what_is_not_given_is_listed(tmp_path):
    path, right, toggle = tmp_path / "press.yaml", TABLE.read_text(encoding="utf-8"), template("toggle").decode()
    path.write_text(right.replace(", com: [56.7, 0]", "").replace(", com: [-8.6, -3.8]", ""), encoding="utf-8")
    estimates = dict(draft(path).estimates())
    assert estimates["crank"] == "centre of mass half-way from A to B"
    assert estimates["rocker"] == "centre of mass of a flat plate with its corners at the pins"
    for text, links in ((toggle, []), (toggle.replace("travel: [-80, 195], ", ""), ["piston"])):
        path.write_text(text, encoding="utf-8")
        assert [link for link, words in draft(path).estimates() if "give travel" in words] == links


@pytest.mark.parametrize(("units", "size"), [("mm", 40), ("m", 0.04)])
def test_a_geared_guide_ends_nowhere(units, size):
    """0.04 m per radian: ten turns are 2.5 m, and no limit stands in the way that nobody wrote."""
    links = {"pinion": {"pins": "O", "mass": 5}, "slide": {"pins": "Q", "guide": "up", "mass": 10}}
    drawn = draft(units=units, frame="O", pins={"O": [0, 0], "Q": [size, 0]}, links=links, gears={"slide_guide": "0.04 * O"}, drive="O")
    assert not [finding for finding in drawn.check().findings if "limit" in finding.problem]
    motion = pp.servo_cycle(drawn.press(), angle=[0.0, 20 * np.pi], speed=1.0, acceleration=0.0)
    assert np.ptp(motion.slide_position) == pytest.approx(0.04 * 20 * np.pi, rel=1e-12)


def test_a_driver_that_locks_is_warned_of():
    """No Grashof linkage: the crank is a rocker, by the law of cosines between the poses in which coupler and rocker are in one line."""
    pins = {"A": [0, 0], "D": [400, 0], "B": {"from": "A", "length": 300, "angle": 60}, "C": {"B": 250, "D": 260, "side": "up"}}
    links = {"crank": {"pins": "A B", "mass": 1}, "coupler": {"pins": "B C", "mass": 3}, "rocker": {"pins": "D C", "mass": 1}}
    farthest = np.degrees(np.arccos((300**2 + 400**2 - 510**2) / (2 * 300 * 400)))
    with pytest.warns(pp.PinpressWarning, match=rf"it turns only from -.* to {farthest - 60:.4g}\d* deg, where the linkage locks"):
        pp.build(units="mm", frame="A D", pins=pins, links=links, drive="A")


def test_of_several_slides_one_is_named():
    """A punch and a blank holder on one crank: the stroke of each is twice the radius of its pin, as both go through the shaft's line."""
    table = crank_slide()
    table["pins"] |= {"Q": {"from": "O", "length": 40, "angle": 0}, "V": {"Q": 300, "x": 0, "side": "down"}}
    table["links"] = {
        "crank": {"pins": "O P Q", "mass": 20},
        "rod": table["links"]["rod"],
        "punch": {"pins": "W", "guide": "up", "mass": 100},
        "arm": {"pins": "Q V", "mass": 10},
        "holder": {"pins": "V", "guide": "up", "mass": 60},
    }
    assert pp.build(**table).slide is None
    with pytest.raises(pp.PinpressError, match=r"name a link that the frame guides: .* build\(..., slide=...\), in a job slide"):
        pp.dead_centres(pp.build(**table))
    (note,) = (each for each in draft(**table).check().notes if "guides" in each.problem)
    assert note.problem == "the frame guides punch, holder, and none is called slide: no link has a stroke and dead centres"
    for name, radius in (("punch", 0.1), ("holder", 0.04)):
        assert pp.dead_centres(pp.build(**table, slide=name)).stroke == pytest.approx(2 * radius, rel=1e-12)
        checked = draft(**table).check(slide=name)
        assert checked.facts.slide == name
        assert not any("guides" in each.problem for each in checked.notes)
    with pytest.raises(pp.UnknownNameError, match=r"no link 'puch'.*punch"):
        pp.build(**table, slide="puch")
