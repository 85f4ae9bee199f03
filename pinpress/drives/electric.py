"""What electric motors share: where the power from the mains goes, and how warm it makes them.

A motor's model gives its torque and with it the loss by slip. All other losses are those of its data sheet: a constant part (iron,
bearings, fan) and one that grows with the square of the current. The efficiencies at full and half load tell both: with the losses L1 and
L2 there, 4 (L1 - L2) / 3 grows with the square, slip included, and the rest is constant.

The temperature has one time constant: thermal_time x d(rise)/dt = resistance x heat - rise, in which the thermal resistance [K/W] is the
rise at the rated point by the heat there. That the resistance of the windings grows with their temperature is left out.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..common import plausibility
from ..common.errors import PinpressError, caution, shown
from ..common.parameters import parameter
from ..common.quantities import Values
from .protocol import SpeedTorqueDrive


class MotorPower(NamedTuple):
    """Where the power of a motor goes [W], in the shape of its speed; what is left out is 0.

    Attributes:
        shaft: from the motor into its shaft; negative where it brakes.
        slip: lost by slip: in the bars of the rotor, or as eddy currents in the drum of a slip clutch.
        load: lost in windings and elsewhere with the square of the current, the slip left out, and by excitation.
        constant: lost in iron, bearings and fan, whatever the torque.
        inverter: lost in the inverter.
        resistor: of braking, burnt in the inverter's resistor.
    """

    shaft: Values
    slip: Values = 0.0
    load: Values = 0.0
    constant: Values = 0.0
    inverter: Values = 0.0
    resistor: Values = 0.0

    @property
    def mains(self) -> Values:
        """Power from the mains; negative where braking feeds them."""
        return self.shaft + self.slip + self.load + self.constant + self.inverter + self.resistor

    @property
    def heat(self) -> Values:
        """Power that warms the motor."""
        return self.slip + self.load + self.constant


@dataclass(frozen=True, kw_only=True)
class ElectricMotor(SpeedTorqueDrive):
    """Base of motors on the mains. It must define ``power`` and ``rated_slip_loss``, and overrides what differs.

    Attributes:
        load_loss: losses at the rated point that grow with the square of the current, including losses by slip [W]; None: only the
            losses by slip count, so the power from the mains is a lower bound.
        constant_loss: losses that do not depend on the load [W].
        rated_rise: final temperature rise of the motor at the rated point [K]; None: temperatures are not computed.
        thermal_time: time constant of its temperature [s]; None: not known. Of 1 to 100 s a warning says that it may be in minutes.
    """

    load_loss: float | None = field(default=None, metadata=parameter("W", "not negative"))
    constant_loss: float = field(default=0.0, metadata=parameter("W", "not negative"))
    rated_rise: float | None = field(default=None, metadata=parameter("K", "positive"))
    thermal_time: float | None = field(default=None, metadata=parameter("s", "positive"))

    def power(self, speed: Values, angle: Values = 0.0, time: Values = 0.0, state: tuple[Values, ...] = ()) -> MotorPower:
        """Where the motor's power goes; arguments as for ``torque``."""
        raise NotImplementedError

    @property
    def rated_slip_loss(self) -> Values:
        """Loss by slip at the rated point [W]."""
        raise NotImplementedError

    def __post_init__(self) -> None:
        super().__post_init__()
        check_thermal_time(self, self.thermal_time)
        plausibility.rise(f"{type(self).__name__}: rated_rise", self.rated_rise)

    @property
    def rated_heat(self) -> Values:
        """All losses in the motor at the rated point [W]."""
        return (self.rated_slip_loss if self.load_loss is None else self.load_loss) + self.constant_loss

    @property
    def thermal_resistance(self) -> Values | None:
        """Final temperature rise by heat [K/W]; None if the rise at the rated point is not known."""
        return None if self.rated_rise is None else self.rated_rise / self.rated_heat

    @property
    def _load_by_slip(self) -> Values:
        """Losses with the square of the current, slip left out, by the loss by slip: in an induction motor both are the heat of one current
        in two resistances."""
        return 0.0 if self.load_loss is None else self.load_loss / self.rated_slip_loss - 1.0


def check_thermal_time(motor: object, time: float | None) -> None:
    """Warn of a time constant of a motor's temperature [s] that may be in minutes."""
    if time is not None and 1.0 <= time <= 100.0:  # as minutes these are usual, as seconds too short for any motor
        caution(
            f"{type(motor).__name__}: thermal_time is {time:g} s: if minutes are meant, write {time:g} * 60; the whole motor is looked at,"
            " not its windings alone"
        )


def check_load_loss(motor: ElectricMotor) -> None:
    """Raise PinpressError where the losses with the square of the current are less than those by slip alone."""
    least = motor.rated_slip_loss
    if motor.load_loss is not None and np.any(motor.load_loss < least):
        raise PinpressError(
            f"{type(motor).__name__}: load_loss is {shown(motor.load_loss)}; give at least {float(np.max(least)):.6g} W, the loss by slip"
            " at the rated point, which is part of it"
        )
