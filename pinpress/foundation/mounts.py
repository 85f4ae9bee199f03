"""Rubber pads below a frame, and the mounts that they make.

`RubberPad` finds the stiffness of a pad from its size and hardness. Rubber is nearly incompressible, so a flat pad between two plates is
far stiffer in compression than in shear. The shape factor is S = loaded area / area free to bulge; for small strains (Gent and Lindley
1959; Lindley, Engineering Design with Natural Rubber):

    E_c = 3 G (1 + 2 S^2), and with the bulk modulus B: 1 / E = 1 / E_c + 1 / B
    k_z = E A / t,  k_x = k_y = G A / t

The hardness gives the shear modulus by Gent's formula (Gent 1958), 3 G = 0.0981 (56 + 7.62336 H) / (0.137505 (254 - 2.54 H)) MPa.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from ..common import plausibility
from ..common.arguments import typed
from ..common.errors import PinpressError, shown
from ..common.parameters import Checked, parameter
from ..loads.mounts import Frame as Frame
from ..loads.mounts import Mount as Mount
from ..loads.mounts import Vector

HARDEST, SOFTEST = 80.0, 20.0  # limits between which Gent's formula holds [Shore A]


@dataclass(frozen=True)
class RubberPad(Checked):
    """A rectangular pad of rubber, bonded or held by friction between two plates.

    Attributes:
        length: unloaded length [m].
        width: unloaded width [m].
        thickness: unloaded thickness [m].
        hardness: hardness, 20 to 80 [Shore A]. Give either this or ``shear_modulus``.
        shear_modulus: static shear modulus [Pa].
        loss_factor: loss modulus divided by storage modulus, from 0.05 (natural rubber) to 0.3 (damped compounds) [-].
        stiffening: dynamic divided by static stiffness, at least 1: from 1.1 (soft natural rubber) to 2 and more (hard, filled) [-].
        bulk_modulus: bulk modulus of the rubber [Pa].

    Raises:
        PinpressError: a number is out of its range, or not exactly one of hardness and shear modulus is given.
    """

    length: float = field(metadata=parameter("m", "positive"))
    width: float = field(metadata=parameter("m", "positive"))
    thickness: float = field(metadata=parameter("m", "positive"))
    hardness: float | None = field(default=None, metadata=parameter("Shore A", "positive"))
    shear_modulus: float | None = field(default=None, metadata=parameter("Pa", "positive"))
    loss_factor: float = field(default=0.0, metadata=parameter("-", "not negative"))
    stiffening: float = field(default=1.0, metadata=parameter("-", "positive"))
    bulk_modulus: float = field(default=2e9, metadata=parameter("Pa", "positive"))

    def __post_init__(self) -> None:
        super().__post_init__()
        plausibility.share("RubberPad: loss_factor", self.loss_factor, plausibility.DAMPED)
        for name in ("length", "width", "thickness"):
            plausibility.cylinder("RubberPad", name, getattr(self, name))
        if (self.hardness is None) == (self.shear_modulus is None):
            raise PinpressError("RubberPad: give either hardness= (Shore A) or shear_modulus= [Pa], one of the two")
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
        """S, the loaded area divided by the area that is free to bulge [-]."""
        return self.area / (2 * self.thickness * (self.length + self.width))

    @property
    def modulus_of_shear(self) -> float:
        """Static shear modulus G, as given or from the hardness [Pa]."""
        if self.shear_modulus is not None:
            return self.shear_modulus
        hardness = self.hardness or math.nan  # one of hardness and shear modulus is always given
        return 0.0981e6 * (56 + 7.62336 * hardness) / (0.137505 * (254 - 2.54 * hardness)) / 3

    @property
    def compression_modulus(self) -> float:
        """Static compression modulus E, which takes the bulk modulus into account [Pa]."""
        return 1 / (1 / (3 * self.modulus_of_shear * (1 + 2 * self.shape_factor**2)) + 1 / self.bulk_modulus)

    @property
    def static_stiffness(self) -> tuple[float, float, float]:
        """(3,) static stiffness along x and y (shear) and z (compression) [N/m]."""
        shear = self.modulus_of_shear * self.area / self.thickness
        return shear, shear, self.compression_modulus * self.area / self.thickness

    @property
    def stiffness(self) -> tuple[float, float, float]:
        """(3,) stiffness for vibrations along x, y and z, static stiffness x ``stiffening`` [N/m]."""
        x, y, z = self.static_stiffness
        return x * self.stiffening, y * self.stiffening, z * self.stiffening


@typed
def pad_mount(point: Vector, pad: RubberPad) -> Mount:
    """Make a mount of a rubber pad that lies flat under the frame.

    Args:
        point: (3,) middle of the pad in world axes [m].
        pad: the pad.

    Raises:
        PinpressError: the point is not three finite numbers, or ``pad`` is not a `RubberPad`.
    """
    if not isinstance(pad, RubberPad):
        raise PinpressError(f"pad is {shown(pad)}: give a RubberPad")
    return Mount(point, pad.stiffness, loss_factor=pad.loss_factor, static_stiffness=pad.static_stiffness, area=pad.area)


def listed_mounts(mounts: object, what: str) -> tuple[Mount, ...]:
    """A caller's mounts as a tuple.

    Raises:
        PinpressError: the list is empty, or an item is not a `Mount`.
    """
    if not isinstance(mounts, Sequence) or not mounts or not all(isinstance(mount, Mount) for mount in mounts):
        raise PinpressError(f"{what} is {shown(mounts)}: give a list of Mount, at least one")
    return tuple(mounts)
