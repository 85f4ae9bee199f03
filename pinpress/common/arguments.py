"""Checks of arguments. `typed` checks objects of the library, sequences, mappings, functions and truth values by the annotations of a
public function; numbers, whole numbers and arrays are checked by functions that it calls.

Numbers are in SI units, or quantities of pint, which `in_unit` turns into them; pint is not imported here. Texts of
files and of the command line may have a unit, which `read_quantity` knows.

NumPy accepts as numbers what is probably a mistake: it drops masks and imaginary parts, reads texts, dates and truth values, and turns
None into nan. Here all these are refused, with the name of the argument.
"""

import inspect
import math
import re
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from numbers import Real
from typing import Any, TypeGuard, TypeVar, get_origin

import numpy as np

from .errors import PinpressError, shown, suggestion
from .quantities import Array, readable

Function = TypeVar("Function", bound=Callable[..., Any])

MAKERS = {
    "Linkage": "load",
    "Scatter": "the height, top or stroke of tolerances.bottom_dead_centre",
    "Motion": "cycle or simulate",
    "Reactions": "inverse_dynamics",
    "Run": "simulate",
    "Stiffness": "Stiffness",
    "Capacities": "Capacities",
    "Gibs": "Gibs(length, width)",
    "LoadedGuide": "elasticity.guide_contact",
    "SlideCompliance": "compliance",
    "ElasticRun": "simulate or steady_state with elastic=",
    "CampbellDiagram": "elasticity.campbell",
    "PressRatings": "rate",
    "PressTable": "export.tabulate",
    "WorkPrecision": "accuracy.compare",
    "IdentifiedPress": "measured.identify",
    "IdentifiableParameters": "measured.identifiability",
    "Flywheel": "Flywheel",
    "Header": "Header(title=...)",
    "DirectCurrentLink": "drives.DirectCurrentLink",
    "MountedPress": "mounted",
    "VibrationModes": "foundation.modes",
    "WhirlDiagram": "foundation.whirl",
    "MeasuredRun": "measured.record",
    "Frame": "Frame",
    "ElasticFrame": "foundation.beam_frame, reduced_frame or read_frame",
    "RubberPad": "RubberPad",
    "SlidePlay": "tolerances.play",
    "AccuracyBudget": "tolerances.budget",
    "DeadCentreScatter": "tolerances.bottom_dead_centre",
    "Temperatures": "tolerances.Temperatures(rise)",
}
"""Classes whose objects are checked, and the functions that make them, for messages."""

_OTHERS: dict[str, Callable[[Any], bool]] = {
    "None": lambda value: value is None,
    "Sequence": lambda value: isinstance(value, Iterable) and not isinstance(value, str | bytes | Mapping | type),
    "Mapping": lambda value: isinstance(value, Mapping),
    "bool": lambda value: isinstance(value, bool | np.bool_),
    "Callable": lambda value: callable(value) and not isinstance(value, type),
}
_OTHERS["Iterable"] = _OTHERS["Sequence"]


_Kind = tuple[tuple[str, ...], tuple[str, ...]]
"""What a parameter accepts: names of the library's classes, and keys of `_OTHERS`."""


def typed(function: Function) -> Function:
    """Decorate a function so that it raises PinpressError if an argument does not agree with the annotation of its parameter.

    Numbers, texts and users' own laws are not checked here, but where they are used.
    """
    parameters = inspect.signature(function).parameters
    kinds = {name: kind for name, parameter in parameters.items() if (kind := _kind(_evaluate(parameter.annotation, function)))}
    accepted: dict[str, set[type]] = {name: set() for name in kinds}  # all checks look at the type of a value alone
    places = [(place, name) for place, name in enumerate(parameters) if name in kinds]

    @wraps(function)
    def with_checks(*given: Any, **named: Any) -> Any:
        for place, name in places:
            if place < len(given):
                value = given[place]
            elif name in named:
                value = named[name]
            else:
                continue
            if type(value) not in accepted[name]:
                _check(name, value, kinds[name])
                accepted[name].add(type(value))
        return function(*given, **named)

    return with_checks  # type: ignore[return-value]


def expect(name: str, value: object, kind: type, maker: str) -> None:
    """Raise PinpressError if an argument is not of this kind; ``maker``: the function that makes one, for the message."""
    if not isinstance(value, kind):
        raise PinpressError(f"{name} is a {type(value).__name__}, no {kind.__name__}: give what {maker} returns")


def _evaluate(annotation: object, function: Callable[..., Any]) -> object:
    """The value of an annotation that is kept as text; the text itself where it has a name that only type checkers know."""
    if not isinstance(annotation, str):
        return annotation
    try:
        return eval(annotation, getattr(function, "__globals__", {}))
    except NameError:
        return annotation


def _kind(annotation: object) -> _Kind | None:
    """What an annotation asks for; None if it names something that is not checked here."""
    # In Python 3.10 Sequence[float] is a class.
    text = annotation.__name__ if isinstance(annotation, type) and get_origin(annotation) is None else str(annotation)
    if "Sequence[float]" in text:
        return None  # a vector
    while "[" in text:
        text = re.sub(r"\[[^\[\]]*\]", "", text)
    names = [name.strip().rpartition(".")[2] for name in text.split("|")]
    classes = tuple(name for name in names if name in MAKERS)
    others = tuple(name for name in names if name in _OTHERS)
    return (classes, others) if len(classes) + len(others) == len(names) else None


def _check(name: str, value: object, kind: _Kind) -> None:
    classes, others = kind
    if any(one.__name__ in classes and one.__module__.startswith("pinpress.") for one in type(value).__mro__):
        return
    if any(_OTHERS[other](value) for other in others):
        return
    given = "a class" if isinstance(value, type) else f"a {type(value).__name__}"
    if classes:
        raise PinpressError(f"{name} is {given}, no {classes[0]}: give what {MAKERS[classes[0]]} returns")
    if "bool" in others:
        raise PinpressError(f"{name} is {shown(value)}: give True or False")
    if "Callable" in others:
        raise PinpressError(f"{name} is {shown(value)}: give a function")
    if "Mapping" in others:
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
    """The argument as a new array of finite numbers, for callers that say what they want.

    Args:
        name: of the argument, for the message.
        given: a number, an array, or nested sequences of numbers.
        wanted: what to give instead, for the message.
        shape: of the array, one number by default; None stands for any length along an axis, or for any shape.
        suits: returns whether values of this shape, which are finite, can be used.

    Raises:
        PinpressError: the argument is anything else.
    """
    values = finite_numbers(given)
    if values is None or not (shape is None or _has_shape(values, shape)) or not np.all(suits(values)):
        raise PinpressError(f"{name} is {shown(given)}: give {wanted}")
    return values


def rising_speeds(name: str, given: object) -> Array:
    """The argument as an array (s,) of positive, rising numbers [rad/s], at least one; raises PinpressError if it is anything else."""
    wanted = "an array of positive numbers, rising [rad/s]"
    return suitable_numbers(name, given, wanted, (None,), lambda values: len(values) and values[0] > 0 and np.all(np.diff(values) > 0))


def number(name: str, value: object, unit: str | None = None, *, positive: bool = False) -> float:
    """The argument as a finite number, quantities in the unit; raises PinpressError if it is no number, or must be ``positive`` and is
    not."""
    if type(value) is float and math.isfinite(value) and (value > 0 or not positive):
        return value
    value = in_unit(name, value, unit)
    if positive:
        return float(suitable_numbers(name, value, "one finite number, positive", suits=lambda value: value > 0))
    return float(suitable_numbers(name, value, "one finite number"))


def is_number(value: object) -> bool:
    """Whether a value is one finite number."""
    values = finite_numbers(value)
    return values is not None and not values.ndim


def positive(what: str, value: object, unit: str, largest: float = LARGEST) -> float:
    """A size as a number; raises PinpressError if it is not positive, or outside the range from `SMALLEST` to ``largest``."""
    wanted = f"a positive number [{unit}], from {SMALLEST:g} to {largest:g}"
    return float(suitable_numbers(what, in_unit(what, value, unit), wanted, suits=lambda size: (size >= SMALLEST) & (size <= largest)))


def truth_value(name: str, value: object) -> bool:
    """True or False; raises PinpressError if the value is neither."""
    if not isinstance(value, bool | np.bool_):
        raise PinpressError(f"{name} is {shown(value)}: give True or False")
    return bool(value)


def is_whole_number(value: object) -> TypeGuard[int]:
    """Whether a value is a whole number of Python or NumPy, not a truth value or a span of time."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool | np.timedelta64)


def whole_number(name: str, value: object, least: int, most: int) -> int:
    """A count; raises PinpressError if the value is no whole number from ``least`` to ``most``."""
    if not is_whole_number(value) or not least <= value <= most:
        raise PinpressError(f"{name} is {shown(value)}: give a whole number from {least} to {most}")
    return int(value)


def in_unit(name: str, value: Any, unit: str | None) -> Any:
    """A quantity of pint, or nested lists and tuples with such, as plain numbers; everything else as it is.

    Args:
        name: of the argument, for the message.
        value: what is given.
        unit: "m", "kg m2", "N m/rad" and similar; "-" for plain numbers. With None quantities stay what they are, and are refused later.

    Raises:
        PinpressError: a quantity that is no multiple of the unit; one without an angle for a unit with "rad/s": whether 1/min or Hz count
            turns or radians is not known.
    """
    if unit is None or isinstance(value, float | int | np.ndarray):
        return value
    if isinstance(value, list | tuple) and _holds_quantities(value):
        return type(value)(in_unit(name, each, unit) for each in value)
    if not is_quantity(value):
        return value
    quantity = " ".join(str(value).split())
    if len(quantity) >= 50:
        quantity = f"in {value.units}"
    try:
        converted = _convert(value, unit)
    except Exception as error:  # whatever the registry says
        remedy = "without a unit" if unit == "-" else f"in {unit}, or in a multiple of it"
        raise PinpressError(f"{name} is {quantity}: give it {remedy}") from error
    angles = "rad", "deg", "rev", "turn", "rpm", "cycle", "gon", "arc"  # in the names of units of an angle
    if "rad/s" in unit and not any(word in str(value.units) for word in angles):
        raise PinpressError(f"{name} is {quantity}, which says no angle: give it in {unit}, or in revolutions or degrees by time (rpm)")
    return converted


def is_quantity(value: object) -> bool:
    """Whether a value is a quantity of pint, by what it can do."""
    return all(hasattr(type(value), name) for name in ("to", "to_base_units", "magnitude", "dimensionality", "units"))


def is_multiple(quantity: Any, unit: str) -> bool:
    """Whether a quantity of pint is one of this unit or of its multiples."""
    try:
        _convert(quantity, unit)
    except Exception:  # whatever the registry says
        return False
    return True


def _convert(quantity: Any, unit: str) -> Any:
    in_pint = "" if unit == "-" else re.sub(r"(?<=[A-Za-z])(\d)", r"**\1", unit.replace(" ", "*"))  # kg*m**2 for kg m2
    return quantity.to(in_pint).magnitude


def _holds_quantities(values: Iterable[Any], level: int = 1) -> bool:
    return level <= _DEEPEST and any(
        _holds_quantities(value, level + 1) if isinstance(value, list | tuple) else is_quantity(value) for value in values
    )


def numbers(name: str, values: object, shape: _Shape | None = None, *, unit: str | None = None) -> Array:
    """The values as a new array of finite numbers.

    Args:
        name: of the argument, for the messages.
        values: a number, an array, or nested sequences of numbers.
        shape: of the array, in which None stands for any length along an axis; by default any shape.
        unit: that quantities are turned into, see `in_unit`.

    Raises:
        PinpressError: the values are masked, complex or ragged, texts, truth values, dates or anything else that is no finite number, or
            have another shape.
    """
    array = any_numbers(name, in_unit(name, values, unit), shape)
    if shape is not None and not _has_shape(array, shape):
        raise PinpressError(f"{name} has shape {array.shape}: give {_shape_as_text(shape)}")
    if not np.isfinite(array).all():
        where = f" at point {', '.join(map(str, np.argwhere(~np.isfinite(array))[0]))}" if array.ndim else ""
        raise PinpressError(f"{name} is not finite{where}")
    return array


def any_numbers(name: str, values: object, shape: _Shape | None = None) -> Array:
    """The values as a new array of numbers, which may be infinite or NaN; raises PinpressError as `numbers`. ``shape``: for the message."""
    array = _array(values)
    if isinstance(array, str):
        raise PinpressError(f"{name} is not {_shape_as_text(shape)}, but {array}: {shown(values)}")
    return array


def finite_numbers(values: object) -> Array | None:
    """The values as a new array of finite numbers; None if `numbers` would refuse them, for callers with messages of their own."""
    array = _array(values)
    return None if isinstance(array, str) or not np.isfinite(array).all() else array


def _has_shape(array: Array, shape: _Shape) -> bool:
    return array.ndim == len(shape) and all(wanted in (None, length) for wanted, length in zip(shape, array.shape, strict=True))


def _shape_as_text(shape: _Shape | None) -> str:
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
    """Whether nested lists and tuples have values that NumPy would turn into numbers without a warning, or more levels than any array."""
    return level > _DEEPEST or any(
        _odd(value, level + 1) if isinstance(value, list | tuple) else isinstance(value, bool | np.bool_ | np.ma.MaskedArray)
        for value in values
    )


# ------------------------------------------------------------------------------------------------------------------------- texts with units

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*((?:[A-Za-z%]|(?<=\s)1/|[^\x00-\x7f]).*?)?\s*")
_SPELLINGS = str.maketrans({"\u03bc": "\u00b5", "·": "", "*": "", "²": "2", "³": "3"})  # the letter mu for the sign of a millionth


def read_quantity(text: str, unit: str) -> float:
    """The number of a text, in a unit of `quantities`; a bare number is in this unit.

    Raises:
        ValueError: it is no number, or its unit is of something else; the message says what to write.
    """
    parts = _NUMBER.fullmatch(text)
    if parts is None:
        try:
            return float(text)  # inf and nan, which are refused where the number is used
        except ValueError:
            remedy = ": write decimals after a point" if re.fullmatch(r"\s*[-+]?\d+,\d+.*", text) else ""
            raise ValueError(f"no number{remedy}") from None
    number, given = parts.groups()
    return float(number) * unit_factor(given, unit) if given else float(number)


def unit_factor(given: str, unit: str) -> float:
    """How large a unit is in another one; raises ValueError if it is of something else.

    Blanks, points and stars between the parts of a unit do not matter, nor whether a power is written small.
    """
    known = readable(unit)
    size = known.get(given)
    if size is None:
        size = {_spelling(name): each for name, each in known.items()}.get(_spelling(given))
    if size is None:
        raise ValueError(f"in {given!r}, which is none of {', '.join(known)}{suggestion(given, known)}")
    return size


def known_factor(given: str, unit: str) -> float | None:
    """How large a unit is in another one; None if it is of something else, or empty."""
    try:
        return unit_factor(given, unit) if given else None
    except ValueError:
        return None


def _spelling(unit: str) -> str:
    return "".join(unit.translate(_SPELLINGS).split())
