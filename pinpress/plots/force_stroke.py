"""The force-stroke-energy diagram of a press."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.arguments import typed
from ..common.quantities import Array
from ..ratings.permissible_force import NOMINAL
from ..ratings.rating import PressRatings
from .style import COLOURS, GREY, LINES, SMALL, drawing, grid, legend, plain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGH = 13.0  # [cm]
ROOM = 1.12  # above the nominal force
HYPERBOLAS = (0.2, 0.4, 0.6, 0.8)  # of constant energy: where they meet the diagonal of the panel
NEAR = 2.0  # times the largest height of a change that the left panel shows
GOVERNING = 3.2  # width of the governing curve [pt]


@typed
def ratings(ratings: PressRatings) -> Figure:
    """Draw the permissible force over the slide's height, left near bottom dead centre, right over the stroke.

    Each limit is a thin line; the permissible force of all is thick, in the colour of the limit that governs. Thin hyperbolas are of
    constant energy. The lower panels show the work that the force takes from a height down, and the energies that limit it.

    Args:
        ratings: the ratings of a press.

    Raises:
        PinpressError: Matplotlib is not installed, or no ratings.
    """
    with drawing(HIGH) as figure:
        panels = figure.subplots(2, 2, height_ratios=(1.7, 1.0), width_ratios=(1.0, 1.0))
        near = _near(ratings)
        lines: list[Artist] = []
        for column, reach in enumerate((near, ratings.stroke)):
            lines = _forces(panels[0, column], ratings, reach)
            _works(panels[1, column], ratings, reach)
        for axes in panels[:, 1]:
            axes.set_ylabel("")
        for axes in panels[0]:
            axes.set_xlabel("")
        legend(figure, lines, list(ratings.limits), loc="outside upper center", ncols=4)
        figure.align_ylabels()
    return figure


def _near(ratings: PressRatings) -> float:
    """Up to which height the left panel goes [m]."""
    nominal = ratings.capacities.nominal_height
    marks = [height for height in (*ratings.changes, *([] if nominal is None else [nominal])) if height < ratings.stroke / 2]
    return min(NEAR * max(marks, default=0.1 * ratings.stroke), ratings.stroke)


def _forces(axes: Axes, ratings: PressRatings, reach: float) -> list[Artist]:
    height, top = 1e3 * ratings.height, ROOM * ratings.capacities.nominal_force / 1e3
    grid(axes, "process force [kN]")
    for share in HYPERBOLAS:
        _hyperbola(axes, float(f"{share**2 * top * reach:.2g}"), 1e3 * reach, top)
    lines: list[Artist] = []
    for i, (name, force) in enumerate(ratings.limits.items()):
        look = _look(i)
        below = force < ratings.capacities.nominal_force
        shown = below | np.append(below[1:], False) | np.insert(below[:-1], 0, False) | (name == NOMINAL)
        lines += axes.plot(height, np.where(shown, force / 1e3, np.nan), linewidth=1.0, **look)
        governs = np.array([limit == name for limit in ratings.limited_by])
        # a piece ends at the height at which the next limit begins to govern
        pieces = (
            governs | np.append(governs[1:], False) & _meets(ratings, force) | np.insert(governs[:-1], 0, False) & _meets(ratings, force)
        )
        axes.plot(height, np.where(pieces, force / 1e3, np.nan), linewidth=GOVERNING, **look)
    _limits(axes, reach, top)
    return lines


def _meets(ratings: PressRatings, force: Array) -> Array:
    """Where a limit equals the permissible force."""
    return np.asarray(force <= ratings.force * (1 + 1e-9))


def _works(axes: Axes, ratings: PressRatings, reach: float) -> None:
    grid(axes, "work [kJ]")
    inside = ratings.height <= reach
    axes.plot(1e3 * ratings.height, ratings.work / 1e3, color=GREY)
    highest = max([float(ratings.work[inside].max()), *ratings.energies.values()]) / 1e3
    for name, energy in ratings.energies.items():
        axes.axhline(energy / 1e3, linewidth=1.0, **_look(list(ratings.limits).index(name)))
    _limits(axes, reach, ROOM * highest)
    plain(axes.set_xlabel("height above bottom dead centre [mm]"))


def _hyperbola(axes: Axes, energy: float, reach: float, top: float) -> None:
    """Forces [kN] of constant energy [kJ] over the height [mm], with its name on the diagonal of the panel."""
    height = np.geomspace(1e3 * energy / top, reach, 200)
    axes.plot(height, 1e3 * energy / height, color=GREY, linewidth=0.5, linestyle=(0, (1, 2)))
    middle = np.sqrt(1e3 * energy * reach / top)
    name = axes.text(
        middle, 1e3 * energy / middle, f"{energy:g} kJ", fontsize=SMALL - 1.5, color=GREY, ha="center", va="center", zorder=1.5
    )
    plain(name).set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.5})


def _look(i: int) -> dict[str, Any]:
    return {"color": COLOURS[i % len(COLOURS)], "linestyle": LINES[i // len(COLOURS) % len(LINES)]}


def _limits(axes: Axes, reach: float, top: float) -> None:
    axes.set_xlim(0.0, 1e3 * reach)
    axes.set_ylim(0.0, top)
