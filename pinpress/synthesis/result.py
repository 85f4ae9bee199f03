"""What a synthesis finds, as numbers, text and columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

from ..common.arrays import Array
from ..common.results import Tabular
from ..linkage.linkage import Linkage
from .optimality import ActiveBound

WIDE = 14  # letters of a number's column


@dataclass(frozen=True)
class Row:
    """A variable or constraint of a synthesis.

    Of a constraint with several elements it is the one nearest to a bound.

    Attributes:
        name: of the variable or constraint.
        kind: "variable" or "constraint".
        lower: its lower bound [SI], None if there is none.
        start: its value at the start [SI].
        value: its value at the optimum [SI].
        upper: its upper bound [SI], None if there is none.
    """

    name: str
    kind: str
    lower: float | None
    start: float
    value: float
    upper: float | None


@dataclass(frozen=True, eq=False, repr=False)
class SynthesisResult(Tabular):
    """The optimum that was found.

    Attributes:
        press: the linkage with the lengths found, as `reshaped` makes it.
        variables: name -> value [SI].
        value: of the objective at the optimum [SI].
        start_value: of the objective at the start [SI].
        constraints: name -> value at the optimum, a number or (m,) [SI].
        active: the bounds of variables and constraints that hold the optimum, with what they cost.
        idle: variables on which neither the objective nor a constraint depends: they keep any value.
        kkt: residual of the conditions of Karush, Kuhn and Tucker, in units of the objective's size for a change of a variable over its
            whole range; at most 1e-6.
        evaluations: number of designs that were judged.
        infeasible: number of designs that could not be assembled, or not be judged.
    """

    press: Linkage
    variables: Mapping[str, float]
    value: float
    start_value: float
    constraints: Mapping[str, float | Array]
    active: tuple[ActiveBound, ...]
    idle: tuple[str, ...]
    kkt: float
    evaluations: int
    infeasible: int
    _rows: tuple[Row, ...]

    @property
    def title(self) -> str:
        found = ", ".join(f"{name} = {value:.6g}" for name, value in self.variables.items())
        return f"SynthesisResult of {self.press.name}: {self.start_value:.6g} to {self.value:.6g} with {found}"

    def __str__(self) -> str:
        return _text(self)

    def table(self) -> tuple[Row, ...]:
        """The variables and then the constraints, a row each."""
        return self._rows

    def columns(self) -> dict[str, list[object]]:
        """The table as columns; None where there is no bound."""
        return {field.name: [getattr(row, field.name) for row in self._rows] for field in fields(Row)}


def _text(found: SynthesisResult) -> str:
    """Objective, variables and constraints with their bounds, what holds the optimum, and how well its conditions are met."""
    rows = found.table()
    width = max(12, *(len(row.name) for row in rows)) + 2
    heads = "".join(head.rjust(WIDE) for head in ("lower", "start", "found", "upper"))
    lines = [
        f"{found.press.name}: {found.evaluations} designs, {found.infeasible} of them could not be assembled",
        "",
        f"  {'objective':{width}}{'':{WIDE}}{found.start_value:{WIDE}.6g}{found.value:{WIDE}.6g}",
    ]
    for kind in ("variable", "constraint"):
        some = [row for row in rows if row.kind == kind]
        if some:
            lines += ["", f"{kind.capitalize() + 's':{width + 2}}{heads}", *(_line(row, width) for row in some)]
    lines += ["", "Held by" if found.active else "Held by no bound"]
    lines += [
        f"  {bound.name}, {'value' if bound.side == 'equal' else f'{bound.side} bound'} {bound.bound:.6g}:"
        f" the objective changes by {bound.multiplier:.4g} times what it is changed by"
        for bound in found.active
    ]
    if found.idle:
        lines += [f"Without influence: {', '.join(found.idle)}"]
    return "\n".join([*lines, "", "Checks", f"  {'conditions of the optimum':{width + 14}}{found.kkt:.2g} of the objective"])


def _line(row: Row, width: int) -> str:
    numbers = "".join(("-" if value is None else f"{value:.6g}").rjust(WIDE) for value in (row.lower, row.start, row.value, row.upper))
    return f"  {row.name:{width}}{numbers}"
