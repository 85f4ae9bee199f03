"""A servo motor and its gear, by the numbers of a catalogue."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..common import plausibility
from ..common.errors import PinpressError
from ..common.parameters import Checked, parameter, set_field
from ..common.quantities import Array


@dataclass(frozen=True)
class ServoDrive(Checked):
    """A servo motor that drives the crank through a gear.

    All quantities are those of the motor's own shaft, but ``gear_inertia``. The motor turns ``ratio`` times as fast as the crank, so that
    its torque counts ``ratio`` times at the crank and its inertia ``ratio``² times. It gives and brakes alike. The gear loses nothing; a
    gear that does is described by its drag, ``viscous``, or by friction of bearings.

    Attributes:
        inertia: of the rotor, with the brake and the pinion on its shaft [kg m2].
        ratio: speed of the motor by speed of the crank.
        peak_torque: largest torque of the motor [N m]; None: no limit.
        rated_torque: permanent torque of the motor, which the root mean square must not exceed (S1) [N m]; None: not known. It limits a
            motion only where that is asked for.
        top_speed: highest speed of the motor [rad/s]; None: no limit.
        curve_speed: rising speeds of the motor from 0 to the highest, at which ``curve_torque`` is given [rad/s]; None: no curve.
        curve_torque: largest torque at these speeds, straight between them, never rising: voltage and field weakening leave less of it at
            high speeds [N m]; None: ``peak_torque`` at all speeds. Without these, ``peak_torque`` and ``top_speed`` are those of the curve.
        power: largest mechanical power of the motor, in driving and in braking [W]; None: no limit.
        copper: heat in the windings by the torque's square, R / kt² [W/(N m)²].
        iron: loss in the iron by the speed's square, drawn as power and not as torque [W s2/rad2].
        viscous: drag torque on the shaft by its speed [N m s/rad].
        regeneration: share of the energy given back in braking that is used again, 0 to 1.
        gear_inertia: of gears and all else that turns with the crank and is not in the press's file, at the crank [kg m2].

    Raises:
        PinpressError: a number is not as described, or nothing has inertia.
    """

    inertia: float = field(metadata=parameter("kg m2", "not negative"))
    ratio: float = field(default=1.0, metadata=parameter("-", "positive"))
    peak_torque: float | None = field(default=None, metadata=parameter("N m", "positive"))
    rated_torque: float | None = field(default=None, metadata=parameter("N m", "positive"))
    top_speed: float | None = field(default=None, metadata=parameter("rad/s", "positive"))
    power: float | None = field(default=None, metadata=parameter("W", "positive"))
    copper: float = field(default=0.0, metadata=parameter("W/(N m)2", "not negative"))
    iron: float = field(default=0.0, metadata=parameter("W s2/rad2", "not negative"))
    viscous: float = field(default=0.0, metadata=parameter("N m s/rad", "not negative"))
    regeneration: float = field(default=1.0, metadata=parameter("-", "not negative"))
    gear_inertia: float = field(default=0.0, metadata=parameter("kg m2", "not negative"))
    curve_speed: Sequence[float] | None = field(default=None, metadata=parameter("rad/s", "not negative", axes=1))
    curve_torque: Sequence[float] | None = field(default=None, metadata=parameter("N m", "positive", axes=1))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.regeneration > 1:
            raise PinpressError(f"ServoDrive: regeneration is {self.regeneration:g}; give a share from 0 to 1")
        if not self.inertia + self.gear_inertia > 0:
            raise PinpressError(
                "ServoDrive: inertia is 0; give the rotor's, at the motor's shaft [kg m2]: without it the speed could change at once"
            )
        if self.curve_speed is not None or self.curve_torque is not None:
            self._check_curve()
        if self.peak_torque is not None and self.top_speed is not None:
            plausibility.motor("ServoDrive", self.peak_torque, self.top_speed, self.inertia, "peak_torque in N m")

    def _check_curve(self) -> None:
        if self.curve_speed is None or self.curve_torque is None or len(self.curve_speed) != len(self.curve_torque):
            raise PinpressError("ServoDrive: give curve_speed and curve_torque, one torque for each speed")
        speed, torque = np.asarray(self.curve_speed), np.asarray(self.curve_torque)
        if len(speed) < 2 or speed[0] != 0 or not np.all(np.diff(speed) > 0) or not np.all(np.diff(torque) <= 0):
            raise PinpressError(
                "ServoDrive: give two or more speeds in curve_speed that rise from 0 to the highest [rad/s], and in curve_torque torques"
                " that do not rise [N m]"
            )
        set_field(self, "curve_speed", tuple(speed.tolist()))
        set_field(self, "curve_torque", tuple(torque.tolist()))
        set_field(self, "peak_torque", float(torque[0]) if self.peak_torque is None else self.peak_torque)
        set_field(self, "top_speed", float(speed[-1]) if self.top_speed is None else self.top_speed)
        if self.top_speed is not None and self.top_speed > speed[-1]:
            raise PinpressError(
                f"ServoDrive: top_speed is {self.top_speed:g} rad/s, above the last of curve_speed, {speed[-1]:g}: carry the curve on to it"
            )

    @property
    def crank_inertia(self) -> float:
        """Inertia of motor and gears at the crank, ratio² inertia + gear_inertia [kg m2]."""
        return self.ratio**2 * self.inertia + self.gear_inertia

    def peak_torque_at(self, speed: float | Array) -> Array:
        """Largest torque of the motor at its speeds of any shape [rad/s], both ways; infinite where nothing limits it [N m]."""
        size = np.abs(speed)
        most = np.full(np.shape(size), np.inf if self.peak_torque is None else self.peak_torque)
        if self.curve_speed is None or self.curve_torque is None:
            return most
        return np.asarray(np.minimum(most, np.interp(size, self.curve_speed, self.curve_torque)))

    @property
    def crank_drag(self) -> float:
        """Drag torque at the crank by the crank's speed, ratio² viscous [N m s/rad]."""
        return self.ratio**2 * self.viscous
