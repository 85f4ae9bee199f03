"""Oil that the slide presses through an orifice or past a valve: impact dampers against break-through, and hydraulic die cushions.

Through a sharp orifice of the area a oil of the density rho flows with the pressure drop rho/2 (A v / (C a))^2, where A is the area of the
piston, v its speed and C the discharge coefficient: the force on the piston is A times that (orifice equation, Bernoulli). Signs, heights
and datum are those of `process`.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import positive
from ..common.errors import PinpressError
from ..common.frozen import read_only
from ..common.parameters import Checked, parameter, set_field
from ..common.quantities import Values
from .process import ForceInterval, constant_law


@dataclass(frozen=True, eq=False)
class ImpactDamper(Checked):
    """Impact dampers between slide and bolster: what the slide presses down while it is fast, as it is after break-through.

    Below the highest height the slide is on their pistons. Downwards the force is c(h) |v|^e, with c linear between the heights; upwards a
    check valve lets the pistons go, and there is no force. Zhang 2007, 5.7.6 (2), names them against the shock of blanking.

    Attributes:
        heights: (n,) of the slide [m], at least two, strictly rising or falling; kept rising. Below the lowest there is no force.
        coefficients: (n,) c at the heights, of all dampers together [N s^e/m^e]; not negative. See `orifice_coefficient`.
        exponent: e, 2 of a sharp orifice, 1 of a long narrow gap; from 1 to 3 [-].
        datum: slide position from which heights count [m]; None: that of bottom dead centre.

    Raises:
        PinpressError: a number is not as declared, heights and coefficients do not go together, or the exponent is not from 1 to 3.
    """

    heights: ArrayLike = field(metadata=parameter("m", axes=1))
    coefficients: ArrayLike = field(metadata=parameter("N s^e/m^e", "not negative", axes=1, scenarios=True))
    exponent: float = field(default=2.0, metadata=parameter("-"))
    datum: float | None = field(default=None, metadata=parameter("m"))

    def __post_init__(self) -> None:
        super().__post_init__()
        heights, coefficients = np.asarray(self.heights), np.asarray(self.coefficients)
        if len(heights) < 2 or len(coefficients) != len(heights):
            raise PinpressError(
                f"ImpactDamper: {len(heights)} heights and {len(coefficients)} coefficients; give two or more, a coefficient at each height"
            )
        if heights[0] > heights[-1]:
            heights, coefficients = heights[::-1], coefficients[::-1]
        with np.errstate(all="ignore"):
            slopes = np.diff(coefficients, axis=0).T / np.diff(heights)
        if not (np.diff(heights) > 0).all() or not np.isfinite(slopes).all():
            raise PinpressError("ImpactDamper: heights neither rises nor falls throughout, or two are too close; sort them, each once")
        if not 1.0 <= self.exponent <= 3.0:
            raise PinpressError(f"ImpactDamper: exponent is {self.exponent:g}; give 1 (a gap) to 2 (an orifice), at most 3")
        set_field(self, "heights", read_only(heights))
        set_field(self, "coefficients", read_only(coefficients))

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        return self._both_ways

    @cached_property
    def _both_ways(self) -> tuple[ForceInterval, ...]:
        values = np.asarray(self.coefficients)
        points = list(zip(np.asarray(self.heights).tolist(), list(values) if values.ndim == 2 else values.tolist(), strict=True))
        return tuple(
            ForceInterval(upper, lower, partial(_orifice, low, (high - low) / (upper - lower), lower, self.exponent), one_sided=True)
            for (lower, low), (upper, high) in itertools.pairwise(points)
        )


@dataclass(frozen=True, eq=False)
class HydraulicCushion(Checked):
    """A die cushion whose oil leaves through a relief valve: a constant force below a height on the way down, another on the way up.

    On the way down the force rises from zero over the travel in which the oil is compressed until the valve opens.

    Attributes:
        force: at the open valve [N], or (S,) for S scenarios; not negative.
        height: of the slide, where it meets the cushion [m].
        rise: travel over which the force rises [m]; 0: at once.
        return_force: with which the cushion follows the slide up to that height [N], or (S,); 0 where it is locked below.
        datum: slide position from which heights count [m]; None: that of bottom dead centre.

    Raises:
        PinpressError: a number is not as declared.
    """

    force: Values = field(metadata=parameter("N", "not negative", scenarios=True))
    height: float = field(metadata=parameter("m"))
    rise: float = field(default=0.0, metadata=parameter("m", "not negative"))
    return_force: Values = field(default=0.0, metadata=parameter("N", "not negative", scenarios=True))
    datum: float | None = field(default=None, metadata=parameter("m"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rise and not math.isfinite(1.0 / self.rise):
            raise PinpressError(f"HydraulicCushion: rise is {self.rise:g}; give 0, or a longer travel [m]")

    def intervals(self, downwards: bool) -> tuple[ForceInterval, ...]:
        if not downwards:
            law = constant_law(self.return_force)
            return (ForceInterval(self.height, -math.inf, law, heeds_velocity=False),) if np.any(self.return_force) else ()
        full = ForceInterval(self.height - self.rise, -math.inf, constant_law(self.force), heeds_velocity=False)
        if not self.rise:
            return (full,)
        law = partial(_ramp, np.asarray(self.force) / self.rise if np.ndim(self.force) else self.force / self.rise, self.height)
        return ForceInterval(self.height, self.height - self.rise, law, heeds_velocity=False), full


def orifice_coefficient(piston: float, orifice: float, *, density: float = 870.0, discharge: float = 0.62) -> float:
    """Coefficient c of an `ImpactDamper` with a sharp orifice: its force is c v^2, c = rho A^3 / (2 (C a)^2) [N s2/m2].

    Args:
        piston: diameter of the piston [m].
        orifice: diameter of the orifice [m], below that of the piston.
        density: rho, of the oil [kg/m3].
        discharge: discharge coefficient C of the orifice, at most 1 [-].

    Raises:
        PinpressError: an argument is not positive, the orifice not smaller than the piston, or the discharge coefficient above 1.

    Warns:
        PinpressWarning: the piston is wider than 3 m: diameters may be in mm.
    """
    diameter, hole = positive("piston", piston, "m"), positive("orifice", orifice, "m")
    rho, share = positive("density", density, "kg/m3"), positive("discharge", discharge, "-")
    if not hole < diameter:
        raise PinpressError(f"orifice is {hole:g} m, not smaller than the piston, {diameter:g} m: give both diameters in m")
    plausibility.cylinder("orifice_coefficient", "piston", diameter)
    if share > 1:
        raise PinpressError(f"discharge is {share:g}: give the discharge coefficient, about 0.6 of a sharp edge, at most 1")
    area, throat = (0.25 * math.pi * size**2 for size in (diameter, hole))
    return rho * area**3 / (2 * (share * throat) ** 2)


# Module functions that `partial` binds, not closures: loads can then be sent to other processes.


def _orifice(low: Any, slope: Any, lower: float, exponent: float, height: Any, velocity: Any) -> Any:
    """c |v|^e against the velocity; upwards it would pull, and the contact is lost."""
    coefficient = low + slope * (height - lower)
    if exponent == 1.0:
        return -coefficient * velocity
    if isinstance(velocity, float):
        return coefficient * math.copysign(abs(velocity) ** exponent, -velocity)
    sign = np.where(np.real(velocity) <= 0, 1.0, -1.0)
    return coefficient * sign * (-sign * velocity) ** exponent


def _ramp(rate: Any, height: float, at: Any, velocity: Any) -> Any:
    return rate * (height - at)
