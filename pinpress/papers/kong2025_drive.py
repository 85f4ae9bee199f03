"""Kong 2025: the motor on its inverter, and the ratio of belt and gear stage that its speeds and the press's strokes a minute leave.

The paper prints the ranges of both, but no ratio, no diameters and no teeth. Losses are left out: the torque on the crank is ratio x that
of the motor.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from ..common.quantities import RPM, Values
from ..drives.motors import InverterMotor
from .pages import BEYOND, REPRODUCED, PageEntry, Panel, Row, draw

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
        Row("highest by lowest motor speed", "", MOTOR_SPEED[1] / MOTOR_SPEED[0], places=3),
        Row("most by fewest strokes/min", "", fast / slow, places=3),
        Row("least ratio that serves, 724.9 r/min at 50 strokes/min", "", least, places=3),
        Row("largest ratio that serves, 1450 r/min at 70 strokes/min", "", largest, places=3),
        Row("ratio from which 70 strokes/min need a weakened field, 1485 r/min", "", 1485 / fast, places=3),
        *(
            Row(
                f"gear stage behind a belt of {belt:g}: ratios that serve, and the largest with {PINION} teeth on its pinion",
                "",
                _pair(belt),
            )
            for belt in BELTS
        ),
    ]
    for words, ratio in (("least", least), ("largest", largest)):
        rows += [
            Row(f"{words} ratio: strokes/min at 724.9 and 1450 r/min", "", " to ".join(f"{speed / ratio:.1f}" for speed in MOTOR_SPEED)),
            Row(f"{words} ratio: motor speed at 50 and 70 strokes/min [r/min]", "", " to ".join(f"{ratio * each:.0f}" for each in STROKES)),
            Row(f"{words} ratio: frequency there [Hz]", "", " to ".join(f"{float(frequency_at(ratio * each)):.1f}" for each in STROKES)),
            Row(f"{words} ratio: permanent torque on the crank from 50 to 70 [N m]", "", float(crank_torque(ratio, fast)), places=0),
            Row(f"{words} ratio: its work in a turn of the crank [kJ]", "", float(2e-3 * np.pi * crank_torque(ratio, fast)), places=1),
            Row(
                f"{words} ratio: permanent power there [kW]",
                "",
                " and ".join(f"{1e-3 * float(crank_torque(ratio, each)) * each * RPM:.1f}" for each in STROKES),
            ),
        ]
    rows.append(Row(f"ratio {WEAKENED:g}: field weakened from [strokes/min]", "", 1485 / WEAKENED, places=1))
    rows.append(
        Row(f"ratio {WEAKENED:g}: permanent torque on the crank at 70 strokes/min [N m]", "", float(crank_torque(WEAKENED, fast)), places=0)
    )

    def shown() -> "Figure":
        strokes = np.linspace(30.0, 80.0, 501)
        curves = {f"ratio {ratio:.1f}": (strokes, np.asarray(crank_torque(ratio, strokes)) / 1e3) for ratio in (least, largest, WEAKENED)}
        return draw("strokes/min", [Panel("torque [kN m]", curves)], 5.5)

    reason = (
        "The paper names a belt and one gear stage, and no ratio. The motor's printed range is 2.0 to 1, the press's 1.4 to 1: no one ratio"
        " brings both ends together, but every ratio between the least and the largest below keeps the motor in its range from 50 to 70"
        " strokes/min. With none of them the field is weakened, so that the permanent torque is the same over the range and the power"
        " rises with the strokes. The largest ratio gives most torque and most power: it is the one to choose, and the lower end of the"
        " motor's range, 724.9 r/min, is then 35 strokes/min. Above a ratio of 21.2 the motor gains nothing at 70 strokes/min: what the"
        " ratio adds to the torque the field takes away. Each of these permanent torques is far below the peaks of table 2, which the"
        " flywheel covers."
    )
    caption = "Permanent torque on the crank, without losses; the ratio of 25 is ours, to show field weakening."
    return PageEntry(
        ("Gearing",), "ratios between motor and crank that serve", BEYOND, tuple(rows), reason, "kong2025_gearing", shown, caption
    )


def _pair(belt: float) -> str:
    """Ratios of the gear stage behind a belt, and a pair of wheels just below the largest."""
    least, largest = (ratio / belt for ratio in serving_ratios())
    wheel = math.floor(PINION * largest)
    return f"{least:.3f} to {largest:.3f}; {wheel}:{PINION} makes {belt * wheel / PINION:.3f}"
