"""What is asked first of a press: stroke and dead centres, sense of rotation, size and masses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..common import tables
from ..common.errors import PinpressError
from ..common.quantities import CRANK, Array, DriverCoordinate
from ..common.results import Record
from ..engines.structure import drawn_placements
from ..linkage.linkage import UPRIGHT, Linkage
from ..linkage.tool_point import ALIKE
from .cycle import motion_through_change_points
from .slide_path import DeadCentres, dead_centres, turning_points

ALONG = 0.999  # cosine between two directions that are taken for one in words
POINTS = 721  # crank angles at which the travel of a slide without dead centres is looked for


@dataclass(frozen=True, repr=False)
class MainData(Record, units={"size": "m", "moving_mass": "kg", "slide_mass": "kg", "stroke": "m", "drawn_height": "m"}):
    """What is asked first of a press. What it does not have is None.

    Attributes:
        size: largest extent of its bearings in the drawn pose [m].
        moving_mass: mass of all links but the frame [kg].
        slide_mass: mass of the slide, with what is welded to it [kg].
        rotation: sense in which each driver turns at a positive speed, see `sense_of_rotation`.
        stroke: distance between the dead centres; of a crank that does not turn fully, the way of the slide as far as it turns [m].
        forward_share: share of the time in which the slide makes its way from top to bottom dead centre, or its ways, at a constant
            positive speed [-]; None if the driver slides.
        drawn_height: height of the slide above bottom dead centre in the drawn pose [m].
        tool: where process forces act on the slide, as text.
        dead_centres: where the slide turns back.
        bottoms: of every stroke the place of the driver at its bottom dead centre [rad or m], and the slide's height there above the lowest
            one [m].
        turns_between: crank angles between which the linkage locks [rad]; positions of a driver that slides [m].
        no_stroke: why the slide has no dead centres.
        coordinate: what the coordinate of the driver is.
    """

    size: float
    moving_mass: float
    slide_mass: float | None
    rotation: tuple[str, ...]
    stroke: float | None = None
    forward_share: float | None = None
    drawn_height: float | None = None
    tool: str | None = None
    dead_centres: DeadCentres | None = field(default=None, repr=False)
    bottoms: tuple[tuple[float, float], ...] = field(default=(), repr=False)
    turns_between: tuple[float, float] | None = field(default=None, repr=False)
    no_stroke: str | None = field(default=None, repr=False)
    coordinate: DriverCoordinate = field(default=CRANK, repr=False)


def main_data(press: Linkage, moves: bool = True) -> MainData:
    """The main data of a press.

    Args:
        press: the press.
        moves: whether its motion can be looked at; it cannot where its loops do not close.
    """
    masses = [float(inertia.mass) for inertia in press.model.inertias]
    slide = None if press.slide is None else masses[press.slide_guide.joint + 1]
    rotation = tuple(sense_of_rotation(press, driver=driver) for driver in range(len(press.motors)))
    data = MainData(press.size, sum(masses[1:]), slide, rotation, coordinate=next(iter(press.driver_coordinates), CRANK))
    if press.slide is None or not moves:
        return data
    data = replace(data, tool=tool_in_words(press))
    if len(press.drivers) > 1:
        return replace(data, no_stroke=f"{len(press.drivers)} drivers move the slide")
    try:
        ends = dead_centres(press)
    except PinpressError as error:
        return _as_far_as_it_turns(press, replace(data, no_stroke=str(error)))
    home = press.closed[list(press.driver_indices)]
    drawn = float(motion_through_change_points(press, home, 0.0).slide_position[0]) - ends.bottom_position
    forward, points = forward_share(press) if data.coordinate.turns else None, turning_points(press)
    bottoms = tuple((float(points.places[low]), float(points.positions[low]) - ends.bottom_position) for _, low in points.strokes)
    return replace(data, stroke=ends.stroke, forward_share=forward, drawn_height=drawn, dead_centres=ends, bottoms=bottoms)


def _as_far_as_it_turns(press: Linkage, data: MainData) -> MainData:
    """The main data with the way of the slide and the crank angles between which the linkage locks, where it does."""
    try:
        branch = press.branch_through_change_points
    except PinpressError:
        return data
    if branch.period is not None or not all(branch.locks):
        return data
    low, high = float(branch.angles[0]), float(branch.angles[-1])
    way = motion_through_change_points(press, np.linspace(low, high, POINTS), 0.0).slide_position
    return replace(data, stroke=float(np.ptp(way)), turns_between=(low, high))


def sense_of_rotation(press: Linkage, speed: float = 1.0, driver: int = 0) -> str:
    """How a driver turns, seen with x to the right and z up: "counter-clockwise", "clockwise", or the axis that it turns about; of one
    that slides the direction in which it does in the drawn pose.

    Args:
        press: the press.
        speed: its sign is that of the driver's speed.
        driver: which one, in the order of ``press.drivers``.
    """
    joint = press.driver_indices[driver]
    axis = drawn_placements(press.model)[joint + 1].rotation @ press.axes[joint].direction
    if not press.driver_coordinates[driver].turns:
        return f"along ({_direction_in_words(axis, speed)})"
    across = -float(axis[1]) * (1.0 if speed > 0 else -1.0)  # towards the reader
    if abs(across) > ALONG:
        return "counter-clockwise" if across > 0 else "clockwise"
    return f"about the axis ({_direction_in_words(axis, speed)})"


def _in_words(rotation: str) -> str:
    """What `sense_of_rotation` found, after "a positive speed"."""
    if rotation.startswith("along"):
        return f"slides it {rotation}"
    return f"turns it {rotation}" + ("" if rotation.startswith("about") else ", seen with x to the right and z up")


def _direction_in_words(axis: Array, speed: float) -> str:
    return ", ".join(f"{part:.3g}" for part in np.round(axis, 6) * (1.0 if speed > 0 else -1.0) + 0.0)


def forward_share(press: Linkage, speed: float = 1.0) -> float:
    """Share of the time in which the slide goes from top to bottom dead centre, in one stroke or several, at a constant speed of this sign
    [-]. Raises as `dead_centres`."""
    points = turning_points(press)
    period = 2 * np.pi * points.turns
    forward = float(sum((points.places[low] - points.places[high]) % period for high, low in points.strokes) / period)
    return forward if speed > 0 else 1.0 - forward


def directions(press: Linkage) -> tuple[str, str]:
    """Words for the slide's ways to bottom and to top dead centre: "down" and "up" where it moves so."""
    return ("down", "up") if press.slide_direction @ press.up > UPRIGHT else ("to bottom dead centre", "to top dead centre")


def tool_in_words(press: Linkage) -> str:
    """Where process forces act on the slide, as "at x = 0.0 mm, the middle of SL and SR": coordinates that the guide lets change are
    left out, or those of the drawn pose where the guide is along no world axis."""
    tool, along = press.tool, press.slide_direction
    place = press.model.jointPlacements[press.slide_guide.joint + 1].act(tool.in_body)
    upright = np.abs(along) > ALONG
    kept = [axis for axis in range(3) if not upright[axis] and (axis != 1 or abs(place[1]) > ALIKE * press.size)]
    words = ", ".join(f"{'xyz'[axis]} = {1e3 * place[axis] + 0.0:.1f} mm" for axis in kept)
    return f"at {words}{'' if upright.any() else ' as drawn'}, {tool.name}"


def main_lines(data: MainData, drivers: Sequence[str]) -> list[str]:
    """The main data in words, a line each."""
    mass = tables.scale("kg", [data.moving_mass])
    slide = "" if data.slide_mass is None else f", slide {mass.shown(data.slide_mass)} {mass.unit}"
    return [
        *_stroke_lines(data, drivers[0] if drivers else ""),
        *([] if data.tool is None else [f"  process force acts {data.tool}"]),
        *(
            tables.entry("driver", driver, "", f"a positive speed {_in_words(rotation)}")
            for driver, rotation in zip(drivers, data.rotation, strict=True)
        ),
        tables.entry("largest extent", f"{1e3 * data.size:.1f}", "mm", "of the bearings as drawn"),
        tables.entry("moving mass", mass.shown(data.moving_mass), mass.unit, f"all links but the frame{slide}"),
    ]


def _strokes(data: MainData, driver: str) -> list[str]:
    """A line with the number of strokes, where a turn, or a way there and back, has another number of them than one."""
    ends, coordinate = data.dead_centres, data.coordinate
    if ends is None or ends.strokes_per_turn == 1:
        return []
    alike = ", all alike" if ends.strokes == 1 and ends.strokes_per_turn > 1 else ""
    if len(data.bottoms) > 1:
        shown = ", ".join(
            f"{coordinate.shown(place, '.2f')} ({1e3 * height + 0.0:.3f} mm)"
            for place, height in data.bottoms[:6]  # more do not fit in a line
        )
        alike = f", with bottom dead centres at {shown}"
    if not coordinate.turns:
        return [tables.entry("strokes", f"{ends.strokes}", "", f"of the slide, as {driver} goes there and back{alike}")]
    return [tables.entry("strokes a turn", f"{ends.strokes_per_turn:.6g}", "", f"of {driver}{alike}")]


def _stroke_lines(data: MainData, driver: str) -> list[str]:
    if data.dead_centres is not None and data.drawn_height is not None:
        ends, forward, unit, scale = data.dead_centres, data.forward_share, data.coordinate.shown_unit, data.coordinate.scale
        ways = () if forward is None else (("from top to bottom", forward), ("from bottom to top", 1.0 - forward))
        return [
            tables.entry("stroke", f"{1e3 * ends.stroke:.3f}", "mm"),
            *_strokes(data, driver),
            tables.entry("top dead centre", f"{scale * ends.top_angle:.3f}", unit, f"of {driver}, which is at 0 {unit} as drawn"),
            tables.entry("bottom dead centre", f"{scale * ends.bottom_angle:.3f}", unit),
            tables.entry("slide as drawn", f"{1e3 * data.drawn_height + 0.0:.3f}", "mm", "above bottom dead centre"),
            *(
                tables.entry(way, f"{100 * part:.3f}", "%", f"of the time, {360 * ends.turns * part:.2f} deg of {driver}")
                for way, part in ways
            ),
        ]
    if data.stroke is not None and data.turns_between is not None:
        low, high = (data.coordinate.shown(end, ".3f") for end in data.turns_between)
        between = f"while {driver} moves from {low} to {high}, where the linkage locks"
        return [tables.entry("way of the slide", f"{1e3 * data.stroke:.3f}", "mm", between)]
    return [] if data.no_stroke is None else [tables.entry("stroke", "none", "", data.no_stroke)]
