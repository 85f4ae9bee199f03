"""Balance over changes of die, stroke and speed: the optimum for one operating condition, a compromise, and adjustable counterweights.

Zhang 2007, 1.2.1: with another upper die the balance becomes worse.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..common.arguments import typed
from ..common.errors import PinpressError, shown
from ..common.quantities import Array
from ..common.results import Tabular
from ..common.tables import Column
from ..linkage.linkage import Linkage
from .counterweights import OperatingCondition
from .optimum import balance
from .problem import Criterion, Target, refuse_no_regions
from .regions import CounterweightRegion
from .result import BalancedPress, condition_name


@dataclass(frozen=True, eq=False, repr=False)
class ConditionComparison(Tabular):
    """A criterion in all operating conditions: for the optimum of a condition, for a compromise, and for adjustable counterweights.

    Attributes:
        criterion: the minimised criterion.
        names: names of the designs: "none": the press before balancing; "best for" a condition: its optimum, without the other conditions;
            "compromise": the least worst value; and, with regions to be adjusted, "set anew".
        conditions: names of the operating conditions.
        values: (designs, conditions) values of the criterion [unit of the criterion].
        added_mass: (designs,) mass that balancing adds [kg].
        designs: the balanced presses, without "none".
    """

    criterion: Criterion
    names: tuple[str, ...]
    conditions: tuple[str, ...]
    values: Array
    added_mass: Array
    designs: tuple[BalancedPress, ...]

    @property
    def title(self) -> str:
        most = dict(zip(self.names, self.values.max(axis=1), strict=True))
        compromise, none = (f"{most[name]:.6g} {self.criterion.unit}" for name in ("compromise", "none"))
        count = len(self.conditions)
        return f"ConditionComparison of the {self.criterion.words} over {count} conditions: compromise {compromise}, before {none}"

    @property
    def _pictured(self) -> tuple[str, ...]:
        return ("added mass [kg]", f"worst [{self.criterion.unit}]")

    def columns(self) -> dict[str, Column]:
        """A row for each design: the criterion in each operating condition, its worst value, and the added mass."""
        values: dict[str, Column] = {f"{name} [{self.criterion.unit}]": self.values[:, k] for k, name in enumerate(self.conditions)}
        worst = {f"worst [{self.criterion.unit}]": self.values.max(axis=1), "added mass [kg]": self.added_mass}
        return {"design": list(self.names)} | values | worst


@typed
def compare_conditions(
    press: Linkage,
    conditions: Sequence[OperatingCondition],
    *,
    regions: Sequence[CounterweightRegion],
    minimise: Criterion,
    limits: Mapping[Target, float] | None = None,
) -> ConditionComparison:
    """Compare the optimum for each die, stroke or speed with a compromise for all of them, and with adjustable counterweights.

    Each design is a proved optimum of `balance`. The design for one condition considers only this condition. Its counterweights are not
    adjustable.

    Args:
        press: the press.
        conditions: two or more operating conditions.
        regions: where counterweights may be; regions with ``reset`` are adjusted only in the last design.
        minimise: the criterion.
        limits: largest values of criteria and of added mass in all operating conditions, as in `balance`.

    Raises:
        UnknownNameError: the press does not have a link or bearing with this name.
        PinpressError: there are fewer than two operating conditions, two have the same name, or as `balance`.
    """
    if not isinstance(minimise, Criterion):
        raise PinpressError(f"minimise: {shown(minimise)} is not a criterion: give Range, Rms or Peak")
    refuse_no_regions(regions)
    if len(conditions) < 2:
        raise PinpressError("conditions has fewer than two operating conditions: give two or more")
    fixed = [replace(region, reset="") for region in regions]
    criteria: dict[str, Any] = {"minimise": minimise, "limits": limits}
    designs = [balance(press, conditions, regions=fixed, shares=alone, **criteria) for alone in np.eye(len(conditions)).tolist()]
    designs.append(balance(press, conditions, regions=fixed, **criteria))
    if any(region.reset for region in regions):
        designs.append(balance(press, conditions, regions=regions, **criteria))
    names = tuple(condition_name(designs[0], k) for k in range(len(conditions)))
    if len(set(names)) < len(names):
        raise PinpressError(
            f"two operating conditions have the same name among {', '.join(map(repr, names))}: give different names, name=..."
        )
    changes = [[change for change in design.changes if change.criterion == minimise] for design in designs]
    return ConditionComparison(
        criterion=minimise,
        names=("none", *(f"best for {name}" for name in names), "compromise", "set anew")[: len(designs) + 1],
        conditions=names,
        values=np.array([[change.before for change in changes[0]], *([change.after for change in rows] for rows in changes)]),
        added_mass=np.array([0.0, *(design.added_mass for design in designs)]),
        designs=tuple(designs),
    )
