"""Plots of elastic presses: compliance by parts, bottom dead centre over speed, snap-through, elastic motion, resonances."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.arguments import typed
from ..common.errors import PinpressError
from ..common.quantities import RPM, Array
from ..elasticity.breakthrough import SnapThroughResponse
from ..elasticity.guide_surfaces import LoadedGuide
from ..elasticity.slide_under_load import ElasticDeadCentre
from ..elasticity.speed_range import CampbellDiagram
from ..elasticity.unit_load import SlideCompliance
from ..kinematics.slide_path import dead_centres
from .style import COLOURS, GREY, LINES, Over, grid, legend, panels, plain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGH = 7.0  # height of a chart [cm]
ROOM = 0.28  # height for each name in the legend, above a curve of height 1


@typed
def compliance(elasticity: SlideCompliance, *, ax: Axes | None = None) -> Figure:
    """Draw the compliance at the slide over the crank angle, with the shares of the parts stacked, the largest at the bottom.

    Args:
        elasticity: result of `pinpress.elasticity.compliance`.
        ax: the caller's axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, or ``ax`` are no axes.
    """
    order, coordinate = np.argsort(elasticity.crank_angle), elasticity.coordinate
    with panels(ax, 1, HIGH, lambda figure: [figure.subplots()]) as drawn:
        from matplotlib.ticker import MaxNLocator  # optional, and slow to import

        axes = drawn.axes[0]
        grid(axes, "compliance [µm/kN]")
        parts = _largest_parts(elasticity)
        colours, names = [colour for colour, _, _ in parts], [name for _, name, _ in parts]
        curves = [1e9 * part[order] for _, _, part in parts]
        areas: list[Artist] = list(
            axes.stackplot(coordinate.scale * elasticity.crank_angle[order], curves, colors=colours, alpha=0.75, linewidth=0)
        )
        plain(axes.set_xlabel(f"{coordinate.position} [{coordinate.shown_unit}]"))
        axes.set_ylim(0.0, 1.45e9 * float(elasticity.compliance.max()))  # room for the names
        axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 1.5, 3, 4.5, 9, 10]))
        legend(axes, areas[::-1], names[::-1], loc="upper center", ncols=3, columnspacing=1.0, borderaxespad=0.1)
    return drawn.figure


def _largest_parts(elasticity: SlideCompliance) -> list[tuple[str, str, Array]]:
    """Colours, names and compliances of as many parts as there are colours, the largest first, and of the others together in grey."""
    parts = elasticity.largest_parts(len(COLOURS))
    return [(GREY if name == "others" else colour, name, part) for colour, (name, part) in zip((*COLOURS, GREY), parts, strict=False)]


@typed
def dead_centre_shift(shifts: Mapping[str, ElasticDeadCentre], *, ax: Axes | None = None) -> Figure:
    """Draw the shift of bottom dead centre over the speed, relative to standstill.

    Args:
        shifts: results of `pinpress.elasticity.dead_centre_shift`, by the names of the presses.
        ax: the caller's axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, there is no press, or ``ax`` are no axes.
    """
    _refuse_none(shifts, "dead_centre_shift", ElasticDeadCentre)
    with panels(ax, 1, HIGH, lambda figure: [figure.subplots()]) as drawn:
        axes = drawn.axes[0]
        grid(axes, "shift of bottom dead centre [µm]")
        lines: list[Artist] = []
        for i, shift in enumerate(shifts.values()):
            order = np.argsort(shift.speed)
            rate = dead_centres(shift._press).strokes_per_turn / RPM
            lines += axes.plot(shift.speed[order] * rate, 1e6 * shift.shift[order], color=COLOURS[i % len(COLOURS)], linestyle=_line(i))
        plain(axes.set_xlabel("strokes/min"))
        legend(axes, lines, list(shifts), loc="lower left")
    return drawn.figure


@typed
def snap_through(responses: Mapping[str, SnapThroughResponse], *, ax: Axes | None = None) -> Figure:
    """Draw the force of the sprung press over time, divided by that at break-through; below zero the linkage is pulled.

    Args:
        responses: results of `pinpress.elasticity.snap_through`, by the names of the curves.
        ax: the caller's axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, there is no curve, or ``ax`` are no axes.
    """
    _refuse_none(responses, "snap_through", SnapThroughResponse)
    with panels(ax, 1, HIGH, lambda figure: [figure.subplots()]) as drawn:
        axes = drawn.axes[0]
        grid(axes, "force / force at break-through [-]")
        axes.axhline(0.0, color=GREY, linewidth=0.6)
        lines: list[Artist] = []
        for i, response in enumerate(responses.values()):
            share = response.spring_force / response.force
            lines += axes.plot(1e3 * response.time, share, color=COLOURS[i % len(COLOURS)], linestyle=_line(i))
        plain(axes.set_xlabel("time [ms]"))
        axes.set_ylim(-1.1, 1.1 + ROOM * len(responses))
        legend(axes, lines, list(responses), loc="upper right", borderaxespad=0.1)
    return drawn.figure


@typed
def guide_contact(found: LoadedGuide, *, ax: Iterable[Axes] | None = None) -> Figure:
    """Draw the force on each surface of a slide's guide over the motion, and below it how the slide tilts and turns.

    Args:
        found: result of `pinpress.elasticity.guide_contact`.
        ax: the caller's axes, two; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, or ``ax`` are not two axes.
    """
    over = Over(found.motion)
    with panels(ax, 2, 2 * HIGH, lambda figure: figure.subplots(2, 1, sharex=True)) as drawn:
        top, bottom = drawn.axes
        grid(top, "force on a surface [kN]")
        grid(bottom, "rotation of the slide [µrad]")
        lines: list[Artist] = []
        for i, force in enumerate(found.force.values()):  # of two that carry the same, the second is seen on the first
            colour = COLOURS[i % len(COLOURS)]
            lines += top.plot(over.x, over.along(1e-3 * force), color=colour, linestyle=LINES[i % 2])
        low, high = top.get_ylim()
        top.set_ylim(low, high + 0.4 * (high - low))  # room for the names
        legend(top, lines, list(found.force), loc="upper center", ncols=4, columnspacing=0.8)
        turns = [bottom.plot(over.x, over.along(1e6 * turn), color=COLOURS[i])[0] for i, turn in enumerate(found.rotation.T)]
        legend(bottom, turns, [f"about {axis}" for axis in "xyz"], loc="best", ncols=3)
        over.label(bottom)
        drawn.align_labels()
    return drawn.figure


@typed
def campbell(diagram: CampbellDiagram, *, ax: Axes | None = None) -> Figure:
    """Draw natural frequencies as bands over the speed, the orders of the strokes as lines, and a dot where they meet.

    Args:
        diagram: result of `pinpress.elasticity.campbell`.
        ax: the caller's axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, or ``ax`` are no axes.
    """
    with panels(ax, 1, HIGH, lambda figure: [figure.subplots()]) as drawn:
        axes, speed = drawn.axes[0], diagram.speed / RPM
        grid(axes, "frequency [Hz]")
        highest = float(diagram.order_frequency(diagram.orders)[-1]) / (2 * np.pi)
        for mode, band in enumerate(diagram.modes.natural_frequency.T / (2 * np.pi)):
            if band.min() <= highest:
                axes.axhspan(band.min(), band.max(), color=COLOURS[mode % len(COLOURS)], alpha=0.5)
        for order in range(1, diagram.orders + 1):
            axes.plot(speed, diagram.order_frequency(order) / (2 * np.pi), color=GREY, linewidth=0.6)
        met = [each for each in diagram.resonances if diagram.speed[0] <= each.speed <= diagram.speed[-1]]
        frequency = [each.speed * each.order / diagram.turns / (2 * np.pi) for each in met]
        axes.plot([each.speed / RPM for each in met], frequency, "o", markersize=3, color="black")
        plain(axes.set_xlabel("crank speed [r/min]"))
        axes.set_ylim(0.0, 1.02 * highest)
    return drawn.figure


def _line(i: int) -> Any:
    """A kind of line, solid, dashed, dotted and so on, which tells coinciding curves apart."""
    return LINES[i % len(LINES)]


def _refuse_none(given: Mapping[str, object], maker: str, kind: type) -> None:
    if not isinstance(given, Mapping) or not given or not all(isinstance(each, kind) for each in given.values()):
        raise PinpressError(f"there is no curve to draw: give what {maker} returns, under a name")
