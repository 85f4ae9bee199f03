"""`with_counterweights`: the press that results, against momentum and the paper's own; what no body can be."""

import numpy as np
import pytest
from support import texts
from support.generators.random_linkages import Group, Spec, drawn, momentum_balance
from support.oracles import balance_by_hand as by_hand

import pinpress as pp
from pinpress.balancing import Counterweight, with_counterweights

PAPER = [Counterweight(link, mass, (at, 0.0, 0.0)) for link, mass, at in by_hand.PAPER]


@pytest.fixture(scope="module")
def six_bar():
    return texts.shipped("zxn2_3000b")


@pytest.fixture(scope="module")
def turn(six_bar):
    return pp.cycle(six_bar, by_hand.SPEED)


def body(press, link):
    return press.model.inertias[press.model.frames[press.model.getFrameId(link)].parentJoint]


def test_the_papers_counterweights_shake_as_written_out_by_hand(six_bar, turn):
    force = pp.inverse_dynamics(with_counterweights(six_bar, PAPER), turn).shaking_force
    expected = by_hand.shaking_force(by_hand.PAPER)
    assert np.abs(force[:, 0] + 1j * force[:, 2] - expected).max() < 1e-9 * np.abs(expected).max()


def test_the_paper_rounds_the_centres_of_mass_that_result(six_bar):
    """Kong 2025 prints -0.0181 and 0.1924 m; with these the horizontal range falls by 47.418 %, with its counterweights by 47.389 %."""
    turn, heavy = pp.cycle(six_bar, by_hand.SPEED, points=3600), with_counterweights(six_bar, PAPER)
    for link, mass, centre in (("crank", 1614.656, -0.0181), ("rod", 333.216, 0.1924)):
        assert body(heavy, link).mass == pytest.approx(mass, abs=1e-9)
        assert body(heavy, link).lever[0] == pytest.approx(centre, abs=5.1e-5)
    before = by_hand.ranges(by_hand.shaking_force(states=3600))
    for press, expected in ((texts.shipped("zxn2_3000b_balanced"), [-0.47418, -0.02741]), (heavy, [-0.47389, -0.02741])):
        force = pp.inverse_dynamics(press, turn).shaking_force
        np.testing.assert_allclose(np.ptp(force[:, [0, 2]], axis=0) / before - 1, expected, atol=5.1e-6)


def test_a_counterweight_is_a_body_more_by_the_law_of_momentum():
    """On every link of a linkage in a tilted plane, one of them welded to another: mass, moment and spread, by Pinocchio's momentum."""
    groups = (Group("RRR", 1, (1, 0, 0)),)
    press = texts.load(drawn(Spec(groups, 11, tilted=True, stacked=True, solid=True, extra=True)).urdf("crank"))
    links = [link for link in press.links if press.model.frames[press.model.getFrameId(link)].parentJoint]
    rng = np.random.default_rng(1)
    weights = [Counterweight(link, rng.uniform(1, 5), tuple(rng.normal(size=3)), rng.uniform(0, 2)) for link in links]
    made = with_counterweights(press, weights)
    assert sum(i.mass for i in made.model.inertias) == pytest.approx(
        sum(i.mass for i in press.model.inertias) + sum(w.mass for w in weights)
    )
    motion = pp.servo_cycle(press, angle=[-0.02, 0.01, 0.03], speed=[5.0, -3.0, 8.0], acceleration=[10.0, 40.0, -20.0])
    result = pp.inverse_dynamics(made, motion)
    force, moment = momentum_balance(made, motion, [])
    assert np.abs(result.shaking_force - force).max() < 1e-10 * np.abs(force).max()
    assert np.abs(result.shaking_moment - moment).max() < 1e-10 * np.abs(moment).max()
    assert np.abs(result.power_residual).max() < 1e-10


def test_a_mass_and_a_hole_of_it_cancel(six_bar, turn):
    weight = Counterweight("rocker", 120.0, (0.2, 0.0, -0.1), 4.0)
    hole = Counterweight("rocker", -120.0, (0.2, 0.0, -0.1), -4.0)
    same = pp.inverse_dynamics(with_counterweights(six_bar, [weight, hole]), turn)
    before = pp.inverse_dynamics(six_bar, turn)
    np.testing.assert_allclose(same.driving_torque, before.driving_torque, atol=1e-9 * np.abs(before.driving_torque).max())


def test_inertia_is_about_the_counterweights_own_centre_and_the_order_does_not_count(six_bar):
    weights = [Counterweight("rod", 30.0, (0.1, 0.0, 0.2), 1.5), Counterweight("rod", 10.0, (-0.2, 0.0, 0.0))]
    one, other = with_counterweights(six_bar, weights), with_counterweights(six_bar, weights[::-1])
    np.testing.assert_allclose(body(one, "rod").toPseudoInertia().toMatrix(), body(other, "rod").toPseudoInertia().toMatrix(), atol=1e-12)
    point = [(277.68, 5.33, 0.24), (30.0, 1.5, 0.1 + 0.2j), (10.0, 0.0, -0.2)]
    centre = sum(m * at for m, _, at in point) / sum(m for m, _, _ in point)
    about = sum(own + m * abs(at - centre) ** 2 for m, own, at in point)
    assert body(one, "rod").inertia[1, 1] == pytest.approx(about, rel=1e-12)
    np.testing.assert_allclose(body(one, "rod").lever, (centre.real, 0.0, centre.imag), atol=1e-15)


def test_the_original_stays_and_the_new_press_is_written(six_bar, turn, tmp_path):
    mass = body(six_bar, "crank").mass
    made = with_counterweights(six_bar, PAPER)
    assert body(six_bar, "crank").mass == mass == 1009.16
    again = pp.load(pp.write_urdf(made, tmp_path / "made.urdf"))
    old, new = (pp.inverse_dynamics(press, turn) for press in (made, again))
    np.testing.assert_allclose(new.driving_torque, old.driving_torque, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(new.shaking_force, old.shaking_force, rtol=1e-12, atol=1e-9)
