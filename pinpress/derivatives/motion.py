"""Exact derivatives of a planar linkage's motion by the positions of its pivots, at fixed crank angle, speed and acceleration.

A loop's gap is C b(x): constant rows C, which follow the pivots, times the basis b of the joint coordinates x (see `Plane`). The rows are
sums of vectors from pivot to pivot, so that they change in proportion to the displacements of the pivots: `shift` gives both what a finite
change adds and the derivative in a direction. For all positions of the pivots the gap is zero, and so are its first and second derivative
by time. Differentiated in a direction of the pivots, written ', these three equations are

    J x' = - C' b          J v' = - C' db/dt - C (db/dt)'          J a' = - C' d2b/dt2 - C (d2b/dt2)'

with the Jacobian J of the loops, and on the right only terms without the unknown on the left (implicit function theorem). Each of them is
solved block by block, as the loops themselves are. Nothing is approximated.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..common.arguments import suitable_numbers, typed
from ..common.errors import PinpressError, UnknownNameError, shown
from ..common.products import product
from ..common.quantities import Array, ComplexArray
from ..common.results import Tabular
from ..common.tables import by_driver
from ..engines.planar.closing import Slopes
from ..engines.planar.equations import Equations
from ..engines.planar.kinematics import basis_acceleration, basis_at, basis_velocity
from ..engines.planar.model import Plane
from ..kinematics.motion import Motion, refuse_motion_of_another
from ..linkage.linkage import Linkage

STEP = 1e-30  # step of the complex-step method: its square vanishes beside any number
CONTRADICTED = 1e-9  # share of the displacement by which rounding may leave redundant equations open
Pivots = Mapping[tuple[str, str], ArrayLike]
"""(bearing, link) -> position (3,) of the bearing in the link's own frame [m]."""


@dataclass(frozen=True, eq=False, repr=False)
class MotionSensitivity(Tabular):
    """Derivatives of a motion of n states in one direction of the pivots.

    They belong to the attributes of `Motion` with these names, and are per unit of the direction. All arrays are read-only.

    Attributes:
        motion: the motion itself.
        joint_position: (n, nv) of the joint coordinates [rad or m per unit]. Those of the changed linkage are counted from its own drawn
            pose, closed at crank angle 0.
        v: (n, nv) of the joint rates [rad/s or m/s per unit].
        a: (n, nv) of the joint accelerations [rad/s2 or m/s2 per unit].
        slide_position: (n,) [m per unit]; None if the linkage has no slide.
        slide_velocity: (n,) [m/s per unit]; None if the linkage has no slide.
        slide_acceleration: (n,) [m/s2 per unit]; None if the linkage has no slide.
    """

    motion: Motion
    joint_position: Array
    v: Array
    a: Array
    slide_position: Array | None
    slide_velocity: Array | None
    slide_acceleration: Array | None
    _units: tuple[str, ...]

    @property
    def title(self) -> str:
        what = f"MotionSensitivity of {self.motion.linkage}: {len(self.v)} states"
        if self.slide_position is None:
            return what
        return f"{what}, slide shifted by {self.slide_position.min():.6g} to {self.slide_position.max():.6g} m per unit of the direction"

    @property
    def _pictured(self) -> tuple[str, ...]:
        if self.slide_position is None:
            return ()
        abscissa, *_ = self.motion._pictured
        return abscissa, "slide_position [m per unit]"

    def columns(self) -> dict[str, Array]:
        """Crank angle, and derivatives of slide and joints as (n,) columns, per unit of the direction."""
        columns = by_driver([each.heads[0] for each in self.motion.driver_coordinates], self.motion.crank_angle, self.motion.drivers)
        if self.slide_position is not None and self.slide_velocity is not None and self.slide_acceleration is not None:
            columns |= {
                "slide_position [m per unit]": self.slide_position,
                "slide_velocity [m/s per unit]": self.slide_velocity,
                "slide_acceleration [m/s2 per unit]": self.slide_acceleration,
            }
        for name, per, values in (("position", "", self.joint_position), ("velocity", "/s", self.v), ("acceleration", "/s2", self.a)):
            named = zip(self.motion.joints, self._units, values.T, strict=True)
            columns |= {f"{name}_{joint} [{unit}{per} per unit]": series for joint, unit, series in named}
        return columns


@typed
def motion_derivatives(press: Linkage, motion: Motion, directions: Sequence[Pivots]) -> tuple[MotionSensitivity, ...]:
    """Exact derivatives of a motion by the positions of pivots, at the same crank angles.

    To first order, they are the change from `cycle` of the linkage to `cycle` of the `reshaped` linkage.

    Args:
        press: a planar linkage.
        motion: a motion of this linkage.
        directions: mappings (bearing, link) -> (3,) derivative of the bearing's position in the link's own frame. A direction may move
            several pivots, as one dimension of a press often does.

    Returns:
        The derivatives in every direction.

    Raises:
        PinpressError: the linkage is not planar; the motion belongs to another one; a direction leads out of its plane, or opens loops of a
            redundant linkage; a link that the bearing is not on, or in which it cannot be moved; a derivative that is not three finite
            numbers.
        UnknownNameError: a bearing or link that the linkage does not have.
    """
    plane = planar(press)
    refuse_motion_of_another(press, motion)
    states, drawn = States.of(plane, motion.joint_position.T), States.of(plane, press.closed[:, None])
    rates = Rates.of(states, motion.v.T, motion.a.T)
    units = tuple("rad" if axis.turns else "m" for axis in press.axes)
    result = []
    for direction in directions:
        by = shift(press, plane, directed(press, direction))
        tangent = Tangent.of(states, rates, by)
        slide: tuple[Array | None, Array | None, Array | None] = (None, None, None)
        if press.slide is not None:
            guide, _, sign = press.slide_guide
            moved = tangent.position[guide] + guide_shift(plane, by, guide)
            slide = sign * moved, sign * tangent.v[guide], sign * tangent.a[guide]
        result.append(MotionSensitivity(motion, (tangent.position - drawn.slope(by)).T, tangent.v.T, tangent.a.T, *slide, units))
    return tuple(result)


@typed
def pivot_positions(press: Linkage) -> dict[tuple[str, str], Array]:
    """The position of every bearing in each link in which it can be moved.

    Where links are welded together, the first of them is named; where pivots are given, the others may be named as well.

    Returns:
        (bearing, link) -> (3,) in the link's own frame [m].
    """
    positions = {}
    for j, name in enumerate(press.joints, 1):
        positions[name, _links(press, press.model.parents[j])[0]] = press.model.jointPlacements[j].translation
    for loop in press.loops:
        for joint, point in ((loop.joint1, loop.point1), (loop.joint2, loop.point2)):
            positions[loop.name, _links(press, joint)[0]] = point
    return {(name, link): _placement(press, link).actInv(point) for (name, link), point in positions.items()}


def planar(press: Linkage) -> Plane:
    """The planar engine's constants of a linkage.

    Raises:
        PinpressError: it is not planar.
    """
    return press.plane_or_refuse(
        f"exact derivatives are those of planar linkages with one driver and pins for loops, which {press.name} is not"
    )


def guide_shift(plane: Plane, by: Shift, guide: int) -> float:
    """By how much a guide on the frame is moved along its own axis [m], which no joint coordinate shows."""
    along = plane.directions[plane.prismatic.index(guide), 0]
    return float((along.conjugate() * by.origins[guide, 0]).real)


# ------------------------------------------------------------------------------------------------------------- states and their derivatives


class States(NamedTuple):
    """Closed configurations of a planar linkage, ready for their derivatives.

    Attributes:
        plane: the constants of the linkage.
        basis: (nb, n) the basis, see `Plane`.
        slopes: slopes of the equations there.
    """

    plane: Plane
    basis: ComplexArray
    slopes: Slopes

    @staticmethod
    def of(plane: Plane, position: Array) -> States:
        """The states of closed joint coordinates (nv, n)."""
        basis = basis_at(plane, position)
        return States(plane, basis, Slopes.at(Equations.of(plane), basis, position))

    def solve(self, opened: ComplexArray) -> Array:
        """The joint rates (nv, n), that of the driver zero, that close loops which open at rates ``opened`` (loops, n)."""
        return self.slopes.solve([*opened, *[None] * len(self.plane.offsets)])

    def slope(self, by: Shift) -> Array:
        """The derivative (nv, n) of the joint coordinates at fixed crank angle."""
        return self.solve(product(by.gap_rows, self.basis))


class Rates(NamedTuple):
    """Joint rates and accelerations of states, and the derivatives of the basis by time.

    Attributes:
        v: (nv, n) joint rates.
        a: (nv, n) joint accelerations.
        first: (nb, n) first derivative of the basis by time.
        second: (nb, n) second derivative of the basis by time.
    """

    v: Array
    a: Array
    first: ComplexArray
    second: ComplexArray

    @staticmethod
    def of(states: States, v: Array, a: Array) -> Rates:
        return Rates(v, a, basis_velocity(states.plane, states.basis, v), basis_acceleration(states.plane, states.basis, v, a))


class Tangent(NamedTuple):
    """Derivatives of states in one direction of the pivots.

    Attributes:
        position: (nv, n) of the joint coordinates.
        v: (nv, n) of the joint rates.
        a: (nv, n) of the joint accelerations.
        basis: (nb, n) of the basis.
        second: (nb, n) of the second derivative of the basis by time.
    """

    position: Array
    v: Array
    a: Array
    basis: ComplexArray
    second: ComplexArray

    @staticmethod
    def of(states: States, rates: Rates, by: Shift) -> Tangent:
        """Differentiate states in a direction of the pivots.

        Raises:
            PinpressError: redundant bearings cannot stay closed in this direction.
        """
        plane = states.plane
        moved, rows = by.gap_rows, plane.gap_rows
        opened = product(moved, states.basis)
        position = states.solve(opened)
        basis_slope = basis_velocity(plane, states.basis, position)
        if plane.redundant:
            _refuse_contradiction(opened + product(rows, basis_slope), by)
        still = np.zeros_like(position)
        v = states.solve(product(moved, rates.first) + product(rows, _slope_of_first(plane, states, rates, basis_slope, still)))
        a = states.solve(product(moved, rates.second) + product(rows, _slope_of_second(plane, states, rates, basis_slope, v, still)))
        return Tangent(position, v, a, basis_slope, _slope_of_second(plane, states, rates, basis_slope, v, a))


def _slope_of_first(plane: Plane, states: States, rates: Rates, basis_slope: ComplexArray, v: Array) -> ComplexArray:
    """Derivative (nb, n), in a direction of the pivots, of the first derivative of the basis by time.

    Args:
        plane: constants of the linkage.
        states: closed configurations.
        rates: their rates.
        basis_slope: (nb, n) derivative of the basis in this direction.
        v: (nv, n) derivative of the joint rates in this direction.
    """
    turning = len(plane.revolute)
    spin, spin_slope = plane.turn @ rates.v, plane.turn @ v
    result = np.zeros_like(basis_slope)
    result[1 : 1 + turning] = 1j * (spin * basis_slope[1 : 1 + turning] + spin_slope * states.basis[1 : 1 + turning])
    for row, (joint, rotor) in enumerate(zip(plane.prismatic, plane.guide_rotors, strict=True), 1 + turning):
        result[row] = v[joint] * states.basis[rotor]
        if rotor:
            result[row] += rates.v[joint] * basis_slope[rotor]
            result[row] += 1j * (spin[rotor - 1] * basis_slope[row] + spin_slope[rotor - 1] * states.basis[row])
    return result


def _slope_of_second(plane: Plane, states: States, rates: Rates, basis_slope: ComplexArray, v: Array, a: Array) -> ComplexArray:
    """Derivative (nb, n), in a direction of the pivots, of the second derivative of the basis by time.

    Args:
        plane: constants of the linkage.
        states: closed configurations.
        rates: their rates.
        basis_slope: (nb, n) derivative of the basis in this direction.
        v: (nv, n) derivative of the joint rates in this direction.
        a: (nv, n) derivative of the joint accelerations in this direction.
    """
    turning = len(plane.revolute)
    spin, spin_slope = plane.turn @ rates.v, plane.turn @ v
    factor = 1j * (plane.turn @ rates.a) - spin * spin
    factor_slope = 1j * (plane.turn @ a) - 2 * spin * spin_slope
    result = np.zeros_like(basis_slope)
    result[1 : 1 + turning] = factor * basis_slope[1 : 1 + turning] + factor_slope * states.basis[1 : 1 + turning]
    for row, (joint, rotor) in enumerate(zip(plane.prismatic, plane.guide_rotors, strict=True), 1 + turning):
        if not rotor:
            result[row] = a[joint]
            continue
        k = rotor - 1
        along = rates.a[joint] + 2j * spin[k] * rates.v[joint]
        along_slope = a[joint] + 2j * (spin_slope[k] * rates.v[joint] + spin[k] * v[joint])
        result[row] = along * basis_slope[rotor] + along_slope * states.basis[rotor]
        result[row] += factor[k] * basis_slope[row] + factor_slope[k] * states.basis[row]
    return result


def _refuse_contradiction(left: ComplexArray, by: Shift) -> None:
    """Raise PinpressError where no joint rates keep the loops closed (they open by ``left``): redundant equations contradict each other."""
    worst = np.abs(left).max(axis=1)
    if worst.max() > CONTRADICTED * np.abs(by.gap_rows).max():
        raise PinpressError(
            "bearings that hold each other do not stay closed in this direction: move the pivots of all of them alike; what single ones of"
            " a slide on several points do is found by tolerances.parallelism"
        )


# ------------------------------------------------------------------------------------------------------------------ displacements of pivots


class Displacements(NamedTuple):
    """Displacements of pivots. The frame of a body is that of its Pinocchio joint.

    Attributes:
        joints: (nv, 3) displacements of joints, in the frames of the bodies that carry them [m].
        ends: (loops, 2, 3) displacements of both ends of the loops, in the frames of their bodies [m].
    """

    joints: Array
    ends: Array

    def less(self, other: Displacements) -> Displacements:
        """The difference between these displacements and others."""
        return Displacements(self.joints - other.joints, self.ends - other.ends)


def nowhere(press: Linkage) -> Displacements:
    """Displacements that are all zero."""
    return Displacements(np.zeros((press.model.nv, 3)), np.zeros((len(press.loops), 2, 3)))


def displaced(press: Linkage, pivots: Pivots) -> Displacements:
    """The displacements that bring pivots of a linkage to given positions.

    Raises:
        UnknownNameError: a bearing or link that the linkage does not have.
        PinpressError: a link that the bearing is not on, or in which it cannot be moved; a position that is not three finite numbers.
    """
    moved = nowhere(press)
    for key, position in _vectors(pivots):
        place, before = _pivot(press, *key)
        (moved.joints if len(place) == 1 else moved.ends)[place] = _placement(press, key[1]).act(position) - before
    return moved


def directed(press: Linkage, direction: Pivots) -> Displacements:
    """Displacements per unit of a direction, a mapping (bearing, link) -> (3,) derivative of the position. Raises as `displaced`."""
    moved = nowhere(press)
    for key, derivative in _vectors(direction):
        place, _ = _pivot(press, *key)
        (moved.joints if len(place) == 1 else moved.ends)[place] = _placement(press, key[1]).rotation @ derivative
    return moved


def _vectors(pivots: Pivots) -> Iterator[tuple[tuple[str, str], Array]]:
    """Every pair of names with its vector (3,), after a check."""
    if not isinstance(pivots, Mapping):
        raise PinpressError("pivots is no mapping: give {(bearing, link): (x, y, z)}, in the links' own frames [m]")
    for key, values in pivots.items():
        if not (isinstance(key, tuple) and len(key) == 2):
            raise PinpressError(f"pivots: {shown(key)} is no pair of names: write (bearing, link)")
        yield key, suitable_numbers(f"pivots: {shown(key)}", values, "three finite numbers, in the link's own frame [m]", (3,))


def _pivot(press: Linkage, bearing: str, link: str) -> tuple[tuple[int, ...], Array]:
    """The index of a pivot in `Displacements`, and its position (3,) in the frame of the joint that carries the link [m]."""
    if bearing not in press.bearings:
        raise UnknownNameError("bearing", bearing, press.bearings)
    if link not in press.links:
        raise UnknownNameError("link", link, press.links)
    body, index = _body(press, link), press.bearings.index(bearing)
    if index < len(press.joints):
        parent = press.model.parents[index + 1]
        if body == parent:
            return (index,), press.model.jointPlacements[index + 1].translation
        if body == index + 1:
            others = " or ".join(repr(key) for key in pivot_positions(press) if _body(press, key[1]) == body)
            raise PinpressError(
                f"bearing {shown(bearing)} is the origin of link {shown(link)}'s frame and cannot be moved in it: move the link's"
                " other pivots" + (f", {others}," if others else "") + " instead"
            )
        ends = [parent, index + 1]
    else:
        loop = press.loops[index - len(press.joints)]
        ends = [loop.joint1, loop.joint2]
        if body in ends:
            side = ends.index(body)
            return (index - len(press.joints), side), (loop.point1, loop.point2)[side]
    joined = " and ".join(repr(_links(press, end)[0]) for end in ends)
    raise PinpressError(f"bearing {shown(bearing)} is not on link {shown(link)}: it joins {joined}")


def _placement(press: Linkage, link: str) -> pin.SE3:
    return press.model.frames[press.model.getFrameId(link, pin.BODY)].placement


def _body(press: Linkage, link: str) -> int:
    return int(press.model.frames[press.model.getFrameId(link, pin.BODY)].parentJoint)


def _links(press: Linkage, joint: int) -> list[str]:
    """The links that are welded together on the body of a Pinocchio joint."""
    return [link for link in press.links if _body(press, link) == joint]


# -------------------------------------------------------------------------------------------------- what displacements add to the equations


class Shift(NamedTuple):
    """What displacements add to the rows of a `Plane`.

    Attributes:
        gap_rows: (nl, nb) added to `Plane.gap_rows`.
        origins: (nv, nb) added to `Plane.origins`.
        loop_points: (nl, nb) added to `Plane.loop_points`.
    """

    gap_rows: ComplexArray
    origins: ComplexArray
    loop_points: ComplexArray

    def times(self, share: float) -> Shift:
        """What a share of the displacements adds."""
        return Shift(*(share * rows for rows in self))


def shift(press: Linkage, plane: Plane, moved: Displacements) -> Shift:
    """What displacements add to the rows of a planar linkage.

    Raises:
        PinpressError: a displacement out of the plane.
    """
    origins, points, gaps = (np.zeros_like(rows) for rows in (plane.origins, plane.loop_points, plane.gap_rows))
    for j, parent in enumerate(plane.parents):  # parents come before their children in Pinocchio
        if parent >= 0:
            origins[j] = origins[parent]
        origins[j, plane.rotor(parent)] += _in_plane(plane, parent, moved.joints[j], press.joints[j])
    for k, loop in enumerate(press.loops):
        sides = []
        for joint, displacement in ((loop.joint1 - 1, moved.ends[k, 0]), (loop.joint2 - 1, moved.ends[k, 1])):
            side = origins[joint].copy() if joint >= 0 else np.zeros(gaps.shape[1], complex)
            side[plane.rotor(joint)] += _in_plane(plane, joint, displacement, loop.name)
            sides.append(side)
        points[k], gaps[k] = sides[0], sides[1] - sides[0]
    return Shift(gaps, origins, points)


def shifted(plane: Plane, by: Shift) -> Plane:
    """The constants of a linkage with its pivots moved; joint coordinates still count from the drawn pose of the linkage before."""
    gaps, turning = plane.gap_rows + by.gap_rows, len(plane.revolute)
    size = float(np.abs(gaps[:, : 1 + turning]).sum(axis=1).max(initial=0.0)) or plane.size
    return replace(plane, gap_rows=gaps, origins=plane.origins + by.origins, loop_points=plane.loop_points + by.loop_points, size=size)


def _in_plane(plane: Plane, joint: int, displacement: Array, name: str) -> complex:
    """A displacement in a body's frame as a complex number in the axes of the plane, in the drawn pose; raises PinpressError where it leads
    out of the plane."""
    x, y, along = (plane.frames[joint] if joint >= 0 else np.array([*plane.axes, plane.normal])) @ displacement
    if abs(along) > 1e-12 * max(plane.size, abs(x), abs(y)):  # less is rounding
        raise PinpressError(f"bearing {shown(name)} is moved {along:.3g} m out of the plane of the linkage: move it within the plane")
    return complex(x, y)
