"""The table that a sweep returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.errors import UnknownNameError
from ..common.frozen import Frozen, read_only
from ..common.results import Tabular
from .execution import Outcome
from .grid import Grid, Scalar

Column = NDArray[Any]


@dataclass(frozen=True)
class FailedPoint(Frozen):
    """A point at which the function failed.

    Attributes:
        number: of the point in the order of the grid.
        point: name of every axis -> label.
        error: type and text of the exception.
    """

    number: int
    point: Mapping[str, Scalar]
    error: str


@dataclass(frozen=True, eq=False, repr=False)
class SweepTable(Tabular):
    """Results at all points, in the order of the grid (last axis fastest), whatever the order in which they were finished.

    Attributes:
        function: name of the function.
        axes: name -> labels.
        paired: the axes run side by side.
        shape: lengths of the axes; (n,) where they run side by side.
        values: name -> (n,): the axes' labels, then the results: masked arrays, masked at points that failed or are missing. Read-only.
        failed: the points that failed, with their errors.
        missing: numbers of the points that are not done yet; there are none but in what `read` finds of a sweep that was stopped.
    """

    function: str
    axes: Mapping[str, tuple[Scalar, ...]]
    paired: bool
    shape: tuple[int, ...]
    values: Mapping[str, Column]
    failed: tuple[FailedPoint, ...]
    missing: tuple[int, ...] = ()

    @property
    def title(self) -> str:
        return f"SweepTable of {self.function}: {self._size} points, {self._not_there}"

    def __str__(self) -> str:
        over = " side by side" if self.paired else ""
        lines = [f"{self.function} at {self._size} points, {self._not_there}; axes{over}"]
        lines += [f"  {name:26}{len(labels):6} values, {_ends(labels)}" for name, labels in self.axes.items()]
        lines += ["", f"{'Results':28}{'smallest':>14}{'largest':>14}"]
        for name in self._results:
            values = np.ma.compressed(self.values[name])
            numeric = values.dtype.kind in "if"
            ends = f"{values.min():14.6g}{values.max():14.6g}" if numeric and len(values) else f"{len(set(values.tolist())):14} different"
            lines.append(f"  {name:26}{ends}")
        lines += ["", "Failed"] if self.failed else []
        lines += [f"  {', '.join(f'{k}={v}' for k, v in bad.point.items())}: {bad.error.splitlines()[0]}" for bad in self.failed[:5]]
        lines += [f"  and {len(self.failed) - 5} more"] if len(self.failed) > 5 else []
        return "\n".join(lines)

    def columns(self) -> dict[str, Column | list[str]]:
        """The values, and the errors of points that failed."""
        errors = [""] * self._size
        for bad in self.failed:
            errors[bad.number] = bad.error
        return dict(self.values) | {"error": errors}

    def grid(self, name: str) -> Column:
        """A result as an array of the axes' lengths, masked at points that failed.

        Raises:
            UnknownNameError: no such result.
        """
        if name not in self.values:
            raise UnknownNameError("result", name, self._results)
        return self.values[name].reshape(self.shape)

    @property
    def _size(self) -> int:
        return int(np.prod(self.shape))

    @property
    def _not_there(self) -> str:
        return f"{len(self.failed)} of which failed" + (f", {len(self.missing)} are not done" if self.missing else "")

    @property
    def _results(self) -> list[str]:
        return [name for name in self.values if name not in self.axes]


def table(function: str, grid: Grid, kinds: Mapping[str, str], known: Mapping[int, Outcome]) -> SweepTable:
    """The table of a sweep of which the outcomes of some points are known, or of all."""
    nothing = Outcome(-1, {}, "")
    values = [known.get(number, nothing).values for number in range(len(grid))]
    masked = np.array([not found for found in values])
    columns: dict[str, Column] = {name: _column(labels) for name, labels in grid.columns().items()}
    columns |= {
        name: np.ma.MaskedArray(_filled([found.get(name) for found in values], kind), masked.copy()) for name, kind in kinds.items()
    }
    return SweepTable(
        function=function,
        axes=dict(grid.axes),
        paired=grid.paired,
        shape=grid.shape,
        values=read_only(columns),
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
