"""Arrangements that balance a whole press, added to a press.

- `with_opposed_balancer` (Zhang 2007, 3.5): an auxiliary crank-slider moves a counterweight against the slide.
- `with_balance_shafts` (Lanchester): geared pairs of shafts with eccentric blocks turn against each other.
- `mirrored` (Zhang 2007, 3.6): two halves of the press have two shafts that turn against each other.

All three work on the plan of a planar press (`PressPlan`). In a plan every part has its place in the world, in the closed drawn pose. So
parts can be added, shifted and mirrored independently of the joint tree. The new press is written as a URDF and loaded from it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from ...common import plausibility
from ...common.arguments import positive, suitable_numbers, typed, whole_number
from ...common.errors import PinpressError, shown
from ...common.quantities import Array
from ...kinematics.poses import poses
from ...linkage import loading
from ...linkage.checks import assembly as assembly_checks
from ...linkage.checks import elements as element_checks
from ...linkage.document import Document, check_command, refuse_errors
from ...linkage.linkage import Linkage
from ...linkage.text import MOMENTS, tag
from ..counterweights import combine_inertias, rigid_body, with_counterweights, with_die
from .crank_slider import CENTRED, CrankSlider, approximate_balance, as_crank_slider, harmonic_coefficients

SIDES = ("left", "right")


@typed
def with_opposed_balancer(
    press: Linkage,
    crank_radius: float,
    *,
    rod_length: float | None = None,
    rod_mass: float | None = None,
    rod_inertia: float | None = None,
    die_mass: float = 0.0,
) -> Linkage:
    """Add an auxiliary crank-slider, turned by 180 degrees about the shaft, which moves a counterweight against the slide.

    Zhang 2007, 3.5. The auxiliary crank is part of the crank, opposite to the crank pin. The links "auxiliary_rod" and "counterweight", the
    joints "auxiliary_pin" and "counterweight_guide" and the loop "counterweight_pin" are new. They lie in the plane of the crank pin, and
    the counterweight's centre of mass is at its pin. Their masses obey (index 1 for the main crank-slider, 2 for the auxiliary one; centres
    of mass as vectors along the links)

        m_crank2 e2 + m_rod2 r2 (1 - a2 / l2) = m_crank1 e1 + m_rod1 r1 (1 - a1 / l1)    rotating masses
        (m_counterweight + m_rod2 a2 / l2) r2 = (m_slide + m_die + m_rod1 a1 / l1) r1    reciprocating masses

    The centre of mass of the auxiliary rod divides its length as that of the main rod does. The auxiliary crank has the mass
    m_crank1 r1 / r2. Its centre follows from the first equation (beyond the shaft for a heavy rod), and its moment of inertia is that of a
    crank of this mass with the main crank's shape. By default the auxiliary crank-slider has the main lengths times r2 / r1 and the main
    masses times r1 / r2.

    With equal lambda the shaking force is only the weight, in all orders and directions and for any motion of the crank. With another rod
    length, at constant speed w, the even orders k from 2 along the slide's line remain: m_C r1 w^2 |A_k(lambda1) - A_k(lambda2)|, with the
    main reciprocating mass m_C (`harmonic_coefficients`).

    The moment of the guides' forces on the frame remains, and by default grows. It is - (J1 + J2) times the angular acceleration of the
    rods, in the odd orders, with J of `CrankSlider.residual_inertia` (the thesis neglects this acceleration from eq. 3.5.20 on). With equal
    lambdas and rods whose centres are on their lines, it vanishes for rod_inertia = m_rod2 a2 (l2 - a2) - J1. Such a rod has mass beyond
    its pins.

    Args:
        press: a centred crank-slider.
        crank_radius: radius r2 of the auxiliary crank [m].
        rod_length: length l2 of the auxiliary rod [m]; by default l1 r2 / r1, for equal lambda.
        rod_mass: mass of the auxiliary rod [kg]; by default m_rod1 r1 / r2.
        rod_inertia: moment of inertia of the auxiliary rod about its centre of mass [kg m2]; by default that of a rod with the main rod's
            shape, J_rod1 m_rod2 / m_rod1 (l2 / l1)^2.
        die_mass: mass of an upper die (m7 of the thesis) in the slide's centre of mass, which is balanced too [kg].

    Returns:
        The new press, only in memory (`write_urdf` writes it). It keeps the drawn pose, crank angle, gravity, names and inertias of
        ``press``, but has no visuals.

    Raises:
        PinpressError: the press is not a centred crank-slider (see `as_crank_slider`), a size is not positive, the rod is not longer than
            its crank, or the rod is so heavy that the counterweight would have no mass.
    """
    main = as_crank_slider(press)
    die = float(suitable_numbers("die_mass", die_mass, "a mass that is not negative [kg]", suits=lambda mass: mass >= 0))
    if die:
        press = with_die(press, die, main.slide)
        main = as_crank_slider(press)
    auxiliary = _auxiliary(main, crank_radius, rod_length, rod_mass, rod_inertia)
    return press_of(
        replace(_with_auxiliary(plan_of(press), main, auxiliary), name=f"{press.name}_opposed"),
        "A crank-slider and, turned by 180 degrees about its shaft, an auxiliary one with a counterweight (Zhang 2007, 3.5). SI units.",
    )


@typed
def with_balance_shafts(
    press: Linkage, *, radius: float, shaft_distance: float, orders: Sequence[int] = (1, 2), crank_radius: float | None = None
) -> Linkage:
    """Add pairs of shafts with eccentric blocks, which gears turn against each other at the crank's speed or a multiple of it.

    A counterweight on the crank balances the rotating masses (`approximate_balance` with the share 0). The forces of a pair for the order k
    add along the slide's line and cancel across it. The blocks turn at k times the speed of the crank. At bottom dead centre they point
    away from the slide (towards it for negative A_k). Each block has the product of mass and radius

    m_block radius = m_C r |A_k| / (2 k^2)

    with the reciprocating mass m_C, the crank radius r and A_k of `harmonic_coefficients`. At any constant speed the shaking force has no
    component across the slide's line and none of the pairs' orders; the other even orders along the line remain. The pairs have no moment
    about the crankshaft. F. W. Lanchester's balancer is the pair for the second order. (Fig. 1-2 of Zhang 2007 has blocks of the first
    order on the cranks of two halves instead: `mirrored` of a press with `approximate_balance`, share 1.)

    Args:
        press: a centred crank-slider.
        radius: distance from the shafts to the blocks' centres of mass [m]. The blocks are discs of half this radius.
        shaft_distance: distance of the first pair's shafts, with the crankshaft in the middle; the shafts of the n-th pair are n times as
            far apart [m]. Collisions are not checked.
        orders: orders to cancel, with a pair for each: 1 and even numbers.
        crank_radius: distance from the crankshaft to the counterweight of the rotating masses [m]; None: ``radius``.

    Returns:
        The new press, only in memory, with the drawn pose, crank angle, gravity and names of ``press``, but without visuals. The shafts
        are the links "balance_shaft_1_left" and so on, by order and side.

    Raises:
        PinpressError: the press is not a centred crank-slider (see `as_crank_slider`), a length is not positive, or an order is neither 1
            nor an even number, or is given twice.
    """
    main = as_crank_slider(press)
    arm, distance = positive("radius", radius, "m"), positive("shaft_distance", shaft_distance, "m")
    for name, value in (("radius", arm), ("shaft_distance", distance)):
        plausibility.length(f"with_balance_shafts: {name}", value, press.size)
    checked_orders = [whole_number("orders", order, 1, 100) for order in orders]
    if not checked_orders or len(set(checked_orders)) < len(checked_orders) or any(order % 2 and order > 1 for order in checked_orders):
        raise PinpressError(f"orders is {shown(orders)}: give orders of a crank-slider (1, 2, 4, 6 and so on), each once")
    rotating = approximate_balance(press, arm if crank_radius is None else crank_radius, share=0.0)
    drawn = plan_of(with_counterweights(press, [rotating]))
    shafts = [
        _balance_shaft(drawn, main, order, side, arm, 0.5 * place * distance)
        for place, order in enumerate(checked_orders, 1)
        for side in SIDES
    ]
    return press_of(
        replace(drawn, name=f"{press.name}_balance_shafts", bodies=(*drawn.bodies, *shafts)),
        "A crank-slider with geared shafts that turn against each other and carry eccentric blocks. SI units.",
    )


@typed
def mirrored(press: Linkage, shaft_distance: float) -> Linkage:
    """Make a press of two mirrored halves, on two shafts that a gear pair turns against each other.

    Zhang 2007, 3.6. The left half is the press, shifted by half the distance of the shafts against the direction in which the crank leaves
    bottom dead centre. The right half is the mirror image about the original line of the shaft. Both halves share the slide (and the
    counterweight). All other links and joints exist twice, with half of their mass and with "_left" and "_right" after their names. The
    left shaft is driven. The right shaft mimics it by -1.

    Forces across the slide's line and moments about the middle vanish at any speed, also under a central load on the slide. Forces along
    the line do not change. A slide whose centre of mass is off the line of its pin keeps the moment of this offset.

    Args:
        press: a centred crank-slider, or a press made from one by `with_opposed_balancer`.
        shaft_distance: distance of the shafts [m]. Collisions of the halves are not checked.

    Returns:
        The new press, only in memory, with the crank angle, gravity, names, masses and stroke of ``press``, but without visuals.

    Raises:
        PinpressError: the press is not planar with one driver on the frame; it has gear pairs, no slide, or guides in several directions;
            the slide's pin does not move on a line through the shaft; or the distance is not positive.
    """
    distance, drawn = positive("shaft_distance", shaft_distance, "m"), plan_of(press)
    plausibility.length("mirrored: shaft_distance", distance, press.size)
    guided = [body.link for body in drawn.bodies if body.limits and body.parent == drawn.frame]
    crank = next(body for body in drawn.bodies if body.joint == drawn.driver)
    if crank.parent != drawn.frame or drawn.slide is None:
        raise PinpressError(
            f"{press.name} has no crank on the frame, or no slide: give a crank-slider, or the result of with_opposed_balancer()"
        )
    shaft = np.asarray(crank.place.translation)
    across = _across(press, drawn, guided, shaft)
    return press_of(
        replace(_double_plan(drawn, guided, shaft, across, distance), name=f"{press.name}_symmetric"),
        "Two mirrored halves on two shafts that a gear pair lets turn against each other (Zhang 2007, 3.6). SI units.",
    )


@dataclass(frozen=True, eq=False, repr=False)
class PlanBody:
    """A link and the joint that carries it, both with the same frame.

    Attributes:
        link: name of the link.
        place: place of the frame in the world.
        inertia: inertia of the link in the frame.
        joint: name of the joint.
        parent: name of the link that the joint is fixed to.
        axis: (3,) axis of the joint in the frame.
        limits: lower and upper limit [m], effort [N] and velocity [m/s] of a joint that slides; empty for a joint that turns.
        leader: name of the joint that this joint mimics; None if it does not mimic a joint.
        ratio: turns of this joint for one of the leader.
    """

    link: str
    place: pin.SE3
    inertia: pin.Inertia
    joint: str
    parent: str
    axis: Array
    limits: tuple[float, ...] = ()
    leader: str | None = None
    ratio: float = -1.0


@dataclass(frozen=True, eq=False, repr=False)
class PlanPin:
    """A pin that closes a loop.

    Attributes:
        name: name of the ``<loop_joint>``.
        type: type of the ``<loop_joint>``.
        link1: name of its first link.
        link2: name of its second link.
        point: (3,) place in the world [m].
    """

    name: str
    type: str
    link1: str
    link2: str
    point: Array


@dataclass(frozen=True, eq=False, repr=False)
class PressPlan:
    """A planar press, with every part at its place in the world in the closed drawn pose.

    Attributes:
        name: name of the press.
        frame: name of the root link.
        frame_inertia: inertia of the root link.
        bodies: bodies, parents before their children.
        pins: pins that close the loops.
        driver: name of the driver joint.
        slide: name of the slide's link.
        normal: (3,) normal of the plane in world axes.
        gravity: (3,) [m/s2].
        size: length of the linkage, to which rounding is relative [m].
    """

    name: str
    frame: str
    frame_inertia: pin.Inertia
    bodies: tuple[PlanBody, ...]
    pins: tuple[PlanPin, ...]
    driver: str
    slide: str | None
    normal: Array
    gravity: tuple[float, ...]
    size: float

    def body(self, link: str) -> PlanBody:
        """The body of this name."""
        return next(body for body in self.bodies if body.link == link)


def plan_of(press: Linkage) -> PressPlan:
    """The plan of a planar press without gear pairs.

    Welded links are one body, with the name of the slide, or of the first link if the slide is not one of them.

    Raises:
        PinpressError: the press is not planar, or has gear pairs or several drivers.
    """
    refusal = f"{press.name} is not planar with one driver, or has gear pairs: give a planar press of pins and guides"
    plane = press.plane_or_refuse(refusal)
    if press.relations:
        raise PinpressError(refusal)
    model, drawn_poses = press.model, poses(press, press.closed[None])
    links = {joint: press.link_of(joint) for joint in range(model.njoints)}
    if press.slide is not None:
        links[press.slide_guide.joint + 1] = press.slide  # not the name of a welded link: positions refer to the slide
    bodies = []
    for j, (name, axis, start) in enumerate(zip(press.joints, press.axes, press.closed, strict=True), 1):
        at_q, at_v = model.idx_qs[j], model.idx_vs[j]
        travel = float(model.lowerPositionLimit[at_q]) - start, float(model.upperPositionLimit[at_q]) - start
        limits = (*travel, float(model.upperEffortLimit[at_v]), float(model.velocityLimit[at_v]))
        placement = press.frame_of(links[j]).placement
        bodies.append(
            PlanBody(
                links[j],
                pin.SE3(drawn_poses.rotation[j, 0], drawn_poses.position[j, 0]) * placement,
                placement.actInv(model.inertias[j]),
                name,
                links[int(model.parents[j])],
                placement.rotation.T @ axis.direction,
                () if axis.turns else limits,
            )
        )
    return PressPlan(
        press.name,
        links[0],
        model.inertias[0],
        tuple(bodies),
        tuple(PlanPin(k.name, k.type, links[k.joint1], links[k.joint2], drawn_poses.points(k.joint1, k.point1)[0]) for k in press.loops),
        press.driver,
        press.slide,
        plane.normal,
        tuple(model.gravity.linear.tolist()),
        press.size,
    )


def press_of(plan: PressPlan, comment: str) -> Linkage:
    """Write the press of a plan as a URDF in memory, with a comment, and load it. Raises as `load`."""
    places = {plan.frame: pin.SE3.Identity()} | {body.link: body.place for body in plan.bodies}
    content = [_link(plan.frame, plan.frame_inertia, plan.size)]
    content += [_link(body.link, body.inertia, plan.size) for body in plan.bodies]
    content += [_joint(body, places[body.parent].actInv(body.place), plan.size) for body in plan.bodies]
    content += [_loop(closing_pin, places, plan.normal, plan.size) for closing_pin in plan.pins]
    content.append(tag("transmission", {"name": "crank_drive"}, tag("joint", {"name": plan.driver})))
    robot = tag("robot", {"name": plan.name}, "".join(f"\n  {element}" for element in content) + "\n")
    text = f'<?xml version="1.0"?>\n<!--\n  {comment}\n-->\n{robot}\n'.encode()
    file = f"{plan.name}.urdf (not written)"  # the file's name in errors
    document = Document(file, text)
    refuse_errors(element_checks.errors(document), check_command(file))
    press = loading.build(document, None, plan.slide, plan.gravity)
    refuse_errors(assembly_checks.errors(press), check_command(file))
    return press


def _balance_shaft(drawn: PressPlan, main: CrankSlider, order: int, side: str, radius: float, beside: float) -> PlanBody:
    """A shaft with a block for an order, at the distance ``beside`` from the crankshaft [m]; see `with_balance_shafts`."""
    crank, coefficient = drawn.body(main.crank), float(harmonic_coefficients(main.ratio, order)[order])
    mass = abs(main.reciprocating_mass) * main.crank_radius * abs(coefficient) / (2 * order**2 * radius)
    # Where the rod's centre is off its line, the force of the reciprocating mass is turned by the angle of that complex mass.
    towards = main.reciprocating_mass / abs(main.reciprocating_mass)
    sense = -1 if side == "left" else 1  # the right one turns with the crank
    block = -np.sign(coefficient) * towards * main.drawn_crank ** (sense * order)
    centre = main.point(sense * 1j * towards * beside)
    flat = 0.5 * (np.eye(3) + np.outer(crank.axis, crank.axis))  # tensor of a lamina in the plane, of unit inertia
    lever = crank.place.rotation.T @ (main.point(radius * block) - main.shaft)
    inertia = rigid_body(mass, lever, 0.5 * mass * (0.5 * radius) ** 2 * flat)
    name = f"balance_shaft_{order}_{side}"
    place = pin.SE3(crank.place.rotation, centre)
    return PlanBody(name, place, inertia, f"{name}_bearing", drawn.frame, crank.axis, (), drawn.driver, float(sense * order))


def _auxiliary(
    main: CrankSlider, crank_radius: float, rod_length: float | None, rod_mass: float | None, rod_inertia: float | None
) -> CrankSlider:
    """The auxiliary crank-slider; arguments as in `with_opposed_balancer`."""
    radius = positive("crank_radius", crank_radius, "m")
    plausibility.length("with_opposed_balancer: crank_radius", radius, main.crank_radius + main.rod_length)
    scale = radius / main.crank_radius
    length = main.rod_length * scale if rod_length is None else positive("rod_length", rod_length, "m")
    if not length > radius:
        raise PinpressError(
            f"rod_length is {length:g} m, but crank_radius is {radius:g} m: give a longer rod, for a full turn of the crank"
        )
    mass = main.rod_mass / scale if rod_mass is None else positive("rod_mass", rod_mass, "kg")
    similar = main.rod_inertia * mass / main.rod_mass * (length / main.rod_length) ** 2
    # A centre off the line gives a mass moment, which times the crank radius must equal that of the main rod.
    share = complex(main.rod_share.real, main.rod_share.imag * main.rod_mass / (scale * mass))
    counterweight = (main.reciprocating_mass / scale - mass * share).real
    if not counterweight > 0:
        raise PinpressError(
            f"rod_mass is {mass:g} kg, too much: its share at the far pin exceeds the {main.reciprocating_mass.real / scale:g} kg that"
            " balance the slide; give a lighter rod or a smaller crank_radius"
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


def _with_auxiliary(drawn: PressPlan, main: CrankSlider, auxiliary: CrankSlider) -> PressPlan:
    """The plan of a crank-slider with an auxiliary crank-slider on its crank, whose slide is the counterweight.

    Both crank-sliders have the same drawn angle and opposite directions.
    """
    crank, slide = drawn.body(main.crank), drawn.body(main.slide)
    normal, into = np.cross(auxiliary.direction, auxiliary.across), crank.place.rotation.T
    flat = 0.5 * (np.eye(3) + np.outer(normal, normal))  # tensor of a lamina in the plane, of unit inertia
    centre = crank.place.actInv(auxiliary.point(auxiliary.crank_centre * auxiliary.drawn_crank))
    added = rigid_body(auxiliary.crank_mass, centre, auxiliary.crank_inertia * (into @ flat @ into.T))
    end = auxiliary.point(complex(auxiliary.drawn_reach))
    return replace(
        drawn,
        bodies=(
            *(replace(body, inertia=combine_inertias(body.inertia, added)) if body is crank else body for body in drawn.bodies),
            _auxiliary_rod(auxiliary),
            _counterweight(drawn.frame, slide, auxiliary, end),
        ),
        pins=(*drawn.pins, PlanPin("counterweight_pin", "spherical", auxiliary.rod, auxiliary.slide, end)),
    )


def _auxiliary_rod(auxiliary: CrankSlider) -> PlanBody:
    normal, along = np.cross(auxiliary.direction, auxiliary.across), auxiliary.point(auxiliary.drawn_rod) - auxiliary.shaft
    axes = np.stack([along, -normal, np.cross(normal, along)], axis=1)  # x along the rod, which turns about -y
    place = pin.SE3(axes, auxiliary.point(auxiliary.crank_radius * auxiliary.drawn_crank))
    centre = np.array([auxiliary.rod_centre.real, 0.0, auxiliary.rod_centre.imag])
    inertia = rigid_body(auxiliary.rod_mass, centre, auxiliary.rod_inertia * np.diag([0.5, 1.0, 0.5]))
    return PlanBody(auxiliary.rod, place, inertia, "auxiliary_pin", auxiliary.crank, np.array([0.0, -1.0, 0.0]))


def _counterweight(frame: str, slide: PlanBody, auxiliary: CrankSlider, end: Array) -> PlanBody:
    """The counterweight, guided parallel to the slide, with its centre of mass at its pin, whose place is ``end`` (3,) [m]."""
    up = float(np.sign(auxiliary.direction @ slide.place.rotation @ slide.axis))
    reach = 1.1 * auxiliary.crank_radius  # its limits are a little beyond its travel
    low, high = sorted(up * (auxiliary.rod_length + sign * reach - auxiliary.drawn_reach) for sign in (-1, 1))
    weight = rigid_body(auxiliary.slide_mass, np.zeros(3), slide.inertia.inertia * (auxiliary.slide_mass / slide.inertia.mass))
    place = pin.SE3(slide.place.rotation, end)
    return PlanBody(auxiliary.slide, place, weight, "counterweight_guide", frame, slide.axis, (low, high, *slide.limits[2:]))


def _across(press: Linkage, drawn: PressPlan, guided: Sequence[str], shaft: Array) -> Array:
    """The unit vector (3,) across the slide's line, in the direction in which the crank leaves bottom dead centre.

    Raises:
        PinpressError: a link that is guided on the frame does not move on the slide's line through the shaft.
    """
    assert drawn.slide is not None
    slide = drawn.body(drawn.slide)
    ends = [(k.name, link, k.point) for k in drawn.pins for link in (k.link1, k.link2) if link in guided]
    ends += [(body.joint, body.parent, body.place.translation) for body in drawn.bodies if body.parent in guided]
    along = slide.place.rotation @ slide.axis
    to_slide = next((point - shaft for _, link, point in ends if link == slide.link), along)
    across = np.cross(drawn.normal, along) * (1.0 if to_slide @ along > 0 else -1.0)
    for body in map(drawn.body, guided):
        if abs(body.place.rotation @ body.axis @ across) > CENTRED:
            raise PinpressError(
                f"{press.name}: joint {body.joint!r} does not guide in the direction of the slide: give a press with one direction of"
                " guides"
            )
    for name, _, point in ends:
        if abs((point - shaft) @ across) > CENTRED * press.size:
            raise PinpressError(
                f"{press.name}: the line of bearing {name!r} passes the shaft at {abs((point - shaft) @ across):.6g} m; give a centred"
                " crank-slider"
            )
    return np.asarray(across)


def _double_plan(drawn: PressPlan, shared: Sequence[str], shaft: Array, across: Array, distance: float) -> PressPlan:
    """The plan of both halves; see `mirrored`.

    Args:
        drawn: the plan of the press.
        shared: names of the links that both halves share.
        shaft: (3,) point on the shaft, through which the mirror plane passes [m].
        across: (3,) unit normal of the mirror plane; the left half is shifted against it.
        distance: distance of the shafts [m].
    """
    shift = -0.5 * distance * across

    def named(name: str, side: str) -> str:
        return name if name in (drawn.frame, *shared) else f"{name}_{side}"

    def moved(point: Array, side: str) -> Array:
        point = point + shift
        return point if side == "left" else point - 2 * ((point - shaft) @ across) * across

    def half(body: PlanBody, side: str) -> PlanBody:
        # The frame of a mirrored link keeps its axes, so that points and axes in it are mirrored.
        to = body.place.rotation.T @ across
        mirror = np.eye(3) if side == "left" else np.eye(3) - 2 * np.outer(to, to)
        whole = body.inertia
        return PlanBody(
            named(body.link, side),
            pin.SE3(body.place.rotation, moved(body.place.translation, side)),
            rigid_body(0.5 * whole.mass, mirror @ whole.lever, 0.5 * mirror @ whole.inertia @ mirror),
            f"{body.joint}_{side}",
            named(body.parent, side),
            mirror @ body.axis,
            body.limits,
            f"{drawn.driver}_left" if body.joint == drawn.driver and side == "right" else None,
        )

    kept = [body for body in drawn.bodies if body.link in shared]
    halves = [half(body, side) for side in SIDES for body in drawn.bodies if body.link not in shared]
    return replace(
        drawn,
        bodies=(*halves, *kept),
        pins=tuple(
            PlanPin(f"{k.name}_{side}", k.type, named(k.link1, side), named(k.link2, side), moved(k.point, side))
            for side in SIDES
            for k in drawn.pins
        ),
        driver=f"{drawn.driver}_left",
    )


def _link(name: str, inertia: pin.Inertia, size: float) -> str:
    if not inertia.mass:  # the frame's
        return tag("link", {"name": name})
    origin, mass = tag("origin", {"xyz": _write_numbers(inertia.lever, size)}), tag("mass", {"value": _write_numbers([inertia.mass])})
    largest = float(np.abs(inertia.inertia).max())
    moments = tag("inertia", {name: _write_numbers([inertia.inertia[i, j]], largest) for name, i, j in MOMENTS})
    return tag("link", {"name": name}, tag("inertial", {}, origin + mass + moments))


def _joint(body: PlanBody, place: pin.SE3, size: float) -> str:
    ends = tag("parent", {"link": body.parent}) + tag("child", {"link": body.link})
    content = ends + tag("origin", _placement(place, size)) + tag("axis", {"xyz": _write_numbers(body.axis, 1.0)})
    if body.limits:
        names = ("lower", "upper", "effort", "velocity")
        content += tag("limit", {name: _write_numbers([value]) for name, value in zip(names, body.limits, strict=True)})
    if body.leader is not None:
        content += tag("mimic", {"joint": body.leader, "multiplier": f"{body.ratio:g}", "offset": "0"})
    return tag("joint", {"name": body.joint, "type": "prismatic" if body.limits else "continuous"}, content)


def _loop(closing: PlanPin, places: Mapping[str, pin.SE3], normal: Array, size: float) -> str:
    """A loop joint whose two ends have the world's axes in the drawn pose."""
    place = pin.SE3(np.eye(3), closing.point)
    ends = (("link1", closing.link1), ("link2", closing.link2))
    content = "".join(tag(end, {"link": link} | _placement(places[link].actInv(place), size)) for end, link in ends)
    content += tag("axis", {"xyz": _write_numbers(normal, 1.0)}) if closing.type == "revolute" else ""
    return tag("loop_joint", {"name": closing.name, "type": closing.type}, content)


def _placement(place: pin.SE3, size: float) -> dict[str, str]:
    return {"xyz": _write_numbers(place.translation, size), "rpy": _write_numbers(pin.rpy.matrixToRpy(place.rotation), 1.0)}


def _write_numbers(numbers: Array | list[float], size: float = 0.0) -> str:
    """Numbers as text; numbers below 1e-15 of a size are rounding errors of turned frames, and are written as zero."""
    return " ".join(repr(float(number) if abs(number) > 1e-15 * size else 0.0) for number in numbers)
