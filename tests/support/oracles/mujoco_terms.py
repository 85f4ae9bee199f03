"""Torques of an MJCF from MuJoCo's own mass matrix, bias, passive forces and Jacobians, with loops that hold exactly.

With M a + h = f + S'u + J'l, J a = -g and S a given, the accelerations are a = b + N z, where [J; S] N = 0 and
N'M N z = N'(f - h - M b); then [J; S]' [l; u] = M a + h - f by least norm.
"""

import mujoco
import numpy as np
import pinocchio as pin


class MujocoTerms:
    """A model at one state of a linkage.

    Args:
        path: of the MJCF.
        press: the linkage, from which positions and speeds are taken by the names of joints.
        x: (nv,) its joint coordinates.
        v: (nv,) its joint rates.
    """

    def __init__(self, path, press, x, v):
        self.model = model = mujoco.MjModel.from_xml_path(str(path))
        self.data = data = mujoco.MjData(model)
        free = [k for k in range(model.njnt) if model.jnt_type[k] == int(mujoco.mjtJoint.mjJNT_FREE)]
        ours, q = press.model.createData(), _configuration(press, x)
        pin.forwardKinematics(press.model, ours, q, v)
        for k in range(model.njnt):
            name, at, dof = model.joint(k).name, model.jnt_qposadr[k], model.jnt_dofadr[k]
            if k in free:
                joint = press.model.getJointId(name + "_rx")
                place, turned = ours.oMi[joint], pin.Quaternion(ours.oMi[joint].rotation)
                data.qpos[at : at + 7] = [*place.translation, turned.w, turned.x, turned.y, turned.z]
                data.qvel[dof : dof + 3] = pin.getVelocity(press.model, ours, joint, pin.LOCAL_WORLD_ALIGNED).linear
                data.qvel[dof + 3 : dof + 6] = pin.getVelocity(press.model, ours, joint, pin.LOCAL).angular
            else:
                data.qpos[at], data.qvel[dof] = x[press.joints.index(name)], v[press.joints.index(name)]
        mujoco.mj_forward(model, data)

    def gap(self):
        """Largest violation of an equality."""
        rows = self.data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        return float(np.abs(self.data.efc_pos[rows]).max(initial=0.0))

    def equalities(self):
        """Jacobian (rows, nv) of the equalities, and what they need without accelerations (rows,)."""
        rows, drifts = [np.zeros((0, self.model.nv))], [np.zeros(0)]
        for k in range(self.model.neq):
            row, drift = self._sites(k) if self.model.eq_objtype[k] == int(mujoco.mjtObj.mjOBJ_SITE) else self._joints(k)
            rows.append(row)
            drifts.append(drift)
        return np.vstack(rows), np.concatenate(drifts)

    def _sites(self, k):
        model, data = self.model, self.data
        row, change = np.zeros((6, model.nv)), np.zeros((6, model.nv))
        for site, sign in ((model.eq_obj1id[k], 1.0), (model.eq_obj2id[k], -1.0)):
            for function, total in ((mujoco.mj_jac, row), (mujoco.mj_jacDot, change)):
                moved, turned = np.zeros((3, model.nv)), np.zeros((3, model.nv))
                function(model, data, moved, turned, data.site_xpos[site], model.site_bodyid[site])
                total += sign * np.vstack([moved, turned])
        count = 6 if model.eq_type[k] == int(mujoco.mjtEq.mjEQ_WELD) else 3
        return row[:count], (change @ data.qvel)[:count]

    def _joints(self, k):
        model, row = self.model, np.zeros((1, self.model.nv))
        ratio = model.eq_data[k][1]
        for one, factor in ((model.eq_obj1id[k], 1.0), (model.eq_obj2id[k], -ratio)):
            if one < 0:
                continue
            if model.eq_type[k] == int(mujoco.mjtEq.mjEQ_JOINT):
                row[0, model.jnt_dofadr[one]] += factor
            else:
                for part in range(model.tendon_adr[one], model.tendon_adr[one] + model.tendon_num[one]):
                    row[0, model.jnt_dofadr[model.wrap_objid[part]]] += factor * model.wrap_prm[part]
        return row, np.zeros(1)

    def torque(self, accelerations, held, free, rank=1e-9):
        """Torques of joints with given accelerations.

        Args:
            accelerations: by names of joints.
            held: names of joints without acceleration, whose torques are not asked for.
            free: number of freedoms that move freely.
            rank: singular values up to this share of the largest one are zero.
        """
        model, data = self.model, self.data
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        needed, drift = self.equalities()
        chosen = np.zeros((len(accelerations) + len(held), model.nv))
        for row, name in zip(chosen, (*accelerations, *held), strict=True):
            row[model.joint(name).dofadr[0]] = 1.0
        rows = np.vstack([needed, chosen])
        right = np.concatenate([-drift, list(accelerations.values()), np.zeros(len(held))])
        a = np.linalg.lstsq(rows, right, rcond=rank)[0]
        assert np.abs(rows @ a - right).max() < max(1e-8, rank) * (1 + np.abs(right).max())
        values, ways = np.linalg.svd(rows)[1:]
        assert model.nv - np.count_nonzero(values > rank * values[0]) == free
        still = ways[model.nv - free :].T
        force = data.qfrc_passive - data.qfrc_bias
        a = a + still @ np.linalg.solve(still.T @ mass @ still, still.T @ (force - mass @ a))
        multipliers = np.linalg.lstsq(rows.T, mass @ a - force, rcond=rank)[0]
        return multipliers[len(needed) :][: len(accelerations)]


def _configuration(press, x):
    q = pin.neutral(press.model)
    for joint, coordinate in zip(list(press.model.joints)[1:], x, strict=True):
        q[joint.idx_q : joint.idx_q + joint.nq] = [coordinate] if joint.nq == 1 else [np.cos(coordinate), np.sin(coordinate)]
    return q
