"""A linkage drawn at another crank angle: the same machine, with its coordinates counted from there."""

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators.malformed_linkages import GEAR, changed
from support.generators.spatial_linkages import bennett

import pinpress as pp

TURN = np.linspace(0.0, 6.0, 25)
ANGLE = 1.234


def same_machine(press: pp.Linkage, drawn: pp.Linkage, angle: float) -> None:
    """Motions and forces agree at angles that differ by ``angle``, to rounding."""
    before, after = (
        pp.inverse_dynamics(each, pp.servo_cycle(each, angle=TURN + shift, speed=7.0, acceleration=3.0))
        for each, shift in ((press, angle), (drawn, 0.0))
    )
    largest = max(np.abs(force).max() for force in before.bearing_force.values())
    for name in press.bearings:
        np.testing.assert_allclose(after.bearing_force[name], before.bearing_force[name], atol=1e-12 * largest)
    scale = np.abs(before.driving_torque).max()
    np.testing.assert_allclose(after.driving_torque, before.driving_torque, atol=1e-12 * scale)
    np.testing.assert_allclose(after.motion.v, before.motion.v, atol=1e-11 * np.abs(before.motion.v).max())
    if press.slide is not None:
        np.testing.assert_allclose(after.motion.slide_position, before.motion.slide_position, atol=1e-13)
    assert drawn.engines == press.engines


@pytest.mark.parametrize("name", ["zxn2_3000b", "thin_wall", "jf75g_125_symmetric"])
def test_it_is_the_same_machine(name: str) -> None:
    press = texts.shipped(name)
    drawn = press.drawn_at(ANGLE)
    assert not drawn.closed.any() or np.abs(drawn.closed).max() < 1e-13
    same_machine(press, drawn, ANGLE)


@pytest.mark.exhaustive
def test_in_space() -> None:
    press = texts.load(bennett())
    same_machine(press, press.drawn_at(ANGLE), ANGLE)


def test_gears_with_an_offset() -> None:
    """The wheel stands elsewhere as drawn; at the new pose its coordinate and the offset are 0."""
    press = texts.load(changed((GEAR, GEAR.replace("/>", ' offset="0.7"/>'))))
    drawn = press.drawn_at(ANGLE)
    assert [coupling.offset for coupling in drawn.couplings] == [0.0]
    same_machine(press, drawn, ANGLE)


def test_dead_centres_are_where_it_is_drawn() -> None:
    press = texts.shipped("zxn2_3000b")
    ends = pp.dead_centres(press)
    drawn = press.drawn_at(ends.top_angle, "top dead centre")
    found = pp.dead_centres(drawn)
    assert (found.top_angle, found.stroke) == (0.0, pytest.approx(ends.stroke, abs=1e-15))
    assert found.bottom_angle == pytest.approx(ends.bottom_angle - ends.top_angle, abs=1e-12)
    assert drawn.zero == "top dead centre"
    assert "crank_angle_from_top_dead_centre [rad]" in pp.cycle(drawn, 7.0, points=4).columns()
    assert drawn.driver_coordinates[0].at(0.5) == "crank angle 28.6479 deg from top dead centre"
    again = drawn.drawn_at(-ends.top_angle, "")
    assert list(pp.cycle(again, 7.0, points=4).columns())[1] == "crank_angle [rad]"


def test_written_and_read(tmp_path) -> None:
    """The URDF draws the new pose, with joint limits from there."""
    press = texts.shipped("zxn2_3000b")
    drawn = press.drawn_at(ANGLE)
    read = pp.load(pp.write_urdf(drawn, tmp_path / "drawn.urdf"))
    same_machine(press, read, ANGLE)
    rocker = press.model.joints[press.model.getJointId("D")].idx_q
    moved = press.configuration(ANGLE)[rocker]
    assert read.model.upperPositionLimit[rocker] == pytest.approx(press.model.upperPositionLimit[rocker] - moved, abs=1e-15)
    placed = [each.model.jointPlacements[each.model.getJointId("D")].rotation for each in (press, drawn)]
    np.testing.assert_allclose(pin.log3(placed[0].T @ placed[1]), [0, -moved, 0], atol=1e-14)
