"""Forward dynamics of any linkage, one state at a time: accelerations under given joint efforts, and states kept on the loops.

Loops are held at points (see `held_points`), a fixed one at three, so that every gap is a length. There are three rows for every point and
one for every relation.

In general, the transposed Jacobian of these rows is factorised in every state by QR with column pivoting, its rows scaled so that all
joints move in lengths: the pivots are rows of the Jacobian. As many pivot rows as the closed linkage has independent equations determine
all other rows. The rest of the orthogonal factor is a basis N of the motions that the loops allow, and with any a0 that fulfils the rows

    a = a0 + N (N' M N)^-1 N' (efforts - h - M a0),

minimises Gauss's constraint (a - a_free)' M (a - a_free) (Gauss 1829). This way has no multipliers, so that it allows redundant rows, rows
that are redundant in closed states only, and bodies without mass on joints that others move.

Pinocchio's `constraintDynamics` solves the problem with multipliers (the proximal iterations of Carpentier, Budhiraja and Mansard, Proximal
and sparse resolution of constrained dynamic equations, 2021), in less time, as `tests/benchmarks/run.py constraint_dynamics` prints.
It is tried first where every joint moves a mass. The pivots are checked each time, and where one is near zero that should not be, or digits
would be lost, the general way decides.

Loops that hold each other have rows that depend on others in closed states only. In a state that is open by e such a row demands a force of
about 1/e, and moves the linkage by 1: it would be locked. Each proximal iteration brings a row with the eigenvalue s of J M^-1 J' nearer to
its demand by the share mu / (mu + s), and s is e^2 for these rows. So a mu that is far above e^2 and far below all other eigenvalues lets
them go, and holds the others to rounding.

Pinocchio has no constraint model of a gear pair. Accelerations are linear in efforts, so the torques of gear pairs are found as those that
keep the ratios, with one more call for each pair to see what the linkage answers to its torque.
"""

from __future__ import annotations

import contextlib
import math
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from ...common.arguments import suitable_numbers
from ...common.errors import AssemblyError, PinpressError, SingularityError
from ...common.quantities import Array
from ..engine import MOST_NEWTON_STEPS
from ..structure import Axis, Structure, data_of
from .constraint_models import PointPair, held_points

MASSLESS = 1e-13  # share of the largest inertia below which what resists a motion is rounding
CLEAR = 1e-6  # share of the largest pivot (of an inertia's own size) above which a pivot of the quick way is clearly not zero
# Damping of the quick way, as a share of the largest pivot: an iteration leaves at most 1e-4 of the error (PROXIMAL / CLEAR).
PROXIMAL = 1e-10
# Change of the multipliers at which the quick way stops [N], as a share of the weight where the linkage weighs less than 1 N.
SETTLED = 1e-13
ITERATIONS = 6  # most iterations of the quick way: redundant multipliers never settle, though the accelerations have
# The same where loops hold each other: in all 8 iterations the error falls by (HELD_PROXIMAL / HELD_CLEAR)^8 = 1e-12 at least, and loops
# that are a little open, as inside a step, disturb in proportion to their gap (see docs/pinocchio.md).
HELD_PROXIMAL, HELD_CLEAR, HELD_ITERATIONS = 1e-5, 3e-4, 8
MOST_GEAR_PAIRS = 2  # with more the general way is the faster one
CANCELLED = 1e-2  # share of the accelerations without gear pairs, and of what these answer to a torque, below which digits are lost
OPENED = 1e-2  # by which joints are moved to see whether rows become independent [lengths of the linkage]


class ForwardDynamics:
    """Forward dynamics of one linkage. It holds Pinocchio's data, which are made anew for a copy or a pickle; one thread may use it at a
    time.

    Attributes:
        quick: what `constraintDynamics` takes; None if it does not suit the linkage.
        why: words why it is or is not.
        ends: the points at which loops are held.
        quickly: number of accelerations so far that it found.
        generally: number of those that the null space found.

    States are joint coordinates x (nv,) (see `engines.structure`: angles unwrapped [rad], travels [m]) and rates v (nv,) [rad/s, m/s].
    Efforts (nv,) act along the joints, positive as v [N m, N]. Arrays must be float64 of this shape, which is not checked. Results are new.
    NumPy may warn of numbers that are not finite before they are refused, so call the methods under ``np.errstate``.
    """

    def __init__(self, structure: Structure, closed: Array, rank: int, armature: Array, name: str) -> None:
        """
        Args:
            structure: of the linkage; its model is not changed.
            closed: (nv,) joint coordinates of the closed drawn pose.
            rank: rank of the equations there.
            armature: (nv,) inertia that turns with the joints, as of a flywheel or motor, added to the model's own armature [kg m2; kg for
                a joint that slides].
            name: name of the linkage, for errors.

        Raises:
            PinpressError: an armature of another shape, or not finite; a curve that relates joints.
        """
        for k, _ in structure.curves:
            raise PinpressError(
                f"{name} has the cam {structure.relations[k].name!r}, which forward dynamics does not take: simulate it with method='auto'"
            )
        self._made_of = structure, closed, rank, armature, name
        self.name, self.joints, self.driver, self.rank = name, tuple(structure.model.names)[1:], structure.drivers[0], rank
        self.structure = structure
        self.size, self.rounding, self.still = structure.size, structure.rounding, np.zeros(structure.model.nv)
        self._make_tree(structure, armature)
        by_loop = self._held_points(structure, closed)
        ends = [end for held in by_loop for end in held]
        self._make_anchors(ends)
        self._make_rows(structure, [len(held) for held in by_loop])
        mass = pin.crba(self.model, self.data, closed)
        self.least = math.sqrt(MASSLESS * float((mass.diagonal() * self.per_unit**2).max()))
        self.quick, self.why = self._proximal(closed, ends, mass)
        self.ends, self.quickly, self.generally = ends, 0, 0

    def _make_tree(self, structure: Structure, armature: Array) -> None:
        """Pinocchio's model of the tree with the armature, and its data."""
        count = structure.model.nv
        armature = suitable_numbers("armature", armature, f"{count} finite inertias [kg m2]", (count,))
        self.model = _bounded(structure.model, structure.axes)
        self.model.armature = self.armature = np.array(structure.model.armature) + armature
        self.weightless = self.model.copy()
        self.weightless.gravity.setZero()
        self.data = data_of(self.model)
        self.placements = self.data.oMi  # live: fetching it costs more than the algorithm that fills it

    def _held_points(self, structure: Structure, closed: Array) -> list[list[PointPair]]:
        """The points at which each loop is held; see `held_points`."""
        pin.forwardKinematics(self.model, self.data, closed)
        rotations = [placement.rotation for placement in self.placements]
        return [held_points(loop, rotations, self.size) for loop in structure.loops]

    def _make_anchors(self, ends: list[PointPair]) -> None:
        """Pinocchio's constraint models and data of the points, and their gaps and accelerations, which stay live."""
        self.points, self.data_of_points = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
        for end in ends:
            anchor = pin.PointAnchorConstraintModel(self.model, *end)
            self.points.append(pin.ConstraintModel(anchor))
            self.data_of_points.append(pin.ConstraintData(anchor.createData()))
        # Pinocchio's vectors are complete and will not move: what is fetched from them stays live
        self.anchors = [(self.points[k], self.data_of_points[k]) for k in range(len(ends))]
        inner = [datum.extract() for _, datum in self.anchors]
        self.gaps = [datum.constraint_position_error for datum in inner]
        self.drifts = [datum.constraint_acceleration_error for datum in inner]

    def _make_rows(self, structure: Structure, points_by_loop: list[int]) -> None:
        """The rows of points and relations, scaled so that all joints move in lengths."""
        self.units = np.array([self.size if axis.turns else 1.0 for axis in structure.axes])
        self.per_unit, self.back_per_unit, self.column = 1 / self.units, -1 / self.units, (1 / self.units)[:, None]
        # a joint that carries both ends moves them by rounding, and by an open gap
        moving = np.repeat(structure.incidence.T != 0, [3 * count for count in points_by_loop], axis=0)
        self.weights = moving * self.per_unit
        self.related, self.offsets = structure.relation_slopes, structure.relation_offsets
        self.point_rows, relations, joints = 3 * sum(points_by_loop), len(self.offsets), len(self.units)
        # zero rows at the end, so that there are as many as joints at least and the orthogonal factor comes whole
        self.rows = np.zeros((max(self.point_rows + relations, joints), joints))
        self.rows[self.point_rows : self.point_rows + relations] = self.related * self.per_unit
        # LAPACK counts pivots from 1: one number stands before those of the rows
        self.none, self.undrifting = np.zeros(1), np.zeros(relations)

    def __reduce__(self) -> tuple[Any, ...]:
        return ForwardDynamics, self._made_of

    @cached_property
    def lapack(self) -> Any:
        """LAPACK's routines. NumPy's own QR has no pivoting, and an overhead of 10 us."""
        from scipy.linalg import lapack  # its import takes longer than some derivatives, which need none of it

        return lapack

    def acceleration(self, x: Array, v: Array, efforts: Array) -> Array:
        """Joint accelerations (nv,) of a closed state under efforts (nv,) [rad/s2, m/s2].

        Raises:
            SingularityError: the loops lose equations here: two assemblies meet, and mechanics does not say in which one the motion goes
                on.
            PinpressError: no mass resists a motion, or a state or effort is not finite.
        """
        if self.quick is not None:
            _, _, data, points, data_of_points, settings, _, _, gears, *_ = self.quick
            result: Array = pin.constraintDynamics(self.model, data, x, v, efforts, points, data_of_points, settings)
            if self.quick.held_clearly(self.lapack) and math.isfinite(result.dot(result)):
                geared = self._geared(x, result) if len(gears) else result
                if geared is not None:
                    self.quickly += 1
                    return geared
        self.generally += 1
        return self.acceleration_in_null_space(x, v, efforts)

    def _geared(self, x: Array, without: Array) -> Array | None:
        """Joint accelerations (nv,) that keep the ratios of gear pairs, from those ``without`` gear pairs; None if rounding would be
        seen in them."""
        assert self.quick is not None
        _, _, data, points, data_of_points, settings, _, _, gears, *_ = self.quick
        answers = np.array(
            [pin.constraintDynamics(self.weightless, data, x, self.still, gear, points, data_of_points, settings) for gear in gears]
        )
        root, efforts, failed = self.lapack.dposv(gears.dot(answers.T), gears.dot(without))
        if failed or not min(root.diagonal().tolist()) > CANCELLED**0.5:
            return None
        result: Array = without - efforts.dot(answers)
        before, after = without * self.units, result * self.units
        return result if after.dot(after) > CANCELLED**2 * before.dot(before) else None

    def acceleration_along(self, x: Array, first: Array, second: Array, speed: float, efforts: Array) -> Array:
        """Joint accelerations (nv,) where it is known how all joints move with the driver: at a change point the equations do not say it.

        Args:
            x: (nv,) joint coordinates.
            first: (nv,) first-order influence coefficients, see `Closure`.
            second: (nv,) second-order influence coefficients.
            speed: of the driver [rad/s].
            efforts: (nv,) efforts of the joints [N m, N].

        Raises:
            PinpressError: a state or effort that is not finite.
        """
        v, drift = first * speed, second * speed**2
        mass = pin.crba(self.model, self.data, x, pin.Convention.WORLD)
        left = first.dot(efforts - pin.rnea(self.model, self.data, x, v, drift))
        result = drift + first * (left / first.dot(mass.dot(first)))
        if not math.isfinite(result.dot(result)):
            raise self._trouble(x, v, efforts, self.overflow(x))
        return np.asarray(result)

    def project(self, x: Array, v: Array) -> tuple[Array, Array, float]:
        """The closed state near a state that is nearly closed: positions and rates (nv,), and the gap left [m].

        The positions come from Newton's method with the shortest steps, where all joints are measured in lengths (an angle counts as the
        arc at the linkage's length), the rates from the shortest change. No joint is preferred, because the driver may be at a dead point
        of the linkage. Masses do not enter, because links may have none, and a flywheel would leave all correction to the light links. A
        closed state is returned unchanged.

        Raises:
            SingularityError: the loops lose equations here, see `acceleration`.
            AssemblyError: Newton's method does not close the loops from here.
            PinpressError: a state that is not finite.
        """
        rank, at, left, steps = self.rank, x, math.inf, 0
        while True:
            pin.computeJointJacobians(self.model, self.data, at)
            factor, pivots, orthogonal = self._factorised(at)
            gap, rows = self._widest(at), np.concatenate((self.none, *self.gaps, self.related.dot(at) - self.offsets))
            # Where rows contradict each other a gap is left: what a step takes away of it has to become rounding.
            before, left = left, float(np.abs(pivots.T.dot(rows[1:])).max(initial=0.0)) if self.structure.misfit else gap
            if left <= self.rounding or (left > 0.5 * before and left <= self._floor(at)):
                break
            if steps == MOST_NEWTON_STEPS:
                problem = f"the loops of {self.name} do not close near this state"
                raise AssemblyError(problem, float(x[self.driver]), gap, steps, self.structure.place(x))
            at = at + self._needed(factor, pivots, orthogonal, rows)
            steps += 1
        free = orthogonal[:, rank:]
        rates = free.dot(free.T.dot(v * self.units))
        rates *= self.per_unit
        if not math.isfinite(rates.dot(rates)):
            raise self._trouble(x, v, rates, self.overflow(x))
        return at.copy(), rates, gap

    def gap(self, x: Array) -> float:
        """The largest distance between the two sides of a loop at any of its points (see the module) [m]; for a relation that turns, its
        error times the length of the linkage.

        Raises:
            PinpressError: a state that is not finite.
        """
        pin.forwardKinematics(self.model, self.data, x)
        for point, datum in self.anchors:
            point.calc(self.model, self.data, datum)
        return self._widest(x)

    def energy(self, x: Array, v: Array) -> tuple[float, float]:
        """Kinetic energy, armature included, and potential energy, zero with all centres of mass at the world origin [J]."""
        kinetic = pin.computeKineticEnergy(self.model, self.data, x, v) + 0.5 * float(self.armature.dot(v * v))
        return kinetic, float(pin.computePotentialEnergy(self.model, self.data, x))

    def place(self, x: Array) -> None:
        """Place the links at joint coordinates (nv,), for `point` and `point_efforts`."""
        pin.computeJointJacobians(self.model, self.data, x)

    def point(self, joint: int, point: Array) -> Array:
        """World position (3,) [m] of a point (3,) fixed to the body of a Pinocchio joint, in that joint's frame (0: the frame), where the
        links were placed last."""
        return np.asarray(self.placements[joint].act(point)) if joint else np.array(point, dtype=float)

    def point_efforts(self, joint: int, point: Array, force: Array) -> Array:
        """Joint efforts (nv,) of a force (3,) in world axes [N] that acts at a point, given as for `point`, as the links were placed last;
        zero for joint 0, the frame."""
        if joint == 0:
            return np.zeros(self.model.nv)
        columns = pin.getJointJacobian(self.model, self.data, joint, pin.LOCAL).reshape(6, -1)
        local = self.placements[joint].rotation.T.dot(force)
        return np.asarray(local.dot(columns[:3]) + pin.skew(point).dot(local).dot(columns[3:]))

    def acceleration_in_null_space(self, x: Array, v: Array, efforts: Array) -> Array:
        """Joint accelerations (nv,) by the null space of the constraints; see `acceleration`, and the module."""
        model, data, rank = self.model, self.data, self.rank
        pin.forwardKinematics(model, data, x, v, self.still)
        mass = pin.crba(model, data, x, pin.Convention.WORLD)  # fills the Jacobian too
        factor, pivots, orthogonal = self._factorised(x)
        result = self._needed(factor, pivots, orthogonal, np.concatenate((self.none, *self.drifts, self.undrifting)))
        free = orthogonal[:, rank:] * self.column
        left = free.T.dot(efforts - pin.rnea(model, data, x, v, result))
        root, rates, failed = self.lapack.dposv(free.T.dot(mass.dot(free)), left)
        if failed or not min(root.diagonal().tolist()) > self.least:
            problem = f"no mass resists a motion of {self.name} at {self.structure.place(x)}"
            raise self._trouble(
                x, v, efforts, PinpressError(f"{problem}: give mass to the links that move there, or inertia to the driver")
            )
        result += free.dot(rates)
        if not math.isfinite(result.dot(result)):
            raise self._trouble(x, v, efforts, self.overflow(x))
        return result

    def _factorised(self, x: Array) -> tuple[Array, Array, Array]:
        """The factorisation of the scaled rows: R, the indices of the pivot rows counted from 1, and Q. Of rows that contradict each other
        the singular values on a diagonal, the left vectors of those that count, and the right ones. ``data`` must hold placements and
        Jacobian; the points' constraint data are updated.

        Raises:
            SingularityError: see `acceleration`.
            PinpressError: a state that is not finite.
        """
        for point, datum in self.anchors:
            point.calc(self.model, self.data, datum)
        if self.point_rows:
            jacobian = pin.getConstraintsJacobian(self.model, self.data, self.points, self.data_of_points).reshape(self.point_rows, -1)
            np.multiply(jacobian, self.weights, out=self.rows[: self.point_rows])
        rank = self.rank
        if self.structure.misfit:
            left, values, right = np.linalg.svd(self.rows[: self.point_rows + len(self.offsets)])
            factor, pivots, scales = np.diag(values), left[:, :rank], None
        else:
            factor, pivots, scales, _, _ = self.lapack.dgeqp3(self.rows.T)
        if rank and not abs(factor[rank - 1, rank - 1]) > self.structure.smallest_margin * abs(factor[0, 0]):
            smallest = float(abs(factor[rank - 1, rank - 1])) / (float(abs(factor[0, 0])) or 1.0)
            problem = f"the loops of {self.name} lose equations: two assemblies meet"
            locked = SingularityError(problem, float(x[self.driver]), smallest, self.structure.place(x))
            raise self._trouble(x, self.still, self.still, locked)
        return factor, pivots, right.T if scales is None else self.lapack.dorgqr(factor[:, : len(x)], scales)[0]

    def _needed(self, factor: Array, pivots: NDArray[Any], orthogonal: Array, rows: Array) -> Array:
        """The shortest joint step (nv,) that brings the rows from ``rows`` (1 + rows,), of which the first number is unused, to zero, or as
        near to zero as they all come."""
        rank = self.rank
        if not rank:
            return np.zeros(len(orthogonal))
        wanted = pivots.T.dot(rows[1:]) if self.structure.misfit else rows.take(pivots[:rank])
        result: Array = orthogonal[:, :rank].dot(self.lapack.dtrtrs(factor[:rank, :rank], wanted, trans=1)[0])
        result *= self.back_per_unit
        return result

    def _widest(self, x: Array) -> float:
        """`gap` where the points' constraint data are up to date."""
        sizes = [math.sqrt(gap.dot(gap)) for gap in self.gaps]
        if len(self.offsets):
            sizes += np.abs(self.related.dot(x) - self.offsets).tolist()
        if not math.isfinite(sum(sizes)):
            raise self._trouble(x, self.still, self.still, self.overflow(x))
        return max(sizes, default=0.0)

    def _floor(self, x: Array) -> float:
        """Gap that rounding may leave [m]: more where a joint has made many turns."""
        return self.structure.tolerance + 8 * float(np.finfo(float).eps * np.abs(x * self.units).max())

    def _trouble(self, x: Array, v: Array, efforts: Array, otherwise: PinpressError) -> PinpressError:
        """The error that says which of these is not finite; ``otherwise`` where all are."""
        for what, values in (("position", x), ("speed", v), ("effort", efforts)):
            if not np.isfinite(values).all():
                joint = self.joints[int(np.argmin(np.isfinite(values)))]
                return PinpressError(f"the {what} of joint {joint} of {self.name} is not finite: lower speeds, efforts or the time step")
        return otherwise

    def overflow(self, x: Array) -> PinpressError:
        """The error of numbers that are not finite at a position (nv,)."""
        return PinpressError(
            f"the motion of {self.name} at {self.structure.place(x)} is too fast for floating point: lower speeds or efforts"
        )

    def _weight(self) -> float:
        """Weight of all links [N]; without gravity the force that accelerates them at 1 rad/s2."""
        mass = sum(float(inertia.mass) for inertia in self.model.inertias)
        return mass * (float(np.linalg.norm(self.model.gravity.linear)) or self.size)

    def _proximal(self, closed: Array, ends: list[PointPair], mass: Array) -> tuple[Proximal | None, str]:
        """What `constraintDynamics` takes, None if it does not suit the linkage, and why."""
        if not ends:
            return None, "no loops"
        if self.structure.misfit:
            return None, "redundant loops that contradict each other a little, of which it would hold one more than there are"
        if not ((mass.diagonal() * self.per_unit**2).min() > self.least**2):
            return None, "a joint moves no mass"
        if len(self.offsets) > MOST_GEAR_PAIRS:
            return None, f"more than {MOST_GEAR_PAIRS} gear pairs, of which Pinocchio has no constraint model"
        data, (points, data_of_points) = data_of(self.model), _contacts(self.model, ends)
        opened = closed + OPENED * self.size * self.per_unit * np.random.default_rng(0).uniform(-1, 1, len(closed))
        rows, opened_rows = (_contact_rows(self.model, data, points, data_of_points, x) for x in (closed, opened))
        rank = self.rank - len(self.offsets)  # of the points' rows, where gear pairs add equations of their own
        if len(self.offsets) and self._rank_of_points(closed, data, points, data_of_points) != rank:
            return None, "a gear pair whose ratio the loops keep too, as its torque is then undetermined"
        values = np.linalg.svd(opened_rows * self.per_unit, compute_uv=False)
        hold_each_other = bool(values[rank:].max(initial=0.0) > self.structure.smallest_margin * values[0])
        damping, iterations = (HELD_PROXIMAL, HELD_ITERATIONS) if hold_each_other else (PROXIMAL, ITERATIONS)
        try:
            largest = float((rows @ np.linalg.solve(mass, rows.T)).diagonal().max())
            answers = (self.related @ np.linalg.solve(mass, self.related.T)).diagonal()
        except np.linalg.LinAlgError:
            return None, "an inertia that is zero to rounding"
        if not 0 < largest < math.inf:
            return None, "an inertia that is zero to rounding"
        # Its pivots come in the order of the rows. Each point's frame is turned so that the direction in which the point moves least comes
        # last: else a row may be a combination of others with large coefficients, whose pivot would not look like rounding.
        lefts = np.linalg.svd(rows.reshape(-1, 3, len(closed)))[0]
        turned = [pin.SE3(left * np.linalg.det(left), end[1].translation) for left, end in zip(lefts, ends, strict=True)]
        points, data_of_points = _contacts(self.model, [(end[0], place, *end[2:]) for place, end in zip(turned, ends, strict=True)])
        pin.initConstraintDynamics(self.model, data, points, data_of_points)
        proximal = Proximal(
            largest=largest,
            clear=rank if hold_each_other else rank + len(closed),
            data=data,
            points=points,
            data_of_points=data_of_points,
            settings=pin.ProximalSettings(0.0, SETTLED * min(1.0, self._weight()), damping * largest, iterations),
            pivots=data.constraint_chol.D,
            bounds=CLEAR * np.concatenate([np.full(self.point_rows, largest), mass.diagonal()]),
            gears=self.related / np.sqrt(answers)[:, None],
            least=HELD_CLEAR * largest if hold_each_other else None,
        )
        reasons = ["loops that hold each other, with a larger mu" if hold_each_other else "independent loops"]
        if len(self.offsets):
            reasons.append("gear pairs by their torques")
        return proximal, ", ".join(reasons)

    def _rank_of_points(self, closed: Array, data: pin.Data, points: Any, data_of_points: Any) -> int:
        """Rank of the points' rows in closed states, without gear pairs."""
        beside = closed + OPENED * self.size * self.per_unit * np.random.default_rng(1).uniform(-1, 1, len(closed))
        with contextlib.suppress(PinpressError):  # the drawn pose may be a dead centre, where gear pairs hold what loops hold elsewhere
            closed = self.project(beside, self.still)[0]
        values = np.linalg.svd(_contact_rows(self.model, data, points, data_of_points, closed) * self.per_unit, compute_uv=False)
        return int(np.count_nonzero(values > self.structure.smallest_margin * values[0]))


class Proximal(NamedTuple):
    """The quick way: arguments of `constraintDynamics`, and how its pivots are checked.

    Attributes:
        largest: entry of J M^-1 J' in the drawn pose [1/kg].
        clear: number of pivots that must be above their bounds, or of eigenvalues above the least.
        data: Pinocchio's workspace.
        points: constraint models of the loops' points.
        data_of_points: their constraint data.
        settings: of the proximal iterations.
        pivots: (point rows + nv,) pivots of its factorisation, kept up to date by Pinocchio: of the points' rows [1 / kg], then of the
            inertias of the open tree.
        bounds: (point rows + nv,) above which a pivot is clearly not zero.
        gears: (relations, nv) efforts of the gear pairs, to which they answer with an acceleration of 1 in the open tree.
        least: eigenvalue of J M^-1 J' above which a row is clearly held, where loops hold each other [1 / kg]; None if pivots decide.
    """

    largest: float
    clear: int
    data: pin.Data
    points: pin.StdVec_RigidConstraintModel
    data_of_points: pin.StdVec_RigidConstraintData
    settings: pin.ProximalSettings
    pivots: Array
    bounds: Array
    gears: Array
    least: float | None

    def held_clearly(self, lapack: Any) -> bool:
        """Whether `constraintDynamics` has just held as many rows as the closed linkage has equations, all of them clearly; ``lapack``:
        SciPy's LAPACK."""
        if self.least is None:
            return bool(np.count_nonzero(np.abs(self.pivots) > self.bounds) == self.clear)
        # a row that others hold may have a pivot of any size; eigenvalues are those of the whole matrix
        values, _, failed = lapack.dsyev(self.data.constraint_chol.getInverseOperationalSpaceInertiaMatrix(), compute_v=0)
        return not failed and bool(np.count_nonzero(values > self.least) == self.clear)


def _bounded(model: pin.Model, axes: tuple[Axis, ...]) -> pin.Model:
    """The tree with joints whose configuration is the joint coordinate itself, in place of unbounded ones too."""
    result = pin.Model()
    result.gravity = model.gravity
    for j, axis in enumerate(axes, 1):
        kind = pin.JointModelRevoluteUnaligned if axis.turns else pin.JointModelPrismaticUnaligned
        result.addJoint(model.parents[j], kind(axis.direction), model.jointPlacements[j], model.names[j])
        result.appendBodyToJoint(j, model.inertias[j], pin.SE3.Identity())
    return result


def _contacts(model: pin.Model, ends: list[PointPair]) -> tuple[Any, Any]:
    """Pinocchio's models and data of the points, for `constraintDynamics`."""
    kind = pin.ContactType.CONTACT_3D
    points = pin.StdVec_RigidConstraintModel([pin.RigidConstraintModel(kind, model, *end, pin.LOCAL) for end in ends])
    return points, pin.StdVec_RigidConstraintData([point.createData() for point in points])


def _contact_rows(model: pin.Model, data: pin.Data, points: Any, data_of_points: Any, x: Array) -> Array:
    """Jacobian (3 points, nv) as `constraintDynamics` has it: in open states it differs from that of the anchors."""
    pin.computeJointJacobians(model, data, x)
    for point, datum in zip(points, data_of_points, strict=True):
        point.calc(model, data, datum)
    return np.array(pin.getConstraintsJacobian(model, data, points, data_of_points)).reshape(-1, model.nv)
