"""A press as a MuJoCo model: bodies and joints of its tree, its loops as ``connect`` equalities, gear pairs as joint equalities."""

from functools import partial

import mujoco
import numpy as np

from ...common.errors import PinpressError
from ...linkage.linkage import Linkage


def compiled(press: Linkage) -> mujoco.MjModel:
    """The press as a MuJoCo model; PinpressError where MuJoCo refuses it."""
    spec, tree = mujoco.MjSpec(), press.model
    spec.option.gravity = tree.gravity.linear
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.option.solver, spec.option.tolerance = mujoco.mjtSolver.mjSOL_NEWTON, 0.0
    spec.option.iterations = 2  # of a quadratic cost: the first one is exact
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    off = mujoco.mjtDisableBit
    spec.option.disableflags = int(off.mjDSBL_REFSAFE) | int(off.mjDSBL_CONTACT) | int(off.mjDSBL_ISLAND)
    bodies = [spec.worldbody]
    for j, (name, axis) in enumerate(zip(press.joints, press.axes, strict=True), start=1):
        place, inertia = tree.jointPlacements[j], tree.inertias[j]
        turned = np.empty(4)
        mujoco.mju_mat2Quat(turned, place.rotation.ravel())
        body = bodies[tree.parents[j]].add_body(name=name, pos=place.translation, quat=turned)
        about = inertia.inertia
        body.mass, body.ipos, body.explicitinertial = inertia.mass, inertia.lever, True
        body.fullinertia = [about[0, 0], about[1, 1], about[2, 2], about[0, 1], about[0, 2], about[1, 2]]
        kind = mujoco.mjtJoint.mjJNT_HINGE if axis.turns else mujoco.mjtJoint.mjJNT_SLIDE
        body.add_joint(name=name, type=kind, axis=axis.direction)
        bodies.append(body)
    equality = partial(spec.add_equality, solimp=[0.9999, 0.9999, 0.001, 0.5, 2.0])
    for loop in press.loops:
        for end, joint, point in ((1, loop.joint1, loop.point1), (2, loop.joint2, loop.point2)):
            bodies[joint].add_site(name=f"{loop.name}/{end}", pos=point)
        site, kind = mujoco.mjtObj.mjOBJ_SITE, mujoco.mjtEq.mjEQ_CONNECT
        equality(name=loop.name, type=kind, objtype=site, name1=f"{loop.name}/1", name2=f"{loop.name}/2")
    for pair in press.couplings:
        names = {"name1": press.joints[pair.follower], "name2": press.joints[pair.leader]}
        geared = equality(type=mujoco.mjtEq.mjEQ_JOINT, objtype=mujoco.mjtObj.mjOBJ_JOINT, **names)
        geared.data[:2] = pair.offset, pair.multiplier
    try:
        return spec.compile()
    except ValueError as error:
        raise PinpressError(f"it refuses {press.name}: {' '.join(str(error).split())}") from None
