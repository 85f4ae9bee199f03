"""Servo motions in reports: the best one with what limits it, others beside it, the motor and the capacitor that it needs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common import tables
from ...common.quantities import RPM, Array
from ...servo.comparison import MotionComparison
from ...servo.limits import SlideSpeed, span
from ...servo.motion import ServoMotion
from ...servo.motion_optimum import MotionOptimum
from ...servo.motors import CatalogueMotor
from ...servo.sizing import EnergyStore, MotorChoice
from .blocks import Block, Facts, Figure, Figures, Follows, Line, LineChart, Section, Table, with_prefix
from .shown import Shown, refuse_others

CURVE = 120  # points of a motor's curve
WANTED = {"heat": "heat in the motor", "time": "time of a cycle", "energy": "energy drawn", "peak": "peak torque"}


def optimum(best: MotionOptimum, shown: Shown) -> Section:
    """The section of a best motion; raises `PinpressError` where it is of another press."""
    refuse_others("motion", best._press, shown)
    motion, moving = best.motion, shown.motion is best.motion.motion
    blocks: list[Block] = [Figures(_figures(best)), _limits(best), *_over_time(motion, shown, moving)]
    blocks += _over_angle([("best", motion)], shown, moving)
    blocks.append(_plane(motion, None, shown, moving))
    if best.by_ratio:
        blocks.append(_ratios(best))
    wanted = " and ".join(WANTED.get(name, name) for name in best.minimise)
    proof = f"no motion along these nodes that keeps the limits is better than by {max(best.gap, 0.0):.1e} of it"
    proof = f"{proof}, and finer nodes may change it by {best.node_error:.1e}"
    note = f"Least {wanted}; {proof}: {_bound(best)}."
    return Section("Servo drive", blocks, [("servo drive", _drive_in_words(best))], " ".join([note, *map(_sentence, best.notes)]))


def _bound(best: MotionOptimum) -> str:
    return "the dual cost of its convex program is the proof" if best.gap < 1e-6 else "the gap between its value and the proved bound"


def _sentence(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}."


def _drive_in_words(best: MotionOptimum) -> str:
    drive = best.drive
    parts = [f"rotor {drive.inertia:g} kg m2", f"ratio {drive.ratio:g}", f"{drive.crank_inertia:.4g} kg m2 at the crank"]
    parts += [f"peak {drive.peak_torque:g} N m"] if drive.peak_torque is not None else []
    parts += [f"rated {drive.rated_torque:g} N m"] if drive.rated_torque is not None else []
    parts += [f"up to {drive.top_speed / RPM:.5g} r/min"] if drive.top_speed is not None else []
    return ", ".join(parts)


def _figures(best: MotionOptimum) -> list[Figure]:
    motion, drive = best.motion, best.drive
    rated = "" if drive.rated_torque is None else f"{100 * motion.rms_motor_torque / drive.rated_torque:.3g} % of the rated torque"
    peak = "" if drive.peak_torque is None else f"{100 * motion.peak_motor_torque / drive.peak_torque:.3g} % of the largest"
    return [
        Figure("motor, rms", with_prefix(motion.rms_motor_torque, "N m"), rated),
        Figure("motor, peak", with_prefix(motion.peak_motor_torque, "N m"), peak),
        Figure("peak power", with_prefix(motion.peak_power, "W"), "mechanical"),
        Figure("cycles", f"{60 / motion.duration:.4g} /min", f"{motion.duration:.4g} s each"),
        Figure("energy drawn", with_prefix(motion.energy_drawn, "J"), "in a cycle, from the mains"),
    ]


def _limits(best: MotionOptimum) -> Block:
    if not best.limits:
        return Facts("What limits where", [("limits", "none acts: the motion is free")])
    rows = []
    for each in best.limits:
        everywhere = abs(each.ends_at - each.begins_at) >= 0.999 * float(np.ptp(best.angle))
        ends = ["", ""] if everywhere else [f"{np.degrees(angle) % 360:.1f}" for angle in (each.begins_at, each.ends_at)]
        rows.append([each.limit, f"{each.gain:.3g}", *ends])
    return Table("What limits where", ["limit", "1 % more saves [%]", "from [deg]", "to [deg]"], rows)


def _over_time(motion: ServoMotion, shown: Shown, moving: bool) -> list[Block]:
    """Speed, torque and power of the motor over the time."""
    states = shown.frames.states if moving else np.arange(len(motion.time))
    along, across = (None, "") if moving else (motion.time, "time [s]")
    follows: Follows = "frames" if moving else "nothing"
    drive = motion.drive
    torque = tables.scale("N m", [motion.peak_motor_torque, drive.peak_torque or 0.0])
    power = tables.scale("W", [*motion.power[states], *motion.mains_power[states]])

    def line(name: str, values: Array | float, strong: bool = False) -> Line:
        return Line(name, np.broadcast_to(np.asarray(values, dtype=float), motion.time.shape)[states], along, strong=strong)

    speeds = [line("motor", motion.motor_speed / RPM)]
    speeds += [line("highest", drive.top_speed / RPM)] if drive.top_speed is not None else []
    torques = [line("motor", torque.factor * motion.motor_torque)]
    torques += [line("peak", torque.factor * drive.peak_torque)] if drive.peak_torque is not None else []
    torques += [line("rated", torque.factor * drive.rated_torque)] if drive.rated_torque is not None else []
    powers = [line("mechanical", power.factor * motion.power)]
    if np.any(motion.mains_power != motion.power):
        powers.append(line("with the motor's losses", power.factor * motion.mains_power))
    return [
        LineChart("Motor speed", "r/min", speeds, across=across, follows=follows),
        LineChart("Motor torque, at its own shaft", torque.unit, torques, across=across, follows=follows),
        LineChart("Power", power.unit, powers, across=across, follows=follows, note="below 0 the motor brakes"),
    ]


def _over_angle(motions: Sequence[tuple[str, ServoMotion]], shown: Shown, moving: bool) -> list[Block]:
    """Speed and torque of the crank over its angle."""
    first = shown.motion.driver_coordinates[0]
    across = f"{first.counted} [{first.shown_unit}]"
    single = all(np.ptp(np.sign(motion.speed[motion.speed != 0])) == 0 for _, motion in motions)
    follows: Follows = "position" if moving and single else "nothing"
    scale = tables.scale("N m", [motion.peak_torque for _, motion in motions])
    speeds, torques = [], []
    for name, motion in motions:
        angle, order = np.degrees(motion.angle), np.arange(len(motion.angle))
        if single:  # counted as the cursor is
            angle = angle % (360.0 * (motion.motion.period_turns or 1))
            order = np.argsort(angle, kind="stable")
        speeds.append(Line(name, motion.speed[order] / RPM, angle[order]))
        torques.append(Line(name, scale.factor * motion.torque[order], angle[order]))
    return [
        LineChart("Crank speed over its angle", "r/min", speeds, across=across, follows=follows),
        LineChart("Torque at the crank over its angle", scale.unit, torques, across=across, follows=follows),
    ]


def _plane(motion: ServoMotion, motor: CatalogueMotor | None, shown: Shown, moving: bool) -> LineChart:
    """Torque over the speed of the motor's own shaft, in all quadrants as sizes, below its curves."""
    drive, size = motion.drive, np.abs(motion.motor_speed) / RPM
    torque = np.abs(motion.motor_torque)
    most = max(motion.peak_motor_torque, drive.peak_torque or 0.0, 0.0 if motor is None else max(motor.peak_torque))
    scale = tables.scale("N m", [most])
    points = np.column_stack([size, scale.factor * torque])
    lines = [Line("motion", points[:, 1], points[:, 0], at_frames=points[shown.frames.states] if moving else None)]
    if motor is not None:
        speed = np.linspace(0.0, motor.top_speed, CURVE)
        lines.append(Line("peak torque", scale.factor * motor.peak_torque_at(speed), speed / RPM))
        lines.append(Line("permanent torque (S1)", scale.factor * motor.rated_torque_at(speed), speed / RPM))
    else:
        top = (drive.top_speed or float(np.abs(motion.motor_speed).max())) / RPM
        if drive.peak_torque is not None:
            speed = np.array([0.0, *(each for each in drive.curve_speed or () if 0.0 < each < top * RPM), top * RPM])
            lines.append(Line("peak torque", scale.factor * np.append(drive.peak_torque_at(speed), 0.0), np.append(speed / RPM, top)))
        if drive.rated_torque is not None:
            lines.append(Line("rated torque", np.full(2, scale.factor * drive.rated_torque), np.array([0.0, top])))
    mean = float(motion.weight @ np.abs(motion.motor_speed)) / motion.duration / RPM
    lines.append(Line("rms at the mean speed", np.array([scale.factor * motion.rms_motor_torque]), np.array([mean]), points=True))
    note = "sizes of torque and speed, driving and braking"
    return LineChart("Torque over speed", scale.unit, lines, across="speed of the motor [r/min]", follows="nothing", note=note)


def _ratios(best: MotionOptimum) -> Table:
    rows = [
        [f"{ratio:g}", "no motion keeps the limits" if not np.isfinite(value) else f"{value / best.value:.4f}"]
        for ratio, value in best.by_ratio.items()
    ]
    return Table("Gear ratios tried", ["ratio", "of the least"], rows)


def comparison(found: MotionComparison, shown: Shown) -> Section:
    """The section of motions beside one another; raises `PinpressError` where they are of another press."""
    motions = list(found.motions.items())
    refuse_others("comparison", motions[0][1]._press, shown)
    moving = any(motion.motion is shown.motion for _, motion in motions)
    torque = tables.scale("N m", [row.peak_torque for row in found.rows])
    power = tables.scale("W", [row.peak_power for row in found.rows])
    heads = [
        "motion",
        "limits",
        f"rms [{torque.unit}]",
        "more [%]",
        f"peak [{torque.unit}]",
        "top [r/min]",
        f"power [{power.unit}]",
        "drawn [kJ]",
    ]
    rows = []
    for row in found.rows:
        more = "" if row.more_than_least is None or row.breaks else f"{100 * row.more_than_least:.1f}"
        said = f"breaks {row.breaks}" if row.breaks else "kept"
        cells = [
            torque.shown(row.rms_torque),
            more,
            torque.shown(row.peak_torque),
            f"{row.top_speed / RPM:.5g}",
            power.shown(row.peak_power),
        ]
        rows.append([row.name, said, *cells, f"{1e-3 * row.energy_drawn:.4g}"])
    blocks: list[Block] = [Table("", heads, rows, words=2), *_slide_speeds(found), *_over_angle(motions, shown, moving)]
    note = "Torques and speeds of the motor at its own shaft, powers mechanical. What a law leaves free, as a ramp, is at its best."
    return Section("Motions beside one another", blocks, (), note)


def _slide_speeds(found: MotionComparison) -> list[Block]:
    """Speed of the slide on its way down over its height, with the limits."""
    lines = []
    for name, motion in found.motions.items():
        down = np.flatnonzero(motion.motion.slide_velocity <= 0)
        order = down[np.argsort(motion.height[down], kind="stable")]
        lines.append(Line(name, -motion.motion.slide_velocity[order], 1e3 * motion.height[order]))
    highest = max(float(line.x.max()) for line in lines if line.x is not None)
    for limit in found.limits:
        if isinstance(limit, SlideSpeed) and limit.flank != "up":
            low, high = (float(np.clip(1e3 * end, 0.0, highest)) for end in span(limit))
            lines.append(Line("limit", np.full(2, limit.speed), np.array([low, high]), strong=True))
    across = "height above bottom dead centre [mm]"
    return [LineChart("Slide speed on the way down", "m/s", lines, across=across, follows="nothing")]


def choice(found: MotorChoice, shown: Shown) -> Section:
    """The section of the choice of a motor; raises `PinpressError` where it is for another press."""
    refuse_others("choice", found._press, shown)
    heads = ["motor", "", "ratio", "rms [N m]", "at [r/min]", "thermal [%]", "peak [%]", "speed [%]", "power [kW]"]
    rows = []
    for each in found.tried:
        known = (each.rms_torque, each.mean_speed / RPM, 100 * each.thermal)
        of_motion = ((100, each.peak), (100, each.speed), (1e-3, each.peak_power))
        values = [f"{value:.4g}" for value in known] + ["" if value is None else f"{by * value:.4g}" for by, value in of_motion]
        rows.append([each.motor, each.remark or "suffices", f"{each.ratio:g}", *values])
    blocks: list[Block] = []
    if found.motor is not None and found.best is not None:
        blocks.append(_plane(found.best.motion, found.motor, shown, shown.motion is found.best.motion.motion))
    blocks.append(Table("Motors tried, the smallest first", heads, rows, words=2))
    said = (
        "None of the motors suffices."
        if found.motor is None or found.use is None
        else (f"{found.motor.name} with a gear of {found.use.ratio:g} is the smallest that suffices.")
    )
    note = (
        f"{said} Thermal: rms torque by the permanent torque at the mean speed. One that is too warm by the least heat is so by any motion."
    )
    return Section("Choice of the motor", blocks, (), note)


def energy_store(found: EnergyStore, shown: Shown) -> Section:
    """The section of a capacitor."""
    del shown  # it belongs to no press
    figures = [
        Figure("mean power", with_prefix(found.mean_power, "W"), "from the mains, with the capacitor"),
        Figure("peak power", with_prefix(found.peak_power, "W"), "from the mains, without it"),
        Figure("swing of energy", with_prefix(found.energy_swing, "J")),
        Figure("capacitor", with_prefix(found.capacitance, "F"), f"from {found.upper_voltage:g} to {found.lower_voltage:g} V"),
    ]
    return Section("Mains and capacitor", [Figures(figures)], (), "The mains feed the mean electrical power, the capacitor the rest.")
