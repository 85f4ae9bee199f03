"""What ratings show: the permissible force with its limits over the height, the work of a stroke, and how much of both a process uses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..common.outlets.described import Along, Block, Chart, Column, Curve, Figure, Mark, Section, Table
from ..common.quantities import RPM, Array, DriverCoordinate, quantity
from ..dynamics.described import along_states, drawn_states
from ..dynamics.inputs import written
from ..dynamics.reactions import Reactions
from ..kinematics.described import along_motion
from ..kinematics.motion import is_cycle
from ..kinematics.slide_path import dead_centres
from .along_motion import MotionRatings, limits_in_words
from .emergency_stops import FULL, StoppingTimes
from .permissible_force import capacities_in_words
from .pin_use import PinRatings, PinUse
from .rating import PressRatings, conditions_in_words
from .safety_distance import SafetyDistance

HEIGHT = "height above bottom dead centre"
NEAR = 2.0  # reach of the chart near bottom dead centre, divided by the largest height at which another limit begins to govern
ROWS = 16  # rows of the tables, in addition to the heights at which another limit begins to govern
HYPERBOLAS = (0.2, 0.4, 0.6, 0.8)  # places on the diagonal of a chart where lines of constant energy cross it
ROOM = 1.12  # highest force of a chart, divided by the nominal force
POINTS = 200  # points of a line of constant energy
NO_ADVICE = "This is no advice: what decides is the stopping time measured on the press."
MILLION = 1e6  # strokes, by which wear and lives are given


def press_ratings(ratings: PressRatings, page: Reactions | None = None) -> tuple[Section, ...]:
    """The ratings of a press over its stroke, with the process of a page."""
    use = None if page is None else ratings.utilisation(page)
    works = page is not None and use is not None and bool(use.any())
    figures = [*(_uses(ratings, page, use) if works and page is not None and use is not None else []), *_main_data(ratings)]
    blocks: list[Block] = [*_forces(ratings, page if works else None)]
    if works and page is not None:
        drawn = drawn_states(page)
        blocks.append(_use(ratings.utilisation(drawn), along_states(page, drawn)))
    blocks += [_work(ratings), _table(ratings)]
    inputs = capacities_in_words(ratings.capacities, ratings.driver_coordinate)
    note = f"At {conditions_in_words(ratings)}. By the capacities given; strength, fatigue and overload protection are left out."
    return (Section("Ratings", figures, blocks, inputs, note, ratings._press, "rating"),)


def _uses(ratings: PressRatings, page: Reactions, use: Array) -> list[Figure]:
    """How much of the permissible force and of the energies the process of a page uses."""
    at, first = int(use.argmax()), ratings.driver_coordinate
    height = float(page.motion.slide_position[at]) - dead_centres(page._press).bottom_position
    place = first.shown(float(np.ravel(page.motion.crank_angle[at])[0]), ".4g")
    where = f"at {place}, {quantity('height').text(height)} above bottom dead centre"
    found = [Figure("of the permissible force", float(use[at]), "share", where, kind="force")]
    strokes = (page.motion.period_turns or 1) / ratings.turns
    for name, energy in ratings.energies.items() if is_cycle(page.motion) else ():
        share = page.process_work / strokes / energy
        found.append(Figure(f"of the {name}", share, "share", "by the work of a stroke", kind="energy"))
    return found


def _main_data(ratings: PressRatings) -> list[Figure]:
    """The known main data."""
    given, limit, turning = ratings.capacities, ratings.speed_limit, ratings.driver_coordinate.turns
    capacity, unit = ("torque", "N m") if turning else ("driving force", "N")
    above = "above bottom dead centre"
    at_contact = "" if ratings.contact_height is None else f"{quantity('height').text(ratings.contact_height)} {above}"
    within = "" if ratings.dwell_tolerance is None else f"within {quantity('height').text(ratings.dwell_tolerance)} of bottom dead centre"
    by = f"N for each {unit} {'on the crank' if turning else 'of the driver'}"
    known: list[tuple[str, float | None, str, str]] = [
        ("nominal force", given.nominal_force, "N", ""),
        ("nominal height", given.nominal_height, "height", above),
        (f"{capacity} capacity", ratings.torque_capacity, unit, ""),
        ("stroke", ratings.stroke, "height", ""),
        ("quick return ratio", ratings.quick_return_ratio, "-", ""),
        ("highest speed in the working stroke", float(np.abs(ratings.slide_velocity).max()), "m/s", ""),
        ("speed at contact", ratings.contact_speed, "m/s", at_contact),
        ("mechanical advantage there", ratings.contact_advantage, "-", by),
        ("dwell", ratings.dwell_time, "s", within),
        *((name, energy, "J", "a stroke") for name, energy in ratings.energies.items()),
    ]
    found = [Figure(name, value, kind, where) for name, value, kind, where in known if value is not None]
    if limit is not None:
        words = f"strokes/min, by {limit.limited_by} at {quantity('angle').text(limit.crank_angle)}"
        found.append(Figure("highest speed, idle", limit.strokes_per_minute, "-", words))
    return found


def _forces(ratings: PressRatings, page: Reactions | None) -> list[Chart]:
    """The permissible force with all limits over the stroke, and near bottom dead centre, with lines of constant energy."""
    of = None if page is None else drawn_states(page)
    along = Along(HEIGHT, "m", of=None if of is None else of.motion, period=None if page is None else along_states(page, page).period)
    curves = [Curve("permissible force", ratings.force, ratings.height, look="strong")]
    curves += [Curve(name, force, ratings.height, look="limit") for name, force in ratings.limits.items()]
    if of is not None:
        curves.append(Curve("process force", of.process_force, of.motion.slide_position - dead_centres(of._press).bottom_position))
    nominal = ratings.capacities.nominal_height
    marks = [mark for mark in (*ratings.changes, *([] if nominal is None else [nominal])) if mark < ratings.stroke / 2]
    near = min(NEAR * max(marks, default=0.1 * ratings.stroke), ratings.stroke)
    parts = [("force", "Permissible force", ratings.stroke)]
    parts += [("near_bottom", "Permissible force near bottom dead centre", near)] if marks else []
    return [Chart(name, title, "N", along, [*curves, *_hyperbolas(ratings, reach)], reach=(0.0, reach)) for name, title, reach in parts]


def _hyperbolas(ratings: PressRatings, reach: float) -> list[Curve]:
    """Forces of constant energy over the height."""
    top, found = ROOM * ratings.capacities.nominal_force, []
    for share in HYPERBOLAS:
        energy = float(f"{share**2 * top * reach:.2g}")
        height = np.geomspace(energy / top, reach, POINTS)
        found.append(Curve(quantity("J").text(energy), energy / height, height, look="guide"))
    return found


def _use(use: Array, along: Along) -> Chart:
    """Share of the permissible force over the motion of a page."""
    return Chart("use", "Process force by permissible force", "share", along, [Curve("use", use)])


def _work(ratings: PressRatings) -> Chart:
    """Work of the permissible force from a height down to bottom dead centre, and the energies that limit this work."""
    curves = [Curve("work", ratings.work, ratings.height)]
    marks = [Mark(name, energy) for name, energy in ratings.energies.items()]
    ends = ratings.height[[0, -1]]
    curves += [Curve(mark.name, np.full(2, mark.at), ends, look="limit") for mark in marks]
    title = "Work of the permissible force down to bottom dead centre"
    return Chart("work", title, "J", Along(HEIGHT, "m"), curves, reach=(0.0, ratings.stroke))


def listed_heights(ratings: PressRatings) -> list[int]:
    """Indices of the heights in the table: even steps of the crank angle, the nominal height, and changes of the governing limit."""
    even = np.linspace(0, len(ratings.height) - 1, ROWS).round().astype(int)
    marks = [*ratings.changes, *([] if ratings.capacities.nominal_height is None else [ratings.capacities.nominal_height])]
    return sorted({*even.tolist(), *(int(np.abs(ratings.height - mark).argmin()) for mark in marks)})


def _table(ratings: PressRatings) -> Table:
    rows, first = listed_heights(ratings), ratings.driver_coordinate
    places = ratings.crank_angle % (2 * np.pi * ratings.turns) if first.turns else ratings.crank_angle
    ideal = "frictionless " if ratings.friction else ""
    per_force = f"{ideal}{'torque per force' if first.turns else 'driving force per force'}"
    columns = [
        Column("height", [float(ratings.height[k]) for k in rows], "height"),
        Column(first.position, [float(places[k]) for k in rows], "angle" if first.turns else "height"),
        Column(per_force, [abs(float(ratings.travel_per_angle[k])) for k in rows], "length" if first.turns else "number"),
        Column("force", [float(ratings.force[k]) for k in rows], "N"),
        Column("work", [float(ratings.work[k]) for k in rows], "J"),
        Column("limited by", [ratings.limited_by[k] for k in rows]),
    ]
    note = "Work: of the force that all limits except energy permit, from there to bottom dead centre." if ratings.energies else ""
    return Table("permissible", "Permissible force", columns, note, most=200)


def motion_ratings(ratings: MotionRatings, page: Reactions | None = None) -> tuple[Section, ...]:
    """The ratings of a press along a motion, with the process of a page that shows this motion."""
    least, along = int(ratings.force.argmin()), along_motion(ratings.motion)
    figures = [Figure("least permissible force", float(ratings.force[least]), "N", f"at {ratings.motion.place(least)}")]
    curves = [Curve("permissible force", ratings.force, look="strong")]
    curves += [Curve(name, force, look="limit") for name, force in ratings.limits.items()]
    use = None if page is None else ratings.utilisation(page)
    blocks: list[Block] = []
    if page is not None and use is not None and use.any():
        most = int(use.argmax())
        figures.append(Figure("of the permissible force", float(use[most]), "share", f"at {page.motion.place(most)}", kind="force"))
        drawn = drawn_states(page)
        permissible = np.interp(drawn.motion.time, ratings.motion.time, ratings.force) if drawn is not page else ratings.force
        along = along_states(page, drawn)
        if drawn is not page:
            curves = [Curve(curve.name, np.interp(drawn.motion.time, ratings.motion.time, curve.y), look=curve.look) for curve in curves]
        curves.append(Curve("process force", drawn.process_force))
        blocks.append(_use(drawn.process_force / permissible, along))
    chart = Chart("force", "Permissible process force", "N", along, curves)
    note = "In this motion, next to weights and inertia forces" + ", with friction" * bool(ratings.friction)
    inputs = limits_in_words(ratings)
    return (Section("Ratings", figures, [chart, *blocks, _states(ratings)], inputs, f"{note}.", ratings._press, "rating"),)


def _states(ratings: MotionRatings) -> Table:
    least, motion = int(ratings.force.argmin()), ratings.motion
    rows = sorted({least, *np.linspace(0, len(ratings.force) - 1, ROWS).round().astype(int).tolist()})
    columns = [
        Column("state", [motion.place(k) for k in rows]),
        Column("slide position", [float(motion.slide_position[k]) for k in rows], "height"),
        Column("velocity", [float(motion.slide_velocity[k]) for k in rows], "m/s"),
        Column("force", [float(ratings.force[k]) for k in rows], "N"),
        Column("limited by", [ratings.limited_by[k] for k in rows]),
    ]
    return Table("permissible", "Permissible force", columns, most=200)


def stops(result: StoppingTimes, page: object = None) -> tuple[Section, ...]:
    """The stops of a press over the signal's angle, and the angles at which a brake does not hold."""
    press = result._press
    ends = dead_centres(press)
    whole = 2 * np.pi * press.period_turns
    closing = result.signal[result.closing]
    shaded = (float(closing[0]), float(closing[-1])) if ends.strokes == 1 else None
    along = Along("crank angle at the signal", "angle", result.signal, shaded=shaded)
    figures: list[Figure] = []
    for name, case in result.cases.items():
        figures.append(Figure("holding torque margin", case.margin, "number", name))
        if case.worst is None:
            where = ", ".join(f"{_degrees(low)} to {_degrees(high)} ({way})" for low, high, way in case.slips)
            figures.append(Figure("does not hold", where, where=name))
            continue
        worst, closing_at = case.worst, f"after a signal at {_degrees(case.worst.signal % whole)} of the closing stroke"
        figures += [Figure("longest stop", worst.time, "s", f"{name}, {closing_at}"), Figure("overrun there", worst.overrun, "angle", name)]
        figures.append(Figure("way of the slide there", worst.travel, "height", name))
        if case.worst_elsewhere is not None:
            other = case.worst_elsewhere
            figures.append(Figure("longest stop of all", other.time, "s", f"after a signal at {_degrees(other.signal % whole)}, {name}"))
        if case.top_stop is not None:
            figures.append(Figure("signal of the top stop", case.top_stop.overrun, "angle", f"{name}, before top dead centre"))
    held = {name: case for name, case in result.cases.items() if case.worst is not None}
    charts = [
        Chart(name, title, unit, along, [Curve(each, getattr(case, name), look="line") for each, case in held.items()])
        for name, title, unit in (
            ("time", "Time to standstill", "s"),
            ("overrun", "Angle to standstill", "angle"),
            ("travel", "Way of the slide to standstill", "height"),
        )
    ]
    inputs = [
        ("speed", f"{result.speed / RPM:g} r/min"),
        ("brake", written(result.cases[FULL].torque, "N m")),
        ("delay and rise of the brake", f"{1e3 * result.delay:g} ms, {1e3 * result.rise:g} ms"),
        ("inertia that stays on the crank", written(result.inertia, "kg m2")),
    ]
    note = (
        "Clutch open, without motor and flywheel. Left out: wear, heat and scatter of the brake, which make a stop longer; friction and the"
        " process, which make it shorter. " + NO_ADVICE
    )
    return (Section("Stopping", figures, charts, inputs, note, press, "stopping"),)


def safety_distance(result: SafetyDistance, page: object = None) -> tuple[Section, ...]:
    """A safety distance with its addends."""
    names, times, lengths, sources = zip(*result.addends, strict=True)
    columns = [Column("addend", names), Column("time", times, "s"), Column("length", lengths, "height"), Column("from", sources)]
    figures = [Figure("distance by the formula", result.distance, "height", f"all springs, {result.edition}")]
    for name, other in result.failed.items():
        if other is None:
            figures.append(Figure("distance by the formula", "none", where=f"{name}: the brake does not hold the press"))
        else:
            figures.append(
                Figure("distance by the formula", other.distance, "height", f"{name}, {other.edition}; {other.formula.partition(';')[0]}")
            )
    note = f"{result.formula}. {NO_ADVICE}"
    return (Section("Safety distance", figures, [Table("addends", "Addends", columns)], note=note),)


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):.2f} deg"


def pins(result: PinRatings, page: object = None) -> tuple[Section, ...]:
    """Plain bearings, guides and rolling bearings of a press in a motion."""
    first, uses = result._press.driver_coordinates[0], result.uses.values()
    guides = [each for each in uses if each.largest_tilting is not None]
    plain = [each for each in uses if each.rubbing_way is not None and each not in guides]
    rolling = [each for each in uses if each.rubbing_way is None]
    figures, tables = [], []
    for some, name in ((plain, "largest pressure"), (guides, "largest pressure on a guide")):
        if some:
            pressed = max(some, key=lambda each: each.largest_pressure or 0.0)
            limit = getattr(result.bearings[pressed.bearing], "pressure", None)
            figures.append(Figure(name, pressed.largest_pressure or 0.0, "Pa", f"in {pressed.bearing}", limit, kind="bearing"))
    if rubbing := plain + guides:
        rubbed = max(rubbing, key=lambda each: each.pv or 0.0)
        figures.append(Figure("largest mean p v", rubbed.pv or 0.0, "p v", f"in {rubbed.bearing}"))
    of_pins, of_guides = "Pressure: of the projected surface", "Pressure: at the end of the gibs"
    for some, name, pressure in ((plain, "Plain bearings", of_pins), (guides, "Guides", of_guides)):
        limits = [getattr(result.bearings[each.bearing], "pressure", None) for each in some]
        worn = [None if each.wear is None else MILLION * each.wear for each in some]
        columns = [
            *_forces_of(some, first),
            *([Column("largest tilting moment", [each.largest_tilting for each in some], "N m")] if some is guides else []),
            Column("largest pressure", [each.largest_pressure for each in some], "Pa"),
            *([Column("permissible", limits, "Pa")] if any(limits) else []),
            Column("mean pressure", [each.pressure for each in some], "Pa"),
            Column("mean p v", [each.pv for each in some], "p v"),
            Column("largest p v", [each.largest_pv for each in some], "p v"),
            Column("rubbing way", [each.rubbing_way for each in some], "height"),
            *([Column("wear in a million strokes", worn, "m")] if any(worn) else []),
        ]
        note = f"Way: of a stroke. {pressure}; 1 W/mm² is 1 MPa m/s."
        tables += [Table(name.lower().replace(" ", "_"), name, columns, note)] if some else []
    if rolling:
        shortest = min(rolling, key=lambda each: each.hours or 0.0)
        figures.append(
            Figure("shortest life", shortest.hours or 0.0, "number", f"hours of this motion, L10 of {shortest.bearing}", kind="bearing")
        )
        safe = [each.static_safety for each in rolling]
        columns = [
            *_forces_of(rolling, first),
            Column("way", [each.way for each in rolling], "angle"),
            Column("swing", [each.swing for each in rolling], "angle"),
            Column("equivalent load", [each.equivalent_load for each in rolling], "N"),
            Column("million strokes", [(each.strokes or 0.0) / MILLION for each in rolling], "number"),
            Column("hours", [each.hours for each in rolling], "number"),
            *([Column("static safety", safe, "number")] if any(safe) else []),
        ]
        note = "Life L10 in strokes and in hours of this motion, by ISO 281 without factors for lubricant and reliability."
        tables.append(Table("rolling_bearings", "Rolling bearings", columns, note))
    return (Section("Pins and bearings", figures, tables, press=result._press),)


def _forces_of(uses: Sequence[PinUse], first: DriverCoordinate) -> list[Column]:
    place = Column("at", [each.at for each in uses], "angle" if first.turns else "height")
    return [Column("bearing", [each.bearing for each in uses]), Column("largest force", [each.largest_force for each in uses], "N"), place]


SECTIONS = {
    PressRatings: press_ratings,
    MotionRatings: motion_ratings,
    StoppingTimes: stops,
    SafetyDistance: safety_distance,
    PinRatings: pins,
}
"""How results of this room are described."""
