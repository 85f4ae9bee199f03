"""Results and descriptions are read-only, and stay so however they travel: copied, pickled, sent home by another process."""

from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

import numpy as np

K = TypeVar("K")
V = TypeVar("V", covariant=True)
T = TypeVar("T")


class Frozen:
    """Base of frozen dataclasses that hold arrays, mappings or sequences, which are read-only as well.

    NumPy makes the arrays of a deep copy, or of a pickle, writable again.
    """

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
            elif isinstance(value, dict):
                vars(self)[name] = FrozenMapping(value)
            elif isinstance(value, list):
                vars(self)[name] = tuple(value)

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        for value in state.values():
            read_only(value)


class FrozenMapping(Frozen, Mapping[K, V]):
    """A mapping that is read-only, with the arrays in it, and that, other than ``types.MappingProxyType``, is copied and pickled."""

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
    """The same value, its arrays read-only, those in sequences, dictionaries and dataclasses too."""
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
