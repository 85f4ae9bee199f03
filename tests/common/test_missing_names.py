"""Names of rooms: the message of a name that is not there says where it is."""

import importlib
import subprocess
import sys

import pytest


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


@pytest.mark.exhaustive
def test_a_name_has_one_place_also_after_its_use() -> None:
    """lazy_loader puts what it has found into the package; names of `measures` and `video`, which are modules, came to be there."""
    code = "import pinpress as pp; pp.measures.duty_cycle; pp.video.film; print(hasattr(pp, 'duty_cycle'), hasattr(pp, 'film'))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False False\n"
