"""The result of an elastic simulation: a run whose links stand beside the rigid press's.

Every state has the rigid press at the same crank angle as its `Motion`, the displacement of all links from it, and the true forces of the
bearings. Slide position, velocity and acceleration are those of the slide on its springs.
"""

from __future__ import annotations

import time as clock
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from ...common.frozen import read_only
from ...common.quantities import Array, ComplexArray
from ...common.results import NamedArrays
from ...engines.planar.model import to_complex, to_world
from ...kinematics.motion import Motion, motion_through_change_points
from ..driven_press import WorkOfForce
from ..run import Run, Stats
from ..solvers import SimulationProblem
from ..trajectory import DRIVE_WORK, INTEGRALS, LOAD_WORK, LOST, MOTOR_SQUARED, Sample, Trajectory
from .assembly import DrawnPress, coordinates_of
from .panels import Indices
from .solution import ElasticSolution

FINE = 24  # places on a panel at which extremes are looked for


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ElasticRun(Run):
    """A run of a press on its springs; what it has more than a `Run`. All arrays are read-only.

    Attributes:
        displacement: (n, links, 3) of each moving link beside the rigid press at the same crank angle: of its centre of mass along the two
            axes of the plane [m], and its turn [rad].
        bearing_force: (n, 3) by the names of joints and loops: action of parent on child, or of link1 on link2, in the plane [N].
        shaking_force: (n, 3) sum of the forces of linkage, crown and process loads on the frame [N].
        decay_per_stroke: factor by which a disturbance of the links shrinks in a period; below 1 the stroke is stable. None of a run that
            is no steady state.
        elastic: what yields.
    """

    displacement: Array
    bearing_force: NamedArrays[np.float64]
    shaking_force: Array
    decay_per_stroke: float | None
    _slide: Array
    _extremes: Extremes

    @property
    def title(self) -> str:
        return f"ElasticRun of {self.linkage}: {len(self.crank_angle)} states, {self.time[-1]:.6g} s, slide down to {self.deepest:.6g} m"

    @cached_property
    def slide_position(self) -> Array:  # type: ignore[override]
        return read_only(self._slide[:, 0].copy())

    @property
    def slide_velocity(self) -> Array:
        return read_only(self._slide[:, 1].copy())

    @property
    def slide_acceleration(self) -> Array:
        return read_only(self._slide[:, 2].copy())

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
        """Time [s], crank angle [rad] and slide position [m] of each event at which a load begins, changes its law or ends."""
        return self._extremes.events

    def columns(self) -> dict[str, Array]:
        """The columns of a run, then the size of each bearing's force, and the force on the frame."""
        columns = super().columns()
        columns |= {f"force_{name} [N]": np.linalg.norm(force, axis=1) for name, force in self.bearing_force.items()}
        return columns | {f"shaking_force_{axis} [N]": force for axis, force in zip("xyz", self.shaking_force.T, strict=True)}


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
    """

    solution: ElasticSolution
    first: float
    end: float
    gain: Array

    start = 0.0
    standing = None
    solvers = ("elastic",)

    @property
    def steps(self) -> int:
        return len(self.solution.panels.mesh.start)

    @property
    def evaluations(self) -> int:
        return self.solution.panels.steps * self.steps * len(self.solution.panels.rule.points)

    @property
    def travelled(self) -> float:
        ends = self.states(np.array([0.0, self.end]))
        return abs(float(np.diff(self.crank(*ends.whole)[0])[0]))

    def states(self, times: Array) -> SolutionStates:
        """States at times (n,) of the segment."""
        panels, mesh = self.solution.panels, self.solution.panels.mesh
        begin, until = mesh.knots[0], mesh.knots[-1]
        own = self.first + times
        turns = np.floor((own - begin) / (until - begin) - 1e-12).clip(0) if self.solution.periodic else np.zeros(len(times))
        own = own - turns * (until - begin)
        panel = np.clip(np.searchsorted(mesh.start, own, side="right") - 1, 0, len(mesh.start) - 1)
        share = (own - mesh.start[panel]) / mesh.length[panel]
        return solution_states(self.solution, panel, share, turns, self.gain)

    def crank(self, free: Array, rates: Array) -> tuple[Array, Array]:
        """Angle and speed (n,) of the crank, of free coordinates and rates (n, f)."""
        return crank_of(self.solution, free, rates)

    def at(self, times: Array, complete: bool = True) -> Sample:
        at = self.states(times)
        angle, speed = self.crank(*at.whole)
        _, acceleration = self.crank(at.whole[0], at.whole_acceleration)
        drive = self.solution.equations.driven.drive
        rotor, spin = at.whole[0][:, -1], at.whole[1][:, -1]
        torque = self.solution.equations.crank_torque(at.times, at.y, at.v, at.a, at.segments)
        motor = torque if drive is None else np.broadcast_to(drive.motor_torque(spin, rotor, times), torque.shape)
        return Sample(angle[None], speed[None], acceleration[None], torque, motor, spin, self.integrals(at))

    @cached_property
    def _powers(self) -> tuple[Array, Array]:
        """Powers (p, s, 4) of the `INTEGRALS` at all points of the panels, and their integrals (p + 1, 4) from the solution's start."""
        panels = self.solution.panels
        count, stages = panels.accelerations.shape[:2]
        at = solution_states(self.solution, np.repeat(np.arange(count), stages), np.tile(panels.rule.points, count), None, self.gain)
        powers = np.stack(list(_powers(self.solution, at).T), axis=1).reshape(count, stages, len(INTEGRALS))
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
        whole: free coordinates and rates (n, f), with what the periods before have gained.
        whole_acceleration: (n, f).
    """

    panel: Indices
    share: Array
    turns: Array
    times: Array
    segments: Indices
    y: Array
    v: Array
    a: Array
    whole: tuple[Array, Array]
    whole_acceleration: Array


def solution_states(solution: ElasticSolution, panel: Indices, share: Array, turns: Array | None, gain: Array) -> SolutionStates:
    """States at shares (n,) of panels (n,), some periods (n,) after the first."""
    mesh, equations = solution.panels.mesh, solution.equations
    y, v, a = solution.panels.within(panel, share)
    times = mesh.start[panel] + share * mesh.length[panel]
    passed = np.zeros(len(panel)) if turns is None else turns
    free, rates = equations.whole(times, y, v)
    if turns is not None and turns.any():
        period = mesh.knots[-1] - mesh.knots[0]
        held = () if equations.crank is None else (equations.crank.speed * period,)
        free = free + passed[:, None] * np.concatenate([gain[: y.shape[1]], held])
    accelerations = a if equations.crank is None else np.column_stack([a, np.zeros(len(a))])
    return SolutionStates(panel, share, passed, times, mesh.segment[panel], y, v, a, (free, rates), accelerations)


def crank_of(solution: ElasticSolution, free: Array, rates: Array) -> tuple[Array, Array]:
    """Angle and speed (n,) of the crank's joint, of free coordinates and rates (n, f)."""
    sprung = solution.equations.sprung
    plane = DrawnPress(sprung.press).plane
    driver, parent, sense = plane.driver, plane.parents[plane.driver], float(plane.sense[plane.driver])
    coordinates, all_rates = sprung.all_coordinates(free), rates @ sprung.carry.T
    found = []
    for values in (coordinates, all_rates):
        base = values[:, 3 * parent + 2] if parent >= 0 else 0.0
        found.append(sense * (values[:, 3 * driver + 2] - base))
    return found[0], found[1]


def _powers(solution: ElasticSolution, at: SolutionStates) -> Array:
    """(4, n) rates of the `INTEGRALS`."""
    equations, sprung = solution.equations, solution.equations.sprung
    driven, (free, rates) = equations.driven, at.whole
    coordinates, all_rates = sprung.all_coordinates(free), rates @ sprung.carry.T
    torque = equations.crank_torque(at.times, at.y, at.v, at.a, at.segments)
    motor = torque if driven.drive is None else np.broadcast_to(driven.drive.motor_torque(rates[:, -1], free[:, -1], at.times), torque.shape)
    found = np.zeros((len(INTEGRALS), len(torque)))
    found[DRIVE_WORK], found[MOTOR_SQUARED] = torque * rates[:, -1], motor**2
    geometry = sprung.geometry(coordinates, all_rates)
    found[LOST] = (geometry.opening**2) @ sprung.lines.damping + sprung.turning_rates(all_rates) ** 2 @ sprung.turns.damping
    found[LOAD_WORK] = -sum((force * rate for force, rate in equations.load_forces(at.segments, coordinates, all_rates)), np.zeros(len(torque)))
    return found


def elastic_run(problem: SimulationProblem, segment: ElasticSegment, elastic: object, points: int, began: float) -> ElasticRun:
    """The run of a motion on springs.

    Args:
        problem: what was simulated.
        segment: its solution.
        elastic: what yields.
        points: number of states.
        began: time of the clock at which the call began [s].
    """
    press, solution = problem.driven.press, segment.solution
    sprung, trajectory = solution.equations.sprung, Trajectory([segment])
    times = np.linspace(0.0, segment.end, points)
    at, sample = segment.states(times), segment.at(times)
    motion = motion_through_change_points(press, sample.position[0], sample.speed[0], sample.acceleration[0], times)
    coordinates, rates = sprung.all_coordinates(at.whole[0]), at.whole[1] @ sprung.carry.T
    rigid, _, _ = coordinates_of(sprung, motion)
    moved = (coordinates - rigid).reshape(points, -1, 3)[:, : press.model.nv]
    forces = to_world(DrawnPress(press).plane, _bearing_forces(solution, coordinates, rates))
    kept = {field.name: getattr(motion, field.name) for field in fields(Motion) if field.init}
    integrals = dict(zip(INTEGRALS, sample.integrals, strict=True))
    stats = Stats(
        method="elastic",
        solvers=trajectory.solvers,
        steps=trajectory.steps,
        evaluations=trajectory.evaluations,
        wall_time=clock.perf_counter() - began,
        closure_error=float(motion.closure_error.max()),
        energy_error=_energy_error(segment),
    )
    return ElasticRun(
        **kept,
        stats=stats,
        drive_torque=read_only(sample.drive_torque),
        drive_speed=read_only(sample.drive_speed),
        **integrals,
        problem=problem,
        trajectory=trajectory,
        displacement=read_only(moved),
        bearing_force=NamedArrays(press.bearings, forces),
        shaking_force=read_only(_shaking_force(solution, at.whole_acceleration)),
        decay_per_stroke=solution.decay if solution.periodic else None,
        _slide=_slide(solution, at),
        _extremes=_extremes(segment),
    )


def _bearing_forces(solution: ElasticSolution, coordinates: Array, rates: Array) -> ComplexArray:
    """Forces (bearings, n) in the plane's axes, parent on child, or link1 on link2 [N]."""
    sprung = solution.equations.sprung
    lines, geometry = sprung.lines, sprung.geometry(coordinates, rates)
    pull = -(lines.stiffness * geometry.extension + lines.damping * geometry.opening) * lines.sign
    forces = pull * geometry.against.conj()
    found = np.zeros((len(sprung.press.bearings), len(coordinates)), dtype=complex)
    for spring, number in enumerate(lines.bearing):
        if number >= 0:
            found[number] += forces[:, spring]
    return found


def _shaking_force(solution: ElasticSolution, accelerations: Array) -> Array:
    """Force (n, 3) on the frame: all weights and forces from outside less the inertia forces of all bodies [N]."""
    sprung, driven = solution.equations.sprung, solution.equations.driven
    model = driven.press.model
    left = sprung.weight - (accelerations @ sprung.carry.T) * sprung.inertia
    found = to_world(DrawnPress(driven.press).plane, left[:, ::3].sum(axis=1) + 1j * left[:, 1::3].sum(axis=1))
    outside = [coordinate.force for coordinate in driven.coordinates if isinstance(coordinate, WorkOfForce)]
    return np.asarray(found + sum(outside, model.inertias[0].mass * model.gravity.linear))


def _slide(solution: ElasticSolution, at: SolutionStates) -> Array:
    """Position, velocity and acceleration (n, 3) of the slide on its springs."""
    sprung = solution.equations.sprung
    free, rates = at.whole
    coordinates, all_rates = sprung.all_coordinates(free), rates @ sprung.carry.T
    path = solution.equations.paths[0].over(sprung, coordinates, all_rates)
    bent = np.einsum("nf,nfg,ng->n", rates, path.bend, rates)
    acceleration = np.einsum("nf,nf->n", path.gradient, at.whole_acceleration) + bent
    return read_only(np.stack([path.value, path.rate, acceleration], axis=1))


def _energy_error(segment: ElasticSegment) -> float:
    """Largest energy missing at the borders of panels, as a share of the largest kinetic energy or work."""
    solution, panels = segment.solution, segment.solution.panels
    equations, sprung = solution.equations, solution.equations.sprung
    count = len(panels.mesh.start)
    at = solution_states(solution, np.append(np.arange(count), count - 1), np.append(np.zeros(count), 1.0), None, segment.gain)
    free, rates = at.whole
    coordinates, all_rates = sprung.all_coordinates(free), rates @ sprung.carry.T
    kinetic = 0.5 * np.einsum("nf,fg,ng->n", rates, equations.whole_mass, rates)
    extension, twist = sprung.geometry(coordinates, all_rates).extension, sprung.turning_rates(coordinates)
    stored = 0.5 * (extension**2 @ sprung.lines.stiffness + twist**2 @ sprung.turns.stiffness) - coordinates @ sprung.weight
    _, works = segment._powers
    gained = works[:, DRIVE_WORK] - works[:, LOAD_WORK] - works[:, LOST]
    energy = kinetic + stored
    size = max(float(kinetic.max()), float(np.abs(works[:, [DRIVE_WORK, LOAD_WORK, LOST]]).max()), 1e-300)
    return float(np.abs(energy - energy[0] - gained).max() / size)


def _extremes(segment: ElasticSegment) -> Extremes:
    """Largest values over all panels of the segment, between fine places by parabolas."""
    solution, panels, press = segment.solution, segment.solution.panels, segment.solution.equations.driven.press
    sprung, equations, count = solution.equations.sprung, solution.equations, len(panels.mesh.start)
    places = np.linspace(0.0, 1.0, FINE + 1)
    at = solution_states(solution, np.repeat(np.arange(count), FINE + 1), np.tile(places, count), None, segment.gain)
    free, rates = at.whole
    coordinates, all_rates = sprung.all_coordinates(free), rates @ sprung.carry.T
    forces = _bearing_forces(solution, coordinates, all_rates)
    slide = _slide(solution, at)[:, 0]
    low, where = _lowest(slide.reshape(count, -1))
    panel, share = int(where), (where % 1.0)
    deep = solution_states(solution, np.array([panel]), np.array([share]), None, segment.gain)
    pull = _pull_on_slide(solution, forces)
    peaks = {name: -_lowest(-np.abs(force).reshape(count, -1))[0] for name, force in zip(press.bearings, forces, strict=True)}
    events = []
    for knot in sorted(equations.events or {}):
        first = int(np.searchsorted(panels.mesh.segment, knot))
        there = solution_states(solution, np.array([first]), np.zeros(1), None, segment.gain)
        time = float(there.times[0]) - segment.first
        if solution.periodic:
            time %= float(panels.mesh.knots[-1] - panels.mesh.knots[0])
        events.append((time, float(crank_of(solution, *there.whole)[0][0]), float(_slide(solution, there)[0, 0])))
    return Extremes(
        deepest=low,
        deepest_angle=float(crank_of(solution, *deep.whole)[0][0]),
        reverse_force=max(0.0, -_lowest(-pull.reshape(count, -1))[0]),
        peaks=peaks,
        events=tuple(sorted(events)),
    )


def _pull_on_slide(solution: ElasticSolution, forces: ComplexArray) -> Array:
    """Force (n,) of the pins on the slide along its direction [N]."""
    press, drawn = solution.equations.driven.press, DrawnPress(solution.equations.driven.press)
    slide, along = press.slide_guide.joint, complex(to_complex(drawn.plane, press.slide_direction))
    found = np.zeros(forces.shape[1])
    for number, force in enumerate(forces):
        link1, _, link2, _ = drawn.bearing(number)
        if slide in (link1, link2) and number not in drawn.directions:
            found += (along.conjugate() * force).real * (1.0 if link2 == slide else -1.0)
    return found


def _lowest(values: Array) -> tuple[float, float]:
    """Least value of a function by its values (panels, k) at even places from 0 to 1 on each panel, and where it is: panel + share."""
    panel, place = np.unravel_index(int(values.argmin()), values.shape)
    last = values.shape[1] - 1
    if not 0 < place < last:
        return float(values[panel, place]), float(panel + min(place / last, 1 - 1e-12))
    before, at, after = values[panel, place - 1 : place + 2]
    bend = before - 2 * at + after
    if not bend > 0:
        return float(at), float(panel + place / last)
    beside = 0.5 * (before - after) / bend
    return float(at - 0.125 * (before - after) ** 2 / bend), float(panel + (place + beside) / last)
