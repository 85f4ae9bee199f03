"""Motions and forces of presses whose driver slides: `support.presses.sliding_presses`."""

import dataclasses

import numpy as np
import pytest
from support import texts
from support.presses import sliding_presses
from support.presses.sliding_presses import ARM, BELL, LOWER, NUT, RETRACTED, TOGGLE, UPPER, G, lever_angle, potential

import pinpress as pp
from pinpress.common.quantities import RAM


@pytest.fixture(scope="module")
def bell():
    return texts.load(BELL)


@pytest.fixture(scope="module")
def toggle():
    return texts.load(TOGGLE)


def test_a_cylinder_turns_a_bell_crank_by_the_law_of_cosines(bell):
    travel = np.linspace(-0.1, 0.15, 26)
    motion = pp.servo_cycle(bell, travel, speed=0.2, acceleration=0.5)
    lever = list(bell.joints).index("O")
    np.testing.assert_allclose(motion.joint_position[:, lever], lever_angle(travel), rtol=0, atol=1e-13)
    rate = (lever_angle(travel + 1e-5) - lever_angle(travel - 1e-5)) / 2e-5
    np.testing.assert_allclose(motion.v[:, lever], 0.2 * rate, rtol=1e-7)
    assert (bell.engines, bell.driver_coordinates) == (("plane", "space", "pinocchio"), (RAM,))


def test_the_force_of_a_resting_cylinder_is_the_slope_of_the_potential_energy(bell):
    travel = np.linspace(-0.09, 0.14, 12)
    forces = pp.inverse_dynamics(bell, pp.servo_cycle(bell, travel, speed=0.0, acceleration=0.0))
    slope = (potential(travel + 1e-5) - potential(travel - 1e-5)) / 2e-5
    np.testing.assert_allclose(forces.driving_torque, slope, rtol=1e-6)


def test_the_slide_of_a_toggle_goes_down_as_its_screw_straightens_it(toggle):
    travel = np.linspace(-0.15, 0.09, 13)
    motion = pp.servo_cycle(toggle, travel, speed=0.0, acceleration=0.0)
    np.testing.assert_allclose(motion.slide_position, sliding_presses.slide_position(travel), rtol=0, atol=1e-13)
    ends = pp.dead_centres(toggle)
    assert (ends.top_angle, ends.bottom_angle, ends.turns) == (-0.15, 0.09, 1)
    assert [*ends.columns()][:2] == ["top_angle [m]", "top_position [m]"]
    assert ends.stroke == pytest.approx(2 * np.sqrt(UPPER**2 - 0.01**2) - 2 * np.sqrt(UPPER**2 - 0.25**2), abs=1e-13)


def test_dead_centres_within_the_travel_are_found(tmp_path):
    path = tmp_path / "toggle.urdf"
    path.write_text(TOGGLE.replace('upper="0.09"', 'upper="0.17"'))
    press = pp.load(path)
    ends = pp.dead_centres(press)  # through the straight toggle and on: the travel ends beyond bottom dead centre
    assert ends.bottom_angle == pytest.approx(NUT, abs=1e-12)
    assert ends.bottom_position == pytest.approx(-UPPER - LOWER, abs=1e-13)


@pytest.mark.parametrize("coefficient", [0.0, 0.08])
def test_both_engines_agree_on_a_driver_that_slides(toggle, bell, coefficient):
    pressing = [pp.loads.DeepDrawing(force=1e5, start=0.02)]
    spring = pp.loads.SpringDamper("frame", "lever", stiffness=1e4, free_length=0.4, point1=(-0.6, 0, 0), point2=(0, 0, 0.2))
    for press, loads in ((toggle, pressing), (bell, [spring])):
        motion, guides = pp.cycle(press, 0.4, points=24), ("cylinder", "screw", "slot", "slide_guide")
        friction = {
            name: pp.loads.Friction(coefficient, radius=None if name in guides else 0.03, viscous=10.0 * coefficient)
            for name in press.bearings
        }
        plane, space = (pp.inverse_dynamics(press, motion, loads=loads, friction=friction, engine=name) for name in ("plane", "pinocchio"))
        scale = max(np.abs(force).max() for force in space.bearing_force.values())
        np.testing.assert_allclose(plane.driving_torque, space.driving_torque, rtol=0, atol=1e-12 * scale)
        for name in press.bearings:
            np.testing.assert_allclose(plane.bearing_force[name], space.bearing_force[name], rtol=0, atol=1e-12 * scale)
            np.testing.assert_allclose(plane.bearing_moment[name], space.bearing_moment[name], rtol=0, atol=1e-12 * scale)
        assert np.abs(plane.power_residual).max() < 1e-12


def test_a_cycle_goes_there_and_back_between_the_limits(bell):
    motion = pp.cycle(bell, 0.2, points=100)
    assert (motion.crank_angle[0], motion.crank_angle[50]) == (-0.1, 0.15)
    assert motion.crank_speed[25] == pytest.approx(0.2)
    assert motion.time[1] * 100 == pytest.approx(np.pi * 0.25 / 0.2)
    derived = pp.servo_cycle(bell, motion.crank_angle, time=motion.time, period=100 * motion.time[1])
    np.testing.assert_allclose(derived.crank_speed, motion.crank_speed, rtol=0, atol=1e-13)
    np.testing.assert_allclose(derived.crank_acceleration, motion.crank_acceleration, rtol=0, atol=1e-11)
    back = pp.cycle(bell, -0.2, points=100)
    np.testing.assert_allclose(back.crank_angle, np.roll(motion.crank_angle, 50), rtol=0, atol=1e-15)


def test_columns_and_words_are_those_of_a_travel(bell):
    motion = pp.cycle(bell, 0.2, points=8)
    assert list(motion.columns())[:4] == ["time [s]", "driver_position [m]", "driver_speed [m/s]", "driver_acceleration [m/s2]"]
    assert "driving_force [N]" in pp.inverse_dynamics(bell, motion).columns()
    assert motion.title == "Motion of bell_crank: 8 states, driver at -100 to 150 mm"
    assert motion.place(4) == "driver position 150 mm"
    np.testing.assert_allclose(motion.shown_position, 1e3 * motion.crank_angle)
    with pytest.warns(pp.PinpressWarning, match="speed is 200 m/s: if 200 mm/s are meant, write 200e-3"):
        pp.cycle(bell, 200.0, points=4)


def test_heights_over_time_give_the_positions_of_the_driver(toggle):
    time = np.linspace(0.0, 1.0, 41)
    heights = 0.05 * (1 + np.cos(np.pi * time)) / 2 + 0.001
    motion = pp.servo_cycle(toggle, height=heights, time=time)
    np.testing.assert_allclose(motion.slide_position - pp.dead_centres(toggle).bottom_position, heights, rtol=0, atol=1e-13)


def test_a_lock_before_the_limits_is_said_in_millimetres(tmp_path):
    path = tmp_path / "bell.urdf"
    path.write_text(BELL.replace('upper="0.15"', 'upper="0.9"'))  # it is stretched at OG + OK = 0.883, 0.383 from the drawn pose
    with pytest.raises(
        pp.SingularityError, match=r"the driver slides only from -100 to 383\.\d* mm; .* \(driver position 383\.\d* mm"
    ) as caught:
        pp.cycle(pp.load(path), 0.1)
    assert caught.value.crank_angle == pytest.approx(np.linalg.norm(G) + ARM - RETRACTED, abs=1e-4)


def test_a_changed_press_keeps_its_travel(bell):
    heavier = bell.with_inertias(bell.model.inertias)
    assert heavier.branch is bell.branch
    model = bell.model.copy()
    model.upperPositionLimit[bell.slots[bell.driver_indices[0]].start] = 0.05
    assert dataclasses.replace(bell, model=model).branch.angles[-1] == 0.05
