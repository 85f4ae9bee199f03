"""The result of an elastic simulation: a run with the displacements of links from the rigid press.

Every state has the rigid press at the same crank angle as its `Motion`, the displacement of all links from it, and the true forces of the
bearings. Slide position, velocity and acceleration are those of the slide on its springs.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from ...common.frozen import FrozenMapping, NamedArrays, read_only
from ...common.quantities import Array
from ...kinematics.cycle import motion_through_change_points
from ...kinematics.motion import Motion
from ..failures import failure
from ..law_trials import confirm_torques
from ..run import Run, Stats, energy_error
from ..solvers import SimulationProblem
from ..trajectory import DRIVE_WORK, INTEGRALS, LOAD_WORK, LOST, Sample, Trajectory
from .description import Elastic
from .panels import Indices
from .states import SolutionStates, solution_states
from .task import ElasticSolution


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ElasticRun(Run):
    """A run of a press on its springs; what it has more than a `Run`. All arrays are read-only.

    `inverse_dynamics` of it gives the reactions of the rigid press at the same crank angles, under loads at the heights of its rigid slide;
    the forces of the springs are ``bearing_force``.

    Attributes:
        displacement: (n, links, 3) of each moving link from the rigid press at the same crank angle: of its centre of mass along the two
            axes of the plane [m], and its turn [rad]. Of a linkage in space (n, links, 6): of its centre of mass in world axes [m], and
            the vector of its turn, along its axis and as long as its angle, in world axes [rad].
        bearing_force: (n, 3) by the names of joints and loops: action of parent on child, or of link1 on link2, in the plane [N].
        joint_load: (n,) by the names of the parts with preloaded joints, "frame" that of the columns: the load on both members, positive
            where it pulls [N]; `PreloadedJoint.forces` shares it among them. Of a rod it is the mean of the pulls at its pins. A guide in
            space has two, "slide_guide x" and "slide_guide y": each across it, named by the nearest axis of the link that carries it.
        shaking_force: (n, 3) sum of the forces of linkage, crown and process loads on the frame [N].
        floor_force: (n, 3) force of the mounts on the floor [N]; None if the frame does not stand on mounts.
        frame_motion: (n, 3) displacement of the frame's centre of mass on its mounts along the axes of the plane, from its place under the
            static load [m], and its turn [rad]; None if it does not.
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
        angle: of the crank at the segment's start, which may lie whole periods from that of the solution [rad].
    """

    solution: ElasticSolution
    first: float
    end: float
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
        knots, first = self.solution.panels.mesh.knots, self.solution.panels.mesh.borders - self.first
        period = float(knots[-1] - knots[0])
        borders = (first + period * np.arange(np.ceil(self.end / period) + 1)[:, None]).ravel()
        return np.unique(np.concatenate([borders[(borders > 0.0) & (borders < self.end)], [0.0, self.end]]))

    jumps = borders

    @property
    def travelled(self) -> float:
        return abs(float(np.diff(self.states(np.array([0.0, self.end])).crank[0])[0]))

    @property
    def fastest(self) -> float:
        return float(np.abs(self.states(self.borders).crank[1]).max())

    def states(self, times: Array) -> SolutionStates:
        """States at times (n,) of the segment."""
        mesh = self.solution.panels.mesh
        begin, until = mesh.knots[0], mesh.knots[-1]
        within = self.first + times
        turns = np.floor((within - begin) / (until - begin) - 1e-12).clip(0) if self.solution.gain is not None else np.zeros(len(times))
        within = within - turns * (until - begin)
        panel = np.clip(np.searchsorted(mesh.start, within, side="right") - 1, 0, len(mesh.start) - 1)
        share = (within - mesh.start[panel]) / mesh.length[panel]
        return solution_states(self.solution, panel, share, turns)

    def at(self, times: Array, complete: bool = True) -> Sample:
        return self.sample(self.states(times))

    def sample(self, states: SolutionStates) -> Sample:
        """What a trajectory gives at states."""
        (angle, speed, acceleration), driving = states.crank, states.driving
        driven = driving.torque, driving.motor, driving.speed, self.solution.equations.drive_states(states.v)
        return Sample((angle + self._whole_periods)[None], speed[None], acceleration[None], *driven, self.integrals(states))

    @cached_property
    def _whole_periods(self) -> float:
        """Angle (of whole periods) by which the crank angles of the solution differ from those of the segment [rad]."""
        first = float(self.states(np.zeros(1)).crank[0][0])
        return float(np.round((self.angle - first) / (2 * np.pi)) * 2 * np.pi)

    @cached_property
    def _powers(self) -> tuple[Array, Array]:
        """Powers (p, s, 4) of the `INTEGRALS` at all points of the panels, and their integrals (p + 1, 4) from the solution's start."""
        panels = self.solution.panels
        count, stages = panels.accelerations.shape[:2]
        states = solution_states(self.solution, np.repeat(np.arange(count), stages), np.tile(panels.rule.points, count))
        powers = states.powers().T.reshape(count, stages, len(INTEGRALS))
        gains = panels.mesh.length[:, None] * np.einsum("s,psk->pk", panels.rule.integrate[-1], powers)
        return powers, np.concatenate([np.zeros((1, len(INTEGRALS))), np.cumsum(gains, axis=0)])

    def integrals(self, states: SolutionStates) -> Array:
        """(4, n) the `INTEGRALS` from the segment's start."""
        return np.asarray((self._integrated(states) - self._integrated(self.states(np.zeros(1)))).T)

    def _integrated(self, states: SolutionStates) -> Array:
        powers, ends = self._powers
        weights = self.solution.panels.weights(states.share)
        inside = self.solution.panels.mesh.length[states.panel][:, None] * np.einsum("ns,nsk->nk", weights, powers[states.panel])
        return np.asarray(ends[states.panel] + inside + states.turns[:, None] * ends[-1])


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
    press, trajectory = problem.driven.press, Trajectory([segment])
    solution, sprung = segment.solution, segment.solution.equations.sprung
    times = np.linspace(0.0, segment.end, points)
    states = segment.states(times)
    sample = segment.sample(states)
    motion = motion_through_change_points(press, sample.position[0], sample.speed[0], sample.acceleration[0], times)
    confirm_torques(problem.driven.drive, times, sample.position[0], sample.drive_speed, sample.drive_torque)
    base = sprung.geometry.base
    rigid = {field.name: getattr(motion, field.name) for field in fields(Motion) if field.init}
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
        **rigid,
        stats=stats,
        drive_torque=read_only(sample.drive_torque),
        drive_speed=read_only(sample.drive_speed),
        **integrals,
        problem=problem,
        trajectory=trajectory,
        displacement=read_only(sprung.geometry.displacement(states.bodies.coordinates, motion)),
        bearing_force=NamedArrays(press.bearings, states.forces.in_bearings),
        joint_load=FrozenMapping(states.forces.joint_loads()),
        shaking_force=read_only(states.shaking_force()),
        floor_force=None if base is None else read_only(states.outer_less_inertia()),
        frame_motion=None if base is None else read_only(states.bodies.coordinates[:, 3 * base : 3 * base + 3].copy()),
        decay_per_stroke=None if solution.gain is None else solution.decay,
        elastic=sprung.elastic,
        _on_springs=read_only(states.slide()),
        _extremes=_extremes(segment),
    )


def _audit(segment: ElasticSegment, tolerance: float) -> float:
    """Largest energy missing at the borders of panels, as a share of the largest kinetic energy or work.

    Raises:
        SimulationError: the energy does not balance.
    """
    count, (_, works) = segment.steps, segment._powers
    states = solution_states(segment.solution, np.append(np.arange(count), count - 1), np.append(np.zeros(count), 1.0))
    error = energy_error(*states.energies(), *works[:, [DRIVE_WORK, LOAD_WORK, LOST]].T)
    largest = float(error.max())
    # Coordinates that are wrong by a share of the deflection change the energy of springs by about twice that share; at the ends of panels
    # they are far better. Up to a millionth is accepted of all runs, rigid ones too.
    if not largest <= max(1e-6, tolerance):
        worst = int(error.argmax())
        raise failure("unbalanced", float(states.times[worst]), float(states.crank[0][worst]))
    return largest


def _extremes(segment: ElasticSegment) -> Extremes:
    """Largest values over all panels of the segment."""
    solution, names = segment.solution, segment.solution.equations.driven.press.bearings

    def all_values(panel: Indices, share: Array) -> Array:
        """Depth of the slide, pull on it, and size of each bearing's force, (2 + bearings, n)."""
        states = solution_states(solution, panel, share)
        return np.stack([-states.slide()[:, 0], states.forces.on_slide(), *np.linalg.norm(states.forces.in_bearings, axis=2)])

    (depth, panel, share), (pull, _, _), *peaks = _largest(all_values, segment.steps)
    return Extremes(
        deepest=-depth,
        deepest_angle=float(solution_states(solution, np.array([panel]), np.array([share])).crank[0][0]),
        reverse_force=max(0.0, pull),
        peaks=FrozenMapping({name: value for name, (value, _, _) in zip(names, peaks, strict=True)}),
        events=_events(segment),
    )


def _largest(values: Callable[[Indices, Array], Array], panels: int) -> list[tuple[float, int, float]]:
    """Largest value of each of k functions on panels, the panel, and the share of it where it is.

    Args:
        values: of panels (n,) and shares of them (n,) to values (k, n).
        panels: their number.
    """
    parts = 24  # of a panel, and of the two parts about the largest values at their ends
    places = np.linspace(0.0, 1.0, parts + 1)
    coarse = values(np.repeat(np.arange(panels), parts + 1), np.tile(places, panels))
    candidates = np.argsort(coarse, axis=1)[:, -3:]  # a peak at a border of panels is on two of them
    panel, place = candidates // (parts + 1), places[candidates % (parts + 1)]
    low, high = np.maximum(place - 1 / parts, 0.0), np.minimum(place + 1 / parts, 1.0)
    shares = low[..., None] + (high - low)[..., None] * places
    fine = values(np.repeat(panel, parts + 1), shares.ravel()).reshape(len(coarse), *shares.shape)
    largest = []
    for row in range(len(coarse)):
        peaks = fine[row, row]
        where, best = np.unravel_index(int(peaks.argmax()), peaks.shape)
        value, offset = float(peaks[where, best]), 0.0
        if 0 < best < parts:
            before, after = peaks[where, best - 1], peaks[where, best + 1]
            bend = 2 * value - before - after
            offset = 0.5 * (after - before) / bend if bend > 0 else 0.0
            value += 0.25 * offset * float(after - before)
        step = shares[row, where, 1] - shares[row, where, 0]
        largest.append((value, int(panel[row, where]), float(shares[row, where, best] + offset * step)))
    return largest


def _events(segment: ElasticSegment) -> tuple[tuple[float, float, float], ...]:
    """Time, crank angle and slide position of each event."""
    solution, mesh, events = segment.solution, segment.solution.panels.mesh, []
    for knot in solution.equations.events or {}:
        if knot == len(solution.equations.segments):  # the end of a period
            continue
        state = solution_states(solution, np.array([int(np.searchsorted(mesh.segment, knot))]), np.zeros(1))
        time = float(state.times[0]) - segment.first
        if solution.gain is not None:
            time %= float(mesh.knots[-1] - mesh.knots[0])
        events.append((time, float(segment.at(np.array([time])).position[0, 0]), float(state.slide()[0, 0])))
    return tuple(sorted(events))
