"""Dynamics of a linkage by MuJoCo: its mass matrix, bias, springs and Jacobians, and from these the motion with passive coordinates free.

MuJoCo gets the tree alone. Loops are points (spherical ones), so that the equations of motion stay those of robotics textbooks,

    M a + h = f + S' u + J' l,   J a = -J' v,   S a = a_d,

with the motors' rows S alone: no effort acts at the passive coordinates.
"""

from typing import NamedTuple

import mujoco
import numpy as np

import pinpress as pp
from pinpress.linkage.description import JointSpring


class Found(NamedTuple):
    """Accelerations of all joints (nv,), and efforts of the motors."""

    acceleration: np.ndarray
    efforts: np.ndarray


def model_of(press: pp.Linkage) -> mujoco.MjModel:
    """MuJoCo's model of the open tree, with springs, dampers and armature of the joints; a site at each end of the loops."""
    model, children = press.model, {k: [] for k in range(press.model.njoints)}
    for joint in range(1, model.njoints):
        children[model.parents[joint]].append(joint)
    springs = {spring.joint: spring for spring in press.joint_springs}
    ends = [(loop.joint1, loop.point1, f"{loop.name}_1") for loop in press.loops]
    ends += [(loop.joint2, loop.point2, f"{loop.name}_2") for loop in press.loops]

    def text(numbers) -> str:
        return " ".join(repr(float(number)) for number in numbers)

    def body(joint: int) -> str:
        place, inertia, axis = model.jointPlacements[joint], model.inertias[joint], press.axes[joint - 1]
        spring = springs.get(model.names[joint], JointSpring(model.names[joint]))
        quaternion, principal = np.empty((2, 4))
        mujoco.mju_mat2Quat(quaternion, place.rotation.ravel())
        moments, axes = np.linalg.eigh(inertia.inertia)  # MuJoCo's own, of fullinertia, is exact to 1e-8 in older versions
        mujoco.mju_mat2Quat(principal, (axes * np.linalg.det(axes)).ravel())
        of_body = f'mass="{inertia.mass!r}" diaginertia="{text(moments)}" quat="{text(principal)}"'
        inertial = f'<inertial pos="{text(inertia.lever)}" {of_body}/>' if inertia.mass else ""
        of_joint = f'type="{"hinge" if axis.turns else "slide"}" axis="{text(axis.direction)}" armature="{model.armature[joint - 1]}"'
        of_spring = f'stiffness="{spring.stiffness}" springref="{spring.reference}" damping="{spring.damping}"'
        sites = "".join(f'<site name="{name}" pos="{text(point)}"/>' for at, point, name in ends if at == joint)
        inside = "".join(map(body, children[joint]))
        return (
            f'<body name="{model.names[joint]}" pos="{text(place.translation)}" quat="{text(quaternion)}">'
            f'<joint name="{model.names[joint]}" {of_joint} {of_spring}/>{inertial}{sites}{inside}</body>'
        )

    fixed = "".join(f'<site name="{name}" pos="{text(point)}"/>' for at, point, name in ends if at == 0)
    bodies = "".join(map(body, children[0]))
    options = f'<compiler angle="radian" boundmass="0" balanceinertia="false"/><option gravity="{text(model.gravity.linear)}"/>'
    return mujoco.MjModel.from_xml_string(f"<mujoco>{options}<worldbody>{fixed}{bodies}</worldbody></mujoco>")


def free_motion(press: pp.Linkage, x: np.ndarray, v: np.ndarray, motors: np.ndarray) -> Found:
    """Accelerations and motor efforts of a closed state (nv,), from accelerations of the motors, no effort at passive coordinates."""
    model = model_of(press)
    data, nv = mujoco.MjData(model), model.nv
    order = np.array([model.joint(name).dofadr[0] for name in press.joints])
    data.qpos[order], data.qvel[order] = x, v
    mujoco.mj_forward(model, data)
    mass = np.empty((nv, nv))
    mujoco.mj_fullM(model, data, mass)
    mass, bias, passive = mass[np.ix_(order, order)], data.qfrc_bias[order], data.qfrc_passive[order]
    rows, drift = [], []
    for loop in press.loops:
        jacobians, rates = np.zeros((2, 3, nv)), np.zeros((2, 3, nv))
        for end in (0, 1):
            site = model.site(f"{loop.name}_{end + 1}")
            point, of_body = data.site_xpos[site.id], model.site_bodyid[site.id]
            mujoco.mj_jac(model, data, jacobians[end], None, point, of_body)
            mujoco.mj_jacDot(model, data, rates[end], None, point, of_body)
        rows.append((jacobians[1] - jacobians[0])[:, order])
        drift.append((rates[1] - rates[0])[:, order] @ v)
    for relation in press.relations:
        row = np.zeros(nv)
        row[list(relation.coefficients)] = list(relation.coefficients.values())
        rows.append(row[None])
        drift.append(np.zeros(1))
    selected = np.eye(nv)[list(press.driver_indices[: len(press.motors)])]
    held = np.concatenate([*rows, selected])
    right = np.concatenate([-np.concatenate([*drift, np.zeros(0)]), motors])
    whole = np.block([[mass, -held.T], [held, np.zeros((len(held), len(held)))]])
    found = np.linalg.lstsq(whole, np.concatenate([passive - bias, right]), rcond=1e-12)[0]
    assert np.abs(whole @ found - np.concatenate([passive - bias, right])).max() < 1e-8 * np.abs(found).max()
    return Found(found[:nv], found[len(found) - len(motors) :])
