"""Inverse dynamics of the ZXN2-3000(B) press by a plain loop over the crank angles with Pinocchio: a peer for the benchmark and the tests.

What a roboticist writes for this one press. The URDF's tree is cut at the pins C and F; two point constraints close it.
At every angle: Newton from the previous angle's solution, velocities and accelerations from the constraint Jacobian, `rnea`,
the passive rows for the pin forces of the loops, the crank's row for the torque, and `rnea` again with those forces for the
rest of the joints. No code is shared with pinpress.

World axes x, y, z with z up; the press stands in the x-z plane, joint axes are (0, -1, 0), so angles turn x towards z. SI units.
"""

from __future__ import annotations

from math import ceil, cos, sin
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

URDF = Path(__file__).resolve().parents[3] / "urdf" / "zxn2_3000b.urdf"
# The URDF's loop joints, coded by hand: pin, link1's joint and x of the pin on it, link2's joint and x of the pin on it [m].
LOOPS = (("C", "B", 1.243, "D", 0.375), ("F", "E", 0.480, "slide_guide", 0.0))
JOINTS = ("A", "B", "D", "E", "slide_guide")
PLANE = slice(0, 3, 2)  # x and z of a pin; its y gap is zero in a planar press
LARGEST_STEP = np.radians(5.0)  # of the crank between two closures, so that Newton stays on the branch


def _point(x: float) -> pin.SE3:
    return pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))


class PinocchioLoop:
    """The press, its two constraints, and the last closed configuration, from which the next angle starts."""

    def __init__(self, urdf: Path = URDF) -> None:
        self.model = pin.buildModelFromUrdf(str(urdf))
        self.data = self.model.createData()
        self.ids = {name: self.model.getJointId(name) for name in JOINTS}
        self.constraints = [
            pin.PointAnchorConstraintModel(self.model, self.ids[joint1], _point(x1), self.ids[joint2], _point(x2))
            for _, joint1, x1, joint2, x2 in LOOPS
        ]
        self.constraint_datas = [constraint.createData() for constraint in self.constraints]
        self.loops = list(zip(self.constraints, self.constraint_datas, (slice(0, 2), slice(2, 4)), strict=True))
        crank = self.model.joints[self.ids["A"]]
        self.crank_q, self.crank_v = crank.idx_q, crank.idx_v
        self.passive = np.array([i for i in range(self.model.nv) if i != self.crank_v])
        self.rest = np.zeros(self.model.nv)
        self.external = pin.StdVec_Force([pin.Force.Zero() for _ in range(self.model.njoints)])
        self.reset()

    def reset(self) -> None:
        """Go back to the drawing: crank angle 0, nearly closed."""
        self.theta1 = 0.0
        self.q = pin.neutral(self.model)

    def close(self, theta1: float) -> Array:
        """Turn the crank to theta1 [rad], close both loops by Newton, and return the in-plane Jacobian there, shape (4, 5)."""
        model, data = self.model, self.data
        jacobian, gap, change = np.empty((4, model.nv)), np.empty(4), np.zeros(model.nv)
        start, steps = self.theta1, max(1, ceil(abs(theta1 - self.theta1) / LARGEST_STEP))
        for i in range(1, steps + 1):
            self.theta1 = theta1 if i == steps else start + (theta1 - start) * i / steps
            self.q[self.crank_q], self.q[self.crank_q + 1] = cos(self.theta1), sin(self.theta1)
            for _ in range(20):
                pin.computeJointJacobians(model, data, self.q)
                for constraint, constraint_data, rows in self.loops:
                    constraint.calc(model, data, constraint_data)
                    gap[rows] = constraint_data.constraint_position_error[PLANE]
                    jacobian[rows] = constraint.jacobian(model, data, constraint_data)[PLANE]
                if np.abs(gap).max() < 1e-12:
                    break
                change[self.passive] = -np.linalg.solve(jacobian[:, self.passive], gap)
                self.q = pin.integrate(model, self.q, change)
            else:
                raise ArithmeticError(f"loops not closed at crank angle {self.theta1} rad: gap {np.abs(gap).max():.3g} m")
        return jacobian

    def point(self, theta1: float, omega1: float, alpha1: float) -> tuple[float, dict[str, Array]]:
        """Driving torque [N m] and the force of every joint, world axes [N], at one crank angle [rad], speed and acceleration."""
        model, data = self.model, self.data
        jacobian = self.close(theta1)
        dependent, driven = jacobian[:, self.passive], jacobian[:, self.crank_v]
        v, a = np.zeros(model.nv), np.zeros(model.nv)
        v[self.crank_v] = omega1
        v[self.passive] = -np.linalg.solve(dependent, driven * omega1)
        pin.forwardKinematics(model, data, self.q, v, self.rest)
        drift = np.empty(4)
        for constraint, constraint_data, rows in self.loops:
            constraint.calc(model, data, constraint_data)
            drift[rows] = constraint_data.constraint_acceleration_error[PLANE]
        a[self.crank_v] = alpha1
        a[self.passive] = -np.linalg.solve(dependent, driven * alpha1 + drift)

        # M a + b = tau + J^T lambda, with tau on the crank only; lambda acts on link2, in link1's axes.
        effort = pin.rnea(model, data, self.q, v, a)
        lam = np.linalg.solve(dependent.T, effort[self.passive])
        tau = effort[self.crank_v] - driven @ lam

        forces = {}
        external = self.external
        for force in external:
            force.setZero()
        for (name, *_), (constraint, constraint_data, rows) in zip(LOOPS, self.loops, strict=True):
            local = np.zeros(3)
            local[PLANE] = lam[rows]
            constraint.mapConstraintForceToJointSpace(model, data, constraint_data, local, external, pin.LOCAL)
            forces[name] = constraint_data.oMc1.rotation @ local
        pin.rnea(model, data, self.q, v, a, external)
        placements, wrenches = data.oMi, data.f
        for name, joint in self.ids.items():
            forces[name] = placements[joint].rotation @ wrenches[joint].linear
        return tau, forces


def inverse_dynamics(theta1: ArrayLike, omega1: ArrayLike, alpha1: ArrayLike, press: PinocchioLoop | None = None) -> dict[str, Array]:
    """Driving torque and bearing forces of the press, one crank angle after the other.

    Args:
        theta1: crank angle, shape (n,), 0 along +x, counter-clockwise [rad]; the branch is carried from each to the next.
        omega1: crank speed, shape (n,) or scalar [rad/s].
        alpha1: crank acceleration, shape (n,) or scalar [rad/s2].
        press: to leave reading the URDF out of the call; it is put back to its drawing first.

    Returns:
        "tau", torque on the crank along its axis, shape (n,) [N m]; and for A, B, C, D, E, F and slide_guide the force of the
        joint's parent (a loop's link1) on its child (link2), world axes, shape (n, 3) [N].
    """
    theta1 = np.atleast_1d(np.asarray(theta1, dtype=float))
    omega1 = np.broadcast_to(np.asarray(omega1, dtype=float), theta1.size)
    alpha1 = np.broadcast_to(np.asarray(alpha1, dtype=float), theta1.size)
    press = press or PinocchioLoop()
    press.reset()
    result = {"tau": np.empty(theta1.size)} | {name: np.empty((theta1.size, 3)) for name in ("A", "B", "C", "D", "E", "F", "slide_guide")}
    for i in range(theta1.size):
        result["tau"][i], forces = press.point(float(theta1[i]), float(omega1[i]), float(alpha1[i]))
        for name, force in forces.items():
            result[name][i] = force
    return result
