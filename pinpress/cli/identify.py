"""`pinpress identify`: masses, friction, balance cylinder and motor constant of a press from records of it running idle."""

from __future__ import annotations

import argparse
import importlib.util
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..common.errors import PinpressError, shown
from ..common.files import make_folder
from ..dynamics.inputs import of_press, stated
from .words.options import add_out_option, add_press_options, load_press, print_inputs, say_written
from .words.units import quantity, read_quantity

if TYPE_CHECKING:
    from ..measured.identification import IdentifiedPress
    from ..measured.records import MeasuredRun
    from ..measured.what_is_known import IdentifiableParameters

EPILOG = """\
records are .csv, .parquet, .mat or .mf4 files of the press running idle; name their columns with units, --angle "crank [deg]".
Measure at three speeds or more, or with speeds that swing by a third in 2.6 strokes; a constant speed does not tell masses from friction.
e.g. pinpress identify zxn2_3000b docs/records/21.csv docs/records/42.csv docs/records/63.csv --angle "crank [deg]" --torque "motor [N m]"
     --ratio 20.7 --friction crank,gibs --cylinder --out out
"""


def add(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Put `identify` among the subcommands; parsed options have ``run``, see `run`."""
    parser = commands.add_parser(
        "identify",
        help="masses, friction, balance cylinder of a press from records of crank angle and motor torque",
        description="Print what records of a running press can teach, and what they do: masses, inertias, friction, balance cylinder and\n"
        "motor constant with 95 % intervals. With --out also writes identified.urdf, parameters.csv, and where Matplotlib is\n"
        "installed identifiability.png.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    option = parser.add_argument
    add_press_options(parser)
    option("records", nargs="+", metavar="RECORD", help="files of measured columns")
    option("--angle", required=True, metavar="COLUMN", help="angle of the crank or the motor, rad, deg, turns or counts")
    option("--torque", required=True, metavar="COLUMN", help="torque of the motor, N m or kN m, or its current, A")
    option("--time", metavar="COLUMN", help="default: the one called time or t")
    option("--ratio", type=float, default=1.0, metavar="R", help="turns of the motor by turns of the crank, for the torque (default: 1)")
    option("--angle-ratio", type=float, default=1.0, metavar="R", help="turns of the encoder by turns of the crank (default: 1)")
    option(
        "--offset", type=float, default=0.0, metavar="A", help="angle of the column where the crank angle is 0, in its unit (default: 0)"
    )
    option("--counts", type=float, metavar="N", help="counts of the encoder in a turn, for an angle in counts")
    option("--added", action="append", default=[], metavar="RECORD:LINK=KG", help="mass fastened to a link for one record; with currents")
    option("--prior", type=float, default=0.2, metavar="P", help="share by which masses may differ from the description (default: 0.2)")
    option(
        "--known",
        action="append",
        default=[],
        metavar="NAME=VALUE,SD",
        help='weighed or gauged, in SI units: "slide mass=2200,5" [repeatable]',
    )
    option(
        "--friction", default="crank,slide_guide", metavar="KINDS", help="of crank, pins, slide_guide, gibs, or none (default: %(default)s)"
    )
    option("--cylinder", action="store_true", help="a balance cylinder carries the slide")
    option("--drive-inertia", type=quantity("kg m2"), default=0.0, metavar="J", help="of motor and gears at the crank")
    add_out_option(parser, "the files")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print what can be learnt and what was, and write the files.

    Raises:
        PinpressError: an option or a record is at fault, or computing or writing fails.
    """
    from ..measured.identification import identify  # both to save start-up time, that of all other commands
    from ..measured.what_is_known import identifiability

    press = load_press(options)
    friction = [] if options.friction == "none" else options.friction.split(",")
    runs = _runs(options)
    known = _known(options.known)
    revealed = identifiability(press, runs, prior=options.prior, known=known, friction=friction, cylinder=options.cylinder)
    found = identify(
        press, runs, prior=options.prior, known=known, friction=friction, cylinder=options.cylinder, drive_inertia=options.drive_inertia
    )
    if options.out is not None:
        make_folder(options.out)
    notes = [f"  {each.name}: {note}" for each in runs for note in each.notes]
    print("\n".join([*(each.title for each in runs), *notes, "", str(revealed), "", str(found)]))
    given = [("records", ", ".join(options.records)), ("prior", f"{options.prior:g}"), ("friction", options.friction)]
    given += [("known", "; ".join(options.known))] if known else []
    print_inputs([*of_press(press), *given, *([("cylinder", "yes")] if options.cylinder else []), stated()])
    if options.out is not None:
        _write(found, revealed, options.out)
    return 0


def _runs(options: argparse.Namespace) -> list[MeasuredRun]:
    """The records that the options name."""
    from ..measured.records import record  # to save start-up time

    added = _added(options.added, options.records)
    asked = {name: getattr(options, name) for name in ("torque", "time", "ratio", "angle_ratio", "counts")}
    return [record(file, options.angle, **asked, zero=options.offset, added_mass=added.get(file, {})) for file in options.records]


def _added(words: Sequence[str], records: Sequence[str]) -> dict[str, dict[str, float]]:
    """Masses by record and link."""
    found: dict[str, dict[str, float]] = {}
    for text in words:
        file, _, rest = text.rpartition(":")
        link, _, mass = rest.partition("=")
        matching = [each for each in records if file and (each == file or Path(each).name == file)]
        if len(matching) != 1 or not link or not mass:
            raise PinpressError(
                f"--added {shown(text)} names no record: write RECORD:LINK=KG, as in --added {Path(records[0]).name}:slide=200"
            )
        try:
            found.setdefault(matching[0], {})[link] = read_quantity(mass, "kg")
        except ValueError as error:
            raise PinpressError(f"--added {text}: the mass is {error}") from None
    return found


def _known(words: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Values and standard deviations by the names of parameters."""
    found: dict[str, tuple[float, float]] = {}
    for text in words:
        name, _, numbers = text.partition("=")
        try:
            value, deviation = (float(each) for each in numbers.split(","))
        except ValueError:
            raise PinpressError(
                f"--known {shown(text)} is no value with its standard deviation: write NAME=VALUE,SD, as in --known 'slide mass=2200,5'"
            ) from None
        found[name.strip()] = value, deviation
    return found


def _write(found: IdentifiedPress, revealed: IdentifiableParameters, folder: Path) -> None:
    """Write the files and say so."""
    from ..linkage.writing import write_urdf  # to save start-up time

    names = ["identified.urdf", "parameters.csv"]
    write_urdf(found.press, folder / names[0])
    found.to_csv(folder / names[1])
    if importlib.util.find_spec("matplotlib") is None:
        print(f"\nwrote {', '.join(str(folder / name) for name in names)}; for the picture: pip install 'pinpress[plots]'")
        return
    from ..plots import identification, style  # slow to import

    style.save(identification.identifiability(revealed), folder / "identifiability.png")
    say_written(folder, [*names, "identifiability.png"])
