"""Polar diagrams: the paths of the tips of bearing forces, with circles of constant force and marked crank angles."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.outlets.described import Polar
from ..common.quantities import Array, ShownUnit, quantity
from ..dynamics.harmonics import last_period
from ..kinematics.motion import Motion
from .style import CENTIMETRE, COLOURS, GREY, LIGHT, LINE, SMALL, THIN, Panels, brief, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Text

FRAME, OWN = COLOURS[0], COLOURS[1]
DASHED = (0, (4, 1.5))


def draw_loci(drawn: Panels, axes: Sequence[Axes], loci: Sequence[Polar], before: Mapping[str, Polar]) -> None:
    """Draw a diagram for each locus in the last full period, with equal scales on both axes.

    A diagram shows the path of the force vector's tip in world axes (solid) and in axes that turn with the link on which the force acts
    (dashed), with dots at every quarter turn of the crank in the last period; of a force on a link that does not turn one path alone.
    Circles are lines of constant force. Paths in world axes ``before``, by the names of the loci, are grey.
    """
    marked: list[tuple[int, int]] = []
    for place, locus in zip(axes, loci, strict=True):
        width = float(place.get_position().width) * float(drawn.figure.get_figwidth()) / CENTIMETRE
        if not drawn.own:
            width = float(place.get_window_extent().width) / float(place.figure.dpi) / CENTIMETRE
        motion = locus.of
        assert isinstance(motion, Motion)
        marked = _quarters(motion)
        first = max(0, (last_period(motion) or 0) - 1)  # earlier periods would only hide the last
        old = before.get(locus.name)
        _draw(place, locus, old if old is not None and old.axes == locus.axes else None, first, marked, min(width, 8.0))
    place = axes[0]
    lines = [*place.plot([], [], color=FRAME), *place.plot([], [], color=OWN, linestyle=DASHED)]
    names = ["axes of the frame", "axes fixed to the link"]
    if marked:
        lines += place.plot([], [], "o", color=FRAME, markersize=4.0)
        names.append("crank angle [deg]")
    if before:
        lines += place.plot([], [], color=GREY)
        names.append("before")
    drawn.legend(lines, names, loc="outside lower center", ncols=len(names))


def _closed(path: Array, locus: Polar) -> Array:
    """A path, of a period closed by its first state."""
    return np.concatenate([path, path[:1]]) if locus.closed else path


def _draw(axes: Axes, locus: Polar, old: Polar | None, first: int, marked: Sequence[tuple[int, int]], side: float) -> None:
    """Draw both paths from a state on, with marks; ``side`` is that of the diagram [cm]."""
    known = locus.world if old is None else np.concatenate([locus.world, old.world])
    scale = quantity(locus.quantity).scale([float(np.hypot(*known.T).max())])
    world, own = scale.factor * locus.world, scale.factor * locus.own
    largest = scale.factor * float(np.hypot(*known.T).max())
    labels = _paper(axes, locus, (world, own), largest, scale)
    if old is not None:
        axes.plot(*scale.factor * _closed(old.world, old).T, color=GREY, linewidth=0.8 * LINE)
    if not largest:
        axes.plot(0.0, 0.0, "o", color=FRAME, markersize=4.0)
        return
    turns = np.abs(own - world).max() > 1e-6 * largest
    if turns:
        axes.plot(*_closed(own, locus)[first:].T, color=OWN, linestyle=DASHED, linewidth=0.8 * LINE)
    axes.plot(*_closed(world, locus)[first:].T, color=FRAME, linewidth=0.8 * LINE)
    if len(world) == 1:
        axes.plot(*world[0], "o", color=FRAME, markersize=4.0)
    for _, state in marked:
        if turns:
            axes.plot(*own[state], "o", color="white", markersize=3.0, markeredgecolor=OWN, markeredgewidth=0.8)
        axes.plot(*world[state], "o", color=FRAME, markersize=4.0, markeredgecolor="white", markeredgewidth=THIN)
    letter = float(np.ptp(axes.get_xlim())) * 0.16 / side  # a letter of 6.5 pt is 0.16 cm wide
    taken = np.concatenate([world[first:], own[first:], labels])
    for words, state in _together(world, marked, 0.12 * largest):
        size = letter * np.array([0.5 * len(words), 0.8])
        place = _free(world[state], size, 1.2 * letter, taken)
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


def _paper(axes: Axes, locus: Polar, paths: tuple[Array, Array], largest: float, scale: ShownUnit) -> Array:
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
    places = _clearest(paths, radii)
    for place, radius in zip(places, radii, strict=True):
        words = f"{radius:g}" + (f" {scale.unit}" if radius == end else "")
        _haloed(axes.annotate(words, tuple(place), color=GREY, ha="center", va="center"))
    look: dict[str, Any] = {"color": GREY, "fontsize": SMALL, "style": "italic", "va": "center"}
    plain(axes.text(1.17 * end, 0.0, locus.axes[0], ha="left", **look))
    plain(axes.text(0.0, 1.25 * end, locus.axes[1], ha="center", **look))
    plain(axes.set_title(f"{brief(locus.title)}\n", pad=4.0, fontweight="bold"))
    look = {"ha": "center", "fontsize": SMALL, "color": GREY}
    plain(axes.annotate(f"on {brief(locus.link)}", (0.5, 1.0), (0, 6.0), "axes fraction", "offset points", **look))
    return places


def _clearest(both: tuple[Array, Array], radii: Array) -> Array:
    """Places (k, 2) on circles of these radii, along the diagonal that is farthest from both paths."""
    paths = np.concatenate(both)
    diagonals = [np.multiply.outer(radii, math.sqrt(0.5) * np.array(signs)) for signs in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
    return max(diagonals, key=lambda places: float(np.hypot(*(places[:, None] - paths).T).min()))


def _haloed(text: Text) -> Text:
    """Make a text small, with a white edge that keeps it legible on lines."""
    from matplotlib.patheffects import withStroke  # optional, and slow to import

    text.set_fontsize(6.5)
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
    for degrees in range(0, 360 * turns, 90):
        away = np.abs((angle[last] - np.radians(degrees) + 0.5 * period) % period - 0.5 * period)
        if away.min() <= 0.5 * step + 1e-9:
            marked.append((degrees, int(last[away.argmin()])))
    return marked
