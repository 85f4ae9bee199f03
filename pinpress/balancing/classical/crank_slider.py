"""The centred crank-slider: its lengths and masses, the harmonics of its slide, its counterweights, and a comparison of harmonics.

Points of a link are complex numbers along the line of its pins. The real part points to the far pin. The imaginary part points across the
line, to the side to which the line would turn with the crank. Static substitution replaces a rod of mass m, whose centre is at the share k
of its length (complex if it is off the line), by m (1 - k) at the crank pin and m k at the slide's pin. The inertia force of these masses
equals that of the rod. Their moment does not (`CrankSlider.residual_inertia`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...common.arguments import expect, positive, suitable_numbers, typed, whole_number
from ...common.errors import PinpressError, shown
from ...common.frozen import read_only
from ...common.quantities import Array
from ...common.results import Record, Records
from ...dynamics.harmonics import harmonics
from ...dynamics.reactions import Reactions
from ...engines.planar.model import Plane, to_complex, to_world
from ...kinematics.poses import Poses, poses
from ...linkage.linkage import Linkage
from ..counterweights import Counterweight
from .rotor import Correction

CENTRED = 1e-9  # a smaller offset of the slide's line from the shaft, as a share of the linkage's size, is rounding error
LINE, SPACE = ("along", "across"), "xyz"  # parts of a complex number and of a vector in a table


@dataclass(frozen=True, eq=False, repr=False)
class CrankSlider(
    Record,
    units={
        **dict.fromkeys(("crank_radius", "rod_length", "crank_centre", "rod_centre", "shaft"), "m"),
        **dict.fromkeys(("crank_mass", "rod_mass", "slide_mass"), "kg"),
        **dict.fromkeys(("crank_inertia", "rod_inertia"), "kg m2"),
        "drawn_angle": "rad",
    },
    parts={"crank_centre": LINE, "rod_centre": LINE, "shaft": SPACE, "direction": SPACE, "across": SPACE},
):
    """Lengths, masses and centres of mass of a centred crank-slider, for its balancing.

    Attributes:
        crank: name of the crank's link.
        rod: name of the rod's link.
        slide: name of the slide's link.
        crank_radius: distance from the shaft to the crank pin [m].
        rod_length: distance from the crank pin to the slide's pin [m].
        crank_mass: mass of the crank with the parts welded to it [kg].
        rod_mass: mass of the rod with the parts welded to it [kg].
        slide_mass: mass of the slide with the parts welded to it [kg].
        crank_centre: centre of mass of the crank from the shaft, complex along the line to the crank pin [m].
        rod_centre: centre of mass of the rod from the crank pin, complex along the line to the slide's pin [m].
        crank_inertia: moment of inertia of the crank about the shaft's direction through its centre of mass [kg m2].
        rod_inertia: moment of inertia of the rod about the shaft's direction through its centre of mass [kg m2].
        drawn_angle: positive angle of the crank in the drawn pose, 0 with the crank pin towards the slide [rad].
        shaft: (3,) point on the shaft's axis at the height of the crank pin, in world axes [m].
        direction: (3,) unit vector from the shaft to the slide's pin, in world axes.
        across: (3,) unit vector ``direction`` turned by 90 degrees with the crank, in world axes.
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
        """Lambda, the crank radius divided by the rod length [-]."""
        return self.crank_radius / self.rod_length

    @property
    def drawn_crank(self) -> complex:
        """Unit number along the crank in the drawn pose; see `point`."""
        return complex(np.exp(1j * self.drawn_angle))

    @property
    def drawn_rod(self) -> complex:
        """Unit number along the rod in the drawn pose, from the crank pin to the slide's pin; see `point`."""
        pin = self.crank_radius * self.drawn_crank
        return complex((self.drawn_reach - pin) / self.rod_length)

    @property
    def drawn_reach(self) -> float:
        """Distance of the slide's pin from the shaft in the drawn pose [m]."""
        radius, length, angle = self.crank_radius, self.rod_length, self.drawn_angle
        return float(radius * np.cos(angle) + np.sqrt(length**2 - (radius * np.sin(angle)) ** 2))

    def point(self, number: complex) -> Array:
        """World position (3,) of a complex number from the shaft: its real part along ``direction``, its imaginary part ``across`` [m]."""
        return np.asarray(self.shaft + number.real * self.direction + number.imag * self.across)

    @property
    def rod_share(self) -> complex:
        """Share of the rod's mass that static substitution puts at the slide's pin [-]."""
        return self.rod_centre / self.rod_length

    @property
    def rotating_product(self) -> complex:
        """Mass times radius of the rotating masses: the crank, and the rod's share at the crank pin [kg m]."""
        return self.crank_mass * self.crank_centre + self.crank_radius * self.rod_mass * (1 - self.rod_share)

    @property
    def reciprocating_mass(self) -> complex:
        """Mass of the slide and of the rod's share at the slide's pin [kg]; complex if the rod's centre is off its line."""
        return self.slide_mass + self.rod_mass * self.rod_share

    @property
    def residual_inertia(self) -> float:
        """J - m a (l - a) for a rod with its centre at a on its line [kg m2].

        This number times the rod's angular acceleration is the moment that static substitution neglects. It is negative for rods whose
        mass is between the pins: - m l^2 / 6 for a uniform rod.
        """
        return self.rod_inertia - self.rod_mass * (self.rod_centre.real * self.rod_length - abs(self.rod_centre) ** 2)


@typed
def as_crank_slider(press: Linkage) -> CrankSlider:
    """Read lengths and masses of a centred crank-slider, in any drawn pose and with any direction of the slide.

    Raises:
        PinpressError: the press is not a centred crank-slider; the message names the difference.
    """
    plane = press.plane_or_refuse(str(_refusal(press, "it is not planar, or has several drivers")))
    drawn_poses = poses(press, press.closed[None])
    crank, rod, slide = _bodies(press)
    shaft, crank_pin, slide_pin = _pins(press, plane, drawn_poses, crank, rod, slide)
    radius, length = complex(to_complex(plane, crank_pin - shaft)), complex(to_complex(plane, slide_pin - crank_pin))
    guide = complex(to_complex(plane, drawn_poses.rotation[slide, 0] @ press.axes[slide - 1].direction))
    along = (radius + length) / guide
    if abs(along.imag) > CENTRED * abs(length):
        raise _refusal(press, f"the line of its slide's pin passes the shaft at {abs(along.imag):.6g} m")
    if not 0 < abs(radius) < abs(length):
        raise _refusal(press, f"its crank, {abs(radius):.6g} m, is not shorter than its rod, {abs(length):.6g} m")
    towards = guide * np.sign(along.real)
    direction, across = to_world(plane, np.array([towards, 1j * towards]))
    inertias = press.model.inertias

    def centre(body: int, pin: Array, line: complex) -> complex:
        """Centre of mass from a pin, along the line of the link's pins."""
        return complex(to_complex(plane, drawn_poses.points(body, inertias[body].lever)[0] - pin)) * abs(line) / line

    def inertia(body: int) -> float:
        """Moment of inertia about the plane's normal through the centre of mass."""
        normal = plane.frames[body - 1][2]
        return float(normal @ inertias[body].inertia @ normal)

    return CrankSlider(
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
        crank_inertia=inertia(crank),
        rod_inertia=inertia(rod),
        drawn_angle=float(np.angle(radius / towards)),
        shaft=shaft,
        direction=direction,
        across=across,
    )


def harmonic_coefficients(ratio: float, orders: int = 6) -> Array:
    """Harmonics A_k of the slide's acceleration r w^2 (cos q + A_2 cos 2q + A_4 cos 4q + ...) in a centred crank-slider.

    The crank turns at constant speed w. The acceleration is positive towards the shaft; at q = 0 the slide is farthest from the shaft.

    The coefficients are exact within rounding error for every lambda. With z = exp(2 i q) and b = (lambda / (1 + sqrt(1 - lambda^2)))^2,
    sqrt(1 - lambda^2 sin^2 q) is sqrt(1 + b z) sqrt(1 + b / z) / (1 + b). The function multiplies the binomial series of both roots:
    A_2 = lambda + lambda^3 / 4 + ..., A_4 = - lambda^3 / 4 - ... Zhang 2007, eq. 3.2.2, has only A_2 = lambda.

    Args:
        ratio: lambda, the crank radius divided by the rod length, between 0 and 1 [-].
        orders: highest order.

    Returns:
        (orders + 1,) A_0 to A_orders [-]; A_1 = 1.

    Raises:
        PinpressError: the ratio is not between 0 and 1, or orders is not a whole number of at least 1.
    """
    ratio = positive("ratio of crank radius to rod length", ratio, "-")
    largest = 1 - 1e-9  # nearer to 1 the series has millions of terms
    if not ratio <= largest:
        raise PinpressError(
            f"ratio is {shown(ratio)}, too large for a full turn, in which the crank must be shorter than the rod: give at most {largest!r}"
        )
    orders = whole_number("orders", orders, 1, 10**5)
    root = ratio / (1 + np.sqrt((1 - ratio) * (1 + ratio)))
    base, terms = root**2, 2 + int(np.log(1e-18) / (4 * np.log(root)))  # down to 1e-18 of the first term
    binomials = np.concatenate([[1.0], np.cumprod(1.5 / np.arange(1, terms + orders // 2) - 1)])  # of 1/2
    powers = binomials[:terms] * base ** (2 * np.arange(terms))
    coefficients = np.zeros(orders + 1)
    coefficients[1] = 1.0
    for k in range(1, orders // 2 + 1):
        coefficients[2 * k] = 8 * k**2 / ratio * base**k / (1 + base) * (binomials[k : k + terms] @ powers)
    return read_only(coefficients)


@typed
def complete_balance(press: Linkage, *, rod_radius: float, crank_radius: float) -> Records[Counterweight]:
    """Compute counterweights on rod and crank that keep the press's centre of mass at rest, so the shaking force is only the weight.

    Zhang 2007, 3.3, with m' corrected. The counterweight on the rod, opposite to the slide, has m'' r2 = m2 h2 + m3 l2. Then rod and slide
    act on the crank pin as the mass m_B = m'' + m2 + m3. The counterweight on the crank, opposite to the pin, has m' r1 = m_B l1 + m1 h1
    (our copy of the thesis prints m2 l1 for m_B l1). If centres of mass are off the lines, these are sums of vectors. Moment and driving
    torque are not balanced and usually grow.

    Args:
        press: a centred crank-slider.
        rod_radius: distance from the crank pin to the rod's counterweight [m].
        crank_radius: distance from the shaft to the crank's counterweight [m].

    Returns:
        Point masses on rod and crank, for `with_counterweights`.

    Raises:
        PinpressError: the press is not a centred crank-slider (see `as_crank_slider`), or a radius is not positive.
    """
    main = as_crank_slider(press)
    product = -(main.rod_mass * main.rod_centre + main.slide_mass * main.rod_length) * main.drawn_rod
    on_rod = _correction(press, main, main.rod, main.crank_radius * main.drawn_crank, product).counterweight(main.rod, rod_radius)
    at_pin = on_rod.mass + main.rod_mass + main.slide_mass
    on_crank = _on_crank(press, main, at_pin * main.crank_radius + main.crank_mass * main.crank_centre, crank_radius)
    return Records(Counterweight, (on_rod, on_crank))


@typed
def approximate_balance(press: Linkage, radius: float, *, share: float = 0.5) -> Counterweight:
    """Compute the counterweight on the crank for all rotating masses and a share of the reciprocating mass. Zhang 2007, 3.4.

    Opposite to the crank pin, it has m r = m1 e + k m2 b / l + share k m_C (a sum of vectors), with the crank radius k and the
    reciprocating mass m_C = m3 + m2 a / l. At constant speed w the shaking force keeps the weight, the first order with
    (1 - share) m_C k w^2 along the slide's line and share m_C k w^2 across it, and all higher orders along the line, m_C k w^2 A_2 and so
    on (`harmonic_coefficients`). If the rod's centre is off its line, m_C is complex, and its angle turns both directions.

    Args:
        press: a centred crank-slider.
        radius: distance from the shaft to the counterweight [m].
        share: balanced share of the reciprocating mass, from 0 (only rotating masses) to 1 (the whole first order is across the line) [-].

    Returns:
        A point mass on the crank, for `with_counterweights`.

    Raises:
        PinpressError: the press is not a centred crank-slider (see `as_crank_slider`), the radius is not positive, or the share is not
            from 0 to 1.
    """
    expected = "the part of the reciprocating mass to be balanced, from 0 to 1"
    suitable_numbers("share", share, expected, suits=lambda part: 0 <= part <= 1)
    main = as_crank_slider(press)
    return _on_crank(press, main, main.rotating_product + share * main.crank_radius * main.reciprocating_mass, radius)


@dataclass(frozen=True, repr=False)
class HarmonicChange(Record):
    """A harmonic before and after a change of the press.

    Attributes:
        quantity: "force along the slide" (vertical in an upright press), "force across the slide" (lateral) or "tilting moment".
        unit: "N" or "N m".
        order: frequency / frequency of the crank, possibly a fraction for a press that repeats only after several turns [-].
        before: amplitude before the change [unit].
        after: amplitude after the change [unit].
        change: "cancelled" (only rounding error remains), "reduced", "unchanged", "raised", or "none" (both amplitudes are rounding error).
    """

    quantity: str
    unit: str
    order: float
    before: float
    after: float
    change: str

    @property
    def title(self) -> str:
        amplitudes = f"{self.before:.6g} to {self.after:.6g} {self.unit}"
        return f"HarmonicChange of the {self.quantity}, order {self.order:g}: {amplitudes}, {self.change}"


@typed
def compare_harmonics(before: Reactions, after: Reactions, *, orders: int = 6) -> Records[HarmonicChange]:
    """Compare the harmonics of the shaking force and of the tilting moment of two presses.

    The moment is about the shaft of the press before the change. An amplitude is rounding error below 1e-12 of the largest bearing force,
    or of this force times the linkage's size.

    Args:
        before: reactions of a planar press over at least one period.
        after: reactions of the changed press at the same speed.
        orders: highest order.

    Returns:
        Changes by quantity, then by order.

    Raises:
        PinpressError: a press is not planar or has no slide; the motions have different speeds, no full period, or too few states for the
            orders.
    """
    for reactions in (before, after):
        expect("reactions", reactions, Reactions, "inverse_dynamics")
    press, (speed, speed_after) = before._press, (np.abs(reactions.motion.crank_speed).max() for reactions in (before, after))
    normal = press.plane_or_refuse(f"{press.name} is not planar: take the harmonics of its shaking force axis by axis").normal
    if not abs(speed_after - speed) <= 1e-9 * speed:
        raise PinpressError("before and after have different speeds, but forces grow with speed squared: give both the same speed")
    drawn_poses, along = poses(press, press.closed[None]), press.slide_direction
    axes = np.array([along, np.cross(normal, along)])
    shaft = drawn_poses.position[press.driver_indices[0] + 1, 0]
    (first, least1), (second, least2) = (_amplitudes(reactions, axes, normal, shaft, orders) for reactions in (before, after))
    none = np.zeros(3)
    quantities = (("force along the slide", "N"), ("force across the slide", "N"), ("tilting moment", "N m"))
    return Records(
        HarmonicChange,
        (
            HarmonicChange(quantity, unit, order, was, now, _change(was, now, max(least1[k], least2[k])))
            for k, (quantity, unit) in enumerate(quantities)
            for order in sorted({*first, *second})
            for was, now in [(float(first.get(order, none)[k]), float(second.get(order, none)[k]))]
        ),
    )


def _bodies(press: Linkage) -> tuple[int, int, int]:
    """The Pinocchio joints that carry crank, rod and slide."""
    parents, turns = press.model.parents, [axis.turns for axis in press.axes]
    if len(press.joints) != 3 or len(press.loops) != 1 or press.relations:
        counts = f"{len(press.joints)} moving links, {len(press.loops)} loops and {len(press.relations)} gear pairs"
        raise _refusal(press, f"it has {counts}, not 3, 1 and 0")
    crank = press.driver_indices[0] + 1
    guided = [j for j in range(1, 4) if parents[j] == 0 and not turns[j - 1]]
    if parents[crank] != 0:
        raise _refusal(press, f"its driver {shown(press.driver)} does not turn on the frame")
    if len(guided) != 1 or not all(turns[j - 1] for j in range(1, 4) if j not in guided):
        raise _refusal(press, "its joints are not pins and one guide on the frame")
    (rod,) = (j for j in range(1, 4) if j not in (crank, guided[0]))
    return crank, rod, guided[0]


def _pins(press: Linkage, plane: Plane, at: Poses, crank: int, rod: int, slide: int) -> tuple[Array, Array, Array]:
    """World positions (3,) of the shaft, at the crank pin's height, of the crank pin and of the slide's pin in the drawn pose [m]."""
    pins = {frozenset((int(press.model.parents[j]), j)): at.position[j, 0] for j in range(1, len(press.joints) + 1)}
    pins |= {frozenset((loop.joint1, loop.joint2)): at.points(loop.joint1, loop.point1)[0] for loop in press.loops}
    if not {frozenset((crank, rod)), frozenset((rod, slide))} <= pins.keys():
        raise _refusal(press, f"its third link, {shown(press.link_of(rod))}, does not connect crank and slide")
    crank_pin, slide_pin, shaft = pins[frozenset((crank, rod))], pins[frozenset((rod, slide))], at.position[crank, 0]
    return shaft + ((crank_pin - shaft) @ plane.normal) * plane.normal, crank_pin, slide_pin


def _refusal(press: Linkage, problem: str) -> PinpressError:
    """The error that a press is not a centred crank-slider."""
    return PinpressError(
        f"{press.name} is not a centred crank-slider: {problem}; give a press of crank, rod and slide whose line passes through the shaft"
    )


def _on_crank(press: Linkage, main: CrankSlider, product: complex, radius: float) -> Counterweight:
    """The counterweight on the crank that balances a mass times radius, complex along the line from shaft to crank pin [kg m]."""
    return _correction(press, main, main.crank, 0j, -product * main.drawn_crank).counterweight(main.crank, radius)


def _correction(press: Linkage, main: CrankSlider, link: str, centre: complex, product: complex) -> Correction:
    """The correction in the frame of a link.

    ``centre`` [m] and ``product`` [kg m] are complex numbers from the shaft in the drawn pose, as of `CrankSlider.point`.
    """
    body, drawn_poses = press.frame_of(link).parentJoint, poses(press, press.closed[None])
    into = drawn_poses.rotation[body, 0].T
    return Correction(into @ (main.point(product) - main.shaft), into @ (main.point(centre) - drawn_poses.position[body, 0]))


def _amplitudes(
    reactions: Reactions, axes: Array, normal: Array, shaft: Array, orders: int
) -> tuple[dict[float, Array], tuple[float, float, float]]:
    """Order -> (3,) amplitudes of the forces along and across and of the moment about the shaft, and their rounding limits."""
    force = reactions.shaking_force
    moment = (reactions.shaking_moment - np.cross(shaft, force)) @ normal
    spectrum = harmonics(reactions.motion, np.column_stack([force @ axes.T, moment]), orders)
    turns = reactions.motion.period_turns or 1
    if spectrum is None or len(spectrum.orders) <= orders * turns:
        raise PinpressError(
            f"the motion of {reactions.motion.linkage} does not have a full period of {2 * orders * turns + 1} states: use cycle(...,"
            " points=...)"
        )
    least = 1e-12 * max(float(np.abs(values).max()) for values in (force, *reactions.bearing_force.values()))
    by_order = zip(spectrum.orders[1:].tolist(), spectrum.amplitude[1:], strict=True)
    limits = least, least, least * reactions._press.size
    return {int(order) if order.is_integer() else order: amplitude for order, amplitude in by_order}, limits


def _change(before: float, after: float, least: float) -> str:
    """The word for a change of an amplitude, as in `HarmonicChange`; below ``least`` an amplitude is rounding error."""
    if after <= least:
        return "none" if before <= least else "cancelled"
    if abs(after - before) <= max(least, 1e-9 * before):
        return "unchanged"
    return "reduced" if after < before else "raised"
