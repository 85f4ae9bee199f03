"""What a press stands on, and what stands: mounts, and rigid parts of the frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import typed
from ..common.arrays import Array
from ..common.checks import finite_numbers
from ..common.errors import PinpressError, shown
from ..common.frozen import Frozen, read_only
from ..common.scenario_numbers import set_field
from .rubber_pad import RubberPad

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Frame(Frozen):
    """A rigid part of the frame, with all that stands on it and is not in the URDF: motor, flywheel, bolster, lower die.

    What the URDF's frame link weighs is counted with the press, and so are the links that move.

    Attributes:
        mass: [kg]. centre: of mass, in world axes [m].
        inertia: about the centre of mass, world axes [kg m2]: (3, 3), or (3,) principal ones along x, y and z.
    """

    mass: float
    centre: ArrayLike
    inertia: ArrayLike

    def __post_init__(self) -> None:
        mass = _checked("Frame", "mass", self.mass, (), "one number [kg]")
        if mass < 0:
            raise PinpressError(f"Frame: mass is {shown(self.mass)}; give one that is not negative [kg]")
        _checked("Frame", "centre", self.centre, (3,), "x, y, z [m]")
        inertia = self.tensor
        if inertia.shape != (3, 3) or np.abs(inertia - inertia.T).max() > 1e-9 * np.abs(inertia).max(initial=1e-300):
            raise PinpressError("Frame: inertia is no symmetric tensor; give (3, 3), or (3,) along x, y and z [kg m2]")
        least, middle, largest = np.linalg.eigvalsh(inertia)
        if least < -1e-9 * largest or largest > (least + middle) * (1 + 1e-9):
            raise PinpressError("Frame: no body has this inertia: each principal moment must be at most the sum of the two others")
        for field in ("centre", "inertia"):  # a copy, as what a caller keeps is his to change
            if isinstance(getattr(self, field), np.ndarray):
                set_field(self, field, read_only(np.array(getattr(self, field))))

    @property
    def tensor(self) -> Array:
        """(3, 3) about the centre of mass [kg m2]."""
        given = finite_numbers(self.inertia)
        if given is None or given.shape not in ((3,), (3, 3)):
            raise PinpressError(f"Frame: inertia is {shown(self.inertia)}; give (3, 3), or (3,) along x, y and z [kg m2]")
        return np.diag(given) if given.ndim == 1 else given


@dataclass(frozen=True)
class Mount:
    """A spring and a damper side by side, in each of the world's directions, at a point; its turning is free.

    Under the frame it stands on the floor; as a column it joins the bed to the crown. Damping is viscous (``damping``), or that of rubber
    (``loss_factor``): a loss that is the same at all frequencies.

    Attributes:
        point: where it holds [m], as the press stands.
        stiffness: along x, y and z, of vibrations [N/m]. damping: the same [N s/m].
        loss_factor: share of the stiffness that is 90 degrees ahead, in all directions [-].
        static_stiffness: under constant load [N/m]; None: ``stiffness``.
        area: loaded, for the pressure [m2]; None where it has none.
    """

    point: Vector
    stiffness: Vector
    damping: Vector = (0.0, 0.0, 0.0)
    loss_factor: float = 0.0
    static_stiffness: Vector | None = None
    area: float | None = None

    def __post_init__(self) -> None:
        for field, unit in (("point", "m"), ("stiffness", "N/m"), ("damping", "N s/m"), ("static_stiffness", "N/m")):
            if getattr(self, field) is None and field == "static_stiffness":
                continue
            values = _checked("Mount", field, getattr(self, field), (3,), f"x, y, z [{unit}]")
            if field != "point" and values.min() < 0:
                raise PinpressError(f"Mount: {field} is {shown(getattr(self, field))}; give numbers that are not negative [{unit}]")
            set_field(self, field, tuple(values.tolist()))
        for field in ("loss_factor", "area"):
            if getattr(self, field) is not None:
                value = _checked("Mount", field, getattr(self, field), (), "one number")
                if value < 0 or (field == "area" and value == 0):
                    raise PinpressError(f"Mount: {field} is {shown(getattr(self, field))}; give a positive number")

    @property
    def static(self) -> Vector:
        """Stiffness under constant load [N/m]."""
        return self.stiffness if self.static_stiffness is None else self.static_stiffness


@typed
def pad_mount(point: Vector, pad: RubberPad) -> Mount:
    """The mount that a rubber pad is, its middle at a point [m]."""
    if not isinstance(pad, RubberPad):
        raise PinpressError(f"pad is {shown(pad)}: give a RubberPad")
    return Mount(point, pad.stiffness, loss_factor=pad.loss_factor, static_stiffness=pad.static_stiffness, area=pad.area)


def listed_mounts(mounts: object, what: str) -> tuple[Mount, ...]:
    """Mounts as given by a caller.

    Raises:
        PinpressError: there is none, or one is no `Mount`.
    """
    if not isinstance(mounts, Sequence) or not mounts or not all(isinstance(mount, Mount) for mount in mounts):
        raise PinpressError(f"{what} is {shown(mounts)}: give a list of Mount, at least one")
    return tuple(mounts)


def _checked(kind: str, field: str, given: object, shape: tuple[int, ...], wanted: str) -> Array:
    values = finite_numbers(given)
    if values is None or values.shape != shape:
        raise PinpressError(f"{kind}: {field} is {shown(given)}; give {wanted}, finite")
    return values
