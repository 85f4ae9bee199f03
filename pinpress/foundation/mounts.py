"""What a press stands on, and what stands: rigid parts of the frame, mounts, and rubber pads; and the matrices of rigid parts on springs,
in the coordinates of `mounted_press`.

Stiffness of a pad under the foot of a machine, from its size and hardness: rubber hardly changes its volume, so that a flat pad between two
plates is far stiffer in compression than in shear. With the shape factor S = loaded area / area free to bulge, and small strains (Gent and
Lindley 1959; Lindley, Engineering Design with Natural Rubber):

    E_c = 3 G (1 + 2 S^2), softened by the bulk modulus B: 1 / E = 1 / E_c + 1 / B
    k_z = E A / t,  k_x = k_y = G A / t

The hardness gives the shear modulus by Gent's formula (Gent 1958), 3 G = 0.0981 (56 + 7.62336 H) / (0.137505 (254 - 2.54 H)) MPa.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..common.arguments import finite_numbers, typed
from ..common.errors import PinpressError, shown
from ..common.frozen import Frozen, read_only
from ..common.parameters import Checked, parameter, set_field
from ..common.quantities import Array

Vector = tuple[float, float, float]

HARDEST, SOFTEST = 80.0, 20.0  # Shore A for which Gent's formula holds


@dataclass(frozen=True)
class Frame(Frozen):
    """A rigid part of the frame, with all that stands on it and is not in the URDF: motor, flywheel, bolster, lower die.

    What the URDF's frame link weighs is counted with the press, and so are the links that move.

    Attributes:
        mass: of the part [kg].
        centre: of mass, in world axes [m].
        inertia: about the centre of mass, world axes [kg m2]: (3, 3), or (3,) principal ones along x, y and z.

    Raises:
        PinpressError: a mass that is negative, or an inertia that no body has.
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
        for name in ("centre", "inertia"):  # a copy, as what a caller keeps is his to change
            if isinstance(getattr(self, name), np.ndarray):
                set_field(self, name, read_only(np.array(getattr(self, name))))

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
        stiffness: along x, y and z, of vibrations [N/m].
        damping: viscous, along x, y and z [N s/m].
        loss_factor: share of the stiffness that is 90 degrees ahead, in all directions [-].
        static_stiffness: under constant load [N/m]; None: ``stiffness``.
        area: loaded, for the pressure [m2]; None where it has none.

    Raises:
        PinpressError: what is no vector or number of its kind, or is negative.
    """

    point: Vector
    stiffness: Vector
    damping: Vector = (0.0, 0.0, 0.0)
    loss_factor: float = 0.0
    static_stiffness: Vector | None = None
    area: float | None = None

    def __post_init__(self) -> None:
        for name, unit in (("point", "m"), ("stiffness", "N/m"), ("damping", "N s/m"), ("static_stiffness", "N/m")):
            if getattr(self, name) is None and name == "static_stiffness":
                continue
            values = _checked("Mount", name, getattr(self, name), (3,), f"x, y, z [{unit}]")
            if name != "point" and values.min() < 0:
                raise PinpressError(f"Mount: {name} is {shown(getattr(self, name))}; give numbers that are not negative [{unit}]")
            set_field(self, name, tuple(values.tolist()))
        for name in ("loss_factor", "area"):
            if getattr(self, name) is not None:
                value = _checked("Mount", name, getattr(self, name), (), "one number")
                if value < 0 or (name == "area" and value == 0):
                    raise PinpressError(f"Mount: {name} is {shown(getattr(self, name))}; give a positive number")

    @property
    def static(self) -> Vector:
        """Stiffness under constant load [N/m]."""
        return self.stiffness if self.static_stiffness is None else self.static_stiffness


@dataclass(frozen=True)
class RubberPad(Checked):
    """A rectangular pad of rubber, bonded or held by friction between two plates.

    Attributes:
        length: unloaded [m].
        width: unloaded [m].
        thickness: unloaded [m].
        hardness: Shore A, 20 to 80; or else ``shear_modulus``, one of the two.
        shear_modulus: static [Pa].
        loss_factor: loss by storage modulus [-], 0.05 (natural rubber) to 0.3 (damped compounds).
        stiffening: dynamic by static stiffness [-], 1 or more: 1.1 (soft natural rubber) to 2 and more (hard, filled).
        bulk_modulus: of the rubber [Pa].

    Raises:
        PinpressError: a number that makes no sense, both hardness and shear modulus, or neither.
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
        """Along x, y and z, of vibrations: the static one times ``stiffening`` [N/m]."""
        x, y, z = self.static_stiffness
        return x * self.stiffening, y * self.stiffening, z * self.stiffening


@typed
def pad_mount(point: Vector, pad: RubberPad) -> Mount:
    """The mount that a rubber pad is.

    Args:
        point: middle of the pad, world axes [m].
        pad: the pad.

    Raises:
        PinpressError: no point, or no pad.
    """
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


SMALLEST = 1e-10  # stiffness of a mode beside the stiffest that is none
PULLED = 1e-9  # of the weight, by which a mount may be pulled by rounding
COORDINATES = ("x", "y", "z", "turn about x", "turn about y", "turn about z")


def rows_at(parts: int, part: int, point: Array) -> Array:
    """(3, n) displacement of a point of a part for each coordinate: u + turn x point."""
    rows = np.zeros((3, 6 * parts))
    rows[:, 6 * part : 6 * part + 3] = np.eye(3)
    rows[:, 6 * part + 3 : 6 * part + 6] = -pin.skew(point)
    return rows


def centre_of(body: Array) -> Array:
    """(3,) centre of mass of a body with a spatial inertia (6, 6); the origin of one without mass."""
    return np.array([body[5, 1], body[3, 2], body[4, 0]]) / (body[0, 0] or 1.0)


def body_inertia(frame: Frame) -> Array:
    """(6, 6) spatial inertia of a part about the world origin."""
    return np.asarray(pin.Inertia(frame.mass, np.asarray(frame.centre, dtype=float), frame.tensor).matrix())


def weight_wrench(body: Array, gravity: Array) -> Array:
    """Wrench (6,) of the weight of a body, (6, 6) inertia, about the world origin."""
    return np.asarray(body[:, :3] @ gravity)


def springs_together(springs: Iterable[tuple[ArrayLike, Array]]) -> Array:
    """(n, n) of springs with constants (3,) along x, y and z and rows (3, n)."""
    return np.asarray(sum(at.T @ (np.asarray(constants, dtype=float)[:, None] * at) for constants, at in springs))


def turning_stiffness(
    mounts: Sequence[Mount],
    uprights: Sequence[Mount],
    between: Sequence[Array],
    rest: Array,
    load: Array,
    bodies: Sequence[Array],
    gravity: Array,
) -> Array:
    """Stiffness (n, n) by the static forces as the frame turns."""
    forces = [(0, force, np.array(mount.point)) for force, mount in zip(load, mounts, strict=True)]
    for upright, at in zip(uprights, between, strict=True):
        force = -np.array(upright.static) * (at @ rest)
        forces += [(1, force, np.array(upright.point)), (0, -force, np.array(upright.point))]
    for part, body in enumerate(bodies):
        forces.append((part, body[0, 0] * gravity, centre_of(body)))
    stiffness = np.zeros((6 * len(bodies), 6 * len(bodies)))
    for part, force, point in forces:
        turn = slice(6 * part + 3, 6 * part + 6)
        stiffness[turn, turn] += (force @ point) * np.eye(3) - 0.5 * (np.outer(force, point) + np.outer(point, force))
    return stiffness


def refuse_loose(matrix: Array, problem: str, remedy: str) -> None:
    """Raise where a matrix (n, n) is not positive definite: the problem, a coordinate, the remedy."""
    scale = 1 / np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(scale[:, None] * matrix * scale)
    if values[0] <= SMALLEST * values[-1]:
        free = np.abs(scale * vectors[:, 0]).reshape(-1, 6).max(axis=0)
        turns = 3 * int(free[3:].max() > SMALLEST * free.max())  # a turn about a mount moves the origin too
        raise PinpressError(f"{problem} {COORDINATES[turns + int(free[turns : turns + 3].argmax())]}: {remedy}")


def refuse_pulled(load: Array, gravity: Array) -> None:
    """Raise where a mount is pulled at rest."""
    along = load @ -gravity
    if (along < -PULLED * np.abs(along).sum()).any():
        number = int(along.argmin())
        raise PinpressError(
            f"mount {number} would be pulled by the weight, {abs(load[number, 2]):.4g} N: the centre of mass is not between the mounts;"
            " move them"
        )
