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
anything and a_e by efforts, the torques follow from G (a_x + a_e G' y_x) = 0.

Where rows are redundant the multipliers are those of least size, l = P l with the projector P on the range of J. Their derivative is
P l_x + (1 - P) (dJ/dx) w with w such that J w = l. J w is the velocity of the points at rates w, whose derivative Pinocchio has too.
"""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ...common.errors import PinpressError, SingularityError
from ...common.quantities import Array
from .forward_dynamics import ForwardDynamics

ITERATIONS = 34  # proximal iterations: each leaves a third of the error at most
CLEAR = 1e-7  # share of the largest eigenvalue of J M^-1 J' above which one is clearly not zero


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
            gears: (couplings, nv) rows G of the gear pairs, 1 at the follower.

        Raises:
            PinpressError: the linkage does not suit Pinocchio's constraint dynamics.
        """
        if dynamics.ends and dynamics.proximal is None:
            raise PinpressError(
                f"Pinocchio's constraint dynamics, whose derivatives these are, does not suit {dynamics.name}: a joint moves no mass, or a"
                " gear pair keeps a ratio that the loops keep too; take differences of press.forward_dynamics(...).acceleration"
            )
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
        self.rank = dynamics.rank - len(gears)  # of the points' rows
        self.settings = pin.ProximalSettings()  # those of a state, see `at`

    def at(self, x: Array, v: Array, efforts: Array) -> AccelerationDerivatives:
        """The derivatives at a closed state: joint coordinates, rates and efforts (nv,).

        Raises:
            SingularityError: the loops lose equations there.
            PinpressError: a state that is not finite, or too fast for floating point.
        """
        self.dynamics.acceleration_in_null_space(x, v, efforts)  # raises where it is singular, massless or not finite
        jacobian = self._jacobian(x)
        self.settings = pin.ProximalSettings(0.0, 0.0, self._damping(x, jacobian), ITERATIONS)
        gears = self.gears
        acceleration, multipliers, derivatives = self._without_gears(x, v, efforts)
        torques: Array = np.zeros(len(gears))
        into: list[Array] = [np.zeros((len(gears), len(x)))] * 3
        if len(gears):
            answer = derivatives[2] @ gears.T  # of accelerations and multipliers to the gear pairs' torques
            answered = gears @ answer[: len(x)]
            torques = np.asarray(-np.linalg.solve(answered, gears @ acceleration))
            acceleration, multipliers, derivatives = self._without_gears(x, v, efforts + gears.T @ torques)
            into = [np.asarray(-np.linalg.solve(answered, gears @ each[: len(x)])) for each in derivatives]
            derivatives = [each + answer @ moved for each, moved in zip(derivatives, into, strict=True)]
        self._take_least(x, jacobian, multipliers, derivatives)
        if not np.isfinite([np.sum(each) for each in (acceleration, multipliers, *derivatives, *into)]).all():
            raise self.dynamics.overflow(x)
        return AccelerationDerivatives(
            acceleration,
            np.concatenate([multipliers, torques]),
            *(np.concatenate([each, moved]) for each, moved in zip(derivatives, into, strict=True)),
        )

    def _damping(self, x: Array, jacobian: Array) -> float:
        """The proximal parameter mu at a position (nv,), half the smallest eigenvalue of J M^-1 J' that is not zero [1/kg]; ``jacobian``:
        (rows, nv) J there.

        Raises:
            SingularityError: the loops nearly lose an equation there.
        """
        if not self.rank:
            return 1.0
        dynamics = self.dynamics
        mass = pin.crba(dynamics.model, dynamics.data, x)
        root = np.linalg.solve(np.linalg.cholesky(np.triu(mass) + np.triu(mass, 1).T), jacobian.T)
        sizes = np.linalg.svd(root, compute_uv=False) ** 2
        if not sizes[self.rank - 1] > CLEAR * sizes[0]:
            problem = f"the loops of {dynamics.name} nearly lose an equation: derivatives would be lost in rounding"
            raise SingularityError(problem, float(x[dynamics.driver]), float(sizes[self.rank - 1] / sizes[0]), dynamics.coordinate)
        return 0.5 * float(sizes[self.rank - 1])

    def _without_gears(self, x: Array, v: Array, efforts: Array) -> tuple[Array, Array, list[Array]]:
        """Acceleration (nv,), multipliers (rows,), and the derivatives of both (nv + rows, nv) by position, rate and effort."""
        own = np.zeros(1)
        model, data, points, data_of_points, settings = self.model, self.data, self.points, self.data_of_points, self.settings
        state = [np.concatenate([own, values]) for values in (x, v, efforts)]
        acceleration = np.array(pin.constraintDynamics(model, data, *state, points, data_of_points, settings))[1:]
        multipliers = self.signs * np.array([each.contact_force.linear for each in data_of_points]).reshape(-1)
        found = pin.computeConstraintDynamicsDerivatives(model, data, points, data_of_points, settings)
        of_acceleration, of_multipliers = ([np.array(each) for each in found[k : k + 3]] for k in (0, 3))
        derivatives = [
            np.concatenate([a[1:, 1:], self.signs[:, None] * m.reshape(-1, model.nv)[:, 1:]])
            for a, m in zip(of_acceleration, of_multipliers, strict=True)
        ]
        return acceleration, multipliers, derivatives

    def _take_least(self, x: Array, jacobian: Array, multipliers: Array, derivatives: list[Array]) -> None:
        """Replace the points' multipliers, and their derivatives, by those of least squares."""
        if not len(multipliers):
            return
        count, rank, units = len(x), self.rank, self.dynamics.units
        left, sizes, right = np.linalg.svd(jacobian / units, full_matrices=False)
        held, motions = left[:, :rank], right[:rank].T / units[:, None] / sizes[:rank]
        multipliers[:] = held @ (held.T @ multipliers)
        turned = self._velocity_by_position(x, motions @ (held.T @ multipliers))
        for each in derivatives:
            each[count:] = held @ (held.T @ each[count:])
        derivatives[0][count:] += turned - held @ (held.T @ turned)

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
