"""Pins and rolling bearings: an independent script's values, closed forms, and what is refused."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from support.texts import shipped

import pinpress as pp
from pinpress.ratings import Gibs, PlainBearing, RollingBearing, pins

SIZES = {"O": (0.12, 0.10), "P": (0.10, 0.08), "W": (0.08, 0.08)}
RATINGS = {"O": 800e3, "P": 600e3, "W": 500e3}
# independent NumPy script in maximal coordinates: crank_slide at 10 rad/s, 1e5 N from 30 to 5 mm on the way down
BY_SCRIPT = {
    "way": (6.2831853072, 6.2831853072, 1.0107210206),  # rad a stroke
    "rubbing_way": (0.37699111843, 0.31415926536, 0.040428840823),
    "largest_force": (99086.984881, 99318.62483, 99570.171246),
    "largest_pressure": (8.2572487401e6, 12.414828104e6, 15.557839257e6),
    "pressure": (0.65897969722e6, 0.96866399789e6, 1.1955553968e6),
    "pressure_over_way": (0.65897969722e6, 1.168043311e6, 1.5844337337e6),
    "pv": (0.39538781833e6, 0.58402165551e6, 0.10194959417e6),
}
EQUIVALENT = {"ball": (40240.592774, 43093.166522, 44840.936959), "roller": (43996.365835, 46805.103635, 48523.040518)}
STROKES = {"ball": (7.8573636296e9, 2.6991593728e9, 8.6185567822e9), "roller": (15.809226002e9, 4.9301499744e9, 14.800914948e9)}
DIGITS = 1e-10  # of the printed values, which have 11 digits


def reactions(points: int = 360, load: float = 1e5) -> pp.Reactions:
    press = shipped("crank_slide")
    loads = [pp.loads.ForceStroke([0.005, 0.03], [load, load])] if load else []
    return pp.inverse_dynamics(press, pp.cycle(press, 10.0, points=points), loads)


@pytest.mark.parametrize("points", [360, 77])  # where the states are does not matter
def test_pins_of_a_crank_slide(points: int) -> None:
    found = pins(reactions(points), {name: PlainBearing(*size, wear_rate=1e-15) for name, size in SIZES.items()})
    for quantity, values in BY_SCRIPT.items():
        assert [getattr(found[name], quantity) for name in SIZES] == pytest.approx(values, rel=DIGITS), quantity
    assert math.degrees(found["W"].at) == pytest.approx(318.96034368, abs=1e-7)
    assert math.degrees(found["W"].swing or 0) == pytest.approx(28.9550243719, abs=1e-10)
    assert found["O"].swing is None
    assert found["P"].swing is None
    assert found["W"].wear == pytest.approx(1e-15 * found["W"].pv * 2 * np.pi / 10.0, rel=1e-12)  # k p v over the time of a stroke


@pytest.mark.parametrize("kind", ["ball", "roller"])
def test_rolling_bearings_of_a_crank_slide(kind: str) -> None:
    found = pins(reactions(), {name: RollingBearing(rating, kind, static_rating=1e6) for name, rating in RATINGS.items()})
    uses = list(found.uses.values())
    assert [use.equivalent_load for use in uses] == pytest.approx(EQUIVALENT[kind], rel=DIGITS)
    assert [use.strokes for use in uses] == pytest.approx(STROKES[kind], rel=DIGITS)
    assert [use.hours for use in uses] == pytest.approx(np.array(STROKES[kind]) * 2 * np.pi / 10 / 3600, rel=DIGITS)
    assert [use.static_safety for use in uses] == pytest.approx(1e6 / np.array(BY_SCRIPT["largest_force"]), rel=DIGITS)


def test_two_bearings_share_the_force() -> None:
    one, two = (pins(reactions(), {"W": RollingBearing(5e5, "ball", count)})["W"] for count in (1, 2))
    assert two.equivalent_load == pytest.approx(0.5 * one.equivalent_load)
    assert two.strokes == pytest.approx(8 * one.strokes)


def test_a_swing_under_a_constant_load_lives_as_catalogues_print_it() -> None:
    """An arm swings by a sine under a force that turns with it. L10 180/phi oscillations, phi the whole swing (Harmonic Drive: one
    oscillation means 2 phi), for a life of (C/P)^3 million turns."""
    links = {"arm": {"pins": "O T", "mass": 1}}
    press = pp.build(units="mm", frame="O", pins={"O": [0, 0], "T": [0, -500]}, links=links, drive="O")
    time = np.linspace(0.0, 1.0, 201)
    motion = pp.servo_cycle(press, 0.3 * np.sin(2 * np.pi * time), time=time)
    push = pp.loads.PointForce(
        "arm", lambda motion: 1e5 * np.column_stack([np.cos(motion.crank_angle), 0 * time, np.sin(motion.crank_angle)])
    )
    use = pins(pp.inverse_dynamics(press, motion, [push]), {"O": RollingBearing(1e6, "ball")})["O"]
    assert use.swing == pytest.approx(0.6, rel=1e-6)
    assert use.equivalent_load == pytest.approx(1e5, rel=2e-4)  # the arm weighs 10 N
    assert use.strokes == pytest.approx(1e6 * 10**3 * 180 / math.degrees(0.6), rel=6e-4)


LENGTH, WIDTH, MIDDLE = 0.3, 0.1, 0.06


@pytest.mark.parametrize("points", [60, 77])
def test_a_guide_of_a_massless_crank_slide(points: int) -> None:
    """The rod at the slope b pushes the slide sideways by F tan b, at its pin: the gibs 60 mm higher bear F tan b x 60 mm too."""
    table = {"units": "mm", "masses": "none", "frame": "O", "drive": "O"}
    at = {"O": [0, 0], "P": {"from": "O", "length": 100, "angle": -90}, "W": {"P": 400, "x": 0, "side": "down"}}
    links = {"crank": {"pins": "O P"}, "rod": {"pins": "P W"}, "slide": {"pins": "W", "guide": "up"}}
    press, force, speed = pp.build(**table, pins=at, links=links), 1e5, 5.0
    found = pp.inverse_dynamics(press, pp.cycle(press, speed, points=points), [pp.loads.ForceStroke([0.0, 0.03], [force, force])])
    use = pins(found, {"slide_guide": Gibs(LENGTH, WIDTH, middle=MIDDLE, pressure=5e6, wear_rate=1e-15)})["slide_guide"]

    begin = brentq(lambda angle: 0.5 - (0.1 * np.cos(angle) + np.sqrt(0.16 - 0.01 * np.sin(angle) ** 2)) - 0.03, 0.1, 1.5)
    steeper = (1 + 6 * MIDDLE / LENGTH) / (LENGTH * WIDTH)  # pressure by force

    def side(angle: float) -> float:
        return force * 0.25 * np.sin(angle) / np.sqrt(1 - (0.25 * np.sin(angle)) ** 2)

    def travel(angle: float) -> float:  # by the angle from bottom dead centre
        return 0.1 * np.sin(angle) * (1 + 0.25 * np.cos(angle) / np.sqrt(1 - (0.25 * np.sin(angle)) ** 2))

    assert use.largest_force == pytest.approx(side(begin), rel=1e-7)  # the links weigh 1 mg each
    assert use.at == pytest.approx(2 * np.pi - begin, rel=1e-9)  # the table is drawn at bottom dead centre, and the slide goes down
    assert use.largest_tilting == pytest.approx(MIDDLE * side(begin), rel=1e-7)
    assert use.largest_pressure == pytest.approx(steeper * side(begin), rel=1e-7)
    assert use.largest_pv == pytest.approx(steeper * side(begin) * travel(begin) * speed, rel=1e-7)
    assert use.rubbing_way == pytest.approx(0.4, rel=1e-9)
    assert use.pressure == pytest.approx(steeper * quad(side, 0, begin)[0] / (2 * np.pi), rel=1e-6)
    rubbed = steeper * quad(lambda angle: side(angle) * travel(angle), 0, begin)[0]  # Pa m a stroke
    assert use.pv == pytest.approx(rubbed * speed / (2 * np.pi), rel=1e-6)
    assert use.wear == pytest.approx(1e-15 * rubbed, rel=1e-6)
    assert use.swing is None
    assert use.way is None


REFUSED = [
    ({"X": PlainBearing(0.1, 0.1)}, "no bearing 'X'"),
    ({"slide_guide": PlainBearing(0.1, 0.1)}, "slide_guide is a guide: give Gibs(length, width)"),
    ({"W": Gibs(0.1, 0.1)}, "W is a pin, which has no gibs: give PlainBearing(diameter, width)"),
    ({"W": 0.1}, "bearings of 'W' is 0.1: give a PlainBearing or a RollingBearing, of a guide Gibs"),
    ({"slide_guide": Gibs(0.1, 0.1, normal=(0.0, 0.0, 1.0))}, "is not across the axis of slide_guide"),
    ({"slide_guide": Gibs(0.1, 0.1, middle=0.2, one_sided=True)}, "the slide tips at"),
]


@pytest.mark.parametrize(("bearings", "message"), REFUSED)
def test_refused(bearings, message: str) -> None:
    with pytest.raises(pp.PinpressError) as error:
        pins(reactions(12), bearings)
    assert message in str(error.value)


def test_sizes_are_checked() -> None:
    for call, message in (
        (lambda: PlainBearing(0.1, 0.0), "width"),
        (lambda: RollingBearing(1e5, "needle"), "kind is 'needle': give 'ball' or 'roller'"),
        (lambda: RollingBearing(1e5, count=0), "count"),
    ):
        with pytest.raises(pp.PinpressError, match=message):
            call()
    with pytest.warns(pp.PinpressWarning, match=r"W: its load rating C is 800 N, below its largest force of 9.957e\+04 N: check that C"):
        pins(reactions(), {"W": RollingBearing(800.0)})
