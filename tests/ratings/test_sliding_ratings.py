"""Ratings of presses whose driver slides, against virtual work at a toggle and against a cylinder that is the slide's own guide."""

import csv

import numpy as np
import pytest
from scipy.integrate import quad
from support import texts
from support.presses import sliding_presses
from support.presses.sliding_presses import NUT, TOGGLE, UPPER

import pinpress as pp
from pinpress.cli.main import main
from pinpress.loads.process import ConstantForce
from pinpress.pin_table.templates import template
from pinpress.ratings.permissible_force import Capacities
from pinpress.ratings.rating import rate

FROM, TO = -0.15, 0.09  # travel of the screw [m]
RAM = """<robot name="ram"><link name="frame"/>
<link name="slide"><inertial><mass value="100"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="cylinder" type="prismatic"><parent link="frame"/><child link="slide"/><axis xyz="0 0 1"/>
  <limit lower="-0.2" upper="0.3" effort="1e6" velocity="1"/></joint>
<transmission name="drive"><joint name="cylinder"/></transmission></robot>"""


@pytest.fixture(scope="module")
def toggle():
    return texts.load(TOGGLE)


@pytest.fixture(scope="module")
def ram():
    return texts.load(RAM)


def slope(travel):
    """Travel of the slide by that of the screw, the derivative of `sliding_presses.slide_position`."""
    beside = travel - NUT
    return 2 * beside / np.sqrt(UPPER**2 - beside**2)


def place_at(height):
    """Position of the screw where the slide is at a height above its lowest place, from the right triangle of a link."""
    hanging = -(sliding_presses.slide_position(TO) + height) / 2
    return NUT - np.sqrt(UPPER**2 - hanging**2)


def harmonic(travel, highest):
    """Speed and acceleration of the screw at places on its way down, by the phase of the harmonic motion."""
    middle, half = (FROM + TO) / 2, (TO - FROM) / 2
    phase, frequency = np.arccos((middle - travel) / half), highest / half
    return highest * np.sin(phase), half * frequency**2 * np.cos(phase)


def test_a_toggle_permits_what_virtual_work_says(toggle, engine):
    given = Capacities(4e5, nominal_height=0.02, bearings={"U": 4.5e5})
    found = rate(toggle, 0.1, given, points=21, contact_height=0.03, engine=engine)
    capacity = 4e5 * abs(slope(place_at(0.02)))
    np.testing.assert_allclose(found.torque_capacity, capacity, rtol=1e-9)
    travel = found.crank_angle
    assert (travel[0], travel[-1]) == (FROM, TO)
    np.testing.assert_allclose(found.height, sliding_presses.slide_position(travel) - sliding_presses.slide_position(TO), atol=1e-13)
    np.testing.assert_allclose(found.travel_per_angle, slope(travel), rtol=1e-9)
    upright = np.sqrt(1 - ((travel - NUT) / UPPER) ** 2)  # the upper link bears the process force along itself
    np.testing.assert_allclose(found.limits["driving force"], np.minimum(4e5, capacity / np.abs(slope(travel))), rtol=1e-9)
    np.testing.assert_allclose(found.limits["bearing U"], np.minimum(4e5, 4.5e5 * upright), rtol=1e-9)
    np.testing.assert_allclose(found.force, np.min(list(found.limits.values()), axis=0), rtol=1e-15)
    np.testing.assert_allclose(found.changes, [0.02], rtol=1e-9)
    np.testing.assert_allclose(found.slide_velocity, slope(travel) * harmonic(travel, 0.1)[0], atol=1e-9)
    work, _ = quad(lambda x: min(4e5 * abs(slope(x)), capacity), FROM, TO, points=[place_at(0.02)], epsabs=1e-6)
    np.testing.assert_allclose(found.work[0], work, rtol=1e-6)
    contact = place_at(0.03)
    np.testing.assert_allclose(found.contact_speed, abs(slope(contact)) * harmonic(contact, 0.1)[0], rtol=1e-9)
    np.testing.assert_allclose(found.contact_advantage, 1 / abs(slope(contact)), rtol=1e-9)
    assert found.stroke == pytest.approx(found.height[0], rel=1e-12)
    assert [found.quick_return_ratio, found.dwell_time, found.dwell_tolerance, found.speed_limit] == [None] * 4


@pytest.mark.parametrize("way", [1, -1])
def test_at_speed_the_permissible_force_uses_up_the_driver(toggle, way):
    """The way back is the same: a negative speed, which begins at the upper limit, changes nothing."""
    found = rate(toggle, way * 0.8, Capacities(4e5, torque=1e5), at_speed=True, points=9)
    travel = found.crank_angle
    governs = np.array(found.limited_by) == "driving force"
    assert governs.sum() > 5
    assert found.speed == 0.8
    assert np.all(found.slide_velocity[1:-1] < 0)
    speed, acceleration = harmonic(travel, 0.8)
    for k in np.flatnonzero(governs):
        motion = pp.servo_cycle(toggle, travel[k : k + 1], speed=speed[k : k + 1], acceleration=acceleration[k : k + 1])
        taken = pp.inverse_dynamics(toggle, motion, [ConstantForce(found.force[k], 0.3)])
        np.testing.assert_allclose(np.abs(taken.driving_torque), 1e5, rtol=1e-8)
    at_rest = rate(toggle, 0.8, Capacities(4e5, torque=1e5), points=9)
    assert np.all(np.abs(np.interp(travel[:5], at_rest.crank_angle, at_rest.force) / found.force[:5] - 1) > 1e-3)


def test_a_cylinder_in_line_with_the_slide_gives_it_its_force(ram):
    found = rate(ram, 0.1, Capacities(4e5, torque=3e5, bearings={"cylinder": 3e5}), points=7)  # its bearing force has that of the drive
    np.testing.assert_allclose(found.force, 3e5, rtol=1e-12)
    assert set(found.limited_by) == {"driving force"}
    np.testing.assert_allclose(found.height, np.linspace(0.5, 0.0, 7), atol=1e-14)  # the driver goes from its upper limit to its lower one
    np.testing.assert_allclose(found.travel_per_angle, 1.0, rtol=1e-14)
    np.testing.assert_allclose(found.work, 3e5 * found.height, atol=1e-9)
    loaded = rate(ram, 0.1, Capacities(4e5, torque=3e5), points=3, at_speed=True)
    inertia = 100 * 0.1**2 / 0.25  # at the ends of the travel the slide is accelerated towards the middle
    np.testing.assert_allclose(loaded.force[[0, 1, 2]], 3e5 + 100 * 9.81 + np.array([-1, 0, 1]) * inertia, rtol=1e-6)


@pytest.mark.parametrize("given", [{"torque": 4e5}, {"nominal_height": 0.1}])
def test_limits_that_are_equal_at_every_height_do_not_take_turns(ram, given):
    found = rate(ram, 0.1, Capacities(4e5, **given), points=31)
    assert set(found.limited_by) == {"nominal force"}
    assert found.changes == ()


def test_limits_that_differ_by_rounding_do_not_take_turns(tmp_path):
    """All pins of a cylinder between two of them bear its force."""
    (tmp_path / "toggle.yaml").write_bytes(template("toggle"))
    bearings = dict.fromkeys(("cylinder", "G", "K_piston"), 3e5)
    found = rate(pp.build(tmp_path / "toggle.yaml"), 0.05, Capacities(1e6, torque=3e5, bearings=bearings), points=31)
    assert set(found.limited_by) == {"driving force", "nominal force"}
    assert len(found.changes) == 1


def test_the_use_of_what_is_permissible(toggle):
    found = rate(toggle, 0.1, Capacities(4e5, torque=1e5), points=721)
    motion = pp.cycle(toggle, 0.1)
    used = found.utilisation(pp.inverse_dynamics(toggle, motion, [ConstantForce(5e4, 0.1)]))
    down = (motion.slide_velocity < 0) & (motion.slide_position - sliding_presses.slide_position(TO) < 0.1)
    permitted = np.minimum(4e5, 1e5 / np.abs(slope(motion.crank_angle[down])))
    np.testing.assert_allclose(used[down], 5e4 / permitted, rtol=1e-3)  # interpolated between heights


@pytest.mark.parametrize(
    ("given", "changed", "words"),
    [
        (
            {"flywheel_inertia": 1.0, "speed_drop": 0.1},
            {},
            "slides to and fro: ratings take flywheel_inertia and speed_drop of a crank alone",
        ),
        ({"motor_power": 1e3}, {}, "motor_power of a crank alone; instead, compare the power"),
        ({"slide_acceleration": 1.0}, {}, "slide_acceleration of a crank alone"),
        ({"shaking_force": 1.0}, {}, "shaking_force of a crank alone"),
        ({}, {"dwell_tolerance": 1e-3}, "dwell_tolerance of a crank alone"),
        ({}, {"speed": 0.0}, r"not zero \[m/s\], e.g. 0.1"),
        ({}, {"contact_height": 0.5}, "contact_height is 0.5: give a height between 0 and the stroke"),
        ({"nominal_height": 0.5}, {}, "nominal_height is 0.5: give a height between 0 and the stroke"),
        (
            {"torque": 100.0},
            {"at_speed": True},
            r"the driving force of the idle press is .* N at driver position .* mm and a highest speed of 100",
        ),
    ],
)
def test_what_does_not_fit_a_driver_that_slides_is_refused_by_name(toggle, given, changed, words):
    arguments = {"speed": 0.1, "capacities": Capacities(1e5, **given)} | changed
    with pytest.raises(pp.PinpressError, match=words):
        rate(toggle, **arguments)


def test_a_slide_that_turns_back_within_the_travel_has_no_one_working_stroke(tmp_path):
    path = tmp_path / "toggle.urdf"
    path.write_text(TOGGLE.replace('upper="0.09"', 'upper="0.17"'))
    with pytest.raises(pp.PinpressError, match=r"turns back while its driver goes from -150 mm to 170 mm, .*bottom dead centre: 100 mm"):
        rate(pp.load(path), 0.1, Capacities(1e5))
    path.write_text(TOGGLE.replace('upper="0.09"', f'upper="{NUT}"'))
    assert rate(pp.load(path), 0.1, Capacities(1e5, torque=1e4), points=5).force[-1] == 1e5  # straight: the screw is not loaded


@pytest.mark.exhaustive
def test_the_command_prints_forces_and_millimetres(toggle, tmp_path, capsys):
    words = ["analyse", toggle.document.file, "--speed", "100mm/s", "--load", "drawing:force=50kN,start=40mm", "--set", "points=9"]
    capacities = ["--set", "capacities.nominal_force=400kN", "--set"]
    assert main([*words, *capacities, "capacities.torque=100kN", "--out", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    ratings = out.partition("PressRatings")[2]
    for said in (
        "At up to 100 mm/s of the driver",
        "driving force capacity                    100.00 kN",
        "driver position [mm]",
        "driving force per force",
    ):
        assert said in ratings
    for silent in ("N m", "rad", "strokes/min", "quick return", "dwell", "r/min", "None"):
        assert silent not in ratings
    with (tmp_path / "ratings.csv").open(encoding="utf-8", newline="") as file:
        columns = next(csv.reader(file))
    assert columns[1:3] == ["driver_position [m]", "travel_per_driver_travel [m/m]"]
    assert (tmp_path / "ratings.png").exists()
    assert main([*words, *capacities, "capacities.torque=100kNm"]) == 2
    assert "torque: '100kNm' is in 'kNm', which is none of N, kN" in capsys.readouterr().err


def test_friction_counts_up_to_the_ends_of_the_travel(toggle):
    """There the driver of a harmonic motion stands; friction is that of the way down, as just beside the end."""
    friction = {name: pp.loads.Friction(0.1, 0.05) for name in ("U", "K", "S")} | {"slide_guide": pp.loads.Friction(0.1)}
    given = {"at_speed": True, "points": 41}
    ideal = rate(toggle, 0.1, Capacities(4e5, torque=1e5), **given)
    found = rate(toggle, 0.1, Capacities(4e5, torque=1e5), friction=friction, **given)
    shares = np.interp(ideal.crank_angle, found.crank_angle, found.force) / ideal.force
    assert 0.5 < shares[0] < shares[1] < shares[2] < 0.999
    np.testing.assert_allclose(shares[0], 2 * shares[1] - shares[2], rtol=2e-3)
