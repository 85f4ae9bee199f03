"""The history of ratios: what is stored and said belongs to the ratios that are measured, and each of these can be measured today."""

import json
import math
import re
import runpy
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = vars(import_module("benchmarks.history.table"))


def test_stored_ratios_are_those_that_are_measured() -> None:
    """Of each commit there is one, and the newest one has all."""
    stored, names = PAGES["stored"](), PAGES["words"]()
    assert len(stored) >= 3
    for found in stored:
        assert re.fullmatch(r"[0-9a-f]{40}", found["commit_hash"])
        ratios = [ratio for name in names if (ratio := PAGES["ratio"](found, name)) is not None]
        assert ratios
        assert all(0 < ratio < math.inf for ratio in ratios)
    assert None not in [PAGES["ratio"](stored[-1], name) for name in names]
    known = json.loads((PAGES["HISTORY"] / "results" / "benchmarks.json").read_text(encoding="utf-8"))
    assert {name.removeprefix("ratios.track_") for name in known if name != "version"} == set(names)


def test_every_ratio_says_what_is_beside_what() -> None:
    for name, words in PAGES["words"]().items():
        assert words.count(" / ") == 1, name


def test_contributors_are_shown_the_stored_ratios() -> None:
    page = (PAGES["HISTORY"] / "README.md").read_text(encoding="utf-8")
    assert page == PAGES["fill"](page), "python docs/make.py table"


@pytest.mark.exhaustive
def test_every_ratio_can_be_measured_today(monkeypatch: pytest.MonkeyPatch) -> None:
    """By one turn each: whether it can, not how fast it is."""
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")  # the script sets it, and would leave it so
    monkeypatch.syspath_prepend(str(ROOT / "tests"))
    ratios = runpy.run_path(str(PAGES["HISTORY"] / "ratios.py"))
    ratios["_ratio"].__globals__.update(TURN=0.0, CONTEST=0.0)
    for name in PAGES["words"]():
        assert 0 < ratios[f"track_{name}"]() < math.inf
