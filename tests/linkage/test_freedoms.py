"""Freedoms that no motor moves: spins and swings of rods in one piece and in several, against the closed form of RSSR and beside universal
joints; passive coordinates; drivers that are proposed, or depend on each other."""

import numpy as np
import pinocchio as pin
import pytest
from reference.robots.cases import BASE, CASES
from support import texts

import pinpress as pp
from pinpress.cli.main import main

CRANK, ROCKER, FRAME, OFFSET = 0.06, 0.14, 0.12, 0.2  # m: crank about z at the origin, rocker about x at (FRAME, OFFSET, 0)
BALL_A = np.array([CRANK, 0.0, 0.0])  # as drawn
BALL_B = np.array([FRAME, OFFSET, ROCKER])
LENGTH = float(np.linalg.norm(BALL_B - BALL_A))
ALONG = (BALL_B - BALL_A) / LENGTH


def across(direction):
    """Two axes (3,) across a direction, with it a right-handed frame."""
    first = np.cross(direction, [0.0, 0.0, 1.0])
    first /= np.linalg.norm(first)
    return first, np.cross(direction, first)


def words(vector):
    return " ".join(repr(float(part)) for part in vector)


def rssr(axes, rod_inertia=(0.0, 0.01, 0.01), eccentricity=0.0):
    """URDF of an RSSR linkage whose rod hangs by hinges along these axes, with massless crosses between them, and closes by a ball.

    Args:
        axes: of the hinges at the crank's ball, in the world as drawn.
        rod_inertia: moments of inertia of the rod along itself and across [kg m2].
        eccentricity: distance of the rod's centre of mass from its line [m].
    """
    first, _ = across(ALONG)
    turned = np.column_stack([ALONG, first, np.cross(ALONG, first)])
    tensor = turned @ np.diag(rod_inertia) @ turned.T
    moments = " ".join(f'i{"xyz"[i]}{"xyz"[j]}="{float(tensor[i, j])!r}"' for i in range(3) for j in range(i, 3))
    centre = 0.5 * (BALL_B - BALL_A) + eccentricity * first
    crosses = [f"cross{k}" for k in range(1, len(axes))]
    none = " ".join(f'i{part}="0"' for part in ("xx", "xy", "xz", "yy", "yz", "zz"))
    links = ['<link name="frame"/>']
    links += [f'<link name="{name}"><inertial><mass value="0"/><inertia {none}/></inertial></link>' for name in crosses]
    body = '<link name="{}"><inertial><origin xyz="{}"/><mass value="{}"/><inertia {}/></inertial></link>'
    plain = 'ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"'
    links += [body.format("crank", "0.02 0 0", 4, plain), body.format("rocker", "0 0 0.07", 6, plain)]
    links.append(body.format("rod", words(centre), 3, moments))
    joint = '<joint name="{}" type="continuous"><parent link="{}"/><child link="{}"/><origin xyz="{}"/><axis xyz="{}"/></joint>'
    joints = [joint.format("O", "frame", "crank", "0 0 0", "0 0 1")]
    joints.append(joint.format("Q", "frame", "rocker", words([FRAME, OFFSET, 0.0]), "1 0 0"))
    chain = ["crank", *crosses, "rod"]
    for k, axis in enumerate(axes):
        place = BALL_A if k == 0 else np.zeros(3)
        joints.append(joint.format("A" if k == len(axes) - 1 else f"A{k + 1}", chain[k], chain[k + 1], words(place), words(axis)))
    loop = f'<loop_joint name="B" type="spherical"><link1 link="rod" xyz="{words(BALL_B - BALL_A)}"/>'
    loop += f'<link2 link="rocker" xyz="0 0 {ROCKER}"/></loop_joint>'
    return f'<robot name="rssr">{"".join(links + joints)}{loop}<transmission name="t"><joint name="O"/></transmission></robot>'


UNIVERSAL = across(ALONG)
BALL = (*UNIVERSAL, ALONG)
OBLIQUE = (UNIVERSAL[1], UNIVERSAL[0], (ALONG + 0.3 * UNIVERSAL[0]) / np.sqrt(1.09))  # a free motion of all three hinges


def rocker_angle(crank):
    """Angle of the rocker from the drawn pose, by the length of the rod from (x, y, 0) to (FRAME, OFFSET - ROCKER sin, ROCKER cos)."""
    x, y = CRANK * np.cos(crank), CRANK * np.sin(crank)
    return np.arcsin(((FRAME - x) ** 2 + (OFFSET - y) ** 2 + ROCKER**2 - LENGTH**2) / (2 * ROCKER * (OFFSET - y)))


@pytest.mark.exhaustive
@pytest.mark.parametrize("axes", [BALL, OBLIQUE])
def test_the_output_angle_of_a_rod_between_balls_is_that_of_the_closed_form(axes):
    press = texts.load(rssr(axes))
    assert (press.mobility, press.held) == (2, ("A",))
    motion = pp.cycle(press, 10.0, points=48)
    found = motion.joint_position[:, press.joints.index("Q")]
    np.testing.assert_allclose(found, rocker_angle(motion.crank_angle), rtol=0, atol=1e-11)
    assert np.abs(motion.joint_position[:, press.joints.index("A")]).max() < 1e-15
    assert "5 joints less 3 equations of loops and gear pairs" in str(pp.check(press.file))


@pytest.mark.exhaustive
def test_forces_of_a_slender_rod_do_not_depend_on_how_its_spin_is_held():
    presses = [texts.load(rssr(axes)) for axes in (BALL, OBLIQUE, UNIVERSAL)]
    assert [len(press.held) for press in presses] == [1, 1, 0]
    found = [pp.inverse_dynamics(press, pp.cycle(press, 10.0, points=16)) for press in presses]
    scale = max(np.abs(force).max() for force in found[2].bearing_force.values())
    for other in found[:2]:
        np.testing.assert_allclose(other.driving_torque, found[2].driving_torque, rtol=0, atol=1e-12 * scale)
        np.testing.assert_allclose(other.shaking_moment, found[2].shaking_moment, rtol=0, atol=1e-11 * scale)
        for name in ("O", "Q", "A", "B"):
            np.testing.assert_allclose(other.bearing_force[name], found[2].bearing_force[name], rtol=0, atol=1e-11 * scale)
        assert np.abs(other.power_residual).max() < 1e-12
        assert (len(other.coupling_torque), len(other.indeterminate_coupling)) == (0, 0)


@pytest.mark.exhaustive
def test_runs_of_a_rod_between_balls(method):
    ball, universal = (texts.load(rssr(axes)) for axes in (BALL, UNIVERSAL))
    runs = [pp.simulate(press, 0.1, speed=6.0, method=method, points=7) for press in (ball, universal)]
    np.testing.assert_allclose(runs[0].crank_angle, runs[1].crank_angle, rtol=0, atol=1e-8)
    pp.inverse_dynamics(ball, runs[0])


def test_check_says_which_spin_is_held():
    found = pp.check(texts.load(rssr(BALL)).file)
    assert not found.errors
    assert any("link 'rod' can spin about the line" in note.problem and "held, with joint 'A'" in note.remedy for note in found.notes)
    assert str(found)


def test_a_rod_out_of_balance_is_held_with_a_warning():
    with pytest.warns(pp.PinpressWarning, match="about a line 12 mm from its centre of mass: .* weight would turn"):
        press = texts.load(rssr(BALL, eccentricity=0.012))
    (swing,) = press.freedoms
    assert (swing.kind, swing.joints[0], swing.bodies, press.held) == ("swing", "A", ("rod",), ("A",))
    assert swing.eccentricity == pytest.approx(0.012, rel=1e-9)


def test_written_and_read_again(tmp_path):
    press = texts.load(rssr(BALL))
    pp.write_urdf(press, tmp_path / "again.urdf")
    again = pp.load(tmp_path / "again.urdf")
    assert again.held == press.held
    heavier = press.with_inertias([pin.Inertia(2 * i.mass, i.lever, 2 * i.inertia) for i in press.model.inertias])
    assert heavier.held == press.held


def test_a_link_that_hangs_free_is_no_spin():
    text = rssr(UNIVERSAL).replace("</robot>", "")
    text += '<link name="bob"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>'
    text += '<inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial></link>'
    text += '<joint name="hang" type="continuous"><parent link="rocker"/><child link="bob"/><axis xyz="0 1 0"/></joint>'
    with pytest.warns(pp.PinpressWarning, match="no driver moves joint 'hang'"):
        press = texts.load(text + "</robot>")
    assert [(each.kind, each.joints, each.bodies) for each in press.freedoms] == [("passive", ("hang",), ("bob",))]
    assert (press.motors, press.passive, press.held) == (("O",), ("hang",), ())


SDF = """<sdf version="1.7"><model name="rssr">
<link name="crank"><inertial><pose>0.02 0 0 0 0 0</pose><mass>4</mass>{plain}</inertial></link>
<link name="rocker"><pose>{q} 0 0 0</pose><inertial><pose>0 0 0.07 0 0 0</pose><mass>6</mass>{plain}</inertial></link>
<link name="rod"><pose>{a} 0 0 0</pose><inertial><pose>{centre} 0 0 0</pose><mass>3</mass>{thin}</inertial></link>
<joint name="O" type="revolute"><parent>world</parent><child>crank</child><axis><xyz>0 0 1</xyz></axis></joint>
<joint name="Q" type="revolute"><parent>world</parent><child>rocker</child><axis><xyz>1 0 0</xyz></axis></joint>
<joint name="A" type="ball"><parent>crank</parent><child>rod</child></joint>
<joint name="B" type="ball"><pose>0 0 {rocker} 0 0 0</pose><parent>rod</parent><child>rocker</child></joint></model></sdf>"""
MJCF = """<mujoco model="rssr"><option gravity="0 0 -9.81"/><worldbody>
<body name="crank"><joint name="O" axis="0 0 1"/><inertial pos="0.02 0 0" mass="4" diaginertia="0.02 0.02 0.02"/>
<body name="rod" pos="{a}"><joint name="A" type="ball"/><inertial pos="{centre}" mass="3" fullinertia="{moments}"/></body></body>
<body name="rocker" pos="{q}"><joint name="Q" axis="1 0 0"/><inertial pos="0 0 0.07" mass="6" diaginertia="0.02 0.02 0.02"/></body>
</worldbody><equality><connect name="B" body1="rod" body2="rocker" anchor="{way}"/></equality></mujoco>"""


@pytest.mark.exhaustive
@pytest.mark.parametrize(("ending", "text"), [("sdf", SDF), ("xml", MJCF)])
def test_balls_of_other_formats_follow_whole_turns(ending, text):
    """The axes of the links are those of the world, so that hinges about these axes would lock at 54 degrees."""
    tensor = 0.01 * (np.eye(3) - np.outer(ALONG, ALONG)) + 1e-9 * np.eye(3)
    named = {f"i{'xyz'[i]}{'xyz'[j]}": repr(float(tensor[i, j])) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))}
    places = {"q": [FRAME, OFFSET, 0.0], "a": BALL_A, "centre": 0.5 * (BALL_B - BALL_A), "way": BALL_B - BALL_A}
    text = text.format(
        **{name: words(place) for name, place in places.items()},
        rocker=ROCKER,
        plain="<inertia><ixx>0.02</ixx><iyy>0.02</iyy><izz>0.02</izz></inertia>",
        thin=f"<inertia>{''.join(f'<{name}>{value}</{name}>' for name, value in named.items())}</inertia>",
        moments=" ".join(named.values()),
    )
    press = texts.load(text, name=f"rssr.{ending}", driver="O")
    assert press.held == ("A_z",)
    motion = pp.cycle(press, 10.0, points=24)
    np.testing.assert_allclose(motion.joint_position[:, press.joints.index("Q")], rocker_angle(motion.crank_angle), rtol=0, atol=1e-11)
    torque = pp.inverse_dynamics(press, motion).driving_torque
    universal = texts.load(rssr(UNIVERSAL))
    expected = pp.inverse_dynamics(universal, pp.cycle(universal, 10.0, points=24)).driving_torque
    np.testing.assert_allclose(torque, expected, rtol=0, atol=1e-6 * np.abs(expected).max())  # the rod has 1e-9 kg m2 about its line


# ---------------------------------------------------------------------------------------------------- rods in several pieces


def link(name, along=None, mass=0.0, at=0.5, length=LENGTH, off=0.0):
    """A link; with a direction a slender body along it that reaches from its origin over a length, its centre ``off`` the line [m]."""
    tensor, centre = np.zeros((3, 3)), np.zeros(3)
    if along is not None:
        tensor = mass * length**2 / 12 * (np.eye(3) - np.outer(along, along))
        centre = at * length * along + off * across(along)[0]
    moments = " ".join(f'i{"xyz"[i]}{"xyz"[j]}="{float(tensor[i, j])!r}"' for i in range(3) for j in range(i, 3))
    return f'<link name="{name}"><inertial><origin xyz="{words(centre)}"/><mass value="{mass}"/><inertia {moments}/></inertial></link>'


def unit(random):
    """A random direction (3,)."""
    vector = random.normal(size=3)
    return vector / np.linalg.norm(vector)


def cut_rod(shares, seed, off=0.0):
    """URDF of `rssr` with its rod cut in pieces, of these shares of its length: the first hangs on the crank by a ball, the last on the
    rocker, and each on its neighbour by a hinge of any axis, which a weld locks. Crank and rocker are as in `rssr`."""
    random, count = np.random.default_rng(seed), len(shares)
    text = rssr(UNIVERSAL)
    joint = '<joint name="{}" type="continuous"><parent link="{}"/><child link="{}"/><origin xyz="{}"/><axis xyz="{}"/></joint>'
    weld = '<loop_joint name="weld{}" type="fixed"><link1 link="{}" xyz="{}"/><link2 link="{}" xyz="{}"/></loop_joint>'
    begin, parts = text.index('<link name="cross1">'), []
    kept = text[:begin] + text[text.index('<link name="crank">') : text.index('<link name="rod">')]
    kept += "".join(part + "</joint>" for part in text.split("</joint>")[:2])[text.index('<joint name="O"') :]
    from_crank = int(random.integers(1, count))  # pieces that hang on the crank
    for ball, carrier, place in (("A", "crank", BALL_A), ("B", "rocker", np.array([0.0, 0.0, ROCKER]))):
        parents = [carrier, f"{ball}_1", f"{ball}_2"]
        axes = np.linalg.qr(random.normal(size=(3, 3)))[0].T
        children = [*parents[1:], "piece0" if ball == "A" else f"piece{count - 1}"]
        for k, (parent, child, axis) in enumerate(zip(parents, children, axes, strict=True)):
            parts.append(joint.format(f"{ball}{k}", parent, child, words(place if k == 0 else np.zeros(3)), words(axis)))
        parts += [link(parent) for parent in parents[1:]]
    lengths = np.array(shares) / sum(shares) * LENGTH
    for k, length in enumerate(lengths):
        way = ALONG if k < from_crank else -ALONG  # its origin is at the end from which it hangs
        parts.append(link(f"piece{k}", way, 3.0 * length / LENGTH, length=length, off=off if k < from_crank else 0.0))
        end = length * ALONG
        if k + 1 == from_crank:
            parts.append(weld.format(k, f"piece{k}", words(end), f"piece{k + 1}", words(-lengths[k + 1] * ALONG)))
        elif k + 1 < from_crank:
            parts.append(joint.format(f"H{k}", f"piece{k}", f"piece{k + 1}", words(end), words(unit(random))))
            parts.append(weld.format(k, f"piece{k}", words(end), f"piece{k + 1}", "0 0 0"))
        elif k + 1 < count:
            parts.append(joint.format(f"H{k}", f"piece{k + 1}", f"piece{k}", words(-lengths[k + 1] * ALONG), words(unit(random))))
            parts.append(weld.format(k, f"piece{k}", "0 0 0", f"piece{k + 1}", words(-lengths[k + 1] * ALONG)))
    return kept + "".join(parts) + '<transmission name="t"><joint name="O"/></transmission></robot>'


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize(("seed", "wrong"), [(0, 0.0), (1, 0.0), (2, 0.0), (4, 0.0), (1, 1e-7), (5, 0.0), (2, 1e-5), (5, 1e-4), (3, 0.0)])
def test_a_rod_in_pieces_moves_like_one_in_one_piece(seed, wrong):
    """Also where the angles of the welds are a little wrong [rad], so that hinges and welds contradict each other."""
    shares = np.random.default_rng(seed).uniform(0.3, 1.0, 2 + seed % 3)
    press = texts.load(cut_rod(shares, seed).replace('<link2 link="piece', f'<link2 rpy="{wrong} {-wrong} {wrong}" link="piece'))
    pieces = {f"piece{k}" for k in range(len(shares))}
    (spin,) = press.freedoms
    assert (spin.kind, set(spin.bodies), spin.joints[0], press.mobility) == ("spin", pieces, press.held[0], 2)
    whole = texts.load(rssr(UNIVERSAL, rod_inertia=(0.0, 3 * LENGTH**2 / 12, 3 * LENGTH**2 / 12)))
    torques = [pp.inverse_dynamics(each, pp.servo_cycle(each, [0.0, 0.2], speed=[3.0] * 2)).driving_torque for each in (press, whole)]
    np.testing.assert_allclose(*torques, rtol=0, atol=max(1e-9, 3 * wrong) * np.abs(torques[1]).max())


@pytest.mark.parametrize(("off", "kind"), [(0.0, "spin"), (0.5e-6, "spin"), (2e-6, "swing"), (0.02, "swing")])
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_a_swing_is_a_spin_whose_centre_of_mass_is_off_the_line(off, kind):
    """Off by these shares of the linkage's size, and of the pieces of a rod together."""
    size = texts.load(rssr(BALL)).size
    assert [each.kind for each in texts.load(rssr(BALL, eccentricity=off * size)).freedoms] == [kind]
    if off:
        shares, both = (0.5, 0.5), 2.0 * off * size  # one half is off by twice as much as the whole
        (freedom,) = texts.load(cut_rod(shares, 0, off=both)).freedoms
        assert (freedom.kind, freedom.eccentricity) == (kind, pytest.approx(off * size, rel=1e-6))


# ---------------------------------------------------------------------------------------------------------- what is neither spin nor swing


BODY = '<link name="{}"><inertial><origin xyz="{}"/><mass value="2"/><inertia ixx="1e-2" ixy="0" ixz="0" iyy="1e-2" iyz="0" izz="1e-2"/>'
BODY += "</inertial></link>"
JOINT = '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><origin xyz="{}"/><axis xyz="{}"/>'
JOINT += '<limit lower="-1" upper="1" effort="9" velocity="9"/></joint>'
DRIVEN = '<transmission name="{0}"><joint name="{0}"/></transmission>'


def four_bar(on, last="", drives=("crank",)):
    """Elements of a four-bar that stands in the x-z plane on a link, whose rocker and crank are 0.3 m long and 0.4 m apart."""
    joints = (
        ("crank", on, "bar1", "0 0 0", "0 -1 0"),
        ("knee", "bar1", "bar2", "0.1 0 0.3", "0 -1 0"),
        ("rocker", on, "bar3", "0.4 0 0", "0 -1 0"),
    )
    centres = {"bar1": "0.05 0 0.15", "bar2": "0.2 0 0", "bar3": "0.05 0 0.2"}
    text = "".join(BODY.format(name, centre) for name, centre in centres.items())
    text += "".join(JOINT.format(name, "revolute", *rest) for name, *rest in joints)
    loop = '<loop_joint name="top" type="spherical"><link1 link="bar2" xyz="0.4 0 0.05"/><link2 link="bar3" xyz="0.1 0 0.35"/></loop_joint>'
    return f'<robot name="leg"><link name="frame"/>{text}{loop}{last}{"".join(map(DRIVEN.format, drives))}</robot>'


HIP = BODY.format("hip", "0 0 0.1") + JOINT.format("yaw", "revolute", "frame", "hip", "0 0 1", "0 0 1")


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_a_leg_about_a_vertical_axis_is_no_spin():
    """Gravity does no work on it either; it hangs on one bearing."""
    press = texts.load(four_bar("hip", HIP))
    assert [(each.kind, each.joints, each.held) for each in press.freedoms] == [("passive", ("yaw",), False)]
    assert set(press.freedoms[0].bodies) == {"hip", "bar1", "bar2", "bar3"}
    assert (press.mobility, press.drivers, press.motors, press.held) == (2, ("crank", "yaw"), ("crank",), ())


def test_a_rod_without_mass_that_spins_is_held():
    """It has no inertia by which its acceleration would follow."""
    press = texts.load(rssr(BALL, rod_inertia=(0.0, 0.0, 0.0)).replace('<mass value="3"/>', '<mass value="0"/>'))
    (spin,) = press.freedoms
    assert (spin.kind, spin.bodies, spin.eccentricity, press.held, press.passive) == ("spin", ("rod",), 0.0, ("A",), ())


def robot(number, **options):
    """One of the small files of robots."""
    case = next(each for each in CASES if each.file.startswith(number))
    return pp.load(case.path, **{"driver": None} | options)


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize(
    ("number", "options", "motors", "found"),
    [
        ("16", {}, ("crank_turn",), [("spin", {"half_1", "half_2"})]),
        ("17", {}, ("stroke1", "stroke2"), [("spin", {"tube1", "stem1"}), ("spin", {"tube2", "stem2"})]),
        ("18", {"base": "floating"}, ("turn_a", "turn_b"), [("base", {"frame", "crank_a", "rod_a", "crank_b", "rod_b"})] * 6),
        ("22", {}, ("turn_a",), [("spring", {"rod_a", "crank_b", "rod_b"})]),
        ("27", {}, ("turn_a", "turn_b"), []),
    ],
)
def test_kinds_of_freedoms(number, options, motors, found):
    if number == "22":
        pytest.importorskip("mujoco")
    press = robot(number, **options)
    assert [(each.kind, set(each.bodies)) for each in press.freedoms] == found
    assert press.motors == motors
    assert (*press.held, *press.passive) == tuple(each.joints[0] for each in press.freedoms)
    if number == "18":
        assert press.passive == BASE
    if number == "22":
        assert press.passive == ("knee_a",) == press.sprung


# ------------------------------------------------------------------------------------------------------------------------------- drivers


def test_drivers_that_depend_on_the_others_are_left_out():
    with pytest.warns(
        pp.PinpressWarning,
        match=r"3 drivers are named, but only 2 move it .*; .* loaded without knee_a, as with drivers=\['turn_a', 'turn_b'\]",
    ):
        press = robot("12", driver=["turn_a", "knee_a", "turn_b"])
    assert (press.motors, press.passive) == (("turn_a", "turn_b"), ())


def test_drivers_that_hardly_determine_a_linkage_are_warned_of():
    """The rods of the five-bar lie nearly on each other: cranks that stand let them turn together, nearly."""
    nearly = {"turn_a": -1.1697, "turn_b": 1.1, "knee_a": 2.85, "knee_b": -0.94}
    with pytest.warns(pp.PinpressWarning, match="drivers turn_a, turn_b hardly determine it: conditioning 0.01 of 1"):
        robot("12", pose=nearly)


@pytest.mark.parametrize(
    ("number", "best"), [("13", ("shoulder",)), ("16", ("crank_turn",)), ("19", ("turn_a", "turn_b")), ("24", ("grip_l",))]
)
def test_drivers_are_proposed(number, best):
    pytest.importorskip("mujoco")
    case = next(each for each in CASES if each.file.startswith(number))
    assert pp.propose_drivers(case.path).drivers == best


def test_of_two_fingers_that_a_gear_joins_either_may_drive():
    pytest.importorskip("mujoco")
    proposal = pp.propose_drivers(robot("24"))
    assert (proposal.drivers, proposal.others) == (("grip_l",), ("grip_r",))
    assert proposal.conditioning == pytest.approx(np.sqrt(0.5)) == proposal.conditioning_of_others


def test_a_file_that_names_no_driver_is_checked_with_those_proposed(capsys):
    case = next(each for each in CASES if each.file.startswith("19"))
    assert main(["check", str(case.path)]) == 0
    said = capsys.readouterr().out
    assert "note: no driver is named" in said
    assert "drivers=['turn_a', 'turn_b']" in said
    with pytest.raises(pp.UrdfError, match=r"no driver; its mobility as drawn is 2: name what drives, best drivers=\['turn_a', 'turn_b'\]"):
        pp.load(case.path)


def test_a_press_refuses_what_a_robot_may_leave_free():
    text = rssr(BALL, eccentricity=0.012)
    rocker = '<joint name="Q" type="continuous"><parent link="frame"/><child link="rocker"/>'
    assert rocker in text
    ram = text.replace(rocker, rocker.replace("continuous", "prismatic")).replace(
        '<axis xyz="1 0 0"/></joint>', '<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1e6" velocity="9"/></joint>', 1
    )
    with pytest.raises(pp.UrdfError, match=r"mobility is 2, .*link 'rod' can spin about a line 12 mm from its centre of mass"):
        texts.load(ram)


def test_a_slide_that_carries_all_else_is_the_base_of_a_robot():
    """A leg on two slides: it falls freely, whatever its hip does."""
    body = '<link name="{}"><inertial><origin xyz="0.1 0 -0.2"/><mass value="3"/>'
    body += '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    joint = '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><axis xyz="{}"/>'
    joint += '<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>'
    joints = [
        ("x", "prismatic", "frame", "cart", "1 0 0"),
        ("z", "prismatic", "cart", "hip", "0 0 1"),
        ("hip", "revolute", "hip", "leg", "0 1 0"),
    ]
    drive = '<transmission name="t"><joint name="hip"/></transmission>'
    urdf = "".join([*map(body.format, ("cart", "hip", "leg")), *(joint.format(*each) for each in joints), drive])
    urdf = f'<robot name="hopper"><link name="frame"/>{urdf}</robot>'
    with pytest.warns(pp.PinpressWarning, match="no driver moves joints 'x', 'z': hip leaves 2 free"):
        press = pp.load(texts.file(urdf))
    assert (press.slide, press.motors, press.passive) == (None, ("hip",), ("x", "z"))
    motion = pp.servo_cycle(press, angle=[[0.3, 0.1, 0.2]], speed=[[2.0, 0.5, -0.4]], acceleration=[[4.0, 0.0, 0.0]])
    found = pp.inverse_dynamics(press, motion).motion
    data = press.model.createData()
    pin.centerOfMass(press.model, data, found.joint_position[0], found.v[0], found.a[0])
    lowest = press.model.inertias[1].mass  # the cart does not fall: it hangs on the guide x
    total = sum(inertia.mass for inertia in press.model.inertias)
    assert data.acom[0][0] == pytest.approx(0.0, abs=1e-12)
    assert data.acom[0][2] * total == pytest.approx(-9.81 * (total - lowest), rel=1e-12)
    with pytest.raises(pp.UrdfError, match="mobility is 3, but one joint drives"):
        texts.load(urdf, slide="cart")


def test_of_several_drivers_one_at_its_dead_point_is_left_out():
    """Coupler and rocker in line: the crank cannot move, they can. A single driver there is refused."""
    line = {'0.4 0 0.05"/><link2': '0.15 0 -0.15"/><link2', '"0.1 0 0.35"': '"-0.15 0 0.15"'}
    arm = BODY.format("arm", "0 0 0.1") + JOINT.format("swivel", "revolute", "frame", "arm", "1 0 0", "0 0 1")
    alone, both = four_bar("frame"), four_bar("frame", arm, ("crank", "swivel"))
    for drawn, inline in line.items():
        assert drawn in alone
        alone, both = alone.replace(drawn, inline), both.replace(drawn, inline)
    with pytest.raises(pp.SingularityError, match="joint 'crank' does not determine the drawn pose"):
        texts.load(alone)
    with pytest.warns(pp.PinpressWarning) as warned:
        press = texts.load(both)
    assert [("loaded without crank" in str(each.message), "leaves 1 free" in str(each.message)) for each in warned] == [
        (True, False),
        (False, True),
    ]
    assert (press.motors, len(press.passive), press.mobility) == (("swivel",), 1, 2)


# -------------------------------------------------------------------------------------------------------------------- poses that deceive


def test_a_wrist_at_right_angles_has_no_spins():
    """A spherical wrist on three motors across each other: in this pose alone a leg can turn about the axis of the next motor."""
    axes, text = np.eye(3), '<robot name="wrist"><link name="frame"/>'
    for k in range(3):
        text += BODY.format(f"ring{k}", "0.02 0.03 0.05") + JOINT.format(
            f"motor{k}", "revolute", "frame", f"ring{k}", "0 0 0", words(axes[k])
        )
        text += BODY.format(f"arm{k}", "0.05 0.02 0.03")
        text += JOINT.format(f"knee{k}", "revolute", f"ring{k}", f"arm{k}", "0 0 0", words(axes[(k + 1) % 3]))
    text += BODY.format("head", "0.01 0.02 0.06") + JOINT.format("tip", "revolute", "arm0", "head", "0 0 0", words(axes[2]))
    for k in (1, 2):  # the other arms turn on the head about the axis through the middle and this ball
        place = words(0.1 * axes[(k + 2) % 3])
        text += (
            f'<loop_joint name="L{k}" type="spherical"><link1 link="arm{k}" xyz="{place}"/><link2 link="head" xyz="{place}"/></loop_joint>'
        )
    press = texts.load(text + "".join(DRIVEN.format(f"motor{k}") for k in range(3)) + "</robot>")
    assert (press.mobility, press.freedoms) == (3, ())
    assert press.undriven(()).of("spin", "swing") == ()
    assert len(pp.propose_drivers(press).drivers) == 3


def test_a_wrist_of_an_arm_in_line_has_no_spin():
    """Its fourth joint turns between the third and the sixth, on the line of both; no loop holds the hand."""
    text, last = '<robot name="arm"><link name="frame"/>', "frame"
    for k, axis in enumerate(("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1")):
        text += BODY.format(f"link{k}", "0 0 0.1") + JOINT.format(
            f"r{k}", "revolute", last, f"link{k}", "0 0 0.2" if k < 3 else "0 0 0", axis
        )
        last = f"link{k}"
    text += "".join(DRIVEN.format(f"r{k}") for k in range(5))
    with pytest.warns(pp.PinpressWarning, match="no driver moves joint 'r5'"):
        press = texts.load(text + "</robot>")
    assert (press.held, press.passive) == ((), ("r5",))
    assert len(pp.propose_drivers(press).drivers) == 6
