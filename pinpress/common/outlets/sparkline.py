"""Small pictures of curves for notebooks, as plain SVG: they need no drawing library and take a millisecond.

A picture has curves of one quantity over another, their names in the colours of the curves, and the ends of both axes as numbers. Text and
axes take the colour of the notebook's text, so that they are seen on light and dark ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
from numpy.typing import NDArray

from ..quantities import Array
from ..tables import Columns

WIDTH, HEIGHT = 300, 80  # of the curves [pixels]
LEFT, TOP, RIGHT, BOTTOM = 76, 20, 16, 32  # margins
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")  # Okabe and Ito
MOST_CURVES = len(COLOURS)
LONGEST = 46  # most letters of a line; more are cut off
LETTER = 6.2  # mean width of a letter [pixels]
FONT = {"font-family": "sans-serif", "font-size": "11"}


def sparkline(columns: Columns, names: Sequence[str]) -> str:
    """SVG of curves; empty if fewer than two states have numbers, or all stand above each other.

    Args:
        columns: names with units -> columns of one length.
        names: the abscissa's column, then those of one to four curves in one unit.
    """
    x, *curves = (_numbers(columns[name]) for name in names)
    valued = np.isfinite(x) & np.any([np.isfinite(curve) for curve in curves], axis=0)
    if valued.sum() < 2 or np.ptp(x[valued]) == 0:
        return ""
    low, high = _ends(np.concatenate(curves))
    across = LEFT + WIDTH * _share(x, *_ends(x[valued]))
    root = _sheet(f"{', '.join(names[1:])} over {names[0]}")
    _axes(root, low, high)
    for curve, colour in zip(curves, COLOURS, strict=False):
        _curve(root, across, TOP + HEIGHT * (1 - _share(curve, low, high)), colour)
    _names(root, names[1:])
    _write(root, LEFT, TOP, f"{high:.3g}", "end", below=4)
    _write(root, LEFT, TOP + HEIGHT, f"{low:.3g}", "end", below=4)
    first, last = _ends(x[valued])
    bottom = TOP + HEIGHT + 14
    _write(root, LEFT, bottom, f"{first:.3g}", "start")
    _write(root, LEFT + WIDTH, bottom, f"{last:.3g}", "end")
    _write(root, LEFT + WIDTH / 2, bottom, names[0], "middle")
    return tostring(root, encoding="unicode")


def _numbers(column: object) -> Array:
    """A column as numbers (n,), NaN where there is no value."""
    return np.asarray(np.ma.filled(np.ma.array(column, dtype=float), np.nan))  # None becomes NaN


def _ends(values: Array) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    return float(finite.min()), float(finite.max())


def _share(values: Array, low: float, high: float) -> Array:
    """Values from 0 at the low end to 1 at the high one; a half where both are one."""
    span = high / 2 - low / 2  # halved: the difference of two floats may overflow
    return np.asarray(np.where(np.isfinite(values), (values / 2 - low / 2) / span if span else 0.5, np.nan))


def _sheet(words: str) -> Element:
    width, height = LEFT + WIDTH + RIGHT, TOP + HEIGHT + BOTTOM
    size = {"width": str(width), "height": str(height), "viewBox": f"0 0 {width} {height}"}
    return Element(
        "svg", {"xmlns": "http://www.w3.org/2000/svg", **size, **FONT, "fill": "currentColor", "role": "img", "aria-label": words}
    )


def _axes(root: Element, low: float, high: float) -> None:
    """A frame's left and lower sides, and a line at zero."""
    look = {"fill": "none", "stroke": "currentColor", "stroke-opacity": "0.4"}
    SubElement(root, "path", {"d": f"M{LEFT} {TOP} V{TOP + HEIGHT} H{LEFT + WIDTH}", **look})
    if low < 0 < high:
        zero = TOP + HEIGHT * (1 - float(_share(np.zeros(1), low, high)[0]))
        SubElement(root, "path", {"d": f"M{LEFT} {zero:.1f} H{LEFT + WIDTH}", **look, "stroke-dasharray": "3 3"})


def _curve(root: Element, across: Array, down: Array, colour: str) -> None:
    """A line through all states with numbers; of many states in each pixel only the highest and lowest."""
    kept = np.concatenate([_extremes(part, down) for part in np.array_split(np.arange(len(down)), min(len(down), WIDTH))])
    path, drawing = "", False
    for x, y in zip(across[kept], down[kept], strict=True):
        there = bool(np.isfinite(x) and np.isfinite(y))
        path += f"{'L' if drawing else 'M'}{x:.1f} {y:.1f}" if there else ""
        drawing = there
    SubElement(root, "path", {"d": path, "fill": "none", "stroke": colour, "stroke-width": "1.6", "stroke-linejoin": "round"})


def _extremes(part: NDArray[np.intp], values: Array) -> NDArray[np.intp]:
    """Of neighbouring states the first, the lowest, the highest and the last."""
    if len(part) < 5 or not np.isfinite(values[part]).all():
        return part
    return np.unique([part[0], part[values[part].argmin()], part[values[part].argmax()], part[-1]])


def _names(root: Element, names: Sequence[str]) -> None:
    """The curves' names side by side above them, as far as there is room."""
    left, room = float(LEFT), float(LEFT + WIDTH)
    for name, colour in zip(names, COLOURS, strict=False):
        words = _brief(name)
        if left > LEFT and left + LETTER * len(words) > room:
            break
        _write(root, left, TOP - 7, words, "start").set("style", f"fill:{colour}")
        left += LETTER * len(words) + 12


def _brief(words: str) -> str:
    return words if len(words) <= LONGEST else f"{words[: LONGEST - 1]}…"


def _write(root: Element, x: float, y: float, words: str, anchor: str, below: float = 0.0) -> Element:
    at = {"x": f"{x - (4 if below else 0):.1f}", "y": f"{y + below:.1f}", "text-anchor": anchor}
    text = SubElement(root, "text", at)
    text.text = _brief(" ".join(words.split()))
    return text
