"""`pinpress new`: a pin table to start from."""

import argparse
from pathlib import Path

from ..common import files
from ..common.errors import PinpressError
from ..pin_table.templates import TEMPLATES, template


def add(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Put `new` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "new",
        help="a pin table to start from",
        description="Write a pin table with comments, whose lengths are parameters, to be changed into your press.",
    )
    option = parser.add_argument
    option("file", metavar="TABLE", type=Path, help="what to write, such as press.yaml; it must not be there yet")
    option("--template", choices=TEMPLATES, default=TEMPLATES[0], help=f"kind of press (default: {TEMPLATES[0]})")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the table.

    Returns:
        The exit code, 0.

    Raises:
        PinpressError: the file is there already, or cannot be written.
    """
    if options.file.suffix not in (".yaml", ".yml"):
        raise PinpressError(f"{options.file} does not end in .yaml: name it so, as pin tables are YAML")
    if options.file.exists():
        raise PinpressError(f"{options.file} is there already: give another name")
    files.write(options.file, template(options.template))
    print(f"wrote {options.file}; change it, then: pinpress build {options.file}")
    return 0
