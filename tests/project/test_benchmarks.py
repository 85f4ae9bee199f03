"""Every benchmark and every script that draws for pages can be run. Nothing is timed here: benchmarks run in their quick form."""

import os
import re
import runpy
import shutil
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import pytest

import pinpress as pp

ROOT = Path(__file__).resolve().parents[2]
BENCHMARKS = ROOT / "tests" / "benchmarks"
RUNNER = runpy.run_path(str(BENCHMARKS / "run.py"))
NUMBER = r"-?\d+(\.\d+)?(e[+-]?\d+)?"
PRINTED = {  # script -> patterns of lines that its quick form prints
    "balancing": (
        rf"ZXN2, two circles +pinpress +{NUMBER} +{NUMBER} +{NUMBER}",
        rf" HiGHS +{NUMBER}",
        r"the search stops at \d",
    ),
    "descriptions": (
        r"\| six-bar press \| \d+ \| 7 \| \d+ ms",
        r"\| drake \| (\d+) of \1 \|",
        r"what is said: to (\d+) of \1 \|",
    ),
    "identification": (
        rf"jf75g_125 +crank and gibs, cylinder +{NUMBER} s",
        rf"jf75g_125 +{NUMBER} % of \d+ values within 95 % intervals",
    ),
    "lifting": (
        rf"\| two rigid parts, 12 \| 720 \| exact steps \| {NUMBER} \|",
        rf"\| beams, \d+ \| 2880 \| exact steps \| {NUMBER} \|",
    ),
    "live": [
        r"\| zxn2_3000b \| \d+ \| \d+ \| \d+ ms \| \d+ \|",
    ],
    "measured": (
        r", friction +\S+ ms, \d+ strokes a second",
        rf"6 modes of 3 hits.* {NUMBER} ms",
        rf"mounts fitted.* {NUMBER} ms",
    ),
    "recording": (
        rf"\| `record` with arrows \| {NUMBER} s",
        rf"\| `report` \| {NUMBER} s .* MB",
    ),
    "searches": (
        r"proved optimum +0\.0414",
        rf"Latin hypercube +{NUMBER} +\d+ +{NUMBER}",
    ),
    "servo": (
        r"zxn2_3000b +\d+ ms, gap \d\.\de-",
        r"SLSQP +\d+ ms, heat \+",
        r"pinpress +180 +\d+ ms, time",
        r"toppra +180 +\d+ ms, time",
    ),
    "sweep": (
        rf"and peaks of all 7 bearings +{NUMBER} +{NUMBER}",
        rf"1000 at once +{NUMBER} runs/s",
        rf"Dask, 2 worker processes +{NUMBER} +{NUMBER}",
    ),
    "tolerances": (
        rf"cheapest tolerances, three targets +{NUMBER} s",
        rf"budget of two speeds.* {NUMBER} ms",
        rf"10 of them +{NUMBER} m",
        rf"chains made anew +{NUMBER}",
    ),
    "andrews": (
        rf"reduced +positions at 0\.01 s: {NUMBER}",
        rf"constraint, tolerance 1e-08 +{NUMBER} +{NUMBER} ms",
        r"Exudyn, step",
    ),
    "constraint_dynamics": (
        rf"\| `zxn2_3000b` \| 5 \| \d+ \| {NUMBER} \|",
        rf"\| 5 loops in space \| \d+ \| \d+ \| {NUMBER} \|",
        rf"\| Cassie \| 22 \| \d+ \| {NUMBER} \|",
    ),
    "elastic": (
        rf"collocation 1e-08 m +{NUMBER} s +error",
        rf"SciPy Radau 1e-05 +{NUMBER} s",
        rf"Exudyn DOPRI5.* {NUMBER} s",
    ),
    "inverse_dynamics": (
        rf"pinpress, plane +{NUMBER}",
        rf"Cassie, 12 drivers +{NUMBER} +{NUMBER}",
        rf"import pinpress +{NUMBER}",
    ),
    "n_four_bar": (
        r"N = 40: \d+ joints",
        rf"constraint +{NUMBER} ms, energy {NUMBER}, angles to {NUMBER} rad",
    ),
    "savings": (
        rf"\| torque alone, `bearings=.*` \| {NUMBER} \|",
        rf"\| 50 together, as arrays \| {NUMBER} \|",
        rf"\| and `load` \| {NUMBER} \|",
    ),
    "simulation": (
        rf"\S+ +{NUMBER} rad +{NUMBER} ms",
        r"3 scenarios together",
        rf"the steady state +{NUMBER} ms",
        r"turns free, constraint: energy error",
        r"1e-06 ",
    ),
    "sizes": (
        r"gear pairs +load +branch",
        rf"exponent +{NUMBER}",
        rf"scenarios +ms\n +10 +{NUMBER}",
        r"gear pairs of +2, engine in place 0: .* ratio",
    ),
    "beside_programs": [
        r"Proximal settings: ",
        rf"hand script +{NUMBER} +{NUMBER}",
    ],
    "first_calls": [
        r"\| first \[ms\] \|",
    ],
}
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


def test_every_script_is_tried_somewhere() -> None:
    assert {path.stem for path in (ROOT / "viz").glob("*.py")} == {*PICTURES, *NOT_RUN}
    assert set(RUNNER["scripts"]()) == {*PRINTED, *DOWNLOADS}
    assert all(RUNNER["first_line"](path) for path in RUNNER["scripts"]().values())


def test_no_test_outside_imports_benchmarks() -> None:
    """They are evidence of developers; what tests need stands in tests/support."""
    outside = [path for path in (ROOT / "tests").rglob("*.py") if BENCHMARKS not in path.parents]
    importing = [path.name for path in outside if re.search(r"^\s*(?:from|import) benchmarks", path.read_text(encoding="utf-8"), re.M)]
    assert importing == []


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", PRINTED)
def test_benchmarks_print_their_tables(name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    if name == "live" and shutil.which("chromium") is None:
        pytest.skip("there is no Chromium")
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")  # some scripts set it, and would leave it so
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(sys, "argv", [name])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # as one sees who runs it; what is wrong with it shows in its table
        if name == "live":  # Playwright refuses a second browser in a process where one is open, as that of other tests is
            command = [sys.executable, str(BENCHMARKS / "run.py"), "--quick", name]
            printed = subprocess.run(command, check=True, capture_output=True, text=True, timeout=200).stdout
        else:
            runpy.run_path(str(RUNNER["scripts"]()[name]))["main"](True)
            printed = capsys.readouterr().out
    for row in PRINTED[name]:
        assert re.search(row, printed), f"{row}\n{printed}"
    assert "nan" not in printed.replace("finance", "").split()


@pytest.mark.exhaustive
def test_every_first_call_can_be_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """All of `first_calls` in one process, where each is the first of its kind."""
    matplotlib = pytest.importorskip("matplotlib")
    script = runpy.run_path(str(BENCHMARKS / "speed" / "first_calls.py"))
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
