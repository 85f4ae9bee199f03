"""Rubber pads under the feet of a machine: stiffness from size and hardness.

Rubber hardly changes its volume, so that a flat pad between two plates is far stiffer in compression than in shear. With the shape factor
S = loaded area / area free to bulge, and small strains (Gent and Lindley 1959; Lindley, Engineering Design with Natural Rubber):

    E_c = 3 G (1 + 2 S^2), softened by the bulk modulus B: 1 / E = 1 / E_c + 1 / B
    k_z = E A / t,  k_x = k_y = G A / t

The hardness gives the shear modulus by Gent's formula (Gent 1958), 3 G = 0.0981 (56 + 7.62336 H) / (0.137505 (254 - 2.54 H)) MPa.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..common.errors import PinpressError
from ..common.scenario_numbers import check

HARDEST, SOFTEST = 80.0, 20.0  # Shore A for which Gent's formula holds


@dataclass(frozen=True)
class RubberPad:
    """A rectangular pad of rubber, bonded or held by friction between two plates.

    Attributes:
        length, width, thickness: unloaded [m].
        hardness: Shore A, 20 to 80; or instead shear_modulus: static [Pa]. One of the two.
        loss_factor: loss by storage modulus [-], 0.05 (natural rubber) to 0.3 (damped compounds).
        stiffening: dynamic by static stiffness [-], 1 or more: 1.1 (soft natural rubber) to 2 and more (hard, filled).
        bulk_modulus: [Pa].
    """

    length: float
    width: float
    thickness: float
    hardness: float | None = None
    shear_modulus: float | None = None
    loss_factor: float = 0.0
    stiffening: float = 1.0
    bulk_modulus: float = 2e9

    def __post_init__(self) -> None:
        for field, unit in (("length", "m"), ("width", "m"), ("thickness", "m"), ("stiffening", "-"), ("bulk_modulus", "Pa")):
            check(self, field, "positive", unit)
        check(self, "loss_factor", "not negative", "-")
        if (self.hardness is None) == (self.shear_modulus is None):
            raise PinpressError("RubberPad: give either hardness= (Shore A) or shear_modulus= [Pa], one of the two")
        if self.shear_modulus is not None:
            check(self, "shear_modulus", "positive", "Pa")
        else:
            check(self, "hardness", "positive", "Shore A")
            if self.hardness is not None and not SOFTEST <= self.hardness <= HARDEST:
                raise PinpressError(
                    f"RubberPad: hardness is {self.hardness:g}; give {SOFTEST:g} to {HARDEST:g} Shore A, for which Gent's formula holds,"
                    " or shear_modulus="
                )
        if self.stiffening < 1.0:
            raise PinpressError(f"RubberPad: stiffening is {self.stiffening:g}; rubber is stiffer when it moves: give 1 or more")

    @property
    def area(self) -> float:
        """Loaded area [m2]."""
        return self.length * self.width

    @property
    def shape_factor(self) -> float:
        """S, loaded area by area that is free to bulge [-]."""
        return self.area / (2 * self.thickness * (self.length + self.width))

    @property
    def modulus_of_shear(self) -> float:
        """G, static: as given, or from the hardness [Pa]."""
        if self.shear_modulus is not None:
            return self.shear_modulus
        hardness = self.hardness or math.nan  # one of the two is given
        return 0.0981e6 * (56 + 7.62336 * hardness) / (0.137505 * (254 - 2.54 * hardness)) / 3

    @property
    def compression_modulus(self) -> float:
        """E, static, the bulk modulus allowed for [Pa]."""
        return 1 / (1 / (3 * self.modulus_of_shear * (1 + 2 * self.shape_factor**2)) + 1 / self.bulk_modulus)

    @property
    def static_stiffness(self) -> tuple[float, float, float]:
        """Along x, y (shear) and z (compression) [N/m]."""
        shear = self.modulus_of_shear * self.area / self.thickness
        return shear, shear, self.compression_modulus * self.area / self.thickness

    @property
    def stiffness(self) -> tuple[float, float, float]:
        """The same, of vibrations: the static one times ``stiffening`` [N/m]."""
        x, y, z = self.static_stiffness
        return x * self.stiffening, y * self.stiffening, z * self.stiffening
