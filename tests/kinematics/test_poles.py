"""Poles, polygons and Grashof's kinds: printed values of an independent solution in maximal coordinates, Kennedy's line, poles by
differences of positions, the image of a link, and the range of the crank."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.exploring import examples
from support.generators.random_linkages import Drawing, four_bar
from support.texts import load, shipped

import pinpress as pp

PLANE = [0, 2]
# four-bar with frame 5, crank 2, coupler 4 and rocker 3.5, at 1 rad/s: crank angle [deg] -> angular velocities and accelerations of coupler
# and rocker, pole of the coupler relative to the frame, pole of the crank relative to the rocker along x
PRINTED = {
    60: (-0.3156481429, 0.33973739351, 0.35330362654, 0.58135164014, (4.16808453489, 7.21933418468), -2.57274446692),
    150: (0.05847094742, 0.52601763623, 0.33210939406, -0.29301440123, (27.89036654846, -16.10251063455), -5.54891570265),
    300: (0.21038498501, -0.44500055141, -0.65426055514, -0.42621254155, (-3.75319091787, 6.50071736026), 1.53979370794),
}
LINKS = ("frame", "crank", "coupler", "rocker")


def standing(press, *angles):
    return pp.servo_cycle(press, angle=list(angles), speed=[1.0] * len(angles), acceleration=[0.0] * len(angles))


@pytest.mark.parametrize("angle", PRINTED)
def test_printed_values(angle):
    press = load(four_bar(5, 2, 4, 3.5, 1.0).urdf("O"))
    motion = standing(press, np.radians(angle) - 1.0)
    w3, w4, e3, e4, pole, along = PRINTED[angle]
    coupler, rocker, relative = (
        pp.measures.poles(press, motion, *pair) for pair in (("coupler", "frame"), ("rocker", "frame"), ("crank", "rocker"))
    )
    np.testing.assert_allclose(coupler.position[0, PLANE], pole, atol=1e-10)
    np.testing.assert_allclose(relative.position[0], (along, 0.0, 0.0), atol=1e-10)
    np.testing.assert_allclose(rocker.position[0], (5.0, 0.0, 0.0), atol=1e-12)
    for found, w, e in ((coupler, w3, e3), (rocker, w4, e4)):
        np.testing.assert_allclose(found.angular_velocity[0], (0.0, -w, 0.0), atol=1e-10)
        np.testing.assert_allclose(found.angular_acceleration[0], (0.0, -e, 0.0), atol=1e-10)


def test_at_infinity_and_at_rest():
    press = shipped("crank_slide")
    motion = pp.cycle(press, speed=3.0, points=8)
    found = pp.measures.poles(press, motion, "slide", "frame")
    assert np.isnan(found.position).all()
    moving = np.abs(motion.slide_velocity) > 1e-9
    np.testing.assert_allclose(np.abs(found.direction[moving]), np.tile([1.0, 0.0, 0.0], (moving.sum(), 1)), atol=1e-15)
    assert np.isnan(found.direction[~moving]).all()
    turned = pp.measures.poles(press, motion, "frame", "slide")
    np.testing.assert_array_equal(turned.direction, -found.direction)
    rod = pp.measures.poles(press, motion, "rod", "frame")  # the crank stands across the guide at 90 and 270 deg
    assert np.flatnonzero(np.isnan(rod.position[:, 0])).tolist() == [2, 6]


LENGTHS = st.lists(st.floats(0.5, 3.0), min_size=4, max_size=4)


@examples(30)
@given(LENGTHS, st.floats(0.1, 3.0), st.sampled_from([1, -1]))
def test_random_four_bars(lengths, angle, side):
    """Kennedy's line, poles by differences of positions, and Grashof's kind against the range of the crank."""
    frame, crank, coupler, rocker = lengths
    diagonal = abs(frame - crank * np.exp(1j * angle))
    assume(abs(coupler - rocker) + 0.1 < diagonal < coupler + rocker - 0.1)
    s, p, q, longest = sorted(lengths)
    assume(abs(p + q - s - longest) > 0.02)
    press = load(four_bar(*lengths, angle=angle, side=side).urdf("O"))
    (found,) = pp.measures.grashof(press)
    np.testing.assert_allclose([found.frame, found.crank, found.coupler, found.rocker], lengths, atol=1e-12)
    assert found.links == LINKS[1:]
    turns = found.kind == "double crank" or (found.kind == "crank rocker" and found.shortest == "crank")
    assert turns == (press.branch.period is not None)
    motion = standing(press, -1e-5, 0.0, 1e-5)
    poles = {(a, b): pp.measures.poles(press, motion, a, b).position[1] for a in LINKS for b in LINKS if a < b}
    size = max(lengths)
    for a, b, c in (LINKS[:3], LINKS[1:], (*LINKS[2:], LINKS[0]), (LINKS[3], *LINKS[:2])):
        one, two, three = (poles[tuple(sorted(pair))] for pair in ((a, b), (b, c), (c, a)))
        if np.isfinite([one, two, three]).all():
            spread = max(np.linalg.norm(one - two), np.linalg.norm(two - three), np.linalg.norm(three - one))
            assert np.linalg.norm(np.cross(one - two, three - two)) <= 1e-9 * size * spread * max(1.0, spread / size)
    pole, body = poles["coupler", "frame"], pp.measures.poles(press, motion, "coupler", "frame")
    if np.isfinite(pole).all() and np.linalg.norm(pole) < 20 * size:
        place, turn = press.placements("coupler", motion.crank_angle), body.angular_velocity[1, 1]
        before, after = (np.asarray(each) @ np.linalg.inv(np.asarray(place[1])) @ [*pole, 1.0] for each in (place[0], place[2]))
        assert np.linalg.norm(after - before) / 2e-5 <= 1e-7 * size * max(1.0, abs(turn))


def test_polygons():
    """The image of a link is the link, turned by a right angle and scaled by its angular velocity; accelerations of the pins by hand."""
    press = shipped("zxn2_3000b")
    motion = pp.cycle(press, speed=5.0, points=360)
    found = pp.measures.polygons(press, motion, 60)
    places = {name: path[60] for name, path in pp.measures.bearing_positions(press, motion).items()}
    spin = pp.measures.poles(press, motion, "rocker", "frame")
    w, e = spin.angular_velocity[60], spin.angular_acceleration[60]
    for one, other in (("C", "E"), ("D", "C"), ("D", "E")):
        arm = places[other] - places[one]
        np.testing.assert_allclose(found.velocity[other] - found.velocity[one], np.cross(w, arm), atol=1e-13)
        relative = np.cross(e, arm) + np.cross(w, np.cross(w, arm))
        np.testing.assert_allclose(found.acceleration[other] - found.acceleration[one], relative, atol=1e-12)
    np.testing.assert_allclose(found.velocity["F"], (0.0, 0.0, motion.slide_velocity[60]), atol=1e-14)
    assert set(found.links["rocker"]) == {"C", "D", "E"}
    velocity, acceleration = (chart for section in found.described() for chart in section.blocks)
    assert {curve.name for curve in velocity.curves if curve.look == "marked"} == {"B", "C", "E", "F"}
    assert acceleration.quantity == "m/s2"


def test_slot():
    """The point of the rocker at the pin moves across the slot, and differs from the pin's acceleration by Coriolis and the sliding one."""
    drawing, pin = Drawing("quick_return"), 0.1 * np.exp(0.4j)
    drawing.joint("O", "frame", "crank", 0j)
    drawing.joint("Q", "frame", "rocker", -0.3j, bounded=True)
    drawing.joint("slot", "rocker", "block", pin, along=pin + 0.3j)
    drawing.loop("P", "crank", "block", pin)
    for link in ("crank", "rocker", "block"):
        drawing.body(link, 1.0, pin)
    press = load(drawing.urdf("O"))
    motion = standing(press, 0.7)
    found = pp.measures.polygons(press, motion)
    assert set(found.velocity) == {"O", "P", "Q", "P on rocker"}
    at = pp.measures.bearing_positions(press, motion)
    along = (at["P"] - at["Q"])[0] / np.linalg.norm(at["P"] - at["Q"])
    spin = pp.measures.poles(press, motion, "rocker", "frame").angular_velocity[0]
    sliding = found.velocity["P"] - found.velocity["P on rocker"]
    np.testing.assert_allclose(np.cross(sliding, along), 0.0, atol=1e-15)
    relative = found.acceleration["P"] - found.acceleration["P on rocker"] - 2 * np.cross(spin, sliding)
    np.testing.assert_allclose(np.cross(relative, along), 0.0, atol=1e-14)
    assert not pp.measures.grashof(press)


@pytest.mark.parametrize(
    ("lengths", "kind", "shortest"),
    [
        ((5, 2, 4, 3.5), "crank rocker", "crank"),
        ((1, 2, 2.2, 2.4), "double crank", "frame"),
        ((2, 2.2, 1, 2.4), "double rocker", "coupler"),
        ((2.2, 2.4, 2, 1), "crank rocker", "rocker"),
        ((2, 2.2, 2.3, 3), "triple rocker", "frame"),
        ((2, 1, 2, 1), "change point", "crank"),
    ],
)
def test_kinds(lengths, kind, shortest):
    (found,) = pp.measures.grashof(load(four_bar(*lengths, angle=1.3).urdf("O")))
    assert (found.kind, found.shortest) == (kind, shortest)


def test_kinds_of_shipped_presses():
    """A six-bar is a four-bar and a slide behind it; its slider-crank has equal lengths."""
    first, second = pp.measures.grashof(shipped("zxn2_3000b"))
    assert (first.kind, first.bearings) == ("crank rocker", ("A", "B", "C", "D"))
    assert (second.kind, second.links, second.rocker) == ("change point", ("rocker", "rod", "slide"), None)
    (only,) = pp.measures.grashof(shipped("crank_slide"))
    assert (only.kind, only.bearings, only.links) == ("crank slide", ("O", "P", "W", "slide_guide"), ("crank", "rod", "slide"))
    assert only.margin == pytest.approx(0.3, abs=1e-12)


def test_refused():
    press = shipped("crank_slide")
    motion = pp.cycle(press, speed=1.0, points=12)
    for call, message in (
        (lambda: pp.measures.poles(press, motion, "rodd", "frame"), "did you mean 'rod'"),
        (lambda: pp.measures.poles(press, motion, "rod", "rod"), "one body"),
        (lambda: pp.measures.polygons(press, motion, 12), "from 0 to 11"),
        (lambda: pp.measures.polygons(shipped("zxn2_3000b"), motion), "other joints"),
    ):
        with pytest.raises(pp.PinpressError, match=message):
            call()
