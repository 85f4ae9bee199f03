"""The press on its springs in reports: its motion beside the rigid press's, its vibrations, and both over the speed."""

from __future__ import annotations

import numpy as np

from ...common import tables
from ...common.quantities import RPM
from ...elasticity.impacts import ImpactsByTurn
from ...elasticity.speed_range import CampbellDiagram, ElasticSpeedResponse
from ...elasticity.vibration import ElasticModes
from ...simulation.elastic.parts_in_words import elastic_in_words
from .blocks import Block, Figure, Figures, Line, LineChart, Section, Table, with_prefix
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
