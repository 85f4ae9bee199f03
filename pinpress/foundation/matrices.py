"""Matrices of rigid parts on springs: rows of points, sums of springs, what the weight adds, and what does not stand.

Coordinates: see `mounted_press`.
"""

from collections.abc import Iterable, Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..common.arrays import Array
from ..common.errors import PinpressError
from .mounts import Frame, Mount

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
