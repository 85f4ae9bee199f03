"""What counterweights, rotors and arrangements refuse, each with its message: a table of (call, message)."""

from functools import cache

import numpy as np
import pytest
from support import texts

import pinpress as pp
from pinpress.balancing import Counterweight, CounterweightRegion, Peak, Range, Rms, classical


@cache
def press(name):
    return texts.shipped(name)


def loaded(*counterweight):
    return pp.balancing.with_counterweights(press("zxn2_3000b"), [Counterweight(*counterweight)])


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
    (lambda: pp.balancing.with_counterweights(press("zxn2_3000b"), [("rod", 5.0)]), r"give Counterweight\(link, mass, position\)"),
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
]


@pytest.mark.parametrize(("call", "message"), REFUSALS)
def test_refusals(call, message):
    with pytest.raises(pp.PinpressError, match=message):
        call()
