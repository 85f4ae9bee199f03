"""Random mechanisms in space, written in every dialect with other frames and zeros, against equations of motion written here.

The oracle takes neither the reader's model nor its loops: tree, constraint rows and drifts come from the mechanism as it was made. Link
frames are turned at random, axes lie in any direction, joints are drawn away from the closed pose. With M a + h = f + S'u + J'l, J a = -g
and S a given, a = b + N z, where [J; S] N = 0 and N'M N z = N'(f - h - M b); then [J; S]' [l; u] = M a + h - f by least norm.
"""

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin
import pytest

import pinpress as pp

pytestmark = pytest.mark.filterwarnings("ignore::pinpress.PinpressWarning")
TYPES = {"ball": "spherical", "hinge": "revolute", "weld": "fixed"}
HERE = pin.SE3.Identity()


@dataclass
class Mechanism:
    """Made at its closed pose, in world coordinates. Joints are (name, type, parent, child, place in the parent's frame, axis), loops
    (name, type, two links with a frame in each, axis in these frames); ``home`` are coordinates of the closed pose, zero is as drawn."""

    rng: np.random.Generator
    open: float
    joints: list = field(default_factory=list)
    loops: list = field(default_factory=list)
    home: list = field(default_factory=list)
    inertias: dict = field(default_factory=dict)
    springs: dict = field(default_factory=dict)
    armature: dict = field(default_factory=dict)
    drivers: tuple = ()

    def __post_init__(self):
        self.places = {"world": HERE}

    def joint(self, name, kind, parent, child, point, axis):
        q = self.rng.uniform(-self.open, self.open) * (0.3 if kind == "prismatic" else 1.0)
        place = pin.SE3(pin.exp3(self.rng.normal(size=3)), np.array(point, float))
        axis = place.rotation.T @ axis / np.linalg.norm(axis)
        points = 0.05 * self.rng.normal(size=(5, 3))
        tensor = sum(p @ p * np.eye(3) - np.outer(p, p) for p in points) / 5
        mass = self.rng.uniform(0.3, 2.0)
        self.inertias[child] = pin.Inertia(mass, self.rng.uniform(-0.05, 0.05, 3), mass * tensor)
        self.joints.append((name, kind, parent, child, self.places[parent].inverse() * place * _step(kind, axis, q).inverse(), axis))
        self.places[child] = place
        self.home.append(q)

    def loop(self, name, kind, one, other, point, axis):
        place = pin.SE3(pin.exp3(self.rng.normal(size=3)), np.array(point, float))
        ends = [self.places[link].inverse() * place for link in (one, other)]
        self.loops.append((name, kind, one, ends[0], other, ends[1], place.rotation.T @ axis / np.linalg.norm(axis)))

    @property
    def names(self):
        return [joint[0] for joint in self.joints]

    def model(self):
        model, ids = pin.Model(), {"world": 0}
        for name, kind, parent, child, place, axis in self.joints:
            made = (pin.JointModelRevoluteUnaligned if kind == "revolute" else pin.JointModelPrismaticUnaligned)(axis)
            ids[child] = model.addJoint(ids[parent], made, place, name)
            model.appendBodyToJoint(ids[child], self.inertias[child], HERE)
        return model, ids

    def rows(self, q, v):
        """Gaps, Jacobian and drifts of the loops."""
        model, ids = self.model()
        data, gaps, columns, drifts = model.createData(), [], [], []
        pin.forwardKinematics(model, data, q, v, 0 * v)
        pin.computeJointJacobians(model, data, q)
        for _, kind, one, first, other, second, axis in self.loops:
            ends = []
            for link, place in ((one, first), (other, second)):
                j, world = ids[link], pin.LOCAL_WORLD_ALIGNED
                jacobian, arm = pin.getJointJacobian(model, data, j, world), data.oMi[j].rotation @ place.translation
                rate, change = pin.getVelocity(model, data, j, world), pin.getClassicalAcceleration(model, data, j, world)
                w = rate.angular
                jacobian = np.vstack([jacobian[:3] - pin.skew(arm) @ jacobian[3:], jacobian[3:]])
                drift = change.linear + np.cross(change.angular, arm) + np.cross(w, np.cross(w, arm))
                ends.append((data.oMi[j] * place, jacobian, w, np.concatenate([drift, change.angular])))
            (a, columns_a, w, drift_a), (b, columns_b, w_b, drift_b) = ends
            apart, drift = columns_a - columns_b, drift_a - drift_b
            gaps.append(a.translation - b.translation)
            held = {"ball": np.zeros((0, 3)), "weld": np.eye(3)}.get(kind)
            if held is None:
                held = np.linalg.svd((a.rotation @ axis)[None])[2][1:]
            gaps.append(held @ (pin.log3(a.rotation @ b.rotation.T) if kind == "weld" else np.cross(b.rotation @ axis, a.rotation @ axis)))
            columns += [apart[:3], held @ apart[3:]]
            drifts += [drift[:3], held @ drift[3:] + np.cross(w, held) @ (w - w_b)]
        return np.concatenate(gaps), np.vstack(columns), np.concatenate(drifts)

    def solve(self, q, v, motors, acceleration, held):
        """Accelerations, efforts of the motors, and the number of freedoms that neither motors nor loops determine."""
        model, _ = self.model()
        data, nv = model.createData(), model.nv
        weight = pin.rnea(model, data, q, 0 * v, 0 * v).copy()
        mass = np.column_stack([pin.rnea(model, data, q, 0 * v, e).copy() - weight for e in np.eye(nv)])
        force = -pin.rnea(model, data, q, v, 0 * v)
        for name, (stiffness, reference, damping) in self.springs.items():
            k = self.names.index(name)
            force[k] -= stiffness * (q[k] - reference) + damping * v[k]
        for name, rotor in self.armature.items():
            mass[self.names.index(name), self.names.index(name)] += rotor
        _, columns, drift = self.rows(q, v)
        chosen = np.eye(nv)[[self.names.index(name) for name in (*motors, *held)]]
        rows = np.vstack([columns, chosen])
        a = np.linalg.lstsq(rows, np.concatenate([-drift, acceleration, np.zeros(len(held))]), rcond=1e-8)[0]
        values, ways = np.linalg.svd(rows)[1:]
        still = ways[np.count_nonzero(values > 1e-8 * values[0]) :].T
        a = a + still @ np.linalg.solve(still.T @ mass @ still, still.T @ (force - mass @ a))
        efforts = np.linalg.lstsq(rows.T, mass @ a - force, rcond=1e-8)[0][len(columns) :]
        return a, efforts[: len(motors)], still.shape[1]


def _step(kind, axis, q):
    return pin.SE3(pin.exp3(axis * q), np.zeros(3)) if kind == "revolute" else pin.SE3(np.eye(3), axis * q)


def _plane(rng):
    place = pin.SE3(pin.exp3(rng.normal(size=3)), rng.uniform(-0.3, 0.3, 3))
    return (lambda x, y: place.act(np.array([x, y, 0.0]))), place.rotation[:, 2], place.rotation[:, 0]


def five_bar(made, kind):
    at, z, _ = _plane(made.rng)
    made.joint("A", "revolute", "world", "crank_a", at(-0.1, 0), z)
    made.joint("K", "revolute", "crank_a", "rod_a", at(-0.22, 0.2), z)
    made.joint("B", "revolute", "world", "crank_b", at(0.1, 0), z)
    made.joint("L", "revolute", "crank_b", "rod_b", at(0.2, 0.22), z)
    made.loop("tip", kind, "rod_a", "rod_b", at(0.02, 0.4), z)
    made.drivers = ("A", "B")


def sliding_bar(made, kind):
    at, z, x = _plane(made.rng)
    for side, name in ((-0.3, "l"), (0.3, "r")):
        made.joint(f"slide_{name}", "prismatic", "world", f"carriage_{name}", at(side, 0), x)
        made.joint(f"arm_{name}", "revolute", f"carriage_{name}", f"link_{name}", at(side, 0), z)
    made.loop("tip", kind, "link_l", "link_r", at(0.05, 0.35), z)
    made.drivers = ("slide_l", "slide_r")


def wrist(made, kind):
    centre = made.rng.uniform(-0.1, 0.1, 3)
    axes = np.array([(1, 0, 0), (0.8, 0.6, 0.3), (0, 1, 0.1), (0.3, 0.9, 0.4), (0.4, 0.5, 0.9)])
    for k, (name, parent, child) in enumerate([("m1", "world", "a1"), ("e1", "a1", "a2"), ("m2", "world", "b1"), ("e2", "b1", "b2")]):
        made.joint(name, "revolute", parent, child, centre + 0.2 * axes[k], axes[k])
    made.loop("end", "hinge", "a2", "b2", centre + 0.18 * axes[4], axes[4])
    made.drivers = ("m1", "m2")


def cut_rod(made, kind):
    ends = {"c": (0.11, 0.05, 0.02), "r": (0.45, 0.1, 0.27)}
    made.joint("crank", "revolute", "world", "c", (0, 0, 0), (0.1, 0.2, 1.0))
    for k, (parent, child, axis) in enumerate([("c", "x", (1, 0, 0.2)), ("x", "rod", (0, 1, 0.1))]):
        made.joint(f"u{k}", "revolute", parent, child, ends["c"], axis)
    made.joint("rocker", "revolute", "world", "r", (0.45, 0.12, 0), (1, 0.1, 0.2))
    for k, (parent, child, about) in enumerate([("r", "y", (1, 0.1, 0)), ("y", "y2", (0, 1, 0.2)), ("y2", "rod2", (0.1, 0, 1))]):
        made.joint(f"w{k}", "revolute", parent, child, ends["r"], about)
    made.loop("cut", "weld", "rod", "rod2", (0.3, 0.08, 0.2), (0, 0, 1.0))
    made.drivers = ("crank",)


FAMILIES = {"five_bar": five_bar, "sliding_bar": sliding_bar, "wrist": wrist, "cut_rod": cut_rod}

# ------------------------------------------------------------------------------------------------------------------------------- dialects


def _text(numbers, digits=17):
    return " ".join(f"{number:.{digits}g}" if digits > 9 else f"{number:.{digits}f}" for number in numbers)


def _origin(place, digits):
    return f'xyz="{_text(place.translation, digits)}" rpy="{_text(pin.rpy.matrixToRpy(place.rotation), digits)}"'


def urdf(made, dialect, digits=17):
    """The mechanism with loops of pinpress and Isaac ("loop_joint"), URDF+ ("loop"), or onshape-to-robot ("closing")."""
    lines = ['<link name="world"/>']
    for link, inertia in made.inertias.items():
        upper = [(a, b) for a in range(3) for b in range(a, 3)]
        moments = " ".join(f'i{"xyz"[a]}{"xyz"[b]}="{inertia.inertia[a, b]:.17g}"' for a, b in upper)
        inner = f'<origin xyz="{_text(inertia.lever)}"/><mass value="{inertia.mass:.17g}"/><inertia {moments}/>'
        lines.append(f'<link name="{link}"><inertial>{inner}</inertial></link>')
    for name, kind, parent, child, place, axis in made.joints:
        type_, limit = ("continuous", "") if kind == "revolute" else (str(kind), '<limit lower="-2" upper="2" effort="9" velocity="9"/>')
        inner = f'<parent link="{parent}"/><child link="{child}"/><origin {_origin(place, digits)}/><axis xyz="{_text(axis, digits)}"/>'
        independent = str(name in made.drivers).lower()
        lines.append(f'<joint name="{name}" type="{type_}" independent="{independent}">{inner}{limit}</joint>')
    for name, kind, one, first, other, second, axis in made.loops:
        turns = f'<axis xyz="{_text(axis, digits)}"/>' if kind == "hinge" else ""
        ends = ((one, first), (other, second))
        if dialect == "closing":
            z = pin.SE3(pin.Quaternion.FromTwoVectors(np.array([0, 0, 1.0]), axis).matrix(), np.zeros(3))
            for k, (link, place) in enumerate(ends, 1):
                for mark, height in (("", 0.0), ("_z", 0.07))[: 2 if kind == "hinge" else 1]:
                    frame = f"closing_{name}_{k}{mark}"
                    at = _origin(place * z * pin.SE3(np.eye(3), np.array([0, 0, height])), digits)
                    lines.append(f'<link name="{frame}"/><joint name="{frame}_at" type="fixed"><origin {at}/>')
                    lines.append(f'<parent link="{link}"/><child link="{frame}"/></joint>')
            continue
        sides = zip(("predecessor", "successor"), ends, strict=True)
        inner = (
            "".join(f'<{side} link="{link}"><origin {_origin(place, digits)}/></{side}>' for side, (link, place) in sides)
            if dialect == "loop"
            else "".join(f'<link{k} link="{link}" {_origin(place, digits)}/>' for k, (link, place) in enumerate(ends, 1))
        )
        lines.append(f'<{dialect} name="{name}" type="{TYPES[kind]}">{inner}{turns}</{dialect}>')
    return "\n".join(['<robot name="any">', *lines, "</robot>"])


def _quaternion(rotation):
    x, y, z, w = pin.Quaternion(rotation).coeffs()
    return _text([w, x, y, z])


def mjcf(made):
    """Every body has another frame than its joint, and is drawn in the closed pose at ``ref``; loops are between bodies."""
    frames = {link: pin.SE3(pin.exp3(made.rng.normal(size=3)), made.rng.uniform(-0.2, 0.2, 3)) for link in made.inertias} | {"world": HERE}

    def body(joint):
        name, kind, parent, child, place, axis = joint
        q = made.home[made.names.index(name)]
        at, back = frames[parent].inverse() * place * _step(kind, axis, q) * frames[child], frames[child].inverse()
        inertia, more = back.act(made.inertias[child]), f'armature="{made.armature.get(name, 0.0):.17g}"'
        if name in made.springs:
            more += ' stiffness="{:.17g}" springref="{:.17g}" damping="{:.17g}"'.format(*made.springs[name])
        tensor = inertia.inertia
        moments = _text([*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2]])
        return (
            f'<body name="{child}" pos="{_text(at.translation)}" quat="{_quaternion(at.rotation)}">'
            f'<joint name="{name}" type="{"hinge" if kind == "revolute" else "slide"}" pos="{_text(back.translation)}"'
            f' axis="{_text(back.rotation @ axis)}" ref="{q:.17g}" {more}/>'
            f'<inertial pos="{_text(inertia.lever)}" mass="{inertia.mass:.17g}" fullinertia="{moments}"/>'
            f"{''.join(body(other) for other in made.joints if other[2] == child)}</body>"
        )

    equalities = []
    for _, kind, one, first, other, second, axis in made.loops:
        bodies = f'body1="{one}" body2="{other}"'
        if kind == "weld":
            pose = frames[one].inverse() * first * second.inverse() * frames[other]
            equalities.append(f'<weld {bodies} relpose="{_text(pose.translation)} {_quaternion(pose.rotation)}"/>')
            continue
        for height in (0.0, 0.05)[: 2 if kind == "hinge" else 1]:
            equalities.append(f'<connect {bodies} anchor="{_text((frames[one].inverse() * first).act(axis * height))}"/>')
    motors = "".join(f'<motor joint="{driver}"/>' for driver in made.drivers)
    tree = "".join(body(joint) for joint in made.joints if joint[2] == "world")
    return (
        f'<mujoco><compiler angle="radian"/><worldbody>{tree}</worldbody>'
        f"<equality>{''.join(equalities)}</equality><actuator>{motors}</actuator></mujoco>"
    )


# ---------------------------------------------------------------------------------------------------------------------------------- tests


def mechanism(family, kind="ball", *, seed, drawn_open=0.3):
    made = Mechanism(np.random.default_rng([seed, 5]), drawn_open)
    FAMILIES[family](made, kind)
    return made


def load(tmp_path, text, ending):
    path = tmp_path / f"any.{ending}"
    path.write_text(text)
    return pp.load(path)


def compare(press, made, *, seed=0, tolerance=1e-8, gap=1e-11):
    """Positions, accelerations and efforts at a state near home, by every engine."""
    rng, places = np.random.default_rng(seed), [press.joints.index(name) for name in made.names]
    count, begin = len(press.drivers), press.closed[[press.joints.index(driver) for driver in press.drivers]]
    at, speed, acceleration = begin + rng.uniform(-0.03, 0.03, count), rng.uniform(-1, 1, count), rng.uniform(-3, 3, count)
    state = [values[None] if count > 1 else values for values in (at, speed, acceleration)]
    motion = pp.servo_cycle(press, state[0], speed=state[1], acceleration=state[2])
    q, v, motors = motion.joint_position[0][places], motion.v[0][places], len(press.motors)
    np.testing.assert_allclose(q[[made.names.index(driver) for driver in press.drivers]], at, atol=1e-12)
    gaps, columns, _ = made.rows(q, v)
    assert np.abs(gaps).max() < gap
    assert np.abs(columns @ v).max() < 10 * gap
    expected, efforts, free = made.solve(q, v, press.motors, acceleration[:motors], press.held)
    assert free == count - motors
    for engine in press.engines:
        forces = pp.inverse_dynamics(press, motion, engine=engine)
        np.testing.assert_allclose(forces.motion.a[0][places], expected, atol=tolerance * max(1.0, np.abs(expected).max()))
        np.testing.assert_allclose(np.ravel(forces.driving_torque)[:motors], efforts, atol=tolerance * np.abs(efforts).max())


URDFS = [
    pytest.param(
        family, kind, dialect, seed, marks=[] if seed == 0 and (family, dialect) != ("cut_rod", "loop_joint") else pytest.mark.exhaustive
    )
    for family, kind in [("five_bar", "ball"), ("five_bar", "hinge"), ("sliding_bar", "hinge"), ("wrist", "hinge"), ("cut_rod", "weld")]
    for dialect in ("loop_joint", "loop", "closing")
    if (kind, dialect) != ("weld", "closing")
    for seed in range(6)
]


@pytest.mark.one_in(7)
@pytest.mark.parametrize(("family", "kind", "dialect", "seed"), URDFS)
def test_mechanisms_that_are_drawn_open(family, kind, dialect, seed, tmp_path):
    made = mechanism(family, kind, seed=seed)
    compare(load(tmp_path, urdf(made, dialect), "urdf"), made, seed=seed)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.exhaustive) for seed in range(1, 6))])
@pytest.mark.parametrize("digits", [4, 6, 8])
@pytest.mark.parametrize("family", ["five_bar", "wrist"])
def test_hinges_with_rounded_numbers(family, digits, seed, tmp_path):
    """A hinge in a plane or on a sphere holds more than it needs; axes of four decimals have lengths up to 0.00009 off 1."""
    made = mechanism(family, "hinge", seed=seed, drawn_open=0.0)
    press = load(tmp_path, urdf(made, "loop_joint", digits), "urdf")
    assert press.mobility == 2
    compare(press, made, seed=seed, tolerance=300 * 10.0**-digits, gap=30 * 10.0**-digits)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.exhaustive) for seed in range(1, 6))])
@pytest.mark.parametrize(
    ("family", "kind", "sprung"),
    [
        ("five_bar", "hinge", "B"),
        ("sliding_bar", "ball", "slide_r"),
        ("wrist", "hinge", "m2"),
        pytest.param("cut_rod", "weld", None, marks=pytest.mark.exhaustive),
    ],
)
def test_springs_dampers_and_rotors_of_mjcf(family, kind, sprung, seed, tmp_path):
    pytest.importorskip("mujoco")
    made = mechanism(family, kind, seed=seed)
    for k, name in enumerate(made.names):
        stiffness = 1e3 if name == "slide_r" else 15.0
        made.springs[name] = (stiffness if name == sprung else 0.0, made.home[k] + 0.1, 0.05 * (k + 1))
        made.armature[name] = 0.01 * (k + 1)
    made.drivers = tuple(driver for driver in made.drivers if driver != sprung)
    press = load(tmp_path, mjcf(made), "xml")
    assert press.passive == ((sprung,) if sprung else ())
    np.testing.assert_allclose([press.closed[press.joints.index(name)] for name in made.names], made.home, atol=1e-9)
    compare(press, made, seed=seed)


def test_sdf_keeps_springs_and_says_which_damping_is_not_read_back(tmp_path):
    pytest.importorskip("mujoco")
    made = mechanism("five_bar", seed=0)
    made.springs, made.drivers = {"B": (15.0, made.home[2] + 0.1, 0.2), "K": (0.0, 0.0, 0.1)}, ("A",)
    with pytest.warns(pp.PinpressWarning, match="the damping of K acts in Gazebo, and not in pinpress"):
        path = pp.write_sdf(load(tmp_path, mjcf(made), "xml"), tmp_path / "back.sdf")
    del made.springs["K"]
    back = pp.load(path)
    unread = [note.element for note in pp.check(path).notes if "does not read damping" in note.problem]
    assert unread == ['<joint name="K">']
    for k, (name, kind, parent, child, place, axis) in enumerate(made.joints):  # zero is the closed pose
        made.joints[k] = name, kind, parent, child, place * _step(kind, axis, made.home[k]), axis
    made.springs["B"] = (15.0, 0.1, 0.2)
    compare(back, made)
