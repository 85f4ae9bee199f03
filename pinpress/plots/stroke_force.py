"""Plot of a process force that was measured by the drive of a press."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..common.arguments import typed
from ..common.errors import PinpressError
from ..common.quantities import Array
from ..measured.stroke_force import MeasuredForce
from .style import COLOURS, grid, legend, panels, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

HEIGHT = 7.5  # of a picture [cm]


@typed
def measured_force(forces: Mapping[str, MeasuredForce], *, ax: Axes | Iterable[Axes] | None = None) -> Figure:
    """Draw process forces over the height of the slide with their 95 % bands; the slide moves down from right to left, and
    up, drawn with dashes, from left to right.

    Args:
        forces: what ``process_force`` returns, each under a name.
        ax: the caller's axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, or there is no force.
    """
    if not forces or not all(isinstance(each, MeasuredForce) for each in forces.values()):
        raise PinpressError("there is nothing to draw: give what process_force returns, under a name: {'stroke 1': force}")
    with panels(ax, 1, HEIGHT, lambda figure: [figure.subplots()]) as drawn:
        (panel,) = drawn.axes
        lines: list[Line2D] = []
        names: list[str] = []
        for k, (name, found) in enumerate(forces.items()):
            colour = COLOURS[k % len(COLOURS)]
            down = _drawn(panel, (found.slide_height, found.force, found.interval), colour, "-")
            up = _drawn(panel, (found.slide_height_up, found.force_up, found.interval_up), colour, "--") if len(found.heights_up) else []
            lines, names = [*lines, *down, *up], [*names, name, *([f"{name}, up"] if up else [])]
        panel.axhline(0.0, color="black", linewidth=0.6)
        grid(panel, "force [kN]")
        plain(panel.set_xlabel("height of the slide above bottom dead centre [mm]"))
        legend(panel, lines, names, loc="best")
    return drawn.figure


def _drawn(panel: Axes, ways: tuple[Array, Array, Array], colour: str, style: str) -> list[Line2D]:
    """The line of heights [m], forces [N] and their intervals of one way."""
    height, force, interval = ways
    rising = np.argsort(height, kind="stable")
    millimetres, ends = 1e3 * height[rising], 1e-3 * interval[rising]
    panel.fill_between(millimetres, ends[:, 0], ends[:, 1], color=colour, alpha=0.2, linewidth=0)
    return panel.plot(millimetres, 1e-3 * force[rising], style, color=colour, marker="o", markersize=2.5)
