"""`pinpress measured`: what records of a real press show: masses and friction, process force, vibrations."""

import argparse

from . import force, identify, vibration


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `measured` among the subcommands, with its own."""
    parser = commands.add_parser("measured", help="what records of a real press show: identify, force, vibration")
    own = parser.add_subparsers(required=True, metavar="WHAT")
    for command in (identify, force, vibration):
        command.add(own)
    for subparser in own.choices.values():
        subparser.allow_abbrev = False  # an abbreviation could stand for another option
