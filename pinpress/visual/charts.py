"""The contents of charts of a motion and its reactions, in the units of the charts, apart from any drawing library.

Signs and axes are those of `Reactions`. Values that are rounding beside the largest bearing force of the motion (for moments, beside that
force times the linkage's size) are zero here. All functions raise `PinpressError` for values that are not finite.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..common.arguments import expect
from ..common.errors import PinpressError, UnknownNameError
from ..common.frozen import read_only
from ..common.quantities import RPM, Array, DriverCoordinate
from ..dynamics.applied_loads import turning_points
from ..dynamics.extremes import AXES, ROUNDING, finite, finite_forces, held_moments, is_constant, rounding, torque_without_rounding
from ..dynamics.reactions import Reactions
from ..kinematics.motion import Motion
from ..kinematics.poses import loaded_bodies, poses
from ..linkage.linkage import Linkage
from ..linkage.planarity import UPRIGHT
from ..simulation.run import Run

BEYOND = 1.25  # height shown over the process, divided by the largest at which there is a force
UNITS = {  # quantity -> (limit of the largest value in SI units, unit, number of it in an SI unit), ...
    "position": ((1e-4, "µm", 1e6), (10.0, "mm", 1e3), (math.inf, "m", 1.0)),
    "velocity": ((1e-2, "mm/s", 1e3), (math.inf, "m/s", 1.0)),
    "acceleration": ((1e-2, "mm/s²", 1e3), (math.inf, "m/s²", 1.0)),
    "speed": ((math.inf, "r/min", 1 / RPM),),
    "force": ((1e3, "N", 1.0), (1e7, "kN", 1e-3), (math.inf, "MN", 1e-6)),
    "torque": ((1e3, "N m", 1.0), (1e7, "kN m", 1e-3), (math.inf, "MN m", 1e-6)),
    "moment": ((1e3, "N m", 1.0), (1e7, "kN m", 1e-3), (math.inf, "MN m", 1e-6)),
}


@dataclass(frozen=True, eq=False)
class ChartCurve:
    """One line of a chart.

    Attributes:
        name: name of the line.
        values: (n,) values in the chart's unit.
    """

    name: str
    values: Array


@dataclass(frozen=True, eq=False)
class Chart:
    """Curves of one quantity, in one unit.

    Attributes:
        title: title of the chart.
        quantity: one of `UNITS`.
        unit: unit of all curves.
        curves: one or more curves.
    """

    title: str
    quantity: str
    unit: str
    curves: tuple[ChartCurve, ...]


@dataclass(frozen=True, eq=False)
class Abscissa:
    """The quantity over which states are drawn.

    Attributes:
        quantity: "crank angle", "crank angle from top dead centre" (or from elsewhere), "driver position", "time" or "state".
        unit: "deg", "mm", "s" or, for numbers of states, empty.
        values: (n,) values in that unit.
    """

    quantity: str
    unit: str
    values: Array


@dataclass(frozen=True, eq=False)
class Locus:
    """Polar diagram of a bearing's force: the path of its vector's tip.

    Attributes:
        bearing: name of the bearing.
        link: link on which the force acts, the bearing's child or link2.
        axes: names of the two axes, such as ("x", "z"), see `locus`.
        unit: unit of the components.
        frame: (n, 2) components in world axes.
        own: (n, 2) components in axes that are fixed to the link and coincide with the world's in the drawn pose.
    """

    bearing: str
    link: str
    axes: tuple[str, str]
    unit: str
    frame: Array
    own: Array


@dataclass(frozen=True, eq=False)
class ForceOverHeight:
    """Force of the process over the slide's height.

    Attributes:
        unit: of the force.
        height: (n,) above bottom dead centre, or above the lowest state where there is none [mm].
        force: (n,) on the slide, positive where it resists the working stroke, in that unit.
        reach: largest height to be shown [mm].
        above_bottom: whether heights are above bottom dead centre.
    """

    unit: str
    height: Array
    force: Array
    reach: float
    above_bottom: bool


def abscissa(motion: Motion) -> Abscissa:
    """Choose the quantity over which a motion is drawn.

    A motion of at most one period at constant speed is drawn over the unwrapped crank angle [deg], other motions over time [s]. States that
    are not in time are drawn over the crank angle where it only rises or only falls, else over their numbers, from 0.

    Raises:
        PinpressError: a value is not finite.
    """
    expect("motion", motion, Motion, "cycle or simulate")
    angle, speed = finite("crank angle", motion.crank_angle), finite("crank speed", motion.crank_speed)
    first = motion.driver_coordinates[0]
    one_way = angle.ndim == 1 and _one_way(angle)
    if one_way and np.ptp(angle) <= 2 * np.pi * (motion.period_turns or 1) * (1 + ROUNDING) and is_constant(speed):
        return Abscissa(first.counted, first.shown_unit, read_only(first.scale * angle))
    try:
        return Abscissa("time", "s", read_only(finite("time", motion.time)))
    except PinpressError:
        if motion._time is not None:
            raise
    if one_way:
        return Abscissa(first.counted, first.shown_unit, read_only(first.scale * angle))
    return Abscissa("state", "", read_only(np.arange(len(angle), dtype=float)))


def slide(motion: Motion, bottom: float | None = None) -> tuple[Chart, ...]:
    """Charts of position, velocity and acceleration of the slide along its guide's axis; none for a linkage without a slide.

    Args:
        motion: motion of the linkage.
        bottom: slide position at bottom dead centre [m]; with it the height above it is drawn in place of the position.
    """
    expect("motion", motion, Motion, "cycle or simulate")
    if motion._guide is None:
        return ()
    position = _chart("Slide position", "position", {"position": motion.slide_position})
    if bottom is not None:
        position = _chart("Slide height above bottom dead centre", "position", {"height": motion.slide_position - bottom})
    series = (("velocity", motion.slide_velocity), ("acceleration", motion.slide_acceleration))
    return position, *(_chart(f"Slide {quantity}", quantity, {quantity: values}) for quantity, values in series)


def driver_speeds(motion: Motion) -> tuple[Chart, ...]:
    """Charts of the speeds of the drivers that turn and of those that slide, a curve a driver, where one of them is not constant."""
    found = []
    for kind in _kinds(motion):
        curves = _by_driver(f"{kind.part} speed", motion, motion.crank_speed, kind)
        if not all(is_constant(finite("crank speed", values)) for values in curves.values()):
            found.append(_chart(f"{kind.part.capitalize()} speed", "speed" if kind.turns else "velocity", curves))
    return tuple(found)


def driving(reactions: Reactions) -> tuple[Chart, ...]:
    """Charts of the driving torques of the drivers that turn, and of the driving forces of those that slide, a curve a driver; for a `Run`
    also of the torques and forces of its drives, which turn the flywheels too."""
    motion, found = _motion_of(reactions), []
    for kind in _kinds(motion):
        curves = _by_driver(f"driving {kind.effort}", motion, torque_without_rounding(reactions), kind)
        if isinstance(motion, Run):
            drives = _by_driver("drive", motion, motion.drive_torque, kind)
            curves |= {name if name == "drive" else f"drive of {name}": values for name, values in drives.items()}
        found.append(_chart(f"Driving {kind.effort}", kind.effort, curves))
    return tuple(found)


def _motion_of(reactions: Reactions) -> Motion:
    """The motion of reactions."""
    expect("reactions", reactions, Reactions, "inverse_dynamics")
    return reactions.motion


def bearing(reactions: Reactions) -> Chart:
    """Chart of the magnitude of the force in every bearing and guide."""
    least = rounding(reactions).force
    return _chart(
        "Bearing forces", "force", {name: np.linalg.norm(_clean(f, least), axis=1) for name, f in finite_forces(reactions).items()}
    )


def components(reactions: Reactions, name: str) -> Chart:
    """Chart of the world components of the force in a bearing or guide; those that are zero throughout are left out, unless all are.

    Raises:
        UnknownNameError: there is no such bearing.
    """
    return _components(f"Force in {name}", "force", f"force in {name}", reactions.bearing_force[name], rounding(reactions).force)


def bearing_moment(reactions: Reactions) -> Chart | None:
    """Chart of the magnitudes of the moments that bearings and guides hold, see `held_moments`; None where none does."""
    least = rounding(reactions).moment
    sizes = {name: np.linalg.norm(_clean(moment, least), axis=1) for name, moment in held_moments(reactions).items()}
    holding = {name: size for name, size in sizes.items() if size.any()}
    return _chart("Moments in bearings and guides", "moment", holding) if holding else None


def shaking(reactions: Reactions) -> Chart:
    """Chart of the world components of the shaking force; those that are zero throughout are left out, unless all are."""
    return _components("Shaking force", "force", "shaking force", reactions.shaking_force, rounding(reactions).force)


def shaking_moment(reactions: Reactions) -> Chart:
    """Chart of the world components of the shaking moment about the world origin, without those that are zero, unless all are."""
    return _components("Shaking moment", "moment", "shaking moment", reactions.shaking_moment, rounding(reactions).moment)


def process(reactions: Reactions) -> Chart | None:
    """Force of the process loads on the slide; None where there is none."""
    force = reactions.process_force
    return _chart("Process force", "force", {"process force": finite("process force", force)}) if force.any() else None


def force_over_height(reactions: Reactions) -> ForceOverHeight | None:
    """Force of the process loads over the slide's height; None where there is none."""
    if (chart := process(reactions)) is None:
        return None
    position, bottom = reactions.motion.slide_position, turning_points(reactions._press)[0]
    height = 1e3 * (position - (bottom if math.isfinite(bottom) else position.min()))
    force = chart.curves[0].values
    reach = min(BEYOND * float(height[force != 0].max()), float(height.max()))
    return ForceOverHeight(chart.unit, read_only(height), force, reach, math.isfinite(bottom))


def locus(reactions: Reactions, name: str) -> Locus:
    """Polar diagram of a bearing's force; arguments and errors as of `loci`."""
    return loci(reactions, [name])[0]


def loci(reactions: Reactions, names: Sequence[str]) -> list[Locus]:
    """Polar diagrams of the forces of bearings.

    The diagram of a planar press lies in its plane: along the plane's two world axes, or, where the plane is tilted, along its horizontal
    ("h") and the direction up it ("u"). In space it is the projection on the two world axes along which the force ranges most.

    Args:
        reactions: reactions that have these bearings.
        names: names of the bearings.

    Raises:
        UnknownNameError: there is no such bearing.
    """
    motion, press = _motion_of(reactions), reactions._press
    for name in names:
        if not isinstance(name, str) or name not in press.bearings:
            raise UnknownNameError("bearing", name, press.bearings)
    turned = poses(press, motion.joint_position).rotation @ poses(press, np.zeros((1, press.model.nv))).rotation.swapaxes(2, 3)
    return [_locus(reactions, name, turned) for name in names]


def _locus(reactions: Reactions, name: str, turned: Array) -> Locus:
    """`locus` of a bearing where the bodies are turned by these rotations (joints + 1, n, 3, 3) from the drawn pose."""
    press, least = reactions._press, rounding(reactions).force
    force = _clean(finite(f"force in {name}", reactions.bearing_force[name]), least)
    body = loaded_bodies(press)[press.bearings.index(name)]
    own = np.einsum("nji,nj->ni", turned[body], force)
    axes, directions = _directions(press, force, least)
    unit, factor = _unit("force", float(np.abs(force).max(initial=0.0)))
    frame, own = factor * force @ directions.T, factor * own @ directions.T
    return Locus(name, press.link_of(body), axes, unit, read_only(frame), read_only(own))


def _directions(press: Linkage, force: Array, least: float) -> tuple[tuple[str, str], Array]:
    """Names and world directions (2, 3) of a polar diagram's axes; forces (n, 3) below ``least`` are rounding."""
    normals = press.engine().turning_axes()  # a planar press has one
    if len(normals) == 1 and np.abs(normals).max() < 1 - UPRIGHT:
        return ("h", "u"), press.planarity.axes[[0, 2]]
    across = _least_moved(force, least) if len(normals) > 1 else int(np.abs(normals[0]).argmax())
    first, second = (axis for axis in range(3) if axis != across)
    return (AXES[first], AXES[second]), np.eye(3)[[first, second]]


def _least_moved(force: Array, least: float) -> int:
    """The axis along which a force (n, 3) ranges least; where several are alike but for rounding, the one with the smaller force."""
    left = [1, 0, 2]  # y first, as most presses stand in the x-z plane
    for sizes in (np.ptp(force, axis=0), np.abs(force).max(axis=0)):
        left = [axis for axis in left if sizes[axis] <= min(sizes[left]) + least]
    return left[0]


def factor(quantity: str, unit: str) -> float:
    """Number of a chart's unit in an SI unit of the quantity."""
    return next(factor for _, known, factor in UNITS[quantity] if known == unit)


def _components(title: str, quantity: str, name: str, vector: Array, least: float) -> Chart:
    clean = _clean(finite(name, vector), least)
    shown = [i for i in range(3) if clean[:, i].any()] or range(3)
    return _chart(title, quantity, {AXES[i]: clean[:, i] for i in shown})


def _clean(vector: Array, least: float) -> Array:
    """The vector (n, 3), with zeros for components that nowhere exceed rounding."""
    return np.where(np.abs(vector).max(axis=0) > least, vector, 0.0)


def _kinds(motion: Motion) -> list[DriverCoordinate]:
    """The kinds of drivers that there are, that of the first one first."""
    return list(dict.fromkeys(motion.driver_coordinates))


def _by_driver(name: str, motion: Motion, values: Array, kind: DriverCoordinate) -> dict[str, Array]:
    """A curve (n,) by its name; for several drivers (n, drivers) curves by the names of those of one kind."""
    if values.ndim == 1:
        return {name: values}
    return {driver: values[:, i] for i, driver in enumerate(motion.drivers) if motion.driver_coordinates[i] == kind}


def _chart(title: str, quantity: str, series: Mapping[str, Array]) -> Chart:
    for name, values in series.items():
        finite(title if len(series) == 1 else f"{title}, {name},", values)
    unit, factor = _unit(quantity, max(float(np.abs(values).max()) for values in series.values()))
    return Chart(title, quantity, unit, tuple(ChartCurve(name, read_only(factor * values)) for name, values in series.items()))


def _unit(quantity: str, largest: float) -> tuple[str, float]:
    return next((unit, factor) for limit, unit, factor in UNITS[quantity] if largest < limit)


def _one_way(angle: Array) -> bool:
    steps = np.diff(angle)
    return bool(np.all(steps > 0) or np.all(steps < 0))
