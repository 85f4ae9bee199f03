"""Closing a planar linkage at all crank angles at once by Newton's method, with the exact influence coefficients of every joint.

Blocks are solved in the order in which they depend on each other, in absolute coordinates (see `equations`). What a coordinate of an
earlier block adds to the rate at which a loop opens is its slope times its rate.

Where there are more equations than joints (a second rod to the same slide), the least-squares solution is taken: it fulfils all equations
if the redundant ones agree with the others, and if they do not, the gap shows it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ..engine import ACCEPTED, MOST_NEWTON_STEPS, Closure
from ..rank import RANK
from .equations import BlockRows, Equations, Pose, efforts_of_coupling, matrix_of, pose_at, slope, slopes_of_dyad
from .kinematics import basis_acceleration, basis_at, basis_velocity
from .model import Plane

NO_SLIPS = np.empty((0, 1))
Moved = tuple[tuple[int, ComplexArray], ...]
Opening = Sequence[ComplexArray | Array | None] | ComplexArray
"""Rate (n,) at which the gap of every loop would open, complex, then that of every coupling; None for zero."""


def close(equations: Equations, angle: Array, guess: Array, with_margins: bool = False) -> Closure:
    """Close all loops at crank angles (n,) to rounding, by Newton's method from guesses (nv, n).

    Where it fails, the gap of that configuration is large or not finite: the caller judges.
    """
    plane, x = equations.functions.plane, guess.copy()
    x[plane.driver] = angle
    worst, steps = np.inf, 0
    with np.errstate(all="ignore"):  # a failed closure shows in its gap
        while True:
            basis = basis_at(plane, x)
            gaps = product(plane.gap_rows, basis)
            gap = np.sqrt(np.maximum.reduce((gaps.conj() * gaps).real, axis=0, initial=0.0))
            slips = plane.coupled @ x - plane.offsets[:, None] if len(plane.offsets) else NO_SLIPS
            if len(slips):
                gap = np.maximum(gap, np.abs(slips).max(axis=0))
            before, worst = worst, float(np.maximum.reduce(gap))
            # Rounding can leave a gap slightly above the tolerance: stop where another step no longer halves it.
            stalled = worst > 0.5 * before and worst < ACCEPTED * plane.tolerance
            if worst <= plane.tolerance or stalled or steps == MOST_NEWTON_STEPS or not np.isfinite(worst):
                break
            x += Slopes.at(equations, basis, x).solve([*gaps, *slips])
            steps += 1
        slopes = Slopes.at(equations, basis, x)
        first, second = _influence(basis, slopes)
        margins = slopes.margins() if with_margins else None
    return Closure(x, first, second, gap, worst, steps, margins, basis)


def influence(equations: Equations, basis: ComplexArray, position: Array) -> tuple[Array, Array]:
    """First-order and second-order influence coefficients (nv, n) of closed configurations with this ``basis`` (nb, n) and these joint
    coordinates (nv, n)."""
    with np.errstate(all="ignore"):
        return _influence(basis, Slopes.at(equations, basis, position))


def _influence(basis: ComplexArray, slopes: Slopes) -> tuple[Array, Array]:
    """Influence coefficients, given the slopes of these configurations."""
    plane, first = slopes.equations.functions.plane, slopes.drive()
    opened = _opened_by_turning(plane, basis, first)
    return first, slopes.solve([*opened, *[None] * len(plane.offsets)])


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


# ------------------------------------------------------------------------------------------------------------------------------- solving


class Slopes(NamedTuple):
    """The slopes of all equations at n configurations, ready to be solved.

    Attributes:
        equations: the equations.
        pose: the configurations, with the inverses of dyads and levers.
        moved: by block and loop the coordinates of earlier blocks that move it, and its slopes (n,) by them.
    """

    equations: Equations
    pose: Pose
    moved: tuple[tuple[Moved, ...], ...]

    @staticmethod
    def at(equations: Equations, basis: ComplexArray, position: Array) -> Slopes:
        """The slopes at configurations with this ``basis`` (nb, n) and these joint coordinates (nv, n)."""
        pose = pose_at(equations, basis, position)
        moved = tuple(
            tuple(tuple((row, slope(terms, pose.functions)) for row, terms in loop.moved) for loop in block.loops)
            for block in equations.blocks
        )
        return Slopes(equations, pose, moved)

    def drive(self) -> Array:
        """The rates (nv, n) of all joints while the driver moves at the rate 1."""
        plane = self.equations.functions.plane
        return self._rates([None] * (len(plane.loop_heights) + len(plane.offsets)), 1.0)

    def solve(self, opening: Opening) -> Array:
        """The rates (nv, n) of the joints that keep loops and couplings closed that would open at these rates while the driver rests."""
        return self._rates(opening, 0.0)

    def _rates(self, opening: Opening, driver_rate: float) -> Array:
        functions, plane = self.equations.functions, self.equations.functions.plane
        driver, n = functions.rows[plane.driver], len(self.pose.functions[0])
        rates: list[Array | float] = [0.0] * functions.count
        rates[driver] = driver_rate * float(plane.sense[plane.driver] or 1.0)
        for place, block in enumerate(self.equations.blocks):
            sides = []
            for loop, moved in zip(block.loops, self.moved[place], strict=True):
                side = opening[loop.loop]
                for row, by in moved:
                    if isinstance(rates[row], np.ndarray) or rates[row]:
                        side = by * rates[row] if side is None else side + by * rates[row]
                sides.append(np.zeros(n, complex) if side is None else side)
            if block.closed:
                for row in block.rows:
                    rates[row] = (sides[0] * self.pose.inverses[row]).real
            elif block.rows:
                parts = [part for side in sides for part in (side.real, side.imag)]
                parts += [self._slip(block, k, opening[len(plane.loop_heights) + k], rates, n) for k in block.couplings]
                for row, rate in zip(block.rows, _solve_dense(self.pose.slopes[place], -np.stack(parts, axis=1)).T, strict=True):
                    rates[row] = rate
            for rider, rotor in block.riding:
                if rider == driver and rider not in functions.guides:
                    rates[driver] = rates[driver] + rates[rotor]
        result = np.empty((len(functions.rows), n))
        for joint, (row, outer) in enumerate(zip(functions.rows, functions.outer, strict=True)):
            rate = rates[row] if outer is None else rates[row] - rates[outer]
            result[joint] = -rate if plane.sense[joint] < 0.0 else rate
        result[plane.driver] = driver_rate
        return result

    def _slip(self, block: BlockRows, coupling: int, opening: Array | ComplexArray | None, rates: Sequence[Array | float], n: int) -> Array:
        """The rate (n,) at which a coupling opens, with what the coordinates of earlier blocks add."""
        side = np.zeros(n) if opening is None else opening.real
        for row, by in efforts_of_coupling(self.equations.functions, coupling):
            if row not in block.rows:
                side = side + by * rates[row]
        return side

    def margins(self) -> Array:
        """`Closure.margins` of every block; those of a block with redundant equations, which has no determinant, are positive."""
        margins, n = [], len(self.pose.functions[0])
        for place, block in enumerate(self.equations.blocks):
            if block.closed and not block.redundant:
                margins.append(_dyad_margin(*slopes_of_dyad(block, self.pose.functions)))
                continue
            if not block.rows:
                margins.append(np.ones(n))
                continue
            matrix = matrix_of(self.equations, block, self.pose.functions) if block.closed else self.pose.slopes[place]
            if not np.all(np.isfinite(matrix)):
                return np.full((len(self.equations.blocks), n), np.nan)
            lengths = np.linalg.norm(matrix, axis=1, keepdims=True)
            matrix = matrix / np.where(lengths == 0.0, 1.0, lengths)
            sign = np.ones(n) if block.redundant else np.sign(np.linalg.det(matrix))
            margins.append(sign * np.linalg.svd(matrix, compute_uv=False)[:, -1])
        return np.array(margins).reshape(-1, n)


def _solve_dense(matrix: Array, right: Array) -> Array:
    """Solutions (n, m) of n systems, by least squares where there are more equations than joints; all NaN where one of them is singular."""
    if matrix.shape[1:] == (1, 1):
        return right / matrix[:, 0]
    try:
        if matrix.shape[1] > matrix.shape[2]:
            orthogonal, matrix = np.linalg.qr(matrix)
            right = (orthogonal.transpose(0, 2, 1) @ right[:, :, None])[:, :, 0]
        return np.asarray(np.linalg.solve(matrix, right[:, :, None])[:, :, 0], dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.full((len(matrix), matrix.shape[2]), np.nan)


def _dyad_margin(a: ComplexArray, b: ComplexArray) -> Array:
    """The margin (n,) of a dyad with columns a and b (n,).

    Two columns of unit length whose angle has the cosine c have the singular values sqrt(1 + |c|) and sqrt(1 - |c|). Their product is the
    determinant, which gives the smaller one without cancellation.
    """
    between = a.conj() * b
    length = np.abs(between)
    length[length == 0.0] = 1.0
    return np.asarray(between.imag / length / np.sqrt(1.0 + np.abs(between.real) / length))
