"""Redundant loops whose numbers are rounded: they load, move, and give torques right to the order of their misfit."""

import math
import re
import warnings

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators import random_linkages, random_scenes
from support.generators.malformed_linkages import GOES, ROUNDED
from support.generators.spatial_linkages import bennett, bricard, four_bar
from support.sampling import rest_exhaustive

import pinpress as pp
from pinpress.engines.structure import configuration
from pinpress.kinematics.check import check

AXIS = '<axis xyz="0 -1 0"/>'
MASS = (
    '<inertial><origin xyz="0.1 0.02 0"/><mass value="0.6"/><inertia ixx="1e-4" iyy="4e-3" izz="4e-3" ixy="0" ixz="0" iyz="0"/></inertial>'
)
FIVE_BAR = f"""<robot name="five_bar"><link name="frame"/>
  {"".join(f'<link name="{link}">{MASS}</link>' for link in ("crank_a", "rod_a", "crank_b", "rod_b"))}
  <joint name="a" type="continuous"><parent link="frame"/><child link="crank_a"/><origin xyz="-0.08 0 0" rpy="0 -2.1 0"/>{AXIS}</joint>
  <joint name="knee_a" type="continuous"><parent link="crank_a"/><child link="rod_a"/>
    <origin xyz="0.21 0 0" rpy="0 1.4280879733229899 0"/>{AXIS}</joint>
  <joint name="b" type="continuous"><parent link="frame"/><child link="crank_b"/><origin xyz="0.09 0 0" rpy="0 -0.8 0"/>{AXIS}</joint>
  <joint name="knee_b" type="continuous"><parent link="crank_b"/><child link="rod_b"/>
    <origin xyz="0.19 0 0" rpy="0 -1.3793002370196639 0"/>{AXIS}</joint>
  LOOPS
  <transmission name="ta"><joint name="a"/></transmission><transmission name="tb"><joint name="b"/></transmission></robot>"""
AT = np.array([[0.25, -0.15], [0.1, 0.2], [-0.3, 0.1]])


def five_bar(loops):
    return texts.load(FIVE_BAR.replace("LOOPS", loops))


def loop(kind, end1, end2, name="tip", inside=""):
    return f'<loop_joint name="{name}" type="{kind}"><link1 link="rod_a" {end1}/><link2 link="rod_b" {end2}/>{inside}</loop_joint>'


def hinge(d):
    """A hinge of five equations, of which three are redundant, its end 2 wrong by d [lengths of 0.3 m, rad]."""
    end = f'xyz="{0.29 + 0.1 * d!r} {0.15 * d!r} {0.06 * d!r}" rpy="{d!r} 0 {-0.7 * d!r}"'
    return five_bar(loop("revolute", 'xyz="0.31 0 0"', end, inside=AXIS))


def torques(press, engine="auto", at=AT):
    motion = pp.servo_cycle(press, angle=at, speed=np.full_like(at, 1.2), acceleration=np.full_like(at, 3.0))
    return pp.inverse_dynamics(press, motion, engine=engine).driving_torque


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize("d", [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10])
def test_torques_of_a_rounded_hinge_are_right_to_its_rounding(d):
    exact = torques(five_bar(loop("spherical", 'xyz="0.31 0 0"', 'xyz="0.29 0 0"')))
    press = hinge(d)
    assert press.mobility == 2
    assert 0.3 * d < press.assembly.misfit / press.size < 3 * d
    for engine in ("space", "pinocchio"):
        np.testing.assert_allclose(torques(press, engine), exact, rtol=0, atol=3 * d * np.abs(exact).max())


@pytest.mark.parametrize("d", [1e-3, 1e-6])
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_positions_are_smooth_along_a_motion(d):
    """Eighth differences of positions in steps of 2 mrad: of a smooth motion they are rounding."""
    press, s = hinge(d), np.arange(60)[:, None]
    motion = pp.servo_cycle(press, angle=0.002 * s * [1.0, -0.7], speed=np.zeros((60, 2)), acceleration=np.zeros((60, 2)))
    assert np.abs(np.diff(motion.joint_position, 8, axis=0)).max() < 1e-12  # a jump of a share of the misfit would be 256 times as large
    gaps = press.engine().gaps(motion.joint_position.T)
    assert 0.3 * press.assembly.misfit < gaps.max() < 3 * press.assembly.misfit


def test_two_exact_points_on_one_hinge():
    """Six equations of rank five, of which two count in the plane: no misfit, and the torques of one point."""
    one = loop("spherical", 'xyz="0.31 0 0"', 'xyz="0.29 0 0"')
    press = five_bar(one + loop("spherical", 'xyz="0.31 0.04 0"', 'xyz="0.29 0.04 0"', "second"))
    assert press.assembly.misfit == 0.0
    assert press.mobility == 2
    np.testing.assert_allclose(torques(press), torques(five_bar(one)), rtol=1e-13)


def test_a_hinge_that_is_really_wrong_is_refused_with_its_gap():
    with pytest.raises(pp.AssemblyError, match=r"loop 'tip' does not close: 1.9 mm and 0.699 deg apart as drawn"):
        hinge(1e-2)


def test_loops_that_contradict_each_other_are_named_with_their_gaps():
    """A crank pin that leans by 0.01 rad would have to slide out of the plane by up to sin(0.01) of the rod as it turns."""
    with pytest.raises(
        pp.UrdfError, match=r"held by loop 'W'; it misses moving by little: 0\.1 rad further, loop 'W' stays open by 0\.33 mm at best;"
    ):
        texts.load(GOES.replace('xyz="0.1 0 0" rpy="0 ', 'xyz="0.1 0 0" rpy="0.01 '))


def rounded(text, digits):
    """The text with all numbers rounded; axes keep their length."""

    def axis(found):
        direction = np.round(np.array(found[1].split(), dtype=float), digits)
        return f'<axis xyz="{" ".join(map(repr, (direction / np.linalg.norm(direction)).tolist()))}"/>'

    text = re.sub(r"-?\d+\.\d+(e-?\d+)?", lambda found: repr(round(float(found[0]), digits)), text)
    return re.sub(r'<axis xyz="([^"]*)"/>', axis, text)


@pytest.mark.one_in(8)
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize("digits", [4, 5, 6, 8])
@pytest.mark.parametrize(
    "exact", [bennett(), bricard(), four_bar("revolute"), four_bar("fixed")], ids=["bennett", "bricard", "revolute", "fixed"]
)
def test_rings_in_space_with_rounded_numbers(exact, digits):
    angle = np.linspace(0.0, 1.0, 9)
    found = []
    for text in (exact, rounded(exact, digits)):
        press = texts.load(text)
        reactions = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=angle, speed=2.0, acceleration=0.0))
        found.append(
            (
                reactions.driving_torque,
                *(np.array([by[name] for name in press.bearings]) for by in (reactions.bearing_force, reactions.bearing_moment)),
            )
        )
    assert press.mobility == 1
    assert 0.01 * 10.0**-digits < press.assembly.misfit < 30 * 10.0**-digits
    for of_exact, of_rounded in zip(*found, strict=True):
        np.testing.assert_allclose(of_rounded, of_exact, rtol=0, atol=100 * 10.0**-digits * np.abs(of_exact).max())


@pytest.mark.parametrize(("text", "missed"), ROUNDED, ids=lambda value: f"{value:g}" if isinstance(value, float) else "")
def test_a_crank_slide_with_rounded_axes_loads_with_a_warning(text, missed):
    file = texts.file(text)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        press = pp.load(file)
    messages = [str(warning.message) for warning in caught]
    said = [
        message for message in messages if "redundant equations contradict each other by up to " in message and "of loop 'W'" in message
    ]
    assert len(said) == (press.assembly.misfit > 1e-9 * press.size) == (missed > 1e-9)
    assert 0.0 < press.assembly.misfit <= missed
    exact = texts.load(GOES)
    of_exact, of_rounded = (pp.inverse_dynamics(each, pp.cycle(each, speed=5.0, points=24)).driving_torque for each in (exact, press))
    np.testing.assert_allclose(of_rounded, of_exact, rtol=0, atol=max(3 * missed, 1e-12) * np.abs(of_exact).max())


def test_check_says_the_misfit():
    (finding,) = (each for each in check(texts.file(ROUNDED[0][0])).findings if "contradict each other" in each.problem)
    assert finding.severity == "warning"
    assert finding.remedy.startswith("expect errors of up to 0.0003 of the largest force, torque and travel; axes are up")


ROUNDED_RINGS = [
    *[(GOES, text, missed) for text, missed in ROUNDED[:5]],
    *[(exact, rounded(exact, 5), 1e-4) for exact in (bennett(), four_bar("fixed"))],
]


@pytest.mark.one_in(7)
@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize(("exact", "text", "missed"), ROUNDED_RINGS)
def test_forward_dynamics_and_its_derivatives(exact, text, missed):
    """Accelerations under the driving torque are those of the motion; their derivatives are those of the exact linkage."""
    press, turned = texts.load(text), np.linspace(0.0, 1.0, 5)
    motion = pp.servo_cycle(press, angle=turned, speed=3.0, acceleration=20.0)
    torque = pp.inverse_dynamics(press, motion).driving_torque
    dynamics, driver = press.forward_dynamics(np.zeros(press.model.nv)), press.driver_indices[0]
    for x, v, effort in zip(motion.joint_position, motion.v, torque, strict=True):
        position, rate, gap = dynamics.project(x, v)
        assert np.abs(position - x).max() < 3 * missed
        assert gap < 3 * press.assembly.misfit
        found = dynamics.acceleration(position, rate, effort * (np.arange(len(x)) == driver))
        assert found[driver] == pytest.approx(20.0, rel=3 * missed)
    by_position, of_exact = (
        pp.derivatives.acceleration_derivatives(each, pp.servo_cycle(each, angle=turned, speed=3.0, acceleration=20.0)).by_position
        for each in (press, texts.load(exact))
    )
    np.testing.assert_allclose(by_position, of_exact, rtol=0, atol=100 * missed * np.abs(of_exact).max())


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
def test_a_run_of_all_joints():
    """A run over time with the loops closed by projection, against that of the crank alone."""
    press = texts.load(ROUNDED[0][0])
    runs = (
        pp.simulate(press, duration=0.2, speed=5.0, flywheel=pp.drives.Flywheel(2.0), method=name) for name in ("reduced", "constraint")
    )
    reduced, constraint = (run.crank_angle[-1] for run in runs)
    assert constraint == pytest.approx(reduced, abs=1e-6)


def held_twice(press):
    """The text of a planar linkage, each loop held at two points of its pin: six equations, two of which count."""
    data = press.model.createData()
    pin.framesForwardKinematics(press.model, data, configuration(press.slots, press.closed))
    away, second = 0.1 * press.size * np.array(press.planarity.normal), ""
    for each in press.document.description.loops:
        ends = ""
        for k, end in enumerate((each.link1, each.link2), 1):
            place = data.oMf[press.model.getFrameId(end.link, pin.BODY)]
            point = place.actInv(place.act(np.array(end.xyz)) + away)
            ends += f'<link{k} link="{end.link}" xyz="{" ".join(map(repr, point.tolist()))}"/>'
        second += f'<loop_joint name="{each.name}_second" type="spherical">{ends}</loop_joint>'
    return press.text.decode().replace("</robot>", f"{second}</robot>")


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize("seed", rest_exhaustive([11, 18, *range(20, 40)], 11))
def test_random_linkages_with_each_pin_held_twice(seed):
    drawing = random_linkages.drawn(random_scenes.linkage_spec(np.random.default_rng(seed)))
    if drawing is None:
        pytest.skip("a group does not close")
    planar = texts.load(drawing.urdf("crank"))
    turned, exact = 0.5 * np.linspace(0.0, min(0.4, planar.branch.angles[-1]), 4), None  # half as far as it locks
    twice = held_twice(planar)
    for text, error in ((planar.text.decode(), 0.0), (twice, 1e-12), (rounded(twice, 5), 1e-2), (rounded(twice, 8), 1e-5)):
        press = texts.load(text)
        torque = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=turned, speed=2.0, acceleration=5.0)).driving_torque
        exact = torque if exact is None else exact
        assert press.mobility == 1
        np.testing.assert_allclose(torque, exact, rtol=0, atol=error * np.abs(exact).max())


def three_cranks(wrong):
    """Two loops a hundredth of the robot's length in size, held by all six equations, drawn closed; one crank is too long by this share."""
    pins = {"a": (0.0, 0.0, 0.007), "b": (0.009, 0.0, 0.007 * (1.0 + wrong)), "c": (0.004, 0.003, 0.007)}
    lines = [
        '<robot name="head"><link name="frame"/>',
        *(f'<link name="{link}">{MASS}</link>' for link in ("arm", "bar", "end_b", "end_c")),
    ]
    lines.append(f'<joint name="reach" type="continuous"><parent link="frame"/><child link="arm"/><origin xyz="0 0 0.6"/>{AXIS}</joint>')
    for name, (x, z, length) in pins.items():
        lines.append(f'<link name="crank_{name}">{MASS}</link><joint name="{name}" type="continuous"><parent link="arm"/>')
        lines.append(f'<child link="crank_{name}"/><origin xyz="{0.3 + x} 0 {z}" rpy="0 -1 0"/>{AXIS}</joint>')
        more, carrier, end = length - pins["a"][2], *(("crank_a", "bar") if name == "a" else ("bar", f"end_{name}"))
        at, turned = ((length, 0.0), 1.0) if name == "a" else ((x + more * math.cos(1.0), z + more * math.sin(1.0)), -1.0)
        lines.append(f'<joint name="knee_{name}" type="continuous"><parent link="{carrier}"/><child link="{end}"/>')
        lines.append(f'<origin xyz="{at[0]!r} 0 {at[1]!r}" rpy="0 {turned} 0"/>{AXIS}</joint>')
        if name != "a":
            lines.append(f'<loop_joint name="weld_{name}" type="fixed"><link1 link="crank_{name}" xyz="{length!r} 0 0"/>')
            lines.append(f'<link2 link="end_{name}"/></loop_joint>')
    return "\n".join(
        [*lines, *(f'<transmission name="{name}"><joint name="{name}"/></transmission>' for name in ("reach", "a")), "</robot>"]
    )


@pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
@pytest.mark.parametrize("wrong", [1e-5, 1e-7])
def test_small_loops_of_a_large_robot_that_close_as_drawn(wrong):
    """Their singular values that count are below the largest misfit, too; and what is wrong with them shows in other poses only."""
    exact, press = (texts.load(three_cranks(each)) for each in (0.0, wrong))
    assert (press.mobility, press.motors) == (2, ("reach", "a"))
    assert 0.003 * wrong < press.assembly.misfit / 0.007 < 3 * wrong
    of_exact, of_rounded = torques(exact), torques(press)
    np.testing.assert_allclose(of_rounded, of_exact, rtol=0, atol=10 * wrong * np.abs(of_exact).max())
