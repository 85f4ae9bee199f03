"""CSV files as spreadsheets and programs of all countries save them: the same cells from all."""

import gzip

import numpy as np
import pytest
from scipy.io import savemat
from support.texts import shipped

import pinpress as pp
from pinpress import measured
from pinpress.common.reading.columns import Wanted, read_channels, read_columns, split_head
from pinpress.measured.accelerometers import points_of

POINTS = "channel,x [mm],y [mm],z [mm],direction\ntop,0,100.5,1.5e3,z\nbed,0,0,-900,x\n"
RECORD = "time [s],crank [rad],motor [N m]\n" + "".join(f"{0.01 * k:.3f},{0.05 * k:.4f},{100 + k:.1f}\n" for k in range(40))
DIMENSIONS = "dimension, tolerance, unit\nlength E F, 0.05, mm\nangle C D E, 0.01, deg\n"
MOTORS = """motor,inertia [kg m2],copper loss [W/(N m)2],speed [r/min],rated torque [N m],peak torque [N m]
example 150,0.09,0.045,0,150,420
example 150,0.09,0.045,2000,130,420
"""


def accelerometers(file):
    signals = {"top [g]": np.sin(np.arange(256)), "bed [g]": np.cos(np.arange(256)), "t": np.arange(256) / 500}
    return {
        name: (each.point, each.direction, each.gain) for name, each in measured.vibration(signals, file, time="t").accelerometers.items()
    }


def columns(run):
    return run.time.tolist(), run.angle.tolist(), run.torque.tolist()


def dimensions(file):
    return pp.tolerances.read_dimensions(shipped("zxn2_3000b"), file)


def commas(text):
    """As saved where decimals stand after a comma."""
    return text.replace(",", ";").replace(".", ",")


SAVED = {
    "mark": lambda text: b"\xef\xbb\xbf" + text.encode(),
    "line ends of Windows": lambda text: text.replace("\n", "\r\n").encode(),
    "line ends of old Macs": lambda text: text.replace("\n", "\r").encode(),
    "empty lines": lambda text: text.replace("\n", "\n\n").encode(),
    "UTF-16": lambda text: text.encode("utf-16"),
    "tabs": lambda text: text.replace(",", "\t").encode(),
    "semicolons": lambda text: text.replace(",", ";").encode(),
    "decimal commas": lambda text: commas(text).encode(),
    "decimal commas and tabs": lambda text: commas(text).replace(";", "\t").encode(),
    "Unicode text of a spreadsheet": lambda text: commas(text).replace(";", "\t").encode("utf-16"),
}


@pytest.mark.parametrize("how", SAVED)
@pytest.mark.parametrize(
    ("text", "read"),
    [
        (POINTS, lambda file: accelerometers(file)),
        (RECORD, lambda file: columns(measured.record(file, "crank", "motor"))),
        (DIMENSIONS, lambda file: [(each.name, each.tolerance) for each in dimensions(file).parts]),
        (MOTORS, lambda file: [(each.name, each.inertia, each.speed, each.peak_torque) for each in pp.servo.read_motors(file)]),
    ],
)
def test_a_table_is_the_same_however_it_is_saved(tmp_path, how, text, read):
    plain, saved = tmp_path / "plain.csv", tmp_path / "Tabelle für die Presse.csv"
    plain.write_bytes(text.encode())
    saved.write_bytes(SAVED[how](text))
    assert read(saved) == read(plain)


def test_points_in_mm_are_points_in_m(tmp_path):
    file = tmp_path / "points.csv"
    file.write_text(POINTS, encoding="utf-8")
    read = accelerometers(file)
    np.testing.assert_allclose(read["top"][0], [0, 0.1005, 1.5], rtol=1e-15)
    file.write_text(POINTS.replace("direction", "direction,gain [m/s2 per V]").replace("z\n", "z,98.1\n"), encoding="utf-8")
    assert [each.gain for each in points_of(file).values()] == [98.1, None]
    for text, said in (
        (POINTS.replace("z [mm]", "z [kg]"), r"column 'z' is in 'kg', which is none of m, mm"),
        (POINTS.replace("direction", "direction,gain [mV/g]"), r"column 'gain' is in 'mV/g', which is none of m/s2 per V"),
        (POINTS.replace("bed", "top"), r"points\.csv, line 3: channel 'top' is there twice"),
    ):
        file.write_text(text, encoding="utf-8")
        with pytest.raises(pp.PinpressError, match=said):
            accelerometers(file)


def test_two_columns_of_one_name_are_refused(tmp_path):
    """The last one would be read."""
    file = tmp_path / "run.csv"
    file.write_text(RECORD.replace("\n", ",1\n").replace("motor [N m],1", "motor [N m],motor [N m]"), encoding="utf-8")
    with pytest.raises(pp.PinpressError, match=r"two columns are called 'motor \[N m\]': rename one"):
        measured.record(file, "crank", "motor")


def test_what_is_no_text_is_refused(tmp_path):
    file = tmp_path / "table.csv"
    for content in (b"\xff\xfea", b"\x89PNG\r\n\x1a\n\0\0"):
        file.write_bytes(content)
        with pytest.raises(pp.PinpressError, match=r"table\.csv is no text in UTF-8; save it in this encoding"):
            read_columns(file, {"x": Wanted("m")})
    file.write_bytes("Länge [µm]\n1\n".encode("latin-1"))
    np.testing.assert_allclose(read_columns(file, {"Länge": Wanted("m")}).values["Länge"], [1e-6], rtol=1e-15)


TABLE = "name, length [mm], force [kN], note\nA, 1, 2.5,\nB, -2, 1e3, long\n"
TABLE_OF = {"name": Wanted(), "length": Wanted("m"), "force": Wanted("N", names=("load",)), "gain": Wanted("-", bare="-", needed=False)}


@pytest.mark.parametrize(
    ("head", "factor"),
    [
        ("length [mm]", 1e-3),
        ("length (µm)", 1e-6),
        ("length [\u03bcm]", 1e-6),
        ("length [um]", 1e-6),
        ("length [m]", 1.0),
        ("length [in]", 0.0254),
    ],
)
def test_units_of_heads(tmp_path, head, factor):
    file = tmp_path / "table.csv"
    file.write_text(TABLE.replace("length [mm]", head).replace("force", "load"), encoding="utf-8")
    found = read_columns(file, TABLE_OF)
    np.testing.assert_allclose(found.values["length"], [factor, -2 * factor], rtol=1e-15)
    np.testing.assert_allclose(found.values["force"], [2500.0, 1e6])
    assert found.values["name"] == ["A", "B"]
    assert list(found.lines) == [2, 3]
    assert "gain" not in found.values
    assert split_head("force [kN] ") == ("force", "kN")


def test_units_in_a_line_below_the_names(tmp_path):
    file = tmp_path / "table.csv"
    file.write_text("name,length,force\n-,mm,kN\nA,1,2.5\nB,-2,1e3\n", encoding="utf-8")
    found = read_columns(file, TABLE_OF)
    np.testing.assert_allclose(found.values["length"], [1e-3, -2e-3], rtol=1e-15)
    assert found.values["name"] == ["A", "B"]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("length [mm]", "lenght [mm]", r"no column 'length \[mm\]'; column 'lenght' is unknown, did you mean 'length'"),
        ("length [mm]", "length", r"column 'length' has no unit: write e\.g\. 'length \[mm\]'"),
        ("length [mm]", "length [kg]", r"column 'length' is in 'kg', which is none of m, mm"),
        ("-2", "two", r"table\.csv, line 3, length: 'two' is no number; give a number, or leave out the row"),
        ("-2", "", r"table\.csv, line 3, length: '' is no number"),
        ("-2", '"2,5"', r"line 3, length: '2,5' is no number; write decimals after a point"),
        ("long", "long,1,2", r"line 3: 6 cells for 4 columns: write decimals after a point"),
        ("note", "length", r"two columns are called 'length': rename one"),
        (TABLE, "", r"is empty: give a CSV file with the heads name, length \[mm\], force \[N\] and, if wanted, gain"),
    ],
)
def test_messages_name_line_column_and_remedy(tmp_path, old, new, words):
    file = tmp_path / "table.csv"
    file.write_text(TABLE.replace(old, new), encoding="utf-8")
    with pytest.raises(pp.PinpressError, match=words):
        read_columns(file, TABLE_OF)


def test_compressed_tables(tmp_path):
    """Read as what they are; one that is cut off is refused."""
    for text, name, read in (
        (MOTORS, "motors", pp.servo.read_motors),
        (POINTS, "points", accelerometers),
        (DIMENSIONS, "dimensions", dimensions),
    ):
        plain, packed = tmp_path / f"{name}.csv", tmp_path / f"{name}.csv.gz"
        plain.write_text(text, encoding="utf-8")
        packed.write_bytes(gzip.compress(text.encode()))
        assert str(read(packed)) == str(read(plain))
        packed.write_bytes(packed.read_bytes()[:-9])
        with pytest.raises(pp.PinpressError, match=rf"{name}\.csv\.gz cannot be read: what is compressed in it is not whole"):
            read(packed)


def test_other_formats(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    columns = {"name": ["A", "B"], "length [mm]": [1, -2], "load [kN]": [2.5, 1e3]}
    parquet.write_table(pyarrow.table(columns), tmp_path / "table.parquet")
    found = read_columns(tmp_path / "table.parquet", TABLE_OF)
    assert found.values["name"] == ["A", "B"]
    np.testing.assert_allclose(found.values["length"], [1e-3, -2e-3])
    savemat(tmp_path / "table.mat", {"length": [1.0, 2.0], "force": [3.0, 4.0]})
    lengths = read_columns(tmp_path / "table.mat", {"length": Wanted("m", bare="mm"), "force": Wanted("N", bare="N")})
    np.testing.assert_allclose(lengths.values["length"], [1e-3, 2e-3])
    assert list(lengths.lines) == [1, 2]
    with pytest.raises(pp.PinpressError, match=r"table\.mat: column 'length' has no unit"):
        read_columns(tmp_path / "table.mat", {"length": Wanted("m")})


def test_columns_by_their_order(tmp_path):
    file, both = tmp_path / "table.csv", {"height": Wanted("m", bare="m"), "force": Wanted("N", bare="N")}
    for text, expected in (("0,1\n0.5,2\n", 0.5), ("h,F\n0,1\n0.5,2\n", 0.5), ("h [mm],F\n0,1\n500,2\n", 0.5)):
        file.write_text(text, encoding="utf-8")
        found = read_columns(file, both, by_order=True)
        np.testing.assert_allclose(found.values["height"], [0.0, expected])
    file.write_text("0,1\n1,2,3\n", encoding="utf-8")
    with pytest.raises(pp.PinpressError, match="line 2: 3 cells for 2 columns"):
        read_columns(file, both, by_order=True)


def test_a_record_may_have_words_in_columns_that_nobody_wants(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text("% of a drive\ntime [s],state,crank [rad]\n0,run,0.1\n1,run,0.2\n", encoding="utf-8")
    table = read_channels(file, ["crank [rad]"])
    assert list(table.columns) == ["time", "crank"]
    file.write_text("time [s],state,crank [rad]\n0,run,0.1\n1,run,x\n", encoding="utf-8")
    with pytest.raises(pp.PinpressError, match=r"run\.csv, line 3, crank: 'x' is no number"):
        read_channels(file, ["crank [rad]"])
