"""Least transmission angles of dyads, against closed forms of textbook mechanisms."""

import math

import numpy as np
import pytest
from support import texts
from support.presses.sliding_presses import ARM, BELL, RETRACTED, G

import pinpress as pp

CRANK, COUPLER, ROCKER, FRAME = 0.143, 1.243, 0.375, math.hypot(1.25, 0.2)  # of the six-bar's first loop [m]


def only(**table: object) -> pp.measures.Dyad:
    """The dyad of a press in mm that is driven at A; a four-bar unless its links are given."""
    four_bar = {name: {"pins": two, "mass": 1} for name, two in (("crank", "A B"), ("coupler", "B C"), ("rocker", "C D"))}
    (dyad,) = pp.measures.least_transmission_angles(pp.build(**{"units": "mm", "frame": "A D", "links": four_bar, "drive": "A"} | table))
    return dyad


def test_of_a_six_bar() -> None:
    """Crank-rocker: with the crank in line with the frame, by the law of cosines. Then rod and slide: across the guide."""
    press = texts.shipped("zxn2_3000b")
    first, second = pp.measures.least_transmission_angles(press)
    cosines = [(COUPLER**2 + ROCKER**2 - (FRAME + side * CRANK) ** 2) / (2 * COUPLER * ROCKER) for side in (-1, 1)]
    assert (first.bearing, first.ends) == ("C", ("B", "D"))
    assert first.least_transmission_angle == pytest.approx(math.acos(max(map(abs, cosines))), abs=1e-10)
    motion = pp.cycle(press, speed=1.0, points=720)
    at = pp.measures.bearing_positions(press, motion)
    along = np.abs(at["F"] - at["E"])
    assert (second.bearing, second.ends) == ("F", ("E", "slide_guide"))
    assert second.least_transmission_angle == pytest.approx(np.arctan2(along[:, 2], along[:, 0]).min(), abs=1e-6)


@pytest.mark.parametrize("offset", [0.0, 30.0, -45.0])
def test_of_a_crank_slide(offset: float) -> None:
    """cos = (r + |e|) / l where the pin is furthest from the path of the slide's pin."""
    pins = {"A": [0, 0], "B": {"from": "A", "length": 100, "angle": 10}, "C": {"x": offset, "B": 400, "side": "down"}}
    links = {"crank": {"pins": "A B", "mass": 1}, "rod": {"pins": "B C", "mass": 1}, "slide": {"pins": "C", "guide": "up", "mass": 1}}
    dyad = only(frame="A", pins=pins, links=links)
    assert dyad.least_transmission_angle == pytest.approx(math.acos((100 + abs(offset)) / 400), abs=1e-11)
    assert abs(math.cos(dyad.crank_angle + math.radians(10)) * -math.copysign(1.0, offset or -1.0) - 1) < 1e-9 or not offset


def test_of_a_guide_bar() -> None:
    """The block pushes the bar square to it all round; the first of equal angles is given."""
    slot, _ = pp.measures.least_transmission_angles(texts.shipped("thin_wall"))
    assert (slot.bearing, slot.ends) == ("slot", ("C", "B"))
    assert slot.least_transmission_angle == pytest.approx(math.pi / 2, abs=1e-9)
    assert slot.crank_angle == pytest.approx(0.0, abs=2e-2)


def test_links_that_come_into_line_have_none() -> None:
    """A parallelogram: coupler and rocker are in line where all its pins are."""
    pins = {"A": [0, 0], "D": [300, 0], "B": {"from": "A", "length": 100, "angle": 50}, "C": {"from": "D", "length": 100, "angle": 50}}
    dyad = only(pins=pins)
    assert dyad.least_transmission_angle == 0.0
    assert math.sin(dyad.crank_angle + math.radians(50)) == pytest.approx(0.0, abs=1e-6)


def test_as_far_as_the_crank_turns() -> None:
    """A double rocker locks where coupler and rocker are in line."""
    pins = {"A": [0, 0], "D": [200, 0], "B": {"from": "A", "length": 250, "angle": 60}, "C": {"B": 150, "D": 200, "side": "right"}}
    dyad = only(pins=pins)
    assert dyad.least_transmission_angle < 1e-3


def test_of_a_cylinder() -> None:
    """Between cylinder and bell crank, by the law of cosines, where the cylinder is as long as its travel allows."""
    (dyad,) = pp.measures.least_transmission_angles(texts.load(BELL))
    length = np.linspace(RETRACTED - 0.1, RETRACTED + 0.15, 100_001)
    angle = np.arccos(np.abs(length**2 + ARM**2 - G @ G) / (2 * length * ARM))
    assert (dyad.bearing, dyad.ends) == ("K", ("G", "O"))
    assert dyad.least_transmission_angle == pytest.approx(angle.min(), abs=1e-9)
    assert dyad.crank_angle == pytest.approx(length[angle.argmin()] - RETRACTED, abs=1e-5)


def test_a_loop_that_only_adds_constraint_is_no_dyad() -> None:
    two_point = pp.measures.least_transmission_angles(texts.shipped("jf75g_125_two_point"))
    assert [dyad.bearing for dyad in two_point] == ["P4_front", "P5"]
