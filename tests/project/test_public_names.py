"""The stubs are the only lists of public names: `dir`, imports and type checkers agree with them, and no two names can be mixed up."""

import ast
import importlib
import inspect
from itertools import combinations
from pathlib import Path

import pytest

import pinpress as pp

ROOT = Path(pp.__file__).resolve().parents[1]
STUBS = {path.relative_to(ROOT).as_posix(): ast.parse(path.read_bytes()) for path in sorted(ROOT.glob("pinpress/**/*.pyi"))}
SPACES = {stub.removesuffix(".pyi").removesuffix("/__init__").replace("/", "."): tree for stub, tree in STUBS.items()}
MEANT = {
    ("Job", "job"),  # what the function returns, whose class no user has to write
    ("load", "loads"),  # the namespace of loads keeps the field's word
    ("measured", "measures"),  # what a machine was found to be, beside quantities of a motion: users asked for this word
    ("Sweep", "sweep"),  # what the function returns, whose class no user has to write
}


def listed(tree: ast.Module) -> dict[str, str]:
    """The names of a stub, and where each is taken from."""
    return {
        alias.asname or alias.name: "." * node.level + (node.module or "")
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


def alike(first: str, second: str) -> bool:
    """Whether names are the same but for case, underscores and at most one letter that is changed, added or left out."""
    short, long = sorted((name.replace("_", "").lower() for name in (first, second)), key=len)
    if len(long) > len(short) + 1:
        return False
    same = next((k for k, (a, b) in enumerate(zip(short, long, strict=False)) if a != b), len(short))
    return short[same + (len(short) == len(long)) :] == long[same + 1 :]


def test_every_namespace_has_its_list() -> None:
    modules = [name for name in dir(pp) if inspect.ismodule(getattr(pp, name))]
    assert {f"pinpress.{name}" for name in modules} <= set(SPACES)


@pytest.mark.parametrize("space", SPACES)
def test_the_list_is_what_a_user_sees(space: str) -> None:
    """`dir` shows the names of the stub and no other, each is described, and no two can be mixed up. A module that has been imported is an
    attribute of its package: it would stand before a function of the same name."""
    namespace, names = importlib.import_module(space), listed(SPACES[space])
    assert sorted(namespace.__all__) == dir(namespace) == sorted(names)
    assert [pair for pair in combinations(sorted(names), 2) if alike(*pair) and pair not in MEANT] == []
    modules = {path.stem for path in (ROOT / space.replace(".", "/")).glob("*")}
    assert modules & {name for name, source in names.items() if source.strip(".")} == set()
    package = space if hasattr(namespace, "__path__") else space.rpartition(".")[0]
    assert namespace.__doc__
    for name, source in names.items():
        value = getattr(namespace, name)
        assert value is getattr(importlib.import_module(source, package), name)
        written = vars(value).get("__doc__") if inspect.isclass(value) else value.__doc__  # numbers have the text of their type
        assert written, name
        assert not written.startswith(f"{name}("), f"{name}: only the signature that dataclasses write"


@pytest.mark.parametrize(
    ("first", "second", "answer"),
    [
        ("Report", "report", True),
        ("TradeOff", "trade_off", True),
        ("load", "loads", True),
        ("Extreme", "extremes", True),
        ("Synthesis", "synthesise", True),
        ("stroke", "strike", True),
        ("Rod", "Frame", False),
        ("speed_at", "speed_ratio", False),
        ("abc", "bcd", False),
        ("abcd", "acd", True),
    ],
)
def test_names_that_can_be_mixed_up_are_found(first: str, second: str, answer: bool) -> None:
    assert alike(first, second) == alike(second, first) == answer
