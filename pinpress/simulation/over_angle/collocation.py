"""The reduced equation over the crank angle, for a crank that turns under forces that depend on crank angle and speed alone.

With the kinetic energy W = (I + J) w^2 / 2 the equation reads dW/du = G(u, w) and dt/du = 1 / |w|, where u is the angle travelled. A period
is solved at once for all scenarios: W is the integral of G over the panels of a mesh (collocation), and G depends on W through the speed.
Newton's method needs few rounds. Each is an integral with an integrating factor, or under a stiff drive the solution of each panel's linear
equations. Where no force depends on the speed, one round is exact.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...common.numerics import gauss_rule
from ...common.quantities import Array
from ...drives.transmission import PrescribedSpeed
from ..driven_press import DrivenPress
from ..failures import failure
from .forces import Forces, along_travel, friction_torque_at
from .mesh import TO_REST, Indices, Mesh

ROUNDS = 30  # most rounds of Newton's method
SETTLED = 1e-10  # relative change of the kinetic energy in a round that ends Newton's method, whose next change would be its square
FLOOR = 1e-6  # share of the first kinetic energy: no speed is computed from less
STIFF = 2.0  # where the energy changes the force by more over half a panel, the panel's own linear equations are solved
CLOSE = 1e-3  # relative change of the kinetic energy in a round from which on the slopes of the forces are kept
FURTHEST = 100.0  # largest factor by which a round may change the kinetic energy
BESIDE = 1e-7  # relative change of a speed by which the slopes of the forces are found
LEAST = 1e-3  # share of the period's largest kinetic energy: with less, a drive that depends on speed may be about to stop the crank


@dataclass(frozen=True, eq=False, repr=False)
class CollocationSolution:
    """A period, or a part of it, solved for S scenarios, at q nodes of p panels.

    Attributes:
        mesh: its panels.
        energy: (q, p, S) kinetic energy W at the nodes [J].
        ends: (p + 1, S) W at the borders [J].
        speed: (q, p, S) size of the crank's speed [rad/s]; it has no meaning where W is below the floor.
        force: (q, p, S) dW/du [N m].
        driving: (q, p, S) part of the force that comes from the drive [N m].
        resisting: (q, p, S) part of the force that comes from the loads [N m].
        friction_torque: (q, p, S) part of the force that comes from friction in the bearings [N m]; None for none.
        speed_free: whether no force depends on the speed, so that W is right beyond a stop too.
        stiffness: (p,) e-folds by which a disturbance of W dies away on half a panel; 0 where the drive is not stiff.
        exponent: (S,) e-folds by which a disturbance of a periodic W grows in a period; 0 of any other W.
        settled: (S,) number of panels on which Newton's method has found W: all, or those before the crank nearly stops.
        added: inertia of flywheel and drive, of the first scenario [kg m2].
        evaluations: number of nodes at which the forces were computed, each time counted.
    """

    mesh: Mesh
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
    added: float
    evaluations: int


def solve(driven: DrivenPress, mesh: Mesh, energy: Array, guess: Array | None = None, periodic: bool = False) -> CollocationSolution:
    """Find the kinetic energy over a mesh.

    Args:
        driven: what is simulated.
        mesh: its panels.
        energy: (S,) kinetic energy at the start of the mesh [J].
        guess: (q, p, S) kinetic energy from which Newton's method starts; None: ``energy`` everywhere.
        periodic: whether the motion has to end with the energy with which it begins; ``energy`` is then near it.

    Raises:
        SimulationError: the inertia is not positive everywhere.
    """
    inertia = _inertia(driven, mesh)
    if driven.prescribed is not None:
        return _prescribed(driven, mesh, inertia, driven.prescribed)
    work = np.broadcast_to(energy, (*mesh.angle.shape, len(energy))) if guess is None else guess
    return _Newton(driven, mesh, inertia, energy, work, periodic).solve(work)


def _inertia(driven: DrivenPress, mesh: Mesh) -> Array:
    """(q, p, S) inertia at the crank [kg m2]."""
    inertia: Array = mesh.inertia[:, :, None] + driven.inertia
    if not inertia.min() > 0:
        worst = np.unravel_index(int(inertia.min(axis=2).argmin()), mesh.angle.shape)
        raise failure("no inertia", None, float(mesh.angle[worst]), inertia=float(inertia.min()))
    return inertia


class _Newton:
    """Newton's method for the kinetic energy on all panels at once: dW/du = G + K (W_new - W)."""

    def __init__(self, driven: DrivenPress, mesh: Mesh, inertia: Array, energy: Array, work: Array, periodic: bool) -> None:
        """Begin with a guess of the kinetic energy.

        Args:
            driven: what is simulated.
            mesh: its panels.
            inertia: (q, p, S) at the crank [kg m2].
            energy: (S,) kinetic energy at the start [J].
            work: (q, p, S) the guess at the nodes [J].
            periodic: whether the motion has to end with the energy with which it begins.
        """
        self.mesh, self.inertia, self.energy, self.periodic = mesh, inertia, energy, periodic
        self.forces = Forces(driven.drive, mesh, inertia, work.shape)
        self.constant = driven.drive is None and not mesh.forces and mesh.bearings is None
        self.added = float(np.ravel(driven.inertia)[0])
        # from the guess alone, because W may rise without bounds far from the solution
        self.floor = FLOOR * work.max(axis=(0, 1)) + np.finfo(float).tiny
        self.stiffness, self.exponent = np.zeros(len(mesh.kinds)), np.zeros(len(energy))
        self.everywhere = np.full(len(energy), len(mesh.kinds))

    def solve(self, work: Array) -> CollocationSolution:
        rate, moved, ends, force = None, np.full((len(self.mesh.kinds), len(self.energy)), np.inf), None, None
        for _ in range(ROUNDS):
            above = np.maximum(work, self.floor)
            speed = np.sqrt(2 * above / self.inertia)
            total = self.forces.at(speed)
            if self.constant:
                return self._solution(work, True, self.everywhere)
            # K is found by a difference, because it only has to lead to the solution, and is kept close to it
            if rate is None or moved.max() > CLOSE:
                change = self.forces.faster(speed, BESIDE)
                # no force depends on the speed here; is it so at the speeds that follow from these forces too?
                if self.mesh.bearings is None and not change.any():
                    found = self._solution(work, True, self.everywhere)
                    if np.array_equal(self.forces.at(found.speed), total):
                        return self._seen_at_rest(found, total)
                    work, rate = np.maximum(found.energy, above / FURTHEST), None
                    continue
                rate = change / (2 * BESIDE * above)
                self.stiffness = self._stiffness(rate)
                self.exponent = _over_panels(self.mesh, rate).sum(axis=0) if self.periodic else self.exponent
            before = work
            work, ends, force = self._round(total, rate, before)
            if not np.isfinite(work.sum()):
                work = np.where(np.isfinite(work), work, above)
            work = np.minimum(np.maximum(work, above / FURTHEST), above * FURTHEST)
            last, moved = moved, np.abs(work - before).max(axis=0) / np.maximum(work.max(axis=0), self.energy)
            # a stiff drive's torque changes with the last digit of the speed
            if moved.max() <= SETTLED and not (self.stiffness.any() and moved.max() < 0.5 * last.max()):
                break
        # later panels do not act on earlier ones: the first panels may be right where the last ones are not
        unsettled = moved > SETTLED
        self.forces.at(np.sqrt(2 * np.maximum(work, self.floor) / self.inertia))
        settled = np.where(unsettled.any(axis=0), unsettled.argmax(axis=0), len(self.mesh.kinds))
        return self._solution(work, False, settled, ends, force) if self.stiffness.any() else self._solution(work, False, settled)

    def _stiffness(self, rate: Array) -> Array:
        stiffness = np.abs(rate * self.mesh.measure[:, :, None]).max(axis=(0, 2))
        return np.asarray(stiffness * (stiffness.max() > STIFF))

    def _round(self, total: Array, rate: Array, before: Array) -> tuple[Array, Array, Array | None]:
        """W at the nodes and borders after a round, and under a stiff drive the force that solves the equations."""
        total += self.mesh.weight[:, :, None]
        total -= rate * before
        with np.errstate(all="ignore"):  # far from the solution it may overshoot without bounds
            found = (_solved if self.stiffness.any() else _factored)(self.mesh, total, rate, self.energy, self.periodic)
        self.energy = found[1][0]
        return found

    def _seen_at_rest(self, found: CollocationSolution, total: Array) -> CollocationSolution:
        """A solution whose forces do not depend on its speeds. Where it has a stop, the forces at rest decide `speed_free`."""
        stopping = self.mesh.kinds.any() or not found.ends.min() > 0
        # a periodic motion is speed-free too: it does not come back, whatever its speed
        return replace(found, speed_free=bool(np.array_equal(self.forces.at(0.0 * found.speed), total))) if stopping else found

    def _solution(
        self, work: Array, speed_free: bool, settled: Indices, ends: Array | None = None, force: Array | None = None
    ) -> CollocationSolution:
        forces, weight = self.forces, self.mesh.weight[:, :, None]
        if ends is None or force is None:
            force = forces.total + weight
            work, ends = _integral(self.mesh, forces.total, weight, self.energy)
        else:  # the torque of a stiff drive follows from the solution: computed from the speed it would have the rounding of that
            others = forces.resisting if forces.friction_torque is None else forces.resisting + forces.friction_torque
            forces.driving = force - others - weight
        least = np.finfo(float).tiny if speed_free else self.floor  # before a stop W is small, and right
        return CollocationSolution(
            mesh=self.mesh,
            energy=work,
            ends=ends,
            speed=np.sqrt(2 * np.maximum(work, least) / self.inertia),
            force=force,
            driving=forces.driving,
            resisting=forces.resisting,
            friction_torque=forces.friction_torque,
            speed_free=speed_free,
            stiffness=self.stiffness,
            exponent=self.exponent,
            settled=settled,
            added=self.added,
            evaluations=forces.asked * work.size,
        )


def _prescribed(driven: DrivenPress, mesh: Mesh, inertia: Array, drive: PrescribedSpeed) -> CollocationSolution:
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
        ends=np.full((len(mesh.borders), 1), work.max()),
        speed=speed,
        force=total,
        driving=driving,
        resisting=resisting,
        friction_torque=friction_torque,
        speed_free=True,
        stiffness=np.zeros(len(mesh.kinds)),
        exponent=np.zeros(1),
        settled=np.full(1, len(mesh.kinds)),
        added=float(driven.inertia),
        evaluations=work.size,
    )


# ---------------------------------------------------------------------------------------------------------------- integrals over panels


def _integral(mesh: Mesh, force: Array, weight: Array, energy: Array) -> tuple[Array, Array]:
    """W at the nodes (q, p, S) and borders (p + 1, S) from the force (q, p, S) of drive and loads and that of weights (q, p, 1).

    While the crank turns, the work of weights is the difference of their potential energy and not the integral of their force, because it
    is then the same in every turn. Near a rest W is small and must be right relative to itself: there all is integrated, away from the
    rest.
    """
    rule = gauss_rule()
    q, p, count = force.shape
    rests = bool(mesh.kinds.any())
    inner = (force + weight if rests else force) * mesh.measure[:, :, None]
    flat = inner.reshape(q, p * count)
    totals = (rule.weights @ flat).reshape(p, count)
    ends = np.concatenate([energy[None], totals]).cumsum(axis=0)
    within = (rule.cumulative @ flat).reshape(q, p, count)
    work = ends[:-1] + within
    if not rests:
        work -= mesh.lifted[:, :, None]
        ends -= mesh.lifted_ends[:, None]
    elif mesh.kinds[-1] == TO_REST:
        back = np.concatenate([-totals[::-1].cumsum(axis=0)[::-1], np.zeros((1, count))])
        half = int(ends[:, 0].argmax())
        left = ((rule.weights - rule.cumulative) @ flat).reshape(q, p, count)
        work[:, half:], ends[half + 1 :] = (back[1:] - left)[:, half:], back[half + 1 :]
    return work, ends


def _factored(mesh: Mesh, constant: Array, rate: Array, energy: Array, periodic: bool) -> tuple[Array, Array, None]:
    """W (q, p, S) from dW/du = constant + rate W by an integrating factor, for all scenarios in few operations; its values (p + 1, S) at
    the borders; and no force. At the start W is ``energy``, or if ``periodic`` the same as at the end.

    On every panel W is a part of its own, plus a growth times its value at the panel's start.
    """
    rule = gauss_rule()
    q, p, count = constant.shape
    flat = (rate * mesh.measure[:, :, None]).reshape(q, p * count)
    growth, final = np.exp(rule.cumulative @ flat).reshape(q, p, count), np.exp(rule.weights @ flat).reshape(p, count)
    scaled = (constant * mesh.measure[:, :, None] / growth).reshape(q, p * count)
    ends = _panel_by_panel(final * (rule.weights @ scaled).reshape(p, count), final, energy, periodic)
    return np.asarray(growth * (ends[:-1] + (rule.cumulative @ scaled).reshape(q, p, count))), ends, None


def _solved(mesh: Mesh, constant: Array, rate: Array, energy: Array, periodic: bool) -> tuple[Array, Array, Array]:
    """W as `_factored` returns it, by the collocation equations of every panel, for drives so stiff that polynomials do not resolve an
    integrating factor; and the force dW/du (q, p, S) that solves them, because computed from W it would have the rounding of W.
    """
    rule, measure = gauss_rule(), mesh.measure.T[:, None]
    exponents = np.moveaxis(rate, 0, -1) * measure  # (p, S, q)
    right = np.stack([np.moveaxis(constant, 0, -1) * measure, exponents], axis=-1)
    try:
        parts = np.linalg.solve(np.eye(len(rule.nodes)) - exponents[..., None] * rule.cumulative, right)
    except np.linalg.LinAlgError:
        parts = np.full(right.shape, np.nan)
    own, growth = parts[..., 0], parts[..., 1]
    ends = _panel_by_panel(own @ rule.weights, 1 + growth @ rule.weights, energy, periodic)
    gained = own + growth * ends[:-1, :, None]
    work = ends[:-1, :, None] + gained @ rule.cumulative.T
    return np.moveaxis(work, -1, 0), ends, np.moveaxis(gained / measure, -1, 0)


def _panel_by_panel(gained: Array, final: Array, energy: Array, periodic: bool) -> Array:
    """W (p + 1, S) at the borders, from what panels (p, S) add to it, and the factor (p, S) by which they multiply its value at their
    start."""
    if periodic:
        energy = np.zeros(len(energy))
        for k in range(len(gained)):
            energy = final[k] * energy + gained[k]
        energy = energy / (1 - final.prod(axis=0))
    ends = np.empty((len(gained) + 1, len(energy)))
    ends[0] = energy
    for k in range(len(gained)):
        ends[k + 1] = final[k] * ends[k] + gained[k]
    return ends


def panel_integrals(solution: CollocationSolution, rate: Array) -> Array:
    """Integrals (p, S) of a rate (q, p, S) by the angle travelled, over each panel."""
    return _over_panels(solution.mesh, rate)


def _over_panels(mesh: Mesh, rate: Array) -> Array:
    q, p, count = rate.shape
    return np.asarray((gauss_rule().weights @ (rate * mesh.measure[:, :, None]).reshape(q, -1)).reshape(p, count))
