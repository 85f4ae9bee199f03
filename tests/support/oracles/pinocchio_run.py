"""A free run of the ZXN2-3000(B) press by a plain loop with Pinocchio's constraint dynamics: a peer for the benchmark.

What a roboticist writes for this one press: the URDF's tree cut at the pins C and F, two three-row point contacts, classical Runge-Kutta
steps on the configuration manifold, and after every step Newton's method to close the loops and a least-squares velocity projection. The
proximal settings are those that give digits on planar pins. No code is shared with pinpress. SI units.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from support.oracles.pinocchio_loop import JOINTS, LOOPS, URDF

Array = NDArray[np.float64]


def free_run(angle: float, speed: float, flywheel: float, duration: float, steps: int) -> tuple[float, float]:
    """Crank angle (unwrapped) [rad] and speed [rad/s] after a duration [s], from a crank angle and speed, with a flywheel on the crank
    [kg m2]; no torque."""
    model = pin.buildModelFromUrdf(str(URDF))
    ids = {name: model.getJointId(name) for name in JOINTS}
    crank_q, crank_v = model.joints[ids["A"]].idx_q, model.joints[ids["A"]].idx_v
    armature = np.zeros(model.nv)
    armature[crank_v] = flywheel
    model.armature = armature
    data = model.createData()

    def point(x: float) -> pin.SE3:
        return pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))

    contacts = pin.StdVec_RigidConstraintModel()
    for _, joint1, x1, joint2, x2 in LOOPS:
        kind = pin.ContactType.CONTACT_3D
        contacts.append(pin.RigidConstraintModel(kind, model, ids[joint1], point(x1), ids[joint2], point(x2), pin.ReferenceFrame.LOCAL))
    datas = pin.StdVec_RigidConstraintData()
    for contact in contacts:
        datas.append(contact.createData())
    pin.initConstraintDynamics(model, data, contacts, datas)
    proximal = pin.ProximalSettings(0.0, 1e-13, 1e-8, 20)
    anchors = [pin.PointAnchorConstraintModel(model, ids[j1], point(x1), ids[j2], point(x2)) for _, j1, x1, j2, x2 in LOOPS]
    anchor_datas = [anchor.createData() for anchor in anchors]
    none = np.zeros(model.nv)

    def gaps_and_columns(q: Array) -> tuple[Array, Array]:
        pin.computeJointJacobians(model, data, q)
        gaps, columns = [], []
        for anchor, anchor_data in zip(anchors, anchor_datas, strict=True):
            anchor.calc(model, data, anchor_data)
            gaps.append(anchor_data.constraint_position_error.copy())
            columns.append(anchor.jacobian(model, data, anchor_data).copy())
        return np.concatenate(gaps), np.concatenate(columns)

    def closed(q: Array, fixed: int | None) -> Array:
        for _ in range(20):
            gaps, columns = gaps_and_columns(q)
            if np.abs(gaps).max() < 1e-12:
                return q
            if fixed is not None:
                columns[:, fixed] = 0.0
            q = pin.integrate(model, q, -np.linalg.lstsq(columns, gaps, rcond=1e-9)[0])
        raise ArithmeticError("loops not closed")

    def acceleration(q: Array, v: Array) -> Array:
        return pin.constraintDynamics(model, data, q, v, none, contacts, datas, proximal).copy()

    q = pin.neutral(model)
    for part in np.linspace(0.0, angle, 1 + int(np.ceil(abs(angle) / 0.05))):  # turned to the start in small steps, to stay on the branch
        q[crank_q], q[crank_q + 1] = np.cos(part), np.sin(part)
        q = closed(q, crank_v)
    _, columns = gaps_and_columns(q)
    passive = [i for i in range(model.nv) if i != crank_v]
    v = np.zeros(model.nv)
    v[crank_v] = speed
    v[passive] = np.linalg.lstsq(columns[:, passive], -columns[:, crank_v] * speed, rcond=1e-9)[0]
    turned, h = angle, duration / steps
    for _ in range(steps):
        v1, a1 = v, acceleration(q, v)
        q2, v2 = pin.integrate(model, q, 0.5 * h * v1), v + 0.5 * h * a1
        a2 = acceleration(q2, v2)
        q3, v3 = pin.integrate(model, q, 0.5 * h * v2), v + 0.5 * h * a2
        a3 = acceleration(q3, v3)
        q4, v4 = pin.integrate(model, q, h * v3), v + h * a3
        a4 = acceleration(q4, v4)
        step = h / 6 * (v1 + 2 * v2 + 2 * v3 + v4)
        turned += float(step[crank_v])
        q = pin.integrate(model, q, step)
        v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        q = closed(q, crank_v)
        _, columns = gaps_and_columns(q)
        v = v - np.linalg.lstsq(columns, columns @ v, rcond=1e-9)[0]
    return turned, float(v[crank_v])
