"""What an engineer reads off a synthesis, as text and columns."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .synthesis import Synthesis

WIDE = 14  # letters of a number's column


@dataclass(frozen=True)
class Row:
    """A variable or constraint of a synthesis; of one with several elements the one nearest to a bound. None where there is no bound."""

    name: str
    kind: str
    lower: float | None
    start: float
    value: float
    upper: float | None


def text(synthesis: "Synthesis") -> str:
    """Objective, variables and constraints with their bounds, what holds the optimum, and how well its conditions are met."""
    rows = synthesis.table()
    width = max(12, *(len(row.name) for row in rows)) + 2
    heads = "".join(head.rjust(WIDE) for head in ("lower", "start", "found", "upper"))
    lines = [
        f"{synthesis.press.name}: {synthesis.evaluations} designs, {synthesis.infeasible} of them could not be assembled",
        "",
        f"  {'objective':{width}}{'':{WIDE}}{synthesis.start_value:{WIDE}.6g}{synthesis.value:{WIDE}.6g}",
    ]
    for kind in ("variable", "constraint"):
        some = [row for row in rows if row.kind == kind]
        if some:
            lines += ["", f"{kind.capitalize() + 's':{width + 2}}{heads}", *(_line(row, width) for row in some)]
    lines += ["", "Held by" if synthesis.active else "Held by no bound"]
    lines += [
        f"  {bound.name}, {'value' if bound.side == 'equal' else f'{bound.side} bound'} {bound.bound:.6g}:"
        f" the objective changes by {bound.multiplier:.4g} times what it is changed by"
        for bound in synthesis.active
    ]
    if synthesis.idle:
        lines += [f"Without influence: {', '.join(synthesis.idle)}"]
    return "\n".join([*lines, "", "Checks", f"  {'conditions of the optimum':{width + 14}}{synthesis.kkt:.2g} of the objective"])


def columns(rows: Sequence[Row]) -> dict[str, list[object]]:
    """Rows as columns; None where there is no bound."""
    return {field.name: [getattr(row, field.name) for row in rows] for field in fields(Row)}


def _line(row: Row, width: int) -> str:
    numbers = "".join(("-" if value is None else f"{value:.6g}").rjust(WIDE) for value in (row.lower, row.start, row.value, row.upper))
    return f"  {row.name:{width}}{numbers}"
