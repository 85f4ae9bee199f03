"""What a linkage derives from its model: worked out when first asked for, kept, and refused once the model was changed in place.

Pinocchio's model cannot be made read-only. A change in place would be seen by whatever is worked out later, and by nothing that was
worked out before. The model is therefore compared with a copy of what it was whenever it, or anything derived from it, is read: less
than a microsecond.
"""

from collections.abc import Callable
from typing import Any, Generic, TypeVar, overload

import pinocchio as pin

from ..common.errors import PinpressError
from ..common.frozen import read_only

_MODEL, _AS_BUILT = "model", "_as_built"  # in the linkage's __dict__

T = TypeVar("T")


class Model:
    """The attribute that holds the model."""

    def __get__(self, press: object | None, owner: type | None = None) -> Any:
        if press is None:
            return self
        refuse_changed(press)
        return vars(press)[_MODEL]

    def __set__(self, press: object, model: pin.Model) -> None:
        vars(press).update({_MODEL: model, _AS_BUILT: model.copy()})


class derived(Generic[T]):  # noqa: N801  a decorator, as cached_property is
    """A property that is worked out once. Its arrays are read-only."""

    def __init__(self, work_out: Callable[[Any], T]) -> None:
        self.work_out, self.__doc__ = work_out, work_out.__doc__

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, press: None, owner: type | None = None) -> "derived[T]": ...
    @overload
    def __get__(self, press: object, owner: type | None = None) -> T: ...
    def __get__(self, press: object | None, owner: type | None = None) -> "derived[T] | T":
        if press is None:
            return self
        kept = press.__dict__
        if kept[_MODEL] != kept[_AS_BUILT]:
            refuse_changed(press)
        try:
            return kept[self.name]  # type: ignore[no-any-return]
        except KeyError:
            kept[self.name] = value = read_only(self.work_out(press))
            return value

    def __set__(self, press: object, value: T) -> None:
        raise AttributeError(f"{self.name} follows from the model")


def refuse_changed(press: object) -> None:
    """Raise PinpressError where the model of a linkage is not what it was, or has numbers that equal nothing."""
    kept = vars(press)
    if kept[_MODEL] != kept[_AS_BUILT]:
        if kept[_MODEL] != kept[_MODEL]:  # NaN equals nothing
            raise PinpressError(f"the model of {kept['name']} is not finite: write plain numbers, in SI units")
        raise PinpressError(
            f"the model of {kept['name']} was changed in place, after it was loaded: change a copy, model = press.model.copy(), and make a"
            " changed press of it, dataclasses.replace(press, model=model)"
        )
