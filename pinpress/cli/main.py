"""The command line: `pinpress`, or `python -m pinpress`."""

import argparse
import io
import sys

from .. import check
from ..common.command_end import ended
from . import accuracy as command_accuracy
from . import analyse as command_analyse
from . import balance as command_balance
from . import ratings as command_ratings
from . import record as command_record
from . import simulate as command_simulate


def main(arguments: list[str] | None = None) -> int:
    """Run the command; exit code 2 with one line on stderr where the input is at fault, 1 where `check` finds errors, others see
    `command_end.ended`."""
    return ended("pinpress", lambda: _run(arguments))


def _run(arguments: list[str] | None) -> int:
    options = _parser().parse_args(arguments)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names may have characters that the terminal's encoding lacks
    return int(options.run(options))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="pinpress", description="Mechanical press linkages: motion, driving torque, bearing forces.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in (command_analyse, command_simulate, command_balance, command_ratings, command_record, command_accuracy):
        command.add(commands)
    checked = commands.add_parser(
        "check",
        help="everything that is wrong with a URDF, odd in it, or worth knowing",
        description="List what is wrong with a URDF, with line and remedy: names, numbers, inertias, how links are connected, whether\n"
        "the loops close as drawn and the driver determines them; then what is odd in it, and what is worth knowing.",
        epilog="exit code: 0 without errors (there may be warnings), 1 with errors, 2 for wrong usage",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    checked.add_argument("file", metavar="FILE", help="URDF file, or the name of a shipped press")
    checked.add_argument("--driver", metavar="JOINT", action="append", help="driven joint; may be given several times")
    checked.add_argument("--slide", metavar="LINK", help="slide, where it is not the link called slide")
    checked.set_defaults(run=_check)
    return parser


def _check(options: argparse.Namespace) -> int:
    report = check(options.file, driver=options.driver, slide=options.slide)
    print(report)
    return 1 if report.errors else 0


if __name__ == "__main__":
    sys.exit(main())
