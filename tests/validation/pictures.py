"""Our curves in the axes of a document's figure, with its printed numbers as grey dashes and crosses."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pinpress.common.quantities import Array
from pinpress.plots.style import COLOURS, GREY, LINES, STYLE, drawing, grid

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Panel:
    """One pair of axes.

    Attributes:
        label: label of the upright axis, with its unit.
        curves: name -> (x, y), both (n,).
        levels: values of the upright axis that the document prints.
        logarithmic: whether the upright axis is logarithmic.
    """

    label: str
    curves: dict[str, tuple[Array, Array]]
    levels: Sequence[float] = ()
    logarithmic: bool = False


def draw(across: str, panels: Sequence[Panel], high: float) -> "Figure":
    """Panels below each other, which share the axis with the label ``across``, each ``high`` [cm]."""
    with drawing(1.0 + high * len(panels)) as figure:
        axes = figure.subplots(len(panels), sharex=True, squeeze=False)[:, 0]
        for ax, panel in zip(axes, panels, strict=True):
            grid(ax, panel.label)
            for k, (name, (x, y)) in enumerate(panel.curves.items()):
                ax.plot(x, y, color=COLOURS[k % len(COLOURS)], linestyle=LINES[k % len(LINES)], label=name)
            for level in panel.levels:
                ax.axhline(level, color=GREY, linestyle=(0, (2, 2)), linewidth=0.9)
            if panel.logarithmic:
                ax.set_yscale("log")
            if len(panel.curves) > 1:
                ax.legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(panel.curves))
        axes[-1].set_xlabel(across)
        figure.align_ylabels()
    return figure


def save(figure: "Figure", path: Path) -> None:
    """A PNG file for a screen, while `plots.save` writes for print. The same figure gives the same bytes."""
    from matplotlib import style  # optional, and slow to import

    with style.context(["default", STYLE]):
        figure.savefig(path, dpi=110, metadata={"Software": None})
