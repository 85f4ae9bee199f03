"""Surfaces of a slide's guide: against preloaded joints, the pressure of gibs, non-negative least squares over points, closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls
from support.exploring import examples
from support.texts import shipped

import pinpress as pp
from pinpress.elasticity import PreloadedJoint, eight_way_guide, guide_contact

SIDES = ("left", "right")
SHAPE = {"facing_x": (0.30, 0.20), "facing_y": (0.25, 0.28), "length": 0.6, "width": 0.1, "stiffness": 5e8}


def reactions(force=(0.0, 0.0, 0.0), point=(0.0, 0.0, 0.0), loads=(), angle=(0.0, 0.4), speed=0.0):
    """Of the crank-slide press, by default at its bottom dead centre and a little after it, under a force on its slide."""
    press = shipped("crank_slide")
    motion = pp.servo_cycle(press, angle=list(angle), speed=speed)
    return press, pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slide", force, point), *loads])


def balanced(found, tolerance=1e-7):
    """Assert that the surfaces together give the force of the guide."""
    normal = np.array([surface.normal for surface in found.surfaces])
    force = -np.stack(list(found.force.values()), axis=1) @ normal
    assert np.abs(force - found.guide_force).max() <= tolerance * max(np.abs(found.guide_force).max(), 1.0)


@examples(25)
@given(preload=st.floats(1e4, 1e5), share=st.floats(-4.0, 4.0), length=st.floats(1e-3, 2.0))
def test_opposite_surfaces_are_a_preloaded_joint(preload, share, length):
    """Two on each side: twice the stiffness and twice the preload; whatever their length, without a moment."""
    joint = PreloadedJoint(1e9, 1e9, 2 * preload)
    press, found = reactions((share * preload, 0.0, 0.0), angle=(0.0,))
    guide = eight_way_guide(**SHAPE | {"length": length, "stiffness": 5e8}, preload=preload)
    contact = guide_contact(press, found, guide)
    across = -contact.guide_force[0, 0]
    lever = contact.guide_moment[0, 1]  # of the force about the slide's origin
    assert abs(lever) <= 1e-9 * max(abs(across), 1.0)
    assert contact.shift[0, 0] == pytest.approx(float(joint.elongation(across)), rel=1e-7, abs=1e-13)
    right, left = joint.forces(across)
    sums = {side: sum(contact.force[name][0] for name in contact.force if name.startswith(side) and name.endswith("x")) for side in SIDES}
    assert sums["right"] == pytest.approx(float(right), rel=1e-7, abs=1e-6 * preload)
    assert sums["left"] == pytest.approx(float(left), rel=1e-7, abs=1e-6 * preload)
    balanced(contact)


def test_pressure_is_that_of_gibs():
    """Without preload and clearance the opposite surface pushes where one would have to pull: 6 M / L^2 b. With wide clearance one lifts
    off beyond an eccentricity of L / 6 (`ratings.eccentric_load`). A pair of surfaces on each side is a gib of twice the width."""
    press = shipped("crank_slide")
    motion = pp.servo_cycle(press, angle=[0.5, 0.9, 1.4], speed=0.0)
    weights = pp.inverse_dynamics(press, motion)  # which `eccentric_load` leaves out
    heavy = pp.inverse_dynamics(press, motion, loads=[pp.loads.PointForce("slide", (0.0, 0.0, 1e7), (0.02, 0.0, 0.0))])
    for one_sided, clearance in ((False, 0.0), (True, 1e-3)):
        gibs = pp.ratings.Gibs(0.6, 0.2, one_sided=one_sided)
        expected = pp.ratings.eccentric_load(press, motion, force=1e7, offset=(0.02, 0.0, 0.0), gibs=gibs)
        guide = [
            replace(each, clearance=clearance) if each.name.endswith("x") else replace(each, preload=1e5)
            for each in eight_way_guide(**SHAPE | {"stiffness": 1e12})
        ]
        found = guide_contact(press, heavy, guide)
        pressure = np.max([found.pressure[name] for name in found.pressure if name.endswith("x")], axis=0)
        weight = np.abs(weights.bearing_force["slide_guide"][:, 0] / heavy.bearing_force["slide_guide"][:, 0]).max()
        assert pressure == pytest.approx(expected.pressure, rel=2 * weight + 1e-9)
        touching = np.max([found.contact[name] for name in found.contact if name.endswith("x")], axis=0)
        if one_sided:
            assert expected.contact.min() < 0.9
            assert touching == pytest.approx(expected.contact, rel=4 * weight + 1e-9)


def test_tilting_of_a_closed_guide():
    """k L^2 / 12 of each surface that faces a tilt, all of it before one lifts off; and turning about the guide's axis by the levers."""
    guide = eight_way_guide(**SHAPE, preload=1e5)
    for force, point, about, stiffness in (
        ((0.0, 0.0, 1e4), (0.3, 0.0, 0.0), 1, 4 * 5e8 * 0.6**2 / 12),
        ((0.0, 0.0, 1e4), (0.0, 0.3, 0.0), 0, 4 * 5e8 * 0.6**2 / 12),
        ((1e4, 0.0, 0.0), (0.0, 0.3, 0.0), 2, 4 * 5e8 * (0.20**2 + 0.25**2)),
    ):
        press, found = reactions(force, point, angle=(0.0,))
        contact = guide_contact(press, found, guide)
        moment = np.cross(point, force)[about]
        assert contact.rotation[0, about] == pytest.approx(moment / stiffness, rel=1e-7)
        assert np.abs(np.delete(contact.rotation[0], about)).max() < 1e-6 * abs(contact.rotation[0, about])
        assert not contact.opened
        balanced(contact)


def by_points(guide, force, moment, parts):
    """Forces of all surfaces by non-negative least squares: of all that balance the load, those with the least complementary energy, of
    points that stand for parts of each surface."""
    rows, k, begin = [], [], []
    for surface in guide:
        normal = np.array(surface.normal)
        for s in (np.arange(parts) + 0.5) / parts - 0.5:
            point = np.array(surface.point) + s * surface.length * np.array([0.0, 0.0, 1.0])
            rows.append(np.concatenate([normal[:2], np.cross(point, normal)]))
            k.append(surface.stiffness / parts)
            begin.append(surface.preload / surface.stiffness - surface.clearance)
    matrix, springs, starts = np.array(rows).T, np.array(k), np.array(begin)
    load = -np.concatenate([force[:2], moment])
    heavy = 1e4 / np.sqrt(springs.min())
    left = np.vstack([np.diag(1 / np.sqrt(springs)), heavy * matrix])
    found, _ = nnls(left, np.concatenate([np.sqrt(springs) * starts, heavy * load]), maxiter=100000)
    return found.reshape(len(guide), parts).sum(axis=1)


@pytest.mark.parametrize(
    ("length", "parts", "tolerance"),
    [(1e-4, 1, 2e-5), pytest.param(0.6, 60, 2e-3, marks=pytest.mark.exhaustive)],
    ids=["thin", "long"],
)
@pytest.mark.parametrize("given", [{"preload": 2e4}, {"preload": 2e5}, {"clearance": 2e-5}], ids=["loose", "tight", "clearance"])
def test_against_least_squares_over_points(length, parts, tolerance, given):
    """Off centre in x and y at once. Surfaces that are short along the guide do not hold a tilt: the thin ones stand in two rows."""
    guide = eight_way_guide(**SHAPE | {"length": length}, **given)
    if parts == 1:
        guide = tuple(
            replace(each, name=f"{each.name} {row}", point=(*each.point[:2], 0.3 * height), stiffness=(1 + 0.3 * number) * each.stiffness)
            for row, height in (("low", -1), ("high", 1))
            for number, each in enumerate(guide)
        )
    press, found = reactions((3e4, 0.0, 4e5), (0.12, 0.07, 0.0), angle=(0.5,))
    contact = guide_contact(press, found, guide)
    expected = by_points(guide, contact.guide_force[0], contact.guide_moment[0], parts)
    got = np.array([each[0] for each in contact.force.values()])
    assert got == pytest.approx(expected, abs=tolerance * expected.max())
    assert (got >= 0).all()
    balanced(contact)


def test_process_forces_beside_the_axis_and_turns_of_the_load():
    """``offset`` is a point force of the same size; a guide looked at from the other side carries the mirror image."""
    press = shipped("crank_slide")
    motion = pp.cycle(press, 6.0, points=60)
    drawing = pp.loads.DeepDrawing(5e5, 0.05)
    plain = pp.inverse_dynamics(press, motion, loads=[drawing])
    push = np.zeros((60, 3))
    push[:, 2] = plain.process_force
    guide = eight_way_guide(**SHAPE, preload=2e4)
    beside = guide_contact(press, plain, guide, offset=(0.0, 0.06, 0.0))
    worst = int(np.argmax(plain.process_force))
    there = pp.servo_cycle(press, angle=[motion.crank_angle[worst]], speed=6.0)
    point = pp.inverse_dynamics(press, there, loads=[pp.loads.PointForce("slide", tuple(push[worst]), (0.0, 0.06, 0.0))])
    alone = guide_contact(press, point, guide)
    for name, each in alone.force.items():
        assert each[0] == pytest.approx(beside.force[name][worst], rel=1e-6, abs=1e-3)
    assert abs(beside.rotation[worst, 0]) > 1e-6  # a tilt and its mirror image have the same forces
    np.testing.assert_allclose(alone.rotation[0], beside.rotation[worst], rtol=1e-5, atol=1e-12)
    np.testing.assert_allclose(alone.shift[0], beside.shift[worst], rtol=1e-5, atol=1e-12)
    mirrored = guide_contact(press, plain, guide, offset=(0.0, -0.06, 0.0))
    for name in beside.force:
        other = name.replace("front", "?").replace("back", "front").replace("?", "back")
        np.testing.assert_allclose(mirrored.force[other], beside.force[name], rtol=1e-9, atol=1e-4)
    names = {each.surface for each in beside.opened}
    assert names  # with little preload some lift off while it draws
    for stretch in beside.opened:
        inside = (motion.crank_angle >= stretch.begins) & (motion.crank_angle <= stretch.ends)
        assert beside.contact[stretch.surface][inside].max() < 1
        assert beside.contact[stretch.surface][inside].min() == stretch.least_contact


def test_a_slide_that_nothing_presses_stands_in_the_middle():
    press, found = reactions(angle=(0.0,))
    contact = guide_contact(press, found, eight_way_guide(**SHAPE, clearance=1e-4))
    assert np.abs(contact.shift).max() < 1e-9
    assert max(each.max() for each in contact.force.values()) < 1e-6


def test_guides_in_other_units_are_warned_of_once():
    guide = eight_way_guide(**SHAPE, preload=1e5)
    for make, message in (
        (lambda: replace(guide[0], preload=0.0, clearance=0.1), "if mm are meant"),
        (lambda: replace(guide[0], preload=20.0), "if kN are meant"),
        (lambda: PreloadedJoint(1e9, 1e9, 250.0), "preload is 250 N: if kN are meant, write 250e3"),
        (lambda: eight_way_guide(**SHAPE, preload=50.0), "^eight_way_guide: .*write 50e3"),
        (lambda: eight_way_guide(**SHAPE, clearance=50.0), "^eight_way_guide: .*write 50e-3"),
    ):
        with pytest.warns(pp.PinpressWarning, match=message) as warned:
            make()
        assert len(warned) == 1  # the eight surfaces are alike
