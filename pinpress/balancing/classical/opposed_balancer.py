"""The opposed arrangement: an auxiliary crank-slider moves a counterweight against the slide. Zhang 2007, 3.5."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...common.arguments import typed
from ...common.checks import positive
from ...common.errors import PinpressError
from ...linkage.linkage import Linkage
from ..counterweights import combined, rigid_body
from .crank_slider import CrankSlider, as_crank_slider
from .press_plan import PlanBody, PlanPin, PressPlan, plan_of, press_of

SPARE = 0.1  # of the auxiliary crank radius: how far the counterweight's limits are beyond its travel


@typed
def with_opposed_balancer(
    press: Linkage,
    crank_radius: float,
    *,
    rod_length: float | None = None,
    rod_mass: float | None = None,
    rod_inertia: float | None = None,
) -> Linkage:
    """Add an auxiliary crank-slider, turned by 180 degrees about the shaft, which moves a counterweight against the slide.

    Zhang 2007, 3.5. The auxiliary crank is part of the crank, opposite to the crank pin; new are the links "auxiliary_rod" and
    "counterweight", the joints "auxiliary_pin" and "counterweight_guide" and the loop "counterweight_pin". They are sized (index 1 the main
    crank-slider, 2 the auxiliary one; centres of mass as vectors along the links) by

        m_crank2 e2 + m_rod2 r2 (1 - a2 / l2) = m_crank1 e1 + m_rod1 r1 (1 - a1 / l1)    what turns
        (m_counterweight + m_rod2 a2 / l2) r2 = (m_slide + m_rod1 a1 / l1) r1            what reciprocates

    where the auxiliary rod has its centre of mass at the same part of its length, the auxiliary crank has the mass m_crank1 r1 / r2, its
    centre where the first equation puts it (beyond the shaft for a heavy rod), and the moment of inertia of a crank of the same shape.
    By default the auxiliary crank-slider is the main one with lengths times r2 / r1 and masses times r1 / r2.

    They lie in the plane of the crank pin, and the counterweight's centre of mass is at its pin.

    What is left: with the same lambda no force but the weight, in any order, along the slide's line or across it, however the crank turns.
    With another rod length, at constant speed w, the even orders k from 2 along the line are left,
    m_C r1 w^2 |A_k(lambda1) - A_k(lambda2)| (`harmonic_coefficients`), m_C being the main reciprocating mass. The moment with which the
    guides' forces tilt the frame is left, and by default grows: - (J1 + J2) times the angular acceleration of the rods, in the odd orders,
    J being `CrankSlider.residual_inertia` (from eq. 3.5.20 on the thesis takes that acceleration for zero). It vanishes too with
    rod_inertia = m_rod2 a2 (l2 - a2) - J1, where lambda is the same and the rods' centres are on their lines; such a rod has mass beyond
    its pins.

    Args:
        press: A centred crank-slider.
        crank_radius: Radius r2 of the auxiliary crank [m].
        rod_length: Length l2 of the auxiliary rod [m]; by default l1 r2 / r1, the same lambda.
        rod_mass: Mass of the auxiliary rod [kg]; by default m_rod1 r1 / r2.
        rod_inertia: Moment of inertia of the auxiliary rod about its centre of mass [kg m2]; by default of a rod of the same shape,
            J_rod1 m_rod2 / m_rod1 (l2 / l1)^2.

    Returns:
        A press that is in memory alone; `write_urdf` writes it. It is drawn as ``press`` is, with the same crank angle, gravity, names and
        inertias, but without visuals.

    Raises:
        PinpressError: The press is no centred crank-slider (see `as_crank_slider`), a size is not positive, the rod is no longer than its
            crank, or so heavy that no mass is left for the counterweight.
    """
    main = as_crank_slider(press)
    auxiliary = _auxiliary(main, crank_radius, rod_length, rod_mass, rod_inertia)
    return press_of(
        replace(_with_auxiliary(plan_of(press), main, auxiliary), name=f"{press.name}_opposed"),
        "A crank-slider and, turned by 180 degrees about its shaft, an auxiliary one with a counterweight (Zhang 2007, 3.5). SI units.",
    )


def _auxiliary(
    main: CrankSlider, crank_radius: float, rod_length: float | None, rod_mass: float | None, rod_inertia: float | None
) -> CrankSlider:
    """The auxiliary crank-slider."""
    radius, length, mass = _auxiliary_sizes(main, crank_radius, rod_length, rod_mass)
    scale = radius / main.crank_radius
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


def _auxiliary_sizes(
    main: CrankSlider, crank_radius: float, rod_length: float | None, rod_mass: float | None
) -> tuple[float, float, float]:
    """Crank radius [m], rod length [m] and rod mass [kg] of the auxiliary crank-slider."""
    radius = positive("crank_radius", crank_radius, "m")
    scale = radius / main.crank_radius
    length = main.rod_length * scale if rod_length is None else positive("rod_length", rod_length, "m")
    if not length > radius:
        raise PinpressError(f"rod_length is {length:g} m, crank_radius {radius:g} m: for a full turn the rod must be longer")
    return radius, length, main.rod_mass / scale if rod_mass is None else positive("rod_mass", rod_mass, "kg")


def _with_auxiliary(drawn: PressPlan, main: CrankSlider, auxiliary: CrankSlider) -> PressPlan:
    """The plan of a crank-slider with an auxiliary one on its crank, whose slide is the counterweight. Both have the same drawn angle and
    opposite directions."""
    crank, slide, normal = drawn.body(main.crank), drawn.body(main.slide), np.cross(main.direction, main.across)
    flat = 0.5 * (np.eye(3) + np.outer(normal, normal))  # tensor of a lamina in the plane, of unit inertia
    into = crank.place.rotation.T
    centre = crank.place.actInv(auxiliary.point(auxiliary.crank_centre * auxiliary.drawn_crank))
    added = rigid_body(auxiliary.crank_mass, centre, auxiliary.crank_inertia * (into @ flat @ into.T))

    along = auxiliary.point(auxiliary.drawn_rod) - auxiliary.shaft
    axes = np.stack([along, -normal, np.cross(normal, along)], axis=1)  # x along the rod, which turns about -y
    rod_place = pin.SE3(axes, auxiliary.point(auxiliary.crank_radius * auxiliary.drawn_crank))
    rod_centre = np.array([auxiliary.rod_centre.real, 0.0, auxiliary.rod_centre.imag])
    rod = rigid_body(auxiliary.rod_mass, rod_centre, auxiliary.rod_inertia * np.diag([0.5, 1.0, 0.5]))

    distance = auxiliary.drawn_reach
    end, up = auxiliary.point(complex(distance)), float(np.sign(auxiliary.direction @ slide.place.rotation @ slide.axis))
    spare = (1 + SPARE) * auxiliary.crank_radius
    low, high = sorted(up * (auxiliary.rod_length + sign * spare - distance) for sign in (-1, 1))
    limits = (low, high, *slide.limits[2:])
    weight = rigid_body(auxiliary.slide_mass, np.zeros(3), slide.inertia.inertia * (auxiliary.slide_mass / slide.inertia.mass))
    return replace(
        drawn,
        bodies=(
            *(replace(each, inertia=combined(each.inertia, added)) if each is crank else each for each in drawn.bodies),
            PlanBody(auxiliary.rod, rod_place, rod, "auxiliary_pin", main.crank, np.array([0.0, -1.0, 0.0])),
            PlanBody(auxiliary.slide, pin.SE3(slide.place.rotation, end), weight, "counterweight_guide", drawn.frame, slide.axis, limits),
        ),
        pins=(*drawn.pins, PlanPin("counterweight_pin", "spherical", auxiliary.rod, auxiliary.slide, end)),
    )
