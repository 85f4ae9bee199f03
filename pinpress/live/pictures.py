"""One picture of the window: where all links are over a period, the forces, and the curves next to them, as data of the page.

Each change of a slider makes a new picture. The shapes of the links take longest, and are made only if a window asks for them.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..common.quantities import Array
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..dynamics.reactions import Reactions
from ..engines.planar.engine import PlanarEngine
from ..kinematics.cycle import cycle
from ..kinematics.motion import Motion
from ..kinematics.poses import Poses, poses
from ..linkage.linkage import Linkage
from ..loads.link import Friction, Load
from ..visual import recording
from ..visual.pages import packed
from ..visual.shapes import meshcat_commands
from ..visual.shapes.appearance import ShownLink, bodies
from .drivers import standing, swing, swings

POINTS = 180  # states of a period
FEWEST = 36  # states of a period of a linkage that takes long


@dataclass(frozen=True, eq=False)
class Operation:
    """How a press runs in the window.

    Attributes:
        speed: of the driver [rad/s or m/s].
        loads: forces on links from outside, see `inverse_dynamics`.
        friction: by the names of bearings, see `inverse_dynamics`.
        stiffness: by the names of bearings, see `inverse_dynamics`.
        points: states of a period.
        swings: whether a crank that cannot turn on goes to and fro; else such a press is refused.
        traces: points whose paths are drawn, see `record`.
    """

    speed: float
    loads: Sequence[Load]
    friction: Mapping[str, Friction]
    stiffness: Mapping[str, float]
    points: int = POINTS
    swings: bool = False
    traces: Sequence[tuple[str, ArrayLike]] = ()


@dataclass(frozen=True, eq=False)
class Picture:
    """A press in motion, as the page shows it.

    Attributes:
        press: the press.
        data: what the page's scripts take.
        links: the links as they are shown.
        took: how long it took without shapes [s].
    """

    press: Linkage
    data: dict[str, Any]
    links: tuple[ShownLink, ...]
    took: float


def picture(
    press: Linkage,
    operation: Operation,
    shown: tuple[ShownLink, ...] | None,
    made_up: Mapping[str, Array] = NONE_GIVEN,
    *,
    first: bool = False,
) -> Picture:
    """Move a press through a period, and find forces, curves and poses.

    Args:
        press: the press.
        operation: how it runs.
        shown: the links as they are shown, whose shapes are kept; None for new shapes.
        made_up: links that are shown from their bearings, because their own shapes no longer fit, and their colours (4,).
        first: whether it is the first picture of a page, which takes the size of the press from its motion.

    Raises:
        PinpressError: what `cycle` and `inverse_dynamics` raise.
    """
    began = time.perf_counter()
    motion = (swing if operation.swings and swings(press) else cycle)(press, operation.speed, points=operation.points)
    reactions = inverse_dynamics(press, motion, operation.loads, operation.friction, operation.stiffness)
    frames = _frames(motion)
    at = poses(press, motion.joint_position[frames.states])
    data = recording.moving(press, motion, frames, at, reactions, operation.traces) | _curves(press, motion, reactions, frames)
    if standing(press):
        data["driver"] = data["driver"] | {"name": press.driver}
    took = time.perf_counter() - began
    links = shown
    if links is None:
        links = bodies(press, motion.joint_position[frames.states], made_up=made_up)
        links = tuple(_painted(link, made_up[link.name]) if link.name in made_up else link for link in links)
        data |= recording.shapes(press, frames, at, links, animated=first)
    data["poses"] = _poses(press, at, links)
    return Picture(press, data, links, took)


def colours(links: Sequence[ShownLink]) -> dict[str, Array]:
    """The colour (4,) of most parts of each link, by its name."""
    return {link.name: _main_colour(link) for link in links}


def _main_colour(link: ShownLink) -> Array:
    return np.array(Counter(tuple(part.rgba.tolist()) for part in link.parts).most_common(1)[0][0])


def _painted(link: ShownLink, colour: Array) -> ShownLink:
    """A link with another colour in place of the colour of most of its parts."""
    old = _main_colour(link)
    parts = (replace(part, rgba=colour) if np.array_equal(part.rgba, old) else part for part in link.parts)
    return replace(link, parts=tuple(parts))


def _frames(motion: Motion) -> recording.KeyFrames:
    """All states of one period at constant speed, and the first once more. Exact dead centres are left out: they take longest."""
    count, time = len(motion.time), motion.time
    order = np.append(np.arange(count), 0)
    crank, first = motion.crank_angle, motion.driver_coordinates[0]
    end = 2 * np.pi * motion.period_turns * np.sign(motion.crank_speed[0]) if motion.period_turns is not None else crank[0]
    crank = np.append(crank, end)
    height = None if motion._guide is None else _height(motion)[order]
    return recording.KeyFrames(order, np.append(time, time[-1] * count / (count - 1)), crank, first.scale * crank, height, True, count + 1)


def _height(motion: Motion) -> Array:
    """(n,) heights of the slide above its bottom [m]: that of the parabola through the lowest state."""
    at = int(motion.slide_position.argmin())
    velocity, acceleration = motion.slide_velocity[at], motion.slide_acceleration[at]
    below = 0.5 * velocity**2 / acceleration if acceleration > 0 else 0.0
    return np.asarray(motion.slide_position - (motion.slide_position[at] - below))


def suitable(press: Linkage, operation: Operation) -> Operation:
    """The operation with the number of states that can be computed within 40 ms: all in the plane; in space one picture is timed. Whether a
    crank swings is decided here: one that can turn fully must stay able to."""
    operation = replace(operation, swings=swings(press))
    if isinstance(press.engine(), PlanarEngine):
        return operation
    took = picture(press, replace(operation, points=FEWEST), None).took
    return replace(operation, points=int(np.clip(FEWEST * 0.04 / took, FEWEST, POINTS)))


def _poses(press: Linkage, at: Poses, links: Sequence[ShownLink]) -> list[str]:
    """Poses (k, 7) of the links, as `body_poses` gives them; (1, 7) of a link at rest."""
    paths = meshcat_commands.body_poses(press, at, [link.frame for link in links])
    shown = ((link.name, path if meshcat_commands.moves(path) else path[:1]) for link, path in zip(links, paths, strict=True))
    return [packed(path, f"the pose of {name}") for name, path in shown]


def _curves(press: Linkage, motion: Motion, reactions: Reactions, frames: recording.KeyFrames) -> dict[str, Any]:
    """Slide, torque and largest bearing force over the driver's position."""
    turns = motion.driver_coordinates[0].turns
    curves = []
    if press.slide is not None:
        curves.append(_curve("height of the slide", "m", _height(motion), frames))
    of_driver = f" of {press.driver}" if standing(press) else ""
    effort, unit = ("torque", "N m") if turns else ("force", "N")
    curves.append(_curve(f"driving {effort}{of_driver}", unit, reactions.driving_torque, frames))
    held = standing(press)
    for pair in held if len(held) <= 2 else ():  # there is no room for more
        effort, unit = ("torque", "N m") if press.axes[pair.follower].turns else ("force", "N")
        curves.append(_curve(f"{effort} that holds {pair.name}", unit, reactions.coupling_torque[pair.name][:, 0], frames))
    names = list(reactions.bearing_force)
    forces = np.array([np.linalg.norm(force, axis=1) for force in reactions.bearing_force.values()])
    largest = forces.argmax(axis=0)
    curves.append(_curve("largest bearing force", "N", forces.max(axis=0), frames) | {"at": [names[k] for k in largest[frames.states]]})
    return {"curves": curves}


def _curve(name: str, unit: str, values: Array, frames: recording.KeyFrames) -> dict[str, Any]:
    return {"name": name, "unit": unit, "values": packed(values[frames.states], name)}
