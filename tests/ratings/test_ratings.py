"""Ratings against closed forms of the crank-slider, brute force on inverse dynamics, and quadrature."""

import csv

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq
from support.exploring import examples
from support.texts import shipped

import pinpress as pp
from pinpress.loads.process import ConstantForce
from pinpress.ratings.limits import governing_names, largest_factor
from pinpress.ratings.permissible_force import Capacities
from pinpress.ratings.rating import rate

SPEED = 90 * pp.RPM
R, L = 0.1, 0.4  # crank_slide
LAM = R / L
SHIPPED = ("zxn2_3000b", "jf75g_125", "jf75g_125_symmetric", "jf75g_125_two_point", "thin_wall", "crank_slide")


def height(q):
    return R * (1 - np.cos(q)) + L * (1 - np.sqrt(1 - (LAM * np.sin(q)) ** 2))


def lever(q):
    """Zhang 2007 (4.2.9), corrected: M = F r (sin q + lam sin q cos q / A)."""
    return R * (np.sin(q) + LAM * np.sin(q) * np.cos(q) / np.sqrt(1 - (LAM * np.sin(q)) ** 2))


def angle_of(above):
    """Crank angle before bottom dead centre at a height, from the triangle of crank, rod and slide."""
    distance = L + R - above
    return np.arccos((distance**2 + R**2 - L**2) / (2 * R * distance))


def with_force(press, angle, speed, force, engine="auto"):
    """Reactions of a state with a process force, as a load on slide and frame."""
    motion = pp.servo_cycle(press, speed=speed, angle=np.atleast_1d(angle), engine=engine)
    loads = [ConstantForce(force, 1e3)] if force else []
    return pp.inverse_dynamics(press, motion, loads, engine=engine)


# The crank-slider in closed form


def test_torque_of_a_nominal_height():
    found = rate(shipped("crank_slide"), SPEED, Capacities(1e5, nominal_height=0.006), points=25)
    capacity = 1e5 * lever(angle_of(0.006))
    np.testing.assert_allclose(found.torque_capacity, capacity, rtol=1e-11)
    to_bottom = 2 * np.pi - found.crank_angle  # the crank falls from pi to 2 pi
    np.testing.assert_allclose(found.height, height(to_bottom), atol=1e-14)
    np.testing.assert_allclose(found.travel_per_angle, -lever(to_bottom), atol=1e-15)
    inside = slice(1, -1)  # at the dead centres no torque is needed
    np.testing.assert_allclose(found.force[inside], np.minimum(1e5, capacity / lever(to_bottom[inside])), rtol=1e-11)
    assert found.force[0] == found.force[-1] == 1e5
    at = int(np.abs(found.height - 0.006).argmin())
    assert abs(found.height[at] - 0.006) < 1e-15
    assert set(found.limited_by) == {"nominal force", "torque"}
    assert len(found.changes) == 2  # near the top the torque is enough for the nominal force again
    np.testing.assert_allclose(found.changes[1], 0.006, rtol=1e-12)
    np.testing.assert_allclose(lever(angle_of(found.changes[0])), lever(angle_of(0.006)), rtol=1e-9)


def test_a_given_torque_is_that_of_its_nominal_height():
    press = shipped("crank_slide")
    one = rate(press, SPEED, Capacities(1e5, nominal_height=0.006))
    other = rate(press, SPEED, Capacities(1e5, torque=one.torque_capacity))
    np.testing.assert_allclose(np.interp(one.crank_angle, other.crank_angle, other.force), one.force, rtol=1e-9)
    assert other.contact_height is None
    assert other.contact_speed is None
    assert other.contact_advantage is None


def test_stroke_speeds_and_dwell():
    found = rate(shipped("crank_slide"), SPEED, Capacities(1e5), contact_height=0.02, dwell_tolerance=0.003)
    np.testing.assert_allclose(found.stroke, 2 * R, rtol=1e-12)
    np.testing.assert_allclose(found.quick_return_ratio, 1.0, rtol=1e-12)
    np.testing.assert_allclose(found.contact_speed, SPEED * lever(angle_of(0.02)), rtol=1e-10)
    np.testing.assert_allclose(found.contact_advantage, 1 / lever(angle_of(0.02)), rtol=1e-10)
    np.testing.assert_allclose(found.dwell_time, 2 * angle_of(0.003) / SPEED, rtol=1e-10)
    np.testing.assert_allclose(found.slide_velocity, SPEED * found.travel_per_angle, rtol=1e-14)
    assert set(found.limited_by) == {"nominal force"}
    assert found.changes == ()
    assert found.speed_limit is None


def test_the_rod_of_the_crank_slide_limits_by_its_angle():
    """Static: the rod carries F / cos(phi), the guide F tan(phi), sin(phi) = lam sin(q); the largest rod force is where q is right."""
    capacity = 1e5 * 1.01
    found = rate(shipped("crank_slide"), SPEED, Capacities(1e5, bearings={"W": capacity, "slide_guide": 2e4}))
    sine = LAM * np.sin(found.crank_angle)
    np.testing.assert_allclose(found.limits["bearing W"], np.minimum(1e5, capacity * np.sqrt(1 - sine**2)), rtol=1e-11)
    with np.errstate(divide="ignore"):
        guide = 2e4 * np.sqrt(1 - sine**2) / np.abs(sine)
    np.testing.assert_allclose(found.limits["bearing slide_guide"], np.minimum(1e5, guide), rtol=1e-10)


def test_a_press_that_turns_backwards_works_on_the_other_side():
    press, capacities = shipped("zxn2_3000b"), Capacities(3e6, nominal_height=0.013, bearings={"B": 2.5e6})
    forwards, backwards = rate(press, SPEED, capacities), rate(press, -SPEED, capacities)
    assert np.all(np.diff(forwards.crank_angle) > 0)
    assert np.all(np.diff(backwards.crank_angle) < 0)
    for found in (forwards, backwards):
        assert np.all(np.diff(found.height) <= 0)  # a limit that begins at the nominal height may be there twice, but for rounding
        assert np.all(found.slide_velocity[1:-1] < 0)
    np.testing.assert_allclose(forwards.quick_return_ratio * backwards.quick_return_ratio, 1.0, rtol=1e-11)
    assert abs(forwards.torque_capacity / backwards.torque_capacity - 1) > 0.01  # the six-bar is not symmetric


@pytest.mark.parametrize("speed", [SPEED, -SPEED])
def test_travel_by_angle_is_the_slope_of_the_slide_over_the_crank(speed):
    press = shipped("zxn2_3000b")
    found = rate(press, speed, Capacities(3e6, nominal_height=0.013), points=31)
    step = 1e-5
    after, before = (pp.servo_cycle(press, speed=1.0, angle=found.crank_angle + way * step).slide_position for way in (1, -1))
    scale = np.abs(found.travel_per_angle).max()
    np.testing.assert_allclose(found.travel_per_angle, (after - before) / (2 * step), atol=1e-8 * scale)
    assert np.all(np.sign(found.travel_per_angle[1:-1]) == -np.sign(speed))  # the slide goes down
    np.testing.assert_allclose(found.slide_velocity, speed * found.travel_per_angle, rtol=1e-14)


@pytest.mark.parametrize("speed", [10.0, -10.0])
def test_an_overload_on_the_return_stroke_is_refused(speed):
    """There the idle thin-wall press, which returns quickly, loads pin C twice as much as on its working stroke."""
    press, ends = shipped("thin_wall"), pp.dead_centres(shipped("thin_wall"))
    motion = pp.servo_cycle(press, speed=speed, angle=np.copysign(1.0, speed) * np.linspace(0.0, 2 * np.pi, 3601))
    force = np.linalg.norm(pp.inverse_dynamics(press, motion).bearing_force["C"], axis=1)
    working = motion.slide_velocity < 0
    (low, at_low), (high, at_high) = sorted(
        (force[side].max(), motion.shown_position[side][force[side].argmax()]) for side in (working, ~working)
    )
    assert high > 1.5 * low
    with pytest.raises(pp.PinpressError, match="bearing 'C' of the idle press is") as refused:
        rate(press, speed, Capacities(1e5, bearings={"C": 0.99 * high}), at_speed=True)
    assert abs(float(str(refused.value).split("crank angle ")[1].split(" deg")[0]) - at_high) < 1.0
    assert abs(at_high - at_low) > 30.0
    assert rate(press, speed, Capacities(1e5, bearings={"C": 1.01 * high}), at_speed=True).stroke == pytest.approx(ends.stroke)


# Any press, by brute force


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["zxn2_3000b", "jf75g_125_symmetric", "thin_wall"])
def test_what_is_permissible_at_speed_is_just_kept(name):
    """Bisection on the reactions under an actual load: at the permissible force a capacity is reached, below it none is exceeded."""
    press = shipped(name)
    nominal = {"zxn2_3000b": 3e6, "jf75g_125_symmetric": 1.25e6, "thin_wall": 2e4}[name]
    speed = {"zxn2_3000b": 70, "jf75g_125_symmetric": 300, "thin_wall": 72}[name] * pp.RPM
    idle = pp.inverse_dynamics(press, pp.cycle(press, speed=speed))
    some = dict.fromkeys(press.bearings[:3], 1.2 * nominal) | {press.bearings[-1]: 0.7 * nominal}
    bearings = {b: c + 3 * np.linalg.norm(idle.bearing_force[b], axis=1).max() for b, c in some.items()}
    torque = 0.2 * nominal * pp.dead_centres(press).stroke + np.abs(idle.driving_torque).max()
    found = rate(press, speed, Capacities(nominal, torque=torque, bearings=bearings), at_speed=True, points=13)

    def excess(angle, force):
        result = with_force(press, angle, speed, force)
        shares = {"torque": abs(result.driving_torque[0]) / torque}
        shares |= {f"bearing {b}": np.linalg.norm(result.bearing_force[b][0]) / c for b, c in bearings.items()}
        worst = max(shares, key=shares.get)
        return shares[worst] - 1, worst

    assert len(set(found.limited_by)) > 1
    for angle, force, limit in zip(found.crank_angle, found.force, found.limited_by, strict=True):
        beyond, worst = excess(angle, nominal)
        if abs(beyond) < 1e-14:  # one limit gives way to another here, and rounding decides on which side the state is
            assert force == pytest.approx(nominal, rel=1e-14)
            assert limit in ("nominal force", worst)
            continue
        if beyond < 0:
            assert (force, limit) == (nominal, "nominal force")
            continue
        exact = brentq(lambda f, angle=angle: excess(angle, f)[0], 0.0, nominal, xtol=1e-6, rtol=1e-14)
        np.testing.assert_allclose(force, exact, rtol=1e-9)
        if not any(abs(h - found.height[found.crank_angle == angle][0]) < 1e-12 for h in found.changes):
            assert limit == excess(angle, exact * (1 + 1e-6))[1]


def test_the_nominal_height_is_listed_once():
    """Also where the crank's torque begins to govern there, which is found but for rounding."""
    found = rate(shipped("zxn2_3000b"), 70 * pp.RPM, Capacities(3e6, nominal_height=0.013), points=91)
    assert np.count_nonzero(np.isclose(found.height, 0.013, rtol=1e-9)) == 1


def test_of_limits_that_are_equal_but_for_rounding_the_first_governs():
    least = np.array([1e5, 2e5, np.inf])
    limits = {"nominal force": least, "torque": least * (1 - 1e-15), "bearing A": least - np.array([0.0, 1.0, 0.0])}
    assert governing_names(limits) == ("nominal force", "bearing A", "nominal force")


def test_where_thegoverning_names_limit_changes_two_permit_the_same():
    capacities = Capacities(3e6, nominal_height=0.013, bearings={"A": 1.2e6, "D": 4e6}, flywheel_inertia=6000, speed_drop=0.3)
    coarse, fine = (rate(shipped("zxn2_3000b"), 70 * pp.RPM, capacities, points=n) for n in (31, 301))
    assert len(coarse.changes) >= 2
    np.testing.assert_allclose(coarse.changes, fine.changes, rtol=1e-10)
    for change in coarse.changes:
        forces = np.sort([limit[coarse.height == change][0] for limit in coarse.limits.values()])
        np.testing.assert_allclose(forces[0], forces[1], rtol=1e-10)


def test_a_limit_that_governs_only_between_two_heights_is_named():
    # The flywheel's energy is that of 6.1 mm at nominal force; the torque, which is enough from 6 mm down, governs just above that.
    inertia = 2 * 1e5 * 0.0061 / (SPEED**2 * (1 - 0.9**2))
    capacities = Capacities(1e5, nominal_height=0.006, flywheel_inertia=inertia, speed_drop=0.1)
    coarse, fine = (rate(shipped("crank_slide"), SPEED, capacities, points=n) for n in (13, 2001))
    assert [coarse.limited_by[k] for k in np.flatnonzero(np.isin(coarse.height, coarse.changes))][-2:] == ["torque", "nominal force"]
    np.testing.assert_allclose(coarse.changes, fine.changes, rtol=1e-9)
    np.testing.assert_allclose([coarse.limits[name][k] for k, name in enumerate(coarse.limited_by)], coarse.force, rtol=1e-9)


@given(
    st.lists(st.floats(-1, 1), min_size=6, max_size=6),
    st.floats(1.0, 1e3),
)
@examples(50)
def test_the_largest_factor_reaches_the_capacity(numbers, scale):
    constant, slope = np.array(numbers[:3]) / 2, scale * np.array(numbers[3:])
    (factor,) = largest_factor(constant[None], slope[None], 1.0)
    if not np.isfinite(factor):
        assert np.abs(slope).max() < 1e-290
        return
    np.testing.assert_allclose(np.linalg.norm(constant + factor * slope), 1.0, rtol=1e-9)
    assert np.linalg.norm(constant + 0.999 * factor * slope) < 1
    assert np.linalg.norm(constant + 1.001 * factor * slope) > 1


def test_a_factor_that_nothing_limits_is_infinite():
    assert np.isinf(largest_factor(np.array([[0.5, 0.0]]), np.zeros((1, 2)), 1.0)).all()


# Energy


def test_energy_of_flywheel_and_motor():
    capacities = Capacities(1e5, nominal_height=0.006, flywheel_inertia=20.0, speed_drop=0.2, motor_power=500.0)
    found = rate(shipped("crank_slide"), SPEED, capacities)
    flywheel = 0.5 * 20.0 * (SPEED**2 - (0.8 * SPEED) ** 2)
    np.testing.assert_allclose(found.energies["flywheel energy"], flywheel, rtol=1e-13)
    np.testing.assert_allclose(found.energies["motor energy"], 500.0 / 1.5, rtol=1e-13)  # 90 strokes/min
    np.testing.assert_allclose(found.limits["flywheel energy"][:-1], np.minimum(1e5, flywheel / found.height[:-1]), rtol=1e-13)
    assert found.limits["flywheel energy"][-1] == 1e5
    assert {"flywheel energy", "motor energy"} & set(found.limited_by)


def test_work_of_the_torque_limited_force_is_torque_times_angle():
    """F ds = C dtheta where the torque governs; F_N h below the nominal height."""
    found = rate(shipped("crank_slide"), SPEED, Capacities(1e5, nominal_height=0.006), points=31)
    at = angle_of(0.006)
    top = brentq(lambda q: lever(q) - lever(at), 2.0, np.pi - 1e-3, xtol=1e-15)  # from which up the nominal force is permissible again
    q = 2 * np.pi - found.crank_angle
    torque = found.torque_capacity
    expected = np.where(q <= at, 1e5 * height(q), 1e5 * 0.006 + torque * (np.minimum(q, top) - at))
    expected += np.where(q > top, 1e5 * (height(q) - height(top)), 0.0)
    np.testing.assert_allclose(found.work, expected, rtol=1e-12, atol=1e-11)
    assert found.work[-1] == 0.0


@pytest.mark.one_in(3)
@pytest.mark.parametrize("points", [3, 31, 32])
def test_work_where_an_energy_governs_is_that_of_the_other_limits(points):
    """There the torque gives way to the nominal force between two heights of the table."""
    press = shipped("crank_slide")
    free = rate(press, SPEED, Capacities(1e5, nominal_height=0.006), points=points)
    little = Capacities(1e5, nominal_height=0.006, motor_power=20.0)
    found = rate(press, SPEED, little, points=points)
    assert "torque" not in found.limited_by
    at = angle_of(0.006)
    top = brentq(lambda q: lever(q) - lever(at), 2.0, np.pi - 1e-3, xtol=1e-15)
    expected = 1e5 * 0.006 + found.torque_capacity * (top - at) + 1e5 * (height(np.pi) - height(top))
    np.testing.assert_allclose([found.work[0], free.work[0]], expected, rtol=1e-12)


def test_work_by_adaptive_quadrature():
    press, capacities = shipped("thin_wall"), Capacities(2e4, torque=2500.0, bearings={"B": 2.2e4})
    found = rate(press, 7.54, capacities, at_speed=False, points=91)
    rates, torques, forces = {}, {}, {}

    def power(angle):
        motion = pp.servo_cycle(press, speed=1.0, angle=[angle])
        idle, loaded = (pp.inverse_dynamics(press, motion, [ConstantForce(f, 1e3)] if f else []) for f in (0.0, 1e6))
        rates[angle] = abs(motion.slide_velocity[0])
        torques[angle] = abs(loaded.driving_torque[0] - idle.driving_torque[0]) / 1e6
        forces[angle] = np.linalg.norm(loaded.bearing_force["B"][0] - idle.bearing_force["B"][0]) / 1e6
        return min(2e4, 2500.0 / torques[angle], 2.2e4 / forces[angle]) * rates[angle]

    corners = [found.crank_angle[found.height == change][0] for change in found.changes]
    expected, _ = quad(power, found.crank_angle[0], found.crank_angle[-1], points=corners, epsrel=1e-8, limit=60)
    np.testing.assert_allclose(found.work[0], expected, rtol=1e-7)


# Every press, both engines, what is written


@pytest.mark.one_in(6)
@pytest.mark.parametrize("at_speed", [False, True])
@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_press(name, at_speed):
    press = shipped(name)
    stroke = pp.dead_centres(press).stroke
    capacities = Capacities(1e6, nominal_height=stroke / 20, bearings={press.bearings[0]: 3e6}, flywheel_inertia=500.0, speed_drop=0.2)
    found = rate(press, 70 * pp.RPM, capacities, at_speed=at_speed, points=19)
    assert found.height[-1] == 0.0
    np.testing.assert_allclose(found.height[0], stroke, rtol=1e-12)
    np.testing.assert_allclose(found.force, np.min(list(found.limits.values()), axis=0), rtol=0)
    assert all(np.isfinite(limit).all() and (limit >= 0).all() for limit in found.limits.values())
    governing = [found.limits[name][k] for k, name in enumerate(found.limited_by)]
    np.testing.assert_allclose(governing, found.force, rtol=1e-9)  # where the limit changes, its beginning is known to rounding
    assert np.all(np.diff(found.work) <= 0)
    assert found.speed_limit is not None
    assert name in str(found)
    with pytest.raises(ValueError, match="read-only"):
        found.force[0] = 1.0


@pytest.mark.exhaustive
def test_both_engines_agree():
    press = shipped("crank_slide")
    capacities = Capacities(1e6, nominal_height=pp.dead_centres(press).stroke / 8, bearings=dict.fromkeys(press.bearings[::2], 2e6))
    one, other = (rate(press, 70 * pp.RPM, capacities, at_speed=True, points=3, engine=e) for e in ("plane", "pinocchio"))
    assert one.limited_by == other.limited_by
    np.testing.assert_allclose(one.force, other.force, rtol=1e-9)
    np.testing.assert_allclose(one.work, other.work, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(one.speed_limit.speed, other.speed_limit.speed, rtol=1e-9)


@pytest.mark.exhaustive
def test_columns_to_file_and_frame(tmp_path):
    found = rate(shipped("zxn2_3000b"), SPEED, Capacities(3e6, nominal_height=0.013), points=11)
    found.to_csv(tmp_path / "ratings.csv")
    with (tmp_path / "ratings.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["force [N]"]) for row in rows] == found.force.tolist()
    assert [row["limited_by"] for row in rows] == list(found.limited_by)
    assert [float(row["torque [N]"]) for row in rows] == found.limits["torque"].tolist()
    pytest.importorskip("pandas")
    assert found.to_frame()["height [m]"].tolist() == found.height.tolist()


# Bad input


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"speed": 0.0}, "speed is 0.0"),
        ({"speed": np.inf}, "speed is inf"),
        ({"speed": [1.0]}, "speed is"),
        ({"capacities": 3e6}, "capacities is a float"),
        ({"at_speed": 1}, "at_speed is 1"),
        ({"points": 2}, "points is 2"),
        ({"points": 10.5}, "points is 10.5"),
        ({"engine": "cad"}, "unknown engine"),
        ({"contact_height": 0.5}, "between 0 and the stroke"),
        ({"dwell_tolerance": -1.0}, "dwell_tolerance is -1.0"),
        ({"capacities": Capacities(1e5, bearings={"X": 1.0})}, "no bearing 'X'"),
        ({"capacities": Capacities(1e5, nominal_height=0.2)}, "nominal_height is 0.2"),
        ({"press": "crank_slide"}, "press is a str"),
    ],
)
def test_bad_arguments(changed, words):
    given = {"press": shipped("crank_slide"), "speed": SPEED, "capacities": Capacities(1e5)} | changed
    with pytest.raises(pp.PinpressError, match=words):
        rate(**given)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"nominal_force": 0.0}, "nominal_force is 0.0"),
        ({"nominal_force": None}, "nominal_force is None"),
        ({"nominal_force": 1.0, "torque": np.nan}, "torque is nan"),
        ({"nominal_force": 1.0, "torque": True}, "torque is True"),
        ({"nominal_force": 1.0, "torque": 1.0, "nominal_height": 0.1}, "leave one out"),
        ({"nominal_force": 1.0, "bearings": {"A": -1.0}}, "bearing 'A' is -1.0"),
        ({"nominal_force": 1.0, "bearings": ["A"]}, "mapping"),
        ({"nominal_force": 1.0, "flywheel_inertia": 1.0}, "flywheel_inertia and speed_drop: give both"),
        ({"nominal_force": 1.0, "speed_drop": 0.2}, "flywheel_inertia and speed_drop: give both"),
        ({"nominal_force": 1.0, "flywheel_inertia": 1.0, "speed_drop": 1.2}, "speed_drop is 1.2"),
    ],
)
def test_bad_capacities(given, words):
    with pytest.raises(pp.PinpressError, match=words):
        Capacities(**given)


def test_an_idle_press_beyond_a_capacity_is_named():
    """By inertia at its speed; the same press at rest bears its weight."""
    press = shipped("crank_slide")
    idle = pp.inverse_dynamics(press, pp.cycle(press, speed=300 * pp.RPM, points=3600))
    peak = np.linalg.norm(idle.bearing_force["W"], axis=1)
    capacities = Capacities(1e5, bearings={"W": 0.9 * peak.max()})
    words = (
        rf"bearing 'W' of the idle press is .* at crank angle {np.degrees(idle.motion.crank_angle[peak.argmax()]):.0f} deg and 300 r/min"
    )
    with pytest.raises(pp.PinpressError, match=words):
        rate(press, 300 * pp.RPM, capacities, at_speed=True)
    assert rate(press, 300 * pp.RPM, capacities).speed_limit.strokes_per_minute < 300
    torque = np.abs(idle.driving_torque).max()
    with pytest.raises(pp.PinpressError, match="driving torque of the idle press"):
        rate(press, 300 * pp.RPM, Capacities(1e5, torque=0.9 * torque), at_speed=True)


def test_utilisation_by_a_press_of_the_same_name():
    """A press of other lengths that a table gives the same name: its stroke, or its way, is not the one that was rated."""
    found = rate(shipped("crank_slide"), SPEED, Capacities(1e5, torque=1e4))
    shorter = pp.derivatives.reshaped(shipped("crank_slide"), {("P", "crank"): (0.09, 0.0, 0.0)})
    assert shorter.name == found.press_name
    reactions = pp.inverse_dynamics(shorter, pp.cycle(shorter, SPEED, points=8), [ConstantForce(5e4, 0.1)])
    with pytest.raises(pp.PinpressError, match="it is one of other lengths"):
        found.utilisation(reactions)
    longer = pp.derivatives.reshaped(shipped("crank_slide"), {("W", "rod"): (0.45, 0.0, 0.0)})
    assert pp.dead_centres(longer).stroke == pytest.approx(0.2)
    reactions = pp.inverse_dynamics(longer, pp.cycle(longer, SPEED, points=8), [ConstantForce(5e4, 0.1)])
    with pytest.raises(pp.PinpressError, match="it is one of other lengths"):
        found.utilisation(reactions)
