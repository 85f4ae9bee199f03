"""How many strokes a turn of the driver has, and all that is said of a stroke, of a minute and of a turn."""

import math
import re

import numpy as np
import pytest
from support import texts
from support.presses import sliding_presses

import pinpress as pp
from pinpress.common.quantities import quantity
from pinpress.dynamics.described import energy_of_stroke
from pinpress.kinematics.main_data import forward_share
from pinpress.simulation.duty import stroke_duties

GEARED = """
press: geared
units: mm
parameters: {{gain: {gain}}}
frame: O V
pins:
  O: [0, 0]
  V: [260, 40]
  P: {{from: O, length: 60, angle: -60}}
  W: {{P: 250, x: 20, side: down}}
links:
  shaft: {{pins: V, disc: 45 x 60}}
  crank: {{pins: O P, mass: 7}}
  rod: {{pins: P W, mass: 4}}
  slide: {{pins: W, guide: up, mass: 70}}
gears: {{O: gain * V}}
drive: V
"""
KNUCKLE = """
press: knuckle          # the crank pulls the knee through the straight pose and out at the other side
units: mm
parameters: {{angle: {angle}}}
frame: O K
pins:
  K: [0, 0]
  O: [450, -250]
  J: {{from: K, length: 250, angle: -90}}
  P: {{from: O, length: 50, angle: angle}}
  W: {{J: 230, x: 0, side: down}}
links:
  crank: {{pins: O P, mass: 5}}
  pull: {{pins: P J, mass: 3}}
  upper: {{pins: K J, mass: 5}}
  lower: {{pins: J W, mass: 5}}
  slide: {{pins: W, guide: up, mass: 50}}
drive: O
"""
FORCE, START, END = 16e3, 4e-3, 1.5e-3
WORK = FORCE * (START - END) * 2 / np.pi  # of a quarter of a sine, from nothing to the largest force
GAINS = {"1": (1, 1, 1), "-2": (2, 1, 1), "3": (3, 1, 1), "-1.5": (3, 2, 1), "0.5": (1, 2, 1), "7": (7, 1, 1)}


def built(text, folder, **values):
    path = folder / "press.yaml"
    path.write_text(text.format(**values))
    return pp.build(path)


def loaded(press, speed, points=None):
    motion = pp.cycle(press, speed, points=points)
    return motion, pp.inverse_dynamics(press, motion, [pp.loads.Blanking(FORCE, START, END)])


def worked(text, words):
    """Whether the work of the process is that of the load, in these words."""
    number, unit = quantity("J").text(WORK, digits=5).split()
    return re.search(rf"  work of the process +{re.escape(number)} {unit} +{re.escape(words)}", text) is not None


@pytest.mark.parametrize("gain", GAINS)
def test_a_geared_crank(tmp_path, gain):
    """What a crank does that turns faster than its driver is what it does at its own speed: independent of the strokes of a turn."""
    strokes, turns, differing = GAINS[gain]
    press, plain = built(GEARED, tmp_path, gain=gain), built(GEARED, tmp_path, gain=1)
    ends, own = pp.dead_centres(press), pp.dead_centres(plain)
    assert ends.strokes == differing
    assert ends.strokes_per_turn == pytest.approx(strokes / turns, rel=1e-15)
    assert press.period_turns == turns
    assert ends.stroke == pytest.approx(own.stroke, rel=1e-12)
    way = 1.0 if float(gain) > 0 else -1.0
    assert forward_share(press) == pytest.approx(forward_share(plain, way), abs=1e-12)
    speed = 60 * pp.RPM
    _, reactions = loaded(press, speed)
    text = str(reactions)
    assert f"  {60 * strokes / turns:g} strokes/min, " in text
    assert worked(text, "a stroke\n")
    capacities = pp.ratings.Capacities(1e5, torque=5e3, motor_power=2e4)
    rated, of_plain = pp.ratings.rate(press, speed, capacities), pp.ratings.rate(plain, float(gain) * speed, capacities)
    for name in ("quick_return_ratio", "dwell_time"):
        assert getattr(rated, name) == pytest.approx(getattr(of_plain, name), rel=1e-6)
    assert rated.turns == pytest.approx(turns / strokes, rel=1e-15)
    assert rated.energies["motor energy"] == pytest.approx(2e4 * 60 / (60 * strokes / turns), rel=1e-12)
    assert f"{60 * strokes / turns:g} strokes/min" in str(rated)
    for name in ("quick_return_ratio", "speed_ratio"):
        measure = getattr(pp.measures, name)
        many = pp.cycle(press, speed, points=720 * strokes), pp.cycle(plain, float(gain) * speed, points=720)
        assert measure(many[0]) == pytest.approx(measure(many[1]), rel=1e-9)


@pytest.mark.parametrize("gain", ["-2", "-1.5", "3"])
def test_strokes_of_a_run_and_of_a_check(tmp_path, gain):
    strokes, turns, _ = GAINS[gain]
    press = built(GEARED, tmp_path, gain=gain)
    loads = [pp.loads.Blanking(FORCE, START, END)]
    run = pp.simulate(press, 2.2, speed=2 * np.pi, flywheel=pp.drives.Flywheel(500.0), loads=loads, points=50)
    duties = stroke_duties(run)
    assert len(duties) == math.floor(float(run.crank_angle[-1]) / (2 * np.pi) * strokes / turns)
    np.testing.assert_allclose([each.load_work for each in duties], WORK, rtol=1e-6)
    assert f"{strokes / turns:g}        of V, all alike" in str(pp.check(pp.write_urdf(press, tmp_path / "press.urdf")))


@pytest.mark.one_in(6)
@pytest.mark.parametrize("angle", [90, 75, 110])
def test_a_knuckle_that_passes_its_straight_pose(tmp_path, angle):
    """Two strokes that differ, both to the straight pose. Independent: signs of the slide's speed in fine states."""
    press = built(KNUCKLE, tmp_path, angle=angle)
    ends = pp.dead_centres(press)
    assert (ends.strokes, ends.turns, ends.strokes_per_turn) == (2, 1, 2.0)
    fine = pp.cycle(press, 1.0, points=36000)
    assert forward_share(press) == pytest.approx(float(np.mean(fine.slide_velocity < 0)), abs=2e-4)
    assert forward_share(press, -1.0) == pytest.approx(1.0 - forward_share(press), abs=1e-12)
    _, reactions = loaded(press, 60 * pp.RPM)
    assert reactions.process_work == pytest.approx(2 * WORK, rel=1e-6)
    text = str(reactions)
    assert "  120 strokes/min, " in text
    number = quantity("J").scale([WORK], digits=5).shown(WORK)
    assert worked(text, f"a stroke, on average of the 2 of a turn: {number}, {number} J\n")
    assert "down, in 2 strokes\n" in text
    found = str(pp.check(pp.write_urdf(press, tmp_path / "press.urdf")))
    assert "strokes a turn                       2        of O, with bottom dead centres at " in found
    with pytest.raises(pp.PinpressError, match="turns back 4 times a period and has no one working stroke"):
        pp.ratings.rate(press, 60 * pp.RPM, pp.ratings.Capacities(1e5))


def test_strokes_that_work_differently_are_told_apart(tmp_path):
    """A load above the lower one of two upper dead centres acts in the stroke from the higher one alone."""
    press = built(KNUCKLE, tmp_path, angle=70)
    higher = min(_tops(press))
    motion = pp.cycle(press, 60 * pp.RPM)
    loads = [pp.loads.Blanking(FORCE, higher + 1e-3, higher + 0.2e-3)]
    reactions = pp.inverse_dynamics(press, motion, loads)
    line = next(line for line in str(reactions).splitlines() if line.startswith("  work of the process "))
    works = sorted(float(word) for word in line.partition("turn: ")[2].removesuffix(" J").split(", "))
    assert works == [0.0, pytest.approx(FORCE * 0.8e-3 * 2 / np.pi, abs=1e-3)]
    assert float(line.split()[4]) == pytest.approx(sum(works) / 2, abs=1e-3)


def _tops(press):
    """Heights of the upper turning points in fine states."""
    position = pp.cycle(press, 1.0, points=7200).slide_position
    upper = (position > np.roll(position, 1)) & (position >= np.roll(position, -1))
    return position[upper] - position.min()


def test_a_small_rise_at_the_bottom_is_a_dwell(tmp_path):
    """Where the knuckle hardly passes its straight pose, the slide rises by less than a tenth of its stroke and makes one stroke."""
    press = built(KNUCKLE, tmp_path, angle=20)
    lower, upper = sorted(_tops(press))
    assert 0.0 < lower < 0.1 * upper
    ends = pp.dead_centres(press)
    assert (ends.strokes, ends.strokes_per_turn) == (1, 1.0)
    _, reactions = loaded(press, 60 * pp.RPM)
    assert "  60 strokes/min, " in str(reactions)
    assert "strokes a turn" not in str(pp.check(pp.write_urdf(press, tmp_path / "press.urdf")))


def test_a_screw_that_pushes_a_knee_through():
    """A driver that slides makes two strokes on its way there and back where the knee passes its straight pose."""
    press = texts.load(sliding_presses.TOGGLE.replace('upper="0.09"', 'upper="0.22"'))
    assert (pp.dead_centres(press).turns, pp.dead_centres(press).strokes) == (1, 2)
    _, reactions = loaded(press, 0.2)
    assert reactions.process_work == pytest.approx(2 * WORK, rel=1e-6)
    assert worked(str(reactions), "a stroke, on average of the 2 of a way there and back\n")
    assert pp.dead_centres(texts.load(sliding_presses.TOGGLE)).strokes == 1


@pytest.mark.one_in(8)
@pytest.mark.parametrize("gain", ["-2", "-1.5", "3"])
def test_energy_and_springs_of_a_stroke(tmp_path, gain):
    """A flywheel takes up and gives off the same energy in each of equal strokes; speeds on springs are given in strokes."""
    strokes, turns, _ = GAINS[gain]
    press, plain = built(GEARED, tmp_path, gain=gain), built(GEARED, tmp_path, gain=1)
    shown = [
        energy_of_stroke(loaded(one, speed, points=points)[1])[0][-1].value
        for one, speed, points in ((press, 2 * np.pi, 720 * strokes), (plain, float(gain) * 2 * np.pi, 720))
    ]
    assert shown[0] == pytest.approx(shown[1], rel=1e-4)
    shift = pp.elasticity.dead_centre_shift(press, pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 1e9)), speed=2 * np.pi)
    assert str(shift).splitlines()[-1].split()[1] == f"{60 * strokes / turns:g}"  # strokes/min
