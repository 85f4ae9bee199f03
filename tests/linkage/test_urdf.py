"""The URDF reader: what it reads, and what it lets pass. What it refuses is in `malformed_urdf`."""

import re
from pathlib import Path

import pinocchio
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from support.exploring import examples
from support.generators.malformed_urdf import (
    CRANK_INERTIA,
    CRANK_INERTIAL,
    DRIVE,
    GUIDE,
    INERTIAL,
    LINE_O,
    LINE_P,
    LINE_W,
    VALID,
    XACRO,
    added,
    edited,
    in_joint,
    welded,
)

import pinpress as pp
from pinpress.common.errors import UrdfError
from pinpress.linkage import description as urdf
from pinpress.linkage.checks.elements import errors
from pinpress.linkage.document import Document, check_command, refuse_errors
from pinpress.linkage.loading import parse

SHIPPED = Path(__file__).parents[2] / "urdf"


@pytest.fixture
def file(tmp_path):
    return tmp_path / "press.urdf"


def read(file: Path) -> Document:
    """A URDF without errors; raises UrdfError for the first error in it."""
    document = parse(file)
    refuse_errors(errors(document), check_command(document.file))
    return document


def first_problem(file: Path, text: str | bytes) -> UrdfError:
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(UrdfError) as caught:
        read(file)
    assert caught.value.file == str(file)
    assert caught.value.remedy
    return caught.value


def listed(file: Path) -> list[str]:
    """All errors of a file, as `check` finds them."""
    return [str(finding.error) for finding in pp.check(file).errors]


def urdf_errors(file: Path) -> list[pp.PinpressError]:
    """Errors of a file's elements, before they are put together."""
    try:
        return [finding.error for finding in errors(parse(file))]
    except UrdfError as error:
        return [error]


def test_valid_file(file):
    file.write_text(VALID)
    assert (read(file).file, read(file).text) == (str(file), VALID.encode())
    assert read(file).description == urdf.Description(
        name="press",
        links=("frame", "crank", "rod", "slide"),
        joints=(
            urdf.Joint("O", "continuous", "frame", "crank", (0, 0, 0), None, None, LINE_O),
            urdf.Joint("P", "revolute", "crank", "rod", (0.1, 0, 0), (-4, 4), None, LINE_P),
            urdf.Joint("guide", "prismatic", "frame", "slide", (0, 0, -0.5), (-0.1, 0.3), None, GUIDE),
        ),
        loops=(
            urdf.Loop(
                "W",
                "spherical",
                urdf.LoopEnd("rod", (0.4, 0, 0), (0, 0, 0)),
                urdf.LoopEnd("slide", (0, 0, 0), (0, 0.5, 0)),
                (1, 0, 0),
                LINE_W,
            ),
        ),
        drivers=("O",),
    )
    assert (read(file).description.root, read(file).description.bodies) == (
        "frame",
        {link: link for link in ("frame", "crank", "rod", "slide")},
    )


@pytest.mark.parametrize(
    ("written", "ratio"),
    [
        ('<mimic joint="O"/>', (1.0, 0.0)),
        ('<mimic joint="O" multiplier="-2.5"/>', (-2.5, 0.0)),
        ('<mimic joint="O" multiplier="1" offset="-1e-3"/>', (1.0, -0.001)),
    ],
)
def test_mimic(file, written, ratio):
    file.write_text(in_joint("P", written))
    assert read(file).description.joints[1].mimic == urdf.Mimic("O", ratio[0], ratio[1], 20)
    assert [joint.mimic for joint in read(file).description.joints[::2]] == [None, None]


@pytest.mark.parametrize(
    ("kind", "written", "axis"),
    [("revolute", "", (1, 0, 0)), ("revolute", '<axis xyz="0 -0.6 0.8"/>', (0, -0.6, 0.8)), ("fixed", "", (1, 0, 0))],
)
def test_loop_types(file, kind, written, axis):
    file.write_text(edited(('"spherical"', f'"{kind}"'), ("</loop_joint>", written + "</loop_joint>")))
    (loop,) = read(file).description.loops
    assert (loop.type, loop.axis) == (kind, axis)


def test_axis_remedy_is_accepted(file):
    error = first_problem(file, edited(('xyz="0 -1 0"', 'xyz="3e300 -4e300 0"')))
    assert 'xyz="0.6' in error.remedy
    file.write_text(edited(('xyz="0 -1 0"', error.remedy.removeprefix("write "))))
    assert read(file).description.name == "press"


@pytest.mark.parametrize(
    "text",
    [
        "\ufeff" + VALID,
        VALID.replace("\n", "\r\n"),
        edited(("<link ", "<!-- <link name='x' --><link ")),
        edited(('<robot name="press">', XACRO)),
        edited(('<robot name="press">', '<robot name="press" xmlns="http://www.ros.org" version="1.1">')),
        edited(('<robot name="press">', '<robot name="press" xmlns:drake="http://drake.mit.edu"><drake:x/>')),
        added('<drake:declare_convex/><gazebo reference="crank"><mu1>0,2</mu1></gazebo><ros2_control/><mujoco/><sensor/><fixed_frame/>'),
        in_joint("P", '<drake:damping value="1"/><dynamics damping="0.1" spring_stiffness="0"/>'),
        edited(('effort="1e6"', 'effort="1e6" acceleration="5" drake:acceleration="5"')),
        edited((CRANK_INERTIAL, CRANK_INERTIAL + "<contact/><verbose/><self_collision_checking/><sensor/>")),
        edited((CRANK_INERTIAL, f'{CRANK_INERTIAL}<collision><geometry><mesh filename="package://a/b.stl"/></geometry></collision>')),
        edited(('<transmission name="drive">', '<transmission name="drive" type="pr2"><leftActuator name="l"/><joint name="O"/>')),
        edited((VALID.splitlines()[DRIVE - 1], "")),
        edited(('<material name="steel"/>', '<material name=""><color rgba="1 0 0 1"/></material>')),
        edited(('xyz="0.1 0 0"', 'xyz="  +.1   0 0e-5 " rpy="0 0 0"')),
        edited(('<axis xyz="0 -1 0"/>', "")),
        edited((CRANK_INERTIA, 'ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"')),
        edited(('iyy="2"', 'iyy="2.000001"')),
        edited(('<origin xyz="0.03 0 0"/>', '<origin xyz="0.03 0 0" rpy="0.1 0.2 0.3"/>')),
        welded("cap", "rod", ""),
        welded("cap", "rod", INERTIAL),
        welded("base", "frame", INERTIAL.replace('"1"', '"0"')),
        edited((CRANK_INERTIAL, ""), ("</robot>", '<link name="web">' + INERTIAL + "</link></robot>")).replace(
            "</robot>", '<joint name="weld" type="fixed"><parent link="crank"/><child link="web"/></joint></robot>'
        ),
        VALID.replace('"crank"', '"&lt;script&gt; &quot;曲柄&quot;"').replace('"O"', '"&lt;b&gt;"'),
        VALID.replace('"crank"', '"cra\nnk"'),
    ],
)
def test_passes_and_pinocchio_reads_it_without_a_word(file, text, capfd):
    file.write_bytes(text.encode())
    document = read(file)
    model = pinocchio.buildModelFromXML(document.text.decode())
    assert all(model.existFrame(link, pinocchio.FrameType.BODY) for link in document.description.links)
    assert set(model.names) - {"universe"} == {joint.name for joint in document.description.joints if joint.type != "fixed"}
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    "name",
    [
        "ro\rd",
        "ro\r\nd",
        "ro\n\rd",
        "ro\n\r\nd",
        "ro\td",
        "ro\n&#13;d",
        "ro&#10;d",
        " ro  d ",
        "\n&amp;&lt;&gt;&quot;&apos;",
        "\n&#x80;&#66;",
        "\u2028",
    ],
)
def test_names_are_those_that_pinocchio_reads(file, name):
    file.write_bytes(VALID.replace('"rod"', f'"{name}"').encode())
    document = read(file)
    assert pinocchio.buildModelFromXML(document.text.decode()).existFrame(document.description.links[2], pinocchio.FrameType.BODY)


def test_line_is_where_the_tag_starts(file):
    file.write_text(edited(('<link name="rod">', '<link\n  name="rod"\n>'), (' type="spherical"', ' type="spherical"\n\n ')))
    assert read(file).description.loops[0].line == LINE_W + 2
    assert first_problem(file, file.read_text().replace('"spherical"', '"ball"')).line == LINE_W + 2


def test_driver_named_twice_is_one(file):
    file.write_text(added('<transmission><joint name="guide"/><joint name="O"/></transmission>'))
    assert read(file).description.drivers == ("O", "guide")


MUTATION = st.tuples(
    st.integers(0, len(VALID.encode())), st.integers(0, 8), st.binary(max_size=4) | st.sampled_from([b"<", b'"', b"-", b"9"])
)


@examples(150)
@given(st.lists(MUTATION, max_size=3), st.integers(0, 400))
@example([], 0)
def test_damaged_file_reads_or_raises_urdf_error(tmp_path, mutations, cut):
    text = VALID.encode()
    for place, length, new in mutations:
        text = text[:place] + new + text[place + length :]
    file = tmp_path / "damaged.urdf"
    file.write_bytes(text[: len(text) - cut] if cut < 200 else text)
    errors = urdf_errors(file)
    if errors:
        with pytest.raises(UrdfError, match=re.escape(str(errors[0]))):
            read(file)
    else:
        pinocchio.buildModelFromXML(read(file).text.decode())


def test_bearings_in_the_order_of_the_drawing():
    """As the file lists joints, each loop behind the joints that carry its links; all bearings, once."""
    assert pp.load("zxn2_3000b").bearings_as_drawn == ("A", "B", "D", "C", "E", "slide_guide", "F")
    assert pp.load("thin_wall").bearings_as_drawn == ("A", "C", "slot", "B", "D", "slide_guide", "E")
    for name in ("jf75g_125_symmetric", "jf75g_125_two_point"):
        press = pp.load(name)
        assert sorted(press.bearings_as_drawn) == sorted(press.bearings)
