"""The command line: `pinpress`, or `python -m pinpress`."""

import argparse
import sys

from .. import __version__
from ..common.command_end import ended
from . import about, accuracy, analyse, balance, build, check, ratings, record, report, servo, simulate, sweep, tolerances, view
from .measured import force, identify, vibration

# as the help lists them
MEASURED = (identify, force, vibration)
COMMANDS = (build, view, report, analyse, simulate, balance, servo, ratings, tolerances, sweep, *MEASURED, record, accuracy, check, about)


def main(arguments: list[str] | None = None) -> int:
    """Run the command.

    Args:
        arguments: words after ``pinpress``; by default the arguments of this process.

    Returns:
        The exit code: 2 with one line on stderr if the input is wrong, 1 if `check` finds errors; other codes see
        `command_end.ended`.
    """
    return ended("pinpress", lambda: _run(arguments))


def _run(arguments: list[str] | None) -> int:
    options = _parser().parse_args(arguments)
    if hasattr(sys.stdout, "reconfigure"):
        sys.stdout.reconfigure(errors="backslashreplace")  # names may have characters that the terminal's encoding lacks
    return int(options.run(options))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="pinpress", description="Mechanical press linkages: motion, driving torque, bearing forces.")
    parser.add_argument(
        "--version", action="version", version=f"pinpress {__version__}; versions and licences of all it uses: pinpress about"
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.add(commands)
    for subparser in commands.choices.values():
        subparser.allow_abbrev = False  # an abbreviation could stand for another option
    return parser


if __name__ == "__main__":
    sys.exit(main())
