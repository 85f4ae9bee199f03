"""Every benchmark and every script that draws for pages can be run. Nothing is timed here: benchmarks run in their quick form."""

import os
import re
import runpy
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import make
import pytest

ROOT = Path(__file__).resolve().parents[2]
BENCHMARKS = ROOT / "tests" / "benchmarks"
RUNNER = runpy.run_path(str(BENCHMARKS / "run.py"))
DOWNLOADS = {"install"}  # test_installed_wheel.py installs once, where this downloads every extra again
NOT_QUICK = {"presses", "pictures"} if shutil.which("chromium") is None else set()  # these open pages
WRITTEN = {"pictures": "live.png", "presses": "report.png", "manual": "manual.pdf"}  # script -> a file that its quick form writes


def test_every_script_is_tried_and_described() -> None:
    assert all(RUNNER["scripts"]().values())
    assert all(words for _, words in make.scripts().values())
    assert {path.stem for path in (ROOT / "viz").glob("*.py")} <= set(make.scripts())


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", sorted(set(RUNNER["scripts"]()) - DOWNLOADS))
def test_benchmarks_print_tables(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Tables that have rows, all with as many cells as the head; `programs` prints the text of `pinpress accuracy`."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # as one sees who runs it; what is wrong with it shows in its table
        RUNNER["run"](name, True)
    printed = capsys.readouterr().out
    assert "nan" not in re.findall(r"\w+", printed)
    if name == "programs":
        assert re.search(r"hand script +\S+ +\S+", printed)
        return
    tables = re.findall(r"(?:^\|.*\n)+", printed, re.MULTILINE)
    assert tables
    for table in tables:
        cells = [line.count(" | ") for line in table.splitlines() if not line.startswith("|---")]
        assert len(cells) > 1, table
        assert len(set(cells)) == 1, table


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", sorted(set(make.scripts()) - NOT_QUICK - {"manual"}))
def test_scripts_of_the_documentation_write_their_files(name: str, tmp_path: Path) -> None:
    """In a process of their own, as some open a browser; the pages among the files are those of the repository."""
    command = [sys.executable, str(ROOT / "docs" / "make.py"), name, "--quick", "--to", str(tmp_path)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=280, env={**os.environ, "PYTHONPATH": str(ROOT)})
    assert done.stdout
    assert (tmp_path / WRITTEN.get(name, "")).exists()
    for path in tmp_path.glob("*.md"):
        places = [place for place in ROOT.glob(f"**/{path.name}") if not {".venv", "out"} & set(place.parts)]
        assert path.read_bytes() in [place.read_bytes() for place in places]
