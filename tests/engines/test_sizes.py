"""Linkages larger than a press: what is computed stays right. Times are printed by `tests/benchmarks/run.py sizes`."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import texts
from support.exploring import examples
from support.generators import large_linkages
from support.oracles import n_four_bar

import pinpress as pp
from pinpress.engines.constraints import gear
from pinpress.engines.planar.model import ordered_blocks

MOVED = np.array([1e-3, 0.0, 2e-3])
ANGLES = np.linspace(0.05, 1.2, 7)
KINDS = {"dyads": n_four_bar.urdf, "gears": large_linkages.gear_train}


@pytest.mark.exhaustive
@pytest.mark.parametrize("kind", KINDS)
def test_power_and_idle_forces_of_a_linkage_of_many_joints(kind):
    press = large_linkages.load(KINDS[kind](20))
    motion = pp.servo_cycle(press, angle=ANGLES, speed=3.0)
    result = pp.inverse_dynamics(press, motion)
    assert np.abs(result.power_residual).max() < 1e-13
    assert np.isfinite(result.shaking_moment).all()
    loop_forces = [flags[:3].tolist() for name, flags in result.indeterminate.items() if name not in press.joints]
    assert loop_forces == [[False, True, False]] * len(press.loops)
    assert pp.visual_model(press, motion).ngeoms > len(press.joints)


@pytest.mark.exhaustive
def test_a_row_of_links_with_ties_is_one_linkage_however_its_tree_is_written():
    """Loops between neighbours, or each round all links before it: the same torque."""
    presses = [large_linkages.load(large_linkages.tied_row(3, short)) for short in (True, False)]
    short, long = (pp.inverse_dynamics(press, pp.servo_cycle(press, angle=ANGLES, speed=3.0)) for press in presses)
    np.testing.assert_allclose(short.driving_torque, long.driving_torque, rtol=0, atol=1e-12 * np.abs(long.driving_torque).max())


@pytest.mark.parametrize("name", [*pp.presses(), "geared"])
def test_gaps_as_drawn_are_those_of_the_pinocchio_engine(name):
    press = large_linkages.load(large_linkages.gear_train(3)) if name == "geared" else texts.shipped(name)
    size = press.size
    np.testing.assert_allclose(press.assembly.gaps, press.equations(press.assembly.start).gaps, rtol=0, atol=1e-15 * size)
    beside = dataclasses.replace(press, loops=tuple(dataclasses.replace(loop, point1=loop.point1 + MOVED) for loop in press.loops))
    np.testing.assert_allclose(beside.assembly.gaps, beside.equations(beside.assembly.start).gaps, rtol=0, atol=1e-15 * size)


def test_chain_of_dyads_in_closed_form():
    """I phi'' = V g sin(phi) + torque (see `n_four_bar`), and the bearing forces carry weight and inertia of all rods."""
    count = 60
    press = large_linkages.load(n_four_bar.urdf(count))
    w, alpha = 3.0, -2.0
    result = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=ANGLES, speed=w, acceleration=alpha))
    expected = n_four_bar.inertia(count) * alpha - n_four_bar.moment(count) * n_four_bar.GRAVITY * np.sin(ANGLES)
    np.testing.assert_allclose(result.driving_torque, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    # all rods turn by phi; the tops move as the tips do: mass times acceleration of the centres, less the weight
    along, across = np.stack([np.sin(ANGLES), np.cos(ANGLES)]), np.stack([np.cos(ANGLES), -np.sin(ANGLES)])
    force = n_four_bar.moment(count) * (alpha * across - w**2 * along)
    force[1] += (2 * count + 1) * n_four_bar.GRAVITY
    np.testing.assert_allclose(-result.shaking_force[:, [0, 2]].T, force, rtol=0, atol=1e-11 * np.abs(force).max())


@pytest.mark.exhaustive
def test_gear_train_in_closed_form():
    """Every pair turns the shaft behind it and all that this one drives."""
    count = 61
    press = large_linkages.load(large_linkages.gear_train(count))
    result = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=ANGLES, speed=3.0, acceleration=-2.0))
    inertia, weight = 0.1 + 0.1**2, 9.81 * 0.1
    needed = inertia * -2.0 * (-1.0) ** np.arange(count + 1)[:, None] + weight * np.cos(ANGLES)
    torques = np.zeros_like(ANGLES)
    for shaft in range(count, 0, -1):
        torques = needed[shaft] - torques
        pair = result.coupling_torque[f"shaft_{shaft}"]
        np.testing.assert_allclose(pair, np.stack([torques, torques], axis=1), rtol=0, atol=1e-12 * count)
    np.testing.assert_allclose(result.driving_torque, needed[0] - torques, rtol=0, atol=1e-12 * count)


@pytest.mark.parametrize("count", [20, 40, pytest.param(180, marks=pytest.mark.exhaustive)])
def test_row_of_open_links_in_closed_form(count):
    """Links that hang on each other, each geared to the one before: torque and bearing forces by Newton and Euler."""
    w, alpha, ratio = 3.0, -2.0, -0.9
    press = large_linkages.load(large_linkages.open_row(count, ratio))
    result = pp.inverse_dynamics(press, pp.servo_cycle(press, angle=ANGLES, speed=w, acceleration=alpha))
    shares = np.cumsum(ratio ** np.arange(count))[:, None]  # of the crank angle in every link's
    rotor = np.exp(1j * shares * ANGLES)
    second = (1j * shares * alpha - (shares * w) ** 2) * rotor
    tips = np.cumsum(large_linkages.ROW_STEP * second, axis=0)
    pivots = np.concatenate([np.zeros_like(tips[:1]), tips[:-1]])
    force = np.cumsum((pivots + 0.1 * second + 9.81j)[::-1], axis=0)[::-1]  # of 1 kg each, that every joint carries
    own = (rotor * 0.1).conj() * (pivots + 0.1 * second + 9.81j)
    hanging = np.concatenate([(large_linkages.ROW_STEP * rotor[:-1]).conj() * force[1:], np.zeros_like(force[:1])])
    moment = np.cumsum((own.imag + hanging.imag + 0.1 * shares * alpha)[::-1], axis=0)[::-1]
    torque = (ratio ** np.arange(count)[:, None] * moment).sum(axis=0)
    np.testing.assert_allclose(result.driving_torque, torque, rtol=0, atol=1e-13 * np.abs(torque).max())
    scale = np.abs(force).max()
    for k in (0, 1, count // 2, count - 1):
        found = result.bearing_force[f"joint_{k}"]
        np.testing.assert_allclose(found[:, 0] + 1j * found[:, 2], force[k], rtol=0, atol=1e-13 * scale)
    some = pp.inverse_dynamics(press, result.motion, bearings=[f"joint_{count // 2}"])
    np.testing.assert_allclose(
        some.bearing_force[f"joint_{count // 2}"], result.bearing_force[f"joint_{count // 2}"], rtol=0, atol=1e-13 * scale
    )


# ------------------------------------------------------------------------------------------------------------------- order of solution


@st.composite
def systems(draw):
    """Joints 0 (the driver) to n, and which of them take part in loops and gear pairs."""
    joints = draw(st.integers(2, 9))
    loops = draw(st.lists(st.sets(st.integers(0, joints - 1), min_size=1, max_size=4), max_size=5))
    pairs = st.tuples(st.integers(0, joints - 1), st.integers(0, joints - 1)).filter(lambda pair: pair[0] != pair[1])
    return joints, loops, draw(st.lists(pairs, max_size=3))


@examples(60)
@given(systems())
def test_order_of_blocks(system):
    """Each gives its joints from those before, also where there are too many loops and pairs for all groups to be tried; then there is an
    order exactly where trying all groups finds one."""
    joints, loops, pairs = system
    couplings = [gear(str(one), one, other, 1.0) for one, other in pairs]
    tried = ordered_blocks(loops, couplings, 0, joints, one_block=False)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pinpress.engines.blocks.FEW", 0)
        found = ordered_blocks(loops, couplings, 0, joints, one_block=False)
    if 2 * len(loops) + len(couplings) == joints - 1:
        assert (found is None) == (tried is None)
    if found is None:
        return
    known = {0}
    for block in found:
        involved = set().union(*(loops[k] for k in block.loops), *(pairs[k] for k in block.relations))
        assert involved - known == set(block.joints)
        assert len(block.joints) <= 2 * len(block.loops) + len(block.relations)
        known |= set(block.joints)
    assert known == set(range(joints))
    assert sorted(k for block in found for k in block.loops) == list(range(len(loops)))
    assert sorted(k for block in found for k in block.relations) == list(range(len(couplings)))
