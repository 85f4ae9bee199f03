"""What a run shows: speeds, energies, the motor and its mains, strokes; and a press on its springs next to the rigid one."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..common.outlets.described import Along, Bars, Block, Chart, Column, Curve, Figure, Section, Table
from ..common.quantities import Array, quantity
from ..drives.protocol import corners_of
from ..drives.transmission import Geared
from ..dynamics.described import driver_table, works
from ..dynamics.inputs import row
from ..dynamics.reactions import Reactions
from ..kinematics.described import along_motion, by_driver, chart, known_dead_centres, slide_charts
from ..kinematics.slide_path import slide_turns, stroke_turns
from ..loads.caller_laws import as_given
from .duty import MotorDuty, duty_cycle, motor_energy, stroke_duties
from .elastic.parts_in_words import elastic_in_words
from .elastic.run import ElasticRun
from .motor_energy import motor_of
from .run import Run

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
SAME = 1e-6  # relative difference of angle and speed up to which a run ends as it began
MOST_BEARINGS = 6  # bearings with a chart of their own, those of the largest forces
LOW = 0.03  # share of the stroke above bottom dead centre that is shown about it at least
TURN = 1e-6  # share of a turn by which a run of one turn may be longer


def run(result: Run, page: Reactions | None = None) -> tuple[Section, ...]:
    """The section of a run; without a page also how the slide moves in it."""
    along = _along(result, page)
    own = page is not None and page.motion is result
    driven, first, steady = result.problem.driven, result.driver_coordinates[0], is_steady(result)
    several = len(result.drivers) > 1
    blocks: list[Block] = [] if own else _speeds(result, along)
    parts = {"motor": driven.drive or driven.prescribed, "flywheel": driven.flywheel, "clutch": driven.clutch, "brake": driven.brake}
    inputs = [] if own else [row(name, as_given(part), first) for name, part in parts.items() if part is not None]
    figures = _figures_of_several(result) if several else _figures(result, duty_cycle(result), steady)
    blocks += [driver_table(result)] if several else [*_motor(result, along), *_mains(result)]
    blocks += [*_energy(result), *([] if several else _strokes(result))]
    what = "one period, which repeats itself" if steady else f"{result.time[-1]:.6g} s"
    note = f"Simulated, {what}." if page is None or own else f"Simulated, {what}; the press moves as the top of the page says."
    title = "Steady state under the motor" if steady else "Run"
    section = Section(title, figures, blocks, inputs, note, driven.press, "run")
    slide = [] if page is not None else slide_charts(result, along_motion(result, driven.press))
    return (*([Section("Slide", blocks=slide)] if slide else []), section)


def _along(result: Run, page: Reactions | None) -> Along:
    """What the charts of a run run along: as the page that shows it, else the angle of a period that repeats itself, or time."""
    if page is not None and page.motion is result:
        return along_motion(result, result.problem.driven.press)
    first = result.driver_coordinates[0]
    if is_steady(result):
        return Along(first.counted, first.unit, result.crank_angle, result)
    return Along("time", "s", result.time, result)


def is_steady(result: Run) -> bool:
    """Whether the run is a period of one driver that repeats itself."""
    if result.crank_angle.ndim > 1:
        return False
    turned, speed = abs(float(result.crank_angle[-1] - result.crank_angle[0])), result.crank_speed
    period = 2 * np.pi * (result.period_turns or 0)
    back = abs(turned - period) <= SAME * turned and bool(np.all(np.abs(speed[-1] - speed[0]) <= SAME * np.abs(speed[0])))
    return result.driver_coordinates[0].turns and back


def _speeds(result: Run, along: Along) -> list[Block]:
    first = result.driver_coordinates[0]
    curves = by_driver(f"{first.part} speed", result, result.crank_speed, first)
    return [chart("speed" if first.turns else "driver_speed", f"{first.part.capitalize()} speed", f"{first.unit}/s", along, curves)]


def _figures(result: Run, whole: MotorDuty, steady: bool) -> list[Figure]:
    """Where the run ends, its speeds, works, and what it asks of the motor."""
    first = result.driver_coordinates[0]
    speed, place = f"{first.unit}/s", "angle" if first.turns else "height"
    way = float(result.crank_angle[-1] - result.crank_angle[0])
    turns = f"{way / (2 * np.pi) + 0.0:.6g}"
    moved = f"{turns} {'turn' if turns == '1' else 'turns'}" if first.turns else quantity("height").text(way)
    ends = [quantity(speed).text(value, digits=5) for value in (whole.lowest_speed, whole.highest_speed)]
    known = [
        Figure(f"{first.position} at the end", float(result.crank_angle[-1]), place, f"{moved} from the start"),
        Figure(f"{first.part} speed at the end", float(result.crank_speed[-1]), speed),
        Figure("mean speed", whole.mean_speed, speed),
        Figure("speed drop", whole.speed_drop, "share", f"of the mean, {ends[0]} to {ends[1]}", kind="energy"),
    ]
    known += [Figure("from lowest to highest", whole.recovery_time, "s")] if steady else []
    return [*known, *_works(result, whole), *duty_figures(result, whole)]


def _works(result: Run, whole: MotorDuty) -> list[Figure]:
    turns = result.driver_coordinates[0].turns
    found = [
        Figure("work of the drive", whole.drive_work, "J", "on the crank's shaft" if turns else "on the driver"),
        Figure("work of the loads", whole.load_work, "J", "taken"),
    ]
    if turns:
        given = "given off, with the drive's inertia, from highest to lowest speed"
        found.append(Figure("work of the flywheel", whole.flywheel_work, "J", given))
    if turns or whole.lost:
        where = f"{'clutch, brake and ' if turns else ''}{'dampers' if isinstance(result, ElasticRun) else 'bearings'}"
        lossy = turns and result.problem.driven.press.loses_power
        found.append(Figure("lost", whole.lost, "J", "in clutch, brake, bearings, teeth and threads" if lossy else f"in {where}"))
    return found


def duty_figures(result: Run, whole: MotorDuty) -> list[Figure]:
    """What a part of a run asks of the motor and takes from the mains."""
    driven = result.problem.driven
    if driven.drive is None and driven.prescribed is None:
        return []
    geared = isinstance(driven.drive, Geared) or result.driver_coordinates[0].turns
    name, unit = ("motor", "N m") if geared else ("drive", "N")
    rated = None if driven.drive is None or driven.drive.rated_torque is None else float(np.ravel(driven.drive.rated_torque)[0])
    at = "torque at its own shaft" if geared else "force"
    found = [Figure(f"{name}, rms", whole.motor_rms, unit, at, rated, kind="motor"), Figure(f"{name}, peak", whole.motor_peak, unit, at)]
    if whole.utilisation is not None:
        found.append(Figure(f"{name}, use", whole.utilisation, "share", "rms by rated torque"))
    motor = motor_of(driven)
    if motor is None or whole.mains_work is None or whole.slip_loss is None:
        return found
    power = whole.mains_work / whole.duration
    share = "" if whole.efficiency is None else f"{quantity('share').text(whole.efficiency, digits=4)} of it reach the driver"
    found.append(Figure("from the mains", whole.mains_work, "J", share))
    found += [Figure("lost by slip", whole.slip_loss, "J")] if whole.slip_loss else []
    found.append(Figure("mean power from the mains", power, "W", f"{power / 1e3:.4g} kWh in an hour", kind="motor"))
    if whole.settled_rise is not None:
        at_rated = getattr(motor, "rated_rise", None)
        found.append(
            Figure(f"{name}, settled rise", whole.settled_rise, "K", "of its temperature, if this goes on for good", at_rated, kind="motor")
        )
    return found


def _figures_of_several(result: Run) -> list[Figure]:
    """Works of a run with several drivers, and the efforts of the drives."""
    found = [
        Figure("work of the drives", float(result.drive_work[-1]), "J", "on the drivers"),
        Figure("work of the loads", float(result.load_work[-1]), "J", "taken"),
    ]
    for driver, coordinate, effort in zip(result.drivers, result.driver_coordinates, result.drive_torque.T, strict=True):
        if effort.any():
            ends = {"largest": float(effort.max()), "smallest": float(effort.min())}
            found += [Figure(f"drive of {driver}, {end}", value, coordinate.effort_unit) for end, value in ends.items()]
    return found


def _motor(result: Run, along: Along) -> list[Block]:
    """Torque of the motor along the run, and over its speed next to its curve."""
    driven = result.problem.driven
    if driven.drive is None:
        return []
    turns = isinstance(driven.drive, Geared) or result.driver_coordinates[0].turns
    unit, words = ("N m", "Motor torque, at its own shaft") if turns else ("N", "Drive force")
    sample = result.trajectory.at(result.time, complete=False)
    torque = np.broadcast_to(sample.motor_torque, sample.drive_speed.shape)
    speed = np.broadcast_to(driven.drive.motor_speed(sample.drive_speed), sample.drive_speed.shape)
    name = "torque" if turns else "force"
    over = Chart("motor", words, unit, along, [Curve(name, np.array(torque))])
    return [over, _plane(result, np.array(speed), np.array(torque), unit, turns)]


def _plane(result: Run, speed: Array, torque: Array, unit: str, turns: bool) -> Chart:
    """Torque over the speed of the motor's own shaft, next to its curve if it has one."""
    drive = result.problem.driven.drive
    assert drive is not None
    curves, note = [Curve("run", torque, speed)], ""
    if drive.timed:
        note = "The drive's torque depends on more than the speed: it has no curve."
    else:
        marks = [*getattr(drive, "reversals", ()), *(float(np.ravel(corner)[0]) for corner, _ in corners_of(drive))]
        known = [float(np.ravel(drive.motor_speed(mark))[0]) for mark in marks]
        ahead = np.sign(speed.mean()) or 1.0
        fastest = max(float(np.abs(speed).max()), *(ahead * mark for mark in known), 0.0)
        ratio = float(np.ravel(drive.motor_speed(1.0))[0])
        shaft = np.linspace(min(0.0, float((ahead * speed).min())), BEYOND * fastest, CURVE) * ahead
        law = np.broadcast_to(np.asarray(drive.motor_torque(shaft / ratio), dtype=float), shaft.shape)
        curves.insert(0, Curve("motor's curve" if turns else "drive's curve", np.array(law), shaft))
    if drive.rated_torque is not None:
        places = np.concatenate([curve.x for curve in curves if curve.x is not None])
        ends = np.array([places.min(), places.max()])
        curves.append(Curve("rated torque", np.full(2, float(np.ravel(drive.rated_torque)[0])), ends, look="limit"))
    title = "Motor torque over its speed" if turns else "Drive force over its speed"
    over = Along("speed of its shaft" if turns else "speed", "rad/s" if turns else "m/s", of=result)
    return Chart("plane", title, unit, over, curves, note=note)


def _mains(result: Run) -> list[Bars]:
    """Where the energy from the mains goes, of a motor that says so."""
    if motor_of(result.problem.driven) is None:
        return []
    energy = motor_energy(result)
    return works("mains", "Energy from the mains", {words: float(energy.work[flow][-1]) for flow, words in FROM_MAINS.items()})


def _energy(result: Run) -> list[Bars]:
    over = "Energy of the period" if is_steady(result) else "Energy of the run"
    drive, loads, lost = (float(work[-1]) for work in (result.drive_work, result.load_work, result.lost))
    where = "dampers" if isinstance(result, ElasticRun) else "clutch and brake"
    return works("energy", over, {"drive": drive, "loads": loads, where: lost, "stored in speed and height": drive - loads - lost})


def _strokes(result: Run) -> list[Block]:
    """A table of the strokes of a run."""
    if not result.driver_coordinates[0].turns:
        return []
    found, press = stroke_duties(result), result.problem.driven.press
    if not found:
        return [Table("strokes", "Strokes: none, the crank does not get through a period", [])]
    turns, a_stroke = slide_turns(press), stroke_turns(press)
    what = "turns of the crank" if turns in (None, 1) else f"each {turns:.6g} turns of the crank"
    what += "" if turns is None or a_stroke is None or turns == a_stroke else f", {turns / a_stroke:.0f} strokes in each"
    columns = [
        Column("stroke", [k + 1 for k in range(len(found))]),
        Column("start", [each.start for each in found], "s"),
        Column("duration", [each.duration for each in found], "s"),
        Column("mean", [each.mean_speed for each in found], "rad/s"),
        Column("lowest", [each.lowest_speed for each in found], "rad/s"),
        Column("drive", [each.drive_work for each in found], "J"),
        Column("loads", [each.load_work for each in found], "J"),
        Column("motor, rms", [each.motor_rms for each in found], "N m"),
    ]
    return [Table("strokes", f"Strokes ({what}, from the start)", columns, most=12)]


def numerics(result: Run) -> list[Figure]:
    """How accurate a run is, and what it took."""
    stats = result.stats
    return [
        Figure("energy error", f"{stats.energy_error:.2g}", where="of the largest energy, over the whole run"),
        Figure("steps", f"{stats.steps}", where=f"{stats.evaluations} evaluations"),
    ]


# -------------------------------------------------------------------------------------------------------------------------- on its springs


def elastic_run(result: ElasticRun, page: Reactions | None = None) -> tuple[Section, ...]:
    """The sections of a run of a press on its springs: next to the rigid press, and, if the page shows this run, its drive."""
    own = page is not None and page.motion is result
    press, rigid, ends = result.problem.driven.press, result.rigid_slide_position, known_dead_centres(result.problem.driven.press)
    bottom = 0.0 if ends is None else ends.bottom_position
    first = result.driver_coordinates[0]
    along = along_motion(result, press) if own else Along(first.counted, first.unit, result.crank_angle, result)
    beside = Curve("slide", result.slide_position - rigid)
    blocks: list[Block] = [
        Chart(
            "beside_rigid",
            "Slide next to the rigid press",
            "m",
            along,
            [beside],
            note="At the same crank angle; below 0 the slide is deeper.",
        )
    ]
    blocks += [*_near_bottom(result, rigid, bottom), *_events(result, bottom)]
    forces = page.bearing_force if own and page is not None else None
    largest = sorted(result.peaks, key=lambda name: -result.peaks[name])
    sizes = {name: np.linalg.norm(result.bearing_force[name], axis=1) for name in largest}
    blocks.append(Chart("forces", "Bearing forces on its springs", "N", along, [Curve(name, size) for name, size in sizes.items()]))
    for name in largest[:MOST_BEARINGS] if forces is not None else ():
        assert forces is not None
        both = [Curve("on its springs", sizes[name]), Curve("rigid", np.linalg.norm(forces[name], axis=1), look="limit")]
        blocks.append(Chart(f"forces {name}", f"Force in {name}", "N", along, both))
    blocks.append(_peaks(result, largest, forces))
    note = "Bearings, guides and what else is named yield; the rigid press is at the same crank angle, under the same loads."
    springs = Section("On its springs", _elastic_figures(result, bottom), blocks, elastic_in_words(result.elastic), note, press, "run")
    return (springs, *run(result, page)) if page is None or own else (springs,)


def _elastic_figures(result: ElasticRun, bottom: float) -> list[Figure]:
    drive, loads, lost = (float(work[-1]) for work in (result.drive_work, result.load_work, result.lost))
    at = f"off the rigid bottom dead centre, at {result.driver_coordinates[0].at(result.deepest_angle)}"
    of = f"of {quantity('J').text(drive, 5)} of the drive; loads {quantity('J').text(loads, 5)}"
    frame = float(np.linalg.norm(result.shaking_force, axis=1).max())
    found = [
        Figure("deepest point", result.deepest - bottom, "m", at, kind="accuracy"),
        Figure("reverse force", result.reverse_force, "N", "with which the linkage pulls the slide up", kind="force"),
        Figure("force on the frame", frame, "N", "largest at the states, weight included"),
        Figure("lost in dampers", lost, "J", of),
    ]
    if result.floor_force is not None and result.frame_motion is not None:
        floor, moved = (float(np.linalg.norm(each, axis=1).max()) for each in (result.floor_force, result.frame_motion[:, :2]))
        found.append(Figure("force on the floor", floor, "N", "largest at the states, weight included", kind="floor"))
        found.append(Figure("frame on its mounts", moved, "m", "largest displacement of its centre of mass at the states"))
    if result.decay_per_stroke is not None:
        found.append(Figure("decay of vibrations", result.decay_per_stroke, "share", "of a vibration is left after a stroke"))
    return found


def _near_bottom(result: ElasticRun, rigid: Array, bottom: float) -> list[Block]:
    """The slide about its lowest place, by the crank angle from that of the rigid slide; nothing for a run of several turns."""
    if abs(result.crank_angle[-1] - result.crank_angle[0]) > 2 * np.pi * (1 + TURN):
        return []
    lowest = int(rigid.argmin())
    beside = (result.crank_angle - result.crank_angle[lowest] + np.pi) % (2 * np.pi) - np.pi
    highest = max([LOW * float(np.ptp(rigid)), *(1.2 * (place - rigid[lowest]) for _, _, place in result.events)])
    near = np.flatnonzero(rigid - rigid[lowest] <= highest)
    order = near[np.argsort(beside[near], kind="stable")]
    heights = [("on its springs", result.slide_position), ("rigid", rigid)]
    along = Along("crank angle from the rigid bottom dead centre", "rad", beside[order])
    return [
        Chart("near_bottom", "Slide near bottom dead centre", "m", along, [Curve(name, place[order] - bottom) for name, place in heights])
    ]


def _events(result: ElasticRun, bottom: float) -> list[Block]:
    if not result.events:
        return []
    first = result.driver_coordinates[0]
    times, angles, places = zip(*result.events, strict=True)
    columns = [
        Column("time", list(times), "s"),
        Column(first.counted, list(angles), "angle" if first.turns else "height"),
        Column("slide above bottom dead centre", [place - bottom for place in places], "height"),
    ]
    return [Table("events", "Where loads begin and end", columns, most=12)]


def _peaks(result: ElasticRun, names: list[str], rigid: Mapping[str, Array] | None) -> Table:
    """Peaks of all bearings, next to those of the rigid press if they are known."""
    columns = [Column("bearing", names), Column("on its springs", [result.peaks[name] for name in names], "N")]
    if rigid is not None:
        peaks = [float(np.linalg.norm(rigid[name], axis=1).max()) for name in names]
        columns.append(Column("rigid", peaks, "N"))
        ratios = [f"{result.peaks[name] / peak:.3f}" if peak > 0 else "" for name, peak in zip(names, peaks, strict=True)]
        columns.append(Column("ratio", [float(ratio) if ratio else None for ratio in ratios]))
    return Table("peaks_on_springs", "Largest forces", columns)


SECTIONS = {ElasticRun: elastic_run, Run: run}
"""How results of this room are described."""
