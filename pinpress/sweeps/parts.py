"""A part of a large sweep: consecutive points, which travel to a worker as arrays and come back as the content of a Parquet file."""

from __future__ import annotations

import io
import operator
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.errors import PinpressError, shown
from .execution import Function, as_told, described, outcome, short
from .grid import LARGEST, RESERVED, Grid, Scalar, kind, listed, scalar

if TYPE_CHECKING:
    import pyarrow

Labels = NDArray[Any]

SWEEP, FAILED = b"pinpress_sweep", b"pinpress_failed"  # in the metadata of a part's file: checksum of its sweep, number of failed points
FIRST, LAST = "point", "error"  # columns before the labels and behind the results


class ClashError(Exception):
    """What the function returns makes no table; the text says why."""


class Part(NamedTuple):
    """A part as it comes back.

    Attributes:
        number: number of the part.
        content: its Parquet file; empty where there is none.
        kinds: name of a result -> "number", "bool" or "word"; empty where no point has succeeded.
        failed: number of points that failed.
        clash: why there is no file: what the function returned makes no table. Empty also where the part ended its process.
    """

    number: int
    content: bytes
    kinds: dict[str, str]
    failed: int
    clash: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class Points:
    """n consecutive points of a sweep.

    Attributes:
        first: number of the first one.
        labels: name of an axis -> (n,) labels.
        objects: name of an axis that was given as a mapping -> (n,) objects.
    """

    first: int
    labels: Mapping[str, Labels]
    objects: Mapping[str, Labels]

    def __len__(self) -> int:
        return len(next(iter(self.labels.values())))

    @property
    def arguments(self) -> dict[str, Labels]:
        """The arguments of a function that takes all points at once: copies, which it may change."""
        return {name: each.copy() for name, each in {**self.labels, **self.objects}.items()}

    def point(self, k: int) -> dict[str, object]:
        """The arguments of a function of one point, the k-th of these."""
        return {name: self.objects[name][k] if name in self.objects else labels[k].item() for name, labels in self.labels.items()}

    def between(self, start: int, stop: int) -> Points:
        """Some of these points."""
        labels, objects = ({name: each[start:stop] for name, each in columns.items()} for columns in (self.labels, self.objects))
        return Points(self.first + start, labels, objects)


@dataclass(frozen=True, eq=False, repr=False)
class Stretch:
    """Consecutive points as they travel to a worker: by their columns, or by the axes of the grid where these are shorter.

    Attributes:
        first: number of the first one.
        count: how many there are.
        labels: name of an axis -> its labels, of all places where there is a ``shape``, else of these points.
        objects: the same of the objects of axes that were given as mappings.
        shape: lengths of the axes; None where labels and objects are columns.
    """

    first: int
    count: int
    labels: Mapping[str, Labels]
    objects: Mapping[str, Labels]
    shape: tuple[int, ...] | None

    def points(self) -> Points:
        """The points."""
        if self.shape is None:
            return Points(self.first, self.labels, self.objects)
        places = np.unravel_index(np.arange(self.first, self.first + self.count), self.shape)
        where = dict(zip(self.labels, places, strict=True))
        labels, objects = ({name: each[where[name]] for name, each in columns.items()} for columns in (self.labels, self.objects))
        return Points(self.first, labels, objects)


class Division:
    """The points of a grid, divided into parts of equal length; the last one may be shorter.

    Attributes:
        grid: the grid.
        length: points of a part.
    """

    def __init__(self, grid: Grid, length: int) -> None:
        """Raises PinpressError where the labels of an axis are of several kinds."""
        self.grid, self.length = grid, length
        self._labels = {name: _labels(name, labels) for name, labels in grid.axes.items()}
        self._objects = {
            name: _objects(objects) for name, objects in grid.objects.items() if not all(map(operator.is_, objects, grid.axes[name]))
        }

    def __len__(self) -> int:
        """The number of parts."""
        return -(-len(self.grid) // self.length)

    def size(self, part: int) -> int:
        """The number of points of a part."""
        return min(self.length, len(self.grid) - part * self.length)

    def stretch(self, part: int) -> Stretch:
        """The points of a part."""
        first, count = part * self.length, self.size(part)
        if self.grid.paired:
            every = Points(0, self._labels, self._objects).between(first, first + count)
            return Stretch(first, count, every.labels, every.objects, None)
        whole = Stretch(first, count, self._labels, self._objects, self.grid.shape)
        if sum(self.grid.shape) <= count * len(self.grid.shape):
            return whole
        points = whole.points()
        return Stretch(first, count, points.labels, points.objects, None)


class Found(NamedTuple):
    """What a function gives at n points.

    Attributes:
        values: name of a result -> (n,) numbers as floats, bools, or words as objects; fillers where it failed. Empty where all failed.
        errors: n errors, empty where it succeeded.
    """

    values: Mapping[str, NDArray[Any]]
    errors: Sequence[str]

    @property
    def kinds(self) -> dict[str, str]:
        return {name: {"f": "number", "b": "bool", "O": "word"}[values.dtype.kind] for name, values in self.values.items()}


def computed(function: Function, at_once: bool, sweep: str, number: int, stretch: Stretch) -> Part:
    """One part, in the process of a worker.

    Args:
        function: the function of the sweep.
        at_once: whether it takes all points at once.
        sweep: checksum of the sweep's description.
        number: number of the part.
        stretch: its points.
    """
    points = stretch.points()
    try:
        return encoded(number, points, (found_at_once if at_once else found_one_by_one)(function, points), sweep)
    except ClashError as error:
        return Part(number, b"", {}, 0, str(error))


def encoded(number: int, points: Points, found: Found, sweep: str) -> Part:
    """A part from what was found at its points."""
    import pyarrow  # optional, and slow to import

    failed = np.array([bool(error) for error in found.errors])
    columns = {FIRST: pyarrow.array(np.arange(points.first, points.first + len(points))), **points.labels}
    columns |= {
        name: pyarrow.array(values, pyarrow.string() if values.dtype == object else None, mask=failed)
        for name, values in found.values.items()
    }
    columns[LAST] = pyarrow.array(found.errors, pyarrow.string())
    count = int(failed.sum())
    table = pyarrow.table(columns).replace_schema_metadata({SWEEP: sweep, FAILED: str(count)})
    return Part(number, content_of(table), found.kinds, count)


def content_of(table: pyarrow.Table) -> bytes:
    """A table as a Parquet file. Floats as they are: hardly two are equal, which dictionaries would look for."""
    import pyarrow.parquet  # optional, and slow to import

    words = [field.name for field in table.schema if pyarrow.types.is_string(field.type)]
    with io.BytesIO() as stream:
        pyarrow.parquet.write_table(table, stream, compression="zstd", use_dictionary=words, write_page_checksum=True)
        return stream.getvalue()


def completed(part: Part, kinds: Mapping[str, str]) -> bytes:
    """The file of a part with the columns of these results in their order; null where it has none, as all its points failed."""
    if list(part.kinds) == list(kinds):
        return part.content
    import pyarrow.parquet  # optional, and slow to import

    table = pyarrow.parquet.read_table(pyarrow.BufferReader(part.content))
    types = {"number": pyarrow.float64(), "bool": pyarrow.bool_(), "word": pyarrow.string()}
    columns = {name: table[name] for name in table.column_names if name not in kinds and name != LAST}
    columns |= {name: table[name] if name in part.kinds else pyarrow.nulls(len(table), types[kind]) for name, kind in kinds.items()}
    return content_of(pyarrow.table({**columns, LAST: table[LAST]}, metadata=table.schema.metadata))


def found_one_by_one(function: Function, points: Points) -> Found:
    """What a function of one point gives at several.

    Raises:
        ClashError: it returns other names or kinds of values at some points than at others.
    """
    outcomes = [outcome(function, points.first + k, points.point(k)) for k in range(len(points))]
    good = [found.values for found in outcomes if not found.error]
    if not good:
        return Found({}, [found.error for found in outcomes])
    kinds = {name: kind(value) for name, value in good[0].items()}
    for found in outcomes:
        if not found.error and (other := {name: kind(value) for name, value in found.values.items()}) != kinds:
            raise ClashError(
                f"the function returned {listed(other)} at {points.point(found.number - points.first)}, but {listed(kinds)} before:"
                " return the same names with values of the same kind at every point"
            )
    _refuse_axes(kinds, points)
    values = {name: _filled([found.values.get(name) for found in outcomes], each) for name, each in kinds.items()}
    return Found(values, [found.error for found in outcomes])


def found_at_once(function: Function, points: Points) -> Found:
    """What a function of many points gives. Where it raises, halves of the points are tried, down to those at which it raises.

    Raises:
        ClashError: it returns anything but columns of as many values as there are points, or other ones for some points than for others.
    """
    try:
        returned = function(**points.arguments)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # after any error, SystemExit too, the other points go on
        if len(points) == 1:
            return Found({}, [described(error)])
        half = len(points) // 2
        return joined([found_at_once(function, points.between(start, stop)) for start, stop in ((0, half), (half, len(points)))])
    return _checked(returned, points)


def joined(pieces: Sequence[Found]) -> Found:
    """What was found at points of one piece after the other.

    Raises:
        ClashError: pieces have other results than others.
    """
    kinds = next((piece.kinds for piece in pieces if piece.values), {})
    for piece in pieces:
        if piece.values and piece.kinds != kinds:
            raise ClashError(
                f"the function returned {listed(piece.kinds)} at some points, but {listed(kinds)} at others: return the same names with"
                " values of the same kind at every point"
            )
    values = {
        name: np.concatenate([piece.values[name] if piece.values else _filled([None] * len(piece.errors), each) for piece in pieces])
        for name, each in kinds.items()
    }
    return Found(values, [error for piece in pieces for error in piece.errors])


def _checked(returned: object, points: Points) -> Found:
    """What a function of many points has returned; raises ClashError where that makes no table."""
    if not isinstance(returned, Mapping) or not returned:
        raise ClashError(
            f"the function returned {short(returned)}; return a mapping of names to a value for each point, {{'peak_torque': [1.0, 2.0]}}"
        )
    errors = _errors(returned.get(LAST), len(points))
    values = {}
    for name, column in returned.items():
        if name == LAST:
            continue
        if not isinstance(name, str) or not name or name in RESERVED or as_told(name) != name:
            raise ClashError(f"the function returned values under {shown(name)}; name them by a word other than {', '.join(RESERVED)}")
        values[name], wrong = _column(name, column, len(points))
        for k, why in wrong.items():
            errors[k] = errors[k] or f"ValueError: the function returned under {shown(name)} {why}"
    _refuse_axes(values, points)
    if all(errors):
        return Found({}, errors)
    if not values:
        raise ClashError("the function returned errors alone, though some points have none; return values of these")
    return Found(values, errors)


def _errors(column: object, count: int) -> list[str]:
    """The errors that a function of many points has returned: for each point None, a word or an exception."""
    if column is None:
        return [""] * count
    if isinstance(column, str) or not isinstance(column, Iterable) or len(given := list(column)) != count:
        raise ClashError(f"the function returned {short(column)} under 'error'; return for each of the {count} points None or an error")
    return [described(error) if isinstance(error, BaseException) else "" if error is None else as_told(str(error)) for error in given]


def _column(name: str, column: object, count: int) -> tuple[NDArray[Any], dict[int, str]]:
    """Values of a result (count,) as floats, bools or words, and what is wrong with some of them."""
    if not isinstance(column, np.ndarray) or column.dtype.kind not in "biuf":
        return _listed_column(name, column, count)
    _refuse_shape(name, column.shape, count)
    wrong = {int(k): "no value, as it is masked" for k in np.flatnonzero(np.ma.getmaskarray(column))}
    values = np.array(column)
    if values.dtype.kind in "iu":
        too_large = (values > LARGEST) | (values < -LARGEST)
        wrong |= {int(k): f"{values[k]}, a whole number too large to be kept exactly; give a float" for k in np.flatnonzero(too_large)}
    if values.dtype.kind != "b":
        values = values.astype(float)
        wrong |= {int(k): f"{values[k]}, which is not finite" for k in np.flatnonzero(~np.isfinite(values)) if int(k) not in wrong}
    return values, wrong


def _listed_column(name: str, column: object, count: int) -> tuple[NDArray[Any], dict[int, str]]:
    """The same of a list, or an array of words or objects."""
    if isinstance(column, str | Mapping) or not isinstance(column, Iterable):
        raise ClashError(f"the function returned {short(column)} under {shown(name)}; return one value for each of the {count} points")
    given = list(column)
    _refuse_shape(name, (len(given),), count)
    values: list[Scalar | None] = [None] * count
    wrong = {}
    for k, each in enumerate(given):
        try:
            values[k] = scalar(each)
        except ValueError as error:
            wrong[k] = str(error)
    kinds = sorted({kind(value) for value in values if value is not None}) or ["number"]
    if len(kinds) > 1:
        raise ClashError(f"the function returned {'s and '.join(kinds)}s under {shown(name)}; return values of one kind")
    return _filled(values, kinds[0]), wrong


def _refuse_shape(name: str, shape: tuple[int, ...], count: int) -> None:
    if shape != (count,):
        raise ClashError(f"the function returned values of shape {shape} under {shown(name)}; return one for each of the {count} points")


def _refuse_axes(names: Iterable[str], points: Points) -> None:
    if taken := [name for name in names if name in points.labels]:
        raise ClashError(f"the function returns {shown(taken[0])}, which is the name of an axis: give the result another name")


def _filled(values: Sequence[Scalar | None], kind: str) -> NDArray[Any]:
    """Values of one kind as an array, with fillers for None."""
    filler, dtype = {"number": (0.0, float), "bool": (False, bool), "word": ("", object)}[kind]
    return np.array([filler if value is None else value for value in values], dtype=dtype)


def _labels(name: str, labels: Sequence[Scalar]) -> Labels:
    """Labels as an array of whole numbers, floats, bools or words."""
    if as_told(name) != name:
        raise PinpressError(f"grid: a file cannot have the name {shown(name)} of an axis: give it another one")
    if len({kind(label) for label in labels}) > 1:
        raise PinpressError(f"grid: the labels of axis {shown(name)} are of several kinds: give numbers alone, bools alone or words alone")
    return np.array(labels)


def _objects(objects: Sequence[object]) -> Labels:
    found = np.empty(len(objects), dtype=object)  # one by one: NumPy would look into lists and arrays
    for k, each in enumerate(objects):
        found[k] = each
    return found
