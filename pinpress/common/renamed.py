"""Old names of what has been renamed: they work for the releases that are promised, and warn of what to write and of their end.

A room's `__init__` puts them behind its list of names, which has the new ones alone; so have `dir`, `import *` and the reference:

    __getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
    __getattr__ = OldNames(__name__, __getattr__, {"duty": "duty_cycle"}, gone_in="0.5")

and its stub, for type checkers, ``duty = duty_cycle`` below the imports. A keyword that has been renamed is taken by `old_keywords`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ParamSpec, TypeVar

from .errors import PinpressError, warn_caller

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


@dataclass(frozen=True)
class OldNames:
    """The `__getattr__` of a room with old names.

    Attributes:
        room: name of the room's package, such as "pinpress.measures".
        current: the `__getattr__` of the names of today.
        renamed: old name -> name of today in the same room, or with a dot from the top: "pinpress.loads.Friction".
        gone_in: version without the old names.
    """

    room: str
    current: Callable[[str], Any]
    renamed: Mapping[str, str]
    gone_in: str

    def __call__(self, name: str) -> Any:
        """The object of an old name, with a DeprecationWarning at the caller's line; any other name is looked for among those of today."""
        if name not in self.renamed:
            return self.current(name)
        room, _, new = (self.renamed[name] if "." in self.renamed[name] else f"{self.room}.{self.renamed[name]}").rpartition(".")
        warn_caller(
            f"{self.room}.{name} is now {room}.{new}: write that; version {self.gone_in} has the old name no more", DeprecationWarning
        )
        return getattr(import_module(room), new)


def old_keywords(*, gone_in: str, **renamed: str) -> Callable[[Callable[Parameters, Result]], Callable[Parameters, Result]]:
    """Decorator of a function that takes old keywords too: ``old_keywords(gone_in="0.5", weight="mass")``.

    Type checkers and `help` know the keywords of today alone.

    Args:
        gone_in: version without the old keywords.
        **renamed: old keyword -> keyword of today.
    """

    def decorate(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
        @functools.wraps(function)
        def taking_both(*args: Parameters.args, **given: Parameters.kwargs) -> Result:
            if not renamed.keys().isdisjoint(given):
                given = _with_new_keywords(function.__name__, given, renamed, gone_in)  # type: ignore[assignment]
            return function(*args, **given)

        return taking_both

    return decorate


def _with_new_keywords(function: str, given: Mapping[str, Any], renamed: Mapping[str, str], gone_in: str) -> dict[str, Any]:
    """The keywords of a call by their names of today.

    Raises:
        PinpressError: one is given by both names.
    """
    keywords = {name: value for name, value in given.items() if name not in renamed}
    for old in given.keys() & renamed.keys():
        new = renamed[old]
        if new in keywords:
            raise PinpressError(f"{function}: {old}= is the old name of {new}=; give {new}= alone")
        warn_caller(f"{function}: {old}= is now {new}=: write that; version {gone_in} has the old name no more", DeprecationWarning)
        keywords[new] = given[old]
    return keywords
