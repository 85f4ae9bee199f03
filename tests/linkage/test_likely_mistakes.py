"""Errors say what is likely to be wrong: an axis left out, links of a loop exchanged, a point in world axes."""

import pytest
from support import texts
from support.generators.malformed_linkages import AXIS, ROD_END, SLIDE_END, changed
from support.generators.malformed_urdf import INERTIAL

import pinpress as pp

EXCHANGED = (ROD_END, ROD_END.replace('"rod"', '"slide"')), (SLIDE_END, SLIDE_END.replace('"slide"', '"rod"'))


def first_error(tmp_path, text: str) -> tuple[str, str]:
    """Problem and remedy of what `load` raises and `check` lists first."""
    file = tmp_path / "press.urdf"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(pp.PinpressError) as caught:
        pp.load(file)
    finding = pp.check(file).errors[0]
    assert finding.remedy in str(caught.value)
    return finding.problem, finding.remedy


def test_an_axis_is_left_out(tmp_path) -> None:
    wanted = "joint 'P' (line 8) has no <axis>, which means x: write its <axis>"
    assert first_error(tmp_path, changed((f"{AXIS}<!-- P -->", "")))[1] == wanted
    problem, remedy = first_error(tmp_path, texts.shipped("zxn2_3000b").text.decode().replace(AXIS, "", 1))
    assert problem.startswith("mobility is 0, but one joint drives")
    assert remedy == "joint 'A' (line 89) has no <axis>, which means x: write its <axis>"


def test_where_all_turn_about_x_none_is_left_out(tmp_path) -> None:
    """A loop that does not close is said to be that."""
    text = '<robot name="x"><link name="frame"/>' + "".join(f'<link name="{name}">{INERTIAL}</link>' for name in "abc")
    for name, parent, child, xyz in (("A", "frame", "a", "0 0 0"), ("B", "a", "b", "0 1 0"), ("C", "frame", "c", "0 5 0")):
        text += f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"/></joint>'
    loop = '<loop_joint name="D" type="spherical"><link1 link="b" xyz="0 1 0"/><link2 link="c" xyz="0 0 1"/></loop_joint>'
    problem, remedy = first_error(tmp_path, f'{text}{loop}<transmission name="d"><joint name="A"/></transmission></robot>')
    assert problem.startswith("does not close")
    assert remedy == "draw it closed, or change the link lengths"


def test_links_of_a_loop_are_exchanged(tmp_path) -> None:
    wanted = "link1 and link2 are exchanged: write each point with the link in whose frame it is"
    assert first_error(tmp_path, changed(*EXCHANGED))[1].startswith(wanted)
    text = texts.shipped("zxn2_3000b").text.decode()
    swapped = text.replace('<link1 link="coupler"', '<link1 link="rocker"').replace('<link2 link="rocker"', '<link2 link="coupler"')
    assert first_error(tmp_path, swapped)[1] == wanted


@pytest.mark.exhaustive
def test_a_point_is_in_world_axes(tmp_path) -> None:
    press = texts.shipped("zxn2_3000b")
    x, _, z = pp.measures.bearing_positions(press, pp.cycle(press, 1.0, points=4))["F"][0].tolist()
    text = press.text.decode().replace('<link1 link="rod" xyz="0.480 0 0"', f'<link1 link="rod" xyz="{x!r} 0 {z!r}"')
    assert first_error(tmp_path, text)[1] == "the point of link 'rod' is in world axes: write it in that link's frame"


def test_a_name_that_is_there_twice_is_one_error(tmp_path) -> None:
    file = tmp_path / "press.urdf"
    file.write_text(changed(('<joint name="P"', '<joint name="O"')), encoding="utf-8")
    (finding,) = pp.check(file).findings
    assert finding.problem == "the name is already that of the <joint> on line 7"
