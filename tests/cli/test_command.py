"""The command line, run as a user runs it."""

import csv
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support import texts
from support.in_browser import data_in

import pinpress as pp
from pinpress.cli.main import _parser, main
from pinpress.dynamics.extremes import at_peaks

ROOT = Path(__file__).resolve().parents[2]


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "pinpress", *map(str, arguments)], capture_output=True, text=True, cwd=ROOT, timeout=60)


COMMANDS = "report analyse simulate balance servo ratings tolerances sweep identify force vibration record view accuracy"


@pytest.mark.parametrize("command", COMMANDS.split())
def test_the_examples_of_a_commands_help_are_read(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The parser knows all options of the commands that stand behind "e.g.", the later lines of which are indented."""
    with pytest.raises(SystemExit):
        main([command, "--help"])
    first = re.split(r"\n(?!     )", capsys.readouterr().out.partition("e.g. pinpress ")[2])[0]
    for example in first.split("\n     pinpress "):
        name, *words = shlex.split(example)
        assert name == command
        assert _parser().parse_args([name, *words]).run


def test_analyse_prints_a_summary_and_writes_both_files(tmp_path: Path) -> None:
    out = tmp_path / "made" / "out"
    done = run("analyse", "urdf/zxn2_3000b.urdf", "--speed", 70, "--out", out)
    assert (done.returncode, done.stderr) == (0, "")
    for line in (
        "  stroke                         301.261 mm",
        "  70 strokes/min, A turns counter-clockwise at 70 r/min",
        "  top dead centre                155.497 deg    at 0.370231 s",
        "  bottom dead centre             334.525 deg    at 0.796488 s",
        "  as drawn (0 deg)                 1.612 mm",
        "  working stroke                  49.730 %      of the time, 0.426257 s, down",
        "  fastest, working stroke         1.4697 m/s    at 209.977 deg, 178.758 mm",
        "  largest power                   140.24 kW     at 73.420 deg",
    ):
        assert line in done.stdout
    for word in (
        "largest torque",
        "rms torque",
        "range of shaking force",
        "largest loop gap",
        "largest power residual",
        "time taken",
        "slide_guide",
    ):
        assert word in done.stdout
    with (out / "cycle.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert header[:2] == ["time [s]", "crank_angle [rad]"]
    assert len(rows) == 720
    press = texts.shipped("zxn2_3000b")
    motion = pp.cycle(press, speed=70 * pp.RPM, points=720)
    result = pp.inverse_dynamics(press, motion)
    table = np.array(rows, dtype=float)
    for name, values in {
        "slide_position [m]": motion.slide_position,
        "driving_torque [N m]": result.driving_torque,
        "force_slide_guide_x [N]": result.bearing_force["slide_guide"][:, 0],
        "moment_A_y [N m]": result.bearing_moment["A"][:, 1],
    }.items():
        np.testing.assert_array_equal(table[:, header.index(name)], values)
    page = (out / "recording.html").read_text(encoding="utf-8")
    assert 300_000 < len(page) < 600_000
    assert 'type="range"' in page


def test_report_of_two_presses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    words = ["analyse", "zxn2_3000b_balanced", "--speed", "70", "--points", "90", "--out", str(out), "--report", "--before", "zxn2_3000b"]
    assert main([*words, "--trace", "coupler:0.6,0,0.1"]) == 0
    assert {path.name for path in out.iterdir()} == {"cycle.csv", "recording.html", "report.html"}
    assert f"wrote {out / 'cycle.csv'}, {out / 'recording.html'} and {out / 'report.html'}" in capsys.readouterr().out
    data = data_in(out / "report.html")
    assert [trace["name"] for trace in data["traces"]] == ["slide", "coupler (0.6, 0, 0.1)"]
    assert "dashed: zxn2_3000b" in data["report"]["subtitle"]
    assert data["peak"] == pytest.approx(209375, rel=1e-3)  # N, in D


def test_summary_peaks(capsys: pytest.CaptureFixture[str]) -> None:
    """Peaks of the summary against the quantities themselves, in the words around them."""
    assert main(["analyse", "crank_slide", "--speed", "60", "--points", "120", "--engine", "pinocchio"]) == 0
    text = capsys.readouterr().out
    press = texts.shipped("crank_slide")
    given = pp.inverse_dynamics(press, pp.cycle(press, speed=60 * pp.RPM, points=120, engine="pinocchio"), engine="pinocchio")
    result = at_peaks(given).reactions
    angle = np.degrees(result.motion.crank_angle)
    assert "engine 'pinocchio'" in text
    assert f"{'  stroke':28}{200:12.3f} mm" in text
    torque = result.driving_torque
    assert f"{'  largest torque':28}{torque.max():12.2f} N m    at {angle[torque.argmax()]:.3f} deg" in text
    assert torque.max() == pytest.approx(given.driving_torque.max(), rel=1e-3)
    fastest, at = -result.motion.slide_velocity.min(), int(result.motion.slide_velocity.argmin())
    height = 1e3 * (result.motion.slide_position[at] - pp.dead_centres(press).bottom_position)
    assert f"{'  fastest, working stroke':28}{fastest:12.5f} m/s    at {angle[at]:.3f} deg, {height:.3f} mm" in text
    for name, force in result.bearing_force.items():
        size = np.linalg.norm(force, axis=1)
        row = next(line for line in text.splitlines() if line.startswith(f"  {name} "))
        assert row.split()[1:3] == [f"{size.max():.1f}", f"{angle[size.argmax()]:.3f}"]
    body = text[text.index("  Bearings (") :].split("\n\n")[0]
    assert [line.split()[0] for line in body.split("\n")[2:]] == ["O", "P", "slide_guide", "W"]  # as drawn, the loop where it closes
    assert "to rounding" in text


def test_rounding_is_no_number(capsys: pytest.CaptureFixture[str]) -> None:
    """The guide of a symmetric press carries nothing: neither a force nor a crank angle is printed."""
    assert main(["analyse", "jf75g_125_symmetric", "--speed", "70"]) == 0
    row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("  slide_guide "))
    assert row.split() == ["slide_guide", "0", "-", "-", "0", "0", "0"]


def test_backwards_and_without_slide(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["analyse", "zxn2_3000b", "--speed", "-70"]) == 0
    text = capsys.readouterr().out
    assert "A turns clockwise at 70 r/min" in text
    assert "  bottom dead centre             334.525 deg    at 0.060655 s\n" in text
    assert "  working stroke                  50.270 %      of the time, 0.430886 s, down" in text
    assert not list(tmp_path.iterdir())


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["missing.urdf", "--speed", "70"], "missing.urdf"),
        (["zxn2", "--speed", "70"], "zxn2_3000b"),
        (["zxn2_3000b", "--speed", "0"], "speed is 0"),
        (["zxn2_3000b", "--speed", "nan"], "speed is not finite"),
        (["zxn2_3000b", "--speed", "70", "--points", "1"], "points is 1"),
        (["zxn2_3000b", "--speed", "70", "--driver", "Q"], "no moving joint 'Q'"),
        (["zxn2_3000b", "--speed", "70", "--slide", "rod"], "'rod' is not guided"),
        (["zxn2_3000b", "--speed", "70", "--out", "README.md"], "README.md"),
        (["zxn2_3000b", "--speed", "70", "--report"], "--report needs a folder to write into: also give --out DIR"),
        (["zxn2_3000b", "--speed", "70", "--trace", "rod:0,0,0"], "--trace needs a folder to write into"),
        (["zxn2_3000b", "--speed", "70", "--out", "nowhere", "--trace", "rodd:0,0,0"], "no link 'rodd', did you mean 'rod'?"),
        (["zxn2_3000b", "--speed", "70", "--before", "zxn2_3000b_balanced"], "also give --report"),
    ],
)
def test_error_is_one_line_and_exit_code_2(
    arguments: list[str], says: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    assert main(["analyse", *arguments]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.startswith("pinpress: ")
    assert error.count("\n") == 1
    assert not (ROOT / "nowhere").exists()


@pytest.mark.parametrize("arguments", [[], ["analyse"], ["analyse", "zxn2_3000b", "--speed", "fast"], ["analyze", "zxn2_3000b"]])
def test_usage_errors_exit_with_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """As the process of `test_check.test_wrong_usage_is_the_status_of_the_process` does."""
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err


def test_help_names_units_and_presses(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match=r"^0$"):
        main(["analyse", "--help"])
    shown = capsys.readouterr().out
    for word in ("r/min", "zxn2_3000b", "cycle.csv", "recording.html", "report.html", "--points", "world axes"):
        assert word in shown


def test_installed_command() -> None:
    """The script that pip puts on the path is the same command."""
    command = Path(sys.executable).with_name("pinpress")
    done = subprocess.run([command, "--help"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    assert "analyse" in done.stdout
    assert "check" in done.stdout
