"""Process loads: their laws, works and torques against closed forms of the crank-slider and the thin-wall press, and their balance.

Source of the load cases: Zhang 2007, 5.7. The closed forms here use no pinpress: heights and slopes of the slide over the crank angle, and
integrals of the laws by hand. Torques and works are compared to 1e-11 of their peaks, which leaves a hundred roundings of a position of
0.3 m in an interval of 5 mm.
"""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from support.generators.random_linkages import Drawing, momentum_balance
from support.texts import load, shipped

import pinpress as pp
from pinpress.loads.process import Blanking, ConstantForce, DeepDrawing, ElasticDie, ForceInterval, ForceStroke, Idle, TimeForce, step

ENGINES = ("plane", "pinocchio")
SPEED = 300 * pp.RPM
R, L = 0.015, 0.300  # crank and rod of the JF75G-125 [m]
FORCE, START, END = 1.25e6, 0.010, 0.005
BLANKING, DRAWING = Blanking(FORCE, START, END), DeepDrawing(FORCE, START)
TABLE = ForceStroke([0.012, 0.007, 0.004, 0.001], [0.0, 8e5, 3e5, 1.2e6])
# one of every kind and branch
LOADS: dict[str, Any] = {
    "idle": Idle(),
    "piling": ConstantForce(2e5, 0.003),
    "blanking": BLANKING,
    "stripping": Blanking(FORCE, START, END, stripping=1e5),
    "drawing": DRAWING,
    "table": TABLE,
    "die": ElasticDie(0.004, 2e8, 3e5),
}


@pytest.fixture(params=ENGINES)
def engine(request):
    return request.param


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("loads")


def close(ours, expected, relative=1e-11):
    """Equal within a share of the expected peak."""
    assert np.shape(ours) == np.shape(expected)
    assert np.abs(ours - expected).max() <= relative * np.abs(expected).max()


def crank_slide(angle):
    """Height above bottom dead centre, where the crank angle is zero, and its slope by the angle."""
    sine, cosine = np.sin(angle), np.cos(angle)
    along = np.sqrt(L**2 - (R * sine) ** 2)
    return R + L - R * cosine - along, R * sine + R**2 * sine * cosine / along


def angle_at(height):
    """Crank angle at which the slide comes down to a height: law of cosines in the triangle of crank, rod and slide's distance."""
    distance = R + L - height
    return 2 * np.pi - math.acos((R**2 + distance**2 - L**2) / (2 * R * distance))


def thin_wall(angle):
    """Position of the ram of the thin-wall press and its slope by the crank angle, Chen 2002 (lengths of its result)."""
    l1, l3, l4, l6, h = 0.108, 0.648, 0.220, 0.350, 0.630
    s3 = np.sqrt(l6**2 + l1**2 + 2 * l1 * l6 * np.sin(angle))
    theta3 = np.arccos(l1 * np.cos(angle) / s3)
    theta4 = np.arcsin((h - l3 * np.sin(theta3)) / l4)
    omega3 = l1 * np.cos(angle - theta3) / s3
    omega4 = -l3 * omega3 * np.cos(theta3) / (l4 * np.cos(theta4))
    return l3 * np.cos(theta3) + l4 * np.cos(theta4), -l3 * omega3 * np.sin(theta3) - l4 * omega4 * np.sin(theta4)


def law(name, height, velocity):
    """The forces of LOADS written by hand, for arrays of heights and velocities along the axis."""
    down, between = velocity < 0, (height <= START) & (height > END)
    quarter = np.where(down & between, FORCE * np.sin(np.pi / 2 * (START - height) / (START - END)), 0.0)
    return {
        "idle": lambda: np.zeros_like(height),
        "piling": lambda: np.where(height <= 0.003, 2e5, 0.0),
        "blanking": lambda: quarter,
        "stripping": lambda: np.where(~down & between, -1e5, quarter),
        "drawing": lambda: np.where(down & (height <= START), FORCE * np.sin(np.pi * (START - height) / START), 0.0),
        "table": lambda: np.where(down, np.interp(height, [0.001, 0.004, 0.007, 0.012], [1.2e6, 3e5, 8e5, 0.0], left=0.0, right=0.0), 0.0),
        "die": lambda: np.where(height < 0.004, np.maximum(2e8 * (0.004 - height) - 3e5 * velocity, 0.0), 0.0),
    }[name]()


@cache
def solved(name, angles, speed, engine, load_name=None):
    press, at = shipped(name), np.array(angles)
    motion = pp.servo_cycle(press, speed=speed, angle=at)
    given = [] if load_name is None else [LOADS[load_name]]
    return pp.inverse_dynamics(press, motion, given, engine=engine)


def added_torque(name, angles, speed, engine, load_name):
    """What a load adds to the driving torque."""
    angles = tuple(angles)
    return solved(name, angles, speed, engine, load_name).driving_torque - solved(name, angles, speed, engine).driving_torque


# ------------------------------------------------------------------------------------------------------------- torque, work, crank angles


ANGLES = np.linspace(0.013, 2 * np.pi + 0.013, 240, endpoint=False)  # clear of the edges of all LOADS


@pytest.mark.one_in(11)
@pytest.mark.parametrize("name", [name for name in LOADS if name != "idle"])
@pytest.mark.parametrize("sense", [1, -1])
def test_torque_of_a_load_is_its_force_on_the_slope_of_the_slide(engine, name, sense):
    height, slope = crank_slide(ANGLES)
    expected = -law(name, height, sense * SPEED * slope) * slope
    assert np.count_nonzero(expected) >= 15
    close(added_torque("jf75g_125", ANGLES, sense * SPEED, engine, name), expected)


def test_idle_is_no_load():
    assert not added_torque("jf75g_125", ANGLES, SPEED, "plane", "idle").any()


@pytest.mark.parametrize(("height", "published"), [(START, 5.075507637618298), (END, 5.460298276827404)])
def test_crank_angles_of_blanking(height, published):
    """The angles at which the punch meets the blank and breaks through: no force just outside them, the law's just inside."""
    angle = angle_at(height)
    assert angle == pytest.approx(published, abs=1e-13)
    inside = angle + (1e-9 if height == START else -1e-9)
    none, torque = added_torque("jf75g_125", [2 * angle - inside, inside], SPEED, "plane", "blanking")
    assert none == 0.0
    above, slope = crank_slide(inside)
    # 1e-9 rad from its start the force is 0.005 N: the torque's own rounding, of 500 N m idle, is beside it
    assert torque == pytest.approx(-FORCE * math.sin(np.pi / 2 * (START - above) / (START - END)) * slope, rel=1e-11, abs=1e-9)
    assert torque > 5e-5


@pytest.mark.parametrize(
    ("name", "end", "published"), [("blanking", END, 3978.8735773), ("drawing", 0.0, 7957.7471546)], ids=["blanking", "drawing"]
)
@pytest.mark.parametrize("press", ["jf75g_125", "jf75g_125_symmetric"])
def test_work_of_the_load_cases(engine, press, name, end, published):
    """Integral of the added torque over the crank angles of the load, by Gauss: F (start - end) times 2/pi."""
    work = FORCE * (START - end) * 2 / np.pi
    assert work == pytest.approx(published, abs=1e-7)
    begin, finish = angle_at(START), angle_at(end) if end else 2 * np.pi
    nodes, weights = np.polynomial.legendre.leggauss(24)
    angles = begin + (finish - begin) * (nodes + 1) / 2
    torque = added_torque(press, angles, SPEED, engine, name)
    assert weights @ torque * (finish - begin) / 2 == pytest.approx(work, rel=1e-11)


def test_peak_torque_of_the_load_cases():
    """Both have the same law down to 5 mm, and peak before: the closed form's maximum, found on a grid so fine that it is rounding away."""
    angles = np.linspace(5.40, 5.41, 4001)  # 2.5e-6 rad apart: a parabola's top is met to 1e-12
    height, slope = crank_slide(angles)
    peak = (-FORCE * np.sin(np.pi / 2 * (START - height) / (START - END)) * slope).max()
    assert peak == pytest.approx(14587.28903, abs=1e-5)
    for name in ("blanking", "drawing"):
        assert added_torque("jf75g_125", angles, SPEED, "plane", name).max() == pytest.approx(peak, rel=1e-11)


def test_thin_wall_press_works_towards_negative_x(engine):
    """The ram presses towards -x, so that a positive force points to +x; the table's work is its area, and the press gives it."""
    press = shipped("thin_wall")
    ends = pp.dead_centres(press)
    table = ForceStroke([0.30, 0.20, 0.05], [0.0, 4e4, 1e4])
    angles = np.linspace(0.02, 2 * np.pi + 0.02, 240, endpoint=False)
    position, slope = thin_wall(angles)
    force = np.where(slope < 0, np.interp(position - ends.bottom_position, [0.05, 0.20, 0.30], [1e4, 4e4, 0.0], left=0.0, right=0.0), 0.0)
    assert slope[np.argmax(force)] < 0
    motion = pp.servo_cycle(press, speed=7.54, angle=angles)
    idle, loaded = (pp.inverse_dynamics(press, motion, given, engine=engine) for given in ([], [table]))
    close(loaded.driving_torque - idle.driving_torque, -force * slope)
    pin = loaded.bearing_force["E"] - idle.bearing_force["E"]  # the coupler pushes the ram towards -x, against the load
    close(pin[:, 0], -force)

    # crank angles at the table's points, bisected in the closed form, and Gauss between them
    def angle_of(height):
        low, high = ends.top_angle, ends.bottom_angle + (2 * np.pi if ends.bottom_angle < ends.top_angle else 0.0)
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if thin_wall(middle)[0] - ends.bottom_position > height else (low, middle)
        return low

    nodes, weights = np.polynomial.legendre.leggauss(24)
    work = 0.0
    for upper, lower in ((0.30, 0.20), (0.20, 0.05)):
        begin, finish = angle_of(upper), angle_of(lower)
        motion = pp.servo_cycle(press, speed=7.54, angle=begin + (finish - begin) * (nodes + 1) / 2)
        torque = [pp.inverse_dynamics(press, motion, given, engine=engine).driving_torque for given in ([], [table])]
        work += weights @ (torque[1] - torque[0]) * (finish - begin) / 2
    assert work == pytest.approx(0.5 * 0.10 * 4e4 + 0.15 * 2.5e4, rel=1e-11)


# --------------------------------------------------------------------------------------------------------------- where the force goes


@pytest.mark.parametrize("name", [name for name in LOADS if name != "idle"])
def test_foundation_does_not_feel_a_load_and_the_bearings_do(engine, name):
    """Shaking force and moment are those of the idle press; the rod carries F along it: F on the slide's pin, F tan(phi) across."""
    angles = tuple(ANGLES)
    idle, loaded = solved("jf75g_125", angles, SPEED, engine), solved("jf75g_125", angles, SPEED, engine, name)
    height, slope = crank_slide(ANGLES)
    force = law(name, height, SPEED * slope)
    largest = np.abs(force).max()
    assert np.abs(loaded.shaking_force - idle.shaking_force).max() <= 1e-13 * max(largest, np.abs(idle.shaking_force).max())
    assert np.abs(loaded.shaking_moment - idle.shaking_moment).max() <= 1e-13 * max(largest, np.abs(idle.shaking_force).max()) * (R + L)
    pin = loaded.bearing_force["P4"] - idle.bearing_force["P4"]
    close(pin[:, 2], -force)
    tangent = R * np.sin(ANGLES) / np.sqrt(L**2 - (R * np.sin(ANGLES)) ** 2)
    assert np.abs(np.abs(pin[:, 0]) - np.abs(force * tangent)).max() <= 1e-11 * largest
    assert np.abs(loaded.power_residual).max() <= 1e-13  # as without a load


def drawn_crank_slide(crank, rod, world, angle=2.5):
    """A crank-slider that works along 0.8 + 0.6i of any plane, origins of slide and tool off the pin, in the plane and out of it."""
    axis = 0.8 + 0.6j
    drawing = Drawing("drawn", world)
    pin = crank * np.exp(1j * angle)
    place = axis * (pin.real - math.sqrt(rod**2 - pin.imag**2))
    drawing.joint("O", "frame", "crank", 0j)
    drawing.joint("P", "crank", "rod", axis * pin)
    drawing.joint("G", "frame", "slide", place + axis * (0.04 + 0.15j), 0.2, along=axis, rpy=(0.4, -1.0, 0.3))
    drawing.weld("holder", "slide", "tool", place + axis * (-0.1 - 0.2j), -0.1, rpy=(0.2, 0.5, 2.0))
    drawing.loop("W", "rod", "slide", place)
    for link, centre in (("crank", 0j), ("rod", axis * pin), ("slide", place)):
        drawing.body(link, 3.0, centre)
    return drawing.urdf("O")


def turned():
    """Axes of a plane (columns) that lies anyhow in the world."""
    return np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]


@pytest.mark.parametrize("slide", ["slide", "tool"])
def test_slanting_press_with_the_origin_off_its_pin(engine, slide, folder):
    """Force and reaction are in one line however the guide lies: the foundation gets what the momentum balance without the load says."""
    file = folder / "slanting.urdf"
    file.write_text(drawn_crank_slide(0.1, 0.4, turned()), encoding="utf-8")
    press = pp.load(file, slide=slide)
    motion = pp.cycle(press, 12.0, points=48)
    result = pp.inverse_dynamics(press, motion, [DeepDrawing(1e4, 0.12), ElasticDie(0.05, 1e5, 1e3)], engine=engine)
    idle = pp.inverse_dynamics(press, motion, engine=engine)
    assert np.abs(result.driving_torque - idle.driving_torque).max() > 500.0
    force, moment = momentum_balance(press, motion, [])
    # 1e4 N and 0.6 m of arm beside some 100 N of inertia force
    assert np.abs(result.shaking_force - force).max() <= 1e-13 * 1e4 * 10
    assert np.abs(result.shaking_moment - moment).max() <= 1e-13 * 1e4 * 10
    assert np.abs(result.power_residual).max() <= 1e-13


def test_same_as_a_pair_of_point_forces(engine):
    """A process load is a force on the slide's origin and its opposite on the frame."""
    press = shipped("zxn2_3000b")
    motion = pp.cycle(press, 70 * pp.RPM, points=90)
    height = motion.slide_position - pp.dead_centres(press).bottom_position
    force = np.outer(np.where((motion.slide_velocity < 0) & (height <= 0.05), 3e6 * np.sin(np.pi * (0.05 - height) / 0.05), 0.0), [0, 0, 1])
    pair = pp.inverse_dynamics(press, motion, [pp.loads.PointForce("slide", force), pp.loads.PointForce("frame", -force)], engine=engine)
    ours = pp.inverse_dynamics(press, motion, [DeepDrawing(3e6, 0.05)], engine=engine)
    close(ours.driving_torque, pair.driving_torque, 1e-12)
    close(np.array(list(ours.bearing_force.values())), np.array(list(pair.bearing_force.values())), 1e-12)
    close(ours.shaking_force, pair.shaking_force, 1e-12)


@pytest.mark.parametrize("sense", [1, -1])
def test_at_rest_the_way_is_up(sense):
    """In bottom dead centre, where the speed is rounding, a load of the way down is over and one of the way up has begun."""
    press = shipped("jf75g_125")
    motion = pp.servo_cycle(press, speed=sense * SPEED, angle=[0.0, 2 * np.pi, -2 * np.pi, 1e-9, -1e-9, 3.0])
    through = [Blanking(FORCE, START, -START), Blanking(0.0, START, -START, stripping=1e5)]
    down, up, idle = (pp.inverse_dynamics(press, motion, given).bearing_force["P4"][:5, 2] for given in (through[:1], through[1:], []))
    middle = FORCE * math.sin(np.pi / 4)
    assert down - idle == pytest.approx(np.array([0, 0, 0, 0, -middle] if sense > 0 else [0, 0, 0, -middle, 0]), abs=1e-3)
    assert up - idle == pytest.approx(np.array([1e5, 1e5, 1e5, 1e5, 0] if sense > 0 else [1e5, 1e5, 1e5, 0, 1e5]), abs=1e-6)
    held = pp.servo_cycle(press, speed=0.0, angle=[angle_at(0.0075)])  # at rest within the interval
    torques = [pp.inverse_dynamics(press, held, given).driving_torque[0] for given in ([], [BLANKING])]
    assert torques[0] == torques[1]


# ----------------------------------------------------------------------------------------------------------------------------- laws


def at(load, downwards, height, velocity):
    """Force of a load by its intervals, at one height."""
    found = [interval for interval in load.intervals(downwards) if interval.lower < height <= interval.upper]
    assert len(found) <= 1  # disjoint
    force = found[0].force(height, velocity) if found else 0.0
    return np.maximum(force, 0.0) if found and found[0].one_sided else force


@pytest.mark.parametrize("name", LOADS)
@pytest.mark.parametrize("downwards", [True, False])
def test_stretches_for_numbers(name, downwards):
    """One height at a time, as a simulation asks: Python numbers in and out."""
    velocity = -0.3 if downwards else 0.3
    heights = np.linspace(-0.0003, 0.0148, 60)
    forces = [at(LOADS[name], downwards, float(height), velocity) for height in heights]
    assert all(np.ndim(force) == 0 for force in forces)
    expected = law(name, heights, np.full(60, velocity))
    if name == "drawing" and downwards:
        expected[heights <= 0] = 0.0  # the law by hand goes on below bottom dead centre
    assert forces == pytest.approx(expected, rel=1e-12, abs=1e-9)


# loads of one magnitude, or one a scenario
SCENARIOS: dict[str, Any] = {
    "piling": (lambda f: ConstantForce(f, 0.003)),
    "stripping": (lambda f: Blanking(f, START, END, stripping=0.1 * f)),
    "drawing": (lambda f: DeepDrawing(f, START)),
    "table": (lambda f: ForceStroke([0.0, 0.004, 0.012], np.multiply.outer([1.0, 2.0, 0.5], f))),
    "die": (lambda f: ElasticDie(0.004, 1e3 * f, 0.1 * f)),
}


@pytest.mark.parametrize("name", SCENARIOS)
@pytest.mark.parametrize("downwards", [True, False])
def test_scenarios(name, downwards):
    """Magnitudes (S,) give at any heights (..., S), and at one height, what S loads give one by one."""
    make, magnitudes = SCENARIOS[name], np.array([1e5, 0.0, 4e5]) + 1.0
    together = make(magnitudes).intervals(downwards)
    alone = [make(float(magnitude)).intervals(downwards) for magnitude in magnitudes]
    assert [len(intervals) for intervals in alone] == [len(together)] * 3
    rng = np.random.default_rng(1)
    for k, interval in enumerate(together):
        low, high = max(interval.lower, 0.0), interval.upper
        heights, velocities = rng.uniform(low, high, (4, 5, 3)), rng.normal(size=(4, 5, 3))
        force = interval.force(heights, velocities)
        expected = np.array(
            [
                [[alone[s][k].force(float(heights[i, j, s]), float(velocities[i, j, s])) for s in range(3)] for j in range(5)]
                for i in range(4)
            ]
        )
        close(force, expected, 1e-14)
        close(interval.force(0.5 * (low + high), -0.2), np.array([one[k].force(0.5 * (low + high), -0.2) for one in alone]), 1e-14)
        assert alone[0][k].force(heights, velocities).shape == heights.shape


def test_quarter_and_half_sine_at_marked_points():
    (blanking,), (drawing,) = BLANKING.intervals(True), DRAWING.intervals(True)
    assert (blanking.upper, blanking.lower, drawing.upper, drawing.lower) == (START, END, START, 0.0)
    assert blanking.force(START, -1.0) == 0.0
    assert blanking.force(END, -1.0) == FORCE
    assert blanking.force(START - (START - END) / 3, -1.0) == pytest.approx(FORCE / 2, rel=1e-14)  # sin 30 deg
    assert drawing.force(END, -1.0) == FORCE
    assert drawing.force(START - START / 6, -1.0) == pytest.approx(FORCE / 2, rel=1e-14)
    assert abs(drawing.force(0.0, -1.0)) < 1e-9
    assert BLANKING.intervals(False) == DRAWING.intervals(False) == ()


def test_piling_pulse():
    """Height of the window of +-2.5 ms at 300 strokes/min: 0.0486 mm by the formula in its docstring, against the slide's own motion."""
    press, window = shipped("jf75g_125"), 0.0025
    motion = pp.servo_cycle(press, speed=SPEED, angle=[0.0, SPEED * window], time=[0.0, window])
    height = float(motion.slide_position[1] - motion.slide_position[0])
    assert R * (1 + R / L) * (SPEED * window) ** 2 / 2 == pytest.approx(height, rel=1e-3)
    assert height == pytest.approx(4.86e-5, rel=2e-3)
    angles = SPEED * window * np.array([-1.001, -0.999, -0.5, 0.5, 0.999, 1.001])
    turning = pp.servo_cycle(press, speed=SPEED, angle=angles)
    results = [pp.inverse_dynamics(press, turning, given).bearing_force["P4"][:, 2] for given in ([ConstantForce(1e5, height)], [])]
    assert results[0] - results[1] == pytest.approx(np.array([0, -1e5, -1e5, -1e5, -1e5, 0]), abs=1e-6)
    assert ConstantForce(1e5, 0.0).intervals(True) == ConstantForce(1e5, 0.0).intervals(False) == ()


def test_table_is_linear_interpolation_in_any_order():
    rng = np.random.default_rng(7)
    heights, forces = np.sort(rng.uniform(0, 0.1, 9)), rng.normal(size=9) * 1e5
    some = rng.uniform(heights[0], heights[-1], 200)
    for table in (ForceStroke(heights, forces), ForceStroke(heights[::-1], forces[::-1]), ForceStroke(list(heights), tuple(forces))):
        assert [at(table, True, height, -1.0) for height in some] == pytest.approx(np.interp(some, heights, forces), rel=1e-12, abs=1e-7)
        assert [at(table, True, h, -1.0) for h in heights[1:]] == pytest.approx(forces[1:], rel=1e-12)
        assert at(table, True, heights[-1] + 1e-9, -1.0) == at(table, True, heights[0] - 1e-9, -1.0) == 0.0
        assert table.intervals(False) == ()
        assert len(table.intervals(True)) == 8
    heights[0] = -1.0  # the caller's array is not the table's
    assert ForceStroke([0.0, 1.0], [1.0, 2.0]).intervals(True)[0].lower == 0.0
    assert table.intervals(True)[0].lower > -1.0


def test_die_never_pulls():
    die = ElasticDie(0.004, 2e8, 3e6)
    (interval,) = die.intervals(False)
    assert interval.one_sided
    assert interval.force(0.003, 0.3) < 0.0 == at(die, False, 0.003, 0.3)  # the damper alone would hold the slide down
    assert at(die, True, 0.003, -0.3) == pytest.approx(2e8 * 0.001 + 3e6 * 0.3)
    press = shipped("jf75g_125")
    motion = pp.cycle(press, SPEED, points=720)
    results = [pp.inverse_dynamics(press, motion, given).bearing_force["P4"][:, 2] for given in ([die], [])]
    force = results[1] - results[0]
    assert force.min() >= -1e-9  # N; rounding of the difference of two forces of 1e6 N is smaller
    touching = motion.slide_position < pp.dead_centres(press).bottom_position + 0.004
    assert np.any(touching & (force < 1e-9))  # contact lost on the way up
    assert not force[~touching].any()


def test_die_without_damper_gives_its_energy_back():
    """The press puts k h^2 / 2 into it down to bottom dead centre, and gets it back."""
    press, die = shipped("jf75g_125"), ElasticDie(0.004, 2e8)
    begin = angle_at(0.004)
    nodes, weights = np.polynomial.legendre.leggauss(24)
    works = []
    for low, high in ((begin, 2 * np.pi), (2 * np.pi, 4 * np.pi - begin)):
        motion = pp.servo_cycle(press, speed=SPEED, angle=low + (high - low) * (nodes + 1) / 2)
        loaded, idle = (pp.inverse_dynamics(press, motion, given).driving_torque for given in ([die], []))
        works.append(weights @ (loaded - idle) * (high - low) / 2)
    assert works == pytest.approx([1600.0, -1600.0], rel=1e-11)


# ----------------------------------------------------------------------------------------------------------------------- functions of time


def test_step_is_adams_cubic():
    """The one cubic with values 2 and -3 and slopes zero at 0.5 and 0.75, constant outside."""
    inside, end = np.linspace(0.5, 0.75, 26), np.array([0.5, 0.75])
    powers = np.vander(end, 4), np.array([[3 * x**2, 2 * x, 1.0, 0.0] for x in end])
    cubic = np.linalg.solve(np.concatenate(powers), [2.0, -3.0, 0.0, 0.0])
    assert step(inside, 0.5, 2.0, 0.75, -3.0) == pytest.approx(np.polyval(cubic, inside), abs=1e-11)  # condition of the four equations: 1e4
    assert np.array_equal(step([-1.0, 0.5, 0.75, 9.0, np.inf], 0.5, 2.0, 0.75, -3.0), [2.0, 2.0, -3.0, -3.0, -3.0])
    assert step(0.625, 0.5, 2.0, 0.75, -3.0) == pytest.approx(-0.5)
    assert step(np.zeros((2, 3)), 0.0, 0.1, 1.0, 0.7).shape == (2, 3)


def piling(time):
    """The load function of Zhang 2007, 5.7.3, as printed."""
    return 1250 * sum(
        step(time, begin + 0.0974, 0.0, begin + 0.0975, 1.0) * step(time, begin + 0.1024, 1.0, begin + 0.1025, 0.0)
        for begin in (0.0, 0.2, 0.4, 0.6, 0.8)
    )


PILING_EDGES = tuple(begin + edge for begin in (0.0, 0.2, 0.4, 0.6, 0.8) for edge in (0.0974, 0.0975, 0.1024, 0.1025))


def test_piling_of_the_thesis_as_a_function_of_time(engine):
    time = np.linspace(0.0, 1.0, 100_001)
    force = piling(time)
    assert (force.min(), force.max()) == (0.0, 1250.0)
    assert np.all(force[np.abs(time % 0.2 - 0.1) < 0.0024] == 1250.0)
    assert not force[np.abs(time % 0.2 - 0.1) > 0.0026001].any()
    assert np.sum(force) * 1e-5 == pytest.approx(5 * 1250 * 0.005, rel=1e-9)  # N s; each edge counts half its 0.1 ms

    press, some = shipped("jf75g_125"), np.linspace(0.0, 0.4, 401)
    load = TimeForce(piling, PILING_EDGES)
    motion = pp.servo_cycle(press, speed=SPEED, angle=SPEED * some + np.pi, time=some)  # bottom dead centre at 0.1 s
    loaded, idle = (pp.inverse_dynamics(press, motion, given, engine=engine) for given in ([load], []))
    pin = loaded.bearing_force["P4"][:, 2] - idle.bearing_force["P4"][:, 2]
    assert np.abs(pin + piling(some)).max() <= 1e-12 * np.abs(idle.bearing_force["P4"]).max()
    assert np.abs(loaded.shaking_force - idle.shaking_force).max() <= 1e-13 * np.abs(idle.shaking_force).max()
    slope = crank_slide(SPEED * some + np.pi)[1]
    expected = -piling(some) * slope
    assert np.abs(loaded.driving_torque - idle.driving_torque - expected).max() <= 1e-12 * np.abs(idle.driving_torque).max()
    constant = pp.inverse_dynamics(press, motion, [TimeForce(lambda time: 1250.0)], engine=engine)
    assert constant.bearing_force["P4"][:, 2] - idle.bearing_force["P4"][:, 2] == pytest.approx(-1250.0, abs=1e-7)


def test_edges_are_sorted():
    assert TimeForce(piling, [0.3, 0.1, 0.2, 0.1]).edges == (0.1, 0.2, 0.3)
    assert TimeForce(piling).edges == ()


# ----------------------------------------------------------------------------------------------------------------------- datum, protocol


def test_datum_is_bottom_dead_centre_or_the_loads_own():
    press = shipped("jf75g_125")
    assert pp.loads.datum(BLANKING, press) == pytest.approx(-(R + L), abs=1e-14)
    assert pp.loads.datum(DeepDrawing(FORCE, START, datum=-0.31), press) == -0.31
    motion = pp.servo_cycle(press, speed=SPEED, angle=ANGLES)
    raised = DeepDrawing(FORCE, START - 0.002, -0.002, datum=-(R + L) + 0.002)
    ours, expected = (pp.inverse_dynamics(press, motion, [given]).driving_torque for given in (raised, DRAWING))
    close(ours, expected)


def test_linkage_that_locks_needs_a_datum():
    press = load(drawn_crank_slide(0.4, 0.3, np.eye(3), angle=0.4))
    motion = pp.servo_cycle(press, angle=np.linspace(0.0, 0.2, 5), speed=1.0)
    with pytest.raises(pp.PinpressError, match=r"ElasticDie: drawn has no bottom dead centre .*; give datum=, a slide position \[m\]"):
        pp.inverse_dynamics(press, motion, [ElasticDie(0.1, 1e4)])
    pp.inverse_dynamics(press, motion, [Idle(), ConstantForce(1.0, 0.0)])  # no force, no datum
    middle = float(motion.slide_position[2])
    idle, loaded = (pp.inverse_dynamics(press, motion, given).driving_torque for given in ([], [ElasticDie(1.0, 1e4, datum=middle)]))
    force = 1e4 * (1.0 + middle - motion.slide_position)
    close(loaded - idle, -force * motion.slide_velocity, 1e-12)


class Cushion:
    """A load of the caller's own: constant over 2 mm, both ways."""

    datum = None

    def __init__(self, force):
        self.force = force

    def intervals(self, downwards):
        return (ForceInterval(0.002, 0.0, self.force),)


def test_load_of_the_callers_own():
    press = shipped("jf75g_125")
    motion = pp.servo_cycle(press, speed=SPEED, angle=ANGLES)
    idle, loaded = (pp.inverse_dynamics(press, motion, given).driving_torque for given in ([], [Cushion(lambda h, v: 5e5)]))
    height, slope = crank_slide(ANGLES)
    close(loaded - idle, np.where(height <= 0.002, -5e5 * slope, 0.0))
    for force, problem in (
        (lambda h, v: np.ones(2), r"Cushion: force at height 0.002 m, velocity 0 m/s has shape \(2,\); give \(\)"),
        (lambda h, v: 0.0 * h + math.nan, "Cushion: force at height .* is nan; give finite numbers"),
        (lambda h, v: 1.0 if np.ndim(h) == 0 else np.ones(3), r"Cushion: force has shape \(3,\); give \(\d+,\), as many as"),
    ):
        with pytest.raises(pp.PinpressError, match=problem):
            pp.inverse_dynamics(press, motion, [Cushion(force)])


def test_magnitudes_are_copied_and_read_only():
    given = np.array([1.0, 2.0])
    load = Blanking(given, START, END)
    given[0] = 9.0
    assert load.force.tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="read-only"):
        load.force[0] = 3.0
    assert isinstance(Blanking(np.float32(2.0), 1, 0).force, float)
