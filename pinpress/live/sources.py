"""What the window shows and changes: a press in Python, a URDF (or SDF, MJCF) file, or a pin table, with the numbers by which it can be
changed, and a file to write the changed press to.

The numbers of a pin table are those of its text, and the changed table is this text with other numbers. The numbers of every other press
are lengths and pivots (`live.dimensions`), and a URDF is written.
"""

from __future__ import annotations

import os
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from ..common import files
from ..common.errors import PinpressError
from ..derivatives.reshape import reshaped
from ..linkage.linkage import Linkage
from ..linkage.loading import presses
from ..linkage.writing import write_urdf
from ..pin_table.building import draft, drawn_from
from ..pin_table.formulas import parameters_of
from ..pin_table.numbers import TableNumber, numbers_of, rewritten, with_numbers
from ..pin_table.placement import UNITS
from ..pin_table.reading import Entry
from .dimensions import REACH, TURN, Dimension, LinkageDimensions, dimension
from .drivers import with_moving

TABLES = (".yaml", ".yml")  # ends of the names of pin tables


@dataclass(frozen=True, eq=False)
class Source(ABC):
    """A press that is shown, and the numbers by which it can be changed.

    Attributes:
        press: the press as it was given.
        dimensions: the numbers, with their values in the press as it was given.
        files: the files that it was read from.
        folder: where changed presses are written.
        suggested: name of the file to write a changed press to.
        suffixes: ends of the names of files that it can be written to.
    """

    press: Linkage
    dimensions: tuple[Dimension, ...]
    files: tuple[str, ...]
    folder: Path
    suggested: str
    suffixes: tuple[str, ...]

    @abstractmethod
    def changed(self, values: Sequence[float]) -> Linkage:
        """The press with other values of its dimensions; raises PinpressError where they make none."""

    @abstractmethod
    def made_up(self, values: Sequence[float]) -> Collection[str]:
        """The links whose own shapes no longer fit."""

    @abstractmethod
    def write(self, values: Sequence[float], path: Path) -> None:
        """Write the changed press; raises PinpressError where that fails."""


@dataclass(frozen=True, eq=False)
class LinkageSource(Source):
    """A press by its lengths and pivots."""

    _of_linkage: LinkageDimensions

    @staticmethod
    def of(press: Linkage, *paths: str) -> LinkageSource:
        """A press, and the files that it was read from, its own first; no file for a press made in Python or a shipped one."""
        one = with_moving(press, press.driver, [0.0] * len(press.drivers))  # in the plane where it can be
        found = LinkageDimensions.of(one)
        folder = Path(paths[0]).resolve().parent if paths else Path.cwd()
        called = Path(paths[0]).stem if paths else re.sub(r"\W", "_", press.name)
        return LinkageSource(press, found.shown, paths, folder, f"{called}_changed.urdf", (".urdf",), found)

    def changed(self, values: Sequence[float]) -> Linkage:
        moved = self._of_linkage.pivots(values)
        return reshaped(self.press, moved) if moved else self.press

    def made_up(self, values: Sequence[float]) -> Collection[str]:
        model = self.press.model
        joints = {link: model.frames[model.getFrameId(link, pin.BODY)].parentJoint for _, link in self._of_linkage.pivots(values)}
        return {link for link, joint in joints.items() if joint and self.press.axes[joint - 1].turns}  # large frames and slides stay

    def write(self, values: Sequence[float], path: Path) -> None:
        write_urdf(self.changed(values), path)


@dataclass(frozen=True, eq=False)
class TableSource(Source):
    """A pin table by its own numbers."""

    _text: str
    _table: Entry
    _numbers: tuple[TableNumber, ...]
    _given: Mapping[tuple[str, ...], float]
    _slide: str | None
    _finished: Callable[[Linkage], Linkage]

    @staticmethod
    def of(path: str, parameters: Mapping[str, str], slide: str | None, finished: Callable[[Linkage], Linkage]) -> Source:
        """A table with these values of its parameters and this slide; ``finished``: what is done to each press that is made of it. A table
        that is based on another one, which has most numbers, is changed by its lengths and pivots."""
        found = draft(path, **parameters)
        table = found._table
        press = finished(found.press(slide=slide))
        read = tuple(dict.fromkeys([path, *filter(os.path.exists, _files_of(table))]))  # parameters that are given are in none
        if len(read) > 1:
            return LinkageSource.of(press, *read)
        given = parameters_of({"parameters": table.items("a table")["parameters"]}) if parameters else {}
        numbers = numbers_of(table.file_text)
        values = {each.path: given[each.path[1]] if each.path[0] == "parameters" and given else each.value for each in numbers}
        unit = UNITS[found.unit]
        shown = tuple(_shown(each, values[each.path], found.unit, press.size / unit) for each in numbers)
        own = Path(path)
        suggested = f"{own.stem}_changed{own.suffix}"
        return TableSource(
            press, shown, read, own.resolve().parent, suggested, TABLES, table.file_text, table, numbers, values, slide, finished
        )

    def changed(self, values: Sequence[float]) -> Linkage:
        others = {path: value for path, value in self._by_path(values).items() if value != self._given[path]}
        return self._finished(drawn_from(with_numbers(self._table, others)).press(slide=self._slide)) if others else self.press

    def made_up(self, values: Sequence[float]) -> Collection[str]:
        return ()

    def write(self, values: Sequence[float], path: Path) -> None:
        self.changed(values)  # raises where they make no press
        files.write(path, rewritten(self._text, self._numbers, self._by_path(values)).encode())

    def _by_path(self, values: Sequence[float]) -> dict[tuple[str, ...], float]:
        return {each.path: value for each, value in zip(self._numbers, values, strict=True)}


def _shown(number: TableNumber, value: float, unit: str, size: float) -> Dimension:
    """A number of a table as a slider; ``size`` of the press in the table's unit."""
    if number.kind == "parameter":
        return dimension("parameters", number.path[1], "", value, None if value else 10.0, number.comment)
    pin, keys = number.path[1], number.path[2:]
    if number.kind == "angle":
        return dimension("pins", f"{pin} angle", "deg", value, TURN)
    if number.kind == "length":
        return dimension("pins", f"{pin} {keys[0] if keys[0] == 'length' else f'from {keys[0]}'}", unit, value, None if value else size / 2)
    last = keys[-1]
    axis = {"1": "x", "2": "z"}.get(last, last) if "at" not in keys else {"1": "dx", "2": "dz"}[last]
    return dimension("pins", f"{pin} {axis}", unit, value, REACH * size)


@dataclass(frozen=True, eq=False)
class MovingDriver(Source):
    """A press with several drivers, one of which moves. Its first dimensions are where the drivers stand; that of the moving driver is
    ignored.

    Attributes:
        source: the press with all its drivers.
        moving: name of the driver that moves.
    """

    source: Source
    moving: str

    @staticmethod
    def of(source: Source, moving: str | None = None) -> MovingDriver:
        """A press with several drivers, of which this one moves, by default the first."""
        press = source.press
        driver = moving if moving in press.drivers else press.driver
        standing = tuple(_standing(press, k) for k in range(len(press.drivers)))
        return MovingDriver(
            with_moving(press, driver, [0.0] * len(press.drivers)),
            (*standing, *source.dimensions),
            source.files,
            source.folder,
            source.suggested,
            source.suffixes,
            source,
            driver,
        )

    @property
    def drivers(self) -> tuple[str, ...]:
        return self.source.press.drivers

    def changed(self, values: Sequence[float]) -> Linkage:
        count = len(self.drivers)
        press = self.source.changed(values[count:])
        scales = (coordinate.scale for coordinate in press.driver_coordinates)
        return with_moving(press, self.moving, [value / scale for value, scale in zip(values[:count], scales, strict=True)])

    def made_up(self, values: Sequence[float]) -> Collection[str]:
        return self.source.made_up(values[len(self.drivers) :])

    def write(self, values: Sequence[float], path: Path) -> None:
        self.source.write(values[len(self.drivers) :], path)


def _standing(press: Linkage, k: int) -> Dimension:
    """Where a driver stands, as a slider."""
    coordinate, joint = press.driver_coordinates[k], press.driver_indices[k]
    home = float(press.closed[joint]) * coordinate.scale
    if coordinate.turns:
        return dimension("standing drivers", press.drivers[k], "deg", home, 180.0)
    place = press.slots[joint].start
    limits = press.model.lowerPositionLimit[place], press.model.upperPositionLimit[place]
    low, high = (float(np.clip(limit, -press.size, press.size)) * coordinate.scale for limit in limits)
    found = dimension("standing drivers", press.drivers[k], coordinate.shown_unit, home, max(high - low, 1e-9))
    return replace(found, low=low, high=high)


def _files_of(entry: Entry) -> set[str]:
    """The files in which the entries of a table stand."""
    inner = entry.value.values() if isinstance(entry.value, Mapping) else entry.value if isinstance(entry.value, tuple) else ()
    return {entry.file}.union(*map(_files_of, inner)) if inner else {entry.file}


def opened(
    path: str,
    load: Callable[[str], Linkage],
    parameters: Mapping[str, str],
    slide: str | None = None,
    finished: Callable[[Linkage], Linkage] = lambda press: press,
) -> Source:
    """The press of a file, or a shipped one.

    Args:
        path: of the file, or the name of a shipped press.
        load: what loads a file that is no pin table.
        parameters: values of parameters of a pin table.
        slide: of a pin table, as for `build`.
        finished: what is done to each press that is made of a pin table.

    Raises:
        PinpressError: what `load` raises, or `build` of a table.
    """
    if path.lower().endswith(TABLES):
        return TableSource.of(path, parameters, slide, finished)
    press = load(path)
    shipped = path in presses() and not os.path.exists(path)
    return LinkageSource.of(press) if shipped else LinkageSource.of(press, path)


def state_of_files(paths: Sequence[str]) -> tuple[tuple[int, int, int], ...] | None:
    """What changes when files are saved: time, size and number of each; None while one is not there, as when an editor replaces it."""
    found = []
    for path in paths:
        with suppress(OSError, ValueError):
            status = os.stat(path)
            found.append((status.st_mtime_ns, status.st_size, status.st_ino))
    return tuple(found) if len(found) == len(paths) else None


def checked_name(name: object, source: Source) -> Path:
    """Where a file of this name is written: in the folder of the source, and nowhere else.

    Raises:
        PinpressError: it is no plain name, or does not end as it must.
    """
    wanted = " or ".join(source.suffixes)
    if not (isinstance(name, str) and name.lower().endswith(source.suffixes)):
        raise PinpressError(f"the name must end in {wanted}")
    plain = not name.startswith(".") and not set(name) & set('/\\:*?"<>|') and name.isprintable() and Path(name).name == name
    if plain and len(name.encode()) > 200:  # file systems take 255 bytes; a letter may have four
        raise PinpressError("the name is too long: give one of at most 200 bytes, which are 66 Chinese characters")
    if not plain:
        raise PinpressError("give a plain name, without a folder: the file is written next to the file of the press")
    return source.folder / name


def finite(values: object, count: int) -> list[float]:
    """Values of dimensions as they came from a window.

    Raises:
        PinpressError: they are not as many finite numbers.
    """
    if not (isinstance(values, list) and len(values) == count and all(type(value) in (int, float) for value in values)):
        raise PinpressError(f"these are not {count} numbers")
    if not all(abs(value) < 1e9 for value in values):  # whole numbers in JSON have no largest one
        raise PinpressError("a value is not finite, or too large")
    return [float(value) for value in values]
