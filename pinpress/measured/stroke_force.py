"""Measure the process force over the height of the slide from the signals of the drive: the press is the sensor.

    found = pp.measured.identify(press, idle_runs)  # or the press as described, with friction=
    run = pp.measured.record("blanking.csv", "crank [rad]", "motor [N m]", ratio=20.7)
    force = pp.measured.process_force(found, run, np.linspace(0.0, 0.012, 13), drive_inertia=2000.0)

    sensor = pp.measured.force_sensor(found, heights, drive_inertia=2000.0)  # prepared once, then used stroke by stroke
    for stroke in sensor.strokes(run): ...

Crank and slide have the same power. With the crank's angle q and speed w, the torque of the drive on the crank is

    torque = d/dt ((J + A) w) - A' w^2 / 2 + C + friction - F z',

where J turns with the crank (motor, gears, flywheel), A(q) is the inertia of the links at the crank, C(q) their weight, and z(q) the height
of the slide with z' = dz/dq. The force F on the slide is positive upwards. On the way down it is linear between heights and zero above the
highest. On request a force acts on the way up too, between other heights. The equation is multiplied by B-splines phi over time and
integrated by parts twice,

    integral of phi torque dt = integral of phi'' (J q + G) dt + integral of phi (C - A' w^2 / 2 + friction - F z') dt

where G is the integral of A over q. So the large term needs no derivative of the angle: the flywheel's torque is a second difference of
the angle, whose noise is known. The covariance of both noises makes the rows independent, and least squares give F with its covariance.
Inverse dynamics give the friction under this force, in a few passes.

In an elastic press the force over the angle stays right, but the slide is higher than the crank angle shows, by force / stiffness.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common import plausibility
from ..common.arguments import expect, numbers, positive, typed
from ..common.errors import PinpressError, caution, shown
from ..common.frozen import Frozen
from ..common.quantities import GRAVITY, Array
from ..common.results import Tabular
from ..common.tables import Column
from ..dynamics.applied_loads import force_on_slide
from ..dynamics.inverse_dynamics import NONE_GIVEN, inverse_dynamics
from ..kinematics.cycle import moved
from ..linkage.linkage import NAME_A_SLIDE, Linkage
from ..loads.link import Friction
from .estimates.prior import ZERO
from .identification import IdentifiedPress, checked_inertia
from .records import MeasuredRun, sample_noise, white_noise
from .regressor import InertialEquations, inertial_equations, slide_rates

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

STATES = 1440  # nodes per turn of the splines of the coefficients
APART = 2  # samples between the middles of two B-splines
FEWEST = 40  # least number of samples of a measured stroke


@dataclass(frozen=True, eq=False, repr=False)
class MeasuredForce(Tabular):
    """The process force of a stroke, or of several equal strokes. All arrays are read-only.

    Attributes:
        name: name of the run.
        heights: (k,) heights above bottom dead centre from the crank angle, rising [m].
        force: (k,) forces on the slide on its way down, positive upwards (against the stroke) [N].
        deviation: (k,) standard deviations of ``force`` from noise and from its curvature between heights [N].
        heights_up: (j,) heights on the way up, where strippers and ejectors act; empty if not requested [m].
        force_up: (j,) forces on the slide on its way up, positive upwards; a force that holds the slide back is negative [N].
        deviation_up: (j,) standard deviations of ``force_up`` [N].
        covariance: (k + j, k + j) covariance of the forces due to noise, first down, then up [N2].
        slide_height: (k,) true heights of the slide, higher by force / stiffness [m]; ``heights`` for a rigid press.
        slide_height_up: (j,) true heights of the slide on the way up [m].
        work: work that the slide gave over the stroke, down and up [J].
        work_deviation: standard deviation of the work [J].
        noise: standard deviation of a sample of the torque [N m].
        misfit: rms residual / rms noise while the force acts [-].
        idle_misfit: rms residual / rms noise while no force acts [-].
    """

    name: str
    heights: Array
    force: Array
    deviation: Array
    heights_up: Array
    force_up: Array
    deviation_up: Array
    covariance: Array
    slide_height: Array
    slide_height_up: Array
    work: float
    work_deviation: float
    noise: float
    misfit: float
    idle_misfit: float

    @property
    def title(self) -> str:
        k = int(self.force.argmax())
        return (
            f"MeasuredForce {self.name}: at most {1e-3 * self.force[k]:.4g} ± {1e-3 * 2 * self.deviation[k]:.2g} kN, at"
            f" {1e3 * self.heights[k]:.4g} mm, work {self.work:.4g} ± {2 * self.work_deviation:.2g} J"
        )

    @property
    def interval(self) -> Array:
        """(k, 2) lowest and highest force at 95 % [N]."""
        return np.asarray(self.force[:, None] + np.array([-1.96, 1.96]) * self.deviation[:, None])

    @property
    def interval_up(self) -> Array:
        """(j, 2) lowest and highest force on the way up at 95 % [N]."""
        return np.asarray(self.force_up[:, None] + np.array([-1.96, 1.96]) * self.deviation_up[:, None])

    @property
    def edges(self) -> bool:
        """Whether the residuals show edges of the force that straight lines between these heights do not follow."""
        return self.misfit > 1.5 * max(self.idle_misfit, 1.0)

    def columns(self) -> dict[str, Column]:
        """A row for each height, first down, then up: height, force, deviation, and true height of the slide."""
        return {
            "way": ["down"] * len(self.heights) + ["up"] * len(self.heights_up),
            "height [m]": np.append(self.heights, self.heights_up),
            "force [N]": np.append(self.force, self.force_up),
            "deviation [N]": np.append(self.deviation, self.deviation_up),
            "slide_height [m]": np.append(self.slide_height, self.slide_height_up),
        }


class _Coefficients(NamedTuple):
    """Periodic splines over the crank angle and their period: inertia A [kg m2], weight C [N m], height above bottom dead centre z [m]."""

    inertia: CubicSpline
    weight: CubicSpline
    height: CubicSpline
    period: float

    def inertia_integral(self, angle: Array) -> Array:
        """(n,) integral of A from angle 0 [kg m2 rad]."""
        whole, rest = np.divmod(angle, self.period)
        integral = self.inertia.antiderivative()
        return np.asarray(whole * integral(self.period) + integral(rest))


@dataclass(frozen=True, eq=False, repr=False)
class ProcessForceSensor(Frozen):
    """A press as a sensor of its process force, made by `force_sensor`. It has no state: every stroke is measured separately.

    Attributes:
        press: the press.
        heights: (k,) heights above bottom dead centre between which the force is linear on the way down, rising [m].
        heights_up: (j,) heights between which the force is linear on the way up, rising [m].
        identified: the identified press with friction, balance cylinder and encoder zero; None: the press is as described.
        friction: friction of bearings and guides of a press as described.
        drive_inertia: inertia at the crank that turns with the crank and is not part of the press [kg m2].
        stiffness: stiffness of the press between crank and die [N/m]; None: rigid.
    """

    press: Linkage
    heights: Array
    heights_up: Array
    identified: IdentifiedPress | None
    friction: Mapping[str, Friction]
    drive_inertia: float
    stiffness: float | None
    _coefficients: _Coefficients

    def force(self, run: MeasuredRun) -> MeasuredForce:
        """Measure the force in a run of one stroke, or of several strokes with the same tool and blank.

        Args:
            run: crank angle and torque of the drive at the crank; for an identified press with the same encoder and zero.

        Raises:
            PinpressError: the run has no torque, does not pass all heights, or is sampled too slowly for them.

        Warns:
            PinpressWarning: residuals show edges of the force between the heights, or show that the press differs from its description.
        """
        expect("run", run, MeasuredRun, "measured.record")
        return _measured(self, run)

    def strokes(self, run: MeasuredRun) -> Iterator[MeasuredForce]:
        """Measure the force of each whole stroke of a run, from one top dead centre to the next.

        Raises:
            PinpressError: as for `force`.
        """
        expect("run", run, MeasuredRun, "measured.record")
        period = self._coefficients.period
        angles = np.linspace(0.0, period, STATES, endpoint=False)
        top = float(angles[int(np.argmax(self._coefficients.height(angles)))])
        phase = np.floor((run.angle - self._zero - top) / period)
        for turn in range(int(phase.min()), int(phase.max()) + 1):
            within = phase == turn
            times = run.time[within]
            if len(times) >= FEWEST and np.ptp(run.angle[within]) > 0.98 * period:
                yield self.force(run.between(float(times[0]), float(times[-1])))

    @property
    def _zero(self) -> float:
        """Reading of the encoder in the drawn pose [rad]."""
        return 0.0 if self.identified is None else self.identified.values[ZERO]


@typed
def force_sensor(
    press: Linkage | IdentifiedPress,
    heights: ArrayLike,
    *,
    heights_up: ArrayLike = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    drive_inertia: float = 0.0,
    stiffness: float | None = None,
) -> ProcessForceSensor:
    """Make a sensor of the process force from a press.

    Args:
        press: the press with one crank and a slide: the result of `identify`, with its friction and cylinder, or a press as described.
        heights: (k,) heights above bottom dead centre between which the force is linear on the way down; it is zero above the highest.
            Close heights follow edges, such as the fracture of a blank; distant heights have less noise [m].
        heights_up: (j,) heights on the way up, where strippers and ejectors act [m]; by default no force acts on the way up.
        friction: friction of bearings and guides of a press as described, as for `inverse_dynamics`.
        drive_inertia: inertia at the crank of motor, gears and flywheel, each times its ratio squared, unless it is part of the press
            [kg m2].
        stiffness: stiffness of the press between crank and die: the force makes the slide lag behind the crank [N/m]; default: rigid.

    Raises:
        PinpressError: the press has no slide, several drivers, or a sliding driver; heights do not rise or are outside the stroke; a
            number is out of its range.
    """
    identified = press if isinstance(press, IdentifiedPress) else None
    press = press.press if isinstance(press, IdentifiedPress) else press
    if identified is not None and friction:
        raise PinpressError("friction is given, but the identified press contains its friction: leave friction out")
    equations = inertial_equations(press)
    if press.slide is None:
        raise PinpressError(f"{press.name} has no slide for a process force: {NAME_A_SLIDE}")
    if press.period_turns is None:
        raise PinpressError(f"the crank of {press.name} does not turn fully, but a force sensor needs whole strokes")
    coefficients = _coefficients_of(press, equations)
    stroke = float(coefficients.height(np.linspace(0.0, coefficients.period, STATES)).max())
    down = _knots("heights", heights, stroke, press.name)
    none_up = isinstance(heights_up, Sequence) and not len(heights_up)
    up = np.zeros(0) if none_up else _knots("heights_up", heights_up, stroke, press.name)
    inertia = checked_inertia(drive_inertia)
    spring = None if stiffness is None else positive("stiffness", stiffness, "N/m")
    if spring is not None:
        weight = GRAVITY * float(press.model.inertias[press.slide_guide.joint + 1].mass)
        plausibility.springs("force_sensor: stiffness", spring, weight, press.size)
    return ProcessForceSensor(press, down, up, identified, dict(friction), inertia, spring, coefficients)


def _knots(name: str, heights: ArrayLike, stroke: float, press: str) -> Array:
    """Check the heights of one way; raises PinpressError if they are wrong."""
    knots = numbers(name, heights, (None,), unit="m")
    if not 2 <= len(knots) <= 2000 or not (np.diff(knots) > 0).all():
        raise PinpressError(f"{name} is {shown(heights)}: give 2 to 2000 rising heights above bottom dead centre [m]")
    if knots[0] < -1e-9 * stroke or knots[-1] >= stroke:
        raise PinpressError(
            f"{name} reach from {knots[0]:.6g} to {knots[-1]:.6g} m; the slide of {press} moves from 0 to {stroke:.6g} m above bottom"
            " dead centre: give heights within its stroke, in m"
        )
    return knots


@typed
def process_force(
    press: Linkage | IdentifiedPress,
    run: MeasuredRun,
    heights: ArrayLike,
    *,
    heights_up: ArrayLike = (),
    friction: Mapping[str, Friction] = NONE_GIVEN,
    drive_inertia: float = 0.0,
    stiffness: float | None = None,
) -> MeasuredForce:
    """Measure the process force over the height from one stroke or several equal strokes: ``force_sensor(...).force(run)``.

    Args:
        press: as for `force_sensor`.
        run: crank angle and torque of the drive at the crank.
        heights: as for `force_sensor`.
        heights_up: as for `force_sensor`.
        friction: as for `force_sensor`.
        drive_inertia: as for `force_sensor`.
        stiffness: as for `force_sensor`.

    Raises:
        PinpressError: as for `force_sensor` and `ProcessForceSensor.force`.
    """
    sensor = force_sensor(press, heights, heights_up=heights_up, friction=friction, drive_inertia=drive_inertia, stiffness=stiffness)
    return sensor.force(run)


def _coefficients_of(press: Linkage, equations: InertialEquations) -> _Coefficients:
    from scipy.interpolate import CubicSpline  # slow to import

    period = 2 * np.pi * (press.period_turns or 1)
    angles = np.linspace(0.0, period, STATES * (press.period_turns or 1) + 1)
    torque = equations.coefficients(angles)["torque"]
    motion = moved(press, press.branch, angles, 1.0, 0.0, None, press.engine())
    columns = np.stack([torque.inertia @ equations.values, torque.weight @ equations.values, slide_rates(press, motion)[1]])
    columns[:, -1] = columns[:, 0]
    inertia, weight, height = (CubicSpline(angles, column, bc_type="periodic") for column in columns)
    return _Coefficients(inertia, weight, height, period)


# -------------------------------------------------------------------------------------------------------------------------- least squares


class _Smooth(NamedTuple):
    """The crank by a spline: speeds [rad/s] and accelerations [rad/s2], (n,), and the noise of a sample of the angle [rad]."""

    speed: Array
    acceleration: Array
    noise: float


class _Weights(NamedTuple):
    """Weights of the equations of a run.

    Attributes:
        plain: (m,) phi dt of the samples around the middle of a row.
        twice: (m,) phi'' dt of these samples.
        factor: banded Cholesky factor of the covariance of rows, in units of the torque's noise.
    """

    plain: Array
    twice: Array
    factor: Array

    def of(self, values: Array, twice: bool = False) -> Array:
        """(rows, ...) integrals of samples (n, ...) with phi, or with phi''."""
        weights = self.twice if twice else self.plain
        windows = np.lib.stride_tricks.sliding_window_view(values, len(weights), axis=0)[::APART]
        return np.asarray(windows @ weights)

    def independent(self, rows: Array) -> Array:
        """Rows (rows, ...) with white noise."""
        from scipy.linalg.lapack import dtbtrs  # slow to import

        return np.asarray(dtbtrs(self.factor, rows.reshape(len(rows), -1), uplo="L")[0].reshape(rows.shape))


def _measured(sensor: ProcessForceSensor, run: MeasuredRun) -> MeasuredForce:
    """The force of a run, see `ProcessForceSensor.force`."""
    if run.torque is None:
        raise PinpressError(f"{run.name}: no torque was measured: name its column, or give the constant, record(..., motor_constant=)")
    if len(run.time) < FEWEST:
        raise PinpressError(f"{run.name}: {len(run.time)} samples are too few for a stroke: sample faster")
    smooth, noise, angle = _smooth(run), sample_noise(run.torque), run.angle - sensor._zero
    inertia, weight, height = (spline(angle) for spline in sensor._coefficients[:3])
    rate, slope = sensor._coefficients.height(angle, 1), sensor._coefficients.inertia(angle, 1)
    weights = _weights(run, (smooth.noise / noise) * (sensor.drive_inertia + inertia))
    down = rate * smooth.speed < 0
    basis = _basis([sensor.heights, sensor.heights_up], height, down)
    columns = weights.of(-basis * rate[:, None])
    _refuse_unseen(sensor, run, columns)

    momentum = sensor.drive_inertia * angle + sensor._coefficients.inertia_integral(angle)
    left = weights.of(run.torque - weight + 0.5 * slope * smooth.speed**2) - weights.of(momentum - momentum[0], twice=True)
    independent = weights.independent(columns) / noise
    force, lost = np.zeros(basis.shape[1]), np.zeros(1)
    rubs = bool(sensor.friction) or sensor.identified is not None
    for _ in range(3 if rubs else 1):  # friction is computed again under the last force
        if rubs:
            lost = weights.of(_losses(sensor, run, smooth, basis @ force))
        known = weights.independent(left - lost) / noise
        force, covariance = _least_squares(independent, known)

    residual, acting = known - independent @ force, (columns != 0).any(axis=1)
    curved = []
    for way in range(2):  # with an additional height between every two heights of a way
        ways = [sensor.heights, sensor.heights_up]
        ways[way] = np.sort(np.append(ways[way], 0.5 * (ways[way][1:] + ways[way][:-1])))
        finer = weights.independent(weights.of(-_basis(ways, height, down) * rate[:, None])) / noise
        curved.append(len(ways[way]) > 0 and _contradicts_lines(finer, known, residual, acting))
    return _result(sensor, run, force, covariance, residual, acting, noise, curved)


def _basis(ways: Sequence[Array], height: Array, down: NDArray[np.bool_]) -> Array:
    """(n, k + j) hat functions: weights of the forces at the heights down and up, for a force that is linear between heights and zero above
    them."""
    parts = []
    for heights, on in zip(ways, (down, ~down), strict=True):
        shares = [np.interp(height, heights, one, right=0.0) * on for one in np.eye(len(heights))]
        parts.append(np.array(shares).reshape(len(heights), len(height)).T)
    return np.hstack(parts)


def _contradicts_lines(columns: Array, known: Array, residual: Array, acting: NDArray[np.bool_]) -> bool:
    """Whether forces at additional heights, with these columns, improve the fit significantly (F-test at 99 %)."""
    from scipy.stats import f  # slow to import

    force, _, rank, _ = np.linalg.lstsq(columns, known, rcond=1e-9)
    left = float(((known - columns @ force)[acting] ** 2).sum())
    more, free = rank // 2, max(int(np.count_nonzero(acting)) - int(rank), 1)
    return bool((residual[acting] ** 2).sum() - left > more * left / free * f.isf(0.01, more, free))


def _smooth(run: MeasuredRun) -> _Smooth:
    """Speed and acceleration of the crank by a quintic spline."""
    from scipy.interpolate import make_lsq_spline  # slow to import

    time = run.time - run.time[0]
    pieces = int(np.clip(24 * run.strokes, 4, len(time) // 4))
    knots = np.concatenate([np.zeros(5), np.linspace(0.0, time[-1], pieces + 1), np.full(5, time[-1])])
    spline = make_lsq_spline(time, run.angle, knots, k=5)
    noise = max(white_noise(run.angle), (run.resolution or 0.0) / np.sqrt(12.0), 1e-12)  # rounding to counts is uniform noise
    return _Smooth(spline(time, 1), spline(time, 2), noise)


def _weights(run: MeasuredRun, arm: Array) -> _Weights:
    """Cubic B-splines over the samples; ``arm``: (n,) (noise of the angle / noise of the torque) x rotating inertia."""
    from scipy.linalg import cholesky_banded  # slow to import

    interval = (run.time[-1] - run.time[0]) / (len(run.time) - 1)
    place = np.arange(-2 * APART + 1, 2 * APART) / APART
    near, far = np.abs(place), np.clip(2 - np.abs(place), 0.0, None)
    plain = np.where(near < 1, (4 - 6 * near**2 + 3 * near**3) / 6, far**3 / 6) * interval
    twice = np.where(near < 1, 3 * near - 2, far) / (APART * interval) ** 2 * interval
    rows = (len(run.time) - len(plain)) // APART + 1
    local = arm[len(plain) // 2 :: APART][:rows]
    bands = np.zeros((4, rows))
    for k in range(4):
        shift = k * APART
        if shift < len(plain):
            bands[k, : rows - k] = plain[shift:] @ plain[: len(plain) - shift]
            bands[k, : rows - k] += (twice[shift:] @ twice[: len(plain) - shift]) * local[: rows - k] * local[k:]
    return _Weights(plain, twice, cholesky_banded(bands, lower=True))


def _refuse_unseen(sensor: ProcessForceSensor, run: MeasuredRun, columns: Array) -> None:
    """Refuse a height around which there are no samples."""
    missed, count = np.flatnonzero(np.count_nonzero(columns, axis=0) < 2), len(sensor.heights)
    if len(missed):
        first = int(missed[0])
        way, height = ("down", sensor.heights[first]) if first < count else ("up", sensor.heights_up[first - count])
        raise PinpressError(
            f"{run.name}: no samples on the way {way} between the heights around {height:.6g} m: give heights further apart, sample faster"
            f" than {1 / run.sampling:.4g} Hz, or record the whole stroke"
        )


def _losses(sensor: ProcessForceSensor, run: MeasuredRun, smooth: _Smooth, force: Array) -> Array:
    """(n,) torque of friction under a process force (n,), and of a balance cylinder [N m]."""
    press = sensor.press
    motion = moved(press, press.branch, run.angle - sensor._zero, smooth.speed, smooth.acceleration, None, press.engine())
    loads = [force_on_slide(press, force)] if force.any() else []
    without = inverse_dynamics(press, motion, loads, bearings=()).driving_torque
    if sensor.identified is not None:
        return sensor.identified.torque(motion, loads) - without
    return np.asarray(inverse_dynamics(press, motion, loads, friction=sensor.friction, bearings=()).driving_torque - without)


def _least_squares(columns: Array, known: Array) -> tuple[Array, Array]:
    """Forces and their covariance for noise of 1."""
    sizes = np.linalg.norm(columns, axis=0)
    left, values, right = np.linalg.svd(columns / sizes, full_matrices=False)
    if values[-1] < 1e-9 * values[0]:
        raise PinpressError("the samples cannot separate the forces at these heights: give heights further apart, or sample faster")
    back = (right.T / values) / sizes[:, None]
    return np.asarray(back @ (left.T @ known)), np.asarray(back @ back.T)


def _result(
    sensor: ProcessForceSensor,
    run: MeasuredRun,
    force: Array,
    covariance: Array,
    residual: Array,
    acting: NDArray[np.bool_],
    noise: float,
    curved: Sequence[bool],
) -> MeasuredForce:
    """The force with its band, which is wider if residuals are larger than noise, or if the force of a way is ``curved``."""
    rest = residual[~acting]
    idle_misfit = float(np.sqrt((rest**2).mean())) if len(rest) > FEWEST // 2 else 1.0
    free = max(int(np.count_nonzero(acting)) - len(force), 1)
    misfit = float(np.sqrt((residual[acting] ** 2).sum() / free))
    covariance = covariance * max(1.0, misfit, idle_misfit) ** 2
    count = len(sensor.heights)
    deviation = np.sqrt(np.diag(covariance))
    for is_curved, heights, way in zip(curved, (sensor.heights, sensor.heights_up), (slice(count), slice(count, None)), strict=True):
        if is_curved:
            deviation[way] = np.hypot(deviation[way], np.sqrt(_squared_errors_of_lines(heights, force[way], covariance[way, way])))
    lifted = 0.0 * force if sensor.stiffness is None else force / sensor.stiffness
    # Work is a sum of forces x lengths, by the trapezoidal rule. On the way up a force upwards gives work to the slide.
    down, up = (np.trapezoid(np.eye(len(heights)), heights) for heights in (sensor.heights, sensor.heights_up))
    lengths = np.append(down, -up)
    found = MeasuredForce(
        name=run.name,
        heights=sensor.heights,
        force=force[:count],
        deviation=deviation[:count],
        heights_up=sensor.heights_up,
        force_up=force[count:],
        deviation_up=deviation[count:],
        covariance=covariance,
        slide_height=sensor.heights + lifted[:count],
        slide_height_up=sensor.heights_up + lifted[count:],
        work=float(lengths @ force),
        work_deviation=float(np.sqrt(lengths @ covariance @ lengths)),
        noise=noise,
        misfit=misfit,
        idle_misfit=idle_misfit,
    )
    if idle_misfit > 2:
        caution(
            f"{run.name}: without process force the torque differs from that of the described press by {idle_misfit:.3g} times the"
            " noise: identify the press from a run without a blank, and give its friction and drive_inertia"
        )
    if found.edges:
        caution(
            f"{run.name}: residuals under force are {misfit:.3g} times the noise: the force has edges between heights"
            f" {1e3 * np.diff(sensor.heights).min():.3g} mm apart. Give closer heights where the force jumps"
        )
    return found


def _squared_errors_of_lines(heights: Array, force: Array, covariance: Array) -> Array:
    """(k,) squared errors of straight lines between heights for a curved force [N2].

    At a height the lines of least squares differ from the force by h^2 F'' / 12. F'' is estimated from the forces, less the part that their
    noise explains; the ends use F'' of the next height.
    """
    if len(heights) < 3:
        return np.zeros(len(heights))
    below, above = np.diff(heights)[:-1], np.diff(heights)[1:]
    share = np.maximum(below, above) ** 2 / (6.0 * (below + above))
    inner = np.arange(len(below))
    rows = np.zeros((len(below), len(heights)))
    rows[inner, inner], rows[inner, inner + 1], rows[inner, inner + 2] = share / below, -share * (1 / below + 1 / above), share / above
    squares = np.maximum((rows @ force) ** 2 - np.diag(rows @ covariance @ rows.T), 0.0)
    return np.concatenate([squares[:1], squares, squares[-1:]])
