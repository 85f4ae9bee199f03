"""Options of the press of a command: how its file is read, and where its crank angles are 0."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from ...common.errors import PinpressError, PinTableError
from ...kinematics.slide_path import dead_centres
from ...linkage.linkage import Linkage
from ...linkage.loading import load, presses
from ...pin_table.templates import TEMPLATES

if TYPE_CHECKING:
    from ...pin_table.building import DrawnPress

FILE = f"pin table (.yaml), URDF, SDF or MJCF file, or the name of a shipped press: {', '.join(presses())}"
ZEROS = {"drawn": "the drawn pose", "tdc": "top dead centre", "bdc": "bottom dead centre"}


def add_press_options(parser: argparse.ArgumentParser) -> None:
    """Options of `load_press`: how a file is read, and where crank angles are 0."""
    add_reading_options(parser)
    parser.add_argument(
        "--zero",
        type=str.lower,
        choices=ZEROS,
        default="drawn",
        help="where crank angles are 0 (in options, print and files): as drawn, or at top or bottom dead centre; they rise if the"
        " driver turns positively (default: %(default)s)",
    )


def add_reading_options(parser: argparse.ArgumentParser) -> None:
    """Options to read a press: file, drivers, slide, whether loops may be drawn far open, values of a table's parameters."""
    option = parser.add_argument
    option("file", metavar="FILE", help=FILE)
    driver = "driven joint, if the URDF has no <transmission> or another joint is driven; may be given several times"
    option("--driver", metavar="JOINT", action="append", help=driver)
    add_slide_option(parser)
    option("--allow-open", action="store_true", help="close loops that are drawn open by more than a tenth of the linkage")
    parameter = "another value of a parameter of the pin table, such as r=150; may be given several times"
    option("--set", dest="parameters", metavar="NAME=VALUE", action="append", default=[], help=parameter)


def add_slide_option(parser: argparse.ArgumentParser) -> None:
    """Option --slide, the link whose motion and process force are computed."""
    parser.add_argument("--slide", metavar="LINK", help="name of the slide, if it is not slide")


def add_refused_option(parser: argparse.ArgumentParser, name: str, why: str) -> None:
    """An option of other commands that this command refuses, with a reason."""

    class Refused(argparse.Action):
        def __call__(self, *_: Any) -> None:
            raise PinpressError(f"{name}: {why}")

    parser.add_argument(name, action=Refused, nargs="?", help=argparse.SUPPRESS)


def load_press(options: argparse.Namespace, **more: Any) -> Linkage:
    """Load the press of the options, with crank angles counted by --zero; ``more`` goes to `load`."""
    return with_zero(load_as_drawn(options, **more), options.zero)


def load_as_drawn(options: argparse.Namespace, **more: Any) -> Linkage:
    """Load the press of the options from a pin table or from a file in another format; ``more`` goes to `load`."""
    if names_table(options):
        return drawn(options.file, options.parameters).press(slide=options.slide, **more)
    return load(options.file, driver=options.driver, slide=options.slide, allow_open=options.allow_open, **more)


def load_other(options: argparse.Namespace, file: str, slide: str | None = None) -> Linkage:
    """Load another press than `load_press` from a separate file, with crank angles counted by --zero.

    ``slide`` names its slide if its file does not.
    """
    press = drawn(file).press() if _is_table(file) else load(file)
    if press.slide is None and slide is not None:
        press = drawn(file).press(slide=slide) if _is_table(file) else load(file, slide=slide)
    return with_zero(press, options.zero)


def names_table(options: argparse.Namespace) -> bool:
    """Whether the file is a pin table, or a shipped press with other parameters. Refuses options that do not go with the file."""
    if not _is_table(options.file):
        if not options.parameters:
            return False
        refuse_without_table(options.file, f"--set {options.parameters[0]}")
    if options.driver is not None or options.allow_open:
        raise PinpressError(f"{options.file} is a pin table, which names its driver: leave out --driver and --allow-open")
    return True


def refuse_without_table(file: str, words: str) -> None:
    """Refuse parameters for a file that is neither a pin table nor a shipped press."""
    if not _is_table(file) and file not in presses():
        raise PinpressError(f"{words}: only a pin table has parameters, and {file} is not a pin table: leave it out")


def _is_table(file: str) -> bool:
    """Whether a file is a pin table, or the name of a template: then reading explains how to make a table."""
    return file.lower().endswith((".yaml", ".yml")) or (file in TEMPLATES and not os.path.exists(file))


def table_parameters(specs: Sequence[str]) -> dict[str, str]:
    """Read values of a pin table's parameters from texts such as ``r=150``.

    Raises:
        PinpressError: A text is not NAME=VALUE, or a parameter is given twice.
    """
    found: dict[str, str] = {}
    for words in specs:
        name, equals, value = words.partition("=")
        if not (name and equals and value):
            raise PinpressError(f"{words!r} is not a value of a parameter: write NAME=VALUE, such as r=150")
        if name in found:
            raise PinpressError(f"{words!r}: {name} is given twice")
        found[name] = value
    return found


def drawn(table: str, specs: Sequence[str] = (), option: str = "--set ") -> DrawnPress:
    """Draw the press of a pin table.

    Args:
        table: The file.
        specs: Other values of its parameters, such as ``r=150``.
        option: Text before the values on the command line, for messages.

    Raises:
        PinTableError: The table makes no press with these values.
        PinpressError: As for `table_parameters`.
    """
    from ...pin_table.building import draft  # with a parser that a URDF does without

    parameters = table_parameters(specs)
    with naming_values(parameters, option):
        return draft(table, **parameters)


@contextmanager
def naming_values(parameters: Mapping[str, str], option: str = "--set ") -> Iterator[None]:
    """Raise errors of a pin table's values with the text of the command line.

    Args:
        parameters: Values by the names of parameters.
        option: Text before the values on the command line.

    Raises:
        PinTableError: One of the values is wrong.
    """
    from ...pin_table.reading import CALL  # with a parser that a URDF does without

    try:
        yield
    except PinTableError as error:
        name = error.element.rpartition(": ")[2]
        if error.file != CALL or name not in parameters:
            raise
        raise PinTableError(f"{option}{name}={parameters[name]}", None, "", error.problem, error.remedy) from error


def with_zero(press: Linkage, zero: str) -> Linkage:
    """The press with crank angles counted from the pose of ``zero``."""
    if zero == "drawn":
        return press
    press.refuse_several_drivers(f"their angles are 0 in the drawn pose; leave out --zero {zero}")
    press.refuse_sliding_driver(f"its positions are 0 in the drawn pose; leave out --zero {zero}")
    ends = dead_centres(press)
    return press.drawn_at(ends.top_angle if zero == "tdc" else ends.bottom_angle, ZEROS[zero])
