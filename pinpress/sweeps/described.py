"""What maps of operating points and sweeps show: extremes over speed and force as colours, axes, ranges of results, and failed points."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from numbers import Real

import numpy as np

from ..common import tables
from ..common.outlets.described import Along, Block, Chart, Column, Curve, Figure, Map, Section, Table
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
    blocks: list[Block] = [*_charts(found), Table("axes", "Axes side by side" if found.paired else "Axes", axes, most=200)]
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


def _charts(found: Sweep) -> Iterator[Block]:
    """Every result over a grid of numbers: a curve over one axis, a map over the first two, with the others in the middle of theirs.

    Axes of one label are none, and a result of words has no chart.
    """
    axes = {name: np.array(labels, dtype=float) for name, labels in found.axes.items() if len(labels) > 1 and _are_numbers(labels)}
    if found.paired or not axes or len(axes) < sum(len(labels) > 1 for labels in found.axes.values()):
        return
    drawn, order = list(axes)[:2], {name: np.argsort(values) for name, values in axes.items()}
    middle = {name: len(labels) // 2 for name, labels in found.axes.items() if name not in drawn}
    at = ", ".join(f"{name} = {found.axes[name][k]:.{DIGITS}g}" for name, k in middle.items() if name in axes)
    along = [Along(name, "", axes[name][order[name]]) for name in drawn]
    for name, column in found.results.items():
        if not _are_numbers(np.ma.compressed(column)):
            continue
        values = np.ma.filled(found.grid(name).astype(float), np.nan)[tuple(middle.get(axis, slice(None)) for axis in found.axes)]
        values = values[np.ix_(*(order[axis] for axis in drawn))]
        if len(drawn) == 1:
            done = np.isfinite(values)  # points that failed are none of the curve, which is marked where it has some
            if done.sum() > 1:
                yield Chart(name, name, "", along[0], [Curve(name, values[done], axes[drawn[0]][order[drawn[0]]][done], look="marked")])
        else:
            yield Map(name, f"{name} at {at}" if at else name, "", along[1], along[0], values)


def _are_numbers(values: Iterable[object]) -> bool:
    return all(isinstance(value, Real) and not isinstance(value, bool) for value in values)


SECTIONS = {OperatingMap: operating_map, Sweep: sweep}
"""How results of this room are described."""
