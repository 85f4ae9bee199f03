"""The classical arrangements against closed forms, the shipped presses, and what each of them promises of the shaking force.

Crank-slides are drawn at random: in any plane, at any crank angle, with the slide in any direction, either sense of the crank, either tree,
centres of mass off the pins' lines and off the plane, joint frames turned about.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import make
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import texts
from support.exploring import examples
from support.generators.random_linkages import Drawing, four_bar

import pinpress as pp
from pinpress.balancing import classical, with_counterweights
from pinpress.balancing.classical import mirrored, with_opposed_balancer

ROOT = Path(__file__).resolve().parents[2]
ROUNDING = 1e-12  # of the forces of the press before: sums of forces that cancel
W = 300 * pp.RPM
FIXED = examples(3)
SEEDS = st.integers(0, 2**32 - 1)
SERVO = {"angle": np.linspace(-5, 6, 40), "speed": 20 * np.cos(np.linspace(0, 7, 40)), "acceleration": 500 * np.sin(np.linspace(1, 9, 40))}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("presses")


def loaded(drawing, folder, driver="O", **options):
    file = folder / f"{drawing.name}.urdf"
    file.write_text(drawing.urdf(driver), encoding="utf-8")
    return pp.load(file, **options)


def drawn(seed, on_line=False, offset=0.0, ratio=None):
    """A random crank-slider and what it is drawn from. ``on_line``: centres of mass on the lines of the pins; ``offset`` [m] of the slide's
    pin from the shaft; ``ratio`` of crank and rod."""
    rng = np.random.default_rng(seed)
    world = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    sizes: dict[str, Any] = {
        "crank_radius": rng.uniform(0.01, 0.2),
        "crank_mass": rng.uniform(1, 50),
        "rod_mass": rng.uniform(1, 80),
        "slide_mass": rng.uniform(1, 500),
        "drawn_angle": rng.uniform(-3, 3),
    }
    r, towards, sense = sizes["crank_radius"], np.exp(1j * rng.uniform(-3, 3)), rng.choice([-1, 1])
    length = sizes["rod_length"] = r / (ratio or rng.uniform(0.02, 0.9))
    beside = 0.0 if on_line else 1.0
    sizes["crank_centre"] = r * complex(rng.uniform(-1, 1), beside * rng.uniform(-1, 1))
    sizes["rod_centre"] = length * complex(rng.uniform(-0.2, 1.2), beside * rng.uniform(-0.3, 0.3))
    with_sense = np.conj if sense < 0 else np.asarray  # numbers of a CrankSlider turn with the crank
    crank_pin = r * np.exp(1j * sense * sizes["drawn_angle"])
    slide_pin = crank_pin.real + np.sqrt(length**2 - (crank_pin.imag - offset) ** 2) + 1j * offset
    drawing = Drawing("drawn", world if np.linalg.det(world) > 0 else -world)
    drawing.joint("O", "frame", "crank", 0j, sense=sense, rpy=rng.uniform(-3, 3, 3))
    drawing.joint("guide", "frame", "slide", towards * slide_pin, along=rng.choice([-1, 1]) * towards)
    if rng.integers(2):
        drawing.joint("P", "crank", "rod", towards * crank_pin, rpy=rng.uniform(-3, 3, 3))
        drawing.loop("C", "rod", "slide", towards * slide_pin)
    else:
        drawing.joint("C", "slide", "rod", towards * slide_pin, rpy=rng.uniform(-3, 3, 3))
        drawing.loop("P", "rod", "crank", towards * crank_pin)
    line = (slide_pin - crank_pin) / length
    inertias = {"crank_inertia": sizes["crank_mass"] * r**2, "rod_inertia": sizes["rod_mass"] * length**2 / 9}
    solid = np.array([[0.8, 0.0, 0.1], [0.0, 0.9, -0.15], [0.1, -0.15, 1.0]])
    tensors = {name: solid * value for name, value in inertias.items()}
    crank_centre, rod_centre = (with_sense(sizes[name]) for name in ("crank_centre", "rod_centre"))
    drawing.body("crank", sizes["crank_mass"], towards * crank_centre * crank_pin / r, 0.05 * r, tensors["crank_inertia"])
    drawing.body("rod", sizes["rod_mass"], towards * (crank_pin + rod_centre * line), -0.1 * r, tensors["rod_inertia"])
    drawing.body("slide", sizes["slide_mass"], towards * (slide_pin + 0.1 * length), 0.1 * r)
    return drawing, sizes | inertias


def drawn_press(seed, folder, on_line=False):
    rng = np.random.default_rng(seed + 1)
    return loaded(drawn(seed, on_line)[0], folder, gravity=rng.uniform(-10, 10, 3))


def turn(press, speed=W, points=24, loads=()):
    return pp.inverse_dynamics(press, pp.cycle(press, speed, points=points), loads)


def servo(press):
    return pp.inverse_dynamics(press, pp.servo_cycle(press, **SERVO))


def weight(press):
    return mass(press) * press.model.gravity.linear


def mass(press):
    return sum(inertia.mass for inertia in press.model.inertias)


def peak(*results):
    """The largest component of any bearing force [N]."""
    return max(np.abs(force).max() for result in results for force in result.bearing_force.values())


def along_and_across(press, result):
    """Shaking force less weight along the slide's line, away from the shaft positive, and across it."""
    main = classical.as_crank_slider(press)
    force = result.shaking_force - weight(press)
    return force @ main.direction, force @ main.across


# ------------------------------------------------------------------------------------------------------------------- reading a crank-slider


@FIXED
@given(SEEDS)
def test_a_crank_slide_is_read_as_it_was_drawn(folder, seed):
    """To rounding: lengths are differences of positions of their own size."""
    drawing, sizes = drawn(seed)
    found = classical.as_crank_slider(loaded(drawing, folder))
    for name, value in sizes.items():
        assert getattr(found, name) == pytest.approx(value, rel=1e-12, abs=1e-13), name
    assert (found.crank, found.rod, found.slide) == ("crank", "rod", "slide")


def test_the_jf75g_125_is_read():
    """52.25 kg at the pin and half of 77.49 kg turn with it, 2200 kg and the other half go up and down; a uniform rod."""
    main = classical.as_crank_slider(texts.shipped("jf75g_125_plain"))
    assert (main.crank_radius, main.rod_length, main.ratio) == pytest.approx((0.015, 0.3, 0.05), rel=1e-14)
    assert main.rotating_product == pytest.approx((52.25 + 77.49 / 2) * 0.015, rel=1e-14)
    assert main.reciprocating_mass == pytest.approx(2200 + 77.49 / 2, rel=1e-14)
    assert main.residual_inertia == pytest.approx(-77.49 * 0.3**2 / 6, rel=1e-13)
    np.testing.assert_array_equal([main.direction, main.across], [[0, 0, -1], [1, 0, 0]])


def test_what_differs_from_a_crank_slide_is_named(folder):
    sizes = drawn(3)[1]
    rocker, driven_rod, beside = four_bar(1.0, 0.3, 0.9, 0.8, 0.5), drawn(3)[0], drawn(3, offset=1e-4)[0]
    (rod_pin,) = {joint[0] for joint in driven_rod.joints} & {"P", "C"}
    for press, said in (
        (loaded(rocker, folder), "its joints are not pins and one guide on the frame"),
        (loaded(driven_rod, folder, driver=rod_pin), f"its driver {rod_pin!r} does not turn on the frame"),
        (loaded(beside, folder), "the line of its slide's pin passes the shaft at 0.0001 m"),
        (loaded(drawn(3, ratio=1.5)[0], folder), f"its crank, {sizes['crank_radius']:.6g} m, is not shorter than its rod"),
        (loaded(apart(), folder), "its third link, 'rod', does not connect crank and slide"),
    ):
        with pytest.raises(pp.PinpressError, match=f"is not a centred crank-slider: {said}"):
            classical.as_crank_slider(press)


def apart():
    """A crank that turns alone, beside a slide and a rod that hold each other."""
    drawing = Drawing("apart")
    drawing.joint("O", "frame", "crank", 0j)
    drawing.joint("D", "frame", "rod", 1 + 0j)
    drawing.joint("guide", "frame", "slide", 0.5 + 0.5j, along=1 + 0j)
    drawing.loop("C", "rod", "slide", 0.5 + 0.5j)
    for link in ("crank", "rod", "slide"):
        drawing.body(link, 1.0, 0j)
    return drawing


# ---------------------------------------------------------------------------------------------------------------------------- harmonics


@pytest.mark.parametrize("ratio", [1e-3, 0.05, 0.25, 0.5, 0.9])
def test_harmonic_coefficients_are_those_of_the_exact_acceleration(ratio):
    """r w^2 (...) by Fourier transform of - d2/dq2 (cos q + sqrt(1 - lambda^2 sin^2 q) / lambda), which 512 samples resolve."""
    q = np.arange(512) * (2 * np.pi / 512)
    root = np.sqrt(1 - (ratio * np.sin(q)) ** 2)
    second = -np.cos(q) - ratio * (np.cos(2 * q) * root**2 + (ratio * np.sin(q) * np.cos(q)) ** 2) / root**3
    expected = -2 * np.fft.rfft(second).real[:21] / 512
    np.testing.assert_allclose(classical.harmonic_coefficients(ratio, 20), expected, atol=1e-14)


def test_harmonic_coefficients_begin_like_the_textbooks_series():
    """Each to the order of the first term left out."""
    lam = 0.01
    found = classical.harmonic_coefficients(lam)
    assert found[2] == pytest.approx(lam + lam**3 / 4 + 15 * lam**5 / 128, rel=lam**6)
    assert found[4] == pytest.approx(-(lam**3) / 4 - 3 * lam**5 / 16, rel=lam**4)
    assert found[6] == pytest.approx(9 * lam**5 / 128, rel=3 * lam**2)
    np.testing.assert_array_equal(found[[0, 1, 3, 5]], [0, 1, 0, 0])


def test_slide_accelerates_by_the_harmonics():
    """The textbook crank-slider at bottom dead centre, upwards positive: r w^2 (1 + A2 + A4 + ...), lambda = 0.25."""
    press = texts.shipped("crank_slide")
    motion = pp.cycle(press, W, points=64)
    waves = np.cos(np.multiply.outer(motion.crank_angle, np.arange(41)))
    expected = 0.1 * W**2 * waves @ classical.harmonic_coefficients(0.25, 40)
    np.testing.assert_allclose(motion.slide_acceleration, expected, atol=1e-12 * np.abs(expected).max())


# ----------------------------------------------------------------------------------------------------------------- complete, approximate


@FIXED
@given(SEEDS)
def test_complete_balance_fixes_the_centre_of_mass(folder, seed):
    """To 1e-12 of the stroke, and so the shaking force is the weight, whatever the crank does."""
    press = drawn_press(seed, folder)
    radius = classical.as_crank_slider(press).crank_radius
    balanced = with_counterweights(press, classical.complete_balance(press, rod_radius=2 * radius, crank_radius=1.5 * radius))
    result = servo(balanced)
    model, data = balanced.model, balanced.model.createData()
    centres = np.array([pin.centerOfMass(model, data, q).copy() for q in result.motion.q])
    assert np.ptp(centres, axis=0).max() <= 1e-12 * 2 * radius
    # Rounding is that of the balanced press' own forces: with its counterweights it is several times as heavy as before.
    assert np.abs(result.shaking_force - weight(balanced)).max() <= ROUNDING * peak(result)


def test_complete_balance_of_the_jf75g_125():
    """m'' = (m2 h2 + m3 l2) / r2, m' = (m_B l1 + m1 h1) / r1; with the thesis' m2 for m_B the centre of mass would not stand still."""
    press = texts.shipped("jf75g_125_plain")
    on_rod, on_crank = classical.complete_balance(press, rod_radius=0.2, crank_radius=0.1)
    m_b = (77.49 * 0.15 + 2200 * 0.3) / 0.2 + 77.49 + 2200
    assert on_rod.mass == pytest.approx(m_b - 2277.49, rel=1e-14)
    assert on_crank.mass == pytest.approx((m_b * 0.015 + 52.25 * 0.015) / 0.1, rel=1e-14)
    assert (on_rod.link, on_crank.link) == ("main_rod", "crank")
    np.testing.assert_allclose([on_rod.position, on_crank.position], [[-0.2, 0, 0], [-0.1, 0, 0]], atol=1e-15)
    printed = replace(on_crank, mass=(77.49 * 0.015 + 52.25 * 0.015) / 0.1)
    shaking = turn(with_counterweights(press, [on_rod, printed])).shaking_force
    assert np.ptp(shaking[:, 2]) > np.ptp(turn(press).shaking_force[:, 2])


@FIXED
@given(SEEDS, st.floats(0, 1))
def test_approximate_balance_leaves_what_it_says(folder, seed, share):
    """m_C r w^2 ((1 - share) cos q + A2 cos 2q + ... - i share sin q), as a complex number along the slide's line and across it."""
    press = drawn_press(seed, folder)
    main = classical.as_crank_slider(press)
    balanced = with_counterweights(press, [classical.approximate_balance(press, 0.1, share=share)])
    result = turn(balanced, points=120)
    along, across = along_and_across(balanced, result)
    q = result.motion.crank_angle + main.drawn_angle
    waves = np.cos(np.multiply.outer(q, np.arange(401))) @ classical.harmonic_coefficients(main.ratio, 400)
    left = main.reciprocating_mass * main.crank_radius * W**2 * (waves - share * np.exp(1j * q))
    np.testing.assert_allclose(along + 1j * across, left, atol=ROUNDING * peak(result))


def test_approximate_balance_halves_the_first_order_of_the_jf75g_125():
    press = texts.shipped("jf75g_125_plain")
    result = turn(with_counterweights(press, [classical.approximate_balance(press, 0.15)]))
    first = pp.measures.harmonics(result.motion, result.shaking_force).amplitude[1]
    expected = 0.5 * (2200 + 77.49 / 2) * 0.015 * W**2
    np.testing.assert_allclose(first[[0, 2]], expected, rtol=1e-12)


# ----------------------------------------------------------------------------------------------------------------------------- opposed


@FIXED
@given(SEEDS, st.floats(0.4, 3.0), st.floats(0.3, 3.0))
def test_opposed_with_the_same_ratio_leaves_the_weight_alone(folder, seed, scale, heavier):
    """For rods of any mass and whatever the crank does."""
    press = drawn_press(seed, folder)
    main = classical.as_crank_slider(press)
    # a rod whose far end is no heavier than the main slide's side, which would leave nothing for the counterweight
    rod = min(heavier * main.rod_mass, 0.9 * abs(main.reciprocating_mass.real / (main.rod_share.real or 1))) / scale
    balanced = with_opposed_balancer(press, scale * main.crank_radius, rod_mass=rod)
    result = servo(balanced)
    assert np.abs(result.shaking_force - weight(balanced)).max() <= ROUNDING * peak(result)
    assert np.abs(result.power_residual).max() < 1e-12


@FIXED
@given(SEEDS)
def test_opposed_leaves_the_main_crank_slide_as_it_was(folder, seed):
    """Its motion, and the forces in crank pin, slide pin and guide, to rounding."""
    press = drawn_press(seed, folder)
    before, after = servo(press), servo(with_opposed_balancer(press, 0.1))
    assert after.motion.slide_position == pytest.approx(before.motion.slide_position, rel=0, abs=1e-13)
    normal = press.engine("plane").plane.normal
    in_plane = np.eye(3) - np.outer(normal, normal)  # across it, rigid mechanics leaves open what a loop bears
    for name in ("P", "C", "guide"):
        force, expected = after.bearing_force[name] @ in_plane, before.bearing_force[name] @ in_plane
        np.testing.assert_allclose(force, expected, atol=ROUNDING * peak(before))


@FIXED
@given(SEEDS, st.floats(0.4, 3.0))
def test_opposed_leaves_the_tilting_moment_of_the_rods_inertia(folder, seed, scale):
    """- (J1 + J2) phi'' - J_crank q'' in closed form, J2 = J1 r2 / r1; none at constant speed where the auxiliary rod's J2 is - J1.

    About the shaft, less its mean: the weight's moment, constant as the centre of mass stands still.
    """
    press = drawn_press(seed, folder, on_line=True)
    main = classical.as_crank_slider(press)
    normal, radius, share = np.cross(main.direction, main.across), scale * main.crank_radius, main.rod_share.real
    result = servo(with_opposed_balancer(press, radius))
    found = (result.shaking_moment - np.cross(main.shaft, result.shaking_force)) @ normal
    q, w, a = result.motion.crank_angle + main.drawn_angle, result.motion.crank_speed, result.motion.crank_acceleration
    sine = main.ratio * np.sin(q)  # of the rods' angle phi, against the crank
    phi1 = main.ratio * np.cos(q) / np.sqrt(1 - sine**2)
    phi2 = sine * (phi1**2 - 1) / np.sqrt(1 - sine**2)
    turning = main.crank_inertia + main.crank_mass * abs(main.crank_centre) ** 2 + main.rod_mass * (1 - share) * main.crank_radius**2
    expected = (1 + scale) * (main.residual_inertia * (phi1 * a + phi2 * w**2) - turning * a)
    least = ROUNDING * peak(result) * press.size
    np.testing.assert_allclose(found - found.mean(), expected - expected.mean(), atol=least)
    without = main.rod_mass * scale * main.rod_length**2 * share * (1 - share) - main.residual_inertia
    if without > 0:
        assert np.ptp(turn(with_opposed_balancer(press, radius, rod_inertia=without)).shaking_moment @ normal) <= least


def test_opposed_with_another_ratio_leaves_the_even_orders():
    """m_C r1 w^2 |A_k(lambda1) - A_k(lambda2)| along the line, nothing across it."""
    press = texts.shipped("jf75g_125_plain", gravity=(0, 0, 0))
    result = turn(with_opposed_balancer(press, crank_radius=0.0297, rod_length=0.45), points=64)
    found = pp.measures.harmonics(result.motion, result.shaking_force).amplitude
    one, other = (classical.harmonic_coefficients(ratio, 12) for ratio in (0.05, 0.0297 / 0.45))
    expected = (2200 + 77.49 / 2) * 0.015 * W**2 * np.abs(one - other)
    np.testing.assert_allclose(found[:, 2], expected, atol=ROUNDING * 35e3)
    assert np.abs(found[:, [0, 1]]).max() <= ROUNDING * 35e3


@pytest.mark.parametrize("rod_mass", [None, 113.31])
def test_opposed_keeps_the_balance_condition_of_the_shipped_press(rod_mass):
    """(m1 + m2 + m3) r1 = (m4 + m5 + m6) r2, from which the shipped r2 = 0.0297 m was rounded (to 0.0297 of 0.029699), with the mass moment
    of the crank for (m1 r1 - m4 r2); exactly. The shipped press' 119.06 N and its 1705 N across become rounding."""
    plain, shipped = texts.shipped("jf75g_125_plain"), texts.shipped("jf75g_125")
    press = with_opposed_balancer(plain, 0.0297, rod_mass=rod_mass)

    def products(of):
        """Of main side and auxiliary side, less what of the crank is common."""
        bodies = {link: of.model.inertias[of.model.frames[of.model.getFrameId(link)].parentJoint] for link in of.links[1:]}
        crank = bodies["crank"].mass * bodies["crank"].lever[0]
        main = (bodies["main_rod"].mass + bodies["slide"].mass) * 0.015
        return main + crank, (bodies["auxiliary_rod"].mass + bodies["counterweight"].mass) * 0.0297

    assert products(press)[0] == pytest.approx(products(press)[1], rel=1e-14)
    assert products(shipped)[0] == pytest.approx(products(shipped)[1], rel=5e-5)
    ranges = [np.ptp(turn(each, points=360).shaking_force, axis=0) for each in (shipped, press)]
    assert ranges[0][[0, 2]] == pytest.approx([1704.7, 119.06], rel=1e-4)
    assert ranges[1].max() <= ROUNDING * 70e3


# --------------------------------------------------------------------------------------------------------------------------- symmetric


@pytest.mark.one_in(3)
@pytest.mark.parametrize("orders", [(1, 2), (2,), (1, 4)])
@FIXED
@given(seed=SEEDS)
def test_balance_shafts_leave_the_other_orders_along_the_slide(folder, seed, orders):
    """Any plane, drawn angle and sense, also with centres of mass off the pins' lines: m_C r w^2 A_k of the orders without a pair."""
    press = loaded(drawn(seed)[0], folder)
    main = classical.as_crank_slider(press)
    shafts = classical.with_balance_shafts(press, radius=0.1, shaft_distance=0.7, orders=orders)
    motion = pp.cycle(shafts, W, points=96)
    result = pp.inverse_dynamics(shafts, motion)
    theta = main.drawn_angle + motion.crank_angle
    coefficients = classical.harmonic_coefficients(main.ratio, 40)
    series = sum(coefficients[k] * np.cos(k * theta) for k in (1, *range(2, 41, 2)) if k not in orders)
    left = main.crank_radius * W**2 * series * main.reciprocating_mass
    expected = np.outer(left.real, main.direction) + np.outer(left.imag, main.across)
    force = result.shaking_force - result.shaking_force.mean(axis=0)
    before = pp.inverse_dynamics(press, pp.cycle(press, W, points=96))
    size = max(np.abs(each).max() for each in before.bearing_force.values())
    tail = 10 * main.crank_radius * W**2 * abs(main.reciprocating_mass) * main.ratio**20  # of the series
    np.testing.assert_allclose(force, expected - expected.mean(axis=0), rtol=0, atol=1e-11 * size + tail)
    np.testing.assert_allclose(result.driving_torque.mean(), before.driving_torque.mean(), rtol=0, atol=1e-9 * size)


def test_balance_shafts_of_the_jf75g_125():
    """By hand: m_C = 2200 + 77.49 / 2 kg, r = 15 mm, lambda = 0.05; no moment, and masses of m_C r A_k / (2 k^2 R)."""
    plain = texts.shipped("jf75g_125_plain")
    shafts = classical.with_balance_shafts(plain, radius=0.15, shaft_distance=0.8)
    coefficients = classical.harmonic_coefficients(0.05, 4)
    masses = {name: inertia.mass for name, inertia in zip(shafts.model.names, shafts.model.inertias, strict=True) if "balance" in name}
    assert list(masses) == [f"balance_shaft_{order}_{side}_bearing" for order in (1, 2) for side in ("left", "right")]
    reciprocating = 2200 + 77.49 / 2
    for order in (1, 2):
        expected = reciprocating * 0.015 * coefficients[order] / (2 * order**2 * 0.15)
        assert masses[f"balance_shaft_{order}_left_bearing"] == pytest.approx(expected, rel=1e-12)
        assert masses[f"balance_shaft_{order}_right_bearing"] == pytest.approx(expected, rel=1e-12)
    assert sum(masses.values()) == pytest.approx(2 * 111.937 + 2 * 1.4001, rel=1e-4)
    before, after = (pp.inverse_dynamics(press, pp.cycle(press, W, points=96)) for press in (plain, shafts))
    changes = {(c.quantity, c.order): c.change for c in classical.compare_harmonics(before, after)}
    assert [changes["force along the slide", order] for order in (1, 2, 4)] == ["cancelled", "cancelled", "unchanged"]
    assert changes["force across the slide", 1] == "cancelled"
    rotating = pp.inverse_dynamics(
        changed := with_counterweights(plain, [classical.approximate_balance(plain, 0.15, share=0.0)]), pp.cycle(changed, W, points=96)
    )
    np.testing.assert_allclose(np.ptp(after.shaking_moment[:, 1]), np.ptp(rotating.shaking_moment[:, 1]), rtol=1e-9)
    pinocchio = pp.inverse_dynamics(shafts, pp.cycle(shafts, W, points=24), engine="pinocchio")
    plane = pp.inverse_dynamics(shafts, pp.cycle(shafts, W, points=24), engine="plane")
    np.testing.assert_allclose(pinocchio.shaking_force, plane.shaking_force, rtol=0, atol=1e-9)


def test_mirrored_with_blocks_is_the_shipped_press_of_eccentric_blocks():
    """Zhang 2007, Fig. 1-2: `approximate_balance` with the share 1, on both of two mirrored cranks. The blocks of the shipped press balance
    the slide and the whole of both rods at their crank pins, which is the same sum."""
    plain, shipped = texts.shipped("jf75g_125_plain"), texts.shipped("eccentric_blocks")
    blocks = with_counterweights(plain, [classical.approximate_balance(plain, 0.15, share=1.0)])
    made = mirrored(blocks, 0.5)
    ours, theirs = (pp.inverse_dynamics(press, pp.cycle(press, W, points=72)) for press in (made, shipped))
    size = np.abs(theirs.bearing_force["O_left"]).max()
    np.testing.assert_allclose(ours.shaking_force, theirs.shaking_force, rtol=0, atol=2e-6 * size)  # the block's mass has six digits
    force = theirs.shaking_force[:, 2]
    harmonic = np.abs(np.fft.rfft(force)) / len(force) * 2
    coefficients = classical.harmonic_coefficients(0.05, 2)
    assert harmonic[1] < 1e-5 * harmonic[2]
    assert harmonic[2] == pytest.approx((2200 + 77.49 / 2) * 0.015 * W**2 * coefficients[2], rel=1e-9)


def test_opposed_with_a_die_leaves_the_weight_alone():
    """Zhang 2007, 3.5: (m6 + m4 e4 / L4) L2 = (m5 + m7 + m3 e3 / L3) L1."""
    plain = texts.shipped("jf75g_125_plain")
    opposed = with_opposed_balancer(plain, 0.0297, die_mass=350.0)
    masses = {name: inertia.mass for name, inertia in zip(opposed.model.names, opposed.model.inertias, strict=True)}
    assert masses["slide_guide"] == pytest.approx(2550.0, rel=1e-14)
    rod = 77.49 * 0.015 / 0.0297
    assert (masses["counterweight_guide"] + rod / 2) * 0.0297 == pytest.approx((2200 + 350 + 77.49 / 2) * 0.015, rel=1e-12)
    result = pp.inverse_dynamics(opposed, pp.cycle(opposed, W, points=72))
    size = max(np.abs(each).max() for each in result.bearing_force.values())
    assert np.ptp(result.shaking_force, axis=0).max() < ROUNDING * size * 10
    with pytest.raises(pp.PinpressError, match="die_mass is -1"):
        with_opposed_balancer(plain, 0.0297, die_mass=-1)


def test_symmetric_of_the_shipped_press_is_the_shipped_symmetric_one():
    """Torque, gear pair, shaking force and every bearing force of `jf75g_125_symmetric`, from `jf75g_125`: joints have the same names."""
    made, shipped = mirrored(texts.shipped("jf75g_125"), 0.5), texts.shipped("jf75g_125_symmetric")
    assert set(made.bearings) == set(shipped.bearings)
    assert (made.driver, made.mobility) == (shipped.driver, 1)
    found, expected = servo(made), servo(shipped)
    least = ROUNDING * peak(expected)
    np.testing.assert_allclose(found.driving_torque, expected.driving_torque, atol=least)
    np.testing.assert_allclose(found.coupling_torque["O_right"], expected.coupling_torque["O_right"], atol=least)
    np.testing.assert_allclose(found.shaking_force, expected.shaking_force, atol=least)
    for name, force in expected.bearing_force.items():
        np.testing.assert_allclose(found.bearing_force[name], force, atol=least, err_msg=name)


@FIXED
@given(SEEDS, st.booleans())
def test_symmetric_has_no_lateral_force_and_no_tilting_moment(folder, seed, with_counterweight):
    """Of a crank-slider and of an opposed one, about the middle; along the slide the force stays as it was, and the torque."""
    drawing, sizes = drawn(seed)
    plain = loaded(drawing, folder, gravity=(0, 0, 0))
    main = classical.as_crank_slider(plain)
    half = with_opposed_balancer(plain, 0.8 * sizes["crank_radius"], rod_length=1.3 * sizes["rod_length"]) if with_counterweight else plain
    before, after = servo(half), servo(mirrored(half, 0.4))
    force, least, size = after.shaking_force, ROUNDING * peak(before), plain.size
    assert np.abs(force @ main.across).max() <= least
    assert np.abs((force - before.shaking_force) @ main.direction).max() <= least
    moment = after.shaking_moment - np.cross(main.shaft, force)
    assert np.abs(moment @ np.cross(main.direction, main.across)).max() <= least * size  # tilting
    assert np.abs(moment @ main.direction).max() <= least * size  # what bodies off the plane do about the slide's line
    assert np.abs(after.driving_torque - before.driving_torque).max() <= least * size
    assert np.abs(after.power_residual).max() < ROUNDING


def test_a_central_load_does_not_tilt_the_symmetric_press():
    loads = [pp.loads.DeepDrawing(force=1e6, start=0.010)]
    press = mirrored(with_opposed_balancer(texts.shipped("jf75g_125_plain"), 0.0297), 0.5)
    result = turn(press, loads=loads, points=72)
    assert np.abs(result.shaking_force[:, 0]).max() <= ROUNDING * 1e6
    assert np.abs(result.shaking_moment).max() <= ROUNDING * 1e6


# ---------------------------------------------------------------------------------------------------- what the new presses are good for


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    "make", [lambda press: with_opposed_balancer(press, 0.0297), lambda press: mirrored(with_opposed_balancer(press, 0.0297), 0.5)]
)
def test_new_presses_can_be_written_and_loaded_again(make, tmp_path):
    press = make(texts.shipped("jf75g_125_plain", gravity=(0, 0, -9.80665)))
    again = pp.load(pp.write_urdf(press, tmp_path / "again.urdf"), gravity=(0, 0, -9.80665))
    assert again.bearings == press.bearings
    for one, other in zip(
        (*press.model.inertias, *press.model.jointPlacements), (*again.model.inertias, *again.model.jointPlacements), strict=True
    ):
        assert one == other
    np.testing.assert_array_equal(turn(again).shaking_force, turn(press).shaking_force)
    assert not [finding for finding in pp.check(tmp_path / "again.urdf").findings if finding.severity != "note"]


@pytest.mark.exhaustive
def test_new_presses_can_be_recorded_and_reported(tmp_path):
    press = mirrored(with_opposed_balancer(texts.shipped("crank_slide"), 0.15), 0.6)
    result = turn(press)
    assert pp.record(press, result.motion, tmp_path / "press.html", reactions=result).stat().st_size > 100_000
    assert pp.report(press, result.motion, tmp_path / "report.html", reactions=result).stat().st_size > 100_000


def test_a_changed_press_can_be_arranged():
    """With its counterweights, in memory: those of `approximate_balance` on the plain press are balanced like the rest."""
    plain = texts.shipped("jf75g_125_plain")
    changed = with_counterweights(plain, [classical.approximate_balance(plain, 0.15, share=0.2)])
    press = with_opposed_balancer(changed, 0.0297)
    assert mass(press) > mass(changed) > mass(plain)
    assert np.ptp(turn(press).shaking_force, axis=0).max() <= ROUNDING * 70e3


# ----------------------------------------------------------------------------------------------------------------------------- cancelled


def test_cancelled_says_what_became_of_every_harmonic():
    """Of the plain press with half of the reciprocating mass balanced: the first order along is halved, across raised; no other changes."""
    plain = texts.shipped("jf75g_125_plain")
    balanced = with_counterweights(plain, [classical.approximate_balance(plain, 0.15)])
    found = {(c.quantity, c.order): c for c in classical.compare_harmonics(turn(plain), turn(balanced))}
    along = [found["force along the slide", k].change for k in range(1, 7)]
    assert along == ["reduced", "unchanged", "none", "unchanged", "none", "unchanged"]
    assert [found["force across the slide", k].change for k in range(1, 7)] == ["raised"] + ["none"] * 5
    first = found["force along the slide", 1]
    assert first.before == pytest.approx((52.25 + 77.49 + 2200) * 0.015 * W**2, rel=1e-12)
    assert first.after == pytest.approx(0.5 * (77.49 / 2 + 2200) * 0.015 * W**2, rel=1e-12)


def test_cancelled_by_the_symmetric_press():
    """Tilting moment and lateral force in all orders, about the shaft of the press before, wherever the world's origin is."""
    plain = texts.shipped("jf75g_125_plain")
    found = classical.compare_harmonics(turn(plain), turn(mirrored(with_opposed_balancer(plain, 0.0297), 0.5)))
    assert {change.change for change in found} == {"cancelled", "none"}
    assert [c.order for c in found if c.quantity == "tilting moment" and c.change == "cancelled"] == [1, 3, 5]


@pytest.mark.exhaustive
def test_the_page_is_what_its_script_prints():
    assert make.load("arrangements").page() == (ROOT / "viz" / "arrangements.md").read_text(encoding="utf-8")


def test_a_press_whose_centre_of_mass_rests_runs_as_without_weight() -> None:
    """Its potential energy is constant but for rounding, which the table over the crank angle must not try to resolve."""
    runs = []
    for gravity in ((0.0, 0.0, -9.81), (0.0, 0.0, 0.0)):
        plain = texts.shipped("jf75g_125_plain", gravity=gravity)
        balanced = with_counterweights(plain, classical.complete_balance(plain, rod_radius=0.3, crank_radius=0.15))
        runs.append(pp.simulate(balanced, 0.2, speed=30.0))
    assert runs[0].crank_angle[-1] == pytest.approx(runs[1].crank_angle[-1], abs=1e-9)
