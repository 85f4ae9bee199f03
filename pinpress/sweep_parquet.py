"""Results of a sweep as a Parquet file."""

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from . import files
from .errors import PinpressError
from .sweep_grid import Grid
from .sweep_run import Outcome


def installed() -> Any:
    """pyarrow.

    Raises:
        PinpressError: it is not installed.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise PinpressError("pyarrow is not installed: pip install 'pinpress[sweeps]'") from None
    return pyarrow


def write_columns(path: str | os.PathLike[str], columns: Mapping[str, Any]) -> None:
    """Write columns (n,), numbers or words, None where there is no value, in one step.

    Raises:
        PinpressError: the file cannot be written, or pyarrow is not installed.
    """
    pyarrow = installed()
    with files.written(path) as part, files.refused(path):
        pyarrow.parquet.write_table(pyarrow.table({name: pyarrow.array(values) for name, values in columns.items()}), part)


def write(path: Path, grid: Grid, kinds: Mapping[str, str], found: Sequence[Outcome]) -> None:
    """Write outcomes, in their order."""
    labels = grid.columns()
    numbers = [outcome.number for outcome in found]
    columns: dict[str, Sequence[object]] = {"point": numbers}
    columns |= {name: [column[number] for number in numbers] for name, column in _alike(labels).items()}
    columns |= _alike({name: [outcome.values.get(name) for outcome in found] for name in kinds})
    write_columns(path, columns | {"error": [outcome.error for outcome in found]})


def read(path: Path, grid: Grid, kinds: Mapping[str, str]) -> Iterator[Outcome]:
    """The outcomes in a file that `write` made.

    Raises:
        PinpressError: it cannot be read, or is of another sweep.
    """
    pyarrow = installed()
    try:
        columns = pyarrow.parquet.read_table(path).to_pydict()
    except (OSError, pyarrow.ArrowException) as error:
        raise PinpressError(f"cannot read {path}: {error}; delete it to have its points done anew") from error
    if list(columns) != ["point", *grid.axes, *kinds, "error"]:
        raise PinpressError(f"{path}: its columns are not those of this sweep; give another file")
    labels = _alike(grid.columns())
    for k, (number, words) in enumerate(zip(columns["point"], columns["error"], strict=True)):
        if not 0 <= number < len(grid) or any(columns[name][k] != column[number] for name, column in labels.items()):
            raise PinpressError(f"{path}: row {k} is not of this sweep; give another file")
        yield Outcome(number, {} if words else {name: columns[name][k] for name in kinds}, words)


def _alike(columns: Mapping[str, Sequence[object]]) -> dict[str, Sequence[object]]:
    """Columns of one type each, as Parquet wants them: whole numbers beside others become floats, numbers beside words become words."""
    alike: dict[str, Sequence[object]] = {}
    for name, values in columns.items():
        types = {type(value) for value in values} - {type(None)}
        if len(types) > 1:
            to = float if types == {int, float} else str
            values = [None if value is None else to(value) for value in values]  # type: ignore[arg-type]
        alike[name] = values
    return alike
