"""Linkages written in other formats and dialects, read back by our readers and by those of others."""

import re
import warnings
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from reference.robots.cases import CASES, FOLDER
from support import texts
from support.exploring import examples
from support.generators.machine_elements import MESHING
from support.generators.random_linkages import drawn, linkages
from support.generators.spatial_linkages import bennett, bricard, four_bar

import pinpress as pp
from pinpress.pin_table.templates import template

SAME = 1e-12  # of the largest value: placements are multiplied up and taken apart again


LINKAGES = (
    {name: lambda name=name: pp.load(name) for name in pp.presses()}
    | {name: lambda name=name: pp.build(texts.file(template(name).decode(), "press.yaml")) for name in ("toggle", "rssp", "drawing-8-bar")}
    | {f"{make.__name__}_{cut}": lambda make=make, cut=cut: texts.load(make(cut)) for make in (bennett, bricard) for cut in (2, 3)}
    | {f"four_bar_{kind}": lambda kind=kind: texts.load(four_bar(kind)) for kind in ("spherical", "revolute", "fixed")}
)


def forces(press, start, names):
    """Driving torques and bearing forces (n, 1 + 3 bearings) of the first states of a turn, or on a line of several drivers, from home."""
    steps, count = np.linspace(0.0, 0.05, 4), len(press.drivers)
    places = np.array(start)[:, None] + steps * np.ones((count, 1))
    shape = (4,) if count == 1 else (4, count)
    motion = pp.servo_cycle(press, places.T.reshape(shape), speed=np.full(shape, 2.0), acceleration=np.full(shape, 3.0))
    result = pp.inverse_dynamics(press, motion)
    return np.hstack([np.reshape(result.driving_torque, (4, -1)), *(result.bearing_force[name] for name in names)])


def assert_same(press, again, bearings=True):
    """From the home of one, and from zero of the other."""
    assert (again.mobility, again.drivers) == (press.mobility, press.drivers)
    names = [name for name in press.bearings if name in again.bearings] if bearings else []
    expected = forces(press, press.closed[list(press.driver_indices)], names)
    got = forces(again, again.closed[list(again.driver_indices)], names)
    assert np.abs(got - expected).max() <= SAME * np.abs(expected).max()


@pytest.mark.one_in(14)
@pytest.mark.parametrize("name", LINKAGES)
def test_an_sdf_loads_to_the_same_forces(name, tmp_path):
    press = LINKAGES[name]()
    again = pp.load(pp.write_sdf(press, tmp_path / "press.sdf"), slide=press.slide)
    assert_same(press, again)
    assert set(press.links) <= set(again.links)


@pytest.mark.one_in(29)
@pytest.mark.parametrize("name", LINKAGES)
@pytest.mark.parametrize(("dialect", "home"), [("pinpress", True), ("urdf+", False), ("urdf+", True), ("gazebo", False), ("drake", True)])
def test_a_urdf_in_another_dialect_loads_to_the_same_forces(name, dialect, home, tmp_path):
    press = LINKAGES[name]()
    if dialect == "drake" and any(loop.type != "spherical" for loop in press.loops):
        with pytest.raises(pp.PinpressError, match="Drake's URDF has no rigid constraint but a ball"):
            pp.write_urdf(press, tmp_path / "press.urdf", dialect=dialect)
        return
    again = pp.load(pp.write_urdf(press, tmp_path / "press.urdf", home=home, dialect=dialect), slide=press.slide)
    assert (again.links, again.bearings) == (press.links, press.bearings)
    assert_same(press, again)
    if home:
        assert np.abs(again.closed).max() < 1e-14


@pytest.mark.parametrize("name", MESHING)
@pytest.mark.parametrize("form", ["sdf", "urdf+", "gazebo", "home"])
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")  # tests of each writer have its remarks
def test_teeth_and_threads_keep_motion_and_torque(name, form, tmp_path):
    press, path = pp.build(**MESHING[name]), tmp_path / ("press.sdf" if form == "sdf" else "press.urdf")
    if form == "urdf+" and name in ("lever gear", "planetary"):
        with pytest.raises(pp.PinpressError, match=r"has no <coupling> in URDF\+: its joints are not those between two links"):
            FORMS[form][0](press, path)
        return
    again = pp.load(FORMS[form][0](press, path), slide=press.slide)
    assert_same(press, again, bearings=False)
    assert set(again.meshes) == (set() if form in ("sdf", "urdf+") else set(press.meshes))


FORMS = {  # how a linkage is written, and whether joints are at zero at home then
    "urdf": (pp.write_urdf, False),
    "home": (lambda press, path: pp.write_urdf(press, path, home=True), True),
    "urdf+": (lambda press, path: pp.write_urdf(press, path, dialect="urdf+"), False),
    "gazebo": (lambda press, path: pp.write_urdf(press, path, dialect="gazebo"), True),
    "sdf": (pp.write_sdf, True),
}
OUTSIDE = ("15_", "23_")  # their states are not of one assembly, and not closed exactly
WALKED = ("10_", "16_")  # their only drivers are followed all the way round, which takes a second


def torque(press, case, at):
    """Of all drivers at the state of a case, but its drivers at other places."""
    states = [[values] if len(at) > 1 else values for values in (at, case.speed, case.acceleration)]
    motion = pp.servo_cycle(press, states[0], speed=states[1], acceleration=states[2])
    return np.ravel(pp.inverse_dynamics(press, motion).driving_torque)


@pytest.mark.one_in(23)
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("case", [case for case in CASES if not case.file.startswith((*OUTSIDE, *WALKED))], ids=lambda case: case.id)
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_robots_keep_their_torque_in_every_format(case, form, tmp_path):
    assert_same_torque(case, form, tmp_path)


@pytest.mark.exhaustive
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("case", [case for case in CASES if case.file.startswith(WALKED)], ids=lambda case: case.id)
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_spatial_robots_of_one_driver_too(case, form, tmp_path):
    assert_same_torque(case, form, tmp_path)


def assert_same_torque(case, form, tmp_path):
    if case.path.suffix == ".xml":
        pytest.importorskip("mujoco")
    press = case.press
    write, at_zero = FORMS[form]
    base = {"base": "floating"} if case.load.get("base") == "floating" and form == "sdf" else {}
    again = pp.load(write(press, tmp_path / ("robot.sdf" if form == "sdf" else "robot.urdf")), **base)
    assert (again.mobility, again.motors, len(again.passive)) == (press.mobility, press.motors, len(press.passive))
    at = np.array(case.at) - at_zero * press.closed[list(press.driver_indices)]
    expected = torque(press, case, case.at)
    np.testing.assert_allclose(torque(again, case, at), expected, rtol=0, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("name", ["14_open_pose.urdf", "16_rod_cut_in_middle.urdf", "21_keyframe_home.xml", "13_urdfplus_coupling.urdf"])
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.filterwarnings("ignore:Conversion of an array:DeprecationWarning")  # of yourdfpy 0.0.56
def test_a_urdf_with_home_at_zero_is_closed_for_another_reader(name, tmp_path):
    """The places of links by yourdfpy, with all joints at zero, bring both ends of every loop together."""
    case = next(case for case in CASES if case.file == name)
    if case.path.suffix == ".xml":
        pytest.importorskip("mujoco")
    path = pp.write_urdf(case.press, tmp_path / "home.urdf", home=True)
    import yourdfpy  # takes longer than the other imports of these tests together

    read = yourdfpy.URDF.load(str(path), load_meshes=False, build_scene_graph=True)
    read.update_cfg(np.zeros(len(read.actuated_joints)))
    for loop in ElementTree.parse(path).getroot().findall("loop_joint"):
        ends = []
        for end in (loop.find("link1"), loop.find("link2")):
            point = np.array(end.get("xyz", "0 0 0").split(), dtype=float)
            ends.append((read.get_transform(end.get("link")) @ [*point, 1.0])[:3])
        np.testing.assert_allclose(*ends, rtol=0, atol=1e-12)


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@examples(10)
@given(linkages(most=3), st.sampled_from(["sdf", "gazebo", "urdf+", "home", "pinocchio"]))
def test_random_linkages_keep_their_forces(tmp_path, spec, form):
    """With welded masses, links in parallel planes, and frames turned any way."""
    drawing = drawn(spec)
    assume(drawing)
    press = texts.load(drawing.urdf("crank"))
    if form == "pinocchio":
        again = pp.from_pinocchio(press.model, press.constraint_models(), press.drivers)
    else:
        again = pp.load(FORMS[form][0](press, tmp_path / ("robot.sdf" if form == "sdf" else "robot.urdf")))
    assert_same(press, again)


CRANK_SLIDE = pp.load("crank_slide").text.decode()
GEARS = (FOLDER / "13_urdfplus_coupling.urdf").read_text()
THIRD = """<link name="third"><inertial><mass value="1"/>
    <inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial></link>
  <joint name="J" type="continuous"><parent link="frame"/><child link="third"/><axis xyz="0 1 0"/></joint>
  <relation name="r" offset="{}"><joint name="J" coefficient="1"/><joint name="shoulder" coefficient="2"/>{}</relation></robot>"""
SPINDLE = '<joint name="spindle" coefficient="3"/>'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (CRANK_SLIDE.replace('name="O"', 'name="crank"'), "link 'crank' is called 'crank_link' in SDF, because a joint has its name"),
        (re.sub('(<link name="slide">)', r'\1<tool xyz="0 0 0.1"/>', CRANK_SLIDE), "SDF does not hold the <tool> of link 'slide'"),
        ((FOLDER / "05_flat_inertia.urdf").read_text(), "link 'rod_a' has moments of inertia that no body has, which Gazebo refuses"),
    ],
)
def test_what_sdf_does_not_hold_is_said(text, said, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pp.PinpressWarning)
        press = texts.load(text)
    with pytest.warns(pp.PinpressWarning, match=re.escape(said)):
        pp.write_sdf(press, tmp_path / "press.sdf")


@pytest.mark.parametrize(
    ("of_relation", "options", "refusal"),
    [
        (SPINDLE, None, "SDF has no element for relation 'r'"),
        (SPINDLE, {"dialect": "urdf+"}, "gear 'r' has no <coupling> in URDF+: its joints are not those between two links"),
        ("", {"dialect": "urdf"}, "dialect is 'urdf': write one of pinpress, urdf+, gazebo, drake"),
    ],
)
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_what_a_format_has_no_element_for_is_refused(of_relation, options, refusal, tmp_path):
    press = texts.load(GEARS.replace("</robot>", THIRD.format(0, of_relation)))
    with pytest.raises(pp.PinpressError, match=re.escape(refusal)):
        pp.write_sdf(press, tmp_path / "x.sdf") if options is None else pp.write_urdf(press, tmp_path / "x.urdf", **options)


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_a_gear_with_an_offset_is_a_coupling_where_home_is_zero(tmp_path):
    press = texts.load(GEARS.replace("</robot>", THIRD.format(0.3, "")))
    with pytest.raises(pp.PinpressError, match=re.escape("it has an offset; write the closed pose as zero (home)")):
        pp.write_urdf(press, tmp_path / "x.urdf", dialect="urdf+")
    again = pp.load(pp.write_urdf(press, tmp_path / "x.urdf", dialect="urdf+", home=True))
    assert_same(press, again)
