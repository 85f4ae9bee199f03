"""Where process forces act on a slide: midway between the outermost pins that hold it, or where the file or the table says."""

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.kinematics.main_data import tool_in_words
from pinpress.pin_table import draft

FORCE, START, RADIUS, OFF = 3e5, 0.010, 0.08, 0.12
DRAWING = pp.loads.DeepDrawing(FORCE, START)
SPEED = 60 * pp.RPM


def yoke(angle=-90, first="Y1 Y2", **keys):
    """A scotch yoke whose crank pin is drawn at an angle; its slot ends 120 mm to either side of the middle."""
    return {
        "units": "mm",
        "frame": "O",
        "pins": {
            "O": [0, 0],
            "P": {"from": "O", "length": 1e3 * RADIUS, "angle": angle},
            "M": {"from": "P", "at": [-80 * np.cos(np.radians(angle)), 0]},
            "Y1": {"from": "M", "at": [-1e3 * OFF, 0]},
            "Y2": {"from": "M", "at": [1e3 * OFF, 0]},
        },
        "links": {
            "crank": {"pins": "O P", "mass": 40},
            "block": {"pins": "P", "guide": "Y1 Y2", "mass": 15},
            "slide": {"pins": first, "guide": "up", "mass": 400},
        },
        "drive": "O",
    } | keys


def by_load(press, loads=(DRAWING,), engine="auto"):
    """Moment (n,) of the slide's guide about y that loads add, crank angles from bottom dead centre, and the process force."""
    motion = pp.cycle(press, SPEED, points=360)
    idle, loaded = (pp.inverse_dynamics(press, motion, loads=some, engine=engine) for some in ((), loads))
    guide = press.joints[press.slide_guide.joint]
    added = loaded.bearing_moment[guide] - idle.bearing_moment[guide]
    return added[:, 1], motion.crank_angle - pp.dead_centres(press).bottom_angle, loaded.process_force


@pytest.mark.parametrize("angle", [-90, -40, 100])
@pytest.mark.parametrize("first", ["Y1 Y2", "M Y1 Y2", "Y2 Y1"])
def test_a_scotch_yoke_carries_the_moment_of_its_crank_alone(angle, first, engine):
    """The block pushes r sin(q) beside the middle, in which the force acts, wherever it is drawn and whatever pin is written first."""
    press = pp.build(**yoke(angle, first))
    moment, q, force = by_load(press, engine=engine)
    assert tool_in_words(press) == "at x = 0.0 mm, the middle of Y1 and Y2"
    assert force.max() > 0.99 * FORCE
    expected = force * RADIUS * np.sin(q)
    assert np.abs(np.abs(moment) - np.abs(expected)).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("tool", "x", "name"),
    [("Y1", -OFF, "Y1 of the table"), ([150, -250], 0.03, "the tool of the table"), ({"x": 100}, -0.02, "the tool of the table")],
)
def test_a_table_says_where_the_force_acts_and_a_file_keeps_it(tmp_path, tool, x, name):
    """Coordinates are in the slide's axes, from its first pin, 120 mm left of the middle. Every millimetre adds force times it."""
    press = pp.build(**yoke(tool=tool))
    assert tool_in_words(press) == f"at x = {1e3 * x:.1f} mm, {name}"
    moment, _, force = by_load(press)
    central, _, _ = by_load(pp.build(**yoke()))
    assert np.abs(np.abs(moment - central) - force * abs(x)).max() < 1e-9 * FORCE * OFF
    again = pp.load(pp.write_urdf(press, tmp_path / "press.urdf"))
    assert np.array_equal(again.tool.point, press.tool.point)
    assert again.tool.name == name
    assert name in str(pp.check(tmp_path / "press.urdf"))
    assert np.array_equal(by_load(again)[0], moment)
    drawn = draft(**yoke(tool=tool))
    (tmp_path / "drawn.urdf").write_bytes(drawn.urdf)
    assert np.array_equal(pp.load(tmp_path / "drawn.urdf").tool.point, press.tool.point)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("eccentric_blocks", "at x = 0.0 mm, the middle of P4_left and P4_right"),
        ("jf75g_125_symmetric", "at x = 0.0 mm, the middle of P4_left and P4_right"),
        ("pirica_double_knuckle", "at x = 0.0 mm, the middle of D_left and D_right"),
        ("jf75g_125_two_point", "at x = 0.0 mm, the middle of P4_front and P4_back"),
        ("zxn2_3000b", "at x = 0.0 mm, pin F"),
    ],
)
def test_shipped_presses_are_loaded_in_the_middle(name, words):
    assert tool_in_words(texts.shipped(name)) == words


def test_mirrored_presses_have_no_moment_in_their_guides(engine):
    """By symmetry; about the first of two pins it would be the force times half the distance between them, 312.5 kN m."""
    press = texts.shipped("eccentric_blocks")
    moment, _, force = by_load(press, [pp.loads.DeepDrawing(1.25e6, 0.006)], engine)
    assert force.max() > 1.24e6
    assert np.abs(moment).max() < 1e-9 * force.max() * 0.25


def test_the_guide_of_pirica_takes_what_its_rods_leave():
    """Sum of moments on the slide about its middle: of both pins' forces at +-350 mm, and of the guide."""
    press = texts.shipped("pirica_double_knuckle")
    motion = pp.cycle(press, SPEED, points=720)
    found = pp.inverse_dynamics(press, motion, loads=[pp.loads.DeepDrawing(1.25e6, 0.006)])
    guide = press.joints[press.slide_guide.joint]
    peak = int(found.process_force.argmax())
    left, right = (found.bearing_force[f"D_{side}"][:, 2] for side in ("left", "right"))
    assert np.abs(found.bearing_moment[guide][:, 1]).max() < 2e3
    assert found.bearing_moment[guide][peak, 1] == pytest.approx(-1722.0, abs=0.1)
    assert found.bearing_moment[guide][:, 1] == pytest.approx(0.35 * (right - left), abs=1e-6)


def test_the_middle_follows_its_pins():
    """A press of other lengths has its middle elsewhere."""
    press = texts.shipped("eccentric_blocks")
    wider = pp.derivatives.reshaped(press, {("P4_right", "slide"): (0.6, 0, 0), ("O_right", "frame"): (0.35, 0, 0)})
    assert wider.tool.point == pytest.approx([0.3, 0, 0], abs=1e-15)
    assert wider.tool.name == "the middle of P4_left and P4_right"


def hanging(**links):
    """A crank press whose slide moves a lever that hangs in the frame 300 mm aside."""
    return {
        "units": "mm",
        "frame": "O K",
        "pins": {
            "O": [0, 0],
            "P": {"from": "O", "length": 80, "angle": -30},
            "W": {"P": 400, "x": 0, "side": "down"},
            "L": {"from": "W", "at": [300, 0]},
            "K": {"from": "L", "at": [200, 100]},
            "N": {"L": 60, "K": 190, "side": "down"},
        },
        "links": {
            "crank": {"pins": "O P", "mass": 20},
            "rod": {"pins": "P W", "mass": 15},
            "slide": {"pins": "W L", "guide": "up", "mass": 100},
            "strap": {"pins": "L N", "mass": 1},
            "lever": {"pins": "K N", "mass": 2},
        },
        "drive": "O",
    }


def test_a_lever_that_the_slide_moves_does_not_hold_it():
    assert tool_in_words(pp.build(**hanging())) == "at x = 0.0 mm, pin W"


def test_every_result_takes_the_same_point():
    """Moments of the guide by an eccentric force, by a rated force and by a process load; and the arm of the force in elastic motion."""
    press = texts.shipped("eccentric_blocks")
    motion = pp.servo_cycle(press, speed=0.0, angle=[-0.2])
    gibs = pp.ratings.Gibs(0.5, 0.2)
    beside = pp.ratings.eccentric_load(press, motion, force=FORCE, offset=(0.02, 0, 0), gibs=gibs)
    central = pp.ratings.eccentric_load(press, motion, force=FORCE, offset=(0, 0, 0), gibs=gibs)
    assert np.abs(central.tilting).max() < 1e-9 * FORCE
    assert np.abs(beside.tilting) == pytest.approx([0.02 * FORCE], rel=1e-9)
    low, high = pp.ratings.permissible_eccentricity(press, motion, force=FORCE, gibs=gibs, pressure=50e6)
    assert low == pytest.approx(-high, rel=1e-9)
