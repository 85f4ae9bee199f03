"""Derivatives of the accelerations and multipliers of a linkage by Pinocchio's `computeConstraintDynamicsDerivatives`, one state at a time.

What is differentiated are the accelerations a and multipliers l of

    M(q) a + h(q, v) = efforts + J(q)' l,        J(q) a + dJ/dt v = 0

at the points at which loops are held (see `model.held_points`), world axes, and then of gear pairs.

Two faults of Pinocchio 4.1 are kept out. The derivative by q has a wrong first column wherever a loop joins two moving bodies, or ends on
the frame: the list of columns that a loop spans (`loop_span_indexes` of `RigidConstraintModel`) begins with as many zeros as the model has
rates, and for each of them a term of rotating loop forces is put into the first column once more. With a body of its own on the frame as
the first one the wrong column is this body's, which moves nothing else. The derivatives by rates and efforts are right with and without
it. And where side 1 of a constraint is the frame, its Jacobian is added to that of the call before, so that side 1 is always a body that
moves.

Gear pairs are linear equations G a = 0, whose torques y are efforts G' y. With the derivatives of a linkage without gear pairs, a_x by
anything and a_e by efforts, the torques follow from G (a_x + a_e G' y_x) = 0. Of gear pairs whose ratios the loops keep too, only as many
are taken as the loops leave free in a state: at a dead centre they may hold what loops hold elsewhere.

Where rows are redundant the multipliers are those of least size, l = P l with the projector P on the range of the rows J of points and gear
pairs. Their derivative is P l_x + (1 - P) (dJ/dx) w with w such that J w = l. J w is the velocity of the points at rates w, whose
derivative Pinocchio has too. A torque counts as the force that it is at the length of the linkage.
"""

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...common.errors import PinpressError, SingularityError
from ...common.quantities import Array
from ..rank import rank
from .forward_dynamics import ForwardDynamics

ITERATIONS = 34  # proximal iterations: each leaves a third of the error at most
# Share of the largest eigenvalue of J M^-1 J' above which one counts: less would cost digits, and more is left unheld beside a dead centre.
CLEAR = 1e-8


class AccelerationDerivatives(NamedTuple):
    """Accelerations and multipliers at one state, and their derivatives.

    Attributes:
        acceleration: (nv,).
        multipliers: (rows,) three forces for each point, link1 on link2, world axes [N]; then the torques of gear pairs on their followers
            [N m; N at one that slides].
        by_position: (nv + rows, nv) of acceleration, then multipliers.
        by_rate: (nv + rows, nv).
        by_effort: (nv + rows, nv).
    """

    acceleration: Array
    multipliers: Array
    by_position: Array
    by_rate: Array
    by_effort: Array


class ForwardDerivatives:
    """Derivatives of one linkage's forward dynamics. It holds Pinocchio's data; one thread may use it at a time."""

    def __init__(self, dynamics: ForwardDynamics, gears: Array) -> None:
        """
        Args:
            dynamics: of the linkage.
            gears: (relations, nv) rows G of the gear pairs, 1 at the follower.
        """
        self.dynamics, self.gears = dynamics, gears
        self.model = _behind_another_body(dynamics.model)
        self.data = self.model.createData()
        # side 1 must move, see the module
        ends = [(one, place1, two, place2) if one else (two, place2, one, place1) for one, place1, two, place2 in dynamics.ends]
        self.signs = np.repeat([-1.0 if one else 1.0 for one, *_ in dynamics.ends], 3)  # a contact's force acts on side 1
        self.points = pin.StdVec_RigidConstraintModel(
            [
                pin.RigidConstraintModel(
                    pin.ContactType.CONTACT_3D, self.model, _shifted(one), place1, _shifted(two), place2, pin.LOCAL_WORLD_ALIGNED
                )
                for one, place1, two, place2 in ends
            ]
        )
        self.data_of_points = pin.StdVec_RigidConstraintData([point.createData() for point in self.points])
        pin.initConstraintDynamics(self.model, self.data, self.points, self.data_of_points)
        # units of the gear pairs' torques: lengths of followers that turn
        self.lengths = np.array([dynamics.units[np.flatnonzero(row == 1.0)[0]] for row in gears])
        self.settings = pin.ProximalSettings()  # those of a state, see `at`

    def at(self, x: Array, v: Array, efforts: Array) -> AccelerationDerivatives:
        """The derivatives at a closed state: joint coordinates, rates and efforts (nv,).

        Raises:
            SingularityError: the loops lose equations there.
            PinpressError: a state that is not finite, or too fast for floating point.
        """
        jacobian = self._jacobian(x)
        span = self._span(x, jacobian)
        held, damping = self._held(x, jacobian)
        self.settings = pin.ProximalSettings(0.0, 0.0, damping, ITERATIONS)
        gears, taken, count = self.gears, self._gears_needed(jacobian, held), len(x)
        acceleration, multipliers, derivatives = self._without_gears(x, v, efforts)
        torques, into = np.zeros(len(gears)), [np.zeros((len(gears), count)) for _ in derivatives]
        if len(gears):
            answer = derivatives[2] @ gears[taken].T  # of accelerations and multipliers to the gear pairs' torques
            answered = gears[taken] @ answer[:count]
            torques[taken] = -np.linalg.solve(answered, gears[taken] @ acceleration)
            held_by = np.concatenate([multipliers + answer[count:] @ torques[taken], torques])
            torques = span.least(held_by)[len(jacobian) :]  # so that what follows begins with multipliers of least size
            acceleration, multipliers, derivatives = self._without_gears(x, v, efforts + gears.T @ torques)
            for k, each in enumerate(derivatives):
                into[k][taken] = -np.linalg.solve(answered, gears[taken] @ each[:count])
                derivatives[k] = each + answer @ into[k][taken]
        multipliers = span.least(np.concatenate([multipliers, torques]))
        derivatives = [
            np.concatenate([each[:count], span.least(np.concatenate([each[count:], moved]))])
            for each, moved in zip(derivatives, into, strict=True)
        ]
        if len(jacobian):
            turned = np.concatenate([self._velocity_by_position(x, span.rates(multipliers)), np.zeros((len(gears), count))])
            derivatives[0][count:] += turned - span.least(turned)
        if not np.isfinite([np.sum(each) for each in (acceleration, multipliers, *derivatives)]).all():
            raise self.dynamics.overflow(x)
        return AccelerationDerivatives(acceleration, multipliers, *derivatives)

    def _held(self, x: Array, jacobian: Array) -> tuple[int, float]:
        """How many equations the points hold at a position (nv,) with the Jacobian (rows, nv), and the proximal parameter mu for them: half
        the smallest eigenvalue of J M^-1 J' that counts [1/kg].

        Raises:
            SingularityError: the loops nearly lose an equation there.
            PinpressError: a joint moves no mass.
        """
        dynamics = self.dynamics
        mass = pin.crba(dynamics.model, dynamics.data, x)
        try:
            root = np.linalg.cholesky((np.triu(mass) + np.triu(mass, 1).T) * dynamics.per_unit * dynamics.column)
        except np.linalg.LinAlgError:
            root = np.zeros((1, 1))
        if not root.diagonal().min() > dynamics.least:
            raise PinpressError(
                f"a joint of {dynamics.name} moves no mass, which Pinocchio's constraint dynamics needs: give mass to its links, or take"
                " differences of press.forward_dynamics(...).acceleration"
            )
        if not len(jacobian):
            return 0, 1.0
        sizes = np.linalg.svd(np.linalg.solve(root, dynamics.column * jacobian.T), compute_uv=False) ** 2
        misfit = dynamics.structure.misfit
        count = rank(jacobian, dynamics.structure.rank_tolerance) if misfit else int(np.count_nonzero(sizes > CLEAR * sizes[0]))
        lost = misfit and sizes[count:].max(initial=0.0) > 1e-4 * sizes[count - 1]  # mu would hold what contradicts the others
        if lost or not dynamics.rank - len(self.gears) <= count <= dynamics.rank:
            problem = f"the loops of {dynamics.name} nearly lose an equation: derivatives would be lost in rounding"
            raise SingularityError(problem, float(x[dynamics.driver]), float(sizes[count - 1] / sizes[0]), dynamics.structure.place(x))
        return count, 0.5 * float(sizes[count - 1])

    def _gears_needed(self, jacobian: Array, held: int) -> NDArray[np.int64]:
        """Which gear pairs keep ratios that the points, holding so many equations, do not: as many as the rank asks for."""
        needed = self.dynamics.rank - held
        if needed == len(self.gears):
            return np.arange(needed, dtype=np.int64)
        from scipy.linalg import qr  # its import takes long

        units = self.dynamics.units
        free = np.linalg.svd(jacobian / units)[2][held:].T
        pivots = qr((self.gears / units @ free).T, mode="r", pivoting=True)[1]
        return np.sort(pivots[:needed]).astype(np.int64)

    def _without_gears(self, x: Array, v: Array, efforts: Array) -> tuple[Array, Array, list[Array]]:
        """Acceleration (nv,), multipliers (rows,), and the derivatives of both (nv + rows, nv) by position, rate and effort."""
        zero = np.zeros(1)
        model, data, points, data_of_points, settings = self.model, self.data, self.points, self.data_of_points, self.settings
        state = [np.concatenate([zero, values]) for values in (x, v, efforts)]
        acceleration = np.array(pin.constraintDynamics(model, data, *state, points, data_of_points, settings))[1:]
        multipliers = self.signs * np.array([each.contact_force.linear for each in data_of_points]).reshape(-1)
        derivatives_of_both = pin.computeConstraintDynamicsDerivatives(model, data, points, data_of_points, settings)
        of_acceleration, of_multipliers = ([np.array(each) for each in derivatives_of_both[k : k + 3]] for k in (0, 3))
        derivatives = [
            np.concatenate([a[1:, 1:], self.signs[:, None] * m.reshape(-1, model.nv)[:, 1:]])
            for a, m in zip(of_acceleration, of_multipliers, strict=True)
        ]
        return acceleration, multipliers, derivatives

    def _span(self, x: Array, jacobian: Array) -> "_Span":
        """What the rows of points, with the Jacobian (rows, nv), and gear pairs determine at a position (nv,).

        Raises:
            SingularityError: they lose equations there.
        """
        units = self.dynamics.units
        scales = np.concatenate([np.ones(len(jacobian)), self.lengths])
        rows = np.concatenate([jacobian, self.gears]) * scales[:, None]
        left, sizes, right = np.linalg.svd(rows / units, full_matrices=False)
        rank, dynamics = self.dynamics.rank, self.dynamics
        if rank and not sizes[rank - 1] > self.dynamics.structure.smallest_margin * sizes[0]:
            problem = f"the loops of {dynamics.name} lose equations: two assemblies meet"
            raise SingularityError(
                problem, float(x[dynamics.driver]), float(sizes[rank - 1] / (sizes[0] or 1.0)), dynamics.structure.place(x)
            )
        return _Span(left[:, :rank], right[:rank].T / units[:, None] / sizes[:rank], scales)

    def _jacobian(self, x: Array) -> Array:
        """(rows, nv) of the points: velocity of point 2 less that of point 1, world axes."""
        pin.computeJointJacobians(self.model, self.data, np.concatenate([np.zeros(1), x]))
        for point, datum in zip(self.points, self.data_of_points, strict=True):
            point.calc(self.model, self.data, datum)
        rows = np.array(pin.getConstraintsJacobian(self.model, self.data, self.points, self.data_of_points)).reshape(-1, self.model.nv)
        return np.asarray(self.signs[:, None] * rows[:, 1:])

    def _velocity_by_position(self, x: Array, rates: Array) -> Array:
        """(rows, nv) derivative by the position of the points' velocities at constant rates (nv,)."""
        coordinates, rates = (np.concatenate([np.zeros(1), values]) for values in (x, rates))
        model, data = self.model, self.data
        pin.constraintDynamics(model, data, coordinates, rates, np.zeros(model.nv), self.points, self.data_of_points, self.settings)
        pin.computeConstraintDynamicsDerivatives(model, data, self.points, self.data_of_points, self.settings)
        return np.asarray(self.signs[:, None] * np.array(data.dvc_dq)[:, 1:])


class _Span(NamedTuple):
    """The range of the rows J of points and gear pairs at a position, as forces: a torque counts at the length of its joint.

    Attributes:
        held: (rows, rank) orthonormal.
        motions: (nv, rank) rates to which the rows answer with each of these.
        scales: (rows,) lengths of the gear pairs' torques [m], 1 for forces.
    """

    held: Array
    motions: Array
    scales: Array

    def least(self, multipliers: Array) -> Array:
        """The multipliers of least size, (rows,) or (rows, k), that act as these do."""
        scales = self.scales.reshape(-1, *[1] * (multipliers.ndim - 1))
        return np.asarray(scales * (self.held @ (self.held.T @ (multipliers / scales))))

    def rates(self, multipliers: Array) -> Array:
        """The joint rates (nv,) at which the rows move as these multipliers (rows,) of least size say."""
        return np.asarray(self.motions @ (self.held.T @ (multipliers / self.scales)))


def _behind_another_body(model: pin.Model) -> pin.Model:
    """The model with a body of its own on the frame as its first; see the module."""
    result = pin.Model()
    result.gravity = model.gravity
    result.addJoint(0, pin.JointModelPX(), pin.SE3.Identity(), "a body of its own")
    result.appendBodyToJoint(1, pin.Inertia(1.0, np.zeros(3), np.eye(3)), pin.SE3.Identity())
    for j in range(1, model.njoints):
        result.addJoint(_shifted(model.parents[j]), model.joints[j], model.jointPlacements[j], model.names[j])
        result.appendBodyToJoint(j + 1, model.inertias[j], pin.SE3.Identity())
    result.armature = np.concatenate([np.zeros(1), model.armature])
    return result


def _shifted(joint: int) -> int:
    """The number of a joint behind the body of its own."""
    return int(joint) + 1 if joint else 0
