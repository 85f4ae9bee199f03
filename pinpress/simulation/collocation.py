"""The reduced equation over the crank angle: for a crank that turns, under forces that know time only through its speed.

With the kinetic energy W = (I + J) w^2 / 2 the equation reads dW/du = G(u, w) and dt/du = 1 / |w|, u the angle travelled. A period is
solved at once, for all scenarios: W is the integral of G over `panels` of Gauss nodes (collocation), G depends on W through the speed, and
Newton's method needs few rounds, each an integral with an integrating factor, or where the drive is stiff the panels' own linear equations.
Where no force depends on the speed one round is exact.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..common.arrays import Array
from ..drives.transmission import Drive, PrescribedSpeed
from .driven_press import DrivenPress, not_positive
from .mesh import TO_REST, Grid, Indices, Push
from .reduced_model import rule

ROUNDS = 30
SETTLED = 1e-10  # change of the kinetic energy in a round, beside the energy; Newton's method squares it, and its error is 1e-17
FLOOR = 1e-6  # kinetic energy, beside the first, below which no speed is taken from it
STIFF = 2.0  # change of the force by the kinetic energy over half a panel, above which the panel's equations are solved as they are
CLOSE = 1e-3  # change of the kinetic energy in a round, beside the energy, from which the slopes of the forces are kept
FURTHEST = 100.0  # times the kinetic energy before, that a round may go


@dataclass(frozen=True, eq=False, repr=False)
class Flow:
    """A period, or a part of it, solved for S scenarios.

    Attributes:
        grid: its panels.
        energy: (q, p, S) kinetic energy W at the nodes, ends: (p + 1, S) at the borders [J].
        speed: (q, p, S) size of the crank's speed [rad/s], of no meaning where W is below the floor.
        force: (q, p, S) dW/du; driving, resisting: parts of it, of the drive and of the loads [N m].
        held: whether no force depends on the speed, so that W is right beyond a stop too.
        stiffness: (p,) by how many e-folds a disturbance of W dies away on half a panel; 0 where the drive is not stiff.
        settled: (S,) panels on which Newton's method has found W: all, or those before the crank all but stops.
        added: inertia of flywheel and drive, of the first scenario [kg m2]. evaluations: of the forces, nodes counted.
    """

    grid: Grid
    energy: Array
    ends: Array
    speed: Array
    force: Array
    driving: Array
    resisting: Array
    held: bool
    stiffness: Array
    settled: Indices
    added: float
    evaluations: int


def flow(driven: DrivenPress, grid: Grid, energy: Array, guess: Array | None = None, periodic: bool = False) -> Flow:
    """Kinetic energy over a grid, from ``energy`` (S,) at its start; or that of a ``periodic`` motion, near this energy, which ends with
    the energy with which it began.

    Raises:
        SimulationError: the inertia is not positive somewhere.
    """
    q, p = grid.angle.shape
    shape = (q, p, len(energy))
    inertia = grid.inertia[:, :, None] + driven.inertia
    if not inertia.min() > 0:
        worst = np.unravel_index(int(inertia.min(axis=2).argmin()), (q, p))
        raise not_positive(float(inertia.min()), None, float(grid.angle[worst]))
    drive, added = driven.drive, float(np.ravel(driven.inertia)[0])
    if driven.prescribed is not None:
        return _prescribed(driven, grid, inertia, driven.prescribed)
    forces = Forces(drive, grid, shape)

    def result(work: Array, held: bool, settled: Indices, ends: Array | None = None, force: Array | None = None) -> Flow:
        if ends is None or force is None:
            force = forces.driving + forces.resisting + grid.weight[:, :, None]
            work, ends = _integral(grid, forces.driving + forces.resisting, grid.weight[:, :, None], energy)
        else:  # of a stiff drive the torque that moves the press, not that of a speed which rounding has changed
            forces.driving = force - forces.resisting - grid.weight[:, :, None]
        least = np.finfo(float).tiny if held else floor  # before a stop W is small, and right
        speed = np.sqrt(2 * np.maximum(work, least) / inertia)
        count = forces.asked * work.size
        return Flow(grid, work, ends, speed, force, forces.driving, forces.resisting, held, stiffness, settled, added, count)

    every = np.full(len(energy), p)
    work = np.broadcast_to(energy, shape) if guess is None else guess
    # fixed, as far from the solution W may rise without bounds
    floor = FLOOR * work.max(axis=(0, 1)) + np.finfo(float).tiny
    rate, moved, ends, force, stiffness = None, np.full((p, len(energy)), np.inf), None, None, np.zeros(p)
    for _ in range(ROUNDS):
        above = np.maximum(work, floor)
        speed = np.sqrt(2 * above / inertia)
        total = forces.at(speed)
        if drive is None and not grid.pushes:
            return result(work, True, every)
        # Newton: dW/du = G + K (W_new - W); K by a difference, as it only has to lead there, and not anew close to the end
        if rate is None or moved.max() > CLOSE:
            change = forces.faster(speed, 1e-7)
            if not change.any():  # here; but also at the speeds that come of these forces, and next to a stop?
                found = result(work, True, every)
                if np.array_equal(forces.at(found.speed), total):
                    stopping = grid.kinds.any() or not found.ends.min() > 0
                    # of a periodic motion too: it does not come back, whatever its speed
                    return replace(found, held=bool(np.array_equal(forces.at(0.0 * speed), total))) if stopping else found
                work, rate = np.maximum(found.energy, above / FURTHEST), None
                continue
            rate = change / (2e-7 * above)
            stiffness = np.abs(rate * grid.measure[:, :, None]).max(axis=(0, 2))
            stiffness *= stiffness.max() > STIFF
        before = work
        total += grid.weight[:, :, None]
        total -= rate * before
        with np.errstate(all="ignore"):  # far from the solution it may overshoot without bounds
            work, ends, force = (_solved if stiffness.any() else _factored)(grid, total, rate, energy, periodic)
            energy = ends[0]
        if not np.isfinite(work.sum()):
            work = np.where(np.isfinite(work), work, above)
        work = np.minimum(np.maximum(work, above / FURTHEST), above * FURTHEST)
        last, moved = moved, np.abs(work - before).max(axis=0) / np.maximum(work.max(axis=0), energy)
        if moved.max() <= SETTLED and not (
            stiffness.any() and moved.max() < 0.5 * last.max()
        ):  # a stiff drive feels the last digit of the speed
            break
    # what comes later does not matter to what comes before: the first panels may be right where the last ones are not
    unsettled = moved > SETTLED
    forces.at(np.sqrt(2 * np.maximum(work, floor) / inertia))
    settled = np.where(unsettled.any(axis=0), unsettled.argmax(axis=0), p)
    return result(work, False, settled, ends, force) if stiffness.any() else result(work, False, settled)


class Forces:
    """Forces of drive and loads on a grid, along the travel, at changing speeds. Those of loads that know no speed are worked out once.

    Attributes:
        driving, resisting: (q, p, S) as last worked out [N m]. asked: how often.
    """

    def __init__(self, drive: Drive | None, grid: Grid, shape: tuple[int, ...]) -> None:
        self.drive, self.grid, self.asked = drive, grid, 0
        self.driving, self.resisting = np.zeros(shape), np.zeros(shape)
        self.steady = not grid.pushes

    def at(self, speed: Array) -> Array:
        """Sum of the forces at sizes of the crank's speed (q, p, S)."""
        self.driving = self._driving(speed)
        if not self.steady:
            self.resisting = self._resisting(speed)
        self.asked += 1
        return np.asarray(self.driving + self.resisting)

    def faster(self, speed: Array, share: float) -> Array:
        """Change of the sum where the crank is faster by a share than when it was last worked out."""
        higher = speed * (1 + share)
        change = self._driving(higher) - self.driving
        if not self.steady:
            resisting = self._resisting(higher)
            self.steady = bool(np.array_equal(resisting, self.resisting))
            if not self.steady:
                change += resisting - self.resisting
        self.asked += 1
        return np.asarray(change)

    def _driving(self, speed: Array) -> Array:
        if self.drive is None:
            return np.zeros_like(self.driving)
        torque = np.asarray(self.drive.torque(self.grid.direction * speed))
        signed = torque if self.grid.direction > 0 else -torque
        return signed if signed.shape == speed.shape else signed + np.zeros_like(self.driving)

    def _resisting(self, speed: Array) -> Array:
        result = np.zeros_like(self.driving)
        for push in self.grid.pushes:
            result[:, push.panels] += _pushed(self.grid, push, self.grid.direction * speed)
        return result


def _pushed(grid: Grid, push: Push, speed: Array) -> Array:
    """Force of a push along the travel (q, its panels, S) [N m], at the crank's speeds (q, p, S)."""
    position = grid.position[push.row][:, push.panels, None] - push.datum
    lever = grid.lever[push.row][:, push.panels, None]
    force = push.stretch.force(position, lever * speed[:, push.panels])
    if push.stretch.one_sided:
        force = np.maximum(force, 0.0)
    return np.asarray(grid.direction * lever * force)


def _prescribed(driven: DrivenPress, grid: Grid, inertia: Array, drive: PrescribedSpeed) -> Flow:
    """The flow at a constant speed, with the torque that this takes."""
    speed = np.full(inertia.shape, abs(drive.speed))
    work = 0.5 * inertia * speed**2
    resisting = np.zeros(inertia.shape)
    for push in grid.pushes:
        resisting[:, push.panels] += _pushed(grid, push, grid.direction * speed)
    force = 0.5 * grid.direction * grid.slope[:, :, None] * speed**2
    driving = force - resisting - grid.weight[:, :, None]
    ends = np.full((len(grid.borders), 1), work.max())
    return Flow(
        grid,
        work,
        ends,
        speed,
        force,
        driving,
        resisting,
        True,
        np.zeros(len(grid.kinds)),
        np.full(1, len(grid.kinds)),
        float(driven.inertia),
        work.size,
    )


def _integral(grid: Grid, force: Array, weight: Array, energy: Array) -> tuple[Array, Array]:
    """W at the nodes (q, p, S) and borders (p + 1, S) from the force (q, p, S) of drive and loads and that of weights (q, p, 1).

    Of a crank that turns, weights put in the difference of their potential energy, not the integral of their force: it is the same in every
    turn. From rest and to rest W must be right beside itself where it is small: there all is integrated, away from the rest.
    """
    r = rule()
    q, p, count = force.shape
    rests = bool(grid.kinds.any())
    inner = (force + weight if rests else force) * grid.measure[:, :, None]
    flat = inner.reshape(q, p * count)
    totals = (r.weights @ flat).reshape(p, count)
    ends = np.concatenate([energy[None], totals]).cumsum(axis=0)
    within = (r.cumulative @ flat).reshape(q, p, count)
    work = ends[:-1] + within
    if not rests:
        work -= grid.lifted[:, :, None]
        ends -= grid.lifted_ends[:, None]
    elif grid.kinds[-1] == TO_REST:
        back = np.concatenate([-totals[::-1].cumsum(axis=0)[::-1], np.zeros((1, count))])
        half = int(ends[:, 0].argmax())
        left = ((r.weights - r.cumulative) @ flat).reshape(q, p, count)
        work[:, half:], ends[half + 1 :] = (back[1:] - left)[:, half:], back[half + 1 :]
    return work, ends


def _factored(grid: Grid, constant: Array, rate: Array, energy: Array, periodic: bool) -> tuple[Array, Array, None]:
    """W (q, p, S) from dW/du = constant + rate W by an integrating factor, for all scenarios in few operations; its values (p + 1, S) at
    the borders; and no force. At the start W is ``energy``, or where it is ``periodic`` what it is at the end.

    On every panel W is a part of its own, plus a growth times its value at the start.
    """
    r = rule()
    q, p, count = constant.shape
    flat = (rate * grid.measure[:, :, None]).reshape(q, p * count)
    growth, final = np.exp(r.cumulative @ flat).reshape(q, p, count), np.exp(r.weights @ flat).reshape(p, count)
    scaled = (constant * grid.measure[:, :, None] / growth).reshape(q, p * count)
    ends = _along(final * (r.weights @ scaled).reshape(p, count), final, energy, periodic)
    return np.asarray(growth * (ends[:-1] + (r.cumulative @ scaled).reshape(q, p, count))), ends, None


def _solved(grid: Grid, constant: Array, rate: Array, energy: Array, periodic: bool) -> tuple[Array, Array, Array]:
    """W likewise from the collocation equations of every panel, for drives so stiff that an integrating factor is no polynomial; and the
    force dW/du (q, p, S) that solves them: worked out from W it would be that of its last digit.
    """
    r, measure = rule(), grid.measure.T[:, None]
    exponents = np.moveaxis(rate, 0, -1) * measure  # (p, S, q)
    right = np.stack([np.moveaxis(constant, 0, -1) * measure, exponents], axis=-1)
    try:
        parts = np.linalg.solve(np.eye(len(r.nodes)) - exponents[..., None] * r.cumulative, right)
    except np.linalg.LinAlgError:
        parts = np.full(right.shape, np.nan)
    own, growth = parts[..., 0], parts[..., 1]
    ends = _along(own @ r.weights, 1 + growth @ r.weights, energy, periodic)
    gained = own + growth * ends[:-1, :, None]
    work = ends[:-1, :, None] + gained @ r.cumulative.T
    return np.moveaxis(work, -1, 0), ends, np.moveaxis(gained / measure, -1, 0)


def _along(gained: Array, final: Array, energy: Array, periodic: bool) -> Array:
    """W (p + 1, S) at the borders, from what panels (p, S) gain, and by how much they multiply what is there at their start."""
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
