"""The two peers against the published press's reference values, against mechanics in closed form, and against each other."""

import json
from pathlib import Path

import numpy as np
import pytest
from support.oracles import pinocchio_loop
from support.oracles import six_bar_script as hand_script
from support.oracles.six_bar_script import six_bar, world_forces

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "zxn2_3000b.json").read_text(encoding="utf-8"))
TABLE = REFERENCE["table"]
SPEED = 70 * 2 * np.pi / 60  # the reference's [rad/s]
KINEMATICS = {
    "y": "slide_position",
    "v": "slide_velocity",
    "a": "slide_acceleration",
    **{f"theta{i}": f"theta{i}" for i in (2, 3, 4)},
    **{f"w{i}": f"omega{i}" for i in (2, 3, 4)},
    **{f"al{i}": f"alpha{i}" for i in (2, 3, 4)},
}
# Angles over two turns and backwards, with speed (through zero) and acceleration of their own: nothing periodic to hide behind.
SERVO = (np.linspace(9.0, -4.0, 97), 8.0 * np.cos(np.linspace(0.0, 7.0, 97)), 30.0 * np.sin(np.linspace(1.0, 9.0, 97)))


def table_angles():
    return np.radians([row["theta1_deg"] for row in TABLE])


@pytest.mark.parametrize("name", KINEMATICS)
def test_kinematics_equal_the_reference_at_every_row(name):
    result = six_bar(table_angles(), SPEED, 0.0)
    np.testing.assert_allclose(result[KINEMATICS[name]], [row[name] for row in TABLE], rtol=1e-12, atol=0.0)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("balanced", "column"), [(False, "before"), (True, "after")])
@pytest.mark.parametrize("name", hand_script.UNKNOWNS)
def test_torque_and_forces_equal_the_reference_at_every_row(name, balanced, column):
    expected = np.array([row[column][name] for row in TABLE])
    error = six_bar(table_angles(), SPEED, 0.0, balanced)[name] - expected
    assert np.abs(error).max() < 1e-10 * np.abs(expected).max()


@pytest.mark.parametrize("name", ["TDC", "BDC"])
def test_the_slide_stands_still_at_the_reference_dead_centres(name):
    expected = REFERENCE["kinematic_extremes"]["dead_points"][name]
    result = six_bar(np.radians(expected["theta1_deg"]), SPEED, 0.0)
    assert abs(result["slide_velocity"][0]) < 1e-13
    np.testing.assert_allclose(result["slide_position"], expected["yF"], rtol=1e-12)
    np.testing.assert_allclose(result["slide_acceleration"], expected["a5"], rtol=1e-12)


def test_a_whole_turn_has_the_reference_extremes():
    extremes = REFERENCE["kinematic_extremes"]
    result = six_bar(np.linspace(0.0, 2 * np.pi, 20001), SPEED, 0.0)
    for name, largest, smallest in (
        ("slide_position", "y_max", "y_min"),
        ("slide_velocity", "v_up", "v_down"),
        ("slide_acceleration", "a_max", "a_min"),
    ):
        np.testing.assert_allclose(result[name].max(), extremes[largest][0], rtol=1e-7)
        np.testing.assert_allclose(result[name].min(), extremes[smallest][0], rtol=1e-7)
    rocker = np.degrees(result["theta3"])
    assert (round(rocker.min(), 2), round(rocker.max(), 2)) == (46.75, 91.71)


def test_both_loops_are_closed_at_every_angle():
    theta1 = np.linspace(-7.0, 20.0, 3001)
    result = six_bar(theta1, 0.0, 0.0)
    pin_c = 1.250 - 0.200j + 0.143 * np.exp(1j * theta1) + 1.243 * np.exp(1j * result["theta2"])
    pin_e = 0.480 * np.exp(1j * (result["theta3"] - 0.75 * np.pi))
    assert np.abs(pin_c - 0.375 * np.exp(1j * result["theta3"])).max() < 1e-14
    assert np.abs(pin_e + 0.480 * np.exp(1j * result["theta4"]) - 1j * result["slide_position"]).max() < 1e-14


@pytest.mark.parametrize(
    ("position", "rate", "second"),
    [("slide_position", "slide_velocity", "slide_acceleration")] + [(f"theta{i}", f"omega{i}", f"alpha{i}") for i in (2, 3, 4)],
)
def test_rates_are_the_spectral_derivatives_of_the_positions(position, rate, second):
    n = 256
    result = six_bar(2 * np.pi * np.arange(n) / n, SPEED, 0.0)
    order = 1j * SPEED * np.arange(n // 2 + 1)
    spectrum = np.fft.rfft(result[position])
    for power, name in ((1, rate), (2, second)):
        derivative = np.fft.irfft(spectrum * order**power, n)
        assert np.abs(result[name] - derivative).max() < 1e-9 * np.abs(derivative).max()


def bodies(theta1, omega1, alpha1, result, balanced):
    """(mass, inertia, turn rate, turn acceleration, velocity and acceleration of the centre of mass as x + iy) of every body."""
    mass, centre, inertia = (REFERENCE["parameters"][name]["after" if balanced else "before"] for name in ("mass", "com", "J_com"))
    mass, inertia, centre = ({k: float(v) for k, v in d.items()} for d in (mass, inertia, centre))

    def moved(arm, i):  # velocity and acceleration of the end of an arm (x + iy) that turns with body i
        w, al = (omega1, alpha1) if i == 1 else (result[f"omega{i}"], result[f"alpha{i}"])
        return np.array([1j * w * arm, (1j * al - w**2) * arm])

    e1, e2, e3, e4 = (np.exp(1j * angle) for angle in (theta1, result["theta2"], result["theta3"], result["theta4"]))
    pin_b, pin_e = moved(0.143 * e1, 1), moved(0.480 * e3 * np.exp(-0.75j * np.pi), 3)
    motions = {
        "1": moved(centre["p1"] * e1, 1),
        "2": pin_b + moved(centre["p2"] * e2, 2),
        "3": moved((centre["p3"] + 1j * centre["q3"]) * e3, 3),
        "4": pin_e + moved(centre["p4"] * e4, 4),
        "5": 1j * np.array([result["slide_velocity"], result["slide_acceleration"]]),
    }
    turns = {"1": (omega1, alpha1), "5": (0.0, 0.0)} | {i: (result["omega" + i], result["alpha" + i]) for i in "234"}
    return [(mass[i], inertia.get(i, 0.0), *turns[i], *motions[i]) for i in "12345"]


@pytest.mark.parametrize("balanced", [False, True])
def test_input_power_is_the_rate_of_kinetic_and_potential_energy(balanced):
    result = six_bar(*SERVO, balanced=balanced)
    rate = 0.0
    for m, j, w, al, v, a in bodies(*SERVO, result, balanced):
        rate = rate + (m * v.conj() * (a + 9.81j)).real + j * w * al
    power = result["tau"] * SERVO[1]
    assert np.abs(power - rate).max() < 1e-11 * np.abs(power).max()


@pytest.mark.parametrize("balanced", [False, True])
def test_the_frame_carries_weight_and_inertia_of_all_bodies(balanced):
    result = six_bar(*SERVO, balanced=balanced)
    frame = result["F01x"] + result["F03x"] + result["F05x"] + 1j * (result["F01y"] + result["F03y"])
    needed = sum(m * (a + 9.81j) for m, _, _, _, _, a in bodies(*SERVO, result, balanced))
    assert np.abs(frame - needed).max() < 1e-11 * np.abs(needed).max()


def test_balancing_changes_the_forces_but_not_the_motion():
    before, after = (six_bar(*SERVO, balanced=balanced) for balanced in (False, True))
    for name in before:
        same = np.allclose(before[name], after[name], rtol=1e-12, atol=0.0)
        assert same == (name not in hand_script.UNKNOWNS or name == "F54y"), name  # F54y carries only the slide


@pytest.mark.parametrize(
    "motion",
    [pytest.param((2 * np.pi * np.arange(72) / 72, SPEED, 0.0), id="cycle"), pytest.param(SERVO, id="servo")],
)
def test_the_pinocchio_loop_agrees_with_the_hand_script(motion):
    peer = pinocchio_loop.inverse_dynamics(*motion)
    result = six_bar(*motion)
    expected = world_forces(result) | {"tau": result["tau"]}
    assert set(peer) == set(expected) == {"tau", "A", "B", "C", "D", "E", "F", "slide_guide"}
    for name in expected:
        assert np.abs(peer[name] - expected[name]).max() < 1e-9 * np.abs(expected[name]).max(), name


def test_the_pinocchio_loop_remembers_nothing_between_calls():
    press = pinocchio_loop.PinocchioLoop()
    first, again = (pinocchio_loop.inverse_dynamics([3.0, 3.1], SPEED, 0.0, press) for _ in range(2))
    np.testing.assert_array_equal(first["tau"], again["tau"])


@pytest.mark.parametrize(("length", "value"), [("L2", 0.5), ("L31", 0.05), ("L4", 0.3)])
def test_loops_that_do_not_close_are_refused(monkeypatch, length, value):
    monkeypatch.setattr(hand_script, length, value)
    with pytest.raises(ArithmeticError, match="cannot be closed"):
        six_bar(np.linspace(0.0, 6.0, 50), SPEED, 0.0)
