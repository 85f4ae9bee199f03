"""Every benchmark and every script that draws for pages can be run. Nothing is timed here: benchmarks run in their quick form."""

import os
import re
import runpy
import shutil
import subprocess
import sys
import warnings
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import pinpress as pp

ROOT = Path(__file__).resolve().parents[2]
BENCHMARKS = ROOT / "tests" / "benchmarks"
RUNNER = runpy.run_path(str(BENCHMARKS / "run.py"))
DOWNLOADS = {"install"}  # test_installed_wheel.py installs once, where this downloads every extra again
PICTURES = {  # scripts of viz -> what each writes
    "arrangements": ("arrangements.md", "arrangements.png"),
    "balancing": ("balancing.png",),
    "before_and_after": ("report.png", "comparison.png", "out/zxn2_3000b_bearings.svg"),
    "elasticity": ("elasticity.png",),
    "foundation": ("foundation.md", "foundation.png"),
    "ratings": ("ratings.png",),
    "record_presses": ("thin_wall.png", *(f"out/{name}_report.html" for name in pp.presses())),
    "servo": ("servo.png",),
    "synthesis": (),
}
IN_BROWSER = ("before_and_after", "record_presses")
NOT_RUN = ("light",)  # what the others call


def test_every_script_is_tried_and_described() -> None:
    assert {path.stem for path in (ROOT / "viz").glob("*.py")} == {*PICTURES, *NOT_RUN}
    assert all(RUNNER["scripts"]().values())


def test_no_test_outside_imports_benchmarks() -> None:
    """They are evidence of developers; what tests need stands in tests/support."""
    outside = [path for path in (ROOT / "tests").rglob("*.py") if BENCHMARKS not in path.parents]
    importing = [path.name for path in outside if re.search(r"^\s*(?:from|import) benchmarks", path.read_text(encoding="utf-8"), re.M)]
    assert importing == []


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
def test_every_first_call_can_be_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """All of `first_calls` in one process, where each is the first of its kind."""
    matplotlib = pytest.importorskip("matplotlib")
    script = vars(import_module("benchmarks.speed.first_calls"))
    names: dict[str, Any] = {}
    failed = {}
    with warnings.catch_warnings(), matplotlib.rc_context({"figure.max_open_warning": 0}):
        warnings.simplefilter("ignore")
        exec(script["START"], names)
        for name, made in script["GIVEN"].items():
            exec(f"{name} = {made}", names)
        for name, call in (each for calls in script["KINDS"].values() for each in calls.items()):
            try:
                exec(call, names)
            except Exception as error:
                failed[name] = error
    assert failed == {}


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", PICTURES)
def test_scripts_write_their_pictures(
    name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a copy of their folder."""
    if name in IN_BROWSER and shutil.which("chromium") is None:
        pytest.skip("there is no Chromium")
    folder = tmp_path / "viz"
    shutil.copytree(ROOT / "viz", folder, ignore=shutil.ignore_patterns("*.png", "*.md", "out", "__pycache__"))
    for beside in ("docs", "tests", "urdf"):
        (tmp_path / beside).symlink_to(ROOT / beside)
    monkeypatch.setattr(sys, "path", [str(folder), *sys.path])
    monkeypatch.delitem(sys.modules, "light", raising=False)
    monkeypatch.setattr(sys, "argv", [str(folder / f"{name}.py")])
    if name in IN_BROWSER:  # Playwright refuses a second browser in a process where one is open, as that of other tests is
        paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
        command = [sys.executable, str(folder / f"{name}.py")]
        done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=280, env={**os.environ, "PYTHONPATH": paths})
        printed = done.stdout
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            runpy.run_path(str(folder / f"{name}.py"), run_name="__main__")
        printed = capsys.readouterr().out
    assert printed
    for file in PICTURES[name]:
        assert (folder / file).stat().st_size > 1000, file
        if file.endswith(".md"):
            assert (folder / file).read_text(encoding="utf-8") == (ROOT / "viz" / file).read_text(encoding="utf-8")
