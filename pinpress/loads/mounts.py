"""The rigid frame of a press and the mounts below it, as `foundation` and elastic motion take them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import suitable_numbers
from ..common.errors import PinpressError
from ..common.frozen import Frozen, read_only
from ..common.parameters import in_declared_units, parameter, set_field
from ..common.quantities import Array

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Frame(Frozen):
    """A rigid part of the frame with everything on it that is not in the URDF, such as motor, flywheel, bolster and lower die.

    Leave out the mass of all links in the URDF, its frame link included: it is counted with the press.

    Attributes:
        mass: mass of the part [kg].
        centre: (3,) centre of mass in world axes [m].
        inertia: inertia tensor (3, 3) about the centre of mass in world axes, or its diagonal (3,) [kg m2].

    Raises:
        PinpressError: the mass is negative, no body has this inertia, or a value has another shape or is not finite.
    """

    mass: float = field(metadata=parameter("kg", "not negative"))
    centre: ArrayLike = field(metadata=parameter("m", axes=1))
    inertia: ArrayLike = field(metadata=parameter("kg m2", axes=1))

    def __post_init__(self) -> None:
        in_declared_units(self)
        suitable_numbers("Frame: mass", self.mass, "one finite number that is not negative [kg]", suits=_not_negative)
        suitable_numbers("Frame: centre", self.centre, "x, y, z [m], finite", (3,))
        inertia = self.tensor
        if inertia.shape != (3, 3) or np.abs(inertia - inertia.T).max() > 1e-9 * np.abs(inertia).max(initial=1e-300):
            raise PinpressError("Frame: inertia is no symmetric tensor; give (3, 3), or (3,) along x, y and z [kg m2]")
        least, middle, largest = np.linalg.eigvalsh(inertia)
        if least < -1e-9 * largest or largest > (least + middle) * (1 + 1e-9):
            raise PinpressError("Frame: no body has this inertia: each principal moment must be at most the sum of the two others")
        for name in ("centre", "inertia"):  # copied, because the caller may change the array later
            if isinstance(getattr(self, name), np.ndarray):
                set_field(self, name, read_only(np.array(getattr(self, name))))

    @property
    def tensor(self) -> Array:
        """Inertia tensor (3, 3) about the centre of mass in world axes [kg m2]."""
        wanted = "(3, 3), or (3,) along x, y and z [kg m2]"
        inertia = suitable_numbers("Frame: inertia", self.inertia, wanted, None, lambda inertia: inertia.shape in ((3,), (3, 3)))
        return np.diag(inertia) if inertia.ndim == 1 else inertia


@dataclass(frozen=True)
class Mount:
    """A spring and a damper side by side at a point, along each of the world's axes. It resists no turning.

    Under the frame it stands on the floor; as a column it joins the bed to the crown. Damping is viscous (``damping``), or like that of
    rubber, with equal loss at all frequencies (``loss_factor``).

    Attributes:
        point: (3,) point of attachment under static load, in world axes [m].
        stiffness: (3,) stiffness for vibrations along x, y and z [N/m].
        damping: (3,) viscous damping along x, y and z [N s/m].
        loss_factor: loss stiffness, 90 degrees ahead of the displacement, divided by ``stiffness``, in all directions [-].
        static_stiffness: (3,) stiffness under constant load [N/m]; None: ``stiffness``.
        area: loaded area, from which the pressure is found [m2]; None: there is no pressure.

    Raises:
        PinpressError: a value has another shape, is not finite or is negative.
    """

    point: Vector = field(metadata=parameter("m", axes=1))
    stiffness: Vector = field(metadata=parameter("N/m", "not negative", axes=1))
    damping: Vector = field(default=(0.0, 0.0, 0.0), metadata=parameter("N s/m", "not negative", axes=1))
    loss_factor: float = field(default=0.0, metadata=parameter("-", "not negative"))
    static_stiffness: Vector | None = field(default=None, metadata=parameter("N/m", "not negative", axes=1))
    area: float | None = field(default=None, metadata=parameter("m2", "positive"))

    def __post_init__(self) -> None:
        in_declared_units(self)
        for name, unit in (("point", "m"), ("stiffness", "N/m"), ("damping", "N s/m"), ("static_stiffness", "N/m")):
            if getattr(self, name) is None and name == "static_stiffness":
                continue
            wanted = f"x, y, z [{unit}], finite" + ("" if name == "point" else " and not negative")
            suits = np.isfinite if name == "point" else _not_negative
            values = suitable_numbers(f"Mount: {name}", getattr(self, name), wanted, (3,), suits)
            set_field(self, name, tuple(values.tolist()))
        suitable_numbers("Mount: loss_factor", self.loss_factor, "one number that is not negative", suits=_not_negative)
        plausibility.share("Mount: loss_factor", float(self.loss_factor), plausibility.DAMPED)
        if self.area is not None:
            suitable_numbers("Mount: area", self.area, "a positive number [m2]", suits=lambda area: area > 0)

    @property
    def static(self) -> Vector:
        """(3,) stiffness under constant load along x, y and z [N/m]."""
        return self.stiffness if self.static_stiffness is None else self.static_stiffness


def _not_negative(values: Array) -> bool:
    return bool((values >= 0).all())
