"""The command line: `pinpress`, or `python -m pinpress`."""

import argparse
import re
import sys
from collections.abc import Collection, Sequence
from typing import Any

from ..common.command_end import ended
from ..linkage.loading import presses
from . import accuracy, analyse, balance, build, check, convert, export, record, report, servo, simulate, tolerances, view
from .measured import measured

# as the help lists them
COMMANDS = (build, check, convert, export, report, analyse, simulate, balance, servo, tolerances, record, view, measured, accuracy)


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
    words = sys.argv[1:] if arguments is None else arguments
    parser, commands = _parser()
    if words and not words[0].startswith("-") and words[0] not in commands and _names_press(words[0]):
        words = ["report", *words]
    options = parser.parse_args(_joined(words))
    if hasattr(sys.stdout, "reconfigure"):
        sys.stdout.reconfigure(errors="backslashreplace")  # names may have characters that the terminal's encoding lacks
    return int(options.run(options))


def _names_press(word: str) -> bool:
    """Whether a word is no command but a job or press: it has the ending of one, or is the name of a shipped press."""
    return word.lower().endswith((".yaml", ".yml", ".urdf", ".sdf", ".xml", ".mjcf")) or word in presses()


def _joined(words: Sequence[str]) -> list[str]:
    """Each option with the negative number behind it as one word, as `argparse` takes -70r/min for an option."""
    joined: list[str] = []
    for word in words:
        if joined and re.fullmatch(r"--[^=]+", joined[-1]) and re.match(r"-\.?\d", word):
            word = f"{joined.pop()}={word}"
        joined.append(word)
    return joined


class _Versions(argparse.Action):
    """Prints versions and licences of all that pinpress uses."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from .versions import lines  # seldom needed

        print("\n".join(lines()))
        parser.exit()


def _parser() -> tuple[argparse.ArgumentParser, Collection[str]]:
    parser = argparse.ArgumentParser(
        prog="pinpress",
        description="Mechanical press linkages: motion, driving torque, bearing forces. `pinpress press.yaml` does all that a job allows.",
    )
    parser.add_argument("--version", action=_Versions, nargs=0, help="versions and licences of pinpress and of all it uses")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.add(commands)
    for subparser in commands.choices.values():
        subparser.allow_abbrev = False  # an abbreviation could stand for another option
    return parser, commands.choices


if __name__ == "__main__":
    sys.exit(main())
