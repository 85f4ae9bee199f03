"""The scatter of a press's dead centres with its dimensions: gradients, shares, worst cases, and every press of a sample.

At a dead centre the slide's speed is zero. So, to first order, the height of the dead centre changes with a dimension as it does at a fixed
crank angle. At a height h above bottom dead centre the crank angle changes too. Torque and speed are proportional to the slide's travel per
crank angle, z', whose derivative is dz'/dx - z''/z' (dz/dx - dz_b/dx).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..common import plausibility, tables
from ..common.arguments import number, typed
from ..common.errors import PinpressError, caution
from ..common.numerics import bracketed_roots
from ..common.quantities import GRAVITY, Array
from ..common.results import Tabular
from ..common.tables import Column
from ..derivatives.motion import directed
from ..kinematics.cycle import doubt_speeds, motion_through_change_points
from ..kinematics.main_data import sense_of_rotation
from ..kinematics.motion import Motion, refuse_motion_of_another
from ..kinematics.slide_path import TurningPoints, turning_points
from ..linkage.linkage import Linkage, OfPress
from .dimensions import Dimension, check_dimensions, correlation_matrix, draw_deviations
from .scatter import Scatter, scatter
from .sets_of_lengths.endings import Ending, shapes_of, sound
from .sets_of_lengths.flat_dead_centres import TurningPoint, outermost_positions
from .sets_of_lengths.shapes import Shapes


@dataclass(frozen=True, eq=False, repr=False)
class DeadCentreScatter(OfPress, Tabular):
    """The dead centres of n presses that are built from the same drawing. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        parts: the k dimensions that scatter.
        height: scatter of the slide's height at bottom dead centre [m].
        top: scatter of the slide's height at top dead centre [m].
        stroke: scatter of the distance between the dead centres [m].
        torques: height above the press's own bottom dead centre -> scatter of the crank torque for the force there, on the way down [N m].
        speeds: height above the press's own bottom dead centre -> scatter of the slide's speed there, on the way down [m/s].
        deviations: (k, n) deviations of the dimensions of every press from the nominal dimensions [m or rad].
        backwards: whether the torques belong to a crank that turns in the negative direction.
    """

    _press: Linkage
    parts: tuple[Dimension, ...]
    height: Scatter
    top: Scatter
    stroke: Scatter
    torques: Mapping[float, Scatter]
    speeds: Mapping[float, Scatter]
    deviations: Array
    backwards: bool = False

    @property
    def way_down(self) -> str:
        """The sense of rotation to which the torques at heights belong, as text; empty without torques."""
        if not self.torques:
            return ""
        speed, opposite = ("negative", "positive") if self.backwards else ("positive", "negative")
        sense = sense_of_rotation(self._press, -1.0 if self.backwards else 1.0)
        return (
            f"torques are those on the slide's way down at a {speed} speed of {self._press.driver} ({sense}); those of the other sense of"
            f" rotation go with {opposite} speeds"
        )

    @property
    def gradient(self) -> Array:
        """(k,) derivatives of the height at bottom dead centre [m per m, of an angle m/rad]."""
        return self.height.gradient

    @property
    def share(self) -> Array:
        """(k,) shares of the dimensions in the variance of this height [-]."""
        return self.height.share

    @property
    def worst_case(self) -> float:
        """Worst case of the height at bottom dead centre, to first order [m]."""
        return self.height.worst_case

    def within(self, limit: float, upper: float | None = None) -> float:
        """Share of the presses whose bottom dead centre is within a limit [m], see `Scatter.within`."""
        return self.height.within(limit, upper)

    @property
    def quantities(self) -> tuple[Scatter, ...]:
        """All quantities of the result, bottom dead centre first."""
        return (self.height, self.top, self.stroke, *self.torques.values(), *self.speeds.values())

    @property
    def title(self) -> str:
        return (
            f"DeadCentreScatter of {self.press_name}: {len(self.parts)} dimensions, {self.deviations.shape[1]} presses, bottom dead"
            f" centre at {tables.cell(self.height.nominal)} {self.height.unit}"
        )

    def columns(self) -> dict[str, Column]:
        """The dimensions with tolerance, gradients and shares as (k,) columns."""
        columns: dict[str, Column] = {
            "dimension": [part.name for part in self.parts],
            "tolerance": np.array([part.tolerance for part in self.parts]),
            "tolerance_unit": [part.unit for part in self.parts],
        }
        for quantity in self.quantities:
            head = quantity.quantity.replace(" ", "_")
            columns |= {f"{head}_gradient [{quantity.unit} per unit]": quantity.gradient, f"{head}_share": quantity.share}
        return columns


@typed
def bottom_dead_centre(
    press: Linkage,
    parts: Sequence[Dimension],
    *,
    forces: Mapping[float, float] | None = None,
    speeds: Mapping[float, float] | None = None,
    motion: Motion | None = None,
    correlation: Mapping[tuple[str, str], float] | None = None,
    samples: int = 100_000,
    seed: int = 0,
) -> DeadCentreScatter:
    """Compute the scatter of a press's bottom dead centre, top dead centre and stroke with the tolerances of its dimensions.

    Every press of a sample is closed with its own lengths and followed to its own dead centres, the same that `dead_centres` of the
    `reshaped` linkage finds. Gradients and shares are of first order.

    For drivers that follow a motion, as in servo presses, give ``motion``. Its lowest and highest state replace the dead centres. In every
    press the drivers then have the positions of these states. A press with several drivers needs a motion.

    Args:
        press: a press with nominal dimensions, in a plane or in space.
        parts: the dimensions that scatter.
        forces: height above bottom dead centre [m] -> force of the process on the slide there, upwards [N], for
            `DeadCentreScatter.torques`, without friction, weights and inertia. The crank turns forwards; if all ``speeds`` are negative it
            turns backwards, and the torques are negative.
        speeds: height above bottom dead centre [m] -> speed of the crank [rad/s], negative backwards, for `DeadCentreScatter.speeds`.
        motion: a motion of this press, as from `servo_cycle`; None: the crank turns through the dead centres.
        correlation: (name, name) -> correlation coefficient of two normal dimensions [-]; all other pairs are independent.
        samples: number of presses in the sample.
        seed: seed of the random numbers; the same seed draws the same presses.

    Raises:
        PinpressError: the press has no slide, several drivers and no motion, or no dead centres; the motion belongs to another press, or is
            combined with forces or speeds; there is no dimension, or one is invalid or given twice; a dimension opens redundant bearings,
            as one alone of a press with several points does; presses of the sample cannot be closed; a height is not within the stroke.
        UnknownNameError: a bearing, link or dimension does not exist.

    Warns:
        PinpressWarning: a tolerance is larger than a tenth of its link, or than 0.1 rad, or a dimension does not move the slide.
    """
    checked = check_dimensions(press, parts)
    tied = correlation_matrix(checked, correlation)
    drawn = draw_deviations(checked, tied, samples, seed)
    if motion is None:
        refuse_several_drivers(press)
        points, shapes = turning_points(press), _shapes(press, checked)
        bottom, top = (_outermost(shapes, points, checked, drawn, upwards) for upwards in (False, True))
    else:
        if forces or speeds:
            raise PinpressError("forces and speeds at a height need a crank that turns through its dead centres: leave out motion")
        shapes = _shapes(press, checked)
        bottom, top = (_at_end(shapes, motion, upwards) for upwards in (False, True))
    slopes = np.abs([slope for end in (bottom.local, top.local) for slope in (end.position_slopes, end.rate_slopes)])
    for part, largest in zip(checked, slopes.max(axis=0), strict=True):
        if largest <= 1e-12 * press.size:
            caution(f"dimension {part.name!r} does not move the slide at a dead centre: leave it out, or give another direction")
    backwards = bool(speeds) and all(number(f"speeds at {height} m", value, "rad/s") < 0.0 for height, value in (speeds or {}).items())
    asked = _quantities_at_heights(press, forces or {}, speeds or {}, backwards)
    travels = [_Travel.on_the_way_down(shapes, bottom, *quantity) for quantity in asked]

    gradients = np.array([bottom.gradient, top.gradient, top.gradient - bottom.gradient, *(travel.gradient for travel in travels)])
    # rounding must not take a dimension that changes nothing to a limit of its tolerance at the worst corners
    noise = 1e-12 * np.abs(gradients).max(axis=1, keepdims=True)
    noise[:3] = noise[:3].max()  # the crank of a knuckle moves top dead centre, and its stretched position not at all
    gradients[np.abs(gradients) <= noise] = 0.0
    tolerances = np.array([part.tolerance for part in checked])
    corners = np.array([sign * np.sign(gradient) * tolerances for gradient in gradients for sign in (-1.0, 1.0)])
    everything = np.concatenate([drawn, corners.T], axis=1)
    low, high = bottom.positions(shapes, everything), top.positions(shapes, everything)
    values = [low, high, high - low, *(travel.values(shapes, everything, low) for travel in travels)]
    lowest, highest = bottom.local.position, top.local.position
    heads = [("bottom dead centre", "m", lowest), ("top dead centre", "m", highest), ("stroke", "m", highest - lowest)]
    heads += [(travel.quantity, travel.unit, travel.nominal) for travel in travels]
    count = drawn.shape[1]
    scatters = [
        scatter(*head, checked, gradient, tied, value[:count], value[count + 2 * k : count + 2 * k + 2])
        for k, (head, gradient, value) in enumerate(zip(heads, gradients, values, strict=True))
    ]
    torques, speeds_down = (
        {travel.height: result for travel, result in zip(travels, scatters[3:], strict=True) if travel.unit == unit}
        for unit in ("N m", "m/s")
    )
    return DeadCentreScatter(press, checked, scatters[0], scatters[1], scatters[2], torques, speeds_down, drawn, backwards)


# ------------------------------------------------------------------------------------------------------------------------- the dead centres


class _Local(NamedTuple):
    """The nominal press at a crank angle: joint coordinates ``start``, the slide's position z, z', z'', and the slopes of z and z' by k
    dimensions at this angle.
    """

    start: Array
    position: float
    rate: float
    second: float
    position_slopes: Array
    rate_slopes: Array

    @staticmethod
    def at(shapes: Shapes, angle: float) -> _Local:
        """The nominal press at a crank angle; raises PinpressError if a dimension opens redundant bearings."""
        return _Local.of(shapes, motion_through_change_points(shapes.press, np.array([angle]), 1.0), 0)

    @staticmethod
    def of(shapes: Shapes, motion: Motion, state: int) -> _Local:
        """The nominal press in a state of a motion, with derivatives by time instead of crank angle. Raises as `at`."""
        by_position, by_rate = shapes.slide_slopes(motion.joint_position[state], motion.v[state])
        of_slide = motion.slide_position, motion.slide_velocity, motion.slide_acceleration
        position, rate, second = (float(values[state]) for values in of_slide)
        return _Local(motion.joint_position[state], position, rate, second, by_position, by_rate)


class _DeadCentre(NamedTuple):
    """The nominal press at its outermost slide position; ``points``: turning points that can be outermost in a press of the sample."""

    local: _Local
    angle: float
    points: tuple[TurningPoint, ...]

    @property
    def gradient(self) -> Array:
        """(k,) derivatives of the position by the dimensions."""
        return self.local.position_slopes

    def positions(self, shapes: Shapes, deviations: Array) -> Array:
        """Outermost slide positions (n,) of presses with deviations (k, n) [m].

        Raises:
            PinpressError: some of these presses cannot be closed there.
        """
        positions = [outermost_positions(shapes, deviations, point) for point in self.points]
        return np.asarray(np.max(positions, axis=0) if self.points[0].upwards else np.min(positions, axis=0))


def dead_centre_gradients(press: Linkage, parts: Sequence[Dimension], motion: Motion | None = None) -> tuple[Array, Array]:
    """Derivatives (k,) of the slide's position at bottom and top dead centre by the dimensions, or at the lowest and highest state of a
    motion.

    Raises:
        PinpressError: the press has no slide, several drivers and no motion, or no dead centres; the motion belongs to another press; a
            dimension opens redundant bearings, as in presses with several points.
    """
    if motion is not None:
        shapes = _shapes(press, parts)
        bottom, top = (_Local.of(shapes, motion, state) for state in ends_of(press, motion))
    else:
        refuse_several_drivers(press)
        points, shapes = turning_points(press), _shapes(press, parts)
        bottom, top = (_Local.at(shapes, float(points.places[points.first_of_the_farthest(upwards)])) for upwards in (False, True))
    return bottom.position_slopes, top.position_slopes


def _shapes(press: Linkage, parts: Sequence[Dimension]) -> Shapes:
    """The press with its dimensions. Raises as `shapes_of`."""
    return shapes_of(press, [directed(press, part.direction) for part in parts])


def ends_of(press: Linkage, motion: Motion) -> tuple[int, int]:
    """The lowest and the highest state of a motion.

    Raises:
        PinpressError: the motion belongs to another press, with other joints or lengths, or the press has no slide.
    """
    refuse_motion_of_another(press, motion)
    return int(motion.slide_position.argmin()), int(motion.slide_position.argmax())


def _at_end(shapes: Shapes, motion: Motion, upwards: bool) -> _DeadCentre:
    """The outermost state of a motion, in which the drivers of every press have the same positions."""
    state = ends_of(shapes.press, motion)[upwards]
    local = _Local.of(shapes, motion, state)
    turning_point = TurningPoint(Ending(local.start, np.zeros_like(local.position_slopes), "held"), upwards)
    return _DeadCentre(local, float(np.ravel(motion.crank_angle[state])[0]), (turning_point,))


def _outermost(shapes: Shapes, points: TurningPoints, parts: Sequence[Dimension], drawn: Array, upwards: bool) -> _DeadCentre:
    """A dead centre of the nominal press, with the other turning points that can be outermost in a press of the sample."""
    first = points.first_of_the_farthest(upwards)
    local = _Local.at(shapes, float(points.places[first]))
    spread = 3.0 * np.maximum(np.abs(drawn).max(axis=1), [part.tolerance for part in parts])  # three times, because of first order
    behind = (points.positions[first] - points.positions) * (1.0 if upwards else -1.0)
    reaching = [_turning(points, first, local, upwards)]
    for k in (k for k in range(len(behind)) if k != first):
        other = _Local.at(shapes, float(points.places[k]))
        if behind[k] <= np.maximum(np.abs(local.position_slopes), np.abs(other.position_slopes)) @ spread:
            reaching.append(_turning(points, k, other, upwards))
    return _DeadCentre(local, float(points.places[first]), tuple(reaching))


def _turning(points: TurningPoints, k: int, local: _Local, upwards: bool) -> TurningPoint:
    """A turning point of the nominal press."""
    limits = points.places[: points.limits]
    travel = float(np.ptp(limits)) if len(limits) else 2 * np.pi * points.turns
    speed = float(np.ptp(points.positions)) / travel
    angle_slopes = np.zeros_like(local.rate_slopes)
    ways: tuple[int, ...] = (1, -1)
    if at_limit := k < points.limits:
        ways = (1,) if points.places[k] < limits.max() else (-1,)
    elif abs(local.second) > 1e-6 * speed:  # a flatter path does not turn back at a place of first order
        angle_slopes = -local.rate_slopes / local.second
    steps = math.ceil(360 * points.turns)
    ending = Ending(local.start, angle_slopes, "held" if at_limit else "dead centre")
    return TurningPoint(ending, upwards, ways, local.second, speed, travel / steps, steps)


def refuse_several_drivers(press: Linkage) -> None:
    """Raise PinpressError if a press without a motion has several drivers."""
    if len(press.drivers) > 1:
        raise PinpressError(
            f"{press.name} has {len(press.drivers)} drivers, so it has no dead centres without a motion of all drivers: give"
            " motion=servo_cycle(press, angles, speed=...); its lowest state is the bottom"
        )


# ----------------------------------------------------------------------------------------------------------- torque and speed at a height


class _Travel(NamedTuple):
    """Torque or speed at a height above bottom dead centre, ``factor`` times z', the slide's travel per crank angle.

    ``gradient``: (k,) slopes of the quantity by the dimensions; ``ending``: this height, for bottom dead centres at 0.
    """

    quantity: str
    unit: str
    height: float
    factor: float
    nominal: float
    gradient: Array
    ending: Ending

    @staticmethod
    def on_the_way_down(shapes: Shapes, bottom: _DeadCentre, unit: str, height: float, by: float, backwards: bool) -> _Travel:
        """The quantity of the nominal press; ``by``: force [N] or speed of the crank [rad/s].

        Raises:
            PinpressError: the height is not within the stroke.
        """
        local = _Local.at(shapes, _angle_at(shapes.press, bottom, height, backwards))
        angle_slopes = -(local.position_slopes - bottom.gradient) / local.rate
        rate_slopes = local.rate_slopes + local.second * angle_slopes
        what = "torque" if unit == "N m" else "speed"
        factor = -by if unit == "N m" else -abs(by) * (-1.0 if backwards else 1.0)  # the slide goes down
        ending = Ending(local.start, angle_slopes, "height")
        return _Travel(f"{what} at {1e3 * height:g} mm", unit, height, factor, factor * local.rate, factor * rate_slopes, ending)

    def values(self, shapes: Shapes, deviations: Array, low: Array) -> Array:
        """The quantity (n,) of presses with deviations (k, n) and bottom dead centres ``low`` (n,) [m].

        Raises:
            PinpressError: some of these presses cannot be closed there.
        """
        ending = self.ending._replace(target=low + self.height)
        return self.factor * sound(shapes, deviations, ending, f"{1e3 * self.height:g} mm above bottom dead centre").rate


def _quantities_at_heights(
    press: Linkage, forces: Mapping[float, float], speeds: Mapping[float, float], backwards: bool
) -> Iterator[tuple[str, float, float, bool]]:
    """Unit of each quantity, height, force or speed of the crank, and whether the crank turns backwards; ``backwards``: under forces."""
    if (forces or speeds) and not press.driver_coordinates[0].turns:
        raise PinpressError(
            f"driver {press.driver!r} of {press.name} slides, but torque and speed at a height need a crank: leave them out"
        )
    if speeds:
        doubt_speeds(press, np.array([*speeds.values()]))
    for what, unit, by_height in (("forces", "N", forces), ("speeds", "rad/s", speeds)):
        for height, value in by_height.items():
            above = number(f"height of {what}", height, "m", positive=True)
            by = number(f"{what} at {above:g} m", value, unit)
            if not by:
                raise PinpressError(f"{what} at {above:g} m is 0 {unit}: give another value, or leave it out")
            if what == "speeds":
                yield "m/s", above, by, by < 0.0
            else:
                weight = GRAVITY * float(press.model.inertias[press.slide_guide.joint + 1].mass)
                plausibility.forces(f"{what} at {above:g} m", abs(by), weight)
                yield "N m", above, by, backwards


def _angle_at(press: Linkage, bottom: _DeadCentre, height: float, backwards: bool) -> float:
    """Crank angle at which the slide is at a height above bottom dead centre, on the way down [rad]."""
    points = turning_points(press)
    turn = 2 * np.pi * points.turns
    before = (points.places - bottom.angle) % turn if backwards else (bottom.angle - points.places) % turn
    way = float(before[(before > 1e-9) & (before < turn - 1e-9)].min())
    along = np.linspace(0.0, way if backwards else -way, 181) + bottom.angle
    position, target = motion_through_change_points(press, along, 1.0).slide_position, bottom.local.position + height
    if not target < position.max():
        stroke = 1e3 * float(position.max() - bottom.local.position)
        raise PinpressError(
            f"a height of {1e3 * height:.6g} mm is not within the stroke of {stroke:.6g} mm of {press.name}: give a lower height above"
            " bottom dead centre"
        )

    def ahead(angle: Array) -> tuple[Array, Array]:
        motion = motion_through_change_points(press, angle, 1.0)
        return motion.slide_position - target, motion.slide_velocity

    above = int(np.argmax(position >= target))
    ends = np.sort(along[above - 1 : above + 1])
    return float(bracketed_roots(ahead, ends[:1], ends[1:], absolute=1e-14)[0])
