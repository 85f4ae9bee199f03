"""Which press a command takes: the options by which its file is read, and where its crank angles are 0."""

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
    """Options of `load_press`: those by which a file is read, and where crank angles are 0."""
    add_reading_options(parser)
    parser.add_argument(
        "--zero",
        type=str.lower,
        choices=ZEROS,
        default="drawn",
        help="where crank angles are 0, those given, printed and written: as drawn, or at top or bottom dead centre; they rise where the"
        " driver turns positively (default: %(default)s)",
    )


def add_reading_options(parser: argparse.ArgumentParser) -> None:
    """Options by which a press is read: file, drivers, slide, whether loops may be drawn far open, other values of a table's parameters."""
    option = parser.add_argument
    option("file", metavar="FILE", help=FILE)
    driver = "driven joint, where the URDF has no <transmission> or another is meant; may be given several times"
    option("--driver", metavar="JOINT", action="append", help=driver)
    add_slide_option(parser)
    option("--allow-open", action="store_true", help="close loops that are drawn open by more than a tenth of the linkage")
    parameter = "another value of a parameter of the pin table, such as r=150; may be given several times"
    option("--set", dest="parameters", metavar="NAME=VALUE", action="append", default=[], help=parameter)


def add_slide_option(parser: argparse.ArgumentParser) -> None:
    """Option --slide, the link whose motion and process force are meant."""
    parser.add_argument("--slide", metavar="LINK", help="slide, where it is not the link called slide")


def add_refused_option(parser: argparse.ArgumentParser, name: str, why: str) -> None:
    """An option that other commands have, and this one refuses with a reason."""

    class Refused(argparse.Action):
        def __call__(self, *_: Any) -> None:
            raise PinpressError(f"{name}: {why}")

    parser.add_argument(name, action=Refused, nargs="?", help=argparse.SUPPRESS)


def load_press(options: argparse.Namespace, **more: Any) -> Linkage:
    """The press that the options name, with crank angles counted as they say; ``more`` goes to `load`."""
    return with_zero(load_as_drawn(options, **more), options.zero)


def load_as_drawn(options: argparse.Namespace, **more: Any) -> Linkage:
    """The press that the options name, built from a pin table or loaded from a file in another format; ``more`` goes to `load`."""
    if names_table(options):
        return drawn(options.file, options.parameters).press(slide=options.slide, **more)
    return load(options.file, driver=options.driver, slide=options.slide, allow_open=options.allow_open, **more)


def load_other(options: argparse.Namespace, file: str, slide: str | None = None) -> Linkage:
    """Another press than that of `load_press`, as its own file has it, with crank angles counted as the options say.

    ``slide`` names its slide where its file leaves that open.
    """
    press = drawn(file).press() if _is_table(file) else load(file)
    if press.slide is None and slide is not None:
        press = drawn(file).press(slide=slide) if _is_table(file) else load(file, slide=slide)
    return with_zero(press, options.zero)


def names_table(options: argparse.Namespace) -> bool:
    """Whether the file is a pin table, or a shipped press with other values of its table's parameters; raises PinpressError where an option
    is given that does not go with what it is."""
    if not _is_table(options.file):
        if not options.parameters:
            return False
        refuse_without_table(options.file, f"--set {options.parameters[0]}")
    if options.driver is not None or options.allow_open:
        raise PinpressError(f"{options.file} is a pin table, which says what drives: leave out --driver and --allow-open")
    return True


def refuse_without_table(file: str, words: str) -> None:
    """Raise PinpressError where parameters are given in words, and the file is neither a pin table nor a shipped press."""
    if not _is_table(file) and file not in presses():
        raise PinpressError(f"{words}: only a pin table has parameters, and {file} is none: leave it out")


def _is_table(file: str) -> bool:
    """Whether a file is a pin table, or would be one: for the name of a template reading says how to make it."""
    return file.lower().endswith((".yaml", ".yml")) or (file in TEMPLATES and not os.path.exists(file))


def table_parameters(specs: Sequence[str]) -> dict[str, str]:
    """Values by the names of a pin table's parameters, from words such as ``r=150``.

    Raises:
        PinpressError: Words that are no value of a parameter, or a parameter given twice.
    """
    found: dict[str, str] = {}
    for words in specs:
        name, equals, value = words.partition("=")
        if not (name and equals and value):
            raise PinpressError(f"{words!r} is no value of a parameter: write NAME=VALUE, such as r=150")
        if name in found:
            raise PinpressError(f"{words!r}: {name} is given twice")
        found[name] = value
    return found


def drawn(table: str, specs: Sequence[str] = (), option: str = "--set ") -> DrawnPress:
    """The press that a pin table draws.

    Args:
        table: The file.
        specs: Other values of its parameters, such as ``r=150``.
        option: What stands before them on the command line, for messages.

    Raises:
        PinTableError: The table makes no press with these values.
        PinpressError: As `table_parameters`.
    """
    from ...pin_table.building import draft  # with a parser that a URDF does without

    parameters = table_parameters(specs)
    with naming_values(parameters, option):
        return draft(table, **parameters)


@contextmanager
def naming_values(parameters: Mapping[str, str], option: str = "--set ") -> Iterator[None]:
    """Raise errors of a pin table's values under the words by which the command line gives them.

    Args:
        parameters: Values by the names of parameters.
        option: What stands before them on the command line.

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
    """The press with crank angles counted from where `ZEROS` says."""
    if zero == "drawn":
        return press
    press.refuse_several_drivers(f"their angles are 0 where the press is drawn; leave out --zero {zero}")
    press.refuse_sliding_driver(f"its positions are 0 where the press is drawn; leave out --zero {zero}")
    ends = dead_centres(press)
    return press.drawn_at(ends.top_angle if zero == "tdc" else ends.bottom_angle, ZEROS[zero])
