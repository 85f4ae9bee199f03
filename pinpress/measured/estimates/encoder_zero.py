"""Approximate zero of the encoder: the start of the Gauss-Newton method.

An encoder is zeroed at top dead centre, or wherever it was fastened, while a press may be described in any pose. The description of the
press shows which zero fits the records. Zeros 10 degrees apart are tried, and the best of them is improved. Losses and a factor on the
torque are fitted too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.quantities import Array
from ...kinematics.cycle import moved
from ..regressor import slide_rates
from .prior import Losses, Unknowns
from .run_rows import RunEquations, added_masses, load_torque
from .weak_form import quantities

NEAR = 0.4  # distance from 0 up to which a zero counts as near 0 [rad]


class Start(NamedTuple):
    """How the described press fits the records.

    Attributes:
        about: reading of the encoder in the drawn pose: 0, or a multiple of 10 degrees [rad].
        zero: a better estimate near it [rad].
        torque: torque without losses / torque of the described press; 1 if the press explains little of the torque.
    """

    about: float
    zero: float
    torque: float


def likely_starts(unknowns: Unknowns, runs: Sequence[RunEquations]) -> tuple[Start, ...]:
    """Likely zeros of the encoder: one near 0, and one elsewhere if the described press fits better there.

    The zero is taken as 0 if a run has no torque, or if the press does not repeat its motion after some turns.
    """
    from scipy.optimize import minimize_scalar  # to save start-up time

    turns = unknowns.equations.press.turns_until_back
    if turns is None or not all("torque" in quantities(each.run) for each in runs):
        return (Start(0.0, 0.0, 1.0),)
    tables, step = [_table(each) for each in runs], 2 * np.pi / 36
    zeros = (np.arange(36 * turns) - 36 * turns // 2) * step
    misfits = np.array([_misfit(tables, runs, zero)[0] for zero in zeros])
    near = np.abs(zeros) < NEAR
    tried = [(float(zeros[near][misfits[near].argmin()]), 0.0)]
    best = float(zeros[misfits.argmin()])
    if abs(best) >= NEAR:
        tried.append((best, best))
    starts = []
    for place, about in tried:
        ends = place - step, place + step
        zero = float(minimize_scalar(lambda zero: _misfit(tables, runs, zero)[0], bounds=ends, options={"xatol": 0.01}).x)
        left, torque = _misfit(tables, runs, zero)
        starts.append(Start(about, zero, torque if left < 0.5 else 1.0))
    return tuple(starts)


class _Table(NamedTuple):
    """The described press over its period, at crank angles (n,).

    Attributes:
        angles: crank angles [rad].
        period: period of the press [rad].
        values: (6, n) inertia at the crank, its rate, weight, torque of known loads, travel and height of the slide.
    """

    angles: Array
    period: float
    values: Array


def _table(run: RunEquations) -> _Table:
    equations = run.unknowns.equations
    press = equations.press
    turns = press.period_turns or 1
    angles = np.linspace(0.0, 2 * np.pi * turns, 720 * turns, endpoint=False)
    coefficients = equations.coefficients(angles)["torque"]
    values = equations.values + added_masses(equations, run.run)
    inertia, slope, weight = (each @ values for each in coefficients[:3])
    speed = float(run.smooth.speed.mean())
    loads = load_torque(press, angles, speed, run.loads) if run.loads else np.zeros(len(angles))
    rates = slide_rates(press, moved(press, press.branch, angles, speed, 0.0, None, press.engine()))
    return _Table(angles, 2 * np.pi * turns, np.stack([inertia + run.drive_inertia, slope, weight, loads, *rates]))


def _misfit(tables: Sequence[_Table], runs: Sequence[RunEquations], zero: float) -> tuple[float, float]:
    """Share of the torque's squares that losses and the described press, times a number, do not explain; and this number."""
    columns, values = [], []
    for table, each in zip(tables, runs, strict=True):
        smooth = each.smooth
        inertia, slope, weight, loads, rate, height = (
            np.interp(smooth.angle - zero, table.angles, values, period=table.period) for values in table.values
        )
        inertial = -(smooth.slopes @ (inertia * smooth.speed)) + smooth.weighted @ (weight + loads - 0.5 * slope * smooth.speed**2)
        columns.append(np.column_stack([inertial, smooth.weighted @ _losses(each.losses, smooth.speed, rate, height)]))
        values.append(smooth.sampled @ quantities(each.run)["torque"])
    whole, target = np.concatenate(columns), np.concatenate(values)
    size = np.linalg.norm(whole, axis=0)
    scaled = whole / np.where(size > 0, size, 1.0)
    solution = np.linalg.lstsq(scaled.T @ scaled, scaled.T @ target, rcond=1e-10)[0]
    if solution[0] < 0:  # a negative factor would mean negative masses
        return 1.0, 0.0
    return float(((target - scaled @ solution) ** 2).sum() / (target @ target)), float(solution[0] / size[0]) if size[0] > 0 else 1.0


def _losses(losses: Losses, speed: Array, rate: Array, height: Array) -> Array:
    """(m, k) approximate torques of friction and cylinder."""
    sign = np.sign(speed)
    columns = [sign, speed] if {"crank", "pins"} & set(losses.friction) else []
    columns += [np.abs(rate) * sign] if {"gibs", "slide_guide"} & set(losses.friction) else []
    columns += [rate, rate * height] if losses.cylinder else []
    return np.stack(columns, axis=1) if columns else np.zeros((len(speed), 0))
