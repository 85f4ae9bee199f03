"""Linkages with rods between ball joints, whose spin no driver determines: RSSR against its closed form, and beside universal joints."""

import numpy as np
import pinocchio as pin
import pytest
from support import texts

import pinpress as pp

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
@pytest.mark.parametrize("method", ["reduced", "constraint"])
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
    with pytest.warns(pp.PinpressWarning, match="about a line 12 mm from its centre of mass, .*: its weight would turn it"):
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
