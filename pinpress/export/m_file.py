"""A press's table as a function of MATLAB and Octave in one file."""

from __future__ import annotations

import os
import re
from pathlib import Path

from ..common import files
from ..common.arguments import typed
from ..common.errors import PinpressError
from ..common.files import path_of
from ..common.quantities import Array
from .c_source import filled, header_lines, identifiers, layout
from .tables import PressTable


@typed
def matlab(table: PressTable, path: str | os.PathLike[str]) -> Path:
    """Write a press as a function of MATLAB, Simulink's MATLAB Function block and Octave, and return its path.

    ``outputs = NAME(angle, speed, acceleration, inputs)``, where NAME is that of the file; its head lists the outputs with their units. A
    state whose position the driver does not reach gives NaN.

    Args:
        table: the press.
        path: the .m file; a file of this name is replaced.

    Raises:
        PinpressError: the name does not end in .m or is no name of a function, or the file cannot be written.
    """
    target = Path(path_of("path", path))
    if target.suffix != ".m" or not re.fullmatch("[A-Za-z][A-Za-z0-9_]*", target.stem):
        raise PinpressError(
            f"path is {target}: give a name of letters and digits that ends in .m, such as press.m, as the function has it too"
        )
    rows, numbers = layout(table)
    weights = ["", "acceleration * ", "speed^2 * ", "speed * ", *(f"inputs({k}) * " for k in range(1, 1 + len(table.inputs)))]
    sums = [" + ".join(f"{weights[t]}row({r})" for r, (of, t) in enumerate(rows, 1) if of == c) for c in range(len(table.components))]
    unit = {part: each.unit for each in table.quantities for part in each.components}
    names = [f"%   outputs({k})  {name} [{unit[part]}]" for k, (name, part) in enumerate(_named(table), 1)]
    borders = table.functions.borders
    values = {
        "NAME": target.stem,
        "TITLE": target.stem.upper(),
        "HEADER": "\n".join(f"% {line}".rstrip() for line in header_lines(table)),
        "NAMES": "\n".join(names),
        "OUTPUTS": len(sums),
        "UNIT": table.coordinate.unit,
        "BORDERS": _row(borders),
        "SIZES": f"{numbers.shape[2]}, {numbers.shape[1]}, {len(numbers)}",
        "TABLE": "".join(f"    table(:, :, {k}) = [\n{_matrix(panel.T)}    ];\n" for k, panel in enumerate(numbers, 1)),
        "PERIOD": repr(table.functions.period or 0.0),
        "PANELS": len(numbers),
        "ALL": "\n".join(f"outputs({k}) = {each};" for k, each in enumerate(sums, 1)),
    }
    return files.write(target, filled("press.m", values).encode())


def _named(table: PressTable) -> list[tuple[str, str]]:
    return list(zip(identifiers(table.components), table.components, strict=True))


def _row(numbers: Array) -> str:
    return ", ".join(repr(float(number)) for number in numbers)


def _matrix(numbers: Array) -> str:
    return "".join(f"        {_row(row)}\n" for row in numbers)
