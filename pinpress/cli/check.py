"""`pinpress check`: how a press moves, and everything that is wrong with its file, odd in it, or worth knowing."""

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
        help="stroke, dead centres and bearings of a press, and all that is wrong with its file or odd in it",
        description="Say how a press moves: stroke, dead centres, sense of rotation, masses, bearings, transmission angles. List what is\n"
        "wrong with its file, with line and remedy: names, numbers, inertias, how links are connected, whether the loops close as drawn\n"
        "and the driver determines them; then what is odd in it, and what is worth knowing. Of a file with errors it says what it can.",
        epilog="exit code: 0 without errors (there may be warnings), 1 with errors, 2 for wrong usage",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_reading_options(parser)
    add_refused_option(
        parser, "--zero", "check says where the dead centres are in the angles of the file; pinpress analyse counts from them"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print what is found.

    Returns:
        The exit code: 1 where there are errors, else 0.

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
