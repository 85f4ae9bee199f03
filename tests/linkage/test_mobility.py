"""Which equations belong to which loop or gear pair; which of these a diagnosis names is in the corpus of malformed linkages."""

import numpy as np
import pytest
from support import texts
from support.generators import large_linkages
from support.generators.malformed_linkages import PENDULUM, with_element

import pinpress as pp
from pinpress.engines.constraints import Relation
from pinpress.linkage.checks import mobility

THIRD_SHAFT = PENDULUM.replace("</joint>", '<mimic joint="G" multiplier="3"/></joint>')


@pytest.mark.parametrize(
    "text",
    [*(texts.shipped(name).text.decode() for name in pp.presses()), with_element(THIRD_SHAFT)],
    ids=[*pp.presses(), "two gear pairs"],
)
def test_every_equation_belongs_to_one_loop_or_gear_pair(text):
    """In its rows are the joints that it holds together, and no others."""
    press = large_linkages.load(text)
    rows = press.equations(press.closed)
    found = mobility.constraints(press)
    assert sorted(row for each in found for row in each.points + each.turns) == list(range(len(rows.gaps)))
    for each in found:
        if isinstance(each.by, Relation):
            involved = np.flatnonzero(rows.columns[list(each.turns)].any(axis=0))
            assert set(involved) == set(each.by.coefficients)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("turned", ["1.5707963267948966 0 0", "-1.5707963267948966 0 0", "1.5707963267948966 0.3 0"])
def test_axes_across_each_other_are_not_aligned(turned):
    """A pin of the crank-slide whose other end is turned by a quarter about x: its axis is exactly across that of the first."""
    text = texts.shipped("crank_slide").text.decode()
    spherical = (
        '<loop_joint name="W" type="spherical"><link1 link="rod" xyz="0.400 0 0" rpy="0 0 0"/><link2 link="slide" xyz="0 0 0" rpy="0 0 0"/>'
    )
    assert spherical in text
    hinge = spherical.replace("spherical", "revolute").replace('"0 0 0" rpy="0 0 0"', f'"0 0 0" rpy="{turned}"') + '<axis xyz="0 1 0"/>'
    with pytest.raises(pp.PinpressError, match=r'<loop_joint name="W">|loop .W.'):
        texts.load(text.replace(spherical, hinge))
    straight = texts.load(text.replace(spherical, hinge.replace(turned, "3.141592653589793 0 0")))  # against each other
    assert pp.cycle(straight, speed=1.0, points=12).closure_error.max() < 1e-14
