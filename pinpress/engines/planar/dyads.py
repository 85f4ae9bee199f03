"""The kinds of dyads: two unknown links or slides that close a loop, found by one root, without iteration.

In the plane a vector is a complex number, and a turn of it is a product with exp(i phi). Go round a loop once: the *side* K is the sum of
all vectors that are known before the dyad is closed. The equation of the loop, in the order of a drawing, is of

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


class ChainMotion(NamedTuple):
    """Motion of a chain of dyads at n crank angles, while the driver moves at the rate 1; lists go by rows of functions, see
    `chain.Chain`. Every dyad fills in the rows of its two unknowns.

    Attributes:
        rate_rows: rows of the functions whose derivatives later dyads need.
        functions: (n,) complex functions: rotors of links that turn, ways times the rotors of their guides.
        rates: (n,) first derivatives of the functions in ``rate_rows``.
        inward: (n,) minus second derivatives of the same functions.
        ways: (n,) travels along guides.
        speeds: (n,) rates of angles and ways.
        decelerations: (n,) minus their second derivatives.
    """

    rate_rows: Collection[int]
    functions: list[ComplexArray]
    rates: dict[int, ComplexArray]
    inward: dict[int, ComplexArray]
    ways: list[Array]
    speeds: list[Array]
    decelerations: list[Array]


class Dyad(Protocol):
    """Two unknowns of a loop, which are rows of functions; a lever has one."""

    @property
    def guides(self) -> tuple[Guide, ...]:
        """The guides whose directions are known before the dyad is closed."""

    def close(self, side: ComplexArray, opening: ComplexArray, inward: ComplexArray, motion: ChainMotion) -> None:
        """Fill in the unknowns.

        Args:
            side: (n,) the vector K.
            opening: (n,) its derivative.
            inward: (n,) minus its second derivative. All three may be overwritten.
            motion: of the driver and of earlier dyads.
        """


@dataclass(frozen=True, eq=False)
class TwoLinks:
    """Two links: A over K is t, whose real part follows from the three lengths, and whose length is that of A over that of K.

    Attributes:
        rotor1: row of the rotor of A.
        rotor2: row of the rotor of B.
        inverse1: inverse of A in the drawn pose [1/m].
        inverse2: inverse of B in the drawn pose [1/m].
        square: squared length of A [m2].
        half: half the difference of the squared lengths of B and A [m2].
    """

    rotor1: int
    rotor2: int
    inverse1: ComplexArray
    inverse2: ComplexArray
    square: Array
    half: Array

    guides: tuple[Guide, ...] = ()

    @staticmethod
    def from_drawn_pose(rotor1: int, rotor2: int, a: complex, b: complex) -> TwoLinks:
        """The dyad that closes K + a + b = 0 in the drawn pose, where a points to the left of K."""
        half = 0.5 * (abs(b) - abs(a)) * (abs(b) + abs(a))
        return TwoLinks(rotor1, rotor2, np.array(1.0 / a), np.array(-1.0 / b), np.array(abs(a) ** 2), np.array(half))

    def close(self, side: ComplexArray, opening: ComplexArray, inward: ComplexArray, motion: ChainMotion) -> None:
        functions = motion.functions
        conjugate = side.conj()
        by_square = ONE / (conjugate * side).real
        t = np.empty(side.shape, complex)
        real = by_square * self.half
        real = np.add(real, MINUS_HALF, t.real)
        height = by_square * self.square
        height -= real * real
        height = np.sqrt(height, t.imag)
        a = side * t
        side += a  # B
        np.multiply(a, self.inverse1, functions[self.rotor1])
        np.multiply(side, self.inverse2, functions[self.rotor2])
        by_square /= height
        conjugate *= by_square
        e2 = np.conjugate(t, t)
        e2 *= conjugate
        e1 = conjugate
        e1 += e2
        centripetal1 = _keep_spin(self.rotor1, opening * e1, motion)
        centripetal2 = _keep_spin(self.rotor2, np.multiply(opening, e2, opening), motion)
        a *= centripetal1
        inward += a
        side *= centripetal2
        inward -= side
        _keep_spin_deceleration(self.rotor1, inward * e1, centripetal1, motion)
        _keep_spin_deceleration(self.rotor2, np.multiply(inward, e2, inward), centripetal2, motion)


def _keep_spin(rotor: int, rate: ComplexArray, motion: ChainMotion) -> ComplexArray:
    """Keep the angular velocity w (n,) of a rotor, the real part of ``rate``; returns w^2."""
    speed = motion.speeds[rotor] = rate.real
    centripetal = np.zeros(rate.shape, complex)
    np.multiply(speed, speed, centripetal.real)
    if rotor in motion.rate_rows:
        motion.rates[rotor] = rotor_rate(speed, motion.functions[rotor])
    return centripetal


def rotor_rate(speed: Array, rotor: ComplexArray) -> ComplexArray:
    """The derivative (n,) of a rotor with this angular velocity."""
    rate = np.zeros(rotor.shape, complex)
    rate.imag = speed
    rate *= rotor
    return rate


def _keep_spin_deceleration(rotor: int, deceleration: ComplexArray, centripetal: ComplexArray, motion: ChainMotion) -> None:
    """Fill in the inward part of a rotor, whose angular acceleration is minus the real part of ``deceleration``."""
    motion.decelerations[rotor] = deceleration.real
    if rotor in motion.rate_rows:
        centripetal.imag = deceleration.real
        motion.inward[rotor] = centripetal * motion.functions[rotor]


class Guide(NamedTuple):
    """A guide whose direction is known before its dyad is closed.

    Attributes:
        way: row of the function that is the way along it, times its rotor.
        direction: its direction in the drawn pose.
        rotor: row of the rotor that turns it; None if it does not turn.
    """

    way: int
    direction: ComplexArray
    rotor: int | None

    def current_direction(self, motion: ChainMotion) -> ComplexArray:
        """Its direction, (n,) or without axes."""
        return self.direction if self.rotor is None else motion.functions[self.rotor] * self.direction

    def keep_way(self, way: Array, opening: ComplexArray, motion: ChainMotion) -> None:
        """Keep the way (n,), and add the rate at which the guide's turning moves the point there to ``opening``."""
        motion.ways[self.way] = way
        if self.rotor is None:
            motion.functions[self.way][:] = way
            return
        np.multiply(motion.functions[self.rotor], way, motion.functions[self.way])
        opening += motion.rates[self.rotor] * way * self.direction

    def keep_speed(self, speed: Array, inward: ComplexArray, motion: ChainMotion) -> None:
        """Keep the speed (n,) along the guide, and add what the guide's turning and Coriolis' term contribute to ``inward``."""
        motion.speeds[self.way] = speed
        if self.rotor is None:
            if self.way in motion.rate_rows:
                motion.rates[self.way] = np.asarray(speed + 0j)
            return
        way, rate, function = motion.ways[self.way], motion.rates[self.rotor], motion.functions[self.rotor]
        turning = motion.inward[self.rotor] * way - 2.0 * speed * rate
        inward += turning * self.direction
        if self.way in motion.rate_rows:
            motion.inward[self.way] = turning
            motion.rates[self.way] = speed * function + way * rate

    def keep_deceleration(self, deceleration: Array, motion: ChainMotion) -> None:
        """Fill in the inward part of the way, whose second derivative is minus ``deceleration`` (n,)."""
        motion.decelerations[self.way] = deceleration
        if self.way not in motion.rate_rows:
            return
        if self.rotor is None:
            motion.inward[self.way] = np.asarray(deceleration + 0j)
        else:
            motion.inward[self.way] += deceleration * motion.functions[self.rotor]


@dataclass(frozen=True, eq=False)
class GuidedLink:
    """A link A with one end on a guide: across the guide its component balances that of K, along the guide it is the root.

    Attributes:
        rotor: row of the rotor of A.
        guide: the guide; its direction is -D.
        inverse: inverse of A in the drawn pose [1/m].
        square: squared length of A [m2].
        ahead: whether A points along D.
    """

    rotor: int
    guide: Guide
    inverse: ComplexArray
    square: Array
    ahead: bool

    @property
    def guides(self) -> tuple[Guide, ...]:
        return (self.guide,)

    @cached_property
    def _fixed_axes(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
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
    def from_drawn_pose(rotor: int, guide: Guide, a: complex, ahead: bool) -> GuidedLink:
        """The dyad with the link a in the drawn pose."""
        return GuidedLink(rotor, guide, np.array(1.0 / a), np.array(abs(a) ** 2), ahead)

    def close(self, side: ComplexArray, opening: ComplexArray, inward: ComplexArray, motion: ChainMotion) -> None:
        guide = self.guide
        direction, across, turned_across = self._fixed_axes if guide.rotor is None else self._axes(guide.current_direction(motion))
        a = np.empty(side.shape, complex)
        local = side * across  # K in the axes of the guide
        across_guide = np.negative(local.imag, a.imag)
        root = self.square - across_guide * across_guide
        root = np.sqrt(root, a.real)
        if not self.ahead:
            root = np.negative(root, root)
        way = local.real + root
        by_root = ONE / root
        a *= direction
        np.multiply(a, self.inverse, motion.functions[self.rotor])
        e1 = by_root * turned_across
        e2 = np.conjugate(a)
        e2 *= by_root
        guide.keep_way(way, opening, motion)
        centripetal = _keep_spin(self.rotor, opening * e1, motion)
        guide.keep_speed((opening * e2).real, inward, motion)
        a *= centripetal
        inward += a
        _keep_spin_deceleration(self.rotor, inward * e1, centripetal, motion)
        guide.keep_deceleration((inward * e2).real, motion)


@dataclass(frozen=True, eq=False)
class SwingingGuide:
    """A guide that a link turns: it points at the end of K, at the distance of its offset.

    Attributes:
        rotor: row of the rotor of the guide.
        way: row of the way along the guide times this rotor.
        direction: b, the direction of the guide in the drawn pose.
        foot: component along b of the arm from the pivot to where the way begins [m].
        offset: its component across b [m].
        ahead: whether the point lies ahead of the foot of the pivot on the line.
    """

    rotor: int
    way: int
    direction: ComplexArray
    foot: Array
    offset: float
    ahead: bool

    guides: tuple[Guide, ...] = ()

    @staticmethod
    def from_drawn_pose(rotor: int, way: int, a: complex, b: complex, travel: float) -> SwingingGuide:
        """The dyad with the arm a and the direction b of the guide, its travel being ``travel`` in the drawn pose."""
        foot = a / b
        return SwingingGuide(rotor, way, np.array(b), np.array(foot.real), foot.imag, foot.real + travel > 0.0)

    def close(self, side: ComplexArray, opening: ComplexArray, inward: ComplexArray, motion: ChainMotion) -> None:
        functions = motion.functions
        arm = np.negative(side)
        square = (arm.real * arm.real) + arm.imag * arm.imag
        reach = np.sqrt(square - self.offset**2)
        if not self.ahead:
            reach = np.negative(reach, reach)
        way = motion.ways[self.way] = reach - self.foot
        rotor = np.empty(side.shape, complex)  # arm / (b (reach + i offset))
        np.divide(reach, square, rotor.real)
        np.divide(-self.offset, square, rotor.imag)
        rotor *= arm
        np.multiply(rotor, self.direction.conj(), functions[self.rotor])
        rotor = functions[self.rotor]
        np.multiply(rotor, way, functions[self.way])
        slide = rotor * self.direction
        slide *= I  # arm of the way, as the module defines it
        by_root = np.divide(-1.0, reach)
        e1, e2 = slide.conj(), arm.conj()
        e1 *= by_root
        e2 *= by_root
        centripetal = _keep_spin(self.rotor, opening * e1, motion)
        turning, speed = motion.speeds[self.rotor], (opening * e2).real
        motion.speeds[self.way] = speed
        arm *= centripetal
        inward += arm
        inward -= 2.0 * turning * speed * slide
        _keep_spin_deceleration(self.rotor, inward * e1, centripetal, motion)
        deceleration = motion.decelerations[self.way] = (inward * e2).real
        if self.way in motion.rate_rows:
            moving = np.empty(side.shape, complex)
            moving.real, moving.imag = deceleration, -2.0 * turning * speed
            moving *= rotor
            motion.inward[self.way] = moving + (turning * turning + 1j * motion.decelerations[self.rotor]) * rotor * way
            motion.rates[self.way] = speed * rotor + way * rotor_rate(turning, rotor)


@dataclass(frozen=True, eq=False)
class TwoGuides:
    """Two ways along known directions, D and D2: a linear equation.

    Attributes:
        guide1: the guide whose direction is D.
        guide2: the guide whose direction is -D2.
    """

    guide1: Guide
    guide2: Guide

    @property
    def guides(self) -> tuple[Guide, ...]:
        return self.guide1, self.guide2

    def close(self, side: ComplexArray, opening: ComplexArray, inward: ComplexArray, motion: ChainMotion) -> None:
        arm1, arm2 = -I * self.guide1.current_direction(motion), I * self.guide2.current_direction(motion)
        inverse = -1.0 / (arm1.conj() * arm2).imag
        e1, e2 = arm2.conj() * inverse, arm1.conj() * inverse
        self.guide1.keep_way((side * e1).real, opening, motion)
        self.guide2.keep_way((side * e2).real, opening, motion)
        self.guide1.keep_speed((opening * e1).real, inward, motion)
        self.guide2.keep_speed((opening * e2).real, inward, motion)
        self.guide1.keep_deceleration((inward * e1).real, motion)
        self.guide2.keep_deceleration((inward * e2).real, motion)


@dataclass(frozen=True, eq=False)
class Lever:
    """A link A between two points that are known: it points against K. A second rod to the same slide is one.

    Attributes:
        rotor: row of the rotor of A.
        to_rotor: factor that turns a unit vector along K into this rotor.
        to_inverse: factor that turns the conjugate of the unit vector into the inverse [1/m].
    """

    rotor: int
    to_rotor: ComplexArray
    to_inverse: ComplexArray

    guides: tuple[Guide, ...] = ()

    @staticmethod
    def from_drawn_pose(rotor: int, a: complex) -> Lever:
        """The lever a in the drawn pose."""
        return Lever(rotor, np.array(-abs(a) / a), np.array(-1j / abs(a)))

    def close(self, side: ComplexArray, opening: ComplexArray, inward: ComplexArray, motion: ChainMotion) -> None:
        conjugate = side.conj()
        by_length = ONE / np.sqrt((conjugate * side).real)
        conjugate *= by_length
        np.multiply(side, by_length * self.to_rotor, motion.functions[self.rotor])
        e1 = np.multiply(conjugate, self.to_inverse, conjugate)
        centripetal = _keep_spin(self.rotor, np.multiply(opening, e1, opening), motion)
        side *= centripetal
        inward -= side
        _keep_spin_deceleration(self.rotor, np.multiply(inward, e1, inward), centripetal, motion)
