"""Types of arrays, units beside the SI units, and what the coordinate of a driver is measured in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Values = float | Array
"""A number, or an array with one number for each scenario on the last axis."""

RPM = 2 * np.pi / 60
"""One revolution per minute [rad/s]: `speed=70 * pp.RPM`."""

GRAVITY = 9.81
"""Acceleration by gravity, by which weights and accelerations are judged [m/s2]."""

ATMOSPHERE = 101325.0
"""Pressure of the standard atmosphere [Pa]."""


@dataclass(frozen=True)
class DriverCoordinate:
    """What the coordinate of a driver joint is: its names and units in messages, tables, charts and the command line.

    Attributes:
        position: what the coordinate is called.
        effort: what moves the driver, "torque" or "force".
        unit: SI unit of the coordinate.
        effort_unit: SI unit of the effort.
        shown_unit: unit in which messages and charts show the coordinate.
        scale: shown units in one SI unit.
        zero: where the coordinate is 0, as in "top dead centre"; empty for the drawn pose.
    """

    position: str
    effort: str
    unit: str
    effort_unit: str
    shown_unit: str
    scale: float
    zero: str = ""

    @property
    def turns(self) -> bool:
        """Whether the driver turns; else it slides."""
        return self.unit == "rad"

    @property
    def shown_speed(self) -> tuple[str, float]:
        """The unit in which the command line and what it prints have the driver's speed, and its size in SI units."""
        return ("r/min", RPM) if self.turns else ("mm/s", 1e-3)

    def in_place_of(self, unit: str) -> str:
        """The SI unit that takes the place of a shaft's on this driver: "N" of "N m" where it slides, else the same."""
        return unit if self.turns else _ALONG.get(unit, unit)

    @property
    def part(self) -> str:
        """What moves: "crank" or "driver"."""
        return self.position.split()[0]

    @property
    def counted(self) -> str:
        """What the coordinate is called, and from where it is counted where that is not the drawn pose."""
        return f"{self.position} from {self.zero}" if self.zero else self.position

    @property
    def heads(self) -> tuple[tuple[str, str], ...]:
        """Names and units of columns of the coordinate, its rate and its acceleration."""
        part, unit = self.part, self.unit
        return (self.counted.replace(" ", "_"), unit), (f"{part}_speed", f"{unit}/s"), (f"{part}_acceleration", f"{unit}/s2")

    def shown(self, value: float, digits: str = ".6g") -> str:
        """A coordinate in words: "30 deg", "12 mm"."""
        return f"{round(value * self.scale, 9) + 0.0:{digits}} {self.shown_unit}"  # without what is rounding

    def at(self, value: float) -> str:
        """A place in words: "crank angle 30 deg", "driver position 12 mm", "crank angle 30 deg from top dead centre"."""
        return f"{self.position} {self.shown(value)}" + (f" from {self.zero}" if self.zero else "")


_ALONG = {  # units of a shaft's quantities, and those along an axis
    "rad": "m",
    "rad/s": "m/s",
    "N m": "N",
    "N m/rad": "N/m",
    "N m s/rad": "N s/m",
    "W/(N m)2": "W/N2",
    "W s2/rad2": "W s2/m2",
    "kg m2": "kg",
}

CRANK = DriverCoordinate("crank angle", "torque", "rad", "N m", "deg", 180 / np.pi)
"""The coordinate of a driver that turns."""

RAM = DriverCoordinate("driver position", "force", "m", "N", "mm", 1e3)
"""The coordinate of a driver that slides: a hydraulic cylinder, the nut of a ball screw."""
