"""The driving torque of a press along a path, as a function of b, the square of the crank's speed.

    torque = M b'/2 + M' b/2 + G + F        (b' = db/d(crank angle), acceleration = b'/2)

M is the inertia at the crank, G the torque of weights and springs, and F the torque of the process, which depends on the direction of
travel. All three follow from inverse dynamics at chosen speeds and accelerations. Loads and windows of limits begin and end at nodes, and
the slide turns back at nodes. Nodes are closer to each other near rests, where b rises from 0.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.errors import PinpressError
from ...common.numerics import bracketed_roots
from ...common.quantities import Array
from ...dynamics.applied_loads import acting_between, process_force, process_work
from ...dynamics.inverse_dynamics import inverse_dynamics
from ...kinematics.cycle import moved
from ...kinematics.motion import Motion
from ...kinematics.slide_path import ROUNDING, dead_centres
from ...linkage.linkage import Linkage
from ...loads.link import Friction, Load, PointForce, PointMoment, Spring
from ...loads.process import ProcessLoad, TimeForce
from ..paths import PathLegs

LOOKED = 256  # number of steps of a leg in which crossings of a height are searched
GRADED = 0.9  # share of cosine grading of a leg between rests; the rest is even
GAUSS = 0.5 - 0.5 / 3**0.5, 0.5 + 0.5 / 3**0.5  # nodes of Gauss's rule, as shares of a segment's time
BRAKED = 0.4  # share of cosine grading between marks: the crank brakes before a load or a window begins
SHARED = 0.5  # share of a leg's segments that is divided equally among its pieces, so that short pieces get some
APART = 1e-7  # crank angles closer than this count as one place [rad]


@dataclass(frozen=True, eq=False, repr=False)
class PathGrid:
    """Nodes of a path, N segments between them."""

    legs: PathLegs
    marks: Sequence[Array]  # for each leg, the crank angles that must be nodes, in the order of the leg [rad]
    angle: Array  # (N + 1,) crank angles of the nodes, one after the other [rad]
    leg: NDArray[np.intp]  # (N,) leg of each segment
    share: Array  # (N + 1,) position of a node on its leg, 0 to 1; 0 at a rest
    rest: NDArray[np.bool_]  # (N + 1,) whether the crank rests at the node

    @property
    def step(self) -> Array:
        """(N,) steps of the crank angle, negative on a way back [rad]."""
        return np.diff(self.angle)

    @property
    def way_gone(self) -> Array:
        """(N + 1,) way of the crank from the start of the path, there and back [rad]."""
        return np.concatenate([[0.0], np.cumsum(np.abs(self.step))])

    @property
    def way(self) -> Array:
        """(N,) sense in which the crank turns, 1 or -1."""
        return np.sign(self.step)


class PathMotion(NamedTuple):
    """An approximate motion along a path."""

    way_gone: Array  # (m,) way of the crank from the start of the path [rad]
    b: Array  # (m,) square of its speed there [rad2/s2]


@dataclass(frozen=True, eq=False, repr=False)
class BearingCoefficients:
    """Force of a bearing at the inner places of segments: by_acceleration x acceleration + by_square x b + fixed, world axes."""

    by_acceleration: Array  # (2, N, 3) [N s2/rad]
    by_square: Array  # (2, N, 3) [N s2/rad2]
    fixed: Array  # (2, N, 3), with the process [N]


@dataclass(frozen=True, eq=False, repr=False)
class Coefficients:
    """The torque of a press without its drive, along a path of N segments, each with two inner places.

    The inner places follow Gauss's rule over the time of an approximate motion. Without such a motion they follow a motion whose b rises
    from rests in proportion to the distance, and is constant on a path without rests.
    """

    press_name: str
    grid: PathGrid
    inertia: Array  # (N + 1,) M at the nodes [kg m2]
    inner: Array  # (2, N) inner places, as shares of the segments' steps
    inner_inertia: Array  # (2, N) M there [kg m2]
    inner_slope: Array  # (2, N) dM/d(crank angle) there [kg m2/rad]
    inner_torque: Array  # (2, N) G + F there [N m]
    mean_torque: Array  # (N,) mean of G + F over the crank angle of a segment [N m]
    travel: Array  # (N + 1,) slide velocity / crank speed at the nodes [m/rad]
    inner_travel: Array  # (2, N) the same at the inner places [m/rad]
    inner_bend: Array  # (2, N) its derivative there [m/rad2]
    height: Array  # (N + 1,) height of the slide above bottom dead centre [m]
    holding: Array  # (k,) torque that holds the press at the end of each leg [N m]
    bearings: Mapping[str, BearingCoefficients]  # by their names


def path_marks(press: Linkage, legs: PathLegs, heights: Iterable[float]) -> list[Array]:
    """For each leg, the crank angles [rad] at which the slide turns back or is at one of the heights [m], in the order of the leg."""
    positions = np.array([*heights], float) + dead_centres(press).bottom_position
    return [_marks(press, start, end, positions) for start, end in itertools.pairwise(legs.angles.tolist())]


def path_grid(legs: PathLegs, marks: Sequence[Array], points: int) -> PathGrid:
    """Nodes along a path with this number of segments, and additional nodes at the `path_marks`."""
    ways = np.abs(np.diff(legs.angles))
    angles, leg, share = [legs.angles[:1]], [], [np.zeros(1)]
    for k, (start, end) in enumerate(itertools.pairwise(legs.angles.tolist())):
        count = max(4, round(points * ways[k] / ways.sum()))
        nodes = _grade_nodes(start, end, marks[k], count, legs.closed)
        angles.append(nodes[1:])
        leg.append(np.full(len(nodes) - 1, k))
        share.append(np.append(((nodes - start) / (end - start))[1:-1], 0.0))
    angle = np.concatenate(angles)
    rest = np.zeros(len(angle), bool)
    if not legs.closed:
        rest[np.cumsum([0, *map(len, leg)])] = True
    return PathGrid(legs, marks, angle, np.concatenate(leg), np.concatenate(share), rest)


def load_heights(press: Linkage, loads: Sequence[Load]) -> list[float]:
    """Heights above bottom dead centre at which process loads begin or end [m]."""
    bottom, processes = dead_centres(press).bottom_position, (load for load in loads if isinstance(load, ProcessLoad))
    return [end - bottom for load in processes for _, *ends in acting_between(load, press) for end in ends if np.isfinite(end)]


def feels_speed(loads: Sequence[Load], friction: Mapping[str, Friction]) -> list[str]:
    """Names of the loads whose torque depends on the speed in another way than by its square."""
    names = ["friction of bearings"] if friction else []
    for load in loads:
        if isinstance(load, Spring):
            names += ["a damper"] if np.any(load.damping) else []
        elif isinstance(load, PointForce | PointMoment):
            names += ["a force that is a function of the motion"] if _is_function(load) else []
        elif isinstance(load, ProcessLoad) and any(each.heeds_velocity for down in (True, False) for each in load.intervals(down)):
            names.append(f"{type(load).__name__}, which depends on the slide's speed")
    return list(dict.fromkeys(names))


def coefficients(
    press: Linkage,
    grid: PathGrid,
    loads: Sequence[Load],
    friction: Mapping[str, Friction],
    speed: float,
    bearings: Sequence[str] = (),
    like: PathMotion | None = None,
) -> Coefficients:
    """Compute the coefficients of the torque along a path.

    Args:
        press: the press.
        grid: nodes of the path.
        loads: the loads.
        friction: friction of bearings.
        speed: speed of the crank, for loads that depend on the speed in another way than by its square [rad/s].
        bearings: names of bearings whose forces are computed.
        like: an approximate motion, or None.

    Raises:
        PinpressError: a load is a force in time, or as `inverse_dynamics`.
    """
    if any(isinstance(load, TimeForce) for load in loads):
        raise PinpressError("loads has a TimeForce, but the times of the motion are not yet known: give a load by height")
    if press.loses_power or (press.uneven and bearings):
        press.refuse_contacts("with them the optimum takes no losses and no limits of bearing forces; leave these out")
    inner = _inner_places(grid, like)
    angle = np.empty(3 * len(grid.step) + 1)
    angle[::3] = grid.angle
    angle[1::3], angle[2::3] = grid.angle[:-1] + inner * grid.step
    way = np.concatenate([np.repeat(grid.way, 3), grid.way[-1:]])
    zero, one = np.zeros_like(angle), np.ones_like(angle)
    still = [replace(load, damping=0.0) if isinstance(load, Spring) else load for load in loads if not _feels_travel(load)]
    unit = _moved(press, angle, one, zero)
    at_rest, accelerated, moving, alone = (
        inverse_dynamics(press, motion, given, bearings=bearings)
        for motion, given in (
            (_moved(press, angle, zero, zero), ()),
            (_moved(press, angle, zero, one), ()),
            (unit, ()),
            (_moved(press, angle, zero, zero), still),
        )
    )
    turning = _moved(press, angle, speed * way, zero)
    loaded = inverse_dynamics(press, turning, loads, friction, bearings=bearings)
    slope = 2.0 * (moving.driving_torque - at_rest.driving_torque)
    static = alone.driving_torque
    process = -process_force(loads, press, turning) * unit.slide_velocity  # by the principle of virtual power
    other = loaded.driving_torque - static - 0.5 * slope * speed**2 - process
    work = process_work(loads, press, turning).reshape(-1, 3).sum(axis=1)
    inertia = accelerated.driving_torque - at_rest.driving_torque
    return Coefficients(
        press_name=press.name,
        grid=grid,
        inertia=inertia[::3],
        inner=inner,
        inner_inertia=_inside(inertia),
        inner_slope=_inside(slope),
        inner_torque=_inside(static + process + other),
        mean_torque=_mean(static, inner) + _inside(other).mean(axis=0) + work / grid.step,
        travel=unit.slide_velocity[::3],
        inner_travel=_inside(unit.slide_velocity),
        inner_bend=_inside(unit.slide_acceleration),
        height=unit.slide_position[::3] - dead_centres(press).bottom_position,
        holding=_holding(press, grid, loads),
        bearings={
            name: BearingCoefficients(
                _inside(accelerated.bearing_force[name] - at_rest.bearing_force[name]),
                by_square := _inside(moving.bearing_force[name] - at_rest.bearing_force[name]),
                _inside(loaded.bearing_force[name]) - by_square * speed**2,
            )
            for name in bearings
        },
    )


def _inner_places(grid: PathGrid, like: PathMotion | None) -> Array:
    """(2, N) inner places of the segments, as shares of their steps: Gauss's rule over the time of an approximate motion."""
    if like is None:
        b = np.ones(len(grid.angle)) if grid.legs.closed else np.minimum(grid.share, 1.0 - grid.share)  # b rises like this from a rest
    else:
        b = np.interp(grid.way_gone, like.way_gone, like.b)
    speed = np.sqrt(np.where(grid.rest, 0.0, np.maximum(b, 0.0)))
    start, change = speed[:-1], np.diff(speed)
    even = np.abs(change) <= 1e-6 * np.maximum(start, speed[1:])
    whole = np.where(even, 1.0, np.diff(speed**2))
    gone = (((start + change * part) ** 2 - start**2) / whole for part in GAUSS)
    return np.stack([np.where(even, part, way) for part, way in zip(GAUSS, gone, strict=True)])


def _inside(values: Array) -> Array:
    """Values at the inner places, (2, N, ...), taken from the values at nodes and inner places."""
    return np.stack([values[1::3], values[2::3]])


def _mean(values: Array, inner: Array) -> Array:
    """(N,) means over the segments of values at nodes and inner places."""
    return segment_means(np.stack([values[:-1:3], values[1::3], values[2::3], values[3::3]], axis=1), inner)


def segment_means(values: Array, inner: Array) -> Array:
    """(N,) means over the segments of the cubics through values (N, 4) at their beginnings, inner places and ends."""
    places = np.stack([np.zeros_like(inner[0]), *inner, np.ones_like(inner[0])], axis=1)
    powers = places[:, None, :] ** np.arange(4)[:, None]  # (N, 4, 4)
    weights = np.linalg.solve(powers, np.broadcast_to(1.0 / np.arange(1.0, 5.0)[:, None], (len(places), 4, 1)))[:, :, 0]
    return np.asarray((values * weights).sum(axis=1))


def _feels_travel(load: Load) -> bool:
    """Whether a load depends on the direction of travel: a load of the process, or a function of the motion."""
    return _is_function(load) if isinstance(load, PointForce | PointMoment) else not isinstance(load, Spring)


def _is_function(load: PointForce | PointMoment) -> bool:
    return callable(load.force if isinstance(load, PointForce) else load.moment)


def _holding(press: Linkage, grid: PathGrid, loads: Sequence[Load]) -> Array:
    """(k,) torque that holds the press at rest at the end of each leg [N m]."""
    ends = grid.legs.angles[1:]
    return inverse_dynamics(press, _moved(press, ends, np.zeros_like(ends), np.zeros_like(ends)), loads, bearings=()).driving_torque


def _moved(press: Linkage, angle: Array, speed: Array, acceleration: Array) -> Motion:
    return moved(press, press.branch, angle, speed, acceleration, None, "auto")


def _marks(press: Linkage, start: float, end: float, positions: Array) -> Array:
    """Places between the ends of a leg at which the slide is at one of these positions, or turns back, in the order of the leg."""
    samples = np.linspace(start, end, LOOKED + 1)
    motion = _moved(press, samples, np.ones_like(samples), np.zeros_like(samples))
    above = motion.slide_position[None] - positions[:, None]  # (positions, samples)
    curves = np.concatenate([above, motion.slide_velocity[None]])
    which, before = np.nonzero(np.signbit(curves[:, :-1]) != np.signbit(curves[:, 1:]))
    if not len(which):
        return np.empty(0)
    offset = np.append(positions, 0.0)[which]
    turns = which == len(positions)

    def off(angle: Array) -> tuple[Array, Array]:
        at = _moved(press, angle, np.ones_like(angle), np.zeros_like(angle))
        return (
            np.where(turns, at.slide_velocity, at.slide_position - offset),
            np.where(turns, at.slide_acceleration, at.slide_velocity),
        )

    low, high = np.minimum(samples[before], samples[before + 1]), np.maximum(samples[before], samples[before + 1])
    found = np.sort(bracketed_roots(off, low, high, absolute=ROUNDING))
    found = found[(np.abs(found - start) > APART) & (np.abs(found - end) > APART)]
    found = found[np.append(True, np.diff(found) > APART)] if len(found) else found
    return found if end > start else found[::-1]


def _grade_nodes(start: float, end: float, marks: Array, count: int, even: bool) -> Array:
    """About ``count`` + 1 nodes from start to end, through the marks; equally spaced, or closer to each other towards both ends."""
    fine = np.linspace(0.0, 1.0, 2049)
    graded = fine if even else _denser_at_ends(fine, GRADED)
    borders = np.concatenate([[0.0], np.interp((marks - start) / (end - start), graded, fine), [1.0]])
    pieces = []
    for low, high in itertools.pairwise(borders.tolist()):
        # the torque may change much in a short piece between loads and windows, so each piece gets some nodes
        steps = max(1, round(count * ((1.0 - SHARED) * (high - low) + SHARED / (len(borders) - 1))))
        pieces.append(low + (high - low) * _denser_at_ends(np.arange(steps) / steps, BRAKED if len(marks) else 0.0))
    places = np.concatenate([*pieces, [1.0]])
    shares = places if even else _denser_at_ends(places, GRADED)
    nodes = start + (end - start) * shares
    nodes[np.searchsorted(places, borders)] = np.concatenate([[start], marks, [end]])
    return nodes


def _denser_at_ends(share: Array, grading: float) -> Array:
    """Places from 0 to 1, moved closer to each other towards both ends."""
    return np.asarray((1.0 - grading) * share + grading * 0.5 * (1.0 - np.cos(np.pi * share)))
