"""The one-degree-of-freedom reduction: inertia, potential energy and lengths of a linkage with one driver, over the crank angle.

    (I + J) w' + I' w^2 / 2 + V' = torque + sum F c'

with the reduced inertia I(angle), the potential energy V(angle) of the weights, the inertia J of flywheel and drive on the crank, and
forces F along coordinates c(angle): the slide's position, the length of a spring. All are smooth functions of the crank angle. They are
kept as polynomials, panel by panel (see `panels`), which resolve them within rounding error.
Source: Zhang 2007, 4.2 (for any linkage, and without its linearisations); Kong 2025 for the six-bar press.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..common.errors import SimulationError
from ..common.quantities import Array, DriverCoordinate
from ..dynamics.panels import Panels, last_terms, resolve
from ..engines.branch import MOST_TURNS, periods_until_back
from ..engines.energies import energies as energies_of_states
from ..kinematics.cycle import motion_through_change_points
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage
from ..linkage.memo import per_linkage
from .failures import failure

INERTIA, POTENTIAL, WEIGHT, COORDINATES = 0, 1, 2, 3  # rows of a model

LengthOfMotion = Callable[[Motion], Array]
"""A length (n,) or displacement [m] of the states of a motion."""


@dataclass(frozen=True, eq=False, repr=False)
class ReducedModel(Panels):
    """Reduced inertia, potential energy and coordinates over the crank angle.

    Attributes:
        borders: (p + 1,) of the panels, rising [rad].
        coefficients: (p, rows, q) of powers of x, from -1 to 1 over a panel. Rows are inertia [kg m2], potential energy about the middle
            of its range [J], its derivative by the crank angle [N m], coordinates [m].
        period: crank angle after which all repeats itself, but for the ``gains`` [rad]; None if the crank cannot turn that far.
        gains: (rows,) by how much each row has grown after a period: a slide on a screw or a rack does not come back, nor does the angle of
            a joint with a spring.
        evaluations: states of the linkage that were computed.
        coordinate: what the crank angle is: of a driver that slides it is a position [m], and the reduced inertia a mass [kg].
    """

    gains: Array
    evaluations: int
    coordinate: DriverCoordinate

    @property
    def repeats(self) -> bool:
        """Whether all is the same again after a period."""
        return self.period is not None and not self.gains.any()

    @cached_property
    def potential_range(self) -> float:
        """Range of the potential energy over the `middles` [J]."""
        return float(np.ptp(self.middles[POTENTIAL]))

    @cached_property
    def middles(self) -> Array:
        """(rows, p) in the middles of the panels."""
        return self.coefficients[:, :, 0].T

    @cached_property
    def lightest(self) -> tuple[float, float]:
        """The least reduced inertia at borders and middles of the panels [kg m2], and its crank angle [rad]."""
        angles = np.append(0.5 * (self.borders[1:] + self.borders[:-1]), self.borders[:-1])
        inertia = np.append(self.coefficients[:, INERTIA, 0], self.at(self.borders[:-1])[0][INERTIA])
        return float(inertia.min()), float(angles[int(inertia.argmin())])

    def local(self, angle: Array) -> Array:
        """Crank angles moved by whole periods into the model's range.

        Raises:
            SimulationError: the crank cannot turn that far.
        """
        first = self.borders[0]
        if self.period is not None:
            return np.asarray(angle - np.floor((angle - first) / self.period) * self.period)
        outside = (angle < first - 1e-9) | (angle > self.borders[-1] + 1e-9)  # less is rounding [rad]
        if outside.any():
            raise lock_failure(self, float(np.ravel(angle)[int(np.argmax(outside))]))
        return np.clip(angle, first, self.borders[-1])

    def at(self, angle: Array, derivative: bool = True) -> tuple[Array, Array]:
        """Rows (rows, ...) at crank angles (...), and their derivatives by the crank angle, which are zero without ``derivative``."""
        local = self.local(angle)
        values, slopes = super().at(local, derivative)
        if self.gains.any():
            assert self.period is not None
            values += np.multiply.outer(self.gains, np.round((angle - local) / self.period))
        return values, slopes


def lock_failure(model: ReducedModel, angle: float, time: float | None = None) -> SimulationError:
    """The error of a motion that leaves the range of a model without a period: the linkage locks there, or its driver is at an end."""
    coordinate = model.coordinate
    reason = "runs against a lock" if coordinate.turns else "runs against an end"
    low, high = f"{float(model.borders[0]) * coordinate.scale:.6g}", coordinate.shown(float(model.borders[-1]))
    return failure(reason, time, angle, low=low, high=high)


@per_linkage
def reduced_model_of(press: Linkage) -> ReducedModel:
    """The reduced model of a linkage with one driver, with the slide's position where it has a slide. Raises as `build_reduced_model`."""
    return build_reduced_model(press, [lambda motion: motion.slide_position] if press.slide is not None else [])


def build_reduced_model(
    press: Linkage, coordinates: Sequence[LengthOfMotion], panels: int | None = None, *, angles: bool = False
) -> ReducedModel:
    """The reduced model of a linkage with one driver.

    Args:
        press: the linkage.
        coordinates: lengths of the linkage that the model holds too.
        panels: number of panels of equal width, whether these resolve it or not; by default panels are halved until they do.
        angles: whether some of the coordinates are angles, which may grow by a turn in a period.

    Raises:
        SingularityError: see `Linkage.branch`.
        AssemblyError: see `Linkage.branch`.
        SimulationError: a shaft comes back after more than `MOST_TURNS` turns, or a slide does not come back and a row changes with it.
    """
    branch = press.branch_through_change_points
    period = branch.period
    if period is not None:  # of the loops: a geared shaft that is on no loop may come back later, and its weight with it
        periods = periods_until_back(branch.gain_per_period[[axis.turns for axis in press.axes]])
        if periods is None:
            raise failure("no period", press_name=press.name, most=MOST_TURNS)
        period *= periods
    low, high = (0.0, period) if period is not None else (float(branch.angles[0]), float(branch.angles[-1]))
    turns = (high - low) / (2 * np.pi) if branch.coordinate.turns else 1.0
    # 16 panels a turn resolve most presses at once.
    count = panels or max(2, math.ceil(16 * turns - 1e-9))
    weight = sum(inertia.mass for inertia in list(press.model.inertias)[1:]) * float(np.linalg.norm(press.model.gravity.linear))
    # Weights may balance each other. Then only rounding is left, which must not decide how fine the table is: weights count as at
    # least 1e-6 of what lifting all links by the linkage's size takes.
    measured = _Sizes(len(coordinates), 1e-6 * weight * press.size).missed
    missed = measured if panels is None else lambda values: np.zeros(values.shape[2])
    sampled, points = resolve(lambda angles: sample_rows(press, angles, coordinates), np.linspace(low, high, count + 1), missed)
    gains = np.zeros(COORDINATES + len(coordinates)) if period is None else _gains(press, coordinates, low, period, angles)
    _centre_potential(sampled.coefficients)
    return ReducedModel(sampled.borders, sampled.coefficients, period, gains, points, branch.coordinate)


def _gains(press: Linkage, coordinates: Sequence[LengthOfMotion], start: float, period: float, turning: bool) -> Array:
    """(rows,) by how much the rows of a model grow in a period.

    Raises:
        SimulationError: a slide does not come back, and a row changes otherwise than by a constant.
    """
    if not (press.advancing.any() or turning):
        return np.zeros(COORDINATES + len(coordinates))
    angles, rounding = start + period * np.linspace(0.0, 1.0, 36, endpoint=False), 1e-9  # as a share of the rows
    first, second = (sample_rows(press, angles + moved, coordinates) for moved in (0.0, period))
    gains: Array = (second - first).mean(axis=1)
    gains[np.abs(gains) <= rounding * np.abs(first).max(axis=1)] = 0.0
    far = math.ceil(2 * np.pi * 1000 / period)
    for periods in (1, -far, far):  # far off the length of a spring is linear, but on one side alone
        later = sample_rows(press, angles + periods * period, coordinates)
        size = np.maximum(np.abs(first), np.abs(later)).max(axis=1, keepdims=True)
        if gains[INERTIA] or gains[WEIGHT] or (np.abs(later - first - periods * gains[:, None]) > rounding * size).any():
            raise failure("does not come back", press_name=press.name)
    return gains


class _Sizes:
    """Sizes of the rows of a reduced model over all panels so far, with which the polynomials' last terms are compared."""

    def __init__(self, coordinates: int, least: float) -> None:
        self.scale, self.least = np.zeros(COORDINATES + coordinates), least
        self.lowest, self.highest = np.inf, -np.inf

    def missed(self, values: Array) -> Array:
        """(p,) what polynomials through values (q, rows, p) on p panels miss, as a share of the sizes of the rows."""
        self.scale = np.maximum(self.scale, np.abs(values).max(axis=(0, 2)))
        self.lowest = np.minimum(self.lowest, values[:, POTENTIAL].min())
        self.highest = np.maximum(self.highest, values[:, POTENTIAL].max())
        # The potential energy of a balanced press is constant, and its slope the rounding of the links' parts: both count as at least a
        # thousandth of the energy's size.
        least = max(self.least, 1e-3 * float(max(abs(self.lowest), abs(self.highest))))
        self.scale[WEIGHT] = max(float(self.scale[WEIGHT]), least)
        self.scale[POTENTIAL] = max(float(self.highest - self.lowest), least)
        tail = last_terms(values)
        local = np.abs(values[:, INERTIA]).max(axis=0)  # near a lock the inertia has no bounds
        sizes = np.where(self.scale > 0, self.scale, 1.0)
        return np.asarray(np.maximum((tail / sizes[:, None]).max(axis=0), tail[INERTIA] / np.where(local > 0, local, 1.0)))


def _centre_potential(polynomials: Array) -> None:
    """Make the potential energy of polynomials (p, rows, q) zero in the middle of its range, and throughout where it is constant."""
    values = polynomials[:, POTENTIAL, 0]
    # A range this small, as a share of the energy, is rounding: the press is balanced.
    middle, flat = 0.5 * float(values.min() + values.max()), bool(np.ptp(values) <= 1e-13 * np.abs(values).max())
    polynomials[:, POTENTIAL, 0] -= middle  # its zero is arbitrary, and this one costs no digits
    if flat:
        polynomials[:, [POTENTIAL, WEIGHT]] = 0.0


def sample_rows(press: Linkage, angles: Array, coordinates: Sequence[LengthOfMotion]) -> Array:
    """Rows (rows, n) of the model at crank angles (n,), computed from the linkage."""
    motion = motion_through_change_points(press, angles, 1.0)  # at unit speed rates are derivatives by the crank angle
    kinetic, potential, weight = energies_of_states(press.engine(), motion.states(press))
    return np.array([2 * kinetic, potential, weight, *(coordinate(motion) for coordinate in coordinates)])


def energies(press: Linkage, motion: Motion) -> tuple[Array, Array]:
    """Kinetic energy and potential energy of the weights (n,) of the states of a motion, without flywheel and drive [J]."""
    return energies_of_states(press.engine(), motion.states(press))[:2]


def places_of(model: ReducedModel, row: int, level: float) -> Array:
    """Crank angles in the model's range at which a row passes through a level, in this period or in any other."""
    gain = float(model.gains[row])
    if not gain:
        return model.roots(row, level)
    coefficients = model.coefficients[:, row]
    reach = np.abs(coefficients[:, 1:]).sum(axis=1)
    ends = (level - (coefficients[:, 0] - reach).min()) / gain, (level - (coefficients[:, 0] + reach).max()) / gain
    periods = range(math.floor(min(ends)), math.ceil(max(ends)) + 1)
    return np.concatenate([model.roots(row, level - count * gain) for count in periods])
