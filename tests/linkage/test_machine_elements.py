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
from pinpress.linkage.linkage import is_same_press

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


def test_the_lever_gear_moves_as_an_independent_script_has_it(load, engine):
    press = load(LEVER)
    motion = pp.servo_cycle(press, angle=np.radians([10, 20, 30]), speed=10.0, acceleration=0.0)
    crank = np.degrees(motion.joint_position[:, press.joints.index("A")])
    np.testing.assert_allclose(crank, [26.3769178476, 51.2417145560, 73.8978862480], rtol=0, atol=5.1e-11)
    np.testing.assert_allclose(motion.slide_position, [0.2922685075, 0.2729574102, 0.2496150883], rtol=0, atol=5.1e-11)
    np.testing.assert_allclose(motion.v[1, press.joints.index("A")], 23.7973607047, rtol=0, atol=5.1e-11)
    states = press.engine(engine)
    assert states.gaps(motion.joint_position.T).max() < 1e-14


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


@pytest.mark.parametrize("cut", ["B", "A"])
def test_gears_may_be_held_by_loops(load, cut):
    """The lever gear with the rod on the slide, and the crank's pin in the rod or in the frame as the loop: all moves as before."""
    bodies = link("crank", 2, 0.0006, 0.03) + link("ring", 8, 0.0576) + link("rod", 3, 0.0144, -0.12) + link("slide", 5)
    tree = pin("A1", "frame", "ring") + guide("guide", "slide", (0.3, 0, 0), "1 0 0") + pin("C", "slide", "rod")
    if cut == "B":
        ends = pin("A", "frame", "crank"), '<link1 link="crank" xyz="0.06 0 0"/><link2 link="rod" xyz="-0.24 0 0"/>'
    else:  # the crank's frame is at its pin in the rod
        ends = pin("B", "rod", "crank", (-0.24, 0, 0)), '<link1 link="frame"/><link2 link="crank" xyz="-0.06 0 0"/>'
    teeth = '<gear_mesh name="teeth" gear1="ring" gear2="rod" teeth1="-40" teeth2="20"/>\n'
    press = load(robot(bodies, tree, ends[0], f'<loop_joint name="{cut}" type="spherical">{ends[1]}</loop_joint>\n', teeth, driver="A1"))
    motion = pp.servo_cycle(press, angle=np.radians([10, 20, 30]), speed=10.0, acceleration=0.0)
    np.testing.assert_allclose(motion.slide_position, [0.2922685075, 0.2729574102, 0.2496150883], rtol=0, atol=5.1e-11)
    assert press.meshes["teeth"].carrier == "crank"


def test_stages_of_planets_multiply(load):
    """Two equal stages, the arm of the first one is the shaft of the second sun."""
    parts = [link("sun") + pin("S", "frame", "sun")]
    for stage, sun in ((1, "sun"), (2, "arm1")):
        parts.append(link(f"arm{stage}", centre=0.1) + link(f"planet{stage}"))
        parts.append(pin(f"C{stage}", "frame", f"arm{stage}") + pin(f"P{stage}", f"arm{stage}", f"planet{stage}", (0.25, 0, 0)))
        parts.append(f'<gear_mesh name="s{stage}" gear1="{sun}" gear2="planet{stage}" teeth1="20" teeth2="30"/>\n')
        parts.append(f'<gear_mesh name="r{stage}" gear1="planet{stage}" gear2="frame" teeth1="30" teeth2="-80"/>\n')
    press = load(robot(*parts, driver="S"))
    assert math.isclose(ratio(press, "S", "C2"), 1 / 25, rel_tol=1e-12)
    assert press.engines[0] == "plane"


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
    if -stepped <= other < 0:
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


@pytest.mark.parametrize("engine", ["space", "pinocchio"])
def test_meshes_of_three_drawn_planets_are_redundant_and_agree(load, engine):
    """Spin 1/5 of the sun; torque by the kinetic energy of sun, arm and three planets."""
    parts = [link("sun", 10, 0.05) + link("arm", 40, 0.8) + pin("S", "frame", "sun") + pin("C", "frame", "arm")]
    for k in range(3):
        turned = 2 * math.pi * k / 3
        at = 0.25 * math.cos(turned), 0, 0.25 * math.sin(turned)
        parts.append(link(f"p{k}", 12, 0.14) + pin(f"P{k}", "arm", f"p{k}", at))
        parts.append(f'<gear_mesh name="s{k}" gear1="sun" gear2="p{k}" teeth1="20" teeth2="30"/>\n')
        parts.append(f'<gear_mesh name="r{k}" gear1="p{k}" gear2="frame" teeth1="30" teeth2="-80"/>\n')
    press = load(robot(*parts, driver="S"))
    assert press.mobility == 1
    assert press.rank == 4
    motion = pp.servo_cycle(press, angle=[1.7], speed=50.0, acceleration=20.0)
    assert math.isclose(motion.v[0, press.joints.index("C")], 10.0, rel_tol=1e-12)
    reduced = 0.05 + (0.8 + 3 * (12 * 0.25**2 + 0.14 * (5 / 3) ** 2)) / 25
    torque = pp.inverse_dynamics(press, motion, engine=engine).driving_torque
    np.testing.assert_allclose(torque, 20 * reduced, rtol=1e-9)


def test_gears_on_a_crank_keep_their_ratio_there_whatever_the_crank_does(load):
    text = robot(
        link("crank") + link("one") + link("other"),
        pin("O", "frame", "crank") + pin("A", "crank", "one") + pin("B", "crank", "other", (0.09, 0, 0)),
        '<gear_mesh name="teeth" gear1="one" gear2="other" teeth1="15" teeth2="30"/>\n',
        driver="O",
    )
    press = load(text, drivers=["O", "A"])
    assert dict(press.relations[0].coefficients) == {press.joints.index("B"): 1.0, press.joints.index("A"): 0.5}
    assert press.meshes["teeth"].carrier == "crank"


def test_a_relation_determines_no_driver_and_rather_a_joint_on_no_loop(load):
    for driver, determined in (("A1", "A"), ("A", "A1")):
        press = load(LEVER, driver=driver)
        assert press.joints[press.relations[0].joint] == determined


# ---------------------------------------------------------------------------------------------------------------------------- contacts


def forces(press, torque):
    """Force and push of the only contact where the teeth turn the second body with a torque [N m]."""
    (contact,), (relation,) = press.contacts, press.relations
    of_second = next(joint for joint in relation.coefficients if joint == contact.second - 1)
    effort = torque / relation.coefficients[of_second]
    return effort * contact.unit.force, abs(effort) * contact.unit.push


@pytest.mark.parametrize(("pressure", "helix", "hand", "axial"), [(20, 0, "right", 0), (20, 15, "right", 1), (20, 15, "left", -1)])
def test_teeth_push_along_apart_and_by_their_helix(load, pressure, helix, hand, axial):
    """10 kN on a wheel r 0.5 m: with 15 and 20 deg 2679.4919243112 N along the axis and 3768.0971391408 N apart."""
    press = load(PAIR.replace("teeth2=", f'pressure_angle="{pressure}" helix="{helix}" hand="{hand}" teeth2='))
    force, push = forces(press, 5000.0)
    # The pinion is left of the wheel: a torque against the clock pushes the wheel down there, and it apart to the right. The teeth of a
    # right-handed pinion rise along its axis as they go round it, here towards -y and up at the pitch point.
    tangential, radial = np.array([0, 0, -1e4]), np.array([1e4 * math.tan(math.radians(20)), 0, 0])
    thrust = axial * np.array([0, -2679.4919243112, 0])
    np.testing.assert_allclose(force, tangential + thrust, rtol=0, atol=1e-8)
    np.testing.assert_allclose(push, radial if not helix else [3768.0971391408, 0, 0], rtol=0, atol=1e-8)
    assert math.isclose(np.linalg.norm(press.meshes["teeth"].pitch_point - [-0.5, 0, 0]), 0, abs_tol=1e-15)


def test_teeth_of_an_internal_pair_push_the_pinion_to_its_own_centre(load):
    (contact,) = load(LEVER).contacts
    np.testing.assert_allclose(contact.unit.point, [0.12, 0, 0], atol=1e-16)
    assert (
        contact.unit.push[0]
        < 0
        < load(LEVER.replace('gear1="ring" gear2="rod" teeth1="-40" teeth2="20"', 'gear1="rod" gear2="ring" teeth1="20" teeth2="-40"'))
        .contacts[0]
        .unit.push[0]
    )


def test_a_module_gives_the_working_pressure_angle(load):
    mesh = load(PAIR.replace("teeth2=", 'module="0.0099" teeth2=')).meshes["teeth"]
    assert mesh.module == 0.0099
    assert math.isclose(math.cos(mesh.pressure_angle), 0.0099 * 60 * math.cos(math.radians(20)) / 0.6, rel_tol=1e-14)
    assert "module 9.9 mm, pressure angle 21.5" in repr(mesh)


def test_losses_rub_by_the_share_of_the_rolling_power(load):
    press = load(PAIR.replace("teeth2=", 'efficiency="0.97" teeth2='))
    (contact,), (rubs,) = press.contacts, press.contacts[0].rubbing
    # 1 N m on the pinion at 1 rad/s: power 1 W rolls; the gears turn by 1.2 rad/s against each other
    torque_of_pinion = 1.0 / press.relations[0].coefficients[press.joints.index("Q")]
    assert math.isclose(abs(torque_of_pinion) * np.linalg.norm(rubs.couple) * rubs.forward * 1.2, 0.03, rel_tol=1e-12)
    assert rubs.forward == rubs.backward
    assert (rubs.first, rubs.second) == (contact.first, contact.second)


@pytest.mark.parametrize(("side", "way", "outward"), [("left", 1, 1), ("right", -1, -1)])
@pytest.mark.parametrize("axis", [1, -1])
@pytest.mark.parametrize("up", [1, -1])
def test_a_rack_rolls_on_its_pinion(load, side, way, outward, axis, up):
    """Left and right are those of the drawing, x to the right, whether the guide's axis points up or down."""
    text = ARBOR.replace("0 -1 0", f"0 {-axis} 0").replace('xyz="0 0 1"', f'xyz="0 0 {up}"').replace("radius", f'side="{side}" radius')
    press = load(text.replace('xyz="0.024 0 0"', 'xyz="0 0 0"'))
    mesh = press.meshes["teeth"]
    assert math.isclose(mesh.ratio, way * axis * up * 0.024, rel_tol=1e-14)
    assert math.isclose(ratio(press, "O", "guide"), mesh.ratio, rel_tol=1e-12)
    np.testing.assert_allclose(press.contacts[0].unit.push, [outward * math.tan(math.radians(20)), 0, 0], atol=1e-16)
    np.testing.assert_allclose(press.contacts[0].unit.force, [0, 0, up], atol=1e-16)
    np.testing.assert_allclose(mesh.pitch_point, [outward * 0.024, 0, 0], atol=1e-16)


def test_a_pinion_between_two_racks_doubles_the_stroke(load):
    """The axle slides along a rack of the frame, and the pinion moves the rack on the other side twice as far."""
    text = robot(
        link("axle") + link("pinion") + link("slide"),
        guide("drive", "axle") + pin("P", "axle", "pinion") + guide("guide", "slide", (0.05, 0, 0)),
        '<rack name="still" pinion="pinion" rack="frame" radius="0.05" side="right"/>\n',
        '<rack name="moving" pinion="pinion" rack="slide" radius="0.05"/>\n',
        driver="drive",
    )
    press = load(text)
    assert [press.meshes[name].carrier for name in ("still", "moving")] == ["axle", "axle"]
    assert math.isclose(ratio(press, "drive", "guide"), 2.0, rel_tol=1e-13)
    with pytest.raises(pp.UrdfError, match="on which side"):  # where the frame's teeth are no drawing says
        load(text.replace(' side="right"', ""))


def test_the_drawing_says_on_which_side_the_pinion_lies(load):
    assert load(ARBOR).meshes["teeth"].side == "left"
    by_module = load(ARBOR.replace('radius="0.024"', 'module="0.004" teeth="12"')).meshes["teeth"]
    assert math.isclose(by_module.radii[0], 0.024, rel_tol=1e-15)


@pytest.mark.parametrize(
    ("said", "force", "up", "down", "efficiency", "backward"),
    [
        ((0.009, 0.0555, 0.12, 15), 1e5, 491.10473131, 200.193181, 0.29166782491, None),
        ((0.2, 0.3, 0.06, 15), 4e6, 166734.714, -88937.205223, 0.76363194812, 0.69851117639),
        ((0.02, 0.05, 0.004, 45), 5e4, 166.31706533, -152.00308934, 0.95693693715, 0.95506357759),
    ],
)
def test_a_screw_lifts_and_lowers_by_the_wedge(load, said, force, up, down, efficiency, backward):
    lead, diameter, *_ = said
    numbers = 'lead="{}" diameter="{}" friction="{}" flank="{}"'.format(*said)
    press = load(SPINDLE.replace('lead="0.2" diameter="0.3" flank="15" friction="0.06"', numbers))
    (contact,), mesh = press.contacts, press.meshes["spindle"]
    (rubs,) = contact.rubbing
    pull = np.linalg.norm(contact.unit.couple) / np.linalg.norm(contact.unit.force)
    assert math.isclose(force * (pull + rubs.forward), up, rel_tol=1e-8)
    assert math.isclose(force * (rubs.backward - pull), down, rel_tol=1e-7)
    assert math.isclose(mesh.efficiency, efficiency, rel_tol=1e-10)
    assert mesh.self_locking == (backward is None)
    if backward is not None:
        assert math.isclose(mesh.efficiency_backward, backward, rel_tol=1e-10)
    assert math.isclose(math.tan(mesh.lead_angle), lead / (math.pi * diameter), rel_tol=1e-14)


def test_a_collar_rubs_on_what_carries_the_screw(load):
    press = load(SPINDLE.replace("friction=", 'collar_friction="0.1" collar_diameter="0.08" friction='))
    _, collar = press.contacts[0].rubbing
    assert (collar.first, collar.second) == (press.joints.index("S") + 1, 0)
    assert math.isclose(collar.forward * np.linalg.norm(collar.couple), 0.004, rel_tol=1e-14)


@pytest.mark.parametrize(("hand", "way"), [("right", 1), ("left", -1)])
def test_a_right_handed_screw_moves_along_its_axis_against_the_nut(load, hand, way):
    assert math.isclose(
        ratio(load(SPINDLE.replace("lead=", f'hand="{hand}" lead=')), "S", "guide"), -way * 0.2 / (2 * math.pi), rel_tol=1e-12
    )
    moving = robot(
        link("slide") + link("screw"),
        guide("guide", "slide") + pin("S", "slide", "screw", axis="0 0 1"),
        f'<screw name="spindle" screw="screw" nut="frame" lead="0.2" hand="{hand}"/>\n',
        driver="S",
    )
    assert math.isclose(ratio(load(moving), "S", "guide"), way * 0.2 / (2 * math.pi), rel_tol=1e-12)


def test_a_worm_pushes_by_its_lead_and_friction(load):
    """T2 2000 N m on the wheel, d2 320 mm."""
    press = load(WORM)
    (contact,), mesh = press.contacts, press.meshes["worm"]
    (rubs,) = contact.rubbing
    force, push = forces(press, 2000.0)
    size = np.abs(force[0] / contact.unit.force[0])
    around = np.linalg.norm(rubs.force) * size
    np.testing.assert_allclose(np.abs(force), [12500, 2500, 0], rtol=1e-12, atol=1e-9)
    assert math.isclose(2500 + rubs.forward * around, 3199.1558129, rel_tol=1e-10)
    assert math.isclose(2500 - rubs.backward * around, 1815.5680209, rel_tol=1e-10)
    assert math.isclose(push[2], 4689.6343637, rel_tol=1e-10)
    assert math.isclose(mesh.efficiency, 0.78145615476, rel_tol=1e-10)
    assert math.isclose(mesh.efficiency_backward, 0.72622720835, rel_tol=1e-10)
    # The worm lies below the wheel. As a right-handed one turns about x, its thread goes to -x, and the wheel with it the way of the clock.
    assert math.isclose(ratio(press, "M", "O"), -0.05, rel_tol=1e-12)
    locking = load(WORM.replace('starts="2"', 'starts="1"').replace("0.05", "0.12"))
    (rubs,), (contact,) = locking.contacts[0].rubbing, locking.contacts
    assert locking.meshes["worm"].self_locking
    assert math.isclose(12500 * (0.1 - rubs.backward), -341.90, abs_tol=5.1e-3)
    by_centres = load(WORM.replace('module="0.008" ', "")).meshes["worm"]
    assert math.isclose(by_centres.module, 0.008, rel_tol=1e-14)


@pytest.mark.parametrize("text", [PAIR.replace("teeth1", 'helix="15" efficiency="0.98" teeth1'), WORM, SPINDLE])
def test_contacts_turn_with_the_whole_press(load, text):
    def lie(press):
        (contact,) = press.contacts
        rubs = [vector for each in contact.rubbing for vector in (each.force, each.couple)]
        return np.array([*contact.unit, *rubs]), [(each.forward, each.backward) for each in contact.rubbing]

    base = '<joint name="base" type="fixed"><parent link="frame"/><child link="base"/><origin rpy="0.3 -0.7 1.1"/></joint>\n'
    turned = text.replace('link="frame"', 'link="base"').replace(
        '<link name="frame"/>\n', f'<link name="frame"/>\n<link name="base"/>\n{base}'
    )
    (there, shares_there), (here, shares) = lie(load(turned)), lie(load(text))
    rotation = pin_rotation(0.3, -0.7, 1.1)
    np.testing.assert_allclose(there, here @ rotation.T, atol=1e-12 * np.abs(here).max())
    np.testing.assert_allclose(shares_there, shares, rtol=1e-12)


def pin_rotation(roll, pitch, yaw):
    """Rotation about x, then y, then z of the world."""
    (a, b), (c, d), (e, f) = ((math.cos(angle), math.sin(angle)) for angle in (roll, pitch, yaw))
    return np.array([[e, -f, 0], [f, e, 0], [0, 0, 1]]) @ [[c, 0, d], [0, 1, 0], [-d, 0, c]] @ [[1, 0, 0], [0, a, -b], [0, b, a]]


# --------------------------------------------------------------------------------------------------------------- a changed press


def test_a_changed_press_keeps_its_elements(load, tmp_path):
    press = load(LEVER)
    for changed in (
        pickle.loads(pickle.dumps(press)),
        replace(press, model=press.model.copy()),
        press.with_inertias(press.model.inertias),
        press.drawn_at(0.4),
        press.drawn_at_home(),
        pp.load(pp.write_urdf(press.drawn_at(0.4), tmp_path / "moved.urdf")),
    ):
        assert (changed.meshes["teeth"].carrier, changed.contacts[0].relation) == ("crank", 0)
        np.testing.assert_allclose(changed.contacts[0].unit, press.contacts[0].unit, atol=1e-14)
        assert dict(changed.relations[0].coefficients) == dict(press.relations[0].coefficients)
    assert pp.write_urdf(press, tmp_path / "same.urdf").read_text() == LEVER
    # Longer arms have larger gears; what the relation says stays.
    model = press.model.copy()
    model.jointPlacements[2].translation = np.array([0.07, 0, 0])
    longer = replace(press, model=model)
    np.testing.assert_allclose(longer.contacts[0].unit.point, [0.14, 0, 0], atol=1e-16)
    np.testing.assert_allclose(longer.contacts[0].unit.force, press.contacts[0].unit.force * 6 / 7, atol=1e-12)


def test_teeth_mesh_as_drawn_where_the_press_is_put_together_elsewhere(load):
    apart = load(LEVER.replace('xyz="0.3 0 0"', 'xyz="0.27 0 0"'), pose={"A1": 0.5})
    motion = pp.servo_cycle(apart, angle=np.radians([10, 20]), speed=10.0, acceleration=0.0)
    np.testing.assert_allclose(motion.slide_position, [0.2922685075, 0.2729574102], rtol=0, atol=5.1e-11)


def test_pins_of_one_axis_may_deviate_from_each_other(load):
    press = load(LEVER)
    apart = pp.derivatives.reshaped(press, {("A1", "frame"): (1e-4, 0, 0)})
    assert apart.meshes["teeth"].carrier == "crank"
    np.testing.assert_array_equal(apart.contacts[0].unit, press.contacts[0].unit)


def test_two_drivers_of_a_train_can_be_made_one(load):
    text = PLANETARY.replace('gear2="frame"', 'gear2="ring"').replace("</robot>", link("ring") + pin("R", "frame", "ring") + "</robot>")
    press = load(text, drivers=["S", "R"])
    one = press.with_one_driver("S", {"R": 0.25})
    assert len(one.contacts) == 2
    rates = dict(zip(one.joints, pp.servo_cycle(one, angle=[0.0], speed=1.0, acceleration=0.0).v[0], strict=True))
    assert math.isclose(rates["C"], 0.2 + 0.8 * 0.25, rel_tol=1e-13)


# ---------------------------------------------------------------------------------------------------------------------------- refusals


def without(text, *parts):
    for part in parts:
        text = text.replace(part, "")
    return text


REFUSED = [
    (PAIR, 'gear1="pinion"', 'gear1="pinoin"', "no link 'pinoin', did you mean 'pinion'"),
    (PAIR, 'gear2="wheel"', 'gear2="pinion"', "both are link 'pinion'"),
    (PAIR, 'teeth1="20"', 'teeth1="20.5"', "teeth of the first gear is 20.5; write a whole number"),
    (PAIR, 'teeth1="20"', 'teeth1="0"', "teeth of the first gear is 0"),
    (PAIR, ' teeth1="20"', "", "has no teeth1"),
    (PAIR, 'teeth1="20"', 'teeth1="20" tooth="3"', "unknown attribute 'tooth'; in <gear_mesh> write: name, gear1"),
    (PAIR, 'teeth2="100"', 'teeth2="-20"', "the internal gear has 20 teeth, and the pinion in it 20"),
    (PAIR, 'teeth1="20" teeth2="100"', 'teeth1="-20" teeth2="-100"', "both gears are internal"),
    (PAIR, "teeth1=", 'pressure_angle="0.35" teeth1=', "pressure_angle is 0.35 deg, as if in radians; write degrees: 20.0535"),
    (PAIR, "teeth1=", 'pressure_angle="50" teeth1=', "pressure_angle is 50 deg; write degrees, from 0 to 45"),
    (PAIR, "teeth1=", 'helix="-15" teeth1=', "helix is -15 deg; write degrees, from 0 to 60; hand says the sense"),
    (PAIR, "teeth1=", 'hand="links" teeth1=', "hand is 'links'; write hand: right or left"),
    (PAIR, "teeth1=", 'efficiency="98.5" teeth1=', "efficiency is 98.5; write a share above 0, up to 1"),
    (PAIR, "teeth1=", 'efficiency="0" teeth1=', "efficiency is 0;"),
    (PAIR, "teeth1=", 'module="10" teeth1=', "module is 10 m; a URDF has metres: 0.01 for 10 mm"),
    (PAIR, "teeth1=", 'module="0.008" teeth1=', "module 8 mm makes a centre distance of 480 mm, and the axes are 600 mm apart; correct"),
    (PAIR, "teeth1=", 'carrier="wheel" teeth1=', "its carrier 'wheel' is one of the two itself"),
    (PAIR, "teeth1=", 'center1="0.1 0 0" teeth1=', "no pin of link 'pinion' is at the centre (0.1, 0, 0) of its gear: 'Q' is 100 mm away"),
    (PAIR, 'name="teeth"', 'name="Q"', "the name is already that of a <joint>"),
    (PAIR, "</robot>", '<gear_mesh name="again" gear1="wheel" gear2="pinion" teeth1="5" teeth2="1"/></robot>', "mesh already, in 'teeth'"),
    (
        PAIR,
        'xyz="-0.6 0.0 0.0"',
        'xyz="0 0 0"',
        "'pinion' and 'wheel' are in one point: their distance is 0; write <mimic>, in a table gears:",
    ),
    (
        PAIR.replace("0 -1 0", "1 0 0", 1),
        'name="teeth"',
        'name="bevel"',
        "not parallel; a worm is for axes that cross; bevel gears are not",
    ),
    (
        PAIR,
        '<child link="wheel"/><origin xyz="0.0 0.0 0.0"/><axis xyz="0 -1 0"/>',
        '<child link="wheel"/><origin xyz="0.0 0.0 0.0"/><axis xyz="0 -1 0"/><mimic joint="Q" multiplier="-0.2"/>',
        "joints 'O' and 'Q' are related already, by joint 'O'; remove one of the two",
    ),
    (
        LEVER,
        'gear1="ring" gear2="rod" teeth1="-40" teeth2="20"',
        'gear1="slide" gear2="rod" teeth1="40" teeth2="20"',
        "no link holds both, so that the teeth would part; let one link carry both axes",
    ),
    (LEVER, 'teeth2="20"', 'teeth2="20" carrier="frame"', "link 'frame' does not hold both"),
    (PLANETARY, 'teeth2="-80"', 'teeth2="-90"', "gear 'planet' has module 8.33333 mm, in gear mesh 'sun_pl' 10 mm"),
    (PLANETARY, "teeth1", 'helix="15" teeth1', "the helix of gear 'planet' is right, in gear mesh 'sun_pl' left; correct one hand"),
    (PLANETARY, 'teeth2="30"', 'teeth2="30" planets="3"', "3 planets do not fit between sun and ring: (20 + 80)/3 is not whole"),
    (ARBOR, 'radius="0.024"', 'radius="24"', "radius is 24 m; a URDF has metres: 0.024 for 24 mm"),
    (ARBOR, ' radius="0.024"', "", "its pinion has no radius; give a radius, or else module and teeth"),
    (ARBOR, "radius=", 'module="0.004" teeth="12" radius=', "its radius is given twice"),
    (ARBOR, 'xyz="0.024 0 0"', 'xyz="0 0 0"', "the drawing does not say on which side of the rack the pinion lies; write side"),
    (ARBOR, 'xyz="0 0 1"', 'xyz="0 1 0"', "the rack is not guided across the pinion's axis"),
    (ARBOR, 'rack="slide"', 'rack="frame"', "no link that carries the pinion guides 'frame'; let one link carry"),
    (SPINDLE, 'lead="0.2"', 'lead="200"', "lead is 200 m a turn; a URDF has metres: 0.2 for 200 mm"),
    (SPINDLE, 'lead="0.2"', 'lead="0"', "its lead is 0"),
    (SPINDLE, 'diameter="0.3" ', "", "it has friction and no diameter"),
    (SPINDLE, 'friction="0.06"', 'friction="6"', "friction is 6; write a coefficient of friction from 0"),
    (SPINDLE, 'friction="0.06"', 'collar_friction="0.1"', "its collar has friction and no diameter"),
    (SPINDLE.replace('<axis xyz="0 0 1"/></joint>', '<axis xyz="0 -1 0"/></joint>', 1), "press", "other", "not guided along the axis"),
    (WORM, 'module="0.008" quotient="10"', "", "neither its module nor its quotient is given"),
    (WORM, 'quotient="10"', 'quotient="15"', "module 8 mm makes a centre distance of 220 mm, and the axes are 200 mm apart"),
    (WORM, '<axis xyz="1 0 0"/>', '<axis xyz="0.8 0.6 0"/>', "the axes of worm and wheel are not at a right angle"),
]


@pytest.mark.parametrize(("text", "old", "new", "message"), REFUSED, ids=[each[3] for each in REFUSED])
def test_bad_elements_are_refused(load, text, old, new, message):
    wrong = text.replace(old, new)
    assert wrong != text
    with pytest.raises(pp.UrdfError) as caught:
        load(wrong)
    tag = next(tag for tag in ("gear_mesh", "rack", "screw", "worm") if f"<{tag}" in text)
    assert message in str(caught.value)
    assert caught.value.element.startswith(f"<{tag} name=")
    assert f"<{tag}" in wrong.splitlines()[caught.value.line - 1]
    assert caught.value.remedy


def test_a_lead_larger_than_the_press_is_doubted(load):
    with pytest.warns(pp.PinpressWarning, match=r"screw.*lead is 0.9 m, in a linkage of 0.25 m"):
        load(SPINDLE.replace('lead="0.2"', 'lead="0.9"').replace("-0.5", "-0.25"))


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [(SPINDLE, 'lead="0.2"', 'lead="0.00002"', "lead is 0.02 mm"), (ARBOR, 'radius="0.024"', 'radius="0.000024"', "radius is 0.024 mm")],
)
def test_metres_taken_for_millimetres_are_doubted(load, text, old, new, message):
    with pytest.warns(pp.PinpressWarning, match=message):
        load(text.replace(old, new))


def test_planets_that_fit_count_at_both_their_meshes(load):
    press = load(PLANETARY.replace('teeth2="30"', 'teeth2="30" planets="4"'))
    assert [press.meshes[name].planets for name in ("sun_pl", "ring_pl")] == [4, 4]


def test_a_pair_of_coordinates_on_two_carriers_is_noted(tmp_path):
    path = tmp_path / "press.urdf"
    geared = '<axis xyz="0 -1 0"/><mimic joint="B" multiplier="0.4"/></joint>\n<joint name="B"'
    text = LEVER.replace('<axis xyz="0 -1 0"/></joint>\n<joint name="B"', geared)
    path.write_text("\n".join(line for line in text.splitlines() if "gear_mesh" not in line))
    (note,) = (finding for finding in pp.check(path).findings if "no link carries the axes of both" in finding.problem)
    assert "<gear_mesh>" in note.remedy
    assert "meshes:" in note.remedy


def test_what_contradicts_is_named_by_its_element(load):
    locked = PLANETARY.replace("</robot>", '<gear_mesh name="lock" gear1="sun" gear2="planet2" teeth1="20" teeth2="30"/></robot>')
    locked = locked.replace(
        '<gear_mesh name="sun_pl"', link("planet2") + pin("P2", "frame", "planet2", (0, 0, 0.25)) + '<gear_mesh name="sun_pl"'
    )
    ring = '<gear_mesh name="still" gear1="planet2" gear2="arm" teeth1="30" teeth2="-80"/></robot>'
    with pytest.raises(pp.UrdfError, match=r"mobility is 0.*gear mesh 'still'"):
        load(locked.replace("</robot>", ring))


def test_the_first_of_two_that_mesh_is_proposed_as_driver(load, tmp_path):
    path = tmp_path / "undriven.urdf"
    for text, driver in ((PAIR, "Q"), (WORM, "M"), (PLANETARY, "S")):
        path.write_text(text.replace(DRIVE.format(driver), ""))
        assert pp.propose_drivers(path).drivers == (driver,)


def test_check_lists_elements_below_the_bearings(tmp_path):
    path = tmp_path / "press.urdf"
    path.write_text(LEVER)
    (teeth,) = (each for each in pp.check(path).facts.closings if each.name == "teeth")
    assert (teeth.type, teeth.between) == ("gear mesh", ("ring", "rod"))
    assert "teeth   gear mesh        ring - rod      closed" in str(pp.check(path))
    assert pp.load(path).tool.name == "pin C"  # the ring drives the rod by its teeth


def test_presses_with_other_teeth_are_told_apart(load):
    other = load(PAIR.replace("teeth2=", 'pressure_angle="25" teeth2='))
    assert is_same_press(load(PAIR), load(PAIR.replace("<link", "\n<link")))
    assert not is_same_press(load(PAIR), other)
