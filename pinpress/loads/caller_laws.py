"""Functions that a caller has written, asked in a way that reports what is wrong with them.

Exceptions, and answers that are no finite numbers of the right shape, become a `LawError` that names the law and the arguments. NumPy warns
in these functions as the caller has set it, whatever the library sets around them. The library's own loads are asked as they are.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from numbers import Real
from typing import Any

import numpy as np

from ..common.errors import PinpressError, SimulationError, said, shown
from ..common.parameters import scenario_lengths
from .process import ForceInterval, ProcessLoad, TimeForce

OF_LOAD, OF_TIME = (("height", "m"), ("velocity", "m/s")), (("time", "s"),)


class LawError(SimulationError):
    """A caller's law has raised an exception, or its answer is no finite number.

    Attributes:
        problem: the message without time and crank angle.
    """

    def __init__(self, problem: str, time: float | None = None, crank_angle: float | None = None) -> None:
        self.problem = problem
        super().__init__(problem, time, crank_angle)

    def within(self, time: float, crank_angle: float) -> "LawError":
        """The same error with time and crank angle, which the law itself may not know."""
        return LawError(self.problem, time, crank_angle)


@dataclass(frozen=True, eq=False)
class Asked:
    """A caller's own drive or load.

    Attributes:
        part: the drive or load.
        errors: `numpy.geterr` of the caller.
    """

    part: Any
    errors: Any


def as_given(part: Any) -> Any:
    """A drive or load as the caller wrote it."""
    return part.part if isinstance(part, Asked) else part


def name(part: object) -> str:
    """Name of a drive's or load's class, as the caller wrote it."""
    return type(as_given(part)).__name__


def is_known(load: object) -> bool:
    """Whether a process load is one of the library's."""
    return type(load).__module__.startswith(f"{__package__}.")


def asked_load(load: Any) -> Any:
    """A caller's own load as an `AskedLoad`, a force in time with a `Law`, any other load as it is."""
    if isinstance(load, TimeForce):
        return load if isinstance(load.force, Law) else TimeForce(Law("TimeForce: force", OF_TIME, load.force, np.geterr()), load.edges)
    if is_known(load) or isinstance(load, type | AskedLoad) or not isinstance(load, ProcessLoad):
        return load
    return AskedLoad(load, np.geterr())


@dataclass(frozen=True)
class ForceOfMotion:
    """A caller's function of a motion. What it returns is checked where it is used.

    Attributes:
        what: its name in messages, e.g. "load on 'slide': force".
        call: the function.
        errors: `numpy.geterr` of the caller.
    """

    what: str
    call: Callable[[Any], Any]
    errors: Any

    def __call__(self, motion: Any) -> Any:
        try:
            with np.errstate(**self.errors):
                return self.call(motion)
        except LawError:  # another law, within this one, has said what is wrong
            raise
        except Exception as error:
            raise LawError(f"{self.what} cannot be worked out: {said(error)}") from error


@dataclass(frozen=True)
class Law:
    """A caller's function of numbers or arrays.

    Attributes:
        what: its name in messages, e.g. "Fan: torque".
        names: names of its arguments, with their units.
        call: the function.
        errors: `numpy.geterr` of the caller.
        scenarios: number of scenarios, for each of which it may return a number; None: it returns one.
    """

    what: str
    names: tuple[tuple[str, str], ...]
    call: Callable[..., Any]
    errors: Any
    scenarios: int | None = None

    def __call__(self, *at: Any) -> Any:
        try:
            with np.errstate(**self.errors):
                value = self.call(*at)
        except LawError:  # another law, within this one, has said what is wrong
            raise
        except Exception as error:
            raise LawError(f"{self._in_words(at)} cannot be worked out: {said(error)}") from error
        if isinstance(value, float) and math.isfinite(value):
            return value
        return self._check(value, at)

    def _check(self, value: Any, at: tuple[Any, ...]) -> Any:
        try:
            numbers = np.asarray(value)
        except ValueError:  # rows of different lengths
            numbers = np.asarray(None)
        if numbers.dtype.kind not in "iuf" or np.ma.is_masked(value):
            kind = "masked" if np.ma.is_masked(value) else numbers.dtype
            what = f"holds {kind} values" if isinstance(value, np.ndarray) else f"is {shown(value)}"
            raise LawError(f"{self._in_words(at)} {what}; give finite numbers")
        values = [argument for argument in at if not isinstance(argument, tuple)]  # without the states of a drive
        shape = np.broadcast_shapes(*map(np.shape, values)) or (() if self.scenarios is None or not numbers.ndim else (self.scenarios,))
        lengths = zip(numbers.shape[::-1], shape[::-1], strict=False)
        if numbers.ndim > len(shape) or any(length not in (1, wanted) for length, wanted in lengths):
            raise LawError(f"{self._in_words(at)} has shape {numbers.shape}; give {shape}, as many as it is asked for")
        finite = np.isfinite(numbers)
        if not finite.all() and all(np.isfinite(argument).all() for argument in values):
            raise LawError(f"{self._in_words(at, finite)} is {float(numbers[~finite].flat[0])}; give finite numbers")
        return value

    def _in_words(self, at: tuple[Any, ...], good: Any = None) -> str:
        """The law with its arguments; of arrays those of the first answer that is not ``good``."""
        parts = []
        for (label, unit), value in zip(self.names, at, strict=False):
            if isinstance(value, tuple) or (np.ndim(value) and good is None):
                continue
            if np.ndim(value):
                shape = np.broadcast_shapes(np.shape(value), good.shape)
                value = np.broadcast_to(value, shape)[~np.broadcast_to(good, shape)][0]
            parts.append(f"{label} {float(value):.6g} {unit}")
        return f"{self.what}{' at ' if parts else ''}{', '.join(parts)}"


def refuse_intervals(name: str, downwards: bool, intervals: Any) -> None:
    """Raise PinpressError where the answer of a load's ``intervals`` is not as `ProcessLoad` says; ``name``: of the load."""
    if not isinstance(intervals, tuple | list) or not all(isinstance(interval, ForceInterval) for interval in intervals):
        raise PinpressError(f"{name}: intervals({downwards}) is {shown(intervals)}; give a tuple of ForceInterval, () for none")
    for interval in intervals:
        if not all(isinstance(end, Real) for end in (interval.lower, interval.upper)) or not interval.lower < interval.upper:
            raise PinpressError(
                f"{name}: an interval from {shown(interval.lower)} to {shown(interval.upper)} m; give lower < upper: ForceInterval takes"
                " the upper height first"
            )
    for below, above in itertools.pairwise(sorted(intervals, key=lambda interval: interval.lower)):
        if below.upper > above.lower:
            raise PinpressError(f"{name}: its intervals overlap at {above.lower:g} m; write two loads, or intervals that do not")


@dataclass(frozen=True, eq=False)
class AskedLoad(Asked):
    """A caller's own process load."""

    @property
    def datum(self) -> float | None:
        return self.part.datum  # type: ignore[no-any-return]

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        try:
            with np.errstate(**self.errors):
                intervals = self.part.intervals(downwards)
        except Exception as error:
            raise PinpressError(f"{name(self)}: intervals({downwards}) cannot be worked out: {said(error)}") from error
        refuse_intervals(name(self), downwards, intervals)
        scenarios = next(iter(scenario_lengths(self.part).values()), None)
        law = partial(Law, f"{name(self)}: force", OF_LOAD, errors=self.errors, scenarios=scenarios)
        return tuple(replace(interval, force=law(call=interval.force)) for interval in intervals)
