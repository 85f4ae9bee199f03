"""States of a motion on springs: the forces there, what a run reports of them, and the energies by which it is checked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...common.quantities import Array, ComplexArray
from ...engines.planar.model import to_world
from ..driven_press import WorkOfForce
from ..trajectory import DRIVE_WORK, INTEGRALS, LOAD_WORK, LOST, MOTOR_SQUARED
from .contact import OpenPin
from .equations import Driving, ElasticEquations
from .panels import Indices
from .press.geometry import BodyState
from .press.paths import NEAREST
from .press.sprung_press import JointMotion, SprungPress
from .task import ElasticSolution


@dataclass(frozen=True, eq=False)
class ActingForces:
    """Forces on the bodies at n states.

    Attributes:
        equations: of motion, with their segments.
        times: (n,) [s].
        segments: (n,) in which the states are.
        bodies: the states.
    """

    equations: ElasticEquations
    times: Array
    segments: Indices
    bodies: BodyState

    @cached_property
    def along_paths(self) -> list[tuple[Array, Array]]:
        """Of each load, then of each contact, the force along its path (n,) [N], and the rate of the path (n,) [m/s]."""
        return self.equations.path_forces(self.times, self.segments, self.bodies)

    @property
    def _contacts(self) -> list[Array]:
        """Forces (n,) of all contacts along their paths [N]."""
        return [force for force, _ in self.along_paths[len(self.equations.driven.forces) :]]

    @cached_property
    def joints(self) -> list[tuple[JointMotion, Array]]:
        """The preloaded joints that may open, and the force (n,) of both members of each along its extension [N]."""
        sprung = self.equations.sprung
        members = self._contacts[len(sprung.open_pins) :]
        forces = (loaded + relieved for loaded, relieved in zip(members[::2], members[1::2], strict=True))
        return list(zip(sprung.joint_motions(self.bodies), forces, strict=True))

    @cached_property
    def in_bearings(self) -> Array:
        """Forces (bearings, n, 3) in world axes, parent on child, or link1 on link2 [N]."""
        sprung, friction = self.equations.sprung, self.equations.friction
        forces = sprung.bearing_forces(self.bodies)
        if friction is not None:
            for number, along in friction.along_guides(self.bodies).items():
                forces[number] += along
        for pin, force in zip(sprung.open_pins, self._contacts, strict=False):
            gap = journal_places(sprung, pin, self.bodies)
            forces[pin.bearing] = to_world(sprung.geometry.plane, -force * gap / np.maximum(np.abs(gap), NEAREST))
        for motion, force in self.joints:
            if motion.joint.bearing >= 0:
                forces[motion.joint.bearing] += force[:, None] * motion.along
        return forces

    def joint_loads(self) -> dict[str, Array]:
        """Load (n,) of each part with a preloaded joint, the mean where it yields at two bearings [N]."""
        pulls: dict[str, list[Array]] = {}
        for motion, force in self.joints:
            pulls.setdefault(motion.joint.name, []).append(motion.pull - force)
        return {name: np.mean(loads, axis=0) for name, loads in pulls.items()}

    def on_slide(self) -> Array:
        """Force (n,) of the pins on the slide along its direction [N]."""
        press = self.equations.driven.press
        slide, joints, pull = press.slide_guide.joint + 1, press.model.nv, np.zeros(len(self.times))
        for number, force in enumerate(self.in_bearings):
            if number < joints and not press.axes[number].turns:
                continue
            loop = None if number < joints else press.loops[number - joints]
            first, second = (press.model.parents[number + 1], number + 1) if loop is None else (loop.joint1, loop.joint2)
            if slide in (first, second):
                pull += force @ press.slide_direction * (1.0 if second == slide else -1.0)
        return pull

    def work_on_loads(self) -> Array:
        """Power (n,) that the loads take [W]."""
        return -sum((force * rate for force, rate in self.along_paths[: len(self.equations.driven.forces)]), np.zeros(len(self.times)))

    def lost_power(self) -> Array:
        """Power (n,) lost in dampers, friction and contacts; what the springs of a preloaded joint's members take is not lost [W]."""
        equations = self.equations
        lost = equations.sprung.lost_power(self.bodies)
        if equations.friction is not None:
            lost = lost + equations.friction.lost_power(self.bodies)
        for force, rate in self.along_paths[len(equations.driven.forces) :]:
            lost = lost - force * rate
        for motion, _ in self.joints:
            lost = lost + motion.joint.spring_force(motion.extension) * motion.rate
        return np.asarray(lost)


@dataclass(frozen=True, eq=False)
class SolutionStates:
    """States of a solution, with what a run reports of them.

    Attributes:
        solution: the motion.
        panel: (n,) panels.
        share: (n,) places on them.
        turns: (n,) periods before them.
        times: (n,) within the solution [s].
        segments: (n,) of the mesh.
        y: (n, size) unknown coordinates, without the periods before.
        v: (n, size) their rates.
        a: (n, size) their accelerations.
        bodies: with what the periods before have gained.
        whole_acceleration: (n, f) of the free coordinates.
    """

    solution: ElasticSolution
    panel: Indices
    share: Array
    turns: Array
    times: Array
    segments: Indices
    y: Array
    v: Array
    a: Array
    bodies: BodyState
    whole_acceleration: Array

    @cached_property
    def forces(self) -> ActingForces:
        """Forces on the bodies."""
        return ActingForces(self.solution.equations, self.times, self.segments, self.bodies)

    @cached_property
    def driving(self) -> Driving:
        """What turns the crank."""
        return self.solution.equations.driving(self.times, self.y, self.v, self.a, self.segments, self.bodies)

    @cached_property
    def crank(self) -> tuple[Array, Array, Array]:
        """Angle, speed and acceleration (n,) of the crank."""
        sprung = self.solution.equations.sprung
        values = self.bodies.coordinates, self.bodies.rates, sprung.all_rates(self.whole_acceleration)
        angle, speed, acceleration = map(sprung.geometry.crank, values)
        return angle, speed, acceleration

    def slide(self) -> Array:
        """Position, velocity and acceleration (n, 3) of the slide on its springs."""
        sprung = self.solution.equations.sprung
        path, rates = self.solution.equations.paths[0].over(sprung, self.bodies), sprung.free_rates(self.bodies.rates)
        bent = np.einsum("nf,nfg,ng->n", rates, path.bend, rates)
        acceleration = np.einsum("nf,nf->n", path.gradient, self.whole_acceleration) + bent
        return np.stack([path.value, path.rate, acceleration], axis=1)

    def powers(self) -> Array:
        """(4, n) rates of the `INTEGRALS`."""
        rates = np.zeros((len(INTEGRALS), len(self.times)))
        rates[DRIVE_WORK], rates[MOTOR_SQUARED] = self.driving.torque * self.driving.speed, self.driving.motor**2
        rates[LOAD_WORK], rates[LOST] = self.forces.work_on_loads(), self.forces.lost_power() + self.driving.lost
        return rates

    def energies(self) -> tuple[Array, Array]:
        """Kinetic energy (n,) with the flywheel's, and that of springs and weights (n,) [J]."""
        equations, sprung = self.solution.equations, self.solution.equations.sprung
        shaft = equations.shaft_speed(self.times, self.y, self.v)
        kinetic = sprung.geometry.kinetic_energy(self.bodies) + equations.driven.inertia * shaft**2 / 2
        return kinetic, sprung.stored_energy(self.bodies)

    def outer_less_inertia(self) -> Array:
        """Sum (n, 3) of weights and forces from outside less the inertia forces of all bodies that move [N]."""
        equations = self.solution.equations
        outside = [coordinate.force for coordinate in equations.driven.coordinates if isinstance(coordinate, WorkOfForce)]
        return np.asarray(sum(outside, equations.sprung.weight_less_inertia(self.whole_acceleration)))

    def shaking_force(self) -> Array:
        """Force (n, 3) on the frame: all weights and forces from outside less the inertia forces of all bodies but the frame [N]."""
        sprung, force = self.solution.equations.sprung, self.outer_less_inertia()
        if sprung.geometry.base is not None:
            force = force - sprung.weight_less_inertia(self.whole_acceleration, sprung.geometry.base)
        model = sprung.press.model
        return np.asarray(force + model.inertias[0].mass * model.gravity.linear)


def solution_states(solution: ElasticSolution, panel: Indices, share: Array, turns: Array | None = None) -> SolutionStates:
    """States at shares (n,) of panels (n,), some periods (n,) after the first."""
    mesh, equations = solution.panels.mesh, solution.equations
    _, _, times, segments, y, v, a = solution.panels.states_at(panel, share)
    passed = np.zeros(len(panel)) if turns is None else turns
    free, rates = equations.whole(times, y, v)
    if passed.any():
        assert solution.gain is not None
        by_crank = () if equations.crank is None else (equations.crank.speed * (mesh.knots[-1] - mesh.knots[0]),)
        free = free + passed[:, None] * np.concatenate([solution.gain[equations.body_start : y.shape[1]], by_crank])
    accelerations = a[:, equations.body_start :] if equations.crank is None else np.column_stack([a, np.zeros(len(a))])
    bodies = equations.sprung.state(free, rates)
    return SolutionStates(solution, panel, share, passed, times, segments, y, v, a, bodies, accelerations)


def journal_places(sprung: SprungPress, pin: OpenPin, state: BodyState) -> ComplexArray:
    """Centre (n,) of the second side of a pin from that of its first side, in the axes of the plane [m]."""
    first, second = (sprung.geometry.point(state, body, arm).place @ (1.0, 1j) for body, arm in zip(pin.bodies, pin.arms, strict=True))
    return np.asarray(second - first)
