"""What commands print of a run: its speeds, energies, motor, strokes and bearing forces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..common import tables
from ..common.quantities import RPM
from ..drives.transmission import Geared
from ..dynamics.extremes import at_peaks
from ..dynamics.reactions import Reactions
from ..dynamics.summary import bearing_table, checks, driver_table, driving_lines
from ..kinematics.slide_path import dead_centres, slide_turns, stroke_turns
from ..linkage.linkage import Linkage
from ..simulation.duty import MotorDuty, duty_cycle, stroke_duties
from ..simulation.elastic.run import ElasticRun
from ..simulation.motor_energy import motor_of
from ..simulation.run import Run

if TYPE_CHECKING:
    from ..elasticity.impacts import ImpactsByTurn

MOST_STROKES = 8  # most strokes that are listed in full
FIRST_STROKES = 5  # of more strokes so many first ones are listed, and the last one


def simulation_summary(press: Linkage, run: Run, reactions: Reactions, steady: bool = False) -> str:
    """Speeds, energies, the motor's torque, strokes and bearing forces of a run, and how well the equations are fulfilled.

    Args:
        press: the linkage.
        run: the run.
        reactions: inverse dynamics of this run under its loads; their driving torque is that of flywheel, drive, clutch and brake together.
        steady: whether the run is one period of a steady state.

    Works and extremes of speed and of the motor's torque are those of `duty_cycle`; torques and forces of the crank and the bearings are
    those of `extremes`. Signs as in `Reactions`.
    """
    if len(run.drivers) > 1:
        return "\n".join([_title(press, run), *_of_several(run, reactions), *bearing_table(reactions), "", *_checks(press, run, reactions)])
    whole = duty_cycle(run)
    lines = [
        _title(press, run, steady),
        *_end(run, steady),
        *_speeds(run, whole, steady),
        *_work(run, whole),
        *_motor(run, whole),
        *([] if isinstance(run, ElasticRun) else _torque(reactions)),
        *(_strokes(stroke_duties(run), run.problem.driven.press) if run.driver_coordinates[0].turns else []),
        *(_on_springs(press, run, reactions) if isinstance(run, ElasticRun) else bearing_table(reactions)),
        "",
        *_checks(press, run, reactions),
    ]
    return "\n".join(lines)


def _title(press: Linkage, run: Run, steady: bool = False) -> str:
    of = "a period of its steady state, " if steady else ""
    return f"{press.name}: {of}{run.time[-1]:.6g} s, {len(run.crank_angle)} states, method {run.stats.method!r}"


def _of_several(run: Run, reactions: Reactions) -> list[str]:
    """Lines of a run with several drivers: how they move, works, the efforts of the drives, and those on the drivers."""
    works = [("drives", float(run.drive_work[-1]), "on the drivers"), ("loads", float(run.load_work[-1]), "taken")]
    scale = tables.scale("J", [work for _, work, _ in works])
    lines = [
        "",
        "Drivers",
        *driver_table(run),
        "",
        "Work",
        *(tables.entry(name, scale.shown(work), scale.unit, to) for name, work, to in works),
    ]
    for driver, coordinate, effort in zip(run.drivers, run.driver_coordinates, run.drive_torque.T, strict=True):
        if effort.any():
            of_drive = tables.scale(coordinate.effort_unit, [float(np.abs(effort).max())])
            lines += [
                "",
                f"Drive of {driver}, {coordinate.effort} on the driver",
                tables.entry("largest", of_drive.shown(float(effort.max())), of_drive.unit),
                tables.entry("smallest", of_drive.shown(float(effort.min())), of_drive.unit),
            ]
    return [*lines, *driving_lines(run, reactions)]


def _checks(press: Linkage, run: Run, reactions: Reactions) -> list[str]:
    return [
        "Checks",
        *checks(press, run.stats.closure_error, reactions),
        tables.entry("energy error", f"{run.stats.energy_error:.2g}", "", "of the largest energy, over the whole run"),
        tables.entry("steps", f"{run.stats.steps}", "", f"{run.stats.evaluations} evaluations"),
    ]


def duty_summary(run: Run) -> list[str]:
    """Lines with the speeds of a period of a steady state, and what it asks of the motor."""
    whole = duty_cycle(run)
    return [*_speeds(run, whole, True), *_motor(run, whole)]


def _end(run: Run, steady: bool) -> list[str]:
    first, (unit, size) = run.driver_coordinates[0], run.driver_coordinates[0].shown_speed
    angle = first.scale * run.crank_angle
    way = float(angle[-1] - angle[0]) + 0.0
    turns = f"{way / 360 + 0.0:.6g}"
    moved = f"{turns} {'turn' if turns == '1' else 'turns'} from the start" if first.turns else f"{way:.6g} mm from the start"
    return [
        "",
        "At the end, as at the start" if steady else "At the end",
        tables.entry(first.position, f"{angle[-1]:.3f}", first.shown_unit, moved),
        tables.entry(f"{first.part} speed", f"{run.crank_speed[-1] / size:.6g}", unit),
    ]


def _speeds(run: Run, whole: MotorDuty, steady: bool) -> list[str]:
    unit, size = run.driver_coordinates[0].shown_speed
    recovery = [tables.entry("from lowest to highest", f"{whole.recovery_time:.6g}", "s")] if steady else []
    return [
        "",
        f"{run.driver_coordinates[0].part.capitalize()} speed",
        tables.entry("mean", f"{whole.mean_speed / size:.6g}", unit),
        tables.entry("highest", f"{whole.highest_speed / size:.6g}", unit),
        tables.entry("lowest", f"{whole.lowest_speed / size:.6g}", unit),
        tables.entry("speed drop", f"{100 * whole.speed_drop + 0.0:.4f}", "%", "of the mean"),
        *recovery,
    ]


def _work(run: Run, whole: MotorDuty) -> list[str]:
    turns = run.driver_coordinates[0].turns
    works = [
        ("drive", whole.drive_work, "on the crank's shaft" if turns else "on the driver"),
        ("loads", whole.load_work, "taken"),
    ]
    works += (
        []
        if not turns
        else [
            ("flywheel", whole.flywheel_work, "given off, with the drive's inertia, from highest to lowest speed"),
        ]
    )
    where = f"{'clutch, brake and ' if turns else ''}{'dampers' if isinstance(run, ElasticRun) else 'bearings'}"
    works += [("lost", whole.lost, f"in {where}")] if turns or whole.lost else []
    scale = tables.scale("J", [work for _, work, _ in works])
    return ["", "Work", *(tables.entry(name, scale.shown(work), scale.unit, remark) for name, work, remark in works)]


def _motor(run: Run, whole: MotorDuty) -> list[str]:
    if run.problem.driven.drive is None and run.problem.driven.prescribed is None:
        return []
    use = [] if whole.utilisation is None else [tables.entry("utilisation", f"{100 * whole.utilisation:.4g}", "%", "rms by rated torque")]
    geared = isinstance(run.problem.driven.drive, Geared) or run.driver_coordinates[0].turns
    scale = tables.scale("N m" if geared else "N", [whole.motor_rms, whole.motor_peak])
    return [
        "",
        "Motor (torque at its own shaft)" if geared else "Drive",
        tables.entry("rms", scale.shown(whole.motor_rms), scale.unit),
        tables.entry("peak", scale.shown(whole.motor_peak), scale.unit),
        *use,
        *_mains(run, whole),
    ]


def _mains(run: Run, whole: MotorDuty) -> list[str]:
    """Lines of what the motor takes from the mains, where that is known."""
    motor = motor_of(run.problem.driven)
    if motor is None or whole.mains_work is None or whole.slip_loss is None:
        return []
    power = whole.mains_work / whole.duration
    works, slip, mean = tables.scale("J", [whole.mains_work]), tables.scale("J", [whole.slip_loss]), tables.scale("W", [power])
    share = "" if whole.efficiency is None else f"{100 * whole.efficiency:.4g} % of it reach the driver"
    lines = [
        tables.entry("from the mains", works.shown(whole.mains_work), works.unit, share),
        *([tables.entry("lost by slip", slip.shown(whole.slip_loss), slip.unit)] if whole.slip_loss else []),
        tables.entry("mean power", mean.shown(power), mean.unit, f"from the mains, {power / 1e3:.4g} kWh in an hour"),
    ]
    if whole.settled_rise is not None:
        rated = getattr(motor, "rated_rise", None)
        remark = "of its temperature, if this goes on for good" + ("" if rated is None else f"; {rated:g} K at its rated point")
        lines.append(tables.entry("settled rise", f"{whole.settled_rise:.4g}", "K", remark))
    return lines


def _said(remark: str) -> str:
    """What is in a state, behind its place."""
    return f", {remark}" if remark else ""


def _torque(reactions: Reactions) -> list[str]:
    found = at_peaks(reactions)
    torque, motion = found.reactions.driving_torque, found.reactions.motion
    first = motion.driver_coordinates[0]
    title = "Torque at the crank (flywheel, drive, clutch and brake together)" if first.turns else "Force on the driver"
    lines, scale = ["", title], tables.scale(first.effort_unit, [float(np.abs(torque).max())])
    for name, at in (("largest", int(torque.argmax())), ("smallest", int(torque.argmin()))):
        lines.append(
            tables.entry(
                name,
                scale.shown(float(torque[at])),
                scale.unit,
                f"at {motion.shown_position[at]:8.3f} {first.shown_unit}, {motion.time[at]:.6f} s{_said(found.remarks[at])}",
            )
        )
    return lines


def _strokes(found: Sequence[MotorDuty], press: Linkage) -> list[str]:
    if not found:
        return ["", "Strokes: none, the crank does not get through a period"]
    scale = tables.scale("J", [work for stroke in found for work in (stroke.drive_work, stroke.load_work)])
    heads = ["start [s]", "duration [s]", "mean [r/min]", "lowest [r/min]", f"drive [{scale.unit}]", f"loads [{scale.unit}]"]
    turns, a_stroke = slide_turns(press), stroke_turns(press)
    what = "turns of the crank" if turns in (None, 1) else f"each {turns:.6g} turns of the crank"
    what += "" if turns is None or a_stroke is None or turns == a_stroke else f", {turns / a_stroke:.0f} strokes in each"
    rows = [["", *heads]]
    few = len(found) <= MOST_STROKES
    for k in range(len(found)) if few else [*range(FIRST_STROKES), len(found) - 1]:
        stroke = found[k]
        if not few and k == len(found) - 1:
            rows.append([f"{tables.GAP:>6}"])
        values = (stroke.start, stroke.duration, stroke.mean_speed / RPM, stroke.lowest_speed / RPM)
        works = (scale.shown(stroke.drive_work), scale.shown(stroke.load_work))
        rows.append([f"{k + 1:6d}", *(f"{value:.6g}" for value in values), *works])
    return ["", f"Strokes ({what}, from the start)", *tables.table(rows, [6, 16])]


def _on_springs(press: Linkage, run: ElasticRun, reactions: Reactions) -> list[str]:
    """What an elastic run has: its deepest point and its forces, with the rigid press's beside them."""
    first, bottom = run.driver_coordinates[0], dead_centres(press).bottom_position
    frame = float(np.linalg.norm(run.shaking_force, axis=1).max())
    scale = tables.scale("N", [*run.peaks.values(), run.reverse_force, frame])
    deepest = f"off the rigid bottom dead centre, at {first.at(run.deepest_angle)}"
    lines = [
        "",
        "On its springs",
        tables.entry("deepest point", f"{1e3 * (run.deepest - bottom):+.4f}", "mm", deepest),
        tables.entry("reverse force", scale.shown(run.reverse_force), scale.unit, "with which the linkage pulls the slide up"),
        tables.entry("on the frame", scale.shown(frame), scale.unit, "largest at the states, weight included"),
    ]
    if run.floor_force is not None and run.frame_motion is not None:
        floor, moved = (float(np.linalg.norm(each, axis=1).max()) for each in (run.floor_force, run.frame_motion[:, :2]))
        lines.append(tables.entry("on the floor", scale.shown(floor), scale.unit, "largest at the states, weight included"))
        lines.append(tables.entry("frame", f"{1e3 * moved:.4f}", "mm", "largest displacement of its centre of mass at the states"))
    if run.decay_per_stroke is not None:
        lines.append(tables.entry("decay", f"{100 * run.decay_per_stroke:.3g}", "%", "of a vibration is left after a stroke"))
    heads = ["", f"on its springs [{scale.unit}]", f"rigid [{scale.unit}]"]
    rows = [
        [name, scale.shown(run.peaks[name]), scale.shown(float(np.linalg.norm(reactions.bearing_force[name], axis=1).max()))]
        for name in press.bearings_as_drawn
        if name in run.peaks
    ]
    lines += ["", "Bearings, each at its peak, and of the rigid press at the same crank angles", *tables.fitted([heads, *rows])]
    for found in journals(run):
        lines += ["", *str(found).splitlines()]
    return lines


def journals(run: ElasticRun) -> list[ImpactsByTurn]:
    """What the journals of pins with clearance do, of a run of a whole turn or more."""
    from ..elasticity.impacts import journal_impacts  # seldom needed

    if abs(run.crank_angle[-1] - run.crank_angle[0]) < 2 * np.pi:
        return []
    return [journal_impacts(run, name) for name in run.elastic.clearances]
