"""The JF75G-125 in its four arrangements against published values, its exact equation of motion, and forces in closed form.

Source: Zhang 2007 (master thesis): masses and moments of inertia; the lengths are inferred, see the URDF files. `reference/jf75g_125.json`
was computed from them without pinpress. The closed form is that of two crank-sliders on one shaft, as complex numbers x + iz in the picture
plane: the main one hangs down from the crankshaft, the counterweight's stands up on it.
"""

import json
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import pinpress as pp

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "jf75g_125.json").read_text(encoding="utf-8"))
KINEMATICS = REFERENCE["kinematics_300rpm"]
SHAKING = REFERENCE["shaking"]
G = 9.80665
FLYWHEEL = 940.0  # [kg], on the frame in the reference, not in the URDF files
SPEED = 300 * pp.RPM
PRESSES = ("jf75g_125_plain", "jf75g_125", "jf75g_125_symmetric", "jf75g_125_two_point")
COUNTERWEIGHTED = PRESSES[1:]
A, B = 0.25, 0.30  # [m] shafts at x = -A and A of the symmetric press, main rods at y = -B and B of the double-point one
SIDES = ("left", "right")
TURN = {"angle": np.arange(72) * (2 * np.pi / 72), "speed": SPEED, "acceleration": 0.0}
# Angles over two turns and backwards, with speed (through zero) and acceleration of their own.
SERVO = {"angle": np.linspace(9, -4, 97), "speed": 30 * np.cos(np.linspace(0, 7, 97)), "acceleration": 900 * np.sin(np.linspace(1, 9, 97))}
MOTIONS = {"turn": TURN, "servo": SERVO}


class CrankSlider(NamedTuple):
    """A crank-slider with its crank's centre of mass at the pin, its rod's half-way. ``down``: direction of the slide from the shaft."""

    down: complex
    r: float  # [m]
    length: float  # of the rod [m]
    crank: float  # [kg]
    crank_inertia: float  # about the shaft [kg m2]
    rod: float  # [kg]
    rod_inertia: float  # about the centre of mass [kg m2]
    slide: float  # [kg]


MAIN = CrankSlider(-1j, 0.015, 0.300, 52.25, 0.289, 77.49, 77.49 * 0.300**2 / 12, 2200.0)
AUXILIARY = CrankSlider(1j, 0.0297, 0.600, 18.38, 0.217, 113.31, 113.31 * 0.600**2 / 12, 1045.0)
PARTS = {name: (MAIN,) if name == "jf75g_125_plain" else (MAIN, AUXILIARY) for name in PRESSES}


class Coordinate(NamedTuple):
    """A coordinate with its first two derivatives by the crank angle."""

    value: np.ndarray
    first: np.ndarray
    second: np.ndarray

    def velocity(self, motion):
        return self.first * motion.crank_speed

    def acceleration(self, motion):
        return self.first * motion.crank_acceleration + self.second * motion.crank_speed**2


def paths(part, angle):
    """Of the crank pin, the rod's centre of mass, the slide, and the angle by which the rod has turned from x towards z.

    sin phi = lam sin q, and the slide is at r cos q + l cos phi from the shaft.
    """
    lam = part.r / part.length
    sine, cosine = np.sin(angle), np.cos(angle)
    phi = np.arcsin(lam * sine)
    phi1 = lam * cosine / np.cos(phi)
    phi2 = np.tan(phi) * (phi1**2 - 1)
    pin = part.r * part.down * np.exp(1j * angle)
    pin = Coordinate(pin, 1j * pin, -pin)
    slide = Coordinate(
        part.down * (part.r * cosine + part.length * np.cos(phi)),
        part.down * (-part.r * sine - part.length * np.sin(phi) * phi1),
        part.down * (-part.r * cosine - part.length * (np.cos(phi) * phi1**2 + np.sin(phi) * phi2)),
    )
    rod = Coordinate(*((p + s) / 2 for p, s in zip(pin, slide, strict=True)))
    return pin, rod, slide, Coordinate(-phi, -phi1, -phi2)


def driving_torque(parts, motion):
    """The exact reduced equation: torque = I q'' + I' q'^2 / 2 + V'."""
    inertia = slope = lifting = 0.0
    for part in parts:
        pin, rod, slide, turn = paths(part, motion.crank_angle)
        inertia += part.crank_inertia + part.rod_inertia * turn.first**2
        slope += 2 * part.rod_inertia * turn.first * turn.second
        lifting += G * part.crank * pin.first.imag
        for mass, path in ((part.rod, rod), (part.slide, slide)):
            inertia += mass * np.abs(path.first) ** 2
            slope += 2 * mass * (path.first.conj() * path.second).real
            lifting += G * mass * path.first.imag
    return inertia * motion.crank_acceleration + slope * motion.crank_speed**2 / 2 + lifting


class Forces(NamedTuple):
    """On the rod by the crank, on the slide by the rod, on the slide by its guide, on the crank by its shaft: x + iz [N]."""

    pin: np.ndarray
    slide: np.ndarray
    guide: np.ndarray
    shaft: np.ndarray


def forces(part, motion, lift=0.0):
    """From the slide, with an upward load on it [N], back to the shaft; the side thrust is from the rod's moments about its crank pin."""
    pin, rod, slide, turn = paths(part, motion.crank_angle)
    up = part.slide * (slide.acceleration(motion).imag + G) - lift
    pushed = part.rod * (rod.acceleration(motion) + 1j * G)
    arm = slide.value - pin.value
    about_pin = part.rod_inertia * turn.acceleration(motion) + ((arm / 2).conj() * pushed).imag
    side = (about_pin + arm.real * up) / arm.imag  # about_pin is the moment of -(side + i up) at the arm
    on_rod = side + 1j * up + pushed
    return Forces(on_rod, side + 1j * up, -side, on_rod + part.crank * (pin.acceleration(motion) + 1j * G))


def space(force):
    """World axes (n, 3) of x + iz."""
    return np.stack([force.real, np.zeros(len(force)), force.imag], axis=1)


@cache
def load(name, gravity=G):
    return pp.load(name, gravity=(0, 0, -gravity))


def solved(press, engine, motion="servo", loads=(), **options):
    moved = pp.servo_cycle(press, **MOTIONS[motion], engine=engine)
    return pp.inverse_dynamics(press, moved, loads, engine=engine, **options)


def near(values, expected, tolerance, peak=None):
    """Within a tolerance relative to the peak."""
    assert np.abs(values - expected).max() <= tolerance * np.abs(expected if peak is None else peak).max()


# ------------------------------------------------------------------------------------------------------------------------ all of them


@pytest.mark.parametrize("name", PRESSES)
def test_kinematics_equal_the_reference(name, engine):
    """Height above bottom dead centre, speed and acceleration at 300 r/min: 1e-12 of the peak, of the height 1e-12 of the rod: rounding."""
    rows = KINEMATICS.items()
    motion = pp.servo_cycle(load(name), angle=np.radians([float(degrees) for degrees, _ in rows]), speed=SPEED, engine=engine)
    height, down, faster = (np.array([row[key] for _, row in rows]) for key in ("height_mm", "v_down_m_s", "a_down_m_s2"))
    near(motion.slide_position + 0.315, height / 1000, 1e-12, peak=0.3)
    near(motion.slide_velocity, -down, 1e-12)
    near(motion.slide_acceleration, -faster, 1e-12)


@pytest.mark.parametrize("name", PRESSES)
def test_slide_and_counterweight_in_closed_form(name, engine):
    press = load(name)
    motion = pp.servo_cycle(press, **SERVO, engine=engine)
    slide = paths(MAIN, motion.crank_angle)[2]
    near(motion.slide_position, slide.value.imag, 1e-12)
    near(motion.slide_velocity, slide.velocity(motion).imag, 1e-12)
    near(motion.slide_acceleration, slide.acceleration(motion).imag, 1e-12)
    if name in COUNTERWEIGHTED:
        guide, counterweight = press.joints.index("counterweight_guide"), paths(AUXILIARY, motion.crank_angle)[2]
        near(0.6297 + motion.joint_position[:, guide], counterweight.value.imag, 1e-12)
        near(motion.v[:, guide], counterweight.velocity(motion).imag, 1e-12)
        near(motion.a[:, guide], counterweight.acceleration(motion).imag, 1e-12)


@pytest.mark.parametrize("name", PRESSES)
@pytest.mark.parametrize("motion", MOTIONS)
def test_torque_is_that_of_the_reduced_equation(name, motion, engine):
    result = solved(load(name), engine, motion)
    near(result.driving_torque, driving_torque(PARTS[name], result.motion), 1e-12)


@pytest.mark.parametrize(("name", "redundant"), list(zip(PRESSES, (0, 0, 2, 1), strict=True)))
def test_redundant_equations_are_found(name, redundant):
    """In the plane a loop gives two equations, a gear pair one. However many are too many, all move with one degree of freedom."""
    press = load(name)
    assert press.mobility == 1
    assert 2 * len(press.loops) + len(press.couplings) - press.rank == redundant
    assert "plane" in press.engines
    assert sum(block.redundant for block in press.engine("plane").plane.blocks) == redundant


@pytest.mark.parametrize("name", PRESSES)
def test_stroke(name):
    """Twice the crank radius, 30 mm, as the slide runs on the line of the shaft."""
    ends = pp.dead_centres(load(name))
    assert ends.stroke == pytest.approx(0.030, rel=1e-12)
    assert (ends.bottom_angle, ends.top_angle) == pytest.approx((0.0, np.pi), abs=1e-12)


# ---------------------------------------------------------------------------------------------------------------- plain and opposed


def at_angles(press, speed, engine, angles):
    return pp.inverse_dynamics(press, pp.servo_cycle(press, angle=angles, speed=speed, engine=engine), engine=engine)


@cache
def all_round(press, speed, engine):
    """What every search for extremes begins with."""
    return at_angles(press, speed, engine, np.radians(np.arange(0.0, 361.0, 3.0)))


def extremes(press, speed, engine, curve):
    """Largest and smallest value of a curve over a turn: from steps of 3 degrees, refined tenfold five times, to 1e-12 of its swing."""
    found = []
    for sign in (1, -1):
        result = all_round(press, speed, engine)
        for _ in range(5):
            angles = result.motion.crank_angle
            best, step = angles[np.argmax(sign * curve(result))], angles[1] - angles[0]
            result = at_angles(press, speed, engine, best + np.linspace(-step, step, 21))
        found.append(sign * (sign * curve(result)).max())
    return found


@pytest.mark.parametrize("rpm", ["300", "400"])
@pytest.mark.parametrize("name", SHAKING)
def test_extremes_of_the_shaking_force_and_moment_equal_the_reference(name, rpm, engine):
    """Each to 1e-10 of itself, though the opposed press' vertical range is 119 N of forces of 34 kN that balance each other."""
    speed, weight = float(rpm) * pp.RPM, FLYWHEEL * G

    def both(press, axis):
        return extremes(press, speed, engine, lambda result: result.shaking_force[:, axis])

    (most, least), (right, left), (free_most, free_least) = both(load(name), 2), both(load(name), 0), both(load(name, 0), 2)
    found = {
        "Fy_max": most - weight,
        "Fy_min": least - weight,
        "Fy_range": most - least,
        "Fy_max_nograv": free_most,
        "Fy_min_nograv": free_least,
        "Fz_max": right,
        "Fz_min": left,
        "Fz_range": right - left,
    }
    most, least = extremes(load(name, 0), speed, engine, lambda result: result.shaking_moment[:, 1])
    assert found | {"M_range": most - least} == pytest.approx(SHAKING[name][rpm], rel=1e-10, abs=0)


@pytest.mark.parametrize("name", SHAKING)
def test_bearing_forces_in_closed_form(name, engine):
    """1e-12 of the peak of all: rounding."""
    result = solved(load(name), engine)
    main, auxiliary = forces(MAIN, result.motion), forces(AUXILIARY, result.motion)
    expected = {"P2": main.pin, "P4": main.slide, "slide_guide": main.guide, "O": main.shaft}
    if name == "jf75g_125":
        expected |= {"P3": auxiliary.pin, "P5": auxiliary.slide, "counterweight_guide": auxiliary.guide, "O": main.shaft + auxiliary.shaft}
    assert set(expected) == set(result.bearing_force)
    for bearing, force in expected.items():
        near(result.bearing_force[bearing], space(force), 1e-12, peak=main.shaft)


# --------------------------------------------------------------------------------------------------------------------- symmetric press


def mirrored(vectors):
    """Vectors (n, 3) in a mirror at x = 0."""
    return vectors * [-1.0, 1.0, 1.0]


@pytest.mark.parametrize("motion", MOTIONS)
def test_symmetric_press_neither_shakes_sideways_nor_tilts(motion, engine):
    """Lateral force and moment about y, gravity included, of the vertical force. 1e-12: rounding; the opposed press has 1e-3 and more. Both
    shake alike upright."""
    symmetric, opposed = (solved(load(name), engine, motion) for name in ("jf75g_125_symmetric", "jf75g_125"))
    near(symmetric.shaking_force[:, 2], opposed.shaking_force[:, 2], 1e-12)
    peak = np.abs(symmetric.shaking_force[:, 2]).max()
    for result, most, least in ((symmetric, 1e-12, 0.0), (opposed, np.inf, 1e-3)):
        for values in (result.shaking_force[:, 0], result.shaking_moment[:, 1]):
            assert least * peak <= np.abs(values).max() <= most * peak


@pytest.mark.parametrize("side", SIDES)
def test_either_side_of_the_symmetric_press_carries_half(side, engine):
    """Rods and shafts as those of an opposed press of half the masses, on the right in the mirror, though the left shaft drives alone."""
    result = solved(load("jf75g_125_symmetric"), engine)
    main, auxiliary = forces(MAIN, result.motion), forces(AUXILIARY, result.motion)
    expected = {"P2": main.pin, "P4": main.slide, "P3": auxiliary.pin, "P5": auxiliary.slide, "O": main.shaft + auxiliary.shaft}
    for bearing, force in expected.items():
        half = space(force) / 2
        near(result.bearing_force[f"{bearing}_{side}"], half if side == "left" else mirrored(half), 1e-12, peak=space(main.shaft))


def test_guides_of_the_symmetric_press_carry_nothing(engine):
    result = solved(load("jf75g_125_symmetric"), engine)
    peak = np.abs(result.bearing_force["O_left"]).max()
    for guide in ("slide_guide", "counterweight_guide"):
        assert np.abs(result.bearing_force[guide]).max() <= 1e-12 * peak
        assert np.abs(result.bearing_moment[guide]).max() <= 1e-12 * peak * A


@pytest.mark.parametrize("motion", MOTIONS)
def test_gear_pair_carries_half_of_the_torque(motion, engine):
    """What the right half needs, half of the whole; the right shaft turns against the left one, so it is negative on both."""
    result = solved(load("jf75g_125_symmetric"), engine, motion)
    half = driving_torque((MAIN, AUXILIARY), result.motion) / 2
    near(result.coupling_torque["O_right"], np.stack([-half, -half], axis=1), 1e-12)
    for side, torque in (("left", half), ("right", -half)):  # on either crank, drive and gear together, about the axis -y
        near(-result.bearing_moment[f"O_{side}"][:, 1], torque, 1e-12)


def test_what_the_sides_of_the_symmetric_press_share_is_flagged(engine):
    """Idle forces run along the rods: they reach pins and shafts, load the gears, press sideways on the guides and turn them."""
    flags = solved(load("jf75g_125_symmetric"), engine, "turn").indeterminate
    in_the_plane = {bearing: tuple(flag[[0, 2, 4]]) for bearing, flag in flags.items()}  # forces in x and z, moment about y
    expected = {f"{pin}_{side}": (True, True, pin == "O") for pin in ("O", "P2", "P3", "P4", "P5") for side in SIDES}
    assert in_the_plane == expected | dict.fromkeys(("slide_guide", "counterweight_guide"), (True, False, True))


# ------------------------------------------------------------------------------------------------------------------ double-point press

POINTS = {"front": -B, "back": B}  # y [m]
STIFFNESS = {"equal": {}, "stiff_front": {"P4_front": 2e9, "P4_back": 1e9}}  # [N/m]
FRONT = {"equal": 1 / 2, "stiff_front": 2 / 3}  # of the force along the rods
LOADS = {"idle": (0.0, 0.0), "eccentric": (4e5, 0.4)}  # upwards on the slide [N], at y [m]
UPRIGHT = np.array([0.0, 0.0, 1.0])


@pytest.fixture(params=STIFFNESS)
def stiffness(request):
    return request.param


@pytest.fixture(params=LOADS)
def load_case(request):
    return request.param


@pytest.fixture
def two_point(engine, stiffness, load_case):
    force, y = LOADS[load_case]
    pressed = [pp.loads.PointForce("slide", force * UPRIGHT, (0.0, y, -0.5))]
    return solved(load("jf75g_125_two_point"), engine, loads=pressed, stiffness=STIFFNESS[stiffness])


def shared(motion, front, force):
    """Forces (n, 3) on rod and slide: {"P2_front": ..., "P4_back": ...}, those of one rod in the middle shared out.

    Across the rods each carries half, by the moments about its own crank pin; along them any share is in balance.
    """
    pin, _, slide, _ = paths(MAIN, motion.crank_angle)
    along = (slide.value - pin.value) / MAIN.length
    whole = forces(MAIN, motion, force)
    axial = (along.conj() * whole.slide).real * along
    shares = {"front": front * axial, "back": (1 - front) * axial}
    across = (whole.slide - axial) / 2
    on_slide = {f"P4_{point}": share + across for point, share in shares.items()}
    on_rod = {f"P2_{point}": share + across + (whole.pin - whole.slide) / 2 for point, share in shares.items()}
    return {bearing: space(force) for bearing, force in (on_slide | on_rod).items()}


def moment_about_the_middle(bearing, expected):
    """Of the forces at the two points (n, 3)."""
    return sum(np.cross([0.0, y, 0.0], expected[f"{bearing}_{point}"]) for point, y in POINTS.items())


def test_two_points_together_carry_what_one_does(two_point, load_case):
    """In sum, and in the other bearings, the forces of the opposed press, whatever the stiffnesses."""
    main, auxiliary = forces(MAIN, two_point.motion, LOADS[load_case][0]), forces(AUXILIARY, two_point.motion)
    found = dict(two_point.bearing_force)
    for pin in ("P2", "P4"):
        found[pin] = found.pop(f"{pin}_front") + found.pop(f"{pin}_back")
    expected = {"P2": main.pin, "P4": main.slide, "slide_guide": main.guide, "O": main.shaft + auxiliary.shaft}
    expected |= {"P3": auxiliary.pin, "P5": auxiliary.slide, "counterweight_guide": auxiliary.guide}
    assert set(found) == set(expected)
    for bearing, force in expected.items():
        near(found[bearing], space(force), 1e-12, peak=main.shaft)


def test_two_points_share_by_stiffness(two_point, stiffness, load_case):
    """Along the rods as their stiffnesses, equally where none is given. The shaft holds the crank against the rods about x and z, the guide
    holds the slide against the rods and a load beside the middle plane."""
    force, y = LOADS[load_case]
    expected = shared(two_point.motion, FRONT[stiffness], force)
    for bearing, each in expected.items():
        near(two_point.bearing_force[bearing], each, 1e-12)
    on_crank = moment_about_the_middle("P2", expected)
    near(two_point.bearing_moment["O"][:, [0, 2]], on_crank[:, [0, 2]], 1e-12, peak=B * expected["P2_front"])
    on_slide = moment_about_the_middle("P4", expected) + np.cross([0.0, y, -0.5], force * UPRIGHT)
    near(two_point.bearing_moment["slide_guide"], -on_slide, 1e-12, peak=B * expected["P4_front"])


def test_what_two_points_share_is_flagged(engine):
    """Idle forces run along the main rods, in x and z, and turn shaft and slide about x and z; all else in the plane is determined."""
    flags = solved(load("jf75g_125_two_point"), engine, "turn").indeterminate
    shared_bearings = {f"{pin}_{point}" for pin in ("P2", "P4") for point in POINTS}
    for bearing, (x, _, z, _, about_y, _) in flags.items():
        assert (x, z, about_y) == ((True, True, False) if bearing in shared_bearings else (False, False, False)), bearing
    for bearing in ("O", "slide_guide"):
        assert flags[bearing][[3, 5]].all()
