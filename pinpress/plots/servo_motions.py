"""Plots of servo motions: the slide's height, speed, torque and power over the time, and the motor's torque over its speed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..common.arguments import typed
from ..common.errors import PinpressError
from ..common.quantities import RPM
from ..servo.motion import ServoMotion
from ..servo.motors import CatalogueMotor
from .style import COLOURS, GREY, LINES, THIN, grid, legend, panels, plain

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGH = 4.1  # of each chart, for the label beside it [cm]
CURVE = 120  # points of a motor's curve


@typed
def servo(motions: Mapping[str, ServoMotion], *, ax: Iterable[Axes] | None = None) -> Figure:
    """Draw motions of a servo press over the time: the slide's height, the crank's speed, the torque and the power of the motor.

    The limits of the first motion's drive are dashed lines.

    Args:
        motions: results of `pinpress.servo.evaluate` and `ready_motions`, or ``motion`` of `best_motion`, by the names of the curves.
        ax: the caller's axes, four; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, there is no motion, or ``ax`` are not four axes.
    """
    _refuse_none(motions)
    drive = next(iter(motions.values())).drive
    labels = ("slide height [mm]", "crank speed [r/min]", "motor torque [N m]", "power [kW]")
    with panels(ax, 4, 4 * HIGH, lambda figure: figure.subplots(4, 1, sharex=True)) as drawn:
        lines: list[Artist] = []
        for axes, label in zip(drawn.axes, labels, strict=True):
            grid(axes, label)
        for i, motion in enumerate(motions.values()):
            look = {"color": COLOURS[i % len(COLOURS)], "linestyle": LINES[i // len(COLOURS) % len(LINES)]}
            curves = (1e3 * motion.height, motion.speed / RPM, motion.motor_torque, 1e-3 * motion.power)
            for axes, values in zip(drawn.axes, curves, strict=True):
                made = axes.plot(motion.time, values, **look)  # type: ignore[arg-type]  # a colour and a kind of line
            lines += made
        limits = (
            (1, None if drive.top_speed is None else drive.top_speed / drive.ratio / RPM),
            (2, drive.peak_torque),
            (3, None if drive.power is None else 1e-3 * drive.power),
        )
        for k, most in limits:
            if most is None:
                continue
            low = float(drawn.axes[k].dataLim.intervaly[0])
            for sign in (1, -1) if low < -0.5 * most else (1,):
                drawn.axes[k].axhline(sign * most, color=GREY, linewidth=THIN, linestyle="--")
        plain(drawn.axes[-1].set_xlabel("time [s]"))
        if len(motions) > 1:
            drawn.legend(lines, [str(name) for name in motions], loc="outside upper center", ncols=min(len(motions), 4))
        drawn.align_labels()
    return drawn.figure


@typed
def torque_over_speed(motions: Mapping[str, ServoMotion], motor: CatalogueMotor | None = None, *, ax: Axes | None = None) -> Figure:
    """Draw sizes of the motor's torque over its speed, below the motor's peak and permanent (S1) torque; a dot is the root mean square at
    the mean speed, to be below the latter.

    Args:
        motions: motions as for `servo`.
        motor: the motor; by default only the limits of the first motion's drive are drawn.
        ax: the caller's axes; by default those of a new figure.

    Raises:
        PinpressError: Matplotlib is not installed, there is no motion, ``motor`` is none, or ``ax`` are no axes.
    """
    _refuse_none(motions)
    if motor is not None and not isinstance(motor, CatalogueMotor):
        raise PinpressError(f"motor is a {type(motor).__name__}: give one of servo.read_motors, or servo.CatalogueMotor")
    drive = next(iter(motions.values())).drive
    with panels(ax, 1, 7.0, lambda figure: [figure.subplots()]) as drawn:
        axes = drawn.axes[0]
        lines: list[Artist] = []
        names: list[str] = []
        grid(axes, "motor torque [N m]")
        for i, (name, motion) in enumerate(motions.items()):
            colour, size = COLOURS[i % len(COLOURS)], np.abs(motion.motor_speed)
            lines += axes.plot(size / RPM, np.abs(motion.motor_torque), color=colour)
            names.append(str(name))
            mean = float(motion.weight @ size) / motion.duration
            axes.plot(mean / RPM, motion.rms_motor_torque, "o", markersize=4, color=colour)
        if motor is not None:
            speed = np.linspace(0.0, motor.top_speed, CURVE)
            curves = {"peak torque": motor.peak_torque_at(speed), "permanent torque (S1)": motor.rated_torque_at(speed)}
        else:
            top = drive.top_speed or float(axes.dataLim.intervalx[1]) * RPM
            speed = np.linspace(0.0, top, CURVE)
            curves = {} if drive.peak_torque is None else {"peak torque": drive.peak_torque_at(speed)}
            curves |= {} if drive.rated_torque is None else {"rated torque": np.full(CURVE, drive.rated_torque)}
        for style, (name, values) in zip(("-", "--"), curves.items(), strict=False):
            lines += axes.plot(speed / RPM, values, color="black", linewidth=1.0, linestyle=style)
            names.append(name)
        plain(axes.set_xlabel("speed of the motor [r/min]"))
        axes.set_xlim(left=0.0)
        axes.set_ylim(bottom=0.0)
        legend(axes, lines, names, loc="best")
    return drawn.figure


def _refuse_none(motions: object) -> None:
    if not isinstance(motions, Mapping) or not motions or not all(isinstance(each, ServoMotion) for each in motions.values()):
        raise PinpressError("there is no motion to draw: give motions under their names, {'least heat': best.motion}")
