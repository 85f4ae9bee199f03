"""Parameters of drives, put into their one form: a float, or a read-only array (S,) with one value a scenario."""

import numpy as np

from . import plausibility
from .checks import finite_numbers
from .errors import PinpressError, shown

_WITHIN = {
    "finite": lambda values: np.isfinite(values),
    "other than zero": lambda values: values != 0,
    "positive": lambda values: values > 0,
    "not negative": lambda values: values >= 0,
}


def check(drive: object, field: str, kind: str, unit: str, scenarios: bool = False) -> None:
    """Put a field into its one form, a float or a read-only array (S,) of them.

    Raises:
        PinpressError: it is not a finite number of the kind, or an array (S,) of such numbers where there may be several scenarios.
    """
    given = getattr(drive, field)
    values = finite_numbers(given)
    if values is None or values.ndim > scenarios or not values.size or not np.all(_WITHIN[kind](values)):
        wanted = "a finite number" if kind == "finite" else f"a finite number that is {kind}"
        several = ", or an array (S,) of them" if scenarios else ""
        raise PinpressError(f"{type(drive).__name__}: {field} is {shown(given)}; give {wanted} [{unit}]{several}")
    if unit == "rad/s":
        plausibility.speeds(f"{type(drive).__name__}: {field}", values)
    values.setflags(write=False)
    set_field(drive, field, values if values.ndim else float(values))


def set_field(drive: object, field: str, value: object) -> None:
    object.__setattr__(drive, field, value)  # the dataclasses are frozen


def check_scenarios(drive: object, *fields: str) -> None:
    shapes: dict[str, tuple[int, ...]] = {field: np.shape(getattr(drive, field)) for field in fields if np.ndim(getattr(drive, field))}
    if len(set(shapes.values())) > 1:
        listed = ", ".join(f"{field} {shape}" for field, shape in shapes.items())
        raise PinpressError(f"{type(drive).__name__}: {listed} differ in shape; give one of each scenario in all")
