"""Bounds of the program, made from the limits of press builders, and the limits that contradict one another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.conic_program import InfeasibleError, UnsolvedError
from ...common.errors import PinpressError, UnknownNameError, caution
from ...common.quantities import Array
from ...kinematics.slide_path import dead_centres
from ...linkage.linkage import Linkage
from ...loads.link import Load
from ...loads.process import ProcessLoad, datum
from ..drive import ServoDrive
from ..limits import (
    BearingForce,
    CrankAcceleration,
    CrankSpeed,
    FeedWindow,
    Limit,
    RmsTorque,
    SlideAcceleration,
    SlideSpeed,
    Window,
    in_words,
    span,
)
from .coefficients import Coefficients, segment_means
from .motion_problem import Affine, Bounded, MotionProblem, inner_affine, rest_below
from .optimum import NoMotionError
from .program import Solution, first_sizes, solve
from .torque_curve import hull_bounds

EDGE = 1e-9  # heights closer than this count as one [m]
FLAT = 1e-9  # share of the largest travel by crank angle below which the slide turns back
INVOLVED = 1e-4  # a limit with a smaller part in a contradiction, whose parts sum to one, is not named
AS_LONG = 1e-6  # share by which a cycle must be longer than the time that limits of speed take
MUCH = 1e3  # limits that would have to be more than 1000 times as large are not suggested as a remedy


def limit_heights(limits: Sequence[Limit]) -> list[float]:
    """Heights above bottom dead centre at which windows of limits begin or end [m]."""
    found = [height for limit in limits if isinstance(limit, Window) and limit.heights is not None for height in limit.heights]
    return [*found, *(limit.height for limit in limits if isinstance(limit, FeedWindow))]


def bearings_of(press: Linkage, limits: Sequence[Limit]) -> tuple[str, ...]:
    """Names of the bearings whose force is limited; raises UnknownNameError for a name that the press does not have."""
    for limit in limits:
        if isinstance(limit, BearingForce) and limit.bearing not in press.bearings:
            raise UnknownNameError("bearing", limit.bearing, press.bearings)
    return tuple(dict.fromkeys(limit.bearing for limit in limits if isinstance(limit, BearingForce)))


def refuse_heights(press: Linkage, limits: Sequence[Limit], stroke: float) -> None:
    """Raise PinpressError for a limit at heights that the slide does not reach."""
    for limit in limits:
        heights = (limit.height,) if isinstance(limit, FeedWindow) else limit.heights if isinstance(limit, Window) else None
        if heights and max(heights) > stroke + EDGE:
            raise PinpressError(
                f"{in_words(limit)}: {1e3 * max(heights):.6g} mm is outside the stroke of {press.name}: give heights above bottom dead"
                f" centre, from 0 to {stroke:.9g} m"
            )


def caution_flank(press: Linkage, limits: Sequence[Limit], loads: Sequence[Load]) -> None:
    """Caution if a speed is limited on the way up only, at heights where the process acts on the way down only."""
    speeds = [limit for limit in limits if isinstance(limit, SlideSpeed | CrankSpeed)]
    upwards = [limit for limit in speeds if isinstance(limit, SlideSpeed) and limit.flank == "up" and limit.heights is not None]
    if not upwards or any(limit.flank != "up" for limit in speeds):
        return
    acting: dict[bool, list[tuple[float, float, str]]] = {}
    for down in (True, False):
        pairs = [(load, part) for load in loads if isinstance(load, ProcessLoad) for part in load.intervals(down)]
        shift = dead_centres(press).bottom_position
        spans = [(part.lower + datum(load, press) - shift, part.upper + datum(load, press) - shift, load) for load, part in pairs]
        acting[down] = [(low, high, type(load).__name__) for low, high, load in spans]
    for limit in upwards:
        low, high = span(limit)
        on = {down: [name for bottom, top, name in found if bottom < high - EDGE and top > low + EDGE] for down, found in acting.items()}
        if on[True] and not on[False]:
            names = " and ".join(dict.fromkeys(on[True]))
            caution(
                f"{in_words(limit)} holds on the way up, but {names} acts at these heights on the way down only, where no"
                ' speed is limited. This is probably a mistake: write flank="down", unless the return must be slow'
            )


def motion_problem(
    c: Coefficients, drive: ServoDrive, limits: Sequence[Limit], weights: Mapping[str, float], time: float | None
) -> MotionProblem:
    """The problem with these limits and the limits of the drive.

    Raises:
        PinpressError: the path has no part in a window, a constant speed goes through a dead centre, or the drive cannot hold a rest.
    """
    all_ = np.arange(len(c.grid.step))
    name = "cycle time" if time is None else f"cycle time of {time:.6g} s"
    problem = MotionProblem(c, drive, weights, time, tuple(limits), time_name=name)
    bounds = [*_of_drive(problem), *hull_bounds(problem)]
    for limit in limits:
        if isinstance(limit, SlideSpeed):
            bounds.append(_slide_speed(c, limit))
        elif isinstance(limit, CrankSpeed):
            nodes = _nodes(c, _segments(c, limit))
            bounds.append(Bounded(in_words(limit), np.full(len(nodes), limit.speed**2), limit.speed, "rad/s", nodes=nodes, power=2.0))
        elif isinstance(limit, SlideAcceleration):
            segments = np.flatnonzero(_segments(c, limit))
            most = np.full(len(segments), limit.acceleration)
            for k in range(2):
                travel, bend = c.inner_travel[k][segments], c.inner_bend[k][segments]
                quantity = inner_affine(c, k, travel, bend, np.zeros(len(segments)), segments)
                bounds.append(Bounded(in_words(limit), most, limit.acceleration, "m/s2", quantity, both=True))
        elif isinstance(limit, CrankAcceleration):
            step = c.grid.step
            rate = Affine(-0.5 / step, 0.5 / step, np.zeros(len(step)), all_)
            bounds.append(Bounded(in_words(limit), np.full(len(step), limit.acceleration), limit.acceleration, "rad/s2", rate, both=True))
        elif isinstance(limit, BearingForce):
            bounds += [_bearing_force(c, limit, k) for k in range(2)]
        elif isinstance(limit, RmsTorque):
            torque = drive.rated_torque if limit.torque is None else limit.torque
            if torque is None:
                raise PinpressError("RmsTorque has no torque, and the drive has no rated_torque: give one of them [N m]")
            rms = min(torque * drive.ratio, problem.rms or np.inf)
            problem = replace(problem, rms=rms, rms_name=f"rms torque of the motor of {rms / drive.ratio:.6g} N m")
        elif isinstance(limit, FeedWindow):
            if problem.below is not None:
                raise PinpressError("limits have two feed windows: give one FeedWindow")
            middle = 0.5 * (c.height[1:] + c.height[:-1])
            problem = replace(problem, below=middle < limit.height, feed_time=limit.time, feed_name=in_words(limit))
    return replace(problem, bounds=tuple(bounds))


def _of_drive(problem: MotionProblem) -> list[Bounded]:
    """The convex limits of the drive."""
    c, drive = problem.coefficients, problem.drive
    if drive.peak_torque is not None:
        _refuse_to_hold(c, drive, float(drive.peak_torque_at(0.0)))
    bounds = peak_torque_bounds(drive, problem.mean_torque(), drive.crank_drag)
    if drive.top_speed is not None:
        nodes = np.flatnonzero(~c.grid.rest)
        most = np.full(len(nodes), (drive.top_speed / drive.ratio) ** 2)
        bounds.append(Bounded(_speed_name(drive.top_speed), most, drive.top_speed, "rad/s", nodes=nodes, power=2.0))
    return bounds


def peak_torque_bounds(drive: ServoDrive, torque: Affine, drag: float = 0.0) -> list[Bounded]:
    """The limit of a torque by the drive's peak torque; none if the drive's curve of torque is below it. For ``drag`` see `Bounded`."""
    if drive.peak_torque is None or (drive.curve_torque and drive.curve_torque[0] <= drive.peak_torque):
        return []
    name, most = f"torque of the motor of {drive.peak_torque:.6g} N m", np.full(len(torque.segments), drive.peak_torque * drive.ratio)
    return [Bounded(name, most, drive.peak_torque, "N m", torque, both=True, drag=drag)]


def _refuse_to_hold(c: Coefficients, drive: ServoDrive, peak: float) -> None:
    legs = c.grid.legs
    for angle, dwell, torque in zip(legs.angles[1:], legs.dwells, c.holding, strict=True):
        if dwell and abs(torque) > peak * drive.ratio:
            raise PinpressError(
                f"the drive cannot hold the press at rest at crank angle {np.degrees(angle):.6g} deg: its motor gives {peak:.6g} N m, but"
                f" {abs(torque) / drive.ratio:.6g} N m are needed; give a larger peak_torque or ratio, or a rest elsewhere"
            )


def _segments(c: Coefficients, limit: SlideSpeed | CrankSpeed | SlideAcceleration) -> NDArray[np.bool_]:
    """(N,) whether a segment is in the window of a limit."""
    low, high = span(limit)
    middle = 0.5 * (c.height[1:] + c.height[:-1])
    down = c.grid.way * c.inner_travel[0] < 0
    flank = np.ones(len(down), bool) if limit.flank == "both" else down if limit.flank == "down" else ~down
    inside = flank & (middle > low) & (middle < high)
    if not inside.any():
        raise PinpressError(
            f"{in_words(limit)}: the slide does not pass these heights on the way {limit.flank if limit.flank != 'both' else 'down or up'};"
            f" give heights from {1e3 * c.height.min():.6g} to {1e3 * c.height.max():.6g} mm above bottom dead centre, where the path goes"
        )
    return inside


def _nodes(c: Coefficients, segments: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Nodes at the ends of segments, without rests."""
    ends = np.append(segments, False) | np.append(False, segments)
    return np.flatnonzero(ends & ~c.grid.rest)


def _slide_speed(c: Coefficients, limit: SlideSpeed) -> Bounded:
    inside = _segments(c, limit)
    nodes = _nodes(c, inside)
    flat = np.abs(c.travel[nodes]) <= FLAT * np.abs(c.travel).max()
    if limit.constant:
        ends = np.append(inside, False) | np.append(False, inside)
        if flat.any() or (ends & c.grid.rest).any():
            raise PinpressError(
                f"{in_words(limit)}: the slide rests or turns back within these heights, so it cannot have this speed; give heights away"
                " from dead centres, or leave out constant=True"
            )
    moving = nodes[~flat]
    most = (limit.speed / c.travel[moving]) ** 2
    return Bounded(in_words(limit), most, limit.speed, "m/s", nodes=moving, power=2.0, equal=limit.constant)


def _bearing_force(c: Coefficients, limit: BearingForce, place: int) -> Bounded:
    """The limit of a bearing's force at one of the inner places of segments, a cone of three components."""
    part, all_ = c.bearings[limit.bearing], np.arange(len(c.grid.step))
    first, second, third = (
        inner_affine(c, place, part.by_acceleration[place, :, k], part.by_square[place, :, k], part.fixed[place, :, k], all_)
        for k in range(3)
    )
    most: Array = np.full(len(all_), limit.force)
    return Bounded(in_words(limit), most, limit.force, "N", first, length=(second, third))


# ------------------------------------------------------------------------------------------------------------ least time by limits of speed


class SpeedTimes(NamedTuple):
    """The least time of a cycle within limits of speed, for an arbitrarily strong drive."""

    by_limit: Mapping[str, float]  # name of a limit -> time for its part of the path [s]; where several limits hold, the slowest counts
    least: float  # least time of a cycle, with the rests and the feed window [s]
    reachable: bool  # whether a motion may take exactly this time: limits hold on the whole path, and the crank never rests

    @property
    def words(self) -> str:
        """The limits with their times, e.g. "slide speed of 0.05 m/s from 60 to 0 mm (1.2 s)"."""
        return _listed([f"{name} ({time:.4g} s)" for name, time in self.by_limit.items()])


def speed_times(problem: MotionProblem) -> SpeedTimes:
    """The least times that limits of speed allow along a path, by quadrature."""
    c, n = problem.coefficients, len(problem.coefficients.grid.step)
    travel = np.abs(np.stack([c.travel[:-1], *c.inner_travel, c.travel[1:]], axis=1))  # (N, 4)
    slowness: dict[str, Array] = {}  # times by crank angle [s/rad]
    if problem.drive.top_speed is not None:
        slowness[_speed_name(problem.drive.top_speed)] = np.full((n, 4), problem.drive.ratio / problem.drive.top_speed)
    for limit in problem.limits:
        if isinstance(limit, SlideSpeed | CrankSpeed):
            of_limit = travel / limit.speed if isinstance(limit, SlideSpeed) else np.full((n, 4), 1.0 / limit.speed)
            slowness[in_words(limit)] = np.where(_segments(c, limit)[:, None], of_limit, 0.0)
    if not slowness:
        return SpeedTimes({}, problem.resting, False)
    every = np.stack(list(slowness.values()))
    times = np.maximum(segment_means(every.max(axis=0), c.inner), 0.0) * np.abs(c.grid.step)
    slowest = every.sum(axis=2).argmax(axis=0)
    by_limit = {name: float(times[slowest == k].sum()) for k, name in enumerate(slowness)}
    moving = float(times.sum())
    least = moving + problem.resting
    if problem.below is not None:
        least = max(least, float(times[problem.below].sum()) + rest_below(problem) + problem.feed_time)
    named = {name: time for name, time in by_limit.items() if time > 1e-6 * moving}
    return SpeedTimes(named, least, bool(c.grid.legs.closed and every.max(axis=0).min() > 0))


def refuse_short(problem: MotionProblem) -> None:
    """Raise NoMotionError if the cycle is too short for the limits of speed, even with an arbitrarily strong drive.

    A program without a limit of the torque does not detect this: its speeds outside the windows grow without bound.
    """
    if problem.time is None:
        return
    taken = speed_times(problem)
    if problem.time > taken.least * (1.0 + AS_LONG if not taken.reachable else 1.0 - AS_LONG) or not taken.by_limit:
        return
    beside = [
        *([f"rests of {problem.resting:.4g} s"] if problem.resting else []),
        *([problem.feed_name] if problem.below is not None else []),
    ]
    with_ = f", with {' and '.join(beside)}" if beside else ""
    remedy = _remedy(problem, problem.time_name) if any(bound.quantity is not None for bound in problem.bounds) else ""
    more = f"; with all limits {remedy} would do" if remedy else ""
    raise NoMotionError(
        f"no motion of {problem.coefficients.press_name} keeps the {problem.time_name} and the {taken.words} together: even with the"
        f" strongest drive these speeds take {taken.least:.4g} s{with_}; give a longer time, or higher speeds{more}"
    )


def _speed_name(speed: float) -> str:
    return f"speed of the motor of {speed:.6g} rad/s"


def _listed(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


# ---------------------------------------------------------------------------------------------------------------------- contradictions


def contradiction(problem: MotionProblem) -> NoMotionError:
    """The error that names the limits that contradict one another, and by how much each limit alone must be relaxed."""
    together, press_name = _let_out(problem, None), problem.coefficients.press_name
    if together is None:
        return NoMotionError(
            f"no motion of {press_name} keeps all limits, even if all of them are relaxed: a constant slide speed is impossible on this"
            " path, or numbers differ too much in size; remove limits one by one"
        )
    involved = [name for name, part in together.parts.items() if part > INVOLVED] or list(together.parts)
    remedies = [words for name in involved if (words := _remedy(problem, name))]
    names = _listed(involved)
    remedy = f"{' or '.join(remedies)} would do; " if remedies else ""
    return NoMotionError(
        f"no motion of {press_name} keeps the {names} together: {remedy}relax all {len(involved)} by {100 * together.relaxed:.3g} %"
        if len(involved) > 1
        else f"no motion of {press_name} keeps the {names}: {remedy}relax this limit by {100 * together.relaxed:.3g} %"
    )


def _remedy(problem: MotionProblem, name: str) -> str:
    """The value that a limit must have if it alone is relaxed, as text; empty if this does not help."""
    alone = _let_out(problem, name)
    if alone is None or not 0.0 <= alone.relaxed < MUCH:
        return ""
    grown = 1.0 + alone.relaxed
    if name == problem.time_name and problem.time is not None:
        return f"a cycle time of {problem.time * grown:.4g} s"
    if name == problem.rms_name and problem.rms is not None:
        # exact limits are squares: the program relaxes them to first order
        return f"an rms torque of {problem.rms / problem.drive.ratio * np.sqrt(1.0 + 2.0 * alone.relaxed):.4g} N m"
    if name == problem.feed_name:
        return f"a feed window of {max(0.0, problem.feed_time * (1.0 - alone.relaxed)):.4g} s" if alone.relaxed < 1.0 else ""
    limit = next(bound for bound in problem.bounds if bound.name == name)
    number = limit.limit * (1.0 + limit.power * alone.relaxed) ** (1.0 / limit.power)
    return f"{_kind(limit.name)} of {number:.4g} {limit.unit}"


def _kind(name: str) -> str:
    words = name.split(" of ")
    return f"a {' of '.join(words[:-1])}" if len(words) > 1 else f"a {name}"


def _let_out(problem: MotionProblem, name: str | None) -> Solution | None:
    """The least share by which all limits, or the limit with this name, must be relaxed; None if the solver found no answer."""
    try:
        return solve(problem, first_sizes(problem), (lambda each: each == name) if name else lambda _: True)
    except (InfeasibleError, UnsolvedError):
        return None
