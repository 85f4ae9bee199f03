"""What load cases show: the range of every force over the motion, and the forces of each case in the link's axes."""

from __future__ import annotations

import numpy as np

from ..common.outlets.described import Column, Figure, Section, Table
from .link_loads import LinkLoads


def load_cases(cases: LinkLoads, page: object = None) -> tuple[Section, ...]:
    """The load cases of a link."""
    first = cases._press.driver_coordinates[0]
    place, names, count = "angle" if first.turns else "height", list(cases.force), len(cases.remark)
    force, moment = (float(each.max()) for each in cases.residual)
    figures = [
        Figure("mass", cases.mass, "kg", f"of {cases.link}"),
        Figure("force left over", force, "N", "of all in balance, at most"),
        Figure("moment left over", moment, "N m", "of all in balance, at most"),
    ]
    largest = max((size for size, _ in cases.largest.values()), default=0.0)
    ends = {"smallest": cases.lowest, "largest": cases.highest}
    envelope = [
        Column("force of", names),
        Column("largest force", [cases.largest[name][0] for name in names], "N"),
        Column("at", [cases.largest[name][1] for name in names], place),
        *(Column(f"{end} {'xyz'[k]}", [float(of[name][k]) for name in names], "N", largest) for k in (0, 2) for end, of in ends.items()),
    ]
    rows = [(k, name) for k in range(count) for name in names]
    places = cases.place.reshape(count, -1)[:, 0]
    listed = [
        Column("case", [k + 1 for k, _ in rows]),
        Column("at", [float(places[k]) for k, _ in rows], place),
        Column("remark", [cases.remark[k] for k, _ in rows]),
        Column("force of", [name for _, name in rows]),
        *(Column(f"force {axis}", [float(cases.force[name][k, i]) for k, name in rows], "N", largest) for i, axis in enumerate("xyz")),
        *(
            Column(f"moment {axis}", [float(cases.moment[name][k, i]) for k, name in rows], "N m", largest * cases._press.size)
            for i, axis in enumerate("xyz")
            if any(np.abs(cases.moment[name][:, i]).max() > 1e-9 * largest * cases._press.size for name in names)
        ),
    ]
    note = "In the axes of the link, on the link. Gravity and inertia are a body force in addition."
    tables = [Table("envelope", "Forces over the motion", envelope), Table("load_cases", "Load cases", listed, note)]
    return (Section(f"Load cases of {cases.link}", figures, tables, press=cases._press),)


SECTIONS = {LinkLoads: load_cases}
"""How results of this room are described."""
