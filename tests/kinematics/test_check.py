"""What `check` finds beside errors (those are in `malformed_urdf`), and how it says it."""

import dataclasses
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators import malformed_linkages as goes
from support.generators.malformed_linkages import AXIS, GEAR, GOES, ORIGIN_GUIDE, ROD_END, TRANSMISSION, changed, pinned, with_element
from support.generators.malformed_urdf import INERTIAL
from support.generators.pin_tables import crank_slide
from support.generators.spatial_linkages import bennett, four_bar
from support.refused_commands import refused

import pinpress as pp
from pinpress.cli.main import main
from pinpress.kinematics.main_data import sense_of_rotation

URDF = Path(__file__).resolve().parents[2] / "urdf"
ZXN2, SYMMETRIC = ((URDF / f"{name}.urdf").read_text(encoding="utf-8") for name in ("zxn2_3000b", "jf75g_125_symmetric"))
TWICE = with_element(f'<loop_joint name="V" type="spherical">{ROD_END}{goes.SLIDE_END}</loop_joint>')


@pytest.fixture
def check(tmp_path):
    """`check` of a text."""

    def checked(text, **options):
        file = tmp_path / "press.urdf"
        file.write_text(text, encoding="utf-8")
        return pp.check(file, **options)

    return checked


def edited(text, old, new):
    assert old in text
    return text.replace(old, new, 1)


def said(findings):
    return [(finding.element, finding.line, finding.problem) for finding in findings]


# ------------------------------------------------------------------------------------------------------------------------- healthy presses


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", pp.presses())
def test_shipped_presses_have_nothing_to_be_warned_of(name):
    report = pp.check(name)
    assert said([*report.errors, *report.warnings]) == []
    press = texts.shipped(name)
    facts = report.facts
    assert (facts.drivers, facts.slide, facts.joints, facts.mobility) == (press.drivers, press.slide, press.joints, press.mobility)
    assert facts.engine == ("pinocchio" if "plane" not in press.engines else "plane")
    assert sorted(each.name for each in facts.closings) == sorted(
        [*(loop.name for loop in press.loops), *(pair.name for pair in press.couplings)]
    )
    assert max(each.gap for each in facts.closings) < 1e-12


def test_page_of_a_healthy_press():
    report = pp.check("zxn2_3000b")
    assert (
        str(report)
        == f"""\
{report.file}: no errors, no warnings, 1 note

  stroke                         301.261 mm
  top dead centre                155.497 deg    of A, which is at 0 deg as drawn
  bottom dead centre             334.525 deg
  slide as drawn                   1.612 mm     above bottom dead centre
  from top to bottom              49.730 %      of the time, 179.03 deg of A
  from bottom to top              50.270 %      of the time, 180.97 deg of A
  process force acts at x = 0.0 mm, pin F
  driver                               A        a positive speed turns it counter-clockwise, seen with x to the right and z up
  largest extent                  1864.9 mm     of the bearings as drawn
  moving mass                     11.522 t      all links but the frame, slide 7.074 t
  mobility                             1        free motion: 5 joints less 4 equations of loops and gear pairs (2 more are redundant)
  engine                           plane

Bearings in the order of the drawing
                                 force of - on      as drawn   determines
  A             pin              frame - crank                 driver
  B             pin              crank - coupler
  D             pin              frame - rocker
  C             spherical loop   coupler - rocker   closed     B, D
  E             pin              rocker - rod
  slide_guide   guide            frame - slide
  F             spherical loop   rod - slide        closed     E, slide_guide

Least transmission angles (between the two links of a dyad; best at 90 deg, at 0 they are in line and lock)
      joined to the rest by   angle [deg]   at crank [deg]
  C   B, D                    62.89         170.91
  F   E, slide_guide          43.29         155.50

note: 2 equations are redundant across the plane of the linkage, as in any with parallel pins
    nothing is wrong; what bearings carry across the plane is shared by least squares: reactions.indeterminate marks it"""
    )


def test_main_data_of_a_press():
    """Masses as the source prints them; heights and shares from the motion."""
    press, data = texts.shipped("zxn2_3000b"), pp.check("zxn2_3000b").facts.data
    assert (data.moving_mass, data.slide_mass) == (pytest.approx(sum(i.mass for i in list(press.model.inertias)[1:])), 7073.87)
    motion = pp.cycle(press, speed=1.0, points=7200)
    assert data.stroke == pytest.approx(np.ptp(motion.slide_position), abs=1e-6)
    assert data.drawn_height == pytest.approx(motion.slide_position[0] - motion.slide_position.min(), abs=1e-6)
    assert data.forward_share == pytest.approx(np.mean(motion.slide_velocity < 0), abs=2e-4)
    assert sense_of_rotation(press, -1.0) == "clockwise"


TOGGLE = """\
units: mm
frame: O T
pins: {O: [-620, 310], T: [0, 900], A: {from: O, length: r, angle: 0}, K: {A: 600, T: 420, side: right}, W: {K: 450, x: 0, side: down}}
links:
  crank: {pins: O A, mass: 55}
  pitman: {pins: A K, mass: 79}
  upper: {pins: T K, mass: 98}
  lower: {pins: K W, mass: 103}
  slide: {pins: W, guide: up, mass: 850}
drive: O
parameters: {r: 110}
"""


def test_a_toggle_that_passes_its_straight_position_is_noted(tmp_path):
    """Straight it is 870 mm long, twice in a turn; between them the slide rises. With a crank of 40 mm it turns back twice alone."""
    (tmp_path / "toggle.yaml").write_text(TOGGLE, encoding="utf-8")
    press = pp.build(tmp_path / "toggle.yaml")
    pp.write_urdf(press, tmp_path / "toggle.urdf")
    (note,) = (note for note in pp.check(tmp_path / "toggle.urdf").notes if "turns back" in note.problem)
    turn = pp.cycle(press, 1.0, points=3600)
    speed, height = turn.slide_velocity, 1e3 * (turn.slide_position - (0.900 - 0.420 - 0.450))
    before = np.flatnonzero(np.sign(speed) != np.sign(np.roll(speed, -1)))
    assert len(before) == 4
    middle, _, _, second = before  # the dead centres are the bottom after the drawn pose, and the top
    places = [(k + speed[k] / (speed[k] - speed[k + 1])) / 10 for k in (middle, second)]
    assert note.problem == (
        f"the slide turns back 4 times in a turn of O, besides its dead centres at {places[0]:.2f} deg {height[middle]:.3f} mm,"
        f" at {places[1]:.2f} deg {height[second]:.3f} mm above the bottom"
    )
    pp.write_urdf(pp.build(tmp_path / "toggle.yaml", r=40), tmp_path / "short.urdf")
    assert not [note for note in pp.check(tmp_path / "short.urdf").notes if "turns back" in note.problem]


def test_each_of_several_drivers_has_its_own_sense(check):
    """The axis of the right motor is turned over: it points away from the reader, and the drawn pose stays what it is."""
    five_bar = (URDF.parent / "docs" / "examples" / "five_bar.urdf").read_text(encoding="utf-8")
    right, turned = (f'rpy="0 -0.9416 0"/><axis xyz="0 {y} 0"/>' for y in (-1, 1))
    assert right in five_bar
    report = check(five_bar.replace(right, turned))
    assert report.facts.data.rotation == ("counter-clockwise", "clockwise")
    assert [line.split()[:2] for line in str(report).splitlines() if "a positive speed" in line] == [
        ["driver", "motor_left"],
        ["driver", "motor_right"],
    ]
    (why,) = (note.problem for note in report.notes if "engine" in note.problem)
    assert why == "engine 'space' computes it, not 'plane': there are 2 drivers"


def test_gear_pairs_stand_below_the_joint_that_follows(check):
    lines = str(check(SYMMETRIC)).splitlines()
    place = next(k for k, line in enumerate(lines) if line.startswith("  O_right "))
    assert lines[place + 1].split() == ["gear", "pair", "O_right", "-", "O_left", "closed", "O_right"]


def test_a_flat_dyad_is_told():
    """A crank nearly as long as the rod, cos = r / l; from a pin table."""
    report = pp.pin_table.draft(**crank_slide(rod=110)).check()
    (dyad,) = report.facts.dyads
    assert dyad.least_transmission_angle == pytest.approx(math.acos(100 / 110), abs=1e-9)
    assert "24.62         90.00            below 30 deg, as in a knuckle" in str(report)


def test_what_can_be_read_of_a_file_with_errors(check):
    report = check(changed(('name="slide"', 'name=" slide"'), ("<!-- P -->", '<dynamics damping="1"/>')))
    assert report.facts is None
    assert "as far as it can be read: 5 links, 4 joints, 1 loop, 4.0000 kg" in str(report)


def test_order_in_which_loops_close():
    closings = {each.name: each for each in pp.check("jf75g_125_symmetric").facts.closings}
    assert list(closings) == ["O_right", "P4_left", "P5_left", "P4_right", "P5_right"]
    assert closings["O_right"].joints == ("O_right",)
    assert closings["P4_left"].joints == ("P2_left", "slide_guide")
    assert closings["P4_right"].joints == ("P2_right",)
    assert (closings["O_right"].type, closings["O_right"].between) == ("gear pair", ("O_right", "O_left"))
    assert closings["P5_left"].between == ("auxiliary_rod_left", "counterweight")


# ---------------------------------------------------------------------------------------------------------------------------- redundancy


def redundancies(report):
    return [finding.problem for finding in report.notes if "redundant" in finding.problem]


HINGED = changed((goes.OPENING_W, goes.OPENING_W.replace("spherical", "revolute")), ("</loop_joint>", f"{AXIS}</loop_joint>"))


@pytest.mark.parametrize(("text", "across", "verb"), [(GOES, 1, "equation is"), (HINGED, 3, "equations are")])
def test_redundancy_across_the_plane(check, text, across, verb):
    report = check(text)
    assert redundancies(report) == [f"{across} {verb} redundant across the plane of the linkage, as in any with parallel pins"]
    assert (report.facts.equations, report.facts.rank) == (3 + across, 3)
    assert report.facts.engine == "plane"


def test_redundancy_in_the_plane_names_what_takes_part(check):
    """Also those whose idle force is zero in the drawn pose, a dead centre: the gear pair."""
    _, further = redundancies(check(SYMMETRIC))
    assert further == (
        "2 equations are redundant in the plane, of loop 'P4_left', loop 'P4_right', loop 'P5_left', loop 'P5_right',"
        " gear pair of joint 'O_right'"
    )
    across, further = redundancies(check(TWICE))
    assert across.startswith("2 equations are redundant across the plane")
    assert further == "2 equations are redundant in the plane, of loop 'W', loop 'V'"


@pytest.mark.parametrize("text", [SYMMETRIC, TWICE], ids=["symmetric", "twice"])
def test_loops_that_share_are_those_with_indeterminate_forces(check, tmp_path, text):
    """By the rank of the equations in the engine, over a turn: forces in the plane."""
    press = pp.load(check(text).file)
    result = pp.inverse_dynamics(press, pp.cycle(press, 3.0, points=12))
    open_in_plane = {loop.name for loop in press.loops if result.indeterminate[loop.name][[0, 2]].any()}
    assert set(re.findall(r"loop '(\w+)'", redundancies(check(text))[1])) == open_in_plane


@pytest.mark.exhaustive
def test_a_weld_is_held_in_the_plane_too(check):
    """Three of its six equations lie in the plane, none of them redundant in a four-bar."""
    report = check(four_bar("fixed"))
    assert redundancies(report) == ["3 equations are redundant across the plane of the linkage, as in any with parallel pins"]
    assert [finding.problem for finding in report.notes if "engine" in finding.problem] == [
        "engine 'space' computes it, not 'plane': loop 'W' is a weld"
    ]
    assert report.facts.engine == "space"


@pytest.mark.exhaustive
def test_redundancy_in_space(check):
    report = check(bennett())
    assert redundancies(report) == ["3 equations are redundant in space, of loop 'J3'"]
    assert report.facts.closings[0].joints == ("J1", "J2", "J4")


# ------------------------------------------------------------------------------------------------------------------------- as drawn


@pytest.mark.parametrize(
    ("edit", "apart"),
    [
        ((ROD_END, ROD_END.replace("0.4", "0.4003")), "0.3 mm"),
        ((ROD_END, ROD_END.replace("0.4", "0.399998")), "0.002 mm"),
        ((ORIGIN_GUIDE, ORIGIN_GUIDE.replace('xyz="0 ', 'xyz="0.02 ')), "20 mm"),
    ],
)
def test_drawn_open(check, edit, apart):
    (finding,) = check(changed(edit)).warnings
    assert finding.problem == f"it is {apart} apart as drawn"
    assert finding.remedy.startswith("draw it closed; to close it, load has moved joint ")
    assert finding.line == 12


def test_drawn_open_within_rounding_is_no_finding(check):
    assert check(changed((ROD_END, ROD_END.replace("0.4", "0.4000001")))).warnings == ()


@pytest.mark.exhaustive
def test_gap_and_misalignment_of_a_loop(check):
    """Of a revolute loop in space whose one side is shifted and turned; the linkage then does not close."""
    text = bennett()
    (loop,) = check(text).facts.closings
    assert max(loop.gap, loop.misalignment) < 1e-12
    place = re.search(r'<link1 link="link2" xyz="([^"]+)" rpy="([^"]+)"', text)
    xyz, rpy = (np.array(numbers.split(), dtype=float) for numbers in place.groups())
    tilted = pin.rpy.matrixToRpy(pin.rpy.rpyToMatrix(rpy) @ pin.exp3(np.array([2e-3, 0.0, 0.0])))  # across the axis of the loop
    written = (" ".join(map(repr, map(float, numbers))) for numbers in (np.add(xyz, [3e-4, -4e-4, 0.0]), tilted))
    (loop,) = check(text.replace(place[0], '<link1 link="link2" xyz="{}" rpy="{}"'.format(*written))).facts.closings
    assert (loop.gap, loop.misalignment) == (pytest.approx(5e-4, rel=1e-9), pytest.approx(2e-3, rel=1e-9))


@pytest.mark.exhaustive
def test_rounded_axes(check):
    """A redundant linkage that loads though its axes are not parallel: the slow engine takes it, which is said."""
    report = check(edited(SYMMETRIC, 'rpy="0 1.5707963267948966 0"/><axis', 'rpy="1e-4 1.5707963267948966 0"/><axis'))
    (finding,) = report.warnings
    assert "the axis of joint 'O_right' is 0.00573 deg off the normal of the plane in which joint 'O_left' turns" in finding.problem
    assert finding.remedy.startswith("axes are up to 0.0001 rad from parallel: write angles in full")
    assert report.facts.engine == "space"


# ------------------------------------------------------------------------------------------------------------------------- joint limits


def test_joint_that_leaves_its_limits(check):
    """Crank angle and value are those of the furthest state of a turn."""
    report = check(edited(ZXN2, 'lower="-1.0" upper="1.6"', 'lower="-1.0" upper="0.5"'))
    (finding,) = report.warnings
    press = texts.shipped("zxn2_3000b")
    rocker = pp.cycle(press, 1.0, points=720).joint_position[:, press.joints.index("D")]
    value, angle = rocker.max(), rocker.argmax() / 2
    assert finding.problem == (
        f"it reaches {value:.6g} rad ({np.degrees(value):.4g} deg) at crank angle {angle:.6g} deg, beyond its upper limit 0.5"
    )
    assert finding.element == '<limit> of <joint name="D">'
    assert check(edited(ZXN2, 'upper="1.6"', f'upper="{value + 1e-3}"')).warnings == ()


def test_slide_that_leaves_its_limits(check):
    (finding,) = check(edited(ZXN2, 'lower="-0.05" upper="0.35"', 'lower="-0.001" upper="0.35"')).warnings
    assert re.fullmatch(r"it reaches -0\.0016\d+ m at crank angle 334\.5 deg, beyond its lower limit -0\.001", finding.problem)


def test_drawn_pose_outside_the_limits(check):
    (finding,) = check(edited(ZXN2, 'lower="-0.05" upper="0.35"', 'lower="0.05" upper="0.35"')).warnings
    assert finding.problem == "the linkage is put together with it at 0 m, outside its limits 0.05 to 0.35"


def test_limits_of_a_continuous_joint_mean_nothing(check):
    limit = '<limit lower="0.1" upper="0.2" effort="1" velocity="1"/>'
    assert check(changed((f"{AXIS}<!-- P -->", f"{AXIS}{limit}"))).warnings == ()


@pytest.mark.exhaustive
def test_linkage_that_locks(check):
    """The guide stands off by more than the rod's length: the crank turns until the rod lies across it, 60 deg to either side of x."""
    across, up = 0.45 - goes.PIN[0], -math.sqrt(goes.ROD_LENGTH**2 - (0.45 - goes.PIN[0]) ** 2)
    text = changed(
        (ORIGIN_GUIDE, f'<origin xyz="0.45 0 {goes.PIN[1] + up!r}"/>'),
        (goes.ORIGIN_P, f'<origin xyz="{goes.CRANK_LENGTH!r} 0 0" rpy="0 {goes.ANGLE - math.atan2(up, across)!r} 0"/>'),
    )
    (finding,) = check(text).warnings  # the joint is of type "continuous"
    low, high = map(float, re.fullmatch(r"it turns only from (\S+) to (\S+) deg, where the linkage locks", finding.problem).groups())
    assert (low, high) == pytest.approx((-100.0, 20.0), abs=1e-4)
    assert (finding.element, finding.line) == ('<joint name="O">', 7)
    assert "mm     while O moves from -100.000 deg to 20.000 deg, where the linkage locks" in str(check(text))


# ------------------------------------------------------------------------------------------------------------------------------ elements


REMARKED = '<link name="{}">{}</link><joint name="x" type="fixed"><parent link="rod"/><child link="{}"/></joint></robot>'
ZERO = '<inertial><mass value="1"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
ELEMENTS = [  # an edit, and the finding; None if there is nothing to find
    (("rod", "rod "), '<link name="rod ">', "warning: the name 'rod ' has spaces around it"),
    (
        ("</robot>", REMARKED.format("Rod", INERTIAL, "Rod")),
        '<link name="Rod">',
        "warning: the name 'Rod' differs from 'rod' on line 4 only in case",
    ),
    (("<!-- P -->", '<dynamics damping="0.5" friction="2"/>'), '<dynamics> of <joint name="P">', "note: .*damping='0.5' and friction='2'"),
    (("<!-- P -->", '<dynamics damping="0" friction="2"/>'), '<dynamics> of <joint name="P">', "note: .*does not read friction='2'"),
    ((INERTIAL, ZERO), '<inertia> of <link name="crank">', "warning: all moments of inertia are 0"),
    (
        (INERTIAL, INERTIAL.replace('"1"', '"0.001"', 1)),
        '<inertia> of <link name="crank">',
        "warning: the radius of gyration is 31.6 m, of a linkage of 0.636 m",
    ),
    (("<!-- P -->", '<dynamics damping="0" friction="0.0"/>'), None, ""),
    ((INERTIAL, INERTIAL.replace('"1"', '"0.05"', 1)), None, ""),
    (("</robot>", REMARKED.format("mark", "", "mark")), None, ""),
    (("</robot>", "<gazebo/><drake:x/></robot>"), None, ""),
]


@pytest.mark.parametrize(("edit", "element", "message"), ELEMENTS)
def test_elements(check, edit, element, message):
    text = GOES.replace('"rod"', '"rod "') if edit == ("rod", "rod ") else changed(edit)
    findings = [each for each in check(text).findings if "redundant" not in each.problem]
    assert [each.element for each in findings] == ([] if element is None else [element])
    for each in findings:
        assert re.match(message, f"{each.severity}: {each.problem}")
        assert each.line is not None


def test_names_of_joints_and_loops_are_compared_too(check):
    text = pinned("spherical", 'link="wheel"', 'link="frame" xyz="0.5 0 0"').replace('name="V"', 'name="w"')
    (finding,) = check(text).warnings
    assert finding.problem == "the name 'w' differs from 'W' on line 12 only in case or spaces"


def test_warnings_are_found_beside_errors(check):
    report = check(changed((AXIS, '<axis xyz="0 -2 0"/>'), ('name="slide"', 'name=" slide"'), ("<!-- P -->", '<dynamics damping="1"/>')))
    assert [finding.severity for finding in report.findings] == ["error", "error", "error", "warning", "note"]
    assert report.facts is None


# ----------------------------------------------------------------------------------------------------------------------- drivers and slides


def test_driver_and_slide_are_given(check, tmp_path):
    text = changed((TRANSMISSION, ""), ('"guide"', '"slide_guide"'), ('name="slide"', 'name="ram"'), ('"slide"/>', '"ram"/>'))
    text = text.replace('link="slide"', 'link="ram"')
    found = check(text)
    assert (found.facts.drivers, found.facts.proposal.drivers) == (("O",), ("O",))
    assert ("no driver is named", '<robot name="goes">') in [(each.problem, each.element) for each in found.warnings]
    report = check(text, driver="O", slide="ram")
    assert (report.errors, report.facts.drivers, report.facts.slide) == ((), ("O",), "ram")


@pytest.mark.exhaustive
def test_load_names_the_command_that_lists_the_others(tmp_path):
    file = tmp_path / "two errors.urdf"
    text = pinned("spherical", 'link="wheel" xyz="0 0 0.1"', 'link="frame" xyz="0.5 0 0.13"')
    file.write_text(text.replace('"slide"', '"ram"'), encoding="utf-8")
    for options, written in (({}, ""), ({"driver": "O", "slide": "ram"}, " --set drivers=O --set slide=ram")):
        with pytest.raises(pp.UrdfError, match="mobility is 0") as caught:
            pp.load(file, **options)
        assert str(caught.value).endswith(f"(1 more: pinpress check '{file}'{written} lists them)")
        assert len(pp.check(file, **options).errors) == 2


def test_a_linkage_without_loops_and_a_report_that_is_frozen(check):
    crank = '<robot name="crank"><link name="frame"/><link name="crank">' + INERTIAL + "</link>"
    joint = f'<joint name="O" type="continuous"><parent link="frame"/><child link="crank"/>{AXIS}</joint>'
    report = check(f"{crank}{joint}{TRANSMISSION}</robot>")
    assert (report.findings, report.facts.mobility, report.facts.closings) == ((), 1, ())
    assert "no errors, no warnings, no notes" in str(report)
    for owner, name in ((report, "file"), (pp.check("crank_slide").findings[0], "problem"), (report.facts, "rank")):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(owner, name, None)
    assert pp.check("crank_slide") == pp.check("crank_slide")


def test_several_drivers(check):
    text = changed((GEAR, ""), (TRANSMISSION, TRANSMISSION + '<transmission><joint name="G"/></transmission>'))
    report = check(text)
    assert report.errors == report.warnings == ()
    assert (report.facts.drivers, report.facts.mobility, report.facts.engine) == (("O", "G"), 2, "space")
    assert "there are 2 drivers" in report.notes[-1].problem
    assert "none        2 drivers move the slide" in str(report)


# ------------------------------------------------------------------------------------------------------------------------------- command


def test_command_prints_the_page_and_warnings_are_no_failure(capsys):
    for press in ("zxn2_3000b", str(texts.file(changed((ROD_END, ROD_END.replace("0.4", "0.401")))))):
        assert main(["check", press]) == 0
        assert capsys.readouterr() == (f"{pp.check(press)}\n", "")
    assert "1 warning" in str(pp.check(press))


@pytest.mark.parametrize(
    "arguments",
    [[], ["none.urdf"], ["zxn2"], ["zxn2_3000b", "--set", "drivers=Q"], ["zxn2_3000b", "--set", "slide=rod"], ["zxn2_3000b", "--fast"]],
)
def test_wrong_usage(arguments, capsys):
    refused(capsys, "check", *arguments)


@pytest.mark.exhaustive
def test_names_that_the_terminal_cannot_show():
    file = texts.file(GOES.replace('"rod"', '"曲柄"').replace(GEAR, ""))
    command = [sys.executable, "-m", "pinpress", "check", str(file), "--set", "drivers=O G"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env={**os.environ, "PYTHONIOENCODING": "ascii"}, check=True)
    assert done.stderr == ""
    assert r"\u66f2\u67c4" in done.stdout
