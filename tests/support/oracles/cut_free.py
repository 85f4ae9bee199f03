"""Any linkage's equations of motion with all bodies cut free: dense, and nothing of the library's but the kinematics.

What balances without any motion or load is the null space, by singular values; the share of what is open is chosen in it by least squares.
"""

from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
from support.generators.spatial_linkages import Loops, null_space

ZERO = 1e-9  # share of the largest below which a singular value, or a component of an idle force, is zero


class CutFree(NamedTuple):
    """Forces and moments (bearings, 6), torques of couplings (nc,) and drives (nd,); components (bearings, 6) and couplings (nc,)
    that idle forces reach, and (k, bearings, 6) a basis of these; the least singular value that decided a share, as a part of its matrix:
    rounding grows by its reciprocal."""

    wrenches: np.ndarray
    couplings: np.ndarray
    drives: np.ndarray
    open: np.ndarray
    open_couplings: np.ndarray
    idle: np.ndarray
    least: float
    teeth: np.ndarray


def cut_free(press, motion, i, loads=(), stiffness=None, flanks=None):
    """Newton's and Euler's equations of all bodies at state i, with a force and a moment of every bearing, a torque of every gear pair and
    drive, and a force between the teeth of every ``<gear_mesh>`` as unknowns; of what they leave open the share with the least elastic
    energy (where there is a stiffness), then the least sum of squared forces, of squared moments, of squared torques.

    Teeth push apart, whichever flank they touch with: ``flanks``, the signs of their tangential forces, follow from a solution without.
    """
    if flanks is None and meshes(press):
        flanks = np.sign(cut_free(press, motion, i, loads, stiffness, np.zeros(len(meshes(press)))).teeth)
    model, loops = press.model, Loops(press.text.decode(), press.model)
    data, bearings, couplings, drivers = loops.data, len(press.bearings), len(gears(press)), len(press.drivers)
    pin.forwardKinematics(model, data, motion.q[i], motion.v[i], motion.a[i])
    pin.computeJointJacobians(model, data, motion.q[i])
    pin.updateFramePlacements(model, data)
    width = 6 * bearings + couplings + drivers + len(meshes(press))
    balance, known = np.zeros((6 * model.nv, width)), np.zeros(6 * model.nv)

    def act(body, bearing, point, sign):
        if body:
            rows, columns = 6 * (body - 1), 6 * bearing
            balance[rows : rows + 6, columns : columns + 6] += sign * np.eye(6)
            balance[rows + 3 : rows + 6, columns : columns + 3] += sign * pin.skew(point - data.oMi[body].translation)

    def need(body, force, moment, point):
        if body:
            known[6 * body - 6 : 6 * body - 3] += force
            known[6 * body - 3 : 6 * body] += moment + np.cross(point - data.oMi[body].translation, force)

    def axis_of(j):
        """Direction of a joint in the world, and whether it turns."""
        column = pin.getJointJacobian(model, data, j + 1, pin.LOCAL_WORLD_ALIGNED).reshape(6, model.nv)[:, j]
        turns = np.linalg.norm(column[3:]) > 0.5
        return (column[3:] if turns else column[:3]), turns

    def push(body, column, point, force):
        """A force that a unit of this unknown exerts on a body."""
        if body:
            balance[6 * body - 6 : 6 * body - 3, column] += force
            balance[6 * body - 3 : 6 * body, column] += np.cross(point - data.oMi[body].translation, force)

    toothed = set()  # racks: a force at the pitch line on both bodies, in place of efforts of the joints
    for k, (follower, leader, multiplier) in enumerate(gears(press)):
        ends = [(press.joints.index(name), *axis_of(press.joints.index(name))) for name in (follower, leader)]
        if ends[0][2] != ends[1][2]:
            (slide, along, _), (shaft, about, _) = sorted(ends, key=lambda end: end[2])
            share, way = (1.0, multiplier) if press.joints[slide] == follower else (-multiplier, 1 / multiplier)
            pitch = data.oMi[shaft + 1].translation + way * np.cross(along, about)
            push(slide + 1, 6 * bearings + k, pitch, share * along)
            push(shaft + 1, 6 * bearings + k, pitch, -share * along)
            toothed.add(k)
    for k, mesh in enumerate(meshes(press)):
        bodies, (c1, c2), (z1, z2), pressure = _placed(press, data, mesh)
        axis, between = press.planarity.normal, c2 - c1
        pitch = c1 + z1 / (z1 + z2) * between
        tangential, own = np.cross(axis, between) / np.linalg.norm(between), (c1 if z1 > 0 else c2) - pitch
        apart = own / np.linalg.norm(own) * (1 if z1 > 0 else -1)  # on the first gear: the outer gear of a pair is pushed to its centre
        for body, sign in zip(bodies, (1.0, -1.0), strict=True):
            push(body, 6 * bearings + couplings + drivers + k, pitch, sign * (tangential + flanks[k] * np.tan(pressure) * apart))
    free, across = [], np.tile(np.eye(3), (bearings, 2, 1, 1))  # across: projections of forces and moments to what is weighed
    for j, name in enumerate(press.joints):
        place, inertia = data.oMi[j + 1], model.inertias[j + 1]
        act(j + 1, j, place.translation, 1.0)
        act(model.parents[j + 1], j, place.translation, -1.0)
        rate = inertia * data.a[j + 1] + data.v[j + 1].cross(inertia * data.v[j + 1])
        need(j + 1, place.rotation @ rate.linear, place.rotation @ rate.angular, place.translation)
        need(j + 1, -inertia.mass * model.gravity.linear, np.zeros(3), place.act(inertia.lever))
        axis, turns = axis_of(j)
        across[j, int(turns)] -= np.outer(axis, axis)
        row = np.zeros(width)
        row[6 * j + 3 * turns : 6 * j + 3 * turns + 3] = axis
        for k, (follower, leader, multiplier) in enumerate(gears(press)):
            if k in toothed:
                continue
            row[6 * bearings + k] -= (name == follower) - multiplier * (name == leader)
        for k, driver in enumerate(press.drivers):
            row[6 * bearings + couplings + k] -= name == driver
        free.append(row)
    for k, loop in enumerate(loops.loops, model.nv):
        point, held = loops.places(loop)[0].translation, loops.directions(loop)
        act(loop.joints[1], k, point, 1.0)
        act(loop.joints[0], k, point, -1.0)
        for direction in np.linalg.svd(held)[2][len(held) :] if len(held) else np.eye(3):
            free.append(np.zeros(width))
            free[-1][6 * k + 3 : 6 * k + 6] = direction
    for load in loads:
        frame = model.getFrameId(load.link, pin.BODY)
        force = np.broadcast_to(load.force, (len(motion.q), 3))[i]
        need(model.frames[frame].parentJoint, -force, np.zeros(3), data.oMf[frame].act(np.array(load.point)))

    equations = np.vstack([balance, free])
    found = np.linalg.lstsq(equations, np.append(known, np.zeros(len(free))), rcond=ZERO)[0]
    assert np.abs(equations @ found - np.append(known, np.zeros(len(free)))).max() <= 1e-11 * np.abs(found).max()
    idle = null_space(equations)
    weigh = np.zeros((2, 3 * bearings, width))
    for k in range(bearings):
        for part in range(2):
            weigh[part, 3 * k : 3 * k + 3, 6 * k + 3 * part : 6 * k + 3 * part + 3] = across[k, part]
    levels = [weigh[0], weigh[1], np.eye(width)[6 * bearings :]]
    if stiffness:
        soft = [np.sqrt(1 / stiffness[name]) if name in stiffness else 0.0 for name in press.bearings]
        levels.insert(0, np.repeat(soft, 3)[:, None] * weigh[0])
    least, right_side = 1.0, np.append(known, np.zeros(len(free)))
    for _ in range(2):  # again for what rounding has left
        found = found - np.linalg.lstsq(equations, equations @ found - right_side, rcond=ZERO)[0]
        ways = idle
        for level in levels:
            left, values, right = np.linalg.svd(level @ ways)
            rank = np.count_nonzero(values > ZERO * np.linalg.norm(level, 2))  # not of the largest: that may be rounding
            least = min([least, *(values[:rank] / np.linalg.norm(level, 2))])
            found = found - ways @ right[:rank].T @ ((left[:, :rank].T @ (level @ found)) / values[:rank])
            ways = ways @ right[rank:].T
    wrenches, efforts = found[: 6 * bearings].reshape(bearings, 6), found[6 * bearings :]
    reached = (np.abs(idle[: 6 * bearings]).max(axis=1, initial=0.0) > ZERO).reshape(bearings, 6)
    geared = np.abs(idle[6 * bearings : 6 * bearings + couplings]).max(axis=1, initial=0.0) > ZERO
    basis = idle[: 6 * bearings].T.reshape(-1, bearings, 6)
    torques, teeth = np.split(efforts[couplings:], [drivers])
    return CutFree(wrenches, efforts[:couplings], torques, reached, geared, basis, least, teeth)


def gears(press):
    """(follower, leader, multiplier) of every ``<mimic>``, from the text."""
    joints = ElementTree.fromstring(press.text).findall("joint")
    pairs = [(joint.get("name"), joint.find("mimic")) for joint in joints]
    return [(name, mimic.get("joint"), float(mimic.get("multiplier"))) for name, mimic in pairs if mimic is not None]


def meshes(press):
    """The elements ``<gear_mesh>`` of the text."""
    return ElementTree.fromstring(press.text).findall("gear_mesh")


def _placed(press, data, mesh):
    """Bodies, centres in the world, teeth, and pressure angle of a pair of gears, each of which turns about a pin on the carrier or, with
    the carrier, about one on a third body."""
    model, carrier = press.model, mesh.get("carrier")
    bodies = [model.frames[model.getFrameId(mesh.get(f"gear{k}"), pin.BODY)].parentJoint for k in (1, 2)]
    on = model.frames[model.getFrameId(carrier, pin.BODY)].parentJoint

    def pins(body):
        ends = [(j, model.parents[j], data.oMi[j].translation) for j in range(1, model.njoints) if press.axes[j - 1].turns]
        ends += [(loop.joint1, loop.joint2, data.oMi[loop.joint1].act(loop.point1)) for loop in press.loops]
        return [(set(pair[:2]) - {body}, pair[2]) for pair in ends if body in pair[:2]]

    centers = []
    for body in bodies:
        own = [place for others, place in pins(body) if on in others]
        own += [place for _, place in pins(body) for _, other in pins(on) if np.linalg.norm(place - other) < 1e-9]
        centers.append(own[0] if own else data.oMi[on].translation)  # a ring on the frame is about the carrier's own pin
    return bodies, centers, [float(mesh.get(f"teeth{k}")) for k in (1, 2)], np.radians(float(mesh.get("pressure_angle", "20")))
