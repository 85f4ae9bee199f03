"""Linkages that close through space or more than they must, written as URDF (`bennett`, `bricard`, `four_bar`), and mechanics to judge them
by, which is written with Pinocchio's kinematics of the open tree alone (`Loops`).

All numbers are drawn at random but for the lengths: the place in the world, the frame of every link, the masses. A linkage is drawn in a
generic pose and exactly closed.
"""

from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

ZERO = 1e-9  # share of the largest singular value below which one is zero


class Drawing:
    """A linkage as it is drawn, in world coordinates; `urdf` writes it. Lengths in m, masses in kg."""

    def __init__(self, name, seed):
        self.name, self.rng = name, np.random.default_rng(seed)
        self.placed = {"frame": pin.SE3.Identity()}  # link -> its frame
        self.lines = {"frame": ""}  # link -> its inertia
        self.joints, self.loops = [], []

    def joint(self, name, parent, child, at, axis=None):
        """Hang link ``child`` on ``parent`` by a pin at a point, along an axis; without one, weld it."""
        placement = pin.SE3(rotation(self.rng), np.asarray(at, dtype=float))
        self.placed[child] = placement
        kind = "fixed" if axis is None else "continuous"
        turned = "" if axis is None else f'<axis xyz="{_text(placement.rotation.T @ axis)}"/>'
        self.joints.append(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f"<origin {_place(self.placed[parent].actInv(placement))}/>{turned}</joint>"
        )

    def loop(self, name, kind, link1, link2, at, axis=None):
        """Close a loop at a point; a revolute one has an axis, and loop frames that are turned about it by any angle."""
        local = np.array([0.0, 0.6, -0.8])
        rotation1 = rotation(self.rng)
        if kind == "revolute":
            rotation1 = _turn_onto(rotation1 @ local, axis) @ rotation1
        spin = np.zeros(3) if axis is None or kind == "fixed" else 1.3 * axis
        ends = ""
        for k, (link, turned) in enumerate(((link1, rotation1), (link2, pin.exp3(spin) @ rotation1)), 1):
            ends += f'<link{k} link="{link}" {_place(self.placed[link].actInv(pin.SE3(turned, np.asarray(at, dtype=float))))}/>'
        written = f'<axis xyz="{_text(local)}"/>' if kind == "revolute" else ""
        self.loops.append(f'<loop_joint name="{name}" type="{kind}">{ends}{written}</loop_joint>')

    def body(self, link, mass, centre, extent):
        """Give a link a mass, near a point and about as wide as an extent, with a tensor that some body has."""
        rng = self.rng
        spread = mass * (extent * rng.uniform(0.1, 0.5, 3)) ** 2  # second moments along principal axes: any three will do
        turned = self.placed[link].rotation.T @ rotation(rng)
        i = turned @ np.diag(spread.sum() - spread) @ turned.T
        local = self.placed[link].actInv(np.asarray(centre) + extent * rng.uniform(-0.2, 0.2, 3))
        names = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
        moments = " ".join(f'{name}="{float(i[j, k])!r}"' for name, j, k in names)
        self.lines[link] = f'<inertial><origin xyz="{_text(local)}"/><mass value="{float(mass)!r}"/><inertia {moments}/></inertial>'

    def urdf(self, *drivers):
        lines = [f'<robot name="{self.name}">']
        lines += [f'<link name="{link}">{self.lines.get(link, "")}</link>' for link in self.placed]
        lines += [*self.joints, *self.loops]
        lines += [f'<transmission name="drive_{driver}"><joint name="{driver}"/></transmission>' for driver in drivers]
        return "\n  ".join([*lines, "</robot>", ""])


def rotation(rng):
    quaternion = rng.normal(size=4)
    return pin.Quaternion(quaternion / np.linalg.norm(quaternion)).toRotationMatrix()


def _turn_onto(direction, axis):
    return pin.Quaternion.FromTwoVectors(direction, axis).toRotationMatrix()


def _place(placement):
    return f'xyz="{_text(placement.translation)}" rpy="{_text(pin.rpy.matrixToRpy(placement.rotation))}"'


def _text(numbers):
    return " ".join(repr(float(number)) for number in numbers)


# ------------------------------------------------------------------------------------------------------------------------ single loops


def ring(name, angles, lengths, twists, cut, seed):
    """Links in a ring, joined by pins J1, J2, ... of which J1 drives and J<cut> closes the loop.

    Link k has the common normal of the axes of pins k and k + 1, ``lengths`` long, and turns the axis by ``twists``; the last is the frame.
    ``angles`` (Denavit and Hartenberg's, without offsets) are those of the pins in the drawn pose; every joint's coordinate is what its
    angle gains.
    """
    drawing = Drawing(name, seed)
    count = len(angles)
    place = [pin.SE3(rotation(drawing.rng), drawing.rng.uniform(-0.5, 0.5, 3))]
    for angle, length, twist in zip(angles, lengths, twists, strict=True):
        turned = pin.rpy.rpyToMatrix(0.0, 0.0, angle)
        place.append(place[-1] * pin.SE3(turned @ pin.rpy.rpyToMatrix(twist, 0.0, 0.0), turned @ np.array([length, 0.0, 0.0])))
    at, axes = [p.translation for p in place], [p.rotation[:, 2] for p in place]
    links = ["frame", *(f"link{k}" for k in range(1, count)), "frame"]
    for k in range(1, cut):
        drawing.joint(f"J{k}", links[k - 1], links[k], at[k - 1], axes[k - 1])
    for k in range(count, cut, -1):
        drawing.joint(f"J{k}", links[k], links[k - 1], at[k - 1], -axes[k - 1])
    drawing.loop(f"J{cut}", "revolute", links[cut - 1], links[cut], at[cut - 1], axes[cut - 1])
    masses = np.random.default_rng(seed + 1)  # numbers of their own: the bodies are the same wherever the loop is cut
    for k in range(1, count):
        drawing.rng = masses
        drawing.body(links[k], masses.uniform(1, 5), (at[k - 1] + at[k]) / 2, lengths[k - 1])
    return drawing.urdf("J1")


BENNETT_TWISTS = (0.7, 1.9)
BENNETT_LENGTHS = (0.3, 0.3 * np.sin(1.9) / np.sin(0.7))
BENNETT_DRAWN = 1.1  # angle of its first pin
BRICARD_DRAWN = 0.9


def bennett_angle(first):
    """Angle of the second pin from that of the first, and its slope: tan(first / 2) tan(second / 2) is constant. Third and fourth are less
    the first and less the second."""
    alpha, beta = BENNETT_TWISTS
    constant = np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2)
    c, s = np.cos(first / 2), np.sin(first / 2)
    return 2 * np.arctan2(constant * c, s), -constant / (s**2 + constant**2 * c**2)


def bricard_angle(first):
    """Angle of the second pin from that of the first, and its slope: cos 1 + cos 2 + cos 1 cos 2 = 0; they alternate around the ring.

    The first pin swings by 120 deg to either side, where the second is at zero.
    """
    c = np.cos(first)
    second = np.arccos(-c / (1 + c))
    return second, -np.sin(first) * (1 + np.cos(second)) / (np.sin(second) * (1 + c))


def bennett(cut=3):
    """Bennett's linkage of 1903: four pins in space, which Kutzbach's count of freedoms says is a truss."""
    second = bennett_angle(BENNETT_DRAWN)[0]
    angles = (BENNETT_DRAWN, second, -BENNETT_DRAWN, -second)
    return ring("bennett", angles, BENNETT_LENGTHS * 2, BENNETT_TWISTS * 2, cut, seed=1903)


def bricard(cut=4):
    """Bricard's rectangular linkage of 1927: six equal links, each of which turns the axis by a right angle, alternately left and right."""
    angles = (BRICARD_DRAWN, bricard_angle(BRICARD_DRAWN)[0]) * 3
    return ring("bricard", angles, (0.25,) * 6, (np.pi / 2, -np.pi / 2) * 3, cut, seed=1927)


def four_bar(closing, table=None):
    """A planar four-bar in the x-z plane, its coupler of two halves, front and back, closed in one of three ways.

    "spherical" or "revolute": at the pin C between rocker and back. "fixed": in the weld W between the halves. Its pins are at different
    heights along the normal, and its masses lie off the plane. It may stand on a link ``table``, which the frame carries by a driven pin T.
    """
    drawing = Drawing("four_bar", seed=4)
    normal = np.array([0.0, -1.0, 0.0])

    def point(at, height):
        return np.array([at.real, 0.0, at.imag]) + height * normal

    o, d = 0j, 0.45 - 0.05j
    b = 0.15 * np.exp(0.7j)
    span = d - b
    along = (abs(span) ** 2 + 0.5**2 - 0.35**2) / (2 * abs(span))
    c = b + span / abs(span) * (along + 1j * np.sqrt(0.5**2 - along**2))
    w = 0.6 * b + 0.4 * c + 0.05j
    if table:
        drawing.joint("T", "frame", table, (0.1, 0.3, -0.2), np.array([0.36, 0.48, 0.8]))
    drawing.joint("O", table or "frame", "crank", point(o, 0.0), normal)
    drawing.joint("B", "crank", "front", point(b, 0.05), normal)
    drawing.joint("D", table or "frame", "rocker", point(d, -0.02), normal)
    if closing == "fixed":
        drawing.joint("C", "rocker", "back", point(c, 0.08), normal)
        drawing.loop("W", "fixed", "front", "back", point(w, 0.03))
    else:
        drawing.joint("W", "front", "back", point(w, 0.03))
        drawing.loop("C", closing, "rocker", "back", point(c, 0.08), normal)
    drawing.rng = np.random.default_rng(5)  # the same bodies in all three
    drawing.body("crank", 3.0, point(b / 2, 0.02), 0.15)
    drawing.body("front", 1.0, point((b + w) / 2, 0.04), 0.2)
    drawing.body("back", 1.5, point((w + c) / 2, 0.06), 0.3)
    drawing.body("rocker", 2.5, point((c + d) / 2, 0.0), 0.35)
    if table:
        drawing.body(table, 4.0, point(d / 2, 0.1), 0.5)
    return drawing.urdf("T", "O") if table else drawing.urdf("O")


# ----------------------------------------------------------------------------------- laws of mechanics, written with Pinocchio's kinematics


class Loop:
    """A ``<loop_joint>``, read from the text."""

    def __init__(self, element, model):
        self.name, self.kind = element.get("name"), element.get("type")
        self.frames, self.local = [], []
        for end in (element.find("link1"), element.find("link2")):
            self.frames.append(model.getFrameId(end.get("link"), pin.BODY))
            xyz, rpy = (np.array(end.get(name, "0 0 0").split(), dtype=float) for name in ("xyz", "rpy"))
            self.local.append(pin.SE3(pin.rpy.rpyToMatrix(rpy), xyz))
        self.joints = [model.frames[frame].parentJoint for frame in self.frames]
        axis = element.find("axis")
        self.axis = np.array([1.0, 0.0, 0.0] if axis is None else axis.get("xyz").split(), dtype=float)
        across = np.linalg.svd(self.axis[None])[2][1:]
        self.held = {"spherical": np.zeros((0, 3)), "revolute": across, "fixed": np.eye(3)}[self.kind]  # directions, in link1's loop frame

    def out_of_line(self, rotation):
        """Angle [rad] that the loop should not allow, in the rotation from the loop frame on link1 to that on link2."""
        if self.kind == "revolute":
            return float(np.linalg.norm(np.cross(self.axis, rotation @ self.axis)))
        return float(np.linalg.norm(pin.log3(rotation))) if self.kind == "fixed" else 0.0


class Loops:
    """The loops of a URDF text: what they leave open, the Jacobian of that, and its second derivative without joint accelerations.

    A loop's rows are the three components of point 2 less point 1 in world axes, then the turning of link2 against link1 about the
    directions in which the loop holds it (none, two, or three).
    """

    def __init__(self, text, model):
        self.model, self.data = model, model.createData()
        self.loops = [Loop(element, model) for element in ElementTree.fromstring(text).findall("loop_joint")]

    def places(self, loop):
        """Loop frames on link1 and link2 in the world."""
        return [self.data.oMf[frame] * local for frame, local in zip(loop.frames, loop.local, strict=True)]

    def directions(self, loop):
        """Directions (0, 2 or 3; 3) in which link2 is held against turning, in world axes. They turn with link1."""
        return loop.held @ self.places(loop)[0].rotation.T

    def gaps(self, q):
        """Distance of the points (loops,) [m], and the angle by which the loops are turned out of line (loops,) [rad]."""
        pin.framesForwardKinematics(self.model, self.data, q)
        places = [self.places(loop) for loop in self.loops]
        apart = [np.linalg.norm(two.translation - one.translation) for one, two in places]
        turned = [loop.out_of_line(one.rotation.T @ two.rotation) for loop, (one, two) in zip(self.loops, places, strict=True)]
        return np.array(apart), np.array(turned)

    def rows(self, q, v):
        """Jacobian (rows, nv), and second derivative (rows,) at these joint rates and no joint accelerations."""
        model, data = self.model, self.data
        pin.computeJointJacobians(model, data, q)
        pin.forwardKinematics(model, data, q, v, np.zeros(model.nv))
        pin.updateFramePlacements(model, data)
        jacobian, second = [], []
        for loop in self.loops:
            held, places = self.directions(loop), self.places(loop)
            (columns1, turning1, change1), (columns2, turning2, change2) = map(self._point, loop.frames, places)
            columns, change = columns2 - columns1, change2 - change1
            jacobian += [columns[:3], held @ columns[3:]]
            second += [change[:3], held @ change[3:] + np.cross(turning1, held) @ (turning2 - turning1)]
        return np.concatenate(jacobian), np.concatenate(second)

    def _point(self, frame, place):
        """Jacobian (6, nv) of a link at a point, angular velocity (3,), acceleration of the point and of the turning (6,); world axes."""
        model, data, world = self.model, self.data, pin.LOCAL_WORLD_ALIGNED
        arm = place.translation - data.oMf[frame].translation
        columns = pin.getFrameJacobian(model, data, frame, world).reshape(6, model.nv)
        velocity, acceleration = (f(model, data, frame, world) for f in (pin.getFrameVelocity, pin.getFrameClassicalAcceleration))
        turning, spun = velocity.angular, acceleration.angular
        moved = acceleration.linear + np.cross(spun, arm) + np.cross(turning, np.cross(turning, arm))
        return np.vstack([columns[:3] - pin.skew(arm) @ columns[3:], columns[3:]]), turning.copy(), np.concatenate([moved, spun])

    def multipliers(self, result, i):
        """Components (rows,) of the loops' forces and moments at state i along their rows."""
        parts = []
        for loop in self.loops:
            parts += [result.bearing_force[loop.name][i], self.directions(loop) @ result.bearing_moment[loop.name][i]]
        return np.concatenate(parts)

    def forces(self, multipliers):
        """The forces (3,) of the loops among multipliers (rows,)."""
        starts = np.cumsum([0] + [3 + len(loop.held) for loop in self.loops])
        return [multipliers[start : start + 3] for start in starts[:-1]]


def null_space(matrix):
    """Orthonormal basis (columns) of what a matrix takes to zero."""
    _, values, right = np.linalg.svd(matrix)
    return right[np.count_nonzero(values > ZERO * values.max(initial=0.0)) :].T
