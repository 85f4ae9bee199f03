"""The classical arrangements that balance a rotor or a crank press, after Zhang 2007, chapter 3; `pinpress.balancing.classical.<function>`.

    press = pp.load("jf75g_125_plain")
    arrangements.complete_balance(press, rod_radius=0.3, crank_radius=0.15)   # counterweights for with_counterweights
    arrangements.opposed(press, crank_radius=0.03)                            # a new press, as is
    arrangements.symmetric(press, shaft_distance=0.5)

| arrangement | Zhang 2007 | what is left of the shaking force, beside the weight | and of the moment |
|---|---|---|---|
| `static_balance`, `two_plane_balance` of a rotor | 3.1.1 | nothing | a couple; nothing |
| `complete_balance` | 3.3 | nothing | larger than before |
| `approximate_balance` | 3.4 | first order (1 - share) along, share across; higher orders along | changed |
| `opposed`, same ratio of rod and crank | 3.5 | nothing | odd orders, from the rods' inertia |
| `symmetric` of a crank-slide | 3.6 | all along the slide, nothing across | nothing |
| `symmetric` of an opposed one | 3.6 | nothing | nothing |

`crank_slide` reads lengths and masses, `unbalance` that of a rotor in a model, `harmonic_coefficients` gives the orders of a crank-slide's
forces and `cancelled` compares those of two presses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...common.arguments import typed
from ...common.arrays import Array
from ...common.checks import positive
from ...common.errors import PinpressError, expect
from ...dynamics.harmonics import harmonics
from ...dynamics.inverse_dynamics import Reactions
from ...kinematics.poses import poses
from ...linkage.linkage import Linkage
from .crank_slider import CENTRED, CrankSlide, approximate_balance, complete_balance, crank_slide, harmonic_coefficients
from .mirrored_press import built, doubled, plan, with_auxiliary
from .rotor import Correction, Unbalance, static_balance, two_plane_balance, unbalance

__all__ = [
    "Correction",
    "CrankSlide",
    "HarmonicChange",
    "Unbalance",
    "approximate_balance",
    "cancelled",
    "complete_balance",
    "crank_slide",
    "harmonic_coefficients",
    "opposed",
    "static_balance",
    "symmetric",
    "two_plane_balance",
    "unbalance",
]

ROUNDING = 1e-12  # of the largest bearing force: harmonics that small are none
UNCHANGED = 1e-9  # of an amplitude: a change that is none
SAME_SPEED = 1e-9  # of a speed: a difference that is none


@typed
def opposed(
    press: Linkage,
    crank_radius: float,
    rod_length: float | None = None,
    rod_mass: float | None = None,
    rod_inertia: float | None = None,
) -> Linkage:
    """The press with an auxiliary crank-slide turned by 180 degrees about its shaft, which moves a counterweight against the slide.
    Zhang 2007, 3.5.

    The auxiliary crank is part of the crank, opposite to the crank pin; new are the links "auxiliary_rod" and "counterweight", the joints
    "auxiliary_pin" and "counterweight_guide" and the loop "counterweight_pin". They are sized (index 1 the main crank-slide, 2 the
    auxiliary one; centres of mass as vectors along the links) by

        m_crank2 e2 + m_rod2 r2 (1 - a2 / l2) = m_crank1 e1 + m_rod1 r1 (1 - a1 / l1)    what turns
        (m_counterweight + m_rod2 a2 / l2) r2 = (m_slide + m_rod1 a1 / l1) r1            what reciprocates

    where the auxiliary rod has its centre of mass at the same part of its length, the auxiliary crank the mass m_crank1 r1 / r2, its
    centre where the first equation puts it (beyond the shaft for a heavy rod), and the moment of inertia of a crank of the same shape.
    By default the auxiliary crank-slide is the main one with lengths times r2 / r1 and masses times r1 / r2.

    They lie in the plane of the crank pin, and the counterweight's centre of mass is at its pin.

    What is left: with the same lambda no force but the weight, in any order, along the slide's line or across it, however the crank turns.
    With another rod length, at constant speed w the even orders k from 2 along the line, m_C r1 w^2 |A_k(lambda1) - A_k(lambda2)|
    (`harmonic_coefficients`), m_C being the main reciprocating mass. The moment with which the guides' forces tilt the frame is left, and
    by default grows: - (J1 + J2) times the angular acceleration of the rods, in the odd orders, J being `CrankSlide.residual_inertia`
    (from eq. 3.5.20 on the thesis takes that acceleration for zero). It vanishes too with rod_inertia = m_rod2 a2 (l2 - a2) - J1, where
    lambda is the same and the rods' centres are on their lines; such a rod has mass beyond its pins.

    Args:
        crank_radius: of the auxiliary crank, r2 [m]. rod_length: of its rod, l2 [m]; default: l1 r2 / r1, the same lambda.
        rod_mass: of the auxiliary rod [kg]; default: m_rod1 r1 / r2. rod_inertia: about its centre of mass [kg m2]; default: of a rod of
            the same shape, J_rod1 m_rod2 / m_rod1 (l2 / l1)^2.

    Returns:
        A press that is in memory alone; `write_urdf` writes it. It is drawn as ``press`` is, with the same crank angle, gravity, names and
        inertias, but without visuals.

    Raises:
        PinpressError: no centred crank-slide (see `crank_slide`); a size that is not positive, a rod no longer than its crank, a rod so
            heavy that no mass is left for the counterweight.
    """
    main = crank_slide(press)
    auxiliary = _auxiliary(main, crank_radius, rod_length, rod_mass, rod_inertia)
    return built(
        replace(with_auxiliary(plan(press), main, auxiliary), name=f"{press.name}_opposed"),
        "A crank-slide and, turned by 180 degrees about its shaft, an auxiliary one with a counterweight (Zhang 2007, 3.5). SI units.",
    )


@typed
def symmetric(press: Linkage, shaft_distance: float) -> Linkage:
    """Two halves of a press, one the mirror image of the other, on two shafts that a gear pair lets turn against each other, with the slide
    (and the counterweight) in common. Zhang 2007, 3.6.

    The press, a centred crank-slide or an `opposed` one, is shifted by half the distance of the shafts against the direction to which the
    crank turns from bottom dead centre, the left half, and mirrored about the line on which its shaft was, the right one. Whatever does not
    slide on the frame is there twice then, with "_left" and "_right" behind its name and half of its mass; the left shaft is driven, the
    right one mimics it by -1. Forces across the slide's line and moments about the middle vanish at any speed, also under a central load
    on the slide; those along it stay as they are. A slide whose centre of mass is beside the line of its pin keeps its own moment.

    Args:
        shaft_distance: [m]; that the halves do not collide is for the drawing to see.

    Returns:
        A press that is in memory alone, with the crank angle, gravity, names, masses and strokes of ``press``, without visuals.

    Raises:
        PinpressError: a press that is not planar with one driver on the frame, has gear pairs, no slide, guides in several directions,
            or a slide whose pin does not move on a line through the shaft; a distance that is not positive.
    """
    distance, drawn = positive("shaft_distance", shaft_distance, "m"), plan(press)
    crank = next(each for each in drawn.bodies if each.joint == drawn.driver)
    guided = [each for each in drawn.bodies if each.limits and each.parent == drawn.frame]
    if crank.parent != drawn.frame or drawn.slide is None:
        raise PinpressError(f"{press.name} has no crank on the frame, or no slide: give a crank-slide or what opposed() makes of it")
    slide, shaft, shared = drawn.body(drawn.slide), crank.place.translation, [each.link for each in guided]
    ends = [(k.name, link, k.point) for k in drawn.pins for link in (k.link1, k.link2) if link in shared]
    ends += [(each.joint, each.parent, each.place.translation) for each in drawn.bodies if each.parent in shared]
    along = slide.place.rotation @ slide.axis
    to_slide = next((point - shaft for _, link, point in ends if link == slide.link), along)
    across = np.cross(drawn.normal, along) * (1.0 if to_slide @ along > 0 else -1.0)
    for each in guided:
        if abs(each.place.rotation @ each.axis @ across) > CENTRED:
            raise PinpressError(
                f"{press.name}: joint {each.joint!r} guides in another direction than the slide's; only one can be mirrored"
            )
    for name, _, point in ends:
        if abs((point - shaft) @ across) > CENTRED * press.size:
            raise PinpressError(
                f"{press.name}: bearing {name!r} moves {abs((point - shaft) @ across):.6g} m beside the shaft; give a centred crank-slide"
            )
    return built(
        replace(doubled(drawn, shared, shaft, across, distance), name=f"{press.name}_symmetric"),
        "Two mirrored halves on two shafts that a gear pair lets turn against each other (Zhang 2007, 3.6). SI units.",
    )


@dataclass(frozen=True)
class HarmonicChange:
    """What became of one harmonic.

    Attributes:
        quantity: "force along the slide" (vertical in an upright press), "force across the slide" (lateral) or "tilting moment".
        order: of the crank's speed; fractions too where a press repeats itself only after several turns.
        before, after: amplitudes [N, or N m].
        change: "cancelled" (it is rounding), "reduced", "unchanged", "raised", or "none" where there was and is nothing but rounding.
    """

    quantity: str
    order: float
    before: float
    after: float
    change: str


@typed
def cancelled(before: Reactions, after: Reactions, orders: int = 6) -> tuple[HarmonicChange, ...]:
    """What an arrangement does to the harmonics of the shaking force and of the tilting moment, orders 1 to ``orders``.

    The moment is about the shaft of the press before. What is below 1e-12 of the largest bearing force, or of its moment at an arm of the
    linkage's size, is rounding.

    Args:
        before, after: reactions of two planar presses over a period or more.

    Raises:
        PinpressError: a press without a slide or not planar, motions at different speeds, without a full period or with too few states for
            the orders.
    """
    for reactions in (before, after):
        expect("reactions", reactions, Reactions, "inverse_dynamics")
    press, (speed, other) = before._press, (np.abs(reactions.motion.crank_speed).max() for reactions in (before, after))
    if press.plane is None:
        raise PinpressError(f"{press.name} is not planar: look at the harmonics of its shaking force one axis at a time")
    if not abs(other - speed) <= SAME_SPEED * speed:
        raise PinpressError("before and after are at different speeds, with whose squares forces grow: make both motions with one speed")
    guide, _ = press.slide_guide
    at = poses(press, press.closed[None])
    along = at.rotation[guide + 1, 0] @ press.axes[guide].direction
    axes = np.array([along, np.cross(press.plane.normal, along)])
    shaft = at.position[press.driver_indices[0] + 1, 0]
    (first, least1), (second, least2) = (_amplitudes(each, axes, press.plane.normal, shaft, orders) for each in (before, after))
    none = np.zeros(3)
    return tuple(
        HarmonicChange(quantity, order, was, now, _change(was, now, max(least1[k], least2[k])))
        for k, quantity in enumerate(("force along the slide", "force across the slide", "tilting moment"))
        for order in sorted({*first, *second})
        for was, now in [(float(first.get(order, none)[k]), float(second.get(order, none)[k]))]
    )


def _amplitudes(
    reactions: Reactions, axes: Array, normal: Array, shaft: Array, orders: int
) -> tuple[dict[float, Array], tuple[float, float, float]]:
    """By order, amplitudes (3,) of force along and across and of moment about the shaft, and what is rounding of each."""
    force = reactions.shaking_force
    moment = (reactions.shaking_moment - np.cross(shaft, force)) @ normal
    found = harmonics(reactions.motion, np.column_stack([force @ axes.T, moment]), orders)
    turns = reactions.motion.period_turns or 1
    if found is None or len(found.orders) <= orders * turns:
        raise PinpressError(
            f"the motion of {reactions.motion.linkage} has no full period of {2 * orders * turns + 1} states: use cycle(..., points=...)"
        )
    least = ROUNDING * max(float(np.abs(each).max()) for each in (force, *reactions.bearing_force.values()))
    by_order = {int(o) if o.is_integer() else float(o): at for o, at in zip(found.orders[1:], found.amplitude[1:], strict=True)}
    return by_order, (least, least, least * reactions._press.size)


def _change(before: float, after: float, least: float) -> str:
    if after <= least:
        return "none" if before <= least else "cancelled"
    if abs(after - before) <= max(least, UNCHANGED * before):
        return "unchanged"
    return "reduced" if after < before else "raised"


def _auxiliary(
    main: CrankSlide, crank_radius: float, rod_length: float | None, rod_mass: float | None, rod_inertia: float | None
) -> CrankSlide:
    """The auxiliary crank-slide of `opposed`."""
    radius = positive("crank_radius", crank_radius, "m")
    scale = radius / main.crank_radius
    length = main.rod_length * scale if rod_length is None else positive("rod_length", rod_length, "m")
    if not length > radius:
        raise PinpressError(f"rod_length is {length:g} m, crank_radius {radius:g} m: for a full turn the rod must be longer")
    mass = main.rod_mass / scale if rod_mass is None else positive("rod_mass", rod_mass, "kg")
    similar = main.rod_inertia * mass / main.rod_mass * (length / main.rod_length) ** 2
    # A centre beside the line gives a mass moment, which must be the same times the crank radius.
    share = complex(main.rod_share.real, main.rod_share.imag * main.rod_mass / (scale * mass))
    counterweight = (main.reciprocating_mass / scale - mass * share).real
    if not counterweight > 0:
        raise PinpressError(
            f"rod_mass is {mass:g} kg: at its far end there is more than the {main.reciprocating_mass.real / scale:g} kg that balance the"
            " slide; take a lighter rod or a smaller crank_radius"
        )
    crank_mass = main.crank_mass / scale
    return replace(
        main,
        rod="auxiliary_rod",
        slide="counterweight",
        crank_radius=radius,
        rod_length=length,
        crank_mass=crank_mass,
        rod_mass=mass,
        slide_mass=counterweight,
        crank_centre=(main.rotating_product - radius * mass * (1 - share)) / crank_mass,
        rod_centre=share * length,
        crank_inertia=main.crank_inertia * scale,
        rod_inertia=similar if rod_inertia is None else positive("rod_inertia", rod_inertia, "kg m2"),
        direction=-main.direction,
        across=-main.across,
    )
