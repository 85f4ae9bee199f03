"""What a servo press needs: the smallest motor of a catalogue with its best gear, and the capacitor that evens out its power."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..common.arguments import expect, positive, typed
from ..common.errors import PinpressError
from ..common.results import Record
from .motion import ServoMotion


@dataclass(frozen=True, repr=False)
class EnergyStore(
    Record,
    units={
        "mean_power": "W",
        "peak_power": "W",
        "peak_returned": "W",
        "energy_swing": "J",
        "upper_voltage": "V",
        "lower_voltage": "V",
        "capacitance": "F",
    },
):
    """The capacitor that evens out the power of a servo press, so that the mains give its mean alone.

    Attributes:
        mean_power: mean electrical power of the cycle, what the mains give with the capacitor [W].
        peak_power: largest electrical power, what the mains would give without it [W].
        peak_returned: largest electrical power that braking gives back [W].
        energy_swing: difference between the largest and the smallest energy in the capacitor [J].
        upper_voltage: of the direct-current link when it is full [V].
        lower_voltage: when it is empty [V].
        capacitance: 2 energy_swing / (upper_voltage² - lower_voltage²) [F].
    """

    mean_power: float
    peak_power: float
    peak_returned: float
    energy_swing: float
    upper_voltage: float
    lower_voltage: float
    capacitance: float


@typed
def capacitor(motion: ServoMotion, upper_voltage: float = 750.0, lower_voltage: float = 450.0) -> EnergyStore:
    """The capacitor in the direct-current link that evens out a motion's power: the mains feed its mean, the capacitor the rest.

    The electrical power is the mechanical one with the heat in windings and iron, `ServoMotion.mains_power`. All that braking gives back
    goes into the capacitor. With the losses of converters and a capacitor that ages more is needed.

    Args:
        motion: the motion.
        upper_voltage: of the link when the capacitor is full [V].
        lower_voltage: when it is empty [V].

    Raises:
        PinpressError: the upper voltage is not above the lower one.
    """
    expect("motion", motion, ServoMotion, "servo.evaluate or best_motion")
    upper, lower = positive("upper_voltage", upper_voltage, "V"), positive("lower_voltage", lower_voltage, "V")
    if not upper > lower:
        raise PinpressError(f"upper_voltage is {upper:g} V, not above the lower_voltage of {lower:g} V: exchange them")
    power = motion.mains_power
    mean = float(motion.weight @ power) / motion.duration
    given = np.concatenate([[0.0], np.cumsum(motion.weight * (power - mean))])
    swing = float(np.ptp(given))
    peak, returned = max(float(power.max()), 0.0), max(float(-power.min()), 0.0)
    return EnergyStore(mean, peak, returned, swing, upper, lower, 2 * swing / (upper**2 - lower**2))
