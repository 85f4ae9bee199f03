"""Ratings in reports: what a press may exert at each height, what limits it, and what the process takes of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common import tables
from ...common.outlets.described import charts_of
from ...common.quantities import Array
from ...dynamics.described import described as of_reactions
from ...kinematics.motion import is_cycle
from ...ratings.along_motion import MotionRatings, limits_in_words
from ...ratings.permissible_force import capacities_in_words
from ...ratings.rating import PressRatings, conditions_in_words, data_in_words, listed_heights
from .blocks import Block, Facts, Figure, Figures, Line, LineChart, Section, Table, with_prefix
from .shown import Shown, refuse_others

ACROSS = "height above bottom dead centre [mm]"
NEAR = 2.0  # reach of the chart near bottom dead centre, divided by the largest height at which another limit begins to govern


def section(ratings: PressRatings, shown: Shown) -> Section:
    """The section of ratings; raises `PinpressError` where they are of another press."""
    refuse_others("rating", ratings._press, shown)
    use = ratings.utilisation(shown.reactions)
    blocks: list[Block] = [
        *_figures(ratings, shown, use),
        *_forces(ratings, shown),
        *_use(ratings.utilisation(shown.drawn)[shown.states], shown),
        *_work(ratings),
    ]
    blocks += [Facts("Main data", data_in_words(ratings)), _table(ratings)]
    return Section(
        "Ratings", blocks, [*capacities_in_words(ratings.capacities, ratings.driver_coordinate)], f"At {conditions_in_words(ratings)}."
    )


def along_motion(ratings: MotionRatings, shown: Shown) -> Section:
    """The section of ratings along the motion of the page; raises `PinpressError` where they are of another press or motion."""
    refuse_others("rating", ratings._press, shown)
    use, states = ratings.utilisation(shown.reactions), shown.frames.states
    process, permissible = shown.drawn.process_force[shown.states], np.interp(shown.time, shown.frames.time, ratings.force[states])
    least, most = int(ratings.force.argmin()), int(use.argmax())
    figures = [Figure("least permissible force", with_prefix(float(ratings.force[least]), "N"), f"at {shown.motion.place(least)}")]
    if use.any():
        figures.append(Figure("of the permissible force", f"{100 * use[most]:.4g} %", f"at {shown.motion.place(most)}"))
    scale = tables.scale("N", [ratings.capacities.nominal_force])
    lines = [Line("permissible force", scale.factor * ratings.force[states], strong=True)]
    lines += [Line(name, scale.factor * force[states]) for name, force in ratings.limits.items()]
    if use.any():
        lines.append(Line("process force", scale.factor * process, shown.own_along))
    blocks: list[Block] = [Figures(figures), LineChart("Permissible process force", scale.unit, lines), *_use(process / permissible, shown)]
    note = "In this motion, beside weights and inertia forces" + ", with friction" * bool(ratings.friction)
    return Section("Ratings", blocks, limits_in_words(ratings), f"{note}.")


def _figures(ratings: PressRatings, shown: Shown, use: Array) -> list[Block]:
    if not shown.reactions.process_force.any():
        return []
    at, first = int(use.argmax()), ratings.driver_coordinate
    height = f"{1e3 * (shown.motion.slide_position[at] - (shown.bottom or 0.0)):.4g} mm above bottom dead centre"
    place = first.shown(float(np.ravel(shown.motion.crank_angle[at])[0]), ".4g")
    found = [Figure("of the permissible force", f"{100 * use[at]:.4g} %", f"at {place}, {height}")]
    strokes = (shown.motion.period_turns or 1) / ratings.turns
    for name, energy in ratings.energies.items() if is_cycle(shown.motion) else ():
        share = shown.reactions.process_work / strokes / energy
        found.append(Figure(f"of the {name}", f"{100 * share:.4g} %", "by the work of a stroke"))
    return [Figures(found)]


def _forces(ratings: PressRatings, shown: Shown) -> Sequence[Block]:
    """The permissible force with all limits over the stroke, and near bottom dead centre."""
    scale, height = tables.scale("N", [ratings.capacities.nominal_force]), 1e3 * ratings.height
    lines = [Line("permissible force", scale.factor * ratings.force, height, strong=True)]
    lines += [Line(name, scale.factor * force, height) for name, force in ratings.limits.items()]
    process = charts_of(of_reactions(shown.reactions)).get("force_height")
    if process is not None and shown.bottom is not None:
        pairs = np.column_stack([1e3 * process.curves[0].x, scale.factor * process.curves[0].y])
        drawn = pairs[shown.states]
        lines.append(Line("process force", drawn[:, 1], drawn[:, 0], at_frames=pairs[shown.keys]))
    nominal = ratings.capacities.nominal_height
    marks = [mark for mark in (*ratings.changes, *([] if nominal is None else [nominal])) if mark < ratings.stroke / 2]
    reaches = {"Permissible force": ratings.stroke}
    if marks:
        reaches["Permissible force near bottom dead centre"] = min(NEAR * max(marks), ratings.stroke)
    return [
        LineChart(title, scale.unit, lines, across=ACROSS, follows="height", reach=(0.0, 1e3 * reach)) for title, reach in reaches.items()
    ]


def _use(use: Array, shown: Shown) -> list[Block]:
    """Share of the permissible force over the motion, (c,) in the states that are drawn."""
    if not use.any():
        return []
    return [LineChart("Process force by permissible force", "%", [Line("use", 100 * use, shown.own_along)])]


def _work(ratings: PressRatings) -> list[Block]:
    """Work of the permissible force from a height down, beside the energies that limit it."""
    scale, height = tables.scale("J", [float(ratings.work.max()), *ratings.energies.values()]), 1e3 * ratings.height
    lines = [Line("work", scale.factor * ratings.work, height)]
    lines += [Line(name, np.full(2, scale.factor * energy), height[[0, -1]]) for name, energy in ratings.energies.items()]
    return [
        LineChart(
            "Work of the permissible force down to bottom dead centre",
            scale.unit,
            lines,
            across=ACROSS,
            follows="height",
            reach=(0.0, 1e3 * ratings.stroke),
        )
    ]


def _table(ratings: PressRatings) -> Table:
    first = ratings.driver_coordinate
    force, work = tables.scale("N", [ratings.capacities.nominal_force]), tables.scale("J", [float(ratings.work.max())])
    heads = ["limited by", "height [mm]", f"{first.position} [{first.shown_unit}]", f"force [{force.unit}]", f"work [{work.unit}]"]
    turn = 360.0 * ratings.turns
    rows = []
    for k in listed_heights(ratings):
        position = first.scale * float(ratings.crank_angle[k])
        place = f"{position % turn if first.turns else position:.2f}"
        numbers = [f"{1e3 * ratings.height[k]:.3f}", place, force.shown(float(ratings.force[k])), work.shown(float(ratings.work[k]))]
        rows.append([ratings.limited_by[k], *numbers])
    return Table("Permissible force, by the capacities given", heads, rows)
