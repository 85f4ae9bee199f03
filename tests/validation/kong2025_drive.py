"""Kong 2025: the motor on its inverter, and the ratio of belt and gear stage that its speeds and the press's strokes a minute leave.

The paper prints the ranges of both, but no ratio, no diameters and no teeth. Losses are left out: the torque on the crank is ratio x that
of the motor.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from pinpress.common.quantities import RPM, Values
from pinpress.drives.motors import InverterMotor
from validation.pages import BEYOND, REPRODUCED, Grid, PageEntry, Panel, Row, draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STROKES = (50.0, 70.0)  # a minute, of the press
MOTOR_SPEED = (724.9, 1450.0)  # of the motor in operation [r/min]
BELTS = (2.0, 2.5, 3.15, 4.0)  # belt ratios that a designer would try (ours)
PINION = 20  # teeth of the pinion in the examples (ours)
WEAKENED = 25.0  # a ratio above all that serve, to show field weakening (ours)


def motor() -> InverterMotor:
    """Fig. 1: the permanent torque of the motor on its inverter, field weakening above 50 Hz."""
    return InverterMotor(rated_torque=482.0, rated_speed=1485 * RPM, frequency=50.0, overload=1.0)


def serving_ratios() -> tuple[float, float]:
    """Least and largest ratio of motor speed to strokes a minute with which the motor keeps its printed range over that of the press."""
    return MOTOR_SPEED[0] / STROKES[0], MOTOR_SPEED[1] / STROKES[1]


def frequency_at(motor_speed: Values) -> Values:
    """Frequency [Hz] at which the motor gives its permanent torque at a speed [r/min].

    The lag behind the synchronous speed, 15 r/min at the rated point, stays below fN; above it grows with f / fN, as the slope of the
    torque falls with (fN / f)^2 and the permanent torque with fN / f.
    """
    rated = motor()
    synchronous = rated.synchronous_speed / RPM
    lag = synchronous - rated.rated_speed / RPM
    return np.where(motor_speed <= synchronous - lag, motor_speed + lag, motor_speed / (1 - lag / synchronous)) / synchronous * 50.0


def crank_torque(ratio: float, strokes: Values) -> Values:
    """Permanent torque on the crank [N m] at strokes a minute, without losses."""
    return ratio * motor().torque_limit(frequency_at(ratio * strokes))


def motor_entry() -> PageEntry:
    """Fig. 1."""
    frequency = np.linspace(5.0, 100.0, 400)
    limit = np.asarray(motor().torque_limit(frequency))

    def shown() -> "Figure":
        return draw("frequency [Hz]", [Panel("torque [N m]", {"": (frequency, limit)}, (482.0,), ((50.0, 482.0),))], 5.5)

    rows = (Row("rated torque [N m], from 75 kW at 1485 r/min", "482", 75e3 / (1485 * RPM), 0.1, 1),)
    reason = "The figure prints the rated point; the curve is constant flux below 50 Hz and constant voltage above it."
    return PageEntry(
        ("Fig. 1",), "torque of the motor over frequency", REPRODUCED, rows, reason, "kong2025_motor", shown, "Cross: rated point."
    )


def gearing_entry() -> PageEntry:
    """Which ratios of belt and gear stage serve, and the torque that they leave on the crank."""
    least, largest = serving_ratios()
    slow, fast = STROKES
    rows = [
        Row("highest motor speed / lowest", "", MOTOR_SPEED[1] / MOTOR_SPEED[0], places=3),
        Row("most strokes/min / fewest", "", fast / slow, places=3),
        Row("least ratio that serves, 724.9 r/min at 50 strokes/min", "", least, places=3),
        Row("largest ratio that serves, 1450 r/min at 70 strokes/min", "", largest, places=3),
        Row("ratio from which 70 strokes/min need a weakened field, 1485 r/min", "", 1485 / fast, places=3),
    ]
    by_ratio = Grid(
        (
            "ratio",
            "strokes/min at 724.9 and 1450 r/min",
            "motor at 50 and 70 strokes/min [r/min]",
            "frequency there [Hz]",
            "permanent torque on the crank there [N m]",
            "its work in a turn [kJ]",
            "its power [kW]",
        ),
        tuple(_of_ratio(ratio) for ratio in (least, largest, WEAKENED)),
    )
    by_belt = Grid(
        ("belt", "gear stages that serve", f"largest with {PINION} teeth on the pinion", "ratio of both"),
        tuple(_of_belt(belt) for belt in BELTS),
    )

    def shown() -> "Figure":
        strokes = np.linspace(30.0, 80.0, 501)
        curves = {f"ratio {ratio:.1f}": (strokes, np.asarray(crank_torque(ratio, strokes)) / 1e3) for ratio in (least, largest, WEAKENED)}
        return draw("strokes/min", [Panel("torque [kN m]", curves)], 5.5)

    reason = (
        "The paper names a belt and one gear stage, but no ratio. Every ratio between the least and the largest below keeps the motor"
        " in its printed range from 50 to 70 strokes/min. The largest gives the most torque and power; 724.9 r/min are then 35"
        " strokes/min. Above 21.2 the weakened field takes away at 70 strokes/min what the ratio adds. The peaks of table 2 are the"
        " flywheel's."
    )
    caption = "Permanent torque on the crank, without losses; the ratio of 25 is ours, to show field weakening."
    grids = (by_ratio, by_belt)
    return PageEntry(
        ("Gearing",), "ratios between motor and crank that serve", BEYOND, tuple(rows), reason, "kong2025_gearing", shown, caption, grids
    )


def _of_ratio(ratio: float) -> tuple[str, ...]:
    torque = [float(crank_torque(ratio, each)) for each in STROKES]
    return (
        f"{ratio:.3f}",
        " to ".join(f"{speed / ratio:.1f}" for speed in MOTOR_SPEED),
        " to ".join(f"{ratio * each:.0f}" for each in STROKES),
        " to ".join(f"{float(frequency_at(ratio * each)):.1f}" for each in STROKES),
        " to ".join(f"{each:.0f}" for each in torque),
        " to ".join(f"{2e-3 * math.pi * each:.1f}" for each in torque),
        " to ".join(f"{1e-3 * each * speed * RPM:.1f}" for each, speed in zip(torque, STROKES, strict=True)),
    )


def _of_belt(belt: float) -> tuple[str, ...]:
    """Ratios of the gear stage behind a belt, and a pair of wheels just below the largest."""
    least, largest = (ratio / belt for ratio in serving_ratios())
    wheel = math.floor(PINION * largest)
    return f"{belt:g}", f"{least:.3f} to {largest:.3f}", f"{wheel} : {PINION}", f"{belt * wheel / PINION:.3f}"
