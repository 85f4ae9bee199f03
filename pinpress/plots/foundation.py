"""Plots of a press on its mounts: accelerations in time, acceleration, force on the floor and natural frequencies over speed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..common.arguments import number, typed, whole_number
from ..common.errors import PinpressError, UnknownNameError
from ..common.quantities import RPM, Array
from ..foundation.response import FrameMotion
from ..foundation.speed_response import SpeedResponse
from ..foundation.whirl_modes import WhirlDiagram
from .style import COLOURS, GREY, grid, legend, panels, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGH = 5.0  # height of one panel [cm]
MOST_ORDERS = 20
DECADE = 10.0  # ratio of largest to smallest value up to which an axis is linear


@typed
def vibration(
    motions: Mapping[str, FrameMotion], axis: str = "z", last: float | None = None, *, ax: Axes | Iterable[Axes] | None = None
) -> Figure:
    """Draw the acceleration of all points along an axis over time, with a panel for each motion.

    Args:
        motions: results of `steady_response` or `time_response`, by the motions' names.
        axis: "x", "y" or "z".
        last: time shown at the end of each motion; by default all [s].
        ax: the caller's axes, one for each motion; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, there is no motion, no such axis, or ``ax`` are not as many axes as motions.
    """
    named = isinstance(motions, Mapping) and all(isinstance(motion, FrameMotion) for motion in motions.values())
    if not named or not motions or not isinstance(axis, str) or axis not in ("x", "y", "z"):
        raise PinpressError("there is nothing to draw: give motions, each under a name, and an axis 'x', 'y' or 'z'")
    count = len(motions)
    with panels(ax, count, HIGH * count, lambda figure: figure.subplots(count, 1, squeeze=False)[:, 0]) as drawn:
        for panel, (name, motion) in zip(drawn.axes, motions.items(), strict=True):
            shown = motion.time >= motion.time[-1] - (np.inf if last is None else number("last", last, positive=True))
            lines = []
            for k, values in enumerate(motion.acceleration.values()):
                lines += panel.plot(motion.time[shown], values[shown, "xyz".index(axis)], color=COLOURS[k % len(COLOURS)], linewidth=0.9)
            grid(panel, f"acceleration {axis} [m/s²]")
            plain(panel.set_title(name, loc="left"))
            where = {"loc": "lower right", "bbox_to_anchor": (1.01, 0.98), "borderaxespad": 0.2, "columnspacing": 1.4}
            legend(panel, lines, list(motion.acceleration), ncols=len(lines), **where)  # above the panel, clear of the curves
        plain(panel.set_xlabel("time [s]"))
    return drawn.figure


@typed
def speed_response(responses: Mapping[str, SpeedResponse], point: str, *, ax: Iterable[Axes] | None = None) -> Figure:
    """Draw the acceleration of a point (root mean square, all directions) and the share of force on the floor over the speed.

    Args:
        responses: results of `over_speeds`, by the names of the curves.
        point: name of a point that all responses have.
        ax: the caller's two axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, there is no response, or ``ax`` are not two axes.
        UnknownNameError: a response does not have this point.
    """
    if not isinstance(responses, Mapping) or not responses or not all(isinstance(each, SpeedResponse) for each in responses.values()):
        raise PinpressError("there is nothing to draw: give what over_speeds returns, under a name")
    for response in responses.values():
        if not isinstance(point, str) or point not in response.rms:
            raise UnknownNameError("point", point, response.rms)
    with panels(ax, 2, 1.4 * HIGH, lambda figure: figure.subplots(1, 2)) as drawn:
        left, right = drawn.axes
        lines = []
        for k, response in enumerate(responses.values()):
            colour, speed = COLOURS[k % len(COLOURS)], response.speed / RPM
            lines += left.plot(speed, _size(response.rms[point]), color=colour)
            right.plot(speed, response.transmitted, color=colour)
        for panel, label in ((left, f"acceleration of {point}, rms [m/s²]"), (right, "force on the floor / shaking force [-]")):
            low, high = panel.dataLim.intervaly
            panel.set_yscale("log" if high > DECADE * low else "linear")
            grid(panel, label)
            plain(panel.set_xlabel("strokes per minute"))
        legend(left, lines, list(responses), loc="best")
    return drawn.figure


@typed
def whirl(diagram: WhirlDiagram, orders: int = 2, *, ax: Axes | None = None) -> Figure:
    """Draw natural frequencies over the speed, forward whirl solid, backward dashed, with harmonics of the crank and dots where they meet.

    Args:
        diagram: result of `pinpress.foundation.whirl`.
        orders: number of harmonics, 0 to 20.
        ax: the caller's axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, ``orders`` is no such number, or ``ax`` are no axes.
    """
    harmonics = range(1, whole_number("orders", orders, 0, MOST_ORDERS) + 1)
    with panels(ax, 1, 1.4 * HIGH, lambda figure: [figure.subplots()]) as drawn:
        axes, speed = drawn.axes[0], diagram.speed / RPM
        highest = 1.05 * diagram.frequency.max() / (2 * np.pi)
        for mode, frequency in enumerate(diagram.frequency.T / (2 * np.pi)):
            dashed = diagram.words(mode) == "backward"
            axes.plot(speed, frequency, color=COLOURS[mode % len(COLOURS)], linestyle="--" if dashed else "-")
        for order in harmonics:
            axes.plot(speed, order * diagram.speed / (2 * np.pi), color=GREY, linewidth=0.6)
            met = diagram.critical_speeds(order)
            met = met[(met >= diagram.speed[0]) & (met <= diagram.speed[-1])]
            axes.plot(met / RPM, order * met / (2 * np.pi), "o", markersize=3, color="black")
        grid(axes, "frequency [Hz]")
        axes.set_ylim(0.0, highest)
        plain(axes.set_xlabel("crank speed [r/min]"))
    return drawn.figure


def _size(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=1))
