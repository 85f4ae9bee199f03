"""Balancing of rotors: the sums that must vanish, and the forces and moments on the bearing of a rotor that turns alone.

Zhang 2007, 3.1.1. Rotors are random bodies on one shaft, with joint frames turned any way about it; gravity is off, so that what the
bearing bears is the rotor's unbalance alone.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import texts
from support.exploring import examples
from support.generators.random_linkages import Drawing

import pinpress as pp
from pinpress.balancing import classical
from pinpress.balancing.counterweights import Counterweight, with_counterweights

ROUNDING = 1e-12  # of what there was before: sums of some ten terms
SPEED = 30.0
FIXED = examples(5)
MASSES, POSITIONS = [2.0, -0.5, 3.0], [[0.1, 0.2, 0.0], [0.0, -0.3, 0.2], [-0.2, 0.1, 0.1]]


def rotor(folder, seed):
    """A rotor with any mass distribution; its joint's axis is any direction of its frame, in either sense."""
    rng = np.random.default_rng(seed)
    drawing = Drawing("rotor")
    drawing.joint("O", "frame", "rotor", 0j, sense=rng.choice([-1, 1]), rpy=rng.uniform(-3, 3, 3))
    points = rng.uniform(-1, 1, (4, 3))
    arms = points - points.mean(axis=0)
    tensor = sum(arm @ arm * np.eye(3) - np.outer(arm, arm) for arm in arms)
    drawing.body("rotor", 4.0, complex(*rng.uniform(-0.5, 0.5, 2)), rng.uniform(-0.5, 0.5), tensor)
    file = folder / "rotor.urdf"
    file.write_text(drawing.urdf("O"), encoding="utf-8")
    return pp.load(file, gravity=(0, 0, 0))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("rotors")


def turning(press, engine="auto"):
    """Force and moment of the bearing of a rotor at constant speed, (n, 3) each."""
    motion = pp.cycle(press, SPEED, points=12, engine=engine)
    result = pp.inverse_dynamics(press, motion, engine=engine)
    return result.bearing_force["O"], result.bearing_moment["O"]


# ------------------------------------------------------------------------------------------------------------------------ sums of masses


def test_static_correction_is_minus_the_sum_of_mass_times_radius():
    """2 (0.1, 0) - 0.5 (0, 0.2) + 3 (-0.2, 0.1) = (-0.4, 0.2), worked out by hand; what is along the shaft does not count."""
    correction = classical.static_balance(MASSES, POSITIONS)
    np.testing.assert_allclose(correction.product, [0.4, 0.0, -0.2], atol=1e-16)
    np.testing.assert_array_equal(correction.centre, [0.0, 0.0, 0.0])


@FIXED
@given(st.integers(0, 2**32 - 1))
def test_two_corrections_leave_neither_force_nor_couple(seed):
    rng = np.random.default_rng(seed)
    masses, positions, planes = rng.uniform(-1, 2, 6), rng.uniform(-1, 1, (6, 3)), rng.uniform(-1, 1, 2)
    corrections = classical.two_plane_balance(masses, positions, planes=planes)
    products = np.vstack([masses[:, None] * positions, *(each.product for each in corrections)]) * [1, 0, 1]
    places = np.concatenate([positions[:, 1], planes])
    scale = np.abs(products).sum()  # of the corrections too, which grow as the planes come close
    assert np.abs(products.sum(axis=0)).max() <= ROUNDING * scale
    assert np.abs(places @ products).max() <= ROUNDING * scale


def test_a_mass_between_the_planes_is_shared_like_a_force_on_a_beam():
    """3 kg at 0.2 m, a third of the way from the first plane to the second: two thirds and one third of 0.6 kg m."""
    first, second = classical.two_plane_balance([3.0], [[0.2, 0.1, 0.0]], planes=(0.0, 0.3))
    np.testing.assert_allclose([first.product, second.product], [[-0.4, 0, 0], [-0.2, 0, 0]], atol=1e-15)
    np.testing.assert_array_equal([first.centre, second.centre], [[0, 0, 0], [0, 0.3, 0]])


def test_counterweight_and_hole_have_the_product_of_their_correction():
    correction = classical.two_plane_balance(MASSES, POSITIONS, planes=(-0.4, 0.5))[1]
    for weight in (correction.counterweight("rotor", 0.3), correction.hole("rotor", 0.3)):
        arm = np.array(weight.position) - correction.centre
        assert np.linalg.norm(arm) == pytest.approx(0.3, rel=1e-15)
        np.testing.assert_allclose(weight.mass * arm, correction.product, rtol=1e-15)
    assert correction.hole("rotor", 0.3).mass == -correction.counterweight("rotor", 0.3).mass < 0


def test_a_balanced_rotor_needs_no_mass():
    weight = classical.static_balance([1.0, 1.0], [[0.1, 0, 0], [-0.1, 0, 0]]).counterweight("rotor", 0.2)
    assert weight == Counterweight("rotor", 0.0, (0.0, 0.0, 0.0))


# ----------------------------------------------------------------------------------------------------------------- rotors in a linkage


@FIXED
@given(st.integers(0, 2**32 - 1))
def test_bearing_bears_the_unbalance(folder, seed):
    """Of the rotor as drawn: force - w^2 static, moment - w^2 axis x couple, turned into the world by the drawn joint frame."""
    press = rotor(folder, seed)
    found = classical.unbalance(press, "rotor")
    force, moment = turning(press)
    turned = press.model.jointPlacements[1].rotation
    expected = -(SPEED**2) * turned @ found.static, -(SPEED**2) * turned @ np.cross(found.axis, found.couple)
    np.testing.assert_allclose(force[0], expected[0], atol=ROUNDING * np.abs(force).max())
    np.testing.assert_allclose(moment[0], expected[1], atol=ROUNDING * np.abs(moment).max())


@FIXED
@given(st.integers(0, 2**32 - 1))
def test_two_planes_relieve_the_bearing_of_force_and_moment(folder, engine, seed):
    press = rotor(folder, seed)
    corrections = classical.unbalance(press, "rotor").two_plane_balance((-0.6, 0.9))
    balanced = with_counterweights(press, [each.counterweight("rotor", 0.5) for each in corrections])
    for before, after in zip(turning(press, engine), turning(balanced, engine), strict=True):
        assert np.abs(after).max() <= ROUNDING * np.abs(before).max()


@FIXED
@given(st.integers(0, 2**32 - 1))
def test_one_plane_relieves_it_of_force_alone(folder, seed):
    press = rotor(folder, seed)
    weight = classical.unbalance(press, "rotor").static_balance(plane=0.4).counterweight("rotor", 0.5)
    force, moment = turning(with_counterweights(press, [weight]))
    assert np.abs(force).max() <= ROUNDING * np.abs(turning(press)[0]).max()
    assert np.abs(moment).max() > 1e-3  # the mass distribution is random, and so is its couple


def test_holes_balance_as_well(folder):
    """In a heavy disc, whose inertia stays that of a body."""
    drawing = Drawing("disc")
    drawing.joint("O", "frame", "rotor", 0j)
    drawing.body("rotor", 50.0, 0.004 + 0.003j, 0.01, np.diag([0.5, 0.6, 0.9]))
    file = folder / "disc.urdf"
    file.write_text(drawing.urdf("O"), encoding="utf-8")
    press = pp.load(file, gravity=(0, 0, 0))
    holes = [each.hole("rotor", 0.2) for each in classical.unbalance(press, "rotor").two_plane_balance((-0.05, 0.05))]
    for before, after in zip(turning(press), turning(with_counterweights(press, holes)), strict=True):
        assert np.abs(after).max() <= ROUNDING * np.abs(before).max()


def test_unbalance_of_a_crank_is_its_mass_at_the_pin():
    """JF75G-125, plain: m1 = 52.25 kg at r1 = 0.015 m, in the plane of the rod. Its frame's y axis is the shaft's."""
    found = classical.unbalance(texts.shipped("jf75g_125_plain"), "crank")
    np.testing.assert_allclose(found.static, [52.25 * 0.015, 0, 0], atol=1e-15)
    np.testing.assert_array_equal([found.axis, found.couple], [[0, 1, 0], [0, 0, 0]])
