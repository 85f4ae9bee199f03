"""Random tests draw the same few cases every time, and new ones by the thousands where they are asked to."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from support.exploring import EXPLORE, MORE

HERE = Path(__file__).resolve().parents[1]
PROPERTY = """
from support.exploring import examples
from hypothesis import given, strategies as st

@examples(4)
@given(st.integers(0, 2**62))
def test_property(number):
    with open("cases", "a") as file:
        print(number, file=file)
"""


def cases(folder: Path, *options: str) -> tuple[list[str], str]:
    """Drawn in a run of the property above, and what the run said."""
    folder.mkdir()
    (folder / "test_property.py").write_text(PROPERTY, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-p", "conftest", "-p", "no:cacheprovider", "-c", os.devnull, "--rootdir", ".", *options]
    environment = os.environ | {"PYTHONPATH": str(HERE)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return (folder / "cases").read_text().split(), done.stdout


@pytest.mark.exhaustive
def test_the_same_cases_or_new_ones(tmp_path: Path) -> None:
    first, _ = cases(tmp_path / "first")
    assert 1 < len(first) <= 4
    assert cases(tmp_path / "second")[0] == first
    explored, said = cases(tmp_path / "third", f"--hypothesis-profile={EXPLORE}")
    assert 2 * len(first) < len(explored) <= 4 * MORE
    assert set(explored) - set(first)
    (seed,) = re.findall(r"--hypothesis-seed=\d+", said)
    assert cases(tmp_path / "fourth", f"--hypothesis-profile={EXPLORE}", seed)[0] == explored
