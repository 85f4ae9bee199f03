"""Plot of what records can teach of a press."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..common.arguments import typed
from ..common.errors import PinpressError
from ..measured.what_is_known import IdentifiableParameters
from .style import COLOURS, GREY, THIN, legend, panels, plain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BAR = 0.42  # height of one parameter [cm]
MARGIN = 2.2  # above and below the bars [cm]


@typed
def identifiability(found: IdentifiableParameters, *, ax: Axes | None = None) -> Figure:
    """Draw the doubt that records leave of each parameter, by torque and with shaking force and moment beside it.

    A bar that ends at 0 is fully known, one that ends at 1 is as doubtful as before.

    Args:
        found: what `pinpress.measured.identifiability` returns of some runs.
        ax: the caller's axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, or no runs were given to identifiability.
    """
    if not found.parameters:
        raise PinpressError("there is nothing to draw: give runs, identifiability(press, runs)")
    height = MARGIN + BAR * len(found.parameters)
    with panels(ax, 1, height, lambda figure: [figure.subplots()]) as drawn:
        (panel,) = drawn.axes
        places = np.arange(len(found.parameters))
        doubts = [each.torque for each in found.parameters], [each.shaking for each in found.parameters]
        bars: list[Artist] = []
        for values, shift, colour in zip(doubts, (-0.2, 0.2), COLOURS, strict=False):
            bars += panel.barh(places + shift, np.minimum(values, 1.0), 0.38, color=colour).patches[:1]
        panel.axvline(1.0, color=GREY, linewidth=THIN)
        panel.set_yticks(places, [each.name for each in found.parameters])
        for label in panel.get_yticklabels():
            plain(label)
        panel.set_xlim(0.0, 1.05)
        panel.margins(y=0.01)
        panel.invert_yaxis()
        plain(panel.set_xlabel("doubt that is left, by that before"))
        legend(panel, bars, ["torque", "torque, shaking force and moment"], loc="lower center", bbox_to_anchor=(0.4, 1.0), ncols=2)
    return drawn.figure
