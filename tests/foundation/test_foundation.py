"""A press on its mounts: rubber, loads at rest, modes, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from support.exploring import examples
from support.generators.frames import WIDE, on_four, uneven, weightless
from support.texts import shipped

import pinpress as pp
from pinpress import foundation
from pinpress.common.quantities import quantity
from pinpress.foundation.mounted_press import state_matrix

GRAVITY = 9.81
FIXED = examples(5)


# ---------------------------------------------------------------------------------------------------------------------------------- rubber


def test_hardness_gives_the_modulus_of_gent():
    """50 Shore A: E = 0.0981 (56 + 381.168) / (0.137505 x 127) = 2.45579 MPa, worked out by hand."""
    assert foundation.RubberPad(0.1, 0.1, 0.01, hardness=50).modulus_of_shear == pytest.approx(2.45579e6 / 3, rel=1e-5)


def test_square_pad_is_stiffer_by_its_shape():
    """0.1 x 0.1 x 0.0125 m: S = 2, E_c = 3 G (1 + 8) = 27 MPa; with B = 2.7 GPa E = 27 / 1.01 MPa; k_z = E 0.8 m, k_x = G 0.8 m."""
    pad = foundation.RubberPad(0.1, 0.1, 0.0125, shear_modulus=1e6, bulk_modulus=2.7e9, stiffening=1.5)
    assert pad.shape_factor == pytest.approx(2.0, rel=1e-14)
    np.testing.assert_allclose(pad.static_stiffness, [0.8e6, 0.8e6, 21.6e6 / 1.01], rtol=1e-12)
    np.testing.assert_allclose(pad.stiffness, np.multiply(pad.static_stiffness, 1.5), rtol=1e-14)


def test_pad_stands_as_a_mount():
    pad = foundation.RubberPad(0.2, 0.1, 0.02, hardness=60, loss_factor=0.1, stiffening=1.4)
    mount = foundation.pad_mount((1.0, 2.0, 3.0), pad)
    assert (mount.point, mount.stiffness, mount.static, mount.loss_factor) == ((1.0, 2.0, 3.0), pad.stiffness, pad.static_stiffness, 0.1)
    assert mount.area == pytest.approx(0.02)


# ------------------------------------------------------------------------------------------------------------------------------- at rest


@pytest.mark.exhaustive
@FIXED
@given(st.integers(0, 2**32 - 1))
def test_three_mounts_share_the_weight_by_its_levers(seed):
    """Statically determinate: loads from equilibrium of moments alone, whatever the stiffness; the sag from each by itself."""
    rng = np.random.default_rng(seed)
    places = np.column_stack([np.array([[-1.0, -0.8], [1.0, -0.7], [0.1, 1.0]]) + rng.uniform(-0.1, 0.1, (3, 2)), np.full(3, -1.0)])
    centre, mass = np.array([*rng.uniform(-0.2, 0.2, 2), 0.3]), 1000.0
    stiffness, static = rng.uniform(1e6, 9e6, (3, 3)), rng.uniform(1e6, 9e6, 3)
    mounts = [
        foundation.Mount(tuple(p), tuple(k), static_stiffness=(k[0], k[1], s), area=0.01)
        for p, k, s in zip(places, stiffness, static, strict=True)
    ]
    system = foundation.mounted(weightless(), foundation.Frame(mass, centre, (300, 300, 300)), mounts)
    levers = np.vstack([np.ones(3), places[:, 0], places[:, 1]])
    load = np.linalg.solve(levers, mass * GRAVITY * np.array([1.0, centre[0], centre[1]]))
    np.testing.assert_allclose(system.mount_load[:, 2], load, rtol=1e-10)
    np.testing.assert_allclose(system.sag[:, 2], -load / static, rtol=1e-10)
    np.testing.assert_allclose(system.load_share, load / load.sum(), rtol=1e-10)
    np.testing.assert_allclose(system.pressure, load / 0.01, rtol=1e-10)
    np.testing.assert_allclose(system.to_frame()["load [N]"], load, rtol=1e-10)
    assert quantity("N").scale(load, digits=5).shown(load[2]) in str(system)


@pytest.mark.parametrize("name", ["zxn2_3000b", "jf75g_125_symmetric"])
def test_weight_is_the_mean_of_the_shaking_force(name):
    """Momentum comes back after a turn: what the machine exerts on the mean is its weight at its mean place."""
    press = shipped(name)
    system = foundation.mounted(press, *uneven(20.0))
    result = pp.inverse_dynamics(press, pp.cycle(press, 30 * pp.RPM, points=720))
    mean = np.concatenate([result.shaking_force.mean(axis=0), result.shaking_moment.mean(axis=0)])
    np.testing.assert_allclose(system.press_weight, mean, atol=1e-9 * np.abs(mean).max())
    assert system.total_mass == pytest.approx(120e3 + sum(inertia.mass for inertia in press.model.inertias), rel=1e-12)


# -------------------------------------------------------------------------------------------------------------------------------- modes


def test_modes_of_a_frame_on_mounts_at_its_centre_of_mass():
    """Uncoupled: sqrt(k/m) along the axes, sqrt(sum k r^2 / I) about them. At this height the weight turns nothing."""
    frame = foundation.Frame(1200.0, (0.0, 0.0, -1.0), (500.0, 450.0, 300.0))
    kx, ky, kz = stiffness = (2e6, 3e6, 7e6)
    found = foundation.modes(foundation.mounted(weightless(), frame, on_four(stiffness)))
    squares = {
        "along x": 4 * kx / 1200.0,
        "along y": 4 * ky / 1200.0,
        "along z": 4 * kz / 1200.0,
        "rocking about x": 4 * kz * WIDE**2 / 500.0,
        "rocking about y": 4 * kz * WIDE**2 / 450.0,
        "twisting about z": 4 * (kx + ky) * WIDE**2 / 300.0,
    }
    names = sorted(squares, key=lambda name: squares[name])
    np.testing.assert_allclose(found.natural_frequency, np.sqrt([squares[name] for name in names]), rtol=1e-9)
    assert list(found.motion) == names
    np.testing.assert_allclose(found.damping_ratio, 0.0, atol=1e-9)


@pytest.mark.parametrize("height", [0.7, -0.4])
def test_sway_and_rocking_with_the_weight(height):
    """Centre of mass h above the mounts: coupled, and the weight takes m g h from the stiffness against rocking (adds to it below)."""
    mass, inertia, kx, kz = 1200.0, 450.0, 2e4, 7e4
    frame = foundation.Frame(mass, (0.0, 0.0, -1.0 + height), (500.0, inertia, 300.0))
    found = foundation.modes(foundation.mounted(weightless(), frame, on_four((kx, 3e6, kz))))
    stiffness = np.array([[4 * kx, -4 * kx * height], [-4 * kx * height, 4 * kx * height**2 + 4 * kz * WIDE**2 - mass * GRAVITY * height]])
    expected = np.sqrt(np.linalg.eigvals(stiffness / np.array([[mass], [inertia]])))
    for frequency in expected:
        assert np.abs(found.natural_frequency / frequency - 1).min() < 1e-9


@pytest.mark.parametrize("ratio", [0.05, 0.7, 2.5])
def test_damping_ratio_of_viscous_mounts(ratio):
    """c = 2 z sqrt(k m) on the vertical mode; above 1 it creeps. The other directions have little damping."""
    mass, kz = 1200.0, 7e6
    damping = (0.0, 0.0, 2 * ratio * np.sqrt(4 * kz * mass) / 4)
    frame = foundation.Frame(mass, (0.0, 0.0, -1.0), (900.0, 900.0, 900.0))
    found = foundation.modes(foundation.mounted(weightless(), frame, on_four((2e4, 3e4, kz), damping)))
    vertical = np.sqrt(4 * kz / mass)
    place = int(np.abs(found.natural_frequency - vertical).argmin())
    assert found.motion[place] == "along z"
    assert found.damping_ratio[place] == pytest.approx(ratio, rel=1e-6)
    assert found.damped_frequency[place] == pytest.approx(vertical * np.sqrt(max(0.0, 1 - ratio**2)), rel=1e-6)


def test_loss_factor_damps_every_mode_by_half_of_it():
    frame, mounts = uneven()
    lossy = [foundation.Mount(m.point, m.stiffness, loss_factor=0.2) for m in mounts]
    light = shipped("crank_slide", gravity=(0, 0, 0))
    found = foundation.modes(foundation.mounted(light, frame, lossy))
    np.testing.assert_allclose(found.damping_ratio, 0.1, rtol=1e-9)
    np.testing.assert_allclose(found.damped_frequency, found.natural_frequency * np.sqrt(1 - 0.01), rtol=1e-9)


def test_stretching_of_bed_and_crown():
    """Two masses on a spring, hardly held: sqrt(k (1/m1 + 1/m2)); the mounts change the square by about k_mounts / k."""
    bed, crown = foundation.Frame(900.0, (0, 0, -0.8), (300, 300, 300)), foundation.Frame(600.0, (0, 0, 0.4), (200, 200, 200))
    columns = on_four((2e8, 3e8, 1e8), height=-0.2)
    system = foundation.mounted(weightless(), bed, on_four((1e4, 1e4, 1e4)), crown=crown, uprights=columns)
    found = foundation.modes(system)
    stretching = found.natural_frequency[list(found.motion).index("stretching")]
    assert stretching == pytest.approx(np.sqrt(4e8 * (1 / 900 + 1 / 600)), rel=1e-4)
    assert (found.natural_frequency > 0).all()
    assert len(found.natural_frequency) == 12


@pytest.mark.exhaustive
def test_stiffness_is_the_curvature_of_the_energy_of_bed_and_crown():
    """Bed and crown turn by whatever angles: springs in the world's axes, loaded as at rest, and weights; without symmetry anywhere."""
    bed, crown = foundation.Frame(3000.0, (0.1, -0.2, -0.8), (900, 900, 900)), foundation.Frame(1500.0, (0.3, 0.1, 1.1), (200, 200, 200))
    mounts = [replace(mount, stiffness=(3e4, 2e4, 5e4 + 1e4 * k)) for k, mount in enumerate(on_four((1.0, 1.0, 1.0)))]
    columns = [replace(mount, stiffness=(8e4, 7e4, 9e4 + 2e4 * k)) for k, mount in enumerate(on_four((1.0, 1.0, 1.0), height=0.5))]
    system = foundation.mounted(weightless(), bed, mounts, crown=crown, uprights=columns)
    rest = np.linalg.solve(sum_of_springs(mounts, columns), system.weight)

    def energy(x):
        def moved(part, point):
            place = np.array(point, dtype=float)
            return x[6 * part : 6 * part + 3] + (Rotation.from_rotvec(x[6 * part + 3 : 6 * part + 6]).as_matrix() - np.eye(3)) @ place

        total = GRAVITY * (bed.mass * moved(0, bed.centre)[2] + crown.mass * moved(1, crown.centre)[2])
        for part, springs in ((0, mounts), (1, columns)):
            for spring in springs:
                still = rest_at(rest, part, spring.point) - (rest_at(rest, 0, spring.point) if part else 0.0)
                stretch = still + moved(part, spring.point) - (moved(0, spring.point) if part else 0.0)
                total += 0.5 * np.array(spring.stiffness) @ stretch**2
        return total

    h = 1e-3
    steps = h * np.eye(12)
    curvature = np.array([[sum(s * t * energy(s * a + t * b) for s in (1, -1) for t in (1, -1)) for b in steps] for a in steps]) / (
        4 * h * h
    )
    np.testing.assert_allclose(system.stiffness, curvature, atol=1e-5 * np.abs(curvature).max())
    assert np.abs(system.stiffness - sum_of_springs(mounts, columns)).max() > 1e-2 * np.abs(curvature).max()


def rest_at(x, part, point):
    """Small displacement of a point of a part."""
    return x[6 * part : 6 * part + 3] + np.cross(x[6 * part + 3 : 6 * part + 6], point)


def sum_of_springs(mounts, columns):
    """Stiffness (12, 12) of springs in the world's axes, small displacements, without what their forces add."""
    total = np.zeros((12, 12))
    for part, springs in ((0, mounts), (1, columns)):
        for spring in springs:
            ends = [[rest_at(unit, k, spring.point) for k in range(part + 1)] for unit in np.eye(12)]
            rows = np.array([end[part] - (end[0] if part else 0.0) for end in ends]).T
            total += rows.T @ np.diag(spring.stiffness) @ rows
    return total


def test_resonance_speeds_are_natural_frequencies_by_orders():
    found = foundation.modes(foundation.mounted(shipped("crank_slide"), *uneven()))
    np.testing.assert_allclose(found.resonance_speeds(3)[2] * 3, found.natural_frequency, rtol=1e-15)


def test_eigenvalues_are_of_the_free_system():
    """Each is a root of det(s^2 M + s C + K), its smallest singular value zero beside the matrix's largest."""
    system = foundation.mounted(shipped("crank_slide"), *uneven())
    assert state_matrix(system).shape == (12, 12)
    for s in foundation.modes(system).eigenvalues:
        values = np.linalg.svd(s**2 * system.mass + s * system.damping + system.stiffness, compute_uv=False)
        assert values[-1] < 1e-10 * values[0]


def test_logarithmic_decrement_of_a_decaying_vibration():
    ratio, w = 0.03, 50.0
    time = np.linspace(0.0, 2.0, 20001)
    signal = np.exp(-ratio * w * time) * np.cos(w * np.sqrt(1 - ratio**2) * time)
    assert foundation.logarithmic_decrement(signal) == pytest.approx(2 * np.pi * ratio / np.sqrt(1 - ratio**2), rel=1e-9)


def test_logarithmic_decrement_stands_noise_and_other_vibrations():
    """Of a signal with 1 % noise, whose own peaks outnumber the vibration's by far, an offset and a faster vibration, each by its band."""
    rng = np.random.default_rng(3)
    time = np.arange(4000) / 1000.0
    slow, fast = (np.exp(-ratio * w * time) * np.cos(w * np.sqrt(1 - ratio**2) * time) for ratio, w in ((0.075, 50.0), (0.02, 165.0)))
    expected = [2 * np.pi * ratio / np.sqrt(1 - ratio**2) for ratio in (0.075, 0.02)]
    assert foundation.logarithmic_decrement(slow + 0.01 * rng.normal(size=4000)) == pytest.approx(expected[0], rel=0.01)
    both = 0.2 + slow + 0.5 * fast + 0.01 * rng.normal(size=4000)
    for band, each in zip(((5.0, 12.0), (20.0, 40.0)), expected, strict=True):
        assert foundation.logarithmic_decrement(both, rate=1000.0, band=band) == pytest.approx(each, rel=0.01)


def test_two_modes_that_creep_keep_their_own_damping():
    """c = 2 z sqrt(k m) along x and along z, uncoupled: the slow rate of one is no partner of the fast rate of the other."""
    mass, (kx, kz), (one, other) = 1200.0, (2e4, 7e6), (4.0, 1.05)
    damping = tuple(2 * ratio * np.sqrt(4 * k * mass) / 4 for ratio, k in ((one, kx), (0.0, 1.0), (other, kz)))
    frame = foundation.Frame(mass, (0.0, 0.0, -1.0), (900.0, 900.0, 900.0))
    found = foundation.modes(foundation.mounted(weightless(), frame, on_four((kx, 3e6, kz), damping)))
    for name, ratio in (("along x", one), ("along z", other)):
        assert found.damping_ratio[found.motion.index(name)] == pytest.approx(ratio, rel=1e-6)
    assert found.damping_ratio[found.motion.index("along y")] == pytest.approx(0.0, abs=1e-9)
