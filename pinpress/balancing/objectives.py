"""What balancing makes small or limits: range, rms or peak of a force, moment or torque over a motion, and the added mass.

All of them are convex functions of the added masses, because every force is linear in the masses. The constant part of a force, which
includes the weight, shakes nothing: range and rms leave it out, the peak counts it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..common.arrays import Array
from ..common.checks import finite_numbers
from ..common.errors import PinpressError, UnknownNameError, shown
from ..linkage.linkage import Linkage

QUANTITIES = {"shaking_force": "N", "shaking_moment": "N m", "driving_torque": "N m", "bearing_force": "N", "bearing_moment": "N m"}
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class Forces(Protocol):
    """What `Reactions` and the change of them by a mass (`MassResponse`) have in common."""

    @property
    def shaking_force(self) -> Array: ...
    @property
    def shaking_moment(self) -> Array: ...
    @property
    def driving_torque(self) -> Array: ...
    @property
    def bearing_force(self) -> Mapping[str, Array]: ...
    @property
    def bearing_moment(self) -> Mapping[str, Array]: ...


@dataclass(frozen=True)
class Measure:
    """Base of `Range`, `Rms` and `Peak`: one number for a quantity of `Reactions` over a motion.

    Attributes:
        quantity: "shaking_force", "shaking_moment", "driving_torque", "bearing_force" or "bearing_moment".
        axis: "x", "y", "z" or a direction (3,) in world axes, of which the component counts; None for the length of the whole vector, and
            for the driving torque.
        bearing: Name of the bearing, for a bearing force or bearing moment.
        about: Point (3,) in world axes that a shaking moment is taken about [m].

    Raises:
        UnknownNameError: There is no such quantity.
        PinpressError: The quantity and the other arguments do not go together, or an axis or point is not three finite numbers.
    """

    quantity: str
    axis: str | tuple[float, float, float] | None = None
    bearing: str | None = None
    about: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if type(self) is Measure:
            raise PinpressError("Measure is what Range, Rms and Peak have in common: write one of these")
        if not isinstance(self.quantity, str) or self.quantity not in QUANTITIES:
            raise UnknownNameError("quantity", self.quantity, tuple(QUANTITIES))
        self._refuse_wrong_combination()
        direction = AXES.get(self.axis, ()) if isinstance(self.axis, str) else AXES["z"] if self.axis is None else self.axis
        for name, vector in (("axis", direction), ("about", self.about)):
            numbers = finite_numbers(vector)
            if numbers is None or numbers.shape != (3,) or (name == "axis" and not numbers.any()):
                raise PinpressError(f"{self}: {name} is {shown(getattr(self, name))}; give three numbers, or for an axis 'x', 'y' or 'z'")

    def _refuse_wrong_combination(self) -> None:
        if self.quantity.startswith("bearing") != (self.bearing is not None):
            raise PinpressError(f"{self.words}: a bearing force or moment needs bearing=, the other quantities have none")
        about = finite_numbers(self.about)
        if about is None or about.shape != (3,):
            raise PinpressError(f"{type(self).__name__}: about is {shown(self.about)}; give a point, three numbers [m]")
        if any(self.about) and self.quantity != "shaking_moment":
            raise PinpressError(f"{self.words}: about goes with a shaking moment")
        if self.quantity == "driving_torque" and self.axis is not None:
            raise PinpressError(f"{self.words}: the driving torque has no axis: leave it out")
        if isinstance(self, Range) and self.quantity != "driving_torque" and self.axis is None:
            raise PinpressError(f"{self.words}: a vector has no range: name an axis, or take Rms or Peak")

    @property
    def unit(self) -> str:
        """Unit of the value: "N" or "N m"."""
        return QUANTITIES[self.quantity]

    @property
    def words(self) -> str:
        """Name in messages and tables, such as "range of the shaking force, z"."""
        what = self.quantity.replace("_", " ") + ("" if self.bearing is None else f" of {self.bearing}")
        where = "" if self.axis is None else f", {self.axis if isinstance(self.axis, str) else _point_words(self.axis)}"
        point = f" about {_point_words(self.about)}" if any(self.about) else ""
        return f"{type(self).__name__.lower()} of the {what}{where}{point}"

    def vector(self, forces: Forces) -> Array:
        """The vector (n, 3) whose component is measured; (n, drivers) for the driving torque."""
        values = getattr(forces, self.quantity)
        if self.bearing is not None:
            values = values[self.bearing]
        if any(self.about):
            values = values - np.cross(self.about, forces.shaking_force)
        return np.asarray(values.reshape(len(values), -1))

    def series(self, forces: Forces) -> Array:
        """The series (n, components) whose range, rms or peak is taken; it is linear in the forces."""
        values = self.vector(forces)
        if self.axis is None:
            return values
        direction = np.array(AXES[self.axis] if isinstance(self.axis, str) else self.axis, dtype=float)
        return np.asarray(values @ (direction / np.linalg.norm(direction)))[:, None]

    def varying(self, series: Array) -> Array:
        """A series (n, components) without its constant part, where that does not count."""
        return np.asarray(series - series.mean(axis=0))

    def value(self, forces: Forces) -> float:
        """The measure of `Reactions`, in its unit."""
        return self.of(self.series(forces))

    def of(self, series: Array) -> float:
        """The measure of a series (n, components)."""
        raise NotImplementedError


def _point_words(vector: tuple[float, float, float]) -> str:
    return f"({', '.join(f'{number:g}' for number in vector)})"


class Range(Measure):
    """Largest value less smallest value over the motion's states."""

    def of(self, series: Array) -> float:
        return float(np.ptp(series))


class Rms(Measure):
    """Root mean square of the difference from the mean, over the motion's states."""

    def of(self, series: Array) -> float:
        return math.sqrt(float(np.mean(np.sum((series - series.mean(axis=0)) ** 2, axis=1))))


class Peak(Measure):
    """Largest magnitude over the motion's states, constant part included."""

    def varying(self, series: Array) -> Array:
        return series

    def of(self, series: Array) -> float:
        return float(np.linalg.norm(series, axis=1).max())


@dataclass(frozen=True)
class AddedMass:
    """The mass that balancing adds to the press [kg].

    Where a region replaces a link's own mass, only the difference from that mass counts.
    """

    unit = "kg"
    words = "added mass"


Target = Measure | AddedMass


def limit_words(target: Target, limit: float) -> str:
    """Name of a limit in messages and tables, such as "limit of the added mass, 400 kg"."""
    return f"limit of the {target.words}, {limit:g} {target.unit}"


def refuse_unknown(measure: Measure, press: Linkage) -> None:
    """Check that a press has what is measured.

    Raises:
        UnknownNameError: The press has no such bearing.
        PinpressError: The range of one driving torque is asked for and the press has several drivers.
    """
    if measure.bearing is not None and measure.bearing not in press.bearings:
        raise UnknownNameError("bearing", measure.bearing, press.bearings)
    if isinstance(measure, Range) and measure.quantity == "driving_torque" and len(press.drivers) > 1:
        raise PinpressError(f"{press.name} has {len(press.drivers)} driving torques, which have no range as a whole: take Rms or Peak")
