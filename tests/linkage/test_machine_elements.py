"""Gears, racks, screws and worms of a URDF: motion against Willis' equation and references, contacts against formulas, refusals by name.

References are those of an independent NumPy script in maximal coordinates.
"""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.exploring import examples

import pinpress as pp

DRIVE = '<transmission name="drive"><joint name="{}"/></transmission>'


def link(name, mass=1.0, moment=0.01, centre=0.0):
    moments = f'ixx="{moment}" ixy="0" ixz="0" iyy="{moment}" iyz="0" izz="{moment}"'
    return f'<link name="{name}"><inertial><origin xyz="{centre} 0 0"/><mass value="{mass}"/><inertia {moments}/></inertial></link>\n'


def pin(name, parent, child, at=(0, 0, 0), axis="0 -1 0"):
    x, y, z = (repr(float(each)) for each in at)
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{x} {y} {z}"/><axis xyz="{axis}"/>'
    return f'<joint name="{name}" type="continuous">{ends}</joint>\n'


def guide(name, child, at=(0, 0, 0), axis="0 0 1", parent="frame"):
    x, y, z = at
    ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{x} {y} {z}"/><axis xyz="{axis}"/>'
    return f'<joint name="{name}" type="prismatic">{ends}<limit lower="-9" upper="9" effort="1e9" velocity="1e3"/></joint>\n'


def robot(*parts, driver):
    return f'<robot name="press">\n<link name="frame"/>\n{"".join(parts)}{DRIVE.format(driver)}\n</robot>'


LEVER = robot(
    link("crank", 2, 0.0006, 0.03) + link("ring", 8, 0.0576) + link("rod", 3, 0.0144, 0.12) + link("slide", 5),
    pin("A", "frame", "crank") + pin("A1", "frame", "ring") + pin("B", "crank", "rod", (0.06, 0, 0)),
    guide("guide", "slide", (0.3, 0, 0), "1 0 0"),
    '<loop_joint name="C" type="spherical"><link1 link="rod" xyz="0.24 0 0"/><link2 link="slide"/></loop_joint>\n',
    '<gear_mesh name="teeth" gear1="ring" gear2="rod" teeth1="-40" teeth2="20"/>\n',
    driver="A1",
)
PLANETARY = robot(
    link("sun", 10, 0.05) + link("arm", 40, 0.8, 0.125) + link("planet", 12, 0.14),
    pin("S", "frame", "sun") + pin("C", "frame", "arm") + pin("P", "arm", "planet", (0.25, 0, 0)),
    '<gear_mesh name="sun_pl" gear1="sun" gear2="planet" teeth1="20" teeth2="30"/>\n',
    '<gear_mesh name="ring_pl" gear1="planet" gear2="frame" teeth1="30" teeth2="-80"/>\n',
    driver="S",
)
PAIR = robot(
    link("pinion") + link("wheel"),
    pin("Q", "frame", "pinion", (-0.6, 0, 0)) + pin("O", "frame", "wheel"),
    '<gear_mesh name="teeth" gear1="pinion" gear2="wheel" teeth1="20" teeth2="100"/>\n',
    driver="Q",
)
ARBOR = robot(
    link("pinion") + link("slide"),
    pin("O", "frame", "pinion") + guide("guide", "slide", (0.024, 0, 0)),
    '<rack name="teeth" pinion="pinion" rack="slide" radius="0.024"/>\n',
    driver="O",
)
SPINDLE = robot(
    link("flywheel") + link("slide"),
    pin("S", "frame", "flywheel", axis="0 0 1") + guide("guide", "slide", (0, 0, -0.5)),
    '<screw name="spindle" screw="flywheel" nut="slide" lead="0.2" diameter="0.3" flank="15" friction="0.06"/>\n',
    driver="S",
)
WORM = robot(
    link("motor") + link("wheel"),
    pin("M", "frame", "motor", (0, 0, -0.2), "1 0 0") + pin("O", "frame", "wheel"),
    '<worm name="worm" worm="motor" wheel="wheel" starts="2" teeth="40" module="0.008" quotient="10" friction="0.05"/>\n',
    driver="M",
)


@pytest.fixture
def load(tmp_path):
    def loaded(text, **arguments):
        path = tmp_path / "press.urdf"
        path.write_text(text)
        return pp.load(path, **arguments)

    return loaded


def ratio(press, driver, follower):
    """Speed of one joint by that of the driver, which are all constant in a train."""
    motion = pp.servo_cycle(press, angle=[0.3, 0.4], speed=1.0, acceleration=0.0)
    return np.diff(motion.joint_position[:, press.joints.index(follower)])[0] / 0.1


# ------------------------------------------------------------------------------------------------------------------------------ motion


@pytest.mark.parametrize("engine", ["plane", "space", "pinocchio"])
def test_the_lever_gear_moves_as_an_independent_script_has_it(load, engine):
    press = load(LEVER)
    motion = pp.servo_cycle(press, angle=np.radians([10, 20, 30]), speed=10.0, acceleration=0.0)
    crank = np.degrees(motion.joint_position[:, press.joints.index("A")])
    np.testing.assert_allclose(crank, [26.3769178476, 51.2417145560, 73.8978862480], rtol=0, atol=5.1e-11)
    np.testing.assert_allclose(motion.slide_position, [0.2922685075, 0.2729574102, 0.2496150883], rtol=0, atol=5.1e-11)
    np.testing.assert_allclose(motion.v[1, press.joints.index("A")], 23.7973607047, rtol=0, atol=5.1e-11)
    states = press.engine(engine)
    assert states.gaps(motion.joint_position.T).max() < 1e-14


@pytest.mark.parametrize("engine", ["plane", "space", "pinocchio"])
def test_a_planetary_gear_turns_by_willis(load, engine):
    press = load(PLANETARY)
    motion = pp.servo_cycle(press, angle=np.radians([100.0]), speed=50.0, acceleration=20.0)
    absolute = dict(zip(press.joints, motion.v[0], strict=True))
    assert math.isclose(math.degrees(motion.joint_position[0, press.joints.index("C")]), 20.0, rel_tol=1e-14)
    assert math.isclose(absolute["C"], 10.0, rel_tol=1e-14)
    assert math.isclose(absolute["C"] + absolute["P"], -16.6666666666667, rel_tol=1e-14)
    assert press.period_turns == 5
    torque = pp.inverse_dynamics(press, motion, engine=engine).driving_torque[0]
    by_hand = 0.152555556 * 20 + 8 * 9.81 * math.cos(math.radians(20)) / 5
    assert math.isclose(torque, by_hand, rel_tol=1e-9)


def test_a_cardan_circle_draws_a_straight_line(load):
    pinion_in_ring = robot(
        link("crank") + link("pinion"),
        pin("A", "frame", "crank") + pin("B", "crank", "pinion", (0.1, 0, 0)),
        '<gear_mesh name="teeth" gear1="pinion" gear2="frame" teeth1="40" teeth2="-80"/>\n',
        driver="A",
    )
    press = load(pinion_in_ring)
    at = press.placements("pinion", math.radians(35)) @ np.array([0.1, 0, 0, 1])
    np.testing.assert_allclose(at[:3], [0.163830408858, 0, 0], rtol=0, atol=5.1e-13)


@given(
    teeth=st.tuples(*[st.integers(12, 40)] * 3),
    senses=st.tuples(*[st.sampled_from([1, -1])] * 4),
    turned=st.floats(-3.0, 3.0),
    driver=st.sampled_from(["S", "C"]),
    second=st.booleans(),
)
@examples(8)
def test_random_epicyclic_trains_turn_by_willis(tmp_path_factory, teeth, senses, turned, driver, second):
    """A sun, a stepped planet and a second sun or a ring on one arm; speeds by Willis' equation solved for all of them at once."""
    sun, planet, stepped = teeth
    module = 0.004
    centre = 0.5 * module * (sun + planet)
    other = sun + planet - stepped if second else -(sun + planet + stepped)  # same centre distance, another module
    other = other or 1
    at = centre * np.array([math.cos(turned), 0, math.sin(turned)])
    axes = [f"0 {-sense} 0" for sense in senses]
    text = robot(
        link("sun") + link("arm") + link("planet") + link("out"),
        pin("S", "frame", "sun", axis=axes[0]) + pin("C", "frame", "arm", axis=axes[1]) + pin("P", "arm", "planet", at, axes[2]),
        pin("R", "frame", "out", axis=axes[3]),
        f'<gear_mesh name="one" gear1="sun" gear2="planet" teeth1="{sun}" teeth2="{planet}"/>\n',
        f'<gear_mesh name="two" gear1="out" gear2="planet" teeth1="{other}" teeth2="{stepped}"/>\n',
        '<transmission name="second"><joint name="R"/></transmission>',
        driver=driver,
    )
    if abs(other) <= stepped and other < 0 or other == planet and stepped == planet:
        return
    path = tmp_path_factory.mktemp("train") / "train.urdf"
    path.write_text(text)
    press = pp.load(path)
    # Unknowns: speeds of sun, arm, planet and out from the frame; equations: two meshes and two drivers at 1 and 2 rad/s about their axes.
    known = {"S": 0, "C": 1}[driver]
    rows = [[sun, -sun - planet, planet, 0], [0, -other - stepped, stepped, other], np.eye(4)[known], np.eye(4)[3]]
    order = dict(zip(press.drivers, (1.0, 2.0), strict=True))
    absolute = np.linalg.solve(np.array(rows, float), [0, 0, order[driver] * senses[known], order["R"] * senses[3]])
    expected = np.array([absolute[0], absolute[1], absolute[2] - absolute[1], absolute[3]]) * np.array(senses)
    speeds = np.array([[order[name] for name in press.drivers]] * 2)
    motion = pp.servo_cycle(press, angle=speeds * [[0.0], [7.0]], speed=speeds, acceleration=np.zeros((2, 2)))
    places = [press.joints.index(name) for name in "SCPR"]
    for gained in (motion.v[0], motion.joint_position[1] / 7.0):
        np.testing.assert_allclose(gained[places], expected, rtol=0, atol=1e-11 * np.abs(expected).max())
