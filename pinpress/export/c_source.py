"""A press's table as C99 without a library: constant tables, two functions that keep nothing between calls, and a self test."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files as resources
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..common import files
from ..common.arguments import truth_value, typed
from ..common.errors import PinpressError
from ..common.files import path_of
from ..common.quantities import Array
from .tables import ACCELERATION, FORCES, PressTable

STATES = 8  # of the self test
DOUBLE, SINGLE = 1e-12, 1e-6  # what the self test allows of rounding error, as a share of the largest value
LINE = 6  # numbers in a line


class Code(NamedTuple):
    """The texts of a press in C.

    Attributes:
        source: the .c file.
        header: the .h file.
        outputs: names of the outputs, in their order.
    """

    source: str
    header: str
    outputs: tuple[str, ...]


@typed
def c_code(table: PressTable, path: str | os.PathLike[str], *, single: bool = False) -> tuple[Path, Path]:
    """Write a press as C99, and return the paths of source and header.

    The functions are ``NAME_all`` and ``NAME_acceleration``, where NAME is that of the file; the header has their units and signs. They
    need no library and no memory but the stack, and keep nothing between calls. Compile with -O3, with which loops use vectors. With
    ``-DNAME_SELF_TEST`` the source is a program that compares eight states with numbers of pinpress.

    Args:
        table: the press.
        path: the .c file; the .h file is next to it. Files of these names are replaced.
        single: whether the tables have 4 bytes a number in place of 8, for small controllers. Arithmetic stays in double; errors are
            then 1e-7 of the largest values.

    Raises:
        PinpressError: the name does not end in .c or is no name in C, or a file cannot be written.
    """
    source = Path(path_of("path", path))
    if source.suffix != ".c" or not re.fullmatch("[A-Za-z][A-Za-z0-9_]*", source.stem):
        raise PinpressError(
            f"path is {source}: give a name of letters and digits that ends in .c, such as press.c, as functions have it too"
        )
    code = code_of(table, source.stem, single=truth_value("single", single))
    header = source.with_suffix(".h")
    return files.write(source, code.source.encode()), files.write(header, code.header.encode())


def code_of(table: PressTable, name: str, *, single: bool = False) -> Code:
    """The texts for a file of this name, without its ending."""
    torque, panels = table.components.index("driving_torque"), len(table.functions.borders) - 1
    rows, numbers = layout(table)
    weights = ["", "acceleration", "square", "speed", *(f"inputs[{k}]" for k in range(len(table.inputs)))]
    sums = {c: [_product(weights[t], f"row[{r}]") for r, (of, t) in enumerate(rows) if of == c] for c in range(len(table.components))}
    names = identifiers(table.components)
    states = _states(table)
    macro, coordinate = name.upper(), table.coordinate
    inertia = rows.index((torque, ACCELERATION))
    unit = {part: each.unit for each in table.quantities for part in each.components}
    values: Mapping[str, object] = {
        "HEADER": "\n".join(f" * {line}".rstrip() for line in header_lines(table)),
        "MACRO": macro,
        "PREFIX": name,
        "FILE": name,
        "UNIT": coordinate.unit,
        "EFFORT": coordinate.effort_unit,
        "INERTIA": "kg m2" if coordinate.turns else "kg",
        "INPUTS": len(table.inputs),
        "OUTPUTS": len(names),
        "INPUT_PLACES": _places(f"{macro}_INPUT", identifiers(table.inputs)),
        "OUTPUT_PLACES": _places(macro, names, [unit[each] for each in table.components]),
        "NUMBER": "float" if single else "double",
        "PANELS": panels,
        "TERMS": numbers.shape[1],
        "ROWS": len(rows),
        "TORQUE_ROWS": len(sums[torque]),
        "PERIOD": repr(table.functions.period or 0.0),
        "BORDERS": _lines(table.functions.borders),
        "TABLE": _table(numbers, single),
        "ALL": "".join(f"    outputs[{c}] = {' + '.join(sums[c])};\n" for c in range(len(table.components))),
        "STANDING": " + ".join(part for r, part in enumerate(sums[torque]) if r != inertia) or "0.0",
        "REDUCED": f"row[{inertia}]",
        "STATES": STATES,
        "STATE": "".join(f"    {{\n{_lines(state, 8)}    }},\n" for state in states),
        "LARGEST": _lines(np.maximum(np.abs(states[:, -len(names) :]).max(axis=0), 1e-300)),
        "ALLOWED": SINGLE if single else DOUBLE,
    }
    return Code(filled("press.c", values), filled("press.h", values), names)


def layout(table: PressTable) -> tuple[list[tuple[int, int]], Array]:
    """Functions that are not zero, those of the driving torque first, as (component, term), and their coefficients (p, q, rows)."""
    panels = len(table.functions.borders) - 1
    coefficients = table.functions.coefficients
    by_term = coefficients.reshape(panels, FORCES + len(table.inputs), -1, coefficients.shape[-1])[:, :, :-1]
    torque, live = table.components.index("driving_torque"), np.asarray(np.any(by_term, axis=(0, 3)))
    live[ACCELERATION, torque] = True  # the reduced inertia, also of a press without masses
    components = sorted(range(len(table.components)), key=lambda c: c != torque)
    rows = [(c, t) for c in components for t in np.flatnonzero(live[:, c]).tolist()]
    return rows, np.stack([by_term[:, t, c] for c, t in rows], axis=2)


def filled(template: str, values: Mapping[str, object]) -> str:
    """A template of this room with the values at its @NAMES@."""
    text = resources(__package__).joinpath("templates", template).read_text(encoding="utf-8")
    return re.sub("@([A-Z_]+)@", lambda match: str(values[match[1]]), text)


def header_lines(table: PressTable) -> list[str]:
    """What stands in the head of every file: what it is, where it is from, how exact it is, signs."""
    worst = max(table.error, key=lambda name: table.error[name])
    inputs = f"Inputs: {', '.join(table.inputs)}." if table.inputs else "It has no inputs."
    sign = " The process force `force` resists the working stroke where it is positive." if "force" in table.inputs else ""
    lines = [
        table.title,
        "",
        *(f"{name}: {words}" for name, words in table.origin),
        "",
        f"Largest difference from the engine in {table.compared} states between the nodes, at random speeds, accelerations and forces:",
        f"{table.error[worst]:.1e} in {worst}, as a share of its largest value there, or of a thousandth of the largest force if that is",
        "more. It is the largest of these states, not a bound.",
        f"{inputs}{sign} SI units and radians.",
        "Positions, speeds and accelerations are of the driver joint along its axis, and so is the torque on it. Those of the slide are",
        "positive along its guide as in pinpress, upwards in an upright press. Forces and moments of a bearing act from its parent on its",
        "child link, in world axes with z up; moments about the bearing. The shaking force acts from the machine on its foundation, weight",
        "included, its moment about the world origin.",
    ]
    plain = (line.encode("ascii", "backslashreplace").decode() for line in lines)
    return [line.replace("*/", "* /").replace("/*", "/ *").replace("\n", " ") for line in plain]


def identifiers(names: Iterable[str]) -> tuple[str, ...]:
    """Names as C and others take them, each different from the others, also where capitals do not count."""
    made: dict[str, None] = {}
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
        number = 2
        unique = plain
        while unique.lower() in (each.lower() for each in made):
            unique, number = f"{plain}_{number}", number + 1
        made[unique] = None
    return tuple(made)


def _product(weight: str, row: str) -> str:
    return f"{weight} * {row}" if weight else row


def _places(prefix: str, names: Sequence[str], units: Sequence[str] = ()) -> str:
    """An enumeration of places by names."""
    if not names:
        return ""
    lines = [f"    {prefix}_{name.upper()} = {k}" for k, name in enumerate(names)]
    shown = [f" /* [{unit}] */" for unit in units] or [""] * len(names)
    commas = [*[","] * (len(names) - 1), ""]
    return "\n".join(["enum {", *map("".join, zip(lines, commas, shown, strict=True)), "};", ""])


def _table(numbers: Array, single: bool) -> str:
    """Numbers (p, q, rows) as nested initialisers."""
    kept = numbers.astype(np.float32 if single else float)
    panels = ("".join(f"        {{\n{_lines(power, 12)}        }},\n" for power in panel) for panel in kept)
    return "".join(f"    {{\n{panel}    }},\n" for panel in panels)


def _lines(numbers: Array, indent: int = 4) -> str:
    texts = [f"{value!s}f" if isinstance(value, np.float32) else repr(float(value)) for value in numbers]
    return "".join(f"{' ' * indent}{', '.join(texts[k : k + LINE])},\n" for k in range(0, len(texts), LINE))


def _states(table: PressTable) -> Array:
    """States for the self test (states, 3 + inputs + outputs)."""
    rng, low, high = np.random.default_rng(1), table.functions.borders[0], table.functions.borders[-1]
    angles = rng.uniform(low, high, STATES) + (table.functions.period or 0.0) * np.arange(STATES)
    inputs = rng.uniform(-1e4, 1e4, (len(table.inputs), STATES))
    speeds, accelerations = rng.uniform(-10.0, 10.0, (2, STATES))
    values = table.at(angles, speeds, accelerations, **dict(zip(table.inputs, inputs, strict=True))).values[:-1]
    return np.vstack([angles, speeds, accelerations, inputs, values]).T
