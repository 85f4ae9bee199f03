"""Runs of presses whose driver slides: all methods alike, against closed forms, and what such a driver cannot have."""

import json

import numpy as np
import pytest
from support import texts
from support.in_browser import data_in
from support.presses import sliding_presses

import pinpress as pp
from pinpress.drives import Brake, Clutch, ConstantTorque, Flywheel, Geared, InductionMotor, PrescribedSpeed, ServoMotor, SwitchPoint
from pinpress.engines.energies import energies

LEAD = 0.02  # of the screw [m a turn]


@pytest.fixture(scope="module")
def bell():
    return texts.load(sliding_presses.BELL)


@pytest.fixture(scope="module")
def toggle():
    return texts.load(sliding_presses.TOGGLE)


def test_a_slide_alone_falls_freely(tmp_path):
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    path = tmp_path / "ram.urdf"
    path.write_text(
        '<robot name="ram"><link name="frame"/><link name="slide"><inertial><mass value="3"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link><joint name="ram" type="prismatic">'
        f'<parent link="frame"/><child link="slide"/><axis xyz="0 0 1"/>{limit}</joint>'
        '<transmission name="drive"><joint name="ram"/></transmission></robot>'
    )
    run = pp.simulate(pp.load(path), 0.3, drive=ConstantTorque(6.0), speed=0.5)
    np.testing.assert_allclose(run.crank_angle, 0.5 * run.time + 0.5 * (2.0 - 9.81) * run.time**2, rtol=0, atol=1e-13)


@pytest.mark.parametrize("method", ["reduced", "implicit", "constraint"])
def test_methods_agree_and_energy_balances(bell, method):
    run = pp.simulate(bell, 0.2, drive=ConstantTorque(-200.0), speed=0.1, method=method, points=9)
    travel = run.crank_angle
    lever = (sliding_presses.lever_angle(travel + 1e-6) - sliding_presses.lever_angle(travel - 1e-6)) / 2e-6 * run.crank_speed
    np.testing.assert_allclose(run.v[:, bell.joints.index("O")], lever, rtol=1e-7)
    works = -200.0 * (travel - travel[0])
    kinetic = energies(bell.engine(), run.states(bell)).kinetic
    lifted = sliding_presses.potential(travel) - sliding_presses.potential(travel[:1])
    np.testing.assert_allclose(kinetic - kinetic[0] + lifted, works, rtol=0, atol=2e-9 * np.abs(works).max())
    assert run.crank_angle[-1] == pytest.approx(0.0445, abs=0.03)
    assert list(run.columns())[-4:-2] == ["drive_force [N]", "drive_speed [m/s]"]


@pytest.mark.exhaustive
def test_a_screw_turns_a_motor_into_a_force(bell):
    motor = ServoMotor(times=[0, 1.0], angles=[0, 6 * np.pi], stiffness=200.0, damping=2.0, peak_torque=50.0, inertia=0.002)
    geared = Geared(motor, ratio=2 * np.pi / LEAD)
    run = pp.simulate(bell, 1.5, drive=geared, points=31)
    assert run.crank_angle[-1] == pytest.approx(3 * LEAD, rel=1e-3)
    held = pp.inverse_dynamics(bell, pp.servo_cycle(bell, run.crank_angle[-1:], speed=0.0, acceleration=0.0)).driving_torque
    assert run.drive_torque[-1] == pytest.approx(float(held[0]), rel=1e-4)
    again = pp.simulate(bell, 1.5, drive=geared, points=31, method="constraint")
    np.testing.assert_allclose(again.crank_angle, run.crank_angle, rtol=0, atol=1e-9)
    duty = pp.measures.duty_cycle(run)
    assert (duty.units["highest_speed"], duty.units["motor_rms"]) == ("m/s", "N m")
    assert len(pp.measures.stroke_duties(run)) == 0


def test_a_press_that_deep_draws_by_its_screw(toggle):
    loads = [pp.loads.DeepDrawing(force=5e4, start=0.03)]
    run = pp.simulate(toggle, 0.5, angle=-0.12, drive=PrescribedSpeed(0.4), loads=loads, points=41)
    forces = pp.inverse_dynamics(toggle, run, loads=loads)
    assert np.abs(forces.power_residual).max() < 1e-12
    assert run.drive_work[-1] == pytest.approx(np.trapezoid(forces.driving_torque * 0.4, run.time), rel=0.05)


@pytest.mark.parametrize("method", ["reduced", "implicit", "constraint"])
def test_a_driver_at_its_end_is_said_in_millimetres(bell, method):
    with pytest.raises(pp.SimulationError, match=r"the driver slides only from -100 to 150 mm, .*, driver position 1[5-9]\d") as caught:
        pp.simulate(bell, 2.0, drive=ConstantTorque(-200.0), method=method)
    assert caught.value.reason == "runs against an end"
    assert 0.15 <= caught.value.crank_angle < 0.2


@pytest.mark.parametrize(
    ("part", "word"),
    [
        ({"flywheel": Flywheel(1.0)}, "Flywheel needs a shaft: give what turns behind a screw to its motor"),
        ({"drive": InductionMotor(rated_power=7e3, rated_speed=150.0, inertia=0.1)}, "InductionMotor needs a shaft: let it act through"),
        ({"brake": Brake(torque=1e3, closes=SwitchPoint(time=0.1))}, "Brake needs a shaft"),
        ({"drive": ConstantTorque(1.0), "clutch": Clutch(torque=1e3, closes=SwitchPoint(time=0.1))}, "Clutch needs a shaft"),
    ],
)
def test_what_needs_a_shaft_is_refused_by_name(bell, part, word):
    with pytest.raises(pp.PinpressError, match=f"driver 'cylinder' slides, but {word}"):
        pp.simulate(bell, 0.1, **part)


def test_what_belongs_to_cranks_is_refused_by_name(toggle, bell):
    slides = "driver 'screw' of screw_toggle slides to and fro: "
    with pytest.raises(pp.PinpressError, match=f"{slides}it has no steady state"):
        pp.steady_state(toggle, 0.1, drive=ConstantTorque(1.0))
    with pytest.raises(pp.PinpressError, match=f"{slides}a speed limit needs a crank"):
        pp.ratings.speed_limit(toggle, pp.ratings.Capacities(1e6, torque=1e5))
    with pytest.raises(pp.PinpressError, match=f"{slides}operating points need a crank"):
        pp.sweeps.operating_points(toggle, [0.1])
    with pytest.raises(pp.PinpressError, match=f"{slides}flywheels and their energy are those of a crank"):
        pp.measures.driving_energy(pp.inverse_dynamics(toggle, pp.cycle(toggle, 0.1)))
    with pytest.raises(pp.PinpressError, match=f"{slides}scenarios are those of a crank"):
        pp.simulate_batch(toggle, 0.1, speed=[0.1, 0.2])
    with pytest.raises(pp.PinpressError, match="the driver of the motion slides to and fro, and measures are those of a crank"):
        pp.measures.stroke(pp.cycle(toggle, 0.1))


def test_summaries_and_extremes_are_in_millimetres(toggle):
    reactions = pp.inverse_dynamics(toggle, pp.cycle(toggle, 0.1, points=60))
    text = str(reactions)
    assert "deg" not in text
    assert "screw slides there and back, harmonically, at up to 100 mm/s" in text
    found = {each.quantity: each for each in pp.measures.extremes(reactions)}
    assert found["driver speed"].largest == pytest.approx(100.0, rel=1e-3)
    assert (found["driving force"].unit, found["driving force"].units["largest_at"]) == ("N", "mm")
    assert pp.measures.harmonics(reactions.motion, reactions.shaking_force) is None


@pytest.mark.exhaustive
def test_pages_and_pictures(toggle, tmp_path):
    reactions = pp.inverse_dynamics(toggle, pp.cycle(toggle, 0.1, points=30))
    data = data_in(pp.report(toggle, reactions.motion, tmp_path / "press.html", reactions=reactions))
    assert data["driver"] == {"name": "driver", "unit": " mm"}
    assert all(words in json.dumps(data) for words in ("Driving force", "at [mm]", "largest force"))
    assert (len(data["time"]), data["crank"][0], data["crank"][-1]) == (31, -150.0, -150.0)  # closed to a loop
    one_way = pp.servo_cycle(toggle, np.linspace(-0.1, 0.05, 9), speed=0.1)
    data = data_in(pp.report(toggle, one_way, tmp_path / "way.html"))
    assert "driver position" in json.dumps(data)
    assert len(data["time"]) == 9
    pp.plots.draw(reactions, "driving_force", "polar")


def test_elastic_press_over_the_travel(toggle):
    stiffness = pp.elasticity.Stiffness({"U": 2e9, "K": 2e9, "S": 2e9})
    found = pp.elasticity.compliance(toggle, stiffness)
    assert (found.crank_angle[0], found.crank_angle[-1]) == (-0.15, 0.09)
    assert "driver_position [m]" in found.columns()
    at_end = 3 * 0.5e-9 / np.cos(np.arcsin(0.01 / 0.4)) ** 2  # the force in the links is larger than on the slide, and so is their way
    assert found.compliance[-1] == pytest.approx(at_end, rel=1e-3)


def test_derivatives_by_a_length_are_those_of_differences(toggle):
    motion = pp.cycle(toggle, 0.1, points=12)
    (found,) = pp.derivatives.motion_derivatives(toggle, motion, [{("S", "lower"): (0, 0, -1.0)}])
    longer, shorter = (pp.derivatives.reshaped(toggle, {("S", "lower"): (0, 0, -0.4 - step)}) for step in (1e-5, -1e-5))
    difference = (pp.cycle(longer, 0.1, points=12).slide_position - pp.cycle(shorter, 0.1, points=12).slide_position) / 2e-5
    np.testing.assert_allclose(found.slide_position, difference, rtol=0, atol=1e-8)
    assert "driver_position [m]" in found.columns()


def test_transmission_angles_over_the_travel(toggle, bell):
    (dyad,) = pp.measures.least_transmission_angles(bell)
    travel = np.linspace(-0.1, 0.15, 2001)
    lengths = 0.5 + travel, np.full(2001, 0.3), np.full(2001, np.hypot(0.5, 0.3))
    between = np.arccos((lengths[0] ** 2 + lengths[1] ** 2 - lengths[2] ** 2) / (2 * lengths[0] * lengths[1]))
    folded = np.minimum(between, np.pi - between)
    assert dyad.least_transmission_angle == pytest.approx(folded.min(), abs=1e-6)
    assert dyad.crank_angle == pytest.approx(travel[folded.argmin()], abs=1e-3)
    assert dyad.units["crank_angle"] == "m"
    assert "at driver [mm]" in str(pp.check(bell.file))
