"""What records can determine of a press: the sums that torque and shaking force determine, and the accuracy of each parameter.

print(pp.measured.identifiability(press, runs, friction=("crank", "gibs"), cylinder=True))
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..common import tables
from ..common.arguments import number, typed
from ..common.errors import PinpressError
from ..common.quantities import Array
from ..common.results import Record, Records, Tabular
from ..engines.planar.engine import PlanarEngine
from ..linkage.linkage import Linkage
from .estimates.base_parameters import base_parameters
from .estimates.least_squares import VAGUE
from .estimates.prior import NOTHING, Losses, Unknowns, unknowns_of
from .estimates.run_rows import TURN, loss_rows
from .estimates.weak_form import smoothed
from .identification import checked_radii, checked_runs
from .records import MeasuredRun
from .regressor import SHAKING, refuse_losses


@dataclass(frozen=True, repr=False)
class LearntParameter(Record):
    """How well records determine a parameter.

    Attributes:
        name: name of the parameter.
        torque: standard deviation after / before the measurement of torques: 0 fully known, 1 nothing learnt. A loss has no deviation
            before; its value here is its deviation / loss that alone gives the press's rms torque.
        shaking: the same ratio if shaking force and moment are measured too.
    """

    name: str
    torque: float
    shaking: float


@dataclass(frozen=True, eq=False, repr=False)
class IdentifiableParameters(Tabular):
    """The parameters of a press that records can determine.

    Attributes:
        press_name: name of the press.
        columns_in_torque: number of masses and inertias that the torque depends on.
        rank: number of their sums that the torque determines at changing speed.
        columns_in_shaking: number of masses and inertias that torque, shaking force and moment depend on.
        shaking_rank: number of their sums that torque, shaking force and moment determine.
        sums: the sums that the torque determines, as text.
        parameters: how well these runs determine each parameter.
        learnt: number of parameters that the torque determines: trace of information / (information + prior) [-].
        shaking_learnt: number of parameters that torque, shaking force and moment determine [-].
    """

    press_name: str
    columns_in_torque: int
    rank: int
    columns_in_shaking: int
    shaking_rank: int
    sums: tuple[str, ...]
    parameters: Records[LearntParameter]
    learnt: float
    shaking_learnt: float

    @property
    def title(self) -> str:
        return (
            f"IdentifiableParameters of {self.press_name}: torque determines {self.rank} sums of {self.columns_in_torque} masses and"
            f" inertias, with shaking force and moment {self.shaking_rank} of {self.columns_in_shaking}"
        )

    def columns(self) -> dict[str, tables.Column]:
        """The parameters as columns."""
        return self.parameters.columns()


@typed
def identifiability(
    press: Linkage,
    runs: Sequence[MeasuredRun] = (),
    *,
    prior: float | Mapping[str, float] = 0.2,
    known: Mapping[str, tuple[float, float]] = NOTHING,
    friction: Sequence[str] = ("crank", "slide_guide"),
    cylinder: bool = False,
    radii: Mapping[str, float] | None = None,
    noise: float = 0.01,
) -> IdentifiableParameters:
    """Find which masses, inertias and losses of a press records can determine: by torque, and by torque with shaking force.

    Args:
        press: the press as described, with one crank.
        runs: records; only their times and angles are used, so ``MeasuredRun(time, angle)`` is enough for planned runs. Without runs
            only the sums are found.
        prior: as for `identify`.
        known: as for `identify`.
        friction: as for `identify`.
        cylinder: as for `identify`.
        radii: as for `identify`.
        noise: standard deviation of one sample / largest torque, force or moment of the press in these runs [-].

    Raises:
        PinpressError: as for `identify`, except that runs need no torque; the noise is not positive.
        UnknownNameError: a link, pin or kind of friction does not exist.
    """
    refuse_losses(press, friction, cylinder)
    losses = Losses(tuple(friction), cylinder, checked_radii(press, radii))
    unknowns = unknowns_of(press, prior, losses, known)
    share = number("noise", noise, positive=True)
    if share < 1e-9:  # rounding errors would dominate
        raise PinpressError(f"noise is {share:g}: give it as a share of the largest measured torque, such as 0.01")
    records = checked_runs(press, runs, for_torque=False) if len(runs) else []
    shaking = shaking_quantities(press)
    alone = base_parameters(unknowns.equations)
    beside = base_parameters(unknowns.equations, ("torque", *shaking))
    parameters, learnt = [], (0.0, 0.0)
    if records:
        doubts, learnt = _learnt(unknowns, records, losses, share, shaking)
        parameters = [LearntParameter(each.name, *pair) for each, pair in zip(unknowns.parameters, doubts, strict=True) if pair is not None]
    return IdentifiableParameters(
        press.name, alone.columns, len(alone.names), beside.columns, len(beside.names), alone.names,
        Records(LearntParameter, parameters), *learnt,
    )  # fmt: skip


def shaking_quantities(press: Linkage) -> tuple[str, ...]:
    """Forces and moments on the foundation that contain information about a press; for a planar press, those in its plane."""
    engine = press.engine()
    if not isinstance(engine, PlanarEngine):
        return SHAKING
    normal = np.abs(engine.plane.normal)
    forces = [f"force {axis}" for axis, part in zip("xyz", normal, strict=True) if part < 1 - 1e-9]
    return (*forces, *(f"moment {axis}" for axis, part in zip("xyz", normal, strict=True) if part > 1 - 1e-12))


def _learnt(
    unknowns: Unknowns, runs: Sequence[MeasuredRun], losses: Losses, share: float, shaking: Sequence[str]
) -> tuple[list[tuple[float, float] | None], tuple[float, float]]:
    """Uncertainties of all unknowns by torque alone and with shaking force, None for fixed unknowns; and the numbers of parameters
    determined in both cases."""
    equations, inertial, count = unknowns.equations, unknowns.inertial, len(unknowns.parameters)
    parts: dict[str, list[Array]] = {name: [] for name in ("torque", *shaking)}
    largest = dict.fromkeys(parts, 0.0)
    for run in runs:
        smooth = smoothed(run)
        here, ahead, behind = (equations.coefficients(smooth.angle - turn, tuple(parts)) for turn in (0.0, TURN, -TURN))
        for name, coefficients in here.items():
            rows = np.zeros((smooth.weighted.shape[0], count))
            rows[:, :inertial] = smooth.equations(coefficients)
            rows[:, -1] = (smooth.equations(ahead[name]) - smooth.equations(behind[name])) @ equations.values / (2 * TURN)
            if name == "torque":
                rows[:, inertial:-1] = loss_rows(equations.press, smooth, losses)
            parts[name].append(rows if name == "torque" else smooth.without_offset(rows))
            values = coefficients.columns(smooth.speed, smooth.acceleration) @ equations.values
            largest[name] = max(largest[name], float(np.abs(values).max()))
    rows_of = {name: np.concatenate(each) for name, each in parts.items()}

    rms = float(np.sqrt(((rows_of["torque"][:, :inertial] @ equations.values) ** 2).mean()))
    weight = np.sqrt((rows_of["torque"] ** 2).mean(axis=0)) / rms
    priors = unknowns.deviation
    vague = ~np.isfinite(priors)
    sizes = np.where(vague, np.divide(1, weight, out=np.zeros(count), where=weight > 0), priors)
    spread = unknowns.scaled(sizes[inertial:])
    moving = np.abs(spread).max(axis=0) > 0
    spread = spread[:, moving]
    weighed = unknowns.weighed @ spread
    before = np.diag(np.where(vague, VAGUE, 1.0)[moving] ** -2) + weighed.T @ weighed
    information, doubts, learnt = before, [], []
    for names in (("torque",), tuple(shaking)):
        for name in names:
            scaled = rows_of[name] @ spread / (share * largest[name])
            information = information + scaled.T @ scaled
        covariance = np.linalg.inv(information)
        learnt.append(float(np.trace(np.eye(len(before)) - covariance @ before)))
        doubts.append(np.sqrt(np.diag(spread @ covariance @ spread.T)) / np.where(sizes > 0, sizes, 1.0))
    pairs = [(float(a), float(b)) for a, b in zip(*doubts, strict=True)]
    return [pair if size > 0 else None for pair, size in zip(pairs, sizes, strict=True)], (learnt[0], learnt[1])
