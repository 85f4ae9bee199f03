"""What drives a press, in reports: where the energy of a stroke goes, and a motor's torque beside its curve."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common import tables
from ...common.quantities import RPM, Array, ShownUnit
from ...drives.protocol import corners_of
from ...drives.transmission import Geared
from ...dynamics.inputs import described
from ...loads.caller_laws import as_given
from ...simulation.duty import duty_cycle, motor_energy, stroke_duties
from ...simulation.motor_energy import motor_of
from ...simulation.run import Run
from ..recording import KeyFrames, elastic_run_of
from .blocks import BarChart, Block, Figure, Figures, Follows, Line, LineChart, Section, Table, with_prefix
from .shown import Shown, refuse_others

FROM_MAINS = {  # flows of a motor's energy, in words
    "mains": "from the mains",
    "drive": "on the crank",
    "slip": "slip",
    "load": "windings",
    "constant": "iron, bearings, fan",
    "gears": "gears",
    "inverter": "inverter",
    "resistor": "brake resistor",
}
CURVE = 240  # points of a motor's curve
BEYOND = 1.05  # largest speed of a motor's curve, divided by the largest that the run or the curve's corners have
MOST_STROKES = 12  # most strokes in a table
ROUNDING = 1e-8  # share of the largest work, or of that which a flywheel takes up, below which a work is rounding
SAME = 1e-6  # relative difference of angle and speed up to which a run ends as it began


def _bars(title: str, work: dict[str, float]) -> list[Block]:
    """Works [J] as bars; those that are rounding beside the largest are left out, and the chart where none is left."""
    largest = max(map(abs, work.values()), default=0.0)
    work = {name: value for name, value in work.items() if abs(value) > ROUNDING * largest}
    scale = tables.scale("J", work.values())
    return [BarChart(title, scale.unit, list(work), {"work": [scale.factor * value for value in work.values()]})] if work else []


def energy(run: Run) -> list[Block]:
    over = "Energy of the period" if _is_steady(run) else "Energy of the run"
    drive, loads, lost = (float(work[-1]) for work in (run.drive_work, run.load_work, run.lost))
    where = "dampers" if elastic_run_of(run) else "clutch and brake"
    return _bars(over, {"drive": drive, "loads": loads, where: lost, "stored in speed and height": drive - loads - lost})


def _is_steady(run: Run) -> bool:
    """Whether the run is a period of one driver that repeats itself."""
    if run.crank_angle.ndim > 1:
        return False
    turned, speed = abs(float(run.crank_angle[-1] - run.crank_angle[0])), run.crank_speed
    period = 2 * np.pi * (run.period_turns or 0)
    back = abs(turned - period) <= SAME * turned and bool(np.all(np.abs(speed[-1] - speed[0]) <= SAME * np.abs(speed[0])))
    return run.driver_coordinates[0].turns and back


def motor(run: Run, frames: KeyFrames | None, along: tuple[str, Array] = ("", np.zeros(0)), follows: Follows = "frames") -> list[Block]:
    """Duty, torque, and torque over speed beside the motor's curve.

    Args:
        run: The run.
        frames: Key frames of the page, where they are of this run; None for all states.
        along: Quantity along the chart of torque with its unit, and its values at all states, where there are no frames.
        follows: What the cursor of this chart follows.
    """
    driven = run.problem.driven
    if len(run.drivers) > 1 or (driven.drive is None and driven.prescribed is None):
        return []
    blocks: list[Block] = [Figures(_duty(run))]
    if driven.drive is None:
        return blocks
    blocks += _from_the_mains(run)
    turns = isinstance(driven.drive, Geared) or run.driver_coordinates[0].turns
    unit, words = ("N m", "Motor torque") if turns else ("N", "Drive force")
    every = np.arange(len(run.time)) if frames is None else frames.states
    sample = run.trajectory.at(run.time[np.sort(every)], complete=False)
    order = np.argsort(np.argsort(every, kind="stable"), kind="stable")
    torque = np.broadcast_to(sample.motor_torque, sample.drive_speed.shape)[order]
    speed = np.broadcast_to(driven.drive.motor_speed(sample.drive_speed), sample.drive_speed.shape)[order]
    scale = tables.scale(unit, np.ravel(torque))
    over_time = LineChart(
        f"{words}, at its own shaft" if turns else words,
        scale.unit,
        [Line("torque" if turns else "force", scale.factor * torque, None if frames is not None else along[1])],
        across=along[0],
        follows=follows,
    )
    return [*blocks, over_time, _plane(run, speed, torque, scale, turns, frames is not None)]


def _from_the_mains(run: Run) -> list[Block]:
    """Where the energy from the mains goes, of a motor that says so."""
    if motor_of(run.problem.driven) is None:
        return []
    energy = motor_energy(run)
    return _bars("Energy from the mains", {words: float(energy.work[flow][-1]) for flow, words in FROM_MAINS.items()})


def _duty(run: Run) -> Sequence[Figure]:
    whole, turns = duty_cycle(run), run.driver_coordinates[0].turns
    unit, size = ("r/min", RPM) if turns else ("mm/s", 1e-3)
    effort = "N m" if isinstance(run.problem.driven.drive, Geared) or turns else "N"
    ends = [f"{speed / size:.5g}" for speed in (whole.lowest_speed, whole.highest_speed)]
    figures = [
        Figure("mean speed", f"{whole.mean_speed / size:.5g} {unit}"),
        Figure("speed drop", f"{100 * whole.speed_drop:.4g} %", f"{ends[0]} to {ends[1]} {unit}"),
        Figure("motor, rms", with_prefix(whole.motor_rms, effort)),
        Figure("motor, peak", with_prefix(whole.motor_peak, effort)),
    ]
    if whole.utilisation is not None:
        figures.append(Figure("motor, use", f"{100 * whole.utilisation:.4g} %", "rms by rated torque"))
    if whole.mains_work is not None:
        reaches = "" if whole.efficiency is None else f"{100 * whole.efficiency:.4g} % reach the driver"
        figures.append(Figure("from the mains", with_prefix(whole.mains_work / whole.duration, "W"), reaches))
    if whole.settled_rise is not None:
        figures.append(Figure("motor, settled rise", f"{whole.settled_rise:.4g} K", "of its temperature"))
    return figures


def _plane(run: Run, speed: Array, torque: Array, scale: ShownUnit, turns: bool, moving: bool) -> LineChart:
    """Torque over the speed of the motor's own shaft, beside its curve where it has one."""
    drive = run.problem.driven.drive
    assert drive is not None
    unit, size = ("r/min", RPM) if turns else ("mm/s", 1e-3)
    points = np.column_stack([speed / size, scale.factor * torque])
    lines, note = [Line("run", points[:, 1], points[:, 0], at_frames=points if moving else None)], ""
    if drive.timed:
        note = "the drive's torque depends on more than the speed: it has no curve"
    else:
        marks = [*getattr(drive, "reversals", ()), *(float(np.ravel(speed)[0]) for speed, _ in corners_of(drive))]
        known = [float(np.ravel(drive.motor_speed(mark))[0]) for mark in marks]
        ahead = np.sign(speed.mean()) or 1.0
        fastest = max(float(np.abs(speed).max()), *(ahead * mark for mark in known), 0.0)
        ratio = float(np.ravel(drive.motor_speed(1.0))[0])
        shaft = np.linspace(min(0.0, float((ahead * speed).min())), BEYOND * fastest, CURVE) * ahead
        curve = np.broadcast_to(np.asarray(drive.motor_torque(shaft / ratio), dtype=float), shaft.shape)
        lines.insert(0, Line("motor's curve" if turns else "drive's curve", scale.factor * curve, shaft / size))
    rated = drive.rated_torque
    if rated is not None:
        along = np.concatenate([line.x for line in lines if line.x is not None])
        ends = np.array([along.min(), along.max()])
        lines.append(Line("rated torque", np.full(2, scale.factor * float(np.ravel(rated)[0])), ends))
    what = "Motor torque over its speed" if turns else "Drive force over its speed"
    across = f"speed of its shaft [{unit}]" if turns else f"speed [{unit}]"
    return LineChart(what, scale.unit, lines, across=across, follows="nothing", note=note)


def strokes(run: Run) -> list[Block]:
    """A table of the strokes of a run, where there are several."""
    if len(run.drivers) > 1 or not run.driver_coordinates[0].turns:
        return []
    found = stroke_duties(run)
    if len(found) < 2:
        return []
    work = tables.scale("J", [value for each in found for value in (each.drive_work, each.load_work)])
    effort = tables.scale("N m", [each.motor_peak for each in found])
    heads = ["stroke", "start [s]", "duration [s]", "mean [r/min]", "lowest [r/min]", f"drive [{work.unit}]", f"loads [{work.unit}]"]
    heads += [f"motor, rms [{effort.unit}]"]
    rows = []
    for k in tables.shortened(range(len(found)), MOST_STROKES):
        if k is None:
            rows.append([tables.GAP, *[""] * (len(heads) - 1)])
            continue
        each = found[k]
        cells = [f"{value:.5g}" for value in (each.start, each.duration, each.mean_speed / RPM, each.lowest_speed / RPM)]
        rows.append([f"{k + 1}", *cells, work.shown(each.drive_work), work.shown(each.load_work), effort.shown(each.motor_rms)])
    return [Table("Strokes", heads, rows)]


def section(run: Run, shown: Shown) -> Section:
    """The section of a run beside the page's own motion.

    Raises:
        PinpressError: It is of another press.
    """
    refuse_others("run", run.problem.driven.press, shown)
    first, driven = run.driver_coordinates[0], run.problem.driven
    unit, size = ("r/min", RPM) if first.turns else ("mm/s", 1e-3)
    steady = _is_steady(run)
    across, x = (f"{first.counted} [{first.shown_unit}]", first.scale * run.crank_angle) if steady else ("time [s]", run.time)
    turn = 360.0 * (run.period_turns or 1)
    if steady:  # counted as the cursor is
        x = x - turn * np.floor(min(x[0], x[-1]) / turn + SAME)
    names = [f"{first.part} speed"] if run.crank_speed.ndim == 1 else run.drivers
    speeds = zip(names, run.driver_coordinates, run.crank_speed.reshape(len(run.time), -1).T, strict=True)
    lines = [Line(name, speed / size, x) for name, coordinate, speed in speeds if coordinate.turns == first.turns]
    title = f"{first.part.capitalize()} speed"
    follows: Follows = "position" if steady else "nothing"
    blocks: list[Block] = [LineChart(title, unit, lines, across=across, follows=follows)]
    parts = {"motor": driven.drive or driven.prescribed, "flywheel": driven.flywheel, "clutch": driven.clutch, "brake": driven.brake}
    inputs = [(name, described(as_given(part))) for name, part in parts.items() if part is not None]
    blocks += [*motor(run, None, (across, x), follows), *energy(run), *strokes(run)]
    what = "one period, which repeats itself" if steady else f"{run.time[-1]:.6g} s"
    note = f"Simulated, {what}; the press moves as the top of the page says."
    return Section("Steady state under the motor" if steady else "Run", blocks, inputs, note)
