"""The lengths along which loads act, in a plane, on mounts and in space: rates, gradients and second derivatives by differences."""

from typing import Any

import numpy as np
import pytest
from support.presses.presses_on_springs import SPEED, jf75g, springs
from support.texts import shipped

import pinpress as pp
from pinpress.simulation.driven_press import driven_press
from pinpress.simulation.elastic.press.assembly import sprung_press
from pinpress.simulation.elastic.press.assembly_in_space import press_in_space
from pinpress.simulation.elastic.press.paths import LengthPath, LinePath, from_frame, load_path
from pinpress.simulation.elastic.press.sprung_press import reference_motion

FRAME = pp.foundation.Frame(9000.0, (0.0, 0.0, 0.3), (3000.0, 4000.0, 2500.0))
MOUNTS = [pp.foundation.Mount((x, y, -0.8), (2e6,) * 3, (2e4,) * 3) for x in (-0.6, 0.6) for y in (-0.5, 0.5)]
LOADS = [
    pp.loads.Blanking(1e5, 0.01, 0.005),
    pp.loads.PointForce("slide", (100.0, 0.0, -5e3), (0.1, 0.0, 0.05)),
    pp.loads.SpringDamper("frame", "slide", 1e5, 100.0, point1=(0.3, 0.2, -3.0)),
]


def standing(where: str) -> tuple[Any, Any]:
    """A press on springs, and the paths of its loads."""
    press = shipped("crank_slide") if where == "space" else jf75g()
    if where == "space":
        stiffness = pp.elasticity.Stiffness(dict.fromkeys(press.bearings, 1e8), moments=dict.fromkeys(press.joints, 1e7))
        sprung = press_in_space(press, pp.elasticity.Elastic(stiffness), reference_motion(press))
    else:
        more = {"mounted_frame": FRAME, "mounts": MOUNTS} if where == "mounts" else {}
        sprung = sprung_press(press, pp.elasticity.Elastic(springs(press).stiffness, **more))
    driven = driven_press(press, pp.drives.PrescribedSpeed(SPEED), None, LOADS, None, None, {})
    paths = tuple(load_path(sprung, coordinate) for coordinate in driven.coordinates)
    if where == "mounts":
        paths = from_frame(sprung, paths, True)
        assert isinstance(paths[0], LinePath)
    return sprung, (*paths, LinePath(sprung.geometry.with_lines([1])))


@pytest.mark.parametrize("where", ["plane", "mounts", "space"])
def test_derivatives_of_paths(where):
    sprung, paths = standing(where)
    random, step = np.random.default_rng(2), 1e-5
    rigid = sprung.rigid(np.array([0.4, 2.0]), 3.0)[0]
    free = rigid + 1e-2 * random.normal(size=rigid.shape)
    rates = random.normal(size=free.shape)
    assert any(isinstance(path, LengthPath) for path in paths)
    for path in paths:

        def at(places, path=path):
            return path.over(sprung, sprung.state(places, rates))

        given, steps = at(free), step * np.eye(sprung.free)
        assert given.rate == pytest.approx((given.gradient * rates).sum(axis=1), rel=1e-12)
        ends = [[at(free + sign * one) for sign in (1, -1)] for one in steps]
        gradient = np.stack([(more.value - less.value) / (2 * step) for more, less in ends], axis=1)
        bend = np.stack([(more.gradient - less.gradient) / (2 * step) for more, less in ends], axis=1)
        np.testing.assert_allclose(given.gradient, gradient, rtol=0, atol=1e-7 * max(1.0, np.abs(gradient).max()))
        np.testing.assert_allclose(given.bend, bend, rtol=0, atol=1e-7 * max(1.0, np.abs(bend).max()))


@pytest.mark.parametrize("where", ["plane", "mounts", "space"])
def test_paths_of_the_rigid_press_are_its_coordinates(where):
    """While nothing yields, every length is that which the rigid press goes; distances count from a frame that stands."""
    sprung, paths = standing(where)
    motion = pp.servo_cycle(sprung.press, angle=[0.4, 2.0, 4.0], speed=3.0)
    driven = driven_press(sprung.press, pp.drives.PrescribedSpeed(SPEED), None, LOADS, None, None, {})
    state = sprung.state(*sprung.rigid(motion.crank_angle, 3.0)[:2])
    for path, coordinate in zip(paths, driven.coordinates, strict=False):
        expected = coordinate.over(sprung.press, motion)
        np.testing.assert_allclose(path.over(sprung, state).value, expected, rtol=1e-11, atol=1e-12)
