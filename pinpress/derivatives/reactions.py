"""Exact derivatives of a planar linkage's reactions by the positions of its pivots, at fixed crank angle, speed and acceleration.

The tangent of a force balance is a force balance. For every body, forces F at arms r from the origin of its joint,

    sum F = m a                     sum F' = (m a)'
    sum r x F + M = h    gives      sum r x F' + M' = h' - sum r' x F

with ' for the derivative in a direction of the pivots. The unknown derivatives are balanced by the equations that balance the forces
(`engines.planar.balance`), with right-hand sides in which the forces are known. Inertias do not change in the frames of their links.
Complex numbers and signs are those of `engines.planar.inverse_dynamics`.

A constant load does not depend on the geometry. A process load is a function of the slide's height and speed, which depend on it. Within
its intervals this function is smooth, and is differentiated exactly by a complex step; that of a caller's own load must agree with
differences. Other loads are refused.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..common.errors import PinpressError, said, shown
from ..common.products import product
from ..common.quantities import Array, ComplexArray
from ..dynamics.applied_loads import apply, wrap_laws
from ..engines.friction import REST
from ..engines.planar.balance import Statics, balance, efforts_by_rows, tree_without_work
from ..engines.planar.model import Plane, to_complex
from ..engines.wrenches import AppliedForce
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..loads.caller_laws import LawError, is_known
from ..loads.link import Load, PointForce
from ..loads.process import ForceInterval, ProcessLoad
from .motion import STEP, Rates, Shift, States, Tangent

DIFFERENCE = 1e-5  # share of a range over which a law's slope is found by differences, to check the complex step
ROUGHLY = 1e-3  # relative difference accepted between the two slopes
ANALYTIC = "write it with NumPy's functions that are smooth in complex numbers, without abs, max, real or float"


class Push(NamedTuple):
    """A load on a moving link. Vectors are complex numbers in the axes of the plane.

    Attributes:
        body: index in v of the joint that carries the link.
        arm: from this joint to the point of action, in the drawn pose [m].
        force: (n,) [N].
        slope: (n,) derivative of the force in the direction of the pivots [N per unit].
        braced: whether the frame takes the opposite force in the same line of action, so that none of it leaves the machine.
    """

    body: int
    arm: complex
    force: ComplexArray
    slope: ComplexArray
    braced: bool


def refuse_unknown(loads: Sequence[Load]) -> None:
    """Refuse loads whose force has no exact derivative here.

    Raises:
        PinpressError: a load that is neither a constant force nor a process load with a datum.
    """
    if not isinstance(loads, list | tuple):
        raise PinpressError(f"loads is a {type(loads).__name__}: give a list, loads=[...]")
    for load in loads:
        if isinstance(load, PointForce) and not callable(load.force):
            continue
        if isinstance(load, ProcessLoad) and not isinstance(load, type):
            if load.datum is None and (load.intervals(True) or load.intervals(False)):
                raise PinpressError(
                    f"{type(load).__name__}: the bottom dead centre moves with the geometry: give datum=, a slide position [m]"
                )
            continue
        raise PinpressError(
            f"load {shown(load)}: exact derivatives are known of constant PointForces and of process loads with a datum: give these"
        )


def pushes(plane: Plane, press: Linkage, motion: Motion, loads: Sequence[Load], height: Array, velocity: Array) -> list[Push]:
    """The loads on moving links, with their derivatives in a direction of the pivots.

    Args:
        plane: constants of the linkage.
        press: the linkage.
        motion: its motion.
        loads: loads that `refuse_unknown` accepts.
        height: (n,) derivative of the slide's position.
        velocity: (n,) derivative of the slide's velocity.

    Raises:
        LawError: a caller's force law is not smooth in complex numbers.
    """
    result = []
    for load in loads:
        applied = apply(wrap_laws([load]), press, motion)
        braced = not isinstance(load, PointForce)
        for each in applied:
            if each.joint:
                slope = _force_slope(load, press, motion, height, velocity) if isinstance(load, ProcessLoad) else 0.0
                result.append(_push(plane, each, slope, braced, press.slide_guide.sign if braced else 1.0))
    return result


def _push(plane: Plane, load: AppliedForce, slope: Array | float, braced: bool, sign: float) -> Push:
    body = load.joint - 1
    arm = complex(*(plane.frames[body] @ load.point)[:2])
    guide = sign * plane.directions[plane.prismatic.index(body), 0] if braced else 0.0
    force = to_complex(plane, load.force)
    return Push(body, arm, force, slope * guide * np.ones_like(force), braced)


def _force_slope(load: ProcessLoad, press: Linkage, motion: Motion, height: Array, velocity: Array) -> Array:
    """Derivative (n,) of the force of a process load along the guide [N per unit]."""
    above, speed, result = motion.slide_position - (load.datum or 0.0), motion.slide_velocity, np.zeros_like(height)
    down = speed < -REST * press.size * np.abs(motion.crank_speed).max()  # as `apply` decides
    for downwards in (True, False):
        for interval in load.intervals(downwards):
            inside = (down == downwards) & (interval.lower < above) & (above <= interval.upper)
            at = above[inside], speed[inside]
            try:
                law = np.asarray(interval.force(at[0] + 1j * STEP * height[inside], at[1] + 1j * STEP * velocity[inside]), dtype=complex)
            except Exception as error:
                raise LawError(
                    f"{type(load).__name__}: force of complex numbers cannot be worked out: {said(error)}; {ANALYTIC}"
                ) from error
            if not is_known(load) and inside.any():
                _refuse_not_analytic(type(load).__name__, interval, *at)
            result[inside] = np.imag(law) / STEP * ((interval.sense * np.real(law) > 0) if interval.one_sided else 1.0)
    return result


def _refuse_not_analytic(name: str, interval: ForceInterval, height: Array, velocity: Array) -> None:
    """Raise LawError where a caller's force of complex numbers does not give its derivative: `abs`, for example, loses the imaginary
    part."""
    for of, a, b in (("height", 1.0, 0.0), ("velocity", 0.0, 1.0)):
        size = DIFFERENCE * (max(float(np.ptp(height)), DIFFERENCE) if a else max(float(np.abs(velocity).max(initial=0.0)), DIFFERENCE))
        exact = np.imag(interval.force(height + 1j * STEP * a, velocity + 1j * STEP * b)) / STEP * np.ones_like(height)
        above, below = (np.asarray(interval.force(height + way * a * size, velocity + way * b * size), dtype=float) for way in (1, -1))
        near = (above - below) / (2 * size)
        least = DIFFERENCE * float(np.abs(above).max(initial=0.0)) / (size / DIFFERENCE)
        wrong = np.abs(exact - near) > ROUGHLY * np.maximum(np.abs(exact), np.abs(near)) + least
        if 2 * wrong.sum() > wrong.size:  # at a kink some of them may differ
            raise LawError(f"{name}: force of complex numbers does not have its derivative by the {of}; {ANALYTIC}")


# ------------------------------------------------------------------------------------------------------------------------ reactions


class Balanced(NamedTuple):
    """States whose reactions are known.

    Attributes:
        states: the closed configurations.
        rates: their joint rates and accelerations.
        statics: constants of the balance of its forces.
        mass: (nv,) of the bodies [kg].
        forces: (bearings, n) complex [N].
        sides: the bodies that every loop joins, -1 for the frame.
    """

    states: States
    rates: Rates
    statics: Statics
    mass: Array
    forces: ComplexArray
    sides: Sequence[tuple[int, int]]


class ReactionTangent(NamedTuple):
    """Derivatives of reactions in one direction of the pivots.

    Attributes:
        torque: (n,) of the driver, along its axis.
        forces: (bearings, n) complex; None if bearings share forces that rigid mechanics leaves open.
        moments: (bearings, n) about the normal; None if the forces are.
        shaking_force: (n,) complex.
        shaking_moment: (n,) about the world origin and the normal.
    """

    torque: Array
    forces: ComplexArray | None
    moments: Array | None
    shaking_force: ComplexArray
    shaking_moment: Array


def tangent(balanced: Balanced, moved: Tangent, by: Shift, pushes: Sequence[Push]) -> ReactionTangent:
    """Derivatives of reactions.

    Args:
        balanced: states whose reactions are known.
        moved: derivatives of the states in the direction.
        by: what the direction adds to the rows of the plane.
        pushes: the loads on moving links.
    """
    plane, basis, bodies = balanced.states.plane, balanced.states.basis, balanced.statics.bodies
    origins, centers = product(plane.origins, basis), product(plane.centers, basis)
    origins_slope = product(plane.origins, moved.basis) + product(by.origins, basis)
    centers_slope = product(plane.centers, moved.basis)
    second = balanced.rates.second.copy()
    second[0] = 1.0  # so that the first column of the rows is the weight
    own = product(bodies.forces, second)
    own_slope = product(bodies.forces, moved.second) + balanced.mass[:, None] * product(by.origins, balanced.rates.second)
    spin = bodies.inertia @ moved.a

    moment = _moment(centers_slope, own) + _moment(centers, own_slope) + spin
    _add_bearings(balanced, moved, by, origins_slope, moment)
    subtree = plane.subtree @ own_slope
    shaking_force = -own_slope.sum(axis=0)
    shaking_moment = -(_moment(origins_slope + centers_slope, own) + _moment(origins + centers, own_slope) + spin).sum(axis=0)
    for push in pushes:
        arm, arm_slope = (push.arm * rotor[plane.rotor(push.body)] for rotor in (basis, moved.basis))
        moment[push.body] -= _moment(arm_slope, push.force) + _moment(arm, push.slope)
        subtree[plane.carriers(push.body)] -= push.slope
        if not push.braced:
            shaking_force += push.slope
            shaking_moment += _moment(origins_slope[push.body] + arm_slope, push.force)
            shaking_moment += _moment(origins[push.body] + arm, push.slope)
    torque, forces, moments = _balance(balanced, moved, origins, subtree, moment)
    return ReactionTangent(torque, forces, moments, shaking_force, shaking_moment)


def _add_bearings(balanced: Balanced, moved: Tangent, by: Shift, origins_slope: ComplexArray, moment: Array) -> None:
    """Add to the moment of every body what the known forces of its bearings do because their arms change; its own joint has no arm."""
    plane, basis = balanced.states.plane, balanced.states.basis
    count = len(plane.parents)
    for joint, parent in enumerate(plane.parents):
        if parent >= 0:
            moment[parent] += _moment(origins_slope[joint] - origins_slope[parent], balanced.forces[joint])
    first = product(plane.loop_points, moved.basis) + product(by.loop_points, basis)
    second = first + product(plane.gap_rows, moved.basis) + product(by.gap_rows, basis)
    for k, (body1, body2) in enumerate(balanced.sides):
        if body1 >= 0:
            moment[body1] += _moment(first[k] - origins_slope[body1], balanced.forces[count + k])
        if body2 >= 0:
            moment[body2] -= _moment(second[k] - origins_slope[body2], balanced.forces[count + k])


def _balance(
    balanced: Balanced, moved: Tangent, origins: ComplexArray, subtree: ComplexArray, moment: Array
) -> tuple[Array, ComplexArray | None, Array | None]:
    """Torque, forces and moments of the bearings, from the tips of the tree to the frame as in `engines.planar.inverse_dynamics`.

    Args:
        balanced: states whose reactions are known.
        moved: derivatives of the states.
        origins: (nv, n) complex positions of the joint origins [m].
        subtree: (nv, n) complex forces, summed over all bodies that a joint carries.
        moment: (nv, n) moments on the bodies; overwritten.
    """
    plane, basis, bodies = balanced.states.plane, balanced.states.basis, balanced.statics.bodies
    count = len(plane.parents)
    inner = [joint for joint in reversed(range(count)) if plane.parents[joint] >= 0]
    for joint in inner:
        parent = plane.parents[joint]
        moment[parent] += moment[joint] + _moment(origins[joint] - origins[parent], subtree[joint])
    joint_efforts = plane.sense[:, None] * moment
    slides, slides_slope = product(plane.directions, basis), product(plane.directions, moved.basis)
    for joint, slide, slide_slope in zip(plane.prismatic, slides, slides_slope, strict=True):
        joint_efforts[joint] = (slide.conj() * subtree[joint]).real + (slide_slope.conj() * balanced.forces[joint]).real
    relation_multipliers = np.zeros((len(plane.offsets), basis.shape[1]))
    tree = tree_without_work(balanced.statics, subtree.conj())
    torque = balance(
        balanced.statics,
        balanced.states.slopes.configurations,
        tree,
        relation_multipliers,
        efforts_by_rows(balanced.statics, joint_efforts),
    )
    if plane.redundant:
        return torque, None, None
    bearings = np.array(tree.forces).conj()
    moments = np.zeros(bearings.shape)
    points = product(plane.loop_points, basis)
    for joint in plane.prismatic:
        moments[joint] = moment[joint] - sum(
            plane.incidence[joint, k] * _moment(points[k] - origins[joint], bearings[count + k])
            for k in np.flatnonzero(plane.incidence[joint])
        )
    moments[plane.driver] = plane.sense[plane.driver] * torque
    for joint in bodies.geared:
        moments[joint] += plane.sense[joint] * (plane.relation_slopes[:, joint] @ relation_multipliers)
    return torque, bearings, moments


def _moment(arm: ComplexArray, force: ComplexArray) -> Array:
    """The moment of a force about the normal, positive along it."""
    return np.asarray((arm.conj() * force).imag)
