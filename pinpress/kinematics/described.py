"""What a motion shows: height, velocity and acceleration of the slide, and speeds of drivers that are not constant.

All functions raise `PinpressError` for values that are not finite.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ..common.arguments import expect
from ..common.errors import PinpressError
from ..common.frozen import read_only
from ..common.outlets.described import Along, Chart, Curve, Figure, Map, Section
from ..common.quantities import Array, DriverCoordinate
from ..linkage.linkage import Linkage
from .frames.workspace import ReachMap
from .motion import ROUNDING, Motion, finite, is_constant, is_cycle
from .planar.poles import PolePath, VectorPolygons
from .slide_path import DeadCentres, dead_centres
from .traces import PointTrace

FAR = 4.0  # times the median distance of a pole from its middle up to which its path is drawn: it goes to infinity


def described(motion: Motion) -> tuple[Section, ...]:
    """The sections of a motion alone, which does not know its press: positions of the slide are not counted from bottom dead centre."""
    along = along_motion(motion)
    parts = {"Slide": slide_charts(motion, along), "Drive": driver_speeds(motion, along)}
    return tuple(Section(title, blocks=charts) for title, charts in parts.items() if charts)


def along_motion(motion: Motion, press: Linkage | None = None) -> Along:
    """What the charts of a motion run along.

    A motion of at most one period at constant speed is drawn over the unwrapped crank angle, other motions over time. States that are not
    in time are drawn over the crank angle if it only rises or only falls, else over their numbers, from 0.

    Args:
        motion: the motion.
        press: its press, whose dead centres are marked; None for no marks.

    Raises:
        PinpressError: a value is not finite.
    """
    expect("motion", motion, Motion, "cycle or simulate")
    angle, speed = finite("crank angle", motion.crank_angle), finite("crank speed", motion.crank_speed)
    one_way = angle.ndim == 1 and _one_way(angle)
    turn = 2 * np.pi * (motion.period_turns or 1)
    if one_way and np.ptp(angle) <= turn * (1 + ROUNDING) and is_constant(speed):
        return over_angle(motion, press)
    try:
        return Along("time", "s", read_only(finite("time", motion.time)), motion)
    except PinpressError:
        if motion._time is not None:
            raise
    return over_angle(motion, press) if one_way else Along("state", "-", read_only(np.arange(len(angle), dtype=float)), motion)


def over_angle(motion: Motion, press: Linkage | None = None) -> Along:
    """Along the coordinate of the first driver; a period of a crank has marks at the dead centres, and its working stroke is shaded."""
    first, angle = motion.driver_coordinates[0], motion.crank_angle
    marks, shaded, period = dict[str, float](), None, None
    if is_cycle(motion):
        period = math.copysign(2 * np.pi * (motion.period_turns or 1), angle[-1] - angle[0])
        ends = None if press is None else known_dead_centres(press)
        if ends is not None and ends.strokes == 1 and first.turns:
            low = min(angle[0], angle[0] + period)
            bottom, top = (low + (place - low) % abs(period) for place in (ends.bottom_angle, ends.top_angle))
            marks = {"TDC": top, "BDC": bottom}
            shaded = (top, bottom) if period > 0 and top < bottom else (bottom, top) if period < 0 and bottom < top else None
    return Along(first.counted, first.unit, read_only(np.array(angle)), motion, marks, shaded, period)


def known_dead_centres(press: Linkage) -> DeadCentres | None:
    """The dead centres of a press; None if it has none, or several drivers."""
    try:
        return dead_centres(press) if press.slide is not None and len(press.drivers) == 1 else None
    except PinpressError:
        return None


def _one_way(angle: Array) -> bool:
    steps = np.diff(angle)
    return bool(np.all(steps > 0) or np.all(steps < 0))


def slide_charts(motion: Motion, along: Along, bottom: float = -math.inf) -> list[Chart]:
    """Charts of position, velocity and acceleration of the slide along its guide's axis; none for a linkage without a slide. With the
    position at bottom dead centre [m] the height above it stands in place of the position."""
    if motion._guide is None:
        return []
    if math.isfinite(bottom):
        first = chart("height", "Slide height above bottom dead centre", "m", along, {"height": motion.slide_position - bottom})
    else:
        first = chart("position", "Slide position", "m", along, {"position": motion.slide_position})
    series = (("velocity", "m/s", motion.slide_velocity), ("acceleration", "m/s2", motion.slide_acceleration))
    return [first, *(chart(name, f"Slide {name}", unit, along, {name: values}) for name, unit, values in series)]


def driver_speeds(motion: Motion, along: Along) -> list[Chart]:
    """Charts of the speeds of the drivers that turn and of those that slide, a curve a driver, if one of them is not constant."""
    found = []
    for kind in kinds_of_drivers(motion):
        curves = by_driver(f"{kind.part} speed", motion, motion.crank_speed, kind)
        if not all(is_constant(finite("crank speed", values)) for values in curves.values()):
            name = "speed" if kind.turns else "driver_speed"
            found.append(chart(name, f"{kind.part.capitalize()} speed", f"{kind.unit}/s", along, curves))
    return found


def kinds_of_drivers(motion: Motion) -> list[DriverCoordinate]:
    """The kinds of drivers that there are, that of the first one first."""
    return list(dict.fromkeys(motion.driver_coordinates))


def by_driver(name: str, motion: Motion, values: Array, kind: DriverCoordinate) -> dict[str, Array]:
    """A curve (n,) by its name; for several drivers (n, drivers) curves by the names of those of one kind."""
    if values.ndim == 1:
        return {name: values}
    return {driver: values[:, i] for i, driver in enumerate(motion.drivers) if motion.driver_coordinates[i] == kind}


def chart(name: str, title: str, unit: str, along: Along, series: Mapping[str, Array], reference: float = 0.0) -> Chart:
    """A chart of curves (n,) by their names; raises PinpressError if a value is not finite."""
    for curve, values in series.items():
        finite(title if len(series) == 1 else f"{title}, {curve},", values)
    return Chart(
        name, title, unit, along, [Curve(curve, read_only(np.array(values))) for curve, values in series.items()], reference=reference
    )


def workspace(found: ReachMap) -> tuple[Section, ...]:
    """Maps of both margins over the drivers, and the places of the frame, with the singular poses on them."""
    first, second = (
        Along(name, each.unit, values) for name, each, values in zip(found.drivers, found.driver_coordinates, found.positions, strict=True)
    )
    marks = [Curve(name, at[:, 1], at[:, 0], look="points") for name, at in (("locks", found.locks), ("dead points", found.dead_points))]
    marks = [curve for curve in marks if len(curve.y)]
    maps = [
        Map(f"map {name}", title, "-", first, second, values.T, curves=marks)
        for name, title, values in (
            ("loops", "How far the loops are from locking", found.loop_margin),
            ("frame", f"How far {found.frame} is from a dead point", found.frame_margin),
        )
    ]
    places = found.place[found.reached]
    wide, high = sorted(np.argsort(np.ptp(places, axis=0))[1:].tolist())
    inside = found.within_limits[found.reached]
    curves = [
        Curve(name, places[some, high], places[some, wide], look="points")
        for name, some in (("within the limits of the joints", inside), ("beyond them", ~inside))
        if some.any()
    ]
    title = f"Places of {found.frame}, {'xyz'[high]} over {'xyz'[wide]}"
    chart = Chart("places", title, "m", Along("xyz"[wide], "m"), curves, square=True)
    figures = [
        Figure("nodes reached", float(found.reached.mean()), "share"),
        Figure("least margin of the loops", float(np.nanmin(found.loop_margin))),
        Figure(f"least margin of {found.frame}", float(np.nanmin(found.frame_margin))),
    ]
    return (Section(f"Workspace of {found.frame}", figures, [*maps, chart]),)


def point_trace(found: PointTrace) -> tuple[Section, ...]:
    """The path of a point in the plane of its two widest axes, its speed, acceleration and curvature."""
    along, position = along_motion(found.motion), finite("position", found.position)
    wide, high = sorted(np.argsort(np.ptp(position, axis=0))[1:].tolist())
    closed = [*range(len(position)), *([0] if is_cycle(found.motion) else [])]
    curve = Curve("path", read_only(position[closed, high]), read_only(position[closed, wide]))
    sizes = {"velocity": ("m/s", found.velocity), "acceleration": ("m/s2", found.acceleration)}
    charts = [
        Chart("path", f"Path, {'xyz'[high]} over {'xyz'[wide]}", "m", Along("xyz"[wide], "m"), [curve], square=True),
        *(chart(name, f"Size of the {name}", unit, along, {name: np.linalg.norm(each, axis=1)}) for name, (unit, each) in sizes.items()),
    ]
    curvature = found.curvature
    figures = [Figure("largest speed", float(found.speed.max()), "m/s")]
    if np.isfinite(curvature).all():  # nowhere at rest
        charts.append(chart("curvature", "Curvature of the path", "1/m", along, {"curvature": curvature}))
        if curvature.any():
            figures.append(Figure("least radius of curvature", float(1.0 / curvature.max()), "m"))
    if is_cycle(found.motion):
        figures += [Figure("length of the path", found.length, "m"), Figure("area inside the path", found.area, "m2")]
    return (Section(f"Point {found.name}", figures, charts),)


def pole_path(found: PolePath) -> tuple[Section, ...]:
    """The path of a pole where it is not far away, and the relative angular velocity."""
    along, position = along_motion(found.motion), found.position
    wide = _plane_of(found.angular_velocity)
    axis = 3 - sum(wide)
    charts = []
    if np.isfinite(position).any():
        away = np.linalg.norm(position - np.nanmedian(position, axis=0), axis=1)
        near = away <= FAR * np.nanmedian(away)
        order = np.roll(np.arange(len(near)), -int(near.argmin()) if is_cycle(found.motion) else 0)  # a period begins where the pole is far
        branches = np.split(order, np.flatnonzero(np.diff(near[order])) + 1)
        curves = [
            Curve(f"branch {k}", *_line(position[branch][:, wide])) for k, branch in enumerate((b for b in branches if near[b[0]]), 1)
        ]
        title, note = (
            f"Path of the pole, {'xyz'[wide[1]]} over {'xyz'[wide[0]]}",
            "" if near.all() else "parts that are far away are left out",
        )
        charts.append(Chart("path", title, "m", Along("xyz"[wide[0]], "m"), curves, square=True, note=note))
    title = f"Relative angular velocity about {'xyz'[axis]}"
    charts.append(chart("angular velocity", title, "rad/s", along, {"angular velocity": found.angular_velocity[:, axis]}))
    return (Section(f"Pole of {found.link} relative to {found.to}", blocks=charts),)


def vector_polygons(found: VectorPolygons) -> tuple[Section, ...]:
    """Both polygons: vectors of the pins from the pole of the polygon, and the figures that the pins of each link form there."""
    wide = ["xyz".index(axis) for axis in found.axes]

    def polygon(name: str, unit: str, vectors: Mapping[str, Array]) -> Chart:
        tips = {point: finite(name, vector)[wide] for point, vector in vectors.items()}
        rays = [Curve(point, *_line([np.zeros(2), tip]), look="marked") for point, tip in tips.items() if tip.any()]
        round_trips = {link: [*points, points[0]] for link, points in found.links.items()}
        figures = [Curve(link, *_line([tips[point] for point in points]), look="guide") for link, points in round_trips.items()]
        title = f"{name.capitalize()} polygon, {found.axes[1]} over {found.axes[0]}"
        return Chart(name, title, unit, Along(found.axes[0], unit), [*figures, *rays], square=True)

    charts = [polygon("velocity", "m/s", found.velocity), polygon("acceleration", "m/s2", found.acceleration)]
    angle = float(np.ravel(found.motion.crank_angle[found.state])[0])
    return (Section(f"Polygons at {found.motion.driver_coordinates[0].shown(angle, '.2f')}", blocks=charts),)


def _line(points: Sequence[Array] | Array) -> tuple[Array, Array]:
    """Values up and across (n,) of a line through points."""
    across, up = np.array(points).T
    return read_only(up), read_only(across)


def _plane_of(spin: Array) -> list[int]:
    """The two world axes of the drawing of a planar linkage, from angular velocities (n, 3)."""
    about = int(np.abs(spin).sum(axis=0).argmax()) if spin.any() else 1
    return [axis for axis in range(3) if axis != about]


SECTIONS = {
    Motion: lambda motion, page: described(motion),
    ReachMap: lambda found, page: workspace(found),
    PointTrace: lambda found, page: point_trace(found),
    PolePath: lambda found, page: pole_path(found),
    VectorPolygons: lambda found, page: vector_polygons(found),
}
"""How results of this room are described."""
