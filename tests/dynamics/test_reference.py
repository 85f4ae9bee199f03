"""The shipped presses against published values, an independent script, and mechanics in closed form.

Source of the ZXN2-3000(B): Kong X. et al. 2025, Forging and Stamping Technology 50(2), 195-203. `reference/zxn2_3000b.json` was computed
from its lengths and masses (and inferred inertias) without pinpress; `support.oracles.six_bar_script` is a second such computation.
"""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from support import texts
from support.oracles.six_bar_script import six_bar, world_forces

import pinpress as pp

ROOT = Path(__file__).parents[1]
REFERENCE = json.loads((ROOT / "reference" / "zxn2_3000b.json").read_text(encoding="utf-8"))
TABLE = REFERENCE["table"]
EXTREMES = REFERENCE["kinematic_extremes"]
SPEED = 70 * pp.RPM
TURN = 2 * np.pi / SPEED  # [s]
ENGINES = ("plane", "space", "pinocchio")
PRESSES = {"before": "zxn2_3000b", "after": "zxn2_3000b_balanced"}
BALANCED = {"zxn2_3000b": False, "zxn2_3000b_balanced": True}
THETA2, THETA3 = 2.743420032466139, 0.850905189263493  # drawn angles of coupler and rocker
THETA4 = THETA3 - 2.4872085419244342  # of the rod
# Angles over two turns and backwards, with speed (through zero) and acceleration of their own.
SERVO = {"angle": np.linspace(9, -4, 97), "speed": 8 * np.cos(np.linspace(0, 7, 97)), "acceleration": 30 * np.sin(np.linspace(1, 9, 97))}


@pytest.fixture(scope="module")
def presses():
    return {name: texts.shipped(name) for name in (*BALANCED, "crank_slide")}


def at(press, degrees, engine="auto"):
    """Motion at one or more crank angles, at the reference's speed."""
    angle = np.radians(np.atleast_1d(degrees))
    return pp.servo_cycle(press, angle=angle, speed=SPEED, engine=engine)


def column(name):
    return np.array([row[name] for row in TABLE])


def link_motion(press, motion):
    """{i: (angle, rate, acceleration)} of coupler 2, rocker 3 and rod 4 in the picture plane; joints of the tree: A, B, D, E."""
    joints = {name: press.joints.index(name) for name in "ABDE"}
    q = {}
    for name, joint in joints.items():
        start, unbounded = press.model.joints[joint + 1].idx_q, press.model.joints[joint + 1].nq == 2
        q[name] = np.arctan2(motion.q[:, start + 1], motion.q[:, start]) if unbounded else motion.q[:, start]
    sums = {2: ("A", "B"), 3: ("D",), 4: ("D", "E")}
    drawn = {2: THETA2, 3: THETA3, 4: THETA4}
    return {
        i: (drawn[i] + sum(q[n] for n in names), *(sum(rates[:, joints[n]] for n in names) for rates in (motion.v, motion.a)))
        for i, names in sums.items()
    }


@pytest.mark.parametrize("press_name", PRESSES.values())
def test_kinematics_equal_the_reference(presses, press_name, engine):
    """Slide, link angles, rates and accelerations at every row, 1e-12 relative: both sides close to rounding."""
    press = presses[press_name]
    motion = at(press, column("theta1_deg"), engine)
    for name, values in (("y", motion.slide_position), ("v", motion.slide_velocity), ("a", motion.slide_acceleration)):
        np.testing.assert_allclose(values, column(name), rtol=1e-12, atol=0, err_msg=name)
    for i, (angle, rate, acceleration) in link_motion(press, motion).items():
        wrapped = np.angle(np.exp(1j * (angle - column(f"theta{i}"))))
        assert np.abs(wrapped).max() < 1e-12
        np.testing.assert_allclose(rate, column(f"w{i}"), rtol=1e-12, atol=0)
        np.testing.assert_allclose(acceleration, column(f"al{i}"), rtol=1e-12, atol=0)


@pytest.mark.parametrize("state", PRESSES)
def test_torque_and_forces_equal_the_reference(presses, state, engine):
    """Torque and all bearings at every row, to 1e-10 of each one's peak: rounding of a 14 by 14 system."""
    press = presses[PRESSES[state]]
    result = pp.inverse_dynamics(press, at(press, column("theta1_deg"), engine), engine=engine)
    # what body i does to body j, in our order parent on child (link1 on link2)
    expected = {key: np.array([row[state][key] for row in TABLE]) for key in TABLE[0][state]}
    forces = world_forces(expected)
    assert set(forces) == set(press.bearings)
    for name in forces:
        assert np.abs(result.bearing_force[name] - forces[name]).max() <= 1e-10 * np.abs(forces[name]).max(), name
    assert np.abs(result.driving_torque - expected["tau"]).max() <= 1e-10 * np.abs(expected["tau"]).max()


@pytest.mark.parametrize("name", ["TDC", "BDC"])
def test_dead_centres(presses, name, engine):
    """The slide stands still there: 1e-13 m/s is the rounding of the printed angle."""
    expected = EXTREMES["dead_points"][name]
    motion = at(presses["zxn2_3000b"], expected["theta1_deg"], engine)
    assert abs(motion.slide_velocity[0]) < 1e-13
    np.testing.assert_allclose(motion.slide_position, expected["yF"], rtol=1e-12)
    np.testing.assert_allclose(motion.slide_acceleration, expected["a5"], rtol=1e-12)
    np.testing.assert_allclose(motion.crank_angle / SPEED, expected["t"], rtol=1e-12)


@pytest.mark.parametrize(
    ("key", "quantity", "sign"),
    [
        ("y_max", "slide_position", 1),
        ("y_min", "slide_position", -1),
        ("v_up", "slide_velocity", 1),
        ("v_down", "slide_velocity", -1),
        ("a_max", "slide_acceleration", 1),
        ("a_min", "slide_acceleration", -1),
    ],
)
def test_extremes(presses, key, quantity, sign, engine):
    """The value at the reference's angle to 1e-12, and less on both sides of it: it is the extreme."""
    value, degrees, seconds = EXTREMES[key]
    values = getattr(at(presses["zxn2_3000b"], [degrees, degrees - 0.1, degrees + 0.1], engine), quantity)
    np.testing.assert_allclose(values[0], value, rtol=1e-12)
    assert sign * values[0] > sign * values[1]
    assert sign * values[0] > sign * values[2]
    np.testing.assert_allclose(np.radians(degrees) / SPEED, seconds, rtol=1e-12)
    turn = getattr(pp.cycle(presses["zxn2_3000b"], SPEED, points=3600), quantity)
    assert (sign * turn).max() <= sign * value + 1e-12


@pytest.mark.parametrize("press_name", BALANCED)
@pytest.mark.parametrize("motion_name", ["turn", "backward", "servo"])
def test_hand_script(presses, press_name, engine, motion_name):
    """Every quantity over 720 crank angles and over a servo motion, to 1e-10 of its peak; both scripts condition alike."""
    press = presses[press_name]
    motion = {
        "turn": lambda: pp.cycle(press, SPEED, points=720, engine=engine),
        "backward": lambda: pp.cycle(press, -SPEED, points=90, engine=engine),
        "servo": lambda: pp.servo_cycle(press, **SERVO, engine=engine),
    }[motion_name]()
    expected = six_bar(motion.crank_angle, motion.crank_speed, motion.crank_acceleration, BALANCED[press_name])
    result = pp.inverse_dynamics(press, motion, engine=engine)

    def same(name, values, wanted):
        assert np.abs(values - wanted).max() <= 1e-10 * np.abs(wanted).max(), name

    for name in ("slide_position", "slide_velocity", "slide_acceleration"):
        same(name, getattr(motion, name), expected[name])
    for i, (angle, rate, acceleration) in link_motion(press, motion).items():
        same(i, np.exp(1j * angle), np.exp(1j * expected[f"theta{i}"]))
        same(i, rate, expected[f"omega{i}"])
        same(i, acceleration, expected[f"alpha{i}"])
    same("torque", result.driving_torque, expected["tau"])
    forces = world_forces(expected)
    for name in forces:
        same(name, result.bearing_force[name], forces[name])
    grounded = -forces["A"] - forces["D"] - forces["slide_guide"]
    same("shaking force", result.shaking_force, grounded)


def test_moments_of_the_hand_script(presses):
    """Turning pins carry no moment but the driver's torque. (The guide's is the slide's own, of which the script knows nothing.)"""
    press = presses["zxn2_3000b"]
    motion = pp.servo_cycle(press, **SERVO)
    tau = six_bar(motion.crank_angle, motion.crank_speed, motion.crank_acceleration)["tau"]
    for engine in ENGINES:
        moment = pp.inverse_dynamics(press, motion, engine=engine).bearing_moment
        peak = np.abs(tau).max()
        np.testing.assert_allclose(moment["A"], np.outer(tau, [0.0, -1.0, 0.0]), atol=1e-10 * peak)
        for name in "BCDEF":
            assert np.abs(moment[name]).max() <= 1e-10 * peak


def test_balancing_claims(presses, engine):
    """Range of the shaking force after balancing against before, Kong 2025: -47.42 % across, -2.741 % along the slide."""
    before, after = (
        np.ptp(pp.inverse_dynamics(press, pp.cycle(press, SPEED, points=720, engine=engine), engine=engine).shaking_force, axis=0)
        for press in (presses["zxn2_3000b"], presses["zxn2_3000b_balanced"])
    )
    change = 100 * (after - before)[[0, 2]] / before[[0, 2]]
    assert (round(change[0], 2), round(change[1], 3)) == (-47.42, -2.741)
    assert max(before[1], after[1]) <= 1e-12 * before[2]  # nothing across the plane


def test_the_shaking_force_does_not_know_the_inertias(presses):
    """The inferred inertias enter the torque, but not the shaking force: the claims above are the paper's masses alone. 1e-12: rounding."""
    press = presses["zxn2_3000b"]
    text = re.sub(r'(i(xx|yy|zz))="([\d.]+)"', lambda m: f'{m[1]}="{2 * float(m[3])}"', press.text.decode())
    one, other = (pp.inverse_dynamics(p, pp.cycle(p, SPEED, points=72)) for p in (press, texts.load(text)))
    peak = np.abs(one.shaking_force).max()
    assert np.abs(one.shaking_force - other.shaking_force).max() <= 1e-12 * peak
    assert np.abs(one.driving_torque - other.driving_torque).max() > 1e-2 * np.abs(one.driving_torque).max()


R, L = 0.1, 0.4
LAM = R / L


def crank_slide(angle):
    """Position of the slide and rod angle with their first two derivatives by the crank angle: (z, z', z''), (psi, psi', psi'').

    sin psi = lam sin q, and z = -r cos q - l cos psi.
    """
    s, c = np.sin(angle), np.cos(angle)
    root = np.sqrt(1 - LAM**2 * s**2)
    root1 = -(LAM**2) * s * c / root
    root2 = -(LAM**2) * (c**2 - s**2) / root - root1**2 / root
    psi1 = LAM * c / root
    psi2 = -LAM * s / root - LAM * c * root1 / root**2
    return (-R * c - L * root, R * s - L * root1, R * c - L * root2), (np.arcsin(LAM * s), psi1, psi2)


CRANK_SLIDE_MOTIONS = {
    "turn": lambda press, engine: pp.cycle(press, 12.0, points=90, engine=engine),
    "servo": lambda press, engine: pp.servo_cycle(
        press,
        angle=np.linspace(-8, 5, 61),
        speed=10 * np.cos(np.linspace(0, 9, 61)),
        acceleration=80 * np.sin(np.linspace(1, 6, 61)),
        engine=engine,
    ),
}


@pytest.mark.parametrize("motion_name", CRANK_SLIDE_MOTIONS)
def test_crank_slide_kinematics(presses, motion_name, engine):
    """z(q) = -r cos q - l sqrt(1 - lam^2 sin^2 q) and its exact rates, to 1e-12 of the peak: rounding."""
    motion = CRANK_SLIDE_MOTIONS[motion_name](presses["crank_slide"], engine)
    (z, z1, z2), _ = crank_slide(motion.crank_angle)
    speed, acceleration = motion.crank_speed, motion.crank_acceleration
    for values, expected in (
        (motion.slide_position, z),
        (motion.slide_velocity, z1 * speed),
        (motion.slide_acceleration, z1 * acceleration + z2 * speed**2),
    ):
        assert np.abs(values - expected).max() <= 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("motion_name", CRANK_SLIDE_MOTIONS)
def test_crank_slide_torque(presses, motion_name, engine):
    """The reduced equation M = I q'' + I' q'^2 / 2 + V' of the one degree of freedom, to 1e-12 of the peak: rounding.

    Crank 20 kg with its centre of mass at 0.030 m and 0.10 kg m2 about it; rod 15 kg with its centre of mass half-way and 0.20 kg m2;
    slide 100 kg. The rod's centre of mass is at (r sin q / 2, (z - r cos q) / 2).
    """
    press = presses["crank_slide"]
    motion = CRANK_SLIDE_MOTIONS[motion_name](press, engine)
    q, speed, acceleration = motion.crank_angle, motion.crank_speed, motion.crank_acceleration
    (_, z1, z2), (_, psi1, psi2) = crank_slide(q)
    x1, x2 = R * np.cos(q) / 2, -R * np.sin(q) / 2
    h1, h2 = (z1 + R * np.sin(q)) / 2, (z2 + R * np.cos(q)) / 2
    inertia = 0.10 + 20 * 0.030**2 + 15 * (x1**2 + h1**2) + 0.20 * psi1**2 + 100 * z1**2
    slope = 2 * (15 * (x1 * x2 + h1 * h2) + 0.20 * psi1 * psi2 + 100 * z1 * z2)
    lifting = 9.81 * (20 * 0.030 * np.sin(q) + 15 * h1 + 100 * z1)
    expected = inertia * acceleration + slope * speed**2 / 2 + lifting
    torque = pp.inverse_dynamics(press, motion, engine=engine).driving_torque
    assert np.abs(torque - expected).max() <= 1e-12 * np.abs(expected).max()


def test_crank_slide_forces(presses, engine):
    """At constant speed: pin W lifts the slide, the guide takes the rod's side thrust, from its moments about P. 1e-12 of the peak."""
    press = presses["crank_slide"]
    motion = pp.cycle(press, 12.0, points=90, engine=engine)
    q = motion.crank_angle
    (z, _, z2), (psi, _, psi2) = crank_slide(q)
    w2 = 12.0**2
    up = 100 * (z2 * w2 + 9.81)  # rod on slide
    # rod turns by -psi from straight down; its centre of mass is at half of (-r sin q, z + r cos q) from P
    arm_x, arm_z = -R * np.sin(q), z + R * np.cos(q)
    a_x, a_z = -R * np.sin(q) / 2 * w2, (z2 + R * np.cos(q)) / 2 * w2
    spin = -psi2 * w2  # about -y, x towards z
    about_p = 0.20 * spin + 15 * (arm_x / 2 * (a_z + 9.81) - arm_z / 2 * a_x)
    # about_p = arm_x * (-up) - arm_z * (-side), with `side` of rod on slide along x
    side = (about_p + arm_x * up) / arm_z
    result = pp.inverse_dynamics(press, motion, engine=engine)
    zero = np.zeros_like(q)
    for name, expected in (
        ("W", np.stack([side, zero, up], axis=1)),
        ("slide_guide", np.stack([-side, zero, zero], axis=1)),
        ("P", np.stack([side + 15 * a_x, zero, up + 15 * (a_z + 9.81)], axis=1)),
    ):
        assert np.abs(result.bearing_force[name] - expected).max() <= 1e-12 * np.abs(up).max(), name
    assert psi.max() > 0.2
