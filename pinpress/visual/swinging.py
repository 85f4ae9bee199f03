"""Vibrations of an elastic press, or of a press on its mounts, as a recording: `record_modes`.

The press vibrates in one of its natural modes. For an elastic press the crank slowly makes a turn, to show how the vibration changes. The
modes follow one another in the time of the page; the page repeats the chosen mode.

A flexible link is drawn undeformed, and the bent line of its nodes between two bearings is drawn over it. On mounts, the links move with
the part of the frame that carries them. The frame is drawn as lines: a rigid part from its centre of mass to its mounts and everything that
it carries, an elastic part by the lines of its model. A short line below each foot is its mount.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..common.arguments import expect, typed, whole_number
from ..common.errors import PinpressError
from ..common.quantities import RPM, Array, ComplexArray
from ..elasticity.vibration import ElasticModes
from ..engines.planar.model import to_world
from ..foundation.frame_lines import frame_lines
from ..foundation.mounted_press import VibrationModes
from ..foundation.whirl_modes import WhirlDiagram
from ..kinematics.cycle import motion_through_change_points
from ..kinematics.motion import Motion
from ..kinematics.poses import Poses, poses
from ..kinematics.servo_motion import servo_cycle
from ..linkage.linkage import Linkage, is_same_press, told_apart
from ..simulation.elastic.flexible_link import FlexibleBody
from ..simulation.elastic.press.assembly import sprung_press
from .deflected import IN_SPACE, SEEN, displaced, rotation_matrices
from .pages import meshcat, packed, page, write
from .recording import KeyFrames, moving, shapes
from .shapes.appearance import bodies

RATE = 24  # key frames a second
SWING = 24  # key frames of a vibration
STANDING = 4  # vibrations shown for each mode if the crank stands still
MOST = 24  # most modes of a page


class Film(NamedTuple):
    """A mode over its k key frames.

    Attributes:
        at: poses of the bodies.
        lines: name and nodes (k, n, 3) of each bent line [m].
        frequency: (k,) natural frequency [rad/s].
        words: description of the mode on the page.
    """

    at: Poses
    lines: list[tuple[str, Array]]
    frequency: Array
    words: str


@typed
def record_modes(
    press: Linkage, modes: ElasticModes | VibrationModes | WhirlDiagram, path: str | os.PathLike[str], *, lowest: int = 4
) -> Path:
    """Write a self-contained page in which the press vibrates in its natural modes, and return its path.

    The crank goes through the angles of the modes, with 20 seconds for a turn. It stands still if there is only one angle, and on mounts.
    Displacements are magnified, with a separate factor for each mode, and vibrations are slowed down to one per second. The page shows
    frequency, damping ratio, and the parts with most of the strain and kinetic energy. ``#t=`` at the end of its address stops it, as in
    `record`.

    Args:
        press: the linkage.
        modes: natural modes from `natural_frequencies`; or, for a press on its mounts, from `foundation.modes`, or from `foundation.whirl`
            at the highest speed.
        path: path of the file, usually ending in `.html`.
        lowest: number of shown modes, from 1 to 24, the lowest first.

    Raises:
        PinpressError: the modes are of another press, Meshcat is not installed, or the file cannot be written.
    """
    most = whole_number("lowest", lowest, 1, MOST)
    if isinstance(modes, VibrationModes | WhirlDiagram):
        other, title = modes.system.press, f"{press.name} on its mounts: vibrations"
    else:
        expect("modes", modes, ElasticModes, "natural_frequencies")
        other, title = modes._press, f"{press.name}: vibrations"
    if not is_same_press(other, press):
        raise PinpressError(f"the modes are of {told_apart(other, press)}, and the press is {press.name}: give modes of the same press")
    motion, films = on_springs(press, modes, most) if isinstance(modes, ElasticModes) else _on_mounts(press, modes, most)
    return write(path, page("recording.html", title, _content(press, motion, films), {"viewer": meshcat()}))


def _content(press: Linkage, motion: Motion, films: list[Film]) -> dict[str, Any]:
    """Data of the page: one film after another, each over all states of the motion, with a hidden second in between."""
    keys = len(motion.crank_angle)
    length = (keys - 1) / RATE
    start = np.arange(len(films)) * (length + 1.0)
    time = (start[:, None] + np.arange(keys) / RATE).ravel()
    crank = np.tile(motion.crank_angle.reshape(keys, -1)[:, 0], len(films))
    states = np.tile(np.arange(keys), len(films))
    frames = KeyFrames(states, time, crank, motion.driver_coordinates[0].scale * crank, None, False, keys)
    whole = Poses(*(np.concatenate([getattr(film.at, name) for film in films], axis=1) for name in ("rotation", "position")))
    drawn = bodies(press, motion.joint_position)
    return {
        **moving(press, motion, frames, whole, None, ()),
        **shapes(press, frames, whole, drawn),
        "traces": [],
        "modes": [
            {"name": f"mode {k + 1}", "start": float(start[k]), "end": float(start[k] + length), "words": film.words}
            for k, film in enumerate(films)
        ],
        "frequency": [each / (2 * np.pi) for film in films for each in film.frequency.tolist()],
        "bends": [
            {"link": name, "nodes": packed(np.concatenate([film.lines[k][1] for film in films]), f"the line of {name}")}
            for k, (name, _) in enumerate(films[0].lines)
        ],
    }


def on_springs(press: Linkage, modes: ElasticModes, most: int) -> tuple[Motion, list[Film]]:
    """The motion of the crank, and films of up to ``most`` of the lowest modes in its states."""
    angles = len(modes.crank_angle)
    keys = SWING * (STANDING if angles == 1 else 20) + 1
    state = np.arange(keys) * angles // (keys - 1) % angles
    swing = np.sin(2 * np.pi * np.arange(keys) / SWING)
    motion = motion_through_change_points(press, modes.crank_angle[state], 0.0)
    rigid = poses(press, motion.joint_position)
    geometry = None if modes.shapes.shape[-1] == IN_SPACE else sprung_press(press, modes.elastic).geometry
    bending_links: list[tuple[FlexibleBody, slice]] = []  # with the slice of their coordinates; in space no links bend
    if geometry is not None:
        first, angles_of_links = geometry.rigid_size, geometry.rigid(motion)[0]
        bending_links = [(link, slice(link.columns.start - first, link.columns.stop - first)) for link in geometry.flexible]
    films = []
    for number in range(min(most, modes.natural_frequency.shape[1])):
        shape, bending = modes.shapes[:, number], modes._bending[:, number]
        straight = 3 if geometry is None else 2
        weighed = np.concatenate([shape[..., :straight], press.size * shape[..., straight:]], axis=2)
        both = np.concatenate([weighed.reshape(len(shape), -1), bending], axis=1)
        sign = np.cumprod(np.append(1.0, np.where((both[1:] * both[:-1]).sum(axis=1) < 0, -1.0, 1.0)))  # continuous over the angle
        # a link may only rotate about its centre of mass, so a rotation counts as the displacement at a quarter of the press's size
        sizes = [np.abs(shape[..., :straight]), 0.25 * press.size * np.abs(shape[..., straight:])]
        sizes += [np.abs(bending[:, own] @ link.shapes.T) for link, own in bending_links]
        largest = max(float(size.max(initial=0.0)) for size in sizes)
        factor = (SEEN * press.size / largest * swing * sign[state])[:, None]
        moved = factor[:, :, None] * shape[state]
        at = displaced(press, rigid, moved)
        lines = []
        for link, own in bending_links:
            nodes = _line(link)
            if len(nodes) < 3:
                continue
            assert geometry is not None
            turn = np.exp(1j * (angles_of_links[:, 3 * link.body + 2] + moved[:, link.body, 2]))[:, None]
            places = link.places[nodes] + (factor * bending[state][:, own]) @ link.shapes[nodes].T
            centre = at.points(link.body + 1, press.model.inertias[link.body + 1].lever)
            lines.append((link.name, centre[:, None, :] + to_world(geometry.plane, turn * places)))
        films.append(Film(at, lines, modes.natural_frequency[state, number], _words(modes, number)))
    return motion, films


def _words(modes: ElasticModes, mode: int) -> str:
    state = modes.nearest_to_bottom
    yields, moves = modes.words(state, mode)
    hertz, ratio = modes.natural_frequency[:, mode] / (2 * np.pi), modes.damping_ratio[state, mode]
    span = f"{hertz[state]:.4g} Hz" if len(hertz) == 1 else f"{hertz.min():.4g} to {hertz.max():.4g} Hz"
    return f"{span}; at {np.degrees(modes.crank_angle[state]):.4g} deg damping ratio {ratio:.3g}, yields: {yields}; moves: {moves}"


def _line(link: FlexibleBody) -> Any:
    """Nodes within 2 % of the line between the two most distant bearings, in order along the line."""
    ends: ComplexArray = link.places[list(link.nodes)]
    one, two = np.unravel_index(np.abs(ends[:, None] - ends).argmax(), (len(ends), len(ends)))
    along = (link.places - ends[one]) / (ends[two] - ends[one])
    on = np.flatnonzero((np.abs(along.imag) < 0.02) & (np.abs(along.real - 0.5) < 0.52))
    return on[np.argsort(along.real[on], kind="stable")]


def _on_mounts(press: Linkage, modes: VibrationModes | WhirlDiagram, most: int) -> tuple[Motion, list[Film]]:
    """The press at zero, and films of up to ``most`` of the lowest modes; for a whirl diagram at its highest speed."""
    system, keys = modes.system, SWING * STANDING + 1
    phase, zero = 2 * np.pi * np.arange(keys) / SWING, np.zeros((keys, len(press.drivers)))
    several = len(press.drivers) > 1
    motion = servo_cycle(press, zero, speed=zero) if several else motion_through_change_points(press, zero[:, 0], 0.0)
    still, lines = poses(press, motion.joint_position), frame_lines(system)
    size = max(press.size, float(np.ptp(np.vstack([line.places for line in lines]), axis=0).max()))
    films = []
    for shape, frequency, words in _modes(modes)[:most]:
        largest = max(float(np.linalg.norm(np.abs(line.rows @ shape), axis=1).max()) for line in lines)  # displacement of a node
        coordinates = SEEN * size / largest * np.real(shape * np.exp(1j * phase)[:, None])
        carried = coordinates @ system.parts[system.carrier].T
        turn, shift = rotation_matrices(carried[:, 3:]), carried[:, :3]
        at = Poses(turn @ still.rotation, (turn @ still.position[..., None])[..., 0] + shift)
        bent = [(line.name, line.places + np.einsum("kin,sn->ski", line.rows, coordinates)) for line in lines]
        films.append(Film(at, bent, np.full(keys, frequency), words))
    return motion, films


def _modes(modes: VibrationModes | WhirlDiagram) -> list[tuple[ComplexArray, float, str]]:
    """Shape (n,), frequency [rad/s] and description of each mode by rising frequency; the displacement is the real part of shape x exp(i
    phase)."""
    if isinstance(modes, VibrationModes):
        return [
            (
                np.asarray(-1j * modes.shapes[:, k], dtype=complex),
                float(w),
                f"{w / (2 * np.pi):.4g} Hz, resonance at {w / RPM:.4g} r/min, damping ratio {ratio:.3g}: {modes.motion[k]}",
            )
            for k, (w, ratio) in enumerate(zip(modes.natural_frequency, modes.damping_ratio, strict=True))
        ]
    whirling = []
    for k in np.argsort(modes.frequency[-1]).tolist():
        w, whirls = float(modes.frequency[-1, k]), f", whirls {modes.words(k)}" if modes.words(k) else ""
        state = f"{w / (2 * np.pi):.4g} Hz at {modes.speed[-1] / RPM:.4g} r/min, damping ratio {modes.damping_ratio[-1, k]:.3g}"
        whirling.append((modes.shapes[-1, k], w, f"{state}: {modes.motion(k)}{whirls}"))
    return whirling
