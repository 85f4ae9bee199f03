"""A planar linkage whose equations are a chain of dyads, closed at all crank angles at once without iteration.

Most press linkages are a driver and dyads one after the other (`dyads`). Then positions, rates and forces follow from a root for each dyad:
there is no guess, no table of the branch, no sine but those of the driver. Shafts on the frame that are geared to the driver turn with it,
and levers, as a second rod to the same slide is one, follow the links at both their ends. `chain_of` looks whether a linkage is such a
chain along its branch, and judges the closed form there by Newton's method; all others, and motions beyond change points, are closed by
`closing.close`.

What the engine does not need for forces is computed when it is first read: angles of the joints (an arc tangent takes longer than all else
that a dyad needs), their rates relative to each other, and gaps.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...common.frozen import read_only
from ...common.products import product
from ...common.quantities import Array, ComplexArray
from ..branch import SUBDIVISION, Branch, nodes_before, predict
from ..engine import ClosedStates
from . import closing
from .dyads import ONE, ZERO, Along, Dyad, Guide, GuidedLink, I, Lever, SwingingGuide, TwoGuides, TwoLinks, rotor_rate
from .functions import Functions
from .model import Plane

CLEAR = 1e-3  # smallest margin of a dyad's equations, see `Closure.margins`: nearer to a dead centre Newton's method closes
EQUAL = 1e-9  # by which the functions of a chain may differ from those that Newton's method finds [1 or lengths of the linkage]
PIECE, SMALLEST_PIECE = 7200, 900  # most states that are worked through at a time, and those below which calls would take most of it
IN_CACHE = 40_000  # states times dyads whose arrays stay in the cache
Known = tuple[tuple[int, ComplexArray], ...]


class Equation(NamedTuple):
    """The loop that a dyad closes: ``constant`` + sum(coefficient * function) = 0.

    Attributes:
        loop: index of the loop.
        constant: what does not move [m]; None where it is zero.
        known: rows and coefficients of the functions of the driver and of earlier dyads.
        dyad: the dyad, or a lever.
        unknown: rows of its unknowns.
    """

    loop: int
    constant: ComplexArray | None
    known: Known
    dyad: Dyad
    unknown: tuple[int, ...]


class Gear(NamedTuple):
    """A shaft on the frame that gears turn with the driver.

    Attributes:
        joint: its joint.
        coupling: index of the coupling that determines it.
        row: row of its rotor.
        sense: `Plane.sense` of the joint.
        ratio: its angle by that of the driver.
        offset: its angle where that of the driver is zero [rad].
    """

    joint: int
    coupling: int
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
        needed: rows of the functions whose rates later dyads need.
        low: crank angle from which on the closed form serves [rad or m].
        high: crank angle to which it serves [rad or m].
    """

    plane: Plane
    functions: Functions
    driver: int
    gears: tuple[Gear, ...]
    equations: tuple[Equation, ...]
    needed: tuple[int, ...]
    low: float = -np.inf
    high: float = np.inf

    @cached_property
    def turns(self) -> bool:
        """Whether the driver turns, then about the plane's normal, or slides."""
        return bool(self.plane.sense[self.plane.driver])

    @cached_property
    def levers(self) -> tuple[int, ...]:
        """Places of the equations of levers."""
        return tuple(place for place, equation in enumerate(self.equations) if isinstance(equation.dyad, Lever))

    @cached_property
    def piece(self) -> int:
        """Number of states that are worked through at a time: fewer in long chains, and where idle forces of levers take memory, too."""
        most = max(1, PIECE // (1 + len(self.levers)))
        return min(most, max(SMALLEST_PIECE, IN_CACHE // max(1, len(self.equations))))

    @cached_property
    def backwards(self) -> tuple[int, ...]:
        """The joints whose axes lie against the plane's normal."""
        return tuple(j for j, sense in enumerate(self.plane.sense) if sense < 0.0)


class Closed(NamedTuple):
    """A chain closed at n crank angles, and its derivatives while the driver moves at the rate 1.

    Attributes:
        functions: (rows, n) functions; those that later dyads do not need, and ones, are filled in by `all_functions`.
        inward: (rows, n) minus their second derivatives; not those of the rows of ones.
        along: the same and more by rows, see `Along`.
    """

    functions: ComplexArray
    inward: ComplexArray
    along: Along


def close(chain: Chain, angle: Array) -> Closed:
    """Close the chain at crank angles (n,), at which its dyads reach."""
    functions, inward = np.empty((2, chain.functions.count, len(angle)), complex)
    blank: list[Any] = [None] * chain.functions.count
    rates = dict.fromkeys(chain.needed, functions[0])
    along = Along(list(functions), list(inward), rates, blank, blank.copy(), blank.copy(), blank.copy())
    _drive(chain, angle, along)
    for _, constant, ((row, by), *others), dyad, unknown in chain.equations:
        known, opening, bending = along.functions[row] * by, along.rates[row] * by, along.inward[row] * by
        for row, by in others:
            known += along.functions[row] * by
            opening += along.rates[row] * by
            bending += along.inward[row] * by
        if constant is not None:
            known += constant
        for unknown_row, inverse in zip(unknown, dyad.close(known, opening, bending, along), strict=True):
            along.inverses[unknown_row] = inverse
    return Closed(functions, inward, along)


def _drive(chain: Chain, angle: Array, along: Along) -> None:
    """Fill in the driver."""
    row, function = chain.driver, along.functions[chain.driver]
    along.first[row], along.second[row] = ONE, ZERO
    if chain.turns:
        np.cos(angle, function.real)
        np.sin(angle, function.imag)
        along.rates[row] = function * I
        along.inward[row][:] = function
    else:
        function.real, function.imag = angle, 0.0
        along.ways[row], along.inward[row][:] = angle, 0.0
        along.rates[row] = np.ones(angle.shape, complex)
    for gear in chain.gears:
        row, speed = gear.row, gear.sense * gear.ratio
        rotor = along.functions[row]
        if speed == -1.0 and not gear.offset:  # a mirrored pair
            np.conjugate(function, rotor)
        else:
            turned_by = gear.sense * (gear.ratio * angle + gear.offset)
            np.cos(turned_by, rotor.real)
            np.sin(turned_by, rotor.imag)
        along.first[row], along.second[row] = np.array(speed), ZERO
        along.rates[row] = rotor * np.array(1j * speed)
        np.multiply(rotor, np.array(speed * speed), along.inward[row])


def all_functions(chain: Chain, closed: Closed) -> ComplexArray:
    """The functions (rows, n), also those that closing does not need."""
    closed.functions[chain.functions.ones_at] = 1.0
    for way, rotor in chain.functions.guides.items():
        if rotor is None:
            closed.functions[way] = closed.along.ways[way]
    return closed.functions


def rate_of(chain: Chain, closed: Closed, row: int) -> ComplexArray:
    """The derivative (n,) of a joint's function while the driver moves at the rate 1."""
    along = closed.along
    if row in along.rates:
        return along.rates[row]
    if row not in chain.functions.guides:
        return rotor_rate(along.first[row], along.functions[row])
    rotor, speed = chain.functions.guides[row], along.first[row]
    if rotor is None:
        return np.asarray(speed + 0j)
    return speed * along.functions[rotor] + along.ways[row] * rate_of(chain, closed, rotor)


# --------------------------------------------------------------------------------------------------------------- motions along the branch


class ChainClosure:
    """A chain closed at crank angles (n,) of a branch, piece by piece when something of it is read.

    Attributes:
        chain: the chain.
        branch: the branch.
        angle: (n,) crank angles [rad or m].
    """

    def __init__(self, chain: Chain, branch: Branch, angle: Array) -> None:
        self.chain, self.branch, self.angle = chain, branch, angle

    @cached_property
    def _whole(self) -> Closed:
        return close(self.chain, self.angle)

    def pieces(self) -> Iterator[tuple[slice, Closed]]:
        """The chain closed in pieces that stay in the cache; kept where one piece is enough."""
        n, most = len(self.angle), self.chain.piece
        if n <= most:
            yield slice(0, n), self._whole
            return
        size = -(-n // -(-n // most))  # of equal pieces
        for start in range(0, n, size):
            s = slice(start, min(start + size, n))
            yield s, close(self.chain, self.angle[s])

    @cached_property
    def basis(self) -> ComplexArray:
        """(nb, n) basis of `Plane`."""
        found = np.empty((len(self.chain.functions.order), len(self.angle)), complex)
        for s, closed in self.pieces():
            np.take(all_functions(self.chain, closed), self.chain.functions.order, axis=0, out=found[:, s])
        return read_only(found)

    @cached_property
    def influence(self) -> tuple[Array, Array]:
        """Influence coefficients (nv, n) of first and second order of all joints."""
        chain = self.chain
        first, second = np.empty((2, len(chain.functions.rows), len(self.angle)))
        for s, closed in self.pieces():
            rates, bending = closed.along.first, closed.along.second
            for j, (row, outer) in enumerate(zip(chain.functions.rows, chain.functions.outer, strict=True)):
                if outer is None:
                    first[j, s] = rates[row]
                    np.negative(bending[row], second[j, s])
                else:
                    np.subtract(rates[row], rates[outer], first[j, s])
                    np.subtract(bending[outer], bending[row], second[j, s])
        for j in chain.backwards:
            np.negative(first[j], first[j])
            np.negative(second[j], second[j])
        return read_only((first, second))

    @cached_property
    def position(self) -> Array:
        """(nv, n) joint coordinates."""
        chain, plane = self.chain, self.chain.plane
        position, geared = np.empty((len(chain.functions.rows), len(self.angle))), {plane.driver, *(gear.joint for gear in chain.gears)}
        position[list(geared)] = self.angle
        for s, closed in self.pieces():
            angles = {}
            for j, row in enumerate(chain.functions.rows):
                if (plane.sense[j] and j not in geared) or row in chain.functions.outer:
                    function = closed.functions[row]
                    angles[row] = np.arctan2(function.imag, function.real)
            for j, (row, outer) in enumerate(zip(chain.functions.rows, chain.functions.outer, strict=True)):
                if j not in geared:
                    position[j, s] = closed.along.ways[row] if row not in angles else angles[row]
                    if outer is not None:
                        position[j, s] -= angles[outer]
        for j in chain.backwards:
            np.negative(position[j], position[j])
        turns = nodes_before(self.branch, self.angle)
        turns -= position
        turns *= 1.0 / (2 * np.pi)
        np.rint(turns, turns)
        turns *= 2 * np.pi
        turns[list(plane.prismatic)] = 0.0
        position += turns
        position[plane.driver] = self.angle
        for gear in chain.gears:
            position[gear.joint] = gear.ratio * self.angle + gear.offset
        return read_only(position)

    def way(self, joint: int) -> Array:
        """(n,) coordinate of a prismatic joint [m]."""
        if len(self.angle) <= self.chain.piece:
            return self._whole.along.ways[self.chain.functions.rows[joint]]
        return np.concatenate([closed.along.ways[self.chain.functions.rows[joint]] for _, closed in self.pieces()])

    @cached_property
    def gap(self) -> Array:
        """(n,) largest gap of a loop [m]."""
        return read_only(np.abs(product(self.chain.plane.gap_rows, self.basis)).max(axis=0))


class ChainStates(ClosedStates):
    """States of a chain along its branch; joint coordinates and rates are computed when they are first read.

    Attributes:
        closure: the closed chain.
        speed: speed of the driver, (n,) or one number [rad/s or m/s].
        acceleration: its acceleration, (n,) or 0.0 [rad/s2 or m/s2].
        speeds: (n,) the speed in every state.
        accelerations: (n,) the acceleration in every state.
    """

    def __init__(self, closure: ChainClosure, speed: Array | float, acceleration: Array | float) -> None:
        self.closure, self.speed, self.acceleration = closure, speed, acceleration
        self.jacobian, self.solved = None, None

    def __getattr__(self, name: str) -> Any:
        if name in ("position", "basis", "gap"):
            value = getattr(self.closure, name)
        elif name in ("speeds", "accelerations"):
            of, value = self.speed if name == "speeds" else self.acceleration, np.empty(len(self.closure.angle))
            value[:] = of
            value.setflags(write=False)
        elif name == "v":
            value = read_only(self.closure.influence[0] * self.speed)
        elif name == "a":
            first, second = self.closure.influence
            value = second * (self.speed * self.speed)
            if isinstance(self.acceleration, np.ndarray):
                value += first * self.acceleration
            value = read_only(value)
        else:
            raise AttributeError(name)
        vars(self)[name] = value
        return value


# ------------------------------------------------------------------------------------------------------------- chains found in linkages


def chain_of(plane: Plane, branch: Branch) -> Chain | None:
    """The chain of a linkage along its branch, as far as its dyads stay clear of dead centres; None where the linkage is no chain of dyads,
    or comes near to dead centres all the time.

    At the nodes of the branch the closed form has to agree with Newton's method.
    """
    if branch.change_points:
        return None
    angles = np.append(branch.angles[:-1:SUBDIVISION], branch.angles[-1])  # nodes of the walk, between which it looked at margins
    begin = int(np.argmin(np.abs(angles)))
    judge = closing.close(plane, angles, predict(branch, angles), with_margins=True)
    assert judge.basis is not None
    assert judge.margins is not None
    chain = _built(plane, judge.basis[:, begin])
    if chain is None:
        return None
    with np.errstate(all="ignore"):  # nodes that are beyond the reach of a dyad are left out
        tried = ChainClosure(chain, branch, angles)
        size = np.where(np.arange(len(chain.functions.order)) > len(plane.revolute), plane.size, 1.0)[:, None]
        errors = np.abs(tried.basis - judge.basis) / size
        good = (np.abs(judge.margins) >= CLEAR).all(axis=0) & (errors <= EQUAL).all(axis=0)
    if branch.period is not None:
        return chain if good.all() else None
    bad = np.flatnonzero(~good)
    low = int(bad[bad < begin].max(initial=-1)) + 1
    high = int(bad[bad >= begin].min(initial=len(angles))) - 1
    return replace(chain, low=float(angles[low]), high=float(angles[high])) if low < high else None


def _built(plane: Plane, drawn: ComplexArray) -> Chain | None:
    """The chain of a linkage, given its basis (nb,) in a pose of its branch."""
    if plane.parents[plane.driver] >= 0 or not any(block.loops for block in plane.blocks):
        return None
    functions = Functions(plane)
    rows = functions.rows
    gears = _gears(plane, rows)
    if gears is None:
        return None
    places = {joint: place for place, joint in enumerate((*plane.revolute, *plane.prismatic), 1)}  # in the basis
    build = _Builder(drawn, functions.order, {way: rotor for way, _, rotor in plane.guides})
    known = {0, places[plane.driver], *(places[gear.joint] for gear in gears)}
    equations, needed = [], {rows[plane.driver]}
    for block in plane.blocks:
        if block.kind == "gear":
            continue
        if block.kind not in ("dyad", "lever"):
            return None
        entries, own = _entries(plane, block.loops[0]), [places[joint] for joint in block.joints]
        equation = build.equation(block.loops[0], entries, known, own)
        if equation is None:
            return None
        equations.append(equation)
        needed |= {row for row, _ in equation.known} | {guide.rotor for guide in equation.dyad.guides if guide.rotor is not None}
        known |= set(own)
    return Chain(plane, functions, rows[plane.driver], gears, tuple(equations), tuple(sorted(needed)))


def _gears(plane: Plane, rows: Sequence[int]) -> tuple[Gear, ...] | None:
    """The shafts of a linkage that are geared to the driver; None where gears turn anything else, or a driver that slides.

    Args:
        plane: the linkage.
        rows: rows of the functions of all joints.
    """
    turning = {plane.driver: (1.0, 0.0)}  # by joint its angle: a ratio to that of the driver, and an offset
    gears = []
    for block in plane.blocks:
        if block.kind != "gear":
            continue
        (coupling,), (joint,) = block.couplings, block.joints
        equation = dict(plane.coupling_rows[coupling])
        own = equation.pop(joint)
        if not equation.keys() <= turning.keys() or any(plane.parents[j] >= 0 or not plane.sense[j] for j in (joint, *equation)):
            return None
        ratio = -sum(by * turning[other][0] for other, by in equation.items()) / own
        offset = (float(plane.offsets[coupling]) - sum(by * turning[other][1] for other, by in equation.items())) / own
        turning[joint] = ratio, offset
        gears.append(Gear(joint, coupling, rows[joint], float(plane.sense[joint]), ratio, offset))
    return tuple(gears)


def _entries(plane: Plane, loop: int) -> dict[int, complex]:
    """The coefficients of a loop's gap over the basis that are not zero."""
    row = plane.gap_rows[loop]
    return {int(place): complex(row[place]) for place in np.flatnonzero(row)}


class _Builder(NamedTuple):
    """What dyads are built from; functions go by their places in the basis.

    Attributes:
        drawn: (nb,) the basis in the drawn pose.
        order: rows of functions, see `Chain`.
        rotors: of every way the place of the rotor that turns its guide, 0 for none.
    """

    drawn: ComplexArray
    order: Sequence[int]
    rotors: dict[int, int]

    def equation(self, loop: int, entries: dict[int, complex], known: set[int], own: Sequence[int]) -> Equation | None:
        """The equation of a loop with these coefficients; None where its dyad has no closed form."""
        moving = [place for place in sorted(entries) if place in known and place]
        outer = {self.rotors[place] for place in own if place in self.rotors} - set(own)
        if not moving or not set(entries) <= known | set(own) or not outer <= known:
            return None
        dyad = self._dyad(entries, own, sum((entries[place] * self.drawn[place] for place in entries if place in known), 0j))
        if dyad is None:
            return None
        constant, known_part = entries.get(0), self._coefficients(entries, moving)
        unknown = (dyad.one,) if isinstance(dyad, Lever) else (dyad.one, dyad.other)
        return Equation(loop, None if constant is None else np.array(constant), known_part, dyad, unknown)

    def _coefficients(self, entries: dict[int, complex], places: Sequence[int]) -> Known:
        return tuple((self.order[place], np.array(entries[place])) for place in places if place in entries)

    def _dyad(self, entries: dict[int, complex], own: Sequence[int], known: complex) -> Dyad | None:
        """The dyad with these two functions; ``known``: the vector K in the drawn pose."""
        turning, ways = [place for place in own if place not in self.rotors], [place for place in own if place in self.rotors]
        if any(place not in entries for place in ways) or not known:
            return None
        guides = [
            Guide(self.order[way], np.array(entries[way]), self.order[self.rotors[way]] if self.rotors[way] else None) for way in ways
        ]
        if len(own) == 1:
            return Lever.drawn(self.order[own[0]], entries[own[0]]) if own[0] in entries and turning else None
        if not turning:
            return TwoGuides(*guides)
        one, other = turning[0], own[0] if own[1] == turning[0] else own[1]
        if ways and self.rotors[other] == one:
            way = float((self.drawn[other] / self.drawn[one]).real)
            return SwingingGuide.drawn(self.order[one], self.order[other], entries.get(one, 0j), entries[other], way)
        if one not in entries or other not in entries:
            return None
        a = entries[one] * self.drawn[one]
        if ways:
            direction = entries[other] * (self.drawn[self.rotors[other]] if self.rotors[other] else 1.0)
            return GuidedLink.drawn(self.order[one], guides[0], entries[one], (a / direction).real < 0.0)
        left = (a / known).imag > 0.0
        one, other = (one, other) if left else (other, one)
        return TwoLinks.drawn(self.order[one], self.order[other], entries[one], entries[other])
