"""Results and descriptions that are read-only, and stay so when they are copied, pickled or sent by another process."""

from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .errors import PinpressError, UnknownNameError

K = TypeVar("K")
V = TypeVar("V", covariant=True)
T = TypeVar("T")


_WRITABLE = (np.ndarray, dict, list)
_UNCHANGEABLE = frozenset((tuple, str, int, float, bool, type(None)))  # most fields: a look at the type takes less time


class Frozen:
    """Base of frozen dataclasses whose arrays, mappings and sequences are read-only too.

    They stay so in copies and pickles, where NumPy would make arrays writable again.
    """

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if type(value) is np.ndarray:
                value.setflags(write=False)
            elif type(value) in _UNCHANGEABLE or not isinstance(value, _WRITABLE):
                continue
            elif isinstance(value, np.ndarray):
                value.setflags(write=False)
            elif isinstance(value, dict):
                vars(self)[name] = FrozenMapping(value)
            else:
                vars(self)[name] = tuple(value)

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        for value in state.values():
            read_only(value)


class FrozenMapping(Frozen, Mapping[K, V]):
    """A read-only mapping with read-only arrays. Unlike ``types.MappingProxyType`` it can be copied and pickled."""

    def __init__(self, items: Mapping[K, V]) -> None:
        self._items = dict(items)
        read_only(self._items)

    def __getitem__(self, key: K) -> V:
        return self._items[key]

    def __iter__(self) -> Iterator[K]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __repr__(self) -> str:
        return repr(self._items)


def read_only(value: T) -> T:
    """Make the arrays of a value read-only, also those in sequences, dictionaries and dataclasses, and return the value."""
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
        if isinstance(value, np.ma.MaskedArray):
            value.harden_mask()
            read_only(np.ma.getmaskarray(value))
    elif isinstance(value, dict):
        for part in value.values():
            read_only(part)
    elif isinstance(value, tuple | list):
        for part in value:
            read_only(part)
    elif hasattr(value, "__dataclass_fields__"):
        for part in vars(value).values():
            read_only(part)
    return value


N = TypeVar("N", bound=np.generic)


class NamedArrays(Frozen, Mapping[str, NDArray[N]]):
    """Read-only mapping from the names of joints and loops to arrays.

    The values are an array, or what has rows and can be made read-only like one. An unknown name raises a `PinpressError` that lists the
    known ones; a name that was left out raises one that says so, with ``get`` too.
    """

    def __init__(self, names: tuple[str, ...], values: Any, left_out: tuple[str, ...] = ()) -> None:
        values.setflags(write=False)
        self._names, self._values, self._left_out = names, values, left_out

    def __getitem__(self, name: str) -> NDArray[N]:
        try:
            place = self._names.index(name)
        except ValueError:
            raise self._missing(name) from None
        values: NDArray[N] = self._values[place]
        return values

    def _missing(self, name: str) -> PinpressError:
        """The error for a name that is not among these."""
        if name not in self._left_out:
            return UnknownNameError("bearing", name, self._names + self._left_out)
        named = [*self._names, name]
        return PinpressError(
            f"bearing {name!r} was left out: name it too, inverse_dynamics(..., bearings={named}), or give no bearings=, for all"
        )

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
