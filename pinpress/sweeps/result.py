"""The table that a sweep returns."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common import tables
from ..common.errors import UnknownNameError
from ..common.frozen import Frozen, read_only
from .execution import Outcome
from .grid import Grid, Scalar

Column = NDArray[Any]


@dataclass(frozen=True)
class FailedPoint(Frozen):
    """A point at which the function failed.

    Attributes:
        number: of the point in the order of the grid. point: name of every axis -> label. error: type and text of the exception.
    """

    number: int
    point: Mapping[str, Scalar]
    error: str


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Frozen):
    """Results at all points, in the order of the grid (last axis fastest), whatever the order in which they were finished.

    Attributes:
        function: name of the function. axes: name -> labels. paired: the axes run side by side. shape: lengths of the axes; (n,) where
            they run side by side.
        columns: name -> (n,): the axes' labels, then the results: masked arrays, masked at points that failed or are missing. Read-only.
        failed: the points that failed, with their errors.
        missing: numbers of the points that are not done yet; there are none but in what `read` finds of a sweep that was stopped.
    """

    function: str
    axes: Mapping[str, tuple[Scalar, ...]]
    paired: bool
    shape: tuple[int, ...]
    columns: Mapping[str, Column]
    failed: tuple[FailedPoint, ...]
    missing: tuple[int, ...] = ()

    def __repr__(self) -> str:
        return f"<Sweep of {self.function}: {self._size} points, {self._not_there}>"

    def __str__(self) -> str:
        over = " side by side" if self.paired else ""
        lines = [f"{self.function} at {self._size} points, {self._not_there}; axes{over}"]
        lines += [f"  {name:26}{len(labels):6} values, {_ends(labels)}" for name, labels in self.axes.items()]
        lines += ["", f"{'Results':28}{'smallest':>14}{'largest':>14}"]
        for name in self._results:
            values = np.ma.compressed(self.columns[name])
            numeric = values.dtype.kind in "if"
            ends = f"{values.min():14.6g}{values.max():14.6g}" if numeric and len(values) else f"{len(set(values.tolist())):14} different"
            lines.append(f"  {name:26}{ends}")
        lines += ["", "Failed"] if self.failed else []
        lines += [f"  {', '.join(f'{k}={v}' for k, v in bad.point.items())}: {bad.error.splitlines()[0]}" for bad in self.failed[:5]]
        lines += [f"  and {len(self.failed) - 5} more"] if len(self.failed) > 5 else []
        return "\n".join(lines)

    def grid(self, name: str) -> Column:
        """A result as an array of the axes' lengths, masked at points that failed.

        Raises:
            UnknownNameError: no such result.
        """
        if name not in self.columns:
            raise UnknownNameError("result", name, self._results)
        return self.columns[name].reshape(self.shape)

    def to_frame(self) -> tables.DataFrame:
        """The columns, and one of errors, as a pandas DataFrame; results of failed points are missing values there."""
        return tables.frame(self._lists)

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the columns, and one of errors, a point a line, to full precision; results of failed points are left empty."""
        tables.write_csv(path, self._lists)

    def to_parquet(self, path: str | os.PathLike[str]) -> None:
        """Write the same as a Parquet file; results of failed points are null. Needs pyarrow.

        Raises:
            PinpressError: the file cannot be written, or pyarrow is not installed.
        """
        from .parquet import write_columns

        write_columns(path, self._lists)

    @property
    def _size(self) -> int:
        return int(np.prod(self.shape))

    @property
    def _not_there(self) -> str:
        return f"{len(self.failed)} of which failed" + (f", {len(self.missing)} are not done" if self.missing else "")

    @property
    def _results(self) -> list[str]:
        return [name for name in self.columns if name not in self.axes]

    @cached_property
    def _lists(self) -> dict[str, list[object]]:
        errors = [""] * self._size
        for bad in self.failed:
            errors[bad.number] = bad.error
        return {name: values.tolist() for name, values in self.columns.items()} | {"error": list[object](errors)}


def table(function: str, grid: Grid, kinds: Mapping[str, str], known: Mapping[int, Outcome]) -> Sweep:
    """The table of a sweep of which the outcomes of some points are known, or of all."""
    nothing = Outcome(-1, {}, "")
    values = [known.get(number, nothing).values for number in range(len(grid))]
    masked = np.array([not found for found in values])
    columns: dict[str, Column] = {name: _column(labels) for name, labels in grid.columns().items()}
    columns |= {
        name: np.ma.MaskedArray(_filled([found.get(name) for found in values], kind), masked.copy()) for name, kind in kinds.items()
    }
    return Sweep(
        function=function,
        axes=dict(grid.axes),
        paired=grid.paired,
        shape=grid.shape,
        columns=read_only(columns),
        failed=tuple(
            FailedPoint(number, dict(zip(grid.axes, grid.labels(number), strict=True)), known[number].error)
            for number in sorted(known)
            if known[number].error
        ),
        missing=tuple(number for number in range(len(grid)) if number not in known),
    )


def _column(labels: list[Scalar]) -> Column:
    """Labels as an array; of different kinds as objects, which NumPy would make words."""
    kinds = {str if isinstance(label, str) else bool if isinstance(label, bool) else float for label in labels}
    return np.array(labels) if len(kinds) == 1 else np.array(labels, dtype=object)


def _filled(values: list[Scalar | None], kind: str) -> Column:
    """Results as an array. What the mask hides must not pass for a result where it is taken off: not a number, or nothing."""
    if kind != "number":
        return np.array(values, dtype=object if None in values else None)
    if None in values:
        return np.array([np.nan if value is None else value for value in values], dtype=float)
    return np.array(values)


def _ends(labels: tuple[Scalar, ...]) -> str:
    first, last = (f"{label:.6g}" if isinstance(label, float) else f"{label}" for label in (labels[0], labels[-1]))
    return first if len(labels) == 1 else f"{first} to {last}" if len(labels) > 2 else f"{first}, {last}"
