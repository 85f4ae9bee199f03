"""How commands move a press: a period at constant speed, or with --motion, of one driver or several, as a table says."""

from __future__ import annotations

import argparse

from ...common.errors import PinpressError
from ...kinematics.cycle import POINTS, cycle
from ...kinematics.motion import Motion
from ...kinematics.motion_table import read_motion
from ...linkage.linkage import Linkage
from .units import OfDriver, driver_speed, quantity

SPEED = "crank speed, in r/min, negative: backwards; highest speed of a driver that slides, in mm/s"
MOTION = (
    "CSV file with the motion of one driver or several over time; its first line names the columns with their units: time [s], and the"
    " name of every driver, A [deg], or ram_guide [mm] of one that slides"
)


def add_motion_options(parser: argparse.ArgumentParser, *, several: bool = False) -> None:
    """Options of `motion_of`: --speed, or --motion with --period; ``several``: whether --speed may be given several times."""
    one_of = parser.add_mutually_exclusive_group(required=True)
    worst = f"{SPEED}; may be given several times: each criterion then counts at its worst speed"
    action = "append" if several else "store"
    one_of.add_argument("--speed", type=driver_speed, action=action, metavar="RPM", help=worst if several else SPEED)
    one_of.add_argument("--motion", metavar="FILE", help=f"in place of --speed: {MOTION}")
    add_period_option(parser)


def add_period_option(parser: argparse.ArgumentParser) -> None:
    """Option --period, of a motion from a table."""
    help = "time in s after which the motion of --motion begins again (default: it is not closed)"
    parser.add_argument("--period", type=quantity("s"), metavar="S", help=help)


def motion_of(press: Linkage, options: argparse.Namespace, speed: OfDriver | None, a_turn: int = POINTS, engine: str = "auto") -> Motion:
    """The motion of `add_motion_options`: a period at constant speed, or that of a table.

    Args:
        press: the press.
        options: those of `add_motion_options`, and --points.
        speed: the speed, or one of several; None where the motion is that of a table.
        a_turn: states of a turn at constant speed where --points is not given; of a driver that slides those of the period.
        engine: as of `cycle`.

    Raises:
        PinpressError: options do not go together, a press with several drivers has a speed in place of a motion, or as `cycle` and
            `read_motion`.
    """
    first = press.driver_coordinates[0]
    if speed is None:
        if options.points is not None:
            raise PinpressError("--points is of a period at constant speed: leave it out, the states are those of --motion")
        return read_motion(press, options.motion, period=options.period, engine=engine)
    if options.period is not None:
        raise PinpressError("--period is that of --motion, and at constant speed the press has its own: leave it out")
    refuse_without_motion(press, "one speed does not say how they move together")
    points = a_turn * (press.period_turns if first.turns else 1) if options.points is None else options.points
    return cycle(press, speed=speed.of(first), points=points, engine=engine)


def refuse_without_motion(press: Linkage, why: str) -> None:
    """Raise PinpressError where the press has several drivers, whose motion is not given; ``why``: it is needed."""
    columns = ", ".join(f"{name} [{each.shown_unit}]" for name, each in zip(press.drivers, press.driver_coordinates, strict=True))
    press.refuse_several_drivers(f"{why}; give --motion FILE, a table with the columns time [s], {columns}")


def refuse_beside_motion(options: argparse.Namespace, *names: str) -> None:
    """Raise PinpressError where one of these options, which are for constant speed, is given beside --motion."""
    if options.motion is not None and (given := [name for name in names if getattr(options, name) not in (None, [], False)]):
        option = f"--{given[0].replace('_', '-')}"
        raise PinpressError(f"{option} is for a press at constant speed: give --speed in place of --motion, or leave {option} out")
