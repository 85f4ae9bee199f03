"""Findings about a linkage: errors, of which `load` raises the first and `check` lists all, warnings and notes."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from ...common.errors import PinpressError, UrdfError
from ...common.results import Record

SEVERITIES = ("error", "warning", "note")


@dataclass(frozen=True, repr=False)
class Finding(Record):
    """One thing found.

    Attributes:
        severity: "error" (the linkage is not loaded), "warning" (it is loaded, but hardly what was meant) or "note" (worth knowing).
        element: the XML element, e.g. ``<joint name="A">``; None where the finding is about the file as a whole.
        line: line of this element in the file; None where there is none.
        problem: what was found.
        remedy: what to write or to do; empty where nothing need be done.
        error: the exception that `load` raises if this is the first error; None for warnings and notes.
    """

    severity: str
    element: str | None
    line: int | None
    problem: str
    remedy: str
    error: PinpressError | None = field(default=None, compare=False, repr=False)

    def message(self, file: str) -> str:
        """All of it, as the message of a UrdfError puts it."""
        place = file if self.line is None else f"{file}:{self.line}"
        return f"{place}: {self.element}: {self.problem}; {self.remedy}"

    @staticmethod
    def of(error: UrdfError) -> "Finding":
        return Finding("error", error.element, error.line, error.problem, error.remedy, error)


def refuse(findings: Iterable[Finding], command: str) -> None:
    """Raise the first error, if there is one; its message says how many more there are, and that ``command`` lists them."""
    errors = [finding.error for finding in findings if finding.error is not None]
    if len(errors) > 1:
        errors[0].args = (f"{errors[0]} ({len(errors) - 1} more: {command} lists them)",)
    if errors:
        raise errors[0]


def command(file: str, drivers: Iterable[str] = (), slide: str | None = None) -> str:
    """The command that lists what is found in a file."""
    import shlex  # only on the way to an error

    options = [word for driver in drivers for word in ("--driver", driver)] + ([] if slide is None else ["--slide", slide])
    return shlex.join(["pinpress", "check", file, *options])
