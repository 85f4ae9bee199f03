"""A planar press in Exudyn: rigid bodies in the plane (x to the right, y for the press's z), about their centres of mass, and its joints.

Every joint is an equation with a Lagrange multiplier, which is its force. Inverse dynamics is a dynamic run over the turn with the crank
held at its speed by a constraint of velocities, one step an angle, with sensors on all joints; its error falls with the square of the
number of angles.

These were tried on the ZXN2-3000(B) and left: generalised alpha (less exact in the same time, and with radius 1 its forces oscillate),
Newton's method to 1e-12 (no more exact, and slower) and to 1e-8 (forces of single states are off), a Jacobian kept as long as it converges
(slower), and Newmark with index 2 (the trapezoidal rule). The initial accelerations of each state, solved anew at every angle, are more
exact than a run, but they need positions and velocities that are closed before. The sparse linear solver is slower. `sys.exudynFast`
(without range checks) gains less than a tenth. The explicit integrators refuse joints.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import exudyn
import numpy as np
import pinocchio as pin
from benchmarks.peers.peer import Answer, Peer, RunEnd, load_on_slide, steps_of
from exudyn import itemInterface as items  # noqa: N813
from support.oracles.exudyn_solver import solve

from pinpress.accuracy.scenes import CLUTCH, Scene, SpeedLaw
from pinpress.common.errors import PinpressError
from pinpress.common.quantities import Array
from pinpress.kinematics.cycle import cycle
from pinpress.kinematics.servo_motion import servo_cycle
from pinpress.kinematics.slide_path import dead_centres
from pinpress.linkage.linkage import Linkage

NEWTON = 1e-10  # relative tolerance; at 1e-8 the forces of single states are off
RADIUS = 0.9  # spectral radius of generalised alpha: with 1 stiff forces ring, with 0.6 errors are twenty times as large
FLAT = (0, 2)  # axes of the press's plane in the world


@dataclass(frozen=True, eq=False)
class System:
    """A planar press in Exudyn.

    Attributes:
        container: Exudyn's container, to be kept together with ``mbs``.
        mbs: Exudyn's system of bodies.
        bodies: bodies in Pinocchio's order of joints, the ground first.
        nodes: nodes of the bodies; None for the ground.
        joints: name of a joint or loop -> number of its object.
        centres: (joints + 1, 3) centres of mass in the joints' frames [m].
        rotations: (joints + 1, 3, 3) rotations of these frames in the drawn pose of the tree.
        signs: (joints + 1,) signs of the angles about the joints' axes, positive where they turn counter-clockwise in the plane; 0 for
            joints that slide.
        drawn: (joints + 1, 3) centres of mass in the world in the drawn pose of the tree [m].
    """

    container: Any
    mbs: Any
    bodies: tuple[Any, ...]
    nodes: tuple[Any, ...]
    joints: dict[str, Any]
    centres: Array
    rotations: Array
    signs: Array
    drawn: Array

    def marker(self, joint: int, point: Array) -> Any:
        """A marker on the body of a Pinocchio joint (0: the frame), at a point (3,) in that joint's frame [m]."""
        return _marker(self.mbs, self.bodies[joint], self.rotations[joint] @ (point - self.centres[joint]))


def build(press: Linkage) -> System:
    """The bodies, weights and joints of a planar press, not yet assembled.

    Raises:
        PinpressError: the linkage is not planar, has gear pairs, or has more equations than it needs.
    """
    plane = press.plane_or_refuse(f"only planar linkages are compared in it, and {press.name} is not planar")
    if press.couplings:
        raise PinpressError(f"{press.name} has gear pairs, which are not compared in it")
    if plane.redundant:
        raise PinpressError(f"loops of {press.name} hold each other, and its equations are then singular")
    tree, data = press.model, press.model.createData()
    pin.forwardKinematics(tree, data, pin.neutral(tree))
    places = list(data.oMi)
    places[0] = pin.SE3.Identity()
    centres = np.array([np.zeros(3), *(inertia.lever for inertia in list(tree.inertias)[1:])])
    drawn = np.array([place.act(centre) for place, centre in zip(places, centres, strict=True)])
    rotations = np.array([place.rotation for place in places])
    signs = [0.0] + [-float((r @ a.direction)[1]) * a.turns for r, a in zip(rotations[1:], press.axes, strict=True)]
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    bodies, nodes = _add_bodies(mbs, tree, rotations, drawn)
    joints: dict[str, Any] = {}
    system = System(container, mbs, bodies, nodes, joints, centres, rotations, np.array(signs), drawn)
    joints.update(_added_joints(press, system))
    return system


def _add_bodies(mbs: Any, tree: pin.Model, rotations: Array, drawn: Array) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Add bodies with their weights; return bodies and nodes as in `System`."""
    bodies, nodes = [mbs.AddObject(items.ObjectGround())], [None]
    for j in range(1, tree.njoints):
        inertia = tree.inertias[j]
        about = float((rotations[j] @ inertia.inertia @ rotations[j].T)[1, 1])
        nodes.append(mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[*drawn[j][list(FLAT)].tolist(), 0.0])))
        bodies.append(mbs.AddObject(items.ObjectRigidBody2D(mass=inertia.mass, inertia=about, nodeNumber=nodes[j])))
        centre = _marker(mbs, bodies[j], np.zeros(3))
        mbs.AddLoad(items.LoadForceVector(markerNumber=centre, loadVector=_flat(inertia.mass * tree.gravity.linear)))
    return tuple(bodies), tuple(nodes)


def _added_joints(press: Linkage, system: System) -> Iterator[tuple[str, Any]]:
    """Add joints and loops; yield their names and objects."""
    tree, mbs = press.model, system.mbs
    for j, (name, axis) in enumerate(zip(press.joints, press.axes, strict=True), start=1):
        ends = [system.marker(tree.parents[j], tree.jointPlacements[j].translation), system.marker(j, np.zeros(3))]
        if axis.turns:
            yield name, mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=ends))
        else:
            x, y, _ = along = _flat(system.rotations[j] @ axis.direction)
            rail = items.ObjectJointPrismatic2D(markerNumbers=ends, axisMarker0=along, normalMarker1=[-y, x, 0.0])
            yield name, mbs.AddObject(rail)
    for loop in press.loops:
        ends = [system.marker(loop.joint1, loop.point1), system.marker(loop.joint2, loop.point2)]
        yield loop.name, mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=ends))


def begin(press: Linkage, system: System, angle: float, speed: float) -> None:
    """Set the initial state of an assembled system, closed, at a crank angle [rad] and speed [rad/s]."""
    state = servo_cycle(press, angle=[angle], speed=[speed])
    tree, data = press.model, press.model.createData()
    pin.forwardKinematics(tree, data, state.q[0], state.v[0])
    places, rates = np.zeros((tree.njoints, 3)), np.zeros((tree.njoints, 3))
    for j in range(1, tree.njoints):
        parent, x, v = tree.parents[j], state.joint_position[0, j - 1], state.v[0, j - 1]
        velocity = pin.getVelocity(tree, data, j, pin.LOCAL_WORLD_ALIGNED)
        places[j, :2] = (data.oMi[j].act(system.centres[j]) - system.drawn[j])[list(FLAT)]
        rates[j, :2] = (velocity.linear + np.cross(velocity.angular, data.oMi[j].rotation @ system.centres[j]))[list(FLAT)]
        places[j, 2], rates[j, 2] = places[parent, 2] + system.signs[j] * x, rates[parent, 2] + system.signs[j] * v
    initial = exudyn.ConfigurationType.Initial
    system.mbs.systemData.SetODE2Coordinates(places[1:].ravel(), configuration=initial)
    system.mbs.systemData.SetODE2Coordinates_t(rates[1:].ravel(), configuration=initial)


def settings(duration: float, steps: int) -> Any:
    """Settings of a run without output or files, with steps of equal length."""
    made = exudyn.SimulationSettings()
    made.solution.file.write = False
    made.solution.solverInformationFileName = ""
    made.linearSolver.solverType = exudyn.LinearSolverType.EigenDense
    made.solution.sensors.writePeriod = duration / steps
    run = made.timeIntegration
    run.numberOfSteps, run.endTime = steps, duration
    run.verboseMode = run.verboseModeFile = 0
    run.adaptiveStep = False
    run.newton.useModifiedNewton = run.newton.modifiedNewtonJacUpdatePerStep = True
    run.newton.relativeTolerance = NEWTON
    run.generalizedAlpha.spectralRadius = RADIUS
    return made


def turn_settings(angle: Array, speed: float) -> Any:
    """Settings of a run over crank angles (n,) at a speed, an angle a step. Raises PinpressError if the angles are no such run."""
    step = (angle[-1] - angle[0]) / max(1, len(angle) - 1)
    if len(angle) < 2 or not np.abs(np.diff(angle) - step).max() < 1e-9 * abs(step) or not step * speed > 0:
        raise PinpressError("give two or more crank angles in equal steps that go with the speed: Exudyn runs from one to the next")
    return settings((angle[-1] - angle[0]) / speed, len(angle) - 1)


class Exudyn(Peer):
    """A planar press in Exudyn."""

    cannot = "inverse dynamics but by a run in time, with its error; singular loops; closing: it starts from a closed pose"
    left_out: ClassVar[Mapping[str, str]] = {CLUTCH: "its steps do not end where a clutch grips"}
    steps: tuple[float, ...] = (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4)

    def __init__(self, press: Linkage) -> None:
        """Make the system of inverse dynamics.

        Raises:
            PinpressError: as `build`, or the crank does not turn on the frame.
        """
        self._driver = press.driver_indices[0] + 1
        self._driven = build(press)
        if press.model.parents[self._driver] != 0:
            raise PinpressError(f"it is compared with cranks on the frame, and that of {press.name} is not")
        self.name = f"Exudyn {exudyn.config.Version()}"
        self._press = press
        self._sign = self._driven.signs[self._driver]
        mbs = self._driven.mbs
        still = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0))
        turning = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=self._driven.nodes[self._driver], coordinate=2))
        self._drive = mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[still, turning], velocityLevel=True))
        kinds = exudyn.OutputVariableType
        self._torque = _sensor(mbs, items.SensorObject, objectNumber=self._drive, outputVariableType=kinds.Force)
        self._forces = {
            name: _sensor(mbs, items.SensorObject, objectNumber=joint, outputVariableType=self._force_of(name))
            for name, joint in self._driven.joints.items()
        }
        self._angles = {
            name: _sensor(mbs, items.SensorNode, nodeNumber=self._driven.nodes[j], outputVariableType=kinds.Coordinates)
            for j, name in enumerate(press.joints, start=1)
            if not press.axes[j - 1].turns
        }
        self._driven.mbs.Assemble()

    def inverse_dynamics(self, angle: Array, speed: float) -> Answer:
        """See `Peer`."""
        system, over_turn = self._driven, turn_settings(angle, speed)
        mbs = system.mbs
        mbs.SetObjectParameter(self._drive, "offset", float(self._sign * speed))
        begin(self._press, system, float(angle[0]), speed)
        solve(mbs, over_turn)

        def stored(sensor: Any) -> Array:
            return np.asarray(mbs.GetSensorStoredData(sensor))[:, 1:]

        force = {}
        for name, sensor in self._forces.items():
            turned = stored(self._angles[name])[:, 2] if name in self._angles else None
            force[name] = _upright(stored(sensor), turned)
        return Answer(-self._sign * stored(self._torque)[:, 0], force)

    def prepared(self, scene: Scene) -> Callable[[float], RunEnd]:
        """See `Peer`.

        A stiff law is a damper; motor and loads are connectors with functions of ours. Under a stiff law the trapezoidal rule and its
        forces ring, so that generalised alpha takes its place.
        """
        system, drive, kind = build(self._press), scene.drive, exudyn.DynamicSolverType
        mbs, sign = system.mbs, self._sign
        still = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0))

        def marked(joint: int, coordinate: int) -> list[Any]:
            return [still, mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=system.nodes[joint], coordinate=coordinate))]

        if isinstance(drive, SpeedLaw):
            law = {"damping": drive.gain, "velocityOffset": float(sign * drive.speed)}
            mbs.AddObject(items.ObjectConnectorCoordinateSpringDamperExt(markerNumbers=marked(self._driver, 2), **law))
        elif drive is not None:
            _force(mbs, marked(self._driver, 2), lambda _, t, item, u, v, *__: float(-sign * drive.torque(sign * v)))
        if scene.loads:
            joint, zero = self._slide(system)
            _force(mbs, marked(joint, 1), lambda _, t, item, u, v, *__: -load_on_slide(scene, zero + u, v))
        mbs.Assemble()
        own = mbs.GetObjectParameter(system.bodies[self._driver], "inertia")
        mbs.SetObjectParameter(system.bodies[self._driver], "inertia", own + scene.inertia)
        solver = kind.GeneralizedAlpha if isinstance(drive, SpeedLaw) else kind.TrapezoidalIndex2

        def run(step: float) -> RunEnd:
            begin(self._press, system, scene.angle, scene.speed)
            initial = exudyn.ConfigurationType.Initial
            kinetic, potential = self._energies(system, lambda get: get(configuration=initial))
            solve(mbs, settings(scene.duration, steps_of(scene.duration, step)), solver)
            gained = sum(self._energies(system, lambda get: get())) - kinetic - potential
            return self._end(system, gained / kinetic if drive is None and not scene.loads else None)

        return run

    def _slide(self, system: System) -> tuple[int, float]:
        """Pinocchio's joint of the slide, and its height above bottom dead centre where the centre of mass is as drawn [m].

        Raises:
            PinpressError: the slide is no body on an upright guide.
        """
        press, heights = self._press, []
        joint = next((j for j in range(1, press.model.njoints) if not system.signs[j]), 0)
        states, data = cycle(press, points=3, speed=1.0), press.model.createData()
        for q in states.q:
            pin.forwardKinematics(press.model, data, q)
            heights.append(float(data.oMi[joint].act(system.centres[joint])[2] - system.drawn[joint][2]))
        zero = states.slide_position - np.array(heights)
        if not joint or np.ptp(zero) > 1e-9 * press.size:
            raise PinpressError(f"it is compared at work with slides on upright guides, and that of {press.name} is not")
        return joint, float(zero[0]) - dead_centres(press).bottom_position

    def _end(self, system: System, error: float | None) -> RunEnd:
        mbs = system.mbs
        x, v = mbs.systemData.GetODE2Coordinates().reshape(-1, 3), mbs.systemData.GetODE2Coordinates_t().reshape(-1, 3)
        force = {}
        for name, joint in system.joints.items():
            output = np.asarray(mbs.GetObjectOutput(joint, self._force_of(name)))[None]
            turned = x[[self._press.joints.index(name)], 2] if name in self._angles else None
            force[name] = _upright(output, turned)[0]
        row = self._driver - 1
        return RunEnd(self._sign * float(x[row, 2]), self._sign * float(v[row, 2]), self._gap(system, x), error, force)

    def _force_of(self, name: str) -> Any:
        kinds, press = exudyn.OutputVariableType, self._press
        slides = name in press.joints and not press.axes[press.joints.index(name)].turns
        return kinds.ForceLocal if slides else kinds.Force

    def _energies(self, system: System, state: Callable[[Callable[..., Any]], Any]) -> tuple[float, float]:
        """Kinetic and potential energy [J] of the state that Exudyn's function returns."""
        tree, data = self._press.model, system.mbs.systemData
        x, v = state(data.GetODE2Coordinates).reshape(-1, 3), state(data.GetODE2Coordinates_t).reshape(-1, 3)
        mass = np.array([body.mass for body in list(tree.inertias)[1:]])
        about = [system.mbs.GetObjectParameter(body, "inertia") for body in system.bodies[1:]]
        kinetic = 0.5 * float(mass @ (v[:, 0] ** 2 + v[:, 1] ** 2) + about @ v[:, 2] ** 2)
        return kinetic, -float(mass @ (x[:, :2] @ tree.gravity.linear[list(FLAT)]))

    def _gap(self, system: System, x: Array) -> float:
        """Largest distance between the two sides of a pin [m], at coordinates (bodies, 3)."""
        tree = self._press.model
        turned = np.concatenate([[0j], np.exp(1j * x[:, 2])])
        centres = system.drawn[:, 0] + 1j * system.drawn[:, 2]
        centres[1:] += x[:, 0] + 1j * x[:, 1]

        def place(joint: int, point: Array) -> complex:
            arm = system.rotations[joint] @ (point - system.centres[joint])
            return complex(centres[joint] + (turned[joint] if joint else 1.0) * (arm[0] + 1j * arm[2]))

        pins = [(tree.parents[j], tree.jointPlacements[j].translation, j, np.zeros(3)) for j in range(1, tree.njoints) if system.signs[j]]
        pins += [(loop.joint1, loop.point1, loop.joint2, loop.point2) for loop in self._press.loops]
        return max(abs(place(j1, p1) - place(j2, p2)) for j1, p1, j2, p2 in pins)


def _upright(multipliers: Array, turned: Array | None) -> Array:
    """(n, 3) forces of parent on child in world axes [N].

    Args:
        multipliers: (n, 2 or 3) forces of child on parent in Exudyn's plane; those of a guide in the axes of its slider [N].
        turned: (n,) angle of that slider [rad]; None for a pin.
    """
    flat = -(multipliers[:, 0] + 1j * multipliers[:, 1])
    if turned is not None:
        flat = flat * np.exp(1j * turned)
    return np.stack([flat.real, np.zeros(len(flat)), flat.imag], axis=1)


def _force(mbs: Any, markers: list[Any], law: Callable[..., float]) -> None:
    """A connector whose force along the second marker's coordinate is the negative of a law's."""
    mbs.AddObject(
        items.ObjectConnectorCoordinateSpringDamper(markerNumbers=markers, stiffness=0.0, damping=0.0, springForceUserFunction=law)
    )


def _flat(vector: Array) -> list[float]:
    return [float(vector[0]), float(vector[2]), 0.0]


def _marker(mbs: Any, body: Any, arm: Array) -> Any:
    return mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=_flat(arm)))


def _sensor(mbs: Any, kind: Any, **what: Any) -> Any:
    return mbs.AddSensor(kind(storeInternal=True, writeToFile=False, **what))
