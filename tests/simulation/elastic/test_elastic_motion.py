"""Presses on springs: against independently computed strokes, the rigid limit, energy, and the order of the collocation."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.presses.presses_on_springs import stiffness_of
from support.texts import shipped

import pinpress as pp
from pinpress.common.numerics import radau_rule
from pinpress.simulation.elastic import panels
from pinpress.simulation.elastic.press.assembly import sprung_press
from pinpress.simulation.elastic.press.sprung_press import SprungPress

JF75G, SIX_BAR = ("jf75g_125_plain", 300.0), ("zxn2_3000b", 70.0)
BLANKING = {"jf75g_125_plain": pp.loads.Blanking(1.25e6, 0.010, 0.005), "zxn2_3000b": pp.loads.Blanking(2e6, 0.010, 0.006)}


@cache
def stroke(name, rpm, stiffness=2e9, loaded=True, points=361, **more):
    press, speed = shipped(name), rpm * pp.RPM
    elastic = pp.elasticity.Elastic(stiffness_of(press, stiffness))
    loads = [BLANKING[name]] if loaded else []
    return pp.steady_state(press, speed, drive=pp.drives.PrescribedSpeed(speed), loads=loads, elastic=elastic, points=points, **more)


# The same presses, loads and springs in a program of its own, with seven and with eight collocation points: they agree to 4e-10 in the
# forces. Depth beside the rigid bottom dead centre [um], crank angles from there [deg], forces [N], works [J].
REFERENCE = [
    (
        *JF75G,
        -1643.1889,
        -5.4,
        (-69.25835, -36.69391),
        {"O": 1303074.8, "P2": 1292157.7, "P4": 1261977.9},
        (5256.46962, 3978.87358, 1277.59604),
    ),
    (
        *SIX_BAR,
        -1949.6454,
        -11.5,
        (-48.34404, -33.56629),
        {"A": 599454.7, "D": 1906926.6, "E": 2038080.0, "F": 2032259.9},
        (7760.26462, 5092.95818, 2667.30644),
    ),
]


@pytest.mark.parametrize(("name", "rpm", "depth", "angle", "events", "peaks", "works"), REFERENCE)
def test_blanking_against_another_program(name, rpm, depth, angle, events, peaks, works):
    run, bottom = stroke(name, rpm), pp.dead_centres(shipped(name))
    assert 1e6 * (run.deepest - bottom.bottom_position) == pytest.approx(depth, abs=1e-3)
    beside = [np.degrees(at - bottom.bottom_angle + np.pi) % 360 - 180 for at in (run.deepest_angle, *(at for _, at, _ in run.events))]
    assert beside[0] == pytest.approx(angle, abs=0.06)
    np.testing.assert_allclose(beside[1:], events, rtol=0, atol=1e-5)
    for bearing, peak in peaks.items():
        assert run.peaks[bearing] == pytest.approx(peak, rel=3e-6), bearing
    np.testing.assert_allclose([run.drive_work[-1], run.load_work[-1], run.lost[-1]], works, rtol=0, atol=6e-6)  # as printed


def test_decay_is_that_of_the_lowest_vibration():
    """Between the strokes the lowest vibration decays as exp(-zeta w T); its frequency changes a little along the turn."""
    press = shipped(JF75G[0])
    lowest = sprung_press(press, pp.elasticity.Elastic(stiffness_of(press))).lowest_frequency
    assert lowest / (2 * np.pi) == pytest.approx(86.814, abs=1e-3)
    assert stroke(*JF75G, loaded=False).decay_per_stroke == pytest.approx(np.exp(-0.02 * lowest * 0.2), rel=0.01)


@pytest.mark.parametrize(
    ("name", "rpm"), [JF75G, SIX_BAR, ("thin_wall", 40.0), ("jf75g_125_symmetric", 300.0), ("jf75g_125_two_point", 300.0)]
)
def test_stiffer_springs_lead_to_the_rigid_press(name, rpm):
    """What is left of the rigid press's forces, torque and motion goes with 1 / stiffness."""
    press = shipped(name)
    rigid = pp.inverse_dynamics(press, pp.cycle(press, rpm * pp.RPM, points=36))
    errors = []
    for stiffness in (5e8, 1e9) if name == "thin_wall" else (2e10, 4e10):  # a light press: rounding of its places is force
        run = stroke(name, rpm, stiffness, loaded=False, points=37)
        force = max(
            np.abs(run.bearing_force[bearing][:-1, [0, 2]] - rigid.bearing_force[bearing][:, [0, 2]]).max() for bearing in press.bearings
        )
        torque = np.abs(run.drive_torque[:-1] - rigid.driving_torque).max() / np.abs(rigid.driving_torque).max()
        shaking = np.abs(run.shaking_force[:-1] - rigid.shaking_force).max()
        errors.append((force, torque, shaking, np.abs(run.displacement).max()))
    order = np.log2(np.divide(*errors))
    np.testing.assert_allclose(order, 1.0, atol=0.02)
    assert errors[1][1] < 2e-3


@pytest.mark.exhaustive
def test_work_of_the_drive_is_that_of_loads_and_losses():
    for run in (stroke(*JF75G), stroke(*SIX_BAR)):
        assert run.stats.energy_error < 1e-10
        assert abs(run.drive_work[-1] - run.load_work[-1] - run.lost[-1]) < 1e-10 * run.drive_work[-1]


@pytest.mark.exhaustive
def test_marched_strokes_come_to_the_steady_one():
    press, speed, steady = shipped(JF75G[0]), JF75G[1] * pp.RPM, stroke(*JF75G, points=121)
    elastic, drive = steady.elastic, pp.drives.PrescribedSpeed(speed)
    run = pp.simulate(press, 1.0, drive=drive, loads=[BLANKING[press.name]], elastic=elastic, points=601)
    assert run.stats.energy_error < 1e-10
    beside = [np.abs(run.slide_position[120 * k : 120 * k + 121] - steady.slide_position).max() for k in range(5)]
    np.testing.assert_allclose(np.divide(beside[3:], beside[2:-1]), steady.decay_per_stroke, rtol=0.02)


def test_the_start_rings_no_bell():
    """An idle run from its start, at which the springs carry the rigid motion's forces, stays beside the steady state."""
    press, speed, steady = shipped(JF75G[0]), JF75G[1] * pp.RPM, stroke(*JF75G, loaded=False, points=121)
    run = pp.simulate(press, 0.2, drive=pp.drives.PrescribedSpeed(speed), elastic=steady.elastic, points=121)
    assert np.abs(run.slide_position - steady.slide_position).max() < 0.02 * np.abs(steady.displacement).max()
    assert run.trajectory.fastest == pytest.approx(np.abs(run.crank_speed).max(), rel=1e-3)


@pytest.mark.parametrize("stages", [2, 3, 4])
def test_order_of_the_collocation(stages, monkeypatch):
    """2 s - 1 at the borders of the panels, on a smooth stroke."""
    run = stroke(*JF75G, stiffness=2e7, loaded=False)
    found = run.trajectory.segments[0].solution
    gain, errors = found.gain, []
    for count in (40, 80):
        borders = np.arange(count + 1) / count
        mesh = panels.Mesh(found.panels.mesh.knots, np.zeros(count, dtype=int), borders[:-1], borders[1:])
        rule = radau_rule(stages)
        y, v, _ = found.panels.at(mesh.borders)
        _, _, a = found.panels.at((mesh.start[:, None] + mesh.length[:, None] * rule.points).ravel() - 1e-15)
        guess = panels.PanelSolution(
            mesh, rule, np.concatenate([y, v], axis=1), a.reshape(count, stages, -1), np.inf, 0, np.eye(2 * y.shape[1])
        )
        coarse = panels.solve(found.equations, guess, panels.Ends(True, gain, []), 1e-13, 9)
        errors.append(np.abs(coarse.states - guess.states)[:, : y.shape[1]].max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2 * stages - 1, abs=0.5)


def test_derivatives_of_the_forces():
    """Closed-form Jacobians against differences, with a crown, a twisting shaft and rods."""
    press, rng = shipped(SIX_BAR[0]), np.random.default_rng(1)
    stiffness = replace(stiffness_of(press), frame=4e9, shaft=3e7)
    sprung = sprung_press(press, pp.elasticity.Elastic(stiffness, crown_mass=5000.0, damping_ratio=0.1))
    place, _, _ = sprung.geometry.rigid(pp.servo_cycle(press, angle=[0.3, 2.0, 4.0], speed=1.0))
    free = sprung.free_coordinates(place) + 1e-3 * rng.normal(size=(3, sprung.free))
    rates = rng.normal(size=free.shape)
    at = sprung.spring_forces(sprung.state(free, rates))
    for given, by_rate in ((at.stiffness, False), (at.damping, True)):
        for k in range(sprung.free):
            step = 1e-6 * np.eye(sprung.free)[k]
            ends = [
                sprung.spring_forces(sprung.state(free + (0 if by_rate else s) * step, rates + (s if by_rate else 0) * step), False).force
                for s in (1, -1)
            ]
            np.testing.assert_allclose(given[:, :, k], (ends[1] - ends[0]) / 2e-6, rtol=0, atol=1e-7 * np.abs(given).max())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"elastic": pp.elasticity.Elastic(pp.elasticity.Stiffness({"O": 1e9}))}, "lacks 'P2', 'slide_guide', 'P4'"),
        ({"elastic": 2e9}, "give an Elastic"),
        ({"drive": pp.drives.ConstantTorque(10.0)}, "no steady state"),
        ({"drive": pp.drives.PrescribedSpeed(1.0)}, "prescribes 1"),
    ],
)
def test_steady_states_that_cannot_be_are_refused(change, message):
    press, speed = shipped(JF75G[0]), 31.4
    given = {"drive": pp.drives.PrescribedSpeed(speed), "elastic": pp.elasticity.Elastic(stiffness_of(press))} | change
    with pytest.raises(pp.PinpressError, match=message):
        pp.steady_state(press, speed, **given)


def test_decay_where_the_stroke_is_smooth():
    """An idle stroke at low speed takes few panels, on which its vibrations are not resolved; its decay is that of the lowest vibration."""
    press, speed = shipped(JF75G[0]), 100 * pp.RPM
    elastic = pp.elasticity.Elastic(stiffness_of(press))
    run = pp.steady_state(press, speed, drive=pp.drives.PrescribedSpeed(speed), elastic=elastic)
    lowest = pp.elasticity.natural_frequencies(press, elastic, angle=np.linspace(0, 2 * np.pi, 180, endpoint=False)).natural_frequency[:, 0]
    assert isinstance(run, pp.ElasticRun)
    assert run.decay_per_stroke == pytest.approx(np.exp(-0.02 * np.mean(lowest**2) / 545.47 * 0.6), rel=0.05)


@pytest.mark.parametrize("given", [{"method": "constraint"}, {"step": 1e-3}])
def test_methods_and_steps_of_rigid_motions_are_refused(given):
    press = shipped(JF75G[0])
    with pytest.raises(pp.PinpressError, match="method and steps of its own"):
        pp.simulate(press, 0.1, drive=pp.drives.PrescribedSpeed(31.4), elastic=pp.elasticity.Elastic(stiffness_of(press)), **given)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("height", [0.001, 0.003, 0.006])
def test_a_run_that_begins_on_the_way_up_is_stripped_from_where_it_begins(height):
    """Below the blank, within it and above it: force times the way that is left in it. On the way up a blank is not cut."""
    press, speed = shipped("jf75g_125_plain"), JF75G[1] * pp.RPM
    bottom = pp.dead_centres(press).bottom_position
    way = pp.cycle(press, speed)
    up = way.slide_velocity > 0
    angle = np.interp(height, way.slide_position[up] - bottom, way.crank_angle[up])
    run = pp.simulate(
        press,
        0.03,
        speed=speed,
        angle=angle,
        drive=pp.drives.PrescribedSpeed(speed),
        loads=[pp.loads.Blanking(6e5, 0.004, 0.002, stripping=3e4)],
        elastic=pp.elasticity.Elastic(stiffness_of(press)),
        tolerance=1e-4,
    )
    begun, ended = run.slide_position[[0, -1]] - bottom
    assert ended > 0.004
    assert run.load_work[-1] == pytest.approx(3e4 * np.clip(0.004 - max(begun, 0.002), 0.0, None), abs=1e-6)


@pytest.mark.parametrize("share", [0.0, 1e-3])
def test_a_force_that_no_energy_has_is_refused(monkeypatch, share):
    """A thousandth of the largest weight, which acts on a link beside all that has a work: no run comes out of which more energy is missing
    than the tolerance allows."""
    press, spring_forces = shipped(JF75G[0]), SprungPress.spring_forces

    def with_a_wrong_one(sprung, state, derivatives=True):
        forces = spring_forces(sprung, state, derivatives)
        forces.force[:, 0] += share * np.abs(sprung.free_weight).max()
        return forces

    monkeypatch.setattr(SprungPress, "spring_forces", with_a_wrong_one)
    given = {"drive": pp.drives.PrescribedSpeed(300 * pp.RPM), "elastic": pp.elasticity.Elastic(stiffness_of(press)), "points": 11}
    if not share:
        assert pp.simulate(press, 0.01, **given).stats.energy_error < 1e-9
        return
    with pytest.raises(pp.SimulationError, match="the energy does not balance"):
        pp.simulate(press, 0.01, **given)
