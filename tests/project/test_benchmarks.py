"""Every benchmark and every script that draws for pages can be run. Nothing is timed here: each work is done once, and the numbers that a
script names in capital letters are as small as they may be."""

import re
import runpy
import shutil
import sys
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.oracles import andrews

import pinpress as pp

ROOT = Path(__file__).resolve().parents[2]
BENCHMARKS = ROOT / "tests" / "benchmarks"
ELSEWHERE = {
    "features/first_calls": "test_every_first_call_can_be_made, in one process",
    "features/install": "test_installed_wheel.py installs once, where this downloads every extra again",
    "history/ratios": "test_ratio_history.py",
}

Names = dict[str, Any]


@dataclass(frozen=True)
class Small:
    """How little of a benchmark is run, and what it must print.

    Attributes:
        rows: patterns of lines.
        names: other values of names of the script, of those that it has and a folder for what it writes.
        words: of its command line.
        browser: whether it opens Chromium.
    """

    rows: tuple[str, ...]
    names: Callable[[Names, Path], Names] = lambda given, folder: {}
    words: tuple[str, ...] = ()
    browser: bool = False


def first(mapping: Mapping[str, Any], *words: str) -> dict[str, Any]:
    """The entries of a mapping whose names have one of these words in them."""
    return {name: value for name, value in mapping.items() if any(word in name for word in words)}


NUMBER = r"-?\d+(\.\d+)?(e[+-]?\d+)?"
SMALL = {
    "features/balancing": Small(
        (rf"ZXN2, two circles +pinpress +{NUMBER} +{NUMBER} +{NUMBER}", rf" HiGHS +{NUMBER}", r"the search stops at \d"),
        lambda *_: {"REPEATED": 1},
    ),
    "features/descriptions": Small(
        (r"\| six-bar press \| \d+ \| 7 \| \d+ ms", r"\| drake \| (\d+) of \1 \|", r"what is said: to (\d+) of \1 \|"),
        lambda given, _: {"REPEATS": 1, "PRESSES": first(given["PRESSES"], "six-bar"), "FORMATS": first(given["FORMATS"], "drake")},
    ),
    "features/identification": Small(
        (rf"jf75g_125 +crank and gibs, cylinder +{NUMBER} s", rf"jf75g_125 +{NUMBER} % of \d+ values within 95 % intervals"),
        lambda given, _: {"TIMES": 1, "PRESSES": 1, "STROKES": first(given["STROKES"], "jf75g"), "DRAWN": ["jf75g_125"]},
    ),
    "features/lifting": Small(
        (rf"\| two rigid parts, 12 \| 720 \| exact steps \| {NUMBER} \|", rf"\| beams, \d+ \| 2880 \| exact steps \| {NUMBER} \|"),
        lambda *_: {"STATES": 720, "ENOUGH": 1e-9, "STROKES": 1, "METHODS": (), "EXACT": 1e-6},
    ),
    "features/live": Small(
        (r"\| zxn2_3000b \| \d+ \| \d+ \| \d+ ms \| \d+ \|",),
        lambda *_: {"SHOWN": ["zxn2_3000b"], "SECONDS": 0.2, "PICTURES": 2},
        browser=True,
    ),
    "features/measured": Small(
        (r", friction +\S+ ms, \d+ strokes a second", rf"6 modes of 3 hits.* {NUMBER} ms", rf"mounts fitted.* {NUMBER} ms"),
        lambda *_: {"TIMES": 1},
    ),
    "features/recording": Small(
        (rf"\| `record` with arrows \| {NUMBER} s", rf"\| `report` \| {NUMBER} s .* MB"), lambda *_: {"REPEATS": 1}
    ),
    "features/searches": Small((r"proved optimum +0\.0414", rf"Latin hypercube +{NUMBER} +\d+ +{NUMBER}"), lambda *_: {}),
    "features/servo": Small(
        (r"zxn2_3000b +\d+ ms, gap \d\.\de-", r"SLSQP +\d+ ms, heat \+", r"pinpress +180 +\d+ ms, time", r"toppra +180 +\d+ ms, time"),
        lambda *_: {"REPEATED": 1, "PRESSES": ["zxn2_3000b"], "SEGMENTS": [180]},
    ),
    "features/sweep": Small(
        (
            rf"and peaks of all 7 bearings +{NUMBER} +{NUMBER}",
            rf"1000 at once +{NUMBER} runs/s",
            rf"Dask, 2 worker processes +{NUMBER} +{NUMBER}",
        ),
        lambda *_: {"SPEEDS": np.linspace(1, 2, 5), "FORCES": np.linspace(0, 1e6, 5), "REPEATS": 1, "POINTS": 100},
    ),
    "features/tolerances": Small(
        (
            rf"cheapest tolerances, three targets +{NUMBER} s",
            rf"budget of two speeds.* {NUMBER} ms",
            rf"10 of them +{NUMBER} m",
            rf"chains made anew +{NUMBER}",
        ),
        lambda *_: {"RUNS": 1, "COMPARED": 50, "OTHERS": 1},
    ),
    "mechanics/andrews": Small(
        (rf"reduced +positions at 0\.01 s: {NUMBER}", rf"constraint, tolerance 1e-08 +{NUMBER} +{NUMBER} ms", r"Exudyn, step"),
        lambda *_: {
            "DURATION": 0.005,
            "TOLERANCES": (1e-8,),
            "STEPS": (1e-5,),
            "andrews": SimpleNamespace(**{**vars(andrews), "REFERENCE": {0.01: andrews.REFERENCE[0.01]}}),
        },
    ),
    "mechanics/constraint_dynamics": Small(
        (
            rf"\| `zxn2_3000b` \| 5 \| \d+ \| {NUMBER} \|",
            rf"\| 5 loops in space \| \d+ \| \d+ \| {NUMBER} \|",
            rf"\| Cassie \| 22 \| \d+ \| {NUMBER} \|",
        ),
        lambda given, _: {
            "STATES": 1,
            "REPEATS": 1,
            "TURNS": 1,
            "SETTINGS": given["SETTINGS"][20:22],
            "LINKAGES": first(given["LINKAGES"], "zxn2", "Cassie", "5 loops"),
        },
    ),
    "mechanics/elastic": Small(
        (rf"collocation 1e-08 m +{NUMBER} s +error", rf"SciPy Radau 1e-05 +{NUMBER} s", rf"Exudyn DOPRI5.* {NUMBER} s"),
        lambda given, _: {"CASES": given["CASES"][:1]},
        ("--quick",),
    ),
    "mechanics/inverse_dynamics": Small(
        (rf"pinpress, plane +{NUMBER}", rf"Cassie, 12 drivers +{NUMBER} +{NUMBER}", rf"import pinpress +{NUMBER}"),
        lambda *_: {
            "REPEATS": {360: 1},
            "FEWEST": range(2, 4),
            "SUBSET": 36,
            "timed": lambda entries, repeats: [[seconds(work)] for _, _, work, _ in entries],
        },
        ("--quick",),
    ),
    "mechanics/n_four_bar": Small((r"N = 40: \d+ joints", rf"constraint +{NUMBER} ms, energy {NUMBER}, angles to {NUMBER} rad")),
    "mechanics/savings": Small(
        (rf"\| torque alone, `bearings=.*` \| {NUMBER} \|", rf"\| 50 together, as arrays \| {NUMBER} \|", rf"\| and `load` \| {NUMBER} \|"),
        lambda given, folder: {
            "REPEATS": {360: 1},
            "SIDES": 8,
            "WRITTEN": folder / "savings.md",
            "INTERPRETERS": first(given["INTERPRETERS"], "import pinocchio", "and `load`"),
        },
        ("--quick",),
    ),
    "mechanics/simulation": Small(
        (
            rf"\S+ +{NUMBER} rad +{NUMBER} ms",
            r"3 scenarios together",
            rf"the steady state +{NUMBER} ms",
            r"turns free, constraint: energy error",
            r"1e-06 ",
        ),
        lambda given, _: {
            "TOLERANCES": (1e-6, 1e-8),
            "STEPS": (1e-2,),
            "ASKED": (1e-6,),
            "SCENARIOS": 3,
            "LONG": 2.0,
            "FREE": 2.0,
            "BY_JOINTS": 2.0,
            "SIX_BAR": 2.0,
        },
        ("--quick",),
    ),
    "mechanics/sizes": Small(
        (
            r"gear pairs +load +branch",
            rf"exponent +{NUMBER}",
            rf"scenarios +ms\n +10 +{NUMBER}",
            r"gear pairs of +2, engine in place 0: .* ratio",
        ),
        lambda given, _: {"KINDS": tuple(kind._replace(sizes=(2, 3, 4)) for kind in given["KINDS"]), "THREADED": (8,), "REPEATS": 1},
        ("--quick",),
    ),
}


PICTURES = {  # scripts of viz -> what each writes
    "arrangements": ("arrangements.md", "arrangements.png"),
    "balancing": ("balancing.png",),
    "before_and_after": ("report.png", "comparison.png", "out/zxn2_3000b_bearings.svg"),
    "elasticity": ("elasticity.png",),
    "foundation": ("foundation.md", "foundation.png"),
    "ratings": ("ratings.png",),
    "ratios": ("ratios.png",),
    "record_presses": ("thin_wall.png", *(f"out/{name}_report.html" for name in pp.presses())),
    "servo": ("servo.png",),
    "synthesis": (),
}
IN_BROWSER = ("before_and_after", "record_presses")
NOT_RUN = ("accuracy", "light")  # minutes with peers, whose results test_accuracy.py looks at; what the others call


def test_every_script_is_tried_somewhere() -> None:
    assert {path.stem for path in (ROOT / "viz").glob("*.py")} == {*PICTURES, *NOT_RUN}
    scripts = {str(path.relative_to(BENCHMARKS).with_suffix("")) for path in BENCHMARKS.rglob("*.py") if path.name != "__init__.py"}
    assert scripts == {*SMALL, *ELSEWHERE}


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", SMALL)
def test_benchmarks_print_their_tables(
    name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small = SMALL[name]
    if small.browser and shutil.which("chromium") is None:
        pytest.skip("there is no Chromium")
    main, given = opened(BENCHMARKS / f"{name}.py", monkeypatch, small.words)
    smaller = small.names(given, tmp_path)
    assert smaller.keys() <= given.keys(), "names that the script does not have"
    main.__globals__.update(smaller)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # as one sees who runs it; what is wrong with it shows in its table
        main()
    printed = capsys.readouterr().out
    for row in small.rows:
        assert re.search(row, printed), f"{row}\n{printed}"
    assert "nan" not in printed.replace("finance", "").split()


def opened(script: Path, monkeypatch: pytest.MonkeyPatch, words: Sequence[str] = ()) -> tuple[Callable[[], None], Names]:
    """The `main` of a script as on its command line, all but run, in which what it times is done once; and the script's names."""
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")  # some scripts set it, and would leave it so
    monkeypatch.setattr(sys, "path", [str(script.parent), *sys.path])
    monkeypatch.setattr(sys, "argv", [str(script), *words])
    given = runpy.run_path(str(script))
    main: Callable[[], None] = given["main"]
    if "least_seconds" in given:
        main.__globals__["least_seconds"] = lambda works, repeats: [seconds(work) for work in works]
    return main, given


def seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


@pytest.mark.exhaustive
def test_every_first_call_can_be_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """All of `first_calls` in one process, where each is the first of its kind."""
    matplotlib = pytest.importorskip("matplotlib")
    script = runpy.run_path(str(BENCHMARKS / "features" / "first_calls.py"))
    names: Names = {}
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
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        runpy.run_path(str(folder / f"{name}.py"), run_name="__main__")
    assert capsys.readouterr().out
    for file in PICTURES[name]:
        assert (folder / file).stat().st_size > 1000, file
        if file.endswith(".md"):
            assert (folder / file).read_text(encoding="utf-8") == (ROOT / "viz" / file).read_text(encoding="utf-8")
