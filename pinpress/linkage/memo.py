"""What follows from a linkage: worked out when first asked for, kept with it, and refused once its model was changed in place.

Whatever room works it out, `per_linkage` keeps it. What is kept travels with a linkage that is copied or pickled; a changed linkage,
made by `dataclasses.replace`, starts with nothing.

Pinocchio's model cannot be made read-only. A change in place would be seen by whatever is worked out later, and by nothing that was
worked out before. The model is therefore compared with a copy of what it was whenever it, or anything that follows from it, is read: less
than a microsecond.
"""

from collections.abc import Callable
from functools import partial, wraps
from typing import Any, NamedTuple, TypeVar, overload

import pinocchio as pin

from ..common.errors import PinpressError
from ..common.frozen import read_only

_MODEL, _AS_BUILT, _KEPT = "model", "_as_built", "_kept"  # in the linkage's __dict__

P = TypeVar("P")
T = TypeVar("T")


class Kept(NamedTuple):
    """What is kept with a linkage, by the full names of the functions that worked it out: what its masses matter to, and what follows from
    its geometry alone."""

    of_masses: dict[str, Any]
    of_geometry: dict[str, Any]


class Model:
    """The attribute that holds the model."""

    def __get__(self, press: object | None, owner: type | None = None) -> Any:
        if press is None:
            return self
        refuse_changed(press)
        return vars(press)[_MODEL]

    def __set__(self, press: object, model: pin.Model) -> None:
        vars(press).update({_MODEL: model, _AS_BUILT: model.copy(), _KEPT: Kept({}, {})})


@overload
def per_linkage(work_out: Callable[[P], T]) -> Callable[[P], T]: ...
@overload
def per_linkage(*, of_geometry: bool) -> Callable[[Callable[[P], T]], Callable[[P], T]]: ...
def per_linkage(work_out: Callable[[Any], Any] | None = None, *, of_geometry: bool = False) -> Any:
    """A function of a linkage that is worked out once for each. Its arrays are read-only; errors are raised again each time.

    Args:
        of_geometry: it does not depend on masses and inertias, and is kept where these change (`Linkage.with_inertias`).
    """
    if work_out is None:
        return partial(per_linkage, of_geometry=of_geometry)
    name = _name(work_out)

    @wraps(work_out)
    def kept(press: Any) -> Any:
        attributes = press.__dict__
        if attributes[_MODEL] != attributes[_AS_BUILT]:
            refuse_changed(press)
        known = attributes[_KEPT][of_geometry]
        try:
            return known[name]
        except KeyError:
            known[name] = value = read_only(work_out(press))
            return value

    return kept


def keep_geometry(changed: object, press: object) -> None:
    """Keep with a linkage that differs only in its masses what is known of its geometry."""
    vars(changed)[_KEPT].of_geometry.update(vars(press)[_KEPT].of_geometry)


def keep_all_but(forgotten: Callable[[Any], Any], copied: object, press: object) -> None:
    """Keep with an equal linkage what is known of it, but for what one function of `per_linkage` worked out."""
    for known, own in zip(vars(copied)[_KEPT], vars(press)[_KEPT], strict=True):
        known.update({name: value for name, value in own.items() if name != _name(forgotten)})


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


def _name(work_out: Callable[[Any], Any]) -> str:
    return f"{work_out.__module__}.{work_out.__qualname__}"
