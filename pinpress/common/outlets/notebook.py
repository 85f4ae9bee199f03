"""Results in notebooks: the numbers that are looked for first, a small picture of the first chart, and the columns."""

from __future__ import annotations

import html
from collections.abc import Sequence

from .. import tables
from ..quantities import quantity
from ..tables import Columns
from .described import Chart, Section, charts_of
from .sparkline import MOST_CURVES, sparkline
from .text import remark, value

DIGITS = 3
MOST_FIGURES = 8


def notebook(title: str, sections: Sequence[Section], columns: Columns) -> str:
    """HTML of a result: its first figures, a picture of its first chart, and its columns."""
    figures = [figure for section in sections for figure in section.figures][:MOST_FIGURES]
    lines = [f"{figure.name}: {' '.join(value(figure, DIGITS))} {remark(figure, DIGITS)}".strip() for figure in figures]
    listed = f"<ul>{''.join(f'<li>{html.escape(line)}</li>' for line in lines)}</ul>" if lines else ""
    drawn = next((picture(chart) for chart in charts_of(sections).values() if isinstance(chart, Chart)), "")
    return f"<div>{drawn}{listed}{tables.html(title, columns)}</div>"


def picture(chart: Chart) -> str:
    """A small picture of a chart of up to four curves along one quantity; empty if it has others."""
    x = chart.along.values
    curves = [curve for curve in chart.curves if curve.x is None]
    if x is None and chart.curves and chart.curves[0].x is not None:
        x, curves = chart.curves[0].x, [curve for curve in chart.curves if curve.x is chart.curves[0].x]
    if x is None or not curves:
        return ""
    across = quantity(chart.along.quantity).scale(x.tolist())
    up = quantity(chart.quantity).scale([float(part) for curve in curves for part in curve.y], chart.reference)
    drawn = {f"{curve.name} [{up.unit}]": up.factor * curve.y for curve in curves[:MOST_CURVES]}
    name = f"{chart.along.name} [{across.unit}]"
    return sparkline({name: across.factor * x, **drawn}, [name, *drawn])
