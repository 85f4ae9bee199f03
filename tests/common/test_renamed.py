"""Old names work, warn at the caller's line, and stand in no list; what is past its end is found."""

import ast
import importlib
import re
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import pinpress as pp
from pinpress.common.renamed import OldNames, old_keywords

ROOT = Path(pp.__file__).resolve().parent
ROOM = {
    "__init__.py": """import lazy_loader
from pinpress.common.renamed import OldNames
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__getattr__ = OldNames(__name__, __getattr__, {"weigh": "mass_of", "Rubbing": "pinpress.loads.Friction"}, gone_in="0.5")
""",
    "__init__.pyi": """import pinpress.loads
from .masses import mass_of as mass_of
weigh = mass_of
Rubbing = pinpress.loads.Friction
""",
    "masses.py": "def mass_of(name: str) -> float:\n    return 2.0\n",
    "py.typed": "",
}


@pytest.fixture
def room(tmp_path, monkeypatch):
    """A package `renaming_room` in which two names are old ones."""
    folder = tmp_path / "renaming_room"
    folder.mkdir()
    for name, text in ROOM.items():
        (folder / name).write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield importlib.import_module("renaming_room")
    for name in [name for name in sys.modules if name.split(".")[0] == "renaming_room"]:
        del sys.modules[name]


def old_names() -> dict[str, OldNames]:
    """Those of all rooms."""
    stubs = [path.relative_to(ROOT.parent).as_posix() for path in ROOT.rglob("*.pyi")]
    rooms = [stub.removesuffix(".pyi").removesuffix("/__init__").replace("/", ".") for stub in stubs]
    found = {room: importlib.import_module(room).__getattr__ for room in rooms}
    return {room: names for room, names in found.items() if isinstance(names, OldNames)}


def version(text: str) -> tuple[int, ...]:
    return tuple(int(number) for number in re.findall(r"\d+", text))


def overdue(rooms: dict[str, OldNames], today: str) -> list[str]:
    """Rooms whose old names should have gone."""
    return [room for room, names in rooms.items() if version(names.gone_in) <= version(today)]


def untyped(names: OldNames, stub: str) -> list[str]:
    """Old names that a stub does not have."""
    assigned = {target.id for node in ast.parse(stub).body if isinstance(node, ast.Assign) for target in node.targets}  # type: ignore[attr-defined]
    return sorted(names.renamed.keys() - assigned)


def test_an_old_name_is_the_new_one_and_warns_at_the_callers_line(room) -> None:
    with pytest.warns(
        DeprecationWarning, match=r"^renaming_room\.weigh is now renaming_room\.mass_of: write that; version 0\.5 has"
    ) as told:
        assert room.weigh is room.mass_of
    assert [warning.filename for warning in told] == [__file__]
    with pytest.warns(DeprecationWarning, match=r"renaming_room\.Rubbing is now pinpress\.loads\.Friction"):
        assert room.Rubbing is pp.loads.Friction


def test_an_import_of_an_old_name_warns_at_the_importing_line(room) -> None:
    with pytest.warns(DeprecationWarning, match="weigh is now") as told:
        from renaming_room import weigh  # type: ignore[import-not-found]
    assert weigh is room.mass_of
    assert {warning.filename for warning in told} == {__file__}


def test_old_names_stand_in_no_list_and_names_of_today_do_not_warn(room) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert dir(room) == room.__all__ == ["mass_of"]
        assert room.mass_of("slide") == 2.0
        with pytest.raises(AttributeError, match="no_such_name"):
            _ = room.no_such_name


@pytest.mark.exhaustive
def test_type_checkers_know_old_names(room, tmp_path) -> None:
    Path(room.__file__ + "i").write_text(
        "from .masses import mass_of as mass_of\nweigh = mass_of\n", encoding="utf-8"
    )  # quick: no pinpress
    user = tmp_path / "user.py"
    user.write_text("import renaming_room as room\nreveal_type(room.weigh('slide'))\nroom.weight('slide')\n", encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--config-file=", "--follow-imports=silent", str(user)]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False).stdout
    assert 'Revealed type is "float"' in said or 'Revealed type is "builtins.float"' in said
    assert 'has no attribute "weight"' in said


def test_an_old_keyword_is_the_new_one_and_warns() -> None:
    @old_keywords(gone_in="0.5", weight="mass")
    def lifted(height: float, *, mass: float = 1.0) -> float:
        """Work against gravity."""
        return 9.81 * mass * height

    with pytest.warns(DeprecationWarning, match=r"^lifted: weight= is now mass=: write that; version 0\.5 has") as told:
        assert lifted(2.0, weight=3.0) == lifted(2.0, mass=3.0)  # type: ignore[call-arg]
    assert [warning.filename for warning in told] == [__file__]
    with pytest.raises(pp.PinpressError, match="weight= is the old name of mass=; give mass= alone"):
        lifted(2.0, weight=3.0, mass=3.0)  # type: ignore[call-arg]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert lifted(2.0) == 9.81 * 2.0
        with pytest.raises(TypeError, match="unexpected keyword argument 'width'"):
            lifted(2.0, width=3.0)  # type: ignore[call-arg]
    assert (lifted.__name__, lifted.__doc__) == ("lifted", "Work against gravity.")


def test_old_names_of_rooms_are_typed_and_none_is_past_its_end() -> None:
    rooms = old_names()
    assert overdue(rooms, pp.__version__) == []
    for room, names in rooms.items():
        stub = ROOT.parent / room.replace(".", "/")
        text = (stub / "__init__.pyi" if stub.is_dir() else stub.with_suffix(".pyi")).read_text(encoding="utf-8")
        assert untyped(names, text) == [], room


def test_what_is_past_its_end_or_without_a_type_is_found(room) -> None:
    names = room.__getattr__
    assert overdue({"room": names}, "0.4.9") == []
    assert overdue({"room": names}, "0.5.0") == overdue({"room": names}, "0.10") == ["room"]
    assert untyped(names, ROOM["__init__.pyi"]) == []
    assert untyped(names, "weigh = mass_of") == ["Rubbing"]
