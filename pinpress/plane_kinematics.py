"""Closing a planar linkage at all crank angles at once, with the exact influence coefficients of every joint.

A loop's gap and the columns of its Jacobian are rows of one matrix product with the basis (see `plane`). Blocks are solved in the order in
which they depend on each other; a dyad's 2x2 system a x + b y = c, complex a, b, c and real x, y, has the closed solution

    x = -Im(conj(b) c) / D,   y = Im(conj(a) c) / D,   D = Im(conj(a) b)
"""

from typing import NamedTuple

import numpy as np

from .branch import Closure
from .coordinates import Array, ComplexArray
from .plane import Block, Plane, product

MOST_NEWTON_STEPS = 12


def close(plane: Plane, angle: Array, guess: Array, with_margins: bool = False) -> Closure:
    """Close all loops at crank angles (n,) by Newton's method from guesses (nv, n), to rounding.

    Where it fails, the gap of that configuration is large or not finite: the caller judges.
    """
    x = guess.copy()
    x[plane.driver] = angle
    count = len(plane.loop_points)
    worst, steps = np.inf, 0
    with np.errstate(all="ignore"):  # a failed closure shows in its gap
        while True:
            at = basis(plane, x)
            rows = product(plane.closure, at)
            gaps = rows[:count]
            gap = np.sqrt((gaps.real**2 + gaps.imag**2).max(axis=0, initial=0.0))
            before, worst = worst, float(gap.max())
            # Rounding can leave a gap slightly above the tolerance: stop where another step no longer halves it.
            stalled = worst > 0.5 * before and worst < 1e3 * plane.tolerance
            if worst <= plane.tolerance or stalled or steps == MOST_NEWTON_STEPS or not np.isfinite(worst):
                break
            step = np.zeros_like(x)
            _solve(plane, rows, _factors(plane, rows), list(-gaps), step)
            x += step
            steps += 1
        factors = _factors(plane, rows)
        first = np.empty_like(x)
        first[plane.driver] = 1.0
        _solve(plane, rows, factors, [None if row is None else -rows[row] for row in plane.driven], first)
        second = np.empty_like(x)
        second[plane.driver] = 0.0
        curvature = basis_acceleration(plane, at, first, None)
        _solve(plane, rows, factors, list(-product(plane.closure[:count], curvature)), second)
        margins = _margins(plane, rows) if with_margins else None
    return Closure(x, first, second, gap, worst, steps, margins, at)


def basis(plane: Plane, x: Array) -> ComplexArray:
    """The basis (nb, n) of joint coordinates (nv, n)."""
    turning = len(plane.revolute)
    at = np.empty((1 + len(x), x.shape[1]), complex)
    at[0] = 1.0
    absolute = plane.turn @ x
    np.cos(absolute, out=at.real[1 : 1 + turning])
    np.sin(absolute, out=at.imag[1 : 1 + turning])
    for row, (joint, rotor) in enumerate(zip(plane.prismatic, plane.guide_rotors, strict=True), 1 + turning):
        at[row] = x[joint] * at[rotor] if rotor else x[joint]
    return at


def basis_velocity(plane: Plane, at: ComplexArray, v: Array) -> ComplexArray:
    """First time derivative of the basis at joint rates (nv, n)."""
    turning = len(plane.revolute)
    rate = np.empty_like(at)
    rate[0] = 0.0
    spin = plane.turn @ v
    np.multiply(at[1 : 1 + turning], 1j * spin, out=rate[1 : 1 + turning])
    for row, (joint, rotor) in enumerate(zip(plane.prismatic, plane.guide_rotors, strict=True), 1 + turning):
        rate[row] = v[joint] * at[rotor] + 1j * spin[rotor - 1] * at[row] if rotor else v[joint]
    return rate


def basis_acceleration(plane: Plane, at: ComplexArray, v: Array, a: Array | None) -> ComplexArray:
    """Second time derivative of the basis at joint rates and accelerations (nv, n); ``a`` None: the centripetal and Coriolis part alone."""
    turning = len(plane.revolute)
    result = np.empty_like(at)
    result[0] = 0.0
    spin = plane.turn @ v
    factor: Array | ComplexArray = spin * -spin
    if a is not None:
        inward, factor = factor, np.empty(spin.shape, complex)
        factor.real, factor.imag = inward, plane.turn @ a
    np.multiply(at[1 : 1 + turning], factor, out=result[1 : 1 + turning])
    for row, (joint, rotor) in enumerate(zip(plane.prismatic, plane.guide_rotors, strict=True), 1 + turning):
        along = 0.0 if a is None else a[joint]
        if rotor:
            result[row] = (along + 2j * spin[rotor - 1] * v[joint]) * at[rotor] + factor[rotor - 1] * at[row]
        else:
            result[row] = along
    return result


class Dyad(NamedTuple):
    """conj(a) / D and -conj(b) / D of a 2x2 block; their products with c have y and x as imaginary parts."""

    a: ComplexArray
    b: ComplexArray


def dyad_columns(block: Block, rows: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """The two columns (n,) of a 2x2 block's joints."""
    (_, a), (_, b) = block.own[0]
    return rows[a], rows[b]


def block_matrix(block: Block, rows: ComplexArray) -> Array:
    """Jacobian (n, 2k, 2k) of a block: real and imaginary part of every loop against the block's joints."""
    size = len(block.joints)
    matrix = np.zeros((rows.shape[1], size, size))
    for k, columns in enumerate(block.own):
        for joint, row in columns:
            j = block.joints.index(joint)
            matrix[:, 2 * k, j], matrix[:, 2 * k + 1, j] = rows[row].real, rows[row].imag
    return matrix


def _factors(plane: Plane, rows: ComplexArray) -> list[Dyad | Array]:
    result: list[Dyad | Array] = []
    for block in plane.blocks:
        if len(block.loops) == 1:
            a, b = dyad_columns(block, rows)
            a = a.conj()
            scale = 1.0 / (a * b).imag
            result.append(Dyad(a * scale, b.conj() * -scale))
        else:
            result.append(block_matrix(block, rows))
    return result


def _solve(plane: Plane, rows: ComplexArray, factors: list[Dyad | Array], target: list[ComplexArray | None], x: Array) -> None:
    """Fill the passive rows of joint rates x (nv, n), so that they move every loop by ``target``, (n,) each, None for 0."""
    for block, factor in zip(plane.blocks, factors, strict=True):
        sides = []
        for loop, columns in zip(block.loops, block.known, strict=True):
            side = target[loop]
            for joint, row in columns:
                moved = rows[row] * x[joint]
                side = -moved if side is None else side - moved
            sides.append(np.zeros(rows.shape[1], complex) if side is None else side)
        if isinstance(factor, Dyad):
            x[block.joints[0]] = (factor.b * sides[0]).imag
            x[block.joints[1]] = (factor.a * sides[0]).imag
        else:
            right = np.stack([part for side in sides for part in (side.real, side.imag)], axis=1)
            x[list(block.joints)] = _solve_dense(factor, right).T


def _solve_dense(matrix: Array, right: Array) -> Array:
    """Solutions (n, m) of a stack of systems; NaN, not an exception, where one of them is singular."""
    try:
        return np.asarray(np.linalg.solve(matrix, right[:, :, None])[:, :, 0], dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.full_like(right, np.nan)


def _margins(plane: Plane, rows: ComplexArray) -> Array:
    """`Closure.margins` of every block."""
    margins = []
    for block in plane.blocks:
        matrix = block_matrix(block, rows)
        if not np.all(np.isfinite(matrix)):
            return np.full((len(plane.blocks), rows.shape[1]), np.nan)
        matrix = matrix / np.linalg.norm(matrix, axis=1, keepdims=True)
        margins.append(np.sign(np.linalg.det(matrix)) * np.linalg.svd(matrix, compute_uv=False)[:, -1])
    return np.array(margins).reshape(-1, rows.shape[1])
