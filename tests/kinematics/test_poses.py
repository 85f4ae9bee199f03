"""Poses of bodies and bearings against Pinocchio, one state at a time."""

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators.spatial_linkages import bennett

import pinpress as pp
from pinpress.kinematics.poses import bearing_points, loaded_bodies, poses


@pytest.fixture(params=[*pp.presses(), "bennett"])
def press(request):
    return texts.load(bennett()) if request.param == "bennett" else texts.shipped(request.param)


def test_against_pinocchio(press):
    motion = pp.cycle(press, speed=7.0, points=17)
    at, data = poses(press, motion.joint_position), press.model.createData()
    points = bearing_points(press, at)
    assert points.shape == (len(press.bearings), 17, 3)
    close = {"rtol": 0.0, "atol": 1e-13 * (1 + press.size)}
    for i, q in enumerate(np.array(motion.q)):
        pin.forwardKinematics(press.model, data, q)
        for j, placement in enumerate(data.oMi):
            np.testing.assert_allclose(at.rotation[j, i], placement.rotation, **close)
            np.testing.assert_allclose(at.position[j, i], placement.translation, **close)
        for k in range(1, press.model.njoints):
            np.testing.assert_allclose(points[k - 1, i], data.oMi[k].translation, **close)
        for k, loop in enumerate(press.loops, press.model.njoints - 1):  # both ends of a closed loop are there
            np.testing.assert_allclose(points[k, i], data.oMi[loop.joint2].act(loop.point2), rtol=0.0, atol=1e-9)


def test_links_that_are_loaded():
    press = texts.shipped("zxn2_3000b")
    loaded = dict(zip(press.bearings, (press.link_of(body) for body in loaded_bodies(press)), strict=True))
    assert loaded == {"A": "crank", "B": "coupler", "C": "rocker", "D": "rocker", "E": "rod", "F": "slide", "slide_guide": "slide"}
    assert press.link_of(0) == "frame"
