"""Cam tables for motion controllers: the slide's height or the crank's angle over a master axis that turns once in the period of a motion.

A controller connects the points of a table by lines or polynomials. The table has the fewest equal steps with which its curve stays within
a tolerance of the motion, and a point at each corner of the motion's law. The error is measured between the points.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..common import files
from ..common.arguments import expect, positive, typed
from ..common.errors import PinpressError, shown, suggestion
from ..common.numerics import quintics
from ..common.quantities import Array
from ..common.results import Tabular
from ..dynamics.inputs import motion_in_words, of_press, stated
from ..kinematics.motion import Motion, is_cycle
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage, OfPress
from .motion import ServoMotion
from .state_curve import SAME, StateCurve, state_curve

TURN = 360.0  # of the master axis [deg]
SAMPLES = 200  # places in a step at which the error is measured: a peak between two of them is larger by 1e-4 of it at most
MOST_STEPS = 5000
DECIMALS = 10  # of the numbers of a table, so that none has an exponent
SEAM = 1e-6  # share of its range by which a quantity may miss the start of the next period


@dataclass(frozen=True, eq=False, repr=False)
class CamPoints(OfPress, Tabular):
    """A cam: points of a slave axis over a master axis from 0 to 360 deg. Units are those of controllers.

    Attributes:
        of: "height" or "angle".
        layout: of the file, see `cam_table`.
        unit: of the slave: "mm" or "deg".
        interpolation: between the points, with which the error is measured: "linear", "cubic spline" or "quintic".
        period: time in which the master turns once [s].
        closed: whether the motion repeats itself.
        master: (n,) places of the master axis [deg].
        slave: (n,) heights of the slide above bottom dead centre [mm], or unwrapped positions of the driver [deg, or mm where it slides].
        velocity: (n,) of the slave per degree of the master [mm/deg or deg/deg].
        acceleration: (n,) of the slave per squared degree of the master [mm/deg2 or deg/deg2]; at a corner the mean of both sides.
        error: largest error between the points [mm or deg].
        error_at: place of the master axis with this error [deg].
        corners: number of corners of the motion's law, each of which is a point.
        motion: the motion as text.
    """

    _press: Linkage
    of: str
    layout: str
    unit: str
    interpolation: str
    period: float
    closed: bool
    master: Array
    slave: Array
    velocity: Array
    acceleration: Array
    error: float
    error_at: float
    corners: int
    motion: str

    @property
    def title(self) -> str:
        """The press, the tabulated quantity, the number of points and the largest error."""
        return (
            f"CamPoints of {self.press_name}: {self.of} at {len(self.master)} points, {self.interpolation}, error {self._error_as_text}"
            f" at {self.error_at:.5g} deg"
        )

    @property
    def advance(self) -> float:
        """Advance of the slave in a turn of the master [mm or deg]; 0 if the slave comes back."""
        return float(self.slave[-1] - self.slave[0])

    @property
    def head(self) -> tuple[str, ...]:
        """Lines with press, file and its SHA-256, motion, units, period, largest error and interpolation."""
        slave = "slide above bottom dead centre" if self.of == "height" else "driver, unwrapped"
        once = "the motion repeats itself, the last point is the first of the next turn"
        if not self.closed:
            once = "the motion does not repeat itself, run the table once"
        elif self.advance:
            once += (
                f", {self.advance:+.6g} {self.unit} on; make the slave modulo {abs(self.advance):.6g} {self.unit}, or the table relative"
            )
        scale = f"scale: the controller divides by the largest values: 360 deg and {self.slave.max():.12g} {self.unit}"
        return (
            *(f"{name}: {words}" for name, words in of_press(self._press)[:2]),
            f"motion: {self.motion}",
            f"master: 0 to 360 deg in {self.period:.9g} s",
            f"slave: {self.of} of the {slave} [{self.unit}]; velocity [{self.unit}/deg], acceleration [{self.unit}/deg2]",
            f"points: {len(self.master)}, {self.corners} of them at corners of the motion",
            f"interpolation: {self.interpolation}; largest error {self._error_as_text} at master {self.error_at:.6g} deg",
            f"repetition: {once}",
            *([scale] if self.layout == "kas" else []),
            ": ".join(stated()),
        )

    @property
    def _error_as_text(self) -> str:
        return f"{1e3 * self.error:.4g} um" if self.unit == "mm" else f"{self.error:.4g} deg"

    def columns(self) -> dict[str, Array]:
        """Master, slave, velocity and acceleration."""
        return {
            "master [deg]": self.master,
            f"{self.of} [{self.unit}]": self.slave,
            f"velocity [{self.unit}/deg]": self.velocity,
            f"acceleration [{self.unit}/deg2]": self.acceleration,
        }

    def write(self, path: str | os.PathLike[str]) -> tuple[Path, ...]:
        """Write the file for the controller, with decimal points and CRLF; return what was written.

        For a layout without comments the `head` is in a second file, whose name ends with ".head.txt".

        Raises:
            PinpressError: a file cannot be written.
        """
        layout, target = LAYOUTS[self.layout], Path(path)
        written = [files.write(target, _text(layout.lines(self)))]
        if not layout.comments:
            written.append(files.write(target.with_suffix(".head.txt"), _text(list(self.head))))
        return tuple(written)


class _Layout(NamedTuple):
    """How a controller takes a table: its curve through the points, the fewest steps, whether the file holds the head, and its lines."""

    interpolation: str
    fewest: int
    comments: bool
    lines: Callable[[CamPoints], list[str]]


class _Points(NamedTuple):
    """The columns (n,) of a table."""

    master: Array
    slave: Array
    velocity: Array
    acceleration: Array


def _text(lines: list[str]) -> bytes:
    return "".join(f"{line}\r\n" for line in lines).encode()


def _rows(between: str, *columns: Array) -> list[str]:
    return [between.join(f"{value:.{DECIMALS}f}" for value in row) for row in zip(*columns, strict=True)]


def _xyva(table: CamPoints) -> list[str]:
    return [*(f"# {line}" for line in table.head), *_rows(" ", table.master, table.slave, table.velocity, table.acceleration)]


def _lenze(table: CamPoints) -> list[str]:
    first, *others = _rows(" ", table.master, table.slave)
    return [f"{first} // {'; '.join(table.head)}", *others]  # a comment may only stand behind the numbers of a line


def _kas(table: CamPoints) -> list[str]:
    rows = [f"{row};SPLINE" for row in _rows(";", table.master, table.slave)]
    return [f"CYCLIC;{'YES' if table.closed else 'NO'};", "TABLE_BEGIN;;", *rows, "TABLE_END;;"]


LAYOUTS = {
    "xyva": _Layout("quintic", 1, True, _xyva),
    "pairs": _Layout("linear", 1, False, lambda table: _rows(" ", table.master, table.slave)),
    "sew": _Layout("linear", 1, False, lambda table: [str(len(table.master)), *_rows(";", table.master, table.slave)]),
    "lenze": _Layout("linear", 1, True, _lenze),
    "kas": _Layout("cubic spline", 4, False, _kas),
}


@typed
def cam_table(
    press: Linkage,
    motion: Motion | ServoMotion,
    *,
    of: str = "height",
    layout: str = "xyva",
    tolerance: float = 1e-6,
    period: float | None = None,
) -> CamPoints:
    """A motion as a cam table for a controller: points of a slave axis over a master axis, which turns once in the period.

    The master is at 0 in the first state. Between states the motion is the quintic through positions, speeds and accelerations. The table
    has the fewest equal steps that keep the tolerance; each corner, where two states are at one instant and the acceleration jumps, is a
    point. The angle goes on beyond 360 deg, and below 0 if the crank turns backwards: the last point is the first one plus a whole number
    of turns.

    Args:
        press: the press, with one driver.
        motion: a period of `cycle`, or any motion in time: of a servo drive from its start to its end, or a run.
        of: "height" of the slide above bottom dead centre, or "angle" of the crank; for a driver that slides its position.
        layout: "xyva": master, slave, velocity and acceleration, as for fifth-degree polynomials between points (SMC_CAMXYVA of CODESYS,
            MotionFunctionPoint of TwinCAT); the others are master and slave: "pairs", one a line (CODESYS, TwinCAT), "sew" (MOVI-C),
            "lenze" (Cam Loader) with lines between the points, "kas" (Kollmorgen) with a cubic spline through them.
        tolerance: largest error between the points [m], of an angle [rad].
        period: time after which the motion begins again, for a motion whose last state is one step before that time [s]. Left out: `cycle`
            ends with its period, other motions with their last state.

    Raises:
        PinpressError: an unknown layout; the press has several drivers, or no slide to have a height; the motion has no times, states that
            are not valid, or too few to resolve it to the tolerance; the table would have more than 5000 steps; the largest value of a
            "kas" table is not positive, although the controller scales the table to it.
    """
    states = motion.motion if isinstance(motion, ServoMotion) else motion
    expect("motion", states, Motion, "cycle, servo_cycle or servo.evaluate")
    if not isinstance(of, str) or of not in ("angle", "height"):
        raise PinpressError(f"of is {shown(of)}: give 'angle' or 'height'")
    if not isinstance(layout, str) or layout not in LAYOUTS:
        raise PinpressError(f"layout is {shown(layout)}{suggestion(str(layout), LAYOUTS)}: give one of {', '.join(LAYOUTS)}")
    press.refuse_several_drivers("a cam table has one slave: give the motions of several drivers as tables over time, motion.to_csv(...)")
    if not states.complete:
        raise PinpressError("the motion has states that are not valid: give one without gaps")
    coordinate = press.driver_coordinates[0]
    unit, scale = ("mm", 1e3) if of == "height" else (coordinate.shown_unit, coordinate.scale)
    within = scale * positive("tolerance", tolerance, "m" if unit == "mm" else "rad")
    curve, length, closed = _over_master(press, states, of, scale, period)
    worst = int(curve.missed.argmax())
    if not curve.missed[worst] <= within:
        raise PinpressError(
            f"the states of the motion do not resolve its {of} to the tolerance: near master {curve.starts[worst]:.5g} deg the next state"
            f" is {curve.missed[worst]:.3g} {unit} off; give a motion of more states, or a larger tolerance"
        )
    points, error, error_at = _fewest(curve, closed, LAYOUTS[layout], within, unit)
    if layout == "kas" and not points.slave.max() > 0:
        raise PinpressError(
            f"the largest {of} is {points.slave.max():g} {unit}, but a kas table is divided by it: turn the crank forwards, or give another"
            " layout"
        )
    corners, words = len(curve.corners), motion_in_words(states)
    interpolation = LAYOUTS[layout].interpolation
    return CamPoints(press, of, layout, unit, interpolation, length, closed, *points, error, error_at, corners, words)


def _over_master(press: Linkage, motion: Motion, of: str, scale: float, period: float | None) -> tuple[StateCurve, float, bool]:
    """The slave over the master axis [deg], the period [s], and whether the slave is back after the period, except for whole turns."""
    if of == "height":
        bottom = dead_centres(press).bottom_position
        columns = [motion.slide_position - bottom, motion.slide_velocity, motion.slide_acceleration]
    else:
        columns = [motion.crank_angle, motion.crank_speed, motion.crank_acceleration]
    whole = TURN if of == "angle" and press.driver_coordinates[0].turns else 0.0
    time = motion.time - motion.time[0]
    if period is not None:
        length = positive("period", period, "s")
    elif is_cycle(motion):
        length = float(2 * np.pi * (motion.period_turns or 1) / abs(motion.crank_speed[0]))
    else:
        length = float(time[-1])
    left = length - float(time[-1])
    if left < -SAME * length:
        raise PinpressError(f"period is {length:g} s, but the motion takes {time[-1]:g} s: give its period, or leave period out")
    per_degree = length / TURN if length else 0.0
    value, first, second = (scale * per_degree**order * np.array(column) for order, column in enumerate(columns))

    def back(gained: float) -> float:
        return whole * round(gained / whole) if whole else 0.0

    if left > SAME * length:  # the first state comes again, whole turns later
        gained = back(value[-1] + first[-1] * left / per_degree - value[0])
        value, first, second = np.append(value, value[0] + gained), np.append(first, first[0]), np.append(second, second[0])
        time = np.append(time, length)
    gained = back(value[-1] - value[0])
    missed = abs(value[-1] - value[0] - gained) / max(float(np.ptp(value)), math.ulp(0.0))
    closed = missed <= SEAM and abs(first[-1] - first[0]) <= SEAM * max(float(np.abs(first).max()), math.ulp(0.0))
    if closed:
        value[-1] = value[0] + gained
    return state_curve(TURN * time / length if length else time, value, first, second), length, bool(closed)


def _fewest(curve: StateCurve, closed: bool, layout: _Layout, within: float, unit: str) -> tuple[_Points, float, float]:
    """The points of the table with the fewest steps that keeps the tolerance, by bisection; its largest error, and where it is."""

    def table(steps: int) -> tuple[_Points, float, float]:
        exact = points_of(curve, steps, closed)
        points = _Points(*(np.round(each, DECIMALS) + 0.0 for each in exact))  # as they are written, without a minus before 0
        return points, *largest_error(curve, points, layout.interpolation, closed)

    few, enough = layout.fewest - 1, layout.fewest
    best = table(enough)
    while best[1] > within:
        if enough == MOST_STEPS:
            raise PinpressError(
                f"{MOST_STEPS} steps with {layout.interpolation} interpolation have an error of {best[1]:.3g} {unit}, more than"
                f" {within:.3g} {unit}: give a larger tolerance, or layout='xyva', whose polynomials need fewer points"
            )
        few, enough = enough, min(2 * enough, MOST_STEPS)
        best = table(enough)
    while enough - few > 1:
        middle = (few + enough) // 2
        tried = table(middle)
        few, enough, best = (few, middle, tried) if tried[1] <= within else (middle, enough, best)
    return best


def points_of(curve: StateCurve, steps: int, closed: bool) -> _Points:
    """The points of a table with this number of steps a turn; between corners the steps are equal, and none is longer."""
    ends = np.array([curve.starts[0], *curve.corners, curve.ends[-1]])
    counts = np.ceil(np.diff(ends) * steps / TURN * (1 - SAME)).astype(int)
    parts = [np.linspace(low, high, count + 1)[:-1] for low, high, count in zip(ends[:-1], ends[1:], counts, strict=True)]
    master = np.append(np.concatenate(parts), ends[-1])
    value, first, second = curve.at(master)
    second = 0.5 * (second + curve.at(master, before=True)[2])
    if closed:
        second[[0, -1]] = second[[0, -1]].mean()
        first[-1] = first[0]
    return _Points(master, value, first, second)


def largest_error(curve: StateCurve, points: _Points, interpolation: str, closed: bool) -> tuple[float, float]:
    """Largest distance of a table's curve from the motion, and where on the master axis [deg]."""
    master, value, first, second = points
    h = np.diff(master)
    share = np.linspace(0.0, 1.0, SAMPLES + 1)[:, None]
    places = np.minimum(master[:-1] + share * h, curve.ends[-1])
    if interpolation == "linear":
        drawn = value[:-1] + share * np.diff(value)
    elif interpolation == "quintic":
        drawn = np.polynomial.polynomial.polyval(share * h, quintics(h, value, first, second), tensor=False)
    else:
        from scipy.interpolate import CubicSpline  # to save start-up time

        trend = (value[-1] - value[0]) / (master[-1] - master[0]) * (master - master[0])
        even = np.append((value - trend)[:-1], value[0]) if closed else value
        spline = CubicSpline(master, even, bc_type="periodic" if closed else "not-a-knot")
        drawn = spline(places) + (np.interp(places, master, trend) if closed else 0.0)
    off = np.abs(drawn - curve.at(places.ravel())[0].reshape(places.shape))
    worst = np.unravel_index(int(off.argmax()), off.shape)
    return float(off[worst]), float(places[worst])
