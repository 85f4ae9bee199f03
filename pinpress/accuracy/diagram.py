"""`WorkPrecision` as a figure: error against run time, both logarithmic, and what settings do to the error."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from ..common.arguments import typed
from ..plots.style import COLOURS, GREY, SMALL, drawing, grid, legend, plain
from .measurements import CLUTCH, DIE, FREE_RUN, INVERSE_DYNAMICS, PROXIMAL, SCENES, SPEED_LAW, TABLE, Measurement, WorkPrecision

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEIGHT = 28.0  # [cm]
ANGLE = "error of the crank angle [rad]"
MARKERS = "osD^vP*X<>dhp12348"

Value = Callable[[Measurement], float | None]


@typed
def plot(measured: WorkPrecision) -> Figure:
    """Draw error against run time, of inverse dynamics and of every scene, and what settings do to the error.

    The error of a scene is that of the crank angle at its end; under a stiff speed law, which leaves that no choice, that of the bearing
    forces. Then come loop gaps of the free run, error against the proximal parameter of constraint dynamics, and against the number of
    samples of the reduced table. Errors of torque, forces and accelerations are shares of their peaks, those of a table of its range. Grey
    lines show to what the reference is known.

    Args:
        measured: what `compare` returns.

    Raises:
        PinpressError: not a `WorkPrecision`; Matplotlib is not installed.
    """
    looks = _looks(measured)
    with drawing(HEIGHT) as figure:
        panels = figure.subplots(4, 2)
        drawn: dict[str, Any] = {}
        for axes, group, label, value in (
            (panels[0, 0], INVERSE_DYNAMICS, "error of the torque", _error),
            (panels[0, 1], FREE_RUN, ANGLE, _error),
            (panels[1, 0], CLUTCH, ANGLE, _error),
            (panels[1, 1], DIE, ANGLE, _error),
            (panels[2, 0], SPEED_LAW, "error of bearing forces", _force_error),
            (panels[2, 1], FREE_RUN, "loop gap [m]", _loop_gap),
        ):
            for method in _methods(measured, group):
                line = _series(axes, measured.of(group, method), _time, value, looks[method])
                if len(line.get_xdata()):
                    drawn.setdefault(method, line)
            title = group[0].upper() + group[1:]
            _axes(axes, f"{title}, loops" if value is _loop_gap else title, "time [ms]", label)
            if value is _error:
                _known(axes, measured, group)
        lines = _settings(panels[3, 0], measured, PROXIMAL)
        _axes(panels[3, 0], "Constraint dynamics", "proximal parameter mu", "error of accelerations")
        if lines:
            legend(panels[3, 0], lines, _methods(measured, PROXIMAL), loc="upper left")
        _settings(panels[3, 1], measured, TABLE)
        _axes(panels[3, 1], "Reduced table", "samples", "error between them")
        _ticks(panels[3, 1], [row.evaluations for row in measured.of(TABLE, "reduced") if row.evaluations][::2])
        legend(figure, list(drawn.values()), list(drawn), loc="outside upper center", ncols=3)
        plain(figure.supxlabel(f"{measured.press_name}: {measured.scene}", fontsize=SMALL, color=GREY))
    return figure


def _settings(axes: Axes, measured: WorkPrecision, group: str) -> list[Any]:
    """Lines of error over the setting, one a method."""
    lines = []
    for k, method in enumerate(_methods(measured, group)):
        look = {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k], "zorder": 3 + k}
        lines.append(_series(axes, measured.of(group, method), _number, _error, look))
    _known(axes, measured, group)
    return lines


def _known(axes: Axes, measured: WorkPrecision, group: str) -> None:
    """A line at what the reference is known to."""
    if group in measured.certificates:
        axes.axhline(measured.certificates[group], color=GREY, linewidth=0.8, zorder=0)


def _ticks(axes: Axes, counts: Sequence[int]) -> None:
    from matplotlib.ticker import NullFormatter  # optional, and slow to import

    axes.set_xticks(counts, [str(count) for count in counts])
    axes.xaxis.set_minor_formatter(NullFormatter())


def _looks(measured: WorkPrecision) -> dict[str, dict[str, Any]]:
    """A colour for what pinpress, and what every other program offers; a marker for each of its methods; fixed steps dashed."""
    methods = [method for group in (INVERSE_DYNAMICS, *SCENES) for method in _methods(measured, group)]
    families: dict[str, str] = {}
    looks: dict[str, dict[str, Any]] = {}
    for method in dict.fromkeys(methods):
        family = {"plane": "reduced", "pinocchio": "constraint"}.get(method, method.split(",")[0].split(" ")[0])
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
    grid(axes, upwards)
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
