"""A press in MuJoCo: its motion, forces and free runs.

MuJoCo's constraints are soft, so its own answers cannot be compared: `mj_inverse` finds no force in loops that are exactly closed, and
gives the torque of the open tree. An expert takes Jacobians, mass matrix, bias and accelerations from MuJoCo and solves the exact equations
of the loops in NumPy, for all crank angles at once where that is possible.

There are two ways to run freely. `MujocoSteps` takes `mj_step` with RK4 and the stiffest equalities that are stable: omega = 0.5 / step,
critically damped (0.2 and 1 err more; Euler and implicitfast fail; a higher impedance changes nothing, and more than two iterations of the
Newton solver only take time). The stiffness of the loops goes with the step, so that its error falls with the square of the step even by
RK4, and the loops stay open. `Mujoco` takes the classical RK4 with projection on MuJoCo's own terms: each step is slower, but of order 4
and closed. `pinpress accuracy` shows where they cross.

Bearing forces are those of the open tree by `mj_rnePostConstraint` (``cfrc_int``) plus what the loops add. Letting MuJoCo add these from
``efc_force`` gives the same to rounding. Where loops hold each other, the forces that this leaves open are those with the least sum of
squared loop forces, not pinpress's.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import ClassVar

import mujoco
import numpy as np
import pinocchio as pin
from benchmarks.peers.loop_equations import Ends, LoopEquations, carriers_of, ends_of, with_loops
from benchmarks.peers.peer import Answer, Peer, RunEnd, load_on_slide, steps_of
from mujoco import rollout

from pinpress.accuracy.scenes import CLUTCH, DIE, SPEED_LAW, Scene
from pinpress.common.errors import PinpressError, SimulationError
from pinpress.common.quantities import Array
from pinpress.kinematics.cycle import cycle
from pinpress.kinematics.slide_path import dead_centres
from pinpress.linkage.linkage import Linkage

RANK = 1e-9  # singular values below this are zero

STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
Effort = Callable[[Array, Array], Array | float]  # efforts (nv,) by joint coordinates and rates (nv,)


def free(x: Array, v: Array) -> float:
    """No effort."""
    return 0.0


class Mujoco(Peer):
    """A press with exact loops on the terms of MuJoCo."""

    how = " + NumPy"
    cannot = "exact loops by itself: closing, rates and bearing forces are NumPy's; bodies without mass"
    left_out: ClassVar[Mapping[str, str]] = {
        CLUTCH: "its steps do not end where a clutch grips",
        SPEED_LAW: "its steps are stable only below the time in which the law forgets",
    }
    steps: tuple[float, ...] = (2e-2, 1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4)

    def __init__(self, press: Linkage) -> None:
        """Make the model.

        Raises:
            PinpressError: the press has several drivers, no loops, a welded loop, a body that MuJoCo refuses, or a crank that does not turn
                fully.
        """
        self._ends = ends_of(press)
        self.name = f"MuJoCo {mujoco.__version__}{self.how}"
        self._press = press
        self._model = _compiled(press, self._ends)
        self._data = mujoco.MjData(self._model)
        self._driver = press.driver_indices[0]
        self._bodies = [self._model.body(press.joints[j - 1]).id for j in carriers_of(press)[1:]]
        sites = [[self._model.site(f"{k}/{side}").id for side in (1, 2)] for k in range(len(self._ends))]
        self._sites = [site for pair in sites for site in pair]
        self._loops = LoopEquations(press, self.name, self._terms)

    def inverse_dynamics(self, angle: Array, speed: float) -> Answer:
        """See `Peer`."""
        angle = np.asarray(angle, dtype=float)
        loops = self._loops
        x, columns = loops.closed(angle, loops.predicted(angle))
        v = loops.rates(columns, np.zeros(columns.shape[:2]), speed)
        a = loops.rates(columns, self._drifts(x, v), 0.0)
        return Answer(*self._efforts(x, v, a, columns))

    def prepared(self, scene: Scene) -> Callable[[float], RunEnd]:
        """See `Peer`; classical Runge-Kutta steps, also over the edges of loads, with the loops closed after each."""
        return partial(self._run, scene, self._working(scene) if scene.drive or scene.loads else free)

    def _run(self, scene: Scene, effort: Effort, step: float) -> RunEnd:
        x, v = self._start(scene)
        begin, count = self._energies(x, v), steps_of(scene.duration, step)
        h = scene.duration / count

        def acceleration(x: Array, v: Array) -> Array:
            return self._acceleration(x, v, effort(x, v))

        for _ in range(count):
            a1 = acceleration(x, v)
            v2 = v + 0.5 * h * a1
            a2 = acceleration(x + 0.5 * h * v, v2)
            v3 = v + 0.5 * h * a2
            a3 = acceleration(x + 0.5 * h * v2, v3)
            v4 = v + h * a3
            a4 = acceleration(x + h * v3, v4)
            x, v = x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            if not np.isfinite(x).all():
                raise SimulationError(f"{self.name} does not keep {self._press.name} together: give a shorter step")
            closed, columns = self._loops.closed(x[[self._driver]], x[None])
            x, v = closed[0], self._loops.rates(columns, np.zeros(columns.shape[:2]), v[self._driver])[0]
        end = self._end(x, v, begin, effort(x, v))
        return end if effort is free else replace(end, energy_error=None)

    def _working(self, scene: Scene) -> Effort:
        """Efforts of the drive on its joint, and of the loads on that of the slide."""
        press, states = self._press, cycle(self._press, points=2, speed=1.0)
        joint = next(j for j in range(len(press.joints)) if not press.axes[j].turns)
        (first, second), at = states.slide_position, states.joint_position[:, joint]
        along = float(np.sign((second - first) / (at[1] - at[0])))
        zero = float(first - along * at[0]) - dead_centres(press).bottom_position
        drive = scene.drive

        def effort(x: Array, v: Array) -> Array:
            result = np.zeros(len(x))
            if drive is not None:
                result[self._driver] = float(drive.torque(float(v[self._driver])))
            result[joint] = along * load_on_slide(scene, zero + along * float(x[joint]), along * float(v[joint]))
            return result

        return effort

    def _start(self, scene: Scene) -> tuple[Array, Array]:
        """Joint coordinates and rates (nv,) at the start of a scene, after the flywheel is put on."""
        self._model.dof_armature[self._driver] = scene.inertia
        mujoco.mj_setConst(self._model, self._data)
        angle = np.array([float(scene.angle)])
        x, columns = self._loops.closed(angle, self._loops.predicted(angle))
        return x[0], self._loops.rates(columns, np.zeros(columns.shape[:2]), scene.speed)[0]

    def _end(self, x: Array, v: Array, begin: tuple[float, float], effort: Array | float = 0.0) -> RunEnd:
        a, columns = self._acceleration(x, v, effort), self._columns()
        places = self._data.site_xpos[self._sites]
        gap = float(np.linalg.norm(places[::2] - places[1::2], axis=1).max())
        kinetic, potential = self._energies(x, v)
        _, force = self._efforts(x[None], v[None], a[None], columns[None])
        error = (kinetic + potential - sum(begin)) / begin[0]
        return RunEnd(float(x[self._driver]), float(v[self._driver]), gap, error, {name: f[0] for name, f in force.items()})

    def _load(self, x: Array, v: Array | None = None) -> None:
        """Compute places of the bodies, mass matrix, the loops' Jacobian and rates at joint coordinates (nv,) and rates (nv,)."""
        data = self._data
        data.qpos[:] = x
        mujoco.mj_fwdPosition(self._model, data)
        data.efc_force[:] = 0.0  # else `mj_rnePostConstraint` counts old values
        if v is not None:
            data.qvel[:] = v
            mujoco.mj_comVel(self._model, data)

    def _columns(self) -> Array:
        """(kept, nv) Jacobian of the loops' gaps, then of gear pairs, in the loaded state."""
        return np.asarray(self._data.efc_J.reshape(-1, self._model.nv)[self._loops.kept])

    def _terms(self, x: Array) -> tuple[Array, Array]:
        """Jacobian (rows, nv) and gaps (rows,) at joint coordinates (nv,)."""
        data = self._data
        data.qpos[:] = x
        mujoco.mj_fwdPosition(self._model, data)
        return data.efc_J.reshape(-1, self._model.nv).copy(), data.efc_pos.copy()

    def _site_accelerations(self, into: Array) -> None:
        """Write accelerations of the loops' ends (2 loops, 6) at zero joint accelerations, in the loaded state."""
        model, data = self._model, self._data
        data.qacc[:] = 0.0
        mujoco.mj_rnePostConstraint(model, data)
        for site, row in zip(self._sites, into, strict=True):
            mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_SITE, site, row, 0)
            if not model.site_bodyid[site]:  # of the world MuJoCo below 4 gives 0, and of bodies what they have beside free fall
                row[3:] = -model.opt.gravity

    def _drift(self, sites: Array) -> Array:
        """(n, kept) accelerations of the gaps from those of the ends (n, 2 loops, 6)."""
        apart = sites[:, ::2, 3:] - sites[:, 1::2, 3:]
        rows = np.zeros((len(sites), 3 * len(self._ends) + len(self._press.couplings)))
        rows[:, : 3 * len(self._ends)] = apart.reshape(len(sites), -1)
        return rows[:, self._loops.kept]

    def _drifts(self, x: Array, v: Array) -> Array:
        sites = np.empty((len(x), len(self._sites), 6))
        for k in range(len(x)):
            self._load(x[k], v[k])
            self._site_accelerations(sites[k])
        return self._drift(sites)

    def _efforts(self, x: Array, v: Array, a: Array, columns: Array) -> tuple[Array, dict[str, Array]]:
        """Driving torque (n,) and bearing forces (n, 3) of a motion (n, nv), with the Jacobians (n, rows, nv)."""
        model, data, press = self._model, self._data, self._press
        tree, wrench = np.empty_like(x), np.empty((len(x), model.nbody, 6))
        for k in range(len(x)):
            self._load(x[k], v[k])
            data.qacc[:] = a[k]
            mujoco.mj_rne(model, data, 1, tree[k])
            mujoco.mj_rnePostConstraint(model, data)
            wrench[k] = data.cfrc_int
        torque, rows = self._loops.multipliers(columns, tree)  # of forces by the second points on the first
        on_second = -rows[:, : 3 * len(self._ends)].reshape(len(x), -1, 3)
        return torque, with_loops(press, self._ends, wrench[:, self._bodies, 3:], on_second)

    def _acceleration(self, x: Array, v: Array, effort: Array | float = 0.0) -> Array:
        """(nv,) under efforts (nv,), from the equations of motion and of the loops together."""
        model, data = self._model, self._data
        self._load(x, v)
        sites = np.empty((1, len(self._sites), 6))
        self._site_accelerations(sites[0])
        columns, drift = self._columns(), self._drift(sites)[0]
        nv, rows = columns.shape[1], columns.shape[0]
        bias, system = np.empty(nv), np.zeros((nv + rows, nv + rows))
        mujoco.mj_rne(model, data, 0, bias)
        system[:nv, :nv] = self._inertia()
        system[nv:, :nv], system[:nv, nv:] = columns, columns.T
        right = np.concatenate([effort - bias, -drift])
        if self._loops.square:
            return np.asarray(np.linalg.solve(system, right)[:nv])
        return np.asarray(np.linalg.lstsq(system, right, rcond=RANK)[0][:nv])

    def _inertia(self) -> Array:
        """(nv, nv) mass matrix of the loaded state."""
        inertia = np.empty((self._model.nv, self._model.nv))
        mujoco.mj_fullM(self._model, self._data, inertia)
        return inertia

    def _energies(self, x: Array, v: Array) -> tuple[float, float]:
        """Kinetic and potential energy [J]."""
        self._load(x, v)
        heights = self._data.xipos @ self._model.opt.gravity
        return float(0.5 * v @ self._inertia() @ v), float(-self._model.body_mass @ heights)


class MujocoSteps(Mujoco):
    """Free runs by MuJoCo's own `mj_step` with RK4, with soft loops as stiff as the step allows."""

    inverse, how = False, ", mj_step"
    cannot = "closed loops: they stay open by what their stiffness allows; inverse dynamics with loops"
    left_out: ClassVar[Mapping[str, str]] = {**Mujoco.left_out, DIE: "its loops are softer than the die"}
    steps: tuple[float, ...] = (2e-3, 1e-3, 5e-4, 2e-4, 1e-4)

    def prepared(self, scene: Scene) -> Callable[[float], RunEnd]:
        """See `Peer`; the steps are taken in one call of `mujoco.rollout`."""
        return partial(self._own_steps, scene)

    def _own_steps(self, scene: Scene, step: float) -> RunEnd:
        (x, v), duration = self._start(scene), scene.duration
        begin, count = self._energies(x, v), steps_of(duration, step)
        model, data, stiffness = self._model, mujoco.MjData(self._model), (0.5 * count / duration) ** 2
        model.opt.timestep = duration / count
        model.eq_solref[:] = -stiffness, -2 * np.sqrt(stiffness)
        data.qpos[:], data.qvel[:] = x, v
        first = np.empty(mujoco.mj_stateSize(model, STATE))
        mujoco.mj_getState(model, data, first, STATE)
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(lambda message: None)  # MuJoCo would print it and write a log; the error below says it
        try:
            states, _ = rollout.rollout(model, data, first[None], nstep=count)
        finally:
            mujoco.set_mju_user_warning(before)
        mujoco.mj_setState(model, data, states[0, -1].copy(), STATE)
        if not (np.isfinite(states).all() and abs(data.time - duration) < 0.5 * duration / count):  # MuJoCo starts anew where it fails
            raise SimulationError(f"{self.name} does not keep {self._press.name} together: give a shorter step")
        return self._end(data.qpos.copy(), data.qvel.copy(), begin)


def _compiled(press: Linkage, ends: tuple[Ends, ...]) -> mujoco.MjModel:
    """The press as a MuJoCo model: bodies and joints of its tree, points of loops as ``connect`` equalities, gear pairs as joint ones.

    Raises:
        PinpressError: MuJoCo refuses it.
    """
    spec, tree = mujoco.MjSpec(), press.model
    spec.option.gravity = tree.gravity.linear
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.option.solver, spec.option.tolerance = mujoco.mjtSolver.mjSOL_NEWTON, 0.0
    spec.option.iterations = 2  # of a quadratic cost: the first one is exact
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    off = mujoco.mjtDisableBit
    spec.option.disableflags = int(off.mjDSBL_REFSAFE) | int(off.mjDSBL_CONTACT) | int(off.mjDSBL_ISLAND)
    bodies, carriers = [spec.worldbody], carriers_of(press)
    for j, name in enumerate(press.joints, start=1):
        if carriers[j] != j:
            bodies.append(None)  # a cross without mass: its joint is the carrier's
            continue
        chain = [j]
        while carriers[tree.parents[chain[0]]] == j:
            chain.insert(0, tree.parents[chain[0]])
        place, inertia = pin.SE3.Identity(), tree.inertias[j]
        for joint in chain:
            place = place * tree.jointPlacements[joint]
        turned = np.empty(4)
        mujoco.mju_mat2Quat(turned, place.rotation.ravel())
        body = bodies[tree.parents[chain[0]]].add_body(name=name, pos=place.translation, quat=turned)
        about = inertia.inertia
        body.mass, body.ipos, body.explicitinertial = inertia.mass, inertia.lever, True
        body.fullinertia = [about[0, 0], about[1, 1], about[2, 2], about[0, 1], about[0, 2], about[1, 2]]
        at = place.inverse()
        for joint in chain:
            at = at * tree.jointPlacements[joint]
            axis = press.axes[joint - 1]
            kind = mujoco.mjtJoint.mjJNT_HINGE if axis.turns else mujoco.mjtJoint.mjJNT_SLIDE
            body.add_joint(name=press.joints[joint - 1], type=kind, pos=at.translation, axis=at.rotation @ axis.direction)
        bodies.append(body)
    equality = partial(spec.add_equality, solimp=[0.9999, 0.9999, 0.001, 0.5, 2.0])
    site, kind = mujoco.mjtObj.mjOBJ_SITE, mujoco.mjtEq.mjEQ_CONNECT
    for k, end in enumerate(ends):
        bodies[end.joint1].add_site(name=f"{k}/1", pos=end.point1)
        bodies[end.joint2].add_site(name=f"{k}/2", pos=end.point2)
        equality(name=f"{end.name}/{k}", type=kind, objtype=site, name1=f"{k}/1", name2=f"{k}/2")
    for pair in press.couplings:
        names = {"name1": press.joints[pair.follower], "name2": press.joints[pair.leader]}
        geared = equality(type=mujoco.mjtEq.mjEQ_JOINT, objtype=mujoco.mjtObj.mjOBJ_JOINT, **names)
        geared.data[:2] = pair.offset, pair.multiplier
    try:
        return spec.compile()
    except ValueError as error:
        raise PinpressError(f"it refuses {press.name}: {' '.join(str(error).split())}") from None
