"""Stiffness and damping of the mounts of a press, fitted to measured natural frequencies.

    fitted = pp.measured.fit_mounts(system, record.modes(beside=pp.foundation.modes(system)))
    pp.foundation.modes(fitted.system)

A catalogue does not give the dynamic stiffness of rubber well: it may be off by a factor of two. Each measured frequency and damping
ratio is an equation for the loss and for factors on the stiffness along x, y and z. All mounts share these factors, and so do all columns
of a frame in two parts. Bounded least squares in the logarithms of the factors solve the equations; the model is that of `foundation`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..common.arguments import expect, typed
from ..common.errors import PinpressError, caution, shown
from ..common.numerics import pair_modes
from ..common.quantities import Array
from ..common.results import Tabular
from ..common.tables import Column
from ..foundation.mounted_press import MountedPress, modes, with_mounts
from ..foundation.mounts import Mount
from .hit_modes import MeasuredModes

UNSEEN = 3.0  # the modes do not determine a stiffness if highest / lowest end of its interval is larger
DAMPING = ("loss_factor", "viscous")
BY_MODE = ("natural_frequency", "natural_frequency_deviation", "damping_ratio", "damping_ratio_deviation", "energy_share", "mac")


@dataclass(frozen=True, eq=False, repr=False)
class FittedMounts(Tabular):
    """Mounts fitted to measured natural frequencies by `fit_mounts`. All arrays are read-only.

    Attributes:
        system: the press on these mounts.
        names: names of the k fitted values: "stiffness of mounts along x", ..., "loss factor of mounts".
        values: (k,) factors on the given stiffness or viscous dampers; a loss factor is the value itself [-].
        intervals: (k, 2) lowest and highest value at 95 %, the wider of the intervals from noise and from the residual [-].
        measured: the measured modes.
        frequency: (m,) natural frequencies of the fitted system, in the order of the measured modes [rad/s].
        damping_ratio: (m,) damping ratios of the fitted system, in the order of the measured modes [-].
    """

    system: MountedPress
    names: tuple[str, ...]
    values: Array
    intervals: Array
    measured: MeasuredModes
    frequency: Array
    damping_ratio: Array

    @property
    def title(self) -> str:
        off = np.abs(self.frequency / self.measured.natural_frequency - 1).max()
        return f"FittedMounts of {self.system.press.name}: {len(self.names)} values, frequencies to {100 * off:.2g} %"

    def columns(self) -> dict[str, Column]:
        """A row for each fitted value: name, value, and both ends of its interval."""
        return {"name": list(self.names), "value [-]": self.values, "low [-]": self.intervals[:, 0], "high [-]": self.intervals[:, 1]}


@typed
def fit_mounts(system: MountedPress, measured: MeasuredModes, *, damping: str = "loss_factor") -> FittedMounts:
    """Fit stiffness and damping of the mounts of a press to measured modes.

    The stiffnesses along x, y and z get one factor each, the same for all mounts and the same for all columns of a frame in two parts.
    A given static stiffness of the mounts does not change.

    Args:
        system: the press on the mounts as described.
        measured: modes from hits, compared with the modes of this system: ``record.modes(beside=foundation.modes(system))``.
        damping: "loss_factor" (one loss factor for all mounts, one for all columns) or "viscous" (a factor on their dampers).

    Raises:
        PinpressError: the measured modes were not compared with those of the system, there are fewer frequencies than stiffnesses, or the
            mounts have no dampers.

    Warns:
        PinpressWarning: a value reaches its bound, because the model cannot have the measured frequencies.
    """
    expect("measured", measured, MeasuredModes, "vibration(...).modes(beside=...)")
    if not isinstance(damping, str) or damping not in DAMPING:
        raise PinpressError(f"damping is {shown(damping)}: give one of {', '.join(DAMPING)}")
    if measured.beside is None or len(measured.beside.shapes) != len(system.mass):
        raise PinpressError("the measured modes are not compared with those of this system: write modes(beside=foundation.modes(system))")
    from scipy.optimize import least_squares  # slow to import
    from scipy.stats import t as student

    partner = np.array(measured.partner)
    seen = np.flatnonzero(partner >= 0)
    names, start, low, high = _unknowns(system, damping)
    count = 3 if system.crown is None else 6
    if len(seen) < count:
        raise PinpressError(
            f"{len(seen)} measured modes have a calculated partner, for {count} stiffnesses: hit the frame in other directions too"
        )
    seen_modes = replace(
        measured,
        partner=tuple(partner[seen].tolist()),
        shapes=measured.shapes[:, seen],
        **{name: getattr(measured, name)[seen] for name in BY_MODE},
    )
    frequency, ratio = seen_modes.natural_frequency, seen_modes.damping_ratio
    # the model of a rigid frame has errors too, taken as 1e-3 of a frequency and 1e-3 in a damping ratio
    scatter = np.hypot(seen_modes.natural_frequency_deviation / frequency, 1e-3)
    scatter_of_ratio = np.hypot(seen_modes.damping_ratio_deviation, 1e-3)
    shapes = measured.beside.shapes[:, partner[seen]]

    def calculated(logarithms: Array) -> tuple[Array, Array]:
        """Frequencies and damping ratios of the modes whose shapes are nearest to those of the calculated partners."""
        changed = modes(_changed(system, names, np.exp(logarithms)))
        mine, theirs = pair_modes((changed.shapes.T @ system.mass @ shapes) ** 2)
        places = mine[np.argsort(theirs)]
        return changed.natural_frequency[places], changed.damping_ratio[places]

    def residual(logarithms: Array) -> Array:
        ours, damped = calculated(logarithms)
        return np.concatenate([np.log(ours / frequency) / scatter, (damped - ratio) / scatter_of_ratio])

    best = least_squares(residual, start, bounds=(low, high), x_scale=0.1, diff_step=1e-4)
    freedom = max(len(best.fun) - len(names), 1)
    information = best.jac.T @ best.jac
    deviation = np.sqrt(max(1.0, 2 * best.cost / freedom) * np.diag(np.linalg.pinv(information, hermitian=True)))
    deviation[np.diag(information) < 1e-12] = np.inf
    half = float(student.ppf(0.975, freedom)) * deviation
    intervals = np.exp(np.clip(best.x[:, None] + np.array([-1.0, 1.0]) * half[:, None], low[:, None], high[:, None]))
    for name, logarithm, bounds in zip(names, best.x, np.column_stack([low, high]), strict=True):
        if np.abs(logarithm - bounds).min() < 1e-3:
            caution(f"{name} reaches its bound, {np.exp(logarithm):.4g}: the model cannot have the measured frequencies. Check the masses")
    values = np.exp(best.x)
    return FittedMounts(_changed(system, names, values), names, values, intervals, seen_modes, *calculated(best.x))


def _unknowns(system: MountedPress, damping: str) -> tuple[tuple[str, ...], Array, Array, Array]:
    """Names of the unknowns, first estimates of their logarithms, and the bounds of these."""
    rows: list[tuple[str, float, float, float]] = []
    factor = 1.0, 1 / 20, 20.0
    for what, springs in (("mounts", system.mounts), ("columns", system.uprights)):
        if not springs:
            continue
        for i, axis in enumerate("xyz"):
            if any(spring.stiffness[i] > 0 for spring in springs):
                rows.append((f"stiffness of {what} along {axis}", *factor))
        if damping == "loss_factor":
            loss = float(np.clip(np.mean([spring.loss_factor for spring in springs]), 0.01, 0.5))
            rows.append((f"loss factor of {what}", loss, 1e-4, 1.0))
        elif any(np.any(spring.damping) for spring in springs):
            rows.append((f"dampers of {what}", *factor))
        else:
            raise PinpressError(f"the {what} have no dampers: give Mount(damping=...), or damping='loss_factor'")
    names, *numbers = zip(*rows, strict=True)
    start, low, high = np.log(np.array(numbers))
    return tuple(map(str, names)), start, low, high


def _changed(system: MountedPress, names: tuple[str, ...], values: Array) -> MountedPress:
    """The system with changed springs."""
    changes = dict(zip(names, values.tolist(), strict=True))

    def spring(one: Mount, what: str) -> Mount:
        stiffness = tuple(k * changes.get(f"stiffness of {what} along {axis}", 1.0) for k, axis in zip(one.stiffness, "xyz", strict=True))
        dampers = tuple(c * changes.get(f"dampers of {what}", 1.0) for c in one.damping)
        return replace(one, stiffness=stiffness, damping=dampers, loss_factor=changes.get(f"loss factor of {what}", one.loss_factor))

    mounts = [spring(one, "mounts") for one in system.mounts]
    return with_mounts(replace(system, uprights=tuple(spring(one, "columns") for one in system.uprights)), mounts)
