"""What options give for each driver: of a press with one driver the words alone, of one with several behind the driver's name.

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
    """What reads an option of `argparse`: a speed or position, behind the name of a driver where there is one, ``A=30``.

    Args:
        read: what reads the speed or position.
    """

    def of_driver(text: str) -> tuple[str, OfDriver]:
        name, _, value = text.rpartition("=")  # a driver's name may have an equals sign in it
        return name, read(value)

    return of_driver


def parted(press: Linkage, words: str) -> tuple[str, str]:
    """The name of a driver and what is behind it in ``A:induction:ratio=20``; with one driver, and where no driver is named, no name."""
    begins = [name for name in press.drivers if words.startswith(f"{name}:")]
    if len(press.drivers) == 1 or not begins:
        return "", words
    name = max(begins, key=len)  # a driver's name may have a colon in it
    return name, words[len(name) + 1 :]


def by_driver(press: Linkage, option: str, given: Sequence[tuple[str, T]], example: str) -> dict[str, T]:
    """What an option gives by the names of drivers.

    Args:
        press: the press.
        option: the option, for messages.
        given: names and what stands behind them; a press with one driver needs no name.
        example: what may stand behind a name, with what parts them, for messages.

    Raises:
        PinpressError: several drivers and no name, or something given twice.
        UnknownNameError: a driver that the press does not have.
    """
    found: dict[str, T] = {}
    for name, value in given:
        if not name and len(press.drivers) > 1:
            first = press.drivers[0]
            raise PinpressError(
                f"{option} is of one of the {len(press.drivers)} drivers of {press.name}: write e.g. {option} {first}{example}"
            )
        driver = name or press.driver
        if driver not in press.drivers:
            raise UnknownNameError("driver", driver, press.drivers)
        if driver in found:
            raise PinpressError(f"{option} of {driver} is given twice: give it once")
        found[driver] = value
    return found
