"""Records of files and arrays: what is read is what was written, and what is amiss is named with what to do."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import pinpress as pp
from pinpress.common.outlets.described import charts_of
from pinpress.measured import MeasuredRun, record

SHORT = Path(__file__).with_name("short.csv")
TIME = np.arange(400) / 200
ANGLE = 7.0 * TIME + 0.4 * np.sin(2 * TIME)
TORQUE = 100 * np.cos(ANGLE) + 50
CHANNELS = {"time [s]": TIME, "crank [rad]": ANGLE, "motor [N m]": TORQUE}


def changed(column, change):
    """A record from arrays with one column changed in place."""
    columns = {"time": TIME.copy(), "angle": ANGLE.copy(), "torque": TORQUE.copy()}
    change(columns[column])
    return MeasuredRun(**columns)


def put(at, value):
    def change(column):
        column[at] = value

    return change


def written(folder, ending, channels=CHANNELS):
    file = folder / f"run{ending}"
    pp.common.tables.__dict__[{".csv": "write_csv", ".mat": "write_mat", ".parquet": "write_parquet"}[ending]](file, channels)
    return file


@pytest.mark.parametrize("ending", [".csv", ".mat", ".parquet"])
def test_what_was_written_is_read(tmp_path, ending):
    run = record(written(tmp_path, ending), "crank [rad]", "motor [N m]", ratio=20.0)
    for found, meant in ((run.time, TIME), (run.angle, ANGLE), (run.torque, 20 * TORQUE)):
        np.testing.assert_array_equal(found, meant)


def test_mdf_files_keep_units_and_times(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    file = tmp_path / "run.mf4"
    signals = [
        asammdf.Signal(np.degrees(ANGLE), TIME, name="crank", unit="deg"),
        asammdf.Signal(TORQUE / 1e3, TIME, name="motor", unit="kN m"),
        asammdf.Signal(TORQUE[::2], TIME[::2], name="slow", unit="N m"),
    ]
    with asammdf.MDF() as made:
        made.append(signals[:2])
        made.append(signals[2:])
        made.save(file)
    run = record(file, "crank", "motor")
    np.testing.assert_allclose(run.angle, ANGLE, rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(run.torque, TORQUE, rtol=1e-14)
    with pytest.raises(pp.PinpressError, match=r"different times: resample"):
        record(file, "crank", "slow")
    with pytest.raises(pp.UnknownNameError, match="channel"):
        record(file, "crank", "moter")


def test_a_short_file_of_every_kind_of_column():
    """Milliseconds, degrees that start anew after each turn, kilonewtons."""
    run = record(
        SHORT,
        "crank [deg]",
        "motor [N m]",
        ratio=-2.0,
        angle_ratio=-1.0,
        zero=0.3,
        height="height [mm]",
        shaking_force={"z": "force [kN]"},
        shaking_moment={"y": "moment [kN m]"},
        between=(0.1, 0.5),
    )
    assert run.time[[0, -1]] == pytest.approx([0.1, 0.5])
    np.testing.assert_allclose(run.angle, -np.radians(2.1 * np.arange(20, 101)), atol=2e-4)
    assert run.torque[0] == pytest.approx(-2 * (12 + 5 * math.sin(2.2)), rel=1e-4)
    assert run.height.max() < 0.15
    assert -20301 < run.shaking_force["z"].min() < run.shaking_force["z"].max() < -19699
    assert run.shaking_moment["y"][0] == pytest.approx(200 * math.cos(1.0), rel=1e-3)
    assert "crank" not in run.notes


def test_angles_that_start_anew_are_made_continuous_and_it_is_said(tmp_path):
    steps = CHANNELS | {"crank [rad]": np.angle(np.exp(1j * ANGLE))}
    run = record(written(tmp_path, ".csv", steps), "crank [rad]", "motor [N m]")
    np.testing.assert_allclose(run.angle, ANGLE, atol=1e-13)
    assert "restarts" in str(run)
    counted = {"time [s]": TIME, "motor [N m]": TORQUE} | {"crank [counts]": np.round(ANGLE / (2 * np.pi) * 8192) % 2**16}
    run = record(written(tmp_path, ".csv", counted), "crank [counts]", "motor [N m]", counts=8192)
    np.testing.assert_allclose(run.angle, ANGLE, atol=4e-4)
    assert run.resolution == pytest.approx(2 * np.pi / 8192, rel=1e-6)


def test_european_tables_have_commas_in_numbers_and_units_in_a_line_of_their_own(tmp_path):
    file = tmp_path / "run.csv"
    rows = [f"{t:.6f};{a:.9f};{m:.9f}".replace(".", ",") for t, a, m in zip(TIME, ANGLE, TORQUE, strict=True)]
    file.write_text("\n".join(["Zeit;Kurbel;Motor", "s;rad;N m", *rows]), encoding="latin-1")
    np.testing.assert_allclose(record(file, "Kurbel", "Motor").torque, TORQUE, atol=1e-8)


@pytest.mark.parametrize(
    ("angle", "torque", "words"),
    [
        ("speed [rpm]", "motor [N m]", "is a speed in rpm, not an angle"),
        ("crank", "motor [%]", "multiply it by the rated torque"),
        ("crank [deg]", "motor [N m]", "is in rad, not in deg"),
        ("plain", "motor [N m]", r"has no unit: write the column as 'plain' with one of the units rad, deg"),
        ("plain [counts]", "motor [N m]", "give the counts in one turn"),
        ("crank", "crank", "which is not a unit of torque"),
        ("krank", "motor [N m]", "did you mean 'crank'"),
    ],
)
def test_wrong_columns_are_named(tmp_path, angle, torque, words):
    more = {"speed [rpm]": ANGLE, "motor [%]": TORQUE, "plain": ANGLE}
    channels = {"time [s]": TIME, "crank [rad]": ANGLE, **more, "motor [N m]": TORQUE}
    if "%" in torque:
        del channels["motor [N m]"]
    else:
        del channels["motor [%]"]
    with pytest.raises(pp.PinpressError, match=words):
        record(written(tmp_path, ".csv", channels), angle, torque)


@pytest.mark.parametrize(
    ("column", "change", "words"),
    [
        ("torque", put(7, math.nan), "torque is not finite at point 7"),
        ("time", put(slice(200, None), TIME[200:] + 1), r"no samples for 1.005 s after 0.995 s.*between="),
        ("time", put(9, TIME[8]), r"does not rise after 0.04 s"),
        ("angle", put(slice(99, None), ANGLE[99:] + 1), r"jumps by .* deg after 0.49 s"),
        ("angle", put(slice(None), 3.0), "rests all the time at 171.887 deg"),
        ("angle", lambda angle: angle.__imul__(20.0), r"sample at \d+ Hz or more"),
        ("torque", put(slice(None), 3.0), "is the same in all samples"),
        ("torque", lambda torque: torque.__imul__(1e-300), r"largest torque is .*e-298 N m, a size that no press has"),
        ("torque", lambda torque: torque.__imul__(1e300), r"largest torque is .*e\+302 N m, a size that no press has"),
    ],
)
def test_what_cannot_be_used_is_refused(column, change, words):
    with pytest.raises(pp.PinpressError, match=words):
        changed(column, change)


@pytest.mark.parametrize("way", [1, -1])
def test_a_press_that_turns_backwards_may_be_sampled_as_coarsely(way):
    """Every 6 degrees; a jump of 30 more is refused in either direction."""
    angle = way * np.radians(6.0) * np.arange(400)
    run = MeasuredRun(TIME, angle, way * TORQUE)
    assert run.strokes == pytest.approx(400 * 6 / 360, rel=0.01)
    with pytest.raises(pp.PinpressError, match=f"jumps by {way * 36} deg after 1 s"):
        MeasuredRun(TIME, angle + way * np.radians(30.0) * (TIME > 1.0), way * TORQUE)


@pytest.mark.parametrize(
    ("column", "change", "words"),
    [
        ("torque", lambda torque: np.minimum(torque, 120, out=torque), r"stays at 120 for \d+ samples from"),
        ("torque", lambda torque: torque.__imul__(-1.0), r"negative, as if the press drives its motor.*the sign"),
        ("time", lambda time: time.__iadd__(1e-3 * np.sin(1e4 * time)), "record at a fixed rate"),
        ("angle", put(slice(250, None), ANGLE[250]), r"the crank rests for 0.75 s from 1.25 s on. A brake.*between="),
    ],
)
def test_what_is_hardly_meant_is_warned_of(column, change, words):
    with pytest.warns(pp.PinpressWarning, match=words):
        changed(column, change)


def test_an_encoder_that_is_coarse_does_not_rest():
    """Counts of 5 degrees, which last for up to 30 samples, and a servo press that pauses for as long."""
    time = np.arange(4000) / 1000
    for angle in (np.radians(5.0) * np.floor(40 * time), 5.0 * time - 5.0 * np.clip(time - 2.0, 0.0, 0.03)):
        MeasuredRun(time, angle, 100.0 + np.sin(time))


def test_files_that_are_none(tmp_path):
    for name, content, words in (
        ("a.csv", "x,y\n1,2\n3,z\n", "a.csv, line 3, y: 'z' is no number"),
        ("b.csv", "1,2\n3,4\n", "the first line has numbers, no names"),
        ("c.csv", "x,y\n1,2\n3\n", "c.csv, line 3: 1 cells, the names are 2"),
        ("d.mat", "hello", "no MATLAB file"),
        ("e.parquet", "hello", "no Parquet file"),
        ("f.xls", "hello", "export it as one of these"),
        ("g.mf4", "hello", "no MDF4 file"),
    ):
        (tmp_path / name).write_text(content)
        with pytest.raises(pp.PinpressError, match=words):
            record(tmp_path / name, "x [rad]", "y [N m]")
    v73 = tmp_path / "h.mat"
    savemat(v73, {"x": TIME})
    v73.write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + bytes(400))
    with pytest.raises(pp.PinpressError, match=r"save.*-v7"):
        record(v73, "x [rad]")


def test_parts_and_currents():
    run = MeasuredRun(TIME, ANGLE, current=TORQUE / 3, shaking_force={"z": TORQUE}, added_mass={"slide": 200.0})
    part = run.between(0.5, 1.0)
    assert (part.time[0], part.torque, part.added_mass["slide"]) == (0.5, None, 200.0)
    assert len(part.shaking_force["z"]) == len(part.time) == 101
    assert run.strokes == pytest.approx((ANGLE[-1] - ANGLE[0]) / (2 * np.pi))
    with pytest.raises(pp.PinpressError, match="give only one of them"):
        MeasuredRun(TIME, ANGLE, TORQUE, TORQUE)


def test_pages_plots_and_texts_show_the_signals_of_a_record():
    run = MeasuredRun(TIME, ANGLE, TORQUE, shaking_force={"x": TORQUE, "z": 2 * TORQUE}, added_mass={"slide": 200.0})
    (section,) = run.described()
    charts = charts_of([section])
    assert list(charts) == ["torque", "shaking force", "angle"]
    assert [curve.name for curve in charts["shaking force"].curves] == ["shaking force x", "shaking force z"]
    np.testing.assert_array_equal(charts["torque"].curves[0].y, TORQUE)
    figures = {figure.name: figure.value for figure in section.figures}
    speeds = 7.0 + 0.8 * np.cos(2 * TIME)
    assert figures["highest speed"] == pytest.approx(speeds.max(), rel=1e-3)
    assert figures["lowest speed"] == pytest.approx(speeds.min(), rel=1e-3)
    assert figures["mass added to slide"] == 200.0
    (row,) = [line.split() for line in str(run).splitlines() if "torque [N m]" in line]
    assert [float(cell) for cell in row[3:]] == pytest.approx([TORQUE.min(), TORQUE.max()], abs=0.005)
