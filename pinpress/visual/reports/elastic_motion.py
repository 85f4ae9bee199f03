"""The press on its springs in reports: its motion beside the rigid press's, its vibrations, and both over the speed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...common import tables
from ...common.quantities import RPM, Array
from ...dynamics.inputs import Inputs, described
from ...elasticity.impacts import ImpactsByTurn
from ...elasticity.speed_range import CampbellDiagram, ElasticSpeedResponse
from ...elasticity.vibration import ElasticModes
from ...simulation.elastic.description import Elastic
from ...simulation.elastic.run import ElasticRun
from .blocks import Block, Figure, Figures, Follows, Line, LineChart, Section, Table, with_prefix
from .elasticity import stiffness_in_words
from .foundation import mounts_in_words
from .shown import Shown, refuse_others

MOST_BEARINGS = 6  # bearings with a chart of their own, those of the largest forces
MOST_EVENTS = 12  # events in the table
MOST_MODES = 6  # modes with a curve or a band of their own, the lowest
MOST_LINES = 12  # orders with a line of their own
MOST_RESONANCES = 16  # resonances in the table
MOST_PLACES = 4000  # places of an orbit
ROUND = 181  # points of a circle
LOW = 0.03  # share of the stroke above bottom dead centre that is shown about it at least
TURN = 1e-6  # share of a turn by which a run of one turn may be longer
MINUS = "\u2212"


def motion(run: ElasticRun, shown: Shown) -> Section:
    """The section of an elastic run; raises `PinpressError` where it is of another press."""
    refuse_others("run", run.problem.driven.press, shown)
    moving, rigid, bottom = shown.motion is run, run.rigid_slide_position, shown.bottom or 0.0
    states = shown.frames.states if moving else np.arange(len(run.time))
    first = run.driver_coordinates[0]
    along = None if moving else first.scale * run.crank_angle
    across = "" if moving else f"{first.counted} [{first.shown_unit}]"
    follows: Follows = "frames" if moving else "nothing"

    def chart(title: str, unit: str, lines: list[tuple[str, Array]], note: str = "") -> LineChart:
        drawn = [Line(name, values[states], along) for name, values in lines]
        return LineChart(title, unit, drawn, across=across, follows=follows, note=note)

    beside = 1e3 * (run.slide_position - rigid)
    blocks: list[Block] = [Figures(_figures(run, bottom))]
    blocks.append(chart("Slide beside the rigid press", "mm", [("slide", beside)], note="at the same crank angle; below 0 it is deeper"))
    blocks += [*_near_bottom(run, rigid, bottom), *_events(run, bottom)]
    rigid_forces = shown.reactions.bearing_force if moving else None
    largest = sorted(run.peaks, key=lambda name: -run.peaks[name])
    scale = tables.scale("N", list(run.peaks.values()))
    for name in largest[:MOST_BEARINGS]:
        lines = [("on its springs", scale.factor * np.linalg.norm(run.bearing_force[name], axis=1))]
        if rigid_forces is not None:
            lines.append(("rigid", scale.factor * np.linalg.norm(rigid_forces[name], axis=1)))
        blocks.append(chart(f"Force in {name}", scale.unit, lines))
    blocks.append(_peaks(run, largest, rigid_forces))
    note = "Bearings, guides and what else is named yield; the rigid press is at the same crank angle, under the same loads."
    return Section("On its springs", blocks, elastic_in_words(run.elastic), note)


def _figures(run: ElasticRun, bottom: float) -> list[Figure]:
    depth = f"{1e3 * (run.deepest - bottom):+.4g} mm".replace("-", MINUS)
    drive, loads, lost = (float(work[-1]) for work in (run.drive_work, run.load_work, run.lost))
    found = [
        Figure("deepest point", depth, f"off the rigid bottom dead centre, at {run.driver_coordinates[0].shown(run.deepest_angle, '.5g')}"),
        Figure("reverse force", with_prefix(run.reverse_force, "N"), "with which the linkage pulls the slide up"),
        Figure("force on the frame", with_prefix(float(np.linalg.norm(run.shaking_force, axis=1).max()), "N"), "largest"),
        Figure("lost in dampers", with_prefix(lost, "J"), f"of {with_prefix(drive, 'J')} of the drive; loads {with_prefix(loads, 'J')}"),
    ]
    if run.floor_force is not None and run.frame_motion is not None:
        found.append(Figure("force on the floor", with_prefix(float(np.linalg.norm(run.floor_force, axis=1).max()), "N"), "largest"))
        moved = float(np.linalg.norm(run.frame_motion[:, :2], axis=1).max())
        found.append(Figure("frame on its mounts", with_prefix(moved, "m"), "largest displacement of its centre of mass"))
    if run.decay_per_stroke is not None:
        found.append(Figure("decay of vibrations", f"{run.decay_per_stroke:.3g}", "what is left of one after a stroke"))
    return found


def _near_bottom(run: ElasticRun, rigid: Array, bottom: float) -> list[Block]:
    """The slide about its lowest place, by the crank angle from that of the rigid slide; nothing for a run of several turns."""
    if abs(run.crank_angle[-1] - run.crank_angle[0]) > 2 * np.pi * (1 + TURN):
        return []
    lowest = int(rigid.argmin())
    beside = np.degrees((run.crank_angle - run.crank_angle[lowest] + np.pi) % (2 * np.pi) - np.pi)
    highest = max([LOW * float(np.ptp(rigid)), *(1.2 * (place - rigid[lowest]) for _, _, place in run.events)])
    near = np.flatnonzero(rigid - rigid[lowest] <= highest)
    order = near[np.argsort(beside[near], kind="stable")]
    heights = [("on its springs", run.slide_position), ("rigid", rigid)]
    lines = [Line(name, 1e3 * (place[order] - bottom), beside[order]) for name, place in heights]
    across = "crank angle from the rigid bottom dead centre [deg]"
    return [LineChart("Slide near bottom dead centre", "mm", lines, across=across, follows="nothing")]


def _events(run: ElasticRun, bottom: float) -> list[Block]:
    if not run.events:
        return []
    first, rows = run.driver_coordinates[0], []
    for event in tables.shortened(run.events, MOST_EVENTS):
        if event is None:
            rows.append([tables.GAP, "", ""])
            continue
        time, angle, place = event
        rows.append([f"{1e3 * time:.4f}", f"{first.scale * angle:.4f}", f"{1e3 * (place - bottom):.4f}"])
    return [
        Table("Where loads begin and end", ["time [ms]", f"{first.counted} [{first.shown_unit}]", "slide above BDC [mm]"], rows, words=0)
    ]


def _peaks(run: ElasticRun, names: list[str], rigid: Mapping[str, Array] | None) -> Table:
    """Peaks of all bearings, beside those of the rigid press where they are known."""
    scale = tables.scale("N", list(run.peaks.values()))
    heads, rows = ["bearing", f"on its springs [{scale.unit}]"], [[name, scale.shown(run.peaks[name])] for name in names]
    if rigid is not None:
        heads += [f"rigid [{scale.unit}]", "ratio"]
        for row, name in zip(rows, names, strict=True):
            peak = float(np.linalg.norm(rigid[name], axis=1).max())
            row += [scale.shown(peak), f"{run.peaks[name] / peak:.3f}" if peak > 0 else ""]
    return Table("Largest forces", heads, rows)


def elastic_in_words(elastic: Elastic) -> Inputs:
    """What yields, in words."""
    words = [("damping", f"ratio {elastic.damping_ratio:g} of the lowest vibration at bottom dead centre")]
    if elastic.dampers:
        words.append(("dampers", ", ".join(f"{name} {1e-3 * value:.4g} kN s/m" for name, value in elastic.dampers.items())))
    if elastic.crown_mass is not None:
        words.append(("crown", f"{elastic.crown_mass:.6g} kg"))
    for name, each in elastic.clearances.items():
        law = each.law if each.law == "linear" else f"{each.law}, restitution {each.restitution:g}"
        words.append((f"clearance of {name}", f"{1e6 * each.radial:.6g} um radial, contact law {law!r}"))
    if elastic.flexible_links:
        words.append(("flexible links", ", ".join(f"{each.link}, {len(each.natural_frequency)} shapes" for each in elastic.flexible_links)))
    if elastic.mounted_frame is not None:
        words += [("frame", described(elastic.mounted_frame)), ("mounts", mounts_in_words(elastic.mounts))]
    return [*stiffness_in_words(elastic.stiffness), *words]


def modes(found: ElasticModes, shown: Shown) -> Section:
    """The section of the modes; raises `PinpressError` where they are of another press."""
    refuse_others("modes", found._press, shown)
    state, first = found.nearest_to_bottom, shown.motion.driver_coordinates[0]
    frequency = found.natural_frequency / (2 * np.pi)
    rows = []
    for mode, hertz in enumerate(frequency.T):
        yields, moves = found.words(state, mode)
        rows.append([f"{mode + 1}", yields, moves, f"{hertz[state]:.2f}", f"{hertz.min():.2f}", f"{hertz.max():.2f}"])
        rows[-1].append(f"{found.damping_ratio[state, mode]:.4f}")
    blocks: list[Block] = []
    if len(found.crank_angle) > 1:
        order = np.argsort(found.crank_angle)
        along = first.scale * found.crank_angle[order]
        lines = [Line(f"mode {k + 1}", frequency[order, k], along) for k in range(min(frequency.shape[1], MOST_MODES))]
        few = "" if len(lines) == frequency.shape[1] else f"the {len(lines)} lowest of {frequency.shape[1]} modes"
        across = f"{first.counted} [{first.shown_unit}]"
        blocks.append(LineChart("Natural frequencies", "Hz", lines, across=across, follows="position", note=few))
    heads = ["mode", "yields", "moves", "at BDC [Hz]", "least [Hz]", "largest [Hz]", "damping ratio"]
    blocks.append(Table("", heads, rows, words=3))
    held = "the crank held" if found.flywheel is None else "the crank free, with its flywheel"
    note = f"About the rigid pose, {held}; who yields and moves at {first.shown(found.crank_angle[state], '.4g')}, by shares of energy."
    return Section("Vibrations on its springs", blocks, elastic_in_words(found.elastic), note)


def campbell(found: CampbellDiagram, shown: Shown) -> Section:
    """The section of a Campbell diagram; raises `PinpressError` where it is of another press."""
    refuse_others("diagram", found._press, shown)
    speed, frequency = found.speed / RPM, found.modes.natural_frequency / (2 * np.pi)
    ends = np.array([speed[0], speed[-1]])
    highest = float(found.order_frequency(found.orders)[-1]) / (2 * np.pi)
    lines = []
    for mode in range(frequency.shape[1]):
        band = frequency[:, mode]
        if mode >= MOST_MODES or band.min() > highest:
            break
        closed = np.array([ends[0], ends[1], ends[1], ends[0], ends[0]])
        lines.append(Line(f"mode {mode + 1}", np.array([band.min(), band.min(), band.max(), band.max(), band.min()]), closed, strong=True))
    met = sorted({each.order for each in found.resonances if each.mode <= MOST_MODES})[:MOST_LINES]
    lines += [Line(f"order {order}", found.order_frequency(order) / (2 * np.pi), speed) for order in met]
    few = "orders that meet none of these modes are left out" if len(met) < found.orders else ""
    blocks: list[Block] = []
    if len(speed) > 1 and lines:
        blocks.append(LineChart("Campbell diagram", "Hz", lines, across="crank speed [r/min]", follows="nothing", note=few))
    rows = [
        [f"{each.mode}", f"{each.order}", f"{each.speed / RPM:.1f}", f"{each.slowest / RPM:.1f} to {each.fastest / RPM:.1f}"]
        for each in found.resonances[:MOST_RESONANCES]
    ]
    if rows:
        blocks.append(Table("Resonances, the fastest first", ["mode", "order", "speed [r/min]", "somewhere in the turn [r/min]"], rows))
    note = "Orders are harmonics of the stroke. How strongly each shakes the press is not in the diagram."
    return Section("Resonances over the speed", blocks, elastic_in_words(found.modes.elastic), note)


def over_speeds(found: ElasticSpeedResponse, shown: Shown) -> Section:
    """The section of strokes over the speed; raises `PinpressError` where it is of another press."""
    refuse_others("strokes", found._press, shown)
    speed, across = found.speed / RPM, "crank speed [r/min]"
    worst = sorted(found.peaks, key=lambda name: -float(found.peaks[name].max()))[:MOST_BEARINGS]
    scale = tables.scale("N", [float(found.peaks[name].max()) for name in worst])
    depth = Line("slide", 1e3 * found.depth, speed)
    forces = [Line(name, scale.factor * found.peaks[name], speed) for name in worst]
    forces += [Line(name, scale.factor * values, speed) for name, values in (("reverse force", found.reverse_force),)]
    frame = Line("on the frame", scale.factor * found.frame_force, speed)
    blocks: list[Block] = [
        LineChart("Depth below the rigid bottom dead centre", "mm", [depth], across=across, follows="nothing"),
        LineChart("Largest forces in a stroke", scale.unit, forces, across=across, follows="nothing"),
        LineChart("Force on the frame, beside its mean", scale.unit, [frame], across=across, follows="nothing"),
    ]
    note = "The stroke that the press repeats at each speed, held constant."
    return Section("Strokes over the speed", blocks, elastic_in_words(found.elastic), note)


def impacts(found: ImpactsByTurn, shown: Shown) -> Section:
    """The section of a pin with clearance; raises `PinpressError` where it is of another press."""
    refuse_others("pin", found._press, shown)
    scale, orbit = tables.scale("N", found.peak.tolist()), 1e6 * found.orbit[:: max(1, len(found.orbit) // MOST_PLACES)]
    turn = np.linspace(0.0, 2 * np.pi, ROUND)
    radius = 1e6 * found.radial
    chances = [
        Figure("largest force of a turn", with_prefix(found.mean_peak, "N"), f"mean of {len(found.peak)} turns"),
        Figure("its spread", f"{100 * found.spread:.3g} %", "standard deviation by the mean"),
        Figure("impacts a turn", f"{found.impacts.mean():.3g}", f"{100 * found.flight.mean():.2g} % of it in flight"),
        Figure("deepest in the bearing", with_prefix(float(found.depth.max()), "m"), f"beyond the clearance of {radius:.4g} \u00b5m"),
    ]
    lines = [Line("bearing, by the clearance", radius * np.sin(turn), radius * np.cos(turn)), Line("journal", orbit[:, 1], orbit[:, 0])]
    along = "across [\u00b5m]"
    note = "Centre of the journal from that of the bearing; on the circle they touch."
    picture = LineChart("Orbit of the journal", "\u00b5m", lines, across=along, follows="nothing", square=True, note=note)
    heads = ["start", "turn", f"peak [{scale.unit}]", "depth [\u00b5m]", "impacts", "in flight [%]"]
    rows = []
    for k in tables.shortened(range(len(found.peak)), MOST_EVENTS):
        if k is None:
            rows.append([tables.GAP, *[""] * (len(heads) - 1)])
            continue
        cells = [f"{found.start[k] + 1}", f"{found.turn[k] + 1}", scale.shown(float(found.peak[k])), f"{1e6 * found.depth[k]:.3f}"]
        rows.append([*cells, f"{found.impacts[k]}", f"{100 * found.flight[k]:.2f}"])
    words = "Where impacts follow one another, small differences grow: peaks of single turns mean little, their distribution does."
    return Section(f"Journal in {found.bearing}", [Figures(chances), picture, Table("Turn by turn", heads, rows, words=0)], note=words)
