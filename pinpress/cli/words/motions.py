"""Options of the motion of a press: a period at constant speed, or --motion of one or several drivers by a table."""

from __future__ import annotations

import argparse

from ...common.errors import PinpressError
from ...kinematics.cycle import POINTS, cycle
from ...kinematics.motion import Motion
from ...kinematics.motion_table import read_motion
from ...linkage.linkage import Linkage
from .units import OfDriver, driver_speed, quantity

SPEED = "crank speed, in r/min, negative: backwards; highest speed of a sliding driver, in mm/s"
MOTION = (
    "CSV file with the motion of one or several drivers over time; its first line names the columns with their units: time [s], and the"
    " name of every driver, A [deg], or ram_guide [mm] of a sliding driver"
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
    help = "time in s after which the motion of --motion begins again (default: it does not repeat)"
    parser.add_argument("--period", type=quantity("s"), metavar="S", help=help)


def motion_of(press: Linkage, options: argparse.Namespace, speed: OfDriver | None, a_turn: int = POINTS, engine: str = "auto") -> Motion:
    """Read the motion of `add_motion_options`: a period at constant speed, or the motion of a table.

    Args:
        press: the press.
        options: options of `add_motion_options`, and --points.
        speed: the speed, or one of several; None for the motion of a table.
        a_turn: states of a turn at constant speed, or of the period of a sliding driver, if --points is not given.
        engine: as for `cycle`.

    Raises:
        PinpressError: options do not go together, a press with several drivers has a speed in place of a motion, or as for `cycle` and
            `read_motion`.
    """
    first = press.driver_coordinates[0]
    if speed is None:
        if options.points is not None:
            raise PinpressError("--points is for a period at constant speed: leave it out, because --motion has its states")
        return read_motion(press, options.motion, period=options.period, engine=engine)
    if options.period is not None:
        raise PinpressError("--period is for --motion; at constant speed the press determines the period: leave it out")
    refuse_without_motion(press, "one speed does not determine the motion of several drivers")
    points = a_turn * (press.period_turns if first.turns else 1) if options.points is None else options.points
    return cycle(press, speed=speed.of(first), points=points, engine=engine)


def refuse_without_motion(press: Linkage, why: str) -> None:
    """Refuse a press with several drivers without their motion; ``why``: the reason."""
    columns = ", ".join(f"{name} [{each.shown_unit}]" for name, each in zip(press.drivers, press.driver_coordinates, strict=True))
    press.refuse_several_drivers(f"{why}; give --motion FILE, a table with the columns time [s], {columns}")


def refuse_beside_motion(options: argparse.Namespace, *names: str) -> None:
    """Refuse options for constant speed together with --motion."""
    if options.motion is not None and (given := [name for name in names if getattr(options, name) not in (None, [], False)]):
        option = f"--{given[0].replace('_', '-')}"
        raise PinpressError(f"{option} is for a press at constant speed: give --speed in place of --motion, or leave {option} out")
