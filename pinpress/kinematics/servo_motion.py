"""Motions that a servo drive prescribes: of the crank, or of the slide by a table of heights over time."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common.arguments import in_unit, numbers, typed
from ..common.errors import PinpressError, SingularityError, shown
from ..common.numerics import bracketed_roots
from ..common.quantities import Array
from ..engines.branch import Branch, out_of_branch
from ..linkage.linkage import Linkage
from .cycle import doubt_speeds, motion_through_change_points, moved
from .driver_motion import DriverMotion, Drivers, driver_motion
from .motion import Motion, with_gaps
from .slide_path import EQUAL, ROUNDING, DeadCentres, dead_centres

Flank = Literal["down", "up"]
NODES = 361  # nodes of a flank, between which the slide's path is inverted


@typed
def servo_cycle(
    press: Linkage,
    angle: ArrayLike | None = None,
    *,
    speed: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
    time: ArrayLike | None = None,
    period: float | None = None,
    height: ArrayLike | None = None,
    flank: Flank | Sequence[Flank] | None = None,
    engine: str = "auto",
    on_singular: Literal["error", "nan"] = "error",
) -> Motion:
    """Move a press as a servo drive prescribes it.

    Give any part of the motion that determines it:

    - ``angle`` and ``time``, and if you know them ``speed`` and ``acceleration``: what is missing is derived, and contradictions are
      refused.
    - ``speed`` (n,) and ``time`` with one number for ``angle``, that at the start. Or ``acceleration`` (n,) and ``time`` with one number
      for each of angle and speed at the start.
    - ``height`` of the slide and ``time``, with the ``flank``.
    - ``angle`` and ``speed``: the acceleration is that of the motion that passes the angles one after the other at these speeds,
      a = w dw/dangle. This is refused where they determine no time: at standstill over several states, or in any other order.
    - ``angle``, ``speed`` and ``acceleration`` without time: independent states. They are not compared, and have a `Motion.time` only
      where they fit together.

    Derivatives by time are those of the quintic spline through at least six states. Their errors go with the fifth power of the step, those
    of an acceleration from angles with the fourth. Over a ``period`` in equal steps they are those of the trigonometric polynomial, exact
    to rounding for a smooth motion. Columns contradict each other where they differ by more than the error of the derivative, which is
    estimated from the cubic spline, central differences and the noise of the columns. Columns of fewer than six states that differ by more
    than 5 % are warned of.

    A linkage with several drivers takes (n, drivers) of angle, speed and acceleration, in the order of `Linkage.drivers`. There the
    assembly is followed from the drawn pose to the first state and from state to state, on straight lines between the drivers' positions.
    Of a linkage with passive coordinates (`Linkage.passive`) give all of them too, or the motors alone: the passive ones then rest where
    the linkage was put together, until `inverse_dynamics` moves them.

    Args:
        press: the press.
        angle: (n,) of the driver joint, any angles up to 1e7 rad in any order; or one number, the angle at the start [rad]. Of a driver
            that slides its position, within the limits of its joint [m].
        speed: (n,) of the driver joint, or one number: a constant speed; where ``acceleration`` and one angle, that at the start, are
            given, the speed at the start [rad/s or m/s].
        acceleration: (n,) of the driver joint, or one number. The number 0 leaves out the torque or force that a change of speed
            takes [rad/s2 or m/s2].
        time: (n,), rising [s].
        period: time [s] after which the motion begins again, a whole number of turns later: the motion is then closed. The last state may
            be at the end of the period, where the first comes again, or one step before. By default the motion is not closed.
        height: (n,) of the slide above bottom dead centre [m].
        flank: "down": the crank angles at which the slide goes down where the crank turns positively; "up": the others. One word says where
            the first state outside a dead centre is. Through a state in a dead centre the crank goes on to the other flank; where the slide
            turns back elsewhere, the crank turns back too. A sequence has a word for each state. Leave it out where the driver slides; the
            driver must then move the slide one way all along.
        engine: as of `inverse_dynamics`: "plane", "space", "pinocchio", or "auto", the fastest.
        on_singular: what becomes of states that are not reached because the linkage locks on the way from the last one that is: "error",
            or "nan": they are not `Motion.valid`, and NaN, in the motion and in its `inverse_dynamics`. All other results are finite.

    Raises:
        PinpressError: what is given does not determine the motion, or contradicts itself, with the instant; a number is not finite, arrays
            differ in length, time does not rise, the slide does not reach a height.
        SingularityError: the linkage locks within the motion, and ``on_singular`` is "error".
        AssemblyError: the loops do not close.

    Warns:
        PinpressWarning: a derived acceleration is dominated by noise or uncertain; a speed that varies in time has the acceleration 0; a
            speed is hardly meant, see `cycle`.
    """
    press.engine(engine)  # refuses an engine that does not suit before anything is computed
    unit = press.driver_coordinates[0].unit
    angle, speed, acceleration = (
        in_unit("angle", angle, unit),
        in_unit("speed", speed, f"{unit}/s"),
        in_unit("acceleration", acceleration, f"{unit}/s2"),
    )
    time, period, height = in_unit("time", time, "s"), in_unit("period", period, "s"), in_unit("height", height, "m")
    if height is not None:
        angle = _angles_at(press, angle, speed, acceleration, time, height, flank)
    elif flank is not None:
        raise PinpressError("flank is given, but no height: give height=..., (n,) [m] above bottom dead centre")
    elif angle is None and time is None:
        raise PinpressError(f"give angle, (n,) [{unit}] and speed=..., or time=... with angle, speed or height")
    elif angle is None:
        raise PinpressError(f"give angle, (n,) [{unit}]; or one number, the angle at the start, with the speed; or height, (n,) [m]")
    given = press.drivers
    if press.passive and press.motors and angle is not None and numbers("angle", angle).shape[1:] != (len(press.drivers),):
        given = press.motors
    if len(given) == 1 < len(press.drivers):
        angle, speed, acceleration = (np.ravel(each) if np.ndim(each) == 2 else each for each in (angle, speed, acceleration))
    found = driver_motion(Drivers(given, press.driver_coordinates[: len(given)]), angle, speed, acceleration, time, period)
    if len(given) < len(press.drivers):
        found = _with_passive(press, found)
    if not isinstance(on_singular, str) or on_singular not in ("error", "nan"):
        raise PinpressError(f'on_singular is {shown(on_singular)}: write "error" or "nan"')
    branch = None if len(press.drivers) > 1 else press.branch
    if on_singular == "error":
        motion = moved(press, branch, found.angle, found.speed, found.acceleration, found.time, engine)
    else:
        motion = _moved_where_reached(press, branch, found, engine)
    doubt_speeds(press, found.speed, motion)
    return motion


def _with_passive(press: Linkage, motors: DriverMotion) -> DriverMotion:
    """The motion of all drivers, of that of the motors: passive coordinates rest where the linkage was put together."""
    count, passive = len(motors.angle), press.driver_indices[len(press.motors) :]
    rest = np.zeros((count, len(passive)))
    values = ((motors.angle, rest + press.closed[list(passive)]), (motors.speed, rest), (motors.acceleration, rest))
    angle, speed, acceleration = (np.concatenate([given.reshape(count, -1), others], axis=1) for given, others in values)
    return DriverMotion(angle, speed, acceleration, motors.time)


def _moved_where_reached(press: Linkage, branch: Branch | None, asked: DriverMotion, engine: str) -> Motion:
    """The motion with gaps in the states that are not reached."""
    locked: dict[int, SingularityError] = {}
    angles = asked.angle
    if branch is not None and branch.period is None:
        home = float(press.closed[press.driver_indices[0]])
        for upwards, beyond in ((False, angles < branch.angles[0]), (True, angles > branch.angles[-1])):
            if branch.locks[upwards] is not None:
                lock = out_of_branch(branch, upwards)
                assert isinstance(lock, SingularityError)  # as the branch ends in one
                locked |= dict.fromkeys(np.flatnonzero(beyond).tolist(), lock)
                angles = np.where(beyond, home, angles)
    motion = moved(press, branch, angles, asked.speed, asked.acceleration, asked.time, engine, locked)
    if not locked:
        return motion
    gaps = sorted(locked)
    reasons = [str(locked[state]) for state in gaps if state - 1 not in locked]
    return with_gaps(press, motion, (asked.angle, asked.speed, asked.acceleration), gaps, reasons)


def _angles_at(
    press: Linkage,
    angle: ArrayLike | None,
    speed: ArrayLike | None,
    acceleration: ArrayLike | None,
    time: ArrayLike | None,
    height: ArrayLike,
    flank: Flank | Sequence[Flank] | None,
) -> Array:
    """Crank angles (n,) of a table of heights over time; arguments as of `servo_cycle`."""
    for name, given in (("angle", angle), ("speed", speed), ("acceleration", acceleration)):
        if given is not None:
            raise PinpressError(f"height and {name} are given: the crank's motion follows from the heights over time, leave {name} out")
    if time is None:
        raise PinpressError("height is given, but no time: give time=..., (n,) [s]")
    heights = numbers("height", height, (None,))
    if numbers("time", time).shape != heights.shape:
        raise PinpressError(f"time has shape {np.shape(time)}, but height has {heights.shape}")
    if len(press.drivers) > 1:
        raise PinpressError(
            f"{press.name} has {len(press.drivers)} drivers, which a table of heights does not determine: give their angles"
        )
    ends = dead_centres(press)
    _refuse_unreachable(heights, ends.stroke)
    if not press.driver_coordinates[0].turns:
        return _over_travel(press, ends, heights, flank)
    down = _flanks(heights, ends.stroke, flank)
    return _on_flanks(press, ends, heights, down)


def _over_travel(press: Linkage, ends: DeadCentres, heights: Array, flank: object) -> Array:
    """Positions (n,) at heights, of a driver that slides and with which the slide moves all one way."""
    if flank is not None:
        raise PinpressError(f"flank is given, but the driver of {press.name} slides: leave flank out")
    low, high = sorted((ends.top_angle, ends.bottom_angle))
    if not np.isclose([low, high], press.branch.angles[[0, -1]], rtol=0.0, atol=EQUAL * press.size).all():
        raise PinpressError(
            f"the slide of {press.name} turns back within the driver's travel, so that a height belongs to several positions of the driver:"
            " give these in place of heights (in Python angle=...)"
        )
    at_bottom, at_top = heights <= EQUAL * ends.stroke, heights >= (1 - EQUAL) * ends.stroke
    positions = np.where(at_bottom, ends.bottom_angle, ends.top_angle)
    between = ~at_bottom & ~at_top
    if between.any():
        positions[between] = _invert_path(press, ends, heights[between], low, high)
    return positions


def _refuse_unreachable(heights: Array, stroke: float) -> None:
    beyond = np.maximum(-heights, heights - stroke)
    if len(beyond) and beyond.max() > EQUAL * stroke:
        state = int(beyond.argmax())
        raise PinpressError(
            f"height is {heights[state]:.9g} m in state {state}, which the slide does not reach: give heights above bottom dead centre,"
            f" from 0 to the stroke of {stroke:.9g} m"
        )


def _in_dead_centre(heights: Array, stroke: float) -> NDArray[np.bool_]:
    return (heights <= EQUAL * stroke) | (heights >= (1 - EQUAL) * stroke)


def _flanks(heights: Array, stroke: float, flank: Flank | Sequence[Flank] | None) -> NDArray[np.bool_]:
    """Whether each state (n,) is on the flank on which the slide goes down; in a dead centre as before it."""
    words = list(flank) if isinstance(flank, Iterable) and not isinstance(flank, str) else [flank]
    if any(not isinstance(word, str) or word not in ("down", "up") for word in words) or not (
        isinstance(flank, str) or len(words) == len(heights)
    ):
        raise PinpressError(
            f'flank is {shown(flank)}: give "down" (the slide goes down where the crank turns positively) or "up"; or one of both for each'
            f" of the {len(heights)} states"
        )
    between = np.flatnonzero(~_in_dead_centre(heights, stroke))
    if not isinstance(flank, str):
        given = np.array([word == "down" for word in words])
        return given[_last_of(between, len(heights))] if len(between) else given
    _refuse_unclear_turns(heights, stroke)
    passed = np.cumsum(np.diff(between, prepend=between[:1]) > 1) % 2
    down = (passed == 0) == (flank == "down")
    full = np.full(len(heights), flank == "down")
    full[between] = down
    return full[_last_of(between, len(heights))] if len(between) else full


def _last_of(chosen: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """For each of ``count`` states the last of the chosen ones up to it; the first chosen one where there is none."""
    return np.asarray(chosen[np.maximum(np.searchsorted(chosen, np.arange(count), side="right") - 1, 0)])


def _refuse_unclear_turns(heights: Array, stroke: float) -> None:
    """Raise PinpressError where the slide turns back so near to a dead centre that it may have passed it between the states."""
    steps = np.diff(heights)
    moving = np.flatnonzero(steps)
    for before, after in itertools.pairwise(moving):
        if np.signbit(steps[before]) == np.signbit(steps[after]):
            continue
        state = before + 1
        left = stroke - heights[state] if steps[before] > 0 else heights[state]
        if EQUAL * stroke < left <= max(abs(steps[before]), abs(steps[after])):
            name = "top" if steps[before] > 0 else "bottom"
            raise PinpressError(
                f"the slide turns back in state {state} at {heights[state]:.6g} m, {left:.3g} m from {name} dead centre and less than a"
                f" step: whether the crank passes it does not show. Give a state in the dead centre, at a height of"
                f" {stroke if name == 'top' else 0:.9g} m, or a flank for each state, flank=[...]"
            )


def _on_flanks(press: Linkage, ends: DeadCentres, heights: Array, down: NDArray[np.bool_]) -> Array:
    """Crank angles (n,) at heights on the flanks, in sequence through the dead centres; the first is from 0 to a period."""
    period = 2 * np.pi * ends.turns
    top, bottom = ends.top_angle, ends.bottom_angle + (period if ends.bottom_angle < ends.top_angle else 0.0)
    at_bottom, at_top = heights <= EQUAL * ends.stroke, heights >= (1 - EQUAL) * ends.stroke
    angles = np.where(at_bottom, bottom, np.where(down, top, top + period))
    for chosen, low, high in ((down, top, bottom), (~down, bottom, top + period)):
        between = chosen & ~at_bottom & ~at_top
        if between.any():
            angles[between] = _invert_path(press, ends, heights[between], low, high)
    turned = np.zeros(len(heights))
    for state in np.flatnonzero(down[1:] != down[:-1]) + 1:
        upwards = at_top[state - 1] or (not at_bottom[state - 1] and heights[state - 1] + heights[state] > ends.stroke)
        if upwards:  # through top dead centre a new turn begins, or the last one begins again
            turned[state:] += period if down[state] else -period
    angles += turned
    return np.asarray(angles - period * np.floor(angles[:1] / period))


def angle_on_flank(press: Linkage, ends: DeadCentres, height: float, down: bool) -> float:
    """Crank angle within the period at which the slide is at a height above bottom dead centre [m], on the flank on which it goes down
    where the crank turns positively, or on the other; raises PinpressError where the slide turns back between its dead centres."""
    return float(_on_flanks(press, ends, np.array([height]), np.array([down]))[0])


def _invert_path(press: Linkage, ends: DeadCentres, heights: Array, low: float, high: float) -> Array:
    """Crank angles (m,) between two dead centres at which the slide is at heights between them, to rounding.

    Raises:
        PinpressError: the slide turns back between the dead centres.
    """
    nodes = np.linspace(low, high, NODES)
    way = motion_through_change_points(press, nodes, 1.0).slide_position - ends.bottom_position
    rises = way[-1] > way[0]
    if not np.all(np.diff(way) > 0 if rises else np.diff(way) < 0):
        raise PinpressError(
            f"the slide of {press.name} turns back between its dead centres, so that a height belongs to several positions of the"
            " driver: give these in place of heights (in Python angle=...)"
        )
    after = np.searchsorted(way if rises else -way, heights if rises else -heights)

    def short_of(angle: Array) -> tuple[Array, Array]:
        motion = motion_through_change_points(press, angle, 1.0)
        above, speed = motion.slide_position - ends.bottom_position - heights, motion.slide_velocity
        return (-above, -speed) if rises else (above, speed)

    # A bracket of three steps: a height beside a node would change sides by rounding.
    before, behind = np.clip(after - 2, 0, NODES - 1), np.clip(after + 1, 0, NODES - 1)
    return bracketed_roots(short_of, nodes[before], nodes[behind], absolute=ROUNDING)
