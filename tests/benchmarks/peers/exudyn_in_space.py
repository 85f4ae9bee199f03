"""A press in Exudyn that does not stand in one plane: rigid bodies with Euler parameters, and its joints.

As in the plane, every joint is an equation with a Lagrange multiplier, and inverse dynamics is a run over the turn with the crank held at
its speed. A cross without mass between two joints is a joint of its own, which holds one direction square to another. Equations that say
one thing twice, as those of Bricard's linkage, make Exudyn's singular; with one of the two left out its Newton's method still fails, at the
angle where that one is needed.
"""

from typing import Any

import exudyn
import numpy as np
import pinocchio as pin
from benchmarks.peers.exudyn_press import Exudyn, turn_settings
from benchmarks.peers.loop_equations import carriers_of
from benchmarks.peers.peer import Answer, Peer
from exudyn import itemInterface as items  # noqa: N813
from support.oracles.exudyn_solver import solve

from pinpress.common.errors import PinpressError
from pinpress.common.quantities import Array
from pinpress.kinematics.servo_motion import servo_cycle
from pinpress.linkage.linkage import Linkage

ALONG = 1e-12  # largest part of a crank's axis that is not along one of the world's


def exudyn_peer(press: Linkage) -> Peer:
    """The press in Exudyn, in its plane or in space.

    Raises:
        PinpressError: see `Exudyn` and `ExudynInSpace`.
    """
    return Exudyn(press) if press.engines[0] == "plane" else ExudynInSpace(press)


class ExudynInSpace(Peer):
    """A press in space in Exudyn."""

    cannot = Exudyn.cannot

    def __init__(self, press: Linkage) -> None:
        """Make the system.

        Raises:
            PinpressError: the press has gear pairs, welded loops, or more equations than it needs, or its crank does not turn about one of
                the world's axes on the frame.
        """
        if press.couplings or any(loop.type == "fixed" for loop in press.loops):
            raise PinpressError(f"{press.name} has gear pairs or welded loops, which are not compared in it")
        if press.rank < sum(3 + loop.held_rotations for loop in press.loops):
            raise PinpressError(f"loops of {press.name} hold each other, and its equations are then singular")
        self._driver = press.driver_indices[0] + 1
        about = press.model.jointPlacements[self._driver].rotation @ press.axes[self._driver - 1].direction
        self._coordinate = int(np.argmax(np.abs(about)))
        self._sign = float(about[self._coordinate])
        if press.model.parents[self._driver] or abs(abs(self._sign) - 1) > ALONG:
            raise PinpressError(f"it is compared with cranks on the frame, along one of the world's axes, unlike that of {press.name}")
        self.name = f"Exudyn {exudyn.config.Version()}"
        self._press = press
        self._carriers = carriers_of(press)
        self._container = exudyn.SystemContainer()
        self._mbs = self._container.AddSystem()
        self._centres = [np.zeros(3), *(body.lever for body in list(press.model.inertias)[1:])]
        self._drawn: Array = np.zeros((0, 7))
        self._drawn, _ = self._states(0.0, 0.0)
        self._bodies: dict[int, Any] = {0: self._mbs.AddObject(items.ObjectGround())}
        self._nodes: dict[int, Any] = {}
        self._add_bodies()
        self._joints = {**self._tree_joints(), **self._loop_joints()}
        self._add_sensors()
        self._mbs.Assemble()

    def inverse_dynamics(self, angle: Array, speed: float) -> Answer:
        """See `Peer`."""
        mbs, over_turn = self._mbs, turn_settings(angle, speed)
        mbs.SetObjectParameter(self._drive, "offset", float(self._sign * speed))
        places, rates = self._states(float(angle[0]), speed)
        initial = exudyn.ConfigurationType.Initial
        mbs.systemData.SetODE2Coordinates((places - self._drawn).ravel().tolist(), configuration=initial)
        mbs.systemData.SetODE2Coordinates_t(rates.ravel().tolist(), configuration=initial)
        solve(mbs, over_turn)
        force = {}
        for name, (joint, parent, axes) in self._joints.items():
            local = self._stored(self._forces[joint])
            turned = self._stored(self._rotations[parent]).reshape(-1, 3, 3) if parent else np.eye(3)[None]
            force[name] = -np.einsum("nij,nj->ni", turned @ axes, local)
        for j, name in enumerate(self._press.joints, start=1):
            if name not in force:  # a cross without mass
                force[name] = force[self._press.joints[self._carriers[j] - 1]]
        return Answer(-self._sign * self._stored(self._torque)[:, 0], force)

    def _states(self, angle: float, speed: float) -> tuple[Array, Array]:
        """Centres of mass and Euler parameters of all bodies that have a mass (bodies, 7), and their rates, closed."""
        tree, data = self._press.model, self._press.model.createData()
        state = servo_cycle(self._press, angle=[angle], speed=[speed])
        pin.forwardKinematics(tree, data, state.q[0], state.v[0])
        places: list[list[float]] = []
        rates: list[list[float]] = []
        for j in self._moving():
            place, velocity = data.oMi[j], pin.getVelocity(tree, data, j, pin.LOCAL)
            omega = velocity.angular
            turned = pin.Quaternion(place.rotation)
            w, xyz = turned.w, np.array(turned.vec())
            spin = 0.5 * np.array([-xyz @ omega, *(w * omega + np.cross(xyz, omega))])
            moving = place.rotation @ (velocity.linear + np.cross(omega, self._centres[j]))
            sign = 1.0 if not len(self._drawn) or self._drawn[len(places)][3:] @ np.array([w, *xyz]) > 0 else -1.0
            places.append([*place.act(self._centres[j]), sign * w, *(sign * xyz)])
            rates.append([*moving, *(sign * spin)])
        return np.array(places), np.array(rates)

    def _moving(self) -> list[int]:
        return [j for j in range(1, self._press.model.njoints) if self._carriers[j] == j]

    def _add_bodies(self) -> None:
        tree, mbs = self._press.model, self._mbs
        for k, j in enumerate(self._moving()):
            inside = tree.inertias[j]
            about = inside.inertia
            moments = [about[0, 0], about[1, 1], about[2, 2], about[1, 2], about[0, 2], about[0, 1]]
            self._nodes[j] = mbs.AddNode(items.NodeRigidBodyEP(referenceCoordinates=self._drawn[k].tolist()))
            self._bodies[j] = mbs.AddObject(items.ObjectRigidBody(mass=inside.mass, inertia=moments, nodeNumber=self._nodes[j]))
            centre = self._marker(j, inside.lever, np.eye(3))
            mbs.AddLoad(items.LoadForceVector(markerNumber=centre, loadVector=(inside.mass * tree.gravity.linear).tolist()))

    def _tree_joints(self) -> dict[str, tuple[Any, int, Array]]:
        """Joints of the tree: name -> object, the joint whose body carries its first side, and the axes of its forces there."""
        made = {}
        for j in self._moving():
            press, tree = self._press, self._press.model
            first, axis = j, press.axes[j - 1]
            while tree.parents[first] and self._carriers[tree.parents[first]] == j:
                first = tree.parents[first]
            if first not in (j, tree.parents[j]):
                raise PinpressError(f"{press.name} has several bodies without mass between two others, which are not compared in it")
            parent, place = tree.parents[first], tree.jointPlacements[first]
            if first != j:  # the axis of the cross on the parent stays square to that on the body
                on_parent, on_body = _frame(place.rotation @ press.axes[first - 1].direction, 0), _frame(axis.direction, 1)
                kind, held = items.ObjectJointGeneric, {"constrainedAxes": [1, 1, 1, 0, 0, 1]}
            else:
                column = 2 if axis.turns else 0
                on_body = _frame(axis.direction, column)
                on_parent = place.rotation @ on_body
                kind, held = (items.ObjectJointRevoluteZ if axis.turns else items.ObjectJointPrismaticX), {}
            ends = [self._marker(parent, place.translation, on_parent), self._marker(j, np.zeros(3), on_body)]
            made[press.joints[j - 1]] = (self._mbs.AddObject(kind(markerNumbers=ends, **held)), parent, on_parent)
        return made

    def _loop_joints(self) -> dict[str, tuple[Any, int, Array]]:
        """Loops, as `_tree_joints`."""
        made = {}
        for loop in self._press.loops:
            turns = _frame(np.array([1.0, 0.0, 0.0]), 2)
            axes1, axes2 = loop.rotation1 @ turns, loop.rotation2 @ turns
            ends = [self._marker(loop.joint1, loop.point1, axes1), self._marker(loop.joint2, loop.point2, axes2)]
            pinned = loop.type == "revolute"
            kind, held = (items.ObjectJointRevoluteZ, {}) if pinned else (items.ObjectJointGeneric, {"constrainedAxes": [1, 1, 1, 0, 0, 0]})
            made[loop.name] = (self._mbs.AddObject(kind(markerNumbers=ends, **held)), loop.joint1, axes1)
        return made

    def _add_sensors(self) -> None:
        mbs, kinds = self._mbs, exudyn.OutputVariableType
        still = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0))
        crank = items.MarkerNodeRotationCoordinate(nodeNumber=self._nodes[self._driver], rotationCoordinate=self._coordinate)
        self._drive = mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[still, mbs.AddMarker(crank)], velocityLevel=True))

        def stored(kind: Any, **what: Any) -> Any:
            return mbs.AddSensor(kind(storeInternal=True, writeToFile=False, **what))

        self._torque = stored(items.SensorObject, objectNumber=self._drive, outputVariableType=kinds.Force)
        force, joints = {"outputVariableType": kinds.ForceLocal}, [joint for joint, _, _ in self._joints.values()]
        self._forces = {joint: stored(items.SensorObject, objectNumber=joint, **force) for joint in joints}
        self._rotations = {
            j: stored(items.SensorBody, bodyNumber=self._bodies[j], outputVariableType=kinds.RotationMatrix) for j in self._moving()
        }

    def _stored(self, sensor: Any) -> Array:
        return np.asarray(self._mbs.GetSensorStoredData(sensor))[:, 1:]

    def _marker(self, joint: int, point: Array, axes: Array) -> Any:
        """A marker on the body of a Pinocchio joint (0: the frame), at a point (3,) and along axes in that joint's frame."""
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = axes, point - self._centres[joint]
        return self._mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=self._bodies[joint], localHT=place))


def _frame(axis: Array, column: int) -> Array:
    """Axes as columns, of which one is along a vector."""
    along = axis / np.linalg.norm(axis)
    first = np.cross(np.eye(3)[np.argmin(np.abs(along))], along)
    first /= np.linalg.norm(first)
    return np.roll(np.stack([first, np.cross(along, first), along], axis=1), column + 1, axis=1)
