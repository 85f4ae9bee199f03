"""A press that swings on its mounts in one mode after another, as content of a recording; see `swinging.record_modes`.

The links ride with the part of the frame that carries them. The frame is drawn as lines: of a rigid part from its centre of mass to
everything that it stands on or carries, of one that bends the lines of its model. A short line below each foot is its mount.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..common.errors import PinpressError
from ..common.quantities import RPM, Array, ComplexArray
from ..foundation.elastic_frame import ElasticFrame
from ..foundation.frame_parts import rows_at
from ..foundation.mounted_press import MountedPress, VibrationModes
from ..foundation.whirl_modes import WhirlDiagram
from ..kinematics.cycle import motion_through_change_points
from ..kinematics.poses import Poses, poses
from ..kinematics.servo_motion import servo_cycle
from ..linkage.linkage import Linkage, is_same_press, told_apart
from .deflected import SEEN, rotation_matrices
from .pages import packed
from .recording import KeyFrames, moving, shapes
from .shapes.appearance import bodies

PAD = 0.05  # length of the line of a mount, share of the size of the picture


class FrameLine(NamedTuple):
    """A line of the frame: its name, its nodes (k, 3), and the rows (k, 3, n) of their displacements."""

    name: str
    places: Array
    rows: Array


class _Mode(NamedTuple):
    """A mode: its shape (n,), which moves as the real part of it times exp(i phase), frequency [rad/s], and what is said of it."""

    shape: ComplexArray
    frequency: float
    words: str


def content(press: Linkage, modes: VibrationModes | WhirlDiagram, count: int, frames: tuple[int, int, float, float]) -> dict[str, Any]:
    """What a page of the lowest modes shows; the crank stands at its zero.

    Args:
        press: the press.
        modes: its modes on its mounts.
        count: number of modes, the lowest.
        frames: key frames of a vibration, vibrations of a mode, key frames a second, and the pause between modes [s].

    Raises:
        PinpressError: the modes are of another press.
    """
    system, (swing, swings, rate, pause) = modes.system, frames
    refuse_modes_of_another(press, system.press)
    shown = _modes(modes)[:count]
    keys = swing * swings + 1
    drawn = np.zeros((keys, len(press.drivers)))
    several = len(press.drivers) > 1
    motion = servo_cycle(press, drawn, speed=drawn) if several else motion_through_change_points(press, drawn[:, 0], 0.0)
    still, lines = poses(press, motion.joint_position), frame_lines(system)
    size = max(press.size, float(np.ptp(np.vstack([line.places for line in lines]), axis=0).max()))
    films = [_film(system, still, lines, mode, SEEN * size, 2 * np.pi * np.arange(keys) / swing) for mode in shown]
    length = (keys - 1) / rate
    start = np.arange(len(shown)) * (length + pause)
    time, crank = (start[:, None] + np.arange(keys) / rate).ravel(), np.zeros(keys * len(shown))
    key_frames = KeyFrames(np.tile(np.arange(keys), len(shown)), time, crank, crank, None, False, keys)
    whole = Poses(*(np.concatenate([getattr(film[0], name) for film in films], axis=1) for name in ("rotation", "position")))
    found = moving(press, motion, key_frames, whole, None, ()) | shapes(press, key_frames, whole, bodies(press, motion.joint_position))
    found |= {"traces": [], "frequency": [mode.frequency / (2 * np.pi) for mode in shown for _ in range(keys)]}
    found |= {
        "modes": [
            {"name": f"mode {k + 1}", "start": float(start[k]), "end": float(start[k] + length), "words": mode.words}
            for k, mode in enumerate(shown)
        ]
    }
    found |= {
        "bends": [
            {"link": line.name, "nodes": packed(np.concatenate([film[1][k] for film in films]), f"the lines of {line.name}")}
            for k, line in enumerate(lines)
        ]
    }
    return found


def _modes(modes: VibrationModes | WhirlDiagram) -> list[_Mode]:
    """The modes by rising frequency; those of a diagram at its highest speed."""
    found = []
    if isinstance(modes, WhirlDiagram):
        at = f"at {modes.speed[-1] / RPM:.4g} r/min"
        for k in np.argsort(modes.frequency[-1]):
            whirls = f", whirls {modes.words(int(k))}" if modes.words(int(k)) else ""
            hertz, ratio = modes.frequency[-1, k] / (2 * np.pi), modes.damping_ratio[-1, k]
            words = f"{hertz:.4g} Hz {at}, damping ratio {ratio:.3g}: {modes.motion(int(k))}{whirls}"
            found.append(_Mode(modes.shapes[-1, k], float(modes.frequency[-1, k]), words))
        return found
    for k, w in enumerate(modes.natural_frequency):
        words = f"{w / (2 * np.pi):.4g} Hz, resonance at {w / RPM:.4g} r/min, damping ratio {modes.damping_ratio[k]:.3g}: {modes.motion[k]}"
        found.append(_Mode(np.asarray(-1j * modes.shapes[:, k], dtype=complex), float(w), words))
    return found


def _film(system: MountedPress, still: Poses, lines: list[FrameLine], mode: _Mode, seen: float, phase: Array) -> tuple[Poses, list[Array]]:
    """Poses of the bodies over phases (keys,), and nodes (keys, k, 3) of each line; the largest displacement of a node is ``seen``."""
    amplitude = max(float(np.linalg.norm(np.abs(line.rows @ mode.shape), axis=1).max()) for line in lines)
    coordinates = seen / amplitude * np.real(mode.shape * np.exp(1j * phase)[:, None])
    carried = coordinates @ system.parts[system.carrier].T
    turn, shift = rotation_matrices(carried[:, 3:]), carried[:, :3]
    at = Poses(turn @ still.rotation, (turn @ still.position[..., None])[..., 0] + shift)
    return at, [line.places + np.einsum("kin,sn->ski", line.rows, coordinates) for line in lines]


def frame_lines(system: MountedPress) -> list[FrameLine]:
    """The lines of the frame, its attachments and its mounts."""
    found = list(_elastic_lines(system.frame, len(system.mass))) if isinstance(system.frame, ElasticFrame) else _rigid_lines(system)
    for name, each in system.attached.items():
        on, centre = system.parts[system.carrier if each.on is None else each.on], np.asarray(each.body.centre, dtype=float)
        ends = [np.asarray(spring.point, dtype=float) for spring in each.springs] or [_nearest(found, centre)]
        for end in ends:
            own = system.parts[name]
            foot = rows_at(own if each.springs else on, end)
            found.append(FrameLine(name, np.array([centre, end]), np.array([rows_at(own, centre), foot])))
    down = PAD * float(np.ptp(np.vstack([line.places for line in found]), axis=0).max())
    for k, mount in enumerate(system.mounts):
        foot = np.array(mount.point)
        rows = np.array([system.mount_rows[k], np.zeros_like(system.mount_rows[k])])
        found.append(FrameLine(f"mount {k + 1}", np.array([foot, foot - [0.0, 0.0, down]]), rows))
    return found


def _rigid_lines(system: MountedPress) -> list[FrameLine]:
    """Lines from the centre of mass of each rigid part to its mounts and columns."""
    found = []
    points: dict[str, list[Any]] = {part: [upright.point for upright in system.uprights] for part in (system.bed, system.carrier)}
    points[system.bed] = [*points[system.bed], *(mount.point for mount in system.mounts)]
    for part, ends in points.items():
        body = system.frame if part == system.bed else system.crown
        if body is None or isinstance(body, ElasticFrame):
            continue
        centre = np.asarray(body.centre, dtype=float)
        for end in ends:
            places = np.array([centre, end])
            found.append(FrameLine(part, places, np.array([rows_at(system.parts[part], place) for place in places])))
    return found


def _elastic_lines(frame: ElasticFrame, count: int) -> list[FrameLine]:
    """The lines of a frame's model; without any, from its middle to each interface."""
    shapes = np.pad(frame.shapes, ((0, 0), (0, 0), (0, count - frame.shapes.shape[2])))
    if len(frame.lines):
        return [FrameLine("frame", frame.places[chain], shapes[chain]) for chain in _chains(frame)]
    middle = np.mean(list(frame.nodes.values()), axis=0)
    whole = rows_at(np.eye(6, count), middle)
    ends = [
        (np.array(place), rows_at(np.pad(frame.motions[name], ((0, 0), (0, count - shapes.shape[2]))), place))
        for name, place in frame.nodes.items()
    ]
    return [FrameLine("frame", np.array([middle, place]), np.array([whole, rows])) for place, rows in ends]


def _chains(frame: ElasticFrame) -> list[list[int]]:
    """Numbers of the nodes along lines that follow each other."""
    found: list[list[int]] = []
    for one, two in frame.lines.tolist():
        if found and found[-1][-1] == one:
            found[-1].append(two)
        else:
            found.append([one, two])
    return found


def _nearest(lines: list[FrameLine], place: Array) -> Array:
    """The node of the lines that is nearest to a place."""
    nodes = np.vstack([line.places for line in lines])
    return np.asarray(nodes[np.linalg.norm(nodes - place, axis=1).argmin()])


def refuse_modes_of_another(press: Linkage, other: Linkage) -> None:
    """Raise PinpressError where modes are of another press than this one."""
    if not is_same_press(other, press):
        raise PinpressError(f"the modes are of {told_apart(other, press)}, and the press is {press.name}: give those of the same one")
