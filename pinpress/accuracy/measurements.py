"""What `compare` measures: error against run time, as rows of a table, and drawn in a figure."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..common import tables
from ..common.arguments import typed
from ..common.results import Record, Records, Tabular
from ..common.tables import Column
from ..plots.style import COLOURS, GREY, SMALL, grid, legend, panels, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FREE_RUN, CLUTCH, DIE, SPEED_LAW, SPRINGS = SCENES = (
    "free run",
    "clutch and blanking",
    "elastic die",
    "stiff speed law",
    "blanking on springs",
)
INVERSE_DYNAMICS, PROXIMAL, TABLE = "inverse dynamics", "proximal settings", "reduced table"
GROUPS = (INVERSE_DYNAMICS, *SCENES, PROXIMAL, TABLE)
PROXIMAL_STATES = 24  # states of a turn in which proximal settings are measured
UNITS = {  # meaning of `seconds` and `error` of a group
    INVERSE_DYNAMICS: ("of a turn", "of the driving torque, of its peak"),
    **dict.fromkeys(SCENES, ("of the run and the forces at its end", "of the crank angle at its end [rad]")),
    SPRINGS: ("of half a stroke and the forces at its end", "of the slide's place at its end, of the largest displacement by the springs"),
    PROXIMAL: (f"of {PROXIMAL_STATES} states", "of the joint accelerations, of their peak"),
    TABLE: ("of making it", "of reduced inertia and potential energy between the samples, of their range"),
}

HEIGHT = 33.0  # [cm]
WIDTH = 98  # longest line of the text
ANGLE = "error of the crank angle [rad]"
MARKERS = "osD^vP*X<>dhp1234x+"
FAMILIES = {  # of one colour each
    **dict.fromkeys(("plane", "space", "implicit", "elastic"), "reduced"),
    "pinocchio": "constraint",
    "SciPy": "hand",
}


@dataclass(frozen=True, repr=False)
class Measurement(Record, units={"seconds": "s", "loop_gap": "m"}):
    """One method with one setting. A quantity that it does not have is None.

    Attributes:
        group: one of `GROUPS`.
        method: "plane", "reduced", ..., or a peer with its version.
        setting: the setting in words.
        number: the setting as a number: a tolerance, a step [s], a proximal parameter or a number of samples.
        seconds: least run time; `UNITS` says of what [s].
        error: largest error; `UNITS` says of what.
        force_error: largest error of a bearing force, as a share of the largest peak of any [-].
        loop_gap: largest distance between the two sides of a loop [m].
        energy_error: error of the power balance, as a share of the peak power, or of the energy at the end, as a share of the kinetic
            energy at the start [-].
        evaluations: number of crank angles, of evaluations of the equation of motion, or of samples.
        problem: message of the method where there is no error; else empty.
        cannot: what a peer cannot do for a linkage, in words; empty for methods of our own.
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
    cannot: str = ""


Value = Callable[[Measurement], float | None]


@dataclass(frozen=True, repr=False)
class WorkPrecision(Tabular):
    """Error against run time of everything that is offered for a press, and of its peers, measured in one run.

    Attributes:
        press_name: name of the press.
        scene: what was computed, in words.
        machine: the computer, in words.
        scenes: group of a simulation -> its scene in words.
        certificates: group -> difference of the two independent methods whose agreement makes the reference, in the unit of its errors.
        certified_by: group -> names of these two methods.
        measurements: all measurements, in the order of `GROUPS`.
        skipped: a line for each method that could not be measured, with the reason.
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
        """The fastest measurement of each method of a group that reaches an error, the fastest first."""
        best: dict[str, Measurement] = {}
        for m in sorted(self.of(group), key=lambda m: m.seconds):
            if m.error is not None and m.error <= error:
                best.setdefault(m.method, m)
        return Records(Measurement, best.values())

    @property
    def cannot(self) -> dict[str, str]:
        """Method -> what it cannot do for a linkage, in words, where that is said."""
        return {m.method: m.cannot for m in self.measurements if m.cannot}

    @property
    def title(self) -> str:
        fastest = min(measurement.seconds for measurement in self.measurements)
        return f"WorkPrecision of {self.press_name}: {len(self.measurements)} measurements, {self.scene}, the fastest {fastest:.4g} s"

    def columns(self) -> dict[str, Column]:
        """The measurements as columns, None where there is no value."""
        return self.measurements.columns()

    def __str__(self) -> str:
        lines = [*_wrapped(f"{self.press_name}: {self.scene}"), *_wrapped(self.machine)]
        for group in GROUPS:
            rows = self.of(group)
            if rows:
                time, error = UNITS[group]
                lines += ["", *_wrapped(f"{group[0].upper()}{group[1:]}: time {time}; error {error}")]
                lines += _wrapped(f"  {self.scenes[group]}") if group in self.scenes else []
                lines += [*_wrapped(f"  reference: {self.certified_by[group]} agree to {self.certificates[group]:.1e}"), *_table(rows)]
        for words in ([f"{method} cannot do: {words}" for method, words in self.cannot.items()], self.skipped):
            lines += [""] * bool(words) + [part for line in words for part in _wrapped(line)]
        return "\n".join(lines)


@typed
def plot(measured: WorkPrecision, *, ax: Iterable[Axes] | None = None) -> Figure:
    """Draw error against run time, of inverse dynamics and of every scene, and what settings do to the error.

    The error of a scene is that of the crank angle at its end; under a stiff speed law, which fixes the crank angle, it is that of the
    bearing forces; on springs it is that of the bearing forces and of the slide's place. Further panels show loop gaps of the free run,
    error against the proximal parameter of constraint dynamics, and error against the number of samples of the reduced table. Errors of
    torque, forces and accelerations are shares of their peaks, those of a table are shares of its range. Grey lines show how far the
    reference is known.

    Args:
        measured: result of `compare`.
        ax: the caller's ten axes; by default those of a new figure.

    Raises:
        PinpressError: it is no `WorkPrecision`, Matplotlib is not installed, or ``ax`` are not ten axes.
    """
    looks = _looks(measured)
    with panels(ax, 10, HEIGHT, lambda figure: figure.subplots(5, 2).ravel()) as drawn:
        *over_time, proximal, table = drawn.axes
        lines_of: dict[str, Any] = {}
        charts = (
            (INVERSE_DYNAMICS, "error of the torque", _error),
            (FREE_RUN, ANGLE, _error),
            (CLUTCH, ANGLE, _error),
            (DIE, ANGLE, _error),
            (SPEED_LAW, "error of bearing forces", _force_error),
            (SPRINGS, "error of bearing forces", _force_error),
            (SPRINGS, "error of the slide's place", _error),
            (FREE_RUN, "loop gap [m]", _loop_gap),
        )
        for axes, (group, label, value) in zip(over_time, charts, strict=True):
            for method in _methods(measured, group):
                line = _series(axes, measured.of(group, method), _time, value, looks[method])
                if len(line.get_xdata()):
                    lines_of.setdefault(method, line)
            title = group[0].upper() + group[1:]
            title += ", loops" if value is _loop_gap else ", slide" if group == SPRINGS and value is _error else ""
            _axes(axes, title, "time [ms]", label)
            if value is _error:
                _known(axes, measured, group)
        lines = _settings(proximal, measured, PROXIMAL)
        _axes(proximal, "Constraint dynamics", "proximal parameter mu", "error of accelerations")
        if lines:
            legend(proximal, lines, _methods(measured, PROXIMAL), loc="upper left")
        _settings(table, measured, TABLE)
        _axes(table, "Reduced table", "samples", "error between them")
        _ticks(table, [row.evaluations for row in measured.of(TABLE, "reduced") if row.evaluations][::2])
        drawn.legend(list(lines_of.values()), list(lines_of), loc="outside upper center", ncols=3)
        if drawn.own:
            plain(drawn.figure.supxlabel(f"{measured.press_name}: {measured.scene}", fontsize=SMALL, color=GREY))
    return drawn.figure


def _wrapped(line: str) -> list[str]:
    return textwrap.wrap(line, WIDTH, subsequent_indent="  " + " " * (len(line) - len(line.lstrip())))


def _table(rows: Sequence[Measurement]) -> list[str]:
    """A table of a group: a method a line where all have one setting, else a method and below it a setting a line."""
    heads = ("", "time [ms]", "error", "force error", "loop gap [m]", "energy error", "evaluations")
    alike = len({row.setting for row in rows}) == 1
    cells = [(rows[0].setting if alike else "", *heads[1:]), *(_cells(row, row.method if alike else f"  {row.setting}") for row in rows)]
    kept = [k for k in range(len(heads)) if k < 3 or any(line[k] for line in cells[1:])]
    lines = tables.fitted([[line[k] for k in kept] for line in cells])
    lines[1:] = [f"{line.rstrip()}  {row.problem}" if _is_long(row) else line for line, row in zip(lines[1:], rows, strict=True)]
    for k in range(len(rows), 0, -1):
        if not alike and (k == 1 or rows[k - 1].method != rows[k - 2].method):
            lines.insert(k, f"  {rows[k - 1].method}")
    return [part for line in lines for part in ([line.rstrip()] if len(line.rstrip()) <= WIDTH else _wrapped(line.rstrip()))]


def _is_long(row: Measurement) -> bool:
    """Whether a problem is too long for the column of errors."""
    return len(row.problem) > len("not finite")


def _cells(row: Measurement, name: str) -> tuple[str, ...]:
    errors = [("" if value is None else f"{value:.1e}") for value in (row.error, row.force_error, row.loop_gap, row.energy_error)]
    if row.problem:
        errors[0] = "" if _is_long(row) else row.problem
    return name, f"{1e3 * row.seconds:.4g}", *errors, "" if row.evaluations is None else str(row.evaluations)


def _settings(axes: Axes, measured: WorkPrecision, group: str) -> list[Any]:
    """Draw lines of error over the setting, one a method."""
    lines = []
    for k, method in enumerate(_methods(measured, group)):
        look = {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k], "zorder": 3 + k}
        lines.append(_series(axes, measured.of(group, method), _number, _error, look))
    _known(axes, measured, group)
    return lines


def _known(axes: Axes, measured: WorkPrecision, group: str) -> None:
    """Draw a line at the error to which the reference is known."""
    if group in measured.certificates:
        axes.axhline(measured.certificates[group], color=GREY, linewidth=0.8, zorder=0)


def _ticks(axes: Axes, counts: Sequence[int]) -> None:
    from matplotlib.ticker import NullFormatter  # optional, and slow to import

    axes.set_xticks(counts, [str(count) for count in counts])
    axes.xaxis.set_minor_formatter(NullFormatter())


def _looks(measured: WorkPrecision) -> dict[str, dict[str, Any]]:
    """A colour for each family of methods, a marker for each method, and dashes for fixed steps."""
    methods = [method for group in (INVERSE_DYNAMICS, *SCENES) for method in _methods(measured, group)]
    families: dict[str, str] = {}
    looks: dict[str, dict[str, Any]] = {}
    for method in dict.fromkeys(methods):
        first = method.split(",")[0].split(" ")[0]
        family = FAMILIES.get(first, first)
        colour = families.setdefault(family, COLOURS[len(families) % len(COLOURS)])
        fixed = "Runge-Kutta" in method or "mj_step" in method
        looks[method] = {"color": colour, "marker": MARKERS[len(looks) % len(MARKERS)], "linestyle": (0, (4, 1.5)) if fixed else "-"}
    return looks


def _methods(measured: WorkPrecision, group: str) -> list[str]:
    return list(dict.fromkeys(m.method for m in measured.of(group)))


def _series(axes: Axes, rows: Sequence[Measurement], along: Value, value: Value, look: dict[str, Any]) -> Any:
    """A line through the measurements that have both values, in their order; one without is left out of a logarithmic chart."""
    points = [(x, y) for x, y in ((along(row), value(row)) for row in rows) if x and y]
    return axes.loglog([x for x, _ in points], [y for _, y in points], markersize=4.0, linewidth=1.0, **look)[0]


def _axes(axes: Axes, title: str, across: str, upwards: str) -> None:
    from matplotlib.ticker import LogFormatterSciNotation, LogLocator  # optional, and slow to import

    grid(axes, upwards)
    if math.isfinite(axes.xaxis.get_minpos()):  # an axis without measurements has no range for ticks
        axes.xaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))  # within one decade these are named; more names would overlap
        axes.xaxis.set_minor_formatter(LogFormatterSciNotation(minor_thresholds=(1.0, 1.0)))
    axes.margins(x=0.08, y=0.08)
    axes.set_xlabel(across)
    axes.set_title(title, loc="left")


def _time(row: Measurement) -> float:
    return 1e3 * row.seconds


def _error(row: Measurement) -> float | None:
    return row.error


def _force_error(row: Measurement) -> float | None:
    return row.force_error


def _loop_gap(row: Measurement) -> float | None:
    return row.loop_gap


def _number(row: Measurement) -> float | None:
    return row.number if row.number is not None else row.evaluations
