"""Vibrations of a press on its springs, or of its frame on its mounts, as a recording: `record_modes`.

The press swings in one of its natural vibrations while its crank goes slowly through a turn, so that one sees how the vibration changes.
Mode follows mode in the time of the page, which repeats the one that is chosen. A flexible link is drawn as it is on the whole, with the
line of its nodes between two bearings bent over it.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..common.arguments import expect, typed, whole_number
from ..common.quantities import Array, ComplexArray
from ..elasticity.vibration import ElasticModes
from ..engines.planar.model import to_world
from ..foundation.mounted_press import VibrationModes
from ..foundation.whirl_modes import WhirlDiagram
from ..kinematics.cycle import motion_through_change_points
from ..kinematics.motion import Motion
from ..kinematics.poses import Poses, poses
from ..linkage.linkage import Linkage
from ..simulation.elastic.flexible_link import FlexibleBody
from ..simulation.elastic.press.assembly import sprung_press
from ..simulation.elastic.press.plane import PlaneGeometry
from . import swinging_frame
from .deflected import IN_SPACE, SEEN, displaced
from .pages import meshcat, packed, page, write
from .recording import KeyFrames, moving, shapes
from .shapes.appearance import bodies

RATE = 24  # key frames a second
SWING = 24  # key frames of a vibration
SWINGS = 20  # in a turn
STANDING = 4  # where the crank stands
PAUSE = 1.0  # between modes in the time of the page, which does not show it [s]
MOST = 24  # modes of a page
TURNED = 0.25  # a turn counts as the displacement this far from the centre of mass, as a share of the linkage's size
BESIDE = 0.02  # share of the distance of two bearings by which nodes lie beside the line that is drawn


@typed
def record_modes(
    press: Linkage, modes: ElasticModes | VibrationModes | WhirlDiagram, path: str | os.PathLike[str], *, lowest: int = 4
) -> Path:
    """Write a self-contained page in which the press swings in its natural vibrations, and return its path.

    The crank goes through the angles of the modes, a turn in 20 seconds; at one angle alone, and on mounts, it stands. Displacements are
    magnified so that they can be seen, for each mode by its own factor; vibrations are slowed down to one a second. The page says
    frequency, damping ratio, and what yields and moves. ``#t=`` at the end of its address stops it, as in `record`.

    Args:
        press: the linkage.
        modes: its vibrations, of `natural_frequencies`; or those on its mounts, of `foundation.modes`, or of `foundation.whirl` at the
            highest speed.
        path: path of the file, usually ending in `.html`.
        lowest: number of modes that are shown, from 1 to 24, the lowest first.

    Raises:
        PinpressError: the modes are of another press, Meshcat is not installed, or the file cannot be written.
    """
    most = whole_number("lowest", lowest, 1, MOST)
    if isinstance(modes, VibrationModes | WhirlDiagram):
        film = swinging_frame.content(press, modes, most, (SWING, STANDING, RATE, PAUSE))
        return write(path, page("recording.html", f"{press.name} on its mounts: vibrations", film, {"viewer": meshcat()}))
    expect("modes", modes, ElasticModes, "natural_frequencies")
    swinging_frame.refuse_modes_of_another(press, modes._press)
    count = min(most, modes.natural_frequency.shape[1])
    standing = len(modes.crank_angle) == 1
    keys = SWING * (STANDING if standing else SWINGS) + 1
    state = np.zeros(keys, dtype=int) if standing else (np.arange(keys) * len(modes.crank_angle) // (keys - 1)) % len(modes.crank_angle)
    one = _swinging(press, modes, state)
    whole, bends = _joined([one.mode(k) for k in range(count)])
    length = (keys - 1) / RATE
    start = np.arange(count) * (length + PAUSE)
    time = (start[:, None] + np.arange(keys) / RATE).ravel()
    crank = np.tile(modes.crank_angle[state], count)
    first = one.motion.driver_coordinates[0]
    frames = KeyFrames(np.tile(np.arange(keys), count), time, crank, first.scale * crank, None, False, keys)
    drawn = bodies(press, one.motion.joint_position)
    content = moving(press, one.motion, frames, whole, None, ()) | shapes(press, frames, whole, drawn)
    content |= {"traces": [], "modes": [_words(modes, k, start[k], length) for k in range(count)]}
    content |= {"frequency": [float(f"{each:.6g}") for each in (modes.natural_frequency[state, :count].T / (2 * np.pi)).ravel()]}
    content |= {"bends": [{"link": name, "nodes": packed(nodes, f"the line of {name}")} for name, nodes in bends.items()]}
    return write(path, page("recording.html", f"{press.name}: vibrations", content, {"viewer": meshcat()}))


def _words(modes: ElasticModes, mode: int, start: float, length: float) -> dict[str, Any]:
    state = modes.nearest_to_bottom
    yields, moves = modes.words(state, mode)
    hertz, ratio = modes.natural_frequency[:, mode] / (2 * np.pi), modes.damping_ratio[state, mode]
    span = f"{hertz[state]:.4g} Hz" if len(hertz) == 1 else f"{hertz.min():.4g} to {hertz.max():.4g} Hz"
    words = f"{span}; at {np.degrees(modes.crank_angle[state]):.4g} deg damping ratio {ratio:.3g}, yields: {yields}; moves: {moves}"
    return {"name": f"mode {mode + 1}", "start": float(start), "end": float(start + length), "words": words}


class _ModeFilm(NamedTuple):
    """One mode over the key frames: poses of the bodies, and the nodes (keys, k, 3) of the line of each flexible link."""

    at: Poses
    lines: dict[str, Array]


class _Swinging(NamedTuple):
    """A press at the key frames of a mode.

    Attributes:
        press: the linkage.
        modes: its vibrations.
        geometry: of the press on its springs; None in space, where no links bend.
        state: (keys,) angles of the modes at the key frames.
        motion: of the rigid press.
        at: its poses.
    """

    press: Linkage
    modes: ElasticModes
    geometry: PlaneGeometry | None
    state: Any
    motion: Motion
    at: Poses

    def mode(self, number: int) -> _ModeFilm:
        """A mode while it swings; its sign goes on from angle to angle."""
        shape, bending = self.modes.shapes[:, number], self.modes._bending[:, number]
        straight = 3 if shape.shape[-1] == IN_SPACE else 2
        weighed = np.concatenate([shape[..., :straight], self.press.size * shape[..., straight:]], axis=2)
        both = np.concatenate([weighed.reshape(len(shape), -1), bending], axis=1)
        same = np.where((both[1:] * both[:-1]).sum(axis=1) < 0, -1.0, 1.0)
        sign = np.cumprod(np.append(1.0, same))
        bent = [np.abs(bending[:, _own(self.geometry, each)] @ each.shapes.T) for each in self.geometry.flexible] if self.geometry else []
        # all that a link does that turns about its centre of mass
        turned = TURNED * self.press.size * float(np.abs(shape[..., straight:]).max())
        largest = max(float(np.abs(shape[..., :straight]).max()), turned, *(float(each.max(initial=0.0)) for each in bent))
        swing = np.sin(2 * np.pi * np.arange(len(self.state)) / SWING)
        factor = (SEEN * self.press.size / largest * swing * sign[self.state])[:, None]
        moved = factor[:, :, None] * shape[self.state]
        at = displaced(self.press, self.at, moved)
        if self.geometry is None:
            return _ModeFilm(at, {})
        angles = self.geometry.rigid(self.motion)[0]
        lines = {}
        for link in self.geometry.flexible:
            nodes = _line(link)
            if len(nodes) < 3:
                continue
            turn = np.exp(1j * (angles[:, 3 * link.body + 2] + moved[:, link.body, 2]))[:, None]
            places = link.places[nodes] + (factor * bending[self.state][:, _own(self.geometry, link)]) @ link.shapes[nodes].T
            centre = at.points(link.body + 1, self.press.model.inertias[link.body + 1].lever)
            lines[link.name] = centre[:, None, :] + to_world(self.geometry.plane, turn * places)
        return _ModeFilm(at, lines)


def _swinging(press: Linkage, modes: ElasticModes, state: Any) -> _Swinging:
    geometry = None if modes.shapes.shape[-1] == IN_SPACE else sprung_press(press, modes.elastic).geometry
    motion = motion_through_change_points(press, modes.crank_angle[state], 0.0)
    return _Swinging(press, modes, geometry, state, motion, poses(press, motion.joint_position))


def _joined(films: list[_ModeFilm]) -> tuple[Poses, dict[str, Array]]:
    """One film after another."""
    rotation, position = (np.concatenate([getattr(film.at, name) for film in films], axis=1) for name in ("rotation", "position"))
    return Poses(rotation, position), {name: np.concatenate([film.lines[name] for film in films]) for name in films[0].lines}


def _own(geometry: PlaneGeometry, link: FlexibleBody) -> slice:
    """Coordinates of a flexible link's shapes among those of all flexible links."""
    first = geometry.rigid_size
    return slice(link.columns.start - first, link.columns.stop - first)


def _line(link: FlexibleBody) -> Any:
    """Nodes on the line between the two bearings that are farthest from each other, from one to the other."""
    ends: ComplexArray = link.places[list(link.nodes)]
    one, two = np.unravel_index(np.abs(ends[:, None] - ends).argmax(), (len(ends), len(ends)))
    along = (link.places - ends[one]) / (ends[two] - ends[one])
    on = np.flatnonzero((np.abs(along.imag) < BESIDE) & (along.real > -BESIDE) & (along.real < 1 + BESIDE))
    return on[np.argsort(along.real[on], kind="stable")]
