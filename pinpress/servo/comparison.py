"""Comparison of motions of a servo press: what each motion needs from the drive, and which limits it breaks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..common import tables
from ..common.arguments import typed
from ..common.errors import PinpressError
from ..common.frozen import FrozenMapping
from ..common.quantities import RPM
from ..common.results import Record, Records, Tabular
from ..linkage.linkage import is_same_press
from .limits import (
    BearingForce,
    FeedWindow,
    Limit,
    TorqueRate,
    checked,
    in_words,
)
from .motion import ServoMotion, largest_size

KEPT = 1e-3  # share by which a motion may exceed a limit that it keeps: best motions exceed theirs by less between nodes
NOT_SEEN = BearingForce, TorqueRate  # limits that cannot be checked from the states of a motion
UNITS = {
    "rms_torque": "N m",
    "peak_torque": "N m",
    "top_speed": "rad/s",
    "peak_power": "W",
    "energy_drawn": "J",
    "cycle": "s",
    "more_than_least": "-",
}


@dataclass(frozen=True, repr=False)
class ComparedMotion(Record, units=UNITS):
    """One motion of a comparison.

    Attributes:
        name: name of the motion.
        rms_torque: rms torque of the motor, at the motor's shaft [N m].
        peak_torque: largest torque of the motor, at the motor's shaft [N m].
        top_speed: largest speed of the motor [rad/s].
        peak_power: largest mechanical power [W].
        energy_drawn: energy drawn from the mains in a cycle [J].
        cycle: time of a cycle [s].
        more_than_least: rms torque / least rms torque of the motions that keep all limits, less 1 [-]; None if no motion keeps all limits.
        breaks: the limits that the motion breaks, with the motion's values; empty if it keeps all limits.
    """

    name: str
    rms_torque: float
    peak_torque: float
    top_speed: float
    peak_power: float
    energy_drawn: float
    cycle: float
    more_than_least: float | None
    breaks: str


@dataclass(frozen=True, eq=False, repr=False)
class MotionComparison(Tabular):
    """Comparison of motions of one press.

    Attributes:
        motions: name of a motion -> the motion.
        limits: limits that the motions should keep, in addition to those of their drives.
        rows: what each motion needs from its drive, and which limits it breaks.
    """

    motions: Mapping[str, ServoMotion]
    limits: tuple[Limit, ...]
    rows: Records[ComparedMotion]

    @property
    def title(self) -> str:
        """The press, the number of motions, and the motion with the least rms torque among the motions that keep the limits."""
        press_name = next(iter(self.motions.values())).press_name
        least = next((row for row in self.rows if row.more_than_least == 0 and not row.breaks), None)
        said = "none keeps its limits" if least is None else f"least rms torque of the motor {least.rms_torque:.6g} N m by {least.name}"
        return f"MotionComparison for {press_name}: {len(self.rows)} motions, {said}"

    def columns(self) -> dict[str, tables.Column]:
        """A row for each motion."""
        return self.rows.columns()


@typed
def compare_motions(motions: Mapping[str, ServoMotion], limits: Sequence[Limit] = ()) -> MotionComparison:
    """Compare motions of one press: how much a better motion saves.

    Args:
        motions: name of a motion -> the motion; for instance the motion of `best_motion` and the motions of `ready_motions`.
        limits: limits that the motions should keep, in addition to those of their drives. Limits of bearing forces and of the rate of
            torque are not checked; the printed comparison lists them.

    Raises:
        PinpressError: there is no motion, a value is not a `ServoMotion`, the motions belong to several presses, or neither `RmsTorque` nor
            the drive gives a torque.
    """
    if not motions or not all(isinstance(motion_, ServoMotion) for motion_ in motions.values()):
        raise PinpressError("motions has no motions to compare: give them with their names, {'least heat': best.motion, ...}")
    first = next(iter(motions.values()))._press
    if not all(is_same_press(motion_._press, first) for motion_ in motions.values()):
        raise PinpressError("the motions belong to several presses: compare motions of one press")
    checked_limits = checked(limits)
    broken = {name: _broken(motion_, checked_limits) for name, motion_ in motions.items()}
    keeping = [motion_.rms_motor_torque for name, motion_ in motions.items() if not broken[name]]
    least = min(keeping) if keeping else None

    def row(name: str, motion: ServoMotion) -> ComparedMotion:
        return ComparedMotion(
            name=str(name),
            rms_torque=motion.rms_motor_torque,
            peak_torque=motion.peak_motor_torque,
            top_speed=float(np.abs(motion.motor_speed).max()),
            peak_power=motion.peak_power,
            energy_drawn=motion.energy_drawn,
            cycle=motion.duration,
            more_than_least=motion.rms_motor_torque / least - 1 if least else None,
            breaks="; ".join(broken[name]),
        )

    return MotionComparison(FrozenMapping(dict(motions)), checked_limits, Records(ComparedMotion, [row(*item) for item in motions.items()]))


def _broken(motion: ServoMotion, limits: Sequence[Limit]) -> list[str]:
    """The limits that a motion breaks, as text."""
    drive, texts = motion.drive, []
    of_drive = (
        ("peak torque", motion.peak_motor_torque, None if drive.curve_torque else drive.peak_torque, "N m"),
        ("top speed", float(np.abs(motion.motor_speed).max()), drive.top_speed, "rad/s"),
        ("power", motion.peak_power, drive.power, "W"),
    )
    for name, value, most, unit in of_drive:
        if most is not None and value > (1 + KEPT) * most:
            texts.append(f"{name} of {most:.6g} {unit}: {value:.4g}")
    if drive.curve_torque is not None:
        use = np.abs(motion.motor_torque) / drive.peak_torque_at(motion.motor_speed)
        k = int(use.argmax())
        if use[k] > 1 + KEPT:
            speed = abs(float(motion.motor_speed[k])) / RPM
            texts.append(f"curve of torque at {speed:.4g} r/min: {abs(float(motion.motor_torque[k])):.4g} N m")
    for limit in limits:
        if isinstance(limit, NOT_SEEN):
            continue
        if isinstance(limit, FeedWindow):
            above = motion.duration - float(motion.weight @ (motion.height < limit.height))  # pauses with them
            if above < (1 - KEPT) * limit.time:
                texts.append(f"{in_words(limit)}: {above:.4g} s")
            continue
        value, most = largest_size(motion, limit)
        if value > (1 + KEPT) * most:
            texts.append(f"{in_words(limit)}: {value:.4g}")
    return texts
