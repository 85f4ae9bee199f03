"""Pins with clearance: contact laws against bouncing balls, and runs against energy and DOP853."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.texts import shipped

import pinpress as pp
from pinpress.simulation.elastic import contact
from pinpress.simulation.elastic.press.friction import bodies_of
from pinpress.simulation.elastic.run import ElasticSegment
from pinpress.simulation.elastic.states import journal_places
from pinpress.simulation.elastic.strokes import Event

SPEED = 300 * pp.RPM


def restitution_of_linear(ratio: float) -> float:
    """Restitution of a linear contact with a damping ratio, which ends where its force vanishes [-].

    With w the frequency without damping, the force N = k d + b d' first vanishes after the time t with tan(w' t) = 2 z s / (2 z^2 - 1), s =
    sqrt(1 - z^2), w' = s w.
    """
    s = math.sqrt(1 - ratio**2)
    phase = math.atan2(2 * ratio * s, 2 * ratio**2 - 1)
    return math.exp(-ratio / s * phase)


@pytest.mark.parametrize(("restitution", "factor"), [(0.9, 0.16648195), (0.7, 0.63482828), (0.5, 1.43275053)])
def test_damping_factor(restitution, factor):
    """Printed values of an independent solution of the condition of the module."""
    assert contact.damping_factor(restitution) == pytest.approx(factor, abs=5e-9)


@pytest.mark.parametrize(("ratio", "restitution"), [(0.02, 0.939841), (0.05, 0.858758), (0.1, 0.744079)])
def test_restitution_of_a_linear_contact(ratio, restitution):
    assert restitution_of_linear(ratio) == pytest.approx(restitution, abs=5e-7)


def bounced(law, mass, speed):
    """Speed after a ball of this mass has struck a contact, by DOP853 until its force vanishes."""

    def rates(t, state):
        return [state[1], -float(law.force(-state[0], -state[1])) / mass]

    def parted(t, state):
        return float(law.force(-state[0], -state[1])) if t > 0 else 1.0

    parted.terminal, parted.direction = True, -1  # type: ignore[attr-defined]
    found = solve_ivp(rates, (0.0, 1.0), [0.0, speed], "DOP853", events=parted, rtol=1e-11, atol=1e-14, first_step=1e-9, max_step=1e-4)
    return -found.y[1, -1]


def pin(clearance, stiffness=1e9, damping=0.0):
    return contact.OpenPin(0, (0, 1), (0j, 0j), clearance, stiffness, damping)


@pytest.mark.parametrize("restitution", [0.9, 0.5])
@pytest.mark.parametrize(("mass", "speed"), [(10.0, 0.5), (0.2, 3.0)])
def test_a_ball_bounces_with_the_restitution_asked_for(restitution, mass, speed):
    law = pin(contact.Clearance(1e-4, "hertz", restitution, 1e10)).contact().struck(speed)
    assert bounced(law, mass, speed) == pytest.approx(restitution * speed, rel=1e-6)


def test_a_ball_bounces_on_a_linear_contact():
    mass, stiffness, ratio = 10.0, 1e9, 0.05
    law = pin(contact.Clearance(1e-4), stiffness, 2 * ratio * math.sqrt(stiffness * mass)).contact()
    assert bounced(law, mass, 0.5) == pytest.approx(0.5 * restitution_of_linear(ratio), rel=1e-6)


def elastic(press, stiffness=2e9, **clearances):
    springs = pp.elasticity.Stiffness(dict.fromkeys(press.bearings, stiffness), moments={"slide_guide": 0.1 * stiffness})
    return pp.elasticity.Elastic(springs, clearances=clearances)


def run(clearance, duration=0.2, points=241, **more):
    press = shipped("jf75g_125_plain")
    return pp.simulate(press, duration, drive=pp.drives.PrescribedSpeed(SPEED), elastic=elastic(press, P4=clearance), points=points, **more)


@pytest.mark.exhaustive
@pytest.mark.parametrize("clearance", [pp.elasticity.Clearance(1e-4), pp.elasticity.Clearance(5e-5, "hertz", 0.7, 1e11)])
def test_energy_of_a_turn_with_clearance(clearance):
    found = run(clearance)
    assert found.stats.energy_error < 1e-9
    solution = found.trajectory.segments[0].solution
    states = found.trajectory.segments[0].states(found.time)
    sprung = solution.equations.sprung
    gap = np.abs(journal_places(sprung, sprung.open_pins[0], states.bodies))
    force = np.linalg.norm(found.bearing_force["P4"], axis=1)
    assert gap.max() > clearance.radial
    assert gap.min() < clearance.radial  # it flies
    assert (force[gap < clearance.radial] == 0).all()
    assert len(found.events) >= 4


def test_small_clearance_changes_little_where_the_pin_is_always_pressed():
    """Near bottom dead centre, from rest on its bearing, the journal follows the force: the slide stands lower by the clearance."""
    press, clearance = shipped("jf75g_125_plain"), 1e-5
    bottom, drive = pp.dead_centres(press).bottom_angle, pp.drives.PrescribedSpeed(SPEED)
    ends = [
        pp.simulate(press, 0.01, angle=bottom - 0.15, drive=drive, elastic=elastic(press, **pins), points=31)
        for pins in ({}, {"P4": pp.elasticity.Clearance(clearance)})
    ]
    lower = ends[0].slide_position - ends[1].slide_position
    np.testing.assert_allclose(lower, clearance, rtol=0.02)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"radial": 5.0}, "in m"),
        ({"radial": 1e-4, "law": "flores"}, "'linear', 'hertz'"),
        ({"radial": 1e-4, "restitution": 0.5}, "restitution belongs to the law 'hertz'"),
        ({"radial": 1e-4, "law": "hertz", "restitution": 0.5}, "hertz_stiffness belongs"),
        ({"radial": 1e-4, "law": "hertz", "restitution": 1.5, "hertz_stiffness": 1e10}, "at most 1"),
    ],
)
def test_clearances_that_make_no_sense_are_refused(given, message):
    with pytest.raises(pp.PinpressError, match=message):
        pp.elasticity.Clearance(**given)


def test_a_steady_state_with_clearance_is_refused():
    press = shipped("jf75g_125_plain")
    with pytest.raises(pp.PinpressError, match="no steady state"):
        pp.steady_state(press, SPEED, drive=pp.drives.PrescribedSpeed(SPEED), elastic=elastic(press, P4=pp.elasticity.Clearance(1e-4)))


@pytest.mark.exhaustive
def test_impacts_turn_by_turn():
    """Peaks of the turns are those of the run; the motion has settled into no cycle, so that only its statistics mean anything."""
    clearance = pp.elasticity.Clearance(1e-4)
    found = run(clearance, duration=0.6)
    impacts = pp.elasticity.journal_impacts(found, "P4")
    assert impacts.turn.tolist() == [0, 1, 2]
    assert impacts.peak.max() == pytest.approx(found.peaks["P4"], rel=1e-3)
    assert (np.hypot(*impacts.orbit.T).max() - 1e-4) == pytest.approx(impacts.depth.max(), rel=1e-12)
    assert (impacts.impacts >= 1).all()
    assert ((impacts.flight > 0) & (impacts.flight < 1)).all()
    begun = pp.elasticity.journal_impacts(run(clearance, duration=0.37), "P4")  # what follows the last whole turn is no part of it
    assert begun.turn.tolist() == [0]
    assert begun.peak[0] == pytest.approx(impacts.peak[0], rel=1e-6)
    assert begun.flight[0] == pytest.approx(impacts.flight[0], rel=1e-6)
    press = shipped("jf75g_125_plain")
    many = pp.elasticity.impact_statistics(press, elastic(press, P4=clearance), "P4", speed=SPEED, turns=2, settling=1, starts=2)
    assert many.start.tolist() == [0, 0, 1, 1]
    assert many.spread > 1e-3


@pytest.mark.exhaustive
def test_turns_are_those_of_the_crank_where_its_speed_changes():
    """A torque speeds it up to four times its first speed, with which the run would have half a turn."""
    press, pins = shipped("jf75g_125_plain"), {"P4": pp.elasticity.Clearance(1e-4)}
    drive, flywheel = pp.drives.ConstantTorque(300.0), pp.drives.Flywheel(5.0)
    found = pp.simulate(press, 0.6, speed=0.3 * SPEED, drive=drive, flywheel=flywheel, elastic=elastic(press, **pins), points=2001)
    assert isinstance(found, pp.ElasticRun)
    impacts = pp.elasticity.journal_impacts(found, "P4")
    first = found.crank_angle - found.crank_angle[0] < 2 * np.pi
    assert impacts.turn.tolist() == [0]
    assert impacts.peak[0] == pytest.approx(np.linalg.norm(found.bearing_force["P4"][first], axis=1).max(), rel=1e-3)


@pytest.mark.exhaustive
def test_clearance_of_a_pin_on_the_crank():
    """The crank goes its own way while the journal flies; at every event the journal is as far from the centre as the clearance."""
    press, pins = shipped("jf75g_125_plain"), {"O": pp.elasticity.Clearance(1e-4)}
    drive = pp.drives.PrescribedSpeed(SPEED)
    found = pp.simulate(press, 0.04, angle=2.0, drive=drive, elastic=elastic(press, **pins), points=61)
    assert found.stats.energy_error < 1e-9
    segment = found.trajectory.segments[0]
    assert isinstance(segment, ElasticSegment)
    sprung, events = segment.solution.equations.sprung, segment.solution.equations.events
    mesh = segment.solution.panels.mesh
    times = [mesh.knots[knot] for knot, event in (events or {}).items() if isinstance(event, Event)]
    assert times
    states = segment.states(np.array(times))
    gap = np.abs(journal_places(sprung, sprung.open_pins[0], states.bodies))
    np.testing.assert_allclose(gap, 1e-4, rtol=0, atol=1e-11)


def test_wear_goes_with_force_and_way():
    """By hand: volume = k / H sum of force x way, over the surface of the bearing."""
    press = shipped("jf75g_125_plain")
    steady = pp.steady_state(press, SPEED, drive=pp.drives.PrescribedSpeed(SPEED), elastic=elastic(press), points=721)
    assert isinstance(steady, pp.ElasticRun)
    depth = pp.elasticity.wear_depth(steady, "P4", radius=0.05, width=0.1, hardness=1e9, coefficient=1e-7)
    rods = press.joints.index("P2")  # the rod turns against crank and slide; its absolute angle is that of crank and P2
    spin = steady.v[:, press.joints.index("O")] + steady.v[:, rods]
    force = np.linalg.norm(steady.bearing_force["P4"], axis=1)
    volume = 1e-7 / 1e9 * np.trapezoid(force * np.abs(spin) * 0.05, steady.time)
    assert depth == pytest.approx(volume / (2 * np.pi * 0.05 * 0.1) / 0.2 * 3600, rel=1e-3)


@pytest.mark.exhaustive
def test_wear_by_short_impacts():
    """Next to 400 000 even times, whose steps are a thousandth of an impact. Even times of ordinary number would miss impacts."""
    press = shipped("jf75g_125_plain")
    found = run(pp.elasticity.Clearance(1e-4), duration=0.2)
    sizes = {"radius": 0.05, "width": 0.1, "hardness": 1e9, "coefficient": 1e-7}
    segment = found.trajectory.segments[0]
    assert isinstance(segment, ElasticSegment)
    way = force = np.zeros(0)
    times = np.linspace(0.0, segment.end, 400_001)
    for part in np.array_split(times, 40):
        states = segment.states(part)
        rates = states.bodies.rates
        force = np.append(force, np.linalg.norm(states.forces.in_bearings[press.bearings.index("P4")], axis=1))
        first, second = bodies_of(segment.solution.equations.sprung, press.bearings.index("P4"))
        way = np.append(way, np.abs(rates[:, 3 * second + 2] - rates[:, 3 * first + 2]) * 0.05)
    volume = 1e-7 / 1e9 * np.trapezoid(force * way, times)
    expected = volume / (2 * np.pi * 0.05 * 0.1) / segment.end * 3600
    assert pp.elasticity.wear_depth(found, "P4", **sizes) == pytest.approx(expected, rel=1e-4)
