"""The README says what is so: its code runs, its test command is what the integration runs, its links lead somewhere, and it is short."""

import re
from pathlib import Path

import numpy as np
import pytest
from support import page_blocks

import pinpress as pp

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
MOST_LINES = 134  # two screens, a picture, a table of pins, a robot, and how a press is computed


def test_python_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    (tmp_path / "docs").symlink_to(ROOT / "docs")  # as in a checkout
    shown, robot = page_blocks.run(README, names)
    assert shown.same, shown.printed
    assert robot.same
    assert np.shape(names["torque"]) == (2, 2)
    assert (tmp_path / "report.html").stat().st_size > 1_000_000
    reactions = names["reactions"]
    assert isinstance(reactions, pp.Reactions)
    assert reactions.process_force.max() == pytest.approx(1e6, rel=1e-3)


def test_table_of_pins_is_the_crank_press_that_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A stroke of twice the crank, and no warning."""
    monkeypatch.chdir(tmp_path)
    (table,) = [block for block in page_blocks.blocks(README) if block.language == "yaml"]
    Path("press.yaml").write_text(table.body, encoding="utf-8")
    assert pp.dead_centres(pp.build("press.yaml")).stroke == pytest.approx(0.2, rel=1e-12)  # a warning is an error in tests


def test_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\((?!http)([^)#]+)\)", README):
        assert (ROOT / target).exists(), target


def test_integration_runs_the_test_command() -> None:
    commands = re.findall(r"```\n(python3 -m venv .*?)\n```", README)
    assert len(commands) == 2
    assert commands[1] in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def test_fits_two_screens() -> None:
    assert README.count("\n") <= MOST_LINES
