"""A report that several modules open: to write and load it takes longer than most tests."""

from pathlib import Path

import pytest
from support import texts

import pinpress as pp


@pytest.fixture(scope="session")
def small_report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    press = texts.shipped("zxn2_3000b")
    return pp.report(press, pp.cycle(press, speed=70 * pp.RPM, points=24), tmp_path_factory.mktemp("small") / "out.html")
