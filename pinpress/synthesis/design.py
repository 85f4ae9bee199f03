"""Designs that a synthesis tries: the press it starts from with its pivots displaced, and all that a `Trial` shows of it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import cast

import numpy as np

from ..common.arrays import Array, ComplexArray
from ..common.frozen import NamedArrays, read_only
from ..derivatives.motion import STEP, Rates, States, Tangent, guide_shift
from ..derivatives.pivots import Displacements, Shift, shift
from ..derivatives.reactions import Balanced, Push, pushes, tangent
from ..derivatives.reshape import continue_geometry, redrawn
from ..dynamics.applied_loads import apply, asked
from ..dynamics.inverse_dynamics import shaking
from ..engines.constant_rows import product
from ..engines.engine import ClosedStates
from ..engines.forces import AppliedConditions, Wrenches
from ..engines.planar.bodies import Bodies, build
from ..engines.planar.inverse_dynamics import inverse_dynamics
from ..engines.planar.model import Plane, flat, in_space
from ..kinematics.motion import Motion, of_states
from ..linkage.linkage import Linkage
from ..loads.link import Load
from .trial import Positions, Trial, TrialReactions


@dataclass(frozen=True, eq=False, repr=False)
class Start:
    """What a search starts from.

    Attributes:
        press: planar, drawn closed.
        plane: the constants of its planar equations.
        motion: its motion over one period, from crank angle 0.
        loads: the loads on it.
    """

    press: Linkage
    plane: Plane
    motion: Motion
    loads: Sequence[Load]


@dataclass(frozen=True, eq=False, repr=False)
class Design:
    """The press of the start with its pivots displaced, closed at all crank angles, in the joint coordinates of the start.

    Attributes:
        start: what the search starts from.
        variables: name -> value [SI].
        moved: the displacements of the pivots from the start.
        slopes: the derivatives of the displacements by every variable.
        plane: the constants of its planar equations.
        position: (nv, n) joint coordinates.
        first: (nv, n) their first influence coefficients, derivatives by the crank angle.
        second: (nv, n) their second influence coefficients.
        gap: (n,) of the loops [m].
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

    def next(self, variables: dict[str, float], moved: Displacements, slopes: Sequence[Displacements]) -> "Design":
        """Another design, its assembly continued from this one.

        Args:
            variables: name -> value [SI].
            moved: the displacements of its pivots from the start.
            slopes: the derivatives of the displacements by every variable.

        Raises:
            AssemblyError, SingularityError: as `continue_geometry` does.
        """
        start = self.start
        by = shift(start.press, start.plane, moved.less(self.moved))
        plane, closure = continue_geometry(self.plane, self.position, by)
        return Design(start, variables, moved, slopes, plane, closure.position, closure.first, closure.second, closure.gap)

    @cached_property
    def press(self) -> Linkage:
        """The linkage itself, drawn anew."""
        return redrawn(self.start.press, self.moved, self.position[:, 0])

    def trial(self) -> Trial:
        """What objectives and constraints see, with real arrays."""
        return Trial(
            dict(self.variables),
            self.motion,
            Positions(self.start.press.bearings, self._point),
            partial(getattr, self, "press"),
            partial(getattr, self, "_reactions"),
        )

    def trial_towards(self, place: int, step: float) -> Trial:
        """What objectives and constraints see for their gradients: complex arrays, value + i h derivative with h = STEP x ``step``.

        Args:
            place: of the variable by which is differentiated.
            step: by which that variable is scaled.
        """
        h, name = STEP * step, list(self.variables)[place]
        return Trial(
            self.variables | {name: cast("float", self.variables[name] + 1j * h)},
            self._motion_towards(place, h),
            Positions(self.start.press.bearings, partial(self._point_towards, place, h)),
            partial(getattr, self, "press"),
            partial(self._reactions_towards, place, h),
        )

    # ----------------------------------------------------------------------------------------------------------------------------- motion

    @cached_property
    def _states(self) -> States:
        return States.of(self.plane, self.position)

    @cached_property
    def _rates(self) -> Rates:
        speed = self.start.motion.crank_speed[0]
        return Rates.of(self._states, self.first * speed, self.second * speed**2)

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
        guide, offset = press.slide_guide
        offset += float(drawn[guide, 0]) + guide_shift(self.plane, shift(press, self.start.plane, self.moved), guide)
        return replace(motion, _guide=(guide, offset))

    def _motion_towards(self, place: int, h: float) -> Motion:
        motion, slope, by = self.motion, self._tangents[place], self._by[place]
        drawn = slope.position[:, :1]
        guided = motion._guide
        if guided is not None:
            guide, offset = guided
            moved = float(drawn[guide, 0]) + guide_shift(self.plane, by, guide)
            guided = guide, cast("float", offset + 1j * h * moved)
        return replace(
            motion,
            joint_position=_complex(motion.joint_position, h, (slope.position - drawn).T),
            v=_complex(motion.v, h, slope.v.T),
            a=_complex(motion.a, h, slope.a.T),
            _guide=guided,
        )

    def _point_towards(self, place: int, h: float, bearing: int) -> Array:
        return _complex(self._point(bearing), h, self._point_slope(bearing, place))

    def _point(self, bearing: int) -> Array:
        """World position (n, 3) of a bearing [m]."""
        plane, count = self.plane, len(self.plane.parents)
        row = plane.origins[bearing] if bearing < count else plane.loop_points[bearing - count]
        height = plane.heights[bearing] if bearing < count else plane.loop_heights[bearing - count]
        return np.asarray(in_space(plane, product(row[None], self._states.at)[0]) + height * plane.normal)

    def _point_slope(self, bearing: int, place: int) -> Array:
        """Derivative (n, 3) of the position of a bearing by a variable."""
        plane, by, count = self.plane, self._by[place], len(self.plane.parents)
        rows = [(of.origins[bearing] if bearing < count else of.loop_points[bearing - count])[None] for of in (plane, by)]
        return in_space(plane, (product(rows[0], self._tangents[place].basis) + product(rows[1], self._states.at))[0])

    # -------------------------------------------------------------------------------------------------------------------------- reactions

    @cached_property
    def _wrenches(self) -> Wrenches:
        under = AppliedConditions(apply(asked(self.start.loads), self.press, self.motion), None, None, gears=True)
        states = ClosedStates(self.position, self._rates.v, self._rates.a, self._states.at)
        return inverse_dynamics(self._bodies, states, under, range(len(self.start.press.bearings)))

    @cached_property
    def _bodies(self) -> Bodies:
        return build(self.plane, self.start.press.model)

    @cached_property
    def _reactions(self) -> TrialReactions:
        found, press = self._wrenches, self.press
        force, moment = (dict(enumerate(vectors)) for vectors in (found.force, found.moment))
        shaken = shaking(press, self.motion, force, moment, apply(asked(self.start.loads), press, self.motion))
        names = press.bearings
        return TrialReactions(found.torque[0], shaken[0], NamedArrays(names, found.force), NamedArrays(names, found.moment), shaken[1])

    def _reactions_towards(self, place: int, h: float) -> TrialReactions:
        real, found, names = self._reactions, self._wrenches, self.start.press.bearings
        slope = tangent(self._known, self._tangents[place], self._by[place], self._pushes(place))
        force = moment = None
        if slope.forces is not None and slope.moments is not None:
            force = NamedArrays(names, _complex(found.force, h, in_space(self.plane, slope.forces)))
            if self._bodies.flat:
                moment = NamedArrays(names, _complex(found.moment, h, np.multiply.outer(slope.moments, self.plane.normal)))
        return TrialReactions(
            _complex(real.driving_torque, h, slope.torque),
            _complex(real.shaking_force, h, in_space(self.plane, slope.shaking_force)),
            force,
            moment,
            _complex(real.shaking_moment, h, np.multiply.outer(slope.shaking_moment, self.plane.normal)) if self._bodies.flat else None,
        )

    @cached_property
    def _known(self) -> Balanced:
        press = self.start.press
        mass = np.array([inertia.mass for inertia in press.model.inertias][1:])
        sides = [(loop.joint1 - 1, loop.joint2 - 1) for loop in press.loops]
        return Balanced(self._states, self._rates, self._bodies, mass, flat(self.plane, self._wrenches.force), sides)

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
