"""The path of a point of a link over a motion, such as a point of a coupler: velocity, acceleration and curvature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..common import tables
from ..common.arguments import suitable_numbers, typed
from ..common.errors import PinpressError, shown
from ..common.frozen import read_only
from ..common.quantities import Array
from ..common.results import Tabular
from ..linkage.linkage import Linkage
from .motion import Motion, is_cycle, refuse_motion_of_another
from .poses import point_on_body

REST = 1e-9  # share of the largest speed, or acceleration across the path, below which it is rounding


@dataclass(frozen=True, eq=False, repr=False)
class PointTrace(Tabular):
    """How a point of a link moves, in the n states of a motion.

    Attributes:
        name: of the point.
        link: name of its link.
        point: (3,) where it is in the link's own frame [m].
        motion: the motion.
        position: (n, 3) in world axes [m].
        velocity: (n, 3) [m/s].
        acceleration: (n, 3) [m/s2].
    """

    name: str
    link: str
    point: Array
    motion: Motion
    position: Array
    velocity: Array
    acceleration: Array

    @property
    def speed(self) -> Array:
        """(n,) size of the velocity [m/s]."""
        return np.asarray(np.linalg.norm(self.velocity, axis=1))

    @property
    def _across(self) -> Array:
        """(n, 3) curvature vectors, from the point towards the centre of curvature [1/m]; NaN where the point rests."""
        speed = self.speed
        moving = np.where(speed > REST * speed.max(initial=0.0), speed, np.nan)[:, None]
        along = self.velocity / moving
        across = self.acceleration - (self.acceleration * along).sum(axis=1, keepdims=True) * along
        sizes = np.linalg.norm(self.acceleration, axis=1)
        across[np.linalg.norm(across, axis=1) <= REST * sizes.max(initial=0.0)] = 0.0  # straight
        return np.asarray(across / moving**2)

    @property
    def curvature(self) -> Array:
        """(n,) curvature of the path [1/m]: 0 where it is straight, NaN where the point rests."""
        return np.asarray(np.linalg.norm(self._across, axis=1))

    @property
    def radius(self) -> Array:
        """(n,) radius of curvature of the path [m]: infinite where it is straight, NaN where the point rests."""
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / self.curvature)

    @property
    def centre(self) -> Array:
        """(n, 3) centre of curvature in world axes [m]; NaN where the path is straight or the point rests."""
        across = self._across
        size = (across**2).sum(axis=1, keepdims=True)
        return np.asarray(self.position + across / np.where(size > 0, size, np.nan))

    @property
    def length(self) -> float:
        """Length of the path over the motion [m], over a `cycle` back to its beginning.

        Over a cycle at even times it is exact to rounding where the point does not rest; else to the fourth order in the step, and to the
        second where the point rests.

        Raises:
            PinpressError: the states have no time.
        """
        speed, time = self.speed, self.motion.time
        if is_cycle(self.motion):
            return float(speed.mean() * (2 * time[-1] - time[-2] - time[0]))
        rest = np.where(speed > 0, speed, 1.0)
        slope = (self.velocity * self.acceleration).sum(axis=1) / rest
        step = np.diff(time)
        return float((0.5 * step * (speed[1:] + speed[:-1]) - step**2 / 12 * np.diff(slope)).sum())

    @property
    def area(self) -> float:
        """Area that the path encloses over a `cycle` [m2]; of a path through space that of its widest shadow.

        Raises:
            PinpressError: the motion is no cycle.
        """
        if not is_cycle(self.motion):
            raise PinpressError(f"the motion of point {self.name} is no cycle, so that its path encloses no area: give a cycle")
        time = self.motion.time
        swept = np.cross(self.position - self.position[0], self.velocity).mean(axis=0)
        return float(0.5 * np.linalg.norm(swept) * (2 * time[-1] - time[-2] - time[0]))

    @property
    def title(self) -> str:
        return f"PointTrace of {self.name}, a point of {self.link}: {len(self.position)} states, at up to {self.speed.max():.6g} m/s"

    def columns(self) -> dict[str, tables.Column]:
        """A row for each state."""
        columns: dict[str, tables.Column] = dict(self.motion.position_columns())
        vectors = (("position", "m", self.position), ("velocity", "m/s", self.velocity), ("acceleration", "m/s2", self.acceleration))
        for name, unit, values in vectors:
            columns |= tables.by_axis(name, unit, values)
        return columns | {"curvature [1/m]": self.curvature}


@typed
def trace(press: Linkage, motion: Motion, link: str, point: ArrayLike = (0.0, 0.0, 0.0), name: str | None = None) -> PointTrace:
    """Follow a point of a link over a motion; that of an `ElasticRun` is followed on its rigid links.

    Args:
        press: the linkage.
        motion: its motion.
        link: name of the link.
        point: (3,) in the link's own frame [m].
        name: of the point; by default link and point.

    Raises:
        UnknownNameError: a link that the linkage does not have.
        PinpressError: a point of another shape or not finite; a motion of a linkage with other joints or lengths.
    """
    refuse_motion_of_another(press, motion)
    what = f"trace of {shown(link)}"
    place = suitable_numbers(f"{what}: point", point, "x, y, z in the link's frame [m]", (3,))
    joint, on_body = point_on_body(press, link, place, what, "point")
    if joint:
        moved = press.engine().body_motion(motion.states(press), [joint], accelerations=True).points(on_body[None])
        vectors = [np.array(each[0].T) for each in moved]
    else:
        vectors = [np.tile(on_body, (len(motion.v), 1)), *np.zeros((2, len(motion.v), 3))]
    label = f"{link} ({', '.join(f'{value:g}' for value in place)})" if name is None else str(name)
    return PointTrace(label, link, read_only(place), motion, *map(read_only, vectors))
