"""The linkage reduced to its crank, one state at a time: what `reduced` tabulates, for integration over time."""

import math
from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..common.arrays import Array
from .reduced_model import COORDINATES, INERTIA, WEIGHT, Table, horner

SLACK = 1e-6  # beyond the table, by rounding of many turns [rad]


class Instant(NamedTuple):
    """A state of the crank: angle, speed; coordinates with their rates; inertia I, I', V'; derivatives c' of the coordinates."""

    angle: float
    speed: float
    coordinates: list[tuple[float, float]]
    inertia: float
    inertia_slope: float
    weight: float
    levers: list[float]


class CrankAlone:
    """`machine.Dynamics` of one position, the crank angle. Plain numbers: for one state NumPy takes longer."""

    size, crank, alone = 1, 0, True

    def __init__(self, table: Table) -> None:
        self.table = table
        self.borders = table.borders.tolist()
        falling = table.coefficients[:, :, ::-1].tolist()  # powers of x
        # of V' the value alone is needed, of V nothing
        self.rows = [(panel[WEIGHT], [panel[INERTIA], *panel[COORDINATES:]]) for panel in falling]

    def at(self, position: Array, speed: Array) -> Instant:
        angle, rate = float(position[0]), float(speed[0])
        borders, period = self.borders, self.table.period
        local = angle
        if period is not None:
            local -= (angle - borders[0]) // period * period
        if not borders[0] - SLACK <= local <= borders[-1] + SLACK:
            count = self.table.coefficients.shape[1] - COORDINATES  # an integrator looks ahead: it shall try a shorter step
            return Instant(angle, rate, [(math.nan, math.nan)] * count, math.nan, math.nan, math.nan, [math.nan] * count)
        panel = min(max(bisect_right(borders, local) - 1, 0), len(borders) - 2)
        half = 0.5 * (borders[panel + 1] - borders[panel])
        x = (local - borders[panel]) / half - 1.0
        weights, rows = self.rows[panel]
        weight, values, slopes = horner(weights, x), [], []
        for row in rows:
            value = slope = 0.0
            for coefficient in row:
                slope = slope * x + value
                value = value * x + coefficient
            values.append(value)
            slopes.append(slope / half)
        levers = slopes[1:]
        coordinates = [(value, lever * rate) for value, lever in zip(values[1:], levers, strict=True)]
        return Instant(angle, rate, coordinates, values[0], slopes[0], weight, levers)

    def accelerations(self, instant: Instant, torque: float, forces: Sequence[float], inertia: float) -> float:
        total = instant.inertia + inertia
        if not total > 0:  # no mass resists: an integrator shall try a shorter step
            return math.nan
        for row, force in enumerate(forces):
            torque += force * instant.levers[row]
        return (torque - instant.weight - 0.5 * instant.inertia_slope * instant.speed * instant.speed) / total

    def of_crank(self, accelerations: float) -> float:
        return float(np.ravel(accelerations)[0])

    def stands(self, instant: Instant, time: float) -> None:
        return None

    def moved(self, position: Array, angle: float) -> tuple[Array, Array]:
        return position + angle, np.array([1.0 if angle > 0 else -1.0])

    def project(self, position: Array, speed: Array) -> None:
        return None

    def closed(self, position: Array, speed: Array) -> tuple[Array, Array]:
        return position, speed
