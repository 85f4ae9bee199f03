"""Names of rooms: where one is that is not there, and old names, which work, warn at the caller's line, and end."""

import importlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

import pinpress as pp

PACKAGE = Path(pp.__file__).resolve().parent
ROOM = {
    "__init__.py": """from pinpress.common.public_names import public_names
__getattr__, __dir__, __all__ = public_names(__name__, __file__, renamed={"weigh": "mass_of"}, gone_in="0.5")
""",
    "__init__.pyi": "from .masses import mass_of as mass_of\nweigh = mass_of\n",
    "masses.py": "def mass_of(name: str) -> float:\n    return 2.0\n",
}


@pytest.fixture
def room(tmp_path, monkeypatch):
    """A package `renaming_room` with an old name."""
    folder = tmp_path / "renaming_room"
    folder.mkdir()
    for name, text in ROOM.items():
        (folder / name).write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield importlib.import_module("renaming_room")
    for name in [name for name in sys.modules if name.split(".")[0] == "renaming_room"]:
        del sys.modules[name]


def overdue(texts: dict[str, str], today: str) -> list[str]:
    """Files of rooms whose old names should have gone."""

    def version(text: str) -> tuple[int, ...]:
        return tuple(int(number) for number in text.split("."))

    ends = {name: re.search(r'gone_in="([\d.]+)"', text) for name, text in texts.items()}
    return [name for name, end in ends.items() if end is not None and version(end[1]) <= version(today)]


def test_an_old_name_is_the_new_one_and_warns_at_the_callers_line(room) -> None:
    said = r"^renaming_room\.weigh is now renaming_room\.mass_of: write that; version 0\.5 has the old name no more$"
    with pytest.warns(DeprecationWarning, match=said) as told:
        assert room.weigh is room.mass_of
    with pytest.warns(DeprecationWarning, match=said) as told_of_import:
        from renaming_room import weigh  # type: ignore[import-not-found]
    assert weigh("crank") == 2.0
    assert {warning.filename for warning in (*told, *told_of_import)} == {__file__}  # an import asks twice
    assert room.__all__ == dir(room) == ["mass_of"]


def test_no_old_name_is_past_its_end() -> None:
    assert overdue({"room": ROOM["__init__.py"]}, "0.4.9") == []
    assert overdue({"room": ROOM["__init__.py"]}, "0.5.0") == ["room"]
    rooms = [stub.with_suffix(".py") for stub in PACKAGE.rglob("*.pyi")]
    assert len(rooms) > 15
    assert overdue({str(path): path.read_text(encoding="utf-8") for path in rooms}, pp.__version__) == []


@pytest.mark.parametrize(
    ("space", "name", "said"),
    [
        ("pinpress", "Flywheel", "pinpress has no 'Flywheel': it is pinpress.drives.Flywheel"),
        ("pinpress", "cycel", "pinpress has no 'cycel', did you mean 'cycle'?"),
        ("pinpress.loads", "blanking", "pinpress.loads has no 'blanking', did you mean 'Blanking'?"),
        ("pinpress.measures", "cycle", "pinpress.measures has no 'cycle': it is pinpress.cycle"),
        ("pinpress", "qqq", "pinpress has no 'qqq'"),
        ("pinpress", "__wrapped__", "pinpress has no '__wrapped__'"),
    ],
)
def test_a_name_that_is_not_there_is_told_where_it_is(space: str, name: str, said: str) -> None:
    with pytest.raises(AttributeError) as raised:
        getattr(importlib.import_module(space), name)
    assert str(raised.value) == said


def test_a_name_has_one_place_also_after_its_use() -> None:
    """lazy_loader puts what it has found into the package; names of `measures` and `video`, which are modules, came to be there."""
    code = "import pinpress as pp; pp.measures.duty_cycle; pp.video.film; print(hasattr(pp, 'duty_cycle'), hasattr(pp, 'film'))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False False\n"
