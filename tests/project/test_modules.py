"""Modules are deep and folders hold few of them."""

from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "pinpress"
MODULES = {path.relative_to(PACKAGE).as_posix(): path for path in sorted(PACKAGE.rglob("*.py"))}
MOST = 16  # modules of one folder, apart from its __init__ and what its results show
DESCRIBED = "described.py"
LEAST = 40  # lines of a module
SHORT = {  # modules that have fewer, and why
    "__main__.py": "`python -m pinpress`",
    "measures.py": "a list of names, in measures.pyi",
    "plots/figure.py": "it imports Matplotlib, which is optional, where the rest of the room does so only to draw",
    "video.py": "a list of names, in video.pyi",
}


def crowded(modules: Iterable[str]) -> dict[str, int]:
    """Folders with too many modules, and how many these are."""
    count = Counter(Path(module).parent.as_posix() for module in modules if Path(module).name not in ("__init__.py", DESCRIBED))
    return {folder: number for folder, number in count.items() if number > MOST}


def splinters(lines: dict[str, int]) -> list[str]:
    """Modules that are too short, of the numbers of lines of all."""
    return [module for module, number in lines.items() if number < LEAST and Path(module).name != "__init__.py"]


def test_folders_hold_few_modules() -> None:
    assert crowded(MODULES) == {}


def test_modules_are_not_splinters() -> None:
    """The list of those that may be short has no other module."""
    assert splinters({module: path.read_text(encoding="utf-8").count("\n") for module, path in MODULES.items()}) == sorted(SHORT)


@pytest.mark.parametrize("number", [MOST, MOST + 1])
def test_a_crowd_is_found(number: int) -> None:
    assert crowded(["room/__init__.py", *(f"room/m{k}.py" for k in range(number))]) == ({} if number == MOST else {"room": number})


def test_a_splinter_is_found() -> None:
    assert splinters({"__init__.py": 1, "room/__init__.py": 1, "room/a.py": LEAST, "room/b.py": LEAST - 1}) == ["room/b.py"]
