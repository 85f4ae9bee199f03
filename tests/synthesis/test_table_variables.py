"""Synthesis over the numbers of a pin table: slopes and optimum of presses that are built again, text, units, refusals."""

import contextlib

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import pinpress as pp
from pinpress.pin_table.templates import template

SPEED = 60 * pp.RPM
STEP = 0.01  # of differences between built presses [mm]
TABLE = """
press: demo
units: mm
parameters:
  r: 95  # crank radius
  l: 400
  e: 20
  spare: 3
frame: O
pins:
  O: [0, 0]
  P: {from: O, length: r, angle: -70}
  W: {P: l, x: e, side: down}
  Q: {P: 0.3 * l, W: l, side: right}
links:
  crank: {pins: O P, section: [60, 40], com: [10, r / 20]}
  rod: {pins: P W Q, mass: l / 80, com: [l / 2, 0.1 * l]}
  slide: {pins: W, guide: up, mass: 90}
drive: O
"""


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    path = tmp_path_factory.mktemp("tables") / "press.yaml"
    path.write_text(TABLE)
    return path


def torque(trial):
    """Mean square of the driving torque."""
    return (trial.reactions.driving_torque**2).mean()


def built(path, points=360, **values):
    press = pp.build(path, **values)
    motion = pp.cycle(press, SPEED, points=points)
    return motion, pp.inverse_dynamics(press, motion)


def test_slopes_are_those_of_presses_that_are_built_again(table):
    trials = []

    def objective(trial):
        trials.append(trial)
        return (trial.motion.slide_acceleration**2).mean()

    pp.synthesis.synthesise(table, {"l": (350, 400, 450)}, minimise=objective, speed=SPEED, points=24)
    trial = next(each for each in trials if np.iscomplexobj(each.variables["l"]))
    h, start = np.imag(trial.variables["l"]), np.real(trial.variables["l"])
    (_, ahead), (_, back) = (built(table, 24, l=start + way * STEP) for way in (1, -1))
    names = ["driving_torque", "shaking_force", "shaking_moment"]
    pairs = [(getattr(trial.reactions, name), getattr(ahead, name), getattr(back, name)) for name in names]
    for name in ("bearing_force", "bearing_moment"):
        pairs += [(getattr(trial.reactions, name)[key], *(getattr(each, name)[key] for each in (ahead, back))) for key in "OPW"]
    for exact, one, two in pairs:
        difference = (one - two) / (2 * STEP)
        assert np.imag(exact) / h == pytest.approx(difference, rel=1e-6, abs=1e-6 * np.abs(difference).max() + 1e-9)


def test_the_optimum_is_that_of_building_again(table):
    def objective(length):
        return (built(table, 60, l=length)[1].driving_torque ** 2).mean()

    naive = minimize_scalar(objective, bounds=(200, 900), method="bounded", options={"xatol": 1e-4})
    found = pp.synthesis.synthesise(table, {"l": (200, 400, 900)}, minimise=torque, speed=SPEED, points=60)
    assert not found.active  # the optimum lies between the bounds
    assert found.value == pytest.approx(naive.fun, rel=1e-12)
    assert found.variables["l"] == pytest.approx(naive.x, rel=1e-5)  # a minimum's place is known to the square root of rounding


def test_the_result_is_a_table_that_builds_the_same_press(table, tmp_path):
    limits = {"stroke": (lambda trial: pp.measures.stroke(trial.motion), 0.18, 0.18)}
    variables = {"r": (80, 95, 110), "pins.O.1": (-20, 0, 20)}
    found = pp.synthesis.synthesise(table, variables, minimise=lambda t: t.motion.slide_acceleration, subject_to=limits, speed=SPEED)
    assert "# crank radius" in found.pin_table
    (tmp_path / "new.yaml").write_text(found.pin_table)
    again = pp.build(tmp_path / "new.yaml")
    assert again.name == found.press.name
    for one, other in zip(again.model.inertias, found.press.model.inertias, strict=True):
        assert one == other
    motion = pp.cycle(again, SPEED)
    assert np.array_equal(motion.slide_position, pp.cycle(found.press, SPEED).slide_position)
    assert pp.measures.stroke(motion) == pytest.approx(0.18, rel=1e-9)
    assert motion.slide_acceleration.max() == pytest.approx(found.value, rel=1e-9)


def test_variables_are_in_the_units_of_the_table(tmp_path):
    inches = tmp_path / "inches.yaml"
    text = TABLE.replace("units: mm", "units: in").replace("r: 95", "r: 3.75").replace("l: 400", "l: 16").replace("e: 20", "e: 0.8")
    inches.write_text(text.replace("[60, 40]", "[2, 1]").replace("com: [10,", "com: [1,"))
    limits = {"stroke": (lambda trial: pp.measures.stroke(trial.motion), 0.18, 0.18)}
    found = pp.synthesis.synthesise(
        inches, {"r": (3, 3.75, 4.5)}, minimise=lambda t: t.motion.slide_acceleration, subject_to=limits, speed=SPEED
    )
    offset, rod, crank = 0.8 * 0.0254, 16 * 0.0254, found.variables["r"] * 0.0254
    stroke = np.sqrt((rod + crank) ** 2 - offset**2) - np.sqrt((rod - crank) ** 2 - offset**2)
    assert stroke == pytest.approx(0.18, rel=1e-9)


def test_a_trade_off_over_the_numbers_of_a_table(table):
    curve = pp.synthesis.trade_off(
        table,
        {"r": (80, 95, 110)},
        first=lambda trial: trial.motion.slide_acceleration,
        second=lambda trial: -pp.measures.stroke(trial.motion),
        speed=SPEED,
        points=24,
        designs=3,
    )
    assert curve.designs[0].variables["r"] == pytest.approx(80, rel=1e-3)  # an end gives way by 1e-4 of the curve's range
    assert curve.designs[-1].variables["r"] == pytest.approx(110, rel=1e-3)
    assert "r: 110" in curve.designs[-1].pin_table or "r: 109.9" in curve.designs[-1].pin_table


REFUSALS = [
    ({"q": (1, 2, 3)}, "'q'"),
    ({"spare": (1, 2, 3)}, "variable 'spare': no place and no mass of .*press.yaml depends on it; leave it out"),
    ({"r": (110, 95, 80)}, "variable 'r': its lower bound 110 is above its upper bound 80: exchange them"),
    (
        {"pins.P.angle": (-80, -70, -60)},
        "the angle of crank in the drawn pose changes with pins.P.angle",
    ),
    ({"pins.P.length": (80, 95, 110)}, "'pins.P.length'"),  # a formula
    ({"l": (50, 50, 60)}, "the start, l = 50, is not a valid press"),
    ({"e": (600, 600, 700)}, "W: 400 from P does not reach x = 600"),
]


@pytest.mark.parametrize(("variables", "message"), REFUSALS)
def test_refusals(table, variables, message):
    with pytest.raises(pp.PinpressError, match=message):
        pp.synthesis.synthesise(table, variables, minimise=torque, speed=SPEED)


def test_a_table_has_its_own_geometry(table):
    with pytest.raises(pp.PinpressError, match="leave geometry out"):
        pp.synthesis.synthesise(table, {"r": (80, 95, 110)}, minimise=torque, geometry=lambda r: {}, speed=SPEED)
    with pytest.raises(pp.PinpressError, match="press is 3: give the path of a file"):
        pp.synthesis.synthesise(3, {"r": (80, 95, 110)}, minimise=torque, speed=SPEED)


def test_a_driver_that_slides_to_and_fro(tmp_path):
    """Its speed is not constant: trials have the velocities, accelerations and torques of `cycle`, and slopes of built presses."""
    path, seen = tmp_path / "toggle.yaml", []
    path.write_bytes(template("toggle"))

    def objective(trial):
        seen.append(trial)
        return trial.motion.slide_acceleration

    with contextlib.suppress(pp.PinpressError):  # whether there is an optimum does not matter
        pp.synthesis.synthesise(path, {"lower": (338, 340, 342)}, minimise=objective, speed=0.1, points=24)
    trial = next(each for each in seen if np.iscomplexobj(each.variables["lower"]))
    h = np.imag(trial.variables["lower"])
    press = pp.build(path)
    reactions = pp.inverse_dynamics(press, pp.cycle(press, 0.1, points=24))
    for name in ("driving_torque", "shaking_force", "shaking_moment"):
        exact = getattr(reactions, name)
        assert np.real(getattr(trial.reactions, name)) == pytest.approx(exact, abs=1e-9 * np.abs(exact).max())
    ahead, here, back = (pp.cycle(pp.build(path, lower=340 + way * STEP), 0.1, points=24) for way in (1, 0, -1))
    for name in ("slide_position", "slide_velocity", "slide_acceleration"):
        exact, size = getattr(trial.motion, name), np.abs(getattr(here, name)).max()
        assert np.real(exact) == pytest.approx(getattr(here, name), abs=1e-10 * size)
        difference = (getattr(ahead, name) - getattr(back, name)) / (2 * STEP)
        assert np.imag(exact) / h == pytest.approx(difference, abs=1e-6 * np.abs(difference).max())
