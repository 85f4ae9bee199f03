"""A press in Drake: its multibody algorithms with exact loops in NumPy, and runs by its own discrete steps.

Drake's joints form a tree, and its constraints for loops (ball, weld, coupler) exist in discrete plants with the solver SAP alone. So there
are two ways. `Drake` takes Jacobians and bias accelerations of the loops' points, `CalcInverseDynamics` and
`CalcSpatialAccelerationsFromVdot` from a continuous plant, and an expert solves the loops' equations in NumPy; bearing forces are sums of
mass times acceleration over the bodies that a joint carries (Drake's own reaction forces belong to forward dynamics, of which the torque
would have to be known). `DrakeSteps` runs freely by Drake's own steps with `AddBallConstraint`, whose error falls with the step; a pin
needs a second ball on its axis, and a flywheel is the rotor of an actuator.

Bodies have their origins at their centres of mass, so that Drake's accelerations of bodies are those of the centres.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from importlib.metadata import version
from typing import Any, ClassVar

import numpy as np
from benchmarks.peers.loop_equations import Ends, LoopEquations, ends_of, with_loops
from benchmarks.peers.peer import Answer, Peer, RunEnd, steps_of

from pinpress.accuracy.scenes import CLUTCH, DIE, SPEED_LAW, Scene
from pinpress.common.errors import PinpressError, SimulationError
from pinpress.common.quantities import Array
from pinpress.linkage.linkage import Linkage

ORIGIN = np.zeros((3, 1))


@dataclass(frozen=True, eq=False)
class Plant:
    """A press as a plant.

    Attributes:
        plant: Drake's plant, finalised.
        context: its context.
        frames: of every pair of points that coincide the frame at the first one, drawn along the world's axes, and that at the second one.
    """

    plant: Any
    context: Any
    frames: tuple[tuple[Any, Any], ...]


class Drake(Peer):
    """Inverse dynamics of a press with exact loops on the terms of Drake."""

    how = " + NumPy"
    cannot = "loops in continuous time: closing, rates and bearing forces are NumPy's"

    def __init__(self, press: Linkage) -> None:
        """Make the plant.

        Raises:
            PinpressError: the press has several drivers, gear pairs, no loops, a welded loop, or a crank that does not turn fully.
        """
        self._ends = ends_of(press)
        if press.couplings:
            raise PinpressError(f"{press.name} has gear pairs, which are not compared in it")
        from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces  # slow to import

        self.name = f"Drake {version('drake')}{self.how}"
        self._press = press
        self._made = plant_of(press, self._ends, 0.0, 0.0)
        tree = press.model
        self._carried = np.zeros((tree.nv, tree.nv))  # joint by body
        for body in range(1, tree.njoints):
            joint = body
            while joint:
                self._carried[joint - 1, body - 1] = tree.inertias[body].mass
                joint = tree.parents[joint]
        self._speeds = JacobianWrtVariable.kV
        self._forces = MultibodyForces(self._made.plant)
        self._loops = LoopEquations(press, self.name, self._terms)

    def inverse_dynamics(self, angle: Array, speed: float) -> Answer:
        """See `Peer`."""
        loops = self._loops
        x, columns = loops.closed(np.asarray(angle, dtype=float), loops.predicted(np.asarray(angle, dtype=float)))
        v = loops.rates(columns, np.zeros(columns.shape[:2]), speed)
        drift = np.array([self._drift(*state) for state in zip(x, v, strict=True)])
        a = loops.rates(columns, drift[:, loops.kept], 0.0)
        return Answer(*self._efforts(x, v, a, columns))

    def _terms(self, x: Array) -> tuple[Array, Array]:
        """Jacobian (rows, nv) and gaps (rows,) at joint coordinates (nv,), in the frames at the first points."""
        plant, context = self._made.plant, self._made.context
        plant.SetPositions(context, x)
        columns, gaps = [], []
        for first, second in self._made.frames:
            gaps.append(plant.CalcPointsPositions(context, second, ORIGIN, first)[:, 0])
            columns.append(plant.CalcJacobianTranslationalVelocity(context, self._speeds, second, ORIGIN, first, first))
        return np.concatenate(columns), np.concatenate(gaps)

    def _drift(self, x: Array, v: Array) -> Array:
        """(rows,) accelerations of the gaps without joint accelerations."""
        plant, context = self._made.plant, self._made.context
        plant.SetPositionsAndVelocities(context, np.concatenate([x, v]))
        bias = plant.CalcBiasTranslationalAcceleration
        return np.concatenate([bias(context, self._speeds, second, ORIGIN, first, first)[:, 0] for first, second in self._made.frames])

    def _efforts(self, x: Array, v: Array, a: Array, columns: Array) -> tuple[Array, dict[str, Array]]:
        """Driving torque (n,) and bearing forces (n, 3) of a motion (n, nv), with the Jacobians (n, kept, nv)."""
        plant, context, press = self._made.plant, self._made.context, self._press
        count, bodies = x.shape
        efforts, moved, turned = np.empty_like(x), np.empty((count, bodies, 3)), np.empty((count, len(self._ends), 3, 3))
        for i in range(count):
            plant.SetPositionsAndVelocities(context, np.concatenate([x[i], v[i]]))
            plant.CalcForceElementsContribution(context, self._forces)  # weights
            efforts[i] = plant.CalcInverseDynamics(context, a[i], self._forces)
            accelerations = plant.CalcSpatialAccelerationsFromVdot(context, a[i])
            moved[i] = [acceleration.translational() for acceleration in accelerations[1:]]
            for k, (first, _) in enumerate(self._made.frames):
                turned[i, k] = first.CalcRotationMatrixInWorld(context).matrix()
        torque, rows = self._loops.multipliers(columns, efforts)  # of forces on the second points, in the frames at the first ones
        on_second = (turned @ rows.reshape(count, -1, 3, 1))[..., 0]
        tree = self._carried @ (moved - press.model.gravity.linear)
        return torque, with_loops(press, self._ends, tree, on_second)


class DrakeSteps(Drake):
    """Free runs by Drake's own discrete steps with ball constraints and the solver SAP."""

    inverse, how = False, ", SAP"
    cannot = "steps of an order above the first; inverse dynamics with loops"
    steps: tuple[float, ...] = (4e-3, 2e-3, 1e-3, 5e-4, 2e-4)
    left_out: ClassVar[Mapping[str, str]] = {
        CLUTCH: "its steps do not end where a clutch grips",
        DIE: "its error falls with the step alone",
        SPEED_LAW: "its error falls with the step alone",
    }

    def prepared(self, scene: Scene) -> Callable[[float], RunEnd]:
        """See `Peer`; a plant with steps of each length is made when it is first asked for."""
        angle = np.array([scene.angle])
        x, columns = self._loops.closed(angle, self._loops.predicted(angle))
        v = self._loops.rates(columns, np.zeros(columns.shape[:2]), scene.speed)
        made = cache(partial(plant_of, self._press, self._ends, inertia=scene.inertia))
        return lambda step: self._run(made(scene.duration / steps_of(scene.duration, step)), scene, np.concatenate([x[0], v[0]]))

    def _run(self, made: Plant, scene: Scene, state: Array) -> RunEnd:
        from pydrake.systems.analysis import Simulator  # slow to import

        plant, press = made.plant, self._press
        simulator = Simulator(plant)
        context = simulator.get_mutable_context()
        plant.SetPositionsAndVelocities(context, state)
        begin = plant.CalcKineticEnergy(context), plant.CalcPotentialEnergy(context)  # with the flywheel's
        try:
            simulator.AdvanceTo(scene.duration)
        except RuntimeError as error:
            raise SimulationError(f"{self.name} does not keep {press.name} together: {' '.join(str(error).split())}") from None
        x, v = plant.GetPositions(context).copy(), plant.GetVelocities(context).copy()
        gap = max(float(np.linalg.norm(plant.CalcPointsPositions(context, second, ORIGIN, first))) for first, second in made.frames)
        gained = plant.CalcKineticEnergy(context) + plant.CalcPotentialEnergy(context) - sum(begin)
        driver = self._loops.driver
        return RunEnd(float(x[driver]), float(v[driver]), gap, gained / begin[0], self._force(x, v, scene.inertia))

    def _force(self, x: Array, v: Array, inertia: float) -> dict[str, Array]:
        """Bearing forces (3,) in a state without torque, from the equations of motion and of the loops together."""
        plant, context, loops = self._made.plant, self._made.context, self._loops
        columns, drift = self._terms(x)[0][loops.kept], self._drift(x, v)[loops.kept]
        nv, rows = columns.shape[1], columns.shape[0]
        plant.CalcForceElementsContribution(context, self._forces)
        system = np.zeros((nv + rows, nv + rows))
        system[:nv, :nv] = plant.CalcMassMatrix(context)
        system[loops.driver, loops.driver] += inertia
        system[nv:, :nv], system[:nv, nv:] = columns, columns.T
        right = np.concatenate([-plant.CalcInverseDynamics(context, np.zeros(nv), self._forces), -drift])
        a = np.linalg.lstsq(system, right, rcond=None)[0][:nv]
        _, force = self._efforts(x[None], v[None], a[None], columns[None])
        return {name: each[0] for name, each in force.items()}


def plant_of(press: Linkage, ends: tuple[Ends, ...], step: float, inertia: float) -> Plant:
    """The press as a plant.

    Args:
        press: a press without gear pairs.
        ends: its points that coincide.
        step: time step of a discrete plant, with ball constraints; 0 for a continuous plant, without any [s].
        inertia: moment of inertia of a flywheel on the driver of a discrete plant [kg m2].
    """
    from pydrake.math import RigidTransform, RotationMatrix  # slow to import, and an extra of its own, as all of Drake here
    from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
    from pydrake.multibody.tree import FixedOffsetFrame, PrismaticJoint, RevoluteJoint, RotationalInertia, SpatialInertia

    plant, tree = MultibodyPlant(step), press.model
    if step:
        plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    plant.mutable_gravity_field().set_gravity_vector(np.array(tree.gravity.linear))
    bodies, drawn = [plant.world_body()], [np.eye(3)]
    centres = [np.zeros(3), *(np.array(body.lever) for body in list(tree.inertias)[1:])]
    joints = []

    def frame(name: str, joint: int, point: Array, rotation: Array) -> Any:
        place = RigidTransform(RotationMatrix(rotation), point - centres[joint])
        return plant.AddFrame(FixedOffsetFrame(name, bodies[joint].body_frame(), place))

    for j, (name, axis) in enumerate(zip(press.joints, press.axes, strict=True), start=1):
        place, inside = tree.jointPlacements[j], tree.inertias[j]
        about = inside.inertia
        moments = (about[0, 0], about[1, 1], about[2, 2], about[0, 1], about[0, 2], about[1, 2])
        mass = SpatialInertia.MakeFromCentralInertia(inside.mass, np.zeros(3), RotationalInertia(*moments)) if inside.mass else None
        bodies.append(plant.AddRigidBody(name, mass or SpatialInertia.Zero()))
        drawn.append(drawn[tree.parents[j]] @ place.rotation)
        on_parent = frame(f"{name}/parent", tree.parents[j], place.translation, place.rotation)
        on_child = frame(f"{name}/child", j, np.zeros(3), np.eye(3))
        kind = RevoluteJoint if axis.turns else PrismaticJoint
        joints.append(plant.AddJoint(kind(name, on_parent, on_child, axis.direction)))
    frames = []
    for k, end in enumerate(ends):
        first = frame(f"{k}/first", end.joint1, end.point1, drawn[end.joint1].T)
        frames.append((first, frame(f"{k}/second", end.joint2, end.point2, np.eye(3))))
        if step:
            at1, at2 = end.point1 - centres[end.joint1], end.point2 - centres[end.joint2]
            plant.AddBallConstraint(bodies[end.joint1], at1, bodies[end.joint2], at2)
    if step:
        rotor = plant.AddJointActuator("flywheel", joints[press.driver_indices[0]])
        rotor.set_default_rotor_inertia(inertia)
        rotor.set_default_gear_ratio(1.0)
    plant.Finalize()
    if [joint.velocity_start() for joint in joints] != list(range(len(joints))):
        raise PinpressError("Drake orders the joints otherwise")
    return Plant(plant, plant.CreateDefaultContext(), tuple(frames))
