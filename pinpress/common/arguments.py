"""Checks of arguments: objects of the library, sequences, mappings, functions, True or False by the annotations of a public function
(`typed`); one number, a whole number or an array of numbers where the function asks.

NumPy takes for numbers what was hardly meant as such: it drops masks and imaginary parts, reads texts, dates and truth values, and turns
None into nan. Here all these are refused, by the name of the argument.
"""

import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from numbers import Real
from typing import Any, NamedTuple, TypeGuard, TypeVar, get_origin

import numpy as np

from .errors import PinpressError, shown
from .quantities import Array

Function = TypeVar("Function", bound=Callable[..., Any])

MAKERS = {
    "Linkage": "load",
    "Motion": "cycle or simulate",
    "Reactions": "inverse_dynamics",
    "Run": "simulate",
    "Stiffness": "Stiffness",
    "Capacities": "Capacities",
    "Guide": "Guide(length, width)",
    "SlideCompliance": "compliance",
    "PressRatings": "rate",
    "WorkPrecision": "accuracy.compare",
    "Flywheel": "Flywheel",
    "MountedPress": "mounted",
    "Frame": "Frame",
    "RubberPad": "RubberPad",
}
"""Classes whose objects are checked, and what makes them."""

_OTHERS: dict[str, Callable[[Any], bool]] = {
    "None": lambda value: value is None,
    "Sequence": lambda value: isinstance(value, Iterable) and not isinstance(value, str | bytes | Mapping | type),
    "Mapping": lambda value: isinstance(value, Mapping),
    "bool": lambda value: isinstance(value, bool | np.bool_),
    "Callable": lambda value: callable(value) and not isinstance(value, type),
}
_OTHERS["Iterable"] = _OTHERS["Sequence"]


class _Kind(NamedTuple):
    """What a parameter takes: names of the library's classes, and of what else may be given."""

    classes: tuple[str, ...]
    others: tuple[str, ...]


def typed(function: Function) -> Function:
    """A function that raises PinpressError where an argument is nothing of what its parameter is annotated with.

    Numbers, texts and users' own laws are checked where they are used.
    """
    parameters = inspect.signature(function).parameters
    kinds = {name: kind for name, parameter in parameters.items() if (kind := _kind(_evaluated(parameter.annotation, function)))}
    places = [(place, name) for place, name in enumerate(parameters) if name in kinds]

    @wraps(function)
    def with_checks(*given: Any, **named: Any) -> Any:
        for place, name in places:
            if place < len(given):
                _check(name, given[place], kinds[name])
            elif name in named:
                _check(name, named[name], kinds[name])
        return function(*given, **named)

    return with_checks  # type: ignore[return-value]


def expect(name: str, value: object, kind: type, maker: str) -> None:
    """Raise PinpressError where an argument is of another kind than it must be; ``maker``: what makes one."""
    if not isinstance(value, kind):
        raise PinpressError(f"{name} is a {type(value).__name__}, no {kind.__name__}: give what {maker} returns")


def _evaluated(annotation: object, function: Callable[..., Any]) -> object:
    """What an annotation means that is kept as it is written; its text where a name in it is there for type checkers alone."""
    if not isinstance(annotation, str):
        return annotation
    try:
        return eval(annotation, getattr(function, "__globals__", {}))
    except NameError:
        return annotation


def _kind(annotation: object) -> _Kind | None:
    """What an annotation asks for; None where it names something that is not looked into here."""
    # Python 3.10 takes Sequence[float] for a class.
    text = annotation.__name__ if isinstance(annotation, type) and get_origin(annotation) is None else str(annotation)
    if "Sequence[float]" in text:
        return None  # a vector
    while "[" in text:
        text = re.sub(r"\[[^\[\]]*\]", "", text)
    names = [name.strip().rpartition(".")[2] for name in text.split("|")]
    classes = tuple(name for name in names if name in MAKERS)
    others = tuple(name for name in names if name in _OTHERS)
    return _Kind(classes, others) if len(classes) + len(others) == len(names) else None


def _check(name: str, value: object, kind: _Kind) -> None:
    for one in type(value).__mro__:
        if one.__name__ in kind.classes and one.__module__.startswith("pinpress."):
            return
    if any(_OTHERS[other](value) for other in kind.others):
        return
    given = "a class" if isinstance(value, type) else f"a {type(value).__name__}"
    if kind.classes:
        raise PinpressError(f"{name} is {given}, no {kind.classes[0]}: give what {MAKERS[kind.classes[0]]} returns")
    if "bool" in kind.others:
        raise PinpressError(f"{name} is {shown(value)}: give True or False")
    if "Callable" in kind.others:
        raise PinpressError(f"{name} is {shown(value)}: give a function")
    if "Mapping" in kind.others:
        raise PinpressError(f"{name} is {given}: give a mapping, {name}={{...}}")
    raise PinpressError(f"{name} is one {type(value).__name__}: give a list, {name}=[...]")


_Shape = tuple[int | None, ...]  # None: any length along that axis

SMALLEST, LARGEST = 1e-12, 1e12  # range of sizes in SI units: squares of smaller or larger ones lose meaning
_DEEPEST = 32  # most levels of nested lists; NumPy itself stops at 64 axes, or at 32
_SORTS = {
    "b": "truth values",
    "c": "complex numbers",
    "S": "text",
    "U": "text",
    "T": "text",
    "M": "dates",
    "m": "spans of time",
    "V": "records",
}


def suitable_numbers(
    name: str, given: object, wanted: str, shape: _Shape | None = (), suits: Callable[[Array], Any] = lambda values: True
) -> Array:
    """What is given as a new array of finite numbers, for callers that say what they want.

    Args:
        name: of the argument, for the message.
        given: a number, an array, or nested sequences of numbers.
        wanted: what to give instead, for the message.
        shape: that the array must have, one number by default; None for any length along an axis, or for any shape.
        suits: whether all values, which have this shape and are finite, can be used.

    Raises:
        PinpressError: it is anything else.
    """
    values = finite_numbers(given)
    if values is None or not (shape is None or _has_shape(values, shape)) or not np.all(suits(values)):
        raise PinpressError(f"{name} is {shown(given)}: give {wanted}")
    return values


def number(name: str, value: object, positive: bool = False) -> float:
    """The value as a finite number, named in the `PinpressError` where it is none."""
    if positive:
        return float(suitable_numbers(name, value, "one finite number, positive", suits=lambda found: found > 0))
    return float(suitable_numbers(name, value, "one finite number"))


def is_number(value: object) -> bool:
    """Whether a value is one finite number."""
    found = finite_numbers(value)
    return found is not None and not found.ndim


def positive(what: str, value: object, unit: str) -> float:
    """A size as a number; raises PinpressError where it is not positive, or so small or large that its squares lose meaning."""
    wanted = f"a positive number [{unit}], from {SMALLEST:g} to {LARGEST:g}"
    return float(suitable_numbers(what, value, wanted, suits=lambda size: (size >= SMALLEST) & (size <= LARGEST)))


def truth_value(name: str, value: object) -> bool:
    """True or False; raises PinpressError where the value is neither."""
    if not isinstance(value, bool | np.bool_):
        raise PinpressError(f"{name} is {shown(value)}: give True or False")
    return bool(value)


def is_whole_number(value: object) -> TypeGuard[int]:
    """Whether a value is a whole number, of Python or of NumPy; truth values and spans of time are none."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool | np.timedelta64)


def whole_number(name: str, value: object, least: int, most: int) -> int:
    """A count; raises PinpressError where the value is no whole number from ``least`` to ``most``."""
    if not is_whole_number(value) or not least <= value <= most:
        raise PinpressError(f"{name} is {shown(value)}: give a whole number from {least} to {most}")
    return int(value)


def numbers(name: str, values: object, shape: _Shape | None = None) -> Array:
    """The values as a new array of finite numbers.

    Args:
        name: of the argument, for the messages.
        values: a number, an array, or nested sequences of numbers.
        shape: that the array must have, None for any length along an axis; by default any shape.

    Raises:
        PinpressError: masked, complex or ragged values, texts, truth values, dates, anything that is no number or not finite, or another
            shape.
    """
    array = any_numbers(name, values, shape)
    if shape is not None and not _has_shape(array, shape):
        raise PinpressError(f"{name} has shape {array.shape}: give {_wanted(shape)}")
    if not np.isfinite(array).all():
        where = f" at point {', '.join(map(str, np.argwhere(~np.isfinite(array))[0]))}" if array.ndim else ""
        raise PinpressError(f"{name} is not finite{where}")
    return array


def any_numbers(name: str, values: object, shape: _Shape | None = None) -> Array:
    """The values as a new array of numbers, infinite ones and NaN too; raises as `numbers` does where they are none. ``shape``: for the
    message."""
    array = _array(values)
    if isinstance(array, str):
        raise PinpressError(f"{name} is not {_wanted(shape)}, but {array}: {shown(values)}")
    return array


def finite_numbers(values: object) -> Array | None:
    """The values as a new array of finite numbers; None where `numbers` refuses them: for callers that say more about what they want."""
    array = _array(values)
    return None if isinstance(array, str) or not np.isfinite(array).all() else array


def _has_shape(array: Array, shape: _Shape) -> bool:
    return array.ndim == len(shape) and all(wanted in (None, length) for wanted, length in zip(shape, array.shape, strict=True))


def _wanted(shape: _Shape | None) -> str:
    if shape is None:
        return "a number or an array of numbers"
    if shape == ():
        return "one finite number"
    lengths = ["n" if length is None else str(length) for length in shape]
    return f"finite numbers of shape ({', '.join(lengths)}{',' if len(lengths) == 1 else ''})"


def _array(values: Any) -> Array | str:
    """The values as a new array of floats, or what they are instead of numbers."""
    if type(values) is float:
        return np.array(values)
    if isinstance(values, np.ma.MaskedArray):
        return "masked (fill the gaps, or leave them out)"
    if hasattr(type(values), "units") or hasattr(type(values), "unit"):
        return "a quantity with a unit (give its magnitude in SI units)"
    if isinstance(values, bool) or (isinstance(values, list | tuple) and _odd(values)):
        return "truth values, masked values or deeply nested lists"
    try:
        array = np.asarray(values)
    except Exception:  # whatever a caller's own object raises
        return "ragged lists or something else"
    if array.dtype.kind in _SORTS:
        return _SORTS[array.dtype.kind]
    if array.dtype.kind == "O" and not all(isinstance(value, Real) and not isinstance(value, bool) for value in array.ravel().tolist()):
        return "something else"
    try:
        with np.errstate(all="ignore"):  # what overflows becomes infinite, which the callers refuse
            return np.array(array, dtype=float)
    except (TypeError, ValueError, OverflowError):  # OverflowError: a whole number beyond the range of floats
        return "beyond the range of floating point numbers"


def _odd(values: Iterable[Any], level: int = 1) -> bool:
    """Whether nested lists and tuples hold what NumPy would turn into numbers without a word, or more levels than any array has."""
    return level > _DEEPEST or any(
        _odd(value, level + 1) if isinstance(value, list | tuple) else isinstance(value, bool | np.bool_ | np.ma.MaskedArray)
        for value in values
    )
