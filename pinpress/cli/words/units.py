"""Read numbers of the command line: without a unit (then the help names it) or with a unit (12mm, 4000kN, 70rpm, 15deg)."""

import argparse
from collections.abc import Callable
from dataclasses import dataclass

from ...common import quantities
from ...common.arguments import read_quantity as read_quantity
from ...common.errors import PinpressError
from ...common.quantities import CRANK, RAM, DriverCoordinate, readable


def quantity(unit: str) -> Callable[[str], float]:
    """Make a reader for `argparse` of a number in this unit, or with another unit."""

    def read(text: str) -> float:
        try:
            return read_quantity(text, unit)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"{text!r} is {error}") from None

    return read


@dataclass(frozen=True)
class OfDriver:
    """A speed, position or effort of the driver as text; its unit depends on the press.

    Attributes:
        text: Text of the option.
        turning: Unit of a number without a unit if the driver turns: "r/min", "deg" or "N m".
        sliding: Unit of a number without a unit if the driver slides: "mm/s", "mm" or "N".
    """

    text: str
    turning: str
    sliding: str

    def of(self, coordinate: DriverCoordinate) -> float:
        """Read the number in SI units, for a driver with this coordinate.

        Raises:
            PinpressError: its unit belongs to another quantity.
        """
        unit = self.turning if coordinate.turns else self.sliding
        try:
            number = read_quantity(self.text, unit)
        except ValueError:
            wrong, does = f"{self.text!r} does not go with a driver that", "turns" if coordinate.turns else "slides"
            raise PinpressError(
                f"{wrong} {does}: give a number in one of {', '.join(readable(unit))}; without a unit it is in {unit}"
            ) from None
        return number * quantities.si_size(unit)


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
