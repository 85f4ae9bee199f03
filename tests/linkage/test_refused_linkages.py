"""What `load` refuses of paths, drivers, slides and gravity, each with its message; faults in files are in the corpus of malformed ones."""

import math

import numpy as np
import pytest
from support import texts
from support.generators.malformed_linkages import GEAR, GOES, PENDULUM, ROD_END, TRANSMISSION, changed, pinned, with_element
from support.generators.malformed_urdf import INERTIAL
from support.generators.random_linkages import four_bar
from support.oracles import cassie

import pinpress as pp

NO_FILE = f"no such file; name a URDF file or a shipped press .*{', '.join(pp.presses())}"
NO_PATH = "^path is .*: give the path of a file$"
GUIDED = 'joint name="guide" type="prismatic"'
NO_DRIVER = changed((TRANSMISSION, ""))
SLIDES = changed((TRANSMISSION, TRANSMISSION.replace('"O"', '"guide"')))
WELDED = f'<link name="cap">{INERTIAL}</link><joint name="weld" type="fixed"><parent link="rod"/><child link="cap"/></joint>'
GRAVITIES = (9.81, (0, 0), (0, 0, math.nan), (0, 0, math.inf), (0, 0, "down"), "down", None, [[0, 0, -9.81]])

REFUSALS = [
    *((lambda name=name: pp.load(name), NO_FILE) for name in ("none", "")),
    *(
        (lambda name=name: pp.load(name), f"{words}.*; give the path of a URDF file")
        for name, words in (("none.urdf", "No such file"), (".", "directory"), ("a\0b.urdf", "null"))
    ),
    *(
        (lambda call=call, path=path: call(path), NO_PATH)
        for path in (None, 0, b"crank_slide", object(), ["crank_slide"], pp)
        for call in (pp.load, pp.check)
    ),
    (lambda: pp.load('<robot name="mine"><link name="frame"/></robot>'), "not the path of a file; write it to a file"),
    (
        lambda: pp.load(texts.file("units: mm", "press.yaml")),
        r"press.yaml: this is a table of pins, not a URDF; make .* by pp.build\(path\)",
    ),
    (lambda: texts.load(GOES.replace("loop_joint", "lop_joint")), "unknown element <lop_joint>, did you mean 'loop_joint'"),
    (lambda: texts.load(changed(('<link name="slide">', '<link name="slide"><tool xyz="0 0"/>'))), "2 numbers, not 3"),
    # drivers
    (lambda: texts.load(NO_DRIVER), '<robot name="goes">: no driver; .* best drivers=\\[.O.\\] .*load\\(..., drivers=...\\)'),
    (lambda: texts.load(NO_DRIVER, driver=()), "no driver"),
    (
        lambda: texts.load(with_element('<transmission name="b"><joint name="P"/></transmission>')),
        "mobility is 1, but 2 joints drive; drive fewer joints",
    ),
    (lambda: texts.load(GOES, driver=("O", "O")), "driver names a joint twice: O, O"),
    *(
        (lambda name=name: texts.load(with_element(WELDED), driver=name), f"^no moving joint {name!r}{guess}; there are: O, P, G, guide$")
        for name, guess in (("guid", ", did you mean 'guide'[?]"), ("W", ""), ("weld", ""), ("", ""), (3, ""))
    ),
    (
        lambda: texts.load(SLIDES.replace('lower="-1" upper="1"', "")),
        '<joint name="guide">: .* is 0 to 0 m, as programs write it that know no limits',
    ),
    # slides and gravity
    (lambda: pp.load("crank_slide", slide="slid"), "^no link 'slid', did you mean 'slide'.*frame, crank, rod, slide"),
    *(
        (lambda name=name: pp.load("crank_slide", slide=name), f"link '{name}' is not guided by the frame; guided links: slide")
        for name in ("rod", "frame")
    ),
    *((lambda gravity=gravity: pp.load("crank_slide", gravity=gravity), r"^gravity (is not finite|has shape)") for gravity in GRAVITIES),
    # configurations
    *(
        (lambda angle=angle: texts.shipped("crank_slide").configuration(angle), message)
        for angle, message in (
            *((shape, r"angle has shape .*: give one angle or \(n,\) angles \[rad\]") for shape in ([], [[0.1]], np.zeros((2, 2)))),
            *((word, "angle") for word in (math.nan, "0.3", None)),
            (1e8, "turns away"),
        )
    ),
    # mobility
    (
        lambda: texts.load(changed((GEAR, ""), ("</robot>", PENDULUM + "</robot>"))),
        "mobility is 3, .* with joint 'O' held still, joints 'G', 'L' can move; .*a link hangs free",
    ),
    (
        lambda: texts.load(GOES.replace(GOES[GOES.index("<loop_joint") : GOES.index("</loop_joint>") + 13], "")),
        "mobility is 3, .* joints 'P', 'guide' can move; .*a <loop_joint> is missing",
    ),
    (
        lambda: texts.load(pinned("spherical", 'link="rod" xyz="0.2 0 0"', 'link="frame" xyz="0.2 0 -0.1"')),
        "loop 'V' contradicts the others; .*nothing can move|does not close",
    ),
    # another pose
    *((lambda angle=angle: texts.shipped("crank_slide").drawn_at(angle), "finite|angle") for angle in (math.nan, 1e9, "top")),
    (
        lambda: texts.load(changed((GEAR, ""), (TRANSMISSION, TRANSMISSION + '<transmission><joint name="G"/></transmission>'))).drawn_at(
            1.0
        ),
        "one driver that turns",
    ),
]


@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=[message[:40] for _, message in REFUSALS])
def test_refusals(call, message, capfd):
    with pytest.raises(pp.PinpressError, match=message):
        call()
    assert capfd.readouterr().err == ""


def test_errors_know_where_and_what():
    """File, element and line; the names that there are; the gap of a loop; and check lists what load raises."""
    for name in ("none", "none.urdf"):
        with pytest.raises(pp.UrdfError) as refused:
            pp.load(name)
        assert (refused.value.file, refused.value.element, refused.value.line) == (name, None, None)
    table = texts.file("units: mm", "press.yaml")
    assert "this is a table of pins" in str(pp.check(table).errors[0].error)
    with pytest.raises(pp.UnknownNameError) as unknown:
        texts.load(GOES, driver="guid")
    assert (unknown.value.name, unknown.value.known) == ("guid", ("O", "P", "G", "guide"))
    assert (texts.load(NO_DRIVER, driver="O").drivers, texts.load(NO_DRIVER, driver=("O",)).drivers) == (("O",), ("O",))
    with pytest.raises(pp.AssemblyError, match=r"loop 'W' does not close: .* mm apart as drawn, .* mm at best; draw it closed") as opened:
        texts.load(changed((ROD_END, ROD_END.replace("0.4 0 0", "0.4 0.02 0"))))
    assert (opened.value.crank_angle, opened.value.gap) == (0.0, pytest.approx(0.02, rel=1e-6))
    assert opened.value.iterations > 0


def test_a_driver_in_its_dead_point_is_refused():
    """Crank and coupler in one line: the rocker cannot push. Or the crank is pinned to the frame at its tip, beside a pendulum."""
    stretched = four_bar(0.4, 0.1, 0.4, 0.3, math.acos(0.8))
    held = changed((GEAR, ""), ('name="P" type="continuous"', 'name="P" type="fixed"'))
    for text, joint, smallest in ((stretched.urdf("D"), "D", 1e-9), (held, "O", 1e-9)):
        with pytest.raises(pp.SingularityError, match=f"joint '{joint}' does not determine the drawn pose") as refused:
            texts.load(text)
        assert refused.value.crank_angle == 0.0
        assert refused.value.smallest_singular_value < smallest
    assert texts.load(stretched.urdf("O")).driver == "O"


LOCK = math.acos((0.3**2 + 0.4**2 - 0.45**2) / (2 * 0.3 * 0.4))  # coupler and rocker are in one line


@pytest.fixture(scope="module")
def locking():
    """A four-bar, drawn with its crank along the frame, whose crank turns only as far as `LOCK`."""
    text = four_bar(0.4, 0.3, 0.25, 0.2, 0.0).urdf("O")
    with pytest.warns(pp.PinpressWarning, match='<joint name="O">: it turns only from .* where the linkage locks'):
        return texts.load(text)


@pytest.mark.exhaustive
def test_a_linkage_that_locks_says_where(locking, engine):
    for sign in (1, -1):
        assert pp.servo_cycle(locking, speed=1.0, angle=[0.0, sign * 0.99 * LOCK], engine=engine).closure_error.max() < 1e-12
        for move in (
            lambda sign=sign: pp.cycle(locking, sign * 7.0, points=90, engine=engine),
            lambda sign=sign: pp.servo_cycle(locking, [0.0, sign * 1.01 * LOCK], speed=1.0, engine=engine),
            lambda sign=sign: locking.configuration(sign * 1.5),
        ):
            with pytest.raises(pp.SingularityError, match="the linkage locks") as refused:
                move()
            assert refused.value.crank_angle == pytest.approx(sign * LOCK, abs=1e-6)
            assert 0 <= refused.value.smallest_singular_value < 1e-3
            assert f"{math.degrees(sign * LOCK):.4f} deg" in str(refused.value)


def test_a_linkage_without_a_slide_has_no_slide_position(locking):
    states = pp.servo_cycle(locking, speed=1.0, angle=[0.0, 0.5])
    for name in ("slide_position", "slide_velocity", "slide_acceleration"):
        with pytest.raises(pp.PinpressError, match=r"four_bar has no slide: .* load\(..., slide=...\)"):
            getattr(states, name)
    with pytest.raises(pp.PinpressError, match="has no slide"):
        pp.dead_centres(locking)


# Pinocchio's configurations


@pytest.mark.parametrize("name", pp.presses())
def test_the_configuration_of_shipped_presses_is_that_of_the_motion(name):
    press = texts.shipped(name)
    motion = pp.cycle(press, speed=1.0, points=7)
    several, one = press.configuration(motion.crank_angle), press.configuration(motion.crank_angle[3])
    np.testing.assert_allclose(several, motion.q, rtol=0, atol=1e-14)  # sines by another way where joints are closed by roots
    assert (one.shape, several.shape) == ((press.model.nq,), (7, press.model.nq))
    np.testing.assert_array_equal(press.configuration([motion.crank_angle[3]])[0], one)
    np.testing.assert_allclose(one, motion.q[3], rtol=0, atol=1e-14)
    one[:] = 0.0  # the caller's
    assert np.abs(press.configuration(motion.crank_angle[3]) - several[3]).max() < 1e-14


def test_configurations_of_several_drivers_follow_them():
    legs = texts.load(cassie.urdf())
    angle = 0.05 * np.sin(np.arange(24.0)).reshape(2, 12)
    motion = pp.servo_cycle(legs, angle=angle, speed=1.0)
    np.testing.assert_array_equal(legs.configuration(angle), motion.q)
    np.testing.assert_array_equal(legs.configuration(angle[0]), motion.q[0])
    for wrong in (0.1, np.zeros(3), np.zeros((0, 12)), np.zeros((2, 3))):
        with pytest.raises(pp.PinpressError, match=r"angle has shape .*: give \(12,\) or \(n, 12\), the angles of all drivers \[rad\]"):
            legs.configuration(wrong)
