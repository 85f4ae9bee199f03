"""CSV files as spreadsheets and programs of all countries save them: the same cells from all."""

import numpy as np
import pytest
from support.texts import shipped

import pinpress as pp
from pinpress import measured
from pinpress.common.reading.cells import factor_to, parted, read_rows

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
    for text, said in (
        (POINTS.replace("z [mm]", "z [kg]"), r"'kg' in 'z \[kg\]' is none of m, mm"),
        (POINTS.replace("bed", "top"), "points.csv:3: channel 'top' is there twice"),
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
    file.write_bytes("Länge\n1\n".encode("latin-1"))
    with pytest.raises(ValueError, match="no text in UTF-8; save it in this encoding"):
        read_rows(file, 1000)
    file.write_bytes(b"\xff\xfea")
    with pytest.raises(ValueError, match="no text in UTF-8"):
        read_rows(file, 1000)
    file.write_bytes(b"")
    assert read_rows(file, 1000) == []


def test_units_of_heads():
    assert factor_to("m", "x") == factor_to("m", "x [m]") == 1.0
    assert factor_to("m", "x (mm)") == 1e-3
    assert factor_to("N", "force [kN] ") == 1e3
    assert parted("force [kN] ") == ("force", "kN")
