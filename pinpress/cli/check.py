"""`pinpress check`: report how a press moves, with the errors, doubts and notes about its file."""

import argparse
from collections.abc import Sequence

from ..common.errors import PinTableError
from ..common.results import Records
from ..kinematics.check import CheckResult, check
from ..linkage.document import Finding
from .words.press import add_reading_options, add_refused_option, drawn, names_table


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `check` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "check",
        help="stroke, dead centres and bearings of a press, and all errors and doubts about its file",
        description="Report how a press moves: stroke, dead centres, sense of rotation, masses, bearings, transmission angles. List the\n"
        "errors of its file, with line and remedy: names, numbers, inertias, connections of links, loops that do not close as drawn or\n"
        "that the driver does not determine. Then list doubts and notes. For a file with errors the report is as complete as possible.",
        epilog="exit code: 0 without errors (there may be warnings), 1 with errors, 2 for wrong usage",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_reading_options(parser)
    add_refused_option(parser, "--zero", "check reports the dead centres in the angles of the file; pinpress analyse can count from them")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the report.

    Returns:
        The exit code: 1 if there are errors, else 0.

    Raises:
        PinpressError: There is no such file, driver or slide.
    """
    if names_table(options):
        result = _of_table(options.file, options.parameters, options.slide)
    else:
        result = check(options.file, driver=options.driver, slide=options.slide, allow_open=options.allow_open)
    print(result)
    return 1 if result.errors else 0


def _of_table(file: str, parameters: Sequence[str], slide: str | None) -> CheckResult:
    try:
        return drawn(file, parameters).check(slide)
    except PinTableError as error:
        if error.line is None:
            raise  # there is no such file, it is no table at all, or a value is none
        finding = Finding("error", error.element or None, error.line, error.problem, error.remedy, error)
        return CheckResult(error.file, Records(Finding, [finding]), None)
