"""What `compare` measures, as a page of charts and tables."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..common.arguments import typed
from ..dynamics.inputs import stated
from ..visual.reports.blocks import Block, Line, LineChart, Section, Table
from ..visual.reports.report import article
from .measurements import FREE_RUN, GROUPS, INVERSE_DYNAMICS, PROXIMAL, SCENES, SPEED_LAW, SPRINGS, TABLE, UNITS, Measurement, WorkPrecision

KNOWN = "reference known to"
OF_SETTINGS = {PROXIMAL: "proximal parameter", TABLE: "samples"}  # what the error is drawn over, in place of the time


@typed
def report(measured: WorkPrecision, path: str | os.PathLike[str]) -> Path:
    """Write a self-contained page with error against run time of each group, and the tables of all measurements; return its path.

    The error of a scene is that of the crank angle at its end; under a stiff speed law, which fixes the crank angle, it is that of the
    bearing forces; on springs it is that of the slide's place and of the bearing forces. A line shows how far the reference is known. The
    page opens without server and network.

    Args:
        measured: Result of `compare`.
        path: Path of the file, usually ending in `.html`.

    Raises:
        PinpressError: Plotly is not installed, or the file cannot be written.
    """
    inputs = [("press", measured.press_name), ("scene", measured.scene), ("computer", measured.machine)]
    inputs += [(group, words) for group, words in measured.scenes.items()]
    inputs += [("left out", words) for words in measured.skipped]
    parts = [_section(measured, group) for group in GROUPS if measured.of(group)]
    if measured.cannot:
        rows = [
            ["" if k else method, words]
            for method, sentence in measured.cannot.items()
            for k, words in enumerate(sentence.split("; "))  # a page cuts long cells
        ]
        parts.append(Section("Limits", [Table("", ["program", "what it cannot do"], rows, words=2)]))
    return article(
        f"{measured.press_name}: error against run time", f"{len(measured.measurements)} measurements", [*inputs, stated()], parts, path
    )


def _section(measured: WorkPrecision, group: str) -> Section:
    time, error = UNITS[group]
    across, along = (OF_SETTINGS[group], _setting) if group in OF_SETTINGS else ("time [ms]", _milliseconds)
    blocks: list[Block] = []
    if group == SPEED_LAW:
        blocks += _chart(measured, group, "Error of bearing forces", "of the largest peak", across, along, _force_error)
    else:
        blocks += _chart(measured, group, "Error", "", across, along, _error)
    if group == SPRINGS:
        blocks += _chart(measured, group, "Error of bearing forces", "of the largest peak", across, along, _force_error)
    if group == FREE_RUN:
        blocks += _chart(measured, group, "Loop gap", "m", across, along, _loop_gap)
    note = f"Time {time}; error {error}."
    if group in measured.certificates:
        note += f" Reference: {measured.certified_by[group]} agree to {measured.certificates[group]:.1e}."
    return Section(f"{group[0].upper()}{group[1:]}", [*blocks, _table(measured, group)], note=note)


def _chart(
    measured: WorkPrecision,
    group: str,
    title: str,
    unit: str,
    across: str,
    along: Callable[[Measurement], float | None],
    value: Callable[[Measurement], float | None],
) -> list[Block]:
    """A line a method through the measurements that have both values, which a logarithmic chart can show; nothing where none has."""
    lines = []
    for method in dict.fromkeys(row.method for row in measured.of(group)):
        points = [(x, y) for x, y in ((along(row), value(row)) for row in measured.of(group, method)) if x and y]
        if points:
            lines.append(Line(method, np.array([y for _, y in points]), np.array([x for x, _ in points])))
    if not lines:
        return []
    if value is _error and group in (INVERSE_DYNAMICS, *SCENES, PROXIMAL) and measured.certificates.get(group):
        places = np.concatenate([line.x for line in lines if line.x is not None])
        lines.insert(0, Line(KNOWN, np.full(2, measured.certificates[group]), np.array([places.min(), places.max()])))  # below the others
    return [LineChart(title, unit, lines, across=across, follows="nothing", logarithmic="xy")]


def _table(measured: WorkPrecision, group: str) -> Table:
    heads = ("method", "setting", "time [ms]", "error", "force error", "loop gap [m]", "energy error", "evaluations")
    rows = [_cells(row) for row in measured.of(group)]
    kept = [k for k in range(len(heads)) if k < 4 or any(row[k] for row in rows)]
    return Table("", [heads[k] for k in kept], [[row[k] for k in kept] for row in rows], words=2)


def _cells(row: Measurement) -> list[str]:
    errors = ["" if value is None else f"{value:.1e}" for value in (row.error, row.force_error, row.loop_gap, row.energy_error)]
    if row.problem:
        errors[0] = row.problem
    return [row.method, row.setting, f"{1e3 * row.seconds:.4g}", *errors, "" if row.evaluations is None else str(row.evaluations)]


def _milliseconds(row: Measurement) -> float | None:
    return 1e3 * row.seconds


def _setting(row: Measurement) -> float | None:
    return row.number if row.number is not None else row.evaluations


def _error(row: Measurement) -> float | None:
    return row.error


def _force_error(row: Measurement) -> float | None:
    return row.force_error


def _loop_gap(row: Measurement) -> float | None:
    return row.loop_gap
