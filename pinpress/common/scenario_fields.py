"""Which fields of a drive, flywheel or load hold one value a scenario. A class declares them; nothing is taken from the shape of a field.

    @dataclass(frozen=True)
    class Hydraulic:
        per_scenario: ClassVar = {"pressure": 0}  # one number [Pa], or (S,) for S scenarios
        pressure: float | Array

The number is that of the axes that one scenario's value has of its own: 0 for a number, 1 for the forces (n,) of a table, which with
scenarios are (n, S). A field that is not declared has the same value in all scenarios, whatever its shape: a torque curve, a program,
a point.
"""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import PinpressError, shown


def lengths(item: Any) -> dict[str, int]:
    """Numbers of scenarios by the names of the fields that hold several, in a drive, flywheel or load and in what it is made of.

    Raises:
        PinpressError: a declaration that names no field, or a declared field of another shape than it has there.
    """
    if not is_dataclass(item) or isinstance(item, type):
        if getattr(item, "per_scenario", None):
            raise PinpressError(f"{type(item).__name__}: per_scenario is for dataclasses, whose fields it names; make it one")
        return {}
    found, declared = {}, _declared(item)
    for field in fields(item):
        value = getattr(item, field.name)
        if field.name in declared:
            shape = np.shape(value)
            if len(shape) not in (declared[field.name], declared[field.name] + 1):
                raise PinpressError(
                    f"{type(item).__name__}: {field.name} has shape {shape}; per_scenario declares {declared[field.name]} axes of its own,"
                    " and behind them one of the scenarios"
                )
            if len(shape) > declared[field.name]:
                found[f"{type(item).__name__}.{field.name}"] = shape[-1]
        else:
            found |= lengths(value)
    return found


def pick(item: Any, which: int | NDArray[np.intp]) -> Any:
    """A drive, flywheel or load with the values of one scenario, or of some."""
    if not is_dataclass(item) or isinstance(item, type):
        return item
    changes: dict[str, Any] = {}
    declared = _declared(item)
    for field in fields(item):
        value = getattr(item, field.name)
        if field.name in declared:
            if np.ndim(value) > declared[field.name]:
                part = np.asarray(value)[..., which]
                changes[field.name] = float(part) if part.ndim == 0 else part
        elif is_dataclass(value) and (picked := pick(value, which)) is not value:
            changes[field.name] = picked
    return replace(item, **changes) if changes else item


def _declared(item: Any) -> Mapping[str, int]:
    """Names of the fields of a dataclass that may hold one value a scenario, with the axes of their own."""
    declared = getattr(item, "per_scenario", {})
    good = isinstance(declared, Mapping) and all(isinstance(axes, int) and axes >= 0 for axes in declared.values())
    if not good or not set(declared) <= {field.name for field in fields(item) if field.init}:
        raise PinpressError(
            f"{type(item).__name__}: per_scenario is {shown(declared)}; give the fields that may be arrays of scenarios, each with"
            " the number of"
            ' axes of its own: {"force": 0}'
        )
    return declared
