"""The slide's shift by virtual work against exact derivatives of the closed linkage, and against linkages of other lengths."""

import numpy as np
import pytest
from support import texts
from support.generators.spatial_crank_slide import SPATIAL

import pinpress as pp
from pinpress.derivatives import motion_derivatives, pivot_positions, reshaped
from pinpress.derivatives.motion import directed
from pinpress.tolerances.virtual_work import unit_forces


@pytest.mark.parametrize("name", ["zxn2_3000b", "jf75g_125", "crank_slide"])
def test_shifts_are_the_exact_derivatives_in_every_direction_of_every_pivot(name):
    press = texts.shipped(name)
    motion = pp.servo_cycle(press, [0.3, 1.9, 3.6, 5.2], speed=4.0)  # the speed makes no difference
    unit = unit_forces(press, motion)
    pivots = [key for key in pivot_positions(press) if key != ("slide_guide", "frame")]
    directions = [{key: axis} for key in pivots for axis in np.eye(3)[[0, 2]]]
    exact = motion_derivatives(press, motion, directions)
    shifts = np.array([unit.shift(directed(press, direction)) for direction in directions])
    assert shifts == pytest.approx(np.array([each.slide_position for each in exact]), abs=1e-9)
    assert np.abs(shifts).max() > 0.9


def test_guides_are_lines():
    """Moved along itself a guide moves nothing; moved across it moves the slide as the derivative says."""
    press = texts.shipped("crank_slide")
    motion = pp.servo_cycle(press, [0.7, 2.0], speed=0.0)
    unit = unit_forces(press, motion)
    along, across = ({("slide_guide", "frame"): axis} for axis in ((0, 0, 1), (1, 0, 0)))
    assert unit.shift(directed(press, along)) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert unit.shift(directed(press, across)) == pytest.approx(motion_derivatives(press, motion, [across])[0].slide_position)


@pytest.mark.exhaustive
def test_shifts_in_space_are_those_of_linkages_of_other_lengths():
    press, by = texts.load(SPATIAL), 1e-5
    motion, at = pp.servo_cycle(press, [0.5], speed=0.0), pivot_positions(press)
    unit = unit_forces(press, motion)
    for key in [("W", "rod"), ("W", "slide"), ("P", "crank"), ("O", "frame")]:
        for axis in np.eye(3):
            ends = [
                pp.servo_cycle(reshaped(press, {key: at[key] + sign * by * axis}), [0.5], speed=0.0).slide_position[0] for sign in (1, -1)
            ]
            assert unit.shift(directed(press, {key: axis}))[0] == pytest.approx((ends[0] - ends[1]) / (2 * by), abs=2e-5)
