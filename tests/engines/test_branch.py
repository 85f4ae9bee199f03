"""Every configuration belongs to the assembly that is drawn, however a motion is sampled, and where a linkage locks is said exactly."""

import math
import re

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators.random_linkages import Drawing, Group, Spec, drawn, four_bar
from support.generators.redundant_linkages import five_bar
from support.generators.spatial_linkages import bennett

import pinpress as pp
from pinpress.engines.branch import predict
from pinpress.engines.structure import configuration

ENGINES = ("plane", "space", "pinocchio")
STROKE = (-0.9596, -0.6582)  # the ZXN2-3000(B)'s slide, rounded outwards (Kong 2025) [m]
# Joint coordinates of its other assembly, against the drawn one: rod folded back on the rocker's arm, F on D, slide at z = 0.
FOLDED = {"E": -0.75 * np.pi + np.pi + 2.4872085419244342, "slide_guide": 0.9579409746502484}


@pytest.fixture(scope="module")
def zxn2():
    return texts.shipped("zxn2_3000b")


def folded(press, angle):
    """Joint coordinates (nv, n) of the false assembly at crank angles (n,)."""
    x = predict(press.branch, angle)
    for name, value in FOLDED.items():
        x[press.joints.index(name)] = value
    return x


def gap(press, q):
    """Largest distance (n,) between the sides of the loops, from Pinocchio's forward kinematics alone."""
    data = press.model.createData()
    gaps = []
    for each in q:
        pin.forwardKinematics(press.model, data, each)
        sides = [(data.oMi[k.joint1].act(k.point1), data.oMi[k.joint2].act(k.point2)) for k in press.loops]
        gaps.append(max(np.linalg.norm(one - other) for one, other in sides))
    return np.array(gaps)


def test_the_false_assembly_exists(zxn2, engine):
    """What the tests below rule out can happen: Newton's method, started at the false assembly, finds it closed as well as the true one."""
    angle = np.linspace(0.0, 6.0, 7)
    closure = zxn2.engine(engine).close(angle, folded(zxn2, angle))
    slide = closure.position[zxn2.joints.index("slide_guide")] + zxn2.slide_guide[1]
    assert np.abs(slide).max() < 1e-13
    assert closure.gap.max() < 1e-14
    assert gap(zxn2, configuration(zxn2.slots, closure.position).T).max() < 1e-14
    assert np.isfinite(closure.first).all()


@pytest.mark.parametrize(
    ("engine", "points"), [*(("plane", n) for n in (8, 9, 37, 360, 100_000)), *(("pinocchio", n) for n in (8, 9, 37, 360))]
)
@pytest.mark.parametrize("speed", [7.0, -7.0])
def test_a_turn_stays_on_the_drawn_assembly(zxn2, points, speed, engine):
    """Few points or many, either way round. (100 000 on the planar engine: the other would take a minute.)"""
    motion = pp.cycle(zxn2, speed, points=points, engine=engine)
    assert STROKE[0] < motion.slide_position.min()
    assert motion.slide_position.max() < STROKE[1]
    assert motion.closure_error.max() < 5e-14  # the last bit of the angle of the second crank, 140 rad
    some = slice(None, None, max(1, points // 50))
    assert gap(zxn2, motion.q[some]).max() < 1e-14
    assert np.ptp(motion.slide_position) > 0.25


def test_servo_angles_from_anywhere(zxn2, engine):
    """Random angles over thousands of turns, unsorted, each alone and all together: the same as within the first turn.

    To the rounding of the angle: 1e4 rad has a spacing of 2e-12, and the slide moves by at most 0.2 m/rad.
    """
    angle = np.random.default_rng(3).uniform(-1e4, 1e4, 5000 if engine == "plane" else 60)
    motion = pp.servo_cycle(zxn2, angle=angle, speed=0.0, engine=engine)
    assert STROKE[0] < motion.slide_position.min()
    assert motion.slide_position.max() < STROKE[1]
    first_turn = pp.servo_cycle(zxn2, angle=np.mod(angle, 2 * np.pi), speed=0.0, engine=engine)
    np.testing.assert_allclose(motion.slide_position, first_turn.slide_position, rtol=0, atol=2e-12)
    for i in range(5):
        alone = pp.servo_cycle(zxn2, angle=angle[i : i + 1], speed=0.0, engine=engine)
        np.testing.assert_allclose(alone.q[0], motion.q[i], rtol=0, atol=2e-12)


def test_a_turn_of_the_zxn2(zxn2):
    """Crank and coupler gain a turn against each other, rocker, rod and slide swing."""
    branch = zxn2.branch
    assert branch.period == 2 * np.pi
    gained = dict(zip(zxn2.joints, branch.gain_per_period, strict=True))
    assert gained == {"A": 2 * np.pi, "B": -2 * np.pi, "D": 0.0, "E": 0.0, "slide_guide": 0.0}
    np.testing.assert_allclose(predict(branch, np.array([2 * np.pi]))[:, 0], zxn2.closed + branch.gain_per_period, atol=1e-12)
    np.testing.assert_allclose(predict(branch, np.array([-6 * np.pi]))[:, 0], zxn2.closed - 3 * branch.gain_per_period, atol=1e-12)


@pytest.mark.parametrize("press_name", ["zxn2_3000b", "crank_slide"])
def test_tables_predict(press_name):
    """At random angles the table is off by less than 1e-13 rad or m (2e-15 when this was written) from configurations that Newton's method
    closes from guesses 1e-6 away: rounding. So closing takes at most one step, and none where the gap is
    rounding already.
    """
    press = texts.shipped(press_name)
    angle = np.random.default_rng(1).uniform(0, 2 * np.pi, 3000)
    guess = predict(press.branch, angle)
    closed = press.engine().close(angle, guess + 1e-6)
    assert closed.iterations > 0
    assert np.abs(closed.position - guess).max() < 1e-13
    predicted = press.engine().close(angle, guess)
    assert predicted.iterations <= 1
    assert predicted.gap.max() < 1e-14


# ---------------------------------------------------------------------------------------------------------------------------- locks


def crank_slide(r, rod):
    """The shipped crank-slider with other lengths."""
    text = texts.shipped("crank_slide").text.decode()
    for old, new, count in (
        ('<origin xyz="0.100 0 0"/><axis', f'<origin xyz="{r!r} 0 0"/><axis', 1),
        ('<origin xyz="0 0 -0.500"/><axis', f'<origin xyz="0 0 {-(r + rod)!r}"/><axis', 1),
        ('<link1 link="rod" xyz="0.400 0 0"', f'<link1 link="rod" xyz="{rod!r} 0 0"', 1),
    ):
        assert text.count(old) == count
        text = text.replace(old, new)
    return texts.load(text)


def four_bar_press(*args, **options):
    return texts.load(four_bar(*args, **options).urdf("O"))


def locked(press, **motion):
    with pytest.raises(pp.SingularityError) as caught:
        (pp.servo_cycle if "angle" in motion else pp.cycle)(press, **motion)
    assert 0.0 <= caught.value.smallest_singular_value < 1e-3
    return caught.value.crank_angle


def test_a_crank_longer_than_its_rod_locks():
    """It turns as far as sin q = rod / r, to 1e-6 rad, both ways, and is right all the way there."""
    r, rod = 0.5, 0.4
    lock = np.arcsin(rod / r)
    press = crank_slide(r, rod)
    assert press.branch.period is None
    assert locked(press, speed=1.0) == pytest.approx(lock, abs=1e-6)
    assert locked(press, speed=-1.0) == pytest.approx(-lock, abs=1e-6)
    assert locked(press, angle=[0.0, lock + 1e-5], speed=1.0) == pytest.approx(lock, abs=1e-6)
    assert locked(press, angle=[0.0, -lock - 1e-5], speed=1.0) == pytest.approx(-lock, abs=1e-6)
    with pytest.raises(pp.SingularityError, match=re.escape(f"{np.degrees(-lock):.4f}"[:8])):
        pp.cycle(press, speed=1.0)
    for direction in (1, -1):
        angle = direction * np.linspace(-0.999 * lock, 0.999 * lock, 201)
        motion = pp.servo_cycle(press, angle=angle, speed=float(direction))
        root = np.sqrt(rod**2 - (r * np.sin(angle)) ** 2)
        np.testing.assert_allclose(motion.slide_position, -r * np.cos(angle) - root, rtol=1e-12)
        slope = r * np.sin(angle) + r**2 * np.sin(angle) * np.cos(angle) / root
        np.testing.assert_allclose(motion.slide_velocity, direction * slope, rtol=1e-10, atol=1e-12)
    # close to the lock all engines still say the same
    one, *others = (pp.servo_cycle(press, angle=[0.0, 0.9999 * lock], speed=1.0, engine=engine) for engine in ENGINES)
    for other in others:
        np.testing.assert_allclose(one.slide_velocity, other.slide_velocity, rtol=1e-9, atol=1e-12)


def test_a_crank_as_long_as_its_rod_is_refused_where_two_assemblies_meet():
    """At 90 degrees rod lies on crank and W on O: the slide could as well stand still from there on."""
    press = crank_slide(0.4, 0.4)
    assert locked(press, speed=1.0) == pytest.approx(np.pi / 2, abs=1e-6)
    assert locked(press, speed=-1.0) == pytest.approx(-np.pi / 2, abs=1e-6)
    angle = np.linspace(-1.5, 1.5, 31)
    np.testing.assert_allclose(pp.servo_cycle(press, angle=angle, speed=1.0).slide_position, -0.8 * np.cos(angle), rtol=1e-12)


@pytest.mark.parametrize("shorter", [1e-3, 1e-5, 1e-7])
def test_a_crank_a_little_shorter_than_its_rod_goes_round(shorter):
    """The slide turns sharply at 90 degrees, but turns: the closed form, to 1e-11 m, because l - r is a small difference."""
    rod = 0.4
    r = rod * (1 - shorter)
    press = crank_slide(r, rod)
    angle = np.linspace(0, 2 * np.pi, 2001)
    motion = pp.servo_cycle(press, angle=angle, speed=1.0)
    assert np.abs(motion.slide_position + r * np.cos(angle) + np.sqrt(rod**2 - (r * np.sin(angle)) ** 2)).max() < 1e-11


@pytest.mark.parametrize("longer", [1e-3, 1e-6])
def test_a_crank_a_little_longer_than_its_rod_locks(longer):
    """Just before 90 degrees, to 1e-6 rad."""
    press = crank_slide(0.4 * (1 + longer), 0.4)
    assert locked(press, speed=1.0) == pytest.approx(np.arcsin(1 / (1 + longer)), abs=1e-6)


@pytest.mark.parametrize("degrees", [20, 60, 90, 100, 135])
def test_a_parallelogram_is_refused_at_its_change_points(degrees):
    """Its links lie in a line at 0 and at 180 degrees from the frame's line, where it could go on as a crossed four-bar."""
    press = four_bar_press(1.0, 0.3, 1.0, 0.3, np.radians(degrees))
    assert locked(press, speed=1.0) == pytest.approx(np.radians(180 - degrees), abs=1e-6)
    assert locked(press, speed=-1.0) == pytest.approx(np.radians(-degrees), abs=1e-6)
    angle = np.radians(np.linspace(1, 179, 45) - degrees)
    motion = pp.servo_cycle(press, angle=angle, speed=1.0)
    np.testing.assert_allclose(motion.q[:, press.model.joints[press.joints.index("D") + 1].idx_q], angle, atol=1e-11)
    np.testing.assert_allclose(motion.v[:, press.joints.index("B")], -1.0, rtol=1e-9)


@pytest.mark.parametrize("side", [1, -1])
def test_a_double_rocker_locks_both_ways(side):
    """The driven rocker turns between the angles at which coupler and other rocker lie in a line, stretched and folded: law of cosines."""
    ground, crank, coupler, rocker = 2.0, 1.6, 0.7, 1.8
    low, high = (np.arccos((crank**2 + ground**2 - reach**2) / (2 * crank * ground)) for reach in (rocker - coupler, rocker + coupler))
    drawn = np.radians(60)
    press = four_bar_press(ground, crank, coupler, rocker, drawn, side)
    assert low < drawn < high
    assert locked(press, speed=1.0) == pytest.approx(high - drawn, abs=1e-6)
    assert locked(press, speed=-1.0) == pytest.approx(low - drawn, abs=1e-6)
    angle = np.linspace(low + 1e-3, high - 1e-3, 50) - drawn
    motion = pp.servo_cycle(press, angle=angle, speed=1.0)
    assert gap(press, motion.q).max() < 1e-13
    # the rocker stays on its side of the line from the crank pin to its own pivot
    pin_b = crank * np.exp(1j * (angle + drawn))
    start = np.angle(complex(_corner(press)) - ground)
    pin_c = ground + rocker * np.exp(1j * (start + motion.q[:, press.model.joints[press.joints.index("D") + 1].idx_q]))
    assert (side * (np.conj(ground - pin_b) * (pin_c - pin_b)).imag).min() > 0
    np.testing.assert_allclose(np.abs(pin_c - pin_b), coupler, rtol=1e-12)


def _corner(press):
    """Pin C of the four-bar in the drawn pose, x + i z (its rocker's frame is at D and not turned)."""
    (loop,) = press.loops
    point = loop.point2 + press.model.jointPlacements[loop.joint2].translation
    return complex(point[0], point[2])


@pytest.mark.parametrize("bounded", [True, False])
def test_a_drag_link_goes_round(bounded):
    """Shortest link on the frame: crank and rocker both turn fully. Unwrapped over several turns, the rocker gains as many as the crank."""
    press = four_bar_press(0.5, 1.0, 1.1, 0.9, np.radians(70), bounded=bounded)
    assert press.branch.period == pytest.approx(2 * np.pi)
    gained = dict(zip(press.joints, press.branch.gain_per_period, strict=True))
    assert gained == {"O": 2 * np.pi, "B": 0.0, "D": 2 * np.pi}
    angle = np.linspace(-13, 21, 400)
    motion = pp.servo_cycle(press, angle=angle, speed=1.0)
    assert gap(press, motion.q).max() < 1e-13
    joint = press.joints.index("D")
    assert motion.v[:, joint].min() > 0.0  # never turns back
    if bounded:
        rocker = motion.q[:, press.model.joints[joint + 1].idx_q]
        turned = pp.servo_cycle(press, angle=angle + 6 * np.pi, speed=1.0).q[:, press.model.joints[joint + 1].idx_q]
        np.testing.assert_allclose(turned, rocker + 6 * np.pi, rtol=0, atol=1e-12)
        assert np.diff(rocker).min() > 0.0
        assert abs((rocker[-1] - rocker[0]) - 34) < 2 * np.pi


@pytest.mark.parametrize(("seed", "nodes"), [(4, 560), (25, 950)])
def test_links_that_turn_fast_are_followed(engine, seed, nodes):
    """Far from any singularity, but the coupler turns many times as fast as the crank; near one, in shorter steps."""
    spec = Spec(groups=(Group("RRR", 0, (1, 0, 0)),), seed=seed, tilted=True, stacked=False, solid=False, extra=False)
    press = texts.load(drawn(spec).urdf("crank"))
    angles = press.branch.angles
    assert len(angles) > nodes
    motion = pp.servo_cycle(press, angle=np.linspace(angles[0], angles[-1], 722)[1:-1], speed=5.0, engine=engine)
    assert motion.closure_error.max() < 1e-13
    turned = np.abs(np.diff(motion.joint_position, axis=0)).max()  # half a degree of the crank
    assert turned < 0.15


@pytest.mark.parametrize(("ratio", "turns"), [(-1.0, 1), (-0.5, 2), (0.6, 5)])
def test_period_of_a_geared_linkage(ratio, turns):
    """Both cranks are back only after as many turns as their ratio says."""
    press = texts.load(five_bar(ratio))
    assert press.branch.period == pytest.approx(2 * np.pi * turns, rel=1e-12)
    angles = np.linspace(0.0, 2 * np.pi * turns, 50)
    here, later = (predict(press.branch, angles + shift) for shift in (0.0, press.branch.period))
    whole = (later - here) / (2 * np.pi)
    assert np.abs(whole - np.round(whole)).max() < 1e-9


@pytest.fixture(scope="module")
def never_back():
    return texts.load(five_bar(math.sqrt(2)))


@pytest.mark.exhaustive
def test_a_geared_linkage_that_is_never_back(never_back, engine):
    """With an irrational ratio it is followed through 128 turns either way; further on it says so."""
    press = never_back
    motion = pp.servo_cycle(press, angle=np.linspace(-99.0, 99.0, 40), speed=3.0, engine=engine)
    assert motion.closure_error.max() < 5e-14  # the last bit of the angle of the second crank, 140 rad
    result = pp.inverse_dynamics(press, motion, engine=engine)
    assert np.abs(result.power_residual).max() < 1e-12
    with pytest.raises(pp.PinpressError, match=r"not back at its drawn pose after 128 turns .* between -46080 and 46080 deg"):
        pp.servo_cycle(press, angle=[805.0], speed=3.0, engine=engine)


@pytest.mark.exhaustive
def test_a_geared_linkage_that_is_never_back_is_remarked(never_back):
    assert any("not back at its drawn pose after 128 turns" in note.problem for note in pp.check(never_back.file).notes)


@pytest.mark.exhaustive
def test_redundant_loops_that_contradict_each_other_by_little():
    """A Bennett linkage turns only because its lengths fit: wrong in the twelfth digit, it closes as drawn, but not all round. The
    gap that this leaves is the misfit."""
    text = bennett()
    height = re.search(r'<joint name="J4".*?<origin xyz="\S+ \S+ (\S+)"', text)[1]
    press = texts.load(text.replace(f' {height}"', f' {float(height) + 2.5e-12!r}"'))
    assert 1e-13 < press.assembly.misfit < 1e-10
    torque, exact = (pp.inverse_dynamics(each, pp.cycle(each, 5.0, points=36)).driving_torque for each in (press, texts.load(text)))
    np.testing.assert_allclose(torque, exact, rtol=0, atol=1e-9 * np.abs(exact).max())


@pytest.mark.one_in(3)
@pytest.mark.parametrize("turns", [1500, -1500, 100_000])
def test_joints_many_turns_away_have_turned_as_often(engine, turns):
    """Of a drag link all that turns fully has made the crank's turns, one that swings has not, and the crank is where it was sent."""
    press = four_bar_press(0.5, 1.0, 1.1, 0.9, np.radians(70))
    angle = np.linspace(0.1, 6.2, 101)
    here = pp.servo_cycle(press, angle=angle, speed=1.0, engine=engine)
    there = pp.servo_cycle(press, angle=angle + 2 * np.pi * turns, speed=1.0, engine=engine)
    np.testing.assert_array_equal(there.crank_angle, angle + 2 * np.pi * turns)
    gained = there.joint_position - here.joint_position
    for name, made in (("O", turns), ("D", turns), ("B", 0)):
        rounding = 8 * np.spacing(2 * np.pi * abs(turns))
        np.testing.assert_allclose(gained[:, press.joints.index(name)], 2 * np.pi * made, rtol=0, atol=rounding)


FAR = "turns away: numbers as large are .* rad apart"


@pytest.mark.parametrize("turns", [1e6, 1.5e6])
def test_a_million_turns_away_the_slide_is_where_the_angle_says(turns):
    """By the crank-slider's formula, at the very angle that was given, within half a rounding of it."""
    press, crank, rod = texts.shipped("crank_slide"), 0.100, 0.400
    angle = 2 * np.pi * turns + np.linspace(0.1, 6.2, 13)
    motion = pp.servo_cycle(press, angle=angle, speed=1.0)
    expected = -crank * np.cos(angle) - np.sqrt(rod**2 - (crank * np.sin(angle)) ** 2)
    rounding = 0.5 * np.spacing(angle.max()) * crank * 1.2
    np.testing.assert_allclose(motion.slide_position, expected, rtol=0, atol=rounding + 1e-15)


@pytest.mark.parametrize("angle", [1e12, -1e17, 1.01e7])
def test_angles_whose_rounding_would_be_seen_are_refused(angle):
    press = texts.shipped("crank_slide")
    for asked in (
        lambda: pp.servo_cycle(press, angle=[0.0, angle], speed=1.0),
        lambda: pp.servo_cycle(press, angle=[angle], speed=1.0, engine="pinocchio"),
        lambda: pp.simulate(press, 0.1, speed=1.0, angle=angle),
        lambda: pp.simulate(press, 0.1, speed=1.0, angle=angle, method="constraint"),
        lambda: pp.simulate_batch(press, 0.1, speed=[1.0, 2.0], angle=angle, drive=pp.drives.ConstantTorque(1.0)),
        lambda: pp.steady_state(press, 5.0, drive=pp.drives.InductionMotor(1e3, 150.0), angle=angle),
    ):
        with pytest.raises(pp.PinpressError, match=FAR):
            asked()


def test_times_whose_steps_are_lost_in_rounding_are_refused():
    press, steps = texts.shipped("crank_slide"), 1e-3 * np.arange(4)
    with pytest.raises(pp.PinpressError, match="its steps are lost in rounding: count it from where the motion begins"):
        pp.servo_cycle(press, angle=steps, speed=1.0, time=1e12 + np.arange(4))
    pp.servo_cycle(press, angle=steps, speed=1.0, time=1e6 + steps)


@pytest.mark.parametrize("turns", [-2500, 1500])
@pytest.mark.parametrize("name", ["zxn2_3000b", "crank_slide", "jf75g_125_symmetric"])
def test_joints_far_away_have_turned_as_often(name, turns):
    """What a joint gains in a turn, followed in small steps, it has gained as often as the crank has turned."""
    press = texts.shipped(name)
    followed = pp.servo_cycle(press, angle=np.linspace(0.3, 0.3 + 2 * np.pi, 200), speed=1.0).joint_position
    assert np.abs(np.diff(followed, axis=0)).max() < 0.2
    far = pp.servo_cycle(press, angle=[0.3 + 2 * np.pi * turns], speed=1.0).joint_position[0]
    np.testing.assert_allclose(far, followed[0] + turns * (followed[-1] - followed[0]), rtol=0, atol=1e-9)


def tangent():
    """A slide 0.5 m beside a crank's pivot, which the crank pushes by a guide of its own: it is at 0.5 m tan q."""
    drawing = Drawing("tangent")
    drawing.joint("O", "frame", "crank", 0j)
    drawing.joint("S", "crank", "block", 0.5 + 0j, along=1 + 0j)
    drawing.joint("G", "frame", "slide", 0.5 + 0j, along=1j)
    drawing.loop("W", "block", "slide", 0.5 + 0j)
    for link in ("crank", "block", "slide"):
        drawing.body(link, 2.0, 0.4 + 0.1j)
    return drawing.urdf("O")


def test_a_slide_that_moves_beyond_all_bounds_is_followed_far(engine):
    """Towards a right angle its guides become parallel: the linkage locks there, and is exact before it."""
    press = texts.load(tangent())
    low, high = press.branch.angles[[0, -1]]
    assert -np.pi / 2 < low < -np.pi / 2 + 2e-3
    assert np.pi / 2 - 2e-3 < high < np.pi / 2
    angle = np.linspace(-1.55, 1.55, 40)
    motion = pp.servo_cycle(press, angle=angle, speed=2.0, acceleration=0.0, engine=engine)
    guide = motion.joints.index("G")
    np.testing.assert_allclose(motion.joint_position[:, guide], 0.5 * np.tan(angle), rtol=1e-11)
    np.testing.assert_allclose(motion.v[:, guide], 1.0 / np.cos(angle) ** 2, rtol=1e-11)
    assert locked(press, angle=[0.0, 1.6], speed=1.0) == pytest.approx(np.pi / 2, abs=2e-3)


def test_a_slide_that_a_loop_holds_where_it_is():
    """Nothing but its guide goes round the loop: the lengths round it are the rounding of its points."""
    drawing = Drawing("held", world=pin.rpy.rpyToMatrix(0.3, 0.5, 0.7))
    drawing.joint("O", "frame", "crank", 0j)
    drawing.joint("G", "frame", "slide", 0.31 + 0.57j, along=np.exp(0.7j), rpy=(0.2, 0.3, 0.4))
    drawing.loop("L", "frame", "slide", 0.73 + 0.19j)
    for link in ("crank", "slide"):
        drawing.body(link, 2.0, 0.4 + 0.1j)
    press = texts.load(drawing.urdf("O"))
    motion = pp.cycle(press, speed=1.0)
    assert np.abs(motion.joint_position[:, motion.joints.index("G")]).max() < 1e-14
