"""A recording: one web page that shows a press turning, with everything it needs inside the file.

The page holds Meshcat's viewer, the commands that build the scene, and a control bar of its own. It opens by double click,
without a server or a network. World axes are in metres, with z up; a planar press stands in the x-z plane and is seen from -y.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..common import files
from ..common.arguments import typed
from ..common.quantities import Array
from ..dynamics.inverse_dynamics import Reactions
from ..kinematics.motion import Motion, poses
from ..linkage.linkage import Linkage
from . import overlays, pages
from .key_frames import Keys, keys
from .shapes import meshcat_commands
from .shapes.appearance import Body, bodies


@typed
def record(
    press: Linkage,
    motion: Motion,
    path: str | os.PathLike[str],
    *,
    reactions: Reactions | None = None,
    traces: Sequence[tuple[str, ArrayLike]] = (),
) -> Path:
    """Write a self-contained page that shows the press moving, and return its path.

    The page plays in real time, or slowed down where a period takes less than half a second. A motion over one period is closed to a loop.
    Long motions are thinned to 360 key frames per turn of the crank. Equal input gives equal bytes. ``#t=0.25`` at the end of the page's
    address stops it at 0.25 s.

    Args:
        press: The linkage. The boxes, cylinders, spheres and meshes of its URDF's ``<visual>`` are drawn; links without any get shapes from
            their joints.
        motion: Motion of the linkage, with times.
        path: Path of the file, usually ending in `.html`. An old file is replaced only when the page is complete.
        reactions: Reactions to this motion. Bearing and guide forces (on child and link2, at their points of action) and the shaking force
            (with its tip at the foot of the press) are drawn as arrows, with one scale of length and colour for all.
        traces: Points whose paths are drawn, each the name of a link and x, y, z in its frame [m]. The slide's path is always drawn.

    Raises:
        PinpressError: The motion has no times, states more than 90 deg of the crank apart or more than 555 turns, a value is not finite,
            the reactions are of another motion or press, a shape cannot be drawn, Meshcat is not installed, or the file cannot be written.
        UnknownNameError: A trace is on a link that the linkage does not have.
    """
    shown = scene(press, motion, keys(press, motion), reactions, traces)
    return files.write(path, pages.page("recording.html", press.name, shown, pages.meshcat()))


def scene(
    press: Linkage, motion: Motion, frames: Keys, reactions: Reactions | None, traces: Sequence[tuple[str, ArrayLike]]
) -> dict[str, Any]:
    """What the page's player (`templates/playback.js`) shows, as JSON. Args and Raises as of `record`; ``frames`` are the motion's."""
    if reactions is not None:
        overlays.belonging(press, motion, reactions)
    position = motion.joint_position[frames.states]
    at, drawn = poses(press, position), bodies(press, position)
    of_body = {body.name: meshcat_commands.body_poses(press, at, body.frame) for body in drawn}
    return {
        **_series(frames),
        "legend": _legend(drawn, of_body),
        "front": overlays.front(press, at, drawn),
        "turn": frames.turn,
        "period": None if motion.period_turns is None else 360 * motion.period_turns,  # deg
        "size": press.size,
        **overlays.bearings(press, at, frames, reactions),
        **overlays.shaking(reactions, frames),
        **overlays.traces(press, at, frames, traces),
        "scene": meshcat_commands.pack(meshcat_commands.commands(drawn, of_body, frames.time)),
    }


def _series(frames: Keys) -> dict[str, Any]:
    return {
        "time": _short(frames.time),  # s
        "crank": _short(np.degrees(frames.crank)),  # deg
        "slide": None if frames.slide is None else _short(frames.slide),  # m
    }


def _short(values: Array) -> list[float]:
    """Numbers to nine digits: what a page needs, in half the characters."""
    return [float(f"{value:.9g}") for value in values.tolist()]


def _legend(drawn: Sequence[Body], of_body: dict[str, Array]) -> list[dict[str, str]]:
    """The moving links with the colour that most of their parts have."""
    moving = [body for body in drawn if meshcat_commands.moves(of_body[body.name])]
    colours = (Counter(meshcat_commands.hexadecimal(part.rgba) for part in body.parts).most_common(1)[0][0] for body in moving)
    return [{"name": body.name, "colour": f"#{colour}"} for body, colour in zip(moving, colours, strict=True)]
