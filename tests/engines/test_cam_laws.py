"""Laws of cams and the geometry of cam and roller, against printed values of an independent script, differences and the pole."""

import numpy as np
import pytest

from pinpress.common.motion_laws import VDI_LAWS
from pinpress.engines.constraints import Curve
from pinpress.engines.contacts import ZERO, UnitWrench
from pinpress.engines.machine_elements.cams import CamContact, CamLaw, CamPoint, law_problem

RISE, DWELL = np.radians([90.0, 180.0])
EPS = 1e-5


def law(name, height=0.04):
    """Rise over 90 deg, dwell, return, dwell."""
    ends = (CamPoint(0.0, 0.0), CamPoint(RISE, height, name), CamPoint(DWELL, height), CamPoint(DWELL + RISE, 0.0, name))
    return CamLaw(ends)


def cam(law, **geometry):
    """A cam in the x-z plane that turns from x to z; its follower goes up, or has its pivot on x."""
    common = {"name": "cam", "kind": "cam", "relation": 0, "first": 1, "second": 2, "carrier": 0, "unit": UnitWrench(ZERO, ZERO)}
    common |= {"curve": Curve(0, law), "sense": 1.0, "roller_radius": 0.02, "roller_width": 0.03, "grooved": False}
    return CamContact(**common | {"origin": np.array([0.3, 0.1, 0.2]), "axes": np.eye(3)[[0, 2]]} | geometry)


EJECTOR = {"radius": 0.08, "offset": 0.01}
ARM = {"radius": 0.07, "arm": 0.12, "distance": 0.15, "turning": -1.0}
SWING = CamLaw((CamPoint(0.0, 0.0), CamPoint(np.radians(100), np.radians(15), "3-4-5"), CamPoint(np.radians(200), 0.0, "3-4-5")))


@pytest.mark.parametrize(
    ("name", "angle", "lift", "pressure_angle", "force", "torque", "radius"),
    [
        ("3-4-5", 20, 3.0564446477, 8.8413955664, 4496.0388812, 101.3878918, -1298.006981),
        ("3-4-5", 45, 20, 20.799191955, 4755.139165, 212.24505323, 91.67776254),
        ("3-4-5", 70, 36.943555352, 6.290389654, 4474.8262569, 101.50815665, 64.4847066),
        ("sine", 45, 20, 22.385793035, 4807.5441485, 226.39472345, 91.04082045),
        ("modified sine", 70, 36.459358628, 7.1413959172, 4513.2167759, 109.77253414, 67.65340104),
    ],
)
def test_ejector(name, angle, lift, pressure_angle, force, torque, radius):
    """25 kg at 12 rad/s against a spring of 20 kN/m preloaded by 800 N, 3 kN and the weight. Force and moment on the cam balance."""
    made, angles = cam(law(name), **EJECTOR), np.radians([float(angle)])
    at, (value, slope, bend) = made.at(angles), made.law(angles)
    effort = 25.0 * (bend * 12.0**2 + 9.81) + 20e3 * value + 3800.0
    found = 1e3 * at.lift, np.degrees(at.pressure_angle), effort / at.leverage, effort * slope, 1e3 / at.curvature
    assert [float(each[0]) for each in found] == pytest.approx([lift, pressure_angle, force, torque, radius], rel=2e-10)
    wrench = made.wrench(np.array([angles, value]))
    push = effort * wrench.force[0]
    assert np.linalg.norm(push) == pytest.approx(force, rel=1e-10)
    assert push[2] == pytest.approx(effort[0], rel=1e-14)
    lever = wrench.point[0] - made.origin
    assert np.cross(lever, push) @ [0.0, -1.0, 0.0] == pytest.approx(torque, rel=1e-9)  # what the follower does to the cam, turned round


@pytest.mark.parametrize(
    ("angle", "swing", "slope", "pressure_angle", "force", "torque"),
    [
        (30, 29.7122444507, 0.19845, 10.31796551, 2354.47520182, 55.1627688),
        (50, 34.7660444507, 0.28125, 19.64137159, 1769.63277153, 56.25),
        (80, 41.3972444507, 0.1152, 12.12086348, 945.18451165, 12.77494315),
    ],
)
def test_swinging_arm(angle, swing, slope, pressure_angle, force, torque):
    """0.8 kg m2 at 15 rad/s against 200 N m. The force passes through the pole of cam and arm on the line of centres."""
    made, angles = cam(SWING, **ARM), np.radians([float(angle)])
    at, (value, rate, bend) = made.at(angles), made.law(angles)
    effort = 0.8 * bend * 15.0**2 + 200.0
    found = np.degrees(made.start + value), rate, np.degrees(at.pressure_angle), effort / at.leverage, effort * rate
    assert [float(each[0]) for each in found] == pytest.approx([swing, slope, pressure_angle, force, torque], rel=2e-9)
    pole = made.distance * rate / (1.0 + rate)
    assert (at.normal.conjugate() * (at.roller - pole)).imag == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    ("name", "largest", "angle"),
    [("3-4-5", 21.07281602, 41.614659), ("sine", 22.65770104, 42.021076), ("modified sine", 19.57511014, 41.204739)],
)
def test_largest_pressure_angle(name, largest, angle):
    found = np.degrees(cam(law(name), **EJECTOR).largest_pressure_angle())
    assert found[0] == pytest.approx(largest, abs=6e-9)
    assert found[1] == pytest.approx(angle, abs=1e-6)


def test_pressure_angles_of_rises_falls_and_grooves():
    """An open cam drives on its rises, which are its falls when it turns the other way; in a groove it drives on both."""
    open_cam, groove = cam(law("3-4-5"), **EJECTOR), cam(law("3-4-5"), grooved=True, **EJECTOR)
    rise, fall = open_cam.largest_pressure_angle(1.0), open_cam.largest_pressure_angle(-1.0)
    assert fall[0] > rise[0]
    assert groove.largest_pressure_angle() == open_cam.largest_pressure_angle(0.0) == fall


@pytest.mark.parametrize("geometry", [EJECTOR, ARM, ARM | {"turning": 1.0}])
@pytest.mark.parametrize("name", VDI_LAWS)
def test_curvature_and_normal_are_those_of_the_path_on_the_cam(name, geometry):
    made = cam(law(name, 0.04 if geometry is EJECTOR else 0.2), **geometry)
    angles = np.radians([11.0, 33.0, 52.0, 71.0, 120.0, 200.0, 222.0, 263.0, 300.0, 500.0])

    def on_cam(angle):
        return made.at(angle).roller * np.exp(-1j * angle)

    before, here, after = (on_cam(angles + step) for step in (-1e-3, 0.0, 1e-3))
    # the circle through three points
    sides = np.abs(after - before) * np.abs(after - here) * np.abs(here - before)
    curvature = 2.0 * ((here - before).conjugate() * (after - here)).imag / sides
    at = made.at(angles)
    np.testing.assert_allclose(at.curvature, -curvature, rtol=1e-4, atol=1e-4)
    tangent = (after - before) * np.exp(1j * angles)
    np.testing.assert_allclose((tangent.conjugate() * at.normal).real / np.abs(tangent), 0.0, atol=1e-4)
    way = made.at(angles + 1e-6).roller - made.at(angles - 1e-6).roller
    np.testing.assert_allclose(way, 2e-6 * at.way * at.slope, atol=2e-11)


@pytest.mark.parametrize("name", VDI_LAWS)
def test_derivatives_of_laws(name):
    """Slopes and bends are differences of values and slopes, also turns away and over corners of the law."""
    rule = law(name)
    angles = np.random.default_rng(1).uniform(-20.0, 20.0, 200)
    apart = np.abs((angles[:, None] - rule.corners + np.pi) % (2 * np.pi) - np.pi).min(axis=1) > 2 * EPS
    angles = angles[apart]
    (value, slope, bend), before, after = rule(angles), rule(angles - EPS), rule(angles + EPS)
    np.testing.assert_allclose((after[0] - before[0]) / (2 * EPS), slope, atol=1e-10)
    np.testing.assert_allclose((after[1] - before[1]) / (2 * EPS), bend, atol=1e-8)
    np.testing.assert_allclose(rule(angles + 6 * np.pi)[0], value, atol=1e-15)
    assert all(rule(np.array([angle]))[1][0] == 0.0 for angle in (RISE, 2.0, DWELL, 5.0))  # exactly, in the dwells


def test_laws_at_a_share():
    """s, v and a of a stroke of 1 in a time of 1, at 0.3."""
    printed = {
        "3-4-5": (0.16308, 1.323, 5.04),
        "sine": (0.148634654272, 1.309016994375, 5.975664329483),
        "modified sine": (0.177887762629, 1.322954206934, 4.108072692436),
    }
    for name, values in printed.items():
        found = np.array([each[0] for each in law(name, 1.0)(np.array([0.3 * RISE]))])
        assert found * [1.0, RISE, RISE**2] == pytest.approx(values, rel=1e-11)


def test_tables_of_lifts():
    """A periodic spline, and rows with derivatives: both come back to a harmonic lift, at knots and between them."""
    knots, between = np.radians(np.arange(0.0, 360.0, 5.0)), np.linspace(-7.0, 9.0, 333)
    values = np.array([1.0 - np.cos(between), np.sin(between), np.cos(between)])
    rows = tuple(CamPoint(angle, 1.0 - np.cos(angle), "", np.sin(angle), np.cos(angle)) for angle in knots)
    np.testing.assert_allclose(CamLaw(rows, tabulated=True)(between), values, atol=2e-6)
    spline = CamLaw(tuple(row._replace(slope=None, bend=None) for row in rows), tabulated=True)
    np.testing.assert_allclose(spline(between), values, atol=1e-3)
    np.testing.assert_allclose(spline(knots)[0], [row.lift for row in rows], atol=1e-15)
    whole = CamLaw((*spline.points, spline.points[0]._replace(angle=2 * np.pi)), tabulated=True)
    np.testing.assert_allclose(whole(between), spline(between), atol=1e-14)


POINTS = law("3-4-5").points


@pytest.mark.parametrize(
    ("points", "tabulated", "problem"),
    [
        (POINTS[:1], False, "its law has 1 points"),
        (POINTS[::-1], False, "goes from 270 to 180 deg"),
        ((*POINTS, CamPoint(7.0, 0.0)), False, "goes over 401.07 deg"),
        ((POINTS[0]._replace(law="cubic"), *POINTS[1:]), False, "first point has the law 'cubic'"),
        ((POINTS[0], POINTS[1]._replace(law="cubik"), *POINTS[2:]), False, "did you mean 'cubic'"),
        (POINTS[:3], False, "not closed: the lift is 0.04 m at 180 deg, and 0 m where the next turn begins"),
        ((POINTS[0], CamPoint(2 * np.pi, 0.04, "sine")), False, "not closed: the lift is 0.04 m at 360 deg"),
        ((*POINTS[:3], POINTS[3]._replace(law="")), False, "speed jumps at 180 deg: 0 to -0.0254648 m/rad"),
        ((POINTS[0], CamPoint(1.0, 0.01), CamPoint(2.0, 0.03), CamPoint(4.0, 0.0, "sine")), False, "speed jumps at 0 deg: 0 to 0.01 m/rad"),
        ((*POINTS[:3], POINTS[3]._replace(slope=0.0)), True, "some rows of its table have slopes and bends"),
        ((CamPoint(0.0, 0.0), CamPoint(3.0, 0.1), CamPoint(2 * np.pi, 0.2)), True, "not closed"),
        (
            (CamPoint(0.0, 0.0, "", 0.1, 0.0), CamPoint(3.0, 0.1, "", 0.0, 0.0), CamPoint(2 * np.pi, 0.0, "", 0.2, 0.0)),
            True,
            "its last row, a turn after the first one, has another slope or bend",
        ),
    ],
)
def test_refused_laws(points, tabulated, problem):
    found = law_problem(points, tabulated, "m")
    assert found is not None
    assert problem in found[0]


def test_allowed_laws():
    assert law_problem(POINTS, False, "m") is None
    assert law_problem([point._replace(law="") for point in POINTS], True, "m") is None
    assert law_problem((CamPoint(0.0, 0.01), CamPoint(3.0, 0.01)), False, "m") is None  # a disc
