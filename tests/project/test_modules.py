"""Modules are deep and folders hold few of them."""

from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "pinpress"
MODULES = {path.relative_to(PACKAGE).as_posix(): path for path in sorted(PACKAGE.rglob("*.py"))}
MOST = 16  # modules of one folder, apart from its __init__ and what its results show
DESCRIBED = "described.py"
LEAST = 40  # lines of a module
SHORT = {  # modules that have fewer, and why
    "__main__.py": "`python -m pinpress`",
    "cli/measured/measured.py": "a list of its commands",
    "measures.py": "a list of names, in measures.pyi",
    "plots/figure.py": "it imports Matplotlib, which is optional, where the rest of the room does so only to draw",
    "video.py": "a list of names, in video.pyi",
}


def test_folders_hold_few_modules() -> None:
    modules = (Path(module) for module in MODULES)
    count = Counter(module.parent.as_posix() for module in modules if module.name not in ("__init__.py", DESCRIBED))
    assert {folder: number for folder, number in count.items() if number > MOST} == {}


def test_modules_are_not_splinters() -> None:
    """The list of those that may be short has no other module."""
    lines = {module: path.read_text(encoding="utf-8").count("\n") for module, path in MODULES.items() if path.name != "__init__.py"}
    assert [module for module, number in lines.items() if number < LEAST] == sorted(SHORT)
