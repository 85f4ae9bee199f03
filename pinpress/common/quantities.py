"""Types of arrays, the one table of units with how numbers are written and read, and what the coordinate of a driver is measured in.

Results hold SI units. `quantity` finds the row of the table by an SI unit ("N m") or by a name ("frequency"), so that declarations, column
heads and descriptions stay texts. A row says in which unit numbers are shown, by the size of the largest of them, and which units are read.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import NamedTuple

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
        """A coordinate as text: "30 deg", "12 mm"."""
        return f"{round(value * self.scale, 9) + 0.0:{digits}} {self.shown_unit}"  # without what is rounding

    def at(self, value: float) -> str:
        """A place as text: "crank angle 30 deg", "driver position 12 mm", "crank angle 30 deg from top dead centre"."""
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

# ------------------------------------------------------------------------------------------------------------------------- numbers as texts


class ShownUnit(NamedTuple):
    """How the numbers of one quantity are written next to each other: in one unit, with one number of decimals.

    Attributes:
        unit: with its prefix.
        factor: of these units in one SI unit.
        decimals: digits after the point.
        least: values up to this size are written as 0 [SI unit]; negative for places, of which 0 has decimals too.
    """

    unit: str
    factor: float
    decimals: int
    least: float = 0.0

    def shown(self, value: float) -> str:
        """A value in SI units as a number in this unit; thousands stand apart if there are more than four digits before the point."""
        if math.isnan(value):
            return ""
        rounded = round(value * self.factor, self.decimals) + 0.0
        if self.least >= 0 and (abs(value) <= self.least or not rounded):
            return "0"
        return grouped(rounded, f".{self.decimals}f")


def grouped(value: float, digits: str) -> str:
    """A number with a space between thousands if it has more than four digits before the point."""
    number = f"{value:,{digits}}"
    return number.replace(",", " " if len(number.partition(".")[0].strip("-")) > len("1,000") else "")


@dataclass(frozen=True)
class Quantity:
    """A row of the table of units.

    Attributes:
        name: what it is called, as in "torque".
        unit: SI unit; "-" for none.
        shown: units in which it is shown: name, size [SI unit], and the size of the largest value from which on it is chosen [SI unit].
            Empty: the SI unit.
        read: further units in which it is read -> size [SI unit].
        decimals: digits after the point of a place, such as an angle; None: as many as the largest value needs.
    """

    name: str
    unit: str
    shown: tuple[tuple[str, float, float], ...] = ()
    read: Mapping[str, float] = field(default_factory=dict)
    decimals: int | None = None

    def scale(self, values: Iterable[float], reference: float = 0.0, digits: int = 3) -> ShownUnit:
        """How values are written next to each other.

        Args:
            values: all that are written next to each other, or their extremes [SI unit].
            reference: largest value of its kind; values below 1e-6 of it, and those below 1e-9 of the largest value, are 0 [SI unit].
            digits: of the largest value; digits before the point are all written.
        """
        largest = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
        least = max(NEGLIGIBLE * reference, ROUNDING * largest)
        unit, factor = self.unit if self.unit != "-" else "", 1.0
        for name, size, start in self.shown:
            if largest * (1 + ROUNDING) >= start:
                unit, factor = name, 1 / size
        if self.decimals is not None:
            return ShownUnit(unit, factor, self.decimals, -1.0)
        before_point = math.floor(math.log10(largest * factor * (1 + ROUNDING))) if largest > least else 0
        return ShownUnit(unit, factor, min(max(digits - 1 - before_point, 0), 9), least)

    def text(self, value: float, digits: int = 3, reference: float = 0.0) -> str:
        """A value [SI unit] with its unit: "21.5 kN m"."""
        scale = self.scale([value], reference, digits)
        return f"{scale.shown(value)} {scale.unit}".rstrip()

    def in_unit(self, unit: str) -> Quantity:
        """The same row for values in one of its units instead of the SI unit."""
        size = self.sizes()[unit]
        if size == 1.0:
            return self
        read = {name: other / size for name, other in self.sizes().items()}
        shown = self.shown or ((self.unit, 1.0, 0.0),)
        return replace(self, unit=unit, shown=tuple((name, other / size, start / size) for name, other, start in shown), read=read)

    def sizes(self) -> dict[str, float]:
        """All units that are read -> size [SI unit]."""
        return {self.unit: 1.0, **{name: size for name, size, _ in self.shown}, **self.read}


ROUNDING = 1e-9  # share of the largest value below which a value is an error of rounding
DEGREE, TURN = math.pi / 180, 2 * math.pi
STANDARD_GRAVITY = 9.80665  # [m/s2]
TINY = 1e-30  # sizes below it are zero, which is written in the usual unit
NEGLIGIBLE = 1e-6  # share of the largest value of a kind below which a value is nothing to a reader
_KILO = 1e4  # forces, torques and energies take a prefix from here on: presses are rated as 3000 kN


def _rated(name: str, unit: str, kilo: float = _KILO, **read: float) -> Quantity:
    shown = ((unit, 1.0, 0.0), (f"k{unit}", 1e3, kilo), (f"M{unit}", 1e6, 1e7))
    return Quantity(name, unit, shown, read)


QUANTITIES = (
    Quantity(
        "length", "m", (("mm", 1e-3, 0.0), ("µm", 1e-6, TINY), ("mm", 1e-3, 1e-4), ("m", 1.0, 10.0)), {"um": 1e-6, "cm": 1e-2, "in": 0.0254}
    ),
    Quantity("height", "m", (("mm", 1e-3, 0.0), ("m", 1.0, 10.0)), {"um": 1e-6, "µm": 1e-6}, decimals=3),
    Quantity(
        "angle",
        "rad",
        (("deg", DEGREE, 0.0),),
        {"°": DEGREE, "turn": TURN, "turns": TURN, "rev": TURN},
        decimals=3,
    ),
    Quantity("tilt", "rad", (("µrad", 1e-6, 0.0), ("mrad", 1e-3, 1e-2))),
    _rated("force", "N", tf=1e3 * STANDARD_GRAVITY),
    _rated("torque", "N m"),
    _rated("energy", "J"),
    _rated("power", "W", 1e3),
    Quantity("speed", "m/s", (("m/s", 1.0, 0.0), ("mm/s", 1e-3, TINY), ("m/s", 1.0, 1e-2)), {"m/min": 1 / 60}),
    Quantity(
        "acceleration",
        "m/s2",
        (("m/s²", 1.0, 0.0), ("mm/s²", 1e-3, TINY), ("m/s²", 1.0, 1e-2)),
        {"mm/s2": 1e-3, "m/s^2": 1.0, "g": 9.80665, "mg": 9.80665e-3},
    ),
    Quantity(
        "rotational speed",
        "rad/s",
        (("r/min", RPM, 0.0),),
        {"rpm": RPM, "1/min": RPM, "min-1": RPM, "spm": RPM, "Hz": TURN, "deg/s": DEGREE},
    ),
    Quantity("frequency", "rad/s", (("Hz", TURN, 0.0),), {"kHz": 1e3 * TURN}),
    Quantity("spectral density", "m/s2/√Hz", (("m/s²/√Hz", 1.0, 0.0),)),
    Quantity("angular acceleration", "rad/s2", (), {"deg/s2": DEGREE}),
    Quantity("time", "s", (("s", 1.0, 0.0), ("ms", 1e-3, TINY), ("s", 1.0, 0.1)), {"us": 1e-6, "µs": 1e-6, "min": 60.0, "h": 3600.0}),
    Quantity("mass", "kg", (("kg", 1.0, 0.0), ("t", 1e3, 1e4)), {"g": 1e-3}),
    Quantity("inertia", "kg m2", (), {"kg cm2": 1e-4}),
    Quantity("stiffness", "N/m", (("N/m", 1.0, 0.0), ("kN/mm", 1e6, 1e6)), {"kN/m": 1e3, "N/mm": 1e3, "MN/m": 1e6, "GN/m": 1e9}),
    Quantity("damping", "N s/m", (("N s/m", 1.0, 0.0), ("kN s/m", 1e3, 1e4))),
    Quantity("turning stiffness", "N m/rad", (("N m/rad", 1.0, 0.0), ("kN m/rad", 1e3, 1e4), ("MN m/rad", 1e6, 1e7))),
    Quantity("turning damping", "N m s/rad", (("N m s/rad", 1.0, 0.0), ("kN m s/rad", 1e3, 1e4))),
    Quantity("pressure", "Pa", (("Pa", 1.0, 0.0), ("kPa", 1e3, 1e3), ("MPa", 1e6, 1e5)), {"bar": 1e5, "GPa": 1e9, "N/mm2": 1e6}),
    Quantity("p v", "W/m2", (("W/m²", 1.0, 0.0), ("W/mm²", 1e6, 1e3))),
    Quantity("compliance", "m/N", (("µm/kN", 1e-9, 0.0),)),
    Quantity("slope", "m/m", (("µm/m", 1e-6, 0.0),)),
    Quantity("expansion", "m/K", (("µm/K", 1e-6, 0.0),)),
    Quantity("share", "-", (("%", 1e-2, 0.0),)),
    Quantity("number", "-", (), {"%": 1e-2}),
    Quantity("density", "kg/m3", (), {"t/m3": 1e3}),
    Quantity("curvature", "1/m", (), {"1/mm": 1e3}),
    Quantity("area", "m2", (), {"cm2": 1e-4, "mm2": 1e-6}),
    Quantity("volume", "m3", (), {"l": 1e-3, "cm3": 1e-6}),
    Quantity("voltage", "V", (), {"kV": 1e3}),
    Quantity("current", "A", (), {"mA": 1e-3, "kA": 1e3}),
    Quantity("capacitance", "F", (("mF", 1e-3, 0.0), ("F", 1.0, 1.0))),
)
# Units that several rows have: the row that is taken.
_FIRST = {
    "-": "number",
    "m": "length",
    "mm": "length",
    "rad": "angle",
    "rad/s": "rotational speed",
    "Hz": "frequency",
    "%": "share",
    "g": "mass",
}


@cache
def quantity(key: str) -> Quantity:
    """The row of a quantity by its name, or by a unit, in which values are then given. A unit of no row is a row of its own."""
    row = _row(key)
    return row if row.name == key else row.in_unit(key)


def _row(key: str) -> Quantity:
    named = {row.name: row for row in QUANTITIES}
    key = _FIRST.get(key, key)
    for rows in (named, {row.unit: row for row in QUANTITIES}, {unit: row for row in QUANTITIES for unit in row.sizes()}):
        if key in rows:
            return rows[key]
    return Quantity(key, key)


@cache
def readable(unit: str) -> Mapping[str, float]:
    """All units in which a quantity is read -> how large they are in ``unit``, which comes first."""
    sizes = _row(unit).sizes()
    if unit == "-":
        return {"-": 1.0, "%": 1e-2}
    own = sizes.get(unit, 1.0)
    return {unit: 1.0, **{name: size / own for name, size in sizes.items() if name != unit}}
