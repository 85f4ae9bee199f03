"""A branch that is found from that of a linkage with nearly the same lengths is the one that a walk finds."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support import texts
from support.generators.pin_tables import crank_slide

import pinpress as pp

LONGER = {
    "zxn2_3000b": {("B", "crank"): (0.150, 0.0, 0.0)},
    "thin_wall": {("A", "frame"): (0.002, 0.0, 0.001)},
    "jf75g_125": {("P2", "crank"): (0.0, 0.0, -0.017)},
}


def branch_of(press: Any, other: Any) -> Any:
    """The branch that is kept without a walk; None where none was found."""
    press.follow_beside(other)
    kept = vars(press)["_kept"].of_geometry
    return next((value for name, value in kept.items() if name.endswith("Linkage.branch")), None)


def moved(press: Any, pivots: Any) -> Any:
    """The press with pivots moved by displacements, or to places where it says so."""
    places = pp.derivatives.pivot_positions(press)
    return pp.derivatives.reshaped(press, {key: 0.2 * np.array(at) + 0.8 * places[key] for key, at in pivots.items()})


@pytest.mark.parametrize("name", LONGER)
def test_it_is_the_walked_one(name: str) -> None:
    press = texts.shipped(name)
    quick, walked = (moved(press, LONGER[name]) for _ in range(2))
    found = branch_of(quick, press)
    assert found is not None
    assert found.period == walked.branch.period
    fast, slow = (pp.cycle(each, 5.0, points=90) for each in (quick, walked))
    assert_allclose(fast.joint_position, slow.joint_position, rtol=0, atol=1e-12)
    assert_allclose(fast.a, slow.a, rtol=0, atol=1e-9 * np.abs(slow.a).max())


def test_it_is_walked_where_the_lengths_are_too_different() -> None:
    """With a crank half as long again this four-bar's rocker goes through its dead centre, where two assemblies meet: the walk ends."""
    press = texts.shipped("zxn2_3000b")
    far = pp.derivatives.reshaped(press, {("B", "crank"): (0.35, 0.0, 0.0)})
    assert branch_of(far, press) is None
    with pytest.raises(pp.SingularityError, match="two assemblies meet at crank angles of"):
        pp.cycle(far, 5.0)


def test_another_assembly_is_not_taken_for_it() -> None:
    """The mirror image of a crank slide has the same lengths, and its slide is above the crank: it stays there."""
    above, again, below = (pp.build(**crank_slide(side=side)) for side in ("up", "up", "down"))
    above.follow_beside(below)
    assert_allclose(pp.cycle(above, 5.0).slide_position, pp.cycle(again, 5.0).slide_position, rtol=0, atol=1e-12)


def test_a_driver_that_slides_keeps_its_travel() -> None:
    press = pp.build("pinpress/pin_table/templates/toggle.yaml")
    assert branch_of(pp.build("pinpress/pin_table/templates/toggle.yaml"), press) is not None
