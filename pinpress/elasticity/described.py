"""What results of elastic presses show: compliance at the slide, bottom dead centre over the speed, break-through, vibrations, impacts."""

from __future__ import annotations

import numpy as np

from ..common.outlets.described import Along, Bars, Block, Chart, Column, Curve, Figure, Mark, Section, Table
from ..common.quantities import Array, quantity
from ..dynamics.inputs import written
from ..dynamics.reactions import Reactions
from ..kinematics.described import along_motion, kinds_of_drivers, over_angle
from ..kinematics.motion import refuse_motion_of_another
from ..kinematics.slide_path import dead_centres
from ..simulation.elastic.parts_in_words import elastic_in_words, stiffness_in_words
from .breakthrough import SnapThroughResponse
from .guide_surfaces import LoadedGuide
from .impacts import ImpactsByTurn
from .slide_under_load import DeflectedSlide, ElasticDeadCentre
from .speed_range import CampbellDiagram, ElasticSpeedResponse
from .unit_load import SlideCompliance
from .vibration import ElasticModes

MOST_PARTS = 6  # parts with a separate colour; the others are drawn together
MOST_BEARINGS = 6  # bearings with a separate curve, those with the largest forces
MOST_MODES = 6  # modes with a separate curve or band, the lowest ones
MOST_LINES = 12  # orders with a separate line
MOST_PLACES = 4000  # places of an orbit
ROUND = 181  # points of a circle
SPEED = "crank speed"


def compliance(found: SlideCompliance, page: Reactions | None = None) -> tuple[Section, ...]:
    """The compliance at the slide, by parts; with the process of a page also the deflection under this process."""
    order, first = np.argsort(found.crank_angle), found.coordinate
    along = Along(first.counted, first.unit, found.crank_angle[order])
    curves = [Curve(name, part[order]) for name, part in found.largest_parts(MOST_PARTS)]
    shares = dict(sorted(found.bottom_shares.items(), key=lambda item: -round(item[1], 9)))  # equal shares differ by rounding errors
    figures = [Figure("stiffness at bottom dead centre", found.bottom_stiffness, "N/m", kind="accuracy")]
    nominal = 0.0 if page is None else float(page.process_force.max(initial=0.0))
    if page is not None and nominal > 0:
        height = float(page.motion.slide_position[int(page.process_force.argmax())])
        at = float(np.interp(height, *_by_position(found)))
        figures.append(Figure("yields under the process", at * nominal, "m", "at its largest force"))
    blocks: list[Block] = [
        Chart("compliance", "Compliance at the slide, by parts", "m/N", along, curves, stacked=True),
        Bars("shares", "Shares of the deflection at bottom dead centre", "share", list(shares), {"share": np.array([*shares.values()])}),
        Table("shares", "", [Column("part", list(shares)), Column("share of the deflection", [*shares.values()], "share")]),
    ]
    note = "Displacement of the slide against the table along its guide under a force there, with the crank held; to first order."
    if by_section := [f"{rod.name} of {rod.basis}" for rod in found.stiffness.rods if rod.basis]:
        note += f" Rods by E A / l: {', '.join(by_section)}."
    rigid = {
        "links": [name for name in found._press.links if name not in (found._press.root, *(rod.link for rod in found.stiffness.rods))],
        "bearings": [name for name in found._press.bearings if name not in found.stiffness.bearings],
    }
    note += "".join(f" Rigid {what}: {', '.join(names)}." for what, names in rigid.items() if names)
    return (Section("Elastic press", figures, blocks, stiffness_in_words(found.stiffness), note, found._press, "compliance"),)


def _by_position(found: SlideCompliance) -> tuple[Array, Array]:
    """Slide positions, rising, and the compliance there. Two crank angles with the same position are both kept."""
    order = np.argsort(found.slide_position)
    return found.slide_position[order], found.compliance[order]


def deflection(found: DeflectedSlide, page: Reactions | None = None) -> tuple[Section, ...]:
    """The deflection of the slide over a motion; raises `PinpressError` if it is of another press than the page."""
    motion = found.motion
    same = False
    if page is not None:
        refuse_motion_of_another(page._press, motion)
        shown = page.motion.crank_angle
        same = len(motion.crank_angle) == len(shown) and np.array_equal(motion.crank_angle, shown)
    along = along_motion(page.motion) if same and page is not None else _along(found)
    parts = sorted(found.parts.items(), key=lambda item: -float(np.abs(item[1]).max()))[:MOST_PARTS]
    curves = [Curve("all", found.deflection, look="strong"), *(Curve(name, part) for name, part in parts)]
    note = "" if len(parts) == len(found.parts) else f"Of {len(found.parts)} parts the {len(parts)} that move it most."
    chart = Chart("deflection", "Deflection of the slide", "m", along, curves, note=note)
    states, deflections = found._found
    figures = []
    for name, sign in (("pressed down by at most", -1.0), ("pushed up by at most", 1.0)):
        at = int((sign * deflections).argmax())
        figures.append(Figure(name, max(sign * float(deflections[at]), 0.0), "m", f"at {states.place(at)}", kind="accuracy"))
    return (Section("Deflection under load, weight and inertia", figures, [chart]),)


def _along(found: DeflectedSlide) -> Along:
    motion = found.motion
    return over_angle(motion) if motion.crank_angle.ndim == 1 and len(kinds_of_drivers(motion)) == 1 else along_motion(motion)


def dead_centre(found: ElasticDeadCentre, page: Reactions | None = None) -> tuple[Section, ...]:
    """Bottom dead centre over the speed."""
    order = np.argsort(found.speed)
    speed, shift = found.speed[order], found.shift[order]
    chart = Chart("shift", "Shift of bottom dead centre", "m", Along(SPEED, "rad/s", speed), [Curve("shift", shift)])
    strokes = speed * dead_centres(found._press).strokes_per_turn
    columns = [
        Column("speed", speed.tolist(), "rad/s"),
        Column("strokes/min", (strokes * 30 / np.pi).tolist()),
        Column("shift", shift.tolist(), "m"),
        Column("at", found.crank_angle[order].tolist(), "angle"),
    ]
    standing = found.standstill_position - found.rigid_position
    figures = [Figure("at standstill", standing, "m", "off the rigid bottom dead centre", kind="accuracy")]
    note = "Deeper is negative; relative to standstill."
    table = Table("shift", "", columns, most=16)
    return (Section("Bottom dead centre over the speed", figures, [chart, table], (), note, found._press, "dead centre"),)


def breakthrough(found: SnapThroughResponse, page: Reactions | None = None) -> tuple[Section, ...]:
    """A break-through; the result does not name a press."""
    before = f"{quantity('share').text(found.reverse_ratio, 4)} of the force before"
    figures = [
        Figure("reverse load", found.reverse_force, "N", before, kind="force"),
        Figure("overshoot", found.overshoot, "m"),
        Figure("peak acceleration", found.peak_acceleration, "m/s2"),
        Figure("vibration after it", found.frequency, "frequency"),
        Figure("stored energy", found.energy, "J"),
    ]
    along = Along("time from break-through", "s", found.time)
    force = Curve("force of the spring", found.spring_force)
    share = Curve("force by that at break-through", found.spring_force / found.force)
    blocks: list[Block] = [
        Chart("spring_force", "Force on the linkage", "N", along, [force], note="Below 0 it is pulled."),
        Chart("spring_share", "Share of the force at break-through", "-", along, [share], detail=True),
        Chart("displacement", "Displacement", "m", along, [Curve("slide", found.displacement)]),
    ]
    given = {"force": (found.force, "N"), "stiffness": (found.stiffness, "N/m"), "mass": (found.mass, "kg")}
    given |= {"damping ratio": (found.damping_ratio, "-")}
    given |= {"break time": (found.break_time, "s"), "clearance": (found.clearance, "m")}
    words = ", ".join(f"{name} {written(value, unit)}" for name, (value, unit) in given.items())
    return (Section("Break-through", figures, blocks, [("break-through", words)]),)


def modes(found: ElasticModes, page: Reactions | None = None) -> tuple[Section, ...]:
    """Natural vibrations of a press on its springs."""
    state, first, frequency = found.nearest_to_bottom, found._press.driver_coordinates[0], found.natural_frequency
    words = [found.words(state, mode) for mode in range(frequency.shape[1])]
    columns = [
        Column("mode", [str(mode + 1) for mode in range(frequency.shape[1])]),
        Column("yields", [yields for yields, _ in words]),
        Column("moves", [moves for _, moves in words]),
        Column("near bottom dead centre", frequency[state].tolist(), "frequency"),
        Column("least", frequency.min(axis=0).tolist(), "frequency"),
        Column("largest", frequency.max(axis=0).tolist(), "frequency"),
        Column("damping ratio", found.damping_ratio[state].tolist(), "number"),
    ]
    blocks: list[Block] = []
    if len(found.crank_angle) > 1:
        order = np.argsort(found.crank_angle)
        along = Along(first.counted, first.unit, found.crank_angle[order])
        curves = [Curve(f"mode {k + 1}", frequency[order, k]) for k in range(min(frequency.shape[1], MOST_MODES))]
        few = "" if len(curves) == frequency.shape[1] else f"The {len(curves)} lowest of {frequency.shape[1]} modes."
        blocks.append(Chart("natural_frequencies", "Natural frequencies", "frequency", along, curves, note=few))
    blocks.append(Table("modes", "", columns))
    crank = "the crank held" if found.flywheel is None else "the crank free, with its flywheel"
    where = first.shown(found.crank_angle[state], ".4g")
    note = f"About the rigid pose, {crank}; what yields and moves at {where}, by shares of energy."
    return (Section("Vibrations on its springs", (), blocks, elastic_in_words(found.elastic), note, found._press, "modes"),)


def campbell(found: CampbellDiagram, page: Reactions | None = None) -> tuple[Section, ...]:
    """Natural frequencies as bands over the speed, the orders of the strokes as lines, and points where they meet."""
    speed, frequency = found.speed, found.modes.natural_frequency
    highest = float(found.order_frequency(found.orders)[-1])
    bands = [(mode, band) for mode, band in enumerate(frequency.T[:MOST_MODES]) if band.min() <= highest]
    marks = [Mark(f"mode {mode + 1}", (float(band.min()), float(band.max()))) for mode, band in bands]
    met = sorted({each.order for each in found.resonances if each.mode <= MOST_MODES})[:MOST_LINES]
    curves = [Curve(f"order {order}", found.order_frequency(order), look="guide") for order in met]
    inside = [each for each in found.resonances if speed[0] <= each.speed <= speed[-1]]
    at, height = np.array([each.speed for each in inside]), np.array([each.speed * each.order / found.turns for each in inside])
    curves += [Curve("resonances", height, at, look="points")] if inside else []
    few = "Orders that meet none of these modes are left out." if len(met) < found.orders else ""
    blocks: list[Block] = []
    if len(speed) > 1 and curves:
        along = Along(SPEED, "rad/s", speed)
        blocks.append(Chart("campbell", "Campbell diagram", "frequency", along, curves, marks, note=few))
    mean = frequency.mean(axis=0)
    if found.resonances:
        columns = [
            Column("mode", [each.mode for each in found.resonances]),
            Column("order", [each.order for each in found.resonances]),
            Column("speed", [each.speed for each in found.resonances], "rad/s"),
            Column("somewhere in the turn from", [each.slowest for each in found.resonances], "rad/s"),
            Column("to", [each.fastest for each in found.resonances], "rad/s"),
            Column("frequency", [float(mean[each.mode - 1]) for each in found.resonances], "frequency"),
        ]
        blocks.append(Table("resonances", "Resonances, the fastest first", columns, most=16))
    note = (
        f"{len(found.resonances)} resonances. Orders are harmonics of the stroke. How strongly each shakes the press is not in the diagram."
    )
    inputs = elastic_in_words(found.modes.elastic)
    return (Section("Resonances over the speed", (), blocks, inputs, note, found._press, "diagram"),)


def over_speeds(found: ElasticSpeedResponse, page: Reactions | None = None) -> tuple[Section, ...]:
    """The stroke that the press repeats at each speed."""
    along = Along(SPEED, "rad/s", found.speed)
    worst = sorted(found.peaks, key=lambda name: -float(found.peaks[name].max()))[:MOST_BEARINGS]
    forces = [*(Curve(name, found.peaks[name]) for name in worst), Curve("reverse force", found.reverse_force)]
    columns = [
        Column("speed", found.speed.tolist(), "rad/s"),
        Column("below rigid", found.depth.tolist(), "m"),
        Column(f"peak of {worst[0]}", found.peaks[worst[0]].tolist(), "N"),
        Column("reverse force", found.reverse_force.tolist(), "N"),
        Column("on the frame", found.frame_force.tolist(), "N"),
    ]
    blocks: list[Block] = [
        Chart("depth", "Depth below the rigid bottom dead centre", "m", along, [Curve("slide", found.depth)]),
        Chart("peaks_over_speed", "Largest forces in a stroke", "N", along, forces),
        Chart("frame_over_speed", "Force on the frame, next to its mean", "N", along, [Curve("on the frame", found.frame_force)]),
        Table("strokes_over_speed", "", columns),
    ]
    note = "The stroke that the press repeats at each speed, held constant."
    return (Section("Strokes over the speed", (), blocks, elastic_in_words(found.elastic), note, found._press, "strokes"),)


def impacts(found: ImpactsByTurn, page: Reactions | None = None) -> tuple[Section, ...]:
    """A pin with clearance: the orbit of its journal, and its impacts in each turn."""
    orbit = found.orbit[:: max(1, len(found.orbit) // MOST_PLACES)]
    turn = np.linspace(0.0, 2 * np.pi, ROUND)
    radius = quantity("m").text(found.radial, 4)
    ends = [quantity("N").text(float(value), 5) for value in (found.peak.min(), found.peak.max())]
    figures = [
        Figure("largest force of a turn", found.mean_peak, "N", f"mean of {len(found.peak)} turns, {ends[0]} to {ends[1]}", kind="bearing"),
        Figure("its spread", found.spread, "share", "standard deviation by the mean"),
        Figure("impacts a turn", float(found.impacts.mean()), "-", f"{quantity('share').text(float(found.flight.mean()))} of it in flight"),
        Figure("deepest in the bearing", float(found.depth.max()), "m", f"beyond the clearance of {radius}"),
    ]
    curves = [
        Curve("bearing, by the clearance", found.radial * np.sin(turn), found.radial * np.cos(turn), look="limit"),
        Curve("journal", orbit[:, 1], orbit[:, 0]),
    ]
    note = "Centre of the journal from that of the bearing; on the circle they touch."
    picture = Chart("orbit", "Orbit of the journal", "m", Along("across", "m"), curves, square=True, note=note)
    columns = [
        Column("start", (found.start + 1).tolist()),
        Column("turn", (found.turn + 1).tolist()),
        Column("peak", found.peak.tolist(), "N"),
        Column("depth", found.depth.tolist(), "m"),
        Column("impacts", found.impacts.tolist()),
        Column("in flight", found.flight.tolist(), "share"),
    ]
    table = Table("turns", "Turn by turn", columns, most=12)
    words = "If impacts follow one another, small differences grow: peaks of single turns mean little, their distribution does."
    return (Section(f"Journal in {found.bearing}", figures, [picture, table], (), words, found._press, "pin"),)


def guide(found: LoadedGuide, page: Reactions | None = None) -> tuple[Section, ...]:
    """The force on each surface of a slide's guide, and how the slide tilts and turns."""
    along = along_motion(found.motion)
    names = list(found.force)
    columns = [
        Column("surface", names),
        Column("least force", [float(found.force[name].min()) for name in names], "N"),
        Column("largest force", [float(found.force[name].max()) for name in names], "N"),
        Column("pressure", [float(found.pressure[name].max()) for name in names], "Pa"),
        Column("touches from", [float(found.contact[name].min()) for name in names], "share"),
    ]
    turns = [Curve(f"about {axis}", values) for axis, values in zip("xyz", found.rotation.T, strict=True)]
    blocks: list[Block] = [
        Chart("surfaces", "Force on the surfaces of the guide", "N", along, [Curve(name, force) for name, force in found.force.items()]),
        Chart("rotation", "Rotation of the slide", "tilt", along, turns),
        Table("surfaces", "", columns),
    ]
    return (Section("Surfaces of the guide", (), blocks),)


SECTIONS = {
    SlideCompliance: compliance,
    DeflectedSlide: deflection,
    ElasticDeadCentre: dead_centre,
    SnapThroughResponse: breakthrough,
    ElasticModes: modes,
    CampbellDiagram: campbell,
    ElasticSpeedResponse: over_speeds,
    ImpactsByTurn: impacts,
    LoadedGuide: guide,
}
"""How results of this room are described."""
