"""Gravity says what is up: a guide whose axis points down makes the same press as one whose axis points up, however the file lies."""

import re
import warnings

import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation
from support import texts

import pinpress as pp

PRESSES = ("crank_slide", "zxn2_3000b")


@pytest.fixture(scope="module", params=PRESSES)
def both(request):
    return texts.shipped(request.param), texts.load(texts.guide_turned_round(request.param))


def same(first, second, tolerance=1e-9):
    first, second = np.asarray(first), np.asarray(second)
    assert_allclose(second, first, rtol=0, atol=tolerance * max(np.abs(first).max(), 1e-12))


def test_positions_count_upwards_whatever_the_axis(both):
    up, down = both
    assert (up.slide_guide.sign, down.slide_guide.sign) == (1.0, -1.0)
    assert up.slide_direction.tolist() == down.slide_direction.tolist() == [0.0, 0.0, 1.0]
    first, second = (pp.cycle(press, speed=7.0, points=36) for press in both)
    same(first.joint_position[:, up.slide_guide.joint], -second.joint_position[:, down.slide_guide.joint])
    assert pp.dead_centres(up).top_position > pp.dead_centres(up).bottom_position


def test_runs_are_alike(both, method):
    """With a spring, along which the force has a coordinate of its own, and a force over time."""
    loads = [pp.loads.ElasticDie(0.005, 1e6, 1e3), pp.loads.SpringDamper("frame", "slide", 1e3), pp.loads.TimeForce(lambda time: 1e3)]
    runs = [
        pp.simulate(press, 0.6, speed=12.0, flywheel=pp.drives.Flywheel(2e3), loads=loads, method=method, points=25, tolerance=1e-9)
        for press in both
    ]
    same(runs[0].slide_position, runs[1].slide_position, 1e-6)
    same(runs[0].crank_speed, runs[1].crank_speed, 1e-6)
    assert runs[0].crank_speed[-1] < 12.0


def test_elastic_presses_and_gibs_are_alike(both):
    stiffness = pp.elasticity.Stiffness(bearings={"slide_guide": 1e9}, frame=1e9)
    found = [pp.elasticity.compliance(press, stiffness, angle=[0.5, 2.0, 4.0]) for press in both]
    same(found[0].compliance, found[1].compliance)
    same(found[0].height, found[1].height)
    gibs = pp.ratings.Gibs(length=0.5, width=0.2, middle=0.1)
    motions = [pp.cycle(press, speed=7.0, points=12) for press in both]
    pressures = [
        pp.ratings.eccentric_load(press, motion, force=1e5, offset=(0.1, 0.0, 0.0), gibs=gibs)
        for press, motion in zip(both, motions, strict=True)
    ]
    same(pressures[0].tilting_moment, pressures[1].tilting_moment)
    same(pressures[0].pressure, pressures[1].pressure)


def test_derivatives_are_alike(both):
    bearing, link = next(iter(pp.derivatives.pivot_positions(both[0])))
    changes = []
    for press in both:
        motion = pp.cycle(press, speed=7.0, points=24)
        changes += pp.derivatives.motion_derivatives(press, motion, [{(bearing, link): (0.3, 0.0, 0.1)}])
    for name in ("slide_position", "slide_velocity", "slide_acceleration"):
        same(getattr(changes[0], name), getattr(changes[1], name))


def test_check_says_so(both):
    assert not pp.check(both[1].file).warnings
    assert "the axis points down; positions, speeds and forces of slide 'slide' count upwards all the same" in [
        note.problem for note in pp.check(both[1].file).notes
    ]


@pytest.mark.parametrize(("lean", "sign"), [(0.0, -1.0), (40.0, -1.0), (50.0, -1.0), (89.0, -1.0), (90.0, 1.0), (91.0, 1.0)])
def test_only_of_a_horizontal_slide_the_axis_counts(tmp_path, lean, sign):
    """A crank-slide turned about y by an angle as a whole, its guide's axis downwards: below 90 deg that is the end where weights pull."""
    text, turn = texts.guide_turned_round("crank_slide"), np.radians(lean)
    for joint in ("O", "slide_guide"):
        part = re.search(rf'<joint name="{joint}".*?</joint>', text, re.DOTALL)[0]
        z = -0.5 * (joint == "slide_guide")
        pitch = turn + (0.5 * np.pi if joint == "O" else 0.0)
        place = f'<origin xyz="{float(z * np.sin(turn))!r} 0 {float(z * np.cos(turn))!r}" rpy="0 {float(pitch)!r} 0"/>'
        text = text.replace(part, re.sub(r"<origin[^>]*/>", place, part))
    file = tmp_path / "inclined.urdf"
    file.write_text(text, encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        inclined = pp.load(file)
    assert inclined.slide_guide.sign == sign
    down = pp.cycle(inclined, speed=1.0, points=8)
    way = down.joint_position[:, inclined.slide_guide.joint]
    assert_allclose(np.diff(down.slide_position), sign * np.diff(way), atol=1e-12)


def lying(text, rotation):
    """A press whose file has turned the world: gravity turns with it, so that it is the same press."""
    x, y, z = (float(angle) for angle in pin.rpy.matrixToRpy(rotation))
    bolts = f'<parent link="floor"/><child link="frame"/><origin rpy="{x!r} {y!r} {z!r}"/>'
    floor = f'<link name="floor"/><joint name="bolts" type="fixed">{bolts}</joint>'
    return texts.load(re.sub(r"(<robot[^>]*>)", rf"\1{floor}", text, count=1), gravity=tuple(rotation @ (0.0, 0.0, -9.81)))


ONTO = {  # rotations that bring z to these axes, of files with another axis up, and any others
    "z": np.eye(3),
    "x": np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
    "-y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "-z": np.diag([1.0, -1.0, -1.0]),
} | {f"random {seed}": Rotation.random(rng=np.random.default_rng(seed)).as_matrix() for seed in range(6)}


@pytest.mark.one_in(23)
@pytest.mark.parametrize("turned", ONTO)
@pytest.mark.parametrize("downwards", [False, True])
def test_a_press_is_the_same_however_its_file_lies(both, turned, downwards):
    """The laws of mechanics do not depend on the axes: scalars are equal, vectors turn with the world."""
    rotation, upright = ONTO[turned], both[0]
    turned_press = lying(both[downwards].text.decode(), rotation)
    np.testing.assert_allclose(turned_press.slide_direction, rotation @ [0.0, 0.0, 1.0], atol=1e-12)
    for one, other in zip(*(vars(pp.dead_centres(press)).values() for press in (upright, turned_press)), strict=True):
        assert other == pytest.approx(one, abs=1e-9)
    loads = [pp.loads.DeepDrawing(1e5, 0.02), pp.loads.ElasticDie(0.005, 1e7, 1e4), pp.loads.ConstantForce(5e4, 0.03)]
    motions = [pp.cycle(press, speed=7.0, points=48) for press in (upright, turned_press)]
    for name in ("slide_position", "slide_velocity", "slide_acceleration"):
        first_values, other_values = (getattr(motion, name) for motion in motions)
        same(first_values, other_values, 1e-8)
    first, second = (pp.inverse_dynamics(press, motion, loads) for press, motion in zip((upright, turned_press), motions, strict=True))
    for engine in ("space", "pinocchio"):
        same(first.driving_torque, pp.inverse_dynamics(turned_press, motions[1], loads, engine=engine).driving_torque, 1e-8)
    same(first.driving_torque, second.driving_torque, 1e-8)
    same(first.process_work, second.process_work, 1e-8)
    for name in first.bearing_force:
        same(first.bearing_force[name] @ rotation.T, second.bearing_force[name], 1e-7)
    same(first.shaking_force @ rotation.T, second.shaking_force, 1e-8)
    text = [str(found) for found in (first, second)]
    slides = [re.search(r"Slide\n.*?\n\n", each, re.DOTALL)[0] for each in text]
    number = r"-?\d+(?:\.\d+)?"
    assert re.sub(number, "#", slides[0]) == re.sub(number, "#", slides[1])
    ours, theirs = (np.array(re.findall(number, slide), dtype=float) for slide in slides)
    assert_allclose(theirs, ours, rtol=3e-4)  # a flat peak is located to 0.01 deg, where the slide has moved 0.02 mm
    runs = [
        pp.simulate(press, 0.2, speed=8.0, flywheel=pp.drives.Flywheel(2e3), loads=loads, points=5) for press in (upright, turned_press)
    ]
    same(runs[0].slide_position, runs[1].slide_position, 1e-6)


def test_mounts_carry_a_press_that_lies_by_its_weight():
    """The load on mounts, their sag and share are along gravity: those of the upright press."""
    rotation, upright = ONTO["y"], texts.shipped("crank_slide")
    feet = [(x, y, -1.0) for x in (-0.5, 0.5) for y in (-0.4, 0.4)]
    systems = []
    for press, turn, stiff in ((upright, np.eye(3), (2e6, 1e6, 3e6)), (lying(upright.text.decode(), rotation), rotation, (2e6, 3e6, 1e6))):
        mounts = [pp.foundation.Mount(tuple(turn @ foot), stiff, area=0.01) for foot in feet]
        frame = pp.foundation.Frame(900.0, tuple(turn @ (0.02, 0.01, -0.3)), turn @ np.diag([90.0, 80.0, 60.0]) @ turn.T)
        systems.append(pp.foundation.mounted(press, frame, mounts))
    for name in ("load_share", "pressure", "upward_load", "downward_sag"):
        same(*(getattr(system, name) for system in systems))
    assert str(systems[0]).splitlines()[2].split()[4:] == str(systems[1]).splitlines()[2].split()[4:]


def test_without_gravity_up_is_z():
    press = texts.load(texts.guide_turned_round("crank_slide"), gravity=(0.0, 0.0, 0.0))
    assert press.up.tolist() == press.slide_direction.tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize(("axis", "end"), [("1 0 0", "left"), ("-1 0 0", "right")])
def test_where_the_bottom_of_a_slide_that_lies_is(axis, end, tmp_path):
    text = texts.shipped("thin_wall").text.decode()
    head, joint = text.split('<joint name="slide_guide"')
    path = tmp_path / "lying.urdf"
    limits = ' lower="-10" upper="10"'
    joint = re.sub(r' lower="[^"]*" upper="[^"]*"', limits, joint.replace('<axis xyz="1 0 0"/>', f'<axis xyz="{axis}"/>', 1), count=1)
    path.write_text(f'{head}<joint name="slide_guide"{joint}')
    (note,) = (each for each in pp.check(path).findings if "top dead centre" in each.problem)
    assert note.severity == "note"
    assert note.problem.endswith(f"whose bottom dead centre, where process loads act, is farthest {end}")
    press = pp.load(path)
    ends, x = pp.dead_centres(press), press.slide_direction[0]
    assert ends.bottom_position < ends.top_position  # along the axis; in the world to the side that the note says
    assert (x * ends.bottom_position < x * ends.top_position) == (end == "left")
