"""The README says what is so: its code runs, its table is what its command prints, its test command is what the integration runs."""

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_python_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(code, names)
    assert (tmp_path / "cycle.csv").stat().st_size > 100_000
    assert (tmp_path / "press.html").stat().st_size > 500_000
    pressing, result = names["pressing"], names["result"]
    # 1 MN over the last 10 mm of the way down is seen by the drive, but not by the foundation
    assert pressing.driving_torque.max() > 1.5 * result.driving_torque.max()  # type: ignore[attr-defined]
    np.testing.assert_allclose(pressing.shaking_force, result.shaking_force, atol=1e-6)  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["kong2025", "accuracy", "balancing", "synthesis"])
def test_tables_are_what_their_scripts_print(name: str) -> None:
    spec = importlib.util.spec_from_file_location(name, ROOT / "viz" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    assert script.table() in README


def test_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\((?!http)([^)#]+)\)", README):
        assert (ROOT / target).exists(), target


def test_integration_runs_the_test_command() -> None:
    commands = re.findall(r"```\n(python3 -m venv .*?)\n```", README)
    assert len(commands) == 2
    assert commands[1] in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
