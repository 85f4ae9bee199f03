"""Rooms stand on storeys: imports point down, no files import each other in a circle, imports in functions say why they are there."""

import ast
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib.util import resolve_name
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOUND = (*ROOT.glob("pinpress/**/*.py"), *ROOT.glob("pinpress/**/*.pyi"))
FILES = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in sorted(FOUND)}
LINTER = [sys.executable, "-c", "from importlinter.cli import lint_imports_command; lint_imports_command()", "--no-cache"]


def module(file: str) -> str:
    """The dotted name of a file; a stub is a part of its module."""
    return file.rpartition(".")[0].replace("/", ".").removesuffix(".__init__")


class Import(NamedTuple):
    """A statement that imports, and whether it stands in a function."""

    node: ast.Import | ast.ImportFrom
    in_function: bool


@cache
def imports(text: str) -> tuple[Import, ...]:
    """All imports of a module. Its tree is not kept: millions of nodes would hold up the garbage collector."""
    return tuple(_imports(ast.parse(text), False))


def _imports(node: ast.AST, in_function: bool) -> Iterator[Import]:
    """Of statements alone, as nine tenths of a tree are expressions."""
    if isinstance(node, ast.Import | ast.ImportFrom):
        yield Import(node, in_function)
    inside = in_function or isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    for block in ("body", "handlers", "orelse", "finalbody", "cases"):
        for inner in getattr(node, block, ()):
            yield from _imports(inner, inside)


def circle(files: dict[str, str]) -> list[str]:
    """Modules that import each other in a circle, be it for types, in functions or by the list of a room's names; or none.

    files: path from the root -> text.
    """
    modules = {module(file) for file in files}
    graph: dict[str, set[str]] = {name: set() for name in modules}
    for file, text in files.items():
        for node, _ in imports(text):
            if isinstance(node, ast.Import):
                found = {alias.name for alias in node.names}
            else:
                package = file.rpartition("/")[0].replace("/", ".")
                source = resolve_name("." * node.level + (node.module or ""), package) if node.level else node.module or ""
                wholes = {alias.name: f"{source}.{alias.name}" for alias in node.names}
                found = {whole if whole in modules else source for whole in wholes.values()}
            graph[module(file)] |= (found & modules) - {module(file)}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return [str(name) for name in error.args[1]]
    return []


def unexplained(text: str) -> list[int]:
    """The lines of imports inside functions that no comment explains: beside it, above it, or at the import right above it."""
    lines = text.splitlines()
    found: list[int] = []
    explained: set[int] = set()  # the last lines of imports
    for line, end in sorted((node.lineno, node.end_lineno or node.lineno) for node, in_function in imports(text) if in_function):
        if "  # " in lines[end - 1] or lines[line - 2].lstrip().startswith("# ") or line - 1 in explained:
            explained.add(end)
        else:
            found.append(line)
    return found


def lint(folder: Path) -> tuple[int, str]:
    """Exit code and output of the linter of imports, with the contract of this project."""
    environment = os.environ | {"PYTHONPATH": str(folder)}
    done = subprocess.run([*LINTER, "--config", str(ROOT / "pyproject.toml")], cwd=folder, env=environment, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def test_imports_point_down() -> None:
    """By the storeys in `pyproject.toml`, without an exception."""
    code, said = lint(ROOT)
    assert code == 0, said


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("room", "line"),
    [
        ("linkage", "def kept():\n    from ..kinematics.motion import Motion  # inside a function\n"),
        ("engines", "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from ..linkage.linkage import Linkage\n"),
        ("balancing", "from ..sweeps import sweeping\n"),
        ("attic", ""),  # a room that stands on no storey
    ],
)
def test_an_import_upwards_or_aside_is_found(room: str, line: str, tmp_path: Path) -> None:
    for file in FILES:
        path = tmp_path / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
    added = tmp_path / "pinpress" / room / "added.py"
    added.parent.mkdir(exist_ok=True)
    (added.parent / "__init__.py").touch()
    added.write_text(line)
    code, said = lint(tmp_path)
    assert code == 1
    assert room in said


@cache
def tree_of_tests() -> dict[str, str]:
    """The texts of all modules of tests, by their paths."""
    paths = sorted((ROOT / "tests").rglob("*.py"))
    return {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in paths}


@pytest.mark.parametrize(
    ("pattern", "allowed"),
    [
        # What tests share stands in `support` or in `extremes`.
        pytest.param(r"^ *(from|import) [^#\n]*\b(test_\w+|conftest)\b", r"\A\Z", id="imports of test modules"),
        # Benchmarks are evidence of developers.
        pytest.param(r"^\s*(from|import) benchmarks", "tests/benchmarks/", id="imports of benchmarks"),
        # Random tests draw as `support.exploring` says.
        pytest.param(
            r"\bsettings\(.*(derandomize|max_examples)", "exploring|conftest|test_exploring|test_layers", id="settings of Hypothesis"
        ),
    ],
)
def test_no_test_has(pattern: str, allowed: str) -> None:
    assert [path for path, text in tree_of_tests().items() if re.search(pattern, text, re.MULTILINE) and not re.search(allowed, path)] == []


@pytest.mark.exhaustive
def test_no_files_import_each_other_in_a_circle() -> None:
    assert circle(FILES) == []


@pytest.mark.parametrize(
    "closing",
    [
        "from . import a\n",
        "from .a import X\n",
        "import pinpress.room.a\n",
        "def f():\n    from ..room.a import X\n",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from pinpress.room.a import X\n",
        "from ..room import X\n",  # whose list takes it from a
    ],
)
def test_a_circle_is_found(closing: str) -> None:
    files = {
        "pinpress/room/__init__.pyi": "from .a import X as X\n",
        "pinpress/room/__init__.py": "",
        "pinpress/room/a.py": "from .b import Y\n",
    }
    assert circle(files | {"pinpress/room/b.py": "Y = 1\n"}) == []
    assert "pinpress.room.b" in circle(files | {"pinpress/room/b.py": closing})


@pytest.mark.exhaustive
def test_imports_inside_functions_say_why() -> None:
    found = {file: unexplained(text) for file, text in FILES.items() if file.endswith(".py")}
    assert {file: lines for file, lines in found.items() if lines} == {}


def test_an_import_that_does_not_say_why_is_found() -> None:
    text = "import os\ndef f():\n    import re  # slow\n    import ast\n    g()\n    import csv\n    # slow\n    import json\n"
    assert unexplained(text) == [6]
