"""The points of a sweep: axes of labelled values, all combinations or paired, and the comparison of two sweeps."""

import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.errors import PinpressError, shown

Scalar = float | int | bool | str
"""A value that a table can hold."""

RESERVED = ("point", "error", "checksum")  # names of other columns of a table
LONGEST = 10_000  # characters of a word in a table
LARGEST = 2**53  # largest whole number up to which a float holds all exactly


@dataclass(frozen=True, eq=False, repr=False)
class Grid:
    """Points of a sweep, numbered from 0; the last axis changes fastest.

    Attributes:
        axes: name -> labels of each axis, numbers or texts.
        objects: name -> arguments of the function: the objects of an axis that is a mapping, else the labels.
        paired: whether the axes are columns of equal length.
    """

    axes: Mapping[str, tuple[Scalar, ...]]
    objects: Mapping[str, tuple[object, ...]]
    paired: bool

    def __len__(self) -> int:
        return math.prod(self.shape)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes; (n,) if the axes are paired."""
        lengths = tuple(len(labels) for labels in self.axes.values())
        return lengths[:1] if self.paired else lengths

    def labels(self, number: int) -> tuple[Scalar, ...]:
        """The labels of a point, in the order of the axes."""
        return tuple(labels[k] for labels, k in zip(self.axes.values(), self._places(number), strict=True))

    def point(self, number: int) -> dict[str, object]:
        """The arguments of the function at a point."""
        return {name: objects[k] for (name, objects), k in zip(self.objects.items(), self._places(number), strict=True)}

    def columns(self) -> dict[str, NDArray[Any]]:
        """The labels of all n points, name of the axis -> (n,)."""
        labels = {name: as_array(labels) for name, labels in self.axes.items()}
        return self._at(labels, np.arange(len(self)))

    def arguments(self) -> Callable[[Sequence[int]], dict[str, NDArray[Any]]]:
        """A function of the numbers of m points that returns the arguments at them: name -> (m,) labels, or objects of a mapping."""
        arguments = {
            name: as_array(labels) if all(map(operator.is_, self.objects[name], labels)) else _as_objects(self.objects[name])
            for name, labels in self.axes.items()
        }
        return lambda numbers: self._at(arguments, np.asarray(numbers))

    def refuse_mixed_labels(self) -> None:
        """Raise PinpressError if the labels of an axis are of several kinds."""
        for name, labels in self.axes.items():
            if len({kind(label) for label in labels}) > 1:
                raise PinpressError(
                    f"grid: the labels of axis {shown(name)} are of several kinds: give only numbers, only bools or only texts"
                )

    def _at(self, axes: dict[str, NDArray[Any]], numbers: NDArray[np.intp]) -> dict[str, NDArray[Any]]:
        places = [numbers] * len(axes) if self.paired else np.unravel_index(numbers, self.shape)
        return {name: values[k] for (name, values), k in zip(axes.items(), places, strict=True)}

    def _places(self, number: int) -> list[int]:
        if self.paired:
            return [number] * len(self.axes)
        places = []
        for length in reversed(self.shape):
            number, place = divmod(number, length)
            places.append(place)
        return places[::-1]


def make_grid(grid: object, paired: bool) -> Grid:
    """A caller's grid; see `pinpress.sweeps.sweep`.

    Raises:
        PinpressError: the grid is not a mapping, an axis has no values, a value twice or a value that a table cannot hold, or paired axes
            differ in length.
    """
    if not isinstance(grid, Mapping) or not grid:
        raise PinpressError("grid: give a mapping of at least one argument's name to its values, {'speed': [...], 'force': [...]}")
    axes, objects = {}, {}
    for name, values in grid.items():
        if not isinstance(name, str) or not name or name in RESERVED:
            raise PinpressError(
                f"grid: {shown(name)} cannot be an axis; name an argument of the function, other than {', '.join(RESERVED)}"
            )
        axes[name], objects[name] = _axis(name, values)
        if not paired and len(set(axes[name])) < len(axes[name]):
            twice = next(label for k, label in enumerate(axes[name]) if label in axes[name][:k])
            raise PinpressError(f"grid: axis {shown(name)} has {shown(twice)} twice; give each value once")
    lengths = {name: len(labels) for name, labels in axes.items()}
    if paired and len(set(lengths.values())) > 1:
        raise PinpressError(f"grid: with paired=True all axes must be equally long, not {lengths}")
    return Grid(axes, objects, paired)


def scalar(value: object) -> Scalar:
    """A number, word or bool as Python's own type.

    Raises:
        ValueError: a table cannot hold the value; the message says why.
    """
    if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0):
        value = value.item()
    if isinstance(value, bool):
        return value
    if isinstance(value, str):
        if len(value) > LONGEST or "\0" in value or not _encodes(value):
            raise ValueError(f"a word of {len(value)} characters; a table takes {LONGEST} of UTF-8, none of them a null character")
        return str(value)
    if isinstance(value, int):
        if abs(value) > LARGEST:
            raise ValueError(f"{value:.3g}, a whole number too large to be kept exactly; give a float")
        return int(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{value}, which is not finite")
        return float(value)
    raise ValueError(f"a {type(value).__name__}, no number, word or bool")


def kind(value: Scalar) -> str:
    """The kind of a value: "bool", "word" or "number"."""
    return "bool" if isinstance(value, bool) else "word" if isinstance(value, str) else "number"


def list_kinds(kinds: Mapping[str, str]) -> str:
    """Names of results and kinds of their values, as text."""
    return ", ".join(f"{name} ({kind})" for name, kind in kinds.items())


def differences(before: Mapping[str, object], now: Mapping[str, object]) -> Iterator[str]:
    """The differences between two descriptions of sweeps, as text."""
    if before.get("function") != now["function"]:
        yield f"its function is {shown(before.get('function'))}, not {shown(now['function'])}"
    then, axes = before.get("axes"), now["axes"]
    assert isinstance(axes, dict)
    if not isinstance(then, dict) or list(then) != list(axes):
        yield f"its axes are {', '.join(then) if isinstance(then, dict) else then}, not {', '.join(axes)}"
        return
    if before.get("paired") != now["paired"]:
        yield "its axes run side by side" if before.get("paired") else "its axes are those of a full grid"
    for name, labels in axes.items():
        if len(then[name]) != len(labels):
            yield f"axis {shown(name)} has {len(then[name])} values, not {len(labels)}"
        for k, (old, new) in enumerate(zip(then[name], labels, strict=False)):
            if old != new or isinstance(old, bool) != isinstance(new, bool):
                yield f"value {k} of axis {shown(name)} is {shown(old)}, not {shown(new)}"
                break


def fingerprint(grid: Grid, function: str) -> dict[str, object]:
    """A description that identifies the sweep in all its runs, for JSON."""
    return {"function": function, "axes": {name: list(labels) for name, labels in grid.axes.items()}, "paired": grid.paired}


def _axis(name: str, values: object) -> tuple[tuple[Scalar, ...], tuple[object, ...]]:
    """Labels and objects of one axis; raises PinpressError as `make_grid`."""
    if isinstance(values, Mapping):
        labels, objects = list(values), tuple(values.values())
    elif isinstance(values, Sequence | np.ndarray) and not isinstance(values, str | bytes) and getattr(values, "ndim", 1) == 1:
        labels, objects = list(values), ()
    else:
        raise PinpressError(f"grid: axis {shown(name)} is {shown(values)}; give a sequence of values, or a mapping of labels to objects")
    if not labels:
        raise PinpressError(f"grid: axis {shown(name)} has no values; give at least one")
    kept = []
    for k, label in enumerate(labels):
        try:
            kept.append(scalar(label))
        except ValueError as error:
            raise PinpressError(
                f"grid: value {k} of axis {shown(name)} is {error}; give finite numbers or words, objects under labels: {{'label': object}}"
            ) from None
    return tuple(kept), objects or tuple(kept)


def as_array(labels: Sequence[Scalar]) -> NDArray[Any]:
    """Labels as an array; labels of different kinds as objects, because NumPy would turn all into words."""
    return np.array(labels) if len({kind(label) for label in labels}) == 1 else _as_objects(labels)


def _as_objects(objects: Sequence[object]) -> NDArray[Any]:
    array = np.empty(len(objects), dtype=object)  # one by one: NumPy would look into lists and arrays
    for k, item in enumerate(objects):
        array[k] = item
    return array


def _encodes(word: str) -> bool:
    try:
        word.encode()
    except UnicodeEncodeError:
        return False
    return True
