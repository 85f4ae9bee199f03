"""Springs, dampers and clearances of the command line are those of Python, and what is wrong with them is said by the option's name."""

from typing import Any

import numpy as np
import pytest

import pinpress as pp
from pinpress.cli import simulate
from pinpress.cli.main import main
from pinpress.common.quantities import quantity

RUN = ["simulate", "crank_slide", "--speed", "60", "--duration", "0.02", "--motor", "prescribed:speed=60"]
SPRINGS = ["--stiffness", "all=50MN/m", "--stiffness", "P=6e7", "--moment-stiffness", "slide_guide=1e6"]
OTHER = "damping_ratio=3%,shaft=100kNm/rad,frame=1e8,crown_mass=0.5t"


def test_every_word_reaches_the_simulation(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    """The summary, the page's inputs and the table are those of the run in Python."""
    runs: list[pp.ElasticRun] = []

    def spy(*args: Any, **kwargs: Any) -> Any:
        assert kwargs["tolerance"] is None
        runs.append(pp.simulate(*args, **kwargs))
        return runs[-1]

    monkeypatch.setattr(simulate, "simulate", spy)
    words = ["--elastic", OTHER, "--clearance", "P:radial=20um", "--points", "12", "--out", str(tmp_path)]
    assert main([*RUN, *SPRINGS, *words]) == 0
    (run,), (text, _) = runs, capsys.readouterr()
    stiffness = run.elastic.stiffness
    assert dict(stiffness.bearings) == {"O": 5e7, "P": 6e7, "slide_guide": 5e7, "W": 5e7}
    assert dict(stiffness.moments) == {"slide_guide": 1e6}
    assert (stiffness.shaft, stiffness.frame, run.elastic.crown_mass, run.elastic.damping_ratio) == (1e5, 1e8, 500.0, 0.03)
    assert run.elastic.clearances["P"].radial == pytest.approx(20e-6)
    lowest = 1e3 * (run.deepest - pp.dead_centres(pp.load("crank_slide")).bottom_position)
    assert quantity("m").text(1e-3 * lowest, 5) in text
    assert "20 µm radial, contact law 'linear'" in text
    assert quantity("N").scale(run.peaks.values(), digits=5).shown(run.peaks["O"]) in text
    header = (tmp_path / "simulation.csv").read_text(encoding="utf-8").partition("\n")[0]
    assert "force_P [N]" in header


JOINTS = ["--preloaded-joint", "frame:loaded=20MN/m,relieved=80MN/m,preload=40kN"]
JOINTS += ["--preloaded-joint", "slide_guide:loaded=3e7,relieved=3e7,preload=2kN"]


def test_preloaded_joints_are_those_of_python(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Tie rods and gibs stand for columns and guide; the inputs name both."""
    runs: list[pp.ElasticRun] = []

    def spy(*args: Any, **kwargs: Any) -> Any:
        runs.append(pp.simulate(*args, **kwargs))
        return runs[-1]

    monkeypatch.setattr(simulate, "simulate", spy)
    assert main([*RUN, *SPRINGS, *JOINTS, "--elastic", "crown_mass=0.5t", "--points", "12"]) == 0
    (run,), out = runs, capsys.readouterr().out
    rods = pp.elasticity.PreloadedJoint(loaded=2e7, relieved=8e7, preload=4e4)
    gibs = pp.elasticity.PreloadedJoint(loaded=3e7, relieved=3e7, preload=2e3)
    assert run.elastic.stiffness.frame == rods
    assert dict(run.elastic.stiffness.bearings) == {"O": 5e7, "P": 6e7, "slide_guide": gibs, "W": 5e7}
    assert set(run.joint_load) == {"frame", "slide_guide"}
    assert "slide_guide: 30 kN/mm and 30 kN/mm, preloaded by 2000 N" in out
    assert "preloaded by 40 kN" in out


FRAME = ["--frame", "mass=2t,centre=0/0/0.3,inertia=400/500/300"]
MOUNT = ["--mount", "point=0.4/0/-0.8,stiffness=4MN/m/4MN/m/9MN/m,damping=4e4/4e4/8e4"]
OTHER_MOUNT = ["--mount", MOUNT[1].replace("0.4", "-0.4")]


def test_the_frame_on_its_mounts(capsys: pytest.CaptureFixture[str]) -> None:
    """The summary has what the run in Python has of floor and frame, and the inputs name both."""
    assert main([*RUN, *SPRINGS, *FRAME, *MOUNT, *OTHER_MOUNT, "--points", "12"]) == 0
    bearings = {"O": 5e7, "P": 6e7, "slide_guide": 5e7, "W": 5e7}
    mounts = [pp.foundation.Mount((x, 0.0, -0.8), (4e6, 4e6, 9e6), (4e4, 4e4, 8e4)) for x in (0.4, -0.4)]
    frame = pp.foundation.Frame(2000.0, (0.0, 0.0, 0.3), (400.0, 500.0, 300.0))
    stiffness = pp.elasticity.Stiffness(bearings, moments={"slide_guide": 1e6})
    elastic = pp.elasticity.Elastic(stiffness, mounted_frame=frame, mounts=mounts)
    speed, press = 60 * pp.RPM, pp.load("crank_slide")
    run = pp.simulate(press, 0.02, speed=speed, drive=pp.drives.PrescribedSpeed(speed), elastic=elastic, points=12)
    assert run.floor_force is not None
    assert run.frame_motion is not None
    floor, moved = (np.linalg.norm(each, axis=1).max() for each in (run.floor_force, run.frame_motion[:, :2]))
    out = capsys.readouterr().out
    rows = {line[:25].strip(): line.split() for line in out.splitlines() if line.startswith("  ")}
    assert rows["force on the floor"][4:6] == quantity("N").text(floor, 5).split()
    assert " ".join(rows["frame on its mounts"][4:6]) == quantity("m").text(moved, 5)
    assert "Frame(mass=2000 kg" in out
    assert "2 at (0.4, 0, -0.8), (-0.4, 0, -0.8) m: 4 / 4 / 9 kN/mm along x, y, z, damping 40 / 40 / 80 kN s/m" in out


FILE = """\
frame: {mass: 2 t, centre: [0, 0, 0.3], inertia: [400, 500, 300]}
mounts: [{points: [[0.4, 0.1, -0.8], [-0.4, 0.1, -0.8], [0, -0.3, -0.8]], stiffness: [4 MN/m, 4 MN/m, 9 MN/m]}]
"""


def test_a_frame_file_is_what_the_words_are(capsys: pytest.CaptureFixture[str], tmp_path: Any) -> None:
    path = tmp_path / "frame.yaml"
    path.write_text(FILE)
    mounts = [f"point={place},stiffness=4MN/m/4MN/m/9MN/m" for place in ("0.4/0.1/-0.8", "-0.4/0.1/-0.8", "0/-0.3/-0.8")]
    shown = []
    for words in (["--frame", str(path)], [*FRAME, *(word for each in mounts for word in ("--mount", each))]):
        assert main([*RUN, *SPRINGS, *words, "--points", "12"]) == 0
        shown.append([line for line in capsys.readouterr().out.splitlines() if "time taken" not in line])
    assert shown[0] == shown[1]
    path.write_text(FILE + "rotors: [{inertia: 3, axis: [0, 1, 0]}]\n")
    assert main([*RUN, *SPRINGS, "--frame", str(path)]) == 2
    assert f"stands on one rigid frame: leave out rotors of {path}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--clearance", "P:radial=0.1mm"], "--clearance is for a press on springs: also give --stiffness of its bearings"),
        (["--moment-stiffness", "all=1e6"], "--moment-stiffness is for a press on springs"),
        (["--elastic", "damping_ratio=0.02"], "--elastic is for a press on springs"),
        (["--stiffness", "P=1e8"], "--stiffness lacks 'O', 'slide_guide', 'W'"),
        (["--stiffness", "all=1e8"], "--moment-stiffness lacks 'slide_guide'"),
        (["--stiffness", "Q=1e8"], "no bearing 'Q'"),
        (["--stiffness", "all=1e8N/m2"], "write e.g. --stiffness A=2e9"),
        ([*SPRINGS, "--moment-stiffness", "P=1e6"], "no bearing 'P'"),
        ([*SPRINGS, "--elastic", "damping=0.02"], "no key 'damping'"),
        ([*SPRINGS, "--elastic", "damping_ratio=2.5"], "give a number from 0 to 2"),
        ([*SPRINGS, "--elastic", "frame=1e9"], "--elastic frame=1e9: Elastic: a crown on its columns needs both"),
        ([*SPRINGS, "--clearance", "0.1mm"], "it names no pin; write e.g. --clearance W:radial=0.1mm"),
        ([*SPRINGS, "--clearance", "Q:radial=0.1mm"], "no bearing 'Q'"),
        ([*SPRINGS, "--clearance", "P:radial=0.1mm", "--clearance", "P:radial=0.2mm"], "--clearance P:radial=0.2mm: P is given twice"),
        ([*SPRINGS, "--clearance", "P:radial=100"], "give the radial clearance in m"),
        ([*SPRINGS, "--clearance", "P:radial=0.1mm,law=hertz"], "restitution belongs to the law 'hertz': give it"),
        (["--preloaded-joint", JOINTS[1]], "--preloaded-joint is for a press on springs"),
        ([*SPRINGS, "--preloaded-joint", "P:loaded=1e9,relieved=1e9,preload=1e4"], "which a guide has across its axis alone"),
        ([*SPRINGS, "--preloaded-joint", "slide_guide:loaded=1e9,relieved=2e9,preload=1e4"], "both gibs of a guide are alike"),
        ([*SPRINGS, "--preloaded-joint", "slide_guide:loaded=1e9,relieved=1e9"], "preload is missing"),
        ([*SPRINGS, "--preloaded-joint", "loaded=1e9"], "it names neither a guide nor the frame; write e.g. --preloaded-joint frame:"),
        ([*SPRINGS, *JOINTS, "--elastic", OTHER], "--preloaded-joint frame also describes the columns: leave out one of them"),
        ([*SPRINGS, *JOINTS], "a crown on its columns needs both"),
        ([*FRAME, *MOUNT], "--frame is for a press on springs"),
        ([*SPRINGS, *FRAME], "a press on its mounts needs --frame and --mount"),
        ([*SPRINGS, *MOUNT], "a press on its mounts needs --frame and --mount"),
        ([*SPRINGS, *FRAME, "--mount", "point=0/0/0"], "--mount point=0/0/0: "),
        ([*SPRINGS, *FRAME, *MOUNT, "--pad", "length=0.2"], "--pad: the loss factor of rubber needs one frequency"),
        ([*SPRINGS, *FRAME, *MOUNT, "--elastic", "frame=1e9,crown_mass=1t"], "leave out crown_mass, or the mounts"),
        ([*SPRINGS, *FRAME, *MOUNT, "--clearance", "P:radial=0.1mm"], "pinpress: Elastic: a frame on mounts is rigid"),
        ([*SPRINGS, "--method", "constraint"], "--method does not go with --stiffness"),
    ],
)
def test_wrong_words(words: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*RUN, *words]) == 2
    out, error = capsys.readouterr()
    assert out == ""
    assert says in error
    assert error.count("\n") == 1
