"""What stays read-only however it travels: results and descriptions whose copies and pickles are as frozen as they are."""

from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

import numpy as np

K = TypeVar("K")
V = TypeVar("V", covariant=True)


class Frozen:
    """Base of frozen dataclasses that hold arrays: NumPy makes those of a deep copy, or of a pickle, writable again."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        freeze(state)
        vars(self).update(state)


class FrozenMapping(Frozen, Mapping[K, V]):
    """A mapping that is read-only, with the arrays in it, and that, other than ``types.MappingProxyType``, is copied and pickled."""

    def __init__(self, items: Mapping[K, V]) -> None:
        self._items = dict(items)
        freeze(self._items)

    def __getitem__(self, key: K) -> V:
        return self._items[key]

    def __iter__(self) -> Iterator[K]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __repr__(self) -> str:
        return repr(self._items)


def freeze(value: object) -> None:
    """Make arrays read-only, those in tuples, lists and dictionaries too."""
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
        if isinstance(value, np.ma.MaskedArray):
            value.harden_mask()
    elif isinstance(value, dict):
        for inner in value.values():
            freeze(inner)
    elif isinstance(value, tuple | list):
        for inner in value:
            freeze(inner)
