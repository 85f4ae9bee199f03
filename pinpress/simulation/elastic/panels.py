"""Second-order equations of motion by Radau IIA collocation, on many panels of time at once.

    M y'' + R(t, y, y', y'') = F(t, y, y')

M is constant; R, where there is any, are inertia forces that depend on the state. On a panel of length h the unknowns are the
accelerations a at the s Radau points c; the coefficients A give

    y' = v0 + h A a,   y = y0 + c h v0 + h^2 A A a

(Hairer and Wanner, Solving Ordinary Differential Equations II, IV.5; order 2 s - 1 at the ends of panels). Newton's method takes the
accelerations of all panels, the states at their borders and the times of events together: each panel's equations are solved for what its
first state and its times add, all panels in one call of LAPACK, and what is left is a recurrence over the borders. So the periodic motion
costs no more than a motion from a known state, and break-through, whose time is not known, is met exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from ...common.numerics import RadauRule
from ...common.quantities import Array

Indices = NDArray[np.intp]


class Linearised(NamedTuple):
    """Equations of motion at n states, and their derivatives.

    Attributes:
        left: (n, f) F - M y'' - R, which is 0 for a motion.
        stiffness: (n, f, f) minus its derivatives by y.
        damping: (n, f, f) by y'.
        mass: (f, f) or (n, f, f) by y''.
        by_time: (n, f) its derivative by the time itself.
    """

    left: Array
    stiffness: Array
    damping: Array
    mass: Array
    by_time: Array


class EquationsOfMotion(Protocol):
    """Equations of motion."""

    def linearised(self, time: Array, y: Array, v: Array, a: Array, segments: Indices) -> Linearised:
        """The equations at n states and accelerations, (n, f) each, in the given segments of the motion."""

    def event(self, knot: int, time: float, y: Array, v: Array) -> tuple[float, Array, float]:
        """What is zero at a knot whose time is free, its gradient (2 f,) by state and rate, and its derivative by the time itself."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Panels of time. Segments lie between knots; in each of them the forces are smooth.

    Attributes:
        knots: (m + 1,) times of the segments' ends [s].
        segment: (p,) segment of each panel, rising.
        low: (p,) start of each panel as a share of its segment.
        high: (p,) end of each panel as a share of its segment.
    """

    knots: Array
    segment: Indices
    low: Array
    high: Array

    @property
    def spans(self) -> Array:
        return np.asarray(np.diff(self.knots)[self.segment])

    @property
    def start(self) -> Array:
        """(p,) times at which the panels begin [s]."""
        return np.asarray(self.knots[self.segment] + self.low * self.spans)

    @property
    def length(self) -> Array:
        """(p,) lengths of the panels [s]."""
        return np.asarray((self.high - self.low) * self.spans)

    @property
    def borders(self) -> Array:
        """(p + 1,) times at which panels begin and end [s]."""
        return np.append(self.start, self.knots[-1])

    def slopes(self, knot: int) -> tuple[Array, Array]:
        """Derivatives (p,) of the panels' starts and lengths by the time of a knot."""
        after, before = self.segment == knot, self.segment == knot - 1
        starts = np.where(after, 1.0 - self.low, np.where(before, self.low, 0.0))
        return starts, (self.high - self.low) * (before.astype(float) - after)


class PanelStates(NamedTuple):
    """States of a motion at n places on its panels.

    Attributes:
        panel: (n,) the panels.
        share: (n,) places on them, from 0 to 1.
        time: (n,) [s].
        segment: (n,) of the mesh.
        y: (n, f) coordinates.
        v: (n, f) rates.
        a: (n, f) accelerations.
    """

    panel: Indices
    share: Array
    time: Array
    segment: Indices
    y: Array
    v: Array
    a: Array


@dataclass(frozen=True, eq=False)
class PanelSolution:
    """A motion as polynomials on panels.

    Attributes:
        mesh: the panels.
        rule: the collocation rule.
        states: (p + 1, 2 f) coordinates and rates at the borders.
        accelerations: (p, s, f) at the points of each panel.
        change: largest change of a coordinate in the last Newton step [m or rad].
        steps: number of Newton steps.
        passage: (2 f, 2 f) derivative of the last state by the first one, with the events met at their own times.
        curvature: largest change in a Newton step by the square of the change before, on the way to it; 0: not known [1/m].
    """

    mesh: Mesh
    rule: RadauRule
    states: Array
    accelerations: Array
    change: float
    steps: int
    passage: Array
    curvature: float = 0.0

    def errors(self) -> Array:
        """(p,) largest local error of a coordinate on each panel, from the last coefficient of its acceleration [m or rad]."""
        last = np.abs(np.einsum("s,psf->pf", self.rule.series[-1], self.accelerations)).max(axis=1)
        return np.asarray(self.mesh.length**2 * last)

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Coordinates, rates and accelerations (n, f) at times (n,) within the motion [s]."""
        panel = np.clip(np.searchsorted(self.mesh.start, times, side="right") - 1, 0, len(self.mesh.start) - 1)
        return self.within(panel, (times - self.mesh.start[panel]) / self.mesh.length[panel])

    def sample(self, shares: Array) -> PanelStates:
        """The states at shares (m,) of every panel, panel by panel."""
        count = len(self.mesh.start)
        return self.states_at(np.repeat(np.arange(count), len(shares)), np.tile(shares, count))

    def states_at(self, panel: Indices, share: Array) -> PanelStates:
        """The states at shares (n,) of panels (n,)."""
        time = self.mesh.start[panel] + share * self.mesh.length[panel]
        return PanelStates(panel, share, time, self.mesh.segment[panel], *self.within(panel, share))

    def weights(self, share: Array) -> Array:
        """(n, s): values at the points of a panel to integrals from its start to shares (n,), on a panel of length 1."""
        stages = len(self.rule.points)
        return np.asarray(legendre.legvander(2 * share - 1, stages) @ self.rule.integral)

    def within(self, panel: Indices, share: Array) -> tuple[Array, Array, Array]:
        """Coordinates, rates and accelerations (n, f) at shares (n,) of panels (n,)."""
        size, length = self.accelerations.shape[2], self.mesh.length[panel][:, None]
        first = self.states[panel]
        stages = len(self.rule.points)
        values = legendre.legvander(2 * share - 1, stages)
        once = values @ self.rule.integral
        weights = np.stack([once @ self.rule.integrate, once, values[:, :stages] @ self.rule.series], axis=1)
        twice, once, a = np.matmul(weights, self.accelerations[panel]).swapaxes(0, 1)
        v = first[:, size:] + length * once
        y = first[:, :size] + length * (share[:, None] * first[:, size:] + length * twice)
        return y, v, a

    def onto(self, mesh: Mesh) -> PanelSolution:
        """The same motion on other panels, as a guess for `solve`; its knots may have other times."""
        old, new = self.mesh, mesh
        times = np.interp(new.borders, new.knots, old.knots)  # piece by piece: events stay events
        inside = np.interp((new.start[:, None] + new.length[:, None] * self.rule.points).ravel(), new.knots, old.knots)
        y, v, _ = self.at(times)
        nudged = inside - 1e-12 * old.spans.max()  # the last point of a panel belongs to it, not to the next
        _, _, a = self.at(nudged)
        accelerations = a.reshape(len(new.start), len(self.rule.points), -1)
        return PanelSolution(mesh, self.rule, np.concatenate([y, v], axis=1), accelerations, np.inf, 0, self.passage, self.curvature)


class Ends(NamedTuple):
    """How a motion begins and ends.

    Attributes:
        periodic: whether it ends as it begins, with ``gain`` added; else the first state is kept.
        gain: (2 f,) what the last state has more than the first one.
        free: knots whose times are free, each with an event.
        kept: coordinates that begin where they are even so, as nothing depends on them.
    """

    periodic: bool
    gain: Array
    free: Sequence[int]
    kept: Sequence[int] = ()


def solve(
    equations: EquationsOfMotion, guess: PanelSolution, border: Ends, tolerance: float, most: int, divided_above: float = np.inf
) -> PanelSolution | None:
    """The motion near a guess by Newton's method; None if it does not converge.

    Args:
        equations: of motion.
        guess: panels, and a motion on them.
        border: how it begins and ends.
        tolerance: change of the coordinates at which it is found [m or rad].
        most: number of Newton steps.
        divided_above: error of a panel above which panels are divided anyway: the motion is then found no better than it takes to see it
            [m or rad]; without it all changes are made until they are small.
    """
    panels, change, curvature, stalls = guess, np.inf, guess.curvature, 0
    for count in range(1, most + 1):
        before = change
        panels = newton_step(equations, panels, border, count)
        change = panels.change
        if not np.isfinite(change) or not (np.diff(panels.mesh.knots) > 0).all():
            return None
        stalled = change > 0.1 * before  # rounding ends what Newton's method gains
        stalls += stalled
        near = 1e3 if stalls < 3 else 1e4  # on stiff springs places are known no better
        if change <= tolerance or (stalled and change <= near * tolerance):
            return replace(panels, curvature=curvature)
        if np.isfinite(before):
            curvature = max(curvature, change / before**2)
        # The next change: Newton's method squares what is left; the changes before show it within a factor of 3.
        ahead = 3.0 * curvature * change**2 if curvature and np.isfinite(divided_above) else np.inf
        if ahead <= 0.1 * tolerance:
            return replace(panels, curvature=curvature)
        error = float(panels.errors().max()) if np.isfinite(ahead) else 0.0
        if error > divided_above and ahead <= 0.02 * error:  # it does not matter to how panels are divided
            return replace(panels, curvature=curvature)
        if count > 3 and change > 2.0 * before:
            return None
    return None


def newton_step(equations: EquationsOfMotion, at: PanelSolution, border: Ends, count: int) -> PanelSolution:
    """One Newton step."""
    mesh, rule, a = at.mesh, at.rule, at.accelerations
    (panels, stages, size), h = a.shape, mesh.length
    free = list(border.free)
    step = _Step(equations, at)
    alone, by_state, by_time = step.solved(bool(free))
    ends, passages, timed = step.ends(alone, by_state, by_time)
    # what the borders' states change by: (2 f, 2 f + m) times the changes of the first state and of the free times, and a constant
    count_free = len(free)
    slopes = [mesh.slopes(knot) for knot in free]
    carried, alone_at = np.zeros((panels + 1, 2 * size, 2 * size + count_free)), np.zeros((panels + 1, 2 * size))
    carried[0, :, : 2 * size] = np.eye(2 * size)
    defects = ends - at.states[1:]
    for p in range(panels):
        carried[p + 1] = passages[p] @ carried[p]
        for k, (starts, lengths) in enumerate(slopes):
            if starts[p] or lengths[p]:
                carried[p + 1, :, 2 * size + k] += timed[p] @ (starts[p], lengths[p])
        alone_at[p + 1] = passages[p] @ alone_at[p] + defects[p]
    changes, passing = _border_changes(equations, at, border, carried, alone_at)
    moved = carried @ changes + alone_at
    inner = alone + np.einsum("pkx,px->pk", by_state, moved[:-1])
    knots = mesh.knots.copy()
    for k, (knot, (starts, lengths)) in enumerate(zip(free, slopes, strict=True)):
        inner += np.einsum("pkx,px->pk", by_time, np.stack([starts, lengths], axis=1)) * changes[2 * size + k]
        knots[knot] += changes[2 * size + k]
    states = at.states + moved
    largest = float(np.abs(moved[:, :size]).max())
    inner = inner.reshape(panels, stages, size)
    largest = max(largest, float((h**2 * np.abs(inner).max(axis=(1, 2))).max()))
    return PanelSolution(Mesh(knots, mesh.segment, mesh.low, mesh.high), rule, states, a + inner, largest, count, carried[-1] @ passing)


def _border_changes(equations: EquationsOfMotion, at: PanelSolution, border: Ends, carried: Array, alone: Array) -> tuple[Array, Array]:
    """Changes (2 f + m,) of the first state and of the free times that fulfil the conditions at the borders; and the derivative
    (2 f + m, 2 f) of both by the first state, where the events are met."""
    size, free = at.states.shape[1] // 2, list(border.free)
    matrix, right = np.zeros((2 * size + len(free),) * 2), np.zeros(2 * size + len(free))
    if border.periodic:
        matrix[: 2 * size] = carried[-1] - carried[0]
        right[: 2 * size] = -(at.states[-1] + alone[-1] - at.states[0] - border.gain)
        for row in border.kept:
            matrix[row], right[row] = 0.0, 0.0
            matrix[row, row] = 1.0
    else:
        matrix[: 2 * size, : 2 * size] = np.eye(2 * size)
    for k, knot in enumerate(free):
        place = int(np.searchsorted(at.mesh.segment, knot))  # the panel that begins at the knot
        value, gradient, by_time = equations.event(knot, float(at.mesh.knots[knot]), at.states[place, :size], at.states[place, size:])
        matrix[2 * size + k] = gradient @ carried[place]
        matrix[2 * size + k, 2 * size + k] += by_time
        right[2 * size + k] = -(value + gradient @ alone[place])
    events = matrix[2 * size :]
    times = -np.linalg.solve(events[:, 2 * size :], events[:, : 2 * size]) if free else np.zeros((0, 2 * size))
    return np.linalg.solve(matrix, right), np.concatenate([np.eye(2 * size), times])


class _Step:
    """The linear equations of all panels in one Newton step."""

    def __init__(self, equations: EquationsOfMotion, at: PanelSolution) -> None:
        mesh, rule, a = at.mesh, at.rule, at.accelerations
        self.rule, self.h = rule, mesh.length
        self.panels, self.stages, self.size = a.shape
        h = self.h[:, None, None]
        self.first = at.states[:-1]
        self.once = np.einsum("st,ptf->psf", rule.integrate, a)
        self.twice = np.einsum("st,ptf->psf", rule.integrate_twice, a)
        v0, y0 = self.first[:, None, self.size :], self.first[:, None, : self.size]
        self.v = v0 + h * self.once
        self.y = y0 + h * rule.points[:, None] * v0 + h * h * self.twice
        times = (mesh.start[:, None] + self.h[:, None] * rule.points).ravel()
        count = self.panels * self.stages
        segments = np.repeat(mesh.segment, self.stages)
        y, v = self.y.reshape(count, -1), self.v.reshape(count, -1)
        linear = equations.linearised(times, y, v, a.reshape(count, -1), segments)
        shape = self.panels, self.stages, self.size
        self.left, self.by_time = linear.left.reshape(shape), linear.by_time.reshape(shape)
        self.stiffness, self.damping = linear.stiffness.reshape(*shape, -1), linear.damping.reshape(*shape, -1)
        self.mass = linear.mass if linear.mass.ndim == 2 else linear.mass.reshape(*shape, -1).swapaxes(0, 1)  # stages first, as it is added

    def solved(self, timed: bool) -> tuple[Array, Array, Array]:
        """Changes of the accelerations (p, s f): alone; by the first state (p, s f, 2 f); by start and length (p, s f, 2)."""
        rule, size, h = self.rule, self.size, self.h[:, None, None, None]
        columns = 2 * size + 1 + (2 if timed else 0)
        right = np.empty((self.panels, self.stages, size, columns))
        right[..., 0] = self.left
        right[..., 1 : 1 + size] = -self.stiffness
        right[..., 1 + size : 1 + 2 * size] = -(h * rule.points[:, None, None] * self.stiffness + self.damping)
        if timed:
            h = self.h[:, None, None]
            v0 = self.first[:, None, size:]
            slope = rule.points[:, None] * v0 + 2 * h * self.twice
            bent = np.matmul(self.stiffness, slope[..., None])[..., 0] + np.matmul(self.damping, self.once[..., None])[..., 0]
            right[..., -2] = self.by_time
            right[..., -1] = rule.points[:, None] * self.by_time - bent
        rows = self.stages * size
        right = right.reshape(self.panels, rows, columns)
        changes = np.empty_like(right)
        for first in range(0, self.panels, 16):  # the equations of 16 panels stay in the cache
            part = slice(first, first + 16)
            changes[part] = np.linalg.solve(self._matrix(part).reshape(-1, rows, rows), right[part])
        return changes[..., 0], changes[..., 1 : 1 + 2 * size], changes[..., 1 + 2 * size :]

    def _matrix(self, part: slice) -> Array:
        """Derivatives (k, s, f, s, f) of the equations by the accelerations, on some panels."""
        rule, h = self.rule, self.h[part, None, None, None, None]
        matrix = (h * h * rule.integrate_twice[:, None, :, None]) * self.stiffness[part, :, :, None, :]
        matrix += (h * rule.integrate[:, None, :, None]) * self.damping[part, :, :, None, :]
        stage = np.arange(self.stages)
        matrix[:, stage, :, stage] += self.mass if self.mass.ndim == 2 else self.mass[:, part]
        return np.asarray(matrix)

    def ends(self, alone: Array, by_state: Array, by_time: Array) -> tuple[Array, Array, Array]:
        """States (p, 2 f) at the ends of the panels, and their derivatives by the first states (p, 2 f, 2 f) and by start and length of the
        panels (p, 2 f, 2)."""
        rule, size, h = self.rule, self.size, self.h
        weights = np.stack([rule.integrate_twice[-1], rule.integrate[-1]])  # (2, s)
        powers = np.stack([h * h, h], axis=1)  # (p, 2)

        def summed(changes: Array) -> Array:
            sums = np.einsum("ks,psfx->pkfx", weights, changes.reshape(self.panels, self.stages, size, -1))
            return np.asarray((powers[:, :, None, None] * sums).reshape(self.panels, 2 * size, -1))

        ends = np.concatenate([self.y[:, -1], self.v[:, -1]], axis=1) + summed(alone[..., None])[..., 0]
        passage = summed(by_state)
        diagonal = np.arange(2 * size)
        passage[:, diagonal, diagonal] += 1.0
        passage[:, diagonal[:size], diagonal[size:]] += h[:, None]
        timed = summed(by_time) if by_time.shape[-1] else np.zeros((self.panels, 2 * size, 2))
        if by_time.shape[-1]:
            v0 = self.first[:, size:]
            timed[:, :size, 1] += v0 + 2 * h[:, None] * self.twice[:, -1]
            timed[:, size:, 1] += self.once[:, -1]
        return ends, passage, timed
