"""The cheapest tolerances that keep targets for the scatter of the dead centres, with a proof.

A dimension with the tolerance t_i costs k_i T_i / t_i: k_i at its present tolerance T_i, and 2 k_i at half of T_i. The variance of a
quantity with gradient g is sum (g_i r_i t_i)^2, where r_i is standard deviation / tolerance of the dimension. The program minimises the sum
of k_i T_i s_i with a cone s_i t_i >= 1 for each dimension and one cone for each target. It is convex, and its dual solution proves the
optimum. With one target and no active bound, t_i is proportional to (k_i T_i / (g_i r_i)^2)^(1/3).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..common import plausibility, tables
from ..common.arguments import number, positive, suitable_numbers, typed
from ..common.conic_program import AT_MOST, CONE, PROVED, InfeasibleError, Optimum, Rows, minimise
from ..common.errors import PinpressError, shown
from ..common.quantities import Array
from ..common.results import Tabular
from ..common.tables import Column
from ..kinematics.motion import Motion
from ..linkage.linkage import Linkage, OfPress
from .dead_centre_scatter import dead_centre_gradients
from .dimensions import Dimension, check_dimensions, correlation_matrix, refuse_unknown, root_of

QUANTITIES = ("height", "top", "stroke")
SLACK = 1e-6  # relative distance below which a target counts as used up, and a tolerance as equal to its bound


@dataclass(frozen=True, eq=False, repr=False)
class AllocatedTolerances(OfPress, Tabular):
    """The cheapest tolerances of k dimensions. All arrays are read-only.

    Attributes:
        press_name: name of the press.
        parts: the k dimensions with the new tolerances, for `bottom_dead_centre`.
        before: (k,) the tolerances before [m, of an angle rad].
        bounds: (k, 2) smallest and largest tolerances [m or rad].
        costs: (k,) costs of the dimensions [unit of the given costs].
        value: cost of all dimensions.
        bound: lower bound of the cost of all tolerances that keep bounds and targets, from the dual solution.
        cost_before: cost of the tolerances before, even if they miss the targets.
        cost_alike: cost if one factor changes all tolerances until the targets are kept; None if a tolerance would leave its bounds.
        targets: quantity -> largest permitted deviation [m].
        reached: quantity -> deviation with the new tolerances, the chosen number of standard deviations [m].
        prices: quantity -> by how much the cost falls for each metre by which its target grows [unit of the costs per m].
    """

    _press: Linkage
    parts: tuple[Dimension, ...]
    before: Array
    bounds: Array
    costs: Array
    value: float
    bound: float
    cost_before: float
    cost_alike: float | None
    targets: Mapping[str, float]
    reached: Mapping[str, float]
    prices: Mapping[str, float]

    @property
    def tolerances(self) -> Array:
        """(k,) the tolerances [m or rad]."""
        return np.array([part.tolerance for part in self.parts])

    @property
    def gap(self) -> float:
        """(value - bound) / value: no permitted tolerances cost less by more than this share [-]."""
        return max(self.value - self.bound, 0.0) / self.value

    @property
    def title(self) -> str:
        return f"AllocatedTolerances of {self.press_name}: cost {tables.cell(self.value)}, proved to {max(self.gap, PROVED):.1g}"

    def columns(self) -> dict[str, Column]:
        """The dimensions with their tolerances and costs as (k,) columns."""
        return {
            "dimension": [part.name for part in self.parts],
            "unit": [part.unit for part in self.parts],
            "tolerance": self.tolerances,
            "before": self.before,
            "smallest": self.bounds[:, 0],
            "largest": self.bounds[:, 1],
            "cost": self.costs,
        }


@typed
def allocate(
    press: Linkage,
    parts: Sequence[Dimension],
    cost: Mapping[str, float] | None,
    targets: Mapping[str, float],
    bounds: Mapping[str, Sequence[float]] | None = None,
    *,
    deviations: float = 3.0,
    motion: Motion | None = None,
    correlation: Mapping[tuple[str, str], float] | None = None,
) -> AllocatedTolerances:
    """Find the cheapest tolerances that keep targets for the dead centres: `allocate(press, parts, None, {"height": 50e-6})`.

    A tolerance of half the width costs twice as much. The shape of a distribution stays: standard deviation and measured deviations change
    in proportion to the tolerance. Only the scatter counts, not the mean of measured deviations.

    Args:
        press: a press with nominal dimensions, in a plane or in space.
        parts: the dimensions with their present tolerances.
        cost: name of a dimension -> its cost at the present tolerance, in any unit; other dimensions cost 1. None: all cost 1.
        targets: "height" (bottom dead centre), "top" or "stroke" -> largest deviation, in both directions [m].
        bounds: name of a dimension -> smallest and largest tolerance [m, of an angle rad]; by default a tenth and ten times the present
            tolerance.
        deviations: number of standard deviations within a target [-]; 3 are 99.73 % of the presses if the quantity is normal.
        motion: as in `bottom_dead_centre`.
        correlation: as in `bottom_dead_centre`.

    Raises:
        PinpressError: there is no target, the smallest tolerances miss a target (the message names by how much), bounds do not rise, or a
            cost or target is not positive; also as `bottom_dead_centre`.
        UnknownNameError: a dimension or quantity does not exist.
    """
    checked = check_dimensions(press, parts)
    tied = correlation_matrix(checked, correlation)
    present = np.array([part.tolerance for part in checked])
    names = [part.name for part in checked]
    by_names = (("cost", "dimension", cost, names), ("targets", "quantity", targets, QUANTITIES), ("bounds", "dimension", bounds, names))
    for argument, kind, given, known in by_names:
        if given is not None and not isinstance(given, Mapping):
            raise PinpressError(f"{argument} is {shown(given)}: give a mapping with names of a {kind}, e.g. {{{known[0]!r}: ...}}")
        for name in given or {}:
            refuse_unknown(kind, name, known)
    prices = np.array([number(f"cost of {name}", (cost or {}).get(name, 1.0), positive=True) for name in names])
    limits = {name: number(f"target of {name}", value, "m", positive=True) for name, value in targets.items()}
    if not limits:
        raise PinpressError(f"targets is empty: give one or more of {', '.join(QUANTITIES)}, e.g. {{'height': 50e-6}}")
    for name, limit in limits.items():
        plausibility.target(f"target of {name}", limit, press.size)
    ends, sure = _bounds(checked, bounds or {}), positive("deviations", deviations, "-", 100.0)

    bottom, top = dead_centre_gradients(press, checked, motion)
    gradients = {"height": bottom, "top": top, "stroke": top - bottom}
    ratios = np.array([part.standard_deviation for part in checked]) / present
    root = root_of(tied)
    spreads = {name: sure * root * (gradients[name] * ratios * present) / limit for name, limit in limits.items()}
    if not correlation:
        _refuse_missed(checked, limits, spreads, ends[:, 0] / present)

    optimum = _minimise_cost(prices / prices.sum(), list(spreads.values()), ends / present[:, None], limits)
    factors = np.clip(optimum.x[: len(checked)], *(ends / present[:, None]).T)
    chosen = tuple(_with_tolerance(part, float(factor)) for part, factor in zip(checked, factors, strict=True))
    reached = {name: limit * float(np.linalg.norm(spreads[name] @ factors)) for name, limit in limits.items()}
    costs, scale = prices / factors, float(prices.sum())
    # The first dual variable of a target's cone is what a share more of the target saves.
    last = optimum.prices[-len(limits) :]
    saved = {name: scale * float(dual[0]) / limit for (name, limit), dual in zip(limits.items(), last, strict=True)}
    used = max(float(np.linalg.norm(spread.sum(axis=1))) for spread in spreads.values())
    alike = 1.0 / used if used else 1.0
    inside = ((ends[:, 0] <= alike * present) & (alike * present <= ends[:, 1])).all()
    return AllocatedTolerances(
        press,
        chosen,
        present,
        ends,
        costs,
        float(costs.sum()),
        scale * optimum.bound,
        scale,
        scale / alike if inside else None,
        limits,
        reached,
        saved,
    )


def _bounds(parts: Sequence[Dimension], bounds: Mapping[str, Sequence[float]]) -> Array:
    """Smallest and largest tolerances (k, 2) [m or rad]."""
    ends = np.array([[0.1 * part.tolerance, 10.0 * part.tolerance] for part in parts])
    for k, part in enumerate(parts):
        if part.name in bounds:
            wanted = f"smallest and largest tolerance [{part.unit}], positive and rising"
            rising = lambda given: (given[0] > 0) & (given[1] > given[0])  # noqa: E731
            ends[k] = suitable_numbers(f"bounds of {part.name}", bounds[part.name], wanted, (2,), rising)
    return ends


def _refuse_missed(parts: Sequence[Dimension], limits: Mapping[str, float], spreads: Mapping[str, Array], smallest: Array) -> None:
    """Raise PinpressError if the smallest tolerances miss a target."""
    missed = []
    for name, limit in limits.items():
        least = limit * float(np.linalg.norm(spreads[name] @ smallest))
        if least > limit:
            part = parts[int(np.argmax(np.linalg.norm(spreads[name] * smallest, axis=0)))]
            by = 1e6 * (least - limit)
            missed.append(
                f"{name} misses its target of {1e6 * limit:.4g} um by {by:.4g} um with the smallest tolerances; {part.name} adds most"
            )
    if missed:
        raise PinpressError(f"{'; '.join(missed)}: give smaller lower bounds, or larger targets")


def _minimise_cost(prices: Array, spreads: Sequence[Array], ends: Array, limits: Mapping[str, float]) -> Optimum:
    """The optimum in the factors u of the present tolerances and s >= 1 / u.

    Args:
        prices: (k,) shares of the cost.
        spreads: a matrix (k, k) for each target: the length of its product with u is the used share of the target.
        ends: (k, 2) smallest and largest factors.
        limits: targets, for messages.
    """
    count = len(prices)
    unit, none = np.eye(count), np.zeros((count, count))
    rows = [
        Rows(AT_MOST, np.hstack([unit, none]) / ends[:, 1:], np.ones(count)),
        Rows(AT_MOST, np.hstack([-unit, none]) / ends[:, :1], -np.ones(count)),
    ]
    for k in range(count):
        u, s = np.hstack([unit[k], none[k]]), np.hstack([none[k], unit[k]])
        rows.append(Rows(CONE, -np.array([u + s, 0.0 * u, s - u]), np.array([0.0, 2.0, 0.0])))
    for spread in spreads:
        coefficients = np.vstack([np.zeros(2 * count), np.hstack([-spread, none])])
        rows.append(Rows(CONE, coefficients, np.hstack([1.0, np.zeros(count)])))
    remedy = (
        f"costs differ by a factor of {prices.max() / prices.min():.2g}, and bounds by a factor of"
        f" {(ends[:, 1] / ends[:, 0]).max():.2g}: give costs and bounds that differ less"
    )
    try:
        return minimise(np.hstack([np.zeros(count), prices]), rows, remedy=remedy)
    except InfeasibleError as error:
        raise PinpressError(
            f"no tolerances within the bounds keep {', '.join(limits)}: give smaller lower bounds, or larger targets"
        ) from error


def _with_tolerance(part: Dimension, factor: float) -> Dimension:
    """A dimension whose tolerance and scatter are wider by a factor."""
    shape = part.shape if isinstance(part.shape, str) else factor * np.asarray(part.shape)
    return replace(part, tolerance=factor * part.tolerance, shape=shape, sd=None if part.sd is None else factor * part.sd)
