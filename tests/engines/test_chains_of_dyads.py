"""Chains of dyads, which the planar engine closes by one root each: judged by Newton's method, by Pinocchio, and by what they leave out."""

import numpy as np
import pytest
from hypothesis import assume, given
from support import texts
from support.exploring import examples
from support.generators.random_linkages import Drawing, apart, drawn, four_bar, linkages, random_friction, servo
from support.generators.redundant_linkages import mimicking

import pinpress as pp
from pinpress.engines.engine import ClosedStates
from pinpress.engines.planar.engine import PlanarEngine
from pinpress.engines.wrenches import AppliedConditions
from pinpress.kinematics import cycle as cycles


def find_chain(press):
    return cycles._constants(press).chain


def crank(drawing, length=0.2, at=0j):
    drawing.joint("crank", "frame", "crank_link", at, bounded=False)
    drawing.body("crank_link", 3.0, at + 0.3 * length)
    return at + length


def rod_to_slide(direction=1.0, sense=1, driven=1):
    """A crank, a rod and a slide whose line passes beside the shaft; the slide is ahead of the rod or behind it."""
    drawing = Drawing("rod_to_slide")
    pin = crank(drawing)
    end = pin + 0.9 * np.exp(0.3j) * direction
    drawing.joint("rod", "crank_link", "rod_link", pin, sense=sense)
    drawing.joint("guide", "frame", "slide", end + 0.1j, along=driven * direction)
    drawing.loop("pin", "rod_link", "slide", end)
    drawing.body("rod_link", 2.0, 0.5 * (pin + end) + 0.1j)
    drawing.body("slide", 9.0, end + 0.2j)
    return drawing


def slide_on_a_rocker():
    """A four-bar whose rocker carries a guide, whose slide a rod from the crank moves: the guide turns, and is known."""
    drawing = four_bar(1.0, 0.2, 0.9, 0.5, 0.3, name="slide_on_a_rocker")
    start, along = 1.1 + 0.3j, np.exp(0.4j)
    drawing.joint("guide", "rocker", "slide", start, along=along)
    end = start + 0.2 * along
    drawing.joint("rod", "crank", "rod_link", 0.2 * np.exp(0.3j))
    drawing.loop("pin", "rod_link", "slide", end)
    drawing.body("slide", 2.0, end + 0.05j)
    drawing.body("rod_link", 1.0, 0.5 * end)
    drawing.joint("tail", "slide", "tail_link", end + 0.1j)  # what hangs on the slide has a moment about its guide
    drawing.joint("far", "frame", "far_link", end + 0.9)
    drawing.loop("last", "tail_link", "far_link", end + 0.5 + 0.4j)
    drawing.body("tail_link", 1.0, end + 0.3)
    drawing.body("far_link", 1.0, end + 0.8)
    return drawing


def swinging_guide(behind=False):
    """A crank's pin on a slide in a guide that swings beside its pivot: a shaper. A second slide on this guide moves a table."""
    drawing = Drawing("swinging")
    pin, pivot = crank(drawing), -0.7j
    along = (pin - pivot - 0.1) * (-1 if behind else 1)
    drawing.joint("swing", "frame", "guide_link", pivot)
    drawing.joint("way", "guide_link", "block", pin, along=along)
    drawing.loop("pin", "crank_link", "block", pin)
    drawing.joint("table_guide", "frame", "table", 1.0 + 0.2j, along=1.0)
    drawing.joint("rod", "guide_link", "rod_link", 0.3j)
    drawing.loop("end", "rod_link", "table", 1.0 + 0.2j)
    for link, mass, centre in (("guide_link", 4.0, 0.1j), ("block", 1.0, pin + 0.02), ("table", 9.0, 1.1), ("rod_link", 2.0, 0.4)):
        drawing.body(link, mass, centre)
    return drawing


def two_guides():
    """A crank's pin in a cross slide: both guides are known, and keep their directions."""
    drawing = Drawing("two_guides")
    pin = crank(drawing, at=0.1j)
    drawing.joint("yoke_guide", "frame", "yoke", 0.5j, along=np.exp(0.1j))
    drawing.joint("block_guide", "yoke", "block", pin, along=np.exp(1.4j))
    drawing.loop("pin", "block", "crank_link", pin)
    drawing.body("yoke", 4.0, 0.2j)
    drawing.body("block", 1.0, pin + 0.03)
    return drawing


def sliding_driver():
    """A cylinder's rod moves a rocker."""
    drawing = Drawing("sliding_driver")
    drawing.joint("crank", "frame", "rod", 0j, along=1.0)
    drawing.joint("link", "rod", "link_body", 0.5 + 0j)
    drawing.joint("rocker", "frame", "rocker_link", 0.6 - 0.8j)
    drawing.loop("pin", "link_body", "rocker_link", 1.1 + 0.1j)
    for link, centre in (("rod", 0.2j), ("link_body", 0.7 + 0j), ("rocker_link", 0.8 - 0.3j)):
        drawing.body(link, 2.0, centre)
    return drawing


def mirrored_cranks():
    """Two cranks geared to each other, each with a rod to the same slide, of which the second is redundant; and a third shaft, geared to
    the second one so that it turns twice as fast and begins a little ahead, whose crank moves a rocker."""
    drawing = Drawing("mirrored_cranks")
    slide = 1.0j
    for side, sign, sense in (("left", -1.0, 1), ("right", 1.0, -1)):
        at = 0.3 * sign
        pin, end = at + 0.1 * sign * np.exp(0.4j * sign), slide + 0.2 * sign
        drawing.joint(f"shaft_{side}", "frame", f"crank_{side}", complex(at), sense=sense, bounded=False)
        drawing.joint(f"rod_{side}", f"crank_{side}", f"rod_{side}", pin, sense=-sense)
        drawing.body(f"crank_{side}", 3.0 - sign, pin - 0.05)
        drawing.body(f"rod_{side}", 2.0, 0.5 * (pin + end) + 0.1j)
    drawing.joint("guide", "frame", "slide", slide, along=1j)
    for sign, side in ((-1.0, "left"), (1.0, "right")):
        drawing.loop(f"pin_{side}", f"rod_{side}", "slide", slide + 0.2 * sign)
    drawing.body("slide", 9.0, slide + 0.05)
    pivot, fast = 1.9 - 0.2j, 1.2 + 0.1j
    drawing.joint("fast_shaft", "frame", "fast_crank", 1.1 + 0j, bounded=False)
    drawing.joint("coupler", "fast_crank", "coupler", fast)
    drawing.joint("rocker", "frame", "rocker", pivot)
    drawing.loop("end", "coupler", "rocker", 1.8 + 0.5j)
    for link, centre in (("fast_crank", fast), ("coupler", 1.5 + 0.3j), ("rocker", pivot + 0.1j)):
        drawing.body(link, 1.0, centre)
    text = drawing.urdf("shaft_left")
    for joint, gear in (("shaft_right", 'joint="shaft_left"'), ("fast_shaft", 'joint="shaft_right" multiplier="-2" offset="0.1"')):
        head, tail = text.split(f'<joint name="{joint}"')
        text = f'{head}<joint name="{joint}"' + tail.replace("</joint>", f"<mimic {gear}/></joint>", 1)
    return text


KINDS = {
    "links": (four_bar(1.0, 0.2, 0.9, 0.5, 0.3), "O", ["TwoLinks"]),
    "links, other side": (four_bar(1.0, 0.2, 0.9, 0.5, 0.3, side=-1), "O", ["TwoLinks"]),
    "rod to slide": (rod_to_slide(), "crank", ["GuidedLink"]),
    "rod to slide, behind": (rod_to_slide(np.exp(2.5j), sense=-1, driven=-1), "crank", ["GuidedLink"]),
    "slide on a rocker": (slide_on_a_rocker(), "O", ["TwoLinks", "GuidedLink", "TwoLinks"]),
    "swinging guide": (swinging_guide(), "crank", ["SwingingGuide", "GuidedLink"]),
    "swinging guide, behind": (swinging_guide(behind=True), "crank", ["SwingingGuide", "GuidedLink"]),
    "two guides": (two_guides(), "crank", ["TwoGuides"]),
    "sliding driver": (sliding_driver(), "crank", ["TwoLinks"]),
}


def gently(press):
    """Angles, speeds and accelerations of a motion clear of locks, without a relation between them."""
    chain = find_chain(press)
    low, high = (0.0, 6.0) if press.branch.period else (0.5 * chain.low, 0.5 * chain.high)
    share = np.linspace(0.0, 1.0, 25)
    return {"angle": low + share * (high - low), "speed": 3.0 - share, "acceleration": 2.0 + 5.0 * share}


def judged(press, motion, loads=()):
    """A motion and its forces against Newton's method and the general equations of the planar engine."""
    chain = find_chain(press)
    assert press.branch.period is not None or chain.low <= motion.crank_angle.min() <= motion.crank_angle.max() <= chain.high
    engine, angle = press.engine("plane"), motion.crank_angle
    near = np.asarray(motion.joint_position.T) + 1e-7
    newton = engine.close(angle, near)
    assert newton.iterations > 0
    weight = np.array([1.0 if axis.turns else 1.0 / press.size for axis in press.axes])[:, None]
    v, a = newton.first * motion.crank_speed, newton.second * motion.crank_speed**2 + newton.first * motion.crank_acceleration
    for found, expected in ((motion.joint_position.T, newton.position), (motion.v.T, v), (motion.a.T, a)):
        assert np.abs(weight * (found - expected)).max() <= 1e-12 * max(1.0, np.abs(weight * expected).max())
    found = pp.inverse_dynamics(press, motion, loads)
    conditions = AppliedConditions(found._conditions.loads, None, None)
    general = engine.inverse_dynamics(ClosedStates(newton.position, v, a), conditions)
    assert np.abs(found._wrenches.force - general.force).max() <= 1e-12 * np.abs(general.force).max()
    scale = max(np.abs(general.moment).max(), np.abs(general.force).max() * press.size)
    assert np.abs(found._wrenches.moment - general.moment).max() <= 1e-12 * scale
    assert np.abs(found.driving_torque - general.torque[0]).max() <= 1e-12 * scale
    some = press.bearings[1::2]
    partly = pp.inverse_dynamics(press, motion, loads, bearings=some)
    for name in some:
        assert np.abs(partly.bearing_force[name] - found.bearing_force[name]).max() <= 1e-13 * np.abs(general.force).max()
        assert np.abs(partly.bearing_moment[name] - found.bearing_moment[name]).max() <= 1e-13 * scale
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_dyad(kind):
    drawing, driver, dyads = KINDS[kind]
    press = texts.load(drawing.urdf(driver))
    assert [type(equation.dyad).__name__ for equation in find_chain(press).equations] == dyads
    loads = [pp.loads.PointForce(link, (30.0, 0.0, -50.0), (0.1, 0.0, 0.2)) for link in press.links if link != "frame"]
    motion = pp.servo_cycle(press, **gently(press))
    result = judged(press, motion, loads)
    assert max(apart(result, pp.inverse_dynamics(press, motion, loads, engine="pinocchio"))) <= 1e-11
    assert np.abs(result.power_residual).max() <= 1e-12


@pytest.mark.parametrize("name", ["drawn", "eccentric_blocks", "jf75g_125_symmetric", "jf75g_125_two_point", "pirica_double_knuckle"])
@pytest.mark.filterwarnings("ignore:.*apart as drawn")
def test_gears_and_levers(name):
    """A second rod shares the force on its slide, and gears the torque, as Pinocchio's engine and the general equations say."""
    press = texts.load(mirrored_cranks()) if name == "drawn" else pp.load(name)
    chain = find_chain(press)
    assert any(type(equation.dyad).__name__ == "Lever" for equation in chain.equations)
    assert len(chain.gears) == len(press.couplings)
    loads = [pp.loads.PointForce(link, (30.0, 0.0, -50.0), (0.1, 0.0, 0.2)) for link in press.links if link != press.root]
    motion = pp.servo_cycle(press, **gently(press))
    result, other = judged(press, motion, loads), pp.inverse_dynamics(press, motion, loads, engine="pinocchio")
    alone = pp.inverse_dynamics(press, motion, loads, bearings=())
    assert max(*apart(result, other), apart(alone, other)[1]) <= 1e-11
    peak = max(np.abs(force).max() for force in other.bearing_force.values())
    assert all(np.abs(torque).max() > 1e-6 * peak * press.size for torque in other.coupling_torque.values())
    assert np.abs(result.power_residual).max() <= 1e-12


@pytest.mark.filterwarnings("ignore:.*apart as drawn")
def test_gears_that_are_left_to_newtons_method():
    """A shaft on the crank, and a rack."""
    text = mirrored_cranks()
    assert find_chain(texts.load(text)) is not None
    rack = '<joint name="rack" type="prismatic"><parent link="frame"/><child link="rack"/><origin xyz="0 0 2"/><axis xyz="1 0 0"/>'
    rack += '<limit lower="-9" upper="9" effort="1" velocity="1"/><mimic joint="shaft_left" multiplier="0.1"/></joint>'
    mass = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    press = texts.load(text.replace("</robot>", f'<link name="rack">{mass}</link>{rack}</robot>'))
    assert find_chain(press) is None
    assert isinstance(press.engine(), PlanarEngine)
    planet = '<joint name="planet" type="continuous"><parent link="crank_left"/><child link="planet"/><axis xyz="0 -1 0"/>'
    planet += '<mimic joint="shaft_left" multiplier="3"/></joint>'
    assert find_chain(texts.load(text.replace("</robot>", f'<link name="planet">{mass}</link>{planet}</robot>'))) is None


@given(linkages())
@examples(30)
def test_random_chains(spec):
    drawing = drawn(spec)
    assume(drawing is not None)
    try:
        press = texts.load(drawing.urdf("crank"))
        chain = find_chain(press)
    except pp.PinpressError:
        assume(False)  # it locks where it is drawn
    plane = press.engine().plane
    assert (chain is None) == any(block.kind not in ("dyad", "lever") for block in plane.blocks)
    if chain is not None:
        judged(press, pp.servo_cycle(press, **servo(press, np.random.default_rng(spec.seed))))


def test_shipped_presses_are_chains():
    assert all(find_chain(pp.load(name)) is not None for name in pp.presses())


def driven_on_a_swing(slides=False):
    """A swing on the frame carries a crank and a rocker, which a rod joins: they are closed on the swing, whose angle a strut from the
    rocker to the frame determines only then. Or the driver is the rod of a cylinder on the swing, which a link joins to the rocker."""
    drawing = Drawing("driven_on_a_swing")
    drawing.joint("swing", "frame", "swing_link", 0j)
    drawing.body("swing_link", 5.0, 0.4 + 0.1j)
    at, pin, pivot = 0.4 + 0j, 0.5 + 0.05j, 1.0 + 0.1j
    corner = 0.9 + 0.5j
    drawing.joint("rocker", "swing_link", "rocker_link", pivot)
    drawing.body("rocker_link", 2.0, corner)
    if slides:
        drawing.joint("drive", "swing_link", "driven", at, along=1.0 + 0.2j)
    else:
        drawing.joint("drive", "swing_link", "driven", at)
    drawing.body("driven", 1.0, at + 0.02j)
    drawing.joint("rod", "driven", "rod_link", pin)
    drawing.body("rod_link", 1.0, 0.6 + 0.3j)
    drawing.loop("pin", "rod_link", "rocker_link", corner)
    drawing.joint("strut", "frame", "strut_link", 0.3 + 1.1j)
    drawing.body("strut_link", 1.0, 0.6 + 1.0j)
    drawing.loop("tie", "strut_link", "rocker_link", corner + 0.2j)
    drawing.joint("way", "swing_link", "block", 0.2 + 0.3j, along=1j + 0.3)  # a follower on the swing
    drawing.joint("lever", "rocker_link", "lever_link", pivot + 0.1j)
    drawing.loop("last", "lever_link", "block", 0.2 + 0.3j)
    drawing.body("block", 1.0, 0.25 + 0.3j)
    drawing.body("lever_link", 1.0, 0.6 + 0.2j)
    return drawing


@pytest.mark.parametrize("slides", [False, True])
def test_forces_of_what_is_closed_on_a_link_that_moves(slides):
    """The blocks are closed one after the other, but their absolute angles follow only together; Pinocchio judges."""
    press = texts.load(driven_on_a_swing(slides).urdf("drive"))
    statics = press.engine("plane")._statics
    assert len(statics.blocks) < len(statics.plane.blocks)
    motion = pp.servo_cycle(press, angle=[-0.02, 0.0, 0.03], speed=[3.0, 2.0, -1.0], acceleration=[5.0, -4.0, 20.0])
    loads = [pp.loads.PointForce("block", (30.0, 0.0, -80.0)), pp.loads.PointForce("rod_link", (-10.0, 5.0, 60.0), (0.1, 0.0, 0.05))]
    scenes = {}, {"loads": loads}, {"loads": loads, "friction": random_friction(press, most=0.05)}
    for scene in scenes:
        found, other = (pp.inverse_dynamics(press, motion, engine=name, **scene) for name in ("plane", "pinocchio"))
        assert max(apart(found, other)) <= 1e-10


def test_a_slide_whose_forces_meet_on_its_guide_needs_no_moment():
    """Pin and centre of mass stand where its joint does, and nothing has an arm; a load beside it has one."""
    drawing = Drawing("no_arms")
    pin = crank(drawing)
    end = pin + 0.9 * np.exp(-0.3j)
    drawing.joint("rod", "crank_link", "rod_link", pin)
    drawing.joint("guide", "frame", "slide", end, along=1.0)
    drawing.loop("pin", "rod_link", "slide", end)
    drawing.body("rod_link", 2.0, 0.5 * (pin + end))
    drawing.body("slide", 9.0, end)
    press = texts.load(drawing.urdf("crank"))
    motion = pp.servo_cycle(press, **gently(press))
    assert not judged(press, motion).bearing_moment["guide"].any()
    load = pp.loads.PointForce("slide", (0.0, 0.0, -50.0), (0.1, 0.0, 0.0))
    np.testing.assert_allclose(judged(press, motion, [load]).bearing_moment["guide"], np.tile((0.0, -5.0, 0.0), (25, 1)), atol=1e-12)


def carried_driver(slides, follower, drives_more):
    """A driver on a link that swings, and what is geared to it there: a pinion, a rack, or nothing; the follower may drive a dyad more."""
    drawing, along, pin = Drawing("carried_driver"), np.exp(0.3j), 0.25j
    drawing.joint("swing", "frame", "carrier", 0j)
    drawing.joint("driver", "carrier", "driven", 0.3 * along, along=along if slides else None)
    drawing.joint("rocker", "frame", "rocker_link", 0.9 - 0.6j)
    drawing.loop("end", "driven", "rocker_link", 0.8 * along + 0.1j)
    for link, centre in (("carrier", 0.1j), ("driven", 0.5 * along), ("rocker_link", 0.8 - 0.2j)):
        drawing.body(link, 2.0, centre)
    if follower == "none":
        return drawing.urdf("driver")
    drawing.joint("follower", "carrier", "wheel", pin, along=along * np.exp(0.1j) if follower == "rack" else None)
    drawing.body("wheel", 1.0, pin + 0.1)
    if drives_more:
        drawing.joint("arm", "frame", "arm_link", -0.3 + 0.7j)
        drawing.joint("rod", "wheel", "rod_link", pin + 0.12 + 0.05j)
        drawing.loop("far", "rod_link", "arm_link", 0.3 + 0.6j)
        drawing.body("arm_link", 1.0, -0.1 + 0.6j)
        drawing.body("rod_link", 0.5, 0.3 + 0.6j)
    ratio = {(True, "pinion"): 5.0, (True, "rack"): 0.5, (False, "pinion"): -0.7, (False, "rack"): 0.1}[slides, follower]
    return mimicking(drawing.urdf("driver"), "follower", "driver", ratio)


@pytest.mark.one_in(12)
@pytest.mark.parametrize("drives_more", [False, True])
@pytest.mark.parametrize("follower", ["none", "pinion", "rack"])
@pytest.mark.parametrize("slides", [True, False])
def test_gears_of_a_driver_that_rides_on_a_link(slides, follower, drives_more):
    """The travel of a cylinder on a swinging carrier is no angle, so that its gears do not heed how far the carrier swings."""
    press = texts.load(carried_driver(slides, follower, drives_more))
    states = {"angle": np.linspace(-0.01, 0.015, 5), "speed": 0.3, "acceleration": 0.2}
    ours, other = (pp.servo_cycle(press, engine=engine, **states) for engine in ("plane", "space"))
    for mine, theirs in ((ours.joint_position, other.joint_position), (ours.v, other.v), (ours.a, other.a)):
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-12 * max(1.0, np.abs(theirs).max()))
    found, expected = (pp.inverse_dynamics(press, motion, engine=engine) for motion, engine in ((ours, "plane"), (other, "space")))
    assert max(apart(found, expected)) <= 1e-11
