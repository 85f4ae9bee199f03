"""Elastic motion in its limits: quasi-static formulas, closed forms, and Exudyn with bodies of its own."""

import numpy as np
import pytest
from extremes.extreme_crank_slide import CrankSlider
from scipy.optimize import brentq
from support.oracles.end_on_springs import end_of
from support.presses.presses_on_springs import stiffness_of
from support.texts import shipped

import pinpress as pp
from pinpress.simulation.driven_press import driven_press
from pinpress.simulation.elastic import period
from pinpress.simulation.elastic.equations import ElasticEquations, HeldCrank
from pinpress.simulation.elastic.march import march
from pinpress.simulation.elastic.press.assembly import sprung_press
from pinpress.simulation.elastic.press.paths import load_path
from pinpress.simulation.elastic.strokes import Strokes
from pinpress.simulation.elastic.task import Task

SPEED = 300 * pp.RPM


@pytest.mark.exhaustive
def test_break_through_of_a_slide_between_light_links():
    """The snap-through of `elasticity` is the elastic motion of a slow press with light links: the slide swings about its rigid place."""
    links = CrankSlider(crank_mass=5e-5, rod_mass=5e-5, crank_inertia=1e-6, rod_inertia=1e-6, gravity=0.0)
    press, force, end, ratio = links.press(), 2e4, 0.004, 0.04
    mass, held = links.slide_mass, {"slide_guide": 1e13}  # a guide that yields would swing with it
    stiffness = pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 1e9) | held, moments=held)
    begin = end + 1e-7  # of the rigid press: the slide on its springs stands higher by the force
    angle = brentq(lambda angle: links.slide(angle) - links.slide(0.0) - begin, -1.0, 0.0)
    run = pp.simulate(
        press,
        0.7,
        angle=angle,
        drive=pp.drives.PrescribedSpeed(0.003),
        loads=[pp.loads.Blanking(force, end + 0.002, end)],
        elastic=pp.elasticity.Elastic(stiffness, damping_ratio=ratio),
        points=20001,
    )
    assert isinstance(run, pp.ElasticRun)
    ((broken, there, _),) = run.events
    spring, lowest = 1 / pp.elasticity.compliance(press, stiffness, angle=[there, 0.0]).compliance
    own = ratio * np.sqrt(spring / lowest)  # dampers go with the springs: the damping ratio is that of bottom dead centre
    swings = (run.slide_position - run.rigid_slide_position)[run.time > broken]
    least = int(swings.argmin())
    bend, slope, middle = np.polyfit([-1.0, 0.0, 1.0], swings[least - 1 : least + 2], 2)
    lowest_place = middle - slope**2 / (4 * bend)  # between the states
    found = pp.elasticity.snap_through(force, spring, mass=mass, damping_ratio=own)
    closed = np.exp(-own * np.pi / np.sqrt(1 - own**2))
    assert found.reverse_force / force == pytest.approx(closed, rel=1e-12)
    assert -lowest_place * spring / force == pytest.approx(closed, rel=5e-6)


@pytest.mark.parametrize("ratio", [0.0, 1e-3])
def test_decay_of_a_slow_press(monkeypatch, ratio):
    """A turn of very many vibrations is not followed through all of them: each crank angle damps as it would by itself."""
    press, speed = shipped("jf75g_125_plain"), 3.0
    elastic = pp.elasticity.Elastic(stiffness_of(press, 2e9), damping_ratio=ratio)

    def decay(speed):
        return pp.steady_state(press, speed, drive=pp.drives.PrescribedSpeed(speed), elastic=elastic).decay_per_stroke

    followed = decay(speed)
    monkeypatch.setattr(period, "MOST_PARTS", 0)
    assert decay(speed) == pytest.approx(followed, rel=2e-5)
    monkeypatch.undo()
    assert decay(1e-4) == (0.0 if ratio else 1.0)  # one turn in 17 hours: it would be followed through 3e7 vibrations


def test_bottom_dead_centre_over_the_speed():
    """The deepest point of an idle stroke comes to that of `dead_centre_shift`, with the inverse of the stiffness."""
    press = shipped("jf75g_125_plain")
    bottom, off = pp.dead_centres(press).bottom_position, []
    for stiffness in (4e10, 8e10):
        elastic = pp.elasticity.Elastic(stiffness_of(press, stiffness))
        run = pp.steady_state(press, SPEED, drive=pp.drives.PrescribedSpeed(SPEED), elastic=elastic, points=37)
        assert isinstance(run, pp.ElasticRun)
        found = pp.elasticity.dead_centre_shift(press, elastic.stiffness, speed=[SPEED])
        off.append((run.deepest - bottom) / (float(found.position[0]) - bottom) - 1)
    assert abs(off[1]) < 2e-3
    assert off[0] / off[1] == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize(
    ("how", "bound"),
    [
        pytest.param({"tolerance": 1e-7}, 1e-6, id="explicit"),
        pytest.param({"steps": 20000}, 3e-6, id="implicit", marks=pytest.mark.exhaustive),  # of order two, in twenty times the time
        pytest.param({"steps": 80000}, 3e-7, id="implicit, 80 000 steps", marks=pytest.mark.exhaustive),
    ],
)
def test_exudyn_rings_alike(how, bound):
    """The springs ring over half a stroke from a pose in which they are slack; bodies, springs and integrators are Exudyn's own."""
    pytest.importorskip("exudyn")
    from support.oracles.exudyn_on_springs import ExudynOnSprings, Setting

    press = shipped("jf75g_125_plain")
    start, until = pp.dead_centres(press).bottom_angle - np.pi, np.pi / SPEED
    sprung = sprung_press(press, pp.elasticity.Elastic(stiffness_of(press, 2e9)))
    driven = driven_press(press, pp.drives.PrescribedSpeed(SPEED), None, [], None, None)
    paths = tuple(load_path(sprung, coordinate) for coordinate in driven.coordinates)
    equations = ElasticEquations(sprung, driven, paths, HeldCrank(start, SPEED), segments=((),))
    place, rates, _ = sprung.geometry.rigid(pp.servo_cycle(press, angle=[start], speed=SPEED))
    state = np.concatenate([sprung.free_coordinates(place)[0, :-1], sprung.free_rates(rates)[0, :-1]])
    task = Task(equations, Strokes(driven, 1), None, 2 * until, SPEED, np.zeros(len(state)), 1e-10)
    found = march(task, start, state, until)
    own = end_of(found, equations.state(np.array([until]), *np.split(found.panels.states[-1:], 2, axis=1)))
    other = end_of(found, ExudynOnSprings(found, until).run(Setting("", **how)))
    largest = np.abs(own.force).max()
    assert largest > 1e4
    np.testing.assert_allclose(other.force, own.force, rtol=0, atol=bound * largest)
