"""The shapes of a press as Pinocchio's geometry: those that Pinocchio reads from the URDF, and plain ones where it has none."""

from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from support import texts
from support.generators.random_linkages import four_bar
from support.generators.small_linkages import two_cranks
from support.generators.spatial_linkages import bennett

import pinpress as pp
from pinpress.visual.shapes.appearance import bodies

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def objects(model):
    return {each.name: each for each in model.geometryObjects}


@pytest.mark.parametrize("name", pp.presses())
def test_of_shipped_presses_it_is_what_pinocchio_reads(name):
    press = texts.shipped(name)
    ours = objects(pp.visual_model(press))
    theirs = objects(pin.buildGeomFromUrdf(press.model.copy(), press.file, pin.VISUAL))
    assert ours.keys() == theirs.keys()
    for each, other in ((ours[key], theirs[key]) for key in ours):
        assert (each.parentJoint, each.parentFrame, each.overrideMaterial) == (other.parentJoint, other.parentFrame, other.overrideMaterial)
        assert each.geometry == other.geometry
        assert_allclose(each.placement.homogeneous, other.placement.homogeneous, rtol=0, atol=1e-15)
        assert_allclose(each.meshColor, other.meshColor, rtol=0, atol=1e-7)  # theirs are of single precision


@pytest.mark.parametrize("text", [bennett(), four_bar(1.0, 0.3, 0.9, 0.7, 0.5).urdf("O")])
def test_links_without_visuals_have_the_shapes_of_a_recording(text):
    press = texts.load(text)
    motion = pp.servo_cycle(press, angle=np.linspace(0.0, 0.3, 5), speed=1.0)
    drawn = bodies(press, motion.joint_position)
    found = objects(pp.visual_model(press, motion))
    assert {f"{body.name}_{k}" for body in drawn for k in range(len(body.parts))} == found.keys()
    data, geometry = press.model.createData(), pp.visual_model(press, motion)
    placed = geometry.createData()
    pin.updateGeometryPlacements(press.model, data, geometry, placed, motion.q[-1])
    pin.framesForwardKinematics(press.model, data, motion.q[-1])
    for body in drawn:
        for k, part in enumerate(body.parts):
            world = data.oMf[body.frame].homogeneous @ part.placement
            assert_allclose(placed.oMg[geometry.getGeometryId(f"{body.name}_{k}")].homogeneous, world, rtol=0, atol=1e-13)
            assert_array_equal(found[f"{body.name}_{k}"].meshColor, part.rgba)


def test_rails_are_as_long_as_the_travel_of_all_crank_angles():
    text = texts.shipped("crank_slide").text.decode()
    while "<visual" in text:
        text = text[: text.index("<visual")] + text[text.index("</visual>") + len("</visual>") :]
    press = texts.load(text)
    turn = objects(pp.visual_model(press, pp.cycle(press, speed=1.0, points=3600)))
    short = objects(pp.visual_model(press, pp.servo_cycle(press, angle=[0.0, 0.1], speed=1.0)))
    longest = [each for each in turn if turn[each].geometry != short[each].geometry]
    assert longest != []
    for name, each in objects(pp.visual_model(press)).items():
        if isinstance(each.geometry, coal.Box):
            assert_allclose(each.geometry.halfSide, turn[name].geometry.halfSide, rtol=1e-4)


def test_several_drivers():
    assert pp.visual_model(two_cranks()).ngeoms == 3


def test_meshes_are_in_it(tmp_path: Path):
    (tmp_path / "m.obj").write_text(TETRAHEDRON)
    text = texts.shipped("crank_slide").text.decode()
    start, end = text.index("<visual", text.index('<link name="slide"')), text.index("</link>", text.index('<link name="slide"'))
    mesh = '<visual><geometry><mesh filename="m.obj" scale="0.1 0.2 0.3"/></geometry></visual>'
    (tmp_path / "press.urdf").write_text(text[:start] + mesh + text[end:])
    found = objects(pp.visual_model(pp.load(tmp_path / "press.urdf")))["slide_0"]
    assert isinstance(found.geometry, coal.BVHModelOBBRSS)
    assert (found.geometry.num_tris, found.meshPath, found.meshScale.tolist()) == (4, "", [1.0, 1.0, 1.0])
    assert_allclose(sorted(found.geometry.vertices().tolist()), [[0, 0, 0], [0, 0, 0.3], [0, 0.2, 0], [0.1, 0, 0]], atol=1e-7)


def test_every_call_makes_new_ones():
    press = texts.shipped("crank_slide")
    objects(pp.visual_model(press))["slide_0"].placement = pin.SE3.Random()
    first, second = (objects(pp.visual_model(press))["slide_0"].placement for _ in range(2))
    assert first == second


def test_a_motion_of_other_joints_is_refused():
    motion = pp.cycle(texts.shipped("zxn2_3000b"), speed=1.0, points=4)
    with pytest.raises(pp.PinpressError, match="the motion is of zxn2_3000b with other joints than crank_slide"):
        pp.visual_model(texts.shipped("crank_slide"), motion)
