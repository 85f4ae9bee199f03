"""What results of servo presses show: the best motion with what limits it, the motions compared with it, the motor and the capacitor that
it needs, and the cam table of a motion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..common.outlets.described import Along, Block, Chart, Column, Curve, Figure, Section, Table
from ..common.quantities import RPM, Array
from ..dynamics.reactions import Reactions
from .cam_tables import TURN, CamPoints
from .comparison import NOT_SEEN, MotionComparison
from .drive import ServoDrive
from .limits import SlideSpeed, in_words, span
from .motion import ServoMotion
from .motion_optimum import UNITS, MotionOptimum
from .motors import CatalogueMotor
from .sizing import EnergyStore, MotorChoice

POINTS = 120  # of a motor's curve
HEIGHT = "height above bottom dead centre"
OBJECTIVES = {"heat": "heat in the motor", "time": "time of a cycle", "energy": "energy drawn", "peak": "peak torque"}
BRAKING = 0.5  # the limit in braking is drawn too if braking uses more than this share of it


def servo_motion(motion: ServoMotion, page: Reactions | None = None) -> tuple[Section, ...]:
    """A motion and what it needs from its drive."""
    blocks: list[Block] = [*_over_time(motion), *_over_angle({"motion": motion}), _plane(motion)]
    return (Section("Servo motion", _needs(motion), blocks, [("servo drive", _drive_in_words(motion.drive))], "", motion._press, "motion"),)


def optimum(best: MotionOptimum, page: Reactions | None = None) -> tuple[Section, ...]:
    """A best motion with its proof, and what limits it."""
    motion, minimise = best.motion, " and ".join(OBJECTIVES.get(name, name) for name in best.minimise)
    unit = UNITS[next(iter(best.minimise))] if len(best.minimise) == 1 else "-"
    figures = [
        Figure("objective", best.value, unit),
        Figure("no motion is below", best.bound, unit),
        Figure("gap", f"{best.gap:.1e}"),
        Figure("error of the nodes", f"{best.node_error:.1e}", "-", f"with {len(best.angle) - 1} segments"),
        *_needs(motion),
        Figure("limits are kept to", f"{best.missed:.1e}"),
        Figure("heat between nodes", f"{best.deviation:+.1e}", "-", "of that of the program"),
    ]
    blocks: list[Block] = [_limits(best)] if best.limits else []
    blocks += [*_over_time(motion), *_over_angle({"best": motion}), _plane(motion)]
    blocks += [_ratios(best)] if best.by_ratio else []
    proof = "the dual cost of its convex program is the proof" if best.gap < 1e-6 else "the gap between its value and the proved bound"
    better = f"no motion along these nodes that keeps the limits is better than by {max(best.gap, 0.0):.1e} of it"
    finer = f"finer nodes may change it by {best.node_error:.1e}"
    free = () if best.limits else ("no limit acts: the motion is free",)
    note = " ".join([f"Least {minimise}; {better}, and {finer}: {proof}.", *map(_sentence, (*free, *best.notes))])
    return (Section("Servo drive", figures, blocks, [("servo drive", _drive_in_words(best.drive))], note, best._press, "motion"),)


def comparison(found: MotionComparison, page: Reactions | None = None) -> tuple[Section, ...]:
    """Comparison of motions of one press."""
    rows = found.rows
    more = [None if row.more_than_least is None or row.breaks else row.more_than_least for row in rows]
    columns = [
        Column("motion", [row.name for row in rows]),
        Column("limits", ["broken" if row.breaks else "kept" for row in rows]),
        Column("rms", [row.rms_torque for row in rows], "N m"),
        Column("more", more, "share", 1.0),
        Column("peak", [row.peak_torque for row in rows], "N m"),
        Column("top", [row.top_speed for row in rows], "rad/s"),
        Column("power", [row.peak_power for row in rows], "W"),
        Column("drawn", [row.energy_drawn for row in rows], "J"),
        Column("cycle", [row.cycle for row in rows], "s"),
    ]
    unseen = [in_words(limit) for limit in found.limits if isinstance(limit, NOT_SEEN)]
    note = "Torques and speeds of the motor at its own shaft, powers mechanical. What a law leaves free, as a ramp, is at its best."
    note += f" Not looked at: {'; '.join(unseen)}." if unseen else ""
    blocks: list[Block] = [Table("motions", "", columns, most=200)]
    if broken := {row.name: f"breaks {row.breaks}" for row in rows if row.breaks}:
        words = [Column("motion", list(broken)), Column("limit and what the motion has", list(broken.values()))]
        blocks.append(Table("broken", "Limits that are broken", words, most=200))
    blocks += [_slide_speeds(found), *_over_angle(found.motions)]
    press = next(iter(found.motions.values()))._press
    return (Section("Motions beside one another", (), blocks, (), note, press, "comparison"),)


def choice(found: MotorChoice, page: Reactions | None = None) -> tuple[Section, ...]:
    """The choice of a motor."""
    tried = found.tried
    columns = [
        Column("motor", [each.motor for each in tried]),
        Column("", [each.remark or "suffices" for each in tried]),
        Column("ratio", [float(each.ratio) for each in tried]),
        Column("rms", [each.rms_torque for each in tried], "N m"),
        Column("at", [each.mean_speed for each in tried], "rad/s"),
        Column("thermal", [each.thermal for each in tried], "share"),
        Column("peak", [each.peak for each in tried], "share"),
        Column("speed", [each.speed for each in tried], "share"),
        Column("power", [each.peak_power for each in tried], "W"),
    ]
    figures: list[Figure] = []
    blocks: list[Block] = []
    chosen = "None of the motors suffices."
    if found.motor is not None and found.best is not None and found.use is not None:
        use, name = found.use, found.motor.name
        chosen = f"{name} with a gear of {use.ratio:g} is the smallest that suffices."
        figures = [
            Figure("thermal use", use.thermal, "share", "of the permanent torque at the mean speed, by the rms torque", kind="motor"),
            Figure("peak use", use.peak, "share", "of the peak torque at the same speed", kind="motor"),
            Figure("speed use", use.speed, "share", "of the highest speed", kind="motor"),
        ]
        blocks.append(_plane(found.best.motion, found.motor))
    blocks.append(Table("tried", "Motors tried, the smallest first", columns, most=200))
    thermal = "Thermal: rms torque by the permanent torque at the mean speed. One that is too warm by the least heat is so by any motion."
    return (Section("Choice of the motor", figures, blocks, (), f"{chosen} {thermal}", found._press, "choice"),)


def energy_store(found: EnergyStore, page: Reactions | None = None) -> tuple[Section, ...]:
    """A capacitor, which belongs to no press."""
    figures = [
        Figure("mean power", found.mean_power, "W", "from the mains, with the capacitor"),
        Figure("peak power", found.peak_power, "W", "from the mains, without it"),
        Figure("peak returned", found.peak_returned, "W", "by braking"),
        Figure("swing of energy", found.energy_swing, "J"),
        Figure("capacitor", found.capacitance, "F", f"from {found.upper_voltage:g} to {found.lower_voltage:g} V"),
    ]
    return (Section("Mains and capacitor", figures, note="The mains feed the mean electrical power, the capacitor the rest."),)


def cam_table(found: CamPoints, page: Reactions | None = None) -> tuple[Section, ...]:
    """A cam table, with its points."""
    scale, quantity = (1e-3, "m") if found.unit == "mm" else (np.pi / 180, "rad")
    master = Along("master angle", "rad", np.pi / 180 * found.master)
    points = Chart("cam", "Slave over the master axis", quantity, master, [Curve(found.of, scale * found.slave, look="marked")])
    rate = Chart("cam_rate", "Slave speed at this period", f"{quantity}/s", master, [Curve("speed", _speed(found, scale), look="marked")])
    figures = [
        Figure("points", float(len(found.master)), "-", f"{found.corners} at corners of the motion"),
        Figure("interpolation", found.interpolation),
        Figure("largest error", scale * found.error, quantity, f"at {found.error_at:.5g} deg of the master"),
        Figure("period", found.period, "s", "repeats itself" if found.closed else "does not repeat itself"),
    ]
    inputs = [("cam table", f"{found.of} in the layout {found.layout}")]
    return (Section("Cam table", figures, [points, rate], inputs, "", found._press, "motion"),)


def _speed(found: CamPoints, scale: float) -> Array:
    return scale * found.velocity * TURN / found.period


def _sentence(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}."


# ------------------------------------------------------------------------------------------------------------------- numbers and tables


def _drive_in_words(drive: ServoDrive) -> str:
    parts = [f"rotor {drive.inertia:g} kg m2", f"ratio {drive.ratio:g}", f"{drive.crank_inertia:.4g} kg m2 at the crank"]
    parts += [f"peak {drive.peak_torque:g} N m"] if drive.peak_torque is not None else []
    parts += [f"rated {drive.rated_torque:g} N m"] if drive.rated_torque is not None else []
    parts += [f"up to {drive.top_speed / RPM:.5g} r/min"] if drive.top_speed is not None else []
    return ", ".join(parts)


def _needs(motion: ServoMotion) -> list[Figure]:
    """What a motion needs from its drive, next to the drive's limits."""
    drive, speed = motion.drive, float(np.abs(motion.motor_speed).max())

    def used(name: str, value: float, unit: str, limit: float | None, words: str) -> Figure:
        share = "" if limit is None else f"{100 * value / limit:.3g} % {words}"
        return Figure(name, value, unit, share, limit, kind="motor")

    return [
        Figure("cycle", motion.duration, "s", f"{60.0 / motion.duration:.6g} a minute"),
        used("motor, rms torque", motion.rms_motor_torque, "N m", drive.rated_torque, "of the rated torque"),
        used("motor, peak torque", motion.peak_motor_torque, "N m", drive.peak_torque, "of the largest"),
        used("motor, highest speed", speed, "rad/s", drive.top_speed, "of the highest"),
        used("peak power", motion.peak_power, "W", drive.power, "of the largest, mechanical"),
        Figure("energy drawn", motion.energy_drawn, "J", "in a cycle, from the mains"),
        Figure("gear ratio", float(drive.ratio)),
    ]


def _limits(best: MotionOptimum) -> Table:
    """The active limits with their prices and ranges of crank angles; no angles for a limit that is active everywhere."""
    everywhere = [abs(limit.ends_at - limit.begins_at) >= 0.999 * float(np.ptp(best.angle)) for limit in best.limits]
    pairs = list(zip(best.limits, everywhere, strict=True))
    columns = [
        Column("limit", [limit.limit for limit in best.limits]),
        Column("price", [f"{limit.price:.6g} {limit.price_unit}" for limit in best.limits]),
        Column("1 % more saves", [limit.gain / 100 for limit in best.limits], "share"),
        Column("from", [None if always else limit.begins_at % (2 * np.pi) for limit, always in pairs], "angle"),
        Column("to", [None if always else limit.ends_at % (2 * np.pi) for limit, always in pairs], "angle"),
    ]
    return Table("limits", "What limits where", columns, most=200)


def _ratios(best: MotionOptimum) -> Table:
    shares = [value / best.value if np.isfinite(value) else "no motion keeps the limits" for value in best.by_ratio.values()]
    columns = [Column("ratio", [float(ratio) for ratio in best.by_ratio]), Column("of the least", shares, "-")]
    return Table("ratios", "Gear ratios tried", columns)


# ------------------------------------------------------------------------------------------------------------------------------- charts


def _over_time(motion: ServoMotion) -> list[Chart]:
    """Height of the slide, speed of the crank, torque and power of the motor over time, with the limits of the drive."""
    drive, along = motion.drive, Along("time", "s", motion.time, motion.motion)
    top = None if drive.top_speed is None else drive.top_speed / drive.ratio
    torques = [Curve("motor", motion.motor_torque), *_limit("peak", drive.peak_torque, motion.motor_torque)]
    torques += _limit("rated", drive.rated_torque, np.zeros_like(motion.time))
    speeds = [Curve("crank", motion.speed), *_limit("highest", top, motion.speed)]
    powers = [Curve("mechanical", motion.power), *_limit("largest", drive.power, motion.power)]
    charts = [
        Chart("height", "Slide height above bottom dead centre", "m", along, [Curve("height", motion.height)]),
        Chart("crank_speed", "Crank speed", "rad/s", along, speeds),
        Chart("torque", "Motor torque, at its own shaft", "N m", along, torques),
        Chart("power", "Mechanical power", "W", along, powers, note="below 0 the motor brakes"),
    ]
    if np.any(motion.mains_power != motion.power):
        title = "Electrical power, with the motor's losses"
        charts.append(Chart("mains_power", title, "W", along, [Curve("electrical", motion.mains_power)]))
    return charts


def _limit(name: str, most: float | None, values: Array) -> list[Curve]:
    """A limit as a curve over all states, and its negative if the values come near it; no curve without a limit."""
    if most is None:
        return []
    curves = [Curve(name, np.full(len(values), most), look="limit")]
    if values.min() < -BRAKING * most:
        curves.append(Curve(f"{name}, backwards", np.full(len(values), -most), look="limit"))
    return curves


def _over_angle(motions: Mapping[str, ServoMotion]) -> list[Chart]:
    """Speed and torque of the crank over its angle; if all cranks turn in one direction only, over the angle within a turn."""
    first = next(iter(motions.values())).motion.driver_coordinates[0]
    one_way = all(np.ptp(np.sign(motion.speed[motion.speed != 0])) == 0 for motion in motions.values())
    along = Along(first.counted if one_way else f"{first.counted}, there and back", first.unit)
    speeds, torques = [], []
    for name, motion in motions.items():
        angle, order = motion.angle, np.arange(len(motion.angle))
        if one_way:
            angle = angle % (2 * np.pi * (motion.motion.period_turns or 1))
            order = np.argsort(angle, kind="stable")
        speeds.append(Curve(name, motion.speed[order], angle[order]))
        torques.append(Curve(name, motion.torque[order], angle[order]))
    return [
        Chart("speed_over_angle", "Crank speed over its angle", "rad/s", along, speeds),
        Chart("torque_over_angle", "Torque at the crank over its angle", "N m", along, torques),
    ]


def _plane(motion: ServoMotion, motor: CatalogueMotor | None = None) -> Chart:
    """Absolute torque over absolute speed of the motor's shaft, with the curves of the motor, or else of the drive."""
    drive, size = motion.drive, np.abs(motion.motor_speed)
    mean = float(motion.weight @ size) / motion.duration
    curves = [
        Curve("motion", np.abs(motion.motor_torque), size),
        Curve("rms at the mean speed", np.array([motion.rms_motor_torque]), np.array([mean]), look="points"),
    ]
    if motor is not None:
        speed = np.linspace(0.0, motor.top_speed, POINTS)
        curves.append(Curve("peak torque", motor.peak_torque_at(speed), speed, look="limit"))
        curves.append(Curve("permanent torque (S1)", motor.rated_torque_at(speed), speed, look="limit"))
    else:
        speed = np.linspace(0.0, drive.top_speed or float(size.max()), POINTS)
        if drive.peak_torque is not None:
            curves.append(Curve("peak torque", drive.peak_torque_at(speed), speed, look="limit"))
        if drive.rated_torque is not None:
            curves.append(Curve("rated torque", np.full(POINTS, drive.rated_torque), speed, look="limit"))
    note = "sizes of torque and speed, driving and braking"
    along = Along("speed of the motor", "rad/s", of=motion.motion)
    return Chart("plane", "Torque over speed", "N m", along, curves, reach=(0.0, None), note=note)


def _slide_speeds(found: MotionComparison) -> Chart:
    """Speed of the slide on its way down over its height, with the limits."""
    curves = []
    for name, motion in found.motions.items():
        down = np.flatnonzero(motion.motion.slide_velocity <= 0)
        order = down[np.argsort(motion.height[down], kind="stable")]
        curves.append(Curve(name, -motion.motion.slide_velocity[order], motion.height[order]))
    highest = max(float(motion.height.max()) for motion in found.motions.values())
    speeds = [limit for limit in found.limits if isinstance(limit, SlideSpeed) and limit.flank != "up"]
    for number, limit in enumerate(speeds, 1):
        ends = np.clip(np.array(span(limit)), 0.0, highest)
        curves.append(Curve("limit" if len(speeds) == 1 else f"limit {number}", np.full(2, limit.speed), ends, look="limit"))
    return Chart("slide_speed", "Slide speed on the way down", "m/s", Along(HEIGHT, "m"), curves)


SECTIONS = {
    ServoMotion: servo_motion,
    MotionOptimum: optimum,
    MotionComparison: comparison,
    MotorChoice: choice,
    EnergyStore: energy_store,
    CamPoints: cam_table,
}
"""How results of this room are described."""
