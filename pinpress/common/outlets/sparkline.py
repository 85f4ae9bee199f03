"""Small pictures of curves for notebooks, as plain SVG: they need no drawing library and take a millisecond.

A picture has curves of one quantity over another, their names in the colours of the curves, and the ends of both axes as numbers. Text and
axes take the colour of the notebook's text, so that they are seen on light and dark ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

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
    right, bottom = LEFT + WIDTH, TOP + HEIGHT
    axis = 'fill="none" stroke="currentColor" stroke-opacity="0.4"'
    parts = [f'<path d="M{LEFT} {TOP} V{bottom} H{right}" {axis}/>']
    if low < 0 < high:
        zero = TOP + HEIGHT * (1 - float(_share(np.zeros(1), low, high)[0]))
        parts.append(f'<path d="M{LEFT} {zero:.1f} H{right}" {axis} stroke-dasharray="3 3"/>')
    parts += [_curve(across, TOP + HEIGHT * (1 - _share(curve, low, high)), colour) for curve, colour in zip(curves, COLOURS, strict=False)]
    place = float(LEFT)
    for name, colour in zip(names[1:], COLOURS, strict=False):  # the names side by side above the curves, as far as there is room
        words = _brief(name)
        if place > LEFT and place + LETTER * len(words) > right:
            break
        parts.append(_text(place, TOP - 7, words, "start", f' style="fill:{colour}"'))
        place += LETTER * len(words) + 12
    first, last = _ends(x[valued])
    parts += [_text(LEFT - 4, TOP + 4, f"{high:.3g}", "end"), _text(LEFT - 4, bottom + 4, f"{low:.3g}", "end")]
    parts += [_text(LEFT, bottom + 14, f"{first:.3g}", "start"), _text(right, bottom + 14, f"{last:.3g}", "end")]
    parts.append(_text(LEFT + WIDTH / 2, bottom + 14, _brief(names[0]), "middle"))
    width, height, label = right + RIGHT, bottom + BOTTOM, escape(f"{', '.join(names[1:])} over {names[0]}")
    size = f'width="{width}" height="{height}" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="11"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} fill="currentColor" role="img" aria-label="{label}">{"".join(parts)}</svg>'


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


def _curve(across: Array, down: Array, colour: str) -> str:
    """A line through all states with numbers; of many states in each pixel only the highest and lowest."""
    kept = np.concatenate([_extremes(part, down) for part in np.array_split(np.arange(len(down)), min(len(down), WIDTH))])
    path, drawing = "", False
    for x, y in zip(across[kept], down[kept], strict=True):
        visible = bool(np.isfinite(x) and np.isfinite(y))
        path += f"{'L' if drawing else 'M'}{x:.1f} {y:.1f}" if visible else ""
        drawing = visible
    return f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="1.6" stroke-linejoin="round"/>'


def _extremes(part: NDArray[np.intp], values: Array) -> NDArray[np.intp]:
    """Of neighbouring states the first, the lowest, the highest and the last."""
    if len(part) < 5 or not np.isfinite(values[part]).all():
        return part
    return np.unique([part[0], part[values[part].argmin()], part[values[part].argmax()], part[-1]])


def _brief(words: str) -> str:
    words = " ".join(words.split())
    return words if len(words) <= LONGEST else f"{words[: LONGEST - 1]}…"


def _text(x: float, y: float, words: str, anchor: str, style: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{style}>{escape(words)}</text>'
