"""The proof of an optimum: on linkages nobody thought of no admissible counterweights are better than the bound, whatever is measured; and
what it rests on, that forces change by masses as is said."""

from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import lsq_linear
from support import texts
from support.generators.random_linkages import Group, Spec, drawn
from support.generators.spatial_linkages import bennett, four_bar
from support.oracles import cassie

import pinpress as pp
from pinpress.balancing import (
    AddedMass,
    Counterweight,
    CounterweightRegion,
    OperatingCondition,
    Peak,
    Range,
    Rms,
    balance,
    with_counterweights,
)
from pinpress.balancing.counterweights import PointMasses, mass_response

MASS = AddedMass()
STATES = 12
SEEDS = range(4)


@pytest.fixture(scope="module")
def planar():
    """Random linkages of two dyads by their seeds: in tilted planes, links in several of them, welded together, with mass off the plane."""

    @cache
    def made(seed):
        kinds = ("RRR", "RRP", "RPR", "PRR")
        groups = (Group("RRR", seed % 3, (1, 0, 0)), Group(kinds[seed % 4], (seed + 1) % 3, (2, 0, 0)))
        drawing = drawn(Spec(groups, 7 + seed, tilted=seed > 0, stacked=seed > 1, solid=seed > 0, extra=seed > 2))
        return texts.load(drawing.urdf("crank"))

    return made


def moving(press):
    return [link for link in press.links if press.model.frames[press.model.getFrameId(link)].parentJoint]


# ------------------------------------------------------------------------------------------------------------------ what masses change


def swing(press, engine="auto"):
    """A motion with speeds and accelerations that have nothing to do with its angles."""
    rng, drivers = np.random.default_rng(3), len(press.drivers)
    shape = (STATES, drivers) if drivers > 1 else STATES
    return pp.servo_cycle(
        press,
        angle=rng.uniform(-0.05, 0.05, shape),
        speed=rng.uniform(-9, 9, shape),
        acceleration=rng.uniform(-50, 50, shape),
        engine=engine,
    )


def check_change(press, link, engine):
    """Counterweights on a link against `mass_response`, to 1e-11 of the largest force: both are differences of two results."""
    rng, motion, size = np.random.default_rng(8), swing(press, engine), press.size
    masses, points = press.model.inertias[1].mass * rng.uniform(0.1, 0.5, 2), 0.5 * size * rng.normal(size=(2, 3))
    loads = [pp.loads.PointForce(link, (30.0, -20.0, 10.0), (0.1, 0.0, 0.2))]
    before = pp.inverse_dynamics(press, motion, loads)
    weights = [Counterweight(link, mass, tuple(point)) for mass, point in zip(masses, points, strict=True)]
    after = pp.inverse_dynamics(with_counterweights(press, weights), motion, loads, engine=engine)
    found = mass_response(press, OperatingCondition(motion, loads), before, PointMasses(link, masses, points), inner_forces=True)
    force = max(np.abs(after.shaking_force).max(), *(np.abs(values).max() for values in after.bearing_force.values()))
    for name, scale in (("shaking_force", 1.0), ("shaking_moment", size), ("driving_torque", size)):
        assert np.abs(getattr(found, name) - (getattr(after, name) - getattr(before, name))).max() <= 1e-11 * scale * force, name
    for bearing in press.bearings:
        assert np.abs(found.bearing_force[bearing] - (after.bearing_force[bearing] - before.bearing_force[bearing])).max() <= 1e-11 * force
        moment = found.bearing_moment[bearing] - (after.bearing_moment[bearing] - before.bearing_moment[bearing])
        assert np.abs(moment).max() <= 1e-11 * size * force, bearing


@pytest.mark.parametrize("engine", ["auto", "pinocchio"])
@pytest.mark.parametrize("seed", SEEDS)
def test_masses_change_the_forces_of_planar_linkages(planar, seed, engine):
    for link in moving(planar(seed))[:: 3 + seed]:
        check_change(planar(seed), link, engine)


@pytest.mark.parametrize(
    ("text", "link"),
    [(bennett(), "link2"), (four_bar("revolute"), "back"), (four_bar("revolute", "table"), "crank"), (cassie.urdf(), "left-foot-crank")],
    ids=["bennett", "four_bar", "turntable", "cassie"],
)
def test_masses_change_the_forces_of_linkages_in_space(text, link):
    """And of those that close more than they must, and have several drivers."""
    check_change(texts.load(text), link, "pinocchio")


@pytest.mark.parametrize("link", ["crank_right", "auxiliary_rod_left"])
def test_masses_change_the_forces_of_geared_shafts(link):
    check_change(texts.shipped("jf75g_125_symmetric"), link, "auto")


# ----------------------------------------------------------------------------------------------------------------- nothing is better

ANY = (
    Range("shaking_force", "x"),
    Range("shaking_force", (1.0, 2.0, -2.0)),
    Rms("shaking_force"),
    Peak("shaking_force"),
    Rms("shaking_moment", about=(0.3, -0.2, 0.5)),
    Peak("shaking_moment", about=(0.3, -0.2, 0.5)),
    Range("driving_torque"),
    Peak("driving_torque"),
    Peak("bearing_force", bearing="crank"),
    Range("bearing_force", "z", bearing="loop_0"),
    Rms("bearing_force", bearing="crank"),
    Rms("bearing_moment", bearing="crank"),
)


def regions_of(press, rng):
    """A disc, a polygon and a point on random links, of at most half the press's mass each."""
    most, size = 0.5 * sum(i.mass for i in press.model.inertias), 0.3 * press.size
    regions = []
    for kind in ("disc", "corners", "at"):
        link = str(rng.choice(moving(press)))
        in_link = press.model.frames[press.model.getFrameId(link)]
        frame = press.engine("plane").plane.frames[in_link.parentJoint - 1]
        along = (in_link.placement.rotation.T @ frame.T).T  # the plane's axes in the link's frame
        middle, arms = size * rng.normal(size=3), size * rng.normal(size=(4, 2)) @ along[:2]
        place = {
            "disc": {"radius": size, "centre": tuple(middle)},
            "corners": {"corners": tuple(tuple(middle + arm) for arm in arms)},
            "at": {"at": tuple(middle)},
        }[kind]
        regions.append(
            (CounterweightRegion(link, mass=(0.0, most), gyration=float(rng.choice([0.0, 0.1 * size])), **place), middle, arms, along)
        )
    return regions


def random_filling(region, middle, arms, along, rng):
    """Point masses anywhere in a region, of the region's gyration."""
    share = rng.dirichlet(np.ones(3)) * region.mass[1] * rng.choice([0.0, 0.1, 1.0]) * rng.uniform()
    if region.at is not None:
        points = np.tile(middle, (3, 1))
    elif region.corners:
        points = middle + rng.dirichlet(0.3 * np.ones(len(arms)), 3) @ arms
    else:
        points = middle + region.radius * (rng.uniform(0, 1, (3, 1)) ** 0.2) * _unit(rng) @ along[:2]
    return [Counterweight(region.link, m, tuple(p), m * region.gyration**2) for m, p in zip(share, points, strict=True)]


def _unit(rng):
    angle = rng.uniform(0, 2 * np.pi, 3)
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def part_of(weights, share):
    return [Counterweight(w.link, share * w.mass, w.position, share * w.inertia) for w in weights]


@pytest.mark.one_in(9)
@pytest.mark.parametrize("number", range(len(ANY)))
def test_no_counterweights_beat_the_bound(planar, number):
    """In two conditions, one with loads. Random ones, and the best with a little of these mixed in: convexity has no other way out."""
    press, rng = planar(number % len(SEEDS)), np.random.default_rng(number)
    criteria = (ANY[number], ANY[(5 * number + 1) % len(ANY)])[: 1 + number % 2]
    conditions = [
        OperatingCondition(swing(press)),
        OperatingCondition(swing(press), [pp.loads.PointForce(press.links[-1], rng.normal(size=(STATES, 3)) * 100)]),
    ]
    regions = regions_of(press, rng)
    before = [pp.inverse_dynamics(press, case.motion, case.loads) for case in conditions]
    sizes = {m: max(m.value(r) for r in before) for m in criteria}
    b = balance(press, conditions, regions=[region for region, *_ in regions], minimise=dict.fromkeys(criteria, 1.0))

    def worst(weights):
        changed = with_counterweights(press, weights)
        after = [pp.inverse_dynamics(changed, case.motion, case.loads) for case in conditions]
        return sum(max(m.value(r) for r in after) / sizes[m] for m in criteria)

    assert b.value == pytest.approx(worst(b.counterweights), abs=1e-8)
    assert -1e-8 <= b.value - b.bound <= 1e-7 * len(criteria)
    assert b.value <= len(criteria) * (1 + 1e-7)  # to leave the press alone is admissible
    for share in (1.0, 1.0, 1.0, 0.3, 0.03, 0.003):
        other = [weight for region, middle, arms, along in regions for weight in random_filling(region, middle, arms, along, rng)]
        assert worst([*part_of(b.counterweights, 1 - share), *part_of(other, share)]) >= b.bound - 1e-9


@pytest.mark.exhaustive
def test_no_masses_beat_the_bound_in_space():
    """Bennett's linkage: masses at points, a hole among them, and one in place of a link's own, which keeps its shape."""
    press = texts.load(bennett())
    motion = pp.servo_cycle(press, angle=np.linspace(-0.5, 0.5, STATES), speed=9.0)
    own = press.model.inertias[1].mass
    regions = [
        CounterweightRegion("link1", mass=(0.5, 10.0), replaces=True),
        CounterweightRegion("link2", at=(0.1, 0.1, 0.0), mass=(-0.2, 5.0), gyration=0.02),
        CounterweightRegion("link3", at=(-0.1, 0.05, 0.2), mass=(0.0, 5.0)),
    ]
    body = press.model.inertias[1]
    rng = np.random.default_rng(4)
    for criterion in (
        Rms("shaking_force"),
        Peak("driving_torque"),
        Range("shaking_moment", (1.0, 1.0, 0.0)),
        Peak("bearing_force", bearing="J3"),
    ):
        b = balance(press, motion, regions=regions, minimise=criterion)
        assert -1e-8 <= (b.value - b.bound) / b.changes[0].before <= 1e-7
        assert criterion.value(pp.inverse_dynamics(b.press, motion)) == pytest.approx(b.value, rel=1e-9)
        for _ in range(4):
            masses = [rng.uniform(*region.mass) for region in regions]
            weights = [Counterweight(r.link, m, r.at, m * r.gyration**2) for r, m in zip(regions[1:], masses[1:], strict=True)]
            changed = with_counterweights(press, weights)
            inertias = list(changed.model.inertias)
            inertias[1] = pin.Inertia(masses[0], body.lever, body.inertia * masses[0] / own)
            assert criterion.value(pp.inverse_dynamics(changed.with_inertias(inertias), motion)) >= b.bound
    with pytest.raises(pp.PinpressError, match=r"'link2': bennett is not planar.*at="):
        balance(press, motion, regions=[CounterweightRegion("link2", radius=0.1)], minimise=Rms("shaking_force"))


@pytest.mark.parametrize("name", ["jf75g_125", "thin_wall", "jf75g_125_plain"])
@pytest.mark.parametrize("criterion", [Range("shaking_force", "z"), Rms("driving_torque"), Peak("bearing_force", bearing="slide_guide")])
def test_shipped_presses_are_proved_to_rounding(name, criterion):
    press = texts.shipped(name)
    regions = [CounterweightRegion(link, radius=0.2) for link in press.links[1:]]
    b = balance(press, pp.cycle(press, 20.0, points=90), regions=regions, minimise=criterion, limits={MASS: 50.0})
    assert -1e-8 <= (b.value - b.bound) / b.changes[0].before <= 1e-7
    assert b.residual < 1e-8
    assert b.value < (1 - 1e-4) * b.changes[0].before


# ---------------------------------------------------------------------------------------------------------- bounded least squares


@pytest.mark.parametrize(
    "criterion", [Rms("shaking_force"), Rms("driving_torque"), Rms("bearing_force", bearing="D")], ids=lambda m: m.words
)
def test_rms_of_masses_at_points_is_bounded_least_squares(criterion):
    """Columns are finite changes, by 1 kg; SciPy's active set finds the same masses, with their bounds from 0 or below to 150 kg."""
    press = texts.shipped("zxn2_3000b")
    motion = pp.cycle(press, 7.0, points=72)
    regions = [
        CounterweightRegion("crank", at=(-0.2, 0, 0.1), mass=(0, 150)),
        CounterweightRegion("crank", at=(-0.1, 0, -0.3), mass=(0, 150)),
        CounterweightRegion("coupler", at=(-0.3, 0, 0), mass=(-20, 150), gyration=0.1),
        CounterweightRegion("rocker", at=(0.2, 0, 0.5), mass=(0, 150)),
        CounterweightRegion("rod", at=(-0.2, 0, 0.1), mass=(0, 150)),
    ]
    after = [pp.inverse_dynamics(press, motion)]
    for region in regions:
        weight = Counterweight(region.link, 1.0, region.at, region.gyration**2)
        after.append(pp.inverse_dynamics(with_counterweights(press, [weight]), motion))
    series = [criterion.series(reactions) for reactions in after]
    fixed, *others = [(s - s.mean(axis=0)).ravel() / np.sqrt(len(s)) for s in series]
    matrix = np.array([other - fixed for other in others]).T
    felt = np.linalg.norm(matrix, axis=0) > 1e-9 * np.linalg.norm(matrix)  # bearing D does not feel what the crank carries
    matrix[:, ~felt] = 0.0
    best = lsq_linear(matrix, -fixed, tuple(np.array([region.mass for region in regions]).T), method="bvls", tol=1e-14)
    b = balance(press, motion, regions=regions, minimise=criterion)
    assert b.value == pytest.approx(np.sqrt(2 * best.cost), rel=1e-8)
    masses = {(weight.link, weight.position): weight.mass for weight in b.counterweights}
    found = [next((m for (link, at), m in masses.items() if link == region.link and np.allclose(at, region.at)), 0.0) for region in regions]
    # The lighter of designs that are as good to 1e-6 wins: along the flattest direction
    np.testing.assert_allclose(found, np.where(felt, best.x, 0.0), atol=1e-2)


@pytest.mark.parametrize("points", [36, 360])
def test_what_a_criterion_is_larger_by_between_the_states_is_said(points):
    """The proof is that of the states; a load begins between them, and with eight times as many the range is larger."""
    press, load = texts.shipped("zxn2_3000b"), [pp.loads.DeepDrawing(1e6, 0.01)]
    region = CounterweightRegion("crank", radius=0.3, mass=(0.0, 400.0))
    speed, wanted = 70 * pp.RPM, Range("driving_torque")
    found = balance(press, pp.cycle(press, speed, points=points), regions=[region], minimise=wanted, loads=load)
    finer = pp.inverse_dynamics(found.press, pp.cycle(found.press, speed, points=8 * points), load).driving_torque
    assert found.between_states == pytest.approx((np.ptp(finer) - found.value) / found.changes[0].before, rel=1e-9)
    assert 1e-4 < found.between_states < 0.2
    assert "between the states" in str(found)
