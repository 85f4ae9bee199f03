"""The elastic press in reports: what yields at the slide, bottom dead centre over the speed, and the blow of a break-through."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common import tables
from ...common.quantities import RPM, Array
from ...dynamics.inputs import written
from ...elasticity.breakthrough import SnapThroughResponse
from ...elasticity.slide_under_load import DeflectedSlide, ElasticDeadCentre
from ...elasticity.unit_load import SlideCompliance
from ...kinematics.motion import refuse_motion_of_another
from ...simulation.elastic.parts_in_words import stiffness_in_words
from .blocks import BarChart, Block, Figure, Figures, Line, LineChart, Section, Table, with_prefix
from .shown import Shown, refuse_others

MOST_PARTS = 6  # parts with a colour of their own; the others are drawn together
MOST_ROWS = 16  # rows of the table of speeds


def compliance(found: SlideCompliance, shown: Shown) -> Section:
    """The section of a compliance; raises `PinpressError` where it is of another press."""
    refuse_others("compliance", found._press, shown)
    order, first = np.argsort(found.crank_angle), found.coordinate
    along = first.scale * found.crank_angle[order]
    lines = [Line(name, 1e9 * part[order], along) for name, part in found.largest_parts(MOST_PARTS)]
    across = f"{first.counted} [{first.shown_unit}]"
    at_bottom = sorted(found.bottom_shares.items(), key=lambda item: -round(item[1], 9))
    figures = [Figure("stiffness at bottom dead centre", f"{1e-6 * found.bottom_stiffness:.4g} kN/mm")]
    nominal = float(shown.reactions.process_force.max(initial=0.0))
    if nominal > 0:
        place = int(shown.reactions.process_force.argmax())
        height = float(shown.motion.slide_position[place])
        at = float(np.interp(height, *_by_position(found)))
        figures.append(Figure("yields under the process", f"{1e3 * at * nominal:.4g} mm", "at its largest force"))
    blocks: list[Block] = [
        Figures(figures),
        LineChart("Compliance at the slide, by parts", "µm/kN", lines, across=across, follows="position", stacked=True),
        BarChart("Shares of the deflection at bottom dead centre", "%", *_bars(at_bottom)),
    ]
    note = "Displacement of the slide against the table along its guide under a force there, with the crank held; to first order."
    return Section("Elastic press", blocks, stiffness_in_words(found.stiffness), note)


def _bars(shares: Sequence[tuple[str, float]]) -> tuple[list[str], dict[str, list[float]]]:
    return [name for name, _ in shares], {"share": [100 * share for _, share in shares]}


def _by_position(found: SlideCompliance) -> tuple[Array, Array]:
    """Slide positions, rising, and the compliance there; of two crank angles with one position both are kept."""
    order = np.argsort(found.slide_position)
    return found.slide_position[order], found.compliance[order]


def deflection(found: DeflectedSlide, shown: Shown) -> Section:
    """The section of a deflection; raises `PinpressError` where it is of another press."""
    motion = found.motion
    refuse_motion_of_another(shown.press, motion)
    same = len(motion.crank_angle) == len(shown.motion.crank_angle) and np.array_equal(motion.crank_angle, shown.motion.crank_angle)
    states = shown.frames.states if same else np.arange(len(found.deflection))
    first = motion.driver_coordinates[0]
    along = None if same else first.scale * motion.crank_angle
    parts = sorted(found.parts.items(), key=lambda item: -float(np.abs(item[1]).max()))[:MOST_PARTS]
    lines = [Line("all", 1e3 * found.deflection[states], along, strong=True)]
    lines += [Line(name, 1e3 * part[states], along) for name, part in parts]
    chart = LineChart(
        "Deflection of the slide",
        "mm",
        lines,
        across="" if same else f"{first.counted} [{first.shown_unit}]",
        follows="frames" if same else "position",
        note="" if len(parts) == len(found.parts) else f"of {len(found.parts)} parts the {len(parts)} that move it most",
    )
    low, high = float(found.deflection.min()), float(found.deflection.max())
    ends = {"pressed down by at most": -min(low, 0.0), "pushed up by at most": max(high, 0.0)}
    figures = [Figure(name, f"{1e3 * value + 0.0:.4g} mm") for name, value in ends.items()]
    return Section("Deflection under load, weight and inertia", [Figures(figures), chart])


def dead_centre(found: ElasticDeadCentre, shown: Shown) -> Section:
    """The section of bottom dead centre over the speed; raises `PinpressError` where it is of another press."""
    refuse_others("dead centre", found._press, shown)
    order = np.argsort(found.speed)
    speed, shift = found.speed[order] / RPM, 1e6 * found.shift[order]
    chart = LineChart("Shift of bottom dead centre", "µm", [Line("shift", shift, speed)], across="crank speed [r/min]", follows="nothing")
    rows = [[f"{w:.5g}", f"{s:+.3f}", f"{np.degrees(a):.4f}"] for w, s, a in zip(speed, shift, found.crank_angle[order], strict=True)]
    table = Table("", ["speed [r/min]", "shift [µm]", "at [deg]"], [rows[k] for k in _even(len(rows))], words=0)
    standing = 1e6 * (found.standstill_position - found.rigid_position)
    figures = [Figure("at standstill", f"{standing:+.4g} µm".replace("-", "\u2212"), "off the rigid bottom dead centre")]
    note = "Deeper is negative; relative to standstill."
    return Section("Bottom dead centre over the speed", [Figures(figures), chart, table], note=note)


def _even(count: int) -> list[int]:
    """Numbers of the rows that are listed, the first and the last among them."""
    return [int(k) for k in np.linspace(0, count - 1, min(count, MOST_ROWS)).round()]


def breakthrough(found: SnapThroughResponse, shown: Shown) -> Section:  # it is of no press by its name
    """The section of a break-through."""
    figures = [
        Figure("reverse load", with_prefix(found.reverse_force, "N"), f"{100 * found.reverse_ratio:.4g} % of the force before"),
        Figure("overshoot", f"{1e3 * found.overshoot:.4g} mm"),
        Figure("peak acceleration", f"{found.peak_acceleration:.4g} m/s²"),
        Figure("vibration after it", f"{found.frequency / (2 * np.pi):.4g} Hz"),
        Figure("stored energy", with_prefix(found.energy, "J")),
    ]
    scale, time = tables.scale("N", [found.force]), 1e3 * found.time
    force = Line("force of the spring", scale.factor * found.spring_force, time)
    across = "time from break-through [ms]"
    displacement = Line("slide", 1e3 * found.displacement, time)
    blocks: list[Block] = [
        Figures(figures),
        LineChart("Force on the linkage", scale.unit, [force], across=across, follows="nothing", note="below 0 it is pulled"),
        LineChart("Displacement", "mm", [displacement], across=across, follows="nothing"),
    ]
    given = {"force": (found.force, "N"), "stiffness": (found.stiffness, "N/m"), "mass": (found.mass, "kg")}
    given |= {"damping ratio": (found.damping_ratio, "-")}
    given |= {"break time": (found.break_time, "s"), "clearance": (found.clearance, "m")}
    words = ", ".join(f"{name} {written(value, unit)}" for name, (value, unit) in given.items())
    return Section("Break-through", blocks, [("break-through", words)])
