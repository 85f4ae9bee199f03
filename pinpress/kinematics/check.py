"""Everything that is wrong with a URDF, odd in it, or worth knowing about the linkage it describes."""

from __future__ import annotations

import contextlib
import math
import os
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..common import tables
from ..common.arguments import typed
from ..common.errors import PinpressError, UrdfError
from ..common.results import Record, Records, Tabular
from ..common.tables import Column
from ..engines.constraints import LoopJoint
from ..engines.rank import rank as rank_of
from ..linkage.checks import assembly as assembly_checks
from ..linkage.checks import elements as element_checks
from ..linkage.checks import mobility
from ..linkage.checks.assembly import open_in_words
from ..linkage.document import SEVERITIES, Document, Finding
from ..linkage.driving.drivers import Proposal, propose, settle
from ..linkage.driving.freedoms import Freedom
from ..linkage.formats.free_bodies import Base, with_base
from ..linkage.home import mount
from ..linkage.linkage import Linkage
from ..linkage.loading import build, locate, parse, refuse_without_driver
from ..linkage.machine_elements import WORDS
from .main_data import MainData, main_data, main_lines
from .planar.transmission_angles import Dyad, least_transmission_angles
from .slide_path import turning_points

# What becomes of the freedoms of each kind.
KINDS = {
    "spin": "held by joint",
    "swing": "held, out of balance, by joint",
    "spring": "coordinates of springs:",
    "base": "coordinates of a floating base:",
    "passive": "moved by no motor:",
}
WIDTH = 120  # characters of a line of text
FLAT = math.radians(30.0)  # smaller transmission angles are marked
TURNED_BACK = 6  # places at which a slide turns back that a note lists
WHOLE = ("<robot", "<model", "<mujoco")  # elements that messages about the file as a whole do not name


@dataclass(frozen=True, repr=False)
class Closing(Record, units={"gap": "m", "misalignment": "rad"}):
    """A loop, gear pair or machine element of a linkage.

    Attributes:
        name: of the loop or element; of a gear pair, of the joint with the ``<mimic>``.
        type: "spherical", "revolute", "fixed", "gear pair", or of an element "gear mesh", "rack", "screw", "worm" or "cam".
        between: names of the links, of a gear pair of the joints.
        gap: between its two sides as drawn [m].
        misalignment: of its axes or links as drawn [rad].
        joints: names of the joints whose coordinates it determines, where the linkage is planar; else, of those it closes a loop of.
    """

    name: str
    type: str
    between: tuple[str, ...]
    gap: float
    misalignment: float
    joints: tuple[str, ...]


@dataclass(frozen=True, repr=False)
class Place(Record):
    """A joint or loop of a linkage.

    Attributes:
        name: of the joint or loop.
        type: "pin", "guide" (on the frame), "slot" (on another link), or that of the loop: "spherical", "revolute" or "fixed".
        between: names of the links; the force of the first on the second is given.
    """

    name: str
    type: str
    between: tuple[str, str]


@dataclass(frozen=True, repr=False)
class Facts(Record):
    """What the elements of a URDF make, put together.

    Attributes:
        drivers: names of the joints that motors drive.
        slide: name of the slide's link, None if there is none.
        joints: names of those that move.
        equations: number of those of loops and gear pairs.
        rank: number of those that are independent in the drawn pose.
        freedoms: that no motor determines, see `Linkage.freedoms`.
        mobility: degrees of freedom.
        engine: that computes it, "plane" or "space"; None if it cannot be loaded.
        closings: loops, then gear pairs. Those of a planar linkage close in the order of the joints that they determine.
        bearings: joints and loops in the order of the drawing, see `Linkage.bearings_as_drawn`.
        data: stroke, dead centres, masses and the like.
        dyads: of a planar linkage, with their least transmission angles.
        proposal: of drivers, where the file names none; these are then the drivers here.
        assembly: how the closed pose was found, as text; empty for the drawn pose.
    """

    drivers: tuple[str, ...]
    slide: str | None
    joints: tuple[str, ...]
    equations: int
    rank: int
    freedoms: Records[Freedom] = field(repr=False)
    engine: str | None
    closings: Records[Closing] = field(repr=False)
    bearings: Records[Place] = field(repr=False)
    data: MainData = field(repr=False)
    dyads: Records[Dyad] = field(repr=False)
    proposal: Proposal | None = field(repr=False)
    assembly: str = ""

    @property
    def mobility(self) -> int:
        return len(self.joints) - self.rank

    @property
    def determined(self) -> tuple[str, ...]:
        """Names of the joints that drive, are held, or are coordinates of what no motor moves."""
        return tuple(dict.fromkeys((*self.drivers, *(each.joints[0] for each in self.freedoms))))


@dataclass(frozen=True, repr=False)
class CheckResult(Tabular):
    """What `check` found: a table with a finding a row; as text, a page to read.

    Attributes:
        file: path of the URDF.
        findings: errors first, the one that `load` raises in front, then warnings, then notes.
        facts: None if the errors leave open what the elements make.
        elements: what the file has in it, in words, where there are no facts.
    """

    file: str
    findings: Records[Finding]
    facts: Facts | None
    elements: str = ""

    @property
    def errors(self) -> Records[Finding]:
        return self._of("error")

    @property
    def warnings(self) -> Records[Finding]:
        return self._of("warning")

    @property
    def notes(self) -> Records[Finding]:
        return self._of("note")

    def _of(self, severity: str) -> Records[Finding]:
        return Records(Finding, (finding for finding in self.findings if finding.severity == severity))

    @property
    def title(self) -> str:
        return f"CheckResult of {self.file}: {_count_findings(self)}"

    def columns(self) -> dict[str, Column]:
        """The findings as columns, None if one has no line."""
        return self.findings.columns()

    def __str__(self) -> str:
        lines = [f"{self.file}: {_count_findings(self)}"]
        lines += ["", f"  {self.elements}"] if self.elements else []
        if self.facts is not None:
            lines += ["", *_describe(self.facts)]
        for severity in SEVERITIES:
            listed = self._of(severity)
            lines += [""] * bool(listed) + [line for finding in listed for line in _lines_of(self.file, finding)]
        return "\n".join(lines)


@typed
def check(
    path: str | os.PathLike[str],
    driver: str | Sequence[str] | None = None,
    slide: str | None = None,
    *,
    base: Base = "fixed",
    pose: Mapping[str, float] | None = None,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
) -> CheckResult:
    """Find all errors of a file, and what else is odd in it or worth knowing, and say how the press moves. `load` raises the first error.

    Args:
        path: as for `load`.
        driver: as for `load`.
        slide: as for `load`.
        base: as for `load`.
        pose: as for `load`.
        gravity: as for `load`: it says what is up.

    Raises:
        UrdfError: there is no such file.
        UnknownNameError: no such driver or slide.
        PinpressError: the slide is not guided by the frame, or a driver is named twice.
    """
    file = os.fspath(locate(path))
    try:
        document = with_base(parse(file), base)
    except UrdfError as error:
        if not os.path.exists(file):
            raise
        return CheckResult(file, Records(Finding, [Finding.of(error)]), None)
    return check_document(file, document, driver, slide, gravity, pose=pose)


def check_document(
    file: str,
    document: Document,
    driver: str | Sequence[str] | None = None,
    slide: str | None = None,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
    *,
    pose: Mapping[str, float] | None = None,
    in_file: bool = True,
) -> CheckResult:
    """`check` of what was read from a file; ``in_file``: as of `load_document`."""
    findings = [*element_checks.errors(document), *element_checks.once(document.remarks), *element_checks.remarks(document)]
    facts = None
    if all(finding.error is None for finding in findings):
        try:
            more, facts = _put_together(document, driver, slide, gravity, pose, in_file)
            findings += more
        except UrdfError as error:
            findings.append(Finding.of(error))
    ordered = sorted(findings, key=lambda finding: SEVERITIES.index(finding.severity))
    return CheckResult(file, Records(Finding, ordered), facts, "" if facts else _count_elements(document))


def _put_together(
    document: Document,
    driver: str | Sequence[str] | None,
    slide: str | None,
    gravity: Sequence[float],
    pose: Mapping[str, float] | None,
    in_file: bool,
) -> tuple[list[Finding], Facts]:
    """Findings and facts of the linkage that the elements make; raises the errors of `build`."""
    (press, of_drivers), proposal = settle(mount(build(document, driver, slide, gravity), pose)), None
    if not press.drivers and press.assembly.closes:
        proposal = propose(press)
        if not proposal.drivers:
            refuse_without_driver(press)
        press, _ = settle(replace(press, drivers=proposal.drivers))
        problem, remedy = "no driver is named", f"this is the report with those proposed: load(..., {proposal.in_words})"
        of_drivers = (Finding("warning" if press.slide else "note", document.called("robot", press.name), None, problem, remedy),)
    errors = list(assembly_checks.errors(press, in_file))
    findings = [*errors, *of_drivers, *(assembly_checks.units_remarks(press) if errors else assembly_checks.remarks(press))]
    columns, tolerance = press.assembly.rows_as_drawn.columns, press.structure.rank_tolerance
    rank = (rank_of(columns, tolerance) if errors else press.rank) - len(press.held)
    between: list[tuple[str, ...]] = [(loop.link1.link, loop.link2.link) for loop in document.description.loops]
    meshing = {contact.relation: (press.link_of(contact.first), press.link_of(contact.second)) for contact in press.contacts}
    between += [meshing.get(k, tuple(press.joints[j] for j in relation.joints)) for k, relation in enumerate(press.relations)]
    closings = (
        Closing(
            each.by.name,
            each.by.type if isinstance(each.by, LoopJoint) else WORDS.get(each.kind, "gear pair"),
            between[k],
            *mobility.opening(press, each, press.assembly.gaps),
            joints,
        )
        for k, each, joints in _in_order(press)
    )
    engine, data = None if errors else press.engine().name, main_data(press, moves=not errors)
    places = Records(Place, _places(press))
    return [*findings, *_no_slide(press, places), *_turned_back(press, data)], Facts(
        press.motors,
        press.slide,
        press.joints,
        len(press.assembly.gaps) - len(press.held),
        rank,
        Records(Freedom, press.freedoms if press.held or press.passive else ()),
        engine,
        Records(Closing, closings),
        places,
        data,
        Records(Dyad, []) if errors else _dyads(press),
        proposal,
        "" if errors else assembly_checks.assembly_in_words(press),
    )


def _places(press: Linkage) -> Iterator[Place]:
    joints = {joint.name: joint for joint in press.document.description.joints}
    loops = {loop.name: loop for loop in press.document.description.loops}
    for name in press.bearings_as_drawn:
        if name in loops:
            yield Place(name, loops[name].type, (loops[name].link1.link, loops[name].link2.link))
            continue
        joint = joints[name]
        sliding = "guide" if press.model.parents[press.joints.index(name) + 1] == 0 else "slot"
        yield Place(name, "pin" if press.axes[press.joints.index(name)].turns else sliding, (joint.parent, joint.child))


def _no_slide(press: Linkage, places: Sequence[Place]) -> Iterator[Finding]:
    """A note of several links that the frame guides, none of which is taken for the slide."""
    guided = [place.between[1] for place in places if place.type == "guide"]
    if press.slide is not None or len(guided) < 2:
        return
    problem = f"the frame guides {', '.join(guided)}, and none is called slide: no link has a stroke and dead centres"
    remedy = f"call the one that works slide, or name it: load(..., slide={guided[0]!r}), in a job slide: {guided[0]}"
    yield Finding("note", press.document.called("robot", press.name), None, problem, remedy)


def _turned_back(press: Linkage, data: MainData) -> Iterator[Finding]:
    """A note of a slide that turns back more often than twice until it repeats its motion, as under a toggle that passes its straight
    position."""
    ends = data.dead_centres
    if ends is None or not data.coordinate.turns or (period := press.branch_through_change_points.period) is None:
        return
    points, turns = turning_points(press), round(period / (2 * np.pi))
    if len(points.places) * points.turns <= 2 * turns:
        return
    further = sorted(
        (angle, position - ends.bottom_position)
        for angle, position in zip(points.places, points.positions, strict=True)
        if angle not in (ends.top_angle, ends.bottom_angle)
    )
    also = ", ".join(f"at {np.degrees(angle):.2f} deg {abs(1e3 * height):.3f} mm" for angle, height in further[:TURNED_BACK])
    often = f"{len(points.places)} times in {'a turn' if turns == 1 else f'{turns} turns'} of {press.driver}"
    problem = f"the slide turns back {often}, besides its dead centres {also} above the bottom"
    remedy = "as under a toggle that passes its straight position; if that is not meant, make the crank shorter or move its shaft"
    yield Finding("note", press.document.called("robot", press.name), None, problem, remedy)


def _dyads(press: Linkage) -> Records[Dyad]:
    try:
        return least_transmission_angles(press)
    except PinpressError:  # not planar, or with several drivers
        return Records(Dyad, [])


def _in_order(press: Linkage) -> Iterator[tuple[int, mobility.Constraint, tuple[str, ...]]]:
    """Index of every loop and gear pair, itself, and names of its joints: see `Closing`."""
    owners = mobility.constraints(press)
    for k, joints in press.engine().closing_order():
        if k == len(owners):
            return  # what follows are held spins
        yield k, owners[k], tuple(press.joints[joint] for joint in joints)


def _count_findings(result: CheckResult) -> str:
    numbers = [
        f"{len(found) or 'no'} {word}{'' if len(found) == 1 else 's'}"
        for found, word in ((result.errors, "error"), (result.warnings, "warning"), (result.notes, "note"))
    ]
    return ", ".join(numbers)


def _count_elements(document: Document) -> str:
    """Links, joints and loops of a file that cannot be put together, and its masses as far as they are numbers."""
    counts = [(len(document.robot.all(tag)), word) for tag, word in (("link", "link"), ("joint", "joint"), ("loop_joint", "loop"))]
    masses = [mass.get("value") for link in document.robot.all("link") for part in link.all("inertial") for mass in part.all("mass")]
    total = 0.0
    for value in masses:
        with contextlib.suppress(ValueError, TypeError):
            total += max(float(value), 0.0) if math.isfinite(float(value)) else 0.0
    named = ", ".join(f"{count} {word}{'' if count == 1 else 's'}" for count, word in counts)
    scale = tables.scale("kg", [total])
    return f"as far as it can be read: {named}, {scale.shown(total)} {scale.unit}"


def _describe(facts: Facts) -> list[str]:
    lines = [*main_lines(facts.data, facts.drivers), *_mobility(facts), "", *_bearings(facts)]
    if facts.dyads:
        lines += ["", "Least transmission angles (between the two links of a dyad; best at 90 deg, at 0 they are in line and lock)"]
        coordinate = facts.data.coordinate
        rows = [["", "joined to the rest by", "angle [deg]", f"at {coordinate.part} [{coordinate.shown_unit}]", ""]]
        for dyad in facts.dyads:
            angles = [f"{np.degrees(dyad.least_transmission_angle):.2f}", f"{coordinate.scale * dyad.crank_angle + 0.0:.2f}"]
            flat = dyad.least_transmission_angle < FLAT
            rows.append([dyad.bearing, ", ".join(dyad.ends), *angles, f"below {np.degrees(FLAT):.0f} deg, as in a knuckle" if flat else ""])
        lines += tables.fitted_words(rows)
    return lines


def summarise_facts(facts: Facts) -> str:
    """How the press moves: its stroke, or why there is none, and the smallest of the transmission angles."""
    data = facts.data
    if facts.mobility != len(facts.determined):
        return f"mobility {facts.mobility}"
    if len(facts.drivers) > 1 and data.no_stroke is not None:
        return data.no_stroke
    if data.turns_between is not None:
        low, high = (data.coordinate.shown(end, ".2f") for end in data.turns_between)
        return f"locks: {facts.drivers[0]} moves only from {low} to {high}"
    stroke = "no stroke" if data.stroke is None else f"stroke {1e3 * data.stroke:.3f} mm"
    angles = [np.degrees(dyad.least_transmission_angle) for dyad in facts.dyads]
    return f"{stroke}, least transmission angle {min(angles):.2f} deg" if angles else stroke


def _mobility(facts: Facts) -> list[str]:
    left = f"free motion{'' if facts.mobility == 1 else 's'}: {len(facts.joints)} joints"
    if facts.equations:
        left += f" less {facts.rank} equations of loops and gear pairs"
        more = facts.equations - facts.rank
        left += f" ({more} more {'is' if more == 1 else 'are'} redundant)" if more else ""
    if facts.mobility != len(facts.determined):
        left += f"; but the number of drivers is {len(facts.drivers)}"
    kinds = {kind: [each.joints[0] for each in facts.freedoms if each.kind == kind] for kind in KINDS}
    return [
        tables.entry("mobility", f"{facts.mobility}", "", left),
        *(tables.entry(kind, f"{len(joints)}", "", f"{KINDS[kind]} {', '.join(joints)}") for kind, joints in kinds.items() if joints),
        *([tables.entry("assembly", "closed", "", facts.assembly)] if facts.assembly else []),
        *([tables.entry("engine", facts.engine)] if facts.engine else []),
    ]


def _bearings(facts: Facts) -> list[str]:
    """A table of bearings in the order of the drawing, each gear pair below the joint that follows in it, then machine elements."""
    rows = [["", "", "force of - on", "as drawn", "determines" if facts.engine == "plane" else "joints of the loop"]]
    before: dict[tuple[str, ...], str] = {}
    closings = {each.name: each for each in facts.closings}
    together = {each.name: before.setdefault(each.joints, each.name) for each in facts.closings}

    def closing_cells(each: Closing) -> list[str]:
        first = together[each.name]
        joints = ", ".join(each.joints) if first == each.name else f"(with {first})"
        return [open_in_words(each.gap, each.misalignment, facts.data.size) or "closed", joints or "nothing new"]

    for place in facts.bearings:
        each = closings.get(place.name)
        between = " - ".join(place.between)
        if each is not None and each.type != "gear pair":
            rows.append([place.name, f"{place.type} loop", between, *closing_cells(each)])
            continue
        rows.append([place.name, place.type, between, "", "driver" if place.name in facts.drivers else ""])
        if each is not None:
            rows.append(["", "gear pair", " - ".join(each.between), *closing_cells(each)])
    elements = (each for each in facts.closings if each.type in WORDS.values())
    rows += [[each.name, each.type, " - ".join(each.between), *closing_cells(each)] for each in elements]
    return ["Bearings in the order of the drawing", *tables.fitted_words(rows)]


def _lines_of(file: str, finding: Finding) -> list[str]:
    place = "" if finding.line is None else f"{file}:{finding.line}: "
    element = "" if finding.element is None or finding.element.startswith(WHOLE) else f"{finding.element}: "
    wrapper = textwrap.TextWrapper(WIDTH, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
    lines = wrapper.wrap(f"{place}{finding.severity}: {element}{finding.problem}")
    wrapper.initial_indent = "    "
    return lines + wrapper.wrap(finding.remedy)
