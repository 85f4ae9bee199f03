"""What `compare` measures: error against run time, as rows of a table, a CSV file and text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..common import text
from ..common.results import Record, Records, Tabular
from ..common.tables import Column

FREE_RUN, CLUTCH, DIE, SPEED_LAW = SCENES = ("free run", "clutch and blanking", "elastic die", "stiff speed law")
INVERSE_DYNAMICS, PROXIMAL, TABLE = "inverse dynamics", "proximal settings", "reduced table"
GROUPS = (INVERSE_DYNAMICS, *SCENES, PROXIMAL, TABLE)
PROXIMAL_STATES = 24  # of a turn, that proximal settings are measured in
UNITS = {  # what `seconds` and `error` of a group are
    INVERSE_DYNAMICS: ("of a turn", "of the driving torque, of its peak"),
    **dict.fromkeys(SCENES, ("of the run and the forces at its end", "of the crank angle at its end [rad]")),
    PROXIMAL: (f"of {PROXIMAL_STATES} states", "of the joint accelerations, of their peak"),
    TABLE: ("of making it", "of reduced inertia and potential energy between the samples, of their range"),
}


@dataclass(frozen=True, repr=False)
class Measurement(Record, units={"seconds": "s", "loop_gap": "m"}):
    """One method with one setting. A quantity that it does not have is None.

    Attributes:
        group: one of `GROUPS`.
        method: "plane", "reduced", ..., or a peer with its version.
        setting: in words.
        number: the setting: a tolerance, a step [s], a proximal parameter, a number of samples.
        seconds: least run time, of what `UNITS` says [s].
        error: largest error, of what `UNITS` says.
        force_error: largest error of a bearing force, as a share of the largest peak of any [-].
        loop_gap: largest distance between the two sides of a loop [m].
        energy_error: of the power balance, as a share of the peak power, or of the energy at the end, as a share of the kinetic energy at
            the start [-].
        evaluations: crank angles, evaluations of the equation of motion, or samples.
        problem: what the method answered instead, where there is no error; else empty.
    """

    group: str
    method: str
    setting: str
    number: float | None
    seconds: float
    error: float | None
    force_error: float | None = None
    loop_gap: float | None = None
    energy_error: float | None = None
    evaluations: int | None = None
    problem: str = ""


@dataclass(frozen=True, repr=False)
class WorkPrecision(Tabular):
    """Error against run time of everything that is offered for a press, and of its peers, measured in one run.

    Attributes:
        press_name: name of the press.
        scene: what was computed, in words.
        machine: on what, in words.
        scenes: group of a simulation -> that scene in words.
        certificates: group -> difference of the two independent methods whose agreement makes the reference, in the unit of its errors.
        certified_by: group -> which two these are.
        measurements: in the order of `GROUPS`.
        skipped: a line for each that could not be measured, with the reason.
    """

    press_name: str
    scene: str
    machine: str
    scenes: Mapping[str, str]
    certificates: Mapping[str, float]
    certified_by: Mapping[str, str]
    measurements: Records[Measurement]
    skipped: tuple[str, ...]

    def of(self, group: str, method: str | None = None) -> Records[Measurement]:
        """The measurements of a group, or of one method in it."""
        return Records(Measurement, (m for m in self.measurements if m.group == group and method in (None, m.method)))

    def fastest(self, group: str, error: float) -> Records[Measurement]:
        """Of every method of a group that reaches an error the fastest measurement that does, the fastest first."""
        best: dict[str, Measurement] = {}
        for m in sorted(self.of(group), key=lambda m: m.seconds):
            if m.error is not None and m.error <= error:
                best.setdefault(m.method, m)
        return Records(Measurement, best.values())

    @property
    def title(self) -> str:
        fastest = min(measurement.seconds for measurement in self.measurements)
        return f"WorkPrecision of {self.press_name}: {len(self.measurements)} measurements, {self.scene}, the fastest {fastest:.4g} s"

    def columns(self) -> dict[str, Column]:
        """The measurements as columns, None where there is no value."""
        return self.measurements.columns()

    def __str__(self) -> str:
        lines = [f"{self.press_name}: {self.scene}", self.machine]
        for group in GROUPS:
            rows = self.of(group)
            if rows:
                time, error = UNITS[group]
                lines += ["", f"{group[0].upper()}{group[1:]}: time {time}; error {error}"]
                lines += [f"  {self.scenes[group]}"] if group in self.scenes else []
                lines += [f"  reference: {self.certified_by[group]} agree to {self.certificates[group]:.1e}", *_table(rows)]
        return "\n".join([*lines, *(["", *self.skipped] if self.skipped else [])])


def _table(rows: Sequence[Measurement]) -> list[str]:
    heads = ("", "time [ms]", "error", "force error", "loop gap [m]", "energy error", "evaluations")
    kept = [k for k in range(len(heads)) if k < 3 or any(_cells(row)[k] for row in rows)]
    width = max(len(_cells(row)[0]) for row in rows) + 2
    table = ([cells[k] for k in kept] for cells in (heads, *map(_cells, rows)))
    return [line.rstrip() for line in text.table(table, [width, 14])]


def _cells(row: Measurement) -> tuple[str, ...]:
    name = f"{row.method}, {row.setting}" if row.setting else row.method
    errors = [("" if value is None else f"{value:.1e}") for value in (row.error, row.force_error, row.loop_gap, row.energy_error)]
    if row.problem:
        errors[0] = row.problem
    return name, f"{1e3 * row.seconds:.4g}", *errors, "" if row.evaluations is None else str(row.evaluations)
