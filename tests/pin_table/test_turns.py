"""A table whose press runs clockwise: positive angles, speeds and torques are in the sense of running, and the press is the same."""

import numpy as np
import pytest
import yaml

import pinpress as pp
from pinpress.pin_table.templates import TEMPLATES, template

RACK = """
press: rack
units: mm
frame: O
pins: {O: [0, 0], S: [200, 0]}
links:
  wheel: {pins: O, disc: 60 x 30}
  slide: {pins: S, guide: up, mass: 50}
gears: {slide_guide: 1 * O}
drive: O
"""
KNEE = """
press: geared
units: mm
frame: O V
pins:
  O: [0, 0]
  V: [260, 40]
  P: {from: O, length: 60, angle: -60}
  W: {P: 250, x: 20, side: down}
links:
  shaft: {pins: V, mass: 30, com: [10, 5]}
  crank: {pins: O P, mass: 7}
  rod: {pins: P W, mass: 4}
  slide: {pins: W, guide: up, mass: 70}
gears: {O: -2 * V}
drive: V
"""
TABLES = {name: template(name).decode() for name in TEMPLATES} | {"geared": KNEE}
# A driver that slides, and two about axes that their tables give: no sense in the picture.
WITHOUT_SENSE = ("toggle", "screw", "rssp")


def built(text, folder, turns=None):
    table = yaml.safe_load(text)
    path = folder / f"{turns}.yaml"
    path.write_text(yaml.safe_dump(table if turns is None else table | {"turns": turns}, sort_keys=False))
    return pp.build(path)


@pytest.mark.parametrize("name", [name for name in TABLES if name not in WITHOUT_SENSE])
def test_a_press_that_runs_clockwise_is_the_press_turned_backwards(name, tmp_path):
    """Mechanics does not know which sense is called positive: world quantities are equal, the driver's change sign."""
    plain, running = built(TABLES[name], tmp_path), built(TABLES[name], tmp_path, "clockwise")
    assert pp.check(pp.write_urdf(running, tmp_path / "running.urdf")).facts.data.rotation == ("clockwise",)
    motions = pp.cycle(plain, -3.0, points=60), pp.cycle(running, 3.0, points=60)
    loads = [pp.loads.DeepDrawing(2e4, 0.01)]
    before, after = (pp.inverse_dynamics(*each, loads) for each in zip((plain, running), motions, strict=True))
    for one, other in ((motions[0].slide_velocity, motions[1].slide_velocity), (-before.driving_torque, after.driving_torque)):
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-9 * np.abs(one).max())
    np.testing.assert_allclose(motions[1].crank_angle, -motions[0].crank_angle, rtol=0, atol=1e-12)
    np.testing.assert_allclose(after.shaking_force, before.shaking_force, rtol=0, atol=1e-9 * np.abs(before.shaking_force).max())
    largest = max(np.abs(force).max() for force in before.bearing_force.values())
    for bearing, force in before.bearing_force.items():
        np.testing.assert_allclose(after.bearing_force[bearing], force, rtol=0, atol=1e-8 * largest)
    ends, others = pp.dead_centres(plain), pp.dead_centres(running)
    periods = (ends.bottom_angle + others.bottom_angle) / (2 * np.pi * ends.turns)
    assert periods == pytest.approx(round(periods), abs=1e-9)


def test_racks_mesh_as_before(tmp_path):
    """A rack lies on one side of its pinion, whatever sense is called positive."""
    plain, running = built(RACK, tmp_path), built(RACK, tmp_path, "clockwise")
    before, after = (
        pp.servo_cycle(press, speed=way, angle=way * np.linspace(0.0, 0.2, 5)) for press, way in ((plain, -1.0), (running, 1.0))
    )
    np.testing.assert_allclose(after.slide_position, before.slide_position, atol=1e-15)
    assert np.ptp(before.slide_position) > 0


def test_the_torque_at_a_height_is_that_of_the_way_down(tmp_path):
    """The flank of the way down is that of the sense of running: virtual work, force times z' on either flank. Said in the table's text."""
    text = TABLES["link-drive"]
    plain, running = built(text, tmp_path), built(text, tmp_path, "clockwise")
    found = {}
    for name, press in (("plain", plain), ("running", running)):
        part = pp.tolerances.pin_position(press, press.driver, "x", 50e-6)
        found[name] = pp.tolerances.bottom_dead_centre(press, [part], forces={0.005: 8e5}, samples=3)
        motion = pp.cycle(press, 1.0, points=36000)
        height = motion.slide_position - pp.dead_centres(press).bottom_position
        down = (motion.slide_velocity < 0) & (height < 0.05)
        slope = np.interp(0.005, *zip(*sorted(zip(height[down], -motion.slide_velocity[down], strict=True)), strict=True))
        assert found[name].torques[0.005].nominal == pytest.approx(8e5 * slope, rel=1e-5)
    assert "at a positive speed of" in found["plain"].way_down
    assert "(counter-clockwise)" in found["plain"].way_down
    assert "at a positive speed of" in found["running"].way_down
    assert "(clockwise)" in found["running"].way_down
    part = pp.tolerances.pin_position(plain, plain.driver, "x", 50e-6)
    back = pp.tolerances.bottom_dead_centre(plain, [part], forces={0.005: 8e5}, speeds={0.005: -1.0}, samples=3)
    assert back.torques[0.005].nominal == pytest.approx(-found["running"].torques[0.005].nominal, rel=1e-9)
    assert "at a negative speed of" in str(back)
    assert "(clockwise)" in str(back)


def test_counter_clockwise_is_what_a_table_means_without_a_sense(tmp_path):
    assert built(KNEE, tmp_path, "counter-clockwise").joints == built(KNEE, tmp_path).joints
