"""Tables in Markdown."""

from collections.abc import Iterable, Sequence


def table(heads: Sequence[str], rows: Iterable[Sequence[object]], numbers: int = 0) -> str:
    """A table whose columns behind the first are numbers, to the right, as many as ``numbers``; bars in cells are escaped."""
    marks = [":"[: 0 < k <= numbers] for k in range(len(heads))]
    lines = [f"| {' | '.join(heads)} |", "".join(f"|---{mark}" for mark in marks) + "|"]
    for row in rows:
        cells = [str(cell).replace("|", r"\|") for cell in row]
        assert len(cells) == len(heads), f"{cells} under {heads}"
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)
