"""What was asked before never changes an answer: equal calls give equal bits."""

from __future__ import annotations

import numpy as np
import pytest

import pinpress as pp

SPEEDS = (5.0, -6.0, 7.0, 8.0)  # [rad/s]


def _forces(press: pp.Linkage, speed: float, engine: str, points: int = 24) -> np.ndarray:
    reactions = pp.inverse_dynamics(press, pp.cycle(press, speed=speed, points=points), engine=engine)
    return np.concatenate([reactions.driving_torque, *(force.ravel() for force in reactions.bearing_force.values())])


@pytest.mark.parametrize("engine", ["plane", "space", "pinocchio"])
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
