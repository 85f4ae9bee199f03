"""Parameters of process loads, put into their one form: a float, or a read-only array (S,) with one value a scenario."""

import math
from typing import TYPE_CHECKING

import numpy as np

from ..common.arrays import Array
from ..common.checks import finite_numbers
from ..common.errors import PinpressError, shown
from ..common.scenario_numbers import set_field
from .protocol import ProcessLoad

if TYPE_CHECKING:
    from .process import Blanking, DeepDrawing


def checked_numbers(load: object, name: str) -> Array:
    value = getattr(load, name)
    found = finite_numbers(value)
    if found is None:
        raise PinpressError(f"{type(load).__name__}: {name} is {shown(value)}; give finite numbers")
    return found


def check_height(load: object, name: str) -> None:
    values = checked_numbers(load, name)
    if values.ndim:
        raise PinpressError(f"{type(load).__name__}: {name} has shape {values.shape}; give one number [m], the same for all scenarios")
    set_field(load, name, float(values))


def check_datum(load: ProcessLoad) -> None:
    if load.datum is not None:
        check_height(load, "datum")


def check_span(load: "Blanking | DeepDrawing") -> None:
    """Heights start and end, start above end and not so near that the rate of the force overflows."""
    check_height(load, "start")
    check_height(load, "end")
    extent = load.start - load.end
    if not (extent > 0 and math.isfinite(extent) and math.isfinite(math.pi / extent)):
        raise PinpressError(
            f"{type(load).__name__}: start is {load.start:g}, not above end, {load.end:g}; give heights [m] with start above end"
        )


def check_magnitude(load: object, name: str) -> None:
    """One number that is not negative, or (S,) of them."""
    values = checked_numbers(load, name)
    if values.ndim > 1 or not values.size:
        raise PinpressError(f"{type(load).__name__}: {name} has shape {values.shape}; give one number, or (S,) for S scenarios")
    if np.any(values < 0):
        raise PinpressError(
            f"{type(load).__name__}: {name} is {shown(getattr(load, name))}; give it not negative (positive resists the slide's work)"
        )
    set_field(load, name, fixed(values) if values.ndim else float(values))


def check_scenarios(load: object, *names: str) -> None:
    shapes = {np.shape(getattr(load, name)) for name in names} - {()}
    if len(shapes) > 1:
        raise PinpressError(f"{type(load).__name__}: {' and '.join(names)} are for different numbers of scenarios, {sorted(shapes)}")


def fixed(array: Array) -> Array:
    array.setflags(write=False)
    return array
