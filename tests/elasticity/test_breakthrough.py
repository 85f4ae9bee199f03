"""Snap-through against closed forms, energy, and a solver of differential equations that knows nothing of segments."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from support.exploring import examples

import pinpress as pp
from pinpress.elasticity.breakthrough import Release, permissible_breakthrough, segments, snap_through

F, K, M = 1.25e6, 6e8, 2600.0
W = np.sqrt(K / M)
PERIOD = 2 * np.pi / W
FEW = examples(8)


def test_at_once_and_without_damping():
    found = snap_through(F, K, mass=M)
    assert found.reverse_force == pytest.approx(F, rel=1e-13)
    assert found.overshoot == pytest.approx(F / K, rel=1e-13)
    assert found.peak_acceleration == pytest.approx(F / M, rel=1e-13)
    assert found.frequency == pytest.approx(W, rel=1e-15)
    assert found.energy == pytest.approx(0.5 * F**2 / K, rel=1e-15)
    np.testing.assert_allclose(found.displacement, F / K * np.cos(W * found.time), atol=1e-12 * F / K)
    assert found.time[-1] == pytest.approx(6 * PERIOD, rel=1e-2)


@pytest.mark.parametrize("zeta", [0.01, 0.05, 0.3, 0.9])
def test_at_once_with_damping(zeta):
    found = snap_through(F, K, mass=M, damping_ratio=zeta)
    assert found.reverse_ratio == pytest.approx(np.exp(-zeta * np.pi / np.sqrt(1 - zeta**2)), rel=1e-12)
    assert found.frequency == pytest.approx(W * np.sqrt(1 - zeta**2), rel=1e-15)


@pytest.mark.parametrize("turns", [0.01, 0.3, 0.5, 0.77, 1.4, 2.5, 12.3])
def test_linear_drop_without_damping(turns):
    half = np.pi * turns
    found = snap_through(F, K, mass=M, damping_ratio=0.0, break_time=turns * PERIOD)
    assert found.reverse_ratio == pytest.approx(abs(np.sin(half) / half), rel=1e-10)


@pytest.mark.parametrize("gap", [0.0, 1e-12, 1e-5])
def test_drop_over_a_whole_period_leaves_nothing(gap):
    """The slide comes to rest just as the force is gone, on the edge of the clearance."""
    found = snap_through(F, K, mass=M, damping_ratio=0.0, break_time=PERIOD, clearance=gap)
    assert found.reverse_ratio == pytest.approx(0.0, abs=1e-13)
    with pytest.raises(pp.PinpressError, match="any force is permitted"):
        permissible_breakthrough(1e5, K, mass=M, damping_ratio=0.0, break_time=PERIOD)


def solved(zeta, tau, gap, end):
    """The equation as it stands, from edge to edge of the clearance: the turning points below, where x' = 0, and the last state."""
    c, lowest, peak = 2 * zeta * np.sqrt(K * M), 0.0, 0.0
    state, t, side = [F / K, 0.0], 0.0, 1

    def rate(t, y, side):
        pull = 0.0 if side == 0 else K * (y[0] + (gap if side < 0 else 0.0)) + c * y[1]
        return [y[1], (max(0.0, 1 - t / tau) * F - pull if tau and t < tau else -pull) / M]

    def upper(t, y, side):
        return y[0] if side >= 0 else y[0] + gap

    def lower(t, y, side):
        return y[0] + gap if side == 0 else 1.0

    def turning(t, y, side):
        return y[1]

    upper.terminal = lower.terminal = True  # type: ignore[attr-defined]
    lower.direction = -1  # type: ignore[attr-defined]
    turning.direction = 1  # type: ignore[attr-defined]
    while t < end:
        upper.direction = -1 if side == 1 else 1  # type: ignore[attr-defined]
        until = tau if t < tau < end else end
        found = solve_ivp(
            rate, (t, until), state, "DOP853", rtol=1e-12, atol=1e-15, events=(upper, lower, turning), args=(side,), dense_output=True
        )
        lowest = min([lowest, *(y[0] for y in found.y_events[2])])
        times = np.linspace(t, found.t[-1], 4001)
        peak = max([peak, *(abs(rate(t, y, side)[1]) for t, y in zip(times[1:-1], found.sol(times[1:-1]).T, strict=True))])
        t, state = found.t[-1], list(found.y[:, -1])
        if found.t_events[0].size:
            side, state[0] = {1: 0, 0: 1, -1: 0}[side], (-gap if side < 0 else 0.0)
        elif found.t_events[1].size:
            side, state[0] = -1, -gap
    return lowest, peak, state


@pytest.mark.parametrize(
    ("zeta", "tau", "gap"), [(0.0, 0.0, 3e-4), (0.05, 0.0, 1e-3), (0.03, 0.4, 2e-4), (0.0, 0.8, 1e-3), (0.1, 1.7, 1e-4), (0.02, 2.6, 5e-5)]
)
def test_clearance_against_a_solver(zeta, tau, gap):
    found = snap_through(F, K, mass=M, damping_ratio=zeta, break_time=tau * PERIOD, clearance=gap)
    lowest, peak, state = solved(zeta, tau * PERIOD, gap, found.time[-1])
    assert found.overshoot == pytest.approx(-lowest, rel=1e-9)
    assert found.reverse_force == pytest.approx(max(0.0, K * (-lowest - gap)), rel=1e-8)
    assert found.peak_acceleration == pytest.approx(peak, rel=2e-4)  # the solver knows it between edges alone, at a grid of times
    assert found.peak_acceleration >= peak * (1 - 1e-9)
    np.testing.assert_allclose([found.displacement[-1] * W, found.velocity[-1]], [state[0] * W, state[1]], atol=1e-8 * F / K * W)


@FEW
@given(tau=st.floats(0.0, 3.0), gap=st.floats(0.0, 2e-3))
def test_energy_is_kept_once_the_force_is_gone(tau, gap):
    found = snap_through(F, K, mass=M, damping_ratio=0.0, break_time=tau * PERIOD, clearance=gap)
    after = found.time >= tau * PERIOD
    energy = 0.5 * M * found.velocity**2 + 0.5 * found.spring_force**2 / K
    np.testing.assert_allclose(energy[after], energy[-1], atol=1e-12 * found.energy)
    assert found.reverse_force == pytest.approx(np.sqrt(2 * K * energy[-1]), rel=1e-6, abs=1e-5 * F)
    if not tau:
        assert energy[-1] == pytest.approx(found.energy, rel=1e-12)


@FEW
@given(zeta=st.floats(0.0, 0.5), tau=st.floats(1e-3, 3.0), gap=st.floats(0.0, 2e-3), size=st.floats(0.1, 10.0))
def test_balance_of_energy_and_scaling(zeta, tau, gap, size):
    """Stored energy and work of the force are not less than what is left; and forces with clearances to scale give the same ratio."""
    found = snap_through(F, K, mass=M, damping_ratio=zeta, break_time=tau * PERIOD, clearance=gap)
    t, x, v = found.time, found.displacement, found.velocity
    push = F * np.maximum(0.0, 1 - t / (tau * PERIOD))
    work = np.concatenate([[0.0], np.cumsum(0.5 * (push[1:] + push[:-1]) * np.diff(x))])
    left = 0.5 * M * v**2 + 0.5 * found.spring_force**2 / K
    assert np.all(left <= found.energy + work + 2e-3 * found.energy)
    scaled = snap_through(size * F, K, mass=M, damping_ratio=zeta, break_time=tau * PERIOD, clearance=size * gap)
    assert scaled.reverse_ratio == pytest.approx(found.reverse_ratio, rel=1e-9, abs=1e-9)


def test_permissible_force():
    """Without clearance reverse load is in proportion to force; with it the force found brings about just what is permitted."""
    stiffness, mass = np.linspace(4e8, 7e8, 5), np.linspace(2500.0, 2600.0, 5)
    permitted = permissible_breakthrough(1.5e5, stiffness, mass=mass, damping_ratio=0.04, break_time=2e-3)
    for force, k, m in zip(permitted, stiffness, mass, strict=True):
        assert snap_through(force, k, mass=m, damping_ratio=0.04, break_time=2e-3).reverse_force == pytest.approx(1.5e5, rel=1e-12)
    assert permissible_breakthrough(1.5e5, K, mass=M)[0] == pytest.approx(1.5e5, rel=1e-12)
    force = permissible_breakthrough(1.5e5, K, mass=M, damping_ratio=0.04, break_time=2e-3, clearance=3e-4)[0]
    assert snap_through(force, K, mass=M, damping_ratio=0.04, break_time=2e-3, clearance=3e-4).reverse_force == pytest.approx(
        1.5e5, rel=1e-9
    )
    assert snap_through(0.9 * force, K, mass=M, damping_ratio=0.04, break_time=2e-3, clearance=3e-4).reverse_force < 1.5e5


@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.9])
@pytest.mark.parametrize("turns", [0.3, 2.3, 30.7])
def test_what_is_passed_over_of_a_slow_drop_is_above_rest(zeta, turns):
    """The slide stays pressed there, and what follows is the same."""
    case = Release(F, K, M, zeta, turns * PERIOD, 1e-4)
    every, some = (list(segments(case, pressed=pressed)) for pressed in (True, False))
    passed = len(every) - len(some)
    assert passed >= 2 * turns - 3
    for stretch, span in every[:passed]:
        assert stretch.slack == 0.0
        assert stretch.at(np.linspace(0.0, span, 50))[0].min() > 0.0
    for (one, span), (other, same) in zip(every[passed:], some, strict=True):
        # counts of roundings: of a phase of 30 turns, through edges that are met at a shallow angle
        np.testing.assert_allclose(
            (one.start + span, one.x, one.v / W), (other.start + same, other.x, other.v / W), rtol=1e-8, atol=1e-11 * F / K
        )


def test_what_only_rounding_could_tell():
    """The smallest numbers there are give what zero gives."""
    plain, tiny = snap_through(F, K, mass=M), snap_through(F, K, mass=M, damping_ratio=0.0, break_time=5e-324, clearance=5e-324)
    assert (tiny.reverse_force, tiny.peak_acceleration) == (plain.reverse_force, plain.peak_acceleration)
