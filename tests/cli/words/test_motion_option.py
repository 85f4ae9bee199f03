"""`--motion`: commands move a press with several drivers, or with one, as a table says, and say what the library gives."""

from pathlib import Path

import numpy as np
import pytest
from support import texts
from support.generators.period_presses import of_two_motors
from support.in_browser import data_in
from support.presses.two_servos import TWO_SERVOS
from support.refused_commands import refused

import pinpress as pp
from pinpress.cli.main import main
from pinpress.common.quantities import quantity
from pinpress.dynamics.extremes import at_peaks

TIME = np.arange(72) / 72
ANGLES = np.column_stack([360 * TIME, -360 * TIME + 15 * np.sin(2 * np.pi * TIME)])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("press.yaml").write_text(TWO_SERVOS, encoding="utf-8")
    np.savetxt("motion.csv", np.column_stack([TIME, ANGLES]), delimiter=",", header="time [s],A [deg],B [deg]", comments="", fmt="%.17g")
    return tmp_path


def wanted() -> tuple[pp.Linkage, pp.Motion]:
    press = pp.build("press.yaml")
    return press, pp.servo_cycle(press, np.radians(ANGLES), time=TIME, period=1.0)


MOTION = ["press.yaml", "--motion", "motion.csv", "--period", "1"]


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(list(arguments)) == 0
    return capsys.readouterr().out


def test_build(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "build", "press.yaml")
    assert "2 drivers move the slide" in text
    assert "C   (0, -503.673)   (0, 421.588)    2 drivers move the slide" in text  # what another side would give
    assert pp.load("press.urdf").drivers == ("A", "B")


def test_analyse(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "analyse", *MOTION, "--load", "drawing:force=200kN,start=20mm,datum=-975mm", "--out", "out", "--report")
    press, motion = wanted()
    load = pp.loads.DeepDrawing(2e5, 0.02, datum=-0.975)
    reactions = pp.inverse_dynamics(press, motion, loads=[load])
    low = int(motion.slide_position.argmin())
    lowest = next(line for line in text.splitlines() if line.startswith("  lowest position"))
    assert lowest.split()[2:] == [f"{1e3 * motion.slide_position[low]:.3f}", "mm", "at", f"{TIME[low]:.5f}", "s,", "0.000", "mm"]
    for k, driver in enumerate("AB"):
        torque = reactions.driving_torque[:, k]
        at = int(torque.argmax())
        lines = text[text.index(f"  largest torque of {driver} ") :].splitlines()
        assert float(lines[0].split()[4]) == pytest.approx(torque[at], rel=1e-4)
        assert f"at {TIME[at]:.5f} s" in lines[0]
    size = np.linalg.norm(reactions.bearing_force["S"], axis=1)
    row = next(line for line in text.splitlines() if line.startswith("  S "))
    assert quantity("s").scale(TIME, digits=5).shown(TIME[size.argmax()]) in row.split()
    assert "motion        prescribed, A at up to 60 r/min, B at up to " in text
    work = next(line.split() for line in text.splitlines() if line.startswith("  work of the process "))
    assert work[4:] == [*quantity("J").text(reactions.process_work, 5).split(), "over", "the", "motion"]
    again = pp.read_motion(press, "out/cycle.csv")
    np.testing.assert_array_equal(again.slide_position, motion.slide_position)
    data = data_in(Path("out/report.html"))
    titles = [chart["title"] for section in data["report"]["sections"] for chart in section["blocks"] if "title" in chart]
    assert "Driving torque" in titles
    assert data["time"][-1:] != TIME[-1:]  # closed to a loop


def test_record(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A picture may be of any instant of the closed motion, that after its last row too."""
    assert printed(capsys, "record", *MOTION, "--out", "press.html", "--at", "0.995s") == "wrote press.html\n"
    for place in ("2s", "90deg"):
        error = refused(capsys, "record", *MOTION, "--out", "press.html", "--at", place)
        assert f"--at {place}: with --motion give a time from its first state, from 0 to 1 s" in error


def test_balance(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--region", "crank_1:radius=0.2", "--region", "crank_2:radius=0.2", "--minimise", "range:shaking_force:z"]
    text = printed(capsys, "balance", *MOTION, *words)
    press, motion = wanted()
    regions = [pp.balancing.CounterweightRegion(f"crank_{k}", radius=0.2) for k in (1, 2)]
    best = pp.balancing.balance(press, motion, regions=regions, minimise=pp.balancing.Range("shaking_force", "z"))
    assert str(best) in text
    lighter = pp.inverse_dynamics(best.press, motion).shaking_force[:, 2]
    assert np.ptp(lighter) == pytest.approx(best.value, rel=1e-9)
    assert np.ptp(lighter) < np.ptp(pp.inverse_dynamics(press, motion).shaking_force[:, 2])


def test_tolerances(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("d.csv").write_text("dimension,tolerance,unit\nlength D S,0.05,mm\n", encoding="utf-8")
    words = ["--dimensions", "d.csv", "--samples", "1000"]
    text = printed(capsys, "tolerances", *MOTION, *words)
    assert "DeadCentreScatter of two_servos: 1 dimensions, 1000 presses" in text
    assert "motion        motion.csv" in text
    assert "without a motion they have no dead centre; give --motion FILE" in refused(capsys, "tolerances", "press.yaml", *words)
    assert "--budget is for a crank" in refused(capsys, "tolerances", *MOTION, *words, "--budget", "10,70")


def test_report(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stiff = ["--stiffness", "A=1e9", "--stiffness", "B=1e9"]
    assert printed(capsys, "report", *MOTION, *stiff, "--out", "r.html") == "wrote r.html\n"
    press, motion = wanted()
    deflected = pp.elasticity.slide_deflection(press, motion, pp.elasticity.Stiffness(bearings={"A": 1e9, "B": 1e9}))
    assert deflected.deflection.max() < 0


def test_ratings(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--nominal-force", "300kN", "--torque", "A=9kNm", "--torque", "B=1e4", "--bearing", "S=290kN"]
    words += ["--friction", "A:coefficient=0.05,radius=60mm"]
    text = printed(capsys, "ratings", *MOTION, *words, "--load", "drawing:force=100kN,start=20mm,datum=-975mm", "--out", "out")
    press, motion = wanted()
    given = pp.ratings.Capacities(3e5, drivers={"A": 9e3, "B": 1e4}, bearings={"S": 2.9e5})
    found = pp.ratings.rate_motion(press, motion, given, friction={"A": pp.loads.Friction(0.05, radius=0.06)})
    assert str(found) in text
    assert ["torque", "B", "10", "kN", "m"] in [line.split() for line in text.splitlines()]
    process = pp.inverse_dynamics(press, motion, loads=[pp.loads.DeepDrawing(1e5, 0.02, datum=-0.975)])
    assert f"of the permissible force {quantity('share').text(found.utilisation(process).max(), 5):>15}" in text
    assert Path("out/ratings.csv").read_text(encoding="utf-8").startswith("time [s],crank_angle_A [rad],crank_angle_B [rad],")
    assert printed(capsys, "report", *MOTION, *words, "--load", "drawing:force=100kN,start=20mm,datum=-975mm", "--out", "r.html")
    data = data_in(Path("r.html"))
    (section,) = [each for each in data["report"]["sections"] if each["title"] == "Ratings"]
    assert section["blocks"][0]["figures"][1]["value"] == f"{100 * found.utilisation(process).max():.5g} %"
    assert ["bearing S", "290 kN"] in data["report"]["inputs"][0]["rows"]
    limit = ["ratings", *MOTION, "--nominal-force", "300kN"]
    assert "write e.g. --torque A=5e3" in refused(capsys, *limit, "--torque", "9e3")
    assert "--nominal-height is for a press at constant speed" in refused(capsys, *limit, "--nominal-height", "3mm")
    assert "give --motion FILE" in refused(capsys, "ratings", "press.yaml", "--speed", "30", "--nominal-force", "300kN")


def test_report_on_mounts(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    corners = [f"{x}/{y}/-1.3" for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    stands = ["--frame", "mass=6t,centre=0/0/-0.5,inertia=2500/2200/1500"]
    stands += [word for corner in corners for word in ("--mount", f"point={corner},stiffness=2e6/2e6/4e6,damping=5e3/5e3/2e4")]
    words = [*stands, "--lift-off", "2", "--modes", "m.html", "--out", "r.html"]
    assert printed(capsys, "report", *MOTION, *words) == "wrote r.html and m.html\n"
    (section,) = [each for each in data_in(Path("r.html"))["report"]["sections"] if each["title"] == "Vibration on the mounts"]
    shown = {figure["name"]: figure["value"] for figure in section["blocks"][0]["figures"]}
    press, motion = wanted()
    places = [tuple(map(float, corner.split("/"))) for corner in corners]
    mounts = [pp.foundation.Mount(place, (2e6, 2e6, 4e6), (5e3, 5e3, 2e4)) for place in places]
    system = pp.foundation.mounted(press, pp.foundation.Frame(6e3, (0, 0, -0.5), (2500, 2200, 1500)), mounts, motion=motion)
    found = pp.foundation.steady_response(system, pp.inverse_dynamics(press, motion), points={}, period=1.0)
    value, unit = shown["least load on a mount"].split()
    assert float(value) * {"N": 1.0, "kN": 1e3}[unit] == pytest.approx(found.least_load.min(), rel=1e-3)
    assert printed(capsys, "report", "press.yaml", "--motion", "motion.csv", *stands, "--out", "r.html") == "wrote r.html\n"  # from rest
    assert "one speed does not say how they move" in refused(capsys, "report", *MOTION, *words, "--speed-range", "10,20")


def test_one_driver(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The crank swings to and fro; nothing is said of strokes a minute."""
    time = np.linspace(0.0, 1.0, 61)
    path = tmp_path / "m.csv"
    swing = 40 + 30 * np.sin(2 * np.pi * time)
    np.savetxt(path, np.column_stack([time, swing]), delimiter=",", header="time [s],A [deg]", comments="")
    text = printed(capsys, "analyse", "zxn2_3000b", "--motion", str(path), "--period", "1")
    assert "  1 s, 61 states" in text or "states, engine" in text
    assert "strokes/min" not in text
    assert "heights are above bottom dead centre" in text
    press = texts.shipped("zxn2_3000b")
    motion = pp.servo_cycle(press, np.radians(swing), time=time, period=1.0)
    torque = at_peaks(pp.inverse_dynamics(press, motion)).reactions.driving_torque
    assert quantity("N m").text(torque.max(), 5) in text


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["analyse", "press.yaml", "--speed", "30"], "give --motion FILE, a table with the columns time [s], A [deg], B [deg]"),
        (["analyse", *MOTION, "--points", "90"], "leave it out, because --motion has its states"),
        (["analyse", *MOTION, "--flywheel", "3"], "--flywheel is for a press at constant speed: give --speed in place of --motion"),
        (["report", *MOTION, "--nominal-force", "3e6", "--nominal-height", "3mm", "--out", "r.html"], "--nominal-height is for a press at"),
        (["analyse", *MOTION, "--zero", "tdc"], "leave out --zero tdc"),
        (["analyse", "zxn2_3000b", "--speed", "70", "--period", "1"], "--period is for --motion"),
        (["servo", "press.yaml", "--time", "1", "--drive", "inertia=1,ratio=6,peak_torque=2"], "the best motion needs one crank"),
    ],
)
def test_wrong_words(arguments: list[str], says: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert says in refused(capsys, *arguments)


def test_drivers_that_the_file_does_not_name(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = of_two_motors().text.decode()
    for transmission in (
        '<transmission name="drive"><joint name="O"/></transmission>',
        '<transmission name="other"><joint name="P"/></transmission>',
    ):
        assert robot.count(transmission) == 1
        robot = robot.replace(transmission, "")
    Path("robot.urdf").write_text(robot, encoding="utf-8")
    np.savetxt("robot.csv", np.column_stack([TIME, 9 * TIME**2, 0 * TIME]), delimiter=",", header="time [s],P [deg],O [deg]", comments="")
    text = printed(capsys, "analyse", "robot.urdf", "--driver", "P", "--driver", "O", "--motion", "robot.csv")
    assert "driven at joints P, O" in text
    assert "following the assembly" not in text


def test_an_unknown_driver_is_found_by_its_column(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("motors.urdf").write_bytes(of_two_motors().text)
    error = refused(capsys, "analyse", "motors.urdf", "--motion", "motion.csv")
    assert "motion.csv has no column for driver 'O' of geared_five_bar: call it O [deg]; there are: time, A, B" in error


def test_record_of_a_swing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One crank that swings comes back to its first state too, at the end of the period."""
    path, page = tmp_path / "m.csv", tmp_path / "press.html"
    time = np.arange(60) / 60
    swing = 40 + 30 * np.sin(2 * np.pi * time)
    np.savetxt(path, np.column_stack([time, swing]), delimiter=",", header="time [s],A [deg]", comments="")
    words = ["record", "zxn2_3000b", "--motion", str(path), "--period", "1", "--out", str(page), "--at"]
    assert printed(capsys, *words, "0.995") == f"wrote {page}\n"
    assert "from 0 to 1 s" in refused(capsys, *words, "1.01")
    data = data_in(page)
    assert (data["time"][-1], data["crank"][-1]) == pytest.approx((1.0, 40.0))
    assert len(data["time"]) == 61
