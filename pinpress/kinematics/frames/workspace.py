"""The workspace of a linkage over the positions of two drivers: what is reached, and how near to singular poses it is there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common import tables
from ...common.arguments import number, typed, whole_number
from ...common.errors import PinpressError, SingularityError, UnknownNameError, shown
from ...common.quantities import Array, DriverCoordinate
from ...common.results import Tabular
from ...engines.mounting import limits
from ...engines.spatial.frames import moving_frame, placed_frame
from ...linkage.assembly import follow_drivers, refuse_far
from ...linkage.linkage import Linkage

NEARLY_LOCKED = 1e-3  # loop margin at which a grid ends: where it is zero is a thousandth of a node away, and takes half the steps
WAYS = ((0, 1), (0, -1), (1, 0), (-1, 0))  # from a node of the grid to its neighbours


@dataclass(frozen=True, eq=False, repr=False)
class ReachMap(Tabular):
    """What a linkage reaches over a grid of the positions of two drivers, a of the first one and b of the second, while others stand.

    Attributes:
        linkage: name of the linkage.
        frame: name of the frame that is looked at.
        drivers: names of the two drivers.
        driver_coordinates: what their coordinates are: angles [rad], or positions of drivers that slide [m].
        positions: (a,) of the first driver and (b,) of the second [rad or m].
        reached: (a, b) bool: whether the linkage comes there from its home pose in one assembly.
        within_limits: (a, b) bool: whether it comes there with all joints within their limits.
        place: (a, b, 3) of the frame's origin in world axes [m]; NaN where it is not reached, as the other values.
        loop_margin: (a, b) least singular value of the passive joints' columns in the equations of the loops, scaled to unit length [-].
            At zero the drivers do not determine the linkage: it locks, or two assemblies meet.
        frame_margin: (a, b) least singular value of the frame's Jacobian by all motors, but those that are zero everywhere: a way [lengths
            of the linkage] or an angle [rad], by an angle [rad] or a way [lengths of the linkage] of the motors [-]. At zero the frame
            cannot be moved one way, and holds any force that way.
        locks: (k, 2) positions of the two drivers at which the linkage locks, on the lines of the grid, to about 1e-3 of their distance
            [rad or m].
        dead_points: (m, 2) positions of the two drivers at which ``frame_margin`` is zero, on the lines of the grid, where the frame has as
            many freedoms as there are motors; else none are looked for [rad or m].
    """

    linkage: str
    frame: str
    drivers: tuple[str, str]
    driver_coordinates: tuple[DriverCoordinate, DriverCoordinate]
    positions: tuple[Array, Array]
    reached: NDArray[np.bool_]
    within_limits: NDArray[np.bool_]
    place: Array
    loop_margin: Array
    frame_margin: Array
    locks: Array
    dead_points: Array

    @property
    def title(self) -> str:
        rows = zip(self.drivers, self.driver_coordinates, self.positions, strict=True)
        ends = [f"{name} {at[0] * each.scale:.6g} to {at[-1] * each.scale:.6g} {each.shown_unit}" for name, each, at in rows]
        return (
            f"ReachMap of {self.linkage}: {self.frame} over {' and '.join(ends)}, {self.reached.sum()} of {self.reached.size} nodes reached"
        )

    def columns(self) -> dict[str, tables.Column]:
        """A row for each node that is reached."""
        grids = np.meshgrid(*self.positions, indexing="ij")
        heads = (f"{each.heads[0][0]}_{name} [{each.unit}]" for name, each in zip(self.drivers, self.driver_coordinates, strict=True))
        columns: dict[str, tables.Column] = {head: grid[self.reached] for head, grid in zip(heads, grids, strict=True)}
        columns |= tables.by_axis("place", "m", self.place[self.reached])
        return columns | {"loop_margin [-]": self.loop_margin[self.reached], "frame_margin [-]": self.frame_margin[self.reached]}


@typed
def workspace(
    press: Linkage,
    frame: str,
    ranges: Mapping[str, tuple[float, float]],
    *,
    points: int = 41,
    oriented: bool | None = None,
) -> ReachMap:
    """Find what a linkage reaches over a grid of the positions of two drivers, and where it is singular.

    From the node nearest to the home pose the assembly is followed from node to node along the lines of the grid. Other drivers stand where
    they are at home.

    Args:
        press: a linkage with two motors or more.
        frame: name of a link, as of `Linkage.placements`.
        ranges: names of two drivers -> their ends [rad or m].
        points: number of nodes along each, at least 3.
        oriented: whether the frame's Jacobian has rows of its orientation next to those of its position; None: where there are more than
            three motors.

    Raises:
        UnknownNameError: no link, or no driver of this name.
        PinpressError: other than two drivers, ends that are not finite or equal, beyond the limits of a driver that slides.
        SingularityError: the linkage locks on the way from its home pose to the nearest node.
    """
    named, count = press.frame_named(frame), whole_number("points", points, 3, 1000)
    for name in ranges:
        if name not in press.motors:
            raise UnknownNameError("driver", name, press.motors)
    if len(ranges) != 2:
        raise PinpressError(f"ranges is {shown(dict(ranges))}: give two of the drivers {', '.join(press.motors)} with their ends")
    columns = [press.drivers.index(name) for name in ranges]
    lines = [_nodes(name, ends, count) for name, ends in ranges.items()]
    home = press.closed[list(press.driver_indices)]
    grid = np.tile(home, (count, count, 1))
    grid[:, :, columns[0]], grid[:, :, columns[1]] = np.meshgrid(*lines, indexing="ij")
    refuse_far("ranges", grid, press.driver_coordinates)
    flooded = _flood(press, grid)
    place, loop_margin, frame_margin = np.full((count, count, 3), np.nan), *np.full((2, count, count), np.nan)
    x = flooded.position[:, flooded.reached]
    moving = moving_frame(press.loops_in_space, x, named, with_margins=True)
    place[flooded.reached] = placed_frame(press.loops_in_space, named, x)[:, :3, 3]
    loop_margin[flooded.reached] = moving.margins
    motors = len(press.motors)
    full = motors > 3 if oriented is None else oriented
    scaled = moving.columns.transpose(2, 0, 1)[:, : 6 if full else 3, :motors] * press.lengths[list(press.driver_indices[:motors])]
    scaled[:, :3] /= press.size
    values, signs = _least_singular_values(scaled)
    frame_margin[flooded.reached] = values
    signed = np.full((count, count), np.nan)
    signed[flooded.reached] = signs * values
    lower, upper = (limit[:, None, None] for limit in limits(press.structure))
    coordinates = tuple(press.driver_coordinates[column] for column in columns)
    return ReachMap(
        linkage=press.name,
        frame=frame,
        drivers=tuple(ranges),  # type: ignore[arg-type]
        driver_coordinates=coordinates,  # type: ignore[arg-type]
        positions=(lines[0], lines[1]),
        reached=flooded.reached,
        within_limits=flooded.reached & ((flooded.position >= lower) & (flooded.position <= upper)).all(axis=0),
        place=place,
        loop_margin=loop_margin,
        frame_margin=frame_margin,
        locks=flooded.locks[:, columns],
        dead_points=_zeros(lines, signed),
    )


def _nodes(name: str, ends: tuple[float, float], count: int) -> Array:
    low, high = (number(f"ranges[{name!r}]", end) for end in ends)
    if not low < high:
        raise PinpressError(f"ranges[{name!r}] is {low:g} to {high:g}: give the lower end, then the upper one")
    return np.linspace(low, high, count)


class _Flooded(NamedTuple):
    """Closed joint coordinates (nv, a, b), which nodes (a, b) are reached, and where (k, drivers) the linkage locks."""

    position: Array
    reached: NDArray[np.bool_]
    locks: Array


def _flood(press: Linkage, grid: Array) -> _Flooded:
    """Follow the assembly from node to node of a grid (a, b, drivers), until no line leads to another node."""
    shape, home = grid.shape[:2], press.closed
    engine, structure = press.engine(), press.structure
    away = np.abs(grid - home[list(press.driver_indices)]).sum(axis=2)
    i, k = divmod(int(away.argmin()), shape[1])
    position, reached = np.full((len(home), *shape), np.nan), np.zeros(shape, dtype=bool)
    position[:, i, k] = follow_drivers(engine, structure, home, grid[i, k][None], press.name)[:, 0]
    reached[i, k] = True
    waiting, locks = [(i, k, way) for way in WAYS], []
    while waiting:
        i, k, (across, up) = waiting.pop()
        line: list[tuple[int, int]] = []
        for step in range(1, shape[0]):
            node = (i + step * across, k + step * up)
            if not (min(node) >= 0 and max(node) < shape[0]) or reached[node]:
                break
            line.append(node)
        if not line:
            continue
        locked: dict[int, SingularityError] = {}
        ahead = tuple(np.transpose(line))
        moved = follow_drivers(engine, structure, position[:, i, k], grid[ahead], press.name, locked, NEARLY_LOCKED)
        count = min(locked, default=len(line))  # behind a lock the same line locks
        if locked:
            locks.append(locked[count].drivers)
        for node, x in zip(line[:count], moved.T, strict=False):
            position[:, node[0], node[1]], reached[node] = x, True
            waiting += [(*node, way) for way in WAYS if way[0] * across + way[1] * up == 0]
    return _Flooded(position, reached, np.reshape(locks, (-1, grid.shape[2])))


def _least_singular_values(jacobian: Array) -> tuple[Array, Array]:
    """Least singular values (n,) of Jacobians (n, rows, drivers), but those that are zero in all of them; and signs (n,) that change where
    one of them passes zero, NaN where none can be told."""
    values = np.linalg.svd(jacobian, compute_uv=False)
    count = int((values.max(axis=0) > 1e-9 * values.max()).sum())
    directions, sizes, _ = np.linalg.svd(jacobian.transpose(1, 0, 2).reshape(jacobian.shape[1], -1), full_matrices=False)
    spanned = directions[:, sizes > 1e-9 * sizes[0]]
    if spanned.shape[1] != jacobian.shape[2] or count != jacobian.shape[2]:
        return np.asarray(values[:, count - 1]), np.full(len(jacobian), np.nan)
    signs = np.asarray(np.sign(np.linalg.det(spanned.T @ jacobian)))
    return np.asarray(values[:, count - 1]), signs


def _zeros(lines: list[Array], values: Array) -> Array:
    """(m, 2) places on the lines of a grid at which values (a, b) change their sign, by straight lines between the nodes."""
    found = []
    for axis in (0, 1):
        before, after = (np.moveaxis(values, axis, 0)[part] for part in (slice(-1), slice(1, None)))
        i, k = np.nonzero(before * after < 0.0)
        share = before[i, k] / (before[i, k] - after[i, k])
        along = lines[axis][i] + share * (lines[axis][i + 1] - lines[axis][i])
        pair = (along, lines[1 - axis][k])
        found.append(np.column_stack(pair if axis == 0 else pair[::-1]))
    return np.concatenate(found)
