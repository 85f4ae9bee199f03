"""Numbers of the command line: bare ones in the unit that the help names, others with one of their own (12mm, 4000kN, 70rpm, 15deg)."""

import argparse
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ...common.errors import PinpressError, suggestion
from ...common.quantities import CRANK, RAM, RPM, DriverCoordinate

# Factors to the first unit of each row, which is the one that help and messages name.
_ROWS: tuple[Mapping[str, float], ...] = (
    {"m": 1.0, "mm": 1e-3, "um": 1e-6, "cm": 1e-2, "in": 0.0254},
    {"N": 1.0, "kN": 1e3, "MN": 1e6, "tf": 9806.65},
    {"r/min": 1.0, "rpm": 1.0, "spm": 1.0, "Hz": 60.0, "rad/s": 30 / math.pi, "deg/s": 1 / 6},
    {"deg": 1.0, "rad": 180 / math.pi},
    {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
    {"kg": 1.0, "g": 1e-3, "t": 1e3},
    {"m2": 1.0, "cm2": 1e-4, "mm2": 1e-6},
    {"kg m2": 1.0, "kgm2": 1.0},
    {"N m": 1.0, "Nm": 1.0, "kNm": 1e3, "MNm": 1e6},
    {"W": 1.0, "kW": 1e3, "MW": 1e6},
    {"Hz": 1.0, "kHz": 1e3},
    {"m/s": 1.0, "mm/s": 1e-3},
    {"mm": 1.0, "m": 1e3, "um": 1e-3, "cm": 10.0, "in": 25.4},
    {"mm/s": 1.0, "m/s": 1e3, "m/min": 1e3 / 60},
    {"m/s2": 1.0, "mm/s2": 1e-3},
    {"rad/s2": 1.0, "deg/s2": math.pi / 180},
    {"W/(N m)2": 1.0},
    {"W s2/rad2": 1.0},
    {"s/rad": 1.0},
    {"V": 1.0, "kV": 1e3},
    {"N/m": 1.0, "kN/m": 1e3, "kN/mm": 1e6, "N/mm": 1e3, "MN/m": 1e6, "GN/m": 1e9},
    {"N/m^1.5": 1.0},
    {"N s/m": 1.0, "Ns/m": 1.0, "kNs/m": 1e3},
    {"N m/rad": 1.0, "Nm/rad": 1.0, "kNm/rad": 1e3},
    {"N m s/rad": 1.0, "Nms/rad": 1.0, "kNms/rad": 1e3},
    {"Pa": 1.0, "bar": 1e5, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/mm2": 1e6},
    {"m3": 1.0, "l": 1e-3, "cm3": 1e-6},
    {"N/m^e": 1.0},
    {"N s^e/m^e": 1.0},
    {"Shore A": 1.0},
    {"K": 1.0},
    {"1/K": 1.0},
    {"-": 1.0, "%": 1e-2},
)
UNITS = {next(iter(row)): row for row in _ROWS}
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z%].*?)?\s*")


def read_quantity(text: str, unit: str) -> float:
    """The number of a text, in a unit that `UNITS` has.

    Raises:
        ValueError: it is no number, or its unit is of something else; the message says what to write.
    """
    parts = _NUMBER.fullmatch(text)
    if parts is None:
        try:
            return float(text)  # inf and nan, which are refused where the number is used
        except ValueError:
            remedy = ": write decimals after a point" if re.fullmatch(r"\s*[-+]?\d+,\d+.*", text) else ""
            raise ValueError(f"no number{remedy}") from None
    number, given = parts.groups()
    known = UNITS[unit]
    if given and given not in known:
        raise ValueError(f"in {given!r}, which is none of {', '.join(known)}{suggestion(given, known)}")
    return float(number) * known[given] if given else float(number)


def quantity(unit: str) -> Callable[[str], float]:
    """What reads an option of `argparse`: a number in this unit, or with a unit of its own."""

    def read(text: str) -> float:
        try:
            return read_quantity(text, unit)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"{text!r} is {error}") from None

    return read


@dataclass(frozen=True)
class OfDriver:
    """A speed, position or effort of the driver as it was given, whose unit depends on the press.

    Attributes:
        text: As given.
        turning: Unit of a bare number where the driver turns, "r/min", "deg" or "N m".
        sliding: Unit of a bare number where it slides, "mm/s", "mm" or "N".
    """

    text: str
    turning: str
    sliding: str

    def of(self, coordinate: DriverCoordinate) -> float:
        """The number in SI units, of a driver with this coordinate.

        Raises:
            PinpressError: its unit is of something else.
        """
        unit = self.turning if coordinate.turns else self.sliding
        try:
            number = read_quantity(self.text, unit)
        except ValueError:
            wrong, does = f"{self.text!r} does not go with a driver that", "turns" if coordinate.turns else "slides"
            raise PinpressError(
                f"{wrong} {does}: give a number in one of {', '.join(UNITS[unit])}; without a unit it is in {unit}"
            ) from None
        return math.radians(number) if unit == "deg" else number * {"r/min": RPM, "N m": 1.0, "N": 1.0}.get(unit, 1e-3)


def driver_speed(text: str) -> OfDriver:
    """Reads an option of `argparse`: a speed of the driver."""
    return _of_driver(text, CRANK.shown_speed[0], RAM.shown_speed[0])


def driver_position(text: str) -> OfDriver:
    """Reads an option of `argparse`: a crank angle, or the position of a driver that slides."""
    return _of_driver(text, CRANK.shown_unit, RAM.shown_unit)


def driver_effort(text: str) -> OfDriver:
    """Reads an option of `argparse`: a torque at the driver joint, or the force of a driver that slides."""
    return _of_driver(text, CRANK.effort_unit, RAM.effort_unit)


def _of_driver(text: str, turning: str, sliding: str) -> OfDriver:
    try:
        read_quantity(text, sliding)
    except ValueError:
        quantity(turning)(text)  # refuses what is neither
    return OfDriver(text, turning, sliding)
