"""A servo motor and its gear, by the numbers of a catalogue."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..common.errors import PinpressError
from ..common.parameters import Checked, parameter


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

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.regeneration > 1:
            raise PinpressError(f"ServoDrive: regeneration is {self.regeneration:g}; give a share from 0 to 1")
        if not self.inertia + self.gear_inertia > 0:
            raise PinpressError(
                "ServoDrive: inertia is 0; give the rotor's, at the motor's shaft [kg m2]: without it the speed could change at once"
            )

    @property
    def crank_inertia(self) -> float:
        """Inertia of motor and gears at the crank, ratio² inertia + gear_inertia [kg m2]."""
        return self.ratio**2 * self.inertia + self.gear_inertia

    @property
    def crank_drag(self) -> float:
        """Drag torque at the crank by the crank's speed, ratio² viscous [N m s/rad]."""
        return self.ratio**2 * self.viscous
