"""Polar diagrams of bearing forces, as small multiples."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.quantities import Array
from ..dynamics.harmonics import last_period
from ..kinematics.motion import Motion
from ..visual.charts import Locus
from .style import COLOURS, GREY, LIGHT, LINE, SMALL, THIN, WIDTH, Over, brief, drawing, legend, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.text import Text

FRAME, OWN = COLOURS[0], COLOURS[1]
DASHED = (0, (4, 1.5))
QUARTER = 90  # between marked crank angles [deg]
CLOSE = 0.12  # of the largest force: marks that are closer together share a label
SAME = 1e-6  # of the largest force: paths that differ by less are drawn as one
TINY = 6.5  # size of the letters in a diagram [pt]
LETTER = 0.16  # width of one of these [cm]
LARGEST = 8.0  # longest side of a diagram [cm]


def draw_loci(motion: Motion, loci: Sequence[Locus]) -> "Figure":
    """A diagram for each locus in the last full period, with equal scales on both axes.

    A diagram of a force on a link that does not turn has one path.
    """
    columns = {1: 1, 2: 2, 4: 2}.get(len(loci), 3 if len(loci) < 10 else 4)
    rows = math.ceil(len(loci) / columns)
    side = min(WIDTH / columns, LARGEST)
    with drawing(1.0 + rows * (side + 0.8)) as figure:
        over, marked = Over(motion), _quarters(motion)
        first = max(0, (last_period(motion) or 0) - 1)  # earlier periods would only hide the last
        places = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, locus in zip(places, loci, strict=False):
            _draw(axes, locus, over, first, marked, side)
        for axes in places[len(loci) :]:
            axes.set_axis_off()
        lines = [*places[0].plot([], [], color=FRAME), *places[0].plot([], [], color=OWN, linestyle=DASHED)]
        names = ["axes of the frame", "axes fixed to the link"]
        if marked:
            lines += places[0].plot([], [], "o", color=FRAME, markersize=4.0)
            names.append("crank angle [deg]")
        legend(figure, lines, names, loc="outside lower center", ncols=len(names))
    return figure


def _draw(axes: "Axes", locus: Locus, over: Over, first: int, marked: Sequence[tuple[int, int]], side: float) -> None:
    """Draw both paths from a state on, with marks; ``side`` is that of the diagram [cm]."""
    largest = float(np.hypot(*locus.frame.T).max())
    labels = _paper(axes, locus, largest)
    if not largest:
        axes.plot(0.0, 0.0, "o", color=FRAME, markersize=4.0)
        return
    turns = np.abs(locus.own - locus.frame).max() > SAME * largest
    if turns:
        axes.plot(*over.along(locus.own)[first:].T, color=OWN, linestyle=DASHED, linewidth=0.8 * LINE)
    axes.plot(*over.along(locus.frame)[first:].T, color=FRAME, linewidth=0.8 * LINE)
    if len(locus.frame) == 1:
        axes.plot(*locus.frame[0], "o", color=FRAME, markersize=4.0)
    for _, state in marked:
        if turns:
            axes.plot(*locus.own[state], "o", color="white", markersize=3.0, markeredgecolor=OWN, markeredgewidth=0.8)
        axes.plot(*locus.frame[state], "o", color=FRAME, markersize=4.0, markeredgecolor="white", markeredgewidth=THIN)
    letter = float(np.ptp(axes.get_xlim())) * LETTER / side
    taken = np.concatenate([locus.frame[first:], locus.own[first:], labels])
    for words, state in _together(locus.frame, marked, CLOSE * largest):
        size = letter * np.array([0.5 * len(words), 0.8])
        place = _free(locus.frame[state], size, 1.2 * letter, taken)
        _haloed(axes.annotate(words, tuple(place), color=FRAME, ha="center", va="center"))
        taken = np.concatenate([taken, place + np.multiply.outer([-1.0, -0.5, 0.0, 0.5, 1.0], [size[0], 0.0])])


def _together(path: Array, marked: Sequence[tuple[int, int]], close: float) -> list[tuple[str, int]]:
    """Labels of marked crank angles with their states; marks that are close together share a label at the first of them."""
    groups: list[tuple[list[str], int]] = []
    for degrees, state in marked:
        near = next((words for words, other in groups if np.hypot(*(path[state] - path[other])) < close), None)
        if near is None:
            groups.append(([str(degrees)], state))
        else:
            near.append(str(degrees))
    return [(", ".join(words), state) for words, state in groups]


def _free(mark: Array, size: Array, gap: float, taken: Array) -> Array:
    """Middle (2,) of a label next to its mark, clear of places (k, 2) that are taken; ``size``: its half width and height."""
    angles = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    middles = mark + directions * (gap + size)

    def clear(middle: Array) -> float:
        return min(gap, float(np.hypot(*np.maximum(np.abs(taken - middle) - size, 0.0).T).min()))

    return max(middles, key=clear)


def _paper(axes: "Axes", locus: Locus, largest: float) -> Array:
    """Draw axes through zero, names, and circles of constant force with their values; return the places (k, 2) of the values."""
    step = _step(largest)
    radii: Array = np.arange(1, max(1, math.ceil(largest / step - 1e-9)) + 1, dtype=float) * step
    turn = np.linspace(0.0, 2 * np.pi, 181)
    for radius in radii:
        axes.plot(radius * np.cos(turn), radius * np.sin(turn), color=LIGHT, linewidth=THIN, zorder=0.5)
    end = float(radii[-1])
    for across in ([-1.15, 1.15], [0.0, 0.0]), ([0.0, 0.0], [-1.15, 1.15]):
        axes.plot(*np.multiply(end, across), color=LIGHT, linewidth=THIN, zorder=0.5)
    axes.set_aspect("equal")
    axes.set_xlim(-1.15 * end, 1.15 * end)
    axes.set_ylim(-1.15 * end, 1.3 * end)
    axes.set_axis_off()
    places = _clearest(locus, radii)
    for place, radius in zip(places, radii, strict=True):
        words = f"{radius:g}" + (f" {locus.unit}" if radius == end else "")
        _haloed(axes.annotate(words, tuple(place), color=GREY, ha="center", va="center"))
    look: dict[str, Any] = {"color": GREY, "fontsize": SMALL, "style": "italic", "va": "center"}
    plain(axes.text(1.17 * end, 0.0, locus.axes[0], ha="left", **look))
    plain(axes.text(0.0, 1.25 * end, locus.axes[1], ha="center", **look))
    plain(axes.set_title(f"{brief(locus.bearing)}\n", pad=4.0, fontweight="bold"))
    look = {"ha": "center", "fontsize": SMALL, "color": GREY}
    plain(axes.annotate(f"on {brief(locus.link)}", (0.5, 1.0), (0, 6.0), "axes fraction", "offset points", **look))
    return places


def _clearest(locus: Locus, radii: Array) -> Array:
    """Places (k, 2) on circles of these radii, along the diagonal that is farthest from both paths."""
    paths = np.concatenate([locus.frame, locus.own])
    diagonals = [np.multiply.outer(radii, math.sqrt(0.5) * np.array(signs)) for signs in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
    return max(diagonals, key=lambda places: float(np.hypot(*(places[:, None] - paths).T).min()))


def _haloed(text: "Text") -> "Text":
    """Make a text small, with a white edge that keeps it legible on lines."""
    from matplotlib.patheffects import withStroke  # optional, and slow to import

    text.set_fontsize(TINY)
    text.set_path_effects([withStroke(linewidth=1.2, foreground="white")])
    return text


def _step(largest: float) -> float:
    """A round step of which at most three make up a size."""
    if not largest:
        return 1.0
    power = 10.0 ** math.floor(math.log10(largest / 3))
    return next(factor * power for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if largest / (factor * power) <= 3 * (1 + 1e-9))


def _quarters(motion: Motion) -> list[tuple[int, int]]:
    """Quarter turns [deg] in the last period, each with its nearest state; empty for several drivers."""
    angle: Array = motion.crank_angle
    if angle.ndim > 1 or len(angle) < 3:
        return []
    turns = motion.period_turns or 1
    period = 2 * np.pi * turns
    last = np.flatnonzero(np.abs(angle - angle[-1]) < period * (1 - 1e-9))
    step = float(np.abs(np.diff(angle)).max())
    marked = []
    for degrees in range(0, 360 * turns, QUARTER):
        away = np.abs((angle[last] - np.radians(degrees) + 0.5 * period) % period - 0.5 * period)
        if away.min() <= 0.5 * step + 1e-9:
            marked.append((degrees, int(last[away.argmin()])))
    return marked
