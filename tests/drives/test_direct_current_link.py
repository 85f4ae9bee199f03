"""The energy of a direct-current link: closed forms, small steps of time, laws that hold for any power."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pinpress as pp
from pinpress.common.numerics import gauss_rule
from pinpress.drives import DirectCurrentLink
from pinpress.drives.direct_current_link import LinkedPower

LINK = DirectCurrentLink(capacitance=0.05, lower_voltage=450.0, charged_voltage=560.0, upper_voltage=750.0)
LIMITED = dataclasses.replace(LINK, mains_power=20e3)
FULL, EMPTY = LINK.energy_at(750.0), LINK.energy_at(450.0)


def linked(link, power, end=1.0, count=16):
    """A power, a function of time, from 0 to ``end``."""
    edges = np.linspace(0.0, end, count + 1)
    half = 0.5 * np.diff(edges)[:, None]
    return LinkedPower(link, edges, power(edges[:-1, None] + half + half * gauss_rule().nodes))


def swing(time):
    return 8e3 + 40e3 * np.sin(2 * np.pi * time) - 15e3 * np.cos(6 * np.pi * time)


def in_small_steps(link, energy, steps):
    """Energy, work from the mains and work burnt after `swing`, by steps of equal time: drawn, then charged, then burnt."""
    times = np.linspace(0.0, 1.0, steps + 1)
    work = 8e3 * times - 40e3 / (2 * np.pi) * np.cos(2 * np.pi * times) - 15e3 / (6 * np.pi) * np.sin(6 * np.pi * times)
    full, mains, burnt = link.energy_at(link.upper_voltage), 0.0, 0.0
    most = np.inf if link.mains_power is None else link.mains_power / steps
    for drawn in np.diff(work).tolist():
        energy -= drawn
        given, over = min(max(-energy, 0.0), most), max(energy - full, 0.0)
        energy, mains, burnt = energy + given - over, mains + given, burnt + over
    return energy, mains, burnt


@pytest.mark.parametrize("link", [LINK, LIMITED], ids=["without a limit", "limited mains"])
@pytest.mark.parametrize("begin", [0.0, 0.7 * FULL, FULL])
def test_small_steps_come_to_it_in_first_order(link, begin):
    course = linked(link, swing).course(begin)
    found = course.energy[-1], course.mains[-1], course.burnt[-1]
    coarse, fine = (np.abs(np.subtract(in_small_steps(link, begin, steps), found)).max() for steps in (2_000, 16_000))
    assert fine < 5e-5 * course.mains[-1]
    assert fine < 0.3 * coarse or coarse < 1e-6 * course.mains[-1]
    assert len(set(course.feeding.tolist())) >= 3


def test_a_sine_in_closed_form():
    """A sin from rest at the charged voltage: the half wave of braking gives A T / pi; what goes beyond the capacitor is burnt."""
    size = 60e3
    course = linked(LINK, lambda t: -size * np.sin(2 * np.pi * t)).course(0.0)
    half_wave = size / np.pi
    filled = np.arccos(1 - 2 * np.pi * FULL / size) / (2 * np.pi)  # when the capacitor is full
    emptied = 0.5 + filled  # when what it took is used up
    lasting = np.diff(course.times) > 1e-12
    starts, feeding = course.times[:-1][lasting], course.feeding[lasting]
    changes = starts[1:][np.diff(feeding) != 0]
    assert changes == pytest.approx([filled, 0.5, emptied], rel=1e-10)
    assert course.burnt[-1] == pytest.approx(half_wave - FULL, rel=1e-12)
    assert course.mains[-1] == pytest.approx(half_wave - FULL, rel=1e-12)
    assert course.energy.max() == FULL
    assert course.energy[-1] == 0
    times = np.array([0.5 * filled, 0.5 * (filled + 0.5), 0.5 * (0.5 + emptied), 0.5 * (emptied + 1.0)])
    taken = -size * np.sin(2 * np.pi * times)
    mains, burnt = course.powers(LINK, times, taken)
    assert mains.tolist() == [0.0, 0.0, 0.0, taken[3]]
    assert burnt.tolist() == [0.0, -taken[1], 0.0, 0.0]


def test_limited_mains_charge_in_the_pause():
    """A pulse of 50 kW for 0.1 s on 20 kW: 3 kJ come out of the capacitor, and are back 0.15 s later."""
    edges = np.array([0.0, 0.1, 1.0])
    power = np.repeat([[50e3], [0.0]], len(gauss_rule().nodes), axis=1)
    course = LinkedPower(LIMITED, edges, power).course(0.0)
    assert course.energy.min() == pytest.approx(-3e3, rel=1e-12)
    assert course.times[course.energy == 0].tolist() == pytest.approx([0.0, 0.25, 1.0], rel=1e-12)
    assert course.mains[-1] == pytest.approx(5e3, rel=1e-12)


coefficients = st.lists(st.floats(-1e5, 1e5), min_size=2, max_size=6)


@given(coefficients, st.sampled_from([None, 5e3, 30e3]), st.floats(0.0, 1.0))
def test_energy_is_kept_and_its_order_too(series, limit, share):
    """Of any power: nothing is lost, the voltage stays below the upper one, and who starts with more never ends with less."""
    link = dataclasses.replace(LINK, mains_power=limit)
    power = linked(link, lambda t: np.polynomial.chebyshev.chebval(2 * t - 1, series), count=3)
    work = 0.5 * np.diff(power.edges) @ (power.power @ gauss_rule().weights)
    scale = 1.0 + np.abs(series).sum()
    ends = []
    for begin in (share * FULL, FULL):
        course = power.course(begin)
        balance = course.mains[-1] - work - course.burnt[-1] - (course.energy[-1] - begin)
        assert abs(balance) < 1e-11 * (scale + FULL)
        assert course.energy.max() <= FULL
        assert (np.diff(course.mains) >= -1e-11 * scale).all()
        assert (np.diff(course.burnt) >= -1e-11 * scale).all()
        assert limit is not None or course.energy.min() >= 0
        ends.append(float(course.energy[-1]))
    assert ends[0] <= ends[1] + 1e-10 * (scale + FULL)
    assert ends[1] - ends[0] <= (1 - share) * FULL + 1e-10 * (scale + FULL)


@given(coefficients, st.sampled_from([None, 5e3, 30e3]))
def test_a_stroke_that_repeats_ends_as_it_began(series, limit):
    link = dataclasses.replace(LINK, mains_power=limit)
    power = linked(link, lambda t: np.polynomial.chebyshev.chebval(2 * t - 1, series), count=3)
    scale = 1.0 + np.abs(series).sum() + FULL
    begin = power.settled()
    if begin is None:
        assert 0.5 * np.diff(power.edges) @ (power.power @ gauss_rule().weights) > limit
    else:
        assert power.course(begin).energy[-1] == pytest.approx(begin, abs=1e-10 * scale)


def test_voltages_and_energies():
    assert LINK.energy_at(750.0) == pytest.approx(0.025 * (750.0**2 - 560.0**2))
    assert LINK.voltage_at(np.array([EMPTY, 0.0, FULL])) == pytest.approx([450.0, 560.0, 750.0])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"upper_voltage": 500.0}, "upper_voltage 500 V; give them rising"),
        ({"charged_voltage": 400.0}, "lower_voltage is 450, charged_voltage 400"),
        ({"charged_voltage": 450.0, "upper_voltage": 450.0}, "give them rising"),
        ({"capacitance": 0.0}, "capacitance"),
        ({"capacitance": 1e305}, "give that of the link in F"),
        ({"mains_power": -1.0}, "mains_power"),
    ],
)
def test_a_wrong_link_is_refused(change, said):
    with pytest.raises(pp.PinpressError, match=said):
        dataclasses.replace(LINK, **change)
