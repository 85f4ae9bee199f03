"""How bodies are turned: a nominal turn that follows the crank angle, and a small turn from there, with all their derivatives.

The rotation matrix of a body is

    R = N(p) E(w),   E(w) = I + f (W + W W / 2),   f = 1 / (1 + w w / 4)

where N turns with the crank angle p as the body of the rigid press does, W is the cross product with w, and w is Gibbs's vector of the
small turn from there, twice the tangent of half the angle along the axis (Cayley's formula). So a body may turn fully, while w stays small
and its formula rational. N is a Fourier series over the period, so that it has derivatives of any order; it need not be the rigid press's
turn exactly, as w makes up for the rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ....common.errors import PinpressError
from ....common.quantities import Array, ComplexArray
from ....kinematics.cycle import motion_through_change_points
from ....kinematics.poses import poses
from ....linkage.linkage import Linkage

RESOLVED = 1e-15  # size of the last harmonics of a series that is fine enough
DEGREE = 12  # of Taylor polynomials

CROSS = np.zeros((3, 3, 3))  # of unit vectors: CROSS[d] @ s = e_d x s
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    CROSS[_i, _k, _j], CROSS[_i, _j, _k] = 1.0, -1.0
_UNIT = np.eye(3)
_OUTER = np.einsum("di,ej->deij", _UNIT, _UNIT)
SQUARE = 0.5 * (_OUTER + _OUTER.swapaxes(2, 3)) - np.einsum("de,ij->deij", _UNIT, _UNIT)  # (CROSS[d] CROSS[e] + CROSS[e] CROSS[d]) / 2
_FALLING = np.array(
    [[np.prod(np.arange(power, power - order, -1.0)) for power in range(DEGREE + 1)] for order in range(4)]
)  # by derivatives
SMALL = 21  # matrices of a small turn: itself, 3 derivatives, 9 second ones, its rate and 3 of them, its second rate and 3 of them


@dataclass(frozen=True, eq=False, repr=False)
class NominalTurns:
    """Rotation matrices of B bodies over the crank angle, as a table of Taylor polynomials.

    Attributes:
        period: of the linkage [rad].
        table: (cells, 13, B 9) coefficients of the matrices about the middle of each cell of the period, the constant first.
    """

    period: float
    table: Array

    def at(self, angle: Array) -> Array:
        """(n, B, 4, 3, 3): the matrices at crank angles (n,) and their first three derivatives by the angle."""
        cells, width = len(self.table), self.period / len(self.table)
        place = (angle % self.period) / width
        cell = np.minimum(place.astype(np.intp), cells - 1)
        from_middle = (place - cell - 0.5) * width
        powers = from_middle[:, None] ** np.arange(DEGREE + 1)
        weights = np.zeros((len(angle), 4, DEGREE + 1))
        for order in range(4):
            weights[:, order, order:] = _FALLING[order, order:] * powers[:, : DEGREE + 1 - order]
        found = (weights @ self.table[cell]).reshape(len(angle), 4, -1, 3, 3)
        return found.swapaxes(1, 2)


def nominal_turns(press: Linkage, joints: tuple[int, ...], own_axes: Array) -> NominalTurns:
    """The turns of bodies of the rigid press.

    Args:
        press: the linkage; its crank turns fully.
        joints: Pinocchio's joints of the bodies, 0 for the frame.
        own_axes: (B, 3, 3) axes that are fixed to each body, in its joint's frame, as columns: the matrices hold these in world axes.

    Raises:
        PinpressError: a body turns too abruptly for a series.
    """
    turns = press.period_turns or 1
    count, most = 64 * turns, 8192 * turns
    while True:
        angle = np.linspace(0.0, 2 * np.pi * turns, count, endpoint=False)
        placed = poses(press, motion_through_change_points(press, angle, 1.0).joint_position)
        turned = np.concatenate(
            [(placed.rotation[joint] @ axes).reshape(count, 9) for joint, axes in zip(joints, own_axes, strict=True)], axis=1
        )
        series = np.fft.rfft(turned, axis=0)[: count // 2] / count
        size = np.abs(series).max(axis=1)
        left = float(size[-count // 8 :].max())
        if left <= RESOLVED or count >= most:
            break
        count *= 2
    if left > 1e-10:  # errors of places would then show in a run
        raise PinpressError(
            f"links of {press.name} turn too abruptly for an elastic motion in space: keep the linkage away from where it locks"
        )
    return NominalTurns(2 * np.pi * turns, _taylor(series[: int(np.flatnonzero(size > 0.1 * RESOLVED).max()) + 1], 1.0 / turns))


def _taylor(series: ComplexArray, base: float) -> Array:
    """(cells, 13, m) Taylor coefficients about the middles of cells of a period, of Fourier series (K, m) with a base frequency."""
    harmonics = np.arange(len(series))
    cells = 4 * len(series)  # for each harmonic: with this degree rounding is all that is left
    coefficients, term = np.empty((cells, DEGREE + 1, series.shape[1])), series * np.exp(1j * np.pi * harmonics / cells)[:, None]
    for power in range(DEGREE + 1):
        coefficients[:, power] = np.fft.irfft(term, cells, axis=0) * cells
        term = term * (1j * base * harmonics / (power + 1))[:, None]
    return coefficients


class Turned(NamedTuple):
    """Rotation matrices of B bodies at n states by their four coordinates: three of w, then the crank angle. The last axis of each array
    has the rows of a matrix one after the other.

    Along a line of coordinates with the given rates, `rate` and `curve` are derivatives by the time.

    Attributes:
        matrix: (n, B, 9) R.
        by: (n, B, 4, 9) derivatives of R.
        by_twice: (n, B, 4, 4, 9) second derivatives; None if they are not asked for.
        rate: (n, B, 9) rate of R.
        rate_by: (n, B, 4, 9) rates of `by`.
        curve: (n, B, 9) second rate of R where all accelerations are zero.
        curve_by: (n, B, 4, 9) derivatives of `curve`; None if they are not asked for.
    """

    matrix: Array
    by: Array
    by_twice: Array | None
    rate: Array
    rate_by: Array
    curve: Array
    curve_by: Array | None


def turn_bodies(nominal: NominalTurns, w: Array, angle: Array, w_rate: Array, speed: Array, derivatives: bool = True) -> Turned:
    """Rotation matrices and their derivatives.

    Args:
        nominal: the nominal turns.
        w: (n, B, 3) Gibbs's vectors of the small turns from there.
        angle: (n,) of the crank [rad].
        w_rate: (n, B, 3) rates of w [1/s].
        speed: (n,) of the crank [rad/s].
        derivatives: whether second derivatives and those of ``curve`` are asked for.
    """
    n, b = w.shape[:2]
    shapes = {"matrix": (), "by": (4,), "by_twice": (4, 4), "rate": (), "rate_by": (4,), "curve": (), "curve_by": (4,)}
    left_out = () if derivatives else ("by_twice", "curve_by")
    arrays = {name: None if name in left_out else np.empty((n, b, *shape, 9)) for name, shape in shapes.items()}
    for first in range(0, n, 48):  # 48 states stay in the cache
        part = slice(first, first + 48)
        parts = {name: None if array is None else array[part].reshape(*array[part].shape[:-1], 3, 3) for name, array in arrays.items()}
        small = _small_turn(w[part], w_rate[part], derivatives)
        _fill(parts, nominal.at(angle[part]), small, speed[part, None, None, None])
    return Turned(**arrays)  # type: ignore[arg-type]


def _fill(parts: dict[str, Any], nominal: Array, small: Array, spin: Array) -> None:
    """Fill the arrays of `Turned` (n, B, ..., 3, 3), of nominal turns (n, B, 4, 3, 3), small ones, and speeds (n, 1, 1, 1)."""
    n, b = nominal.shape[:2]
    product = (nominal.reshape(n, b, 12, 3) @ small.reshape(n, b, 3, SMALL * 3)).reshape(n, b, 4, 3, SMALL, 3)
    n0, n1, n2, n3 = (product[:, :, order].swapaxes(2, 3) for order in range(4))  # (n, B, SMALL, 3, 3)
    each, rate, curve = spin[..., None], 13, 17
    parts["matrix"][:] = n0[:, :, 0]
    parts["by"][:, :, :3], parts["by"][:, :, 3] = n0[:, :, 1:4], n1[:, :, 0]
    parts["rate"][:] = n0[:, :, rate] + spin * n1[:, :, 0]
    parts["rate_by"][:, :, :3] = n0[:, :, 14:17] + each * n1[:, :, 1:4]
    parts["rate_by"][:, :, 3] = n1[:, :, rate] + spin * n2[:, :, 0]
    parts["curve"][:] = n0[:, :, curve] + 2 * spin * n1[:, :, rate] + spin**2 * n2[:, :, 0]
    if parts["by_twice"] is None:
        return
    parts["curve_by"][:, :, :3] = n0[:, :, 18:21] + 2 * each * n1[:, :, 14:17] + each**2 * n2[:, :, 1:4]
    parts["curve_by"][:, :, 3] = n1[:, :, curve] + 2 * spin * n2[:, :, rate] + spin**2 * n3[:, :, 0]
    parts["by_twice"][:, :, :3, :3] = n0[:, :, 4:13].reshape(n, b, 3, 3, 3, 3)
    parts["by_twice"][:, :, :3, 3] = parts["by_twice"][:, :, 3, :3] = n1[:, :, 1:4]
    parts["by_twice"][:, :, 3, 3] = n2[:, :, 0]


def _small_turn(w: Array, v: Array, derivatives: bool) -> Array:
    """(n, B, 3, SMALL, 3): rows of E(w), of vectors (n, B, 3) with rates v (n, B, 3), and of its derivatives; those that are not asked for
    are 0."""

    def along(vectors: Array) -> Array:
        """(n, B, 3, 3, 3) of `SQUARE` with vectors (n, B, 3) as its second."""
        return np.asarray(vectors.reshape(-1, 3) @ SQUARE.transpose(1, 0, 2, 3).reshape(3, 27)).reshape(*vectors.shape[:2], 3, 3, 3)

    def contracted(tensors: Array, vectors: Array) -> Array:
        return np.asarray(sum(tensors[:, :, d] * vectors[:, :, d, None, None] for d in range(3)))

    rows = np.zeros((*w.shape[:2], 3, SMALL, 3))
    square, square_rate = along(w), along(v)
    k_by = CROSS + square
    k = contracted(CROSS + 0.5 * square, w)
    k_rate, k_curve = contracted(k_by, v), contracted(square_rate, v)
    size, size_rate, size_curve = (w * w).sum(axis=2), 2 * (w * v).sum(axis=2), 2 * (v * v).sum(axis=2)
    f = 1 / (1 + size / 4)
    f1, f2, f3 = -(f**2) / 4, f**3 / 8, -3 * f**4 / 32
    f_rate, f_curve = f1 * size_rate, f2 * size_rate**2 + f1 * size_curve
    f_by = 2 * f1[..., None] * w
    f_rate_by = 2 * ((f2 * size_rate)[..., None] * w + f1[..., None] * v)
    one, two, three, twice = (..., None, None), (..., None), (..., None, None, None), (..., None, None)

    def put(place: slice | int, values: Array) -> None:
        rows[:, :, :, place] = values if isinstance(place, int) else values.swapaxes(2, 3)

    put(0, _UNIT + f[one] * k)
    put(slice(1, 4), f_by[twice] * k[:, :, None] + f[three] * k_by)
    put(13, f_rate[one] * k + f[one] * k_rate)
    put(slice(14, 17), f_rate_by[twice] * k[:, :, None] + f_by[twice] * k_rate[:, :, None] + f_rate[three] * k_by + f[three] * square_rate)
    put(17, f_curve[one] * k + 2 * f_rate[one] * k_rate + f[one] * k_curve)
    if not derivatives:
        return rows
    f_curve_by = 2 * ((f3 * size_rate**2 + f2 * size_curve)[two] * w + 2 * (f2 * size_rate)[two] * v)
    curve_by = f_curve_by[twice] * k[:, :, None] + 2 * f_rate_by[twice] * k_rate[:, :, None] + f_by[twice] * k_curve[:, :, None]
    put(slice(18, 21), curve_by + f_curve[three] * k_by + 2 * f_rate[three] * square_rate)
    f_twice = 4 * f2[one] * w[..., :, None] * w[..., None, :] + 2 * f1[one] * _UNIT
    mixed = f_by[:, :, :, None, None, None] * k_by[:, :, None]
    by_twice = f_twice[..., None, None] * k[:, :, None, None] + mixed + mixed.swapaxes(2, 3) + f[..., None, None, None, None] * SQUARE
    put(slice(4, 13), by_twice.reshape(*w.shape[:2], 9, 3, 3))
    return rows
