"""The public names of a room. Each is imported when it is first used; the message of a name that is missing says which room has it.

A room's `__init__.pyi` is the list of its names.
"""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, TypeAlias

import lazy_loader

PACKAGE = Path(__file__).parents[1]
Look: TypeAlias = Callable[[str], Any]
Names: TypeAlias = Callable[[], list[str]]


def public_names(room: str, file: str) -> tuple[Look, Names, list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a room.

    Args:
        room: its name, such as "pinpress.measures".
        file: its file; the stub is in the same folder.
    """
    package = room if Path(file).stem == "__init__" else room.rpartition(".")[0]
    there, names, listed = lazy_loader.attach_stub(package, file)

    def look(name: str) -> Any:
        if name not in listed:
            asked = name.startswith("_")  # by Python or a tool such as pytest, which expect no answer
            raise AttributeError(f"{room} has no {name!r}{'' if asked else _elsewhere(name, listed)}")
        found = there(name)
        if package != room:  # the loader keeps what it has found in the package, where it is no public name
            around = import_module(package)
            if name not in around.__all__:
                vars(around).pop(name, None)
            setattr(import_module(room), name, found)
        return found

    return look, names, listed


def _elsewhere(name: str, listed: list[str]) -> str:
    """Which other rooms have a name, or else which name of this room is close to it."""
    import ast  # only on the way to an error

    from .errors import suggestion  # only on the way to an error

    rooms = []
    for stub in sorted(PACKAGE.rglob("*.pyi")):
        imports = [node for node in ast.parse(stub.read_bytes()).body if isinstance(node, ast.ImportFrom)]
        if any(name == (alias.asname or alias.name) for node in imports for alias in node.names):
            rooms.append(".".join(stub.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__"))
    return f": it is {' and '.join(f'{room}.{name}' for room in rooms)}" if rooms else suggestion(name, listed)
