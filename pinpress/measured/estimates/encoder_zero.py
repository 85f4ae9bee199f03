"""Where the encoder's zero is, roughly, from all turns of the crank by which it may be off: the start of Gauss and Newton's method.

An encoder is zeroed at top dead centre, or wherever it was fastened, while a press is drawn in any pose. The press as described says which
zero fits the records: of those 10 degrees apart the best, and the best near it. Losses, and the size of the torque, are free.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.quantities import Array
from ...dynamics.inverse_dynamics import inverse_dynamics
from ...kinematics.cycle import moved
from ..regressor import slide_rates
from .prior import Losses, Unknowns
from .run_rows import RunEquations, added_masses
from .weak_form import quantities

TRIED = 36  # zeros a turn
STATES = 720  # of a turn, between which the press is linear here
ROUNDING = 1e-10  # share of the largest singular value below which columns are one
EXACT = 0.01  # of the start [rad]
EXPLAINED = 0.5  # share of the torque's squares that is left, above which its size is not judged
NEAR = 0.4  # zeros that are some degrees off [rad]


class _Table(NamedTuple):
    """The press of a run as described over its period, at angles (n,).

    Attributes:
        angles: of the crank [rad].
        period: of the crank [rad].
        values: (6, n) inertia at the crank, its rate, weight, torque of known loads, travel and height of the slide.
    """

    angles: Array
    period: float
    values: Array

    def at(self, angle: Array) -> Array:
        """(6, m) of these."""
        return np.stack([np.interp(angle, self.angles, each, period=self.period) for each in self.values])


class Start(NamedTuple):
    """What the press as described says of the records.

    Attributes:
        about: which angle the encoder shows where the press is as drawn, 0 or so many times 10 degrees [rad].
        zero: a better estimate near it [rad].
        torque: by how much the torque, but for losses, is larger than that of the press as described; 1 where this explains little of it.
    """

    about: float
    zero: float
    torque: float


def likely_starts(unknowns: Unknowns, runs: Sequence[RunEquations]) -> tuple[Start, ...]:
    """Where the encoder's zero may be: some degrees from 0, and elsewhere where the press as described fits better there; 0 where no torque
    was measured in a run, or where the press is not back after some turns."""
    press = unknowns.equations.press
    turns = press.turns_until_back
    if turns is None or not all("torque" in quantities(each.run) for each in runs):
        return (Start(0.0, 0.0, 1.0),)
    tables, step = [_tabulated(each) for each in runs], 2 * np.pi / TRIED
    count = TRIED * turns
    zeros = (np.arange(count) - count // 2) * step
    misfits = np.array([_misfit(tables, runs, zero)[0] for zero in zeros])
    near = np.abs(zeros) < NEAR
    around = float(zeros[near][misfits[near].argmin()])
    found = [_start(tables, runs, around, 0.0)]
    far = float(zeros[int(misfits.argmin())])
    if abs(far) >= NEAR and misfits.min() < misfits[near].min():
        found.append(_start(tables, runs, far, far))
    return tuple(found)


def _start(tables: Sequence[_Table], runs: Sequence[RunEquations], near: float, about: float) -> Start:
    """The best zero near one that was tried."""
    from scipy.optimize import minimize_scalar  # to save start-up time

    ends = (near - 2 * np.pi / TRIED, near + 2 * np.pi / TRIED)
    zero = float(minimize_scalar(lambda zero: _misfit(tables, runs, zero)[0], bounds=ends, options={"xatol": EXACT}).x)
    left, torque = _misfit(tables, runs, zero)
    return Start(about, zero, torque if left < EXPLAINED else 1.0)


def _tabulated(run: RunEquations) -> _Table:
    equations, known = run.unknowns.equations, run.known
    press = equations.press
    turns = press.period_turns or 1
    angles = np.linspace(0.0, 2 * np.pi * turns, STATES * turns, endpoint=False)
    found = equations.coefficients(angles)["torque"]
    values = equations.values + added_masses(equations, run.run)
    inertia, slope, weight = (each @ values for each in found[:3])
    motion = moved(press, press.branch, angles, float(run.smooth.speed.mean()), 0.0, None, press.engine())
    loads = np.zeros(len(angles))
    if known.loads:
        plain, loaded = (inverse_dynamics(press, motion, each, bearings=()).driving_torque for each in ((), known.loads))
        loads = loaded - plain
    return _Table(angles, 2 * np.pi * turns, np.stack([inertia + known.inertia, slope, weight, loads, *slide_rates(press, motion)]))


def _misfit(tables: Sequence[_Table], runs: Sequence[RunEquations], zero: float) -> tuple[float, float]:
    """Share of the squares of the torque that the press as described, times a number, and losses leave; and this number."""
    columns, values = [], []
    for table, each in zip(tables, runs, strict=True):
        smooth = each.smooth
        inertia, slope, weight, loads, rate, height = table.at(smooth.angle - zero)
        inertial = -(smooth.slopes @ (inertia * smooth.speed)) + smooth.weighted @ (weight + loads - 0.5 * slope * smooth.speed**2)
        losses = smooth.weighted @ _losses(each.losses, smooth.speed, rate, height)
        columns.append(np.column_stack([inertial, losses]))
        values.append(smooth.sampled @ quantities(each.run)["torque"])
    whole, target = np.concatenate(columns), np.concatenate(values)
    size = np.linalg.norm(whole, axis=0)
    scaled = whole / np.where(size > 0, size, 1.0)
    solution = np.linalg.lstsq(scaled.T @ scaled, scaled.T @ target, rcond=ROUNDING)[0]
    if solution[0] < 0:  # no masses are negative
        return 1.0, 0.0
    return float(((target - scaled @ solution) ** 2).sum() / (target @ target)), float(solution[0] / size[0]) if size[0] > 0 else 1.0


def _losses(losses: Losses, speed: Array, rate: Array, height: Array) -> Array:
    """(m, k) about what friction and cylinder do."""
    sign = np.sign(speed)
    columns = [sign, speed] if {"crank", "pins"} & set(losses.friction) else []
    columns += [np.abs(rate) * sign] if {"gibs", "slide_guide"} & set(losses.friction) else []
    columns += [rate, rate * height] if losses.cylinder else []
    return np.stack(columns, axis=1) if columns else np.zeros((len(speed), 0))
