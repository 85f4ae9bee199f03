"""A crank alone, in one bearing or two: Pinocchio gives vectors where a matrix has one column."""

import numpy as np
import pytest
from support.generators.hostile_files import press as urdf

import pinpress as pp

INERTIA, TORQUE, SPEED, TIME = 1.0, 3.0, 2.0, 0.5
AXIS = '<axis xyz="0 -1 0"/>'


def loaded(folder, kind, turned="0 0 0"):
    """With a second bearing of this kind on the same axis, 0.4 m beside the first."""
    ends = f'<link1 link="frame" xyz="0 0.4 0" rpy="{turned}"/><link2 link="crank" xyz="0 0.4 0" rpy="{turned}"/>'
    axis = AXIS if kind == "revolute" else ""
    file = folder / "crank.urdf"
    file.write_text(urdf(kind and f'<loop_joint name="L" type="{kind}">{ends}{axis}</loop_joint>'), encoding="utf-8")
    return pp.load(file)


@pytest.mark.parametrize("kind", ["", "spherical", "revolute"])
def test_second_bearing_on_the_axis_changes_nothing(tmp_path, kind):
    press = loaded(tmp_path, kind)
    angle, acceleration = np.array([0.0, 0.3, 0.5]), np.array([4.0, 5.0, 6.0])
    for engine in ("plane", "space", "pinocchio"):
        motion = pp.servo_cycle(press, speed=SPEED, angle=angle, acceleration=acceleration, engine=engine)
        result = pp.inverse_dynamics(press, motion, engine=engine)
        np.testing.assert_allclose(result.driving_torque, INERTIA * acceleration, rtol=1e-14)
        carried = sum(result.bearing_force.values())
        np.testing.assert_allclose(carried, [[0.0, 0.0, 9.81]] * 3, rtol=0, atol=1e-13)
    for method in ("reduced", "constraint"):
        run = pp.simulate(press, TIME, speed=SPEED, drive=pp.drives.ConstantTorque(TORQUE), method=method)
        assert run.crank_angle[-1] == pytest.approx(SPEED * TIME + 0.5 * TORQUE / INERTIA * TIME**2, rel=1e-12)


def test_what_holds_the_crank(tmp_path):
    for kind, turned in (("fixed", "0 0 0"), ("revolute", "0.1 0 0")):
        with pytest.raises(pp.UrdfError, match="mobility is 0, but one joint drives"):
            loaded(tmp_path, kind, turned)


@pytest.mark.parametrize("kind", ["spherical", "revolute"])
def test_forces_come_from_no_memory_left_over(tmp_path, monkeypatch, kind):
    """A loop all of whose equations are redundant: arrays that nobody has written hold nan here."""
    press, empty = loaded(tmp_path, kind), np.empty

    def unwritten(*arguments, **named):
        made = empty(*arguments, **named)
        if made.dtype.kind in "fc":
            made.fill(np.nan)
        return made

    motion = pp.cycle(press, speed=SPEED, points=3)
    monkeypatch.setattr(np, "empty", unwritten)
    carried = pp.inverse_dynamics(press, motion).bearing_force
    np.testing.assert_allclose(sum(carried.values()), [[0.0, 0.0, 9.81]] * 3, rtol=0, atol=1e-13)
