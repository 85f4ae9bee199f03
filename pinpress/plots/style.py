"""Common parts of all plots: size, style, axes, legends and files. They use Matplotlib without pyplot."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..common import files
from ..common.errors import PinpressError, shown

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Text

NOT_INSTALLED = "plots need Matplotlib, which is not installed: pip install 'pinpress[plots]'"
CENTIMETRE = 1 / 2.54  # [inch]
WIDTH = 16.0  # width of a text column, and so of every plot [cm]
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")  # Okabe and Ito; its yellow is too light for lines
LINES = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (5, 1.5, 1.2, 1.5)))
GREY, LIGHT = "#7a7a7a", "#dddddd"
SMALL, NORMAL = 8.0, 9.0  # sizes of letters [pt]
LONGEST = 40  # most letters of a name; more are cut off
LINE, THIN = 1.3, 0.6  # widths of lines [pt]
STYLE = {
    "font.size": NORMAL,
    "axes.titlesize": NORMAL,
    "axes.labelsize": NORMAL,
    "legend.fontsize": SMALL,
    "axes.linewidth": THIN,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": LINE,
    "lines.solid_joinstyle": "round",
}
FORMATS: dict[str, dict[str, str | None]] = {".svg": {"Date": None}, ".png": {"Software": None}, ".pdf": {"CreationDate": None}}
DOTS = 300  # resolution of a PNG file [1/inch]


@contextmanager
def drawing(height: float) -> Iterator[Figure]:
    """A figure to draw on, `WIDTH` wide and ``height`` high [cm], in our style. It is laid out when the block ends.

    Raises:
        PinpressError: Matplotlib is not installed.
    """
    try:
        import matplotlib.figure  # optional, and slow to import
        import matplotlib.style  # optional, and slow to import
    except ImportError:
        raise PinpressError(NOT_INSTALLED) from None
    from .figure import NotebookFigure  # it imports Matplotlib

    with matplotlib.style.context(["default", STYLE]):
        figure = NotebookFigure(figsize=(WIDTH * CENTIMETRE, height * CENTIMETRE), dpi=DOTS, layout="constrained")
        yield figure
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # it would move all parts a little whenever the figure is drawn


class Panels(NamedTuple):
    """Axes to draw on.

    Attributes:
        figure: the figure that they are on.
        axes: one for each chart, row by row.
        own: whether the figure is ours, to be laid out; False for axes that the caller gave.
    """

    figure: Figure
    axes: list[Axes]
    own: bool

    def legend(self, handles: Sequence[Artist], names: Sequence[str], **where: Any) -> None:
        """Draw one legend of all axes next to them; on the caller's axes, whose figure may have more, on the first axes."""
        legend(self.figure if self.own else self.axes[0], handles, names, **(where if self.own else {"loc": "best"}))

    def align_labels(self) -> None:
        """Align the labels of the vertical axes in our figure. Axes without a label have words at their ticks, which would push other
        labels away."""
        if self.own:
            self.figure.align_ylabels([axes for axes in self.axes if axes.get_ylabel()])


@contextmanager
def panels(ax: Axes | Iterable[Axes] | None, count: int, height: float, laid_out: Callable[[Figure], Iterable[Axes]]) -> Iterator[Panels]:
    """Axes to draw on: those given, or those of a new figure.

    Args:
        ax: axes of the caller; None for a new figure.
        count: number of charts.
        height: height of the new figure [cm].
        laid_out: function that makes the axes of the new figure.

    Raises:
        PinpressError: Matplotlib is not installed, or ``ax`` are not as many axes as charts.
    """
    if ax is None:
        with drawing(height) as figure:
            yield Panels(figure, list(laid_out(figure)), own=True)
        return
    axes = _given(ax, count)
    from matplotlib import style  # optional, and slow to import

    with style.context(["default", STYLE]):
        yield Panels(axes[0].figure, axes, own=False)  # type: ignore[arg-type]  # a part of a figure does as well


def _given(ax: object, count: int) -> list[Axes]:
    """The caller's axes, row by row."""
    try:
        from matplotlib.axes import Axes  # optional, and slow to import
    except ImportError:
        raise PinpressError(NOT_INSTALLED) from None
    axes = np.ravel(np.array(ax, dtype=object)).tolist()
    if not all(isinstance(each, Axes) for each in axes):
        raise PinpressError(f"ax is {shown(ax)}: give axes of Matplotlib, matplotlib.pyplot.subplots({count})[1]")
    if len(axes) != count:
        raise PinpressError(f"ax has {len(axes)} axes, but there are {count} charts to draw: give matplotlib.pyplot.subplots({count})[1]")
    return axes


def save(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a plot to an SVG, PNG or PDF file, and return the path. Equal plots give equal bytes.

    Args:
        figure: the plot.
        path: path of the file; its suffix decides the format.

    Raises:
        PinpressError: the suffix is another one, the file cannot be written, or ``figure`` is no plot.
    """
    suffix = Path(path).suffix.lower() if isinstance(path, str | os.PathLike) else ""
    if suffix not in FORMATS:
        raise PinpressError(f"a plot cannot be written as {path}: end its name in {', '.join(FORMATS)}")
    if not callable(getattr(figure, "savefig", None)):
        raise PinpressError(f"{shown(figure)} is no figure: give what a function of pinpress.plots returns, e.g. torque")
    from matplotlib import style  # optional, and slow to import

    content = io.BytesIO()
    with style.context(["default", STYLE, {"svg.hashsalt": "pinpress", "svg.fonttype": "path"}]):
        figure.savefig(content, format=suffix[1:], metadata=FORMATS[suffix])
    return files.write(path, content.getvalue())


def grid(axes: Axes, label: str) -> None:
    """Set the look of a chart's axes, and the label of the vertical one."""
    # set for these axes, because ticks are made when the figure is drawn, after the style has ended
    axes.grid(True, color=LIGHT, linewidth=THIN)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=SMALL, width=THIN, length=3.0)
    axes.margins(x=0.0)
    plain(axes.set_ylabel(label))


def legend(owner: Axes | Figure, handles: Sequence[Artist], names: Sequence[str], **where: Any) -> None:
    """Draw a legend of any names. Matplotlib alone would leave out names with a leading "_", and typeset text between two "$"."""
    texts = owner.legend(list(handles), ["-"] * len(names), frameon=False, handlelength=1.8, **where).get_texts()
    for text, name in zip(texts, names, strict=True):
        plain(text).set_text("\n".join(brief(line) for line in name.split("\n")))


def above(axes: Axes, handles: Sequence[Artist], names: Sequence[str]) -> None:
    """Draw a legend in one line above the axes, clear of the curves."""
    where = {"loc": "lower left", "bbox_to_anchor": (-0.01, 0.98), "borderaxespad": 0.2, "columnspacing": 1.4}
    legend(axes, handles, [name.replace("\n", " ") for name in names], ncols=len(names), **where)


def brief(name: str, most: int = LONGEST) -> str:
    """A name, cut off where it is too long."""
    return name if len(name) <= most else name[: most - 1] + "…"


def plain(text: Text) -> Text:
    """The text, without typesetting of mathematics."""
    text.set_parse_math(False)
    return text
