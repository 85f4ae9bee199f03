"""Results of a sweep as a Parquet file."""

import os
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..common import files
from ..common.errors import PinpressError
from .execution import Outcome
from .grid import Grid


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
    files.write(path, _content(columns))


def _content(columns: Mapping[str, Any]) -> bytes:
    pyarrow = installed()
    with pyarrow.BufferOutputStream() as stream:
        pyarrow.parquet.write_table(pyarrow.table({name: pyarrow.array(values) for name, values in columns.items()}), stream)
        content: bytes = stream.getvalue().to_pybytes()
    return content


def write(path: Path, grid: Grid, kinds: Mapping[str, str], found: Sequence[Outcome]) -> int:
    """Write outcomes, in their order. Returns the file's checksum."""
    labels = grid.columns()
    numbers = [outcome.number for outcome in found]
    columns: dict[str, Sequence[object]] = {"point": numbers}
    columns |= {name: [column[number] for number in numbers] for name, column in _alike(labels).items()}
    columns |= _alike({name: [outcome.values.get(name) for outcome in found] for name in kinds})
    content = _content(columns | {"error": [outcome.error for outcome in found]})
    files.write(path, content)
    return zlib.crc32(content)


def read(path: Path, kinds: Mapping[str, str], checksum: object) -> Iterator[Outcome]:
    """The outcomes in a file that `write` made, whose checksum it was.

    Raises:
        PinpressError: it cannot be read, or is not that file.
    """
    pyarrow = installed()
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PinpressError(f"cannot read {path}: {error.strerror}") from error
    if zlib.crc32(content) != checksum:
        raise PinpressError(
            f"{path} is damaged or was changed, its checksum does not fit: give another file, or delete it to have its points done anew"
        )
    columns = pyarrow.parquet.read_table(pyarrow.BufferReader(content)).to_pydict()
    for k, (number, words) in enumerate(zip(columns["point"], columns["error"], strict=True)):
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
