"""How a press moves in the window: through one period of its driver. Of several drivers one moves; sliders set where the others stand.

A gear pair of ratio 0 holds a driver that stands, so that a press with one moving driver is computed as any other, in the plane too. The
torque in this pair is what holds the driver. Where drivers stand elsewhere than in the drawn pose, the press is drawn again there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..common.errors import PinpressError
from ..common.quantities import RPM, Array
from ..derivatives.motion import displaced
from ..derivatives.reshape import redrawn
from ..engines.constraints import Coupling
from ..kinematics.cycle import doubt_speeds, moved
from ..kinematics.motion import Motion
from ..linkage.assembly import follow_drivers
from ..linkage.linkage import Linkage

CLEAR = 0.05  # share of the way between two poses in which a driver locks, by which a motion to and fro stays away from each


def default_speed(press: Linkage) -> float:
    """The speed of the (first) driver where none is given [rad/s or m/s]."""
    return 60 * RPM if press.driver_coordinates[0].turns else 0.1


def swings(press: Linkage) -> bool:
    """Whether the crank of a press with one driver cannot turn fully, or is not back after a turn, as of a screw or a rack."""
    return press.driver_coordinates[0].turns and (press.branch.period is None or press.turns_until_back is None)


def swing(press: Linkage, speed: float, points: int) -> Motion:
    """A crank that cannot turn on swings harmonically to and fro, from its lowest angle where the speed is positive.

    Args:
        press: the press, whose crank `swings`.
        speed: the highest one [rad/s].
        points: states of the period.

    Raises:
        PinpressError: the speed is 0.
    """
    if not speed:
        raise PinpressError("speed is 0: the crank does not move. Give a speed other than 0")
    branch = press.branch
    low, high = float(branch.angles[0]), float(branch.angles[-1])
    half = (0.5 - CLEAR) * (high - low)
    phase: Array = np.arange(points, dtype=float) * (2 * np.pi / points)
    way, frequency = math.copysign(half, speed), abs(speed) / half
    angles = 0.5 * (low + high) - way * np.cos(phase)
    rates, accelerations = speed * np.sin(phase), way * frequency**2 * np.cos(phase)
    motion = moved(press, branch, angles, rates, accelerations, phase / frequency, "auto")
    doubt_speeds(press, rates, motion)
    return motion


def with_moving(press: Linkage, driver: str, positions: Sequence[float]) -> Linkage:
    """The press with one driver, while its others stand.

    Args:
        press: the press.
        driver: name of the driver that moves.
        positions: (drivers,) where they stand, from the zeros of the file; that of the moving driver is ignored [rad or m].

    Raises:
        SingularityError: the press locks on the straight way from the home pose.
    """
    if len(press.drivers) == 1:
        return press
    home = press.closed[list(press.driver_indices)]
    away = [0.0 if name == driver else float(value - zero) for name, value, zero in zip(press.drivers, positions, home, strict=True)]
    one = press.with_one_driver(driver, dict.fromkeys(press.drivers, 0.0))
    farthest = int(np.abs(away).argmax())
    if not away[farthest]:
        return one
    ratios = {name: value / away[farthest] for name, value in zip(press.drivers, away, strict=True)}
    line = press.with_one_driver(press.drivers[farthest], ratios)  # all of them at once, on the straight line between two poses
    there = follow_drivers(line.engine(), line.structure, line.closed, home[[farthest]][None] + away[farthest], press.name)[:, 0]
    return redrawn(one, displaced(one, {}), there)


def standing(press: Linkage) -> list[Coupling]:
    """What holds the drivers of a press that stand, see `with_moving`."""
    return [pair for pair in press.couplings if pair.multiplier == 0]
