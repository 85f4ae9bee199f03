"""`pinpress check`: how a press moves, with the errors, doubts and notes about its file, and all errors of a job at once."""

import argparse
import re
import warnings

from ..common.errors import PinpressError, PinpressWarning, PinTableError
from ..common.results import Records
from ..jobs.job import read_job
from ..jobs.reading import base_of
from ..jobs.sources import Source
from ..kinematics.check import CheckResult, check
from ..linkage.document import Finding
from .options import add_job_options, source_of


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `check` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "check",
        help="motion and bearings of a press or robot, and all errors and doubts about its file or job",
        description="Report how a press moves: stroke, dead centres, sense of rotation, masses, bearings, transmission angles; of a robot\n"
        "what its motors leave free, and drivers that it could have where the file names none. List the\n"
        "errors of its file, with line and remedy: names, numbers, inertias, connections of links, loops that do not close as drawn or\n"
        "that the driver does not determine. Then list doubts and notes, and all errors in the sections of a job. For a file with errors\n"
        "the report is as complete as possible. Nothing is computed beyond the motion.",
        epilog="exit code: 0 without errors (there may be warnings), 1 with errors, 2 for wrong usage",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_job_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the report.

    Returns:
        The exit code: 1 if there are errors, else 0.

    Raises:
        PinpressError: there is no such file, driver or slide.
    """
    found = source_of(options)
    result = _of_press(found)
    print(result)
    if result.errors or result.facts is None:
        return 1
    if result.facts.proposal is not None and set(found.items) == {"file"}:
        return 0  # nothing but a file that names no driver, which is no error of the file
    errors: list[PinpressError] = []
    with warnings.catch_warnings():
        for each in result.warnings:  # loading the press says again what the report lists
            warnings.filterwarnings("ignore", f".*{re.escape(f'{each.problem}; {each.remedy}')}", PinpressWarning)
        read_job(found, errors.append)
    print("".join(f"\nerror: {error}" for error in errors), end="\n" if errors else "")
    return 1 if errors else 0


def _of_press(found: Source) -> CheckResult:
    given = found.press_sections()
    slide = given.get("slide")
    try:
        drawn = found.drawn()
        if drawn is None:
            return check(found.model, driver=given.get("drivers"), slide=slide, base=base_of(given), pose=given.get("pose"))
        return drawn.check(slide)
    except PinTableError as error:
        if error.line is None:
            raise  # there is no such file, it is no table at all, or a value is none
        finding = Finding("error", error.element or None, error.line, error.problem, error.remedy, error)
        return CheckResult(error.file, Records(Finding, [finding]), None)
