"""A linkage written as a URDF and loaded again: the same numbers, and the same text wherever nothing has changed."""

import dataclasses
import difflib
import re
import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support import texts
from support.exploring import examples
from support.generators.random_linkages import drawn, linkages
from support.generators.spatial_linkages import bennett, four_bar

import pinpress as pp
from pinpress.balancing import Counterweight, with_counterweights
from pinpress.engines.constraints import gear

EPS = np.finfo(float).eps
LEVER = 3.0  # centre of mass [ulp of its largest component]: Pinocchio reads (m c) (1 / m), three roundings of up to an ulp each
TENSOR = EPS  # of its largest component
ROTATION = 6 * EPS  # Pinocchio reads roll, pitch and yaw, by way of a quaternion
WELDED = 2 * EPS  # masses, lengths and tensors that are sums over links


def text(numbers):
    return " ".join(repr(float(x)) for x in numbers)


def unit(*numbers):
    return np.array(numbers) / np.linalg.norm(numbers)


# A crank-slider through space, which can be changed in every number and still moves. Its loop is between links that are welded to rod and
# slide, turned against them; a gear runs with the crank, and a counterweight is welded to it.
PIN_P, PIN_W = np.array([0.02, -0.05, -0.1]), np.array([0.06, 0.08, -0.5])
ROD_END = pin.SE3(pin.rpy.rpyToMatrix(0.3, -1.2, 2.0), 0.9 * (PIN_W - PIN_P))
LUG = pin.SE3(pin.rpy.rpyToMatrix(-2.0, 0.4, 0.1), np.array([0.0, 0.1, 0.02]))
WEIGHT = pin.SE3(pin.rpy.rpyToMatrix(0.7, 0.8, -0.9), np.array([0.01, 0.02, 0.05]))
CRANK_AXIS = unit(0.2, -0.9, 0.3)


def place(placement):
    return f'xyz="{text(placement.translation)}" rpy="{text(pin.rpy.matrixToRpy(placement.rotation))}"'


PRESS = f"""<?xml version="1.0"?>
<!-- A press with <joint name="O"> & "quotes" in its comment. -->
<robot name='space_press' xmlns:drake="http://drake.mit.edu">
  <material name="steel"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="frame">
    <visual name="bed"><origin xyz="0 0 -1"/><geometry><box size="1 1 0.1"/></geometry><material name="steel"/></visual>
  </link>
  <link name="crank">
    <!-- measured -->
    <inertial>
      <origin xyz="0.01 0.02 -0.03" rpy="0 0 0.5"/>
      <mass
        value='6'/>
      <inertia ixx="0.05" ixy="0.01" ixz="0" iyy="0.06" iyz="-0.01" izz="0.04"/>
    </inertial>
    <visual><geometry><cylinder radius="0.1" length="0.02"/></geometry></visual>
  </link>
  <link name="weight">
    <inertial><origin xyz="0 0 0.01"/><mass value="2"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
  </link>
  <link name="cross"><inertial><mass value="0.5"/><inertia ixx="5e-4" ixy="0" ixz="0" iyy="6e-4" iyz="0" izz="4e-4"/></inertial></link>
  <link name="rod">
    <inertial>
      <origin xyz="0.02 0.06 -0.2"/><mass value="3"/><inertia ixx="0.05" ixy="0" ixz="0.004" iyy="0.05" iyz="0.006" izz="0.01"/>
    </inertial>
  </link>
  <link name="rod_end"/>
  <link name="slide"><inertial><mass value="20"/><inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.2"/></inertial></link>
  <link name="lug"></link>
  <link name="gear"><inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.1"/></inertial></link>

  <joint name="O" type="continuous">
    <parent link="frame"/><child link="crank"/>
    <axis xyz="{text(CRANK_AXIS)}"/>
  </joint>
  <joint name="screws" type="fixed"><parent link="crank"/><child link="weight"/><origin {place(WEIGHT)}/></joint>
  <joint name="P" type="continuous">
    <parent link="crank"/><child link="cross"/><origin rpy="0 0 0" xyz="{text(PIN_P)}"/><axis xyz="{text(CRANK_AXIS)}"/>
    <dynamics damping="0.5"/><drake:rotor_inertia value="1"/>
  </joint>
  <joint name="Q" type="revolute">
    <parent link="cross"/><child link="rod"/><axis xyz="{text(unit(-0.9, -0.2, 0.0))}"/>
    <limit lower="-1" upper="1" effort="100" velocity="30"/>
  </joint>
  <joint name="end" type="fixed"><parent link="rod"/><child link="rod_end"/><origin {place(ROD_END)}/></joint>
  <joint name="slide_guide" type="prismatic">
    <parent link="frame"/><child link="slide"/><origin xyz="{text(PIN_W)}"/><axis xyz="{text(unit(0.1, -0.2, 0.9))}"/>
    <limit lower="-1" upper="1" effort="1e6" velocity="3"/>
  </joint>
  <joint name="weld" type="fixed"><parent link="slide"/><child link="lug"/><origin {place(LUG)}/></joint>
  <joint name="G" type="continuous">
    <parent link="frame"/><child link="gear"/><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/>
    <mimic joint="O" multiplier="-2"/>
  </joint>
  <loop_joint name="W" type="spherical">
    <link1 link="rod_end" xyz="{text(ROD_END.actInv(PIN_W - PIN_P))}"/><link2 link="lug" xyz="{text(LUG.actInv(np.zeros(3)))}" rpy="0 0 1"/>
  </loop_joint>
  <transmission name="drive"><type>simple</type><joint name="O"><hardwareInterface/></joint><actuator name="motor"/></transmission>
  <gazebo reference="crank"><mu1>0,2</mu1></gazebo>
</robot>
<!-- end -->
"""


@pytest.fixture
def file(tmp_path):
    return tmp_path / "read.urdf"


@pytest.fixture
def press(file):
    return loaded(file, PRESS)


def loaded(file, content, **options):
    file.write_bytes(content.encode())
    return pp.load(file, **options)


def written(press, folder, **options):
    """The linkage of the file that it is written to."""
    return pp.load(pp.write_urdf(press, folder / "written.urdf"), **options)


def changed(press, change, **fields):
    """A linkage with a model that ``change`` was done to."""
    model = press.model.copy()
    change(model)
    return dataclasses.replace(press, model=model, **fields)


def lines_changed(press, other):
    """Lines of the text of a linkage that another's does not have, and what that has instead."""
    lines = difflib.ndiff(press.text.decode().splitlines(), other.text.decode().splitlines())
    picked = [line for line in lines if line[0] in "-+"]
    return [line[2:].strip() for line in picked if line[0] == "-"], [line[2:].strip() for line in picked if line[0] == "+"]


def assert_same(one, other, welded=True):
    """Every number that a URDF says, to what was promised; ``welded`` where the bodies are sums of links."""
    model, expected = one.model, other.model
    length = max(np.abs(inertia.lever).max() for inertia in expected.inertias) + other.size
    assert list(model.names) == list(expected.names)
    for inertia, wanted in zip(model.inertias, expected.inertias, strict=True):
        np.testing.assert_allclose(inertia.mass, wanted.mass, rtol=WELDED if welded else 0, atol=0)
        ulp = np.spacing(np.abs(wanted.lever).max())
        np.testing.assert_allclose(inertia.lever, wanted.lever, rtol=0, atol=WELDED * length if welded else LEVER * ulp)
        largest = np.abs(wanted.inertia).max()
        np.testing.assert_allclose(inertia.inertia, wanted.inertia, rtol=0, atol=(WELDED if welded else TENSOR) * largest)
    places = zip(
        [*model.jointPlacements, *(frame(one, link) for link in one.links)],
        [*expected.jointPlacements, *(frame(other, link) for link in other.links)],
        strict=True,
    )
    for placement, wanted in places:
        np.testing.assert_allclose(placement.translation, wanted.translation, rtol=0, atol=WELDED * length if welded else 0)
        np.testing.assert_allclose(placement.rotation, wanted.rotation, rtol=0, atol=ROTATION)
    for loop, wanted in zip(one.loops, other.loops, strict=True):
        assert (loop.name, loop.type, loop.joint1, loop.joint2) == (wanted.name, wanted.type, wanted.joint1, wanted.joint2)
        for end in ("1", "2"):
            point, rotation = getattr(loop, f"point{end}"), getattr(loop, f"rotation{end}")
            np.testing.assert_allclose(point, getattr(wanted, f"point{end}"), rtol=0, atol=WELDED * length if welded else 0)
            np.testing.assert_allclose(rotation, getattr(wanted, f"rotation{end}"), rtol=0, atol=ROTATION)
    for name in ("lowerPositionLimit", "upperPositionLimit", "velocityLimit", "upperEffortLimit", "damping", "upperDryFrictionLimit"):
        np.testing.assert_array_equal(getattr(model, name), getattr(expected, name))
    pairs = [[(p.name, p.follower, p.leader, p.multiplier, p.offset) for p in each.couplings] for each in (one, other)]
    assert pairs[0] == pairs[1]
    assert (one.name, one.links, one.root, one.drivers, one.slide) == (other.name, other.links, other.root, other.drivers, other.slide)


def number(press, joint):
    """Of a joint in Pinocchio's model."""
    return press.joints.index(joint) + 1


def frame(press, link):
    return press.model.frames[press.model.getFrameId(link, pin.BODY)].placement


def some_inertia(rng, scale=1.0):
    """Of a body: any three second moments of mass along principal axes will do."""
    mass, spread = 10 ** rng.uniform(-1, 3), 10 ** rng.uniform(-3, 0, 3)
    turned = pin.exp3(rng.normal(size=3))
    return pin.Inertia(mass, scale * rng.normal(size=3), scale**2 * mass * (turned @ np.diag(spread.sum() - spread) @ turned.T))


def nudge(rng, size):
    return pin.SE3(pin.exp3(size * rng.normal(size=3)), size * rng.normal(size=3))


# ------------------------------------------------------------------------------------------------------------------------------ the text


@pytest.mark.parametrize("name", pp.presses())
def test_unchanged_press_has_the_same_bytes(name, tmp_path):
    press = texts.shipped(name)
    assert pp.write_urdf(press, tmp_path / "written.urdf") == tmp_path / "written.urdf"
    assert (tmp_path / "written.urdf").read_bytes() == press.text


@pytest.mark.parametrize(
    "content",
    [
        "\ufeff" + PRESS,
        PRESS.replace("\n", "\r\n"),
        PRESS.replace('"crank"', '"&lt;cr&amp;ank&gt; &quot;曲柄&quot;"').replace('"O"', '"it\'s"'),
        PRESS.replace('"crank"', '"cra\nnk"'),
        PRESS.replace("<transmission", "<transmission name='idle'><joint name='O'/></transmission><transmission"),
        PRESS.replace('<inertial><mass value="20"/>', '<inertial\t ><mass\n value = "20" />'),
    ],
    ids=["byte_order_mark", "crlf", "escaped", "line_break_in_name", "driver_twice", "white_space"],
)
def test_text_stays_but_for_the_one_number(file, tmp_path, content):
    press = loaded(file, content)
    assert written(press, tmp_path).text == press.text
    heavier = body_changed(press, "slide_guide", lambda body: pin.Inertia(21.5, body.lever, body.inertia))
    assert written(heavier, tmp_path).text == re.sub(rb'value( ?= ?)"20"', rb'value\1"21.5"', press.text)


@pytest.mark.filterwarnings("ignore:.*the centre of mass is", "ignore:.*the slide weighs")  # anywhere, anything
def test_visuals_comments_and_foreign_elements_are_kept(press, tmp_path):
    rng = np.random.default_rng(1)

    def all_new(model):
        for j in range(1, model.njoints):
            model.inertias[j] = some_inertia(rng)
            model.jointPlacements[j] = model.jointPlacements[j] * nudge(rng, 1e-3)

    gone, come = lines_changed(press, written(changed(press, all_new), tmp_path))
    kept = ("visual", "geometry", "gazebo", "drake", "<!--", "material", "transmission")
    assert gone
    come = [re.sub(r'<visual name="added_ballast">.*?</visual>', "", line) for line in come]  # of links that have become heavier
    assert not [line for line in gone + come if any(word in line for word in kept)]


def test_counterweights_are_balls_of_steel(press, tmp_path):
    """Written, written again unchanged, with another one, and without; a link that is only heavier has none."""

    def balls(loaded):
        ball = r'<visual name="added_ballast"><origin xyz="(.*?)"/><geometry><sphere radius="(.*?)"/></geometry></visual>'
        return re.findall(ball, loaded.text.decode())

    weight = Counterweight("crank", 40.0, (-0.3, 0.0, 0.1))
    balanced = with_counterweights(press, [weight])
    first = written(balanced, tmp_path)
    ((place, radius),) = balls(first)
    np.testing.assert_allclose(np.array(place.split(), dtype=float), weight.position, rtol=0, atol=1e-9)
    assert 4 / 3 * np.pi * float(radius) ** 3 * 7850 == pytest.approx(40.0, rel=1e-9)
    assert written(first, tmp_path).text == first.text
    both = written(with_counterweights(first, [Counterweight("crank", 10.0, (0.1, 0.0, 0.0))]), tmp_path)
    ((place, radius),) = balls(both)
    np.testing.assert_allclose(np.array(place.split(), dtype=float), [-0.22, 0.0, 0.08], rtol=0, atol=1e-9)
    assert not balls(written(both.with_inertias(press.model.inertias), tmp_path))
    heavier = [pin.Inertia(2 * each.mass, each.lever, 2 * each.inertia) for each in press.model.inertias]
    assert not balls(written(press.with_inertias(heavier), tmp_path))


def test_name_is_escaped(press, tmp_path):
    name = '"Nürnberg" <1> & it\'s'
    assert written(dataclasses.replace(press, name=name), tmp_path).name == name


# --------------------------------------------------------------------------------------------------------------------------- the numbers


@pytest.mark.filterwarnings("ignore:.*the centre of mass is", "ignore:.*the slide weighs")  # anywhere, anything
@pytest.mark.parametrize("name", pp.presses())
def test_inertias(name, tmp_path):
    press, rng = texts.shipped(name), np.random.default_rng(2)

    def all_new(model):
        for j in range(model.njoints):
            model.inertias[j] = some_inertia(rng)

    heavier = changed(press, all_new)
    again = written(heavier, tmp_path)
    assert_same(again, heavier, welded=False)


def thin_rod(press, model):
    """A singular tensor, turned: Pinocchio's constructor would find it negative."""
    turned = pin.exp3(np.array([0.3, 0.2, 0.9]))
    tensor = turned @ np.diag([0.1, 0.1, 0.0]) @ turned.T
    assert np.linalg.eigvalsh(tensor)[0] != 0
    model.inertias[number(press, "Q")].inertia = tensor


def all_placements(press, model):
    rng = np.random.default_rng(3)
    for j in range(1, model.njoints):
        model.jointPlacements[j] = nudge(rng, 1e-2) * model.jointPlacements[j]


def turned_by(pitch):
    """A placement in which roll and yaw are one, nearly or exactly."""

    def turned(press, model):
        model.jointPlacements[number(press, "G")].rotation = pin.rpy.rpyToMatrix(0.4, pitch, -2.0)

    return turned


def welded_links(press, model):
    """Neither the body's inertia nor the loop's point on it goes with the frame of a welded link."""
    for link in ("weight", "rod_end", "lug"):
        model.frames[model.getFrameId(link, pin.BODY)].placement = nudge(np.random.default_rng(4), 0.1) * frame(press, link)


def limits(press, model):
    model.lowerPositionLimit[press.model.joints[number(press, "Q")].idx_q] = -0.25
    for j, name in enumerate(press.joints):
        model.velocityLimit[j], model.upperEffortLimit[j], model.damping[j] = 2.5 + j, 1e3 + j, 0.1 * j
        model.upperDryFrictionLimit[j] = 0.25 if name == "slide_guide" else 0.0


PITCHES = (np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-9, np.pi / 2 - 1e-4, np.pi)


@pytest.mark.filterwarnings("ignore:.*apart as drawn:pinpress.PinpressWarning")
@pytest.mark.parametrize(
    "change", [thin_rod, all_placements, welded_links, limits, *map(turned_by, PITCHES)], ids=lambda each: each.__name__
)
def test_a_changed_model_is_written(press, tmp_path, change):
    other = changed(press, lambda model: change(press, model))
    assert_same(written(other, tmp_path), other)


def test_one_moment_of_a_link_whose_inertia_is_written_in_turned_axes(file, tmp_path):
    press = loaded(file, PRESS.replace('<origin xyz="0.02 0.06 -0.2"/>', '<origin xyz="0.02 0.06 -0.2" rpy="1 0.2 -0.5"/>'))
    other = body_changed(press, "Q", lambda body: pin.Inertia(body.mass, body.lever, body.inertia * [[1, 1, 1], [1, 1, 1], [1, 1, 1.01]]))
    assert_same(written(other, tmp_path), other)


def test_attribute_that_was_not_there(file, tmp_path):
    press = loaded(file, PRESS.replace('<origin xyz="0.5 0 0"/>', '<origin xyz="0.5 0 0" />'))

    def turned(model):
        model.jointPlacements[number(press, "G")].rotation = pin.rpy.rpyToMatrix(0.0, 0.0, 0.25)

    assert b'<origin xyz="0.5 0 0" rpy="0.0 0.0 0.25" />' in written(changed(press, turned), tmp_path).text


def test_loop_on_welded_links(press, tmp_path):
    loop = press.loops[0]
    ends = {"point1": loop.point1 - 2e-3, "point2": loop.point2 + 1e-3, "rotation2": pin.exp3(np.array([1.0, -2.0, 0.5]))}
    other = dataclasses.replace(press, loops=(dataclasses.replace(loop, **ends),))
    again = written(other, tmp_path)
    assert_same(again, other)
    assert not np.allclose(again.loops[0].point1, loop.point1, rtol=0, atol=1e-4)
    assert len(lines_changed(press, again)[0]) == 1


@pytest.mark.one_in(3)
@pytest.mark.parametrize("content", [bennett(), four_bar("revolute"), four_bar("fixed")], ids=["bennett", "revolute", "fixed"])
def test_loop_that_holds_rotations(file, tmp_path, content):
    """Turned about its axis, which it may be, or both ends alike; the <axis> is not touched."""
    press = loaded(file, content)
    loop = press.loops[0]
    turn = pin.exp3(np.array([0.7, 0.0, 0.0]))
    both = {"rotation1": loop.rotation1 @ turn, "rotation2": loop.rotation2 @ turn}
    for ends in ({"rotation1": both["rotation1"]}, both) if loop.type == "revolute" else (both,):
        other = dataclasses.replace(press, loops=(dataclasses.replace(loop, **ends),))
        again = written(other, tmp_path)
        assert_same(again, other, welded=False)
        assert re.findall(b"<axis.*?>", again.text) == re.findall(b"<axis.*?>", press.text)
        assert again.text != press.text


@pytest.mark.parametrize(("old", "new", "drivers"), [("spherical", "revolute", ["O"]), ("fixed", "revolute", ["O", "D"])])
def test_type_of_a_loop(file, tmp_path, old, new, drivers):
    """A four-bar, and one whose coupler is welded of halves; these then turn, and a second driver moves them. There and back."""
    press = loaded(file, four_bar(old))
    data, upright = press.model.createData(), np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # first axis: -y
    pin.forwardKinematics(press.model, data, pin.neutral(press.model))
    loop = press.loops[0]
    ends = {f"rotation{k}": data.oMi[joint].rotation.T @ upright for k, joint in ((1, loop.joint1), (2, loop.joint2))}
    other = dataclasses.replace(press, loops=(dataclasses.replace(loop, type=new, **ends),), drivers=tuple(drivers))
    turning = written(other, tmp_path)
    assert_same(turning, other, welded=old == "spherical")
    held = dataclasses.replace(turning, loops=(dataclasses.replace(turning.loops[0], type=old),), drivers=press.drivers)
    assert_same(written(held, tmp_path), held, welded=old == "spherical")


def test_loop_that_turns_about_an_axis_no_more(file, tmp_path):
    """Its <axis> is gone; its ends stay as they are."""
    press = loaded(file, four_bar("revolute"))
    other = dataclasses.replace(press, loops=(dataclasses.replace(press.loops[0], type="spherical"),))
    again = written(other, tmp_path)
    assert_same(again, other)
    assert again.text.count(b"<axis") == press.text.count(b"<axis") - 1


@pytest.mark.parametrize("change", [{"multiplier": 1 / 3}, {"offset": -0.1}, {"leader": 1, "multiplier": 0.7}])
def test_gear_pair(press, tmp_path, change):
    pair = dataclasses.replace(press.couplings[0], **change)
    other = dataclasses.replace(press, relations=(gear(pair.name, pair.follower, pair.leader, pair.multiplier, pair.offset),))
    again = written(other, tmp_path)
    assert_same(again, other)
    assert len(lines_changed(press, again)[0]) == 1


@pytest.mark.parametrize(
    ("name", "new"),
    [("G", pin.JointModelRUBX()), ("Q", pin.JointModelRevoluteUnaligned(unit(-0.8, -0.3, 0.1))), ("slide_guide", pin.JointModelPZ())],
)
def test_axis(press, tmp_path, name, new):
    j = number(press, name)

    def tilted(model):
        new.setIndexes(j, model.joints[j].idx_q, model.joints[j].idx_v)
        model.joints[j] = pin.JointModel(new)

    other = changed(press, tilted)
    again = written(other, tmp_path)
    assert_same(again, other)
    assert again.model.joints[j].shortname() == new.shortname()
    np.testing.assert_allclose(again.axes[j - 1].direction, other.axes[j - 1].direction, rtol=0, atol=EPS)
    assert len(lines_changed(press, again)[0]) == 1


# --------------------------------------------------------------------------------------------------------------------------- drivers

TWO = four_bar("spherical", table="table")  # T carries the frame of the crank O
DRIVES = '<transmission name="drive_T"><joint name="T"/></transmission>\n  <transmission name="drive_O"><joint name="O"/></transmission>'


@pytest.mark.parametrize(
    "transmissions",
    [
        DRIVES,
        "",
        '<transmission name="both"><joint name="T"/><joint name="O"/></transmission>',
        '<transmission name="a"><joint name="T"/><joint name="O"/></transmission><transmission name="b"><joint name="D"/></transmission>',
        '<transmission name="a"><joint name="B"/></transmission>\n  <transmission name="b"><joint name="D"/><actuator/></transmission>\n  '
        '<transmission name="c"><joint name="T"/></transmission>',
    ],
    ids=["one_each", "none", "one_for_both", "three", "others"],
)
@pytest.mark.parametrize("drivers", [("T", "O"), ("O", "T"), ("D", "T")])
def test_drivers_named_at_load(file, tmp_path, transmissions, drivers):
    assert DRIVES in TWO
    press = loaded(file, TWO.replace(DRIVES, transmissions), driver=drivers)
    again = written(press, tmp_path)
    assert again.drivers == drivers
    assert len(re.findall(rb'<joint name="\w"/>', again.text)) == 2
    assert (again.text == press.text) == (press.document.description.drivers == drivers)
    assert not re.findall(rb"<transmission[^>]*>\s*</transmission>", again.text)
    assert len(re.findall(rb"\n *\n", again.text)) == len(re.findall(rb"\n *\n", press.text))


def test_driver_with_a_name_to_be_escaped(file, tmp_path):
    press = loaded(file, PRESS.replace('name="P"', "name='&quot;P&quot; &lt;&amp;&apos;'"), driver='"P" <&\'')
    again = written(press, tmp_path)
    assert again.drivers == ('"P" <&\'',)
    assert again.text.count(b"<hardwareInterface/>") == 1


# ------------------------------------------------------------------------------------------------------------- bodies of several links


def body_changed(press, joint, change):
    """A linkage in which ``change`` was done to the inertia of the body that a joint carries."""
    j = number(press, joint)
    return changed(press, lambda model: model.inertias.__setitem__(j, change(model.inertias[j])))


def ball(mass, radius=0.05, at=(0.0, 0.0, 0.0)):
    return pin.Inertia(mass, np.array(at), 0.4 * mass * radius**2 * np.eye(3))


def link_inertia(press, link):
    """What the text of a linkage says of a link, alone on a joint."""
    inertial = re.search(rf'<link name="{link}">.*?(<inertial>.*?</inertial>)', press.text.decode(), re.S)
    alone = f'<robot name="a"><link name="f"/><link name="b">{inertial[1]}</link>'
    joint = '<joint name="j" type="continuous"><parent link="f"/><child link="b"/></joint></robot>'
    return pin.buildModelFromXML(alone + joint).inertias[1]


def links_without_inertia(press):
    links = re.findall(r'<link name="(\w+)"(?:/>|>(.*?)</link>)', press.text.decode(), re.S)
    return [link for link, content in links if "<inertial>" not in content]


@pytest.mark.parametrize("change", [lambda total: total + ball(3.0, at=(0.1, 0.0, 0.0)), lambda total: total - ball(0.5)])
def test_the_heaviest_of_welded_links_takes_the_difference(press, tmp_path, change):
    """The crank has 6 kg, the counterweight on it 2."""
    other = body_changed(press, "O", change)
    again = written(other, tmp_path)
    assert_same(again, other)
    assert link_inertia(again, "weight") == link_inertia(press, "weight")
    assert link_inertia(again, "crank").mass == other.model.inertias[number(press, "O")].mass - 2


def test_one_link_takes_all_where_none_can_take_the_difference(press, tmp_path):
    """Less mass is left than either has."""
    other = body_changed(press, "O", lambda total: ball(1.5))
    again = written(other, tmp_path)
    assert_same(again, other)
    assert "weight" in links_without_inertia(again)
    assert link_inertia(again, "crank").mass == 1.5


def test_the_next_takes_it_where_the_heaviest_would_be_unsound(file, tmp_path):
    """The crank a flat plate, from which nothing can be taken across its plane; the counterweight a ball, from which it can."""
    plate = PRESS.replace(
        'ixx="0.05" ixy="0.01" ixz="0" iyy="0.06" iyz="-0.01" izz="0.04"', 'ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="2"'
    )
    press = loaded(file, plate.replace('rpy="0 0 0.5"', ""))
    heavier, crank = written(body_changed(press, "O", lambda total: total + ball(1.0)), tmp_path), link_inertia(press, "crank")
    assert link_inertia(heavier, "crank") != crank
    less = 1e-3 * np.diag([1.0, 1.0, 0.0])
    other = body_changed(press, "O", lambda body: pin.Inertia(body.mass, body.lever, body.inertia - less))
    again = written(other, tmp_path)
    assert_same(again, other)
    assert link_inertia(again, "crank") == crank
    assert link_inertia(again, "weight") != link_inertia(press, "weight")


def test_inertia_of_welded_links_stays_split(press, tmp_path):
    """Where other bodies change."""
    again = written(body_changed(press, "Q", lambda total: total + ball(1.0)), tmp_path)
    assert len(lines_changed(press, again)[0]) == 1
    assert again.model.inertias[number(press, "O")] == press.model.inertias[number(press, "O")]


@pytest.mark.parametrize("tag", ['<link name="frame"/>', '<link name="frame"></link>', '<link name="frame"><!-- heavy --></link>', None])
def test_frame_gets_a_mass(file, tmp_path, tag):
    """Which it did not have; it carries the shaking force, not the crank."""
    content = PRESS if tag is None else re.sub(r'<link name="frame">.*?</link>', tag, PRESS, flags=re.S)
    press = loaded(file, content)
    other = changed(press, lambda model: model.inertias.__setitem__(0, ball(500.0, at=(0.1, 0.2, 0.3))))
    again = written(other, tmp_path)
    assert_same(again, other)
    back = dataclasses.replace(again, model=press.model)
    assert written(back, tmp_path).model.inertias[0].mass == 0


# ------------------------------------------------------------------------------------------------------------------------ other linkages


@pytest.mark.filterwarnings("ignore:.*apart as drawn:pinpress.PinpressWarning")
def test_planar_press_stays_planar(tmp_path):
    """Its angles and lengths in the plane changed: the planar engine takes it."""
    press, rng = texts.shipped("zxn2_3000b"), np.random.default_rng(6)

    def change(model):
        for j in range(1, model.njoints):
            move = pin.SE3(pin.exp3(np.array([0.0, 5e-3, 0.0]) * rng.normal()), 5e-3 * rng.normal(size=3) * [1, 0, 1])
            model.jointPlacements[j] = move * model.jointPlacements[j]

    other = changed(press, change)
    again = written(other, tmp_path)
    assert "plane" in again.engines
    assert_same(again, other, welded=False)


def test_forces_of_the_file_are_those_of_the_changed_linkage(tmp_path):
    """Whatever a linkage has worked out is worked out anew for the changed one; a redundant press, whose lengths must fit to all digits.
    Gravity is not in the file."""
    press, rng = texts.shipped("jf75g_125_symmetric"), np.random.default_rng(7)
    before = pp.inverse_dynamics(press, pp.cycle(press, speed=7.0, points=8)).driving_torque

    def change(model):
        model.gravity.linear = np.array([0.1, -0.2, -9.0])
        for inertia in model.inertias:
            inertia.mass *= rng.uniform(0.5, 2)
            inertia.lever = inertia.lever + np.array([0.02, 0.0, -0.01])

    other = changed(press, change)
    both = (written(other, tmp_path, gravity=(0.1, -0.2, -9.0)), other)
    one, two = (pp.inverse_dynamics(each, pp.cycle(each, speed=7.0, points=8)) for each in both)
    largest = max(np.abs(force).max() for force in two.bearing_force.values())
    np.testing.assert_allclose(one.driving_torque, two.driving_torque, rtol=0, atol=1e-12 * largest)
    for name in press.bearings:
        np.testing.assert_allclose(one.bearing_force[name], two.bearing_force[name], rtol=0, atol=1e-12 * largest)
    assert np.abs(two.driving_torque - before).max() > 1e-2 * np.abs(before).max()


@pytest.mark.exhaustive
@examples(12)
@given(linkages(most=3), st.integers(0, 2**32 - 1))
def test_random_linkage(tmp_path, spec, seed):
    """Unchanged the same bytes; changed, in its plane, the same numbers; written once more, the same bytes again."""
    drawing, rng = drawn(spec), np.random.default_rng(seed)
    assume(drawing)
    press = loaded(tmp_path / "read.urdf", drawing.urdf("crank"))
    assert written(press, tmp_path).text == press.text
    size = press.size

    def change(model):
        for j in range(model.njoints):
            model.inertias[j] = some_inertia(rng, size)
            turn = 1e-3 * rng.normal() * press.axes[j - 1].direction if j and press.axes[j - 1].turns else np.zeros(3)
            model.jointPlacements[j] = model.jointPlacements[j] * pin.SE3(pin.exp3(turn), np.zeros(3))

    along = press.engine("plane").plane.axes.T @ (1e-3 * size * rng.normal(size=2))  # in the world
    data = press.model.createData()
    pin.forwardKinematics(press.model, data, pin.neutral(press.model))
    loops = [dataclasses.replace(loop, point1=loop.point1 + data.oMi[loop.joint1].rotation.T @ along) for loop in press.loops]
    other = changed(press, change, loops=tuple(loops))
    again = written(other, tmp_path)
    assert_same(again, other)
    assert written(again, tmp_path).text == again.text


# ----------------------------------------------------------------------------------------------------------------------------- refusals


def with_model(change):
    return lambda press: {"model": changed(press, lambda model: change(press, model)).model}


def guided(press, model):
    joint, j = pin.JointModelPX(), number(press, "Q")
    joint.setIndexes(j, model.joints[j].idx_q, model.joints[j].idx_v)
    model.joints[j] = pin.JointModel(joint)


def of_wheel(attribute, value):
    return with_model(lambda press, model: getattr(model, attribute).__setitem__(press.model.joints[number(press, "G")].idx_v, value))


def stretched(factor):
    return with_model(lambda press, model: setattr(model.jointPlacements[number(press, "G")], "rotation", factor * np.eye(3)))


def with_loop(**fields):
    return lambda press: {"loops": (dataclasses.replace(press.loops[0], **fields),)}


REFUSALS = [  # fields that are changed, the error and its message
    (lambda press: {"model": pin.buildReducedModel(press.model, [number(press, "G")], pin.neutral(press.model))}, "other joints"),
    (lambda press: {"model": texts.shipped("crank_slide").model}, "other joints"),
    (lambda press: {"loops": ()}, "other loops"),
    (with_loop(joint2=0), "other loops"),
    (with_loop(name="V"), "other loops"),
    (lambda press: {"relations": ()}, "other gear pairs"),
    (lambda press: {"links": press.links[:-1]}, "other links"),
    (with_model(guided), "other joint types"),
    (of_wheel("rotorInertia", 0.5), "cannot hold the changed rotorInertia"),
    (of_wheel("rotorInertia", 0.5), "changed rotorInertia"),
    (of_wheel("lowerPositionLimit", -7.0), "has no effort"),  # of a joint that turns without end
    (stretched(1.001), "cannot hold the changed directions of joints"),
    (stretched(1 + 1e-9), "cannot hold the changed directions of joints"),
    (with_loop(type="fixed"), r"written.urdf \(not written\): .* do not close"),
    (lambda press: {"drivers": ("slide_gide",)}, "did you mean"),
    *((lambda press, name=name: {"name": name}, "name|well-formed XML") for name in ("", "\ud800", "nul\0", "bell\a")),
]


@pytest.mark.parametrize(("fields", "message"), REFUSALS)
def test_what_no_urdf_of_this_structure_can_hold_is_refused(press, tmp_path, fields, message):
    """What was in the file before is in it still, and nothing lies beside it."""
    target = tmp_path / "kept" / "written.urdf"
    target.parent.mkdir()
    target.write_text("as it was")
    with pytest.raises(pp.PinpressError, match=message):
        pp.write_urdf(dataclasses.replace(press, **fields(press)), target)
    assert target.read_text() == "as it was"
    assert list(target.parent.iterdir()) == [target]


@pytest.mark.parametrize("name", ["missing/written.urdf", ".", "nul\0.urdf"])
def test_path_that_cannot_be_written(press, tmp_path, name):
    with pytest.raises(pp.PinpressError, match="cannot write") as caught:
        pp.write_urdf(press, f"{tmp_path}/{name}")
    assert "give a file in a directory you can write to" in str(caught.value)
    assert [each.name for each in tmp_path.iterdir()] == ["read.urdf"]


def test_link_to_a_file_stays_one(press, tmp_path):
    target, link = tmp_path / "target.urdf", tmp_path / "link.urdf"
    link.symlink_to(target)
    assert pp.write_urdf(press, link) == link
    assert link.is_symlink()
    assert target.read_bytes() == press.text


def test_written_over_the_file_that_was_read(press, file):
    """It is replaced and not written into: who has it open reads on in the old one."""
    heavier = body_changed(press, "Q", lambda total: total + ball(1.0))
    with open(file, "rb") as reader:
        assert_same(pp.load(pp.write_urdf(heavier, file)), heavier)
        assert reader.read() == press.text


@pytest.mark.exhaustive
def test_import_of_pinpress_leaves_it_out():
    writing = "'pinpress.linkage.writing' in sys.modules"
    code = f"import sys, pinpress; assert not {writing}; pinpress.write_urdf; assert {writing}"
    subprocess.run([sys.executable, "-c", code], check=True)
