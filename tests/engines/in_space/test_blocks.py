"""Equations in space that are solved block by block: the same as all at once, and linkages of any size."""

import numpy as np
import pytest
from support import texts
from support.generators import large_linkages
from support.oracles import cassie, n_four_bar

import pinpress as pp
from pinpress.engines.engine import ClosedStates
from pinpress.engines.spatial.closing import PassiveColumns
from pinpress.engines.spatial.engine import SpatialEngine
from pinpress.engines.spatial.equations import Equations, equations
from pinpress.engines.wrenches import AppliedConditions, AppliedForce


def in_space(press: pp.Linkage) -> SpatialEngine:
    engine = press.engine("space")
    assert isinstance(engine, SpatialEngine)
    return engine


def passive_columns(found: Equations):
    """Columns (n, rows, k) of the passive joints, not scaled."""
    return found.entries[found.loops.passive_places].transpose(2, 0, 1)


def redundant():
    """Three four-bars in a plane, with ball joints: each has one equation too many."""
    return large_linkages.load(n_four_bar.urdf(3))


CASES = {
    "redundant": redundant,
    "cassie": lambda: texts.load(cassie.urdf()),
    "chain": lambda: large_linkages.load(large_linkages.spatial_chain(4)),
}


@pytest.fixture(scope="module", params=CASES)
def factorised(request):
    """The equations of a linkage near its drawn pose, their factors, and the columns that these are of."""
    press = CASES[request.param]()
    loops = in_space(press).loops
    found = equations(loops, press.closed[:, None] + 1e-3 * np.arange(5.0))
    assert len(loops.blocks.blocks) > 1
    return press, found, PassiveColumns(loops, found.entries), passive_columns(found)


def test_solutions_are_those_of_all_equations_at_once(factorised):
    """Rates of gaps that the joints can make, to 1e-12; multipliers of least norm, and a basis of the idle ones, to 1e-11."""
    press, found, solved, columns = factorised
    passive = found.loops.passive
    wanted = np.sin(1.0 + np.arange(len(passive) * 5.0)).reshape(len(passive), 5)
    rates = solved.rates(np.einsum("nrk,kn->rn", columns, wanted))
    np.testing.assert_allclose(rates[passive], wanted, rtol=0, atol=1e-12)
    assert not rates[list(in_space(press).structure.drivers)].any()

    effort = np.zeros((press.model.nv, 5))
    effort[passive] = wanted
    expected = np.linalg.pinv(columns.swapaxes(1, 2)) @ wanted.T[:, :, None]
    np.testing.assert_allclose(solved.multipliers(effort).T, expected[:, :, 0], rtol=0, atol=1e-11 * np.abs(expected).max())

    idle = [part.idle for part in solved.parts]
    redundant_rows = found.loops.rows - len(passive)
    assert sum(each.shape[2] for each in idle) == redundant_rows
    for each in idle:
        np.testing.assert_allclose(
            each.swapaxes(1, 2) @ each, np.broadcast_to(np.eye(redundant_rows), (5, *2 * [redundant_rows])), atol=1e-13
        )
        assert np.abs(columns.swapaxes(1, 2) @ each).max() < 1e-13 * np.abs(columns).max()


def test_where_a_block_is_singular_the_whole_is_decomposed():
    """Two of its columns are equal at the second of three configurations, one is rounding at the last."""
    loops = in_space(large_linkages.load(large_linkages.spatial_chain(4))).loops
    entries = equations(loops, np.zeros((len(loops.bodies.parents), 3))).entries
    block = loops.blocks.blocks[1]
    own = loops.places_in(block.joints)[block.rows]
    entries[own[:, 1], 1] = entries[own[:, 0], 1]
    entries[own[:, 0], 2] *= 1e-13
    solved = PassiveColumns(loops, entries)
    assert not solved.regular
    columns = entries[loops.passive_places].transpose(2, 0, 1)
    target = np.cos(np.arange(3.0 * loops.rows)).reshape(loops.rows, 3)
    missed = [c @ x - t for c, x, t in zip(columns, solved.rates(target)[loops.passive].T, target.T, strict=True)]
    assert np.abs(missed[0]).max() < 1e-12
    for k in (1, 2):  # the best that the independent columns can do
        assert np.abs(missed[k]).max() > 1e-2
        np.testing.assert_allclose(columns[k].T @ missed[k], 0, atol=1e-12)
    (part,) = solved.parts
    assert part.states.tolist() == [1, 2]
    assert np.abs(columns[1:].swapaxes(1, 2) @ part.idle).max() < 1e-12


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


@pytest.mark.one_in(5)
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
