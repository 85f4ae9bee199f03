"""The force-stroke-energy diagram of a press."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.arguments import typed
from ..common.quantities import Array
from ..dynamics.reactions import Reactions
from ..kinematics.slide_path import dead_centres
from ..ratings.permissible_force import NOMINAL
from ..ratings.rating import PressRatings
from .style import COLOURS, GREY, LINES, SMALL, grid, panels, plain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGH = 13.0  # height of the figure [cm]
ROOM = 1.12  # highest force of a panel, divided by the nominal force
HYPERBOLAS = (0.2, 0.4, 0.6, 0.8)  # places on the diagonal of the panel where lines of constant energy cross it
NEAR = 2.0  # reach of the left panel, divided by the largest height at which another limit begins to govern
GOVERNING = 3.2  # width of the governing curve [pt]
HALF_NAME = (0.07, 0.035)  # half width and height of the name of an energy, of the panel


@typed
def ratings(ratings: PressRatings, reactions: Reactions | None = None, *, ax: Iterable[Axes] | None = None) -> Figure:
    """Draw the permissible force over the slide's height, left near bottom dead centre, right over the stroke.

    Each limit is a thin line. The permissible force is a thick line in the colour of the limit that governs. Thin hyperbolas are lines of
    constant energy. The lower panels show the work of the force from a height down to bottom dead centre, and the energies that limit it.

    Args:
        ratings: The ratings of a press.
        reactions: Reactions of this press to one period under process loads, whose force is drawn too, dashed.
        ax: The caller's four axes, the upper two first; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, ``ratings`` is not a `PressRatings`, the reactions are of another press, or ``ax`` are
            not four axes.
    """
    with panels(ax, 4, HIGH, lambda figure: figure.subplots(2, 2, height_ratios=(1.7, 1.0)).ravel()) as drawn:
        upper, lower = drawn.axes[:2], drawn.axes[2:]
        lines: list[Artist] = []
        for column, reach in enumerate((_near(ratings), ratings.stroke)):
            lines = _forces(upper[column], ratings, reach)
            if reactions is not None:
                lines += _process(upper[column], ratings, reactions)
            _works(lower[column], ratings, reach)
        if drawn.own:  # the panels share labels
            for axes in (upper[1], lower[1]):
                axes.set_ylabel("")
            for axes in upper:
                axes.set_xlabel("")
        names = [*ratings.limits, *([] if reactions is None else ["process force"])]
        drawn.legend(lines, names, loc="outside upper center", ncols=4)
        drawn.align_labels()
    return drawn.figure


def _near(ratings: PressRatings) -> float:
    """Largest height in the left panel [m]."""
    nominal = ratings.capacities.nominal_height
    marks = [height for height in (*ratings.changes, *([] if nominal is None else [nominal])) if height < ratings.stroke / 2]
    return min(NEAR * max(marks, default=0.1 * ratings.stroke), ratings.stroke)


def _forces(axes: Axes, ratings: PressRatings, reach: float) -> list[Artist]:
    height, top = 1e3 * ratings.height, ROOM * ratings.capacities.nominal_force / 1e3
    grid(axes, "process force [kN]")
    for share in HYPERBOLAS:
        _hyperbola(axes, float(f"{share**2 * top * reach:.2g}"), 1e3 * reach, top, _clear_of(ratings, 1e3 * reach, top))
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


def _process(axes: Axes, ratings: PressRatings, reactions: Reactions) -> list[Artist]:
    """The process force over the height."""
    ratings.utilisation(reactions)  # refuses those of another press
    bottom = dead_centres(reactions._press).bottom_position
    height = 1e3 * (reactions.motion.slide_position - bottom)
    lines: list[Artist] = [*axes.plot(height, reactions.process_force / 1e3, color="black", linestyle="--", linewidth=1.2)]
    return lines


def _meets(ratings: PressRatings, force: Array) -> Array:
    """Whether a limit equals the permissible force, at every height (n,)."""
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


def _clear_of(ratings: PressRatings, reach: float, top: float) -> Array:
    """Points (k, 2) of all limits' curves in a panel, as shares of its reach [mm] and of its top [kN]."""
    height = 1e3 * ratings.height / reach
    curves = [np.stack([height, force / 1e3 / top], axis=1) for force in ratings.limits.values()]
    return np.concatenate(curves)


def _hyperbola(axes: Axes, energy: float, reach: float, top: float, taken: Array) -> None:
    """Forces [kN] of constant energy [kJ] over the height [mm], with its name near the diagonal, where it is clear of points (k, 2)."""
    height = np.geomspace(1e3 * energy / top, reach, 200)
    axes.plot(height, 1e3 * energy / height, color=GREY, linewidth=0.5, linestyle=(0, (1, 2)))
    middle = np.sqrt(1e3 * energy * reach / top)

    def overlap(place: float) -> int:
        here = np.array([place / reach, 1e3 * energy / place / top])
        inside = (here > HALF_NAME) & (here < 1 - np.array(HALF_NAME))
        return int((np.abs(taken - here) < HALF_NAME).all(axis=1).sum()) if inside.all() else len(taken)

    place = min(middle * np.array([1.0, 0.85, 1.18, 0.7, 1.4, 0.6, 1.7, 0.5, 2.0]), key=overlap)
    name = axes.text(place, 1e3 * energy / place, f"{energy:g} kJ", fontsize=SMALL - 1.5, color=GREY, ha="center", va="center", zorder=1.5)
    plain(name).set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.5})


def _look(i: int) -> dict[str, Any]:
    return {"color": COLOURS[i % len(COLOURS)], "linestyle": LINES[i // len(COLOURS) % len(LINES)]}


def _limits(axes: Axes, reach: float, top: float) -> None:
    axes.set_xlim(0.0, 1e3 * reach)
    axes.set_ylim(0.0, top)
