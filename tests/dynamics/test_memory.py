"""What was asked before never changes an answer: equal calls give equal bits."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pinocchio as pin
import pytest

import pinpress as pp

SPEEDS = (5.0, -6.0, 7.0, 8.0)  # [rad/s]


def _forces(press: pp.Linkage, speed: float, engine: str, points: int = 24) -> np.ndarray:
    reactions = pp.inverse_dynamics(press, pp.cycle(press, speed=speed, points=points), engine=engine)
    return np.concatenate([reactions.driving_torque, *(force.ravel() for force in reactions.bearing_force.values())])


@pytest.mark.one_in(9)
@pytest.mark.parametrize("name", ["zxn2_3000b", "jf75g_125_symmetric", "eccentric_blocks"])
def test_forces_do_not_depend_on_earlier_calls(name: str, engine: str) -> None:
    """A press that was asked for other speeds, grids and runs before answers with the bits of one that was loaded just now."""
    fresh = {speed: _forces(pp.load(name), speed, engine) for speed in SPEEDS}
    used = pp.load(name)
    pp.simulate(used, 0.05, speed=3.0, drive=pp.drives.ConstantTorque(10.0))
    pp.dead_centres(used)
    rng = np.random.default_rng(1)
    for speed in rng.choice(SPEEDS, 12):
        _forces(used, speed, engine, points=int(rng.integers(2, 40)))
        assert np.array_equal(_forces(used, speed, engine), fresh[speed])


@pytest.mark.exhaustive
def test_threads_share_a_press() -> None:
    press = pp.load("crank_slide")
    expected = {points: pp.cycle(press, 5.0, points=points).slide_acceleration for points in range(3, 13)}
    with ThreadPoolExecutor(4) as pool:
        for points, found in zip(
            200 * list(expected), pool.map(lambda n: pp.cycle(press, 5.0, points=n), 200 * list(expected)), strict=True
        ):
            np.testing.assert_array_equal(found.slide_acceleration, expected[points])


def test_forces_belong_to_their_masses_bearings_and_loads() -> None:
    press, speeds = pp.load("zxn2_3000b"), (4.0, 5.0, 6.0)
    motions_of = [pp.cycle(press, speed, points=30) for speed in speeds]
    heavier = press.with_inertias([pin.Inertia(2 * i.mass, i.lever, 2 * i.inertia) for i in press.model.inertias])
    plain = [pp.inverse_dynamics(press, motion) for motion in motions_of]
    pushed = pp.inverse_dynamics(press, motions_of[2], [pp.loads.PointForce("slide", (0.0, 0.0, 1e5))])
    doubled = [pp.inverse_dynamics(heavier, pp.cycle(heavier, speed, points=30)) for speed in speeds[::-1]]
    some = pp.inverse_dynamics(heavier, pp.cycle(heavier, 4.0, points=30), bearings=["B"])
    assert np.abs(pushed.driving_torque - plain[2].driving_torque).max() > 1e3
    np.testing.assert_allclose(some.bearing_force["B"], doubled[2].bearing_force["B"], rtol=1e-12, atol=1e-8)
    for one, two in zip(plain, reversed(doubled), strict=True):
        np.testing.assert_allclose(two.driving_torque, 2 * one.driving_torque, rtol=1e-12, atol=1e-8)
