"""A planar linkage whose equations are a chain of dyads, closed at all crank angles at once without iteration.

Most press linkages are a driver and dyads one after the other (`dyads`). Then positions and rates follow from a root for each dyad: there
is no guess, no table of the branch, no sine but those of the driver. Shafts on the frame that are geared to the driver turn with it,
and levers, such as a second rod to the same slide, follow the links at both their ends. `find_chain` says whether a linkage is such a
chain along its branch, and compares the closed form there with Newton's method. `closing.close` closes all other linkages, and motions
beyond change points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ..branch import SUBDIVISION, Branch, nodes_before, predict
from ..engine import ClosedStates
from . import closing
from .dyads import ONE, ZERO, ChainMotion, Dyad, Guide, GuidedLink, I, Lever, SwingingGuide, TwoGuides, TwoLinks
from .equations import Equations, nonzero
from .functions import Functions
from .model import Plane

CLEAR = 1e-3  # smallest margin of a dyad's equations, see `Closure.margins`: nearer to a dead centre Newton's method closes
PIECE, SMALLEST_PIECE = 7200, 900  # most states that are worked through at a time, and those below which calls would take most of it
IN_CACHE = 40_000  # states times dyads whose arrays stay in the cache


class Equation(NamedTuple):
    """The loop that a dyad closes: ``constant`` + sum(coefficient * function) = 0.

    Attributes:
        loop: index of the loop.
        constant: what does not move [m]; None if it is zero.
        terms: rows and coefficients of the functions of the driver and of earlier dyads.
        dyad: the dyad, or a lever.
    """

    loop: int
    constant: ComplexArray | None
    terms: tuple[tuple[int, ComplexArray], ...]
    dyad: Dyad


class Gear(NamedTuple):
    """A shaft on the frame that gears turn with the driver.

    Attributes:
        joint: its joint.
        relation: index of the relation that determines it.
        row: row of its rotor.
        sense: `Plane.sense` of the joint.
        ratio: its angle by that of the driver.
        offset: its angle where that of the driver is zero [rad].
    """

    joint: int
    relation: int
    row: int
    sense: float
    ratio: float
    offset: float


@dataclass(frozen=True, eq=False, repr=False)
class Chain:
    """Constants of a chain of dyads.

    Attributes:
        plane: the linkage.
        functions: rows of its functions.
        driver: row of the driver.
        gears: the shafts that are geared to the driver, each behind the one that turns it.
        equations: the loops in the order in which they are closed.
        rate_rows: rows of the functions whose rates later dyads need.
        winding: rows of the rotors that make turns along the branch, beside those of the driver and of geared shafts.
        low: smallest crank angle at which the closed form can be used [rad or m].
        high: largest such crank angle [rad or m].
    """

    plane: Plane
    functions: Functions
    driver: int
    gears: tuple[Gear, ...]
    equations: tuple[Equation, ...]
    rate_rows: frozenset[int]
    winding: tuple[int, ...] = ()
    low: float = -np.inf
    high: float = np.inf

    @cached_property
    def turns(self) -> bool:
        """Whether the driver turns, then about the plane's normal, or slides."""
        return bool(self.plane.sense[self.plane.driver])

    @cached_property
    def piece(self) -> int:
        """Number of states that are worked through at a time: fewer in long chains."""
        return min(PIECE, max(SMALLEST_PIECE, IN_CACHE // len(self.equations)))


def close(chain: Chain, angle: Array, basis: ComplexArray) -> ChainMotion:
    """Close the chain at crank angles (n,), at which its dyads reach, while the driver moves at the rate 1, and fill in the ``basis``
    (nb, n)."""
    basis[0] = 1.0
    blank: list[Any] = [None] * chain.functions.count
    motion = ChainMotion(chain.rate_rows, [basis[place] for place in chain.functions.places], {}, {}, blank, blank.copy(), blank.copy())
    _fill_driver(chain, angle, motion)
    for _, constant, ((row, by), *others), dyad in chain.equations:
        side, opening, inward = motion.functions[row] * by, motion.rates[row] * by, motion.inward[row] * by
        for row, by in others:
            side += motion.functions[row] * by
            opening += motion.rates[row] * by
            inward += motion.inward[row] * by
        if constant is not None:
            side += constant
        dyad.close(side, opening, inward, motion)
    return motion


def _fill_driver(chain: Chain, angle: Array, motion: ChainMotion) -> None:
    """Fill in the driver."""
    row, function = chain.driver, motion.functions[chain.driver]
    motion.speeds[row], motion.decelerations[row] = ONE, ZERO
    if chain.turns:
        np.cos(angle, function.real)
        np.sin(angle, function.imag)
        motion.rates[row] = function * I
        motion.inward[row] = function.copy()
    else:
        function.real, function.imag = angle, 0.0
        motion.ways[row], motion.inward[row] = angle, np.zeros(angle.shape, complex)
        motion.rates[row] = np.ones(angle.shape, complex)
    for gear in chain.gears:
        row, speed = gear.row, gear.sense * gear.ratio
        rotor = motion.functions[row]
        if speed == -1.0 and not gear.offset:  # a mirrored pair
            np.conjugate(function, rotor)
        else:
            turned_by = gear.sense * (gear.ratio * angle + gear.offset)
            np.cos(turned_by, rotor.real)
            np.sin(turned_by, rotor.imag)
        motion.speeds[row], motion.decelerations[row] = np.array(speed), ZERO
        motion.rates[row] = rotor * np.array(1j * speed)
        motion.inward[row] = rotor * np.array(speed * speed)


# ------------------------------------------------------------------------------------------------------------------ joints along the branch


def states_along(
    chain: Chain, branch: Branch, angle: Array, speed: Array | float, acceleration: Array | float
) -> tuple[ClosedStates, Array]:
    """The states of a chain at crank angles (n,) of its branch, and the largest gap (n,) of a loop in each [m]; in pieces that stay in the
    cache.

    Args:
        chain: the chain.
        branch: its branch.
        angle: (n,) crank angles [rad or m].
        speed: of the driver, (n,) or one number [rad/s or m/s].
        acceleration: of the driver, (n,) or 0.0 [rad/s2 or m/s2].
    """
    n = len(angle)
    position, v, a = np.empty((3, len(chain.plane.parents), n))
    basis: ComplexArray = np.empty((len(chain.functions.order), n), complex)
    gap = np.empty(n)
    size = -(-n // -(-n // chain.piece))  # of equal pieces
    for start in range(0, n, size):
        s = slice(start, min(start + size, n))
        motion = close(chain, angle[s], basis[:, s])
        _fill_positions(chain, branch, angle[s], motion, position[:, s])
        _fill_rates(chain, motion, _part(speed, s), _part(acceleration, s), v[:, s], a[:, s])
        gaps = product(chain.plane.gap_rows, basis[:, s])
        np.sqrt(np.maximum.reduce(gaps.real**2 + gaps.imag**2, axis=0), gap[s])
    return ClosedStates(position, v, a, basis), gap


def _part(rate: Array | float, states: slice) -> Array | float:
    return rate[states] if isinstance(rate, np.ndarray) else rate


def _fill_rates(chain: Chain, motion: ChainMotion, speed: Array | float, acceleration: Array | float, v: Array, a: Array) -> None:
    """Fill in joint rates and accelerations (nv, n)."""
    functions, rates, decelerations = chain.functions, motion.speeds, motion.decelerations
    for sense, row, outer, first, second in zip(chain.plane.sense.tolist(), functions.rows, functions.outer, v, a, strict=True):
        if outer is None:
            first[:] = rates[row]
            np.negative(decelerations[row], second)
        else:
            np.subtract(rates[row], rates[outer], first)
            np.subtract(decelerations[outer], decelerations[row], second)
        if sense < 0.0:
            np.negative(first, first)
            np.negative(second, second)
        second *= speed * speed
        if isinstance(acceleration, np.ndarray):
            second += first * acceleration
        first *= speed


def _fill_positions(chain: Chain, branch: Branch, angle: Array, motion: ChainMotion, position: Array) -> None:
    """Fill in joint coordinates (nv, n) at crank angles (n,)."""
    functions, plane = chain.functions, chain.plane
    exact = {plane.driver: angle} | {gear.joint: gear.ratio * angle + gear.offset for gear in chain.gears}
    angles: dict[int | None, Array] = {functions.rows[joint]: plane.sense[joint] * angle for joint, angle in exact.items()}
    for joint in plane.revolute:
        if joint not in exact:
            function = motion.functions[functions.rows[joint]]
            angles[functions.rows[joint]] = np.arctan2(function.imag, function.real)
    if chain.winding:
        near = nodes_before(branch, angle)
        for row in chain.winding:
            missing = plane.turn[functions.places[row] - 1] @ near - angles[row]
            angles[row] += 2 * np.pi * np.rint(missing * (0.5 / np.pi))
    for joint, (row, outer) in enumerate(zip(functions.rows, functions.outer, strict=True)):
        if joint in exact or not plane.sense[joint]:
            position[joint] = exact[joint] if joint in exact else motion.ways[row]
        else:
            relative = angles[row] if outer is None else angles[row] - angles[outer]
            position[joint] = relative if plane.sense[joint] > 0.0 else -relative


# ------------------------------------------------------------------------------------------------------------- chains found in linkages


def find_chain(equations: Equations, branch: Branch) -> Chain | None:
    """The chain of a linkage along its branch, as far as its dyads stay clear of dead centres; None if the linkage is no chain of dyads, or
    if dyads come near to dead centres all the time.

    At the nodes of the branch the closed form has to agree with Newton's method.
    """
    if branch.change_points:
        return None
    angles = np.append(branch.angles[:-1:SUBDIVISION], branch.angles[-1])  # nodes of the walk, which has checked margins between them
    begin = int(np.argmin(np.abs(angles)))
    newton = closing.close(equations, angles, predict(branch, angles), with_margins=True)
    assert newton.basis is not None
    assert newton.margins is not None
    chain = _build_chain(equations, newton.basis[:, begin])
    if chain is None:
        return None
    with np.errstate(all="ignore"):  # nodes that are beyond the reach of a dyad are left out
        basis = np.empty_like(newton.basis)
        close(chain, angles, basis)
        plane = equations.functions.plane
        size = np.where(np.arange(len(basis)) > len(plane.revolute), plane.size, 1.0)[:, None]
        errors = np.abs(basis - newton.basis) / size
        # Beyond rounding, which margins down to `CLEAR` enlarge a thousand times, the other assembly would differ by far more.
        good = (np.abs(newton.margins) >= CLEAR).all(axis=0) & (errors <= 1e-9).all(axis=0)
    chain = replace(chain, winding=_find_winding(chain, branch, newton.position[:, -1]))
    if branch.period is not None:
        return chain if good.all() else None
    bad = np.flatnonzero(~good)
    low = int(bad[bad < begin].max(initial=-1)) + 1
    high = int(bad[bad >= begin].min(initial=len(angles))) - 1
    return replace(chain, low=float(angles[low]), high=float(angles[high])) if low < high else None


def _find_winding(chain: Chain, branch: Branch, end: Array) -> tuple[int, ...]:
    """`Chain.winding`, given the joint coordinates (nv,) at the end of the branch."""
    plane = chain.plane
    angles = plane.turn @ np.concatenate([branch.coefficients[0], end[:, None]], axis=1)
    # A link makes no turns, so that its arc tangent is its angle, if it stays 1 rad below half a turn at the nodes of the branch.
    turning = (np.abs(angles) >= np.pi - 1.0).any(axis=1) | (np.abs(plane.turn @ branch.gain_per_period) > 1.0)
    exact = {plane.driver, *(gear.joint for gear in chain.gears)}
    return tuple(chain.functions.rows[j] for j, turns in zip(plane.revolute, turning, strict=True) if turns and j not in exact)


def _build_chain(equations: Equations, drawn: ComplexArray) -> Chain | None:
    """The chain of a linkage, given its basis (nb,) in a pose of its branch."""
    functions, plane = equations.functions, equations.functions.plane
    gears = _find_gears(equations)
    if plane.parents[plane.driver] >= 0 or gears is None:
        return None
    by_rows = drawn[list(functions.places)]
    chain, rate_rows = [], {functions.rows[plane.driver]}
    for block in equations.blocks:
        if not block.loops:
            continue
        if not block.has_inverses or not block.loops[0].earlier_functions:
            return None
        (loop,) = block.loops
        constant = plane.gap_rows[loop.loop][0]
        side = constant + sum(by * by_rows[row] for row, by in loop.earlier_functions)
        dyad = _build_dyad(functions, nonzero(functions, plane.gap_rows[loop.loop]), block.rows, by_rows, complex(side))
        if dyad is None:
            return None
        chain.append(Equation(loop.loop, np.array(constant) if constant else None, loop.earlier_functions, dyad))
        rate_rows |= {row for row, _ in loop.earlier_functions} | {guide.rotor for guide in dyad.guides if guide.rotor is not None}
    if not chain:
        return None
    return Chain(plane, functions, functions.rows[plane.driver], gears, tuple(chain), frozenset(rate_rows))


def _find_gears(equations: Equations) -> tuple[Gear, ...] | None:
    """The shafts of a linkage that are geared to the driver; None if gears turn anything else, or a driver that slides."""
    functions, plane = equations.functions, equations.functions.plane
    turning = {plane.driver: (1.0, 0.0)}  # by joint its angle: a ratio to that of the driver, and an offset
    gears = []
    for block in equations.blocks:
        if block.loops and not block.relations:
            continue
        if block.loops or len(block.joints) != 1 or block.redundant:
            return None
        (relation,), (joint,) = block.relations, block.joints
        others = dict(plane.relation_rows[relation])
        by_joint = others.pop(joint)
        if not others.keys() <= turning.keys() or any(plane.parents[j] >= 0 or not plane.sense[j] for j in (joint, *others)):
            return None
        ratio = -sum(by * turning[other][0] for other, by in others.items()) / by_joint
        offset = (float(plane.offsets[relation]) - sum(by * turning[other][1] for other, by in others.items())) / by_joint
        turning[joint] = ratio, offset
        gears.append(Gear(joint, relation, functions.rows[joint], float(plane.sense[joint]), ratio, offset))
    return tuple(gears)


def _build_dyad(
    functions: Functions, coefficients: Mapping[int, ComplexArray], unknown: Sequence[int], drawn: ComplexArray, side: complex
) -> Dyad | None:
    """The dyad that determines these rows; None if it has no closed form.

    Args:
        functions: rows of the functions.
        coefficients: of the loop's gap, by rows.
        unknown: rows of its unknowns.
        drawn: (rows,) functions in the drawn pose.
        side: the vector K in the drawn pose.
    """
    guides, by = functions.guides, {row: complex(coefficient) for row, coefficient in coefficients.items()}
    turning, ways = [row for row in unknown if row not in guides], [row for row in unknown if row in guides]
    if any(row not in by for row in ways) or not side:
        return None
    guides_of_ways = [Guide(way, coefficients[way], guides[way]) for way in ways]
    if len(unknown) == 1:
        return Lever.from_drawn_pose(unknown[0], by[unknown[0]]) if turning and unknown[0] in by else None
    if not turning:
        return TwoGuides(*guides_of_ways)
    rotor = turning[0]
    if ways and guides[ways[0]] == rotor:
        travel = float((drawn[ways[0]] / drawn[rotor]).real)
        return SwingingGuide.from_drawn_pose(rotor, ways[0], by.get(rotor, 0j), by[ways[0]], travel)
    if any(row not in by for row in unknown):
        return None
    a = by[rotor] * drawn[rotor]
    if ways:
        carrier = guides[ways[0]]
        direction = by[ways[0]] * (1.0 if carrier is None else drawn[carrier])
        return GuidedLink.from_drawn_pose(rotor, guides_of_ways[0], by[rotor], bool((a / direction).real < 0.0))
    left, right = turning if (a / side).imag > 0.0 else reversed(turning)
    return TwoLinks.from_drawn_pose(left, right, by[left], by[right])
