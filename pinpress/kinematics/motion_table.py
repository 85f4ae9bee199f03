"""A motion from a file: a table with a column of time, and one for every driver.

    time [s], A [deg], ram_guide [mm]
    0.00,     0.0,     0.0
    0.01,     3.6,     0.1

A motion that pinpress wrote is read back with its speeds and accelerations, by the names of its columns.
"""

from __future__ import annotations

import math
import os

import numpy as np

from ..common.arguments import typed, unit_factor
from ..common.errors import PinpressError
from ..common.quantities import RPM, Array, DriverCoordinate
from ..common.reading.columns import TIMES, Channels, Column, read_channels
from ..linkage.linkage import Linkage
from .motion import Motion
from .servo_motion import servo_cycle


@typed
def read_motion(press: Linkage, path: str | os.PathLike[str], *, period: float | None = None, engine: str = "auto") -> Motion:
    """Move a press as a table says, over time.

    The table has a column ``time [s]``, and for every driver one with its name and unit, ``A [deg]``, ``ram_guide [mm]``. With one driver
    this column may also be called ``angle [deg]``, or ``position [mm]`` where the driver slides. Speeds and accelerations are derived as by
    `servo_cycle`. A table that pinpress wrote (`Motion.to_csv`, `Reactions.to_csv`) has them, and they are taken from it. Other columns are
    left alone.

    Args:
        press: the press, with one driver or several.
        path: a .csv or .txt file with commas, semicolons (then also with decimal commas) or tabs between the columns, whose names stand in
            its first line; or a .parquet, .mat or .mf4 file.
        period: as of `servo_cycle`: time after which the motion begins again [s]; None: the motion is not closed.
        engine: as of `servo_cycle`.

    Returns:
        The motion; with n states of several drivers crank_angle, crank_speed and crank_acceleration are (n, drivers), in the order of
        `Linkage.drivers` [rad or m].

    Raises:
        PinpressError: the file cannot be read, lacks a column or a unit, or as `servo_cycle`; the message names the file.
        SingularityError: the linkage locks within the motion.
        AssemblyError: the loops do not close.

    Warns:
        PinpressWarning: as `servo_cycle`.
    """
    table = read_channels(path, [*TIMES, *(name for order in range(3) for names in _names(press, order) for name in names)])
    angle, speed, acceleration = (_rates(press, table, order) for order in range(3))
    if angle is None:
        raise PinpressError(_lacking(press, table))
    time = _time(table)
    try:
        return servo_cycle(press, angle, speed=speed, acceleration=acceleration, time=time, period=period, engine=engine)
    except PinpressError as error:
        if type(error) is not PinpressError:  # others say where the linkage locks or opens
            raise
        raise PinpressError(f"{table.file}: {error}") from None


def _names(press: Linkage, order: int) -> list[tuple[str, ...]]:
    """For every driver the names that a column of its coordinate (order 0), speed (1) or acceleration (2) may have."""
    names_by_driver = []
    for driver, coordinate in zip(press.drivers, press.driver_coordinates, strict=True):
        head = coordinate.heads[order][0]
        if len(press.drivers) > 1:
            names: tuple[str, ...] = (f"{head}_{driver}",)
        else:
            names = (head,) if order else (head, coordinate.position.split()[-1])
        names_by_driver.append(names if order else (driver, *names))
    return names_by_driver


def _rates(press: Linkage, table: Channels, order: int) -> Array | None:
    """Coordinates, speeds or accelerations of all drivers, (n,) of one and (n, drivers) of several; None if the table lacks any."""
    columns = []
    for names, coordinate in zip(_names(press, order), press.driver_coordinates, strict=True):
        name = next((name for name in names if name in table.columns), None)
        if name is None:
            return None
        columns.append(_in_si_units(table, table.column(name), name, coordinate, order))
    return columns[0] if len(columns) == 1 else np.column_stack(columns)


def _in_si_units(table: Channels, column: Column, name: str, coordinate: DriverCoordinate, order: int) -> Array:
    turns = coordinate.turns
    unit = (("deg", "r/min", "rad/s2") if turns else ("m", "m/s", "m/s2"))[order]
    if not column.unit:
        written = f"{name} [{coordinate.shown_unit if order == 0 else unit}]"
        raise PinpressError(f"{table.file}: column {name!r} has no unit: write it behind the name, {written}")
    factor = _factor(table, name, column.unit, unit)
    return column.values * (factor * (math.radians(1.0), RPM, 1.0)[order] if turns else factor)


def _factor(table: Channels, name: str, given: str, unit: str) -> float:
    try:
        return unit_factor(given, unit)
    except ValueError as error:
        raise PinpressError(f"{table.file}: column {name!r} is {error}") from None


def _time(table: Channels) -> Array:
    """Times (n,) of the table [s]."""
    if table.time is not None:
        return table.time
    name = next((name for name in table.columns if name.lower() in TIMES), None)
    if name is None:
        raise PinpressError(f"{table.file} has no column of time: call it time [s]; there are: {', '.join(table.columns)}")
    column = table.column(name)
    return column.values * _factor(table, name, column.unit or "s", "s")


def _lacking(press: Linkage, table: Channels) -> str:
    """Which driver has no column."""
    for driver, coordinate, names in zip(press.drivers, press.driver_coordinates, _names(press, 0), strict=True):
        if not any(name in table.columns for name in names):
            missing = f"{table.file} has no column for driver {driver!r} of {press.name}"
            unit = coordinate.shown_unit
            called = " or ".join(f"{name} [{unit}]" for name in (names[0], *names[2:]))  # names[1] is that of files of pinpress
            return f"{missing}: call it {called}; there are: {', '.join(table.columns)}"
    raise AssertionError("a driver has no column")
