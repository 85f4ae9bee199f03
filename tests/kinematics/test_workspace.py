"""Workspaces: where a five-bar locks follows from the lengths of its rods, and dead points are where the frame's Jacobian loses rank."""

from pathlib import Path

import numpy as np
import pytest
from reference.robots.cases import FOLDER

import pinpress as pp

DOCS = Path(__file__).resolve().parents[2] / "docs" / "robots"


@pytest.fixture(scope="module")
def five_bar():
    return pp.load(FOLDER / "09_companion_yaml_3d" / "robot.urdf")


@pytest.fixture(scope="module")
def around_a_lock(five_bar):
    return pp.measures.workspace(five_bar, "rod_b", {"turn_b": (0.8, 1.4), "turn_a": (-1.4, -0.8)}, points=13)


def knees_apart(turn_a, turn_b):
    """Distance of the knees of the five-bar [m], which rods of 0.31 and 0.29 m join, from the numbers of the file."""
    left = np.array([-0.08 + 0.21 * np.cos(2.1 + turn_a), 0.21 * np.sin(2.1 + turn_a)])
    right = np.array([0.09 + 0.19 * np.cos(0.8 + turn_b), 0.19 * np.sin(0.8 + turn_b)])
    return np.linalg.norm(left - right, axis=0)


@pytest.mark.exhaustive
def test_a_linkage_is_reached_up_to_where_it_locks(around_a_lock):
    found = around_a_lock
    assert found.drivers == ("turn_b", "turn_a")
    turn_b, turn_a = np.meshgrid(*found.positions, indexing="ij")
    np.testing.assert_array_equal(found.reached, knees_apart(turn_a, turn_b) > 0.02)
    assert 4 < (~found.reached).sum() < 100
    assert len(found.locks) >= 4
    np.testing.assert_allclose(knees_apart(found.locks[:, 1], found.locks[:, 0]), 0.02, rtol=0, atol=1e-5)  # of 6 mm between nodes
    np.testing.assert_array_equal(np.isnan(found.loop_margin), ~found.reached)
    np.testing.assert_array_equal(found.within_limits, found.reached)  # they have none


def test_margins_are_singular_values_of_the_jacobians(five_bar, around_a_lock):
    """Of the frame's by the drivers in lengths of the linkage; a planar frame moves in two of the three directions."""
    found = around_a_lock
    rows = (slice(3), slice(None))  # a path along these meets no lock
    assert found.reached[rows].all()
    drivers = np.stack(np.meshgrid(*found.positions, indexing="ij"), axis=-1)[rows].reshape(-1, 2)[:, ::-1]
    jacobian = five_bar.jacobian("rod_b", drivers)[:, :3] / five_bar.size
    values = np.linalg.svd(jacobian, compute_uv=False)
    rank = 1 if values[:, 1].max() < 1e-9 else 2  # the origin of rod_b is on one crank
    np.testing.assert_allclose(found.frame_margin[rows].ravel(), values[:, rank - 1], rtol=1e-9)
    np.testing.assert_allclose(found.place[rows].reshape(-1, 3), five_bar.placements("rod_b", drivers)[:, :3, 3], rtol=0, atol=1e-9)


@pytest.mark.exhaustive
def test_a_leg_has_dead_points_where_it_is_straight():
    """With knee and hip in line with the foot, the foot cannot be moved along the leg."""
    leg = pp.load(DOCS / "leg.urdf")
    found = pp.measures.workspace(leg, "foot", {"hip": (-0.5, 0.5), "crank": (-1.4, 0.4)}, points=25)
    assert found.reached.all()
    assert len(found.dead_points) >= 25
    margins = [np.linalg.svd(leg.jacobian("foot", at)[:3], compute_uv=False)[1] / leg.size for at in found.dead_points]
    assert max(margins) < 2e-3 * np.nanmax(found.frame_margin)  # between nodes the determinant bends a little
    knee, foot = (leg.placements(frame, found.dead_points)[:, :3, 3] for frame in ("shank", "foot"))
    beside = np.cross(knee, foot)[:, 1] / np.linalg.norm(knee, axis=1) / np.linalg.norm(foot, axis=1)  # the hip is the origin
    assert np.abs(beside).max() < 2e-3
    assert (~found.within_limits).any()  # the knee's
    assert pp.plots.draw(found, "map").axes


def test_what_is_no_workspace_is_refused(five_bar):
    with pytest.raises(pp.UnknownNameError, match="no driver 'turn_c', did you mean 'turn_"):
        pp.measures.workspace(five_bar, "rod_a", {"turn_c": (0, 1), "turn_a": (0, 1)})
    with pytest.raises(pp.PinpressError, match="give two of the drivers turn_a, turn_b with their ends"):
        pp.measures.workspace(five_bar, "rod_a", {"turn_a": (0, 1)})
    with pytest.raises(pp.PinpressError, match=r"ranges\['turn_a'\] is 1 to 0: give the lower end"):
        pp.measures.workspace(five_bar, "rod_a", {"turn_b": (0, 1), "turn_a": (1, 0)})
