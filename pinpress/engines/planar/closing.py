"""Newton's method for the loops of a planar linkage, at all crank angles at once, and the exact influence coefficients of every joint.

A Newton step, the rates and the accelerations of the joints solve the same linear equations with different right-hand sides: the gaps, the
rate of the driver, and the centripetal and Coriolis accelerations of the gaps. `Slopes` solves them block by block, in absolute
coordinates, in an order in which no block depends on a later one (see `equations`). A coordinate of an earlier block opens a loop at the
slope of the gap by this coordinate times the rate of the coordinate; this goes to the right-hand side.

A block can have more equations than joints (a second rod to the same slide). It then gets the least-squares solution. This solution fulfils
all equations if the redundant ones agree with the others. If they do not agree, a gap remains.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ..engine import MOST_NEWTON_STEPS, Closure
from ..structure import ZERO
from .equations import BlockRows, Configurations, Equations, configurations_at, efforts_of_relation, matrix_of, slope, slopes_of_dyad
from .kinematics import basis_acceleration, basis_at, basis_velocity
from .model import Plane

NO_SLIPS = np.empty((0, 1))  # errors of the relations of a linkage without relations
EarlierSlopes = tuple[tuple[int, ComplexArray], ...]
"""Rows of coordinates of earlier blocks, each with the slope (n,) of a loop's gap by it."""
Opening = Sequence[ComplexArray | Array | None] | ComplexArray
"""Right-hand side: the complex rate (n,) at which the gap of every loop opens, then the real one of every relation; None is zero."""


def close(equations: Equations, angle: Array, guess: Array, with_margins: bool = False) -> Closure:
    """Close all loops at crank angles (n,) to rounding, by Newton's method from guesses (nv, n).

    It never raises. Where the method fails, the gap of that configuration is large or not finite; the caller checks it.
    """
    plane, x = equations.functions.plane, guess.copy()
    x[plane.driver] = angle
    widest, steps = np.inf, 0
    with np.errstate(all="ignore"):  # a division by zero gives a gap that is not finite
        while True:
            basis = basis_at(plane, x)
            gaps = product(plane.gap_rows, basis)
            gap = np.sqrt(np.maximum.reduce((gaps.conj() * gaps).real, axis=0, initial=0.0))
            # errors of the relations
            slips = product(plane.relation_slopes, x) - plane.offsets[:, None] if len(plane.offsets) else NO_SLIPS
            if len(slips):
                gap = np.maximum(gap, np.abs(slips).max(axis=0))
            previous, widest = widest, float(np.maximum.reduce(gap))
            # Rounding can leave a gap slightly above that of rounding. Stop if a step did not halve such a gap.
            stalls = widest > 0.5 * previous and widest < plane.tolerance
            if widest <= plane.rounding or stalls or steps == MOST_NEWTON_STEPS or not np.isfinite(widest):
                break
            # A Newton step solves the equations of the rates, with the gaps as the right-hand side.
            x += Slopes.at(equations, basis, x).solve([*gaps, *slips])
            steps += 1
        slopes = Slopes.at(equations, basis, x)
        first, second = _compute_influence(basis, slopes)
        margins = slopes.margins() if with_margins else None
    return Closure(x, first, second, gap, widest, steps, margins, basis)


def influence(equations: Equations, basis: ComplexArray, position: Array) -> tuple[Array, Array]:
    """First-order and second-order influence coefficients (nv, n) of closed configurations.

    Args:
        equations: the equations.
        basis: (nb, n) the basis of the configurations.
        position: (nv, n) their joint coordinates.
    """
    with np.errstate(all="ignore"):
        return _compute_influence(basis, Slopes.at(equations, basis, position))


def _compute_influence(basis: ComplexArray, slopes: Slopes) -> tuple[Array, Array]:
    """The influence coefficients (nv, n) from the slopes at closed configurations."""
    plane, first = slopes.equations.functions.plane, slopes.drive()
    # The centripetal and Coriolis accelerations (nl, n) of the gaps. Only a guide that turns has a Coriolis acceleration.
    if any(plane.guide_rotors):
        gap_accelerations = product(plane.gap_rows, basis_acceleration(plane, basis, first, None))
    else:
        spin = product(plane.turn, first)
        gap_accelerations = product(plane.centripetal, basis[1 : 1 + len(plane.revolute)] * (spin * spin))
    return first, slopes.solve([*gap_accelerations, *[None] * len(plane.offsets)])  # those of relations are zero


def can_move(plane: Plane, drawn: Closure) -> bool:
    """Whether the driver can move the linkage in its closed drawn pose.

    Without redundant equations it can. Redundant ones must allow the rates that the least-squares solution gives.
    """
    if not plane.redundant:
        return True
    basis_rate = basis_velocity(plane, basis_at(plane, drawn.position), drawn.first)
    opening_rates = product(plane.gap_rows, basis_rate), product(plane.relation_slopes, drawn.first)
    return all(np.abs(each).max(initial=0.0) <= ZERO * plane.size for each in opening_rates)


# ------------------------------------------------------------------------------------------------------------------------------- solving


class Slopes(NamedTuple):
    """The derivatives of all gaps by the absolute coordinates (the Jacobian) at n configurations, and the solution of the rates.

    Attributes:
        equations: the equations.
        configurations: the configurations, with the inverses of dyads and levers and the matrices of all other blocks.
        earlier: by block and loop the coordinates of earlier blocks that move the loop, each with the slope (n,) of the loop's gap by it.
    """

    equations: Equations
    configurations: Configurations
    earlier: tuple[tuple[EarlierSlopes, ...], ...]

    @staticmethod
    def at(equations: Equations, basis: ComplexArray, position: Array) -> Slopes:
        """The slopes at n configurations with the basis (nb, n) and the joint coordinates ``position`` (nv, n)."""
        configurations = configurations_at(equations, basis, position)
        earlier = tuple(
            tuple(tuple((row, slope(terms, configurations.functions)) for row, terms in loop.earlier_slopes) for loop in block.loops)
            for block in equations.blocks
        )
        return Slopes(equations, configurations, earlier)

    def drive(self) -> Array:
        """The rates (nv, n) of all joints while the driver moves at the rate 1."""
        plane = self.equations.functions.plane
        return self._solve_rates([None] * (len(plane.loop_heights) + len(plane.offsets)), 1.0)

    def solve(self, opening: Opening) -> Array:
        """The rates (nv, n) of the joints that close what opens at the rates ``opening``, while the driver rests."""
        return self._solve_rates(opening, 0.0)

    def _solve_rates(self, opening: Opening, driver_rate: float) -> Array:
        """The rates (nv, n) of the joints that close what opens, while the driver moves at a rate."""
        functions, plane = self.equations.functions, self.equations.functions.plane
        driver, n = functions.rows[plane.driver], len(self.configurations.functions[0])
        rates: list[Array | float] = [0.0] * functions.count  # of absolute coordinates, by rows; floats until a block determines them
        rates[driver] = driver_rate * float(plane.sense[plane.driver] or 1.0)
        for place, block in enumerate(self.equations.blocks):
            right_sides = []
            for loop, earlier in zip(block.loops, self.earlier[place], strict=True):
                total = opening[loop.loop]
                for row, gap_slope in earlier:
                    if isinstance(rates[row], np.ndarray) or rates[row]:  # skip rates that are the float zero
                        total = gap_slope * rates[row] if total is None else total + gap_slope * rates[row]
                right_sides.append(np.zeros(n, complex) if total is None else total)
            if block.has_inverses:
                for row in block.rows:
                    rates[row] = (right_sides[0] * self.configurations.inverses[row]).real
            elif block.rows:
                parts = [part for total in right_sides for part in (total.real, total.imag)]
                parts += [self._compute_slip_rate(block, k, opening[len(plane.loop_heights) + k], rates, n) for k in block.relations]
                for row, rate in zip(block.rows, _solve_dense(self.configurations.slopes[place], -np.stack(parts, axis=1)).T, strict=True):
                    rates[row] = rate
            for rider, rotor in block.riding:
                if rider == driver and rider not in functions.guides:  # from here on the absolute rate of a driver that rides
                    rates[driver] = rates[driver] + rates[rotor]
        # from absolute rates to those of the joints
        result = np.empty((len(functions.rows), n))
        for joint, (row, outer) in enumerate(zip(functions.rows, functions.outer, strict=True)):
            rate = rates[row] if outer is None else rates[row] - rates[outer]
            result[joint] = -rate if plane.sense[joint] < 0.0 else rate
        result[plane.driver] = driver_rate
        return result

    def _compute_slip_rate(
        self, block: BlockRows, relation: int, opening: Array | ComplexArray | None, rates: Sequence[Array | float], n: int
    ) -> Array:
        """The rate (n,) at which a relation opens, with what the coordinates of earlier blocks add.

        The slope of a relation by a coordinate is the effort of its unit multiplier there (virtual work).
        """
        total = np.zeros(n) if opening is None else opening.real
        for row, coefficient in efforts_of_relation(self.equations.functions, relation):
            if row not in block.rows:
                total = total + coefficient * rates[row]
        return total

    def margins(self) -> Array:
        """`Closure.margins` of every block. A block with redundant equations has no determinant: its margins are positive."""
        margins, n = [], len(self.configurations.functions[0])
        for place, block in enumerate(self.equations.blocks):
            if block.has_inverses and not block.redundant:
                margins.append(_dyad_margin(*slopes_of_dyad(block, self.configurations.functions)))
                continue
            if not block.rows:  # it determines no joint, and so is never singular
                margins.append(np.ones(n))
                continue
            matrix = (
                matrix_of(self.equations, block, self.configurations.functions) if block.has_inverses else self.configurations.slopes[place]
            )
            if not np.all(np.isfinite(matrix)):
                return np.full((len(self.equations.blocks), n), np.nan)
            lengths = np.linalg.norm(matrix, axis=1, keepdims=True)
            matrix = matrix / np.where(lengths == 0.0, 1.0, lengths)
            sign = np.ones(n) if block.redundant else np.sign(np.linalg.det(matrix))
            margins.append(sign * np.linalg.svd(matrix, compute_uv=False)[:, -1])
        return np.array(margins).reshape(-1, n)


def _solve_dense(matrix: Array, right: Array) -> Array:
    """The solutions (n, m) of n systems of equations, by least squares if there are more equations than joints.

    If one matrix is singular, all solutions are NaN; with 1 x 1 matrices only the solution of that one is not finite.
    """
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

    Scale both columns to unit length; c is the cosine of the angle between them. The singular values are sqrt(1 + |c|) and sqrt(1 - |c|),
    and their product is the absolute determinant. The determinant divided by the larger one is the smaller one without cancellation.
    """
    product_ab = a.conj() * b  # real part: scalar product of the columns, imaginary part: determinant
    lengths = np.abs(product_ab)
    lengths[lengths == 0.0] = 1.0
    return np.asarray(product_ab.imag / lengths / np.sqrt(1.0 + np.abs(product_ab.real) / lengths))
