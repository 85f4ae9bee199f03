"""Key frames: the states of a motion that a recording shows."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..common.arguments import expect
from ..common.errors import PinpressError
from ..common.quantities import Array
from ..engines.branch import predict
from ..engines.joints import configuration
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage

PER_TURN = 360  # between keys 1 degree apart a crank pin leaves its circle by 0.004 % of the crank radius
FEWEST_PER_TURN = 36  # 0.4 %
FARTHEST = np.pi / 2  # between states, which are joined by straight lines
MOST = 20_000  # keeps the page of a long run below 20 MB


@dataclass(frozen=True, eq=False)
class Keys:
    """Key frames, k of them.

    Attributes:
        states: (k,) indices of states of the motion.
        time: (k,) times from the first one [s].
        crank: (k,) angles of the (first) driver [rad].
        slide: (k,) slide positions [m]; None where there is no slide.
        turn: Number of keys of one period, after which the linkage repeats its path; all of them where it does not.
    """

    states: NDArray[np.intp]
    time: Array
    crank: Array
    slide: Array | None
    turn: int


def keys(press: Linkage, motion: Motion) -> Keys:
    """Choose key frames: a motion of one period is closed to a loop, a long one is thinned to `PER_TURN` a turn of the crank.

    Raises:
        PinpressError: The motion is of a linkage with other joints, has no times, states too far apart or more turns than a page holds, or
            a value is not finite.
    """
    expect("press", press, Linkage, "load")
    expect("motion", motion, Motion, "cycle or simulate")
    if motion.joints != press.joints or motion.drivers != press.drivers:
        raise PinpressError(f"the motion is of {motion.linkage} with other joints than {press.name}: make it with cycle(press, ...)")
    _refuse_broken(motion, press.slide is not None)
    time = motion.time - motion.time[0]
    crank = np.asarray(motion.crank_angle).reshape(len(time), -1)[:, 0]  # of several drivers, the first
    period = _period(press, motion)
    last = None if period is None else _closing_time(time, crank, period)
    order = np.arange(len(time))
    if period is not None and last is not None:  # the first state once more, so that the loop has no jump
        order, time = np.append(order, 0), np.append(time, last)
        crank = np.append(crank, crank[0] + np.sign(crank[-1] - crank[0]) * period)
    turns = float(np.abs(np.diff(crank)).sum() / (2 * np.pi))
    if turns * FEWEST_PER_TURN > MOST:
        raise PinpressError(
            f"{turns:.0f} turns are more than a recording holds ({MOST // FEWEST_PER_TURN}): record a shorter part of the motion"
        )
    widest = float(np.abs(np.diff(crank)).max(initial=0.0))
    if widest > FARTHEST:
        raise PinpressError(
            f"the crank turns {np.degrees(widest):.0f} deg from one state to the next, too far to show what is between:"
            f" give a state every {np.degrees(FARTHEST):.0f} deg at least"
        )
    most = min(PER_TURN * max(1, np.ceil(turns - 1e-6)), MOST) + 1
    kept = np.rint(np.linspace(0, len(order) - 1, int(min(len(order), most)))).astype(int)  # the first and the last among them
    order, crank = order[kept], crank[kept]
    slide = np.asarray(motion.slide_position)[order] if press.slide is not None else None
    beyond = np.flatnonzero(np.abs(crank - crank[0]) >= (period or np.inf) * (1 - 1e-9))
    turn = int(beyond[0]) + 1 if len(beyond) else len(order)
    return Keys(order, time[kept], crank, slide, turn)


def _refuse_broken(motion: Motion, has_slide: bool) -> None:
    series = {"time": motion.time, "crank_angle": motion.crank_angle, "joint_position": motion.joint_position}
    if has_slide:
        series["slide_position"] = motion.slide_position
    for name, values in series.items():
        bad = ~np.isfinite(values)
        if np.size(values) == 0 or bad.any():
            where = f"is not finite at index {int(np.argwhere(bad)[0][0])}" if bad.any() else "is empty"
            raise PinpressError(f"motion.{name} {where}; record a motion that cycle or simulate returned")
    if np.any(np.diff(motion.time) <= 0):
        raise PinpressError("motion.time does not increase from point to point; order the points of the motion by time")


def _period(press: Linkage, motion: Motion) -> float | None:
    """Crank angle after which all is where it was, balanced shafts too [rad]; None where it is not after a period of the motion."""
    if motion.period_turns is None:
        return None
    period = 2 * np.pi * motion.period_turns
    before, after = configuration(press.slots, predict(press.branch_through_change_points, np.array([0.0, period]))).T
    return period if np.allclose(before, after, rtol=0.0, atol=1e-9 * (1 + press.size)) else None


def _closing_time(time: Array, crank: Array, period: float) -> float | None:
    """When the first point comes round again [s], if the motion is one period [rad] without its end point; else None."""
    turned = abs(crank[-1] - crank[0])
    gap, step = period - turned, np.max(np.abs(np.diff(crank)), initial=0.0)
    return float(time[-1] * (1 + gap / turned)) if len(time) > 2 and 1e-6 * step < gap <= 1.001 * step else None
