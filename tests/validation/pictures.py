"""Our curves in the axes of a document's figure, with its printed numbers as grey dashes."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pinpress.common.quantities import Array
from pinpress.plots.style import COLOURS, GREY, LINES, STYLE, drawing, grid

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(
    across: str,
    up: str,
    curves: Mapping[str, tuple[Array, Array]],
    levels: Sequence[float] = (),
    logarithmic: bool = False,
    high: float = 7.5,
) -> "Figure":
    """Curves by their names, (x, y) both (n,), over axes with these labels; ``levels``: values of the upright axis that are printed;
    ``high``: of the picture [cm]."""
    with drawing(high) as figure:
        axes = figure.subplots()
        grid(axes, up)
        for k, (name, (x, y)) in enumerate(curves.items()):
            axes.plot(x, y, color=COLOURS[k % len(COLOURS)], linestyle=LINES[k % len(LINES)], label=name)
        for level in levels:
            axes.axhline(level, color=GREY, linestyle=(0, (2, 2)), linewidth=0.9)
        axes.set_yscale("log" if logarithmic else "linear")
        axes.legend(frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(curves))
        axes.set_xlabel(across)
    return figure


def save(figure: "Figure", path: Path) -> None:
    """A PNG file for a screen, while `plots.save` writes for print. The same figure gives the same bytes."""
    from matplotlib import style  # optional, and slow to import

    with style.context(["default", STYLE]):
        figure.savefig(path, dpi=110, metadata={"Software": None})
