"""Preloaded joints that open while the press runs: against closed forms of one mass, DOP853, energy, the quasi-static slide, long runs."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support.exploring import examples
from support.texts import shipped

import pinpress as pp
from pinpress.elasticity import Elastic, PreloadedJoint, Rod, Stiffness, slide_deflection
from pinpress.simulation.elastic.preloaded_joint import JointSpring
from pinpress.simulation.elastic.press.assembly import sprung_press

SPEED = 300 * pp.RPM
BLANK = pp.loads.Blanking(1.25e6, 0.010, 0.005)


@examples(60)
@given(
    loaded=st.floats(1e8, 1e10),
    relieved=st.floats(1e8, 1e10),
    series=st.one_of(st.just(math.inf), st.floats(1e8, 1e10)),
    ends=st.sampled_from([1, 2]),
    load=st.floats(-4.0, 4.0),
)
def test_three_springs_side_by_side_are_the_joint_in_series_with_a_pin(loaded, relieved, series, ends, load):
    joint = PreloadedJoint(loaded, relieved, 1e5)
    load = 1e5 * load
    extension = np.array([float(joint.elongation(load)) / ends + load / series])
    found = JointSpring("rod", 0, joint, ends, series).open(3, 7.0)
    pull = found.always * (extension - found.rest) - found.spring_force(extension)
    assert pull[0] == pytest.approx(load, rel=1e-9, abs=1e-6 * 1e5)
    assert found.always >= 0
    if 0.99 * -joint.slack_load < load < 0.99 * joint.opening_load:
        assert sum(found.dampers) + found.damping == pytest.approx(7.0)  # of the closed joint


def one_mass_press(ratio):
    """A crown, with all that hangs on it, as one mass on its columns: the bearings are ten thousand times as stiff."""
    press = shipped("crank_slide")
    joint = PreloadedJoint(1e7, 3e7, 2e4)
    stiffness = Stiffness(dict.fromkeys(press.bearings, 1e11), {"slide_guide": 1e10}, frame=joint)
    mass = 2000 + sum(press.model.inertias[k].mass for k in range(1, press.model.njoints))
    return press, joint, mass, Elastic(stiffness, ratio, dict.fromkeys(press.bearings, 3e6), crown_mass=2000)


@pytest.mark.exhaustive
def test_one_mass_on_a_joint_that_opens():
    """A press holds 40 kN, which opens its joint, and is let go: when the uprights touch and lift off, and the extreme heights, by the two
    half periods. The crank creeps through bottom dead centre."""
    press, joint, mass, elastic = one_mass_press(0.0)
    wheel, force = pp.drives.Flywheel(1e9), 4e4
    weight = 9.81 * (mass - 2000)  # the columns are as the crown's own weight leaves them
    push = pp.loads.TimeForce(lambda t: np.where(np.asarray(t) < 0.01, force, 0.0), edges=(0.01,))
    begin = pp.dead_centres(press).bottom_angle
    run = pp.simulate(press, 0.11, speed=1e-3, angle=begin, flywheel=wheel, loads=[push], elastic=elastic, points=501)
    opening = joint.opening_load / joint.stiffness
    raised = float(joint.elongation(force - weight))  # where it rests under the force
    open_rate, closed_rate = math.sqrt(joint.loaded / mass), math.sqrt(joint.stiffness / mass)
    # open it swings about where the rods alone carry the weight: loaded x + preload = -weight
    middle_open, middle_closed = -(weight + joint.preload) / joint.loaded, -weight / joint.stiffness
    to_touch = math.acos((opening - middle_open) / (raised - middle_open)) / open_rate
    speed = open_rate * math.sqrt((raised - middle_open) ** 2 - (opening - middle_open) ** 2)
    swing = math.hypot(speed / closed_rate, opening - middle_closed)
    within = 2 * (math.pi - math.atan2(speed / closed_rate, opening - middle_closed)) / closed_rate
    touch = 0.01 + to_touch
    expected = [0.01, touch, touch + within, touch + within + 2 * to_touch, touch + 2 * within + 2 * to_touch]
    assert swing - middle_closed < joint.slack_load / joint.stiffness  # the rods stay taut
    assert [time for time, _, _ in run.events][:5] == pytest.approx(expected, rel=4e-5)  # the bearings yield too, a hundredth per cent
    lifted = run.slide_position - run.rigid_slide_position
    assert lifted.max() == pytest.approx(raised, rel=1e-3)
    assert lifted.min() == pytest.approx(middle_closed - swing, rel=3e-4)
    assert run.joint_load["frame"].max() == pytest.approx(force - weight, rel=1e-4)
    assert run.stats.energy_error < 1e-9
    pulled, pressed = joint.forces(run.joint_load["frame"])
    assert (pressed == 0).any()
    assert (pulled > 0).all()


@pytest.mark.exhaustive
@pytest.mark.parametrize("part", ["frame", "rod", "slide_guide"])
def test_against_dop853(part):
    """The closed press, with the members that lift off taken away, by a right side written here."""
    press, held = shipped("crank_slide"), pp.drives.PrescribedSpeed(2.0)
    bearings: dict[str, float | PreloadedJoint] = dict.fromkeys(press.bearings, 1e8)
    joint = {"frame": PreloadedJoint(1e8, 3e8, 1e4), "slide_guide": PreloadedJoint(5e7, 5e7, 1e3), "rod": PreloadedJoint(1e8, 3e8, 5e3)}[
        part
    ]
    if part == "slide_guide":
        bearings["slide_guide"] = joint
    rods = [Rod("rod", ("P", "W"), joint)] if part == "rod" else []
    stiffness = Stiffness(bearings, {"slide_guide": 1e7}, rods, frame=joint if part == "frame" else 4e8)
    elastic = Elastic(stiffness, 0.1, crown_mass=500)
    blank = pp.loads.Blanking(3e4, 0.02, 0.01)
    begin, end = 5.85, 0.035 if part == "frame" else 0.06  # it breaks after 26 ms
    given = {"speed": 2.0, "angle": begin, "drive": held, "loads": [blank], "elastic": elastic}
    run = pp.simulate(press, end, points=41, tolerance=1e-8, **given)
    assert run.stats.energy_error < 1e-9
    segment = run.trajectory.segments[0]
    solution = segment.solution
    sprung, slide = sprung_press(press, elastic), solution.equations.paths[0]
    rows = [int(np.flatnonzero(sprung.springs.bearing == each.bearing)[0]) for each in sprung.joints]
    series = 1e8 if part == "rod" else math.inf
    bottom = pp.dead_centres(press).bottom_position

    def pull_of(x):
        """Pull of the joint in series with the pin at an extension, without dampers."""
        ends = len(rows)
        far = 1e9 * abs(x) + 1.0
        return brentq(lambda load: float(joint.elongation(load)) / ends + load / series - x, -far, far, xtol=1e-9, rtol=1e-15)

    opened = [each.open(row, float(sprung.springs.damping[row])) for each, row in zip(sprung.joints, rows, strict=True)]

    def rates(time, state, cutting):
        size = len(state) // 2
        free, speeds = np.append(state[:size], begin + 2.0 * time), np.append(state[size:], 2.0)
        bodies = sprung.state(free[None], speeds[None])
        force = sprung.spring_forces(bodies, derivatives=False).force[0]
        at = sprung.geometry.strains(bodies)
        gradients = sprung.to_free(sprung.geometry.gradient(at))[0]
        for row, each in zip(rows, opened, strict=True):
            x, v, gradient = float(at.extension[0, row]), float(at.opening[0, row]), gradients[row]
            closed = -(sprung.springs.stiffness[row] * x + sprung.springs.damping[row] * v)
            pushes = each.members[1] * (each.reach[1] - x) - each.dampers[1] * v if x < each.reach[1] else 0.0
            pulls = each.members[0] * (each.reach[0] + x) + each.dampers[0] * v if x > -each.reach[0] else 0.0
            alone = -pull_of(x) - float(each.spring_force(np.array([x]))[0])  # what always holds, by the series
            force = force + (alone - each.damping * v + max(pushes, 0.0) - max(pulls, 0.0) - closed) * gradient
        if cutting:
            path = slide.over(sprung, bodies)
            height = float(path.value[0]) - bottom
            force = force + 3e4 * math.sin(0.5 * math.pi * (0.02 - height) / 0.01) * path.gradient[0]
        return np.concatenate([state[size:], np.linalg.solve(sprung.mass[:size, :size], force[:size])])

    first = segment.states(np.zeros(1))
    state = np.concatenate([first.y[0], first.v[0]])
    breaks = next(time for time, _, place in run.events if abs(place - bottom - 0.01) < 1e-9)
    assert len(run.events) > 2
    for cutting, span in ((True, (0.0, breaks)), (False, (breaks, end))):
        state = solve_ivp(rates, span, state, "DOP853", args=(cutting,), rtol=1e-7, atol=1e-10).y[:, -1]
    last = segment.states(np.array([end]))
    size = len(state) // 2
    np.testing.assert_allclose(state[:size], last.y[0], atol=2e-8)
    np.testing.assert_allclose(state[size:], last.v[0], atol=2e-5)


def fast_press(frame, guide=2e9, rods=(), ratio=0.05):
    bearings = {"O": 3e9, "P2": 4e9, "P4": 4e9, "slide_guide": guide}
    return Elastic(Stiffness(bearings, {"slide_guide": 2e8}, rods, frame=frame), ratio, crown_mass=4000)


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    "elastic",
    [
        fast_press(PreloadedJoint(2e9, 6e9, 8e5)),
        pytest.param(fast_press(PreloadedJoint(2e9, 6e9, 2e5)), marks=pytest.mark.exhaustive),  # it opens six times in a stroke
        pytest.param(fast_press(8e9, PreloadedJoint(1e9, 1e9, 2e4)), marks=pytest.mark.exhaustive),
        pytest.param(fast_press(8e9, rods=[Rod("main_rod", ("P2", "P4"), PreloadedJoint(3e9, 5e9, 2e5))]), marks=pytest.mark.exhaustive),
    ],
    ids=["frame", "loose frame", "gibs", "rod"],
)
def test_a_steady_state_is_the_stroke_to_which_runs_settle(elastic):
    press, held = shipped("jf75g_125_plain"), pp.drives.PrescribedSpeed(SPEED)
    given = {"drive": held, "loads": [BLANK], "elastic": elastic}
    steady = pp.steady_state(press, SPEED, points=181, **given)
    run = pp.simulate(press, 0.4, speed=SPEED, points=2 * 180 + 1, **given)
    ((name, load),) = steady.joint_load.items()
    joint = next(each.joint for each in sprung_press(press, elastic).joints)
    assert load.max() > joint.opening_load or -load.min() > joint.slack_load
    largest = np.abs(load).max()
    np.testing.assert_allclose(run.joint_load[name][-181:], load, atol=5e-3 * largest)  # a disturbance shrinks to 0.7 % in a stroke
    assert run.slide_position[-181:].min() == pytest.approx(steady.slide_position.min(), abs=1e-6)
    assert run.stats.energy_error < 1e-9
    assert steady.stats.energy_error < 1e-6  # where a damped member lifts off, Newton's method ends at its tolerance
    assert steady.lost[-1] == pytest.approx(steady.drive_work[-1] - steady.load_work[-1], rel=1e-5)


@pytest.mark.exhaustive
def test_stiffer_joints_open_as_the_rigid_press_says():
    """Of a slow press the load of the columns tends to that of rigid mechanics as all stiffnesses grow, in proportion to 1 / k; the slide
    yields by the quasi-static deflection."""
    press, held = shipped("crank_slide"), pp.drives.PrescribedSpeed(0.5)
    drawing, errors = [pp.loads.DeepDrawing(3e4, 0.02)], []
    for factor in (1.0, 4.0):
        joint = PreloadedJoint(1e8 * factor, 3e8 * factor, 1e4)
        stiffness = Stiffness(dict.fromkeys(press.bearings, 4e8 * factor), {"slide_guide": 1e8 * factor}, frame=joint)
        run = pp.simulate(
            press, 1.0, speed=0.5, angle=5.5, drive=held, loads=drawing, points=101, elastic=Elastic(stiffness, 0.5, crown_mass=500)
        )
        motion = pp.servo_cycle(press, angle=run.crank_angle, speed=0.5)
        bent = slide_deflection(press, motion, stiffness, loads=drawing)
        yielded = run.slide_position - run.rigid_slide_position
        later = slice(10, -1)
        open_there = bent.parts["frame"] > joint.opening_load / joint.stiffness
        assert open_there.any()
        errors.append(np.abs(yielded - bent.deflection)[later].max() / np.abs(bent.deflection).max())
    assert errors[1] < 0.35 * errors[0]


def test_a_joint_that_starts_open():
    """The weight of the links leaves the rods of a press slack from the start; it stays there."""
    press, _, mass, elastic = one_mass_press(0.05)
    loose = PreloadedJoint(3e7, 5e6, 1e3)
    elastic = Elastic(Stiffness(elastic.stiffness.bearings, elastic.stiffness.moments, frame=loose), 0.05, crown_mass=2000)
    held = pp.drives.PrescribedSpeed(1e-3)
    run = pp.simulate(press, 0.05, speed=1e-3, drive=held, elastic=elastic, points=11)
    weight = 9.81 * (mass - 2000)
    assert run.joint_load["frame"] == pytest.approx(np.full(11, -weight), rel=1e-3)
    assert -run.joint_load["frame"].max() > loose.slack_load
    lowered = run.slide_position - run.rigid_slide_position
    assert lowered == pytest.approx(np.full(11, float(loose.elongation(-weight))), rel=1e-2)
