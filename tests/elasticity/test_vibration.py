"""Vibrations of presses on springs: against Castigliano's compliance, closed forms, and the shapes of the equations."""

from dataclasses import replace

import numpy as np
import pytest
from support.texts import shipped

import pinpress as pp
from pinpress.elasticity import Elastic, Rod, Stiffness, natural_frequencies
from pinpress.simulation.driven_press import driven_press
from pinpress.simulation.elastic.press.assembly import sprung_press
from pinpress.simulation.elastic.press.paths import load_path

ANGLES = np.array([0.1, 1.3, 2.2, 3.6, 5.1])


def stiffness_of(press, value=2e9, **more):
    guides = [joint for joint, axis in zip(press.joints, press.axes, strict=True) if not axis.turns]
    return Stiffness(dict.fromkeys(press.bearings, value), moments=dict.fromkeys(guides, 0.1 * value), **more)


@pytest.mark.parametrize(
    ("name", "rods"),
    [
        ("crank_slide", [Rod("rod", ("P", "W"), 7e8)]),
        ("zxn2_3000b", [Rod("rod", ("E", "F"), 7e8), Rod("rocker", ("D", "E"), 9e8)]),
        ("jf75g_125", []),
    ],
)
def test_all_modes_together_yield_as_castigliano_says(name, rods):
    """Under a static force every mode moves by its share over its squared frequency: their sum is the compliance by virtual work."""
    press = shipped(name)
    stiffness = stiffness_of(press, rods=rods, shaft=3e7, frame=4e9)
    elastic = Elastic(stiffness, crown_mass=5000.0)
    modes = natural_frequencies(press, elastic, angle=ANGLES)
    sprung = sprung_press(press, elastic)
    driven = driven_press(press, pp.drives.PrescribedSpeed(1.0), None, [pp.loads.ConstantForce(1e5, 0.01)], None, None, {})
    path = load_path(sprung, driven.coordinates[0])
    place, _, _ = sprung.geometry.rigid(pp.servo_cycle(press, angle=ANGLES, speed=0.0))
    count = modes.natural_frequency.shape[1]
    full = np.zeros((len(ANGLES) * count, place.shape[1]))
    full[:, : 3 * press.model.nv] = modes.shapes.reshape(len(full), -1)
    slide = path.over(sprung, sprung.geometry.state(np.repeat(place, count, axis=0), full)).rate.reshape(-1, count)
    expected = pp.elasticity.compliance(press, stiffness, angle=ANGLES).compliance
    np.testing.assert_allclose((slide**2 / modes.natural_frequency**2).sum(axis=1), expected, rtol=1e-9)


def test_shaft_between_flywheel_and_linkage():
    """Two inertias on a shaft: w^2 = k (1 / J1 + 1 / J2), where the linkage's inertia at the crank is the torque by acceleration."""
    press, angle, flywheel, shaft = shipped("crank_slide"), 1.0, 30.0, 1e5
    started = pp.servo_cycle(press, angle=[angle, angle], speed=0.0, acceleration=[0.0, 1.0])
    linkage = np.diff(pp.inverse_dynamics(press, started).driving_torque)[0]
    elastic = Elastic(stiffness_of(press, 1e12, shaft=shaft))
    modes = natural_frequencies(press, elastic, angle=angle, flywheel=pp.drives.Flywheel(flywheel))
    assert modes.natural_frequency[0, 0] ** 2 == pytest.approx(shaft * (1 / linkage + 1 / flywheel), rel=1e-4)
    assert modes.strain_energy["shaft"][0, 0] == pytest.approx(1.0, rel=1e-4)
    assert modes.kinetic_energy["flywheel"][0, 0] == pytest.approx(linkage / (linkage + flywheel), rel=1e-3)
    held = natural_frequencies(press, elastic, angle=angle)
    assert held.natural_frequency[0, 0] ** 2 == pytest.approx(shaft / linkage, rel=1e-4)


def test_frequencies_grow_with_the_root_of_the_stiffness():
    press = shipped("zxn2_3000b")
    soft, stiff = (natural_frequencies(press, Elastic(stiffness_of(press, k)), angle=ANGLES).natural_frequency for k in (1e9, 4e9))
    np.testing.assert_allclose(stiff, 2 * soft, rtol=1e-9)


def test_dampers_in_proportion_damp_by_frequency():
    """The lowest mode at bottom dead centre has the ratio given, others more in proportion to their frequencies."""
    press = shipped("zxn2_3000b")
    modes = natural_frequencies(press, Elastic(stiffness_of(press), damping_ratio=0.03), angle=pp.dead_centres(press).bottom_angle)
    np.testing.assert_allclose(modes.damping_ratio, 0.03 * modes.natural_frequency / modes.natural_frequency[0, 0], rtol=1e-9)


def test_dampers_of_their_own_couple_modes():
    """Ratios of the eigenvalues of M u'' + C u' + K u = 0; a mode that creeps back has 1 or more."""
    press = shipped("jf75g_125_plain")
    elastic = Elastic(stiffness_of(press), dampers={"P4": 6e6})
    modes = natural_frequencies(press, elastic, angle=[0.7])
    sprung = sprung_press(press, elastic)
    place, _, _ = sprung.geometry.rigid(pp.servo_cycle(press, angle=[0.7], speed=0.0))
    forces = sprung.spring_forces(sprung.geometry.state(place, 0 * place))
    n, mass = sprung.free - 1, sprung.mass[:-1, :-1]
    by_place, by_rate = (np.linalg.solve(mass, each[0, :-1, :-1]) for each in (forces.stiffness, forces.damping))
    values = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-by_place, -by_rate]]))
    swinging = np.sort(-values.real[values.imag > 0] / np.abs(values[values.imag > 0]))
    assert len(swinging) < n
    found = np.sort(modes.damping_ratio[0])
    np.testing.assert_allclose(found[: len(swinging)], swinging, rtol=1e-6)
    assert (found[len(swinging) :] >= 1.0).all()
    assert found.max() > 1.5


def test_shares_of_energy():
    """They sum to 1; a rod and the pins at its ends share by their compliances along it where the force passes through all three."""
    press = shipped("crank_slide")
    elastic = Elastic(stiffness_of(press, 4e9, rods=[Rod("rod", ("P", "W"), 1e9)]))
    modes = natural_frequencies(press, elastic, angle=[0.0])
    for shares in (modes.strain_energy, modes.kinetic_energy):
        np.testing.assert_allclose(sum(shares.values()), 1.0, rtol=1e-12)
    in_line = {name: modes.strain_energy[name][0, 0] for name in ("P", "W", "rod P-W")}
    light = replace(elastic, stiffness=stiffness_of(press, 4e9))  # without the rod, links' own masses share the pins' forces alike
    bare = natural_frequencies(press, light, angle=[0.0]).strain_energy
    assert in_line["P"] / in_line["W"] == pytest.approx(bare["P"][0, 0] / bare["W"][0, 0], rel=0.1)
    assert in_line["rod P-W"] == pytest.approx((in_line["P"] + in_line["W"]) * 2, rel=1e-6)


def test_words_of_the_lowest_mode():
    press = shipped("jf75g_125_plain")
    modes = natural_frequencies(press, Elastic(stiffness_of(press)))
    assert modes.natural_frequency[0, 0] / (2 * np.pi) == pytest.approx(86.814, abs=1e-3)
    assert modes.words(modes.nearest_to_bottom, 0)[1] == "slide 98 %"
    assert "86.81 Hz" in str(modes)
    assert "slide_guide turning" in str(modes)
