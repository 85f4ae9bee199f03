"""Base parameters: the sums of masses and inertias that torque, or shaking force, determines without anything known before.

Columns of the equations that depend on each other belong to parameters that are known together only (Gautier 1991). The sums are found over
a period at speeds and accelerations that have nothing to do with each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...common.quantities import Array
from ..regressor import ABSENT, InertialEquations

DEPENDENT = 1e-9  # share of a column that is left beside others below which it depends on them
SHOWN = 1e-6  # share of the largest term of a sum, in the sizes of its parameters, below which a term is rounding
MOTIONS = 8  # states for each parameter, at speeds and accelerations that have nothing to do with each other


class BaseParameters(NamedTuple):
    """Sums of parameters that are known together.

    Attributes:
        matrix: (sums, parameters): sums are this matrix times the parameters.
        names: of the sums, in words.
        units: of the sums.
        columns: number of parameters that are in the equations at all.
    """

    matrix: Array
    names: tuple[str, ...]
    units: tuple[str, ...]
    columns: int


def base_parameters(equations: InertialEquations, wanted: Sequence[str] = ("torque",)) -> BaseParameters:
    """The sums that quantities determine where speed and acceleration are free; the crank and what is heavy stand before what they hide."""
    columns = generic_columns(equations, wanted)
    sizes = np.linalg.norm(columns, axis=0)
    there = np.flatnonzero(sizes > ABSENT * sizes.max()).tolist()
    crank, kinds = equations.press.link_of(equations.press.driver_indices[0] + 1), ("kg", "kg m", "kg m2")
    named = [(equations.parameters[k].name.rpartition(" moment")[0] == crank, equations.parameters[k]) for k in range(len(sizes))]
    order = sorted(
        there, key=lambda k: (not named[k][0] and named[k][1].name != f"{crank} I", kinds.index(named[k][1].unit), -named[k][1].size)
    )
    chosen = _independent(columns, order)
    matrix = np.zeros((len(chosen), columns.shape[1]))
    # In the sizes of the parameters, so that what is rounding can be told.
    scale = np.array([max(each.size, 1e-300) for each in equations.parameters])
    basis = columns[:, chosen] * scale[chosen]
    others = [k for k in there if k not in chosen]
    if others:
        shares = np.linalg.lstsq(basis, columns[:, others] * scale[others], rcond=None)[0]
        shares[np.abs(shares) < SHOWN * np.maximum(np.abs(shares).max(axis=0), 1.0)] = 0.0
        matrix[:, others] = shares * scale[chosen][:, None] / scale[others]
    matrix[np.arange(len(chosen)), chosen] = 1.0
    names = tuple(_words(equations, row, first) for row, first in zip(matrix, chosen, strict=True))
    return BaseParameters(matrix, names, tuple(equations.parameters[k].unit for k in chosen), len(there))


def generic_columns(equations: InertialEquations, wanted: Sequence[str]) -> Array:
    """(rows, parameters) of quantities over a period at speeds and accelerations that have nothing to do with each other."""
    press, rng = equations.press, np.random.default_rng(0)
    count = MOTIONS * len(equations.parameters)
    low, high = (0.0, 2 * np.pi * (press.turns_until_back or 1)) if press.branch.period else press.branch.angles[[0, -1]] * 0.9
    angle = low + (high - low) * (np.arange(count) + 0.5) / count
    speed, acceleration = rng.uniform(1.0, 3.0, count), rng.uniform(-5.0, 5.0, count)
    found = equations.coefficients(angle, tuple(wanted))
    return np.concatenate([each.columns(speed, acceleration) for each in found.values()])


def _independent(columns: Array, order: Sequence[int]) -> NDArray[np.intp]:
    """Those of the columns, in this order, that do not depend on ones before them."""
    basis, chosen = np.zeros((len(columns), 0)), []
    for k in order:
        left = columns[:, k] / np.linalg.norm(columns[:, k])
        for _ in range(2):
            left = left - basis @ (basis.T @ left)
        if np.linalg.norm(left) > DEPENDENT * 100:
            basis = np.column_stack([basis, left / np.linalg.norm(left)])
            chosen.append(k)
    return np.array(chosen)


def _words(equations: InertialEquations, row: Array, first: int) -> str:
    """A sum in words, its own parameter first."""
    words = equations.parameters[first].name
    for k in np.flatnonzero(row):
        if k != first:
            words += f" {'-' if row[k] < 0 else '+'} {abs(row[k]):.4g} {equations.parameters[k].name}"
    return words
