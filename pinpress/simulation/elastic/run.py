"""The result of an elastic simulation: a run whose links stand beside the rigid press's.

Every state has the rigid press at the same crank angle as its `Motion`, the displacement of all links from it, and the true forces of the
bearings. Slide position, velocity and acceleration are those of the slide on its springs.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from ...common.frozen import FrozenMapping, NamedArrays, read_only
from ...common.quantities import Array, ComplexArray
from ...engines.planar.model import to_world
from ...kinematics.cycle import motion_through_change_points
from ...kinematics.motion import Motion
from ..driven_press import WorkOfForce
from ..failures import failure
from ..law_trials import confirm_torques
from ..run import Run, Stats, allowed_error, energy_error
from ..solvers import SimulationProblem
from ..trajectory import DRIVE_WORK, INTEGRALS, LOAD_WORK, LOST, MOTOR_SQUARED, Sample, Trajectory
from .contact import OpenPin
from .description import Elastic
from .panels import Indices
from .press.paths import NEAREST
from .press.sprung_press import BodyState, SprungPress
from .task import ElasticSolution

FINE = 24  # parts of a panel at whose ends extremes are looked for, and of the two parts about one of them


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ElasticRun(Run):
    """A run of a press on its springs; what it has more than a `Run`. All arrays are read-only.

    `inverse_dynamics` of it gives the reactions of the rigid press at the same crank angles, under loads at the heights of its rigid slide;
    the forces of the springs are ``bearing_force``.

    Attributes:
        displacement: (n, links, 3) of each moving link beside the rigid press at the same crank angle: of its centre of mass along the two
            axes of the plane [m], and its turn [rad]. Of a linkage in space (n, links, 6): of its centre of mass in world axes [m], and
            the vector of its turn, along its axis and as long as its angle, in world axes [rad].
        bearing_force: (n, 3) by the names of joints and loops: action of parent on child, or of link1 on link2, in the plane [N].
        joint_load: (n,) by the names of the parts with preloaded joints, "frame" that of the columns: the load on both members, positive
            where it pulls [N]; `PreloadedJoint.forces` shares it among them. Of a rod it is the mean of the pulls at its pins. A guide in
            space has two, "slide_guide x" and "slide_guide y": each across it, named by the nearest axis of the link that carries it.
        shaking_force: (n, 3) sum of the forces of linkage, crown and process loads on the frame [N].
        floor_force: (n, 3) force of the mounts on the floor [N]; None where the frame does not stand on mounts.
        frame_motion: (n, 3) displacement of the frame's centre of mass on its mounts along the axes of the plane, from its place under the
            static load [m], and its turn [rad]; None where it does not.
        decay_per_stroke: factor by which a disturbance of the links shrinks in a period; below 1 the stroke is stable. None of a run that
            is no steady state.
        elastic: what yields.
    """

    displacement: Array
    bearing_force: NamedArrays[np.float64]
    joint_load: Mapping[str, Array]
    shaking_force: Array
    floor_force: Array | None
    frame_motion: Array | None
    decay_per_stroke: float | None
    elastic: Elastic
    _on_springs: Array
    _extremes: Extremes

    @property
    def title(self) -> str:
        return f"ElasticRun of {self.linkage}: {len(self.crank_angle)} states, {self.time[-1]:.6g} s, slide down to {self.deepest:.6g} m"

    @cached_property
    def slide_position(self) -> Array:
        return read_only(self._on_springs[:, 0].copy())

    @property
    def rigid_slide_position(self) -> Array:
        """(n,) slide position of the rigid press at the same crank angles [m]."""
        guide, offset, sign = self._slide()
        return read_only(sign * self.joint_position[:, guide] + offset)

    @property
    def slide_velocity(self) -> Array:
        return read_only(self._on_springs[:, 1].copy())

    @property
    def slide_acceleration(self) -> Array:
        return read_only(self._on_springs[:, 2].copy())

    @property
    def jumps(self) -> None:
        """Between its states the rigid press at the same crank angles is not known."""

    @property
    def deepest(self) -> float:
        """Lowest position of the slide, between the states too [m]."""
        return self._extremes.deepest

    @property
    def deepest_angle(self) -> float:
        """Crank angle at which the slide is deepest [rad]."""
        return self._extremes.deepest_angle

    @property
    def peaks(self) -> Mapping[str, float]:
        """Largest force of each bearing, between the states too [N]."""
        return self._extremes.peaks

    @property
    def reverse_force(self) -> float:
        """Largest force with which the linkage pulls the slide in its direction, upwards: by inertia, and after break-through [N]."""
        return self._extremes.reverse_force

    @property
    def events(self) -> tuple[tuple[float, float, float], ...]:
        """Time [s], crank angle [rad] and slide position [m] of each event: a load begins, changes its law or ends; a member of a preloaded
        joint lifts off or touches; clutch or brake is switched, begins to slip or to hold; the drive's torque jumps."""
        return self._extremes.events

    def columns(self) -> dict[str, Array]:
        """The columns of a run, then the size of each bearing's force, the loads of preloaded joints, and the force on the frame."""
        columns = super().columns()
        columns |= {f"force_{name} [N]": np.linalg.norm(force, axis=1) for name, force in self.bearing_force.items()}
        columns |= {f"joint_load_{name} [N]": load for name, load in self.joint_load.items()}
        columns |= {f"shaking_force_{axis} [N]": force for axis, force in zip("xyz", self.shaking_force.T, strict=True)}
        if self.floor_force is not None and self.frame_motion is not None:
            columns |= {f"floor_force_{axis} [N]": force for axis, force in zip("xyz", self.floor_force.T, strict=True)}
            columns |= dict(zip(("frame_along [m]", "frame_up [m]", "frame_turn [rad]"), self.frame_motion.T, strict=True))
        return columns


@dataclass(frozen=True)
class Extremes:
    """Largest values over a run, between its states too; attributes as the properties of `ElasticRun`."""

    deepest: float
    deepest_angle: float
    reverse_force: float
    peaks: Mapping[str, float]
    events: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True, eq=False, repr=False)
class ElasticSegment:
    """A motion on springs as a segment of a trajectory; see `trajectory.Segment`.

    Attributes:
        solution: the motion.
        first: time of the solution at which the segment begins [s]; a periodic solution goes on at its start.
        end: time of the segment's end [s].
        gain: (2 f,) what coordinates and rates gain in a period.
        angle: of the crank at the segment's start, which may lie whole periods from that of the solution [rad].
    """

    solution: ElasticSolution
    first: float
    end: float
    gain: Array
    angle: float

    start = 0.0
    standing = None
    solvers = ("elastic",)

    @property
    def steps(self) -> int:
        return len(self.solution.panels.mesh.start)

    @property
    def evaluations(self) -> int:
        return self.solution.evaluations

    @property
    def borders(self) -> Array:
        knots, own = self.solution.panels.mesh.knots, self.solution.panels.mesh.borders - self.first
        period = float(knots[-1] - knots[0])
        found = (own + period * np.arange(np.ceil(self.end / period) + 1)[:, None]).ravel()
        return np.unique(np.concatenate([found[(found > 0.0) & (found < self.end)], [0.0, self.end]]))

    jumps = borders

    @property
    def travelled(self) -> float:
        return abs(float(np.diff(self.crank(self.states(np.array([0.0, self.end])))[0])[0]))

    @property
    def fastest(self) -> float:
        return float(np.abs(self.crank(self.states(self.borders))[1]).max())

    def states(self, times: Array) -> SolutionStates:
        """States at times (n,) of the segment."""
        mesh = self.solution.panels.mesh
        begin, until = mesh.knots[0], mesh.knots[-1]
        own = self.first + times
        turns = np.floor((own - begin) / (until - begin) - 1e-12).clip(0) if self.solution.periodic else np.zeros(len(times))
        own = own - turns * (until - begin)
        panel = np.clip(np.searchsorted(mesh.start, own, side="right") - 1, 0, len(mesh.start) - 1)
        share = (own - mesh.start[panel]) / mesh.length[panel]
        return solution_states(self.solution, panel, share, turns, self.gain)

    def crank(self, at: SolutionStates) -> tuple[Array, Array]:
        """Angle and speed (n,) of the crank."""
        geometry = self.solution.equations.sprung.geometry
        return geometry.crank(at.bodies.coordinates), geometry.crank(at.bodies.rates)

    def at(self, times: Array, complete: bool = True) -> Sample:
        return self.sample(self.states(times))

    def sample(self, at: SolutionStates) -> Sample:
        """What a trajectory gives at states."""
        (angle, speed), equations = self.crank(at), self.solution.equations
        acceleration = equations.sprung.geometry.crank(equations.sprung.all_rates(at.whole_acceleration))
        driving = equations.driving(at.times, at.y, at.v, at.a, at.segments, at.bodies)
        angle = angle + self._whole_periods
        states = equations.drive_states(at.v)
        driven = driving.torque, driving.motor, driving.speed, states
        return Sample(angle[None], speed[None], acceleration[None], *driven, self.integrals(at))

    @cached_property
    def _whole_periods(self) -> float:
        """Angle (of whole periods) by which the crank angles of the solution differ from those of the segment [rad]."""
        own = float(self.crank(self.states(np.zeros(1)))[0][0])
        return float(np.round((self.angle - own) / (2 * np.pi)) * 2 * np.pi)

    @cached_property
    def _powers(self) -> tuple[Array, Array]:
        """Powers (p, s, 4) of the `INTEGRALS` at all points of the panels, and their integrals (p + 1, 4) from the solution's start."""
        panels = self.solution.panels
        count, stages = panels.accelerations.shape[:2]
        at = solution_states(self.solution, np.repeat(np.arange(count), stages), np.tile(panels.rule.points, count), None, self.gain)
        powers = _powers(self.solution, at).T.reshape(count, stages, len(INTEGRALS))
        gains = panels.mesh.length[:, None] * np.einsum("s,psk->pk", panels.rule.integrate[-1], powers)
        return powers, np.concatenate([np.zeros((1, len(INTEGRALS))), np.cumsum(gains, axis=0)])

    def integrals(self, at: SolutionStates) -> Array:
        """(4, n) the `INTEGRALS` from the segment's start."""
        return np.asarray((self._integrated(at) - self._integrated(self.states(np.zeros(1)))).T)

    def _integrated(self, at: SolutionStates) -> Array:
        powers, ends = self._powers
        weights = self.solution.panels.weights(at.share)
        inside = self.solution.panels.mesh.length[at.panel][:, None] * np.einsum("ns,nsk->nk", weights, powers[at.panel])
        return np.asarray(ends[at.panel] + inside + at.turns[:, None] * ends[-1])


@dataclass(frozen=True, eq=False)
class SolutionStates:
    """States of a solution.

    Attributes:
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


def solution_states(solution: ElasticSolution, panel: Indices, share: Array, turns: Array | None, gain: Array) -> SolutionStates:
    """States at shares (n,) of panels (n,), some periods (n,) after the first."""
    mesh, equations = solution.panels.mesh, solution.equations
    _, _, times, segments, y, v, a = solution.panels.states_at(panel, share)
    passed = np.zeros(len(panel)) if turns is None else turns
    free, rates = equations.whole(times, y, v)
    if turns is not None and turns.any():
        period = mesh.knots[-1] - mesh.knots[0]
        held = () if equations.crank is None else (equations.crank.speed * period,)
        free = free + passed[:, None] * np.concatenate([gain[equations.own : y.shape[1]], held])
    accelerations = a[:, equations.own :] if equations.crank is None else np.column_stack([a, np.zeros(len(a))])
    return SolutionStates(panel, share, passed, times, segments, y, v, a, equations.sprung.state(free, rates), accelerations)


def _powers(solution: ElasticSolution, at: SolutionStates) -> Array:
    """(4, n) rates of the `INTEGRALS`."""
    equations, sprung = solution.equations, solution.equations.sprung
    driven, nothing = equations.driven, np.zeros(len(at.times))
    driving = equations.driving(at.times, at.y, at.v, at.a, at.segments, at.bodies)
    found = np.zeros((len(INTEGRALS), len(at.times)))
    found[DRIVE_WORK], found[MOTOR_SQUARED] = driving.torque * driving.speed, driving.motor**2
    found[LOST] = sprung.lost_power(at.bodies) + driving.lost
    if equations.friction is not None:
        found[LOST] += equations.friction.lost_power(at.bodies)
    powers = [force * rate for force, rate in equations.load_forces(at.times, at.segments, at.bodies)]
    loads = len(driven.forces)
    found[LOAD_WORK], found[LOST] = -sum(powers[:loads], nothing), found[LOST] - sum(powers[loads:], nothing)
    for each in sprung.joint_motions(at.bodies):  # what the springs of their members take is not lost
        found[LOST] += each.joint.spring_force(each.extension) * each.rate
    return found


def segment_of(run: ElasticRun) -> ElasticSegment:
    """The motion on springs of a run."""
    (segment,) = run.trajectory.segments
    assert isinstance(segment, ElasticSegment)
    return segment


def elastic_run(problem: SimulationProblem, segment: ElasticSegment, points: int, began: float) -> ElasticRun:
    """The run of a motion on springs.

    Args:
        problem: what was simulated.
        segment: its solution.
        points: number of states.
        began: time of the clock at which the call began [s].

    Raises:
        SimulationError: the energy does not balance.
    """
    press, solution = problem.driven.press, segment.solution
    sprung, trajectory = solution.equations.sprung, Trajectory([segment])
    times = np.linspace(0.0, segment.end, points)
    at = segment.states(times)
    sample = segment.sample(at)
    motion = motion_through_change_points(press, sample.position[0], sample.speed[0], sample.acceleration[0], times)
    confirm_torques(problem.driven.drive, times, sample.position[0], sample.drive_speed, sample.drive_torque)
    forces = bearing_forces(solution, at.times, at.segments, at.bodies)
    kept = {field.name: getattr(motion, field.name) for field in fields(Motion) if field.init}
    integrals = dict(zip(INTEGRALS, sample.integrals, strict=True))
    stats = Stats(
        method="elastic",
        solvers=trajectory.solvers,
        steps=trajectory.steps,
        evaluations=trajectory.evaluations,
        wall_time=clock.perf_counter() - began,
        closure_error=float(motion.closure_error.max()),
        energy_error=_audit(segment, problem.tolerance),
    )
    return ElasticRun(
        **kept,
        stats=stats,
        drive_torque=read_only(sample.drive_torque),
        drive_speed=read_only(sample.drive_speed),
        **integrals,
        problem=problem,
        trajectory=trajectory,
        displacement=read_only(sprung.geometry.displacement(at.bodies.coordinates, motion)),
        bearing_force=NamedArrays(press.bearings, forces),
        joint_load=FrozenMapping(_joint_loads(solution, at.times, at.segments, at.bodies)),
        shaking_force=read_only(_shaking_force(solution, at.whole_acceleration)),
        floor_force=_floor_force(solution, at.whole_acceleration),
        frame_motion=_frame_motion(solution, at.bodies.coordinates),
        decay_per_stroke=solution.decay if solution.periodic else None,
        elastic=sprung.elastic,
        _on_springs=_slide(solution, at),
        _extremes=_extremes(segment),
    )


def bearing_forces(solution: ElasticSolution, times: Array, segments: Indices, state: BodyState) -> Array:
    """Forces (bearings, n, 3) in world axes, parent on child, or link1 on link2 [N]."""
    sprung = solution.equations.sprung
    found, friction = sprung.bearing_forces(state), solution.equations.friction
    if friction is not None:
        for number, along in friction.along_guides(state).items():
            found[number] += along
    if not sprung.open_pins and not sprung.open_joints:
        return found
    contacts = _contact_forces(solution, times, segments, state)
    for pin, force in zip(sprung.open_pins, contacts, strict=False):
        gap = journal_places(sprung, pin, state)
        found[pin.bearing] = to_world(sprung.geometry.plane, -force * gap / np.maximum(np.abs(gap), NEAREST))
    for each, force in zip(sprung.joint_motions(state), _joint_forces(sprung, contacts), strict=True):
        if each.joint.bearing >= 0:
            found[each.joint.bearing] += force[:, None] * each.along
    return found


def _contact_forces(solution: ElasticSolution, times: Array, segments: Indices, state: BodyState) -> list[Array]:
    """Forces (n,) of all contacts along their paths [N]."""
    found = solution.equations.load_forces(times, segments, state)
    return [force for force, _ in found[len(solution.equations.driven.forces) :]]


def _joint_forces(sprung: SprungPress, contacts: Sequence[Array]) -> list[Array]:
    """Of each preloaded joint the force (n,) of both members along its extension, of the forces (n,) of all contacts [N]."""
    members = contacts[len(sprung.open_pins) :]
    return [loaded + relieved for loaded, relieved in zip(members[::2], members[1::2], strict=True)]


def _joint_loads(solution: ElasticSolution, times: Array, segments: Indices, state: BodyState) -> dict[str, Array]:
    """Load (n,) of each part with a preloaded joint, the mean where it yields at two bearings [N]."""
    sprung, found = solution.equations.sprung, dict[str, list[Array]]()
    if not sprung.open_joints:
        return {}
    contacts = _contact_forces(solution, times, segments, state)
    for each, force in zip(sprung.joint_motions(state), _joint_forces(sprung, contacts), strict=True):
        found.setdefault(each.joint.name, []).append(each.pull - force)
    return {name: np.mean(pulls, axis=0) for name, pulls in found.items()}


def journal_places(sprung: SprungPress, pin: OpenPin, state: BodyState) -> ComplexArray:
    """Centre (n,) of the second side of a pin from that of its first side, in the axes of the plane [m]."""
    one, two = (sprung.geometry.point(state, body, arm).place @ (1.0, 1j) for body, arm in zip(pin.bodies, pin.arms, strict=True))
    return np.asarray(two - one)


def _shaking_force(solution: ElasticSolution, accelerations: Array) -> Array:
    """Force (n, 3) on the frame: all weights and forces from outside less the inertia forces of all bodies [N]."""
    model, sprung, found = solution.equations.driven.press.model, solution.equations.sprung, _force_of_all(solution, accelerations)
    if sprung.geometry.base is not None:
        found = found - sprung.weight_less_inertia(accelerations, sprung.geometry.base)
    return np.asarray(found + model.inertias[0].mass * model.gravity.linear)


def _floor_force(solution: ElasticSolution, accelerations: Array) -> Array | None:
    """Force (n, 3) of the mounts on the floor [N]; None where the frame is fixed."""
    if solution.equations.sprung.geometry.base is None:
        return None
    return read_only(_force_of_all(solution, accelerations))


def _force_of_all(solution: ElasticSolution, accelerations: Array) -> Array:
    """Sum (n, 3) of weights and forces from outside less the inertia forces of all bodies that move [N]."""
    outside = [each.force for each in solution.equations.driven.coordinates if isinstance(each, WorkOfForce)]
    return np.asarray(sum(outside, solution.equations.sprung.weight_less_inertia(accelerations)))


def _frame_motion(solution: ElasticSolution, coordinates: Array) -> Array | None:
    """Displacement of the frame's centre of mass along the axes of the plane, and its turn (n, 3); None where the frame is fixed."""
    base = solution.equations.sprung.geometry.base
    return None if base is None else read_only(coordinates[:, 3 * base : 3 * base + 3].copy())


def _slide(solution: ElasticSolution, at: SolutionStates) -> Array:
    """Position, velocity and acceleration (n, 3) of the slide on its springs."""
    sprung = solution.equations.sprung
    path, rates = solution.equations.paths[0].over(sprung, at.bodies), sprung.free_rates(at.bodies.rates)
    bent = np.einsum("nf,nfg,ng->n", rates, path.bend, rates)
    acceleration = np.einsum("nf,nf->n", path.gradient, at.whole_acceleration) + bent
    return read_only(np.stack([path.value, path.rate, acceleration], axis=1))


def _audit(segment: ElasticSegment, tolerance: float) -> float:
    """Largest energy missing at the borders of panels, as a share of the largest kinetic energy or work.

    Raises:
        SimulationError: the energy does not balance.
    """
    solution, panels = segment.solution, segment.solution.panels
    equations, sprung = solution.equations, solution.equations.sprung
    count = len(panels.mesh.start)
    at = solution_states(solution, np.append(np.arange(count), count - 1), np.append(np.zeros(count), 1.0), None, segment.gain)
    shaft = equations.shaft_speed(at.times, at.y, at.v)
    kinetic = sprung.geometry.kinetic_energy(at.bodies) + equations.driven.inertia * shaft**2 / 2
    _, works = segment._powers
    error = energy_error(kinetic, sprung.stored_energy(at.bodies), *works[:, [DRIVE_WORK, LOAD_WORK, LOST]].T)
    largest = float(error.max())
    if not largest <= allowed_error(tolerance):
        worst = int(error.argmax())
        raise failure("unbalanced", float(at.times[worst]), float(segment.crank(at)[0][worst]))
    return largest


def _extremes(segment: ElasticSegment) -> Extremes:
    """Largest values over all panels of the segment."""
    solution, names = segment.solution, segment.solution.equations.driven.press.bearings

    def all_values(panel: Indices, share: Array) -> Array:
        """Slide position, pull on the slide, and size of each bearing's force, (2 + bearings, n)."""
        at = solution_states(solution, panel, share, None, segment.gain)
        forces = bearing_forces(solution, at.times, at.segments, at.bodies)
        return np.stack([-_slide(solution, at)[:, 0], _pull_on_slide(solution, forces), *np.linalg.norm(forces, axis=2)])

    found = _largest(all_values, len(solution.panels.mesh.start))
    deep = solution_states(solution, np.array([found[0][1]]), np.array([found[0][2]]), None, segment.gain)
    return Extremes(
        deepest=-found[0][0],
        deepest_angle=float(segment.crank(deep)[0][0]),
        reverse_force=max(0.0, found[1][0]),
        peaks=FrozenMapping({name: value for name, (value, _, _) in zip(names, found[2:], strict=True)}),
        events=_events(segment),
    )


def _largest(values: Callable[[Indices, Array], Array], panels: int) -> list[tuple[float, int, float]]:
    """Largest value of each of k functions on panels, the panel, and the share of it where it is.

    Args:
        values: of panels (n,) and shares of them (n,) to values (k, n).
        panels: their number.
    """
    places = np.linspace(0.0, 1.0, FINE + 1)
    coarse = values(np.repeat(np.arange(panels), FINE + 1), np.tile(places, panels))
    candidates = np.argsort(coarse, axis=1)[:, -3:]  # a peak at a border is on one of two panels, beside a second one
    panel, place = candidates // (FINE + 1), places[candidates % (FINE + 1)]
    low, high = np.maximum(place - 1 / FINE, 0.0), np.minimum(place + 1 / FINE, 1.0)
    shares = low[..., None] + (high - low)[..., None] * places
    fine = values(np.repeat(panel, FINE + 1), shares.ravel()).reshape(len(coarse), *shares.shape)
    found = []
    for row in range(len(coarse)):
        own = fine[row, row]
        where, best = np.unravel_index(int(own.argmax()), own.shape)
        value, beside = float(own[where, best]), 0.0
        if 0 < best < FINE:
            before, after = own[where, best - 1], own[where, best + 1]
            bend = 2 * value - before - after
            beside = 0.5 * (after - before) / bend if bend > 0 else 0.0
            value += 0.25 * beside * float(after - before)
        step = shares[row, where, 1] - shares[row, where, 0]
        found.append((value, int(panel[row, where]), float(shares[row, where, best] + beside * step)))
    return found


def _events(segment: ElasticSegment) -> tuple[tuple[float, float, float], ...]:
    """Time, crank angle and slide position of each event."""
    solution, mesh, found = segment.solution, segment.solution.panels.mesh, []
    for knot in solution.equations.events or {}:
        if knot == len(solution.equations.segments):  # the end of a period
            continue
        there = solution_states(solution, np.array([int(np.searchsorted(mesh.segment, knot))]), np.zeros(1), None, segment.gain)
        time = float(there.times[0]) - segment.first
        if solution.periodic:
            time %= float(mesh.knots[-1] - mesh.knots[0])
        found.append((time, float(segment.at(np.array([time])).position[0, 0]), float(_slide(solution, there)[0, 0])))
    return tuple(sorted(found))


def _pull_on_slide(solution: ElasticSolution, forces: Array) -> Array:
    """Force (n,) of the pins on the slide along its direction [N], of the forces of all bearings (bearings, n, 3)."""
    press = solution.equations.driven.press
    slide, joints, found = press.slide_guide.joint + 1, press.model.nv, np.zeros(forces.shape[1])
    for number, force in enumerate(forces):
        if number < joints and not press.axes[number].turns:
            continue
        loop = None if number < joints else press.loops[number - joints]
        first, second = (press.model.parents[number + 1], number + 1) if loop is None else (loop.joint1, loop.joint2)
        if slide in (first, second):
            found += force @ press.slide_direction * (1.0 if second == slide else -1.0)
    return found
