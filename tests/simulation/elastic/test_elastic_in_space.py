"""Linkages in space on springs: against the plane, the rigid limit, closed forms and other programs."""

from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from support.presses.presses_on_springs import PINS, rssp, springs
from support.texts import shipped

import pinpress as pp
from pinpress.kinematics.poses import poses
from pinpress.simulation.elastic.press import assembly, space, turning
from pinpress.simulation.elastic.press.assembly_in_space import press_in_space
from pinpress.simulation.elastic.press.sprung_press import reference_motion

SPEED = 100 * pp.RPM


@cache
def idle(stiffness, points=37):
    return stroke(rssp(), SPEED, springs(rssp(), stiffness, PINS), points=points)


def stroke(press, speed, elastic, **more):
    return pp.steady_state(press, speed, drive=pp.drives.PrescribedSpeed(speed), elastic=elastic, **more)


def simulated(*given, **named):
    return pp.simulate(*given, **named)


def in_space(press, elastic):
    return press_in_space(press, elastic, reference_motion(press))


@pytest.mark.exhaustive
def test_a_planar_press_moves_in_space_as_in_its_plane(monkeypatch):
    """Under blanking: forces, events, depth, decay and works of the planar equations."""
    press, speed, stiffness = shipped("jf75g_125_plain"), 300 * pp.RPM, 2e9
    more = {"loads": [pp.loads.Blanking(1.25e6, 0.010, 0.005)], "points": 91}
    plane = stroke(press, speed, springs(press, stiffness, ["slide_guide"]), **more)
    monkeypatch.setattr(assembly, "press_in_plane", press_in_space)
    space = stroke(press, speed, springs(press, stiffness, press.joints), **more)
    assert space.stats.steps == plane.stats.steps
    for bearing, peak in plane.peaks.items():
        assert space.peaks[bearing] == pytest.approx(peak, rel=2e-8)  # a guide's twist is an angle there, its sine here
    np.testing.assert_allclose(space.events, plane.events, rtol=0, atol=1e-10)
    np.testing.assert_allclose(space.slide_position, plane.slide_position, rtol=0, atol=1e-11)
    np.testing.assert_allclose(space.drive_torque, plane.drive_torque, rtol=0, atol=1e-7 * np.abs(plane.drive_torque).max())
    np.testing.assert_allclose(space.shaking_force, plane.shaking_force, rtol=0, atol=0.01)
    assert space.decay_per_stroke == pytest.approx(plane.decay_per_stroke, rel=1e-8)
    np.testing.assert_allclose(space.displacement[:, :, [0, 2]], plane.displacement[:, :, :2], rtol=0, atol=1e-10)
    assert np.abs(space.displacement[:, :, [1, 3, 5]]).max() < 1e-12
    np.testing.assert_allclose(np.abs(space.displacement[:, :, 4]), np.abs(plane.displacement[:, :, 2]), rtol=0, atol=1e-10)
    assert [each[-1] for each in (space.drive_work, space.load_work, space.lost)] == pytest.approx(
        [each[-1] for each in (plane.drive_work, plane.load_work, plane.lost)], rel=1e-9
    )


def forces_of(found):
    return np.array([found.bearing_force[name][:36] for name in rssp().bearings])


@pytest.mark.exhaustive
def test_start_without_vibration_in_space():
    """Springs that carry the inertia forces of the rigid press carry its bearing forces, but for what goes with 1 / stiffness."""
    rigid = pp.inverse_dynamics(rssp(), pp.servo_cycle(rssp(), angle=[0.7], speed=SPEED))
    drive, left = pp.drives.PrescribedSpeed(SPEED), []
    for stiffness in (1e9, 2e9):
        run = simulated(rssp(), 1e-4, angle=0.7, speed=SPEED, drive=drive, elastic=springs(rssp(), stiffness, PINS), points=2)
        left.append(max(np.abs(run.bearing_force[name][0] - rigid.bearing_force[name][0]).max() for name in rssp().bearings))
    assert np.log2(left[0] / left[1]) == pytest.approx(1.0, abs=0.05)
    assert left[1] < 2e-3 * max(np.abs(rigid.bearing_force[name]).max() for name in rssp().bearings)


@pytest.mark.exhaustive
def test_displacements_are_what_stretches_the_springs():
    """A point of a link moves by its centre of mass and its turn. What is between the two sides of a bearing is its force by its stiffness;
    at the universal joint the springs of both its pins stand in a row. A cross without mass moves with its carrier."""
    press, stiffness = rssp(), 1e8
    drive, elastic = pp.drives.PrescribedSpeed(SPEED), springs(press, stiffness, PINS)
    run = simulated(press, 1e-3, angle=0.7, speed=SPEED, drive=drive, elastic=elastic, points=3)
    placed = poses(press, run.joint_position)

    def moved(joint, point):
        if not joint:
            return np.zeros((3, 3))
        arm = placed.points(joint, point) - placed.points(joint, press.model.inertias[joint].lever)
        return run.displacement[:, joint - 1, :3] + np.cross(run.displacement[:, joint - 1, 3:], arm)

    (loop,), size = press.loops, max(np.abs(each).max() for each in run.bearing_force.values())
    within = {"rtol": 0, "atol": 5e-4 * size}
    stretched = moved(loop.joint2, loop.point2) - moved(loop.joint1, loop.point1)
    np.testing.assert_allclose(-stiffness * stretched, run.bearing_force[loop.name], **within)
    for name, springs_in_a_row in (("O", 1), ("B", 2)):
        joint = press.model.getJointId(name)
        carrier, place = press.model.parents[joint], press.model.jointPlacements[joint].translation
        stretched = moved(joint, np.zeros(3)) - moved(carrier, place)
        np.testing.assert_allclose(-stiffness * stretched / springs_in_a_row, run.bearing_force[name], **within)
    cross = press.model.getJointId("B_cross")
    np.testing.assert_allclose(run.displacement[:, cross - 1, :3], moved(1, press.model.jointPlacements[cross].translation), atol=1e-12)
    np.testing.assert_array_equal(run.displacement[:, cross - 1, 3:], run.displacement[:, 0, 3:])


def test_turns_and_their_derivatives_far_from_small():
    """Gibbs's vector w is twice the tangent of half the angle along the axis, by SciPy's rotations; derivatives by central differences of
    them along a line, and of each other, for turns of more than 90 degrees."""
    random, step = np.random.default_rng(0), 1e-4
    w, v = random.uniform(-2, 2, (2, 1, 40, 3))

    def matrices(vectors):
        halves = np.concatenate([0.5 * vectors, np.ones((*vectors.shape[:-1], 1))], axis=-1)
        return Rotation.from_quat(halves.reshape(-1, 4)).as_matrix().reshape(*vectors.shape[:-1], 3, 3)

    def small(vectors):
        """(1, B, matrices, 3, 3): see `turning.SMALL`."""
        return turning._small_turn(vectors, v, True).swapaxes(2, 3)

    found, along = small(w), [matrices(w + share * step * v) for share in (-1, 0, 1)]
    np.testing.assert_allclose(found[:, :, 0], along[1], atol=1e-14)
    np.testing.assert_allclose(found[:, :, 13], (along[2] - along[0]) / (2 * step), atol=1e-6)
    np.testing.assert_allclose(found[:, :, 17], (along[2] - 2 * along[1] + along[0]) / step**2, atol=1e-5)
    for d in range(3):
        more, less = (small(w + sign * step * np.eye(3)[d]) for sign in (1, -1))
        slopes = (more - less) / (2 * step)
        np.testing.assert_allclose(found[:, :, 1 + d], slopes[:, :, 0], atol=1e-6)
        np.testing.assert_allclose(found[:, :, 4 + 3 * d : 7 + 3 * d], slopes[:, :, 1:4], atol=1e-6)
        np.testing.assert_allclose(found[:, :, 14 + d], slopes[:, :, 13], atol=1e-6)
        np.testing.assert_allclose(found[:, :, 18 + d], slopes[:, :, 17], atol=1e-5)


def test_vectors_of_turns_are_those_of_rotations():
    vectors = np.random.default_rng(1).normal(size=(50, 3)) * np.geomspace(1e-9, 1.0, 50)[:, None]
    np.testing.assert_allclose(space._turn_of(Rotation.from_rotvec(vectors).as_matrix()), vectors, rtol=1e-7, atol=1e-15)
    np.testing.assert_array_equal(space._turn_of(np.eye(3)[None]), np.zeros((1, 3)))


@pytest.mark.exhaustive
def test_rigid_limit_in_space():
    """What is left of the rigid press goes with 1 / stiffness."""
    rigid, runs = pp.inverse_dynamics(rssp(), pp.cycle(rssp(), SPEED, points=36)), [idle(k) for k in (1e9, 2e9)]
    left = [np.abs(forces_of(run) - forces_of(rigid)).max() for run in runs]
    np.testing.assert_allclose(np.log2(np.divide(left[:-1], left[1:])), 1.0, atol=0.02)
    torque = [np.abs(run.drive_torque[:-1] - rigid.driving_torque).max() for run in runs]
    np.testing.assert_allclose(np.log2(np.divide(torque[:-1], torque[1:])), 1.0, atol=0.02)


@pytest.mark.exhaustive
def test_rigid_limit_in_space_by_extrapolation():
    """Most states agree much better than the worst ones, at which a panel begins: there vibrations too fast to be followed leave traces."""
    exact = forces_of(pp.inverse_dynamics(rssp(), pp.cycle(rssp(), SPEED, points=36)))
    rough = [forces_of(idle(k)) for k in (2e9, 4e9, 8e9)]
    first = [2 * rough[1] - rough[0], 2 * rough[2] - rough[1]]
    left = np.abs((4 * first[1] - first[0]) / 3 - exact).max(axis=(0, 2)) / np.abs(exact).max()
    assert left.max() < 3e-7
    assert np.median(left) < 1e-8


@pytest.mark.exhaustive
def test_energy_in_space():
    run = idle(1e9)
    assert run.stats.energy_error < 1e-9
    assert abs(run.drive_work[-1] - run.lost[-1]) < 1e-9 * run.stats.energy_error + 1e-9 * np.ptp(run.drive_work)


def test_derivatives_in_space():
    """Of springs, dampers and inertia forces, by central differences, where links are displaced and turned far more than they are."""
    press = rssp()
    sprung, random = in_space(press, springs(press, 1e9, PINS)), np.random.default_rng(3)
    place, rates, _ = sprung.geometry.rigid(pp.servo_cycle(press, angle=[0.4, 2.0], speed=3.0))
    y = sprung.free_coordinates(place) + 1e-2 * random.normal(size=(2, sprung.free))
    v = sprung.free_rates(rates) + random.normal(size=y.shape)
    a = random.normal(size=y.shape)

    def forces(y, v, a):
        state = sprung.state(y, v)
        inertia, own = sprung.varying_inertia(state, a), sprung.spring_forces(state)
        return [own.force, inertia.force], [
            (-own.stiffness, inertia.by_place),
            (-own.damping, inertia.by_rate),
            (0 * y, inertia.by_acceleration),
        ]

    _, found = forces(y, v, a)
    for which, exact in enumerate(found):
        for k in range(sprung.free):
            step = np.zeros_like(y)
            step[:, k] = 1e-6
            shifted = [[each + sign * step * (number == which) for number, each in enumerate((y, v, a))] for sign in (1, -1)]
            after, before = (forces(*each)[0] for each in shifted)
            for one, other, slope in zip(after, before, exact, strict=True):
                if slope.ndim == 3:
                    np.testing.assert_allclose((one - other) / 2e-6, slope[:, :, k], rtol=0, atol=1e-6 * np.abs(slope).max())


def test_vibrations_of_a_planar_press_are_among_those_in_space(monkeypatch):
    press, wheel = shipped("jf75g_125_plain"), pp.drives.Flywheel(30.0)
    given = {"angle": [0.3, 2.0], "flywheel": wheel}
    plane = pp.elasticity.natural_frequencies(press, springs(press, 2e9, ["slide_guide"]), **given)
    monkeypatch.setattr(assembly, "press_in_plane", press_in_space)
    space = pp.elasticity.natural_frequencies(press, springs(press, 2e9, press.joints), **given)
    for state in range(2):
        beside = np.abs(space.natural_frequency[state] / plane.natural_frequency[state][:, None] - 1)
        assert beside.min(axis=1).max() < 1e-10
        mode = int(beside[0].argmin())
        for part in plane.strain_energy:
            assert space.strain_energy[part][state, mode] == pytest.approx(plane.strain_energy[part][state, 0], rel=1e-6)
        for link in plane.kinetic_energy:
            assert space.kinetic_energy[link][state, mode] == pytest.approx(plane.kinetic_energy[link][state, 0], rel=1e-6)
        one, other = space.shapes[state, mode][:, [0, 2, 4]], plane.shapes[state, 0]
        np.testing.assert_allclose(np.abs(one), np.abs(other), rtol=0, atol=1e-9 * np.abs(other).max())
    assert sum(space.strain_energy.values())[0] == pytest.approx(1.0, abs=1e-12)


def test_rotor_on_its_bearing_whirls_as_its_closed_form_says():
    """A spinning rotor whose bearing yields against tilting: A p'' - i C w p' + k p = 0, with gyroscopic moments, seen from the rotor."""
    press, spin, tilting = shipped("jf75g_125_plain"), 400.0, 3e6
    inertias = list(press.model.inertias)
    across, polar = 0.3, 0.5
    inertias[1] = pin.Inertia(50.0, np.zeros(3), np.diag([across, polar, across]))
    rotor = press.with_inertias(inertias)
    stiffness = pp.elasticity.Stiffness(dict.fromkeys(rotor.bearings, 2e9), moments=dict.fromkeys(rotor.joints, tilting))
    sprung = in_space(rotor, pp.elasticity.Elastic(stiffness, damping_ratio=0.0))
    own, lines = sprung.springs.bearing == 0, sprung.geometry.lines
    geometry = replace(sprung.geometry, lines=lines._make(column[own] for column in lines))
    sprung = replace(sprung, geometry=geometry, springs=sprung.springs._make(column[own] for column in sprung.springs))
    place, rates, _ = sprung.geometry.rigid(pp.servo_cycle(rotor, angle=[0.3], speed=spin))
    state = geometry.state(place, rates)
    inertia, springs_of = sprung.varying_inertia(state, np.zeros((1, sprung.free))), sprung.spring_forces(state)
    tilts = slice(6 * geometry.crank_body + 3, 6 * geometry.crank_body + 5)
    mass, gyroscopic = inertia.by_acceleration[0, tilts, tilts], inertia.by_rate[0, tilts, tilts]
    stiff = springs_of.stiffness[0, tilts, tilts] + inertia.by_place[0, tilts, tilts]
    first_order = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, stiff), -np.linalg.solve(mass, gyroscopic)]])
    found = np.sort(np.abs(np.linalg.eigvals(first_order).imag))[::2]
    root = np.sqrt((polar * spin) ** 2 + 4 * across * tilting)
    whirls = np.array([polar * spin + root, polar * spin - root]) / (2 * across)
    np.testing.assert_allclose(found, np.sort(np.abs(whirls - spin)), rtol=1e-10)
    straight = springs_of.stiffness[0, :3, :3]
    np.testing.assert_allclose(np.sqrt(np.diagonal(straight) / 50.0), np.sqrt(2e9 / 50.0), rtol=1e-12)


@pytest.mark.exhaustive
def test_motion_in_space_beside_dop853():
    """A crank that runs freely with its flywheel while a force pulls the rod aside."""
    press, elastic = rssp(), springs(rssp(), 2e6, PINS)
    drive, flywheel, until = pp.drives.ConstantTorque(20.0), pp.drives.Flywheel(5.0), 0.005
    loads = [pp.loads.PointForce("rod", (300.0, 500.0, 0.0), (0.0, 0.0, -0.2))]
    run = simulated(press, until, speed=SPEED, drive=drive, flywheel=flywheel, loads=loads, elastic=elastic, tolerance=1e-7)
    solution = run.trajectory.segments[0].solution
    equations, size = solution.equations, solution.equations.size

    def rates(time, state):
        y, v, time, still = state[None, :size], state[None, size:], np.array([time]), np.zeros((1, size))
        at = equations.linearised(time, y, v, still, np.zeros(1, dtype=int))
        return np.concatenate([v[0], np.linalg.solve(at.mass[0], at.left[0])])

    found = solve_ivp(rates, (0.0, until), solution.panels.states[0], "DOP853", rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(solution.panels.states[-1, :size], found.y[:size, -1], rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"moments": dict.fromkeys(PINS[:2], 1e8)}, "lacks 'B', 'slide_guide'"),
        ({"bearings": {"O": 1e9}}, "lacks 'B_cross', 'B', 'slide_guide', 'S'"),
        ({"moments": dict.fromkeys((*PINS, "S"), 1e8)}, "'S', which is a ball joint"),
        ({"shaft": 1e6}, "in space knows no shaft"),
    ],
)
def test_stiffnesses_that_a_press_in_space_lacks_are_named(change, words):
    press = rssp()
    given = {"bearings": dict.fromkeys(press.bearings, 1e9), "moments": dict.fromkeys(PINS, 1e8), **change}
    with pytest.raises(pp.PinpressError, match=words):
        stroke(press, SPEED, pp.elasticity.Elastic(pp.elasticity.Stiffness(**given)))


# ------------------------------------------------------------------------------------------------------------------ joints that open

GIBS = pp.elasticity.PreloadedJoint(5e7, 5e7, 1e3)  # N/m, N


def with_gibs(press, gibs, pins, stiffness=1e8, **more):
    bearings = dict.fromkeys(press.bearings, stiffness) | {"slide_guide": gibs}
    return pp.elasticity.Elastic(pp.elasticity.Stiffness(bearings, moments=dict.fromkeys(pins, 0.1 * stiffness)), **more)


@pytest.mark.exhaustive
@pytest.mark.parametrize("until", [0.021, 0.06])
def test_gibs_of_a_planar_press_open_in_space_as_in_its_plane(monkeypatch, until):
    """Blanking opens them: instants, loads and forces of the planar equations; across the plane nothing opens."""
    press, held = shipped("crank_slide"), pp.drives.PrescribedSpeed(2.0)
    given = {"speed": 2.0, "angle": 5.865, "drive": held, "loads": [pp.loads.Blanking(3e4, 0.02, 0.01)], "points": 41, "tolerance": 1e-6}
    plane = simulated(press, until, elastic=with_gibs(press, GIBS, ["slide_guide"], damping_ratio=0.1), **given)
    monkeypatch.setattr(assembly, "press_in_plane", press_in_space)
    space = simulated(press, until, elastic=with_gibs(press, GIBS, press.joints, damping_ratio=0.1), **given)
    assert len(plane.events) >= 3
    np.testing.assert_allclose(space.events, plane.events, rtol=0, atol=1e-7)
    in_plane, across = (space.joint_load[f"slide_guide {axis}"] for axis in "xy")
    load = plane.joint_load["slide_guide"]
    assert np.abs(load).max() > GIBS.opening_load
    np.testing.assert_allclose(np.abs(in_plane), np.abs(load), rtol=0, atol=1e-5 * np.abs(load).max())
    assert np.abs(across).max() < 1e-6
    for name in press.bearings:
        size = np.abs(plane.bearing_force[name]).max()
        np.testing.assert_allclose(space.bearing_force[name], plane.bearing_force[name], rtol=0, atol=1e-5 * size)
    assert space.stats.energy_error < 1e-9
    assert space.lost[-1] == pytest.approx(plane.lost[-1], rel=1e-5)


@cache
def pushed_aside(gibs):
    """A rod in space, whose slide a force pushes aside in both directions across its guide, beginning at once."""
    loads = [pp.loads.PointForce("slide", (3e3, 4e3, 0.0), (0.0, 0.0, 0.0))]
    elastic = with_gibs(rssp(), gibs, PINS, damping_ratio=0.05)
    return simulated(rssp(), 0.01, speed=SPEED, drive=pp.drives.PrescribedSpeed(SPEED), elastic=elastic, loads=loads, points=21)


@pytest.mark.exhaustive
def test_gibs_that_stay_closed_are_a_number():
    tight, plain = pushed_aside(pp.elasticity.PreloadedJoint(5e7, 5e7, 1e6)), pushed_aside(1e8)
    np.testing.assert_allclose(tight.slide_position, plain.slide_position, rtol=0, atol=1e-12)
    for name in rssp().bearings:
        np.testing.assert_allclose(tight.bearing_force[name], plain.bearing_force[name], rtol=0, atol=1e-3)
    assert not tight.events


@pytest.mark.exhaustive
def test_gibs_open_in_both_directions_and_leave_one_with_all():
    run = pushed_aside(GIBS)
    loads = np.array([run.joint_load[f"slide_guide {axis}"] for axis in "xy"])
    force = run.bearing_force["slide_guide"]
    np.testing.assert_allclose(np.abs(loads.T), np.abs(force[:, :2]), rtol=0, atol=1e-6 * np.abs(force).max())
    assert (np.abs(loads).min(axis=1) > GIBS.opening_load).all()
    assert run.stats.energy_error < 1e-9
    sums = [GIBS.forces(load) for load in loads]
    assert all((np.minimum(*each) == 0).all() for each in sums)


def test_a_pin_in_space_has_no_joint_that_opens():
    press = rssp()
    stiffness = pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 1e8) | {"O": GIBS}, moments=dict.fromkeys(PINS, 1e7))
    with pytest.raises(pp.PinpressError, match="'O' is a PreloadedJoint, which a guide has across its axis alone"):
        stroke(press, SPEED, pp.elasticity.Elastic(stiffness))
