"""Parallelism of a slide that hangs on several points, and the dimensions that matter most.

    tol = pp.tolerances
    chains = {
        side: [tol.link_length(press, "O", f"P2_{side}", 10e-6), tol.link_length(press, f"P2_{side}", f"P4_{side}", 20e-6)]
        for side in ("front", "back")
    }
    tol.parallelism(press, {f"P4_{side}": parts for side, parts in chains.items()})

Every point has a separate chain of rods from the crank to the slide. A rigid slide on several chains with different lengths would jam. The
height of a point is therefore the height that its chain alone gives it. Virtual work gives this height, with a unit force on the slide that
only this chain carries (see `virtual_work`), exact to first order in the dimensions. The points have the heights z_i at the places x_i,
y_i, the stiffness k, and guides of the stiffness kappa against turning. The slide takes the height h and the slopes s, t that minimise

    sum of k (h + s x_i + t y_i - z_i)^2 + kappa (s^2 + t^2)

Two points at -b and b have the slope (z_1 - z_2) / 2b times 2 k b^2 / (2 k b^2 + kappa). Without guides the slope follows the points. Four
points are not in one plane in general: their distances from the plane strain the slide, its rods and their bearings.

The caller gives permissible slopes, either as a number or as a table of `PermissibleSlope`. This has the form of standards: a difference of
heights that grows with the measured length. The grades of standards such as JIS B 6402 are not built in, because their texts were not
available.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..common import plausibility
from ..common.arguments import positive, suitable_numbers, typed
from ..common.errors import PinpressError, UnknownNameError
from ..common.frozen import FrozenMapping
from ..common.parameters import Checked, parameter
from ..common.quantities import Array, DriverCoordinate
from ..common.results import Tabular
from ..derivatives.motion import directed
from ..kinematics.motion import Motion
from ..kinematics.poses import bearing_points, poses
from ..kinematics.servo_motion import servo_cycle
from ..kinematics.slide_path import dead_centres
from ..linkage.linkage import Linkage, OfPress
from .dimensions import Dimension, check_dimensions, correlation_matrix, draw_deviations
from .scatter import Scatter, scatter
from .single_chains import ALONE, Chain
from .virtual_work import unit_forces

STATES = 120  # crank angles of a period
ONE_PLACE = 1e-9  # points that are closer, as a share of the linkage's size, are in one place


@dataclass(frozen=True)
class PermissibleSlope(Checked):
    """A row of a table of permissible slopes, from a standard or a contract.

    Over a measured length L the heights may differ by ``constant + by_length * L``.

    Attributes:
        constant: constant part of the difference [m].
        by_length: part of the difference that grows with the length, e.g. 60e-6 for 0.06 mm a metre [m/m].
        force: force of the process on the slide during the measurement, positive upwards; 0 for an idle press [N].
        place: (2,) place of this force from `Linkage.tool`, along both directions of `SlideParallelism` [m].
    """

    constant: float = field(metadata=parameter("m", "not negative"))
    by_length: float = field(default=0.0, metadata=parameter("m/m", "not negative"))
    force: float = field(default=0.0, metadata=parameter("N"))
    place: ArrayLike = field(default=(0.0, 0.0), metadata=parameter("m", axes=1))

    def __post_init__(self) -> None:
        super().__post_init__()
        if np.shape(self.place) != (2,):
            raise PinpressError(f"PermissibleSlope: place has shape {np.shape(self.place)}: give two numbers, along both directions [m]")
        if not (self.constant or self.by_length):
            raise PinpressError("PermissibleSlope: constant and by_length are 0: give the permissible difference of heights [m]")
        plausibility.lean("PermissibleSlope: constant", self.constant)


@dataclass(frozen=True, eq=False, repr=False)
class SlideParallelism(OfPress, Tabular):
    """Slopes of a slide on m points against the table. All arrays are read-only.

    Slopes are in m/m, along two directions at a right angle to the guide. The columns are n crank angles.

    Attributes:
        press_name: name of the press.
        coordinate: what the coordinate of the driver is.
        points: names of the bearings on which the slide hangs.
        places: (m, 2) places of the points from `Linkage.tool`, along both directions [m].
        directions: (2, 3) unit vectors of both directions in world axes; for a planar press in its plane, then across it.
        crank_angle: (n,) crank angles [rad]; for a driver that slides its positions [m].
        slope_sd: (n, 2) standard deviations of the slopes, to first order [-].
        slopes: the scatter of both slopes at bottom dead centre, with the shares of the dimensions; every press of its sample is exact.
        misfit_sd: (m,) standard deviations of the points' heights from their plane at bottom dead centre [m].
        point_force_sd: (m,) standard deviations of the forces on the points by this misfit and the guides [N]; None without stiffnesses.
        guide_moment_sd: (2,) standard deviations of the guides' moments against both slopes [N m]; None without stiffnesses.
        turning_compliance: (2, 2) slopes / moments of a force off the middle of the points [1/(N m)]; None without stiffnesses.
        deviations: (k, presses) deviations of the dimensions of every press of the sample from the nominal dimensions [m or rad].
    """

    _press: Linkage
    coordinate: DriverCoordinate
    points: tuple[str, ...]
    places: Array
    directions: Array
    crank_angle: Array
    slope_sd: Array
    slopes: tuple[Scatter, Scatter]
    misfit_sd: Array
    point_force_sd: Array | None
    guide_moment_sd: Array | None
    turning_compliance: Array | None
    deviations: Array

    def within(self, permissible: float) -> float:
        """Share of the sample's presses whose slopes at bottom dead centre are permissible in both directions [-].

        Args:
            permissible: largest permissible slope, from the standard or the customer [m/m].

        Raises:
            PinpressError: the slope is not positive.
        """
        return self._within(np.full(2, positive("permissible", permissible, "-")), np.zeros(2))

    def kept(self, permissible: Mapping[str, PermissibleSlope], lengths: ArrayLike) -> Mapping[str, float]:
        """Share of the sample's presses that keep each row of a table, in both directions.

        Args:
            permissible: name of a row, e.g. a grade -> its permissible slope.
            lengths: (2,) measured lengths along both directions, e.g. width and depth of the slide less the margins [m].

        Raises:
            PinpressError: there is no row, a row is not a `PermissibleSlope`, lengths are not two positive numbers, or a row has a
                force but the slide has no stiffnesses.
        """
        measured = suitable_numbers("lengths", lengths, "two positive lengths [m]", (2,), lambda given: given > 0)
        if not isinstance(permissible, Mapping) or not permissible:
            raise PinpressError("permissible has no row: give {name: PermissibleSlope(...)}")
        shares = {}
        for name, row in permissible.items():
            if not isinstance(row, PermissibleSlope):
                raise PinpressError(f"permissible {name!r} is a {type(row).__name__}: give a PermissibleSlope(constant, by_length)")
            shares[name] = self._within(row.constant / measured + row.by_length, self._tilt(name, row))
        return FrozenMapping(shares)

    def _within(self, limits: Array, tilt: Array) -> float:
        """Share of the presses whose slopes + tilt (2,) are within limits (2,) in both directions."""
        deviations = np.array([slope.deviation for slope in self.slopes])
        return float(np.mean(np.all(np.abs(deviations + tilt[:, None]) <= limits[:, None], axis=0)))

    def _tilt(self, name: str, row: PermissibleSlope) -> Array:
        """Slopes (2,) by the force of a row."""
        if not row.force:
            return np.zeros(2)
        if self.turning_compliance is None:
            raise PinpressError(
                f"permissible {name!r} has a force, but the slide has no stiffnesses to tilt by: give point_stiffness and guide_stiffness"
                " to parallelism, or the force 0"
            )
        return np.asarray(row.force * self.turning_compliance @ (np.asarray(row.place) - self.places.mean(axis=0)))

    @property
    def title(self) -> str:
        sd = " and ".join(f"{1e6 * slope.first_order_sd:.4g}" for slope in self.slopes)
        span = max(np.linalg.norm(first - second) for first in self.places for second in self.places)
        return f"SlideParallelism of {self.press_name}: {len(self.points)} points up to {span:.4g} m apart, slopes of sd {sd} um/m"

    def columns(self) -> dict[str, Array]:
        """A row for each crank angle: standard deviations of both slopes."""
        names = "{} [{}]".format(*self.coordinate.heads[0]), "first_slope_sd [-]", "second_slope_sd [-]"
        return dict(zip(names, (self.crank_angle, *self.slope_sd.T), strict=True))


@typed
def parallelism(
    press: Linkage,
    parts: Mapping[str, Sequence[Dimension]],
    *,
    point_stiffness: float | None = None,
    guide_stiffness: float | None = None,
    correlation: Mapping[tuple[str, str], float] | None = None,
    samples: int = 100_000,
    seed: int = 0,
) -> SlideParallelism:
    """Compute the scatter of the slopes of a slide on several points, from the tolerances of the dimensions of the points' chains.

    Args:
        press: a press with one driver, whose slide hangs on at least two points at different places.
        parts: name of a point (the bearing of a rod on the slide) -> dimensions of its chain. A dimension of a shared part, e.g. the
            position of the shaft, moves the part for this point only, as if the shaft were tilted. A dimension given for several points
            moves all of them equally.
        point_stiffness: stiffness of every point [N/m]; None: points are rigid compared with the guides.
        guide_stiffness: stiffness of the guides against turning of the slide, in both directions [N m/rad]; None: guides do not resist.
            Give both stiffnesses or neither.
        correlation: correlation of dimensions, as in `bottom_dead_centre`.
        samples: number of presses in the sample.
        seed: seed of the random numbers.

    Raises:
        UnknownNameError: a bearing or dimension does not exist.
        PinpressError: the slide hangs on one point, a point is not named, a chain alone does not hold the slide or cannot be closed in
            every press of the sample, two dimensions have the same name, only one stiffness is given, a stiffness is not positive, or the
            press has several drivers or no dead centres.
    """
    if (point_stiffness is None) != (guide_stiffness is None):
        raise PinpressError(
            "only one of point_stiffness and guide_stiffness is given, but the slope depends on both: give both, or neither"
        )
    stiffness = None if point_stiffness is None else positive("point_stiffness", point_stiffness, "N/m")
    turning = 0.0 if guide_stiffness is None else positive("guide_stiffness", guide_stiffness, "N m/rad")
    press.refuse_several_drivers("parallelism needs a press with one driver; bearing_moment of inverse_dynamics has the slide's moment")
    bottom = dead_centres(press).bottom_angle
    if press.driver_coordinates[0].turns:
        angles = np.linspace(0.0, 2 * np.pi * press.period_turns, STATES, endpoint=False)
    else:
        angles = np.linspace(press.branch.angles[0], press.branch.angles[-1], STATES)
    motion = servo_cycle(press, np.append(angles, bottom), speed=0.0)
    points = _points(press, motion, parts)
    dimensions = _each_once(press, parts)
    places, directions = _places(press, motion, points)
    moved = [directed(press, part.direction) for part in dimensions]
    chains = [Chain.of(press, motion, points, point, [dimensions.index(part) for part in parts[point]], moved) for point in points]
    fit = _Fit.of(places, stiffness, turning)
    heights = np.zeros((len(points), len(dimensions), len(angles) + 1))
    for by_dimension, chain in zip(heights, chains, strict=True):
        by_dimension[chain.dimensions] = chain.slopes
    slopes = np.einsum("si,ikn->nsk", fit.slopes, heights)
    tied = correlation_matrix(dimensions, correlation)
    sd, tolerances = (np.array([getattr(part, name) for part in dimensions]) for name in ("standard_deviation", "tolerance"))
    covariance = tied * np.outer(sd, sd)
    at_bottom = np.where(np.abs(slopes[-1]) > 1e-12 * np.abs(slopes).max(), slopes[-1], 0.0)  # less is rounding error

    drawn = draw_deviations(dimensions, tied, samples, seed)
    corners = [sign * np.sign(gradient) * tolerances for gradient in at_bottom for sign in (-1.0, 1.0)]
    everything = np.column_stack([drawn, *corners])
    exact = fit.slopes @ np.array([chain.heights(everything) for chain in chains])

    def _slope(k: int) -> Scatter:
        """The scatter of one slope at bottom dead centre."""
        name = f"slope along ({', '.join(f'{part + 0.0:.3g}' for part in directions[k].round(3))})"
        of_sample, of_corners = exact[k, : drawn.shape[1]], exact[k, drawn.shape[1] + 2 * k : drawn.shape[1] + 2 * k + 2]
        return scatter(name, "m/m", 0.0, dimensions, at_bottom[k].copy(), tied, of_sample, of_corners)

    return SlideParallelism(
        _press=press,
        coordinate=press.driver_coordinates[0],
        points=points,
        places=places,
        directions=directions,
        crank_angle=angles,
        slope_sd=np.sqrt(np.einsum("nsk,kl,nsl->ns", slopes[:-1], covariance, slopes[:-1])),
        slopes=(_slope(0), _slope(1)),
        misfit_sd=_deviations(fit.misfit @ heights[:, :, -1], covariance),
        point_force_sd=None if stiffness is None else _deviations(fit.forces @ heights[:, :, -1], covariance),
        guide_moment_sd=None if stiffness is None else turning * _deviations(at_bottom, covariance),
        turning_compliance=None if stiffness is None else fit.compliance,
        deviations=drawn,
    )


def _deviations(rows: Array, covariance: Array) -> Array:
    """Standard deviations of linear combinations (r, k) of dimensions."""
    return np.asarray(np.sqrt(np.maximum(np.einsum("rk,kl,rl->r", rows, covariance, rows), 0.0)))


class _Fit(NamedTuple):
    """How a slide follows the heights of its m points, by the least squares of the module.

    Attributes:
        slopes: (2, m) slopes per unit of the heights [1/m].
        misfit: (m, m) distances of the points from their plane without guides, per unit of the heights [-].
        forces: (m, m) forces on the points per unit of the heights [N/m]; zero without stiffness.
        compliance: (2, 2) slopes by moments about the middle of the points [1/(N m)]; infinite without stiffness.
    """

    slopes: Array
    misfit: Array
    forces: Array
    compliance: Array

    @staticmethod
    def of(places: Array, stiffness: float | None, turning: float) -> _Fit:
        """The fit of points at places (m, 2); ``turning`` is 0 without stiffness."""
        columns = np.column_stack([np.ones(len(places)), places - places.mean(axis=0)])  # about the middle, which keeps its height
        free = fitted = np.linalg.pinv(columns, rcond=ONE_PLACE)
        compliance = np.full((3, 3), np.inf)
        if stiffness is not None:
            compliance = np.linalg.inv(stiffness * columns.T @ columns + np.diag([0.0, turning, turning]))
            fitted = stiffness * compliance @ columns.T
        unit, spread = np.eye(len(places)), np.ptp(places, axis=0)
        forces, slopes = (stiffness or 0.0) * (unit - columns @ fitted), fitted[1:].copy()
        slopes[spread <= ONE_PLACE * spread.max()] = 0.0  # points on a line do not resist a slope across the line
        return _Fit(slopes, unit - columns @ free, forces, compliance[1:, 1:])


# ----------------------------------------------------------------------------------------------------------------------------- points


def _points(press: Linkage, motion: Motion, parts: Mapping[str, Sequence[Dimension]]) -> tuple[str, ...]:
    """The bearings through which the drive carries the slide; ``parts`` must name all of them."""
    body = press.slide_guide.joint + 1
    on_slide = [name for name, parent in zip(press.joints, list(press.model.parents)[1:], strict=True) if parent == body]
    on_slide += [loop.name for loop in press.loops if body in (loop.joint1, loop.joint2)]
    forces = unit_forces(press, motion).force
    carrying = tuple(name for name in press.bearings if name in on_slide and np.abs(forces[name]).max() > ALONE)
    for name in parts:
        if name not in press.bearings:
            raise UnknownNameError("bearing", name, press.bearings)
    if len(carrying) < 2:
        raise PinpressError(f"the slide of {press.name} hangs on one point, {', '.join(carrying)}: parallelism needs several points")
    if set(parts) != set(carrying):
        raise PinpressError(
            f"the slide of {press.name} hangs on {', '.join(carrying)}, but parts does not name all of them, or names others: give"
            " parts={point: [...]} for each of these points, with an empty list for exact dimensions"
        )
    return carrying


def _each_once(press: Linkage, parts: Mapping[str, Sequence[Dimension]]) -> tuple[Dimension, ...]:
    """The dimensions of all chains; a dimension of several points counts once."""
    dimensions: dict[str, Dimension] = {}
    for point, of_chain in parts.items():
        if isinstance(of_chain, Dimension) or not isinstance(of_chain, Sequence):
            raise PinpressError(f"parts of {point!r} is not a list: give the dimensions of this point's chain, {{{point!r}: [...]}}")
        for part in check_dimensions(press, of_chain) if len(of_chain) else ():
            if dimensions.setdefault(part.name, part) is not part:
                raise PinpressError(
                    f"two different dimensions have the name {part.name!r}: give different names, or give the same dimension to both points"
                )
    if not dimensions:
        raise PinpressError("parts has no dimensions: give dimensions of the chains, e.g. from tolerances.link_length")
    return tuple(dimensions.values())


def _places(press: Linkage, motion: Motion, points: Sequence[str]) -> tuple[Array, Array]:
    """Places (m, 2) of points from `Linkage.tool` along two directions, and these directions (2, 3)."""
    up = press.slide_direction
    if len(press.engine().directions) == 2:
        across = np.cross(press.engine().turning_axes()[0], up)
    else:
        across = np.eye(3)[int(np.abs(up).argmin())]
        across = across - (across @ up) * up
    across = across / np.linalg.norm(across)
    across = across * np.sign(across[np.abs(across).argmax()])
    square = np.cross(up, across)
    directions = np.array([across, square * np.sign(square[np.abs(square).argmax()])])
    final_poses = poses(press, motion.joint_position[-1:])
    origin = final_poses.points(press.slide_guide.joint + 1, press.tool.in_body)[0]
    everywhere = bearing_points(press, final_poses)[:, 0]
    places = np.array([directions @ (everywhere[press.bearings.index(point)] - origin) for point in points])
    apart = min(np.linalg.norm(place - other) for k, place in enumerate(places) for other in places[:k])
    if not apart > ONE_PLACE * press.size:
        raise PinpressError(
            f"two of the points {', '.join(points)} of {press.name} are above each other, so they do not determine a slope: the slide"
            " must hang on points side by side"
        )
    return places, directions
