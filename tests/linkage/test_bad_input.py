"""Whatever is handed in wrong comes back as a PinpressError that says where and what to do: no other exception, no word on stderr."""

import builtins
import csv
import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import pinpress as pp

SHIPPED = Path(__file__).parents[2] / "urdf"
CRANK_SLIDE = (SHIPPED / "crank_slide.urdf").read_text(encoding="utf-8")
AXIS = '<axis xyz="0 -1 0"/>'  # first that of joint O
LOOP = '<loop_joint name="W" type="spherical">'
ROD_END = '<link1 link="rod" xyz="0.400 0 0" rpy="0 0 0"/>'
CRANK_INERTIAL = next(line.strip() for line in CRANK_SLIDE.splitlines() if '<origin xyz="0.030 0 0"/>' in line)
INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
LIMIT = '<limit lower="-1" upper="1" effort="1e6" velocity="20"/>'


@pytest.fixture(autouse=True)
def _silent(capfd):
    yield
    assert capfd.readouterr().err == ""


@pytest.fixture(scope="module")
def press():
    return pp.load("crank_slide")


@pytest.fixture(scope="module")
def motion(press):
    return pp.cycle(press, speed=7.0, points=12)


@pytest.fixture(scope="module")
def result(press, motion):
    return pp.inverse_dynamics(press, motion)


def edited(*edits: tuple[str, str]) -> str:
    """The crank-slider with texts replaced at their first place, where each must occur."""
    text = CRANK_SLIDE
    for old, new in edits:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def added(elements: str) -> str:
    return edited(("</robot>", elements + "</robot>"))


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


def written(folder: Path, text: str) -> Path:
    path = folder / "press.urdf"
    path.write_text(text, encoding="utf-8")
    return path


def four_bar(crank: float, coupler: float, rocker: float, base: float, angle: float, driver: str = "A") -> str:
    """Pivots A (origin) and D (base, 0), crank A-B at ``angle`` as drawn, coupler B-C closed upwards on the rocker D-C by the loop C."""
    bx, bz = crank * math.cos(angle), crank * math.sin(angle)
    to_d, direction = math.hypot(base - bx, bz), math.atan2(-bz, base - bx)
    cosine = (coupler**2 + to_d**2 - rocker**2) / (2 * coupler * to_d)
    raised = math.acos(min(1.0, cosine))
    cx, cz = coupler * math.cos(direction + raised), coupler * math.sin(direction + raised)
    links = "".join(f'<link name="{name}">{INERTIAL}</link>' for name in ("crank", "coupler", "rocker"))
    joints = "".join(
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{x!r} 0 {z!r}"/><axis xyz="0 -1 0"/></joint>'
        for name, parent, child, x, z in (
            ("A", "frame", "crank", 0, 0),
            ("B", "crank", "coupler", bx, bz),
            ("D", "frame", "rocker", base, 0),
        )
    )
    loop = (
        f'<loop_joint name="C" type="spherical"><link1 link="coupler" xyz="{cx!r} 0 {cz!r}"/>'
        f'<link2 link="rocker" xyz="{bx + cx - base!r} 0 {bz + cz!r}"/></loop_joint>'
    )
    drive = f'<transmission name="drive"><joint name="{driver}"/></transmission>'
    return f'<robot name="four_bar"><link name="frame"/>{links}{joints}{loop}{drive}</robot>'


# Files


@pytest.mark.parametrize(
    ("name", "problem", "remedy"),
    [
        ("none", "no such file", f"name a URDF file or a shipped press ({', '.join(pp.presses())})"),
        ("", "no such file", f"name a URDF file or a shipped press ({', '.join(pp.presses())})"),
        ("none.urdf", "No such file", "give the path of a URDF file"),
        (".", "directory", "give the path of a URDF file"),
        ("a\0b.urdf", "null", "give the path of a URDF file"),
    ],
)
def test_no_such_file(name, problem, remedy):
    with pytest.raises(pp.UrdfError) as caught:
        pp.load(name)
    assert (caught.value.file, caught.value.element, caught.value.line) == (name, None, None)
    assert problem in caught.value.problem
    assert remedy in caught.value.remedy


def test_text_of_a_urdf_is_no_path():
    with pytest.raises(pp.UrdfError, match="not the path of a file; write it to a file"):
        pp.load('<robot name="mine"><link name="frame"/></robot>')


@pytest.mark.parametrize("call", [pp.load, lambda file: pp.check(file).errors[0].error])
def test_a_table_of_pins_is_no_urdf(tmp_path, call):
    file = tmp_path / "press.yaml"
    file.write_text("units: mm", encoding="utf-8")
    with pytest.raises(pp.UrdfError, match=r"press.yaml: this is a table of pins, not a URDF; make a press of it by pp.build\(path\)"):
        raise call(file)


def test_path_object_is_reported_as_text(tmp_path):
    with pytest.raises(pp.UrdfError) as caught:
        pp.load(tmp_path)
    assert caught.value.file == str(tmp_path)


@pytest.mark.parametrize("text", [CRANK_SLIDE[:-20], CRANK_SLIDE.replace('name="crank"', 'name="crank', 1), "press", "<robot"])
def test_malformed_xml(tmp_path, text):
    path = written(tmp_path, text)
    with pytest.raises(pp.UrdfError, match="not well-formed XML") as caught:
        pp.load(path)
    assert caught.value.file == str(path)
    assert caught.value.element is None
    assert str(caught.value).startswith(f"{path}:{caught.value.line}: ")


def refused(folder: Path, text: str, element: str, at: str, problem: str) -> pp.UrdfError:
    """Loading fails with a UrdfError on this element, on the line of the text ``at``."""
    path = written(folder, text)
    with pytest.raises(pp.UrdfError) as caught:
        pp.load(path)
    error = caught.value
    assert (error.file, error.element, error.line) == (str(path), element, line_of(text, at))
    assert problem in error.problem
    said = f"{path}:{error.line}: {element}: {error.problem}; {error.remedy}"
    assert str(error) in (said, f"{said} (1 more: pinpress check {path} lists them)")
    return error


def test_missing_inertial(tmp_path):
    refused(tmp_path, edited((CRANK_INERTIAL, "")), '<link name="crank">', '<link name="crank">', "it moves, but has no <inertial>")


MASS, INERTIA, AXIS_O = (
    f'<{tag}> of <{of}">' for tag, of in (("mass", 'link name="crank'), ("inertia", 'link name="crank'), ("axis", 'joint name="O'))
)


@pytest.mark.parametrize(
    ("edit", "element", "problem"),
    [
        (('<mass value="20"', '<mass value="0"'), MASS, "the mass 0.0 of a moving link is not positive"),
        (('<mass value="20"', '<mass value="-20"'), MASS, "the mass -20.0 of a moving link is not positive"),
        (('<mass value="20"', '<mass value="NaN"'), MASS, "'NaN' is not a finite number"),
        (('<mass value="20"', '<mass value="3,5"'), MASS, "'3,5' is not a finite number"),
        (('<mass value="20"', '<mass value="abc"'), MASS, "'abc' is not a finite number"),
        (('<inertia ixx="0.05"', '<inertia ixx="0.50"'), INERTIA, "exceeds the sum of the other two"),
        (('<inertia ixx="0.05"', '<inertia ixx="-0.05"'), INERTIA, "a principal moment of inertia is negative"),
        ((AXIS, '<axis xyz="0 0 0"/>'), AXIS_O, "the axis is zero"),
        ((AXIS, '<axis xyz="0 -2 0"/>'), AXIS_O, "the axis has length 2, not 1"),
        ((AXIS, '<axes xyz="0 -1 0"/>'), '<axes> of <joint name="O">', "did you mean 'axis'?"),
        (
            (LOOP, LOOP.replace('"spherical"', '"revolut"')),
            '<loop_joint name="W">',
            "unknown loop type 'revolut', did you mean 'revolute'?",
        ),
        ((ROD_END, ROD_END.replace("rod", "rood")), '<link1> of <loop_joint name="W">', "no link 'rood', did you mean 'rod'?"),
        (('<child link="slide"/>', '<child link="rod"/>'), '<joint name="slide_guide">', "already the child of joint 'P'"),
        (("</robot>", '<link name="table"/></robot>'), '<link name="table">', "2 root links: frame, table"),
        (
            ('<joint name="O"><hardware', '<joint name="Q"><hardware'),
            '<joint name="Q"> of <transmission name="crank_drive">',
            "no joint 'Q'",
        ),
    ],
)
def test_element_at_fault(tmp_path, edit, element, problem):
    at = edit[1] if element != '<joint name="slide_guide">' else '<joint name="slide_guide"'
    refused(tmp_path, edited(edit), element, at, problem)


def test_misspelt_loop_joint(tmp_path):
    text = CRANK_SLIDE.replace("loop_joint", "lop_joint")
    refused(tmp_path, text, '<lop_joint name="W">', "<lop_joint", "unknown element <lop_joint>, did you mean 'loop_joint'?")


# Driver, slide and gravity


def driven_by(transmissions: str) -> str:
    return CRANK_SLIDE[: CRANK_SLIDE.index("<transmission")] + transmissions + "</robot>"


def test_a_driver_is_needed(tmp_path):
    path = written(tmp_path, driven_by(""))
    with pytest.raises(pp.UrdfError) as caught:
        pp.load(path)
    assert (caught.value.file, caught.value.element, caught.value.problem) == (str(path), '<robot name="crank_slide">', "no driver")
    assert "load(..., driver=...)" in caught.value.remedy
    assert pp.load(path, driver="O").drivers == ("O",)
    with pytest.raises(pp.UrdfError, match="no driver"):
        pp.load(path, driver=())


def test_drivers_more_than_degrees_of_freedom(tmp_path):
    path = written(
        tmp_path,
        driven_by('<transmission name="a"><joint name="O"/></transmission><transmission name="b"><joint name="P"/></transmission>'),
    )
    with pytest.raises(pp.UrdfError, match="mobility is 1, but 2 joints drive; drive fewer joints"):
        pp.load(path)
    assert pp.load(path, driver=["O"]).drivers == ("O",)
    with pytest.raises(pp.PinpressError, match="driver names a joint twice: O, O"):
        pp.load(path, driver=("O", "O"))


def test_no_such_driver(tmp_path):
    welded = f'<link name="cap">{INERTIAL}</link><joint name="weld" type="fixed"><parent link="rod"/><child link="cap"/></joint>'
    path = written(tmp_path, added(welded))
    for name, guess in (("slide_guid", ", did you mean 'slide_guide'?"), ("W", ""), ("weld", ""), ("", ""), (3, "")):
        with pytest.raises(pp.UnknownNameError) as caught:
            pp.load(path, driver=name)
        assert (caught.value.name, caught.value.known) == (name, ("O", "P", "slide_guide"))
        assert str(caught.value) == f"no moving joint {name!r}{guess}; there are: O, P, slide_guide"


@pytest.mark.parametrize(
    ("limit", "problem"),
    [
        ('lower="0.1" upper="0.3"', "slides from 0.1 to 0.3 m, the <limit> of its joint, and the drawn pose, 0, is outside"),
        ("", "the <limit> of the driver, which slides, is 0 to 0 m, as programs write it that know no limits"),
    ],
)
def test_driver_that_slides_needs_a_way_to_go(tmp_path, limit, problem):
    path = written(tmp_path, edited(('lower="-0.01" upper="0.21"', limit)))
    with pytest.raises(pp.UrdfError, match=problem) as caught:
        pp.load(path, driver="slide_guide")
    assert (caught.value.element, caught.value.line) == ('<joint name="slide_guide">', line_of(CRANK_SLIDE, '<joint name="slide_guide"'))


def test_slide_must_be_a_guided_link():
    with pytest.raises(pp.UnknownNameError, match="no link 'slid', did you mean 'slide'") as caught:
        pp.load("crank_slide", slide="slid")
    assert (caught.value.name, caught.value.known) == ("slid", ("frame", "crank", "rod", "slide"))
    for name in ("rod", "frame"):
        with pytest.raises(pp.PinpressError, match=f"link '{name}' is not guided by the frame; guided links: slide"):
            pp.load("crank_slide", slide=name)


@pytest.mark.parametrize("gravity", [9.81, (0, 0), (0, 0, math.nan), (0, 0, math.inf), (0, 0, "down"), "down", None, [[0, 0, -9.81]]])
def test_gravity_that_makes_no_sense_is_refused(gravity):
    with pytest.raises(pp.PinpressError, match=r"^gravity (is not finite|has shape)"):
        pp.load("crank_slide", gravity=gravity)


# Linkages that do not close or do not move


def test_open_loop_has_three_degrees_of_freedom(tmp_path):
    text = "".join(line + "\n" for line in CRANK_SLIDE.splitlines() if "<loop_joint" not in line)
    path = written(tmp_path, text)
    with pytest.raises(pp.UrdfError, match="mobility is 3, but one joint drives") as caught:
        pp.load(path)
    assert caught.value.problem.endswith("with joint 'O' held still, joints 'P', 'slide_guide' can move")
    assert "a <loop_joint> is missing" in caught.value.remedy


def test_free_link_adds_a_degree_of_freedom(tmp_path):
    pendulum = (
        f'<link name="lever">{INERTIAL}</link><joint name="L" type="continuous"><parent link="frame"/><child link="lever"/>{AXIS}</joint>'
    )
    with pytest.raises(pp.UrdfError, match=r"mobility is 2, .* with joint 'O' held still, joint 'L' can move") as caught:
        pp.load(written(tmp_path, added(pendulum)))
    assert (caught.value.element, caught.value.line) == ('<robot name="crank_slide">', None)
    assert "a link hangs free" in caught.value.remedy


def test_loop_too_many_leaves_no_mobility(tmp_path):
    stay = '<loop_joint name="V" type="spherical"><link1 link="rod" xyz="0.2 0 0"/><link2 link="frame" xyz="0 0 -0.3"/></loop_joint>'
    with pytest.raises(pp.UrdfError, match="mobility is 0, but one joint drives: loop 'V' contradicts the others") as caught:
        pp.load(written(tmp_path, added(stay)))
    assert "nothing can move" in caught.value.remedy


@pytest.mark.parametrize(
    ("edit", "gap"),
    [
        ((ROD_END, ROD_END.replace("0.400", "0.05")), 0.35),  # a rod much too short
        ((ROD_END, ROD_END.replace("0.400", "3")), 2.6),  # one much too long: the slide could follow, but not near the drawing
        (('<origin xyz="0 0 -0.500"/>', '<origin xyz="0.9 0 -0.500"/>'), 0.9),  # out of the rod's reach
        ((ROD_END, ROD_END.replace("0.400 0 0", "0.400 0.02 0")), 0.02),  # pins apart along their axis: out of the plane
        ((ROD_END, ROD_END.replace("0.400 0 0", "0.400 1e-6 0")), 1e-6),
    ],
)
def test_loop_that_does_not_close(tmp_path, edit, gap):
    text = edited(edit)
    path = written(tmp_path, text)
    with pytest.raises(pp.AssemblyError, match="loop 'W' does not close near the drawn pose; draw it closed") as caught:
        pp.load(path)
    assert caught.value.crank_angle == 0.0
    assert caught.value.gap == pytest.approx(gap, rel=1e-6)
    assert caught.value.iterations > 0
    assert str(caught.value).startswith(f"{path}:{line_of(text, LOOP)}: ")


def test_driver_at_its_dead_point(tmp_path):
    drawn = math.acos(0.8)  # crank and coupler in one line: the rocker cannot push
    path = written(tmp_path, four_bar(0.1, 0.4, 0.3, 0.4, drawn, driver="D"))
    with pytest.raises(pp.SingularityError, match="joint 'D' does not determine the drawn pose") as caught:
        pp.load(path)
    assert caught.value.crank_angle == 0.0
    assert caught.value.smallest_singular_value < 1e-9
    assert pp.load(path, driver="A").driver == "A"


@pytest.fixture(scope="module")
def locking(tmp_path_factory):
    """A four-bar whose crank turns only until coupler and rocker are in one line, and that crank angle."""
    path = written(tmp_path_factory.mktemp("locking"), four_bar(0.3, 0.25, 0.2, 0.4, 0.0))
    with pytest.warns(pp.PinpressWarning, match='<joint name="A">: it turns only from .* where the linkage locks'):
        return pp.load(path), math.acos((0.3**2 + 0.4**2 - 0.45**2) / (2 * 0.3 * 0.4))


@pytest.mark.parametrize("engine", ["plane", "space", "pinocchio"])
@pytest.mark.parametrize("sign", [1, -1])
def test_linkage_that_locks(locking, engine, sign):
    linkage, lock = locking
    assert pp.servo_cycle(linkage, speed=1.0, angle=[0.0, sign * 0.99 * lock], engine=engine).closure_error.max() < 1e-12
    for move in (
        lambda: pp.cycle(linkage, sign * 7.0, points=90, engine=engine),
        lambda: pp.servo_cycle(linkage, [0.0, sign * 1.01 * lock], speed=1.0, engine=engine),
    ):
        with pytest.raises(pp.SingularityError, match="the linkage locks") as caught:
            move()
        assert caught.value.crank_angle == pytest.approx(sign * lock, abs=1e-6)
        assert 0 <= caught.value.smallest_singular_value < 1e-3
        assert f"{math.degrees(sign * lock):.4f} deg" in str(caught.value)


# Motions


@pytest.mark.parametrize(
    ("speed", "problem"),
    [
        (math.nan, "speed is not finite"),
        (math.inf, "speed is not finite"),
        (0, "speed is 0"),
        (-0.0, "speed is 0"),
        ([1.0, 2.0], "speed is an array"),
        (np.array([7.0]), "speed is an array"),
        ("fast", "speed is not a number"),
        (None, "cycle needs the speed of the driver"),
        (1 + 2j, "speed is not a number"),
    ],
)
def test_speeds_that_make_no_sense_are_refused(press, speed, problem):
    with pytest.raises(pp.PinpressError, match=problem):
        pp.cycle(press, speed)


@pytest.mark.parametrize("points", [0, 1, -3, 2.5, 4.0, True, "360", np.array([3]), np.float64(4)])
def test_numbers_of_points_that_make_no_sense_are_refused(press, points):
    with pytest.raises(pp.PinpressError, match=r"points is .*: give a whole number from 2 to 10000000"):
        pp.cycle(press, 7.0, points=points)


def test_points_are_not_clipped(press):
    for points in (2, np.int64(3), 100_003):
        assert pp.cycle(press, 7.0, points=points).crank_angle.shape == (points,)
    for points in (10**15, 10**30):
        with pytest.raises((pp.PinpressError, MemoryError)):
            pp.cycle(press, 7.0, points=points)


@pytest.mark.parametrize(
    ("given", "problem"),
    [
        ({"angle": [[0.0, 1.0]]}, r"angle has shape \(1, 2\)"),
        ({"angle": 1.0}, r"angle has shape \(\)"),
        ({"angle": []}, r"angle has shape \(0,\)"),
        ({"angle": [0.0, math.nan]}, "angle is not finite at point 1"),
        ({"angle": [0.0, "x"]}, "angle is not a number"),
        ({"angle": [[0.0], [1.0, 2.0]]}, "angle is not a number"),
        ({"angle": [0.0, 1.0], "speed": [1.0, 2.0, 3.0]}, r"speed has shape \(3,\), but angle has \(2,\)"),
        ({"angle": [0.0, 1.0], "speed": [1.0]}, r"speed has shape \(1,\), but angle has \(2,\)"),
        ({"angle": [0.0, 1.0], "speed": [1.0, math.inf]}, "speed is not finite at point 1"),
        ({"angle": [0.0, 1.0], "acceleration": [1.0]}, "acceleration has shape"),
        ({"angle": [0.0, 1.0], "acceleration": math.nan}, "acceleration is not finite"),
        ({"angle": [0.0, 1.0], "time": 0.0}, r"time has shape \(\)"),
        ({"angle": [0.0, 1.0], "time": [0.0]}, "time has shape"),
        ({"angle": [0.0, 1.0], "time": [0.0, math.nan]}, "time is not finite at point 1"),
        ({"angle": [0.0, 1.0], "time": [1.0, 1.0]}, "time does not rise"),
        ({"angle": [0.0, 1.0, 2.0], "time": [0.0, 2.0, 1.0]}, "time does not rise"),
        ({"angle": None}, "give angle"),
        ({"angle": None, "time": [0.0, 1.0]}, "give angle, .* or height"),
        ({"speed": None}, "servo_cycle needs the speed of the driver .*, or time"),
        ({"angle": 1.0, "speed": None, "time": [0.0, 1.0]}, "angle is that at the start alone: give speed too"),
        ({"speed": None, "time": [0.0, 1.0]}, "2 states are too few to find speed and acceleration: give 6 or more"),
        ({"speed": [1.0, 2.0]}, "2 states are too few to find the acceleration"),
        ({"period": 1.0}, "period is given, but no time"),
        ({"angle": [0.0, 1.0, 2.0], "time": [0.0, 1.0, 2.0], "period": 3.0}, "2 states are too few to find a closed motion"),
        ({"angle": np.arange(9.0), "time": np.arange(9.0), "period": 7.0}, "period is 7 s, but the states take 8 s"),
        ({"angle": np.arange(9.0), "time": np.arange(9.0), "period": 11.0}, "period is 11 s, but the states take 8 s"),
        ({"angle": np.arange(9.0), "time": np.arange(9.0), "period": "a second"}, "period is 'a second'"),
        ({"flank": "up"}, "flank is given, but no height"),
        ({"height": [0.1, 0.1], "flank": "up"}, "height and angle are given: .* leave angle out"),
        ({"angle": None, "speed": None, "height": [0.1, 0.1], "flank": "up"}, "height is given, but no time"),
        ({"angle": None, "speed": None, "height": [0.1], "time": [0.0, 1.0], "flank": "up"}, "time has shape .*, but height has"),
        ({"angle": None, "speed": None, "height": [0.1, 0.1], "time": [0.0, 1.0], "flank": 5}, "flank is 5: give"),
        ({"angle": None, "speed": None, "height": [0.1, 0.1], "time": [0.0, 1.0]}, "flank is None: give"),
        ({"engine": "mujoco"}, "unknown engine 'mujoco': write 'auto', 'plane', 'space' or 'pinocchio'"),
        ({"engine": None}, "unknown engine None"),
    ],
)
def test_servo_motions_that_make_no_sense_are_refused(press, given, problem):
    with pytest.raises(pp.PinpressError, match=problem):
        pp.servo_cycle(press, **({"angle": [0.0, 1.0], "speed": 1.0} | given))


@pytest.mark.exhaustive
def test_plane_engine_where_the_linkage_is_not_planar(tmp_path):
    head = (
        f'<link name="head">{INERTIAL}</link><joint name="Q" type="continuous"><parent link="rod"/><child link="head"/>'
        f'<origin xyz="0.4 0 0" rpy="0 -1.5707963267948966 0"/>{AXIS}</joint>'
    )
    weld = '<loop_joint name="W" type="fixed"><link1 link="head"/>'
    press = pp.load(written(tmp_path, edited((LOOP, weld), (ROD_END, ""), ("</robot>", head + "</robot>"))))
    motion = pp.cycle(press, 7.0, points=3)
    for call in (lambda: pp.cycle(press, 7.0, engine="plane"), lambda: pp.inverse_dynamics(press, motion, engine="plane")):
        with pytest.raises(pp.PinpressError, match=r"not a planar linkage.*: use engine='space'"):
            call()


@pytest.mark.parametrize("speed", [1.0, [1.0, -1.0], [0.0, 0.0]])
def test_time_of_states_that_are_no_motion(press, speed):
    states = pp.servo_cycle(press, speed=speed, angle=[1.0, 0.5], acceleration=0.0)
    with pytest.raises(pp.PinpressError, match="pass time= to servo_cycle"):
        _ = states.time
    assert "time [s]" not in states.columns()


def test_slide_of_a_linkage_without_one(locking):
    linkage, _ = locking
    states = pp.servo_cycle(linkage, speed=1.0, angle=[0.0, 0.5])
    for name in ("slide_position", "slide_velocity", "slide_acceleration"):
        with pytest.raises(pp.PinpressError, match=r"four_bar has no slide: .* load\(..., slide=...\)"):
            getattr(states, name)
    with pytest.raises(pp.PinpressError, match="has no slide"):
        pp.dead_centres(linkage)


# Loads and reactions


@pytest.mark.parametrize("engine", ["plane", "space", "pinocchio"])
@pytest.mark.parametrize(
    ("load", "problem"),
    [
        (pp.loads.PointForce("slide", np.zeros((11, 3))), r"load on 'slide': force has shape \(11, 3\); give \(3,\) or \(12, 3\)"),
        (pp.loads.PointForce("slide", lambda motion: np.zeros((3, 12))), r"force has shape \(3, 12\)"),
        (pp.loads.PointForce("slide", lambda motion: None), "force is not"),  # type: ignore[return-value]
    ],
)
def test_loads_of_another_shape_are_refused(press, motion, engine, load, problem):
    with pytest.raises(pp.PinpressError, match=problem):
        pp.inverse_dynamics(press, motion, loads=[load], engine=engine)


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        (((0.0, 1.0),), r"force has shape \(2,\); give \(3,\) or \(n, 3\)"),
        ((5.0,), r"force has shape \(\)"),
        (((0.0, math.nan, 0.0),), "force is not finite"),
        (("up",), "force is not a number or an array of numbers"),
        (((0.0, 0.0, 1.0), (0.0, 0.0)), r"point has shape \(2,\)"),
        (((0.0, 0.0, 1.0), (0.0, 0.0, math.inf)), "point is not finite"),
        (((0.0, 0.0, 1.0), "tip"), "point is not a number or an array of numbers"),
    ],
)
def test_a_load_that_makes_no_sense_is_refused_when_it_is_made(values, problem):
    with pytest.raises(pp.PinpressError, match=f"^load on 'slide': {problem}"):
        pp.loads.PointForce("slide", *values)


def test_load_on_unknown_link(press, motion):
    with pytest.raises(pp.UnknownNameError, match="no link 'slid', did you mean 'slide'") as caught:
        pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slid", (0.0, 0.0, 1.0))])
    assert (caught.value.name, caught.value.known) == ("slid", ("frame", "crank", "rod", "slide"))


def test_exception_of_the_callers_own_load_is_named(press, motion):
    def force(motion):
        raise ZeroDivisionError("mine")

    with pytest.raises(pp.PinpressError, match="load on 'slide': force cannot be worked out: ZeroDivisionError: mine") as caught:
        pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slide", force)])
    assert isinstance(caught.value.__cause__, ZeroDivisionError)


@pytest.mark.parametrize("quantity", ["bearing_force", "bearing_moment", "indeterminate"])
def test_unknown_bearing(result, quantity):
    mapping = getattr(result, quantity)
    known = ("O", "P", "slide_guide", "W")
    for kind in (pp.PinpressError, KeyError):
        with pytest.raises(kind) as caught:
            mapping["slide_guid"]
        assert (caught.value.name, caught.value.known) == ("slide_guid", known)  # type: ignore[attr-defined]
        assert str(caught.value) == "no bearing 'slide_guid', did you mean 'slide_guide'?; there are: O, P, slide_guide, W"
    assert mapping.get("slide_guid") is None
    assert mapping.get("Q", 3) == 3
    assert "W" in mapping
    assert "Q" not in mapping
    assert None not in mapping
    assert tuple(mapping) == known


@pytest.mark.parametrize(
    ("call", "problem"),
    [
        (lambda press, motion: pp.inverse_dynamics(press, motion, engine="planar"), "unknown engine 'planar'"),
        (lambda press, motion: pp.inverse_dynamics(pp.load("zxn2_3000b"), motion), "of crank_slide with other joints than zxn2_3000b"),
        (lambda press, motion: pp.inverse_dynamics(press, motion, loads=pp.loads.PointForce("slide", (0.0, 0.0, 1.0))), "give a list"),
        (lambda press, motion: motion.to_csv("a\0b"), "cannot write"),
        (lambda press, motion: motion.to_mat("a\0b"), "cannot write"),
    ],
    ids=["engine", "press", "load", "csv", "mat"],
)
def test_what_does_not_fit_a_motion_is_refused(press, motion, call, problem):
    with pytest.raises(pp.PinpressError, match=problem):
        call(press, motion)


@pytest.mark.parametrize("engine", ["plane", "space", "pinocchio"])
@pytest.mark.parametrize("edit", [(ROD_END, ROD_END.replace("0.400", "0.390")), ('<origin xyz="0.100 0 0"/>', '<origin xyz="0.090 0 0"/>')])
def test_motion_of_another_lengths(tmp_path, motion, engine, edit):
    with pytest.warns(pp.PinpressWarning, match="W.*it is 10 mm apart as drawn"):
        other = pp.load(written(tmp_path, edited(edit)))
    with pytest.raises(pp.AssemblyError, match="the motion leaves the loops of this linkage open") as caught:
        pp.inverse_dynamics(other, motion, engine=engine)
    assert caught.value.gap == pytest.approx(0.01, rel=1e-6)
    assert np.abs(motion.crank_angle - caught.value.crank_angle % (2 * np.pi)).min() < 1e-9


GUIDE = pp.elasticity.eight_way_guide(facing_x=(0.1, 0.1), facing_y=(0.1, 0.1), length=0.3, width=0.05, stiffness=1e9)


@pytest.mark.parametrize(
    "take",
    [
        pp.measures.bearing_positions,
        pp.measures.transmission_angle_curves,
        lambda press, motion: pp.derivatives.motion_derivatives(press, motion, [{("W", "rod"): (1.0, 0.0, 0.0)}]),
        lambda press, motion: pp.record(press, motion, "/no/such/folder/never.html"),
        lambda press, motion: pp.visual_model(press, motion),
        lambda press, motion: pp.measured.plan(press, {"turning": motion}, noise=1.0),
        lambda press, motion: pp.elasticity.guide_contact(press, pp.inverse_dynamics(pp.load("crank_slide"), motion), GUIDE),
    ],
    ids=["bearing_positions", "transmission_angle_curves", "motion_derivatives", "record", "visual_model", "plan", "guide_contact"],
)
def test_motion_of_another_lengths_is_not_read(tmp_path, motion, take):
    """What is read off a motion alone would be of no press."""
    with pytest.warns(pp.PinpressWarning, match="W.*it is 10 mm apart as drawn"):
        other = pp.load(written(tmp_path, edited((ROD_END, ROD_END.replace("0.400", "0.390")))))
    with pytest.raises(pp.PinpressError, match=r"leaves the loops of crank_slide open by 0\.01 m at crank angle .* of other lengths"):
        take(other, motion)
    take_again = pp.measures.bearing_positions(pp.load("crank_slide"), motion)  # the same press, loaded once more, may take it
    assert len(take_again) == 4


# Files written


@pytest.mark.parametrize("write", ["to_csv", "to_mat"])
def test_place_that_cannot_be_written(tmp_path, motion, result, write):
    for thing in (motion, result):
        for path in (tmp_path / "missing" / "file", tmp_path):
            with pytest.raises(pp.PinpressError, match=f"cannot write {path}: .*; give a file in a directory"):
                getattr(thing, write)(path)


def test_frame_without_pandas(monkeypatch, motion, result):
    true_import = builtins.__import__

    def without_pandas(name, *args, **kwargs):
        if name.split(".")[0] == "pandas":
            raise ImportError(name)
        return true_import(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without_pandas)
    for thing in (motion, result):
        with pytest.raises(pp.PinpressError, match=r"pip install 'pinpress\[tables\]'"):
            thing.to_frame()


@pytest.mark.parametrize("engine", ["plane", "space", "pinocchio"])
def test_results_cannot_be_written_to(press, engine):
    motion = pp.cycle(press, 7.0, points=3, engine=engine)
    result = pp.inverse_dynamics(press, motion, engine=engine)
    arrays = [motion.q, motion.v, motion.a, result.shaking_force, result.shaking_moment, result.power_residual]
    arrays += [*motion.columns().values(), *result.columns().values()]
    for name in result.bearing_force:
        arrays += [result.bearing_force[name], result.bearing_moment[name], result.indeterminate[name]]
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    with pytest.raises(TypeError):
        result.bearing_force["O"] = np.zeros(3)


@pytest.mark.parametrize("frozen", ["press", "motion", "result"])
def test_attributes_cannot_be_set(request, frozen):
    with pytest.raises(AttributeError):
        request.getfixturevalue(frozen).motion = None


def test_arrays_handed_in_stay_the_callers(press):
    angle, speed = np.array([0.0, 0.5]), np.array([1.0, 1.0])
    states = pp.servo_cycle(press, speed=speed, angle=angle)
    angle[0] = speed[0] = 9.0
    assert (states.crank_angle[0], states.crank_speed[0]) == (0.0, 1.0)


# Hostile names

HOSTILE = {"O": "<script>alert(1)</script>", "P": 'Kurbel, "Zapfen"  1', "slide_guide": "导轨", "W": "a'b;c"}


def renamed(names: dict[str, str]) -> str:
    text = CRANK_SLIDE
    for old, new in names.items():
        escaped = new.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
        text = text.replace(f'joint name="{old}"', f'joint name="{escaped}"')
    return text


@pytest.fixture(scope="module")
def hostile(tmp_path_factory):
    press = pp.load(written(tmp_path_factory.mktemp("hostile"), renamed(HOSTILE)))
    return pp.inverse_dynamics(press, pp.cycle(press, 7.0, points=12))


def test_hostile_names_are_names(hostile, result):
    assert set(hostile.bearing_force) == set(HOSTILE.values())
    for old, new in HOSTILE.items():
        np.testing.assert_array_equal(hostile.bearing_force[new], result.bearing_force[old])


def test_hostile_names_in_csv(hostile, tmp_path):
    hostile.to_csv(tmp_path / "result.csv")
    with open(tmp_path / "result.csv", newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header == list(hostile.columns())
    for name in HOSTILE.values():
        column = [float(row[header.index(f"force_{name}_x [N]")]) for row in rows]
        assert column == hostile.bearing_force[name][:, 0].tolist()


def test_hostile_names_in_mat(hostile, tmp_path):
    from scipy.io import loadmat

    hostile.to_mat(tmp_path / "result.mat")
    loaded = {name: values for name, values in loadmat(tmp_path / "result.mat").items() if not name.startswith("__")}
    assert len(loaded) == len(hostile.columns())
    assert all(name.isascii() and name.isidentifier() for name in loaded)
    for values, column in zip(loaded.values(), hostile.columns().values(), strict=True):
        assert values[:, 0].tolist() == column.tolist()


@pytest.mark.parametrize("names", [{"O": "肘", "P": "膝"}, {"O": "A-1", "P": "A 1"}, {"O": "shaft [left]"}])
def test_no_column_is_lost_in_mat(tmp_path, names):
    from scipy.io import loadmat

    press = pp.load(written(tmp_path, renamed(names)))
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 7.0, points=3))
    reactions.to_mat(tmp_path / "result.mat")
    assert len([name for name in loadmat(tmp_path / "result.mat") if not name.startswith("__")]) == len(reactions.columns())


# Overflow: numbers out of floating point's range are refused, not handed back as inf or nan


@pytest.mark.parametrize("engine", ["plane", "space", "pinocchio"])
@pytest.mark.parametrize(
    "given",
    [
        pytest.param({"speed": 1e200}, id="turn"),
        pytest.param({"speed": 1e-320}, id="time"),
        pytest.param({"speed": 1e200, "angle": [0.1, 0.2]}, id="servo"),
    ],
)
def test_motion_out_of_range(press, engine, given):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pp.PinpressWarning)  # that it may be in r/min
        with pytest.raises(pp.PinpressError):
            (pp.servo_cycle if "angle" in given else pp.cycle)(press, engine=engine, **given)


HUGE = (1e308, 1e308, 1e308)
FAR = (1e5, 1e5, 1e5)


@pytest.mark.parametrize("engine", ["plane", "space", "pinocchio"])
@pytest.mark.parametrize(
    "load",
    [pp.loads.PointForce("slide", HUGE, FAR), pp.loads.PointForce("frame", HUGE, FAR)],
    ids=["slide", "frame"],
)
def test_load_out_of_range(press, motion, engine, load):
    with np.errstate(all="ignore"), pytest.raises(pp.PinpressError, match="not finite"):  # warnings have a test of their own, the next
        _ = pp.inverse_dynamics(press, motion, loads=[load], engine=engine).shaking_moment  # all that a load on the frame reaches


@pytest.mark.parametrize("engine", ["plane", "space", "pinocchio"])
def test_load_out_of_range_is_refused_without_warnings(press, motion, engine):
    with pytest.raises(pp.PinpressError, match="not finite"):
        pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slide", HUGE, FAR)], engine=engine)


@pytest.mark.parametrize("engine", ["plane", "space", "pinocchio"])
def test_power_out_of_range_is_not_balanced(press, engine):
    with pytest.warns(pp.PinpressWarning, match="rad/s, .* r/min"):
        motion = pp.cycle(press, 1e140, points=12)
    result = pp.inverse_dynamics(press, motion, engine=engine)
    with np.errstate(all="ignore"), pytest.raises(pp.PinpressError):
        _ = result.power_residual


# Other defects


def test_loads_from_a_generator_stay_in_the_power_balance(press, motion):
    result = pp.inverse_dynamics(press, motion, loads=(pp.loads.PointForce("slide", (0.0, 0.0, force)) for force in (-1e6,)))
    assert np.abs(result.power_residual).max() < 1e-9


def test_linkage_cannot_be_written_to():
    press = pp.load("crank_slide")
    with pytest.raises(ValueError, match="read-only"):
        press.closed[0] = 1.0


def test_driver_locked_beside_a_link_that_hangs_free(tmp_path):
    """One degree of freedom, but not the driver's: the crank is pinned to the frame at its tip, the pendulum no loop reaches moves."""
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    file = tmp_path / "locked.urdf"
    file.write_text(
        f'<robot name="locked"><link name="frame"/><link name="crank">{inertial}</link><link name="pendulum">{inertial}</link>'
        '<joint name="A" type="continuous"><parent link="frame"/><child link="crank"/><axis xyz="0 -1 0"/></joint>'
        '<joint name="P" type="continuous"><parent link="frame"/><child link="pendulum"/><axis xyz="0 -1 0"/></joint>'
        '<loop_joint name="C" type="spherical"><link1 link="frame" xyz="1 0 0"/><link2 link="crank" xyz="1 0 0"/></loop_joint>'
        '<transmission name="drive"><joint name="A"/></transmission></robot>',
        encoding="utf-8",
    )
    with pytest.raises(pp.SingularityError, match="joint 'A' does not determine the drawn pose") as caught:
        pp.load(file)
    assert caught.value.smallest_singular_value == 0.0
