"""The reduced equation over the crank angle, for a crank that turns under forces that depend on crank angle and speed alone.

With the kinetic energy W = (I + J) w^2 / 2 the equation reads dW/du = G(u, w) and dt/du = 1 / |w|, where u is the angle travelled. A period
is solved at once for all scenarios: W is the integral of G over the panels of a mesh (collocation), and G depends on W through the speed.
Newton's method needs few rounds. Each is an integral with an integrating factor, or under a stiff drive the solution of each panel's linear
equations. Where no force depends on the speed, one round is exact.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...common.numerics import gauss_rule, running_sums
from ...common.products import product
from ...common.quantities import Array
from ...drives.transmission import PrescribedSpeed
from ..driven_press import DrivenPress
from ..failures import failure
from .forces import Forces, along_travel, friction_torque_at
from .mesh import FROM_REST, TO_REST, AngleMesh, Indices

ROUNDS = 12  # most rounds of Newton's method in which no further panel is solved
SETTLED = 1e-8  # relative change of the kinetic energy that ends Newton's method, which squares it: the next one would be rounding
FLOOR = 1e-6  # share of the kinetic energy at the start: forces are not computed at the speeds of less
TINY = float(np.finfo(float).tiny)
FURTHEST = 100.0  # largest factor by which a round may change the kinetic energy
BESIDE = 1e-7  # relative change of a speed by which the slopes of the forces are found
LEAST = 1e-3  # share of the period's largest kinetic energy: with less, a drive that depends on speed may be about to stop the crank


class Growth(NamedTuple):
    """How a disturbance of W grows with the angle, by dW/du = K W."""

    slopes: Array  # (q, p, S) K
    stiffness: Array  # (p,) see `CollocationSolution`
    within: Array | None  # (q, p, S) factor from the start of a panel to its nodes; None of a stiff drive
    through: Array | None  # (p, S) factor over a whole panel; None of a stiff drive


@dataclass(frozen=True, eq=False, repr=False)
class CollocationSolution:
    """A period, or a part of it, solved for S scenarios, at q nodes of p panels.

    Attributes:
        mesh: its panels.
        energy: (q, p, S) kinetic energy W at the nodes [J].
        ends: (p + 1, S) W at the borders [J].
        speed: (q, p, S) size of the crank's speed that W gives [rad/s]; nearly 0 where W is not positive.
        force: (q, p, S) dW/du [N m].
        driving: (q, p, S) part of the force that comes from the drive [N m].
        resisting: (q, p, S) part of the force that comes from the loads [N m].
        friction_torque: (q, p, S) part of the force that comes from friction in the bearings [N m]; None for none.
        speed_free: whether no force depends on the speed, so that W is right beyond a stop too.
        stiffness: (p,) e-folds by which a disturbance of W dies away on half a panel; 0 where the drive is not stiff.
        exponent: (S,) e-folds by which a disturbance of a periodic W grows in a period; 0 of any other W.
        settled: (S,) number of panels on which W is solved: all, or those before the crank nearly stops. There every force was computed at
            the speed that W gives.
        added: inertia of flywheel and drive, (S,), or (1,) where all scenarios have the same [kg m2].
        evaluations: number of nodes at which the forces were computed, each time counted.
        growth: of a disturbance of W, about right; None if no force depends on the speed.
    """

    mesh: AngleMesh
    energy: Array
    ends: Array
    speed: Array
    force: Array
    driving: Array
    resisting: Array
    friction_torque: Array | None
    speed_free: bool
    stiffness: Array
    exponent: Array
    settled: Indices
    added: Array
    evaluations: int
    growth: Growth | None = None

    @cached_property
    def slowness(self) -> Array:
        """(q, p, S) derivative of the time by x [s]."""
        return np.asarray(self.mesh.measure[:, :, None] / self.speed)

    @cached_property
    def durations(self) -> Array:
        """(p, S) of the panels [s]."""
        return _sums(self.slowness)

    def start_with(self, energy: Array) -> Array:
        """About the kinetic energy (q, p, S) over the same mesh from other energies (S,) at the start."""
        change: Array = energy - self.ends[0]
        growth = self.growth
        if growth is None or growth.within is None or growth.through is None:
            return self.energy + change
        return np.asarray(self.energy + growth.within * np.concatenate([change[None], change * growth.through[:-1].cumprod(axis=0)]))


def solve(
    driven: DrivenPress,
    mesh: AngleMesh,
    energy: Array,
    guess: Array | None = None,
    *,
    nearby: CollocationSolution | None = None,
    periodic: bool = False,
    roughly: bool = False,
) -> CollocationSolution:
    """Find the kinetic energy over a mesh.

    Args:
        driven: what is simulated.
        mesh: its panels.
        energy: (S,) kinetic energy at the start of the mesh [J].
        guess: (q, p, S) kinetic energy from which Newton's method starts; None: ``energy`` everywhere, or that of 1 rad/s from a rest.
        nearby: a solution over the same mesh, near which Newton's method starts in place of a guess.
        periodic: whether the motion has to end with the energy with which it begins; ``energy`` is then near it.
        roughly: whether the solution is only to show where to search for another.

    Raises:
        SimulationError: the inertia is not positive everywhere.
    """
    inertia = _inertia(driven, mesh)
    if driven.prescribed is not None:
        return _at_constant_speed(driven, mesh, inertia, driven.prescribed)
    if driven.speed_free:
        return _Newton(driven, mesh, inertia, energy, energy[None, None], periodic).integrate()
    if nearby is not None:
        guess = nearby.start_with(energy)
    if guess is None:
        guess = 0.5 * inertia if mesh.kinds[0] == FROM_REST else np.broadcast_to(energy, (*mesh.angle.shape, len(energy)))
    return _Newton(driven, mesh, inertia, energy, guess, periodic).solve(guess, 1e-4 if roughly else SETTLED)


def _inertia(driven: DrivenPress, mesh: AngleMesh) -> Array:
    """(q, p, S) inertia at the crank [kg m2]."""
    inertia: Array = mesh.inertia[:, :, None] + driven.inertia
    if not mesh.inertia.min() + np.min(driven.inertia) > 0 and not inertia.min() > 0:
        worst = np.unravel_index(int(inertia.min(axis=2).argmin()), mesh.angle.shape)
        raise failure("no inertia", None, float(mesh.angle[worst]), inertia=float(inertia.min()))
    return inertia


class _Newton:
    """Newton's method for the kinetic energy on all panels at once: dW/du = G + K (W_new - W)."""

    def __init__(self, driven: DrivenPress, mesh: AngleMesh, inertia: Array, energy: Array, work: Array, periodic: bool) -> None:
        """Begin with a guess of the kinetic energy.

        Args:
            driven: what is simulated.
            mesh: its panels.
            inertia: (q, p, S) at the crank [kg m2].
            energy: (S,) kinetic energy at the start [J].
            work: (q, p, S) the guess at the nodes [J]; (1, 1, S) where none is needed.
            periodic: whether the motion has to end with the energy with which it begins.
        """
        self.mesh, self.inertia, self.energy, self.periodic = mesh, inertia, energy, periodic
        self.shape = (*mesh.angle.shape, len(energy))
        self.forces = Forces(driven.drive, mesh, inertia, self.shape)
        self.twice = 2 / inertia
        self.added = np.ravel(driven.inertia).astype(float)
        # The guess must not decide where W is solved; only a start from rest leaves no other measure.
        self.floor = FLOOR * np.where(energy > 0, energy, work.max(axis=(0, 1))) + TINY
        self.everywhere = np.full(len(energy), len(mesh.kinds))

    def solve(self, work: Array, change: float) -> CollocationSolution:
        """Find W from a guess (q, p, S) by rounds, the last of which changes W by no more than this share. Far from the guess each round
        solves a few more panels."""
        new_work, ends, force, growth, left = work, None, None, None, ROUNDS
        settled = most = 0 * self.everywhere
        while left:
            left -= 1
            above = np.maximum(work, self.floor)
            speed = np.sqrt(above * self.twice)
            total = self.forces.at(speed)
            faster = self.forces.faster(speed, BESIDE)
            # no force depends on the speed here; is it so at the speeds that follow from these forces too?
            if self.mesh.bearings is None and not faster.any():
                free = self._solution(work, True, self.everywhere)
                if np.array_equal(self.forces.at(free.speed), total):
                    stopping = self.mesh.kinds.any() or not free.ends.min() > 0
                    # With a stop, the forces at rest decide. A periodic motion is speed-free too: it never comes back.
                    return replace(free, speed_free=bool(np.array_equal(self.forces.at(0.0 * free.speed), total))) if stopping else free
                work, growth = np.maximum(free.energy, above / FURTHEST), None
                continue
            growth = _growth(self.mesh, faster, above)
            before = work
            new_work, ends, force = self._round(total, growth, before)
            work, changes = self._limit(new_work, before, above)
            # W that was limited, or whose speed was, is not that of these forces. Later panels do not act on earlier ones.
            unsolved = ~(changes <= change) | (work != new_work).any(axis=0) | (work < self.floor).any(axis=0)
            settled = np.where(unsolved.any(axis=0), unsolved.argmax(axis=0), len(self.mesh.kinds))
            if changes.max() <= change:
                break
            left = ROUNDS if (settled > most).any() else left
            most = np.maximum(most, settled)
        steady = not self.forces.vary and not self.mesh.kinds.any()
        if growth is not None and growth.within is not None and steady and work is new_work:
            # the forces at this W differ from these by a square of the last change
            force = growth.slopes * (new_work - before) + total + self.mesh.weight[:, :, None]
        else:
            self.forces.at(np.sqrt(np.maximum(work, self.floor) * self.twice))
        return self._solution(work, False, settled, growth, None if force is None else ends, force)

    def integrate(self) -> CollocationSolution:
        """Where no force depends on the speed, W is an integral."""
        self.forces.at(np.broadcast_to(np.sqrt(np.maximum(self.energy, self.floor) * self.twice[0, 0]), self.shape))
        return self._solution(None, True, self.everywhere)

    def _round(self, total: Array, growth: Growth, before: Array) -> tuple[Array, Array, Array | None]:
        """W at the nodes and borders after a round, and under a stiff drive the force that solves the equations.

        Without a stiff drive only what the integral of the force misses is solved with K, so that the rounding of K does not count.
        """
        mesh, measure, weight = self.mesh, self.mesh.measure[:, :, None], self.mesh.weight[:, :, None]
        force = None
        with np.errstate(all="ignore"):  # far from the solution it may overshoot without bounds
            if growth.within is None or growth.through is None:
                exponents = growth.slopes * measure
                constant = (total + weight) * measure - exponents * before
                work, ends, force = _solve_stiff(mesh, constant, exponents, self.energy, self.periodic)
            else:
                work, ends = _integral(mesh, total, weight, self.energy)
                missed = (work - before) * growth.slopes * measure
                further, at_ends = _solve_by_factor(missed, growth.within, growth.through, ends[-1] - ends[0] if self.periodic else None)
                work += further
                ends += at_ends
        self.energy = ends[0]
        return work, ends, force

    def _limit(self, work: Array, before: Array, above: Array) -> tuple[Array, Array]:
        """W after a round, limited to a factor of what it was ``before``, where that is ``above`` the floor, and its largest change (p, S)
        as a share."""
        if not (np.abs(work - before).max(axis=0) <= 0.5 * above.min(axis=0)).all():
            finite = np.where(np.isfinite(work), work, above)
            work = np.minimum(np.maximum(finite, above / FURTHEST), above * FURTHEST)
        return work, np.abs(work - before).max(axis=0) / np.maximum(work.max(axis=0), self.energy)

    def _solution(
        self,
        work: Array | None,
        speed_free: bool,
        settled: Indices,
        growth: Growth | None = None,
        ends: Array | None = None,
        force: Array | None = None,
    ) -> CollocationSolution:
        forces, weight = self.forces, self.mesh.weight[:, :, None]
        if work is None or ends is None or force is None:
            force = forces.total + weight
            work, ends = _integral(self.mesh, forces.total, weight, self.energy)
        else:  # the torque of a stiff drive follows from the solution: computed from the speed it would have the rounding of that
            others = forces.resisting if forces.friction_torque is None else forces.resisting + forces.friction_torque
            forces.driving = force - others - weight
        exponent = np.zeros(len(self.energy))
        if growth is not None and self.periodic:
            exponent = _sums(growth.slopes * self.mesh.measure[:, :, None]).sum(axis=0)
        speed = np.maximum(work, TINY) * self.twice  # never from the floor, so that the energy balance tells what is wrong
        return CollocationSolution(
            mesh=self.mesh,
            energy=work,
            ends=ends,
            speed=np.sqrt(speed, out=speed),
            force=force,
            driving=forces.driving,
            resisting=forces.resisting,
            friction_torque=forces.friction_torque,
            speed_free=speed_free,
            stiffness=np.zeros(len(self.mesh.kinds)) if growth is None else growth.stiffness,
            exponent=exponent,
            settled=settled,
            added=self.added,
            evaluations=forces.asked * work.size,
            growth=growth,
        )


def _growth(mesh: AngleMesh, change: Array, above: Array) -> Growth:
    """How disturbances grow where energies (q, p, S) whose speeds are larger by the share `BESIDE` ``change`` the force (q, p, S)."""
    slopes = change / (2 * BESIDE * above)
    exponents = slopes * mesh.measure[:, :, None]
    stiffness = np.maximum(exponents.max(axis=(0, 2)), -exponents.min(axis=(0, 2)))
    # Where the energy changes the force by more than this over half a panel, polynomials do not resolve an integrating factor.
    if not stiffness.max() <= 2.0:
        return Growth(slopes, stiffness, None, None)
    growth = np.exp(_to_end(exponents))
    return Growth(slopes, 0.0 * stiffness, growth[:-1], growth[-1])


def _at_constant_speed(driven: DrivenPress, mesh: AngleMesh, inertia: Array, drive: PrescribedSpeed) -> CollocationSolution:
    """The solution at a constant speed, with the torque that this takes."""
    speed = np.full(inertia.shape, abs(drive.speed))
    work = 0.5 * inertia * speed**2
    resisting = np.zeros(inertia.shape)
    for force in mesh.forces:
        resisting[:, force.panels] += along_travel(mesh, force, mesh.direction * speed)
    total = 0.5 * mesh.direction * mesh.slope[:, :, None] * speed**2
    friction_torque, driving = None, total - resisting - mesh.weight[:, :, None]
    if mesh.bearings is not None:
        friction_torque = friction_torque_at(mesh, mesh.bearings, speed, np.zeros(speed.shape), np.full(speed.shape, np.inf))[0]
        driving -= friction_torque
    return CollocationSolution(
        mesh=mesh,
        energy=work,
        ends=0.5 * (mesh.inertia_ends[:, None] + driven.inertia) * drive.speed**2,
        speed=speed,
        force=total,
        driving=driving,
        resisting=resisting,
        friction_torque=friction_torque,
        speed_free=True,
        stiffness=np.zeros(len(mesh.kinds)),
        exponent=np.zeros(1),
        settled=np.full(1, len(mesh.kinds)),
        added=np.array([float(driven.inertia)]),
        evaluations=work.size,
    )


# ---------------------------------------------------------------------------------------------------------------- integrals over panels


def _integral(mesh: AngleMesh, force: Array, weight: Array, energy: Array) -> tuple[Array, Array]:
    """W at the nodes (q, p, S) and borders (p + 1, S) from the force (q, p, S) of drive and loads and that of weights (q, p, 1).

    While the crank turns, the work of weights is the difference of their potential energy and not the integral of their force, because it
    is then the same in every turn. Near a rest W is small and must be right relative to itself: there all is integrated, away from the
    rest.
    """
    rests = bool(mesh.kinds.any())
    inner = (force + weight if rests else force) * mesh.measure[:, :, None]
    integrals = _to_end(inner)
    work, totals = integrals[:-1], integrals[-1]
    ends = running_sums(energy, totals)
    work += ends[:-1]
    if not rests:
        work -= mesh.lifted[:, :, None]
        ends -= mesh.lifted_ends[:, None]
    elif mesh.kinds[-1] == TO_REST:
        back = running_sums(0.0, -totals[::-1])[::-1]
        half = int(ends[:, 0].argmax())
        rule = gauss_rule()
        left = product(rule.weights - rule.cumulative, inner.reshape(len(inner), -1)).reshape(inner.shape)
        work[:, half:], ends[half + 1 :] = (back[1:] - left)[:, half:], back[half + 1 :]
    return work, ends


def _solve_by_factor(constant: Array, within: Array, through: Array, short: Array | None) -> tuple[Array, Array]:
    """F (q, p, S) from dF/dx = constant + K du/dx F by an integrating factor, for all scenarios in few operations, and its values
    (p + 1, S) at the borders. On every panel F is a part of its own, plus a growth times its value at the panel's start.

    Args:
        constant: (q, p, S), which is overwritten.
        within: (q, p, S) see `Growth`.
        through: (p, S) see `Growth`.
        short: (S,) by which F has to be larger at the start than at the end; None: it is zero at the start.
    """
    constant /= within
    integrals = _to_end(constant)
    values, ends = integrals[:-1], _panel_by_panel(through * integrals[-1], through, short)
    values += ends[:-1]
    values *= within
    return values, ends


def _solve_stiff(mesh: AngleMesh, constant: Array, exponents: Array, energy: Array, periodic: bool) -> tuple[Array, Array, Array]:
    """W (q, p, S) from dW/dx = constant + exponents W by the collocation equations of every panel, for drives so stiff that polynomials do
    not resolve an integrating factor; its values (p + 1, S) at the borders; and the force dW/du (q, p, S) that solves them, because
    computed from W it would have the rounding of W. At the start W is ``energy``, or if ``periodic`` the same as at the end.
    """
    rule, measure = gauss_rule(), mesh.measure.T[:, None]
    exponents = np.moveaxis(exponents, 0, -1)  # (p, S, q)
    right = np.stack([np.moveaxis(constant, 0, -1), exponents], axis=-1)
    try:
        parts = np.linalg.solve(np.eye(len(rule.nodes)) - exponents[..., None] * rule.cumulative, right)
    except np.linalg.LinAlgError:
        parts = np.full(right.shape, np.nan)
    from_zero, growth = parts[..., 0], parts[..., 1]
    gains, factors = from_zero @ rule.weights, 1 + growth @ rule.weights
    ends = _panel_by_panel(gains, factors, 0.0 * energy if periodic else None, energy)
    gained = from_zero + growth * ends[:-1, :, None]
    work = ends[:-1, :, None] + gained @ rule.cumulative.T
    return np.moveaxis(work, -1, 0), ends, np.moveaxis(gained / measure, -1, 0)


def _panel_by_panel(gained: Array, factors: Array, short: Array | None, start: Array | float = 0.0) -> Array:
    """Values (p + 1, S) at the borders of what panels (p, S) add to, and multiply by factors (p, S), from a ``start`` (S,), or if
    ``short`` is given from one that is larger by that (S,) than the value at the end."""
    if short is not None:
        at_end = _panel_by_panel(gained, factors, None)[-1]
        start = (at_end + short) / (1 - factors.prod(axis=0))
    panels, count = gained.shape
    ends = np.empty((panels + 1, count))
    ends[0] = start
    for k in range(panels):
        np.multiply(factors[k], ends[k], out=ends[k + 1])
        ends[k + 1] += gained[k]
    return ends


def panel_integrals(solution: CollocationSolution, rate: Array) -> Array:
    """Integrals (p, S) of a rate (q, p, S) by the angle travelled, over each panel."""
    rule, mesh = gauss_rule(), solution.mesh
    return np.asarray(np.einsum("qp,qps->ps", rule.weights[:, None] * mesh.measure, rate))


def _sums(rate: Array) -> Array:
    """Integrals (p, S) of a rate (q, p, S) by x over each panel."""
    q, p, count = rate.shape
    return product(gauss_rule().weights, rate.reshape(q, -1)).reshape(p, count)


def _to_end(rate: Array) -> Array:
    """Integrals (q + 1, p, S) of a rate (q, p, S) by x from each panel's start to its nodes and to its end."""
    q, p, count = rate.shape
    return product(gauss_rule().to_end, rate.reshape(q, -1)).reshape(q + 1, p, count)
