"""A report: one web page with the recording of a press, and charts of its motion, torque and forces that follow it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from ...common.arguments import expect, typed
from ...common.errors import PinpressError
from ...common.errors import shown as as_text
from ...common.outlets import described
from ...common.results import Tabular
from ...drives.transmission import Flywheel
from ...dynamics.inverse_dynamics import inverse_dynamics
from ...dynamics.reactions import Reactions
from ...kinematics.described import along_motion
from ...kinematics.motion import Motion
from ...linkage.linkage import Linkage
from ...simulation.run import Run, inputs_of
from .. import pages
from ..pages import packed
from ..recording import key_frames, scene, shaft_flywheels
from .drawn import figure, section, sections_of
from .extremes import table_of_extremes
from .header import Header
from .shown import Shown, as_shown, before_shown, in_words

if TYPE_CHECKING:
    from ...ratings.rating import PressRatings


@typed
def report(
    press: Linkage,
    motion: Motion,
    path: str | os.PathLike[str],
    *,
    reactions: Reactions | None = None,
    traces: Sequence[tuple[str, ArrayLike]] = (),
    before: Reactions | None = None,
    results: Sequence[Tabular] = (),
    flywheel: Flywheel | Mapping[str, Flywheel] | None = None,
    header: Header | None = None,
    inputs: Sequence[tuple[str, str]] = (),
    before_name: str = "",
    before_inputs: Sequence[tuple[str, str]] = (),
) -> Path:
    """Write a self-contained page with the recording (see `record`) and interactive charts whose cursor follows it; return the path.

    At its top a table has the numbers that are looked for first and all that have a limit, with the share of the limit; beside ``before``
    also its numbers, and the changes. Charts show slide height, velocity and acceleration; driving torque, crank speed if it is not
    constant, and the energy balance of a stroke; every bearing and guide force, its magnitude, components, and polar diagrams in world axes
    and in the axes of the loaded link; moments in guides; shaking force with its harmonics, and shaking moment. Under process loads, charts
    show the process force over the crank angle and over the slide's height. For a run, a chart shows the motor's torque over the speed,
    with the motor's curve. A table lists the extremes, see `measures.extremes`. Curves have the recording's key frames, at most 360 a turn,
    and the states on both sides of each step of the load. For an `ElasticRun` these forces are those of the rigid press; a separate section
    compares them with the forces of the springs, and shows the slide's depth and the places where loads begin and end. At its end the page
    states what was computed: press, file and its SHA-256, motion, drives, loads, friction, version and day. Without WebGL a drawing stands
    in place of the moving press.

    Args:
        press: As for `record`.
        motion: As for `record`.
        path: Path of the file, as for `record`.
        reactions: Reactions to this motion; by default those without loads and friction. Give them for a run under loads.
        traces: As for `record`.
        before: Reactions of another press, or of this one at another operating point. They are drawn as dashed curves, and the table also
            shows their ranges.
        results: Other results of the press, each of which adds a section: `PressRatings`, whose permissible force is drawn next to the
            process force too, and `MotionRatings`; `PinRatings`, `LinkLoads`, `StoppingTimes` and `SafetyDistance`; `DriveChoice`;
            a `Run` of the press next to this motion; `BalancedPress` and `TradeOffCurve`;
            `SlideCompliance`, `DeflectedSlide`, `ElasticDeadCentre` and `SnapThroughResponse`; `LoadedGuide`; `ElasticRun`, `ElasticModes`,
            `CampbellDiagram`, `ElasticSpeedResponse` and `ImpactsByTurn`; `ElasticFrame`, `MountedPress`, `VibrationModes`, `FrameMotion`,
            `SpeedResponse`, `WhirlDiagram`, `LiftingMotion` and `Isolation`;
            `ServoMotion`, `MotionOptimum`, `MotionComparison`, `MotorChoice`, `EnergyStore` and `CamPoints`; `DeadCentreScatter` and its
            `Scatter`, `AllocatedTolerances`, `SlidePlay`, `DeadCentresInClearances`, `HeatShift`, `AccuracyBudget` and `SlideParallelism`.
        flywheel: As for `record`; by default those of a run, of the motion or among the results.
        header: Language of the page, and title, company, logo and other parts of a title block, which stands at the top of the page and of
            its first sheet; by default the page is in English, and the press's name is the title.
        inputs: Additional rows for the inputs of the page: pairs of name and text, such as the files from which the press was made.
        before_name: Name of the dashed curves, such as "at 50 r/min"; by default the name of their press.
        before_inputs: Additional rows for the inputs of the dashed curves.

    Raises:
        PinpressError: As `record`, or a run under loads has no reactions, Plotly is not installed, a result is of another press or of a
            kind that has no section, an input is not a pair of texts, or ``before`` is over another quantity (time or crank angle) than the
            motion, or turns the other way.
        UnknownNameError: As `record`.
    """
    if odd := [type(result).__name__ for result in results if not isinstance(result, Tabular)]:
        raise PinpressError(f"results: a report has no section for an object of type {odd[0]}; give results such as ratings or runs")
    frames = key_frames(press, motion)
    if reactions is None and isinstance(motion, Run) and any(force.drive is None for force in motion.problem.driven.forces):
        raise PinpressError("the run has loads: give its reactions with them, inverse_dynamics(press, run, loads=[...])")
    if reactions is None:
        reactions = inverse_dynamics(press, motion)
    if before is not None:
        expect("before", before, Reactions, "inverse_dynamics")
    rows, before_rows = _rows("inputs", inputs), _rows("before_inputs", before_inputs)
    player = scene(press, motion, frames, reactions, traces, shaft_flywheels(press, flywheel, [motion, *results]))
    shown = as_shown(reactions, frames)
    dashed = None if before is None else before_shown(before, motion)
    header = header or Header()
    content = {"header": header.block(), **_content(shown, dashed, results, rows, before_name, before_rows)}
    data = player | {"report": content}
    libraries = {"viewer": pages.meshcat(), "plotly": pages.plotly()}
    page = pages.page("report.html", header.heading(press.name), data, libraries, header.language)
    return pages.write(path, page)


def _rows(name: str, given: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Additional rows of inputs; raises PinpressError if a row is not a pair of texts."""
    rows = [tuple(row) if isinstance(row, Sequence) else (row,) for row in given]
    if odd := [row for row in rows if len(row) != 2 or not all(isinstance(part, str) for part in row)]:
        raise PinpressError(f'{name} has {as_text(odd[0])}: give pairs of texts, such as ("drawing", "4711-03")')
    return [(name, words) for name, words in rows]


def _content(
    shown: Shown,
    before: Shown | None,
    results: Sequence[Tabular],
    rows: Sequence[tuple[str, str]],
    before_name: str,
    before_rows: Sequence[tuple[str, str]],
) -> dict[str, Any]:
    """Data of the charts of the page; ``rows``: additional inputs."""
    if isinstance(shown.motion, Run) and not any(result is shown.motion for result in results):
        results = [shown.motion, *results]
    ratings = None
    if results:
        from ...ratings.rating import PressRatings  # slow to import, and most reports do not need it

        # the permissible force next to the process force is that of the first ratings
        ratings = next((result for result in results if isinstance(result, PressRatings)), None)
    more = [part for result in results for part in sections_of(result, shown)]
    drawn = [section(_with_limit(part, ratings), shown, before, headlines=False) for part in shown.sections]
    drawn = [part for part in drawn if part["blocks"]] + [section(part, shown) for part in more] + [table_of_extremes(shown, before)]
    abscissa, heights = along_motion(shown.motion), shown.heights
    inputs = [{"title": "", "rows": _with_rows(_inputs(shown, more), rows)}]
    if before is not None:
        others = _with_rows(inputs_of(before.reactions), before_rows)
        inputs.append({"title": "Dashed curves, where they differ", "rows": [row for row in others if row not in inputs[0]["rows"]]})
    count = len(shown.motion.crank_angle)
    beside = "" if before is None else f"; dashed: {before_name or before.press.name}, {in_words(before.motion)}"
    return {
        "subtitle": f"{in_words(shown.motion)}, {count} {'states' if count > 1 else 'state'}{beside}",
        "inputs": inputs,
        "figures": _verdict([*shown.sections, *more], [] if before is None else before.sections),
        "over": {"quantity": abscissa.name, "unit": {"rad": "deg", "m": "mm"}.get(abscissa.quantity, abscissa.quantity)},
        "before": None if before is None else packed(before.along, "before"),
        "dashed": "" if before is None else before_name or before.press.name,
        "heights": None if heights is None else packed(heights, "height"),
        "period": shown.period,
        "sections": drawn,
    }


def _verdict(sections: Sequence[described.Section], before: Sequence[described.Section]) -> list[dict[str, Any]]:
    """Numbers that are looked for first or have a limit, with the share of it, and beside a press before with its numbers and changes."""
    old = {(part.title, number.name): number for part in before for number in part.figures}
    rows = []
    for part in sections:
        for number in part.figures:
            if not (number.kind or number.limit is not None):
                continue
            then = old.get((part.title, number.name))
            change = ""
            if then is not None and not isinstance(number.value, str) and not isinstance(then.value, str) and then.value:
                share = 100 * (number.value / then.value - 1)
                change = f"{share:+.1f} %" if abs(share) >= 0.05 else "the same"
            more: dict[str, Any] = {"use": number.use, "before": "" if then is None else figure(then)["value"], "change": change}
            rows.append(dict[str, Any](figure(number)) | {key: value for key, value in more.items() if value not in ("", None)})
    return rows


def _with_limit(part: described.Section, ratings: PressRatings | None) -> described.Section:
    """A section with the permissible force next to the process force."""
    if ratings is None:
        return part
    permissible = described.Curve("permissible force", ratings.force, ratings.height)
    blocks: list[described.Block] = []
    for block in part.blocks:
        if isinstance(block, described.Chart) and block.name == "force_height":
            block = replace(block, curves=[*block.curves, permissible])
        blocks.append(block)
    return replace(part, blocks=blocks)


def _inputs(shown: Shown, more: Sequence[described.Section]) -> list[tuple[str, str]]:
    """The inputs of the page and of its other results."""
    *rows, computed_by = inputs_of(shown.reactions)
    for part in more:
        rows += [row for row in part.inputs if row not in rows]
    return [*rows, computed_by]


def _with_rows(inputs: Sequence[tuple[str, str]], rows: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Inputs with additional rows before the last row, which names the version and the date."""
    return [*inputs[:-1], *rows, inputs[-1]]
