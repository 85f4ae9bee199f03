"""Eccentric loads against statics by hand, and gib pressures against distributions integrated numerically."""

import dataclasses

import numpy as np
import pytest
from support.generators.small_linkages import bolted
from support.texts import shipped

import pinpress as pp
from pinpress.ratings.eccentric_loads import Gibs, eccentric_load, permissible_eccentricity

FORCE = 1e5
LAM = 0.25  # crank_slide
ANGLES = np.array([0.0, 0.4, 1.3, 5.0, 5.9])


def at(press, angles=ANGLES):
    return pp.servo_cycle(press, speed=0.0, angle=angles)


def by_strips(gibs, n, m, strips=5_001):
    """Peak pressure and contact of elastic gibs of strips that only push, or push and pull, by bisection on their approach."""
    z = np.linspace(-0.5, 0.5, strips) * gibs.length
    dz = gibs.length / (strips - 1)

    def resultants(rise, tilt):
        p = rise + tilt * z
        p = np.maximum(p, 0) if gibs.one_sided else p
        weights = np.full(strips, dz)
        weights[[0, -1]] /= 2
        return gibs.width * (p @ weights), gibs.width * ((p * z) @ weights), p

    if not gibs.one_sided:
        rise, tilt = n / (gibs.length * gibs.width), 12 * m / (gibs.width * gibs.length**3)
    else:  # the contact begins at z0: the eccentricity of a triangle or trapezium over what is left rises with z0
        low, high = -50 * gibs.length, 0.499 * gibs.length
        for _ in range(50):
            z0 = 0.5 * (low + high)
            force, moment, _ = resultants(-z0, 1.0)
            low, high = (z0, high) if moment / force < m / n else (low, z0)
        tilt = n / resultants(-z0, 1.0)[0]
        rise = -z0 * tilt
    force, moment, p = resultants(rise, tilt)
    np.testing.assert_allclose([force, moment], [n, m], rtol=1e-6)
    return p.max(), np.mean(p > 0)


@pytest.mark.parametrize(("name", "axis"), [("crank_slide", 0), ("zxn2_3000b", 0), ("thin_wall", 2)])  # the last one lies
def test_gibs_of_a_planar_press_face_along_its_plane(name, axis):
    """Left out, the normal is the direction across the guide in the plane, its largest component positive."""
    press = shipped(name)
    given, default = Gibs(0.3, 0.1, normal=tuple(np.eye(3)[axis])), Gibs(0.3, 0.1)
    loads = [eccentric_load(press, at(press), force=FORCE, offset=0.02 * np.eye(3)[axis], gibs=gibs) for gibs in (given, default)]
    np.testing.assert_array_equal(loads[1].normal_force, loads[0].normal_force)
    np.testing.assert_array_equal(loads[1].tilting, loads[0].tilting)
    np.testing.assert_allclose(loads[1].normal_force, loads[1].force[:, axis], rtol=1e-14)
    assert np.abs(loads[1].normal_force).max() > 1.0
    least, most = permissible_eccentricity(press, at(press), force=FORCE, gibs=default, pressure=2e8)
    assert (least, most) == permissible_eccentricity(press, at(press), force=FORCE, gibs=given, pressure=2e8)
    for offset in (least, most):
        assert eccentric_load(press, at(press), force=FORCE, offset=offset * np.eye(3)[axis], gibs=default).pressure.max() == pytest.approx(
            2e8, rel=1e-9
        )


def test_gibs_of_a_press_that_leans():
    """By 0.2 rad about y, its guide with it: the gibs face 0.2 rad below x."""
    press = bolted(shipped("crank_slide"), "0 0.2 0")
    upright = eccentric_load(shipped("crank_slide"), at(shipped("crank_slide")), force=FORCE, offset=(0.02, 0.0, 0.0), gibs=Gibs(0.3, 0.1))
    leaning = eccentric_load(press, at(press), force=FORCE, offset=(0.02, 0.0, 0.0), gibs=Gibs(0.3, 0.1))
    np.testing.assert_allclose(leaning.normal_force, upright.normal_force, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(leaning.normal_force, leaning.force @ [np.cos(0.2), 0.0, -np.sin(0.2)], rtol=1e-9, atol=1e-6)


def test_guide_of_the_crank_slide():
    """The rod's lateral force F tan(phi) and the tilting moment F e both go into the guide: the rod's pin holds no moment."""
    press = shipped("crank_slide")
    found = eccentric_load(press, at(press), force=FORCE, offset=(0.02, 0.0, 0.5), gibs=Gibs(0.3, 0.1))
    sine = LAM * np.sin(ANGLES)
    lateral = FORCE * sine / np.sqrt(1 - sine**2)
    assert found.guide == "slide_guide"
    np.testing.assert_allclose(found.tilting_moment, [0, -FORCE * 0.02, 0], atol=1e-9)  # r x F = (e, 0, .) x (0, 0, F)
    np.testing.assert_allclose(np.abs(found.force[:, 0]), np.abs(lateral), rtol=1e-10, atol=1e-6)
    np.testing.assert_allclose(found.force[:, 1:], 0.0, atol=1e-6)
    np.testing.assert_allclose(found.moment, np.tile([0, FORCE * 0.02, 0], (len(ANGLES), 1)), atol=1e-6)
    np.testing.assert_allclose(found.pressure, np.abs(lateral) / 0.03 + 6 * FORCE * 0.02 / (0.1 * 0.3**2), rtol=1e-10)
    assert np.all(found.contact == 1)
    assert not found.indeterminate


@pytest.mark.parametrize("middle", [-0.1, 0.15])
def test_gibs_beside_the_slides_origin(middle):
    """The lateral force at the origin has a lever about gibs above or below it."""
    press = shipped("crank_slide")
    found = eccentric_load(press, at(press), force=FORCE, offset=(0.02, 0, 0), gibs=Gibs(0.3, 0.1, middle=middle))
    central = eccentric_load(press, at(press), force=FORCE, offset=(0.02, 0, 0), gibs=Gibs(0.3, 0.1))
    # about the middle M' = M - d x R with d = (0, 0, middle), R = (N, 0, 0)
    np.testing.assert_allclose(found.moment[:, 1], central.moment[:, 1] - middle * central.force[:, 0], rtol=1e-10)


def test_out_of_the_plane():
    """A force in front of the plane tilts the slide about x: only gibs that face y feel it."""
    press = shipped("crank_slide")
    front = eccentric_load(press, at(press), force=FORCE, offset=(0, 0.03, 0), gibs=Gibs(0.3, 0.2, normal=(0, 2, 0)))
    np.testing.assert_allclose(front.moment, np.tile([-FORCE * 0.03, 0, 0], (len(ANGLES), 1)), atol=1e-6)
    np.testing.assert_allclose(front.pressure, 6 * FORCE * 0.03 / (0.2 * 0.3**2), rtol=1e-10)
    side = eccentric_load(press, at(press), force=FORCE, offset=(0, 0.03, 0), gibs=Gibs(0.3, 0.2))
    np.testing.assert_allclose(side.tilting, 0.0, atol=1e-6)


def test_two_points_share_the_tilting_moment_with_the_guide():
    press = shipped("jf75g_125_two_point")
    assert eccentric_load(press, at(press), force=FORCE, offset=(0, 0.03, 0), gibs=Gibs(0.3, 0.2, normal=(0, 1, 0))).indeterminate
    assert not eccentric_load(press, at(press), force=FORCE, offset=(0.03, 0, 0), gibs=Gibs(0.3, 0.2)).indeterminate


@pytest.mark.parametrize(
    ("name", "offset"), [("zxn2_3000b", (0.05, 0.0, 0.0)), ("thin_wall", (0.0, 0.01, 0.02)), ("jf75g_125", (0.01, 0, 0))]
)
def test_both_engines_agree(name, offset):
    press = shipped(name)
    one, other = (
        eccentric_load(press, at(press), force=FORCE, offset=offset, gibs=Gibs(0.3, 0.2), engine=e) for e in ("plane", "pinocchio")
    )
    for field in ("force", "moment", "pressure", "tilting_moment"):
        np.testing.assert_allclose(getattr(one, field), getattr(other, field), rtol=1e-9, atol=1e-6 * FORCE)


def test_the_guide_of_a_press_works_like_its_links():
    """Statics of the six-bar's slide alone: the pin of its rod pushes along EF."""
    press = shipped("zxn2_3000b")
    motion = at(press)
    found = eccentric_load(press, motion, force=FORCE, offset=(0.04, 0, 0), gibs=Gibs(0.5, 0.2))
    pins = pp.measures.bearing_positions(press, motion)
    rod = pins["F"] - pins["E"]
    lateral = FORCE * rod[:, 0] / rod[:, 2]  # the force in the rod is along it; its vertical part holds the process force
    np.testing.assert_allclose(found.normal_force, lateral, rtol=1e-9)


# Pressures


@pytest.mark.parametrize("share", [0.05, 0.15, 0.17, 0.3, 0.45])
@pytest.mark.parametrize("one_sided", [False, True])
def test_pressures_are_those_of_elastic_strips(share, one_sided):
    """At one state of the crank-slider, moved to an eccentricity M / N of a share of the length."""
    press = shipped("crank_slide")
    gibs = Gibs(0.3, 0.1, one_sided=one_sided)
    state = at(press, np.array([1.3]))
    n = abs(eccentric_load(press, state, force=FORCE, offset=(0, 0, 0), gibs=gibs).normal_force[0])
    found = eccentric_load(press, state, force=FORCE, offset=(share * gibs.length * n / FORCE, 0, 0), gibs=gibs)
    peak, contact = by_strips(gibs, n, share * gibs.length * n)
    np.testing.assert_allclose(found.pressure, peak, rtol=8e-4)  # a strip is 2e-4 of the length
    if one_sided:
        np.testing.assert_allclose(found.contact, contact, atol=4e-4)


def test_a_single_gib_tips():
    press = shipped("crank_slide")
    gibs = Gibs(0.3, 0.1, one_sided=True)
    state = at(press, np.array([1.3]))
    n = abs(eccentric_load(press, state, force=FORCE, offset=(0, 0, 0), gibs=gibs).normal_force[0])
    with pytest.raises(pp.PinpressError, match=r"tips at crank angle 74\.48"):
        eccentric_load(press, state, force=FORCE, offset=(0.51 * gibs.length * n / FORCE, 0, 0), gibs=gibs)
    with pytest.raises(pp.PinpressError, match="permit no eccentricity"):
        permissible_eccentricity(
            press, at(press, np.array([0.0])), force=FORCE, gibs=gibs, pressure=1e8
        )  # no lateral force at the dead centre


# Permissible eccentricity


@pytest.mark.parametrize("one_sided", [False, True])
@pytest.mark.parametrize("middle", [0.0, 0.05])
@pytest.mark.parametrize("pressure", [2e6, 4e6])
def test_the_permissible_eccentricity_just_reaches_the_pressure(one_sided, middle, pressure):
    press = shipped("crank_slide")
    gibs = Gibs(0.3, 0.1, middle=middle, one_sided=one_sided)
    motion = at(press, np.array([0.8, 1.0, 1.3]))
    left, right = permissible_eccentricity(press, motion, force=FORCE, gibs=gibs, pressure=pressure)
    assert left < 0 < right
    for edge in (left, right):
        found = eccentric_load(press, motion, force=FORCE, offset=(edge * (1 - 1e-12), 0, 0), gibs=gibs)
        np.testing.assert_allclose(found.pressure.max(), pressure, rtol=1e-9)
        assert eccentric_load(press, motion, force=FORCE, offset=(edge * 1.001, 0, 0), gibs=gibs).pressure.max() > pressure
    if middle == 0:
        np.testing.assert_allclose(left, -right, rtol=1e-9)


def test_closed_form_of_the_permissible_eccentricity():
    """At a dead centre the guide holds F e alone: e = p L^2 b / (6 F)."""
    press = shipped("crank_slide")
    edges = permissible_eccentricity(press, at(press, np.array([0.0])), force=FORCE, gibs=Gibs(0.3, 0.1), pressure=2e6)
    np.testing.assert_allclose(edges, np.array([-1, 1]) * 2e6 * 0.3**2 * 0.1 / (6 * FORCE), rtol=1e-9)


def test_too_much_for_the_gibs():
    press = shipped("crank_slide")
    with pytest.raises(pp.PinpressError, match=r"at crank angle 74\.48.* deg the gibs permit no eccentricity"):
        permissible_eccentricity(press, at(press, np.array([0.1, 1.3])), force=FORCE, gibs=Gibs(0.3, 0.1), pressure=5e5)


# Bad input


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"length": 0.0}, "length is 0.0"),
        ({"width": np.nan}, "width is nan"),
        ({"normal": (0, 0, 0)}, r"normal is \(0, 0, 0\): give a direction"),
        ({"normal": (1, 0)}, "three finite numbers"),
        ({"middle": np.inf}, "middle is inf"),
    ],
)
def test_bad_gibs(changed, words):
    with pytest.raises(pp.PinpressError, match=words):
        Gibs(**{"length": 0.3, "width": 0.1} | changed)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"force": -1.0}, "force is -1.0"),
        ({"offset": 0.02}, "offset is 0.02"),
        ({"gibs": 0.3}, "gibs is a float"),
        ({"motion": None}, "motion is a NoneType"),
        ({"press": None}, "press is a NoneType"),
        ({"gibs": Gibs(0.3, 0.1, normal=(1, 0, 1))}, "not across the guide's axis"),
    ],
)
def test_bad_arguments(changed, words):
    press = shipped("crank_slide")
    given = {"press": press, "motion": at(press), "force": FORCE, "offset": (0, 0, 0), "gibs": Gibs(0.3, 0.1)}
    with pytest.raises(pp.PinpressError, match=words):
        eccentric_load(**given | changed)
    given = {"press": press, "motion": at(press), "force": FORCE, "gibs": Gibs(0.3, 0.1), "pressure": 1e7}
    if "offset" not in changed:
        with pytest.raises(pp.PinpressError, match=words):
            permissible_eccentricity(**given | changed)


def test_a_linkage_without_a_slide():
    press = dataclasses.replace(shipped("crank_slide"), slide=None)
    with pytest.raises(pp.PinpressError, match="has no slide"):
        eccentric_load(press, at(shipped("crank_slide")), force=FORCE, offset=(0, 0, 0), gibs=Gibs(0.3, 0.1))
