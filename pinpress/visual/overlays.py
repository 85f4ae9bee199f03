"""What a recording shows over the links: names of bearings, forces as arrows, and the paths of slide and chosen points."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..common.arguments import expect
from ..common.errors import PinpressError, shown
from ..common.quantities import Array
from ..dynamics import applied_loads
from ..dynamics.inverse_dynamics import Reactions
from ..kinematics.motion import Motion, Poses, bearing_points
from ..linkage.linkage import Linkage
from .key_frames import Keys
from .pages import packed
from .shapes.appearance import Body
from .shapes.bearing_layout import TOWARDS

BEHIND = 0.01  # of the linkage's size: by how much links are behind the frame to be looked at from there
TOGETHER = 1e-6  # of the linkage's size: bearings that stay this close share a label


def bearings(press: Linkage, at: Poses, keys: Keys, reactions: Reactions | None) -> dict[str, Any]:
    """Places (k, 3) at which bearings are, each once, and the bearings' names with their places and forces (k, 3)."""
    points = bearing_points(press, at)
    where, places = _merged(points, TOGETHER * press.size)
    return {
        "places": [_packed_path(points[first], "the place of a bearing") for first in places],
        "bearings": [
            {
                "name": name,
                "place": place,
                "force": None if reactions is None else packed(reactions.bearing_force[name][keys.states], f"bearing_force[{shown(name)}]"),
            }
            for name, place in zip(press.bearings, where, strict=True)
        ],
    }


def shaking(reactions: Reactions | None, keys: Keys) -> dict[str, Any]:
    """The shaking force (k, 3), None without reactions, and the largest force of all that are shown [N]."""
    if reactions is None:
        return {"shaking": None, "peak": 0.0}
    force = reactions.shaking_force[keys.states]
    all_forces = [force, *(values[keys.states] for values in reactions.bearing_force.values())]
    peak = max(float(np.linalg.norm(values, axis=1).max()) for values in all_forces)
    return {"shaking": packed(force, "shaking_force"), "peak": peak}


def traces(press: Linkage, at: Poses, keys: Keys, chosen: Sequence[tuple[str, ArrayLike]]) -> dict[str, Any]:
    """Paths (k, 3): of the slide's origin, if there is a slide, and of the chosen points, each a link and x, y, z in its frame [m].

    Raises:
        PinpressError: an unknown link, or a point that is none.
    """
    paths = []
    for trace in traced(press, chosen):
        path = packed(at.points(trace.joint, trace.point), f"the path of {trace.name}")
        paths.append({"name": trace.name, "link": trace.link, "path": path, "keys": keys.turn})
    return {"traces": paths}


class Trace(NamedTuple):
    """A point whose path is drawn.

    Attributes:
        name: of the path.
        link: on which the point is.
        joint: in whose frame the point is fixed.
        point: (3,) place in that frame [m].
    """

    name: str
    link: str
    joint: int
    point: Array


def traced(press: Linkage, chosen: Sequence[tuple[str, ArrayLike]]) -> list[Trace]:
    """The points whose paths are drawn.

    Raises:
        PinpressError: an unknown link, or a point that is none.
    """
    found = []
    if press.slide is not None:
        joint, origin = applied_loads.point_on_body(press, press.slide, (0, 0, 0), "slide", "origin")
        found.append(Trace(press.slide, press.slide, joint, origin))
    for link, point in _listed(chosen):
        joint, local = applied_loads.point_on_body(press, link, point, f"trace of {shown(link)}", "point")
        words = ", ".join(f"{value:g}" for value in np.asarray(point, dtype=float))
        found.append(Trace(f"{link} ({words})", link, joint, local))
    return found


def belonging(press: Linkage, motion: Motion, reactions: Reactions) -> None:
    """Refuse reactions that are not those to the motion of the press.

    Raises:
        PinpressError: they are of another press or motion.
    """
    expect("reactions", reactions, Reactions, "inverse_dynamics")
    other, its = reactions.motion, reactions._press
    same = other is motion or (
        other.joints == motion.joints and np.array_equal(other.joint_position, motion.joint_position) and np.array_equal(other.v, motion.v)
    )
    if not same:
        raise PinpressError(
            f"the reactions are of another motion of {other.linkage}: give those that inverse_dynamics(press, motion) returns for this one"
        )
    if its is not press and not (its.name == press.name and its.bearings == press.bearings and its.model == press.model):
        raise PinpressError(f"the reactions are of {its.name}, another press than {press.name}: give those of the same one")


def front(press: Linkage, at: Poses, drawn: Sequence[Body]) -> list[float]:
    """Direction (3,) from which a press is looked at: the normal of its plane, on the side on which its moving links stand before the
    frame, or on that of -y, but not from below; [] in space."""
    turning = [at.rotation[j, 0] @ axis.direction for j, axis in enumerate(press.axes, 1) if axis.turns]
    if not turning or any(np.linalg.norm(np.cross(turning[0], axis)) > 1e-6 for axis in turning):
        return []
    normal = turning[0] * (1.0 if turning[0] @ TOWARDS > 0 else -1.0)
    heights: dict[bool, list[float]] = {True: [], False: []}  # of parts along the normal: of the frame's, of the moving links'
    for body in drawn:
        frame = press.model.frames[body.frame]
        places = [at.points(frame.parentJoint, frame.placement.act(part.placement[:3, 3]))[0] for part in body.parts]
        heights[frame.parentJoint == 0] += [float(place @ normal) for place in places]
    if all(heights.values()) and np.mean(heights[True]) > np.mean(heights[False]) + BEHIND * press.size and normal[2] < 0.5:
        normal = -normal
    return [float(value) for value in normal]


def _merged(points: Array, near: float) -> tuple[list[int], list[int]]:
    """For every bearing its place, and for every place its first bearing; points (bearings, k, 3)."""
    where: list[int] = []
    places: list[int] = []
    for number, path in enumerate(points):
        found = next((i for i, first in enumerate(places) if np.abs(points[first] - path).max() <= near), None)
        if found is None:
            places.append(number)
        where.append(len(places) - 1 if found is None else found)
    return where, places


def _packed_path(path: Array, what: str) -> str:
    return packed(path[:1] if np.ptp(path, axis=0).max() == 0.0 else path, what)  # one point where it rests


def _listed(chosen: object) -> list[tuple[str, ArrayLike]]:
    if not isinstance(chosen, list | tuple) or not all(isinstance(trace, list | tuple) and len(trace) == 2 for trace in chosen):
        raise PinpressError(f"traces is {shown(chosen)}: give a list of a link and a point in its frame, e.g. [('coupler', (0.6, 0, 0))]")
    return list(chosen)
