"""The folder of a large sweep: a Parquet file for each finished part, and beside them a description of the sweep.

Each part is written whole or not at all, so that a kill at any instant leaves finished parts and nothing else. A part's metadata have the
checksum of the description, so that a file of another sweep is noticed. The description's name begins with a line: readers of Parquet
pass it over.
"""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..common import files
from ..common.errors import PinpressError, shown
from .grid import Scalar, differences, fingerprint, listed
from .parts import FAILED, FIRST, LAST, SWEEP, Division, Part, completed

if TYPE_CHECKING:
    from pyarrow.parquet import FileMetaData

DESCRIPTION = "_sweep.json"
MOST_LISTED = 10_000  # labels of an axis in the description; of more there is a checksum
LARGEST_DESCRIPTION = 100_000_000  # bytes


class PartFolder:
    """The parts of a sweep that are finished; `part_folder` opens it.

    Attributes:
        path: the folder.
        known: number of a part that is finished -> how many of its points failed.
        kinds: name of a result -> "number", "bool" or "word", for all parts; empty until a point has succeeded.
        points: number of points of these parts.
        checksum: of the description.
    """

    def __init__(self, path: Path, description: Mapping[str, Any], division: Division) -> None:
        """Read what is there; raises as `part_folder`."""
        self.path, self._division = path, division
        self.checksum = _checksum(json.dumps(description))
        self.known: dict[int, int] = {}
        self.points = 0
        self.kinds: dict[str, str] = {}
        self._held: list[Part] = []  # parts without a point that succeeded, until it is known what the results are
        for number, file in parts_in(path):
            metadata = footer(file)
            self._check(number, file, metadata)
            self._take(Part(number, b"", _kinds(metadata, division), int(metadata.metadata[FAILED])), file)

    def add(self, part: Part) -> None:
        """Write a part.

        Raises:
            PinpressError: its results have other names or kinds than those of other parts, or the file cannot be written.
        """
        if part.clash:
            raise PinpressError(part.clash)
        self._take(part, None)
        if self.kinds:
            self.write_held()

    def _take(self, part: Part, file: Path | None) -> None:
        """Note a part, and hold it where its results are not in a file yet; ``file``: where it is from."""
        if part.kinds and not self.kinds:
            self.kinds = part.kinds
        elif part.kinds and part.kinds != self.kinds:
            raise PinpressError(
                f"the function returned {listed(part.kinds)} in part {part.number}{f' ({file})' if file else ''}, but {listed(self.kinds)}"
                " in others: return the same names with values of the same kind at every point"
            )
        self.known[part.number] = part.failed
        self.points += self._division.size(part.number)
        if file is None:
            self._held.append(part)
        elif not part.kinds:
            self._held.append(part._replace(content=file.read_bytes()))

    def write_held(self) -> None:
        """Write the parts that are held; without columns of results where no point has succeeded, until one does."""
        while self._held:
            part = self._held.pop()
            files.write(file_of(self.path, part.number), completed(part, self.kinds))

    def _check(self, number: int, file: Path, metadata: FileMetaData) -> None:
        """Raise PinpressError where a file is no part of this sweep."""
        given = metadata.metadata or {}
        if number >= len(self._division) or given.get(SWEEP) != self.checksum.encode() or not given.get(FAILED, b"").isdigit():
            raise PinpressError(f"{file} is no part of this sweep, as its metadata say: move it out of the folder")
        if metadata.num_rows != self._division.size(number):
            raise PinpressError(
                f"{file} has {metadata.num_rows} points, not {self._division.size(number)}: delete it, and it is done again"
            )


def part_folder(path: Path, function: str, at_once: bool, division: Division) -> PartFolder:
    """Open the folder of a sweep, or make it.

    Args:
        path: the folder.
        function: name of the function.
        at_once: whether it takes all points of a part at once.
        division: the parts of the sweep.

    Raises:
        PinpressError: the folder cannot be made, is of another sweep, has other files, or one of its parts is damaged.
    """
    axes = {name: _listed_labels(labels) for name, labels in division.grid.axes.items()}
    description = {**fingerprint(division.grid, function), "axes": axes, "points_a_part": division.length, "at_once": at_once}
    file = path / DESCRIPTION
    if path.suffix.lower() in (".sqlite", ".db", ".csv", ".mat"):
        raise PinpressError(
            f"{path} is the name of a file, but this sweep is written to a folder of Parquet files: give a name without {path.suffix}"
        )
    with files.refused(path):
        there = sorted(each.name for each in path.iterdir()) if path.exists() else []
    if DESCRIPTION in there:
        _refuse_another(path, file, description)
    elif there:
        raise PinpressError(f"{path} has other files in it, such as {there[0]}: give a folder of its own for each sweep")
    else:
        with files.refused(path):
            path.mkdir(exist_ok=True)
        files.write(file, json.dumps(description).encode())
    return PartFolder(path, description, division)


def file_of(folder: Path, number: int) -> Path:
    """The file of a part."""
    return folder / f"part-{number:06}.parquet"


def parts_in(folder: Path) -> Iterator[tuple[int, Path]]:
    """Numbers and files of the parts in a folder, in order; none where there is no folder."""
    there = folder.iterdir() if folder.is_dir() else ()
    named = ((re.fullmatch(r"part-(\d{6,})\.parquet", file.name), file) for file in there)
    yield from sorted((int(name[1]), file) for name, file in named if name)


def footer(file: Path) -> FileMetaData:
    """The metadata of a part's file.

    Raises:
        PinpressError: it cannot be read, or is no Parquet file.
    """
    import pyarrow  # optional, and slow to import
    import pyarrow.parquet

    try:
        return pyarrow.parquet.read_metadata(file)
    except (OSError, pyarrow.ArrowException) as error:
        raise damaged(file, error) from error


def damaged(file: Path, error: Exception) -> PinpressError:
    """The error of a part that cannot be read."""
    return PinpressError(
        f"{file} is damaged ({' '.join(str(error).split())}): delete it, and call the sweep again, which does its points again"
    )


def _refuse_another(path: Path, file: Path, description: Mapping[str, Any]) -> None:
    """Raise PinpressError where the description in a folder is not this one."""
    try:
        before = json.loads(files.read(file, LARGEST_DESCRIPTION))
        if not isinstance(before, dict):
            raise ValueError("it is no mapping")
    except (OSError, ValueError) as error:
        raise PinpressError(
            f"{file} is damaged, or no description of a sweep ({error}): give another folder, or delete this one"
        ) from error
    if before == description:
        return
    found = list(differences(before, description)) if isinstance(before.get("axes"), dict) else []
    found += [
        f"its {name} is {shown(before.get(name))}, not {description[name]}"
        for name in ("points_a_part", "at_once")
        if before.get(name) != description[name]
    ]
    differ = "; ".join(found) or "its description is another one"
    raise PinpressError(f"{path} is of another sweep: {differ}. Give another folder, or repeat the sweep that it is of")


def _listed_labels(labels: tuple[Scalar, ...]) -> list[Scalar]:
    """The labels of an axis for the description: all, or of very many their checksum."""
    return [*labels] if len(labels) <= MOST_LISTED else [f"{len(labels)} labels with the checksum {_checksum(repr(labels))}"]


def _kinds(metadata: FileMetaData, division: Division) -> dict[str, str]:
    """Names and kinds of the results in a part's file."""
    kinds = {"double": "number", "bool": "bool", "string": "word"}
    schema = metadata.schema.to_arrow_schema()
    return {field.name: kinds[str(field.type)] for field in schema if field.name not in (FIRST, LAST, *division.grid.axes)}


def _checksum(text: str) -> str:
    return f"{zlib.crc32(text.encode()):08x}"
