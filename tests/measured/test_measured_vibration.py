"""Vibrations measured by accelerometers: spectra, orders, modes from hits, mounts fitted to them, against systems of which all is known."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student
from support import hammer_hits
from support.hammer_hits import BEGIN, RATE, SENSORS, columns, standing

from pinpress import RPM, PinpressError, PinpressWarning, UnknownNameError, foundation, measured
from pinpress.foundation.mounted_press import with_mounts
from pinpress.measured import hit_modes
from pinpress.measured.hit_modes import MeasuredModes

ONE = {"A [m/s2]": measured.Accelerometer((0.0, 0.0, 1.0), "x")}
TIME = np.arange(20_000) / 1000.0


def one(values, **more):
    """A record of one channel at 1000 Hz."""
    return measured.vibration({"time [s]": TIME[: len(values)], "A [m/s2]": values}, ONE, **more)


# --------------------------------------------------------------------------------------------------------------------------------- reading


def test_units_gains_and_directions(tmp_path):
    """A column in V with a gain, one in g, and the same in m/s2 are one acceleration; a file of points says what a mapping does."""
    wave = np.sin(2 * np.pi * 8 * TIME[:2000])
    table = {"t [ms]": 1000 * TIME[:2000], "a [V]": wave, "b [g]": wave, "c [m/s2]": 9.80665 * wave}
    millivolts = measured.vibration(
        {"time [s]": TIME[:2000], "A [mV]": wave}, {"A [mV]": measured.Accelerometer((1, 2, 3), "y", gain=20.0)}
    )
    np.testing.assert_allclose(millivolts.runs[0].acceleration[:, 0], 0.02 * wave, atol=1e-12)
    points = {
        "a [V]": measured.Accelerometer((1, 2, 3), "-y", gain=9.80665),
        "b [g]": measured.Accelerometer(("crown", (1, 2, 3)), (0, 0, 2)),
        "c [m/s2]": measured.Accelerometer((1, 2, 3), "x"),
    }
    record = measured.vibration(table, points)
    np.testing.assert_allclose(record.runs[0].acceleration, 9.80665 * np.column_stack([wave] * 3), atol=1e-12)
    assert record.runs[0].rate == pytest.approx(1000.0)
    np.testing.assert_array_equal([sensor.along for sensor in record.accelerometers.values()], [(0, -1, 0), (0, 0, 1), (1, 0, 0)])
    (tmp_path / "points.csv").write_text(
        "channel,x [m],y [m],z [m],direction,part,gain\na [V],1,2,3,-y,,9.80665\nb [g],1,2,3,z,crown,\nc [m/s2],1,2,3,x,bed,\n"
    )
    np.savetxt(tmp_path / "run.csv", np.column_stack(list(table.values())), delimiter=",", header=",".join(table), comments="", fmt="%.12g")
    same = measured.vibration(tmp_path / "run.csv", tmp_path / "points.csv")
    np.testing.assert_allclose(same.runs[0].acceleration, record.runs[0].acceleration, atol=1e-9)
    assert same.accelerometers["b"].on_crown
    assert "crown 1, 2, 3 m" in str(same)


def test_an_accelerometer_reads_the_motion_of_its_point():
    """A turn about x by 1 moves a point at (1, 2, 3) by (0, -3, 2)."""
    sensor = measured.Accelerometer(("crown", (1.0, 2.0, 3.0)), "z")
    np.testing.assert_array_equal(sensor.row(2), [0, 0, 0, 0, 0, 0, 0, 0, 1, 2, -1, 0])
    np.testing.assert_array_equal(measured.Accelerometer((1.0, 2.0, 3.0), "-y").row(1), [0, -1, 0, 3, 0, -1])


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: measured.Accelerometer((0, 0), "z"), r"point is \(0, 0\)"),
        (lambda: measured.Accelerometer((0, 0, 0), "w"), "direction is 'w': give one of x, y, z"),
        (lambda: measured.Accelerometer((0, 0, 0), "z", gain=0.0), "gain is 0.0"),
        (lambda: measured.vibration({"time [s]": TIME, "A [V]": TIME}, {"A [V]": ONE["A [m/s2]"]}), "is in V: name it in one of m/s2"),
        (lambda: measured.vibration({"time [s]": TIME, "A": TIME}, {"A": ONE["A [m/s2]"]}), "has no unit"),
        (lambda: measured.vibration({"time [s]": TIME, "B [g]": TIME}, ONE), "no column in run 1 of the name 'A'"),
        (lambda: measured.vibration({"time [s]": TIME**1.2, "A [m/s2]": TIME}, ONE), "not in equal time steps"),
        (lambda: measured.vibration({"time [s]": TIME, "A [m/s2]": np.sin(TIME)}, {}), "points is {}"),
        (lambda: one(np.sin(TIME), speed=3.0, tacho="A"), "several of angle, tacho and speed"),
        (lambda: one(np.sin(TIME), speed=-3.0), "speed is -3.0: give one positive speed"),
        (lambda: one(np.sin(TIME), tacho="A [m/s2]", pulses=0), "pulses is 0"),
        (lambda: one(np.sin(TIME)).order_spectra(), "the crank angle is not known"),
        (lambda: one(np.sin(TIME), speed=2.0).order_spectra(turns=8), "6.366 turns of the crank are less than a window of 8"),
        (lambda: one(np.sin(TIME), speed=300.0).order_spectra(12), "is 573 Hz; 1000 samples a second are too few"),
        (lambda: one(np.sin(TIME)).spectra(1e-3), "resolution 0.001 Hz needs windows of 1000000 samples"),
        (lambda: one(np.sin(TIME)).modes(), "neither beside nor band"),
        (lambda: one(np.sin(TIME)).modes(band=(5, 450)), "1000 samples a second are too few for 450 Hz"),
        (lambda: one(np.sin(50 * TIME)).modes(band=(2, 50)), "no hit stands out"),
        (lambda: one(np.sin(TIME)).modes(band=(5, 50), hits=[30.0]), "give times from 0 to 19.999 s"),
        (lambda: one(np.sin(TIME)).decrement("B", (5, 50)), "no channel 'B'"),
    ],
)
def test_records_that_cannot_be_used_are_named(make, says):
    with pytest.raises(PinpressError, match=says):
        make()


@pytest.mark.parametrize(
    ("values", "says"),
    [
        (np.zeros(1000), "constant, 0 in all samples"),
        (np.clip(np.sin(50 * TIME), -0.7, 0.7), "stays at its extreme for"),
        (1e5 * np.sin(50 * TIME), "check its unit, or its gain"),
    ],
)
def test_doubtful_channels_are_warned_of(values, says):
    with pytest.warns(PinpressWarning, match=says):
        one(values)


# --------------------------------------------------------------------------------------------------------------------------------- spectra


def test_densities_hold_the_mean_square_and_lines_stand_where_they_are():
    """Parseval: a sine of amplitude 2 and noise of 0.5 have the mean square 2.25."""
    rng = np.random.default_rng(1)
    found = one(2 * np.sin(2 * np.pi * 37 * TIME) + 0.5 * rng.normal(size=len(TIME))).spectra(0.5)
    assert found.rms[0] == pytest.approx(1.5, rel=0.02)
    assert found.lines[0] == pytest.approx(37.0)
    np.testing.assert_allclose(np.diff(found.frequency), 0.5)
    assert found.density[300:, 0].mean() == pytest.approx(0.25 / 500, rel=0.05)


def test_runs_count_by_their_windows():
    """By default the shortest run is eight windows side by side, which are fifteen that overlap by half; a run of twice the time has 31."""
    long, short = 2 * np.sin(2 * np.pi * 40 * TIME), 5 * np.sin(2 * np.pi * 40 * TIME[:10_000])
    runs = [{"time [s]": TIME[: len(values)], "A [m/s2]": values} for values in (long, short)]
    found = measured.vibration(runs, ONE).spectra()
    np.testing.assert_allclose(np.diff(found.frequency), 8 / 10)
    assert found.windows == 15 + 31
    assert found.rms[0] ** 2 == pytest.approx((31 * 2**2 / 2 + 15 * 5**2 / 2) / 46, rel=1e-3)


@pytest.mark.parametrize("how", ["angle", "tacho"])
def test_orders_stay_sharp_while_the_speed_changes(how):
    """A run-up from 150 to 450 r/min: amplitudes 1 and 0.3 at orders 1 and 2.5, and a vibration at 20 Hz that is no order."""
    speed = RPM * (150 + 15 * TIME)
    angle = np.cumsum(speed) / 1000.0
    values = np.sin(angle) + 0.3 * np.cos(2.5 * angle + 0.2)
    columns = {"time [s]": TIME, "A [m/s2]": values, "crank [deg]": np.degrees(angle) % 360, "tacho [V]": 5.0 * (np.sin(angle) > 0)}
    record = measured.vibration(columns, ONE, **({"angle": "crank [deg]"} if how == "angle" else {"tacho": "tacho"}))
    found = record.order_spectra(4, turns=8)
    tolerance = 2e-3 if how == "angle" else 0.02  # between pulses a sample long in the drawn pose the records show an angle of a guess
    np.testing.assert_allclose(found.of("A", 1), 1.0, rtol=tolerance)
    np.testing.assert_allclose(found.of("A", 2.5), 0.3, rtol=10 * tolerance)
    assert found.of("A", 3.5).max() < 0.01
    assert (np.diff(found.speed) > 0).all()
    assert found.speed[0] / RPM == pytest.approx(150 + 15 * 1.45, rel=0.05)
    with pytest.raises(PinpressError, match=r"order 2\.3 is not resolved: give a multiple of 0\.125"):
        found.of("A", 2.3)


@pytest.mark.parametrize("order", [1.0, 7.0, 12.0])
def test_orders_keep_their_size_up_to_the_fewest_samples_that_are_taken(order):
    """Order 12 of a crank whose speed swings by 1.5 % about 50 rad/s, at 2.5 samples a period where it is fastest."""
    rate = 2.5 * 12 * 50 * 1.016 / (2 * np.pi)
    time = np.arange(int(40 * 2 * np.pi / 50 * rate)) / rate
    angle = 50 * time + 0.05 * np.sin(15 * time)
    columns = {"time [s]": time, "A [m/s2]": 2 * np.cos(order * angle + 0.3) + 9.81, "crank [rad]": angle}
    found = measured.vibration(columns, ONE, angle="crank [rad]").order_spectra(12, turns=8)
    np.testing.assert_allclose(found.of("A", order), 2.0, rtol=5e-4)


def test_noise_alone_has_no_peaks_and_windows_are_those_that_are_averaged():
    rng = np.random.default_rng(3)
    record = one(rng.normal(size=len(TIME)))
    for resolution in (None, 0.06, 0.4, 3.0):
        assert len(record.spectra(resolution).lines) == 0
    assert record.spectra(0.08).windows == 2  # of 12 500 samples each in 20 000, half of one apart


def test_given_speeds_lay_runs_beside_each_other():
    runs = [{"time [s]": TIME, "A [m/s2]": size * np.sin(speed * TIME)} for size, speed in ((1.0, 20.0), (4.0, 40.0))]
    found = measured.vibration(runs, ONE, speed=[20.0, 40.0]).order_spectra(3, turns=10)
    np.testing.assert_allclose(found.of("A", 1), np.where(found.speed < 30, 1.0, 4.0), rtol=1e-3)
    assert "OrderSpectra" in str(found)
    with pytest.raises(PinpressError, match="or 2, one for each run"):
        measured.vibration(runs, ONE, speed=[20.0, 30.0, 40.0])


# ----------------------------------------------------------------------------------------------------------------------------------- modes


def test_modes_of_a_press_are_found_from_three_hits():
    """All six modes, the first two of them closer than their damping is wide: frequencies to 0.02 %, damping to 1e-4, shapes to 0.998."""
    record = measured.vibration(columns(), SENSORS)
    exact = foundation.modes(standing())
    found = record.modes(beside=exact)
    np.testing.assert_allclose(found.hits, [BEGIN / RATE, 2 * BEGIN / RATE + 8, 3 * BEGIN / RATE + 16], atol=0.05)
    np.testing.assert_allclose(found.natural_frequency, exact.natural_frequency, rtol=2e-4)
    np.testing.assert_allclose(found.damping_ratio, hammer_hits.free(0)[1], atol=1e-4)
    assert found.partner == (0, 1, 2, 3, 4, 5)
    assert found.mac[range(6), range(6)].min() > 0.998
    assert found.energy_share.sum() == pytest.approx(1.0)
    assert "rocking about y" in str(found)
    assert found.doubts == ()
    rows = found.columns()
    assert rows["motion"] == list(exact.motion)
    np.testing.assert_allclose(np.array(rows["calculated_frequency [Hz]"], dtype=float), exact.natural_frequency / (2 * np.pi), rtol=1e-12)
    decay = found.damping_ratio * found.natural_frequency * 2 * np.pi / (found.natural_frequency * np.sqrt(1 - found.damping_ratio**2))
    np.testing.assert_allclose(rows["logarithmic_decrement [-]"], decay, rtol=1e-12)  # decay rate times the period of the damped swing
    np.testing.assert_allclose(2 * np.pi * rows["frequency [Hz]"], found.natural_frequency, rtol=1e-12)
    np.testing.assert_allclose(2 * np.pi * rows["frequency_deviation [Hz]"], found.natural_frequency_deviation, rtol=1e-12)
    np.testing.assert_array_equal(np.array(rows["mac [-]"], dtype=float), found.mac[range(6), range(6)])


@pytest.mark.exhaustive
def test_deviations_of_modes_are_those_of_many_records():
    exact = foundation.modes(standing())
    errors = []
    for seed in range(30):
        found = measured.vibration(columns(noise=0.1, seed=seed), SENSORS).modes(beside=exact)
        errors.append((found.natural_frequency - exact.natural_frequency) / found.natural_frequency_deviation)
        errors.append((found.damping_ratio - hammer_hits.free(0)[1]) / found.damping_ratio_deviation)
    spread = np.sqrt(np.mean(np.square(errors)))
    assert 0.85 < spread < 1.15  # 360 errors: 4 %
    assert np.abs(errors).max() < 5


def test_without_noise_modes_are_exact():
    found = measured.vibration(columns(noise=0.0), SENSORS).modes(
        band=(2, 30), hits=[BEGIN / RATE, 2 * BEGIN / RATE + 8, 3 * BEGIN / RATE + 16]
    )
    np.testing.assert_allclose(found.natural_frequency, foundation.modes(standing()).natural_frequency, rtol=1e-6)
    assert found.beside is None
    assert found.partner == (-1,) * 6
    assert "calculated" not in str(found)


@pytest.mark.exhaustive
def test_a_soft_hammer_a_hum_and_a_frame_that_bends():
    """Blows of 12 ms, a hum at 50 Hz, a bending mode at 90 Hz and 2 % noise: all six modes, the bending one, and the hum by its name."""
    table, rng = columns(noise=0.02, seed=3, seconds=4.0), np.random.default_rng(0)
    time, pulse, w = table["time [s]"], np.hanning(7) / np.hanning(7).sum(), 2 * np.pi * 90
    bending = np.zeros(len(time))
    for begin, size in ((BEGIN, 1.0), (2 * BEGIN + 2000, -0.6), (3 * BEGIN + 4000, 0.8)):
        bending[begin:] += size * np.exp(-0.01 * w * (time[begin:] - time[begin])) * np.sin(w * (time[begin:] - time[begin]))
    for name in SENSORS:
        hum = 0.05 * rng.normal() * np.sin(2 * np.pi * 50 * time + rng.normal())
        table[name] = np.convolve(table[name], pulse)[: len(time)] + rng.normal() * bending + hum + 0.1 * rng.normal()
    found = measured.vibration(table, SENSORS).modes(band=(2, 120), beside=foundation.modes(standing()))
    expected = [*foundation.modes(standing()).natural_frequency, 2 * np.pi * 50, w]
    np.testing.assert_allclose(found.natural_frequency, expected, rtol=2e-3)
    np.testing.assert_allclose(found.damping_ratio, [*(hammer_hits.free(0)[1],) * 6, 0.0, 0.01], atol=2e-3)
    assert found.partner == (0, 1, 2, 3, 4, 5, -1, -1)  # the frame bends and hums beyond what was calculated
    assert [each is None for each in found.columns()["calculated_frequency [Hz]"]] == [False] * 6 + [True] * 2
    assert [each is None for each in found.columns()["mac [-]"]] == [False] * 6 + [True] * 2
    assert found.doubts == (
        "50 Hz does not die away: it is not a mode, but a hum or a machine that runs nearby",
        "the first 0.25 s after the hits are left out, because the vibration is not yet free: the hammer is soft, "
        "or it bounced and struck again",
    )


def test_one_hit_does_not_tell_close_modes_apart():
    with pytest.warns(PinpressWarning, match="are closer than their damping is wide: 1 hit mixes their shapes"):
        measured.vibration(columns(blows=(0,), noise=1e-3), SENSORS).modes(band=(2, 30))


def bounced(rng, modes, bounces):
    """Free vibrations of modes (Hz, damping ratio) after two hits with noise, in closed form; a bouncing hammer strikes twice."""
    time, channels = np.arange(7500) / 1000.0, int(rng.integers(1, 4))
    values = np.zeros((len(time), channels))
    shapes = rng.normal(size=(len(modes), channels))
    for begin in (0.5, 4.0):
        blows = [(begin, 1.0), *([(begin + rng.uniform(0.02, 0.25), rng.uniform(0.3, 0.7))] if bounces else [])]
        strengths = rng.choice([-1.0, 1.0], len(modes)) * rng.uniform(0.5, 1.5, len(modes))
        for at, size in blows:
            since = np.maximum(time - at, 0.0)[:, None]
            for (frequency, ratio), shape, strength in zip(modes, shapes, strengths, strict=True):
                w = 2 * np.pi * frequency
                values += size * strength * shape * np.exp(-ratio * w * since) * np.sin(w * np.sqrt(1 - ratio**2) * since)
    values += rng.uniform(1e-3, 1e-2) * np.abs(values).max() * rng.normal(size=values.shape)
    sensors = {f"{k} [m/s2]": measured.Accelerometer((0.0, 0.0, float(k)), "x") for k in range(channels)}
    return measured.vibration({"time [s]": time, **dict(zip(sensors, values.T, strict=True))}, sensors)


@pytest.mark.parametrize("seed", [*range(2), *(pytest.param(seed, marks=pytest.mark.exhaustive) for seed in range(2, 40))])
def test_a_bouncing_hammer_is_doubted_and_its_modes_are_right(seed):
    """One mode or two, one to three channels, blows 20 to 250 ms apart: the doubt is said, and intervals hold. A clean record has none."""
    rng = np.random.default_rng(seed)
    modes = [(20.0, rng.uniform(0.01, 0.06)), (33.0, rng.uniform(0.01, 0.06))][: 1 + seed % 2]
    clean = bounced(np.random.default_rng(seed), modes, False).modes(band=(5, 60))
    assert (len(clean.natural_frequency), clean.misfit) == (len(modes), 1.0)
    with warnings.catch_warnings(record=True):
        warnings.simplefilter("always")
        found = bounced(rng, modes, True).modes(band=(5, 60))
    assert found.late > 0
    assert any("the hammer" in each for each in found.doubts)
    exact = np.array(modes)
    for each in (clean, found):
        frequency, deviation = each.natural_frequency / (2 * np.pi), each.natural_frequency_deviation / (2 * np.pi)
        near = exact[np.abs(np.subtract.outer(frequency, exact[:, 0])).argmin(axis=1)]
        assert (np.abs(frequency - near[:, 0]) < 4.5 * deviation).all()
        assert (np.abs(each.damping_ratio - near[:, 1]) < 4.5 * each.damping_ratio_deviation).all()


def test_decrement_of_one_channel_in_a_band():
    """The band holds the mode of 23.9 Hz alone; its neighbour at 19.5 Hz is left out."""
    record = measured.vibration(columns(blows=(2,), noise=1e-3), SENSORS)
    ratio = hammer_hits.free(0)[1]
    start = BEGIN / RATE + 0.05
    assert record.decrement("Bz", (22, 26), start=start) == pytest.approx(2 * np.pi * ratio, rel=0.15)
    with pytest.raises(UnknownNameError):
        record.decrement("Fz", (18, 21))


# ---------------------------------------------------------------------------------------------------------------------------------- mounts


@pytest.mark.exhaustive
def test_mounts_are_fitted_to_measured_frequencies():
    """Pads of 60 Shore A that were thought to be of 70: the factors on their stiffness are known, and so is the loss."""
    thought, real = standing(70.0, 0.03), standing()
    found = measured.vibration(columns(), SENSORS).modes(beside=foundation.modes(thought))
    fitted = measured.fit_mounts(thought, found)
    expected = [*np.divide(real.mounts[0].stiffness, thought.mounts[0].stiffness), 2 * hammer_hits.free(0)[1]]
    np.testing.assert_allclose(fitted.values, expected, rtol=0.01)
    assert ((fitted.intervals[:, 0] < expected) & (expected < fitted.intervals[:, 1])).all()
    np.testing.assert_allclose(fitted.frequency, found.natural_frequency, rtol=1e-3)
    np.testing.assert_allclose(foundation.modes(fitted.system).natural_frequency, foundation.modes(real).natural_frequency, rtol=1e-3)
    assert "stiffness of mounts along z" in str(fitted)
    with pytest.raises(PinpressError, match="have no dampers"):
        measured.fit_mounts(thought, found, damping="viscous")
    with pytest.raises(PinpressError, match="damping is 'rubber'"):
        measured.fit_mounts(thought, found, damping="rubber")


def as_measured(system, beside, known):
    """The modes of a system, with deviations as shares of their frequencies, as if measured, and one without a partner between them."""
    real = foundation.modes(system)
    partner = np.abs(real.shapes.T @ system.mass @ beside.shapes).argmax(axis=1)
    assert sorted(partner) == list(range(6))
    values = np.column_stack([real.natural_frequency, known * real.natural_frequency, real.damping_ratio, 0.5 * known])
    frequency, deviation, ratio, ratio_deviation = np.insert(values, 2, [20.0, 1.0, 0.3, 1.0], axis=0).T
    return MeasuredModes(
        channels=("A",),
        hits=np.zeros(1),
        natural_frequency=frequency,
        natural_frequency_deviation=deviation,
        damping_ratio=ratio,
        damping_ratio_deviation=ratio_deviation,
        shapes=np.ones((1, 7), dtype=complex),
        energy_share=np.full(7, 1 / 7),
        noise=0.0,
        beside=beside,
        partner=tuple(np.insert(partner, 2, -1).tolist()),
        mac=np.ones((7, 6)),
    )


@pytest.mark.parametrize("damping", ["viscous", "loss_factor"])
def test_intervals_of_mounts_are_those_of_linear_least_squares(damping):
    """Exact frequencies and damping ratios of changed mounts, one more mode between them that has no partner: the factors are exact, and
    their intervals those of differences of the model's own modes, by what is said to be known of each measured number."""

    def changed(factors):
        by_axis, last = factors[:3], factors[3]
        more = {"damping": np.array([4e4, 4e4, 6e4]) * last} if damping == "viscous" else {"loss_factor": 0.1 * last}
        mounts = [replace(each, stiffness=np.multiply(each.stiffness, by_axis), **more) for each in standing().mounts]
        return with_mounts(standing(), mounts)

    thought, factors = changed(np.ones(4)), np.array([0.7, 1.4, 0.9, 1.6])
    real, beside = foundation.modes(changed(factors)), foundation.modes(thought)
    known = np.array([2e-3, 3e-3, 4e-4, 1e-3, 5e-3, 1e-4])
    found = as_measured(changed(factors), beside, known)
    fitted = measured.fit_mounts(thought, found, damping=damping)
    expected = factors * [1, 1, 1, 1 if damping == "viscous" else 0.1]
    np.testing.assert_allclose(fitted.values, expected, rtol=1e-6)
    assert len(fitted.measured.partner) == len(fitted.frequency) == 6
    table = fitted.columns()
    np.testing.assert_array_equal(np.column_stack([table["low [-]"], table["high [-]"]]), fitted.intervals)
    np.testing.assert_allclose(fitted.frequency, real.natural_frequency, rtol=1e-7)

    def scaled(logarithms):
        one = foundation.modes(changed(factors * np.exp(logarithms)))
        return np.r_[
            np.log(one.natural_frequency) / np.hypot(known, 1e-3), one.damping_ratio / np.hypot(0.5 * known, 1e-3)
        ]  # the model is trusted to 1e-3

    slopes = np.column_stack([(scaled(1e-4 * unit) - scaled(-1e-4 * unit)) / 2e-4 for unit in np.eye(4)])
    half = student.ppf(0.975, 12 - 4) * np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))
    np.testing.assert_allclose(np.log(fitted.intervals / fitted.values[:, None]), np.outer(half, [-1, 1]), rtol=2e-3)


@pytest.mark.exhaustive
def test_mounts_that_cannot_have_the_frequencies_are_told():
    """Frequencies of mounts 30 times as stiff along y: the largest factor is 20."""
    thought = standing()
    stiff = with_mounts(thought, [replace(each, stiffness=np.multiply(each.stiffness, (1, 30, 1))) for each in thought.mounts])
    with pytest.warns(PinpressWarning, match=r"stiffness of mounts along y reaches its bound, 20") as told:
        fitted = measured.fit_mounts(thought, as_measured(stiff, foundation.modes(thought), np.full(6, 1e-3)))
    assert len(told) == 1
    assert fitted.values[1] == pytest.approx(20.0, rel=2e-3)


def test_shares_of_energy_are_those_of_each_mode_alone():
    """Of two modes seen by three channels after two hits of different lengths: squares of all samples of one and of the other."""
    random = np.random.default_rng(2)
    roots = np.array([-1.0 + 20j, -3.0 + 35j])
    shapes, strengths = (random.normal(size=size) + 1j * random.normal(size=size) for size in ((3, 2), (2, 2)))
    decays = hit_modes._Decays(tuple(np.zeros((n, 3)) for n in (200, 300)), 0.01, np.zeros(2), 1.0)
    energy = np.zeros(2)
    for hit, part in enumerate(decays.values):
        for mode in range(2):
            wave = strengths[mode, hit] * np.exp(roots[mode] * 0.01 * np.arange(len(part)))
            energy[mode] += (np.abs(np.outer(wave, shapes[:, mode])) ** 2).sum()
    found = hit_modes._energy_share(decays, hit_modes._Model(roots, shapes, strengths))
    np.testing.assert_allclose(found, energy / energy.sum(), rtol=1e-12)


def test_deviations_of_a_frequency_and_a_damping_ratio_are_those_of_their_root():
    """Of 200 000 roots about -2 + 30i, whose parts are correlated; w = |root| and the ratio is minus the real part over it."""
    covariance = np.array([[0.02, 0.007], [0.007, 0.01]])
    parts = np.random.default_rng(0).multivariate_normal([-2.0, 30.0], covariance, 200_000)
    sizes = np.hypot(*parts.T)
    found = hit_modes._deviations(np.array([-2.0 + 30.0j]), covariance)
    np.testing.assert_allclose(found[0], [sizes.std(), (-parts[:, 0] / sizes).std()], rtol=0.01)
