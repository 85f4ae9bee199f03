"""Air that the slide compresses: the balance cylinder that carries its weight, and the cushion under the die.

The air of all cylinders, pipes and tank changes its state together, by p V^n = constant: n = 1 where it keeps the temperature of its walls
(isothermal, slow), 1.4 where it exchanges no heat with them (adiabatic, a high-speed press). The force on the slide is the gauge pressure
times the area of the pistons; the air around presses on their other sides. Without heat and throttles no work is lost over a turn.

Pressures are gauge pressures [Pa]: 6 bar are 6e5 Pa. Signs, heights and datum are those of `process`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import is_whole_number, numbers
from ..common.errors import PinpressError, shown
from ..common.parameters import Checked, parameter
from ..common.quantities import ATMOSPHERE, Array, Values
from .caller_laws import LawError
from .process import ForceInterval


@dataclass(frozen=True, eq=False)
class BalanceCylinder(Checked):
    """Balance cylinders: compressed air from a tank carries the slide over its whole stroke.

    The force lifts the slide: N A ((p + p0) (V / (V + N A (h - height)))^n - p0), with the N pistons' area A and the pressure p0 of the
    air around. Zhang 2007, 2.1 (4), names these cylinders, and leaves them out of its models.

    Attributes:
        bore: of each cylinder [m].
        pressure: gauge pressure with the slide at ``height`` [Pa], or (S,) for S scenarios.
        volume: of the air in all cylinders, pipes and tank with the slide at ``height`` [m3], or (S,).
        rod: diameter of the piston rod, where it goes through the pressed side [m].
        count: number of cylinders.
        exponent: n, from 1 (isothermal) to 1.4 (adiabatic, air) [-].
        height: at which pressure and volume are given [m]; 0: bottom dead centre, where the air is compressed most.
        atmosphere: pressure around the cylinders [Pa].
        datum: slide position from which heights count [m]; None: that of bottom dead centre.

    Raises:
        PinpressError: a number is not as declared, the rod is as thick as the bore, or the exponent is below 1 or above 5/3.

    Warns:
        PinpressWarning: a pressure may be in bar, a diameter in mm, or a volume in litres.
    """

    bore: float = field(metadata=parameter("m", "positive"))
    pressure: Values = field(metadata=parameter("Pa", "positive", scenarios=True))
    volume: Values = field(metadata=parameter("m3", "positive", scenarios=True))
    rod: float = field(default=0.0, metadata=parameter("m", "not negative"))
    count: int = 1
    exponent: float = field(default=1.4, metadata=parameter("-"))
    height: float = field(default=0.0, metadata=parameter("m"))
    atmosphere: float = field(default=ATMOSPHERE, metadata=parameter("Pa", "not negative"))
    datum: float | None = field(default=None, metadata=parameter("m"))

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_air(self)

    @property
    def area(self) -> float:
        """Area of all pistons on which the pressure acts [m2]."""
        return _area(self)

    def pressure_at(self, heights: ArrayLike) -> Array:
        """Gauge pressure at heights of the slide [Pa]: of the heights' shape, and with S scenarios (..., S).

        Raises:
            PinpressError: a height is no finite number, or the slide has swept all of the volume there.
        """
        return _pressures(self, numbers("BalanceCylinder: heights", heights, unit="m"))

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return self._both_ways

    @cached_property
    def _both_ways(self) -> tuple[ForceInterval, ...]:
        return (ForceInterval(math.inf, -math.inf, _law(self), heeds_velocity=False),)


@dataclass(frozen=True, eq=False)
class PneumaticCushion(Checked):
    """A die cushion on air: below a height the slide presses its pistons down, and they follow it up again to that height.

    At the height, where the pistons rest against their stop, the full pressure meets the slide at once; below it the force is that of
    `BalanceCylinder`, upwards. The mass of pistons and pad is not in it; see `pick_up_force`.

    Attributes:
        bore: of each cylinder [m].
        pressure: gauge pressure with the pistons at their stop [Pa], or (S,) for S scenarios.
        volume: of the air in all cylinders, pipes and tank with the pistons at their stop [m3], or (S,).
        height: of the slide, where it meets the cushion [m].
        rod: diameter of the piston rod, where it goes through the pressed side [m].
        count: number of cylinders.
        exponent: n, from 1 (isothermal) to 1.4 (adiabatic, air) [-].
        atmosphere: pressure around the cylinders [Pa].
        datum: slide position from which heights count [m]; None: that of bottom dead centre.

    Raises and warns as `BalanceCylinder`.
    """

    bore: float = field(metadata=parameter("m", "positive"))
    pressure: Values = field(metadata=parameter("Pa", "positive", scenarios=True))
    volume: Values = field(metadata=parameter("m3", "positive", scenarios=True))
    height: float = field(metadata=parameter("m"))
    rod: float = field(default=0.0, metadata=parameter("m", "not negative"))
    count: int = 1
    exponent: float = field(default=1.4, metadata=parameter("-"))
    atmosphere: float = field(default=ATMOSPHERE, metadata=parameter("Pa", "not negative"))
    datum: float | None = field(default=None, metadata=parameter("m"))

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_air(self)

    @property
    def area(self) -> float:
        """Area of all pistons on which the pressure acts [m2]."""
        return _area(self)

    def pressure_at(self, heights: ArrayLike) -> Array:
        """Gauge pressure as of `BalanceCylinder.pressure_at`; above its height the cushion keeps its pressure there."""
        return _pressures(self, np.minimum(numbers("PneumaticCushion: heights", heights, unit="m"), self.height))

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return self._both_ways

    @cached_property
    def _both_ways(self) -> tuple[ForceInterval, ...]:
        return (ForceInterval(self.height, -math.inf, _law(self), heeds_velocity=False),)


Air = BalanceCylinder | PneumaticCushion


def _check_air(load: Air) -> None:
    name = type(load).__name__
    if not is_whole_number(load.count) or not 1 <= load.count <= 1000:
        raise PinpressError(f"{name}: count is {shown(load.count)}; give the number of cylinders, 1 to 1000")
    if not load.rod < load.bore:
        raise PinpressError(f"{name}: rod is {load.rod:g} m, not thinner than the bore, {load.bore:g} m; give both diameters in m")
    # The largest adiabatic exponent is that of a gas of single atoms.
    if not 1.0 <= load.exponent <= 5 / 3:
        raise PinpressError(f"{name}: exponent is {load.exponent:g}; give 1 (isothermal) to 1.4 (adiabatic, air), at most 5/3")
    if not math.isfinite(_area(load)):
        raise PinpressError(f"{name}: bore is {load.bore:g} m; give that of one cylinder in m")
    plausibility.cylinder(name, "bore", load.bore)
    plausibility.air(name, np.asarray(load.pressure), np.asarray(load.volume))


def _area(load: Air) -> float:
    return 0.25 * math.pi * (load.bore * load.bore - load.rod * load.rod) * load.count


def _law(load: Air) -> Any:
    return partial(_lift, type(load).__name__, _area(load), load.pressure, load.volume, load.exponent, load.height, load.atmosphere)


def _pressures(load: Air, heights: Array) -> Array:
    if np.ndim(load.pressure) or np.ndim(load.volume):
        heights = heights[..., None]
    return np.asarray(_law(load)(heights, 0.0)) / _area(load)


# A module function that `partial` binds, not a closure: loads can then be sent to other processes.
def _lift(
    name: str, area: float, pressure: Any, volume: Any, exponent: float, given_at: float, atmosphere: float, height: Any, velocity: Any
) -> Any:
    left = volume + area * (height - given_at)
    if not (left > 0 if isinstance(left, float) else (np.real(left) > 0).all()):
        lowest = float(np.min(np.real(height)))
        raise LawError(
            f"{name}: at {lowest:g} m above its datum the slide has swept all of its volume; give the volume [m3] of the air in cylinders,"
            f" pipes and tank with the slide at {given_at:g} m, and that height in m"
        )
    return area * ((pressure + atmosphere) * (volume / left) ** exponent - atmosphere)
