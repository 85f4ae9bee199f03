"""A servo motor and its gear, described by the numbers of a catalogue."""

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

    All quantities refer to the motor's shaft, except ``gear_inertia``. The motor turns ``ratio`` times as fast as the crank. At the crank
    the motor's torque counts ``ratio`` times, and its inertia ``ratio``² times. The limits are the same for driving and braking. The gear
    has no losses. Describe the losses of a real gear by its drag ``viscous``, or by friction of bearings.

    Attributes:
        inertia: inertia of the rotor, with the brake and the pinion on its shaft [kg m2].
        ratio: speed of the motor / speed of the crank [-].
        peak_torque: largest torque of the motor [N m]; None: no limit.
        rated_torque: permanent torque of the motor (duty S1), a limit of the rms torque only with `RmsTorque` [N m]; None: not known.
        top_speed: highest speed of the motor [rad/s]; None: no limit.
        curve_speed: rising speeds of the motor from 0 to the highest, the points of ``curve_torque`` [rad/s]; None: no curve.
        curve_torque: largest torques at these speeds, linear between them, never rising [N m]; None: ``peak_torque`` at all speeds. If
            ``peak_torque`` or ``top_speed`` is None, it follows from the curve.
        power: largest mechanical power of the motor, in driving and in braking [W]; None: no limit.
        copper: heat in the windings / torque², R / kt² [W/(N m)²].
        iron: loss in the iron / speed², an electrical power without a drag torque [W s2/rad2].
        viscous: drag torque on the motor's shaft / speed of the shaft [N m s/rad].
        regeneration: share of the energy given back in braking that is used again, 0 to 1 [-].
        gear_inertia: inertia at the crank of gears and other parts that turn with it and are not in the press's file [kg m2].

    Raises:
        PinpressError: a number is not as described, or both inertias are 0.
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
                "ServoDrive: inertia is 0, so the speed could jump: give the inertia of the rotor at the motor's shaft [kg m2]"
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
                "ServoDrive: the curve is not valid: give two or more speeds in curve_speed, rising from 0 [rad/s], and torques in"
                " curve_torque that do not rise [N m]"
            )
        set_field(self, "curve_speed", tuple(speed.tolist()))
        set_field(self, "curve_torque", tuple(torque.tolist()))
        set_field(self, "peak_torque", float(torque[0]) if self.peak_torque is None else self.peak_torque)
        set_field(self, "top_speed", float(speed[-1]) if self.top_speed is None else self.top_speed)
        if self.top_speed is not None and self.top_speed > speed[-1]:
            raise PinpressError(
                f"ServoDrive: top_speed is {self.top_speed:g} rad/s, above the last of curve_speed, {speed[-1]:g}: extend the curve to"
                " top_speed"
            )

    @property
    def crank_inertia(self) -> float:
        """Inertia of motor and gears at the crank, ratio² inertia + gear_inertia [kg m2]."""
        return self.ratio**2 * self.inertia + self.gear_inertia

    def peak_torque_at(self, speed: float | Array) -> Array:
        """Largest torque of the motor [N m] at speeds of the motor [rad/s]; infinite without a limit.

        The speeds may have any shape and sign.
        """
        size = np.abs(speed)
        most = np.full(np.shape(size), np.inf if self.peak_torque is None else self.peak_torque)
        if self.curve_speed is None or self.curve_torque is None:
            return most
        return np.asarray(np.minimum(most, np.interp(size, self.curve_speed, self.curve_torque)))

    @property
    def crank_drag(self) -> float:
        """Drag torque at the crank / speed of the crank, ratio² viscous [N m s/rad]."""
        return self.ratio**2 * self.viscous
