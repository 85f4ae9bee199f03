"""Forces that act on the links from outside, springs, dampers and process loads between them, and springs and rotors in joints."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common import plausibility
from ..common.arguments import numbers
from ..common.errors import PinpressError, caution, shown
from ..common.quantities import GRAVITY, Array
from ..engines.engine import ClosedStates, Engine
from ..engines.friction import REST
from ..engines.structure import drawn_placements, joints_between
from ..engines.wrenches import AppliedForce
from ..kinematics.motion import is_cycle
from ..kinematics.poses import body_of, point_motion, point_on_body, rotation_of
from ..kinematics.slide_path import dead_centres
from ..loads import caller_laws
from ..loads.link import LinkLoad, Load, PointForce, PointMoment, SpringDamper, TorsionSpring
from ..loads.process import ForceInterval, ProcessLoad, TimeForce, datum

ROUNDING = 1e-9  # of heights [lengths of the linkage]
PARALLEL = 1e-9  # sine of the angle between axes below which it is rounding

if TYPE_CHECKING:
    from ..kinematics.motion import Motion
    from ..linkage.linkage import Linkage

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(3)
GAUSS = (_NODES + 1) / 2, _WEIGHTS / 2  # by which the work between two states is found


def wrap_laws(loads: Sequence[Load]) -> list[Load]:
    """The loads with callers' own functions wrapped, so that their errors and numbers are checked; other loads are returned unchanged."""
    return [
        replace(load, force=caller_laws.ForceOfMotion(f"{load.label}: force", load.force, np.geterr()))
        if isinstance(load, PointForce) and callable(load.force)
        else replace(load, moment=caller_laws.ForceOfMotion(f"{load.label}: moment", load.moment, np.geterr()))
        if isinstance(load, PointMoment) and callable(load.moment)
        else load
        if isinstance(load, LinkLoad)  # looking whether something follows a protocol takes long
        else caller_laws.asked_load(load)
        for load in loads
    ]


def apply(loads: Sequence[Load], press: "Linkage", motion: "Motion", *, warned: bool = False) -> list[AppliedForce]:
    """Loads as arrays over the motion; ``warned``: the process loads were looked at before.

    A process load acts by its intervals for downward travel where the slide moves against the slide's direction, else by those for upward
    travel. Where the slide rests, its travel counts as upward, so that a load of the working stroke has ended at bottom dead centre.

    Raises:
        UnknownNameError: a load on a link that the linkage does not have.
        PinpressError: a force of the wrong shape; a value that is not finite; a spring whose ends meet; a process load on a linkage without
            a slide, without a datum, or for several scenarios; a force in time for states that have no time.
    """
    applied: list[AppliedForce] = []
    for load in loads:
        if isinstance(load, SpringDamper):
            applied += _spring_forces(load, press, motion)
        elif isinstance(load, TorsionSpring):
            turn = turn_of_spring(load, press)
            moment = -load.stiffness * (turn.angle(motion.joint_position) - load.free_angle) - load.damping * turn.angle(motion.v)
            applied += turn_forces(press, motion, turn, moment)
        elif isinstance(load, PointMoment):
            vectors = moment_vectors(load, press, load.moment(motion) if callable(load.moment) else load.moment)
            applied += _moment_forces(load, press, motion, vectors)
        elif isinstance(load, PointForce):
            # A copy, because the caller may change an array later, and results are worked out when they are needed.
            force = numbers(f"{load.label}: force", load.force(motion) if callable(load.force) else load.force, unit="N")
            applied.append(point_force(load, press, force, len(motion.crank_angle), warned=warned))
        elif isinstance(load, TimeForce):
            applied += _on_slide(load, press, _in_time(load, motion))
        elif isinstance(load, ProcessLoad) and not isinstance(load, type):
            applied += _on_slide(load, press, _in_height(load, press, motion, warned=warned))
        else:
            raise PinpressError(
                f"load {shown(load)} is no load: give a PointForce, PointMoment, SpringDamper, TorsionSpring, a load of the process"
                " or a TimeForce"
            )
    return applied


def joint_efforts(press: "Linkage", engine: Engine, states: ClosedStates) -> Array | None:
    """Efforts (nv, n) that springs and dampers in the joints supply, less those that accelerate rotors (the model's armature), along the
    joints' axes [N m, N]; None if a linkage has neither.

    A joint's bearing passes on what the links that it carries need: a rotor is between the drive and the bearing.
    """
    armature = engine.structure.model.armature  # every look at the linkage's own model compares the whole of it
    if not (press.joint_springs or armature.any()):
        return None
    efforts = -armature[:, None] * states.a
    for spring in press.joint_springs:
        joint = press.joints.index(spring.joint)
        efforts[joint] += spring.effort(states.position[joint], states.v[joint])
    return np.asarray(efforts)


def _on_slide(load: "ProcessLoad | TimeForce", press: "Linkage", along: Array) -> list[AppliedForce]:
    """A force (n,) [N] along `Linkage.slide_direction` at `Linkage.tool`, and its opposite on the frame in one line of action."""
    guide = press.slide_guide.joint
    placement = press.model.jointPlacements[guide + 1]  # in the world, as the frame carries the guide
    point, force = press.tool.in_body, along[:, None] * press.slide_direction
    # A point of the slide moves along the axis: where it was drawn is a point of the frame in its line of action.
    return [AppliedForce(guide + 1, point, force), AppliedForce(0, placement.act(point), -force)]


def force_on_slide(press: "Linkage", force: ArrayLike) -> PointForce:
    """A force along `Linkage.slide_direction`, one number or (n,) [N], on the slide alone, where process forces act."""
    x, y, z = press.tool.point.tolist()
    return PointForce(str(press.slide), np.multiply.outer(force, press.slide_direction), (x, y, z))


def _in_height(load: ProcessLoad, press: "Linkage", motion: "Motion", *, warned: bool = False) -> Array:
    """The force (n,) of a process load on the slide, along the guide's axis [N]; ``warned``: the load was looked at before."""
    name, force = caller_laws.name(load), np.zeros(len(motion.crank_angle))
    intervals = intervals_of(load)
    if not intervals:  # an idle press needs no datum
        return force
    zero = datum(caller_laws.as_given(load), press)
    height, velocity = _heights(press, motion, zero)
    # At a dead centre the speed is rounding, which must not decide on the direction of travel.
    down = velocity < -REST * press.size * np.abs(motion.crank_speed).max()
    acts = False
    for downwards, interval in intervals:
        _refuse_scenarios(name, interval)
        inside = np.flatnonzero((down == downwards) & (interval.lower < height) & (height <= interval.upper))
        acts |= len(inside) > 0
        force[inside] = _force_in(name, interval, height[inside], velocity[inside])
    if warned:
        return force
    if not acts:
        _warn_if_stepped_over(name, intervals, motion, height, velocity, press.size)
    known = not acts or load.datum is None  # else finding the stroke would take long
    warn_of_load(name, press, intervals, zero, turning_points(press) if known else (-math.inf, math.inf))
    return force


def _warn_if_stepped_over(
    name: str, intervals: Sequence[tuple[bool, ForceInterval]], motion: "Motion", height: Array, velocity: Array, size: float
) -> None:
    """Warn of a process load that acts in no state of a motion, although the slide moves through its heights between two of them."""
    way, _, before = _through_turning_points(motion, _closed(motion, height), _closed(motion, velocity))
    states = np.append(np.diff(before, prepend=-1) > 0, True)  # the others are turning points between them
    for downwards, each in intervals:
        travelled = np.abs(np.diff(way.clip(each.lower, each.upper)))
        there = states & (each.lower < way) & (way <= each.upper)  # at rest, or on the way back, without the load
        through = (travelled > ROUNDING * size) & ((way[1:] < way[:-1]) == downwards) & ~there[1:] & ~there[:-1]
        if through.any():
            highest, lowest = (way[np.flatnonzero(through)[0] + after] for after in ((0, 1) if downwards else (1, 0)))
            plausibility.stepped_over(name, (each.lower, each.upper), (float(lowest), float(highest)), len(height))
            return


def warn_of_load(
    name: str, press: "Linkage", intervals: Sequence[tuple[bool, ForceInterval]], zero: float, ends: tuple[float, float]
) -> None:
    """Warn of a process load whose heights or forces are allowed but hardly meant.

    Args:
        name: of the load.
        press: the linkage that it acts on.
        intervals: of the load, each with whether it is for downward travel.
        zero: the load's datum, a slide position [m].
        ends: slide positions at bottom and top dead centre [m]; infinite where they are not known.
    """
    low, high = ends[0] - zero, ends[1] - zero
    contact = any(each.one_sided and not math.isfinite(each.upper - each.lower) for _, each in intervals)
    plausibility.heights(name, [(each.lower, each.upper) for _, each in intervals], low, high, press.size, contact)
    weight = float(press.model.inertias[press.slide_guide.joint + 1].mass) * GRAVITY
    met = intervals if contact and math.isfinite(low) else ()
    for downwards, each in met:  # what a contact does at bottom dead centre
        if downwards and each.sense > 0 and each.lower < low < each.upper:
            plausibility.contact(name, _size(each, low), each.upper - low, weight, press.size)
    pushing = [(downwards, each) for downwards, each in intervals if not (each.one_sided or each.heeds_velocity)]
    if not pushing:
        return  # a contact, or a law of the caller's: what it does not reach is not asked for
    largest = 0.0
    for _, each in pushing:
        lower = each.lower if math.isfinite(each.lower) else each.upper
        for height in (lower, 0.5 * (lower + each.upper), each.upper) if math.isfinite(each.upper) else ():
            largest = max(largest, _size(each, height))
    plausibility.forces(name, largest, weight)
    for downwards, each in pushing:
        reaches_over = downwards and math.isfinite(each.lower) and each.lower < high < each.upper
        # A process load that begins with a hundredth of its largest force begins suddenly.
        if reaches_over and _size(each, each.upper) < 0.01 * largest < _size(each, high):
            plausibility.onset(name, each.upper, high)


def _size(interval: ForceInterval, height: float) -> float:
    """Size of a force that does not depend on the velocity, the largest of all scenarios [N]."""
    return float(np.abs(interval.force(height, 0.0)).max(initial=0.0))


def intervals_of(load: ProcessLoad) -> list[tuple[bool, ForceInterval]]:
    """The intervals of a process load, each with whether it is for downward travel."""
    return [(downwards, interval) for downwards in (True, False) for interval in load.intervals(downwards)]


def acting_between(load: ProcessLoad, press: "Linkage") -> list[tuple[bool, float, float]]:
    """For each interval of a process load whether it is for downward travel, and the slide positions between which it acts, rising [m];
    infinite where it has no end."""
    intervals = intervals_of(caller_laws.asked_load(load))
    zero = datum(caller_laws.as_given(load), press) if intervals else 0.0  # an idle press needs no datum
    return [(downwards, each.lower + zero, each.upper + zero) for downwards, each in intervals]


def _heights(press: "Linkage", motion: "Motion", zero: float) -> tuple[Array, Array]:
    """Heights (n,) of the slide above a slide position [m], and its velocities along the guide's axis (n,) [m/s]."""
    guide, offset, sign = press.slide_guide
    return sign * motion.joint_position[:, guide] + (offset - zero), sign * motion.v[:, guide]


def _force_in(name: str, interval: ForceInterval, height: Array, velocity: Array) -> Array:
    """The force (m,) of a process load at heights (m,) within an interval [N]; raises PinpressError if it is not finite."""
    return np.broadcast_to(interval.acting(numbers(f"{name}: force", interval.force(height, velocity))), height.shape)


def process_force(loads: Sequence[Load], press: "Linkage", motion: "Motion") -> Array:
    """Sum (n,) of the process loads and forces in time on the slide, along its guide's axis [N]; raises as `apply`."""
    total = np.zeros(len(motion.crank_angle))
    for load in wrap_laws(loads):
        if isinstance(load, TimeForce):
            total += _in_time(load, motion)
        elif not isinstance(load, LinkLoad):
            total += _in_height(load, press, motion, warned=True)
    return total


def process_work(loads: Sequence[Load], press: "Linkage", motion: "Motion") -> Array:
    """Work that the slide does against the process loads and forces in time from each of a motion's states to the next, over a `cycle` also
    from the last one to the first [J]: (n - 1,), or (n,).

    Raises as `apply`.
    """
    total = np.zeros(len(motion.crank_angle) - (not is_cycle(motion)))
    for load in wrap_laws(loads):
        if isinstance(load, TimeForce):
            power = _closed(motion, -_in_time(load, motion) * _heights(press, motion, 0.0)[1])
            total += 0.5 * (power[1:] + power[:-1]) * np.diff(_closed_time(motion.time, motion))
        elif not isinstance(load, LinkLoad):
            total += _work_in_height(load, press, motion)
    return total


def _work_in_height(load: ProcessLoad, press: "Linkage", motion: "Motion") -> Array:
    """Work against a process load, as of `process_work`: its laws are integrated over the height within the borders of its intervals."""
    intervals = intervals_of(load)
    if not intervals:
        return np.zeros(len(motion.crank_angle) - (not is_cycle(motion)))
    heights, velocities = _heights(press, motion, datum(caller_laws.as_given(load), press))
    height, velocity, before = _through_turning_points(motion, _closed(motion, heights), _closed(motion, velocities))
    work = np.zeros(len(height) - 1)
    begin, way, change = height[:-1, None], np.diff(height)[:, None], np.diff(velocity)[:, None]
    nodes, weights = GAUSS
    for downwards, interval in intervals:
        ends = np.clip(np.stack([height[:-1], height[1:]]), interval.lower, interval.upper)
        steps = np.flatnonzero((way[:, 0] < 0) & downwards | (way[:, 0] > 0) & (not downwards))
        steps = steps[ends[0, steps] != ends[1, steps]]
        first, travel = ends[0, steps, None], (ends[1] - ends[0])[steps, None]
        at = first + travel * nodes
        speed = velocity[:-1, None][steps] + change[steps] * (at - begin[steps]) / way[steps]
        force = _force_in(caller_laws.name(load), interval, at.ravel(), speed.ravel()).reshape(at.shape)
        work[steps] -= force @ weights * travel[:, 0]
    return np.asarray(np.bincount(before, work, len(motion.crank_angle) - (not is_cycle(motion))))


def _through_turning_points(motion: "Motion", height: Array, velocity: Array) -> tuple[Array, Array, NDArray[np.intp]]:
    """Heights and velocities with those where the slide turns back between two states, as it does under an even acceleration; and for each
    step from one to the next the state at or before its beginning."""
    states = np.arange(len(height) - 1)
    if motion._time is None or not len(states):
        return height, velocity, states
    before = np.flatnonzero(velocity[:-1] * velocity[1:] < 0)
    share = velocity[before] / (velocity[before] - velocity[before + 1])
    turns = height[before] + 0.5 * velocity[before] * share * np.diff(_closed_time(motion._time, motion))[before]
    return np.insert(height, before + 1, turns), np.insert(velocity, before + 1, 0.0), np.sort(np.concatenate([states, before]))


def _closed(motion: "Motion", values: Array) -> Array:
    """Values (n,) over a motion, with the first one once more behind those over a `cycle`."""
    return np.append(values, values[0]) if is_cycle(motion) else values


def _closed_time(time: Array, motion: "Motion") -> Array:
    return np.append(time, 2 * time[-1] - time[-2]) if is_cycle(motion) else time


def turning_points(press: "Linkage") -> tuple[float, float]:
    """Slide positions at bottom and top dead centre [m]; infinite where there are none."""
    try:
        ends = dead_centres(press)
        return ends.bottom_position, ends.top_position
    except PinpressError:
        return -math.inf, math.inf


def _refuse_scenarios(name: str, interval: ForceInterval) -> None:
    """Raise PinpressError where a load's magnitude is an array of scenarios: over as many states it would be taken for one number a
    state."""
    somewhere = next((height for height in (interval.upper, interval.lower) if math.isfinite(height)), 0.0)
    shape = np.shape(interval.force(somewhere, 0.0))
    if shape:
        raise PinpressError(f"{name}: its force has shape {shape}, for scenarios; give one number, as a motion is one scenario")


def _in_time(load: TimeForce, motion: "Motion") -> Array:
    """The force (n,) of a load in time on the slide, along the guide's axis [N]."""
    load.force(motion.time[:1])  # refuses an array that does not depend on time, which may have as many values as the motion has states
    return np.broadcast_to(numbers("TimeForce: force", load.force(motion.time), unit="N"), motion.time.shape)


def point_force(load: PointForce, press: "Linkage", force: ArrayLike, states: int | None = None, *, warned: bool = False) -> AppliedForce:
    """A force at a point of a link, placed on its body.

    Args:
        load: the load.
        press: the linkage.
        force: its force in world axes [N]: (3,), or over ``states`` (states, 3).
        states: number of states of a motion; None: the force is constant, and stands in one state.
        warned: whether the load was looked at before.

    Raises:
        UnknownNameError: a link that the linkage does not have.
        PinpressError: a force of another number of states.

    Warns:
        PinpressWarning: the link turns about this point in the frame, so that the force does no work.
    """
    what = load.label
    joint, point = point_on_body(press, load.link, load.point, what, "point")
    values, shapes = np.asarray(force, dtype=float), [(3,)] if states is None else [(3,), (states, 3)]
    if values.shape not in shapes:
        raise PinpressError(f"{what}: force has shape {values.shape}; give {' or '.join(map(str, shapes))}, in world axes [N]")
    unbalance = callable(load.force)  # a force that a caller turns at a pin
    if joint and not (warned or unbalance) and values.any() and (pins := _pins_in_frame(press, joint, point)):
        caution(
            f"{what}: its point is at pin {pins[0]}, which stands still in the frame, so that the force does no work:"
            " give point=, where it acts in the link's own frame [m]"
        )
    return AppliedForce(joint, point, np.broadcast_to(values, (1 if states is None else states, 3)))


def _pins_in_frame(press: "Linkage", joint: int, point: Array) -> list[str]:
    """Names of the pins at a point of a body (3,) about which the body turns in the frame."""
    pins = [
        name
        for body, (name, axis) in enumerate(zip(press.joints, press.axes, strict=True), 1)
        if body == joint and press.model.parents[body] == 0 and axis.turns and _apart(point, axis.direction) <= ROUNDING * press.size
    ]
    for loop in press.loops:
        ends = {loop.joint1: loop.point1, loop.joint2: loop.point2}
        if set(ends) == {0, joint} and np.linalg.norm(point - ends[joint]) <= ROUNDING * press.size:
            pins.append(loop.name)
    return pins


def _apart(point: Array, axis: Array) -> float:
    """Distance of a point from an axis (3,) of unit length through the origin."""
    return float(np.linalg.norm(point - (point @ axis) * axis))


def moment_vectors(load: PointMoment, press: "Linkage", moment: Any) -> Array:
    """`PointMoment.vectors`; raises PinpressError where one number is given and the linkage moves in a plane other than x-z."""
    vectors, plane = load.vectors(moment), press.planarity
    if np.size(moment) == 1 and plane.is_planar and abs(plane.normal[1]) < 0.5:
        problem = f"one number is a moment in the x-z plane, and {press.name} does not move in it"
        raise PinpressError(f"{load.label}: {problem}: give three numbers, in world axes [N m]")
    return vectors


def _moment_forces(load: PointMoment, press: "Linkage", motion: "Motion", vectors: Array) -> list[AppliedForce]:
    """The forces of a moment (3,) or (n, 3) [N m] on its link, and of the opposite one on the link that takes it."""
    count = len(motion.crank_angle)
    if vectors.ndim == 2 and len(vectors) != count:
        raise PinpressError(f"{load.label}: moment has {len(vectors)} rows, but the motion has {count} states")
    moment = np.broadcast_to(vectors, (count, 3))
    bodies = [body_of(press, link) for link in (load.link, load.on) if link is not None]
    return [AppliedForce.couple(body, sign * moment) for body, sign in zip(bodies, (1.0, -1.0), strict=False)]


class RelativeTurn(NamedTuple):
    """How two links turn against each other about parallel axes.

    Attributes:
        bodies: Pinocchio joints on whose bodies the two links are.
        axis: (3,) in the frame of the second body's joint, of length 1.
        by: (nv,) 1 or -1 for the joints whose angles add up to that of the second link against the first, 0 for the others.
    """

    bodies: tuple[int, int]
    axis: Array
    by: Array

    def angle(self, coordinates: Array) -> Array:
        """The angle [rad] at joint coordinates (..., nv), or its rate at joint rates."""
        return np.asarray(coordinates @ self.by)


def relative_turn(press: "Linkage", link1: str, link2: str, what: str) -> RelativeTurn | None:
    """How link2 turns against link1; None if it does not. ``what`` has the links, for messages.

    Raises:
        UnknownNameError: a link that the linkage does not have.
        PinpressError: between them joints turn about axes that are not parallel.
    """
    bodies = body_of(press, link1), body_of(press, link2)
    remedy = "in inverse_dynamics give a PointMoment by a function of the motion"
    return turn_between(press, bodies, f"{what}: between {shown(link1)} and {shown(link2)}", remedy)


def turn_between(press: "Linkage", bodies: tuple[int, int], what: str, remedy: str) -> RelativeTurn | None:
    """How the second of two bodies turns against the first, by their numbers; otherwise as `relative_turn`."""
    first, second = bodies
    between = joints_between([parent - 1 for parent in list(press.model.parents)[1:]], first - 1, second - 1)
    placed, axes = drawn_placements(press.model), press.axes
    turning = [joint for joint in between if axes[joint].turns]
    if not turning:
        return None
    back = [joint for joint in turning if between[joint] < 0]  # on the way from link1 towards the frame
    begin = max(back) if back else min(turning)
    axis, by = placed[begin + 1].rotation @ axes[begin].direction, np.zeros(len(axes))
    for joint in turning:
        own = placed[joint + 1].rotation @ axes[joint].direction
        if not np.linalg.norm(np.cross(own, axis)) <= PARALLEL:
            raise PinpressError(
                f"{what} joints {press.joints[begin]} and {press.joints[joint]} turn about axes"
                f" that are not parallel, so that there is no one angle: {remedy}"
            )
        by[joint] = between[joint] * np.sign(own @ axis)
    return RelativeTurn(bodies, placed[second].rotation.T @ axis, by)


def turn_of_spring(load: TorsionSpring, press: "Linkage") -> RelativeTurn:
    """How the second link of a torsion spring turns against the first; raises PinpressError where it does not, and as `relative_turn`."""
    turn = relative_turn(press, load.link1, load.link2, load.label)
    if turn is None:
        raise PinpressError(f"{load.label}: these links do not turn against each other: name two that do")
    return turn


def turn_forces(press: "Linkage", motion: "Motion", turn: RelativeTurn, moment: Array) -> list[AppliedForce]:
    """The forces of a moment (n,) about the axis of a turn on its second link, and of the opposite one on its first [N m]."""
    axis = rotation_of(press, motion.joint_position, turn.bodies[1]) @ turn.axis
    vectors = moment[:, None] * axis
    return [AppliedForce.couple(turn.bodies[1], vectors), AppliedForce.couple(turn.bodies[0], -vectors)]


def _spring_forces(load: SpringDamper, press: "Linkage", motion: "Motion") -> list[AppliedForce]:
    """The forces of a spring and damper on its two links."""
    ends, what = spring_ends(load, press), load.label
    (position1, velocity1), (position2, velocity2) = (point_motion(press, motion, *end) for end in ends)
    span, rate = position2 - position1, velocity2 - velocity1
    length = np.linalg.norm(span, axis=1)
    if (load.free_length or load.damping) and not length.min() > 1e-12 * press.size:
        place = motion.driver_coordinates[0].at(np.ravel(motion.crank_angle[int(length.argmin())])[0])
        raise PinpressError(f"{what}: its ends meet at {place}, where it has no direction; move a point")
    direction = span / np.where(length == 0.0, 1.0, length)[:, None]
    tension = load.stiffness * (length - load.free_length) + load.damping * np.einsum("nk,nk->n", rate, direction)
    force = tension[:, None] * direction
    return [AppliedForce(*ends[0], force), AppliedForce(*ends[1], -force)]


def spring_ends(load: SpringDamper, press: "Linkage") -> tuple[tuple[int, Array], tuple[int, Array]]:
    """The ends of a spring: for each the Pinocchio joint on whose body it is, and the point (3,) in that joint's frame [m].

    Raises:
        UnknownNameError: a link that the linkage does not have.
    """
    what = load.label
    plausibility.length(f"{what}: free_length", float(load.free_length), press.size)
    return point_on_body(press, load.link1, load.point1, what, "point1"), point_on_body(press, load.link2, load.point2, what, "point2")
