"""Every exception and warning of the library, and words for their messages. Exceptions carry their data as attributes."""

from __future__ import annotations

import pickle
import sys
import unicodedata
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from .quantities import CRANK

_COLLECTED: ContextVar[list[str] | None] = ContextVar("collected", default=None)  # of one thread, unlike filters of warnings
_LONGEST_SHOWN = 200  # most characters of a value in a message
_LONGEST_NAME = 200  # most characters of a name that alternatives are suggested for: comparing longer ones takes long


class PinpressError(Exception):
    """Base of all errors. Each can be put right by the caller: the message says where the error is, and what to do.

    Errors can be copied and pickled with their attributes, so that process pools can report them.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        # By default an exception is rebuilt from its message alone, which fails for a class that takes other arguments.
        return _rebuild, (type(self), self.args, {name: sendable(value) for name, value in vars(self).items()})


class PinpressWarning(UserWarning):
    """A warning of something that is allowed but probably a mistake; the message says where it is, and what to do."""


class UrdfError(PinpressError):
    """A URDF that cannot be used, or a file in another format that would be turned into one.

    Attributes:
        file: path of the file, or the name by which it was asked for.
        element: the XML element at fault, e.g. ``<joint name="A">``; None if the file as a whole is at fault.
        line: line of this element in the file; None if there is none.
        problem: what is wrong.
        remedy: what to write instead.
    """

    def __init__(self, file: str, element: str | None, line: int | None, problem: str, remedy: str) -> None:
        self.file, self.element, self.line, self.problem, self.remedy = file, element, line, problem, remedy
        place = file if line is None else f"{file}:{line}"
        where = place if element is None else f"{place}: {element}"
        super().__init__(f"{where}: {problem}; {remedy}")


class FileEntryError(PinpressError):
    """An entry of a file in YAML or JSON that cannot be used.

    Attributes:
        file: path of the file, or how what stands in it was given.
        line: in the file; None if there is none.
        element: keys that lead to the entry, such as "links: crank: mass"; empty if the file as a whole is at fault.
        problem: what is wrong.
        remedy: what to write instead.
    """

    def __init__(self, file: str, line: int | None, element: str, problem: str, remedy: str) -> None:
        self.file, self.line, self.element, self.problem, self.remedy = file, line, element, problem, remedy
        place = file if line is None else f"{file}:{line}"
        super().__init__(f"{place}: {f'{element}: ' if element else ''}{problem}; {remedy}")


class PinTableError(FileEntryError):
    """A pin table that makes no press.

    Attributes:
        file: path of the file, or how the table was given.
        line: in the file; None if there is none.
        element: keys that lead to the entry, such as "links: crank: mass"; empty if the table as a whole is at fault.
        problem: what is wrong.
        remedy: what to write instead.
        sketch: the pins placed so far as SVG, with the lengths that do not meet; None if there is nothing to show.
    """

    def __init__(self, file: str, line: int | None, element: str, problem: str, remedy: str, sketch: str | None = None) -> None:
        self.sketch = sketch
        super().__init__(file, line, element, problem, remedy)


class AssemblyError(PinpressError):
    """The loops of a linkage do not close at a crank angle.

    Attributes:
        crank_angle: angle of the driver joint [rad]; position of one that slides [m]; of several drivers, that of the first.
        gap: largest distance left between the two sides of a loop [m].
        iterations: steps of Newton's method taken.
    """

    def __init__(self, problem: str, crank_angle: float, gap: float, iterations: int, place: str = "") -> None:
        self.crank_angle, self.gap, self.iterations = crank_angle, gap, iterations
        place = place or CRANK.at(crank_angle)  # of a driver that slides, or several, as text
        super().__init__(f"{problem} ({place}, {1e3 * gap:.3g} mm open after {iterations} iterations)")


class SingularityError(PinpressError):
    """The driver does not determine the linkage at a crank angle: the linkage locks there, or two assemblies meet.

    Attributes:
        crank_angle: angle of the driver joint [rad]; position of one that slides [m]; of several drivers, that of the first.
        smallest_singular_value: smallest singular value of the passive joints' columns in the loop Jacobian, scaled to unit length [-].
        drivers: positions of several drivers there [rad or m]; () for one driver.
    """

    def __init__(
        self, problem: str, crank_angle: float, smallest_singular_value: float, place: str = "", drivers: Sequence[float] = ()
    ) -> None:
        self.crank_angle, self.smallest_singular_value, self.drivers = crank_angle, smallest_singular_value, tuple(drivers)
        super().__init__(f"{problem} ({place or CRANK.at(crank_angle)})")


class SimulationError(PinpressError):
    """A simulation cannot go on, or has no answer.

    Attributes:
        time: time of the failure [s]; None if it belongs to no instant.
        crank_angle: crank angle at the failure [rad], of a driver that slides its position [m]; None if it belongs to none.
        reason: the kind of failure in a word or two, e.g. "stalls"; None if it has no name.
        coordinate: what the crank angle is.
    """

    def __init__(self, problem: str, time: float | None = None, crank_angle: float | None = None, reason: str | None = None) -> None:
        self.time, self.crank_angle, self.reason, self.coordinate = time, crank_angle, reason, CRANK
        super().__init__(problem)

    def __str__(self) -> str:  # not worked out before: solvers, which raise it, do not know what the driver is
        place = [] if self.time is None else [f"time {self.time:.6g} s"]
        place += [] if self.crank_angle is None else [self.coordinate.at(self.crank_angle)]
        return str(self.args[0]) + (f" ({', '.join(place)})" if place else "")


class UnknownNameError(PinpressError, KeyError):
    """A bearing, link or joint that the linkage does not have.

    Attributes:
        name: the name asked for.
        known: the names there are.
    """

    def __init__(self, kind: str, name: object, known: Iterable[str]) -> None:
        self.name, self.known = name, tuple(known)
        alike = suggestion(name, self.known) if isinstance(name, str) else ""
        super().__init__(f"no {kind} {shown(name)}{alike}; there are: {', '.join(self.known)}")

    def __str__(self) -> str:  # KeyError would print the message as a quoted literal
        return str(self.args[0])


class UnknownScenarioError(PinpressError, IndexError):
    """A scenario that does not exist.

    Attributes:
        number: number of the scenario asked for.
        count: number of scenarios.
    """

    def __init__(self, number: object, count: int) -> None:
        self.number, self.count = number, count
        super().__init__(f"there are {count} scenarios, 0 to {count - 1}, not {shown(number)}")


@contextmanager
def cautions_collected() -> Iterator[list[str]]:
    """The messages of warnings that this thread would issue within the block, which are collected instead, each once."""
    messages: list[str] = []
    token = _COLLECTED.set(messages)
    try:
        yield messages
    finally:
        _COLLECTED.reset(token)


def caution(message: str) -> None:
    """Issue a PinpressWarning that points at the caller of the library, however deep in it this is called."""
    collected = _COLLECTED.get()
    if collected is not None:
        if message not in collected:
            collected.append(message)
        return
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "pinpress":
        frame, level = frame.f_back, level + 1
    warnings.warn(message, PinpressWarning, stacklevel=level)


def suggestion(name: str, known: Iterable[str]) -> str:
    """The words ", did you mean 'x'?" where a known name is close to the one given, else an empty string.

    Bearings of a pin in which several links meet have its name and that of a link, ``K_upper``: for the pin, all of them are close.
    """
    if len(name) > _LONGEST_NAME:
        return ""
    known = list(known)
    if same := next((other for other in known if other.lower() == name.lower() and other != name), None):
        return f", did you mean {same!r}?"
    if name and (of_a_pin := [other for other in known if other.startswith(f"{name}_")][:3]):
        return f", did you mean {' or '.join(map(repr, of_a_pin))}?"
    import difflib  # only on the way to an error

    close = difflib.get_close_matches(name, [other for other in known if len(other) <= _LONGEST_NAME], n=1)
    return f", did you mean {close[0]!r}?" if close else ""


def shown(value: object) -> str:
    """A value as messages show it: on one line, and shortened where it is long."""
    if isinstance(value, int) and value.bit_length() > 200:  # Python refuses to print a number of thousands of digits
        return f"a whole number of {value.bit_length()} bits"
    try:
        text = " ".join(repr(value).split())
    except Exception:  # whatever a caller's own object raises
        text = f"a {type(value).__name__}"
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}..."


def odd_character(name: str, with_control: bool = True) -> str | None:
    """The first character of a name that no line shows as it is, as "U+202E"; None if all can be seen.

    Such characters are half of a character, characters that turn the line round and, if ``with_control``, control characters and line ends.
    """
    directions = "LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"  # of Unicode, which turn a line round
    hidden = ("Cs", "Cc", "Zl", "Zp") if with_control else ("Cs",)
    for character in name:
        turns = unicodedata.bidirectional(character) in directions or character in "\u200e\u200f\u061c"
        if turns or unicodedata.category(character) in hidden:
            return f"U+{ord(character):04X}"
    return None


def said(error: BaseException) -> str:
    """An exception that a caller's function has raised, as messages show it."""
    try:
        text = str(error)
    except Exception:  # whatever a caller's own exception raises
        text = "without a message"
    kind = type(error).__name__
    return f"{kind}: {text}" if text else kind


def _rebuild(kind: type[PinpressError], arguments: tuple[object, ...], attributes: Mapping[str, object]) -> PinpressError:
    error = kind.__new__(kind, *arguments)
    vars(error).update(attributes)
    return error


def sendable(value: object) -> object:
    """An attribute in a form that can be pickled: one that cannot, such as a function given for a name, becomes its description."""
    try:
        pickle.dumps(value)
    except Exception:  # whatever pickling says
        return shown(value)
    return value
