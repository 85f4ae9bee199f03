"""Base parameters: the sums of masses and inertias that torque, or shaking force, determines without a prior.

Parameters whose columns in the equations depend on each other are known only together (Gautier 1991). The sums are found from states over a
period whose speeds and accelerations are independent of each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...common.quantities import Array
from ..regressor import InertialEquations


class BaseParameters(NamedTuple):
    """Sums of parameters that are known together.

    Attributes:
        matrix: (sums, parameters) from the parameters to the sums.
        names: the sums as text.
        units: units of the sums.
        columns: number of parameters that occur in the equations.
    """

    matrix: Array
    names: tuple[str, ...]
    units: tuple[str, ...]
    columns: int


def base_parameters(equations: InertialEquations, wanted: Sequence[str] = ("torque",)) -> BaseParameters:
    """The sums that these quantities determine if speed and acceleration can be chosen freely.

    A sum is named by its first parameter: one of the crank if possible, otherwise the heaviest.
    """
    parameters, columns = equations.parameters, _independent_states(equations, wanted)
    sizes = np.linalg.norm(columns, axis=0)
    present = np.flatnonzero(sizes > 1e-12 * sizes.max()).tolist()
    crank, kinds = equations.press.link_of(equations.press.driver_indices[0] + 1), ("kg", "kg m", "kg m2")

    def rank(k: int) -> tuple[bool, int, float]:
        name = parameters[k].name
        of_crank = name.rpartition(" moment")[0] == crank or name == f"{crank} I"
        return not of_crank, kinds.index(parameters[k].unit), -parameters[k].size

    basis, chosen = np.zeros((len(columns), 0)), list[int]()
    for k in sorted(present, key=rank):
        rest = columns[:, k] / sizes[k]
        for _ in range(2):  # the second time for rounding errors
            rest = rest - basis @ (basis.T @ rest)
        if np.linalg.norm(rest) > 1e-7:  # otherwise it depends on the columns before it
            basis = np.column_stack([basis, rest / np.linalg.norm(rest)])
            chosen.append(k)

    # Terms below 1e-6 of the largest are rounding errors, if each parameter is divided by its size.
    scale = np.array([max(each.size, 1e-300) for each in parameters])
    matrix = np.zeros((len(chosen), len(parameters)))
    others = [k for k in present if k not in chosen]
    if others:
        shares = np.linalg.lstsq(columns[:, chosen] * scale[chosen], columns[:, others] * scale[others], rcond=None)[0]
        shares[np.abs(shares) < 1e-6 * np.maximum(np.abs(shares).max(axis=0), 1.0)] = 0.0
        matrix[:, others] = shares * scale[chosen][:, None] / scale[others]
    names = []
    for first, row in zip(chosen, matrix, strict=True):
        terms = [f" {'-' if row[k] < 0 else '+'} {abs(row[k]):.4g} {parameters[k].name}" for k in np.flatnonzero(row)]
        names.append(parameters[first].name + "".join(terms))
        row[first] = 1.0
    return BaseParameters(matrix, tuple(names), tuple(parameters[k].unit for k in chosen), len(present))


def _independent_states(equations: InertialEquations, wanted: Sequence[str]) -> Array:
    """(rows, parameters) of the quantities in eight states for each parameter over a period, with random speeds and accelerations."""
    press, rng = equations.press, np.random.default_rng(0)
    count = 8 * len(equations.parameters)
    low, high = (0.0, 2 * np.pi * (press.turns_until_back or 1)) if press.branch.period else press.branch.angles[[0, -1]] * 0.9
    angle = low + (high - low) * (np.arange(count) + 0.5) / count
    speed, acceleration = rng.uniform(1.0, 3.0, count), rng.uniform(-5.0, 5.0, count)
    coefficients = equations.coefficients(angle, tuple(wanted))
    return np.concatenate([each.columns(speed, acceleration) for each in coefficients.values()])
