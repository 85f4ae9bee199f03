"""Gears, racks, screws and worms of pin tables: what their URDF says of them, and what is refused."""

import contextlib
import random
import re
import xml.etree.ElementTree as ET
from typing import Any

import numpy as np
import pytest
import yaml
from support.generators.machine_elements import ARBOR, GEARED, LEVER_GEAR, MESHING, PLANETARY, RUBBING, SCREW, TEETH, WORM, changed, meshing

import pinpress as pp
from pinpress.pin_table.building import draft
from pinpress.pin_table.machine_elements import SECTIONS


def elements(table: dict[str, Any]) -> list[dict[str, str]]:
    """The machine elements in the URDF of a table, with their tags; the text is read without the linkage."""
    robot = ET.fromstring(draft(**table)._text())
    return [{"tag": each.tag} | each.attrib for each in robot if each.tag in ("gear_mesh", "rack", "screw", "worm")]


PAIR = {"tag": "gear_mesh", "name": "teeth", "gear1": "pinion", "gear2": "crank", "teeth1": "20", "teeth2": "100"}
OF_SCREW = {"tag": "screw", "name": "spindle", "screw": "flywheel", "nut": "slide", "hand": "right", "lead": "0.2", "diameter": "0.3"}
WRITTEN = [
    (meshing(), [PAIR]),
    (meshing(pressure_angle="2 * 10", efficiency=0.985), [PAIR | {"pressure_angle": "20", "efficiency": "0.985"}]),
    (meshing(teeth=["z", "5 * z"]) | {"parameters": {"z": 20}}, [PAIR]),
    (meshing(helix=15), [PAIR | {"helix": "15", "hand": "right"}]),
    (meshing(helix="15 left", module=4, carrier="frame"), [PAIR | {"helix": "15", "hand": "left", "module": "0.004", "carrier": "frame"}]),
    (meshing(helix="25 double", module="0.4cm"), [PAIR | {"helix": "25", "double_helical": "true", "module": "0.004"}]),
    (meshing(at="Q O"), [PAIR | {"center1": "0 0 0", "center2": "0 0 0"}]),
    (meshing(at="P"), [PAIR | {"center2": "0.1 0 0"}]),
    (PLANETARY, [{"name": "sun_planet", "gear2": "planet"}, {"name": "ring", "gear2": "frame", "teeth2": "-80", "center2": "0 0 0"}]),
    (ARBOR, [{"tag": "rack", "name": "rack", "pinion": "pinion", "rack": "slide", "radius": "0.024", "side": "left"}]),
    (changed(ARBOR, "racks", "rack", radius=None, module=4, teeth=12), [{"module": "0.004", "teeth": "12"}]),
    (changed(ARBOR, "racks", "rack", radius="2.4 cm"), [{"radius": "0.024"}]),
    (SCREW, [OF_SCREW | {"flank": "15", "friction": "0.06"}]),
    (changed(SCREW, "screws", "spindle", hand="left", collar_diameter=80), [OF_SCREW | {"hand": "left", "collar_diameter": "0.08"}]),
]


@pytest.mark.parametrize(("table", "written"), WRITTEN)
def test_what_the_urdf_says(table, written):
    found = elements(table)
    assert len(found) == len(written)
    for one, other in zip(found, written, strict=True):
        assert {key: one[key] for key in other} == other


def test_lengths_are_in_the_unit_of_the_table():
    assert elements(changed(ARBOR | {"units": "in"}, "racks", "rack", radius=1))[0]["radius"] == "0.0254"


def test_tables_are_laid_over_each_other_by_keys(tmp_path):
    (tmp_path / "below.yaml").write_text(yaml.safe_dump(meshing(efficiency=0.98)))
    (tmp_path / "above.yaml").write_text("base: below.yaml\nmeshes: {teeth: {helix: 10, efficiency: none}}\n")
    (found,) = ET.fromstring(draft(tmp_path / "above.yaml")._text()).iter("gear_mesh")
    assert (found.get("helix"), found.get("teeth2"), found.get("efficiency")) == ("10", "100", None)
    (tmp_path / "none.yaml").write_text("base: below.yaml\nmeshes: {teeth: none}\nlinks: {pinion: none}\nframe: O\ndrive: O\n")
    assert not list(ET.fromstring(draft(tmp_path / "none.yaml")._text()).iter("gear_mesh"))


def test_copies_mesh_as_their_links_do():
    """A pinion between two wheels meshes with both; a mirror image has the other hand and the other side."""
    both = meshing(helix="15 left") | {"copies": [{"links": "crank rod", "y": [-300, 300], "names": "_front _back"}]}
    found = elements(both)
    assert [(each["name"], each["gear1"], each["gear2"]) for each in found] == [
        ("teeth_front", "pinion", "crank_front"),
        ("teeth_back", "pinion", "crank_back"),
    ]
    assert [each["hand"] for each in found] == ["left", "left"]
    mirrored = meshing(helix="15 left", at="Q O") | {
        "copies": [{"links": "crank rod pinion", "mirror": "x", "names": "_l _r", "gear": "O"}]
    }
    assert [(each["gear1"], each["hand"], each["center1"]) for each in elements(mirrored)] == [
        ("pinion_l", "left", "0 0 0"),
        ("pinion_r", "right", "0 0 0"),
    ]
    for axis, way, other in (
        ("x", "up", "right"),
        ("y", "up", "left"),
        ("z", "up", "left"),
        ("x", "right", "right"),
        ("z", "right", "right"),
    ):
        copies = [{"links": "pinion slide", "mirror": axis, "names": "_1 _2", "gear": "O"}]
        table = ARBOR | {"links": ARBOR["links"] | {"slide": {"pins": "W", "guide": way, "mass": 5}}, "copies": copies}
        assert [each["side"] for each in elements(table)] == ["left", other]


REFUSED = [
    (meshing(gears=None), "no gears; name the two gears: gears: pinion wheel"),
    (meshing(teeth=None), "no teeth; give the teeth of both: teeth: 20 100"),
    (meshing(gears="pinion"), "meshes: teeth: gears: 1 values; write two gears with a blank between them"),
    (meshing(teeth=20), "meshes: teeth: teeth: 1 values; write two numbers of teeth"),
    (meshing(teeth="20, 100"), r"separate names by blanks: 20 100"),
    (meshing(gears="pinion cranks"), "no link cranks, did you mean 'crank'.; name one of crank, rod, slide, pinion, frame"),
    (meshing(carrier="frames"), "meshes: teeth: carrier: no link frames"),
    (meshing(ratio=5), "'ratio' is no key here; write some of gears, teeth, module"),
    (meshing(helix="15 up"), "'15 up' is not a helix; write helix: 15 left, or of herringbone teeth helix: 25 double"),
    (meshing(at="R"), "meshes: teeth: at: no pin R; name one of O, P, W, Q"),
    (meshing(at="W"), "W does not say which gear has its centre there; name the centres of both gears: at: B A"),
    (changed(PLANETARY, "meshes", "ring", at=None), "a gear is fixed to the frame, and nothing says where its centre is; .* at: A"),
    (GEARED | {"meshes": {"P": TEETH}}, "meshes: P: P is a bearing, whose force has this name; give the machine element another name"),
    (GEARED | {"meshes": {"a b": TEETH}}, "'a b' cannot name a machine element; write one word: a_b"),
    (ARBOR | {"meshes": {"rack": {"gears": "pinion slide", "teeth": "1 1"}}}, "racks: rack: rack is a name in meshes too"),
    (GEARED | {"meshes": TEETH}, "meshes: gears: 'pinion crank' is a text; write one of meshes: {gears: ...}"),
    (changed(ARBOR, "racks", "rack", side="up"), "racks: rack: side: 'up' is not a word here; write left or right"),
    (changed(ARBOR, "racks", "rack", rack=None), "no rack; name the link that slides: rack: slide"),
    (changed(ARBOR, "racks", "rack", radius="24 rad"), "'24 rad' is not a number"),
    (changed(SCREW, "screws", "spindle", lead=None), "no lead; give the lead of a turn: lead: 20"),
    (changed(SCREW, "screws", "spindle", hand="rigth"), "'rigth' is not a word here, did you mean 'right'?"),
    (GEARED | {"worms": {"worm": {"worm": "pinion", "wheel": "crank", "starts": 2}}}, "no teeth; give the teeth of the wheel: teeth: 40"),
    (GEARED, "it hangs only by pin Q and swings freely; .* name a gear in meshes"),
    (
        {key: value for key, value in LEVER_GEAR.items() if key != "meshes"} | {"gears": {"A1": "0.4 * B"}},
        "gears: A1: no link carries both axes .* write gears whose carrier moves .*: meshes: {teeth: {gears: ring rod, teeth: }}",
    ),
]


@pytest.mark.parametrize(("table", "message"), REFUSED)
def test_what_a_table_refuses(table, message):
    with pytest.raises(pp.PinTableError, match=message):
        draft(**(table if table is not GEARED else GEARED | {"drive": "O"}))


TWO_LINES = SCREW | {"units": "m", "pins": {name: pin | {"z": pin["z"] / 1e3} for name, pin in SCREW["pins"].items()}}
UNFIT = [  # what the linkage has against an element, at the table's line
    (meshing(pressure_angle=0.35), "meshes: teeth: pressure_angle is 0.35 deg, as if in radians; write degrees: 20.05"),
    (meshing(gears="pinion rod"), r"carried at 'Q' by 'frame', .* at 'P' by 'crank', .*: no link holds both, so that the teeth would part"),
    (meshing(teeth="20 20.5"), "teeth of the second gear is 20.5; write a whole number"),
    (meshing(gears="crank crank"), "both are link 'crank'; name two links"),
    (meshing(module=12), "module 12 mm makes a centre distance of 720 mm, and the axes are 600 mm apart"),
    (meshing(efficiency=98.5), "efficiency is 98.5; write a share above 0"),
    (changed(LEVER_GEAR, "meshes", "teeth", gears="ring crank"), "their distance is 0; .* gears:, for a belt, a chain or a coupling"),
    (changed(PLANETARY, "meshes", "ring", teeth="30 -90"), "gear 'planet' has module 8.33333 mm, in gear mesh 'sun_planet' 10 mm"),
    (changed(PLANETARY, "meshes", "sun_planet", planets=3), r"3 planets do not fit between sun and ring: \(20 \+ 80\)/3 is not whole"),
    (changed(TWO_LINES, "screws", "spindle", diameter=0.3), "screws: spindle: lead is 200 m a turn; .* 0.2 for 200 mm"),
    (changed(ARBOR, "racks", "rack", radius=None), "racks: rack: its pinion has no radius; give a radius, or else module and teeth"),
    (changed(ARBOR, "racks", "rack", pinion="slide", rack="pinion"), "link 'slide' has no pin about which it turns"),
    (changed(SCREW, "screws", "spindle", diameter=None), "it has friction and no diameter; give the mean diameter of the thread"),
    (meshing() | {"gears": {"O": "-0.2 * Q"}}, "joints 'O' and 'Q' are related already, by joint 'O'; remove one of the two"),
]


@pytest.mark.parametrize(("table", "message"), UNFIT)
def test_what_does_not_mesh_is_refused_at_its_line(table, message, tmp_path):
    with pytest.raises(pp.PinTableError, match=message):
        pp.build(**table)
    (tmp_path / "press.yaml").write_text(yaml.safe_dump(table | {"press": "press"}, sort_keys=False, default_flow_style=True, width=10**6))
    with pytest.raises(pp.PinTableError, match=r"press.yaml:1: \w+: \w+: "):
        pp.build(tmp_path / "press.yaml")
    (finding,) = draft(tmp_path / "press.yaml").check().errors
    assert finding.line == 1
    assert re.fullmatch(r"\w+: \w+", finding.element)


# Angles of the ring, and by them the angles of the crank and the positions of the slide, by an independent program.
OF_RING = [(10, 26.3769178476, 0.2922685075), (20, 51.2417145560, 0.2729574102), (30, 73.8978862480, 0.2496150883)]


@pytest.mark.parametrize("turns", ["clockwise", "counter-clockwise"])
def test_a_lever_gear_turns_its_crank_by_the_angles_against_it(turns):
    """Willis: the ring is 40 internal teeth about the 20 of the planet, which swings with the rod."""
    ring, crank, slide = np.transpose(OF_RING)
    sense = 1.0 if turns == "counter-clockwise" else -1.0
    press = pp.build(**LEVER_GEAR | {"turns": turns})
    motion = pp.servo_cycle(press, sense * np.radians(ring), speed=1.0, acceleration=0.0)
    np.testing.assert_allclose(sense * np.degrees(motion.joint_position[:, press.joints.index("A")]), crank, rtol=0, atol=6e-11)
    moved = motion.slide_position - pp.servo_cycle(press, [0.0], speed=1.0, acceleration=0.0).slide_position[0]
    np.testing.assert_allclose(0.3 + moved, slide, rtol=0, atol=6e-11)


def test_a_planetary_turns_its_arm_a_fifth_as_fast():
    press = pp.build(**PLANETARY)
    motion = pp.servo_cycle(press, np.radians([0.0, 100.0]), speed=50.0, acceleration=20.0)
    turned = dict(zip(press.joints, motion.joint_position.T, strict=True))
    assert np.degrees(turned["A"][1]) == pytest.approx(20.0, rel=1e-13)
    assert np.degrees(turned["A"][1] + turned["P"][1]) == pytest.approx(-100 / 3, rel=1e-13)
    assert motion.v[1, press.joints.index("A")] == pytest.approx(10.0, rel=1e-13)


def test_a_rack_in_gears_is_doubted_with_what_to_write():
    gears = {key: value for key, value in ARBOR.items() if key != "racks"} | {"gears": {"slide_guide": "24 * O"}}
    with pytest.warns(pp.PinpressWarning, match=re.escape("0.024 m/rad for 24 mm. A table in mm has racks: {")):
        draft(**gears)


def acting(table: dict[str, Any], state: tuple[float, float, float], force: tuple[float, float, float], **options: Any) -> pp.Reactions:
    """Reactions at an angle [deg], speed [rad/s] and acceleration [rad/s2] of the driver, reached from the drawn pose, under a force on the
    slide."""
    angle, speed, acceleration = state
    press = pp.build(**table, **options)
    motion = pp.servo_cycle(press, np.radians([0.0, angle]), speed=speed, acceleration=acceleration)
    return pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slide", force)])


def pinion(mass: float, inertia: float) -> dict[str, Any]:
    """The geared crank-slide with this pinion, whose 20 teeth turn 100 of the crank."""
    return meshing() | {"links": GEARED["links"] | {"pinion": {"pins": "Q", "mass": mass, "inertia": inertia}}}


WEIGHTLESS = pinion(1e-12, 1e-14)  # far below the last digit that is compared
# Forces [N] in x and z on the second of the two links, and torques [N m], by an independent program in maximal coordinates.
FORCES = [
    (
        (WEIGHTLESS, (-450, -50, 0), (0, 0, 0)),
        {"teeth": (66.2022688217, -181.8892387044), "O": (26.0878253334, 1228.67543223), "Q": (66.2022688217, -181.889238704)}
        | {"P": (152.290094155, 850.586193522)},
        -18.1889238704,
    ),
    (
        (WEIGHTLESS, (-450, -50, 0), (0, 0, 1e5)),
        {"teeth": (7213.2024165023, 19818.1107612955), "O": (-32940.8012971, -118771.324568), "Q": (7213.2024165, 19818.1107613)},
        1981.81107613,
    ),
    (
        (WEIGHTLESS, (-1350, -50, 0), (0, 0, 1e5)),
        {"teeth": (7213.2024165023, -19818.1107612957), "O": (18514.3964641, -79135.1030452), "Q": (7213.2024165, -19818.1107613)},
        -1981.81107613,
    ),
    (
        (pinion(30, 0.15), (-450, -50, -25), (0, 0, 0)),
        {"teeth": (70.8174113922, -194.5692387044), "O": (35.3508730868, 1301.85543223), "Q": (70.8174113922, 99.7307612956)},
        -23.2069238704,
    ),
    (
        (LEVER_GEAR, (20, 10, 0), (-1000, 0, 0)),
        {"teeth": (540.2614485139, -890.6136782363), "A": (340.883677221, 430.246625649), "A1": (540.261448514, -812.133678236)}
        | {"B": (356.048796872, 442.025878877), "C": (937.736865279, -430.918919518), "slide_guide": (0, 479.968919518)},
        -117.461886776,
    ),
    (
        (ARBOR, (-5, 0, 0), (0, 0, 1e4)),
        {"rack": (3621.8496026713, -9950.95), "O": (3621.84960267, -9941.14), "slide_guide": (-3621.84960267, 0)},
        -238.8228,
    ),
]


@pytest.mark.parametrize(("case", "forces", "torque"), FORCES)
def test_forces_of_teeth_and_bearings(case, forces, torque):
    reactions = acting(*case)
    assert reactions.driving_torque[-1] == pytest.approx(torque, rel=5e-12)
    for name, (x, z) in forces.items():
        x_is, y_is, z_is = reactions.bearing_force[name][-1]
        assert (x_is, y_is, z_is) == pytest.approx((x, 0.0, z), rel=5e-12, abs=5e-10), name


# Load [N], lead, mean diameter [mm], friction, angle of the flanks [deg], friction in the collar; torques in the sense of turning, against
# the load and with it [N m]; efficiencies against it and with it. By the theory of the wedge in an independent program.
SCREWS = [
    ((1e5, 9, 55.5, 0.12, 15, 0.0), (491.10473131, 200.193181), (0.29166782491, -1.0)),
    ((1e5, 9, 55.5, 0.12, 15, 0.1), (891.10473131, 600.193181), (0.29166782491, -1.0)),
    ((4e6, 200, 300, 0.06, 15, 0.0), (166734.714, -88937.205223), (0.76363194812, 0.69851117639)),
    ((5e4, 20, 50, 0.004, 45, 0.0), (166.31706533, -152.00308934), (0.95693693715, 0.95506357759)),
]


@pytest.mark.parametrize(("screw", "torques", "efficiencies"), SCREWS)
@pytest.mark.parametrize("hand", ["right", "left"])
def test_torque_of_a_screw(screw, torques, efficiencies, hand):
    """A right-handed screw that is held along its axis, and turns positively about z, lets its nut go down."""
    load, lead, diameter, friction, flank, collar = screw
    said = {"lead": lead, "diameter": diameter, "friction": friction, "flank": flank, "hand": hand}
    table = changed(SCREW, "screws", "spindle", **said, **({"collar_friction": collar, "collar_diameter": 80} if collar else {}))
    spindle: Any = pp.build(**table).meshes["spindle"]
    assert spindle.efficiency == pytest.approx(efficiencies[0], rel=1e-10)
    assert spindle.self_locking == (efficiencies[1] < 0)
    if not spindle.self_locking:
        assert spindle.efficiency_backward == pytest.approx(efficiencies[1], rel=1e-10)
    down = 1.0 if hand == "right" else -1.0
    for way, torque in zip((down, -down), torques, strict=True):
        reactions = acting(table, (3.0 * way, way, 0.0), (0, 0, load), gravity=(0, 0, 0))
        assert way * reactions.driving_torque[-1] == pytest.approx(torque, rel=5e-9)


@pytest.mark.parametrize(
    ("way", "worm", "torque"), [(1, (1815.5680209, 4590.8732644), 72.622720835), (-1, (3199.1558129, 4689.6343637), 127.96623251)]
)
def test_forces_of_a_worm(way, worm, torque):
    """2000 N m on the wheel, which it drives where the worm turns positively; the worm's teeth push with 12.5 kN along its axis."""
    press = pp.build(**WORM, gravity=(0, 0, 0))
    motion = pp.servo_cycle(press, [0.0, 0.3 * way], speed=float(way), acceleration=0.0)
    reactions = pp.inverse_dynamics(press, motion, loads=[pp.loads.PointMoment("wheel", (0, 2000, 0))])
    assert reactions.driving_torque[-1] == pytest.approx(-torque, rel=1e-9)
    assert reactions.bearing_force["worm"][-1] == pytest.approx((12500, *worm), rel=1e-9)


@pytest.mark.parametrize("turns", ["clockwise", "counter-clockwise"])
@pytest.mark.parametrize("mirror", ["x", "z"])
@pytest.mark.parametrize("guide", ["up", "down", "right", 30])
def test_mirrored_racks_push_as_mirror_images(turns, mirror, guide):
    """Two pinions that gears turn against each other, each on the outer side of its slide."""
    table = ARBOR | {"pins": {"O": [-124, 100], "W": [-100, 150]}, "turns": turns}
    table |= {"links": ARBOR["links"] | {"slide": {"pins": "W", "guide": guide, "mass": 5}}}
    table |= {"copies": [{"links": "pinion slide", "mirror": mirror, "names": "_1 _2", "gear": "O"}]}
    press = pp.build(**table, slide="slide_1", gravity=(0, 0, 0))
    sense = 1.0 if turns == "clockwise" else -1.0
    motion = pp.servo_cycle(press, np.array([0.0, 0.2]) * sense, speed=sense, acceleration=0.0)
    one, two = (motion.joint_position[:, press.joints.index(f"slide_guide_{k}")] for k in (1, 2))
    np.testing.assert_allclose(two, one, rtol=0, atol=1e-15)
    assert np.ptp(one) == pytest.approx(0.2 * 24e-3, rel=1e-12)
    sign = (-1, 1, 1) if mirror == "x" else (1, 1, -1)
    loads = [pp.loads.PointForce(f"slide_{k}", tuple(way * np.array([5e3, 0, 1e4]))) for k, way in ((1, np.ones(3)), (2, np.array(sign)))]
    forces = pp.inverse_dynamics(press, motion, loads=loads).bearing_force
    np.testing.assert_allclose(forces["rack_2"], forces["rack_1"] * sign, rtol=0, atol=1e-9)
    if guide == "up":
        assert forces["rack_1"][-1] == pytest.approx((1e4 * np.tan(np.radians(20)), 0, -1e4), rel=1e-12)


@pytest.mark.parametrize("name", MESHING)
def test_the_urdf_with_shapes_loads_to_the_same_press(name, tmp_path):
    drawn = draft(**MESHING[name])
    (tmp_path / "press.urdf").write_bytes(drawn.urdf)
    press, again = drawn.press(), pp.load(tmp_path / "press.urdf")
    assert (again.joints, again.drivers, list(again.meshes)) == (press.joints, press.drivers, list(press.meshes))
    for one, other in zip(again.relations, press.relations, strict=True):
        assert dict(one.coefficients) == pytest.approx(dict(other.coefficients), rel=1e-14)


ODD = [None, "", " ", "x", 5, -5, 0, 1e300, float("nan"), True, [], [1], [1, 2], [1, 2, 3], {}, {"a": 1}, "1 2", "frame", "frame frame"]
ODD += [
    "pinion",
    "slide",
    "Q",
    "Q O",
    "P P P",
    "-0",
    "24mm",
    "24 kg",
    "mm",
    "0x10",
    "15 left right",
    "left",
    "2**2**2**2**2",
    "1/0",
    "\u202e",
]


@pytest.mark.exhaustive
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize("seed", range(300))
def test_odd_values_make_a_press_or_an_error(seed):
    chosen = random.Random(seed)
    table = chosen.choice([*MESHING.values(), *RUBBING.values()])
    section = chosen.choice([name for name in SECTIONS if name in table])
    name = chosen.choice(list(table[section]))
    element = dict(table[section][name]) | {
        chosen.choice(SECTIONS[section].keys): chosen.choice(ODD) for _ in range(chosen.choice([1, 1, 2]))
    }
    with contextlib.suppress(pp.PinpressError):
        assert pp.build(**table | {section: table[section] | {name: element}}).meshes


def test_a_fly_press_has_no_pin_in_the_frame():
    """Its spindle turns in the slide and screws itself through the nut, which is the frame: 40 mm down in a turn of a left-hand thread."""
    table = {
        "units": "mm",
        "pins": {"N": {"x": 0, "y": 0, "z": 0, "axis": "z"}},
        "links": {"slide": {"pins": "N", "guide": "up", "mass": 20}, "spindle": {"pins": "N", "mass": 8, "inertia": [0.2, 0.2, 0.3]}},
        "screws": {"thread": {"screw": "spindle", "nut": "frame", "lead": 40, "hand": "left"}},
        "drive": "N",
    }
    press = pp.build(**table)
    motion = pp.servo_cycle(press, [0.0, 2 * np.pi], speed=1.0, acceleration=0.0)
    assert np.ptp(motion.slide_position) == pytest.approx(0.04, rel=1e-12)
    assert motion.slide_position[-1] < motion.slide_position[0]
    torque = pp.inverse_dynamics(press, motion).driving_torque
    np.testing.assert_allclose(torque, -28 * 9.81 * 0.04 / (2 * np.pi), rtol=1e-12)
    with pytest.raises(pp.PinTableError, match="no frame; name the pins that are fixed in the frame"):
        pp.build(**{key: value for key, value in GEARED.items() if key != "frame"} | {"meshes": {"teeth": TEETH}})
