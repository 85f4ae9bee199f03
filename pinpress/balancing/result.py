"""A balanced press, and what balancing does to it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from ..common import tables
from ..common.frozen import Frozen
from ..dynamics.inverse_dynamics import Reactions
from ..linkage.linkage import Linkage
from . import tables as balance_tables
from .counterweights import Counterweight
from .mass_response import Case
from .objectives import Measure, Target


@dataclass(frozen=True)
class Outcome:
    """A measure before and after balancing, in one case, in its unit."""

    measure: Measure
    case: int
    before: float
    after: float

    @property
    def change(self) -> float:
        """Relative; NaN where there was nothing before."""
        return self.after / self.before - 1.0 if self.before else float("nan")


@dataclass(frozen=True)
class Active:
    """A constraint that holds the optimum back.

    Attributes:
        constraint: in words. price: by how much the objective falls for one more of what the constraint limits, in the objective's unit per
            unit of that; None where that is the shape of a room, which is no number.
    """

    constraint: str
    price: float | None


@dataclass(frozen=True, eq=False, repr=False)
class Balance(Frozen):
    """A balanced press.

    Attributes:
        original: the press as it was. press: with its counterweights; `write_urdf` writes it.
        cases: that it was balanced in. objective: measures with their weights. limits: as they were given.
        counterweights: what the rooms are filled with, in their order, none that weigh nothing; of a room that replaces a link's own mass
            the whole of it. added_mass: of all [kg].
        value: the objective: of a measure alone, in one case, in its unit; else the weighted sum of measures relative to before.
        unit: of the value, empty where it is relative.
        bound: no counterweights in these rooms have a lower one, at the states of the motion. The difference is what is left unproved, and
            what the preference for lighter ones has cost.
        residual: largest violation of the conditions of optimality, relative to before.
        outcomes: of the objective's measures, then of all others, case by case, from ``before`` and ``after``.
        active: constraints that hold the optimum back.
        before, after: reactions of the press and of the balanced one, of every case: both in the motion of the case. Where that is a run,
            simulate the balanced press for its own.
    """

    original: Linkage
    press: Linkage
    cases: tuple[Case, ...]
    objective: Mapping[Target, float]
    limits: Mapping[Target, float]
    counterweights: tuple[Counterweight, ...]
    added_mass: float
    value: float
    unit: str
    bound: float
    residual: float
    outcomes: tuple[Outcome, ...]
    active: tuple[Active, ...]
    before: tuple[Reactions, ...]
    after: tuple[Reactions, ...]

    def __repr__(self) -> str:
        return f"<Balance of {self.press.name}: {self.added_mass:.6g} kg added, {len(self.counterweights)} counterweights>"

    def __str__(self) -> str:
        return balance_tables.text(self)

    @cached_property
    def effects(self) -> tuple[Outcome, ...]:
        """What balancing does to the rest of the press; see `balance_tables.effects`. Worked out when first asked for."""
        return balance_tables.effects(self)

    def columns(self) -> dict[str, list[object]]:
        """Measures before and after as columns, the outcomes and then `effects`; None where there is no value."""
        return balance_tables.columns(self)

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the columns, a measure in one case a line.

        Raises:
            PinpressError: the file cannot be written.
        """
        tables.write_csv(path, self.columns())

    def to_frame(self) -> tables.DataFrame:
        """The columns as a pandas DataFrame. Raises PinpressError where pandas is not installed."""
        return tables.frame(self.columns())
