"""Results that follow from a linkage alone: computed when first needed, kept with it, and refused once its model was changed in place.

`per_linkage` keeps such results in all rooms. They are copied and pickled with the linkage; a changed linkage, made by
`dataclasses.replace`, starts without any.

Pinocchio's model cannot be made read-only, and a change in place would show in results that are computed later, but not in those computed
before. Therefore the model is compared with a copy of its first state whenever it, or a result, is read, which takes less than a
microsecond.
"""

from collections.abc import Callable
from functools import partial, wraps
from typing import Any, NamedTuple, TypeVar, overload

import pinocchio as pin

from ..common.errors import PinpressError
from ..common.frozen import read_only

_MODEL, _AS_BUILT, _KEPT = "model", "_as_built", "_kept"  # keys in the linkage's __dict__

P = TypeVar("P")
T = TypeVar("T")


class Kept(NamedTuple):
    """Results kept with a linkage, by the full names of the functions that computed them.

    Attributes:
        of_masses: results that may depend on masses and inertias.
        of_geometry: results that depend on the geometry alone.
    """

    of_masses: dict[str, Any]
    of_geometry: dict[str, Any]


class Model:
    """The attribute of a linkage that holds its model; reading it raises PinpressError if the model was changed in place."""

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
    """Decorate a function of a linkage so that it is computed once for each linkage. Arrays in its result are read-only; errors are not
    kept.

    Args:
        work_out: the function.
        of_geometry: whether its result does not depend on masses and inertias, and is kept when these change (`Linkage.with_inertias`).
    """
    if work_out is None:
        return partial(per_linkage, of_geometry=of_geometry)
    name = _name(work_out)

    @wraps(work_out)
    def kept(press: Any) -> Any:
        attributes = press.__dict__
        if attributes[_MODEL] != attributes[_AS_BUILT]:
            refuse_changed(press)
        results = attributes[_KEPT][of_geometry]
        try:
            return results[name]
        except KeyError:
            results[name] = value = read_only(work_out(press))
            return value

    return kept


def keep_geometry(changed: object, press: object) -> None:
    """Hand the kept results of geometry to a linkage that differs from ``press`` only in its masses."""
    vars(changed)[_KEPT].of_geometry.update(vars(press)[_KEPT].of_geometry)


def keep_geometry_of(work_out: Callable[[Any], T], press: object, result: T) -> None:
    """Keep a result of a function of `per_linkage`, one of geometry alone, that was found in another way than by calling it."""
    vars(press)[_KEPT].of_geometry[_name(work_out)] = read_only(result)


def keep_all_but(forgotten: Callable[[Any], Any], copied: object, press: object) -> None:
    """Hand all kept results to an equal linkage, without that of one function (``forgotten``) of `per_linkage`."""
    for results, from_press in zip(vars(copied)[_KEPT], vars(press)[_KEPT], strict=True):
        results.update({name: value for name, value in from_press.items() if name != _name(forgotten)})


def refuse_changed(press: object) -> None:
    """Raise PinpressError if the model of a linkage was changed in place, or has numbers that are not finite."""
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
