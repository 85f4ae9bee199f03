"""Planar linkages written as URDF: drawn by hand joint by joint (`Drawing`), or at random (`linkages`), always exactly closed; and laws of
mechanics to judge any linkage by (`momentum_balance`, `newton_euler`).

A linkage is drawn in a plane: a point is a complex number, x + i y, with a height along the plane's normal. How the plane lies in the
world, how every joint frame is turned and where a loop is cut are chosen apart from the drawing: none of it may change the mechanics.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from hypothesis import strategies as st

import pinpress as pp

UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]).T  # plane's x, y and normal as columns: world x, z and -y
CLEAR = 0.4  # every dyad's sine (every triad's determinant) in the drawn pose is larger; 0 is where it locks
TRIES = 200  # at placing a dyad clear of its singularity


class Drawing:
    """A linkage as it is drawn; `urdf` writes it. Lengths in m, masses in kg, tensors in the plane's axes about the centre of mass."""

    def __init__(self, name="drawing", world=UPRIGHT, frame="frame"):
        self.name, self.world, self.frame = name, np.asarray(world), frame
        self.placed = {frame: (np.eye(3), np.zeros(3))}  # link -> rotation and origin of its frame in the world
        self.bodies: dict[str, Any] = {frame: None}
        self.joints, self.loops, self.elements = [], [], []

    def space(self, at, height=0.0):
        """World position (3,) of a point of the plane."""
        return self.world @ np.array([at.real, at.imag, height])

    def joint(self, name, parent, child, at, height=0.0, along=None, sense=1, bounded=False, rpy=(0.0, 0.0, 0.0)):
        """Hang link ``child`` on ``parent``, by a pin at a point or, with the direction ``along``, by a guide."""
        rotation, origin = self.placed[parent]
        turned, place = rotation @ pin.rpy.rpyToMatrix(np.array(rpy, dtype=float)), self.space(at, height)
        normal = self.world[:, 2]
        axis = turned.T @ (sense * (normal if along is None else self.space(along / abs(along))))
        kind = "prismatic" if along is not None else "revolute" if bounded else "continuous"
        self.placed[child] = (turned, place)
        self.bodies.setdefault(child, None)
        self.joints.append((name, kind, parent, child, rotation.T @ (place - origin), rpy, axis))

    def weld(self, name, parent, child, at, height=0.0, rpy=(0.0, 0.0, 0.0)):
        """Fix link ``child`` to ``parent``."""
        self.joint(name, parent, child, at, height, rpy=rpy)
        self.joints[-1] = (name, "fixed", *self.joints[-1][2:])

    def loop(self, name, link1, link2, at, height=0.0):
        """Close a loop by a pin at a point."""
        ends = []
        for link in (link1, link2):
            rotation, origin = self.placed[link]
            ends.append((link, rotation.T @ (self.space(at, height) - origin)))
        self.loops.append((name, ends))

    def element(self, tag, **attributes):
        """A machine element, such as "gear_mesh"."""
        given = " ".join(f'{name}="{value}"' for name, value in attributes.items())
        self.elements.append(f"  <{tag} {given}/>")

    def body(self, link, mass, centre, height=0.0, tensor=None):
        """Give a link its inertia; ``tensor`` (3, 3), by default a ball of radius of gyration 0.1."""
        self.bodies[link] = (mass, centre, height, mass * 0.01 * np.eye(3) if tensor is None else np.asarray(tensor))

    def urdf(self, driver):
        """The text; ``driver`` is a joint's name."""
        lines = [f'<robot name="{self.name}">']
        for link, body in self.bodies.items():
            lines.append(f'  <link name="{link}">{"" if body is None else self._inertial(link, *body)}</link>')
        for name, kind, parent, child, xyz, rpy, axis in self.joints:
            limit = {"revolute": '<limit lower="-7" upper="7" effort="1e6" velocity="100"/>'}
            limit["prismatic"] = '<limit lower="-50" upper="50" effort="1e6" velocity="100"/>'
            moving = "" if kind == "fixed" else f'<axis xyz="{_text(axis)}"/>{limit.get(kind, "")}'
            lines.append(
                f'  <joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
                f'<origin xyz="{_text(xyz)}" rpy="{_text(rpy)}"/>{moving}</joint>'
            )
        for name, ends in self.loops:
            (link1, xyz1), (link2, xyz2) = ends
            lines.append(
                f'  <loop_joint name="{name}" type="spherical"><link1 link="{link1}" xyz="{_text(xyz1)}"/>'
                f'<link2 link="{link2}" xyz="{_text(xyz2)}"/></loop_joint>'
            )
        lines += [*self.elements, f'  <transmission name="drive"><joint name="{driver}"/></transmission>']
        return "\n".join([*lines, "</robot>", ""])

    def _inertial(self, link, mass, centre, height, tensor):
        rotation, origin = self.placed[link]
        local = rotation.T @ self.world
        i = local @ tensor @ local.T
        moments = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
        written = " ".join(f'{name}="{float(i[j, k])!r}"' for name, j, k in moments)
        xyz = _text(rotation.T @ (self.space(centre, height) - origin))
        return f'<inertial><origin xyz="{xyz}"/><mass value="{float(mass)!r}"/><inertia {written}/></inertial>'


def _text(numbers):
    return " ".join(repr(float(number)) for number in numbers)


def four_bar(ground, crank, coupler, rocker, angle, side=1, name="four_bar", bounded=True):
    """Pins O and D on the frame, O at the world origin; crank O-B, coupler B-C, rocker D-C (loop pin C).

    Drawn at a crank angle from the line O-D, with C to the left (side 1) or right (-1) of the line B-D. Every link has 2 kg.
    """
    b, d = crank * np.exp(1j * angle), complex(ground)
    span = d - b
    along = (abs(span) ** 2 + coupler**2 - rocker**2) / (2 * abs(span))
    c = b + span / abs(span) * (along + 1j * side * np.sqrt(coupler**2 - along**2))
    drawing = Drawing(name)
    drawing.joint("O", "frame", "crank", 0j)
    drawing.joint("B", "crank", "coupler", b, bounded=bounded)
    drawing.joint("D", "frame", "rocker", d, bounded=bounded)
    drawing.loop("C", "coupler", "rocker", c)
    for link, centre in (("crank", 0.3 * b), ("coupler", b + 0.4 * (c - b) * np.exp(0.2j)), ("rocker", d + 0.6 * (c - d))):
        drawing.body(link, 2.0, centre)
    return drawing


@dataclass(frozen=True)
class Group:
    """A dyad or triad to be added. ``kind``: its joints from host to host, R a pin, P a guide; "triad" for a plate on three bars.

    ``cut``: which of its pins is the loop's. ``hosts``: indices, taken modulo the links that there are.
    """

    kind: str
    cut: int
    hosts: tuple[int, int, int]


@dataclass(frozen=True)
class Spec:
    """All that a random linkage is made from: ``groups`` say what hangs where, ``seed`` fixes every number, the rest what is allowed.

    tilted: in any plane and with joint frames turned any way. stacked: links in parallel planes. solid: centres of mass off the plane,
    products of inertia. extra: a mass welded to a link, a frame with mass.
    """

    groups: tuple[Group, ...]
    seed: int
    tilted: bool = False
    stacked: bool = False
    solid: bool = False
    extra: bool = False


KINDS = ("RRR", "RRP", "RPR", "PRR", "triad")


@st.composite
def linkages(draw, most=4, **fixed):
    """Specs of random linkages with one crank and up to ``most`` groups; shrinks to one RRR dyad, upright and flat."""
    index = st.integers(0, 7)
    group = st.builds(Group, st.sampled_from(KINDS), st.integers(0, 2), st.tuples(index, index, index))
    groups = tuple(draw(st.lists(group, min_size=1, max_size=most)))
    flags = {name: fixed.get(name) for name in ("tilted", "stacked", "solid", "extra")}
    flags = {name: draw(st.booleans()) if value is None else value for name, value in flags.items()}
    return Spec(groups=groups, seed=draw(st.integers(0, 2**32 - 1)), **flags)


def drawn(spec):
    """The Drawing of a spec, or None where some group could not be placed clear of its singularity. The driver is the joint "crank"."""
    rng = np.random.default_rng(spec.seed)
    world = _rotation(rng) if spec.tilted else UPRIGHT
    scale = 10 ** rng.uniform(-1, 1) if spec.tilted else 1.0
    builder = _Builder(Drawing("random", world), rng, spec, scale)
    builder.crank()
    for group in spec.groups:
        if not (builder.triad(group) if group.kind == "triad" else builder.dyad(group)):
            return None
    builder.masses()
    return builder.drawing


class _Builder:
    """Random numbers put into a Drawing, unscaled inside (lengths around 1)."""

    def __init__(self, drawing, rng, spec, scale):
        self.drawing, self.rng, self.spec, self.scale = drawing, rng, spec, scale
        self.links, self.near = ["frame"], {"frame": 0j}  # near: a point that a link's other points are drawn around

    def point(self, around, spread=0.8):
        return around + spread * complex(*self.rng.normal(size=2))

    def height(self):
        return self.rng.uniform(-0.5, 0.5) if self.spec.stacked else 0.0

    def name(self):
        """Of a new link; its first letter random, because Pinocchio sorts links by name."""
        return f"{'abcdefgh'[self.rng.integers(8)]}{len(self.links)}"

    def add(self, parent, child, at, along=None, name=None):
        rng = self.rng
        self.drawing.joint(
            name or f"joint_{child}",
            parent,
            child,
            self.scale * at,
            self.scale * self.height(),
            along=along,
            sense=int(rng.choice([-1, 1])),
            bounded=bool(rng.integers(2)),
            rpy=rng.uniform(-3, 3, 3) if self.spec.tilted else (0.0, rng.uniform(-3, 3), 0.0) if rng.integers(2) else (0.0, 0.0, 0.0),
        )

    def adopt(self, link, near):
        self.links.append(link)
        self.near[link] = near

    def close(self, link1, link2, at):
        if self.rng.integers(2):
            link1, link2 = link2, link1
        self.drawing.loop(f"loop_{len(self.drawing.loops)}", link1, link2, self.scale * at, self.scale * self.height())

    def crank(self):
        pivot, link = self.point(0j), self.name()
        self.add("frame", link, pivot, name="crank")
        self.adopt(link, pivot + 0.4 * np.exp(1j * self.rng.uniform(0, 6)))

    def hosts(self, group):
        """Two different links, and a third that is one of all."""
        count = len(self.links)
        first = group.hosts[0] % count
        second = (first + 1 + group.hosts[1] % (count - 1)) % count
        return [self.links[first], self.links[second], self.links[group.hosts[2] % count]]

    def dyad(self, group):
        host1, host2, _ = self.hosts(group)
        for _ in range(TRIES):
            a, b, c = (self.point(p) for p in (self.near[host1], (self.near[host1] + self.near[host2]) / 2, self.near[host2]))
            along = np.exp(1j * self.rng.uniform(0, 2 * np.pi))
            # sine of the angle between the two directions in which the joints can move the loop apart
            sides = {"RRR": (b - a, 1j * (c - b)), "RRP": (b - a, along), "RPR": (c - a, along), "PRR": (c - b, along)}[group.kind]
            lengths = [abs(x) for x in {"RRR": (b - a, c - b), "RRP": (b - a,), "RPR": (c - a,), "PRR": (c - b,)}[group.kind]]
            sine = abs((np.conj(sides[0]) * sides[1]).real) / (abs(sides[0]) * abs(sides[1]))
            if sine > CLEAR and min(lengths) > 0.4 and max(lengths) < 2.5:
                break
        else:
            return False
        pins = [k for k in range(3) if group.kind[k] == "R"]
        cut = pins[group.cut % len(pins)]
        places = [a, b, c]
        x = self.name()
        y = self.name() + "y"
        chain = [host1, x, y, host2]
        for k in range(cut):  # from the first host up to the cut, then from the second one down to it
            self.add(chain[k], chain[k + 1], places[k], None if group.kind[k] == "R" else along)
        for k in range(2, cut, -1):
            self.add(chain[k + 1], chain[k], places[k], None if group.kind[k] == "R" else along)
        self.close(chain[cut], chain[cut + 1], places[cut])
        self.adopt(x, (a + b) / 2)
        self.adopt(y, (b + c) / 2)
        return True

    def triad(self, group):
        hosts = self.hosts(group)
        for _ in range(TRIES):
            middle = sum(self.near[h] for h in hosts) / 3
            feet = [self.point(self.near[h]) for h in hosts]
            heads = [self.point(middle) for _ in hosts]
            bars = [(head - foot) for head, foot in zip(heads, feet, strict=True)]
            units = [bar / abs(bar) for bar in bars]
            # the plate is held unless its three bars' lines meet in a point
            lines = [[u.real, u.imag, (np.conj(h - middle) * u).imag] for u, h in zip(units, heads, strict=True)]
            sizes = [abs(bar) for bar in bars] + [abs(heads[i] - heads[i - 1]) for i in range(3)]
            if abs(np.linalg.det(lines)) > CLEAR and min(sizes) > 0.4 and max(sizes) < 2.5:
                break
        else:
            return False
        names = [f"{self.name()}{letter}" for letter in "ijk"]
        plate = self.name() + "p"
        carrier = group.cut % 3  # the plate hangs on this bar; the loops are cut at the other two, at either end
        self.add(hosts[carrier], names[carrier], feet[carrier])
        self.add(names[carrier], plate, heads[carrier])
        for k in range(3):
            if k == carrier:
                continue
            if self.rng.integers(2):
                self.add(hosts[k], names[k], feet[k])
                self.close(names[k], plate, heads[k])
            else:
                self.add(plate, names[k], heads[k])
                self.close(names[k], hosts[k], feet[k])
        for k in range(3):
            self.adopt(names[k], (feet[k] + heads[k]) / 2)
        self.adopt(plate, middle)
        return True

    def masses(self):
        rng, spec, drawing = self.rng, self.spec, self.drawing
        if spec.extra:
            host = self.links[1 + int(rng.integers(len(self.links) - 1))]
            at = self.point(self.near[host])
            drawing.weld("weld", host, "welded", self.scale * at, self.scale * self.height(), rng.uniform(-3, 3, 3))
            self.links.append("welded")
            self.near["welded"] = self.near[host]
        for link in self.links:
            if link == "frame" and not spec.extra:
                continue
            mass = 10 ** rng.uniform(-0.5, 1.0)
            # second moments of mass along principal axes: any three make a valid tensor
            spread = self.scale**2 * mass * 10 ** rng.uniform(-3, -0.5, 3)
            turned = _rotation(rng) if spec.solid else np.eye(3)
            tensor = turned @ np.diag(spread.sum() - spread) @ turned.T
            height = rng.uniform(-0.5, 0.5) if spec.solid else 0.0
            drawing.body(link, mass, self.scale * self.point(self.near[link], 0.3), self.scale * height, tensor)


def _rotation(rng):
    quaternion = rng.normal(size=4)
    return pin.Quaternion(quaternion / np.linalg.norm(quaternion)).toRotationMatrix()


# ----------------------------------------------------------------------------------- laws of mechanics, written with Pinocchio's kinematics


def momentum_balance(press, motion, loads):
    """What must reach the foundation, (n, 3) force and (n, 3) moment about the world origin: weights and loads less the rate of momentum.

    The rate is Pinocchio's own for the open tree, about the centre of mass.
    """
    model, data = press.model, press.model.createData()
    gravity = model.gravity.linear
    force, moment = np.empty((len(motion.q), 3)), np.empty((len(motion.q), 3))
    for i, (q, v, a) in enumerate(zip(motion.q, motion.v, motion.a, strict=True)):
        pin.forwardKinematics(model, data, q, v, a)
        pin.computeCentroidalMomentumTimeVariation(model, data, q, v, a)
        centre, mass = data.com[0], data.mass[0]
        force[i] = mass * gravity - data.dhg.linear
        moment[i] = np.cross(centre, force[i]) - data.dhg.angular
        force[i] += model.inertias[0].mass * gravity
        moment[i] += np.cross(model.inertias[0].lever, model.inertias[0].mass * gravity)
        pin.updateFramePlacements(model, data)
        for load in loads:
            point = data.oMf[model.getFrameId(load.link, pin.BODY)].act(np.array(load.point))
            acting = np.broadcast_to(load.force, (len(motion.q), 3))[i]
            force[i] += acting
            moment[i] += np.cross(point, acting)
    return force, moment


def newton_euler(press, motion, result, loads=()):
    """What Newton's and Euler's equations of every body leave over, from bearing forces and moments as they are documented.

    Returns:
        forces (bodies, n, 3), moments about the joints' origins (bodies, n, 3), and (n, bearings) what passive joints transmit along the
        motion they should leave free, with the driver's torque less its moment along its axis. All should be zero.
    """
    model, data = press.model, press.model.createData()
    n, count = len(motion.q), model.nv
    forces, moments, idle = np.zeros((count, n, 3)), np.zeros((count, n, 3)), np.zeros((n, count))
    for i, (q, v, a) in enumerate(zip(motion.q, motion.v, motion.a, strict=True)):
        pin.forwardKinematics(model, data, q, v, a)
        pin.computeJointJacobians(model, data, q)
        place = [data.oMi[j] for j in range(model.njoints)]

        def act(joint, force, point, moment=0.0, i=i, place=place):
            if joint:
                forces[joint - 1, i] += force
                moments[joint - 1, i] += moment + np.cross(point - place[joint].translation, force)

        for j, name in enumerate(press.joints, 1):
            inertia = model.inertias[j]
            force, moment, origin = result.bearing_force[name][i], result.bearing_moment[name][i], place[j].translation
            act(j, force, origin, moment)
            act(model.parents[j], -force, origin, -moment)
            act(j, inertia.mass * model.gravity.linear, place[j].act(inertia.lever))
            rate = inertia * data.a[j] + data.v[j].cross(inertia * data.v[j])
            act(j, -(place[j].rotation @ rate.linear), origin, -(place[j].rotation @ rate.angular))
            free = pin.getJointJacobian(model, data, j, pin.LOCAL_WORLD_ALIGNED)[:, j - 1]
            idle[i, j - 1] = free @ np.concatenate([force, moment]) - (result.driving_torque[i] if name == press.driver else 0.0)
        for loop in press.loops:
            force, point = result.bearing_force[loop.name][i], place[loop.joint1].act(loop.point1)
            act(loop.joint2, force, point)
            act(loop.joint1, -force, point)
            assert not result.bearing_moment[loop.name].any()
        pin.updateFramePlacements(model, data)
        for load in loads:
            frame = model.getFrameId(load.link, pin.BODY)
            force = np.broadcast_to(load.force, (n, 3))[i]
            act(model.frames[frame].parentJoint, force, data.oMf[frame].act(np.array(load.point)))
    return forces, moments, idle


# ---------------------------------------- states, loads and friction at random

STATES = 4


def loaded(drawing, folder, **options):
    file = folder / f"{drawing.name}.urdf"
    file.write_text(drawing.urdf("crank"), encoding="utf-8")
    return pp.load(file, **options)


def servo(press, rng, states=STATES):
    """Angles about the drawn pose, with speeds and accelerations that have nothing to do with them."""
    low, high = (-np.inf, np.inf) if press.branch.period else press.branch.angles[[0, -1]]
    angle = rng.uniform(max(-0.05, 0.5 * low), min(0.05, 0.5 * high), states)
    return {"angle": angle, "speed": rng.uniform(-10, 10, states), "acceleration": rng.uniform(-50, 50, states)}


def random_loads(press, rng, count, in_plane):
    """Forces at points of random links, the frame among them."""
    across = 0.0 if in_plane else 1.0
    normal = press.engine("plane").plane.normal
    loads = []
    for _ in range(count):
        force = 100 * rng.normal(size=(STATES, 3))
        force -= (1 - across) * (force @ normal)[:, None] * normal
        loads.append(pp.loads.PointForce(str(rng.choice(press.links)), force, tuple(press.size * rng.normal(size=3))))
    return loads


def peaks(press, result):
    """Largest bearing force and moment; a moment is never judged more sharply than the force on an arm as long as the linkage."""
    force = max(np.abs(values).max() for values in (*result.bearing_force.values(), result.shaking_force))
    moment = max(np.abs(values).max() for values in result.bearing_moment.values())
    return force, max(moment, force * press.size)


def apart(one, other):
    """Largest differences between two results of one linkage: of forces as a share of the peak; of moments and torques, those of gear pairs
    too, as a share of theirs."""
    force, moment = peaks(other._press, other)
    forces = [values - other.bearing_force[name] for name, values in one.bearing_force.items()] + [one.shaking_force - other.shaking_force]
    moments = [values - other.bearing_moment[name] for name, values in one.bearing_moment.items()]
    moments += [torque - other.coupling_torque[name] for name, torque in one.coupling_torque.items()]
    moments += [one.shaking_moment - other.shaking_moment, one.driving_torque - other.driving_torque]
    return max(np.abs(each).max() for each in forces) / force, max(np.abs(each).max() for each in moments) / moment


def slides(press):
    """Joints that slide, by Pinocchio's names of them."""
    return {
        name for name, joint in zip(press.joints, list(press.model.joints)[1:], strict=True) if joint.shortname().startswith("JointModelP")
    }


def random_friction(press, seed=0, most=0.15, viscous=300.0):
    """Friction of all bearings, at random."""
    rng = np.random.default_rng(seed)
    return {
        name: pp.loads.Friction(rng.uniform(0.02, most), None if name in slides(press) else rng.uniform(0.03, 0.1), rng.uniform(0, viscous))
        for name in press.bearings
        if not any(loop.name == name and loop.type == "fixed" for loop in press.loops)
    }
