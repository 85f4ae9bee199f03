"""Our curves in the axes of a document's figures, with its printed numbers as grey marks."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..common.arrays import Array
from ..plots.style import COLOURS, GREY, LINES, above, drawing, grid, plain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Panel:
    """One pair of axes.

    Attributes:
        label: of the upright axis, with its unit. curves: name -> (x, y), both (n,).
        levels: values of the upright axis that the document prints. points: (x, y) that it prints.
        logarithmic: whether the upright axis is.
    """

    label: str
    curves: dict[str, tuple[Array, Array]]
    levels: Sequence[float] = ()
    points: Sequence[tuple[float, float]] = ()
    logarithmic: bool = False


def draw(across: str, panels: Sequence[Panel], high: float = 4.2, columns: int = 1) -> "Figure":
    """Panels over one quantity ``across``, row by row; ``high``: of each [cm]. Grey dashes and crosses are printed numbers."""
    rows = -(-len(panels) // columns)
    with drawing(1.0 + high * rows) as figure:
        places = figure.subplots(rows, columns, sharex=True, squeeze=False)
        for k, panel in enumerate(panels):
            axes = places[k // columns, k % columns]
            grid(axes, panel.label)
            lines: list[Artist] = []
            for i, (x, y) in enumerate(panel.curves.values()):
                lines += axes.plot(x, y, color=COLOURS[i % len(COLOURS)], linestyle=LINES[i % len(LINES)])
            for level in panel.levels:
                axes.axhline(level, color=GREY, linestyle=(0, (2, 2)), linewidth=0.9)
            if panel.points:
                axes.plot(*np.transpose(panel.points), color=GREY, marker="x", markersize=5.0, linestyle="none")
            if panel.logarithmic:
                axes.set_yscale("log")
            if len(lines) > 1:
                above(axes, lines, list(panel.curves))
            if k // columns == rows - 1:
                plain(axes.set_xlabel(across))
        figure.align_ylabels()
    return figure
