"""The two oracles of the six-bar press against mechanics in closed form, and against each other; `test_reference` compares us with them."""

import json
from pathlib import Path

import numpy as np
import pytest
from support.oracles import pinocchio_loop
from support.oracles import six_bar_script as hand_script
from support.oracles.six_bar_script import six_bar, world_forces

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "zxn2_3000b.json").read_text(encoding="utf-8"))
SPEED = 70 * 2 * np.pi / 60  # the reference's [rad/s]
# Angles over two turns and backwards, with speed (through zero) and acceleration of their own: nothing periodic to hide behind.
SERVO = (np.linspace(9.0, -4.0, 97), 8.0 * np.cos(np.linspace(0.0, 7.0, 97)), 30.0 * np.sin(np.linspace(1.0, 9.0, 97)))


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
def test_input_power_is_the_rate_of_energy_and_the_frame_carries_weight_and_inertia(balanced):
    result = six_bar(*SERVO, balanced=balanced)
    moving = bodies(*SERVO, result, balanced)
    rate = sum((m * v.conj() * (a + 9.81j)).real + j * w * al for m, j, w, al, v, a in moving)
    power = result["tau"] * SERVO[1]
    assert np.abs(power - rate).max() < 1e-11 * np.abs(power).max()
    frame = result["F01x"] + result["F03x"] + result["F05x"] + 1j * (result["F01y"] + result["F03y"])
    needed = sum(m * (a + 9.81j) for m, _, _, _, _, a in moving)
    assert np.abs(frame - needed).max() < 1e-11 * np.abs(needed).max()


def test_balancing_changes_the_forces_but_not_the_motion():
    before, after = (six_bar(*SERVO, balanced=balanced) for balanced in (False, True))
    for name in before:
        same = np.allclose(before[name], after[name], rtol=1e-12, atol=0.0)
        assert same == (name not in hand_script.UNKNOWNS or name == "F54y"), name  # F54y carries only the slide


@pytest.mark.parametrize("motion", [(2 * np.pi * np.arange(72) / 72, SPEED, 0.0), SERVO], ids=["cycle", "servo"])
def test_the_pinocchio_loop_agrees_with_the_hand_script(motion):
    peer, result = pinocchio_loop.inverse_dynamics(*motion), six_bar(*motion)
    expected = world_forces(result) | {"tau": result["tau"]}
    assert set(peer) == set(expected) == {"tau", "A", "B", "C", "D", "E", "F", "slide_guide"}
    for name in expected:
        assert np.abs(peer[name] - expected[name]).max() < 1e-9 * np.abs(expected[name]).max(), name


@pytest.mark.parametrize(("length", "value"), [("L2", 0.5), ("L31", 0.05), ("L4", 0.3)])
def test_loops_that_do_not_close_are_refused(monkeypatch, length, value):
    monkeypatch.setattr(hand_script, length, value)
    with pytest.raises(ArithmeticError, match="cannot be closed"):
        six_bar(np.linspace(0.0, 6.0, 50), SPEED, 0.0)
