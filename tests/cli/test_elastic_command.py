"""Springs, dampers and clearances of the command line are those of Python, and what is wrong with them is said by the option's name."""

from typing import Any

import pytest

import pinpress as pp
from pinpress.cli import simulate
from pinpress.cli.main import main

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
    assert f"{lowest:+.4f} mm" in text
    assert "20 um radial, contact law 'linear'" in text
    assert f"{run.peaks['O']:.1f}" in text
    header = (tmp_path / "simulation.csv").read_text(encoding="utf-8").partition("\n")[0]
    assert "force_P [N]" in header


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--clearance", "P:radial=0.1mm"], "--clearance is for a press on springs: give --stiffness of its bearings too"),
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
        ([*SPRINGS, "--clearance", "P:radial=0.1mm", "--clearance", "P:radial=0.2mm"], "the clearance of P is given twice"),
        ([*SPRINGS, "--clearance", "P:radial=100"], "give the radial clearance in m"),
        ([*SPRINGS, "--clearance", "P:radial=0.1mm,law=hertz"], "restitution belongs to the law 'hertz': give it"),
        ([*SPRINGS, "--method", "constraint"], "--method does not go with --stiffness"),
    ],
)
def test_wrong_words(words: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*RUN, *words]) == 2
    out, error = capsys.readouterr()
    assert out == ""
    assert says in error
    assert error.count("\n") == 1
