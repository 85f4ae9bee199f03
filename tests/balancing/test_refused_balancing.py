"""What counterweights, rotors and arrangements refuse, each with its message: a table of (call, message)."""

from functools import cache

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.balancing import (
    AddedMass,
    Counterweight,
    CounterweightRegion,
    OperatingCondition,
    Peak,
    Range,
    Rms,
    classical,
    with_counterweights,
)


@cache
def press(name):
    return texts.shipped(name)


def loaded(*counterweight):
    return with_counterweights(press("zxn2_3000b"), [Counterweight(*counterweight)])


def region(**options):
    return CounterweightRegion("crank", **options)


def two_planes(mass, positions, planes):
    return classical.two_plane_balance(mass, positions, planes=planes)


def opposed(**sizes):
    return classical.with_opposed_balancer(press("jf75g_125_plain"), **sizes)


def shafts(**sizes):
    return classical.with_balance_shafts(press("jf75g_125_plain"), **{"radius": 0.1, "shaft_distance": 0.5} | sizes)


def unbalance(link):
    return classical.unbalance(press("crank_slide"), link)


def mirrored(name, distance=0.5):
    return classical.mirrored(press(name), distance)


def opposed_of(name):
    return classical.with_opposed_balancer(press(name), 0.1)


def share(value):
    return classical.approximate_balance(press("crank_slide"), 0.1, share=value)


def complete(rod_radius, crank_radius):
    return classical.complete_balance(press("crank_slide"), rod_radius=rod_radius, crank_radius=crank_radius)


def corrected(radius):
    return classical.static_balance([2.0, 3.0], [[0.1, 0.2, 0.0], [-0.2, 0.1, 0.1]]).counterweight("rotor", radius)


@cache
def turn(name, speed=7.0, points=72):
    return pp.cycle(press(name), speed, points=points)


def harmonics(**changed):
    """Of the plain press before, and at another speed or with other states after."""
    plain = press("jf75g_125_plain")
    results = [pp.inverse_dynamics(plain, turn("jf75g_125_plain", **options)) for options in ({}, changed)]
    return classical.compare_harmonics(*results)


X, Z, MASS = Range("shaking_force", "x"), Range("shaking_force", "z"), AddedMass()
AT = CounterweightRegion("crank", at=(-0.1, 0, 0))
DISCS = [CounterweightRegion(link, radius=radius) for link, radius in (("crank", 0.3), ("rocker", 0.6), ("rod", 0.3))]


def balanced(regions, minimise=X, limits=None, **options):
    return pp.balancing.balance(
        press("zxn2_3000b"), **{"motion": turn("zxn2_3000b"), "regions": regions, "minimise": minimise, "limits": limits} | options
    )


def traded(first=X, second=Z, **options):
    return pp.balancing.trade_off(press("zxn2_3000b"), turn("zxn2_3000b"), regions=DISCS, first=first, second=second, **options)


@cache
def with_dies(*masses):
    """The plain press with upper dies."""
    plain, found = press("jf75g_125_plain"), []
    for mass in masses:
        heavier = with_counterweights(plain, [Counterweight("slide", mass, (0.0, 0.0, -0.4))])
        found.append(OperatingCondition(pp.cycle(heavier, 7.0, points=72), press=heavier, name=f"die of {mass:g} kg"))
    return found


def with_two_dies(region=AT, **options):
    return pp.balancing.balance(press("jf75g_125_plain"), with_dies(100.0, 400.0), regions=[region], minimise=Z, **options)


def of_another_press():
    conditions = [*with_dies(100.0), OperatingCondition(turn("zxn2_3000b"), press=press("zxn2_3000b"))]
    return pp.balancing.balance(press("jf75g_125_plain"), conditions, regions=[AT], minimise=Z)


def compared(*masses):
    return pp.balancing.compare_conditions(press("jf75g_125_plain"), with_dies(*masses), regions=[AT], minimise=Z)


PLACE = (0.0, 0.0, 0.0)
REFUSALS = [
    (lambda: classical.harmonic_coefficients(1.0), "at most"),
    (lambda: classical.harmonic_coefficients(0.0), "positive"),
    (lambda: classical.harmonic_coefficients(0.2, 0), "from 1"),
    (lambda: classical.harmonic_coefficients(0.2, 2.5), "from 1"),
    (lambda: opposed(crank_radius=0.0), "crank_radius is 0.0: give a positive number"),
    (lambda: opposed(crank_radius=0.03, rod_length=-1), "rod_length is -1: give a positive"),
    (lambda: opposed(crank_radius=0.03, rod_length=0.02), "crank_radius is 0.03 m: give a longer rod"),
    (lambda: opposed(crank_radius=0.03, rod_mass=0.0), "rod_mass is 0.0"),
    (lambda: opposed(crank_radius=0.03, rod_inertia=np.nan), "rod_inertia is nan"),
    (lambda: opposed(crank_radius=0.03, rod_mass=3000.0), "its share at the far pin exceeds the 1119.37 kg that balance the slide"),
    (lambda: shafts(orders=(3,)), r"crank-slider \(1, 2, 4, 6"),
    (lambda: shafts(orders=(2, 2)), "each once"),
    (lambda: shafts(orders=()), "each once"),
    (lambda: shafts(orders=(0,)), "from 1"),
    (lambda: shafts(radius=0.0), "radius"),
    (lambda: shafts(shaft_distance=-1.0), "shaft_distance"),
    (lambda: mirrored("jf75g_125", 0.0), "shaft_distance is 0.0: give a positive number"),
    (lambda: mirrored("jf75g_125_symmetric"), "has gear pairs"),
    (lambda: mirrored("zxn2_3000b"), "the line of bearing 'F' passes the shaft at 1.25 m"),
    (lambda: mirrored("thin_wall"), "the line of bearing 'E' passes the shaft at 0.28 m"),
    (lambda: two_planes([1.0], [[0, 0]], (0, 1)), r"positions \(1, 2\)"),
    (lambda: two_planes([1.0, 2.0], [[0, 0, 0]], (0, 1)), r"masses has shape \(2,\)"),
    (lambda: two_planes([np.nan], [[0, 0, 0]], (0, 1)), "masses is not finite"),
    (lambda: two_planes([1.0], [["a", 0, 0]], (0, 1)), "positions is not a number or an array of numbers"),
    (lambda: two_planes([1.0], [[0, 0, 1]], (0.2, 0.2)), "two different planes"),
    (lambda: two_planes([1.0], [[0, 0, 1]], (0.2, 0.3, 0.4)), "two different planes"),
    (lambda: two_planes([1.0], [[0, 0, 1]], 0.3), "one number for each plane"),
    (lambda: two_planes([1.0], [[0, 1, 1]], (0.0, 1e-320)), "planes that are further apart"),
    (lambda: unbalance("rod"), "'rod' does not turn on the frame: give one of crank"),
    (lambda: unbalance("slide"), "'slide' does not turn on the frame: give one of crank"),
    (lambda: unbalance("frame"), "'frame' does not turn on the frame: give one of crank"),
    (lambda: unbalance("cranck"), "did you mean 'crank'"),
    (lambda: loaded("crnk", 1.0), "crnk.*crank"),
    (lambda: loaded("frame", 1.0), "'frame' does not move.*rocker"),
    (lambda: loaded("crank", np.nan), "'crank'.*mass.*nan.*finite"),
    (lambda: loaded("crank", 1.0, (0.0, np.inf, 0.0)), "'crank'.*position"),
    (lambda: loaded("crank", 1.0, (0.0, 0.0)), "'crank'.*position"),
    (lambda: loaded("crank", 1.0, PLACE, np.inf), "'crank'.*inertia.*finite"),
    (lambda: loaded("crank", "heavy"), "'crank'.*mass.*'heavy'"),
    (lambda: loaded("crank", 1.0, PLACE, -1.0), "'crank'.*no body has an inertia"),
    (lambda: loaded("crank", 0.0, PLACE, 1.0), "'crank'.*no body has an inertia.* 0 kg"),
    (lambda: loaded("rod", -277.68), "'E' a mass of 0 kg: remove less mass"),
    (lambda: loaded("rod", -300.0), "'E' a mass of -22.32 kg"),
    (lambda: loaded("rod", -100.0, (1.5, 0.0, 0.0)), "'E' principal moments.*no body"),
    (lambda: with_counterweights(press("zxn2_3000b"), [("rod", 5.0)]), r"give Counterweight\(link, mass, position\)"),
    (lambda: region(), "'crank'.*at, radius or corners"),
    (lambda: region(at=PLACE, radius=0.1), "'crank'.*one of"),
    (lambda: region(radius=-0.1), "'crank'.*radius.*-0.1"),
    (lambda: region(radius=float("nan")), "'crank'.*radius is nan"),
    (lambda: region(at=PLACE, gyration=-1.0), "'crank'.*gyration.*-1.0"),
    (lambda: region(radius=0.1, mass=(5, 1)), r"'crank'.*\(5, 1\).*least and largest mass"),
    (lambda: region(radius=0.1, mass=(float("nan"), 1)), "'crank'.*nan"),
    (lambda: region(radius=0.1, mass=7.0), "'crank'.*7.0"),
    (lambda: region(radius=0.1, mass=(-5, 1)), "'crank'.*-5 kg.*at=..."),
    (lambda: region(replaces=True, gyration=0.1), "'crank'.*gyration"),
    (lambda: region(reset="mass", radius=0.1), "needs a fixed place"),
    (lambda: region(reset="position", at=(0.1, 0, 0)), "needs room"),
    (lambda: region(reset="position", replaces=True), "needs room"),
    (lambda: region(reset="shape", radius=0.1), "reset is 'shape'"),
    (lambda: Range("shaking_force"), "range.*axis.*Rms or Peak"),
    (lambda: Range("speed", "x"), "speed.*shaking_force"),
    (lambda: Range("shaking_force", "w"), "'w'.*'x'"),
    (lambda: Rms("shaking_force", (0.0, 0.0, 0.0)), "axis.*three numbers"),
    (lambda: Peak("bearing_force"), "bearing="),
    (lambda: Peak("shaking_force", bearing="A"), "bearing="),
    (lambda: Range("driving_torque", "x"), "no axis"),
    (lambda: Rms("shaking_force", about=(0, 0, 1)), "about.*shaking moment"),
    (
        lambda: classical.as_crank_slider(press("zxn2_3000b")),
        "it has 5 moving links, 2 loops and 0 gear pairs, not 3, 1 and 0",
    ),
    (lambda: opposed_of("jf75g_125_symmetric"), "is not a centred crank-slider: .*8 moving links, 4 loops and 1 gear pairs"),
    *((lambda value=value: share(value), "share is .* from 0 to 1") for value in (-0.1, 1.1, np.nan, "half", True)),
    (lambda: complete(0.0, 0.1), "radius of the counterweight on 'rod' is .* give a positive number"),
    (lambda: complete(0.1, -0.1), "radius of the counterweight on 'crank' is .* give a positive number"),
    *((lambda value=value: corrected(value), "'rotor' is .* give a positive number") for value in (0.0, -0.1, np.nan, np.inf, "0.1", True)),
    (lambda: harmonics(speed=14.0), "different speeds"),
    (lambda: harmonics(points=12), "does not have a full period of 13 states"),
    (lambda: classical.compare_harmonics(press("crank_slide"), press("crank_slide")), "is a Linkage"),
    (lambda: balanced([CounterweightRegion("crnk", radius=0.1)]), "crnk.*crank"),
    (lambda: balanced([CounterweightRegion("frame", radius=0.1)]), "frame.*does not move.*crank"),
    (lambda: balanced([]), r"regions.*CounterweightRegion\("),
    (lambda: balanced(["crank"]), r"regions.*CounterweightRegion\("),
    (lambda: balanced([AT], Peak("bearing_force", bearing="Q")), "'Q'.*A"),
    (lambda: balanced([AT], "shaking_force"), "shaking_force.*Range"),
    (lambda: balanced([AT], {X: 0.0}), "weight.*above zero"),
    (lambda: balanced([AT], {X: -1.0}), "weight.*shaking force, x.*-1.0.*not negative"),
    (lambda: balanced([AT], {X: float("nan")}), "weight.*nan"),
    (lambda: balanced([AT], X, {Z: -1}), "limit.*shaking force, z.*-1"),
    (lambda: balanced([AT], Range("shaking_force", "y")), "shaking force, y.*zero before balancing.*leave it out"),
    (lambda: balanced([AT], Rms("bearing_moment", bearing="C")), "bearing moment of C.*zero before balancing"),
    (lambda: balanced(DISCS, Z, {X: 10.0, MASS: 100.0}), "(?=.*shaking force, x, 10 N)(?=.*added mass, 100 kg).*relax each limit by"),
    (lambda: balanced(DISCS[:1], Z, {X: 0.0}), "shaking force, x, 0 N"),
    (
        lambda: balanced([CounterweightRegion("crank", mass=(200, 300), radius=0.3)], X, {MASS: 100.0}),
        "(?=.*least mass of .*'crank', 200 kg).*added mass, 100 kg",
    ),
    (lambda: balanced([CounterweightRegion("slide", radius=0.1, replaces=True)] * 2), "two regions.*'slide'"),
    (lambda: balanced([CounterweightRegion("crank", corners=((0.1, 0, 0), (0.1, 0.2, 0)))]), "'crank'.*different planes"),
    (lambda: balanced([CounterweightRegion("crank", corners=((0.1, 0, 0),) * 2)]), "'crank'.*its size is zero.*at="),
    (lambda: balanced([CounterweightRegion("crank", at=(-0.1, 0, 0), mass=(-5000.0, 0.0))], MASS), "mass of.*remove less mass"),
    # A bearing's peak goes on falling for ever smaller lifts of ever heavier rockers.
    (lambda: balanced(DISCS, Peak("bearing_force", bearing="A")), r"grow beyond.*'rocker'.*mass=\(0, most\)"),
    (lambda: balanced(DISCS, motion=turn("jf75g_125")), "jf75g_125"),
    (lambda: balanced(DISCS, motion=[turn("zxn2_3000b")]), "OperatingCondition"),
    (lambda: balanced(DISCS, motion=[]), "OperatingCondition"),
    (
        lambda: balanced(DISCS, motion=[OperatingCondition(turn("zxn2_3000b"))], loads=[pp.loads.PointForce("slide", (0, 0, 1.0))]),
        "loads to every OperatingCondition",
    ),
    (lambda: traded(second=X), "both criteria are the range of the shaking force, x: give two"),
    (lambda: traded(points=1), "whole number from 2"),
    (lambda: traded(second="z"), "not a criterion"),
    (lambda: with_two_dies(shares=(1.0,)), "one for each operating condition"),
    (lambda: with_two_dies(shares=(0.0, 0.0)), "not all zero"),
    (lambda: with_two_dies(shares=(1.0, -1.0)), "not negative"),
    (lambda: with_two_dies(CounterweightRegion("slide", replaces=True)), "so the region is not the same body in all"),
    (of_another_press, "differs from jf75g_125_plain in: links"),
    (lambda: compared(100.0), "fewer than two"),
    (lambda: compared(100.0, 100.0), "have the same name"),
]


@pytest.mark.parametrize(("call", "message"), REFUSALS)
def test_refusals(call, message):
    with pytest.raises(pp.PinpressError, match=message):
        call()
