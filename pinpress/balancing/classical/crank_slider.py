"""The centred crank-slide: read from a linkage, its slide's harmonics, and the counterweights that balance it.

Points of a link are complex numbers along the line of its pins: the real part towards the far pin, the imaginary part across it, on the
side to which the line would turn with the crank. By static substitution a rod of mass m whose centre is at the share k of its length
(complex where it lies off the line) counts as m (1 - k) at the crank pin and m k at the slide's pin: its inertia force is exactly theirs,
its moment is not (`CrankSlide.residual_inertia`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...common.arguments import typed
from ...common.arrays import Array
from ...common.checks import is_number, positive, whole_number
from ...common.errors import PinpressError, shown
from ...common.frozen import Frozen
from ...engines.planar.model import Plane, flat, in_space
from ...kinematics.poses import poses
from ...linkage.linkage import Linkage
from ..counterweights import Counterweight
from .rotor import Correction

CENTRED = 1e-9  # of the linkage's size: what the slide's pin may be beside the shaft by the rounded figures of a drawing
LARGEST_RATIO = 1 - 1e-9  # of crank radius to rod length; nearer to 1 the series below is of millions of terms
SMALLEST_TERM = 1e-18  # of that series, beside its first


@dataclass(frozen=True, eq=False)
class CrankSlide(Frozen):
    """A centred crank-slide: lengths, masses and centres of mass as its balancing needs them.

    Attributes:
        crank, rod, slide: names of the links.
        crank_radius, rod_length: between the pins [m].
        crank_mass, rod_mass, slide_mass: [kg], with all that is welded to the link.
        crank_centre: centre of mass from the shaft, complex along the line to the crank pin [m].
        rod_centre: from the crank pin, complex along the line to the slide's pin [m].
        crank_inertia, rod_inertia: about the centres of mass, about the shaft's direction [kg m2].
        drawn_angle: of the crank in the drawn pose, in its positive sense from where its pin points at the slide [rad].
        shaft: (3,) point on the shaft's axis, at the height of the crank pin, world axes [m].
        direction: (3,) unit vector from the shaft to the slide's pin. across: (3,) the same turned by 90 degrees with the crank.
    """

    crank: str
    rod: str
    slide: str
    crank_radius: float
    rod_length: float
    crank_mass: float
    rod_mass: float
    slide_mass: float
    crank_centre: complex
    rod_centre: complex
    crank_inertia: float
    rod_inertia: float
    drawn_angle: float
    shaft: Array
    direction: Array
    across: Array

    @property
    def ratio(self) -> float:
        """Lambda, crank radius by rod length."""
        return self.crank_radius / self.rod_length

    @property
    def drawn_crank(self) -> complex:
        """Unit number along the crank in the drawn pose; see `point`."""
        return complex(np.exp(1j * self.drawn_angle))

    @property
    def drawn_rod(self) -> complex:
        """The same along the drawn rod, from the crank pin to the slide's."""
        pin = self.crank_radius * self.drawn_crank
        return complex((reach(self.crank_radius, self.rod_length, self.drawn_angle) - pin) / self.rod_length)

    def point(self, number: complex) -> Array:
        """World position (3,) of a number from the shaft, in the drawn pose: its real part along the slide's line, i across [m]."""
        return np.asarray(self.shaft + number.real * self.direction + number.imag * self.across)

    @property
    def rod_share(self) -> complex:
        """Of the rod's mass that static substitution puts at the slide's pin."""
        return self.rod_centre / self.rod_length

    @property
    def rotating_product(self) -> complex:
        """Mass times radius of what turns with the crank: the crank and the rod's share at the crank pin [kg m]."""
        return self.crank_mass * self.crank_centre + self.crank_radius * self.rod_mass * (1 - self.rod_share)

    @property
    def reciprocating_mass(self) -> complex:
        """Of what moves with the slide: the slide and the rod's share at its pin [kg]. Complex where the rod's centre is off its line."""
        return self.slide_mass + self.rod_mass * self.rod_share

    @property
    def residual_inertia(self) -> float:
        """J - m a (l - a) of a rod with its centre at a on its line: times the rod's angular acceleration, it is the moment that
        static substitution leaves out [kg m2]. Negative for rods whose mass is between the pins: of a uniform one - m l^2 / 6."""
        return self.rod_inertia - self.rod_mass * (self.rod_centre.real * self.rod_length - abs(self.rod_centre) ** 2)


@typed
def crank_slide(press: Linkage) -> CrankSlide:
    """The crank-slide that a linkage is, drawn in any pose, in whatever direction its slide moves.

    Raises:
        PinpressError: it is none, or its slide's pin does not move on a line through the shaft; the message says what differs.
    """
    if press.plane is None or len(press.drivers) > 1:
        raise _refusal(press, "it is not planar, or has several drivers")
    plane, at = press.plane, poses(press, press.closed[None])
    crank, rod, slide = _bodies(press)
    pins = {frozenset((int(press.model.parents[j]), j)): at.position[j, 0] for j in range(1, len(press.joints) + 1)}
    pins |= {frozenset((loop.joint1, loop.joint2)): at.points(loop.joint1, loop.point1)[0] for loop in press.loops}
    if not {frozenset((crank, rod)), frozenset((rod, slide))} <= pins.keys():
        raise _refusal(press, f"its third link, {shown(press.link_of(rod))}, does not connect crank and slide")
    crank_pin, slide_pin = pins[frozenset((crank, rod))], pins[frozenset((rod, slide))]
    shaft = at.position[crank, 0]
    shaft = shaft + ((crank_pin - shaft) @ plane.normal) * plane.normal  # its point at the crank pin's height
    radius, length = (complex(flat(plane, end - start)) for start, end in ((shaft, crank_pin), (crank_pin, slide_pin)))
    guide = complex(flat(plane, at.rotation[slide, 0] @ press.axes[slide - 1].direction))
    along = (radius + length) / guide
    if abs(along.imag) > CENTRED * abs(length):
        raise _refusal(press, f"its slide's pin moves {abs(along.imag):.6g} m beside the shaft")
    if not 0 < abs(radius) < abs(length):
        raise _refusal(press, f"its crank, {abs(radius):.6g} m, is not shorter than its rod, {abs(length):.6g} m")
    towards = guide * np.sign(along.real)
    inertias = press.model.inertias

    def centre(body: int, pin: Array, line: complex) -> complex:
        """Of mass, from a pin, along the line of the link's pins."""
        return complex(flat(plane, at.points(body, inertias[body].lever)[0] - pin)) * abs(line) / line

    direction, across = in_space(plane, np.array([towards, 1j * towards]))
    for array in (shaft, direction, across):
        array.setflags(write=False)
    return CrankSlide(
        crank=press.link_of(crank),
        rod=press.link_of(rod),
        slide=press.slide or press.link_of(slide),
        crank_radius=abs(radius),
        rod_length=abs(length),
        crank_mass=float(inertias[crank].mass),
        rod_mass=float(inertias[rod].mass),
        slide_mass=float(inertias[slide].mass),
        crank_centre=centre(crank, shaft, radius),
        rod_centre=centre(rod, crank_pin, length),
        crank_inertia=_inertia(plane, press, crank),
        rod_inertia=_inertia(plane, press, rod),
        drawn_angle=float(np.angle(radius / towards)),
        shaft=shaft,
        direction=direction,
        across=across,
    )


def reach(crank_radius: float, rod_length: float, angle: float) -> float:
    """Distance of the slide's pin from the shaft at a crank angle [rad] from where the crank pin points at it [m]."""
    return float(crank_radius * np.cos(angle) + np.sqrt(rod_length**2 - (crank_radius * np.sin(angle)) ** 2))


def harmonic_coefficients(ratio: float, orders: int = 6) -> Array:
    """Harmonics of the slide's acceleration: the A_k (orders + 1,) in r w^2 (cos q + A_2 cos 2q + A_4 cos 4q + ...), A_1 = 1, of a
    centred crank-slide whose crank turns evenly; towards the shaft is positive, q = 0 where the slide is farthest from it.

    To rounding, for every lambda: with z = exp(2 i q), sqrt(1 - lambda^2 sin^2 q) is sqrt(1 + b z) sqrt(1 + b / z) / (1 + b), where
    b = (lambda / (1 + sqrt(1 - lambda^2)))^2, and its binomial series in b are multiplied. A_2 = lambda + lambda^3 / 4 + ...,
    A_4 = - lambda^3 / 4 - ...; Zhang 2007, eq. 3.2.2, has A_2 = lambda alone.

    Args:
        ratio: lambda, crank radius by rod length, between 0 and 1. orders: the highest order.

    Raises:
        PinpressError: a ratio that is not between 0 and 1, orders that are no whole number from 1.
    """
    ratio = positive("ratio of crank radius to rod length", ratio, "-")
    if not ratio <= LARGEST_RATIO:
        raise PinpressError(
            f"ratio is {shown(ratio)}: for a full turn the crank must be shorter than the rod; give at most {LARGEST_RATIO!r}"
        )
    orders = whole_number("orders", orders, 1, 10**5)
    root = ratio / (1 + np.sqrt((1 - ratio) * (1 + ratio)))
    base, terms = root**2, 2 + int(np.log(SMALLEST_TERM) / (4 * np.log(root)))
    binomials = np.concatenate([[1.0], np.cumprod(1.5 / np.arange(1, terms + orders // 2) - 1)])  # of 1/2
    powers = binomials[:terms] * base ** (2 * np.arange(terms))
    coefficients = np.zeros(orders + 1)
    coefficients[1] = 1.0
    for k in range(1, orders // 2 + 1):
        coefficients[2 * k] = 8 * k**2 / ratio * base**k / (1 + base) * (binomials[k : k + terms] @ powers)
    coefficients.setflags(write=False)
    return coefficients


@typed
def complete_balance(press: Linkage, rod_radius: float, crank_radius: float) -> tuple[Counterweight, Counterweight]:
    """Counterweights on rod and crank with which the press's centre of mass stands still: its shaking force is its weight alone.
    Zhang 2007, 3.3, with its m' corrected.

    On the rod, opposite to the slide: m'' r2 = m2 h2 + m3 l2, so that with it rod and slide weigh m_B = m'' + m2 + m3 in the crank pin. On
    the crank, opposite to the pin: m' r1 = m_B l1 + m1 h1 (as our text of the thesis reads, it has m2 l1 for m_B l1). As vectors: on the
    side away from the centre of what they balance. Moment and driving torque are not balanced, and mostly grow.

    Args:
        rod_radius: from the crank pin to the rod's counterweight. crank_radius: from the shaft to the crank's [m].

    Returns:
        Point masses on rod and crank, for `with_counterweights`.

    Raises:
        PinpressError: no centred crank-slide (see `crank_slide`), a radius that is not positive.
    """
    main = crank_slide(press)
    product = -(main.rod_mass * main.rod_centre + main.slide_mass * main.rod_length) * main.drawn_rod
    on_rod = _correction(press, main, main.rod, main.crank_radius * main.drawn_crank, product).counterweight(main.rod, rod_radius)
    at_pin = on_rod.mass + main.rod_mass + main.slide_mass
    return on_rod, _on_crank(press, main, at_pin * main.crank_radius + main.crank_mass * main.crank_centre, crank_radius)


@typed
def approximate_balance(press: Linkage, radius: float, share: float = 0.5) -> Counterweight:
    """A counterweight on the crank for what turns and a share of what reciprocates. Zhang 2007, 3.4.

    m r = m1 e + k m2 b / l + share k m_C, opposite to the crank pin (as vectors), with m_C = m3 + m2 a / l. At constant speed w this is
    left of the shaking force, beside the weight: of first order (1 - share) m_C k w^2 along the slide's line, share m_C k w^2 across it;
    the higher orders, m_C k w^2 A_2 and so on along it, stay as they are (`harmonic_coefficients`). Where the rod's centre is off its
    line, m_C is complex, and both directions are turned by its angle.

    Args:
        radius: from the shaft to the counterweight [m]. share: from 0 (what turns alone) to 1 (the first order is all across).

    Returns:
        A point mass on the crank, for `with_counterweights`.

    Raises:
        PinpressError: no centred crank-slide (see `crank_slide`), a radius that is not positive, a share that is not from 0 to 1.
    """
    if not is_number(share) or not 0 <= share <= 1:
        raise PinpressError(f"share is {shown(share)}: give the part of the reciprocating mass to be balanced, from 0 to 1")
    main = crank_slide(press)
    return _on_crank(press, main, main.rotating_product + share * main.crank_radius * main.reciprocating_mass, radius)


def _on_crank(press: Linkage, main: CrankSlide, product: complex, radius: float) -> Counterweight:
    """On the crank, against a mass times radius that is along the line from shaft to crank pin."""
    return _correction(press, main, main.crank, 0j, -product * main.drawn_crank).counterweight(main.crank, radius)


def _correction(press: Linkage, main: CrankSlide, link: str, centre: complex, product: complex) -> Correction:
    """In the frame of a link; numbers are along the slide's line and across it, from the shaft, in the drawn pose."""
    body = press.model.frames[press.model.getFrameId(link)].parentJoint
    at = poses(press, press.closed[None])
    into = at.rotation[body, 0].T
    return Correction(into @ (main.point(product) - main.shaft), into @ (main.point(centre) - at.position[body, 0]))


def _bodies(press: Linkage) -> tuple[int, int, int]:
    """The Pinocchio joints that carry crank, rod and slide."""
    parents, turns = press.model.parents, [axis.turns for axis in press.axes]
    if len(press.joints) != 3 or len(press.loops) != 1 or press.couplings:
        counts = f"{len(press.joints)} moving links, {len(press.loops)} loops and {len(press.couplings)} gear pairs"
        raise _refusal(press, f"it has {counts}, not 3, 1 and 0")
    crank = press.driver_indices[0] + 1
    guided = [j for j in range(1, 4) if parents[j] == 0 and not turns[j - 1]]
    if parents[crank] != 0:
        raise _refusal(press, f"its driver {shown(press.driver)} does not turn on the frame")
    if len(guided) != 1 or not all(turns[j - 1] for j in range(1, 4) if j not in guided):
        raise _refusal(press, "it has not one guide, on the frame, and else pins")
    (rod,) = (j for j in range(1, 4) if j not in (crank, guided[0]))
    return crank, rod, guided[0]


def _inertia(plane: Plane, press: Linkage, body: int) -> float:
    """Of a body about its centre of mass, about the normal [kg m2]."""
    normal = plane.frames[body - 1][2]
    return float(normal @ press.model.inertias[body].inertia @ normal)


def _refusal(press: Linkage, problem: str) -> PinpressError:
    return PinpressError(
        f"{press.name} is no centred crank-slide: {problem}; give a press of crank, rod and slide, guided through the shaft"
    )
