"""What tolerances, clearances, heat and parallelism refuse, each with its message: a table of (call, message)."""

from functools import cache

import pytest
import yaml
from support import texts
from support.presses.two_servos import TWO_SERVOS

import pinpress as pp
from pinpress import tolerances as tol
from pinpress.derivatives import pivot_positions, reshaped
from pinpress.tolerances.dimensions import check_dimensions, correlation_matrix

PARALLELISM_SIDES = ("front", "back")


@cache
def six_bar():
    return texts.shipped("zxn2_3000b")


@cache
def light():
    """A crank-slide whose rod and crank weigh nothing."""
    return texts.load(texts.without_mass(texts.shipped("crank_slide").text.decode(), "rod", "crank"))


@cache
def two_points():
    return texts.shipped("jf75g_125_two_point")


def length(first, second, *arguments, **options):
    return tol.link_length(six_bar(), first, second, *(arguments or (1e-5,)), **options)


def correlation(coefficients):
    parts = [*(length(*pins) for pins in ("AB", "BC", "EF")), length("D", "E", shape="uniform")]
    return correlation_matrix(parts, coefficients)


def allocate(*arguments):
    parts = [length("A", "B", 50e-6), length("E", "F", 50e-6)]
    return tol.allocate(six_bar(), parts, *arguments)


def play(clearance, **options):
    return tol.play(light(), pp.cycle(light(), 9.0, points=8), clearance, **options)


def budget(**arguments):
    return tol.budget(light(), **{"speeds": [1.0], **arguments})


def rods(**options):
    """A dimension for each point of the two-point press, with the point's name unless options say otherwise."""
    return {f"P4_{side}": [tol.link_length(two_points(), f"P2_{side}", f"P4_{side}", 1e-5, **options)] for side in PARALLELISM_SIDES}


def parallelism(parts=None, **options):
    return tol.parallelism(two_points(), rods() if parts is None else parts, **options)


def single_point():
    single = texts.shipped("jf75g_125")
    return tol.parallelism(single, {"P4": [tol.link_length(single, "P2", "P4", 1e-5)]})


@cache
def sloped():
    return parallelism(samples=10)


def kept(rows, lengths=(1.0, 1.0)):
    return sloped().kept(rows, lengths)


@cache
def servos():
    press = pp.build(**yaml.safe_load(TWO_SERVOS))
    return press, pp.servo_cycle(press, [[0.1, 0.0], [0.2, 0.0]], speed=0.0), [tol.pin_position(press, "A", "x", 1e-5)]


@cache
def path():
    return pp.servo_cycle(six_bar(), [0.1, 0.2], speed=1.0)


def scatter(parts=None, press=None, **options):
    return tol.bottom_dead_centre(press or six_bar(), parts or [length("E", "F", 5e-5)], **options)


def of_a_longer_rod():
    return reshaped(six_bar(), {("F", "rod"): pivot_positions(six_bar())["F", "rod"] * 1.01})


def across_the_plane():
    press, together, _ = servos()
    return scatter([tol.pin_position(press, "A", "y", 1e-5)], press, motion=together)


def one_point_alone():
    return scatter([tol.link_length(two_points(), "O", "P2_back", 1e-5)], two_points())


REFUSALS = [
    (lambda: length("A", "F"), r"no link has the pins A, F \(A joins frame and crank; F joins"),
    (lambda: length("E", "E"), "named twice"),
    (lambda: length("E", "G"), "no bearing 'G'"),
    (lambda: length("slide_guide", "F"), "is a guide, not a pin"),
    (lambda: length("E", "F", 0.0), "tolerance of dimension 'EF' is 0.0: give one finite number, positive"),
    (lambda: tol.pin_position(six_bar(), "E", "x", 1e-5), "not on link 'frame'"),
    (lambda: tol.pin_position(six_bar(), "A", "u", 1e-5), "axis is 'u'"),
    (lambda: length("E", "F", shape="gauss"), "shape of 'EF' is 'gauss'"),
    (lambda: length("E", "F", shape="uniform", sd=1e-6), "leave out sd"),
    (lambda: length("E", "F", shape=[1e-5, 1e-5]), "at least two different deviations"),
    (lambda: tol.Dimension("d", {("F", "rod"): (0, 0, 0)}, 1e-5), "is zero, so it moves no pivot"),
    (lambda: check_dimensions(six_bar(), []), "parts is empty"),
    (lambda: check_dimensions(six_bar(), [length("E", "F")] * 2), "given twice: EF"),
    (lambda: correlation({("AB", "BC"): 0.9, ("BC", "EF"): 0.9, ("AB", "EF"): -0.9}), "contradict each other"),
    (lambda: correlation({("AB", "BC"): 1.1}), "a number from -1 to 1"),
    (lambda: correlation({("AB", "AB"): 0.5}), "not a pair of names"),
    (lambda: correlation({("AB", "BC"): 0.1, ("BC", "AB"): 0.2}), "given twice"),
    (lambda: correlation({("AB", "BC"): 0.0, ("BC", "AB"): 0.2}), "given twice"),
    (lambda: correlation({("AB", "XY"): 0.1}), "no dimension 'XY'"),
    (lambda: correlation({("AB", "DE"): 0.1}), "'DE' is not normal"),
    (lambda: allocate(None, {}), "targets is empty"),
    (lambda: allocate(None, {"heigth": 5e-5}), "no quantity 'heigth', did you mean 'height'"),
    (lambda: allocate(None, {"height": -5e-5}), "target of height is -5e-05: give one finite number, positive"),
    (lambda: allocate({"XY": 1.0}, {"height": 5e-5}), "no dimension 'XY'"),
    (lambda: allocate({"EF": 0.0}, {"height": 5e-5}), "cost of EF is 0.0"),
    (
        lambda: allocate(None, {"height": 5e-5}, {"EF": (2e-5, 1e-5)}),
        r"bounds of EF is \(2e-05, 1e-05\): give smallest and largest tolerance \[m\]",
    ),
    (lambda: tol.heat(six_bar(), tol.Temperatures({"frame": 5.0})), r"give the position of its table, Temperatures\(..., table"),
    (lambda: tol.heat(six_bar(), tol.Temperatures({"slide": 5.0})), "'slide' of zxn2_3000b is warm: give the position of its face"),
    (lambda: tol.heat(six_bar(), tol.Temperatures({"rods": 5.0})), "no link 'rods'"),
    (lambda: tol.Temperatures({}), r"rise is \{\}"),
    (lambda: tol.Temperatures({"rod": 5.0}, 12.0), r"expansion of all links is 12 1/K: give 0 to 0.0001 1/K; steel has 1\.2e-5"),
    (lambda: play({}), "clearance is empty"),
    (lambda: play({"Z": 1e-5}), "no bearing 'Z'"),
    (lambda: play({"W": 0.0}), "clearance of 'W'"),
    (lambda: play({"W": 0.5}), "0.5 m: give the radial clearance in m"),
    (lambda: play({"W": tol.GuideClearance(1e-5, 0.2)}), "this bearing is a pin, not a guide"),
    (lambda: play({"W": 1e-5}, known_to=5), "known_to is 5"),
    (lambda: tol.GuideClearance(1e-3, 0.002), "on each side, both in m"),
    (lambda: tol.play_over_speeds(light(), {"W": 1e-5}, speed=0.0), "give speeds other than zero"),
    (lambda: budget(), "give clearance, stiffness or temperatures"),
    (lambda: budget(clearance={"W": 1e-5}, speeds=[0.0]), "a speed of zero: give speeds of the crank"),
    (lambda: budget(clearance={"W": 1e-5}, stiffness_known_to=10.0), "stiffness_known_to is 10"),
    (lambda: budget(stiffness=pp.elasticity.Stiffness({"W": 1e9}), process="much"), "process"),
    (
        lambda: budget(stiffness=pp.elasticity.Stiffness({"W": 1e3})),
        "deflect by .* mm at 1 rad/s, but the stroke is only 200 mm: check",
    ),
    (lambda: parallelism({"P4_front": []}), "hangs on P4_front, P4_back, .* for each of these points"),
    (lambda: parallelism({"P4_front": [], "Z": []}), "no bearing 'Z'"),
    (lambda: parallelism({"P4_front": [], "P4_back": []}), "parts has no dimensions"),
    (lambda: parallelism(guide_stiffness=1e8), "give both, or neither"),
    (lambda: parallelism(guide_stiffness=1e8, point_stiffness=-1.0), "point_stiffness"),
    (lambda: parallelism(rods(name="rod")), "two different dimensions have the name 'rod'"),
    (lambda: parallelism(samples=10).within(-1e-5), "permissible"),
    (single_point, "hangs on one point, P4"),
    (lambda: kept({"loaded": tol.PermissibleSlope(1e-5, force=1e5)}), "'loaded' has a force.*give point_stiffness"),
    (lambda: kept({}), "no row"),
    (lambda: kept({"a": 1e-5}), "'a' is a float"),
    (lambda: kept({"a": tol.PermissibleSlope(1e-5)}, (0.0, 1.0)), "lengths"),
    (lambda: tol.PermissibleSlope(0.0), "are 0"),
    (lambda: tol.PermissibleSlope(1e-5, place=(1.0, 2.0, 3.0)), "place has shape"),
    (lambda: scatter(forces={0.4: 1e6}), "a height of 400 mm is not within the stroke of 301.261 mm"),
    (lambda: scatter(speeds={0.0: 1.0}), "height of speeds is 0.0: give one finite number, positive"),
    (lambda: scatter(forces={0.1: 0.0}), "is 0 N"),
    (lambda: scatter(samples=1), "samples is 1"),
    (lambda: scatter([length("B", "C", 0.1, sd=0.5)], samples=50), "of 56 presses, worst corners included, cannot be closed at"),
    (one_point_alone, "do not stay closed in this direction"),
    (across_the_plane, "redundant bearings of two_servos do not stay closed"),
    (lambda: scatter(servos()[2], servos()[0]), "has 2 drivers, so it has no dead centres.*motion=servo_cycle"),
    (lambda: tol.allocate(servos()[0], servos()[2], None, {"height": 1e-5}), "has 2 drivers"),
    (lambda: tol.heat(servos()[0], tol.Temperatures({"rod": 1.0})), "has 2 drivers"),
    (lambda: scatter(servos()[2], servos()[0], motion=path()), "the motion is of zxn2_3000b with other joints"),
    (lambda: scatter(motion=path(), speeds={0.1: 1.0}), "leave out motion"),
    (lambda: scatter(press=of_a_longer_rod(), motion=path()), "leaves the loops of zxn2_3000b open by .* of other lengths"),
]


@pytest.mark.filterwarnings("ignore:Stiffness", "ignore:dimension 'BC'")
@pytest.mark.parametrize(("call", "message"), REFUSALS, ids=[message for _, message in REFUSALS])
def test_refusals(call, message):
    with pytest.raises(pp.PinpressError, match=message):
        call()
