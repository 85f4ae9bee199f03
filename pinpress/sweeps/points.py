"""The job of a worker: call a function at points of a sweep, one at a time or many at once, and return its results as columns."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.errors import shown
from .grid import LARGEST, LONGEST, RESERVED, Scalar, kind, list_kinds, scalar

Function = Callable[..., Mapping[str, object]]
Values = NDArray[Any]

ERROR = "error"  # name under which a function of many points returns the errors of those that failed
KILLS = (
    "BrokenProcessPool: the function ends the process that it runs in, by os._exit, a crash of compiled code, or because it takes too much"
    " memory"
)


class Results(NamedTuple):
    """Results at n points.

    Attributes:
        numbers: n numbers of the points.
        errors: n errors: type and text of the exception; empty where the function succeeded.
        kinds: name of a result -> "number", "bool" or "word"; empty where all points failed.
        columns: n values of every result, in the order of ``kinds``; fillers where a point failed.
        clash: why the results make no table; empty if they make one.
    """

    numbers: Sequence[int]
    errors: Sequence[str]
    kinds: Mapping[str, str]
    columns: Sequence[Sequence[Scalar] | Values]
    clash: str = ""


class ClashError(Exception):
    """The values that the function returned make no table; the text says why."""


def call_at_point(function: Function, number: int, point: Mapping[str, object]) -> Results:
    """The function at one point."""
    try:
        values = _check(function(**point))
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # after any error, SystemExit too, the other points go on
        return fail([number], describe(error))
    return Results([number], [""], {name: kind(value) for name, value in values.items()}, [[value] for value in values.values()])


def call_at_points(function: Function, _part: int, points: tuple[Sequence[int], Mapping[str, Values]]) -> Results:
    """The function at m points, given by their numbers and arguments (m,). If it raises, halves of the points are tried, until only the
    points that raise remain."""
    try:
        return _call_by_halves(function, *points)
    except ClashError as error:
        return Results([], [], {}, [], str(error))


def fail(numbers: Sequence[int], error: str) -> Results:
    """Points that all failed."""
    return Results(numbers, [error] * len(numbers), {}, [])


def describe(error: BaseException) -> str:
    """Type and text of an exception for a table."""
    try:
        text = str(error)
    except Exception as second:
        text = f"its text cannot be had ({type(second).__name__})"
    return storable(f"{type(error).__name__}: {text}")


def storable(text: str) -> str:
    """A text that a table can hold: UTF-8 without null characters, and not too long."""
    return text.encode("utf-8", "backslashreplace").decode().replace("\0", "\\0")[:LONGEST]


def _check(returned: object) -> dict[str, Scalar]:
    """The values that the function returned, for a table.

    Raises:
        TypeError: it returned no mapping of names to values.
        ValueError: a table cannot hold a value.
    """
    if not isinstance(returned, Mapping) or not returned:
        raise TypeError(f"the function returned {_short(returned)}; return a mapping of names to numbers, {{'peak_torque': 1.0}}")
    values = {}
    for name, value in returned.items():
        if not isinstance(name, str) or not name or name in RESERVED:
            raise TypeError(f"the function returned a value under {shown(name)}; name it by a word other than {', '.join(RESERVED)}")
        try:
            scalar(name)
            values[name] = scalar(value)
        except ValueError as error:
            raise ValueError(f"the function returned under {shown(name)} {error}") from None
    return values


def _call_by_halves(function: Function, numbers: Sequence[int], arguments: Mapping[str, Values]) -> Results:
    """The function at all these points at once; if it raises, at both halves of them."""
    try:
        returned = function(**{name: values.copy() for name, values in arguments.items()})  # copies, which it may change
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # as in `call_at_point`
        if len(numbers) == 1:
            return fail(numbers, describe(error))
        half = len(numbers) // 2
        return _join(
            *(
                _call_by_halves(function, numbers[part], {name: values[part] for name, values in arguments.items()})
                for part in (slice(half), slice(half, None))
            )
        )
    return _columns_of(returned, numbers, arguments)


def _join(first: Results, second: Results) -> Results:
    """Results at two groups of points as one.

    Raises:
        ClashError: the groups differ in their results.
    """
    numbers, errors = [*first.numbers, *second.numbers], [*first.errors, *second.errors]
    kinds = first.kinds or second.kinds
    for half in (first, second):
        if half.kinds and half.kinds != kinds:
            raise ClashError(
                f"the function returned {list_kinds(half.kinds)} at some points, but {list_kinds(kinds)} at others: return the same"
                " names with values of the same kind at every point"
            )
    halves = [
        dict(zip(half.kinds, half.columns, strict=True)) or {name: _fill([None] * len(half.numbers), each) for name, each in kinds.items()}
        for half in (first, second)
    ]
    return Results(numbers, errors, kinds, [np.concatenate([half[name] for half in halves]) for name in kinds])


def _columns_of(returned: object, numbers: Sequence[int], arguments: Mapping[str, Values]) -> Results:
    """The values that a function of many points returned; raises ClashError if they make no table."""
    if not isinstance(returned, Mapping) or not returned:
        raise ClashError(
            f"the function returned {_short(returned)}; return a mapping of names to a value for each point, {{'peak_torque': [1.0, 2.0]}}"
        )
    errors = _errors(returned.get(ERROR), len(numbers))
    columns = {}
    for name, column in returned.items():
        if name == ERROR:
            continue
        if not isinstance(name, str) or not name or name in RESERVED or storable(name) != name:
            raise ClashError(f"the function returned values under {shown(name)}; name them by a word other than {', '.join(RESERVED)}")
        if name in arguments:
            raise ClashError(axis_name_taken(name))
        columns[name], faults = _column(name, column, len(numbers))
        for k, fault in faults.items():
            errors[k] = errors[k] or f"ValueError: the function returned under {shown(name)} {fault}"
    if all(errors):
        return Results(numbers, errors, {}, [])
    if not columns:
        raise ClashError("the function returned only errors, but some points have no error; return values for these points")
    kinds = {name: {"f": "number", "b": "bool", "O": "word"}[values.dtype.kind] for name, values in columns.items()}
    return Results(numbers, errors, kinds, list(columns.values()))


def axis_name_taken(name: str) -> str:
    """Message for a result with the name of an axis."""
    return f"the function returns {shown(name)}, which is the name of an axis: give the result another name"


def _errors(column: object, count: int) -> list[str]:
    """The errors that a function of many points returned: None, a word or an exception for each point."""
    if column is None:
        return [""] * count
    if isinstance(column, str) or not isinstance(column, Iterable) or len(errors := list(column)) != count:
        raise ClashError(f"the function returned {_short(column)} under 'error'; return for each of the {count} points None or an error")
    return [describe(error) if isinstance(error, BaseException) else "" if error is None else storable(str(error)) for error in errors]


def _column(name: str, column: object, count: int) -> tuple[Values, dict[int, str]]:
    """Values of a result (count,) as floats, bools or words, and the faults of values that a table cannot hold."""
    if not isinstance(column, np.ndarray) or column.dtype.kind not in "biuf":
        return _listed_column(name, column, count)
    _refuse_shape(name, column.shape, count)
    faults = {int(k): "no value, as it is masked" for k in np.flatnonzero(np.ma.getmaskarray(column))}
    values = np.array(column)
    if values.dtype.kind in "iu":
        too_large = (values > LARGEST) | (values < -LARGEST)
        faults |= {int(k): f"{values[k]}, a whole number too large to be kept exactly; give a float" for k in np.flatnonzero(too_large)}
    if values.dtype.kind != "b":
        values = values.astype(float)
        faults |= {int(k): f"{values[k]}, which is not finite" for k in np.flatnonzero(~np.isfinite(values)) if int(k) not in faults}
    return values, faults


def _listed_column(name: str, column: object, count: int) -> tuple[Values, dict[int, str]]:
    """As `_column`, for a list or an array of words or objects."""
    if isinstance(column, str | Mapping) or not isinstance(column, Iterable):
        raise ClashError(f"the function returned {_short(column)} under {shown(name)}; return one value for each of the {count} points")
    items = list(column)
    _refuse_shape(name, (len(items),), count)
    values: list[Scalar | None] = [None] * count
    faults = {}
    for k, item in enumerate(items):
        try:
            values[k] = scalar(item)
        except ValueError as error:
            faults[k] = str(error)
    kinds = sorted({kind(value) for value in values if value is not None}) or ["number"]
    if len(kinds) > 1:
        raise ClashError(f"the function returned {'s and '.join(kinds)}s under {shown(name)}; return values of one kind")
    return _fill(values, kinds[0]), faults


def _refuse_shape(name: str, shape: tuple[int, ...], count: int) -> None:
    if shape != (count,):
        raise ClashError(f"the function returned values of shape {shape} under {shown(name)}; return one for each of the {count} points")


def _fill(values: Sequence[Scalar | None], kind: str) -> Values:
    """Values of one kind as an array, with fillers for None."""
    filler, dtype = {"number": (0.0, float), "bool": (False, bool), "word": ("", object)}[kind]
    return np.array([filler if value is None else value for value in values], dtype=dtype)


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
