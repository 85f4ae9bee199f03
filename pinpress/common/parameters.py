"""Parameters of drives, flywheels and loads. Each field declares its unit, its sign, and whether each scenario may have a value of its own.

    @dataclass(frozen=True)
    class HydraulicMotor(SpeedTorqueDrive):
        pressure: Values = field(metadata=parameter("Pa", "positive", scenarios=True))  # one number, or (S,) for S scenarios

`Checked`, the base of the library's drives and loads, turns every declared parameter into a float or a read-only array. Only the
declaration allows scenarios, never the shape of a value: a field that is not declared, or declared without ``scenarios``, has the same
value in all scenarios, whatever its shape: a torque curve, a program, a point.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import Field, fields, is_dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import plausibility
from .arguments import finite_numbers, in_unit, is_whole_number, typed
from .errors import PinpressError, shown
from .frozen import Frozen

_KEY = "pinpress.parameter"  # key in the metadata of a dataclass's field

_SIGNS: Mapping[str, Callable[[Any], Any]] = {
    "finite": np.isfinite,
    "other than zero": lambda values: values != 0,
    "positive": lambda values: values > 0,
    "not negative": lambda values: values >= 0,
}


class Parameter(NamedTuple):
    """The declaration of a field.

    Attributes:
        unit: as in "N m"; "-" for none.
        sign: "finite" (any), "other than zero", "positive" or "not negative".
        scenarios: whether it may hold one value for each scenario, on a last axis (S,).
        axes: number of axes of one scenario's value: 0 for a number, 1 for the forces (n,) of a table, which with scenarios are (n, S).
        remark: added in messages to what is to be given.
    """

    unit: str
    sign: str = "finite"
    scenarios: bool = False
    axes: int = 0
    remark: str = ""

    def wanted(self) -> str:
        """What is to be given, for messages."""
        kind = "" if self.sign == "finite" else f" that {'are' if self.axes else 'is'} {self.sign}"
        if self.axes:
            words = f"finite numbers{kind} [{self.unit}], {self.axes} axes of them" + ", and behind these one of scenarios" * self.scenarios
        else:
            words = f"a finite number{kind} [{self.unit}]" + ", or an array (S,) of them" * self.scenarios
        return words + (f" ({self.remark})" if self.remark else "")

    def checked(self, what: str, value: object) -> Any:
        """The value as a float or a read-only array; raises PinpressError with its name ``what`` where it is not as declared."""
        values = finite_numbers(in_unit(what, value, self.unit))
        if values is not None and (not values.size or values.ndim not in (self.axes, self.axes + self.scenarios)):
            raise PinpressError(f"{what} has shape {values.shape}; give {self.wanted()}")
        if values is None or not np.all(_SIGNS[self.sign](values)):
            raise PinpressError(f"{what} is {shown(value)}; give {self.wanted()}")
        if self.unit == "rad/s":
            plausibility.speeds(what, values)
        values.setflags(write=False)
        return values if values.ndim else float(values)


@typed
def parameter(unit: str, sign: str = "finite", *, scenarios: bool = False, axes: int = 0, remark: str = "") -> Mapping[str, Parameter]:
    """Metadata for a dataclass's field that declare it a parameter.

    Args:
        unit: as in "N m"; "-" for none.
        sign: "finite" (any), "other than zero", "positive" or "not negative".
        scenarios: whether it may hold one value for each scenario, on a last axis (S,).
        axes: number of axes of one scenario's value, 0 for a number.
        remark: added in messages to what is to be given.

    Raises:
        PinpressError: the sign is unknown, or ``axes`` is no number of axes.
    """
    if not isinstance(sign, str) or sign not in _SIGNS:
        raise PinpressError(f"parameter: sign is {shown(sign)}; give one of {', '.join(_SIGNS)}")
    if not is_whole_number(axes) or axes < 0:
        raise PinpressError(f"parameter: axes is {shown(axes)}; give the number of axes that one scenario's value has, 0 for a number")
    return {_KEY: Parameter(unit, sign, scenarios, axes, remark)}


class Checked(Frozen):
    """Base of frozen dataclasses whose declared parameters are checked when they are made."""

    def __post_init__(self) -> None:
        check_parameters(self)


def check_parameters(item: Any) -> None:
    """Turn the declared parameters of a dataclass into floats or read-only arrays. A parameter whose default is None may be None.

    Raises:
        PinpressError: a value is not as declared, or values are for different numbers of scenarios.
    """
    name, counts = type(item).__name__, {}
    for field, declared in _declared(item):
        value = getattr(item, field.name)
        if value is None and field.default is None:
            continue
        value = declared.checked(f"{name}: {field.name}", value)
        set_field(item, field.name, value)
        if np.ndim(value) > declared.axes:
            counts[field.name] = np.shape(value)[-1]
    if len(set(counts.values())) > 1:
        raise PinpressError(
            f"{name}: {' and '.join(counts)} are for different numbers of scenarios, {', '.join(map(str, counts.values()))};"
            " give one value of each scenario in all"
        )


def in_declared_units(item: Any) -> None:
    """Put quantities with units in the declared fields of a dataclass into their SI units, and leave all else as it is."""
    for field, declared in _declared(item):
        set_field(item, field.name, in_unit(f"{type(item).__name__}: {field.name}", getattr(item, field.name), declared.unit))


def set_field(item: object, field: str, value: object) -> None:
    """Set a field of a frozen dataclass, while it is being made."""
    object.__setattr__(item, field, value)


def declared(field: Field[Any]) -> Parameter | None:
    """What is declared of a field of a dataclass; None if nothing is."""
    found: Parameter | None = field.metadata.get(_KEY)
    return found


def in_signature(item: Any) -> Sequence[Field[Any]]:
    """The fields of a dataclass, or of its instance, in the order of its arguments: those that must be named come last."""
    return sorted(fields(item), key=lambda field: field.kw_only is True)


def _declared(item: Any) -> Iterator[tuple[Field[Any], Parameter]]:
    for field in fields(item):
        if _KEY in field.metadata:
            yield field, field.metadata[_KEY]


# ---------------------------------------------------------------------------------------------------------------------------- scenarios


def scenario_lengths(item: Any) -> dict[str, int]:
    """Number of scenarios of each field that holds several, by its name, in a drive, flywheel or load and in its parts.

    Raises:
        PinpressError: a field has another shape than declared.
    """
    if not is_dataclass(item) or isinstance(item, type):
        return {}
    found: dict[str, int] = {}
    name = type(item).__name__
    for field in fields(item):
        value, declared = getattr(item, field.name), field.metadata.get(_KEY)
        if declared is None:
            found |= scenario_lengths(value)
        elif declared.scenarios and value is not None:
            shape = np.shape(value)
            if len(shape) not in (declared.axes, declared.axes + 1):
                raise PinpressError(f"{name}: {field.name} has shape {shape}; give {declared.wanted()}")
            if len(shape) > declared.axes:
                found[f"{name}.{field.name}"] = shape[-1]
    return found


def pick_scenarios(item: Any, which: int | NDArray[np.intp]) -> Any:
    """A drive, flywheel or load with the values of one scenario, or of several; ``which``: their indices."""
    if not is_dataclass(item) or isinstance(item, type):
        return item
    changes: dict[str, Any] = {}
    for field in fields(item):
        value, declared = getattr(item, field.name), field.metadata.get(_KEY)
        if declared is not None and declared.scenarios and np.ndim(value) > declared.axes:
            part = np.asarray(value)[..., which]
            changes[field.name] = float(part) if part.ndim == 0 else part
        elif declared is None and is_dataclass(value) and (picked := pick_scenarios(value, which)) is not value:
            changes[field.name] = picked
    return replace(item, **changes) if changes else item


def refuse_scenarios(function: str, speed: object, parts: tuple[Any, ...]) -> None:
    """Raise PinpressError if a speed, or a parameter of a drive, flywheel or load, has several scenarios: this ``function`` takes
    one."""
    speeds = finite_numbers(speed)
    found = {} if speeds is None or speeds.ndim != 1 else {"speed": len(speeds)}
    for part in parts:
        found |= scenario_lengths(part)
    for name, count in found.items():
        raise PinpressError(f"{name} has {count} scenarios, and {function} takes one: give one number, or all of them to simulate_batch")
