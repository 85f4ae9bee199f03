"""Regions for counterweights: what fills it is a body that lies inside, and the best of all that do."""

from itertools import pairwise

import numpy as np
import pytest
from support import texts
from support.generators.period_presses import five_bar, of_two_motors
from support.generators.random_linkages import Drawing

import pinpress as pp
from pinpress.balancing import AddedMass, CounterweightRegion, Peak, Range, Rms, balance, with_counterweights

TORQUE, MASS = Range("driving_torque"), AddedMass()
HEAVY = Rms("shaking_moment", "y")
IN = 1e-6  # of a region's size: what the solver's 1e-8 of the forces may be in a place of a light counterweight


@pytest.fixture(scope="module")
def six_bar():
    return texts.shipped("zxn2_3000b")


@pytest.fixture(scope="module")
def turn(six_bar):
    return pp.cycle(six_bar, 7.0, points=60)


def balanced(six_bar, turn, region, criterion=TORQUE, most=200.0):
    return balance(six_bar, turn, regions=[region], minimise=criterion, limits={MASS: most})


@pytest.mark.parametrize("link", ["crank", "coupler", "rocker", "rod"])
@pytest.mark.parametrize("gyration", [0.0, 0.15])
@pytest.mark.parametrize("criterion", [TORQUE, HEAVY], ids=lambda m: m.words)
def test_what_fills_a_disc_is_a_body_within_it(six_bar, turn, link, gyration, criterion):
    """Its moment of inertia about the disc's centre is that of material within the radius, and of the gyration that is asked for."""
    region = CounterweightRegion(link, radius=0.4, centre=(0.1, 0.3, -0.2), gyration=gyration)
    for weight in balanced(six_bar, turn, region, criterion).counterweights:
        arm = np.subtract(weight.position, region.centre)
        assert weight.position[1] == pytest.approx(0.3, abs=1e-12)  # in the plane of the centre
        assert np.linalg.norm(arm) <= 0.4 * (1 + IN)
        own = weight.inertia / weight.mass - gyration**2
        assert -IN <= own <= 0.4**2 - arm @ arm + IN


@pytest.mark.parametrize("criterion", [TORQUE, HEAVY, Range("shaking_force", "x")], ids=lambda m: m.words)
def test_what_fills_a_polygon_is_in_its_hull(six_bar, turn, criterion):
    corners = ((-0.3, 0.0, 0.1), (-0.1, 0.0, 0.4), (0.3, 0.0, 0.1), (0.0, 0.0, 0.2), (0.05, 0.0, -0.35))  # not in order, one inside
    edges = ((0, 1), (1, 2), (2, 4), (4, 0))
    for link in ("crank", "rocker"):
        for weight in balanced(six_bar, turn, CounterweightRegion(link, corners=corners), criterion).counterweights:
            x, y, z = weight.position
            assert abs(y) <= 1e-12
            for i, j in edges:  # clockwise: the inside is on the right
                (ax, _, az), (bx, _, bz) = corners[i], corners[j]
                assert (bx - ax) * (z - az) - (bz - az) * (x - ax) <= IN
            assert 0 <= weight.inertia <= weight.mass * 0.5**2


@pytest.mark.exhaustive
def test_a_disc_is_between_polygons_inside_and_around_it(six_bar, turn):
    """Torque and moment count the spread of the material too."""
    for criterion in (TORQUE, HEAVY, Peak("bearing_force", bearing="A")):
        corners = [np.array([np.cos(a), 0.0, np.sin(a)]) for a in np.arange(32) * 2 * np.pi / 32]
        disc, inner, outer = (
            balanced(six_bar, turn, region, criterion)
            for region in (
                CounterweightRegion("rod", radius=0.3),
                CounterweightRegion("rod", corners=tuple(tuple(0.3 * c) for c in corners)),
                CounterweightRegion("rod", corners=tuple(tuple(0.3 * c / np.cos(np.pi / 32)) for c in corners)),
            )
        )
        before = disc.changes[0].before
        assert outer.bound <= disc.value + 1e-9 * before
        assert disc.bound <= inner.value + 1e-9 * before
        assert inner.value - outer.value < 0.6 * (before - disc.value)


def test_more_room_is_never_worse(six_bar, turn):
    regions = [
        {"at": (0.1, 0.0, 0.1)},
        {"corners": ((0.1, 0.0, 0.1), (0.15, 0.0, 0.0))},
        {"corners": ((0.1, 0.0, 0.1), (0.15, 0.0, 0.0), (-0.1, 0.0, 0.05))},
        {"radius": 0.2},
        {"radius": 0.25, "centre": (-0.03, 0.0, 0.04)},
        {"radius": 0.25, "centre": (-0.03, 0.0, 0.04), "mass": (0.0, 300.0)},
    ]
    for criterion in (TORQUE, Range("shaking_force", "x")):
        found = [
            balance(six_bar, turn, regions=[CounterweightRegion("rod", **({"mass": (0.0, 80.0)} | region))], minimise=criterion)
            for region in regions
        ]
        for less, more in pairwise(found):
            assert more.bound <= less.value + 1e-9 * less.changes[0].before
        assert found[-1].value < found[0].value


@pytest.mark.parametrize("gyration", [0.0, 0.12])
def test_the_lightest_flywheel_is_a_rim(gyration):
    """A rotor is turned by a couple in proportion to its angular acceleration: a moment of inertia relieves the drive of it, with no mass
    moment, which would lift weight, and the lightest is m (radius^2 + gyration^2)."""
    drawing = Drawing("rotor")
    drawing.joint("O", "frame", "rotor", 0j)
    drawing.body("rotor", 2.0, 0j, tensor=np.diag([0.1, 0.1, 0.2]))
    press, needed, radius = texts.load(drawing.urdf("O")), 7.0, 0.4
    angle = np.linspace(0.0, 2 * np.pi, 40, endpoint=False)
    acceleration = 30 * np.cos(2 * angle) + 5
    servo = pp.servo_cycle(press, angle=angle, speed=4.0, acceleration=acceleration)
    force = needed * acceleration[:, None] * np.stack([-np.sin(angle), 0 * angle, np.cos(angle)], axis=1)  # on arms of half a metre
    loads = [pp.loads.PointForce("rotor", sign * force, (0.5 * sign, 0.0, 0.0)) for sign in (1, -1)]
    b = balance(
        press,
        servo,
        regions=[CounterweightRegion("rotor", radius=radius, gyration=gyration, mass=(0.0, 100.0))],
        minimise=Peak("driving_torque"),
        loads=loads,
    )
    (rim,) = b.counterweights
    assert b.changes[0].before == pytest.approx((needed - 0.2) * 35)
    assert b.value < 1e-7 * b.changes[0].before
    assert rim.mass * (radius**2 + gyration**2) == pytest.approx(needed - 0.2, rel=1e-6)
    assert rim.inertia == pytest.approx(needed - 0.2, rel=1e-6)
    assert np.abs(rim.position).max() < 1e-6


def test_a_room_in_place_of_the_links_own_mass(six_bar, turn):
    """The counterweight is all of the link; without a place it keeps the link's shape, centre and inertia in proportion."""
    b = balance(six_bar, turn, regions=[CounterweightRegion("rod", mass=(400.0, 400.0), replaces=True)], minimise=TORQUE)
    (rod,) = b.counterweights
    assert (rod.mass, rod.inertia) == (pytest.approx(400.0), pytest.approx(5.33 * 400 / 277.68))
    assert rod.position == pytest.approx((0.24, 0.0, 0.0), abs=1e-9)
    assert b.added_mass == pytest.approx(400 - 277.68)
    placed = balance(
        six_bar,
        turn,
        regions=[CounterweightRegion("rod", mass=(300.0, 300.0), at=(0.2, 0.0, 0.0), gyration=0.1, replaces=True)],
        minimise=TORQUE,
    )
    (rod,) = placed.counterweights
    assert (rod.mass, rod.inertia) == (pytest.approx(300.0), pytest.approx(3.0))
    joint = placed.press.model.getJointId("E")
    np.testing.assert_allclose(placed.press.model.inertias[joint].lever, (0.2, 0.0, 0.0), atol=1e-12)
    assert placed.press.model.inertias[joint].mass == pytest.approx(300.0)


def test_another_room_adds_to_a_link_that_is_replaced(six_bar, turn):
    regions = [
        CounterweightRegion("rod", mass=(300.0, 300.0), replaces=True),
        CounterweightRegion("rod", mass=(50.0, 50.0), at=(-0.1, 0.0, 0.0)),
    ]
    b = balance(six_bar, turn, regions=regions, minimise=TORQUE)
    assert [weight.mass for weight in b.counterweights] == pytest.approx([300.0, 50.0])
    assert b.press.model.inertias[six_bar.model.getJointId("E")].mass == pytest.approx(350.0)
    assert b.added_mass == pytest.approx(350 - 277.68)


def test_holes_take_mass_away(six_bar, turn):
    """Lightening holes in the rocker, and what is heavier elsewhere."""
    vertical = Range("shaking_force", "z")
    hole = CounterweightRegion("rod", at=(0.3, 0.0, 0.0), mass=(-60.0, 0.0), gyration=0.05)
    b = balance(six_bar, turn, regions=[hole], minimise=vertical)
    (weight,) = b.counterweights
    assert weight.mass == pytest.approx(-60.0)
    assert weight.inertia == pytest.approx(-60 * 0.05**2)
    assert b.press.model.inertias[six_bar.model.getJointId("E")].mass == pytest.approx(277.68 - 60)
    again = pp.inverse_dynamics(with_counterweights(six_bar, b.counterweights), turn)
    assert vertical.value(again) == pytest.approx(b.value, rel=1e-9)
    assert b.value < b.changes[0].before


def test_least_masses_are_kept_and_most_not_exceeded(six_bar, turn):
    regions = [CounterweightRegion("crank", radius=0.3, mass=(20.0, 50.0)), CounterweightRegion("coupler", radius=0.3, mass=(7.0, 9.0))]
    b = balance(six_bar, turn, regions=regions, minimise=Range("shaking_force", "x"))
    crank, coupler = (weight.mass for weight in b.counterweights)
    assert 20 - 1e-6 <= crank <= 50 + 1e-6
    assert 7 - 1e-6 <= coupler <= 9 + 1e-6


def test_rooms_on_links_that_are_welded_together_are_in_their_own_frames():
    """A crank-slider in a tilted plane with a plate welded askew to its crank: the same region, said in either frame."""
    drawing = Drawing("welded", np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0])
    drawing.joint("O", "frame", "crank", 0j, rpy=(0.3, -0.4, 1.0))
    drawing.joint("P", "crank", "rod", 0.1j)
    drawing.joint("guide", "frame", "slide", 0.5 + 0j, along=1 + 0j)
    drawing.weld("weld", "crank", "plate", 0.05 + 0.02j, height=0.1, rpy=(1.0, 0.2, -0.7))
    drawing.loop("W", "rod", "slide", 0.5 + 0j)
    for link in ("crank", "rod", "slide"):
        drawing.body(link, 5.0, 0.05j)
    press = texts.load(drawing.urdf("O"))
    motion, model = pp.cycle(press, 20.0, points=40), press.model
    crank, plate = (model.frames[model.getFrameId(link)].placement for link in ("crank", "plate"))
    along = press.engine("plane").plane.frames[0]  # the plane's axes in the frame of the crank's joint
    corners = [0.05 * along[0], 0.1 * along[1], -0.1 * along[0] + 0.02 * along[1]]
    for shape in ("disc", "corners"):
        found = []
        for link, frame in (("crank", crank), ("plate", plate)):
            inside = [tuple(float(x) for x in frame.actInv(corner)) for corner in corners]
            place = {"radius": 0.1, "centre": inside[0]} if shape == "disc" else {"corners": tuple(inside)}
            b = balance(press, motion, regions=[CounterweightRegion(link, mass=(0.0, 3.0), **place)], minimise=Rms("shaking_force"))
            found.append((b.value, *frame.act(np.array(b.counterweights[0].position))))
        np.testing.assert_allclose(*found, rtol=1e-6, atol=1e-7)


def test_regions_in_the_plane_of_two_motors():
    """A plane without gears has the same regions as with them, and the same best counterweights."""
    ratio, speed = 0.5, 4.0
    geared, press = five_bar(ratio), of_two_motors()
    turn = pp.cycle(geared, speed, points=72)
    motion = pp.servo_cycle(press, np.outer(turn.crank_angle, [1.0, ratio]), speed=[[speed, ratio * speed]] * 72, acceleration=0.0)
    regions = [CounterweightRegion("left_crank", radius=0.08, gyration=0.02), CounterweightRegion("right_crank", radius=0.1)]
    least = {Range("shaking_force", "x"): 1.0, Range("shaking_moment", "y"): 0.5}
    want, found = (balance(each, of, regions=regions, minimise=least) for each, of in ((geared, turn), (press, motion)))
    assert found.value == pytest.approx(want.value, rel=1e-7)
    ranges = [float(np.ptp(each.reactions_after[0].shaking_force[:, 0])) for each in (found, want)]
    assert ranges[0] == pytest.approx(ranges[1], rel=1e-5)


def test_a_region_in_millimetres_is_doubted(six_bar, turn):
    for region, said in (
        (CounterweightRegion("crank", radius=300.0), "radius is 300 m, beside a linkage of 1.86488 m: give it in m, 300e-3"),
        (CounterweightRegion("crank", at=(0.1, 0.0, 0.2), gyration=90.0), "gyration is 90 m, beside a linkage"),
    ):
        with pytest.warns(pp.PinpressWarning) as caught:
            balanced(six_bar, turn, region)
        assert all(f"region on 'crank': {said}" in str(warning.message) for warning in caught)
