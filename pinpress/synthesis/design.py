"""A press with one set of variables: the `Trial`, the argument of objectives and constraints, and the `Design` behind it.

An objective is a plain NumPy function of a `Trial`. A complex step gives its exact gradient: for each variable the function is called once
with a trial whose arrays are complex, value + i h derivative. h is so small that h^2 is less than a rounding error. The imaginary part of
the result is then h times its derivative. The derivatives of motion and reactions are exact (`pinpress.derivatives`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import cast

import numpy as np
import pinocchio as pin

from ..common.errors import PinpressError
from ..common.frozen import Frozen, NamedArrays, read_only
from ..common.products import product
from ..common.quantities import Array, ComplexArray
from ..derivatives.motion import STEP, Displacements, Rates, Shift, States, Tangent, guide_shift, shift
from ..derivatives.reactions import Balanced, Push, pushes, tangent
from ..derivatives.reshape import continue_geometry, redrawn
from ..dynamics.applied_loads import apply, wrap_laws
from ..dynamics.shaking import shaking
from ..engines.engine import ClosedStates
from ..engines.planar.balance import Statics, build_statics
from ..engines.planar.bodies import build_bodies
from ..engines.planar.equations import Equations
from ..engines.planar.inverse_dynamics import inverse_dynamics
from ..engines.planar.model import Plane, to_complex, to_world
from ..engines.wrenches import AppliedConditions, Wrenches
from ..kinematics.motion import Motion, of_states
from ..linkage.linkage import Linkage, SlideGuide
from ..loads.link import Load
from .table_variables import TableVariables

SHARED = "redundant bearings share forces, so the derivatives of these forces are not known: use driving_torque"
OUT_OF_PLANE = "the links are in several planes, so the derivatives of moments are not known: use forces or driving_torque"


@dataclass(frozen=True, eq=False, repr=False)
class Trial(Frozen):
    """A press with one set of variables, from which objectives and constraints are computed.

    For a gradient the arrays are complex. So write a function of a trial with NumPy functions that take complex numbers: arithmetic, sums,
    ``min``, ``max``, ``ptp``, ``sqrt``, ``sin`` and similar ones. Compare real parts. Instead of ``abs(x)``, ``hypot`` and ``arctan2``
    write ``np.where(x.real < 0, -x, x)``, ``np.sqrt(x * x + y * y)`` and ``np.arctan(y / x)``. `synthesise` refuses a function whose
    gradient differs from difference quotients of its values.

    Attributes:
        variables: name -> value of each variable [SI].
        motion: motion over one period at constant speed, see `cycle`.
    """

    variables: Mapping[str, float]
    motion: Motion
    _positions: Callable[[], Mapping[str, Array]]
    _press: Callable[[], Linkage]
    _reactions: Callable[[], TrialReactions]

    @cached_property
    def positions(self) -> Mapping[str, Array]:
        """Name of a bearing -> (n, 3) position in world axes [m], computed at the first access."""
        return self._positions()

    @cached_property
    def press(self) -> Linkage:
        """The linkage, whose numbers are always real."""
        return self._press()

    @cached_property
    def reactions(self) -> TrialReactions:
        """The reactions of the press, computed at the first access."""
        return self._reactions()


@dataclass(frozen=True, eq=False, repr=False)
class TrialReactions(Frozen):
    """Reactions of a trial, with the names, signs and units of `Reactions`.

    Attributes:
        driving_torque: (n,) driving torque [N m].
        shaking_force: (n, 3) shaking force in world axes [N].
    """

    driving_torque: Array
    shaking_force: Array
    _bearing_force: Mapping[str, Array] | None
    _bearing_moment: Mapping[str, Array] | None
    _shaking_moment: Array | None

    @property
    def bearing_force(self) -> Mapping[str, Array]:
        """Name of a joint or loop -> (n, 3) force in world axes [N].

        Raises:
            PinpressError: the access is for a gradient, and redundant bearings share forces.
        """
        if self._bearing_force is None:
            raise PinpressError(SHARED)
        return self._bearing_force

    @property
    def bearing_moment(self) -> Mapping[str, Array]:
        """Name of a joint or loop -> (n, 3) moment in world axes [N m].

        Raises:
            PinpressError: the access is for a gradient, and redundant bearings share forces, or the links are in several planes.
        """
        if self._bearing_moment is None:
            raise PinpressError(SHARED if self._bearing_force is None else OUT_OF_PLANE)
        return self._bearing_moment

    @property
    def shaking_moment(self) -> Array:
        """(n, 3) shaking moment about the world origin [N m].

        Raises:
            PinpressError: the access is for a gradient, and the links are in several planes.
        """
        if self._shaking_moment is None:
            raise PinpressError(OUT_OF_PLANE)
        return self._shaking_moment


@dataclass(frozen=True, eq=False, repr=False)
class Start:
    """The press at the start of a search, planar and drawn closed, with its planar equations, its motion over one period, its loads, and
    the pin table that it was drawn from."""

    press: Linkage
    plane: Plane
    motion: Motion
    loads: Sequence[Load]
    table: TableVariables | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Design:
    """The starting press with displaced pivots, closed at all crank angles, in the joint coordinates of the start.

    Attributes:
        start: the press at the start of the search.
        variables: name -> value of each variable [SI].
        moved: displacements of the pivots from the start.
        slopes: derivatives of these displacements by each variable.
        plane: constants of the planar equations.
        position: (nv, n) joint coordinates [rad or m].
        first: (nv, n) first influence coefficients, the derivatives of ``position`` by the crank angle.
        second: (nv, n) second influence coefficients, the second derivatives.
        gap: (n,) largest gap of the loops [m].
    """

    start: Start
    variables: dict[str, float]
    moved: Displacements
    slopes: Sequence[Displacements]
    plane: Plane
    position: Array
    first: Array
    second: Array
    gap: Array

    def next(self, variables: dict[str, float], moved: Displacements, slopes: Sequence[Displacements]) -> Design:
        """Another design, in the assembly continued from this design.

        Args:
            variables: name -> value of each variable [SI].
            moved: displacements of the pivots from the start.
            slopes: derivatives of these displacements by each variable.

        Raises:
            AssemblyError: the design cannot be assembled.
            SingularityError: two assemblies meet on the way there.
        """
        start = self.start
        by = shift(start.press, start.plane, moved.less(self.moved))
        plane, closure = continue_geometry(self.plane, self.position, by)
        return Design(start, variables, moved, slopes, plane, closure.position, closure.first, closure.second, closure.gap)

    @cached_property
    def press(self) -> Linkage:
        """The linkage of this design, drawn in its own closed pose; of a pin table with the masses that it gives to this design."""
        press = redrawn(self.start.press, self.moved, self.position[:, 0])
        return press if self.start.table is None else self.start.table.weighed(press, self.variables)

    def trial(self) -> Trial:
        """The trial of this design, with real arrays."""
        return Trial(
            dict(self.variables),
            self.motion,
            partial(getattr, self, "_positions"),
            partial(getattr, self, "press"),
            partial(getattr, self, "_reactions"),
        )

    def trial_towards(self, place: int, step: float) -> Trial:
        """The trial for the gradients by one variable, with complex arrays, value + i h derivative with h = STEP * ``step``.

        Args:
            place: index of the variable.
            step: range that scales the variable [SI].
        """
        h, name = STEP * step, list(self.variables)[place]
        return Trial(
            self.variables | {name: cast("float", self.variables[name] + 1j * h)},
            self._motion_towards(place, h),
            partial(self._positions_towards, place, h),
            partial(getattr, self, "press"),
            partial(self._reactions_towards, place, h),
        )

    # ----------------------------------------------------------------------------------------------------------------------------- motion

    @cached_property
    def _states(self) -> States:
        return States.of(self.plane, self.position)

    @cached_property
    def _rates(self) -> Rates:
        speed, acceleration = self.start.motion.crank_speed, self.start.motion.crank_acceleration  # a driver that slides turns round
        return Rates.of(self._states, self.first * speed, self.second * speed**2 + self.first * acceleration)

    @cached_property
    def _by(self) -> list[Shift]:
        return [shift(self.start.press, self.start.plane, slope) for slope in self.slopes]

    @cached_property
    def _tangents(self) -> list[Tangent]:
        return [Tangent.of(self._states, self._rates, by) for by in self._by]

    @cached_property
    def motion(self) -> Motion:
        """The motion over one period, from crank angle 0."""
        press, drawn = self.start.press, self.position[:, :1]
        motion = of_states(
            press, self.position - drawn, self._rates.v, self._rates.a, self.gap, self.start.motion.time, self.start.motion.period_turns
        )
        if press.slide is None:
            return motion
        guide, offset, sign = press.slide_guide
        offset += sign * (float(drawn[guide, 0]) + guide_shift(self.plane, shift(press, self.start.plane, self.moved), guide))
        return replace(motion, _guide=SlideGuide(guide, offset, sign))

    def _motion_towards(self, place: int, h: float) -> Motion:
        motion, slope, by = self.motion, self._tangents[place], self._by[place]
        drawn = slope.position[:, :1]
        guided = motion._guide
        if guided is not None:
            guide, offset, sign = guided
            moved = sign * (float(drawn[guide, 0]) + guide_shift(self.plane, by, guide))
            guided = SlideGuide(guide, cast("float", offset + 1j * h * moved), sign)
        return replace(
            motion,
            joint_position=_complex(motion.joint_position, h, (slope.position - drawn).T),
            v=_complex(motion.v, h, slope.v.T),
            a=_complex(motion.a, h, slope.a.T),
            _guide=guided,
        )

    @cached_property
    def _points(self) -> Array:
        return np.array([self._point(bearing) for bearing in range(len(self.start.press.bearings))])

    @cached_property
    def _positions(self) -> Mapping[str, Array]:
        return NamedArrays(self.start.press.bearings, self._points)

    def _positions_towards(self, place: int, h: float) -> Mapping[str, Array]:
        slopes = np.array([self._point_slope(bearing, place) for bearing in range(len(self._points))])
        return NamedArrays(self.start.press.bearings, _complex(self._points, h, slopes))

    def _point(self, bearing: int) -> Array:
        """World position (n, 3) of a bearing [m]."""
        plane, count = self.plane, len(self.plane.parents)
        row = plane.origins[bearing] if bearing < count else plane.loop_points[bearing - count]
        height = plane.heights[bearing] if bearing < count else plane.loop_heights[bearing - count]
        return np.asarray(to_world(plane, product(row[None], self._states.basis)[0]) + height * plane.normal)

    def _point_slope(self, bearing: int, place: int) -> Array:
        """Derivative (n, 3) of the position of a bearing by a variable."""
        plane, by, count = self.plane, self._by[place], len(self.plane.parents)
        rows = [(of.origins[bearing] if bearing < count else of.loop_points[bearing - count])[None] for of in (plane, by)]
        return to_world(plane, (product(rows[0], self._tangents[place].basis) + product(rows[1], self._states.basis))[0])

    # -------------------------------------------------------------------------------------------------------------------------- reactions

    @cached_property
    def _wrenches(self) -> Wrenches:
        self.start.press.refuse_contacts("a synthesis does not compute forces with them; give only functions of the motion")
        return self._wrenches_of(self.press)

    def _wrenches_of(self, press: Linkage) -> Wrenches:
        """Wrenches of a press with these lengths and other masses."""
        conditions = AppliedConditions(apply(wrap_laws(self.start.loads), press, self.motion), None, None)
        states = ClosedStates(self.position, self._rates.v, self._rates.a, self._states.basis)
        return inverse_dynamics(self._statics_of(press), states, conditions, bearings=True)

    def _statics_of(self, press: Linkage) -> Statics:
        plane = _weighed(self.plane, press.model)
        return build_statics(build_bodies(plane, press.model), Equations.of(plane))

    @cached_property
    def _statics(self) -> Statics:
        return self._statics_of(self.press)

    @cached_property
    def _reactions(self) -> TrialReactions:
        return self._reactions_of(self.press, self._wrenches)

    def _reactions_of(self, press: Linkage, wrenches: Wrenches) -> TrialReactions:
        shaken = shaking(press, self.motion, wrenches, apply(wrap_laws(self.start.loads), press, self.motion))
        names = press.bearings
        return TrialReactions(
            wrenches.torque[0], shaken[0], NamedArrays(names, wrenches.force), NamedArrays(names, wrenches.moment), shaken[1]
        )

    def _slopes_by_mass(self, place: int) -> Callable[[Callable[[TrialReactions], Array]], Array | float]:
        """What gives the derivatives of a part of the reactions by the masses that a variable of a table changes, the motion kept."""
        table = self.start.table
        if table is None:
            return lambda part: 0.0
        ahead, back, distance = table.heavier(self.press, self.variables, list(self.variables)[place])
        one, two = (self._reactions_of(press, self._wrenches_of(press)) for press in (ahead, back))
        return lambda part: np.asarray((part(one) - part(two)) / distance)

    def _reactions_towards(self, place: int, h: float) -> TrialReactions:
        real, wrenches, names = self._reactions, self._wrenches, self.start.press.bearings
        slope, by_mass = tangent(self._known, self._tangents[place], self._by[place], self._pushes(place)), self._slopes_by_mass(place)
        force: Mapping[str, Array] | None = None
        moment: Mapping[str, Array] | None = None
        if slope.forces is not None and slope.moments is not None:
            force = NamedArrays(
                names, _complex(wrenches.force, h, to_world(self.plane, slope.forces) + by_mass(lambda of: _stacked(of.bearing_force)))
            )
            if self._statics.bodies.in_one_plane:
                moments = np.multiply.outer(slope.moments, self.plane.normal) + by_mass(lambda of: _stacked(of.bearing_moment))
                moment = NamedArrays(names, _complex(wrenches.moment, h, moments))
        return TrialReactions(
            _complex(real.driving_torque, h, slope.torque + by_mass(lambda of: of.driving_torque)),
            _complex(real.shaking_force, h, to_world(self.plane, slope.shaking_force) + by_mass(lambda of: of.shaking_force)),
            force,
            moment,
            _complex(
                real.shaking_moment,
                h,
                np.multiply.outer(slope.shaking_moment, self.plane.normal) + by_mass(lambda of: of.shaking_moment),
            )
            if self._statics.bodies.in_one_plane
            else None,
        )

    @cached_property
    def _known(self) -> Balanced:
        press = self.start.press
        mass = np.array([inertia.mass for inertia in self.press.model.inertias][1:])
        sides = [(loop.joint1 - 1, loop.joint2 - 1) for loop in press.loops]
        states = self._states._replace(plane=self._statics.bodies.plane)
        return Balanced(states, self._rates, self._statics, mass, to_complex(self.plane, self._wrenches.force), sides)

    def _pushes(self, place: int) -> Sequence[Push]:
        if not self.start.loads:
            return ()
        moving = self._motion_towards(place, STEP)
        height, velocity = (np.zeros(len(moving.crank_angle)),) * 2
        if moving._guide is not None:
            height, velocity = moving.slide_position.imag / STEP, moving.slide_velocity.imag / STEP
        return pushes(self.plane, self.press, self.motion, self.start.loads, height, velocity)


def _complex(value: Array, h: float, derivative: Array) -> Array:
    """value + i h derivative, read-only. In a gradient the arrays of a `Trial` are complex, whatever their type says."""
    result: ComplexArray = value + 1j * h * derivative
    return cast(Array, read_only(result))


def _stacked(named: Mapping[str, Array]) -> Array:
    """The arrays of all names, one after the other."""
    return np.array(list(named.values()))


def _weighed(plane: Plane, model: pin.Model) -> Plane:
    """The constants of a linkage with the centres of mass of a model, whose links have the same frames."""
    levers = np.array([frame @ inertia.lever for frame, inertia in zip(plane.frames, list(model.inertias)[1:], strict=True)])
    centers = np.zeros_like(plane.centers)
    centers[np.arange(len(levers)), list(plane.rotors)] = levers[:, 0] + 1j * levers[:, 1]
    return replace(plane, centers=centers, center_heights=plane.heights + levers[:, 2])
