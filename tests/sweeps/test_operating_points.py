"""Operating points against inverse dynamics of each, and their extremes against all states."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import texts
from support.exploring import examples

import pinpress as pp
from pinpress.sweeps.operating_map import Affine, largest, operating_points

SIX_BAR = texts.shipped("zxn2_3000b")
SPEEDS = np.linspace(20.0, 100.0, 60) * pp.RPM
FORCES = np.linspace(-1e5, 3e6, 70)


def one_by_one(press, speed, load, points=360):
    """The results at one point, by inverse dynamics with its own load."""
    found = pp.inverse_dynamics(press, pp.cycle(press, speed, points=points), load)
    results = {"largest_driving_torque": found.driving_torque.max(), "smallest_driving_torque": found.driving_torque.min()}
    results |= {f"peak_force_{name}": np.linalg.norm(force, axis=1).max() for name, force in found.bearing_force.items()}
    return results | {f"range_shaking_force_{axis}": np.ptp(found.shaking_force[:, k]) for k, axis in enumerate("xyz")}


def agrees(found, i, j, expected):
    """To 1e-12 of the result; of ranges and torques, differences, of what is subtracted; of a bearing without a force, to rounding of the
    forces of others."""
    largest_force = max(value for name, value in expected.items() if name.startswith("peak_force"))
    torque = max(abs(expected["largest_driving_torque"]), abs(expected["smallest_driving_torque"]))
    assert list(found.results) == list(expected)
    for name, value in expected.items():
        size = max(value, 1e-3 * largest_force) if name.startswith("peak") else torque if name.endswith("torque") else largest_force
        assert abs(found.grid(name)[i, j] - value) <= 1e-12 * size, name


@pytest.mark.parametrize("name", pp.presses())
@pytest.mark.parametrize("sign", [1, -1])
def test_every_shipped_press(name, sign):
    press = texts.shipped(name)
    stroke = pp.dead_centres(press).stroke
    points = 24 if "plane" not in press.engines else 72
    speeds, forces = sign * np.array([3.0, 0.5, 20.0]), np.array([0.0, 2e6, 3e4])
    found = operating_points(press, speeds, forces=forces, unit_load=pp.loads.DeepDrawing(force=1.0, start=0.3 * stroke), points=points)
    assert found.shape == (3, 3)
    for i, j in ((0, 0), (1, 1), (2, 2), (2, 1)):
        load = pp.loads.DeepDrawing(force=forces[j], start=0.3 * stroke)
        agrees(found, i, j, one_by_one(press, speeds[i], [load], points))


@pytest.fixture(scope="module")
def found():
    """A downward blow at the slide and a push at the coupler, amplitudes of both signs, with a spring."""
    return operating_points(SIX_BAR, SPEEDS, forces=FORCES, unit_load=unit_loads(1.0), loads=[SPRING], angles=True)


SPRING = pp.loads.SpringDamper("frame", "slide", stiffness=2e5, free_length=0.4, point1=(0, 0, 0.5))


def blow(motion):
    return np.outer(np.where(motion.slide_velocity < 0, np.sin(motion.crank_angle) ** 2, 0.0), (0.0, 0.1, 1.0))


def unit_loads(amplitude):
    return [
        pp.loads.PointForce("slide", lambda motion: amplitude * blow(motion)),
        pp.loads.PointForce("coupler", (0.2 * amplitude, 0.0, 0.0), (0.5, 0, 0)),
    ]


def test_points_of_a_grid_of_tiles(found):
    random = np.random.default_rng(1)
    for i, j in [(0, 0), (59, 69), (0, 69), *random.integers((60, 70), size=(12, 2))]:
        agrees(found, i, j, one_by_one(SIX_BAR, SPEEDS[i], [*unit_loads(FORCES[j]), SPRING]))


def test_angles_are_where_the_extremes_are(found):
    for i, j in ((0, 0), (31, 8), (59, 69)):
        reactions = pp.inverse_dynamics(SIX_BAR, pp.cycle(SIX_BAR, SPEEDS[i]), [*unit_loads(FORCES[j]), SPRING])
        state = {name: round(360 * angles[i, j] / (2 * np.pi)) for name, angles in found.angles.items()}
        assert set(state) == {name for name in found.results if not name.startswith("range")}
        torque = reactions.driving_torque
        assert torque[state["largest_driving_torque"]] == pytest.approx(torque.max(), rel=1e-12)
        assert torque[state["smallest_driving_torque"]] == pytest.approx(torque.min(), rel=1e-12)
        for name, force in reactions.bearing_force.items():
            size = np.linalg.norm(force, axis=1)
            assert size[state[f"peak_force_{name}"]] == pytest.approx(size.max(), rel=1e-12)


def test_order_of_speeds_and_forces_is_the_callers(found):
    i, j = np.random.default_rng(2).permutation(60), np.random.default_rng(3).permutation(70)
    mixed = operating_points(SIX_BAR, SPEEDS[i], forces=FORCES[j], unit_load=unit_loads(1.0), loads=[SPRING], bearings=["A"])
    assert [name for name in mixed.results if name.startswith("peak")] == ["peak_force_A"]
    for name in mixed.results:
        expected = found.grid(name)[np.ix_(i, j)]
        np.testing.assert_allclose(mixed.grid(name), expected, rtol=0, atol=1e-14 * np.abs(expected).max())


def test_without_a_load():
    found = operating_points(SIX_BAR, SPEEDS[:3], bearings=())
    assert found.shape == (3, 1)
    expected = pp.inverse_dynamics(SIX_BAR, pp.cycle(SIX_BAR, SPEEDS[1])).driving_torque.max()
    assert found.grid("largest_driving_torque")[1, 0] == pytest.approx(expected, rel=1e-13)


@examples(30)
@given(
    seed=st.integers(0, 2**32 - 1),
    components=st.integers(1, 3),
    states=st.integers(1, 40),
    shape=st.tuples(st.integers(1, 75), st.integers(1, 75)),
    rank=st.integers(0, 3),
    lengths=st.booleans(),
)
def test_largest_is_that_of_all_states(seed, components, states, shape, rank, lengths):
    """Of random coefficients, of less than full rank too, with the same load in half of the states."""
    random = np.random.default_rng(seed)
    components = components if lengths else 1
    a, c, d = np.einsum("pr,rks->pks", random.standard_normal((3, rank)), random.standard_normal((rank, components, states)))
    d[:, states // 2 :] = d[:, :1]
    squares, forces = np.sort(random.uniform(0, 2, shape[0])), np.sort(random.uniform(-2, 2, shape[1]))
    every = np.einsum("ks,n->kns", a, squares)[:, :, None] + c[:, None, None] + np.einsum("ks,m->kms", d, forces)[:, None]
    every = np.linalg.norm(every, axis=0) if lengths else every[0]
    found, state = largest(Affine(a, c, d), squares, forces, lengths, True)
    rounding = 1e-14 * (np.abs(a).max() * 2 + np.abs(c).max() + np.abs(d).max() * 2)
    np.testing.assert_allclose(found, every.max(axis=2), rtol=0, atol=rounding)
    np.testing.assert_allclose(np.take_along_axis(every, state[..., None], axis=2)[..., 0], found, rtol=0, atol=rounding)


def test_an_elastic_die_pushes_in_proportion():
    """At a given motion its force depends on the height alone."""
    found = operating_points(SIX_BAR, [2.0, 6.0], forces=[1e7, 4e7], unit_load=pp.loads.ElasticDie(0.02, 1.0))
    for i, j in ((0, 1), (1, 0)):
        agrees(found, i, j, one_by_one(SIX_BAR, found.speeds[i], [pp.loads.ElasticDie(0.02, found.forces[j])]))


def test_table(found):
    columns = found.columns()
    np.testing.assert_array_equal(columns["peak_force_A [N]"].reshape(60, 70), found.grid("peak_force_A"))
    assert (columns["speed [rad/s]"][71], columns["force [N]"][71]) == (SPEEDS[1], FORCES[1])
    assert list(columns)[:3] == ["speed [rad/s]", "force [N]", "largest_driving_torque [N m]"]
    np.testing.assert_array_equal(columns["angle_of_peak_force_A [rad]"], found.angles["peak_force_A"].ravel())
    assert re.search(r"speeds +60 +20.0000 r/min to 100.000 r/min", str(found))
    with pytest.raises(pp.UnknownNameError, match="did you mean 'peak_force_slide_guide'"):
        found.grid("peak_force_slideguide")
    with pytest.raises(ValueError, match="read-only"):
        found.grid("peak_force_A")[0, 0] = 0.0
