"""`pinpress vibration`: what it prints and writes is what the library gives; what it says of wrong words."""

import re

import numpy as np
import pytest
from support import hammer_hits
from support.refused_commands import refused

import pinpress as pp
from pinpress.cli.main import main
from pinpress.common import tables

JOB = """\
file: jf75g_125
foundation:
  frame: {mass: 15 t, centre: 0 100 -300 mm, inertia: 9000 8000 7000 kg m2}
  mounts:
    points: [-900 -700 -1300 mm, 900 -700 -1300 mm, -900 700 -1300 mm, 900 700 -1300 mm]
    pad: {length: 300 mm, width: 300 mm, thickness: 40 mm, hardness: 65, loss_factor: 0.1}
"""


@pytest.fixture
def files(tmp_path):
    """A record of three hits, and where its accelerometers sit."""
    tables.write_csv(tmp_path / "hits.csv", hammer_hits.columns())
    rows = [f"{name},{','.join(map(str, sensor.point))},{sensor.direction}" for name, sensor in hammer_hits.SENSORS.items()]
    (tmp_path / "job.yaml").write_text(JOB)
    (tmp_path / "points.csv").write_text("\n".join(["channel,x,y,z,direction", *rows]) + "\n")
    return [str(tmp_path / "hits.csv"), "--points", str(tmp_path / "points.csv")]


@pytest.mark.exhaustive
def test_modes_of_hits_and_the_mounts_that_fit_them(capsys, tmp_path, files):
    assert main(["measured", "vibration", *files, "--job", str(tmp_path / "job.yaml"), "--fit", "--out", str(tmp_path / "out")]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    system = hammer_hits.standing(65.0, 0.1)
    record = pp.measured.vibration(hammer_hits.columns(), hammer_hits.SENSORS)
    found = record.modes(beside=pp.foundation.modes(system))
    assert str(pp.measured.fit_mounts(system, found)) in out
    modes, noise = str(found).splitlines(), re.compile(r"  noise +\S+ %")  # fitted mounts change no mode, but the noise's last digits
    printed = [line for line in out.splitlines() if not noise.match(line)]
    assert all(row.split("±")[0] in {line.split("±")[0] for line in printed} for row in modes[2:] if not noise.match(row))
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        *("channels.csv", "modes.csv", "modes.png", "mounts.csv", "spectra.csv", "spectra.png"),
    ]


@pytest.mark.exhaustive
def test_modes_in_a_band_without_a_model(capsys, files):
    assert main(["measured", "vibration", *files, "--band", "3 50 Hz", "--count", "6"]) == 0
    out, _ = capsys.readouterr()
    assert "3        15 channels" in out
    assert "calculated" not in out


@pytest.mark.exhaustive
def test_orders_of_a_running_press(capsys, tmp_path):
    """Unbalance once a turn, while the press runs up."""
    time = np.arange(20_000) / 500
    speed = pp.RPM * (150 + 4 * time)
    angle = np.cumsum(speed) / 500
    tables.write_csv(tmp_path / "run.csv", {"time [s]": time, "top [m/s2]": np.sin(angle), "crank [deg]": np.degrees(angle) % 360})
    (tmp_path / "job.yaml").write_text(JOB)
    (tmp_path / "points.csv").write_text("channel,x,y,z,direction\ntop [m/s2],0.8,0.6,1.2,z\n")
    points, out_folder = ["--points", str(tmp_path / "points.csv")], tmp_path / "out"
    assert (
        main(
            [
                "measured",
                "vibration",
                str(tmp_path / "run.csv"),
                *points,
                "--angle",
                "crank [deg]",
                "--orders",
                "4",
                "--out",
                str(out_folder),
            ]
        )
        == 0
    )
    out, _ = capsys.readouterr()
    record = pp.measured.vibration(str(tmp_path / "run.csv"), tmp_path / "points.csv", angle="crank [deg]")
    assert str(record.order_spectra(4)) in out
    assert (out_folder / "orders.png").stat().st_size > 5000
    assert (out_folder / "orders.csv").read_text().count("\n") > 20


@pytest.mark.one_in(8)
@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "give --band '3 100 Hz', or --job with a foundation"),
        (["--band", "3 Hz"], "give the lowest and the highest frequency"),
        (["--speed", "200 r/min", "--band", "3 50 Hz"], "--band is for hits on a frame at rest"),
        (["--speed", "fast"], "is no row of numbers"),
        (["--band", "3 50 Hz", "--fit"], "--fit needs the mounts as described"),
        (["--band", "3 50 Hz", "--job", "jf75g_125"], "the job has no foundation"),
        (["--job", "jf75g_125", "--angle", "crank [deg]"], "is for hits on a frame at rest"),
        (["--band", "3 5000 Hz"], "are too few for 5000 Hz"),
    ],
)
def test_wrong_words(capsys, files, words, said):
    assert said in refused(capsys, "measured", "vibration", *files, *words)
