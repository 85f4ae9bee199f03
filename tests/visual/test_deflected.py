"""Links drawn on their springs."""

import numpy as np
import pytest
from support.texts import shipped

import pinpress as pp
from pinpress.kinematics.poses import poses
from pinpress.visual.deflected import displaced, magnification


def test_displacements_put_links_where_they_are():
    """Without magnification the slide's origin is at the elastic slide position, and a bearing is as wide open as its force says."""
    press, speed, stiffness = shipped("jf75g_125_plain"), 300 * pp.RPM, 2e7
    elastic = pp.elasticity.Elastic(pp.elasticity.Stiffness(dict.fromkeys(press.bearings, stiffness), moments={"slide_guide": 2e6}), 0.0)
    run = pp.steady_state(press, speed, drive=pp.drives.PrescribedSpeed(speed), elastic=elastic, points=25)
    assert isinstance(run, pp.ElasticRun)
    at = displaced(press, poses(press, run.joint_position), run.displacement)
    slide = press.model.frames[press.model.getFrameId("slide")]
    np.testing.assert_allclose(at.points(slide.parentJoint, slide.placement.translation)[:, 2], run.slide_position, rtol=0, atol=1e-12)
    crank, rod = (press.joints.index(name) + 1 for name in ("O", "P2"))
    gap = at.points(rod, np.zeros(3)) - at.points(crank, press.model.jointPlacements[rod].translation)
    np.testing.assert_allclose(run.bearing_force["P2"], -stiffness * gap, rtol=0, atol=1e-6 * stiffness * np.abs(gap).max())


@pytest.mark.parametrize(("share", "factor"), [(1e-3, 50.0), (0.011, 2.0), (0.2, 1.0), (0.0, 1.0), (3e-6, 10000.0)])
def test_magnification_is_a_round_number(share, factor):
    press = shipped("crank_slide")
    assert magnification(press, np.full((3, 3, 3), share * press.size)) == factor
