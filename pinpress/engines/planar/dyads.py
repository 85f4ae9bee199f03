"""The kinds of dyads: two unknown links or slides that close a loop, found by one root, without iteration.

In the plane a vector is a complex number, and a turn of it is a product with exp(i phi). Go round a loop once: K is the sum of all vectors
that are known before the dyad is closed. The two that are not are, in the order of a drawing,

    two links         K + A = B                    A and B keep their lengths and turn: the third corner of a triangle on the side K
    guided link       K + A = s D                  A keeps its length and turns, s is a way along the known direction D of a guide
    swinging guide    K + (a + b s) u = 0          u turns a guide, along whose direction b the way s goes; a is the offset of its line
    two guides        K + s D = s2 D2              both ways are along known directions

A *lever* is a single link between two points that are known: K + A = 0, one of whose two equations is redundant.

Each dyad has at most two solutions, which differ in the sign of one root. The drawn pose tells the sign; it stays the same while the dyad
does not come into line, where the root is zero.

The velocities of the two unknowns are x1 and x2, rates of angles and ways. Their *arms* are the vectors with which they close what opens at
the rate o, a complex number as well:

    i x1 arm1 - i x2 arm2 = -o        has the solution        x1 = Re(o e1),  x2 = Re(o e2)

    e1 = conj(arm2) / d,   e2 = conj(arm1) / d,   d = -Im(conj(arm1) arm2)

The arm of a link is the link itself, that of a way along D is -i D. The same two *inverses* e1 and e2 give accelerations.
The inverse of a lever is e1 = i conj(arm1) / |arm1|^2, with which x1 closes what opens across it.

Of a function of the crank angle its *inward* part is minus its second derivative while the driver moves at the rate 1: that of a rotor u
with angular velocity w and acceleration alpha is (w^2 - i alpha) u. What opens without the unknown accelerations is closed by these in the
same way. Constants are arrays without axes, which NumPy multiplies by in half the time that a Python number takes.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from ...common.quantities import Array, ComplexArray

ZERO, ONE, MINUS_HALF, I = np.array(0.0), np.array(1.0), np.array(-0.5), np.array(1j)  # noqa: E741


class Along(NamedTuple):
    """What is known along a chain of dyads at n crank angles, while the driver moves at the rate 1; lists go by rows of functions, see
    `chain.Chain`. Dyads fill in the rows of their two unknowns.

    Attributes:
        needed: rows of the functions whose derivatives later dyads need.
        functions: (n,) complex functions: rotors of links that turn, ways times the rotors of their guides.
        rates: (n,) first derivatives of those that are needed.
        inward: (n,) minus second derivatives of those that are needed.
        ways: (n,) travels along guides.
        first: (n,) rates of angles and ways.
        second: (n,) minus their second derivatives.
    """

    needed: Collection[int]
    functions: list[ComplexArray]
    rates: dict[int, ComplexArray]
    inward: dict[int, ComplexArray]
    ways: list[Array]
    first: list[Array]
    second: list[Array]


class Dyad(Protocol):
    """Two unknowns of a chain, ``one`` and ``other``, which are rows of functions; a lever has one."""

    @property
    def one(self) -> int: ...
    @property
    def guides(self) -> tuple[Guide, ...]:
        """The guides whose directions are known before the dyad is closed."""

    def close(self, known: ComplexArray, opening: ComplexArray, inward: ComplexArray, along: Along) -> None:
        """Fill in the unknowns.

        Args:
            known: (n,) the vector K.
            opening: (n,) its derivative.
            inward: (n,) minus its second derivative. All three may be overwritten.
            along: what is known of the chain.
        """


@dataclass(frozen=True, eq=False)
class TwoLinks:
    """Two links: A over K is t, whose real part follows from the three lengths, and whose length is that of A over that of K.

    Attributes:
        one: row of the rotor of A.
        other: row of the rotor of B.
        of_one: inverse of A in the drawn pose [1/m].
        of_other: inverse of B in the drawn pose [1/m].
        square: squared length of A [m2].
        half: half the difference of the squared lengths of B and A [m2].
    """

    one: int
    other: int
    of_one: ComplexArray
    of_other: ComplexArray
    square: Array
    half: Array

    guides: tuple[Guide, ...] = ()

    @staticmethod
    def drawn(one: int, other: int, a: complex, b: complex) -> TwoLinks:
        """The dyad that closes K + a + b = 0 in the drawn pose, where a points to the left of K."""
        half = 0.5 * (abs(b) - abs(a)) * (abs(b) + abs(a))
        return TwoLinks(one, other, np.array(1.0 / a), np.array(-1.0 / b), np.array(abs(a) ** 2), np.array(half))

    def close(self, known: ComplexArray, opening: ComplexArray, inward: ComplexArray, along: Along) -> None:
        functions = along.functions
        conjugate = known.conj()
        by_square = ONE / (conjugate * known).real
        t = np.empty(known.shape, complex)
        real = by_square * self.half
        real = np.add(real, MINUS_HALF, t.real)
        height = by_square * self.square
        height -= real * real
        height = np.sqrt(height, t.imag)
        a = known * t
        known += a  # B
        np.multiply(a, self.of_one, functions[self.one])
        np.multiply(known, self.of_other, functions[self.other])
        by_square /= height
        conjugate *= by_square
        e2 = np.conjugate(t, t)
        e2 *= conjugate
        e1 = conjugate
        e1 += e2
        bent1, bent2 = _started(self.one, opening * e1, along), _started(self.other, np.multiply(opening, e2, opening), along)
        a *= bent1
        inward += a
        known *= bent2
        inward -= known
        _finished(self.one, inward * e1, bent1, along)
        _finished(self.other, np.multiply(inward, e2, inward), bent2, along)


def _started(rotor: int, rate: ComplexArray, along: Along) -> ComplexArray:
    """Keep the angular velocity w (n,) of a rotor, the real part of ``rate``; returns w^2."""
    speed = along.first[rotor] = rate.real
    bent = np.zeros(rate.shape, complex)
    np.multiply(speed, speed, bent.real)
    if rotor in along.needed:
        along.rates[rotor] = rotor_rate(speed, along.functions[rotor])
    return bent


def rotor_rate(speed: Array, rotor: ComplexArray) -> ComplexArray:
    """The derivative (n,) of a rotor with this angular velocity."""
    rate = np.zeros(rotor.shape, complex)
    rate.imag = speed
    rate *= rotor
    return rate


def _finished(rotor: int, bending: ComplexArray, bent: ComplexArray, along: Along) -> None:
    """Fill in the inward part of a rotor, whose angular acceleration is minus the real part of ``bending``."""
    along.second[rotor] = bending.real
    if rotor in along.needed:
        bent.imag = bending.real
        along.inward[rotor] = bent * along.functions[rotor]


class Guide(NamedTuple):
    """A guide whose direction is known before its dyad is closed.

    Attributes:
        way: row of the function that is the way along it, times its rotor.
        direction: its direction in the drawn pose.
        rotor: row of the rotor that turns it; None where it does not turn.
    """

    way: int
    direction: ComplexArray
    rotor: int | None

    def along(self, along: Along) -> ComplexArray:
        """Its direction, (n,) or without axes."""
        return self.direction if self.rotor is None else along.functions[self.rotor] * self.direction

    def open(self, way: Array, opening: ComplexArray, along: Along) -> None:
        """Keep the way (n,), and add the rate at which the guide's turning moves the point there to ``opening``."""
        along.ways[self.way] = way
        if self.rotor is None:
            along.functions[self.way][:] = way
            return
        np.multiply(along.functions[self.rotor], way, along.functions[self.way])
        opening += along.rates[self.rotor] * way * self.direction

    def bend(self, speed: Array, inward: ComplexArray, along: Along) -> None:
        """Keep the speed (n,) along the guide, and add what the guide's turning and Coriolis' term contribute to ``inward``."""
        along.first[self.way] = speed
        if self.rotor is None:
            if self.way in along.needed:
                along.rates[self.way] = np.asarray(speed + 0j)
            return
        way, rate, function = along.ways[self.way], along.rates[self.rotor], along.functions[self.rotor]
        turning = along.inward[self.rotor] * way - 2.0 * speed * rate
        inward += turning * self.direction
        if self.way in along.needed:
            along.inward[self.way] = turning
            along.rates[self.way] = speed * function + way * rate

    def finish(self, bending: Array, along: Along) -> None:
        """Fill in the inward part of the way, whose second derivative is minus ``bending`` (n,)."""
        along.second[self.way] = bending
        if self.way not in along.needed:
            return
        if self.rotor is None:
            along.inward[self.way] = np.asarray(bending + 0j)
        else:
            along.inward[self.way] += bending * along.functions[self.rotor]


@dataclass(frozen=True, eq=False)
class GuidedLink:
    """A link A with one end on a guide: across the guide its component balances that of K, along the guide it is the root.

    Attributes:
        one: row of the rotor of A.
        guide: the guide; its direction is -D.
        of_one: inverse of A in the drawn pose [1/m].
        square: squared length of A [m2].
        ahead: whether A points along D.
    """

    one: int
    guide: Guide
    of_one: ComplexArray
    square: Array
    ahead: bool

    @property
    def other(self) -> int:
        return self.guide.way

    @property
    def guides(self) -> tuple[Guide, ...]:
        return (self.guide,)

    @cached_property
    def _still(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """`_axes` of a guide that does not turn."""
        direction, across, turned_across = self._axes(self.guide.direction)
        return np.asarray(direction), np.asarray(across), np.asarray(turned_across)

    @staticmethod
    def _axes(along_guide: ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """D, its conjugate, and that of -i D."""
        direction = np.negative(along_guide)
        across = np.conjugate(direction)
        return direction, across, across * I

    @staticmethod
    def drawn(one: int, guide: Guide, a: complex, ahead: bool) -> GuidedLink:
        """The dyad with the link a in the drawn pose."""
        return GuidedLink(one, guide, np.array(1.0 / a), np.array(abs(a) ** 2), ahead)

    def close(self, known: ComplexArray, opening: ComplexArray, inward: ComplexArray, along: Along) -> None:
        guide = self.guide
        direction, across, turned_across = self._still if guide.rotor is None else self._axes(guide.along(along))
        a = np.empty(known.shape, complex)
        seen = known * across  # K in the axes of the guide
        side = np.negative(seen.imag, a.imag)
        root = self.square - side * side
        root = np.sqrt(root, a.real)
        if not self.ahead:
            root = np.negative(root, root)
        way = seen.real + root
        by_root = ONE / root
        a *= direction
        np.multiply(a, self.of_one, along.functions[self.one])
        e1 = by_root * turned_across
        e2 = np.conjugate(a)
        e2 *= by_root
        guide.open(way, opening, along)
        bent = _started(self.one, opening * e1, along)
        guide.bend((opening * e2).real, inward, along)
        a *= bent
        inward += a
        _finished(self.one, inward * e1, bent, along)
        guide.finish((inward * e2).real, along)


@dataclass(frozen=True, eq=False)
class SwingingGuide:
    """A guide that a link turns: it points at the end of K, at the distance of its offset.

    Attributes:
        one: row of the rotor of the guide.
        other: row of the way along it times this rotor.
        direction: b, the direction of the guide in the drawn pose.
        foot: component along b of the arm from the pivot to where the way begins [m].
        offset: its component across b [m].
        ahead: whether the point lies ahead of the foot of the pivot on the line.
    """

    one: int
    other: int
    direction: ComplexArray
    foot: Array
    offset: float
    ahead: bool

    guides: tuple[Guide, ...] = ()

    @staticmethod
    def drawn(one: int, other: int, a: complex, b: complex, way: float) -> SwingingGuide:
        """The dyad with the arm a and the direction b of the guide, the way being ``way`` in the drawn pose."""
        foot = a / b
        return SwingingGuide(one, other, np.array(b), np.array(foot.real), foot.imag, foot.real + way > 0.0)

    def close(self, known: ComplexArray, opening: ComplexArray, inward: ComplexArray, along: Along) -> None:
        functions, one, other = along.functions, self.one, self.other
        arm = np.negative(known)
        square = (arm.real * arm.real) + arm.imag * arm.imag
        reached = np.sqrt(square - self.offset**2)
        if not self.ahead:
            reached = np.negative(reached, reached)
        way = along.ways[other] = reached - self.foot
        rotor = np.empty(known.shape, complex)  # arm / (b (reached + i offset))
        np.divide(reached, square, rotor.real)
        np.divide(-self.offset, square, rotor.imag)
        rotor *= arm
        np.multiply(rotor, self.direction.conj(), functions[one])
        rotor = functions[one]
        np.multiply(rotor, way, functions[other])
        slide = rotor * self.direction
        slide *= I  # arm of the way, as the module defines it
        by_root = np.divide(-1.0, reached)
        e1, e2 = slide.conj(), arm.conj()
        e1 *= by_root
        e2 *= by_root
        bent = _started(one, opening * e1, along)
        turning, speed = along.first[one], (opening * e2).real
        along.first[other] = speed
        arm *= bent
        inward += arm
        inward -= 2.0 * turning * speed * slide
        _finished(one, inward * e1, bent, along)
        bending = along.second[other] = (inward * e2).real
        if other in along.needed:
            moving = np.empty(known.shape, complex)
            moving.real, moving.imag = bending, -2.0 * turning * speed
            moving *= rotor
            along.inward[other] = moving + (turning * turning + 1j * along.second[one]) * rotor * way
            along.rates[other] = speed * rotor + way * rotor_rate(turning, rotor)


@dataclass(frozen=True, eq=False)
class TwoGuides:
    """Two ways along known directions, D and D2: a linear equation.

    Attributes:
        first: the guide whose direction is D.
        second: the guide whose direction is -D2.
    """

    first: Guide
    second: Guide

    @property
    def one(self) -> int:
        return self.first.way

    @property
    def other(self) -> int:
        return self.second.way

    @property
    def guides(self) -> tuple[Guide, ...]:
        return self.first, self.second

    def close(self, known: ComplexArray, opening: ComplexArray, inward: ComplexArray, along: Along) -> None:
        arm1, arm2 = -I * self.first.along(along), I * self.second.along(along)
        inverse = -1.0 / (arm1.conj() * arm2).imag
        e1, e2 = arm2.conj() * inverse, arm1.conj() * inverse
        self.first.open((known * e1).real, opening, along)
        self.second.open((known * e2).real, opening, along)
        self.first.bend((opening * e1).real, inward, along)
        self.second.bend((opening * e2).real, inward, along)
        self.first.finish((inward * e1).real, along)
        self.second.finish((inward * e2).real, along)


@dataclass(frozen=True, eq=False)
class Lever:
    """A link A between two points that are known: it points against K. A second rod to the same slide is one.

    Attributes:
        one: row of the rotor of A.
        of_one: that by which a unit vector along K has to be multiplied for this rotor.
        of_inverse: that by which the conjugate of this vector has to be multiplied for the inverse [1/m].
    """

    one: int
    of_one: ComplexArray
    of_inverse: ComplexArray

    guides: tuple[Guide, ...] = ()

    @staticmethod
    def drawn(one: int, a: complex) -> Lever:
        """The lever a in the drawn pose."""
        return Lever(one, np.array(-abs(a) / a), np.array(-1j / abs(a)))

    def close(self, known: ComplexArray, opening: ComplexArray, inward: ComplexArray, along: Along) -> None:
        conjugate = known.conj()
        by_length = ONE / np.sqrt((conjugate * known).real)
        conjugate *= by_length
        np.multiply(known, by_length * self.of_one, along.functions[self.one])
        e1 = np.multiply(conjugate, self.of_inverse, conjugate)
        bent = _started(self.one, np.multiply(opening, e1, opening), along)
        known *= bent
        inward -= known
        _finished(self.one, np.multiply(inward, e1, inward), bent, along)
