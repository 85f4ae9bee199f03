"""Equations in space that are solved block by block: the same as all at once, and linkages of any size."""

import numpy as np
import pytest
from support.generators import large_linkages
from support.oracles import n_four_bar

import pinpress as pp
from pinpress.engines.engine import ClosedStates
from pinpress.engines.spatial.engine import SpatialEngine
from pinpress.engines.wrenches import AppliedConditions, AppliedForce


def in_space(press: pp.Linkage) -> SpatialEngine:
    engine = press.engine("space")
    assert isinstance(engine, SpatialEngine)
    return engine


def test_a_long_chain():
    """Closed near its drawn pose, and its forces, as by Pinocchio's engine."""
    press = large_linkages.load(large_linkages.spatial_chain(22))
    angles, guess = np.linspace(-0.02, 0.01, 4), np.repeat(press.closed[:, None], 4, axis=1)

    def moved(engine):
        closed = engine.close(angles, guess, with_margins=True)
        states = ClosedStates(closed.position, 3.0 * closed.first, 9.0 * closed.second - 2.0 * closed.first, solved=closed.solved)
        forces = engine.inverse_dynamics(states, AppliedConditions([], None, None))
        return closed, states, forces

    engine, judge = in_space(press), press.engine("pinocchio")
    (closed, *ours), (other, *theirs) = moved(engine), moved(judge)
    assert other.margins.min() > 1e-3
    np.testing.assert_allclose(closed.margins, other.margins, rtol=1e-9)
    for mine, judged, names in zip(ours, theirs, (("position", "v", "a"), ("torque", "force", "moment")), strict=True):
        for name in names:
            expected = getattr(judged, name)
            assert np.abs(getattr(mine, name) - expected).max() <= 1e-12 * (1 + np.abs(expected).max()), name


@pytest.mark.one_in(12)
@pytest.mark.parametrize("every", [None, 1, 2, "gears"], ids=["balls", "hinges", "both", "gears"])
@pytest.mark.parametrize("stiff", ["none", "all", "some"])
def test_idle_forces_of_a_chain(stiff, every):
    """Under forces across the plane, as by Pinocchio's engine."""
    text, rng, gears = n_four_bar.urdf(18), np.random.default_rng(3), every == "gears"
    every = None if gears else every
    press = large_linkages.load(large_linkages.geared_chain(18) if gears else large_linkages.hinged(text, every) if every else text)
    engine, count = in_space(press), len(press.bearings)
    compliance = None if stiff == "none" else 1e-9 * 10.0 ** rng.uniform(-2.0, 2.0, size=count)
    if stiff == "some":
        compliance[-4:] = 0.0
    closed = engine.close(np.array([0.01, 0.02]), np.repeat(press.closed[:, None], 2, axis=1))
    states = ClosedStates(closed.position, 3.0 * closed.first, 9.0 * closed.second)
    loads = [AppliedForce(joint, rng.normal(size=3), 10.0 * rng.normal(size=(2, 3))) for joint in (1, 9, 20, 33)]
    ours, theirs = (
        each.inverse_dynamics(states, AppliedConditions(loads, None, compliance)) for each in (engine, press.engine("pinocchio"))
    )
    across = np.abs(theirs.force[:, :, 1]).max()  # the plane
    assert across > 1.0
    np.testing.assert_allclose(ours.force[:, :, 1], theirs.force[:, :, 1], rtol=0, atol=2e-13 * across)
    peak = max(np.abs(theirs.force).max(), np.abs(theirs.moment).max())
    for mine, other in ((ours.force, theirs.force), (ours.moment, theirs.moment)):
        np.testing.assert_allclose(mine, other, rtol=0, atol=2e-13 * peak)
    for open_here, open_there in zip(
        engine.indeterminate(closed.position, np.eye(3)), press.engine("pinocchio").indeterminate(closed.position, np.eye(3)), strict=True
    ):
        np.testing.assert_array_equal(open_here, open_there)
