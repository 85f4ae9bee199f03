"""Plot of a process force that was measured by the drive of a press."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..common.arguments import typed
from ..common.errors import PinpressError
from ..measured.stroke_force import MeasuredForce
from .style import COLOURS, grid, legend, panels, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEIGHT = 7.5  # of a picture [cm]


@typed
def measured_force(forces: Mapping[str, MeasuredForce], *, ax: Axes | Iterable[Axes] | None = None) -> Figure:
    """Draw process forces over the height of the slide with their 95 % bands; the slide moves down from right to left.

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
        lines = []
        for k, found in enumerate(forces.values()):
            colour, low = COLOURS[k % len(COLOURS)], found.interval * 1e-3
            rising = np.argsort(found.slide_height, kind="stable")
            millimetres = 1e3 * found.slide_height[rising]
            panel.fill_between(millimetres, low[rising, 0], low[rising, 1], color=colour, alpha=0.2, linewidth=0)
            lines += panel.plot(millimetres, 1e-3 * found.force[rising], color=colour, marker="o", markersize=2.5)
        panel.axhline(0.0, color="black", linewidth=0.6)
        grid(panel, "force [kN]")
        plain(panel.set_xlabel("height of the slide above bottom dead centre [mm]"))
        legend(panel, lines, list(forces), loc="best")
    return drawn.figure
