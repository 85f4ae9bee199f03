"""Errors, warnings and notes about a linkage that is put together: `errors` say why `load` refuses it, `remarks` what is odd in it.

The facts come from `Linkage.assembly`, `Linkage.planarity` and `mobility`; here they get their words.
"""

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pinocchio as pin

from ...common.errors import AssemblyError, PinpressError, SingularityError, UrdfError
from ...common.plausibility import UNWEIGHED
from ...common.quantities import Array
from ...engines.branch import MOST_TURNS, Branch, predict
from ...engines.constraints import LoopJoint
from ...engines.machine_elements.cams import CamContact
from ...engines.mounting import Mounting, within
from ...engines.pinocchio.equations import Rows
from ...engines.planar.model import PARALLEL
from ...engines.rank import rank, singular_values
from ...engines.structure import configuration, data_of, drawn_placements
from ..document import Finding
from ..driving.freedoms import Freedom, generic_ways
from ..home import FAR, HOME, POSE, ROUNDED, nearby
from ..linkage import LEVEL, Linkage
from . import mobility, units

SEEN = 1e-9  # smaller gaps and motions are rounding [lengths of the linkage, rad]
OPEN = 1e-6  # a loop drawn further open than this is reported [lengths of the linkage, rad]
CLOSED = 1e-3  # a loop is closed if it is drawn less open than this [lengths of the linkage]
STEEP = {"a guide": 30.0, "an arm": 45.0}  # pressure angle above which a cam may jam its follower [deg]
SAMPLES = 720  # crank angles of a turn at which positions of joints are checked


def errors(press: Linkage, in_file: bool = True) -> Iterator[Finding]:
    """Everything that keeps the linkage from being loaded; each finding carries a UrdfError, AssemblyError or SingularityError.

    ``in_file``: whether the linkage is that of a file that `load` reads, which takes a pose."""
    if wrong := list(_read_otherwise_far(press)):
        yield from wrong
        return
    assembly = press.assembly
    if assembly.closes and assembly.determined:
        yield from _massless(press)
        return
    rows = assembly.rows if assembly.closes else assembly.rows_as_drawn
    freedom = press.model.nv - rank(rows.columns, press.structure.rank_tolerance)
    if assembly.closes and _meets(press, freedom):
        yield _change_point(press, rows, in_file)
    elif freedom != len(press.drivers) and (assembly.closes or (press.slide and press.drivers)):
        yield _mobility(press, rows, freedom)
    if not assembly.closes:
        yield from _open(press, rows)
    elif freedom == len(press.drivers):
        yield from list(_dead_point(press, rows, in_file)) or _massless(press)


def _read_otherwise_far(press: Linkage) -> Iterator[Finding]:
    """Errors of loops that are drawn far open, by a tenth of the linkage, and would be closed with their points read otherwise, or have
    numbers that are hardly in SI units: what closes them is another linkage than the one that was meant."""
    for each in () if press.mounted.startswith((POSE, HOME)) else _loops(_open_beyond(press, 0.1)):
        if likely := _other_units(press) or _read_otherwise(press, each):
            problem = f"it is {opening_in_words(press, each, press.assembly.gaps)} apart as drawn, in a linkage of {press.size:.3g} m"
            yield Finding.of(UrdfError(press.file, mobility.element(press, each), each.by.line, problem, likely))


def opening_in_words(press: Linkage, each: mobility.Constraint, gaps: Array) -> str:
    """How far a loop or gear pair is open, as text; empty if it is closed within rounding error."""
    return open_in_words(*mobility.opening(press, each, gaps), press.size)


def open_in_words(distance: float, angle: float, size: float) -> str:
    """A distance [m] and an angle [rad] as text, without what is rounding error in a linkage of this size [m]."""
    mm = "less than 0.0001 mm" if distance < min(OPEN * size, 1e-7) else f"{_short(1e3 * distance)} mm"
    apart = [mm] if distance > SEEN * size else []
    return " and ".join(apart + [f"{_short(np.degrees(angle))} deg"] * (angle > SEEN))


def _short(number: float) -> str:
    """A number with three digits, or with all digits before the point."""
    return f"{number:.0f}" if 100 <= number < 1e9 else f"{number:.3g}"


def remedy_of_rounded_axes(press: Linkage) -> str | None:
    """The remedy for axes that are nearly parallel; None if they are parallel, or far from it."""
    off = press.planarity.farthest_off
    if not PARALLEL < off < 1e-2:  # axes as near to parallel as half a degree are meant to be parallel
        return None
    return f"axes are up to {off:.2g} rad from parallel: write angles in full, 1.5707963267948966 for a quarter turn"


def _mobility(press: Linkage, rows: Rows, freedom: int) -> Finding:
    drive = "one joint drives" if len(press.drivers) == 1 else f"{len(press.drivers)} joints drive"
    problem = f"mobility is {freedom}, but {drive}"
    if freedom > len(press.drivers):
        problem += f": with {_named(press.drivers)} held still, {_named(mobility.undetermined_joints(press, rows))} can move"
        read = ((each, _read_otherwise(press, each)) for each in mobility.constraints(press))
        exchanged = next((f"{each.title}: {likely}" for each, likely in read if likely), None)
        remedy = _without_axis(press) or exchanged or "a <loop_joint> is missing, a link hangs free, or a driver is missing"
        free = press.freedoms if press.assembly.closes else ()
        if free and all(each.kind in ("spin", "swing") for each in free):  # those in balance would be held
            problem += f": {' and '.join(map(_spin_in_words, free))}"
            remedy = (
                "its weight would turn it: put its centre of mass on the line, or make one of its ball joints a universal one, of two pins"
            )
    else:
        if alone := mobility.overconstraining(press, rows):
            problem += f": {' or '.join(each.title for each in alone)} contradicts the others"
        elif freedom == 0 and (locking := mobility.locking(press, rows)):
            problem += f": held by {', '.join(each.title for each in locking)}"
        stuck = (
            _other_units(press)
            or _without_axis(press)
            or remedy_of_rounded_axes(press)
            or "a loop, a gear pair or a fixed joint too many: nothing can move"
        )
        remedy = "drive fewer joints" if freedom > 0 else stuck
        least = float(singular_values(rows.columns)[press.model.nv - len(press.drivers)])
        if press.assembly.closes and freedom == 0:
            problem += _misses(press)
        if least < 1e-3:  # equations that are clearly independent have singular values of about 1
            remedy = "write equal and symmetrical lengths and angles with all digits, as formulas or copies: then the equations agree"
    return Finding.of(UrdfError(press.file, _robot(press), None, problem, remedy))


def _misses(press: Linkage) -> str:
    """By how little the loops keep drivers from moving, as text: their gaps at best with the drivers moved on; empty if by much."""
    mounting, drivers, start = Mounting(press.structure), list(press.driver_indices), press.closed.copy()
    start[drivers] += 0.1 * mounting.lengths[drivers]
    gaps = press.equations(mounting.close(start, drivers, limited=False).position).gaps
    widest = float(np.abs(gaps).max(initial=0.0))
    if not SEEN * press.size < widest < 0.02 * press.size:  # of loops that meet a moved driver at right angles it would be 0.1
        return ""
    those = [each for each in mobility.constraints(press) if each.gap(gaps) > 0.1 * widest]
    each_open = ", ".join(f"{each.title} stays open by {opening_in_words(press, each, gaps)}" for each in those)
    by = "0.1 rad" if all(press.axes[joint].turns for joint in drivers) else f"0.1 rad or {_short(100 * press.size)} mm"
    return f"; it misses moving by little: {by} further, {each_open} at best"


def _meets(press: Linkage, freedom: int) -> bool:
    """Whether a linkage has fewer degrees of freedom in poses beside its home pose than there, where it has ``freedom``."""
    if freedom <= len(press.drivers):
        return False
    # open poses beside a misfit have the rank of equations that contradict each other
    beside = not press.assembly.misfit and mobility.freedom_nearby(press) == len(press.drivers)
    return beside or generic_ways(press.structure, press.closed) < freedom


def _choice(press: Linkage, in_file: bool) -> str:
    """The poses that choose one of the assemblies beside a singular pose, as the end of a remedy."""
    poses = nearby(press) if in_file else []
    return f"; or choose an assembly by load(..., pose=...): {' or '.join(map(repr, poses))}" if poses else ""


def _change_point(press: Linkage, rows: Rows, in_file: bool) -> Finding:
    """The error of a linkage drawn at a change point, such as a parallelogram drawn in one line."""
    problem = "two assemblies meet in the drawn pose, and the loops do not say which of them it is"
    remedy = "draw the linkage a little further on"
    if not mobility.is_shaky(press):
        remedy += _choice(press, in_file)
    else:
        moving = _named(mobility.undetermined_joints(press, rows))
        problem = f"its loops hold {moving} only at second order, in this pose and beside it: it is shaky, and no forces follow"
        remedy = "another pose does not help: change lengths or guides that are equal or parallel, or leave out a link"
    smallest = mobility.singular_value(rows.columns, press.model.nv - len(press.drivers) - 1)
    error = SingularityError(f"{press.file}: {problem}; {remedy}", 0.0, smallest)
    return Finding("error", _robot(press), None, problem, remedy, error)


def _open(press: Linkage, rows: Rows) -> Iterator[Finding]:
    """Errors of the loops and gear pairs that are open in the best pose that was found, the one furthest open first."""
    owners, at_best = mobility.constraints(press), press.equations(np.array(press.home)).gaps
    gaps, left = ([each.gap(of) for each in owners] for of in (rows.gaps, at_best))
    # Where loops overconstrain each other, all of them may be left open; those that are drawn closed are not at fault.
    still_open = [k for k in range(len(owners)) if min(gaps[k], left[k]) > press.structure.tolerance]
    still_open = still_open or [int(np.argmax(gaps))]
    common = _other_units(press) or _without_axis(press) or remedy_of_rounded_axes(press)
    nearly = max(left) <= ROUNDED * press.size
    fit = "; loops hold each other here, so that lengths and angles must fit to all digits" if nearly else ""
    beside = fit if press.engine().redundant(press.assembly.start) else ""
    for k in sorted(still_open, key=lambda k: -left[k]):
        each, opening = owners[k], opening_in_words(press, owners[k], rows.gaps)
        apart = f"{opening} apart as drawn" if opening else "drawn closed, but the others cannot close beside it"
        problem = f"does not close: {apart}, {opening_in_words(press, each, at_best) or 'closed'} at best"
        remedy = (common or _read_otherwise(press, each) or "draw it closed, or change the link lengths") + beside
        error = AssemblyError(
            f"{press.file}:{each.by.line}: {each.title} {problem}; {remedy}", 0.0, left[k], press.assembly.drawn.iterations
        )
        yield Finding("error", mobility.element(press, each), each.by.line, problem, remedy, error)


def _other_units(press: Linkage) -> str | None:
    """Which angles or lengths seem to be in other units, and what to write; None if none do."""
    robot = press.document.robot
    wrong_units = (*units.angles(robot), *units.length(robot, press.size))
    return next((f"{finding.problem}; {finding.remedy}" for finding in wrong_units), None)


def _without_axis(press: Linkage) -> str | None:
    """What to write if joints have no ``<axis>``, which means x, and others turn or slide about another direction; else None."""
    moving = [joint for joint in press.document.robot.all("joint") if joint.get("name") in press.joints]
    without = [joint for joint in moving if not joint.all("axis")]
    others = [press.axes[press.joints.index(joint.get("name"))].direction for joint in moving if joint not in without]
    if not without or all(abs(direction[0]) > 0.999 for direction in others):  # along x within 2.6 degrees
        return None
    named = ", ".join(f"{joint.get('name')!r} (line {joint.line})" for joint in without)
    have, turn = ("has", "its") if len(without) == 1 else ("have", "their")
    return f"joint{'s' * (len(without) > 1)} {named} {have} no <axis>, which means x: write {turn} <axis>"


def _read_otherwise(press: Linkage, each: mobility.Constraint) -> str | None:
    """What to write if a loop that is drawn open would be closed with its points read otherwise: with its links exchanged, or one point in
    world axes; else None."""
    loop = next((loop for loop in press.document.description.loops if loop.name == each.by.name), None)
    if loop is None or not isinstance(each.by, LoopJoint) or mobility.opening(press, each, press.assembly.gaps)[0] <= CLOSED * press.size:
        return None
    places = drawn_placements(press.model)

    def placed(link: str, xyz: tuple[float, float, float]) -> Array:
        frame = press.model.frames[press.model.getFrameId(link, pin.BODY)]
        return np.asarray((places[frame.parentJoint] * frame.placement).act(np.array(xyz)))

    (link1, xyz1), (link2, xyz2) = ((end.link, end.xyz) for end in (loop.link1, loop.link2))
    readings = (
        ("link1 and link2 are exchanged: write each point with the link in whose frame it is", placed(link2, xyz1), placed(link1, xyz2)),
        (f"the point of link {link1!r} is in world axes: write it in that link's frame", np.array(xyz1), placed(link2, xyz2)),
        (f"the point of link {link2!r} is in world axes: write it in that link's frame", placed(link1, xyz1), np.array(xyz2)),
    )
    gaps = [float(np.linalg.norm(one - other)) for _, one, other in readings]
    best = int(np.argmin(gaps))
    return readings[best][0] if gaps[best] <= CLOSED * press.size else None


def _dead_point(press: Linkage, rows: Rows, in_file: bool) -> Iterator[Finding]:
    columns = rows.columns[:, press.structure.passive_joints]
    values = singular_values(columns)
    if rank(columns, press.structure.rank_tolerance) == columns.shape[1]:
        return
    problem = f"{_named(press.drivers)} {'does' if len(press.drivers) == 1 else 'do'} not determine the drawn pose"
    free = _named(mobility.undetermined_joints(press, rows))
    remedy = (
        _without_axis(press)
        or f"draw the linkage away from its dead point ({free} can move with the driver held still){_choice(press, in_file)}"
    )
    smallest = float(values.min()) if len(values) == columns.shape[1] else 0.0
    error = SingularityError(f"{press.file}: {problem}; {remedy}", 0.0, smallest)
    yield Finding("error", _robot(press), None, problem, remedy, error)


def _massless(press: Linkage) -> Iterator[Finding]:
    """The error of a linkage with massless links in which no mass resists a motion."""
    masses = [inertia.mass for inertia in press.model.inertias]
    if all(masses[1:]):
        return
    # A single driver may be drawn where the only heavy link stands at its dead centre: its acceleration shows that it will move.
    rates = (
        np.hstack([press.assembly.drawn.first, press.assembly.drawn.second])
        if len(press.drivers) == 1
        else mobility.rates_of_drivers(press)
    )
    mass = pin.crba(press.model, data_of(press.model), configuration(press.slots, press.closed))
    resisted = rates.T @ mass @ rates
    values, ways = np.linalg.eigh(resisted if len(press.drivers) > 1 else resisted.diagonal().sum().reshape(1, 1))
    # A smaller share of the inertia that the heaviest link might have is rounding.
    if values[0] > 1e-13 * max(masses[1:]) * press.size**2:
        return
    moved = rates if len(press.drivers) == 1 else rates @ ways[:, :1]
    moving = np.flatnonzero(np.abs(moved).max(axis=1) > SEEN)
    body = next(int(j) + 1 for j in moving if not masses[j + 1])
    problem = "it moves without a mass, as do all links that move with it: nothing resists the drive"
    error = UrdfError(press.file, press.document.called("link", press.link_of(body)), None, problem, "write its <mass> and <inertia>")
    yield Finding.of(error)


def _robot(press: Linkage) -> str:
    return press.document.called("robot", press.name)


def _named(names: Sequence[str], word: str = "joint") -> str:
    return f"{word} {names[0]!r}" if len(names) == 1 else f"{word}s {', '.join(map(repr, names))}"


def remarks(press: Linkage, *, quick: bool = False, centres: bool = True) -> Iterator[Finding]:
    """What is said of a linkage without `errors`: warnings and notes.

    Args:
        press: the linkage.
        quick: whether only warnings that are found quickly are wanted, about files that probably describe another linkage than was meant.
        centres: whether centres of mass are checked.
    """
    yield from _steep_cams(press)
    if quick:
        # A gap of a hundredth of the linkage is probably a mistake, and so is any that a joint has to move by 0.05 rad or m to close.
        far = np.abs(press.closed - press.assembly.start).max() > 0.05
        yield from _drawn_open(press, _loops(_open_beyond(press, OPEN if far else 0.01)), together=True)
        yield from _outside_limits(press)
        yield from _beside_pose(press)
        yield from (finding for finding in (*_undriven(press), *_misfit(press)) if finding.severity == "warning")
        yield from units_remarks(press, centres)
        if "plane" in press.engines:  # other assemblies have not been followed yet, which takes long
            yield from (finding for finding in _driver(press)[1] if finding.severity == "warning")
        return
    yield from _drawn_open(press, _open_beyond(press, OPEN))
    if press.home and not press.mounted.startswith((POSE, HOME)) and (nearer := press.assembly.nearer):
        problem = "the linkage is put together in an assembly that is farther from the drawing than another one at the same drivers"
        yield Finding("warning", _robot(press), None, problem, f"if that one is meant: load(..., pose={nearer!r})")
    yield from _outside_limits(press)
    yield from _misfit(press)
    yield from units_remarks(press)
    yield from _slide_axis(press)
    yield from _stroke(press)
    poses = press.closed[:, None]
    if len(press.drivers) == 1:
        branch, findings = _driver(press)
        yield from findings
        if branch is not None:
            # One pose alone may be a dead centre, where idle forces do not reach all loops.
            poses = np.hstack([poses, predict(branch, np.linspace(branch.angles[0], branch.angles[-1], 6))])
            yield from _limits(press, branch)
    yield from _undriven(press)
    yield from _gears_without_carrier(press)
    yield from _redundant(press, poses)
    yield from _engine(press)


def _steep_cams(press: Linkage) -> Iterator[Finding]:
    """Warnings of cams whose followers may jam."""
    for contact in press.contacts:
        if isinstance(contact, CamContact):
            largest, angle = np.degrees(contact.largest_pressure_angle())
            follower = "an arm" if contact.arm else "a guide"
            if largest > STEEP[follower]:
                problem = f"its pressure angle reaches {largest:.4g} deg at {angle:.4g} deg, above {STEEP[follower]:g} deg for {follower}"
                element, line = press.document.called("cam", contact.name), press.relations[contact.relation].line
                yield Finding("warning", element, line, problem, "write a larger radius, or more angle for the lift")


def _driver(press: Linkage) -> tuple[Branch | None, list[Finding]]:
    """The drawn assembly over the motion of the one driver, None if it cannot be followed, and findings about that motion."""
    where = press.document.called("joint", press.driver), press.document.find("joint", press.driver).line
    try:
        return press.branch, list(_range_of_driver(press, press.branch, where))
    except PinpressError as error:
        way = "a turn" if press.driver_coordinates[0].turns else "the driver's travel"
        problem = f"the drawn assembly cannot be followed through {way}: {error}"
        return None, [Finding("warning", *where, problem, "change the link lengths")]


def _range_of_driver(press: Linkage, branch: Branch, where: tuple[str, int]) -> Iterator[Finding]:
    """Findings about a driver that does not turn fully, or not slide from limit to limit; ``where``: its joint and the joint's line."""
    coordinate = branch.coordinate
    if branch.period is not None or not (coordinate.turns or any(branch.locks)):
        return
    if not any(branch.locks):
        problem = f"the linkage is not back at its drawn pose after {MOST_TURNS} turns of it"
        yield Finding("note", *where, problem, "it is followed through as many turns either way: keep motions inside")
    elif points := press.branch_through_change_points.change_points:
        places = ", ".join(f"{place * coordinate.scale:.6g}" for place in sorted(point.angle for point in points))
        problem = f"two assemblies meet at {coordinate.position}s of {places} {coordinate.shown_unit}"
        yield Finding("note", *where, problem, "a simulated run goes through, in the drawn one; a prescribed turn is refused there")
    else:
        low, high = float(branch.angles[0]), float(branch.angles[-1])
        turns_round = press.slots[press.driver_indices[0]].unbounded  # its joint is of type "continuous"
        # A driver that moves by less than a degree, or 0.017 lengths of the linkage, hardly moves it.
        severity = "note" if not turns_round and high - low > math.radians(1.0) * (1.0 if coordinate.turns else press.size) else "warning"
        moves = f"it {'turns' if coordinate.turns else 'slides'} only from {low * coordinate.scale:.6g} to {coordinate.shown(high)}"
        yield Finding(severity, *where, f"{moves}, where the linkage locks", "keep motions inside, or correct the lengths")


def _undriven(press: Linkage) -> Iterator[Finding]:
    """What becomes of the freedoms that no motor moves."""
    robot = _robot(press)
    for kind in ("spin", "swing"):
        if not (spins := [each for each in press.freedoms if each.kind == kind]):
            continue
        they, held = "; ".join(map(_spin_in_words, spins)), f"held, with {_named([each.joints[0] for each in spins])} as in the home pose"
        if kind == "spin":
            problem = f"{they}: no driver determines that"
            yield Finding("note", robot, None, problem, f"this is {held}: forces of slender links do not depend on it")
        else:
            problem = f"{they}: no driver determines that, and weight would turn them"
            remedy = "put centres of mass on the lines, or make one of two ball joints a universal one, of two pins"
            yield Finding("warning", robot, None, problem, f"this is {held}; {remedy}")
    if free := [each.joints[0] for each in press.freedoms if each.kind == "passive"]:
        problem = f"no driver moves {_named(free)}: {', '.join(press.motors) or 'what drives'} leaves {len(free)} free"
        remedy = "it is free, as a passive coordinate" if len(free) == 1 else "they are free, as passive coordinates"
        remedy += "; if that is not meant, a driver or a <loop_joint> is missing"
        yield Finding("warning", robot, None, problem, remedy)


def _gears_without_carrier(press: Linkage) -> Iterator[Finding]:
    """Notes of joints that follow others by their coordinates, as the file says, though no link carries both axes."""
    mimics = {joint.name for joint in press.document.description.joints if joint.mimic}
    for pair in (pair for pair in press.couplings if pair.name in mimics):
        ends = [{int(press.model.parents[joint + 1]), joint + 1} for joint in (pair.follower, pair.leader)]
        if ends[0].isdisjoint(ends[1]):
            leader = press.joints[pair.leader]
            problem = f"its coordinate is {pair.multiplier:.6g} times that of joint {leader!r}, though no link carries the axes of both"
            remedy = "teeth turn relative to a link that carries both gears: for teeth write <gear_mesh>, in a table meshes:"
            yield Finding("note", press.document.called("joint", pair.name), pair.line, problem, remedy)


def _spin_in_words(spin: Freedom) -> str:
    those, own = _named(spin.bodies, "link"), "its" if len(spin.bodies) == 1 else "their"
    off = f"a line {_short(1e3 * (spin.eccentricity or 0.0))} mm from" if spin.kind == "swing" else "the line of bearings through"
    return f"{those} can spin about {off} {own} centre of mass"


def units_remarks(press: Linkage, centres: bool = True) -> Iterator[Finding]:
    """Warnings of lengths, angles, masses or inertias that are hardly in SI units; ``centres``: whether centres of mass are looked at."""
    masses = [float(inertia.mass) for inertia in press.model.inertias][1:]
    yield from units.remarks(press.document, press.size, sum(masses), centres)
    if press.slide is not None and press.slide_guide.joint not in press.driver_indices:
        yield from _light_slide(press, masses)


def _light_slide(press: Linkage, masses: list[float]) -> Iterator[Finding]:
    """The warning of a slide, moved by other links, that is far lighter than one of them; ``masses``: of all bodies but the frame [kg]."""
    heaviest, weight = int(np.argmax(masses)), masses[press.slide_guide.joint]
    # Slides of presses are the heaviest links themselves.
    if UNWEIGHED < weight < 0.01 * masses[heaviest]:
        link = press.document.find("link", press.slide)
        problem = f"the slide weighs {weight:.4g} kg, link {press.link_of(heaviest + 1)!r} {masses[heaviest]:.4g} kg"
        yield Finding("warning", str(link), link.line, problem, "write masses in kg, 1000 for a tonne")


def _stroke(press: Linkage) -> Iterator[Finding]:
    """The warning of a slide with a longer stroke than any press has."""
    if press.slide is None or len(press.drivers) > 1:
        return
    try:
        branch = press.branch
    except PinpressError:
        return  # `_driver` reports it
    guide = press.slide_guide.joint
    angles = np.linspace(branch.angles[0], branch.angles[-1], SAMPLES)
    stroke = float(np.ptp(predict(branch, angles)[guide]))
    if stroke > 5.0:  # [m]: no press has more
        joint = press.document.find("joint", press.joints[guide])
        problem = f"slide {press.slide!r} goes {stroke:.3g} m to and fro"
        yield Finding("warning", str(joint), joint.line, problem, "write lengths in metres, 0.001 for a millimetre")


def _slide_axis(press: Linkage) -> Iterator[Finding]:
    """The note of a slide whose axis points down, or of one that moves horizontally, whose axis says where its bottom dead centre is."""
    if press.slide is None:
        return
    name, axis = press.joints[press.slide_guide.joint], press.slide_direction
    joint = press.document.find("joint", name)
    if abs(axis @ press.up) <= LEVEL:
        x, y, z = np.round(axis, 3) + 0.0
        end = f"farthest {'left' if x > 0 else 'right'}" if x and not y else "at its far end against that axis"
        tops = f"the axis ({x:g}, {y:g}, {z:g}) points to the top dead centre of slide {press.slide!r}"
        problem = f"{tops}, whose bottom dead centre, where process loads act, is {end}"
        yield Finding("note", str(joint), joint.line, problem, "turn the axis of its guide round where the tool is at the other end")
    if press.slide_guide.sign < 0:
        problem = f"the axis points down; positions, speeds and forces of slide {press.slide!r} count upwards all the same"
        yield Finding("note", str(joint), joint.line, problem, f"only the coordinate of joint {name!r} itself counts along its axis")


def _drawn_open(press: Linkage, those: list[mobility.Constraint], together: bool = False) -> Iterator[Finding]:
    """Warnings of loops and gear pairs, that they are drawn open, of a file that does not say how to close them; ``together``: one warning,
    of the widest."""
    if press.mounted.startswith((POSE, HOME)) or not those:
        return
    widest, more = max(those, key=lambda each: each.gap(press.assembly.gaps)), len(those) - 1
    for each in [widest] if together else those:
        problem = f"it is {opening_in_words(press, each, press.assembly.gaps)} apart as drawn"
        problem += f", and {more} more loop{'s are' if more > 1 else ' is'} open" if together and more else ""
        remedy = f"{_read_otherwise(press, each) or 'draw it closed'}; to close it, load has moved {_largest_move(press)}"
        if (np.abs(press.closed - press.assembly.start) > FAR * press.lengths).any():
            remedy += ", so far that another assembly may be meant: say which by load(..., pose={joint: rad or m})"
        yield Finding("warning", mobility.element(press, each), each.by.line, problem, remedy)


def _misfit(press: Linkage) -> Iterator[Finding]:
    """The warning of redundant equations that contradict each other a little; a note where that is nearly rounding error."""
    misfit, size = press.assembly.misfit, press.size
    if not misfit:
        return
    named = ", ".join(each.title for each in mobility.contradicting(press))
    problem = f"redundant equations contradict each other by up to {_short(1e3 * misfit)} mm, of {named}"
    exact = remedy_of_rounded_axes(press) or "write equal and symmetrical lengths and angles with all digits"
    remedy = f"expect errors of up to {10 * misfit / size:.1g} of the largest force, torque and travel; {exact}"
    yield Finding("warning" if misfit > SEEN * size else "note", _robot(press), None, problem, remedy)


def _beside_pose(press: Linkage) -> Iterator[Finding]:
    """The warning of a pose that was given and does not close."""
    if press.mounted.startswith(f"{POSE} with all joints free"):
        problem = "no closed pose was found with the joints where pose= puts them"
        yield Finding("warning", _robot(press), None, problem, "one near it was taken, with all joints free: press.closed")


def _outside_limits(press: Linkage) -> Iterator[Finding]:
    """Warnings of joints that are outside their limits in the home pose."""
    inside, description = within(press.structure, press.closed), press.document.description
    for joint in (press.document.find("joint", press.joints[j]) for j in np.flatnonzero(~inside)):
        j, limit = press.joints.index(joint.get("name")), joint.all("limit")[-1]
        lower, upper = next(each.limits for each in description.joints if each.name == joint.get("name") and each.limits)
        problem = f"the linkage is put together with it at {_value(press, j, press.closed[j])}, outside its limits {lower:g} to {upper:g}"
        yield Finding("warning", str(limit), limit.line, problem, "limits count from the zeros of the file: correct them")


def assembly_in_words(press: Linkage) -> str:
    """How a linkage that is drawn open was closed, and which other assemblies there are; empty for the drawn pose."""
    if not press.home or not mobility.constraints(press):
        return ""
    widest = max(mobility.constraints(press), key=lambda each: each.gap(press.assembly.gaps))
    text = f"from {press.assembly.how}; as drawn {widest.title} is {opening_in_words(press, widest, press.assembly.gaps) or '0 mm'} apart"
    if press.assembly.moved:
        text += f"; moves {_largest_move(press)}"
    others = [", ".join(f"{name} {value:.3g}" for name, value in each.items()) for each in press.assembly.others]
    more = f" or {len(others) - 3} more" if len(others) > 3 else ""
    return f"{text}; other assemblies there have {' or '.join(others[:3])}{more}" if others else text


def _open_beyond(press: Linkage, beyond: float) -> list[mobility.Constraint]:
    """Loops and gear pairs that are drawn open ``beyond`` this share of the linkage's length."""
    gaps, most = press.assembly.gaps, beyond * press.size
    if np.linalg.norm(gaps) <= most:
        return []  # as for most linkages
    return [each for each in mobility.constraints(press) if each.gap(gaps) > most]


def _loops(those: list[mobility.Constraint]) -> list[mobility.Constraint]:
    """The loops among loops and gear pairs."""
    return [each for each in those if isinstance(each.by, LoopJoint)]


def _largest_move(press: Linkage) -> str:
    """Which joint closing the drawn pose moves most, and by how much."""
    moves = press.closed - press.assembly.start
    most = int(np.argmax(np.abs(moves)))
    return f"joint {press.joints[most]!r} by {_value(press, most, moves[most])}"


def _limits(press: Linkage, branch: Branch) -> Iterator[Finding]:
    """Warnings of joints that leave their limits within a turn of the driver, or as far as it turns."""
    low, high = branch.angles[0], branch.angles[-1]
    turns = (high - low) / (2 * np.pi) if branch.coordinate.turns else 1.0
    angles = np.linspace(low, high, 1 + max(1, round(SAMPLES * turns)))
    positions = predict(branch, angles)
    elements = press.document.robot.all("joint")
    for described, of in zip(press.document.description.joints, elements, strict=True):
        if described.limits is None:
            continue
        (lower, upper), joint, element = described.limits, press.joints.index(described.name), of.all("limit")[0]
        if not within(press.structure, press.closed)[joint]:
            continue  # this is reported of the home pose
        for beyond, side, limit in ((lower - positions[joint], "lower", lower), (positions[joint] - upper, "upper", upper)):
            at = int(np.argmax(beyond))
            if beyond[at] > 1e-9:  # [rad or m]: less is rounding
                reached = f"it reaches {_value(press, joint, positions[joint, at])} at {branch.coordinate.at(angles[at])}"
                remedy = "widen the limit, or correct the lengths (limits do not enter any computation)"
                yield Finding("warning", str(element), element.line, f"{reached}, beyond its {side} limit {limit:g}", remedy)


def _value(press: Linkage, joint: int, value: float) -> str:
    """A joint coordinate as text."""
    return f"{value:.6g} rad ({np.degrees(value):.4g} deg)" if press.axes[joint].turns else f"{value:.6g} m"


def _redundant(press: Linkage, poses: Array) -> Iterator[Finding]:
    out_of_plane, further, among = mobility.redundancy(press, press.closed)
    robot, shared = _robot(press), "is shared by least squares: reactions.indeterminate marks it"
    if out_of_plane:
        problem = f"{_equations(out_of_plane)} redundant across the plane of the linkage, as in any with parallel pins"
        yield Finding("note", robot, None, problem, f"nothing is wrong; what bearings carry across the plane {shared}")
    if further:
        taking_part = [*among, *(each for x in poses.T for each in mobility.redundancy(press, x).among)]
        where = "in the plane" if press.planarity.is_planar else "in space"
        named = ", ".join(each.title for each in mobility.constraints(press) if each in taking_part)
        problem = f"{_equations(further)} redundant {where}, of {named}"
        remedy = f"their load {shared}; or give inverse_dynamics a stiffness=. Write lengths and angles with all digits"
        yield Finding("note", robot, None, problem, remedy)


def _equations(count: int) -> str:
    return "1 equation is" if count == 1 else f"{count} equations are"


def _engine(press: Linkage) -> Iterator[Finding]:
    if "plane" not in press.engines:
        problem = f"engine 'space' computes it, not 'plane': {_not_planar(press)}"
        remedy, slower = remedy_of_rounded_axes(press), "results are as exact, and take ten to twenty times longer"
        yield Finding("warning" if remedy else "note", _robot(press), None, problem, remedy or slower)


def _not_planar(press: Linkage) -> str:
    """Why the planar engine cannot compute a linkage."""
    if len(press.drivers) > 1:
        return f"there are {len(press.drivers)} drivers"
    if curved := [relation.name for relation in press.relations if relation.curve is not None]:
        return f"it has the cam {curved[0]!r}"
    turning, _, joints, loops = press.planarity
    if turning is None:
        return "no joint turns"
    plane = f"the plane in which joint {press.joints[turning]!r} turns"
    if (off := max(joints)) > PARALLEL:
        joint = joints.index(off)
        if press.axes[joint].turns:
            return f"the axis of joint {press.joints[joint]!r} is {np.degrees(off):.3g} deg off the normal of {plane}"
        return f"joint {press.joints[joint]!r} slides {np.degrees(off):.3g} deg out of {plane}"
    if (off := max(loops, default=0.0)) > PARALLEL:
        return f"the axis of loop {press.loops[loops.index(off)].name!r} is {np.degrees(off):.3g} deg off the normal of {plane}"
    if welds := [loop.name for loop in press.loops if loop.type == "fixed"]:
        return f"loop {welds[0]!r} is a weld"
    return "its equations do not fall into groups with as many unknown joints, or are singular in these"
