"""Any linkage, one configuration at a time, by Pinocchio's constraint models and recursive Newton-Euler algorithm.

The general path, and the judge of the planar one. A loop pin is a `PointAnchorConstraintModel`; its three rows are turned into world axes.
Redundant rows are allowed: rank is found from singular values, and forces that rigid mechanics does not decide are chosen as those with the
least sum of squared bearing forces.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from .branch import Closure
from .coordinates import Array, Axis, Slot, axes, configuration, crank_angle, slots
from .errors import AssemblyError
from .loads import AppliedForce
from .plane import LoopPin
from .wrenches import Wrenches

RANK = 1e-9  # singular values below this share of the largest are zero, columns scaled to unit length
MOST_NEWTON_STEPS = 12
LOOSEST = 1e-6  # gap, in lengths of the linkage, beyond which a motion is another linkage's


@dataclass(frozen=True, eq=False, repr=False)
class Spatial:
    """Constants of a linkage for this engine.

    Attributes:
        model: the Pinocchio model. loops: in declared order. driver: index of the driver joint in v.
        crossed: (nv, nl) +1 / -1 where loop l's point 2 / 1 hangs on joint j.
        share: (3 nv + 3 nl, 3 nl) what loop forces add to the forces of all joints and loops.
        size: length of the linkage [m]. tolerance: gap at which a loop is closed to rounding [m].
        slots, axes: of the joints.
    """

    model: pin.Model
    loops: tuple[LoopPin, ...]
    driver: int
    crossed: Array
    share: Array
    size: float
    tolerance: float
    slots: tuple[Slot, ...]
    axes: tuple[Axis, ...]


def build(model: pin.Model, loops: Sequence[LoopPin], driver: int) -> Spatial:
    """Constants of a linkage."""
    size, reach = _extent(model, loops)
    crossed = np.zeros((model.nv, len(loops)))
    for k, loop in enumerate(loops):
        for joint, sign in ((loop.joint2, 1.0), (loop.joint1, -1.0)):
            while joint > 0:
                crossed[joint - 1, k] += sign
                joint = model.parents[joint]
    return Spatial(
        model=model,
        loops=tuple(loops),
        driver=driver,
        crossed=crossed,
        share=np.concatenate([-np.kron(crossed, np.eye(3)), np.eye(3 * len(loops))]),
        size=size,
        tolerance=8 * np.finfo(float).eps * (size + reach),
        slots=slots(model),
        axes=axes(model),
    )


def loop_rows(model: pin.Model, loops: Sequence[LoopPin], x: Array) -> tuple[Array, Array]:
    """Loop gaps (3 nl,) and their Jacobian (3 nl, nv) at joint coordinates (nv,), world axes: point 2 minus point 1."""
    return _Anchors(model, loops).rows(configuration(slots(model), x))


def mobility(columns: Array) -> int:
    """Degrees of freedom left by a loop Jacobian (rows, nv): nv less its rank."""
    values = singular_values(columns)
    return int(columns.shape[1] - np.count_nonzero(values > RANK * max(1.0, values.max(initial=0.0))))


def singular_values(columns: Array) -> Array:
    """Of a loop Jacobian (rows, columns), largest first, its columns scaled to unit length."""
    return np.asarray(np.linalg.svd(_unit_columns(columns)[0], compute_uv=False))


def close(spatial: Spatial, angle: Array, guess: Array) -> Closure:
    """Close all loops at crank angles (n,) by Newton's method from guesses (nv, n), with margins; see `plane_kinematics.close`."""
    anchors = _Anchors(spatial.model, spatial.loops)
    results = [_close_one(spatial, anchors, float(angle[i]), guess[:, i]) for i in range(len(angle))]
    position, first, second = (np.array([r[k] for r in results]).T.reshape(guess.shape) for k in range(3))
    gap, steps, margin = (np.array([r[k] for r in results]) for k in (3, 4, 5))
    return Closure(position, first, second, gap, float(gap.max()), int(steps.max(initial=0)), margin[None, :])


def inverse_dynamics(spatial: Spatial, q: Array, v: Array, a: Array, loads: Sequence[AppliedForce]) -> Wrenches:
    """Driving torque and the wrench of every joint and loop; arguments as `plane_dynamics.inverse_dynamics`."""
    model, count, bearings = spatial.model, spatial.model.nv, spatial.model.nv + len(spatial.loops)
    n = v.shape[1]
    result = Wrenches.zeros(bearings, n)
    anchors = _Anchors(model, spatial.loops)
    data = anchors.data
    placements, wrenches = data.oMi, data.f  # live: fetching them again costs more than the algorithm that fills them
    for i in range(n):
        at = np.ascontiguousarray(q[:, i])
        gaps, columns = anchors.rows(at)
        if not np.abs(gaps).max(initial=0.0) <= LOOSEST * spatial.size:
            angle = crank_angle(spatial.slots[spatial.driver], at)
            widest = float(np.linalg.norm(gaps.reshape(-1, 3), axis=1).max())
            raise AssemblyError("the motion leaves the loops of this linkage open: it is another one's", angle, widest, 0)
        rotations = [placement.rotation for placement in placements]
        rates, accelerations = v[:, i].copy(), a[:, i].copy()
        applied = [(load.joint, load.point, load.force[i]) for load in loads]
        effort = pin.rnea(model, data, at, rates, accelerations, _external(rotations, applied))
        carried = np.concatenate([rotations[j + 1] @ wrenches[j + 1].linear for j in range(count)])
        pins = _solve_pins(spatial, columns, effort, carried)
        result.torque[i] = effort[spatial.driver] - columns[:, spatial.driver] @ pins.ravel()
        forces = [(loop.joint2, loop.point2, pins[k]) for k, loop in enumerate(spatial.loops)]
        forces += [(loop.joint1, loop.point1, -pins[k]) for k, loop in enumerate(spatial.loops)]
        pin.rnea(model, data, at, rates, accelerations, _external(rotations, forces + applied))
        result.force[count:, i] = pins
        for j in range(count):
            wrench = wrenches[j + 1]
            result.force[j, i] = rotations[j + 1] @ wrench.linear
            result.moment[j, i] = rotations[j + 1] @ wrench.angular
    return result


def indeterminate(spatial: Spatial, q: Array) -> NDArray[np.bool_]:
    """Components (bearings, 6) that loop forces which move nothing reach in any configuration (nq, n); see `Reactions.indeterminate`."""
    count = len(spatial.crossed)
    marks = np.zeros((count + len(spatial.loops), 6), dtype=bool)
    anchors = _Anchors(spatial.model, spatial.loops)
    placements = anchors.data.oMi
    for at in np.ascontiguousarray(q.T):
        _, columns = anchors.rows(at)
        idle = _Passive(columns, spatial.driver).idle
        if not idle.shape[1]:
            continue
        marks[:, :3] |= (np.abs(spatial.share @ idle).max(axis=1) > RANK).reshape(-1, 3)
        points = [placements[loop.joint1].act(loop.point1) for loop in spatial.loops]
        for j, crossed in enumerate(spatial.crossed):
            moments = np.zeros((3, idle.shape[1]))
            for k in map(int, np.flatnonzero(crossed)):
                arm = points[k] - placements[j + 1].translation
                moments += crossed[k] * (pin.skew(arm) @ idle[3 * k : 3 * k + 3])
            marks[j, 3:] |= np.abs(moments).max(axis=1) > RANK * spatial.size
    return marks


def power_balance(spatial: Spatial, q: Array, v: Array, a: Array, torque: Array, loads: Sequence[AppliedForce]) -> tuple[Array, Array]:
    """As `plane_dynamics.power_balance`, body by body from Pinocchio's forward kinematics."""
    model, data = spatial.model, spatial.model.createData()
    gravity = model.gravity.linear
    balance, total = np.empty(v.shape[1]), np.empty(v.shape[1])
    for i in range(v.shape[1]):
        pin.forwardKinematics(model, data, np.ascontiguousarray(q[:, i]), v[:, i].copy(), a[:, i].copy())
        powers = [torque[i] * v[spatial.driver, i]]
        for j in range(1, model.njoints):
            inertia, velocity = model.inertias[j], data.v[j]
            momentum_rate = inertia * data.a[j] + velocity.cross(inertia * velocity)
            lifted = data.oMi[j].rotation @ (velocity.linear + np.cross(velocity.angular, inertia.lever))
            powers += [inertia.mass * float(gravity @ lifted), -momentum_rate.dot(velocity)]
        for load in loads:
            if load.joint:
                velocity = data.v[load.joint]
                moved = data.oMi[load.joint].rotation @ (velocity.linear + np.cross(velocity.angular, load.point))
                powers.append(float(load.force[i] @ moved))
        balance[i], total[i] = np.sum(powers), np.sum(np.abs(powers))
    return balance, total


class _Anchors:
    """Constraint models and datas of the loops. Built for each call, because they neither copy nor pickle."""

    def __init__(self, model: pin.Model, loops: Sequence[LoopPin]) -> None:
        self.model, self.data = model, model.createData()
        self.models = [
            pin.PointAnchorConstraintModel(model, k.joint1, pin.SE3(np.eye(3), k.point1), k.joint2, pin.SE3(np.eye(3), k.point2))
            for k in loops
        ]
        self.datas = [m.createData() for m in self.models]

    def rows(self, q: Array) -> tuple[Array, Array]:
        """Gaps (3 nl,) and Jacobian (3 nl, nv) at a configuration (nq,), world axes."""
        pin.computeJointJacobians(self.model, self.data, q)
        gaps, columns = np.empty(3 * len(self.models)), np.empty((3 * len(self.models), self.model.nv))
        for k, (m, d) in enumerate(zip(self.models, self.datas, strict=True)):
            m.calc(self.model, self.data, d)
            rotation = d.oMc1.rotation
            gaps[3 * k : 3 * k + 3] = rotation @ d.constraint_position_error
            columns[3 * k : 3 * k + 3] = rotation @ m.jacobian(self.model, self.data, d).reshape(3, self.model.nv)
        return gaps, columns

    def drift(self, q: Array, v: Array) -> Array:
        """Second derivative (3 nl,) of the gaps at joint rates (nv,) and no joint acceleration, world axes."""
        pin.forwardKinematics(self.model, self.data, q, v, np.zeros(self.model.nv))
        result = np.empty(3 * len(self.models))
        for k, (m, d) in enumerate(zip(self.models, self.datas, strict=True)):
            m.calc(self.model, self.data, d)
            result[3 * k : 3 * k + 3] = d.oMc1.rotation @ d.constraint_acceleration_error
        return result


def _close_one(spatial: Spatial, anchors: _Anchors, angle: float, guess: Array) -> tuple[Array, Array, Array, float, int, float]:
    x = guess.copy()
    x[spatial.driver] = angle
    worst, steps = np.inf, 0
    while True:
        q = configuration(spatial.slots, x)
        gaps, columns = anchors.rows(q)
        before, worst = worst, float(np.linalg.norm(gaps.reshape(-1, 3), axis=1).max(initial=0.0))
        stalled = worst > 0.5 * before and worst < 1e3 * spatial.tolerance
        if not np.all(np.isfinite(columns)):
            return x, np.full_like(x, np.nan), np.full_like(x, np.nan), np.inf, steps, 0.0
        passive = _Passive(columns, spatial.driver)
        if worst <= spatial.tolerance or stalled or steps == MOST_NEWTON_STEPS:
            break
        x += passive.rates(-gaps)
        steps += 1
    first = passive.rates(-columns[:, spatial.driver])
    first[spatial.driver] = 1.0
    second = passive.rates(-anchors.drift(q, first))
    return x, first, second, worst, steps, passive.margin()


class _Passive:
    """Singular value decomposition of the passive columns of a loop Jacobian, scaled to unit length."""

    def __init__(self, columns: Array, driver: int) -> None:
        self.rest = np.array([j for j in range(columns.shape[1]) if j != driver], dtype=int)
        self.scaled, self.lengths = _unit_columns(columns[:, self.rest])
        self.left, self.values, self.right = np.linalg.svd(self.scaled, full_matrices=True)
        self.rank = int(np.count_nonzero(self.values > RANK * max(1.0, self.values.max(initial=0.0))))

    def rates(self, target: Array) -> Array:
        """Joint rates (nv,), the driver's zero, that move the loops by ``target`` (rows,) in the least-squares sense."""
        r = self.rank
        result = np.zeros(len(self.rest) + 1)
        result[self.rest] = self.right[:r].T @ ((self.left[:, :r].T @ target) / self.values[:r]) / self.lengths
        return result

    def multipliers(self, effort: Array) -> Array:
        """Least-norm loop forces (rows,) that balance the passive efforts (nv - 1,)."""
        r = self.rank
        return np.asarray(self.left[:, :r] @ ((self.right[:r] @ (effort / self.lengths)) / self.values[:r]))

    @property
    def idle(self) -> Array:
        """Basis (rows, k) of the loop forces that move nothing."""
        return np.asarray(self.left[:, self.rank :])

    def margin(self) -> float:
        """`Closure.margins` of the whole linkage, without a sign: redundant rows have no determinant."""
        count = len(self.rest)
        if count == 0:
            return 1.0
        return float(self.values[count - 1]) if len(self.values) >= count else 0.0


def _solve_pins(spatial: Spatial, columns: Array, effort: Array, carried: Array) -> Array:
    """Loop pin forces (nl, 3) in world axes, so that no passive joint transmits a generalised force."""
    passive = _Passive(columns, spatial.driver)
    pins, idle = passive.multipliers(effort[passive.rest]), passive.idle
    if idle.shape[1]:
        # forces of joints, then pins: (carried, 0) + share (pins + idle y); of all y, the one with the least sum of squares
        response = spatial.share @ idle
        start = spatial.share @ pins
        start[: carried.size] += carried
        # the normal equations serve: the pins' own forces are among the squares, so their matrix is the unit matrix or more
        pins = pins - idle @ np.linalg.solve(response.T @ response, response.T @ start)
    return pins.reshape(-1, 3)


def _external(rotations: list[Array], forces: Sequence[tuple[int, Array, Array]]) -> pin.StdVec_Force:
    """World forces at points of joints' bodies as Pinocchio's external forces in joint frames, which are so rotated."""
    wrenches = [np.zeros(6) for _ in rotations]
    for joint, point, force in forces:
        local = rotations[joint].T @ force
        wrenches[joint][:3] += local
        wrenches[joint][3:] += pin.skew(point) @ local
    return pin.StdVec_Force([pin.Force(w) for w in wrenches])


def _unit_columns(columns: Array) -> tuple[Array, Array]:
    lengths = np.linalg.norm(columns, axis=0)
    lengths[lengths == 0.0] = 1.0
    return columns / lengths, lengths


def _extent(model: pin.Model, loops: Sequence[LoopPin]) -> tuple[float, float]:
    """Largest extent of joints and loop points in the drawn pose, and their largest distance from the world origin [m]."""
    data = model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model))
    points = [data.oMi[j].translation.copy() for j in range(1, model.njoints)]
    points += [data.oMi[k.joint1].act(k.point1) for k in loops] + [data.oMi[k.joint2].act(k.point2) for k in loops]
    cloud = np.array(points)
    size = float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0)))
    return size or 1.0, float(np.linalg.norm(cloud, axis=1).max())
