"""Plots of measured vibrations: spectra, orders over the speed, and measured modes beside calculated ones."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..common.arguments import expect, typed
from ..common.errors import PinpressError, UnknownNameError
from ..common.quantities import RPM
from ..foundation.mounted_press import VibrationModes
from ..measured.hit_modes import MeasuredModes
from ..measured.vibration_spectra import OrderSpectra, Spectra
from .style import COLOURS, GREY, LINES, grid, legend, panels, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEIGHT = 7.5  # of a picture [cm]
DEEP = 3.0  # decades of amplitude that colours show
MOST_CHANNELS = 8  # channels of a legend


@typed
def measured_spectra(found: Spectra, channels: Iterable[str] | None = None, *, ax: Axes | Iterable[Axes] | None = None) -> Figure:
    """Draw spectral densities of channels over the frequency.

    Args:
        found: what ``vibration(...).spectra()`` returns.
        channels: their names; by default the eight strongest.
        ax: the caller's axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, or ``found`` is something else.
        UnknownNameError: there is no such channel.
    """
    expect("found", found, Spectra, "vibration(...).spectra")
    strongest = np.argsort(-found.rms, kind="stable")[:MOST_CHANNELS]
    names = [found.channels[k] for k in sorted(strongest)] if channels is None else list(channels)
    for name in names:
        if not isinstance(name, str) or name not in found.channels:
            raise UnknownNameError("channel", name, found.channels)
    if not names:
        raise PinpressError("channels is empty: name one or more")
    with panels(ax, 1, HEIGHT, lambda figure: [figure.subplots()]) as drawn:
        (panel,) = drawn.axes
        lines = []
        for k, name in enumerate(names):
            look: dict[str, Any] = {
                "color": COLOURS[k % len(COLOURS)],
                "linestyle": LINES[k // len(COLOURS) % len(LINES)],
                "linewidth": 0.9,
            }
            density = np.maximum(found.density[1:, found.channels.index(name)], np.finfo(float).tiny)
            lines += panel.plot(found.frequency[1:], np.sqrt(density), **look)
        panel.set_yscale("log")
        grid(panel, "acceleration [m/s²/√Hz]")
        plain(panel.set_xlabel("frequency [Hz]"))
        legend(panel, lines, names, loc="best", ncols=2)
    return drawn.figure


@typed
def order_spectra(
    found: OrderSpectra, channel: str, *, beside: VibrationModes | None = None, ax: Axes | Iterable[Axes] | None = None
) -> Figure:
    """Draw the amplitudes of a channel over speed and frequency: orders rise as rays, natural frequencies stand.

    Args:
        found: what ``vibration(...).order_spectra()`` returns.
        channel: its name.
        beside: calculated modes, whose frequencies are drawn as lines.
        ax: the caller's axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, ``found`` is something else, or has fewer than two windows.
        UnknownNameError: there is no such channel.
    """
    expect("found", found, OrderSpectra, "vibration(...).order_spectra")
    if not isinstance(channel, str) or channel not in found.channels:
        raise UnknownNameError("channel", channel, found.channels)
    if len(found.speed) < 2:
        raise PinpressError("one window makes no picture over the speed: give fewer turns, or runs at several speeds")
    amplitude = found.amplitude[:, :, found.channels.index(channel)]
    top = float(amplitude.max()) or 1.0
    with panels(ax, 1, HEIGHT, lambda figure: [figure.subplots()]) as drawn:
        (panel,) = drawn.axes
        speed, order = np.meshgrid(found.speed, found.order, indexing="ij")
        frequency = order * speed / (2 * np.pi)
        shades = 20 * np.log10(np.maximum(amplitude / top, 10**-DEEP))
        mesh = panel.pcolormesh(speed / RPM, frequency, shades, cmap="viridis", shading="gouraud", rasterized=True)
        bar = panel.figure.colorbar(mesh, cax=panel.inset_axes((1.02, 0.0, 0.025, 1.0)))  # inside axes that the caller gave
        plain(bar.ax.set_ylabel(f"dB of {top:.3g} m/s²"))
        for w in () if beside is None else beside.natural_frequency / (2 * np.pi):
            if w < frequency.max():
                panel.axhline(w, color="white", linewidth=0.8, linestyle=(0, (4, 3)))
        grid(panel, "frequency [Hz]")
        panel.grid(False)
        panel.set_ylim(0.0, float(frequency.max()))
        plain(panel.set_xlabel("strokes per minute"))
        plain(panel.set_title(channel, loc="left"))
    return drawn.figure


@typed
def measured_modes(found: MeasuredModes, *, ax: Iterable[Axes] | None = None) -> Figure:
    """Draw measured modes beside the calculated ones: damping over frequency, and the agreement of all shapes (MAC).

    Args:
        found: what ``vibration(...).modes(beside=...)`` returns.
        ax: the caller's two axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, or ``found`` is something else, or has no calculated modes beside it.
    """
    expect("found", found, MeasuredModes, "vibration(...).modes")
    beside = found.beside
    if beside is None:
        raise PinpressError("no calculated modes stand beside the measured ones: modes(beside=foundation.modes(system))")
    with panels(ax, 2, HEIGHT, lambda figure: figure.subplots(1, 2, width_ratios=(3, 2))) as drawn:
        left, right = drawn.axes
        hertz = found.natural_frequency / (2 * np.pi)
        measured = left.errorbar(
            hertz,
            100 * found.damping_ratio,
            yerr=200 * found.damping_ratio_deviation,
            xerr=2 * found.natural_frequency_deviation / (2 * np.pi),
            fmt="o",
            color=COLOURS[1],
            markersize=4,
            linewidth=0.9,
        )
        calculated = left.plot(
            beside.natural_frequency / (2 * np.pi), 100 * beside.damping_ratio, "s", color=COLOURS[0], mfc="none", markersize=6
        )
        for k, place in enumerate(found.partner):
            if place >= 0:
                ends = (
                    [hertz[k], beside.natural_frequency[place] / (2 * np.pi)],
                    [100 * found.damping_ratio[k], 100 * beside.damping_ratio[place]],
                )
                left.plot(*ends, color=GREY, linewidth=0.7, zorder=0)
        grid(left, "damping ratio [%]")
        left.margins(x=0.06)
        left.set_ylim(0.0, 115 * max(found.damping_ratio.max(), beside.damping_ratio.max()))
        plain(left.set_xlabel("natural frequency [Hz]"))
        legend(left, [measured.lines[0], calculated[0]], ["measured", "calculated"], loc="best")
        right.imshow(found.mac, vmin=0.0, vmax=1.0, cmap="Blues", aspect="auto")
        for i, row in enumerate(found.mac):
            for k, value in enumerate(row):
                right.text(k, i, f"{value:.2f}", ha="center", va="center", fontsize=6, color="white" if value > 0.5 else "black")
        right.set_xticks(range(found.mac.shape[1]), [f"{w / (2 * np.pi):.4g}" for w in beside.natural_frequency], rotation=45, fontsize=7)
        right.set_yticks(range(len(hertz)), [f"{w:.4g}" for w in hertz], fontsize=7)
        plain(right.set_title("agreement of shapes (MAC)", loc="left"))
        plain(right.set_xlabel("calculated [Hz]"))
        plain(right.set_ylabel("measured [Hz]"))
    return drawn.figure
