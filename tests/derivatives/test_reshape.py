"""Linkages with their pivots elsewhere: lengths as given, the assembly kept, drawn anew, and written."""

import numpy as np
import pinocchio as pin
import pytest
from support import texts
from support.generators.small_linkages import bolted, geared
from support.generators.spatial_linkages import bennett

import pinpress as pp
from pinpress.derivatives.motion import pivot_positions
from pinpress.derivatives.reshape import reshaped

SPEED = 7.0
ROUNDING = 1e-13  # of lengths near 1 m that pass through placements, sines and Newton's method


def crank_slide(radius, rod):
    return reshaped(texts.shipped("crank_slide"), {("P", "crank"): (radius, 0, 0), ("W", "rod"): (rod, 0, 0)})


def test_a_crank_slide_has_the_stroke_of_its_new_crank():
    motion = pp.cycle(crank_slide(0.13, 0.37), SPEED, points=720)
    angle = motion.crank_angle
    below = 0.13 * np.cos(angle) + np.sqrt(0.37**2 - (0.13 * np.sin(angle)) ** 2)
    assert np.abs(motion.slide_position + below).max() <= ROUNDING


def test_the_drawn_pose_is_closed_and_the_crank_angle_keeps_its_meaning():
    press = reshaped(texts.shipped("zxn2_3000b"), {("A", "frame"): (1.3, 0, -0.25), ("C", "coupler"): (1.3, 0, 0)})
    assert np.abs(press.closed).max() <= ROUNDING
    origins = press.plane_or_refuse("").origins
    along = origins[press.joints.index("B")] - origins[press.joints.index("A")]
    assert abs(np.angle(along.sum())) <= ROUNDING  # the crank lies along x, as it was drawn


def test_the_assembly_is_kept_where_another_one_is_nearer_in_one_step():
    """The rocker of the ZXN2-3000(B) stays on the same side of the line from B to D through a change that alone turns it by 40 degrees."""
    press = texts.shipped("zxn2_3000b")
    far = reshaped(press, {("A", "frame"): (0.9, 0, -0.6), ("C", "coupler"): (1.0, 0, 0)})
    steps = press
    for share in np.linspace(0.1, 1.0, 10):
        steps = reshaped(
            steps, {("A", "frame"): (1.25 - 0.35 * share, 0, -0.2 - 0.4 * share), ("C", "coupler"): (1.243 - 0.243 * share, 0, 0)}
        )
    margins = [p.engine().close(np.zeros(1), p.closed[:, None], with_margins=True).margins for p in (press, far, steps)]
    assert (np.sign(margins[0]) == np.sign(margins[1])).all()
    assert np.abs(margins[1] - margins[2]).max() <= ROUNDING


def test_the_way_there_and_back_leads_to_the_same_motion():
    press = texts.shipped("thin_wall")
    there = reshaped(press, {("D", "bar"): (0.7, 0, 0), ("slide_guide", "frame"): (0.3, 0, 0.68), ("C", "frame"): (0.05, 0, -0.02)})
    back = reshaped(there, {("D", "bar"): (0.648, 0, 0), ("slide_guide", "frame"): (0.41, 0, 0.63), ("C", "frame"): (0, 0, 0)})
    motions = [pp.cycle(p, SPEED, points=60) for p in (press, back)]
    for name in ("slide_position", "slide_velocity", "slide_acceleration"):
        values = [getattr(motion, name) for motion in motions]
        assert np.abs(values[0] - values[1]).max() <= 10 * ROUNDING * np.abs(values[0]).max(), name
    assert np.abs(pp.cycle(there, SPEED, points=60).slide_position - motions[0].slide_position).max() > 0.01


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["zxn2_3000b", "jf75g_125_symmetric", "thin_wall"])
def test_a_changed_linkage_is_written_and_loads_to_the_same_motion(name, tmp_path):
    press = texts.shipped(name)
    scaled = reshaped(press, {pivot: 1.1 * position for pivot, position in pivot_positions(press).items()})
    loaded = pp.load(pp.write_urdf(scaled, tmp_path / "changed.urdf"))
    motions = [pp.cycle(p, SPEED, points=60) for p in (scaled, loaded, press)]
    size = np.abs(motions[0].slide_position).max()
    assert np.abs(motions[0].slide_position - motions[1].slide_position).max() <= ROUNDING * size
    assert np.abs(motions[0].slide_position - 1.1 * motions[2].slide_position).max() <= 10 * ROUNDING * size  # as large as that, to scale


def test_joint_limits_keep_their_place_counted_from_the_new_pose():
    press = texts.shipped("zxn2_3000b")
    changed = reshaped(press, {("slide_guide", "frame"): (0.02, 0, -0.957), ("F", "rod"): (0.5, 0, 0)})
    guide, offset, _ = press.slide_guide
    new_offset = changed.slide_guide.offset
    place = press.model.joints[guide + 1].idx_q
    moved = 0.957 - 0.9579409746502484  # of the zero of the guide itself, which was given another place
    for limits in ("lowerPositionLimit", "upperPositionLimit"):
        before, after = (getattr(p.model, limits)[place] for p in (press, changed))
        assert abs((before + offset - moved) - (after + new_offset)) <= ROUNDING


def test_a_linkage_in_space_is_closed_with_its_new_lengths():
    """Bennett's linkage half as large again has the same angles; with one length alone changed it cannot close."""
    press = texts.load(bennett())
    assert "plane" not in press.engines
    larger = reshaped(press, {pivot: 1.5 * position for pivot, position in pivot_positions(press).items()})
    assert np.abs(larger.closed).max() <= 1e-9  # drawn closed
    for before, after in zip(press.model.jointPlacements, larger.model.jointPlacements, strict=True):
        assert np.abs(after.rotation - before.rotation).max() <= 1e-9
        assert np.abs(after.translation - 1.5 * before.translation).max() <= 1e-9
    pivot, position = list(pivot_positions(press).items())[1]
    with pytest.raises(pp.SingularityError, match="cannot be assembled"):
        reshaped(press, {pivot: 1.1 * position})


@pytest.mark.parametrize(
    ("pivots", "words"),
    [
        ({("P", "rod"): (0, 0, 0)}, "origin of link 'rod'"),
        ({("P", "slide"): (0, 0, 0)}, "joins 'crank' and 'rod'"),
        ({("Q", "crank"): (0, 0, 0)}, "no bearing 'Q'"),
        ({("P", "wheel"): (0, 0, 0)}, "no link 'wheel'"),
        ({("P", "crank"): (0.1, 0)}, "three finite numbers"),
        ({("P", "crank"): (0.1, np.nan, 0)}, "three finite numbers"),
        ({("P", "crank"): (0.1, 0.01, 0)}, "out of the plane"),
        ({"P": (0.1, 0, 0)}, "pair of names"),
        ([("P", "crank")], "give a mapping"),
    ],
)
def test_pivots_that_make_no_sense_are_refused(pivots, words):
    with pytest.raises(pp.PinpressError, match=words):
        reshaped(texts.shipped("crank_slide"), pivots)


def test_lengths_that_do_not_reach_and_another_assembly_are_refused():
    """The rod of the ZXN2-3000(B) turned over would close, with the slide above its bearing on the rocker."""
    with pytest.raises(pp.SingularityError, match="two assemblies"):
        reshaped(texts.shipped("zxn2_3000b"), {("F", "rod"): (-0.48, 0, 0)})
    with pytest.raises(pp.AssemblyError) as caught:
        reshaped(texts.shipped("crank_slide"), {("W", "rod"): (0.05, 0, 0), ("slide_guide", "frame"): (0.4, 0, -0.5)})
    assert caught.value.gap > 0.1
    with pytest.raises(pp.AssemblyError):
        reshaped(texts.shipped("jf75g_125_two_point"), {("P4_front", "main_rod_front"): (0.31, 0, 0)})  # the rod behind holds the slide


def test_pivots_are_in_the_frames_of_links_that_are_welded_askew():
    """A ZXN2-3000(B) bolted down askew, its crank pivot given in the frame that is bolted, moves as one that stands upright."""
    pivots = {("A", "frame"): (1.3, 0.0, -0.2), ("C", "rocker"): (0.39, 0.0, 0.01)}
    upright, askew = texts.shipped("zxn2_3000b"), bolted(texts.shipped("zxn2_3000b"), "0.3 0.2 0.5")
    motions = [pp.cycle(reshaped(press, pivots), SPEED, points=24) for press in (upright, askew)]
    assert np.abs(motions[0].v - motions[1].v).max() <= 1e3 * ROUNDING  # of planes that are turned


def test_a_gear_pair_that_is_offset_is_drawn_where_it_meshes(tmp_path):
    press = geared('<mimic joint="fast" multiplier="-0.5" offset="0.2"/>', "fast")
    apart = reshaped(press, {("slow", "frame"): (0.2, 0, 0)})
    reloaded = pp.load(pp.write_urdf(apart, tmp_path / "apart.urdf"))
    for changed in (apart, reloaded):
        assert not changed.closed.any()
        drawn = changed.model.jointPlacements[changed.joints.index("slow") + 1]
        np.testing.assert_allclose(drawn.rotation, pin.exp3(np.array([0, -0.2, 0])), atol=1e-15)
        assert np.abs(pp.cycle(changed, SPEED, points=4).joint_position @ [0.5, 1.0]).max() <= ROUNDING
