"""Read options for each driver: without a name for a press with one driver, else after the driver's name.

--speed 70                            one driver
--speed A=30 --speed B=-30            several drivers
--motor A:induction:rated_power=5kW   of several drivers that of A
"""

from collections.abc import Callable, Sequence
from typing import TypeVar

from ...common.errors import PinpressError, UnknownNameError
from ...linkage.linkage import Linkage
from .units import OfDriver

T = TypeVar("T")


def named(read: Callable[[str], OfDriver]) -> Callable[[str], tuple[str, OfDriver]]:
    """Make a reader for `argparse` of a speed or position, optionally after the name of a driver, ``A=30``.

    Args:
        read: reader of the speed or position.
    """

    def of_driver(text: str) -> tuple[str, OfDriver]:
        name, _, value = text.rpartition("=")  # a driver's name may have an equals sign in it
        return name, read(value)

    return of_driver


def parted(press: Linkage, words: str) -> tuple[str, str]:
    """Split ``A:induction:ratio=20`` into the driver's name and the rest; the name is empty with one driver or no name."""
    begins = [name for name in press.drivers if words.startswith(f"{name}:")]
    if len(press.drivers) == 1 or not begins:
        return "", words
    name = max(begins, key=len)  # a driver's name may have a colon in it
    return name, words[len(name) + 1 :]


def by_driver(press: Linkage, option: str, given: Sequence[tuple[str, T]], example: str) -> dict[str, T]:
    """Read the values of an option by the names of drivers.

    Args:
        press: the press.
        option: the option, for messages.
        given: names and values; a press with one driver needs no name.
        example: separator and example of a value, for messages.

    Raises:
        PinpressError: there are several drivers but no name, or a driver is given twice.
        UnknownNameError: the press has no such driver.
    """
    found: dict[str, T] = {}
    for name, value in given:
        if not name and len(press.drivers) > 1:
            first = press.drivers[0]
            raise PinpressError(
                f"{option} needs the name of one of the {len(press.drivers)} drivers of {press.name}: write e.g. {option} {first}{example}"
            )
        driver = name or press.driver
        if driver not in press.drivers:
            raise UnknownNameError("driver", driver, press.drivers)
        if driver in found:
            raise PinpressError(f"{option} of {driver} is given twice: give it once")
        found[driver] = value
    return found
