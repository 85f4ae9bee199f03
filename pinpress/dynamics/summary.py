"""The main results over one period of a press, as text."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..common import tables
from ..common.errors import PinpressError
from ..common.quantities import RPM, Array, DriverCoordinate
from ..kinematics.main_data import directions, forward_share, sense_of_rotation, tool_in_words
from ..kinematics.motion import Motion
from ..kinematics.slide_path import DeadCentres, DeadCentresOverTravel, dead_centres, turning_points
from ..kinematics.states import ROUNDING
from ..linkage.linkage import Linkage
from .applied_loads import process_work
from .extremes import at_peaks
from .reactions import Reactions

AXES = "xyz"
CLOSED = 1e-12  # gap [lengths of the linkage] or residual that is rounding


@dataclass(frozen=True)
class Places:
    """Where a press is in the states of a motion, as tables of peaks say it.

    Attributes:
        of_what: what tells the states apart: the crank or driver, or the time where there are several drivers.
        unit: of that.
        digits: behind the point, in tables.
        values: (n,) of that [unit].
        heights: (n,) of the slide above bottom dead centre, or above the lowest state where several drivers move it [m]; None without.
        bottom: bottom dead centre as a position of the slide [m]; None where there is none.
        remarks: what is in each state, as "where the load begins"; empty where nothing is said of any.
    """

    of_what: str
    unit: str
    digits: int
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
        first, several, ends = motion.driver_coordinates[0], len(motion.drivers) > 1, _dead_centres(press)
        bottom = None if ends is None else ends.bottom_position
        heights = None
        if press.slide is not None and (several or bottom is not None):
            heights = motion.slide_position - (motion.slide_position.min() if bottom is None else bottom)
        if several and motion._time is not None:
            return Places("time", "s", 4, motion.time, heights, bottom)
        return Places(first.part, first.shown_unit, 2, motion.shown_position, heights, bottom)

    def shown(self, at: int) -> str:
        """Where it is in a state, in a cell of a table."""
        return f"{self.values[at]:.{self.digits}f}"

    def said(self, at: int) -> str:
        """Where it is in a state, in words: "at 30.000 deg, 12.000 mm"."""
        height = "" if self.heights is None else f", {1e3 * self.heights[at]:9.3f} mm"
        remark = f", {self.remarks[at]}" if self.remarks and self.remarks[at] else ""
        return f"at {self.values[at]:8.{self.digits + 1}f} {self.unit}{height}{remark}"


Utilisation = tuple[Reactions, Array]
"""Reactions of n states, and (n,) process force divided by the permissible force in these [-]."""


def summary(
    press: Linkage, motion: Motion, reactions: Reactions, utilisation: Utilisation | None = None, *, prescribed: bool = False
) -> str:
    """Stroke, peaks and ranges over the period, with units, crank angles and heights, and how well the equations are fulfilled.

    Peaks are those of `extremes`; dead centres are exact. Heights of the slide are above bottom dead centre; of a
    press with several drivers, which has none, above the lowest state. Several drivers have no one crank angle: in its place stand times.
    Signs are those of `inverse_dynamics`.

    Args:
        press: The press.
        motion: The motion, with times.
        reactions: Reactions to this motion.
        utilisation: how much of the permissible force the process takes; None: it is not known.
        prescribed: Whether the motion is any one over time, of one driver or several, and not a period of `cycle`.
    """
    peaks = at_peaks(reactions).reactions
    lines = [
        *(_drivers(press, motion, reactions) if prescribed else _turning_press(press, motion, reactions)),
        *(_prescribed_slide(press, peaks.motion) if prescribed else _slide(press, peaks.motion)),
        *process_summary(press, motion, reactions, utilisation, prescribed=prescribed),
        *driving_lines(motion, reactions),
        *_gear_pairs(motion, reactions),
        *bearing_table(reactions),
        *_shaking(peaks),
        "",
        "Checks",
        *checks(press, float(motion.closure_error.max()), reactions),
    ]
    return "\n".join(lines)


def _turning_press(press: Linkage, motion: Motion, reactions: Reactions) -> list[str]:
    """Lines with the speed of a period, and its number of states."""
    counted = f"{motion.driver_coordinates[0].position}s{f' from {press.zero}' if press.zero else ''}"
    return [f"{press.name}: {_speed(press, motion)}", f"  {len(motion.crank_angle)} {counted}, engine {reactions.engine!r}"]


def _drivers(press: Linkage, motion: Motion, reactions: Reactions) -> list[str]:
    """Lines with the duration of a prescribed motion, its number of states, and how far and how fast every driver moves."""
    counted = f", counted from {press.zero}" if press.zero else ""
    return [
        f"{press.name}: a motion of {motion.time[-1] - motion.time[0]:.6g} s",
        f"  {len(motion.time)} states, engine {reactions.engine!r}",
        "",
        f"{'Driver' if len(motion.drivers) == 1 else 'Drivers'}{counted}",
        *driver_table(motion),
    ]


def driver_table(motion: Motion) -> list[str]:
    """Lines with how far and how fast every driver moves."""
    coordinates, count = motion.driver_coordinates, len(motion.drivers)
    angles, speeds = (np.reshape(values, (-1, count)).T for values in (motion.crank_angle, motion.crank_speed))
    rows = [["", "first", "last", "lowest", "highest", "", "fastest", ""]]
    for name, each, angle, speed in zip(motion.drivers, coordinates, angles, speeds, strict=True):
        places = (f"{each.scale * place + 0.0:.3f}" for place in (angle[0], angle[-1], angle.min(), angle.max()))
        unit, size = each.shown_speed
        rows.append([name, *places, each.shown_unit, f"{speed[np.abs(speed).argmax()] / size:.3f}", unit])
    return tables.fitted(rows)


def _speed(press: Linkage, motion: Motion) -> str:
    """Speed and sense of rotation in words, and strokes per minute where the slide makes one in some turns."""
    if not motion.driver_coordinates[0].turns:
        fastest = float(np.abs(motion.crank_speed).max())
        return f"{press.driver} slides there and back, harmonically, at up to {1e3 * fastest:g} mm/s"
    speed = float(motion.crank_speed[0])
    turning = f"{press.driver} turns {sense_of_rotation(press, speed)} at {abs(speed) / RPM:g} r/min"
    ends = _dead_centres(press)
    return turning if ends is None else f"{abs(speed) / RPM * ends.strokes_per_turn:g} strokes/min, {turning}"


def _slide(press: Linkage, motion: Motion) -> list[str]:
    if press.slide is None:
        return []
    try:
        ends = dead_centres(press)
    except PinpressError as error:
        return ["", f"Slide ({press.slide}): {error}"]
    coordinate, (down, up) = motion.driver_coordinates[0], directions(press)
    return [
        "",
        f"Slide ({press.slide}), heights above bottom dead centre",
        tables.entry("stroke", f"{1e3 * ends.stroke:.3f}", "mm"),
        *(_turning(press, motion, ends, down, up) if coordinate.turns else _sliding(coordinate, ends)),
        *_fastest(press, motion, Places.of(press, motion)),
    ]


def _fastest(press: Linkage, motion: Motion, places: Places) -> list[str]:
    """Lines with the largest speeds and accelerations of the slide both ways."""
    velocity, acceleration, (down, up) = motion.slide_velocity, motion.slide_acceleration, directions(press)
    quantities = [
        ("fastest, working stroke", -velocity, "m/s"),
        ("fastest, return stroke", velocity, "m/s"),
        ("largest acceleration up" if up == "up" else "acceleration towards top", acceleration, "m/s2"),
        ("largest acceleration down" if down == "down" else "... towards bottom", -acceleration, "m/s2"),
    ]
    return [_extreme(name, values, unit, np.argmax, places) for name, values, unit in quantities]


def _prescribed_slide(press: Linkage, motion: Motion) -> list[str]:
    """Lines with where the slide is in a prescribed motion, and how fast."""
    if press.slide is None:
        return []
    places, position = Places.of(press, motion), motion.slide_position
    low, high = int(position.argmin()), int(position.argmax())
    above = "its lowest place in this motion" if places.bottom is None else "bottom dead centre"
    return [
        "",
        f"Slide ({press.slide}), heights above {above}",
        tables.entry("way", f"{1e3 * (position[high] - position[low]):.3f}", "mm"),
        tables.entry("lowest position", f"{1e3 * position[low]:.3f}", "mm", places.said(low)),
        tables.entry("highest position", f"{1e3 * position[high]:.3f}", "mm", places.said(high)),
        *_fastest(press, motion, places),
    ]


def process_summary(
    press: Linkage, motion: Motion, reactions: Reactions, utilisation: Utilisation | None, *, prescribed: bool = False
) -> list[str]:
    """Lines with the largest force and the work of the process; none without a process. Arguments as of `summary`."""
    if not at_peaks(reactions).reactions.process_force.any():
        return []
    ends, work, places, peaks = _dead_centres(press), reactions.process_work, Places.at_peaks(reactions), at_peaks(reactions).reactions
    over = "in this motion" if prescribed else "a stroke" if ends else "a period"
    if not prescribed and ends is not None:
        work /= ends.strokes_per_turn * (motion.period_turns or 1)
        over += f", on average of the {ends.strokes} of {_turns(ends)}{_work_of_each(press, motion, reactions)}" if ends.strokes > 1 else ""
    scale = tables.scale("J", [work])
    lines = [
        "",
        "Process (force of the loads between slide and frame)",
        f"  process force acts {tool_in_words(press)}",
        _extreme("largest force", peaks.process_force, "N", np.argmax, places),
        tables.entry("work", scale.shown(work), scale.unit, over),
    ]
    if utilisation is not None:
        states, shares = utilisation
        at = int(np.argmax(shares))
        lines.append(tables.entry("of the permissible force", f"{100 * shares[at]:.2f}", "%", Places.of(press, states.motion).said(at)))
    return lines


def _work_of_each(press: Linkage, motion: Motion, reactions: Reactions) -> str:
    """The work of the process in each of several strokes that differ, in words; of a driver that slides nothing."""
    points, turns = turning_points(press), motion.period_turns
    if turns is None:
        return ""
    period, starts = 2 * np.pi * points.turns, np.sort([points.places[top] for top, _ in points.strokes])
    middle = motion.crank_angle + 0.5 * (motion.crank_angle[1] - motion.crank_angle[0])
    stroke = np.searchsorted(starts, middle % period) % len(starts)
    works = np.bincount(stroke, process_work(reactions.loads, press, motion), len(starts)) * points.turns / turns
    scale = tables.scale("J", works.tolist())
    return f": {', '.join(scale.shown(float(work)) for work in works)} {scale.unit}"


def _turns(ends: DeadCentres) -> str:
    """The turns after which the slide repeats its motion, or the driver's way there and back, in words."""
    if isinstance(ends, DeadCentresOverTravel):
        return "a way there and back"
    return "a turn" if ends.turns == 1 else f"{ends.turns:.6g} turns"


def _turning(press: Linkage, motion: Motion, ends: DeadCentres, down: str, up: str) -> list[str]:
    """Lines with the dead centres of a crank that turns, and with the time that the strokes take."""
    speed = float(motion.crank_speed[0])
    period, forward = 2 * np.pi * ends.turns / abs(speed), forward_share(press, speed)
    parts = f", in {ends.strokes} strokes" if ends.strokes > 1 else ""

    def time(angle: float) -> float:
        return float((angle if speed > 0 else 2 * np.pi * ends.turns - angle) / abs(speed))

    return [
        *(
            tables.entry(name, f"{np.degrees(angle):.3f}", "deg", f"at {time(angle):.6f} s")
            for name, angle in (("top dead centre", ends.top_angle), ("bottom dead centre", ends.bottom_angle))
        ),
        *([] if press.zero else [tables.entry("as drawn (0 deg)", f"{1e3 * (motion.slide_position[0] - ends.bottom_position):.3f}", "mm")]),
        tables.entry("working stroke", f"{100 * forward:.3f}", "%", f"of the time, {forward * period:.6f} s, {down}{parts}"),
        tables.entry("return stroke", f"{100 * (1 - forward):.3f}", "%", f"of the time, {(1 - forward) * period:.6f} s, {up}{parts}"),
    ]


def _sliding(coordinate: DriverCoordinate, ends: DeadCentres) -> list[str]:
    """Lines with the dead centres of a press whose driver slides."""
    places = (("top dead centre", ends.top_angle), ("bottom dead centre", ends.bottom_angle))
    return [tables.entry(name, f"{coordinate.scale * place:.3f}", coordinate.shown_unit, "of the driver") for name, place in places]


def driving_lines(motion: Motion, reactions: Reactions) -> list[str]:
    """Lines with the driving torque or force of every driver, and the largest power."""
    found, coordinates, places = at_peaks(reactions), motion.driver_coordinates, replace(Places.at_peaks(reactions), heights=None)
    efforts = (found.reactions.driving_torque, found.reactions.motion.crank_speed)
    torques, speeds = (np.reshape(values, (-1, len(coordinates))).T for values in efforts)
    lines: list[str] = []
    for driver, coordinate, torque, speed in zip(motion.drivers, coordinates, torques, speeds, strict=True):
        scale = tables.scale(coordinate.effort_unit, [float(np.abs(torque).max())])
        of = f" of {driver}" if len(coordinates) > 1 else ""
        lines += [
            "",
            f"Driving {coordinate.effort}{of} (on the driver, along its axis)",
            _extreme("largest", torque, coordinate.effort_unit, np.argmax, places),
            _extreme("smallest", torque, coordinate.effort_unit, np.argmin, places),
            tables.entry("rms", scale.shown(float(np.sqrt(found.weight @ torque**2))), scale.unit),
            _extreme("largest power", torque * speed, "W", np.argmax, places),
        ]
    return lines


def _gear_pairs(motion: Motion, reactions: Reactions) -> list[str]:
    press = reactions._press
    toothless = len(reactions.coupling_torque) > len(press.structure.racks)
    left_out = "; bearing forces leave out those between the teeth of two shafts" if toothless else ""
    lines = ["", f"Gear pairs (torque or force on the joint that mimics, along its axis{left_out})"] if reactions.coupling_torque else []
    places = replace(Places.at_peaks(reactions), heights=None)
    for name, torque in at_peaks(reactions).reactions.coupling_torque.items():
        unit = "N m" if press.axes[press.joints.index(name)].turns else "N"
        lines += [_extreme(f"{name}, largest", torque[:, 0], unit, np.argmax, places)]
        lines += [_extreme(f"{name}, smallest", torque[:, 0], unit, np.argmin, places)]
    return lines


def bearing_table(reactions: Reactions) -> list[str]:
    """Lines with the largest force and moment of every bearing over a motion's states, in the order of the drawing, where the crank and the
    slide are then, and the range of the force along each axis."""
    places, press, reactions = Places.at_peaks(reactions), reactions._press, at_peaks(reactions).reactions
    names = [name for name in press.bearings_as_drawn if name in reactions.bearing_force]
    sizes = {name: np.linalg.norm(reactions.bearing_force[name], axis=1) for name in names}
    moments = [float(np.linalg.norm(reactions.bearing_moment[name], axis=1).max(initial=0.0)) for name in names]
    largest = max((float(size.max()) for size in sizes.values()), default=0.0)
    forces = tables.scale("N", [largest], ROUNDING * largest)
    turning = tables.scale("N m", moments, ROUNDING * largest * press.size)
    axes = [i for i in range(3) if any(np.abs(reactions.bearing_force[name][:, i]).max() > forces.least for name in names)]
    heads = [
        f"peak force [{forces.unit}]",
        f"at {places.of_what} [{places.unit}]",
        *(["height [mm]"] if places.heights is not None else []),
    ]
    heads += [*(f"range {AXES[i]} [{forces.unit}]" for i in axes), f"peak moment [{turning.unit}]"]
    rows = [["", *heads]]
    for name, moment in zip(names, moments, strict=True):
        at = int(sizes[name].argmax())
        place = [places.shown(at), *([] if places.heights is None else [f"{1e3 * places.heights[at]:.3f}"])]
        if sizes[name][at] <= forces.least:
            place = ["-"] * len(place)
        ranges = [forces.shown(float(np.ptp(reactions.bearing_force[name][:, i]))) for i in axes]
        rows.append([name, forces.shown(float(sizes[name][at])), *place, *ranges, turning.shown(moment)])
    return ["", "Bearings (action of parent on child, of link1 on link2), each at its peak", *tables.fitted(rows)]


def _shaking(reactions: Reactions) -> list[str]:
    force = reactions.shaking_force
    largest = max((float(np.abs(each).max(initial=0.0)) for each in reactions.bearing_force.values()), default=0.0)
    scale = tables.scale("N", [float(np.abs(force).max(initial=0.0))], ROUNDING * largest)
    lines = ["", "Shaking force on the foundation, weight included"]
    for i, axis in enumerate(AXES):
        if np.abs(force[:, i]).max(initial=0.0) > scale.least:
            low, high, width = (scale.shown(float(value)) for value in (force[:, i].min(), force[:, i].max(), np.ptp(force[:, i])))
            lines.append(tables.entry(axis, low, scale.unit, f"to {high:>10} {scale.unit},  range {width:>10} {scale.unit}"))
    return lines


def checks(press: Linkage, gap: float, reactions: Reactions) -> list[str]:
    """Lines that say how well loops and the balance of power are fulfilled; ``gap``: the largest of a loop [m]."""
    residual = float(np.abs(reactions.power_residual).max())
    closed = "closed to rounding" if gap <= CLOSED * max(press.size, 1.0) else f"{gap:.3g}"
    balanced = "0 to rounding" if residual <= CLOSED else f"{residual:.3g}"
    return [
        tables.entry("largest loop gap", closed, "" if closed.startswith("closed") else "m"),
        tables.entry("largest power residual", balanced, "", "of the peak power: what drive, loads and energies leave over"),
    ]


def _dead_centres(press: Linkage) -> DeadCentres | None:
    try:
        return dead_centres(press) if press.slide is not None else None
    except PinpressError:
        return None


def _extreme(name: str, values: Array, unit: str, choose: Callable[[Array], np.intp], places: Places) -> str:
    """A line with an extreme of a quantity [SI unit] and where the press is then."""
    size = float(np.abs(values).max())
    at = int(np.argmax(np.abs(values - values[choose(values)]) <= 1e-12 * size))  # of those that differ by rounding the first
    scale = tables.scale(unit, [size])
    scale = scale._replace(decimals=scale.decimals + 1)  # where it is does not depend on the motion's states
    return tables.entry(name, scale.shown(float(values[at])), scale.unit, places.said(at))
