"""What the reactions of a motion show: slide, process, drive, bearings, floor, and how well the equations are fulfilled.

Signs and axes are those of `Reactions`. Values that are rounding next to the largest bearing force of the motion (for moments, next to that
force times the linkage's size) are zero here. All functions raise `PinpressError` for values that are not finite.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..common.errors import PinpressError, UnknownNameError
from ..common.frozen import read_only
from ..common.outlets.described import Along, Bars, Block, Chart, Column, Curve, Figure, Polar, Section, Table
from ..common.quantities import NEGLIGIBLE, RPM, Array, quantity
from ..kinematics.cycle import cycle
from ..kinematics.described import along_motion, by_driver, chart, driver_speeds, kinds_of_drivers, known_dead_centres, slide_charts
from ..kinematics.main_data import directions, forward_share, sense_of_rotation, tool_in_words
from ..kinematics.motion import ROUNDING, Motion, finite, is_constant, is_cycle
from ..kinematics.poses import loaded_bodies, poses
from ..kinematics.slide_path import DeadCentres, DeadCentresOverTravel, stroke_turns
from ..kinematics.slide_path import turning_points as strokes_of
from ..linkage.linkage import Linkage
from ..linkage.planarity import UPRIGHT
from ..loads.link import LinkLoad
from .applied_loads import process_work, turning_points
from .cams import CamReactions, cam
from .driving_energy import driving_energy
from .extremes import AXES, DrivenMotion, at_peaks, finite_forces, held_moments, over_time, rms_of, rounding, torque_without_rounding
from .harmonics import HarmonicAnalysis, harmonics
from .reactions import Reactions, carrying
from .timing import TimingDiagram

BEYOND = 1.25  # height shown over the process, divided by the largest at which there is a force
CLOSED = 1e-12  # gap [lengths of the linkage] or residual that is rounding
NO_WORK = 1e-8  # share of the largest work, or of that which a flywheel takes up, below which a work is rounding


def described(reactions: Reactions) -> tuple[Section, ...]:
    """The sections of reactions to a motion; charts have the states on both sides of each step of the load."""
    rounding(reactions)  # which refuses forces that are not finite
    drawn, press = drawn_states(reactions), reactions._press
    along = along_states(reactions, drawn)
    sections = [
        _motion(reactions),
        _slide(reactions, drawn, along),
        _process(reactions, drawn, along),
        *_drive(reactions, drawn, along),
        _bearings(reactions, drawn, along),
        *(cam_section(cam(press, reactions, each.name)) for each in press.contacts if each.kind == "cam"),
        _floor(reactions, drawn, along),
        Section("Checks", checks(press, float(reactions.motion.closure_error.max()), reactions)),
    ]
    return tuple(section for section in sections if section.figures or section.blocks or section.note)


def along_states(reactions: Reactions, drawn: Reactions) -> Along:
    """What charts of reactions run along, at the states that are drawn of them."""
    along = along_motion(reactions.motion, reactions._press)
    if drawn is reactions:
        return along
    motion = drawn.motion
    return replace(along, of=motion, values=motion.time if along.quantity == "s" else read_only(np.array(motion.crank_angle)))


def drawn_states(reactions: Reactions) -> Reactions:
    """Reactions with the states on both sides of each step of the load, so that a step is drawn as one."""
    found = at_peaks(reactions)
    return found.reactions if any(found.remarks) else reactions


# --------------------------------------------------------------------------------------------------------------------------- where it is


@dataclass(frozen=True)
class Places:
    """Where a press is in the states of a motion, as tables of peaks say it.

    Attributes:
        of_what: what distinguishes the states: the crank or driver, or the time if there are several drivers.
        quantity: of that.
        values: (n,) of that, within a period.
        heights: (n,) of the slide above bottom dead centre, or above the lowest state if several drivers move it [m]; None without.
        bottom: bottom dead centre as a position of the slide [m]; None if there is none.
        remarks: what is in each state, as "where the load begins"; empty if nothing is said of any.
    """

    of_what: str
    quantity: str
    values: Array
    heights: Array | None
    bottom: float | None
    remarks: tuple[str, ...] = ()

    @staticmethod
    def at_peaks(reactions: Reactions) -> Places:
        """The places in the states of `extremes.at_peaks`."""
        found = at_peaks(reactions)
        return replace(Places.of(reactions._press, found.reactions.motion), remarks=found.remarks)

    @staticmethod
    def of(press: Linkage, motion: Motion) -> Places:
        """The places in the states of a motion."""
        first, several, ends = motion.driver_coordinates[0], len(motion.drivers) > 1, known_dead_centres(press)
        bottom = None if ends is None else ends.bottom_position
        heights = None
        if press.slide is not None and (several or bottom is not None):
            heights = motion.slide_position - (motion.slide_position.min() if bottom is None else bottom)
        if several and motion._time is not None:
            return Places("time", "s", motion.time, heights, bottom)
        return Places(first.part, "rad" if first.turns else "height", np.asarray(motion.shown_position) / first.scale, heights, bottom)

    def said(self, at: int) -> str:
        """Where it is in a state: "at 30.000 deg, 12.000 mm"."""
        height = "" if self.heights is None else f", {quantity('height').text(float(self.heights[at]))}"
        remark = f", {self.remarks[at]}" if self.remarks and self.remarks[at] else ""
        value = float(np.ravel(self.values[at])[0])
        place = f"{value:.5f} s" if self.quantity == "s" else quantity(self.quantity).text(value)
        return f"at {place}{height}{remark}"


def extreme(
    name: str,
    values: Array,
    unit: str,
    choose: Callable[[Array], np.intp],
    places: Places,
    kind: str = "",
) -> Figure:
    """An extreme of a quantity [SI unit] and where the press is then; of extremes that differ by rounding the first."""
    size = float(np.abs(values).max())
    at = int(np.argmax(np.abs(values - values[choose(values)]) <= 1e-12 * size))
    return Figure(name, float(values[at]), unit, places.said(at), kind=kind)


# ------------------------------------------------------------------------------------------------------------------------------- motion


def is_period(press: Linkage, motion: Motion) -> bool:
    """Whether a motion is a period of `cycle`: at constant speed, or harmonically there and back."""
    if len(motion.drivers) > 1:
        return False
    if motion.driver_coordinates[0].turns:
        return is_cycle(motion) and is_constant(motion.crank_speed)
    fastest = float(np.abs(motion.crank_speed).max())
    if not fastest or len(motion.crank_angle) < 3:
        return False
    try:
        again = cycle(press, fastest, points=len(motion.crank_angle))
    except PinpressError:
        return False
    return bool(np.allclose(again.crank_angle, motion.crank_angle) and np.allclose(again.crank_speed, motion.crank_speed))


def _motion(reactions: Reactions) -> Section:
    """The speed of a period with its number of states; of any other motion its duration, and how every driver moves."""
    motion, press = reactions.motion, reactions._press
    counted = f" from {press.zero}" if press.zero else ""
    first = motion.driver_coordinates[0]
    if is_period(press, motion):
        states = f"{len(motion.crank_angle)} {first.position}s{counted}, engine {reactions.engine!r}"
        return Section("Motion", note=f"{_speed(press, motion)}; {states}")
    lasting = f"{motion.time[-1] - motion.time[0]:.6g} s, " if motion._time is not None else ""
    states = f"{lasting}{len(motion.crank_angle)} states, engine {reactions.engine!r}"
    return Section("Motion", blocks=[driver_table(motion, counted)], note=states)


def driver_table(motion: Motion, counted: str = "") -> Table:
    """How far and how fast every driver moves; speeds are the fastest ones with their signs."""
    coordinates, count = motion.driver_coordinates, len(motion.drivers)
    angles, speeds = (np.reshape(values, (-1, count)).T for values in (motion.crank_angle, motion.crank_speed))
    rows = []
    for name, each, angle, speed in zip(motion.drivers, coordinates, angles, speeds, strict=True):
        place, fast = quantity("angle" if each.turns else "height"), quantity(f"{each.unit}/s")
        ends = [place.text(float(value)) for value in (angle[0], angle[-1], angle.min(), angle.max())]
        rows.append([name, *ends, fast.text(float(speed[np.abs(speed).argmax()]), digits=5)])
    heads = ("", "first", "last", "lowest", "highest", "fastest")
    columns = [Column(head, list(cells)) for head, cells in zip(heads, zip(*rows, strict=True), strict=True)]
    return Table("drivers", f"Drivers{f', counted{counted}' if counted else ''}", columns)


def _speed(press: Linkage, motion: Motion) -> str:
    """Speed and sense of rotation, and strokes per minute if the slide makes one in some turns."""
    if not motion.driver_coordinates[0].turns:
        fastest = float(np.abs(motion.crank_speed).max())
        return f"{press.driver} slides there and back, harmonically, at up to {1e3 * fastest:g} mm/s"
    speed = float(motion.crank_speed[0])
    turning = f"{press.driver} turns {sense_of_rotation(press, speed)} at {abs(speed) / RPM:g} r/min"
    ends = known_dead_centres(press)
    return turning if ends is None else f"{abs(speed) / RPM * ends.strokes_per_turn:g} strokes/min, {turning}"


# -------------------------------------------------------------------------------------------------------------------------------- slide


def _slide(reactions: Reactions, drawn: Reactions, along: Along) -> Section:
    press, motion = reactions._press, at_peaks(reactions).reactions.motion
    if press.slide is None:
        return Section("Slide")
    charts = slide_charts(drawn.motion, along, turning_points(press)[0])
    places = Places.of(press, motion)
    position = motion.slide_position
    ends = known_dead_centres(press)
    if ends is not None and is_period(press, reactions.motion):
        down, up = directions(press)
        coordinate = motion.driver_coordinates[0]
        figures = [
            Figure("stroke", ends.stroke, "height", kind="slide"),
            *(_turning(press, reactions.motion, ends, down, up) if coordinate.turns else _sliding(ends)),
        ]
        above = "bottom dead centre"
    else:
        low, high = int(position.argmin()), int(position.argmax())
        above = "the lowest place in this motion" if places.bottom is None else "bottom dead centre"
        figures = [
            Figure("way", float(position[high] - position[low]), "height", kind="slide"),
            Figure("lowest position", float(position[low]), "height", places.said(low)),
            Figure("highest position", float(position[high]), "height", places.said(high)),
        ]
    note = f"{press.slide}; heights are above {above}"
    return Section("Slide", [*figures, *_fastest(press, motion, places)], charts, note=note)


def _turning(press: Linkage, motion: Motion, ends: DeadCentres, down: str, up: str) -> list[Figure]:
    """The dead centres of a crank that turns, and the time that the strokes take."""
    speed = float(motion.crank_speed[0])
    period, forward = 2 * np.pi * ends.turns / abs(speed), forward_share(press, speed)
    parts = f", in {ends.strokes} strokes" if ends.strokes > 1 else ""

    def time(angle: float) -> float:
        return float((angle if speed > 0 else 2 * np.pi * ends.turns - angle) / abs(speed))

    at = [("top dead centre", ends.top_angle), ("bottom dead centre", ends.bottom_angle)]
    drawn = float(motion.slide_position[0] - ends.bottom_position)
    return [
        *(Figure(name, angle, "rad", f"at {time(angle):.6f} s") for name, angle in at),
        *([] if press.zero else [Figure("as drawn (0 deg)", drawn, "height")]),
        Figure("working stroke", forward, "share", f"of the time, {forward * period:.6f} s, {down}{parts}"),
        Figure("return stroke", 1 - forward, "share", f"of the time, {(1 - forward) * period:.6f} s, {up}{parts}"),
    ]


def _sliding(ends: DeadCentres) -> list[Figure]:
    """The dead centres of a press whose driver slides."""
    places = (("top dead centre", ends.top_angle), ("bottom dead centre", ends.bottom_angle))
    return [Figure(name, place, "height", "of the driver") for name, place in places]


def _fastest(press: Linkage, motion: Motion, places: Places) -> list[Figure]:
    """The largest speeds and accelerations of the slide both ways."""
    velocity, acceleration, (down, up) = motion.slide_velocity, motion.slide_acceleration, directions(press)
    quantities = [
        ("fastest, working stroke", -velocity, "m/s"),
        ("fastest, return stroke", velocity, "m/s"),
        ("largest acceleration up" if up == "up" else "acceleration towards top", acceleration, "m/s2"),
        ("largest acceleration down" if down == "down" else "acceleration towards bottom", -acceleration, "m/s2"),
    ]
    return [extreme(name, values, unit, np.argmax, places) for name, values, unit in quantities]


# ------------------------------------------------------------------------------------------------------------------------------ process


def _process(reactions: Reactions, drawn: Reactions, along: Along) -> Section:
    force = finite("process force", drawn.process_force)
    if not force.any():
        return Section("Process")
    process = Chart("process", "Process force", "N", along, [Curve("process force", force)])
    return Section(
        "Process",
        process_figures(reactions),
        [process, force_over_height(drawn, along)],
        note=f"force acts {tool_in_words(reactions._press)}",
    )


def process_figures(reactions: Reactions) -> list[Figure]:
    """The largest force and the work of the process; none without a process."""
    peaks = at_peaks(reactions).reactions
    if not peaks.process_force.any():
        return []
    press, motion = reactions._press, reactions.motion
    ends, work, turns = known_dead_centres(press), reactions.process_work, motion.period_turns
    over = "over the motion"
    if is_period(press, motion):
        over = "a stroke" if ends else "a period"
    if ends is not None and is_period(press, motion):
        work /= ends.strokes_per_turn * (turns or 1)
        over += f", on average of the {ends.strokes} of {_turns(ends)}{_work_of_each(press, motion, reactions)}" if ends.strokes > 1 else ""
    return [
        extreme("largest process force", peaks.process_force, "N", np.argmax, Places.at_peaks(reactions), kind="force"),
        Figure("work of the process", work, "J", over, kind="energy"),
    ]


def force_over_height(drawn: Reactions, over: Along) -> Chart:
    """Force of the process loads over the slide's height."""
    motion, force = drawn.motion, drawn.process_force
    bottom = turning_points(drawn._press)[0]
    height = motion.slide_position - (bottom if math.isfinite(bottom) else motion.slide_position.min())
    axis = "height above bottom dead centre" if math.isfinite(bottom) else "height above the lowest state"
    reach = min(BEYOND * float(height[force != 0].max()), float(height.max()))
    along = Along(axis, "m", of=motion, period=over.period)
    return Chart("force_height", "Force over the height", "N", along, [Curve("process force", force, height)], reach=(0.0, reach))


def _work_of_each(press: Linkage, motion: Motion, reactions: Reactions) -> str:
    """The work of the process in each of several strokes that differ, in words; of a driver that slides nothing."""
    points, turns = strokes_of(press), motion.period_turns
    if turns is None:
        return ""
    period, starts = 2 * np.pi * points.turns, np.sort([points.places[top] for top, _ in points.strokes])
    middle = motion.crank_angle + 0.5 * (motion.crank_angle[1] - motion.crank_angle[0])
    stroke = np.searchsorted(starts, middle % period) % len(starts)
    works = np.bincount(stroke, process_work(reactions.loads, press, motion), len(starts)) * points.turns / turns
    scale = quantity("J").scale(works.tolist(), digits=5)
    return f": {', '.join(scale.shown(float(work)) for work in works)} {scale.unit}"


def _turns(ends: DeadCentres) -> str:
    """The turns after which the slide repeats its motion, or the driver's way there and back, in words."""
    if isinstance(ends, DeadCentresOverTravel):
        return "a way there and back"
    return "a turn" if ends.turns == 1 else f"{ends.turns:.6g} turns"


# -------------------------------------------------------------------------------------------------------------------------------- drive


def _drive(reactions: Reactions, drawn: Reactions, along: Along) -> list[Section]:
    """Torque or force of every driver, speeds that are not constant, energy, and gear pairs."""
    figures, energy = energy_of_stroke(reactions)
    blocks: list[Block] = [*driving_charts(drawn, along), *driver_speeds(drawn.motion, along), *energy]
    found = at_peaks(reactions)
    coordinates, places = reactions.motion.driver_coordinates, replace(Places.at_peaks(reactions), heights=None)
    efforts = (torque_without_rounding(found.reactions), found.reactions.motion.crank_speed)
    torques, speeds = (np.reshape(values, (-1, len(coordinates))).T for values in efforts)
    mean = over_time(reactions)
    over = np.reshape(torque_without_rounding(mean.reactions), (-1, len(coordinates))).T
    own: list[Figure] = []
    for driver, coordinate, torque, speed, by_time in zip(reactions.motion.drivers, coordinates, torques, speeds, over, strict=True):
        if reactions.passive == "free" and driver in reactions._press.passive:
            continue  # where nothing drives it there is only rounding
        of = f" of {driver}" if len(coordinates) > 1 else ""
        what, unit = coordinate.effort, coordinate.effort_unit
        own += [
            extreme(f"largest {what}{of}", torque, unit, np.argmax, places, kind="torque"),
            extreme(f"smallest {what}{of}", torque, unit, np.argmin, places, kind="torque"),
            Figure(f"rms {what}{of}", rms_of(by_time, mean.share), unit),
            extreme(f"largest power{of}", torque * speed, "W", np.argmax, places),
        ]
    note = "Torques and forces act on the driver, along its axis."
    sections = [Section("Drive", [*own, *figures], blocks, note=note)]
    pairs = _gear_pairs(reactions)
    return [*sections, pairs] if pairs.figures else sections


def driving_charts(drawn: Reactions, along: Along) -> list[Chart]:
    """Charts of the driving torques of the drivers that turn, and of the driving forces of those that slide, a curve a driver; for a run
    also of the torques and forces of its drives, which turn the flywheels too."""
    motion, found = drawn.motion, []
    for kind in kinds_of_drivers(motion):
        curves = by_driver(f"driving {kind.effort}", motion, torque_without_rounding(drawn), kind)
        if isinstance(motion, DrivenMotion):
            drives = by_driver("drive", motion, motion.drive_torque, kind)
            curves |= {name if name == "drive" else f"drive of {name}": values for name, values in drives.items()}
        name = "torque" if kind.turns else "driving_force"
        found.append(chart(name, f"Driving {kind.effort}", kind.effort_unit, along, curves))
    return found


def energy_of_stroke(reactions: Reactions) -> tuple[list[Figure], list[Bars]]:
    """Where the energy of a stroke goes at constant speed; nothing if that is not known."""
    motion = reactions.motion
    first = motion.driver_coordinates[0]
    simulated = isinstance(motion, DrivenMotion)
    if simulated or not first.turns or motion.crank_speed.ndim > 1 or not is_cycle(motion) or not is_constant(motion.crank_speed):
        return [], []
    asked = driving_energy(reactions)
    turns, period_turns = stroke_turns(reactions._press), motion.period_turns
    strokes = 1.0 if turns is None or period_turns is None else period_turns / turns
    by_time = over_time(reactions)
    work = {
        "drive": asked.work,
        "process": reactions.process_work,
        "friction": sum(float(by_time.weight @ power) for power in by_time.reactions.friction_power.values()),
    }
    if any(isinstance(load, LinkLoad) for load in reactions.loads):
        work["springs, dampers, other forces"] = work["drive"] - work["process"] - work["friction"]
    least = NO_WORK * max(asked.stored, abs(asked.work))
    figures = [Figure("taken up and given off", asked.stored, "J", "by a flywheel at an even torque")]
    if abs(asked.work) > least:
        figures = [Figure("mean torque", asked.mean_torque, "N m"), Figure("mean power", asked.mean_power, "W"), *figures]
    kinds = {name: value / strokes for name, value in work.items() if abs(value) > least}
    # of two works one is the other
    return figures, works("energy", "Energy of a stroke", kinds) if len(kinds) > 2 else []


def works(name: str, title: str, work: Mapping[str, float]) -> list[Bars]:
    """Works [J] as bars; those that are rounding next to the largest are left out, and the chart if none is left."""
    largest = max(map(abs, work.values()), default=0.0)
    left = {what: value for what, value in work.items() if abs(value) > NO_WORK * largest}
    return [Bars(name, title, "J", list(left), {"work": np.array(list(left.values()))})] if left else []


def _gear_pairs(reactions: Reactions) -> Section:
    press = reactions._press
    toothed, elements = ({contact.relation for contact in of.contacts} for of in (press.structure, press))
    pairs = {relation.name: k for k, relation in enumerate(press.relations) if relation.is_pair and k not in elements}
    left_out = "" if toothed.issuperset(pairs.values()) else "; bearing forces leave out those between the teeth of two shafts"
    places = replace(Places.at_peaks(reactions), heights=None)
    figures: list[Figure] = []
    for name, torque in at_peaks(reactions).reactions.coupling_torque.items():
        if name not in pairs:
            continue  # a machine element is listed among the bearings
        unit = "N m" if press.axes[press.relations[pairs[name]].joint].turns else "N"
        figures += [extreme(f"{name}, largest", torque[:, 0], unit, np.argmax, places)]
        figures += [extreme(f"{name}, smallest", torque[:, 0], unit, np.argmin, places)]
    return Section("Gear pairs", figures, note=f"Torque or force on the joint that mimics, along its axis{left_out}." if figures else "")


# ----------------------------------------------------------------------------------------------------------------------------- bearings


def _bearings(reactions: Reactions, drawn: Reactions, along: Along) -> Section:
    press = reactions._press
    if not press.bearings:
        return Section("Bearings and guides")
    largest = reactions._largest_force
    sizes = _sizes(drawn)
    blocks: list[Block] = [chart("bearings", "Bearing forces", "N", along, sizes, largest)]
    moment = bearing_moments(drawn, along)
    blocks += [] if moment is None else [moment]
    blocks += [peaks_of_bearings(reactions), bearing_table(reactions)]
    blocks += [tooth_table(reactions)] if reactions.mesh else []
    for polar in loci(reactions, carrying(press, as_drawn=True)):
        blocks += [replace(polar, note=left_open(reactions, polar.title)), components(drawn, polar.title, along)]
    most = max(sizes, key=lambda name: float(sizes[name].max()))
    peak = at_peaks(reactions).reactions
    size = np.linalg.norm(peak.bearing_force[most], axis=1)
    where = extreme("largest bearing force", size, "N", np.argmax, Places.at_peaks(reactions), kind="bearing")
    return Section("Bearings and guides", [replace(where, where=f"{most}, {where.where}")], blocks)


def _sizes(drawn: Reactions) -> dict[str, Array]:
    least = rounding(drawn).force
    return {name: np.linalg.norm(_clean(force, least), axis=1) for name, force in finite_forces(drawn).items()}


def bearing_moments(drawn: Reactions, along: Along) -> Chart | None:
    """Magnitudes of the moments that bearings and guides hold, see `held_moments`; None if none does."""
    least = rounding(drawn).moment
    sizes = {name: np.linalg.norm(_clean(moment, least), axis=1) for name, moment in held_moments(drawn).items()}
    holding = {name: size for name, size in sizes.items() if size.any()}
    return chart("moments", "Moments in bearings and guides", "N m", along, holding) if holding else None


def components(drawn: Reactions, name: str, along: Along) -> Chart:
    """World components of the force in a bearing or guide; those that are zero throughout are left out, unless all are."""
    found = _components(
        f"components {name}", f"Force in {name}", "N", f"force in {name}", drawn.bearing_force[name], rounding(drawn).force, along
    )
    return replace(found, detail=True)


def peaks_of_bearings(reactions: Reactions) -> Bars:
    """The largest forces of all bearings and guides."""
    peaks, least = at_peaks(reactions).reactions, rounding(reactions).force
    sizes = {name: float(np.linalg.norm(_clean(force, least), axis=1).max()) for name, force in finite_forces(peaks).items()}
    return Bars("peaks", "Peak bearing forces", "N", list(sizes), {"peak": np.array(list(sizes.values()))})


def bearing_table(reactions: Reactions) -> Table:
    """The largest force and moment of every bearing over a motion's states, in the order of the drawing, where the crank and the slide are
    then, and the range of the force along each axis."""
    places, press, reactions = Places.at_peaks(reactions), reactions._press, at_peaks(reactions).reactions
    names = [name for name in carrying(press, as_drawn=True) if name in reactions.bearing_force]
    sizes = {name: np.linalg.norm(reactions.bearing_force[name], axis=1) for name in names}
    moments = [float(np.linalg.norm(reactions.bearing_moment[name], axis=1).max(initial=0.0)) for name in names]
    largest = max((float(size.max()) for size in sizes.values()), default=0.0)
    least = ROUNDING * largest
    force = least / NEGLIGIBLE  # so that what is rounding is written as 0
    axes = [i for i in range(3) if any(np.abs(reactions.bearing_force[name][:, i]).max() > least for name in names)]
    at = {name: int(sizes[name].argmax()) for name in names}
    loaded = {name: sizes[name][at[name]] > least for name in names}
    where = [float(np.ravel(places.values[at[name]])[0]) if loaded[name] else "-" for name in names]
    columns = [
        Column("", names),
        Column("peak force", [float(sizes[name][at[name]]) for name in names], "N", force),
        Column(f"at {places.of_what}", where, places.quantity),
    ]
    if places.heights is not None:
        heights = places.heights
        columns.append(Column("height", [float(heights[at[name]]) if loaded[name] else "-" for name in names], "height"))
    columns += [
        Column(f"range {AXES[i]}", [float(np.ptp(reactions.bearing_force[name][:, i])) for name in names], "N", force) for i in axes
    ]
    columns.append(Column("peak moment", moments, "N m", force * press.size))
    title = "Bearings (action of parent on child, of link1 on link2), each at its peak"
    return Table("bearings_at_peak", title, columns, most=200)


def tooth_table(reactions: Reactions) -> Table:
    """For all teeth and threads the force of the first link on the second one where it is largest, and the largest lost power."""
    places, press, reactions = Places.at_peaks(reactions), reactions._press, at_peaks(reactions).reactions
    found, between = reactions.mesh, {contact.name: (contact.first, contact.second) for contact in press.contacts}
    names = list(found)
    sizes = {name: np.linalg.norm(reactions.bearing_force[name], axis=1) for name in names}
    at = {name: int(size.argmax()) for name, size in sizes.items()}
    force = max((float(size.max()) for size in sizes.values()), default=0.0)
    columns = [
        Column("", names),
        Column("force of - on", [" - ".join(map(press.link_of, between[name])) for name in names]),
        Column("peak force", [float(sizes[name][at[name]]) for name in names], "N", force),
        Column(f"at {places.of_what}", [float(np.ravel(places.values[at[name]])[0]) for name in names], places.quantity),
        *(
            Column(part, [float(getattr(found[name], part)[at[name]]) for name in names], "N", force)
            for part in ("tangential", "radial", "axial")
        ),
    ]
    lost = [float(found[name].power.max()) for name in names]
    columns += [Column("largest power lost", lost, "W")] if any(lost) else []
    return Table("teeth_at_peak", "Teeth and threads, each at its peak", columns, most=200)


def left_open(reactions: Reactions, name: str) -> str:
    """What rigid mechanics does not decide of a bearing, and is not zero, in words; empty if there is nothing."""
    least = rounding(reactions)
    axes = reactions.indeterminate_axes.T
    sizes = [np.abs(vector @ axes).max(axis=0) for vector in (reactions.bearing_force[name], reactions.bearing_moment[name])]
    shown = np.concatenate([sizes[0] > least.force, sizes[1] > least.moment]) & reactions.indeterminate[name]
    names = AXES if np.array_equal(axes, np.eye(3)) else ("h", "across the plane", "u")
    return ", ".join(itertools.compress([f"{kind} {axis}" for kind in ("force", "moment") for axis in names], shown))


def loci(reactions: Reactions, names: Sequence[str]) -> list[Polar]:
    """Polar diagrams of the forces of bearings.

    The diagram of a planar press lies in its plane: along the plane's two world axes, or, if the plane is tilted, along its horizontal
    ("h") and the direction up it ("u"). In space it is the projection on the two world axes along which the force ranges most.

    Args:
        reactions: reactions that have these bearings.
        names: names of the bearings.

    Raises:
        UnknownNameError: there is no such bearing.
    """
    motion, press = reactions.motion, reactions._press
    for name in names:
        if not isinstance(name, str) or name not in carrying(press):
            raise UnknownNameError("bearing", name, carrying(press))
    turned = poses(press, motion.joint_position).rotation @ poses(press, np.zeros((1, press.model.nv))).rotation.swapaxes(2, 3)
    return [_locus(reactions, name, turned) for name in names]


def _locus(reactions: Reactions, name: str, turned: Array) -> Polar:
    """The locus of a bearing if the bodies are turned by these rotations (joints + 1, n, 3, 3) from the drawn pose."""
    press, least = reactions._press, rounding(reactions).force
    force = _clean(finite(f"force in {name}", reactions.bearing_force[name]), least)
    loaded = (*loaded_bodies(press), *(contact.second for contact in press.contacts))
    body = loaded[carrying(press).index(name)]
    own = np.einsum("nji,nj->ni", turned[body], force)
    axes, across = _directions(press, force, least)
    world, own = read_only(force @ across.T), read_only(own @ across.T)
    return Polar(f"polar {name}", name, press.link_of(body), axes, "N", world, own, reactions.motion, is_cycle(reactions.motion))


def _directions(press: Linkage, force: Array, least: float) -> tuple[tuple[str, str], Array]:
    """Names and world directions (2, 3) of a polar diagram's axes; forces (n, 3) below ``least`` are rounding."""
    normals = press.engine().turning_axes()  # a planar press has one
    if len(normals) == 1 and np.abs(normals).max() < 1 - UPRIGHT:
        return ("h", "u"), press.planarity.axes[[0, 2]]
    across = _least_moved(force, least) if len(normals) > 1 else int(np.abs(normals[0]).argmax())
    first, second = (axis for axis in range(3) if axis != across)
    return (AXES[first], AXES[second]), np.eye(3)[[first, second]]


def _least_moved(force: Array, least: float) -> int:
    """The axis along which a force (n, 3) ranges least; of several that are alike within rounding, the one with the smaller force."""
    left = [1, 0, 2]  # y first, as most presses stand in the x-z plane
    for sizes in (np.ptp(force, axis=0), np.abs(force).max(axis=0)):
        left = [axis for axis in left if sizes[axis] <= min(sizes[left]) + least]
    return left[0]


# -------------------------------------------------------------------------------------------------------------------------------- floor


def _floor(reactions: Reactions, drawn: Reactions, along: Along) -> Section:
    blocks: list[Block] = [shaking(drawn, along), shaking_moment(drawn, along)]
    bars = harmonics_of_shaking(reactions)
    blocks += [] if bars is None else [bars]
    force = at_peaks(reactions).reactions.shaking_force
    least = ROUNDING * reactions._largest_force
    figures = []
    for i, axis in enumerate(AXES):
        if np.abs(force[:, i]).max(initial=0.0) > least:
            low, high, width = float(force[:, i].min()), float(force[:, i].max()), float(np.ptp(force[:, i]))
            scale = quantity("N").scale([low, high], reactions._largest_force, digits=5)
            ends = f"from {scale.shown(low)} to {scale.shown(high)} {scale.unit}"
            figures.append(Figure(f"range of shaking force {axis}", width, "N", ends, kind="floor"))
    return Section("Foundation", figures, blocks, note="The shaking force includes the weight.")


def shaking(drawn: Reactions, along: Along) -> Chart:
    """World components of the shaking force; those that are zero throughout are left out, unless all are."""
    return _components("shaking", "Shaking force", "N", "shaking force", drawn.shaking_force, rounding(drawn).force, along)


def shaking_moment(drawn: Reactions, along: Along) -> Chart:
    """World components of the shaking moment about the world origin, without those that are zero, unless all are."""
    least = rounding(drawn).moment
    return _components("shaking_moment", "Shaking moment", "N m", "shaking moment", drawn.shaking_moment, least, along)


def harmonics_of_shaking(reactions: Reactions) -> Bars | None:
    """Amplitudes of the shaking force by axis, those that are not zero; None if the motion has no full period."""
    found: HarmonicAnalysis | None = harmonics(reactions.motion, reactions.shaking_force)
    if found is None or len(found.orders) < 2:
        return None
    force = reactions.shaking_force
    clean = _clean(force, rounding(reactions).force)
    axes = [i for i in range(3) if clean[:, i].any()] or [0, 1, 2]
    orders = [int(order) if order.is_integer() else float(order) for order in found.orders[1:]]
    series = {AXES[i]: found.amplitude[1:, i] for i in axes}
    means = [float(found.amplitude[0, i]) for i in axes]
    scale = quantity("N").scale(np.abs(clean).ravel().tolist(), float(np.abs(clean).max(initial=0.0)))
    words = ", ".join(f"{AXES[i]} {scale.shown(mean)} {scale.unit}" for i, mean in zip(axes, means, strict=True))
    return Bars(
        "harmonics",
        "Harmonics of the shaking force",
        "N",
        orders,
        series,
        across="order of the crank's speed",
        note=f"Mean: {words}.".replace("-", "\u2212"),
    )


# --------------------------------------------------------------------------------------------------------------------------------- cams


def cam_section(found: CamReactions) -> Section:
    """Extremes of a cam, and its lift, pressure angle, contact force and Hertzian pressure over the motion."""
    along = along_motion(found.motion, found._press)
    peaks = [
        ("largest contact force", found.largest_force, "N", "force"),
        ("least contact force", found.least_force, "N", ""),
        ("largest Hertzian pressure", found.largest_pressure, "Pa", ""),
        ("largest pressure angle", found.largest_pressure_angle, "rad", ""),
        ("least radius of the cam", found.least_radius, "length", ""),
    ]
    figures = [
        Figure(name, value, unit, f"at cam angle {quantity('angle').text(angle)}", kind=kind)
        for name, (value, angle), unit, kind in peaks
        if math.isfinite(value)
    ]
    if found.lift_off_speed is not None:
        figures.append(
            Figure("the roller leaves the cam", found.lift_off_speed, "rad/s", "the speed at which the least contact force is 0")
        )
    charts = [
        chart(f"lift {found.name}", "Lift of the follower", "rad" if found.arm else "height", along, {"lift": found.lift}),
        chart(f"pressure angle {found.name}", "Pressure angle", "rad", along, {"pressure angle": found.pressure_angle}),
        chart(f"contact force {found.name}", "Contact force", "N", along, {"contact force": found.force}),
        chart(f"pressure {found.name}", "Hertzian pressure", "Pa", along, {"pressure": found.pressure}),
    ]
    held = found.grooved or found.least_force[0] >= 0.0
    note = "" if held else "The least contact force is below 0: the roller leaves the cam, and the forces are not those of the press."
    return Section(f"Cam {found.name}", figures, charts, note=note, press=found._press, of="cam")


# ------------------------------------------------------------------------------------------------------------------------------- checks


def checks(press: Linkage, gap: float, reactions: Reactions) -> list[Figure]:
    """How well loops and the balance of power are fulfilled; ``gap``: the largest of a loop [m]."""
    residual = float(np.abs(reactions.power_residual).max())
    closed: float | str = "closed, up to rounding errors" if gap <= CLOSED * max(press.size, 1.0) else gap
    balanced: float | str = "0, up to rounding errors" if residual <= CLOSED else f"{residual:.3g}"
    return [
        Figure("largest loop gap", closed, "m"),
        Figure("largest power residual", balanced, "-", "of the peak power: remaining error of drive - loads - change of energy"),
    ]


# -------------------------------------------------------------------------------------------------------------------------------- parts


def _components(name: str, title: str, unit: str, what: str, vector: Array, least: float, along: Along) -> Chart:
    clean = _clean(finite(what, vector), least)
    shown = [i for i in range(3) if clean[:, i].any()] or range(3)
    return chart(name, title, unit, along, {AXES[i]: clean[:, i] for i in shown})


def _clean(vector: Array, least: float) -> Array:
    """The vector (n, 3), with zeros for components that nowhere exceed rounding."""
    return np.where(np.abs(vector).max(axis=0) > least, vector, 0.0)


def timing_diagram(found: TimingDiagram) -> tuple[Section, ...]:
    """A timing diagram: a bar for each window."""
    press, feed, bars = found._press, found.feed, found.bars
    axis, ends = press.driver_coordinates[0], known_dead_centres(press)
    marks = {} if ends is None else {"TDC": ends.top_angle, "BDC": ends.bottom_angle}
    curves = []
    for row, each in enumerate(bars):
        reach = each.crank_angle + np.array([0.0, -each.turned if found.backwards else each.turned])  # in one piece, also beyond the period
        again = sum(other.name == each.name for other in bars[:row])
        curves.append(Curve(f"{each.name} {again + 1}" if again else each.name, np.full(2, -float(row)), reach, look="strong"))
    along = Along(axis.counted, axis.unit, marks=marks)
    chart = Chart("timing", "Timing diagram, a bar a row", "-", along, curves)
    figures = [
        Figure("feed window", feed.turned, "angle", f"above {quantity('height').text(found.above)}"),
        Figure("feed window", feed.duration, "s"),
    ]
    if found.feed_time is not None and found.reserve is not None and found.highest_speed is not None:
        figures += [
            Figure("feeder's time", found.feed_time, "s", limit=feed.duration),
            Figure("reserve", found.reserve, "s"),
            Figure("feeder fits up to", found.highest_speed, "rad/s"),
        ]
    columns = [
        Column("window", [each.name for each in bars]),
        Column("from", [each.crank_angle for each in bars], "angle"),
        Column("to", [each.ends_at for each in bars], "angle"),
        Column("turned", [each.turned for each in bars], "angle"),
        Column("time", [each.duration for each in bars], "s"),
    ]
    return (Section("Timing", figures, [chart, Table("windows", "", columns, most=200)], press=press, of="diagram"),)


SECTIONS = {
    Reactions: lambda reactions, page: described(reactions),
    CamReactions: lambda found, page: (cam_section(found),),
    TimingDiagram: lambda found, page: timing_diagram(found),
}
"""How results of this room are described."""
