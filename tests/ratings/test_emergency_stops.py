"""Stops and safety distances: closed forms, the closed form of the six-bar press, and printed examples of the standards' formulas."""

import math
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.oracles import balance_by_hand as six_bar
from support.texts import shipped

import pinpress as pp
from pinpress.ratings import emergency_stops
from pinpress.ratings.emergency_stops import FULL, HALF, UNLOADED, BrakedPress
from pinpress.ratings.limits import without_masses
from pinpress.ratings.safety_distance import safety_distance
from pinpress.simulation.reduced_model import INERTIA, reduced_model_of

SPEED = 50 * pp.RPM
STATES = 720
ORDER = np.fft.fftfreq(STATES, 1 / STATES)


@cache
def six_bar_at_its_crank() -> tuple[np.ndarray, np.ndarray]:
    """Fourier series of the inertia at the crank [kg m2] and of the potential energy [J], from the closed form of the six-bar."""
    inertias = {"crank": 31.5, "coupler": 37.4, "rocker": 183.0, "rod": 5.33, "slide": 0.0}  # kg m2, those of the press's URDF
    inertia, energy, frames = np.zeros(STATES), np.zeros(STATES), six_bar.links(STATES)
    for link, mass, place in six_bar.BODIES:
        centre = frames[link][0] + frames[link][1] * place
        velocity, turn = (np.fft.ifft(1j * ORDER * np.fft.fft(curve)) for curve in (centre, frames[link][1]))
        inertia += mass * abs(velocity) ** 2 + inertias[link] * abs(turn) ** 2
        energy += mass * six_bar.GRAVITY * centre.imag
    return np.fft.fft(inertia) / STATES, np.fft.fft(energy) / STATES


def stop_by_hand(signal: float, torque: float) -> float:
    """Time to standstill of the six-bar at 50 r/min, braked 30 ms after a signal [deg] and fully after 80 ms, by its reduced equation."""
    inertia, energy = six_bar_at_its_crank()

    def rates(time: float, state: np.ndarray) -> list[float]:
        wave = np.exp(1j * ORDER * state[0])
        forces = 1j * ORDER * (inertia * state[1] ** 2 / 2 + energy) @ wave
        return [state[1], -(forces.real + torque * np.clip((time - 0.030) / 0.050, 0.0, 1.0)) / (inertia @ wave).real]

    def speed(_: float, state: np.ndarray) -> float:
        return float(state[1])

    speed.terminal = True  # type: ignore[attr-defined]
    start = [np.radians(signal), 50 * np.pi / 30]
    return float(solve_ivp(rates, (0.0, 3.0), start, "DOP853", events=speed, rtol=1e-10, atol=1e-11, max_step=0.02).t[-1])


def six_bar_press(torque: float) -> BrakedPress:
    return BrakedPress(shipped("zxn2_3000b"), SPEED, torque, 0.030, 0.050, 0.0, ())


@pytest.mark.parametrize(
    ("inertia", "torque", "time", "angle"),
    [
        (2000, 25e3, 0.455, 1.27369791667),
        (2000, 12.5e3, 0.855, 2.27434895833),
        (300, 60e3, 0.08, 0.316666666667),  # it stands as the brake reaches its full torque
        (200, 60e3, 0.0708248290464, 0.286082763488),  # and before
    ],
)
def test_a_flywheel_alone_stops_by_the_closed_form(inertia: float, torque: float, time: float, angle: float) -> None:
    """Without weight: w1 = w0 - T tr/(2 J), t = td + tr + w1 J/T; if w1 < 0, t = td + sqrt(2 J w0 tr/T)."""
    press = without_masses(shipped("crank_slide"))
    for speed in (5.0, -5.0):
        stop = BrakedPress(press, speed, torque, 0.030, 0.050, inertia, ()).stop(1.0, 2.0)
        assert (stop.time, stop.overrun) == pytest.approx((time, angle), rel=2e-11)


# independent NumPy script in maximal coordinates; the last signal is that of the longest stop, of which it printed four decimals
STOPS = {0.0: (0.0533197018, 10.9542235119), 90.0: (0.0791215914, 14.3199638903), 180.0: (0.2387742830, 51.3760863658)}
STOPS |= {270.0: (0.0772636452, 27.9861821876), 195.0: (None, 59.247065), 178.3020: (0.239627928, 49.580726)}


def test_stops_of_the_six_bar() -> None:
    for signal, (time, overrun) in STOPS.items():
        stop = six_bar_press(25e3).stop(math.radians(signal), 3.0)
        if time is not None:
            assert stop.time == pytest.approx(time, abs=6e-11 if signal % 90 == 0 else 1.5e-9)
        assert math.degrees(stop.overrun) == pytest.approx(overrun, abs=1e-10 if signal % 90 == 0 else 5e-5 if time else 6e-7)
    inertia = reduced_model_of(shipped("zxn2_3000b")).at(np.linspace(0.0, 2 * np.pi, 721))[0][INERTIA]
    assert (inertia.min(), inertia.max()) == pytest.approx((35.8451, 356.3045), abs=6e-5)
    weight = six_bar_press(25e3).holding_torque(np.radians([96.25, 209.5]))
    assert weight == pytest.approx([13533.588, -14989.069], abs=6e-4)


@pytest.fixture(scope="module")
def stops() -> pp.ratings.StoppingTimes:
    return pp.ratings.stopping(shipped("zxn2_3000b"), SPEED, 25e3, 0.030, 0.050, control=0.010, device=0.020)


@pytest.mark.exhaustive
def test_worst_signal_is_searched_and_a_brake_that_slips_has_no_time(stops: pp.ratings.StoppingTimes) -> None:
    full, half = stops.cases[FULL], stops.cases[HALF]
    assert full.worst_elsewhere is None
    assert not full.slips
    assert stops.worst.time == pytest.approx(0.239627928, abs=5e-9)  # the search of that script ended 0.003 deg beside the worst signal
    assert math.degrees(stops.worst.signal) == pytest.approx(178.3020, abs=5e-3)
    assert stops.worst.travel == pytest.approx(0.15737, abs=2e-5)
    assert stops.worst.time == full.time.max() == full.time[stops.closing].max()
    assert full.margin == pytest.approx(25e3 / 14989.069, rel=1e-6)  # that one is the largest in steps of 0.25 deg
    assert full.top_stop is not None
    assert math.degrees(full.top_stop.overrun) == pytest.approx(14.98461382, abs=1e-7)
    end = full.top_stop.signal + full.top_stop.overrun
    assert end == pytest.approx(pp.dead_centres(shipped("zxn2_3000b")).top_angle + 2 * np.pi, abs=1e-8)
    assert np.degrees(full.overrun).max() == pytest.approx(59.4, abs=0.2)  # elsewhere: the longest time has not the largest angle
    assert half.worst is None
    assert not half.time.size
    assert np.degrees([each[:2] for each in half.slips]).ravel() == pytest.approx([78.613513, 112.217953, 188.349981, 233.835281], abs=6e-7)
    assert [each[2] for each in half.slips] == ["slips back", "runs on"]
    with pytest.warns(pp.PinpressWarning, match="half of the springs does not hold the press at 78.61 to 112.22 deg"):
        stops.distance("OSHA 1910.217")


@pytest.mark.exhaustive
def test_a_stronger_brake_holds_with_half_of_its_springs_too() -> None:
    stops = pp.ratings.stopping(shipped("zxn2_3000b"), SPEED, 32e3, 0.030, 0.050)
    for name, time, signal, torque in ((FULL, 0.180472095, 185.3348, 32e3), (HALF, 0.648522585, 158.4574, 16e3)):
        worst = stops.cases[name].worst
        assert worst is not None
        assert worst.time == pytest.approx(time, abs=2e-6)
        assert six_bar_press(torque).stop(math.radians(signal), 3.0).time == pytest.approx(time, abs=3e-8)  # by the digits of the signal
        assert worst.time >= time
        assert math.degrees(worst.signal) == pytest.approx(signal, abs=5e-3)
        assert worst.time == pytest.approx(stop_by_hand(math.degrees(worst.signal), torque), abs=1e-7)


def test_a_symmetric_press_stops_backwards_as_forwards_and_through_bottom_dead_centre_its_slide_goes_down_and_up() -> None:
    press = shipped("crank_slide")
    top = pp.dead_centres(press).top_angle
    for after in (0.3, 1.7, 2.9, 4.0):
        one, other = (BrakedPress(press, w, 500.0, 0.02, 0.03, 0.0, ()).stop(top + math.copysign(after, w), 3.0) for w in (10.0, -10.0))
        assert (one.time, one.overrun, one.travel) == pytest.approx((other.time, other.overrun, other.travel), abs=1e-10)
        path = pp.servo_cycle(press, np.linspace(one.signal, one.signal + one.overrun, 20001), speed=1.0).slide_position
        assert one.travel == pytest.approx(np.abs(np.diff(path)).sum(), rel=1e-7)


@pytest.mark.exhaustive
def test_a_failed_balance_cylinder_is_a_case_of_its_own() -> None:
    press, up = shipped("crank_slide"), [pp.loads.PointForce("slide", (0.0, 0.0, 900.0))]
    stops = pp.ratings.stopping(press, -10.0, 500.0, 0.02, 0.03, loads=up)
    weights = [pp.inverse_dynamics(press, pp.cycle(press, 1e-6, points=720), loads).driving_torque for loads in (up, [])]
    for name, torque, weight in ((FULL, 500.0, weights[0]), (HALF, 250.0, weights[0]), (UNLOADED, 500.0, weights[1])):
        assert stops.cases[name].margin == pytest.approx(torque / np.abs(weight).max(), rel=1e-4)
    closed, ends = stops.signal[stops.closing], pp.dead_centres(press)
    assert (closed[0], closed[-1]) == pytest.approx((ends.top_angle, ends.top_angle - np.pi), abs=1e-9)


@pytest.mark.exhaustive
def test_a_longer_stop_right_before_top_dead_centre_is_found() -> None:
    press, speed = shipped("zxn2_3000b"), 50 * pp.RPM
    brake = 1.0002 * 14989.069
    with pytest.warns(pp.PinpressWarning, match=r"all springs: the brake barely holds the press, with 1\.000\d+ times its holding torque"):
        stops = pp.ratings.stopping(press, speed, brake, 0.03, 0.05)
    longest = stops.cases["all springs"].worst_elsewhere
    assert longest is not None
    assert math.degrees(longest.signal) % 360 == pytest.approx(155.41, abs=0.01)  # 0.085 deg before top dead centre
    assert longest.time > 2 * stops.worst.time
    with pytest.warns(pp.PinpressWarning, match="outside of the closing stroke"), pytest.warns(pp.PinpressWarning, match="does not hold"):
        stops.distance("ISO 13855:2010", resolution=0.014)


def test_searched_signals_are_among_the_signals_and_failures_have_their_own_distance(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(emergency_stops, "STEP", math.radians(45))  # fewer signals are faster
    press, up = shipped("crank_slide"), (pp.loads.PointForce("slide", (0.0, 0.0, 300.0)),)
    holding = BrakedPress(press, 10.0, 1.0, 0.0, 0.0, 0.0, up).holding_torque(np.linspace(0.0, 2 * np.pi, 7201))
    with pytest.warns(pp.PinpressWarning, match="half of the springs: the brake barely holds the press, with 1.004 times"):
        stops = pp.ratings.stopping(press, 10.0, 2.008 * float(np.abs(holding).max()), 0.02, 0.03, control=0.01, loads=up)
    assert (np.diff(stops.signal) > 0).all()
    held = {name: case for name, case in stops.cases.items() if case.worst is not None}
    assert {*held} == {FULL, HALF, UNLOADED}
    for name, case in held.items():
        assert np.array_equal(case.signal, stops.signal)
        assert case.time[stops.closing].max() == case.worst.time, name
    result = stops.distance("ISO 13855:2010", resolution=0.014)
    assert {*result.failed} == {HALF, UNLOADED}
    for name, found in result.failed.items():
        expected = distance("ISO 13855:2010", held[name].worst.time + 0.01, resolution=0.014)
        assert found is not None
        assert 1e3 * found.distance == pytest.approx(expected, rel=1e-12)
    half = result.failed[HALF]
    assert half is not None
    # each distance has the speed K by which it is computed
    pace = "S = K T + C, K = 1600 mm/s" if half.distance > 0.5 else "S = K T + C, K = 2000 mm/s"
    assert f"{1e3 * half.distance:.3f} mm     half of the springs, ISO 13855:2010; {pace}" in str(result)


def test_a_failure_that_the_brake_does_not_hold_has_no_distance(stops: pp.ratings.StoppingTimes) -> None:
    assert stops.cases[HALF].worst is None
    with pytest.warns(pp.PinpressWarning, match="half of the springs does not hold the press"):
        result = stops.distance("ISO 13855:2010", resolution=0.014)
    assert result.failed[HALF] is None
    assert "half of the springs: the brake does not hold the press" in str(result)


def test_a_slow_press_that_turns_back_before_its_brake_closes_goes_both_ways() -> None:
    lifted = (pp.loads.PointForce("slide", (0.0, 0.0, 2e3)),)
    stop = BrakedPress(shipped("crank_slide"), 1.0, 2000.0, 0.25, 0.05, 0.0, lifted).stop(math.radians(200.0), 3.0)
    assert math.degrees(stop.overrun) == pytest.approx(-33.13, abs=0.005)
    assert stop.travel == pytest.approx(0.01236, abs=2e-5)  # 6.54 mm from end to end


# the formulas by hand: T [s], d [mm], S [mm]; the first one is printed by Rockwell 450L-UM001, p. 72
BY_ISO = [(0.32, 14, 512.0), (0.238, 14, 476.0), (0.238, 20, 500.0), (0.238, 30, 508.8), (0.238, 40, 588.8)]
BY_ISO += [(0.268, 14, 500.0), (0.268, 20, 500.0), (0.268, 30, 556.8), (0.268, 40, 636.8), (0.04, 14, 100.0), (0.238, 50, 1230.8)]


def distance(edition: str, time: float, monitor: float | None = None, two_hand: bool = False, **lengths: float) -> float:
    times = {"stopping": time, "at 90 deg": time, "control": 0.0, "device": 0.0}
    result = safety_distance(edition, times, monitor, lengths, two_hand, "all springs and loads")
    assert result.distance == pytest.approx(sum(length for _, _, length, _ in result.addends), abs=1e-15)
    return 1e3 * result.distance


def test_distances_of_each_edition() -> None:
    for time, resolution, expected in BY_ISO:
        assert distance("ISO 13855:2010", time, resolution=1e-3 * resolution) == pytest.approx(expected, rel=1e-12)
    assert distance("ISO 13855:2010", 0.238, two_hand=True) == pytest.approx(1600 * 0.238 + 250)
    assert distance("ISO 13855:2024", 0.2, reach=0.0, supplement=0.1) == pytest.approx(500.0)
    assert distance("ISO 13855:2024", 0.3, reach=0.1, supplement=0.0) == pytest.approx(580.0)
    assert distance("ISO 13855:2024", 0.2, two_hand=True, reach=0.55, supplement=0.0) == pytest.approx(870.0)
    assert distance("OSHA 1910.217", 0.238) == pytest.approx(380.85, abs=5e-3)
    assert distance("OSHA 1910.217", 0.268) == pytest.approx(428.85, abs=5e-3)
    assert distance("ANSI B11.19", 0.238, monitor=0.0, resolution=0.014) == pytest.approx(63 * 25.4 * 0.238 + 3.4 * 7)
    assert distance("ANSI B11.19", 0.2, resolution=0.005) == pytest.approx(63 * 25.4 * 0.24)  # 20 % without a monitor


@pytest.mark.exhaustive
def test_addends_are_named(stops: pp.ratings.StoppingTimes) -> None:
    with pytest.warns(pp.PinpressWarning, match="does not hold"):
        result = stops.distance("ISO 13855:2010", resolution=0.014)
    assert [name for name, *_ in result.addends] == ["stopping time", "control", "device", "C", "up to 500 mm"]
    assert result.distance == 0.5
    assert "SICK 8012624" in result.formula


REFUSED = [
    (lambda: stopping(0.0), "speed is 0.0: give one number that is not zero"),
    (lambda: stopping(5.0, brake=-1.0), "brake is -1.0: give a positive number"),
    (lambda: stopping(5.0, delay=-0.1), "delay is -0.1: give 0, or one number from 1e-9 to 1e9 [s]"),
    (lambda: stopping(5.0, delay=30.0), "delay is 30 s, and no press takes as long: if ms are meant, write 30e-3"),
    (lambda: stopping(5.0, brake=60.0), "the brake of 60 N m does not hold the press at"),
    (lambda: stopping(5.0, loads=[pp.loads.ConstantForce(1e3, 0.01)]), "is not a load of ratings"),
    (lambda: distance("ISO 13855", 0.2), "edition is 'ISO 13855': give one of ISO 13855:2010"),
    (lambda: distance("ISO 13855:2010", 0.2), "ISO 13855:2010 needs resolution"),
    (lambda: distance("ISO 13855:2024", 0.2, resolution=0.014), "resolution is no part of the formula of ISO 13855:2024"),
    (lambda: distance("ISO 13855:2024", 0.2, reach=0.1), "ISO 13855:2024 needs supplement"),
    (lambda: distance("ISO 13855:2010", 0.2, resolution=0.09), "resolution is 90 mm: the formula is for curtains of at most 70 mm"),
    (lambda: distance("ANSI B11.19", 0.2, resolution=0.07), "resolution is 70 mm: Dpf = 3.4 (d - 7 mm) is for curtains of at most 64 mm"),
    (lambda: distance("ANSI B11.19", 0.2, two_hand=True), "two_hand is no part of the formula of ANSI B11.19"),
]


def stopping(speed: float, brake: float = 500.0, delay: float = 0.03, **more: object) -> pp.ratings.StoppingTimes:
    return pp.ratings.stopping(shipped("crank_slide"), speed, brake, delay, 0.05, **more)


@pytest.mark.parametrize(("call", "message"), REFUSED)
def test_refused(call, message: str) -> None:
    with pytest.raises(pp.PinpressError) as error:
        call()
    assert message in str(error.value)


@pytest.mark.exhaustive
def test_warned(stops: pp.ratings.StoppingTimes) -> None:
    with pytest.warns(pp.PinpressWarning, match="resolution is 0.014 mm"), pytest.warns(pp.PinpressWarning, match="does not hold"):
        stops.distance("ANSI B11.19", resolution=14e-6)
    with pytest.warns(pp.PinpressWarning, match="it takes 2.2 s"):
        distance("OSHA 1910.217", 2.2)
