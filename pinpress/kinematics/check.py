"""Everything that is wrong with a URDF, odd in it, or worth knowing about the linkage it describes."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..common import tables
from ..common.arguments import typed
from ..common.errors import UrdfError
from ..common.results import Record, Records, Tabular
from ..common.tables import Column
from ..engines.joints import LoopJoint
from ..engines.spatial.kinematics import rank as rank_of
from ..linkage import assembly_checks, mobility
from ..linkage.assembly_checks import short
from ..linkage.linkage import Linkage
from ..linkage.loading import assembled, document_of, located
from ..linkage.urdf import element_checks, reader
from ..linkage.urdf.document import SEVERITIES, Document, Finding

WIDTH = 120  # of a line of text
WHOLE = ("<robot", "<model", "<mujoco")  # what is said of the file as a whole is said of none of its elements


@dataclass(frozen=True, repr=False)
class Closing(Record, units={"gap": "m", "misalignment": "rad"}):
    """A loop or gear pair of a linkage.

    Attributes:
        name: of the loop; of a gear pair, of the joint with the ``<mimic>``.
        type: "spherical", "revolute", "fixed" or "gear pair".
        between: names of the links, of a gear pair of the joints.
        gap: between its two sides as drawn [m].
        misalignment: of its axes or links as drawn [rad].
        joints: names of the joints whose coordinates it determines, where the linkage is planar; else, of those it closes a loop of.
    """

    name: str
    type: str
    between: tuple[str, str]
    gap: float
    misalignment: float
    joints: tuple[str, ...]


@dataclass(frozen=True, repr=False)
class Facts(Record):
    """What the elements of a URDF make, put together.

    Attributes:
        drivers: names of the driver joints.
        slide: name of the slide's link, None if there is none.
        joints: names of those that move.
        equations: number of those of loops and gear pairs.
        rank: number of those that are independent in the drawn pose.
        mobility: degrees of freedom.
        engine: that computes it, "plane" or "pinocchio"; None where it cannot be loaded.
        closings: loops, then gear pairs. Those of a planar linkage close in the order of the joints that they determine.
    """

    drivers: tuple[str, ...]
    slide: str | None
    joints: tuple[str, ...]
    equations: int
    rank: int
    engine: str | None
    closings: Records[Closing] = field(repr=False)

    @property
    def mobility(self) -> int:
        return len(self.joints) - self.rank


@dataclass(frozen=True, repr=False)
class CheckResult(Tabular):
    """What `check` found: a table with a finding a row; as text, a page to read.

    Attributes:
        file: path of the URDF.
        findings: errors first, the one that `load` raises in front, then warnings, then notes.
        facts: None where the errors leave open what the elements make.
    """

    file: str
    findings: Records[Finding]
    facts: Facts | None

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
        return f"CheckResult of {self.file}: {_counted(self)}"

    def columns(self) -> dict[str, Column]:
        """The findings as columns, None where one has no line."""
        return self.findings.columns()

    def __str__(self) -> str:
        lines = [f"{self.file}: {_counted(self)}"]
        if self.facts is not None:
            lines += ["", *_described(self.facts)]
        for severity in SEVERITIES:
            found = self._of(severity)
            lines += [""] * bool(found) + [line for finding in found for line in _said(self.file, finding)]
        return "\n".join(lines)


@typed
def check(
    path: str | os.PathLike[str], driver: str | Sequence[str] | None = None, slide: str | None = None, *, allow_open: bool = False
) -> CheckResult:
    """Find all errors of a URDF, of which `load` raises the first, and whatever else is odd in it or worth knowing.

    Args:
        path: as of `load`.
        driver: as of `load`.
        slide: as of `load`.
        allow_open: as of `load`.

    Raises:
        UrdfError: there is no such file.
        UnknownNameError: no such driver or slide.
        PinpressError: the slide is not guided by the frame, or a driver is named twice.
    """
    file = os.fspath(located(path))
    findings, facts = [], None
    try:
        document = document_of(file)
        findings += [*reader.errors(document), *document.remarks, *element_checks.remarks(document.robot)]
        if all(finding.error is None for finding in findings):
            found, facts = _put_together(document, driver, slide, allow_open)
            findings += found
    except UrdfError as error:
        if not os.path.exists(file):
            raise
        findings.append(Finding.of(error))
    return CheckResult(file, Records(Finding, sorted(findings, key=lambda finding: SEVERITIES.index(finding.severity))), facts)


def _put_together(
    document: Document, driver: str | Sequence[str] | None, slide: str | None, allow_open: bool
) -> tuple[list[Finding], Facts]:
    """Findings and facts of the linkage that the elements make; raises the errors of `assembled`."""
    description = reader.describe(document)
    press = assembled(document, driver, slide)
    errors = list(assembly_checks.errors(press))
    remarks = assembly_checks.units_remarks(press) if errors else assembly_checks.remarks(press, document.robot, allow_open)
    findings = [*errors, *remarks]
    rank = rank_of(press.equations(press.as_drawn).columns) if errors else press.rank
    between = [(loop.link1.link, loop.link2.link) for loop in description.loops]
    between += [(press.joints[pair.follower], press.joints[pair.leader]) for pair in press.couplings]
    closings = (
        Closing(
            each.by.name,
            each.by.type if isinstance(each.by, LoopJoint) else "gear pair",
            between[k],
            *mobility.opening(press, each, press.drawn_gaps),
            joints,
        )
        for k, each, joints in _in_order(press)
    )
    engine = None if errors else press.engine().name
    return findings, Facts(press.drivers, press.slide, press.joints, len(press.drawn_gaps), rank, engine, Records(Closing, closings))


def _in_order(press: Linkage) -> Iterator[tuple[int, mobility.Constraint, tuple[str, ...]]]:
    """Index of every loop and gear pair, itself, and names of its joints: see `Closing`."""
    owners = mobility.constraints(press)
    for k, joints in press.engine().closing_order():
        yield k, owners[k], tuple(press.joints[joint] for joint in joints)


def _counted(result: CheckResult) -> str:
    numbers = [
        f"{len(found) or 'no'} {word}{'' if len(found) == 1 else 's'}"
        for found, word in ((result.errors, "error"), (result.warnings, "warning"), (result.notes, "note"))
    ]
    return ", ".join(numbers)


def _described(facts: Facts) -> list[str]:
    independent = f"{facts.rank} of {facts.equations}" if facts.rank < facts.equations else f"{facts.rank}"
    named = [
        ("driver", ", ".join(facts.drivers)),
        ("slide", facts.slide or "none"),
        ("mobility", f"{facts.mobility}: {len(facts.joints)} joints, {independent} equations are independent"),
        *([("engine", facts.engine)] if facts.engine else []),
    ]
    lines = tables.table(named, [12, 0])
    if not facts.closings:
        return lines
    rows = [("", "", "", "gap as drawn", "determines" if facts.engine == "plane" else "joints")]
    before: dict[tuple[str, ...], str] = {}
    for each in facts.closings:
        gaps = [f"{short(1e3 * each.gap)} mm"] * (each.type != "gear pair" or each.gap > 0)
        gaps += [f"{short(np.degrees(each.misalignment))} deg"] * (each.type != "spherical")
        together = before.setdefault(each.joints, each.name)
        joints = ", ".join(each.joints) if together == each.name else f"(with {together})"
        rows.append((each.name, each.type, " - ".join(each.between), ", ".join(gaps), joints or "nothing new"))
    return [*lines, "", *tables.fitted_words(rows)]


def _said(file: str, finding: Finding) -> list[str]:
    place = "" if finding.line is None else f"{file}:{finding.line}: "
    element = "" if finding.element is None or finding.element.startswith(WHOLE) else f"{finding.element}: "
    wrapper = textwrap.TextWrapper(WIDTH, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
    lines = wrapper.wrap(f"{place}{finding.severity}: {element}{finding.problem}")
    wrapper.initial_indent = "    "
    return lines + wrapper.wrap(finding.remedy)
