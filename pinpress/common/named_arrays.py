"""Arrays under the names of bearings."""

from collections.abc import Iterator, Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from .errors import PinpressError, UnknownNameError
from .frozen import Frozen

T = TypeVar("T", bound=np.generic)


class ByBearing(Frozen, Mapping[str, NDArray[T]]):
    """Read-only mapping from the names of joints and loops to arrays; an unknown name is a `PinpressError` that lists the known ones, one
    that was left out is a `PinpressError` that says so, with ``get`` too."""

    def __init__(self, names: tuple[str, ...], values: NDArray[T], left_out: tuple[str, ...] = ()) -> None:
        values.setflags(write=False)
        self._names, self._values, self._left_out = names, values, left_out

    def __getitem__(self, name: str) -> NDArray[T]:
        if name not in self._names:
            if name in self._left_out:
                raise PinpressError(
                    f"bearing {name!r} was left out: name it too, inverse_dynamics(..., bearings={[*self._names, name]}), or give no"
                    " bearings=, for all"
                )
            raise UnknownNameError("bearing", name, self._names + self._left_out)
        values: NDArray[T] = self._values[self._names.index(name)]
        return values

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
