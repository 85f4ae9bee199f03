"""The moving press of a report: the linkage, its motion with reactions, and the key frames that all charts share."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...common.errors import PinpressError
from ...common.outlets import described
from ...common.quantities import RPM, Array
from ...dynamics.applied_loads import turning_points
from ...dynamics.extremes import at_peaks, rounding
from ...dynamics.reactions import Reactions
from ...kinematics.described import along_motion
from ...kinematics.motion import Motion, is_constant
from ...linkage.linkage import Linkage, is_same_press, told_apart
from ...simulation.run import Run
from ..recording import KeyFrames, key_frames


@dataclass(frozen=True, eq=False)
class Shown:
    """The moving press of a page.

    Attributes:
        press: The linkage.
        reactions: Reactions to its motion.
        frames: Key frames of the motion.
        bottom: Slide position at bottom dead centre [m]; None without a dead centre.
        drawn: Reactions whose states the curves show: ``reactions``, perhaps with additional states on both sides of each step of the load.
        states: (c,) indices of the curves' states in `drawn`: key frames, and both states at each step of the load.
        time: (c,) times of these states, 0 at the first [s].
        along: (c,) quantity over which the curves are drawn, in its unit.
    """

    press: Linkage
    reactions: Reactions
    frames: KeyFrames
    bottom: float | None
    drawn: Reactions
    states: NDArray[np.intp]
    time: Array
    along: Array

    @property
    def motion(self) -> Motion:
        """The motion of the reactions."""
        return self.reactions.motion

    @cached_property
    def sections(self) -> Sequence[described.Section]:
        """The sections of the reactions."""
        return self.reactions.described()

    @cached_property
    def charts(self) -> Mapping[str, described.Chart | described.Bars | described.Polar | described.Map]:
        """The charts of the reactions by their names."""
        return described.charts_of(self.sections)

    @property
    def period(self) -> float | None:
        """Crank angle of a period [deg], negative if the crank turns from 0 down; None without a period or if the driver slides."""
        turns, crank = self.motion.period_turns, self.frames.crank
        if turns is None or not self.motion.driver_coordinates[0].turns:
            return None
        return -360.0 * turns if crank[-1] < crank[0] else 360.0 * turns

    @property
    def own_along(self) -> Array | None:
        """(c,) quantity over which the curves are drawn; None if their states are the key frames only."""
        return None if self.drawn is self.reactions else self.along

    @property
    def keys(self) -> NDArray[np.intp]:
        """(k,) indices of the key frames in `drawn`."""
        return self.states[np.searchsorted(self.time, self.frames.time)]

    @property
    def heights(self) -> Array | None:
        """(k,) heights of the slide above bottom dead centre at the key frames [mm]; None without a dead centre."""
        if self.frames.height is None or not self.frames.above_bottom:
            return None
        return np.asarray(1e3 * self.frames.height)


def as_shown(reactions: Reactions, frames: KeyFrames) -> Shown:
    """The moving press of a page, from reactions and the key frames of their motion; raises `PinpressError` as `extremes`."""
    rounding(reactions)  # raises an error if a force is not finite
    press = reactions._press
    bottom = -math.inf if press.slide is None else turning_points(press)[0]
    motion, peaks = reactions.motion, at_peaks(reactions)
    beside = np.flatnonzero([bool(remark) for remark in peaks.remarks])  # the states on both sides of each step of the load
    drawn = peaks.reactions if len(beside) else reactions
    states, time, crank = frames.states, frames.time, frames.crank
    if len(beside):
        its, angle = drawn.motion.time, drawn.motion.crank_angle.reshape(len(peaks.remarks), -1)[:, 0]
        states = np.append(np.searchsorted(its, motion.time[states]), beside)
        time, crank = np.append(time, its[beside] - motion.time[0]), np.append(crank, angle[beside])
        order = np.argsort(time, kind="stable")
        states, time, crank = states[order], time[order], crank[order]
    along = time if along_motion(motion).name == "time" else motion.driver_coordinates[0].scale * crank
    return Shown(press, reactions, frames, bottom if math.isfinite(bottom) else None, drawn, states, time, along)


def before_shown(before: Reactions, motion: Motion) -> Shown:
    """The dashed curves: another press, or this one at another operating point.

    Raises:
        PinpressError: ``before`` is over another quantity than the motion, or turns the other way.
    """
    its, over = along_motion(before.motion).name, along_motion(motion).name
    if its != over:
        raise PinpressError(f"before is over {its}, the motion over {over}: compare a cycle with a cycle, or a run with a run")
    frames = key_frames(before._press, before.motion)
    if over != "time" and (motion.crank_angle[-1] > motion.crank_angle[0]) != (frames.crank[-1] > frames.crank[0]):
        raise PinpressError("before turns the other way than the motion: compare two that turn the same way")
    return as_shown(before, frames)


def in_words(motion: Motion) -> str:
    """Description of the motion, as text."""
    if isinstance(motion, Run):
        return f"simulated run of {motion.time[-1]:.6g} s"
    if motion.crank_speed.ndim == 1 and is_constant(motion.crank_speed):
        speed = float(motion.crank_speed[0])
        moving = f"crank at {speed / RPM:.6g} r/min" if motion.driver_coordinates[0].turns else f"driver at {1e3 * speed:.6g} mm/s"
        return moving.replace("-", "\u2212")
    return "prescribed motion"


def refuse_others(what: str, press: Linkage, shown: Shown) -> None:
    """Raise PinpressError if a result is of another press than the page."""
    if not is_same_press(press, shown.press):
        its = told_apart(press, shown.press)
        raise PinpressError(f"results: the {what} is of {its}, the page of {shown.press.name}: give one of the same press")
