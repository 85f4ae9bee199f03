"""The parts of a frame: rigid parts on springs, attachments, rotors, and their matrices.

The motion of part k of the frame is the displacement of its point at the world origin and its rotation, (x, y, z, rx, ry, rz). This motion
is B_k u, where u are the coordinates of the whole system; for a rigid part B_k selects six coordinates. So a spring between two parts has
the rows [1, -skew(p)] (B_a - B_b), a wrench w about the world origin on a part is the force B_k^T w on the coordinates, and a body of
spatial inertia Y adds B_k^T Y B_k to the mass matrix.

A rotor of polar inertia J that spins with w about the unit vector n has the angular momentum J w n. When its part rotates by t, the angular
momentum rotates too, and the rotor exerts the gyroscopic moment -J w (t' x n) on the part. This is -w G t' with the skew-symmetric G = -J
skew(n), so it does no work.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.frozen import Frozen
from ..common.parameters import Checked, parameter, set_field
from ..common.quantities import Array
from ..loads.mounts import Frame, Mount, Vector
from .mounts import listed_mounts

COORDINATES = ("x", "y", "z", "turn about x", "turn about y", "turn about z")


@dataclass(frozen=True)
class Attachment(Frozen):
    """A body that stands on a part of the frame: a motor on its bracket, a feeder, a cabinet.

    Attributes:
        body: mass, centre of mass and inertia of the body. The frame's mass must not include it.
        springs: springs between the body and the part, e.g. a bracket's stiffness; no springs: the body is bolted on.
        on: name of the part that carries it; None: the one that carries crank and guides.

    Raises:
        PinpressError: ``body`` is not a `Frame`, or ``springs`` is not a list of `Mount`.
    """

    body: Frame
    springs: Sequence[Mount] = ()
    on: str | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.body, Frame):
            raise PinpressError(f"Attachment: body is {shown(self.body)}: give a Frame, with its mass, centre and inertia")
        if not isinstance(self.springs, Sequence) or len(self.springs):
            set_field(self, "springs", listed_mounts(self.springs, "Attachment: springs"))
        if self.on is not None and not isinstance(self.on, str):
            raise PinpressError(f"Attachment: on is {shown(self.on)}: give the name of a part of the frame")
        super().__post_init__()


@dataclass(frozen=True)
class Rotor(Checked):
    """A body that spins on a part of the frame in proportion to the crank, such as flywheel, crankshaft or the rotor of the motor.

    The part's mass must include the rotor's mass. If the part rotates about another axis, the rotor exerts a gyroscopic moment on it. If
    the speed changes, the part carries the reaction torque.

    Attributes:
        inertia: moment of inertia about its axis [kg m2].
        axis: (3,) direction of its axis in world axes, of any length; a positive spin is about this direction [-].
        ratio: speed of the rotor / speed of the crank, negative if the rotor turns the other way about ``axis`` [-].
        on: name of the part that carries it; None: the one that carries crank and guides.

    Raises:
        PinpressError: a number is out of its range, or the axis has no direction.
    """

    inertia: float = field(metadata=parameter("kg m2", "positive"))
    axis: Vector = field(metadata=parameter("-", axes=1))
    ratio: float = field(default=1.0, metadata=parameter("-"))
    on: str | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        set_field(self, "axis", direction("Rotor: axis", self.axis))
        if self.on is not None and not isinstance(self.on, str):
            raise PinpressError(f"Rotor: on is {shown(self.on)}: give the name of a part of the frame")

    @property
    def momentum(self) -> Array:
        """(3,) angular momentum in world axes at a crank speed of 1 rad/s [kg m2]."""
        return np.asarray(self.inertia * self.ratio * np.array(self.axis))


def direction(what: str, given: ArrayLike) -> Vector:
    """A caller's direction as a vector (3,) of length 1; ``what``: its name, for the message.

    Raises:
        PinpressError: the direction is not a vector (3,) of finite numbers, or is zero.
    """
    vector = np.asarray(given, dtype=float)
    if vector.shape != (3,) or not vector.any():
        raise PinpressError(f"{what} is {shown(given)}: give x, y, z of a direction")
    near_one = vector / np.abs(vector).max()
    x, y, z = (near_one / np.linalg.norm(near_one)).tolist()
    return x, y, z


class Body(NamedTuple):
    """A rigid body of the system: the part with which it moves, and its spatial inertia (6, 6) about the world origin."""

    part: str
    inertia: Array


class Spring(NamedTuple):
    """A spring between two parts, the upper part first; or between a part and the floor (None)."""

    mount: Mount
    part: str
    other: str | None


def axis_index(axis: object) -> int:
    """0, 1 or 2 of a caller's axis "x", "y" or "z"; raises PinpressError for any other axis."""
    if not isinstance(axis, str) or axis not in ("x", "y", "z"):
        raise PinpressError(f"axis is {shown(axis)}: write 'x', 'y' or 'z'")
    return "xyz".index(axis)


def motions_of(names: Sequence[str]) -> dict[str, Array]:
    """Motions (6, n) at the world origin of rigid parts that move freely, for a unit of each coordinate; a part has six coordinates."""
    return {name: np.eye(6, 6 * len(names), 6 * k) for k, name in enumerate(names)}


def part_named(parts: Mapping[str, Array], name: str | None, carrier: str) -> str:
    """The name of a part of the frame, checked; ``carrier`` for None.

    Raises:
        UnknownNameError: there is no such part.
    """
    if name is None:
        return carrier
    if name not in parts:
        raise UnknownNameError("part of the frame", name, parts)
    return name


def body_inertia(frame: Frame) -> Array:
    """Spatial inertia (6, 6) of a part about the world origin, linear before angular."""
    return np.asarray(pin.Inertia(frame.mass, np.asarray(frame.centre, dtype=float), frame.tensor).matrix())


def centre_of(body: Array) -> Array:
    """Centre of mass (3,) of a body with a spatial inertia (6, 6) [m]; the origin if the body has no mass."""
    return np.array([body[5, 1], body[3, 2], body[4, 0]]) / (body[0, 0] or 1.0)


def weight_wrench(body: Array, gravity: Array) -> Array:
    """Wrench (6,) of the weight of a body with a spatial inertia (6, 6) about the world origin [N, N m]."""
    return np.asarray(body[:, :3] @ gravity)


def rows_at(motion: Array, point: ArrayLike) -> Array:
    """Rows (3, n) of the displacement of a point of a part, u + rotation x point, from the rows (6, n) of the part's motion."""
    return np.asarray(motion[:3] - pin.skew(np.asarray(point, dtype=float)) @ motion[3:])


def spring_rows(spring: Spring, parts: Mapping[str, Array]) -> Array:
    """Rows (3, n) of the elongation of a spring: the displacement of the first part at the spring's point less that of the second part."""
    rows = rows_at(parts[spring.part], spring.mount.point)
    return rows if spring.other is None else rows - rows_at(parts[spring.other], spring.mount.point)


def springs_together(springs: Iterable[tuple[ArrayLike, Array]], count: int) -> Array:
    """Stiffness matrix (n, n) of springs, each with its constants (3,) along x, y and z and the rows (3, n) of its elongation."""
    total = np.zeros((count, count))
    for constants, at in springs:
        total += at.T @ (np.asarray(constants, dtype=float)[:, None] * at)
    return total


def gyroscopic_matrix(rotors: Iterable[Rotor], parts: Mapping[str, Array], carrier: str, count: int) -> Array:
    """Skew-symmetric matrix G (n, n) of gyroscopic moments -G u' at a crank speed of 1 rad/s [kg m2]."""
    total = np.zeros((count, count))
    for rotor in rotors:
        turn = parts[part_named(parts, rotor.on, carrier)][3:]
        total -= turn.T @ pin.skew(rotor.momentum) @ turn
    return total


def turning_stiffness(forces: Iterable[tuple[Array, Array, Array]], count: int) -> Array:
    """Geometric stiffness (n, n) from static forces on parts that rotate; see `mounted_press`.

    Args:
        forces: for each force, the rows (6, n) of its part's motion, the force (3,) [N] and its point (3,) [m].
        count: n, the number of coordinates.
    """
    stiffness = np.zeros((count, count))
    for motion, force, point in forces:
        turn = (force @ point) * np.eye(3) - 0.5 * (np.outer(force, point) + np.outer(point, force))
        stiffness += motion[3:].T @ turn @ motion[3:]
    return stiffness


def refuse_loose(matrix: Array, problem: str, remedy: str) -> None:
    """Raise PinpressError if a matrix (n, n) is not positive definite; the message is the problem, a free coordinate and the remedy."""
    scale = 1 / np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh(scale[:, None] * matrix * scale)
    smallest = 1e-10  # as a share of the largest; below it an eigenvalue is a rounding error
    if values[0] <= smallest * values[-1]:
        free = np.abs(scale * vectors[:, 0]).reshape(-1, 6).max(axis=0)
        turns = 3 * int(free[3:].max() > smallest * free.max())  # first, because a turn about a mount also moves the origin
        raise PinpressError(f"{problem} {COORDINATES[turns + int(free[turns : turns + 3].argmax())]}: {remedy}")


def refuse_pulled(load: Array, gravity: Array) -> None:
    """Raise PinpressError if the weight pulls at a mount instead of pressing on it."""
    along = load @ -gravity
    # a load within rounding error may pull at a mount
    if (along < -1e-9 * np.abs(along).sum()).any():
        number = int(along.argmin())
        pulled = -along[number] / np.linalg.norm(gravity)
        raise PinpressError(
            f"mount {number + 1} of {len(along)} would be pulled by the weight, {pulled:.4g} N: the centre of mass is not between the"
            " mounts; move them"
        )
