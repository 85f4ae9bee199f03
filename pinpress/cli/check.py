"""`pinpress check`: everything that is wrong with a URDF, odd in it, or worth knowing."""

import argparse

from ..kinematics.check import check
from .options import add_open_option


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `check` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "check",
        help="everything that is wrong with a URDF, odd in it, or worth knowing",
        description="List what is wrong with a URDF, with line and remedy: names, numbers, inertias, how links are connected, whether\n"
        "the loops close as drawn and the driver determines them; then what is odd in it, and what is worth knowing.",
        epilog="exit code: 0 without errors (there may be warnings), 1 with errors, 2 for wrong usage",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    option("file", metavar="FILE", help="URDF file, or the name of a shipped press")
    option("--driver", metavar="JOINT", action="append", help="driven joint; may be given several times")
    option("--slide", metavar="LINK", help="slide, where it is not the link called slide")
    add_open_option(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print what is found.

    Returns:
        The exit code: 1 where there are errors, else 0.

    Raises:
        PinpressError: There is no such file, driver or slide.
    """
    result = check(options.file, driver=options.driver, slide=options.slide, allow_open=options.allow_open)
    print(result)
    return 1 if result.errors else 0
