"""Arguments of public functions by their annotations: objects of the library, sequences, mappings, functions, True or False."""

import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from typing import Any, NamedTuple, TypeVar, get_origin

import numpy as np

from .errors import PinpressError, shown

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
    "Ratings": "rate",
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
