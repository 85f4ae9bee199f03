"""A press that swings on its mounts in one mode after another, as content of a recording; see `swinging.record_modes`.

The links ride with the part of the frame that carries them. The frame is drawn as lines: of a rigid part from its centre of mass to
everything that it stands on or carries, of one that bends the lines of its model. A short line below each foot is its mount.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..common.errors import PinpressError
from ..common.quantities import RPM, Array, ComplexArray
from ..foundation.frame_lines import FrameLine, frame_lines
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


def refuse_modes_of_another(press: Linkage, other: Linkage) -> None:
    """Raise PinpressError where modes are of another press than this one."""
    if not is_same_press(other, press):
        raise PinpressError(f"the modes are of {told_apart(other, press)}, and the press is {press.name}: give those of the same one")
