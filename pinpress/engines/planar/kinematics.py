"""Closing a planar linkage at all crank angles at once, with the exact influence coefficients of every joint.

A loop's gap and the columns of its Jacobian are rows of one matrix product with the basis (see `model`). Blocks are solved in the order in
which they depend on each other. The joint rates x and y of a dyad close what opens at the rate c, a x + b y + c = 0 with complex a, b, c
and real x, y:

    x = Im(conj(b) c) / D,   y = -Im(conj(a) c) / D,   D = Im(conj(a) b)

What a joint of an earlier block adds to c is its column times its rate. The x and y that belong to a unit of this rate are the dyad's
*transfer* from that joint: with them rates, accelerations and efforts go from dyad to dyad as products of real numbers.

Where there are more equations than joints (a second rod to the same slide), the least-squares solution is taken: it fulfils all equations
if the redundant ones agree with the others, and if they do not, the gap shows it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ..engine import ACCEPTED, MOST_NEWTON_STEPS, PIECE, ClosedStates, Closure, Jacobian
from ..forces import RANK
from .model import Block, Plane, to_world

NO_SLIPS = np.empty((0, 1))


def close(plane: Plane, angle: Array, guess: Array, with_margins: bool = False) -> Closure:
    """Close all loops at crank angles (n,) to rounding, by Newton's method from guesses (nv, n).

    Where it fails, the gap of that configuration is large or not finite: the caller judges.
    """
    x = guess.copy()
    x[plane.driver] = angle
    count = len(plane.loop_heights)
    worst, steps = np.inf, 0
    with np.errstate(all="ignore"):  # a failed closure shows in its gap
        while True:
            basis = basis_at(plane, x)
            rows = product(plane.closure, basis)
            gaps = rows[:count]
            gap = np.sqrt(np.maximum.reduce((gaps.conj() * gaps).real, axis=0, initial=0.0))
            slips = plane.coupled @ x - plane.offsets[:, None] if len(plane.offsets) else NO_SLIPS
            if len(slips):
                gap = np.maximum(gap, np.abs(slips).max(axis=0))
            before, worst = worst, float(np.maximum.reduce(gap))
            # Rounding can leave a gap slightly above the tolerance: stop where another step no longer halves it.
            stalled = worst > 0.5 * before and worst < ACCEPTED * plane.tolerance
            if worst <= plane.tolerance or stalled or steps == MOST_NEWTON_STEPS or not np.isfinite(worst):
                break
            step = np.zeros_like(x)
            solve(plane, rows, factored(plane, rows), [*gaps, *slips], step)
            x += step
            steps += 1
        jacobian = Jacobian(rows, factored(plane, rows))
        first, second = _influence(plane, basis, jacobian)
        margins = _margins(plane, rows) if with_margins else None
    return Closure(x, first, second, gap, worst, steps, margins, basis, jacobian)


def influence(plane: Plane, basis: ComplexArray) -> tuple[Array, Array]:
    """First-order and second-order influence coefficients (nv, n) of closed configurations with this ``basis`` (nb, n)."""
    with np.errstate(all="ignore"):
        return _influence(plane, basis, jacobian_at(plane, basis))


def jacobian_at(plane: Plane, basis: ComplexArray) -> Jacobian:
    """The loop equations at configurations with this ``basis`` (nb, n)."""
    rows = product(plane.closure, basis)
    return Jacobian(rows, factored(plane, rows))


def _influence(plane: Plane, basis: ComplexArray, jacobian: Jacobian) -> tuple[Array, Array]:
    """Influence coefficients, given the loop equations at these configurations."""
    rows, factors = jacobian
    first, second = np.empty((2, len(plane.parents), basis.shape[1]))
    drive(plane, rows, factors, first)
    opened = _opened_by_turning(plane, basis, first)
    second[plane.driver] = 0.0
    solve(plane, rows, factors, [*opened, *[None] * len(plane.offsets)] if len(plane.offsets) else opened, second)
    return first, second


def _opened_by_turning(plane: Plane, basis: ComplexArray, v: Array) -> ComplexArray:
    """Second derivatives (nl, n) of the gaps by time at joint rates (nv, n) without accelerations."""
    if any(plane.guide_rotors):
        return np.asarray(product(plane.gap_rows, basis_acceleration(plane, basis, v, None)))
    spin = product(plane.turn, v)
    spin *= spin
    return np.asarray(product(plane.centripetal, basis[1 : 1 + len(plane.revolute)] * spin))


def moves(plane: Plane, drawn: Closure) -> bool:
    """Whether the driver moves a linkage in its closed drawn pose: redundant equations could contradict the motion that the others give."""
    if not plane.redundant:
        return True
    rate = basis_velocity(plane, basis_at(plane, drawn.position), drawn.first)
    opened = product(plane.gap_rows, rate), plane.coupled @ drawn.first
    return all(np.abs(each).max(initial=0.0) <= RANK * plane.size for each in opened)


def basis_at(plane: Plane, x: Array) -> ComplexArray:
    """The basis (nb, n) of joint coordinates (nv, n)."""
    turning = len(plane.revolute)
    basis = np.empty((1 + len(x), x.shape[1]), complex)
    basis[0] = 1.0
    absolute, rotors = product(plane.turn, x), basis[1 : 1 + turning]
    np.cos(absolute, out=rotors.real)
    np.sin(absolute, out=rotors.imag)
    for row, joint, rotor in plane.guides:
        basis[row] = x[joint] * basis[rotor] if rotor else x[joint]
    return basis


def known_basis(states: ClosedStates) -> ComplexArray:
    """The basis (nb, n) of states that carry it."""
    assert states.basis is not None
    return states.basis


def openings(plane: Plane, x: Array) -> Array:
    """Gaps (nl, 3) of the loops at joint coordinates (nv,), point 2 less point 1 in world axes [m]."""
    return to_world(plane, product(plane.gap_rows, basis_at(plane, x[:, None]))[:, 0])


def gaps(plane: Plane, x: Array, basis: ComplexArray) -> Array:
    """Largest gap (n,) of a loop or coupling at joint coordinates (nv, n) with their basis (nb, n) [m]."""
    widest: Array = np.abs(product(plane.gap_rows, basis)).max(axis=0, initial=0.0)
    return np.asarray(np.maximum(widest, np.abs(plane.coupled @ x - plane.offsets[:, None]).max(axis=0, initial=0.0)))


def basis_velocity(plane: Plane, basis: ComplexArray, v: Array) -> ComplexArray:
    """First time derivative (nb, n) of the basis at joint rates (nv, n)."""
    turning = len(plane.revolute)
    rate = np.empty_like(basis)
    rate[0] = 0.0
    spin = product(plane.turn, v)
    np.multiply(basis[1 : 1 + turning], 1j * spin, out=rate[1 : 1 + turning])
    for row, joint, rotor in plane.guides:
        rate[row] = v[joint] * basis[rotor] + 1j * spin[rotor - 1] * basis[row] if rotor else v[joint]
    return rate


def basis_acceleration(plane: Plane, basis: ComplexArray, v: Array, a: Array | None) -> ComplexArray:
    """Second time derivative (nb, n) of the basis at joint rates and accelerations (nv, n); without ``a`` only its centripetal and Coriolis
    part."""
    turning = slice(1, 1 + len(plane.revolute))
    result = np.empty(basis.shape, complex)
    result[0] = 0.0
    spin, factor = product(plane.turn, v), result[turning]
    np.multiply(spin, -spin, out=factor.real)
    factor.imag = 0.0 if a is None else product(plane.turn, a)
    for row, joint, rotor in plane.guides:
        along = 0.0 if a is None else a[joint]
        if rotor:
            result[row] = (along + 2j * spin[rotor - 1] * v[joint]) * basis[rotor] + factor[rotor - 1] * basis[row]
        else:
            result[row] = along
    factor *= basis[turning]
    return result


def dyad_columns(block: Block, rows: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """The Jacobian's two columns (n,) of a dyad."""
    (_, a), (_, b) = block.own[0]
    return rows[a], rows[b]


def block_matrix(plane: Plane, block: Block, rows: ComplexArray) -> Array:
    """Jacobian (n, equations, joints) of a block; its rows are the real and imaginary part of every loop, then the couplings."""
    loops = 2 * len(block.loops)
    matrix = np.zeros((rows.shape[1], loops + len(block.couplings), len(block.joints)))
    for k, columns in enumerate(block.own):
        for joint, row in columns:
            j = block.joints.index(joint)
            matrix[:, 2 * k, j], matrix[:, 2 * k + 1, j] = rows[row].real, rows[row].imag
    for row, k in enumerate(block.couplings, loops):
        matrix[:, row] = [plane.coupling_rows[k].get(joint, 0.0) for joint in block.joints]
    return matrix


class DyadFactor(NamedTuple):
    """The loop equation of a dyad at n configurations, ready to be solved; the terms are those of the module.

    Attributes:
        loop: index of the loop.
        pair: its two joints.
        inverse: (2, n) conj(b) / D and -conj(a) / D.
        transfers: the joints of earlier blocks that move the loop, with the dyad's transfer (2, n) from each.
        driven: (2, n) the transfer from the driver; None where the driver does not move the loop.
    """

    loop: int
    pair: slice
    inverse: ComplexArray
    transfers: list[tuple[int, Array]]
    driven: Array | None


class Solvable(NamedTuple):
    """The equations of a block that is no dyad at n configurations, ready to be solved.

    Attributes:
        block: the block.
        matrix: -conj(a) / |a|^2 of a lever with column a, the coefficient of a gear's coupling, the matrix of a dense block.
    """

    block: Block
    matrix: Any


Factor = DyadFactor | Solvable
Opening = Sequence[ComplexArray | Array | None] | ComplexArray
"""Rate (n,) at which the gap of every loop would open, complex, then that of every coupling; None for zero."""


def factored(plane: Plane, rows: ComplexArray) -> tuple[Factor, ...]:
    """The equations of all blocks, ready to be solved."""
    inverses = _inverses(plane, rows)
    result: list[Factor] = []
    for block in plane.blocks:
        if block.kind == "dyad":
            inverse, loop, driven = next(inverses), block.loops[0], None
            if (row := plane.driven[loop]) is not None:
                driven = (inverse * rows[row]).imag
            transfers = [(joint, (inverse * rows[row]).imag) for joint, row in block.known[0]]
            result.append(DyadFactor(loop, block.pair, inverse, transfers, driven))
        elif block.kind == "lever":
            a = rows[block.own[0][0][1]]
            result.append(Solvable(block, a.conj() / -(a.real * a.real + a.imag * a.imag)))
        elif block.kind == "gear":
            result.append(Solvable(block, plane.coupling_rows[block.couplings[0]][block.joints[0]]))
        else:
            result.append(Solvable(block, block_matrix(plane, block, rows)))
    return tuple(result)


def _inverses(plane: Plane, rows: ComplexArray) -> Iterator[ComplexArray]:
    """`DyadFactor.inverse` of all dyads, found for as many at a time as stay in the cache."""
    together = max(1, PIECE // rows.shape[1])
    for start in range(0, len(plane.dyad_columns), together):
        columns = rows.take(plane.dyad_columns[start : start + together], axis=0)  # b and a
        inverses = columns.conj()
        determinants = (inverses[:, ::-1] * columns).imag  # D and -D
        inverses *= 1.0 / determinants
        for place in range(len(inverses)):  # iterating over an array ends with a costly IndexError
            yield inverses[place]


def drive(plane: Plane, rows: ComplexArray, factors: Sequence[Factor], x: Array) -> None:
    """Fill in the rates (nv, n) of the passive joints while the driver moves at the rate 1. Arguments as of `solve`."""
    driven: Opening | None = None
    x[plane.driver] = 1.0
    for factor in factors:
        if isinstance(factor, DyadFactor):
            _add_transfers(factor, factor.driven, x)
        else:
            driven = driven or _opened_by_driver(plane, rows)
            _solve_block(plane, rows, factor, driven, x)


def _opened_by_driver(plane: Plane, rows: ComplexArray) -> Opening:
    """The rates at which all gaps open while the driver moves at the rate 1."""
    gears = [np.full(rows.shape[1], gear.get(plane.driver, 0.0)) for gear in plane.coupling_rows]
    return [*(None if row is None else rows[row] for row in plane.driven), *gears]


def solve(plane: Plane, rows: ComplexArray, factors: Sequence[Factor], opening: Opening, x: Array) -> None:
    """Fill in the rates of the passive joints that keep loops and couplings closed.

    Args:
        plane: constants of the linkage.
        rows: rows of `Plane.closure` at the configurations.
        factors: what `factored` made of them.
        opening: the rates at which all gaps would open. The driver's part is in them.
        x: (nv, n) joint rates to be filled in.
    """
    for factor in factors:
        if isinstance(factor, DyadFactor):
            opened = opening[factor.loop]
            _add_transfers(factor, None if opened is None else (factor.inverse * opened).imag, x)
        else:
            _solve_block(plane, rows, factor, opening, x)


def _add_transfers(dyad: DyadFactor, rates: Array | None, x: Array) -> None:
    """Fill in the rates of a dyad's joints: these (2, n), and what the joints of earlier blocks add."""
    for joint, transfer in dyad.transfers:
        moved = transfer * x[joint]
        rates = moved if rates is None else np.add(rates, moved, out=moved)
    x[dyad.pair] = 0.0 if rates is None else rates


def _solve_block(plane: Plane, rows: ComplexArray, factor: Solvable, opening: Opening, x: Array) -> None:
    """`solve` of one block that is no dyad."""
    block, matrix = factor
    sides = []
    for loop, columns in zip(block.loops, block.known, strict=True):
        side = opening[loop]
        for joint, row in columns:
            moved = rows[row] * x[joint]
            side = moved if side is None else side + moved
        sides.append(np.zeros(rows.shape[1], complex) if side is None else side)
    if block.kind == "lever":
        x[block.joints[0]] = (matrix * sides[0]).real
        return
    parts = [part for side in sides for part in (side.real, side.imag)]
    parts += [_slip(plane, block, k, opening[len(plane.loop_heights) + k], x) for k in block.couplings]
    if block.kind == "gear":
        x[block.joints[0]] = parts[0] / -matrix
    elif block.joints:
        x[list(block.joints)] = _solve_dense(matrix, -np.stack(parts, axis=1)).T


def _slip(plane: Plane, block: Block, coupling: int, opening: Array | ComplexArray | None, x: Array) -> Array:
    """The rate (n,) at which a coupling opens, with what the joints of earlier blocks add."""
    side = np.zeros(x.shape[1]) if opening is None else opening.real
    for joint, by in plane.coupling_rows[coupling].items():
        if joint not in block.joints and joint != plane.driver:
            side = side + by * x[joint]
    return side


def _solve_dense(matrix: Array, right: Array) -> Array:
    """Solutions (n, m) of n systems, by least squares where there are more equations than joints; all NaN where one of them is singular."""
    try:
        if matrix.shape[1] > matrix.shape[2]:
            orthogonal, matrix = np.linalg.qr(matrix)
            right = (orthogonal.transpose(0, 2, 1) @ right[:, :, None])[:, :, 0]
        return np.asarray(np.linalg.solve(matrix, right[:, :, None])[:, :, 0], dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.full((len(matrix), matrix.shape[2]), np.nan)


def _margins(plane: Plane, rows: ComplexArray) -> Array:
    """`Closure.margins` of every block; those of a block with redundant equations, which has no determinant, are positive."""
    margins = []
    for block in plane.blocks:
        if block.kind == "dyad":
            margins.append(_dyad_margin(*dyad_columns(block, rows)))
            continue
        matrix = block_matrix(plane, block, rows)
        if not np.all(np.isfinite(matrix)):
            return np.full((len(plane.blocks), rows.shape[1]), np.nan)
        if not block.joints:
            margins.append(np.ones(rows.shape[1]))
            continue
        lengths = np.linalg.norm(matrix, axis=1, keepdims=True)
        matrix = matrix / np.where(lengths == 0.0, 1.0, lengths)
        sign = np.ones(rows.shape[1]) if block.redundant else np.sign(np.linalg.det(matrix))
        margins.append(sign * np.linalg.svd(matrix, compute_uv=False)[:, -1])
    return np.array(margins).reshape(-1, rows.shape[1])


def _dyad_margin(a: ComplexArray, b: ComplexArray) -> Array:
    """The margin (n,) of a dyad with columns a and b (n,).

    Two columns of unit length whose angle has the cosine c have the singular values sqrt(1 + |c|) and sqrt(1 - |c|). Their product is the
    determinant, which gives the smaller one without cancellation.
    """
    between = a.conj() * b
    length = np.abs(between)
    length[length == 0.0] = 1.0
    return np.asarray(between.imag / length / np.sqrt(1.0 + np.abs(between.real) / length))
