"""What maps of operating points and sweeps show: extremes over speed and force as colours, axes, ranges of results, and failed points."""

from __future__ import annotations

import numpy as np

from ..common import tables
from ..common.outlets.described import Along, Block, Column, Figure, Map, Section, Table
from ..common.quantities import quantity
from ..dynamics.reactions import Reactions
from .operating_map import OperatingMap, unit_of
from .sweeping import Sweep

DIGITS = 6  # of the ends of a range


def operating_map(found: OperatingMap, page: Reactions | None = None) -> tuple[Section, ...]:
    """Extremes over a turn at every speed and force, a map a quantity."""
    by_speed, by_force = np.argsort(found.speeds), np.argsort(found.forces)
    across, up = Along("force", "N", found.forces[by_force]), Along("speed", "rad/s", found.speeds[by_speed])
    blocks: list[Block] = []
    for name, values in found.results.items() if min(found.shape) > 1 else ():
        words = name.replace("_", " ")
        blocks.append(Map(f"map {name}", words.capitalize(), unit_of(name), across, up, values[np.ix_(by_speed, by_force)]))
    ends = [
        [quantity(unit_of(name)).text(float(end), DIGITS) for end in (values.min(), values.max())] for name, values in found.results.items()
    ]
    columns = [
        Column("over a turn", list(found.results)),
        Column("smallest", [low for low, _ in ends]),
        Column("largest", [high for _, high in ends]),
    ]
    speeds, forces = (
        f"{quantity(unit).text(float(values.min()), DIGITS)} to {quantity(unit).text(float(values.max()), DIGITS)}"
        for values, unit in ((found.speeds, "rad/s"), (found.forces, "N"))
    )
    figures = [Figure("speeds", str(len(found.speeds)), where=speeds), Figure("forces", str(len(found.forces)), where=forces)]
    return (Section("Operating points", figures, [*blocks, Table("ranges", "", columns, most=200)]),)


def sweep(found: Sweep, page: Reactions | None = None) -> tuple[Section, ...]:
    """Axes, the ranges of the results, and the failed points."""
    labels = found.axes.values()
    axes = [
        Column("", list(found.axes)),
        Column("values", [len(values) for values in labels]),
        Column("first", [values[0] for values in labels]),
        Column("last", [values[-1] for values in labels]),
    ]
    blocks: list[Block] = [Table("axes", "Axes side by side" if found.paired else "Axes", axes, most=200)]
    if found.results:
        ends = [[*tables.ends(values), "", ""][:2] for values in found.results.values()]
        low, high = zip(*ends, strict=True)
        blocks.append(
            Table("results", "Results", [Column("", list(found.results)), Column("smallest", low), Column("largest", high)], most=200)
        )
    if failed := found.failed:
        points = [", ".join(f"{name}={label}" for name, label in bad.point.items()) for bad in failed]
        errors = [bad.error.splitlines()[0] for bad in failed]
        blocks.append(Table("failed points", "Failed points", [Column("point", points), Column("error", errors)], most=10))
    return (Section("Sweep", (), blocks),)


SECTIONS = {OperatingMap: operating_map, Sweep: sweep}
"""How results of this room are described."""
