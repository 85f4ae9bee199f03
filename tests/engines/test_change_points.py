"""Change points: where two assemblies meet, a linkage in motion goes on in its own; a turn that is only prescribed is refused there.

What is expected is known in closed form: a slide on a crank as long as its rod is at -2 r cos(angle); the coupler of a parallelogram does
not turn; of a kite (crank as long as the ground, rocker as the coupler) the rocker's angle follows from the triangle.
"""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from support import texts
from support.exploring import examples
from support.generators import random_linkages, redundant_linkages

import pinpress as pp
from pinpress.kinematics.cycle import motion_through_change_points

METHODS = ("reduced", "constraint")
TEXT = (Path(__file__).parents[2] / "urdf" / "crank_slide.urdf").read_text(encoding="utf-8")
R = 0.1


@pytest.fixture(scope="module")
def equal():
    """The textbook press with its rod as long as its crank."""
    return texts.load(equal_rod())


def equal_rod():
    text = TEXT.replace("0.400 0 0", f"{R} 0 0").replace("0 0 -0.500", f"0 0 {-2 * R}").replace("0.200 0 0", f"{R / 2} 0 0")
    return re.sub(r"<limit[^/]*/>", '<limit lower="-1" upper="1" effort="1e6" velocity="20"/>', text)


def energy(angle, speed, flywheel):
    """Kinetic and potential energy of that press: crank 20 kg at 0.03 m and 0.1 kg m2; rod 15 kg midway and 0.2 kg m2; slide 100 kg."""
    sine, cosine = np.sin(angle), np.cos(angle)
    slide, rod = 2 * R * sine, np.hypot(0.5 * R * cosine, 1.5 * R * sine)
    inertia = flywheel + 0.1 + 20 * 0.03**2 + 15 * rod**2 + 0.2 + 100 * slide**2
    return 0.5 * inertia * speed**2 + 9.81 * (-20 * 0.03 * cosine - 15 * 1.5 * R * cosine - 100 * 2 * R * cosine)


@pytest.mark.parametrize("speed", [8.0, -30.0])
def test_rod_as_long_as_the_crank(equal, method, speed):
    """At 90 degrees the slide might stay on the crankshaft: in motion it goes on. Closed form of position and energy."""
    run = pp.simulate(equal, 4.0, speed=speed, flywheel=pp.drives.Flywheel(50.0), method=method, points=2001)
    assert abs(run.crank_angle[-1]) > 8 * math.pi
    np.testing.assert_allclose(run.slide_position, -2 * R * np.cos(run.crank_angle), atol=1e-14)
    np.testing.assert_allclose(run.slide_velocity, 2 * R * np.sin(run.crank_angle) * run.crank_speed, atol=1e-12 * abs(speed))
    total = energy(run.crank_angle, run.crank_speed, 50.0)
    np.testing.assert_allclose(total, total[0], rtol=1e-10)  # some hundred steps of 1e-11 each, at the most
    assert run.stats.energy_error < 1e-10


@pytest.mark.exhaustive
def test_both_methods_under_drive_and_load(equal):
    options = {"speed": 8.0, "flywheel": pp.drives.Flywheel(50.0), "drive": pp.drives.ConstantTorque(100.0), "points": 201}
    first, second = (pp.simulate(equal, 3.0, method=m, loads=[pp.loads.Blanking(5e3, 0.03, 0.01)], **options) for m in METHODS)
    np.testing.assert_allclose(first.crank_angle, second.crank_angle, atol=1e-8)
    assert first.load_work[-1] > 0
    ends = pp.dead_centres(equal)
    assert ends.stroke == pytest.approx(4 * R, abs=1e-14)
    # in the forces the load is where it was in the run: 30 to 10 mm above bottom dead centre, on the way down
    load = pp.loads.Blanking(5e3, 0.03, 0.01)
    forces = [pp.inverse_dynamics(equal, first, loads=loads).bearing_force["W"] for loads in ([], [load])]
    height = first.slide_position - ends.bottom_position
    pressed = np.abs(forces[1] - forces[0]).max(axis=1) > 100.0
    assert pressed.any()
    assert (height[pressed] < 0.03 + 1e-9).all()
    assert (height[pressed] > 0.01 - 1e-9).all()


def test_a_swing_that_turns_back_at_the_change_point(equal, method):
    """Released at rest 1e-4 rad and 0.3 rad beyond the change point: it falls through it. Closed form of the energy."""
    for start in (math.pi / 2 + 1e-4, math.pi / 2 + 0.3):
        run = pp.simulate(equal, 1.0, angle=start, flywheel=pp.drives.Flywheel(5.0), method=method)
        assert run.crank_angle.min() < -math.pi / 2
        total = energy(run.crank_angle, run.crank_speed, 5.0)
        np.testing.assert_allclose(total, total[0], atol=1e-8 * np.ptp(energy(run.crank_angle, 0.0, 0.0)))


def test_a_prescribed_turn_is_refused_there(equal):
    """Without momentum mechanics does not say which way: the error has the crank angle; a turn up to it is fine."""
    for angle in (math.pi / 2 + 1e-3, math.pi, -math.pi / 2 - 1e-3):
        with pytest.raises(pp.SingularityError, match="two assemblies meet") as caught:
            pp.servo_cycle(equal, angle=[0.0, angle], speed=1.0)
        assert abs(abs(caught.value.crank_angle) - math.pi / 2) < 1e-6
    near = pp.servo_cycle(equal, angle=[math.pi / 2 - 1e-3], speed=1.0)
    assert abs(near.slide_position[0] + 2 * R * math.sin(1e-3)) < 1e-14


def test_forces_at_the_change_point(equal):
    """Beside it they balance; at the point itself they have no value, and the error says at which crank angle."""
    run = pp.simulate(equal, 0.5, speed=8.0, flywheel=pp.drives.Flywheel(50.0), points=501)
    result = pp.inverse_dynamics(equal, run)
    assert np.abs(result.power_residual).max() < 1e-10  # rounding of accelerations beside the point grows as 1 / distance^2
    start = math.pi / 2 - 1e-9
    still = pp.simulate(equal, 1e-12, angle=start, speed=8.0, flywheel=pp.drives.Flywheel(50.0), points=2)
    for engine in ("plane", "space", "pinocchio"):
        with pytest.raises(pp.SingularityError, match="no value") as caught:
            pp.inverse_dynamics(equal, still, engine=engine)
        assert abs(caught.value.crank_angle - math.pi / 2) < 1e-8


def test_check_says_so(equal):
    (note,) = [finding for finding in pp.check(equal.file).notes if "assemblies meet" in finding.problem]
    assert "90, 270 deg" in note.problem
    assert "prescribed turn is refused" in note.remedy


@pytest.mark.parametrize("drawn", [0.9, 2.0, 0.05, -0.02, 3.1])
def test_parallelograms(method, drawn):
    """Drawn anywhere, 0.02 rad beside a change point too."""
    press = texts.load(random_linkages.four_bar(1.0, 0.3, 1.0, 0.3, drawn, 1 if drawn > 0 else -1, bounded=False).urdf("O"))
    run = pp.simulate(press, 1.5, speed=9.0, flywheel=pp.drives.Flywheel(20.0), method=method)
    assert run.crank_angle[-1] > 4 * math.pi
    columns = {name: run.joint_position[:, run.joints.index(name)] for name in ("O", "B", "D")}
    np.testing.assert_allclose(columns["D"], columns["O"], atol=1e-12)
    np.testing.assert_allclose(columns["B"], -columns["O"], atol=1e-12)
    assert run.stats.energy_error < 1e-9


def test_a_kite(method):
    """Ground and crank alike, coupler and rocker alike: where the crank lies on the ground line, pins meet and the rocker may stand still
    or go on; it goes on, and is back after two turns of the crank."""
    press = texts.load(random_linkages.four_bar(0.3, 0.3, 0.8, 0.8, 1.2, bounded=False).urdf("O"))
    run = pp.simulate(press, 3.0, speed=9.0, flywheel=pp.drives.Flywheel(20.0), method=method, points=1001)
    assert run.crank_angle[-1] > 8 * math.pi
    assert run.stats.energy_error < 1e-9
    # the triangle O B D is isosceles, so D-B stands at (pi + crank) / 2 to the ground; C is off its middle by a right angle
    crank = 1.2 + run.crank_angle
    half = 0.3 * np.sin(crank / 2)
    towards = np.exp(0.5j * (np.pi + crank))  # from D to B, while the crank is below a turn; smooth beyond
    pin = 0.3 + towards * (half - 1j * np.sqrt(0.8**2 - half**2))
    rocker = np.unwrap(np.angle((pin - 0.3) / (pin[0] - 0.3)))
    np.testing.assert_allclose(run.joint_position[:, run.joints.index("D")], rocker, atol=1e-10)


def test_a_lock_is_none():
    """At a lock there is no other side: `branch_through_change_points` is the branch itself."""
    press = texts.load(random_linkages.four_bar(1.0, 0.8, 0.3, 0.7, 0.9).urdf("O"))
    assert press.branch_through_change_points is press.branch
    whole = texts.shipped("zxn2_3000b")
    assert whole.branch_through_change_points is whole.branch
    assert not whole.branch_through_change_points.change_points


@pytest.mark.exhaustive
@examples(12)
@given(
    st.floats(0.3, 3.0),
    st.floats(0.1, 0.9),
    st.floats(0.1, 3.0),
    st.sampled_from([1.0, -1.0]),
)
def test_all_parallelograms(ground, share, drawn, way):
    """Of any lengths, drawn anywhere but at a change point, either way round: carried through both, the rocker turns as the crank."""
    assume(min(drawn, math.pi - drawn) > 0.02)
    press = texts.load(random_linkages.four_bar(ground, share * ground, ground, share * ground, drawn, bounded=False).urdf("O"))
    run = pp.simulate(press, 1.0, speed=7.0 * way, flywheel=pp.drives.Flywheel(100.0 * ground**2), points=61)
    rocker = run.joint_position[:, run.joints.index("D")]
    np.testing.assert_allclose(rocker, run.crank_angle, atol=1e-11)
    assert len(press.branch_through_change_points.change_points) == 2


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_forces_at_a_change_point_are_refused(equal, side):
    """On either end of the turn to which the loops alone lead, where forces grow without bounds; inside of it they have a value."""
    corner = side * 0.5 * math.pi
    assert equal.branch.period is None  # it ends at both
    with pytest.raises(pp.SingularityError, match="no value at the change point"):
        pp.inverse_dynamics(equal, motion_through_change_points(equal, np.array([0.0, corner]), 8.0))
    result = pp.inverse_dynamics(equal, motion_through_change_points(equal, np.array([0.0, 0.99 * corner]), 8.0))
    assert np.isfinite(result.bearing_force["W"]).all()


def pushed_parallelogram():
    """A nut that slides up and down pushes the crank of a parallelogram of 0.3 and 0.8 m by a slot across; drawn at 0.5 rad."""
    arm = 0.3 * np.exp(0.5j)
    drawing = random_linkages.Drawing("pushed_parallelogram")
    drawing.joint("nut", "frame", "nut", -0.4 + 1j * arm.imag, along=1j)
    drawing.joint("slot", "nut", "block", arm, along=1 + 0j)
    drawing.joint("O", "frame", "crank", 0j)
    drawing.joint("B", "crank", "coupler", arm)
    drawing.joint("D", "frame", "rocker", 0.8 + 0j)
    drawing.loop("N", "block", "crank", arm)
    drawing.loop("C", "coupler", "rocker", 0.8 + arm)
    for link, centre in (("nut", -0.4 + 0.1j), ("block", arm), ("crank", 0.5 * arm), ("coupler", arm + 0.3), ("rocker", 0.8 + 0.4 * arm)):
        drawing.body(link, 3.0, centre)
    text, travel = drawing.urdf("nut"), 'lower="-50" upper="50"'
    return texts.load(text.replace(travel, 'lower="-0.25" upper="0.12"', 1), slide="nut")


def test_a_driver_that_slides_through_a_change_point(method):
    """Where all pins are in one line, 144 mm below the drawn pose: the equation of motion in closed form, by SciPy."""
    drawn = 0.3 * np.sin(0.5)
    turning = 3.0 * 0.3**2 * (1 + 0.5**2 + 1 + 0.4**2) + 2 * 3.0 * 0.01  # of block, crank, coupler and rocker at the crank's angle
    weight = 9.81 * 3.0 * (1 + 1 + 0.5 + 1 + 0.4)

    def rates(_, state):
        height, speed = drawn + state[0], state[1]
        across = 0.3**2 - height**2
        return speed, (60.0 - weight - turning * height / across**2 * speed**2) / (3.0 + turning / across)

    expected = solve_ivp(rates, (0.0, 0.25), [0.1, -0.5], method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    assert expected[0] < -0.19
    press = pushed_parallelogram()
    run = pp.simulate(press, 0.25, angle=0.1, speed=-0.5, drive=pp.drives.ConstantTorque(60.0), method=method)
    assert len(press.branch_through_change_points.change_points) == 1
    np.testing.assert_allclose([run.crank_angle[-1], run.crank_speed[-1]], expected, rtol=0, atol=1e-9)


def locking_parallelogram(geared):
    """A parallelogram whose coupler moves a slide by a rod that is too short to follow it all the way; or the same with gears in place of
    the pin C."""
    arm = 0.3 * np.exp(0.9j)
    top, foot = 0.5 + arm, 0.45 + 0.42j
    drawing = random_linkages.Drawing("parallelogram")
    drawing.joint("O", "frame", "crank", 0j)
    drawing.joint("B", "crank", "coupler", arm)
    drawing.joint("D", "frame", "second", 1.0 + 0j)
    drawing.joint("E", "coupler", "rod", top)
    drawing.joint("guide", "frame", "slide", foot, along=1j)
    drawing.loop("W", "rod", "slide", foot)
    if not geared:
        drawing.loop("C", "coupler", "second", 1.0 + arm)
    for link, centre in (
        ("crank", 0.5 * arm),
        ("coupler", 0.4 + arm),
        ("second", 1.0 + 0.6 * arm),
        ("rod", 0.5 * (top + foot)),
        ("slide", foot),
    ):
        drawing.body(link, 3.0, centre)
    text = drawing.urdf("O")
    for joint, multiplier in (("B", -1.0), ("D", 1.0)) if geared else ():
        text = redundant_linkages.mimicking(text, joint, "O", multiplier)
    return texts.load(text)


@pytest.mark.exhaustive
def test_a_change_point_beyond_a_lock_is_met_in_another_assembly():
    """Over the lock the rod folds to its other side. At the change point on the way back the drawn assembly's polynomials do not hold, and
    the run ends, where it went over to the drawn assembly in a leap."""
    free, geared = locking_parallelogram(False), locking_parallelogram(True)
    point = min(free.branch_through_change_points.change_points, key=lambda each: abs(each.angle))
    through = pp.simulate(geared, 1.0, speed=15.0, method="constraint", points=1001)
    furthest = int(through.crank_angle.argmax())
    assert through.crank_angle[-1] < point.angle < through.crank_angle[furthest]
    back = furthest + int(np.argmax(through.crank_angle[furthest:] < point.angle + point.half))
    until = float(through.time[back]) - 0.002
    run = pp.simulate(free, until, speed=15.0, method="constraint", points=5)
    same = pp.simulate(geared, until, speed=15.0, method="constraint", points=5)
    order = [run.joints.index(joint) for joint in same.joints]
    np.testing.assert_allclose(run.joint_position[:, order], same.joint_position, rtol=0, atol=1e-8)
    with pytest.raises(pp.SimulationError, match="locks ahead") as caught:
        pp.simulate(free, 1.0, speed=15.0, method="constraint")
    assert abs(caught.value.crank_angle - point.angle) < 1.01 * point.half
