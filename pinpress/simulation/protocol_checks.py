"""Drives and loads are asked once before a run: what a caller has written himself may answer anything."""

import itertools
import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from ..common.checks import any_numbers, is_number
from ..common.errors import PinpressError, said, shown
from ..drives.transmission import Drive
from ..loads import caller_laws
from ..loads.process import ProcessLoad, Stretch, TimeForce
from . import law_trials as laws

SPEEDS = np.array([-1.0, 0.5, 2.0])  # [rad/s]


def check_drive(drive: Drive) -> None:
    """Raise PinpressError where a drive does not answer as the protocol says."""
    name = caller_laws.name(drive)
    inertia = _asked(f"{name}: inertia", lambda: drive.inertia)
    if inertia.ndim > 1 or not np.all(np.isfinite(inertia)) or np.any(inertia < 0):
        raise PinpressError(f"{name}: inertia is {shown(drive.inertia)}; give a finite number that is not negative [kg m2]")
    state = _asked(f"{name}: state", lambda: list(drive.state))
    if state.ndim != 1 or not np.all(np.isfinite(state)):
        raise PinpressError(f"{name}: state is {shown(drive.state)}; give a tuple of finite numbers, () for none")
    if len(state) and not drive.timed:
        raise PinpressError(f"{name}: a drive with states is timed: let timed be True")
    states = tuple(state.tolist())
    rates = _asked(f"{name}: rates", lambda: list(drive.rates(1.0, 0.0, 0.0, states)))
    if rates.shape != state.shape:
        raise PinpressError(f"{name}: rates gives {rates.size} of {state.size} states; give one of each")
    _asked(f"{name}: corners", lambda: [np.ravel(corner)[0] for corner in drive.corners])
    for what in (drive.torque, drive.motor_torque):
        call: Callable[..., Any] = what
        _law(f"{name}: {what.__name__}", partial(call, angle=0.0, time=0.0, state=states), drive.timed)
    if isinstance(drive, laws.AskedDrive):
        laws.try_drive(drive)


def check_load(load: ProcessLoad | TimeForce) -> None:
    """Raise PinpressError where a load does not answer as the protocol says."""
    name = caller_laws.name(load)
    if isinstance(load, TimeForce):
        value = _asked(f"{name}: force", lambda: load.force(np.array([0.0])))
        if value.size != 1 or not np.isfinite(value).all():
            raise PinpressError(f"{name}: force at time 0 is {value}; give a finite number [N]")
        laws.try_in_time(load.force)
        return
    datum = load.datum
    if datum is not None and not is_number(datum):
        raise PinpressError(f"{name}: datum is {shown(datum)}; give a slide position [m], or None for bottom dead centre")
    for downwards in (True, False):
        stretches = load.stretches(downwards)
        if not isinstance(stretches, tuple | list) or not all(isinstance(s, Stretch) for s in stretches):
            raise PinpressError(f"{name}: stretches({downwards}) is {shown(stretches)}; give a tuple of Stretch, () for none")
        for stretch in stretches:
            if not stretch.lower < stretch.upper:
                raise PinpressError(f"{name}: a stretch from {shown(stretch.lower)} to {shown(stretch.upper)} m; give lower < upper")
            inside = [end for end in (stretch.lower, stretch.upper) if math.isfinite(end)] or [0.0]
            height = sum(inside) / len(inside)
            _law(f"{name}: force", partial(_at_rest, stretch, height), False)
        ordered = sorted(stretches, key=lambda s: s.lower)
        for below, above in itertools.pairwise(ordered):
            if below.upper > above.lower:
                raise PinpressError(f"{name}: its stretches overlap at {above.lower:g} m; write two loads, or stretches that do not")
    if isinstance(load, caller_laws.AskedLoad):
        laws.try_load(load)


def _at_rest(stretch: Stretch, height: float, shape: Any) -> Any:
    """Force of a stretch at a height, without speed; ``shape``: a number or an array of any values, whose shape the force shall have."""
    return stretch.force(height + 0.0 * shape, 0.0 * shape)


def _law(what: str, law: Callable[[Any], Any], timed: bool) -> None:
    """Ask a law with a number, and where it is to be solved over the crank angle with an array."""
    number = _asked(what, lambda: law(1.0))
    if not np.all(np.isfinite(number)):
        raise PinpressError(f"{what} is {number}; give finite numbers")
    if not timed:
        shape = (len(SPEEDS), number.size) if number.ndim else SPEEDS.shape
        given = np.broadcast_to(SPEEDS[:, None], shape) if number.ndim else SPEEDS
        array = _asked(f"{what} of an array", lambda: law(given))
        if np.broadcast_shapes(array.shape, shape) != shape:
            raise PinpressError(
                f"{what} of an array of shape {shape} has shape {array.shape}; it must take arrays, as NumPy's functions do"
            )


def _asked(what: str, ask: Callable[[], Any]) -> Any:
    """An answer as an array of numbers."""
    try:
        with np.errstate(all="ignore"):
            return any_numbers(what, ask())
    except PinpressError:
        raise
    except Exception as error:
        raise PinpressError(f"{what} cannot be worked out: {said(error)}") from error
